"""Values that only simulations use, in SI units; attributes without a key in the language have MuJoCo's names."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from .geometry import IDENTITY, Pose

# The value of an attribute: a number in SI units, text, boolean, or a tuple of them. None: not set.
Attribute = float | str | bool | tuple[float | str | bool, ...] | None
Values = Mapping[str, Attribute]

POSITION, VELOCITY, MOTOR, GENERAL = "position", "velocity", "motor", "general"
SENSOR_ELEMENT, BODY_ELEMENT, TEMPLATE_ELEMENT = "sensor", "body", "template"
AT_JOINT = "joint"
CLASSIC = "classic"


@dataclass(frozen=True)
class Actuator:
    """An actuator of a joint, a tendon, a site or a body."""

    type: str = POSITION
    name: str = ""  # empty for the actuator of a joint, which has the name of the joint
    targets: Mapping[str, str] = field(default_factory=dict, hash=False)  # by MuJoCo attribute
    kp: float | None = None  # N*m/rad or N/m
    kv: float = 0.0  # N*m*s/rad or N*s/m
    damping_ratio: float = 0.0
    damping: float = 0.0  # at the joint
    gear: tuple[float, ...] = ()
    range: tuple[float, float] | None = None  # of its command; None: derived from its type and joint
    unlimited: bool = False
    force: tuple[float, float] | None = None  # smallest and largest, N or N*m
    mjcf: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Contact:
    """Contact parameters of a shape: bit masks and values, by MuJoCo attribute."""

    values: Values = field(default_factory=dict, hash=False)

    @property
    def sliding_friction(self) -> float | None:
        """The coefficient of sliding friction, the first of MuJoCo's three, or None if not set."""
        friction = self.values.get("friction")
        first = friction[0] if isinstance(friction, tuple) and friction else friction
        return float(first) if isinstance(first, (int, float)) else None


@dataclass(frozen=True)
class Marked:
    """A site, a camera or a light (``tag``) of a link, at ``pose`` in it."""

    tag: str
    name: str
    pose: Pose = IDENTITY
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Root:
    """The pose of the root link in the world, and the name and attributes of a free joint there."""

    pose: Pose = IDENTITY
    joint: str = ""
    values: Values = field(default_factory=dict, hash=False)
    placed: bool = False  # the pose is set; otherwise a free base is placed on the floor
    world: bool = False  # the link is MuJoCo's world body


AT_ORIGIN = Root()


@dataclass(frozen=True)
class Entry:
    """An entry in a list of an MJCF, such as constraints or sensors: its element, name and attributes."""

    tag: str
    name: str
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Replicas:
    """Copies of an element: how many, and the pose of each relative to the previous one."""

    count: int
    step: Pose


@dataclass(frozen=True)
class Simulated:
    """An MJCF element for a sensor."""

    kind: str  # one of *_ELEMENT: in the list of sensors, in the body of ``link``, or a template file
    element: str  # the file of a TEMPLATE_ELEMENT
    name: str
    link: str
    pose: Pose | None = None  # in the link; None: the frame of the link
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    replicas: Replicas | None = None
    section: str = ""  # the MJCF section of a TEMPLATE_ELEMENT that is not in a body

    @property
    def site(self) -> str:
        """The site where a sensor element measures: the site of its link, or a separate one if it has a pose."""
        return self.link if self.pose is None else f"{self.name}_site"


@dataclass(frozen=True)
class SdfElement:
    """An SDF element: a value, or attributes and child elements. Numbers are in SI units."""

    name: str
    value: float | str | bool | None = None
    attributes: Mapping[str, float | str | bool] = field(default_factory=dict)
    elements: "tuple[SdfElement, ...]" = ()

    def words(self) -> Any:
        """Return the element as in a description: a value, or a mapping of attributes and child elements."""
        if self.value is not None:
            return self.value
        attributes = {"attributes": dict(self.attributes)} if self.attributes else {}
        return {**attributes, **{element.name: element.words() for element in self.elements}}


@dataclass(frozen=True)
class GazeboSensor:
    """A ``<sensor>`` of SDF, at ``pose`` in ``link``, with the axes of Gazebo (a camera looks along x, z is up)."""

    type: str
    name: str
    link: str  # with ``at_joint``, the name of a joint
    pose: Pose = IDENTITY
    stamp: str = ""  # the frame in the headers of its messages
    elements: tuple[SdfElement, ...] = ()
    at_joint: bool = False
    feels: str = ""  # the link whose shapes a contact sensor observes
    without: frozenset[str] = frozenset()  # default elements that the description removes

    # The element that sets the frame of its messages, by Gazebo version; in Gazebo classic a plug-in sets it.
    FRAME_ELEMENTS: ClassVar = {"harmonic": "gz_frame_id", "fortress": "ignition_frame_id", CLASSIC: ""}
    # The types with a different name in Gazebo classic (gazebo11:gazebo/sensors).
    CLASSIC_NAMES: ClassVar = {"gpu_lidar": "ray", "rgbd_camera": "depth", "depth_camera": "depth", "navsat": "gps"}

    def in_classic(self) -> "GazeboSensor":
        elements = (replace(item, name="ray" if item.name == "lidar" else item.name) for item in self.elements)
        return replace(self, type=self.CLASSIC_NAMES.get(self.type, self.type), elements=tuple(elements))

"""Values that only simulations use, in SI units. Attributes without a YAML key have their MuJoCo names."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from .geometry import IDENTITY, Pose

# The value of an attribute: a number in SI units, string, boolean, tuple of these, or None if not set.
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
    name: str = ""  # "" to use the name of the actuated joint
    targets: Mapping[str, str] = field(default_factory=dict, hash=False)  # driven element, such as {"tendon": NAME}
    kp: float | None = None  # N*m/rad or N/m
    kv: float = 0.0  # N*m*s/rad or N*s/m
    damping_ratio: float = 0.0
    damping: float = 0.0  # damping that the actuator adds to the joint, N*m*s/rad or N*s/m
    gear: tuple[float, ...] = ()
    range: tuple[float, float] | None = None  # range of the command, or None to derive it from ``type`` and the joint
    unlimited: bool = False
    force: tuple[float, float] | None = None  # (minimum, maximum) force or torque, N or N*m
    mjcf: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Contact:
    """Contact parameters of a shape, such as bit masks, by MuJoCo attribute."""

    values: Values = field(default_factory=dict, hash=False)

    @property
    def sliding_friction(self) -> float | None:
        """The sliding friction coefficient (the first value of MuJoCo's ``friction``), or None if not set."""
        friction = self.values.get("friction")
        first = friction[0] if isinstance(friction, tuple) and friction else friction
        return float(first) if isinstance(first, (int, float)) else None


@dataclass(frozen=True)
class Attachment:
    """A site, camera or light (``tag``) that is attached to a link at ``pose``."""

    tag: str
    name: str
    pose: Pose = IDENTITY
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Root:
    """The root link in simulations: its pose in the world, and the name and attributes of its free joint."""

    pose: Pose = IDENTITY
    joint: str = ""
    values: Values = field(default_factory=dict, hash=False)
    placed: bool = False  # True if the pose is set; otherwise a free base is placed on the floor
    world: bool = False  # True if the root link is MuJoCo's world body


AT_ORIGIN = Root()


@dataclass(frozen=True)
class Entry:
    """An element of an MJCF, such as a constraint or sensor: its tag, name and attributes."""

    tag: str
    name: str
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Replicas:
    """Copies of an MJCF element: their number, and the pose of each copy relative to the previous copy."""

    count: int
    step: Pose


@dataclass(frozen=True)
class SensorElement:
    """An MJCF element that simulates a sensor."""

    kind: str  # SENSOR_ELEMENT (in <sensor>), BODY_ELEMENT (in the body of ``link``) or TEMPLATE_ELEMENT (a file)
    element: str  # the tag, or the file of a TEMPLATE_ELEMENT
    name: str
    link: str
    pose: Pose | None = None  # pose in the link, or None for the link frame
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    replicas: Replicas | None = None
    section: str = ""  # MJCF section for a TEMPLATE_ELEMENT, or "" if it belongs in a body

    @property
    def site(self) -> str:
        """The name of the site where the sensor measures: the link's site, or a separate site if ``pose`` is set."""
        return self.link if self.pose is None else f"{self.name}_site"


@dataclass(frozen=True)
class SdfElement:
    """An SDF element with a value, or with attributes and child elements. Numbers are in SI units."""

    name: str
    value: float | str | bool | None = None
    attributes: Mapping[str, float | str | bool] = field(default_factory=dict)
    elements: "tuple[SdfElement, ...]" = ()

    def words(self) -> Any:
        """Convert the element to plain YAML values: a value, or a mapping of attributes and child elements."""
        if self.value is not None:
            return self.value
        attributes = {"attributes": dict(self.attributes)} if self.attributes else {}
        return {**attributes, **{element.name: element.words() for element in self.elements}}


@dataclass(frozen=True)
class GazeboSensor:
    """An SDF ``<sensor>`` at ``pose`` in ``link``, with Gazebo's axes: a camera looks along x, and z is up."""

    type: str
    name: str
    link: str  # the name of a link or, with ``at_joint``, of a joint
    pose: Pose = IDENTITY
    stamp: str = ""  # frame_id in the headers of messages from the sensor
    elements: tuple[SdfElement, ...] = ()
    at_joint: bool = False
    feels: str = ""  # link whose shapes a contact sensor observes
    without: frozenset[str] = frozenset()  # tags of default elements that the description removes

    # The SDF element that sets the frame_id of messages, by Gazebo version. In Gazebo classic, a plug-in sets it.
    FRAME_ELEMENTS: ClassVar = {"harmonic": "gz_frame_id", "fortress": "ignition_frame_id", CLASSIC: ""}
    # Sensor types with a different name in Gazebo classic (gazebo11:gazebo/sensors).
    CLASSIC_NAMES: ClassVar = {"gpu_lidar": "ray", "rgbd_camera": "depth", "depth_camera": "depth", "navsat": "gps"}

    def in_classic(self) -> "GazeboSensor":
        elements = (replace(item, name="ray" if item.name == "lidar" else item.name) for item in self.elements)
        return replace(self, type=self.CLASSIC_NAMES.get(self.type, self.type), elements=tuple(elements))

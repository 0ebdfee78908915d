"""What a simulation has of a sensor, made from the type of the sensor: elements of MJCF and of SDF as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, ClassVar

from .geometry import IDENTITY, Pose

SENSOR_ELEMENT = "sensor"
BODY_ELEMENT = "body"
TEMPLATE_ELEMENT = "template"

# The value of an attribute: a number in SI units, text, true or false, or several of them. None: left out.
Attribute = float | str | bool | tuple[float | str | bool, ...] | None


@dataclass(frozen=True)
class Replicas:
    """Copies of an element: how many, and where each sits against the one before it, turned about one axis at most."""

    count: int
    step: Pose


@dataclass(frozen=True)
class Simulated:
    """What a simulation has of a sensor, in the words of MJCF.

    ``kind`` says where it stands: SENSOR_ELEMENT (in the list of sensors), BODY_ELEMENT (in the body of ``link``) or
    TEMPLATE_ELEMENT (text of a template, in that body, or in the section of the file that ``section`` names).
    ``element`` is the name of the element, or the file of the template. ``pose`` is where it sits in the link; None is
    at the link's own frame.
    """

    kind: str
    element: str
    name: str
    link: str
    pose: Pose | None = None
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    replicas: Replicas | None = None
    section: str = ""

    @property
    def site(self) -> str:
        """The site that a sensor element measures at: that of its frame, or one of its own where it has a pose."""
        return self.link if self.pose is None else f"{self.name}_site"


AT_JOINT = "joint"


CLASSIC = "classic"
# What Gazebo classic calls the sensors that Gazebo has, and the element of a lidar (gazebo11:gazebo/sensors).
_CLASSIC_TYPES = {"gpu_lidar": "ray", "rgbd_camera": "depth", "depth_camera": "depth", "navsat": "gps"}
_CLASSIC_ELEMENTS = {"lidar": "ray"}


@dataclass(frozen=True)
class SdfElement:
    """An element in the words of SDF: a value, or attributes and elements. Numbers are in SI units."""

    name: str
    value: float | str | bool | None = None
    attributes: Mapping[str, float | str | bool] = field(default_factory=dict)
    elements: tuple[SdfElement, ...] = ()

    def words(self) -> Any:
        """Return it as a description has it: a value, or a mapping of attributes and elements."""
        if self.value is not None:
            return self.value
        attributes = {"attributes": dict(self.attributes)} if self.attributes else {}
        return {**attributes, **{one.name: one.words() for one in self.elements}}


@dataclass(frozen=True)
class GazeboSensor:
    """What Gazebo has of a sensor: a ``<sensor>`` of SDF.

    It sits at ``pose`` in ``link``, with the axes of Gazebo (a camera looks along x, z is up); with ``at_joint``, that
    is the name of a joint. Messages carry the frame ``stamp``. ``feels``: the link whose shapes a contact is felt by.
    ``without`` are names of elements that it is said not to have.
    """

    type: str
    name: str
    link: str
    pose: Pose = IDENTITY
    stamp: str = ""
    elements: tuple[SdfElement, ...] = ()
    at_joint: bool = False
    feels: str = ""
    without: frozenset[str] = frozenset()

    # Who reads it, and the element that names the frame of its messages there. SDF up to 1.11 has no word for it; in
    # Gazebo classic a plug-in says it.
    FRAME_ELEMENTS: ClassVar[Mapping[str, str]] = MappingProxyType(
        {"harmonic": "gz_frame_id", "fortress": "ignition_frame_id", CLASSIC: ""}
    )

    def in_classic(self) -> GazeboSensor:
        """Return it as Gazebo classic calls it."""
        elements = (replace(item, name=_CLASSIC_ELEMENTS.get(item.name, item.name)) for item in self.elements)
        return replace(self, type=_CLASSIC_TYPES.get(self.type, self.type), elements=tuple(elements))

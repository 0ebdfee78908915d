"""What a simulation has of a sensor: elements of MJCF as data, made from the type of the sensor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .geometry import Pose

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

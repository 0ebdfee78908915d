"""The sensors of a robot in MJCF: elements in bodies, the list of sensors, and what templates of sensor types add.

A sensor element measures at a site: that of the frame, or one of its own, called NAME_site, where it has a pose. MuJoCo
numbers what stands in ``<replicate>``, and with a site the sensors that measure at it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Pose, Robot, Sensor
from rosorin_compile.model.simulation import (
    BODY_ELEMENT,
    SENSOR_ELEMENT,
    TEMPLATE_ELEMENT,
    Attribute,
    Replicas,
    Simulated,
)
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.numbers import NumberFormat, vector

# The separator before the number of a copy.
_SEPARATOR = "_"

Attributes = Sequence[tuple[str, str]]


class Element(NamedTuple):
    """An element as printed; ``replicate`` are the attributes of the element around it, ``text`` is of a template."""

    tag: str = ""
    attributes: Attributes = ()
    replicate: Attributes = ()
    text: str = ""


class Elements(NamedTuple):
    """All elements: by the body that they stand in, the list of sensors, and text by section of the file."""

    bodies: Mapping[str, Sequence[Element]]
    sensors: Sequence[Element]
    sections: Sequence[tuple[str, str]]
    diagnostics: list[Diagnostic]


def elements_of(robot: Robot, templates: Templates, number: NumberFormat) -> Elements:
    """Return what the sensors of a robot are in MJCF. Raises TemplateProblem if a template fails."""
    bodies: dict[str, list[Element]] = {}
    sensors: list[Element] = []
    sections: list[tuple[str, str]] = []
    diagnostics: list[Diagnostic] = []
    printer = _Printer(number)
    for sensor in robot.sensors:
        for part in sensor.simulated:
            if part.kind == TEMPLATE_ELEMENT:
                text = _rendered(robot, sensor, part, templates, number)
                diagnostics += _damaged(sensor, part, text)
                if part.section:
                    sections.append((part.section, text))
                else:
                    bodies.setdefault(part.link, []).append(Element(text=text))
                continue
            made = printer.element(part)
            if part.kind == SENSOR_ELEMENT:
                sensors.append(made)
                if part.pose is None:
                    continue
                made = printer.site(part)
            bodies.setdefault(part.link, []).append(made)
    return Elements(bodies, sensors, sections, diagnostics)


class _Printer:
    """Puts elements into the terms of MuJoCo, numbers printed."""

    def __init__(self, number: NumberFormat) -> None:
        self.number = number

    def element(self, part: Simulated) -> Element:
        """Return the element itself: in its body with its pose and its copies, in the list of sensors at its site."""
        values: dict[str, str | None] = {"name": part.name}
        if part.kind == BODY_ELEMENT:
            values |= self.pose(part.pose)
        elif part.element.startswith("frame"):
            values |= {"objtype": "site", "objname": part.site}
        else:
            values["site"] = part.site
        values |= {name: self.attribute(value) for name, value in part.attributes.items()}
        attributes = [(name, value) for name, value in values.items() if value is not None]
        return Element(part.element, attributes, self.replicate(part.replicas) if part.kind == BODY_ELEMENT else ())

    def site(self, part: Simulated) -> Element:
        """Return the site of a sensor element that has a pose, with its copies."""
        attributes = [("name", part.site), *self.pose(part.pose).items()]
        return Element("site", attributes, self.replicate(part.replicas))

    def pose(self, pose: Pose | None) -> dict[str, str]:
        """Return the attributes of a pose; what is zero needs none."""
        if pose is None:
            return {}
        values = {"pos": vector(pose.xyz, self.number)} if any(pose.xyz) else {}
        quaternion = pose.transform().quaternion()
        return values if quaternion == (1, 0, 0, 0) else {**values, "quat": vector(quaternion, self.number)}

    def replicate(self, replicas: Replicas | None) -> Attributes:
        if replicas is None:
            return ()
        values = [("count", str(replicas.count)), ("sep", _SEPARATOR)]
        if any(replicas.step.xyz):
            values.append(("offset", vector(replicas.step.xyz, self.number)))
        if any(replicas.step.rpy):
            values.append(("euler", vector(replicas.step.rpy, self.number)))
        return values

    def attribute(self, value: Attribute) -> str | None:
        if isinstance(value, tuple):
            return " ".join(self.scalar(item) for item in value)
        return None if value is None else self.scalar(value)

    def scalar(self, value: float | str | bool) -> str:
        if isinstance(value, bool):
            return "true" if value else "false"
        return value if isinstance(value, str) else self.number(value)


def _rendered(robot: Robot, sensor: Sensor, part: Simulated, templates: Templates, number: NumberFormat) -> str:
    printed = partial(vector, number=number)
    values: dict[str, Any] = {"robot": robot, "sensor": sensor, "element": part, "number": number, "vector": printed}
    return templates.render(part.element, values).strip()


def _damaged(sensor: Sensor, part: Simulated, text: str) -> Iterator[Diagnostic]:
    """Yield an error if the text of a template would spoil the file."""
    from xml.etree import ElementTree

    what = f'what {part.element} makes for sensor "{sensor.name}"'
    around = part.section or "body"
    try:
        made = ElementTree.fromstring(f"<{around}>{text}</{around}>")  # noqa: S314 - no entities without a DOCTYPE
    except ElementTree.ParseError as problem:
        help = "MJCF is XML: close every element, put every value in quotes"
        yield error("template-failed", f"{what} is no XML: {problem}", None, help)
        return
    if any(True for name in ("joint", "freejoint") for _ in made.iter(name)):
        yield error("template-failed", f"{what} has a joint", None, "a joint stands in joints of the description")
    if any(not body.get("name") for body in made.iter("body") if body is not made):
        yield error("template-failed", f"{what} has a body without a name", None, "name it")

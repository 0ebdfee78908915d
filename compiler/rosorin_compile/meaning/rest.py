"""Rest: sensors, the drive, and what only two robots of one format are compared by.

Publishers, hardware, controllers, what sensors have in simulations, names of shapes: each format says those in
words of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from ..frontend.annotations import sections
from ..model import HeightMap, Robot
from ..model.drive import ROLES
from ..model.sections import own_sections
from .difference import OTHER, Item, Side
from .joints import changed, differ
from .pairing import Pairing
from .plainly import compare_entries, compare_plainly, either
from .values import changed_entry
from .wording import number

# Shapes in two lists of one length are known by their numbers, their names and what they look like are compared.
_PURPOSES = ("collision", "visual")


def compare_sensors(a: Robot, b: Robot) -> Iterator[Item]:
    """Yield what differs in the types and frames of sensors."""
    old, new = {sensor.name: sensor for sensor in a.sensors}, {sensor.name: sensor for sensor in b.sensors}
    yield from either("sensor", old, new)
    for name in old:
        for quantity in ("type", "frame", "optical_frame"):
            if name not in new:
                continue
            before, after = str(getattr(old[name], quantity)), str(getattr(new[name], quantity))
            if before != after:
                text = f"sensor {name} {quantity.replace('_', ' ')} {before or 'none'} -> {after or 'none'}"
                yield Item(OTHER, name, quantity, text, before, after)


def compare_drives(pairing: Pairing) -> Iterator[Item]:
    """Yield what differs in what moves the base."""
    a, b = pairing.a.robot.drive, pairing.b.robot.drive
    if a is None or b is None or a.kind != b.kind:
        before, after = a.kind if a else None, b.kind if b else None
        if before != after:
            text = f"drive {before or 'none'} -> {after or 'none'}"
            yield Item(OTHER, "drive", "kind", text, before, after)
        return
    pairs = [("frame", a.frame or pairing.a.robot.root, b.frame or pairing.b.robot.root)]
    for role in ROLES[a.kind]:
        pairs.append((role, ", ".join(a.joints.get(role, ())), ", ".join(b.joints.get(role, ()))))
    for quantity, before, after in pairs:
        if before != after:
            text = f"drive {quantity.replace('_', ' ')} {before or 'none'} -> {after or 'none'}"
            yield Item(OTHER, "drive", quantity, text, before, after)
    if a.radius is not None and b.radius is not None:
        if differ(pairing.a, pairing.b, "radius", (a.radius, b.radius), pairing.tolerance):
            yield changed(OTHER, "drive", "radius", (a.radius, b.radius), "m")
    elif a.radius != b.radius:
        said = ["from its shapes" if one is None else f"{number(one)} m" for one in (a.radius, b.radius)]
        yield Item(OTHER, "drive", "radius", f"drive radius {said[0]} -> {said[1]}", said[0], said[1])


def compare_rest(pairing: Pairing, sides: tuple[Side, Side]) -> Iterator[Item]:
    """Yield what differs in what no other comparison reads; that something is new or gone is told where it is named."""
    if sides[0].format is not sides[1].format:
        return
    a, b = pairing.a.robot, pairing.b.robot
    yield from changed_entry("the robot", {"modes": a.modes}, {"modes": b.modes})
    yield from compare_plainly(_plain(a), _plain(b))
    yield from compare_entries("publisher of", _own_publishers(a), _own_publishers(b))
    yield from compare_entries("sensor", _simulated(a), _simulated(b))
    yield from compare_entries("", _shapes(a, b), _shapes(b, a))


def _plain(robot: Robot) -> dict[str, Any]:
    """Return the sections that are compared value by value."""
    of_model = (field.name for field in fields(robot) if field.name in sections() and sections()[field.name].compared)
    own = (name for name in own_sections() if sections()[name].compared and name in robot.sections.values)
    named = {**{name: getattr(robot, name) for name in of_model}, **{name: robot.sections[name] for name in own}}
    return {**robot.sections.said, **named}


def _own_publishers(robot: Robot) -> dict[str, Any]:
    """Return what is said of who publishes a frame where that is no node of the list, by the frame."""
    named = {one.name for one in robot.publishers}
    owners = {joint.child: joint.publisher for joint in robot.joints if joint.publisher.name not in named}
    return {child: {"about": one.about, "package": one.package} for child, one in owners.items()}


def _simulated(robot: Robot) -> dict[str, Any]:
    return {one.name: {"stamps": one.stamps, "simulated": one.simulated, "gazebo": one.gazebo} for one in robot.sensors}


def _shapes(robot: Robot, other: Robot) -> dict[str, Any]:
    """Return what is said of shapes beside their numbers and colours."""
    found: dict[str, Any] = {}
    for link in robot.links:
        twin = other.link.get(link.name)
        for purpose in _PURPOSES:
            shapes = getattr(link, purpose)
            if twin is None or len(shapes) != len(getattr(twin, purpose)):
                continue
            for place, shape in enumerate(shapes, 1):
                said = {"name": shape.name, "material": shape.material, "texture": robot.texture(shape)}
                if isinstance(shape.geometry, HeightMap):
                    said["method"] = shape.geometry.method
                found[f"{purpose} shape {place} of {link.name}"] = said
    return found

"""Plainly: sections whose entries are plain values, compared one by one, as the schema calls them.

What a section is for does not matter here: an entry is a record of the model or a mapping, whatever words it has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from rosorin_compile.language.annotations import ENTRIES, Node
from rosorin_compile.language.schema import sections
from rosorin_compile.model import HeightMap, Robot

from .difference import OTHER, Item, Side
from .pairing import Pairing
from .values import changed_entry, differing

# Shapes in two lists of one length are known by their numbers, their names and what they look like are compared.
_PURPOSES = ("collision", "visual")


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
    named = (field.name for field in fields(robot) if field.name in sections() and sections()[field.name].compared)
    return {**robot.sections.said, **{name: getattr(robot, name) for name in named}}


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


def compare_plainly(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Item]:
    """Yield what differs in sections, each by its name: entries that are new or gone, then their values.

    A section is one entry, many by name, or a list, in which entries without a name have numbers, as far as they have
    no equal in the other one; ``None`` is none.
    """
    for section, node in sections().items():
        if node.compared:
            entries = _entries(node, old.get(section), new.get(section))
            yield from either(node.compared, *entries)
            yield from compare_entries(node.compared, *entries)


def either(kind: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Item]:
    """Yield the names that are in one of two tables only."""
    for name in old:
        if name not in new:
            yield Item(OTHER, name or kind, kind, f"removed: {kind} {name}".strip(), name or kind, None)
    for name in new:
        if name not in old:
            yield Item(OTHER, name or kind, kind, f"new: {kind} {name}".strip(), None, name or kind)


def compare_entries(kind: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Item]:
    """Yield what differs in the entries that both have."""
    for name in old:
        if name in new:
            yield from changed_entry(f"{kind} {name}".strip(), old[name], new[name])


Entries = Mapping[str, Any]


def _entries(node: Node, old: Any, new: Any) -> tuple[Entries, Entries]:
    """Return the entries of a section in two robots by name."""
    if isinstance(old or new, (tuple, list)):
        return _of_lists(old or (), new or ())
    if node.merge == ENTRIES:
        return old or {}, new or {}
    return {} if old is None else {"": old}, {} if new is None else {"": new}


def _of_lists(old: Sequence[Any], new: Sequence[Any]) -> tuple[Entries, Entries]:
    left, gone = list(new), []
    for one in old:
        equal = next((at for at, other in enumerate(left) if not any(differing(one, other))), None)
        if equal is None:
            gone.append(one)
        else:
            del left[equal]
    first, second = (
        {getattr(one, "name", "") or str(at): one for at, one in enumerate(some, start=1)} for some in (gone, left)
    )
    return first, second

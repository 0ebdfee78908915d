"""Difference: two robots compared by meaning, whatever they were written in.

B is put under the names of A first (``pairing``); then frames, joints, masses, shapes and the rest are compared, each
seen from the nearest thing that both have. What a format cannot say is told as not compared, never as a difference.

A comparison is lines for people, and JSON for programs (``schemas/robot_diff.schema.json``).
"""

from __future__ import annotations

from typing import Any

from ..diagnostics.wording import counted, printable
from .frames import compare_frames, furthest
from .item import (
    DEFAULT_TOLERANCE,
    FRAME,
    JOINT,
    KINDS,
    LIMIT,
    MASS,
    NAME,
    OTHER,
    SHAPE,
    VISUAL,
    Difference,
    Item,
    Side,
)
from .joints import compare_joints
from .others import compare_masses, compare_others
from .pairing import Pairing, compare_names, pair
from .shapes import compare_shapes
from .unsaid import not_carried, unsaid


def compare_robots(a: Side, b: Side, tolerance: float = DEFAULT_TOLERANCE, prefix: str | None = None) -> Difference:
    """Return how two robots differ by meaning.

    ``tolerance`` is no difference (m, rad, parts of other numbers), besides what the digits of a source leave open.
    ``prefix`` is what the names of B begin with, None: find out, empty: nothing.
    """
    pairing = pair(*_known_names(a, b), tolerance, prefix)
    missing, lacking = not_carried(pairing, a, b)
    silent = unsaid(a, b)
    frames = compare_frames(pairing)
    items = [*frames.items, *compare_joints(pairing, frames.coordinates, silent.topics)]
    notes = [*_prefix_note(pairing, a, b), *frames.notes]
    not_compared = [*lacking, *silent.lines]
    if "mass" not in silent.topics:
        found, said = compare_masses(pairing, frames.clusters)
        items += found
        notes += said
    for purpose in ("collision", "visual"):
        if purpose not in silent.topics:
            shapes = compare_shapes(pairing, (a, b), frames.clusters, purpose)
            items += shapes.items
            notes += shapes.notes
            not_compared += shapes.not_compared
    items += compare_names(pairing, missing, "fixed joint name" not in silent.topics)
    items += compare_others(pairing, (a, b), silent.topics)
    if a.robot.name != b.robot.name and a.format.names_robot and b.format.names_robot:
        notes.append(f"the robot is called {a.robot.name} in A, {b.robot.name} in B")
    moved = [item for item in items if item.kind in (FRAME, JOINT)]
    if moved:
        notes += furthest(pairing, frames.coordinates, moved)
    return Difference(a, b, _arranged(pairing, items), tuple(notes), tuple(not_compared), tolerance)


def _known_names(a: Side, b: Side) -> tuple[Side, Side]:
    """Return the sides under common names where a description says how an artifact calls its links."""
    from .pairing import renamed

    for side, other in ((a, b), (b, a)):
        output = other.format.output(side.robot)
        if other.format.names is not None and output is not None:
            names = other.format.names(output)
            free = {new: old for new, old in names.items() if old not in other.robot.link}
            changed = other._replace(robot=renamed(other.robot, free, {}))
            return (a, changed) if other is b else (changed, b)
    return a, b


def _prefix_note(pairing: Pairing, a: Side, b: Side) -> list[str]:
    if not pairing.prefixed:
        return []
    whole = (b if pairing.prefixed == "B" else a).robot
    cut = sum(name.startswith(pairing.prefix) for name in whole.link)
    some = "" if cut == len(whole.links) else f"{cut} of {len(whole.links)} of "
    return [f'{some}the names of {pairing.prefixed} begin with "{pairing.prefix}"']


def _arranged(pairing: Pairing, items: list[Item]) -> tuple[Item, ...]:
    """Return the differences, the most important kind first, each kind in the order of the tree."""
    order = {name: index for index, name in enumerate([*pairing.a.order, *pairing.b.order])}
    for bodies in (pairing.b, pairing.a):
        order |= {joint.name: order[joint.child] for joint in bodies.robot.joints if joint.name not in bodies.order}
    order |= pairing.a.order
    last = len(order)
    return tuple(sorted(items, key=lambda item: (KINDS.index(item.kind), order.get(item.name, last))))


_COUNTED = {
    FRAME: ("frame", "frames"),
    JOINT: ("joint", "joints"),
    LIMIT: ("limit", "limits"),
    MASS: ("mass", "masses"),
    SHAPE: ("set of collision shapes", "sets of collision shapes"),
    VISUAL: ("visual", "visuals"),
    NAME: ("name", "names"),
    OTHER: ("other thing", "other things"),
}
# More than a person reads; a program gets all.
_MOST = 200


def lines(difference: Difference, full: bool = False) -> list[str]:
    """Return a comparison as lines of plain text, the most important differences first, a summary last."""
    if difference.a is None or difference.b is None:
        return [*(str(diagnostic) for diagnostic in difference.diagnostics), summary(difference)]
    said = [f"{letter}: {_side(side)}" for letter, side in (("A", difference.a), ("B", difference.b))]
    said += [item.text for item in difference.items]
    if not full and len(difference.items) > _MOST:
        said[2 + _MOST :] = [f"... {len(difference.items) - _MOST} more differences (--full shows them)"]
    said += [f"note: {note}" for note in difference.notes]
    said += [f"not compared: {line}" for line in difference.not_compared]
    return [printable(line, keep="\t") for line in [*said, summary(difference)]]


def _side(side: Side) -> str:
    robot = side.robot
    links, joints = len(robot.links), sum(not joint.is_fixed for joint in robot.joints)
    sizes = f"{counted(links, 'link')}, {joints:,} that move{'s' if joints == 1 else ''}"
    return f"{side.label} ({side.format.word} of {robot.name}, {sizes})"


def summary(difference: Difference) -> str:
    """Return one line: the same, or how many differences of each kind."""
    if difference.a is None or difference.b is None:
        return "not compared"
    if difference.same:
        return "the same robot, as far as it was compared"
    counts = {kind: sum(item.kind == kind for item in difference.items) for kind in KINDS}
    said = [f"{count} {_COUNTED[kind][count > 1]}" for kind, count in counts.items() if count]
    return f"different: {', '.join(said)}"


def as_json(difference: Difference) -> dict[str, Any]:
    """Return a comparison as a value of JSON. Raises ValueError if there was nothing to compare."""
    a, b = difference.sides
    return {
        "a": _side_json(a),
        "b": _side_json(b),
        "same": difference.same,
        "tolerance": difference.tolerance,
        "differences": [_item_json(item) for item in difference.items],
        "notes": list(difference.notes),
        "not_compared": list(difference.not_compared),
        "summary": summary(difference),
    }


def _side_json(side: Side) -> dict[str, Any]:
    robot = side.robot
    counts = {"links": len(robot.links), "joints": len(robot.joints)}
    return {"source": side.label, "format": side.format.name, "robot": robot.name, **counts}


def _item_json(item: Item) -> dict[str, Any]:
    found: dict[str, Any] = {"kind": item.kind, "name": item.name, "quantity": item.quantity, "text": item.text}
    found |= {"a": item.before, "b": item.after, "unit": item.unit}
    if item.distance is not None:
        found["distance"] = item.distance
    if item.angle is not None:
        found["angle"] = item.angle
    if item.when:
        found["when"] = item.when
    if item.at:
        found["at"] = dict(item.at)
    return found

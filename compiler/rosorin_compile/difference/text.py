"""Text: a comparison as lines for people, and as JSON for programs (``schemas/robot_diff.schema.json``)."""

from __future__ import annotations

from typing import Any

from ..wording import counted, printable
from .values import (
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

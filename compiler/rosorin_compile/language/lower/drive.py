"""The section ``drive`` of a description as a value of the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model.drive import ROLES, Drive
from rosorin_compile.source.rule_registry import JOINTS, Rule
from rosorin_compile.source.wording import listed

from .entries import Problem, source_of

RULES = (
    Rule(
        "drive-kind",
        "A drive says no kind of base, or several.",
        "One of `mecanum`, `differential`, `omni`, `tricycle`, `ackermann`, with its wheels.",
        JOINTS,
    ),
)


def drive_of(tree: Mapping[str, Any], problem: Problem) -> Drive | None:
    """Return what drives a robot; ``problem`` takes what is wrong with it, and it is None then."""
    entry = tree["drive"]
    kinds = [kind for kind in ROLES if kind in entry]
    if len(kinds) != 1:
        message = f"drive has one of {', '.join(ROLES)}; this one has {listed(kinds) or 'none'}"
        problem("drive-kind", message, ("drive",), "say which kind of base it is, and its wheels")
        return None
    said = entry[kinds[0]]
    joints = {role: _names(said[role]) for role in ROLES[kinds[0]] if role in said}
    radius = float(entry["radius"]) if "radius" in entry else None
    return Drive(kinds[0], joints, entry.get("frame", ""), radius, source_of(entry.get("source")))


def _names(said: Any) -> tuple[str, ...]:
    return (str(said),) if isinstance(said, str) else tuple(map(str, said))

"""What differs in what MoveIt has to know of two robots."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.compare.difference import OTHER, YAML, Item, Side
from rosorin_compile.compare.pairing import Pairing
from rosorin_compile.compare.values import changed_entry
from rosorin_compile.model.moveit import said_of

from . import MOVEIT

AFTER = "drive"


def compare(pairing: Pairing, sides: tuple[Side, Side]) -> Iterator[Item]:
    """Yield what differs between two descriptions in planning. States are named poses, and compared as those."""
    one, other = pairing.a.robot.sections[MOVEIT], pairing.b.robot.sections[MOVEIT]
    if one == other or not all(side.format is YAML for side in sides):
        return
    old, new = said_of(one), said_of(other)
    for name in dict.fromkeys((*old, *new)):
        before, after = old.get(name), new.get(name)
        if before != after:
            text = f"MoveIt: {name} {before or 'none'} -> {after or 'none'}"
            yield Item(OTHER, name, "planning", text, before, after)
    if one is not None and other is not None:
        for word in ("urdf", "search"):
            yield from changed_entry("MoveIt", {word: getattr(one, word)}, {word: getattr(other, word)})

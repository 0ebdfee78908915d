"""What differs in what MoveIt has to know of two robots."""

from __future__ import annotations

from collections.abc import Iterator

from ...meaning.difference import OTHER, Item
from ...meaning.values import changed_entry
from .value import Moveit, said_of


def compare(one: Moveit | None, other: Moveit | None) -> Iterator[Item]:
    """Yield what differs; the joints of states are those of poses."""
    if one == other:
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

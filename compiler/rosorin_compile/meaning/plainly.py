"""Plainly: sections whose entries are plain values, compared one by one, as the schema calls them.

What a section is for does not matter here: an entry is a record of the model or a mapping, whatever words it has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..frontend.annotations import ENTRIES, Node, sections
from .difference import OTHER, Item
from .values import changed_entry, differing


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

"""Plainly: sections whose entries are plain values, compared one by one, as the schema calls them.

What a section is for does not matter here: an entry is a record of the model or a mapping, whatever words it has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..frontend.annotations import ENTRIES, Node, sections
from .difference import OTHER, Item
from .values import changed_entry


def compare_plainly(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Item]:
    """Yield what differs in sections, each by its name: entries that are new or gone, then their values.

    A section is one entry, many by name, or a list, in which entries without a name have numbers; ``None`` is none.
    """
    for section, node in sections().items():
        if node.compared:
            entries = _by_name(node, old.get(section)), _by_name(node, new.get(section))
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


def _by_name(node: Node, section: Any) -> Mapping[str, Any]:
    """Return the entries of a section by name."""
    if section is None:
        return {}
    if isinstance(section, (tuple, list)):
        return {getattr(one, "name", "") or str(at): one for at, one in enumerate(section, start=1)}
    return section if node.merge == ENTRIES else {"": section}

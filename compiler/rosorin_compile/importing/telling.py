"""Telling: what became of a source, in a few lines for the person who imports it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from typing import Any

from ..tree import Map, Seq
from ..wording import counted, first_of

_TAG = re.compile(r"<([^\s/>!?]+)")
_FEW = 3


def sizes(tree: Map) -> str:
    """Return how many links and joints a robot has."""
    links, joints = len(tree.get("links") or ()), len(tree.get("joints") or ())
    return f"{counted(links, 'link')}, {counted(joints, 'joint')}"


def kept(tree: Map) -> list[str]:
    """Return the line about elements that stand in the description as they stood in the source; none without any."""
    tags = Counter(_tag(text) for text in _elements(tree))
    if not tags:
        return []
    return ["kept as they are: " + ", ".join(f"{tag} ({count})" if count > 1 else tag for tag, count in tags.items())]


def accepted(tree: Map) -> list[str]:
    """Return the lines about rules that the robot breaks, and that the description accepts."""
    found: dict[str, list[str]] = {}
    for entry in tree.get("accept") or ():
        found.setdefault(entry["rule"], []).extend(map(str, entry.get("of") or ()))
    return [
        f"accepted: {rule} ({first_of(names, _FEW)})" if names else f"accepted: {rule}" for rule, names in found.items()
    ]


def _elements(node: Any) -> Iterator[str]:
    """Yield every element that is kept, in the order of the tree."""
    if isinstance(node, Map):
        for key, value in node.items():
            if key == "urdf_elements" and isinstance(value, Seq):
                yield from value
            else:
                yield from _elements(value)
    elif isinstance(node, Seq):
        for item in node:
            yield from _elements(item)


def _tag(text: str) -> str:
    found = _TAG.search(text)
    return found[1] if found else "text"

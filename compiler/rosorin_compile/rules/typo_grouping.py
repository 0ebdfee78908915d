"""Misspelt names: an unknown name is reported once, where its letters were written, with its probable definition.

A misspelt definition leaves every use of it unknown: if nothing uses the definition, the uses are one diagnostic that
shows it. Diagnostics that only follow from an unknown name are dropped.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.language.annotations import Node
from rosorin_compile.language.schema import sections
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Related, Span
from rosorin_compile.source.messages import UNNAMED, Offer, merge_by_name, offer, placed, written
from rosorin_compile.source.tree import Instance, Map, Place, Seq, exists, locate, nearer
from rosorin_compile.source.tree import Path as TreePath

from .names import named_sections

_WORD = re.compile(r"\w+")
# Diagnostics that follow from an unknown name, and the rules that report that name.
_FOLLOWING = {
    "control-joint": ("unknown-link", "unknown-joint", "unknown-option"),
    "controller-missing": ("control-interface", "controller-name", "unknown-joint"),
    "moveit-not-in-urdf": ("unknown-backend", "unknown-option"),
    "moveit-state": ("unknown-joint",),
    "moveit-urdf": ("unknown-backend",),
    "navigation-frames": ("unknown-link", "unknown-publisher"),
    "navigation-owner": ("unknown-link", "unknown-publisher"),
    "scene-without-robot": ("unknown-backend",),
    "unreached-link": ("unknown-link",),
}


def merge_misspelt(
    diagnostics: list[Diagnostic], tree: Map, places: Mapping[tuple[str, str], TreePath]
) -> list[Diagnostic]:
    """Merge all diagnostics caused by one misspelt name; ``places`` as in ``check``."""
    wrong = {one.rule for one in diagnostics if one.severity == ERROR}
    diagnostics = [one for one in diagnostics if wrong.isdisjoint(_FOLLOWING.get(one.rule, ()))]
    offers = [offer(one) for one in diagnostics]
    if not any(offers):
        return diagnostics
    uses: dict[str, list[tuple[TreePath, Place]]] = {one.meant: [] for one in offers if one}
    _collect(tree, tree.via, (), Node(properties=sections()), uses)
    moved = []
    for diagnostic, found in zip(diagnostics, offers, strict=True):
        moved.append(placed(diagnostic, found))
        defined = next(_definitions(tree, places, found.meant), None) if found else None
        if found and defined:
            path, home = defined[0], _home(defined[1], found)
            others = [one for where, one in uses[found.meant] if where[: len(path)] != path]
            if all(_home(one, found) == home for one in others):
                note = Related(f'"{found.meant}" {UNNAMED}', home)
                moved[-1] = replace(moved[-1], related=(*moved[-1].related, note))
    homes = {note.span for one in moved for note in one.related if note.message.endswith(UNNAMED)}
    # The warning that the letters of such a definition are swapped says the same again.
    return merge_by_name(one for one in moved if one.severity == ERROR or one.span not in homes)


def _home(place: Place, found: Offer) -> Span:
    """Return where the letters of a name were written that differ from those of the unknown one."""
    return written([place.span, *(one.span for one in place.stack())], found.meant, found.name) or place.span


def _definitions(tree: Map, places: Mapping[tuple[str, str], TreePath], name: str) -> Iterator[tuple[TreePath, Place]]:
    for kind, key in (("link", "frame"), ("joint", "joint")):
        path = places.get((kind, name))
        if path and path[0] in ("links", "joints"):
            yield path, locate(tree, path, key=True)
        elif path:
            path = (*path, key) if path[-1] != key and exists(tree, (*path, key)) else path
            yield path, locate(tree, path)
    for section, _ in named_sections():
        if name in (tree.get(section) or ()):
            yield (section, name), locate(tree, (section, name), key=True)
    for group, entry in (tree.get("servos") or {}).items():
        if name in entry["joints"]:
            path = ("servos", group, "joints", entry["joints"].index(name))
            yield path, locate(tree, path)


def _collect(
    node: Any, via: Instance | None, path: TreePath, schema: Node | None, uses: dict[str, list[tuple[TreePath, Place]]]
) -> None:
    """Add the path and place of each use of some names in a piece of the tree."""
    via = nearer(via, node.via)
    # The keys of the option rename of an output are frames.
    is_naming = len(path) == 3 and (path[0], path[2]) == ("outputs", "rename")
    is_naming = is_naming or (schema is not None and schema.keys is not None and bool(schema.keys.names))
    for key, value in node.items() if isinstance(node, Map) else enumerate(node):
        if is_naming and key in uses:
            uses[key].append(((*path, key), Place(node.key_spans[key], via)))
        if isinstance(value, (Map, Seq)):
            _collect(value, via, (*path, key), schema and schema.below(key), uses)
        elif isinstance(value, str):
            for name in uses.keys() & (_WORD.findall(value) if key == "when" else (value,)):  # conditions name several
                uses[name].append(((*path, key), Place(node.value_spans[key], via)))

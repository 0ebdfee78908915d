"""Misspelt names: an unknown one is told where its letters were written, with the definition that it should name.

Who misspells a definition leaves every use of it behind: where nothing names what was defined, the uses are told as
one, and the definition is shown. What only follows from an unknown name is not told beside it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.language.annotations import Node
from rosorin_compile.language.schema import sections
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Related, Span
from rosorin_compile.source.messages import UNNAMED, Offer, offer, placed, told_once, written
from rosorin_compile.source.tree import Instance, Map, Place, Seq, exists, locate, nearer
from rosorin_compile.source.tree import Path as TreePath

from .names import named_sections

_WORD = re.compile(r"\w+")
# Options of outputs whose keys name what is defined elsewhere.
_NAMING = ("outputs", "rename")
# What is wrong because a name leads nowhere, and the rules that tell that: who corrects it sees whether it still is.
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


def once(diagnostics: list[Diagnostic], tree: Map, places: Mapping[tuple[str, str], TreePath]) -> list[Diagnostic]:
    """Return what is wrong with a robot, with every misspelt name told once; ``places`` as in ``check``."""
    wrong = {one.rule for one in diagnostics if one.severity == ERROR}
    diagnostics = [one for one in diagnostics if wrong.isdisjoint(_FOLLOWING.get(one.rule, ()))]
    offers = [offer(one) for one in diagnostics]
    if not any(offers):
        return diagnostics
    mentions = _mentions(tree, {one.meant for one in offers if one})
    told = [_told(one, of, tree, places, mentions) if of else one for one, of in zip(diagnostics, offers, strict=True)]
    homes = {note.span for one in told for note in one.related if note.message.endswith(UNNAMED)}
    # Of a definition that is shown it is not said, too, that its letters are swapped.
    return told_once(one for one in told if one.severity == ERROR or one.span not in homes)


class _Named(NamedTuple):
    """Where a name is defined or named: the path in the tree, and the place."""

    path: TreePath
    place: Place


def _told(
    diagnostic: Diagnostic,
    of: Offer,
    tree: Map,
    places: Mapping[tuple[str, str], TreePath],
    mentions: Mapping[str, list[_Named]],
) -> Diagnostic:
    """Return an unknown name at the place of its letters, with the definition that nothing names."""
    diagnostic = placed(diagnostic, of)
    defined = next(_definitions(tree, places, of.meant), None)
    if defined is None:
        return diagnostic
    home, size = _home(defined.place, of), len(defined.path)
    others = [one for one in mentions.get(of.meant, ()) if one.path[:size] != defined.path]
    if any(_home(one.place, of) != home for one in others):
        return diagnostic
    note = Related(f'"{of.meant}" {UNNAMED}', home)
    return replace(diagnostic, related=(*diagnostic.related, note))


def _home(place: Place, of: Offer) -> Span:
    """Return where the letters of a defined name were written that tell it from the unknown one."""
    return written([place.span, *(one.span for one in place.stack())], of.meant, of.name) or place.span


def _definitions(tree: Map, places: Mapping[tuple[str, str], TreePath], name: str) -> Iterator[_Named]:
    for kind, key in (("link", "frame"), ("joint", "joint")):
        path = places.get((kind, name))
        if path and path[0] in ("links", "joints"):
            yield _Named(path, locate(tree, path, key=True))
        elif path:
            path = (*path, key) if path[-1] != key and exists(tree, (*path, key)) else path
            yield _Named(path, locate(tree, path))
    for section, _ in named_sections():
        owner = tree.get(section)
        if isinstance(owner, Map) and name in owner:
            yield _Named((section, name), locate(tree, (section, name), key=True))
    for group, entry in (tree.get("servos") or {}).items():
        if name in entry["joints"]:
            path = ("servos", group, "joints", entry["joints"].index(name))
            yield _Named(path, locate(tree, path))


def _mentions(tree: Map, wanted: set[str]) -> dict[str, list[_Named]]:
    found: dict[str, list[_Named]] = {}

    def walk(node: Any, via: Instance | None, path: TreePath, said: Node | None) -> None:
        via = nearer(via, node.via)
        names = (len(path) == 3 and (path[0], path[2]) == _NAMING) or (
            said is not None and said.keys is not None and bool(said.keys.names)
        )
        for key, value in node.items() if isinstance(node, Map) else enumerate(node):
            if names and key in wanted:
                found.setdefault(str(key), []).append(_Named((*path, key), Place(node.key_spans[key], via)))
            if isinstance(value, (Map, Seq)):
                walk(value, via, (*path, key), said and said.below(key))
            elif isinstance(value, str):
                # A condition names several modes.
                for name in wanted.intersection(_WORD.findall(value) if key == "when" else (value,)):
                    found.setdefault(name, []).append(_Named((*path, key), Place(node.value_spans[key], via)))

    walk(tree, tree.via, (), Node(properties=sections()))
    return found

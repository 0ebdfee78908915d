"""Mentions: every place of a description that names something, as the schema says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from rosorin_compile.source.tree import Map, Path

from .annotations import SPELT, Node, sections


@dataclass(frozen=True)
class Mention:
    """A name of a kind, where it is used, and what is said of it there; ``key`` where a key of the description is it.

    ``among`` says where it is looked up: "" among the names of the description.
    """

    kind: str
    name: str
    path: Path
    key: bool
    what: str
    among: str


def mentions(tree: Map, kinds: Collection[str] = (), only: str = "") -> Iterator[Mention]:
    """Yield what names something of some kinds, or of any, in the order of the schema and of the description.

    What has a rule of its own, or none (``x-said`` is false), is left out. ``only`` is the one section that is asked.
    """
    for section, node in sections().items():
        if tree.get(section) is not None and _has(node, kinds) and only in ("", section):
            yield from _at(node, tree[section], (section,), kinds)


def _has(node: Node, kinds: Collection[str]) -> bool:
    return not kinds or not node.of.isdisjoint(kinds)


def _at(node: Node, value: Any, path: Path, kinds: Collection[str]) -> Iterator[Mention]:
    if node.said is False:
        return
    if isinstance(value, str):
        if _is_asked(node, kinds):
            yield _mention(node, value, path, key=False)
        return
    inner: Iterable[tuple[str | int, Node | None, Any]]
    if isinstance(value, Map):
        if node.keys is not None and _is_asked(node.keys, kinds):
            yield from (_mention(node.keys, name, (*path, name), key=True) for name in value)
        inner = ((key, node.at(key), one) for key, one in value.items())
    elif isinstance(value, list):
        inner = ((index, node.items, one) for index, one in enumerate(value))
    else:
        return
    for step, below, one in inner:
        if below is not None and _has(below, kinds):
            yield from _at(below, one, (*path, step), kinds)


def _is_asked(node: Node, kinds: Collection[str]) -> bool:
    return bool(node.names) and node.said is not False and (not kinds or node.names in kinds)


def _mention(node: Node, name: str, path: Path, key: bool) -> Mention:
    """Return a mention; of what the schema has no words for it is said where it stands."""
    words = node.said.format(*path) if node.said else f"the {path[-1]} of {_entry(path)}"
    return Mention(node.names, name, path, key, words, node.among)


def _entry(path: Path) -> str:
    section = sections()[str(path[0])]
    if len(path) > 2 and isinstance(path[1], int):
        return f"{path[0]}[{path[1]}]"
    by_name = section.keys is not None or section.others is not None
    return f'{section.called or path[0]} "{path[1]}"' if len(path) > 2 and by_name else section.called or str(path[0])


def explained(tree: Map) -> Iterator[Path]:
    """Yield the paths of entries that have no frame, of whose numbers the schema says that they are shown."""
    for section, node in sections().items():
        if node.explained is True:
            yield from ((section, name) for name in tree.get(section) or ())


def givers(tree: Map, section: str) -> Iterator[tuple[str, str, Path]]:
    """Yield what a section gives names to: the kind, the name, and the path of the text or the key that is it."""
    node = sections().get(section)
    if node is not None and tree.get(section) is not None:
        found = _marked(node, tree[section], (section,), lambda one: one.gives)
        yield from ((kind, name, path) for kind, name, path, _ in found)


def spelt(tree: Map) -> Iterator[Marked]:
    """Yield the texts and keys whose words are held against usual ones (``x-spelt``), each with what it is called."""
    for section, node in sections().items():
        if SPELT in node.of and tree.get(section) is not None:
            yield from _marked(node, tree[section], (section,), lambda one: one.spelt)


# What the schema says of a text or a key, that, the path to it, and whether it is a key.
Marked = tuple[str, str, Path, bool]


def _marked(node: Node, value: Any, path: Path, mark: Callable[[Node], str]) -> Iterator[Marked]:
    if isinstance(value, str) and mark(node):
        yield mark(node), value, path, False
    inner: Iterable[tuple[str | int, Node | None, Any]] = ()
    if isinstance(value, Map):
        if node.keys is not None and mark(node.keys):
            yield from ((mark(node.keys), name, (*path, name), True) for name in value)
        inner = ((key, node.at(key), one) for key, one in value.items())
    elif isinstance(value, list):
        inner = ((index, node.items, one) for index, one in enumerate(value))
    for step, below, one in inner:
        if below is not None:
            yield from _marked(below, one, (*path, step), mark)

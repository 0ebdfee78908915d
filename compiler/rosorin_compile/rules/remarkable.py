"""What single values of a tree are worth a second look: found in one pass, since trees can be large."""

from __future__ import annotations

import math
import re
from typing import Any, NamedTuple

from rosorin_compile.language.expression.syntax import NUMERIC
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import has_unit

# A little more than one turn, so that 6.2832 passes for 2*pi.
FULL_TURN = 2 * math.pi + 1e-3  # rad

# https://www.w3.org/TR/xml/#charsets
NOT_XML = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


class Remarkable(NamedTuple):
    """Paths with their values, parents before children, in the order of the tree.

    ``numbers``: bare numbers beyond a full turn, but for efforts and velocities in limits of joints; ``texts``: texts,
    and ``keys``: names, with characters that XML cannot carry; ``stand_ins``: mappings whose source says that they are
    stand-ins.
    """

    numbers: list[tuple[Path, float]]
    texts: list[tuple[Path, str]]
    keys: list[tuple[Path, str]]
    stand_ins: list[tuple[Path, Map]]


def collect(tree: Map) -> Remarkable:
    """Return the remarkable values of a tree."""
    collector = _Collector()
    collector.visit(tree)
    return collector.found


def _is_plain(items: Any) -> bool:
    """Say quickly that a list holds numbers within a turn and nothing else, as most do."""
    return set(map(type, items)) == {float} and -FULL_TURN <= min(items) <= max(items) <= FULL_TURN


def _is_carried(text: str) -> bool:
    """Say whether XML can carry a text."""
    return (text.isascii() and text.isprintable()) or not NOT_XML.search(text)


class _Collector:
    """Walks a tree; a piece that stands in many places and has nothing remarkable is looked at once."""

    def __init__(self) -> None:
        self.found = Remarkable([], [], [], [])
        self.marks = 0
        self.path: list[str | int] = []
        self.plain: set[int] = set()
        self.keys: set[str] = set()  # those that XML can carry

    def visit(self, node: Map | Seq) -> None:
        before = self.marks
        if isinstance(node, Map):
            self._mapping(node)
        pairs: Any = node.items() if isinstance(node, Map) else () if _is_plain(node) else enumerate(node)
        for key, item in pairs:
            kind = type(item)
            if kind is Map or kind is Seq:
                if id(item) not in self.plain:
                    self.path.append(key)
                    self.visit(item)
                    self.path.pop()
            elif kind in NUMERIC:
                if not (-FULL_TURN <= item <= FULL_TURN or self._is_large(key) or has_unit(item)):
                    self.mark(self.found.numbers, (*self.path, key), item)
            elif kind is str and item.isascii() and item.isprintable():
                continue
            elif isinstance(item, str) and not _is_carried(item):
                self.mark(self.found.texts, (*self.path, key), item)
        if self.marks == before:
            self.plain.add(id(node))

    def _is_large(self, key: str | int) -> bool:
        """Say whether a number at a key may well be beyond a full turn: nearly every joint has such limits."""
        return key in ("effort", "velocity") and self.path[:1] == ["joints"] and self.path[2:] == ["limit"]

    def _mapping(self, node: Map) -> None:
        source = node.get("source")
        if isinstance(source, Map) and source.get("status") == "stand_in":
            self.mark(self.found.stand_ins, tuple(self.path), node)
        if self.keys.issuperset(node):
            return
        for key in node:
            if _is_carried(key):
                self.keys.add(key)
            else:
                self.mark(self.found.keys, (*self.path, key), key)

    def mark(self, found: list[tuple[Path, Any]], path: Path, value: Any) -> None:
        found.append((path, value))
        self.marks += 1

"""Trees that an earlier run has read, in the user's cache: reading YAML is most of what a run does before it thinks.

A tree is taken from there where its file holds what it held, to the letter. What is kept is no code: texts, numbers and
places, as ``marshal`` writes them, for this Python and for the modules that say what YAML means here.
"""

from __future__ import annotations

import marshal
import os
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from .. import units
from ..diagnostics import Source, Span
from ..project import stdin_of
from ..startup import TYPE_CHECKING
from ..startup.cache import digest, keep, private_folder, recalled
from ..units import Quantity
from . import load, tree
from .load import mapping_of, read_text
from .tree import Instance, Map, Seq, Text

if TYPE_CHECKING:
    from typing import Any

_MOST = 200_000  # characters of a file; who changes a number of a larger one has it read anew
_MOST_OF_ALL = 2_000_000  # characters of the files of a description
_TEXT, _QUANTITY, _SEQ, _MAP = range(4)  # the kinds of values that have a tuple in their place
_new = tuple.__new__


class CachedTrees:
    """The files that ``path`` is read with: those that a run before has read, and those that this one has."""

    def __init__(self, path: Path) -> None:
        self._file = _file_of(path)
        self._before: dict[str, tuple[str, bytes]] = {}
        self._used: dict[str, tuple[str, bytes]] = {}
        self._room = _MOST_OF_ALL
        data = recalled(self._file) if self._file else None
        with suppress(Exception):  # what is missing or damaged in whatever way says nothing
            kept = marshal.loads(data or b"")  # noqa: S302 - from a folder that is the user's alone
            self._before = {shown: (text, packed) for shown, (text, packed) in kept.items()}

    def mapping(self, path: Path, shown: str, asked: Span | None = None, via: Instance | None = None) -> Map:
        """Read a YAML file whose top is a mapping. Raises LoadError."""
        source = read_text(path, shown, asked)
        text, data = self._before.get(shown, ("", b""))
        if text == source.text:
            with suppress(Exception):
                made = _Unpacking(source, via).mapping(marshal.loads(data))  # noqa: S302 - as above
                self._take(shown, text, data)
                return made
        made = mapping_of(source, path, via)
        if self._file and len(source.text) <= min(_MOST, self._room):
            self._take(shown, source.text, marshal.dumps(_packed(made, {})))
        return made

    def _take(self, shown: str, text: str, data: bytes) -> None:
        self._used[shown] = text, data
        self._room -= len(text)

    def keep(self) -> None:
        """Keep what was read for other runs, if it is not what was there, and forget it here."""
        if self._file and self._used != self._before:
            keep(self._file, marshal.dumps(self._used))
        self._before, self._used = {}, {}


@cache
def load_own(path: Path, shown: str) -> Map:
    """Read a file that ships with the tool, once a process; nobody may change the tree. Raises LoadError."""
    trees = CachedTrees(path)
    made = trees.mapping(path, shown)
    trees.keep()
    return made


def _file_of(path: Path) -> str:
    """Return the file of the cache for what is read with a file; "" if there is none."""
    folder = private_folder("trees") if stdin_of(path) is None else ""
    try:
        name = f"{_meaning()}\n{os.path.abspath(path)}".encode("utf-8", "surrogateescape")
    except OSError:  # modules or folders that are gone
        return ""
    return os.path.join(folder, digest(name)) if folder else ""


@cache
def _meaning() -> str:
    """Return what tells this Python, and the modules that say what YAML means, from others. Raises OSError."""
    files = [Path(str(module.__file__)).stat() for module in (load, tree, units, sys.modules[__name__])]
    return " ".join([sys.version, *(f"{one.st_mtime_ns} {one.st_size}" for one in files)])


def _packed(value: Any, known: dict[int, Any]) -> Any:
    """Return what stands for a value; an alias and its anchor, which are one value, have one in their place."""
    kind = type(value)
    if kind is Text:
        return _TEXT, str(value)
    if kind is Quantity:
        return _QUANTITY, float(value), value.dimension, value.text
    if kind is not Map and kind is not Seq:
        return value
    if id(value) not in known:
        if kind is Map:
            keys, values = value.key_spans, value.value_spans
            inner: Any = {key: _packed(one, known) for key, one in value.items()}
            places = [(*keys[key][1:], *values[key][1:]) for key in value]
        else:
            inner, places = [_packed(one, known) for one in value], [span[1:] for span in value.value_spans]
        known[id(value)] = _MAP if kind is Map else _SEQ, value.span[1:], inner, places
    return known[id(value)]


class _Unpacking:
    """Makes the tree again that tuples stand for, as it is read from a source now."""

    def __init__(self, source: Source, via: Instance | None) -> None:
        self.source = source
        self.via = via
        self.known: dict[int, Any] = {}

    def value(self, packed: tuple[Any, ...]) -> Any:
        """Return what a tuple stands for."""
        kind = packed[0]
        if kind == _TEXT:
            return Text(packed[1])
        if kind == _QUANTITY:
            return Quantity(*packed[1:])
        if id(packed) not in self.known:
            self.known[id(packed)] = self.mapping(packed) if kind == _MAP else self.sequence(packed)
        return self.known[id(packed)]

    def mapping(self, packed: tuple[Any, ...]) -> Map:
        source = self.source
        made = Map(_new(Span, (source, *packed[1])), self.via)
        keys, values = made.key_spans, made.value_spans
        for (key, one), (line, column, length, *place) in zip(packed[2].items(), packed[3], strict=True):
            made[key] = self.value(one) if type(one) is tuple else one
            keys[key] = _new(Span, (source, line, column, length))
            values[key] = _new(Span, (source, *place))
        return made

    def sequence(self, packed: tuple[Any, ...]) -> Seq:
        made = Seq(_new(Span, (self.source, *packed[1])), self.via)
        made.extend([self.value(one) if type(one) is tuple else one for one in packed[2]])
        made.value_spans = [_new(Span, (self.source, *place)) for place in packed[3]]
        return made

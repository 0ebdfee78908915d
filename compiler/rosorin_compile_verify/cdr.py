"""CDR: messages as rosbag2 stores them, many at once.

Messages of one topic mostly have one layout: the same names in the same places, and between them numbers. The layout is
read once, from one message; all others whose remaining bytes are the same are read with it in one go.
(OMG DDS-RTPS 10.5: four bytes say the byte order; each number is aligned to its size, counted from behind them.)
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from .arrays import SECOND, Floats, Times

HEADER = 4
MAX_ITEMS = 10_000
_FLOAT, _TIME = 8, 8


class CdrError(Exception):
    """A message cannot be read; the text says why."""


class Cursor:
    """Reads one message."""

    def __init__(self, raw: bytes) -> None:
        if len(raw) < HEADER or raw[0] or raw[1] not in (0, 1):
            raise CdrError("the message is not in CDR")
        self.raw = raw
        self.order = "<" if raw[1] else ">"
        self.at = HEADER
        self.fixed = [
            (0, 2)
        ]  # what two messages of one layout share: byte order, counts, names; padding may be anything

    def align(self, size: int) -> int:
        """Go on to the next place for a number of ``size`` bytes, and return it."""
        self.at += -(self.at - HEADER) % size
        return self.at

    def take(self, size: int, alignment: int = 1) -> int:
        """Go on behind ``size`` bytes, and return where they begin. Raises CdrError."""
        at = self.align(alignment)
        if at + size > len(self.raw):
            raise CdrError(f"the message ends after {len(self.raw)} bytes, within what it announces")
        self.at = at + size
        return at

    def count(self) -> int:
        """Return a number of items. Raises CdrError."""
        number = self._number()
        if number > MAX_ITEMS:
            raise CdrError(f"{number:,} items in one message")
        return number

    def _number(self) -> int:
        at = self.take(4, 4)
        self.fixed.append((at, 4))
        return int(struct.unpack_from(f"{self.order}I", self.raw, at)[0])

    def text(self) -> str:
        """Return a text. Raises CdrError."""
        return self.bytes().decode("utf-8", "replace")

    def bytes(self) -> bytes:
        """Return a text as bytes, without the zero at its end. Raises CdrError."""
        size = self._number()
        at = self.take(size)
        self.fixed.append((at, size))
        return self.raw[at : at + size].rstrip(b"\0")

    def same(self) -> np.ndarray:
        """Return the places of the bytes that two messages of one layout share."""
        return np.concatenate([np.arange(at, at + size) for at, size in self.fixed])

    def header(self) -> tuple[int, str]:
        """Return the place of the stamp of a std_msgs/Header, and its frame. Raises CdrError."""
        return self.take(_TIME, 4), self.text()


class Layout(NamedTuple):
    """Where the numbers of a message are: ``same`` are the bytes that others must share, the rest are numbers."""

    order: str
    same: np.ndarray
    items: tuple[Any, ...]


class TransformPlace(NamedTuple):
    """One transform of a message: its frames, where its stamp is, where its seven numbers begin."""

    parent: str
    child: str
    stamp: int
    numbers: int


class JointPlace(NamedTuple):
    """A joint state: its names, where its stamp is, where its positions begin, and how many there are."""

    names: tuple[str, ...]
    stamp: int
    numbers: int
    size: int


def transforms(raw: bytes) -> Layout:
    """Return the layout of a tf2_msgs/TFMessage. Raises CdrError."""
    cursor = Cursor(raw)
    items = []
    for _ in range(cursor.count()):
        stamp, parent = cursor.header()
        child = cursor.text()
        numbers = cursor.take(7 * _FLOAT, _FLOAT)
        items.append(TransformPlace(parent, child, stamp, numbers))
    return Layout(cursor.order, cursor.same(), tuple(items))


def joint_state(raw: bytes) -> Layout:
    """Return the layout of a sensor_msgs/JointState. Raises CdrError."""
    cursor = Cursor(raw)
    stamp, _ = cursor.header()
    names = tuple(cursor.text() for _ in range(cursor.count()))
    count = cursor.count()
    numbers = cursor.take(count * _FLOAT, _FLOAT) if count else cursor.at
    return Layout(cursor.order, cursor.same(), (JointPlace(names, stamp, numbers, count),))


class Group(NamedTuple):
    """Messages of one layout: their bytes (n, length), and which of the messages that were given they are (n,)."""

    layout: Layout
    rows: np.ndarray
    places: np.ndarray

    def stamps(self, at: int) -> Times:
        """Return the stamps (n,) in ns that stand at a place."""
        words = np.ascontiguousarray(self.rows[:, at : at + 8]).view(f"{self.layout.order}u4").astype(np.int64)
        return np.asarray(((words[:, 0] + 2**31) % 2**32 - 2**31) * SECOND + words[:, 1], np.int64)

    def doubles(self, at: int, count: int) -> Floats:
        """Return the doubles (n, count) that begin at a place."""
        if not count:
            return np.empty((len(self.rows), 0))
        block = np.ascontiguousarray(self.rows[:, at : at + 8 * count])
        return block.view(f"{self.layout.order}f8").astype(np.float64)


class Reader:
    """Reads messages of one type in groups of one layout; ``of`` gives the layout of a message."""

    def __init__(self, of: Any) -> None:
        self.of = of

    def groups(self, raws: Sequence[bytes], broken: list[str]) -> Iterator[Group]:
        """Yield messages grouped by layout; why a message cannot be read goes into ``broken``."""
        lengths = np.fromiter(map(len, raws), np.int64, len(raws))
        for length in np.unique(lengths):
            places = np.flatnonzero(lengths == length)
            joined = raws if len(places) == len(raws) else [raws[at] for at in places.tolist()]
            rows = np.frombuffer(b"".join(joined), np.uint8).reshape(len(places), int(length))
            yield from self._of_length(rows, places, broken)

    def _of_length(self, rows: np.ndarray, places: np.ndarray, broken: list[str]) -> Iterator[Group]:
        while len(rows):
            try:
                layout = self.of(rows[0].tobytes())
            except CdrError as problem:
                broken.append(str(problem))
                rows, places = rows[1:], places[1:]
                continue
            alike = (rows[:, layout.same] == rows[0, layout.same]).all(axis=1)
            yield Group(layout, rows[alike], places[alike])
            rows, places = rows[~alike], places[~alike]

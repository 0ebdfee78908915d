"""Which triangle each sample of a picture sees: scan conversion in whole numbers, depth by the planes of triangles.

A sample is the middle of a cell of a grid. Corners are rounded to 1/16 of a cell, so that every sample between two
triangles with a common edge belongs to exactly one of them, on every machine. Nearness is affine over the picture
(``a x + b y + c``, the larger the nearer) and rounded to 24 bits: of triangles in one plane the first one is seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Whole = NDArray[np.int64]

_FINE = 16  # parts of a cell
_CHUNK = 1_000_000  # samples of triangles that are looked at together
_LEVELS = 2**24  # of nearness
_NUMBERS = 2**32  # of triangles
MOST_SAMPLES = 2_000_000_000  # of the boxes around all triangles: more take minutes
NOTHING = -1


class TooMuch(Exception):
    """Triangles lie over each other so often that nobody would wait for the picture."""


class Scene(NamedTuple):
    """Triangles on a grid: corners (n, 3) in parts of a cell, nearness by its coefficients (n, 3), and its range."""

    x: Whole
    y: Whole
    near: Floats
    low: float
    high: float


class Layer(NamedTuple):
    """What the samples of a grid (rows, columns) see: ``keys`` hold nearness and number, the larger the nearer."""

    keys: Whole

    @property
    def triangle(self) -> Whole:
        """The number of the triangle that is seen, or NOTHING."""
        return np.where(self.keys < 0, NOTHING, _NUMBERS - 1 - (self.keys & (_NUMBERS - 1)))


def scene(x: Floats, y: Floats, near: Floats, low: float, high: float) -> Scene:
    """Return triangles as they are drawn. ``x`` and ``y`` (n, 3) are in cells; nearness is between low and high.

    A sample (column, row) is at column + 0.5, row + 0.5.
    """
    at = [np.rint(np.clip(values, -1e8, 1e8) * _FINE).astype(np.int64) for values in (x, y)]
    # Of a scene without depth everything is equally near.
    return Scene(at[0], at[1], near, low, high if high > low else low + 1.0)


def turns_left(scene: Scene) -> Whole:
    """Return twice the areas (n,) of triangles in parts of cells; below zero for those that turn the other way."""
    x, y = scene.x, scene.y
    return (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])


def first_seen(scene: Scene, chosen: Whole, columns: int, first: int, end: int) -> Layer:
    """Return what the samples of the rows from ``first`` to ``end`` see of the chosen triangles."""
    keys = np.full((end - first) * columns, NOTHING, np.int64)
    for place, key in _samples(scene, chosen, columns, first, end):
        np.maximum.at(keys, place, key)
    return Layer(keys.reshape(end - first, columns))


def next_seen(scene: Scene, chosen: Whole, before: Layer, behind: Layer, first: int) -> Layer:
    """Return what is seen behind one layer and before another one, of the chosen triangles."""
    rows, columns = before.keys.shape
    keys = np.full(rows * columns, NOTHING, np.int64)
    near, far = before.keys.reshape(-1), behind.keys.reshape(-1)
    for place, key in _samples(scene, chosen, columns, first, first + rows):
        between = (key < near[place]) & (key > far[place])
        np.maximum.at(keys, place[between], key[between])
    return Layer(keys.reshape(rows, columns))


def every(scene: Scene, chosen: Whole, columns: int, rows: int) -> tuple[Whole, Whole, Whole]:
    """Return all samples of the chosen triangles: place, level of nearness and number."""
    found = list(_samples(scene, chosen, columns, 0, rows))
    if not found:
        nothing = np.empty(0, np.int64)
        return nothing, nothing, nothing
    place, key = (np.concatenate(part) for part in zip(*found, strict=True))
    return place, key >> 32, _NUMBERS - 1 - (key & (_NUMBERS - 1))


def _samples(scene: Scene, chosen: Whole, columns: int, first: int, end: int) -> Iterator[tuple[Whole, Whole]]:
    """Yield samples that lie on triangles: their places in the grid, and their keys. Raises TooMuch."""
    for part in _parts(scene, chosen, columns, first, end):
        yield from _samples_of(scene, part, columns, first, end)


def _parts(scene: Scene, chosen: Whole, columns: int, first: int, end: int) -> list[Whole]:
    """Return the chosen triangles in parts that have some million rows each. Raises TooMuch."""
    x, y = scene.x[chosen] // _FINE, scene.y[chosen] // _FINE
    high = np.clip(y.max(axis=1) + 1, first, end) - np.clip(y.min(axis=1), first, end)
    wide = np.clip(x.max(axis=1) + 1, 0, columns) - np.clip(x.min(axis=1), 0, columns)
    if int((high * wide).sum()) > MOST_SAMPLES:
        raise TooMuch(f"{len(chosen):,} triangles lie over each other")
    rows = np.cumsum(high)
    cuts = np.searchsorted(rows, np.arange(_CHUNK, int(rows[-1]) if len(rows) else 0, _CHUNK))
    return np.split(chosen, np.unique(cuts))


def _samples_of(scene: Scene, chosen: Whole, columns: int, first: int, end: int) -> Iterator[tuple[Whole, Whole]]:
    """Yield the samples of some triangles."""
    number, row, left, right = _spans(scene, chosen, columns, first, end)
    length = right - left + 1
    cuts = np.searchsorted(np.cumsum(length), np.arange(_CHUNK, int(length.sum()), _CHUNK)).tolist()
    scale = (_LEVELS - 1) / (scene.high - scene.low)
    a, b, c = (scene.near[:, i] for i in range(3))
    for start, stop in pairwise([0, *cuts, len(length)]):
        part = slice(start, stop)
        many, of = length[part], number[part]
        if not len(many):
            continue
        begin = np.cumsum(many) - many
        step = np.arange(int(many.sum())) - np.repeat(begin, many)
        at = (a[of] * (left[part] + 0.5) + (b[of] * (row[part] + 0.5) + c[of]) - scene.low) * scale
        level = np.repeat(at, many) + np.repeat(a[of] * scale, many) * step
        level = np.clip(np.rint(level), 0, _LEVELS - 1).astype(np.int64)
        place = np.repeat((row[part] - first) * columns + left[part], many) + step
        yield place, (level << 32) | np.repeat(_NUMBERS - 1 - of, many)


def _spans(scene: Scene, chosen: Whole, columns: int, first: int, end: int) -> tuple[Whole, Whole, Whole, Whole]:
    """Return the rows of triangles: number of the triangle, row, first and last column."""
    x, y = scene.x[chosen], scene.y[chosen]
    flipped = turns_left(Scene(x, y, scene.near, 0, 0)) < 0
    x, y = (np.where(flipped[:, None], values[:, ::-1], values) for values in (x, y))
    half = _FINE // 2
    low = np.maximum(-((half - y.min(axis=1)) // _FINE), first)  # the first row whose middle is not above
    high = np.minimum((y.max(axis=1) - half) // _FINE, end - 1)
    many = np.maximum(high - low + 1, 0)
    many[turns_left(Scene(x, y, scene.near, 0, 0)) == 0] = 0
    at = np.repeat(np.arange(len(chosen)), many)
    row = np.arange(len(at)) - np.repeat(np.cumsum(many) - many, many) + low[at]
    left, right = np.zeros(len(at), np.int64), np.full(len(at), columns - 1, np.int64)
    middle = row * _FINE + half
    for i in range(3):
        j = (i + 1) % 3
        across, down = y[:, i] - y[:, j], x[:, j] - x[:, i]  # inside is where across x + down y + more >= 0
        more = -(across * x[:, i] + down * y[:, i])
        more = more - ~((across > 0) | ((across == 0) & (down > 0)))  # an edge belongs to one of its two triangles
        value = down[at] * middle + more[at] + across[at] * half
        slope = across[at] * _FINE
        safe = np.where(slope == 0, 1, slope)
        bound = -(value // safe)  # ceil(-value / slope) for a rising edge
        left = np.where(slope > 0, np.maximum(left, bound), left)
        right = np.where(slope < 0, np.minimum(right, value // -safe), right)
        right = np.where((slope == 0) & (value < 0), -1, right)
    full = left <= right
    return chosen[at[full]], row[full], left[full], right[full]

"""How a surface looks: one sun with soft shadows, a bright sky and a floor, as on the page; all in numpy.

Colours are mixed as light (linear), and shown with the tone curve of the page (Khronos PBR Neutral). What needs a
power is looked up in a table that Python's own floats make, so that the last bit is the same on every machine.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Vector

from .camera import Box, along, cross, unit
from .raster import NOTHING, Whole, first_seen, scene

Floats = NDArray[np.float64]


class Theme(NamedTuple):
    """The colours around a robot, as on the page: sky, its upper end, floor, lines, letters and what is around them.

    ``shade`` is how dark the shadow on the floor is (0 to 1).
    """

    sky: tuple[int, int, int]
    zenith: tuple[int, int, int]
    ground: tuple[int, int, int]
    grid: tuple[int, int, int]
    label: tuple[int, int, int]
    halo: tuple[int, int, int]
    shade: float


THEMES = {
    "light": Theme(
        (0xF3, 0xF5, 0xF8),
        (0xFD, 0xFD, 0xFE),
        (0xE6, 0xEA, 0xEF),
        (0xB9, 0xC2, 0xCD),
        (0x1F, 0x29, 0x33),
        (0xFF, 0xFF, 0xFF),
        0.22,
    ),
    "dark": Theme(
        (0x17, 0x1B, 0x21),
        (0x1D, 0x22, 0x29),
        (0x1F, 0x25, 0x2D),
        (0x3A, 0x44, 0x50),
        (0xE6, 0xEA, 0xF0),
        (0x17, 0x1B, 0x21),
        0.45,
    ),
}

SUN: Vector = unit((0.25, 0.75, 1.0))  # the direction to it
_SUN_COLOUR = (0.70, 0.645, 0.575)  # times what a white surface that faces it sends back
# What the sky and the room send to a white surface, by its normal (x, y, z): fitted to pictures of the page. The terms
# are 1, x, y, z, x^2 - y^2, z^2, xy, xz and yz; a row is a colour.
_AROUND = (
    (0.503, 0.075, -0.194, 0.245, -0.092, 0.065, 0.052, 0.075, -0.167),
    (0.507, 0.072, -0.194, 0.244, -0.092, 0.060, 0.049, 0.073, -0.168),
    (0.513, 0.069, -0.195, 0.243, -0.092, 0.056, 0.045, 0.071, -0.168),
)
SHADOWS = 1024  # cells along the side of the map of shadows
_SOFT = 2.2  # cells: how far around a point shadows are looked for
_LIFT = 1.6  # cells: how far a point is lifted off its surface, so that it does not shade itself
_TABLE = 4096


def _to_linear(value: float) -> float:
    return value / 12.92 if value <= 0.04045 else math.pow((value + 0.055) / 1.055, 2.4)


def _to_screen(value: float) -> float:
    return 12.92 * value if value <= 0.0031308 else 1.055 * math.pow(value, 1 / 2.4) - 0.055


_SCREEN = np.array([_to_screen(math.pow(i / (_TABLE - 1), 2)) for i in range(_TABLE)])


def linear(colour: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a colour of the screen (sRGB, 0 to 1) as light."""
    red, green, blue = map(_to_linear, colour)
    return red, green, blue


def on_screen(light: Floats) -> Floats:
    """Return light as sRGB, 0 to 1."""
    at = np.sqrt(np.clip(light, 0.0, 1.0)) * (_TABLE - 1)  # finer where it is dark
    made: Floats = _SCREEN[np.rint(at).astype(np.int64)]
    return made


def toned(light: Floats) -> Floats:
    """Return light (n, 3) as the page shows it: the tone curve "neutral" of Khronos, which keeps hues."""
    least = light.min(axis=1)
    offset = np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    made = light - offset[:, None]
    peak = made.max(axis=1)
    start = 0.8 - 0.04
    room = 1.0 - start
    squeezed = 1.0 - room * room / (np.maximum(peak, start) + room - start)
    share = 1.0 - 1.0 / (0.15 * (np.maximum(peak, start) - squeezed) + 1.0)
    bright = made * (squeezed / np.maximum(peak, start))[:, None]
    bright = bright + (squeezed[:, None] - bright) * share[:, None]
    shown: Floats = np.where((peak > start)[:, None], bright, made)
    return shown


class Shadows(NamedTuple):
    """What the sun sees: nearness to it on a grid, and how points of the root frame lie on that grid."""

    depth: Floats
    right: Vector
    down: Vector
    corner: tuple[float, float]
    cell: float

    def on_grid(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return column, row and nearness to the sun (m) of points (n, 3)."""
        x, y, z = points[:, 0], points[:, 1], points[:, 2]
        column = (along((x, y, z), self.right) - self.corner[0]) / self.cell
        row = (along((x, y, z), self.down) - self.corner[1]) / self.cell
        return column, row, along((x, y, z), SUN)

    def lit(self, points: Floats, normals: Floats) -> Floats:
        """Return how much of the sun points see (0 to 1)."""
        if not len(self.depth):
            return np.ones(len(points))
        column, row, near = self.on_grid(points + normals * (_LIFT * self.cell))
        seen = np.zeros(len(points))
        for across, below in _AROUND_A_POINT:
            i, j = (np.floor(value).astype(np.int64) + 1 for value in (column + across * _SOFT, row + below * _SOFT))
            i, j = np.clip(i, 0, self.depth.shape[1] - 1), np.clip(j, 0, self.depth.shape[0] - 1)
            seen += self.depth[j, i] <= near + self.cell
        return seen / len(_AROUND_A_POINT)


# Points of a disc, evenly spread over a spiral.
_AROUND_A_POINT = tuple(
    (math.sqrt((i + 0.5) / 24) * math.cos(2.399963 * i), math.sqrt((i + 0.5) / 24) * math.sin(2.399963 * i))
    for i in range(24)
)


def shadows(triangles: Floats, box: Box) -> Shadows:
    """Return what the sun sees of triangles (n, 3, 3)."""
    right = unit(cross((0.0, 0.0, 1.0), SUN))
    down = cross(SUN, right)
    if not len(triangles):
        return Shadows(np.empty((0, 0)), right, down, (0.0, 0.0), 1.0)
    x, y, z = (triangles[..., i] for i in range(3))
    across, below, near = along((x, y, z), right), along((x, y, z), down), along((x, y, z), SUN)
    corner = (float(across.min()), float(below.min()))
    cell = max(float(across.max()) - corner[0], float(below.max()) - corner[1], 1e-6 * box.diagonal) / SHADOWS or 1.0
    columns, rows = (across - corner[0]) / cell, (below - corner[1]) / cell
    planes, low, high = _planes(columns, rows, near), float(near.min()), float(near.max())
    size = SHADOWS + 1
    seen = first_seen(scene(columns, rows, planes, low, high), np.arange(len(triangles)), size, 0, size)
    depth = np.where(seen.keys < 0, -np.inf, low + (seen.keys >> 32) * ((high - low) / (2**24 - 1)))
    return Shadows(np.pad(depth, 1, constant_values=-np.inf), right, down, corner, cell)


def _planes(x: Floats, y: Floats, near: Floats) -> Floats:
    """Return the coefficients (n, 3) of what is affine over triangles whose corners are at x, y (n, 3)."""
    ax, ay, an = (v[:, 1] - v[:, 0] for v in (x, y, near))
    bx, by, bn = (v[:, 2] - v[:, 0] for v in (x, y, near))
    area = ax * by - bx * ay
    safe = np.where(area == 0, 1.0, area)
    a, b = (an * by - bn * ay) / safe, (ax * bn - bx * an) / safe
    return np.stack([a, b, near[:, 0] - a * x[:, 0] - b * y[:, 0]], axis=-1)


class FloorShadow(NamedTuple):
    """How dark the floor is (0 to 1) on a grid in the root frame."""

    dark: Floats
    corner: tuple[float, float]
    cell: float

    def at(self, x: Floats, y: Floats) -> Floats:
        """Return how dark points of the floor are, between the cells by both of their neighbours."""
        column, row = (x - self.corner[0]) / self.cell - 0.5, (y - self.corner[1]) / self.cell - 0.5
        rows, columns = self.dark.shape
        inside = (column >= 0) & (row >= 0) & (column < columns - 1) & (row < rows - 1)
        dark = np.zeros(x.shape)
        column, row = column[inside], row[inside]
        i, j = column.astype(np.int64), row.astype(np.int64)
        u, v = column - i, row - j
        low = self.dark[j, i] * (1 - u) + self.dark[j, i + 1] * u
        high = self.dark[j + 1, i] * (1 - u) + self.dark[j + 1, i + 1] * u
        dark[inside] = low * (1 - v) + high * v
        return dark


def floor_shadow(triangles: Floats, ground: float, box: Box) -> FloorShadow:
    """Return the shadow of triangles on a floor at the height ``ground`` (m), with soft edges."""
    if not len(triangles):
        return FloorShadow(np.zeros((2, 2)), (0.0, 0.0), 1.0)
    fall = (triangles[..., 2] - ground) / SUN[2]
    x, y = triangles[..., 0] - fall * SUN[0], triangles[..., 1] - fall * SUN[1]
    soft = 0.008 * max(box.diagonal, 1e-9)
    margin = 6 * soft
    corner = (float(x.min()) - margin, float(y.min()) - margin)
    wide = max(float(x.max()) - corner[0], float(y.max()) - corner[1]) + margin
    cell = max(wide / 700, soft / 4)
    size = math.ceil(wide / cell)
    flat = np.zeros((len(triangles), 3))
    shape = scene((x - corner[0]) / cell, (y - corner[1]) / cell, flat, 0.0, 1.0)
    mask: Whole = first_seen(shape, np.arange(len(triangles)), size, 0, size).triangle
    dark = (mask != NOTHING).astype(np.float64)
    reach = max(1, round(soft / cell))
    for _ in range(3):  # three box filters are nearly a Gaussian one
        dark = _blurred(_blurred(dark, reach).T, reach).T
    return FloorShadow(dark, corner, cell)


def _blurred(values: Floats, reach: int) -> Floats:
    """Return the means of each value and ``reach`` of its neighbours on both sides along the rows."""
    wide = 2 * reach + 1
    padded = np.pad(values, ((0, 0), (reach + 1, reach)))
    sums = np.cumsum(padded, axis=1)
    made: Floats = (sums[:, wide:] - sums[:, :-wide]) / wide
    return made


def shaded(colours: Floats, normals: Floats, lit: Floats) -> Floats:
    """Return the light (n, 3) that surfaces send back; ``colours`` (n, 3) are light, ``lit`` is their share of sun."""
    x, y, z = normals[:, 0], normals[:, 1], normals[:, 2]
    facing = np.maximum(along((x, y, z), SUN), 0.0) * lit
    terms = (np.ones(len(x)), x, y, z, x * x - y * y, z * z, x * y, x * z, y * z)
    made = np.empty_like(colours)
    for i in range(3):
        around = sum(share * term for share, term in zip(_AROUND[i], terms, strict=True))
        made[:, i] = colours[:, i] * (np.maximum(around, 0.05) + _SUN_COLOUR[i] * facing)
    return made

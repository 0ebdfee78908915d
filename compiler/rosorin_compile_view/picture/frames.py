"""Frames in a picture: three axes each, and a name beside it, at a place of its own where there is one.

In a PNG letters are strokes, so that no font of the system is needed: the common letters of five by seven dots, whose
dots that touch are joined by lines.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Transform

from .camera import Camera
from .light import Theme

Floats = NDArray[np.float64]
Point = tuple[float, float]

AXES = ((0xE5, 0x48, 0x4D), (0x30, 0xA4, 0x6C), (0x3E, 0x63, 0xDD))  # x, y, z, as on the page
LONG = 0.07  # of an axis, times the diagonal of the robot
_LINE = 2.0  # pixels
_PEN, _HALO = 1.25, 4.2  # pixels: of a letter, and of the light around it
_LETTER = 1.45  # pixels: a dot of a letter of five by seven
HIGH = 11.0  # pixels: a line of text
_GAP = 4.0

WIDE = 6  # columns of a letter with the gap behind it
_HIGH = 7
# The letters from space to ~, five columns each, two hexadecimal digits a column; the lowest bit is the top dot.
_DOTS = (
    "0000000000 00005F0000 0007000700 147F147F14 242A7F2A12 2313086462 3649562050 0008070300"
    "001C224100 0041221C00 2A1C7F1C2A 08083E0808 0080703000 0808080808 0000606000 2010080402"
    "3E5149453E 00427F4000 7249494946 2141494D33 1814127F10 2745454539 3C4A494931 4121110907"
    "3649494936 464949291E 0000140000 0040340000 0008142241 1414141414 0041221408 0201590906"
    "3E415D594E 7C1211127C 7F49494936 3E41414122 7F4141413E 7F49494941 7F09090901 3E41415173"
    "7F0808087F 00417F4100 2040413F01 7F08142241 7F40404040 7F021C027F 7F0408107F 3E4141413E"
    "7F09090906 3E4151215E 7F09192946 2649494932 03017F0103 3F4040403F 1F2040201F 3F4038403F"
    "6314081463 0304780403 6159494D43 007F414141 0204081020 004141417F 0402010204 4040404040"
    "0003070800 2054547840 7F28444438 3844444428 384444287F 3854545418 00087E0902 18A4A49C78"
    "7F08040478 00447D4000 2040403D00 7F10284400 00417F4000 7C04780478 7C08040478 3844444438"
    "FC18242418 18242418FC 7C08040408 4854545424 04043F4424 3C4040207C 1C2040201C 3C4030403C"
    "4428102844 4C9090907C 4464544C44 0008364100 0000770000 0041360800 0201020402"
)
_TABLE = bytes.fromhex(_DOTS.replace(" ", ""))
_UNKNOWN = bytes.fromhex("7F4141417F")


class Axis(NamedTuple):
    """One axis of a frame: its ends in pixels and its colour."""

    start: Point
    end: Point
    colour: tuple[int, int, int]


class Name(NamedTuple):
    """The name of a frame: the left end and the middle of its line, in pixels."""

    x: float
    y: float
    text: str

    @property
    def width(self) -> float:
        """How long it is (pixels)."""
        return len(self.text) * WIDE * _LETTER


def drawn(places: Mapping[str, Transform], camera: Camera, size: float) -> tuple[list[Axis], list[Name]]:
    """Return the axes and the names of frames by their places; ``size`` is that of the robot (m)."""
    axes: list[Axis] = []
    wanted: list[tuple[float, float, str]] = []
    for name, place in places.items():
        long = LONG * size
        ends = [place.apply(end) for end in ((0.0, 0.0, 0.0), (long, 0.0, 0.0), (0.0, long, 0.0), (0.0, 0.0, long))]
        x, y, depth = camera.seen(np.array(ends))
        if (depth <= 0).any():
            continue
        at = [(round(float(a), 2), round(float(b), 2)) for a, b in zip(x, y, strict=True)]
        axes += [Axis(at[0], end, colour) for end, colour in zip(at[1:], AXES, strict=True)]
        wanted.append((*at[0], name))
    return axes, list(_placed(wanted, camera))


def _placed(wanted: Sequence[tuple[float, float, str]], camera: Camera) -> Iterator[Name]:
    """Yield names beside their frames, where no other name is; frames at one place have theirs below each other."""
    taken: list[Name] = []
    for x, y, text in wanted:
        name = _free(x, y, text, taken, camera)
        taken.append(name)
        yield name


def _free(x: float, y: float, text: str, taken: Sequence[Name], camera: Camera) -> Name:
    wide = Name(0, 0, text).width
    for step in range(60):
        away = (step // 2 + step % 2) * (1 if step % 2 else -1) * HIGH / 2
        for left in (x - 4 - wide, x + 4):  # axes mostly go up and to the right
            name = Name(round(left, 2), round(y + 3 + away, 2), text)
            inside = left >= 0 and left + wide <= camera.width and HIGH / 2 <= name.y <= camera.height - HIGH / 2
            if inside and not any(_overlap(name, other) for other in taken):
                return name
    return Name(round(min(max(x + 4, 0.0), max(camera.width - wide, 0.0)), 2), y, text)


def _overlap(one: Name, other: Name) -> bool:
    apart = one.x + one.width + _GAP < other.x or other.x + other.width + _GAP < one.x
    return not apart and abs(one.y - other.y) < HIGH


def paint(pixels: NDArray[np.uint8], axes: Sequence[Axis], names: Sequence[Name], theme: Theme) -> None:
    """Draw frames over a picture, which is changed."""
    for start, end, colour in axes:
        _line(pixels, start, end, _LINE, colour)
    for colour, pen in ((theme.halo, _HALO), (theme.label, _PEN)):
        for name in names:
            for a, b in strokes(name.text):
                ends = [(name.x + p * _LETTER, name.y + (q - 3.0) * _LETTER) for p, q in (a, b)]
                _line(pixels, ends[0], ends[1], pen, colour, 0.8 if pen == _HALO else 1.0)


def _line(
    pixels: NDArray[np.uint8],
    start: Point,
    end: Point,
    pen: float,
    colour: tuple[int, int, int],
    strength: float = 1.0,
) -> None:
    """Draw a line with round ends, its edges softened over a pixel."""
    rows, columns = pixels.shape[:2]
    (ax, ay), (bx, by) = start, end
    x0, x1 = (int(min(max(v, 0), columns)) for v in (min(ax, bx) - pen, max(ax, bx) + pen + 2))
    y0, y1 = (int(min(max(v, 0), rows)) for v in (min(ay, by) - pen, max(ay, by) + pen + 2))
    if x0 >= x1 or y0 >= y1:
        return
    y, x = np.mgrid[y0:y1, x0:x1] + 0.5
    dx, dy = bx - ax, by - ay
    length = dx * dx + dy * dy
    t = np.clip(((x - ax) * dx + (y - ay) * dy) / (length or 1.0), 0.0, 1.0)
    off = np.sqrt((x - ax - t * dx) ** 2 + (y - ay - t * dy) ** 2)
    share = strength * np.clip(pen / 2 + 0.5 - off, 0.0, 1.0)
    part = pixels[y0:y1, x0:x1]
    below = part[..., 3] / 255.0 if part.shape[2] == 4 else np.ones(part.shape[:2])
    alpha = share + below * (1.0 - share)
    for i in range(3):
        mixed = colour[i] * share + part[..., i] * below * (1.0 - share)
        part[..., i] = np.rint(mixed / np.where(alpha == 0, 1.0, alpha)).astype(np.uint8)
    if part.shape[2] == 4:
        part[..., 3] = np.rint(alpha * 255.0).astype(np.uint8)


def strokes(text: str) -> Iterator[tuple[Point, Point]]:
    """Yield the lines of a text: their ends in dots from its upper left; what is not ASCII is a box."""
    for index, letter in enumerate(text):
        for (a, b), (c, d) in _letter(letter):
            yield (index * WIDE + a, b), (index * WIDE + c, d)


@cache
def _letter(letter: str) -> tuple[tuple[Point, Point], ...]:
    start = 5 * (ord(letter) - ord(" "))
    columns = _TABLE[start : start + 5] if " " <= letter <= "~" else _UNKNOWN
    dots = {(x, y) for x in range(5) for y in range(_HIGH + 1) if columns[x] >> y & 1}
    found: list[tuple[Point, Point]] = []
    joined: set[Point] = set()
    for x, y in sorted(dots):
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            crossed = dx and dy and ((x + dx, y) in dots or (x, y + dy) in dots)
            if (x + dx, y + dy) in dots and not crossed:
                found.append(((x, y), (x + dx, y + dy)))
                joined |= {(x, y), (x + dx, y + dy)}
    return (*found, *(((x, y), (x, y)) for x, y in sorted(dots - joined)))

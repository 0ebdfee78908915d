"""Frames in a picture: three axes each, and a name beside it, at a place of its own where there is one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...model import Transform
from .camera import Camera
from .letters import WIDE, strokes

Floats = NDArray[np.float64]

AXES = ((0xE5, 0x48, 0x4D), (0x30, 0xA4, 0x6C), (0x3E, 0x63, 0xDD))  # x, y, z, as on the page
LABEL = (0x1F, 0x29, 0x33)
LONG = 0.07  # of an axis, times the diagonal of the robot
_LINE = 2.0  # pixels
_PEN, _HALO = 1.25, 4.2  # pixels: of a letter, and of the light around it
_LETTER = 1.45  # pixels: a dot of a letter of five by seven
HIGH = 11.0  # pixels: a line of text
_GAP = 4.0


class Axis(NamedTuple):
    """One axis of a frame: its ends in pixels and its colour."""

    start: tuple[float, float]
    end: tuple[float, float]
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


def drawn(
    places: Mapping[str, Transform], names: Sequence[str], camera: Camera, size: float
) -> tuple[list[Axis], list[Name]]:
    """Return the axes and the names of frames; ``size`` is the diagonal of the robot (m)."""
    axes: list[Axis] = []
    wanted: list[tuple[float, float, str]] = []
    for name in names:
        place = places[name]
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
        for left in (x + 5, x - 5 - wide):
            name = Name(round(left, 2), round(y + away, 2), text)
            inside = left >= 0 and left + wide <= camera.width and HIGH / 2 <= name.y <= camera.height - HIGH / 2
            if inside and not any(_overlap(name, other) for other in taken):
                return name
    return Name(round(min(max(x + 5, 0.0), max(camera.width - wide, 0.0)), 2), y, text)


def _overlap(one: Name, other: Name) -> bool:
    apart = one.x + one.width + _GAP < other.x or other.x + other.width + _GAP < one.x
    return not apart and abs(one.y - other.y) < HIGH


def paint(pixels: NDArray[np.uint8], axes: Sequence[Axis], names: Sequence[Name]) -> None:
    """Draw frames over a picture, which is changed."""
    for start, end, colour in axes:
        _line(pixels, start, end, _LINE, colour)
    for colour, pen in (((0xFF, 0xFF, 0xFF), _HALO), (LABEL, _PEN)):
        for name in names:
            for a, b in strokes(name.text):
                ends = [(name.x + p * _LETTER, name.y + (q - 3.0) * _LETTER) for p, q in (a, b)]
                _line(pixels, ends[0], ends[1], pen, colour, 0.8 if pen == _HALO else 1.0)


def _line(
    pixels: NDArray[np.uint8],
    start: tuple[float, float],
    end: tuple[float, float],
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

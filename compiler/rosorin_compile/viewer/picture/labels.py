"""Frames drawn over a picture: three axes each, and the name beside them where there is room.

Letters are strokes between the dots of a 5 x 7 matrix, so that no font of the system is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Transform, Vector

from .render import Camera, Theme

Pixels = NDArray[np.uint8]
Point = tuple[float, float]
Label = tuple[float, float, str]

AXIS_COLOURS = [[*bytes.fromhex(colour)] for colour in ("e5484d", "30a46c", "3e63dd")]  # as on the page
SENSOR, EMPTY = (bytes.fromhex("8e4ec6"), 11.0), (bytes.fromhex("7d8a97"), 8.0)  # markers: colour, pixels
_AXIS_LENGTH = 0.07  # times the size of the robot
_AXIS_PEN, _LETTER_PEN, _HALO_PEN = 2.0, 1.25, 4.2  # pixels
_DOT = 1.45  # pixels between the dots of a letter
_ADVANCE = 6  # dots from a letter to the next
_LINE_HEIGHT = 11.0  # pixels
_GAP = 4.0  # pixels between names

# The characters from space to ~: five columns each, two hexadecimal digits a column; the lowest bit is the top dot.
_DOTS = bytes.fromhex(
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
_BOX = bytes.fromhex("7F4141417F")  # any other character


def draw_frames(pixels: Pixels, frames: Mapping[str, Transform], camera: Camera, size: float, theme: Theme) -> None:
    """Draw the axes and names of frames, by their poses in the root frame, over a picture (rows, columns, 3 or 4).

    The length of an axis follows from the ``size`` of the robot (m). Frames behind the camera are left out.
    """
    origins: list[Label] = []
    axes = np.eye(4, 3, -1) * _AXIS_LENGTH * size
    for name, pose in frames.items():
        x, y, depth = camera.project(np.array([pose.apply(tuple(end)) for end in axes.tolist()]))
        if (depth > 0).all():
            origin, *tips = zip(x.round(2).tolist(), y.round(2).tolist(), strict=True)
            origins.append((*origin, name))
            for tip, axis_colour in zip(tips, AXIS_COLOURS, strict=True):
                _draw_line(pixels, origin, tip, _AXIS_PEN, axis_colour, 1.0)
    labels = _placed(origins, camera.width, camera.height)
    for colour, pen, opacity in ((theme.halo, _HALO_PEN, 0.8), (theme.label, _LETTER_PEN, 1.0)):
        for start, middle, text in labels:
            for index, letter in enumerate(text):
                left, top = start + index * _ADVANCE * _DOT, middle - 3 * _DOT
                for (a, b), (c, d) in _strokes(letter):
                    ends_of_stroke = (left + a * _DOT, top + b * _DOT), (left + c * _DOT, top + d * _DOT)
                    _draw_line(pixels, *ends_of_stroke, pen, colour, opacity)


def draw_markers(pixels: Pixels, points: Sequence[Vector], camera: Camera, marker: tuple[bytes, float]) -> None:
    """Draw a round marker at each point (m, in the root frame) before the camera."""
    for point in points:
        x, y, depth = (round(float(value), 2) for value in camera.project(np.array(point)))
        if depth > 0:
            _draw_line(pixels, (x, y), (x, y), marker[1], marker[0], 1.0)


def _placed(origins: Sequence[Label], width: int, height: int) -> list[Label]:
    """Return where the name of each frame is: close to its origin, and where no other name is.

    A name is given by the left end and the vertical middle of its text (pixels).
    """
    labels, reach = list[Label](), (height - _LINE_HEIGHT) / 2
    for x, y, text in origins:
        wide = _width(text)
        steps = ((step + 1) // 2 * (_LINE_HEIGHT / 2 if step % 2 else -_LINE_HEIGHT / 2) for step in range(60))
        # to the left first: most axes point up or to the right
        places = [(left, y + 3 + step, text) for step in steps for left in (x - _GAP - wide, x + _GAP)]
        inside = [one for one in places if 0 <= one[0] <= width - wide and abs(one[1] - height / 2) <= reach]
        free = (one for one in inside if not any(_overlap(one, other) for other in labels))
        labels.append(next(free, (min(max(x + _GAP, 0.0), max(width - wide, 0.0)), y, text)))
    return labels


def _width(text: str) -> float:
    return len(text) * _ADVANCE * _DOT


def _overlap(one: Label, other: Label) -> bool:
    apart = one[0] + _width(one[2]) + _GAP < other[0] or other[0] + _width(other[2]) + _GAP < one[0]
    return not apart and abs(one[1] - other[1]) < _LINE_HEIGHT


def _draw_line(pixels: Pixels, start: Point, end: Point, pen: float, colour: Sequence[int], opacity: float) -> None:
    """Draw an antialiased line with round ends; ``pen`` is its width in pixels."""
    rows, columns = pixels.shape[:2]
    (ax, ay), (bx, by) = start, end
    x0, x1 = (int(min(max(v, 0), columns)) for v in (min(ax, bx) - pen, max(ax, bx) + pen + 2))
    y0, y1 = (int(min(max(v, 0), rows)) for v in (min(ay, by) - pen, max(ay, by) + pen + 2))
    if x0 >= x1 or y0 >= y1:
        return
    y, x = np.mgrid[y0:y1, x0:x1] + 0.5
    dx, dy = bx - ax, by - ay
    t = np.clip(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy or 1.0), 0.0, 1.0)
    distance = np.sqrt((x - ax - t * dx) ** 2 + (y - ay - t * dy) ** 2)
    share = opacity * np.clip(pen / 2 + 0.5 - distance, 0.0, 1.0)[..., None]
    area = pixels[y0:y1, x0:x1]
    below = (area[..., 3:] / 255.0 if area.shape[2] == 4 else 1.0) * (1.0 - share)
    alpha = share + below
    area[..., :3] = np.rint((np.array(list(colour)) * share + area[..., :3] * below) / np.where(alpha == 0, 1.0, alpha))
    area[..., 3:] = np.rint(alpha * 255.0)


@cache
def _strokes(letter: str) -> tuple[tuple[Point, Point], ...]:
    """Return the lines of a letter in dots: adjacent dots are joined, others are points."""
    start = 5 * (ord(letter) - ord(" "))
    columns = _DOTS[start : start + 5] if " " <= letter <= "~" else _BOX
    dots = [(x, y) for x in range(5) for y in range(8) if columns[x] >> y & 1]
    found: list[tuple[Point, Point]] = [(point, point) for point in dots]
    for (x, y), (dx, dy) in product(dots, ((1, 0), (0, 1), (1, 1), (1, -1))):
        crossed = dx and dy and ((x + dx, y) in dots or (x, y + dy) in dots)
        if (x + dx, y + dy) in dots and not crossed:
            found.append(((x, y), (x + dx, y + dy)))
    joined = {point for start, end in found for point in (start, end) if start != end}
    return tuple(line for line in found if line[0] != line[1] or line[0] not in joined)

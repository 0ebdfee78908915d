"""Pictures of robots: reading a PNG, and judging what a picture shows by rays through exact shapes."""

import colorsys
import math
import struct
import zlib
from collections.abc import Mapping, Sequence

import numpy as np

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Robot, Sphere, Transform

# Links are told apart by their hue, whatever light falls on them.
HUES = {"red": 0.0, "yellow": 1 / 6, "green": 1 / 3, "cyan": 0.5, "blue": 2 / 3, "magenta": 5 / 6}


def rgba(name: str) -> list[float]:
    return [*colorsys.hsv_to_rgb(HUES[name], 0.75, 0.8), 1.0]


def hue_name(colour: Sequence[int]) -> str:
    """Return which of the colours a pixel has; "" for a grey one."""
    hue, saturation, _ = colorsys.rgb_to_hsv(*(int(value) / 255 for value in colour[:3]))
    if saturation < 0.3:
        return ""
    return min(HUES, key=lambda name: abs((hue - HUES[name] + 0.5) % 1 - 0.5))


def pixels(data: bytes) -> np.ndarray:
    """Return the pixels of a PNG that this tool wrote: 8 bits a channel, rows without a filter (ISO/IEC 15948)."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    parts, at = [], 8
    while at < len(data):
        (size,) = struct.unpack(">I", data[at : at + 4])
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + content)
        parts.append((kind, content))
        at += 12 + size
    width, height, depth, colour, *rest = struct.unpack(">IIBBBBB", parts[0][1])
    assert (parts[0][0], depth, rest, parts[-1]) == (b"IHDR", 8, [0, 0, 0], (b"IEND", b""))
    raw = zlib.decompress(b"".join(content for kind, content in parts if kind == b"IDAT"))
    channels = {2: 3, 6: 4}[colour]
    rows = np.frombuffer(raw, np.uint8).reshape(height, 1 + width * channels)
    assert not rows[:, 0].any()
    return rows[:, 1:].reshape(height, width, channels)


# Rays: where one meets an exact shape first, by textbook formulas.


def first_hit(
    robot: Robot, places: Mapping[str, Transform], eye: Sequence[float], way: Sequence[float]
) -> tuple[str, float]:
    """Return the link that a ray from outside meets first and how far away that is; "" and infinity for none."""
    found = ("", math.inf)
    for link in robot.links:
        for shape in link.visual or link.collision:
            at = places[link.name].then(shape.origin().transform())
            back = at.inverse()
            far = _hit(shape.geometry, np.array(back.apply(tuple(eye))), np.array(back.rotate(tuple(way))))
            if far < found[1]:
                found = (link.name, far)
    return found


def _hit(geometry: object, eye: np.ndarray, way: np.ndarray) -> float:
    if isinstance(geometry, Box):
        half = np.array(geometry.size) / 2
        return _slabs(-half, half, eye, way)
    if isinstance(geometry, Sphere):
        return _ball(np.zeros(3), geometry.radius, eye, way)
    if isinstance(geometry, HeightMap):
        x, y = geometry.origin
        cells = [(i, j, h) for i, row in enumerate(geometry.heights) for j, h in enumerate(row) if h > 0]
        corners = [((x + i * geometry.cell, y + j * geometry.cell, 0), h) for i, j, h in cells]
        tops = [(np.array(low), np.array([low[0] + geometry.cell, low[1] + geometry.cell, h])) for low, h in corners]
        return min((_slabs(low, high, eye, way) for low, high in tops), default=math.inf)
    assert isinstance(geometry, Cylinder | Capsule)
    side = _tube(geometry.radius, geometry.length, eye, way, isinstance(geometry, Cylinder))
    if isinstance(geometry, Cylinder):
        return side
    ends = [np.array([0, 0, sign * geometry.length / 2]) for sign in (1, -1)]
    return min(side, *(_ball(end, geometry.radius, eye, way) for end in ends))


def _slabs(low: np.ndarray, high: np.ndarray, eye: np.ndarray, way: np.ndarray) -> float:
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - eye) / way, (high - eye) / way
    near, far = np.nanmax(np.minimum(a, b)), np.nanmin(np.maximum(a, b))
    return float(near) if near <= far else math.inf


def _ball(centre: np.ndarray, radius: float, eye: np.ndarray, way: np.ndarray) -> float:
    off = eye - centre
    a, b, c = way @ way, off @ way, off @ off - radius**2
    inside = b * b - a * c
    return float((-b - math.sqrt(inside)) / a) if inside >= 0 else math.inf


def _tube(radius: float, length: float, eye: np.ndarray, way: np.ndarray, closed: bool) -> float:
    found = [math.inf]
    a, b, c = way[:2] @ way[:2], eye[:2] @ way[:2], eye[:2] @ eye[:2] - radius**2
    if a > 0 and b * b - a * c >= 0:
        far = (-b - math.sqrt(b * b - a * c)) / a
        if abs(eye[2] + far * way[2]) <= length / 2:
            found.append(far)
    if closed and way[2]:
        for height in (length / 2, -length / 2):
            far = (height - eye[2]) / way[2]
            at = eye[:2] + far * way[:2]
            if at @ at <= radius**2:
                found.append(far)
    return float(min(found))

"""A z-buffer renderer: one sun with soft shadows, a bright sky, and a floor with a grid, as on the page.

A pixel has nine samples, each of which is shaded. Projected corners are rounded to 1/16 of the distance between
samples and compared as integers, so that exactly one of two adjacent triangles covers a sample, on every machine.
Depth is rounded to 24 bits; of triangles in one plane the first one is visible. Colours are mixed as linear light and
displayed with the tone curve of the page (Khronos PBR Neutral). Of translucent triangles the nearest one is drawn.
Scalar products do without BLAS, whose last digit depends on the CPU.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .triangles import Floats, Piece

Ints = NDArray[np.int64]

FIELD_OF_VIEW = math.radians(28.0)  # vertical, as on the page (``viewer/src/stage.js``)
MARGIN = 1.06  # times the distance at which the sphere around the robot fills the picture
_SMALLEST_RADIUS = 0.02  # m

_FINE = 3  # samples along the side of a pixel
_BAND = 400_000  # samples that are drawn at once
_CHUNK = 1_000_000  # samples of triangles that are compared at once
_STEPS = 16  # of rounded coordinates between two samples
_DEPTHS = 2**24 - 1
_LAST = 2**32 - 1  # the lower half of a key is this minus the number of the triangle

_SUN = np.array((0.25, 0.75, 1.0)) / math.sqrt(1.625)  # the direction to it
_SUN_COLOUR = np.array((0.70, 0.645, 0.575))  # reflected by a white surface that faces the sun
# Light of the sky that a white surface with the normal (x, y, z) reflects: red, green and blue for each of the terms
# 1, x, y, z, x^2 - y^2, z^2, xy, xz and yz. Fitted to pictures of the page.
_SKY = np.array(
    [
        (0.503, 0.075, -0.194, 0.245, -0.092, 0.065, 0.052, 0.075, -0.167),
        (0.507, 0.072, -0.194, 0.244, -0.092, 0.060, 0.049, 0.073, -0.168),
        (0.513, 0.069, -0.195, 0.243, -0.092, 0.056, 0.045, 0.071, -0.168),
    ]
)
_EDGE = 0.62  # the share of light that is left along the edges of boxes
_FLOOR_RADIUS = 6.0  # times the diagonal of the robot

_MAP_CELLS = 1024  # along the longer side of the shadow map
_PENUMBRA = 2.2  # cells: the radius within which a point looks for shadows
_OFFSET = 1.6  # cells: the height of that point above its surface, so that a surface does not shade itself
_BLUR, _BLURS = 10, 3  # cells and passes of the box filter for the shadow on the floor
_BORDER = _BLUR * _BLURS
_TAPS = 4  # lookups of a sample in the shadow map; those of the samples of a pixel differ
_DISC = [(math.sqrt((i + 0.5) / 36), 2.399963 * i) for i in range(_FINE**2 * _TAPS)]  # evenly spread: radius, angle
_DISC_POINTS = np.array([(radius * math.cos(angle), radius * math.sin(angle)) for radius, angle in _DISC])


class Theme(NamedTuple):
    """The colours around a robot, as on the page; ``shadow`` is the opacity of the shadow on the floor."""

    shadow: float
    horizon: bytes
    zenith: bytes
    floor: bytes
    grid: bytes
    label: bytes
    halo: bytes


THEMES = {
    "light": Theme(0.22, *map(bytes.fromhex, ("f3f5f8", "fdfdfe", "e6eaef", "b9c2cd", "1f2933", "ffffff"))),
    "dark": Theme(0.45, *map(bytes.fromhex, ("171b21", "1d2229", "1f252d", "3a4450", "e6eaf0", "171b21"))),
}

# Python's own powers in a table, because those of numpy differ between machines in the last digit.
_TABLE = 4096
_SCREEN = [(i / (_TABLE - 1)) ** 2 for i in range(_TABLE)]  # steps are smaller where it is dark
_SCREEN_TABLE = np.array([12.92 * v if v <= 0.0031308 else 1.055 * v ** (1 / 2.4) - 0.055 for v in _SCREEN])


def _dot(vectors: Floats, axis: Floats) -> Floats:
    product: Floats = (vectors * axis).sum(axis=-1)
    return product


class Camera(NamedTuple):
    """A pinhole camera: its position (m), its axes in the root frame, and the size of its picture in pixels.

    ``focal`` is the length in pixels of an object of 1 m at a distance of 1 m. Pixel (0, 0) is at the top left.
    """

    eye: Floats
    right: Floats
    down: Floats
    forward: Floats
    focal: float
    width: int
    height: int

    @staticmethod
    def fit(bounds: Floats, direction: ArrayLike, width: int, height: int) -> Camera:
        """Return the camera in a direction from a box (2, 3), so that its picture contains the box, as on the page."""
        radius = max(math.dist(*bounds) / 2, _SMALLEST_RADIUS)
        distance = MARGIN * radius / math.sin(FIELD_OF_VIEW / 2) / min(1.0, width / height)
        back = np.array(direction) / math.hypot(*np.array(direction))
        right = np.cross((0.0, 0.0, 1.0) if math.hypot(*back[:2]) > 1e-9 else (1.0, 0.0, 0.0), back)
        right /= math.hypot(*right)
        focal = height / 2 / math.tan(FIELD_OF_VIEW / 2)
        return Camera(bounds.mean(axis=0) + back * distance, right, np.cross(right, back), -back, focal, width, height)

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return x and y (pixels) of points (..., 3) in the picture, and their depth (m) along the optical axis."""
        offset = points - self.eye
        depth = _dot(offset, self.forward)
        x, y = (_dot(offset, axis) / depth * self.focal for axis in (self.right, self.down))
        return x + self.width / 2, y + self.height / 2, depth

    def rays(self, x: Floats, y: Floats) -> Floats:
        """Return the directions (..., 3) of pixels; their length along ``forward`` is 1."""
        across, below = (x - self.width / 2) / self.focal, (y - self.height / 2) / self.focal
        return self.forward + across[..., None] * self.right + below[..., None] * self.down


def _displayed(light: Floats) -> Floats:
    """Return light (n, 3) as sRGB from 0 to 1. Source: Khronos PBR Neutral Tone Mapper."""
    least = light.min(axis=1, keepdims=True)
    light = light - np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = light.max(axis=1, keepdims=True)
    compressed = 1.0 - 0.24 * 0.24 / (np.maximum(peak, 0.76) - 0.52)
    desaturated = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0)
    bright = light * (compressed / np.maximum(peak, 0.76)) * (1.0 - desaturated) + compressed * desaturated
    light = np.clip(np.where(peak > 0.76, bright, light), 0.0, 1.0)
    shown: Floats = _SCREEN_TABLE[np.rint(np.sqrt(light) * (_TABLE - 1)).astype(np.int64)]
    return shown


class Grid:
    """Triangles that are projected onto a grid of samples; the centre of a sample is at (column + 0.5, row + 0.5).

    ``x`` and ``y`` (n, 3) are in 1/16 of a sample, ``area`` (n,) is twice the signed area. The weight of corner k in
    a point of a triangle is ``weights[:, k] @ (x, y, 1)``: 1 at this corner and 0 at the others. ``near`` (n, 3) grows
    towards the camera; between the corners it is ``plane @ (x, y, 1)``, which is not rounded, so that triangles in one
    plane are equally near.
    """

    def __init__(self, x: Floats, y: Floats, near: Floats) -> None:
        """Take triangles whose corners are at x and y (n, 3), in samples."""
        self.x, self.y = (np.rint(values * _STEPS).astype(np.int64) for values in (x, y))
        (ax, bx, cx), (ay, by, cy) = self.x.T, self.y.T
        self.area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        next_x, last_x, next_y, last_y = (np.roll(v, shift, 1) for v in (x, y) for shift in (-1, -2))
        constant = next_x * last_y - last_x * next_y
        area = constant.sum(axis=1, keepdims=True)
        lines = np.stack([next_y - last_y, last_x - next_x, constant], axis=-1)
        self.weights: Floats = lines / np.where(area == 0, 1.0, area)[..., None]
        self.near, self.plane = near, (self.weights * near[..., None]).sum(axis=1)

    def visible(self, chosen: Ints, columns: int, first: int, end: int) -> Ints:
        """Return the largest key of each sample in the rows from ``first`` to ``end``, or -1."""
        keys = np.full((end - first) * columns, -1, np.int64)
        for place, key in self.samples(chosen, columns, first, end):
            np.maximum.at(keys, place, key)
        return keys

    def samples(self, chosen: Ints, columns: int, first: int, end: int) -> Iterator[tuple[Ints, Ints]]:
        """Yield the samples that the chosen triangles cover: number of the sample, and nearness with triangle as key.

        Samples are numbered row by row from the row ``first``.
        """
        low, high = (float(self.near.min()), float(self.near.max())) if len(self.near) else (0.0, 0.0)
        scale = _DEPTHS / (high - low) if high > low else 0.0
        top, bottom = self.y[chosen].min(axis=1), self.y[chosen].max(axis=1)
        chosen = chosen[(top <= end * _STEPS) & (bottom >= first * _STEPS) & (self.area[chosen] != 0)]
        for start in range(0, len(chosen), 20_000):
            triangle, row, left, length = self._spans(chosen[start : start + 20_000], columns, first, end)
            a, b, c = self.plane[triangle].T
            lowest, highest = ((f(self.near[triangle], axis=1) - low) * scale for f in (np.min, np.max))
            nearness = (a * (left + 0.5) + b * (row + 0.5) + c - low) * scale
            slope, place, low_half = a * scale, (row - first) * columns + left, _LAST - triangle
            cuts = np.searchsorted(np.cumsum(length), np.arange(_CHUNK, int(length.sum()), _CHUNK))
            for part in np.split(np.arange(len(length)), cuts):
                of, step = _repeated(length[part])
                of = part[of]
                depth = np.clip(nearness[of] + slope[of] * step, lowest[of], highest[of])
                depth = np.rint(depth).astype(np.int64)
                yield place[of] + step, (depth << 32) | low_half[of]

    def _spans(self, chosen: Ints, columns: int, first: int, end: int) -> tuple[Ints, Ints, Ints, Ints]:
        """Return the covered part of each row of triangles: triangle, row, first column and number of columns."""
        flipped = (self.area[chosen] < 0)[:, None]
        x, y = (np.where(flipped, values[chosen, ::-1], values[chosen]) for values in (self.x, self.y))
        half = _STEPS // 2
        top = np.maximum(-((half - y.min(axis=1)) // _STEPS), first)
        bottom = np.minimum((y.max(axis=1) - half) // _STEPS, end - 1)
        of, step = _repeated(np.maximum(bottom - top + 1, 0))
        row = top[of] + step
        left, right = np.zeros(len(of), np.int64), np.full(len(of), columns - 1)
        for i, j in ((0, 1), (1, 2), (2, 0)):  # a sample is inside where slope * column + value >= 0 for all sides
            across, down = y[:, i] - y[:, j], x[:, j] - x[:, i]
            constant = -(across * x[:, i] + down * y[:, i])
            constant -= (across < 0) | ((across == 0) & (down <= 0))  # a side belongs to one of its two triangles
            value = (across * half + constant)[of] + down[of] * (row * _STEPS + half)
            slope = (across * _STEPS)[of]
            bound = -(value // np.where(slope == 0, 1, slope))
            left = np.where(slope > 0, np.maximum(left, bound), left)
            right = np.where(slope < 0, np.minimum(right, value // np.where(slope < 0, -slope, 1)), right)
            right = np.where((slope == 0) & (value < 0), -1, right)
        covered = left <= right
        return chosen[of[covered]], row[covered], left[covered], (right - left + 1)[covered]


def _repeated(counts: Ints) -> tuple[Ints, Ints]:
    """Repeat each index by its count; return the repeated indices and the repetition numbers 0, 1, ..."""
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - (np.cumsum(counts) - counts)[of]


class Shadows:
    """The robot as the sun sees it: nearness to the sun on a grid of cells, and the blurred shadow on the floor."""

    def __init__(self, corners: Floats) -> None:
        """Take the shadows of triangles (n, 3, 3) in metres."""
        right = np.array((-_SUN[1], _SUN[0], 0.0)) / math.hypot(_SUN[0], _SUN[1])
        self.axes = np.cross(_SUN, right), right
        y, x, near = (_dot(corners, axis) for axis in (*self.axes, _SUN))
        self.cell = max(float(np.ptp(x)), float(np.ptp(y)), 1e-9) / _MAP_CELLS
        self.corner = [float(values.min()) - _BORDER * self.cell for values in (y, x)]
        size = _MAP_CELLS + 2 * _BORDER + 1
        grid = Grid((x - self.corner[1]) / self.cell, (y - self.corner[0]) / self.cell, near)
        keys = grid.visible(np.arange(len(corners)), size, 0, size).reshape(size, size)
        depth = float(near.min()) + (keys >> 32) * (float(np.ptp(near)) / _DEPTHS)
        blurred = (keys >= 0).astype(np.float64)
        for _ in range(2 * _BLURS):  # rows and columns in turn
            sums = np.cumsum(np.pad(blurred, ((0, 0), (_BLUR + 1, _BLUR))), axis=1)
            blurred = ((sums[:, 2 * _BLUR + 1 :] - sums[:, : -2 * _BLUR - 1]) / (2 * _BLUR + 1)).T
        self.near, self.blurred = np.where(keys < 0, -np.inf, depth), blurred

    def _lookup(self, values: Floats, points: Floats, offset: Floats | float = 0.0) -> Floats:
        at = np.stack([_dot(points, axis) - start for axis, start in zip(self.axes, self.corner, strict=True)])
        row, column = np.clip(np.floor(at / self.cell + offset), 0, len(values) - 1).astype(np.int64)
        found: Floats = values[row, column]
        return found

    def sunlight(self, points: Floats, normals: Floats, sample: Ints) -> Floats:
        """Return the share of the sun (n,) that points (n, 3) of surfaces see; ``sample`` is that of the pixel."""
        points = points + normals * (_OFFSET * self.cell)
        near = _dot(points, _SUN) + self.cell
        taps = (_DISC_POINTS[sample + _FINE**2 * tap].T * _PENUMBRA for tap in range(_TAPS))
        lit: Floats = sum(self._lookup(self.near, points, tap) <= near for tap in taps) / np.float64(_TAPS)
        return lit

    def on_floor(self, points: Floats) -> Floats:
        """Return the darkness, 0 to 1, of points (..., 3) on the floor."""
        return self._lookup(self.blurred, points)


class Scene:
    """Triangles (n, ...) with their looks, their bounding box (2, 3), and the shadows of opaque ones."""

    def __init__(self, pieces: Sequence[Piece], bounds: Floats, theme: Theme) -> None:
        """Take the visible pieces."""
        visible = [piece for piece in pieces if piece.visible]
        counts = [len(piece.corners) for piece in visible]
        linear = lambda v: v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4  # noqa: E731 - of sRGB
        looks = [(piece.opacity, piece.two_sided, piece.outlined, *map(linear, piece.colour)) for piece in visible]
        look = np.repeat(np.array(looks, np.float64).reshape(-1, 6), counts, axis=0)
        self.opacity, self.colour = look[:, 0], look[:, 3:]
        self.two_sided, self.outlined = look[:, 1:3].T > 0
        self.corners: Floats = np.concatenate([np.empty((0, 3, 3)), *(piece.corners for piece in visible)])
        self.normals: Floats = np.concatenate([np.empty((0, 3, 3)), *(piece.normals for piece in visible)])
        self.bounds, self.theme = bounds, theme
        self.size = max(math.dist(*bounds), 0.05)  # m; the distances of the floor follow from it
        opaque = self.corners[self.opacity >= 1.0]
        self.shadows = Shadows(opaque) if len(opaque) else None


def render(scene: Scene, camera: Camera, transparent: bool, progress: Callable[[int, int], None]) -> NDArray[np.uint8]:
    """Return the pixels of a picture: (rows, columns, 3), or with an alpha channel where it is transparent.

    ``progress`` is called with the number of finished rows and of all rows.
    """
    x, y, depth = camera.project(scene.corners)
    grid = Grid(x * _FINE, y * _FINE, 1.0 / depth)
    front = (grid.area < 0) | scene.two_sided
    opaque, translucent = (np.nonzero(front & kind)[0] for kind in (scene.opacity >= 1.0, scene.opacity < 1.0))
    pixels = np.empty((camera.height, camera.width, 4 if transparent else 3), np.uint8)
    columns = camera.width * _FINE
    step = max(1, _BAND // (columns * _FINE))
    for first in range(0, camera.height, step):
        end = min(first + step, camera.height)
        rows = (columns, first * _FINE, end * _FINE)
        behind = _background(scene, camera, first, end, transparent)
        samples = behind.repeat(_FINE, axis=0).repeat(_FINE, axis=1).reshape(-1, 4)  # premultiplied by alpha
        solid, veil = (grid.visible(chosen, *rows) for chosen in (opaque, translucent))
        for keys in (solid, np.where(veil > solid, veil, -1)):
            places = np.nonzero(keys >= 0)[0]
            triangle = _LAST - (keys[places] & _LAST)
            opacity = scene.opacity[triangle, None]
            colour = _shade(scene, camera, grid, triangle, places % columns, places // columns + first * _FINE)
            colour = np.pad(colour, ((0, 0), (0, 1)), constant_values=1.0)
            samples[places] = colour * opacity + samples[places] * (1.0 - opacity)
        band = samples.reshape(end - first, _FINE, camera.width, _FINE, 4).mean(axis=(1, 3))
        alpha = band[..., 3:]
        band[..., :3] /= np.where(alpha == 0.0, 1.0, alpha)
        pixels[first:end] = np.rint(np.clip(band, 0.0, 1.0) * 255.0)[..., : pixels.shape[2]]
        progress(end, camera.height)
    return pixels


def _shade(scene: Scene, camera: Camera, grid: Grid, triangle: Ints, column: Ints, row: Ints) -> Floats:
    """Return the colours (n, 3) of samples as sRGB, 0 to 1; ``triangle`` is the one that a sample sees."""
    lines = grid.weights[triangle]
    x, y = (column + 0.5)[:, None], (row + 0.5)[:, None]
    weights = np.clip(lines[..., 0] * x + lines[..., 1] * y + lines[..., 2], 0.0, 1.0)
    # The distance of a sample from a side is the weight of the opposite corner by its gradient.
    edges = (weights / np.sqrt(lines[..., 0] ** 2 + lines[..., 1] ** 2))[:, [0, 2]].min(axis=1) / _FINE
    weights *= grid.near[triangle]
    weights /= weights.sum(axis=1, keepdims=True)
    points, normals = ((weights[..., None] * values[triangle]).sum(axis=1) for values in (scene.corners, scene.normals))
    length = np.sqrt((normals * normals).sum(axis=1, keepdims=True))
    normals /= np.where(length == 0, 1.0, length)
    normals[scene.two_sided[triangle] & ((normals * (points - camera.eye)).sum(axis=1) > 0)] *= -1.0
    i, j, k = normals.T
    terms = np.stack([np.ones(len(i)), i, j, k, i * i - j * j, k * k, i * j, i * k, j * k], axis=1)
    sky = np.stack([_dot(terms, channel) for channel in _SKY], axis=1)
    sun = np.maximum(_dot(normals, _SUN), 0.0)
    if scene.shadows is not None:
        sun = sun * scene.shadows.sunlight(points, normals, row % _FINE * _FINE + column % _FINE)
    light = scene.colour[triangle] * (np.maximum(sky, 0.05) + _SUN_COLOUR * sun[:, None])
    edge = _EDGE + (1.0 - _EDGE) * _smooth(edges - 0.4)
    return _displayed(light * np.where(scene.outlined[triangle], edge, 1.0)[:, None])


def _smooth(values: Floats) -> Floats:
    """Return a smooth step from 0 at 0 to 1 at 1."""
    t = np.clip(values, 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _background(scene: Scene, camera: Camera, first: int, end: int, transparent: bool) -> Floats:
    """Return sky and floor in the rows from ``first`` to ``end``: sRGB and alpha (rows, columns, 4), 0 to 1."""
    # One more row and column, for the size of a pixel on the floor.
    rows, columns = np.mgrid[first : end + 1, 0 : camera.width + 1] + 0.5
    rays = camera.rays(columns, rows)
    height = camera.eye[2] - (scene.bounds[0, 2] - 1e-4 * scene.size)
    on_floor = (rays[..., 2] < -1e-9) & (height > 0)
    points = camera.eye + rays * np.where(on_floor, height / np.where(on_floor, -rays[..., 2], 1.0), 0.0)[..., None]
    on_floor, rows = on_floor[:-1, :-1, None], rows[:-1, :-1, None]
    dark = 0.0 if scene.shadows is None else scene.shadows.on_floor(points[:-1, :-1])[..., None]
    dark = scene.theme.shadow * np.where(on_floor, dark, 0.0)
    if transparent:
        return np.concatenate([np.zeros((*dark.shape[:2], 3)), dark], axis=-1)
    horizon, zenith, floor, grid = (np.array([*colour]) / 255.0 for colour in scene.theme[1:5])
    sky = horizon + (zenith - horizon) * (1.0 - rows / camera.height)
    x, y = np.moveaxis(points - scene.bounds.mean(axis=0), -1, 0)[:2]
    distance = np.sqrt(x * x + y * y)[:-1, :-1, None] / (_FLOOR_RADIUS * scene.size)
    fade = np.where(on_floor, 1.0 - _smooth((distance - 0.25) / 0.75), 0.0)
    step = 10.0 ** round(math.log10(scene.size / 8))
    lines = np.maximum(0.35 * _grid_lines(x, y, step), 0.8 * _grid_lines(x, y, 10 * step))[..., None]
    ground = floor + (grid - floor) * lines
    return np.pad((sky + (ground - sky) * fade) * (1.0 - dark), ((0, 0), (0, 0), (0, 1)), constant_values=1.0)


def _grid_lines(x: Floats, y: Floats, step: float) -> Floats:
    """Return the share of each pixel that is on a line of the floor; lines fade where they are too close together."""
    found = np.zeros((x.shape[0] - 1, x.shape[1] - 1))
    for value in (x / step, y / step):
        pixel = np.abs(np.diff(value, axis=1))[:-1] + np.abs(np.diff(value, axis=0))[:, :-1] + 1e-12
        offset = np.abs(value - np.rint(value))[:-1, :-1] / pixel
        found = np.maximum(found, np.maximum(1.0 - offset, 0.0) * (1.0 - np.clip((pixel - 0.08) / 0.22, 0.0, 1.0)))
    return found

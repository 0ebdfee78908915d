"""The pixels of a picture: the background, the floor, and over them what each of nine samples a pixel sees.

What is seen is found for each sample, but shaded once for each pixel and triangle, in the middle of what is seen of
it. A picture is made in bands of rows, so that a large one needs no more memory than a small one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera import Box, Camera
from .light import THEMES, FloorShadow, Shadows, Theme, floor_shadow, linear, on_screen, shaded, shadows, toned
from .raster import Layer, Scene, Whole, first_seen, next_seen, scene, turns_left
from .soup import Piece

Floats = NDArray[np.float64]
Told = Callable[[int, int], None]

FINE = 3  # samples along the side of a pixel
_BAND = 3_000_000  # samples that are looked at together
_LAYERS = 6  # of translucent surfaces behind each other; more are not seen through
REACH = 6.0  # of the floor, times the diagonal of the robot
_EDGE = 0.62  # what is left of the light along the edges of boxes


class Surfaces(NamedTuple):
    """All triangles that are drawn, (n, ...) each: corners and normals (m), and of which face and piece they are.

    ``outline`` is the row of ``quads`` (m, 4, 3) whose sides are drawn, or -1.
    """

    corners: Floats
    normals: Floats
    face: Whole
    piece: Whole
    outline: Whole
    quads: Floats


class Model(NamedTuple):
    """What is drawn: its surfaces, the look of the pieces (n, ...), and what the sun sees of it."""

    surfaces: Surfaces
    link: Whole
    colour: Floats
    opacity: Floats
    mesh: NDArray[np.bool_]
    box: Box
    sun: Shadows
    floor: FloorShadow
    theme: Theme

    @property
    def one_sided(self) -> NDArray[np.bool_]:
        """Of which pieces what looks away is not drawn: it is hidden, or it would be seen through the other side."""
        return ~self.mesh | (self.opacity < 1.0)

    @property
    def ground(self) -> float:
        """The height of the floor (m)."""
        return ground_of(self.box)


def ground_of(box: Box) -> float:
    """Return the height of the floor below a box (m)."""
    return box.lower[2] - 1e-4 * max(box.diagonal, 0.05)


def modelled(pieces: Sequence[Piece], box: Box, theme: Theme = THEMES["light"]) -> Model:
    """Return pieces as they are drawn, with their shadows; translucent ones throw none."""
    made = surfaces(pieces)
    opacity = np.array([piece.opacity for piece in pieces] or [1.0])
    solid = made.corners[opacity[made.piece] >= 1.0]
    return Model(
        made,
        np.array([piece.link for piece in pieces] or [0]),
        np.array([linear(piece.colour) for piece in pieces] or [(0.0, 0.0, 0.0)]),
        opacity,
        np.array([piece.mesh for piece in pieces] or [False]),
        box,
        shadows(solid, box),
        floor_shadow(solid, ground_of(box), box),
        theme,
    )


def surfaces(pieces: Sequence[Piece]) -> Surfaces:
    """Return the triangles of pieces: polygons as fans, in their order."""
    parts: list[tuple[Floats, Floats, Whole, Whole, Whole]] = []
    quads: list[Floats] = []
    faces = outlines = 0
    for index, piece in enumerate(pieces):
        for corners, normals in piece.patches:
            n, k = corners.shape[:2]
            fan = [(0, i, i + 1) for i in range(1, k - 1)]
            face = np.repeat(np.arange(faces, faces + n), k - 2)
            outline = np.full(n * (k - 2), -1, np.int64)
            if piece.outlined:
                outline = np.repeat(np.arange(outlines, outlines + n), k - 2)
                quads.append(corners)
                outlines += n
            made, smooth = (values[:, fan].reshape(-1, 3, 3) for values in (corners, normals))
            parts.append((made, smooth, face, np.full(len(face), index, np.int64), outline))
            faces += n
    if not parts:
        none, zero = np.empty((0, 3, 3)), np.empty(0, np.int64)
        return Surfaces(none, none, zero, zero, zero, np.empty((0, 4, 3)))
    all_quads = np.concatenate(quads) if quads else np.empty((0, 4, 3))
    columns: Any = [np.concatenate(part) for part in zip(*parts, strict=True)]
    return Surfaces._make([*columns, all_quads])


def in_view(model: Model, camera: Camera, fine: int) -> tuple[Scene, Whole]:
    """Return the triangles in a picture with ``fine`` samples along a pixel, and which of them can be seen."""
    corners = model.surfaces.corners
    x, y, depth = camera.seen(corners)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = [a[:, i] * b[:, j] - a[:, j] * b[:, i] for i, j in ((1, 2), (2, 0), (0, 1))]
    away = sum(normal[i] * (corners[:, 0, i] - camera.eye[i]) for i in range(3))
    safe = np.where(away == 0, 1.0, away)
    # Along a ray, 1 / depth is normal * direction / away; the direction is affine over the picture.
    ahead, right, down = (
        sum(normal[i] * axis[i] for i in range(3)) / safe for axis in (camera.ahead, camera.right, camera.down)
    )
    right, down = right / camera.focal, down / camera.focal
    near = np.stack([right / fine, down / fine, ahead - right * camera.width / 2 - down * camera.height / 2], axis=-1)
    nearest, farthest = (float(depth.min()), float(depth.max())) if len(depth) else (1.0, 2.0)
    made = scene(x * fine, y * fine, near, 1 / farthest, 1 / nearest)
    seen = (turns_left(made) != 0) & ((away < 0) | ~model.one_sided[model.surfaces.piece])
    return made, np.nonzero(seen)[0]


class Fragments(NamedTuple):
    """What is shaded, once each: a pixel of a band and a triangle, and how many samples of the pixel see it.

    ``x`` and ``y`` are the middle of these samples in the picture. ``sample`` is where each covered sample is (pixel of
    the band, times the samples of a pixel, plus sample), ``of`` its fragment.
    """

    pixel: Whole
    triangle: Whole
    many: Whole
    x: Floats
    y: Floats
    sample: Whole
    of: Whole


def fragments(layer: Layer, first: int, fine: int) -> Fragments:
    """Return what to shade of a layer that begins at the row ``first`` of pixels."""
    columns = layer.keys.shape[1]
    width = columns // fine
    flat = layer.keys.reshape(-1)
    place = np.nonzero(flat >= 0)[0]
    triangle = Layer(flat[place]).triangle
    row, column = place // columns, place % columns
    pixel = row // fine * width + column // fine
    across, below = column % fine, row % fine
    number = int(triangle.max(initial=0)) + 1
    key, of, many = np.unique(pixel * number + triangle, return_inverse=True, return_counts=True)
    of = of.reshape(-1)
    right, down = (np.bincount(of, weights=v, minlength=len(key)) / np.maximum(many, 1) for v in (across, below))
    at = key // number
    x, y = at % width + (right + 0.5) / fine, first + at // width + (down + 0.5) / fine
    return Fragments(at, key % number, many, x, y, pixel * fine**2 + below * fine + across, of)


def colours(model: Model, camera: Camera, seen: Fragments, outlines: bool = True) -> Floats:
    """Return what fragments look like (n, 3), as sRGB from 0 to 1."""
    every, index = model.surfaces, seen.triangle
    a, b, c = (every.corners[index, i] for i in range(3))
    points = _points(camera, seen, a, b, c)
    normals = _normals(points, a, b, c, every.normals[index])
    towards = np.array(camera.eye) - points
    inside = (normals * towards).sum(axis=1) < 0
    turned = inside & ~model.one_sided[every.piece[index]]
    normals = np.where(turned[:, None], -normals, normals)
    light = shaded(model.colour[every.piece[index]], normals, model.sun.lit(points, normals))
    if outlines:
        light = light * _outlined(model, camera, seen)[:, None]
    return on_screen(toned(light))


def _points(camera: Camera, seen: Fragments, a: Floats, b: Floats, c: Floats) -> Floats:
    """Return where the rays through fragments meet the planes of their triangles (m)."""
    rays = camera.rays(seen.x, seen.y)
    u, v = b - a, c - a
    normal = [u[:, i] * v[:, j] - u[:, j] * v[:, i] for i, j in ((1, 2), (2, 0), (0, 1))]
    away = sum(normal[i] * (a[:, i] - camera.eye[i]) for i in range(3))
    steep = sum(normal[i] * rays[i] for i in range(3))
    far = away / np.where(steep == 0, 1.0, steep)
    return np.stack([camera.eye[i] + far * rays[i] for i in range(3)], axis=-1)


def _normals(points: Floats, a: Floats, b: Floats, c: Floats, normals: Floats) -> Floats:
    """Return the normals at points of triangles, between those of the corners."""
    u, v, p = b - a, c - a, points - a
    uu, uv, vv, pu, pv = ((one * other).sum(axis=1) for one, other in ((u, u), (u, v), (v, v), (p, u), (p, v)))
    size = uu * vv - uv * uv
    size = np.where(size <= 0, 1.0, size)
    second, third = (np.clip((x * y - uv * z) / size, 0.0, 1.0) for x, y, z in ((vv, pu, pv), (uu, pv, pu)))
    first = np.maximum(1.0 - second - third, 0.0)
    made = first[:, None] * normals[:, 0] + second[:, None] * normals[:, 1] + third[:, None] * normals[:, 2]
    length = np.sqrt((made * made).sum(axis=1))
    found: Floats = made / np.where(length == 0, 1.0, length)[:, None]
    return found


def _outlined(model: Model, camera: Camera, seen: Fragments) -> Floats:
    """Return what is left of the light near the sides of outlined faces (n,)."""
    row = model.surfaces.outline[seen.triangle]
    left = np.ones(len(row))
    there = np.nonzero(row >= 0)[0]
    if not len(there):
        return left
    x, y, _ = camera.seen(model.surfaces.quads)
    x, y, px, py = x[row[there]], y[row[there]], seen.x[there], seen.y[there]
    near = np.full(len(there), np.inf)
    for i in range(4):
        ax, ay, bx, by = x[:, i - 1], y[:, i - 1], x[:, i], y[:, i]
        length = np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        off = np.abs((px - ax) * (by - ay) - (py - ay) * (bx - ax)) / np.where(length == 0, 1.0, length)
        near = np.minimum(near, np.where(length == 0, np.inf, off))
    t = np.clip((near - 0.4) / 1.0, 0.0, 1.0)
    left[there] = _EDGE + (1.0 - _EDGE) * (t * t * (3.0 - 2.0 * t))
    return left


def painted(model: Model, camera: Camera, transparent: bool, progress: Told) -> NDArray[np.uint8]:
    """Return the picture of a model: (rows, columns, 3), or 4 where it is transparent."""
    drawn, chosen = in_view(model, camera, FINE)
    opacity = model.opacity[model.surfaces.piece]
    solid, veils = chosen[opacity[chosen] >= 1.0], chosen[opacity[chosen] < 1.0]
    step = max(1, _BAND // (camera.width * FINE * FINE))
    made = np.empty((camera.height, camera.width, 4), np.uint8)
    for first in range(0, camera.height, step):
        end = min(first + step, camera.height)
        band = background(model, camera, first, end, transparent)
        _cover(band, model, camera, (drawn, solid, veils), first, end)
        made[first:end] = np.rint(np.clip(band, 0.0, 1.0) * 255.0).astype(np.uint8)
        progress(end, camera.height)
    return made if transparent else made[..., :3]


def _cover(band: Floats, model: Model, camera: Camera, of: tuple[Scene, Whole, Whole], first: int, end: int) -> None:
    """Draw the surfaces that the rows from ``first`` to ``end`` see over their background, which is changed."""
    drawn, solid, veils = of
    rows = (camera.width * FINE, first * FINE, end * FINE)
    base = first_seen(drawn, solid, *rows)
    layers = [base, *_veils(drawn, veils, base, rows)] if len(veils) else [base]
    found = [fragments(layer, first, FINE) for layer in layers]
    shown = [(seen, colours(model, camera, seen)) for seen in found]
    flat = band.reshape(-1, 4)
    if len(layers) == 1:
        _laid(flat, *shown[0])
    else:
        _mixed(flat, shown, model.opacity[model.surfaces.piece])


def _laid(flat: Floats, seen: Fragments, colour: Floats) -> None:
    """Lay solid surfaces over pixels (n, 4), each by the share of its samples."""
    share = seen.many / FINE**2
    covered = np.bincount(seen.pixel, weights=share, minlength=len(flat))
    there = np.nonzero(covered)[0]
    left = (1.0 - covered[there]) * flat[there, 3]
    alpha = covered[there] + left
    for i in range(3):
        sums = np.bincount(seen.pixel, weights=share * colour[:, i], minlength=len(flat))[there]
        flat[there, i] = (sums + left * flat[there, i]) / alpha
    flat[there, 3] = alpha


def _mixed(flat: Floats, shown: Sequence[tuple[Fragments, Floats]], opacity: Floats) -> None:
    """Lay surfaces over pixels (n, 4), sample by sample, the farthest first; ``opacity`` is that of the triangles."""
    covered = np.zeros(len(flat), bool)
    for seen, _ in shown:
        covered[seen.pixel] = True
    pixels = np.nonzero(covered)[0]
    row = np.cumsum(covered) - 1
    samples = np.repeat(flat[pixels], FINE**2, axis=0)
    for seen, colour in shown:
        at = row[seen.sample // FINE**2] * FINE**2 + seen.sample % FINE**2
        share, below = opacity[seen.triangle][seen.of], samples[at]
        left = below[:, 3] * (1.0 - share)
        alpha = share + left
        mixed = colour[seen.of] * share[:, None] + below[:, :3] * left[:, None]
        samples[at, :3] = mixed / np.where(alpha == 0, 1.0, alpha)[:, None]
        samples[at, 3] = alpha
    parts = samples.reshape(-1, FINE**2, 4)
    alpha = parts[..., 3].sum(axis=1)
    sums = (parts[..., :3] * parts[..., 3:]).sum(axis=1)
    flat[pixels, :3] = sums / np.where(alpha == 0, 1.0, alpha)[:, None]
    flat[pixels, 3] = alpha / FINE**2


def _veils(drawn: Scene, veils: Whole, base: Layer, rows: tuple[int, int, int]) -> Iterator[Layer]:
    """Return the translucent surfaces before the solid ones, the farthest layer first."""
    first = rows[1]
    before = Layer(np.full_like(base.keys, np.iinfo(np.int64).max))
    found: list[Layer] = []
    for _ in range(_LAYERS):
        before = next_seen(drawn, veils, before, base, first)
        if not (before.keys >= 0).any():
            break
        found.append(before)
    return reversed(found)


def background(model: Model, camera: Camera, first: int, end: int, transparent: bool) -> Floats:
    """Return sky and floor of the rows from ``first`` to ``end``: (rows, columns, 4), sRGB and opacity, 0 to 1."""
    made = np.zeros((end - first, camera.width, 4))
    y, x = np.mgrid[first : end + 1, 0 : camera.width + 1] + 0.5
    rays = camera.rays(x, y)
    high = camera.eye[2] - model.ground
    hits = (rays[2] < -1e-9) & (high > 0)
    far = np.where(hits, high / np.where(hits, -rays[2], 1.0), 0.0)
    at = [camera.eye[i] + far * rays[i] for i in range(2)]
    hits = hits[:-1, :-1]
    dark = model.theme.shade * np.where(hits, model.floor.at(at[0][:-1, :-1], at[1][:-1, :-1]), 0.0)
    if transparent:
        made[..., 3] = dark
        return made
    up = np.clip(1.0 - y[:-1, :-1] / camera.height, 0.0, 1.0)
    floor, fade, theme = *_floor(model, at), model.theme
    fade = np.where(hits, fade, 0.0)
    for i in range(3):
        sky = (theme.sky[i] + (theme.zenith[i] - theme.sky[i]) * up) / 255
        made[..., i] = (sky + (floor[i] - sky) * fade) * (1.0 - dark)
    made[..., 3] = 1.0
    return made


def _floor(model: Model, at: list[Floats]) -> tuple[list[Floats], Floats]:
    """Return the colour of the floor with its grid, and how much of it is seen.

    ``at`` are points in x and y (m), with one more row and column than is asked for.
    """
    size = max(model.box.diagonal, 0.05)
    centre, step = model.box.centre, grid_step(size)
    x, y = at[0] - centre[0], at[1] - centre[1]
    wide = [np.abs(v[:-1, 1:] - v[:-1, :-1]) + np.abs(v[1:, :-1] - v[:-1, :-1]) + 1e-12 for v in (x, y)]
    x, y = x[:-1, :-1], y[:-1, :-1]
    drawn = np.maximum(0.35 * _lines(x, y, wide, step), 0.8 * _lines(x, y, wide, 10 * step))
    reach = REACH * size
    t = np.clip((np.sqrt(x * x + y * y) / reach - 0.25) / 0.75, 0.0, 1.0)
    fade = 1.0 - t * t * (3.0 - 2.0 * t)
    ground, grid = model.theme.ground, model.theme.grid
    return [(ground[i] + (grid[i] - ground[i]) * drawn) / 255 for i in range(3)], fade


def grid_step(size: float) -> float:
    """Return how far apart the lines of the floor are (m) for a robot of that size."""
    return float(10.0 ** round(math.log10(size / 8)))


def _lines(x: Floats, y: Floats, wide: list[Floats], step: float) -> Floats:
    """Return how much of a pixel is on a line of the grid; lines that are too close to be told apart fade."""
    found = np.zeros(x.shape)
    for value, pixel in zip((x, y), wide, strict=True):
        there = value / step
        off = np.abs(there - np.rint(there)) * step / pixel
        close = np.clip((pixel / step - 0.08) / 0.22, 0.0, 1.0)
        found = np.maximum(found, (1.0 - np.minimum(off, 1.0)) * (1.0 - close))
    return found

"""A picture as SVG: the faces that are seen as polygons, in painter's order, each in the colour that it has on average.

The same camera, light and shadows as in ``painting``. Text is text, for whatever font the reader has.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from typing import Any, NamedTuple
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from .camera import Box, Camera
from .frames import HIGH, Axis, Name
from .light import FloorShadow, Theme
from .ordering import Polygon, ordered, surfaces_of
from .painting import REACH, Model, Surfaces, colours, fragments, grid_step, in_view, modelled
from .png import MARK
from .raster import Layer, Whole, first_seen, next_seen
from .soup import Piece

Floats = NDArray[np.float64]
Told = Callable[[int, int], None]
Point = tuple[float, float]

_SAMPLES = 800_000  # of the grid on which it is looked up what is seen
_MOST_FACES = 6_000  # of meshes; they are made coarser until there are no more
_COARSER = 8  # times that this is tried
_EDGE = 0.62  # what is left of the light along the edges of boxes
_END = "</linearGradient></defs>"
_STOPS = 16  # of the gradient by which the floor fades


class _Drawn(NamedTuple):
    """A polygon as it is drawn: where its corners are (pixels), its colour and opacity."""

    points: tuple[Point, ...]
    colour: str
    dark: str
    opacity: float
    sides: tuple[bool, ...]


def svg(
    pieces: Sequence[Piece],
    box: Box,
    camera: Camera,
    axes: Sequence[Axis],
    names: Sequence[Name],
    transparent: bool,
    theme: Theme,
    title: str,
    progress: Told,
) -> str:
    """Return the drawing of pieces and frames."""
    model = modelled(pieces, box, theme)
    drawn = _faces(model, camera, progress)
    size = f'width="{camera.width}" height="{camera.height}" viewBox="0 0 {camera.width} {camera.height}"'
    name = escape(title)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{escape(title, {chr(34): "&quot;"})}">',
        f"<!-- {MARK}: edits here are lost. -->",
        f"<title>{name}</title>",
        *([] if transparent else _ground(model, camera)),
        *_shadow(model, camera),
        '<g stroke-width=".7" stroke-linejoin="round">',
        *_polygons(drawn),
        "</g>",
        *_frames(axes, names, theme),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _faces(model: Model, camera: Camera, progress: Told) -> list[_Drawn]:
    """Return the faces that are seen, the farthest first."""
    factor = math.sqrt(_SAMPLES / (camera.width * camera.height))
    width, height = math.ceil(camera.width * factor), math.ceil(camera.height * factor)
    grid = camera._replace(width=width, height=height, focal=camera.focal * factor)
    model, seen = _fine_enough(model, grid)
    progress(1, 4)
    polygons = ordered(_polygons_of(model, seen), model, grid)
    progress(2, 4)
    flat = model._replace(surfaces=surfaces_of(polygons))
    colour, there = _means(flat, grid, len(polygons))
    progress(3, 4)
    made = []
    for index, polygon in enumerate(polygons):
        if there[index]:
            x, y, _ = camera.seen(polygon.corners)
            points = tuple((round(float(a), 1), round(float(b), 1)) for a, b in zip(x, y, strict=True))
            light, dark = _hex(colour[index]), _hex(colour[index] * _EDGE**0.5)
            made.append(_Drawn(points, light, dark, float(model.opacity[polygon.piece]), polygon.sides))
    return made


def _fine_enough(model: Model, grid: Camera) -> tuple[Model, Whole]:
    """Return a model and its faces that are seen, its meshes so coarse that there are not too many of these."""
    made, seen = model, _seen(model, grid)
    for step in range(_COARSER):
        if len(seen) <= _MOST_FACES:
            break
        made = _coarser(model, model.box.diagonal / 250 * 1.4**step)
        seen = _seen(made, grid)
    return made, seen


def _coarser(model: Model, cell: float) -> Model:
    """Return a model in whose meshes the corners in one cell of a grid (m) are one, where they are on average."""
    every = model.surfaces
    mesh = model.mesh[every.piece]
    corners = every.corners.copy()
    points = corners[mesh].reshape(-1, 3)
    cells = np.rint(points / cell).astype(np.int64)
    _, at = np.unique(np.column_stack([np.repeat(every.piece[mesh], 3), cells]), axis=0, return_inverse=True)
    at = at.reshape(-1)
    many = np.bincount(at)
    middles = np.stack([np.bincount(at, weights=points[:, i]) / many for i in range(3)], axis=-1)
    corners[mesh] = middles[at].reshape(-1, 3, 3)
    flat = np.zeros(len(mesh), bool)
    a, b, c = at.reshape(-1, 3).T
    flat[mesh] = (a == b) | (b == c) | (c == a)
    keep = np.nonzero(~flat)[0]
    taken: Any = [part[keep] for part in (corners, *every[1:5])]
    return model._replace(surfaces=Surfaces._make([*taken, every.quads]))


def _layers(model: Model, grid: Camera) -> Iterator[Layer]:
    """Yield what the grid sees: the solid faces, then the translucent ones before them, the nearest first."""
    drawn, chosen = in_view(model, grid, 1)
    opacity = model.opacity[model.surfaces.piece[chosen]]
    solid, veils = chosen[opacity >= 1.0], chosen[opacity < 1.0]
    base = first_seen(drawn, solid, grid.width, 0, grid.height)
    yield base
    before = Layer(np.full_like(base.keys, np.iinfo(np.int64).max))
    for _ in range(4 if len(veils) else 0):
        before = next_seen(drawn, veils, before, base, 0)
        yield before


def _seen(model: Model, grid: Camera) -> Whole:
    """Return the numbers of the faces of which a sample sees something."""
    found = [np.unique(layer.triangle) for layer in _layers(model, grid)]
    triangles = np.unique(np.concatenate(found))
    made: Whole = np.unique(model.surfaces.face[triangles[triangles >= 0]])
    return made


def _polygons_of(model: Model, faces: Whole) -> list[Polygon]:
    """Return faces as polygons, in their order."""
    every = model.surfaces
    start = np.searchsorted(every.face, faces, "left").tolist()
    end = np.searchsorted(every.face, faces, "right").tolist()
    made = []
    for first, last in zip(start, end, strict=True):
        corners = np.concatenate([every.corners[first, :2], every.corners[first:last, 2]])
        normal = np.concatenate([every.normals[first, :2], every.normals[first:last, 2]]).sum(axis=0)
        normal = normal / (math.sqrt(float((normal * normal).sum())) or 1.0)
        outlined = bool(every.outline[first] >= 0)
        made.append(Polygon(corners, (outlined,) * len(corners), normal, int(every.piece[first])))
    return made


def _means(model: Model, grid: Camera, count: int) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the colour (n, 3) that each face has where it is seen, and whether it is seen at all."""
    sums, weight = np.zeros((count, 3)), np.zeros(count)
    for layer in _layers(model, grid):
        parts = fragments(layer, 0, 1)
        face = model.surfaces.face[parts.triangle]
        shown = colours(model, grid, parts)
        weight += np.bincount(face, minlength=count)
        for i in range(3):
            sums[:, i] += np.bincount(face, weights=shown[:, i], minlength=count)
    return sums / np.maximum(weight, 1.0)[:, None], weight > 0


def _polygons(drawn: Sequence[_Drawn]) -> Iterator[str]:
    """Yield polygons as elements; those that follow each other with the same look are one."""
    for (colour, dark, opacity, sides), group in groupby(drawn, lambda one: one[1:]):
        same = list(group)
        shape = "".join(_path(one.points) for one in same)
        if opacity < 1:  # one by one: what lies over each other is seen through each other
            yield from (f'<path d="{_path(one.points)}" fill="{colour}" opacity="{opacity:.3g}"/>' for one in same)
            continue
        yield f'<path d="{shape}" fill="{colour}" stroke="{dark if all(sides) else colour}"/>'
        if any(sides) and not all(sides):
            edges = "".join(_edges(one) for one in same)
            yield f'<path d="{edges}" fill="none" stroke="{dark}"/>'


def _edges(one: _Drawn) -> str:
    ends = zip(one.points, (*one.points[1:], one.points[0]), one.sides, strict=True)
    return "".join(f"M{_at(a)}L{_at(b)}" for a, b, drawn in ends if drawn)


def _path(points: Sequence[Point]) -> str:
    kept = [point for index, point in enumerate(points) if point != points[index - 1]] or list(points[:1])
    return f"M{'L'.join(map(_at, kept))}Z"


def _at(point: Point) -> str:
    x, y = (f"{value:.1f}".removesuffix(".0") for value in point)
    return f"{x} {y}"


def _hex(colour: Sequence[float] | Floats) -> str:
    return "#" + "".join(f"{round(255 * min(max(float(value), 0.0), 1.0)):02x}" for value in colour)


def _rgb(colour: Sequence[int]) -> str:
    return "#" + "".join(f"{value:02x}" for value in colour)


def _ground(model: Model, camera: Camera) -> Iterator[str]:
    """Yield sky and floor: its grid, and over it the sky by which it fades with the distance."""
    theme = model.theme
    whole = f'width="{camera.width}" height="{camera.height}"'
    yield '<defs><linearGradient id="sky" x1="0" y1="1" x2="0" y2="0">'
    yield f'<stop stop-color="{_rgb(theme.sky)}"/><stop offset="1" stop-color="{_rgb(theme.zenith)}"/>' + _END
    high = camera.eye[2] - model.ground
    if high <= 0:
        yield f'<rect {whole} fill="url(#sky)"/>'
        return
    yield '<defs><linearGradient id="far" x1="0" y1="0" x2="0" y2="1">'
    for index in range(_STOPS + 1):
        part = index / _STOPS
        veil = 1 - _fade(model, camera, part, high)
        yield f'<stop offset="{part:.4g}" stop-color="{_rgb(theme.sky)}" stop-opacity="{veil:.3f}"/>'
    yield "</linearGradient></defs>"
    yield f'<rect {whole} fill="{_rgb(theme.ground)}"/>'
    size = max(model.box.diagonal, 0.05)
    step = grid_step(size)
    for apart, reach, strength in ((step, 5 * size, 0.35), (10 * step, REACH * size, 0.8)):
        path = "".join(_grid(model, camera, apart, reach))
        if path:
            yield f'<path d="{path}" stroke="{_rgb(theme.grid)}" stroke-opacity="{strength}" fill="none"/>'
    yield f'<rect {whole} fill="url(#far)"/>'


def _fade(model: Model, camera: Camera, part: float, high: float) -> float:
    """Return how much of the floor is seen in the middle of a row, ``part`` of the picture from its upper edge."""
    x, y, z = camera.rays(np.array(camera.width / 2), np.array(part * camera.height))
    if float(z) >= -1e-9:
        return 0.0
    far = high / -float(z)
    centre, size = model.box.centre, max(model.box.diagonal, 0.05)
    off = math.hypot(camera.eye[0] + far * float(x) - centre[0], camera.eye[1] + far * float(y) - centre[1])
    t = min(max((off / (REACH * size) - 0.25) / 0.75, 0.0), 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


def _grid(model: Model, camera: Camera, step: float, reach: float) -> Iterator[str]:
    """Yield the lines of the floor that are in the picture."""
    cx, cy, _ = model.box.centre
    count = int(reach / step)
    for index in range(-count, count + 1):
        at = index * step
        along, across = [(cx + at, cy - reach), (cx + at, cy + reach)], [(cx - reach, cy + at), (cx + reach, cy + at)]
        for ends in (along, across):
            line = _clipped(np.array([(*end, model.ground) for end in ends]), camera)
            if line is not None:
                yield f"M{_at(line[0])}L{_at(line[1])}"


def _clipped(ends: Floats, camera: Camera) -> tuple[Point, Point] | None:
    """Return the part of a line (2, 3) that is in the picture, in pixels."""
    near = 0.05 * math.dist(camera.eye, tuple(ends.mean(axis=0)))
    depth = camera.seen(ends)[2]
    if (depth < near).all():
        return None
    for i, j in ((0, 1), (1, 0)):
        if depth[i] < near:
            ends[i] = ends[i] + (ends[j] - ends[i]) * ((near - depth[i]) / (depth[j] - depth[i]))
    x, y, _ = camera.seen(ends)
    dx, dy = float(x[1] - x[0]), float(y[1] - y[0])
    first, last = 0.0, 1.0
    for slope, room in (
        *((-dx, float(x[0])), (dx, camera.width - float(x[0]))),
        *((-dy, float(y[0])), (dy, camera.height - float(y[0]))),
    ):
        if slope == 0 and room < 0:
            return None
        if slope < 0:
            first = max(first, room / slope)
        elif slope > 0:
            last = min(last, room / slope)
    if first >= last:
        return None
    a, b = ((float(x[0]) + t * dx, float(y[0]) + t * dy) for t in (first, last))
    return a, b


def _shadow(model: Model, camera: Camera) -> Iterator[str]:
    """Yield the shadow on the floor: the outline of its dark half, blurred."""
    if camera.eye[2] <= model.ground:
        return
    path = []
    for loop in outline(model.floor):
        points = np.array([(x, y, model.ground) for x, y in loop])
        x, y, depth = camera.seen(points)
        if (depth > 0).all():
            path.append(_path([(round(float(a), 1), round(float(b), 1)) for a, b in zip(x, y, strict=True)]))
    if not path:
        return
    centre = np.array(model.box.centre)
    soft = 0.008 * model.box.diagonal * camera.focal / float(camera.seen(centre)[2])
    yield f'<filter id="soft"><feGaussianBlur stdDeviation="{soft:.1f}"/></filter>'
    shape = "".join(path)
    yield f'<path d="{shape}" fill-rule="evenodd" fill-opacity="{model.theme.shade}" filter="url(#soft)"/>'


def outline(shadow: FloorShadow) -> list[list[Point]]:
    """Return the outlines of the dark half of a shadow as loops in the root frame (m)."""
    inside = np.pad(shadow.dark >= 0.5, 1)
    after: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for (dj, di), start, end in (
        ((-1, 0), (0, 0), (1, 0)),  # the border goes round with the inside on its left
        ((0, 1), (1, 0), (1, 1)),
        ((1, 0), (1, 1), (0, 1)),
        ((0, -1), (0, 1), (0, 0)),
    ):
        border = inside & ~np.roll(inside, (-dj, -di), (0, 1))
        for j, i in np.argwhere(border).tolist():
            after.setdefault((i + start[0], j + start[1]), []).append((i + end[0], j + end[1]))
    loops = []
    for first in sorted(after):
        while after.get(first):
            loop, here = [first], after[first].pop()
            while here != first:
                loop.append(here)
                here = after[here].pop()
            loops.append(_simple(loop))
    (x, y), cell = shadow.corner, shadow.cell
    return [[(x + (i - 1) * cell, y + (j - 1) * cell) for i, j in loop] for loop in loops if len(loop) > 2]


def _simple(loop: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return a loop without the corners that are less than a cell off the line between others (Douglas, Peucker)."""
    points = np.array(loop, dtype=np.float64)
    half = int(((points - points[0]) ** 2).sum(axis=1).argmax())
    keep = {0, half}
    waiting = [(0, half), (half, len(loop))]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        a, b = points[first], points[last % len(loop)]
        way, off = b - a, points[first + 1 : last] - a
        far = np.abs(off[:, 0] * way[1] - off[:, 1] * way[0]) / (math.hypot(*way.tolist()) or 1.0)
        index = int(far.argmax())
        if far[index] > 0.9:
            middle = first + 1 + index
            keep.add(middle)
            waiting += [(first, middle), (middle, last)]
    return [loop[index] for index in sorted(keep)]


def _frames(axes: Sequence[Axis], names: Sequence[Name], theme: Theme) -> Iterator[str]:
    if axes:
        yield '<g stroke-width="2" stroke-linecap="round">'
        for start, end, colour in axes:
            yield f'<path d="M{_at(start)}L{_at(end)}" stroke="{_rgb(colour)}"/>'
        yield "</g>"
    if names:
        font = f'font-family="DejaVu Sans, Verdana, sans-serif" font-size="{HIGH:g}"'
        around = _rgb(theme.halo).replace("ffffff", "fff")
        halo = f'stroke="{around}" stroke-opacity=".8" stroke-width="3" stroke-linejoin="round" paint-order="stroke"'
        yield f'<g {font} fill="{_rgb(theme.label)}" {halo} dominant-baseline="central">'
        for name in names:
            yield f'<text x="{name.x:.1f}" y="{name.y:.1f}">{escape(name.text)}</text>'
        yield "</g>"

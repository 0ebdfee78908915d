"""What is drawn: the shapes of a robot as polygons, placed by its joints, each with the look of its link.

Polygons with the same number of corners stand together in one array. Solids are those of the page
(``viewer/src/geometry.js``), colours are its formula (``viewer/src/colours.js``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Box as BoxShape
from rosorin_compile.model import (
    Capsule,
    Cylinder,
    Ellipsoid,
    Geometry,
    HeightMap,
    Link,
    Mesh,
    Robot,
    Shape,
    Sphere,
    Transform,
    Vector,
)

from .camera import Box

Floats = NDArray[np.float64]

ROUND = 40  # corners of a circle
COLLISION = (0xE8 / 255, 0x83 / 255, 0x3A / 255)
VEIL = 0.35  # how much a collision shape covers where visuals are drawn as well
_CREASE = 0.82  # the cosine of the angle up to which a mesh is taken to be round there
_MOST_ROUND = 400_000  # triangles; of larger meshes no edge is looked at

Colour = tuple[float, float, float]


class Surface(NamedTuple):
    """A part of a mesh: triangles (n, 3, 3) in metres, and the colour that its file gives them, if it does."""

    triangles: Floats
    colour: Colour | None = None


Surfaces = Callable[[Mesh], "list[Surface] | None"]


class Patch(NamedTuple):
    """Polygons with equally many corners: (n, k, 3) in the root frame (m), counter-clockwise from outside.

    ``normals`` (n, k, 3) are those of the surface at each corner, of length 1.
    """

    corners: Floats
    normals: Floats


class Piece(NamedTuple):
    """One shape as it is drawn. ``link`` is its number in the robot; ``mesh``: it may be open."""

    link: int
    colour: Colour
    opacity: float
    patches: tuple[Patch, ...]
    box: Box
    mesh: bool
    outlined: bool
    shown: bool = True


def pieces(
    robot: Robot, places: Mapping[str, Transform], surfaces: Surfaces, visual: bool, collision: bool
) -> list[Piece]:
    """Return what is drawn of a robot whose links are at ``places``.

    ``surfaces`` returns the parts of a mesh, or None for one that cannot be read. They have their own colours where
    nobody gives the visual one. Shapes that are not shown have their box alone, because the page fits all of them.
    """
    made: list[Piece] = []
    for index, link in enumerate(robot.links):
        for purpose, shown, shape in _shapes(link, surfaces, visual, collision):
            veiled = purpose == "collision" and visual and collision
            rgba = robot.colour(shape) if purpose == "visual" else None if robot.has_looks else robot.look_of(link)
            colour = COLLISION if veiled else rgba[:3] if rgba else robot.own_colours[link.name][:3]
            opacity = VEIL if veiled else rgba[3] if rgba else 1.0
            at = places[link.name].then(shape.origin().transform())
            own = purpose == "visual" and rgba is None
            made += _piece(shape, Look(index, colour, opacity, own), at, surfaces, shown)
    return made


def _shapes(link: Link, surfaces: Surfaces, visual: bool, collision: bool) -> Iterator[tuple[str, bool, Shape]]:
    """Yield the shapes of a link, what they are for, and whether they are shown.

    Of a link with a visual mesh that cannot be read the collision shapes are shown as well.
    """
    lost = any(isinstance(shape.geometry, Mesh) and surfaces(shape.geometry) is None for shape in link.visual)
    instead = visual and lost
    yield from (("visual", visual, one) for shape in link.visual for one in shape.drawn())
    yield from (("collision", collision or instead, one) for shape in link.collision for one in shape.drawn())


class Look(NamedTuple):
    """How a shape is drawn: the number of its link, colour and opacity; ``own``: a mesh may have its own colours."""

    link: int
    colour: Colour
    opacity: float
    own: bool


def _piece(shape: Shape, look: Look, at: Transform, surfaces: Surfaces, shown: bool) -> Iterator[Piece]:
    geometry = shape.geometry
    if isinstance(geometry, Mesh):
        for surface, colour in surfaces(geometry) or ():
            if len(surface):
                ends = surface.min(axis=(0, 1)), surface.max(axis=(0, 1))
                patches = (Patch(surface, _mesh_normals(surface)),) if shown else ()
                own = look._replace(colour=colour) if look.own and colour is not None else look
                yield _placed_piece(geometry, own, at, ends, patches, shown)
    else:
        yield _placed_piece(geometry, look, at, _extent(geometry), tuple(_solid(geometry)) if shown else (), shown)


def _placed_piece(
    geometry: Geometry,
    look: Look,
    at: Transform,
    ends: tuple[Sequence[float] | Floats, Sequence[float] | Floats],
    patches: tuple[Patch, ...],
    shown: bool,
) -> Piece:
    sides = [(float(low), float(high)) for low, high in zip(*ends, strict=True)]
    box = around([at.apply((x, y, z)) for x, y, z in product(*sides)])
    placed = tuple(_placed(patch, at) for patch in patches)
    mesh, is_box = isinstance(geometry, Mesh), isinstance(geometry, BoxShape)
    return Piece(look.link, look.colour, look.opacity, placed, box, mesh, is_box, shown)


def around(points: Sequence[Vector]) -> Box:
    """Return the box around points."""
    columns = list(zip(*points, strict=True))
    low, high = [min(c) for c in columns], [max(c) for c in columns]
    return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def bounds(found: Sequence[Piece], places: Mapping[str, Transform]) -> Box:
    """Return the box around all shapes, or around the frames of a robot that has none."""
    if found:
        return around([corner for piece in found for corner in (piece.box.lower, piece.box.upper)])
    return around([place.xyz for place in places.values()])


def _placed(patch: Patch, at: Transform) -> Patch:
    (a, b, c), xyz = at.rows, at.xyz

    def turned(v: Floats) -> Floats:
        x, y, z = v[..., 0], v[..., 1], v[..., 2]
        return np.stack([row[0] * x + row[1] * y + row[2] * z for row in (a, b, c)], axis=-1)

    return Patch(turned(patch.corners) + np.array(xyz), turned(patch.normals))


def _extent(geometry: BoxShape | Cylinder | Capsule | Sphere | Ellipsoid | HeightMap) -> tuple[Vector, Vector]:
    """Return the lower and the upper corner around a solid in its own frame."""
    if isinstance(geometry, HeightMap):
        x, y = geometry.origin
        cells = [(i, j, h) for i, row in enumerate(geometry.heights) for j, h in enumerate(row) if h > 0]
        box = around(cells or [(0, 0, 0.0)])
        (first, left, _), (last, right, top), cell = box.lower, box.upper, geometry.cell
        return (x + first * cell, y + left * cell, 0.0), (x + (last + 1) * cell, y + (right + 1) * cell, top)
    if isinstance(geometry, BoxShape):
        half = tuple(side / 2 for side in geometry.size)
    elif isinstance(geometry, Sphere):
        half = (geometry.radius,) * 3
    elif isinstance(geometry, Ellipsoid):
        half = geometry.radii
    else:
        more = geometry.radius if isinstance(geometry, Capsule) else 0.0
        half = (geometry.radius, geometry.radius, geometry.length / 2 + more)
    x, y, z = half
    return (-x, -y, -z), (x, y, z)


def _solid(geometry: BoxShape | Cylinder | Capsule | Sphere | Ellipsoid | HeightMap) -> Iterator[Patch]:
    if isinstance(geometry, BoxShape):
        yield _box(geometry.size)
    elif isinstance(geometry, HeightMap):
        yield _quads(_steps(geometry))
    elif isinstance(geometry, Sphere):
        yield from _ball(geometry.radius, 0.0)
    elif isinstance(geometry, Ellipsoid):
        yield from (_stretched(patch, geometry.radii) for patch in _ball(1.0, 0.0))
    elif isinstance(geometry, Capsule):
        yield _side(geometry.radius, geometry.length)
        yield from _ball(geometry.radius, geometry.length)
    else:
        yield _side(geometry.radius, geometry.length)
        yield from _caps(geometry.radius, geometry.length)


def _stretched(patch: Patch, factors: Vector) -> Patch:
    """Return polygons stretched along x, y and z; their normals turn the other way."""
    normals = patch.normals / np.array(factors)
    return Patch(patch.corners * np.array(factors), normals / np.linalg.norm(normals, axis=-1, keepdims=True))


def _quads(quads: Sequence[Sequence[Vector]]) -> Patch:
    """Return flat polygons, each with the normal that its corners say."""
    corners = np.array(quads, dtype=np.float64).reshape(-1, 4, 3)
    return Patch(corners, np.repeat(_flat(corners)[:, None], 4, axis=1))


def _box(size: Vector) -> Patch:
    x, y, z = (side / 2 for side in size)
    return _quads(
        [
            [(x, -y, -z), (x, y, -z), (x, y, z), (x, -y, z)],
            [(-x, y, -z), (-x, -y, -z), (-x, -y, z), (-x, y, z)],
            [(x, y, -z), (-x, y, -z), (-x, y, z), (x, y, z)],
            [(-x, -y, -z), (x, -y, -z), (x, -y, z), (-x, -y, z)],
            [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)],
            [(-x, y, -z), (x, y, -z), (x, -y, -z), (-x, -y, -z)],
        ]
    )


def _circle(index: int) -> tuple[float, float]:
    turn = 2 * math.pi * (index % ROUND) / ROUND
    return math.cos(turn), math.sin(turn)


def _side(radius: float, length: float) -> Patch:
    h = length / 2
    corners, normals = [], []
    for i in range(ROUND):
        (a, b), (c, d) = _circle(i), _circle(i + 1)
        corners.append([(radius * x, radius * y, z) for x, y, z in ((a, b, -h), (c, d, -h), (c, d, h), (a, b, h))])
        normals.append([(a, b, 0.0), (c, d, 0.0), (c, d, 0.0), (a, b, 0.0)])
    return Patch(np.array(corners), np.array(normals))


def _caps(radius: float, length: float) -> Iterator[Patch]:
    for sign in (1, -1):
        ring = [(radius * x, radius * y, sign * length / 2) for x, y in map(_circle, range(ROUND))]
        corners = np.array([ring[::sign]])
        yield Patch(corners, np.broadcast_to(np.array([0.0, 0.0, sign]), corners.shape))


def _ball(radius: float, apart: float) -> Iterator[Patch]:
    """Yield a sphere whose halves are ``apart`` (m): rings of quads, and triangles about the poles."""
    rings = ROUND // 2
    quads: list[list[Vector]] = []
    fans: list[list[Vector]] = []
    lifts: dict[int, list[float]] = {3: [], 4: []}
    latitudes = [(math.sin(math.pi * i / rings), math.cos(math.pi * i / rings)) for i in range(rings + 1)]
    for ring, ((high, top), (low, bottom)) in enumerate(pairwise(latitudes)):
        lift = apart / 2 if ring < rings / 2 else -apart / 2
        for i in range(ROUND):
            (a, b), (c, d) = _circle(i), _circle(i + 1)
            above: list[Vector] = [(high * c, high * d, top), (high * a, high * b, top)]
            under: list[Vector] = [(low * a, low * b, bottom), (low * c, low * d, bottom)]
            if ring == 0:
                fans.append([*under, (0.0, 0.0, 1.0)])
            elif ring == rings - 1:
                fans.append([*above, (0.0, 0.0, -1.0)])
            else:
                quads.append([*under, *above])
            lifts[3 if ring in (0, rings - 1) else 4].append(lift)
    for polygons in (quads, fans):
        normals = np.array(polygons)
        lifted = np.array(lifts[normals.shape[1]])[:, None] * np.array([0.0, 0.0, 1.0])
        yield Patch(radius * normals + lifted[:, None, :], normals)


def _steps(shape: HeightMap) -> list[list[Vector]]:
    """Return the body under a height map: tops of equal height as rectangles, walls where heights differ."""
    heights = np.zeros((len(shape.heights) + 2, max(map(len, shape.heights), default=0) + 2))
    for i, row in enumerate(shape.heights):
        heights[i + 1, 1 : len(row) + 1] = np.maximum(row, 0.0)
    xs = [shape.origin[0] + (i - 1) * shape.cell for i in range(heights.shape[0] + 1)]
    ys = [shape.origin[1] + (j - 1) * shape.cell for j in range(heights.shape[1] + 1)]
    made: list[list[Vector]] = []
    for (first, left, last, right), high in _rectangles(heights):
        (a, b), (c, d) = (xs[first], xs[last]), (ys[left], ys[right])
        made.append([(a, c, high), (b, c, high), (b, d, high), (a, d, high)])
        made.append([(a, d, 0.0), (b, d, 0.0), (b, c, 0.0), (a, c, 0.0)])
    for i in range(1, heights.shape[0]):
        for first, end, low, high, ahead in _walls(heights[i - 1], heights[i]):
            a, b = (ys[end], ys[first]) if ahead else (ys[first], ys[end])
            made.append([(xs[i], a, low), (xs[i], b, low), (xs[i], b, high), (xs[i], a, high)])
    for j in range(1, heights.shape[1]):
        for first, end, low, high, ahead in _walls(heights[:, j - 1], heights[:, j]):
            a, b = (xs[first], xs[end]) if ahead else (xs[end], xs[first])
            made.append([(a, ys[j], low), (b, ys[j], low), (b, ys[j], high), (a, ys[j], high)])
    return made


def _rectangles(heights: Floats) -> Iterator[tuple[tuple[int, int, int, int], float]]:
    """Yield rectangles of cells of one height above zero: runs of a row, then equal runs of rows that follow."""
    open_runs: dict[tuple[int, int, float], int] = {}
    for i in range(heights.shape[0]):
        row = heights[i]
        cuts = [0, *(np.nonzero(row[1:] != row[:-1])[0] + 1).tolist(), len(row)]
        runs = {(a, b, float(row[a])) for a, b in pairwise(cuts) if row[a] > 0}
        for run in sorted(set(open_runs) - runs):
            yield (open_runs.pop(run), run[0], i, run[1]), run[2]
        for run in runs:
            open_runs.setdefault(run, i)


def _walls(behind: Floats, ahead: Floats) -> Iterator[tuple[int, int, float, float, bool]]:
    """Yield runs along which two rows of cells differ: first cell, end, lower and upper height, which one is higher."""
    changes = (behind[1:] != behind[:-1]) | (ahead[1:] != ahead[:-1])
    cuts = [0, *(np.nonzero(changes)[0] + 1).tolist(), len(behind)]
    for first, end in pairwise(cuts):
        one, other = float(behind[first]), float(ahead[first])
        if one != other:
            yield first, end, min(one, other), max(one, other), other > one


def _flat(corners: Floats) -> Floats:
    """Return the normals (n, 3) of polygons, of length 1; zero for one without area."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.stack([a[:, i] * b[:, j] - a[:, j] * b[:, i] for i, j in ((1, 2), (2, 0), (0, 1))], axis=-1)
    return _unit(normal)


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt(vectors[..., 0] ** 2 + vectors[..., 1] ** 2 + vectors[..., 2] ** 2)
    made: Floats = vectors / np.where(length == 0, 1.0, length)[..., None]
    return made


def _mesh_normals(triangles: Floats) -> Floats:
    """Return normals (n, 3, 3) for the corners of a mesh: smooth where it is round, those of the faces elsewhere."""
    flat = _flat(triangles)
    if len(triangles) > _MOST_ROUND:
        return np.repeat(flat[:, None], 3, axis=1)
    _, at = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    at = at.reshape(-1)
    every = np.repeat(flat, 3, axis=0)
    mean = _unit(np.stack([np.bincount(at, weights=every[:, i]) for i in range(3)], axis=-1))[at]
    round_there = (mean * every).sum(axis=1) > _CREASE
    return np.where(round_there[:, None], mean, every).reshape(-1, 3, 3)

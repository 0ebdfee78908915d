"""The shapes of a robot as triangles in the root frame, with the colours of the page (``viewer/src/colours.js``)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Mesh, Robot, Sphere, Transform
from rosorin_compile.model.colours import own_colours

Floats = NDArray[np.float64]
Colour = tuple[float, float, float]
# A mesh in parts: triangles (n, 3, 3) in metres, and the colour that the mesh file gives them, or None.
MeshParts = Sequence[tuple[Floats, Colour | None]]

_SEGMENTS = 40  # of a circle
_COLLISION_OVERLAY = (0xE8 / 255, 0x83 / 255, 0x3A / 255, 0.35)  # where visuals are drawn as well
_SMOOTH = 0.82  # cosine of the largest angle between a face and a smooth surface through its corners
_MOST_SMOOTH = 400_000  # triangles; larger meshes are drawn with flat faces
# The faces of a box: numbers of its corners in the order of itertools.product, counter-clockwise from outside.
_BOX_FACES = [(4, 6, 7, 5), (2, 0, 1, 3), (6, 2, 3, 7), (0, 4, 5, 1), (1, 5, 7, 3), (2, 6, 4, 0)]


class Piece(NamedTuple):
    """Triangles of one colour: corners and the surface normals there (n, 3, 3), counter-clockwise from outside.

    ``bounds`` has the lower and the upper corner of the bounding box. The back of a face is drawn where a surface is
    ``two_sided``: meshes are often open. The first two sides of each triangle are ``outlined``. Pieces that are not
    ``visible`` only have to fit into the picture.
    """

    corners: Floats
    normals: Floats
    colour: Colour
    opacity: float
    bounds: Floats
    two_sided: bool
    outlined: bool
    visible: bool


def pieces(
    robot: Robot, poses: Mapping[str, Transform], meshes: Mapping[Mesh, MeshParts], visual: bool, collision: bool
) -> list[Piece]:
    """Return the shapes of a robot whose links have these poses in the root frame, visual and collision shapes visible.

    A link of which a visual mesh is not in ``meshes``, because it cannot be read, shows its collision shapes. With both
    kinds visible, collision shapes are translucent.
    """
    made: list[Piece] = []
    colours = own_colours(robot)
    for link in robot.links:
        incomplete = any(isinstance(shape.geometry, Mesh) and shape.geometry not in meshes for shape in link.visual)
        own = None if robot.has_looks else robot.look_of(link)
        collision_rgba = _COLLISION_OVERLAY if visual and collision else own
        solids = [(solid, robot.colour(solid), True, visual) for shape in link.visual for solid in shape.drawn()]
        shown = collision or (visual and incomplete)
        solids += [(solid, collision_rgba, False, shown) for shape in link.collision for solid in shape.drawn()]
        for shape, rgba, is_visual, visible in solids:
            geometry, pose = shape.geometry, poses[link.name].then(shape.pose.transform())
            red, green, blue, opacity = rgba or colours[link.name]
            solid: MeshParts = () if isinstance(geometry, Mesh) else [(part, None) for part in _solid(geometry)]
            parts = meshes.get(geometry, ()) if isinstance(geometry, Mesh) else solid
            for corners, own_colour in (part for part in parts if len(part[0])):
                sides = zip(corners.min(axis=(0, 1)), corners.max(axis=(0, 1)), strict=True)
                box = _rotated(np.array(list(product(*sides))), pose) + pose.xyz
                colour = own_colour if rgba is None and is_visual and own_colour else (red, green, blue)
                placed = _rotated(corners, pose) + pose.xyz, _rotated(_normals(corners), pose)
                looks = isinstance(geometry, Mesh) and opacity >= 1.0, isinstance(geometry, Box), visible
                made.append(Piece(*placed, colour, opacity, np.array([box.min(axis=0), box.max(axis=0)]), *looks))
    return made


def _rotated(vectors: Floats, pose: Transform) -> Floats:
    return np.stack([(vectors * np.array(row)).sum(axis=-1) for row in pose.rows], axis=-1)


def _solid(geometry: Box | Cylinder | Capsule | Sphere | Ellipsoid | HeightMap) -> list[Floats]:
    """Return the surfaces of a solid in its own frame, as triangles (n, 3, 3)."""
    if isinstance(geometry, Box | HeightMap):
        boxes = geometry.boxes() if isinstance(geometry, HeightMap) else [geometry]
        faces = [np.array(list(product(*zip(box.lower, box.upper, strict=True))))[_BOX_FACES] for box in boxes]
        return [_triangulated(np.array(faces).reshape(-1, 4, 3))]
    # Surfaces of revolution about z: radius and height of their profiles from top to bottom.
    half = [math.pi * step / (_SEGMENTS // 2) for step in range(_SEGMENTS // 2 + 1)]
    radius = 1.0 if isinstance(geometry, Ellipsoid) else geometry.radius
    h = geometry.length / 2 if isinstance(geometry, Cylinder | Capsule) else 0.0
    if isinstance(geometry, Cylinder):
        profiles = [[*side] for side in pairwise([(0.0, h), (radius, h), (radius, -h), (0.0, -h)])]
    else:
        middle = _SEGMENTS // 4
        turns = [(t, h) for t in half[: middle + 1]] + [(t, -h) for t in half[middle if h else middle + 1 :]]
        profiles = [[(radius * math.sin(t), radius * math.cos(t) + z) for t, z in turns]]
    steps = [2 * math.pi * (step % _SEGMENTS) / _SEGMENTS for step in range(_SEGMENTS + 1)]
    found = []
    for profile in profiles:
        p = np.array([[(r * math.cos(turn), r * math.sin(turn), z) for turn in steps] for r, z in profile])
        p = p * (geometry.radii if isinstance(geometry, Ellipsoid) else 1.0)
        quads = np.stack([p[1:, :-1], p[1:, 1:], p[:-1, 1:], p[:-1, :-1]], axis=2)
        found.append(_triangulated(quads.reshape(-1, 4, 3)))
    return found


def _triangulated(quads: Floats) -> Floats:
    return quads[:, [(0, 1, 2), (2, 3, 0)]].reshape(-1, 3, 3)


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    scaled: Floats = vectors / np.where(length == 0, 1.0, length)
    return scaled


def _normals(triangles: Floats) -> Floats:
    """Return normals (n, 3, 3): averaged over the faces at a corner where the surface is round, else of the face."""
    faces = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    flat = np.repeat(_unit(faces), 3, axis=0)
    if len(triangles) > _MOST_SMOOTH:
        return flat.reshape(-1, 3, 3)
    corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1)
    mean = _unit(np.stack([np.bincount(corner, weights=flat[:, i]) for i in range(3)], axis=-1))[corner]
    is_round = (mean * flat).sum(axis=1, keepdims=True) > _SMOOTH
    return np.where(is_round, mean, flat).reshape(-1, 3, 3)

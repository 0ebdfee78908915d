"""Solids: shapes of two robots that fill the same space, however they are written."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..compare.shapes import Solid, solid_from
from ..model import Box, Capsule, Cylinder, HeightMap, Mesh, Shape, Sphere, Transform, Vector
from ..model.geometry import angle_between, minus, norm
from .bodies import TURNS, Placed
from .printing import Printing, joined

_ROUND = ("cylinder", "capsule")


class Piece(NamedTuple):
    """A solid of a link: the link and its number there, the shape that says it, and the solid seen from some frame."""

    link: str
    number: int
    shape: Shape
    solid: Solid


def pieces_of(link: str, shapes: Sequence[Shape], printing: Printing, capsules: bool = True) -> list[Piece]:
    """Return the solids of a link in its own frame; without ``capsules`` they are cylinders of the same full length."""
    found: list[Piece] = []
    for whole in shapes:
        for shape in whole.solids():
            made = shape if capsules else _without_capsule(shape)
            found.append(Piece(link, len(found), whole, _solid(made, whole, printing)))
    return found


def _without_capsule(shape: Shape) -> Shape:
    geometry = shape.geometry
    if not isinstance(geometry, Capsule):
        return shape
    return replace(shape, geometry=Cylinder(geometry.radius, geometry.length + 2 * geometry.radius))


def _solid(shape: Shape, whole: Shape, printing: Printing) -> Solid:
    solid = solid_from(shape)
    if isinstance(shape.geometry, Mesh):
        name = shape.geometry.file.replace("\\", "/").rsplit("/", 1)[-1]
        solid = solid._replace(sizes=shape.geometry.scale, words=(name,))
    room = 3**0.5 * printing.room("xyz", *whole.pose.xyz) + _size_room(whole.geometry, printing)
    return solid._replace(room=room, turn_room=TURNS * printing.room("rpy", *whole.pose.rpy))


def _size_room(geometry: object, printing: Printing) -> float:
    if isinstance(geometry, Box):
        corners = max(printing.room("min", *geometry.lower), printing.room("max", *geometry.upper))
        return max(printing.room("size", *geometry.size), corners)
    if isinstance(geometry, (Cylinder, Capsule)):
        return max(printing.room("radius", geometry.radius), printing.room("length", geometry.length))
    if isinstance(geometry, Sphere):
        return printing.room("radius", geometry.radius)
    if isinstance(geometry, HeightMap):
        return printing.room("heights", *(z for line in geometry.heights for z in line[:1]))
    return 0.0


def seen(piece: Piece, place: Placed) -> Piece:
    """Return a solid seen from the frame that its link is placed in."""
    solid = piece.solid
    transform = place.transform.then(Transform(solid.rows, solid.centre))
    room = solid.room + place.length + place.angle * norm(solid.centre)
    moved = solid._replace(
        rows=transform.rows, centre=transform.xyz, room=room, turn_room=solid.turn_room + place.angle
    )
    return piece._replace(solid=moved)


class Matched(NamedTuple):
    """Solids of two sets: those that are in both, pair by pair, and those that only one of the two has."""

    pairs: list[tuple[Piece, Piece]]
    old: list[Piece]
    new: list[Piece]


def match(old: Sequence[Piece], new: Sequence[Piece], tolerance: float) -> Matched:
    """Return which solids of two sets are the same."""
    order = sorted(range(len(new)), key=lambda index: new[index].solid.centre[0])
    places = [new[index].solid.centre[0] for index in order]
    widest = max((piece.solid.room for piece in new), default=0.0)
    taken: set[int] = set()
    pairs, left = [], []
    for piece in old:
        x, reach = piece.solid.centre[0], tolerance + joined(piece.solid.room, widest) + widest
        first, last = bisect_left(places, x - reach), bisect_right(places, x + reach)
        near = (index for index in order[first:last] if index not in taken)
        twin = next((index for index in near if same(piece.solid, new[index].solid, tolerance)), None)
        if twin is None:
            left.append(piece)
        else:
            taken.add(twin)
            pairs.append((piece, new[twin]))
    return Matched(pairs, left, [piece for index, piece in enumerate(new) if index not in taken])


def same(one: Solid, other: Solid, tolerance: float) -> bool:
    """Say whether two solids, seen from the same frame, fill the same space as well as they are known."""
    if one.kind != other.kind or one.words != other.words or len(one.sizes) != len(other.sizes):
        return False
    room = tolerance + joined(one.room, other.room)
    if norm(minus(one.centre, other.centre)) > room:
        return False
    turn = 1e-9 + tolerance + joined(one.turn_room, other.turn_room)
    if one.kind == "box":
        return _same_box(one, other, room, turn)
    if any(abs(a - b) > room for a, b in zip(one.sizes, other.sizes, strict=True)):
        return False
    if one.kind in _ROUND:
        angle = angle_between(_axis(one), _axis(other))
        return min(angle, math.pi - angle) <= turn
    return one.kind == "sphere" or _same_rows(one, other, turn)


def _axis(solid: Solid) -> Vector:
    """Return the axis of a solid that is round about it: z of its own frame."""
    return (solid.rows[0][2], solid.rows[1][2], solid.rows[2][2])


def _same_rows(one: Solid, other: Solid, turn: float) -> bool:
    return all(abs(a - b) <= turn for r, s in zip(one.rows, other.rows, strict=True) for a, b in zip(r, s, strict=True))


def _same_box(one: Solid, other: Solid, room: float, turn: float) -> bool:
    """Say whether two boxes about the same middle have the same corners."""
    if _same_rows(one, other, turn):
        return all(abs(a - b) <= room for a, b in zip(one.sizes, other.sizes, strict=True))
    reach = 2 * (room + turn * norm((one.sizes[0], one.sizes[1], one.sizes[2])))
    corners = _corners(other)
    return all(any(norm(minus(corner, near)) <= reach for near in corners) for corner in _corners(one))


def _corners(solid: Solid) -> list[Vector]:
    """Return the eight corners of a box, seen from its middle."""
    a, b, c = (size / 2 for size in solid.sizes)
    turn = Transform(solid.rows)
    return [turn.rotate((x, y, z)) for x in (-a, a) for y in (-b, b) for z in (-c, c)]

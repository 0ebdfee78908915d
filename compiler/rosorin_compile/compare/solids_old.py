"""Solids: shapes as sets, because their numbers in an artifact mean nothing, and which of two sets are the same.

One box that falls into two moves all that follow it to other numbers; as sets, one solid is gone and two are new. Two
solids are the same if they fill the same space, however they are written, as well as they are known.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.formats import Value
from rosorin_compile.formats.facts import SIZES, Solid
from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Mesh, Shape, Sphere, Transform, Vector
from rosorin_compile.model.geometry import angle_between, minus, norm, plus, pose_of, rotation_of_rpy
from rosorin_compile.model.shape import ROWS, plain

from .tolerance import ROOT_THREE, TURNS, Placed, Printing, joined

_CENTRE = ("origin x", "origin y", "origin z")
_ANGLES = ("roll", "pitch", "yaw")
_LOWER, _UPPER = (tuple(f"box {end} {axis}" for axis in "xyz") for end in ("min", "max"))
_UPRIGHT = Transform().rows
# What the way through another frame costs a length (m) or a rotation entry.
_NOISE = 1e-9
_MANY = 500
_MOST_COLUMNS = 200_000


class Delta(NamedTuple):
    """How a set of solids differs from another: those that are only in the old one, and those only in the new one."""

    removed: tuple[Solid, ...]
    added: tuple[Solid, ...]


def solid_of(found: Mapping[str, Value]) -> Solid:
    """Return a solid from the facts about it, by quantity: "geometry", "origin x", "size x", or "box min x"."""
    if _LOWER[0] in found:
        return _box_of(found)
    values = {quantity: value for quantity, value in found.items() if isinstance(value.value, float)}
    kind = str(found["geometry"].value) if "geometry" in found else ""
    sizes = [float(values[size].value) for size in SIZES.get(kind, ()) if size in values]
    x, y, z = (float(values[quantity].value) if quantity in values else 0.0 for quantity in _CENTRE)
    rpy = [float(values[angle].value) if angle in values else 0.0 for angle in _ANGLES]
    known = {"geometry", *SIZES.get(kind, ()), *_CENTRE, *_ANGLES}
    words = tuple(f"{quantity} {found[quantity].value}" for quantity in sorted(found) if quantity not in known)
    lengths = [values[quantity].tolerance for quantity in SIZES.get(kind, ()) if quantity in values]
    lengths += [ROOT_THREE * values[quantity].tolerance for quantity in _CENTRE if quantity in values]
    turns = [values[angle].tolerance for angle in _ANGLES if angle in values]
    rows = rotation_of_rpy((rpy[0], rpy[1], rpy[2])) if any(rpy) else _UPRIGHT
    solid = Solid(kind, tuple(sizes), (x, y, z), rows, words, max(lengths, default=0.0), sum(turns))
    return straight(solid)


def straight(solid: Solid) -> Solid:
    """Return a box that quarter turns brought along the axes as one without rotation; all else as it is."""
    shape = shape_of(solid) if solid.kind == "box" and solid.rows != _UPRIGHT else None
    if shape is None:
        return solid
    upright = solid_from(shape)
    return solid._replace(sizes=upright.sizes, centre=upright.centre, rows=upright.rows)


def _box_of(found: Mapping[str, Value]) -> Solid:
    lower, upper = ([found.get(q, Value(0.0)) for q in quantities] for quantities in (_LOWER, _UPPER))
    a, b, c = (float(value.value) for value in lower)
    d, e, f = (float(value.value) for value in upper)
    box = Box((a, b, c), (d, e, f))
    return Solid("box", box.size, box.centre, _UPRIGHT, (), max(value.tolerance for value in (*lower, *upper)))


def shape_of(solid: Solid) -> Shape | None:
    """Return a solid as a shape of the model; None for a mesh, whose size no artifact says."""
    place = pose_of(Transform(solid.rows, solid.centre))
    if solid.kind == "box" and len(solid.sizes) == 3:
        x, y, z = (size / 2 for size in solid.sizes)
        return Shape(Box((-x, -y, -z), (x, y, z)), place)
    if solid.kind in ("cylinder", "capsule") and len(solid.sizes) == 2:
        radius, length = solid.sizes
        return Shape(Cylinder(radius, length) if solid.kind == "cylinder" else Capsule(radius, length), place)
    if solid.kind == "ellipsoid" and len(solid.sizes) == 3:
        x, y, z = (size / 2 for size in solid.sizes)
        return Shape(Ellipsoid((x, y, z)), place)
    return Shape(Sphere(solid.sizes[0]), place) if solid.kind == "sphere" and solid.sizes else None


CAPSULE = "capsule"


def as_cylinder(solid: Solid) -> Solid:
    """Return a capsule as a cylinder of the same full length, as formats without one have it; all else as it is."""
    if solid.kind != CAPSULE:
        return solid
    radius, length = solid.sizes
    return solid._replace(kind="cylinder", sizes=(radius, length + 2 * radius))


def solid_from(shape: Shape, tolerance: float = 0.0) -> Solid:
    """Return a shape of the model as a solid; ``tolerance``: how well its numbers are known (m, rotation entries)."""
    geometry, pose, sizes = shape.geometry, shape.pose, tuple[float, ...]()
    if pose.rpy != (0.0, 0.0, 0.0):
        shape = shape.in_link
        geometry, pose = shape.geometry, shape.origin()
    elif isinstance(geometry, Box):
        box = Box(plus(geometry.lower, pose.xyz), plus(geometry.upper, pose.xyz))
        return Solid("box", box.size, box.centre, _UPRIGHT, (), tolerance, tolerance)
    if isinstance(geometry, Box):
        sizes = geometry.size
    elif isinstance(geometry, (Cylinder, Capsule)):
        sizes = (geometry.radius, geometry.length)
    elif isinstance(geometry, Sphere):
        sizes = (geometry.radius,)
    elif isinstance(geometry, Ellipsoid):
        x, y, z = geometry.radii
        sizes = (2 * x, 2 * y, 2 * z)
    elif isinstance(geometry, Mesh):
        sizes = geometry.scale
    rows = rotation_of_rpy(pose.rpy)
    return Solid(type(geometry).__name__.lower(), sizes, pose.xyz, rows, (), tolerance, tolerance)


class Matched(NamedTuple):
    """Solids of two sets by their places there: those that are in both, pair by pair, and what only one of them has."""

    pairs: list[tuple[int, int]]
    old: list[int]
    new: list[int]


def match(old: Sequence[Solid], new: Sequence[Solid], noise: float = 0.0) -> Matched:
    """Return which solids of two sets are the same; ``noise`` (m, and rotation entries) is no difference."""
    twins: dict[Solid, list[int]] = {}
    for index in reversed(range(len(new))):
        twins.setdefault(new[index], []).append(index)
    pairs = [(index, twins[solid].pop()) for index, solid in enumerate(old) if twins.get(solid)]
    # The others are looked for among neighbours: a large height map makes thousands of boxes.
    known = {index for index, _ in pairs}
    order = sorted((index for rest in twins.values() for index in rest), key=lambda index: new[index].centre)
    places = [new[index].centre[0] for index in order]
    widest = max((new[index].tolerance for index in order), default=0.0)
    taken: set[int] = set()
    left = []
    for index, solid in enumerate(old):
        if index in known:
            continue
        x, reach = solid.centre[0], noise + joined(solid.tolerance, widest)
        near = order[bisect_left(places, x - reach) : bisect_right(places, x + reach)]
        twin = next((other for other in near if other not in taken and same(solid, new[other], noise)), None)
        if twin is None:
            left.append(index)
        else:
            taken.add(twin)
            pairs.append((index, twin))
    return Matched(sorted(pairs), left, sorted(index for index in order if index not in taken))


def delta(old: Sequence[Solid], new: Sequence[Solid]) -> Delta:
    """Return how two sets of solids that one writer printed differ."""
    return _delta(old, new, 0.0)


def remainder(whole: Sequence[Solid], part: Sequence[Solid]) -> Delta:
    """Return how two sets of solids differ as far as different writers print them."""
    return _delta(whole, part, _NOISE)


def _delta(old: Sequence[Solid], new: Sequence[Solid], noise: float) -> Delta:
    rest = match(old, new, noise)
    return Delta(tuple(old[index] for index in rest.old), tuple(new[index] for index in rest.new))


def same_set(one: Sequence[Solid], other: Sequence[Solid]) -> bool:
    """Say whether two writers mean the same solids, as far as they print them."""
    if len(one) != len(other):
        return False
    if all(same(a, b, _NOISE) for a, b in zip(one, other, strict=True)):  # in one order, as a rule
        return True
    return remainder(one, other) == Delta((), ())


def same_bodies(one: Sequence[Solid], other: Sequence[Solid]) -> bool:
    """Say whether two writers mean the same solids, though boxes may be cut otherwise."""
    if same_set(one, other):
        return True
    rest = remainder(one, other)
    return bool(rest.removed and rest.added) and same_space(rest.removed, rest.added, _NOISE)


def same_space(one: Sequence[Solid], other: Sequence[Solid], noise: float) -> bool:
    """Say whether two sets of boxes along the axes of one frame fill the same space, cut as they may be."""
    boxes = [[solid.box for solid in solids] for solids in (one, other)]
    known = [[box for box in found if box is not None] for found in boxes]
    if known != boxes or not all(known):
        return False
    tolerances = (max(solid.tolerance for solid in solids) for solids in (one, other))
    near = noise + _NOISE + joined(*tolerances)
    every = [box for found in known for box in found]
    xs, ys = (_marks((corner[axis] for box in every for corner in (box.lower, box.upper)), near) for axis in (0, 1))
    if len(xs) * len(ys) > _MOST_COLUMNS:
        return False
    first, second = (_columns(found, xs, ys, near) for found in known)
    return first.keys() == second.keys() and all(_same_column(first[at], second[at], near) for at in first)


def _same_column(one: Sequence[tuple[float, float]], other: Sequence[tuple[float, float]], near: float) -> bool:
    pairs = zip(one, other, strict=False)
    return len(one) == len(other) and all(abs(a - c) <= near and abs(b - d) <= near for (a, b), (c, d) in pairs)


def _marks(numbers: Iterable[float], near: float) -> list[float]:
    """Return where boxes begin and end along an axis; what is as good as the same once."""
    marks: list[float] = []
    for number in sorted(numbers):
        if not marks or number - marks[-1] > near:
            marks.append(number)
    return marks


def _columns(
    boxes: Sequence[Box], xs: Sequence[float], ys: Sequence[float], near: float
) -> dict[tuple[int, int], list[tuple[float, float]]]:
    """Return, for each column between the marks along x and y, the ranges of z that boxes fill."""
    filled: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for box in sorted(boxes, key=lambda box: box.lower[2]):
        (a, b, low), (c, d, high) = box.lower, box.upper
        across = range(bisect_right(ys, b) - 1, bisect_right(ys, d) - 1)
        for i in range(bisect_right(xs, a) - 1, bisect_right(xs, c) - 1):
            for j in across:
                column = filled.setdefault((i, j), [])
                if column and low - column[-1][1] <= near:
                    column[-1] = (column[-1][0], max(column[-1][1], high))
                else:
                    column.append((low, high))
    return filled


def largest_step(difference: Delta) -> float | None:
    """Return by how much solids changed at most (m), each new one held against the nearest old one.

    Of very many, each is held against the one in its place. None if a solid became another kind of solid, or only
    turned, which no length says.
    """
    old, largest = list(difference.removed), 0.0
    many = len(old) > _MANY
    for solid in difference.added[: len(old)]:
        steps = [_step(solid, other) for other in (old[:1] if many else old)]
        nearest = min(range(len(steps)), key=lambda index: steps[index])
        if steps[nearest] in (0.0, float("inf")):
            return None
        largest = max(largest, steps[nearest])
        old.pop(nearest)
    return largest or None


def _step(one: Solid, other: Solid) -> float:
    """Return how far a face moved at most (m), if the solid is a box; of others how far middle and size changed."""
    if one.kind != other.kind or len(one.sizes) != len(other.sizes):
        return float("inf")
    lengths = zip(one.sizes, other.sizes, strict=True) if one.kind != "mesh" else ()
    sizes = [abs(a - b) / 2 for a, b in lengths]
    centre = [abs(a - b) for a, b in zip(one.centre, other.centre, strict=True)]
    if one.kind == "box":
        return max(a + b for a, b in zip(sizes, centre, strict=True))
    return max([2 * size for size in sizes] + centre)


_ROUND = ("cylinder", "capsule")


class Piece(NamedTuple):
    """A solid of a link: the link and its number there, the shape that says it, and the solid seen from some frame."""

    link: str
    number: int
    shape: Shape
    solid: Solid


def pieces_of(
    link: str, shapes: Sequence[Shape], printing: Printing, capsules: bool = True, form: str = ROWS
) -> list[Piece]:
    """Return the solids of a link in its own frame; without ``capsules`` as a URDF 1.0 has them.

    ``form`` is how height maps are cut into boxes.
    """
    found: list[Piece] = []
    for whole in shapes:
        for shape in whole.solids(form):
            made = shape if capsules else replace(shape, geometry=plain(shape.geometry))
            found.append(Piece(link, len(found), whole, _solid(made, whole, printing)))
    return found


def _solid(shape: Shape, whole: Shape, printing: Printing) -> Solid:
    solid = solid_from(shape)
    if isinstance(shape.geometry, Mesh):
        name = shape.geometry.file.replace("\\", "/").rsplit("/", 1)[-1]
        solid = solid._replace(words=(f"file {name}",))
    length = ROOT_THREE * printing.tolerance("xyz", *whole.pose.xyz) + _size_tolerance(whole.geometry, printing)
    turn = _NOISE + TURNS * printing.tolerance("rpy", *whole.pose.rpy)
    return solid._replace(tolerance=length, turn_tolerance=turn)


def _size_tolerance(geometry: object, printing: Printing) -> float:
    if isinstance(geometry, Box):
        corners = max(printing.tolerance("min", *geometry.lower), printing.tolerance("max", *geometry.upper))
        return max(printing.tolerance("size", *geometry.size), corners)
    if isinstance(geometry, (Cylinder, Capsule)):
        return max(printing.tolerance("radius", geometry.radius), printing.tolerance("length", geometry.length))
    if isinstance(geometry, Sphere):
        return printing.tolerance("radius", geometry.radius)
    if isinstance(geometry, HeightMap):
        return printing.tolerance("heights", *(z for line in geometry.heights for z in line[:1]))
    return 0.0


def seen(piece: Piece, place: Placed) -> Piece:
    """Return a solid seen from the frame that its link is placed in."""
    solid = piece.solid
    transform = place.transform.then(Transform(solid.rows, solid.centre))
    length, turn = solid.tolerance + place.length + place.angle * norm(solid.centre), solid.turn_tolerance + place.angle
    return piece._replace(
        solid=Solid(solid.kind, solid.sizes, transform.xyz, transform.rows, solid.words, length, turn)
    )


def same(one: Solid, other: Solid, noise: float) -> bool:
    """Say whether two solids, seen from the same frame, fill the same space as well as they are known."""
    if one[:5] == other[:5]:  # but for how well that is known
        return True
    if one.kind != other.kind or one.words != other.words or len(one.sizes) != len(other.sizes):
        return False
    length = noise + joined(one.tolerance, other.tolerance)
    if one.centre != other.centre and norm(minus(one.centre, other.centre)) > length:
        return False
    turn = noise + joined(one.turn_tolerance, other.turn_tolerance)
    if one.kind == "box":
        return _same_box(one, other, length, turn)
    if any(abs(a - b) > length for a, b in zip(one.sizes, other.sizes, strict=True)):
        return False
    if one.kind in _ROUND:
        angle = angle_between(_axis(one), _axis(other))
        return min(angle, math.pi - angle) <= turn
    return one.kind == "sphere" or _same_rows(one, other, turn)


def _axis(solid: Solid) -> Vector:
    """Return the axis of a solid that is round about it: z of its own frame."""
    return (solid.rows[0][2], solid.rows[1][2], solid.rows[2][2])


def turned_by(one: Solid, other: Solid) -> float:
    """Return how far a solid is turned against another one (rad); what is round about its axis has no angle there."""
    if one.kind == other.kind == "sphere":
        return 0.0
    if one.kind == other.kind and one.kind in _ROUND:
        angle = angle_between(_axis(one), _axis(other))
        return min(angle, math.pi - angle)
    return Transform(one.rows).angle_to(Transform(other.rows))


def _same_rows(one: Solid, other: Solid, turn: float) -> bool:
    if one.rows == other.rows:
        return True
    return all(abs(a - b) <= turn for r, s in zip(one.rows, other.rows, strict=True) for a, b in zip(r, s, strict=True))


def _same_box(one: Solid, other: Solid, length: float, turn: float) -> bool:
    """Say whether two boxes about the same middle have the same corners."""
    if _same_rows(one, other, turn):
        return all(abs(a - b) <= length for a, b in zip(one.sizes, other.sizes, strict=True))
    reach = 2 * (length + turn * norm((one.sizes[0], one.sizes[1], one.sizes[2])))
    corners = _corners(other)
    return all(any(norm(minus(corner, near)) <= reach for near in corners) for corner in _corners(one))


def _corners(solid: Solid) -> list[Vector]:
    """Return the eight corners of a box, seen from its middle."""
    a, b, c = (size / 2 for size in solid.sizes)
    turn = Transform(solid.rows)
    return [turn.rotate((x, y, z)) for x in (-a, a) for y in (-b, b) for z in (-c, c)]

"""Compare unordered sets of solids: two solids are equal if they fill the same space within their rounding errors."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Sequence
from itertools import chain, product
from typing import NamedTuple

from rosorin_compile.model import Box, Ellipsoid, Mesh, Shape, Transform, Vector
from rosorin_compile.model.geometry import Rows, angle_between, minus, norm, plus, rotation_of_rpy
from rosorin_compile.model.shape import Rgba

from .precision import POSE_NOISE, ROOT_THREE, TURNS, Precision, RoundedTransform, exact, join_errors
from .sentences import text_of

# Names of the sizes of each kind of solid: full lengths (m) and radii (m) as in URDF, or scale factors of a mesh.
SIZES = {
    "box": ("size x", "size y", "size z"),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("size x", "size y", "size z"),
    "mesh": ("scale x", "scale y", "scale z"),
}
ROUND = ("cylinder", "capsule")
_UPRIGHT = Transform().rows
_MOST_CELLS = 500_000


class Solid(NamedTuple):
    """A geometric shape in the frame of its link, with its colour and names."""

    kind: str
    sizes: tuple[float, ...]  # see ``SIZES``
    centre: Vector  # m
    rows: Rows  # rotation matrix
    words: tuple[str, ...] = ()  # names and other attributes, such as "name skin" or "file a.stl"
    rgba: Rgba | None = None
    tolerance: float = 0.0  # largest error of sizes and centre (m)
    turn_tolerance: float = 0.0  # largest error of an entry of the rotation matrix
    colour_tolerance: float = 0.0  # largest error of a colour component

    @property
    def box(self) -> Box | None:
        """The box in the frame of its link, or None if the solid is rotated or is not a box."""
        if self.kind != "box" or self.rows != _UPRIGHT:
            return None
        half = tuple(size / 2 for size in self.sizes)
        return Box(minus(self.centre, half), plus(self.centre, half))  # type: ignore[arg-type]

    @property
    def as_cylinder(self) -> "Solid":
        """The solid itself, or a cylinder of the same radius and overall length if the solid is a capsule."""
        if self.kind != "capsule":
            return self
        radius, length = self.sizes
        return self._replace(kind="cylinder", sizes=(radius, length + 2 * radius))

    def seen_from(self, place: RoundedTransform) -> "Solid":
        """Transform the solid to a frame in which its link has the pose ``place``."""
        transform = place.transform.then(Transform(self.rows, self.centre))
        length, turn = place.length + place.angle * norm(self.centre), self.turn_tolerance + place.angle
        known = self.tolerance + length
        return self._replace(centre=transform.xyz, rows=transform.rows, tolerance=known, turn_tolerance=turn)


def solid_of(shape: Shape, precision: Precision = exact, share: float = 2.0) -> Solid:
    """Convert a shape other than a height map to a solid. Its tolerance includes ``share`` times the error of sizes."""
    placed = shape.in_link if isinstance(shape.geometry, Box) and shape.pose.rpy != (0.0, 0.0, 0.0) else shape
    geometry, origin = placed.geometry, placed.origin()
    kind = type(geometry).__name__.lower()
    if isinstance(geometry, (Box, Mesh)):
        sizes: tuple[float, ...] = geometry.size if isinstance(geometry, Box) else geometry.scale
    elif isinstance(geometry, Ellipsoid):
        sizes = tuple(2 * radius for radius in geometry.radii)
    else:
        sizes = tuple(getattr(geometry, name) for name in SIZES[kind])
    key = SIZES[kind][-1].split(" ")[0]  # "size", "scale", "length" or "radius"
    length = max(ROOT_THREE * precision("xyz", *shape.pose.xyz), share * precision(key, *sizes))
    turn = POSE_NOISE + TURNS * precision("rpy", *shape.pose.rpy)
    tint = precision("rgba", *shape.rgba) if shape.rgba else 0.0
    return Solid(kind, sizes, origin.xyz, rotation_of_rpy(origin.rpy), _words(shape), shape.rgba, length, turn, tint)


def _words(shape: Shape) -> tuple[str, ...]:
    words = [f"{word} {text}" for word in ("material", "name", "texture") if (text := getattr(shape, word))]
    if not (shape.urdf_elements or shape.contact or shape.mjcf or isinstance(shape.geometry, Mesh)):
        return tuple(words)
    words += [f"file {shape.geometry.file}"] if isinstance(shape.geometry, Mesh) else []
    words += [f"element {' '.join(text.split())}" for text in shape.urdf_elements]
    values = [*(shape.contact.values if shape.contact else {}).items(), *shape.mjcf.items()]
    return tuple(sorted([*words, *(f"{word} {text_of(value)}" for word, value in values)]))


class Matches(NamedTuple):
    """The result of matching two sets of solids: index pairs of equal solids, and indices of unmatched solids."""

    pairs: list[tuple[int, int]]
    old: list[int]
    new: list[int]


def match(old: Sequence[Solid], new: Sequence[Solid], noise: float = POSE_NOISE) -> Matches:
    """Match equal solids of two sets, ignoring differences up to ``noise`` (m, or entries of a rotation matrix)."""
    twins: dict[Solid, list[int]] = {}
    for index in reversed(range(len(new))):
        twins.setdefault(new[index], []).append(index)
    pairs = [(index, twins[solid].pop()) for index, solid in enumerate(old) if twins.get(solid)]
    # Compare the remaining solids only with nearby solids, because a large height map has thousands of boxes.
    known = {index for index, _ in pairs}
    order = sorted((index for rest in twins.values() for index in rest), key=lambda index: new[index].centre)
    places = [new[index].centre[0] for index in order]
    widest = max((new[index].tolerance for index in order), default=0.0)
    taken: dict[int, int] = {}
    for index, solid in enumerate(old):
        x, reach = solid.centre[0], noise + join_errors(solid.tolerance, widest)
        near = () if index in known else order[bisect_left(places, x - reach) : bisect_right(places, x + reach)]
        twin = next((other for other in near if other not in taken and same(solid, new[other], noise)), None)
        if twin is not None:
            taken[twin] = index
    pairs = sorted([*pairs, *((index, twin) for twin, index in taken.items())])
    left = sorted({*range(len(old))} - {index for index, _ in pairs})
    return Matches(pairs, left, sorted(index for index in order if index not in taken))


def same(one: Solid, other: Solid, noise: float) -> bool:
    """Return True if two solids have equal colours and names, and fill the same space within ``noise`` and rounding."""
    if one[:6] == other[:6]:
        return True
    tint = noise + join_errors(one.colour_tolerance, other.colour_tolerance)
    if one.kind != other.kind or one.words != other.words or not same_colour(one.rgba, other.rgba, tint):
        return False
    length = noise + join_errors(one.tolerance, other.tolerance)
    turn = noise + join_errors(one.turn_tolerance, other.turn_tolerance)
    if math.dist(one.centre, other.centre) > length:
        return False
    entries = zip(chain(*one.rows), chain(*other.rows), strict=True)
    is_turned = one.rows != other.rows and any(abs(a - b) > turn for a, b in entries)
    same_sizes = all(abs(a - b) <= length for a, b in zip(one.sizes, other.sizes, strict=True))
    if one.kind == "sphere" or not is_turned:
        return same_sizes
    if one.kind == "box":  # a box that is rotated by 90 deg is equal if its sizes are swapped
        turn = length + turn * norm((one.sizes[0], one.sizes[1], one.sizes[2]))
    elif one.kind not in ROUND or not same_sizes:
        return False
    points = _points(other)
    return all(any(math.dist(point, near) <= turn for near in points) for point in _points(one))


def same_colour(one: Rgba | None, other: Rgba | None, least: float) -> bool:
    """Return True if two colours differ by at most ``least`` in each component, or if neither is set."""
    if one is None or other is None or one == other:
        return one == other
    return all(abs(a - b) <= least for a, b in zip(one, other, strict=True))


def _points(solid: Solid) -> list[Vector]:
    """Return the corners of a box relative to its centre, or the ends of the axis of any other solid."""
    turn = Transform(solid.rows)
    if solid.kind == "box":
        a, b, c = (size / 2 for size in solid.sizes)
        return [turn.rotate((x, y, z)) for x in (-a, a) for y in (-b, b) for z in (-c, c)]
    return [turn.rotate((0.0, 0.0, end)) for end in (-1.0, 1.0)]


def turned_by(one: Solid, other: Solid) -> float:
    """Return the angle (rad) between two solids; the rotation of a round solid about its axis is ignored."""
    if one.kind == other.kind == "sphere":
        return 0.0
    if one.kind == other.kind and one.kind in ROUND:
        angle = angle_between(_points(one)[1], _points(other)[1])
        return min(angle, math.pi - angle)
    return Transform(one.rows).angle_to(Transform(other.rows))


def same_space(one: Sequence[Solid], other: Sequence[Solid], noise: float = POSE_NOISE) -> bool:
    """Return True if two sets of axis-aligned boxes fill the same space, even if they divide it differently."""
    first, second = ([box for solid in solids if (box := solid.box) is not None] for solids in (one, other))
    if not first or not second or len(first) != len(one) or len(second) != len(other):
        return False
    near = noise + POSE_NOISE + join_errors(*(max(solid.tolerance for solid in solids) for solids in (one, other)))
    marks: list[list[float]] = []  # sorted coordinates of all box faces, for each axis
    for axis in range(3):
        ends = sorted(corner[axis] for box in (*first, *second) for corner in (box.lower, box.upper))
        marks.append([end for at, end in enumerate(ends) if not at or end - ends[at - 1] > near])
    if math.prod(map(len, marks)) > _MOST_CELLS:
        return False
    filled: list[set[tuple[int, ...]]] = [set(), set()]
    for boxes, cells in zip((first, second), filled, strict=True):
        for box in boxes:
            sides = zip(marks, box.lower, box.upper, strict=True)
            cells.update(product(*(range(bisect_right(m, a + near), bisect_right(m, b + near)) for m, a, b in sides)))
    return filled[0] == filled[1]


def largest_step(pairs: Iterable[tuple[Solid, Solid]]) -> float | None:
    """Return the largest change (m) of faces, centres and sizes, or None if a solid has a new kind or only rotated."""
    largest = 0.0
    for one, other in pairs:
        if one.kind != other.kind:
            return None
        share = {"box": 0.5, "mesh": 0.0}.get(one.kind, 1.0)
        sizes = [share * abs(a - b) for a, b in zip(one.sizes, other.sizes, strict=True)]
        centre = [abs(a - b) for a, b in zip(one.centre, other.centre, strict=True)]
        steps = [a + b for a, b in zip(sizes, centre, strict=True)] if one.kind == "box" else [*sizes, *centre]
        if not max(steps):
            return None
        largest = max(largest, *steps)
    return largest or None

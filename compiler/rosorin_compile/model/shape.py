"""Visual and collision shapes of links. Sizes are full extents and full lengths in metres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from itertools import product

from .geometry import IDENTITY, Pose, Transform, Vector, minus, pose_of
from .simulation import Contact, Values


@dataclass(frozen=True)
class Box:
    """An axis-aligned box between two corners (metres)."""

    lower: Vector
    upper: Vector

    @property
    def centre(self) -> Vector:
        a, b = self.lower, self.upper
        return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2)

    @property
    def size(self) -> Vector:
        return minus(self.upper, self.lower)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z with its centre at the origin."""

    radius: float
    length: float


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with a half sphere on each end; ``length`` excludes the half spheres."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere around the origin."""

    radius: float


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid around the origin; ``radii`` are half its extents along x, y and z."""

    radii: Vector


@dataclass(frozen=True)
class Mesh:
    """A mesh file, referred to by name. Its coordinates multiplied by ``scale`` are in metres."""

    file: str
    scale: Vector = (1.0, 1.0, 1.0)
    inertia: str = field(default="", compare=False)  # MuJoCo's "inertia" of the mesh ("shell", ...), or "" for default
    mjcf: Values = field(default_factory=dict, compare=False)  # other MuJoCo attributes of the mesh


# How to divide a height map into boxes: the values of the parameter ``form``.
ROWS = "rows"  # one box for each run of cells with the same height in a row (constant x)
MERGED = "merged"  # one box for each rectangle of cells with the same height, so fewer boxes
GROUNDED = "grounded"  # like ROWS, but each box extends down to z = 0, even if its bottom is higher


@dataclass(frozen=True)
class HeightMap:
    """A body defined by heights (m) above z = 0 on a grid of square cells; cells with height 0 are empty.

    ``heights[i][j]`` covers x from ``origin[0] + i * cell`` and y from ``origin[1] + j * cell``. The tops of boxes are
    rounded up to multiples of ``step``. ``bottom`` is the lower end of the body (m): a number for all cells, or a grid
    like ``heights``, rounded down to multiples of ``step``. A cell whose bottom is not below its height is empty.
    """

    origin: tuple[float, float]
    cell: float
    heights: tuple[tuple[float, ...], ...]
    step: float
    method: str = ""
    bottom: float | tuple[tuple[float, ...], ...] = 0.0

    def bottom_of(self, i: int, j: int) -> float:
        return self.bottom if isinstance(self.bottom, (int, float)) else self.bottom[i][j]

    def boxes(self, form: str = ROWS) -> tuple[Box, ...]:
        """Return boxes that fill the height map; ``form`` is ROWS, MERGED or GROUNDED."""
        if form not in self._boxes:
            layer = cache(partial(self._layer, form))  # many cells are alike
            rows = enumerate(self.heights)
            layers = [[layer(height, self.bottom_of(i, j)) for j, height in enumerate(row)] for i, row in rows]
            boxes = _rectangles(layers, grow=form == MERGED)
            if form == MERGED:  # merging along y first may result in fewer boxes
                turned = _rectangles(list(zip(*layers, strict=True)), grow=True)
                if len(turned) < len(boxes):
                    boxes = [(left, top, right, under, layer) for top, left, under, right, layer in turned]
                boxes.sort()
            (x, y), c = self.origin, self.cell
            self._boxes[form] = tuple(
                Box((x + top * c, y + left * c, low), (x + under * c, y + right * c, high))
                for top, left, under, right, (low, high) in boxes
            )
        return self._boxes[form]

    @cached_property
    def _boxes(self) -> dict[str, tuple[Box, ...]]:
        return {}

    def _layer(self, form: str, height: float, bottom: float) -> tuple[float, float] | None:
        if height <= 0:
            return None
        high = round(math.ceil(height / self.step - 1e-6) * self.step, 12)  # a rounding error must not add a step
        if form == GROUNDED:
            return 0.0, high
        is_grid = not isinstance(self.bottom, (int, float))
        low = round(math.floor(bottom / self.step + 1e-6) * self.step, 12) if is_grid else bottom
        return (low, high) if low < high and height > bottom else None


_Layer = tuple[float, float]
_Rectangle = tuple[int, int, int, int, _Layer]  # first row, first column, row after the last, column after the last


def _rectangles(cells: Sequence[Sequence[_Layer | None]], grow: bool) -> list[_Rectangle]:
    """Merge equal cells of each row into rectangles; ``grow`` extends these over equal cells of the next rows."""
    free = {(i, j): value for i, row in enumerate(cells) for j, value in enumerate(row) if value is not None}
    made: list[_Rectangle] = []
    for i, left in list(free):
        value = free.get((i, left))
        if value is None:
            continue
        right, under = left + 1, i + 1
        while free.get((i, right)) == value:
            right += 1
        while grow and all(free.get((under, j)) == value for j in range(left, right)):
            under += 1
        for cell in product(range(i, under), range(left, right)):
            del free[cell]
        made.append((i, left, under, right, value))
    return made


Geometry = Box | Cylinder | Capsule | Sphere | Ellipsoid | Mesh | HeightMap


def plain(geometry: Geometry) -> Geometry:
    """Replace a geometry that URDF 1.0 lacks: a capsule with a cylinder, an ellipsoid with a box."""
    if isinstance(geometry, Capsule):
        return Cylinder(geometry.radius, geometry.length + 2 * geometry.radius)
    if isinstance(geometry, Ellipsoid):
        x, y, z = geometry.radii
        return Box((-x, -y, -z), (x, y, z))
    return geometry


Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Material:
    """A surface material: its colour (red, green, blue, opacity; each 0 to 1) and the name of a texture image."""

    name: str
    rgba: Rgba | None = None
    texture: str = ""
    mjcf: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Shape:
    """A geometry and its pose in the link frame."""

    geometry: Geometry
    pose: Pose = IDENTITY
    name: str = ""
    rgba: Rgba | None = None  # only for visuals, like ``texture`` and ``material``
    material: str = ""
    stand_in: str = field(default="", compare=False)
    texture: str = ""
    urdf_elements: tuple[str, ...] = ()  # XML elements that are added to the shape in the URDF
    contact: Contact | None = None  # only for simulations
    mjcf: Values = field(default_factory=dict, hash=False)  # only for simulations

    def solids(self, form: str = ROWS) -> tuple[Shape, ...]:
        """Return the boxes of a height map as shapes NAME_1, NAME_2, ..., or the shape itself otherwise."""
        if not isinstance(self.geometry, HeightMap):
            return (self,)
        if form not in self._solids:
            boxes, start = enumerate(self.geometry.boxes(form), 1), f"{self.name}_" if self.name else ""
            self._solids[form] = tuple(replace(self, geometry=b, name=start and f"{start}{n}") for n, b in boxes)
        return self._solids[form]

    @cached_property
    def _solids(self) -> dict[str, tuple[Shape, ...]]:
        return {}

    @property
    def volume(self) -> float:
        """The volume in m^3. Raises ValueError for a mesh."""
        return math.fsum(volume_and_moments(solid.geometry)[0] for solid in self.solids())

    @cached_property  # cached, because links may share shapes
    def in_link(self) -> Shape:
        """The same shape, but a box that is rotated by quarter turns becomes a box without a rotation."""
        return self.move(Transform())

    def drawn_shapes(self) -> tuple[Shape, ...]:
        """Return the shapes to draw: a height map with a bottom above 0 becomes boxes or a raised height map."""
        grid = self.geometry
        if not isinstance(grid, HeightMap) or not grid.bottom:
            return (self,)
        if not isinstance(grid.bottom, (int, float)):
            return self.solids(MERGED)
        heights = tuple(tuple(height - grid.bottom if height > 0 else 0.0 for height in row) for row in grid.heights)
        lifted = Pose(self.pose.transform().apply((0.0, 0.0, grid.bottom)), self.pose.rpy)
        return (replace(self, geometry=replace(grid, heights=heights, bottom=0.0), pose=lifted),)

    def origin(self) -> Pose:
        """Return the pose of the geometry's centre in the link frame."""
        if not isinstance(self.geometry, Box) or (centre := self.geometry.centre) == (0.0, 0.0, 0.0):
            return self.pose
        return Pose(self.pose.transform().apply(centre), self.pose.rpy)

    def move(self, transform: Transform) -> Shape:
        """Transform the shape to a parent frame; a box rotated by quarter turns becomes a box without a rotation."""
        placed = transform.then(self.pose.transform())
        is_quarter_turn = all(abs(c) < 1e-12 or abs(abs(c) - 1) < 1e-12 for row in placed.rows for c in row)
        if isinstance(self.geometry, Box) and is_quarter_turn:
            a, b = placed.apply(self.geometry.lower), placed.apply(self.geometry.upper)
            lower = (min(a[0], b[0]), min(a[1], b[1]), min(a[2], b[2]))
            upper = (max(a[0], b[0]), max(a[1], b[1]), max(a[2], b[2]))
            return replace(self, geometry=Box(lower, upper), pose=IDENTITY)
        return replace(self, pose=pose_of(placed))


def volume_and_moments(geometry: Geometry) -> tuple[float, Vector]:
    """Return the volume (m^3) of a solid and its moments of inertia about its centre for a mass of 1 kg (kg*m^2).

    From D. Halliday, R. Resnick, "Fundamentals of Physics", table "Some rotational inertias". A capsule is a cylinder
    and two half spheres, whose centres are 3/8 of the radius from the flat sides. Raises ValueError for a mesh.
    """
    if isinstance(geometry, Box):
        x, y, z = geometry.size
        return x * y * z, ((y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12)
    if isinstance(geometry, Sphere):
        moment = 2 / 5 * geometry.radius**2
        return 4 / 3 * math.pi * geometry.radius**3, (moment, moment, moment)
    if isinstance(geometry, Cylinder):
        r, length = geometry.radius, geometry.length
        across = (3 * r * r + length * length) / 12
        return math.pi * r * r * length, (across, across, r * r / 2)
    if isinstance(geometry, Capsule):
        r, length = geometry.radius, geometry.length
        tube, ends = math.pi * r * r * length, 4 / 3 * math.pi * r**3
        volume = tube + ends
        along = (tube * r * r / 2 + ends * 2 / 5 * r * r) / volume
        # Half sphere: 2/5 r^2 about its flat side, moved to the centre of the capsule by the parallel axis theorem.
        end = 2 / 5 * r * r + length * length / 4 + 3 / 8 * r * length
        across = (tube * (3 * r * r + length * length) / 12 + ends * end) / volume
        return volume, (across, across, along)
    if isinstance(geometry, Ellipsoid):
        x, y, z = (radius * radius for radius in geometry.radii)
        return 4 / 3 * math.pi * math.prod(geometry.radii), ((y + z) / 5, (x + z) / 5, (x + y) / 5)
    raise ValueError("the volume of a mesh is not known")

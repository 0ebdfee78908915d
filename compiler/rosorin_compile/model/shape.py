"""Shapes: what a link looks like and what it collides with. Sizes in metres, full extents and full lengths."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count

from .geometry import IDENTITY, Pose, Transform, Vector, pose_of
from .simulation import Contact, Values


@dataclass(frozen=True)
class Box:
    """An axis-aligned box between two corners (metres)."""

    lower: Vector
    upper: Vector

    @property
    def centre(self) -> Vector:
        """The middle of the box."""
        a, b = self.lower, self.upper
        return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2)

    @property
    def size(self) -> Vector:
        """The full extents along x, y and z."""
        a, b = self.lower, self.upper
        return (b[0] - a[0], b[1] - a[1], b[2] - a[2])


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, its middle at the origin."""

    radius: float
    length: float


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with a half sphere on each end; ``length`` is that of the cylinder part."""

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
    """A mesh file by reference, in the units of the file times ``scale``.

    ``inertia`` is what MuJoCo takes it for (shell, ...); empty is MuJoCo's own choice.
    """

    file: str
    scale: Vector = (1.0, 1.0, 1.0)
    inertia: str = field(default="", compare=False)


@dataclass(frozen=True)
class HeightMap:
    """The top of a body as heights above z = 0 on a grid of square cells; height 0 is no body.

    ``heights[i][j]`` covers x from ``origin[0] + i * cell`` and y from ``origin[1] + j * cell``. ``step`` is the height
    to whose multiples the boxes are rounded up, so that they are never smaller than the body.
    """

    origin: tuple[float, float]
    cell: float
    heights: tuple[tuple[float, ...], ...]
    step: float
    method: str = ""

    def boxes(self) -> tuple[Box, ...]:
        """Return the body as boxes on z = 0: one for each run of equal rounded heights within a row of constant x."""
        return self._boxes

    @cached_property  # each format asks for them, and the proof of what it wrote
    def _boxes(self) -> tuple[Box, ...]:
        made: list[Box] = []
        x0, y0 = self.origin
        for i, row in enumerate(self.heights):
            steps = [_steps(z, self.step) for z in row]
            start = 0
            for j in range(1, len(steps) + 1):
                if j < len(steps) and steps[j] == steps[start]:
                    continue
                if steps[start] > 0:
                    lower = (x0 + i * self.cell, y0 + start * self.cell, 0.0)
                    top = round(steps[start] * self.step, 12)
                    made.append(Box(lower, (x0 + (i + 1) * self.cell, y0 + j * self.cell, top)))
                start = j
        return tuple(made)


def _steps(height: float, step: float) -> int:
    """Return the number of steps that reach the height; an exact multiple is not rounded up by float noise."""
    return math.ceil(height / step - 1e-6) if height > 0 else 0


Geometry = Box | Cylinder | Capsule | Sphere | Ellipsoid | Mesh | HeightMap


def plain(geometry: Geometry) -> Geometry:
    """Return what stands for a geometry in a URDF 1.0, as large: a cylinder for a capsule, a box for an ellipsoid.

    All others are in it as they are.
    """
    if isinstance(geometry, Capsule):
        return Cylinder(geometry.radius, geometry.length + 2 * geometry.radius)
    if isinstance(geometry, Ellipsoid):
        x, y, z = geometry.radii
        return Box((-x, -y, -z), (x, y, z))
    return geometry


Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class Material:
    """How a surface looks: red, green, blue and opacity, each 0 to 1, and an image by reference."""

    name: str
    rgba: Rgba | None = None
    texture: str = ""
    mjcf: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Shape:
    """A geometry at a pose in its link's frame; ``rgba``, ``texture`` and ``material`` matter to visuals only.

    ``urdf_elements`` are elements of XML that the URDF has in this shape, ``contact`` and ``mjcf`` are for simulation.
    """

    geometry: Geometry
    pose: Pose = IDENTITY
    name: str = ""
    rgba: Rgba | None = None
    material: str = ""
    stand_in: str = field(default="", compare=False)
    texture: str = ""
    urdf_elements: tuple[str, ...] = ()
    contact: Contact | None = None
    mjcf: Values = field(default_factory=dict, hash=False)

    def solids(self) -> tuple[Shape, ...]:
        """Return the shape as primitives: a height map becomes its boxes, NAME_1, NAME_2, ...; all else is itself."""
        return self._pieces if isinstance(self.geometry, HeightMap) else (self,)

    @cached_property
    def _pieces(self) -> tuple[Shape, ...]:
        names = (f"{self.name}_{number}" if self.name else "" for number in count(1))
        boxes = self.geometry.boxes() if isinstance(self.geometry, HeightMap) else ()
        return tuple(replace(self, geometry=box, name=name) for box, name in zip(boxes, names, strict=False))

    def origin(self) -> Pose:
        """Return the pose of the middle of the geometry in the link's frame."""
        if isinstance(self.geometry, Box) and self.geometry.centre != (0.0, 0.0, 0.0):
            return Pose(self.pose.transform().apply(self.geometry.centre), self.pose.rpy)
        return self.pose

    def moved(self, transform: Transform) -> Shape:
        """Return the same shape seen from a parent frame; ``transform`` is parent -> frame of this shape.

        A box that ends up along the axes of the parent, whatever quarter turns brought it there, is written as an
        axis-aligned box without rotation.
        """
        placed = transform.then(self.pose.transform())
        if isinstance(self.geometry, Box) and _is_quarter_turn(placed):
            a, b = placed.apply(self.geometry.lower), placed.apply(self.geometry.upper)
            lower = (min(a[0], b[0]), min(a[1], b[1]), min(a[2], b[2]))
            upper = (max(a[0], b[0]), max(a[1], b[1]), max(a[2], b[2]))
            return replace(self, geometry=Box(lower, upper), pose=IDENTITY)
        return replace(self, pose=pose_of(placed))


def _is_quarter_turn(transform: Transform) -> bool:
    return all(abs(c) < 1e-12 or abs(abs(c) - 1) < 1e-12 for row in transform.rows for c in row)

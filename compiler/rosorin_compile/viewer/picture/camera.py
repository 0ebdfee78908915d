"""The camera of a picture: the views of the page (``viewer/src/stage.js``), fitted to the robot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Vector

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Directions to the camera in the root frame: x ahead, y left, z up.
VIEWS: Mapping[str, Vector] = {
    "iso": (1.0, -1.15, 0.75),
    "front": (1.0, 0.0, 0.06),
    "side": (0.0, -1.0, 0.06),
    "top": (0.0, -0.001, 1.0),
}
FIELD_OF_VIEW = math.radians(28.0)  # vertical
MARGIN = 1.06  # times the distance at which the sphere around the robot fills the picture
_SMALLEST_RADIUS = 0.02  # m


class Box(NamedTuple):
    """An axis-aligned box in the root frame (m)."""

    lower: Vector
    upper: Vector

    @staticmethod
    def around(points: Iterable[Vector]) -> Box:
        """Return the smallest box that contains all points."""
        xs, ys, zs = zip(*points, strict=True)
        return Box((min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)))

    @property
    def centre(self) -> Vector:
        """The middle of the box (m)."""
        (a, b, c), (x, y, z) = self
        return ((a + x) / 2, (b + y) / 2, (c + z) / 2)

    @property
    def diagonal(self) -> float:
        """The distance between opposite corners (m)."""
        return math.dist(self.lower, self.upper)


class Camera(NamedTuple):
    """A pinhole camera: its position (m), its axes in the root frame, and the size of its picture in pixels.

    ``focal`` is the length in pixels of an object of 1 m at a distance of 1 m. Pixel (0, 0) is at the top left.
    """

    eye: Vector
    right: Vector
    down: Vector
    forward: Vector
    focal: float
    width: int
    height: int

    @staticmethod
    def fitted(box: Box, direction: Vector, width: int, height: int) -> Camera:
        """Return the camera in the given direction from a box whose picture contains the box, as on the page."""
        radius = max(box.diagonal / 2, _SMALLEST_RADIUS)
        distance = MARGIN * radius / math.sin(FIELD_OF_VIEW / 2) / min(1.0, width / height)
        a, b, c = unit(direction)
        x, y, z = box.centre
        forward = (-a, -b, -c)
        right = unit(cross(forward, (0.0, 0.0, 1.0) if math.hypot(a, b) > 1e-9 else (1.0, 0.0, 0.0)))
        eye = (x + a * distance, y + b * distance, z + c * distance)
        focal = height / 2 / math.tan(FIELD_OF_VIEW / 2)
        return Camera(eye, right, cross(forward, right), forward, focal, width, height)

    def project(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return x and y (pixels) of points (..., 3) in the picture, and their depth (m) along the optical axis."""
        offset = points - self.eye
        depth = dot(offset, self.forward)
        x, y = (dot(offset, axis) / depth * self.focal for axis in (self.right, self.down))
        return x + self.width / 2, y + self.height / 2, depth

    def rays(self, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the x, y and z components of the directions of pixels; their length along ``forward`` is 1."""
        across, below = (x - self.width / 2) / self.focal, (y - self.height / 2) / self.focal
        i, j, k = (self.forward[i] + across * self.right[i] + below * self.down[i] for i in range(3))
        return i, j, k


def dot(vectors: Floats, axis: Vector) -> Floats:
    """Return the scalar products of vectors (..., 3) with an axis, without BLAS: its last digit depends on the CPU."""
    product: Floats = vectors[..., 0] * axis[0] + vectors[..., 1] * axis[1] + vectors[..., 2] * axis[2]
    return product


def unit(vector: Vector) -> Vector:
    """Return a vector of length 1 in the same direction."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length)


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def from_angles(azimuth: float, elevation: float) -> Vector:
    """Return the direction to a camera: azimuth (rad) from x to y, elevation (rad) above the floor."""
    flat = math.cos(elevation)
    return (flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation))

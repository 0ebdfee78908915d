"""From where a picture is taken: the views of the page (``viewer/src/stage.js``), fitted to what is drawn."""

from __future__ import annotations

import math
from collections.abc import Mapping
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
FIELD = math.radians(28.0)  # of view, from the lower to the upper edge
ROOM = 1.06  # times the distance at which the sphere around the robot fills the picture
SMALLEST = 0.02  # m: the radius of what is fitted where there are mere frames


class Box(NamedTuple):
    """An axis-aligned box in the root frame (m)."""

    lower: Vector
    upper: Vector

    @property
    def centre(self) -> Vector:
        """Its middle (m)."""
        return tuple((a + b) / 2 for a, b in zip(self.lower, self.upper, strict=True))  # type: ignore[return-value]

    @property
    def diagonal(self) -> float:
        """How long it is from corner to corner (m)."""
        return math.dist(self.lower, self.upper)


class Camera(NamedTuple):
    """A pinhole camera: where it is (m), its axes in the root frame, and its picture in pixels.

    ``focal`` is how many pixels a thing of 1 m is long that is 1 m ahead. Pixel (0, 0) is at the top left.
    """

    eye: Vector
    right: Vector
    down: Vector
    ahead: Vector
    focal: float
    width: int
    height: int

    def seen(self, points: Floats) -> tuple[Floats, Floats, Floats]:
        """Return where points (..., 3) are in the picture, x and y in pixels, and how far ahead they are (m)."""
        x, y, z = (points[..., i] - self.eye[i] for i in range(3))
        depth = along((x, y, z), self.ahead)
        across, below = along((x, y, z), self.right) / depth, along((x, y, z), self.down) / depth
        return across * self.focal + self.width / 2, below * self.focal + self.height / 2, depth

    def rays(self, x: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
        """Return the directions in which pixels look, of length 1 along ``ahead``; x, y and z one by one."""
        across, below = (x - self.width / 2) / self.focal, (y - self.height / 2) / self.focal
        made = [self.ahead[i] + across * self.right[i] + below * self.down[i] for i in range(3)]
        return made[0], made[1], made[2]


def along(point: tuple[Floats, Floats, Floats], axis: Vector) -> Floats:
    """Return scalar products. Without BLAS, whose last digit depends on the machine."""
    return point[0] * axis[0] + point[1] * axis[1] + point[2] * axis[2]


def fitted(box: Box, direction: Vector, width: int, height: int) -> Camera:
    """Return the camera that looks at a box from a direction, as the page does."""
    radius = max(box.diagonal / 2, SMALLEST)
    narrow = min(1.0, width / height)
    distance = ROOM * radius / math.sin(FIELD / 2) / narrow
    towards = unit(direction)
    (x, y, z), (a, b, c) = box.centre, towards
    eye = (x + a * distance, y + b * distance, z + c * distance)
    ahead = unit((x - eye[0], y - eye[1], z - eye[2]))
    up: Vector = (0.0, 0.0, 1.0) if math.hypot(*ahead[:2]) > 1e-9 else (1.0, 0.0, 0.0)
    right = unit(cross(ahead, up))
    down = cross(ahead, right)
    return Camera(eye, right, down, ahead, height / 2 / math.tan(FIELD / 2), width, height)


def unit(vector: Vector) -> Vector:
    """Return a direction at length 1."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length)


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def looking(azimuth: float, elevation: float) -> Vector:
    """Return the direction to a camera at angles (rad): azimuth from x to y, elevation from the floor up."""
    flat = math.cos(elevation)
    return (flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation))

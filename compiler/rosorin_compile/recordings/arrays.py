"""Arrays of rotations and of times. Quaternions are (x, y, z, w), as ROS 2 messages have them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Transform

Floats = NDArray[np.float64]
Times = NDArray[np.int64]
Flags = NDArray[np.bool_]

SECOND = 1_000_000_000
# tf2 drops transforms whose squared quaternion is off by more (QUATERNION_NORMALIZATION_TOLERANCE in
# tf2/src/buffer_core.cpp).
NORM_TOLERANCE = 10e-3


class Samples(NamedTuple):
    """Transforms of one edge in the order of their arrival.

    ``received`` and ``stamp`` are ns (n,), ``xyz`` metres (n, 3), ``quaternion`` (n, 4) x, y, z, w.
    """

    received: Times
    stamp: Times
    xyz: Floats
    quaternion: Floats

    def where(self, chosen: Any) -> Samples:
        """Return some of the samples: by mask, index or slice."""
        return Samples(*(values[chosen] for values in self))

    def after(self, earlier: Samples) -> Samples:
        """Return these samples behind earlier ones."""
        return Samples(*(np.concatenate(pair) for pair in zip(earlier, self, strict=True)))


NO_SAMPLES = Samples(np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 4)))


def are_rotations(quaternion: Floats, xyz: Floats) -> Flags:
    """Say which transforms (n,) tf2 would take: finite, and with quaternions of length one."""
    square = np.einsum("ij,ij->i", quaternion, quaternion)
    good: Flags = np.isfinite(xyz).all(axis=1) & (np.abs(square - 1.0) <= NORM_TOLERANCE)
    return good


def normalised(quaternion: Floats) -> Floats:
    """Return quaternions (n, 4) at length one."""
    return np.asarray(quaternion / np.linalg.norm(quaternion, axis=1)[:, None], np.float64)


def product(a: Floats, b: Floats) -> Floats:
    """Return the products (n, 4) of quaternions (n, 4) or (4,)."""
    ax, ay, az, aw = (a[..., i] for i in range(4))
    bx, by, bz, bw = (b[..., i] for i in range(4))
    return np.stack(
        (
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ),
        axis=-1,
    )


def inverse(q: Floats) -> Floats:
    """Return the inverse of quaternions of length one."""
    return np.asarray(q * np.array([-1.0, -1.0, -1.0, 1.0]), np.float64)


def angles_between(a: Floats, b: Floats) -> Floats:
    """Return the angles (n,), in radians from 0 to pi, that turn rotations ``a`` (n, 4) into ``b`` (n, 4) or (4,)."""
    turn = product(inverse(a), b)
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(turn[..., :3], axis=-1), np.abs(turn[..., 3])), np.float64)


def turned(q: Floats, vectors: Floats) -> Floats:
    """Return vectors (n, 3) or (3,) turned by a rotation (4,)."""
    u, w = q[:3], q[3]
    t = 2.0 * np.cross(u, vectors)
    return np.asarray(vectors + w * t + np.cross(u, t), np.float64)


def about(axis: Floats, angles: Floats) -> Floats:
    """Return the rotations (n, 4) by ``angles`` (n,) in radians about a unit axis (3,)."""
    half = 0.5 * angles
    return np.concatenate((np.sin(half)[:, None] * axis, np.cos(half)[:, None]), axis=1)


def arrays_of(transform: Transform) -> tuple[Floats, Floats]:
    """Return a transform as position (3,) in metres and quaternion (4,) x, y, z, w."""
    w, x, y, z = transform.quaternion()
    return np.array(transform.xyz, np.float64), np.array((x, y, z, w), np.float64)


def transform_from(xyz: Floats, quaternion: Floats) -> Transform:
    """Return a position (3,) and a quaternion (4,) x, y, z, w as a transform."""
    x, y, z, w = map(float, quaternion)
    px, py, pz = map(float, xyz)
    return Transform.of_quaternion((px, py, pz), (w, x, y, z))

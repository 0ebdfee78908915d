"""Poses and transforms in pure Python, because numpy is slower for vectors of three numbers.

Conventions are those of URDF and REP 103: right-handed axes, metres, radians; ``rpy`` rotates about the fixed axes X,
Y, Z in this order, so R = Rz(yaw) Ry(pitch) Rx(roll) (http://wiki.ros.org/urdf/XML/joint, REP 103 "Rotation
Representation").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

Vector = tuple[float, float, float]
Rows = tuple[Vector, Vector, Vector]
Quaternion = tuple[float, float, float, float]

_UNIT_ROWS: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ORIGIN: Vector = (0.0, 0.0, 0.0)
_UNTURNED: Rows = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.0, 0.0, 1.0))
_ROUNDING = 4e-15  # tolerance for a sine or cosine; a product of three rotations has an error of about 1e-15
_STEEP = 1e-2  # cosine of the pitch, below which (near +-90 degrees) the usual formula for yaw loses digits


def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of two vectors."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a: Vector) -> float:
    """Return the length of a vector."""
    return math.hypot(*a)


def minus(one: Vector, other: Vector) -> Vector:
    """Return the vector ``one - other``."""
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def plus(one: Vector, other: Vector) -> Vector:
    """Return the vector ``one + other``."""
    return (one[0] + other[0], one[1] + other[1], one[2] + other[2])


def unit(vector: Vector) -> Vector:
    """Return a vector scaled to length 1, or a zero vector unchanged."""
    length = norm(vector) or 1.0
    return (vector[0] / length, vector[1] / length, vector[2] / length)


def angle_between(one: Vector, other: Vector) -> float:
    """Return the angle (rad) between two nonzero vectors, accurate even for small angles."""
    return math.atan2(norm(cross(one, other)), dot(one, other))


def _snap(value: float) -> float:
    """Round a sine or cosine to 0, 1 or -1 if it is within rounding error, such as 6e-17 for cos(90 deg)."""
    nearest = round(value)
    return float(nearest) if abs(value - nearest) < _ROUNDING else value


@lru_cache(maxsize=20_000)
def rotation_of_rpy(rpy: Vector) -> Rows:
    """Return the 3x3 rotation matrix, as rows, of fixed-axis roll, pitch, yaw in radians."""
    if not any(rpy):  # most poses have no rotation
        return _UNTURNED
    (sr, cr), (sp, cp), (sy, cy) = ((_snap(math.sin(angle)), _snap(math.cos(angle))) for angle in rpy)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def rotation_about(axis: Vector, angle: float) -> Rows:
    """Return the matrix of a rotation by ``angle`` (rad) about a nonzero axis. Raises ValueError for a zero axis."""
    length = norm(axis)
    if length == 0:
        raise ValueError("a rotation needs an axis that is not zero")
    x, y, z = (c / length for c in axis)
    s, c = math.sin(angle), math.cos(angle)
    t = 1 - c
    return (
        (c + x * x * t, x * y * t - z * s, x * z * t + y * s),
        (y * x * t + z * s, c + y * y * t, y * z * t - x * s),
        (z * x * t - y * s, z * y * t + x * s, c + z * z * t),
    )


def plane_axes(normal: Vector) -> tuple[Vector, Vector]:
    """Return unit vectors along the x and y axes of a planar joint's plane, in the frame of the joint.

    The shortest rotation from z to the normal maps x and y to them, as in MuJoCo. Raises ValueError for a zero vector.
    """
    x, y, z = unit(normal)
    across = math.hypot(x, y)
    if not any(normal):
        raise ValueError("a motion needs an axis that is not zero")
    if across == 0.0:
        return (1.0, 0.0, 0.0), (0.0, math.copysign(1.0, z), 0.0)
    (a, d, _), (b, e, _), (c, f, _) = rotation_about((-y / across, x / across, 0.0), math.atan2(across, z))
    return (a + 0.0, b + 0.0, c + 0.0), (d + 0.0, e + 0.0, f + 0.0)


def quaternion_of(rows: Rows) -> Quaternion:
    """Convert a rotation matrix to a quaternion (x, y, z, w) like tf2 does (``tf2/LinearMath/Matrix3x3.h``)."""
    trace = rows[0][0] + rows[1][1] + rows[2][2]
    if trace > 0:
        s = math.sqrt(trace + 1.0)
        w, s = s * 0.5, 0.5 / s
        return ((rows[2][1] - rows[1][2]) * s, (rows[0][2] - rows[2][0]) * s, (rows[1][0] - rows[0][1]) * s, w)
    i = max(range(3), key=lambda axis: rows[axis][axis])  # the first of equal entries, like tf2
    j, k = (i + 1) % 3, (i + 2) % 3
    s = math.sqrt(rows[i][i] - rows[j][j] - rows[k][k] + 1.0)
    made = [0.0, 0.0, 0.0, 0.0]
    made[i], s = s * 0.5, 0.5 / s
    made[3] = (rows[k][j] - rows[j][k]) * s
    made[j] = (rows[j][i] + rows[i][j]) * s
    made[k] = (rows[k][i] + rows[i][k]) * s
    return (made[0], made[1], made[2], made[3])


@lru_cache(maxsize=20_000)
def eigenvalues(rows: Rows) -> Vector:
    """Return the eigenvalues of a symmetric 3x3 matrix, smallest first.

    Uses Jacobi's method (1846): rotate the largest off-diagonal entry to zero until none is left. Unlike the
    closed-form solution, it is accurate for equal eigenvalues.
    """
    matrix = [list(row) for row in rows]
    for _ in range(60):
        p, q = max(((0, 1), (0, 2), (1, 2)), key=lambda pair: abs(matrix[pair[0]][pair[1]]))
        if abs(matrix[p][q]) <= 1e-17 * max(abs(matrix[i][i]) for i in range(3)):
            break
        theta = (matrix[q][q] / 2 - matrix[p][p] / 2) / matrix[p][q]
        tangent = math.copysign(1.0, theta) / (abs(theta) + math.hypot(theta, 1.0))
        cosine = 1 / math.hypot(tangent, 1.0)
        sine = tangent * cosine
        matrix[p][p] -= tangent * matrix[p][q]
        matrix[q][q] += tangent * matrix[p][q]
        matrix[p][q] = matrix[q][p] = 0.0
        r = 3 - p - q
        first, second = matrix[p][r], matrix[q][r]
        matrix[p][r] = matrix[r][p] = cosine * first - sine * second
        matrix[q][r] = matrix[r][q] = sine * first + cosine * second
    low, middle, high = sorted(matrix[i][i] for i in range(3))
    return (low, middle, high)


@dataclass(frozen=True, repr=False)
class Transform:
    """A rigid transform from a child frame to its parent frame: a 3x3 rotation (``rows``) and a translation (m)."""

    rows: Rows = _UNIT_ROWS
    xyz: Vector = _ORIGIN

    @staticmethod
    def of_quaternion(xyz: Vector, quaternion: Sequence[float]) -> Transform:
        """Build a transform from a position (m) and a nonzero quaternion (w, x, y, z). Raises ValueError for zero."""
        length = math.hypot(*quaternion)
        if length == 0:
            raise ValueError("a quaternion of length zero is not a rotation")
        w, x, y, z = (c / length for c in quaternion)
        rows = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
        return Transform(rows, xyz)

    def __repr__(self) -> str:
        x, y, z = (f"{value + 0.0:.6g}" for value in self.xyz)
        roll, pitch, yaw = (f"{round(math.degrees(angle), 9) + 0.0:.6g}" for angle in self.rpy())
        return f"<Transform xyz {x} {y} {z} m, rpy {roll} {pitch} {yaw} deg>"

    def apply(self, point: Vector) -> Vector:
        """Convert a point (m) from the child frame to the parent frame."""
        (a, b, c), (d, e, f), (g, h, i) = self.rows
        (x, y, z), (j, k, m) = point, self.xyz
        return (a * x + b * y + c * z + j, d * x + e * y + f * z + k, g * x + h * y + i * z + m)

    def rotate(self, vector: Vector) -> Vector:
        """Convert a direction from the child frame to the parent frame."""
        (a, b, c), (d, e, f), (g, h, i) = self.rows
        x, y, z = vector
        return (a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z)

    def then(self, child: Transform) -> Transform:
        """Compose two transforms: the result applies ``child`` first and then this transform."""
        (a, b, c), (d, e, f), (g, h, i) = self.rows
        (j, k, m), (n, o, p), (q, r, s) = child.rows
        first = (a * j + b * n + c * q, a * k + b * o + c * r, a * m + b * p + c * s)
        second = (d * j + e * n + f * q, d * k + e * o + f * r, d * m + e * p + f * s)
        third = (g * j + h * n + i * q, g * k + h * o + i * r, g * m + h * p + i * s)
        return Transform((first, second, third), self.apply(child.xyz))

    def inverse(self) -> Transform:
        """Return the inverse transform, from the parent frame to the child frame."""
        (a, b, c), (d, e, f), (g, h, i) = self.rows
        rows = ((a, d, g), (b, e, h), (c, f, i))
        x, y, z = Transform(rows).rotate(self.xyz)
        return Transform(rows, (-x, -y, -z))

    def quaternion(self) -> Quaternion:
        """Return the rotation as a unit quaternion (w, x, y, z) with w >= 0."""
        x, y, z, w = quaternion_of(self.rows)
        return (-w, -x, -y, -z) if w < 0 else (w, x, y, z)

    def turn_to(self, other: Transform) -> tuple[Vector, float]:
        """Return the rotation to ``other`` as (axis, angle): a unit vector (zero for no rotation), and 0 to pi rad."""
        w, x, y, z = Transform(self.rows).inverse().then(Transform(other.rows)).quaternion()
        return unit((x, y, z)), 2 * math.atan2(norm((x, y, z)), w)

    def angle_to(self, other: Transform) -> float:
        """Return the angle (rad, 0 to pi) between the rotations of two transforms."""
        return self.turn_to(other)[1]

    def rpy(self) -> Vector:
        """Return the rotation as fixed-axis roll, pitch, yaw (rad); yaw is zero at a pitch of +-90 degrees."""
        (a, b, c), (d, e, f), (g, h, i) = self.rows
        horizontal = math.hypot(h, i)
        if horizontal < 1e-12:
            return (math.atan2(-f if g < 0 else f, e) * (1 if g < 0 else -1) + 0.0, math.atan2(-g, horizontal), 0.0)
        if horizontal < _STEEP:
            # ``a`` and ``d`` are small and inaccurate here, so compute the yaw from the roll and other entries.
            roll = math.atan2(h, i)
            sine, cosine = math.sin(roll), math.cos(roll)
            return (roll, math.atan2(-g, horizontal), math.atan2(c * sine - b * cosine, e * cosine - f * sine))
        return (math.atan2(h, i), math.atan2(-g, horizontal), math.atan2(d, a))


@dataclass(frozen=True)
class Pose:
    """The pose of a frame in its parent, as in a description: ``xyz`` in metres, fixed-axis ``rpy`` in radians."""

    xyz: Vector = _ORIGIN
    rpy: Vector = _ORIGIN

    def transform(self) -> Transform:
        return Transform(rotation_of_rpy(self.rpy), self.xyz)


IDENTITY = Pose()


def pose_of(transform: Transform) -> Pose:
    """Convert a transform to a pose. Exact quarter turns yield exact angles."""
    return Pose(transform.xyz, transform.rpy())

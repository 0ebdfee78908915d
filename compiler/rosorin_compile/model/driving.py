"""Driving: what the wheels of a robot turn at for a velocity of its base, and back; where they are, and how large.

All kinds of bases are one equation. A wheel at p (seen from the centre of the drive) that turns at w has a rim that
moves at w * r along the ``direction`` d in which it rolls; the ground holds it along its ``grip`` g, and along g the
hub moves as the rim does:

    g . (v + wz * (-p.y, p.x)) = w * r * (g . d)

For a plain wheel and for an omni wheel, which slides along its axle, g is d. For a mecanum wheel g is the axis of the
roller that stands on the ground, half-way between d and the axle. With axles along +y that is, for the four wheels,
the table of ros2_controllers (mecanum_drive_controller/src/mecanum_drive_controller.cpp; the others are in its
doc/mobile_robot_kinematics.rst, and the equation in K. M. Lynch and F. C. Park, "Modern Robotics" (2017), 13.2).

A steered wheel is turned towards the way of its place: atan2 of the two parts of its velocity, at most a quarter turn.

Velocities are those of the centre of the drive, in the axes of the base frame (REP 103: x forward, y left, wz counter-
clockwise): the middle of the four wheels (mecanum), of all (omni), of the axle between left and right (differential),
of the axle that is not steered (tricycle, ackermann). A differential, tricycle or Ackermann base has no vy there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from .cached import of_robot
from .drive import DIFFERENTIAL, MECANUM, OMNI, ROLES, SLIDING, Drive
from .geometry import Transform, Vector, angle_between, dot, minus, norm, unit
from .shape import Capsule, Cylinder, Shape, Sphere

if TYPE_CHECKING:
    from .robot import Robot

# Along which the ground holds a mecanum wheel: parts along x and y, in the X layout (from above, the axes of the upper
# rollers point at the middle, so those below lie across).
_GRIPS = {"front_left": (1.0, -1.0), "rear_left": (1.0, 1.0), "front_right": (1.0, 1.0), "rear_right": (1.0, -1.0)}
_AROUND = 360  # points on the edge of a cylinder that does not lie along its axle
_ALONG = 1e-9  # rad, of one that does
_SINGULAR = 1e-9


class Twist(NamedTuple):
    """A velocity of the base: m/s forward and to the left, rad/s counter-clockwise."""

    vx: float = 0.0
    vy: float = 0.0
    wz: float = 0.0


@dataclass(frozen=True)
class Wheel:
    """A wheel that is driven: where it is from the centre of the drive (m), its radius (m), and its two directions.

    It rolls along ``direction`` where its joint turns forward and holds along ``grip``, both without steering.
    ``steering`` is the joint that steers it, or empty.
    """

    joint: str
    x: float
    y: float
    radius: float
    direction: tuple[float, float]
    grip: tuple[float, float]
    steering: str = ""


@dataclass(frozen=True)
class Steering:
    """A joint that steers: where its axis is from the centre of the drive (m); ``sign`` -1 where it turns about -z."""

    joint: str
    x: float
    y: float
    sign: float


@dataclass(frozen=True)
class Driving:
    """The kinematics of a drive. ``centre`` (m) is the point whose velocities are meant, in the frame ``frame``.

    ``wheelbase`` and ``track`` (m) are zero where the kind has none.
    """

    kind: str
    frame: str
    centre: tuple[float, float]
    wheels: tuple[Wheel, ...]
    steering: tuple[Steering, ...] = ()
    wheelbase: float = 0.0
    track: float = 0.0

    @property
    def slides(self) -> bool:
        """Whether the base goes sideways."""
        return self.kind in SLIDING

    def angles(self, twist: Twist) -> dict[str, float]:
        """Return the positions (rad) of the joints that steer; straight ahead at rest."""
        return {one.joint: one.sign * _steered(one, twist) for one in self.steering}

    def speeds(self, twist: Twist, angles: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return the speeds (rad/s) of the wheels; ``angles`` (rad, by joint) are those of the steering that is so.

        ``vy`` of a base that does not go sideways counts for nothing.
        """
        if not self.slides:
            twist = twist._replace(vy=0.0)
        angles = self.angles(twist) if angles is None else angles
        made = {}
        for wheel in self.wheels:
            row, rolled = self._row(wheel, angles)
            made[wheel.joint] = dot(row, twist) / rolled
        return made

    def velocity(self, speeds: Mapping[str, float], angles: Mapping[str, float] | None = None) -> Twist:
        """Return the velocity of the base for speeds of the wheels (rad/s) and positions of the steering (rad).

        Where they do not fit each other it is what fits best (least squares). What is not named is at rest. Raises
        ValueError where the wheels do not say it, as two wheels in one place.
        """
        angles = angles or {}
        rows, values = [], []
        for wheel in self.wheels:
            row, rolled = self._row(wheel, angles)
            rows.append(row)
            values.append(rolled * speeds.get(wheel.joint, 0.0))
        for one in self.steering:
            turned = one.sign * angles.get(one.joint, 0.0)
            rows.append(_along((-math.sin(turned), math.cos(turned)), one.x, one.y))
            values.append(0.0)
        if self.slides:
            vx, vy, wz = _fitted(rows, values)
            return Twist(vx, vy, wz)
        vx, wz = _fitted([(row[0], row[2]) for row in rows], values)
        return Twist(vx, 0.0, wz)

    def _row(self, wheel: Wheel, angles: Mapping[str, float]) -> tuple[Vector, float]:
        """Return what vx, vy and wz count for along the grip of a wheel, and for how much a turn of it by 1 rad does.

        A steered wheel is taken to stand on the axis that steers it.
        """
        grip, turned, x, y = wheel.grip, 0.0, wheel.x, wheel.y
        for one in self.steering:
            if one.joint == wheel.steering:
                turned, x, y = one.sign * angles.get(one.joint, 0.0), one.x, one.y
        sine, cosine = math.sin(turned), math.cos(turned)
        held = (cosine * grip[0] - sine * grip[1], sine * grip[0] + cosine * grip[1])
        rolled = wheel.radius * (wheel.grip[0] * wheel.direction[0] + wheel.grip[1] * wheel.direction[1])
        return _along(held, x, y), rolled


def _along(direction: tuple[float, float], x: float, y: float) -> Vector:
    """Return what vx, vy and wz count for in the velocity of a place (m) along a direction."""
    return (direction[0], direction[1], direction[1] * x - direction[0] * y)


def _steered(one: Steering, twist: Twist) -> float:
    """Return the angle (rad) about z that turns a wheel into the way of its place, at most a quarter turn."""
    forward, left = twist.vx - twist.wz * one.y, twist.wz * one.x
    if forward < 0:
        forward, left = -forward, -left
    return math.atan2(left, forward) if forward or left else 0.0


def _fitted(rows: Sequence[Sequence[float]], values: Sequence[float]) -> list[float]:
    """Return the numbers that fit linear equations best: the normal equations, by Gauss. Raises ValueError."""
    size = len(rows[0]) if rows else 0
    normal = [
        [sum(row[i] * row[j] for row in rows) for j in range(size)]
        + [sum(row[i] * value for row, value in zip(rows, values, strict=True))]
        for i in range(size)
    ]
    scale = max((abs(number) for line in normal for number in line[:-1]), default=0.0)
    for column in range(size):
        best = max(range(column, size), key=lambda line: abs(normal[line][column]))
        normal[column], normal[best] = normal[best], normal[column]
        if abs(normal[column][column]) <= _SINGULAR * scale:
            raise ValueError("the wheels do not say how the base moves")
        for line in range(size):
            if line != column:
                factor = normal[line][column] / normal[column][column]
                normal[line] = [a - factor * b for a, b in zip(normal[line], normal[column], strict=True)]
    return [normal[line][size] / normal[line][line] for line in range(size)]


@of_robot
def driving_of(robot: Robot) -> Driving:
    """Return the kinematics of the drive of a robot, at zero. Raises ValueError where there is no drive, or none to be.

    The rules about drives have told what is wrong with one before.
    """
    drive = robot.drive
    if drive is None:
        raise ValueError(f'the robot "{robot.name}" has no drive')
    base = drive.frame or robot.root
    for name in (base, *(end for one in robot.joints for end in (one.parent, one.child))):
        if name not in robot.link:
            raise ValueError(f'there is no link "{name}"')
    for names in drive.joints.values():
        for name in names:
            if name not in robot.joint:
                raise ValueError(f'there is no joint "{name}"')
    placed = {name: _Placed.of(robot, base, name) for names in drive.joints.values() for name in names}
    x, y = _centre(drive, placed)
    steering = tuple(
        Steering(name, placed[name].origin[0] - x, placed[name].origin[1] - y, math.copysign(1, placed[name].axis[2]))
        for name in drive.steering
    )
    wheels = tuple(
        Wheel(
            joint=name,
            x=placed[name].origin[0] - x,
            y=placed[name].origin[1] - y,
            radius=_radius(robot, drive, name),
            direction=(direction := placed[name].direction),
            grip=_grip(drive, name, direction),
            steering=steering_of(robot, drive, name),
        )
        for name in drive.wheels
    )
    return Driving(drive.kind, base, (x, y), wheels, steering, *_sizes(drive, placed))


def steering_of(robot: Robot, drive: Drive, name: str) -> str:
    """Return the joint that steers the wheel of a joint; empty if none does."""
    above = [joint.name for joint in robot.chain(robot.joint[name].parent)]
    return next((one for one in drive.steering if one in above), "")


@dataclass(frozen=True)
class _Placed:
    """A joint at zero: where it is in the base frame (m), and its axis there."""

    origin: Vector
    axis: Vector

    @classmethod
    def of(cls, robot: Robot, base: str, name: str) -> _Placed:
        joint = robot.joint[name]
        where = robot.transform(base, joint.child)
        return cls(where.xyz, unit(where.rotate(joint.axis)))

    @property
    def direction(self) -> tuple[float, float]:
        """Where a wheel rolls that turns forward: across its axis, level."""
        x, y, _ = self.axis
        across = math.hypot(x, y)
        if not across:
            raise ValueError("a wheel that lies flat rolls nowhere")
        return (y / across, -x / across)


def axis_in_base(robot: Robot, drive: Drive, name: str) -> Vector:
    """Return the axis of a joint in the base frame of a drive, at zero, of length 1."""
    return _Placed.of(robot, drive.frame or robot.root, name).axis


def place_in_base(robot: Robot, drive: Drive, name: str) -> Vector:
    """Return where a joint is in the base frame of a drive (m), at zero."""
    return _Placed.of(robot, drive.frame or robot.root, name).origin


def _grip(drive: Drive, name: str, direction: tuple[float, float]) -> tuple[float, float]:
    """Return along which the ground holds a wheel, of length 1."""
    if drive.kind != MECANUM:
        return direction
    role = next(role for role, names in drive.joints.items() if name in names)
    x, y = _GRIPS[role]
    return (x / math.sqrt(2), y / math.sqrt(2))


def _middle(placed: Mapping[str, _Placed], names: Iterable[str]) -> tuple[float, float]:
    found = [placed[name].origin for name in names]
    return (sum(p[0] for p in found) / len(found), sum(p[1] for p in found) / len(found))


def _centre(drive: Drive, placed: Mapping[str, _Placed]) -> tuple[float, float]:
    """Return the centre of a drive in its base frame (m)."""
    if drive.kind == DIFFERENTIAL:
        (xl, yl), (xr, yr) = (_middle(placed, drive.joints[side]) for side in ROLES[DIFFERENTIAL])
        return ((xl + xr) / 2, (yl + yr) / 2)
    return _middle(placed, drive.joints.get("rolling") or drive.wheels)


def _sizes(drive: Drive, placed: Mapping[str, _Placed]) -> tuple[float, float]:
    """Return the wheelbase and the track of a drive (m); zero where there is none."""

    def middle(*roles: str) -> tuple[float, float]:
        return _middle(placed, [name for role in roles for name in drive.joints[role]])

    if drive.kind == MECANUM:
        front, rear = middle("front_left", "front_right"), middle("rear_left", "rear_right")
        left, right = middle("front_left", "rear_left"), middle("front_right", "rear_right")
        return front[0] - rear[0], left[1] - right[1]
    if drive.kind == DIFFERENTIAL:
        return 0.0, middle("left")[1] - middle("right")[1]
    if drive.kind == OMNI:
        return 0.0, 0.0
    axle = drive.joints.get("rolling") or drive.joints["driven"]
    across = [placed[name].origin[1] for name in axle]
    return abs(middle("steering")[0] - _middle(placed, axle)[0]), max(across) - min(across)


def _radius(robot: Robot, drive: Drive, name: str) -> float:
    radius = drive.radius if drive.radius is not None else rolling_radius(robot, name)
    if radius is None:
        raise ValueError(f'the shapes of the wheel of joint "{name}" do not say its radius')
    return radius


@of_robot
def rolling_radius(robot: Robot, name: str) -> float | None:
    """Return how far round shapes reach from the axis of a joint (m): those of its wheel and of what hangs on it.

    Those that collide count, and where none does those that are seen. None where there is no round one: a mesh or a box
    does not say what it rolls on.
    """
    joint = robot.joint[name]
    axis = unit(joint.axis)
    for purpose in ("collision", "visual"):
        found = [
            reach
            for link, where in _below(robot, joint.child)
            for shape in getattr(robot.link[link], purpose)
            for reach in _reaches(shape, where, axis)
        ]
        if found:
            return max(found)
    return None


def _below(robot: Robot, link: str) -> Iterator[tuple[str, Transform]]:
    """Yield a link and those that hang on it, at zero, and where they sit in it."""
    waiting = [(link, Transform())]
    while waiting:
        name, where = waiting.pop()
        yield name, where
        waiting += [(one.child, where.then(one.transform())) for one in robot.joints_from.get(name, ()) if one.moves]
        waiting += [
            (one.child, where.then(one.origin.transform())) for one in robot.joints_from.get(name, ()) if one.is_fixed
        ]


def _reaches(shape: Shape, where: Transform, axis: Vector) -> Iterator[float]:
    """Yield how far a round shape reaches from an axis through the origin (m); nothing for one that is not round."""
    geometry, place = shape.geometry, where.then(shape.pose.transform())
    if isinstance(geometry, Sphere):
        yield _from_axis(place.xyz, axis) + geometry.radius
    elif isinstance(geometry, (Capsule, Cylinder)):
        ends = [(0.0, 0.0, side * geometry.length / 2) for side in (-1, 1)]
        if isinstance(geometry, Capsule):
            yield max(_from_axis(place.apply(end), axis) for end in ends) + geometry.radius
            return
        if abs(math.sin(angle_between(place.rotate((0.0, 0.0, 1.0)), axis))) < _ALONG:
            yield _from_axis(place.xyz, axis) + geometry.radius
            return
        edge = [
            (geometry.radius * math.cos(angle), geometry.radius * math.sin(angle), end[2])
            for angle in (math.tau * step / _AROUND for step in range(_AROUND))
            for end in ends
        ]
        yield max(_from_axis(place.apply(point), axis) for point in edge)


def _from_axis(point: Vector, axis: Vector) -> float:
    along = dot(point, axis)
    return norm(minus(point, (along * axis[0], along * axis[1], along * axis[2])))

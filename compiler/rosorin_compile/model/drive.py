"""The drive of a robot and its kinematics: wheel speeds for a velocity of the base, and back.

One equation describes all kinds of bases. A wheel at p (from the centre of the drive) that turns at w has a rim speed
of w * r along the ``direction`` d in which it rolls. It cannot slip along its ``grip`` g, so hub and rim have the same
speed along g:

    g . (v + wz * (-p.y, p.x)) = w * r * (g . d)

For a plain wheel and for an omni wheel, which slides along its axle, g is d. For a mecanum wheel g is the axis of the
roller that touches the ground, half-way between d and the axle. Sources: ros2_controllers
(mecanum_drive_controller.cpp, mobile_robot_kinematics.rst); K. M. Lynch, F. C. Park, "Modern Robotics" (2017), 13.2.

A steered wheel is turned into its direction of travel, by at most a quarter turn. Velocities are those of the centre of
the drive in the axes of the base frame (REP 103). The centre is the middle of the four wheels (mecanum), of all wheels
(omni), of the axle between left and right (differential), or of the axle that is not steered (tricycle, ackermann).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.cache import of_robot

from .bounds import radius_about
from .geometry import Transform, Vector, dot, unit
from .link import NO_SOURCE, Source
from .shape import Capsule, Cylinder, Sphere

if TYPE_CHECKING:
    from .robot import Robot

MECANUM, DIFFERENTIAL, OMNI, TRICYCLE, ACKERMANN = "mecanum", "differential", "omni", "tricycle", "ackermann"

# The roles of joints for each kind of drive, in the order in which they are printed.
ROLES: Mapping[str, tuple[str, ...]] = {
    MECANUM: ("front_left", "rear_left", "front_right", "rear_right"),
    DIFFERENTIAL: ("left", "right"),
    OMNI: ("wheels",),
    TRICYCLE: ("steering", "driven", "rolling"),
    ACKERMANN: ("steering", "driven", "rolling"),
}
STEERED = (TRICYCLE, ACKERMANN)
SLIDING = (MECANUM, OMNI)  # drives that can move sideways

# The grip direction (x, y) of mecanum wheels in the X layout, not normalized. Seen from above, the axes of the upper
# rollers point at the centre, so the axes of the rollers on the ground are perpendicular to that.
_GRIPS = {"front_left": (1.0, -1.0), "rear_left": (1.0, 1.0), "front_right": (1.0, 1.0), "rear_right": (1.0, -1.0)}
_SINGULAR = 1e-9


@dataclass(frozen=True)
class Drive:
    """The drive of a mobile base: its kind and its joints."""

    kind: str  # a key of ``ROLES``
    joints: Mapping[str, tuple[str, ...]]  # joint names by role
    frame: str = ""  # the base frame, or "" for the root link
    radius: float | None = None  # wheel radius (m), or None to use the radii of the wheel shapes
    source: Source = NO_SOURCE

    @property
    def wheels(self) -> tuple[str, ...]:
        """The names of the driven wheel joints, without duplicates."""
        roles = ("driven",) if self.kind in STEERED else ROLES[self.kind]
        return tuple(dict.fromkeys(name for role in roles for name in self.joints.get(role, ())))

    @property
    def steering(self) -> tuple[str, ...]:
        return self.joints.get("steering", ())

    @property
    def slides(self) -> bool:
        """Whether the base can move sideways."""
        return self.kind in SLIDING


class Twist(NamedTuple):
    """A velocity of the base: ``vx`` forward and ``vy`` to the left (m/s), ``wz`` counter-clockwise (rad/s)."""

    vx: float = 0.0
    vy: float = 0.0
    wz: float = 0.0


class Wheel(NamedTuple):
    """A driven wheel: its position relative to the centre of the drive (m) and its radius (m)."""

    joint: str
    x: float
    y: float
    radius: float
    direction: tuple[float, float]  # rolling direction (x, y) for positive joint velocity, if not steered
    grip: tuple[float, float]  # direction (x, y) in which the wheel cannot slip, if not steered
    steering: str = ""  # the joint that steers the wheel, or "" for an unsteered wheel


class Steering(NamedTuple):
    """A steering joint and its position relative to the centre of the drive (m)."""

    joint: str
    x: float
    y: float
    sign: float  # -1 if the joint axis points down, else 1


class DriveKinematics(NamedTuple):
    """The kinematics of a drive. Velocities are those of the point ``centre`` (x, y in m) in ``frame``."""

    kind: str
    frame: str
    centre: tuple[float, float]
    wheels: tuple[Wheel, ...]
    steering: tuple[Steering, ...] = ()
    wheelbase: float = 0.0  # m; zero if this kind of drive has no wheelbase
    track: float = 0.0  # m; zero if this kind of drive has no track

    @property
    def slides(self) -> bool:
        return self.kind in SLIDING

    def angles(self, twist: Twist) -> dict[str, float]:
        """Return the steering joint positions (rad, by joint name) for a velocity of the base; all are zero at rest."""
        angles = {}
        for axis in self.steering:
            forward, left = twist.vx - twist.wz * axis.y, twist.wz * axis.x
            if forward < 0:
                forward, left = -forward, -left
            angles[axis.joint] = axis.sign * (math.atan2(left, forward) if forward or left else 0.0)
        return angles

    def speeds(self, twist: Twist, angles: Mapping[str, float] | None = None) -> dict[str, float]:
        """Return the wheel speeds (rad/s, by joint name) for a velocity of the base.

        ``angles`` are the current steering joint positions (rad, by joint name), by default those that the velocity
        requires.
        """
        twist = twist if self.slides else twist._replace(vy=0.0)
        angles = self.angles(twist) if angles is None else angles
        rows = {wheel.joint: self._row(wheel, angles) for wheel in self.wheels}
        return {joint: dot(row, twist) / rolled for joint, (row, rolled) in rows.items()}

    def velocity(self, speeds: Mapping[str, float], angles: Mapping[str, float] | None = None) -> Twist:
        """Return the velocity of the base for wheel speeds (rad/s) and steering joint positions (rad), by joint name.

        Missing speeds and positions are zero. Contradictory speeds are fitted by least squares. Raises ValueError if
        the wheels do not determine the velocity.
        """
        angles = angles or {}
        equations = [(self._row(wheel, angles), speeds.get(wheel.joint, 0.0)) for wheel in self.wheels]
        rows = [(*row, rolled * speed) for (row, rolled), speed in equations]
        for axis in self.steering:
            angle = axis.sign * angles.get(axis.joint, 0.0)
            rows.append((*_coefficients((-math.sin(angle), math.cos(angle)), axis.x, axis.y), 0.0))
        if self.slides:
            return Twist(*_least_squares(rows))
        vx, wz = _least_squares([(row[0], *row[2:]) for row in rows])
        return Twist(vx, 0.0, wz)

    def _row(self, wheel: Wheel, angles: Mapping[str, float]) -> tuple[Vector, float]:
        (gx, gy), (dx, dy), angle, x, y = wheel.grip, wheel.direction, 0.0, wheel.x, wheel.y
        for axis in (axis for axis in self.steering if axis.joint == wheel.steering):
            angle, x, y = axis.sign * angles.get(axis.joint, 0.0), axis.x, axis.y
        sine, cosine = math.sin(angle), math.cos(angle)
        grip = (cosine * gx - sine * gy, sine * gx + cosine * gy)
        return _coefficients(grip, x, y), wheel.radius * (gx * dx + gy * dy)


def _coefficients(direction: tuple[float, float], x: float, y: float) -> Vector:
    return (direction[0], direction[1], direction[1] * x - direction[0] * y)


def _least_squares(rows: Sequence[Sequence[float]]) -> list[float]:
    size = len(rows[0]) - 1 if rows else 0
    normal = [[sum(row[i] * row[j] for row in rows) for j in range(size + 1)] for i in range(size)]
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
def drive_kinematics(robot: Robot) -> DriveKinematics:
    """Return the kinematics of a drive, with all joints at zero. Raises ValueError if there is no valid drive."""
    drive = robot.drive
    if drive is None:
        raise ValueError(f'the robot "{robot.name}" has no drive')
    at = {name: place_in_base(robot, drive, name) for names in drive.joints.values() for name in names}

    def middle(*roles: str) -> tuple[float, float]:
        points = [at[name] for role in roles for name in drive.joints[role]]
        return (sum(p[0] for p in points) / len(points), sum(p[1] for p in points) / len(points))

    wheelbase, track, roles = 0.0, 0.0, [role for role in ROLES[drive.kind] if drive.joints.get(role)]
    if drive.kind == DIFFERENTIAL:
        track = middle("left")[1] - middle("right")[1]
    elif drive.kind == MECANUM:
        wheelbase = middle("front_left", "front_right")[0] - middle("rear_left", "rear_right")[0]
        track = middle("front_left", "rear_left")[1] - middle("front_right", "rear_right")[1]
    elif drive.kind in STEERED:
        roles = ["rolling" if drive.joints.get("rolling") else "driven"]
        sides = [at[name][1] for name in drive.joints[roles[0]]]
        wheelbase, track = abs(middle("steering")[0] - middle(*roles)[0]), max(sides) - min(sides)
    centres = [middle(role) for role in roles] if drive.kind == DIFFERENTIAL else [middle(*roles)]
    x, y = (sum(values) / len(centres) for values in zip(*centres, strict=True))
    steering = tuple(
        Steering(name, at[name][0] - x, at[name][1] - y, math.copysign(1, axis_in_base(robot, drive, name)[2]))
        for name in drive.steering
    )
    wheels = []
    for name in drive.wheels:
        radius = drive.radius if drive.radius is not None else rolling_radius(robot, name)
        if radius is None:
            raise ValueError(f'the shapes of the wheel of joint "{name}" do not say its radius')
        ax, ay, _ = axis_in_base(robot, drive, name)
        across = math.hypot(ax, ay)
        if not across:
            raise ValueError("a wheel that lies flat rolls nowhere")
        direction = grip = (ay / across, -ax / across)
        if drive.kind == MECANUM:
            grip = _GRIPS[next(role for role, members in drive.joints.items() if name in members)]
        steered_by = steering_of(robot, drive, name)
        wheels.append(Wheel(name, at[name][0] - x, at[name][1] - y, radius, direction, grip, steered_by))
    return DriveKinematics(drive.kind, drive.frame or robot.root, (x, y), tuple(wheels), steering, wheelbase, track)


def axis_in_base(robot: Robot, drive: Drive, name: str) -> Vector:
    """Return the axis of a joint in the base frame (unit vector), with all joints at zero."""
    joint = robot.joint[name]
    return unit(robot.transform(drive.frame or robot.root, joint.child).rotate(joint.axis))


def place_in_base(robot: Robot, drive: Drive, name: str) -> Vector:
    """Return the position of a joint in the base frame (m), with all joints at zero."""
    return robot.transform(drive.frame or robot.root, robot.joint[name].child).xyz


def steering_of(robot: Robot, drive: Drive, name: str) -> str:
    """Return the name of the joint that steers the wheel joint ``name``, or "" if no joint steers it."""
    above = [joint.name for joint in robot.chain(robot.joint[name].parent)]
    return next((axis for axis in drive.steering if axis in above), "")


@of_robot
def rolling_radius(robot: Robot, name: str) -> float | None:
    """Return the radius (m) of the round collision shapes of a wheel, else of its round visuals, else None."""
    joint = robot.joint[name]
    below = [(joint.child, Transform())]
    for link, place in below:
        for next_joint in robot.joints_from.get(link, ()):
            if next_joint.moves or next_joint.is_fixed:
                below.append((next_joint.child, place.then(next_joint.transform())))
    for purpose in ("collision", "visual"):
        shapes = [(shape, place) for link, place in below for shape in getattr(robot.link[link], purpose)]
        round_ones = [one for one in shapes if isinstance(one[0].geometry, (Sphere, Capsule, Cylinder))]
        if round_ones and any(joint.axis):
            return radius_about(round_ones, joint.axis)
    return None

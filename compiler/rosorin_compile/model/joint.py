"""Joints between links, with their limits, dynamics and the publisher of their transform."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from .geometry import IDENTITY, Pose, Transform, Vector, plane_axes, plus, rotation_about, unit
from .link import NO_SOURCE, Source
from .simulation import Actuator, Values

ROBOT_STATE_PUBLISHER = "robot_state_publisher"
STATIC_TRANSFORM_PUBLISHER = "static_transform_publisher"
UNPUBLISHED = "none"
NODE = "node"

MOVING_TYPES = ("revolute", "continuous", "prismatic")
SEVERAL_COORDINATES = ("planar", "floating", "ball")
# Joint types without an axis, because they rotate in every direction.
AXLELESS = ("floating", "ball")
# Names of the position coordinates (rad or m) by joint type; a quaternion may have any length except zero.
COORDINATES: Mapping[str, tuple[str, ...]] = {
    "fixed": (),
    **dict.fromkeys(MOVING_TYPES, ("position",)),
    "planar": ("x", "y", "angle"),
    "floating": ("x", "y", "z", "qx", "qy", "qz", "qw"),
    "ball": ("qx", "qy", "qz", "qw"),
}


def motion(kind: str, axis: Vector, position: float | Sequence[float]) -> Transform:
    """Return the pose of the child frame in the joint frame at a joint position.

    The position is one number (rad or m) per coordinate in ``COORDINATES``, or 0.0 for the zero position of any joint.
    The x and y axes of a planar joint are those of ``plane_axes``, and its angle is about the normal. Raises ValueError
    for a wrong number of coordinates, for a zero axis, and for a quaternion of length zero.
    """
    names = COORDINATES[kind]
    numbers: Sequence[float] = position if isinstance(position, Sequence) else (position,)
    if kind in SEVERAL_COORDINATES and position == 0.0:
        numbers = (*(0.0 for _ in names[1:]), 0.0 if kind == "planar" else 1.0)
    if names and (len(numbers) != len(names) or (isinstance(position, Sequence) and len(names) == 1)):
        raise ValueError(f"the position of a {kind} joint is {', '.join(names)}, not {len(numbers)} numbers")
    if kind == "fixed":
        return Transform()
    if kind in ("revolute", "continuous"):
        return Transform(rotation_about(axis, numbers[0]))
    if kind == "prismatic":
        return Transform(xyz=_along(axis, numbers[0]))
    if kind == "planar":
        first, second = plane_axes(axis)
        return Transform(rotation_about(axis, numbers[2]), plus(_along(first, numbers[0]), _along(second, numbers[1])))
    *xyz, qx, qy, qz, qw = numbers
    x, y, z = xyz or (0.0, 0.0, 0.0)
    return Transform.of_quaternion((x, y, z), (qw, qx, qy, qz))


def _along(axis: Vector, distance: float) -> Vector:
    if not any(axis):
        raise ValueError("a motion needs an axis that is not zero")
    x, y, z = unit(axis)
    return (x * distance, y * distance, z * distance)


@dataclass(frozen=True)
class Limit:
    """Joint limits, each None if not set."""

    lower: float | None = None  # rad or m
    upper: float | None = None  # rad or m
    effort: float | None = None  # N*m or N
    velocity: float | None = None  # rad/s or m/s
    stand_ins: tuple[str, ...] = field(default=(), compare=False, repr=False)  # names of limits with placeholder values

    def known_value(self, key: str) -> float | None:
        """Return a limit by its name, or None if it is missing or a stand-in (a placeholder value)."""
        value: float | None = None if key in self.stand_ins else getattr(self, key)
        return value


@dataclass(frozen=True)
class Mimic:
    """A mimic relation: position = multiplier * (position of the leader ``joint``) + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0
    solref: tuple[float, ...] = field(default=(), compare=False)  # MuJoCo solver parameters
    solimp: tuple[float, ...] = field(default=(), compare=False)  # MuJoCo solver parameters; () for the default
    name: str = field(default="", compare=False)  # name of the MuJoCo equality constraint, or "" to use the joint name


@dataclass(frozen=True)
class Dynamics:
    """Damping, friction, inertia and spring of a joint."""

    damping: float = 0.0  # N*m*s/rad
    friction: float = 0.0  # N*m
    armature: float = 0.0  # rotor inertia reflected to the joint, kg*m^2
    stiffness: float = 0.0  # spring stiffness, N*m/rad
    spring_reference: float = 0.0  # the position at which the spring is relaxed, rad or m


@dataclass(frozen=True)
class Calibration:
    """Joint positions (rad or m) at the edges of a reference signal that calibrates the joint, or None if not set."""

    rising: float | None = None
    falling: float | None = None
    reference_position: float | None = None


@dataclass(frozen=True)
class SafetyController:
    """The safety controller of a joint: its gains and soft limits, None if not set."""

    k_velocity: float  # N*m*s/rad or N*s/m
    k_position: float | None = None  # 1/s
    soft_lower_limit: float | None = None  # rad or m
    soft_upper_limit: float | None = None  # rad or m


@dataclass(frozen=True)
class Publisher:
    """The ROS node that publishes a transform on /tf or /tf_static."""

    kind: str  # ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, NODE or UNPUBLISHED
    name: str = ""  # name of the ROS node
    package: str = ""
    about: str = ""  # a remark or, for UNPUBLISHED, the reason
    stamps: tuple[str, ...] = ()  # frame_ids in the headers of messages that the node publishes
    simulated: bool = False  # True if the child frame and all frames below it exist only in simulations

    @property
    def publishes(self) -> bool:
        return self.kind != UNPUBLISHED


@dataclass(frozen=True, repr=False)
class Joint:
    """A joint that attaches the child link to the parent link."""

    name: str
    type: str
    parent: str
    child: str
    origin: Pose = IDENTITY  # the pose of the child in the parent at position zero
    axis: Vector = (1.0, 0.0, 0.0)  # for a planar joint, the normal of its plane
    limit: Limit | None = None
    mimic: Mimic | None = None
    dynamics: Dynamics | None = None
    actuator: Actuator | None = None
    publisher: Publisher = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
    source: Source = NO_SOURCE
    calibration: Calibration | None = None
    safety: SafetyController | None = None
    urdf_elements: tuple[str, ...] = ()
    mjcf: Values = field(default_factory=dict, hash=False)

    def __repr__(self) -> str:
        return f"<Joint {self.name}: {self.type}, {self.parent} -> {self.child}>"

    @property
    def moves(self) -> bool:
        """Whether the joint has one axis to move about or along: revolute, continuous or prismatic."""
        return self.type in MOVING_TYPES

    @property
    def unit(self) -> str:
        return "m" if self.type == "prismatic" else "rad"

    @property
    def is_axleless(self) -> bool:
        return self.type in AXLELESS

    @property
    def is_fixed(self) -> bool:
        return self.type == "fixed"

    @property
    def moves_on_tf(self) -> bool:
        """Whether the transform on /tf changes. robot_state_publisher publishes planar joints as if they were fixed."""
        return not self.is_fixed and not (self.type == "planar" and self.publisher.kind == ROBOT_STATE_PUBLISHER)

    @property
    def total_damping(self) -> float:
        """The total damping of the joint and its actuators, in N*m*s/rad or N*s/m."""
        return (self.dynamics.damping if self.dynamics else 0.0) + (self.actuator.damping if self.actuator else 0.0)

    def limits_of(self, interface: str) -> tuple[float | None, float | None]:
        """Return the (lower, upper) limit of "position", "velocity" or "effort", each None if missing or a stand-in."""
        limit = self.limit
        if limit is not None and interface == "position" and self.type != "continuous":
            return limit.known_value("lower"), limit.known_value("upper")
        size = limit.known_value(interface) if limit is not None and interface in ("velocity", "effort") else None
        return (None, None) if size is None else (-size, size)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates of a joint position, such as ("x", "y", "angle") for a planar joint."""
        return COORDINATES[self.type]

    def transform(self, position: float | Sequence[float] = 0.0) -> Transform:
        """Return the pose of the child in the parent at a joint position. Raises ValueError (see ``motion``)."""
        origin = self.origin.transform()
        return origin if self.is_fixed else origin.then(motion(self.type, self.axis, position))

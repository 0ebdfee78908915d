"""The robot: links, joints, the nodes that publish its frames, its poses, and what it is compiled to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from .geometry import IDENTITY, Pose, Transform, Vector, rotation_about
from .shape import Shape
from .simulated import Simulated

ROBOT_STATE_PUBLISHER = "robot_state_publisher"
STATIC_TRANSFORM_PUBLISHER = "static_transform_publisher"
UNPUBLISHED = "none"
NODE = "node"

MOVING_TYPES = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Source:
    """Where a value comes from: ``status`` is factory, measured, calculated, chosen or stand_in."""

    status: str = ""
    note: str = ""
    measured: str = ""


@dataclass(frozen=True)
class Inertial:
    """Mass (kg), the pose of the centre of mass, and the inertia (kg*m^2) about it along the axes of that pose."""

    mass: float
    pose: Pose
    ixx: float
    iyy: float
    izz: float
    ixy: float = 0.0
    ixz: float = 0.0
    iyz: float = 0.0


@dataclass(frozen=True)
class Link:
    """A rigid part, or a mere frame if it has no inertial and no shape."""

    name: str
    inertial: Inertial | None = None
    visual: tuple[Shape, ...] = ()
    collision: tuple[Shape, ...] = ()
    source: Source = Source()


@dataclass(frozen=True)
class Limit:
    """Limits of a joint: radians or metres, N*m or N, rad/s or m/s; None is not given."""

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: position = multiplier * leader + offset."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Dynamics:
    """Damping (N*m*s/rad), friction (N*m) and the inertia of the rotor seen at the joint (kg*m^2)."""

    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0


@dataclass(frozen=True)
class Actuator:
    """A position servo in simulation: gain ``kp`` (N*m/rad) and velocity gain ``kv`` (N*m*s/rad)."""

    kp: float
    kv: float = 0.0


@dataclass(frozen=True)
class Publisher:
    """Who puts an edge on /tf or /tf_static.

    ``kind`` is ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, NODE (any other node) or UNPUBLISHED. ``name`` is the
    name of the node; ``about`` says what is worth knowing, for UNPUBLISHED why nobody publishes it.
    """

    kind: str
    name: str = ""
    package: str = ""
    about: str = ""


@dataclass(frozen=True)
class Joint:
    """How the child link is attached to the parent link; ``origin`` is the child in the parent at position zero."""

    name: str
    type: str
    parent: str
    child: str
    origin: Pose = IDENTITY
    axis: Vector = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    mimic: Mimic | None = None
    dynamics: Dynamics | None = None
    actuator: Actuator | None = None
    publisher: Publisher = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
    source: Source = Source()

    @property
    def moves(self) -> bool:
        """Whether the joint has a position."""
        return self.type in MOVING_TYPES

    def transform(self, position: float = 0.0) -> Transform:
        """Return the child in the parent at a position (radians or metres)."""
        origin = self.origin.transform()
        if self.type in ("revolute", "continuous"):
            return origin.then(Transform(rotation_about(self.axis, position)))
        if self.type == "prismatic":
            length = sum(a * a for a in self.axis) ** 0.5
            x, y, z = (a / length * position for a in self.axis)
            return origin.then(Transform(xyz=(x, y, z)))
        return origin


@dataclass(frozen=True)
class Sensor:
    """A sensor and its frames; ``joint`` mounts ``frame``, ``optical_frame`` is empty for sensors without an image."""

    name: str
    type: str
    frame: str
    joint: str
    optical_frame: str = ""
    source: Source = Source()
    simulated: tuple[Simulated, ...] = ()


@dataclass(frozen=True)
class Edge:
    """A transform that another node owns. ``pose`` is None where only that node knows the numbers."""

    parent: str
    child: str
    publisher: Publisher
    moving: bool
    when: str = ""
    pose: Pose | None = None
    source: Source = Source()


@dataclass(frozen=True)
class ServoGroup:
    """Servos whose pulses map to joint angles: radians = sign * (pulse - zero_pulse) * rad_per_pulse."""

    name: str
    joints: tuple[str, ...]
    rad_per_pulse: float
    zero_pulse: int
    flipped: bool
    pulse_range: tuple[int, int]
    source: Source = Source()

    def radians(self, pulse: int) -> float:
        """Return the joint angle of a pulse; a flipped servo turns against its pulses."""
        difference = self.zero_pulse - pulse if self.flipped else pulse - self.zero_pulse
        return difference * self.rad_per_pulse


@dataclass(frozen=True)
class JointPose:
    """A named pose: positions in radians or metres by joint name; joints not named are at zero."""

    name: str
    positions: Mapping[str, float]
    pulses: Mapping[str, int] = field(default_factory=dict)
    source: Source = Source()


@dataclass(frozen=True)
class Output:
    """One artifact to emit: the backend, the file name in the outputs folder, and the backend's options."""

    name: str
    backend: str
    file: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Robot:
    """A whole robot. Links, joints and sensors stand in the order of the description."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    sensors: tuple[Sensor, ...] = ()
    edges: tuple[Edge, ...] = ()
    publishers: tuple[Publisher, ...] = ()
    servos: tuple[ServoGroup, ...] = ()
    poses: tuple[JointPose, ...] = ()
    outputs: tuple[Output, ...] = ()
    modes: tuple[str, ...] = ()
    disabled_contacts: tuple[tuple[str, str], ...] = ()
    source: Source = Source()

    @cached_property
    def link(self) -> Mapping[str, Link]:
        """The links by name."""
        return {link.name: link for link in self.links}

    @cached_property
    def joint(self) -> Mapping[str, Joint]:
        """The joints by name."""
        return {joint.name: joint for joint in self.joints}

    @cached_property
    def joint_to(self) -> Mapping[str, Joint]:
        """The joint that a link is the child of, by link name."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def joints_from(self) -> Mapping[str, tuple[Joint, ...]]:
        """The joints that leave a link, in the order of the description, by link name."""
        found: dict[str, list[Joint]] = {}
        for joint in self.joints:
            found.setdefault(joint.parent, []).append(joint)
        return {name: tuple(joints) for name, joints in found.items()}

    @cached_property
    def root(self) -> str:
        """The name of the link that is no joint's child."""
        return next(link.name for link in self.links if link.name not in self.joint_to)

    def walk(self) -> Iterator[Link]:
        """Yield the links from the root, parents before children, children in the order of their joints."""
        waiting = [self.root]
        while waiting:
            name = waiting.pop()
            yield self.link[name]
            waiting.extend(joint.child for joint in reversed(self.joints_from.get(name, ())))

    def joints_down(self) -> tuple[Joint, ...]:
        """Return the joints from the root down, as ``walk`` passes them."""
        return tuple(self.joint_to[link.name] for link in self.walk() if link.name in self.joint_to)

    def chain(self, link: str) -> tuple[Joint, ...]:
        """Return the joints from the root to a link."""
        found: list[Joint] = []
        while link in self.joint_to:
            found.append(self.joint_to[link])
            link = found[-1].parent
        return tuple(reversed(found))

    def position(self, joint: Joint, positions: Mapping[str, float]) -> float:
        """Return the position of a joint (radians or metres), through its leaders where it mimics another."""
        factor, offset = 1.0, 0.0
        while joint.mimic is not None:
            offset += factor * joint.mimic.offset
            factor *= joint.mimic.multiplier
            joint = self.joint[joint.mimic.joint]
        return factor * positions.get(joint.name, 0.0) + offset

    def pose_in_root(self, link: str, positions: Mapping[str, float]) -> Transform:
        """Return a link in the root frame at joint positions (radians or metres; joints not named are at zero)."""
        result = Transform()
        for joint in self.chain(link):
            result = result.then(joint.transform(self.position(joint, positions)))
        return result

    def transform(self, source: str, target: str, positions: Mapping[str, float]) -> Transform:
        """Return where ``target`` sits in ``source``, as tf2_echo SOURCE TARGET does."""
        return self.pose_in_root(source, positions).inverse().then(self.pose_in_root(target, positions))

    def published_by(self, kind: str) -> tuple[Joint, ...]:
        """Return the joints whose publisher is of a kind, in the order of the description."""
        return tuple(joint for joint in self.joints if joint.publisher.kind == kind)

    def fixed_neighbours(self, link: str) -> Iterator[tuple[str, Transform]]:
        """Yield the links joined to a link by one fixed joint, and where they sit in it; children before the parent."""
        for joint in self.joints_from.get(link, ()):
            if not joint.moves:
                yield joint.child, joint.origin.transform()
        above = self.joint_to.get(link)
        if above is not None and not above.moves:
            yield above.parent, above.origin.transform().inverse()

"""Values that only ROS reads: controllers of ros2_control, and planning groups and disabled collisions for MoveIt."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from .geometry import Vector
from .link import NO_SOURCE, Source

ADJACENT, DEFAULT, ALWAYS, NEVER, USER = "Adjacent", "Default", "Always", "Never", "User"
REASONS = (ADJACENT, DEFAULT, ALWAYS, NEVER, USER)
"""The words that MoveIt has for why a pair of links is not checked; any other is read as User."""

FIXED, PLANAR, FLOATING = "fixed", "planar", "floating"
VIRTUAL_JOINT = "virtual_joint"  # its name, where none is given

TRIALS, SEED, ALWAYS_SHARE, CLEARANCE = 10_000, 1, 0.95, 0.001

Pair = tuple[str, str]


@dataclass(frozen=True)
class Controller:
    """A controller: ``type`` as the description has it, ``params`` by their full keys (``a.b.c``).

    ``hardware`` is the block whose joints it moves, ``sensor`` the one that it speaks for; empty if not said.
    ``inactive``: it is configured when the robot starts, and somebody switches to it later.
    """

    name: str
    type: str
    params: Mapping[str, Any] = field(default_factory=dict)
    hardware: str = ""
    sensor: str = ""
    inactive: bool = False
    source: Source = NO_SOURCE


@dataclass(frozen=True)
class Group:
    """A planning group: all joints of a chain (base, tip), of the joints, of the links and of other groups.

    ``states`` has the poses that are states of it, by the name of the state; None: those that name all of its joints.
    """

    name: str
    chain: Pair | None = None
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    groups: tuple[str, ...] = ()
    states: Mapping[str, str] | None = None
    source: Source = NO_SOURCE


@dataclass(frozen=True)
class EndEffector:
    """A hand or a tool: the group that it consists of, the link that carries it, and the group that moves that link."""

    name: str
    group: str
    parent: str
    parent_group: str = ""
    source: Source = NO_SOURCE


@dataclass(frozen=True)
class VirtualJoint:
    """The joint between the world and the root of a URDF; what is empty is as the base says."""

    type: str = ""
    parent: str = ""
    name: str = VIRTUAL_JOINT


@dataclass(frozen=True)
class Ball:
    """One of the spheres that stand for a link: its middle in the link's frame, and its radius (m)."""

    xyz: Vector
    radius: float


@dataclass(frozen=True)
class DisabledCollision:
    """A pair of links that is not checked, and why: ``reason`` is one of ``REASONS``, the words of MoveIt.

    ``nearest`` is the smallest distance that was seen (m, below zero inside each other), ``beyond`` one that was never
    reached; None where nobody looked.
    """

    ADJACENT: ClassVar[str] = ADJACENT
    DEFAULT: ClassVar[str] = DEFAULT
    ALWAYS: ClassVar[str] = ALWAYS
    NEVER: ClassVar[str] = NEVER
    REASONS: ClassVar[tuple[str, ...]] = REASONS

    links: Pair
    reason: str = USER
    nearest: float | None = None
    beyond: float | None = None


@dataclass(frozen=True)
class CollisionSearch:
    """How a matrix is computed: how many states are tried, where they begin, and the share that counts as always.

    ``clearance`` is how near (m) a pair may come that is called Never.
    """

    trials: int = TRIALS
    seed: int = SEED
    always: float = ALWAYS_SHARE
    clearance: float = CLEARANCE


@dataclass(frozen=True)
class CollisionMatrix:
    """Pairs of links that need no check, as they were computed.

    ``of`` is a digest of what that was done of, ``states`` how many random states were tried, ``meshes`` the digests of
    mesh files by name. ``how``, ``shapes`` and ``joints`` are digests of the search, of the shapes of each link, and of
    each joint: by them a pair is known that is the same as then.
    """

    of: str
    states: int
    pairs: tuple[DisabledCollision, ...]
    meshes: Mapping[str, str] = field(default_factory=dict)
    how: str = ""
    shapes: Mapping[str, str] = field(default_factory=dict)
    joints: Mapping[str, str] = field(default_factory=dict)

    def renamed(self, link: Callable[[str], str], joint: Callable[[str], str]) -> CollisionMatrix:
        """Return it with other names of links and joints."""
        shapes = {link(name): digest for name, digest in self.shapes.items()}
        joints = {joint(name): digest for name, digest in self.joints.items()}
        return replace(self, pairs=_disabled(self.pairs, link), shapes=shapes, joints=joints)


def _disabled(pairs: tuple[DisabledCollision, ...], link: Callable[[str], str]) -> tuple[DisabledCollision, ...]:
    return tuple(replace(one, links=(link(one.links[0]), link(one.links[1]))) for one in pairs)


@dataclass(frozen=True)
class Moveit:
    """What the section ``moveit`` of a description says.

    ``urdf`` is the name of an output; empty: the one that robot_state_publisher reads. ``virtual_joint`` is None where
    there is to be none. ``unchecked_links`` touch nothing but what is named in ``checked``. ``spheres`` stand for a
    link, by its name; ``joint_properties`` has words that planners read, by joint and by name.
    """

    urdf: str = ""
    groups: tuple[Group, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    virtual_joint: VirtualJoint | None = VirtualJoint()
    passive_joints: tuple[str, ...] = ()
    disabled: tuple[DisabledCollision, ...] = ()
    checked: tuple[Pair, ...] = ()
    unchecked_links: tuple[str, ...] = ()
    spheres: Mapping[str, tuple[Ball, ...]] = field(default_factory=dict)
    joint_properties: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    search: CollisionSearch = CollisionSearch()
    matrix: CollisionMatrix | None = None

    @property
    def own_names(self) -> Mapping[str, Collection[str]]:
        """What may be named here, and is nothing of the robot, by kind: the virtual joint."""
        return {"joint": (self.virtual_joint.name,)} if self.virtual_joint is not None else {}

    def renamed(self, link: Callable[[str], str], joint: Callable[[str], str]) -> Moveit:
        """Return it with other names of links and joints."""
        return replace(
            self,
            groups=tuple(
                replace(
                    one,
                    chain=one.chain and (link(one.chain[0]), link(one.chain[1])),
                    joints=tuple(map(joint, one.joints)),
                    links=tuple(map(link, one.links)),
                )
                for one in self.groups
            ),
            end_effectors=tuple(replace(one, parent=link(one.parent)) for one in self.end_effectors),
            passive_joints=tuple(map(joint, self.passive_joints)),
            disabled=_disabled(self.disabled, link),
            checked=tuple((link(one), link(other)) for one, other in self.checked),
            unchecked_links=tuple(map(link, self.unchecked_links)),
            spheres={link(name): balls for name, balls in self.spheres.items()},
            joint_properties={joint(name): said for name, said in self.joint_properties.items()},
            matrix=self.matrix and self.matrix.renamed(link, joint),
        )

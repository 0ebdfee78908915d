"""What MoveIt has to know of a robot beside its URDF: groups of joints, end effectors, pairs that need no check.

Which joints a group has is a question about one URDF: ``formats.srdf.planning`` answers it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .link import NO_SOURCE, Source

ADJACENT, DEFAULT, ALWAYS, NEVER, USER = "Adjacent", "Default", "Always", "Never", "User"
REASONS = (ADJACENT, DEFAULT, ALWAYS, NEVER, USER)
"""The words that MoveIt has for why a pair of links is not checked; any other is read as User."""

FIXED, PLANAR, FLOATING = "fixed", "planar", "floating"
VIRTUAL_JOINT = "virtual_joint"  # its name, where none is given

TRIALS, SEED, ALWAYS_SHARE, CLEARANCE = 10_000, 1, 0.95, 0.001

Pair = tuple[str, str]


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
class DisabledCollision:
    """A pair of links that is not checked, and why.

    ``nearest`` is the smallest distance that was seen (m, below zero inside each other), ``beyond`` one that was never
    reached; None where nobody looked.
    """

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
    mesh files by name.
    """

    of: str
    states: int
    pairs: tuple[DisabledCollision, ...]
    meshes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Moveit:
    """What the section ``moveit`` of a description says.

    ``urdf`` is the name of an output; empty: the one that robot_state_publisher reads. ``virtual_joint`` is None where
    there is to be none.
    """

    urdf: str = ""
    groups: tuple[Group, ...] = ()
    end_effectors: tuple[EndEffector, ...] = ()
    virtual_joint: VirtualJoint | None = VirtualJoint()
    passive_joints: tuple[str, ...] = ()
    disabled: tuple[DisabledCollision, ...] = ()
    checked: tuple[Pair, ...] = ()
    search: CollisionSearch = CollisionSearch()
    matrix: CollisionMatrix | None = None

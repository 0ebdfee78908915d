"""The value of the section ``moveit``: planning groups, end effectors, and pairs of links that need no check."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from rosorin_compile.model import DisabledCollision, Vector
from rosorin_compile.model.link import NO_SOURCE, Source

FIXED, PLANAR, FLOATING = "fixed", "planar", "floating"

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
    name: str = "virtual_joint"


@dataclass(frozen=True)
class Ball:
    """One of the spheres that stand for a link: its middle in the link's frame, and its radius (m)."""

    xyz: Vector
    radius: float


@dataclass(frozen=True)
class CollisionSearch:
    """How a matrix is computed: how many states are tried, where they begin, and the share that counts as always.

    ``clearance`` is how near (m) a pair may come that is called Never.
    """

    trials: int = 10_000
    seed: int = 1
    always: float = 0.95
    clearance: float = 0.001


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

"""The section ``moveit``: what MoveIt needs to know about a robot in addition to its URDF."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rosorin_compile.language.lower import Problem, record_of, vector_of
from rosorin_compile.model import DisabledCollision, Vector
from rosorin_compile.model.link import NO_SOURCE, Source
from rosorin_compile.model.sections import Section
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path, exists

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
    """How a matrix is computed: states, seed, the share that counts as always, and the least distance (m) for never."""

    trials: int = 10_000
    seed: int = 1
    always: float = 0.95
    clearance: float = 0.001


@dataclass(frozen=True)
class CollisionMatrix:
    """Pairs of links that need no check, as they were computed.

    ``of`` is a digest of everything it was computed from, ``states`` how many random states were tried, ``meshes`` the
    digests of mesh files by name. ``how``, ``shapes`` and ``joints`` are digests of the search, of the shapes of each
    link, and of each joint: they show which pairs have not changed since.
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
        """The names, by kind, that the section may use although the robot does not have them: the virtual joint."""
        return {"joint": (self.virtual_joint.name,)} if self.virtual_joint is not None else {}


def moveit_of(tree: Mapping[str, Any], _: Problem) -> Moveit | None:
    """Return the section ``moveit`` of a description; rules report the problems in it."""
    entry = tree["moveit"]
    if not entry:
        return None
    groups = []
    for name, one in (entry.get("groups") or {}).items():
        chain, states = one.get("chain"), one.get("states")
        ends = None if chain is None else (chain["base"], chain["tip"])
        states = {state: state for state in states} if isinstance(states, list) else states
        groups.append(record_of(Group, one, name=name, chain=ends, states=states))
    virtual, matrix = entry.get("virtual_joint", True), entry.get("collision_matrix")
    return record_of(
        Moveit,
        entry,
        groups=tuple(groups),
        virtual_joint=None if virtual is False else record_of(VirtualJoint, {} if virtual is True else virtual),
        disabled=tuple(record_of(DisabledCollision, one) for one in entry.get("disabled_collisions") or ()),
        checked=tuple((first, second) for first, second in entry.get("checked_collisions") or ()),
        spheres={
            link: tuple(record_of(Ball, one, xyz=vector_of(one.get("xyz"))) for one in balls)
            for link, balls in (entry.get("spheres") or {}).items()
        },
        joint_properties={
            joint: {name: value if isinstance(value, str) else exact(value) for name, value in properties.items()}
            for joint, properties in (entry.get("joint_properties") or {}).items()
        },
        search=record_of(CollisionSearch, entry.get("collisions")),
        matrix=matrix and record_of(CollisionMatrix, matrix),
    )


@rule("moveit-unknown-group", "A name is that of no planning group.", "Correct the name.", Heading.OUTPUTS)
@rule("moveit-unknown-pose", "A state of a group is a pose that there is not.", "Correct the name.", Heading.OUTPUTS)
def planning(case: Case) -> Iterator[Diagnostic]:
    """Find planning groups and poses that a section for planners names and that are not there."""
    said = case.robot.moveit
    if said is None:
        return
    groups, poses = [group.name for group in said.groups], [pose.name for pose in case.robot.poses]
    for id, kind, known, otherwise in (
        ("moveit-unknown-group", "planning group", groups, "name a group of moveit"),
        ("moveit-unknown-pose", "pose", poses, "add it to poses"),
    ):
        for one in [one for one in case.mentions(kind) if one.name not in known]:
            help = case.suggest(one.path, one.name, known, otherwise)
            yield case.problem(id, f'there is no {kind} "{one.name}", {one.what}', one.path, help)


def state_path(case: Case, group: Group, state: str) -> Path:
    """Return the path of a state of a planning group: its key, or its place in a list."""
    path: Path = ("moveit", "groups", group.name, "states")
    return (*path, state) if exists(case.tree, (*path, state)) else (*path, list(group.states or ()).index(state))


SECTION: Section[Moveit | None] = Section("moveit", lower=moveit_of, checks=(planning,))

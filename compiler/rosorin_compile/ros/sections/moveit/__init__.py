"""The section ``moveit``: data that MoveIt needs in addition to the URDF, such as planning groups."""

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
    """A planning group: the joints of a chain (base, tip), listed joints, parent joints of links, and subgroups.

    ``states`` maps state names to pose names. If it is None, all poses that set every joint of the group are states.
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
    """An end effector: its group, the link that it is mounted on (``parent``), and the group that moves this link."""

    name: str
    group: str
    parent: str
    parent_group: str = ""
    source: Source = NO_SOURCE


@dataclass(frozen=True)
class VirtualJoint:
    """The joint between the world and the root link; a field that is "" gets a default that suits the robot."""

    type: str = ""
    parent: str = ""
    name: str = "virtual_joint"


@dataclass(frozen=True)
class Ball:
    """A sphere that approximates a part of a link: its centre in the link frame (m), and its radius (m)."""

    xyz: Vector
    radius: float


@dataclass(frozen=True)
class CollisionSearch:
    """Settings for computing the collision matrix: the number of random states (``trials``) and their seed.

    Pairs that collide in more than the fraction ``always`` of the states, or that stay farther apart than ``clearance``
    (m), need no check.
    """

    trials: int = 10_000
    seed: int = 1
    always: float = 0.95
    clearance: float = 0.001


@dataclass(frozen=True)
class CollisionMatrix:
    """Link pairs that MoveIt need not check for collisions; ``states`` is the number of random states that were tried.

    ``of`` is a digest of all inputs. The other digests show which pairs must be computed again: ``meshes`` by file,
    ``shapes`` by link, ``joints`` by joint, and ``how`` for the search settings.
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
    """The section ``moveit``; ``urdf`` is the name of an output, or "" for the URDF of robot_state_publisher.

    ``virtual_joint`` is None if it is disabled. MoveIt does not check ``unchecked_links`` for collisions, except for
    the pairs in ``checked``. ``spheres`` approximate the shapes of links; ``joint_properties`` are settings for
    planners, by joint and name.
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
        """Names in this section that other sections can refer to, by kind of object: the virtual joint is a "joint"."""
        return {"joint": (self.virtual_joint.name,)} if self.virtual_joint is not None else {}


def moveit_of(tree: Mapping[str, Any], _: Problem) -> Moveit | None:
    """Parse the section ``moveit``, or return None if it is empty; rules report its problems."""
    if not (entry := tree["moveit"]):
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
def planning_names(case: Case) -> Iterator[Diagnostic]:
    """Report unknown planning groups and poses."""
    if (said := case.robot.moveit) is None:
        return
    groups, poses = [group.name for group in said.groups], [pose.name for pose in case.robot.poses]
    for id, kind, known, otherwise in (
        ("moveit-unknown-group", "planning group", groups, 'use a group of "moveit"'),
        ("moveit-unknown-pose", "pose", poses, 'add it to "poses"'),
    ):
        for one in [one for one in case.mentions(kind) if one.name not in known]:
            help = case.suggest(one.path, one.name, known, otherwise)
            yield case.problem(id, f'there is no {kind} "{one.name}" ({one.what})', one.path, help)


def state_path(case: Case, group: Group, state: str) -> Path:
    """Return the path of a state in the description: by name if ``states`` is a mapping, by index if it is a list."""
    path: Path = ("moveit", "groups", group.name, "states")
    return (*path, state) if exists(case.tree, (*path, state)) else (*path, list(group.states or ()).index(state))


SECTION: Section[Moveit | None] = Section("moveit", lower=moveit_of, checks=(planning_names,))

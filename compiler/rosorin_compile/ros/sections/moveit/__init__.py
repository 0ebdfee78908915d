"""The section ``moveit``: what MoveIt has to know of a robot besides its URDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.language.lower import Problem, record_of, vector_of
from rosorin_compile.model import DisabledCollision
from rosorin_compile.model.sections import Section
from rosorin_compile.ros.moveit import Ball, CollisionMatrix, CollisionSearch, Group, Moveit, VirtualJoint
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path, exists


def moveit_of(tree: Mapping[str, Any], _: Problem) -> Moveit | None:
    """Return what a description says for MoveIt; all that can be wrong with it is told by rules."""
    entry = tree["moveit"]
    if not entry:
        return None
    matrix = entry.get("collision_matrix")
    return record_of(
        Moveit,
        entry,
        groups=tuple(_group_of(name, one) for name, one in (entry.get("groups") or {}).items()),
        virtual_joint=_virtual_joint_of(entry.get("virtual_joint", True)),
        disabled=tuple(record_of(DisabledCollision, one) for one in entry.get("disabled_collisions") or ()),
        checked=tuple(map(_pair_of, entry.get("checked_collisions") or ())),
        spheres={
            link: tuple(record_of(Ball, one, xyz=vector_of(one.get("xyz"))) for one in balls)
            for link, balls in (entry.get("spheres") or {}).items()
        },
        joint_properties={
            joint: {name: value if isinstance(value, str) else exact(value) for name, value in said.items()}
            for joint, said in (entry.get("joint_properties") or {}).items()
        },
        search=record_of(CollisionSearch, entry.get("collisions")),
        matrix=matrix and record_of(CollisionMatrix, matrix),
    )


def _group_of(name: str, entry: Mapping[str, Any]) -> Group:
    chain, states = entry.get("chain"), entry.get("states")
    return record_of(
        Group,
        entry,
        name=name,
        chain=None if chain is None else (chain["base"], chain["tip"]),
        states={state: state for state in states} if isinstance(states, list) else states,
    )


def _virtual_joint_of(entry: Any) -> VirtualJoint | None:
    if entry is False:
        return None
    return record_of(VirtualJoint, {} if entry is True else entry)


def _pair_of(names: Sequence[str]) -> tuple[str, str]:
    one, other = names
    return (one, other)


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
        for one in case.mentions(kind):
            if one.name not in known:
                help = case.suggest(one.path, one.name, known, otherwise)
                yield case.problem(id, f'there is no {kind} "{one.name}", {one.what}', one.path, help)


def state_path(case: Case, group: Group, state: str) -> Path:
    """Return the path of a state of a planning group: its key, or its place in a list."""
    path: Path = ("moveit", "groups", group.name, "states")
    return (*path, state) if exists(case.tree, (*path, state)) else (*path, list(group.states or ()).index(state))


SECTION: Section[Moveit | None] = Section("moveit", lower=moveit_of, checks=(planning,))

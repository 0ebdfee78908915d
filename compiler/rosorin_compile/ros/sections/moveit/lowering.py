"""The section ``moveit`` of a description as a value of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.language.lower.entries import Problem
from rosorin_compile.language.lower.plainly import record_of, vector_of
from rosorin_compile.model.moveit import (
    Ball,
    CollisionMatrix,
    CollisionSearch,
    DisabledCollision,
    EndEffector,
    Group,
    Moveit,
    VirtualJoint,
)
from rosorin_compile.source.numbers import exact


def moveit_of(tree: Mapping[str, Any], _: Problem) -> Moveit | None:
    """Return what a description says for MoveIt; all that can be wrong with it is told by rules."""
    entry = tree["moveit"]
    if not entry:
        return None
    matrix = entry.get("collision_matrix")
    return Moveit(
        urdf=entry.get("urdf", ""),
        groups=tuple(_group_of(name, one) for name, one in (entry.get("groups") or {}).items()),
        end_effectors=tuple(
            record_of(EndEffector, one, name=name) for name, one in (entry.get("end_effectors") or {}).items()
        ),
        virtual_joint=_virtual_joint_of(entry.get("virtual_joint", True)),
        passive_joints=tuple(map(str, entry.get("passive_joints") or ())),
        disabled=tuple(_disabled_of(one) for one in entry.get("disabled_collisions") or ()),
        checked=tuple(map(_pair_of, entry.get("checked_collisions") or ())),
        unchecked_links=tuple(map(str, entry.get("unchecked_links") or ())),
        spheres={
            link: tuple(record_of(Ball, one, xyz=vector_of(one.get("xyz"))) for one in balls)
            for link, balls in (entry.get("spheres") or {}).items()
        },
        joint_properties={
            joint: {name: value if isinstance(value, str) else exact(value) for name, value in said.items()}
            for joint, said in (entry.get("joint_properties") or {}).items()
        },
        search=record_of(CollisionSearch, entry.get("collisions")),
        matrix=matrix and record_of(CollisionMatrix, matrix, pairs=tuple(map(_disabled_of, matrix["pairs"]))),
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


def _disabled_of(entry: Mapping[str, Any]) -> DisabledCollision:
    return record_of(DisabledCollision, entry)


def _pair_of(names: Sequence[str]) -> tuple[str, str]:
    one, other = names
    return (one, other)

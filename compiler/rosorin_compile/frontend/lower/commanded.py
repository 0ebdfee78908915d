"""What programs command: the sections ``drive`` (what moves a base) and ``moveit`` (what MoveIt has to know)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...diagnostics.registry import JOINTS, Rule
from ...diagnostics.wording import listed
from ...model.drive import ROLES, Drive
from ...numbers import exact
from .entries import Problem, source_of
from .plainly import record_of, vector_of

if TYPE_CHECKING:
    from ...model.moveit import DisabledCollision, Group, Moveit, VirtualJoint

RULES = (
    Rule(
        "drive-kind",
        "A drive says no kind of base, or several.",
        "One of `mecanum`, `differential`, `omni`, `tricycle`, `ackermann`, with its wheels.",
        JOINTS,
    ),
)


def drive_of(entry: Mapping[str, Any] | None, problem: Problem) -> Drive | None:
    """Return what drives a robot; ``problem`` takes what is wrong with it."""
    if entry is None:
        return None
    kinds = [kind for kind in ROLES if kind in entry]
    if len(kinds) != 1:
        message = f"drive has one of {', '.join(ROLES)}; this one has {listed(kinds) or 'none'}"
        problem("drive-kind", message, ("drive",), "say which kind of base it is, and its wheels")
        return None
    said = entry[kinds[0]]
    joints = {role: _names(said[role]) for role in ROLES[kinds[0]] if role in said}
    radius = float(entry["radius"]) if "radius" in entry else None
    return Drive(kinds[0], joints, entry.get("frame", ""), radius, source_of(entry.get("source")))


def _names(said: Any) -> tuple[str, ...]:
    return (str(said),) if isinstance(said, str) else tuple(map(str, said))


def moveit_of(entry: Mapping[str, Any]) -> Moveit:
    """Return what a description says for MoveIt."""
    from ...model.moveit import Ball, CollisionMatrix, CollisionSearch, EndEffector, Moveit

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
    from ...model.moveit import Group

    chain, states = entry.get("chain"), entry.get("states")
    return record_of(
        Group,
        entry,
        name=name,
        chain=None if chain is None else (chain["base"], chain["tip"]),
        states={state: state for state in states} if isinstance(states, list) else states,
    )


def _virtual_joint_of(entry: Any) -> VirtualJoint | None:
    from ...model.moveit import VirtualJoint

    if entry is False:
        return None
    return record_of(VirtualJoint, {} if entry is True else entry)


def _disabled_of(entry: Mapping[str, Any]) -> DisabledCollision:
    from ...model.moveit import DisabledCollision

    return record_of(DisabledCollision, entry)


def _pair_of(names: Sequence[str]) -> tuple[str, str]:
    one, other = names
    return (one, other)

"""What programs command: the sections ``drive`` (what moves a base) and ``moveit`` (what MoveIt has to know)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ...diagnostics.registry import JOINTS, Rule
from ...diagnostics.wording import listed
from ...model.drive import ROLES, Drive
from ...numbers import exact
from .entries import Problem, source_of, vector_of

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

    search: dict[str, Any] = _without_source(entry.get("collisions") or {})
    search |= {key: float(search[key]) for key in ("always", "clearance") if key in search}
    computed = entry.get("collision_matrix")
    return Moveit(
        urdf=entry.get("urdf", ""),
        groups=tuple(_group_of(name, one) for name, one in (entry.get("groups") or {}).items()),
        end_effectors=tuple(
            EndEffector(name, one["group"], one["parent"], one.get("parent_group", ""), source_of(one.get("source")))
            for name, one in (entry.get("end_effectors") or {}).items()
        ),
        virtual_joint=_virtual_joint_of(entry.get("virtual_joint", True)),
        passive_joints=tuple(map(str, entry.get("passive_joints") or ())),
        disabled=tuple(_disabled_of(one) for one in entry.get("disabled_collisions") or ()),
        checked=tuple(map(_pair_of, entry.get("checked_collisions") or ())),
        unchecked_links=tuple(map(str, entry.get("unchecked_links") or ())),
        spheres={
            link: tuple(Ball(vector_of(one.get("xyz")), float(one["radius"])) for one in balls)
            for link, balls in (entry.get("spheres") or {}).items()
        },
        joint_properties={
            joint: {name: value if isinstance(value, str) else exact(value) for name, value in said.items()}
            for joint, said in (entry.get("joint_properties") or {}).items()
        },
        search=CollisionSearch(**search),
        matrix=computed
        and CollisionMatrix(
            computed["of"],
            computed["states"],
            tuple(map(_disabled_of, computed["pairs"])),
            computed.get("meshes", {}),
            computed.get("how", ""),
            computed.get("shapes", {}),
            computed.get("joints", {}),
        ),
    )


def _group_of(name: str, entry: Mapping[str, Any]) -> Group:
    from ...model.moveit import Group

    chain, states = entry.get("chain"), entry.get("states")
    lists = {key: tuple(entry.get(key) or ()) for key in ("joints", "links", "groups")}
    return Group(
        name=name,
        chain=None if chain is None else (chain["base"], chain["tip"]),
        states={state: state for state in states} if isinstance(states, list) else states,
        source=source_of(entry.get("source")),
        **lists,
    )


def _virtual_joint_of(entry: Any) -> VirtualJoint | None:
    from ...model.moveit import VirtualJoint

    if entry is False:
        return None
    return VirtualJoint(**({} if entry is True else _without_source(entry)))


def _disabled_of(entry: Mapping[str, Any]) -> DisabledCollision:
    from ...model.moveit import USER, DisabledCollision

    distances = {key: float(entry[key]) for key in ("nearest", "beyond") if key in entry}
    return DisabledCollision(_pair_of(entry["links"]), entry.get("reason", USER), **distances)


def _pair_of(names: Sequence[str]) -> tuple[str, str]:
    one, other = names
    return (one, other)


def _without_source(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if key != "source"}

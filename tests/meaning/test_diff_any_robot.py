"""Diff on any robot: the same one written otherwise is the same, and one change is told once, by name."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import FRAME, JOINT, LIMIT, MASS, NAME, SHAPE, YAML, Item, Side
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Inertial,
    Joint,
    Limit,
    Link,
    Pose,
    Robot,
    Shape,
    Sphere,
    Transform,
)
from rosorin_compile.model.geometry import pose_of, rotation_about
from support.machines import _axis, robot_of

SEEDS = st.integers(0, 2**32)


def rewritten(robot: Robot, chance: random.Random) -> Robot:
    """Return the same robot, written otherwise: order, parents of fixed frames, owners and forms of shapes, axes."""
    links = {link.name: link for link in robot.links}
    tops: dict[str, str] = {}
    place: dict[str, Transform] = {}
    members: dict[str, list[str]] = {}
    for link in robot.walk():
        joint = robot.joint_to.get(link.name)
        if joint is None or not joint.is_fixed:
            tops[link.name], place[link.name] = link.name, Transform()
        else:
            tops[link.name] = tops[joint.parent]
            place[link.name] = place[joint.parent].then(joint.transform())
        members.setdefault(tops[link.name], []).append(link.name)
    joints = []
    for joint in robot.joints:
        group = members[tops[joint.child]] if joint.is_fixed else members[tops[joint.parent]]
        # Links that come before it in the walk can be its parent without a circle.
        before = group[: group.index(joint.child)] if joint.is_fixed else group
        parent = chance.choice(before)
        old = place[joint.parent].then(joint.origin.transform())
        joints.append(replace(joint, parent=parent, origin=pose_of(place[parent].inverse().then(old))))
    for group in members.values():
        for name in group:
            other = chance.choice(group)
            way = place[other].inverse().then(place[name])
            moved = [_other_form(shape, chance).move(way) for shape in links[name].collision]
            if other != name:
                links[name] = replace(links[name], collision=())
                links[other] = replace(links[other], collision=(*links[other].collision, *moved))
            else:
                links[name] = replace(links[name], collision=tuple(moved))
    turned = [replace(link, inertial=_turned(link.inertial, chance)) for link in links.values()]
    chance.shuffle(turned)
    chance.shuffle(joints)
    return replace(robot, links=tuple(turned), joints=tuple(joints))


def _other_form(shape: Shape, chance: random.Random) -> Shape:
    """Return the same solid in another pose of its own: turned about its symmetries."""
    turn = Transform()
    geometry = shape.geometry
    if isinstance(geometry, (Cylinder, Capsule)):
        turn = Transform(rotation_about((0.0, 0.0, 1.0), chance.uniform(-3, 3)))
    elif isinstance(geometry, Sphere):
        turn = Transform(rotation_about((0.0, 0.6, 0.8), chance.uniform(-3, 3)))
    elif isinstance(geometry, Box):
        turn = Transform(rotation_about((1.0, 0.0, 0.0), math.pi / 2))
        (a, b, c), (d, e, f) = geometry.lower, geometry.upper
        geometry = Box((a, c, -e), (d, f, -b))
    return replace(shape, geometry=geometry, pose=pose_of(shape.pose.transform().then(turn)))


def _turned(inertial: Inertial | None, chance: random.Random) -> Inertial | None:
    """Return the same inertia along other axes."""
    if inertial is None:
        return None
    turn = Transform(rotation_about(_axis(chance), chance.uniform(-3, 3)))
    i = inertial
    tensor = ((i.ixx, i.ixy, i.ixz), (i.ixy, i.iyy, i.iyz), (i.ixz, i.iyz, i.izz))
    rows = tuple(zip(*turn.rows, strict=True))  # R^T I R

    def entry(a: int, b: int) -> float:
        return math.fsum(rows[a][k] * tensor[k][m] * rows[b][m] for k in range(3) for m in range(3))

    pose = pose_of(inertial.pose.transform().then(turn))
    return Inertial(i.mass, pose, entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2))


def differences(a: Robot, b: Robot) -> list[Item]:
    return list(compare_robots(Side("a", YAML, a), Side("b", YAML, b)).items)


def is_the_same_written_otherwise(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311
    robot = robot_of(chance)
    other = rewritten(robot, chance)
    assert not differences(robot, other)
    assert not differences(other, robot)


@given(SEEDS)
@settings(max_examples=60, deadline=None)
def test_a_robot_that_is_written_otherwise_is_the_same(seed: int) -> None:
    is_the_same_written_otherwise(seed)


@pytest.mark.parametrize("seed", range(8))
def test_a_few_robots_that_are_written_otherwise_are_the_same(seed: int) -> None:
    is_the_same_written_otherwise(seed)


@given(SEEDS)
@settings(max_examples=60, deadline=None)
def test_a_prefix_is_seen_through(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311
    robot = robot_of(chance)
    named = replace(
        robot,
        links=tuple(replace(link, name=f"left/{link.name}") for link in robot.links),
        joints=tuple(
            replace(
                joint,
                name=f"left/{joint.name}",
                parent=f"left/{joint.parent}",
                child=f"left/{joint.child}",
                mimic=joint.mimic and replace(joint.mimic, joint=f"left/{joint.mimic.joint}"),
            )
            for joint in robot.joints
        ),
    )
    found = compare_robots(Side("a", YAML, robot), Side("b", YAML, named))
    assert found.same
    assert found.notes == ('the names of B begin with "left/"',)
    back = compare_robots(Side("b", YAML, named), Side("a", YAML, robot))
    assert back.same
    assert back.notes == ('the names of A begin with "left/"',)


Change = Callable[[Robot, random.Random], tuple[Robot, str, str, str] | None]


def _with_joint(robot: Robot, joint: Joint) -> Robot:
    return replace(robot, joints=tuple(joint if other.name == joint.name else other for other in robot.joints))


def _with_link(robot: Robot, link: Link) -> Robot:
    return replace(robot, links=tuple(link if other.name == link.name else other for other in robot.links))


def moved_frame(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    joints = [joint for joint in robot.joints if joint.is_fixed]
    if not joints:
        return None
    joint = chance.choice(joints)
    x, y, z = joint.origin.xyz
    changed = replace(joint, origin=Pose((x + 0.003, y, z), joint.origin.rpy))
    return _with_joint(robot, changed), FRAME, joint.child, "origin"


def turned_joint(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    joints = [joint for joint in robot.joints if joint.moves]
    if not joints:
        return None
    joint = chance.choice(joints)
    roll, pitch, yaw = joint.origin.rpy
    changed = replace(joint, origin=Pose(joint.origin.xyz, (roll, pitch, yaw + 0.02)))
    return _with_joint(robot, changed), JOINT, joint.name, "origin"


def tilted_axis(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    joints = [joint for joint in robot.joints if joint.moves]
    if not joints:
        return None
    joint = chance.choice(joints)
    x, y, z = joint.axis
    across = (0.0, -z, y) if abs(x) < 0.9 else (-y, x, 0.0)
    tilt = Transform(rotation_about(across, 0.05))
    return _with_joint(robot, replace(joint, axis=tilt.rotate(joint.axis))), JOINT, joint.name, "axis"


def flipped_axis(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    joints = [joint for joint in robot.joints if joint.moves]
    if not joints:
        return None
    joint = chance.choice(joints)
    x, y, z = joint.axis
    limit = joint.limit
    if limit is not None and limit.lower is not None and limit.upper is not None:
        limit = replace(limit, lower=-limit.upper, upper=-limit.lower)
    return _with_joint(robot, replace(joint, axis=(-x, -y, -z), limit=limit)), JOINT, joint.name, "coordinate"


def other_limit(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    joints = [joint for joint in robot.joints if joint.limit is not None and joint.limit.lower is not None]
    if not joints:
        return None
    joint = chance.choice(joints)
    quantity = chance.choice(["lower", "upper", "effort", "velocity"])
    value = getattr(joint.limit, quantity)
    changed = replace(joint, limit=replace(joint.limit or Limit(), **{quantity: value * 1.01}))
    return _with_joint(robot, changed), LIMIT, joint.name, f"limit {quantity}"


def other_mass(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    links = [link for link in robot.links if link.inertial is not None]
    if not links:
        return None
    link = chance.choice(links)
    old = link.inertial
    assert old is not None
    x, y, z = old.pose.xyz
    new, quantity = chance.choice(
        [
            (replace(old, mass=old.mass * 1.001), "mass"),
            (replace(old, pose=Pose((x, y, z + 0.0004), old.pose.rpy)), "centre of mass"),
            (replace(old, izz=old.izz * 1.01), "inertia"),
        ]
    )
    return _with_link(robot, replace(link, inertial=new)), MASS, link.name, quantity


def other_shape(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    links = [link for link in robot.links if link.collision]
    if not links:
        return None
    link = chance.choice(links)
    first = link.collision[0]
    geometry = first.geometry
    if isinstance(geometry, Box):
        a, b, c = geometry.upper
        changed = replace(first, geometry=Box(geometry.lower, (a + 0.001, b, c)))
    elif isinstance(geometry, Sphere):
        changed = replace(first, geometry=Sphere(geometry.radius + 0.001))
    else:
        assert isinstance(geometry, (Cylinder, Capsule))
        changed = replace(first, geometry=replace(geometry, length=geometry.length + 0.001))
    return _with_link(robot, replace(link, collision=(changed, *link.collision[1:]))), SHAPE, link.name, "collision"


def without_leaf(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    leaves = [joint for joint in robot.joints if joint.child not in robot.joints_from]
    leaves = [j for j in leaves if all(o.mimic is None or o.mimic.joint != j.name for o in robot.joints)]
    if not leaves:
        return None
    joint = chance.choice(leaves)
    links = tuple(link for link in robot.links if link.name != joint.child)
    joints = tuple(other for other in robot.joints if other is not joint)
    return replace(robot, links=links, joints=joints), NAME, joint.child, "existence"


def other_link_name(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    name = chance.choice(robot.links).name
    links = tuple(replace(link, name="other") if link.name == name else link for link in robot.links)
    joints = tuple(
        replace(
            joint,
            parent="other" if joint.parent == name else joint.parent,
            child="other" if joint.child == name else joint.child,
        )
        for joint in robot.joints
    )
    return replace(robot, links=links, joints=joints), NAME, name, "name"


def other_joint_name(robot: Robot, chance: random.Random) -> tuple[Robot, str, str, str] | None:
    name = chance.choice(robot.joints).name

    def new(old: str) -> str:
        return "other" if old == name else old

    joints = tuple(
        replace(joint, name=new(joint.name), mimic=joint.mimic and replace(joint.mimic, joint=new(joint.mimic.joint)))
        for joint in robot.joints
    )
    return replace(robot, joints=joints), NAME, name, "name"


CHANGES: list[Change] = [
    moved_frame,
    turned_joint,
    tilted_axis,
    flipped_axis,
    other_limit,
    other_mass,
    other_shape,
    without_leaf,
    other_link_name,
    other_joint_name,
]


def is_told_once(seed: int, change: Change) -> None:
    chance = random.Random(seed)  # noqa: S311
    robot = robot_of(chance)
    made = change(robot, chance)
    if made is None:
        return
    changed, kind, name, quantity = made
    found = differences(robot, changed)
    assert [(item.kind, item.name, item.quantity) for item in found] == [(kind, name, quantity)], found
    chance.shuffle(shuffled := list(changed.joints))
    again = differences(replace(changed, joints=tuple(shuffled)), robot)
    assert len(again) == 1, again


@given(SEEDS, st.sampled_from(CHANGES))
@settings(max_examples=150, deadline=None)
def test_one_change_is_told_once_by_name(seed: int, change: Change) -> None:
    is_told_once(seed, change)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_one_change_of_a_few_robots_is_told_once_by_name(change: Change) -> None:
    for seed in range(4):
        is_told_once(seed, change)

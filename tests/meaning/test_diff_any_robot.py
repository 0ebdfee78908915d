"""Diff on any robot: the same one written otherwise is the same, and one change is told once, by name."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import YAML, Item, Side
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Inertial,
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

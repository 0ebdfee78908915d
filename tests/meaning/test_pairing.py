"""Which names of two robots mean the same: prefixes, names that went to others, bodies that are cut otherwise."""

from __future__ import annotations

from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import YAML, Side
from rosorin_compile.model import Joint, Link, Pose, Robot


def robot(*rows: str) -> Robot:
    """Return a robot of joints, each as "name type parent child x"; the root hangs on none."""
    joints = []
    for row in rows:
        name, kind, parent, child, x = row.split()
        joints.append(Joint(name, kind, parent, child, Pose((float(x), 0.0, 0.0))))
    links = dict.fromkeys(link for joint in joints for link in (joint.parent, joint.child))
    return Robot("r", tuple(map(Link, links)), tuple(joints))


def star(*links: str) -> Robot:
    return robot(*(f"j{at} fixed {links[0]} {link} {at}" for at, link in enumerate(links[1:], 1)))


def told(a: Robot, b: Robot) -> list[tuple[str, object, object]]:
    found = compare_robots(Side("a", YAML, a), Side("b", YAML, b)).items
    return [(item.text, item.before, item.after) for item in found]


def test_joints_that_changed_names_with_each_other() -> None:
    a = robot("left continuous base one 1", "right continuous base two 2")
    b = robot("right continuous base one 1", "left continuous base two 2")
    assert told(a, b) == [
        ("joint left renamed to right", "left", "right"),
        ("joint right renamed to left", "right", "left"),
    ]


def test_a_joint_whose_name_a_new_one_has() -> None:
    a = robot("turn continuous base one 1")
    b = robot("swing continuous base one 1", "turn continuous base two 2")
    assert told(a, b) == [
        ("joint turn renamed to swing", "turn", "swing"),
        ("new: frame two (continuous on base, turn (of B))", None, "two"),
    ]


def test_what_is_gone_was_and_what_is_new_is() -> None:
    small, large = star("base", "one"), star("base", "one", "two")
    assert told(small, large) == [("new: frame two (fixed on base, j2)", None, "two")]
    assert told(large, small) == [("removed: frame two (fixed on base, j2)", "two", None)]

"""Alternatives of one thing are one value that chooses, wherever that can be said."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.importing.layout import Expression, Verbatim
from rosorin_compile.importing.translating.choices import covers, merged
from support.translations import translation_of as of

pytest.importorskip("xacro")

A, NOT_A, B, NOT_B = "a", "not a", "b", "not b"


def when(text: str) -> ast.expr | None:
    return ast.parse(text, mode="eval").body if text else None


def numbers(*texts: str) -> list[Any]:
    return [Verbatim(text) for text in texts]


@pytest.mark.parametrize(
    ("whens", "yes"),
    [
        ((A, NOT_A), True),
        ((A, NOT_B), False),
        (("a and b", "a and not b", NOT_A), True),
        (("a and b", "a and not b", "not a and b"), False),
        (("x == 'p'", "x != 'p'"), True),
        (("x == 'p'", "x == 'q'"), False),
        (("x == 'p'", "x == 'q'", "x not in ['p', 'q']"), True),
        (("x in ['p']", "x not in ['p']"), True),
        ((A, ""), True),
        (tuple("abcdefghijk"), False),
    ],
)
def test_whether_one_of_some_conditions_always_holds(whens: tuple[str, ...], yes: bool) -> None:
    assert covers([when(one) for one in whens], [None]) is yes


TURNED = [
    (numbers("180 deg", "0", "0"), "not a and b"),
    (numbers("0", "180 deg", "0"), "a and not b"),
    (numbers("180 deg", "180 deg", "0"), "not a and not b"),
]


@pytest.mark.parametrize(
    ("key", "found", "made"),
    [
        ("mass", [(Verbatim("1"), A), (Verbatim("2"), NOT_A)], "${1 if a else 2}"),
        ("mass", [(Verbatim("1"), A), (Verbatim("1"), NOT_A)], "1"),
        ("mass", [(Verbatim("1"), A), (Verbatim("2"), B)], "${1 if a else 2 if b else none}"),
        ("mass", [(Verbatim("2"), ""), (Verbatim("1"), A)], "${1 if a else 2}"),
        ("mass", [(Verbatim("2"), ""), (Verbatim("1"), "")], None),
        ("type", [("fixed", "t == 1"), ("free", "t == 2")], "${'fixed' if t == 1 else 'free' if t == 2 else none}"),
        ("rpy", TURNED, ["${0 if a else 180 deg}", "${0 if b else 180 deg}", "0"]),
        ("xyz", [(numbers("1", "0", "0"), A), (numbers("2", "0", "0"), NOT_A)], ["${1 if a else 2}", "0", "0"]),
        ("xyz", [(numbers("1", "0", "1"), A), (numbers("2", "0", "2"), NOT_A)], "${[1, 0, 1] if a else [2, 0, 2]}"),
        ("file", [("m://x/a.dae", A), ("m://x/b.dae", NOT_A)], "m://x/${'a' if a else 'b'}.dae"),
        ("file", [("m://x/a.dae", A), ("m://y/b.stl", NOT_A)], "${'m://x/a.dae' if a else 'm://y/b.stl'}"),
        ("file", [(Expression("m://${x}.dae"), A), ("b", NOT_A)], "${'m://' + str(x) + '.dae' if a else 'b'}"),
        ("limit", [({"lower": "1", "e": "3"}, A), ({"lower": "2", "e": "3"}, NOT_A)],
         {"lower": "${'1' if a else '2'}", "e": "3"}),
        ("limit", [({"e": "3"}, "a and b"), ({"e": "3"}, "a and not b")],
         {"if": "${a and b or (a and (not b))}", "e": "3"}),
        ("sphere", [({"r": ["1"]}, A), ({"r": ["1"], "s": {"x": "1"}}, NOT_A)],
         {"r": ["1"], "s": {"if": "${not a}", "x": "1"}}),
        ("visual", [([{"x": "1"}], A), ([{"x": "2"}, {"y": "1"}], NOT_A)],
         [{"if": "${a}", "x": "1"}, {"if": "${not a}", "x": "2"}, {"if": "${not a}", "y": "1"}]),
    ],
)  # fmt: skip
def test_alternatives_are_one_value(key: str, found: list[tuple[Any, str]], made: Any) -> None:
    assert merged(key, [(value, when(one)) for value, one in found]) == made


ON = '<xacro:arg name="t" default="a"/><link name="base"/><link name="arm"/>'
JOINT = (
    """<xacro:if value="${{'$(arg t)' == '{}'}}"><joint name="j" type="{}"><origin xyz="{} 0 0"/>"""
    '<parent link="base"/><child link="arm"/></joint></xacro:if>'
)


def test_a_joint_that_is_there_several_times_is_said_once(tmp_path: Path) -> None:
    made = of(tmp_path, ON + JOINT.format("a", "fixed", "1") + JOINT.format("b", "fixed", "2"))
    assert "''" not in made.files["robot.yaml"]
    assert (
        "type: fixed, parent: base, child: arm, xyz: [\"${1 if t == 'a' else 2}\", 0, 0]}" in made.files["robot.yaml"]
    )


def test_a_shape_and_a_pose_are_chosen(tmp_path: Path) -> None:
    both = '<origin xyz="0 0 {}"/><geometry><mesh filename="package://p/{}.stl"/></geometry>'
    one, other = both.format(1, "big"), both.format(2, "small")
    body = f'<xacro:if value="$(arg b)">{one}</xacro:if><xacro:unless value="$(arg b)">{other}</xacro:unless>'
    made = of(tmp_path, f'<xacro:arg name="b" default="true"/><link name="base"><visual>{body}</visual></link>')
    robot = made.files["robot.yaml"]
    assert """mesh: {file: "package://p/${'big' if b else 'small'}.stl"}""" in robot
    assert 'xyz: [0, 0, "${1 if b else 2}"]' in robot


ANEW = (
    '<xacro:arg name="sim" default="false"/><link name="base"/>'
    '<xacro:macro name="imu" params="p sim xyz:=\'1 2 3\' height:=2"><link name="${p}imu"/>'
    '<xacro:if value="${sim}"><xacro:property name="xyz" value="3 2 1"/></xacro:if>'
    '<joint name="${p}i" type="fixed"><parent link="base"/><child link="${p}imu"/><origin xyz="${xyz}"/></joint>'
    '<link name="${p}${height}"/><xacro:property name="height" value="5"/><link name="${p}mast_${height}"/>'
    '<joint name="${p}a" type="fixed"><parent link="base"/><child link="${p}2"/></joint>'
    '<joint name="${p}b" type="fixed"><parent link="base"/><child link="${p}mast_5"/></joint></xacro:macro>'
)


def test_a_parameter_that_is_set_anew_is_another_value_from_there_on(tmp_path: Path) -> None:
    made = of(tmp_path, f'{ANEW}<xacro:imu p="l_" sim="$(arg sim)"/><xacro:imu p="r_" sim="true" xyz="4 5 6"/>')
    assert (made.kept, made.arguments, made.written_out) == (("imu",), ("sim",), ())
    assert len(made.proven) == 2
    robot = made.files["robot.yaml"]
    assert '    let: {xyz_2: "${[3, 2, 1] if sim else xyz}", height_2: 5}\n' in robot
    assert 'child: imu, xyz: "${xyz_2}"}\n' in robot
    assert "      ${height}: {}\n      mast_${height_2}: {}\n" in robot

"""Alternatives of one thing are one value that chooses, wherever that can be said."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.translations import translation_of as of

pytest.importorskip("xacro")

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

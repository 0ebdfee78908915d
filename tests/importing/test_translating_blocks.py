"""Blocks that calls hand over become parameters: of named values and of parts."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import compile_robot
from support.translations import translation_of as of

pytest.importorskip("xacro")

INERTIAL = (
    '<xacro:macro name="inertial_box" params="mass x y z *origin"><inertial><xacro:insert_block name="origin"/>'
    '<mass value="${mass}"/><inertia ixx="${(1/12)*mass*(y*y+z*z)}" ixy="0.0" ixz="0.0" '
    'iyy="${(1/12)*mass*(x*x+z*z)}" iyz="0.0" izz="${(1/12)*mass*(x*x+y*y)}"/></inertial></xacro:macro>'
)
ARM = '<link name="arm">{}</link><joint name="j" type="fixed"><parent link="base"/><child link="arm"/></joint>'
SOLID = (
    '<xacro:macro name="solid" params="*origin *geometry"><visual><xacro:insert_block name="origin"/><geometry>'
    '<xacro:insert_block name="geometry"/></geometry></visual><collision><xacro:insert_block name="origin"/><geometry>'
    '<xacro:insert_block name="geometry"/></geometry></collision></xacro:macro>'
)
LENS = (
    '<link name="base"/><xacro:macro name="lens" params="prefix *origin"><link name="${prefix}_lens"><visual>'
    '<xacro:insert_block name="origin"/><geometry><sphere radius="1"/></geometry></visual></link>'
    '<joint name="${prefix}_joint" type="fixed"><xacro:insert_block name="origin"/><parent link="base"/>'
    '<child link="${prefix}_lens"/></joint></xacro:macro>'
)


def box(mass: str, origin: str) -> str:
    return f'<xacro:inertial_box mass="{mass}" x="0.3" y="0.2" z="0.1">{origin}</xacro:inertial_box>'


def test_an_origin_is_handed_to_a_named_value(tmp_path: Path) -> None:
    base = f'<xacro:property name="h" value="0.4"/><link name="base">{box("1", _origin("0 0 ${h/2}"))}</link>'
    robot = of(tmp_path, INERTIAL + base + ARM.format(box("2", "<origin/>"))).files["robot.yaml"]
    head = "  inertial_box(mass, x, y, z, xyz, rpy):\n    mass: ${mass}\n    xyz: ${xyz}\n    rpy: ${rpy}\n"
    assert head in robot
    assert "    inertial: ${inertial_box(1, 0.3, 0.2, 0.1, [0, 0, h / 2], [0, 0, 0])}\n" in robot
    assert "    inertial: ${inertial_box(2, 0.3, 0.2, 0.1, [0, 0, 0], [0, 0, 0])}\n" in robot


@pytest.mark.parametrize("said", ['xyz="0 0 0" rpy="0 0 0"', 'xyz="0 0 1"', 'rpy="0 0 1"', ""])
def test_an_origin_keeps_xyz_and_rpy_whatever_calls_say_of_it(tmp_path: Path, said: str) -> None:
    made = of(tmp_path, f'{INERTIAL}{LENS}<xacro:lens prefix="a"><origin {said}/></xacro:lens>')
    more = of(tmp_path, INERTIAL + f'<link name="base">{box("1", f"<origin {said}/>")}</link>')
    assert (made.kept, more.kept) == (("lens",), ("inertial_box",))
    robot = made.files["robot.yaml"]
    assert "      xyz: {type: list, default: [0, 0, 0]}\n      rpy: {type: list, default: [0, 0, 0]}\n" in robot
    assert 'xyz: "${xyz}", rpy: "${rpy}"' in robot
    assert "  inertial_box(mass, x, y, z, xyz, rpy):\n" in more.files["robot.yaml"]


def test_a_turned_origin_has_its_angles_in_degrees(tmp_path: Path) -> None:
    base = f'<link name="base">{box("1", _origin("1 0 0", "0 ${pi/2} 0"))}</link>'
    robot = of(tmp_path, INERTIAL + base).files["robot.yaml"]
    assert "${inertial_box(1, 0.3, 0.2, 0.1, [1, 0, 0], [0, 90 deg, 0])}" in robot


def test_a_geometry_and_an_origin_in_several_elements(tmp_path: Path) -> None:
    one = f'<xacro:solid>{_origin("1 0 0")}<box size="1 2 3"/></xacro:solid>'
    other = f'<xacro:solid>{_origin("2 0 0")}<box size="3 2 1"/></xacro:solid>'
    made = of(tmp_path, f'{SOLID}<link name="base">{one}</link>{ARM.format(other)}')
    assert made.kept == ("solid",)
    robot = made.files["robot.yaml"]
    visual = '    visual:\n      - {box: {size: "${size}"}, xyz: "${xyz}", rpy: "${rpy}"}\n'
    assert f"  solid(xyz, rpy, size):\n{visual}" in robot
    assert "  base: ${solid([1, 0, 0], [0, 0, 0], [1, 2, 3])}\n" in robot


def test_a_list_that_a_call_gives_is_taken_whole(tmp_path: Path) -> None:
    one = f'<xacro:solid>{_origin("1 0 0")}<box size="1 2 3"/></xacro:solid>'
    made = of(tmp_path, f'{SOLID}{INERTIAL}<link name="base">{one}{box("9", _origin("1 0 0"))}</link>')
    assert "    visual: ${solid([1, 0, 0], [0, 0, 0], [1, 2, 3]).visual}\n" in made.files["robot.yaml"]


def test_shapes_of_several_kinds_are_no_parameter_of_a_named_value(tmp_path: Path) -> None:
    one = f'<xacro:solid>{_origin("1 0 0")}<box size="1 2 3"/></xacro:solid>'
    other = f'<xacro:solid>{_origin("1 0 0")}<sphere radius="1"/></xacro:solid>'
    made = of(tmp_path, f'{SOLID}<link name="base">{one}</link>{ARM.format(other)}')
    (lost,) = made.written_out
    assert (lost.name, lost.reason) == ("solid", 'what is handed over as "geometry" has no word as a value')


def test_an_origin_of_a_part_is_its_parameters(tmp_path: Path) -> None:
    calls = f'<xacro:lens prefix="a">{_origin("1 0 0")}</xacro:lens>'
    calls += '<xacro:lens prefix="b"><origin rpy="0 0 1"/></xacro:lens>'
    robot = of(tmp_path, LENS + calls).files["robot.yaml"]
    assert "      xyz: {type: list, default: [0, 0, 0]}\n      rpy: {type: list, default: [0, 0, 0]}\n" in robot
    assert "  a: {part: lens, with: {xyz: [1, 0, 0]}}\n  b: {part: lens, with: {rpy: [0, 0, 1]}}\n" in robot


def test_a_word_that_is_taken_has_the_name_of_its_block_before_it(tmp_path: Path) -> None:
    calls = (
        f'<xacro:property name="xyz" value="3"/><xacro:lens prefix="a">{_origin("${xyz} 0 0", "0 0 1")}</xacro:lens>'
    )
    robot = of(tmp_path, LENS + calls).files["robot.yaml"]
    assert 'with: {origin_xyz: ["${xyz}", 0, 0], origin_rpy: [0, 0, 1]}' in robot


def test_a_block_is_handed_on(tmp_path: Path) -> None:
    lens = LENS.replace("</visual>", "</visual>" + box("1", '<xacro:insert_block name="origin"/>'))
    made = of(tmp_path, f'{INERTIAL}{lens}<xacro:lens prefix="a">{_origin("0.1 0 0")}</xacro:lens>')
    assert made.kept == ("inertial_box", "lens")
    assert "${inertial_box(1, 0.3, 0.2, 0.1, xyz, rpy)}" in made.files["robot.yaml"]


def test_the_content_of_an_element_is_handed_over(tmp_path: Path) -> None:
    macro = '<xacro:macro name="heavy" params="**more"><inertial><xacro:insert_block name="more"/><inertia ixx="1" '
    macro += 'ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></xacro:macro>'
    call = f'<xacro:heavy><more><mass value="7"/>{_origin("0 0 1")}</more></xacro:heavy>'
    made = of(tmp_path, f'{macro}<link name="base">{call}</link>')
    assert made.kept == ("heavy",)
    assert "    inertial: ${heavy(7, [0, 0, 1])}\n" in made.files["robot.yaml"]


def _origin(xyz: str, rpy: str = "") -> str:
    return f'<origin xyz="{xyz}" rpy="{rpy}"/>' if rpy else f'<origin xyz="{xyz}"/>'


def test_an_inertial_that_a_part_is_handed_is_a_table_of_its_own(tmp_path: Path) -> None:
    macro = '<link name="base"/><xacro:macro name="lid" params="prefix *inertial"><link name="${prefix}_lid">'
    macro += '<xacro:insert_block name="inertial"/></link><joint name="${prefix}_joint" type="fixed">'
    macro += '<parent link="base"/><child link="${prefix}_lid"/></joint></xacro:macro>'
    moments = '<inertia ixx="1" ixy="0.1" ixz="0.1" iyy="1" iyz="0.1" izz="1"/>'
    call = f'<xacro:lid prefix="a"><inertial><mass value="7"/>{_origin("0 0 1")}{moments}</inertial></xacro:lid>'
    robot = of(tmp_path, macro + call).files["robot.yaml"]
    assert "inertial: {type: table}" in robot
    assert 'lid: {inertial: "${inertial}"}' in robot
    assert "inertial: {mass: 7, xyz: [0, 0, 1], inertia: {" in robot


def test_what_a_named_value_has_on_a_condition_may_be_missing(tmp_path: Path) -> None:
    heavy = '<inertial><mass value="${m}"/><inertia ixx="9" ixy="0" ixz="0" iyy="9" iyz="0" izz="9"/></inertial>'
    macro = (
        '<xacro:arg name="heavy" default="true"/><xacro:macro name="weight" params="m"><xacro:if value="$(arg heavy)">'
    )
    macro += f'{heavy}</xacro:if></xacro:macro><xacro:macro name="shape" params="box r"><xacro:if value="${{box}}">'
    macro += '<box size="${r} 1 1"/></xacro:if><xacro:unless value="${box}"><sphere radius="${r}"/></xacro:unless>'
    visual = '<visual><geometry><xacro:shape box="{}" r="1"/></geometry></visual>'
    calls = f'<link name="base"><xacro:weight m="7"/>{visual.format("true")}</link>' + ARM.format(
        visual.format("false")
    )
    made = of(tmp_path, f"{macro}</xacro:macro>{calls}")
    assert made.kept == ("weight", "shape")
    robot = made.files["robot.yaml"]
    assert "    inertial: ${get(weight(7), 'inertial')}\n" in robot
    assert 'visual: ["${shape(true, 1)}"]\n' in robot


def test_a_visual_that_a_part_is_handed_is_a_list(tmp_path: Path) -> None:
    macro = '<link name="base"/><xacro:macro name="lid" params="prefix *look"><link name="${prefix}_lid">'
    macro += '<xacro:insert_block name="look"/></link><joint name="${prefix}_joint" type="fixed">'
    macro += '<parent link="base"/><child link="${prefix}_lid"/></joint></xacro:macro>'
    call = '<xacro:lid prefix="{}"><visual><geometry><{}/></geometry></visual></xacro:lid>'
    calls = call.format("a", 'box size="1 1 1"') + call.format("b", 'sphere radius="1"')
    robot = of(tmp_path, macro + calls).files["robot.yaml"]
    assert "visual: {type: list}" in robot
    assert 'lid: {visual: "${visual}"}' in robot
    assert "      visual:\n        - {sphere: {radius: 1}}\n" in robot


def test_a_use_that_says_what_its_part_does_not_read_is_refused(tmp_path: Path) -> None:
    made = of(tmp_path, LENS + f'<xacro:lens prefix="a">{_origin("1 0 0")}</xacro:lens>')
    text = made.files["robot.yaml"].replace("xyz: [1, 0, 0]}", "xyz: [1, 0, 0], yaw: 1}")
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    found = compile_robot(tmp_path / "robot.yaml").diagnostics
    assert any('"yaw"' in one.message for one in found), found

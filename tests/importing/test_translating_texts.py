"""Numbers that a xacro puts together from texts, and texts that it makes of true and false."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.imported import Outputs, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.importing.xacro.translate import Translation, translate
from rosorin_compile.importing.xacro.write_yaml import Target

pytest.importorskip("xacro")

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def of(here: Path, body: str, **arguments: str) -> Translation:
    path = here / "robot.xacro"
    path.write_text(f"{HEAD}{body}</robot>", "utf-8")
    how = ReadOptions(arguments=arguments, trust=True)
    imported = read_robot(path, how)
    assert imported.tree is not None, imported.diagnostics
    return translate(path, how, imported, Outputs({"urdf": {"file": "r.urdf"}}, {}, {}), Target(Path("d/robot")))


def kept(here: Path, body: str, **arguments: str) -> str:
    """Return the description of a xacro of which nothing is written out."""
    made = of(here, body, **arguments)
    assert (made.reason, made.written_out) == ("", ())
    return made.files["robot.yaml"]


def joint(origin: str) -> str:
    return (
        '<link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/>'
        f"<origin {origin}/></joint>"
    )


W = '<xacro:property name="w" value="0.2"/>'
ARM = (
    '<xacro:macro name="arm" params="p x h:=0"><link name="${p}a"/><link name="${p}b"/>'
    '<joint name="${p}j" type="fixed"><parent link="${p}a"/><child link="${p}b"/>'
    '<origin xyz="-${x} ${h} 0"/></joint></xacro:macro>'
)
MASS = '<xacro:macro name="m" params="g"><inertial><mass value="${g}e-3"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" '
MASS += 'iyz="0" izz="1"/></inertial></xacro:macro>'

NUMBERS = {
    "expression": (W + joint('xyz="0 -${w/2} 0"'), 'xyz: [0, "${-(w / 2)}", 0]'),
    "name": (W + joint('xyz="-${w} 0 0"'), 'xyz: ["${-w}", 0, 0]'),
    "plus": (W + joint('xyz="+${w} 0 0"'), 'xyz: ["${w}", 0, 0]'),
    "angle": (joint('rpy="-${pi/2} 0 0"'), "rpy: [-90 deg, 0, 0]"),
    "angle function": (joint('rpy="-${radians(45)} 0 0"'), "rpy: [-45 deg, 0, 0]"),
    "property": (W + '<xacro:property name="z" value="-${w/2}"/>' + joint('xyz="0 0 ${z}"'), "  z: ${-(w / 2)}\n"),
    "property name": (W + '<xacro:property name="z" value="-${w}"/>' + joint('xyz="0 0 ${z/2}"'), "  z: ${-w}\n"),
    "several": (
        W + '<xacro:property name="o" value="0 -${w} 1"/>' + joint('xyz="${o}"'),
        '  o: [0, "${-w}", 1]\n',
    ),
    "parameter": (ARM + '<xacro:arm p="l_" x="0.5"/>', '"${-x}"'),
    "given": (W + ARM + '<xacro:arm p="l_" x="0.5" h="-${w}"/>', 'with: {x: 0.5, h: "${-w}"}'),
    "default": (
        W + ARM.replace("h:=0", "h:=-${w}") + '<xacro:arm p="l_" x="0.5"/>',
        'h: {type: length, default: "${-w}"}',
    ),
    "argument": ('<xacro:arg name="x" default="0.1"/>' + joint('xyz="-$(arg x) 0 0"'), 'xyz: ["${-x}", 0, 0]'),
    "thousandth": (MASS + '<link name="a"><xacro:m g="20"/></link>', 'mass: "${g * 0.001}"'),
    "digits": ('<xacro:property name="n" value="5"/>' + joint('xyz="0.${n} 0 0"'), "${float('0.' + str(n))}"),
}


@pytest.mark.parametrize("case", NUMBERS)
def test_a_number_that_is_put_together_is_a_number(tmp_path: Path, case: str) -> None:
    body, line = NUMBERS[case]
    assert line in kept(tmp_path, body)


def test_a_text_with_a_dash_stays_a_text(tmp_path: Path) -> None:
    body = '<xacro:arg name="tag" default="x"/><xacro:property name="side" value="-$(arg tag)"/><link name="a${side}"/>'
    assert '  side: "-${tag}"\n' in kept(tmp_path, body)


def plugin(text: str) -> str:
    return f'<gazebo><plugin name="q" filename="q.so"><on>{text}</on></plugin></gazebo>'


def switch(params: str) -> str:
    return f'<xacro:macro name="m" params="{params}"><link name="a"/>{plugin("${s}")}</xacro:macro>'


ARG = '<xacro:arg name="s" default="false"/>'
LINK = '<link name="a"/>'
WHEEL = '<xacro:if value="${s}"><link name="b"/><joint name="j" type="fixed"><parent link="a"/><child link="b"/>'
WHEEL += "</joint></xacro:if>"
WORD = "<on>${'True' if s else 'False'}</on>"
FLAGS = {
    "parameter": (switch("s:=false") + "<xacro:m/>", WORD),
    "argument given": (ARG + switch("s:=false") + '<xacro:m s="$(arg s)"/>', WORD),
    "no default": (ARG + switch("s") + '<xacro:m s="$(arg s)"/>', WORD),
    "true given": (switch("s") + '<xacro:m s="true"/>', WORD),
    "property": ('<xacro:property name="s" value="true"/>' + LINK + plugin("${s}"), WORD),
    "argument": (ARG + LINK + plugin("$(arg s)"), "<on>${s}</on>"),
    "property of an argument": (ARG + '<xacro:property name="s" value="$(arg s)"/>' + LINK + plugin("${s}"), WORD),
    "comparison": (
        '<xacro:property name="n" value="2"/>' + LINK + plugin("${n > 1}"),
        "<on>${'True' if n > 1 else 'False'}</on>",
    ),
    "opposite": (ARG + switch("s:=false").replace("${s}", "${not s}") + "<xacro:m/>", "<on>${'True' if not s else "),
    "constant": (LINK + plugin("${True}"), "<on>True</on>"),
    "text": (
        switch("s:=false").replace("${s}", "x_${str(s)}") + "<xacro:m/>",
        "<on>x_${'True' if s else 'False'}</on>",
    ),
    "number": (switch("s:=2").replace("${s}", "${s} ${s/2}") + "<xacro:m/>", "<on>${s} ${s / 2}</on>"),
    "condition, too": (ARG + switch("s:=false").replace(LINK, LINK + WHEEL) + '<xacro:m s="$(arg s)"/>', WORD),
}


@pytest.mark.parametrize("case", FLAGS)
def test_true_and_false_are_printed_as_xacro_prints_them(tmp_path: Path, case: str) -> None:
    body, line = FLAGS[case]
    assert line in kept(tmp_path, body)


@pytest.mark.parametrize("value", ["true", "false"])
def test_an_argument_that_is_declared_nowhere_is_what_is_given(tmp_path: Path, value: str) -> None:
    robot = kept(tmp_path, LINK + WHEEL.replace("${s}", "$(arg s)"), s=value)
    assert f"  s: {{type: boolean, default: {value}}}\n" in robot
    assert "    if: ${s}\n" in robot
    assert 'if: "${s}"' in robot


def test_what_is_given_and_nothing_takes_is_no_argument(tmp_path: Path) -> None:
    assert "args:" not in kept(tmp_path, LINK, s="true")
    assert "  side: {type: text, default: a_}\n" in kept(tmp_path, '<link name="$(arg side)b"/>', side="a_")


def test_the_default_of_the_source_is_proven_beside_what_is_given(tmp_path: Path) -> None:
    """What is given is the default here, and what the source says for it still one of the combinations."""
    ways = '<xacro:arg name="way" default="real"/><xacro:if value="${\'$(arg way)\' == \'mock\'}">'
    ways += f"{plugin('m')}</xacro:if>"
    body = '<xacro:arg name="p" default=""/><link name="$(arg p)a"/>' + ways
    made = of(tmp_path, body, p="x_", way="mock")
    assert "  p: {type: text, default: x_}\n" in made.files["robot.yaml"]
    assert "  way: {type: text, default: mock, one_of: [mock, real]}\n" in made.files["robot.yaml"]
    rows = [(*row,) for row in made.proven]
    assert len(rows) == made.possible == 6
    assert (("p", ""), ("way", "real")) in rows
    assert (("p", "probe_"),) in rows


def test_a_flag_is_given_once_in_each_sense(tmp_path: Path) -> None:
    body = '<xacro:arg name="s" default="True"/>' + LINK + WHEEL.replace("${s}", "$(arg s)")
    assert of(tmp_path, body, s="true").possible == 2
    assert of(tmp_path, body, s="false").possible == 2
    assert of(tmp_path, body).possible == 2


@pytest.mark.parametrize("value", ["${w * 2}", "${-w}", "${0.1 + w}", "${(w + 1) / 2}", "${2 * w**2}"])
def test_what_is_reckoned_and_only_printed_is_a_number(tmp_path: Path, value: str) -> None:
    robot = kept(tmp_path, W + switch("s") + f'<xacro:m s="{value}"/>')
    assert "{type: number}" in robot
    assert "<on>${s}</on>" in robot


@pytest.mark.parametrize("value", ["${w + w}", "${w + 'b'}", "${'%s' % w}"])
def test_what_may_be_a_text_is_none(tmp_path: Path, value: str) -> None:
    made = of(tmp_path, '<xacro:property name="w" value="a"/>' + switch("s") + f'<xacro:m s="{value}"/>')
    assert "type: number" not in "".join(made.files.values())

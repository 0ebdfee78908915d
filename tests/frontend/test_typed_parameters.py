"""A bare number for a typed parameter is in SI units: the robot is that of the number with its unit, or the same error.

Held for parameters of parts, of sensor types and arguments of a description, given or by default, as a literal, an
expression, a named value, on the command line and from Python.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.source.diagnostics import Diagnostic

UNITS = {
    "length": ["m", "mm", "inch"],
    "mass": ["kg", "g", "lb"],
    "time": ["s", "ms", "min"],
    "angle": ["rad", "deg"],
    "force": ["N", "kgf"],
    "torque": ["N*m", "Nm"],
    "inertia": ["kg*m^2", "g*mm^2"],
    "speed": ["m/s", "km/h"],
    "angular_speed": ["rad/s", "rpm", "deg/s"],
    "frequency": ["Hz", "kHz"],
    "density": ["kg/m^3", "g/cm^3"],
}
# What a part may do with a value: right for one dimension, wrong for others, or right for any.
USES = {
    "length": "xyz: [0, 0, '${value}']",
    "angle": "rpy: [0, 0, '${value}']",
    "volume": "xyz: [0, 0, '${value**3 / (1 m**2)}']",
    "density": "xyz: [0, 0, '${value * (2 m)**4 / (1 kg)}']",
    "ratio": "xyz: [0, 0, '${1 m * (value / (2 * value))}']",
    "compared": "xyz: [0, 0, '${1 m if value > 3 mm else 2 m}']",
    "added": "xyz: [0, 0, '${value + 1}']",
    "chosen": "xyz: [0, 0, '${max(value, 2 mm)}']",
    "listed": "xyz: '${[0, 0, value]}'",
    "text": "source: {note: 'as ${value}'}",
}
# Beyond half a turn a bare angle looks like degrees, which is told.
NUMBERS = st.floats(-3, 3).map(lambda one: round(one, 6)).filter(bool)


WAYS = ("given", "computed", "named", "default", "passed on", "argument", "command line", "Python")


def described(kind: str, written: str, way: str, use: str) -> tuple[str, dict[str, Any]]:
    """Return a description in which a value reaches the use of it by some way, and the arguments that it is given."""
    typed, rest, given = f"{{type: {kind}}}", "", written
    arguments: dict[str, Any] = {}
    if way == "computed":
        given = f"${{({written}) * 1}}"
    elif way == "named":
        rest, given = f"let: {{v: {written}}}\n", "${v}"
    elif way == "default":
        typed = f"{{type: {kind}, default: {written}}}"
    elif way == "passed on":
        rest, given = f"let: {{v: '${{{written}}}'}}\n", "${v}"
    elif way == "argument":
        rest, given = f"args: {{v: {{type: {kind}, default: {written}}}}}\n", "${v}"
    elif way in ("command line", "Python"):
        rest, given = f"args: {{v: {{type: {kind}}}}}\n", "${v}"
        bare = re.fullmatch(r"[-\d.e]+", written)
        arguments = {"v": float(written) if way == "Python" and bare else written}
    inside = (
        "" if way == "default" else f", with: {{value: '{given}'}}" if "$" in given else f", with: {{value: {given}}}"
    )
    if way in ("argument", "command line", "Python"):
        typed = "{}"  # of any type: it is the argument that has one
    text = (
        f"robot: r\n{rest}links: {{base_link: {{}}}}\n"
        f"parts:\n  p:\n    params: {{value: {typed}}}\n    links: {{tip: {{}}}}\n"
        f"    joints: {{tip: {{type: fixed, parent: mount, child: tip, {use}}}}}\n"
        f"use: {{one: {{part: p, parent: base_link{inside}}}}}\noutputs: {{urdf: {{file: r.urdf}}}}\n"
    )
    return text, arguments


def outcome(folder: Path, text: str, arguments: dict[str, Any]) -> tuple[CompileResult, list[tuple[str, str, str]]]:
    """Return what a description comes to, and what is said of it but for the numbers as they were written."""
    path = folder / "robot.yaml"
    path.write_text(text)
    compiled = compile_robot(path, arguments)
    return compiled, [(one.rule, one.severity, _plain(one)) for one in compiled.diagnostics]


def _plain(one: Diagnostic) -> str:
    return re.sub(r"(but|is|not) \S+( \S+)? is", r"\1 it is", one.message)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("typed")


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_a_bare_number_is_that_number_with_its_unit_of_si(folder: Path, data: st.DataObject) -> None:
    kind = data.draw(st.sampled_from(sorted(UNITS)))
    number, way, use = data.draw(NUMBERS), data.draw(st.sampled_from(WAYS)), data.draw(st.sampled_from(sorted(USES)))
    number = data.draw(st.sampled_from([number, int(number) or 1]))
    bare, said_of_bare = outcome(folder, *described(kind, str(number), way, USES[use]))
    whole, said_of_whole = outcome(folder, *described(kind, f"{number} {UNITS[kind][0]}", way, USES[use]))
    assert [one for one in said_of_bare if one[1] == "error"] == [one for one in said_of_whole if one[1] == "error"]
    assert [one.text for one in bare.artifacts] == [one.text for one in whole.artifacts]


def test_a_whole_number_of_any_length_is_no_traceback(folder: Path) -> None:
    text, _ = described("length", "1", "Python", USES["length"])
    _, said = outcome(folder, text, {"v": 10**400})
    assert "error" in {severity for _, severity, _ in said}


@pytest.mark.parametrize(("lead", "follower", "text", "factor"), [
    ("revolute", "prismatic", "5 mm/rad", "0.005"),
    ("revolute", "prismatic", "'${18 mm / 180 deg}'", "0.00572957795131"),
    ("prismatic", "revolute", "180 rad/m", "180"),
    ("revolute", "revolute", "2", "2"),
])  # fmt: skip
def test_a_mimic_multiplier_may_be_a_length_per_angle(
    folder: Path, lead: str, follower: str, text: str, factor: str
) -> None:
    joint = (
        "{{type: {}, parent: {}, child: {}, axis: [0, 0, 1], {}limit: {{lower: -1, upper: 1, effort: 1, velocity: 1}}}}"
    )
    mimic = f"mimic: {{joint: j, multiplier: {text}}}, "
    joints = f"{{j: {joint.format(lead, 'b', 'c', '')}, k: {joint.format(follower, 'c', 'd', mimic)}}}"
    robot = folder / "robot.yaml"
    robot.write_text(
        f"robot: r\nlinks: {{b: {{}}, c: {{}}, d: {{}}}}\njoints: {joints}\noutputs: {{urdf: {{file: r.urdf}}}}\n"
    )
    made = compile_robot(robot)
    assert [one.rule for one in made.diagnostics if one.severity == "error"] == []
    assert f'multiplier="{factor}"' in made.artifacts[0].text

"""An artifact of the user's own: a template beside the description and one line of YAML."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats import templating as template
from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.formats.templating import TemplateProblem, Templates
from rosorin_compile.model import Box, Joint, Limit, Link, Output, Pose, Robot, Shape
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from support.robots import compiled, copy_of_rosorin, texts

TESTER = Robot(
    "a<b",
    (Link("base"), Link("arm", collision=(Shape(Box((0, 0, 0), (1, 2, 3))),)), Link("tip")),
    (
        Joint("shoulder", "revolute", "base", "arm", Pose((0.1, 0, 1 / 3)), (0, 0, 1), Limit(-1, 1, 1, 1)),
        Joint("tip_joint", "fixed", "arm", "tip", Pose((1, 0, 0)), source=Source("measured", "a ruler", "2026-01-02")),
    ),
    poses=(JointPose("left", {"shoulder": math.pi / 2}),),
)


def render(folder: Path, text: str, name: str = "own.txt.jinja", options: Mapping[str, Any] | None = None) -> str:
    (folder / name).write_text(text, "utf-8")
    output = Output("own", "template", "own.txt", {"template": name, **(options or {})})
    made, diagnostics = template.write(TESTER, output, Templates(folder))
    assert diagnostics == []
    return made


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{{ robot.name }} {{ robot.joints | map(attribute='name') | join(' ') }}", "a<b shoulder tip_joint"),
        ("{{ number(robot.joint['shoulder'].origin.xyz[2]) }}", "0.333333333333"),
        ("{{ six(1 / 3) }} {{ fixed(7.5e-05, 4) }} {{ number(-0.0) }}", "0.333333 0.0001 0"),
        ("{{ vector(robot.joint.shoulder.origin.xyz, six) }}", "0.1 0 0.333333"),
        ("{{ exact(robot.joint['shoulder'].origin.xyz[2]) }}", "0.3333333333333333"),
        ("{{ vector(robot.joint.shoulder.origin.xyz, exact) }}", "0.1 0 0.3333333333333333"),
        ("{{ vector(robot.joint.shoulder.origin.xyz) }}", "0.1 0 0.333333333333"),
        ("{{ kind(robot.link.arm.collision[0].geometry) }}", "Box"),
        ("{{ source(robot.joint.tip_joint.source) }}", "measured, 2026-01-02: a ruler"),
        ("{{ number(degrees(radians(90))) }}", "90"),
        ("{{ output.file }} {{ output.options.options.colour }}", "own.txt blue"),
        ("{{ robot.name | tojson }}", '"a\\u003cb"'),
        ("{{ vector(robot.transform('base', 'tip', {}).xyz) }}", "1.1 0 0.333333333333"),
        ("{{ vector(robot.transform('base', 'tip', robot.poses[0].positions).xyz, six) }}", "0.1 1 0.333333"),
        ("{{ vector(robot.transform('base', 'tip', robot.poses[0].positions).rpy(), six) }}", "0 0 1.570796"),
        ("{{ vector(robot.transform('base', 'tip', {}).quaternion()) }}", "1 0 0 0"),
    ],
)
def test_what_a_template_can_say(text: str, expected: str, tmp_path: Path) -> None:
    assert render(tmp_path, text, options={"options": {"colour": "blue"}}) == expected


def test_markup_is_escaped_where_the_name_says_xml(tmp_path: Path) -> None:
    text = "<robot name='{{ robot.name }}'/>"
    assert render(tmp_path, text, "own.srdf.jinja") == "<robot name='a&lt;b'/>"
    assert render(tmp_path, text, "own.txt.jinja") == "<robot name='a<b'/>"


def test_a_template_can_include_another(tmp_path: Path) -> None:
    (tmp_path / "part.jinja").write_text("{{ robot.root }}")
    assert render(tmp_path, "root: {% include 'part.jinja' %}") == "root: base"


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("{{ robot.nmae }}", "template-failed"),
        ("{{ nothing }}", "template-failed"),
        ("{% if %}", "template-syntax"),
        ("{{ robot.__class__.__mro__ }}", "template-unsafe"),
        ("{{ number.__wrapped__.__globals__ }}", "template-unsafe"),
        ("{{ robot.transform('base', 'nowhere', {}).xyz.foo }}", "template-failed"),
        ("{% include '../secret.txt' %}", "template-missing"),
        ("{% for i in range(10000000) %}{% endfor %}", "template-failed"),
    ],
)
def test_what_goes_wrong_is_a_problem_with_a_name(text: str, rule: str, tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("secret")
    folder = tmp_path / "description"
    folder.mkdir()
    with pytest.raises(TemplateProblem) as problem:
        render(folder, text)
    assert problem.value.diagnostic.rule == rule


def test_a_template_changes_nothing(tmp_path: Path) -> None:
    with pytest.raises(TemplateProblem):
        render(tmp_path, "{% set _ = output.options.update({'x': 1}) %}")
    with pytest.raises(TemplateProblem):
        render(tmp_path, "{% set _ = robot.poses[0].positions.clear() %}")
    assert TESTER.poses[0].positions == {"shoulder": math.pi / 2}


def test_an_output_without_a_template(tmp_path: Path) -> None:
    text, diagnostics = template.write(TESTER, Output("own", "template", "own.txt"), Templates(tmp_path))
    assert text == ""
    assert [(d.rule, d.severity) for d in diagnostics] == [("template-not-named", "error")]


def test_nothing_is_known_of_its_meaning() -> None:
    assert template.FORMAT.read is None


OWN = """\
{"robot": {{ robot.name | tojson }}, "frames": {
{% for joint in robot.joints if joint.publisher.kind == "robot_state_publisher" %}
  {{ joint.child | tojson }}: [{{ joint.origin.xyz | map("float") | join(", ") }}]{{ "," if not loop.last }}
{% endfor %}
}}
"""


def test_one_line_of_yaml_adds_an_artifact(tmp_path: Path) -> None:
    changes = {
        "robot.yaml": (
            "  frames: {file: frames.md}",
            "  frames: {file: frames.md}\n  own: {file: own.json, template: own.json.jinja}",
        )
    }
    path = copy_of_rosorin(tmp_path, changes)
    (path.parent / "own.json.jinja").write_text(OWN)
    files = texts(compiled(path))
    document = json.loads(files["own.json"])
    assert document["robot"] == "rosorin"
    assert document["frames"]["link1"] == [0.04662, 7.5437e-05, 0.16044]
    before = texts(compiled())
    assert {name for name in files if files[name] != before.get(name)} == {"own.json"}


def test_a_mistake_in_a_template_is_shown_in_it(tmp_path: Path) -> None:
    changes = {"robot.yaml": ("  frames: {file: frames.md}", "  own: {file: own.json, template: own.json.jinja}")}
    path = copy_of_rosorin(tmp_path, changes)
    (path.parent / "own.json.jinja").write_text("one\ntwo {{ robot.nmae }}\n")
    made = compile_robot(path, {})
    (found,) = [d for d in made.diagnostics if d.severity == "error"]
    assert found.rule == "template-failed"
    assert found.span is not None
    assert (Path(found.span.source.path).name, found.span.line) == ("own.json.jinja", 2)
    (path.parent / "own.json.jinja").unlink()
    (found,) = [d for d in compile_robot(path, {}).diagnostics if d.severity == "error"]
    assert found.rule == "template-missing"
    assert found.span is not None
    assert Path(found.span.source.path).name == "robot.yaml"


def test_a_template_can_make_well_formed_xml(tmp_path: Path) -> None:
    text = "<r n='{{ robot.name }}'>{% for p in robot.poses %}<p n='{{ p.name }}'/>{% endfor %}</r>"
    root = ElementTree.fromstring(render(tmp_path, text, "own.xml.jinja"))
    assert root.get("n") == TESTER.name


@pytest.mark.parametrize(
    "text",
    [
        "{{ 1|xmlattr }}",
        "{{ 'abc'|truncate(1) }}",
        "{{ 'a' * 10**10 }}",
        "{{ [1] * 10**10 }}",
        "{{ '%9999999999d' % 1 }}",
        "{{ '%9999999999d'|format(1) }}",
        "{{ '{:9999999999}'.format(1) }}",
        "{{ 'a'.ljust(10**11) }}",
        "{{ 'a'|center(10**11) }}",
        "{% for i in range(99999) %}{% for j in range(99999) %}{% endfor %}{% endfor %}",
        "{{ lipsum(n=10**9) }}",
    ],
)
def test_what_would_be_huge_or_breaks_a_filter_is_told_with_its_line(tmp_path: Path, text: str) -> None:
    with pytest.raises(TemplateProblem) as raised:
        render(tmp_path, f"one line\n{text}\n")
    diagnostic = raised.value.diagnostic
    assert diagnostic.rule == "template-failed"
    assert diagnostic.span is not None
    assert diagnostic.span.line == 2


def test_what_is_not_huge_goes_on(tmp_path: Path) -> None:
    text = "{{ 'ab' * 3 }} {{ '%05d' % 7 }} {{ '%s-%s'|format('a', 1) }} {{ 'x'|center(5) }}|{{ 2**10 }}"
    assert render(tmp_path, text + "{% for i in range(3) %}{{ i }}{% endfor %}") == "ababab 00007 a-1   x  |1024012"


def test_a_template_with_a_name_that_no_file_can_have(tmp_path: Path) -> None:
    with pytest.raises(TemplateProblem) as raised:
        Templates(tmp_path).render("a" * 300 + ".jinja", {})
    assert raised.value.diagnostic.rule == "template-missing"


def test_a_template_that_is_a_link_round_or_too_large(tmp_path: Path) -> None:
    (tmp_path / "round").symlink_to("round")
    with (tmp_path / "large").open("wb") as file:
        file.truncate(3_000_000_000)
    for name, rule in (("round", "template-missing"), ("large", "template-failed")):
        with pytest.raises(TemplateProblem) as raised:
            Templates(tmp_path).render(name, {})
        assert raised.value.diagnostic.rule == rule


GROWING = "{% set a = namespace(x='a') %}{% for i in range(60) %}{% set a.x = a.x OP a.x %}{% endfor %}"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (GROWING.replace("OP", "+"), "too much memory"),
        (GROWING.replace("OP", "~"), "too much memory"),
        ("{{ (9**9999)**9999 }}", "s of CPU time"),
        ("{% macro m(n) %}{% if n %}{{ m(n - 1) }}{{ m(n - 1) }}{% endif %}{% endmacro %}{{ m(60) }}", "s of CPU time"),
        ("{{ ('x' * 60000000) }}", "50,000,000 characters"),
    ],
)
def test_a_template_without_end_is_stopped(tmp_path: Path, text: str, reason: str) -> None:
    with pytest.raises(TemplateProblem, match=reason):
        render(tmp_path, text)


def test_chance_has_no_place_in_an_artifact(tmp_path: Path) -> None:
    with pytest.raises(TemplateProblem, match="No filter named 'random'"):
        render(tmp_path, "{{ [1, 2]|random }}")

"""An artifact of the user's own: a template beside the description and one line of YAML."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats import templating as template
from rosorin_compile.formats.templating import TemplateProblem, Templates
from rosorin_compile.model import Box, Joint, Limit, Link, Output, Pose, Robot, Shape
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose

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


def test_a_template_changes_nothing(tmp_path: Path) -> None:
    with pytest.raises(TemplateProblem):
        render(tmp_path, "{% set _ = output.options.update({'x': 1}) %}")
    with pytest.raises(TemplateProblem):
        render(tmp_path, "{% set _ = robot.poses[0].positions.clear() %}")
    assert TESTER.poses[0].positions == {"shoulder": math.pi / 2}


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

"""``rosorin_compile.sweep``: what a program gives, what it gets, and that it can be sent to another process."""

import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import rosorin_compile
from support.commands import HANDY
from support.paths import ROOT

PROJECT = HANDY
ROBOTS = ["descriptions/rosorin", *sorted(f"examples/{path.name}" for path in (ROOT / "examples").iterdir())]


@pytest.fixture(autouse=True)
def here(project: Path) -> Path:
    return project


def shelf(compiled: rosorin_compile.Compiled) -> float:
    assert compiled.robot is not None, compiled.diagnostics
    return float(compiled.robot.joint["shelf_joint"].origin.xyz[2])


def rows() -> Iterator[dict[str, Any]]:
    yield {"name": "one", "scale": 2}
    yield {"name": "two", "scale": "3"}


@pytest.mark.parametrize(
    "variants",
    [{"one": {"scale": 2}, "two": {"scale": "3"}}, [("one", {"scale": 2}), ("two", {"scale": 3.0})], rows()],
    ids=["mapping", "pairs", "generator"],
)
def test_variants_of_a_program(variants: Any) -> None:
    made = list(rosorin_compile.sweep("handy", variants))
    assert [(one.variant and one.variant.name, shelf(one)) for one in made] == [("one", 2.0), ("two", 3.0)]


def test_variants_of_a_file() -> None:
    Path("fleet.yaml").write_text("one: {scale: 2}\ntwo:\n")
    made = list(rosorin_compile.sweep("handy", "fleet.yaml", {"scale": 5}))
    assert [shelf(one) for one in made] == [2.0, 5.0]
    assert made[0].artifacts == rosorin_compile.compile("handy", {"scale": 2}).artifacts
    assert made[0].variant is not None
    assert made[0].variant.span is not None
    assert made[0].variant.span.line == 1


def test_what_is_wrong_with_one_is_its_own() -> None:
    made = list(rosorin_compile.sweep("handy", {"a/b": {}, "": {}, "one": {"skale": 1}, "two": 5, "good": {}}))
    rules = [one.diagnostics[0].rule if one.robot is None else "fine" for one in made]
    assert rules == ["variant-name", "variant-name", "unknown-argument", "bad-argument", "fine"]


@pytest.mark.parametrize(("variants", "rule"), [(5, "variants-list"), ("none.csv", "file-unreadable")])
def test_an_unusable_list_is_one_result_with_an_error(variants: Any, rule: str) -> None:
    (made,) = rosorin_compile.sweep("handy", variants)
    assert (made.robot, made.variant, [one.rule for one in made.diagnostics]) == (None, None, [rule])


def test_a_description_that_is_not_there() -> None:
    (made,) = rosorin_compile.sweep("hardy", {"one": {}})
    assert 'did you mean "handy"?' in str(made.diagnostics[0])


@pytest.mark.parametrize("name", ROBOTS)
def test_what_is_compiled_can_be_sent_to_another_process(name: str) -> None:
    compiled = rosorin_compile.compile(ROOT / name)
    again = pickle.loads(pickle.dumps(compiled))  # noqa: S301 - our own
    assert again == compiled
    assert again.robot == compiled.robot
    assert [str(one) for one in again.diagnostics] == [str(one) for one in compiled.diagnostics]

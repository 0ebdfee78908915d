"""A change is told whole: what was planted in a robot is told, each thing once, and nothing else, in every form."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.check import as_json
from rosorin_compile.cli.main import main
from rosorin_compile.cli.report_formats import Section, markdown
from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import YAML, Side, lines
from rosorin_compile.compare.golden_check import compare
from rosorin_compile.compare.walk import renamed_robot
from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.viewer.changes_page import change_data
from rosorin_compile.viewer.page import data_of
from support.commands import Shown, edit, write_files
from support.machines import exact_urdf, machine, robot_of
from support.paths import ROOT, data_text
from support.planting import DESCRIPTION, URDF, Planted, at, kind_of, leaves, other, plant, put, told
from support.robots import compiled

SEEDS = st.integers(0, 2**32)
MOST = 5
BACKENDS = ("urdf", "mjcf", "sdf")
# What an MJCF has beside, which follows: pairs that it keeps from touching, followers in a keyframe.
FOLLOWS = {"contact", "contacts", "pose"}

# What no comparison reads, and why.
CASES = yaml.safe_load(data_text("cases/told_whole.yaml"))
NOT_TOLD = CASES["not_told"]
# Where a number comes from and where outputs go is no part of a robot.
NOT_OF_A_ROBOT = ("source", "outputs", "stand_in", "stand_ins", "mesh_files", "missing_meshes", "mesh_contents")


@cache
def described() -> tuple[Robot, ...]:
    """The robots of the repository."""
    files = sorted((ROOT / "examples").glob("*/robot.yaml")) + sorted((ROOT / "descriptions").glob("*/robot.yaml"))
    return tuple(robot for file in files if (robot := compiled(file).robot) is not None)


def differences(a: Robot, b: Robot) -> list[str]:
    """Return what ``diff`` says of two robots, which is the same as text and as JSON."""
    found = compare_robots(Side("a", YAML, a), Side("b", YAML, b))
    said = [item["text"] for item in as_json(found)["differences"]]
    assert lines(found, full=True)[2 : 2 + len(said)] == said
    return said


def by_diff(robot: Robot, chance: random.Random) -> None:
    """Plant changes, and let ``diff`` tell them; seen from the other side they are as many."""
    other_robot, planted = plant(robot, chance, chance.randint(1, MOST), DESCRIPTION)
    said = differences(robot, other_robot)
    assert told(planted, said), (planted_of(planted), said)
    assert len(differences(other_robot, robot)) == len(said)


def planted_of(planted: Sequence[Planted]) -> list[tuple[object, ...]]:
    return [one[1:] for one in planted]


def artifacts(robot: Robot) -> list[Artifact]:
    found = []
    for output in robot.outputs:
        text, _ = FORMATS[output.backend].write(robot, output, Templates())  # type: ignore[misc]
        found.append(Artifact(output.file, text, output.backend, output.name))
    return found


def by_check(robot: Robot, chance: random.Random) -> None:
    """Plant changes, and let ``check`` tell them: in text, and in the table of a pull request."""
    chosen = chance.sample(BACKENDS, chance.randint(1, len(BACKENDS)))
    chosen = chosen if "urdf" in chosen else ["urdf", *chosen]
    robot = replace(robot, outputs=tuple(Output(name, name, f"r.{name}") for name in chosen))
    changed, planted = plant(robot, chance, chance.randint(1, MOST), URDF)
    old = {artifact.file: artifact.text.encode() for artifact in artifacts(robot)}
    comparison = compare(changed, artifacts(changed), old)
    own = [change for change in comparison.changes if not FOLLOWS.intersection(change.kind.split())]
    said = [change.line() for change in own]
    assert told(planted, said), (planted_of(planted), said)
    block = markdown([Section("r", differences=said)]).partition("```diff\n")[2].splitlines()[:-1]
    assert told(planted, block), (planted_of(planted), block)
    page = [change_data(change, [changed, robot]) for change in own]
    assert told(planted, [f"{data.get('frame', '')} {data['text']}" for data in page]), (planted_of(planted), page)


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_what_is_planted_in_any_robot_is_told_by_diff(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311
    by_diff(robot_of(chance), chance)


@given(SEEDS)
@settings(max_examples=40, deadline=None)
def test_what_is_planted_in_any_robot_is_told_by_check(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311
    by_check(robot_of(chance), chance)


@given(SEEDS)
@settings(max_examples=10, deadline=None)
def test_what_is_planted_in_a_robot_of_the_repository_is_told_by_diff(seed: int) -> None:
    chance = random.Random(seed)  # noqa: S311
    by_diff(chance.choice(described()), chance)


@pytest.mark.parametrize("way", [by_diff, by_check])
@pytest.mark.parametrize("seed", [*range(6), 408, 433, 1632])
def test_what_is_planted_in_a_few_robots_is_told(seed: int, way: Callable[[Robot, random.Random], None]) -> None:
    chance = random.Random(seed)  # noqa: S311
    way(robot_of(chance), chance)


@pytest.mark.slow
def test_every_number_name_and_attribute_of_a_description_is_told() -> None:
    """One of each kind that the robots of the repository have, changed alone."""
    kinds: dict[str, tuple[Robot, tuple[object, ...]]] = {}
    for robot in described():
        for path, _ in leaves(robot):
            if not set(path) & set(NOT_OF_A_ROBOT):
                kinds.setdefault(kind_of(path), (robot, path))
    silent = []
    for kind, (robot, path) in sorted(kinds.items()):
        try:
            said = differences(robot, put(robot, path, other(at(robot, path))))
        except KeyError:  # a name that others name, too
            continue
        if not said and not any(known in kind for known in NOT_TOLD):
            silent.append(kind)
    assert not silent


def test_the_page_and_the_json_of_a_comparison_tell_the_same(home: Path, capsys: Shown) -> None:
    for seed in range(3):
        chance = random.Random(seed)  # noqa: S311
        robot = robot_of(chance)
        changed, planted = plant(robot, chance, MOST, {key: rule for key, rule in URDF.items() if "name" not in key})
        for name, one in (("a.urdf", robot), ("b.urdf", changed)):
            (home / name).write_text(exact_urdf(one), "utf-8")
        assert main(["diff", "a.urdf", "b.urdf", "--format", "json", "--html", "page.html"]) == 1
        said = [item["text"] for item in json.loads(capsys.readouterr().out)["result"]["differences"]]
        assert told(planted, said), (planted_of(planted), said)
        page = data_of((home / "page.html").read_text("utf-8"))
        assert [change["text"] for change in page["changes"]] == said


def test_a_new_name_hides_no_other_change() -> None:
    """Both commands see through the new name of a link and of a joint."""
    robot = replace(machine(), outputs=tuple(Output(name, name, f"r.{name}") for name in ("urdf", "mjcf")), poses=())
    upper = next(index for index, link in enumerate(robot.links) if link.name == "upper")
    shoulder = next(index for index, joint in enumerate(robot.joints) if joint.name == "shoulder")
    changed = put(robot, ("links", upper, "inertial", "mass"), 0.7)
    changed = put(changed, ("links", upper, "collision", 0, "geometry", "radius"), 0.05)
    changed = put(changed, ("joints", shoulder, "limit", "upper"), 2.5)
    changed = renamed_robot(changed, {"upper": "boom", "wheel": "tyre"}, {"roll": "spin", "shoulder": "lift_arm"})
    old = {artifact.file: artifact.text.encode() for artifact in artifacts(robot)}
    told_by_check = {change.text for change in compare(changed, artifacts(changed), old).changes}
    told_by_diff = set(differences(robot, changed))
    for said, link, joint in ((told_by_check, "boom", "lift_arm"), (told_by_diff, "upper", "shoulder")):
        assert {text.partition(" (")[0] for text in said} == {
            f"{link} mass 0.2 -> 0.7 kg",
            f"{link} collision: capsule radius 0.0312346 -> 0.05 m",
            f"{joint} limit upper 2 -> 2.5 rad",
            "joint roll renamed to spin",
            "joint shoulder renamed to lift_arm",
            "link upper renamed to boom",
            "link wheel renamed to tyre",
        }


CART = data_text("robots/told_whole_cart.yaml")
EDITS = (
    ("radius: 0.1, length: 0.2}, xyz: [0, 0, 0.1]", "radius: 0.11, length: 0.2}, xyz: [0, 0, 0.6]"),
    ("mass: 2", "mass: 3"),
    ("xyz: [1, 0, 0], axis: [0, 0, 1]", "xyz: [2, 0.001, 0], axis: [0, 1, 0]"),
    ("upper: 1, effort: 5", "upper: 1.5, effort: 6"),
)
TOLD = CASES["told"]


def test_no_change_hides_another_in_any_form(home: Path, capsys: Shown) -> None:
    write_files(home, {"descriptions/cart/robot.yaml": CART})
    assert main(["all"]) == 0
    for old, new in EDITS:
        edit(home / "descriptions/cart/robot.yaml", old, new)
    capsys.readouterr()
    assert main(["check", "--html", "page.html", "--summary", "summary.md", "--format", "json"]) == 1
    (message,) = [one for one in json.loads(capsys.readouterr().out)["diagnostics"] if one["rule"] == "outputs-differ"]
    page = data_of((home / "page.html").read_text("utf-8"))
    block = (home / "summary.md").read_text("utf-8").partition("```diff\n")[2].splitlines()
    assert message["message"].splitlines()[: len(TOLD)] == [f"{line}: urdf, mjcf" for line in TOLD]
    assert [change["text"] for change in page["changes"]] == TOLD
    assert block[: len(TOLD)] == [f"{line}: urdf, mjcf" for line in TOLD]
    assert page["said"] == "6 changes against what is committed"

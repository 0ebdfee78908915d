"""simulate: the comment of each case in tests/data/simulation lists the diagnostics that it gets, notes included.

See support/cases.py; a robot that is called good keeps all limits.
"""

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.mujoco import simulation
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.project import Description
from rosorin_compile.source.system import pip_install
from support.cases import as_comment, check
from support.commands import Shown
from support.paths import DATA, ROOT

pytest.importorskip("mujoco", minversion="3.12")

pytestmark = pytest.mark.slow  # MuJoCo, and seconds of simulation

CASES = sorted((DATA / "simulation").glob("*.yaml"))


def simulated(path: Path) -> list[Diagnostic]:
    return list(simulation.simulate(Request(Description("bad", path, Path("outputs")))).diagnostics)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.stem)
def test_message(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(case.parent)
    text = case.read_text("utf-8")
    diagnostics = simulated(Path(case.name))
    check(case, as_comment(diagnostics, case.name))
    assert ("robot: good" in text) == all(one.severity == "note" for one in diagnostics)


# What there is to say of the robots of this project today. A warning would fail.
ROBOTS = {
    "descriptions/rosorin": {"limit-not-reached": 5, "pose-not-held": 1},
    "examples/ackermann_car": {},
    "examples/omni_base": {},
    "examples/porter": {},
    "examples/turtlebot3_burger": {},
    "examples/unitree_a1": {"limit-not-reached": 1},
    "examples/ur5e": {"limit-not-reached": 2},
}
NOT_DRIVEN = {"examples/unitree_a1", "examples/ur5e"}  # they have no wheels


@pytest.mark.landing("engines", "examples/turtlebot3_burger")
@pytest.mark.parametrize("folder", sorted(ROBOTS))
def test_a_robot_of_this_project_behaves(folder: str, monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    monkeypatch.chdir(ROOT)
    assert main(["simulate", f"{folder}/robot.yaml", "--format", "json", "--no-timing"]) == 0
    answer = json.loads(capsys.readouterr().out)
    made, rules = answer["result"], [one["rule"] for one in answer["diagnostics"] if one["rule"] != "stand-in"]
    assert {rule: rules.count(rule) for rule in rules} == ROBOTS[folder]
    assert made["poses"][0]["pose"] == "home"
    assert bool(made["drive"]) != (folder in NOT_DRIVEN)


MECANUM = DATA / "simulation/drive-mecanum.yaml"
ARM = DATA / "simulation/pose-not-held.yaml"


def test_a_mecanum_base_follows_every_command(capsys: Shown) -> None:
    assert main(["simulate", str(MECANUM), "--format", "json"]) == 0
    made = json.loads(capsys.readouterr().out)["result"]
    assert [one["command"] for one in made["drive"]] == ["forward", "sideways", "turn"]
    for one in made["drive"]:
        assert one["off"] < 0.06
        assert one["cross"] < 0.02
        assert one["ripple"] < 0.001
    assert made["own_servos"] == [f"{end}_{side}_joint" for side in ("left", "right") for end in ("front", "rear")]
    assert set(made["timing"]) == {"steps_per_cpu_second", "times_real_time"}


@pytest.mark.tier("engines")
def test_it_is_the_same_every_time(capsys: Shown) -> None:
    printed = []
    for _ in range(2):
        assert main(["simulate", str(MECANUM), "--no-timing"]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]
    assert "steps a CPU second" not in printed[0]


def test_limits_decide(capsys: Shown) -> None:
    assert main(["simulate", str(ARM)]) == 1
    assert main(["simulate", str(ARM), "--limit", "hold=0.1"]) == 0
    assert "warning" not in capsys.readouterr().out.splitlines()[-1]
    assert main(["simulate", str(MECANUM), "--limit", "drive=0", "--no-timing"]) == 1


@pytest.mark.tier("engines")
def test_a_robot_in_another_format_is_simulated(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    monkeypatch.chdir(ROOT)
    assert main(["simulate", "outputs/rosorin/rosorin.xml", "--no-timing"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("rosorin: 2 poses, 10 ranges simulated: ")


def test_what_mujoco_refuses_is_told(home: Path, capsys: Shown) -> None:
    (home / "r.yaml").write_text(
        "robot: r\nlinks: {a: {}, b: {}}\njoints: {j: {type: continuous, parent: a, child: b, axis: [0, 0, 1]}}\n"
    )
    assert main(["simulate", "r.yaml"]) == 1
    shown = capsys.readouterr().err
    assert "error[simulation-refused]: r cannot be simulated: " in shown


def test_without_mujoco_the_way_out_is_told(monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    monkeypatch.setattr(simulation, "is_installed", lambda name: name != "mujoco")
    assert main(["simulate", str(ARM)]) == 2
    said = f"rosorin-compile: simulate needs what is not installed (mujoco): {pip_install('simulate')}\n"
    assert capsys.readouterr().err == said

"""What changed for a simulation is told value by value, and explained and accepted by the names of its entries."""

from __future__ import annotations

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.source.diagnostics import ERROR
from support.paths import data_text
from support.robots import compiled_text

ROBOT = data_text("robots/simulation_robot.yaml")
CASES = yaml.safe_load(data_text("cases/simulation.yaml"))
CHANGES = CASES["changes"]


@pytest.mark.parametrize(("old", "new", "told"), CHANGES)
def test_each_change_is_told(home, capsys, old, new, told):
    (home / "a.yaml").write_text(ROBOT)
    (home / "b.yaml").write_text(ROBOT.replace(old, new))
    assert main(["diff", "a.yaml", "b.yaml"]) == 1
    assert told in capsys.readouterr().out.splitlines()


def test_the_same_is_the_same(home, capsys):
    for name in ("a.yaml", "b.yaml"):
        (home / name).write_text(ROBOT)
    assert main(["diff", "a.yaml", "b.yaml"]) == 0, capsys.readouterr().out


def test_an_entry_is_explained_by_its_name(home, capsys):
    (home / "robot.yaml").write_text(ROBOT)
    assert main(["explain", "robot.yaml", "pull", "kp"]) == 0
    out = capsys.readouterr().out
    lines = out.splitlines()
    assert lines[0] == "pull"
    assert lines[1].split()[:3] == ["kp", "3", "N*m/rad"]
    assert "robot.yaml:2:7" in out  # where the value stands that its expression names
    assert main(["explain", "robot.yaml", "pul"]) != 0
    assert 'did you mean "pull"?' in capsys.readouterr().err


def test_what_a_rule_says_of_an_entry_is_accepted_by_its_name(tmp_path):
    text = ROBOT.replace("{gain: 3}", "{gain: -3}")
    refused = [one for one in compiled_text(tmp_path, text).diagnostics if one.severity == ERROR]
    assert [one.rule for one in refused] == ["dynamics-negative"]
    accepted = text + "accept: [{rule: dynamics-negative, of: [pull], reason: it is meant to}]\n"
    assert not [one for one in compiled_text(tmp_path, accepted).diagnostics if one.severity == ERROR]

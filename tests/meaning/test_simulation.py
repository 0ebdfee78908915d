"""What changed for a simulation is told value by value, and explained and accepted by the names of its entries."""

from __future__ import annotations

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.source.diagnostics import ERROR
from support.robots import compiled_text

ROBOT = """robot: r
let: {gain: 3}
links:
  base:
    inertial: {mass: 1, of: collision}
    collision: [{box: {size: [0.2, 0.2, 0.1]}, contact: {condim: 4, friction: [0.5]}}]
    sites: {mark: {xyz: [0, 0, 0.1]}}
    cameras: {eye: {fovy: 60}}
    mjcf_elements: [<light name="lamp" pos="0 0 1"/>]
  arm: {inertial: {mass: 1, of: [sphere: {radius: 0.1}]}}
joints:
  hip:
    {type: continuous, parent: base, child: arm, axis: [0, 1, 0], dynamics: {stiffness: 2, spring_reference: 0.1},
    actuator: {type: velocity, kv: 0.5, gear: 2}}
constraints: {shut: {type: connect, links: [base, arm], at: [0, 0, 0]}}
actuators: {pull: {tendon: both, type: position, kp: "${gain}", range: [0, 1]}}
poses: {home: {positions: {hip: 0.1}, controls: {pull: 0.2}}}
mjcf:
  - <tendon><fixed name="both" range="0 1"><joint joint="hip" coef="1"/></fixed></tendon>
  - <custom><text name="note" data="x"/></custom>
outputs: {mjcf: {file: r.xml}}
"""
CHANGES = {
    ("condim: 4", "condim: 6"): "base collision: box condim 4 -> 6",
    ("xyz: [0, 0, 0.1]}}", "xyz: [0, 0, 0.2]}}"): "site mark pose xyz 0 0 0.1 rpy 0 0 0 -> xyz 0 0 0.2 rpy 0 0 0",
    ("fovy: 60", "fovy: 50"): "camera eye fovy 60 -> 50",
    ("stiffness: 2", "stiffness: 3"): "hip stiffness 2 -> 3 N*m/rad (+50.0 %)",
    ("spring_reference: 0.1", "spring_reference: 0.2"): "hip spring reference 0.1 -> 0.2 rad (+5.7 deg)",
    ("kv: 0.5", "kv: 0.6"): "hip kv 0.5 -> 0.6 N*m*s/rad (+20.0 %)",
    ("gear: 2", "gear: 3"): "hip actuator gear 2 -> 3",
    ("type: velocity", "type: damper, range: [0, 1]"): "hip actuator type velocity -> damper",
    ("{gain: 3}", "{gain: 4}"): "actuator pull kp 3 -> 4",
    ('coef="1"', 'coef="2"'): "robot mjcf element fixed both joint hip coef 1 -> 2",
    ("controls: {pull: 0.2}", "controls: {pull: 0.3}"): "pose home: controls pull 0.2 -> 0.3",
    ('data="x"', 'data="y"'): "robot mjcf element text note data x -> y",
    ('pos="0 0 1"', 'pos="0 0 2"'): 'base mjcf element light lamp pos "0 0 1" -> "0 0 2"',
    ("at: [0, 0, 0]", "at: [0, 0, 0.1]"): "constraint shut anchor 0 0 0 -> 0 0 0.1",
    ("connect, links: [base, arm], at: [0, 0, 0]", "weld, links: [base, arm], xyz: [0, 0, 0.1]"): (
        "constraint shut relpose: new, 0 0 0.1 1 0 0 0"
    ),
}


@pytest.mark.parametrize(("change", "told"), CHANGES.items(), ids=map(str, CHANGES.values()))
def test_each_change_is_told(home, capsys, change, told):
    (home / "a.yaml").write_text(ROBOT)
    (home / "b.yaml").write_text(ROBOT.replace(*change))
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

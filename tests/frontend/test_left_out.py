"""A name of what a condition or a loop has left out: that is told, once, wherever it is missed, and nothing else is."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import understand
from rosorin_compile.source.diagnostics import ERROR, Diagnostic

ROBOT = """\
robot: cart
args: {both: {default: false}, sides: {default: []}}
parts:
  arm:
    links: {upper: {}, tool: {sites: {grasp: {xyz: [0, 0, 0]}}}}
    joints:
      turn: {type: continuous, parent: mount, child: upper}
      end: {type: fixed, parent: upper, child: tool}
    sensors: {scan: {type: lidar_2d, parent: tool, frame: laser}}
    use: {hand: {part: hand, parent: tool}}
    poses: {home: {positions: {turn: 0}}}
    moveit: {groups: {all: {joints: [turn]}}}
  hand:
    links: {palm: {}}
    joints: {wrist: {type: continuous, parent: mount, child: palm}}
links: {base_link: {}, plate: {}}
joints: {plate_joint: {type: fixed, parent: base_link, child: plate}}
use:
  left: {part: arm, parent: base_link, xyz: [0, 1, 0]}
"""
LEFT_OUT = {
    "condition": (
        '  right: {part: arm, parent: base_link, if: "${both}"}\n',
        '"right" is left out at robot.yaml:20 (both is false)',
    ),
    "false": (
        "  right: {part: arm, parent: base_link, if: false}\n",
        '"right" is left out at robot.yaml:20 (its if is false)',
    ),
    "round": (
        '  "${side}": {for: {side: [right]}, if: "${side == \'l\' and both}", part: arm, parent: base_link}\n',
        "\"right\" is left out at robot.yaml:20 (side == 'l' and both is false)",
    ),
    "no rounds": (
        '  "${side}": {for: {side: "${sides}"}, part: arm, parent: base_link}\n',
        '"${side}" is left out at robot.yaml:20 (its loop has no rounds)',
    ),
    "prefix": (
        '  other: {part: arm, parent: base_link, prefix: right_, if: "${both}"}\n',
        '"other" is left out at robot.yaml:20 (both is false)',
    ),
}
NAMED = {
    "joint of a pose": "poses: {wave: {positions: {left_turn: 0, right_turn: 0, right_hand_wrist: 0}}}\n",
    "parent of a use": "  tray: {part: hand, parent: right_tool}\n",
    "drive": "drive: {differential: {left: [left_turn], right: [right_turn]}, frame: right_upper}\n",
    "servos": "servos: {s: {joints: [right_turn], rad_per_pulse: 0.1, zero_pulse: 5, pulse_range: [0, 9]}}\n",
    "contacts": "disabled_contacts: [{links: [left_tool, right_laser], reason: they meet}]\n",
    "group": "moveit: {groups: {both: {joints: [left_turn, right_turn]}, arms: {groups: [left_all, right_all]}}}\n",
    "state": "moveit: {groups: {arm: {joints: [left_turn], states: {home: right_home}}}}\n",
    "tip": "moveit: {groups: {arm: {chain: {base: base_link, tip: right_hand_palm}}}}\n",
    "edge": "edges: [{parent: right_laser, child: cloud, publisher: slam}]\n"
    "publishers: {slam: {node: slam, package: slam}}\n",
    "control": "control: {hw: {plugin: a/B, joints: {right_turn: {command: [velocity], state: [position]}}}}\n",
    "actuator": "actuators: {motor: {type: motor, joint: right_turn}}\n",
    "site": "actuators: {pull: {site: right_grasp, type: motor}}\n",
}


def told(folder: Path, left_out: str, named: str) -> list[Diagnostic]:
    """Return the errors of the robot with one more use, which is left out, and one more section."""
    outputs = "outputs: {urdf: {file: r.urdf}, srdf: {file: r.srdf}, mjcf: {file: r.xml}}\n"
    (folder / "robot.yaml").write_text(ROBOT + left_out + named + outputs)
    return [one for one in understand(folder / "robot.yaml").diagnostics if one.severity == ERROR]


@pytest.mark.parametrize("how", LEFT_OUT)
def test_nothing_is_missed(tmp_path: Path, how: str) -> None:
    assert told(tmp_path, LEFT_OUT[how][0], "") == []


@pytest.mark.parametrize("how", LEFT_OUT)
@pytest.mark.parametrize("where", NAMED)
def test_what_is_left_out_is_told_once(tmp_path: Path, how: str, where: str) -> None:
    left_out, cause = LEFT_OUT[how]
    found = told(tmp_path, left_out, NAMED[where])
    assert len(found) == 1, [str(one) for one in found]
    assert found[0].message.replace(f"{tmp_path}/", "").endswith(f": {cause}")
    assert found[0].related[0].message == "left out here"


@pytest.mark.parametrize("how", LEFT_OUT)
def test_a_misspelt_name_is_no_name_of_it(tmp_path: Path, how: str) -> None:
    (one,) = told(tmp_path, LEFT_OUT[how][0], "poses: {wave: {positions: {left_trun: 0}}}\n")
    assert (one.rule, one.help) == ("unknown-joint", 'did you mean "left_turn"?')
    assert "left out" not in one.message


def test_several_names_are_told_as_one(tmp_path: Path) -> None:
    every = "".join(
        text for where, text in NAMED.items() if where in ("joint of a pose", "servos", "contacts", "actuator")
    )
    (one,) = told(tmp_path, LEFT_OUT["condition"][0], every)
    missed = [related.message for related in one.related if related.message.startswith("also missed: ")]
    assert len(missed) == 3, "the joint of the hand is told first"


def test_an_entry_that_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(
        """\
robot: mast
args: {tall: {default: false}}
links: {base_link: {}, mast: {if: "${tall}"}, head: {}}
joints:
  mast_joint: {type: fixed, parent: base_link, child: mast}
  head_joint: {type: fixed, parent: mast, child: head}
"""
    )
    (one,) = [one for one in understand(tmp_path / "robot.yaml").diagnostics if one.severity == ERROR]
    assert '"mast" is left out at ' in one.message
    assert [related.message for related in one.related] == [
        "left out here",
        'also used here: the parent of joint "head_joint"',
    ]

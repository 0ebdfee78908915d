"""Corners of what check says of committed artifacts: names that other things have, too, and what a change explains."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.meaning.causes import _painted
from rosorin_compile.meaning.golden import compare
from support.robots import compiled_text, sound

OUTPUTS = "outputs: {urdf: {file: r.urdf}, mjcf: {file: r.xml}, frames: {file: frames.md}, static_tf: {file: tf.py}}\n"
SOLID = "{mass: 1, inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}}"
HINGE = "axis: [0, 0, 1], limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
ROBOT = f"""\
robot: r
materials: {{red: {{rgba: [1, 0, 0, 1]}}, blue: {{rgba: [0, 0, 1, 1]}}}}
links:
  base: {{}}
  arm: {{inertial: {SOLID}, visual: [{{sphere: {{radius: 0.1}}, material: red}}]}}
  hand:
    inertial: {SOLID}
    visual: [{{sphere: {{radius: 0.2}}, material: red}}, {{sphere: {{radius: 0.05}}, rgba: [0, 1, 0, 1]}}]
  lamp: {{inertial: {SOLID}, visual: [{{sphere: {{radius: 0.3}}, material: blue}}]}}
joints:
  turn: {{type: revolute, parent: base, child: arm, xyz: [0, 0, 0.1], {HINGE}}}
  lamp: {{type: revolute, parent: arm, child: hand, xyz: [0.2, 0, 0], {HINGE}, mimic: {{joint: turn}}}}
  arm: {{type: fixed, parent: arm, child: lamp, xyz: [0, 0.3, 0]}}
{OUTPUTS}"""

CHANGES: dict[str, tuple[list[tuple[str, str]], list[str]]] = {
    "a joint that is called like a link has another name": (
        [("  lamp: {type", "  bend: {type")],
        ["joint lamp renamed to bend: urdf, mjcf"],
    ),
    "a fixed joint that is called like a link has another name": (
        [("  arm: {type", "  stick: {type")],
        ["joint arm renamed to stick: urdf"],
    ),
    "a link that is called like a joint has another name": (
        [("  lamp: {inertial", "  bulb: {inertial"), ("child: lamp", "child: bulb")],
        ["link lamp renamed to bulb: urdf, mjcf, frames"],
    ),
    "a link went, and its material with it": (
        [
            (f"  lamp: {{inertial: {SOLID}, visual: [{{sphere: {{radius: 0.3}}, material: blue}}]}}\n", ""),
            ("  arm: {type: fixed, parent: arm, child: lamp, xyz: [0, 0.3, 0]}\n", ""),
            (", blue: {rgba: [0, 0, 1, 1]}", ""),
        ],
        [
            "removed: link lamp (on arm, published by robot_state_publisher): urdf, mjcf, frames",
            "removed: material blue: urdf",
        ],
    ),
    "a material of two links": (
        [("rgba: [1, 0, 0, 1]", "rgba: [1, 1, 0, 1]")],
        ["material red green 0 -> 1 (and therefore the shapes of arm, hand): urdf, mjcf"],
    ),
    "a frame that nobody publishes is new": (
        [
            ("  base: {}\n", "  base: {}\n  mark: {}\n"),
            ("joints:\n", "joints:\n  m: {type: fixed, parent: base, child: mark, publisher: {none: no need}}\n"),
        ],
        ["new: frame mark (on base, published by nobody): mjcf, frames"],
    ),
    "a frame that nobody publishes is new, and no artifact says who": (
        [
            (", frames: {file: frames.md}, static_tf: {file: tf.py}", ""),
            ("  base: {}\n", "  base: {}\n  mark: {}\n"),
            ("joints:\n", "joints:\n  m: {type: fixed, parent: base, child: mark, publisher: {none: no need}}\n"),
        ],
        ["new: frame mark (on base, published by nobody): mjcf"],
    ),
    "a colour that several formats say": (
        [("rgba: [0, 1, 0, 1]", "rgba: [0, 0.5, 0, 1]")],
        ["hand visual colour 0 1 0 1 -> 0 0.5 0 1: urdf, mjcf"],
    ),
    "a name of a shape": (
        [("radius: 0.2}, mat", "radius: 0.2}, name: skin, mat")],
        ["hand visual: sphere nothing -> name skin: urdf"],
    ),
}


@pytest.mark.parametrize("what", CHANGES)
def test_what_is_said(tmp_path: Path, what: str) -> None:
    changes, said = CHANGES[what]
    text = ROBOT
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    _, _, before = sound(compiled_text(tmp_path, ROBOT))
    robot, _, after = sound(compiled_text(tmp_path, text))
    committed = {artifact.file: artifact.text.encode() for artifact in before.artifacts}
    assert [change.line() for change in compare(robot, after.artifacts, committed).changes] == said


def test_a_material_paints_what_is_seen_of_the_links_that_there_are(tmp_path: Path) -> None:
    _, _, before = sound(compiled_text(tmp_path, ROBOT))
    robot, _, after = sound(compiled_text(tmp_path, ROBOT.replace("rgba: [1, 0, 0, 1]", "rgba: [1, 1, 0, 1]")))
    committed = {artifact.file: artifact.text.encode() for artifact in before.artifacts}
    pair = next(one for one in compare(robot, after.artifacts, committed).pairs if one.output == "urdf")
    assert _painted(robot, pair, ("arm", "visual")) == {"red"}
    assert _painted(robot, pair, ("arm", "collision")) == _painted(robot, pair, ("nothing", "visual")) == set()

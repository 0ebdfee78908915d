"""Corners of what check says of committed artifacts: names that other things have, too, and what a change explains."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.model import Robot
from rosorin_compile.output.committed import Comparison, compare
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
        ["material red colour 1 0 0 1 -> 1 1 0 1 (and therefore the shapes of arm, hand): urdf, mjcf"],
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


# A height map that boxes are made from, and frames that some artifacts leave out and carry the shapes of.
MAPPED = f"""\
robot: g
materials: {{red: {{rgba: [1, 0, 0, 1]}}}}
links:
  floor:
    collision:
      - height_map: {{origin: [0, 0], cell: 0.1, step: 0.05, heights: [[0.1, 0.2], [0.1, 0.3]]}}
      - sphere: {{radius: 0.3}}
  base:
    inertial: {SOLID}
    visual: [{{sphere: {{radius: 0.2}}, rgba: [0, 1, 0, 1]}}]
    collision: [{{sphere: {{radius: 0.2}}}}]
  eye: {{collision: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]}}
  arm: {{inertial: {SOLID}, visual: [{{sphere: {{radius: 0.1}}, material: red}}]}}
joints:
  stand: {{type: fixed, parent: floor, child: base, xyz: [0, 0, 0.5], publisher: {{none: the odometry has it}}}}
  look:
    {{type: fixed, parent: base, child: eye, xyz: [0.2, 0, 0], rpy: [0.3, 0, 0.2],
      publisher: {{static_transform_publisher: tf_eye}}}}
  turn: {{type: revolute, parent: base, child: arm, {HINGE}}}
{OUTPUTS.replace("{urdf", "{robot_model: {file: m.json, joints: [turn, stand]}, urdf")}"""
BOTH = [("radius: 0.2}, rgba", "radius: 0.25}, rgba"), ("radius: 0.2}}]\n  eye", "radius: 0.25}}]\n  eye")]

OF_MAPPED: dict[str, tuple[list[tuple[str, str]], list[str]]] = {
    "a cell of a height map": (
        [("[0.1, 0.3]]", "[0.1, 0.2]]")],
        [
            "floor height map: 1 cell changed, by 100.0 mm (and therefore the shapes of floor, base):"
            " urdf, mjcf, robot_model"
        ],
    ),
    "a cell of a height map, and what it does not say": (
        [("[0.1, 0.3]]", "[0.1, 0.2]]"), ("radius: 0.3", "radius: 0.4")],
        [
            "floor height map: 1 cell changed, by 100.0 mm (and therefore the shapes of floor, base):"
            " urdf, mjcf, robot_model",
            "floor collision: sphere radius 0.3 -> 0.4 m (+100.0 mm; and therefore the shapes of base): urdf, mjcf",
        ],
    ),
    "a column of a height map": (
        [("[[0.1, 0.2], [0.1, 0.3]]", "[[0.1, 0.2, 0.1], [0.1, 0.3, 0.1]]")],
        ["floor height map: 2 x 2 -> 2 x 3 cells (and therefore the shapes of floor, base): urdf, mjcf, robot_model"],
    ),
    "what is seen and collides": (
        BOTH,
        [
            "base collision: sphere radius 0.2 -> 0.25 m (+50.0 mm): urdf, mjcf",
            "base visual: sphere radius 0.2 -> 0.25 m (+50.0 mm): urdf, mjcf",
        ],
    ),
    "what is seen and collides, in another colour": (
        [*BOTH, ("rgba: [0, 1,", "rgba: [0, 0.5,")],
        [
            "base collision: sphere radius 0.2 -> 0.25 m (+50.0 mm): urdf, mjcf",
            "base visual colour 0 1 0 1 -> 0 0.5 0 1: urdf, mjcf",
            "base visual: sphere radius 0.2 -> 0.25 m (+50.0 mm): urdf, mjcf",
        ],
    ),
    "a material, and a size of what it paints": (
        [("red: {rgba: [1, 0", "red: {rgba: [1, 1"), ("radius: 0.1}, mat", "radius: 0.15}, mat")],
        [
            "arm visual: sphere radius 0.1 -> 0.15 m (+50.0 mm): urdf, mjcf",
            "material red colour 1 0 0 1 -> 1 1 0 1 (and therefore the shapes of arm): urdf, mjcf",
        ],
    ),
    "a frame that is turned, and its shapes with it": (
        [("rpy: [0.3, 0, 0.2]", "rpy: [0.4, 0, 0.2]")],
        [
            "eye turned 5.7 deg in base: roll 0.3 -> 0.4 rad (and therefore the shapes of base):"
            " urdf, mjcf, static_tf, frames"
        ],
    ),
    "a frame that carries the shapes of its parent": (
        [("xyz: [0, 0, 0.5]", "xyz: [0, 0, 0.6]")],
        [
            "base moved 100.0 mm in floor: origin z 0.5 -> 0.6 m (and therefore the shapes of base):"
            " urdf, mjcf, robot_model, frames"
        ],
    ),
}


@pytest.mark.parametrize(
    ("before", "changes", "said"),
    [
        pytest.param(text, *cases[what], id=what)
        for text, cases in ((ROBOT, CHANGES), (MAPPED, OF_MAPPED))
        for what in cases
    ],
)
def test_what_is_said(tmp_path: Path, before: str, changes: list[tuple[str, str]], said: list[str]) -> None:
    after = before
    for old, new in changes:
        assert after.count(old) == 1, old
        after = after.replace(old, new)
    assert [change.line() for change in _compared(tmp_path, before, after)[1].changes] == said


def _compared(folder: Path, before: str, after: str) -> tuple[Robot, Comparison]:
    """Return the robot of the text after, and what its artifacts say that those of the text before do not."""
    _, _, old = sound(compiled_text(folder, before))
    robot, _, new = sound(compiled_text(folder, after))
    committed = {artifact.file: artifact.text.encode() for artifact in old.artifacts}
    return robot, compare(robot, new.artifacts, committed)

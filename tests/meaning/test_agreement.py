"""The compiled artifacts hold against the model; one that a faulty template spoiled does not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from support.comparing import BASE, COMMITTED
from support.machines import machine
from support.paths import data_text
from support.robots import compiled_text, sound


def emitted(robot: Robot, number_format: str) -> tuple[Robot, list[Artifact]]:
    """Return a robot with every output, and its artifacts."""
    files = {"urdf": "m.urdf", "mjcf": "m.xml", "static_tf": "tf.launch.py", "static_tf_json": "tf.json"}
    files |= {"robot_model": "model.json", "frames": "frames.md", "sdf": "m.sdf"}
    options = {name: {"number_format": number_format} for name in ("urdf", "mjcf", "frames", "sdf")}
    outputs = tuple(Output(name, name, file, options.get(name, {})) for name, file in files.items())
    robot = replace(robot, outputs=outputs)
    texts = [(output, FORMATS[output.backend].write(robot, output, Templates())[0]) for output in outputs]
    return robot, [Artifact(output.file, text, output.backend, output.name) for output, text in texts]


@pytest.mark.parametrize("number_format", ["exact", "six"])
def test_a_robot_with_every_shape_and_joint_agrees(number_format: str) -> None:
    robot, artifacts = emitted(machine(), number_format)
    assert agreement(robot, artifacts) == []


BODY = "{inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}"
NAMESAKES = f"""robot: r
links: {{base: {BODY}, arm: {BODY}, hand: {BODY}, arm_joint: {BODY}}}
joints:
  arm: {{type: continuous, parent: base, child: arm, axis: [0, 0, 1]}}
  hand: {{type: continuous, parent: arm, child: hand, axis: [0, 1, 0], mimic: {{joint: arm, multiplier: 2}}}}
  arm_joint: {{type: continuous, parent: hand, child: arm_joint, axis: [1, 0, 0], mimic: {{joint: hand}}}}
"""


def test_joints_that_are_called_like_links_agree_and_are_held_against_the_model(tmp_path: Path) -> None:
    """An SDF calls them otherwise, the leaders of followers too."""
    made = compiled_text(tmp_path, NAMESAKES).robot
    assert made is not None
    robot, artifacts = emitted(made, "exact")
    assert agreement(robot, artifacts) == []
    sdf = next(one for one in artifacts if one.backend == "sdf")
    others = [one for one in artifacts if one is not sdf]
    for old, new, what in (
        ("<multiplier>2</multiplier>", "<multiplier>3</multiplier>", "mimic multiplier"),
        ("<xyz>0 0 1</xyz>", "<xyz>0 1 0</xyz>", "axis 0 0 1 -> 0 1 0"),
        ('<mimic joint="hand_joint">', '<mimic joint="base">', "cannot be read back"),
    ):
        assert old in sdf.text
        found = agreement(robot, [*others, replace(sdf, text=sdf.text.replace(old, new))])
        assert found
        assert all(what in one.message for one in found)


def test_the_reference_robot_agrees() -> None:
    assert BASE.robot is not None
    assert agreement(BASE.robot, BASE.artifacts) == []


def spoiled(name: str, old: str, new: str) -> list[str]:
    """Return what is said if one artifact has another text in the first place where the old one stands."""
    assert old in COMMITTED[name].decode(), f"{old!r} is not in {name}"
    artifacts = [replace(a, text=a.text.replace(old, new, 1)) if a.file == name else a for a in BASE.artifacts]
    assert BASE.robot is not None
    found = agreement(BASE.robot, artifacts)
    assert {(d.rule, d.severity) for d in found} == {("artifacts-disagree", "error")}
    assert all("please report it" in d.help for d in found)
    return [d.message for d in found]


@pytest.mark.parametrize("case", yaml.safe_load(data_text("cases/spoiled.yaml")), ids=lambda case: case["said"])
def test_an_artifact_that_says_something_else_is_an_error(case: dict[str, str]) -> None:
    found = spoiled(case["file"], case["old"], case["new"])
    assert all(one.startswith(case["file"]) for one in found)
    assert any(case["said"] in one for one in found), found


def test_shapes_that_are_left_out_are_missed() -> None:
    geom = next(line for line in COMMITTED["rosorin.xml"].decode().splitlines() if "link5_collision_1" in line)
    (message,) = spoiled("rosorin.xml", geom, "")
    assert "link5 collision: 1 -> 0 shapes" in message


def test_a_json_artifact_that_does_not_fit_its_schema_is_found() -> None:
    (found,) = spoiled("robot_model.json", '"zero": 500', '"zero": 500, "spare": 1')
    assert found.startswith('robot_model.json does not fit schemas/robot_model.schema.json: "pulse_to_rad"')


def test_blanks_within_names_are_kept_by_every_format(tmp_path: Path) -> None:
    files = {name: one.file.format("r") for name, one in FORMATS.items() if one.write and one.file}
    left = {name: file for name, file in files.items() if name not in ("urdf", "controllers", "nav2", "scene")}
    del left["robot_localization"]
    outputs = "".join(f"  {name}: {{file: every_{file}}}\n" for name, file in left.items())
    robot, _, made = sound(compiled_text(tmp_path, data_text("robots/blanks.yaml") + outputs))
    assert robot.joint["j  j"].child == "a  b"
    assert len(made.artifacts) >= len(left)

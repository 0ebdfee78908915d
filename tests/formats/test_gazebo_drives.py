"""Actuators drive the joints of each output for Gazebo, unless something else does; what is not driven is reported."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import rosorin_compile
from rosorin_compile import Compiled

BODY = "{inertial: {mass: 1, inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}}}"
LIMIT = "limit: {lower: -1, upper: 1, effort: 5, velocity: 2}"
JOINTS = {
    "servo": f"type: revolute, {LIMIT}, actuator: {{kp: 20, kv: 1, damping: 0.5}}",
    "wheel": "type: continuous, actuator: {type: velocity, kv: 0.4}",
    "pushed": f"type: prismatic, {LIMIT}",
    "idle": f"type: revolute, {LIMIT}",
}
ACTUATORS = "actuators: {push: {type: motor, joint: pushed}}\n"


def _compiled(folder: Path, more: str, gazebo: str) -> Compiled:
    links = ", ".join(f"{name}_link: {BODY}" for name in JOINTS)
    joints = ", ".join(f"{name}: {{parent: base, child: {name}_link, {text}}}" for name, text in JOINTS.items())
    text = f"robot: r\nlinks: {{base: {BODY}, {links}}}\njoints: {{{joints}}}\n{more}"
    text += f"outputs: {{urdf: {{file: r.urdf{gazebo}}}, sdf: {{file: r.sdf{gazebo}}}}}\n"
    (folder / "robot.yaml").write_text(text, encoding="utf-8")
    compiled = rosorin_compile.compile(folder / "robot.yaml")
    assert [str(one) for one in compiled.diagnostics if one.severity == "error"] == []
    return compiled


def _plugins(compiled: Compiled) -> list[dict[str, dict[str, str]]]:
    """Return the settings of the plug-ins by joint, for each artifact."""
    found = []
    for artifact in compiled.artifacts:
        plugins = ElementTree.fromstring(artifact.text).iter("plugin")
        own = [one for one in plugins if "-system" in one.get("filename", "")]
        settings = [{"filename": one.get("filename", "")} | {e.tag: e.text or "" for e in one} for one in own]
        found.append({one.pop("joint_name"): one for one in settings})
    return found


def test_each_joint_with_an_actuator_is_driven(tmp_path: Path) -> None:
    for plugins in _plugins(_compiled(tmp_path, ACTUATORS, ", gazebo: harmonic")):
        assert plugins == {
            "servo": {
                "filename": "gz-sim-joint-position-controller-system",
                "p_gain": "20",
                "d_gain": "1.5",
                "cmd_min": "-5",
                "cmd_max": "5",
            },
            "wheel": {"filename": "gz-sim-joint-controller-system", "use_force_commands": "true", "p_gain": "0.4"},
            "pushed": {"filename": "gz-sim-apply-joint-force-system"},
        }


def test_a_joint_of_another_plugin_is_left_to_it(tmp_path: Path) -> None:
    own = '<gazebo><plugin filename="d" name="Wheels"><left_joint>wheel</left_joint></plugin></gazebo>'
    block = '<ros2_control name="c" type="system"><joint name="servo"/></ros2_control>'
    compiled = _compiled(tmp_path, f"{ACTUATORS}urdf_elements: ['{own}', '{block}']\n", ", gazebo: harmonic")
    in_sdf, in_urdf = (set(plugins) for plugins in _plugins(compiled))
    assert in_urdf == {"pushed"}
    assert in_sdf == {"servo", "pushed"}  # an SDF has no ros2_control


def test_what_gazebo_cannot_drive_is_reported(tmp_path: Path) -> None:
    more = "actuators: {valve: {type: intvelocity, joint: idle, kp: 2}}\n"
    compiled = _compiled(tmp_path, more, ", gazebo: fortress")
    lost = [one for one in compiled.diagnostics if '"valve"' in one.message]
    assert {one.rule for one in lost} == {"urdf-cannot-say", "sdf-cannot-say"}


def test_without_gazebo_a_note_names_the_actuators(tmp_path: Path) -> None:
    compiled = _compiled(tmp_path, ACTUATORS, "")
    assert "plugin" not in "".join(one.text for one in compiled.artifacts)
    notes = [one.message for one in compiled.diagnostics if one.rule == "not-in-format"]
    assert notes == ["SDF cannot express actuators (1 place) and joints.actuator (2 places)"]

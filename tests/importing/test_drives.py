"""A robot without actuators moves after its import: servos stand in for them in the MJCF, and a note says so."""

from pathlib import Path

import pytest

from rosorin_compile import import_robot
from rosorin_compile.formats.compilation import compile_robot

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="lever"><inertial>
    <origin xyz="0.3 0 0"/><mass value="1"/><inertia ixx="0.001" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <link name="wheel"><inertial>
    <mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
  </inertial></link>
  <joint name="swing" type="revolute"><parent link="base"/><child link="lever"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="50" velocity="2"/></joint>
  <joint name="spin" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
</robot>
"""


def mjcf(folder: Path, text: str = ARM, **options: str) -> str:
    source = folder / "arm.urdf"
    source.write_text(text, "utf-8")
    made = import_robot(source, output=folder / "made", **options)  # type: ignore[arg-type]
    assert made.written, made.diagnostics
    compiled = compile_robot(folder / "made/robot.yaml")
    notes = [one for one in compiled.diagnostics if one.rule == "drives-assumed"]
    assert len(notes) == (options.get("drives") != "none")
    return next(one.text for one in compiled.artifacts if one.backend == "mjcf")


def test_joints_with_limits_get_position_servos_and_others_velocity_servos(tmp_path: Path) -> None:
    text = mjcf(tmp_path)
    # 0.01 + 1 * 0.3^2 kg*m^2 about the axis, on a servo of 100 rad/s.
    assert '<position name="swing" joint="swing" kp="1000" dampratio="1" ctrlrange="-1 1"/>' in text
    assert '<velocity name="spin" joint="spin" kv="0.01"/>' in text


@pytest.mark.parametrize(("drives", "tags"), [("velocity", ["velocity", "velocity"]), ("none", [])])
def test_the_option_chooses_the_servos(tmp_path: Path, drives: str, tags: list[str]) -> None:
    text = mjcf(tmp_path, drives=drives)
    assert [tag for tag in ("position", "velocity") for _ in range(text.count(f"<{tag} "))] == tags


def test_a_follower_and_a_fixed_joint_get_none(tmp_path: Path) -> None:
    mimic = ARM.replace('<axis xyz="0 0 1"/></joint>', '<axis xyz="0 0 1"/><mimic joint="swing"/></joint>')
    assert mjcf(tmp_path, mimic).count("joint=") == 1


def test_every_joint_follows_a_sine(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    import numpy as np

    model = mujoco.MjModel.from_xml_string(mjcf(tmp_path))
    data = mujoco.MjData(model)
    worst = 0.0
    while data.time < 4:
        angle = 0.1 * np.sin(np.pi * data.time)
        data.ctrl[:] = [angle, 0.1 * np.pi * np.cos(np.pi * data.time)]
        mujoco.mj_step(model, data)
        if data.time > 1:
            worst = max(worst, abs(data.joint("swing").qpos[0] - angle), abs(data.joint("spin").qvel[0] - data.ctrl[1]))
    assert worst < 0.02


def test_the_actuators_of_an_mjcf_are_its_own(tmp_path: Path) -> None:
    source = tmp_path / "r.xml"
    source.write_text('<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody></mujoco>')
    with pytest.raises(Exception, match="leave --drives out"):
        import_robot(source, output=tmp_path / "made", drives="position")

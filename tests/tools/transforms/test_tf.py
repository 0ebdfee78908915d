"""rosorin-compile tf: what the guide recorded with tf2_echo, and states of the joints."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.model.kinematics import Graph
from rosorin_compile.model.tf2 import lookup
from support.commands import Shown, ask
from support.robots import RECORDED, compiled


def tf(capsys: Shown, *words: str, code: int = 0) -> str:
    return ask(capsys, "tf", *words, code=code)


# What tf2_echo printed on the real robot, as the guide has it.
ON_THE_ROBOT = {
    ("laser", ""): ("[0.048, 0.000, 0.107]", "[0.000, -0.000, 180.000]"),
    ("imu_link", ""): ("[-0.027, -0.000, 0.048]", "[-0.000, -0.500, 89.994]"),
    ("camera_link", "tuck"): ("[0.023, 0.001, 0.289]", "[0.219, -7.197, 0.981]"),
    ("depth_camera_link", "tuck"): ("[0.023, 0.001, 0.289]", "[-82.803, 0.217, -88.992]"),
}


@pytest.mark.usefixtures("rosorin")
@pytest.mark.parametrize("asked", ON_THE_ROBOT)
def test_the_lines_of_the_real_robot(asked: tuple[str, str], capsys: Shown) -> None:
    frame, pose = asked
    lines = tf(capsys, "base_link", frame, *(["--pose", pose] if pose else [])).splitlines()
    translation, degrees = ON_THE_ROBOT[asked]
    assert f"- Translation: {translation}" in lines
    assert f"- Rotation: in RPY (degree) {degrees}" in lines


@pytest.mark.usefixtures("rosorin")
def test_every_recorded_transform(capsys: Shown) -> None:
    for recorded in RECORDED["tf"]:
        pose = ["--pose", recorded["pose"]] if "pose" in recorded else []
        said = json.loads(tf(capsys, recorded["from"], recorded["to"], *pose, "--format", "json"))["result"]
        assert [round(value, 3) for value in said["translation"]] == recorded["translation"]
        if "rpy_deg" in recorded:
            assert [round(value, 3) for value in said["rpy_degrees"]] == recorded["rpy_deg"]


@pytest.mark.usefixtures("rosorin")
def test_the_whole_text(capsys: Shown) -> None:
    assert tf(capsys, "base_link", "imu_link") == (
        "At time 0.0\n"
        "- Translation: [-0.027, -0.000, 0.048]\n"
        "- Rotation: in Quaternion [0.003, -0.003, 0.707, 0.707]\n"
        "- Rotation: in RPY (radian) [-0.000, -0.009, 1.571]\n"
        "- Rotation: in RPY (degree) [-0.000, -0.500, 89.994]\n"
        "- Matrix:\n"
        "  0.000 -1.000 -0.000 -0.027\n"
        "  1.000  0.000 -0.009 -0.000\n"
        "  0.009 -0.000  1.000  0.048\n"
        "  0.000  0.000  0.000  1.000\n"
    )


@pytest.mark.usefixtures("rosorin")
def test_jazzy_says_the_order_of_the_quaternion(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "imu_link", "--distro", "jazzy")
    assert "- Rotation: in Quaternion (xyzw) [0.003, -0.003, 0.707, 0.707]\n" in said
    assert said.replace(" (xyzw)", "") == tf(capsys, "base_link", "imu_link")


@pytest.mark.usefixtures("rosorin")
def test_a_frame_in_itself_is_the_identity(capsys: Shown) -> None:
    said = tf(capsys, "laser", "laser")
    assert "- Translation: [0.000, 0.000, 0.000]\n- Rotation: in Quaternion [0.000, 0.000, 0.000, 1.000]\n" in said
    assert "- Rotation: in RPY (degree) [0.000, -0.000, 0.000]\n" in said


@pytest.mark.usefixtures("rosorin")
def test_pulses_of_the_tuck_are_the_tuck(capsys: Shown) -> None:
    pulses = [f"--pulse={joint}={pulse}" for joint, pulse in RECORDED["tuck"]["pulses"].items()]
    radians = [f"--joint=joint{i + 1}={value!r}" for i, value in enumerate(RECORDED["tuck"]["positions_rad"])]
    told = tf(capsys, "base_link", "camera_link", "--pose", "tuck")
    assert tf(capsys, "base_link", "camera_link", *pulses) == told
    assert tf(capsys, "base_link", "camera_link", *radians) == told
    same = ["--pose", "tuck", "--pulse", "joint3=500", "--joint", f"joint3={RECORDED['tuck']['positions_rad'][2]}"]
    assert tf(capsys, "base_link", "camera_link", *same) == told


@pytest.mark.usefixtures("rosorin")
def test_more_digits_widen_the_matrix(capsys: Shown) -> None:
    lines = tf(capsys, "base_link", "laser", "--digits", "6").splitlines()
    assert lines[1] == "- Translation: [0.048156, 0.000076, 0.106748]"
    assert lines[6] == " -1.000000 -0.000000  0.000000  0.048156"
    assert tf(capsys, "base_link", "laser", "--digits", "0").splitlines()[1] == "- Translation: [0, 0, 0]"
    assert tf(capsys, "base_link", "laser", "--digits", "18", code=2) == "rosorin-compile: --digits takes 0 to 17\n"


@pytest.mark.usefixtures("rosorin")
def test_json_has_the_chain_with_its_publishers(capsys: Shown) -> None:
    said = json.loads(tf(capsys, "laser", "camera_link", "--joint", "joint1=30deg", "--format", "json"))["result"]
    assert said["positions"] == {"joint1": pytest.approx(math.pi / 6)}
    assert [(step["parent"], step["child"], step["direction"]) for step in said["chain"][:2]] == [
        ("base_link", "laser", "up"),
        ("base_link", "link1", "down"),
    ]
    by = {"name": "tf_base_laser", "kind": "static_transform_publisher", "when": "always"}
    assert said["chain"][0]["publishers"] == [by]
    assert said["chain"][1]["publishers"][0]["name"] == "robot_state_publisher"
    assert (said["chain"][1]["joint"], said["chain"][1]["type"]) == ("joint1", "revolute")
    assert len(said["matrix"]) == 4
    assert said["rpy_degrees"] == pytest.approx([math.degrees(angle) for angle in said["rpy"]])


FRAMES = ["base_footprint", "base_link", "laser", "link5", "depth_camera_link"]


@pytest.mark.usefixtures("rosorin")
@pytest.mark.landing("fuzz", "link5")
@pytest.mark.parametrize("source", FRAMES)
def test_any_state_is_that_of_the_model(source: str) -> None:
    robot = compiled().robot
    assert robot is not None
    graph = Graph(robot)

    @settings(max_examples=25, deadline=None)
    @given(st.lists(st.floats(-2, 2), min_size=6, max_size=6), st.sampled_from([link.name for link in robot.links]))
    def holds(values: list[float], target: str) -> None:
        names = [*(f"joint{i}" for i in range(1, 6)), "r_joint"]
        state = dict(zip(names, values, strict=True))
        answer, expected = lookup(graph, source, target, state), robot.transform(source, target, state)
        assert answer.translation == pytest.approx(expected.xyz, abs=1e-12)
        for row, other in zip(answer.rows, expected.rows, strict=True):
            assert row == pytest.approx(other, abs=1e-12)

    holds()


@pytest.mark.usefixtures("rosorin")
def test_a_sweep_prints_a_block_a_state(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "link1", "--sweep", "joint1=-30deg:30deg:3")
    heads = [line for line in said.splitlines() if line.startswith("#")]
    assert heads == ["# joint1 = -0.523599", "# joint1 = 0", "# joint1 = 0.523599"]
    assert said.count("At time 0.0") == 3
    assert said.splitlines()[12:22] == tf(capsys, "base_link", "link1").splitlines()


@pytest.mark.usefixtures("rosorin")
def test_a_sweep_as_a_table(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "link1", "--sweep", "joint1=-90deg:90deg:3", "--table")
    assert said == (
        "joint1 (rad)  x (m)  y (m)  z (m)  roll (deg)  pitch (deg)  yaw (deg)\n"
        "      -1.571  0.047  0.000  0.160       0.503       -0.003     90.000\n"
        "       0.000  0.047  0.000  0.160       0.500       -0.000      0.000\n"
        "       1.571  0.047  0.000  0.160       0.497       -0.003    -90.000\n"
    )
    rows = [[float(cell) for cell in line.split()] for line in said.splitlines()[1:]]
    assert [row[0] for row in rows] == [-1.571, 0.0, 1.571]
    assert [row[6] for row in rows] == pytest.approx([90, 0, -90], abs=0.01)


@pytest.mark.usefixtures("rosorin")
def test_several_sweeps_are_all_combinations_and_csv_reads_back(capsys: Shown) -> None:
    sweeps = ["--sweep", "joint1=0:1:2", "--sweep", "joint2=-0.5:0.5:3"]
    lines = tf(capsys, "base_link", "link5", *sweeps, "--csv").splitlines()
    assert lines[0] == "joint1,joint2,x,y,z,roll,pitch,yaw,qx,qy,qz,qw"
    rows = [[float(cell) for cell in line.split(",")] for line in lines[1:]]
    assert [row[:2] for row in rows] == [[a, b] for a in (0, 1) for b in (-0.5, 0, 0.5)]
    robot = compiled().robot
    assert robot is not None
    expected = robot.transform("base_link", "link5", {"joint1": 1.0, "joint2": 0.5})
    assert rows[-1][2:5] == pytest.approx(expected.xyz, abs=1e-12)
    said = json.loads(tf(capsys, "base_link", "link5", *sweeps, "--format", "json"))["result"]
    assert [state["translation"] for state in said] == [row[2:5] for row in rows]

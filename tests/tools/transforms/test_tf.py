"""rosorin-compile tf: what the guide recorded with tf2_echo, and states of the joints."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.joint_values import position
from rosorin_compile.model.kinematics import Graph
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.transforms import lookup
from support.commands import HANDY, Shown, ask
from support.robots import RECORDED, compiled

pytestmark = pytest.mark.usefixtures("rosorin")


def tf(capsys: Shown, *words: str, code: int = 0) -> str:
    return ask(capsys, "tf", *words, code=code)


# What tf2_echo printed on the real robot, as the guide has it.
ON_THE_ROBOT = {
    ("laser", ""): ("[0.048, 0.000, 0.107]", "[0.000, -0.000, 180.000]"),
    ("imu_link", ""): ("[-0.027, -0.000, 0.048]", "[-0.000, -0.500, 89.994]"),
    ("camera_link", "tuck"): ("[0.023, 0.001, 0.289]", "[0.219, -7.197, 0.981]"),
    ("depth_camera_link", "tuck"): ("[0.023, 0.001, 0.289]", "[-82.803, 0.217, -88.992]"),
}


@pytest.mark.parametrize("asked", ON_THE_ROBOT)
def test_the_lines_of_the_real_robot(asked: tuple[str, str], capsys: Shown) -> None:
    frame, pose = asked
    lines = tf(capsys, "base_link", frame, *(["--pose", pose] if pose else [])).splitlines()
    translation, degrees = ON_THE_ROBOT[asked]
    assert f"- Translation: {translation}" in lines
    assert f"- Rotation: in RPY (degree) {degrees}" in lines


def test_every_recorded_transform(capsys: Shown) -> None:
    for recorded in RECORDED["tf"]:
        pose = ["--pose", recorded["pose"]] if "pose" in recorded else []
        said = json.loads(tf(capsys, recorded["from"], recorded["to"], *pose, "--format", "json"))["result"]
        assert [round(value, 3) for value in said["translation"]] == recorded["translation"]
        if "rpy_deg" in recorded:
            assert [round(value, 3) for value in said["rpy_degrees"]] == recorded["rpy_deg"]


def test_pulses_of_the_tuck_are_the_tuck(capsys: Shown) -> None:
    pulses = [f"--pulse={joint}={pulse}" for joint, pulse in RECORDED["tuck"]["pulses"].items()]
    radians = [f"--joint=joint{i + 1}={value!r}" for i, value in enumerate(RECORDED["tuck"]["positions_rad"])]
    told = tf(capsys, "base_link", "camera_link", "--pose", "tuck")
    assert tf(capsys, "base_link", "camera_link", *pulses) == told
    assert tf(capsys, "base_link", "camera_link", *radians) == told
    same = ["--pose", "tuck", "--pulse", "joint3=500", "--joint", f"joint3={RECORDED['tuck']['positions_rad'][2]}"]
    assert tf(capsys, "base_link", "camera_link", *same) == told


FRAMES = ["base_footprint", "base_link", "laser", "link5", "depth_camera_link"]


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
        for row, other in zip(answer.matrix, expected.rows, strict=False):
            assert row[:3] == pytest.approx(other, abs=1e-12)

    holds()


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


# rosorin-compile tf: limits, missing edges, modes, and every way to ask amiss.


PROJECT = HANDY


def test_positions_are_quantities_and_expressions() -> None:
    robot = compiled().robot
    assert robot is not None
    for text in ("30deg", "30 deg", "pi/6", "30*deg", "523.5987755982989 mrad"):
        assert position(robot, "joint1", text) == pytest.approx(math.pi / 6, abs=1e-15)
    assert position(robot, "joint1", "-1.5") == -1.5
    with pytest.raises(RequestError, match='joint "l_joint" follows "r_joint": set that one'):
        position(robot, "l_joint", "0")

"""rosorin-compile tf: what the guide recorded with tf2_echo, and states of the joints."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.joint_values import position
from rosorin_compile.model.kinematics import Graph, NoWay
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.transforms import _no_way, lookup
from support.commands import HANDY, Shown, ask, edit, write_files
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


def test_pulses_of_the_tuck_are_the_tuck(capsys: Shown) -> None:
    pulses = [f"--pulse={joint}={pulse}" for joint, pulse in RECORDED["tuck"]["pulses"].items()]
    radians = [f"--joint=joint{i + 1}={value!r}" for i, value in enumerate(RECORDED["tuck"]["positions_rad"])]
    told = tf(capsys, "base_link", "camera_link", "--pose", "tuck")
    assert tf(capsys, "base_link", "camera_link", *pulses) == told
    assert tf(capsys, "base_link", "camera_link", *radians) == told
    same = ["--pose", "tuck", "--pulse", "joint3=500", "--joint", f"joint3={RECORDED['tuck']['positions_rad'][2]}"]
    assert tf(capsys, "base_link", "camera_link", *same) == told


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


def test_a_sweep_prints_a_block_a_state(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "link1", "--sweep", "joint1=-30deg:30deg:3")
    heads = [line for line in said.splitlines() if line.startswith("#")]
    assert heads == ["# joint1 = -0.523599", "# joint1 = 0", "# joint1 = 0.523599"]
    assert said.count("At time 0.0") == 3
    assert said.splitlines()[12:22] == tf(capsys, "base_link", "link1").splitlines()


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


def test_beyond_a_limit_is_a_warning_and_with_strict_an_error(capsys: Shown) -> None:
    said = 'joint "joint1" at 2.5 rad is above its upper limit of 2.09 rad'
    asked = ["base_link", "link1", "--joint", "joint1=2.5"]
    assert main(["tf", *asked]) == 0
    shown = capsys.readouterr()
    assert f"warning[position-beyond-limit]: {said}\n" in shown.err
    assert "descriptions/rosorin/arm.yaml:10:12: " in shown.err
    assert "At time" in shown.out
    assert f"error[position-beyond-limit]: {said}\n" in tf(capsys, *asked, "--strict", code=1)
    swept = tf(capsys, "base_link", "link1", "--sweep", "joint1=-3:3:7", "--strict", code=1)
    assert swept.count("error[position-beyond-limit]") == 2  # each side once


def test_a_follower_beyond_its_limit_is_told_too(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "link1", "--joint", "r_joint=1.6", "--strict", code=1)
    assert said.count("position-beyond-limit") == 6


def test_frames_of_other_nodes_name_the_missing_edges(capsys: Shown) -> None:
    said = tf(capsys, "map", "laser", code=1)
    message = "the description has no numbers for map -> odom and odom -> base_link, on the way from map to laser"
    assert f"error[transform-not-known]: {message}\n" in said
    assert "publishers.yaml:17:5: map -> odom: slam_toolbox publishes it when slam, known to that node alone\n" in said
    assert "publishers.yaml:18:5: map -> odom: amcl publishes it when not slam, known to that node alone\n" in said
    assert "odom -> base_link: ekf (publish_tf: true in its configuration) publishes it always" in said
    assert "ask the running robot, ros2 run tf2_ros tf2_echo map laser; or give the edge xyz and rpy" in said
    said = tf(capsys, "base_link", "rgb_camera_link", code=1)
    assert "for depth_camera_link -> rgb_camera_link, on the way from base_link to rgb_camera_link\n" in said
    assert "deptrum (from the calibration stored in the camera) publishes it always" in said


def test_in_one_mode_only_its_publishers_are_named(capsys: Shown) -> None:
    assert "amcl" not in tf(capsys, "map", "laser", "--mode", "slam", code=1)
    assert "slam_toolbox" not in tf(capsys, "map", "laser", "--mode", "not slam", code=1)
    said = tf(capsys, "map", "laser", "--mode", "slamm", code=2)
    assert said == 'rosorin-compile: rosorin has no mode "slamm"; did you mean "slam"?\n'


def test_a_transform_that_nobody_publishes_is_answered_with_a_note(capsys: Shown) -> None:
    assert main(["tf", "base_footprint", "camera_link", "--pose", "tuck"]) == 0
    shown = capsys.readouterr()
    assert "- Translation: [0.023, 0.001, 0.314]" in shown.out
    why = "the filter of the odometry owns the transform into base_link"
    assert f"note[transform-unpublished]: no node publishes base_footprint -> base_link: {why}\n" in shown.err


def test_edges_with_a_pose_are_answered_and_modes_told(project: Path, capsys: Shown) -> None:
    assert "- Translation: [0.000, 0.001, 0.000]" in tf(capsys, "handy", "eye_link", "chip")
    file = project / "descriptions" / "handy" / "robot.yaml"
    edit(file, "publisher: slam, when: mapping", "publisher: slam, when: mapping, moving: false, xyz: [1, 0, 0]")
    assert "map -> odom: amcl publishes it when not mapping" in tf(capsys, "handy", "map", "odom", code=1)
    assert main(["tf", "handy", "map", "odom", "--mode", "mapping"]) == 0
    shown = capsys.readouterr()
    assert "- Translation: [1.000, 0.000, 0.000]" in shown.out
    assert "note[transform-sometimes]: map -> odom is published when mapping\n" in shown.err
    edit(
        file, "publisher: amcl, when: not mapping", "publisher: amcl, when: not mapping, moving: false, xyz: [2, 0, 0]"
    )
    said = tf(capsys, "handy", "map", "odom", code=1)
    assert "error[transform-not-known]: map -> odom, on the way from map to odom, depends on the mode\n" in said
    assert "choose a mode: --mode NAME" in said
    assert "- Translation: [2.000, 0.000, 0.000]" in tf(capsys, "handy", "map", "odom", "--mode", "not mapping")
    edit(file, "publisher: amcl, when: not mapping, ", "publisher: amcl, when: not mapping and not mapping, ")
    edit(file, "  - {parent: map, child: odom, publisher: slam, when: mapping, moving: false, xyz: [1, 0, 0]}\n", "")
    said = tf(capsys, "handy", "map", "odom", "--mode", "mapping", code=1)
    assert said == 'rosorin-compile: in these modes no node publishes the frame "map"\n'


def test_trees_that_do_not_meet_are_told() -> None:
    found = _no_way(None, NoWay("moon", "base"))  # type: ignore[arg-type]
    assert (found.rule, found.message) == ("transform-not-known", "moon and base are in trees that do not meet")


def test_positions_are_quantities_and_expressions() -> None:
    robot = compiled().robot
    assert robot is not None
    for text in ("30deg", "30 deg", "pi/6", "30*deg", "523.5987755982989 mrad"):
        assert position(robot, "joint1", text) == pytest.approx(math.pi / 6, abs=1e-15)
    assert position(robot, "joint1", "-1.5") == -1.5
    with pytest.raises(RequestError, match='joint "l_joint" follows "r_joint": set that one'):
        position(robot, "l_joint", "0")


def test_of_several_robots_one_is_named(rosorin: Path, capsys: Shown) -> None:
    write_files(rosorin, HANDY)
    said = tf(capsys, "base_link", "laser", code=2)
    how = "name one: rosorin-compile tf ROBOT SOURCE TARGET"
    assert said == f"rosorin-compile: there are several robots here: handy, rosorin; {how}\n"
    assert tf(capsys, "rosorin", "base_link", "laser").startswith("At time 0.0\n")
    assert tf(capsys, "handy", "base_link", "shelf", "-a", "scale=2") != tf(capsys, "handy", "base_link", "shelf")
    assert tf(capsys, "handy", "base_link", "shelf", "scale:=2").splitlines()[1].endswith("2.000]")


def test_a_description_with_errors_has_no_answer(rosorin: Path, capsys: Shown) -> None:
    edit(
        rosorin / "descriptions" / "rosorin" / "lidar_and_imu.yaml",
        "parent: base_link\n    frame: laser",
        "frame: laser",
    )
    said = tf(capsys, "base_link", "laser", code=1)
    assert "error[" in said
    assert said.endswith("rosorin: a description with errors has no frames and joints to ask about\n")
    said = tf(capsys, "base_link", "laser", "--args", "none.yaml", code=2)
    assert said == 'rosorin-compile: there is no file "none.yaml" of arguments\n'

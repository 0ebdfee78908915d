"""rosorin-compile tf: limits, missing edges, modes, and every way to ask amiss."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model.kinematics import NoWay
from rosorin_compile.rules.joint_states import free_joint, position, sweep_of
from rosorin_compile.rules.transform import _no_way
from rosorin_compile.source.diagnostics import RequestError
from support.commands import HANDY, Shown, ask, edit, write_files
from support.paths import ROOT
from support.robots import compiled

PROJECT = HANDY


def tf(capsys: Shown, *words: str, code: int = 0) -> str:
    return ask(capsys, "tf", *words, code=code)


@pytest.mark.usefixtures("rosorin")
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


@pytest.mark.usefixtures("rosorin")
def test_a_follower_beyond_its_limit_is_told_too(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "link1", "--joint", "r_joint=1.6", "--strict", code=1)
    assert said.count("position-beyond-limit") == 6


@pytest.mark.usefixtures("rosorin")
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


@pytest.mark.usefixtures("rosorin")
def test_in_one_mode_only_its_publishers_are_named(capsys: Shown) -> None:
    assert "amcl" not in tf(capsys, "map", "laser", "--mode", "slam", code=1)
    assert "slam_toolbox" not in tf(capsys, "map", "laser", "--mode", "not slam", code=1)
    said = tf(capsys, "map", "laser", "--mode", "slamm", code=2)
    assert said == 'rosorin-compile: rosorin has no mode "slamm"; did you mean "slam"?\n'


@pytest.mark.usefixtures("rosorin")
def test_a_transform_that_nobody_publishes_is_answered_with_a_note(capsys: Shown) -> None:
    assert main(["tf", "base_footprint", "camera_link", "--pose", "tuck"]) == 0
    shown = capsys.readouterr()
    assert "- Translation: [0.023, 0.001, 0.314]" in shown.out
    why = "the filter of the odometry owns the transform into base_link"
    assert f"note[transform-unpublished]: nobody publishes base_footprint -> base_link: {why}\n" in shown.err


def test_edges_with_a_pose_are_answered_and_modes_told(project: Path, capsys: Shown) -> None:
    assert "- Translation: [0.000, 0.001, 0.000]" in tf(capsys, "eye_link", "chip")
    file = project / "descriptions" / "handy" / "robot.yaml"
    edit(file, "publisher: slam, when: mapping", "publisher: slam, when: mapping, moving: false, xyz: [1, 0, 0]")
    assert "map -> odom: amcl publishes it when not mapping" in tf(capsys, "map", "odom", code=1)
    assert main(["tf", "map", "odom", "--mode", "mapping"]) == 0
    shown = capsys.readouterr()
    assert "- Translation: [1.000, 0.000, 0.000]" in shown.out
    assert "note[transform-sometimes]: map -> odom is published when mapping\n" in shown.err
    edit(
        file, "publisher: amcl, when: not mapping", "publisher: amcl, when: not mapping, moving: false, xyz: [2, 0, 0]"
    )
    said = tf(capsys, "map", "odom", code=1)
    assert "error[transform-not-known]: map -> odom, on the way from map to odom, depends on the mode\n" in said
    assert "choose a mode: --mode NAME" in said
    assert "- Translation: [2.000, 0.000, 0.000]" in tf(capsys, "map", "odom", "--mode", "not mapping")
    edit(file, "publisher: amcl, when: not mapping, ", "publisher: amcl, when: not mapping and not mapping, ")
    edit(file, "  - {parent: map, child: odom, publisher: slam, when: mapping, moving: false, xyz: [1, 0, 0]}\n", "")
    said = tf(capsys, "map", "odom", "--mode", "mapping", code=1)
    assert said == 'rosorin-compile: in these modes nobody publishes the frame "map"\n'


def test_trees_that_do_not_meet_are_told() -> None:
    found = _no_way(None, NoWay("moon", "base"))  # type: ignore[arg-type]
    assert (found.rule, found.message) == ("transform-not-known", "moon and base are in trees that do not meet")


AMISS = [
    ("base_link lazer", 'there is no frame "lazer"; did you mean "laser"?'),
    ("base_link /laser", 'there is no frame "/laser"; did you mean "laser"?'),
    ("base_link", "two frames are needed, and at most one robot: rosorin-compile tf ROBOT SOURCE TARGET"),
    ("a b c d", "two frames are needed, and at most one robot: rosorin-compile tf ROBOT SOURCE TARGET"),
    ("nobody base_link laser", 'no description "nobody": it is no file'),
    ("base_link laser --pose tuk", 'there is no pose "tuk"; did you mean "tuck"?'),
    ("base_link laser --joint joint1", '"joint1" is not JOINT=POSITION'),
    ("base_link laser --joint joint1=", '"joint1=" is not JOINT=POSITION'),
    ("base_link laser --joint joint9=1", 'there is no joint "joint9"; did you mean "joint5"?'),
    ("base_link laser --joint lidar_joint=1", 'joint "lidar_joint" is fixed: it never moves'),
    ("base_link laser --joint joint1=5cm", 'joint "joint1" is revolute: 5cm is a length (m), not an angle (rad)'),
    ("base_link laser --joint joint1=5parsec", 'the position of joint "joint1" has an unknown unit: "parsec"'),
    ("base_link laser --joint joint1=one", 'the position of joint "joint1" cannot be read: one: '),
    ("base_link laser --joint joint1=1e999", 'the position of joint "joint1" is not finite: 1e999'),
    ("base_link laser --joint joint1=[1]", 'the position of joint "joint1" is no number: [1]'),
    ("base_link laser --pulse joint1=5.5", "a pulse is a whole number, 5.5 is none"),
    ("base_link laser --pulse r_joint=5", 'joint "r_joint" has no servo; these have one: joint1, '),
    ("base_link laser --sweep joint1=0:1", '"joint1=0:1" is not JOINT=FROM:TO:COUNT'),
    ("base_link laser --sweep joint1=0:1:x", '"joint1=0:1:x" is not JOINT=FROM:TO:COUNT'),
    ("base_link laser --sweep joint1=0:1:0", "a sweep has 1 to 100,000 states, not 0"),
    ("base_link laser --sweep joint1=0:1:999 --sweep joint2=0:1:999", "the sweeps have 998,001 states together; "),
]


@pytest.mark.usefixtures("rosorin")
@pytest.mark.parametrize(("words", "message"), AMISS, ids=[words for words, _ in AMISS])
def test_asked_amiss(words: str, message: str, capsys: Shown) -> None:
    assert tf(capsys, *words.split(), code=2).startswith(f"rosorin-compile: {message}")


@pytest.mark.usefixtures("rosorin")
def test_a_pulse_that_does_not_exist(capsys: Shown) -> None:
    said = tf(capsys, "base_link", "laser", "--pulse", "joint1=1001", code=1)
    assert said == 'rosorin-compile: there is no pulse 1001 of joint "joint1": outside the range; 0 to 1000 exist\n'


def test_positions_are_quantities_and_expressions() -> None:
    robot = compiled().robot
    assert robot is not None
    turns = free_joint(robot, "joint1")
    for text in ("30deg", "30 deg", "pi/6", "30*deg", "523.5987755982989 mrad"):
        assert position(turns, text) == pytest.approx(math.pi / 6, abs=1e-15)
    assert position(turns, "-1.5") == -1.5
    with pytest.raises(RequestError, match='joint "l_joint" follows "r_joint": set that one'):
        free_joint(robot, "l_joint")


def test_a_sweep_ends_exactly_where_it_says() -> None:
    robot = compiled().robot
    assert robot is not None
    assert sweep_of(robot, "joint1=0.1:0.7:4").positions[-1] == 0.7
    assert sweep_of(robot, "joint1=0.1:0.7:1").positions == (0.1,)


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


def test_no_numpy_is_needed(tmp_path: Path) -> None:
    program = (
        "import sys; from rosorin_compile.cli.main import main; code = main(['tf', 'base_link', 'laser']);"
        "print(sorted({'numpy', 'mujoco'} & set(sys.modules))); sys.exit(code)"
    )
    environment = {**os.environ, "ROSORIN_COMPILE_CACHE": str(tmp_path)}
    ran = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True, env=environment
    )
    assert ran.stdout.splitlines()[-1] == "[]"

"""rosorin-compile pulses: what it prints, and every way to ask amiss."""

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import HANDY, Shown, ask, edit, write_files
from support.robots import RECORDED

pytestmark = pytest.mark.usefixtures("rosorin")


def pulses(capsys: Shown, *words: str, code: int = 0) -> str:
    return ask(capsys, "pulses", *words, code=code)


def test_pulses_become_positions(capsys: Shown) -> None:
    assert pulses(capsys, "joint2=981", "joint3=45") == (
        "joint   pulse  position                degrees\n"
        "joint2  981    -2.014808088502254 rad  -115.44\n"
        "joint3  45     1.9058995431778076 rad  109.2\n"
    )


def test_positions_become_pulses_and_the_rounding_is_told(capsys: Shown) -> None:
    assert pulses(capsys, "joint1=30deg", "joint2=0.5 rad", "joint3=500") == (
        "joint   pulse  position                degrees  asked for               off by\n"
        "joint1  375    0.5235987755982988 rad  30       0.5235987755982988 rad  0 rad\n"
        "joint2  381    0.4984660343695805 rad  28.56    0.5 rad                 -0.00153 rad\n"
        "joint3  500    0 rad                   0\n"
    )
    assert pulses(capsys, "--radians", "joint2=0.5").splitlines()[1].startswith("joint2  381 ")
    assert pulses(capsys, "--degrees", "joint1=30").splitlines()[1].startswith("joint1  375 ")
    assert pulses(capsys, "--radians", "joint1=pi/6", "joint2=-30deg").count("375 ") == 1


def test_all_joints_of_a_pose(capsys: Shown) -> None:
    said = json.loads(pulses(capsys, "--pose", "tuck", "--format", "json"))["result"]
    assert {joint["joint"]: joint["pulse"] for joint in said["joints"]} == RECORDED["tuck"]["pulses"]
    assert [joint["position"] for joint in said["joints"]] == RECORDED["tuck"]["positions_rad"]
    assert said["joints"][0]["pulses_within_limits"] == [2, 998]
    assert (
        said["servos"][0]
        | {
            "name": "arm",
            "joints": [f"joint{i}" for i in range(1, 6)],
            "rad_per_pulse": 0.0041887902047863905,
            "zero_pulse": 500,
            "flipped": True,
            "pulse_range": [0, 1000],
        }
        == said["servos"][0]
    )
    changed = json.loads(pulses(capsys, "--pose", "tuck", "joint1=400", "--format", "json"))["result"]
    assert changed["joints"][0]["pulse"] == 400


def test_poses_of_positions_become_pulses(rosorin: Path, capsys: Shown) -> None:
    poses = "\n  half: {positions: {joint1: 10.1 deg, r_joint: 0.1}}\n  claw: {positions: {r_joint: 0.1}}\n"
    file = rosorin / "descriptions" / "rosorin" / "poses.yaml"
    file.write_text(file.read_text("utf-8").rstrip() + poses, "utf-8")
    assert main(["pulses", "--pose", "half"]) == 0
    shown = capsys.readouterr()
    assert shown.out.splitlines()[1].split()[:2] == ["joint1", "458"]
    assert shown.err == 'without a servo, and not shown, of the pose "half": r_joint\n'
    said = pulses(capsys, "--pose", "claw", code=2)
    assert said == 'rosorin-compile: no joint of the pose "claw" has a servo\n'


def test_nothing_asked_shows_the_calibration(capsys: Shown) -> None:
    lines = pulses(capsys).splitlines()
    assert lines[0] == "arm: position = (500 - pulse) * 0.0041887902047863905"
    assert lines[2] == ("joint1  arm     0 to 1000  -2.0944 to 2.0944 rad  -120 to 120  -2.09 to 2.09 rad  2 to 998")
    assert len(lines) == 7
    assert json.loads(pulses(capsys, "--format", "json"))["result"]["joints"] == []


def test_a_pulse_beyond_a_limit_is_a_warning_and_with_strict_an_error(capsys: Shown) -> None:
    message = 'joint "joint1" at 2.0943951023931953 rad is above its upper limit of 2.09 rad'
    assert main(["pulses", "joint1=0"]) == 0
    shown = capsys.readouterr()
    assert f"warning[position-beyond-limit]: {message}\n" in shown.err
    assert shown.out
    assert f"error[position-beyond-limit]: {message}\n" in pulses(capsys, "joint1=0", "--strict", code=1)


@pytest.mark.parametrize("word", ["500", "30deg", ".5"])
def test_a_number_without_its_joint_says_how_to_write_it(word: str, capsys: Shown) -> None:
    hint = "if it is a pulse or a position, write JOINT="
    assert pulses(capsys, word, code=2).endswith(f"; {hint}{word}\n")
    assert hint not in pulses(capsys, "nobody", code=2)


def test_a_robot_without_servos(home: Path, capsys: Shown) -> None:
    write_files(home, HANDY)
    assert pulses(capsys, "handy", code=2) == 'rosorin-compile: the robot "handy" has no servos\n'


def test_of_several_robots_one_is_named(rosorin: Path, capsys: Shown) -> None:
    write_files(rosorin, HANDY)
    assert "there are several robots here: handy, rosorin; name one" in pulses(capsys, "joint1=500", code=2)
    assert "joint1  500" in pulses(capsys, "rosorin", "joint1=500")


def test_a_description_with_errors(rosorin: Path, capsys: Shown) -> None:
    edit(rosorin / "descriptions" / "rosorin" / "arm.yaml", "zero_pulse: 500", "zero_pulse: 5000")
    assert "error[pulse-range]" in pulses(capsys, "joint1=500", code=1)

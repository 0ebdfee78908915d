"""Explain on the command line: what people and programs get to see, and what they are told after a mistake."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.importing.new_robot import start
from support.commands import HANDY

PROJECT = HANDY


GOLDEN = """\
eye_link: frame, frame of the sensor "eye" (camera), child of the joint "eye_link_joint"
  descriptions/handy/robot.yaml:21:38
  carries eye_link_optical, chip

From base_link to eye_link, moving joints at zero:
  base_link -> shelf: shelf_joint, fixed, published by robot_state_publisher on /tf_static
    descriptions/handy/robot.yaml:12:3
    x               0.1 m   descriptions/handy/robot.yaml:12:68  "${[0.1, cal.left.length, scale]}"
    y               0.12 m  descriptions/handy/robot.yaml:12:68  "${[0.1, cal.left.length, scale]}"
    z               1 m     descriptions/handy/robot.yaml:12:68  "${[0.1, cal.left.length, scale]}"
        cal.left.length = 0.12 m: table  descriptions/handy/calibration.yaml:2:18  120 mm
        scale = 1: argument, its default  descriptions/handy/robot.yaml:3:39  1
    roll pitch yaw  0 rad   not written
    quaternion x y z w  0  0  0  1

  shelf -> eye_link: eye_link_joint, fixed, published by robot_state_publisher on /tf_static
    descriptions/handy/robot.yaml:21:3
    x               0 m     descriptions/handy/robot.yaml:21:61  0
    y               0 m     descriptions/handy/robot.yaml:21:64  0
    z               0.01 m  descriptions/handy/robot.yaml:21:67  1 cm
    roll pitch yaw  0 rad   not written
    quaternion x y z w  0  0  0  1

eye_link in base_link, with all joints at zero:
  xyz                 0.1  0.12  1.01 m
  rpy                 0  0  0 rad
                      0  0  0 deg
  quaternion x y z w  0  0  0  1

"""


@pytest.mark.usefixtures("project")
def test_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "eye"]) == 0
    assert capsys.readouterr().out == GOLDEN
    assert main(["explain", "handy", "eye"]) == 0
    assert capsys.readouterr().out == GOLDEN
    assert main(["explain", "descriptions/handy/robot.yaml", "eye_link"]) == 0
    assert capsys.readouterr().out == GOLDEN


@pytest.mark.usefixtures("project")
def test_for_people_in_a_part(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "left_f1_finger", "odom", "--pose", "open"]) == 0
    told = capsys.readouterr().out
    for line in (
        "    x       0 m      of the pose in the part and that of its mount",
        '        descriptions/handy/parts.yaml:11:14  xyz: [0, "${length / 2}", 5 mm]',
        '          length = 0.02 m: default of the part  descriptions/handy/parts.yaml:3:46  "${2 * base_length}"',
        "    descriptions/handy/parts.yaml:22:18: i = 1",
        'left_f1_finger in base_link, in the pose "open":',
        "Joint left_f1_joint:",
        "    limit lower     0 rad                            descriptions/handy/robot.yaml:8:25  0",
        "        descriptions/handy/parts.yaml:13:16: taken over by ${finger_limit}",
        "Mass:",
        "  map -> odom: published by slam on /tf, when mapping",
        "    the numbers are known to that node alone",
        "  not known: another node alone knows an edge of the chain",
    ):
        assert f"\n{line}\n" in told, line


@pytest.mark.usefixtures("project")
def test_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "eye", "--format", "json", "-a", "scale=2"]) == 0
    (eye,) = json.loads(capsys.readouterr().out)["result"]
    assert eye["chain"][0]["transform"]["xyz"] == [0.1, 0.12, 2.0]
    z = eye["chain"][0]["numbers"][2]
    assert z["origin"]["where"]["line"] == 12
    assert z["origin"]["names"][1] == {
        "name": "scale",
        "value": "2",
        "given_by": "argument, set on the command line",
        "where": None,
        "names": [],
    }
    assert "-0.0" not in json.dumps(eye)


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["shlf"],
            'handy: there is no frame, link, joint, sensor, use, value or number "shlf"; did you mean "shelf"?',
        ),
        (["shelf", "--pose", "x"], 'handy: there is no pose "x"; known: open'),
        (["nobody", "shelf"], 'there is no frame, link, joint, sensor, use, value or number "nobody"'),
    ],
)
def test_unknown_names(capsys: pytest.CaptureFixture[str], words: list[str], message: str) -> None:
    assert main(["explain", *words]) == 2
    assert message in capsys.readouterr().err


def test_several_robots_or_none(project: Path, capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    start("second", project)
    assert main(["explain", "shelf"]) == 2
    told = capsys.readouterr().err
    assert "there are several robots here: handy, second; name one: rosorin-compile explain ROBOT shelf" in told
    assert main(["explain", "second", "laser"]) == 0
    monkeypatch.chdir(project / "descriptions" / "handy")
    assert main(["explain", "shelf"]) == 0
    (project / "descriptions").rename(project / "others")
    assert main(["explain", "shelf"]) == main(["explain", ".", "shelf"]) == 0
    monkeypatch.chdir(project / "others")
    assert main(["explain", "shelf"]) == 2
    assert "there is no descriptions/*/robot.yaml here" in capsys.readouterr().err
    assert main(["explain"]) == 2


def test_a_description_with_errors(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = project / "descriptions" / "handy" / "robot.yaml"
    path.write_text(HANDY["descriptions/handy/robot.yaml"].replace("${cal[side].length", "${cal[sid].length"), "utf-8")
    assert main(["explain", "shelf"]) == 1
    shown = capsys.readouterr()
    assert "error[expression]" in shown.err
    assert "a description with errors has no meaning to explain" in shown.err
    assert shown.out == ""


def test_arguments_and_named_values_are_explained_with_what_uses_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "robot.yaml").write_text(
        "robot: r\n"
        "include: [more.yaml]\n"
        "args: {length: {type: length, default: 300 mm}, spare: 1}\n"
        'let: {half: "${length / 2}"}\n'
        "links: {base_link: {}, a: {}}\n"
        'joints: {j: {type: fixed, parent: base_link, child: a, xyz: [0, 0, "${half}"]}}\n',
        "utf-8",
    )
    (tmp_path / "more.yaml").write_text('links: {b: {if: "${length > 1 m}"}}\n', "utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["explain", "robot.yaml", "half", "length", "spare", "-a", "length=0.5"]) == 0
    assert capsys.readouterr().out == (
        'half = 0.25 m: named value  robot.yaml:4:7  "${length / 2}"\n'
        "  length = 0.5 m: argument, set on the command line\n"
        "  used by:\n"
        '    robot.yaml:6:68  "${half}"\n'
        "length = 0.5 m: argument, set on the command line\n"
        "  used by:\n"
        '    more.yaml:1:17  "${length > 1 m}"\n'
        '    robot.yaml:4:13  "${length / 2}"\n'
        "spare = 1: argument, its default  robot.yaml:3:56  1\n"
        "  nothing uses it\n"
    )
    assert main(["explain", "robot.yaml", "lenght"]) == 2
    assert 'did you mean "length"?' in capsys.readouterr().err

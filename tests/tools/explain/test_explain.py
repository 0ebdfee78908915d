"""Explain: where a frame sits, and for each number the file, line and column that set it, and the way it took."""

import json
import math
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compiled import understand
from rosorin_compile.importing.new_robot import init
from rosorin_compile.language.arguments import read
from rosorin_compile.language.explain import Answer, Explanation, Number, explain
from rosorin_compile.language.origins import Meaning, Origin, Where
from rosorin_compile.source.diagnostics import UnknownName
from support.commands import HANDY

pytestmark = pytest.mark.usefixtures("project")

PROJECT = HANDY


def answers(*names: str, pose: str = "", **given: str) -> list[Explanation | Answer]:
    expanded, lowered, diagnostics, *_ = understand(Path("descriptions/handy/robot.yaml"), given)
    assert lowered is not None, diagnostics
    return explain(expanded, lowered, given, names, pose)


def found(*names: str, pose: str = "", **given: str) -> list[Explanation]:
    explanations = answers(*names, pose=pose, **given)
    assert all(isinstance(one, Explanation) for one in explanations)
    return [one for one in explanations if isinstance(one, Explanation)]


def number(explanation: Explanation, name: str) -> Number:
    (only,) = [n for n in explanation.chain[-1].numbers if n.name == name]
    return only


def origin(explanation: Explanation, name: str) -> Origin:
    known = number(explanation, name).origin
    assert known is not None
    return known


def place(where: Where | None) -> str:
    return "" if where is None else f"{Path(where.file).name}:{where.line}:{where.column}: {where.text}"


def meanings(names: tuple[Meaning, ...], indent: str = "") -> list[str]:
    lines: list[str] = []
    for meaning in names:
        lines.append(f"{indent}{meaning.name} = {meaning.value} ({meaning.given_by}) {place(meaning.where)}".rstrip())
        lines += meanings(meaning.names, indent + "  ")
    return lines


def test_a_plain_number() -> None:
    (eye,) = found("eye_link")
    z = number(eye, "z")
    assert (z.value, z.unit) == (0.01, "m")
    assert place(origin(eye, "z").where) == "robot.yaml:21:67: 1 cm"
    assert number(eye, "roll").origin is None
    assert number(eye, "roll").note == "not written"


def test_a_number_of_a_part_in_a_loop_in_a_part_in_a_loop() -> None:
    (tip,) = found("left_f1_tip")
    x = origin(tip, "x")
    assert number(tip, "x").value == pytest.approx(0.021)
    assert place(x.where) == 'parts.yaml:14:66: "${tip}"'
    assert meanings(x.names) == [
        'tip = 0.021 m (named value) parts.yaml:4:11: "${length + extra}"',
        '  length = 0.02 m (default of the part) parts.yaml:3:46: "${2 * base_length}"',
        "    base_length = 0.01 m (named value) robot.yaml:5:3: 10 mm",
        '  extra = 0.001 m (given where it is used) parts.yaml:26:23: "${i * mm}"',
        '    i = 1 (loop) parts.yaml:22:18: "${range(2)}"',
    ]
    assert [step.message for step in x.stack] == [
        'part "finger" used here as "f1", parent: palm, xyz: [0, "${(i - 0.5) * 30 * mm}", 0]',
        "i = 1",
        'part "hand" used here as "left", parent: base_link, xyz: [0.1, "${sides[side] * cal[side].offset[1]}", 0]',
        "side = left",
        "which is written here",
    ]
    assert [place(step.where).partition(": ")[0] for step in x.stack] == [
        "parts.yaml:21:7",
        "parts.yaml:22:18",
        "robot.yaml:14:3",
        "robot.yaml:15:17",
        "robot.yaml:7:11",
    ]


def test_the_pose_of_a_mount_and_of_what_is_on_it() -> None:
    (palm,) = found("right_palm", scale="2")
    parts = origin(palm, "y").parts
    assert number(palm, "x").value == pytest.approx(0.1 + 0.242)
    assert number(palm, "y").value == pytest.approx(-0.004)
    assert [place(part.where) for part in parts] == [
        'parts.yaml:19:61: xyz: ["${length}", 0, 0]',
        'robot.yaml:19:10: xyz: [0.1, "${sides[side] * cal[side].offset[1]}", 0]',
    ]
    assert meanings(parts[0].names) == [
        'length = 0.242 m (given where it is used) robot.yaml:17:20: "${cal[side].length * scale}"',
        "  cal[side].length = 0.121 m (table) calibration.yaml:3:19: 121 mm",
        '  side = right (loop) robot.yaml:15:17: "${sides}"',
        "    sides = a table of 2 (named value) robot.yaml:7:3: {left: 1, right: -1}",
        "  scale = 2 (argument, set on the command line)",
    ]
    assert set(meanings(parts[1].names)) == {
        "sides[side] = -1 (named value) robot.yaml:7:27: -1",
        "cal[side].offset[1] = 0.004 m (table) calibration.yaml:3:42: 4 mm",
        'side = right (loop) robot.yaml:15:17: "${sides}"',
        "  sides = a table of 2 (named value) robot.yaml:7:3: {left: 1, right: -1}",
    }


def test_a_mirrored_part_on_the_mount_of_its_part() -> None:
    (thumb,) = found("left_thumb_finger")
    assert [number(thumb, axis).value for axis in "xyz"] == pytest.approx([0.101, 0.002 + 0.002 - 0.01, 0.008])
    assert number(thumb, "axis z").value == -1
    assert origin(thumb, "axis z").where.text == "1"
    assert "mirror: y" in origin(thumb, "axis z").stack[0].message
    assert [part.where.text for part in origin(thumb, "x").parts] == [
        'xyz: [0, "${length / 2}", 5 mm]',
        "xyz: [1 mm, 2 mm, 3 mm]",
        'xyz: [0.1, "${sides[side] * cal[side].offset[1]}", 0]',
    ]


def test_what_a_named_value_holds_is_found_in_it() -> None:
    (finger,) = found("right_f0_joint")
    (upper,) = [n for n in finger.joint if n.name == "limit upper"]
    assert upper.value == pytest.approx(math.pi / 2)
    assert upper.origin is not None
    assert place(upper.origin.where) == 'robot.yaml:8:35: "${upper}"'
    assert meanings(upper.origin.names) == [f"upper = {math.pi / 2} rad (named value) robot.yaml:9:3: ${{45*deg * 2}}"]
    assert [place(where) for where in upper.origin.expressions] == ["parts.yaml:13:16: ${finger_limit}"]
    (mass,) = [n for n in finger.inertial if n.name == "mass"]
    assert mass.origin is not None
    assert place(mass.origin.where) == "parts.yaml:5:39: 20 g"
    assert [step.message.partition(",")[0] for step in mass.origin.stack][:2] == [
        'part "finger" used here as "f0"',
        "i = 0",
    ]


def test_a_list_that_is_one_expression() -> None:
    (shelf,) = found("shelf", scale="0.5")
    assert [number(shelf, axis).value for axis in "xyz"] == [0.1, 0.12, 0.5]
    for axis in "xyz":
        assert place(origin(shelf, axis).where) == 'robot.yaml:12:68: "${[0.1, cal.left.length, scale]}"'
        assert (
            meanings(origin(shelf, axis).names)[0] == "cal.left.length = 0.12 m (table) calibration.yaml:2:18: 120 mm"
        )
    (shape,) = shelf.shapes
    assert (shape.purpose, shape.where.text[:12]) == ("collision", "{box: {size:")
    assert [n.name for n in shape.numbers] == ["box size[0]", "box size[1]", "box size[2]"]


def test_frames_of_other_nodes() -> None:
    odom, chip, inner, world, base = found("odom", "chip", "inner", "map", "base_link")
    assert [(edge.parent, edge.child, edge.publisher, edge.when) for edge in odom.chain] == [
        ("map", "odom", "published by slam", "mapping"),
        ("map", "odom", "published by amcl", "not mapping"),
    ]
    assert odom.placed[0].root == "map"
    assert odom.placed[0].transform is None
    assert [edge.child for edge in chip.chain] == ["shelf", "eye_link", "chip"]
    assert place(origin(chip, "y").where) == "robot.yaml:28:80: 1 mm"
    assert chip.placed[0].transform is not None
    assert chip.placed[0].transform.xyz == pytest.approx((0.1, 0.121, 1.01))
    assert inner.placed[0].transform is None
    assert world.chain == ()
    assert world.roles == ("frame of other nodes",)
    assert base.chain == ()
    assert [edge.publisher for edge in base.others] == ["published by ekf (fuses)"]
    assert base.children == ("shelf", "left_palm", "left_thumb_finger", "right_palm", "right_thumb_finger")


def test_names_of_all_kinds() -> None:
    assert [e.name for e in found("eye", "shelf_joint", "shelf", "eye_link")] == ["eye_link", "shelf"]
    with pytest.raises(
        UnknownName, match=r'there is no frame, link, joint, sensor, use, value or number "shelv"; did you mean "shelf"'
    ):
        found("shelv")
    with pytest.raises(UnknownName, match=r'there is no pose "opn"; did you mean "open"'):
        found("shelf", pose="opn")


def test_a_pose() -> None:
    (tip,) = found("left_f0_tip", pose="open")
    at_zero, opened = tip.placed
    assert (at_zero.pose, opened.pose) == ("", "open")
    assert at_zero.transform is not None
    assert opened.transform is not None
    assert at_zero.transform.rpy_degrees == (0, 0, 0)
    assert opened.transform.rpy_degrees == pytest.approx((0, 0, 45))
    half = math.sin(math.pi / 8)
    assert opened.transform.quaternion_xyzw == pytest.approx((0, 0, half, math.cos(math.pi / 8)))


def test_an_argument_from_a_file(project: Path) -> None:
    (project / "mine.yaml").write_text("scale: 3\n", "utf-8")
    given = read([Path("mine.yaml")], {})
    expanded, lowered, *_ = understand(Path("descriptions/handy/robot.yaml"), given)
    assert lowered is not None
    (shelf,) = explain(expanded, lowered, given, ["shelf"])
    assert meanings(origin(shelf, "z").names)[1] == "scale = 3 (argument, set by the file) mine.yaml:1:8: 3"


def test_a_number_that_none_has_is_told() -> None:
    with pytest.raises(UnknownName, match='"mas"; did you mean "mass"'):
        answers("left_f1_tip", "left", "mas")


# Explain on the command line: what people and programs get to see, and what they are told after a mistake.


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


def test_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", "eye"]) == 0
    assert capsys.readouterr().out == GOLDEN
    assert main(["explain", "handy", "eye"]) == 0
    assert capsys.readouterr().out == GOLDEN
    assert main(["explain", "descriptions/handy/robot.yaml", "eye_link"]) == 0
    assert capsys.readouterr().out == GOLDEN


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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["shlf"], 'handy: there is no frame, link, joint, sensor, use, value or number "shlf"; did you mean "shelf"?'),
        (["shelf", "--pose", "x"], 'handy: there is no pose "x"; known: open'),
        (["nobody", "shelf"], 'there is no frame, link, joint, sensor, use, value or number "nobody"'),
    ],
)
def test_unknown_names(capsys: pytest.CaptureFixture[str], words: list[str], message: str) -> None:
    assert main(["explain", *words]) == 2
    assert message in capsys.readouterr().err


def test_several_robots_or_none(project: Path, capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    init("second", project=project)
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

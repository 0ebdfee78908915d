"""Arguments as a person gives and lists them: on the command line, from files, through includes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main

ROBOT = """\
robot: cart
include:
  - {file: tower.yaml, args: {colour: red}}
args:
  base: {one_of: [fixed, free], default: fixed, help: how it stands}
  mast: {type: length, default: 120 mm, help: height of the mast}
  tag: {type: text}
  steps:
    type: list
    default: [1, 2,   # the third is new
              3]
  scaled: {default: "${2 * mast}"}
links: {base_link: {}, top: {}}
joints:
  top_joint: {type: fixed, parent: base_link, child: top, xyz: [0, 0, "${mast}"]}
outputs:
  urdf: {file: cart.urdf}
"""
TOWER = "args: {colour: {default: blue}}\n"
PROJECT = {"descriptions/cart/robot.yaml": ROBOT, "descriptions/cart/tower.yaml": TOWER}


def listed(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, dict[str, object]]:
    capsys.readouterr()
    assert main(["args", "--format", "json", *words]) == 0
    (robot,) = json.loads(capsys.readouterr().out)["result"]
    return {argument["name"]: argument for argument in robot["arguments"]}


def height() -> str:
    (line,) = [line for line in Path("outputs/cart/cart.urdf").read_text("utf-8").splitlines() if "<origin" in line]
    return line.split('"')[1].split()[2]


@pytest.mark.usefixtures("project")
def test_the_list_says_what_is_declared_and_where(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["args"]) == 0
    assert capsys.readouterr().out == (
        "cart:\n"
        "  name    type    allowed      default        set to  where\n"
        "  colour  any                  blue           red     descriptions/cart/tower.yaml:1:8\n"
        "  base    any     fixed, free  fixed                  descriptions/cart/robot.yaml:5:3\n"
        "          how it stands\n"
        "  mast    length               120 mm                 descriptions/cart/robot.yaml:6:3\n"
        "          height of the mast\n"
        "  tag     text                 (required)             descriptions/cart/robot.yaml:7:3\n"
        "  steps   list                 [1, 2, 3]              descriptions/cart/robot.yaml:8:3\n"
        '  scaled  any                  "${2 * mast}"          descriptions/cart/robot.yaml:12:3\n'
    )


@pytest.mark.usefixtures("project")
def test_the_list_for_programs(capsys: pytest.CaptureFixture[str]) -> None:
    found = listed(capsys)
    where = {"file": "descriptions/cart/robot.yaml", "line": 6, "column": 3}
    told = {"name": "mast", "type": "length", "allowed": [], "required": False, "default": "120 mm"}
    assert found["mast"] == {**told, "help": "height of the mast", "span": where, "value": "", "set_at": None}
    assert found["tag"]["required"] is True
    assert found["base"]["allowed"] == ["fixed", "free"]
    place = {"file": "descriptions/cart/robot.yaml", "line": 3, "column": 39}
    assert (found["colour"]["value"], found["colour"]["set_at"]) == ("red", place)


def test_a_robot_without_arguments(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "descriptions" / "cart" / "robot.yaml").write_text("robot: cart\nlinks: {a: {}}\n", "utf-8")
    assert main(["args"]) == 0
    assert capsys.readouterr().out == "cart has no arguments\n"


def test_arguments_of_a_broken_description_are_listed_all_the_same(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = project / "descriptions" / "cart" / "robot.yaml"
    path.write_text(ROBOT.replace("type: fixed", "type: fixd").replace("${mast}", "${mst}"), "utf-8")
    assert main(["args"]) == 0
    assert "height of the mast" in capsys.readouterr().out
    path.write_text(ROBOT.replace("robot: cart", "robot: [cart"), "utf-8")
    assert main(["args"]) == 1
    assert "error[yaml-syntax]" in capsys.readouterr().err


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    "words",
    [
        ["-a", "tag=a", "-a", "mast=150mm"],
        ["-a", "tag=a", "--arg", "mast=0.15"],
        ["tag:=a", "mast:=150mm"],
        ["cart", "tag:=a", "-a", "mast:=150 mm"],
        ["--args", "mine.yaml"],
        ["--args", "other.yaml", "--args", "mine.yaml"],
        ["--args", "other.yaml", "-a", "mast=15cm"],
    ],
)
def test_every_way_to_give_arguments(words: list[str]) -> None:
    Path("mine.yaml").write_text("mast: 150 mm\ntag: a\n", "utf-8")
    Path("other.yaml").write_text("mast: 3 m\ntag: b\n", "utf-8")
    assert main(["all", *words]) == 0
    assert height() == "0.15"
    assert main(["check", *words]) == 0


def test_a_file_of_arguments_is_typed(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "mine.yaml").write_text('tag: "12"\nsteps: [1, 2]\nmast: 150 mm\n', "utf-8")
    found = listed(capsys, "--args", "mine.yaml")
    where = {"file": "mine.yaml", "line": 2, "column": 8}
    assert (found["steps"]["value"], found["steps"]["set_at"]) == ("[1, 2]", where)
    assert main(["all", "--args", "mine.yaml"]) == 0, 'text in quotes is text: "12" is a tag'
    (project / "mine.yaml").write_text("tag: 12\n", "utf-8")
    assert main(["all", "--args", "mine.yaml"]) == 1
    assert (
        'mine.yaml:1:6: error[bad-argument]: "tag" of the description is text, not a number' in capsys.readouterr().err
    )


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mst: 3 mm\n", 'mine.yaml:1:1: error[unknown-argument]: the description has no argument "mst"'),
        ("mast: 3 kg\n", 'mine.yaml:1:7: error[bad-argument]: "mast" of the description is a length, not a mass (kg)'),
        ("base: loose\n", 'mine.yaml:1:7: error[bad-argument]: "loose" is not a value of the argument "base"'),
        ("tag: ${mast}\n", 'mine.yaml:1:6: error[bad-argument]: the argument "tag" is an expression'),
        ("steps: [1, {a: '${1}'}]\n", 'mine.yaml:1:8: error[bad-argument]: the argument "steps" is an expression'),
        ("- a\n", "mine.yaml:1:1: error[not-a-mapping]"),
        ("a: [\n", "error[yaml-syntax]"),
    ],
)
@pytest.mark.parametrize("command", ["all", "check", "args"])
def test_mistakes_in_a_file_have_their_place(
    capsys: pytest.CaptureFixture[str], command: str, text: str, message: str
) -> None:
    Path("mine.yaml").write_text(text, "utf-8")
    assert main([command, "--args", "mine.yaml"]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["-a", "mst=3mm"], 1, 'did you mean "mast"?'),
        (["mst:=3mm"], 1, 'did you mean "mast"?'),
        (["-a", "mast=3kg"], 1, '"mast" of the description is a length, not a mass (kg)'),
        (["-a", "base=loose"], 1, "allowed: fixed, free"),
        (["-a", "mast"], 2, '"mast" is not NAME=VALUE'),
        ([":=3"], 2, '":=3" is not NAME=VALUE'),
        (["--args", "none.yaml"], 2, 'there is no file "none.yaml" of arguments'),
        (["crt"], 2, 'did you mean "cart"?'),
    ],
)
def test_mistakes_on_the_command_line(
    capsys: pytest.CaptureFixture[str], words: list[str], code: int, message: str
) -> None:
    assert main(["args", *words]) == code
    assert message in capsys.readouterr().err


@pytest.mark.usefixtures("project")
def test_a_missing_argument_says_how_to_give_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["all"]) == 1
    assert "give it: -a tag=VALUE" in capsys.readouterr().err


def test_a_changed_file_of_arguments_is_noticed(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The memory of a run has the file of arguments, too."""
    (project / "mine.yaml").write_text("mast: 150 mm\ntag: a\n", "utf-8")
    for expected in ("written: cart.urdf", "unchanged"):
        assert main(["all", "--args", "mine.yaml"]) == 0
        assert expected in capsys.readouterr().out
    (project / "mine.yaml").write_text("mast: 200 mm\ntag: a\n", "utf-8")
    assert main(["all", "--args", "mine.yaml"]) == 0
    assert height() == "0.2"
    assert main(["all", "-a", "tag=a"]) == 0
    assert height() == "0.12"

"""``check NAME``: found by its record, called by its name or by the option that it was, told apart from a robot."""

import os
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import click
import pytest

from rosorin_compile.cli import watch
from rosorin_compile.cli.main import main, program
from rosorin_compile.cli.registry import commands
from support.commands import Shown, write_files
from support.paths import DATA

CART = """\
robot: {name}
links: {{base_link: {{}}, wheel: {{inertial: {{mass: 1, inertia: {{ixx: 1e-3, iyy: 1e-3, izz: 1e-3}}}}}}}}
joints: {{axle: {{type: fixed, parent: base_link, child: wheel, xyz: [0.1, 0, 0]}}}}
outputs: {{urdf: {{file: {name}.urdf}}}}
"""


@pytest.fixture
def carts(home: Path, capsys: Shown) -> Path:
    write_files(home, {f"descriptions/{name}/robot.yaml": CART.format(name=name) for name in ("physics", "cart")})
    assert main(["all"]) == 0
    capsys.readouterr()
    return home


def test_each_check_is_in_the_help(capsys: Shown) -> None:
    assert main(["check", "--help"]) == 0
    said = capsys.readouterr().out
    for one in commands("checks").values():
        assert f"\n  {one.name} " in said
        assert one.help.split()[0] in said


@pytest.mark.parametrize(
    ("line", "name", "left"),
    [
        ("check cart", "check", "cart"),
        ("check physics cart", "check physics", "cart"),
        ("check --hook physics a b", "check physics", "--hook a b"),
        ("check -o physics", "check", "-o physics"),
        ("check --format json physics", "check physics", "--format json"),
        ("check -- physics", "check", "-- physics"),
        ("check cart physics", "check", "cart physics"),
        ("check descriptions/physics", "check", "descriptions/physics"),
        ("check side:=left", "check", "side:=left"),
    ],
)
@pytest.mark.usefixtures("carts")
def test_the_name_of_a_check_stands_first(line: str, name: str, left: str) -> None:
    found, _, words = program().resolve_command(click.Context(program()), line.split())
    assert (found, " ".join(words)) == (name, left)


@pytest.mark.usefixtures("carts")
def test_a_robot_that_is_called_as_a_check_is_reached_by_its_path(capsys: Shown) -> None:
    pytest.importorskip("mujoco")
    assert main(["check", "physics", "cart"]) == 0
    shown = capsys.readouterr()
    way = "rosorin-compile check descriptions/physics"
    assert f'rosorin-compile: "physics" is a check; the robot of that name: {way}\n' in shown.err
    assert shown.out == "cart: physics of zero: nothing to say\n"
    assert main(["check", "descriptions/physics"]) == 0
    shown = capsys.readouterr()
    assert "is a check" not in shown.err
    assert shown.out == "physics: 1 artifact up to date in outputs/physics\n"


@pytest.mark.usefixtures("carts")
def test_a_slip_in_the_name_of_a_check_is_met_with_it(capsys: Shown) -> None:
    assert main(["check", "phisics"]) == 2
    assert '"phisics" is no check; did you mean "physics"?' in capsys.readouterr().err


def test_parameters_of_the_only_robot_here(home: Path, capsys: Shown) -> None:
    folder = DATA / "parameters" / "controllers"
    text = (folder / "robot.yaml").read_text("utf-8")
    write_files(home, {"descriptions/bot/robot.yaml": text, "sound.yaml": (folder / "sound.yaml").read_text("utf-8")})
    assert main(["check", "parameters", "sound.yaml"]) == 0
    assert capsys.readouterr().out == "bot: 1 edge of nodes held against the files: as described\n"


# ``NAME:=VALUE`` sets an argument wherever ``-a`` does: found by asking the parser of every command.


ROBOT = """\
robot: r
args: {x: {type: length, default: 1}}
links: {a: {collision: [{sphere: {radius: "${x}"}}]}, b: {}}
joints:
  j: {type: revolute, parent: a, child: b, axis: [0, 0, 1], limit: {lower: 0, upper: 1, effort: 1, velocity: 1}}
outputs: {urdf: {file: r.urdf}}
"""
# What stands behind the name of a command, for a robot in r.yaml; the argument comes in front of it and behind.
WORDS = {
    "all": ["r.yaml"],
    "print": ["r.yaml", "urdf"],
    "check": ["r.yaml", "--every-argument"],
    "watch": ["r.yaml"],
    "sweep": ["r.yaml", "--over", "fleet.csv", "-o", "made"],
    "collisions": ["r.yaml"],
    "import": ["r.xacro", "-o", "made"],
    "diff": ["r.yaml", "r.yaml"],
    "explain": ["r.yaml", "b"],
    "tf": ["r.yaml", "a", "b"],
    "frames": ["r.yaml"],
    "pulses": ["r.yaml"],
    "args": ["r.yaml"],
    "view": ["r.yaml", "--html", "r.html"],
    "picture": ["r.yaml", "-o", "r.png"],
    "simulate": ["r.yaml"],
    "package": ["r.yaml", "-o", "pkg"],
    "deploy": ["r.yaml", "-o", "."],
    "verify": ["r.yaml", str(DATA / "recordings" / "session.txt")],
    "extract boxes": ["r.xacro"],
    "extract heightmap": ["r.xacro", "--link", "a", "--cell", "1cm"],
    "extract factory": [".", "-o", "made"],
}
XACRO = (
    '<robot xmlns:xacro="http://ros.org/wiki/xacro" name="r"><xacro:arg name="x" default="1"/><link name="a"/></robot>'
)


@pytest.mark.parametrize("name", WORDS)
def test_a_word_sets_what_the_option_sets(
    name: str, home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A name that the robot does not have is refused in the same words, wherever the word stands."""
    files = {"r.yaml": ROBOT, "r.xacro": XACRO, "fleet.csv": "name\nr1\n"}
    write_files(home, {**files, "package.xml": "<package><name>p</name></package>"})
    monkeypatch.setattr(watch, "signal", mock.MagicMock())
    monkeypatch.setattr(watch, "time", SimpleNamespace(sleep=interrupted))
    command, words = name.split(), WORDS[name]
    said = []
    for call in (
        [*command, *words, "-a", "nothing=1"],
        [*command, *words, "nothing:=1"],
        [*command, "nothing:=1", *words],
    ):
        said.append((main(call), capsys.readouterr().err))
    assert said[0] == said[1] == said[2]
    assert said[0][0] == (130 if name == "watch" else 1)
    assert 'has no argument "nothing"' in said[0][1]


def interrupted(_seconds: float) -> None:
    raise KeyboardInterrupt


@pytest.mark.parametrize("word", ["prefix=left_", "prefix:left_"])
@pytest.mark.parametrize("words", [["print", "r.yaml", "urdf"], ["print", "urdf"], ["all", "r.yaml"], ["check"]])
def test_half_a_mark_is_told(home: Path, capsys: Shown, words: list[str], word: str) -> None:
    (home / "r.yaml").write_text(ROBOT)
    assert main([*words, word]) == 2
    assert capsys.readouterr().err == f'rosorin-compile: "{word}" sets no argument: write prefix:=left_\n'


def test_a_file_of_arguments_that_is_none_is_called_what_it_is(home: Path, capsys: Shown) -> None:
    os.mkfifo(home / "pipe")
    (home / "folder").mkdir()
    for name, kind in (
        ("pipe", '"pipe" is not a regular file of arguments: a pipe can be read once only; write it to a file first'),
        ("/dev/null", '"/dev/null" is not a regular file of arguments'),
        ("folder", '"folder" is a folder, not a file of arguments'),
        ("nothing.yaml", 'there is no file "nothing.yaml" of arguments'),
    ):
        assert main(["print", "r.yaml", "urdf", "--args", name]) == 2
        assert kind in capsys.readouterr().err

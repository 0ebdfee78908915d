"""``check NAME``: found by its record, called by its name or by the option that it was, told apart from a robot."""

from __future__ import annotations

from pathlib import Path

import click
import pytest

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
    """A project of a robot that is called as a check, and one that is not."""
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
def test_a_check_that_stands_behind_the_robot_is_told_where_it_stands(home: Path, capsys: Shown) -> None:
    said = '"deployed" is a check; write it before the robot: check deployed ROBOT'
    for words in ("check cart deployed", "check --format json cart -o out deployed"):
        assert main(words.split()) == 2
        assert capsys.readouterr().err.startswith(f"rosorin-compile: {said}\nrosorin-compile: no description")
    assert main(["check", "cart", "physics"]) == 0, "a robot"
    (home / "deployed").touch()
    assert main(["check", "cart", "deployed", "--hook"]) == 2
    assert "stands before" not in capsys.readouterr().err


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

"""Files of other ROS packages: what one package has in parts, two robots of others include."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compiled import Compiled, compile_robot
from rosorin_compile.source.diagnostics import text

WHEELS = """\
help: wheels that several robots have
include: [more/casters.yaml]
let: {tyre: "${load('package://acme_parts/config/tyre.yaml')}"}
args: {tread: {type: length, default: 1 mm, help: of the tyre}}
parts:
  wheel:
    links: {wheel: {collision: [{cylinder: {radius: "${tyre.radius + tread}", length: 20 mm}}]}}
    joints: {axle: {type: continuous, parent: mount, child: wheel, axis: [0, 0, 1]}}
"""
CASTERS = (
    "parts: {caster: {links: {caster: {}}, joints: {caster_joint: {type: fixed, parent: mount, child: caster}}}}\n"
)
ROBOT = """\
robot: NAME
include: [INCLUDE]
links: {base: {}}
use: {left: {part: wheel, parent: base}, rear: {part: caster, parent: base}}
outputs: {urdf: {file: robot.urdf}}
"""
SHORT = "package://acme_parts/parts/wheels.yaml"


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a workspace: acme_parts, and two packages with a robot each that include its parts."""
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)
    src = tmp_path / "src"
    package(src / "acme_parts")
    write(src / "acme_parts/parts/wheels.yaml", WHEELS)
    write(src / "acme_parts/parts/more/casters.yaml", CASTERS)
    write(src / "acme_parts/config/tyre.yaml", "radius: 50 mm\n")
    for name in ("cart", "rover"):
        package(src / f"{name}_description")
        write(robot_of(src, name), ROBOT.replace("NAME", name).replace("INCLUDE", SHORT))
    monkeypatch.chdir(tmp_path)
    return src


def package(folder: Path) -> None:
    write(folder / "package.xml", f'<package format="3"><name>{folder.name}</name></package>')


def write(path: Path, content: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content, "utf-8")


def robot_of(src: Path, name: str) -> Path:
    return src / f"{name}_description/descriptions/{name}/robot.yaml"


def links(made: Compiled) -> list[str]:
    assert made.robot is not None, text(made.diagnostics)
    assert not made.diagnostics, text(made.diagnostics)
    return sorted(link.name for link in made.robot.links)


def test_two_robots_of_two_packages_share_parts_of_a_third(workspace: Path) -> None:
    for name in ("cart", "rover"):
        made = compile_robot(robot_of(workspace, name))
        assert links(made) == ["base", "left_wheel", "rear_caster"]
        assert "0.051" in made.artifacts[0].text
        read = {path.name for path in made.inputs}
        assert read == {"robot.yaml", "wheels.yaml", "casters.yaml", "tyre.yaml"}


@pytest.mark.parametrize(
    "include",
    [
        "{file: parts/wheels.yaml, package: acme_parts}",
        "{file: package://acme_parts/parts/wheels.yaml, args: {tread: 1 mm}}",
        "{file: parts/wheels.yaml, package: acme_parts, packages: {acme_parts: ../../../acme_parts}}",
    ],
)
def test_an_include_names_a_package_in_any_form(workspace: Path, include: str) -> None:
    path = robot_of(workspace, "cart")
    write(path, ROBOT.replace("NAME", "cart").replace("INCLUDE", include))
    assert links(compile_robot(path)) == ["base", "left_wheel", "rear_caster"]


@pytest.mark.parametrize("linked", [False, True], ids=["copied", "symlink-install"])
def test_installed_descriptions_find_installed_parts(
    workspace: Path, monkeypatch: pytest.MonkeyPatch, linked: bool
) -> None:
    """An install space has each package in a prefix of its own; with --symlink-install each file is a link."""
    prefixes = []
    write(
        robot_of(workspace, "cart").parent / "own.yaml",
        "links: {top: {}}\njoints: {t: {type: fixed, parent: base, child: top}}",
    )
    path = robot_of(workspace, "cart")
    path.write_text(path.read_text("utf-8").replace("[package", "[own.yaml, package"), "utf-8")
    for source in workspace.iterdir():
        prefix = workspace.parent / "install" / source.name
        for file in filter(Path.is_file, source.rglob("*")):
            there = prefix / "share" / source.name / file.relative_to(source)
            there.parent.mkdir(parents=True, exist_ok=True)
            there.symlink_to(file) if linked else there.write_bytes(file.read_bytes())
        prefixes.append(str(prefix))
    monkeypatch.setenv("AMENT_PREFIX_PATH", ":".join(prefixes))
    made = compile_robot(
        workspace.parent / "install/cart_description/share/cart_description/descriptions/cart/robot.yaml"
    )
    assert links(made) == ["base", "left_wheel", "rear_caster", "top"]
    read = {path for path in made.inputs if path.name == "wheels.yaml"}
    assert {"install" in path.absolute().parts for path in read} == {True}


def test_arguments_of_shared_parts_are_those_of_the_robot(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["args", str(robot_of(workspace, "cart")), "--format", "json"]) == 0
    ((robot,),) = (json.loads(capsys.readouterr().out)["result"],)
    assert [(one["name"], one["default"]) for one in robot["arguments"]] == [("tread", "1 mm")]
    assert main(["check", str(robot_of(workspace, "cart")), "--every-argument"]) == 0


def test_the_command_line_says_where_a_package_is(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = workspace.parent / "elsewhere"
    (workspace / "acme_parts").rename(other)
    (other / "package.xml").unlink()
    path = str(robot_of(workspace, "cart"))
    for command in (["all"], ["args"], ["check", "--every-argument"]):
        assert main([*command, path]) == 1
        assert 'the package "acme_parts" is not found' in capsys.readouterr().err
        assert main([*command, path, "--package", f"acme_parts={other}"]) == 0, capsys.readouterr().err
        capsys.readouterr()


def test_a_change_of_shared_parts_is_seen(workspace: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(robot_of(workspace, "cart"))
    assert main(["all", path]) == 0
    write(workspace / "acme_parts/config/tyre.yaml", "radius: 60 mm\n")
    capsys.readouterr()
    assert main(["all", path]) == 0
    assert "written: robot.urdf" in capsys.readouterr().out

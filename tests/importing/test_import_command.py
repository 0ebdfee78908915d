"""rosorin-compile import: what it writes, says and refuses."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.importing import round_trip
from support.paths import IMPORTED, ROOT

pytestmark = pytest.mark.slow

ARM = IMPORTED / "little_arm" / "little_arm.urdf"
EXPECTED = ARM.parent / "expected"
ROVER = IMPORTED / "rover" / "rover.urdf"


@pytest.fixture
def here(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path_factory.mktemp("cache")))
    shutil.copy(ARM, tmp_path / "little_arm.urdf")
    return tmp_path


def run(*words: str) -> int:
    """Run the command; return its exit code."""
    return main(["import", *words])


def files(folder: Path) -> dict[str, str]:
    paths = [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".imported"]
    return {str(path.relative_to(folder)): path.read_text("utf-8") for path in paths}


def test_a_robot_becomes_a_description(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("little_arm.urdf") == 0
    assert "no mjcf among its outputs: joint " in capsys.readouterr().out
    assert files(here / "descriptions" / "little_arm") == files(EXPECTED)
    assert [path.name for path in (here / "descriptions").iterdir()] == ["little_arm"]


def test_the_schema_beside_it_is_named(here: Path) -> None:
    assert main(["init", "scout"]) == 0
    assert run(str(ROVER), "--no-parts") == 0
    for text in files(here / "descriptions" / "rover").values():
        assert text.startswith("# yaml-language-server: $schema=../.schema/rosorin-compile.schema.json\n")


def test_a_folder_that_is_taken_is_refused(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    home = here / "descriptions" / "little_arm"
    home.mkdir(parents=True)
    (home / "notes.txt").write_text("mine", "utf-8")
    assert run("little_arm.urdf") == 2
    message = "descriptions/little_arm is not empty; name a new folder with -o, or write into this one with --force"
    assert capsys.readouterr().err == f"rosorin-compile: {message}\n"
    assert files(home) == {"notes.txt": "mine"}


def test_force_deletes_nothing(here: Path) -> None:
    home = here / "descriptions" / "little_arm"
    (home / "old").mkdir(parents=True)
    (home / "notes.txt").write_text("mine", "utf-8")
    (home / "old" / "links.yaml").write_text("links: {}\n", "utf-8")
    (home / "robot.yaml").write_text("robot: before\n", "utf-8")
    assert run("little_arm.urdf", "--force") == 0
    kept = {"robot.yaml.kept": "robot: before\n"}  # nothing says that an import wrote it
    assert files(home) == {**files(EXPECTED), "notes.txt": "mine", "old/links.yaml": "links: {}\n", **kept}


def broken(here: Path, old: str, new: str) -> str:
    """Write the arm with a text replaced; return the file name."""
    text = ARM.read_text("utf-8")
    assert text.count(old) >= 1
    (here / "broken.urdf").write_text(text.replace(old, new), "utf-8")
    return "broken.urdf"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("</robot>", ""),
        ('<child link="tool0"/>', '<child link="tool1"/>'),
        ('effort="30"', 'effort="much"'),
        ('type="fixed"', 'type="glued"'),
        ("<?xml version", "<!DOCTYPE x []><?xml version"),
    ],
)
def test_broken_sources_write_nothing(here: Path, capsys: pytest.CaptureFixture[str], old: str, new: str) -> None:
    assert run(broken(here, old, new), "-o", "a/b/c") == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("broken.urdf:")
    assert "error[" in said.err
    assert said.err.splitlines()[-1].endswith("nothing written")
    assert sorted(path.name for path in here.iterdir()) == ["broken.urdf", "little_arm.urdf"]


def test_what_is_not_carried_is_said_and_strict_refuses(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = broken(here, '<mass value="2.5"/>', '<mass value="2.5" colour="red"/>')
    assert run(name, "-o", "strict", "--strict") == 1
    said = capsys.readouterr().err
    assert "error[import-cannot-carry]" in said
    assert said.endswith("broken.urdf: 1 error, nothing written\n")
    assert not (here / "strict").exists()
    assert run(name, "-o", "easy") == 0
    said_too = capsys.readouterr()
    assert "warning[import-cannot-carry]" in said_too.err
    assert "\nnot carried over: 1, see the warning above\n" in said_too.out


def test_lenient_takes_more(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = broken(here, ' effort="30"', "")
    assert run(name, "-o", "x") == 1
    assert "--lenient" in capsys.readouterr().err
    assert run(name, "-o", "x", "--lenient") == 0
    assert compile_robot(here / "x" / "robot.yaml").robot is not None


def altered(old: str, new: str) -> Callable[..., Any]:
    """Return ``write`` with one thing in what it writes replaced: a fault of the writer."""
    right = round_trip.write

    def wrong(*words: Any) -> dict[str, str]:
        made = right(*words)
        assert any(old in text for text in made.values())
        return {name: text.replace(old, new) for name, text in made.items()}

    return wrong


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("upper: 2.5,", "upper: 2.6,", "elbow limit upper 2.5 -> 2.6 rad (+5.7 deg)"),
        ("mass: 2.5,", "mass: 2.6,", "base_link mass 2.5 -> 2.6 kg (+100.0 g)"),
        ("radius: 0.1,", "radius: 0.11,", "base_link collision: cylinder radius 0.1 -> 0.11 m (+10.0 mm)"),
        ("  tool0: {}\n", "  tool0: {}\n  more: {}\n", ""),
        ("Gazebo/Orange", "Gazebo/Blue", "robot element material Gazebo/Orange -> Gazebo/Blue"),
        ("visual/upper", "visual/lower", "upper_arm.dae -> package://little_arm/meshes/visual/lower_arm.dae"),
        ("material: orange", "rgba: [1, 1, 1, 1]", "base_link visual colour none -> 1 1 1 1"),
    ],
)
def test_a_description_of_another_robot_is_not_written(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, old: str, new: str, said: str
) -> None:
    monkeypatch.setattr(round_trip, "write", altered(old, new))
    assert run("little_arm.urdf") == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert said in told.err
    assert told.err.endswith("little_arm.urdf: 1 error, nothing written\n")
    assert "error[import-differs]: the description would not be the same robot\n" in told.err or not said
    assert [path.name for path in here.iterdir()] == ["little_arm.urdf"]


@pytest.mark.usefixtures("here")
def test_places_of_a_description_that_does_not_compile_are_those_of_its_folder(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(round_trip, "write", altered("upper: 2.5,", "upper: 2.5 mm,"))
    assert run("little_arm.urdf", "-o", "x") == 1
    assert "\nx/robot.yaml:" in capsys.readouterr().err


@pytest.mark.slow
def test_bytes_do_not_depend_on_the_machine(tmp_path: Path) -> None:
    made = []
    for number, (seed, language) in enumerate((("1", "C"), ("2", "C.UTF-8"))):
        folder = tmp_path / str(number)
        environment = {**os.environ, "PYTHONHASHSEED": seed, "LC_ALL": language, "TZ": f"UTC{number}"}
        command = [sys.executable, "-m", "rosorin_compile", "import", str(ROVER), "-o", str(folder / "rover")]
        folder.mkdir()
        subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
        made.append(files(folder / "rover"))
    assert made[0] == made[1] == files(ROVER.parent / "expected")


def test_xacro_is_imported_with_its_arguments(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    text = ARM.read_text("utf-8").replace(
        '<robot name="little_arm">',
        '<robot name="little_arm" xmlns:xacro="http://ros.org/wiki/xacro"><xacro:arg name="upper" default="2.5"/>',
    )
    (here / "arm.xacro").write_text(text.replace('upper="2.5"', 'upper="$(arg upper)"'), "utf-8")
    assert run("arm.xacro", "upper:=2.25", "-o", "one") == 0
    assert "warning[xacro-runs-code]" in capsys.readouterr().err
    assert "  upper: {type: number, default: 2.25}\n" in (here / "one" / "robot.yaml").read_text("utf-8")
    assert 'upper: "${upper}"' in (here / "one" / "robot.yaml").read_text("utf-8")
    assert run("arm.xacro", "-a", "upper=2", "-o", "two", "--flat") == 0
    assert "upper: 2," in (here / "two" / "robot.yaml").read_text("utf-8")


def test_what_is_accepted_is_said(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(broken(here, '<axis xyz="0 1 0"/>', '<axis xyz="0 2 0"/>'), "-o", "x") == 0
    assert "\naccepted: axis-not-unit\n" in capsys.readouterr().out
    assert "rule: axis-not-unit, of: [elbow]" in (here / "x" / "robot.yaml").read_text("utf-8")


@pytest.mark.landing("fuzz", "turtlebot3_burger")
@pytest.mark.parametrize("name", ["turtlebot3_burger", "unitree_a1", "ur5e"])
def test_examples_come_in(here: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro")
    assert run(str(ROOT / "examples" / name / "xacro" / "robot.xacro")) == 0
    assert "the compiled URDF is the same robot\n" in capsys.readouterr().out
    made = compile_robot(here / "descriptions" / name / "robot.yaml")
    assert made.robot is not None
    assert {artifact.backend for artifact in made.artifacts} == {"urdf", "mjcf", "frames", "frames_picture"}


ODD_NAMES = (
    *("on", "no", "1", "1.5", "null", "~", "2020-01-01", "12:30", "0x1F", "12 mm", "Link 1", "ns/base", "a:b", "a: b"),
    *("x #y", "#x", "-5", "- a", "[a]", "{a}", "a, b", "*a", "!a", "|", "%a", "@a", "`a", "=", "<<"),
    *("${pi}", "$${pi}", "$", "a${b", "C:\\a", "Käfer", "机器人", "🤖", "for", "if", "robot", "x" * 900),
)


def test_odd_names_and_texts_survive(here: Path) -> None:
    names = [name for name in ODD_NAMES if "<" not in name]
    links = "".join(f'<link name="{name}"/>' for name in names)
    joints = "".join(
        f'<joint name="{child}" type="fixed"><parent link="on"/><child link="{child}"/></joint>' for child in names[1:]
    )
    more = '<gazebo reference="on"><a>${pi} $${pi} $(find x)</a>\n\t<b c=\'"\'>#: é\U0001f916</b>\n</gazebo>'
    (here / "odd.urdf").write_text(f'<robot name="${{x}}">{links}{joints}{more}</robot>', "utf-8")
    assert run("odd.urdf", "-o", "odd") == 0
    robot = compile_robot(here / "odd" / "robot.yaml").robot
    assert robot is not None
    assert robot.name == "${x}"
    assert {link.name for link in robot.links} == set(names)
    assert [joint.name for joint in robot.joints] == names[1:]
    assert robot.urdf_elements == (more,)

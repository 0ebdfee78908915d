"""The project is found from any folder inside it, and what is inside it may be included."""

import json
import shutil
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main

ROVER = """
robot: %s
include: [../common/base.yaml]
links: {laser: {}}
joints: {laser_joint: {type: fixed, parent: base_link, child: laser, xyz: [0, 0, "${height}"]}}
outputs: {urdf: {file: rover.urdf}}
"""
BASE = "links: {base_link: {}}\nlet: {height: 20 cm}\n"
Shown = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in ("rover", "loader"):
        (tmp_path / "descriptions" / name).mkdir(parents=True)
        (tmp_path / "descriptions" / name / "robot.yaml").write_text(ROVER % name)
    (tmp_path / "descriptions" / "common").mkdir()
    (tmp_path / "descriptions" / "common" / "base.yaml").write_text(BASE)
    (tmp_path / "src" / "deep").mkdir(parents=True)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", "off")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("folder", [".", "src/deep", "descriptions", "descriptions/common", "descriptions/rover"])
def test_all_from_every_folder(folder: str, project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    monkeypatch.chdir(project / folder)
    assert main(["all"]) == 0
    assert main(["check", "loader"]) == 0
    assert sorted(path.name for path in (project / "outputs").iterdir()) == ["loader", "rover"]
    assert str(project) not in "".join(capsys.readouterr())


def test_in_the_folder_of_a_description_it_is_meant(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown
) -> None:
    assert main(["explain", "laser", "z"]) == 2
    monkeypatch.chdir(project / "descriptions" / "rover")
    assert main(["explain", "laser", "z"]) == 0
    assert "z  0.2 m  robot.yaml:5:82" in capsys.readouterr().out


@pytest.mark.parametrize(("inside", "around"), [(".", True), ("xacro/deep", False)])
def test_in_the_folder_of_a_robot_of_its_own_it_is_meant(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown, inside: str, around: bool
) -> None:
    """An example within a bigger project, or a robot that was taken out of one."""
    folder = project / "examples" / "scout"
    (folder / inside).mkdir(parents=True)
    (folder / "robot.yaml").write_text(
        "robot: scout\nlinks: {base_link: {}, mast: {}}\njoints: "
        "{up: {type: fixed, parent: base_link, child: mast, xyz: [0, 0, 1]}}\n"
    )
    if not around:
        shutil.rmtree(project / "descriptions")
    monkeypatch.chdir(folder / inside)
    for words in (
        ["frames"],
        ["view", "--html", str(project / "scout.html")],
        ["tf", "base_link", "mast"],
        ["explain", "mast"],
    ):
        assert main(words) == 0, words
    shown = capsys.readouterr().out
    assert "scout: " in shown
    assert "mast" in shown
    assert "rover" not in shown


def test_messages_name_files_as_seen_from_here(project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown) -> None:
    (project / "descriptions" / "common" / "base.yaml").write_text("links: {base: {}}\nlet: {height: 20 cm}\n")
    monkeypatch.chdir(project / "src")
    assert main(["all", "rover", "--format", "json"]) == 1
    files = {diagnostic["file"] for diagnostic in json.loads(capsys.readouterr().out)["diagnostics"]}
    assert files == {"../descriptions/rover/robot.yaml"}


def test_what_is_outside_is_refused(project: Path, capsys: Shown) -> None:
    description = project / "descriptions" / "rover" / "robot.yaml"
    description.write_text(ROVER.replace("../common/base.yaml", "../../../base.yaml") % "rover")
    (project.parent / "base.yaml").write_text(BASE)
    assert main(["all", "rover"]) == 1
    said = "../../../base.yaml is outside the project, the folder that has descriptions/"
    assert said in capsys.readouterr().err


def test_a_folder_that_everybody_may_write_to_is_no_project(
    project: Path, monkeypatch: pytest.MonkeyPatch, capsys: Shown
) -> None:
    project.chmod(0o777)
    monkeypatch.chdir(project / "src")
    assert main(["all"]) == 2
    assert "there is no descriptions/*/robot.yaml here or above" in capsys.readouterr().err


def test_where_there_is_no_robot_it_is_said_how_to_get_one(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, capsys: Shown
) -> None:
    monkeypatch.chdir(tmp_path_factory.mktemp("empty"))
    for words in (["all"], ["check"], ["print", "urdf"], ["view", "--no-open"]):
        assert main(words) == 2
        told = capsys.readouterr().err
        assert "there is no descriptions/*/robot.yaml here or above" in told
        assert "rosorin-compile init NAME creates one" in told
        assert "rosorin-compile import FILE converts a URDF" in told


def test_an_install_space_of_links(project: Path, capsys: Shown) -> None:
    """``colcon build --symlink-install`` makes folders of links to the files of the source."""
    rover = project / "descriptions" / "rover"
    with (rover / "robot.yaml").open("a") as file:
        file.write("let: {loaded: \"${load('../common/table.yaml').a}\"}\nsensors: {}\n")
    text = (rover / "robot.yaml").read_text()
    (rover / "robot.yaml").write_text(
        text.replace("outputs: {", "outputs: {note: {file: note.txt, template: note.jinja}, ").replace(
            "child: laser,", 'child: laser, rpy: [0, 0, "${loaded}"],'
        )
    )
    (rover / "note.jinja").write_text("{{ robot.name }}")
    (project / "descriptions" / "common" / "table.yaml").write_text("a: 1\n")
    share = project.parent / f"{project.name} installed" / "share" / "rover"
    for path in sorted((project / "descriptions").rglob("*")):
        if path.is_file():
            link = share / path.relative_to(project)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.symlink_to(path)
    installed = share / "descriptions" / "rover"
    assert main(["all", "rover"]) == main(["check", str(installed), "-o", str(project / "outputs/rover")]) == 0
    # What a link in it leads to stands in the project, and nothing else.
    (project.parent / f"{project.name} secret").write_text("a: 1\n")
    table = share / "descriptions" / "common" / "table.yaml"
    table.unlink()
    table.symlink_to(project.parent / f"{project.name} secret")
    capsys.readouterr()
    assert main(["check", str(installed)]) == 1
    assert "../common/table.yaml is outside the project" in capsys.readouterr().err

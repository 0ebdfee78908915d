"""``all -o FOLDER``: the artifacts of one robot in a folder itself, for build systems."""

from pathlib import Path

from rosorin_compile.cli.main import main
from support.commands import Shown, ask

LAMP = "robot: lamp\nlinks: {base_link: {}}\noutputs: {urdf: {file: lamp.urdf}, frames: {file: frames.md}}\n"
PROJECT = {"descriptions/lamp/robot.yaml": LAMP, "descriptions/other/robot.yaml": LAMP}


def names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_the_folder_is_that_of_the_artifacts(project: Path, capsys: Shown) -> None:
    assert "2 artifacts in made/here, written: frames.md, lamp.urdf" in ask(capsys, "all", "lamp", "-o", "made/here")
    assert names(project / "made") == ["here/frames.md", "here/lamp.urdf"]
    assert "unchanged" in ask(capsys, "all", "lamp", "-o", "made/here")
    assert "up to date in made/here" in ask(capsys, "all", "lamp", "-o", "made/here", "-n")
    assert not (project / "outputs").exists()


def test_only_and_a_depfile(project: Path) -> None:
    assert main(["all", "lamp", "-o", "made", "--only", "urdf", "--depfile", "made.d"]) == 0
    assert names(project / "made") == ["lamp.urdf"]
    assert (project / "made.d").read_text("utf-8").startswith("made/lamp.urdf:")

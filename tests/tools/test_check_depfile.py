"""check --depfile: a build learns what was compiled, and what it was compared with."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown, edit

PROJECT = {
    "descriptions/lamp/robot.yaml": "robot: lamp\ninclude: [more.yaml]\noutputs: {urdf: {file: lamp.urdf}}\n",
    "descriptions/lamp/more.yaml": "links: {base_link: {}}\n",
    "descriptions/other/robot.yaml": "robot: other\nlinks: {base_link: {}}\noutputs: {urdf: {file: o.urdf}}\n",
}
CHECK = ("check", "lamp", "--depfile", "lamp.d", "--depfile-target", "stamp")


def test_what_was_read_and_compared(project: Path) -> None:
    assert main(["all", "lamp"]) == 0
    assert main(list(CHECK)) == 0
    names = ["descriptions/lamp/robot.yaml", "descriptions/lamp/more.yaml", "outputs/lamp/lamp.urdf"]
    assert (project / "lamp.d").read_text() == " \\\n  ".join(["stamp:", *names]) + "\n"


def test_what_differs_is_not_done(project: Path) -> None:
    assert main(["all", "lamp"]) == 0
    edit(project / "descriptions/lamp/more.yaml", "base_link", "base")
    assert main(list(CHECK)) == 1
    assert not (project / "lamp.d").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (CHECK[:4], "a depfile needs a target: --depfile-target NAME"),
        (("check", "lamp", *CHECK[4:]), "--depfile-target goes with --depfile FILE"),
        (("check", *CHECK[2:]), "a depfile is about one robot, and there are several: lamp, other; name one"),
        ((*CHECK, "--every-argument"), "it does not go with --every-argument"),
    ],
)
def test_what_does_not_go_together(project: Path, words: tuple[str, ...], said: str, capsys: Shown) -> None:
    assert main(list(words)) == 2
    assert said in capsys.readouterr().err
    assert not (project / "lamp.d").exists()


def test_a_folder_that_is_not_there_is_named(project: Path, capsys: Shown) -> None:
    assert main([*CHECK, "-o", "golden/lamp"]) == 1
    way = "rosorin-compile all with the same -o and arguments writes it"
    assert f"lamp: there is no folder golden/lamp; {way}\n" in capsys.readouterr().err
    assert main(["check", "lamp"]) == 1
    assert "there is no folder" not in capsys.readouterr().err
    assert not (project / "lamp.d").exists()

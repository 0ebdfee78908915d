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

"""``NAME:=VALUE`` sets an argument wherever ``-a`` does, in every command."""

from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import pytest

from rosorin_compile.cli import watch
from rosorin_compile.cli.main import main
from support.commands import Shown, write_files
from support.paths import DATA

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

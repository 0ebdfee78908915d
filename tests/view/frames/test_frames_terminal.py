"""The tree of frames in a terminal: colours, letters, columns, and terminals that have few of each."""

import io
import re
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model.frame_tree import Row, lines
from rosorin_compile.viewer.frames import Look, text_width, tree
from support.robots import copy_of_rosorin


@pytest.fixture(autouse=True)
def rosorin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    copy_of_rosorin(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return tmp_path


class Terminal(io.TextIOWrapper):
    def __init__(self, encoding: str, people: bool = True) -> None:
        super().__init__(io.BytesIO(), encoding)
        self.people = people

    def isatty(self) -> bool:
        return self.people

    def said(self) -> str:
        self.flush()
        assert isinstance(self.buffer, io.BytesIO)
        return self.buffer.getvalue().decode(self.encoding)


def seen(monkeypatch: pytest.MonkeyPatch, terminal: Terminal, *words: str) -> str:
    with monkeypatch.context() as patch:
        patch.setattr(sys, "stdout", terminal)
        assert main(["frames", *words]) == 0
    return terminal.said()


def test_colours_for_people_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    coloured = seen(monkeypatch, Terminal("utf-8"))
    assert "\033[1mslam is on\033[0m" in coloured
    colours = {line.split("\033[")[1].split("m")[0] for line in coloured.splitlines() if "robot_state" in line}
    assert len(colours) == 1
    monkeypatch.setenv("NO_COLOR", "1")
    plain = seen(monkeypatch, Terminal("utf-8"))
    assert "\033" not in plain
    monkeypatch.delenv("NO_COLOR")
    assert seen(monkeypatch, Terminal("utf-8", people=False)) == plain
    assert re.sub("\033\\[\\d+m", "", coloured) == plain


def test_plain_letters_where_the_terminal_has_no_others(monkeypatch: pytest.MonkeyPatch) -> None:
    for encoding in ("ascii", "latin-1"):
        said = seen(monkeypatch, Terminal(encoding, people=False))
        assert said == seen(monkeypatch, Terminal("utf-8", people=False), "--ascii")
        assert said.isascii()
    assert "`-- odom" in said
    assert "|.. base_footprint (above)" in said
    assert "|   `-- link2" in said


def test_the_columns_stand_below_each_other_for_wide_letters() -> None:
    rows = [Row("base", name, "node", "", "/tf", "", "base") for name in ("漢字", "é", "plain", "e\u0301")]
    said = tree(lines(rows, []), Look())
    assert len({text_width(line[: line.index("node")]) for line in said[2:]}) == 1


def columns(text: str) -> list[str]:
    return re.split("  +", next(line for line in text.splitlines() if line.startswith("frame")))


@pytest.mark.parametrize(
    ("width", "heads", "told"),
    [
        (140, ["frame", "published by", "topic", "joint"], ""),
        (110, ["frame", "published by", "topic"], "(no room for: joint)"),
        (80, ["frame", "published by"], "(no room for: joint, topic)"),
        (20, ["frame", "published by"], "(no room for: joint, topic)"),
    ],
)
def test_a_narrow_terminal_gets_fewer_columns(
    monkeypatch: pytest.MonkeyPatch, width: int, heads: list[str], told: str
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("NO_COLOR", "1")
    said = seen(monkeypatch, Terminal("utf-8"), "--mode", "slam")
    assert columns(said) == heads
    assert [line for line in said.splitlines() if line.startswith("(no room")] == [told] * bool(told)
    assert any(line.endswith("when slam") for line in said.splitlines()), "a condition is never left out"
    tree_of_it = said.partition("\n(")[0].splitlines()
    assert width <= 80 or max(map(text_width, tree_of_it)) <= width
    assert columns(seen(monkeypatch, Terminal("utf-8", people=False), "--mode", "slam"))[:4] == [
        "frame",
        "published by",
        "topic",
        "joint",
    ]

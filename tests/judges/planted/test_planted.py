"""Each planted change of an artifact is told by ``check``, and names the right thing; what it told is as committed.

Of the changes of each kind a landing takes one in ``AT_A_LANDING`` of each artifact, from its first; a tier takes all.
"""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

from judges.planted.planting import Planted, drawn, one_of_each, planted, planted_in_lists
from rosorin_compile.compare.artifacts import disagreements
from rosorin_compile.compare.golden_check import compare
from rosorin_compile.formats import Artifact
from rosorin_compile.model import Robot
from support.paths import ROOT, ROSORIN
from support.robots import compiled

HERE = Path(__file__).parent
ROBOTS = [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]
EVERY_WORD = sorted((ROOT / "tests/judges/goldens/every_word").glob("*.yaml"))
EACH = 15  # of an artifact
AT_A_LANDING = 30
SEED = 20261126
_LONGEST = 150


class Told(NamedTuple):
    """A planted change of a file, the lines that ``check`` says of it, and the first word of what is kept of it.

    ``by`` is "proof" where the proof that artifacts agree with the model sees the change, too.
    """

    file: str
    change: Planted
    lines: tuple[str, ...]
    by: str = ""

    @property
    def is_named(self) -> bool:
        """Whether one of the lines holds a name that stands around the place."""
        spread = "default" in self.change.group[:-1]
        return any(spread or name in line for name in self.change.named for line in self.lines)

    @property
    def row(self) -> str:
        """The change and the first line that was told, as they are kept."""
        said = self.lines[0][:_LONGEST] if self.lines else "nothing"
        return f"{self.by}{self.file} {self.change.where} => {said}"


def some(path: Path) -> list[Told]:
    """Return what ``check`` reports of some changes of each artifact of a robot."""
    told: list[Told] = []
    robot, artifacts = _compiled(path)
    for artifact in artifacts:
        changes = drawn(list(planted(artifact.text, artifact.file)), EACH, SEED)
        told += [_told(robot, artifact, change) for change in changes]
    return told


@cache
def of_each_kind(step: int = 1) -> list[Told]:
    """Return what is told of a change of each kind of place that a format has, and whether a proof sees it.

    With a ``step`` of 10 it is the first, the eleventh and so on of each artifact.
    """
    told: list[Told] = []
    had: dict[str, set[tuple[str, ...]]] = {}
    every_word = [path for path in EVERY_WORD if "robot:" in path.read_text("utf-8")]
    for path in (*every_word, *reversed(ROBOTS)):
        robot, artifacts = _compiled(path)
        for artifact in artifacts:
            every = [*planted(artifact.text, artifact.file), *planted_in_lists(artifact.text, artifact.file)]
            for change in one_of_each(every, had.setdefault(artifact.backend, set()), SEED)[::step]:
                sees = any(True for _ in disagreements(robot, replace(artifact, text=change.text)))
                told.append(_told(robot, artifact, change)._replace(by="proof: " if sees else "check: "))
    return told


def _compiled(description: Path) -> tuple[Robot, Sequence[Artifact]]:
    made = compiled(description)
    assert made.robot is not None
    return made.robot, made.artifacts


def _told(robot: Robot, artifact: Artifact, change: Planted) -> Told:
    """Return what ``check`` says of a change of a committed artifact."""
    found = compare(robot, [artifact], {artifact.file: change.text.encode()})
    said = [one.line() for one in found.changes] or [text.remark for text in found.texts if text.remark]
    # What nobody reads back is shown line by line.
    shown = [line for text in found.texts for line in text.lines if line[0] in "-+"]
    return Told(artifact.file, change, tuple(said or shown[2:]))


def rows(told: Sequence[Told]) -> list[str]:
    """Return the lines of a list."""
    return [one.row for one in told]


def missed(told: Sequence[Told]) -> list[str]:
    """Return the changes of which no line names the right thing."""
    return [f"{one.row} (one of {', '.join(one.change.named[:4])})" for one in told if not one.is_named]


def committed(name: str) -> list[str]:
    return (HERE / f"{name}.txt").read_text("utf-8").splitlines()


@pytest.mark.parametrize("path", ROBOTS, ids=lambda path: path.parent.name)
def test_check_reports_each_change_as_committed(path: Path) -> None:
    told = some(path)
    assert missed(told) == []
    expected = set(committed("told"))
    assert [row for row in rows(told) if row not in expected] == [], "python tests/renew.py planted"


@pytest.mark.tier("fuzz")
def test_check_reports_a_change_of_each_kind_as_committed() -> None:
    told = of_each_kind()
    assert missed(told) == []
    moved = [
        line for line in difflib.unified_diff(committed("each_kind"), rows(told), n=0, lineterm="") if line[0] in "-+"
    ]
    assert moved == [], "python tests/renew.py planted, and read the difference"


@pytest.mark.slow
def test_some_of_each_kind_are_told_as_committed() -> None:
    told = of_each_kind(AT_A_LANDING)
    assert missed(told) == []
    assert len(told) >= len(committed("each_kind")) / AT_A_LANDING
    rest = iter(committed("each_kind"))
    assert [row for row in rows(told) if row not in rest] == [], "python tests/renew.py planted"


if __name__ == "__main__":
    lists = {"told": [one for path in ROBOTS for one in some(path)], "each_kind": of_each_kind()}
    for each, told in lists.items():
        (HERE / f"{each}.txt").write_text("".join(f"{row}\n" for row in rows(told)), "utf-8")

"""Each planted change of an artifact is told by ``check``, and names the right thing; what it told is as committed."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from judges.planted.planting import Planted, drawn, planted
from rosorin_compile.meaning.golden import compare
from support.paths import ROOT, ROSORIN
from support.robots import compiled

HERE = Path(__file__).parent
ROBOTS = [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]
EACH = 15  # of an artifact
_LONGEST = 150


class Told(NamedTuple):
    """A planted change of a file, and the lines that ``check`` says of it."""

    file: str
    change: Planted
    lines: tuple[str, ...]

    @property
    def is_named(self) -> bool:
        """Whether one of the lines holds a name that stands around the place."""
        spread = "default" in self.change.group[:-1]
        return any(spread or name in line for name in self.change.named for line in self.lines)

    @property
    def row(self) -> str:
        """The change and the first line that was told, as they are kept."""
        said = self.lines[0][:_LONGEST] if self.lines else "nothing"
        return f"{self.file} {self.change.where} => {said}"


@cache
def told() -> list[Told]:
    """Return what is told of each change."""
    return [told for robot in ROBOTS for told in _of_robot(robot)]


def _of_robot(description: Path) -> Iterator[Told]:
    made = compiled(description)
    assert made.robot is not None
    for artifact in made.artifacts:
        for change in drawn(list(planted(artifact.text, artifact.file)), EACH, 20261126):
            found = compare(made.robot, [artifact], {artifact.file: change.text.encode()})
            said = [one.line() for one in found.changes] or [text.remark for text in found.texts if text.remark]
            # What nobody reads back is shown line by line.
            shown = [line for text in found.texts for line in text.lines if line[0] in "-+"]
            yield Told(artifact.file, change, tuple(said or shown[2:]))


def rows() -> list[str]:
    """Return the lines of ``told.txt``."""
    return [one.row for one in told()]


def test_each_change_is_told_and_names_the_right_thing() -> None:
    assert len(told()) >= 500
    missed = [f"{one.row} (one of {', '.join(one.change.named[:4])})" for one in told() if not one.is_named]
    assert missed == []


def test_what_is_told_is_as_committed() -> None:
    committed = (HERE / "told.txt").read_text("utf-8").splitlines()
    moved = [line for line in difflib.ndiff(committed, rows()) if line[0] in "-+"]
    assert moved == [], "python tests/renew.py planted, and read the difference"


if __name__ == "__main__":
    (HERE / "told.txt").write_text("".join(f"{row}\n" for row in rows()), "utf-8")

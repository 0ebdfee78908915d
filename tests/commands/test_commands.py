"""Command lines, and sessions of Python: what they print, in pages of the format of those in docs (test_docs.py).

A page is a list of scenarios, one a heading "## ". Each runs in an empty folder, with the files and commands above the
first heading before it. ``<!-- project: rosorin -->`` there copies that robot first, ``handy`` another, ``toy``
installs the plug-in examples/rosorin-toy. ``<!-- slow -->`` there makes a page slow. ``<!-- copy: FOLDER -->`` anywhere
copies what a folder of the repository contains; ``<!-- needs: mujoco -->`` anywhere skips a scenario where that module
is not installed. ``[exit N]`` ends the output of a command that fails. ``rosorin-compile ... < FILE`` and ``cd FOLDER``
are understood; the rest is bash.

    python tests/renew.py commands [PAGE...]

writes what the commands print now. It changes neither an exit code nor the rule and place of a diagnostic.
"""

import re
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import pytest

from rosorin_compile import __version__
from support.commands import HANDY, write_files
from support.pages import ELLIPSIS, PACKAGES, Ran, blocks, install, play_text
from support.paths import ROOT, TESTS
from support.robots import copy_of_rosorin

PAGES = sorted((TESTS / "commands").glob("*.md"))
NEEDS = re.compile(r"<!-- needs: (\w+) -->")
PROJECT = re.compile(r"<!-- project: (rosorin|handy|toy) -->")
COPY = re.compile(r"<!-- copy: (\S+) -->")
SLOW = "<!-- slow -->"
BY_HAND = re.compile(r"^\[exit \d+\]$|^\S*:\d+:\d+: (?:error|warning|note)\[[^]]+\]|^(?:error|warning|note)\[[^]]+\]")


@cache
def toy() -> tempfile.TemporaryDirectory[str]:
    """Return a folder where examples/rosorin-toy is installed."""
    folder = tempfile.TemporaryDirectory()
    shutil.copytree(ROOT / "examples" / "rosorin-toy", Path(folder.name, "rosorin-toy"))
    assert install("./rosorin-toy", Path(folder.name)) == ("", 0)
    return folder


def with_toy(folder: Path) -> None:
    shutil.copytree(Path(toy().name, PACKAGES), folder / PACKAGES, ignore=shutil.ignore_patterns("__pycache__"))


PROJECTS: dict[str, Callable[[Path], object]] = {
    "rosorin": copy_of_rosorin,
    "handy": partial(write_files, files=HANDY),
    "toy": with_toy,
}


class Scenario(NamedTuple):
    """A part of a page that is run alone: its title, the line where it begins (from 0), and its text after the head."""

    title: str
    start: int
    head: str
    text: str

    def play(self, folder: Path) -> list[Ran]:
        """Run the scenario in a new folder "here"; absolute paths in it are shown as /here."""
        folder /= "here"
        folder.mkdir()
        for name in PROJECT.findall(self.head):
            PROJECTS[name](folder)
        for name in COPY.findall(self.head + self.text):
            shutil.copytree(ROOT / name, folder, dirs_exist_ok=True)
        made = play_text(self.head + self.text, folder, testing=True)
        return [one._replace(printed=[self._plain(line, folder) for line in one.printed]) for one in made]

    @staticmethod
    def _plain(line: str, folder: Path) -> str:
        return line.replace(str(folder), "/here").replace(f'"version": "{__version__}"', '"version": "VERSION"')


def scenarios(page: Path) -> list[Scenario]:
    """Return the scenarios of a page."""
    lines = page.read_text("utf-8").splitlines(keepends=True)
    inside = {number for one in blocks("".join(lines)) for number in range(one.start, one.start + len(one.lines))}
    starts = [number for number, line in enumerate(lines) if line.startswith("## ") and number not in inside]
    head = "".join(lines[: starts[0]])
    ends = [*starts[1:], len(lines)]
    return [Scenario(lines[a][3:].strip(), a, head, "".join(lines[a:b])) for a, b in zip(starts, ends, strict=True)]


ALL = [(page, scenario) for page in PAGES for scenario in scenarios(page)]

CASES = [
    pytest.param(page, one, id=f"{page.stem}: {one.title}", marks=[pytest.mark.slow] if SLOW in one.head else [])
    for page, one in ALL
]


@pytest.mark.parametrize(("page", "scenario"), CASES)
def test_commands(page: Path, scenario: Scenario, tmp_path: Path) -> None:
    for module in NEEDS.findall(scenario.head + scenario.text):
        pytest.importorskip(module)
    for ran in scenario.play(tmp_path):
        shown, printed = "\n".join(ran.shown), "\n".join(ran.printed)
        assert ran.holds, f"{page.name}, {scenario.title}: $ {ran.command}\nshown:\n{shown}\nprinted:\n{printed}"


def by_hand(lines: list[str]) -> list[str]:
    return [found[0] for line in lines if (found := BY_HAND.match(line))]


def renew(page: Path) -> None:
    lines = page.read_text("utf-8").splitlines()
    for scenario in reversed(scenarios(page)):
        with tempfile.TemporaryDirectory() as folder:
            ran = scenario.play(Path(folder).resolve())
        offset = scenario.start - scenario.head.count("\n")
        for one in reversed([one for one in ran if one.start + offset > scenario.start]):
            if one.holds:
                continue
            if ELLIPSIS in one.shown or (one.shown and by_hand(one.shown) != by_hand(one.printed)):
                sys.stderr.write(f"{page.name}, {scenario.title}: $ {one.command}\n" + "\n".join(one.printed) + "\n")
                continue
            start = one.start + offset
            lines[start : start + len(one.shown)] = one.printed
    page.write_text("\n".join(lines) + "\n", "utf-8")


if __name__ == "__main__":
    for each in PAGES:
        if each.stem in (sys.argv[1:] or [each.stem]):
            renew(each)

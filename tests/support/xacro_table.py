"""The cases in tests/xacro: how they are read, and expanded by the real xacro.

A case is a folder for one feature of xacro. Its files:

    robot.xacro   how it is said there; the real xacro expands it
    robot.yaml    how the same robot is said here
    why.md        why it is not carried over, and what to write instead; the other two may be there to show it

The case begins with a title, "# AREA: FEATURE", in robot.yaml, or in why.md if there is one. In robot.yaml comments
follow: remarks for the page, and

    # args: NAME=VALUE                                   given to both
    # env: NAME=VALUE                                    environment variables that xacro reads
    # xacro: accepts | refuses: WORDS OF ITS MESSAGE     how xacro takes robot.xacro, where robot.yaml is refused
    # expect: LINE:COLUMN: SEVERITY[RULE]: MESSAGE       what is said of robot.yaml, as in tests/bad
    #   help: HELP
    #   related: LINE:COLUMN: MESSAGE

Lines between "show" and "end", both comments of their own, are what the page shows (see xacro_page).
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import sys
from collections.abc import Iterator
from itertools import takewhile
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple
from unittest.mock import patch

import yaml

from support.paths import XACRO

NAMES = XACRO / "names.yaml"

TITLE = re.compile(r"# ([^:]+): (.+)")


class Case(NamedTuple):
    """One feature: where it is, its title, the remarks of the page, and what its comments say."""

    folder: Path
    area: str
    feature: str
    remarks: str
    arguments: dict[str, str]
    environment: dict[str, str]
    xacro: str
    expected: tuple[str, ...]
    why: str

    @property
    def name(self) -> str:
        return self.folder.name

    def has(self, name: str) -> bool:
        return (self.folder / name).is_file()


def cases() -> list[Case]:
    """Return all cases in the order of their folders."""
    return [read(folder) for folder in sorted(XACRO.iterdir()) if folder.is_dir() and folder.name[:2].isdigit()]


def read(folder: Path) -> Case:
    """Return the case of a folder."""
    comments = _comments(folder / "robot.yaml")
    why = (folder / "why.md").read_text("utf-8").splitlines() if (folder / "why.md").is_file() else []
    title = TITLE.fullmatch(why[0] if why else f"# {comments.pop(0)}")
    assert title, f"{folder.name} begins with no title"
    said = [line for line in comments if line.startswith(("args: ", "env: ", "xacro: ", "expect: ", "  "))]
    remarks = " ".join(line for line in comments if line not in said)
    told = tuple(f"# {line}" for line in said if line.startswith(("expect: ", "  ")))
    xacro = next((line.removeprefix("xacro: ") for line in said if line.startswith("xacro: ")), "")
    body = "\n".join(why[1:]).strip()
    return Case(folder, title[1], title[2], remarks, _pairs(said, "args: "), _pairs(said, "env: "), xacro, told, body)


def _comments(path: Path) -> list[str]:
    lines = path.read_text("utf-8").splitlines() if path.is_file() else []
    return [line[2:] for line in takewhile(lambda line: line.startswith("#"), lines)]


def _pairs(lines: list[str], start: str) -> dict[str, str]:
    words = [word for line in lines if line.startswith(start) for word in line.removeprefix(start).split()]
    return dict(word.split("=", 1) for word in words)


def expand(case: Case) -> str:
    """Return what the real xacro makes of a case. Raises what xacro raises."""
    from xacro import process_file

    with _packages(case.folder / "site"), patch.dict(os.environ, case.environment), _in(case.folder):
        noise = io.StringIO()
        with contextlib.redirect_stderr(noise):
            return str(process_file("robot.xacro", mappings=dict(case.arguments)).toxml())


@contextlib.contextmanager
def _in(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


@contextlib.contextmanager
def _packages(folder: Path) -> Iterator[None]:
    """Let Python find the packages in a folder, and xacro's $(find), which asks ament for them, as well."""
    ament, packages = ModuleType("ament_index_python"), ModuleType("ament_index_python.packages")
    packages.get_package_share_directory = lambda name: str(folder / name)  # type: ignore[attr-defined]
    fakes = {"ament_index_python": ament, "ament_index_python.packages": packages}
    with patch.dict(sys.modules, fakes), patch.object(sys, "path", [*sys.path, str(folder)]):
        yield


@contextlib.contextmanager
def ready(case: Case) -> Iterator[None]:
    """Be in the folder of a case, with its packages in reach."""
    site = case.folder / "site"
    with _packages(site), patch.dict(os.environ, {"ROS_PACKAGE_PATH": str(site)}), _in(case.folder):
        yield


class Name(NamedTuple):
    """A name of xacro: how it is used there, how the same is said here, or the case or the reason instead."""

    space: str
    name: str
    theirs: str
    ours: str
    case: str
    why: str


def names() -> list[Name]:
    """Return the names that xacro has in expressions, and what becomes of them."""
    table = yaml.safe_load(NAMES.read_text("utf-8"))
    return [_name(space, name, entry) for space, entries in table.items() for name, entry in entries.items()]


def _name(space: str, name: str, entry: Any) -> Name:
    if isinstance(entry, dict):
        return Name(space, name, "", "", entry.get("case", ""), entry.get("why", ""))
    theirs, ours = entry if isinstance(entry, list) else (entry, entry)
    return Name(space, name, str(theirs), str(ours), "", "")

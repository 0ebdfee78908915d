"""Checks by name: ``check physics ROBOT`` is the check "physics", and ``check ROBOT`` compares a robot.

The name of a built-in check comes before a robot of that name, which is reached by its path. A robot of the project
comes before a check of a plug-in, which is reached as DISTRIBUTION:NAME.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from rosorin_compile.source.project import ROOT_FILE, Description, NoDescription, all_here

from .registry import check, names, whose
from .table import CHECK, is_own

Resolved = tuple[str, click.Command, list[str]]


def resolve(command: click.Command, words: list[str]) -> Resolved:
    """Return the check that the words after ``check`` name, or ``check`` itself, with the words that are left."""
    at = _first_word(command, words, 0)
    if at is None:
        return CHECK, command, words
    name = words[at]
    if not is_own(name, "checks"):
        distribution = whose("checks", name)
        if distribution and name in {path.parent.name for path in all_here()}:
            way = f"rosorin-compile {CHECK} {distribution}:{name}"
            _report(f'"{name}" is a robot here; the check of that name of {distribution}: {way}')
            return CHECK, command, words
    found = check(name)
    if found is None:
        _report_mistake(command, words, at)
        return CHECK, command, words
    if is_own(name, "checks"):
        _report_robot(name)
    return f"{CHECK} {name}", found, words[:at] + words[at + 1 :]


def _first_word(command: click.Command, words: Sequence[str], begin: int) -> int | None:
    """Return the index of the first word that is no option and no value of one, or None if there is none before --."""
    takes_value = {
        name for one in command.params if isinstance(one, click.Option) and not one.is_flag for name in one.opts
    }
    before = ""
    for at in range(begin, len(words)):
        if words[at] == "--":
            return None
        if not words[at].startswith("-") and before not in takes_value:
            return at
        before = words[at] if words[at].startswith("-") else ""
    return None


def _report_mistake(command: click.Command, words: Sequence[str], at: int) -> None:
    """Report a check that is named after the robot, or a misspelt one."""
    from rosorin_compile.source.diagnostics import nearest

    name = words[at]
    later: int | None = at
    while later is not None:
        later = _first_word(command, words, later + 1)
        word = "" if later is None else words[later]
        if word and is_own(word, "checks") and _robot(word) is None and not Path(word).exists():
            _report(f'"{word}" is a check, and stands before the robot: {CHECK} {word} ROBOT')
            return
    close = nearest(name, names("checks"))
    if close is not None and close != name and _robot(name) is None:
        _report(f'"{name}" is no check; did you mean "{close}"?')


def _report_robot(name: str) -> None:
    """Report how a robot is reached that has the name of a check."""
    robot = _robot(name)
    if robot is None:
        return
    path = robot.path.parent if robot.path.name == ROOT_FILE else robot.path
    shown = f"./{path}" if path == Path(name) else str(path)
    _report(f'"{name}" is a check; the robot of that name: rosorin-compile {CHECK} {shown}')


def _robot(name: str) -> Description | None:
    try:
        return Description.find([name])[0]
    except NoDescription:
        return None


def _report(message: str) -> None:
    sys.stderr.write(f"rosorin-compile: {message}\n")

"""Which command or check a line calls: ``check physics ROBOT`` is a check.

The name of a check stands first. One of ours comes before a robot of that name, which is reached by its path; a robot
of the project comes before a check of a plug-in, which is reached as DISTRIBUTION:NAME. Either way that is said.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.source.project import ROOT_FILE, Description, NoDescription, all_here

from . import registry
from .parser import Parser
from .record import Check, Command
from .registry import Registered

CHECK = "check"  # the command that has checks

# Words that people type for a command, and the command that they look for.
INSTEAD = {
    "build": "all",
    "convert": "import",
    "create": "init",
    "generate": "all",
    "lint": "check",
    "new": "init",
    "show": "view",
    "validate": "check",
}


class Called(NamedTuple):
    """What a line calls (None: nothing of that name), in which words, and the words that are left for the parser.

    ``said`` is what there is to say of it ahead.
    """

    name: str
    found: Registered[Command] | Registered[Check] | None
    words: list[str]
    said: str = ""


def called(words: Sequence[str]) -> Called:
    """Return what a command line calls."""
    at = next((index for index, word in enumerate(words) if not word.startswith("-")), None)
    if at is None:
        return Called("", None, list(words))
    found = registry.command(words[at])
    plain = Called(words[at], found, list(words))
    if found is None or found.record.name != CHECK or found.plugin:
        return plain
    names_option = _Options(found)
    first = _first_word(plain.words, at + 1, names_option)
    return _by_name(plain, first) or _behind(plain, first, names_option) or _near(plain, first)


class _Options:
    """The options of ``check`` itself, asked for where they matter."""

    def __init__(self, command: Registered[Command]) -> None:
        self.command = command
        self.parser: Parser | None = None

    def takes_value(self, word: str) -> bool:
        """Say whether a word is an option whose value is the next one."""
        return any(one.nargs != 0 for one in self._parser().options if word in one.option_strings)

    def _parser(self) -> Parser:
        if self.parser is None:
            self.parser = Parser(add_help=False)
            self.command.add_options(self.parser)
        return self.parser


def _first_word(words: Sequence[str], begin: int, options: _Options) -> int | None:
    """Return where the first word stands that is no option and no value of one; None if there is none before --."""
    before = ""
    for at in range(begin, len(words)):
        if words[at] == "--":
            return None
        if not words[at].startswith("-") and not (before and options.takes_value(before)):
            return at
        before = words[at] if words[at].startswith("-") else ""
    return None


def _by_name(plain: Called, at: int | None) -> Called | None:
    """Return the check whose name a word is."""
    if at is None:
        return None
    name = plain.words[at]
    if name not in registry.own_checks():
        of_plugin = registry.whose("checks", name)
        if of_plugin and name in {path.parent.name for path in all_here()}:
            way = f"rosorin-compile {CHECK} {of_plugin}:{name}"
            return plain._replace(said=f'"{name}" is a robot here; the check of that name of {of_plugin}: {way}')
    found = registry.check(name)
    if found is None:
        return None
    said = _robot_by_path(name) if found.plugin is None else ""
    return Called(f"{plain.name} {name}", found, plain.words[:at] + plain.words[at + 1 :], said)


def _behind(plain: Called, at: int | None, options: _Options) -> Called | None:
    """Return the command itself where a word behind the first is the name of a check, and nothing else; say so."""
    while at is not None:
        at = _first_word(plain.words, at + 1, options)
        name = "" if at is None else plain.words[at]
        if name in registry.own_checks() and _robot(name) is None and not os.path.lexists(name):
            return plain._replace(said=f'"{name}" is a check, and stands before the robot: {CHECK} {name} ROBOT')
    return None


def _near(plain: Called, at: int | None) -> Called:
    """Return the command itself; a word that is no robot may nearly be the name of a check."""
    from rosorin_compile.source.diagnostics import nearest

    name = "" if at is None else plain.words[at]
    close = nearest(name, registry.names("checks"))
    if close is None or close == name or _robot(name) is not None:
        return plain
    return plain._replace(said=f'"{name}" is no check; did you mean "{close}"?')


def _robot(name: str) -> Description | None:
    """Return the robot of a name."""
    try:
        return Description.find([name])[0]
    except NoDescription:
        return None


def _robot_by_path(name: str) -> str:
    """Return how a robot is reached that is called as a check; empty if there is none."""
    robot = _robot(name)
    if robot is None:
        return ""
    path = robot.path.parent if robot.path.name == ROOT_FILE else robot.path
    shown = f"./{path}" if path == Path(name) else str(path)
    return f'"{name}" is a check; the robot of that name: rosorin-compile {CHECK} {shown}'


def suggestion(word: str) -> str:
    """Return a suggestion for a word that people type for a command, or an empty text."""
    from rosorin_compile.formats import FORMATS

    command = INSTEAD.get(word) or (f"print ROBOT {word}" if word in FORMATS else "")
    return f'say "{command}"' if command else ""

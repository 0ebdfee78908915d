"""Older spellings of a command line: they work for a release, and the new one is said once, on standard error.

The robot was the last word of some commands, and is the first of all. An option that has another name is added under
the old one by ``Parser.add_older``: the help and the completion do not show it.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Sequence
from typing import Any

from ..world import is_set
from .usage import old_spelling

# Words that people type for a command, and what it is called here.
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


def instead(word: str) -> str:
    """Return what to say for a word that people type and that is no command; empty for all others."""
    from ..formats import FORMATS

    said = INSTEAD.get(word) or (f"print ROBOT {word}" if word in FORMATS else "")
    return f'say "{said}"' if said else ""


def say_new(new: str, old: str) -> None:
    """Say how a line is written now, and until when ``old`` works."""
    sys.stderr.write(f"rosorin-compile: {old_spelling(old, new)}\n")


def robot_first(
    command: str,
    words: Sequence[str],
    fits: Callable[[str, list[str]], bool],
    robot: Callable[[str], bool] | None = None,
) -> tuple[str, list[str]]:
    """Return the robot and the other words of a line that names one: it is the first word, and once was the last.

    Where both may be a robot, it is the first unless the rest ``fits`` the last one alone. ``robot`` says whether a
    word can be one.
    """
    from .robots import is_robot

    robot = robot or is_robot
    first, last = words[0], words[-1]
    if not robot(last) or (robot(first) and (fits(first, [*words[1:]]) or not fits(last, [*words[:-1]]))):
        return first, [*words[1:]]
    if not _in_a_launch_file():
        say_new(f"{command} {shlex.join([last, *words[:-1]])}", "the old order")
    return last, [*words[:-1]]


def later_robot(command: str, words: Sequence[str], robots: Sequence[str]) -> None:
    """Say where the robot stands now, in a line of words that can be told from it wherever it stands."""
    if robots and words[0] != robots[0]:
        rest = [word for word in words if word != robots[0]]
        say_new(f"{command} {shlex.join([*robots, *rest])}", "the old order")


def _in_a_launch_file() -> bool:
    """Say whether a launch file may have called: it takes whatever stands on standard error for a failure."""
    return is_set("AMENT_PREFIX_PATH") and not sys.stderr.isatty()


class Older(argparse.Action):
    """Takes a value as the option does that has another name now, and says that name."""

    def __init__(self, option_strings: Sequence[str], dest: str, new: str, **settings: Any) -> None:
        super().__init__(option_strings, dest, **settings)
        self.new = new

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Take the value."""
        setattr(namespace, self.dest, values)
        if not self.new:  # the command says it, once it knows what there is
            return
        called = parser.prog.removeprefix("rosorin-compile ")
        say_new(f"{called} {self.new.replace('{}', shlex.quote(str(values)))}", str(option))

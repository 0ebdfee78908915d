"""The robots that a command line asks for, also the one on standard input; ``one`` finds the only one."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.request import is_foreign as is_foreign
from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import (
    STDIN,
    Description,
    NoDescription,
    first_file,
    give_stdin,
    here,
    without_first_file,
)
from rosorin_compile.source.rule_registry import FILES, Rule

from .given import given_arguments, no_half_mark
from .usage import WrongUsage

if TYPE_CHECKING:
    from .command import Options

RULES = (
    Rule(
        "no-robot-file",
        "A warning: a folder of `descriptions` has no file `robot.yaml`, so it is not compiled.",
        "Rename the file that the message names, or move the folder out of `descriptions`.",
        FILES,
    ),
)

_MAX_STDIN = 100_000_001  # bytes; more than any reader takes
_taken: list[Any] = []  # standard input, once it was read


def take_stdin(names: Sequence[str]) -> None:
    """Read standard input, if it is one of the robots that are asked for. Raises WrongUsage."""
    if STDIN not in names:
        return
    if names.count(STDIN) > 1:
        raise WrongUsage("standard input is one robot, and - stands there twice")
    if sys.stdin is None:
        raise WrongUsage("there is no standard input to read a robot from")
    if _taken and _taken[0] is sys.stdin:  # it is read once
        return
    if sys.stdin.isatty():
        sys.stderr.write("reading a robot from this terminal; Ctrl-D ends it\n")
        sys.stderr.flush()
    give_stdin(sys.stdin.buffer.read(_MAX_STDIN))
    _taken[:] = [sys.stdin]
    Progress.begin()  # who typed it did not wait for us


def no_stdin(words: Sequence[str], help: str) -> None:
    """Refuse standard input for a robot. Raises WrongUsage; ``help`` is the way out."""
    if STDIN in words:
        raise WrongUsage(f"a robot on standard input has no name and no folder; {help}")


def descriptions(names: list[str], outputs: str | None = None) -> list[Description]:
    """Return the descriptions that are asked for. Raises WrongUsage."""
    take_stdin(names)
    try:
        return Description.find(names, outputs)
    except NoDescription as problem:
        no_half_mark(names)
        raise WrongUsage(str(problem)) from None


def warn_of_no_robots(console: Console) -> None:
    """Warn of folders of this project that look like descriptions and have no ``robot.yaml``."""
    wrong = without_first_file(Description.around())
    if wrong:
        console.show([Diagnostic("no-robot-file", WARNING, message, help=help) for message, help in wrong])


def descriptions_of(names: list[str]) -> list[Description]:
    """Return the descriptions that are asked for; by default that of this folder, else all here. Raises WrongUsage."""
    if names:
        return descriptions(names)
    try:
        return here()
    except NoDescription as problem:
        raise WrongUsage(str(problem)) from None


def is_robot(word: str) -> bool:
    """Say whether a word is the name or the path of a robot, or stands for the one on standard input."""
    if word == STDIN:
        return True
    try:
        first_file(word)
    except NoDescription:
        return False
    return True


def one(name: str, how: str) -> Description:
    """Return the description of a name, or the only one here. Raises WrongUsage; ``how`` says how to name one."""
    found = descriptions_of([name] if name else [])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; name one: {how}")
    return found[0]


def described(options: Options, names: list[str]) -> list[Description]:
    """Return the descriptions that are asked for, with the folders of their artifacts where -o says. Raises WrongUsage.

    That is the folder of one robot itself; several get a folder each in it, as all robots of a project with --hook.
    """
    output = getattr(options, "output", None)
    found = descriptions(names, output)
    if output is not None and len(found) == 1 and not getattr(options, "hook", False):
        found = [replace(one, outputs=Path(output)) for one in found]
    return found


def check_depfile(options: Options) -> None:
    """Raise WrongUsage for a depfile of several robots, and for a target without one."""
    if options.depfile_target is not None and options.depfile is None:
        raise WrongUsage("--depfile-target goes with --depfile FILE")
    if options.depfile is None:
        return
    if options.hook:
        raise WrongUsage("--depfile does not go with --hook, which is about all robots of a project")
    found = descriptions(given_arguments(options, options.words)[1])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"a depfile is about one robot, and there are several: {robots}; name one")

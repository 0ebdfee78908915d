"""The robots that a command line asks for, also the one on standard input.

``for_each`` does something with each description that is asked for, ``one`` finds the only one.
"""

from __future__ import annotations

import codecs
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import world
from ..diagnostics.console import Console
from ..diagnostics.progress import about, begin
from ..project import (
    ENDINGS,
    STDIN,
    Description,
    NoDescription,
    all_with,
    find,
    give_stdin,
    here,
    looked_in,
    stdin_of,
    tool_folders,
)
from .given import Given, given_arguments, no_half_mark
from .options import console_of
from .usage import FINE, WrongUsage

if TYPE_CHECKING:
    import argparse

_MAX_STDIN = 100_000_001  # bytes; more than any reader takes
_taken: list[Any] = []  # standard input, once it was read


class Settled(NamedTuple):
    """A robot with which a run would do the same again: the folder of its artifacts, and what was made of what.

    ``made`` and ``read`` are the digests of artifacts and files by name; "" for a file that is to be read once more.
    """

    outputs: Path
    made: Mapping[str, str]
    read: Mapping[str, str]


class Run(NamedTuple):
    """One run of a command: its options, where it prints, the arguments for the descriptions, and what is settled."""

    options: argparse.Namespace
    console: Console
    given: Given
    settled: list[Settled]


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
    begin()  # who typed it did not wait for us


def no_stdin(words: Sequence[str], help: str) -> None:
    """Refuse standard input for a robot. Raises WrongUsage; ``help`` is the way out."""
    if STDIN in words:
        raise WrongUsage(f"a robot on standard input has no name and no folder; {help}")


def descriptions(names: list[str], outputs: str | None = None) -> list[Description]:
    """Return the descriptions that are asked for. Raises WrongUsage."""
    take_stdin(names)
    try:
        return find(names, outputs)
    except NoDescription as problem:
        no_half_mark(names)
        raise WrongUsage(str(problem)) from None


def meant(names: list[str]) -> list[Description]:
    """Return the descriptions that are asked for; by default that of this folder, else all here. Raises WrongUsage."""
    if names:
        return descriptions(names)
    try:
        return here()
    except NoDescription as problem:
        raise WrongUsage(str(problem)) from None


def one(name: str, how: str) -> Description:
    """Return the description of a name, or the only one here. Raises WrongUsage; ``how`` says how to name one."""
    found = meant([name] if name else [])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; name one: {how}")
    return found[0]


def for_each(options: argparse.Namespace, one: Callable[[Run, Description], int]) -> int:
    """Do something with each description that is asked for; return the worst exit code."""
    hook = getattr(options, "hook", False)
    given, found = _of_changed(options) if hook and options.words else _asked_for(options)
    summary = getattr(options, "summary", None)
    run = Run(options, console_of(options), given, [])
    code = FINE
    if not found:
        run.console.say("none of these files is in a project: no folder above them has descriptions/*/robot.yaml")
    for description in found:
        run.console.begin(description.name)
        about(f"{description.name}:" if len(found) > 1 else "")
        result = one(run, description)
        run.console.end(result != FINE)
        code = max(code, result)
    run.console.finish()
    if summary is not None:
        append_summary(Path(summary), run.console.summary())
    if run.settled and len(run.settled) == len(found) and code == FINE and _is_plain(run):
        made = {os.fspath(one.outputs): one.made for one in run.settled}
        read = dict.fromkeys(map(str, given.files), "")
        for one_robot in run.settled:
            read.update(one_robot.read)
        keep_run(read, made, run.console)
    return code


def keep_run(read: Mapping[str, str], made: Mapping[str, Mapping[str, str]], console: Console) -> None:
    """Keep what a run said, so that it is said again without one if nothing changes (see ``again.remember``)."""
    from ..plugins import installed
    from ..startup.again import remember

    if not installed():  # what a plug-in does may depend on anything
        remember(read, made, looked_in(), console.printed, tool_folders())


def _is_plain(run: Run) -> bool:
    """Say whether a run does nothing but write artifacts, and talks to people."""
    return run.console.for_people and not run.options.hook and run.options.depfile is None


def _asked_for(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the arguments that the command line sets, and the descriptions that it names. Raises WrongUsage."""
    given, names = given_arguments(options, options.words)
    return given, descriptions(names, getattr(options, "outputs", None))


def _of_changed(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the same of a command line that names files that changed; there may be none. Raises WrongUsage."""
    # What is a file sets no argument, whatever its name.
    files = [word for word in options.words if world.stands(word)]
    given, names = given_arguments(options, [word for word in options.words if word not in files])
    if names:
        raise WrongUsage(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    paths = [str(path) for path in all_with(files)]
    return given, descriptions(paths, getattr(options, "outputs", None)) if paths else []


_SUMMARY = "GITHUB_STEP_SUMMARY"  # the file to which steps of a job append, as GitHub names it


def check_summary(file: Path) -> None:
    """Raise WrongUsage for a file to which no summary goes: one that neither we nor a step of a job has begun."""
    from ..diagnostics.markdown import HEAD

    try:
        whose = world.variable(_SUMMARY)
        if world.kind(file) != world.FILE or (whose and world.is_same(file, whose)):
            return
        begins = world.head(file, len(HEAD.encode())).decode("utf-8", "replace")
    except (OSError, ValueError):
        return  # writing says why not
    if begins.strip() and begins != HEAD:
        raise WrongUsage(f'"{file}" is there, and is no summary: nothing is appended to it; name another file')


def append_summary(file: Path, text: str) -> None:
    """Append a text to a file that other steps of a job may have begun. Raises WrongUsage."""
    check_summary(file)
    try:
        with file.open("a", encoding="utf-8", errors="backslashreplace") as opened:
            opened.write(text)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise WrongUsage(f'cannot write the summary "{file}": {reason}') from None


def check_depfile(options: argparse.Namespace) -> None:
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


def is_foreign(path: Path) -> bool:
    """Say whether a file is a robot in another format than ours, by its name; on standard input by its text."""
    given = stdin_of(path)
    if given is not None:
        return given[:1_000].removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"<")
    if path.suffix.lower() in ("", *ENDINGS):
        return False
    from ..formats import endings

    return path.suffix.lower() in endings()

"""One run of a command: what was asked for is opened in one place, and what is said of it is ended there.

``Run.of`` opens a run, ``for_each`` does something with each robot that is asked for.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source import files
from rosorin_compile.source.console import Console
from rosorin_compile.source.plugins import aside
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, all_with

from .answer import answer_of, begin_robot, give_result, tell_of_robot
from .given import Given, given_arguments
from .robots import described, descriptions_of, no_stdin, one, take_stdin, warn_of_no_robots
from .usage import FINE, WrongUsage

if TYPE_CHECKING:
    import argparse

    from rosorin_compile.model.kinematics.quaternions import Position
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.rules.case import Case


@dataclass(frozen=True)
class Run:
    """One run of a command: its options, where it prints, what the descriptions are given, and the other words."""

    options: argparse.Namespace
    console: Console
    given: Given
    words: list[str] = field(default_factory=list)

    @staticmethod
    def take_stdin(names: Sequence[str]) -> None:
        """Read standard input, if it is one of the robots that are asked for. Raises WrongUsage."""
        take_stdin(names)

    @staticmethod
    def no_stdin(words: Sequence[str], help: str) -> None:
        """Refuse standard input for a robot. Raises WrongUsage; ``help`` is the way out."""
        no_stdin(words, help)

    @classmethod
    def of(cls, options: argparse.Namespace) -> Run:
        """Return the run that options ask for; its words are those that set no argument. Raises WrongUsage."""
        given, words = given_arguments(options, options.words)
        return cls(options, console_of(options), given, words)

    @classmethod
    def alone(cls, options: argparse.Namespace, several: str, how: str, stdin: str = "") -> tuple[Run, Description]:
        """Return the run of a command about one robot, and that robot: the one that is named, or the only one here.

        ``several`` says why it is one, ``how`` how it is named; ``stdin`` is the way out where none is taken from
        standard input. Raises WrongUsage.
        """
        run = cls.of(options)
        if stdin:
            no_stdin(run.words, stdin)
        if len(run.words) > 1:
            raise WrongUsage(f"{several}: {how}")
        return run, one(run.words[0] if run.words else "", how)

    def robots(self, names: list[str]) -> list[Description]:
        """Return the robots of these names; without one that of this folder, else all here. Raises WrongUsage."""
        return descriptions_of(names)

    def compiled(self, description: Description) -> Compiled | None:
        """Return what a robot is compiled to, its meshes found and all of it proven; None, once said, with errors."""
        from rosorin_compile.source.diagnostics import has_errors

        from .compiling import compile_proven, nothing_written

        compiled = compile_proven(self.given, description, self.console)
        self.console.show(compiled.diagnostics)
        if compiled.robot is not None and not has_errors(compiled.diagnostics):
            return compiled
        nothing_written(self.console, description.name, compiled.diagnostics)
        return None

    def understood(self, description: Description, quietly: bool = False) -> Case | None:
        """Return a robot and where it was written, also in another format; None, once said, with errors.

        ``quietly``: what is wrong with it was said before.
        """
        from .understanding import understood

        known = understood(self.given, description, Console("json") if quietly else self.console)
        return None if known is None else known.case

    def positions(self, case: Case) -> dict[str, Position] | None:
        """Return where --pose, --pulse and --joint put the joints of a robot; None, once said, with a wrong pulse.

        What is beyond a limit is told. Raises WrongUsage.
        """
        from .joint_states import asked_for

        return asked_for(case, self.options, self.console)

    def tell_of_robot(self, more: Mapping[str, object]) -> None:
        """Add to what the answer says of the robot at hand, in a command that goes through robots."""
        tell_of_robot(self.options, more)

    def finish(self) -> None:
        """End what is said, and append it to the summary if one is asked for. Raises WrongUsage."""
        self.console.finish()
        summary = getattr(self.options, "summary", None)
        if summary is not None:
            append_summary(Path(summary), self.console.summary())


def for_each(options: argparse.Namespace, work: Callable[[Run, Description], int], alone: str = "") -> int:
    """Do something with each description that is asked for; return the worst exit code.

    Where no robot is named, all there are; or, if ``alone`` says how to name one, the only one. Raises WrongUsage.
    """
    hook = getattr(options, "hook", False)
    given, found = _of_changed(options) if hook and options.words else _asked_for(options, alone)
    run = Run(options, console_of(options), given)
    if not options.words and not alone:
        warn_of_no_robots(run.console)
    plugin = getattr(options, "plugin", None)
    code = FINE
    if not found:
        run.console.say("none of these files is in a project: no folder above them has descriptions/*/robot.yaml")
    for description in found:
        run.console.begin(description.name)
        Progress.about(f"{description.name}:" if len(found) > 1 else "")
        begin_robot(options, description)
        # A program reads one document on standard output, and nothing that a plug-in prints beside it.
        with nullcontext() if plugin is None or run.console.for_people else aside(plugin):
            result = work(run, description)
        differing = {"differences": run.console.differing} if run.console.differing else {}
        tell_of_robot(options, {"fine": result == FINE, **differing})
        run.console.end(result != FINE)
        code = max(code, result)
    give_result(options, {"robots": answer_of(options).robots}, str)
    run.finish()
    return code


def _asked_for(options: argparse.Namespace, alone: str) -> tuple[Given, list[Description]]:
    """Return the arguments that the command line sets, and the descriptions that it names. Raises WrongUsage."""
    given, names = given_arguments(options, options.words)
    names = names or ([str(one("", alone).path)] if alone else [])
    return given, described(options, names)


def _of_changed(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the same of a command line that names files that changed; there may be none. Raises WrongUsage."""
    # What is a file sets no argument, whatever its name.
    files = [word for word in options.words if os.path.lexists(word)]
    given, names = given_arguments(options, [word for word in options.words if word not in files])
    if names:
        raise WrongUsage(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    paths = [str(path) for path in all_with(files)]
    return given, described(options, paths) if paths else []


def console_of(options: argparse.Namespace) -> Console:
    """Return where a command prints what it has to say, in the form that the options choose. Raises WrongUsage."""
    summary = getattr(options, "summary", None)
    if summary is not None:
        check_summary(Path(summary))
    diagnostics = answer_of(options).diagnostics
    form, verbose = getattr(options, "format", "text"), getattr(options, "verbose", False)
    console = Console(form, options.quiet, verbose, summary is not None, diagnostics)
    if hasattr(options, "notes") and not options.notes:
        console.counts, console.listing = True, "--notes lists them"
    return console


_SUMMARY = "GITHUB_STEP_SUMMARY"  # the file to which steps of a job append, as GitHub names it


def check_summary(file: Path) -> None:
    """Raise WrongUsage for a file to which no summary goes: one that neither we nor a step of a job has begun."""
    from rosorin_compile.source.markdown import HEAD

    try:
        whose = os.environ.get(_SUMMARY, "")
        if not files.is_file(file) or (whose and files.same_file(file, whose)):
            return
        begins = files.read_bytes(file, len(HEAD.encode())).decode("utf-8", "replace")
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

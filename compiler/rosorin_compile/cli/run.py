"""The state that a command needs while it runs: options, console, arguments and robots.

``Run.of`` creates it from the options; ``for_each`` calls a function for each requested robot.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence, Sized
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.cli.robots import warn_of_no_robots
from rosorin_compile.source import files
from rosorin_compile.source.console import Console
from rosorin_compile.source.plugins import aside
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, all_with
from rosorin_compile.source.wording import counted, listed

from .answer import answer_of, begin_robot, give_result, tell_of_robot
from .given import Given, given_arguments
from .robots import described, descriptions_of, no_stdin, one, take_stdin
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.model.kinematics.quaternions import Position
    from rosorin_compile.request import Request
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.viewer.changed import Pictures

    from .command import Options


@dataclass(frozen=True)
class Run:
    """One run of a command: its options, its console, the arguments of the descriptions, and the other words."""

    options: Options
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
    def of(cls, options: Options) -> Run:
        """Return the run that options ask for; its words are those that set no argument. Raises WrongUsage."""
        given, words = given_arguments(options, options.words)
        return cls(options, console_of(options), given, words)

    @classmethod
    def alone(cls, options: Options, several: str, how: str, stdin: str = "") -> tuple[Run, Description]:
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

    def request(self, description: Description) -> Request:
        """Return the request for a robot; warnings before code is executed are printed."""
        return self.given.request(description, self.console)

    def robots(self, names: list[str]) -> list[Description]:
        """Return the robots of these names; without one that of this folder, else all here. Raises WrongUsage."""
        return descriptions_of(names)

    def compiled(self, description: Description) -> Compiled | None:
        """Compile a robot with its meshes and print its diagnostics; return None with errors."""
        from rosorin_compile.source.diagnostics import has_errors

        request = self.request(description)
        compiled = request.compile()
        self.console.tell_read(request.inputs(compiled))
        self.console.show(compiled.diagnostics)
        if compiled.robot is not None and not has_errors(compiled.diagnostics):
            return compiled
        nothing_written(self.console, description.name, compiled.diagnostics)
        return None

    def understood(self, description: Description, quietly: bool = False) -> Case | None:
        """Return a robot in any format with its positions in files; None, after printing its errors, with errors."""
        request = self.request(description)
        found = (replace(request, warn=None) if quietly else request).understand()
        if found.case is None and not quietly:
            self.console.show([one for one in found.diagnostics if one.severity == "error"])
            self.no_robot(description)
        return found.case

    def no_robot(self, description: Description) -> None:
        """Print that a robot has errors, after its errors."""
        self.console.warn(f"{description.name}: a description with errors has no frames and joints to ask about")

    def positions(self, case: Case) -> dict[str, Position] | None:
        """Return the positions that --pose, --pulse and --joint set; None, after printing why, with a wrong pulse.

        Positions beyond a limit are printed. Raises WrongUsage.
        """
        from rosorin_compile.model.servos import NoPulse
        from rosorin_compile.rules.joint_states import beyond, beyond_limit, positions

        joints = assignments(self.options.joints, "JOINT=POSITION")
        pulses = assignments(self.options.pulses, "JOINT=PULSE")
        try:
            state = positions(case.robot, self.options.pose, joints, pulses)
        except NoPulse as problem:
            self.console.warn(f"rosorin-compile: {problem}")
            return None
        self.console.show([beyond_limit(case, one) for one in beyond(case.robot, state)])
        return state

    def tell_of_robot(self, more: Mapping[str, object]) -> None:
        """Add to what the answer says of the robot at hand, in a command that goes through robots."""
        tell_of_robot(self.options, more)

    def finish(self) -> None:
        """End what is said, and append it to the summary if one is asked for. Raises WrongUsage."""
        self.console.finish()
        summary = getattr(self.options, "summary", None)
        if summary is not None:
            append_summary(Path(summary), self.console.summary())


def assignments(texts: Iterable[str], example: str) -> dict[str, str]:
    """Return NAME=VALUE texts by name. Raises WrongUsage, which shows the example."""
    from rosorin_compile.rules.joint_states import split

    return dict(split(text, example) for text in texts)


def mode_states(texts: Iterable[str]) -> dict[str, bool]:
    """Return the modes that --mode sets: slam, "not slam", slam=on, slam=off. Raises WrongUsage."""
    found: dict[str, bool] = {}
    for text in texts:
        name, equals, state = text.partition("=")
        words = name.split()
        negated = len(words) == 2 and words[0] == "not"
        name = words[-1] if negated else name.strip()
        if (equals and state not in ("on", "off")) or (equals and negated):
            raise WrongUsage(f'"{text}" is not a mode: write {name}, "not {name}", {name}=on or {name}=off')
        on = state == "on" if equals else not negated
        if found.setdefault(name, on) != on:
            raise WrongUsage(f'the mode "{name}" cannot be on and off')
    return found


def for_each(options: Options, work: Callable[[Run, Description], int], alone: str = "") -> int:
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


def _asked_for(options: Options, alone: str) -> tuple[Given, list[Description]]:
    """Return the arguments that the command line sets, and the descriptions that it names. Raises WrongUsage."""
    given, names = given_arguments(options, options.words)
    names = names or ([str(one("", alone).path)] if alone else [])
    return given, described(options, names)


def _of_changed(options: Options) -> tuple[Given, list[Description]]:
    """Return the same of a command line that names files that changed; there may be none. Raises WrongUsage."""
    # What is a file sets no argument, whatever its name.
    files = [word for word in options.words if os.path.lexists(word)]
    given, names = given_arguments(options, [word for word in options.words if word not in files])
    if names:
        raise WrongUsage(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    paths = [str(path) for path in all_with(files)]
    return given, described(options, paths) if paths else []


def console_of(options: Options) -> Console:
    """Return where a command prints what it has to say, in the form that the options choose. Raises WrongUsage."""
    summary = getattr(options, "summary", None)
    if summary is not None:
        check_summary(Path(summary))
    verbose = getattr(options, "verbose", False)
    console = answer_of(options).console(options.quiet, verbose, summary is not None)
    if hasattr(options, "notes") and not options.notes and not verbose:
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


def write_depfile(
    run: Run, target: str, inputs: Sequence[Path], made: Sequence[Path] = (), newer: Sequence[Path] = ()
) -> int:
    """Write the requested depfile, make the files ``newer`` than it, and return the exit code.

    ``inputs`` are what the target is made of, ``made`` the artifacts.
    """
    from rosorin_compile.output import OutputError

    from . import depfile

    try:
        depfile.write_depfile(Path(run.options.depfile), target, inputs, made)
        depfile.touch(newer)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    return FINE


def write_page(page: Pictures, console: Console) -> None:
    """Write a page of changes. Raises WrongUsage."""
    from rosorin_compile.output import OutputError

    try:
        done = page.write()
    except OutputError as problem:
        raise WrongUsage(f"cannot write the page: {problem.diagnostic.message}") from None
    if not done.robots:
        removed = "; the old one is removed" if done.removed else ""
        console.warn(f"{done.file}: no page, because no robot compiles{removed}")
        return
    if done.left_out:
        console.warn(f"{done.file}: without {done.left_out}")
    console.say(f"{done.file}: a page with {counted(done.robots, 'robot')}, {done.bytes / 1e6:.1f} MB")


def nothing_written(console: Console, name: str, diagnostics: Sequence[Diagnostic]) -> int:
    """Print how many errors keep a robot from being compiled; a robot without outputs has none."""
    errors = sum(diagnostic.severity == "error" for diagnostic in diagnostics)
    if not errors:
        console.say(f"{name}: nothing to emit; say under outputs: what you want")
        return FINE
    console.warn(f"{name}: {counted(errors, 'error')}, nothing written")
    return PROBLEMS


def count(artifacts: Sized, meshes: Collection[str] = ()) -> str:
    """Return the number of artifacts in words, and that of the meshes and textures with them."""
    return listed([counted(len(artifacts), "artifact"), *counted_files(meshes)])


def counted_files(names: Collection[str]) -> list[str]:
    """Return the numbers of meshes and of textures in words, without those that are zero."""
    textures = sum(name.lower().endswith(".png") for name in names)
    counts = {"mesh file": len(names) - textures, "texture": textures}
    return [counted(number, word) for word, number in counts.items() if number]

"""The robots that a command line asks for, also the one on standard input.

``for_each`` does something with each description that is asked for, ``one`` finds the only one.
"""

from __future__ import annotations

import codecs
import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import world
from ..diagnostics.console import Console
from ..diagnostics.progress import Progress
from ..plugins import aside
from ..project import (
    ENDINGS,
    STDIN,
    Description,
    NoDescription,
    all_with,
    first_file,
    give_stdin,
    here,
    stdin_of,
)
from ..world import memory
from .answer import answer_of, begin_robot, give_result, tell_of_robot
from .given import Given, given_arguments, no_half_mark
from .options import append_summary, console_of
from .usage import FINE, WrongUsage

if TYPE_CHECKING:
    import argparse

    from ..model.kinematics.quaternions import Position
    from ..pipeline import Compiled
    from ..rules.case import Case

_MAX_STDIN = 100_000_001  # bytes; more than any reader takes
_NOT_ASKED = ("words", "run", "known", "called", "answer")  # of the options
_taken: list[Any] = []  # standard input, once it was read


class Run(NamedTuple):
    """One run of a command: its options, where it prints, the arguments for the descriptions."""

    options: argparse.Namespace
    console: Console
    given: Given

    @classmethod
    def alone(cls, options: argparse.Namespace, several: str, how: str, stdin: str = "") -> tuple[Run, Description]:
        """Return the run of a command about one robot, and that robot: the one that is named, or the only one here.

        ``several`` says why it is one, ``how`` how it is named; ``stdin`` is the way out where none is taken from
        standard input. Raises WrongUsage.
        """
        given, words = given_arguments(options, options.words)
        if stdin:
            no_stdin(words, stdin)
        if len(words) > 1:
            raise WrongUsage(f"{several}: {how}")
        description = one(words[0] if words else "", how)
        return cls(options, console_of(options), given), description

    def compiled(self, description: Description) -> Compiled | None:
        """Return what a robot is compiled to, its meshes found and all of it proven; None, once said, with errors."""
        from ..diagnostics import has_errors
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
        from .transforms.states import asked_for

        return asked_for(case, self.options, self.console)


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
    world.spoil("standard input is read")
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


def meant(names: list[str]) -> list[Description]:
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
    found = meant([name] if name else [])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; name one: {how}")
    return found[0]


def for_each(options: argparse.Namespace, work: Callable[[Run, Description], int], alone: str = "") -> int:
    """Do something with each description that is asked for; return the worst exit code.

    Where no robot is named, all there are; or, if ``alone`` says how to name one, the only one. Raises WrongUsage.
    """
    hook = getattr(options, "hook", False)
    given, found = _of_changed(options) if hook and options.words else _asked_for(options, alone)
    summary = getattr(options, "summary", None)
    run = Run(options, console_of(options), given)
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
    run.console.finish()
    if summary is not None:
        append_summary(Path(summary), run.console.summary())
    return code


def once(run: Run, description: Description, work: Callable[[], int]) -> int:
    """Do with a robot what a run before has done, if that would only be the same again; return the exit code.

    Where the messages are one document for a program, each run is made.
    """
    console = run.console
    if not console.for_people or console.keeps:
        return work()
    before = console.stand_ins
    done, was_known = memory.once(
        _key(run, description), work, [description.outputs], lambda: {"stand-ins": console.stand_ins - before}
    )
    if was_known:
        console.repeat(done.said)
        console.stand_ins += done.numbers["stand-ins"]
    return done.code


def _key(run: Run, description: Description) -> list[str]:
    """Return what tells one call from another: the options, the arguments, what is seen and how it is shown."""
    options = {name: value for name, value in vars(run.options).items() if name not in _NOT_ASKED}
    told = [options, sorted(run.given.texts.items()), list(map(str, run.given.files))]
    told += [[description.name, str(description.path), str(description.outputs)]]
    told += [sorted((n, str(f)) for n, f in run.given.packages.items())]
    return ["robot", run.options.called, *map(repr, told), *memory.surroundings()]


def _asked_for(options: argparse.Namespace, alone: str) -> tuple[Given, list[Description]]:
    """Return the arguments that the command line sets, and the descriptions that it names. Raises WrongUsage."""
    given, names = given_arguments(options, options.words)
    names = names or ([str(one("", alone).path)] if alone else [])
    return given, described(options, names)


def described(options: argparse.Namespace, names: list[str]) -> list[Description]:
    """Return the descriptions that are asked for, with the folders of their artifacts where -o says. Raises WrongUsage.

    That is the folder of one robot itself; several get a folder each in it, as all robots of a project with --hook.
    """
    output, outputs = getattr(options, "output", None), getattr(options, "outputs", None)
    if output is not None and outputs is not None:
        raise WrongUsage("--outputs is an older name of -o: say one of them")
    found = descriptions(names, output if outputs is None else outputs)
    many = len(found) > 1 or getattr(options, "hook", False)
    if outputs is not None:
        from .older import say_new

        where = outputs if many or not found else str(found[0].outputs)
        say_new(f"{options.called} -o {shlex.quote(where)}", "--outputs")
    elif output is not None and not many:
        found = [replace(one, outputs=Path(output)) for one in found]
    return found


def _of_changed(options: argparse.Namespace) -> tuple[Given, list[Description]]:
    """Return the same of a command line that names files that changed; there may be none. Raises WrongUsage."""
    # What is a file sets no argument, whatever its name.
    files = [word for word in options.words if world.stands(word)]
    given, names = given_arguments(options, [word for word in options.words if word not in files])
    if names:
        raise WrongUsage(f'with --hook the words are files that changed, and there is no file "{names[0]}"')
    paths = [str(path) for path in all_with(files)]
    return given, described(options, paths) if paths else []


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
    from ..formats import FORMATS

    return path.suffix.lower() in FORMATS.endings()

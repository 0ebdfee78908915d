"""The command line. The only code that prints.

Exit codes: 0 fine, 1 problems found, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence, Sized
from typing import TYPE_CHECKING, NamedTuple

from . import __version__
from .console import Console, colour
from .project import Description, NoDescription, find

if TYPE_CHECKING:
    from .output import Written
    from .pipeline import Compiled

FINE, PROBLEMS, USAGE = 0, 1, 2
FORMAT_NAMES = ("text", "json", "github", "sarif")


class Run(NamedTuple):
    """One run of a command: its options, where it prints, and the arguments for the descriptions."""

    options: argparse.Namespace
    console: Console
    arguments: dict[str, str]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    import gc

    gc.disable()
    options = parser().parse_args(argv)
    try:
        code: int = options.run(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PROBLEMS
    return code


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    top = argparse.ArgumentParser(
        prog="rosorin-compile",
        description="Say once, in YAML, what a robot looks like; every artifact that other programs read follows.",
    )
    top.add_argument("--version", action="version", version=f"rosorin-compile {__version__}")
    commands = top.add_subparsers(required=True, metavar="COMMAND")
    _command(commands, "all", "compile, and write every artifact", run_all, _all_options)
    _command(commands, "check", "compile, and compare with the committed artifacts", run_check, _check_options)
    return top


def _command(
    commands: argparse._SubParsersAction[argparse.ArgumentParser],
    name: str,
    help: str,
    run: Callable[[argparse.Namespace], int],
    options: Callable[[argparse.ArgumentParser], None],
) -> None:
    """Add a command with the options that all commands share and its own."""
    command = commands.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.")
    command.add_argument(
        "robots", nargs="*", metavar="ROBOT", help="name in descriptions/, folder or file; default: every robot"
    )
    command.add_argument(
        "-a", "--arg", action="append", default=[], metavar="NAME=VALUE", help="set an argument of the description"
    )
    command.add_argument("--outputs", metavar="DIR", help="where the artifacts stand; default: outputs/")
    command.add_argument("--format", choices=FORMAT_NAMES, default="text", help="form of the diagnostics")
    options(command)
    command.set_defaults(run=run)


def _all_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("-n", "--dry-run", action="store_true", help="write nothing; say what would change")
    command.add_argument("--prune", action="store_true", help="remove what is no artifact from the outputs folder")


def _check_options(command: argparse.ArgumentParser) -> None:
    command.add_argument("--full", action="store_true", help="show text differences in full")


def run_all(options: argparse.Namespace) -> int:
    """Compile each robot and write its artifacts."""
    return _for_each(options, _check_one if options.dry_run else _write_one)


def run_check(options: argparse.Namespace) -> int:
    """Compile each robot and compare with what is committed."""
    return _for_each(options, _check_one)


def _for_each(options: argparse.Namespace, one: Callable[[Run, Description], int]) -> int:
    arguments: dict[str, str] = {}
    for text in options.arg:
        name, equals, value = text.partition("=")
        if not equals or not name:
            return _usage(f'"{text}" is not NAME=VALUE')
        arguments[name] = value
    try:
        descriptions = find(options.robots, options.outputs)
    except NoDescription as problem:
        return _usage(str(problem))
    run = Run(options, Console(options.format), arguments)
    code = max(one(run, description) for description in descriptions)
    run.console.finish()
    return code


def _usage(message: str) -> int:
    sys.stderr.write(f"rosorin-compile: {message}\n")
    return USAGE


def _write_one(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts, or see that nothing has changed since that was done last."""
    from . import stamp

    key = {
        "description": os.path.abspath(description.path),
        "outputs": os.path.abspath(description.outputs),
        "arguments": run.arguments,
        "shown": [str(description.path), str(description.outputs), colour()],
    }
    remembered = stamp.recall(key, description.outputs) if run.console.for_people else None
    if remembered is not None:
        said, summary = remembered
        sys.stderr.write(said)
        run.console.say(f"{summary}, unchanged")
        return FINE
    from .pipeline import compile_robot

    begun = stamp.now()
    compiled = compile_robot(description.path, run.arguments)
    said = run.console.show(compiled.diagnostics)
    if not compiled.artifacts:
        return _without_artifacts(run, description, compiled)
    files = {artifact.file: artifact.text for artifact in compiled.artifacts}
    written = _write(run, description, files)
    if written is None:
        return PROBLEMS
    summary = f"{description.name}: {_count(files)} in {description.outputs}"
    run.console.say(f"{summary}, {_what_changed(written)}")
    if not written.kept:
        stamp.remember(key, compiled.inputs, files, description.outputs, [said, summary], begun=begun)
    return FINE


def _without_artifacts(run: Run, description: Description, compiled: Compiled) -> int:
    """Say how many problems keep a robot from being compiled; a robot without outputs has none."""
    errors = sum(diagnostic.severity == "error" for diagnostic in compiled.diagnostics)
    if not errors:
        run.console.say(f"{description.name}: nothing to emit; say under outputs: what you want")
        return FINE
    sys.stderr.write(f"{description.name}: {errors} error{'s' if errors > 1 else ''}, nothing written\n")
    return PROBLEMS


def _write(run: Run, description: Description, files: dict[str, str]) -> Written | None:
    from .diagnostic import NOTE, Diagnostic
    from .output import OutputError, write_set

    try:
        written = write_set(description.outputs, files, run.options.prune)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return None
    for name in written.kept:
        message = f"{description.outputs}/{name} is no artifact of this robot; it is kept"
        run.console.show([Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it")])
    return written


def _count(artifacts: Sized) -> str:
    return f"{len(artifacts)} artifact{'' if len(artifacts) == 1 else 's'}"


def _what_changed(written: Written) -> str:
    if not written.written and not written.removed:
        return "unchanged"
    parts = [f"written: {', '.join(written.written)}"] if written.written else []
    parts += [f"removed: {', '.join(written.removed)}"] if written.removed else []
    return "; ".join(parts)


def _check_one(run: Run, description: Description) -> int:
    """Compile one robot in memory and compare with its outputs folder."""
    from .compare import agreement, compare, lines
    from .diagnostic import error, has_errors
    from .output import OutputError, read_set
    from .pipeline import compile_robot

    compiled = compile_robot(description.path, run.arguments)
    run.console.show(compiled.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return _without_artifacts(run, description, compiled)
    try:
        committed = read_set(description.outputs)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    disagreements = agreement(compiled.robot, compiled.artifacts)
    run.console.show(disagreements)
    comparison = compare(compiled.robot, compiled.artifacts, committed)
    differences = lines(comparison, full=getattr(run.options, "full", False))
    if run.console.for_people:
        for line in differences:
            print(line)
    elif differences:
        help = "rosorin-compile all writes them anew"
        run.console.show([error("outputs-differ", "\n".join(differences), None, help)])
    if not comparison.same or disagreements:
        return PROBLEMS
    run.console.say(f"{description.name}: {_count(compiled.artifacts)} as committed in {description.outputs}")
    return FINE

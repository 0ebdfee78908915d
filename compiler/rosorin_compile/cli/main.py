"""The command line: a command is found by its record, and its module is imported when it is called.

Exit codes: 0 fine, 1 problems found, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import errno
import io
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.console import guarded, show_progress
from rosorin_compile.source.progress import Progress

from .answer import Answer, begun
from .calling import CHECK, called, suggestion
from .parser import Refused
from .registry import commands, names
from .usage import PROBLEMS, USAGE, WrongUsage, tell_of_cache, tell_of_system

if TYPE_CHECKING:
    from .calling import Called
    from .parser import Parser
    from .record import Command

# No command of the help: the scripts of ``completion`` ask so what may stand at the cursor.
ASKED_BY_SHELLS = "complete"

_NEEDED = {"jinja2": "jinja2", "jsonschema": "jsonschema", "yaml": "pyyaml"}  # modules, and their packages
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # what writing to a stream can end in

_WHAT = "Compile one YAML description of a robot to URDF, MJCF, SDF, launch files and other artifacts."
_MORE = """Run rosorin-compile COMMAND --help for the options of a command.
Exit codes: 0 fine, 1 problems or differences, 2 wrong usage."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error: no letter may stop a run
    with guarded():
        return _run(words)


def _run(words: list[str]) -> int:
    """Run a command line; return the exit code."""
    if not words:
        sys.stderr.write(parser(words).format_help())
        return USAGE
    if words[0] == ASKED_BY_SHELLS:
        from .completion import candidates

        return candidates.answer(words[1:], candidates.CommandLine(names("commands"), parser))
    answer = begun(words)
    try:
        code = _answered(words, answer)
        answer.end()
        sys.stdout.flush()
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        _say_no_more()
        return PROBLEMS
    except Exception as problem:
        # Python 3.11 wraps what comes while a class is made.
        return 130 if isinstance(problem.__cause__, KeyboardInterrupt) else _stopped(problem, answer)
    finally:
        Progress.hide()
    return code


def _answered(words: list[str], answer: Answer) -> int:
    """Do what a command line asks for; a program finds in the answer, too, why it cannot be followed."""
    try:
        line = _line(words)
        answer.command = _asked(line)
        options = _parsed(line)
        options.answer, answer.command = answer, options.called
        answer.form = getattr(options, "format", "")
        if getattr(options, "xacro_seconds", None):
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(options.xacro_seconds)  # for all processes of the run
        if _shown(options):
            show_progress(getattr(options, "in_logs", True))
        code: int = options.run(options)
        if not getattr(options, "quiet", False):
            console = answer.console()
            tell_of_cache(console)
            tell_of_system(console)
        return code
    except WrongUsage as problem:
        sys.stderr.write(f"rosorin-compile: {problem}\n")
        answer.refuse(str(problem))
        return USAGE
    except Refused as problem:
        answer.refuse(problem.message)
        answer.end()
        raise


def _shown(options: argparse.Namespace) -> bool:
    """Say whether somebody wants to see how far a run is: at a terminal, or in the log of a job."""
    for_people = getattr(options, "format", "text") in ("text", "github", "markdown")
    return for_people and not getattr(options, "quiet", False)


def _say_no_more() -> None:
    """Let standard output lead nowhere, so that Python does not try it again at the end."""
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _stopped(problem: Exception, answer: Answer) -> int:
    """Say what stopped the run: a plug-in, a name that no file can have, a full disk, a package that is not there.

    Whatever else is raised goes on.
    """
    from rosorin_compile.source.plugins import PluginFailed

    if isinstance(problem, ModuleNotFoundError) and problem.name in _NEEDED:
        package = _NEEDED[problem.name]
        message = f"the package {package} is not installed, and no robot is read without it: pip install {package}"
        sys.stderr.write(f"rosorin-compile: {message}\n")
        answer.refuse(message)
        answer.end()
        return USAGE
    if isinstance(problem, OSError) and problem.errno in _FULL and problem.filename is None:
        _say_no_more()
        sys.stderr.write(f"rosorin-compile: cannot write to standard output: {problem.strerror}\n")
        return PROBLEMS
    if isinstance(problem, OSError) and problem.errno == errno.ENAMETOOLONG:
        message = f"no file can have so long a name: {str(problem.filename)[:60]}..."
        sys.stderr.write(f"rosorin-compile: {message}\n")
        answer.refuse(message)
        answer.end()
        return USAGE
    if isinstance(problem, PluginFailed):
        told = problem.diagnostic
    elif isinstance(problem, OSError) and problem.filename is not None:
        from rosorin_compile.source.load import unreadable

        told = unreadable(problem)
    else:
        raise problem
    answer.console().show([told])
    answer.end()
    return PROBLEMS


def parse(words: list[str]) -> argparse.Namespace:
    """Return the options of a command line; words may stand before, between and after its options."""
    return _parsed(_line(words))


def _line(words: list[str]) -> Called:
    line = called(words[1:] if words[:1] == ["--"] else words)
    if line.said:
        sys.stderr.write(f"rosorin-compile: {line.said}\n")
    return line


def _asked(line: Called) -> str:
    """Return what is called by its own name: ``all`` for ``compile``, ``check physics`` for ``check --physics``."""
    if line.found is None:
        return ""
    return f"{CHECK} {line.found.record.name}" if line.found.is_check else line.found.record.name


def _parsed(line: Called) -> argparse.Namespace:
    top = _parser(line)
    options: argparse.Namespace
    with line.found.guarded() if line.found else nullcontext():
        options, more = top.parse_known_args(line.words)
    unknown = next((word for word in more if word.startswith("-") and word != "-"), "")
    if unknown:
        raise WrongUsage(f"{line.name} has no option {unknown}; {_near(unknown, options.known)}")
    if more and not hasattr(options, "words"):
        raise WrongUsage(f'{line.name} takes no "{more[0]}"; see rosorin-compile {line.name} --help')
    if more:
        options.words += more
    return options


def parser(words: Sequence[str]) -> Parser:
    """Return the parser of a command line; of the commands it has only the one that ``words`` call."""
    return _parser(called(words))


def _parser(line: Called) -> Parser:
    from .parser import Parser, Version

    top = Parser(
        prog="rosorin-compile",
        usage="rosorin-compile [-h] [--version] COMMAND ...",
        description=_WHAT,
        epilog=_MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        listed=lambda: listed(commands().values()),
    )
    top.add_argument(
        "--version", action=Version, nargs=0, help="show the versions of the tool and its plug-ins, and exit"
    )
    within = top.add_subparsers(required=True, metavar="COMMAND", prog="rosorin-compile", help=argparse.SUPPRESS)
    if line.name and line.found is None:
        also = [name for one in commands(of_plugins=False).values() for name in one.also]
        near = _near(line.name, [*names("commands"), *also])
        top.error(f'there is no command "{line.name}"; {suggestion(line.name) or near}')
    _add(within, line)
    return top


def _add(within: argparse._SubParsersAction[Parser], line: Called) -> None:
    """Add the command that a line calls, or the check, by one of its names."""
    found = line.found
    if found is None:
        return
    record, asked, first = found.record, _asked(line), line.name.split()[0]
    also = {record.name, *getattr(record, "also", ())} - {first} if not found.is_check else ()
    other = f" Alias: {', '.join(also)}." if also else ""
    added = within.add_parser(first, description=f"{record.help[0].upper()}{record.help[1:]}.{other}")
    added.prog = f"rosorin-compile {line.name}"
    found.add_options(added)
    if record.words:
        added.usage = f"{added.prog} [options] {record.words}"
    for one in (added, *added.within.values()):
        one.set_defaults(called=asked if one is added else f"{asked} {one.prog.split()[-1]}")
        one.epilog = "\n\n".join(filter(None, [one.epilog, f"Exit codes: {record.exits}, 2 wrong usage."]))
    added.set_defaults(run=found.run, known=added.long_options())


def _near(word: str, known: Iterable[str]) -> str:
    from rosorin_compile.source.diagnostics import did_you_mean

    return did_you_mean(word.partition("=")[0], known)


def listed(every: Iterable[Command]) -> str:
    """Return commands as the help shows them, in groups."""
    every = [one for one in every if not one.hidden]
    width = max(len(one.name) for one in every)
    lines: dict[str, list[str]] = {}
    for one in every:
        lines.setdefault(one.group, []).append(f"  {one.name:<{width}}  {one.help}\n")
    return "".join(f"\n{group}:\n{''.join(found)}" for group, found in lines.items())

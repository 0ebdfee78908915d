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
from pathlib import Path
from typing import TYPE_CHECKING

from .commands.answer import Answer, begun
from .commands.parser import Refused
from .commands.registry import GROUPS, command, commands
from .commands.usage import (
    PROBLEMS,
    USAGE,
    WrongUsage,
    tell_of_cache,
    tell_of_json,
    tell_of_system,
    tell_which_tool,
)
from .diagnostics.console import guarded, show_progress
from .diagnostics.progress import hide
from .world import spoil

if TYPE_CHECKING:
    from .commands.parser import Parser

# No command of the help: the scripts of ``completion`` ask so what may stand at the cursor.
ASKED_BY_SHELLS = "complete"

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)  # what writing to a stream can end in

_WHAT = "Say once, in YAML, what a robot looks like; every artifact that other programs read follows."
_MORE = """rosorin-compile COMMAND --help says more about one.
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
        from .commands.completion import candidates

        helps = {name: one.help for name, one in commands().items()}
        return candidates.answer(words[1:], candidates.CommandLine(helps, parser))
    answer = begun(words)
    try:
        tell_which_tool()
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
        hide()
    return code


def _answered(words: list[str], answer: Answer) -> int:
    """Do what a command line asks for; a program finds in the answer, too, why it cannot be followed."""
    try:
        found = command(_called(words))
        answer.command = found.record.name if found is not None else ""
        options = parse(words)
        options.answer, answer.command = answer, options.called
        answer.form = getattr(options, "format", "")
        if getattr(options, "old_json", False) and not getattr(options, "quiet", False):
            tell_of_json()
        if getattr(options, "xacro_seconds", None):
            os.environ["ROSORIN_COMPILE_XACRO_SECONDS"] = str(options.xacro_seconds)  # for all processes of the run
        if _shown(options):
            show_progress()
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
    """Say whether a run is one for a person, who wants to see how far it is."""
    for_programs = getattr(options, "format", "text") != "text"
    return not (for_programs or getattr(options, "quiet", False))


def _say_no_more() -> None:
    """Let standard output lead nowhere, so that Python does not try it again at the end."""
    spoil("nobody reads what is said")
    with Path(os.devnull).open("wb") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _stopped(problem: Exception, answer: Answer) -> int:
    """Say that a plug-in stopped the run, a name that no file can have, or a full disk; whatever else goes on."""
    from .plugins import PluginFailed

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
    if not isinstance(problem, PluginFailed):
        raise problem
    answer.console().show([problem.diagnostic])
    answer.end()
    return PROBLEMS


def parse(words: list[str]) -> argparse.Namespace:
    """Return the options of a command line; words may stand before, between and after its options."""
    words = words[1:] if words[:1] == ["--"] else words
    options: argparse.Namespace
    options, more = parser(words).parse_known_args(words)
    unknown = next((word for word in more if word.startswith("-") and word != "-"), "")
    if unknown:
        raise WrongUsage(f"{_called(words)} has no option {unknown}; {_near(unknown, options.known)}")
    if more and not hasattr(options, "words"):
        raise WrongUsage(f'{_called(words)} takes no "{more[0]}"; see rosorin-compile {_called(words)} --help')
    if more:
        options.words += more
    return options


def parser(words: Sequence[str]) -> Parser:
    """Return the parser of a command line; of the commands it has only the one that ``words`` call."""
    from .commands.parser import Parser, Version

    top = Parser(
        prog="rosorin-compile",
        usage="rosorin-compile [-h] [--version] COMMAND ...",
        description=f"{_WHAT}\n{listed()}",
        epilog=_MORE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action=Version, nargs=0, help="show the version, and the plug-ins with theirs")
    within = top.add_subparsers(required=True, metavar="COMMAND", prog="rosorin-compile", help=argparse.SUPPRESS)
    called = _called(words)
    if called:
        _add_command(top, within, called)
    return top


def _add_command(top: Parser, within: argparse._SubParsersAction[Parser], called: str) -> None:
    """Add the command that a line calls, by one of its names."""
    found = command(called)
    if found is None:
        known = [name for one in commands().values() for name in (one.name, *one.also)]
        top.error(f'there is no command "{called}"; {_near(called, known)}')
    record = found.record
    also = f" Its other name: {', '.join({record.name, *record.also} - {called})}." if record.also else ""
    added = within.add_parser(called, description=f"{record.help[0].upper()}{record.help[1:]}.{also}")
    found.function(record.options)(added)
    if record.words:
        added.usage = f"{top.prog} {called} [options] {record.words}"
    for one in (added, *added.within.values()):
        one.set_defaults(called=record.name if one is added else f"{record.name} {one.prog.split()[-1]}")
        one.epilog = "\n\n".join(filter(None, [one.epilog, f"Exit codes: {record.exits}, 2 wrong usage."]))
    added.set_defaults(run=found.function(record.run), known=added.long_options())


def _called(words: Sequence[str]) -> str:
    """Return the command that a command line calls: its first word that is no option."""
    return next((word for word in words if not word.startswith("-")), "")


def _near(word: str, known: Iterable[str]) -> str:
    from .diagnostics import did_you_mean

    return did_you_mean(word.partition("=")[0], known)


def listed() -> str:
    """Return the commands as the help shows them, in groups."""
    every = commands().values()
    width = max(len(one.name) for one in every)
    lines = {group: [f"  {one.name:<{width}}  {one.help}\n" for one in every if one.group == group] for group in GROUPS}
    return "".join(f"\n{group}:\n{''.join(found)}" for group, found in lines.items())

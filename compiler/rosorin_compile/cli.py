"""The command line: the table of commands. Each is a module of ``commands``, imported when it is called.

Exit codes: 0 fine, 1 problems found, 2 wrong usage.
"""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from . import __version__
from .commands.shared import PROBLEMS, USAGE, WrongUsage

COMMANDS = {
    "all": "compile, and write every artifact",
    "check": "compile, and compare with the committed artifacts",
    "args": "list the arguments of a robot",
    "explain": "say where a frame sits, and where each of its numbers was written",
    "watch": "compile on every change, and say what moved",
    "init": "start a new robot",
    "schema": "print the JSON Schema of descriptions, for editors",
}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    import gc

    gc.disable()
    words = sys.argv[1:] if argv is None else list(argv)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as standard error: no letter may stop a run
    options = parse(words)
    try:
        code: int = options.run(options)
        sys.stdout.flush()
    except WrongUsage as problem:
        sys.stderr.write(f"rosorin-compile: {problem}\n")
        return USAGE
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PROBLEMS
    return code


def parse(words: Sequence[str]) -> argparse.Namespace:
    """Return the options of a command line; words may stand before, between and after its options."""
    top = parser(words)
    options, more = top.parse_known_args(words)
    if more and (not hasattr(options, "words") or any(word.startswith("-") for word in more)):
        top.error(f"unrecognized arguments: {' '.join(more)}")
    if more:
        options.words += more
    return options


def parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Return the parser of a command line; of the commands only the one that ``words`` call is complete."""
    top = argparse.ArgumentParser(
        prog="rosorin-compile",
        description="Say once, in YAML, what a robot looks like; every artifact that other programs read follows.",
    )
    top.add_argument("--version", action="version", version=f"rosorin-compile {__version__}")
    commands = top.add_subparsers(required=True, metavar="COMMAND")
    called = next((word for word in words if not word.startswith("-")), "")
    for name, help in COMMANDS.items():
        command = commands.add_parser(name, help=help, description=f"{help[0].upper()}{help[1:]}.")
        if name == called:
            module = import_module(f".commands.{name}", __package__)
            module.options(command)
            command.set_defaults(run=module.run)
    return top

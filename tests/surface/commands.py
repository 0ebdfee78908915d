"""The command line as lines: each command with its words and exit codes, each option with what it takes."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from rosorin_compile.cli import parser
from rosorin_compile.commands.parser import Parser
from rosorin_compile.commands.registry import checks, commands


def lines() -> Iterator[str]:
    """Yield the commands, in the order of their names."""
    for name, record in sorted(commands().items()):
        yield from _of(name, parser([name]).within[name], record.words)
        yield from (f"{also} as {name}" for also in record.also)
    for name, check in sorted(checks().items()):
        yield from _of(f"check {name}", parser(["check", name]).within["check"], check.words)
        yield from (f"check {old} as check {name}" for old in check.old)


def _of(name: str, command: Parser, words: str) -> Iterator[str]:
    yield f"{name} {words}".rstrip()
    exits = (command.epilog or "").rpartition("Exit codes: ")[2]
    yield f"{name} exits: {' '.join(exits.split())}"
    for option in sorted(map(_option, command.options)):
        yield f"{name} {option}"
    for within, inner in sorted(command.within.items()):
        yield from _of(f"{name} {within}", inner, "")


def _option(action: argparse.Action) -> str:
    """Return an option with what it takes and what it is where it is not given."""
    names = ", ".join(action.option_strings) or f"<{action.dest}>"
    takes = "" if action.nargs == 0 else f" {action.metavar or action.dest.upper()}"
    many = f" nargs={action.nargs}" if action.nargs not in (None, 0) else ""
    choices = f" of {', '.join(map(str, action.choices))}" if action.choices and action.option_strings else ""
    default = "" if action.default in (None, False, [], argparse.SUPPRESS) else f" default={action.default}"
    return f"{names}{takes}{many}{choices}{default}"

"""rosorin-compile args: list the arguments of each robot."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.console import Console
from rosorin_compile.source.project import Description

from .answer import give_result
from .given import Given
from .robots import descriptions, warn_of_no_robots
from .run import Run
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.source.diagnostics import Span

    from .parser import Parser

_HEADS = ("name", "type", "allowed", "default", "set to", "where")


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robots()
    command.add_result()


def run(options: argparse.Namespace) -> int:
    """List the arguments of each robot; those that are given are shown, and checked."""
    run = Run.of(options)
    if not run.words:
        warn_of_no_robots(run.console)
    code, listed = FINE, []
    for description in descriptions(run.words):
        found = _declared(run.given, description, run.console)
        if found is None:
            code = PROBLEMS
        else:
            listed.append((description.name, found))
    robots = [{"robot": name, "arguments": [_object(argument) for argument in found]} for name, found in listed]
    give_result(options, robots, lambda: "\n".join(line for name, found in listed for line in _lines(name, found)))
    return code


def _declared(given: Given, description: Description, console: Console) -> list[Argument] | None:
    """Return the arguments of a description; None, after saying what is wrong, if they cannot be set like this."""
    from rosorin_compile.language.arguments import declared
    from rosorin_compile.source.load import LoadError

    try:
        found, diagnostics = declared(description.path, given.values(), given.packages)
    except LoadError as problem:
        diagnostics = [problem.diagnostic]
    console.show(diagnostics)
    return None if diagnostics else found


def _lines(name: str, found: list[Argument]) -> list[str]:
    """Return the arguments of a robot as a table, the help of each below it."""
    if not found:
        return [f"{name} has no arguments"]
    rows = [_HEADS, *(_row(argument) for argument in found)]
    used = [index for index in range(len(_HEADS)) if any(row[index] for row in rows[1:])]
    widths = {index: max(len(row[index]) for row in rows) for index in used}
    lines = [f"{name}:"]
    for row, argument in zip(rows, [None, *found], strict=True):
        lines.append("  " + "  ".join(row[index].ljust(widths[index]) for index in used).rstrip())
        if argument is not None and argument.help:
            lines.append(f"  {'':{widths[0]}}  {argument.help}")
    return lines


def _row(argument: Argument) -> tuple[str, ...]:
    default = "(required)" if argument.required else argument.default
    allowed = ", ".join(argument.allowed)
    return (argument.name, argument.type, allowed, default, argument.value, _place(argument.span))


def _place(span: Span) -> str:
    return f"{span.source.path}:{span.line}:{span.column}"


def _object(argument: Argument) -> dict[str, Any]:
    """Return an argument as plain JSON; values are the texts that are written, ``value`` only where one is given."""
    made: dict[str, Any] = {
        "name": argument.name,
        "type": argument.type,
        "allowed": list(argument.allowed),
        "required": argument.required,
        "default": None if argument.required else argument.default,
        "help": argument.help,
        **_where(argument.span),
    }
    if argument.value:
        made["value"] = {"text": argument.value, **(_where(argument.set_at) if argument.set_at else {})}
    return made


def _where(span: Span) -> dict[str, Any]:
    return {"file": span.source.path, "line": span.line, "column": span.column}

"""rosorin-compile args: list the arguments of each robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .answer import give_result
from .command import Options, command
from .options import robots_argument
from .robots import descriptions, warn_of_no_robots
from .run import Run
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.source.diagnostics import Span


_HEADS = ("name", "type", "allowed", "default", "set to", "where")


@command("args", exits="0 listed, 1 an invalid argument")
@robots_argument()
def run(options: Options) -> int:
    """List the arguments of each robot; those that are set are shown, and checked."""
    from rosorin_compile import api

    run = Run.of(options)
    if not run.words:
        warn_of_no_robots(run.console)
    results = [api.arguments(run.request(description)) for description in descriptions(run.words)]
    for result in results:
        run.console.show(result.diagnostics)
    if not options.words:
        warn_of_no_robots(run.console)
    fine = [result for result in results if not result.diagnostics]
    robots = [{"robot": one.robot, "arguments": [_object(argument) for argument in one.arguments]} for one in fine]
    give_result(options, robots, lambda: "\n".join(line for one in fine for line in _lines(one.robot, one.arguments)))
    return FINE if len(fine) == len(results) else PROBLEMS


def _lines(name: str, found: Sequence[Argument]) -> list[str]:
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

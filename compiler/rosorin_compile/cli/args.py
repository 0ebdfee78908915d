"""rosorin-compile args: list the arguments of each robot."""

from collections.abc import Sequence

from rosorin_compile import api
from rosorin_compile.language.arguments import Argument

from .command import Options, command, robots_argument
from .console import FINE, PROBLEMS, table
from .run import Run, find_robots, warn_of_no_robots


@command("args", exits="0 listed, 1 an invalid argument")
@robots_argument()
def run(options: Options) -> int:
    """List the arguments of each robot; those that are set are shown, and checked."""
    run = Run.from_options(options)
    results = [api.arguments(run.request(description)) for description in find_robots(run.words)]
    for result in results:
        run.console.show(result.diagnostics)
    if not run.words:
        warn_of_no_robots(run.console)
    valid = [result for result in results if not result.diagnostics]
    run.give(valid, lambda: "\n".join(line for one in valid for line in _lines(one.robot, one.arguments)))
    return FINE if len(valid) == len(results) else PROBLEMS


def _lines(name: str, arguments: Sequence[Argument]) -> list[str]:
    if not arguments:
        return [f"{name} has no arguments"]
    rows = [("name", "type", "allowed", "default", "set to", "where")]
    for one in arguments:
        place = f"{one.span.source.path}:{one.span.line}:{one.span.column}"
        default = "(required)" if one.required else one.default
        rows.append((one.name, one.type, ", ".join(one.allowed), default, one.value, place))
    used = [column for column in zip(*rows, strict=True) if any(column[1:])]
    heads, *lines = table(list(zip(*used, strict=True)))
    width = max(len(row[0]) for row in rows)
    shown = [f"{name}:", f"  {heads}"]
    for argument, line in zip(arguments, lines, strict=True):
        shown += [f"  {line}", *([f"  {'':{width}}  {argument.help}"] if argument.help else [])]
    return shown

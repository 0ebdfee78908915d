"""rosorin-compile explain and args: the lines of YAML behind a frame, and the arguments of a description."""

from collections.abc import Sequence

from rosorin_compile import api
from rosorin_compile.language.arguments import Argument
from rosorin_compile.source.diagnostics import ERROR, RequestError, UnknownName, has_errors
from rosorin_compile.source.project import Description, NoDescription, all_here

from .command import command, option, robot_options, robots_argument, words_argument
from .console import FINE, PROBLEMS, table
from .run import Run, find_robots, take_stdin, warn_of_no_robots


@command("explain", exits="0 printed, 1 the description has errors")
@words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts, arguments, named values or numbers (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@option("--pose POSE", default="", help="also print the frames in a named pose", offers="pose")
@robot_options
def run_explain(run: Run) -> int:
    """Explain frames of one robot; of several words the first is the robot if it can be."""
    take_stdin(run.words)
    description, names = None, run.words
    if len(names) > 1:
        try:
            description, names = Description.find(names[:1])[0], names[1:]
        except NoDescription:
            if not all_here():
                raise
    description = description or run.find_robot("", f"ROBOT {' '.join(names)}")
    try:
        found = api.explain(run.request(description), names, pose=run.pose)
    except UnknownName as problem:
        raise RequestError(f"{description.name}: {problem}") from None
    if has_errors(found.diagnostics):
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        run.console.warn(f"{description.name}: a description with errors has no meaning to explain")
        return PROBLEMS
    return run.give(found.answers, lambda: str(found))


@command("args", exits="0 listed, 1 an invalid argument")
@robots_argument()
def run_args(run: Run) -> int:
    """List the arguments of each robot; those that are set are shown, and checked."""
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

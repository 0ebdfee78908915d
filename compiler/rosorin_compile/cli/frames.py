"""rosorin-compile frames, graph, explain and args: its frames, nodes, lines of YAML and arguments."""

import os
import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from rosorin_compile import api
from rosorin_compile.language.arguments import Argument
from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import lines, publishers, rows, way
from rosorin_compile.output import may_replace, write_file
from rosorin_compile.source.diagnostics import ERROR, RequestError, UnknownName, has_errors
from rosorin_compile.source.project import Description, NoDescription, all_here
from rosorin_compile.viewer.frames import BOLD, Frames, Look, frames, table, tree

from . import command as cli
from .console import FINE, PROBLEMS, paint
from .console import table as aligned
from .run import Run, find_robots, take_stdin, warn_of_no_robots


@cli.command("frames", exits="0 shown or written, 1 the robot has errors")
@cli.robot_argument
@cli.option("--frame FRAME", help="show only the path to a frame", offers="frame", excludes="publisher output")
@cli.option("--publisher NODE", help='show only edges of a publisher; "nobody": those without one', excludes="output")
@cli.mode_option("one tree each for on and off")
@cli.option("-o", "--output FILE.svg", help="write a drawing: FILE.svg; FOLDER/: one file per tree")
@cli.force_option
@cli.flag("--ascii", help="draw the tree with ASCII characters")
@cli.robot_options
def run_frames(run: Run) -> int:
    """Show the tree of frames of one robot."""
    description = run.only_robot()
    found = frames(run.request(description), **run.pick("frame publisher output force modes"))
    failed, robot = run.show(found), found.robot
    if robot is None:
        return run.no_robot(description)
    if failed:
        return PROBLEMS
    if found.files:
        return run.give(found, lambda: "\n".join(f"{robot.name}: {path}" for path in found.files))
    return run.console.give(found, lambda: _text(robot, found, run), lambda text: paint(f"{text}\n", sys.stdout))


def _text(robot: Robot, found: Frames, run: Run) -> str:
    every, on_terminal, is_ascii = rows(robot), sys.stdout.isatty(), True
    with suppress(UnicodeEncodeError, LookupError):  # a stream in memory has no encoding
        is_ascii = run.ascii or not "└├│─╌".encode(sys.stdout.encoding or "utf-8")
    colours = publishers(every) if on_terminal and not os.environ.get("NO_COLOR") else ()
    style = Look(is_ascii, colours, shutil.get_terminal_size().columns if on_terminal else 0)
    if run.publisher is not None:
        published = (row for one in found.trees for row in one.edges if row.publisher == run.publisher)
        edges = list(dict.fromkeys(published))
        return "\n".join(table(edges, style)) if edges else f"{run.publisher} publishes nothing here"
    labels: dict[str, list[str]] = {}  # of situations, by their tree
    for situation in found.trees:
        shown = lines(situation.edges, robot.frames)
        if run.frame is not None:
            shown = way(shown, run.frame)
        drawn = "\n".join(tree(shown, style)) if shown else f"{run.frame} is not there"
        labels.setdefault(drawn, []).append(situation.label)
    if len(labels) == 1 < len(found.trees):  # a tree that is the same in all situations needs no heading
        return next(iter(labels))
    headed = ((style.paint(", or ".join(names), BOLD), drawn) for drawn, names in labels.items())
    return "\n\n".join(f"{head}\n{drawn}" if head else drawn for head, drawn in headed)


@cli.command("graph", exits="0 shown or written, 1 errors or open ends")
@cli.robot_argument
@cli.option("-o", "--output FILE.svg", help="write a drawing")
@cli.force_option
@cli.robot_options
def run_graph(run: Run) -> int:
    """Show the nodes of a robot, the topics between them, and topics that no node publishes."""
    from rosorin_compile.ros.graph import graph

    description = run.only_robot()
    found = graph(run.request(description))
    failed = run.show(found)
    if not found.robot:
        return run.no_robot(description)
    if run.output is None:
        run.give(found, found.text)
        return PROBLEMS if failed else FINE
    write_file(Path(run.output), found.svg().encode(), (), None if run.force else may_replace)
    run.give(found, lambda: f"{found.robot}: {run.output}")
    return PROBLEMS if failed else FINE


@cli.command("explain", exits="0 printed, 1 the description has errors")
@cli.words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts, arguments, named values or numbers (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@cli.option("--pose POSE", default="", help="also print the frames in a named pose", offers="pose")
@cli.robot_options
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


@cli.command("args", exits="0 listed, 1 an invalid argument")
@cli.robots_argument()
def run_args(run: Run) -> int:
    """List the arguments of each robot; those that are set are shown, and checked."""
    results = [api.arguments(run.request(description)) for description in find_robots(run.words)]
    for result in results:
        run.console.show(result.diagnostics)
    if not run.words:
        warn_of_no_robots(run.console)
    valid = [result for result in results if not result.diagnostics]
    run.give(valid, lambda: "\n".join(line for one in valid for line in _argument_table(one.robot, one.arguments)))
    return FINE if len(valid) == len(results) else PROBLEMS


def _argument_table(name: str, arguments: Sequence[Argument]) -> list[str]:
    if not arguments:
        return [f"{name} has no arguments"]
    rows = [("name", "type", "allowed", "default", "set to", "where")]
    for one in arguments:
        place = f"{one.span.source.path}:{one.span.line}:{one.span.column}"
        default = "(required)" if one.required else one.default
        rows.append((one.name, one.type, ", ".join(one.allowed), default, one.value, place))
    used = [column for column in zip(*rows, strict=True) if any(column[1:])]
    heads, *rest = aligned(list(zip(*used, strict=True)))
    width = max(len(row[0]) for row in rows)
    shown = [f"{name}:", f"  {heads}"]
    for argument, line in zip(arguments, rest, strict=True):
        shown += [f"  {line}", *([f"  {'':{width}}  {argument.help}"] if argument.help else [])]
    return shown

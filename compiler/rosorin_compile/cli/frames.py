"""rosorin-compile frames and graph: the tree of frames, and the nodes with their topics, as text or as a drawing."""

import os
import shutil
import sys
from contextlib import suppress
from pathlib import Path

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import lines, publishers, rows, way
from rosorin_compile.output import may_replace, write_file
from rosorin_compile.viewer.frames import BOLD, Frames, Look, frames, table, tree

from . import command as cli
from .console import FINE, PROBLEMS, paint
from .run import Run


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

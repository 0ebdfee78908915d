"""rosorin-compile frames: show the tree of frames with who publishes them, or write it as a picture."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from rosorin_compile.source.console import paint
from rosorin_compile.source.diagnostics import has_errors

from . import complete
from .answer import give_result
from .command import Options, command, option
from .options import PATH, mode_option, robot_argument, robot_options
from .run import Run, mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.model.frame_tree import Row
    from rosorin_compile.viewer.frame_trees import Tree
    from rosorin_compile.viewer.frames_text import Look


_HOW = "rosorin-compile frames ROBOT"
_LINES = "└├│─╌"


@command("frames", exits="0 shown or written, 1 the robot has errors")
@robot_argument
@option(
    "--frame",
    metavar="FRAME",
    help="show only the path from the root to a frame",
    shell_complete=complete.of("frame"),
)
@option("--publisher", metavar="NODE", help='show only the edges of a publisher; "nobody": edges without one')
@mode_option("one tree each for on and off")
@option(
    "-o",
    "--output",
    type=PATH,
    metavar="FILE.svg",
    help="write a drawing: FILE.svg; FOLDER/: one file per tree",
)
@option("--force", is_flag=True, help="replace a file that this command did not write")
@option("--ascii", is_flag=True, help="draw the tree with ASCII characters")
@robot_options
def run(options: Options) -> int:
    """Show the tree of frames of one robot."""
    from rosorin_compile import api

    chosen = [name for name in ("frame", "publisher", "output") if getattr(options, name) is not None]
    if len(chosen) > 1:
        raise WrongUsage(f"--{chosen[0]} and --{chosen[1]} do not go together")
    run, description = Run.alone(options, "one robot at a time", _HOW)
    found = api.frames(
        run.request(description),
        frame=options.frame,
        publisher=options.publisher,
        modes=mode_states(options.modes),
        output=options.output,
        force=options.force,
    )
    run.console.show(found.diagnostics)
    if found.robot is None:
        run.no_robot(description)
    if found.robot is None or has_errors(found.diagnostics):
        return PROBLEMS
    robot = found.robot
    if found.files:
        give_result(options, found, lambda: "\n".join(f"{robot.name}: {path}" for path in found.files))
        return FINE
    give_result(options, found, lambda: _text(robot, found.trees, options), lambda text: paint(f"{text}\n", sys.stdout))
    return FINE


def _text(robot: Robot, shown: tuple[Tree, ...], options: Options) -> str:
    from rosorin_compile.model.frame_tree import publishers, rows
    from rosorin_compile.viewer.frames_text import Look, table

    every = rows(robot)
    how = Look(options.ascii or not _has_lines(), publishers(every) if _coloured() else (), _width())
    if options.publisher is not None:
        found = _of_publisher(shown, options.publisher)
        return "\n".join(table(found, how)) if found else f"{options.publisher} publishes nothing here"
    if options.frame is not None:
        return "\n".join([*_answers(every, shown, options.frame), "", *_trees(robot, shown, how, options.frame)])
    return "\n".join(_trees(robot, shown, how, None))


def _of_publisher(shown: tuple[Tree, ...], name: str) -> list[Row]:
    return list(dict.fromkeys(row for one in shown for row in one.edges if row.publisher == name))


def _answers(every: tuple[Row, ...], shown: tuple[Tree, ...], frame: str) -> list[str]:
    """Return who publishes a frame, in a sentence for each edge into it."""
    there = {row for one in shown for row in one.edges}
    said = []
    for row in (row for row in every if row.child == frame and row in there):
        edge = f"{row.parent} -> {row.child}"
        joint = f", joint {row.joint}" if row.joint else ""
        when = f"when {row.when}" if row.when else "always"
        why = f": {row.why}" if row.why else ""
        said.append(
            f"{row.publisher} publishes {edge} on {row.topic}, {when}{joint}"
            if row.published
            else f"nobody publishes {edge}{joint}{why}"
        )
    if said:
        return said
    lost = any(row.child == frame for row in every)
    return [f"nobody publishes {frame} in these modes" if lost else f"nothing is above {frame}: it is a root"]


def _trees(robot: Robot, shown: tuple[Tree, ...], how: Look, frame: str | None) -> list[str]:
    """Return the tree of each situation under its heading, or of it the way to a frame."""
    from rosorin_compile.model.frame_tree import lines, way
    from rosorin_compile.viewer.frames_text import heading, tree

    blocks: dict[tuple[str, ...], list[str]] = {}
    names = robot.frames
    for situation in shown:
        found = lines(situation.edges, names)
        if frame is not None:
            found = way(found, frame)
        drawn = tuple(tree(found, how)) if found else (f"{frame} is not there",)
        blocks.setdefault(drawn, []).append(situation.label)
    said: list[str] = []
    for drawn, labels in blocks.items():
        # What is the same in all situations needs no heading.
        label = ", or ".join(labels) if len(blocks) > 1 or len(shown) == 1 else ""
        said += [""] * bool(said) + [heading(label, how)] * bool(label) + list(drawn)
    return said


def _has_lines() -> bool:
    """Whether standard output can print the lines of a tree; a text in memory, without an encoding, can."""
    try:
        _LINES.encode(sys.stdout.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def _width() -> int:
    """Return how many columns the terminal has; 0 for a file or a pipe, in which lines may be as long as they are."""
    import shutil

    return shutil.get_terminal_size().columns if sys.stdout.isatty() else 0


def _coloured() -> bool:
    return sys.stdout.isatty() and not os.environ.get("NO_COLOR")

"""rosorin-compile frames: show the tree of frames with their publishers, or write it as a picture."""

from __future__ import annotations

import os
import shutil
import sys
from typing import TYPE_CHECKING

from rosorin_compile.cli.console import paint
from rosorin_compile.source.diagnostics import RequestError

from . import command as cli
from . import complete
from .answer import PROBLEMS, give_result
from .run import Run, mode_states

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.viewer.frames import Frames


@cli.command("frames", exits="0 shown or written, 1 the robot has errors")
@cli.robot_argument
@cli.option(
    "--frame", metavar="FRAME", help="show only the path from the root to a frame", shell_complete=complete.of("frame")
)
@cli.option("--publisher", metavar="NODE", help='show only the edges of a publisher; "nobody": edges without one')
@cli.mode_option("one tree each for on and off")
@cli.path_option("-o", "--output", metavar="FILE.svg", help="write a drawing: FILE.svg; FOLDER/: one file per tree")
@cli.force_option
@cli.flag("--ascii", help="draw the tree with ASCII characters")
@cli.robot_options
def run(options: cli.Options) -> int:
    """Show the tree of frames of one robot."""
    from rosorin_compile import api

    chosen = [name for name in ("frame", "publisher", "output") if getattr(options, name) is not None]
    if len(chosen) > 1:
        raise RequestError(f"--{chosen[0]} and --{chosen[1]} do not go together")
    run, description = Run.alone(options, "one robot at a time", "rosorin-compile frames ROBOT")
    found = api.frames(
        run.request(description), **options.pick("frame publisher output force"), modes=mode_states(options.modes)
    )
    failed, robot = run.show(found), found.robot
    if robot is None:
        return run.no_robot(description)
    if failed:
        return PROBLEMS
    if found.files:
        return run.give(found, lambda: "\n".join(f"{robot.name}: {path}" for path in found.files))
    return give_result(
        options, found, lambda: _text(robot, found, options), lambda text: paint(f"{text}\n", sys.stdout)
    )


def _text(robot: Robot, found: Frames, options: cli.Options) -> str:
    """Return the trees as text, as wide as the terminal."""
    from rosorin_compile.model.frame_tree import lines, publishers, rows, way
    from rosorin_compile.viewer.frames import Look, heading, table, tree

    every, on_terminal = rows(robot), sys.stdout.isatty()
    colours = on_terminal and not os.environ.get("NO_COLOR")
    width = shutil.get_terminal_size().columns if on_terminal else 0
    style = Look(options.ascii or not _can_print("└├│─╌"), publishers(every) if colours else (), width)
    if options.publisher is not None:
        published = (row for one in found.trees for row in one.edges if row.publisher == options.publisher)
        edges = list(dict.fromkeys(published))
        return "\n".join(table(edges, style)) if edges else f"{options.publisher} publishes nothing here"
    blocks: dict[tuple[str, ...], list[str]] = {}  # the labels of situations by their tree
    for situation in found.trees:
        shown = lines(situation.edges, robot.frames)
        if options.frame is not None:
            shown = way(shown, options.frame)
        drawn = tuple(tree(shown, style)) if shown else (f"{options.frame} is not there",)
        blocks.setdefault(drawn, []).append(situation.label)
    text = [*_publishers_of(robot, found, options.frame), ""] if options.frame is not None else []
    for number, (drawn, labels) in enumerate(blocks.items()):
        # A tree that is the same in all situations needs no heading.
        label = ", or ".join(labels) if len(blocks) > 1 or len(found.trees) == 1 else ""
        text += [""] * (number > 0) + [heading(label, style)] * bool(label) + list(drawn)
    return "\n".join(text)


def _publishers_of(robot: Robot, found: Frames, frame: str) -> list[str]:
    """Return who publishes a frame, in a sentence for each edge into it."""
    from rosorin_compile.model.frame_tree import rows

    into = [row for row in rows(robot) if row.child == frame]
    shown = {row for one in found.trees for row in one.edges}
    sentences = []
    for row in (row for row in into if row in shown):
        edge = f"{row.parent} -> {row.child}"
        joint = f", joint {row.joint}" if row.joint else ""
        when = f"when {row.when}" if row.when else "always"
        why = f": {row.why}" if row.why else ""
        sentences.append(
            f"{row.publisher} publishes {edge} on {row.topic}, {when}{joint}"
            if row.published
            else f"no node publishes {edge}{joint}{why}"
        )
    none = f"no node publishes {frame} in these modes" if into else f"nothing is above {frame}: it is a root"
    return sentences or [none]


def _can_print(text: str) -> bool:
    """Return True if standard output can print a text; one in memory, without an encoding, can."""
    try:
        text.encode(sys.stdout.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True

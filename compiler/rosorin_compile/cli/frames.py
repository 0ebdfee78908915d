"""rosorin-compile frames: show the tree of frames with who publishes them, or write it as a picture."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.console import paint
from rosorin_compile.source.diagnostics import Heading
from rosorin_compile.source.files import is_file, is_folder, read_bytes
from rosorin_compile.source.rule_registry import Rule

from .answer import give_result
from .run import Run
from .understanding import mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.model.frame_tree import Row
    from rosorin_compile.source.diagnostics import Console
    from rosorin_compile.viewer.drawing.situations import Situation
    from rosorin_compile.viewer.drawing.terminal import Look

    from .parser import Parser

RULES = (Rule("picture-file", "A picture cannot be written.", "The message says why.", Heading.OUTPUTS),)

_HOW = "rosorin-compile frames ROBOT"
_LINES = "└├│─╌"


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument("--frame", metavar="FRAME", help="show only the path from the root to a frame")
    command.add_argument(
        "--publisher", metavar="NODE", help='show only the edges of a publisher; "nobody": edges without one'
    )
    command.add_modes("one tree each for on and off")
    command.add_argument(
        "-o",
        "--output",
        type="path",
        metavar="FILE",
        help="write a drawing: .svg, .dot or .gv (Graphviz), .mmd or .md (Mermaid); FOLDER/: one SVG per tree",
    )
    command.add_argument("--force", action="store_true", help="replace a file that this command did not write")
    command.add_argument("--ascii", action="store_true", help="draw the tree with ASCII characters")
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Show the tree of frames of one robot."""
    chosen = [name for name in ("frame", "publisher", "output") if getattr(options, name) is not None]
    if len(chosen) > 1:
        raise WrongUsage(f"--{chosen[0]} and --{chosen[1]} do not go together")
    run, description = Run.alone(options, "one robot at a time", _HOW)
    known = run.understood(description)
    if known is None:
        return PROBLEMS
    from rosorin_compile.viewer.drawing.situations import TooMany, situations

    try:
        shown = situations(known.robot, mode_states(known.robot, options.modes))
    except TooMany as problem:
        raise WrongUsage(f"{problem}; name modes: --mode NAME") from None
    if options.output is not None:
        return _write(known.robot, shown, options, run.console)
    _check_names(known.robot, options)
    give_result(
        options,
        _result(known.robot, shown, options),
        lambda: _text(known.robot, shown, options),
        lambda text: paint(f"{text}\n", sys.stdout),
    )
    return FINE


def _check_names(robot: Robot, options: argparse.Namespace) -> None:
    """Raise WrongUsage for a frame or publisher that the robot does not have."""
    from rosorin_compile.model.frame_tree import NOBODY, rows
    from rosorin_compile.source.diagnostics import did_you_mean

    edges = rows(robot)
    if options.frame is not None:
        frames = dict.fromkeys(robot.frames)
        frames |= dict.fromkeys(name for row in edges for name in (row.parent, row.child))
        if options.frame not in frames:
            raise WrongUsage(f'there is no frame "{options.frame}"; {did_you_mean(options.frame, frames)}')
    if options.publisher is not None:
        names = dict.fromkeys([*(row.publisher for row in edges), NOBODY])
        if options.publisher not in names:
            raise WrongUsage(f'there is no publisher "{options.publisher}"; {did_you_mean(options.publisher, names)}')


def _text(robot: Robot, shown: tuple[Situation, ...], options: argparse.Namespace) -> str:
    from rosorin_compile.model.frame_tree import publishers, rows
    from rosorin_compile.viewer.drawing.terminal import look, table

    every = rows(robot)
    how = look(options.ascii or not _has_lines(), _coloured(), publishers(every), _width())
    if options.publisher is not None:
        found = _of_publisher(shown, options.publisher)
        return "\n".join(table(found, how)) if found else f"{options.publisher} publishes nothing here"
    if options.frame is not None:
        return "\n".join([*_answers(every, shown, options.frame), "", *_trees(robot, shown, how, options.frame)])
    return "\n".join(_trees(robot, shown, how, None))


def _of_publisher(shown: tuple[Situation, ...], name: str) -> list[Row]:
    return list(dict.fromkeys(row for one in shown for row in one.edges if row.publisher == name))


def _answers(every: tuple[Row, ...], shown: tuple[Situation, ...], frame: str) -> list[str]:
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


def _trees(robot: Robot, shown: tuple[Situation, ...], how: Look, frame: str | None) -> list[str]:
    """Return the tree of each situation under its heading, or of it the way to a frame."""
    from rosorin_compile.model.frame_tree import lines, way
    from rosorin_compile.viewer.drawing.terminal import heading, tree

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


def _result(robot: Robot, shown: tuple[Situation, ...], options: argparse.Namespace) -> dict[str, object]:
    """Return the frames of each situation, and who publishes each edge."""
    from rosorin_compile.model.frame_tree import lines, way

    names = robot.frames
    made = []
    for situation in shown:
        found = lines(situation.edges, names)
        if options.frame is not None:
            found = way(found, options.frame)
        edges = [line.row for line in found if line.row is not None]
        if options.publisher is not None:
            edges = [row for row in edges if row.publisher == options.publisher]
        made.append(
            {
                "when": situation.label,
                "modes": [dict(states) for states in situation.modes],
                "frames": list(dict.fromkeys(line.frame for line in found)) if options.publisher is None else [],
                "edges": [_edge(row) for row in edges],
            }
        )
    return {"robot": robot.name, "situations": made}


def _edge(row: Row) -> dict[str, object]:
    return {
        "parent": row.parent,
        "child": row.child,
        "publisher": row.publisher if row.published else None,
        "why": row.why or None,
        "topic": row.topic if row.published else None,
        "when": row.when or None,
        "joint": row.joint or None,
        "type": row.kind or None,
    }


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
    return sys.stdout.isatty() and "NO_COLOR" not in os.environ


def _write(robot: Robot, shown: tuple[Situation, ...], options: argparse.Namespace, console: Console) -> int:
    """Write the picture, or a picture for each situation into a folder. Raises WrongUsage."""
    from rosorin_compile.output import OutputError, write_file, write_set
    from rosorin_compile.viewer.drawing import SUFFIXES, picture, suffix

    target = Path(options.output)
    folder = options.output.endswith(("/", os.sep)) or is_folder(target)
    if folder:
        names = [f"frames_{one.short}.svg" if one.short else "frames.svg" for one in shown]
        files = {target / name: picture(robot, ".svg", [one]) for name, one in zip(names, shown, strict=True)}
    elif suffix(options.output):
        files = {target: picture(robot, suffix(options.output), shown)}
    else:
        raise WrongUsage(f"{options.output} is no picture: name one that ends in {', '.join(SUFFIXES)}, or FOLDER/")
    odd = [path for path in files if os.path.lexists(path) and not is_file(path)]
    if odd:
        raise WrongUsage(f"{odd[0]} cannot be written: it is no regular file")
    foreign = [path for path in files if not options.force and os.path.lexists(path) and not _is_ours(path)]
    if foreign:
        raise WrongUsage(f"{foreign[0]} is there, and frames did not make it; name another file, or add --force")
    try:
        if folder:
            write_set(Path(os.path.abspath(target)), {path.name: text for path, text in files.items()})
        else:
            write_file(target, files[target].encode(), may_replace=None)
    except OutputError as problem:
        console.show([problem.diagnostic if folder else replace(problem.diagnostic, rule="picture-file")])
        return PROBLEMS
    written = {"robot": robot.name, "files": list(map(str, files))}
    give_result(options, written, lambda: "\n".join(f"{robot.name}: {path}" for path in files))
    return FINE


def _is_ours(path: Path) -> bool:
    try:
        return b"Generated by rosorin-compile" in read_bytes(path, 4096)
    except OSError:
        return False

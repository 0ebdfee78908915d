"""The trees of frames of a robot with their publishers, as values and as drawings."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import NOBODY, Row, lines, rows, way
from rosorin_compile.output import OutputError, may_replace, write_file, write_set
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, UnknownName, did_you_mean
from rosorin_compile.source.rule_registry import Heading, Rule

from .frame_trees import TooMany, Tree, frame_trees
from .frames_picture import svg

RULES = (Rule("picture-file", "A picture cannot be written.", "The message says why.", Heading.OUTPUTS),)


@dataclass(frozen=True)
class FrameEdge:
    """An edge of a tree of frames. ``publisher`` is None if nobody publishes it; then ``why`` has the reason.

    ``when`` is the condition in modes, None for always. ``joint`` and its ``type`` are None for edges of other nodes.
    """

    parent: str
    child: str
    publisher: str | None
    why: str | None
    topic: str | None
    when: str | None
    joint: str | None
    type: str | None


@dataclass(frozen=True)
class FrameSituation:
    """The tree of frames in some modes: ``when`` names them, ``modes`` has all combinations."""

    when: str
    modes: tuple[Mapping[str, bool], ...]
    frames: tuple[str, ...]
    edges: tuple[FrameEdge, ...]


@dataclass(frozen=True)
class Frames:
    """The trees of frames of a robot, one for each combination of modes in which they differ.

    ``files`` are drawings that were written. Without ``robot`` there are errors in ``diagnostics``.
    """

    name: str
    situations: tuple[FrameSituation, ...] = ()
    files: tuple[Path, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)
    trees: tuple[Tree, ...] = field(default=(), repr=False)


def trees(robot: Robot, modes: Mapping[str, bool]) -> tuple[Tree, ...]:
    """Return the trees of a robot in modes. Raises RequestError if there are too many."""
    try:
        return frame_trees(robot, modes)
    except TooMany as problem:
        raise RequestError(f"{problem}; name modes: --mode NAME") from None


def frames(robot: Robot, modes: Mapping[str, bool], frame: str | None = None, publisher: str | None = None) -> Frames:
    """Return the trees of a robot, of them only the path to a frame or the edges of a publisher.

    Raises UnknownName.
    """
    edges = rows(robot)
    if frame is not None:
        names = dict.fromkeys([*robot.frames, *(name for row in edges for name in (row.parent, row.child))])
        if frame not in names:
            raise UnknownName(f'there is no frame "{frame}"; {did_you_mean(frame, names)}')
    if publisher is not None:
        names = dict.fromkeys([*(row.publisher for row in edges), NOBODY])
        if publisher not in names:
            raise UnknownName(f'there is no publisher "{publisher}"; {did_you_mean(publisher, names)}')
    shown = trees(robot, modes)
    return Frames(
        robot.name, tuple(_situation(robot, one, frame, publisher) for one in shown), robot=robot, trees=shown
    )


def _situation(robot: Robot, shown: Tree, frame: str | None, publisher: str | None) -> FrameSituation:
    found = lines(shown.edges, robot.frames)
    if frame is not None:
        found = way(found, frame)
    edges = [line.row for line in found if line.row is not None]
    names = dict.fromkeys(line.frame for line in found)
    if publisher is not None:
        edges, names = [row for row in edges if row.publisher == publisher], {}
    modes = tuple(dict(states) for states in shown.modes)
    return FrameSituation(shown.label, modes, tuple(names), tuple(map(_edge, edges)))


def _edge(row: Row) -> FrameEdge:
    return FrameEdge(
        row.parent,
        row.child,
        row.publisher if row.published else None,
        row.why or None,
        row.topic if row.published else None,
        row.when or None,
        row.joint or None,
        row.kind or None,
    )


def draw_frames(robot: Robot, shown: Sequence[Tree], output: str, force: bool = False) -> Frames:
    """Write a drawing of the trees, or one for each tree into a folder: an existing one, or a name that ends in "/".

    A file that this tool did not write is replaced with ``force`` only. Raises RequestError.
    """
    target = Path(output)
    folder = output.endswith(("/", os.sep)) or target.is_dir()
    if folder:
        names = [f"frames_{one.short}.svg" if one.short else "frames.svg" for one in shown]
        files = {target / name: svg(robot, [one]) for name, one in zip(names, shown, strict=True)}
    elif output.casefold().endswith(".svg"):
        files = {target: svg(robot, shown)}
    else:
        raise RequestError(f"{output} is no picture: name one that ends in .svg, or FOLDER/")
    for path in files:
        check_target(path, force)
    try:
        if folder:
            write_set(Path(os.path.abspath(target)), {path.name: text for path, text in files.items()})
        else:
            write_file(target, files[target].encode(), may_replace=None)
    except OutputError as problem:
        return Frames(
            robot.name,
            diagnostics=(problem.diagnostic if folder else replace(problem.diagnostic, rule="picture-file"),),
            robot=robot,
        )
    return Frames(robot.name, files=tuple(files), robot=robot, trees=tuple(shown))


def check_target(path: Path, force: bool) -> None:
    """Raise RequestError if a drawing must not be written to this file: one of other tools needs ``force``."""
    try:
        exists, is_file = os.path.lexists(path), path.is_file()
        ours = force or not is_file or may_replace(path)
    except OSError:
        return  # it is reported when the file is written
    if exists and not is_file:
        raise RequestError(f"{path} cannot be written: it is not a regular file")
    if not ours:
        raise RequestError(f"{path} exists and was not written by this tool: name another file, or add --force")

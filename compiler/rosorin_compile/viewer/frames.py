"""Compute the trees of frames of a robot with the publisher of each transform, and format them as SVG and as text."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import NOBODY, Line, Row, lines, rows, way
from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.output.atomic_files import OutputError, may_replace, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.publishers import check_modes
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, UnknownName

from .frames_picture import Tree, cells_of, frame_trees, number_whys, svg


@dataclass(frozen=True)
class FrameEdge:
    """A transform ``parent`` -> ``child`` in a tree of frames, and the ROS node that publishes the transform.

    ``why`` is the reason if ``publisher`` is None; ``when`` is a condition on modes. Values that do not apply are None.
    """

    parent: str
    child: str
    publisher: str | None
    why: str | None
    topic: str | None
    when: str | None
    joint: str | None
    type: str | None

    @classmethod
    def from_row(cls, row: Row) -> FrameEdge:
        """Create a transform from a row of the table of transforms."""
        publisher, topic = (row.publisher, row.topic) if row.is_published else (None, None)
        rest = (row.why, topic, row.when, row.joint, row.kind)
        return cls(row.parent, row.child, publisher, *(text or None for text in rest))


@dataclass(frozen=True)
class FrameSituation:
    """A tree of frames with the modes in which it is published, as text (``when``) and as on/off states (``modes``)."""

    when: str
    modes: tuple[Mapping[str, bool], ...]
    frames: tuple[str, ...]
    edges: tuple[FrameEdge, ...]


@dataclass(frozen=True)
class Frames:
    """The result of ``frames``: a tree of frames for each combination of modes in which the tree differs.

    ``files`` are the SVG files that were written. ``robot`` is None if ``diagnostics`` has errors.
    """

    name: str
    situations: tuple[FrameSituation, ...] = ()
    files: tuple[Path, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)
    trees: tuple[Tree, ...] = field(default=(), repr=False)


def frames(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    frame: str | None = None,
    publisher: str | None = None,
    modes: Mapping[str, bool] | None = None,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
) -> Frames:
    """Return the trees of frames of a robot with the publisher of each transform, or write the trees as SVG.

    Args:
        frame: Return only the path from the root to this frame.
        publisher: Return only transforms from this ROS node; ``"nobody"`` selects transforms without a publisher.
        modes: Modes that are on or off; by default, return a tree for each combination that differs.
        output: Where to write drawings: an ``.svg`` file, or a folder for one file per tree.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.frames("rosorin", frame="laser")
        >>> [(edge.parent, edge.child, edge.publisher) for edge in found.situations[0].edges][-1:]
        [('base_link', 'laser', 'tf_base_laser')]
    """
    request = Request.from_arguments(robot, arguments, packages, trust=trust)
    case, diagnostics = request.load_case()
    if case is None:
        return Frames(request.description.name, diagnostics=diagnostics)
    chosen, edges = check_modes(case.robot, modes or {}), rows(case.robot)
    every = dict.fromkeys([*case.robot.frames, *(name for row in edges for name in (row.parent, row.child))])
    publishers = dict.fromkeys([*(row.publisher for row in edges), NOBODY])
    for kind, name, names in (("frame", frame, every), ("publisher", publisher, publishers)):
        if name is not None and name not in names:
            raise UnknownName(kind, name, names)
    trees = frame_trees(case.robot, chosen)
    found = Frames(case.robot.name, diagnostics=diagnostics, robot=case.robot, trees=trees)
    if output is not None:
        return _draw(found, case.robot, os.fsdecode(output), force)
    situations = []
    for tree in trees:
        drawn = lines(tree.edges, case.robot.frames)
        drawn = drawn if frame is None else way(drawn, frame)
        shown = [FrameEdge.from_row(line.row) for line in drawn if line.row and publisher in (None, line.row.publisher)]
        here = tuple(dict.fromkeys(line.frame for line in drawn)) if publisher is None else ()
        situations.append(FrameSituation(tree.label, tree.modes, here, tuple(shown)))
    return replace(found, situations=tuple(situations))


def _draw(found: Frames, robot: Robot, output: str, force: bool) -> Frames:
    """Write all trees to an SVG file, or one SVG per tree if ``output`` is a folder (or ends with "/")."""
    target = Path(output)
    folder = output.endswith(("/", os.sep)) or target.is_dir()
    if not folder and target.suffix.lower() != ".svg":
        raise RequestError(f"{output} is not a picture: name one that ends in .svg, or FOLDER/")
    pictures = {target: found.trees}
    if folder:
        pictures = {target / f"{'_'.join(filter(None, ('frames', one.short)))}.svg": (one,) for one in found.trees}
    for path in pictures:
        check_target(path, force)
    files = {path.name: svg(robot, drawn) for path, drawn in pictures.items()}
    try:
        if folder:
            write_set(Path(os.path.abspath(target)), files)
        else:
            write_file(target, files[target.name].encode(), may_replace=None)
    except OutputError as problem:
        failure = problem.diagnostic if folder else replace(problem.diagnostic, rule="picture-file")
        return replace(found, diagnostics=(*found.diagnostics, failure), trees=())
    return replace(found, files=tuple(pictures))


def check_target(path: Path, force: bool) -> None:
    """Raise RequestError if the file exists and this tool did not write it, unless ``force`` is true."""
    with suppress(OSError):  # an unreadable path is reported when the file is written
        if os.path.lexists(path) and not path.is_file():
            raise RequestError(f"{path} cannot be written: it is not a regular file")
        if not force and path.is_file() and not may_replace(path):
            raise RequestError(f"{path} exists and was not written by this tool: name another file, or add --force")


_HEADS = ("published by", "topic", "joint", "")
_OPTIONAL = ("joint", "topic")  # columns to omit, in this order, if the terminal is too narrow
BOLD, _DIM, _PLAIN = "\033[1m", "\033[2m", "\033[0m"
# ANSI codes of blue, yellow, green, magenta, cyan and red, then of their bright variants.
_COLOURS = ("34", "33", "32", "35", "36", "31", "94", "93", "92", "95", "96", "91")
_GAP = "  "


class Look(NamedTuple):
    """Options for text output: ASCII only, publishers to colour (if any), maximum width in columns (0: no limit)."""

    ascii: bool = False
    publishers: Sequence[str] = ()
    width: int = 0

    def paint(self, text: str, code: str) -> str:
        """Return a text with an ANSI colour code, or unchanged if colours are off."""
        return f"{code}{text}{_PLAIN}" if self.publishers and text else text


def tree(lines: Sequence[Line], look: Look) -> list[str]:
    """Format a tree of frames as lines of text."""
    before: list[str] = []  # by line: the start of the lines of its children
    entries = []
    solid, dashed, corner, side, bar = ("--", "..", "`", "|", "|") if look.ascii else ("──", "╌╌", "└", "├", "│")
    for line in lines:
        start = below = ""
        if line.on >= 0:
            branch = dashed if line.row is not None and not line.row.is_published else solid
            start = f"{before[line.on]}{corner if line.last else side}{branch} "
            below = f"{before[line.on]}{' ' if line.last else bar}   "
        before.append(below)
        entries.append(((f"{start}{line.frame}{' (above)' if line.up else ''}",), line.row, len(start)))
    return _columns(("frame", *_HEADS), entries, look)


def table(rows: Sequence[Row], look: Look) -> list[str]:
    """Format transforms as a table, without drawing the tree."""
    return _columns(("from", "to", *_HEADS), [((row.parent, row.child), row, 0) for row in rows], look)


def _columns(heads: Sequence[str], entries: Sequence[tuple[tuple[str, ...], Row | None, int]], look: Look) -> list[str]:
    """Format table rows (first cells, transform for the other cells or None, indentation) below the headers."""
    whys = number_whys(row for _, row, _ in entries)
    shown = [(dict(zip(heads, heads, strict=True)), _DIM, 0)]
    for first, row, indent in entries:
        cells, colour = ["", "", "", ""], BOLD if row is None else _DIM
        if row is not None:
            who, topic, joint, when = cells_of(row, whys).values()
            cells = [who, topic or "-", joint, f"when {when}" if when else ""]
            if row.publisher in look.publishers:
                colour = f"\033[{_COLOURS[look.publishers.index(row.publisher) % len(_COLOURS)]}m"
        shown.append((dict(zip(heads, (*first, *cells), strict=True)), colour, indent))
    widths = {head: max(text_width(cells[head]) for cells, _, _ in shown) for head in heads}
    left_out = []
    for head in _OPTIONAL:
        used = [width for width in widths.values() if width]
        if 0 < look.width < sum(used) + len(_GAP) * (len(used) - 1):
            left_out.append(head)
            del widths[head]
    lines = []
    for texts, colour, indent in shown:
        text = _GAP.join(texts[head] + " " * (width - text_width(texts[head])) for head, width in widths.items())
        lines.append(text[:indent] + look.paint(text[indent:].rstrip(), colour))
    lines += [look.paint(f"(no room for: {', '.join(left_out)})", _DIM)] if left_out else []
    return lines + [look.paint(f"({number}) {why}", _DIM) for why, number in whys.items()]


def text_width(text: str) -> int:
    """Return the width of a text in terminal columns; East Asian characters take two columns."""
    shown = [letter for letter in text if unicodedata.category(letter) not in ("Mn", "Me", "Cf")]
    return sum(2 if unicodedata.east_asian_width(letter) in ("W", "F") else 1 for letter in shown)

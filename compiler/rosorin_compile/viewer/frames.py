"""The trees of frames of a robot with the publisher of each transform: as values, as text and as SVG.

There is a tree for each combination of modes in which the tree differs. In the SVG (``viewer/frames.svg.jinja``), each
line of a tree (a frame) is a group ``<g class="line">`` with the values of the frame in ``data-`` attributes.
"""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.format import NODES, UNPUBLISHED, Format, OutputEntry, xml_syntax
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.model.frame_tree import NOBODY, Line, Row, lines, publishers, rows, way
from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.output.atomic_files import OutputError, may_replace, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.publishers import MAX_MODES, check_modes, holds, modes_in
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, Suggestion, UnknownName, error

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

_MAX_TREES = 32  # maximum number of trees in a picture
# Colours that are distinct for colour-blind readers and dark enough for lines on white, based on the palettes of
# Okabe and Ito (https://jfly.uni-koeln.de/color) and of Paul Tol (https://personal.sron.nl/~pault).
_PALETTE = (
    *("#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#56b4e9", "#882255", "#332288", "#44aa99"),
    *("#999933", "#cc6677", "#117733"),
)
_COLUMNS = ("publisher", "topic", "joint", "when")  # columns to the right of the tree
_MARGIN, _COLUMN_GAP, _INDENT, _ROW, _LEGEND = 22.0, 30.0, 32.0, 27.0, 520.0  # pixels, as in the template


class FrameEdge(NamedTuple):
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


@dataclass(frozen=True)
class FrameSituation:
    """A tree of frames with the modes in which it is published, as text (``when``) and as on/off states (``modes``)."""

    when: str
    modes: tuple[Mapping[str, bool], ...]
    frames: tuple[str, ...] = ()
    edges: tuple[FrameEdge, ...] = ()
    rows: tuple[Row, ...] = field(default=(), repr=False)  # the transforms
    short: str = field(default="", repr=False)  # ``when`` for file names, such as "slam_on"


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
    nodes = dict.fromkeys([*(row.publisher for row in edges), NOBODY])
    for kind, name, names in (("frame", frame, every), ("publisher", publisher, nodes)):
        if name is not None and name not in names:
            raise UnknownName(kind, name, names)
    trees = frame_trees(case.robot, chosen)
    found = Frames(case.robot.name, diagnostics=diagnostics, robot=case.robot)
    if output is not None:
        return _draw(found, case.robot, trees, os.fsdecode(output), force)
    situations = []
    for tree in trees:
        drawn = lines(tree.rows, case.robot.frames)
        drawn = drawn if frame is None else way(drawn, frame)
        shown = [line.row for line in drawn if line.row and publisher in (None, line.row.publisher)]
        here = tuple(dict.fromkeys(line.frame for line in drawn)) if publisher is None else ()
        situations.append(replace(tree, frames=here, edges=tuple(map(_edge, shown))))
    return replace(found, situations=tuple(situations))


def _edge(row: Row) -> FrameEdge:
    publisher, topic = (row.publisher, row.topic) if row.is_published else (None, None)
    rest = (row.why, topic, row.when, row.joint, row.kind)
    return FrameEdge(row.parent, row.child, publisher, *(text or None for text in rest))


def _draw(found: Frames, robot: Robot, trees: Sequence[FrameSituation], output: str, force: bool) -> Frames:
    """Write all trees to an SVG file, or one SVG per tree if ``output`` is a folder (or ends with "/")."""
    target = Path(output)
    pictures, is_folder = {target: trees}, output.endswith(("/", os.sep)) or target.is_dir()
    if is_folder:
        pictures = {target / f"{'_'.join(filter(None, ('frames', one.short)))}.svg": (one,) for one in trees}
    elif target.suffix.lower() != ".svg":
        raise RequestError(f"{output} is not a picture: name one that ends in .svg, or FOLDER/")
    for path in pictures:
        check_target(path, force)
    try:
        if is_folder:
            write_set(Path(os.path.abspath(target)), {path.name: svg(robot, one) for path, one in pictures.items()})
        else:
            write_file(target, svg(robot, trees).encode(), may_replace=None)
    except OutputError as problem:
        failure = problem.diagnostic if is_folder else replace(problem.diagnostic, rule="picture-file")
        return replace(found, diagnostics=(*found.diagnostics, failure))
    return replace(found, files=tuple(pictures))


def check_target(path: Path, force: bool) -> None:
    """Raise RequestError if the file exists and this tool did not write it, unless ``force`` is true."""
    with suppress(OSError):  # an unreadable path is reported when the file is written
        if os.path.lexists(path) and not path.is_file():
            raise RequestError(f"{path} cannot be written: it is not a regular file")
        if not force and path.is_file() and not may_replace(path):
            raise RequestError(f"{path} exists and was not written by this tool: name another file, or add --force")


_HEADS = ("published by", "topic", "joint", "")
BOLD, _DIM, _PLAIN = "\033[1m", "\033[2m", "\033[0m"
# ANSI codes of blue, yellow, green, magenta, cyan and red, then of their bright variants.
_COLOURS = ("34", "33", "32", "35", "36", "31", "94", "93", "92", "95", "96", "91")


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
    for head in ("joint", "topic"):  # omit these columns, in this order, if the terminal is too narrow
        used = [width for width in widths.values() if width]
        if 0 < look.width < sum(used) + 2 * (len(used) - 1):
            left_out.append(head)
            del widths[head]
    lines = []
    for texts, colour, indent in shown:
        text = "  ".join(texts[head] + " " * (width - text_width(texts[head])) for head, width in widths.items())
        lines.append(text[:indent] + look.paint(text[indent:].rstrip(), colour))
    lines += [look.paint(f"(no room for: {', '.join(left_out)})", _DIM)] if left_out else []
    return lines + [look.paint(f"({number}) {why}", _DIM) for why, number in whys.items()]


class TooMany(RequestError):
    """Raised if the frames depend on too many modes, or have too many different trees, for a picture."""

    def __str__(self) -> str:
        return f"{self.args[0]}; name modes: --mode NAME"


def colours(publishers: Sequence[str]) -> Mapping[str, str]:
    """Map each publisher to a colour; if there are not enough colours, they are used several times."""
    return {name: _PALETTE[at % len(_PALETTE)] for at, name in enumerate(publishers)}


def frame_trees(robot: Robot, fixed: Mapping[str, bool]) -> tuple[FrameSituation, ...]:
    """Return the different trees of frames for all states of the modes not in ``fixed``. Raises TooMany."""
    edges = rows(robot)
    used = modes_in(robot, [row.when for row in edges])
    free = len(used) - len(fixed.keys() & used)
    if free > MAX_MODES:
        raise TooMany(f"the frames depend on {free} modes together: too many to show")
    groups: dict[tuple[Row, ...], list[Mapping[str, bool]]] = {}
    for states in product(*([fixed[mode]] if mode in fixed else [True, False] for mode in used)):
        modes = dict(zip(used, states, strict=True))
        active = [row for row in edges if holds(row.when, modes)]
        # A published transform replaces an unpublished transform between the same frames.
        best = {(row.parent, row.child): row for row in sorted(active, key=lambda row: row.is_published)}
        shown = tuple(row for row in active if row.is_published or best[row.parent, row.child] is row)
        groups.setdefault(shown, []).append(modes)
    if len(groups) > _MAX_TREES:
        raise TooMany(f"the tree of frames differs in {len(groups)} combinations of modes: too many to show")
    trees: list[FrameSituation] = []
    for shown, group in groups.items():
        cubes = _cubes(group)
        words = [[f"{mode} is {'on' if on else 'off'}" for mode, on in cube.items()] for cube in cubes]
        short, taken = "_".join(words[0]).replace(" is ", "_"), {one.short.casefold() for one in trees}
        names = [short, *(f"{short}_{number}" for number in range(2, _MAX_TREES + 1))]
        short = next(name for name in names if name.casefold() not in taken)
        trees.append(FrameSituation(", or ".join(map(" and ".join, words)), tuple(cubes), rows=shown, short=short))
    return tuple(trees)


def _cubes(group: Sequence[Mapping[str, bool]]) -> list[Mapping[str, bool]]:
    """Find a short boolean expression for combinations of modes: alternatives, as required states by mode."""
    left, cubes = list(group), list[Mapping[str, bool]]()
    while left:
        cube = left[0]
        for removed in left[0]:
            wider = {mode: on for mode, on in cube.items() if mode != removed}
            if sum(wider.items() <= modes.items() for modes in group) == 2 ** (len(left[0]) - len(wider)):
                cube = wider
        left = [modes for modes in left if not cube.items() <= modes.items()]
        cubes.append(cube)
    return cubes


def svg(robot: Robot, trees: Sequence[FrameSituation]) -> str:
    """Format an SVG of all trees, one below the other."""
    panels, bottom = list[dict[str, Any]](), 72.0
    for tree in trees:
        drawn = lines(tree.rows, robot.frames)
        top = bottom + (70.0 if tree.when else 46.0)  # y coordinate of the first frame
        panels.append({"label": tree.when, "lines": drawn, "top": top})
        bottom = top + _ROW * (len(drawn) - 0.5)
    every = [line for panel in panels for line in panel["lines"]]
    whys = number_whys(line.row for line in every)
    cells = [cells_of(line.row, whys) for line in every if line.row is not None]
    columns, end = {}, max(map(right_of, every), default=_MARGIN) + _COLUMN_GAP
    for name in _COLUMNS:
        if texts := [text for row in cells if (text := row[name])]:
            columns[name] = end  # the left edge of the column
            end += max(map(_pixels, (name, *texts))) + _COLUMN_GAP
    title = f"{robot.name}: the tree of frames"
    labels = (_pixels(tree.when, 14) for tree in trees)
    width = max(end - _COLUMN_GAP, _MARGIN + max(_LEGEND, _pixels(title, 16), *labels)) + _MARGIN
    notes, letters = list[str](), int((width - 2 * _MARGIN) / _pixels("m"))
    for why, number in whys.items():
        room = letters if why.isascii() else letters // 2
        notes += wrap(f"({number}) nobody: {why}", room, subsequent_indent="    ", break_on_hyphens=False)
    values = {"title": title, "width": width, "bottom": bottom, "panels": panels, "columns": columns, "notes": notes}
    values["n"] = lambda number: f"{round(number, 1):.10g}"
    values |= {"colours": colours(publishers(rows(robot))), "whys": whys, "right_of": right_of, "cells_of": cells_of}
    return Templates.own("viewer/frames.svg.jinja", values)


def number_whys(edges: Iterable[Row | None]) -> dict[str, int]:
    """Return footnote numbers for the reasons why no ROS node publishes a transform."""
    return {why: at for at, why in enumerate(dict.fromkeys(row.why for row in edges if row and row.why), 1)}


def right_of(line: Line) -> float:
    """Return the x coordinate (pixels) of the right edge of the box of a frame in a line of the tree."""
    return _MARGIN + _INDENT * line.depth + _pixels(f"{line.frame} (again)" if line.again else line.frame) + 16.0


def cells_of(row: Row, whys: Mapping[str, int]) -> dict[str, str]:
    """Return the table cells of a transform by column; ``whys`` has footnote numbers by reason."""
    return {
        "publisher": f"{row.publisher} ({whys.get(row.why)})" if row.why else row.publisher,
        "topic": row.topic if row.is_published else "",
        "joint": f"{row.joint} ({row.kind})" if row.joint else "",
        "when": row.when,
    }


def text_width(text: str) -> int:
    """Return the width of a text in columns of a monospace font; East Asian characters take two columns."""
    if text.isascii():
        return len(text)
    shown = [letter for letter in text if unicodedata.category(letter) not in ("Mn", "Me", "Cf")]
    return sum(2 if unicodedata.east_asian_width(letter) in ("W", "F") else 1 for letter in shown)


def _pixels(text: str, size: float = 12.0) -> float:
    return 0.61 * size * text_width(text)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Format the trees of frames as SVG: for the modes in the option ``modes``, or for all combinations of modes."""
    on = output.options.get("modes")
    try:
        return svg(robot, frame_trees(robot, {} if on is None else {mode: mode in on for mode in robot.modes})), []
    except TooMany as problem:
        help = 'write an output for each picture, with "modes: [NAME, ...]"'
        return "", [error("too-many-pictures", str(problem.args[0]), None, help)]


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Report a file name that does not end in .svg, and unknown modes."""
    path: tuple[str, ...] = ("outputs", output.name)
    if not output.file.casefold().endswith(".svg"):
        message = f'the picture "{output.file}" has no supported file name extension'
        yield case.problem("picture-kind", message, (*path, "file"), "use a file name that ends in .svg")
    for index, mode in enumerate(output.options.get("modes", ())):
        if mode not in case.robot.modes:
            help = Suggestion(mode, case.robot.modes, f'add "{mode}" to modes')
            yield case.problem("unknown-mode", f'there is no mode "{mode}"', (*path, "modes", index), help)


FORMAT = Format(
    name="frames_picture",
    word="picture of the frames",
    article="a",
    about="the tree of frames, with who publishes each",
    rank=80,
    covers=(
        *NODES,
        *UNPUBLISHED,
        *("robot", "joints.type", "joints.parent", "joints.child", "sensors.type", "sensors.parent", "sensors.frame"),
        *("sensors.joint", "sensors.optical.frame", "sensors.optical.joint", "edges.parent", "edges.child"),
        *("edges.publisher", "edges.moving", "edges.when", "publishers.node"),
    ),
    options={
        "modes": {
            "type": "array",
            "description": "Active modes; default: a frame tree for each combination of modes.",
            "items": {"$ref": "#/$defs/name"},
        }
    },
    file="frames.svg",
    endings=(".svg",),
    check=check,
    write=write,
    asked=lambda *source: OutputEntry({"file": "frames.svg"}),  # noqa: ARG005
    syntax=xml_syntax,
    shown=False,
)

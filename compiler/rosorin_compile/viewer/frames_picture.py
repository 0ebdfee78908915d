"""frames_picture: an SVG of the trees of frames, one for each combination of modes with a different tree.

This module computes the layout for the template ``viewer/frames.svg.jinja``. Each line of the tree (a frame) is a group
``<g class="line">`` with the values of the frame in ``data-`` attributes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count, product
from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.format import NODES, UNPUBLISHED, Format, OutputEntry, xml_syntax
from rosorin_compile.model import Output, Robot
from rosorin_compile.model.frame_tree import NOBODY, Line, Row, lines, publishers, rows
from rosorin_compile.rules.publishers import MAX_MODES, holds, modes_in
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, Suggestion, error
from rosorin_compile.source.wording import plural

if TYPE_CHECKING:
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.rules.case import Case


_MAX_TREES = 32  # maximum number of trees in a picture
# Colours that are distinct for colour-blind readers and dark enough for lines on white, based on the palettes of
# Okabe and Ito (https://jfly.uni-koeln.de/color) and of Paul Tol (https://personal.sron.nl/~pault).
PALETTE = (
    *("#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#56b4e9", "#882255", "#332288", "#44aa99"),
    *("#999933", "#cc6677", "#117733"),
)
GREY = "#8c959f"  # colour of transforms without a publisher

_SIZE = 12.0  # font size in pixels
_ROW, _INDENT, _PAD, _STEP = 27.0, 32.0, 8.0, 22.0
_MARGIN, _GAP, _HEAD = 22.0, 26.0, 56.0
_COLUMNS = {"publisher": "published by", "topic": "topic", "joint": "joint", "when": "when"}


# Line width (pixels) and legend of each kind of transform.
_STYLES: Mapping[str, dict[str, Any]] = {
    "moving": {"width": 2.6, "dashed": False, "about": "moving, on /tf"},
    "static": {"width": 1.2, "dashed": False, "about": "static, on /tf_static"},
    NOBODY: {"width": 1.4, "dashed": True, "about": "nobody: in the description, not in tf2"},
}


class TooMany(RequestError):
    """Raised if the frames depend on too many modes, or have too many different trees, for a picture."""

    def __str__(self) -> str:
        return f"{self.args[0]}; name modes: --mode NAME"


class Tree(NamedTuple):
    """The transforms of a tree of frames, and the modes in which they are published.

    ``label`` describes the modes, such as "slam is on", or is ""; ``short`` is the same for file names ("slam_on").
    """

    label: str
    short: str
    modes: tuple[Mapping[str, bool], ...]
    edges: tuple[Row, ...]


def colours(publishers: Sequence[str]) -> Mapping[str, str]:
    """Map each publisher to a colour; if there are not enough colours, they are used several times."""
    return {name: PALETTE[at % len(PALETTE)] for at, name in enumerate(publishers)}


def frame_trees(robot: Robot, fixed: Mapping[str, bool]) -> tuple[Tree, ...]:
    """Return the different trees of frames for all states of the modes not in ``fixed``. Raises TooMany."""
    edges = rows(robot)
    used = modes_in(robot, [row.when for row in edges])
    varied = [mode for mode in used if mode not in fixed]
    if len(varied) > MAX_MODES:
        raise TooMany(f"the frames depend on {len(varied)} modes together: too many to show")
    groups: dict[tuple[Row, ...], list[tuple[bool, ...]]] = {}
    for states in product((True, False), repeat=len(varied)):
        modes = {**fixed, **dict(zip(varied, states, strict=True))}
        active = [row for row in edges if holds(row.when, modes)]
        # A published transform replaces an unpublished transform between the same frames.
        best = {(row.parent, row.child): row for row in sorted(active, key=lambda row: row.is_published)}
        shown = tuple(row for row in active if row.is_published or best[row.parent, row.child] is row)
        groups.setdefault(shown, []).append(states)
    if len(groups) > _MAX_TREES:
        raise TooMany(f"the tree of frames differs in {len(groups)} combinations of modes: too many to show")
    trees: list[Tree] = []
    for shown, group in groups.items():
        known = [{**fixed, **{varied[at]: on for at, on in cube.items()}} for cube in _cubes(group)]
        named = tuple({mode: states[mode] for mode in used if mode in states} for states in known)
        words = [" and ".join(f"{mode} is {'on' if on else 'off'}" for mode, on in states.items()) for states in named]
        short = "_".join(f"{mode}_{'on' if on else 'off'}" for mode, on in named[0].items())
        taken = {tree.short.casefold() for tree in trees}
        if short.casefold() in taken:
            short = next(name for at in count(2) if (name := f"{short}_{at}").casefold() not in taken)
        trees.append(Tree(", or ".join(words), short, named, shown))
    return tuple(trees)


def _cubes(group: Sequence[tuple[bool, ...]]) -> list[dict[int, bool]]:
    """Find a short boolean expression for combinations of modes: alternatives, as required states by mode index."""
    left, cubes = list(group), []
    while left:
        cube = dict(enumerate(left[0]))
        for at in range(len(left[0])):
            wider = {mode: on for mode, on in cube.items() if mode != at}
            size = 2 ** (len(left[0]) - len(wider))
            if sum(all(states[mode] == on for mode, on in wider.items()) for states in group) == size:
                cube = wider
        left = [states for states in left if any(states[mode] != on for mode, on in cube.items())]
        cubes.append(cube)
    return cubes


def svg(robot: Robot, trees: Sequence[Tree]) -> str:
    """Format an SVG of all trees, one below the other."""
    from rosorin_compile.formats.templating import Templates

    drawn = [lines(tree.edges, robot.frames) for tree in trees]
    every = [line for panel in drawn for line in panel]
    edges = [line.row for line in every if line.row is not None]
    whys = number_whys(edges)
    colour = colours(publishers(rows(robot)))
    title = f"{robot.name}: the tree of frames"

    # Compute the left edges of the columns to the right of the tree, and the right edge of the last column.
    columns, end = {}, max(map(right_of, every), default=_MARGIN) + _GAP
    for name, head in _COLUMNS.items():
        columns[name] = end
        texts = [text for row in edges if (text := cells_of(row, whys)[name])]
        if texts:
            end += max(map(text_width, (head, *texts))) + _GAP + (14.0 if name == "publisher" else 0.0)

    panels = [_panel(tree, part) for tree, part in zip(trees, drawn, strict=True)]
    # Place the legend: publishers with their colours, wrapped to rows, and the kinds of lines.
    keys = [name for name in colour if any(row.publisher == name for row in edges)]
    styles = [style for name, style in _STYLES.items() if name != NOBODY or any(not row.is_published for row in edges)]
    limit = max(
        end - _GAP,
        *(panel["count_x"] + text_width(panel["count"]) for panel in panels),
        *(_MARGIN + text_width(title, 16), *(_MARGIN + 30 + text_width(name) for name in keys)),
        _MARGIN + sum(58 + text_width(style["about"]) for style in styles) - 20,
    )
    x, y, placed_keys = _MARGIN, 58.0, []
    for name in keys:
        if x > _MARGIN and x + 14 + text_width(name) > limit:
            x, y = _MARGIN, y + _STEP
        placed_keys.append((name, x, y))
        x += 34 + text_width(name)
    styles_y = y + (_STEP if keys else 0.0)

    top = styles_y + 14
    for panel in panels:
        panel["top"] = top
        top += _HEAD + _ROW * len(panel["lines"])
    bottom, notes = top + (24 if whys else 0), []
    for why, at in whys.items():
        notes.append((f"({at})", _MARGIN, bottom))
        letters = max(1, int((limit - _MARGIN - 34) / text_width("m" if why.isascii() else "\u6f22")))
        for words in wrap(f"nobody: {why}", letters, break_on_hyphens=False):
            notes.append((words, _MARGIN + 34, bottom))
            bottom += 18
    size = {"width": limit + _MARGIN, "height": bottom + (6 if whys else 12)}
    legend = {"title": title, "keys": placed_keys, "styles": styles, "styles_y": styles_y, "notes": notes}
    looks = {"colours": colour, "grey": GREY, "styles_of": _STYLES, "heads": _COLUMNS, "columns": columns, "whys": whys}
    functions = {function.__name__: function for function in (right_of, cells_of, text_width, short_number)}
    return Templates.own("viewer/frames.svg.jinja", {**size, **legend, **looks, **functions, "panels": panels})


def _panel(tree: Tree, drawn: Sequence[Line]) -> dict[str, Any]:
    edges = [line.row for line in drawn if line.row is not None]
    frames, styles = len({line.frame for line in drawn}), Counter(row.style for row in edges)
    kinds = {"moving": "moving", "static": "static", NOBODY: "published by nobody"}
    counts = [f"{styles[style]} {text}" for style, text in kinds.items() if styles[style]]
    return {
        "label": tree.label,
        "lines": drawn,
        "count": ", ".join([f"{frames} {plural('frame', frames)}", *counts]),
        "count_x": _MARGIN + (text_width(tree.label, 14) + 18 if tree.label else 0.0),
        "last": {line.on: at for at, line in enumerate(drawn) if line.on >= 0},
        "used": {name for row in edges for name, cell in cells_of(row, {}).items() if cell},
    }


def number_whys(edges: Iterable[Row | None]) -> dict[str, int]:
    """Return footnote numbers for the reasons why no ROS node publishes a transform."""
    return {why: at for at, why in enumerate(dict.fromkeys(row.why for row in edges if row and row.why), 1)}


def right_of(line: Line) -> float:
    """Return the x coordinate (pixels) of the right edge of the frame name in a line of the tree."""
    name = f"{line.frame} (again)" if line.again else line.frame
    return _MARGIN + _INDENT * line.depth + text_width(name) + 2 * _PAD


def cells_of(row: Row, whys: Mapping[str, int]) -> dict[str, str]:
    """Return the table cells of a transform by column; ``whys`` has footnote numbers by reason."""
    return {
        "publisher": f"{row.publisher} ({whys.get(row.why)})" if row.why else row.publisher,
        "topic": row.topic if row.is_published else "",
        "joint": f"{row.joint} ({row.kind})" if row.joint else "",
        "when": row.when,
    }


def text_width(text: str, size: float = _SIZE) -> float:
    """Estimate the width of a text in pixels, for a monospace font of ``size`` pixels."""
    return sum(0.61 if letter.isascii() else 1.1 for letter in text) * size


def short_number(value: float) -> str:
    """Format a number with one decimal, or without decimals if the decimal is zero."""
    return f"{value:.1f}".removesuffix(".0")


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

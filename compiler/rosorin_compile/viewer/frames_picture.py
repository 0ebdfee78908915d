"""frames_picture: the tree of frames as SVG, one line per frame; the same robot gives the same bytes.

This module computes where each text and line is, ``templates/viewer/frames.svg.jinja`` writes it. Each line of the tree
is a group ``<g class="line">`` whose ``data-`` attributes have its values.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.format import Asked, Format, xml_syntax
from rosorin_compile.formats.unsupported import NODES, UNPUBLISHED
from rosorin_compile.model import Output, Robot
from rosorin_compile.model.frame_tree import NOBODY, Line, Row, lines, publishers, rows
from rosorin_compile.source.diagnostics import Diagnostic, Suggestion, error
from rosorin_compile.source.rule_registry import OUTPUTS, Rule
from rosorin_compile.source.wording import plural

from .frame_trees import GREY, TooMany, Tree, colours, frame_trees

if TYPE_CHECKING:
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.rules.case import Case

RULES = (
    Rule("picture-kind", "The file name of a picture does not end in `.svg`.", "End it in `.svg`.", OUTPUTS),
    Rule(
        "too-many-pictures",
        "The tree of frames differs in more combinations of modes than one picture can show.",
        "Fix `modes`, one picture for each combination.",
        OUTPUTS,
    ),
)

_SIZE = 12.0  # of letters, in pixels
_ROW, _INDENT, _PAD, _STEP = 27.0, 32.0, 8.0, 22.0
_MARGIN, _GAP, _HEAD = 22.0, 26.0, 56.0
_COLUMNS = {"publisher": "published by", "topic": "topic", "joint": "joint", "when": "when"}


class _Style(NamedTuple):
    """The look of an edge: the width of its line, and what it means."""

    width: float
    dashed: bool
    about: str


_STYLES = {
    "moving": _Style(2.6, False, "moving, on /tf"),
    "static": _Style(1.2, False, "static, on /tf_static"),
    NOBODY: _Style(1.4, True, "nobody: in the description, not in tf2"),
}


def svg(robot: Robot, trees: Sequence[Tree]) -> str:
    """Return the picture of all trees, one below the other."""
    from rosorin_compile.formats.templating import Templates

    panels = [_Panel(tree.label, lines(tree.edges, robot.frames)) for tree in trees]
    every = [line for panel in panels for line in panel.lines]
    edges = [line.row for line in every if line.row is not None]
    whys = {why: at for at, why in enumerate(dict.fromkeys(row.why for row in edges if row.why), 1)}
    colour = colours(publishers(rows(robot)))
    title = f"{robot.name}: the tree of frames"

    # The columns next to the tree: where each begins, and where the last one ends.
    begin = [max((line_x(line) + box_width(line) for line in every), default=_MARGIN) + _GAP]
    cells = [cells_of(row, whys) for row in edges]
    for name, head in _COLUMNS.items():
        used = any(row[name] for row in cells)
        width = max(text_width(text) for text in (head, *(row[name] for row in cells))) + _GAP if used else 0.0
        begin.append(begin[-1] + width + (14.0 if used and name == "publisher" else 0.0))

    # The legend: publishers with their colours, as many in a row as there is room for, and the kinds of lines.
    keys = [name for name in colour if any(row.publisher == name for row in edges)]
    styles = [style for name, style in _STYLES.items() if name != NOBODY or any(not row.published for row in edges)]
    limit = max(
        begin[-1] - _GAP,
        *(panel.count_x + text_width(panel.count) for panel in panels),
        *(_MARGIN + text_width(title, 16), *(_MARGIN + 30 + text_width(name) for name in keys)),
        _MARGIN + sum(58 + text_width(style.about) for style in styles) - 20,
    )
    x, y, placed_keys = _MARGIN, 58.0, []
    for name in keys:
        if x > _MARGIN and x + 14 + text_width(name) > limit:
            x, y = _MARGIN, y + _STEP
        placed_keys.append((name, x, y))
        x += 34 + text_width(name)
    y += _STEP if keys else 0.0

    tops = [y + 14]
    for panel in panels:
        tops.append(tops[-1] + _HEAD + _ROW * len(panel.lines))
    bottom, notes = tops[-1] + (24 if whys else 0), []
    for why, at in whys.items():
        notes.append((f"({at})", _MARGIN, bottom))
        letters = max(1, int((limit - _MARGIN - 34) / text_width("m" if why.isascii() else "\u6f22")))
        for words in wrap(f"nobody: {why}", letters, break_on_hyphens=False):
            notes.append((words, _MARGIN + 34, bottom))
            bottom += 18
    functions = (line_x, box_width, name_of, cells_of, text_width, shortened)
    values = {
        "title": title,
        "width": limit + _MARGIN,
        "height": bottom + (6 if whys else 12),
        "keys": placed_keys,
        "colours": colour,
        "grey": GREY,
        "styles": styles,
        "styles_of": _STYLES,
        "styles_y": y,
        "heads": _COLUMNS,
        "columns": dict(zip(_COLUMNS, begin, strict=False)),
        "panels": list(zip(panels, tops, strict=False)),
        "whys": whys,
        "notes": notes,
    }
    values |= {function.__name__: function for function in functions}
    return Templates.own("viewer/frames.svg.jinja", values)


class _Panel(NamedTuple):
    """One tree of the picture."""

    label: str
    lines: Sequence[Line]

    @property
    def count(self) -> str:
        """The number of frames, and of edges of each kind."""
        frames = len({line.frame for line in self.lines})
        styles = Counter(line.row.style for line in self.lines if line.row is not None)
        counts = [f"{frames} {plural('frame', frames)}"]
        counts += [f"{styles[style]} {style}" for style in ("moving", "static") if styles[style]]
        return ", ".join(counts + ([f"{styles[NOBODY]} published by nobody"] if styles[NOBODY] else []))

    @property
    def count_x(self) -> float:
        """Where this number begins, next to the label."""
        return _MARGIN + (text_width(self.label, 14) + 18 if self.label else 0.0)

    def uses(self, column: str) -> bool:
        """Return True if an edge of the tree has a cell in a column."""
        return any(line.row is not None and cells_of(line.row)[column] for line in self.lines)

    @property
    def last(self) -> dict[int, int]:
        """The index of the last line that hangs on each line."""
        return {line.on: at for at, line in enumerate(self.lines) if line.on >= 0}


def line_x(line: Line) -> float:
    """Return where the box of a frame begins."""
    return _MARGIN + _INDENT * line.depth


def box_width(line: Line) -> float:
    """Return the width of the box of a frame."""
    return text_width(name_of(line)) + 2 * _PAD


def name_of(line: Line) -> str:
    """Return the name in the box of a frame."""
    return f"{line.frame} (again)" if line.again else line.frame


def cells_of(row: Row, whys: Mapping[str, int] = {}) -> dict[str, str]:
    """Return the cells of an edge by column."""
    return {
        "publisher": f"{row.publisher} ({whys[row.why]})" if row.why in whys else row.publisher,
        "topic": row.topic if row.published else "",
        "joint": f"{row.joint} ({row.kind})" if row.joint else "",
        "when": row.when,
    }


def text_width(text: str, size: float = _SIZE) -> float:
    """Return the width of a text (pixels). A letter of a monospace font is 0.6 of its size wide, others are wider."""
    return sum(0.61 if letter.isascii() else 1.1 for letter in text) * size


def shortened(value: float) -> str:
    """Return a number with one decimal place, or none where it is zero."""
    return f"{value:.1f}".removesuffix(".0")


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the picture of a robot. Option ``modes``: modes that are on; by default a tree for each combination."""
    on = output.options.get("modes")
    try:
        return svg(robot, frame_trees(robot, {} if on is None else {mode: mode in on for mode in robot.modes})), []
    except TooMany as problem:
        help = "say which modes are on, one picture each: modes: [NAME, ...]"
        return "", [error("too-many-pictures", str(problem), None, help)]


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Report another kind of picture, and modes that do not exist."""
    path: tuple[str, ...] = ("outputs", output.name)
    if not output.file.casefold().endswith(".svg"):
        message = f'"{output.file}" does not say which kind of picture it is'
        yield case.problem("picture-kind", message, (*path, "file"), "end its name in .svg")
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
            "description": "The modes that are on, the others are off; default: a tree for every situation.",
            "items": {"$ref": "#/$defs/name"},
        }
    },
    file="frames.svg",
    endings=(".svg",),
    check=check,
    write=write,
    asked=lambda *source: Asked({"file": "frames.svg"}),  # noqa: ARG005
    syntax=xml_syntax,
    shown=False,
)

"""The tree of frames: one row for each edge, with who publishes it; and the rows as a tree.

The tree is a list of lines, parents above children, each frame once. What draws it for terminals and for pictures is a
format (``formats.frames``, and those with pictures); for a notebook it is a table in HTML, here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.wording import and_more

from .joint import STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Publisher

if TYPE_CHECKING:
    from .robot import Robot

NOBODY = "nobody"
TF, TF_STATIC, NO_TOPIC = "/tf", "/tf_static", "none"


class Row(NamedTuple):
    """One transform: ``why`` says why nobody publishes it, ``when`` in which modes somebody does ("" is always).

    ``first`` is the parent in the first row of this child, by which a second one is told apart; ``joint`` and ``kind``
    are empty for the transforms of other nodes.
    """

    parent: str
    child: str
    publisher: str
    why: str
    topic: str
    when: str
    first: str
    joint: str = ""
    kind: str = ""

    @property
    def published(self) -> bool:
        """Whether tf2 knows the edge."""
        return self.topic != NO_TOPIC

    @property
    def who(self) -> str:
        """The publisher in the words of the list of frames: "nobody: why" where there is none."""
        return f"{self.publisher}: {self.why}" if self.why else self.publisher

    @property
    def style(self) -> str:
        """How the edge is drawn: moving, static or nobody."""
        return {TF: "moving", TF_STATIC: "static"}.get(self.topic, NOBODY)


def rows(robot: Robot) -> tuple[Row, ...]:
    """Return all edges: joints from the root down, then the transforms of other nodes, as the list of frames has them.

    What only simulations have is no frame.
    A joint that somebody else publishes under the same parent is one edge with that transform, and named there.
    """
    first: dict[str, str] = {}
    table: list[Row] = []
    joints = robot.joints_down()
    for joint in joints:
        if joint.child in robot.simulated_frames:
            continue
        first.setdefault(joint.child, joint.parent)
        if joint.name in robot.turns and joint.publisher.kind == UNPUBLISHED:
            continue  # its publishers are edges below, each in its modes
        publishing = _publishing(joint.publisher, joint.moves_on_tf)
        table.append(Row(joint.parent, joint.child, *publishing, "", first[joint.child], joint.name, joint.type))
    named = {(joint.parent, joint.child): joint for joint in joints}
    for edge in robot.edges:
        first.setdefault(edge.child, edge.parent)
        publishing = _publishing(edge.publisher, edge.moving)
        same = named.get((edge.parent, edge.child))
        own = (same.name, same.type) if same is not None else ("", "")
        table.append(Row(edge.parent, edge.child, *publishing, edge.when, first[edge.child], *own))
    return tuple(table)


def _publishing(publisher: Publisher, moving: bool) -> tuple[str, str, str]:
    """Return who publishes, why nobody does, and the topic."""
    if publisher.kind == UNPUBLISHED:
        return NOBODY, " ".join(publisher.about.split()), NO_TOPIC
    return publisher.name, "", TF if moving and publisher.kind != STATIC_TRANSFORM_PUBLISHER else TF_STATIC


def publishers(edges: tuple[Row, ...]) -> tuple[str, ...]:
    """Return who publishes something, in the order of the rows; nobody is none of them."""
    return tuple(dict.fromkeys(row.publisher for row in edges if row.published))


class Line(NamedTuple):
    """A line of the tree: the frame that it shows, and the edge that leads there (None for a root).

    ``on`` is the number of the line that it hangs on (-1 for a root), ``last`` whether no other hangs there below it.
    ``up`` says that the frame is the parent in ``row``: tf2 has another parent for the child. Then ``again`` says that
    the frame has a line of its own besides.
    """

    frame: str
    row: Row | None
    depth: int
    on: int
    last: bool
    up: bool = False
    again: bool = False


class _Grown(NamedTuple):
    """The parts of a tree: the row into each frame, the children of each, and rows that are no part of the tree."""

    into: dict[str, Row]
    below: dict[str, list[str]]
    more: dict[str, list[Row]]


def lines(edges: Sequence[Row], frames: Iterable[str]) -> list[Line]:
    """Return the tree of edges and further frames. The parent of a frame is that of tf2, if it has one.

    A frame that only stands above another in the description, on no topic, hangs below that other one.
    """
    names = list(dict.fromkeys([*frames, *(name for row in edges for name in (row.parent, row.child))]))
    grown = _grow(edges)
    lone = _lone(names, grown)
    drawn: list[Line] = []
    # What waits: the frame, its row, the line that it hangs on, whether it is the last there, whether it stands above.
    roots = [name for name in names if name not in grown.into and name not in lone]
    steps: list[tuple[str, Row | None, int, bool, bool]]
    steps = [(name, None, -1, at == 0, False) for at, name in enumerate(reversed(roots))]
    while steps:
        name, row, on, last, up = steps.pop()
        depth = drawn[on].depth + 1 if on >= 0 else 0
        again = up and name not in lone
        drawn.append(Line(name, row, depth, on, last, up, again))
        if up:
            continue
        hanging = [(other.parent, other, True) for other in grown.more.get(name, ())]
        hanging += [(child, grown.into[child], False) for child in grown.below.get(name, ())]
        here = len(drawn) - 1
        steps += [(frame, edge, here, at == 0, is_up) for at, (frame, edge, is_up) in enumerate(reversed(hanging))]
    return drawn


def _grow(edges: Sequence[Row]) -> _Grown:
    """Return the tree of tf2, with what only the description knows added where a frame has no parent yet."""
    into: dict[str, Row] = {}
    more: dict[str, list[Row]] = {}
    for row in sorted(edges, key=lambda row: not row.published):
        if row.child in into or row.child == row.parent or _above(into, row.parent, row.child):
            more.setdefault(row.child, []).append(row)
        else:
            into[row.child] = row
    below: dict[str, list[str]] = {}
    for row in edges:
        if into.get(row.child) is row:
            below.setdefault(row.parent, []).append(row.child)
    return _Grown(into, below, more)


def _above(into: dict[str, Row], frame: str, other: str) -> bool:
    """Say whether ``other`` is above a frame, or is it."""
    while frame != other and frame in into:
        frame = into[frame].parent
    return frame == other


def _lone(names: Sequence[str], grown: _Grown) -> set[str]:
    """Return the frames that have no line but as the parent in one row that is no part of the tree."""
    parents = Counter(row.parent for rows in grown.more.values() for row in rows)
    hung = grown.into.keys() | grown.below.keys() | grown.more.keys()
    return {name for name in names if parents[name] == 1 and name not in hung}


def way(tree: Sequence[Line], frame: str) -> list[Line]:
    """Return the lines from a root to a frame; none if the tree does not have it."""
    at = next((at for at, line in enumerate(tree) if line.frame == frame and not line.again), -1)
    upwards: list[Line] = []
    while at >= 0:
        upwards.append(tree[at])
        at = tree[at].on
    return upwards[::-1]


# A page with more is no longer looked at, but still makes the browser slow.
MOST = 500
_HEADS = ("frame", "published by", "topic", "joint", "when")
_LEFT = "text-align: left"


def html(robot: Robot) -> str:
    """Return the tree of frames in all modes; every name is escaped."""
    from html import escape  # not at the top: it brings thousands of entities along

    tree = lines(rows(robot), robot.frames)
    heads = "".join(f'<th style="{_LEFT}">{head}</th>' for head in _HEADS)
    body = "".join(map(_line, tree[:MOST]))
    if len(tree) > MOST:
        body += f'<tr><td colspan="{len(_HEADS)}">{and_more(len(tree) - MOST).strip()}</td></tr>'
    caption = f'<caption style="{_LEFT}">{escape(repr(robot)[1:-1])}</caption>'
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


def _line(line: Line) -> str:
    """Return one row; a frame that stands above another in some modes only is told from the tree by an arrow."""
    from html import escape

    row = line.row
    name = f"\u2191 {line.frame}" if line.up else line.frame
    cells = ["", "", "", ""]
    if row is not None:
        joint = f"{row.joint} ({row.kind})" if row.joint else ""
        cells = [row.who, row.topic if row.published else "", joint, row.when]
    indent = f"{_LEFT}; padding-left: {0.5 + 1.5 * min(line.depth, 40)}em"
    others = "".join(f'<td style="{_LEFT}">{escape(cell)}</td>' for cell in cells)
    return f'<tr><td style="{indent}">{escape(name)}</td>{others}</tr>'

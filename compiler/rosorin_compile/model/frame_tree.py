"""The transforms of a robot with their publishers, as rows of a table and as lines of a printed tree."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.wording import and_more

if TYPE_CHECKING:
    from .robot import Robot

NOBODY = "nobody"
TF, TF_STATIC, NO_TOPIC = "/tf", "/tf_static", "none"
_MAX_HTML_ROWS = 500
_LEFT = "text-align: left"


class Row(NamedTuple):
    """A transform parent -> child and its publisher, as a row of a table."""

    parent: str
    child: str
    publisher: str
    why: str  # why no node publishes the transform, or ""
    topic: str
    when: str  # condition on modes under which the transform is published, or "" for always
    first: str  # parent in the first row with this child; may differ from ``parent`` in later rows
    joint: str = ""  # joint that connects parent and child, or ""
    kind: str = ""  # type of that joint, or ""

    @property
    def is_published(self) -> bool:
        return self.topic != NO_TOPIC

    @property
    def who(self) -> str:
        return f"{self.publisher}: {self.why}" if self.why else self.publisher

    @property
    def style(self) -> str:
        return {TF: "moving", TF_STATIC: "static"}.get(self.topic, NOBODY)


def rows(robot: "Robot") -> tuple[Row, ...]:
    """Return a row for each transform: joints from the root down, then transforms that other nodes publish.

    Links that exist only in simulations are omitted.
    """
    joints = {(joint.parent, joint.child): joint for joint in robot.joints_down()}
    first = {child: parent for parent, child in joints if child not in robot.simulated_frames}
    table = list[Row]()
    for edge in (*robot.joint_edges(), *robot.edges):
        joint = joints.get((edge.parent, edge.child))
        names = (joint.name, joint.type) if joint is not None else ("", "")
        who, why = edge.publisher.name, ""
        if not edge.publisher.publishes:
            who, why = NOBODY, " ".join(edge.publisher.about.split())
        top = first.setdefault(edge.child, edge.parent)
        table.append(Row(edge.parent, edge.child, who, why, edge.topic, edge.when, top, *names))
    return tuple(table)


def publishers(edges: tuple[Row, ...]) -> tuple[str, ...]:
    """Return the names of the publishers, without duplicates, in the order of the rows."""
    return tuple(dict.fromkeys(row.publisher for row in edges if row.is_published))


class Line(NamedTuple):
    """A line of the printed tree: a frame, and the transform that connects the frame to the frame in line ``on``."""

    frame: str
    row: Row | None  # None for a root
    depth: int
    on: int  # index of the line that this line is indented under; -1 for a root
    last: bool  # True for the last line that is indented under line ``on``
    up: bool = False  # True if the frame is a second parent of the frame in line ``on``
    again: bool = False  # True if ``up`` is True and the frame also has a regular line


def lines(edges: Sequence[Row], frames: Iterable[str]) -> list[Line]:
    """Lay out frames as the lines of a printed tree, with children under their parents.

    ``edges`` are the rows of the transforms. ``frames`` are included even if they are in no row. A frame with several
    parents is under its first published parent; each further parent has an extra line (``Line.up``) under the frame.
    """
    names = list(dict.fromkeys([*frames, *(name for row in edges for name in (row.parent, row.child))]))
    into: dict[str, Row] = {}
    more: dict[str, list[Row]] = {}  # by child: rows with a further parent, and rows that would close a cycle
    for row in sorted(edges, key=lambda row: not row.is_published):
        ancestor = row.parent
        while ancestor != row.child and ancestor in into:
            ancestor = into[ancestor].parent
        if row.child in into or ancestor == row.child:
            more.setdefault(row.child, []).append(row)
        else:
            into[row.child] = row
    children: dict[str, list[str]] = {}
    for row in edges:
        if into.get(row.child) is row:
            children.setdefault(row.parent, []).append(row.child)
    # For frames that occur only once, as a further parent, the extra line is the only line.
    parents = Counter(row.parent for rows in more.values() for row in rows)
    in_tree = into.keys() | children.keys() | more.keys()
    lone = {name for name in names if parents[name] == 1 and name not in in_tree}
    drawn: list[Line] = []
    roots = [name for name in names if name not in into and name not in lone]
    waiting: list[tuple[str, Row | None, int, bool, bool]]  # frame, row, on, last, up of each ``Line`` to add
    waiting = [(name, None, -1, at == 0, False) for at, name in enumerate(reversed(roots))]
    while waiting:
        name, edge, on, last, up = waiting.pop()
        drawn.append(Line(name, edge, drawn[on].depth + 1 if on >= 0 else 0, on, last, up, up and name not in lone))
        if up:
            continue
        below = [(row.parent, row, True) for row in more.get(name, ())]
        below += [(child, into[child], False) for child in children.get(name, ())]
        here = len(drawn) - 1
        waiting += [(frame, row, here, at == 0, is_up) for at, (frame, row, is_up) in enumerate(reversed(below))]
    return drawn


def way(tree: Sequence[Line], frame: str) -> list[Line]:
    """Return the lines from a root down to a frame, or an empty list if the tree does not contain the frame."""
    at = next((at for at, line in enumerate(tree) if line.frame == frame and not line.again), -1)
    upwards: list[Line] = []
    while at >= 0:
        upwards.append(tree[at])
        at = tree[at].on
    return upwards[::-1]


def html(robot: "Robot") -> str:
    """Return the tree of frames in all modes as an HTML table for notebooks; every name is escaped."""
    from html import escape  # slow to import

    tree, body = lines(rows(robot), robot.frames), ""
    for line in tree[:_MAX_HTML_ROWS]:
        row, name = line.row, f"\u2191 {line.frame}" if line.up else line.frame
        cells = ["", "", "", ""]
        if row is not None:
            joint = f"{row.joint} ({row.kind})" if row.joint else ""
            cells = [row.who, row.topic if row.is_published else "", joint, row.when]
        body += f'<tr><td style="{_LEFT}; padding-left: {0.5 + 1.5 * min(line.depth, 40)}em">{escape(name)}</td>'
        body += "".join(f'<td style="{_LEFT}">{escape(cell)}</td>' for cell in cells) + "</tr>"
    if len(tree) > _MAX_HTML_ROWS:
        body += f'<tr><td colspan="5">{and_more(len(tree) - _MAX_HTML_ROWS).strip()}</td></tr>'
    heads = "".join(f'<th style="{_LEFT}">{h}</th>' for h in ("frame", "published by", "topic", "joint", "when"))
    caption = f'<caption style="{_LEFT}">{escape(repr(robot)[1:-1])}</caption>'
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"

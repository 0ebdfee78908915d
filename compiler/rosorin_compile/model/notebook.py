"""Notebook: the tree of frames of a robot as a table in HTML, with who publishes each edge."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from ..diagnostics.wording import and_more
from .frame_tree import Line, lines, rows

if TYPE_CHECKING:
    from .robot import Robot

# A page with more is no longer looked at, but still makes the browser slow.
MOST = 500
_HEADS = ("frame", "published by", "topic", "joint", "when")
_LEFT = "text-align: left"


def html(robot: Robot) -> str:
    """Return the tree of frames in all modes; every name is escaped."""
    tree = lines(rows(robot), [link.name for link in robot.links])
    heads = "".join(f'<th style="{_LEFT}">{head}</th>' for head in _HEADS)
    body = "".join(map(_line, tree[:MOST]))
    if len(tree) > MOST:
        body += f'<tr><td colspan="{len(_HEADS)}">{and_more(len(tree) - MOST).strip()}</td></tr>'
    caption = f'<caption style="{_LEFT}">{escape(repr(robot)[1:-1])}</caption>'
    return f"<table>{caption}<thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"


def _line(line: Line) -> str:
    """Return one row; a frame that stands above another in some modes only is told from the tree by an arrow."""
    row = line.row
    name = f"\u2191 {line.frame}" if line.up else line.frame
    cells = ["", "", "", ""]
    if row is not None:
        joint = f"{row.joint} ({row.kind})" if row.joint else ""
        cells = [row.who, row.topic if row.published else "", joint, row.when]
    indent = f"{_LEFT}; padding-left: {0.5 + 1.5 * min(line.depth, 40)}em"
    others = "".join(f'<td style="{_LEFT}">{escape(cell)}</td>' for cell in cells)
    return f'<tr><td style="{indent}">{escape(name)}</td>{others}</tr>'

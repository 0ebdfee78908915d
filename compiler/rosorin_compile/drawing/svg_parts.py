"""Parts of an SVG: texts, arrows, the legend and the notes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from .letters import GREY, escape, width, wrapped

INK, QUIET, FAINT = "#1f2328", "#59636e", "#d0d7de"

_SIZE = 12.0
_STEP = 22.0
_STYLES = (
    ("moving, on /tf", 2.6, False),
    ("static, on /tf_static", 1.2, False),
    ("nobody: in the description, not in tf2", 1.4, True),
)


class Legend(NamedTuple):
    """Parts of the picture above the trees, where they end, and how wide the picture is."""

    parts: list[str]
    bottom: float
    right: float


class Notes(NamedTuple):
    """Parts of the picture below the trees, and where they end."""

    parts: list[str]
    bottom: float


def number(value: float) -> str:
    """Return a length in pixels as text."""
    return f"{value:.1f}".removesuffix(".0")


def text(said: str, x: float, y: float, ink: str, size: float, name: str, bold: bool = False) -> str:
    """Return a text whose first letter stands at x on the line y."""
    weight = ' font-weight="600"' if bold else ""
    return (
        f'<text class="{name}" x="{number(x)}" y="{number(y)}" font-size="{size:g}" fill="{ink}"{weight}>'
        f"{escape(said)}</text>"
    )


def arrow(start: float, end: float, y: float, paint: str, thick: float, dashed: bool, back: bool) -> list[str]:
    """Return a level arrow; ``back`` points to its start."""
    head = 7.0
    line = (start + head, end) if back else (start, end - head)
    tip = f"M{number(start)} {number(y)}l7 -4.5v9z" if back else f"M{number(end)} {number(y)}l-7 -4.5v9z"
    dashes = ' stroke-dasharray="4 2.5"' if dashed else ""
    return [
        f'<path class="edge" d="M{number(line[0])} {number(y)}H{number(line[1])}" fill="none" stroke="{paint}" '
        f'stroke-width="{thick:g}"{dashes}/>',
        f'<path class="tip" d="{tip}" fill="{paint}"/>',
    ]


def legend(title: str, colour: Mapping[str, str], nobody: bool, right: float, margin: float) -> Legend:
    """Return the title, the colours of publishers and the kinds of lines; ``right`` is where the trees end."""
    widest = max([width(title, 16), *(30 + width(name, _SIZE) for name in colour)])
    styles = _STYLES if nobody else _STYLES[:2]
    row = sum(38 + width(said, _SIZE) + 20 for said, _, _ in styles)
    limit = max(right, margin + widest, margin + row - 20)
    parts = [text(title, margin, 32, INK, 16, "title", bold=True)]
    x, y = margin, 58.0
    for name, paint in colour.items():
        wide = 14 + width(name, _SIZE)
        if x > margin and x + wide > limit:
            x, y = margin, y + _STEP
        parts.append(f'<rect x="{number(x)}" y="{number(y - 9)}" width="10" height="10" rx="2" fill="{paint}"/>')
        parts.append(text(name, x + 14, y, INK, _SIZE, "key"))
        x += wide + 20
    if colour:
        y += _STEP
    x = margin
    for said, thick, dashed in styles:
        parts += arrow(x, x + 30, y - 4, GREY if dashed else INK, thick, dashed, back=False)
        parts.append(text(said, x + 38, y, QUIET, _SIZE, "key"))
        x += 38 + width(said, _SIZE) + 20
    rule = y + 14
    parts.append(f'<path d="M{number(margin)} {number(rule)}H{number(limit)}" stroke="{FAINT}"/>')
    return Legend(parts, rule, limit + margin)


def footnotes(reasons: Mapping[str, int], top: float, margin: float, room: float) -> Notes:
    """Return the numbered reasons, in lines that fit; a word that is wider than the picture is broken."""
    parts = []
    y = top + 10
    for why, at in reasons.items():
        for line, said in enumerate(wrapped(f"nobody: {why}", room - 34, _SIZE)):
            if line == 0:
                parts.append(text(f"({at})", margin, y, QUIET, _SIZE, "note"))
            parts.append(text(said, margin + 34, y, QUIET, _SIZE, "note"))
            y += 18
    return Notes(parts, y - 6)

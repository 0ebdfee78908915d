"""Report: what became words, and what stays as it is and why, in lines for the person who imports."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import and_more, first_of

from .proving import Worded

_FEW = 3
_MOST = 12


def told_words(worded: Worded) -> list[str]:
    """Return the lines about what a robot says beside links and joints; none where it says nothing."""
    lines = []
    if worded.said:
        parts = [
            f"{len(names)} {word}{'' if len(names) == 1 else 's'} ({first_of(list(names), _FEW)})"
            for word, names in worded.said.items()
        ]
        lines.append("in words, and the same when they are written again: " + ", ".join(parts))
    reasons: dict[str, list[str]] = {}
    for what, why in worded.kept.items():
        reasons.setdefault(why, []).append(what)
    told = [f"not in words: {first_of(names, _FEW)}: {why}" for why, names in reasons.items()]
    if len(told) > _MOST:
        told[_MOST:] = [f"not in words:{and_more(len(told) - _MOST)}"]
    return [*lines, *told, *worded.remarks]

"""Telling: what became of the macros and arguments of a xacro, in a few lines for the person who imports it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ....diagnostics import Span
from ....diagnostics.wording import counted, listed
from . import Translation


def told(translation: Translation) -> Iterator[str]:
    """Yield the lines about a translation."""
    if not translation.files:
        yield f"flat, without macros and arguments: {translation.reason}{_at(translation.span)}"
        return
    kept, lost = len(translation.kept), len(translation.written_out)
    if kept or lost:
        line = f"{kept} of {counted(kept + lost, 'macro')} kept"
        yield f"{line}, {lost} written out where {'it is' if lost == 1 else 'they are'} called" if lost else line
    for one in translation.written_out:
        yield f"  {one.name}: {one.reason}{_at(one.span)}"
    if translation.idle:
        them = "it" if len(translation.idle) == 1 else "them"
        yield f"left out, because nothing calls {them}: {listed(translation.idle)}"
    if translation.arguments:
        yield f"arguments kept: {listed(translation.arguments)}"
    if translation.fixed:
        them = "it changes" if len(translation.fixed) == 1 else "they change"
        said = listed([f"{name} ({value!r})" for name, value in translation.fixed])
        yield f"arguments that are none any more, because what {them} is written out as it is: {said}"
    proven = len(translation.proven)
    how = "its arguments as they are" if proven == 1 else f"{proven} combinations of its arguments"
    if translation.possible > proven + len(translation.refused):
        how += f" (of {translation.possible}: the defaults, and each argument changed alone)"
    yield f"the same robot as xacro makes it, with {how}"
    if translation.refused:
        first = " ".join(f"{name}:={value}" for name, value in translation.refused[0])
        yield f"not compared, because xacro refuses it: {first}"


def _at(span: Span | None) -> str:
    return f" ({Path(span.source.path).name}:{span.line})" if span is not None else ""

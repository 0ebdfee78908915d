"""Report: what became of the macros and arguments of a xacro, in a few lines for the person who imports it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from rosorin_compile.source.diagnostics import Span, counted, listed

from . import WITHIN, Translation, WrittenOut


def translation_report(translation: Translation) -> Iterator[str]:
    """Yield the lines about a translation."""
    if not translation.files:
        yield f"flat, without macros and arguments: {translation.reason}{_at(translation.span)}"
        return
    macros = [one for one in translation.written_out if not one.name.startswith("<")]
    kept, lost = len(translation.kept), len({one.name for one in macros})
    if kept or lost:
        line = f"{kept} of {counted(kept + lost, 'macro')} kept"
        yield f"{line}, {lost} written out where {'it is' if lost == 1 else 'they are'} called" if lost else line
    yield from _reasons(macros)
    yield from _elements(translation)
    if translation.idle:
        them = "it" if len(translation.idle) == 1 else "them"
        yield f"left out, because nothing calls {them}: {listed(translation.idle)}"
    if translation.arguments:
        yield f"arguments kept: {listed(translation.arguments)}"
    if translation.unused:
        them = "it" if len(translation.unused) == 1 else "them"
        yield f"arguments left out, because nothing uses {them}: {listed(translation.unused)}"
    if translation.environment:
        yield f"variables of the environment that are arguments now: {listed(translation.environment)}"
    if translation.fixed:
        them = "it" if len(translation.fixed) == 1 else "them"
        said = listed([f"{name} ({' '.join(value.split())})" if value else name for name, value in translation.fixed])
        yield f"arguments replaced by their value, because expanded elements depend on {them}: {said}"
    frozen = [one for one in translation.frozen if one.reason]
    for reason, names in groupby(frozen, lambda one: f"{one.reason}{_at(one.span)}"):
        yield f"  {listed([one.name for one in names])}: {reason}"
    yield from translation.shared
    proven = len(translation.proven)
    how = "its arguments as they are" if proven == 1 else f"{proven} combinations of its arguments"
    if translation.possible > proven + len(translation.refused):
        how += f" (of {translation.possible}: the defaults, and each argument changed alone)"
    yield f"the same robot as xacro makes it, with {how}"
    if translation.refused:
        first = " ".join(f"{name}:={value}" for name, value in translation.refused[0])
        yield f"not compared, because xacro refuses it: {first}"


def _elements(translation: Translation) -> Iterator[str]:
    """Yield the lines about elements that stand elsewhere than in the xacro, or as it expands them."""
    elements = [one for one in translation.written_out if one.name.startswith("<")]
    lifted, flat = ([one for one in elements if one.flat == is_flat] for is_flat in (False, True))
    if lifted:
        where = "its part" if len(lifted) == 1 else "their parts"
        yield f"at the top, not in {where}: {counted(len(lifted), 'element')}"
    yield from _reasons(lifted)
    if flat:
        yield f"as xacro expands {'it' if len(flat) == 1 else 'them'}: {counted(len(flat), 'element')}"
    yield from _reasons(flat)


def _reasons(lost: Sequence[WrittenOut]) -> Iterator[str]:
    within = [one.name for one in lost if one.reason == WITHIN]
    for one in lost:
        if one.reason != WITHIN:
            yield f"  {one.name}: {one.reason}{_at(one.span)}"
    if within:
        yield f"  {listed(within)}: {WITHIN if len(within) == 1 else WITHIN.replace(' it ', ' them ')}"


def _at(span: Span | None) -> str:
    return f" ({Path(span.source.path).name}:{span.line})" if span is not None else ""

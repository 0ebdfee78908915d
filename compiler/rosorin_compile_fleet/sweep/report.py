"""Report: what a person sees of a sweep. Errors at once, each with its variant; what many variants have, once.

All that there is to say of a variant stands in its line of the index, and is taken from there.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from io import TextIOWrapper
from itertools import islice
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import ERROR as WRONG
from rosorin_compile.diagnostics import Console, Diagnostic, Progress, Related, Source, Span, and_more, counted
from rosorin_compile.extending import world

from .folder import Stored
from .making import ERROR, MADE, UNCHANGED, Made
from .running import Counts, duration
from .variants import Row

MAX_FAILED = 20  # variants whose errors are shown
MAX_KINDS = 500  # different remarks that are kept


class _Kind(NamedTuple):
    """A remark that several variants have: the first of them, and how many they are."""

    diagnostic: Diagnostic
    first: str
    many: int


class Teller:
    """Shows errors as they come, and keeps the rest for the end."""

    def __init__(self, console: Console) -> None:
        self.console = console
        self.kinds: dict[str, _Kind] = {}
        self.failed = 0
        self.lost = 0
        self.stand_ins: dict[str, int] = {}

    def take(self, made: Made) -> None:
        """Take what there is to say of one variant."""
        if made.state == ERROR:
            self.failed += 1
        elif '"diagnostics": []' in made.line[-20:]:
            return
        entry = json.loads(made.line)
        shown = self.failed <= MAX_FAILED
        for one in entry["diagnostics"]:
            if one["severity"] == WRONG:
                if shown:
                    self.console.show([_named(read(one), entry["name"])])
                continue
            key = json.dumps(one)
            known = self.kinds.get(key)
            if known is not None:
                self.kinds[key] = known._replace(many=known.many + 1)
            elif len(self.kinds) < MAX_KINDS:
                self.kinds[key] = _Kind(read(one), entry["name"], 1)
            else:
                self.lost += 1

    def finish(self, counts: Counts, stored: Stored) -> None:
        """Show what is left to say, and the table."""
        self.console.show([_of_many(kind, counts.total) for kind in self.kinds.values()])
        if self.lost:
            self.console.warn(f"{counted(self.lost, 'more remark')}: sweep.json has them all")
        if self.failed > MAX_FAILED:
            more = counted(self.failed - MAX_FAILED, "more variant")
            self.console.warn(f"{more} with errors: sweep.json has them all")
        for line in table(counts, stored):
            self.console.say(line)


def table(counts: Counts, stored: Stored) -> Iterator[str]:
    """Yield the table at the end."""
    yield f"made      {counts.by_state[MADE]:>10,}"
    yield f"unchanged {counts.by_state[UNCHANGED]:>10,}"
    yield f"errors    {counts.by_state[ERROR]:>10,}"
    if stored.objects:
        yield f"distinct artifacts {stored.objects:,}, {_size(stored.size)}"
    if counts.worked and counts.seconds > Progress.AFTER:  # of less a person knows it, and a script reads no clock
        each = 1e3 * counts.seconds / counts.worked
        yield f"{duration(counts.seconds)}, {each:,.0f} ms a variant"


def _size(size: int) -> str:
    """Return a number of bytes as a person says it.

    >>> _size(999), _size(12_345), _size(2_000_000)
    ('999 bytes', '12.3 kB', '2.0 MB')
    """
    for unit, factor in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            return f"{size / factor:,.1f} {unit}"
    return f"{size:,} bytes"


def _named(diagnostic: Diagnostic, variant: str) -> Diagnostic:
    return replace(diagnostic, message=f"{variant}: {diagnostic.message}")


def _of_many(kind: _Kind, total: int) -> Diagnostic:
    """Return a remark with the variants that have it."""
    diagnostic, first, count = kind
    whose = f"all {counted(total, 'variant')}" if count == total > 1 else f"{first}{and_more(count - 1)}"
    return replace(diagnostic, message=f"{whose}: {diagnostic.message}")


def read(entry: Mapping[str, Any]) -> Diagnostic:
    """Return a diagnostic as it stands in a line of the index, with the line of its file."""
    related = tuple(Related(one["message"], _span(one)) for one in entry["related"])
    return Diagnostic(entry["rule"], entry["severity"], entry["message"], _span(entry), related, entry["help"])


def _span(entry: Mapping[str, Any]) -> Span | None:
    if "file" not in entry:
        return None
    try:
        version = world.version(entry["file"])
    except OSError:
        version = ""
    source = _line(entry["file"], entry["line"], version)
    return Span(source, entry["line"], entry["column"], entry["length"])


@lru_cache(maxsize=1_000)
def _line(path: str, number: int, version: str) -> Source:  # noqa: ARG001 - of a file as it is now
    """Return one line of a file; an empty one of a file that is not there any more."""
    text = ""
    try:
        with TextIOWrapper(world.stream(path), encoding="utf-8-sig", errors="replace") as file:
            text = next(islice(file, number - 1, None), "")
    except (OSError, ValueError):
        pass
    row = Row(path, text.rstrip("\n"))
    row.first = number
    return row

"""Stand-ins: values that hold a place until somebody knows better. Each is named by every run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import OUTPUTS, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import first_of

from .case import Case

SHOWN = 8


@rule(
    "stand-in",
    "A note: a value is not known and something holds its place.",
    "Measure it, and change its `source`.",
    OUTPUTS,
)
def listed_once(case: Case) -> Iterator[Diagnostic]:
    """Name each stand-in once, by its text, with all the places that it stands in for."""
    by_note: dict[str, list[Path]] = {}
    for path, entry in case.remarkable.stand_ins:
        by_note.setdefault(entry["source"].get("note", ""), []).append(path)
    for note, paths in by_note.items():
        names = first_of([_name(path) for path in paths], SHOWN)
        message = f"{note or 'nothing says what is missing'} ({names})"
        place = (*paths[0], "source", "note" if note else "status")
        found_here = case.problem("stand-in", message, place, severity=NOTE)
        yield replace(found_here, related=())


def _name(path: Path) -> str:
    """Return the entry at a path in few words: joint1 limit, base_footprint collision[0]."""
    if not path:
        return "the robot"
    words = ""
    for step in path[1:] if len(path) > 1 and not isinstance(path[1], int) else path:
        words += f"[{step}]" if isinstance(step, int) else f" {step}"
    return words.strip()

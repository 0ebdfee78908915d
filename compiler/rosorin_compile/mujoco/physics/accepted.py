"""What a description accepts of the findings about its physics: by the rule, and by the names of links and joints.

A note that sums up many pairs or joints is made of those that nobody accepts by name; each of the others goes with it
as a diagnostic of its own, which ``Case.settled`` takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import accepts
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

Member = TypeVar("Member")


def apart(
    case: Case, rule: str, members: Iterable[Member], names: Callable[[Member], Sequence[str]]
) -> tuple[list[Diagnostic], list[Member]]:
    """Return of what goes into one note a diagnostic for each that is accepted, and the others."""
    taken: list[Diagnostic] = []
    left: list[Member] = []
    for member in members:
        found = Diagnostic(rule, NOTE, "", of=tuple(names(member)))
        if accepts(case, found):
            taken.append(found)
        else:
            left.append(member)
    return taken, left

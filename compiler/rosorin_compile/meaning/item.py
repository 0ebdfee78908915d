"""Values of a comparison of two robots: the sides, what differs, and what cannot be compared.

Numbers, lengths and lists stand here as the lines of a comparison say them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ..diagnostics import Diagnostic
from ..diagnostics.wording import first_of
from ..formats import Format
from ..model import Robot
from ..numbers import exact
from ..project import ENDINGS
from .tolerance import EXACT, Printing
from .wording import amount, number_pair, step

# A description has a word for everything, and is no artifact.
YAML = Format(name="yaml", word="description", article="a", endings=ENDINGS, takes_arguments=True)
DEFAULT_TOLERANCE = 1e-9


class Side(NamedTuple):
    """One of two robots: as it was named, the format that it was read from, and how well its numbers are known."""

    label: str
    format: Format
    robot: Robot
    printing: Printing = EXACT
    folder: Path | None = None


# Kinds of differences, the most important ones first: what moves and where, then what it may do, weighs, looks like.
FRAME, JOINT, LIMIT, MASS, SHAPE, VISUAL, NAME, OTHER = (
    "frame",
    "joint",
    "limit",
    "mass",
    "shape",
    "visual",
    "name",
    "other",
)
KINDS = (FRAME, JOINT, LIMIT, MASS, SHAPE, VISUAL, NAME, OTHER)

Scalar = float | str | None


@dataclass(frozen=True)
class Item:
    """One difference: of which kind, of what, in words, and as values in SI units.

    ``name`` is the link or joint, as A calls it, or B where it is new. ``distance`` (m) and ``angle`` (rad) say how far
    a frame is off, ``when`` at which positions of the joints, ``at`` where it is off the most.
    """

    kind: str
    name: str
    quantity: str
    text: str
    before: Scalar = None
    after: Scalar = None
    unit: str = ""
    distance: float | None = None
    angle: float | None = None
    when: str = ""
    at: Mapping[str, float] = field(default_factory=dict)


class Difference(NamedTuple):
    """How two robots differ by meaning; ``notes`` say what is written differently and means the same.

    ``a`` and ``b`` are None where they could not be read, or not be compared: then ``diagnostics`` has errors.
    """

    a: Side | None
    b: Side | None
    items: tuple[Item, ...]
    notes: tuple[str, ...]
    not_compared: tuple[str, ...]
    tolerance: float
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def sides(self) -> tuple[Side, Side]:
        """The two robots that were compared. Raises ValueError if one of them could not be read."""
        if self.a is None or self.b is None:
            raise ValueError("one of the two could not be read: see diagnostics")
        return self.a, self.b

    @property
    def same(self) -> bool:
        """Whether both could be read, and nothing that was compared differs."""
        return not self.items and self.a is not None and self.b is not None

    def __str__(self) -> str:
        """Return the lines that the command line prints; what keeps from comparing, if anything does."""
        from .robots import lines

        return "\n".join(lines(self, full=True))

    def __repr__(self) -> str:
        """Return the answer alone."""
        from .robots import summary

        return f"<Difference: {summary(self)}>"


_MOST = 3


def number(value: float, other: float | None = None) -> str:
    """Return a number in print, with the digits that tell it from another one."""
    if other is not None and other != value:
        return number_pair(value, other)[0]
    return exact(float(f"{value:.6g}"))


def row(values: Iterable[float]) -> str:
    """Return numbers in a row."""
    return " ".join(number(value) for value in values)


def far(distance: float, angle: float, verbs: bool = False) -> str:
    """Return a length (m) and an angle (rad), each only if it is not zero.

    >>> far(0.002, 0.0), far(0.0, 0.01), far(0.002, 0.01, verbs=True)
    ('2.0 mm', '0.57 deg', 'moved 2.0 mm and turned 0.57 deg')
    """
    values = (("moved ", distance, "m"), ("turned ", angle, "rad"))
    parts = [f"{verb if verbs else ''}{amount(value, unit)}" for verb, value, unit in values if value > 1e-12]
    return " and ".join(parts) or "0 mm"


def several(names: Sequence[str]) -> str:
    """Return the first names of a list and the number of the others."""
    return first_of(names, _MOST)


def changed(kind: str, name: str, quantity: str, values: tuple[float | None, float | None], unit: str) -> Item:
    """Return the line about a number that changed; None is a number that is not given."""
    old, new = values
    subject = f"{name} {quantity}"
    if old is None or new is None:
        said = number(old if new is None and old is not None else new or 0.0)
        text = f"{subject}: {'removed, was' if new is None else 'new,'} {said} {unit}".rstrip()
        return Item(kind, name, quantity, text, old, new, unit)
    before, after = number_pair(old, new)
    remark = step(new - old, old, unit)
    text = f"{subject} {before} -> {after} {unit}".rstrip() + (f" ({remark})" if remark else "")
    return Item(kind, name, quantity, text, old, new, unit)

"""Values of a comparison of two robots: the sides, what differs, and what cannot be compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ..diagnostic import Diagnostic
from ..emit import Format
from ..model import Robot
from ..project import ENDINGS
from .printing import EXACT, Printing

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
        from .text import lines

        return "\n".join(lines(self, full=True))

    def __repr__(self) -> str:
        """Return the answer alone."""
        from .text import summary

        return f"<Difference: {summary(self)}>"

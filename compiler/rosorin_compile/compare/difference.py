"""The result of comparing two robots: the differences, and the values that cannot be compared.

It is printed as text, or as JSON that conforms to ``schemas/robot_diff.schema.json``.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats import Format
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.project import ENDINGS
from rosorin_compile.source.wording import count_of, plural, printable

from .precision import POSE_NOISE, Precision, exact

# A placeholder for the format of YAML descriptions, which can express all values.
YAML = Format(name="yaml", word="description", article="a", endings=ENDINGS, takes_arguments=True)
DEFAULT_TOLERANCE = POSE_NOISE


class Side(NamedTuple):
    """One of the two robots of a comparison."""

    label: str  # name or file for messages
    format: Format
    robot: Robot
    printing: Precision = exact  # largest errors of the numbers in its file
    folder: Path | None = None


# Kinds of differences, the most important first: frames and joints, then limits and masses, then shapes and the rest.
FRAME, JOINT, LIMIT, MASS = "frame", "joint", "limit", "mass"
SHAPE, VISUAL, NAME, OTHER = "shape", "visual", "name", "other"
KINDS = (FRAME, JOINT, LIMIT, MASS, SHAPE, VISUAL, NAME, OTHER)

Scalar = float | str | None


class Item(NamedTuple):
    """A difference between robots A and B, as a sentence and as values in SI units."""

    kind: str
    name: str  # name of the link or joint in A, or in B if only B has it
    quantity: str  # what differs, such as "origin"
    text: str  # the sentence
    before: Scalar = None
    after: Scalar = None
    unit: str = ""
    distance: float | None = None  # how far a frame or a shape moved (m)
    angle: float | None = None  # by which angle it turned (rad)
    when: str = ""  # joint positions at which the robots differ: "always" or "away from 0"
    at: Mapping[str, float] = {}  # {joint: position} (rad or m) of the largest difference


class Report(NamedTuple):
    """The lists to which the parts of a comparison add their results."""

    items: list[Item]
    notes: list[str]
    not_compared: list[str]  # values that a format lacks


@dataclass(frozen=True)
class Difference:
    """The result of comparing two robots: ``items`` are differences with an effect, ``notes`` describe others.

    ``a`` and ``b`` are None if a robot could not be read or compared; ``diagnostics`` contains the errors.
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
        """True if both robots could be read and no compared value differs."""
        return not self.items and self.a is not None and self.b is not None

    def summary(self) -> str:
        """Return the number of differences of each kind in one line, or "not compared" after errors."""
        if self.a is None or self.b is None:
            return "not compared"
        if self.same:
            return "the same robot, as far as it was compared"
        counts = Counter(item.kind for item in self.items)
        words = {kind: _WORDS.get(kind, (kind, plural(kind, 2))) for kind in KINDS}
        found = [f"{counts[kind]} {words[kind][counts[kind] > 1]}" for kind in KINDS if counts[kind]]
        return f"different: {', '.join(found)}"

    def __str__(self) -> str:
        """Return the lines that the command line prints, or the errors that prevent a comparison."""
        return "\n".join(lines(self, full=True))

    def __repr__(self) -> str:
        return f"<Difference: {self.summary()}>"


_WORDS = {SHAPE: ("set of collision shapes", "sets of collision shapes"), OTHER: ("other thing", "other things")}
# The maximum number of differences in text output; JSON has all differences.
_MOST = 200


def lines(difference: Difference, full: bool = False) -> list[str]:
    """Format a comparison as lines of text, the most important differences first; ``full`` lists all of them."""
    if difference.a is None or difference.b is None:
        return [*(str(diagnostic) for diagnostic in difference.diagnostics), difference.summary()]
    shown = []
    for letter, side in (("A", difference.a), ("B", difference.b)):
        joints = sum(not joint.is_fixed for joint in side.robot.joints)
        sizes = f"{count_of(len(side.robot.links), 'link')}, {joints:,} that move{'s' if joints == 1 else ''}"
        shown.append(f"{letter}: {side.label} ({side.format.word} of {side.robot.name}, {sizes})")
    shown += [item.text for item in difference.items]
    if not full and len(difference.items) > _MOST:
        shown[2 + _MOST :] = [f"... {count_of(len(difference.items) - _MOST, 'more difference')} (--full shows them)"]
    shown += [f"note: {note}" for note in difference.notes]
    shown += [f"not compared: {line}" for line in difference.not_compared]
    return [printable(line, keep="\t") for line in [*shown, difference.summary()]]

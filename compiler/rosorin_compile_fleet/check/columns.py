"""The numbers of a fleet: of each fact and each argument one column, with a value for each robot where it differs.

An artifact is read by its format's ``facts``, each distinct text once: equal artifacts have equal sums. As a sweep has
proven that the artifacts of a robot say the same, a number is read from one of them, and no artifact is read that adds
nothing. What is kept is what differs from the first robot that has the artifact; of very many robots with very many
different numbers it is kept of some that are drawn, and of those with the largest and the smallest numbers.
"""

from __future__ import annotations

import hashlib
import math
import os
import re
import zlib
from array import array
from collections import OrderedDict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile import Fact, Facts, Format
from rosorin_compile.extending import FORMATS, Quantity, world
from rosorin_compile.model import Pose, Transform

from .spread import is_same
from .sweep_file import Variant

MOST = 2_000_000  # values that are kept
MOST_READ = 1_000_000  # values of artifacts that may come again
MOST_TEXTS = 40  # different texts of one thing
_EXTREMES = 8  # robots with the smallest and with the largest number
_BLOCK = 1 << 20
_STEEP = math.radians(75)  # pitch: beyond it roll and yaw are no numbers that can be compared
_SHAPE = re.compile(r"(collision|visual|cell) \d.*")

_LARGEST = 1e300  # no number is larger
_FEW_DIGITS = 1e-9  # numbers that are not known better have been rounded to a few digits

# What readers raise for a text that is none of their format, or damaged.
_DAMAGED = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, SyntaxError)

ARGUMENT = "argument"


class Column(NamedTuple):
    """One number of all robots that are kept: ``values`` by their order, NaN where a robot has none.

    ``extremes`` are robots that are not kept, with their values. ``files`` are the artifacts that show it.
    """

    fact: Fact
    unit: str
    tolerance: float
    values: list[float]
    extremes: list[tuple[int, float]]
    files: tuple[str, ...]


class Read(NamedTuple):
    """What an artifact says otherwise than the first one of its name: numbers and texts, and facts that it lacks."""

    numbers: tuple[tuple[Fact, float], ...]
    texts: tuple[tuple[Fact, str], ...]
    missing: tuple[Fact, ...]
    problem: str = ""


class _First:
    """The first artifact of a name: its format and its facts, and the frames whose roll and yaw say nothing."""

    def __init__(self, format: Format | None, facts: Facts, size: int) -> None:
        self.format = format
        self.size = size
        pitches = ((fact.name, value.value) for fact, value in facts.items() if fact[::2] == ("frame", "pitch"))
        steep = [name for name, pitch in pitches if isinstance(pitch, float) and abs(pitch) > _STEEP]
        self.steep = {name: _rotation(facts, name) for name in steep}
        self.facts = self.turned(facts)

    def turned(self, facts: Facts) -> Facts:
        """Return facts in which a frame that looks up or down has the turn from that of the first robot."""
        for name, first in self.steep.items():
            keys = Fact.angles(name)
            if not all(key in facts for key in keys):
                continue
            axis, angle = first.turn_to(_rotation(facts, name))
            old = facts[keys[0]]
            for key in keys:
                del facts[key]
            for letter, part in zip("xyz", axis, strict=True):
                facts[Fact("frame", name, f"turn {letter}")] = old._replace(value=part * angle)
        return facts


def _rotation(facts: Facts, frame: str) -> Transform:
    found = map(facts.get, Fact.angles(frame))
    roll, pitch, yaw = (float(value.value) if value else 0.0 for value in found)
    return Pose(rpy=(roll, pitch, yaw)).transform()


class Said:
    """A text that some robots have: how many, and the first of them."""

    def __init__(self) -> None:
        self.count = 0
        self.robots: list[int] = []

    def add(self, robot: int) -> None:
        """Take down one more robot."""
        self.count += 1
        if len(self.robots) < MOST_TEXTS:
            self.robots.append(robot)


class Columns:
    """The numbers of all robots, taken one robot after the other.

    ``texts`` are those that differ from the first robot's in ``usual_texts``; ``plain`` the sums of artifacts that no
    format reads, by name.
    """

    def __init__(self) -> None:
        self.robots: list[str] = []
        self.texts: dict[Fact, dict[str, Said]] = {}
        self.usual_texts: dict[Fact, str] = {}
        self.plain: dict[str, set[str]] = {}
        self._firsts: dict[str, _First] = {}
        self._chosen: dict[frozenset[str], tuple[str, ...]] = {}
        self._arguments: list[Fact] = []
        self._owner: dict[Fact, str] = {}
        self._lacking: dict[str, set[int]] = {}
        self._files: dict[Fact, list[str]] = {}
        self._base: dict[Fact, float] = {}
        self._units: dict[Fact, tuple[str, float]] = {}
        self._values: dict[Fact, tuple[array[int], array[float]]] = {}
        self._ends: dict[Fact, tuple[list[tuple[float, int]], list[tuple[float, int]]]] = {}
        self._read: OrderedDict[tuple[str, str], Read] = OrderedDict()
        self._held = 0
        self._kept = 0
        self._mask = 0

    @property
    def drawn(self) -> list[int]:
        """The robots that are kept, in their order."""
        return [at for at, name in enumerate(self.robots) if self._is_drawn(name)]

    def take(self, variant: Variant, texts: Texts) -> list[tuple[str, str]]:
        """Take the numbers of a robot; return the artifacts that cannot be read, each with the reason."""
        robot = len(self.robots)
        self.robots.append(variant.name)
        self._take_arguments(robot, variant.arguments)
        present = [name for name in variant.artifacts if texts.is_there(variant, name)]
        chosen = self._to_read(variant, present, texts)
        problems = []
        for name in chosen:
            read = self._reading(variant, name, texts)
            if read.problem:
                problems.append((name, read.problem))
            else:
                self._take_read(robot, name, read, chosen)
        for name in self._lacking.keys() - set(chosen):
            self._lacking[name].add(robot)
        for name in present:
            if self._firsts[name].format is None:
                self.plain.setdefault(name, set()).add(variant.artifacts[name])
        return problems

    def columns(self) -> Iterator[Column]:
        """Yield the numbers that differ between robots, in the order in which they came."""
        drawn = self.drawn
        place = {robot: at for at, robot in enumerate(drawn)}
        lacking = {name: [place[robot] for robot in robots if robot in place] for name, robots in self._lacking.items()}
        lost = [fact for fact, owner in self._owner.items() if lacking.get(owner) and fact in self._base]
        for fact in dict.fromkeys([*self._values, *lost]):
            values = [self._base[fact]] * len(drawn)
            for at in lacking.get(self._owner.get(fact, ""), ()):
                values[at] = math.nan
            for robot, number in zip(*self._values.get(fact, ((), ())), strict=True):
                if robot in place:
                    values[place[robot]] = number
            ends = {robot: value for end in self._ends.get(fact, ()) for value, robot in end if robot not in place}
            unit, tolerance = self._units.get(fact, ("", 0.0))
            every = [value for value in (*values, *ends.values()) if math.isfinite(value)]
            if every and not is_same(min(every), max(every)) and max(every) - min(every) > 2 * tolerance:
                yield Column(fact, unit, tolerance, values, sorted(ends.items()), tuple(self._files.get(fact, ())))

    def count(self) -> int:
        """Return how many numbers the artifacts have."""
        return sum(fact.kind != ARGUMENT for fact in self._base)

    def _take_arguments(self, robot: int, arguments: Mapping[str, Any]) -> None:
        seen = set()
        for path, said in flat(arguments):
            fact = Fact(ARGUMENT, path, "")
            seen.add(fact)
            found = _number(said)
            if found is None:
                self._take_text(fact, robot, str(said))
                continue
            number, unit = found
            if unit:
                self._units[fact] = (unit, 0.0)
            if fact not in self._base:
                self._arguments.append(fact)
                self._begin(fact, robot, number if robot == 0 else math.nan, number)
            self._put(fact, robot, number)
        for fact in self._arguments:
            if fact not in seen:
                self._put(fact, robot, math.nan)

    def _take_read(self, robot: int, name: str, read: Read, chosen: tuple[str, ...]) -> None:
        """Take what an artifact says otherwise than the first one; all of what is read from one that is not here."""
        numbers = dict(read.numbers)
        for fact, number in numbers.items():
            if self._owner.setdefault(fact, name) == name:
                self._put(fact, robot, number)
        for fact, text in read.texts:
            if self._owner.setdefault(fact, name) == name:
                self._take_text(fact, robot, text)
        for fact in read.missing:
            if self._owner.get(fact) == name:
                self._put(fact, robot, math.nan) if fact in self._base else self._take_text(fact, robot, "")
        if all(owner in chosen for owner in self._lacking):
            return
        missing = set(read.missing)
        for fact, value in self._firsts[name].facts.items():
            if self._owner.get(fact, name) not in chosen and fact not in missing and not isinstance(value.value, str):
                self._put(fact, robot, numbers.get(fact, float(value.value)), always=True)

    def _to_read(self, variant: Variant, present: list[str], texts: Texts) -> tuple[str, ...]:
        """Return the artifacts whose numbers are read: those that say something that no other one says."""
        key = frozenset(present)
        if key not in self._chosen:
            for name in present:
                if name not in self._firsts:
                    self._first(variant, name, texts)
            self._chosen[key] = _cover({name: self._firsts[name] for name in present})
            for name in self._chosen[key]:
                self._lacking.setdefault(name, set(range(len(self.robots) - 1)))
            self._own(self._chosen[key])
        return self._chosen[key]

    def _first(self, variant: Variant, name: str, texts: Texts) -> None:
        text = texts.read(variant, name)
        format, facts = recognised(name, text)
        self._firsts[name] = first = _First(format, facts, len(text))
        for fact in first.facts:
            self._files.setdefault(fact, []).append(name)

    def _own(self, chosen: tuple[str, ...]) -> None:
        """Say from which artifact each fact is read: of several from the one that prints it best."""
        robot = len(self.robots) - 1
        for name in sorted(chosen, key=lambda name: not _is_exact(self._firsts[name].facts)):
            for fact, value in self._firsts[name].facts.items():
                if fact in self._owner:
                    continue
                self._owner[fact] = name
                if isinstance(value.value, str):
                    self.usual_texts.setdefault(fact, value.value)
                else:
                    self._units[fact] = (value.unit, value.tolerance)
                    self._begin(fact, robot, float(value.value), float(value.value))

    def _reading(self, variant: Variant, name: str, texts: Texts) -> Read:
        key = (name, variant.artifacts[name])
        if key in self._read:
            self._read.move_to_end(key)
            return self._read[key]
        read = self._read[key] = _difference(self._firsts[name], texts.read(variant, name))
        self._held += _size(read)
        while self._held > MOST_READ and len(self._read) > 1:
            self._held -= _size(self._read.popitem(last=False)[1])
        return read

    def _take_text(self, fact: Fact, robot: int, text: str) -> None:
        found = self.texts.setdefault(fact, {})
        if text in found or len(found) < MOST_TEXTS:
            found.setdefault(text, Said()).add(robot)

    def _begin(self, fact: Fact, robot: int, base: float, number: float) -> None:
        self._base[fact] = base
        self._ends[fact] = ([(number, robot)], [(number, robot)])

    def _put(self, fact: Fact, robot: int, number: float, always: bool = False) -> None:
        if fact not in self._base:
            self._begin(fact, robot, math.nan, number)
        base = self._base[fact]
        if not always and (number == base or (math.isnan(number) and math.isnan(base))):
            return
        if not math.isnan(number):
            _keep_ends(*self._ends[fact], number, robot)
        if not self._is_drawn(self.robots[robot]):
            return
        robots, numbers = self._values.setdefault(fact, (array("l"), array("d")))
        robots.append(robot)
        numbers.append(number)
        self._kept += 1
        if self._kept > MOST:
            self._thin()

    def _is_drawn(self, name: str) -> bool:
        return not self._mask or (zlib.crc32(name.encode("utf-8", "replace")) * 2654435761 >> 16) & self._mask == 0

    def _thin(self) -> None:
        """Keep half of the robots that are kept, by what their names come to: no order of a sweep lies in that."""
        self._mask = self._mask * 2 + 1
        self._kept = 0
        for fact, (robots, numbers) in self._values.items():
            kept = [(r, v) for r, v in zip(robots, numbers, strict=True) if self._is_drawn(self.robots[r])]
            self._values[fact] = (array("l", (r for r, _ in kept)), array("d", (v for _, v in kept)))
            self._kept += len(kept)


def _difference(first: _First, text: str) -> Read:
    """Return what a text says otherwise than the first one of its name."""
    assert first.format is not None  # noqa: S101 - it was chosen
    assert first.format.facts is not None  # noqa: S101
    try:
        facts = first.turned(first.format.facts(text))
    except _DAMAGED as problem:
        return Read((), (), (), str(problem) or "it is damaged")
    numbers: list[tuple[Fact, float]] = []
    words: list[tuple[Fact, str]] = []
    for fact, value in facts.items():
        known = first.facts.get(fact)
        if known is not None and known.value == value.value:
            continue
        if isinstance(value.value, str):
            words.append((fact, value.value))
        else:
            numbers.append((fact, float(value.value)))
    return Read(tuple(numbers), tuple(words), tuple(fact for fact in first.facts if fact not in facts))


def _keep_ends(low: list[tuple[float, int]], high: list[tuple[float, int]], number: float, robot: int) -> None:
    """Take down a number among the smallest and the largest."""
    if len(low) < _EXTREMES or number < low[-1][0]:
        low.append((number, robot))
        low.sort()
        del low[_EXTREMES:]
    if len(high) < _EXTREMES or number > high[-1][0]:
        high.append((number, robot))
        high.sort(reverse=True)
        del high[_EXTREMES:]


def _size(read: Read) -> int:
    return 10 + len(read.numbers) + 2 * len(read.texts) + len(read.missing)


def _is_exact(facts: Facts) -> bool:
    """Say whether numbers were printed with more than a few digits."""
    known = [(value.tolerance, value.value) for fact, value in facts.items() if not fact.is_angle]
    return not any(off > _FEW_DIGITS * max(1.0, abs(value)) for off, value in known if not isinstance(value, str))


def _said(facts: Facts) -> set[tuple[str, str, str]]:
    """Return what an artifact speaks of: of shapes only whose they are, for each counts them in its own way.

    Raw elements are texts of one format alone, and no numbers.
    """
    found = set()
    for kind, name, quantity in facts:
        if quantity.startswith("element "):
            continue
        shape = _SHAPE.fullmatch(quantity) or (quantity.startswith("box ") and kind == "link")
        found.add((kind, name, quantity.split(" ")[0] if shape else quantity))
    return found


def _cover(firsts: Mapping[str, _First]) -> tuple[str, ...]:
    """Return artifacts that together say all that is said: the exact ones that say most before others."""
    readable = {name: first for name, first in firsts.items() if first.format is not None}
    said = {name: _said(first.facts) for name, first in readable.items()}
    order = sorted(readable, key=lambda name: (not _is_exact(readable[name].facts), -len(said[name]), name))
    known: set[tuple[str, str, str]] = set()
    chosen = []
    for name in order:
        if not said[name] <= known:
            known |= said[name]
            chosen.append(name)
    for name in sorted(chosen, key=lambda name: (-readable[name].size, name)):
        others: set[tuple[str, str, str]] = set().union(*(said[one] for one in chosen if one != name))
        if said[name] <= others:
            chosen.remove(name)
    return tuple(chosen)


def recognised(name: str, text: str) -> tuple[Format | None, Facts]:
    """Return the format of an artifact, known by name and text, with its facts; None if that format has no facts."""
    best: tuple[Format | None, Facts] = (None, {})
    for format in FORMATS.values():
        if format.facts is None or not _may_be(format, name):
            continue
        try:
            facts = format.facts(text)
        except _DAMAGED:
            continue
        if len(facts) > len(best[1]):
            best = (format, facts)
    return best


def _may_be(format: Format, name: str) -> bool:
    usual = Path(format.file.replace("{}", "robot")).suffixes
    endings = {"".join(usual[at:]) for at in range(len(usual))} | set(format.endings)
    return not endings or name.lower().endswith(tuple(endings))


class Texts:
    """The artifacts of a sweep on disk, each held against its sum; what several robots share is read once."""

    def __init__(self) -> None:
        self._sums: dict[tuple[int, ...], bytes] = {}
        self._bad: set[str] = set()

    def look(self, variant: Variant) -> tuple[list[str], list[str]]:
        """Return the artifacts of a robot that are not there, and those that are others now."""
        missing, changed = [], []
        self._bad = set()
        for name, digest in variant.artifacts.items():
            found = self._sum(variant.folder / name)
            if found is None:
                missing.append(name)
            elif found.hex() != digest:
                changed.append(name)
        self._bad = {*missing, *changed}
        return missing, changed

    def is_there(self, variant: Variant, name: str) -> bool:
        """Say whether an artifact of the robot that was looked at is the one that was made."""
        return name in variant.artifacts and name not in self._bad

    def read(self, variant: Variant, name: str) -> str:
        """Return the text of an artifact; empty for one that is no text."""
        try:
            return world.text(variant.folder / name)
        except (OSError, ValueError):
            return ""

    def _sum(self, path: Path) -> bytes | None:
        """Return the SHA-256 of a file; of one that has several names it is computed once."""
        try:
            with world.stream(path) as file:
                status = os.fstat(file.fileno())
                key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
                if key in self._sums:
                    return self._sums[key]
                sums = hashlib.sha256()
                while block := file.read(_BLOCK):
                    sums.update(block)
        except (OSError, ValueError):
            return None
        found = sums.digest()
        if status.st_nlink > 1 and len(self._sums) < MOST_READ // 5:
            self._sums[key] = found
        return found


def flat(arguments: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of arguments with their paths: ``lidar.xyz[0]``."""
    if isinstance(arguments, Mapping) and arguments:
        for name, value in arguments.items():
            yield from flat(value, f"{path}.{name}" if path else str(name))
    elif isinstance(arguments, list) and arguments:
        for index, value in enumerate(arguments):
            yield from flat(value, f"{path}[{index}]")
    elif path:
        yield path, arguments


def _number(said: Any) -> tuple[float, str] | None:
    """Return a number in SI units with its unit, which is empty where nothing says it; None for what is no number."""
    if isinstance(said, bool) or said is None:
        return None
    if isinstance(said, (int, float)):
        return (float(said), "") if abs(said) < _LARGEST else None
    if not isinstance(said, str):
        return None
    quantity = Quantity.parse(said.strip())
    if quantity is not None:
        return (float(quantity), quantity.unit) if abs(quantity) < _LARGEST else None
    try:
        number = float(said) if len(said) < 100 and "_" not in said else math.nan
    except ValueError:
        return None
    return (number, "") if abs(number) < _LARGEST else None

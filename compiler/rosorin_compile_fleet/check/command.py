"""rosorin-compile check fleet: the robots of a sweep, checked as one."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.diagnostics import (
    ERROR,
    NOTE,
    Console,
    Diagnostic,
    Heading,
    Progress,
    Related,
    Rule,
    Span,
    and_more,
    counted,
    error,
    first_of,
    listed,
    printable,
)
from rosorin_compile.extending import FINE, PROBLEMS, Run, WrongUsage, give_result, world

from .answers import CheckedFleet, FleetOutlier
from .columns import Columns, Texts
from .judging import Far, Row, far_of, outliers, rows_of
from .report import add_table, table, texts_of, told_of
from .spread import FEWEST
from .sweep_file import SweepFile, Variant, span_of

if TYPE_CHECKING:
    from rosorin_compile.extending import Parser


RULES = (
    Rule(
        "fleet-failed",
        "A robot of a sweep was not made: its first error is in the message, the others are in `sweep.json`.",
        "Correct its arguments or the description, and run the sweep again.",
        Heading.FLEETS,
    ),
    Rule(
        "fleet-missing",
        "An artifact of a sweep, or the whole folder of a robot, is not there.",
        "Run the sweep again: it does only what is missing.",
        Heading.FLEETS,
    ),
    Rule(
        "fleet-changed",
        "An artifact is not the one that the sweep made: somebody has changed it since. Its numbers are not compared.",
        "Change the description or the arguments, and run the sweep again.",
        Heading.FLEETS,
    ),
    Rule(
        "fleet-unreadable",
        "An artifact is the one that the sweep made, and cannot be read back.",
        "A newer rosorin-compile may have made it; else please report it.",
        Heading.FLEETS,
    ),
    Rule(
        "fleet-few",
        "A note: there are too few robots to say which of them has a number that is far from that of the others.",
        "",
        Heading.FLEETS,
    ),
    Rule(
        "fleet-numbers",
        "A note: the numbers that differ between the robots of a fleet (in the forms for programs).",
        "",
        Heading.FLEETS,
    ),
)

_MOST = 500  # diagnostics of one kind that are kept
_NAMED = 3


class Told:
    """Diagnostics of one kind: the first of them, and how many there are in all."""

    def __init__(self) -> None:
        self.kept: list[Diagnostic] = []
        self.count = 0

    def add(self, diagnostic: Diagnostic) -> None:
        """Keep one more, or count it."""
        self.count += 1
        if len(self.kept) < _MOST:
            self.kept.append(diagnostic)

    def all(self) -> list[Diagnostic]:
        """Return what was kept; the last of it says how many are left."""
        left = self.count - len(self.kept)
        if not left:
            return self.kept
        last = self.kept[-1]
        return [*self.kept[:-1], replace(last, message=f"{last.message},{and_more(left, 'of this kind')}")]


class Failed:
    """Robots that were not made: those that have the same first error are told together."""

    def __init__(self) -> None:
        self.count = 0
        self._found: dict[object, tuple[Variant, list[str], list[int]]] = {}
        self._more = Told()

    def take(self, variant: Variant) -> None:
        """Take one robot that was not made."""
        self.count += 1
        first = _first_error(variant)
        key = tuple(str(first.get(part)) for part in ("rule", "message", "file", "line", "column"))
        if key not in self._found and len(self._found) == _MOST:
            self._more.add(_failed(variant, [variant.name], 1))
            return
        _, names, count = self._found.setdefault(key, (variant, [], [0]))
        count[0] += 1
        names += [variant.name] if len(names) < _NAMED else []

    def all(self) -> list[Diagnostic]:
        """Return an error for each reason."""
        return [_failed(variant, names, count) for variant, names, (count,) in self._found.values()] + self._more.all()


class StandIns:
    """Values that only hold a place: what each is, and which robots have it."""

    def __init__(self) -> None:
        self.robots = 0
        self._found: dict[str, tuple[Mapping[str, Any], list[str], list[int]]] = {}

    def take(self, variant: Variant) -> None:
        """Take those of one robot."""
        said = {str(one.get("message", "")): one for one in variant.diagnostics if one.get("rule") == "stand-in"}
        self.robots += bool(said)
        for message, one in said.items():
            if message in self._found or len(self._found) < _MOST:
                _, names, count = self._found.setdefault(message, (one, [], [0]))
                count[0] += 1
                names += [variant.name] if len(names) < _NAMED else []

    def notes(self, made: int) -> list[Diagnostic]:
        """Return a note for each; those that some robots have and others have not come first."""
        notes = []
        for message, (one, names, (count,)) in sorted(self._found.items(), key=lambda entry: entry[1][2][0]):
            whose = f"all {counted(made, 'robot')}" if count == made else f"{count:,} of {counted(made, 'robot')}: "
            named = "" if count == made else first_of(names, _NAMED) if count <= _NAMED else f"{', '.join(names)}"
            named += and_more(count - len(names)) if count != made and count > len(names) else ""
            said = f"{printable(message)} (in {whose}{named})"
            notes.append(Diagnostic("stand-in", NOTE, said, _place(one), (), ""))
        return notes


class Fleet:
    """What was found in a sweep."""

    def __init__(self, file: SweepFile) -> None:
        self.file = file
        self.columns = Columns()
        self.stand_ins = StandIns()
        self.failed = Failed()
        self.missing, self.changed, self.unreadable = Told(), Told(), Told()
        self.total = self.made = 0
        self.names: set[str] = set()
        self.problem: Diagnostic | None = None
        self.rows: list[Row] = []
        self.far: dict[int, list[Far]] = {}

    def read(self) -> None:
        """Read all robots, one after the other."""
        texts = Texts()
        for variant in self.file.variants():
            self.total += 1
            Progress.step(f"reading {variant.name},", self.total)
            if variant.name in self.names:
                message = f'{self.file.path} has two variants "{printable(variant.name)}"'
                self.problem = self.problem or error("fleet-file", message, variant.span(), "give each its own name")
                continue
            self.names.add(variant.name)
            if not variant.made:
                self.failed.take(variant)
                continue
            self.made += 1
            self.stand_ins.take(variant)
            self._look(variant, texts)
        self.problem = self.file.problem or self.problem
        self.rows = rows_of(self.columns)
        self.far = far_of(self.rows, self.columns.drawn)

    def _look(self, variant: Variant, texts: Texts) -> None:
        missing, changed = texts.look(variant)
        help = "run rosorin-compile sweep again: it does only what is missing"
        if missing and world.kind(variant.folder) != world.FOLDER:
            message = f"{variant.name}: there is no folder {variant.folder}"
            self.missing.add(error("fleet-missing", message, variant.span("folder"), help))
        elif missing:
            message = f"{variant.name}: {listed(missing, _NAMED)} of {variant.folder} {_is(missing)} not there"
            self.missing.add(error("fleet-missing", message, variant.span("artifacts"), help))
        if changed:
            message = f"{variant.name}: {listed(changed, _NAMED)} of {variant.folder} {_is(changed)} not what was made"
            way = "change the description or the arguments instead, and run the sweep again"
            self.changed.add(error("fleet-changed", message, variant.span("artifacts"), way))
        for name, problem in self.columns.take(variant, texts):
            message = f"{variant.name}: {variant.folder / name} cannot be read: {problem}"
            self.unreadable.add(error("fleet-unreadable", message, variant.span("artifacts")))

    def diagnostics(self) -> list[Diagnostic]:
        """Return all that is wrong, and the stand-ins; the file is read once more for the places of outliers."""
        told = [self.problem] if self.problem else []
        told += self.failed.all()
        for kind in (self.missing, self.changed, self.unreadable):
            told += kind.all()
        told += self._outliers()
        if 1 < self.made < FEWEST:
            message = f"{counted(self.made, 'robot')}: too few to say which number is an outlier; that takes {FEWEST}"
            told.append(Diagnostic("fleet-few", NOTE, message))
        return [*told, *self.stand_ins.notes(self.made)]

    def _outliers(self) -> Iterator[Diagnostic]:
        waiting = {self.columns.robots[robot]: far for robot, far in self.far.items()}
        for variant in self.file.variants() if waiting else ():
            far = waiting.pop(variant.name, None)
            if far is not None:
                places = {one.row.fact.name: _span_of(variant, one.row) for one in far if one.row.is_argument}
                yield from outliers(printable(variant.name), far, {"": variant.span(), **places})
            if not waiting:
                return

    def summary(self) -> str:
        """Return in one line how many robots there are, and what became of them."""
        counts = [f"{self.made:,} made"] + ([f"{self.failed.count:,} failed"] if self.failed.count else [])
        stand_ins = self.stand_ins.robots
        words = [f"{counted(self.total, 'robot')} in {self.file.path}: {', '.join(counts)}"]
        words += [f"{len(self.far):,} with outliers"] if self.far else []
        words += [f"{stand_ins:,} with stand-ins"] if stand_ins else []
        drawn = len(self.columns.drawn)
        if drawn < self.made:
            words.append(f"medians are those of {drawn:,} drawn robots")
        return "; ".join(words)

    def counts(self) -> tuple[int, int]:
        """Return how many numbers of the artifacts differ between robots, and how many are the same in all."""
        differing = sum(1 for row in self.rows if not row.is_argument) + sum(len(row.follow) for row in self.rows)
        return differing, self.columns.count() - differing

    def answer(self, fine: bool) -> CheckedFleet:
        """Return what a program gets; ``fine``: there is no error."""
        differing, same = self.counts()
        far = [(self.columns.robots[robot], one) for robot, found in self.far.items() for one in found]
        return CheckedFleet(
            file=str(self.file.path),
            fine=fine,
            robots=self.total,
            made=self.made,
            failed=self.failed.count,
            with_outliers=len(self.far),
            with_stand_ins=self.stand_ins.robots,
            drawn=len(self.columns.drawn),
            differing=differing,
            same=same,
            numbers=[told_of(row) for row in self.rows],
            outliers=[FleetOutlier(name, one.row.label, one.value, one.sigmas) for name, one in far],
        )

    def numbers(self, full: bool) -> list[str]:
        """Return the lines about numbers: the table of those that differ, and how many are equal."""
        differing, same = self.counts()
        if not self.made:
            return []
        lines = table(self.rows, full) if self.rows else []
        lines += texts_of(self.columns, full)
        if self.made > 1:
            verb = "differs" if differing == 1 else "differ"
            lines.append(f"{counted(differing, 'number')} of the artifacts {verb}, {same:,} are the same in all robots")
        return lines


def options(command: Parser) -> None:
    """Add what this check takes."""
    command.add_argument("words", nargs="*", metavar="FILE", help="the sweep.json of a sweep, or its folder")
    command.add_argument("--full", action="store_true", help="show all numbers")
    command.add_page("write a page that shows the numbers of all robots")
    command.add_messages(summary=True)


def run(options: argparse.Namespace) -> int:
    """Check the robots of a sweep as one; return the exit code."""
    files = options.words
    if len(files) != 1:
        many = f'; what is "{files[1]}" for?' if files else ""
        raise WrongUsage(f"a fleet is the sweep.json of one sweep{many}: rosorin-compile check fleet FILE")
    run = Run.of(options)
    console = run.console
    fleet = Fleet(SweepFile(Path(files[0])))
    console.begin(printable(str(fleet.file.path)))
    fleet.read()
    diagnostics = fleet.diagnostics()
    failed = any(one.severity == ERROR for one in diagnostics)
    _tell_numbers(fleet, console, options.full)
    console.show(diagnostics)
    console.say(fleet.summary())
    if options.html is not None:
        from .page import write

        write(fleet, diagnostics, options, console)
    console.end(failed)
    give_result(options, asdict(fleet.answer(not failed)), str)
    run.finish()
    return PROBLEMS if failed else FINE


def _tell_numbers(fleet: Fleet, console: Console, full: bool) -> None:
    lines = fleet.numbers(full)
    if console.quiet or not lines:
        return
    if console.for_people:
        for line in lines:
            console.say(line)
    else:
        console.collected.append(Diagnostic("fleet-numbers", NOTE, "\n".join(lines)))
    if console.keeps:
        add_table(fleet.rows, console)


def _span_of(variant: Variant, row: Row) -> Span:
    return variant.span(row.fact.name)


def _is(names: list[str]) -> str:
    return "is" if len(names) == 1 else "are"


def _first_error(variant: Variant) -> Mapping[str, Any]:
    return next((one for one in variant.diagnostics if one.get("severity") == ERROR), {})


def _failed(variant: Variant, names: list[str], count: int) -> Diagnostic:
    """Return that robots were not made, with the first error of the first of them."""
    first = _first_error(variant)
    whose = printable(f"{', '.join(names)}{and_more(count - len(names))}")
    message = f"{whose} {'was' if count == 1 else 'were'} not made"
    if not first:
        return error("fleet-failed", f"{message}; the status is {printable(variant.status)}", variant.span("status"))
    errors = sum(one.get("severity") == ERROR for one in variant.diagnostics)
    more = f" ({counted(errors - 1, 'more error')})" if errors > 1 and count == 1 else ""
    place = _place(first)
    related = [Related("said here", place)] if place else []
    said = f"{message}: {printable(str(first.get('message', '')))}{more}"
    return error("fleet-failed", said, variant.span("status"), printable(str(first.get("help", ""))), related)


def _place(said: Mapping[str, Any]) -> Span | None:
    """Return where a diagnostic is about, as the sweep has it; None for one without a place."""
    file, line, column = said.get("file"), said.get("line"), said.get("column")
    if not isinstance(file, str) or not isinstance(line, int) or not isinstance(column, int):
        return None
    return span_of(file, "", max(1, min(line, 10_000_000)), max(1, column)) if line < 100_000 else None

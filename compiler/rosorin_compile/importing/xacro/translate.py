"""Translate a xacro to a description with its macros and arguments, verified against what xacro makes.

What cannot be translated is given up by name: a macro is expanded where it is called, an argument keeps its value.
The result is compiled, and what differs names what is given up next.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs, ReadOptions
from rosorin_compile.source.diagnostics import counted, listed
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import MarkupError

from ..description import tree_of
from .documents import PROBE, GiveUp, Target, WrittenFiles
from .expand import _expand
from .formulas import literal
from .ir import FLAG, LET, Program, Unsupported, Variable, build
from .verify import Combination, Fault, Source, combinations, faults, moves
from .wording import Found, find, wording_report
from .write_yaml import write

MAX_BUILDS, MAX_CHECKS = 60, 25
MAX_SECONDS = 45.0  # of CPU, with its children


class WrittenOut(NamedTuple):
    """A macro that is expanded where it is called, or an argument that keeps its value, with the reason."""

    name: str
    reason: str
    at: str = ""


@dataclass(frozen=True)
class Translation:
    """The files of a description (text by name), and what became of the macros and arguments of the source.

    ``fixed`` are arguments with the value that they keep, ``proven`` the combinations of arguments that were compared.
    ``words`` are the lines about elements that became entries, ``plain`` is the robot without those. ``report`` are the
    lines for the person who imports the robot. Without files, ``reason`` says why.
    """

    files: dict[str, str]
    kept: tuple[str, ...] = ()
    written_out: tuple[WrittenOut, ...] = ()
    arguments: tuple[str, ...] = ()
    fixed: tuple[tuple[str, str], ...] = ()
    proven: tuple[Combination, ...] = ()
    words: tuple[str, ...] = ()
    plain: Map | None = None
    report: tuple[str, ...] = ()
    reason: str = ""


def translate(path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, target: Target) -> Translation:
    """Return the description of a xacro; without files, and with a reason, if it cannot be translated.

    ``imported`` is the robot that the xacro expands to with the arguments that are given, ``wanted`` the artifacts that
    its description asks for.
    """
    try:
        return _Search(path, options, imported, wanted, target).run()
    except Unsupported as problem:
        reason = problem.reason
    except MarkupError as problem:
        reason = problem.diagnostic.message
    except OSError as problem:
        reason = str(problem)
    except RecursionError:
        reason = "its expressions are nested too deeply"
    return Translation({}, report=(f"flat, without macros and arguments: {reason}",), reason=reason)


def _seconds() -> float:
    """Return the CPU time of the process and its children."""
    return sum(os.times()[:4])


class _Search:
    """The search for what has to be given up."""

    def __init__(self, path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, target: Target) -> None:
        self.path = path
        self.options = options
        self.imported = imported
        self.wanted = wanted
        self.target = target
        self.source = Source(path, options, target.name, target.meshes)
        self.source.known[()] = imported
        self.inlined: dict[str, str] = {}  # keys of macros, with the reason
        self.fixed: dict[str, list[str]] = {}  # values of arguments, with the reason
        self.implicit: dict[str, list[str]] = {}
        self.explicit: set[str] = set()
        self.plain: set[str] = set()  # places of properties that are written as their values
        self.program: Program | None = None
        self.began = _seconds()

    def run(self) -> Translation:
        failing: Combination | None = None
        for _ in range(MAX_CHECKS):
            made = self.attempt()
            self.source.environment = [one.name for one in made.program.arguments.values() if one.environment]
            rows, possible = combinations(made.choices)
            rows = sorted(rows, key=lambda row: row != failing)  # what failed before fails first
            found, compared, refused = self.check(made, rows)
            if found:
                failing = found[0].combination
                self.mend(made, found)
                continue
            if self.fix_refused(made, rows, refused) or self.fix_unfollowed(made):
                continue
            late = len(rows) - len(compared) - len(refused) if self.is_late() else 0
            return self.finished(made, compared, possible, refused, late)
        raise Unsupported("nothing that was given up makes it the same robot")

    def is_late(self) -> bool:
        return _seconds() - self.began > MAX_SECONDS

    # One attempt.

    def attempt(self) -> WrittenFiles:
        """Return the files with what has been given up so far; give up what cannot be written."""
        for _ in range(MAX_BUILDS):
            if self.is_late():
                raise Unsupported(f"the translation takes more than {MAX_SECONDS:g} s")
            program = self.program or self.built()
            self.program = program
            try:
                return self.written(program)
            except GiveUp as stop:
                self.give_up(program, stop)
        raise Unsupported("too much of it cannot be translated")

    def built(self) -> Program:
        plan = {"inlined": self.inlined, "fixed": self.fixed, "implicit": self.implicit, "plain": sorted(self.plain)}
        answer = _expand(self.path, self.options, plan)
        if "error" in answer:
            raise Unsupported(str(answer["error"]))
        for key, reason in answer["reasons"].items():
            self.inlined.setdefault(key, reason)
        for name, value in answer["fixed"].items():
            self.fixed.setdefault(name, value)
        self.implicit = answer["implicit"]
        return build(answer)

    def written(self, program: Program, words: Found | None = None) -> WrittenFiles:
        made = write(program, self.target, self.explicit, self.imported, self.wanted, self.accepted(), words)
        made.packages = {**self.options.packages, **made.packages}
        return made

    def check(
        self, made: WrittenFiles, rows: Sequence[Combination], in_words: bool = False
    ) -> tuple[list[Fault], list[Combination], list[Combination]]:
        """Return the differences of some combinations, which were compared, and which xacro refuses."""
        return faults(made.files, self.source, rows, made.packages, in_words, self.is_late)

    def accepted(self) -> list[Any]:
        """Return what the robots of all combinations have to be accepted for; each rule once."""
        made: dict[tuple[str, str], dict[str, Any]] = {}
        for imported in self.source.known.values():
            for entry in (imported.tree.get("accept") if imported.tree is not None else None) or ():
                key = (str(entry["rule"]), str(entry.get("reason") or ""))
                known = made.setdefault(key, {"rule": key[0], "of": [], "reason": key[1]})
                known["of"] += [str(one) for one in entry.get("of") or () if str(one) not in known["of"]]
        return [{name: value for name, value in entry.items() if value} for entry in made.values()]

    # Giving up.

    def give_up(self, program: Program, stop: GiveUp) -> None:
        """Give up what cannot be written. Raises Unsupported if nothing is left to give up."""
        macro, reason = stop.macro, stop.problem.reason
        if macro is not None and stop.explicit and macro.key not in self.explicit:
            self.explicit.add(macro.key)
            return
        self.program = None
        if macro is not None and macro.definition not in self.inlined:
            self.inlined[macro.definition] = reason
        elif stop.problem.node is None or not self.blame_formula(program, stop.problem.node, reason):
            raise stop.problem

    def blame_formula(self, program: Program, node: ast.AST, reason: str) -> bool:
        """Give up what a formula depends on: properties become their values, then arguments keep theirs."""
        found = program.variables_in(node)
        lets = [one for one in found if one.kind == LET and one.place and str(one.place) not in self.plain]
        if lets:
            self.plain |= {str(one.place) for one in lets}
            return True
        values = [one for one in found if one.kind != LET and one.name not in self.fixed and not one.owner]
        for one in values:
            self.fix(one, reason)
        return bool(values)

    def fix(self, variable: Variable, reason: str) -> None:
        self.fixed[variable.name] = [str(variable.values[0]), reason]
        self.program = None

    def fix_refused(self, made: WrittenFiles, rows: Sequence[Combination], refused: Sequence[Combination]) -> bool:
        """Fix variables of the environment of which xacro takes no other value than the one they have."""
        found = False
        for variable in made.program.arguments.values():
            mine = [row for row in rows if len(row) == 1 and row[0][0] == variable.name]
            if variable.environment and mine and all(row in refused for row in mine):
                self.fix(
                    variable, f"with another value of the environment variable {variable.name} xacro makes no robot"
                )
                found = True
        return found

    def fix_unfollowed(self, made: WrittenFiles) -> bool:
        """Fix the arguments that the translation does not follow for any value; return True if there are any."""
        others = {}
        for variable in made.program.arguments.values():
            text = str(variable.values[0])
            value = literal(text)
            if len(made.choices.get(variable.name, ())) > 1 or (variable in made.used and variable.type == FLAG):
                continue
            if isinstance(value, bool):
                others[variable] = "false" if value else "true"
            elif isinstance(value, (int, float)):
                others[variable] = repr(value + 1 if isinstance(value, int) else value * 1.25 + 0.01)
            elif len(words := text.split()) > 1 and all(isinstance(literal(one), (int, float)) for one in words):
                others[variable] = " ".join(repr(float(one) * 1.25 + 0.01) for one in words)
            elif variable in made.used and text and "/" not in text:
                others[variable] = f"{text}{PROBE}"
        read = {one: text for one, text in others.items() if one in made.used}
        found = [one for one in others if one not in read and moves(self.source, ((one.name, others[one]),))]
        if read and self.differs(made, tuple((one.name, text) for one, text in read.items())):
            found += [one for one, text in read.items() if self.differs(made, ((one.name, text),))]
        for one in found:
            self.fix(one, "with another value of it the robot is another than xacro makes")
        return bool(found)

    def differs(self, made: WrittenFiles, row: Combination) -> bool:
        known = row in self.source.known
        found, *_ = self.check(made, [row])
        if not known:
            self.source.known.pop(row, None)
        return any(not one.refused for one in found)

    def mend(self, made: WrittenFiles, found: list[Fault]) -> None:
        """Give up what a difference names. Raises Unsupported if there is nothing left."""
        if self.accepted() != getattr(self, "accepts", None):
            self.accepts = self.accepted()
            return  # other arguments break other rules
        if self.blame(made, found) or self.give_up_all(made, found[0]):
            self.program = None
            return
        arguments = made.program.arguments
        values = [arguments[name] for name, _ in found[0].combination if name in arguments and name not in self.fixed]
        lets = {str(one.place) for one in made.used if one.kind == LET and one.place is not None}
        if not values and lets <= self.plain:
            raise Unsupported(found[0].text)
        if not values:
            self.plain |= lets
            self.program = None
        for variable in values:
            self.fix(variable, f"not proven: {found[0].text}")

    def blame(self, made: WrittenFiles, found: Sequence[Fault]) -> bool:
        """Give up the macro or the property that a difference names; return False if it names none."""
        macros = made.program.macros.values()
        by_name = {macro.name: macro for macro in macros} | {macro.ours: macro for macro in macros}
        for fault in found:
            for macro in [by_name[name] for name in fault.macros if name in by_name]:
                if macro.level == "robot" and macro.key not in self.explicit:
                    self.explicit.add(macro.key)
                    return True
                if macro.definition not in self.inlined:
                    self.inlined[macro.definition] = f"not proven: {fault.text}"
                    return True
        lets = {one.ours: one for one in made.used if one.kind == LET and one.place is not None}
        for fault in found:
            for variable in [lets[name] for name in fault.macros if name in lets]:
                if str(variable.place) not in self.plain:
                    self.plain.add(str(variable.place))
                    return True
        return False

    def give_up_all(self, made: WrittenFiles, fault: Fault) -> bool:
        """Keep the prefixes of all macros, or expand all inline; return False if that is done already."""
        macros = [macro for macro in made.program.macros.values() if macro.definition not in self.inlined]
        if any(macro.key not in self.explicit for macro in macros if macro.level == "robot"):
            self.explicit |= {macro.key for macro in macros}
        else:
            self.inlined |= {macro.definition: f"not proven: {fault.text}" for macro in macros}
        return bool(macros)

    # The result.

    def finished(
        self, made: WrittenFiles, rows: list[Combination], possible: int, refused: Sequence[Combination], late: int
    ) -> Translation:
        program, plain = made.program, None
        made = self.written(program)  # the combinations may break rules that have to be accepted
        lines: tuple[str, ...] = ()
        if not self.target.verbatim:
            rows_of_users = [row for row in rows if all(text != PROBE for _, text in row)]
            made, lines, plain = self.in_words(made, rows_of_users)
        order = [key for key, _, _ in program.answer["defined"]]
        empty = [one for one in program.macros.values() if one.key in made.empty]
        kept = [one for one in program.macros.values() if one not in empty]
        kept.sort(key=lambda one: order.index(one.definition) if one.definition in order else 0)
        lost = [
            WrittenOut(name, reason, program.at(tuple(place[:2]) if place else None))
            for name, place, reason, key in program.answer["inlined"]
            if name not in program.answer["silent"]
        ]
        lost += [WrittenOut(one.name, "its materials are those of the robot", program.at(one.place)) for one in empty]
        used = [one for one in program.arguments.values() if one in made.used]
        names = tuple({one.definition: one.name for one in kept}.values())
        report = [*_report_macros(names, lost, program), *self.report_arguments(program, used)]
        for package in made.unfound:
            report.append(
                f"it asks for the package {package}: source its workspace, or give --package {package}=FOLDER"
            )
        report += self.target.sharing.report(made.files) if self.target.sharing is not None else ()
        report += _report_proof(rows, possible, refused, late)
        fixed = tuple((name, value[0]) for name, value in self.fixed.items())
        arguments = tuple(one.name for one in used)
        return Translation(made.files, names, tuple(lost), arguments, fixed, tuple(rows), lines, plain, tuple(report))

    def report_arguments(self, program: Program, used: Sequence[Variable]) -> Iterator[str]:
        """Yield the lines about arguments."""
        unused = [one.name for one in program.arguments.values() if one not in used]
        environment = [one.name for one in used if one.environment]
        if used:
            yield f"arguments kept: {listed([one.name for one in used])}"
        if unused:
            yield f"arguments left out, because nothing uses {_them(unused)}: {listed(unused)}"
        if environment:
            yield f"variables of the environment that are arguments now: {listed(environment)}"
        if self.fixed:
            values = [f"{name} ({' '.join(text.split())})" if text else name for name, (text, _) in self.fixed.items()]
            yield f"arguments replaced by their value: {listed(values)}"
        for reason, names in groupby(self.fixed, lambda name: self.fixed[name][1]):
            yield f"  {listed(list(names))}: {reason}"

    def in_words(self, made: WrittenFiles, rows: list[Combination]) -> tuple[WrittenFiles, tuple[str, ...], Map | None]:
        """Replace raw elements by entries of the language if the robot stays the same."""
        found = first = find(made.documents.plain, list(self.source.known.values()))
        while found.spots and not self.is_late():
            again = self.written(made.program, found)
            wrong, *_ = self.check(again, rows, in_words=True)
            if not wrong and not self.is_late():
                lines = tuple(wording_report(again.documents.labels, first))
                return again, lines, found.left_of(tree_of(self.imported))
            found = found.without(wrong[0].text) if wrong else Found()
        return made, tuple(wording_report({}, first)), None


def _report_macros(kept: Sequence[str], lost: Sequence[WrittenOut], program: Program) -> Iterator[str]:
    if kept or lost:
        line = f"{len(kept)} of {counted(len(kept) + len(lost), 'macro')} kept"
        how = f", {len(lost)} written out where {'it is' if len(lost) == 1 else 'they are'} called"
        yield f"{line}{how}" if lost else line
    yield from (f"  {one.name}: {one.reason}{f' ({one.at})' if one.at else ''}" for one in lost)
    executed, idle = program.answer["silent"], list(dict.fromkeys(program.answer["uncalled"]))
    if executed:
        yield f"named values where they are called, because they only set properties: {listed(executed)}"
    if idle:
        yield f"left out, because nothing calls {_them(idle)}: {listed(idle)}"


def _report_proof(
    rows: Sequence[Combination], possible: int, refused: Sequence[Combination], late: int
) -> Iterator[str]:
    how = "its arguments as they are" if len(rows) == 1 else f"{len(rows)} combinations of its arguments"
    if possible > len(rows) + len(refused):
        how += f" (of {possible}: the defaults, and each argument changed alone)"
    yield f"the same robot as xacro makes it, with {how}"
    if late:
        yield f"not compared, because that takes too long: {counted(late, 'combination')}"
    if refused:
        first = " ".join(f"{name}:={value}" for name, value in refused[0])
        yield f"not compared, because xacro refuses it: {first}"


def _them(items: Sequence[Any]) -> str:
    return "it" if len(items) == 1 else "them"

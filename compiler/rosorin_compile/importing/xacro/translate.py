"""Translate a xacro to a description with its macros and arguments, verified against what xacro makes.

What cannot be translated is given up by name, as little as possible: an element stays as xacro expands it, a macro is
expanded where it is called, an argument keeps its value. Static analysis decides first; then the result is compiled,
and what differs names what is given up next.
"""

from __future__ import annotations

import copy
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs, ReadOptions
from rosorin_compile.source.diagnostics import Span, counted, listed
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element, MarkupError

from ..description import tree_of
from .build import Changes, GiveUp, Program
from .resolve import Plan
from .texts import Unsupported
from .tree import ARGUMENT, Macro, Place, Variable, place_of
from .verify import Combination, Fault, Source, choices_of, combinations, faults, moves, other_values
from .wording import Found, find
from .wording import wording_report as words_report
from .write_yaml import PROBE, Target, WrittenFiles, write

MAX_BUILDS, MAX_CHECKS, MAX_BISECTED = 300, 30, 8
MAX_SECONDS = 45.0  # of CPU, with its children
_NO_LIST = re.compile(r"is a list, not the text|takes a list, not text")
_DIMENSION = re.compile(r" is an? [\w ]+ \(\S+\), but \S+ is an? [\w ]+ \(| is a number, not an? \w+ \(")
_PRINTED = re.compile(r'(?:(\w+)|\w+ "([^"]*)"): xacro has (?:True|False), the translation (?:true|false)\Z')


class WrittenOut(NamedTuple):
    """A macro that is expanded where it is called, or (``flat``) an element as xacro expands it, with the reason."""

    name: str
    reason: str
    span: Span | None
    flat: bool = False


@dataclass(frozen=True)
class Translation:
    """The files of a description (text by name), and what became of the macros and arguments of the source.

    ``proven`` are the combinations of arguments that were compared, ``possible`` how many there are, ``refused`` those
    that xacro cannot expand, ``late`` how many were left for lack of time. ``idle`` are macros that nothing calls,
    ``executed`` those that only set properties, ``fixed`` arguments that have the value they have here, for the reasons
    in ``frozen``, ``unfound`` packages that the description does not find by itself. Without files, ``reason`` says
    why. ``words`` are the lines about elements that became words, ``plain`` is the robot without those; ``shared`` the
    lines about files that other robots include, ``grown`` what those were before.
    """

    files: dict[str, str]
    kept: tuple[str, ...] = ()
    written_out: tuple[WrittenOut, ...] = ()
    arguments: tuple[str, ...] = ()
    proven: tuple[Combination, ...] = ()
    possible: int = 0
    refused: tuple[Combination, ...] = ()
    idle: tuple[str, ...] = ()
    unused: tuple[str, ...] = ()
    executed: tuple[str, ...] = ()
    fixed: tuple[tuple[str, str], ...] = ()
    environment: tuple[str, ...] = ()
    unfound: tuple[str, ...] = ()
    late: int = 0
    reason: str = ""
    span: Span | None = None
    words: tuple[str, ...] = ()
    plain: Map | None = None
    shared: tuple[str, ...] = ()
    grown: Mapping[str, str] = field(default_factory=dict)
    frozen: tuple[WrittenOut, ...] = ()


def translate(path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, target: Target) -> Translation:
    """Return the description of a xacro; without files, and with a reason, if it cannot be translated.

    ``imported`` is the robot that the xacro expands to with the arguments that are given, ``wanted`` the artifacts that
    its description asks for.
    """
    search = _Search(path, options, imported, wanted, target)
    try:
        return search.run()
    except Unsupported as problem:
        return Translation({}, reason=problem.reason, span=problem.span)
    except MarkupError as problem:
        return Translation({}, reason=problem.diagnostic.message, span=problem.diagnostic.span)
    except RecursionError:
        return Translation({}, reason="its expressions are nested too deeply")


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
        self.plan = Plan()
        self.lost: dict[str, WrittenOut] = {}
        self.flat: dict[Place, WrittenOut] = {}
        self.frozen: dict[str, WrittenOut] = {}
        self.accepts: list[Any] = []
        self.trees = 0
        self.began = _seconds()

    def run(self) -> Translation:
        failing: Combination | None = None
        for _ in range(MAX_CHECKS):
            made = self.attempt()
            arguments = {name: one for name, one in made.program.names.arguments.items() if one in made.used}
            self.source.environment = made.program.names.environment.keys()
            rows, possible = combinations(choices_of(arguments, self.options.arguments))
            rows = sorted(rows, key=lambda row: row != failing)  # what failed before fails first
            found, compared, refused = self.check(made, rows)
            if found:
                failing = found[0].combination
                self.mend(made, found)
                continue
            if self.fix_dead(made, rows, refused) or self.fix_unfollowed(made):
                continue
            accepts = self.accepted(probes=False)
            if accepts != self.accepts:
                self.accepts = accepts
                made = self.written(made.program)
            late = len(rows) - len(compared) - len(refused) if self.is_late() else 0
            return self.finished(made, arguments, compared, possible, refused, late)
        raise Unsupported("nothing that was given up makes it the same robot")

    # One attempt.

    def attempt(self) -> WrittenFiles:
        """Return the files with what has been given up so far; give up what the analysis cannot translate."""
        self.accepts = self.accepted()
        for _ in range(MAX_BUILDS):
            if self.is_late():
                raise Unsupported(f"the translation takes more than {MAX_SECONDS:g} s")
            try:
                program = self.built()
                if self.fix_reached(program):
                    continue
                return self.written(program)
            except Changes as stop:
                self.plan.handed.setdefault(stop.macro.name, set()).update(stop.names)
            except GiveUp as stop:
                self.give_up(stop.subject, stop.problem)
        raise Unsupported("too much of it cannot be translated")

    def give_up(self, subject: Macro | Element | Variable, problem: Unsupported) -> None:
        """Give up a macro, an element, a property or an argument. Raises Unsupported if it is given up already."""
        span = problem.span or (subject.element.span if isinstance(subject, Macro) else subject.span)
        if isinstance(subject, Element):
            self.flatten(subject, problem)
        elif isinstance(subject, Macro):
            if subject.name in self.plan.inlined:
                raise problem
            self.inline(subject.name, problem.reason, span)
        elif subject.where == ARGUMENT:
            text = self.options.arguments.get(subject.name, subject.raw)
            if subject.name in self.plan.fixed or "$" in text:
                raise problem
            self.fix(subject.name, text, WrittenOut(subject.name, problem.reason, span))
        else:
            if subject.span is None or place_of(subject.span) in self.plan.unwritable:
                raise problem
            self.plan.unwritable[place_of(subject.span)] = problem.reason

    def built(self) -> Program:
        trees = [one.tree for one in self.source.known.values() if one.tree is not None]
        self.trees = len(trees)
        return Program(self.path, self.options.packages, self.options.arguments, self.plan, trees)

    def written(
        self, program: Program, words: Found | None = None, shares: frozenset[str] | None = None
    ) -> WrittenFiles:
        choices = choices_of(program.names.arguments, self.options.arguments)
        made = write(program, choices, self.target, self.imported, self.wanted, self.accepts, words, shares)
        return made._replace(packages={**self.options.packages, **made.packages})

    def check(
        self, made: WrittenFiles, rows: Sequence[Combination], in_words: bool = False
    ) -> tuple[list[Fault], list[Combination], list[Combination]]:
        """Return the differences of some combinations, which were compared, and which xacro refuses."""
        elements = made.documents.elements
        return faults(made.files, self.source, rows, made.packages, elements, in_words, self.is_late)

    def is_late(self) -> bool:
        return _seconds() - self.began > MAX_SECONDS

    def accepted(self, probes: bool = True) -> list[Any]:
        """Return what the robots of all combinations have to be accepted for; each rule once."""
        made: dict[tuple[str, str], dict[str, Any]] = {}
        for combination, imported in self.source.known.items():
            if not probes and any(text == PROBE for _, text in combination):
                continue
            for entry in (imported.tree.get("accept") if imported.tree is not None else None) or ():
                key = (str(entry["rule"]), str(entry.get("reason") or ""))
                known = made.setdefault(key, {"rule": key[0], "of": [], "reason": key[1]})
                known["of"] += [str(one) for one in entry.get("of") or () if str(one) not in known["of"]]
        return [{name: value for name, value in entry.items() if value} for entry in made.values()]

    # Giving up.

    def inline(self, name: str, reason: str, span: Span | None) -> None:
        self.plan.inlined.add(name)
        self.lost[name] = WrittenOut(name, reason, span)

    def flatten(self, element: Element, problem: Unsupported) -> None:
        place = place_of(element.span)
        if place in self.plan.flat:
            raise problem
        self.plan.flat.add(place)
        self.flat[place] = WrittenOut(_called(element), problem.reason, problem.span or element.span, flat=True)

    def fix(self, name: str, text: str, why: WrittenOut) -> None:
        self.plan.fixed[name] = text
        self.frozen[name] = why

    def fix_reached(self, program: Program) -> bool:
        """Fix the arguments that may decide what stays as xacro expands it; return True if there are any.

        What was given up may not be reached any more with their values: it is tried again.
        """
        found = False
        for place in self.plan.flat:
            for name in program.reaching(place):
                text = program.names.text_of(name)
                if text is not None:
                    self.fix(name, text, self.flat[place]._replace(name=name))
                    found = True
        if found:
            self.plan.flat.clear()
            self.flat.clear()
            self.plan.inlined.clear()
            self.lost.clear()
        return found

    def fix_dead(self, made: WrittenFiles, rows: Sequence[Combination], refused: Sequence[Combination]) -> bool:
        """Fix variables of the environment of which xacro takes no other value than the one they have."""
        found = False
        for name in made.program.names.environment:
            mine = [row for row in rows if len(row) == 1 and row[0][0] == name]
            text = made.program.names.text_of(name) if name in made.program.names.arguments else None
            taken = [row for row in mine if row not in refused and self.source.read(row).tree is not None]
            if text is not None and mine and not taken:
                reason = f"with another value of the environment variable {name} xacro makes no robot"
                self.fix(name, text, WrittenOut(name, reason, made.program.names.arguments[name].span))
                found = True
        return found

    def fix_unfollowed(self, made: WrittenFiles) -> bool:
        """Fix the arguments that the translation does not follow for any value; return True if there are any."""
        program, used = made.program, made.used
        others = other_values(program.names.arguments, used, self.options.arguments)
        read = {name: text for name, text in others.items() if program.names.arguments[name] in used}
        found = [name for name in others if name not in read and moves(self.source, ((name, others[name]),))]
        if read and self.differs(made, tuple(read.items())):
            found += [name for name, text in read.items() if self.differs(made, ((name, text),))]
        reason = "with another value of it the robot is another than xacro makes"
        for name in found:
            text = program.names.text_of(name)
            if text is not None:
                self.fix(name, text, WrittenOut(name, reason, program.names.arguments[name].span))
        return any(name in self.plan.fixed for name in found)

    def differs(self, made: WrittenFiles, row: Combination) -> bool:
        known = row in self.source.known
        found, *_ = self.check(made, [row])
        if not known:
            self.source.known.pop(row, None)
        return any(not one.refused for one in found)

    # Mending what was found to differ.

    def mend(self, made: WrittenFiles, found: list[Fault]) -> None:
        """Give up what a difference names. Raises Unsupported if there is nothing left."""
        plan, texts = self.plan, [one.text for one in found]
        reckons = [one for one in found if _DIMENSION.search(one.text)]
        plain = {name for one in reckons for name in one.macros} - plan.plain or (
            {""} - plan.plain if reckons else set()
        )
        printed = {match[1] or match[2] for text in texts if (match := _PRINTED.search(text))} - plan.printed
        known = len([one for one in self.source.known.values() if one.tree is not None])
        if plain:
            plan.plain |= plain
        elif not plan.texts and any(map(_NO_LIST.search, texts)):
            plan.texts = True
        elif not plan.lacking and any("is a mapping, not empty" in text for text in texts):
            plan.lacking = True
        elif printed:
            plan.printed |= printed
        elif not plan.turns and any("more than a full turn" in text for text in texts):
            plan.turns = True
        elif self.accepted() != self.accepts or (plan.flat and known > self.trees):
            return  # other arguments break other rules, and have other elements
        elif not self.blame(made, found) and not self.bisect(made, found[0]):
            values = {name: made.program.names.text_of(name) for name, _ in found[0].combination}
            values = {name: text for name, text in values.items() if text is not None and name not in plan.fixed}
            if not values:
                raise Unsupported(texts[0])
            for name, text in values.items():
                self.fix(name, str(text), WrittenOut(name, f"not proven: {texts[0]}", None))

    def blame(self, made: WrittenFiles, found: Sequence[Fault]) -> bool:
        """Give up the macro or the element that a difference is about; return False if it names none."""
        macros = made.program.kept
        by_name = {macro.ours: macro for macro in macros} | {macro.name: macro for macro in macros}
        by_call = {place_of(use.element.span): macro for macro in macros for use in macro.uses}
        for fault in found:
            named = [by_name[name] for name in fault.macros if name in by_name]
            for macro in [*named, *(by_call[place] for place in fault.places if place in by_call)]:
                if macro.name not in self.plan.explicit and (macro.prefix or macro.mount):
                    self.plan.explicit.add(macro.name)
                    return True
                if macro.name not in self.plan.inlined:
                    self.inline(macro.name, f"not proven: {fault.text}", macro.element.span)
                    return True
        properties = {one.ours: one.span for one in made.program.globals if one in made.used}
        for fault in found:
            for span in (properties[name] for name in fault.macros if properties.get(name)):
                if span is not None and place_of(span) not in self.plan.unwritable:
                    self.plan.unwritable[place_of(span)] = fault.text
                    return True
        elements = {
            place_of(one.span): one for file in made.program.files.values() for one in file.document.root.iter()
        }
        for fault in found:
            for place in fault.places:
                if place in elements and place not in self.plan.flat:
                    self.flatten(elements[place], Unsupported(f"not proven: {fault.text}"))
                    return True
        return False

    def bisect(self, made: WrittenFiles, fault: Fault) -> bool:
        """Find the macro without which a difference is gone, and expand it inline; else the names of all."""
        macros = [macro for macro in made.program.kept if macro.name not in self.plan.inlined]
        named = [macro for macro in macros if macro.name not in self.plan.explicit and (macro.prefix or macro.mount)]
        if named:
            self.plan.explicit |= {macro.name for macro in macros}
            return True
        before = copy.deepcopy(self.plan)
        for macro in macros[:MAX_BISECTED]:
            self.plan.inlined.add(macro.name)
            try:
                again, *_ = self.check(self.written(self.built()), [fault.combination])
            except (Changes, GiveUp, Unsupported):
                again = [fault]
            if not again:
                self.inline(macro.name, f"not proven: {fault.text}", macro.element.span)
                return True
            self.plan = copy.deepcopy(before)
        for macro in macros:
            self.inline(macro.name, f"not proven: {fault.text}", macro.element.span)
        return bool(macros)

    # The result.

    def finished(
        self,
        made: WrittenFiles,
        arguments: Mapping[str, Any],
        rows: list[Combination],
        possible: int,
        refused: Sequence[Combination],
        late: int,
    ) -> Translation:
        """Return the translation with words for its elements, and with the files that other robots have, too."""
        program, words, plain = made.program, Found(), None
        lines: tuple[str, ...] = ()
        proven = tuple(rows)
        rows = [row for row in rows if all(text != PROBE for _, text in row)]
        if not self.target.verbatim:
            words, made, lines, plain = self.in_words(made, rows)
        shared: tuple[str, ...] = ()
        sharing = self.target.sharing
        if sharing is not None:
            made = self.with_shared(program, rows, words)
            shared = tuple(sharing.report(made.files))
        macros = sorted(program.kept, key=lambda one: (list(program.files).index(one.file.path), one.element.start))
        kept = [one.name for one in macros if one.body is None or not one.body.is_empty()]
        lost = {name: one for name, one in self.lost.items() if name not in kept}
        for macro in macros_of(program):
            if program.only_sets(macro):
                lost.pop(macro.name, None)
            elif macro.called and macro.name not in kept and macro.name not in lost:
                problem = program.lost.get(macro.name)
                reason = "it makes nothing" if macro.level else "what calls it is written out"
                reason = "its materials are those of the robot" if macro.makes_materials else reason
                reason = problem.reason if problem is not None else reason
                lost[macro.name] = WrittenOut(macro.name, reason, macro.element.span)
        fixed = {name: text for name, text in self.plan.fixed.items() if name in program.names.fixed}
        return Translation(
            made.files,
            tuple(kept),
            (*lost.values(), *self.flat.values()),
            tuple(arguments),
            proven,
            possible,
            tuple(refused),
            tuple(dict.fromkeys(one.name for one in program.macros.values() if not one.called)),
            tuple(name for name in program.names.arguments if name not in arguments),
            executed=tuple(one.name for one in macros_of(program) if one.called and program.only_sets(one)),
            fixed=tuple(fixed.items()),
            environment=tuple(name for name in program.names.environment if name in arguments),
            unfound=made.unfound,
            late=late,
            words=lines,
            plain=plain,
            shared=shared,
            grown=sharing.grown if sharing is not None else {},
            frozen=tuple(one for name, one in self.frozen.items() if name in fixed),
        )

    def in_words(
        self, made: WrittenFiles, rows: list[Combination]
    ) -> tuple[Found, WrittenFiles, tuple[str, ...], Map | None]:
        """Replace raw elements by entries of the language if the robot stays the same."""
        found = first = find(made.documents.plain, made.documents.evaluated, list(self.source.known.values()))
        while found.spots and not self.is_late():
            again = self.written(made.program, found)
            wrong, *_ = self.check(again, rows, in_words=True)
            if not wrong and not self.is_late():
                lines = tuple(words_report(again.documents.said, first))
                return found, again, lines, found.left_of(tree_of(self.imported))
            found = found.without(wrong[0].text) if wrong else Found()
        return Found(), made, tuple(words_report({}, first)), None

    def with_shared(self, program: Program, rows: list[Combination], words: Found) -> WrittenFiles:
        """Return the files with those that other robots of the package have, too, in their place."""
        sharing = self.target.sharing

        def tried(taken: frozenset[str]) -> tuple[WrittenFiles, list[Fault]]:
            made = self.written(program, words, taken)
            wrong = self.check(made, rows, bool(words.spots))[0]
            return made, [Fault("the comparison takes too long", (), ())] if self.is_late() and not wrong else wrong

        taken: frozenset[str] = frozenset()
        made, wrong = tried(taken)
        while wrong and sharing.refuse(wrong[0].text):
            made, wrong = tried(taken)
        for name in list(sharing.apart):
            again, wrong = tried(taken | {name})  # other words for the same thing may do, too
            if not wrong and name not in sharing.apart:
                made, taken = again, taken | {name}
        tried(taken)
        return made


def macros_of(program: Program) -> list[Macro]:
    """Return the macros of a program, each once."""
    return list(dict.fromkeys(program.macros.values()))


def _called(element: Element) -> str:
    """Return what an element is called in the report."""
    called = element.get("macro") if element.tag == "xacro:call" else element.tag.removeprefix("xacro:")
    if "$" in called:
        return f'<xacro:call macro="{called}">'
    if called in (element.tag, "element", "attribute", "insert_block", "include"):
        name = element.get("name")
        return f'<{element.tag} name="{name}">' if name else f"<{element.tag}>"
    return called


def translation_report(translation: Translation) -> Iterator[str]:
    """Yield the lines about a translation for the person who imports the robot."""
    if not translation.files:
        yield f"flat, without macros and arguments: {translation.reason}{_at(translation.span)}"
        return
    macros = [one for one in translation.written_out if not one.flat]
    kept, lost = len(translation.kept), len(macros)
    if kept or lost:
        line = f"{kept} of {counted(kept + lost, 'macro')} kept"
        yield f"{line}, {lost} written out where {'it is' if lost == 1 else 'they are'} called" if lost else line
    yield from (f"  {one.name}: {one.reason}{_at(one.span)}" for one in macros)
    if translation.executed:
        yield f"named values where they are called, because they only set properties: {listed(translation.executed)}"
    flat = [one for one in translation.written_out if one.flat]
    if flat:
        yield f"as xacro expands {_them(flat)}: {counted(len(flat), 'element')}"
    yield from (f"  {one.name}: {one.reason}{_at(one.span)}" for one in flat)
    if translation.idle:
        yield f"left out, because nothing calls {_them(translation.idle)}: {listed(translation.idle)}"
    if translation.arguments:
        yield f"arguments kept: {listed(translation.arguments)}"
    if translation.unused:
        yield f"arguments left out, because nothing uses {_them(translation.unused)}: {listed(translation.unused)}"
    if translation.environment:
        yield f"variables of the environment that are arguments now: {listed(translation.environment)}"
    if translation.fixed:
        fixed = listed([f"{name} ({' '.join(value.split())})" if value else name for name, value in translation.fixed])
        yield f"arguments replaced by their value: {fixed}"
    for reason, names in groupby(translation.frozen, lambda one: f"{one.reason}{_at(one.span)}"):
        yield f"  {listed([one.name for one in names])}: {reason}"
    for package in translation.unfound:
        yield f"it asks for the package {package}: source its workspace, or give --package {package}=FOLDER"
    yield from translation.shared
    proven = len(translation.proven)
    how = "its arguments as they are" if proven == 1 else f"{proven} combinations of its arguments"
    if translation.possible > proven + len(translation.refused):
        how += f" (of {translation.possible}: the defaults, and each argument changed alone)"
    yield f"the same robot as xacro makes it, with {how}"
    if translation.late:
        yield f"not compared, because that takes too long: {counted(translation.late, 'combination')}"
    if translation.refused:
        first = " ".join(f"{name}:={value}" for name, value in translation.refused[0])
        yield f"not compared, because xacro refuses it: {first}"


def _them(items: Sequence[Any]) -> str:
    return "it" if len(items) == 1 else "them"


def _at(span: Span | None) -> str:
    return f" ({Path(span.source.path).name}:{span.line})" if span is not None else ""

"""Translating: a xacro as a description with its macros, arguments and files, proven against the real xacro.

To be read in this order: ``program`` (what is in the files), ``texts``, ``scopes`` and ``expressions`` (what values
are), ``walking`` (what an element is) with ``contexts`` (where it stands: ``among``, ``inside``, ``keeping``),
``calling``, ``setting``, ``returning`` and ``entries`` (what is made), ``naming`` (short names and mounts),
``rendering`` (the files), ``attempting`` and ``proving``, ``fixing`` (what cannot be kept), ``wording`` (elements that
become words), ``sharing`` and ``uniting`` (what several robots of a package include).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs, ReadOptions
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element, MarkupError

from ..description import tree_of
from .attempting import Attempt, Changed, How, accepted, attempt
from .fixing import MOST_SWITCHES, reached, switches_of, undecided, value_of
from .flattened import Place, place_of
from .lifting import can_lift, elements_at, macro_around, own_place
from .pieces import Macro
from .problems import AtTop, InMacro, InProperty
from .program import Fixed, Program
from .proving import PROBE, Combination, Fault, Source, choices_of, combinations, faults, moves, other_values
from .scopes import Variable
from .texts import Unsupported
from .values import ARGUMENTS
from .walking import Walker
from .wording import Found, find
from .wording import wording_report as lines

MAX_ATTEMPTS = 40
_NO_LIST = re.compile(r"is a list, not the text|takes a list, not text")
_DIMENSION = re.compile(r" is an? [\w ]+ \(\S+\), but \S+ is an? [\w ]+ \(| is a number, not an? \w+ \(")
_SPELT = re.compile(r'(?:(\w+)|\w+ "([^"]*)"): xacro has (?:True|False), the translation (?:true|false)\Z')
WITHIN = "what calls it is written out"


class WrittenOut(NamedTuple):
    """A macro that is written out where it is called, or flat: as xacro expands it; why, and its place."""

    name: str
    reason: str
    span: Span | None
    flat: bool = False


class Translation(NamedTuple):
    """The files of a description (text by name), and what became of the macros and arguments of the source.

    ``proven`` are the combinations of arguments that were compared, ``possible`` how many there are, ``refused`` those
    that xacro itself cannot expand, ``fixed`` arguments that have the one value they have here, ``frozen`` says why,
    ``environment`` those that were variables of the environment. ``reason`` says why there are no files. ``words`` are
    the lines about elements that became words, ``plain`` is the robot without those. ``shared`` are the lines about
    files that other robots include, ``grown`` what those were that have more now, by their name.
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
    fixed: tuple[tuple[str, str], ...] = ()
    environment: tuple[str, ...] = ()
    reason: str = ""
    span: Span | None = None
    words: tuple[str, ...] = ()
    plain: Map | None = None
    shared: tuple[str, ...] = ()
    grown: Mapping[str, str] = {}
    frozen: tuple[WrittenOut, ...] = ()


def translate(path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, changed: Changed) -> Translation:
    """Return the description of a xacro, proven; without files, and with a reason, where it cannot be translated.

    ``imported`` is the robot that the xacro expands to with the arguments that are given, ``wanted`` the artifacts
    that its description asks for, ``changed`` what is to be otherwise than in the xacro. Where a part of it is flat, it
    is tried without the arguments that choose; of these come back all that cost nothing.
    """
    source = Source(path, options, changed.name, changed.meshes)
    source.known[()] = imported

    why: dict[str, WrittenOut] = {}

    def tried(fixed: Mapping[str, str]) -> _Mending:
        return _Mending(source, imported, wanted, changed, fixed, why)

    best = tried({})
    if not best.is_whole():
        fixed = _switches(path, options)
        for name in fixed:
            best.freeze(name)
        other = tried(fixed) if fixed else best
        best = other if other.worth() > best.worth() else best
        for name, _ in best.made.fixed[:MOST_SWITCHES]:
            other = tried({one: text for one, text in best.made.fixed if one != name})
            best = other if other.worth() > best.worth() else best
    return best.shared(best.made if changed.verbatim else best.in_words())


def _switches(path: Path, options: ReadOptions) -> dict[str, str]:
    """Return the arguments of a xacro that choose, with their texts."""
    fixed: dict[str, str] = {}
    while True:
        try:
            program = Program(path, options.packages, options.arguments, fixed=fixed)
            with suppress(InMacro, InProperty, AtTop):
                Walker(program, frozenset()).walk()
        except Fixed as found:
            fixed[found.name] = found.text
        except (Unsupported, MarkupError):
            return {}
        else:
            return switches_of(program)


class _Mending:
    """Attempts at one translation, each without what was wrong with the one before."""

    def __init__(
        self,
        source: Source,
        imported: Imported,
        wanted: Outputs,
        changed: Changed,
        fixed: Mapping[str, str],
        why: dict[str, WrittenOut],
    ) -> None:
        self.source = source
        self.imported = imported
        self.wanted = wanted
        self.changed = changed
        self.fixed = dict(fixed)
        self.why = why
        self.lost: list[WrittenOut] = []
        self.proven: _Proven | None = None
        self.words = Found()
        self.changing: frozenset[str] = frozenset()
        self.begin()
        self.made = self.translated()

    def freeze(self, name: str, reason: str = "", span: Span | None = None) -> None:
        """Take down why an argument is none any more: the first thing that had to be written out, if not said."""
        lost = [one for one in (*self.lost, *self.out.values(), *self.flat.values()) if one.reason]
        if not reason and lost:
            reason, span = lost[0].reason, lost[0].span
        if not reason and self.last:
            reason = self.last[0].text
        self.why.setdefault(name, WrittenOut(name, reason, span))

    def is_whole(self) -> bool:
        """Say whether there is a translation, nothing of it is flat, and every argument is one."""
        made = self.made
        return bool(made.files) and not made.fixed and not any(one.flat for one in made.written_out)

    def worth(self) -> tuple[bool, int, int, int]:
        """Return what tells a better translation: whether there is one, the macros it keeps, what is flat or fixed."""
        made = self.made
        return bool(made.files), len(made.kept), -sum(one.flat for one in made.written_out), -len(made.fixed)

    def in_words(self) -> Translation:
        """Return the translation with what its elements say in words, as far as it is the same robot with them."""
        if self.proven is None or not self.made.files:
            return self.made
        first, how, rows = self.proven
        found = find(first.documents.plain, first.documents.evaluated, list(self.source.known.values()))
        told = found
        while found.spots:
            again = attempt(self.source.path, self.source.options, how._replace(words=found))
            wrong, _ = faults(again.files, self.source, rows, again.packages, again.documents.elements, in_words=True)
            if not wrong:
                left = found.left_of(tree_of(how.imported))
                said = tuple(lines(again.documents.said, told))
                self.words = found
                return self.made._replace(files=again.files, words=said, plain=left)
            found = found.without(wrong[0].text)
        return self.made._replace(words=tuple(lines({}, told)))

    def shared(self, made: Translation) -> Translation:
        """Return a translation with the files that it shares with other robots in their place."""
        sharing = self.changed.sharing
        if sharing is None or self.proven is None or not made.files:
            return made
        proven = self.proven
        taken: frozenset[str] = frozenset()
        files, wrong = self.with_shared(proven, taken)
        while wrong and sharing.refuse(wrong[0].text):
            files, wrong = self.with_shared(proven, taken)
        for name in list(sharing.apart):
            again, wrong = self.with_shared(proven, taken | {name})  # other words for the same thing may do, too
            if not wrong and name not in sharing.apart:
                files, taken = again, taken | {name}
        self.with_shared(proven, taken)
        return made._replace(files=files, shared=tuple(sharing.report(files)), grown=sharing.grown)

    def with_shared(self, proven: _Proven, taken: frozenset[str]) -> tuple[dict[str, str], list[Fault]]:
        """Return the files, of some those that others have for it, and why that is not the same robot."""
        how = proven.how._replace(words=self.words, shares=taken)
        again = attempt(self.source.path, self.source.options, how)
        spots = bool(self.words.spots)
        wrong, _ = faults(again.files, self.source, proven.rows, again.packages, again.documents.elements, spots)
        return again.files, wrong

    def begin(self) -> None:
        """Forget what was found to be wrong."""
        self.out: dict[str, WrittenOut] = {}
        self.flat: dict[Place, WrittenOut] = {}
        self.lifted: dict[Place, WrittenOut] = {}
        self.unsaid: dict[str, str] = {}
        self.explicit: set[str] = set()
        self.texts = self.turns = self.chains = self.lacking = False
        self.spelt: frozenset[str] = frozenset()
        self.plain: frozenset[str] = frozenset()
        self.last: list[Fault] = []

    def translated(self) -> Translation:
        """Return the translation, or why there is none."""
        for _ in range(MAX_ATTEMPTS):
            try:
                found = self.once()
            except Fixed as problem:
                found = None
                self.fixed[problem.name] = problem.text
                said = f'what is included is named by it: "{problem.element.get("filename")}"'
                self.freeze(problem.name, said, problem.element.span)
            except InMacro as problem:
                found = None if self.set_aside(problem.problem, problem.macro) else self.in_macro(problem)
            except InProperty as problem:
                found = Translation({}, reason=problem.reason) if problem.name in self.unsaid else None
                self.unsaid[problem.name] = problem.reason
            except AtTop as problem:
                found = None if self.set_aside(problem.problem, None) else self.at_top(problem)
            except Unsupported as problem:
                found = _nothing(problem)
            except MarkupError as problem:
                found = Translation({}, reason=problem.diagnostic.message, span=problem.diagnostic.span)
            if found is not None:
                return found
        return Translation({}, reason=self.last[0].text if self.last else "no end of mending")

    def set_aside(self, problem: Unsupported, macro: Macro | None) -> bool:
        """Lift the one element that a problem is about out of its macro, or take it as it is expanded; say whether."""
        place, element = own_place(problem), problem.element
        if place is None or element is None or place in self.flat:
            return False
        if macro is None or place in self.lifted:  # it cannot be said at the top either
            self.lifted.pop(place, None)
            self.flat[place] = _flat(element, problem)
            return True
        if not can_lift(macro, element, self.lifted):
            return False
        self.lifted[place] = _flat(element, problem)._replace(flat=False)
        return True

    def at_top(self, problem: AtTop) -> Translation | None:
        """Take what stands at the top of a file as it is expanded; say so if that was done already."""
        place = place_of(problem.element.span)
        found = _nothing(problem.problem) if place in self.flat else None
        self.flat[place] = _flat(problem.element, problem.problem)
        return found

    def in_macro(self, problem: InMacro) -> Translation | None:
        """Write a macro out; say so if that was done already."""
        name = problem.macro.name
        if name in self.out:
            return _nothing(problem.problem)
        self.out[name] = WrittenOut(name, problem.problem.reason, problem.problem.span or problem.macro.place)
        return None

    def once(self) -> Translation | None:
        """Return the translation if it is proven, or if nothing is left to be mended; None to try again."""
        source, options = self.source, self.source.options
        accepts = accepted(source)
        trees = [one.tree for one in source.known.values() if one.tree is not None]
        how = How(
            self.imported,
            self.wanted,
            self.changed,
            frozenset(self.out),
            frozenset(self.explicit),
            accepts,
            frozenset(self.flat),
            trees,
            self.unsaid,
            self.texts,
            self.turns,
            self.fixed,
            frozenset(self.lifted),
            self.changing,
        )
        how = how._replace(chains=self.chains, plain=self.plain, lacking=self.lacking, spelt=self.spelt)
        made = attempt(source.path, options, how)
        source.environment = made.program.environment.keys()
        used = {name: one for name, one in made.program.arguments.items() if one.used}
        choices = choices_of(used, options.arguments)
        rows, possible = combinations(choices)
        self.last, refused = faults(made.files, source, rows, made.packages, made.documents.elements)
        if self.last:
            return self.mend(made, len(accepts), len(trees))
        more = undecided(reached(made.program, self.flat), choices) or self.unfollowed(made, used) or self.unread(made)
        if more:  # what there is would not follow them
            self.fix(more, made.program)
            return None
        wanted = accepted(source, probes=False)  # nobody asks for the probes any more
        if wanted != accepts:
            how = how._replace(accepts=wanted)
            made = attempt(source.path, options, how)
        self.proven = _Proven(made, how, [row for row in rows if all(text != PROBE for _, text in row)])
        frozen = tuple(self.why[name] for name in made.program.fixed if name in self.why)
        told = {**self.flat, **self.lifted}
        return _translation(made, self.out, told, rows, possible, refused)._replace(frozen=frozen)

    def fix(self, arguments: Mapping[str, str], program: Program) -> None:
        """Begin anew without some arguments; what is flat and follows them says why."""
        for name in arguments:
            flat = next((one for place, one in self.flat.items() if name in reached(program, [place])), None)
            self.freeze(name, flat.reason if flat else "", flat.span if flat else None)
        self.lost += [*self.out.values(), *self.flat.values()]
        self.fixed |= arguments
        self.begin()

    def mend(self, made: Attempt, accepts: int, trees: int) -> Translation | None:
        """Find out what to do otherwise the next time; return why there is no translation if nothing is left.

        ``accepts`` and ``trees`` are how many rules were accepted and how many robots known when this was attempted.
        """
        source, texts = self.source, [one.text for one in self.last]
        reckons = [one for one in self.last if _DIMENSION.search(one.text)]
        plain = {name for one in reckons for name in one.macros} - self.plain
        plain = plain or ({ARGUMENTS} - self.plain if reckons else plain)
        if plain:
            self.plain |= plain
            return None
        if made.chosen:
            self.chains = True
            return None
        if not self.texts and any(map(_NO_LIST.search, texts)):
            self.texts = True
            return None
        if not self.lacking and any("is a mapping, not empty" in text for text in texts):
            self.lacking = True
            return None
        spelt = {found[1] or found[2] for text in texts if (found := _SPELT.search(text))} - self.spelt
        if spelt:
            self.spelt |= spelt
            return None
        if not self.turns and any("more than a full turn" in text for text in texts):
            self.turns = True
            return None
        if made.program.changed() - self.changing:
            self.changing |= made.program.changed()
            self.begin()
            return None
        if len(accepted(source)) > accepts:  # other arguments break other rules
            return None
        if self.flat and len([one for one in source.known.values() if one.tree is not None]) > trees:
            return None
        frozen = reached(made.program, self.flat)
        changed = {name: frozen[name] for name, _ in self.last[0].combination if name in frozen}
        if changed:  # what is flat does not follow them
            self.fix(changed, made.program)
        elif not _blame(self.last, made, self.out, self.explicit, self.flat, self.unsaid):
            return self.without_choice(made, texts[0])
        return None

    def without_choice(self, made: Attempt, reason: str) -> Translation | None:
        """Begin anew without the arguments that nothing can be made of otherwise; return why there are none."""
        values = {name: value_of(made.program, name) for name, _ in self.last[0].combination}
        found = {name: text for name, text in values.items() if text is not None and name not in self.fixed}
        if not found:
            return Translation({}, reason=reason)
        self.lost.append(WrittenOut("", f"not proven: {reason}", None))
        self.fix(found, made.program)
        return None

    def unread(self, made: Attempt) -> dict[str, str]:
        """Return the arguments that the translation does not read, but that xacro makes another robot of."""
        others = {name: one for name, one in made.program.arguments.items() if not one.used}
        rows = other_values(others, self.source.options.arguments)
        found = {
            name: value_of(made.program, name) for name, text in rows.items() if moves(self.source, ((name, text),))
        }
        return {name: text for name, text in found.items() if text is not None}

    def unfollowed(self, made: Attempt, used: Mapping[str, Variable]) -> dict[str, str]:
        """Return the arguments that may be any number or text, but that the translation does not follow."""
        source, given = self.source, self.source.options.arguments
        others = other_values(used, given)

        def differs(row: Combination) -> bool:
            known = row in source.known
            found, _ = faults(made.files, source, [row], made.packages, made.documents.elements)
            if not known:
                source.known.pop(row, None)  # nobody asks for it
            return any(not one.refused for one in found)

        if not others or not differs(tuple(others.items())):
            return {}
        found = {name: value_of(made.program, name) for name, text in others.items() if differs(((name, text),))}
        for name in found:
            self.freeze(
                name,
                "with another value of it the robot is another than xacro makes",
                made.program.arguments[name].span,
            )
        return {name: text for name, text in found.items() if text is not None}


def _nothing(problem: Unsupported) -> Translation:
    return Translation({}, reason=problem.reason, span=problem.span)


def _flat(element: Element, problem: Unsupported) -> WrittenOut:
    called = element.get("macro") if element.tag == "xacro:call" else element.tag.removeprefix("xacro:")
    name = element.get("name")
    what = called
    if "$" in called:
        what = f'<xacro:call macro="{called}">'
    elif called in (element.tag, "element", "attribute", "insert_block"):
        what = f'<{element.tag} name="{name}">' if name else f"<{element.tag}>"
    return WrittenOut(what, problem.reason, problem.span or element.span, flat=True)


def _flat_at(program: Program, place: Place, reason: str) -> WrittenOut:
    """Return what is told of an element that is flattened because its translation is not proven."""
    for file in program.files.values():
        for element in file.document.root.iter():
            if place_of(element.span) == place:
                return _flat(element, Unsupported(reason))
    return WrittenOut(f"line {place[1]}", reason, None, flat=True)


def _translation(
    made: Attempt,
    out: Mapping[str, WrittenOut],
    flat: Mapping[Place, WrittenOut],
    rows: list[Combination],
    possible: int,
    refused: list[Combination],
) -> Translation:
    kept = [macro.name for macro in made.macros if macro.body is None or not macro.body.is_empty()]
    lost = dict(out)
    for name, macro in made.program.macros.items():
        if macro.called and name not in kept and name not in lost:
            lost[name] = WrittenOut(name, "what it makes has no word as a value", macro.place)
    used = [name for name, variable in made.program.arguments.items() if variable.used]
    lost |= {one.name: one for one in flat.values() if one.name in kept or one.name in lost}
    kept = [name for name in kept if name not in lost]
    others = {(one.name, one.reason): one for one in flat.values() if one.name not in lost}
    called = made.program.called()
    told = {*kept, *lost, *(one.name for one in flat.values())}
    others |= {(name, WITHIN): WrittenOut(name, WITHIN, None) for name in made.program.macros if name in called - told}
    unused = [name for name in made.program.arguments if name not in used]
    idle = [name for name in made.program.macros if name not in called]
    proven = tuple(row for row in rows if row not in refused)
    return Translation(
        made.files,
        tuple(kept),
        (*lost.values(), *others.values()),
        tuple(used),
        proven,
        possible,
        tuple(refused),
        tuple(idle),
        tuple(unused),
        tuple(made.program.fixed.items()),
        tuple(name for name in made.program.environment if name in used),
    )


def _blame(
    found: list[Fault],
    made: Attempt,
    out: dict[str, WrittenOut],
    explicit: set[str],
    flat: dict[Place, WrittenOut],
    unsaid: dict[str, str],
) -> bool:
    """Give the macros at fault long names, or write them out; say whether there was anything to change."""
    by_name = {macro.ours: macro for macro in made.macros} | {macro.name: macro for macro in made.macros}
    inner = {place_of(one.span): one for one in _inner_elements(made.program, found)}
    for fault in found:
        places = [place for place in fault.own if place in inner and place not in flat]
        if places and any(name in out for name in fault.macros):  # its macro was not to blame
            flat[places[0]] = _flat(inner[places[0]], Unsupported(f"not proven: {fault.text}"))
            return True
        for name in fault.macros:
            macro = by_name.get(name)
            if macro is not None and _demote(macro, fault, out, explicit):
                return True
    if _leave_unsaid(found, made, unsaid):
        return True
    for fault in found:
        for place in fault.tops:
            if place not in flat:
                flat[place] = _flat_at(made.program, place, f"not proven: {fault.text}")
                return True
    for macro in made.macros:
        if macro.body is not None and macro.name not in explicit and (macro.prefix or macro.mount):
            explicit.update(one.name for one in made.macros)
            return True
    left = [macro for macro in made.macros if macro.name not in out]
    for macro in left:
        out[macro.name] = WrittenOut(macro.name, f"not proven: {found[0].text}", macro.place)
    return bool(left)


def _leave_unsaid(found: Sequence[Fault], made: Attempt, unsaid: dict[str, str]) -> bool:
    """Leave out the first property that is at fault; say whether there is one."""
    properties = {
        one.ours: name
        for name in made.program.properties
        if isinstance(one := made.program.scope.names.get(name), Variable)
    }
    for fault in found:
        for name in fault.macros:
            if name in properties and properties[name] not in unsaid:
                unsaid[properties[name]] = fault.text
                return True
    return False


def _inner_elements(program: Program, found: Sequence[Fault]) -> list[Element]:
    """Return the elements of macros that faults name."""
    elements = elements_at(program, {place for fault in found for place in fault.own})
    return [one for one in elements if macro_around(one) is not None]


def _demote(macro: Macro, fault: Fault, out: dict[str, WrittenOut], explicit: set[str]) -> bool:
    if macro.body is not None and macro.name not in explicit and (macro.prefix or macro.mount):
        explicit.add(macro.name)
        return True
    if macro.name in out:
        return False
    out[macro.name] = WrittenOut(macro.name, f"not proven: {fault.text}", macro.place)
    return True


class _Proven(NamedTuple):
    """An attempt that is proven: how it was made, and for which combinations of arguments."""

    made: Attempt
    how: How
    rows: list[Combination]


__all__ = ["Changed", "Translation", "WrittenOut", "translate"]

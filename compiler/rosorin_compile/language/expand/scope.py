"""Scopes: names and their values, lexically nested; expressions, loops and conditions evaluated in them.

A named value is evaluated when it is first needed, once. ``resolve`` returns a new tree: pieces without any expression
are taken over as they are. ``rounds`` yields a scope for each round of a ``for``; ``explained`` says where an
expression is wrong, and ``short`` tells a value in a few letters.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NoReturn

from rosorin_compile.source.diagnostics import MAX_LISTED, Help, Related, Span, Suggestion, error, nearest
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Instance, Kept, Map, Place, Seq
from rosorin_compile.source.units import UNITS
from rosorin_compile.source.wording import first_of
from rosorin_compile.source.xml.elements import fitted

from ..expression import CHOICES, Piece, compiled, evaluate, names_in, pieces
from ..expression.functions import (
    BUILT_IN,
    CONSTANTS,
    FUNCTIONS,
    OF_DESCRIPTIONS,
    ExpressionError,
    KindError,
    functions,
    kind_of,
)
from ..expression.syntax import weight
from ..schema import keys_of_xml
from ..suggestions import flag_meant, number_meant, unit_meant
from .ledger import Failed, Ledger, LeftOut
from .tracing import OF_KINDS, Traced, given, given_at, is_like_a_number

RULES = (
    Rule(
        "expression",
        "An expression cannot be read or has no value: an unknown name, kinds that do not go together, a division by "
        "zero.",
        "Correct it; [what is allowed](language.md#expressions).",
        ARGUMENTS,
    ),
    Rule("cycle", "A named value needs itself.", "Give one of the circle a value of its own.", ARGUMENTS),
    Rule("too-large", "Loops and parts make more values than any robot has.", "Use smaller loops.", ARGUMENTS),
)


MAX_NODES = 1_500_000
_OF_XACRO = re.compile(r"\$\((find|arg|env|optenv|eval|dirname|anon)\b([^)]*)\)")
_NO_LOOP: Mapping[str, Span] = {}
# How often a named value that takes values may stand in itself.
MAX_CALLED = 30
# Steps of all expressions together (some ten seconds); one of them may take a seventh of it.
MAX_WORK = 20_000_000
# Rules that speak of an entry and not of its name, though they are told there.
_OF_ENTRIES = ("missing-key", "unknown-key", "ignored-key", "part-cycle")


class Scope:
    """Names of one part, loop or description, within ``parent``; ``via`` tells how the expansion came here.

    ``prefix`` stands before the names of all that a part here makes.
    """

    def __init__(self, ledger: Ledger, parent: Scope | None = None, via: Instance | None = None) -> None:
        self.ledger = ledger
        self.parent = parent
        self.via: Instance | None = via or (parent.via if parent else None)
        self.values: dict[str, Any] = {}
        self.places: dict[str, Place] = {}
        # Where the values stand that were written here, not given from outside: named values and defaults.
        self.said: dict[str, Place] = {}
        # The parameters of a part, of a type of sensors, or of the description, by name.
        self.declared: Mapping[str, Any] = {}
        self.mount: Place | None = None  # where a part was told the frame that it is attached to
        self.pending: dict[str, tuple[Any, Place]] = {}
        self.broken: set[str] = set()
        # Where the names of a loop stand, whose places are those of their values.
        self.looped: Mapping[str, Span] = _NO_LOOP
        self.running: list[str] = parent.running if parent else []
        self.prefix: str = parent.prefix if parent else ""
        if via is not None:
            ledger.scopes[id(via)] = self
        if ledger.root is None:
            ledger.root = self

    def inner(self, via: Instance) -> Scope:
        """Return a scope within this one, for a round of a loop."""
        return Scope(self.ledger, self, via)

    def define(self, name: str, value: Any, place: Place, value_place: Place | None = None) -> None:
        """Add a named value, not evaluated yet: named at ``place``, written at ``said``. A name taken is reported."""
        if name.endswith(")") and "(" in name:
            self._define_called(name, value, place, value_place or place)
            return
        if name in self.places:
            related = [Related("first defined here", self.places[name].span)]
            self.report("duplicate-name", f'the value "{name}" is named twice', place, "rename one", related)
            return
        if not name.isidentifier():
            help = "use letters, digits and underscores, and begin with a letter"
            self.report("bad-name", f'"{name}" cannot be used in an expression', place, help)
        self.places[name] = place
        self.said[name] = value_place or place
        self.pending[name] = (value, value_place or place)

    def _define_called(self, name: str, value: Any, place: Place, value_place: Place) -> None:
        """Add a named value that takes values itself: ``box(x, y)``. What is wrong with its name is reported."""
        own, _, given = name.partition("(")
        parameters = parameters_of(given.removesuffix(")"))
        if parameters is None or not own.isidentifier() or own in functions() or own in OF_DESCRIPTIONS:
            taken = own in functions() or own in OF_DESCRIPTIONS
            message = f'"{own}" is a function of the language' if taken else f'"{name}" cannot be called'
            self.report("bad-name", message, place, "write NAME(FIRST, SECOND): letters, digits and underscores")
            return
        if own in self.places:
            related = [Related("first defined here", self.places[own].span)]
            self.report("duplicate-name", f'the value "{own}" is named twice', place, "rename one", related)
            return
        self.places[own], self.said[own] = place, value_place
        self.values[f"{own}()"] = Called(self, own, parameters, value, value_place)

    def define_all(self, lets: Any) -> None:
        """Add the named values of a ``let`` section; nothing if there is none."""
        if isinstance(lets, Map):
            for name, value in lets.items():
                value_place = Place(lets.value_spans[name], lets.via)
                self.define(name, value, Place(lets.key_spans[name], lets.via), value_place)

    def bind(self, name: str, value: Any, place: Place) -> None:
        """Add a value that is known already."""
        self.places[name] = place
        self.values[name] = value

    def report(
        self,
        rule: str,
        message: str,
        place: Place,
        help: Help = "",
        related: Sequence[Related] = (),
        of_kinds: bool | None = None,
    ) -> None:
        """Add an error at a place, or at the argument behind it, with the includes and parts that led to it.

        ``of_kinds`` says whether it is a mistake of kinds, where the rule does not.
        """
        kinds = rule in OF_KINDS if of_kinds is None else of_kinds
        trace = None if rule in _OF_ENTRIES else given_at(self, place.span, kinds)
        self.report_traced(rule, message, place, help, related, trace)

    def report_traced(
        self, rule: str, message: str, place: Place, help: Help, related: Iterable[Related], trace: Traced | None
    ) -> None:
        """Add an error at a place, or at the argument that the value there comes of: there one for all expressions."""
        stack = tuple(self.via.stack()) if self.via else place.stack()
        uses = trace.related(place.span) if trace else ()
        span = trace.span if trace else place.span
        if trace and rule == "expression":
            outermost = (span, stack[-1:])
            if outermost in self.ledger.blamed:
                return
            self.ledger.blamed.add(outermost)
        self.ledger.diagnostics.append(error(rule, message, span, help, [*related, *uses, *stack]))

    def lookup(self, name: str) -> Any:
        """Return the value of a name. Raises KeyError if there is none, Failed if its own expression is wrong."""
        scope: Scope | None = self
        while scope is not None:
            values = scope.values
            if name in values:
                return values[name]
            if name in scope.pending or name in scope.broken:
                return scope.evaluate_pending(name)
            if name.endswith(CHOICES) and name.removesuffix(CHOICES) in scope.places:
                break  # this scope has another value of that name
            scope = scope.parent
        raise KeyError(name)

    def evaluate_pending(self, name: str) -> Any:
        """Return the value of a name of this very scope that nobody has needed so far."""
        if name in self.broken:
            raise Failed
        mark = f"{name}@{id(self)}"
        if mark in self.running:
            self._cycle(mark)
        self.running.append(mark)
        try:
            self.values[name] = self.resolve(*self.pending[name])
        except Failed:
            self.broken.add(name)
            raise
        finally:
            self.running.pop()
        del self.pending[name]
        return self.values[name]

    def _cycle(self, mark: str) -> None:
        chain = [step.partition("@")[0] for step in [*self.running[self.running.index(mark) :], mark]]
        related = [
            Related(f'"{step}" is named here', self.places[step].span) for step in chain[1:-1] if step in self.places
        ]
        message = f"{' -> '.join(chain)}: the value needs itself"
        self.report("cycle", message, self.places[chain[0]], "give one of them a value of its own", related)
        self.broken.update(chain)
        raise Failed

    def known_names(self) -> set[str]:
        """Return all names that were given here and around here, without constants, units and functions."""
        outer = self.parent.known_names() if self.parent else set()
        return outer | set(self.places)

    def resolve(self, value: Any, place: Place, xml: bool = False) -> Any:
        """Return a value of the tree with everything in it evaluated. Raises Failed after reporting.

        ``xml``: its texts are elements of XML.
        """
        if self.ledger.is_constant(value):
            return value
        if isinstance(value, Map):
            return self.mapping(value)
        if isinstance(value, Seq):
            return self.sequence(value, xml)
        return self.text(value, place.span, place.via, xml)

    def _value(self, item: Any, span: Span, via: Instance | None, xml: bool = False) -> Any:
        """Return an item that is not constant, evaluated."""
        if type(item) is Map:
            return self.mapping(item)
        if type(item) is Seq:
            return self.sequence(item, xml)
        return self.text(item, span, via, xml)

    def mapping(self, value: Map) -> Map:
        """Return a mapping with its keys and values evaluated, its loops unrolled and its conditions decided.

        A key whose expression gives ``none`` is left out: that is how a part passes an optional argument on.
        """
        via = self.via or value.via
        made = Map(value.span, via)
        plan = self.ledger.plan(value)
        xml = keys_of_xml()  # a value that comes to stand in an element has to be spelt as XML spells it
        self.count(len(plan) + 1, value.span, via)
        failed = False
        for key, item, constant, controlled, named in plan:
            span = value.value_spans[key]
            try:
                if controlled or named:
                    self._entries_of(made, value, key, item, via)
                    continue
                resolved = item if constant else self._value(item, span, via, key in xml)
                if resolved is None and not constant:
                    continue
                made[key] = resolved
                made.key_spans[key] = value.key_spans[key]
                made.value_spans[key] = span
            except Failed:
                failed = True
        if failed:
            raise Failed
        return made

    def _entries_of(self, made: Map, value: Map, key: str, item: Any, via: Instance | None) -> None:
        """Add the entries that one entry with a loop, a condition or an expression in its name makes."""
        key_span, span = value.key_spans[key], value.value_spans[key]
        for scope, entry in self.entries(item, key):
            name = scope.name(key, key_span, via) if "$" in key else key
            if name in made:
                related = [Related("first defined here", made.key_spans[name])]
                help = "use the loop's value in the name" if isinstance(item, Map) and "for" in item else ""
                message = f'the key "{name}" stands twice in one mapping'
                self.report("duplicate-key", message, Place(key_span, via), help, related)
                raise Failed
            entry = scope.resolve(entry, Place(span, via))
            if "$" in key and isinstance(entry, Map) and scope is not self:
                entry = entry.by(scope.via)  # what is the same in every round does not know which one gave its name
            made.put(name, entry, key_span, span)

    def name(self, key: str, span: Span, via: Instance | None) -> str:
        """Return a key with its expressions evaluated; it has to be text or a number."""
        name = self.text(key, span, via)
        if type(name) is str:
            return name
        if isinstance(name, (str, int, float)):
            return str(FUNCTIONS["str"](name))
        self.report("wrong-type", f"a name is text, not {kind_of(name)}", Place(span, via), "put it inside text")
        raise Failed

    def sequence(self, value: Seq, xml: bool = False) -> Seq:
        """Return a sequence with its items evaluated, its loops unrolled and its conditions decided."""
        via = self.via or value.via
        made = Seq(value.span, via)
        plan = self.ledger.plan(value)
        self.count(len(plan) + 1, value.span, via)
        failed = False
        for (_, item, constant, controlled, _), span in zip(plan, value.value_spans, strict=True):
            try:
                if controlled:
                    for scope, entry in self.entries(item):
                        found = scope.resolve(entry, Place(span, via), xml)
                        made.put(Kept(found, scope.via or via) if xml and isinstance(found, str) else found, span)
                else:
                    made.append(item if constant else self._value(item, span, via, xml))
                    made.value_spans.append(span)
            except Failed:
                failed = True
        if failed:
            raise Failed
        return made

    def count(self, nodes: int, span: Span, via: Instance | None) -> None:
        """Count values that are made. Raises Failed when the description grows beyond all measure."""
        self.ledger.nodes += nodes
        Progress.step("expanding parts" if self.ledger.parts else "expanding", self.ledger.parts)
        if self.ledger.nodes > MAX_NODES:
            if not self.ledger.full:
                self.ledger.full = True
                message = f"the description grows beyond {MAX_NODES:,} values"
                self.report("too-large", message, Place(span, via), "use fewer or smaller loops")
            raise Failed

    def _too_much_work(self, place: Place) -> NoReturn:
        """Raise Failed, after reporting it once: the expressions of the description take too long together."""
        if not self.ledger.full:
            self.ledger.full = True
            message = f"the expressions of the description take more than {MAX_WORK:,} steps together"
            self.report("too-large", message, place, "use fewer or smaller loops, or calculate once, under let")
        raise Failed

    def entries(self, item: Any, key: str = "", is_use: bool = False) -> Iterator[tuple[Scope, Any]]:
        """Yield an entry with the scope to evaluate it in: for each round of its ``for``, where its ``if`` holds.

        What is left out is noted under its ``key``.
        """
        if not isinstance(item, Map) or ("for" not in item and "if" not in item):
            yield self, item
            return
        body, scope = self.ledger.body(item), None
        for scope in rounds(self, item):
            if "if" not in item or scope.condition(item["if"], Place(item.value_spans["if"], self.via or item.via)):
                yield scope, body
            else:
                self.ledger.left_out.append(LeftOut(key, item, scope, is_use, is_empty=False))
        if scope is None:
            self.ledger.left_out.append(LeftOut(key, item, self, is_use, is_empty=True))

    def condition(self, value: Any, place: Place) -> bool:
        """Return whether an ``if`` holds; it has to be true or false."""
        resolved = self.resolve(value, place)
        if isinstance(resolved, bool):
            return resolved
        what = f'"{resolved}"' if isinstance(resolved, (str, int, float)) else kind_of(resolved)

        help = flag_meant(resolved) or "compare it: ${n > 0}"
        elsewhere = isinstance(value, str) and "$" in value and given_at(self, place.span, of_kinds=True) is None
        if help.startswith("write") and elsewhere:
            help = f"where the value comes from, {help}"
        self.report("wrong-type", f"a condition is true or false, not {what}", place, help)
        raise Failed

    def text(self, text: str, span: Span, via: Instance | None, xml: bool = False) -> Any:
        """Return text with its ``${...}`` replaced; text that is one expression has the type of its value.

        In ``xml`` a value is spelt so that it stays a value; one that is whole elements may stand between elements.
        """
        parts: list[str] = []
        for piece in pieces(text):
            if not piece.is_expression:
                if "$(" in piece.text:
                    self._check_no_xacro(text, piece, Place(span, via))
                parts.append(piece.text)
                continue
            if piece.unclosed:
                where = shifted(Place(span, via), text, piece.offset)
                self.report("expression", 'the "}" of an expression is missing', where, "close it")
                raise Failed
            try:
                value = evaluate(piece.text, self.lookup)
                if self.ledger.work > MAX_WORK:
                    self._too_much_work(Place(span, via))
                if isinstance(value, (list, dict)):
                    self.count(weight(value), span, via)
                if piece.is_whole:
                    return as_tree(value, span, via) if type(value) is list else value
                worded = FUNCTIONS["str"](value)
                parts.append(fitted("".join(parts), worded) if xml else worded)
            except ExpressionError as problem:
                self._explain(problem, piece, text, Place(span, via))
                raise Failed from None
        return "".join(parts)

    def _check_no_xacro(self, text: str, piece: Piece, place: Place) -> None:
        """Raise Failed, after reporting it, for a substitution of xacro, which would reach the artifacts as it is.

        In elements of XML it may be meant for another program.
        """
        found = _OF_XACRO.search(piece.text)
        if found is None or "<" in text:
            return
        kind, rest = found[1], found[2].strip()
        name = rest.split()[0] if rest else "NAME"
        help = {"find": f"write package://{name}", "eval": f"write ${{{rest}}}", "dirname": "write the path from here"}
        way_out = help.get(kind, f"write ${{{name}}}, with {name} under args")
        where = shifted(place, text, piece.offset + found.start())
        self.report("expression", f'"{found[0]}" has a meaning in xacro, and none here', where, way_out)
        raise Failed

    def _explain(self, problem: ExpressionError, piece: Piece, text: str, place: Place) -> None:
        """Report what is wrong with an expression, where in it, and where the names that it uses come from."""
        where, help = explained(problem, piece, text, place, self.known_names())
        names = [] if problem.unknown else [name for name in names_in(piece.text) if self.place_of(name)]
        if not help:
            values = self._had(names)
            text_for = next((name for name, value in values.items() if is_like_a_number(value)), "")
            if text_for:  # a mistake in what the name stands for: told there, once for all that use it
                self._tell_text(text_for, values[text_for], where)
                return
            empty = [name for name, value in values.items() if value is None]
            help = f'"{empty[0]}" has no value: write one behind its name, or ask: != none' if empty else ""
        of_kinds = isinstance(problem, KindError)
        trace = given(self, names, of_kinds) if _is_allowed(piece.text) else None
        told = (trace.span, *trace.others) if trace else ()
        related = [
            Related(f'"{name}" comes from here', span)
            for name in names[:3]
            if (span := self.place_of(name)) not in told
        ]
        meant = nearest(problem.unknown, self.known_names()) if problem.unknown else None
        if meant:
            near = self.named_at(meant)
            is_name = near is not None and near.source.line(near.line).startswith(meant, near.column - 1)
            related = [Related(f'"{meant}" {"is named" if is_name else "comes from"} here', near)]
        if problem.near is not None:
            related.insert(0, Related("the suggestion is defined here", problem.near))
        self.report_traced("expression", problem.message, where, help, related, trace)

    def _had(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the values of those names that have one by now; nothing is evaluated for a message."""
        values: dict[str, Any] = {}
        for name in names:
            scope: Scope | None = self
            while scope is not None and name not in scope.places:
                scope = scope.parent
            if scope is not None and name in scope.values:
                values[name] = scope.values[name]
        return values

    def _tell_text(self, name: str, text: str, used: Place) -> None:
        """Report a name that stands for a text which was to be a number, at its own place."""
        trace = given(self, [name]) or Traced(self.place_of(name) or used.span)
        message = f'"{name}" is the text "{text}", and a number is calculated with it'
        self.report_traced("expression", message, used, partial(number_meant, text, []), (), trace)

    def named_at(self, name: str) -> Span | None:
        """Return where a name in scope stands itself: that of a loop in its ``for``, and not with its value."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.looped:
                return scope.looped[name]
            if name in scope.places:
                return scope.places[name].span
            scope = scope.parent
        return None

    def place_of(self, name: str) -> Span | None:
        """Return where a name in scope was given its value."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.places:
                return scope.places[name].span
            scope = scope.parent
        return None


def rounds(outer: Scope, item: Map) -> Iterator[Scope]:
    """Yield a scope for each round of a ``for``; several names are nested loops, the last one fastest.

    Without a ``for`` that is the scope around it, once. Raises Failed after reporting.
    """
    loops = item.get("for")
    if loops is None:
        yield outer
        return
    via = outer.via or item.via
    place = Place(item.value_spans["for"], via)
    if not isinstance(loops, Map) or not loops:
        help = "write for: {side: [left, right]}"
        outer.report("wrong-type", "for maps a name to the values that it takes", place, help)
        raise Failed
    scopes = [outer]
    for name, values in loops.items():
        where = Place(loops.value_spans[name], via)
        looped = dict.fromkeys(map(str.strip, name.split(",")), loops.key_spans[name])
        inner_scopes: list[Scope] = []
        counted = 0
        for scope in scopes:
            given, spans = _values(scope, values, where)
            if len(given) > counted:  # as if every round had as many, so that a huge product is refused at once
                outer.count((len(given) - counted) * len(scopes), where.span, where.via)
                counted = len(given)
            in_place = isinstance(values, Seq)  # else they come from elsewhere, and the loop says from where
            for value, span in zip(given, spans, strict=True):
                outer_via, at = scope.via or via, span if in_place else where.span
                if at != span:
                    outer_via = Instance("which is written here", span, outer_via)
                made = Instance(f"{name} = {short(value)}", at, outer_via, made=True)
                inner = scope.inner(made)
                _bind(inner, name, value, Place(at, where.via))
                inner.looped = looped
                inner_scopes.append(inner)
        scopes = inner_scopes
    yield from scopes


def _values(scope: Scope, values: Any, place: Place) -> tuple[Sequence[Any], Sequence[Span]]:
    """Return what a loop runs over, a list or the keys of a table, and where each of it was written."""
    resolved = scope.resolve(values, place)
    if isinstance(resolved, Mapping):
        keys = list(resolved)
        known = resolved.key_spans if isinstance(resolved, Map) else {}
        return keys, [known.get(key, place.span) for key in keys]
    if isinstance(resolved, list):
        spans = resolved.value_spans if isinstance(resolved, Seq) else [place.span] * len(resolved)
        return resolved, spans
    scope.report("wrong-type", "a loop runs over a list or a table", place, "write a list, or ${range(4)}")
    raise Failed


def _bind(scope: Scope, names: str, value: Any, place: Place) -> None:
    """Bind the name of a loop; ``key, value`` names take a row apart."""
    if "," not in names:
        scope.bind(names.strip(), value, place)
        return
    split = [name.strip() for name in names.split(",")]
    if not isinstance(value, list) or len(value) != len(split):
        scope.report("wrong-type", f"a round of this loop does not give {len(split)} values", place, "")
        raise Failed
    for name, item in zip(split, value, strict=True):
        scope.bind(name, item, place)


def explained(problem: ExpressionError, piece: Piece, text: str, place: Place, known: set[str]) -> tuple[Place, Help]:
    """Return where in the text at ``place`` an expression is wrong, and the way out; ``known`` are names in scope."""
    help: Help = problem.help
    if problem.unit is not None and (meant := unit_meant(problem.unit[1], [])):
        help = f"write {problem.unit[0]} {meant}"
    elif problem.unknown.endswith("()"):
        help = Suggestion(problem.unknown[:-2], {*functions(), *(one.name for one in BUILT_IN)})
    elif problem.unknown in ("math", "np", "numpy", "xacro", "self"):
        help = "functions and constants stand by themselves: pi, sin(x), load('file.yaml')"
    elif problem.unknown:
        names = first_of(sorted(known), MAX_LISTED)
        way_out = f"known here: {names}" if names else "name it in let"
        help = Suggestion(problem.unknown, {*known, *CONSTANTS, *UNITS}, instead=way_out)
    where = shifted(place, text, piece.offset + 2)
    if "\n" not in piece.text and where.span != place.span:
        indent = len(piece.text) - len(piece.text.lstrip())
        column = where.span.column + indent + max(0, problem.column)
        where = Place(where.span._replace(column=column, length=1), where.via)
    return where, help


def _is_allowed(text: str) -> bool:
    """Say whether an expression can be read, whatever its names stand for."""
    try:
        compiled(text)
    except ExpressionError:
        return False
    return True


def short(value: Any) -> str:
    """Return the value of a loop's round in a few letters."""
    if isinstance(value, (str, int, float)):
        return str(value)[:40]
    if isinstance(value, list) and not any(isinstance(item, (list, Mapping)) for item in value):
        return ", ".join(map(str, value))[:40]
    if isinstance(value, (list, Mapping)):
        return f"{type(value).__name__.lower().replace('seq', 'a list').replace('map', 'a table')} of {len(value)}"
    return str(value)[:40]


def as_tree(value: list[Any], span: Span, via: Instance | None) -> Seq:
    """Return a list that an expression made as a Seq: its items get the place of the expression."""
    if isinstance(value, Seq):
        return value
    made = Seq(span, via)
    for item in value:
        made.put(as_tree(item, span, via) if type(item) is list else item, span)
    return made


def shifted(place: Place, text: str, offset: int) -> Place:
    """Return the place of a character within a scalar; the start of the scalar where it runs over several lines."""
    span = place.span
    if span.length < len(text):
        return place
    first = span.source.line(span.line)[span.column - 1 : span.column]
    quote = 1 if first in ("'", '"') and not text.startswith(first) else 0
    length = max(1, span.length - quote - offset)
    return Place(span._replace(column=span.column + quote + offset, length=length), place.via)


def parameters_of(text: str) -> tuple[str, ...] | None:
    """Return the names between the brackets of a name that can be called; None if they are none.

    >>> parameters_of("x, y"), parameters_of(""), parameters_of("x y")
    (('x', 'y'), (), None)
    """
    names = tuple(name.strip() for name in text.split(",")) if text.strip() else ()
    sound = all(name.isidentifier() for name in names) and len(set(names)) == len(names)
    return names if sound else None


class Called:
    """A named value that takes values itself, ``box(x, y): {size: ...}`` under ``let``, as expressions call it.

    What stands in it sees the names of the place where it is written, and the values that it was given.
    """

    def __init__(self, scope: Scope, name: str, parameters: Sequence[str], body: Any, place: Place) -> None:
        self.scope = scope
        self.name = name
        self.parameters = parameters
        self.body = body
        self.place = place

    def __call__(self, *given: Any) -> Any:
        """Return the value for what was given. Raises ExpressionError, and Failed after a mistake within it."""
        wanted = f"{self.name}({', '.join(self.parameters)})"
        if len(given) != len(self.parameters):
            count = len(self.parameters)
            raise ExpressionError(f"{wanted} takes {count} value{'' if count == 1 else 's'}, not {len(given)}")
        running = self.scope.running
        mark = f"{self.name}()@{id(self)}"
        if running.count(mark) > MAX_CALLED:
            raise ExpressionError(f"{wanted} calls itself without end")
        inner = Scope(self.scope.ledger, self.scope)
        for name, value in zip(self.parameters, given, strict=True):
            inner.bind(name, value, self.place)
        running.append(mark)
        try:
            text = isinstance(self.body, str) and self.body.lstrip().startswith("<")
            return inner.resolve(self.body, self.place, xml=text)
        finally:
            running.pop()

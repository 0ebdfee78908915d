"""Scopes: nested namespaces in which expressions, loops and conditions are evaluated.

A named value is evaluated when it is first used. ``resolve`` returns values without expressions unchanged, not copied.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, NamedTuple, NoReturn

from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, Suggestion, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Instance, Map, Place, Seq, XmlText
from rosorin_compile.source.units import UNITS
from rosorin_compile.source.wording import MAX_LISTED, count_of, first_of
from rosorin_compile.source.xml.elements import escape_for

from ..expression import Piece, compile_expression, evaluate, names_in, pieces
from ..expression.functions import CONSTANTS, FUNCTIONS, OF_DESCRIPTIONS, ExpressionError, KindError, functions, kind_of
from ..expression.syntax import CHOICES, EFFORT, weight
from ..schema import keys_of_xml
from ..suggestions import flag_meant, number_meant, unit_meant
from .provenance import OF_KINDS, Origin, argument_at, argument_of, is_like_a_number

MAX_NODES = 3_000_000  # 50,000 parts have 2.7 million
MAX_CALLED = 30  # maximum depth of nested calls of functions that are defined under "let"
# Maximum number of steps of all expressions together (about ten seconds); one expression may take a seventh.
MAX_WORK = 20_000_000
_OF_XACRO = re.compile(r"\$\((find|arg|env|optenv|eval|dirname|anon)\b([^)]*)\)")
# Rules whose errors are reported at the key of an entry, but are not caused by arguments in the key.
_OF_ENTRIES = ("missing-key", "unknown-key", "ignored-key", "part-cycle")


class EvaluationFailed(Exception):
    """Raised when evaluation fails, after the errors were reported."""


class DisabledEntry(NamedTuple):
    """An entry removed by a false ``if``, or by a ``for`` without iterations (``is_empty``).

    ``key`` is the unevaluated key ("" for a list item), ``scope`` has the names for expressions in the entry, and
    ``is_use`` is True for an entry of ``use``.
    """

    key: str
    item: Map
    scope: Any
    is_use: bool
    is_empty: bool


class Expansion:
    """The state of an expansion: diagnostics, limits, and results cached by id() of tree nodes."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.nodes = 0
        self.parts = 0
        self.is_full = False  # True after a limit was reported
        self.blamed: set[Any] = set()  # arguments for which an expression error was reported
        self.root: Any = None  # the scope of the description, which is created first
        self.scopes: dict[int, Any] = {}  # scopes of parts and loop iterations by id() of their Instance
        self.disabled: list[DisabledEntry] = []
        self.parameters: dict[int, Any] = {}
        self._start = EFFORT.total
        self._constant: dict[int, bool] = {}
        self._changing: dict[int, list[str] | None] = {}
        self._bodies: dict[int, Any] = {}

    def forget(self) -> None:
        """Release the scopes, so that the files as written can be freed before the artifacts are generated."""
        self.scopes.clear()
        self.disabled.clear()
        self.root.values.clear()  # its functions load() and find() refer to all files
        self.root = None

    @property
    def work(self) -> int:
        """The number of evaluation steps so far."""
        return EFFORT.total - self._start

    @contextmanager
    def without_limits(self) -> Iterator[None]:
        """Suspend the limits in a ``with`` block that evaluates values only to report errors in them."""
        nodes, work, is_full = self.nodes, self.work, self.is_full
        reported, disabled = len(self.diagnostics), len(self.disabled)
        self.nodes = 0
        yield
        self.nodes, self.is_full = nodes, is_full
        self._start += self.work - work
        self.diagnostics[reported:] = [one for one in self.diagnostics[reported:] if one.rule != "too-large"]
        del self.disabled[disabled:]

    def is_constant(self, value: Any) -> bool:
        """Return True if a value contains no expression, loop or condition."""
        if isinstance(value, str):
            return "$" not in value
        if not isinstance(value, (Map, Seq)):
            return True
        if (constant := self._constant.get(id(value))) is None:
            controlled = isinstance(value, Map) and ("for" in value or "if" in value or "$" in "".join(value))
            items = value.values() if isinstance(value, Map) else value
            constant = self._constant[id(value)] = not controlled and all(map(self.is_constant, items))
        return constant

    def changing_keys(self, value: Map) -> list[str] | None:
        """Return the keys whose values contain expressions, or None if keys, loops or conditions need evaluation."""
        if id(value) not in self._changing:
            changing = [key for key, item in value.items() if not self.is_constant(item)]
            is_fixed = "$" not in "".join(value) and not any(map(_is_controlled, value.values()))
            self._changing[id(value)] = changing if is_fixed else None
        return self._changing[id(value)]

    def body(self, entry: Map) -> Any:
        """Return an entry without ``for`` and ``if``; if only the key ``value`` is left, return its value."""
        if id(entry) not in self._bodies:
            body = entry.copy()
            for control in ("for", "if"):
                body.pop(control, None)
            self._bodies[id(entry)] = body["value"] if list(body) == ["value"] else body
        return self._bodies[id(entry)]


class Scope:
    """The names that are defined in a description, part, loop iteration or function.

    ``parent`` is the enclosing scope, ``via`` the part use or loop iteration that created this scope, and ``prefix``
    the prefix of names that parts define in it. ``places`` maps names to positions; ``local`` has the positions of the
    values that are evaluated in this scope: named values and defaults, but not arguments. ``looped`` has the positions
    of loop variables.
    """

    def __init__(self, expansion: Expansion, parent: Scope | None = None, via: Instance | None = None) -> None:
        self.expansion, self.parent = expansion, parent
        self.via: Instance | None = via or (parent.via if parent else None)
        self.prefix: str = parent.prefix if parent else ""
        self.values: dict[str, Any] = {}
        self.places: dict[str, Place] = {}
        self.local: dict[str, Place] = {}
        self.looped: Mapping[str, Span] = {}
        self.declared: Mapping[str, Any] = {}  # parameters by name
        self.mount: Place | None = None  # position of the value of ``parent`` in the ``use`` entry
        self.pending: dict[str, tuple[Any, Place]] = {}
        self.broken: set[str] = set()
        self.running: list[str] = parent.running if parent else []
        if via is not None:
            expansion.scopes[id(via)] = self
        if expansion.root is None:
            expansion.root = self

    # Names

    def define(self, name: str, value: Any, place: Place, value_place: Place | None = None) -> None:
        """Define a named value, evaluated on first use; its name is at ``place``, its value at ``value_place``."""
        value_place = value_place or place
        call = re.fullmatch(r"([^(]*)\((.*)\)", name, re.DOTALL)
        own, parameters = (call[1], [one.strip() for one in call[2].split(",") if call[2]]) if call else (name, [])
        is_good = all(map(str.isidentifier, (own, *parameters))) and len(set(parameters)) == len(parameters)
        is_taken = call is not None and (own in functions() or own in OF_DESCRIPTIONS)
        if is_taken or not is_good:
            message = f'"{own}" is the name of a built-in function' if is_good else f'"{name}" is not a valid name'
            help = f"write {'NAME(FIRST, SECOND)' if call else 'a name'} with letters, digits and underscores only"
            self.report("bad-name", message, place, "choose another name" if is_good else help)
        elif own in self.places:
            related = [Related("first defined here", self.places[own].span)]
            self.report("duplicate-name", f'the value "{own}" is defined twice', place, "rename one of them", related)
            return
        self.places[own], self.local[own] = place, value_place
        if call:
            self.values[f"{own}()"] = partial(self._call, own, parameters, value, value_place)
        else:
            self.pending[own] = value, value_place

    def _call(self, name: str, parameters: Sequence[str], body: Any, place: Place, *arguments: Any) -> Any:
        signature, count = f"{name}({', '.join(parameters)})", len(parameters)
        if len(arguments) != count:
            raise ExpressionError(f"{signature} takes {count_of(count, 'value')}, not {len(arguments)}")
        mark = f"{name}()@{id(self)}"
        if self.running.count(mark) > MAX_CALLED:
            raise ExpressionError(f"{signature} calls itself without end")
        inner = Scope(self.expansion, self)
        for parameter, value in zip(parameters, arguments, strict=True):
            inner.bind(parameter, value, place)
        self.running.append(mark)
        try:
            return inner.resolve(body, place, xml=isinstance(body, str) and body.lstrip().startswith("<"))
        finally:
            self.running.pop()

    def define_all(self, lets: Any) -> None:
        """Define the named values of a ``let`` section, if it is a mapping."""
        for name, value in lets.items() if isinstance(lets, Map) else ():
            self.define(name, value, key_place(lets, name), value_place(lets, name))

    def bind(self, name: str, value: Any, place: Place) -> None:
        """Define a name with a value that is already evaluated."""
        self.places[name] = place
        self.values[name] = value

    def lookup(self, name: str) -> Any:
        """Return the value of a name. Raises KeyError if it is undefined, EvaluationFailed if it has errors."""
        scope: Scope | None = self
        while scope is not None:
            if name in scope.values:
                return scope.values[name]
            if name in scope.pending or name in scope.broken:
                return scope._evaluate(name)
            # A scope that redefines an argument hides the choices (one_of) of the argument.
            scope = None if name.endswith(CHOICES) and name.removesuffix(CHOICES) in scope.places else scope.parent
        raise KeyError(name)

    def _evaluate(self, name: str) -> Any:
        if name in self.broken:
            raise EvaluationFailed
        mark = f"{name}@{id(self)}"
        if mark in self.running:
            chain = [step.partition("@")[0] for step in [*self.running[self.running.index(mark) :], mark]]
            steps = [step for step in chain[1:-1] if step in self.places]
            related = [Related(f'"{step}" is used here', self.places[step].span) for step in steps]
            message = f"{' -> '.join(chain)}: the value depends on itself"
            self.broken.update(chain)
            help = f"define {'one of them without the others' if chain[2:] else 'it without using its own name'}"
            raise self.fail("cycle", message, self.places[chain[0]], help, related)
        self.running.append(mark)
        try:
            self.values[name] = self.resolve(*self.pending[name])
        except EvaluationFailed:
            self.broken.add(name)
            raise
        finally:
            self.running.pop()
        del self.pending[name]
        return self.values[name]

    def evaluate_rest(self) -> bool:
        """Evaluate the unused named values to report errors in them; return True if all are valid."""
        for name in list(self.pending):
            with suppress(EvaluationFailed):
                self.lookup(name)
        return not self.pending

    def all_names(self) -> dict[str, Span]:
        """Map each name that is visible in this scope to its position; omit constants, units and built-in functions."""
        here = {name: self.looped.get(name, place.span) for name, place in self.places.items()}
        return {**(self.parent.all_names() if self.parent else {}), **here}

    def ancestors(self) -> Iterator[Scope]:
        """Yield this scope and its enclosing scopes, the outermost last."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def owner(self, name: str) -> Scope | None:
        """Return the innermost scope that defines a name, or None if the name is undefined."""
        return next((scope for scope in self.ancestors() if name in scope.places), None)

    # Errors

    def report(self, rule: str, message: str, place: Place, help: Help = "", related: Sequence[Related] = ()) -> None:
        """Report an error at a place, or at the argument that causes it, with the includes and parts that led there."""
        origin = None if rule in _OF_ENTRIES else argument_at(self, place.span, rule in OF_KINDS)
        self.report_origin(rule, message, place, help, related, origin)

    def fail(
        self, rule: str, message: str, place: Place, help: Help = "", related: Sequence[Related] = ()
    ) -> EvaluationFailed:
        """Report an error like ``report``, and return the exception for the caller to raise."""
        self.report(rule, message, place, help, related)
        return EvaluationFailed()

    def report_origin(
        self, rule: str, message: str, place: Place, help: Help, related: Iterable[Related], origin: Origin | None
    ) -> None:
        """Report an error at ``origin`` (None: at ``place``), but only the first "expression" error at each origin."""
        stack = tuple(self.via.stack()) if self.via else place.stack()
        uses = origin.related_places(place.span) if origin else ()
        span = origin.span if origin else place.span
        if origin and rule == "expression":
            if (span, stack[-1:]) in self.expansion.blamed:
                return
            self.expansion.blamed.add((span, stack[-1:]))
        self.expansion.diagnostics.append(error(rule, message, span, help, [*related, *uses, *stack]))

    def count(self, nodes: int, span: Span, via: Instance | None) -> None:
        """Add ``nodes`` to the number of values. If there are too many, report an error and raise EvaluationFailed."""
        self.expansion.nodes += nodes
        Progress.step("expanding parts" if self.expansion.parts else "expanding", self.expansion.parts)
        if self.expansion.nodes > MAX_NODES:
            self._fail_for_size(f"the description grows beyond {MAX_NODES:,} values", Place(span, via))

    def _fail_for_size(self, message: str, place: Place) -> NoReturn:
        if not self.expansion.is_full:
            self.expansion.is_full = True
            self.report("too-large", message, place, 'use fewer or smaller loops, or calculate values once in "let"')
        raise EvaluationFailed

    # Evaluation

    def resolve(self, value: Any, place: Place, xml: bool = False) -> Any:
        """Return a value with its expressions, loops and conditions evaluated. Raises EvaluationFailed after errors.

        ``xml`` is True for XML elements, in which the values of expressions are escaped.
        """
        if self.expansion.is_constant(value):
            return value
        if isinstance(value, Map):
            return self._mapping(value)
        return self._sequence(value, xml) if isinstance(value, Seq) else self.text(value, place.span, place.via, xml)

    def _mapping(self, value: Map) -> Map:
        via, changing = self.via or value.via, self.expansion.changing_keys(value)
        made = Map(value.span, via) if changing is None else value.made_by(via)
        self.count(len(value) + 1, value.span, via)
        failed = False
        for key in value if changing is None else changing:
            item, key_span, span = value[key], value.key_spans[key], value.value_spans[key]
            try:
                if "$" not in key and not _is_controlled(item):
                    resolved = self.resolve(item, Place(span, via), key in keys_of_xml())
                    if resolved is not None or item is None:
                        made.put(key, resolved, key_span, span)
                    else:
                        made.pop(key, None)
                    continue
                for scope, entry in self.entries(item, key):
                    name = scope.name(key, key_span, via) if "$" in key else key
                    if name in made:
                        related = [Related("first defined here", made.key_spans[name])]
                        help = "use the loop variable in the key" if isinstance(item, Map) and "for" in item else ""
                        message = f'the loop creates the key "{name}" more than once'
                        raise self.fail("duplicate-key", message, Place(key_span, via), help, related)
                    entry = scope.resolve(entry, Place(span, via))
                    if "$" in key and isinstance(entry, Map) and scope is not self:
                        entry = entry.made_by(scope.via)  # so that errors in the entry name the iteration of the loop
                    made.put(name, entry, key_span, span)
            except EvaluationFailed:
                failed = True
        if failed:
            raise EvaluationFailed
        return made

    def name(self, key: str, span: Span, via: Instance | None) -> str:
        """Evaluate the expressions in a key. Raises EvaluationFailed if the result is neither text nor a number."""
        name = self.text(key, span, via)
        if isinstance(name, (str, int, float)):
            return str(FUNCTIONS["str"](name))
        raise self.fail("wrong-type", f"a name is text, not {kind_of(name)}", Place(span, via), "put it inside text")

    def _sequence(self, value: Seq, xml: bool) -> Seq:
        via = self.via or value.via
        made, failed = Seq(value.span, via), False
        self.count(len(value) + 1, value.span, via)
        for item, span in zip(value, value.value_spans, strict=True):
            try:
                if not _is_controlled(item):
                    made.put(self.resolve(item, Place(span, via), xml), span)
                    continue
                for scope, entry in self.entries(item):
                    found = scope.resolve(entry, Place(span, via), xml)
                    made.put(XmlText(found, scope.via or via) if xml and isinstance(found, str) else found, span)
            except EvaluationFailed:
                failed = True
        if failed:
            raise EvaluationFailed
        return made

    def entries(self, item: Any, key: str = "", is_use: bool = False) -> Iterator[tuple[Scope, Any]]:
        """Yield (scope, entry without ``for`` and ``if``) for each iteration of ``for`` in which ``if`` is true."""
        if not _is_controlled(item):
            yield self, item
            return
        body, scope = self.expansion.body(item), None
        for scope in rounds(self, item):
            holds = True
            if "if" in item:
                place = Place(item.value_spans["if"], self.via or item.via)
                holds = scope.resolve(item["if"], place)
                if not isinstance(holds, bool):
                    what = f'"{holds}"' if isinstance(holds, (str, int, float)) else kind_of(holds)
                    help = flag_meant(holds) or 'write a comparison, such as "${n > 0}"'
                    raise scope.fail("wrong-type", f"a condition must be true or false, not {what}", place, help)
            if holds:
                yield scope, body
            else:
                self.expansion.disabled.append(DisabledEntry(key, item, scope, is_use, is_empty=False))
        if scope is None:
            self.expansion.disabled.append(DisabledEntry(key, item, self, is_use, is_empty=True))

    def text(self, text: str, span: Span, via: Instance | None, xml: bool = False) -> Any:
        """Evaluate each ``${...}`` in a string; if the string is a single expression, return its value, else a string.

        If ``xml`` is True, escape the values, except complete XML elements that are inserted between elements.
        """
        place = Place(span, via)
        parts: list[str] = []
        for piece in pieces(text):
            if not piece.is_expression:
                xacro = _OF_XACRO.search(piece.text)
                if xacro and "<" not in text:  # XML elements may contain $(...) for another program
                    name, where = (xacro[2].split() or ["NAME"])[0], _within(place, text, piece.offset + xacro.start())
                    help = f'declare {name} in "args" and write "${{{name}}}"'
                    help = f"write package://{name}" if xacro[1] == "find" else help
                    raise self.fail("expression", f'"{xacro[0]}" is xacro syntax: it has no effect here', where, help)
                parts.append(piece.text)
                continue
            if piece.unclosed:
                where = _within(place, text, piece.offset)
                raise self.fail("expression", 'the "}" of an expression is missing', where, "close it")
            try:
                value = evaluate(piece.text, self.lookup)
                if self.expansion.work > MAX_WORK:
                    message = f"the expressions of the description take more than {MAX_WORK:,} steps together"
                    self._fail_for_size(message, place)
                if isinstance(value, (list, dict)):
                    self.count(weight(value), span, via)
                if piece.is_whole:
                    return _as_tree(value, span, via) if type(value) is list else value
                worded = FUNCTIONS["str"](value)
                parts.append(escape_for("".join(parts), worded) if xml else worded)
            except ExpressionError as problem:
                self._report_expression(problem, piece, text, place)
                raise EvaluationFailed from None
        return "".join(parts)

    def _report_expression(self, problem: ExpressionError, piece: Piece, text: str, place: Place) -> None:
        where = _within(place, text, piece.offset + 2)
        if "\n" not in piece.text and where.span != place.span:
            column = where.span.column + len(piece.text) - len(piece.text.lstrip()) + max(0, problem.column)
            where = Place(where.span._replace(column=column, length=1), where.via)
        used = [] if problem.unknown else names_in(piece.text)
        owners = {name: owner for name in used if (owner := self.owner(name)) is not None}
        names = {name: owner.places[name].span for name, owner in owners.items()}
        values = {name: owner.values[name] for name, owner in owners.items() if name in owner.values}
        if not (help := self._expression_help(problem)):
            number = next((name for name, value in values.items() if is_like_a_number(value)), "")
            if number:  # report the string where it was written, only once for all expressions that use it
                written = argument_of(self, [number]) or Origin(names[number])
                message = f'"{number}" is the text "{values[number]}", but is used as a number'
                self.report_origin("expression", message, where, number_meant(values[number], []), (), written)
                return
            empty = [name for name, value in values.items() if value is None]
            help = f'"{empty[0]}" is empty: give it a value, or compare it with "!= none" first' if empty else ""
        origin: Origin | None = None
        with suppress(ExpressionError):  # an invalid expression depends on no arguments
            compile_expression(piece.text)
            origin = argument_of(self, names, isinstance(problem, KindError))
        elsewhere = (origin.span, *origin.others) if origin else ()
        first = list(names.items())[:3]
        related = [Related(f'"{name}" comes from here', span) for name, span in first if span not in elsewhere]
        self.report_origin("expression", problem.message, where, help, related, origin)

    def _expression_help(self, problem: ExpressionError) -> Help:
        unknown = problem.unknown
        if problem.unit is not None and (meant := unit_meant(problem.unit[1], [])):
            return f'write "{problem.unit[0]} {meant}"'
        if unknown.endswith("()"):
            return Suggestion(unknown[:-2], {*functions(), *OF_DESCRIPTIONS})
        if unknown in ("math", "np", "numpy", "xacro", "self"):
            return "functions and constants have no module: pi, sin(x), load('file.yaml')"
        if unknown:
            names = self.all_names()
            known = f"known: {first_of(sorted(names), MAX_LISTED)}" if names else 'define it in "let"'
            return Suggestion(unknown, {*names, *CONSTANTS, *UNITS}, instead=known, places=names)
        return problem.help


def _is_controlled(item: Any) -> bool:
    return isinstance(item, Map) and ("for" in item or "if" in item)


def rounds(outer: Scope, item: Map) -> Iterator[Scope]:
    """Yield a scope with the loop variables for each iteration of ``for``, or ``outer`` if the entry has no ``for``.

    The keys of ``for`` are nested loops, outermost first. Raises EvaluationFailed after reporting errors.
    """
    loops, scopes, via = item.get("for"), [outer], outer.via or item.via
    if loops is None:
        yield outer
        return
    if not isinstance(loops, Map) or not loops:
        place, help = Place(item.value_spans["for"], via), "write for: {side: [left, right]}"
        raise outer.fail("wrong-type", "for maps a name to the values that it takes", place, help)
    for names, values in loops.items():
        where = Place(loops.value_spans[names], via)
        split = [name.strip() for name in names.split(",")]
        outer_scopes, scopes, counted = scopes, [], 0
        for scope in outer_scopes:
            items = scope.resolve(values, where)
            if not isinstance(items, (list, Mapping)):
                help = 'write a list, or an expression such as "${range(4)}"'
                raise scope.fail("wrong-type", '"for" needs a list or a table to loop over', where, help)
            if len(items) > counted:  # assume equally many items for all outer iterations, to refuse a huge loop early
                outer.count((len(items) - counted) * len(outer_scopes), where.span, where.via)
                counted = len(items)
            keys = items.key_spans if isinstance(items, Map) else {}
            spans = items.value_spans if isinstance(items, Seq) else [keys.get(key, where.span) for key in items]
            for value, span in zip(items, spans, strict=True):
                outer_via, at = scope.via or via, span if isinstance(values, Seq) else where.span
                if at != span:  # also report the position of the list if ``for`` gets the list from an expression
                    outer_via = Instance("which is written here", span, outer_via)
                inner = Scope(outer.expansion, scope, Instance(f"{names} = {_short(value)}", at, outer_via, made=True))
                row = value if len(split) > 1 else [value]
                if not isinstance(row, list) or len(row) != len(split):
                    raise inner.fail("wrong-type", f"the loop needs {len(split)} values per item", Place(at, where.via))
                for name, one in zip(split, row, strict=True):
                    inner.bind(name, one, Place(at, where.via))
                inner.looped = dict.fromkeys(split, loops.key_spans[names])
                scopes.append(inner)
    yield from scopes


def _short(value: Any) -> str:
    if isinstance(value, list) and not any(isinstance(item, (list, Mapping)) for item in value):
        return ", ".join(map(str, value))[:40]
    if isinstance(value, (list, Mapping)):
        return f"a {'list' if isinstance(value, list) else 'table'} of {len(value)}"
    return str(value)[:40]


def _as_tree(value: list[Any], span: Span, via: Instance | None) -> Seq:
    if isinstance(value, Seq):
        return value
    made = Seq(span, via)
    for item in value:
        made.put(_as_tree(item, span, via) if type(item) is list else item, span)
    return made


def _within(place: Place, text: str, offset: int) -> Place:
    """Return the place of an offset in a string, or of the string if it spans several lines."""
    span = place.span
    if span.length < len(text):
        return place
    first = span.source.line(span.line)[span.column - 1 : span.column]
    quote = int(first in ("'", '"') and not text.startswith(first))
    length = max(1, span.length - quote - offset)
    return Place(span._replace(column=span.column + quote + offset, length=length), place.via)


def key_place(entry: Map, key: str) -> Place:
    """Return the place of a key of a mapping."""
    return Place(entry.key_spans[key], entry.via)


def value_place(entry: Map, key: str) -> Place:
    """Return the place of the value of a key of a mapping."""
    return Place(entry.value_spans[key], entry.via)

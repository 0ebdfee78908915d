"""Names in a description: arguments and named values, evaluated when they are needed, each once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .diagnostic import Diagnostic, Related, did_you_mean, error
from .expression import CONSTANTS, FUNCTIONS, ExpressionError, evaluate
from .quantity import UNITS
from .tree import Map, Place, Seq, Text

_OPEN = "${"


class Failed(Exception):
    """A value that cannot be had; what is wrong has been reported already."""


class Scope:
    """Evaluates expressions; ``diagnostics`` collects what is wrong, each cause once."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.values = dict(values)
        self.places: dict[str, Place] = {}
        self.pending: dict[str, Any] = {}
        self.running: list[str] = []
        self.broken: set[str] = set()
        self.diagnostics: list[Diagnostic] = []

    def define(self, name: str, value: Any, place: Place) -> None:
        """Add a named value, not evaluated yet. A name that is taken is reported."""
        if name in self.places:
            related = [Related("first defined here", self.places[name].span)]
            self.report("duplicate-name", f'the value "{name}" is named twice', place, "rename one", related)
            return
        if not name.isidentifier():
            help = "use letters, digits and underscores, and begin with a letter"
            self.report("bad-name", f'"{name}" cannot be used in an expression', place, help)
        self.places[name] = place
        self.pending[name] = value

    def report(self, rule: str, message: str, place: Place, help: str = "", related: Sequence[Related] = ()) -> None:
        """Add an error at a place, with the includes and parts that led to it."""
        self.diagnostics.append(error(rule, message, place.span, help, [*related, *place.stack()]))

    def lookup(self, name: str) -> Any:
        """Return the value of a name. Raises KeyError if there is none, Failed if its own expression is wrong."""
        if name in self.broken:
            raise Failed
        if name not in self.pending:
            return self.values[name]
        if name in self.running:
            chain = [*self.running[self.running.index(name) :], name]
            related = [Related(f'"{step}" is named here', self.places[step].span) for step in chain[1:-1]]
            self.report("cycle", f"{' -> '.join(chain)}: the value needs itself", self.places[name], "", related)
            self.broken.update(chain)
            raise Failed
        self.running.append(name)
        try:
            self.values[name] = self.resolve(self.pending[name], self.places[name])
        except Failed:
            self.broken.add(name)
            raise
        finally:
            self.running.pop()
        del self.pending[name]
        return self.values[name]

    def resolve(self, value: Any, place: Place) -> Any:
        """Return a value of the tree with every expression in it evaluated. Raises Failed after reporting."""
        if isinstance(value, Map):
            return self._mapping(value)
        if isinstance(value, Seq):
            return self._sequence(value)
        if isinstance(value, str) and "$" in value:
            return self._text(value, place)
        return value

    def _mapping(self, value: Map) -> Map:
        made = Map(value.span, value.via)
        failed = False
        for key, item in value.items():
            span = value.value_spans[key]
            try:
                made.put(key, self.resolve(item, Place(span, value.via)), value.key_spans[key], span)
            except Failed:
                failed = True
        if failed:
            raise Failed
        return made

    def _sequence(self, value: Seq) -> Seq:
        made = Seq(value.span, value.via)
        failed = False
        for item, span in zip(value, value.value_spans, strict=True):
            try:
                made.put(self.resolve(item, Place(span, value.via)), span)
            except Failed:
                failed = True
        if failed:
            raise Failed
        return made

    def _text(self, text: str, place: Place) -> Any:
        """Return text with its ``${...}`` replaced; text that is one expression has the type of its value."""
        parts: list[str] = []
        position = 0
        while (start := text.find(_OPEN, position)) >= 0:
            if start > 0 and text[start - 1] == "$":
                parts.append(text[position : start - 1] + _OPEN)
                position = start + 2
                continue
            end = _closing(text, start + 2)
            if end < 0:
                self.report("expression", 'the "}" of an expression is missing', _shift(place, text, start), "close it")
                raise Failed
            value = self._expression(text[start + 2 : end], _shift(place, text, start + 2))
            if start == 0 and end == len(text) - 1:
                return value
            parts.append(text[position:start] + self._shown(value, place))
            position = end + 1
        return "".join(parts) + text[position:]

    def _shown(self, value: Any, place: Place) -> str:
        if isinstance(value, (Map, Seq, list)):
            self.report("expression", "a list or a table cannot stand inside text", place, "use it as the whole value")
            raise Failed
        if isinstance(value, bool):
            return "true" if value else "false"
        return str(float(value)) if isinstance(value, float) else str(value)

    def _expression(self, text: str, place: Place) -> Any:
        try:
            return _as_tree(evaluate(text, self.lookup), place)
        except ExpressionError as problem:
            help = problem.help
            if help.startswith("name:"):
                help = did_you_mean(help[5:], {*self.values, *self.places, *CONSTANTS, *_shown_units()})
            elif help.startswith("function:"):
                help = did_you_mean(help[9:], FUNCTIONS)
            indent = len(text) - len(text.lstrip())
            span = place.span
            if "\n" not in text:
                span = span._replace(column=span.column + indent + problem.column, length=1)
            self.report("expression", problem.message, Place(span, place.via), help)
            raise Failed from None


def _shown_units() -> list[str]:
    return [unit for unit in UNITS if len(unit) > 1]


def _as_tree(value: Any, place: Place) -> Any:
    """Return a list made by an expression as a Seq, so that its items have a place."""
    if isinstance(value, list) and not isinstance(value, Seq):
        made = Seq(place.span, place.via)
        for item in value:
            made.put(_as_tree(item, place), place.span)
        return made
    return value


def _closing(text: str, position: int) -> int:
    """Return where the brace that is open at ``position`` closes, or -1; quotes and inner pairs are passed."""
    depth, quote = 1, ""
    for index in range(position, len(text)):
        letter = text[index]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter == "{":
            depth += 1
        elif letter == "}":
            depth -= 1
            if depth == 0:
                return index
    return -1


def _shift(place: Place, text: str, offset: int) -> Place:
    """Return the place of a character within a scalar; the start of the scalar where it runs over several lines."""
    span = place.span
    if span.length < len(text):
        return place
    quote = 1 if isinstance(text, Text) else 0
    length = max(1, span.length - quote - offset)
    return Place(span._replace(column=span.column + quote + offset, length=length), place.via)

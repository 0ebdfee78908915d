"""Called: a named value that takes values itself, ``box(x, y): {size: ["${x}", "${y}", 0.1]}`` under ``let``.

An expression calls it as it calls a function of the language. What stands in it sees the names of the place where it is
written, and the values that it was given.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..expression.functions import ExpressionError
from ..tree import Place
from .scope import Scope

MAX_NESTED = 30


def parameters_of(text: str) -> tuple[str, ...] | None:
    """Return the names between the brackets of a name that can be called; None if they are none.

    >>> parameters_of("x, y"), parameters_of(""), parameters_of("x y")
    (('x', 'y'), (), None)
    """
    names = tuple(name.strip() for name in text.split(",")) if text.strip() else ()
    sound = all(name.isidentifier() for name in names) and len(set(names)) == len(names)
    return names if sound else None


class Called:
    """A named value with parameters, as expressions call it."""

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
        if running.count(mark) > MAX_NESTED:
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

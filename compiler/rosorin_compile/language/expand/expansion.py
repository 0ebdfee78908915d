"""The state that all scopes of one expansion share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.tree import Map, Seq

from ..expression.syntax import EFFORT

_MISSING = object()


class Failed(Exception):
    """A value has errors, which have been reported already."""


class Disabled(NamedTuple):
    """An entry that its condition, or a loop without rounds (``is_empty``), removes; ``scope`` evaluates its name.

    ``key`` is its name as written, "" for an item of a list; ``is_use``: it uses a part.
    """

    key: str
    item: Map
    scope: Any
    is_use: bool
    is_empty: bool


class Expansion:
    """Diagnostics and limits of an expansion, and what was computed for each piece of the files, by its identity."""

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.nodes = 0
        self.parts = 0
        self.is_full = False  # a limit has been reported
        self.blamed: set[Any] = set()  # arguments that an error in an expression was reported for
        self.root: Any = None  # the scope of the description, which is the first one
        self.scopes: dict[int, Any] = {}  # of each part and each round of a loop, by the identity of its Instance
        self.disabled: list[Disabled] = []
        self.parameters: dict[int, Any] = {}
        self._start = EFFORT.total
        self._constant: dict[int, bool] = {}
        self._bodies: dict[int, Any] = {}

    def forget(self) -> None:
        """Drop the scopes, which refer to the tree: it is freed when nobody else needs it."""
        self.scopes.clear()
        self.disabled.clear()
        self.root = None

    @property
    def work(self) -> int:
        """The steps of all expressions so far."""
        return EFFORT.total - self._start

    @contextmanager
    def without_limits(self) -> Iterator[None]:
        """Evaluate something of which nothing is used, only to find its errors: no limit applies to it."""
        nodes, work, is_full = self.nodes, self.work, self.is_full
        reported, disabled = len(self.diagnostics), len(self.disabled)
        self.nodes = 0
        yield
        self.nodes, self.is_full = nodes, is_full
        self._start += self.work - work
        self.diagnostics[reported:] = [one for one in self.diagnostics[reported:] if one.rule != "too-large"]
        del self.disabled[disabled:]

    def is_constant(self, value: Any) -> bool:
        """Return True if a piece of the tree contains no expression, loop or condition."""
        if isinstance(value, str):
            return "$" not in value
        if not isinstance(value, (Map, Seq)):
            return True
        constant = self._constant.get(id(value))
        if constant is None:
            controlled = isinstance(value, Map) and ("for" in value or "if" in value or "$" in "".join(value))
            items = value.values() if isinstance(value, Map) else value
            constant = self._constant[id(value)] = not controlled and all(map(self.is_constant, items))
        return constant

    def body(self, entry: Map) -> Any:
        """Return an entry without its loop and condition; if only ``value`` is left, the value of that."""
        body = self._bodies.get(id(entry), _MISSING)
        if body is _MISSING:
            body = entry.copy()
            for control in ("for", "if"):
                body.pop(control, None)
            body = self._bodies[id(entry)] = body["value"] if list(body) == ["value"] else body
        return body

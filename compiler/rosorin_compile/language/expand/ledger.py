"""The ledger: what one expansion shares, whatever the scope."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.tree import Map, Seq

from ..expression.syntax import EFFORT

_NOTHING = object()


class Failed(Exception):
    """A value that cannot be had; what is wrong has been reported already."""


class Step(NamedTuple):
    """What is to be done with one entry of a mapping or a sequence each time that it is evaluated."""

    key: str
    item: Any
    constant: bool
    controlled: bool
    named: bool


class LeftOut(NamedTuple):
    """An entry that is left out: by its condition, in a round of its loop, or because that has no rounds (``empty``).

    ``key`` is its name as it is written, "" for an item of a list; ``is_use``: it uses a part.
    """

    key: str
    item: Map
    scope: Any
    is_use: bool
    is_empty: bool


class _Scopes(dict[int, "Any"]):
    """Scopes, or what makes one that nobody has asked for yet."""

    def __getitem__(self, key: int) -> Any:
        scope = super().__getitem__(key)
        if callable(scope):
            scope = self[key] = scope()
        return scope


class Ledger:
    """What a whole expansion shares: the diagnostics, the count of values made, and what is known of each piece.

    Pieces are known by identity: every piece of the files that were read lives as long as the expansion.
    """

    def __init__(self) -> None:
        self.diagnostics: list[Diagnostic] = []
        self.nodes = 0
        self.parts = 0
        self.begun = EFFORT.total
        self.full = False
        self.constant: dict[int, bool] = {}
        self.bodies: dict[int, Any] = {}
        self.plans: dict[int, tuple[Step, ...]] = {}
        self.parameters: dict[int, Any] = {}
        self.blamed: set[Any] = set()  # the arguments that a mistake in an expression has been told of
        self.root: Any = None  # the scope of the description, the first one that is made
        # The scope of each part and each round of a loop, by the identity of its Instance: what ``explain`` asks.
        self.scopes: dict[int, Any] = _Scopes()
        # What is left out, and what finds a part by its name: for whoever misses it.
        self.left_out: list[LeftOut] = []
        self.find: Callable[[str], Map | None] | None = None

    def forget(self) -> None:
        """Let go of the scopes, which know the ledger: with them goes the tree, once nobody needs it."""
        self.scopes.clear()
        self.left_out.clear()
        self.find = None
        self.root = None

    @property
    def work(self) -> int:
        """The steps of all expressions of this expansion so far."""
        return EFFORT.total - self.begun

    def is_constant(self, value: Any) -> bool:
        """Say whether a piece of the tree has no expression, loop or condition in it."""
        if isinstance(value, str):
            return "$" not in value
        if not isinstance(value, (Map, Seq)):
            return True
        known = self.constant.get(id(value))
        if known is None:
            known = self.constant[id(value)] = self._is_constant(value)
        return known

    def _is_constant(self, value: Map | Seq) -> bool:
        if isinstance(value, Map) and ("for" in value or "if" in value or "$" in "".join(value)):
            return False
        for item in value.values() if isinstance(value, Map) else value:
            if isinstance(item, str):
                if "$" in item:
                    return False
            elif isinstance(item, (Map, Seq)) and not self.is_constant(item):
                return False
        return True

    def plan(self, value: Map | Seq) -> tuple[Step, ...]:
        """Return the steps that evaluate a piece."""
        plan = self.plans.get(id(value))
        if plan is None:
            pairs = value.items() if isinstance(value, Map) else [("", item) for item in value]
            plan = tuple(self._step(key, item) for key, item in pairs)
            self.plans[id(value)] = plan
        return plan

    def _step(self, key: str, item: Any) -> Step:
        controlled = isinstance(item, Map) and ("for" in item or "if" in item)
        return Step(key, item, self.is_constant(item), controlled, "$" in key)

    def body(self, entry: Map) -> Any:
        """Return an entry without its loop and condition; ``value`` alone stands for what is no mapping."""
        made = self.bodies.get(id(entry), _NOTHING)
        if made is _NOTHING:
            made = Map(entry.span, entry.via)
            for key, value in entry.items():
                if key not in ("for", "if"):
                    made.put(key, value, entry.key_spans[key], entry.value_spans[key])
            made = made["value"] if list(made) == ["value"] else made
            self.bodies[id(entry)] = made
        return made

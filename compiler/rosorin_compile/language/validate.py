"""Validate: the plain tree held against the JSON Schema. Shape, units and finite numbers; no meaning."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import SHAPE, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Dimension, Quantity, describe, parse_unit

from .expand.provenance import problem_at
from .schema import Steps, backend_of, has_entries, sections, subject, unit_at, with_outputs
from .validator import misfits_of, validator_of

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

    from .expand.scope import Scope

RULES = (
    Rule(
        "wrong-unit",
        "A quantity is of another kind: a mass where a length belongs, metres for a joint that turns.",
        "Correct the unit, or the type of the joint.",
        SHAPE,
    ),
    Rule(
        "not-finite",
        "A number is NaN or infinite; or one that is no limit is beyond 1e150, and nothing can be calculated with it.",
        "Write a number, or leave the key out.",
        SHAPE,
    ),
)

# Beyond it, what is calculated of a number (a volume, a moment of inertia) may be beyond all numbers that there are.
MOST = 1e150


def validate(tree: Map, formats: Mapping[str, Format], scope: Scope | None = None) -> list[Diagnostic]:
    """Return what is wrong with the shape of a tree, with the units of its quantities, and with its numbers.

    ``formats`` are those that outputs may name, ``scope`` what the names in expressions stood for (None: nobody knows).
    """
    walk = _Walk()
    walk.through(tree)
    diagnostics = [_not_finite(tree, path, value, scope) for path, value in walk.not_finite]
    misfits = [(path, quantity, _dimensions(tuple(path)) or ()) for path, quantity in walk.misfits]
    misfits += [(path, quantity, (allowed,)) for path, quantity, allowed in _of_options(tree, formats)]
    told = {tuple(path) for path, _, _ in misfits} | {tuple(path) for path, _ in walk.not_finite}
    diagnostics += _complaints(tree, formats, told, scope)
    diagnostics += [_wrong_unit(tree, path, quantity, dimensions, scope) for path, quantity, dimensions in misfits]
    return diagnostics


def _complaints(
    tree: Map, formats: Mapping[str, Format], told: Collection[tuple[str | int, ...]], scope: Scope | None
) -> Iterator[Diagnostic]:
    judge = _judge_of(tree.get("outputs"), formats)
    for misfit in misfits_of(judge.validator, tree):
        from .complaint import Complaint

        if tuple(misfit.path) not in told:
            yield from Complaint(tree, misfit, judge.schema, scope).diagnostics()


class _Judge(NamedTuple):
    """The schema of descriptions with certain outputs, and its validator."""

    schema: dict[str, Any]
    validator: Any


def _judge_of(outputs: Any, formats: Mapping[str, Format]) -> _Judge:
    """Return what judges a description with these outputs, made once for outputs of the same names and formats."""
    schema = with_outputs(outputs, formats)
    options = schema["properties"]["outputs"].get("properties", {})
    # The options of a format live as long as the program: the same ones are told by their identity.
    key = tuple((name, *map(id, one["properties"].values())) for name, one in options.items())
    if key not in _judges:
        if len(_judges) >= _MAX_JUDGES:
            _judges.clear()
        _judges[key] = _Judge(schema, validator_of(schema))
    return _judges[key]


_judges: dict[tuple[Any, ...], _Judge] = {}
_MAX_JUDGES = 100


def _of_options(tree: Map, formats: Mapping[str, Format]) -> Iterator[tuple[Steps, Quantity, Dimension]]:
    """Yield the quantities among the options of outputs that are of another kind than their format asks for."""
    outputs = tree.get("outputs")
    for name, entry in outputs.items() if isinstance(outputs, Map) else ():
        if not isinstance(entry, Map) or not any(isinstance(value, Quantity) for value in entry.values()):
            continue
        named = str(entry.get("backend", backend_of(name, entry)))
        options = formats[named].options if named in formats else {}
        for key, value in entry.items():
            if not isinstance(value, Quantity) or key not in options:
                continue
            is_number = options[key].get("type") in ("number", "integer")
            unit = parse_unit(options[key].get("x-unit", "")) if is_number else None
            if unit is not None and value.dimension != unit[1]:
                yield ["outputs", name, key], value, unit[1]


class _Walk:
    """Notes what a schema cannot say: quantities of another kind than their place asks for, NaN, infinity.

    A piece that stands in many places is walked once.
    """

    def __init__(self) -> None:
        self.path: Steps = []
        self.done: set[int] = set()
        self.not_finite: list[tuple[Steps, float]] = []
        self.misfits: list[tuple[Steps, Quantity]] = []

    def through(self, value: Map | Seq) -> None:
        """Walk through a piece of the tree."""
        before = len(self.not_finite) + len(self.misfits)
        self._walk(value)
        sound = before == len(self.not_finite) + len(self.misfits)
        if sound or value.via is None or not value.via.made:  # what is wrong in a part is told of all that are made
            self.done.add(id(value))

    def _walk(self, value: Map | Seq) -> None:
        pairs: Any = value.items() if isinstance(value, Map) else enumerate(value)
        allowed: dict[str | int, tuple[Dimension, ...] | None] = {}
        for key, item in pairs:
            kind = type(item)
            if kind is str or kind is bool or item is None or (kind is float and -MOST <= item <= MOST):
                continue
            if kind is Map or kind is Seq:
                if id(item) not in self.done:
                    self.path.append(key)
                    self.through(item)
                    self.path.pop()
            elif kind is Quantity:
                step = 0 if type(key) is int else key  # all items of a list are of the same kind
                if step not in allowed:
                    allowed[step] = self._allowed(step)
                self._quantity(item, key, allowed[step])
            elif isinstance(item, float):
                self._number(item, key)

    def _allowed(self, key: str | int) -> tuple[Dimension, ...] | None:
        # The names of entries and the indices of items make no difference.
        steps = [0 if type(step) is int else step for step in (*self.path, key)]
        if len(steps) > 1 and has_entries(str(steps[0])):
            steps[1] = "*"
        return _dimensions(tuple(steps))

    def _quantity(self, item: Quantity, key: str | int, allowed: tuple[Dimension, ...] | None) -> None:
        if allowed is not None and item.dimension not in allowed:
            self.misfits.append(([*self.path, key], item))
        self._number(float(item), key)

    def _number(self, value: float, key: str | int) -> None:
        steps = [*self.path, key]
        if not (-MOST <= value <= MOST or (math.isfinite(value) and not _is_reckoned(steps))):
            self.not_finite.append((steps, value))


def _not_finite(tree: Map, path: Steps, value: float, scope: Scope | None) -> Diagnostic:
    message = f"{subject(path)} is not a finite number"
    if math.isfinite(value):
        message = f"{subject(path)} is {value:g}, and nothing can be calculated with more than {MOST:g}"
    return problem_at(scope, tree, path, "not-finite", message, "write a number, or leave the entry out")


def _is_reckoned(steps: Steps) -> bool:
    """Say whether a number is calculated with: those of limits may be 1.8e308, and masses have rules of their own."""
    reckoned, node = False, sections().get(str(steps[0]))
    for step in steps[1:]:
        if node is None:
            break
        reckoned = reckoned if node.reckoned is None else node.reckoned
        node = node.below(step)
    return reckoned if node is None or node.reckoned is None else node.reckoned


@lru_cache(maxsize=2_000)
def _dimensions(path: tuple[str | int, ...]) -> tuple[Dimension, ...] | None:
    """Return the dimensions that the schema allows at a path; None where it has no number, for others to judge."""
    wanted = unit_at(path)
    if wanted is None:
        return None
    units = [parse_unit(unit) for unit in ([wanted] if isinstance(wanted, str) else wanted)]
    return tuple(unit[1] for unit in units if unit is not None)


def _wrong_unit(
    tree: Map, path: Steps, quantity: Quantity, allowed: tuple[Dimension, ...], scope: Scope | None
) -> Diagnostic:
    named = " or ".join(describe(dimension) for dimension in allowed)
    text = quantity.text or f"{float(quantity):g}"
    message = f"{subject(path)} is {named or 'a plain number'}, but {text} is {describe(quantity.dimension)}"
    plain = not any(map(any, allowed))
    help = "write the number alone, without a unit" if plain else "correct the unit; a bare number is in SI units"
    return problem_at(scope, tree, path, "wrong-unit", message, help)

"""Merge several values of one thing, each on a condition, into one value that chooses.

``<xacro:if>`` and ``<xacro:unless>`` around elements of one kind make alternatives. They are merged key by key: what
they share is written once, and what differs is ``${A if CONDITION else B}``.
"""

from __future__ import annotations

import ast
import re
from typing import Any

from ..description import in_order
from ..layout import Expression, Verbatim
from .formulas import all_of, negated, written

IF = Verbatim("if")
_ZEROS = ("xyz", "rpy")
_NUMBER = re.compile(r"-?[\d.]+(e[-+]?\d+)?( [a-z/]+)?")

Condition = ast.expr | None
Alternative = tuple[Any, Condition]


def conditional(value: Any, when: Condition) -> Any:
    """Return a value with its condition."""
    if when is None:
        return value
    condition = Expression(f"${{{written(when)}}}")
    return {IF: condition, **value} if isinstance(value, dict) else {IF: condition, "value": value}


def merged(key: str, found: list[Alternative], sure: list[Condition] | None = None) -> Any:
    """Return alternatives as one value, or None if they cannot be one.

    ``sure`` are conditions of which one holds anyway.
    """
    found = [one for one in found if one[1] is not None] + [one for one in found if one[1] is None]
    whens = [when for _, when in found]
    if whens.count(None) > 1:
        return None
    covered = covers(whens, sure)
    if all(value == found[0][0] for value, _ in found):
        return conditional(found[0][0], None if covered else any_of(whens))
    values = [value for value, _ in found]
    if all(isinstance(value, dict) for value in values):
        made: Any = _tables(found)
    elif all(isinstance(value, list) and any(isinstance(item, dict) for item in value) for value in values):
        made = _lists(found)
    else:
        return _chain(key, found, covered)
    return None if made is None else conditional(made, None if covered else any_of(whens))


def covers(whens: list[Condition], sure: list[Condition] | None = None) -> bool:
    """Return True if one of some conditions holds whenever one of ``sure`` does."""
    if None in whens:
        return True
    known = {written(when) for when in whens if when is not None}
    opposite = any(written(negated(when)) in known for when in whens if when is not None)
    return opposite or bool(sure and all(one is not None and written(one) in known for one in sure))


def _tables(found: list[Alternative]) -> dict[Any, Any] | None:
    if any(IF in value for value, _ in found):
        return None
    sure = [when for _, when in found]
    made: dict[Any, Any] = {}
    for key in in_order(dict.fromkeys(key for value, _ in found for key in value)):
        made[key] = merged(str(key), [(value[key], when) for value, when in found if key in value], sure)
        if made[key] is None:
            return None
    return made


def _lists(found: list[Alternative]) -> list[Any] | None:
    """Return lists of mappings as one: item by item if they are equally long, else one after the other."""
    if len({len(value) for value, _ in found}) == 1:
        sure = [when for _, when in found]
        items = [merged("", [(value[at], when) for value, when in found], sure) for at in range(len(found[0][0]))]
        if None not in items:
            return items
    if any(isinstance(item, dict) and IF in item for value, _ in found for item in value):
        return None
    whens = [when for _, when in found]
    otherwise = None if None not in whens else all_of([negated(when) for when in whens if when is not None])
    return [conditional(item, when or otherwise) for value, when in found for item in value]


def _chain(key: str, found: list[Alternative], covered: bool) -> Any:
    """Return values as a choice of one of them; of lists that differ in one item as a list with a choice."""
    values = [value for value, _ in found]
    if covered and all(isinstance(value, list) and len(value) == len(values[0]) > 1 for value in values):
        differing = [at for at in range(len(values[0])) if any(value[at] != values[0][at] for value in values)]
        if len(differing) == 1:
            (at,) = differing
            choice = _chain(key, [(value[at], when) for value, when in found], covered)
            return None if choice is None else [*values[0][:at], choice, *values[0][at + 1 :]]
    pairs = []
    for value, when in found:
        node = node_of(value)
        if node is None:
            return None
        pairs.append((node, when))
    if not covered:
        zeros = ast.List([ast.Constant(0)] * 3, ast.Load())
        pairs.append((zeros if key in _ZEROS else ast.Constant(None), None))
    last = pairs.pop()[0]
    for node, when in reversed(pairs):
        if when is None:
            return None
        last = node if written(node) == written(last) else ast.IfExp(when, node, last)
    return Expression(f"${{{written(last)}}}")


def node_of(value: Any) -> ast.expr | None:
    """Return a value of a document as an expression, or None for a mapping."""
    if isinstance(value, Expression):
        return _of_text(value)
    if isinstance(value, Verbatim):
        return _parsed(str(value))
    if isinstance(value, (str, bool)):
        return ast.Constant(value)
    if isinstance(value, list):
        items = [node_of(item) for item in value]
        return None if None in items else ast.List([item for item in items if item is not None], ast.Load())
    return None


def _of_text(value: str) -> ast.expr | None:
    """Return a text with expressions in it as one expression."""
    made: ast.expr | None = None
    pieces = [piece for piece in re.split(r"(\$\{(?:[^{}'\"]|'[^']*'|\"[^\"]*\")*\})", value) if piece]
    if any("${" in piece and not piece.startswith("${") for piece in pieces):
        return None
    for piece in pieces:
        node = _parsed(piece[2:-1]) if piece.startswith("${") else ast.Constant(piece)
        if piece.startswith("${") and len(pieces) > 1:
            node = ast.Call(ast.Name("str", ast.Load()), [node], [])
        made = node if made is None else ast.BinOp(made, ast.Add(), node)
    return made


def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text.strip(), mode="eval").body
    except SyntaxError:  # it has units
        return ast.Name(text if _NUMBER.fullmatch(text) else f"({text})", ast.Load())


def any_of(whens: list[Condition]) -> Condition:
    """Return the condition that one of several holds, or None if that is always so."""
    nodes = {written(when): when for when in whens if when is not None}
    if None in whens:
        return None
    return next(iter(nodes.values())) if len(nodes) == 1 else ast.BoolOp(ast.Or(), list(nodes.values()))

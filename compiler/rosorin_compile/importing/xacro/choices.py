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
from .symbols import all_of, call, negated, plain_node, written

IF = Verbatim("if")
_ZEROS = ("xyz", "rpy")
_NUMBER = re.compile(r"-?[\d.]+(e[-+]?\d+)?( [a-z/]+)?")
_EXPRESSION = re.compile(r"(\$\{(?:[^{}'\"]|'[^']*'|\"[^\"]*\")*\})")

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
    is_covered = covers(whens, sure)
    when = None if is_covered else any_of(whens)
    values = [value for value, _ in found]
    if all(value == values[0] for value in values):
        return conditional(values[0], when)
    if all(isinstance(value, dict) for value in values):
        made: Any = _tables(found)
        return None if made is None else conditional(made, when)
    if all(isinstance(value, list) and any(isinstance(item, dict) for item in value) for value in values):
        return _lists(found)
    return _chain(key, found, is_covered)


def covers(whens: list[Condition], sure: list[Condition] | None = None) -> bool:
    """Return True if one of some conditions holds whenever one of ``sure`` does."""
    known = {written(when) for when in whens if when is not None}
    is_either = any(written(negated(when)) in known for when in whens if when is not None)
    return None in whens or is_either or bool(sure and all(one is not None and written(one) in known for one in sure))


def any_of(whens: list[Condition]) -> Condition:
    """Return the condition that one of several holds, or None if that is always so."""
    nodes = {written(when): when for when in whens if when is not None}
    if None in whens:
        return None
    return next(iter(nodes.values())) if len(nodes) == 1 else ast.BoolOp(ast.Or(), list(nodes.values()))


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
    """Return lists of mappings as one, each item on its condition."""
    if any(isinstance(item, dict) and IF in item for value, _ in found for item in value):
        return None
    otherwise = all_of(*(negated(when) for _, when in found if when is not None))
    return [conditional(item, when or otherwise) for value, when in found for item in value]


def _chain(key: str, found: list[Alternative], is_covered: bool) -> Any:
    """Return values as a choice of one of them, or None if that is no expression."""
    pairs = [(node_of(value), when) for value, when in found]
    if not is_covered:
        pairs.append((plain_node([0, 0, 0] if key in _ZEROS else None), None))
    last = pairs.pop()[0]
    for node, when in reversed(pairs):
        if node is None or last is None or when is None:
            return None
        last = node if written(node) == written(last) else ast.IfExp(when, node, last)
    return None if last is None else Expression(f"${{{written(last)}}}")


def node_of(value: Any) -> ast.expr | None:
    """Return a value of a document as an expression, or None for a mapping."""
    if isinstance(value, Expression):
        return _of_text(value)
    if isinstance(value, Verbatim):
        return _parsed(str(value))
    if isinstance(value, (str, bool)):
        return plain_node(value)
    if isinstance(value, list):
        items = [node for item in value if (node := node_of(item)) is not None]
        return ast.List(items, ast.Load()) if len(items) == len(value) else None
    return None


def _of_text(value: str) -> ast.expr | None:
    """Return a text with expressions in it as one expression."""
    made: ast.expr | None = None
    pieces = [piece for piece in _EXPRESSION.split(value) if piece]
    if any("${" in piece and not piece.startswith("${") for piece in pieces):
        return None
    for piece in pieces:
        node = _parsed(piece[2:-1]) if piece.startswith("${") else ast.Constant(piece)
        if piece.startswith("${") and len(pieces) > 1:
            node = call("str", node)
        made = node if made is None else ast.BinOp(made, ast.Add(), node)
    return made


def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text.strip(), mode="eval").body
    except SyntaxError:  # it has units
        return ast.Name(text if _NUMBER.fullmatch(text) else f"({text})")

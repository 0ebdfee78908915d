"""Expressions of the language as syntax trees of Python. The node of a variable has the attribute ``variable``.

This module runs in the child process.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterable, Iterator
from keyword import iskeyword
from typing import Any

from rosorin_compile.language.expression import evaluate
from rosorin_compile.language.expression.functions import CONSTANTS, OF_DESCRIPTIONS, ExpressionError, functions

_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_OUTSIDE = ("find", "load", "error")  # functions whose value depends on more than their arguments


class Failed(Exception):
    """A value that the language cannot express; ``nodes`` are the expressions that it depends on."""

    def __init__(self, reason: str, *nodes: ast.AST) -> None:
        super().__init__(reason)
        self.nodes = nodes


def literal(text: Any) -> Any:
    """Convert a text of xacro to a number or a boolean if it is one."""
    if not isinstance(text, str) or "_" in text:
        return text
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return _FLAGS.get(text, text)


def plain_node(value: Any) -> ast.expr:
    """Return a Python value as an expression. Raises Failed."""
    if value is None or isinstance(value, bool):
        return ast.Name({None: "none", True: "true", False: "false"}[value], ast.Load())
    if isinstance(value, (list, tuple)):
        return ast.List([plain_node(item) for item in value], ast.Load())
    if isinstance(value, dict):
        return ast.Dict([plain_node(key) for key in value], [plain_node(dict.get(value, key)) for key in value])
    if isinstance(value, float) and not math.isfinite(value):
        raise Failed("nan and inf are no values of the language")
    if isinstance(value, (int, float)) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    if isinstance(value, (int, float, str)):
        return ast.Constant(value)
    raise Failed(f"{type(value).__name__} cannot be translated")


def number_node(text: str) -> ast.expr:
    """Return the number in a text as an expression. Raises Failed."""
    value = literal(text.strip())
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise Failed(f'"{text[:40]}" is no number')
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e6:
        value = int(value)
    return plain_node(value)


def call(name: str, *arguments: ast.expr) -> ast.Call:
    """Return the call of a function of the language."""
    return ast.Call(ast.Name(name, ast.Load()), list(arguments), [])


def negate(node: ast.expr) -> ast.expr:
    """Return the opposite of a condition."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return node.operand
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return plain_node(node.id == "false")
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        opposites: dict[type, type] = {ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In}
        if type(node.ops[0]) in opposites:
            return ast.Compare(node.left, [opposites[type(node.ops[0])]()], node.comparators)
    return ast.UnaryOp(ast.Not(), node)


def all_of(*nodes: ast.expr | None) -> ast.expr | None:
    """Join conditions by ``and``; return None without any."""
    found: dict[str, ast.expr] = {}
    for node in nodes:
        decided = None if node is None else fold(node)
        if decided is False:
            return plain_node(False)
        if node is not None and decided is not True:
            found.setdefault(as_text(node), node)
    return ast.BoolOp(ast.And(), [*found.values()]) if len(found) > 1 else next(iter(found.values()), None)


def fold(node: ast.expr) -> Any:
    """Return the value of an expression of constants, or None."""
    names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    if any(name in _OUTSIDE or (name not in CONSTANTS and name not in functions()) for name in names):
        return None
    if any(hasattr(one, "variable") for one in ast.walk(node)):
        return None
    try:
        return evaluate(as_text(node), dict[str, Any]().__getitem__)
    except ExpressionError:
        return None


def as_text(node: ast.expr) -> str:
    """Return an expression as text of the language."""
    for one in ast.walk(node):
        if isinstance(one, ast.Name) and hasattr(one, "variable"):
            one.id = one.variable.ours
    return ast.unparse(ast.fix_missing_locations(node)).strip()


def variables_in(nodes: Iterable[ast.AST]) -> Iterator[Any]:
    """Yield the variables that expressions read."""
    for node in nodes:
        yield from (one.variable for one in ast.walk(node) if hasattr(one, "variable"))


def usable(name: str, taken: Iterable[str], shadows: bool = False) -> str:
    """Return a name for an expression of the language that is not taken; ``shadows``: it may be that of a function."""
    name = re.sub(r"\W", "_", name, flags=re.ASCII) or "value"
    made, number = name, 1
    reserved = {*(() if shadows else functions()), *OF_DESCRIPTIONS, *CONSTANTS, "rad", "deg", *taken}
    while made in reserved or iskeyword(made):
        number += 1
        made = f"{name}_{number}"
    return made

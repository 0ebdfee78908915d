"""Evaluating a little of Python: the plain values that launch files and setup.py hand on. Nothing is run."""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

Names = Mapping[str, Any]
_MOST = 10_000  # characters or items; a launch file has no need of more
_LARGEST = 10**30


class Unknown(Exception):
    """The value is known only when the program runs."""


_BINARY: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def value(node: ast.expr, names: Names) -> Any:
    """Return the value of an expression of plain values, ``str()``, ``math.pi``, joins of paths and ``names``.

    Raises Unknown for anything else.
    """
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.List | ast.Tuple):
        return [value(item, names) for item in node.elts]
    if isinstance(node, ast.Name) and node.id in names:
        return names[node.id]
    if isinstance(node, ast.Attribute) and ast.unparse(node) in ("math.pi", "np.pi", "numpy.pi"):
        return math.pi
    try:
        return _combined(node, names)
    except (ArithmeticError, IndexError, TypeError, ValueError) as problem:
        raise Unknown from problem


def _combined(node: ast.expr, names: Names) -> Any:
    if isinstance(node, ast.JoinedStr):
        return _short("".join(_part(part, names) for part in node.values))
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -value(node.operand, names)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        left, right = value(node.left, names), value(node.right, names)
        if isinstance(node.op, ast.Mult) and not all(isinstance(side, int | float) for side in (left, right)):
            raise Unknown
        return _short(_BINARY[type(node.op)](left, right))
    if isinstance(node, ast.Subscript):
        index = value(node.slice, names)
        return value(node.value, names)[index]
    if isinstance(node, ast.Call) and not node.keywords:
        return _called(ast.unparse(node.func), [value(argument, names) for argument in node.args])
    raise Unknown


def _called(function: str, arguments: list[Any]) -> Any:
    plain = all(isinstance(argument, str | int | float) for argument in arguments)
    if function in ("str", "float", "math.radians", "radians") and len(arguments) == 1 and plain:
        radians = function.endswith("radians")
        return math.radians(arguments[0]) if radians else {"str": str, "float": float}[function](arguments[0])
    if function in ("os.path.join", "path.join", "join") and all(isinstance(a, str) for a in arguments):
        return "/".join(argument.rstrip("/") for argument in arguments)
    if function in ("glob", "glob.glob") and len(arguments) == 1:
        return arguments
    raise Unknown


def _part(node: ast.expr, names: Names) -> str:
    if isinstance(node, ast.FormattedValue):
        if node.format_spec is not None or node.conversion != -1:
            raise Unknown
        return str(value(node.value, names))
    return str(value(node, names))


def _short(result: Any) -> Any:
    too_long = isinstance(result, str | list) and len(result) > _MOST
    if too_long or (isinstance(result, int) and abs(result) > _LARGEST):
        raise Unknown
    return result


def constants(tree: ast.AST) -> dict[str, Any]:
    """Return the names of a program that are assigned once, and to a plain value."""
    assigned: dict[str, list[ast.expr]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                if isinstance(target, ast.Name):
                    assigned.setdefault(target.id, []).append(node.value)
    found: dict[str, Any] = {}
    for name, values in assigned.items():
        if len(values) == 1:
            try:
                found[name] = value(values[0], found)
            except Unknown:
                continue
    return found

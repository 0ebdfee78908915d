"""Plain values: what expressions of Python say that need not be run, in launch files and setup.py of people."""

from __future__ import annotations

import ast
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType
from typing import Any

Names = Mapping[str, Any]
_MOST_VALUES = 10_000  # characters or items; a launch file has no need of more
_LARGEST = 10**30
_ARGUMENT = "launch argument "
_CHANGES = ("append", "clear", "extend", "insert", "pop", "remove", "reverse", "sort", "update")


class Unknown(Exception):
    """The value is known only when the program runs."""


_BINARY: Mapping[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def value(node: ast.expr, names: Names) -> Any:
    """Return the value of an expression of plain values, ``names``, ``math.pi``, joins of paths and a few calls.

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
    except (ArithmeticError, LookupError, TypeError, ValueError) as problem:
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
    if isinstance(node, ast.Dict) and None not in node.keys:
        return dict(
            zip((value(key, names) for key in node.keys if key), (value(v, names) for v in node.values), strict=True)
        )
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "LaunchConfiguration" and node.args:
        return names[_ARGUMENT + value(node.args[0], names)]
    if isinstance(node, ast.Call) and not node.keywords:
        arguments = [value(argument, names) for argument in node.args]
        if isinstance(node.func, ast.Attribute) and node.func.attr == "split":
            return _split(value(node.func.value, names), arguments)
        return _called(ast.unparse(node.func), arguments)
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


def _split(text: Any, arguments: list[Any]) -> list[str]:
    if not isinstance(text, str) or len(arguments) > 1:
        raise Unknown
    return text.split(*arguments)


def _part(node: ast.expr, names: Names) -> str:
    if isinstance(node, ast.FormattedValue):
        if node.format_spec is not None or node.conversion != -1:
            raise Unknown
        return str(value(node.value, names))
    return str(value(node, names))


def _short(result: Any) -> Any:
    too_long = isinstance(result, str | list) and len(result) > _MOST_VALUES
    if too_long or (isinstance(result, int) and abs(result) > _LARGEST):
        raise Unknown
    return result


def constants(tree: ast.AST, names: Names = MappingProxyType({})) -> dict[str, Any]:
    """Return ``names``, and those that a program or function assigns once, and to a plain value.

    What it assigns more often, or changes in place, has no value that is known here. A launch argument has its default.
    """
    nodes = list(ast.walk(tree))
    times = Counter(node.id for node in nodes if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load))
    times.update(name for node in nodes for name in _changed(node))
    values = {name: known for name, known in names.items() if not times[name]} | _defaults(nodes, names)
    for target, given in (pair for node in nodes for pair in _assigned(node)):
        if isinstance(target, ast.Name) and times[target.id] == 1:
            with suppress(Unknown):
                values[target.id] = value(given, values)
    return values


def _defaults(nodes: Sequence[ast.AST], names: Names) -> dict[str, Any]:
    found: dict[str, Any] = {}
    declared = Counter[str]()
    for node in nodes:
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "DeclareLaunchArgument" and node.args:
            given = next((word.value for word in node.keywords if word.arg == "default_value"), None)
            with suppress(Unknown):
                name = f"{_ARGUMENT}{value(node.args[0], names)}"
                declared[name] += 1
                found |= {} if given is None else {name: value(given, names)}
    return {name: default for name, default in found.items() if declared[name] == 1 and isinstance(default, str)}


def _assigned(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    if isinstance(node, ast.Assign):
        yield from ((target, node.value) for target in node.targets)
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        yield node.target, node.value


def _changed(node: ast.AST) -> Iterator[str]:
    changed: ast.expr | None = None
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in _CHANGES:
        changed = node.func.value
    elif isinstance(node, ast.Subscript) and not isinstance(node.ctx, ast.Load):
        changed = node.value
    if isinstance(changed, ast.Name):
        yield changed.id

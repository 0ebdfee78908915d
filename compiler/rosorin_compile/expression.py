"""Expressions: a closed evaluator for what stands inside ``${...}``.

The text is parsed by Python's own parser and interpreted here, node by node, from an allow-list: arithmetic,
comparison, conditions, lists, indexing and the functions in ``FUNCTIONS``. There is no attribute access, no import,
no assignment and no way to reach an object of the interpreter. Length, depth, the size of numbers and the number of
steps are bounded, so that every expression ends soon.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from .quantity import ANGLE, NUMBER, UNITS, Dimension, Quantity, add, describe, dimension_of

MAX_LENGTH = 2_000
MAX_DEPTH = 40
MAX_STEPS = 100_000
MAX_ITEMS = 10_000
MAX_MAGNITUDE = 1e300


class ExpressionError(Exception):
    """An expression that cannot be evaluated; ``column`` counts from 0 within the expression."""

    def __init__(self, message: str, column: int = 0, help: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.column = column
        self.help = help


def evaluate(text: str, lookup: Callable[[str], Any]) -> Any:
    """Return the value of an expression.

    ``lookup`` gives the value of a name and raises KeyError if there is none; the units in ``quantity.UNITS``,
    the constants and the functions below need no lookup.
    Raises ExpressionError on anything that is not allowed or has no value.
    """
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except SyntaxError as problem:
        raise ExpressionError(f"not an expression: {problem.msg}", max(0, (problem.offset or 1) - 1)) from None
    except (ValueError, RecursionError, MemoryError):
        raise ExpressionError("not an expression that can be read") from None
    return _Evaluator(lookup).value(tree.body, 0)


def _sine(function: Callable[[float], float]) -> Callable[[Any], float]:
    def apply(angle: Any) -> float:
        _expect(angle, (ANGLE, NUMBER))
        return function(float(angle))

    return apply


def _arc(function: Callable[..., float]) -> Callable[..., Quantity]:
    return lambda *values: Quantity(function(*map(float, values)), ANGLE)


def _keeping(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of numbers keep their common dimension."""

    def apply(*values: Any) -> Any:
        flat = list(values[0]) if len(values) == 1 and isinstance(values[0], list) else list(values)
        dimension = _common(flat)
        result = function(*flat)
        return Quantity(result, dimension) if dimension else result

    return apply


def _sqrt(value: Any) -> Any:
    dimension = dimension_of(value)
    if dimension is None or any(n % 2 for n in dimension):
        return math.sqrt(value)
    a, b, c, d = (n // 2 for n in dimension)
    return Quantity(math.sqrt(value), (a, b, c, d))


def _expect(value: Any, allowed: tuple[Dimension, ...]) -> None:
    dimension = dimension_of(value)
    if dimension is not None and dimension not in allowed:
        raise ExpressionError(f"expected {describe(allowed[0])}, got {describe(dimension)}")


def _common(values: list[Any]) -> Dimension | None:
    """Return the dimension that all values share; bare numbers go with any. Raises ExpressionError otherwise."""
    found: Dimension | None = None
    for value in values:
        if not isinstance(value, (int, float)):
            raise ExpressionError(f"expected a number, got {_kind(value)}")
        dimension = dimension_of(value)
        if found is not None and dimension not in (None, found):
            raise ExpressionError(f"{describe(found)} and {describe(dimension or NUMBER)} do not go together")
        found = found or dimension
    return found


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sin": _sine(math.sin),
    "cos": _sine(math.cos),
    "tan": _sine(math.tan),
    "asin": _arc(math.asin),
    "acos": _arc(math.acos),
    "atan": _arc(math.atan),
    "atan2": _arc(math.atan2),
    "sqrt": _sqrt,
    "hypot": _keeping(math.hypot),
    "abs": _keeping(abs),
    "min": _keeping(min),
    "max": _keeping(max),
    "floor": math.floor,
    "ceil": math.ceil,
    "round": round,
    "exp": math.exp,
    "log": math.log,
    "len": len,
    "int": int,
    "float": float,
    "str": str,
}

CONSTANTS: dict[str, Any] = {"pi": math.pi, "tau": math.tau, "true": True, "false": False, "none": None}

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}


def _kind(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, (int, float)):
        return "a number"
    if isinstance(value, str):
        return "text"
    return "a table" if isinstance(value, Mapping) else "a list"


class _Evaluator:
    """Interprets one expression; counts its steps."""

    def __init__(self, lookup: Callable[[str], Any]) -> None:
        self.lookup = lookup
        self.steps = 0

    def value(self, node: ast.AST, depth: int) -> Any:
        self.steps += 1
        if depth > MAX_DEPTH or self.steps > MAX_STEPS:
            raise ExpressionError("the expression is too deep or too long", getattr(node, "col_offset", 0))
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            help = "allowed: numbers, text, lists, names, + - * / // % **, comparisons, and, or, not, a if c else b"
            raise ExpressionError(f"{_construct(node)} is not allowed here", getattr(node, "col_offset", 0), help)
        try:
            return _bounded(method(node, depth + 1))
        except ExpressionError as problem:
            problem.column = problem.column or getattr(node, "col_offset", 0)
            raise
        except (TypeError, ValueError, ArithmeticError, LookupError, RecursionError, MemoryError) as problem:
            raise ExpressionError(_reason(problem), getattr(node, "col_offset", 0)) from None

    def _constant(self, node: ast.Constant, _depth: int) -> Any:
        if isinstance(node.value, (bool, int, float, str)) or node.value is None:
            return node.value
        raise ExpressionError("only numbers and text are values here")

    def _name(self, node: ast.Name, _depth: int) -> Any:
        try:
            return self.lookup(node.id)
        except KeyError:
            pass
        if node.id in CONSTANTS:
            return CONSTANTS[node.id]
        if node.id in UNITS:
            return Quantity(*UNITS[node.id])
        if node.id in ("True", "False", "None"):
            return {"True": True, "False": False, "None": None}[node.id]
        raise ExpressionError(f'there is no value named "{node.id}"', node.col_offset, f"name:{node.id}")

    def _binop(self, node: ast.BinOp, depth: int) -> Any:
        left, right = self.value(node.left, depth), self.value(node.right, depth)
        kind = type(node.op)
        if kind not in _BINARY:
            raise ExpressionError("this operator is not allowed here", node.col_offset)
        if isinstance(left, (str, list)) or isinstance(right, (str, list)):
            return _joined(kind, left, right)
        return _arithmetic(kind, left, right)

    def _unaryop(self, node: ast.UnaryOp, depth: int) -> Any:
        operand = self.value(node.operand, depth)
        if isinstance(node.op, ast.Not):
            return not operand
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise ExpressionError("this operator is not allowed here", node.col_offset)
        result = -operand if isinstance(node.op, ast.USub) else +operand
        dimension = dimension_of(operand)
        return Quantity(result, dimension) if dimension else result

    def _boolop(self, node: ast.BoolOp, depth: int) -> Any:
        stop = isinstance(node.op, ast.Or)
        result: Any = None
        for part in node.values:
            result = self.value(part, depth)
            if bool(result) == stop:
                break
        return result

    def _compare(self, node: ast.Compare, depth: int) -> bool:
        left = self.value(node.left, depth)
        for op, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part, depth)
            if type(op) not in _COMPARE:
                raise ExpressionError("this comparison is not allowed here", node.col_offset)
            if isinstance(left, Quantity) and isinstance(right, Quantity):
                _common([left, right])
            if not _COMPARE[type(op)](left, right):
                return False
            left = right
        return True

    def _ifexp(self, node: ast.IfExp, depth: int) -> Any:
        return self.value(node.body if self.value(node.test, depth) else node.orelse, depth)

    def _list(self, node: ast.List, depth: int) -> list[Any]:
        return [self.value(item, depth) for item in node.elts]

    def _tuple(self, node: ast.Tuple, depth: int) -> list[Any]:
        return [self.value(item, depth) for item in node.elts]

    def _subscript(self, node: ast.Subscript, depth: int) -> Any:
        container, index = self.value(node.value, depth), self.value(node.slice, depth)
        if isinstance(container, Mapping) and index not in container:
            raise ExpressionError(f'the table has no entry "{index}"', node.col_offset)
        return container[index]

    def _call(self, node: ast.Call, depth: int) -> Any:
        if not isinstance(node.func, ast.Name) or node.func.id not in FUNCTIONS:
            name = node.func.id if isinstance(node.func, ast.Name) else "this"
            raise ExpressionError(f'there is no function "{name}"', node.col_offset, f"function:{name}")
        if node.keywords:
            raise ExpressionError("functions take no named arguments here", node.col_offset)
        return FUNCTIONS[node.func.id](*(self.value(item, depth) for item in node.args))


def _arithmetic(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return the result of an operator on two numbers, with its dimension."""
    first, second = dimension_of(left), dimension_of(right)
    if kind is ast.Pow:
        if abs(right) > 64 or (isinstance(left, int) and abs(left) > 10**9):
            raise ExpressionError("the power is too large")
        exponent = int(right) if first else 0
        if first and exponent != right:
            raise ExpressionError("a quantity may only be raised to a whole power")
        return Quantity(left**right, add(NUMBER, first, exponent)) if first else left**right
    if first is None and second is None:
        return _BINARY[kind](left, right)
    if kind in (ast.Mult, ast.Div):
        sign = 1 if kind is ast.Mult else -1
        dimension = add(first or NUMBER, second or NUMBER, sign)
        result = _BINARY[kind](float(left), float(right))
        return Quantity(result, dimension) if dimension != NUMBER else result
    return Quantity(_BINARY[kind](float(left), float(right)), _common([left, right]) or NUMBER)


def _joined(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return text or lists joined; only + with two of a kind is defined."""
    if kind is ast.Add and isinstance(left, str) and isinstance(right, str):
        return left + right
    if kind is ast.Add and isinstance(left, list) and isinstance(right, list):
        return [*left, *right]
    raise ExpressionError(f"cannot combine {_kind(left)} and {_kind(right)} with this operator")


def _bounded(value: Any) -> Any:
    """Return the value unless it grows beyond what a description can need."""
    if isinstance(value, complex):
        raise ExpressionError("the result is not a real number")
    if isinstance(value, (int, float)) and not isinstance(value, bool) and not abs(value) < MAX_MAGNITUDE:
        raise ExpressionError("the result is not a finite number")
    if isinstance(value, (str, list)) and len(value) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
    return value


def _construct(node: ast.AST) -> str:
    names = {"Attribute": "access to an attribute", "Lambda": "a lambda", "ListComp": "a comprehension"}
    return names.get(type(node).__name__, f"this ({type(node).__name__})")


def _reason(problem: Exception) -> str:
    if isinstance(problem, ZeroDivisionError):
        return "division by zero"
    return str(problem) or type(problem).__name__

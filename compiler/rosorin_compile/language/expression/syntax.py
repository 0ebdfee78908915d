"""The syntax of expressions: each node of Python's parser that is allowed becomes a function of the names in scope.

``combine``, ``entry``, ``sliced`` and their like say what operators give for values; ``Effort`` keeps all of it in
bounds. ``compile_node`` goes through the nodes.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from typing import Any

from rosorin_compile.source.diagnostics import nearest
from rosorin_compile.source.units import NUMBER, UNITS, Dimension, Quantity, add

from .functions import CONSTANTS, MAX_ITEMS, ExpressionError, KindError, common_dimension, functions, kind_of
from .literals import Literal

BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}

COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}


def combine(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return the result of an operator on two values, at least one of which is no bare number.

    Quantities add and compare with their like, and multiply to the product of their dimensions; a bare number goes
    with any. Raises ExpressionError.
    """
    if type(left) in NUMERIC and type(right) in NUMERIC:
        first: Dimension | None = left.dimension if type(left) is Quantity else None
        second: Dimension | None = right.dimension if type(right) is Quantity else None
        if kind is ast.Mult or kind is ast.Div:
            dimension = _times(first, second, kind is ast.Mult)
            result = BINARY[kind](left, right)
            return Quantity(result, dimension) if dimension is not None else result
        if kind is ast.Pow:
            return _power(left, right)
        common = first if first == second else common_dimension([left, right])
        result = bounded(BINARY[kind](left, right))
        return result if kind is ast.FloorDiv or common is None else Quantity(result, common)
    return _join(kind, left, right)


NUMERIC = frozenset((int, float, Quantity))


@lru_cache(maxsize=1_000)
def _times(first: Dimension | None, second: Dimension | None, times: bool) -> Dimension | None:
    """Return the dimension of a product or a quotient; None for a plain number."""
    dimension = add(first or NUMBER, second or NUMBER, 1 if times else -1)
    return dimension if dimension != NUMBER else None


def _join(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return two texts or two lists joined by ``+``, the only operator that they have."""
    texts = isinstance(left, str) and isinstance(right, str)
    if kind is ast.Add and (texts or (isinstance(left, list) and isinstance(right, list))):
        if len(left) + len(right) > MAX_ITEMS:
            raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
        EFFORT.spend(left, right)
        return left + right if texts else [*left, *right]
    raise KindError(f"cannot combine {kind_of(left)} and {kind_of(right)} with this operator")


def _power(base: Any, exponent: Any) -> Any:
    if abs(exponent) > 64 or (isinstance(base, int) and abs(base) > 10**9):
        raise ExpressionError("the power is too large")
    dimension = getattr(base, "dimension", None)
    if isinstance(exponent, Quantity) and exponent.dimension != NUMBER:
        raise KindError(f"an exponent is a plain number, not {kind_of(exponent)}")
    if dimension is None:
        return bounded(base**exponent)
    if int(exponent) != exponent:
        raise ExpressionError("a quantity may only be raised to a whole power")
    return Quantity(float(base) ** exponent, _raised(dimension, int(exponent)))


@lru_cache(maxsize=1_000)
def _raised(dimension: Dimension, exponent: int) -> Dimension:
    return add(NUMBER, dimension, exponent)


def entry(container: Any, key: Any) -> Any:
    """Return an entry of a table, a list or a text. Raises ExpressionError if it has none of that name."""
    if not isinstance(key, (str, int, float)):
        raise KindError(f"an entry is named by text or a number, not {kind_of(key)}")
    if isinstance(container, Mapping):
        if key not in container:
            entries = f"entries: {', '.join(map(str, container)) or 'it is empty'}"
            meant = (
                nearest(key, [name for name in container if isinstance(name, str)]) if isinstance(key, str) else None
            )
            help = f'did you mean "{meant}"? ({entries})' if meant else entries
            near = getattr(container, "key_spans", {}).get(meant)
            raise ExpressionError(f'the table has no entry "{key}"', help=help, near=near)
        return container[key]
    if not isinstance(container, (list, str)):
        raise KindError(f"{kind_of(container)} has no entries")
    if not isinstance(key, int):
        raise KindError(f"an item is named by its number, not {kind_of(key)}")
    return container[key]


def holds(function: Callable[[Any, Any], bool] | None, left: Any, right: Any) -> bool:
    """Say whether a comparison holds. Raises ExpressionError where the two cannot be compared."""
    are_numbers = type(left) in NUMERIC and type(right) in NUMERIC
    if not are_numbers and (isinstance(left, _SIZED) or isinstance(right, _SIZED)):
        EFFORT.spend(left, right)
    try:
        return function is not None and bool(function(left, right))
    except TypeError:
        raise KindError(f"{kind_of(left)} and {kind_of(right)} cannot be compared") from None


def sliced(container: Any, ends: list[Any]) -> Any:
    """Return the part of a list or a text from one end to another, by steps. Raises ExpressionError."""
    if not isinstance(container, (list, str)):
        raise KindError(f"{kind_of(container)} has no items in order")
    EFFORT.spend(container)
    return container[slice(*ends)]


def called(name: str, function: Callable[..., Any], values: list[Any]) -> Any:
    """Return what a function gives, within bounds. Raises ExpressionError in the words of the description."""
    EFFORT.spend(*values)
    try:
        result = bounded(function(*values))
    except (TypeError, AttributeError):
        given = ", ".join(map(kind_of, values)) or "nothing"
        raise KindError(f"{name}() does not take {given}") from None
    except (ValueError, ArithmeticError, LookupError):
        raise ExpressionError(f"{name}() has no value for this") from None
    if isinstance(result, (list, str)):
        EFFORT.spend(result)
    return result


MAX_MAGNITUDE = 1e300
MAX_INTEGER = 10**18
MAX_WORK = 3_000_000

_SIZED = (str, list, dict)


class Effort:
    """The work that the expression under evaluation has done so far, those nested in it included.

    ``total`` is the work of all that have been evaluated.
    """

    def __init__(self) -> None:
        self.done = 0
        self.total = 0

    def spend(self, *values: Any) -> None:
        """Count the items of the values, and one step. Raises ExpressionError when it is too much."""
        self.done += 1
        for value in values:
            if type(value) is str:
                self.done += len(value) // 8 + 1
            elif type(value) not in NUMERIC and isinstance(value, _SIZED):
                self.done += weight(value)
        if self.done > MAX_WORK:
            raise ExpressionError(f"more than {MAX_WORK:,} steps")


EFFORT = Effort()


def weight(value: Any) -> int:
    """Return the number of values within a value, itself included; lists in lists count as often as they stand there.

    Stops counting a little above the bound of a list.
    """
    if not isinstance(value, (list, dict)):
        return len(value) // 8 + 1 if isinstance(value, str) else 1
    total, waiting = 0, [value]
    while waiting and total <= MAX_ITEMS:
        items: Any = waiting.pop()
        items = items.values() if isinstance(items, dict) else items
        total += len(items) + 1
        waiting += [item for item in items if isinstance(item, (list, dict))]
    return total


def bounded(value: Any) -> Any:
    """Return the value. Raises ExpressionError if it grows beyond what a description can need, or is no number."""
    kind = type(value)
    if kind is bool or value is None:
        return value
    if isinstance(value, (float, Quantity)):
        if not abs(value) < MAX_MAGNITUDE:
            raise ExpressionError("the result is not a finite number")
    elif isinstance(value, int):
        if abs(value) > MAX_INTEGER:
            raise ExpressionError("the number is too large")
    elif isinstance(value, complex):
        raise ExpressionError("the result is not a real number")
    elif isinstance(value, str):
        if len(value) > MAX_ITEMS:
            raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    elif weight(value) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
    return value


MAX_DEPTH = 40

Lookup = Callable[[str], "Any"]
Code = Callable[[Lookup], "Any"]


class _Loop:
    """The loops of a list, while it is compiled: their names, and how many parts of an item know none of them."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names
        self.parts = 0

    def once(self, code: Code) -> Code:
        """Return what works out a number once for all items of a list; another value is made anew for each."""
        part = self.parts
        self.parts += 1

        def look(lookup: Lookup) -> Any:
            known: dict[int, Any] = lookup(_KNOWN)
            if part in known:
                return known[part]
            value = code(lookup)
            if type(value) in NUMERIC:
                known[part] = value
            return value

        return look


_KNOWN = ""  # a name that nothing has: of what is known for all items of the list that is being made
Within = tuple[int, "_Loop | None"]  # how deep a node stands in its expression, and the loops around it


def compile_node(node: ast.AST, within: Within = (0, None)) -> Code:
    """Return the function of a node. Raises ExpressionError, with its column, for a node that is not allowed."""
    column = getattr(node, "col_offset", 0)
    make = _NODES.get(type(node))
    depth, loop = within
    if depth > MAX_DEPTH:
        raise ExpressionError("the expression is nested too deeply", column)
    if make is None:
        help = "allowed: numbers, text, lists, names, + - * / // % **, comparisons, and, or, not, a if c else b"
        raise ExpressionError(f"{_construct(node)} is not allowed here", column, help)
    code = make(node, (depth + 1, loop))
    return loop.once(code) if loop and type(node) is ast.BinOp and loop.names.isdisjoint(names(node)) else code


def nodes(tree: ast.AST) -> list[ast.AST]:
    """Return all nodes of a tree."""
    found = [tree]
    for node in found:  # which grows meanwhile
        for field in node._fields:
            value = getattr(node, field, None)
            found += [one for one in (value if isinstance(value, list) else [value]) if isinstance(one, ast.AST)]
    return found


def names(tree: ast.AST) -> list[str]:
    """Return the names in a tree, as often as they stand there."""
    return [node.id for node in nodes(tree) if isinstance(node, ast.Name)]


def _constant(node: ast.Constant, _within: Within) -> Code:
    value: Any = node.value
    if isinstance(value, Literal):
        return _literal(value, node.col_offset)
    if not (isinstance(value, (bool, int, float, str)) or value is None):
        raise ExpressionError("only numbers and text are values here", node.col_offset)
    if isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise ExpressionError("half a letter (a lone surrogate) cannot stand in a file", node.col_offset)
    value = bounded(value)
    return lambda _lookup: value


def _literal(literal: Literal, column: int) -> Code:
    """Return a quantity, such as ``5 N*m``; a value that is called like one of its units could be meant as well."""
    value, factors = literal

    def look(lookup: Lookup) -> Any:
        for name in factors:
            with suppress(KeyError):
                lookup(name)
                spaced = value.text.replace("*", " * ").replace("/", " / ").replace("^", "**")
                help = f"call the value something else; or write {spaced} where it is meant"
                raise ExpressionError(f'"{name}" in {value.text} is a unit, and a value here', column, help)
        return value

    return look if factors else lambda _lookup: value


def _name(node: ast.Name, _within: Within) -> Code:
    name, column = node.id, node.col_offset
    builtin = CONSTANTS.get(name, Quantity(*UNITS[name]) if name in UNITS else None)
    known = name in CONSTANTS or name in UNITS

    def look(lookup: Lookup) -> Any:
        try:
            return lookup(name)
        except KeyError:
            if known:
                return builtin
        raise ExpressionError(f'there is no value named "{name}"', column, unknown=name)

    return look


_OPERATORS: dict[type[ast.operator], str] = {
    ast.BitXor: "a power is written **; ^ stands in units alone, such as 2 kg*m^2",
    ast.BitAnd: 'write "and"',
    ast.BitOr: 'write "or"',
}


def _binop(node: ast.BinOp, within: Within) -> Code:
    left, right = compile_node(node.left, within), compile_node(node.right, within)
    kind = type(node.op)
    function = BINARY.get(kind)
    if function is None:
        raise ExpressionError("this operator is not allowed here", node.col_offset, _OPERATORS.get(kind, ""))
    if kind in (ast.Mult, ast.Div):
        return _product(kind, function, left, right)
    simple = kind in (ast.Add, ast.Sub)

    def apply(lookup: Lookup) -> Any:
        a, b = left(lookup), right(lookup)
        if simple and type(a) in _BARE and type(b) in _BARE:
            return function(a, b)  # a sum of a few numbers stays a number of their size
        return combine(kind, a, b)

    return apply


_BARE = frozenset((int, float))


def _product(kind: type[ast.operator], function: Callable[[Any, Any], Any], left: Code, right: Code) -> Code:
    """Return a product or a quotient, with a short way for a bare number and a quantity, which most of them are."""

    def apply(lookup: Lookup) -> Any:
        a, b = left(lookup), right(lookup)
        first, second = type(a), type(b)
        if second in _BARE:
            if first is Quantity:
                return Quantity(function(a, b), a.dimension)
            if first in _BARE:
                return bounded(function(a, b)) if first is int else function(a, b)
        elif second is Quantity and first in _BARE and kind is ast.Mult:
            return Quantity(function(a, b), b.dimension)
        return combine(kind, a, b)

    return apply


def _unaryop(node: ast.UnaryOp, within: Within) -> Code:
    operand = compile_node(node.operand, within)
    if isinstance(node.op, ast.Not):
        return lambda lookup: not operand(lookup)
    if not isinstance(node.op, (ast.USub, ast.UAdd)):
        raise ExpressionError("this operator is not allowed here", node.col_offset)
    sign = -1 if isinstance(node.op, ast.USub) else 1

    def apply(lookup: Lookup) -> Any:
        value = operand(lookup)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise KindError(f"expected a number, got {kind_of(value)}")
        return Quantity(sign * value, value.dimension) if isinstance(value, Quantity) else sign * value

    return apply


def _boolop(node: ast.BoolOp, within: Within) -> Code:
    parts = [compile_node(part, within) for part in node.values]
    stop = isinstance(node.op, ast.Or)

    def apply(lookup: Lookup) -> Any:
        result: Any = None
        for part in parts:
            result = part(lookup)
            if bool(result) == stop:
                break
        return result

    return apply


def _compare(node: ast.Compare, within: Within) -> Code:
    first = compile_node(node.left, within)
    rest = [
        (COMPARE.get(type(op)), isinstance(op, (ast.In, ast.NotIn)), compile_node(part, within))
        for op, part in zip(node.ops, node.comparators, strict=True)
    ]
    if any(function is None for function, _, _ in rest):
        raise ExpressionError("this comparison is not allowed here", node.col_offset)
    literals = _compared_literals(node)

    def apply(lookup: Lookup) -> bool:
        for name, literal in literals:
            _check_choice(lookup, name, literal)
        left = first(lookup)
        for function, of_many, part in rest:
            right = part(lookup)
            if type(left) in _BARE and type(right) in _BARE and function is not None and not of_many:
                if not function(left, right):
                    return False
            else:
                if isinstance(left, Quantity) and isinstance(right, Quantity):
                    common_dimension([left, right])
                if not holds(function, left, right):
                    return False
            left = right
        return True

    return apply


CHOICES = " in"  # behind the name of an argument: the values that its one_of allows
_EQUALITY = (ast.Eq, ast.NotEq, ast.In, ast.NotIn)


def _compared_literals(node: ast.Compare) -> list[tuple[str, ast.Constant]]:
    """Return the literals of a comparison, each with the name that it is compared with."""
    sides = [node.left, *node.comparators]
    found: list[tuple[str, ast.Constant]] = []
    for operation, left, right in zip(node.ops, sides, sides[1:], strict=False):
        for name, other in ((left, right), (right, left)) if isinstance(operation, _EQUALITY) else ():
            items = other.elts if isinstance(other, (ast.List, ast.Tuple)) else [other]
            if isinstance(name, ast.Name):
                found += [(name.id, item) for item in items if isinstance(item, ast.Constant)]
    return [(name, item) for name, item in found if isinstance(item.value, (str, int, float))]


def _check_choice(lookup: Lookup, name: str, literal: ast.Constant) -> None:
    """Raise ExpressionError if an argument with ``one_of`` is compared with a value that it never has."""
    try:
        choices: Any = lookup(name + CHOICES)
    except KeyError:
        return
    value: Any = literal.value
    if value not in choices:
        allowed = f"allowed: {', '.join(map(str, choices))}"
        texts = [choice for choice in choices if isinstance(choice, str)]
        meant = nearest(value, texts) if isinstance(value, str) else None
        help = f'did you mean "{meant}"? ({allowed})' if meant else allowed
        raise ExpressionError(f'the argument "{name}" is never "{value!s}"', literal.col_offset, help)


def _ifexp(node: ast.IfExp, within: Within) -> Code:
    test, body, orelse = (compile_node(part, within) for part in (node.test, node.body, node.orelse))
    return lambda lookup: body(lookup) if test(lookup) else orelse(lookup)


def _list(node: ast.List | ast.Tuple, within: Within) -> Code:
    items = [compile_node(item, within) for item in node.elts]
    return lambda lookup: [item(lookup) for item in items]


def _subscript(node: ast.Subscript, within: Within) -> Code:
    container = compile_node(node.value, within)
    if isinstance(node.slice, ast.Slice):
        ends = [
            compile_node(end, within) if end else None for end in (node.slice.lower, node.slice.upper, node.slice.step)
        ]
        return lambda lookup: sliced(container(lookup), [end(lookup) if end else None for end in ends])
    index = compile_node(node.slice, within)
    return lambda lookup: entry(container(lookup), index(lookup))


def _attribute(node: ast.Attribute, within: Within) -> Code:
    container, key = compile_node(node.value, within), node.attr

    def apply(lookup: Lookup) -> Any:
        value = container(lookup)
        if not isinstance(value, Mapping):
            raise KindError(f"{kind_of(value)} has no entries; only a table has")
        return entry(value, key)

    return apply


def _comprehension(node: ast.ListComp | ast.GeneratorExp, within: Within) -> Code:
    if len(node.generators) > 2:
        raise ExpressionError("at most two loops stand in one list", node.col_offset)
    loops = [_loop(generator, (within[0], None)) for generator in node.generators]
    around = _Loop(frozenset(name for names, _, _ in loops for name in names))
    element = compile_node(node.elt, (within[0], around))

    def apply(lookup: Lookup) -> list[Any]:
        items: list[Any] = []
        known: dict[int, Any] = {}

        def run(level: int, scope: Lookup) -> None:
            if level == len(loops):
                items.append(element(scope))
                return
            names, values, conditions = loops[level]
            for item in values(scope):
                EFFORT.spend()
                inner = _bind(scope, names, item)
                if not conditions or all(condition(inner) for condition in conditions):
                    run(level + 1, inner)

        run(0, (lambda name: known if name is _KNOWN else lookup(name)) if around.parts else lookup)
        return items

    return apply


def _loop(generator: ast.comprehension, within: Within) -> tuple[list[str], Code, list[Code]]:
    targets = generator.target.elts if isinstance(generator.target, ast.Tuple) else [generator.target]
    if not all(isinstance(target, ast.Name) for target in targets):
        raise ExpressionError("a loop sets plain names", generator.target.col_offset)
    names = [target.id for target in targets if isinstance(target, ast.Name)]
    return names, compile_node(generator.iter, within), [compile_node(condition, within) for condition in generator.ifs]


def _bind(lookup: Lookup, names: list[str], item: Any) -> Lookup:
    if len(names) > 1 and (not isinstance(item, list) or len(item) != len(names)):
        raise KindError(f"cannot give {kind_of(item)} to {len(names)} names")
    bound = dict(zip(names, item, strict=True)) if len(names) > 1 else {names[0]: item}

    def inner(name: str) -> Any:
        if name in bound:
            return bound[name]
        if name.removesuffix(CHOICES) in bound:
            raise KeyError(name)
        return lookup(name)

    return inner


def _call(node: ast.Call, within: Within) -> Code:
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    if not name:
        help = "functions are called by name: upper(text), not text.upper()"
        raise ExpressionError("this is no function", node.col_offset, help)
    if node.keywords or any(isinstance(item, ast.Starred) for item in node.args):
        raise ExpressionError("functions take their values in order, without names or stars", node.col_offset)
    items = [compile_node(item, within) for item in node.args]
    function, column = functions().get(name), node.col_offset

    def apply(lookup: Lookup) -> Any:
        target = function
        if target is None:
            try:
                target = lookup(f"{name}()")  # a function of the scope, such as load
            except KeyError:
                raise ExpressionError(f'there is no function "{name}"', column, unknown=f"{name}()") from None
        return called(name, target, [item(lookup) for item in items])

    return apply


_NODES: dict[type[ast.AST], Callable[[Any, Within], Code]] = {
    ast.Constant: _constant,
    ast.Name: _name,
    ast.BinOp: _binop,
    ast.UnaryOp: _unaryop,
    ast.BoolOp: _boolop,
    ast.Compare: _compare,
    ast.IfExp: _ifexp,
    ast.List: _list,
    ast.Tuple: _list,
    ast.Subscript: _subscript,
    ast.Attribute: _attribute,
    ast.ListComp: _comprehension,
    ast.GeneratorExp: _comprehension,
    ast.Call: _call,
}


def _construct(node: ast.AST) -> str:
    names = {"Lambda": "a lambda", "NamedExpr": "an assignment", "JoinedStr": "a formatted text", "Dict": "a table"}
    return names.get(type(node).__name__, f"this ({type(node).__name__})")

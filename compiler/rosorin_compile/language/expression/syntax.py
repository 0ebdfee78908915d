"""The syntax of expressions: quantities, allowed nodes, operators, size limits, and errors for invalid text.

In ``30 mm`` or ``2.5 kg*m^2``, the number and the unit are a single value; this binds tighter than every operator.
"""

import ast
import operator
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Suggestion
from rosorin_compile.source.units import NUMBER, UNITS, Quantity, add, dimension_of
from rosorin_compile.source.wording import printable

from .functions import CONSTANTS, MAX_ITEMS, ExpressionError, KindError, common_dimension, functions, kind_of

MAX_DEPTH = 40
MAX_MAGNITUDE = 1e300
MAX_INTEGER = 10**18
MAX_WORK = 3_000_000

NUMERIC = frozenset((int, float, Quantity))
CHOICES = " in"  # a lookup of "NAME in" returns the allowed values (one_of) of the argument NAME
Lookup = Callable[[str], "Any"]

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {ast.Add: operator.add, ast.Sub: operator.sub}
_BINARY |= {ast.Mult: operator.mul, ast.Div: operator.truediv, ast.FloorDiv: operator.floordiv}
_BINARY |= {ast.Mod: operator.mod, ast.Pow: operator.pow}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
_COMPARE |= {ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}
_COMPARE |= {ast.In: lambda a, b: a in b, ast.NotIn: lambda a, b: a not in b}
_OF_CHOICES = (ast.Eq, ast.NotEq, ast.In, ast.NotIn)  # they are checked against the choices of an argument
_OTHER_OPERATORS: dict[type[ast.operator], str] = {ast.BitAnd: 'write "and"', ast.BitOr: 'write "or"'}
_OTHER_OPERATORS |= {ast.BitXor: 'write "**" for a power; "^" is only for units, such as "2 kg*m^2"'}
_SIZED = (str, list, dict)
_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FACTOR = r"[A-Za-z]+(?:\^-?\d)?(?![\w(])"
# The first alternatives skip strings and names, which contain no quantities.
_TOKEN = re.compile(
    r"""'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|[^\W\d]\w*|"""
    rf"(?<![\w.])(?P<number>{_NUMBER})[ ]*(?P<unit>{_FACTOR}(?:[*/]{_FACTOR})*)"
)
_OVER = rf"(?<![\w.])({_NUMBER})\s*/\s*\Z"


class Literal(NamedTuple):
    """A quantity in an expression; ``factors`` are the units after the first, such as ("m",) for ``kg*m``."""

    value: Quantity
    factors: tuple[str, ...]


def mask_quantities(text: str) -> tuple[str, dict[tuple[int, int], Literal]]:
    """Replace each quantity with a name of equal length; return (text, quantities by (line, column))."""
    parts: list[str] = []
    found: dict[tuple[int, int], Literal] = {}
    end = 0
    for match in _TOKEN.finditer(text):
        unit = ""  # the longest prefix that consists of units; the rest is arithmetic
        for factor in re.finditer(r"[*/]?([A-Za-z]+)(?:\^-?\d)?", match["unit"] or ""):
            if factor[1] not in UNITS:
                break
            unit = match["unit"][: factor.end()]
        parsed = Quantity.parse(f"{match['number']} {unit}") if unit else None
        if parsed is None or match.start() < end:
            continue
        start, stop = match.start(), match.start("unit") + len(unit)
        written = text[start:stop]
        if text[stop:].lstrip().startswith("**"):
            help = f'write "{unit}^2" for a power of the unit, "({written})**2" for a power of the value'
            raise ExpressionError(f'"**" after "{written}" is ambiguous: is it a power of the unit?', start, help)
        if quotient := re.search(_OVER, text[:start]):
            number = quotient[1]
            help = f'write "{number}/{written.removesuffix(unit).strip()} * 1 {unit}", or "{number} / ({written})"'
            message = f'"{number}/{written}" is ambiguous: a fraction of 1 {unit}, or {number} over {written}?'
            raise ExpressionError(message, start, help)
        line = text.count("\n", 0, start) + 1
        column = len(text[text.rfind("\n", 0, start) + 1 : start].encode())  # in bytes, as Python's parser counts
        factors = tuple(re.findall("[A-Za-z]+", unit)[1:])
        found[line, column] = Literal(Quantity(parsed, parsed.dimension, written), factors)
        parts += [text[end:start], "_" * (stop - start)]
        end = stop
    return "".join([*parts, text[end:]]), found


# Patterns for syntax of other languages, with help texts.
_FOREIGN: tuple[tuple[str, str], ...] = (
    (r"&&", 'write "and"'),
    (r"\|\|", 'write "or"'),
    (r"\?.*:", 'write "A if CONDITION else B"'),
    (r"!(?!=)", 'write "not"'),
    (r"\$", 'write the name without "$"'),
    (r"[\u00b0\u00ba]", 'write "deg", as in "90 deg"'),
    (r"[\u2212\u2013\u2014]", 'write the minus sign of the keyboard: "-"'),
    (r"[\u00b2\u00b3]", 'write "**2" or "**3"; in a unit "^2" or "^3"'),
    (r"[\u2018\u2019\u201c\u201d]", "write straight quotes"),
    (r"(?<![=<>!])=(?!=)", 'to compare, write "=="; named values are defined in "let"'),
    (r"\d,\d", "write a decimal point, not a comma"),
)
_NO_UNIT = r"(?<![\w.])([\d.]+) *([A-Za-z]+)\b"
_WORDS = frozenset(("and", "or", "not", "if", "else", "for", "in", "is"))


def mistake(text: str, problem: SyntaxError) -> ExpressionError:
    """Convert an error of Python's parser to an error about the expression ``text``, with help if possible."""
    plain = re.sub(r"'[^']*'|\"[^\"]*\"", lambda match: " " * len(match[0]), text)
    for number, word, start in ((match[1], match[2], match.start(2)) for match in re.finditer(_NO_UNIT, plain)):
        if word not in _WORDS and word not in UNITS and word not in CONSTANTS:
            help = "a unit such as mm, kg, deg or N*m; or * for a product"
            return ExpressionError(f'there is no unit "{word}"', start, help, unit=(number, word))
    for pattern, help in _FOREIGN:
        if found := re.search(pattern, plain):
            sign = printable(found[0] if len(found[0]) < 3 else found[0][:1])
            return ExpressionError(f'"{sign}" has no meaning in an expression', found.start(), help)
    column, help = max(0, (problem.offset or 1) - 1), ""
    if operator := re.search(r"(\*\*|//|[-+*/%<>=]|\b(?:and|or|not|if|else|in))\s*$", plain):
        return ExpressionError(f'a value is missing after "{operator[1]}"', column)
    if "never closed" in str(problem.msg) or "unmatched" in str(problem.msg):
        help = "brackets must come in pairs"
    elif re.search(r"[\w)\]] +[\w(]", plain[max(0, column - 2) :]):
        help = 'write an operator between two values, such as "*"'
    return ExpressionError(f"not an expression: {problem.msg}", column, help)


class Effort:
    """Count evaluation steps: ``done`` of the current expression, ``total`` of all expressions so far."""

    def __init__(self) -> None:
        self.done = 0
        self.total = 0

    def spend(self, *values: Any) -> None:
        """Count one step plus the sizes of the values. Raises ExpressionError if the limit is exceeded."""
        self.done += 1
        for value in values:
            if type(value) not in NUMERIC and isinstance(value, _SIZED):
                self.done += weight(value)
        if self.done > MAX_WORK:
            raise ExpressionError(f"the expression needs more than {MAX_WORK:,} steps")


EFFORT = Effort()


def weight(value: Any) -> int:
    """Count a value and all values nested in it; stop soon after MAX_ITEMS."""
    if not isinstance(value, (list, dict)):
        return len(value) // 8 + 1 if isinstance(value, str) else 1
    total, waiting = 0, [value]
    while waiting and total <= MAX_ITEMS:
        items: Any = waiting.pop()
        items = items.values() if isinstance(items, dict) else items
        total += len(items) + 1
        waiting += [item for item in items if isinstance(item, (list, dict))]
    return total


def check_size(value: Any) -> Any:
    """Return the value unchanged. Raises ExpressionError if it is too large, or not finite."""
    problem = ""
    if isinstance(value, float):
        problem = "" if abs(value) < MAX_MAGNITUDE else "the result is not a finite number"
    elif isinstance(value, int):
        problem = "the number is too large" if abs(value) > MAX_INTEGER else ""
    elif isinstance(value, complex):
        problem = "the result is not a real number"
    elif (len(value) if isinstance(value, str) else weight(value)) > MAX_ITEMS:
        problem = f"the result has more than {MAX_ITEMS:,} {'letters' if isinstance(value, str) else 'items'}"
    if problem:
        raise ExpressionError(problem)
    return value


def check(tree: ast.AST) -> None:
    """Raise ExpressionError if a syntax tree has a node that is not allowed in expressions, such as a lambda."""
    waiting: list[tuple[Any, int]] = [(tree, 0)]
    while waiting:
        node, depth = waiting.pop()
        if depth > MAX_DEPTH:
            raise ExpressionError("the expression is nested too deeply", node.col_offset)
        _check_node(node)
        children: list[ast.AST] = []
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.comprehension) or (isinstance(child, ast.Slice) and node.slice is child):
                children += ast.iter_child_nodes(child)
            else:
                children.append(child)
        waiting += [(child, depth + 1) for child in reversed(children) if isinstance(child, (ast.expr, ast.keyword))]


def _check_node(node: Any) -> None:
    problem, help, column = "", "", getattr(node, "col_offset", 0)
    if type(node) not in _NODES:
        problem = f"this ({type(node).__name__}) is not allowed here"
        help = "allowed: numbers, text, lists, names, + - * / // % **, comparisons, and, or, not, a if c else b"
    elif isinstance(node, ast.Constant) and not isinstance(node.value, Literal):
        if not isinstance(node.value, (bool, int, float, str, type(None))):
            problem = "only numbers and text are values here"
        elif isinstance(node.value, str) and any("\ud800" <= letter <= "\udfff" for letter in node.value):
            problem = "half a letter (a lone surrogate) cannot stand in a file"
        check_size(node.value)
    elif isinstance(node, ast.BinOp) and type(node.op) not in _BINARY:
        problem, help = "this operator is not supported in an expression", _OTHER_OPERATORS.get(type(node.op), "")
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Invert):
        problem = "this operator is not supported in an expression"
    elif isinstance(node, ast.Compare) and not all(type(op) in _COMPARE for op in node.ops):
        problem = "this comparison is not allowed here"
    elif isinstance(node, (ast.ListComp, ast.GeneratorExp)):
        if len(node.generators) > 2:
            problem = "a list can have at most two loops"
        for target in (generator.target for generator in node.generators):
            if not all(isinstance(name, ast.Name) for name in getattr(target, "elts", [target])):
                problem, column = "a loop sets plain names", target.col_offset
    elif isinstance(node, ast.Call):
        if not isinstance(node.func, ast.Name):
            problem, help = "only the name of a function can be called", 'write "upper(text)", not "text.upper()"'
        elif node.keywords or any(isinstance(item, ast.Starred) for item in node.args):
            problem = "functions take their values in order, without names or stars"
    if problem:
        raise ExpressionError(problem, column, help)


def value_of(node: ast.AST, lookup: Lookup) -> Any:
    """Evaluate a syntax tree that passed ``check``. Raises ExpressionError, or any exception of a Python operator."""
    # Operators look up the functions of their operands themselves, because large tables spend most time in calls.
    return _NODES[type(node)](node, lookup)


def _constant(node: ast.Constant, lookup: Lookup) -> Any:
    value: Any = node.value
    if not isinstance(value, Literal):
        return value
    for name in value.factors:
        with suppress(KeyError):
            lookup(name)
            text = value.value.text
            spaced = text.replace("*", " * ").replace("/", " / ").replace("^", "**")
            help = f'rename the value, or write "{spaced}" to multiply by it'
            message = f'"{name}" in "{text}" is a unit, but also the name of a value'
            raise ExpressionError(message, node.col_offset, help)
    return value.value


def _name(node: ast.Name, lookup: Lookup) -> Any:
    try:
        return lookup(node.id)
    except KeyError:
        if node.id in CONSTANTS:
            return CONSTANTS[node.id]
        if node.id in UNITS:
            return Quantity(*UNITS[node.id])
    raise ExpressionError(f'there is no value named "{node.id}"', node.col_offset, unknown=node.id)


def _binary(node: ast.BinOp, lookup: Lookup) -> Any:
    left, right = _NODES[type(node.left)](node.left, lookup), _NODES[type(node.right)](node.right, lookup)
    kind = type(node.op)
    if type(left) not in NUMERIC or type(right) not in NUMERIC:
        return _join(kind, left, right)
    if kind is ast.Pow:
        return _power(left, right)
    first, second = dimension_of(left), dimension_of(right)
    is_product = kind is ast.Mult or kind is ast.Div
    dimension = first if first == second or is_product else common_dimension([left, right])
    if is_product and (first or second):
        dimension = add(first or NUMBER, second or NUMBER, 1 if kind is ast.Mult else -1)
    result = check_size(_BINARY[kind](left, right))
    if dimension is None or kind is ast.FloorDiv or (is_product and dimension == NUMBER):
        return result
    return Quantity(result, dimension)


def _join(kind: type[ast.operator], left: Any, right: Any) -> Any:
    texts = isinstance(left, str) and isinstance(right, str)
    if kind is not ast.Add or not (texts or (isinstance(left, list) and isinstance(right, list))):
        raise KindError(f"cannot combine {kind_of(left)} and {kind_of(right)} with this operator")
    if len(left) + len(right) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
    EFFORT.spend(left, right)
    return left + right if texts else [*left, *right]


def _power(base: Any, exponent: Any) -> Any:
    if abs(exponent) > 64 or (isinstance(base, int) and abs(base) > 10**9):
        raise ExpressionError("the power is too large")
    if dimension_of(exponent) not in (None, NUMBER):
        raise KindError(f"an exponent is a plain number, not {kind_of(exponent)}")
    dimension = dimension_of(base)
    if dimension is None:
        return check_size(base**exponent)
    if int(exponent) != exponent:
        raise ExpressionError("a quantity may only be raised to a whole power")
    return Quantity(float(base) ** exponent, add(NUMBER, dimension, int(exponent)))


def _unary(node: ast.UnaryOp, lookup: Lookup) -> Any:
    value = value_of(node.operand, lookup)
    if isinstance(node.op, ast.Not):
        return not value
    if type(value) not in NUMERIC:
        raise KindError(f"expected a number, got {kind_of(value)}")
    sign = -1 if isinstance(node.op, ast.USub) else 1
    return Quantity(sign * value, value.dimension) if isinstance(value, Quantity) else sign * value


def _boolean(node: ast.BoolOp, lookup: Lookup) -> Any:
    result, is_or = None, type(node.op) is ast.Or
    for part in node.values:
        result = _NODES[type(part)](part, lookup)
        if bool(result) == is_or:
            break
    return result


def _compare(node: ast.Compare, lookup: Lookup) -> bool:
    left_node, left = node.left, _NODES[type(node.left)](node.left, lookup)
    for op, right_node in zip(map(type, node.ops), node.comparators, strict=True):
        if op in _OF_CHOICES:
            _check_choices(left_node, right_node, lookup)
            _check_choices(right_node, left_node, lookup)
        right = _NODES[type(right_node)](right_node, lookup)
        if type(left) is Quantity and type(right) is Quantity:
            common_dimension([left, right])
        EFFORT.spend(left, right)
        try:
            if not _COMPARE[op](left, right):
                return False
        except TypeError:
            raise KindError(f"{kind_of(left)} and {kind_of(right)} cannot be compared") from None
        left_node, left = right_node, right
    return True


def _check_choices(name: ast.expr, other: ast.expr, lookup: Lookup) -> None:
    literals = [item for item in getattr(other, "elts", [other]) if isinstance(item, ast.Constant)]
    if not isinstance(name, ast.Name) or not literals:
        return
    choices: Any = ()
    with suppress(KeyError):
        choices = lookup(name.id + CHOICES)
    for literal in literals if choices else ():
        value: Any = literal.value
        if isinstance(value, (str, int, float)) and value not in choices:
            allowed = f"possible values: {', '.join(map(str, choices))}"
            texts = [choice for choice in choices if isinstance(choice, str)]
            help = Suggestion(value, texts, details=allowed) if isinstance(value, str) else allowed
            raise ExpressionError(f'the argument "{name.id}" cannot be "{value!s}"', literal.col_offset, help)


def _subscript(node: ast.Subscript, lookup: Lookup) -> Any:
    container = value_of(node.value, lookup)
    if not isinstance(node.slice, ast.Slice):
        return _entry(container, value_of(node.slice, lookup))
    if not isinstance(container, (list, str)):
        raise KindError(f"{kind_of(container)} has no items in order")
    EFFORT.spend(container)
    ends = (node.slice.lower, node.slice.upper, node.slice.step)
    return container[slice(*(value_of(end, lookup) if end else None for end in ends))]


def _attribute(node: ast.Attribute, lookup: Lookup) -> Any:
    table = value_of(node.value, lookup)
    if not isinstance(table, Mapping):
        raise KindError(f"{kind_of(table)} has no entries; only a table has entries")
    return _entry(table, node.attr)


def _entry(container: Any, key: Any) -> Any:
    if not isinstance(key, (str, int, float)):
        raise KindError(f"an entry is named by text or a number, not {kind_of(key)}")
    if isinstance(container, Mapping):
        if key in container:
            return container[key]
        entries = f"known: {', '.join(map(str, container))}" if container else "the table is empty"
        texts = [name for name in container if isinstance(name, str)]
        help = Suggestion(str(key), texts, details=entries, places=getattr(container, "key_spans", {}))
        raise ExpressionError(f'the table has no entry "{key}"', help=help)
    if not isinstance(container, (list, str)):
        raise KindError(f"{kind_of(container)} has no entries")
    if not isinstance(key, int):
        raise KindError(f"an item is named by its number, not {kind_of(key)}")
    return container[key]


def _comprehension(node: ast.ListComp | ast.GeneratorExp, lookup: Lookup) -> list[Any]:
    items: list[Any] = []

    def run(level: int, scope: Lookup) -> None:
        if level == len(node.generators):
            items.append(value_of(node.elt, scope))
            return
        generator = node.generators[level]
        names = [name.id for name in getattr(generator.target, "elts", [generator.target])]
        for item in value_of(generator.iter, scope):
            EFFORT.spend()
            inner = _bind(scope, names, item)
            if all(value_of(condition, inner) for condition in generator.ifs):
                run(level + 1, inner)

    run(0, lookup)
    return items


def _bind(lookup: Lookup, names: list[str], item: Any) -> Lookup:
    values = item if len(names) > 1 else [item]
    if not isinstance(values, list) or len(values) != len(names):
        raise KindError(f"cannot give {kind_of(item)} to {len(names)} names")
    bound = dict(zip(names, values, strict=True))

    def inner(name: str) -> Any:
        if name in bound:
            return bound[name]
        if name.removesuffix(CHOICES) in bound:
            raise KeyError(name)
        return lookup(name)

    return inner


def _call(node: ast.Call, lookup: Lookup) -> Any:
    name: str = node.func.id  # type: ignore[attr-defined]
    function = functions().get(name)
    if function is None:
        try:
            function = lookup(f"{name}()")  # ``load``, ``find``, or a function that is defined in "let"
        except KeyError:
            raise ExpressionError(f'there is no function "{name}"', node.col_offset, unknown=f"{name}()") from None
    values = [value_of(item, lookup) for item in node.args]
    EFFORT.spend(*values)
    try:
        result = check_size(function(*values))
    except (TypeError, AttributeError):
        kinds = ", ".join(map(kind_of, values)) or "nothing"
        raise KindError(f"{name}() does not accept {kinds}") from None
    except (ValueError, ArithmeticError, LookupError):
        raise ExpressionError(f"{name}() is not defined for this argument") from None
    if isinstance(result, (list, str)):
        EFFORT.spend(result)
    return result


def _list(node: ast.List | ast.Tuple, lookup: Lookup) -> list[Any]:
    return [value_of(item, lookup) for item in node.elts]


_NODES: dict[type[ast.AST], Callable[[Any, Lookup], Any]] = {ast.Constant: _constant, ast.Name: _name, ast.Call: _call}
_NODES |= {ast.BinOp: _binary, ast.UnaryOp: _unary, ast.BoolOp: _boolean, ast.Compare: _compare}
_NODES |= {ast.Subscript: _subscript, ast.Attribute: _attribute, ast.List: _list, ast.Tuple: _list}
_NODES |= {ast.ListComp: _comprehension, ast.GeneratorExp: _comprehension}
_NODES[ast.IfExp] = lambda node, lookup: value_of(node.body if value_of(node.test, lookup) else node.orelse, lookup)

"""The functions and constants of expressions, and the errors that functions raise.

Quantities that are added or compared must have the same dimension; a bare number is compatible with any dimension.
"""

import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import count
from numbers import Integral
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.load import MAX_NODES
from rosorin_compile.source.plugins import Plugin, divert_stdout, load
from rosorin_compile.source.tree import Text
from rosorin_compile.source.units import ANGLE, NUMBER, UNITS, Dimension, Quantity, describe, dimension_of
from rosorin_compile.source.yaml_mistakes import MAX_DEPTH

if TYPE_CHECKING:
    from rosorin_compile.source.diagnostics import Help

MAX_ITEMS = 100_000
_LARGEST = 10**18  # larger YAML integers are read as floats (see load)
_KINDS: dict[Any, str] = {type(None): "an empty value", bool: "true or false", (int, float): "a number"}
_KINDS |= {str: "text", Mapping: "a table", object: "a list"}


class ExpressionError(Exception):
    """Raised if an expression cannot be evaluated; ``column`` counts from 0, or is -1 if it is not yet determined.

    If the cause is an undefined name, ``unknown`` is the name; if it is an unknown unit, ``unit`` is (number, unit).
    """

    def __init__(
        self, message: str, column: int = -1, help: "Help" = "", unknown: str = "", unit: tuple[str, str] | None = None
    ) -> None:
        super().__init__(message)
        self.message, self.column, self.help, self.unknown, self.unit = message, column, help, unknown, unit


class KindError(ExpressionError):
    """Raised if operands have incompatible kinds, such as a length and a mass."""


class Function(NamedTuple):
    """A function that expressions can call: its name, its help text, and the Python function.

    ``apply`` takes and returns numbers, Quantities, strings, lists, tables (dicts), booleans and None, and raises
    ExpressionError. ``apply`` is None if the function needs the description, like ``load`` and ``find``.
    """

    name: str
    help: str
    apply: Callable[..., Any] | None

    def __call__(self, *values: Any) -> Any:
        if self.apply is None:
            raise ExpressionError(f"{self.name}() has a value in a description only")
        return self.apply(*values)


def function(name: str, help: str) -> Callable[[Callable[..., Any]], Function]:
    """Return a decorator that lets expressions call a Python function by ``name``; ``help`` is its help text."""
    return lambda apply: Function(name, help, apply)


def kind_of(value: Any) -> str:
    """Return the kind of a value for messages, such as "a list" or "a length (m)"."""
    if isinstance(value, Quantity):
        return describe(value.dimension)
    return next(kind for types, kind in _KINDS.items() if isinstance(value, types))


def common_dimension(values: Iterable[Any]) -> Dimension | None:
    """Return the common dimension of the values, or None if all are bare numbers. Raises KindError if they differ."""
    common: Dimension | None = None
    for value in values:
        if not isinstance(value, (int, float)):
            raise KindError(f"expected a number, got {kind_of(value)}")
        dimension = dimension_of(value)
        if common is not None and dimension not in (None, common):
            help = 'values that are added, compared or alternatives of "if" need the same dimension'
            raise KindError(f"cannot combine {describe(common)} with {describe(dimension or NUMBER)}", help=help)
        common = common or dimension
    return common


def _of(dimension: Dimension, what: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def apply(*values: Any) -> Any:
        for value in values:
            if dimension_of(value) not in (None, dimension, NUMBER):
                raise KindError(f"expected {what}, got {kind_of(value)}")
        return function(*values)

    return apply


_of_angle = partial(_of, ANGLE, describe(ANGLE))
_plain = partial(_of, NUMBER, "a plain number")


def _to_angle(function: Callable[..., float]) -> Callable[..., Quantity]:
    return lambda *values: Quantity(function(*map(float, values)), ANGLE)


def _with_dimension(value: Any, dimension: Dimension | None) -> Any:
    return Quantity(value, dimension) if dimension else value


def _keeping(function: Callable[..., Any]) -> Callable[..., Any]:
    def apply(*values: Any) -> Any:
        numbers = values[0] if len(values) == 1 and isinstance(values[0], list) else values
        return _with_dimension(function(*numbers), common_dimension(numbers))

    return apply


def _atan2(y: Any, x: Any) -> Quantity:
    common_dimension([y, x])
    return Quantity(math.atan2(y, x), ANGLE)


def _sqrt(value: Any) -> Any:
    dimension = dimension_of(value)
    if dimension is None:
        return math.sqrt(value)
    if any(n % 2 for n in dimension):
        raise KindError(f"there is no square root of {describe(dimension)}")
    a, b, c, d = (n // 2 for n in dimension)
    return Quantity(math.sqrt(value), (a, b, c, d))


def _sum(values: Any) -> Any:
    total = math.fsum(values) if any(isinstance(value, float) for value in values) else sum(values)
    return _with_dimension(total, common_dimension(values))


def _round(value: Any, digits: int = 0) -> Any:
    return _with_dimension(round(float(value), digits) if digits else round(value), dimension_of(value))


def _rows(rows: Iterable[Iterable[Any]]) -> list[list[Any]]:
    return [list(row) for row in rows]


def _range(*bounds: Any) -> list[int]:
    if any(isinstance(bound, float) and not bound.is_integer() for bound in bounds):
        raise ExpressionError("a range counts in whole numbers")
    numbers = range(*map(int, bounds))
    if len(numbers) > MAX_ITEMS:
        raise ExpressionError(f"the range has more than {MAX_ITEMS:,} numbers")
    return list(numbers)


def _pad(value: Any, width: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or int(value) != value:
        raise ExpressionError(f"pad takes a whole number, not {kind_of(value)}")
    return str(int(value)).zfill(min(int(width), 20))


def _error(text: Any) -> Any:
    raise ExpressionError(_text(text))


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(float(value)) if not float(value).is_integer() else str(int(value))
    if isinstance(value, (str, int)):
        return str(value)
    raise KindError(f"{kind_of(value)} cannot be inserted into text", help="let the expression be the entire value")


def _numbers(text: Any) -> list[Any]:
    if not isinstance(text, str):
        return list(text)
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        raise ExpressionError(f'"{text}" is not a list of numbers', help="write numbers, as in '0 0 1'") from None


def _replace(text: str, old: str, new: str) -> str:
    if not old:
        raise ExpressionError("replace needs a text to look for")
    if text.count(old) * len(new) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    return text.replace(old, new)


def _join(separator: str, texts: list[Any]) -> str:
    words = [_text(text) for text in texts]
    if len(words) * len(separator) + sum(map(len, words)) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    return separator.join(words)


def _of_math(wrap: Callable[..., Callable[..., Any]], names: str) -> dict[str, Callable[..., Any]]:
    return {name: wrap(getattr(math, name)) for name in names.split()}


# Help texts with the functions that they explain; None marks a function that needs the description.
_ROWS: tuple[tuple[str, Mapping[str, Callable[..., Any] | None]], ...] = (
    ("of an angle; a bare number is in radians", _of_math(_of_angle, "sin cos tan")),
    ("the angle; so `atan` of a quotient", _of_math(_to_angle, "asin acos atan")),
    ("`atan2(y, x)`: the angle of a direction, -180 to 180 degrees", {"atan2": _atan2}),
    ("an angle as a plain number of degrees", {"degrees": _of_angle(math.degrees)}),
    ("a plain number of degrees as an angle", {"radians": lambda number: Quantity(math.radians(number), ANGLE)}),
    ("square root; of an area it is a length", {"sqrt": _sqrt}),
    ("size without the sign", {"abs": _keeping(abs)}),
    ("of its arguments, or of a list", {"min": _keeping(min), "max": _keeping(max)}),
    ("`hypot(x, y, ...)`: length of a vector", {"hypot": _keeping(math.hypot)}),
    ("`round(x)`, `round(x, 2)`: nearest whole number, or to two decimals", {"round": _round}),
    ("whole number below, above, towards zero", _of_math(_plain, "floor ceil trunc")),
    ("power of e, logarithms; of plain numbers", _of_math(_plain, "exp log log2 log10")),
    ("of plain numbers", _of_math(_plain, "sinh cosh tanh")),
    ("`fmod(x, y)`: the rest of a division, with the sign of x", _of_math(_plain, "fmod")),
    ("`copysign(x, y)`: x with the sign of y", _of_math(_plain, "copysign")),
    ("greatest common divisor of whole numbers", _of_math(_plain, "gcd")),
    ("`isclose(x, y)`: whether two numbers are the same to 9 digits", _of_math(_plain, "isclose")),
    ("`pow(x, y)`: x to the power of y, of plain numbers; `x**y` also takes quantities", _of_math(_plain, "pow")),
    ("-1, 0 or 1", {"sign": lambda value: (value > 0) - (value < 0)}),
    ("a number or a text as a whole number, or as a number", {"int": _plain(int), "float": float}),
    ("whether a value is not empty and not 0", {"bool": bool}),
    ("number of items of a list, or of letters of a text", {"len": len}),
    ("of a list of numbers", {"sum": _sum}),
    ("`range(4)`: 0, 1, 2, 3; `range(first, end, step)`", {"range": _range}),
    ("a list in order, or from its end", {"sorted": sorted, "reversed": lambda values: list(values)[::-1]}),
    ("the letters of a text, as a list", {"list": list}),
    ("`zip(a, b)`: rows of one item of each list", {"zip": lambda *lists: _rows(zip(*lists, strict=True))}),
    ("`enumerate(list)`: rows of a number, from 0, and an item", {"enumerate": lambda *of: _rows(enumerate(*of))}),
    ("of a table, as a list", {"keys": lambda table: list(table.keys()), "values": lambda table: list(table.values())}),
    ("rows of a key and a value of a table", {"items": lambda table: _rows(table.items())}),
    ("`get(table, key, default)`: an entry of a table, or the default", {"get": dict.get}),
    ("whether all, any of a list are true", {"all": all, "any": any}),
    ("a value as text, as it would stand in one", {"str": _text}),
    ("`pad(7, 2)`: a whole number as text of at least two digits, 07", {"pad": _pad}),
    ("`error('text')`: refuses the description with a message of its author", {"error": _error}),
    ("a text in capitals, in small letters", {"upper": str.upper, "lower": str.lower}),
    ("a text without blanks at its ends", {"strip": str.strip}),
    ("`split(text, ',')`: a text as a list of texts; without a separator at blanks", {"split": str.split}),
    ("`numbers('0 0 1')`: the numbers of a text, as a list; a list stays what it is", {"numbers": _numbers}),
    ("`join(', ', list)`: a list as one text", {"join": _join}),
    ("`replace(text, old, new)`", {"replace": _replace}),
    ("`startswith(text, other)`: whether a text begins so", {"startswith": str.startswith}),
    ("`endswith(text, other)`: whether a text ends so", {"endswith": str.endswith}),
    ("`load('file.yaml')`: the value of a YAML file next to the description, or in a package", {"load": None}),
    ("`find('PACKAGE')`: the folder of a ROS package; `find('PACKAGE', other)`: or another value", {"find": None}),
)
BUILT_IN = tuple(Function(name, help, apply) for help, row in _ROWS for name, apply in row.items())
# Built-in functions by name, without ``load`` and ``find``, which need the description.
FUNCTIONS: dict[str, Callable[..., Any]] = {one.name: one.apply for one in BUILT_IN if one.apply is not None}
OF_DESCRIPTIONS = frozenset(one.name for one in BUILT_IN if one.apply is None)

CONSTANTS: dict[str, Any] = {"pi": math.pi, "tau": math.tau, "e": math.e}
CONSTANTS |= {"true": True, "false": False, "none": None}


@cache
def plugin_functions() -> tuple[Sequence[tuple[Plugin, Function]], Sequence[Diagnostic]]:
    """Return the functions of plug-ins (entry points ``rosorin_compile.functions``), and errors about plug-ins."""
    taken = {*FUNCTIONS, *OF_DESCRIPTIONS, *CONSTANTS, *UNITS}
    return load("functions", Function, _names, taken.__contains__)


def _names(one: Function) -> list[str]:
    if not one.name.isidentifier():
        raise ValueError(f'"{one.name}" cannot be the name of a function')
    if not isinstance(one.help, str):
        raise TypeError(f"what the reference says of {one.name} is a text, not {str(one.help)[:60]!r}")
    if not callable(one.apply):
        raise TypeError(f"{one.name} cannot be called")
    return [one.name]


@cache
def functions() -> Mapping[str, Callable[..., Any]]:
    """Return built-in functions and functions of plug-ins by name, without ``load`` and ``find``."""
    more = plugin_functions()[0]
    return {**FUNCTIONS, **{one.name: _guarded(plugin, one) for plugin, one in more}} if more else FUNCTIONS


def _guarded(plugin: Plugin, one: Function) -> Callable[..., Any]:
    who = f"{one.name}() of {plugin.distribution} {plugin.version}"

    def apply(*values: Any) -> Any:
        try:
            with divert_stdout():
                value = one(*values)
        except (ExpressionError, TypeError, ValueError, ArithmeticError, LookupError):
            raise  # handled by evaluate() as for built-in functions
        except (Exception, SystemExit) as problem:
            raise ExpressionError(f"{who} fails: {type(problem).__name__}: {problem}") from None
        try:
            return plain_value(value)
        except ExpressionError as problem:
            raise ExpressionError(f"the result of {who} {problem}") from None

    return apply


def plain_value(value: object, depth: int = 0, counter: Iterator[int] | None = None) -> Any:
    """Convert a Python object to a value for expressions; an array with ``tolist`` becomes a number or a list.

    ``depth`` and ``counter`` limit nesting and size in recursive calls. Raises ExpressionError for other objects.
    """
    counter = counter or count()
    if depth > MAX_DEPTH or next(counter) >= MAX_NODES:
        raise ExpressionError("is too deep or too large a value")
    if value is None or isinstance(value, (bool, Quantity, Text)):
        return value
    if isinstance(value, (str, os.PathLike)):
        return str.__str__(value) if isinstance(value, str) else Text(os.fsdecode(value))
    if isinstance(value, Integral) and abs(int(value)) < _LARGEST:
        return int(value)
    if isinstance(value, Mapping):
        for key in (key for key in value if not isinstance(key, str)):
            raise ExpressionError(f"is a table with a key that is {type_of(key)}, not text")
        return {str.__str__(key): plain_value(item, depth + 1, counter) for key, item in value.items()}
    if isinstance(value, (list, tuple, range)):
        return [plain_value(item, depth + 1, counter) for item in value]
    if callable(tolist := getattr(value, "tolist", None)):
        return plain_value(tolist(), depth + 1, counter)
    if not hasattr(value, "__float__"):
        raise ExpressionError(f"is {type_of(value)}")
    try:
        return float(value)
    except (OverflowError, ValueError):
        raise ExpressionError("is too large a number") from None


def type_of(value: object) -> str:
    """Format the Python type of an object for messages, such as "of the type set" or "None"."""
    return "None" if value is None else f"of the type {type(value).__name__}"

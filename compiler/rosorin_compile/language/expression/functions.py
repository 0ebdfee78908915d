"""The functions and constants of expressions, and how quantities go through them.

A bare number has no dimension and goes with any; two quantities must be of one dimension where they are added,
compared or chosen from. At the end of this file each function stands with what the reference says of it; those of
plug-ins are entry points of ``rosorin_compile.functions``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.plugins import Plugin, aside, load
from rosorin_compile.source.units import ANGLE, NUMBER, UNITS, Dimension, Quantity, describe, dimension_of

if TYPE_CHECKING:
    from rosorin_compile.source.diagnostics import Span

MAX_ITEMS = 100_000


class ExpressionError(Exception):
    """An expression that has no value; ``column`` counts from 0 within the expression, -1 where it is not known.

    ``unknown`` is a name that is not defined, ``near`` the place of what may be meant instead; ``unit`` is a number and
    the unknown unit after it.
    """

    def __init__(
        self, message: str, column: int = -1, help: str = "", unknown: str = "", near: Span | None = None
    ) -> None:
        super().__init__(message)
        self.message = message
        self.column = column
        self.help = help
        self.unknown = unknown
        self.near = near
        self.unit: tuple[str, str] | None = None


class KindError(ExpressionError):
    """Values of kinds that do not go together, whatever the values."""


class Function(NamedTuple):
    """A function of the language: its name, what the reference says of it, and what gives its value.

    ``apply`` takes and gives what expressions know: numbers, Quantities, texts, lists, tables (dicts), true, false and
    none. It raises ExpressionError for what has no value. None stands for a function that needs the description.
    """

    name: str
    help: str
    apply: Callable[..., Any] | None

    def __call__(self, *values: Any) -> Any:
        """Return the value of the function."""
        if self.apply is None:
            raise ExpressionError(f"{self.name}() has a value in a description only")
        return self.apply(*values)


def function(name: str, help: str) -> Callable[[Callable[..., Any]], Function]:
    """Make a function of the language of a function of Python.

    ``help`` is what the reference says of it, one line of Markdown. A plug-in names what this gives as an entry point
    of ``rosorin_compile.functions``.
    """
    return lambda apply: Function(name, help, apply)


def kind_of(value: Any) -> str:
    """Return what a value is, in words."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, Quantity):
        return describe(value.dimension)
    if isinstance(value, (int, float)):
        return "a number"
    if isinstance(value, str):
        return "text"
    return "a table" if isinstance(value, Mapping) else "a list"


def common_dimension(values: list[Any]) -> Dimension | None:
    """Return the dimension that all values share; bare numbers go with any. Raises ExpressionError otherwise."""
    common: Dimension | None = None
    for value in values:
        if not isinstance(value, (int, float)):
            raise KindError(f"expected a number, got {kind_of(value)}")
        dimension = dimension_of(value)
        if common is not None and dimension not in (None, common):
            help = "what is added, compared or chosen from is of one kind; a product or a quotient may mix"
            message = f"{describe(common)} and {describe(dimension or NUMBER)} do not go together"
            raise KindError(message, help=help)
        common = common or dimension
    return common


def _of_angle(function: Callable[[float], float]) -> Callable[[Any], float]:
    """Make a function of an angle: a bare number is in radians."""

    def apply(angle: Any) -> float:
        dimension = dimension_of(angle)
        if dimension not in (None, ANGLE, NUMBER):
            raise KindError(f"expected {describe(ANGLE)}, got {kind_of(angle)}")
        return function(float(angle))

    return apply


def _to_angle(function: Callable[..., float]) -> Callable[..., Quantity]:
    return lambda *values: Quantity(function(*map(float, values)), ANGLE)


def _atan2(y: Any, x: Any) -> Quantity:
    common_dimension([y, x])
    return Quantity(math.atan2(y, x), ANGLE)


def _keeping(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of numbers, or of one list of them, keep their common dimension."""

    def apply(*values: Any) -> Any:
        numbers = list(values[0]) if len(values) == 1 and isinstance(values[0], list) else list(values)
        dimension = common_dimension(numbers)
        result = function(*numbers)
        return Quantity(result, dimension) if dimension else result

    return apply


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of bare numbers refuse quantities, whose unit it would lose."""

    def apply(*values: Any) -> Any:
        for value in values:
            if isinstance(value, Quantity) and value.dimension != NUMBER:
                raise KindError(f"expected a plain number, got {kind_of(value)}")
        return function(*values)

    return apply


def _sqrt(value: Any) -> Any:
    dimension = dimension_of(value)
    if dimension is None:
        return math.sqrt(value)
    if any(n % 2 for n in dimension):
        raise KindError(f"there is no square root of {describe(dimension)}")
    a, b, c, d = (n // 2 for n in dimension)
    return Quantity(math.sqrt(value), (a, b, c, d))


def _sum(values: Any) -> Any:
    dimension = common_dimension(list(values))
    total = math.fsum(values) if any(isinstance(v, float) for v in values) else sum(values)
    return Quantity(total, dimension) if dimension else total


def _range(*bounds: Any) -> list[int]:
    if any(isinstance(bound, float) and not bound.is_integer() for bound in bounds):
        raise ExpressionError("a range counts in whole numbers")
    numbers = range(*(int(bound) for bound in bounds))
    if len(numbers) > MAX_ITEMS:
        raise ExpressionError(f"a range of more than {MAX_ITEMS:,} numbers")
    return list(numbers)


def _pad(value: Any, width: Any) -> str:
    """Return a whole number as text of at least ``width`` digits: pad(7, 2) is 07."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or int(value) != value:
        raise ExpressionError(f"pad takes a whole number, not {kind_of(value)}")
    return str(int(value)).zfill(min(int(width), 20))


def _error(text: Any) -> Any:
    """Refuse a description with a message of its author."""
    raise ExpressionError(_text(text))


def _text(value: Any) -> str:
    """Return a value as text, whole numbers without a point."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(float(value)) if not float(value).is_integer() else str(int(value))
    if isinstance(value, (str, int)):
        return str(value)
    raise KindError(f"{kind_of(value)} cannot stand inside text", help="use it as the whole value")


def _numbers(text: Any) -> list[Any]:
    if not isinstance(text, str):
        return list(text)
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        raise ExpressionError(f'"{text}" is not numbers with blanks between', help="write it as '0 0 1'") from None


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


def _round(value: Any, digits: int = 0) -> Any:
    dimension = dimension_of(value)
    rounded = round(float(value), digits) if digits else round(value)
    return Quantity(rounded, dimension) if dimension else rounded


def _each(help: str, **functions: Callable[..., Any] | None) -> list[Function]:
    """Return functions of which the reference says the same, in one row."""
    return [Function(name, help, apply) for name, apply in functions.items()]


# The functions, in the order of the reference; a new one is one more row here.
BUILT_IN: tuple[Function, ...] = (
    *_each(
        "of an angle; a bare number is in radians",
        sin=_of_angle(math.sin),
        cos=_of_angle(math.cos),
        tan=_of_angle(math.tan),
    ),
    *_each(
        "the angle; so `atan` of a quotient",
        asin=_to_angle(math.asin),
        acos=_to_angle(math.acos),
        atan=_to_angle(math.atan),
    ),
    Function("atan2", "`atan2(y, x)`: the angle of a direction, -180 to 180 degrees", _atan2),
    *_each(
        "an angle as a plain number of degrees; so the inverse, `radians`",
        degrees=lambda angle: _of_angle(math.degrees)(angle),
        radians=lambda number: Quantity(math.radians(number), ANGLE),
    ),
    Function("sqrt", "square root; of an area it is a length", _sqrt),
    Function("abs", "size without the sign", _keeping(abs)),
    *_each("of its arguments, or of a list", min=_keeping(min), max=_keeping(max)),
    Function("hypot", "`hypot(x, y, ...)`: length of a vector", _keeping(math.hypot)),
    Function("round", "`round(x)`, `round(x, 2)`: nearest whole number, or to two decimals", _round),
    *_each(
        "whole number below, above, towards zero",
        floor=_plain(math.floor),
        ceil=_plain(math.ceil),
        trunc=_plain(math.trunc),
    ),
    *_each(
        "power of e, logarithms; of plain numbers",
        exp=_plain(math.exp),
        log=_plain(math.log),
        log2=_plain(math.log2),
        log10=_plain(math.log10),
    ),
    *_each("of plain numbers", sinh=_plain(math.sinh), cosh=_plain(math.cosh), tanh=_plain(math.tanh)),
    Function("fmod", "`fmod(x, y)`: the rest of a division, with the sign of x", _plain(math.fmod)),
    Function("copysign", "`copysign(x, y)`: x with the sign of y", _plain(math.copysign)),
    Function("gcd", "greatest common divisor of whole numbers", _plain(math.gcd)),
    Function("isclose", "`isclose(x, y)`: whether two numbers are the same to 9 digits", _plain(math.isclose)),
    Function(
        "pow",
        "`pow(x, y)`: x to the power of y, of plain numbers; `x**y` also takes quantities",
        _plain(lambda base, exponent: float(base) ** float(exponent)),
    ),
    Function("sign", "-1, 0 or 1", lambda value: (value > 0) - (value < 0)),
    *_each(
        "a number or a text as a whole number, as a number; whether it is not empty and not 0",
        int=_plain(int),
        float=float,
        bool=bool,
    ),
    Function("len", "number of items of a list, or of letters of a text", len),
    Function("sum", "of a list of numbers", _sum),
    Function("range", "`range(4)`: 0, 1, 2, 3; `range(first, end, step)`", _range),
    *_each(
        "a list in order, or from its end; `list` of a text: its letters",
        sorted=lambda values: sorted(values),
        reversed=lambda values: list(values)[::-1],
        list=lambda values: list(values),
    ),
    Function(
        "zip",
        "`zip(a, b)`: rows of one item of each list",
        lambda *lists: [list(row) for row in zip(*lists, strict=True)],
    ),
    Function(
        "enumerate",
        "`enumerate(list)`: rows of a number, from 0, and an item",
        lambda values, start=0: [[index, value] for index, value in enumerate(values, start)],
    ),
    *_each(
        "of a table, as a list; `items`: rows of a key and a value",
        keys=lambda table: list(table.keys()),
        values=lambda table: list(table.values()),
        items=lambda table: [[key, value] for key, value in table.items()],
    ),
    Function(
        "get",
        "`get(table, key, default)`: an entry of a table, or the default",
        lambda table, key, default=None: table.get(key, default),
    ),
    *_each("whether all, any of a list are true", all=lambda values: all(values), any=lambda values: any(values)),
    Function("str", "a value as text, as it would stand in one", _text),
    Function("pad", "`pad(7, 2)`: a whole number as text of at least two digits, 07", _pad),
    Function("error", "`error('text')`: refuses the description with a message of its author", _error),
    *_each(
        "a text in capitals, in small letters, without blanks at its ends",
        upper=lambda text: text.upper(),
        lower=lambda text: text.lower(),
        strip=lambda text: text.strip(),
    ),
    Function(
        "split",
        "`split(text, ',')`: a text as a list of texts; without a separator at blanks",
        lambda text, separator=None: text.split(separator),
    ),
    Function("numbers", "`numbers('0 0 1')`: the numbers of a text, as a list; a list stays what it is", _numbers),
    Function("join", "`join(', ', list)`: a list as one text", _join),
    Function("replace", "`replace(text, old, new)`", _replace),
    *_each(
        "`startswith(text, other)`: whether a text begins, ends so",
        startswith=lambda text, start: text.startswith(start),
        endswith=lambda text, end: text.endswith(end),
    ),
    Function(
        "load", "`load('file.yaml')`: the value of a YAML file in the folder of the description, or of a package", None
    ),
    Function(
        "find",
        "`find('PACKAGE')`: the folder of a ROS package on this machine; `find('PACKAGE', other)`: the other value "
        "where there is no such package",
        None,
    ),
)

# What the functions do that need nothing but their values, by name.
FUNCTIONS: dict[str, Callable[..., Any]] = {one.name: one.apply for one in BUILT_IN if one.apply is not None}
OF_DESCRIPTIONS = frozenset(one.name for one in BUILT_IN if one.apply is None)

CONSTANTS: dict[str, Any] = {"pi": math.pi, "tau": math.tau, "e": math.e}
CONSTANTS |= {"true": True, "false": False, "none": None}


class Plugged(NamedTuple):
    """The functions that plug-ins add, and what is wrong with plug-ins of this kind."""

    functions: tuple[tuple[Plugin, Function], ...]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged() -> Plugged:
    """Return the functions of plug-ins: entry points of ``rosorin_compile.functions``."""
    taken = {one.name for one in BUILT_IN} | CONSTANTS.keys() | UNITS.keys()
    return Plugged(*load("functions", Function, _names, taken.__contains__))


def _names(one: Function) -> list[str]:
    """Return the name of a plug-in's function. Raises ValueError or TypeError if it is none."""
    if not one.name.isidentifier():
        raise ValueError(f'"{one.name}" cannot be the name of a function')
    if not isinstance(one.help, str):
        raise TypeError(f"what the reference says of {one.name} is a text, not {str(one.help)[:60]!r}")
    if not callable(one.apply):
        raise TypeError(f"{one.name} cannot be called")
    return [one.name]


@cache
def functions() -> Mapping[str, Callable[..., Any]]:
    """Return what the functions of the language do, by name, those of plug-ins among them."""
    more = plugged().functions
    return {**FUNCTIONS, **{one.name: _guarded(plugin, one) for plugin, one in more}} if more else FUNCTIONS


class Names(NamedTuple):
    """The names that expressions know: of functions, of those that need the description, of constants and of units."""

    functions: frozenset[str]
    of_descriptions: frozenset[str]
    constants: frozenset[str]
    units: frozenset[str]


@cache
def expression_names() -> Names:
    """Return the names that expressions know, those of plug-ins among them."""
    return Names(frozenset(functions()), OF_DESCRIPTIONS, frozenset(CONSTANTS), frozenset(UNITS))


def _guarded(plugin: Plugin, one: Function) -> Callable[..., Any]:
    """Return what a plug-in's function does; whatever goes wrong within it is an ExpressionError."""
    who = f"{one.name}() of {plugin.distribution} {plugin.version}"

    def apply(*values: Any) -> Any:
        try:
            with aside(plugin):
                value = one(*values)
        except (ExpressionError, TypeError, ValueError, ArithmeticError, LookupError):
            raise  # as functions that are built in
        except (Exception, SystemExit) as problem:
            raise ExpressionError(f"{who} fails: {type(problem).__name__}: {problem}") from None
        return _plain_value(value, who)

    return apply


def _plain_value(value: Any, who: str) -> Any:
    """Return a value that is of the kinds that expressions know. Raises ExpressionError for another."""
    if isinstance(value, (list, tuple)):
        return [_plain_value(item, who) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _plain_value(item, who) for key, item in value.items()}
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ExpressionError(f"{who} gives what is no value: {type(value).__name__}")

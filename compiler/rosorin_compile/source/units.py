"""Quantities: numbers with a unit, converted to SI units when they are parsed.

A dimension is a tuple of the exponents of (metre, kilogram, second, radian). A bare number has no unit, and is in SI
units. Values: SI brochure (BIPM, 9th edition); inch and pound: international yard and pound agreement, 1959.
"""

import math
import re
from functools import lru_cache

Dimension = tuple[int, int, int, int]

NUMBER: Dimension = (0, 0, 0, 0)
LENGTH, MASS, TIME, ANGLE = (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
_TURN = 2 * math.pi

# One row per dimension: name and SI unit, exponents, and the value of each unit in SI units.
_TABLE: tuple[tuple[str, Dimension, dict[str, float]], ...] = (
    ("length (m)", LENGTH, {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "inch": 0.0254, "ft": 0.3048}),
    ("mass (kg)", MASS, {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237}),
    ("time (s)", TIME, {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}),
    ("angle (rad)", ANGLE, {"rad": 1.0, "mrad": 1e-3, "deg": _TURN / 360, "arcmin": _TURN / 21600, "rev": _TURN}),
    ("force (N)", (1, 1, -2, 0), {"N": 1.0, "kN": 1e3, "kgf": 9.80665}),
    ("torque (N*m)", (2, 1, -2, 0), {"Nm": 1.0, "J": 1.0}),
    ("moment of inertia (kg*m^2)", (2, 1, 0, 0), {}),
    ("speed (m/s)", (1, 0, -1, 0), {}),
    ("angular speed (rad/s)", (0, 0, -1, 1), {"rpm": _TURN / 60}),
    ("frequency (Hz)", (0, 0, -1, 0), {"Hz": 1.0, "kHz": 1e3}),
    ("density (kg/m^3)", (-3, 1, 0, 0), {}),
    ("area (m^2)", (2, 0, 0, 0), {}),
    ("volume (m^3)", (3, 0, 0, 0), {}),
    ("length per angle (m/rad)", (1, 0, 0, -1), {}),
    ("angle per length (rad/m)", (-1, 0, 0, 1), {}),
    ("", (2, 1, -3, 0), {"W": 1.0}),
    ("", (-1, 1, -2, 0), {"Pa": 1.0}),
)
UNITS = {unit: (value, dimension) for _, dimension, units in _TABLE for unit, value in units.items()}
_NAMES = {dimension: f"a{'n' if words[0] == 'a' else ''} {words}" for words, dimension, _ in _TABLE if words}
_NAMES[NUMBER] = "a plain number"
_SI_UNITS = {dimension: words[words.index("(") + 1 : -1] for words, dimension, _ in _TABLE if words}
# Names of dimensions, such as "length", which are allowed as "type" of a parameter.
_WORDS = (words.partition(" (")[0].removeprefix("moment of ").replace(" ", "_") for words, _, _ in _TABLE[:11])
DIMENSIONS: dict[str, Dimension] = {word: row[1] for word, row in zip(_WORDS, _TABLE, strict=False)}

MAX_LENGTH = 100  # maximum number of characters of a quantity
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BARE = re.compile(rf"{_NUMBER}\Z")
_QUANTITY = re.compile(rf"({_NUMBER})\s*([A-Za-z][A-Za-z0-9^*/-]*)\Z")
_FACTOR = re.compile(r"([*/]?)([A-Za-z]+)(?:\^(-?\d))?")


class Quantity(float):
    """A float in SI units with its dimension; ``text`` is the source text, such as "12.5 mm"."""

    __slots__ = ("dimension", "text")
    dimension: Dimension
    text: str

    def __new__(cls, value: float, dimension: Dimension, text: str = "") -> "Quantity":
        made = super().__new__(cls, value)
        made.dimension, made.text = dimension, text
        return made

    @staticmethod
    @lru_cache(maxsize=1_000)
    def parse(text: str) -> "Quantity | None":
        """Parse text such as "12.5 mm". Return None if it is not a number with a known unit."""
        match = _QUANTITY.match(text) if len(text) <= MAX_LENGTH else None
        unit = parse_unit(match[2]) if match else None
        if match is None or unit is None:
            return None
        factor, exponent = unit[0], round(math.log10(unit[0]))
        mantissa, _, power = match[1].lower().partition("e")
        if factor == float(f"1e{exponent}"):  # avoid a rounding error for powers of ten: 46.62 mm is exactly 0.04662
            return Quantity(float(f"{mantissa}e{int(power or 0) + exponent}"), unit[1], text)
        return Quantity(float(match[1]) * factor, unit[1], text)

    @property
    def unit(self) -> str:
        """The SI unit of the quantity, or an empty string for a plain number."""
        parts = [f"{u}^{n}" if n != 1 else u for u, n in zip(("m", "kg", "s", "rad"), self.dimension, strict=True) if n]
        return _SI_UNITS.get(self.dimension) or "*".join(parts)

    def __getnewargs__(self) -> tuple[float, Dimension, str]:  # type: ignore[override]
        return float(self), self.dimension, self.text


def dimension_of(value: float) -> Dimension | None:
    """Return the dimension of a quantity, or None for a plain number."""
    return value.dimension if isinstance(value, Quantity) else None


def in_si(value: float, dimension: Dimension) -> Quantity:
    """Convert a number in SI units to a ``Quantity`` with a dimension."""
    try:
        number = float(value)
    except OverflowError:  # an int that is too large for a float
        number = math.copysign(math.inf, value > 0 or -1)
    return Quantity(number, dimension, repr(number).removesuffix(".0"))


def has_unit(value: object) -> bool:
    """Return True for a quantity that was parsed with a unit, False for a number or a result of ``in_si``."""
    return isinstance(value, Quantity) and _BARE.match(value.text) is None


def describe(dimension: Dimension) -> str:
    """Describe a dimension in words, such as "a length (m)"."""
    return _NAMES.get(dimension) or f"a quantity in {Quantity(0.0, dimension).unit}"


@lru_cache(maxsize=1_000)
def parse_unit(text: str) -> tuple[float, Dimension] | None:
    """Return (value in SI units, dimension) of a unit such as ``mm``, ``N*m`` or ``kg*m^2``, or None if unknown."""
    value, dimension, end = 1.0, NUMBER, 0
    for match in _FACTOR.finditer(text):
        operator, name, power = match.groups()
        if match.start() != end or name not in UNITS or (end == 0) == bool(operator):
            return None
        exponent = int(power or 1) * (-1 if operator == "/" else 1)
        value *= UNITS[name][0] ** exponent
        dimension = add(dimension, UNITS[name][1], exponent)
        end = match.end()
    return (value, dimension) if end == len(text) else None


@lru_cache(maxsize=1_000)
def add(first: Dimension, second: Dimension, times: int = 1) -> Dimension:
    """Return the dimension of the product ``first * second**times``."""
    a, b, c, d = (x + times * y for x, y in zip(first, second, strict=True))
    return (a, b, c, d)


def unknown_unit(text: str) -> str | None:
    """Return the unit in a text such as "5 foo" if it is unknown, or None for any other text."""
    match = _QUANTITY.match(text) if len(text) <= MAX_LENGTH else None
    return match[2] if match and parse_unit(match[2]) is None else None

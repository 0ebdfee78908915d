"""Quantities: numbers with a unit, converted to SI as soon as they are read.

Dimensions are exponents of (metre, kilogram, second, radian). SI counts the radian as 1, but a length in the place of
an angle is a mistake worth reporting. A bare number has no dimension: it is in SI units.
Unit values: the SI brochure (BIPM, 9th edition); inch and pound: international yard and pound agreement, 1959.
"""

from __future__ import annotations

import math
import re
from functools import lru_cache

Dimension = tuple[int, int, int, int]

NUMBER: Dimension = (0, 0, 0, 0)
LENGTH: Dimension = (1, 0, 0, 0)
MASS: Dimension = (0, 1, 0, 0)
TIME: Dimension = (0, 0, 1, 0)
ANGLE: Dimension = (0, 0, 0, 1)
FORCE: Dimension = (1, 1, -2, 0)
TORQUE: Dimension = (2, 1, -2, 0)
INERTIA: Dimension = (2, 1, 0, 0)
_UNIT_OF = {LENGTH: "m", ANGLE: "rad", MASS: "kg", TIME: "s", TORQUE: "N*m", INERTIA: "kg*m^2"}

_SPEED: Dimension = (1, 0, -1, 0)
_TURNING: Dimension = (0, 0, -1, 1)
_FREQUENCY: Dimension = (0, 0, -1, 0)
_UNITS: tuple[tuple[Dimension, dict[str, float]], ...] = (
    (LENGTH, {"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "inch": 0.0254, "ft": 0.3048}),
    (MASS, {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237}),
    (TIME, {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}),
    (_FREQUENCY, {"Hz": 1.0, "kHz": 1e3}),
    (ANGLE, {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "arcmin": math.pi / 10800, "rev": 2 * math.pi}),
    (_TURNING, {"rpm": 2 * math.pi / 60}),
    (FORCE, {"N": 1.0, "kN": 1e3, "kgf": 9.80665}),
    (TORQUE, {"Nm": 1.0, "J": 1.0}),
    ((2, 1, -3, 0), {"W": 1.0}),
    ((-1, 1, -2, 0), {"Pa": 1.0}),
)
UNITS: dict[str, tuple[float, Dimension]] = {
    name: (value, dimension) for dimension, values in _UNITS for name, value in values.items()
}

# The dimensions that a parameter can be declared to have, by the word for it.
DIMENSIONS: dict[str, Dimension] = {
    "length": LENGTH,
    "mass": MASS,
    "time": TIME,
    "angle": ANGLE,
    "force": FORCE,
    "torque": TORQUE,
    "inertia": INERTIA,
    "speed": _SPEED,
    "angular_speed": _TURNING,
    "frequency": _FREQUENCY,
    "density": (-3, 1, 0, 0),
}

_NAMES: dict[Dimension, str] = {
    NUMBER: "a plain number",
    LENGTH: "a length (m)",
    MASS: "a mass (kg)",
    TIME: "a time (s)",
    ANGLE: "an angle (rad)",
    FORCE: "a force (N)",
    TORQUE: "a torque (N*m)",
    INERTIA: "a moment of inertia (kg*m^2)",
    _SPEED: "a speed (m/s)",
    _TURNING: "an angular speed (rad/s)",
    _FREQUENCY: "a frequency (Hz)",
    (2, 0, 0, 0): "an area (m^2)",
    (3, 0, 0, 0): "a volume (m^3)",
    (-3, 1, 0, 0): "a density (kg/m^3)",
    (1, 0, 0, -1): "a length per angle (m/rad)",
    (-1, 0, 0, 1): "an angle per length (rad/m)",
}

# No quantity is longer: a text of megabytes is none.
MAX_LENGTH = 100

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_BARE = re.compile(rf"{_NUMBER}\Z")
_QUANTITY = re.compile(rf"({_NUMBER})\s*([A-Za-z][A-Za-z0-9^*/-]*)\Z")
_FACTOR = re.compile(r"([*/]?)([A-Za-z]+)(?:\^(-?\d))?")


class Quantity(float):
    """A number in SI units with its dimension; ``text`` is what was written."""

    __slots__ = ("dimension", "text")
    dimension: Dimension
    text: str

    def __new__(cls, value: float, dimension: Dimension, text: str = "") -> Quantity:
        """Make a quantity of ``value`` (SI) and ``dimension``."""
        made = super().__new__(cls, value)
        made.dimension = dimension
        made.text = text
        return made

    @staticmethod
    @lru_cache(maxsize=1_000)
    def parse(text: str) -> Quantity | None:
        """Return the quantity of a text such as "12.5 mm", or None if it is not a number and a known unit."""
        match = _QUANTITY.match(text) if len(text) <= MAX_LENGTH else None
        unit = parse_unit(match[2]) if match else None
        if match is None or unit is None:
            return None
        factor, dimension = unit
        return Quantity(_scaled(match[1], factor), dimension, text)

    @classmethod
    def one(cls, unit: str = "") -> Quantity:
        """Return one of a unit, such as ``mm``; by default the plain number. Raises ValueError for no unit."""
        known = parse_unit(unit)
        if known is None:
            raise ValueError(f'"{unit}" is no unit')
        return cls(*known, f"1 {unit}".strip())

    @property
    def described(self) -> str:
        """What it is in words, such as "a length (m)"."""
        return describe(self.dimension)

    def goes_with(self, value: float) -> bool:
        """Return True for a value of the same dimension, or a bare number."""
        return dimension_of(value) in (None, self.dimension)

    @property
    def unit(self) -> str:
        """The SI unit of a quantity that links and joints have; empty for any other."""
        return _UNIT_OF.get(self.dimension, "")

    def __getnewargs__(self) -> tuple[float, Dimension, str]:  # type: ignore[override]
        """Return what a copy is made of, in this process or another one."""
        return float(self), self.dimension, self.text


def dimension_of(value: float) -> Dimension | None:
    """Return the dimension of a quantity, None for a bare number."""
    return value.dimension if isinstance(value, Quantity) else None


def in_si(value: float, dimension: Dimension) -> Quantity:
    """Return a bare number as the quantity of a dimension that it is in SI units."""
    try:
        number = float(value)
    except OverflowError:  # a whole number may have any number of digits
        number = math.inf if value > 0 else -math.inf
    return Quantity(number, dimension, repr(number).removesuffix(".0"))


def has_unit(value: object) -> bool:
    """Return True for a quantity that was written with its unit, and not converted by ``in_si``."""
    return isinstance(value, Quantity) and _BARE.match(value.text) is None


def describe(dimension: Dimension) -> str:
    """Return a dimension in words, such as "a length (m)"."""
    if dimension in _NAMES:
        return _NAMES[dimension]
    parts = [f"{u}^{n}" if n != 1 else u for u, n in zip(("m", "kg", "s", "rad"), dimension, strict=True) if n]
    return f"a quantity in {'*'.join(parts)}"


@lru_cache(maxsize=1_000)
def parse_unit(text: str) -> tuple[float, Dimension] | None:
    """Return the SI value and the dimension of a unit such as ``mm``, ``N*m`` or ``kg*m^2``; None if it is unknown.

    >>> parse_unit("rad/s")
    (1.0, (0, 0, -1, 1))
    """
    if text in UNITS:
        return UNITS[text]
    value, dimension, end = 1.0, NUMBER, 0
    for match in _FACTOR.finditer(text):
        operator, name, power = match.groups()
        if match.start() != end or name not in UNITS or (end == 0) == bool(operator):
            return None
        exponent = int(power or 1) * (-1 if operator == "/" else 1)
        unit, unit_dimension = UNITS[name]
        value *= unit**exponent
        dimension = add(dimension, unit_dimension, exponent)
        end = match.end()
    return (value, dimension) if end == len(text) else None


@lru_cache(maxsize=1_000)
def add(first: Dimension, second: Dimension, times: int = 1) -> Dimension:
    """Return the dimension of a product: the exponents of ``first`` plus ``times`` those of ``second``."""
    a, b, c, d = (x + times * y for x, y in zip(first, second, strict=True))
    return (a, b, c, d)


def _scaled(number: str, factor: float) -> float:
    """Return the number times the factor; powers of ten move the exponent, so 46.62 mm is the double 0.04662."""
    exponent = round(math.log10(factor))
    if factor != float(f"1e{exponent}"):
        return float(number) * factor
    mantissa, _, power = number.lower().partition("e")
    return float(f"{mantissa}e{int(power or 0) + exponent}")


def unknown_unit(text: str) -> str | None:
    """Return the unit of a text that looks like a quantity with an unknown unit, or None."""
    match = _QUANTITY.match(text) if len(text) <= MAX_LENGTH else None
    return match[2] if match and parse_unit(match[2]) is None else None

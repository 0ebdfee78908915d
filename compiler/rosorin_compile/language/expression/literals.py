"""Quantities in expressions (``30 mm``, ``-90 deg``, ``2.5 kg*m^2``), and why a text is not an expression.

A number and the unit after it are one value, which binds tighter than every operator. The unit is written as in a plain
value: no spaces around its ``*`` and ``/``, powers with ``^``. ``masked`` puts a name of the same length in its place
for Python's parser, so columns stay as they are.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from rosorin_compile.source.units import UNITS, Quantity
from rosorin_compile.source.wording import printable

from .functions import CONSTANTS, ExpressionError

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_FACTOR = r"[A-Za-z]+(?:\^-?\d)?(?![\w(])"
# The first alternatives skip texts and names, which contain no literals.
_TOKEN = re.compile(
    r"""'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|[^\W\d]\w*|"""
    rf"(?<![\w.])(?P<number>{_NUMBER})[ ]*(?P<unit>{_FACTOR}(?:[*/]{_FACTOR})*)"
)
_OVER = rf"(?<![\w.])({_NUMBER})\s*/\s*\Z"


class Literal(NamedTuple):
    """A quantity in an expression; ``factors`` are the units after its first one."""

    value: Quantity
    factors: tuple[str, ...]


def masked(text: str) -> tuple[str, dict[tuple[int, int], Literal]]:
    """Return an expression with a name of the same length for each quantity, and the quantities by line and column."""
    parts: list[str] = []
    found: dict[tuple[int, int], Literal] = {}
    end = 0
    for match in _TOKEN.finditer(text):
        unit = ""  # the longest beginning whose factors are units; the rest is arithmetic
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
            help = f"write {unit}^2 for the power of a unit, ({written})**2 for that of the quantity"
            raise ExpressionError(f'"**" after {written} could be the power of the unit', start, help)
        quotient = re.search(_OVER, text[:start])
        if quotient:
            number = quotient[1]
            help = f"write {number}/{written.removesuffix(unit).strip()} * 1 {unit}, or {number} / ({written})"
            message = f"{number}/{written} could be a part of 1 {unit}, or one over {written}"
            raise ExpressionError(message, start, help)
        value = Quantity(parsed, parsed.dimension, written)
        line = text.count("\n", 0, start) + 1
        column = len(text[text.rfind("\n", 0, start) + 1 : start].encode())  # Python's parser counts bytes
        found[line, column] = Literal(value, tuple(re.findall("[A-Za-z]+", unit)[1:]))
        parts += [text[end:start], "_" * (stop - start)]
        end = stop
    return "".join([*parts, text[end:]]), found


# Syntax of other languages, and the help for it.
_FOREIGN: tuple[tuple[str, str], ...] = (
    (r"[\u00a0\u2007\u202f]", "replace it by a space of the keyboard"),
    (r"&&", 'write "and"'),
    (r"\|\|", 'write "or"'),
    (r"\?.*:", "write A if CONDITION else B"),
    (r"!(?!=)", 'write "not"'),
    (r"\$", "a name stands in an expression as it is: no $ before it"),
    (r"[\u00b0\u00ba]", "write deg: 90 deg"),
    (r"[\u2212\u2013\u2014]", 'write the minus sign of the keyboard: "-"'),
    (r"[\u00d7\u00b7]", "write * for a product"),
    (r"\u00f7", "write / for a quotient"),
    (r"[\u00b2\u00b3]", "write **2 or **3; in a unit ^2 or ^3"),
    (r"[\u00b5\u03bc]m", "write um"),
    (r"\u03c0", "write pi"),
    (r"[\u2018\u2019\u201c\u201d]", "write straight quotes"),
    (r"(?<![=<>!])=(?!=)", 'compare with "=="; a value is given its name in let'),
    (r"\d,\d", "a number has a point, not a comma"),
)
_NO_UNIT = r"(?<![\w.])([\d.]+) *([A-Za-z]+)\b"
_WORDS = frozenset(("and", "or", "not", "if", "else", "for", "in", "is"))


def mistake(text: str, problem: SyntaxError) -> ExpressionError:
    """Return the error for a text that is not an expression, given that of Python's parser."""
    plain = re.sub(r"'[^']*'|\"[^\"]*\"", lambda match: " " * len(match[0]), text)
    for match in re.finditer(_NO_UNIT, plain):
        word = match[2]
        if word not in _WORDS and word not in UNITS and word not in CONSTANTS:
            help = "a unit such as mm, kg, deg or N*m; or * for a product"
            unknown_unit = ExpressionError(f'there is no unit "{word}"', match.start(2), help)
            unknown_unit.unit = (match[1], word)
            return unknown_unit
    for pattern, help in _FOREIGN:
        found = re.search(pattern, plain)
        if found:
            sign = printable(found[0] if len(found[0]) < 3 else found[0][:1])
            return ExpressionError(f'"{sign}" has no meaning in an expression', found.start(), help)
    column = max(0, (problem.offset or 1) - 1)
    if "never closed" in str(problem.msg) or "unmatched" in str(problem.msg):
        return ExpressionError(f"not an expression: {problem.msg}", column, "brackets come in pairs")
    if operator := re.search(r"(\*\*|//|[-+*/%<>=]|\b(?:and|or|not|if|else|in))\s*$", plain):
        return ExpressionError(f'a value is missing after "{operator[1]}"', column)
    two = re.search(r"[\w)\]] +[\w(]", plain[max(0, column - 2) :])
    help = "two values need an operator between them: * for a product" if two else ""
    return ExpressionError(f"not an expression: {problem.msg}", column, help)

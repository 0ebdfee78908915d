"""Expressions: a closed evaluator for what stands inside ``${...}``.

The text is read by Python's own parser, to which ``literals`` makes quantities such as ``30 mm`` known; each node is
turned, from an allow-list, into a small function of the names in scope: arithmetic, comparison, conditions, lists,
indexing, list comprehensions and the functions in ``functions``. There is no access to attributes of Python objects
(``table.key`` reaches an entry of a table), no import, no assignment. The length and depth of the text, the size of
numbers, texts and lists, and the number of steps of a comprehension are bounded, so that every expression ends soon.

``pieces`` takes a text apart into plain pieces and ``${...}``; ``$${`` is a plain ``${``. To be read after this:
``syntax`` (what a node becomes), ``functions`` (what it may call).
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from rosorin_compile.source.units import Quantity

from .functions import CONSTANTS, FUNCTIONS, ExpressionError, KindError, functions
from .literals import Literal, masked, mistake
from .syntax import CHOICES, EFFORT, MAX_MAGNITUDE, Code, Lookup, bounded, compile_node, names, nodes

__all__ = ["CHOICES", "CONSTANTS", "FUNCTIONS", "ExpressionError", "compiled", "evaluate", "names_in", "parsed", "run"]


MAX_LENGTH = 2_000

_REAL = frozenset((float, Quantity))
_MISHAPS = (TypeError, ValueError, ArithmeticError, LookupError, RecursionError, MemoryError, AttributeError)


def evaluate(text: str, lookup: Lookup) -> Any:
    """Return the value of an expression.

    ``lookup`` gives the value of a name and raises KeyError if there is none; units, constants and functions need no
    lookup. Raises ExpressionError on anything that is not allowed or has no value.
    """
    return run(compiled(text), text, lookup)


def run(code: Code, text: str, lookup: Lookup) -> Any:
    """Return the value of the expression ``text``, compiled to ``code``. Raises ExpressionError with its column."""
    before, EFFORT.done = EFFORT.done, 0
    try:
        value = code(lookup)
        return value if type(value) in _REAL and -MAX_MAGNITUDE < value < MAX_MAGNITUDE else bounded(value)
    except ExpressionError as problem:
        if problem.column < 0:
            problem.column = _blame(text, lookup)
        raise
    except _MISHAPS as problem:
        kind = KindError if isinstance(problem, (TypeError, AttributeError)) else ExpressionError
        raise kind(_reason(problem), _blame(text, lookup)) from None
    finally:
        EFFORT.total += EFFORT.done
        EFFORT.done = before


def _blame(text: str, lookup: Lookup) -> int:
    """Return the column of the innermost part of an expression that has no value."""
    from ast import iter_child_nodes

    node: ast.AST = parsed(text).body
    while True:
        children = [] if isinstance(node, (ast.ListComp, ast.GeneratorExp)) else iter_child_nodes(node)
        culprit = next((child for child in children if isinstance(child, ast.expr) and _fails(child, lookup)), None)
        if culprit is None:
            return getattr(node, "col_offset", 0)
        node = culprit


def _fails(node: ast.expr, lookup: Lookup) -> bool:
    if isinstance(node, ast.Name) and node.id in functions():
        return False
    EFFORT.done = 0
    try:
        compile_node(node)(lookup)
    except (ExpressionError, *_MISHAPS):
        return True
    return False


@lru_cache(maxsize=20_000)
def compiled(text: str) -> Code:
    """Return an expression as a function of the names in scope. Raises ExpressionError if it is not one."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = parsed(text)
    except SyntaxError as problem:
        raise mistake(text.strip(), problem) from None
    except ValueError:
        raise ExpressionError("not an expression that can be read") from None
    return compile_node(tree.body)


def parsed(text: str) -> ast.Expression:
    """Return the syntax tree of an expression, a constant for each quantity; without remarks that are for people.

    Raises ExpressionError for a quantity that is not clear, SyntaxError, and ValueError if the text is nested too deep
    for the parser.
    """
    import warnings

    plain, literals = masked(text.strip())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        try:
            tree: Any = compile(plain, "<unknown>", "eval", ast.PyCF_ONLY_AST)
        except (RecursionError, MemoryError):
            raise ValueError("nested too deep") from None
    for node in nodes(tree) if literals else ():
        for field in node._fields:
            value = getattr(node, field, None)
            if isinstance(value, list):
                value[:] = [_quantity(item, literals) for item in value]
            elif isinstance(value, ast.Name):
                setattr(node, field, _quantity(value, literals))
    return tree  # type: ignore[no-any-return]


def _quantity(node: Any, literals: Mapping[tuple[int, int], Literal]) -> Any:
    """Return the constant of the quantity that a name stands for; any other node as it is."""
    if not isinstance(node, ast.Name) or (node.lineno, node.col_offset) not in literals:
        return node
    place = {name: getattr(node, name) for name in ("lineno", "col_offset", "end_lineno", "end_col_offset")}
    constant: Any = literals[node.lineno, node.col_offset]
    return ast.Constant(constant, **place)


def names_in(text: str) -> list[str]:
    """Return the names that an expression uses, in order, each once; none if it is no expression."""
    if len(text) > MAX_LENGTH:
        return []
    try:
        tree = parsed(text)
    except (ExpressionError, SyntaxError, ValueError):
        return []
    known = functions()
    return list(dict.fromkeys(name for name in names(tree) if name not in known))


def _reason(problem: Exception) -> str:
    if isinstance(problem, ZeroDivisionError):
        return "division by zero"
    if isinstance(problem, (RecursionError, MemoryError)):
        return "the value is too large"
    return str(problem) or type(problem).__name__


_OPEN = "${"


class Piece(NamedTuple):
    """A piece of a text, and where it starts in it; an expression is given without its braces."""

    text: str
    offset: int
    is_expression: bool = False
    is_whole: bool = False
    unclosed: bool = False


@lru_cache(maxsize=20_000)
def pieces(text: str) -> tuple[Piece, ...]:
    """Return the pieces of a text in order."""
    taken: list[Piece] = []
    position = 0
    while (start := text.find(_OPEN, position)) >= 0:
        if start > 0 and text[start - 1] == "$":
            taken.append(Piece(text[position : start - 1] + _OPEN, position))
            position = start + 2
            continue
        if start > position:
            taken.append(Piece(text[position:start], position))
        end = _closing(text, start + 2)
        if end < 0:
            return (*taken, Piece(text[start + 2 :], start, True, unclosed=True))
        whole = start == 0 and end == len(text) - 1
        taken.append(Piece(text[start + 2 : end], start, True, whole))
        position = end + 1
    if position < len(text):
        taken.append(Piece(text[position:], position))
    return tuple(taken)


def _closing(text: str, position: int) -> int:
    """Return where the brace that is open at ``position`` closes, or -1; quotes and inner pairs are passed."""
    depth, quote = 1, ""
    for index in range(position, len(text)):
        letter = text[index]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter == "{":
            depth += 1
        elif letter == "}":
            depth -= 1
            if depth == 0:
                return index
    return -1

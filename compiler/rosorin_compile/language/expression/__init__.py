"""Parse and evaluate expressions, the contents of ``${...}``, without access to Python objects.

Python's parser reads the text, after quantities such as ``30 mm`` have been replaced by names. ``syntax`` evaluates
only certain nodes: arithmetic, comparisons, conditions, lists, indexing, list comprehensions, and calls of functions
in ``functions``. There are no attributes of Python objects (``table.key`` is an entry of a table), imports or
assignments. The sizes of values and the number of steps are limited, so every expression terminates soon.
"""

import ast
import warnings
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from .functions import ExpressionError as ExpressionError
from .functions import KindError, functions
from .syntax import EFFORT, Literal, Lookup, check, check_size, mask_quantities, mistake, value_of

MAX_LENGTH = 2_000
_FAILURES = (TypeError, ValueError, ArithmeticError, LookupError, RecursionError, MemoryError, AttributeError)
_OPEN = "${"


def evaluate(text: str, lookup: Lookup) -> Any:
    """Evaluate an expression, the text between ``${`` and ``}``.

    ``lookup`` returns the value of a name, and raises KeyError if it is undefined; units, constants and functions are
    built in. Raises ExpressionError, with the column, if the expression is invalid or cannot be evaluated.
    """
    tree = compile_expression(text)
    before, EFFORT.done = EFFORT.done, 0
    try:
        return check_size(value_of(tree, lookup))
    except ExpressionError as problem:
        if problem.column < 0:
            problem.column = _blame(tree, lookup)
        raise
    except _FAILURES as problem:
        message = str(problem) or type(problem).__name__
        if isinstance(problem, ZeroDivisionError):
            message = "division by zero"
        elif isinstance(problem, (RecursionError, MemoryError)):
            message = "the value is too large"
        kind = KindError if isinstance(problem, (TypeError, AttributeError)) else ExpressionError
        raise kind(message, _blame(tree, lookup)) from None
    finally:
        EFFORT.total += EFFORT.done
        EFFORT.done = before


def _blame(node: ast.AST, lookup: Lookup) -> int:
    for child in () if isinstance(node, (ast.ListComp, ast.GeneratorExp)) else ast.iter_child_nodes(node):
        if isinstance(child, ast.expr) and not (isinstance(child, ast.Name) and child.id in functions()):
            EFFORT.done = 0
            try:
                value_of(child, lookup)
            except (ExpressionError, *_FAILURES):
                return _blame(child, lookup)
    return getattr(node, "col_offset", 0)


@lru_cache(maxsize=20_000)
def compile_expression(text: str) -> ast.expr:
    """Return the syntax tree of an expression. Raises ExpressionError if the expression is invalid."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(f"the expression is longer than {MAX_LENGTH} characters")
    try:
        tree = parse_expression(text).body
    except SyntaxError as problem:
        raise mistake(text.strip(), problem) from None
    except ValueError:
        raise ExpressionError("not an expression that can be read") from None
    check(tree)
    return tree


def parse_expression(text: str) -> ast.Expression:
    """Return the syntax tree of an expression, in which each quantity such as ``30 mm`` is a constant.

    Raises ExpressionError for an ambiguous quantity, SyntaxError for invalid syntax, ValueError if the expression is
    nested too deep for the parser.
    """
    plain, literals = mask_quantities(text.strip())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SyntaxWarning)
        try:
            tree = compile(plain, "<unknown>", "eval", ast.PyCF_ONLY_AST)
            return _Literals(literals).visit(tree) if literals else tree  # type: ignore[return-value]
        except (RecursionError, MemoryError):
            raise ValueError("nested too deep") from None


class _Literals(ast.NodeTransformer):
    def __init__(self, literals: Mapping[tuple[int, int], Literal]) -> None:
        self.literals = literals

    def visit_Name(self, node: ast.Name) -> ast.expr:
        literal: Any = self.literals.get((node.lineno, node.col_offset))
        return ast.copy_location(ast.Constant(literal), node) if literal else node


@lru_cache(maxsize=20_000)
def all_names(text: str) -> tuple[str, ...]:
    """Return the names in an expression in order, without duplicates, or () if the expression is invalid."""
    try:
        tree = parse_expression(text) if len(text) <= MAX_LENGTH else ast.Module([], [])
    except (ExpressionError, SyntaxError, ValueError):
        return ()
    return tuple(dict.fromkeys(node.id for node in ast.walk(tree) if isinstance(node, ast.Name)))


def names_in(text: str) -> list[str]:
    """Return the names in an expression, without the names of functions."""
    return [name for name in all_names(text) if name not in functions()]


class Piece(NamedTuple):
    """A literal or an expression (without ``${}``) in a string; ``is_whole`` is True if it is the entire string."""

    text: str
    offset: int
    is_expression: bool = False
    is_whole: bool = False
    unclosed: bool = False


@lru_cache(maxsize=20_000)
def pieces(text: str) -> tuple[Piece, ...]:
    """Split a string into literals and expressions (``${...}``); ``$${`` is an escaped ``${``."""
    found: list[Piece] = []
    position = 0
    while (start := text.find(_OPEN, position)) >= 0:
        if start > 0 and text[start - 1] == "$":
            found.append(Piece(text[position : start - 1] + _OPEN, position))
            position = start + 2
            continue
        if start > position:
            found.append(Piece(text[position:start], position))
        end = _closing(text, start + 2)
        if end < 0:
            return (*found, Piece(text[start + 2 :], start, True, unclosed=True))
        found.append(Piece(text[start + 2 : end], start, True, start == 0 and end == len(text) - 1))
        position = end + 1
    if position < len(text):
        found.append(Piece(text[position:], position))
    return tuple(found)


def _closing(text: str, position: int) -> int:
    depth, quote = 1, ""
    for index in range(position, len(text)):
        letter = text[index]
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        elif letter in "{}":
            depth += 1 if letter == "{" else -1
            if depth == 0:
                return index
    return -1

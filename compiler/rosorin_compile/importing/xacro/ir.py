"""The intermediate representation of a xacro: values, and nodes such as macros, calls, conditions and elements.

A symbolic value (``Symbol``) is an expression of the description language with an example value, computed by xacro.
Expressions are Python syntax trees; the node of a variable has the attribute ``variable``. The type of a symbol is the
type of the expression; the value in xacro may be a string instead. Arguments, properties and macro parameters are
``Variable``s; XML blocks become parameters. ``nodes_of`` converts a symbolically evaluated document to nodes.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field
from keyword import kwlist
from typing import Any

from rosorin_compile.language.expression import evaluate
from rosorin_compile.language.expression.functions import CONSTANTS, OF_DESCRIPTIONS, ExpressionError, functions

from ..description import free_name
from .child import MARK, Place

COMMENTS = "rosorin_comments"  # attribute of an XML element that stores the comments before it
TOKEN = re.compile("\ua657(\\d+)\ua657")  # placeholder for a ``Symbol`` in a string; the letter is rarely used
UNKNOWN = object()  # example value of a ``Symbol`` that cannot be computed
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_OUTSIDE = ("find", "load", "error")  # functions that are not constant: they read files or raise errors
_NUMBERS = re.compile(r"\s*[-+]?[\d.][\d.eE+-]*(?:\s+[-+]?[\d.][\d.eE+-]*)+\s*")

Pieces = list[Any]  # strings and ``Symbol``s that are concatenated


class Untranslatable(Exception):
    """A value cannot be expressed in the description language; ``nodes`` are the expressions at fault."""

    def __init__(self, reason: str, *nodes: ast.AST) -> None:
        super().__init__(reason)
        self.nodes = nodes


def literal(text: Any) -> Any:
    """Convert a string to a number or boolean by the rules of xacro, or return the value unchanged."""
    if not isinstance(text, str) or "_" in text:
        return text
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return _FLAGS.get(text, text)


def plain_node(value: Any) -> ast.expr:
    """Convert a Python value to an expression. Raises Untranslatable if the description language has no such value."""
    if value is None or isinstance(value, bool):
        return ast.Name({None: "none", True: "true", False: "false"}[value], ast.Load())
    if isinstance(value, (list, tuple)):
        return ast.List([plain_node(item) for item in value], ast.Load())
    if isinstance(value, dict):
        return ast.Dict([plain_node(key) for key in value], [plain_node(dict.get(value, key)) for key in value])
    if isinstance(value, float) and not math.isfinite(value):
        raise Untranslatable("nan and inf are not values of the language")
    if isinstance(value, (int, float)) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    if isinstance(value, (int, float, str)):
        return ast.Constant(value)
    raise Untranslatable(f"{type(value).__name__} cannot be translated")


def number_in(text: str) -> int | float:
    """Parse a finite number from a string. Raises Untranslatable if the string is not a number."""
    value = literal(text.strip())
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise Untranslatable(f'"{text[:40]}" is not a number')
    return value


def number_node(text: str) -> ast.expr:
    """Convert a string with a number to an expression. Raises Untranslatable if the string is not a number."""
    value = number_in(text)
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e6:
        value = int(value)
    return plain_node(value)


def call(name: str, *arguments: ast.expr) -> ast.Call:
    """Build an expression that calls a function of the description language."""
    return ast.Call(ast.Name(name, ast.Load()), list(arguments), [])


def negate(node: ast.expr) -> ast.expr:
    """Return the negation of a condition, simplified if possible."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return node.operand
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return plain_node(node.id == "false")
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        opposites: dict[type, type] = {ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.In: ast.NotIn, ast.NotIn: ast.In}
        if type(node.ops[0]) in opposites:
            return ast.Compare(node.left, [opposites[type(node.ops[0])]()], node.comparators)
    return ast.UnaryOp(ast.Not(), node)


def all_of(*nodes: ast.expr | None) -> ast.expr | None:
    """Join conditions with ``and``, where None is true. Return None if the result is always true."""
    found: dict[str, ast.expr] = {}
    for node in nodes:
        decided = True if node is None else fold(node)
        if decided is False:
            return plain_node(False)
        if node is not None and decided is not True:
            found.setdefault(as_text(node), node)
    return ast.BoolOp(ast.And(), [*found.values()]) if len(found) > 1 else next(iter(found.values()), None)


def fold(node: ast.expr) -> Any:
    """Evaluate a constant expression. Return None if the expression is not constant."""
    names = {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}
    is_open = any(name in _OUTSIDE or (name not in CONSTANTS and name not in functions()) for name in names)
    if not is_open and not any(variables_in([node])):
        with suppress(ExpressionError):
            return evaluate(as_text(node), dict[str, Any]().__getitem__)
    return None


def as_text(node: ast.expr) -> str:
    """Format an expression in the syntax of the description language."""
    for one in ast.walk(node):
        if isinstance(one, ast.Name) and hasattr(one, "variable"):
            one.id = one.variable.ours
    return ast.unparse(ast.fix_missing_locations(node)).strip()


def variables_in(nodes: Iterable[ast.AST]) -> Iterator[Any]:
    """Yield the ``Variable`` objects that occur in expressions."""
    for node in nodes:
        yield from (one.variable for one in ast.walk(node) if hasattr(one, "variable"))


def usable(name: str, taken: Iterable[str], shadows: bool = False) -> str:
    """Convert ``name`` to a valid variable name that is not in ``taken``.

    Names of functions are only allowed if ``shadows`` is True.
    """
    reserved = {*(() if shadows else functions()), *OF_DESCRIPTIONS, *CONSTANTS, "rad", "deg", *kwlist, *taken}
    return free_name(re.sub(r"\W", "_", name, flags=re.ASCII) or "value", reserved)


class Restart(Exception):
    """The translation must start again without a macro or argument that cannot be translated."""


@dataclass(eq=False)
class Variable:
    """An argument, a parameter of a macro, or a property that becomes an entry of ``let``."""

    kind: str
    name: str
    ours: str  # name in the description
    value: Any  # example value
    type: str
    symbol: Symbol | None = None  # value of a property, or default of an argument
    owner: str = ""  # key of the macro to which the parameter or property belongs
    place: Any = None
    comments: list[str] = field(default_factory=list)
    candidates: list[Any] = field(default_factory=list)  # values that conditions compare with the variable
    environment: bool = False
    names_file: bool = False  # True if the name of a loaded YAML file contains the variable
    names_mesh: bool = False  # True if the value is the name of a mesh or texture file
    printed: bool = False  # True if the value is inserted into a string
    as_written: bool = False  # True if the text of an argument is used, not the number or boolean that it stands for
    tested: bool = False  # True if the text is a condition
    counted: bool = False  # True if the number is used, not only whether it is 0
    used: bool = False
    digits: str = ""  # the number in the format of the source

    @property
    def node(self) -> ast.expr:
        """A syntax tree node that refers to the variable."""
        made = ast.Name(self.ours, ast.Load())
        made.variable = self  # type: ignore[attr-defined]
        return made


class Symbol:
    """A symbolic value: an expression of the description language, its type, and an example value.

    If ``known`` is True, the expression is constant. ``pieces`` are the parts of a concatenated string.
    """

    tokens: list[Symbol] = []  # symbols by the number in their ``TOKEN``  # noqa: RUF012

    def __init__(self, node: ast.expr | None, value: Any, kind: str, known: bool, pieces: Pieces | None = None) -> None:
        self._node, self.value, self.type, self.known, self.pieces = node, value, kind, known, pieces or []
        self._number = -1

    def __str__(self) -> str:
        if self._number < 0:
            self._number = len(Symbol.tokens)
            Symbol.tokens.append(self)
        return f"\ua657{self._number}\ua657"

    @property
    def node(self) -> ast.expr:
        if self._node is None:
            self._node = joined_node(self.pieces)
        return self._node

    @property
    def variable(self) -> Variable | None:
        """The variable if the expression is just a variable name, else None."""
        return getattr(self._node, "variable", None)

    @property
    def constant(self) -> str | None:
        """The string if the expression is a string constant, else None."""
        node = self._node
        return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else None

    @property
    def package(self) -> str:
        """The name of the ROS package if the expression is ``find(NAME)`` with a constant, else ""."""
        node: Any = self._node
        is_find = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find"
        return str(node.args[0].value) if is_find and isinstance(node.args[0], ast.Constant) else ""

    @property
    def declared_type(self) -> str:
        """The type to declare for a variable with this value, such as list for "0 0 1" or boolean for "false"."""
        if self.constant in ("true", "false"):
            return "boolean"
        can_be_list = self.constant is not None or len(self.pieces) > 1 or self.type == "list"
        is_list = can_be_list and isinstance(self.value, str) and _NUMBERS.fullmatch(self.value) is not None
        return "list" if is_list else self.type

    def as_number(self) -> ast.expr:
        """Return the value as a numeric expression. Raises Untranslatable for a string that is not a number."""
        if self.constant is not None:
            return number_node(self.constant)
        if self.pieces:
            return _number_of_word([piece for word in words_of(self.pieces) for piece in word])
        return call("float", self.node) if self.type == "text" else self.node

    def as_flag(self) -> ast.expr:
        """Return the value as a boolean expression, converted by the rules of xacro conditions."""
        if self.constant is not None:
            return plain_node(bool(literal(self.constant)))
        if self.type == "boolean":
            return self.node
        if self.type == "number" or (self.type == "text" and type(literal(self.value)) in (int, float)):
            number: Any = copy(self.as_number())
            number.is_test = True
            return ast.Compare(number, [ast.NotEq()], [ast.Constant(0)])
        if self.type == "text":
            if self.variable is not None:
                self.variable.tested = True
            return ast.Compare(self.node, [ast.In()], [plain_node(["true", "True", "1"])])
        return call("bool", self.node)

    def as_truth(self) -> ast.expr:
        """Return the value as a boolean expression, converted by the rules of Python."""
        if self.type == "text" and self.constant is None:
            return ast.Compare(self.node, [ast.NotEq()], [ast.Constant("")])
        return plain_node(bool(self.constant)) if self.constant is not None else self.as_flag()

    def as_list(self) -> ast.expr:
        """Return the value as an expression for a list of numbers."""
        words = words_of(self.pieces or ([self.constant] if self.constant is not None else []))
        if len(words) > 1:
            return ast.List([_number_of_word(word) for word in words], ast.Load())
        return self.node if self.type == "list" else call("numbers", self.node)

    def as_text(self) -> ast.expr:
        """Return the value as a string expression, in the format in which xacro prints the value."""
        if self.pieces or self.constant is not None:
            return self.node
        if self.type == "boolean" and not isinstance(self.value, str):  # a boolean from a string keeps its spelling
            decided = fold(self.node)
            if isinstance(decided, bool):
                return ast.Constant(str(decided))
            return ast.IfExp(self.node, ast.Constant("True"), ast.Constant("False"))
        value = fold(self.node)
        if isinstance(value, int) and not isinstance(value, bool):
            return ast.Constant(str(value))
        if self.type == "list":
            return call("join", ast.Constant(" "), self.node)
        node: Any = copy(self.node)
        node.is_text = isinstance(self.value, str)
        return node if self.type == "text" else call("str", node)


def symbol_of(value: Any) -> Symbol:
    """Convert a value to a symbolic value. Raises Untranslatable if the description language has no such value."""
    return value if isinstance(value, Symbol) else Symbol(plain_node(value), value, type_of(value), True)


def example_of(value: Any) -> Any:
    """Return the example value of a symbolic value; return any other value unchanged."""
    return value.value if isinstance(value, Symbol) else value


def is_known(value: Any) -> bool:
    """Return True if a value does not depend on arguments or parameters."""
    return not isinstance(value, Symbol) or value.known


def type_of(value: Any) -> str:
    """Return the type name of a Python value in the description language, or "" for other types."""
    kinds = ((bool, "boolean"), ((int, float), "number"), (str, "text"), ((list, tuple), "list"), (dict, "table"))
    return next((kind for types, kind in kinds if isinstance(value, types)), "")


def join_pieces(pieces: Pieces) -> Any:
    """Concatenate strings and symbolic values; return a string if the result is constant, else a symbolic value."""
    made: Pieces = []
    for piece in pieces:
        for one in piece.pieces or [piece] if isinstance(piece, Symbol) else [piece]:
            text = one if isinstance(one, str) else one.constant
            if text is None:
                made.append(one)
            elif made and isinstance(made[-1], str):
                made[-1] += text
            elif text:
                made.append(text)
    if len(made) < 2:
        return made[0] if made else ""
    examples = [example_of(one) for one in made]
    value = UNKNOWN if any(one is UNKNOWN for one in examples) else "".join(map(str, examples))
    return Symbol(None, value, "text", all(map(is_known, made)), made)


def pieces_of(value: Any) -> Pieces:
    """Return the strings and symbolic values of which a string or symbolic value is composed."""
    text = value.constant if isinstance(value, Symbol) else value
    return ([text] if text else []) if text is not None else value.pieces or [value]


def with_tokens(text: str) -> Any:
    """Replace the ``TOKEN`` placeholders in a string with symbolic values; return a string or a symbolic value."""
    parts = TOKEN.split(text)
    return join_pieces([Symbol.tokens[int(part)] if index % 2 else part for index, part in enumerate(parts)])


def joined_node(pieces: Pieces) -> ast.expr:
    """Return an expression that concatenates strings and symbolic values."""
    made: ast.expr | None = None
    for piece in pieces:
        item = ast.Constant(piece) if isinstance(piece, str) else piece.as_text()
        last = made.right if isinstance(made, ast.BinOp) else made
        if isinstance(last, ast.Constant) and isinstance(item, ast.Constant):
            item = ast.Constant(str(last.value) + str(item.value))
            made = made.left if isinstance(made, ast.BinOp) else None
        made = item if made is None else ast.BinOp(made, ast.Add(), item)
    return made if made is not None else ast.Constant("")


def words_of(pieces: Pieces) -> list[Pieces]:
    """Split a concatenation of strings and symbolic values into words at whitespace."""
    words: list[Pieces] = [[]]
    for piece in pieces:
        parts = re.split(r"\s+", piece) if isinstance(piece, str) else [piece]
        for index, part in enumerate(parts):
            if index:
                words.append([])
            if part != "":
                words[-1].append(part)
    return [word for word in words if word]


def _number_of_word(word: Pieces) -> ast.expr:
    if len(word) == 1:
        return number_node(word[0]) if isinstance(word[0], str) else word[0].as_number()
    if len(word) == 2 and word[0] in ("-", "+") and isinstance(word[1], Symbol):
        made = word[1].as_number()
        return ast.UnaryOp(ast.USub(), made) if word[0] == "-" else made
    return call("float", joined_node(word))


@dataclass(eq=False)
class Element:
    """An XML element with its attributes and child nodes."""

    tag: str
    attributes: dict[str, Pieces]
    body: list[Any]
    place: Place | None
    comments: list[str]


@dataclass(eq=False)
class Call:
    """A call to a translated macro; ``given`` maps each parameter to (value, True if the value is the default)."""

    macro: Macro
    given: dict[str, tuple[Symbol, bool]]
    place: Place | None
    comments: list[str]


@dataclass(eq=False)
class If:
    """An <xacro:if> or <xacro:unless>: the nodes ``body`` are included only if ``test`` evaluates to ``holds``."""

    test: Symbol
    holds: bool
    body: list[Any]


@dataclass(eq=False)
class Words:
    """Text content of an XML element."""

    pieces: Pieces


@dataclass(eq=False)
class Comment:
    """An XML comment."""

    text: str


@dataclass(eq=False)
class Macro:
    """A translated macro; ``level`` is the tag of the element that contains the calls.

    With the level "robot", the macro becomes a part, otherwise a ``let`` function.
    """

    name: str
    key: str  # source position of the definition, as a string
    level: str
    place: Place | None
    comments: list[str]
    parameters: dict[str, Variable] = field(default_factory=dict)
    body: list[Any] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    depth: int = 0
    table: Any = None
    ours: str = ""


def nodes_of(parent: Any) -> list[Any]:
    """Convert the content of an XML element to nodes of the intermediate representation."""
    made: list[Any] = []
    for node in parent.childNodes:
        place, comments = getattr(node, MARK, None), getattr(node, COMMENTS, [])
        if node.nodeType == node.COMMENT_NODE:
            made.append(Comment(node.data))
        elif node.nodeType == node.TEXT_NODE and node.data.strip():
            made.append(Words(pieces_of(with_tokens(node.data.strip()))))
        elif node.nodeType != node.ELEMENT_NODE:
            continue
        elif node.tagName == "xacro-call":
            macro, given = node.rosorin_call
            made.append(Call(macro, given, place, comments))
            macro.calls.append(made[-1])
        elif node.tagName == "xacro-if":
            test = Symbol.tokens[int(TOKEN.fullmatch(node.getAttribute("test"))[1])]  # type: ignore[index]
            made.append(If(test, node.getAttribute("holds") == "1", [*map(Comment, comments), *nodes_of(node)]))
        else:
            attributes = {name: pieces_of(with_tokens(text)) for name, text in node.attributes.items()}
            made.append(Element(node.tagName, attributes, nodes_of(node), place, comments))
    return made


def walk(nodes: list[Any]) -> Iterator[Any]:
    """Yield nodes of the intermediate representation and their descendants in document order."""
    for node in nodes:
        yield node
        yield from walk(getattr(node, "body", []))


def expressions_in(nodes: list[Any]) -> Iterator[ast.AST]:
    """Yield the expressions in nodes and their descendants."""
    for node in walk(nodes):
        pieces: Pieces = []
        if isinstance(node, Element):
            pieces = [piece for text in node.attributes.values() for piece in text]
        elif isinstance(node, Words):
            pieces = node.pieces
        elif isinstance(node, If):
            pieces = [node.test]
        elif isinstance(node, Call):
            pieces = [one for one, _ in node.given.values()]
        yield from (piece.node for piece in pieces if isinstance(piece, Symbol))

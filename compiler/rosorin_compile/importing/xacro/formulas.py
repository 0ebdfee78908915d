"""Translate formulas of Python, as xacro has them, to expressions of the language."""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from rosorin_compile.language.expression import evaluate
from rosorin_compile.language.expression.functions import ExpressionError, functions

from .ir import ANY, FLAG, LIST, NUMBER, TABLE, TEXT, Pieces, Unsupported, Variable, flattened, is_list_text

FLAGS = {"true": True, "True": True, "false": False, "False": False}
_ANGULAR = frozenset(("acos", "asin", "atan", "atan2", "radians"))
_TEXTUAL = frozenset(("str", "join", "upper", "lower", "replace", "find", "strip"))
_BOOLEAN = frozenset(("bool", "all", "any", "startswith", "endswith", "isclose"))
_LISTS = frozenset(("split", "keys", "values", "items", "list", "range", "sorted", "reversed", "zip", "numbers"))


def literal(text: Any) -> Any:
    """Return the number or truth value that a text of xacro is, or the text."""
    if not isinstance(text, str) or "_" in text:
        return text
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return FLAGS.get(text, text)


def type_of_values(values: list[Any], is_raw: bool = False) -> str:
    """Return the type of a variable that has these values; raw ones are texts that may be numbers."""
    kinds = set()
    for value in map(literal, values) if is_raw else values:
        if isinstance(value, bool) or value in ("true", "false"):
            kinds.add(FLAG)
        elif isinstance(value, (int, float)):
            kinds.add(NUMBER)
        elif isinstance(value, str):
            kinds.add(LIST if is_list_text(value) else TEXT)
        else:
            kinds.add(LIST if isinstance(value, list) else TABLE if isinstance(value, dict) else ANY)
    return kinds.pop() if len(kinds) == 1 else ANY


class Formulas:
    """Translates formulas. ``use`` is called with each variable that is read, and may return what to write for it."""

    def __init__(self, variables: Mapping[str, Variable], use: Callable[[Variable], ast.expr | None]) -> None:
        self.variables = variables
        self.use = use
        self.found: Callable[[str], None] = lambda _: None  # called with each package that is named
        self.address: Callable[[str], str] = lambda name: name  # of a file that is loaded, or its beginning

    def type(self, node: ast.expr) -> str:
        """Return the type of what a formula of xacro results in, as far as it is certain."""
        if isinstance(node, ast.Name):
            if node.id in self.variables:
                return self.variables[node.id].type
            return (
                NUMBER if node.id in ("pi", "e", "tau", "inf", "nan") else FLAG if node.id in ("true", "false") else ANY
            )
        if isinstance(node, ast.Constant):
            return type_of_values([node.value]) if not isinstance(node.value, str) else TEXT
        if isinstance(node, ast.IfExp):
            types = {self.type(node.body), self.type(node.orelse)}
            return types.pop() if len(types) == 1 else ANY
        if isinstance(node, ast.BinOp):
            types = {self.type(node.left), self.type(node.right)}
            return TEXT if TEXT in types else LIST if LIST in types else NUMBER
        if isinstance(node, ast.UnaryOp):
            return FLAG if isinstance(node.op, ast.Not) else NUMBER
        if isinstance(node, ast.BoolOp):
            types = {self.type(item) for item in node.values}
            return types.pop() if len(types) == 1 else ANY
        if isinstance(node, ast.Compare):
            return FLAG
        if isinstance(node, (ast.List, ast.ListComp)):
            return LIST
        if isinstance(node, ast.Dict):
            return TABLE
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", "")
            if name in ("__number", "__flag"):
                return NUMBER if name == "__number" else FLAG
            if name in ("get", "min", "max", "load"):
                return ANY
            kinds = ((_TEXTUAL | {"__join"}, TEXT), (_BOOLEAN, FLAG), (_LISTS, LIST))
            return next((kind for names, kind in kinds if name in names), NUMBER)
        return ANY

    # Expressions of the language.

    def node(self, node: ast.expr) -> ast.expr:
        """Return a formula as an expression of the language. Raises Unsupported."""
        if isinstance(node, ast.Name):
            variable = self.variables.get(node.id)
            if variable is None:
                if node.id in ("inf", "nan"):
                    raise Unsupported("nan and inf are no values of the language", node)
                return node
            return self.use(variable) or ast.Name(variable.ours, ast.Load())
        if isinstance(node, ast.Constant):
            return self.constant(node.value)
        if isinstance(node, ast.Compare):
            return self.compare(node)
        if isinstance(node, ast.IfExp):
            test = self.truth(node.test)
            decided = folded(test)
            if isinstance(decided, bool):
                return self.node(node.body if decided else node.orelse)
            return ast.IfExp(test, self.node(node.body), self.node(node.orelse))
        if isinstance(node, ast.BoolOp):
            if all(self.type(item) == FLAG for item in node.values):
                return ast.BoolOp(node.op, [self.truth(item) for item in node.values])
            return ast.BoolOp(node.op, [self.node(item) for item in node.values])
        if isinstance(node, ast.UnaryOp):
            return (
                negated(self.truth(node.operand))
                if isinstance(node.op, ast.Not)
                else ast.UnaryOp(node.op, self.node(node.operand))
            )
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Add) and TEXT in (self.type(node.left), self.type(node.right)):
                return self.joined(flattened([node.left, node.right]))
            return ast.BinOp(self.node(node.left), node.op, self.node(node.right))
        if isinstance(node, ast.Subscript):
            return self.subscript(node)
        if isinstance(node, ast.Call):
            return self.call(node)
        if isinstance(node, ast.List):
            return ast.List([self.node(item) for item in node.elts], ast.Load())
        if isinstance(node, ast.Dict):
            keys = [None if key is None else self.node(key) for key in node.keys]
            return ast.Dict(keys, [self.node(value) for value in node.values])
        if isinstance(node, ast.ListComp):
            rows = [
                ast.comprehension(one.target, self.node(one.iter), [self.truth(test) for test in one.ifs], 0)
                for one in node.generators
            ]
            return ast.ListComp(self.node(node.elt), rows)
        raise Unsupported(f"{ast.unparse(node)[:60]} cannot be translated", node)

    def constant(self, value: Any) -> ast.expr:
        if isinstance(value, float) and not math.isfinite(value):
            raise Unsupported("nan and inf are no values of the language")
        if value is None or isinstance(value, bool):
            return ast.Name({None: "none", True: "true", False: "false"}[value], ast.Load())
        return ast.Constant(value)

    def compare(self, node: ast.Compare) -> ast.expr:
        items = [node.left, *node.comparators]
        if len(items) == 2 and isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
            equal = isinstance(node.ops[0], ast.Eq)
            for item, other in (items, items[::-1]):
                if not isinstance(other, ast.Constant):
                    continue
                kind, value = self.type(item), literal(other.value)
                if kind == FLAG and isinstance(value, (bool, int, float)) and value in (0, 1):
                    made = self.flag(item)
                    return made if bool(value) == equal else negated(made)
                if kind == NUMBER and isinstance(other.value, str) and isinstance(value, (int, float)):
                    items = [ast.Constant(value) if one is other else one for one in items]
                if kind == NUMBER and isinstance(value, bool):
                    items = [ast.Constant(int(value)) if one is other else one for one in items]
        return ast.Compare(self.node(items[0]), node.ops, [self.node(item) for item in items[1:]])

    def subscript(self, node: ast.Subscript) -> ast.expr:
        base = self.node(node.value)
        if isinstance(node.slice, ast.Slice):
            ends = [
                None if one is None else self.node(one) for one in (node.slice.lower, node.slice.upper, node.slice.step)
            ]
            return ast.Subscript(base, ast.Slice(*ends), ast.Load())
        if isinstance(base, ast.Dict) and isinstance(node.slice, ast.Constant):
            for key, value in zip(base.keys, base.values, strict=True):
                if isinstance(key, ast.Constant) and key.value == node.slice.value:
                    return value
        return ast.Subscript(base, self.node(node.slice), ast.Load())

    def call(self, node: ast.Call) -> ast.expr:
        name = getattr(node.func, "id", "")
        if name == "__flag":
            return self.flag(node.args[0])
        if name == "__number":
            return self.of_number(node.args[0])
        if name == "__join":
            return self.joined(flattened([node]))
        if name == "load":
            first, *rest = flattened([node.args[0]])
            first = self.address(first) if isinstance(first, str) else first
            return ast.Call(ast.Name("load"), [self.joined(flattened([first, *rest]))], [])
        if name == "find":
            self.found(node.args[0].value)  # type: ignore[attr-defined]
        arguments = [self.node(item) for item in node.args]
        if name == "float" and isinstance(arguments[0], ast.Constant) and isinstance(arguments[0].value, (int, float)):
            return arguments[0]
        if name == "split" and self.type(node.args[0]) == LIST:
            return arguments[0]
        made = ast.Call(ast.Name(name, ast.Load()), arguments, [])
        return ast.Call(ast.Name("float", ast.Load()), [made], []) if name in _ANGULAR else made

    def of_number(self, node: ast.expr) -> ast.expr:
        """Return the number that a text is."""
        pieces = [one.strip() if isinstance(one, str) else one for one in flattened([node])]
        if len(pieces) > 1:
            return self.of_word([one for one in pieces if one != ""])
        only = pieces[0] if pieces and not isinstance(pieces[0], str) else node
        made = self.node(only)
        value = folded(made)
        if isinstance(value, str):
            return number_node(value)
        return ast.Call(ast.Name("float", ast.Load()), [made], []) if self.type(only) == TEXT else made

    def flag(self, node: ast.expr) -> ast.expr:
        """Return a condition of xacro as one that is true or false."""
        if isinstance(node, ast.BoolOp):
            return ast.BoolOp(node.op, [self.truth(item) for item in node.values])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return negated(self.truth(node.operand))
        if isinstance(node, ast.Constant):
            value = literal(node.value)
            return self.constant(bool(value))
        kind = self.type(node)
        if isinstance(node, ast.IfExp) and kind != FLAG:
            return ast.IfExp(self.truth(node.test), self.flag(node.body), self.flag(node.orelse))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__flag":
            return self.flag(node.args[0])
        made = self.node(node)
        if kind == FLAG:
            return made
        if kind == NUMBER:
            return ast.Compare(made, [ast.NotEq()], [ast.Constant(0)])
        if kind == TEXT:
            accepted = ast.List([ast.Constant(one) for one in ("true", "True", "1")], ast.Load())
            return ast.Compare(made, [ast.In()], [accepted])
        return ast.Call(ast.Name("bool", ast.Load()), [made], [])

    def truth(self, node: ast.expr) -> ast.expr:
        """Return what Python takes for true as a condition."""
        if self.type(node) == TEXT and not isinstance(node, ast.Constant):
            return ast.Compare(self.node(node), [ast.NotEq()], [ast.Constant("")])
        return self.flag(node)

    def joined(self, pieces: Pieces) -> ast.expr:
        """Return pieces as an expression for one text."""
        made: ast.expr | None = None
        for piece in pieces:
            item = ast.Constant(piece) if isinstance(piece, str) else self.as_text(piece)
            if isinstance(made, ast.BinOp) and isinstance(made.right, ast.Constant) and isinstance(item, ast.Constant):
                item, made = ast.Constant(made.right.value + item.value), made.left  # type: ignore[operator]
            elif isinstance(made, ast.Constant) and isinstance(item, ast.Constant):
                item, made = ast.Constant(str(made.value) + str(item.value)), None
            made = item if made is None else ast.BinOp(made, ast.Add(), item)
        return made if made is not None else ast.Constant("")

    def as_text(self, node: ast.expr) -> ast.expr:
        """Return a formula as an expression for the text that xacro prints for it."""
        made, kind = self.printed(node), self.type(node)
        value = folded(made)
        if isinstance(value, (str, int)) and not isinstance(value, bool):
            return ast.Constant(str(value))
        if kind == TEXT or (isinstance(made, ast.IfExp) and kind == FLAG):
            return made
        if kind == LIST:
            return ast.Call(ast.Name("join"), [ast.Constant(" "), made], [])
        return ast.Call(ast.Name("str", ast.Load()), [made], [])

    def printed(self, node: ast.expr) -> ast.expr:
        """Return an expression; what is true or false in Python is ``True`` or ``False`` as text."""
        if self.type(node) == FLAG and not self.is_argument(node):
            made = self.node(node)
            decided = folded(made)
            if isinstance(decided, bool):
                return ast.Constant(str(decided))
            return ast.IfExp(made, ast.Constant("True"), ast.Constant("False"))
        return self.node(node)

    def is_argument(self, node: ast.expr) -> bool:
        return isinstance(node, ast.Name) and node.id in self.variables and self.variables[node.id].kind == "argument"

    def as_list(self, node: ast.expr) -> ast.expr:
        """Return a formula as an expression for a list of numbers."""
        if isinstance(node, ast.Constant) and is_list_text(node.value):
            return ast.List([number_node(word) for word in str(node.value).split()], ast.Load())
        if isinstance(node, ast.IfExp):
            return ast.IfExp(self.truth(node.test), self.as_list(node.body), self.as_list(node.orelse))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__join":
            words = in_words(flattened([node]))
            if len(words) > 1:
                return ast.List([self.of_word(word) for word in words], ast.Load())
        if self.type(node) == LIST:
            return self.node(node)
        return ast.Call(ast.Name("numbers", ast.Load()), [self.node(node)], [])

    def of_word(self, word: Pieces) -> ast.expr:
        """Return one number of several that are separated by blanks."""
        sign = isinstance(word[0], str) and word[0] in ("-", "+") and len(word) == 2
        if sign and not isinstance(word[1], str):
            made = self.node(word[1])
            return ast.UnaryOp(ast.USub(), made) if word[0] == "-" else made
        if len(word) == 1:
            return number_node(word[0]) if isinstance(word[0], str) else self.node(word[0])
        return ast.Call(ast.Name("float", ast.Load()), [self.joined(word)], [])


def as_angle(node: ast.expr) -> ast.expr:
    """Return an expression for an angle: functions that return angles are not made plain numbers."""
    is_plain = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "float"
    inner = node.args[0] if is_plain else None  # type: ignore[attr-defined]
    return inner if isinstance(inner, ast.Call) and getattr(inner.func, "id", "") in _ANGULAR else node


def number_node(text: str) -> ast.expr:
    """Return a number in a text as an expression. Raises Unsupported."""
    value = literal(text)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise Unsupported(f'"{text[:40]}" is no number')
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e6:
        value = int(value)
    return ast.UnaryOp(ast.USub(), ast.Constant(-value)) if value < 0 else ast.Constant(value)


def in_words(pieces: Pieces) -> list[Pieces]:
    """Return pieces as the words that blanks separate."""
    words: list[Pieces] = [[]]
    for piece in pieces:
        if not isinstance(piece, str):
            words[-1].append(piece)
            continue
        for index, part in enumerate(re.split(r"\s+", piece)):
            if index:
                words.append([])
            if part:
                words[-1].append(part)
    return [word for word in words if word]


def negated(node: ast.expr) -> ast.expr:
    """Return the opposite of a condition."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return node.operand
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return ast.Name("false" if node.id == "true" else "true", ast.Load())
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        pairs = ((ast.Eq, ast.NotEq), (ast.NotEq, ast.Eq), (ast.In, ast.NotIn), (ast.NotIn, ast.In))
        for kind, opposite in pairs:
            if isinstance(node.ops[0], kind):
                return ast.Compare(node.left, [opposite()], node.comparators)
    return ast.UnaryOp(ast.Not(), node)


def all_of(nodes: list[ast.expr]) -> ast.expr | None:
    """Return the condition that all hold, or None if there is none."""
    found: dict[str, ast.expr] = {}
    for node in nodes:
        decided = folded(node)
        if decided is False:
            return ast.Name("false", ast.Load())
        if decided is not True:
            found.setdefault(written(node), node)
    if not found:
        return None
    return next(iter(found.values())) if len(found) == 1 else ast.BoolOp(ast.And(), [*found.values()])


def folded(node: ast.expr) -> Any:
    """Return the value of an expression without names except constants, or None."""
    names = (one.id for one in ast.walk(node) if isinstance(one, ast.Name))
    if any(name not in ("pi", "e", "tau", "true", "false", "none") and name not in functions() for name in names):
        return None
    if any(
        isinstance(one, ast.Call) and getattr(one.func, "id", "") in ("find", "load", "error") for one in ast.walk(node)
    ):
        return None
    try:
        return evaluate(written(node), _no_names)
    except ExpressionError:
        return None


def _no_names(name: str) -> Any:
    raise KeyError(name)


def written(node: ast.expr) -> str:
    """Return an expression as text of the language."""
    return ast.unparse(ast.fix_missing_locations(node)).strip()

"""Expressions: what xacro evaluates, in the words of the language.

A value of xacro becomes a tree of Python's ``ast`` in which each name is one of ours, and then text again. What has no
word is ``Unsupported``, with the reason.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

from rosorin_compile.language.expression.functions import expression_names

from .scopes import (
    ANY,
    ARGUMENT,
    CONDITION,
    FLAG,
    LIST,
    NUMBER,
    PARAMETER,
    TABLE,
    WORDS,
    Bound,
    Returned,
    Scope,
    Unsaid,
    Value,
    Variable,
    is_plain,
    literal,
    package_in,
    sole_name,
)
from .texts import EXPRESSION, EXTENSION, TEXT, Token, Unsupported, signed, source_tree, tokens, words

_MODULES = ("math", "python")
_SAME = frozenset(
    (
        *("acos", "asin", "atan", "atan2", "ceil", "copysign", "cos", "cosh", "degrees", "exp", "floor", "fmod", "gcd"),
        *("hypot", "isclose", "log", "log10", "log2", "pow", "radians", "sin", "sinh", "sqrt", "tan", "tanh", "trunc"),
        *("abs", "all", "any", "bool", "float", "int", "len", "list", "max", "min", "round", "sorted", "str", "sum"),
        *("range", "reversed", "zip", "enumerate"),
    )
)
_OTHERS = {"fabs": "abs", "fsum": "sum", "tuple": "list"}
_ANGULAR = frozenset(("acos", "asin", "atan", "atan2", "radians"))
_OF_ANGLES = frozenset(("sin", "cos", "tan", "degrees", "float"))
_METHODS = {"get": "get", "keys": "keys", "values": "values", "items": "items", "split": "split", "upper": "upper"}
_METHODS |= {"lower": "lower", "strip": "strip", "replace": "replace", "startswith": "startswith"}
_METHODS |= {"endswith": "endswith"}
_CONSTANTS = {"True": "true", "False": "false", "None": "none"}
MAX_DEPTH = 60

Mark = Callable[[Variable], None]


class Rendering:
    """Makes expressions for one place: ``own`` is what names its own way; ``mark`` hears which variables are used."""

    def __init__(self, mark: Mark, named: Callable[[Variable], ast.expr | None] | None = None) -> None:
        self.mark = mark
        self.named = named or (lambda _: None)
        self.share: Callable[[str], ast.expr] | None = None
        self.returned: Callable[[Returned], ast.expr] | None = None
        self.loaded: Callable[[str, bool], str] = lambda text, _: text

    def begin(self, node: ast.expr) -> None:
        """Give the name of a file that is put together the beginning that it has here."""
        while isinstance(node, ast.BinOp):
            if isinstance(node.left, ast.Constant):
                node.left = ast.Constant(self.loaded(str(node.left.value), True))
                return
            node = node.left

    def value(self, value: Value, depth: int = 0) -> ast.expr:
        """Return the value of a text as an expression. Raises Unsupported."""
        try:
            return self.tree(value.text, value.scope, depth)
        except Unsupported as problem:
            problem.span = problem.span or value.span
            raise

    def tree(self, text: str, scope: Scope, depth: int = 0) -> ast.expr:
        """Return the value of a text as an expression."""
        if depth > MAX_DEPTH:
            raise Unsupported("names lead to names without end")
        pieces = tokens(text)
        if all(piece.kind == TEXT for piece in pieces):
            return _constant(literal(text))
        if len(pieces) == 1:
            return self.piece(pieces[0], scope, depth)
        return self.joined(pieces, scope, depth)

    def joined(self, pieces: list[Token], scope: Scope, depth: int) -> ast.expr:
        """Return a text that is put together."""
        parts = words(pieces)
        if len(parts) > 1 and all(self.is_number(part, scope) for part in parts):
            return ast.List([self.tree(_spelt(part), scope, depth + 1) for part in parts], ast.Load())
        if signed(pieces):
            whole = self.number([(piece, scope) for piece in pieces], depth)
            if whole is not None:
                return whole
        return self.put_together([(piece, scope) for piece in _addressed(pieces)], depth)

    def put_together(self, pieces: list[tuple[Token, Scope]], depth: int) -> ast.expr:
        """Return a text of several pieces."""
        made: ast.expr | None = None
        for piece, scope in pieces:
            item: ast.expr = ast.Constant(piece.text)
            if piece.kind != TEXT:
                node = self.piece(piece, scope, depth)
                item = self.as_text(printed(node) if piece.kind == EXPRESSION else node)
            made = item if made is None else _plus(made, item)
        return made if made is not None else ast.Constant("")

    def number(self, pieces: list[tuple[Token, Scope]], depth: int) -> ast.expr | None:
        """Return a number that is put together from a sign, one value and an exponent; None where it is none."""
        parts = signed([piece for piece, _ in pieces])
        if parts is None:
            return None
        sign, piece, exponent = parts
        node = self.piece(piece, next(scope for one, scope in pieces if one is piece), depth)
        if _is_text(node) or _is_text_or_flag(node):
            return None
        if exponent:
            node = ast.BinOp(bare(node), ast.Mult(), ast.Constant(float(f"1{exponent}")))
        return ast.UnaryOp(ast.USub(), node) if sign == "-" else node

    def is_number(self, part: list[Token], scope: Scope) -> bool:
        """Say whether a word of several is a number, as far as one can see."""
        parts = signed(part)
        if parts is not None:
            return self.is_number([parts[1]], scope)
        if len(part) != 1:
            return False
        if part[0].kind == TEXT:
            return isinstance(literal(part[0].text), (int, float))
        name = sole_name(part)
        found = scope.find(name) if name else None
        if isinstance(found, Bound):
            return self.is_number(tokens(found.text), found.scope) if found.text else False
        return not isinstance(found, Variable) or found.kind() in (NUMBER, ANY)

    def as_text(self, node: ast.expr) -> ast.expr:
        """Return what is to stand in a text."""
        if isinstance(node, ast.Constant):
            return ast.Constant(_worded(node.value))
        if isinstance(node, (ast.BinOp, ast.IfExp)) and _is_text(node):
            return node
        if isinstance(node, (ast.Name, ast.Call)) and _kind_of(node) == WORDS and not getattr(node, "is_open", False):
            return node
        if isinstance(node, ast.List) or _kind_of(node) == LIST:
            return ast.Call(ast.Name("join", ast.Load()), [ast.Constant(" "), node], [])
        return ast.Call(ast.Name("str", ast.Load()), [node], [])

    def piece(self, piece: Token, scope: Scope, depth: int) -> ast.expr:
        """Return the value of an expression or an extension."""
        if piece.kind == EXPRESSION:
            try:
                tree = source_tree(piece.text)
            except ValueError as problem:
                raise Unsupported(f"${{{piece.text}}}: {problem}") from None
            return self.node(tree, scope, depth + 1)
        kind, _, rest = piece.text.strip().partition(" ")
        rest = package_in(piece.text, scope) if kind == "find" else rest.strip()
        if kind == "arg":
            return self.name(f"arg {rest}", scope, depth)
        if kind == "eval":
            return self.node(source_tree(rest), scope, depth + 1)
        if kind == "find" and "${" in rest:
            found = ast.Call(ast.Name("find", ast.Load()), [self.tree(rest, scope, depth + 1)], [])
            found.kind = WORDS  # type: ignore[attr-defined]
            return found
        if kind == "find":
            return self.folder(rest)
        if kind in ("env", "optenv"):
            return self.name(f"env {rest.split()[0]}", scope, depth)
        raise Unsupported(f"$({piece.text}) has no word here")

    def folder(self, package: str) -> ast.expr:
        """Return the folder of a package."""
        if self.share is not None:
            return self.share(package)
        return ast.Constant(f"package://{package}")

    def name(self, name: str, scope: Scope, depth: int) -> ast.expr:
        """Return what a name stands for."""
        found = scope.find(name)
        if isinstance(found, Bound):
            return self.tree(found.text, found.scope, depth + 1)
        if isinstance(found, Variable):
            if found.unsaid:
                raise Unsupported(found.unsaid)
            own = self.named(found)
            if own is not None:
                return own
            if _is_pi(found):
                return ast.Name("pi", ast.Load())
            if found.where != "loop":
                self.mark(found)
            made = ast.Name(found.ours, ast.Load())
            kind = found.kind()
            stays = found.where == ARGUMENT and kind in (LIST, TABLE)  # what the command line gives is text
            made.kind = WORDS if stays else kind  # type: ignore[attr-defined]
            made.is_list = kind == LIST and found.where == PARAMETER  # type: ignore[attr-defined]
            made.is_open = kind == WORDS and found.is_read()  # type: ignore[attr-defined]
            return made
        if isinstance(found, Unsaid):
            raise Unsupported(found.reason)
        if isinstance(found, Returned):
            if self.returned is None:
                raise Unsupported(f'"{name}" is set by a macro')
            return self.returned(found)
        if name in ("pi", "e", "tau", *_CONSTANTS):
            return ast.Name(_CONSTANTS.get(name, name), ast.Load())
        what = "argument" if name.startswith("arg ") else "name"
        raise Unsupported(f'the {what} "{name.removeprefix("arg ")}" is defined nowhere in reach')

    def node(self, node: ast.expr, scope: Scope, depth: int) -> ast.expr:
        """Return a node of an expression with our names and words."""
        match node:
            case ast.Name(id=spelt):
                name = f"arg {spelt.removeprefix('__arg_')}" if spelt.startswith("__arg_") else spelt
                return self.name(name, scope, depth)
            case ast.Constant(value=value):
                if isinstance(value, complex) or value is ... or isinstance(value, bytes):
                    raise Unsupported(f"{ast.unparse(node)} is no value here")
                return _constant(value)
            case ast.List(elts=items) | ast.Tuple(elts=items):
                return ast.List([self.node(item, scope, depth) for item in items], ast.Load())
            case ast.BoolOp(op=op, values=values):
                return _decided(ast.BoolOp(op, [self.node(item, scope, depth) for item in values]))
        taken = self._by_kind.get(type(node))
        if taken is None:
            raise Unsupported(f"{ast.unparse(node)[:60]} has no word here")
        return taken(node, scope, depth)

    @cached_property
    def _by_kind(self) -> Mapping[type[ast.expr], Callable[[Any, Scope, int], ast.expr]]:
        """What takes a node of each other kind."""
        return {
            ast.Attribute: self.attribute,
            ast.Call: self.call,
            ast.BinOp: self.binary,
            ast.UnaryOp: self.unary,
            ast.Compare: lambda node, scope, depth: _decided(self.comparison(node, scope, depth)),
            ast.IfExp: self.choice,
            ast.Subscript: self.subscript,
            ast.ListComp: self.comprehension,
            ast.GeneratorExp: self.comprehension,
        }

    def unary(self, node: ast.UnaryOp, scope: Scope, depth: int) -> ast.expr:
        """Return a number with its sign, or a negated condition (``not``)."""
        operand = self.node(node.operand, scope, depth)
        if isinstance(node.op, ast.Not):
            return _decided(negated(self.truth(operand)))
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise Unsupported(f"{ast.unparse(node)} has no word here")
        return ast.UnaryOp(node.op, operand)

    def choice(self, node: ast.IfExp, scope: Scope, depth: int) -> ast.expr:
        """Return one of two values by a condition, or the one that it is bound to be."""
        test = self.truth(self.node(node.test, scope, depth))
        holds = folded(test)
        if holds is not None:  # what is not chosen may name what is not there
            return self.node(node.body if holds else node.orelse, scope, depth)
        return ast.IfExp(test, self.node(node.body, scope, depth), self.node(node.orelse, scope, depth))

    def binary(self, node: ast.BinOp, scope: Scope, depth: int) -> ast.expr:
        """Return arithmetic, or texts that are joined."""
        left, right = self.node(node.left, scope, depth), self.node(node.right, scope, depth)
        if isinstance(node.op, ast.Add) and _is_plain(left) and _is_plain(right):
            return ast.Constant(left.value + right.value)  # type: ignore[attr-defined]
        if isinstance(node.op, ast.Add) and isinstance(left, ast.Constant) and left.value == "":
            return right
        if isinstance(node.op, ast.Add) and isinstance(right, ast.Constant) and right.value == "":
            return left
        if isinstance(node.op, ast.Mod) and isinstance(left, ast.Constant) and isinstance(left.value, str):
            raise Unsupported(f"{ast.unparse(node)[:60]}: texts are not put together by %")
        if not isinstance(node.op, (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)):
            raise Unsupported(f"{ast.unparse(node)[:60]} has no word here")
        if isinstance(node.op, (ast.Mult, ast.Div, ast.Pow)):
            left, right = bare(left), bare(right)
        return ast.BinOp(left, node.op, right)

    def attribute(self, node: ast.Attribute, scope: Scope, depth: int) -> ast.expr:
        """Return an entry of a table, or a name of a module."""
        if isinstance(node.value, ast.Name) and scope.find(node.value.id) is None:
            if node.value.id in _MODULES:
                return self.name(node.attr, Scope(), depth)
            inside = scope.find(f"{node.value.id}.{node.attr}")
            if inside is not None:
                return self.name(f"{node.value.id}.{node.attr}", scope, depth)
        whole = ast.unparse(node)
        if scope.find(whole) is not None:
            return self.name(whole, scope, depth)
        value = self.node(node.value, scope, depth)
        return _entry(value, node.attr) or ast.Attribute(value, node.attr, ast.Load())

    def subscript(self, node: ast.Subscript, scope: Scope, depth: int) -> ast.expr:
        value = self.node(node.value, scope, depth)
        found = _entry(value, node.slice.value) if isinstance(node.slice, ast.Constant) else None
        if found is not None:
            return found
        if isinstance(node.slice, ast.Slice):
            ends = [None if e is None else self.node(e, scope, depth) for e in (node.slice.lower, node.slice.upper)]
            step = None if node.slice.step is None else self.node(node.slice.step, scope, depth)
            return ast.Subscript(value, ast.Slice(ends[0], ends[1], step), ast.Load())
        return ast.Subscript(value, self.node(node.slice, scope, depth), ast.Load())

    def comprehension(self, node: ast.ListComp | ast.GeneratorExp, scope: Scope, depth: int) -> ast.expr:
        inner = Scope(scope)
        generators = []
        for generator in node.generators:
            iterated = self.node(generator.iter, inner, depth)
            for target in ast.walk(generator.target):
                if isinstance(target, ast.Name):
                    inner.names[target.id] = Variable(target.id, "loop")
            tests = [self.truth(self.node(test, inner, depth)) for test in generator.ifs]
            generators.append(ast.comprehension(generator.target, iterated, tests, 0))
        return ast.ListComp(self.node(node.elt, inner, depth), generators)

    def comparison(self, node: ast.Compare, scope: Scope, depth: int) -> ast.expr:
        """Return a comparison; of a flag with the text "true" the flag."""
        left = self.node(node.left, scope, depth)
        others = [self.node(item, scope, depth) for item in node.comparators]
        if any(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops):
            raise Unsupported(f"{ast.unparse(node)[:60]} has no word here")
        if len(others) == 1 and isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
            for one, other in ((left, others[0]), (others[0], left)):
                if _kind_of(one) == FLAG and isinstance(other, ast.Constant) and other.value in ("true", "True"):
                    return one if isinstance(node.ops[0], ast.Eq) else negated(one)
                if _kind_of(one) == FLAG and isinstance(other, ast.Constant) and other.value in ("false", "False"):
                    return negated(one) if isinstance(node.ops[0], ast.Eq) else one
                if _kind_of(one) == FLAG and isinstance(other, ast.Constant) and other.value in (0, 1):
                    wanted = bool(other.value) == isinstance(node.ops[0], ast.Eq)
                    return one if wanted else negated(one)
        return ast.Compare(left, node.ops, others)

    def call(self, node: ast.Call, scope: Scope, depth: int) -> ast.expr:
        """Return a call of a function."""
        if isinstance(node.func, ast.Name) and node.func.id == "dict" and node.keywords and not node.args:
            keys: list[ast.expr | None] = [ast.Constant(one.arg) for one in node.keywords]
            return ast.Dict(keys, [self.node(one.value, scope, depth) for one in node.keywords])
        if node.keywords or any(isinstance(item, ast.Starred) for item in node.args):
            raise Unsupported(f"{ast.unparse(node)[:60]} has no word here")
        given = [self.node(item, scope, depth) for item in node.args]
        function = node.func
        if isinstance(function, ast.Attribute):
            owner = function.value
            if isinstance(owner, ast.Name) and owner.id == "xacro" and scope.find("xacro") is None:
                return self.of_xacro(function.attr, given, scope, depth)
            if isinstance(owner, ast.Name) and owner.id in _MODULES and scope.find(owner.id) is None:
                return self.function(function.attr, given)
            return self.method(function, given, scope, depth)
        if not isinstance(function, ast.Name):
            raise Unsupported(f"{ast.unparse(node)[:60]} has no word here")
        if function.id == "__text":
            return self.as_text(given[0]) if _kind_of(given[0]) != FLAG else given[0]
        if function.id in ("load_yaml", "abs_filename", "dotify"):
            return self.of_xacro(function.id, given, scope, depth)
        return self.function(function.id, given)

    def of_xacro(self, name: str, given: list[ast.expr], scope: Scope, depth: int) -> ast.expr:
        """Return what stands for a function of xacro's own."""
        if name == "load_yaml":
            if len(given) == 1 and isinstance(given[0], ast.Constant):
                given = [ast.Constant(self.loaded(str(given[0].value), False))]
            elif len(given) == 1 and _is_text(given[0]):
                self.begin(given[0])
            return ast.Call(ast.Name("load", ast.Load()), given, [])
        if name == "dotify" and len(given) == 1:
            return given[0]
        if name == "arg" and len(given) == 1 and isinstance(given[0], ast.Constant):
            return self.name(f"arg {given[0].value!s}", scope, depth)
        if name == "fatal":
            return ast.Call(ast.Name("error", ast.Load()), given, [])
        raise Unsupported(f"xacro.{name}() has no word here")

    def function(self, name: str, given: list[ast.expr]) -> ast.expr:
        """Return a function of Python or of mathematics."""
        ours = _OTHERS.get(name, name)
        if ours not in _SAME:
            raise Unsupported(f"{name}() has no word here")
        if ours == "str" and len(given) == 1:
            return self.as_text(printed(given[0]))
        if ours in _OF_ANGLES and len(given) == 1:
            return ast.Call(ast.Name(ours, ast.Load()), given, [])
        return ast.Call(ast.Name(ours, ast.Load()), [bare(item) for item in given], [])

    def method(self, function: ast.Attribute, given: list[ast.expr], scope: Scope, depth: int) -> ast.expr:
        """Return a method of a text or a table."""
        owner = self.node(function.value, scope, depth)
        several = isinstance(owner, ast.List) or _kind_of(owner) == LIST
        if function.attr == "split" and several and all(_is_blank(one) for one in given):
            return owner  # several numbers are a list here
        if function.attr == "join":
            return ast.Call(ast.Name("join", ast.Load()), [owner, *given], [])
        if function.attr not in _METHODS:
            raise Unsupported(f".{function.attr}() has no word here")
        return ast.Call(ast.Name(_METHODS[function.attr], ast.Load()), [owner, *given], [])

    def condition(self, value: Value) -> ast.expr:
        """Return a condition of xacro as one that is true or false."""
        node = self.value(value)
        if isinstance(node, ast.Constant) and node.value in _FLAGS:
            return ast.Constant(_FLAGS[node.value])
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            raise Unsupported(f'the condition "{value.text}" is neither true nor false', value.span)
        return self.flag(node)

    def flag(self, node: ast.expr) -> ast.expr:
        """Return whether a condition of xacro holds, which may be a text such as "true"."""
        if _kind_of(node) == WORDS:
            return ast.Compare(node, [ast.In()], [ast.List([ast.Constant(one) for one in _TRUE], ast.Load())])
        return self.truth(node)

    def truth(self, node: ast.expr) -> ast.expr:
        """Return what is true or false of what Python takes for it."""
        if isinstance(node, ast.Constant):
            return ast.Constant(bool(node.value))
        kind = _kind_of(node)
        if kind == NUMBER:
            return ast.Compare(node, [ast.NotEq()], [ast.Constant(0)])
        if kind == WORDS:
            return ast.Compare(node, [ast.NotEq()], [ast.Constant("")])
        if isinstance(node, ast.BoolOp):
            return ast.BoolOp(node.op, [self.truth(item) for item in node.values])
        if kind in (LIST, ANY) or (isinstance(node, (ast.BinOp, ast.Call, ast.List)) and not _is_boolean(node)):
            return ast.Call(ast.Name("bool", ast.Load()), [node], [])
        return node


_TRUE = ("true", "True", "1")
_FLAGS = {"true": True, "True": True, "false": False, "False": False}


def _is_boolean(node: ast.expr) -> bool:
    called = isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return called and node.func.id in ("bool", "all", "any", "startswith", "endswith", "isclose")  # type: ignore


def _addressed(pieces: list[Token]) -> list[Token]:
    """Return pieces in which the folder of a package behind ``file://`` is the address of the package."""
    if len(pieces) < 2 or pieces[0] != Token(TEXT, "file://") or pieces[1].kind != EXTENSION:
        return pieces
    kind, _, package = pieces[1].text.strip().partition(" ")
    return [Token(TEXT, "package://"), *tokens(package.strip()), *pieces[2:]] if kind == "find" else pieces


def _entry(table: ast.expr, key: Any) -> ast.expr | None:
    """Return an entry of a table that stands in an expression: none can in ours."""
    for one, value in zip(table.keys, table.values, strict=True) if isinstance(table, ast.Dict) else ():
        if isinstance(one, ast.Constant) and one.value == key:
            return value
    return None


def _decided(node: ast.expr) -> ast.expr:
    """Return what is true or false whatever else is as that; another expression as it is."""
    if isinstance(node, ast.BoolOp):
        wins = isinstance(node.op, ast.Or)
        known = [folded(item) for item in node.values]
        if not all(
            isinstance(value, bool) or _is_true_or_false(item) for item, value in zip(node.values, known, strict=True)
        ):
            return node
        if wins in known:
            return ast.Constant(wins)
        left = [item for item, value in zip(node.values, known, strict=True) if value is None]
        return ast.BoolOp(node.op, left) if len(left) > 1 else left[0] if left else ast.Constant(not wins)
    value = folded(node)
    return ast.Constant(value) if isinstance(value, bool) else node


def _is_blank(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str) and not node.value.strip()


def _kind_of(node: ast.expr) -> str:
    return str(getattr(node, "kind", ""))


def _is_text_or_flag(node: ast.expr) -> bool:
    return _kind_of(node) in (WORDS, FLAG, LIST, TABLE) or isinstance(node, (ast.Compare, ast.List))


def printed(node: ast.expr) -> ast.expr:
    """Return what is true or false as xacro prints it, ``True`` or ``False``; anything else as it is.

    Readers of SDF and of ros2_control take both spellings where they read a boolean; a plug-in that compares the text
    of its parameter by itself does not. So the two are not the same to the proof, and the spelling is kept.
    """
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return ast.Constant(str(node.value))
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return ast.Constant(node.id.capitalize())
    if not _is_true_or_false(node):
        return node
    return ast.IfExp(node, ast.Constant("True"), ast.Constant("False"))


def _is_true_or_false(node: ast.expr) -> bool:
    if isinstance(node, ast.BoolOp):
        return all(map(_is_true_or_false, node.values))
    return (
        _kind_of(node) == FLAG
        or isinstance(node, ast.Compare)
        or _is_boolean(node)
        or (isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not))
    )


def _is_text(node: ast.expr) -> bool:
    if isinstance(node, ast.IfExp):
        return _is_text(node.body) and _is_text(node.orelse)
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, ast.Add) and (_is_text(node.left) or _is_text(node.right))
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in ("str", "join", "upper", "lower", "replace", "find")
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _is_pi(variable: Variable) -> bool:
    """Say whether a property is another name for pi."""
    if variable.where != "global" or len(variable.values) != 1:
        return False
    text = variable.values[0].text
    return is_plain(text) and literal(text) == math.pi


def bare(node: ast.expr) -> ast.expr:
    """Return an angle that a function gives as a plain number, for where no angle stands."""
    if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
        return ast.UnaryOp(node.op, bare(node.operand))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _ANGULAR:
        return ast.Call(ast.Name("float", ast.Load()), [node], [])
    return node


def _constant(value: Any, whole: bool = False) -> ast.expr:
    if isinstance(value, list):
        return ast.List([_constant(item, whole=True) for item in value], ast.Load())
    if isinstance(value, bool):
        return ast.Constant(value)
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e6:
        value = int(value) if whole else value
    if isinstance(value, float) and not math.isfinite(value):
        raise Unsupported("nan and inf are no values here")
    if isinstance(value, (int, float)) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    return ast.Constant(value)


def _is_plain(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _plus(one: ast.expr, other: ast.expr) -> ast.expr:
    if isinstance(one, ast.Constant) and isinstance(other, ast.Constant):
        return ast.Constant(str(one.value) + str(other.value))
    if isinstance(one, ast.BinOp) and isinstance(one.op, ast.Add) and _is_plain(one.right) and _is_plain(other):
        return ast.BinOp(one.left, ast.Add(), _plus(one.right, other))
    return ast.BinOp(one, ast.Add(), other)


def _spelt(part: list[Token]) -> str:
    signs = {TEXT: "{}", EXPRESSION: "${{{}}}"}
    return "".join(signs.get(piece.kind, "$({})").format(piece.text) for piece in part)


def _worded(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


def negated(node: ast.expr) -> ast.expr:
    """Return the opposite of a condition."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return node.operand
    if isinstance(node, ast.Constant):
        return ast.Constant(not node.value)
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for one, other in ((ast.Eq, ast.NotEq), (ast.In, ast.NotIn)):
            if isinstance(node.ops[0], one):
                return ast.Compare(node.left, [other()], node.comparators)
            if isinstance(node.ops[0], other):
                return ast.Compare(node.left, [one()], node.comparators)
    return ast.UnaryOp(ast.Not(), node)


def all_of(nodes: list[ast.expr]) -> ast.expr | None:
    """Return the condition that all hold; None if there is none."""
    found: list[ast.expr] = []
    for node in nodes:
        if isinstance(node, ast.Constant):
            if not node.value:
                return ast.Constant(False)
            continue
        if not any(ast.dump(node) == ast.dump(other) for other in found):
            found.append(node)
    if not found:
        return None
    return found[0] if len(found) == 1 else ast.BoolOp(ast.And(), found)


def folded(node: ast.expr) -> Any:
    """Return the value of an expression without names but constants; None if it has others, or no value."""
    if any(
        isinstance(one, ast.Name) and one.id not in ("pi", "e", "tau", *expression_names().functions)
        for one in ast.walk(node)
    ):
        return None
    from rosorin_compile.language.expression import ExpressionError, evaluate

    try:
        return evaluate(written(node), _nothing)
    except ExpressionError:
        return None


def _nothing(name: str) -> Any:
    raise KeyError(name)


def written(node: ast.expr) -> str:
    """Return an expression as text of the language."""
    return ast.unparse(_Spelling().visit(ast.fix_missing_locations(ast.Expression(_copied(node))))).strip()


def _copied(node: Any) -> Any:
    from copy import deepcopy

    return deepcopy(node)


class _Spelling(ast.NodeTransformer):
    """True, False and None as the language spells them; names as they are."""

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if node.value is None or isinstance(node.value, bool):
            return ast.Name({None: "none", True: "true", False: "false"}[node.value], ast.Load())
        return node


def usable(name: str, taken: Callable[[str], bool]) -> str:
    """Return a name that expressions can have: no word of Python or of the language, and not taken."""
    import keyword

    made = re.sub(r"\W", "_", name, flags=re.ASCII) or "value"
    made = f"_{made}" if made[0].isdigit() else made
    if keyword.iskeyword(made) or made in ("true", "false", "none", "for"):
        made = f"{made}_"
    number, wanted = 1, made
    while taken(made):
        number += 1
        made = f"{wanted}_{number}"
    return made


__all__ = ["CONDITION", "LIST", "TABLE", "Rendering", "all_of", "folded", "negated", "written"]

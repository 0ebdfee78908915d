"""Translate resolved expressions of xacro to expressions of the language.

A node of the result may have the attributes ``kind`` (what its variable holds), ``is_list`` (a parameter that is a
list) and ``is_open`` (an entry of a table, which may be a text or a number).
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from typing import Any

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.language.expression.functions import functions

from .texts import EXPRESSION, TEXT, Unsupported
from .tree import (
    ANY,
    ARGUMENT,
    FLAG,
    FOLDER,
    GLOBAL,
    LIST,
    LOCAL,
    NUMBER,
    PARAMETER,
    TABLE,
    WORDS,
    Joined,
    Piece,
    Ref,
    Text,
    Variable,
    literal,
    signed,
    words,
)

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
_METHODS = frozenset(("get", "keys", "values", "items", "split", "upper", "lower", "strip", "replace"))
_METHODS |= {"startswith", "endswith"}
_BOOLEAN = frozenset(("bool", "all", "any", "startswith", "endswith", "isclose"))
_TEXTUAL = frozenset(("str", "join", "upper", "lower", "replace", "find"))
_CONSTANTS = {"True": "true", "False": "false", "None": "none"}
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod, ast.Pow)


class Translator:
    """Translates expressions. ``mark`` is called with each variable that is used; ``named`` may replace one.

    ``loaded`` returns the name of a file that is loaded, or of its beginning; ``folder`` the folder of a package.
    """

    def __init__(self, mark: Callable[[Variable], object], named: Callable[[Variable], ast.expr | None]) -> None:
        self.mark = mark
        self.named = named
        self.loaded: Callable[[str, bool], str] = lambda text, _: text
        self.folder: Callable[[str], ast.expr] = lambda package: ast.Constant(f"package://{package}")

    def text(self, text: Text) -> ast.expr:
        """Return a text as an expression. Raises Unsupported."""
        try:
            return self.pieces(text.pieces)
        except Unsupported as problem:
            problem.span = problem.span or text.span
            raise

    def pieces(self, pieces: list[Piece]) -> ast.expr:
        if all(piece.kind == TEXT for piece in pieces):
            return number_node(literal("".join(piece.value for piece in pieces)))
        if len(pieces) == 1:
            return self.piece(pieces[0])
        parts = words(pieces)
        if len(parts) > 1 and all(map(self.is_number, parts)):
            return ast.List([self.pieces(part) for part in parts], ast.Load())
        return self.number(pieces) or self.put_together(pieces)

    def piece(self, piece: Piece) -> ast.expr:
        if piece.kind == TEXT:
            return ast.Constant(piece.value)
        if piece.kind == FOLDER:
            return self.folder(piece.value)
        return self.node(piece.value)

    def put_together(self, pieces: list[Piece]) -> ast.expr:
        """Return a text of several pieces."""
        made: ast.expr | None = None
        if pieces[0] == (TEXT, "file://") and pieces[1].kind == FOLDER:
            pieces = [Piece(TEXT, f"package://{pieces[1].value}"), *pieces[2:]]
        for piece in pieces:
            item: ast.expr = ast.Constant(piece.value)
            if piece.kind != TEXT:
                node = self.piece(piece)
                item = as_text(printed(node) if piece.kind == EXPRESSION else node)
            made = item if made is None else _plus(made, item)
        return made if made is not None else ast.Constant("")

    def number(self, pieces: list[Piece]) -> ast.expr | None:
        """Return a number that is put together from a sign, one value and an exponent, or None."""
        parts = signed(pieces)
        if parts is None:
            return None
        sign, piece, exponent = parts
        node = self.piece(piece)
        if is_text(node) or kind_of(node) in (WORDS, FLAG, LIST, TABLE) or isinstance(node, (ast.Compare, ast.List)):
            return None
        if exponent:
            node = ast.BinOp(bare(node), ast.Mult(), ast.Constant(float(f"1{exponent}")))
        return ast.UnaryOp(ast.USub(), node) if sign == "-" else node

    def is_number(self, part: list[Piece]) -> bool:
        """Return True if a word of several is a number, as far as its kind is known."""
        parts = signed(part)
        if parts is not None:
            part = [parts[1]]
        if len(part) != 1 or part[0].kind == FOLDER:
            return False
        if part[0].kind == TEXT:
            return isinstance(literal(part[0].value), (int, float))
        node = part[0].value
        return not isinstance(node, Ref) or node.variable.kind() in (NUMBER, ANY)

    def node(self, node: ast.expr) -> ast.expr:
        """Return a resolved node in the words of the language."""
        if isinstance(node, Ref):
            return self.reference(node.variable)
        if isinstance(node, Joined):
            return self.pieces(node.pieces)
        if isinstance(node, ast.Name):
            return ast.Name(_CONSTANTS.get(node.id, node.id), ast.Load())
        if isinstance(node, ast.Constant):
            if isinstance(node.value, (complex, bytes)) or node.value is ...:
                raise Unsupported(f"{ast.unparse(node)} is no value of the language")
            return number_node(node.value)
        if isinstance(node, (ast.List, ast.Tuple)):
            made: Any = ast.List([self.node(item) for item in node.elts], ast.Load())
            made.text = getattr(node, "text", None)
            return made  # type: ignore[no-any-return]
        if isinstance(node, ast.BoolOp):
            return _decided(ast.BoolOp(node.op, [self.node(item) for item in node.values]))
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise _unsupported(node)
        return method(node)  # type: ignore[no-any-return]

    def reference(self, variable: Variable) -> ast.expr:
        replaced = self.named(variable)
        if replaced is not None:
            return replaced
        plain = variable.values[0].plain if variable.where == GLOBAL and len(variable.values) == 1 else None
        if plain is not None and literal(plain) == math.pi:
            return ast.Name("pi", ast.Load())
        self.mark(variable)
        made: Any = ast.Name(variable.ours, ast.Load())
        kind = variable.kind()
        is_argument_text = variable.where == ARGUMENT and kind in (LIST, TABLE)  # the command line gives texts
        made.kind = WORDS if is_argument_text else kind
        made.is_list = kind == LIST and variable.where == PARAMETER
        made.is_open = kind in (WORDS, LIST) and variable.is_entry()
        return made  # type: ignore[no-any-return]

    def _dict(self, node: ast.Dict) -> ast.expr:
        keys = [None if key is None else self.node(key) for key in node.keys]
        return ast.Dict(keys, [self.node(value) for value in node.values])

    def _unaryop(self, node: ast.UnaryOp) -> ast.expr:
        operand = self.node(node.operand)
        if isinstance(node.op, ast.Not):
            return _decided(negated(truth(operand)))
        if not isinstance(node.op, (ast.USub, ast.UAdd)):
            raise _unsupported(node)
        return ast.UnaryOp(node.op, operand)

    def _ifexp(self, node: ast.IfExp) -> ast.expr:
        test = truth(self.node(node.test))
        holds = folded(test)
        if holds is not None:  # what is not chosen may name what is not there
            return self.node(node.body if holds else node.orelse)
        return ast.IfExp(test, self.node(node.body), self.node(node.orelse))

    def _binop(self, node: ast.BinOp) -> ast.expr:
        """Return arithmetic, or texts that are joined."""
        if isinstance(node.op, ast.Mod) and isinstance(node.left, ast.Constant) and isinstance(node.left.value, str):
            raise Unsupported(f"{_shown(node)}: texts are not put together by %")
        left, right = self.node(node.left), self.node(node.right)
        if isinstance(node.op, ast.Add):
            if _is_plain(left) and _is_plain(right):
                return ast.Constant(left.value + right.value)  # type: ignore[attr-defined]
            if isinstance(left, ast.Constant) and left.value == "":
                return right
            if isinstance(right, ast.Constant) and right.value == "":
                return left
        if not isinstance(node.op, _ARITHMETIC):
            raise _unsupported(node)
        if isinstance(node.op, (ast.Mult, ast.Div, ast.Pow)):
            left, right = bare(left), bare(right)
        return ast.BinOp(left, node.op, right)

    def _attribute(self, node: ast.Attribute) -> ast.expr:
        value = self.node(node.value)
        return _entry(value, node.attr) or ast.Attribute(value, node.attr, ast.Load())

    def _subscript(self, node: ast.Subscript) -> ast.expr:
        value, index = self.node(node.value), node.slice
        if isinstance(index, ast.Constant) and (found := _entry(value, index.value)) is not None:
            return found
        if isinstance(index, ast.Slice):
            ends = [None if end is None else self.node(end) for end in (index.lower, index.upper, index.step)]
            return ast.Subscript(value, ast.Slice(*ends), ast.Load())
        return ast.Subscript(value, self.node(index), ast.Load())

    def _listcomp(self, node: ast.ListComp | ast.GeneratorExp) -> ast.expr:
        generators = [
            ast.comprehension(one.target, self.node(one.iter), [truth(self.node(test)) for test in one.ifs], 0)
            for one in node.generators
        ]
        return ast.ListComp(self.node(node.elt), generators)

    _generatorexp = _listcomp

    def _compare(self, node: ast.Compare) -> ast.expr:
        """Return a comparison; of a flag with true or false the flag."""
        if any(isinstance(op, (ast.Is, ast.IsNot)) for op in node.ops):
            raise _unsupported(node)
        left, others = self.node(node.left), [self.node(item) for item in node.comparators]
        if len(others) == 1 and isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
            for flag, other in ((left, others[0]), (others[0], left)):
                value = other.value if isinstance(other, ast.Constant) else None
                value = _FLAGS.get(value, value) if isinstance(value, str) else value
                if kind_of(flag) == FLAG and isinstance(value, (bool, int)) and value in (0, 1):
                    return flag if bool(value) == isinstance(node.ops[0], ast.Eq) else negated(flag)
        return _decided(ast.Compare(left, node.ops, others))

    def _call(self, node: ast.Call) -> ast.expr:
        function = node.func
        owner = function.value if isinstance(function, ast.Attribute) else None
        name = function.id if isinstance(function, ast.Name) else getattr(function, "attr", "")
        if owner is None and name == "dict" and node.keywords and not node.args:
            keys: list[ast.expr | None] = [ast.Constant(one.arg) for one in node.keywords]
            return ast.Dict(keys, [self.node(one.value) for one in node.keywords])
        if node.keywords or any(isinstance(item, ast.Starred) for item in node.args) or not name:
            raise _unsupported(node)
        given = [self.node(item) for item in node.args]
        if owner is None and name == "__text":
            return as_text(given[0]) if kind_of(given[0]) != FLAG else given[0]
        if owner is None and name == "__flag":
            return flag_of(given[0])
        if owner is None and name == "find":
            found: Any = ast.Call(ast.Name("find", ast.Load()), given, [])
            found.kind = WORDS
            return found  # type: ignore[no-any-return]
        of_xacro = isinstance(owner, ast.Name) and not isinstance(owner, Ref) and owner.id == "xacro"
        if of_xacro or (owner is None and name in ("load_yaml", "abs_filename", "dotify")):
            return self.of_xacro(name, given)
        if owner is None or (isinstance(owner, ast.Name) and not isinstance(owner, Ref) and owner.id in _MODULES):
            return _function(name, given)
        return self.method(name, self.node(owner), given)

    def of_xacro(self, name: str, given: list[ast.expr]) -> ast.expr:
        """Return what corresponds to a function of xacro itself."""
        if name == "load_yaml" and len(given) == 1:
            if isinstance(given[0], ast.Constant):
                given = [ast.Constant(self.loaded(str(given[0].value), False))]
            else:
                begin: ast.AST = given[0]
                while isinstance(begin, ast.BinOp):
                    if isinstance(begin.left, ast.Constant):
                        begin.left = ast.Constant(self.loaded(str(begin.left.value), True))
                    begin = begin.left
            return ast.Call(ast.Name("load", ast.Load()), given, [])
        if name == "dotify" and len(given) == 1:
            return given[0]
        if name == "fatal":
            return ast.Call(ast.Name("error", ast.Load()), given, [])
        raise Unsupported(f"xacro.{name}() cannot be translated")

    def method(self, name: str, owner: ast.expr, given: list[ast.expr]) -> ast.expr:
        """Return a method of a text or a table."""
        is_list = isinstance(owner, ast.List) or kind_of(owner) == LIST
        if name == "split" and is_list and all(_is_plain(one) and not one.value.strip() for one in given):  # type: ignore
            return owner
        if name != "join" and name not in _METHODS:
            raise Unsupported(f".{name}() cannot be translated")
        return ast.Call(ast.Name(name, ast.Load()), [owner, *given], [])

    def condition(self, text: Text) -> ast.expr:
        """Return a condition of xacro as one that is true or false."""
        node = self.text(text)
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            if node.value not in _FLAGS:
                raise Unsupported("a condition is neither true nor false", text.span)
            return ast.Constant(_FLAGS[node.value])
        return flag_of(node)


def _function(name: str, given: list[ast.expr]) -> ast.expr:
    """Return a function of Python or of its mathematics."""
    ours = _OTHERS.get(name, name)
    if ours not in _SAME:
        raise Unsupported(f"{name}() cannot be translated")
    if ours == "str" and len(given) == 1:
        return as_text(printed(given[0]))
    if not (ours in _OF_ANGLES and len(given) == 1):
        given = [bare(item) for item in given]
    return ast.Call(ast.Name(ours, ast.Load()), given, [])


def _shown(node: ast.expr) -> str:
    return ast.unparse(ast.fix_missing_locations(_Plain().visit(_copied(node))))[:60]


def _unsupported(node: ast.expr) -> Unsupported:
    return Unsupported(f"{_shown(node)} cannot be translated")


def kind_of(node: ast.expr) -> str:
    """Return the kind of the variable that a node is, or nothing."""
    return str(getattr(node, "kind", "") or "") if not isinstance(node, ast.Constant) else ""


def number_node(value: Any) -> ast.expr:
    """Return a constant as an expression; several numbers as a list."""
    if isinstance(value, list):
        items = [int(item) if float(item).is_integer() and abs(item) < 1e6 else item for item in value]
        return ast.List([number_node(item) for item in items], ast.Load())
    if isinstance(value, float) and not math.isfinite(value):
        raise Unsupported("nan and inf are no values of the language")
    if isinstance(value, (int, float)) and not isinstance(value, bool) and value < 0:
        return ast.UnaryOp(ast.USub(), ast.Constant(-value))
    return ast.Constant(value)


def as_text(node: ast.expr) -> ast.expr:
    """Return a value as a text."""
    if isinstance(node, ast.Constant):
        return ast.Constant(str(node.value).lower() if isinstance(node.value, bool) else str(node.value))
    if isinstance(node, (ast.BinOp, ast.IfExp)) and is_text(node):
        return node
    if isinstance(node, (ast.Name, ast.Call)) and kind_of(node) == WORDS and not getattr(node, "is_open", False):
        return node
    if isinstance(node, ast.List) or (kind_of(node) == LIST and not getattr(node, "is_open", False)):
        return ast.Call(ast.Name("join", ast.Load()), [ast.Constant(" "), node], [])
    return ast.Call(ast.Name("str", ast.Load()), [node], [])


def numbers_as_text(node: ast.expr) -> ast.expr:
    """Return a choice between texts of several numbers as one between texts."""
    if isinstance(node, ast.IfExp):
        return ast.IfExp(node.test, numbers_as_text(node.body), numbers_as_text(node.orelse))
    text = getattr(node, "text", None)
    return ast.Constant(text) if isinstance(node, ast.List) and text else node


def flag_of(node: ast.expr) -> ast.expr:
    """Return whether a condition of xacro holds, which may be a text such as "true"."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in _FLAGS:
        return ast.Constant(_FLAGS[node.value])
    if kind_of(node) == WORDS:
        return ast.Compare(
            node, [ast.In()], [ast.List([ast.Constant(one) for one in ("true", "True", "1")], ast.Load())]
        )
    return truth(node)


def truth(node: ast.expr) -> ast.expr:
    """Return true or false for what Python takes for it."""
    if isinstance(node, ast.Constant):
        return ast.Constant(bool(node.value))
    kind = kind_of(node)
    if kind == NUMBER:
        return ast.Compare(node, [ast.NotEq()], [ast.Constant(0)])
    if kind == WORDS:
        return ast.Compare(node, [ast.NotEq()], [ast.Constant("")])
    if isinstance(node, ast.BoolOp):
        return ast.BoolOp(node.op, [truth(item) for item in node.values])
    if kind in (LIST, ANY) or (isinstance(node, (ast.BinOp, ast.Call, ast.List)) and not _is_boolean_call(node)):
        return ast.Call(ast.Name("bool", ast.Load()), [node], [])
    return node


def _is_boolean_call(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _BOOLEAN


def is_flag(node: ast.expr) -> bool:
    """Return True if a node is true or false."""
    if isinstance(node, ast.BoolOp):
        return all(map(is_flag, node.values))
    is_not = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
    return kind_of(node) == FLAG or isinstance(node, ast.Compare) or _is_boolean_call(node) or is_not


def printed(node: ast.expr) -> ast.expr:
    """Return what is true or false as xacro prints it, ``True`` or ``False``; anything else as it is.

    Readers of SDF take both spellings; a plug-in that compares the text of its parameter does not.
    """
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return ast.Constant(str(node.value))
    if isinstance(node, ast.Name) and node.id in ("true", "false"):
        return ast.Constant(node.id.capitalize())
    return ast.IfExp(node, ast.Constant("True"), ast.Constant("False")) if is_flag(node) else node


def is_text(node: ast.expr) -> bool:
    """Return True if a node is a text."""
    if isinstance(node, ast.IfExp):
        return is_text(node.body) and is_text(node.orelse)
    if isinstance(node, ast.BinOp):
        return isinstance(node.op, ast.Add) and (is_text(node.left) or is_text(node.right))
    if isinstance(node, ast.Call):
        return isinstance(node.func, ast.Name) and node.func.id in _TEXTUAL
    return _is_plain(node)


def _is_plain(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _plus(left: ast.expr, right: ast.expr) -> ast.expr:
    if isinstance(left, ast.Constant) and isinstance(right, ast.Constant):
        return ast.Constant(str(left.value) + str(right.value))
    if isinstance(left, ast.BinOp) and isinstance(left.op, ast.Add) and _is_plain(left.right) and _is_plain(right):
        return ast.BinOp(left.left, ast.Add(), _plus(left.right, right))
    return ast.BinOp(left, ast.Add(), right)


def bare(node: ast.expr) -> ast.expr:
    """Return an angle that a function gives as a plain number."""
    if isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Not):
        return ast.UnaryOp(node.op, bare(node.operand))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in _ANGULAR:
        return ast.Call(ast.Name("float", ast.Load()), [node], [])
    return node


def _entry(table: ast.expr, key: Any) -> ast.expr | None:
    """Return an entry of a table that is written in an expression: the language has none there."""
    for one, value in zip(table.keys, table.values, strict=True) if isinstance(table, ast.Dict) else ():
        if isinstance(one, ast.Constant) and one.value == key:
            return value
    return None


def _decided(node: ast.expr) -> ast.expr:
    """Return true or false where the result depends on no name, else the node."""
    if not isinstance(node, ast.BoolOp):
        value = folded(node)
        return ast.Constant(value) if isinstance(value, bool) else node
    wins = isinstance(node.op, ast.Or)
    values = [folded(item) for item in node.values]
    if not all(isinstance(value, bool) or is_flag(item) for item, value in zip(node.values, values, strict=True)):
        return node
    if wins in values:
        return ast.Constant(wins)
    left = [item for item, value in zip(node.values, values, strict=True) if value is None]
    return ast.BoolOp(node.op, left) if len(left) > 1 else left[0] if left else ast.Constant(not wins)


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
        elif not any(ast.dump(node) == ast.dump(other) for other in found):
            found.append(node)
    if not found:
        return None
    return found[0] if len(found) == 1 else ast.BoolOp(ast.And(), found)


def folded(node: ast.expr) -> Any:
    """Return the value of an expression without names except constants, or None."""
    names = (one.id for one in ast.walk(node) if isinstance(one, ast.Name))
    if any(name not in ("pi", "e", "tau", "true", "false", "none") and name not in functions() for name in names):
        return None
    try:
        return evaluate(written(node), _no_names)
    except ExpressionError:
        return None


def _no_names(name: str) -> Any:
    raise KeyError(name)


def folded_text(text: Text) -> bool | None:
    """Return whether a condition holds whatever the arguments and parameters are, or None."""

    def constant(variable: Variable) -> ast.expr | None:
        is_property = variable.where in (GLOBAL, LOCAL) and len(variable.values) >= 1 and not variable.pending
        return translator.text(variable.values[0]) if is_property else None

    translator = Translator(lambda _: None, constant)
    try:
        value = folded(translator.condition(text))
    except (Unsupported, RecursionError):
        return None
    return None if value is None else bool(value)


def written(node: ast.expr) -> str:
    """Return an expression as text of the language."""
    return ast.unparse(ast.fix_missing_locations(ast.Expression(_Plain().visit(_copied(node))))).strip()


def _copied(node: Any) -> Any:
    """Return a copy of a tree, with plain names for references."""
    if isinstance(node, Ref):
        return ast.Name(node.variable.ours, ast.Load())
    if isinstance(node, Joined):
        return ast.JoinedStr([])
    if isinstance(node, list):
        return [_copied(item) for item in node]
    if not isinstance(node, ast.AST):
        return node
    return type(node)(**{name: _copied(getattr(node, name, None)) for name in node._fields})


class _Plain(ast.NodeTransformer):
    """True, False and None in the spelling of the language."""

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if node.value is None or isinstance(node.value, bool):
            return ast.Name(str(node.value).lower(), ast.Load())
        return node

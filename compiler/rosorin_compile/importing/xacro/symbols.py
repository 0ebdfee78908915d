"""Formulas: the values of expressions while xacro runs with symbols.

A ``Symbol`` is a formula with an example of its value. ``Evaluator`` evaluates an expression of xacro in a table of
symbols. This module runs in the child process.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .symbolic import Program

TOKEN = re.compile("\ua657(\\d+)\ua657")  # a letter that no file uses: a token is a name in an expression
UNKNOWN = object()  # an example that cannot be computed
_FUNCTIONS = """
    abs acos all any asin atan atan2 bool ceil copysign cos cosh degrees enumerate exp float floor fmod gcd hypot int
    isclose len list log log10 log2 max min pow radians range reversed round sin sinh sorted sqrt str sum tan tanh
    trunc zip
"""  # of Python and of its mathematics that the language has too
_METHODS = "endswith get items join keys lower replace split startswith strip upper values"


class Restart(Exception):
    """Something has to be added to the plan, and the run begins again."""


class Failed(Exception):
    """An expression that cannot be translated where its value depends on an argument or a parameter."""

    def __init__(self, reason: str, node: ast.AST) -> None:
        super().__init__(reason)
        self.node = node


class Symbol:
    """The formula of a value, and an example of it; if it is ``known``, that is the value."""

    def __init__(self, node: ast.expr, value: Any, known: bool, program: Program) -> None:
        self.node = node
        self.value = value
        self.known = known
        self.program = program
        self.number = -1

    def __str__(self) -> str:
        if self.number < 0:
            self.number = len(self.program.tokens)
            self.program.tokens.append(self)
        return f"\ua657{self.number}\ua657"


def node_of(value: Any) -> ast.expr:
    """Return the formula of a value."""
    if isinstance(value, Symbol):
        return value.node
    if isinstance(value, (list, tuple)):
        return ast.List([node_of(item) for item in value], ast.Load())
    if isinstance(value, dict):
        return ast.Dict([ast.Constant(key) for key in value], [node_of(dict.get(value, key)) for key in value])
    if isinstance(value, (bool, int, float, str, type(None))):
        return ast.Constant(value)
    raise Failed(f"{type(value).__name__} cannot be translated", ast.Constant(0))


def example_of(value: Any) -> Any:
    """Return the example of a value."""
    return value.value if isinstance(value, Symbol) else value


def is_known(value: Any) -> bool:
    """Return True if a value depends on no argument and no parameter."""
    return not isinstance(value, Symbol) or value.known


def names_in(node: ast.AST) -> set[str]:
    """Return the names in a formula."""
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}


class Evaluator(ast.NodeTransformer):
    """Evaluates expressions in a table of symbols: the formula is transformed, the example is what Python computes."""

    def __init__(self, program: Program, symbols: Any, arguments: bool = False) -> None:
        self.program = program
        self.symbols = symbols
        self.arguments = arguments  # names are those of arguments, as in $(eval)

    def eval(self, tree: ast.expr) -> Any:
        """Return the value of an expression. Raises what Python raises, if its names are known, or Failed."""
        if isinstance(tree, ast.Name):
            return self.lookup(tree.id)
        if isinstance(tree, ast.BoolOp):
            return self.bool_of(tree)
        if isinstance(tree, ast.IfExp):
            test = self.eval(tree.test)
            if is_known(test):
                return self.eval(tree.body if example_of(test) else tree.orelse)
            return self.program.conditions.choice(test, self.eval(tree.body), self.eval(tree.orelse))
        if isinstance(tree, ast.Constant):
            return self.program.joined(tree.value) if isinstance(tree.value, str) else tree.value
        known = all(is_known(one) for one in self.names(tree).values())
        try:
            value = self.example(tree)
        except Failed:
            raise
        except Exception:
            if known:
                raise
            value = UNKNOWN
        if callable(value) or isinstance(value, (Iterator, self.program.xacro.NameSpace)):
            return value
        return Symbol(self.visit(_copied(tree)), value, known, self.program)

    def lookup(self, name: str) -> Any:
        token = TOKEN.fullmatch(name)
        if token:
            return self.program.literal(self.program.tokens[int(token[1])])
        if self.arguments and name in self.program.arguments:
            return self.program.literal(self.program.argument(name))
        return self.program.read(self.symbols, name)

    def names(self, tree: ast.expr) -> dict[str, Any]:
        """Return the values of the names in an expression, and of the texts with names in them."""
        own = {one.id for one in ast.walk(tree) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}
        own |= {one.arg for one in ast.walk(tree) if isinstance(one, ast.arg)}
        texts = [one.value for one in ast.walk(tree) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        found = {text: self.program.joined(text) for text in texts if TOKEN.search(text)}
        for one in ast.walk(tree):
            if isinstance(one, ast.Call) and ast.unparse(one.func) == "xacro.arg":
                found[f"arg {ast.unparse(one)}"] = self.program.argument(ast.literal_eval(one.args[0]))
        return found | {name: self.lookup(name) for name in names_in(tree) - own}

    def example(self, tree: ast.expr) -> Any:
        """Return what Python computes with the examples of names."""
        names = {name: example_of(value) for name, value in self.names(tree).items()}
        if any(value is UNKNOWN for value in names.values()):
            return UNKNOWN
        program = self.program

        class Texts(ast.NodeTransformer):
            def visit_Constant(self, node: ast.Constant) -> ast.AST:
                is_text = isinstance(node.value, str) and TOKEN.search(node.value)
                return ast.Constant(names[str(node.value)]) if is_text else node

        space = names.get("xacro")
        if isinstance(space, program.xacro.NameSpace):
            own = {"load_yaml": program.chosen.load, "arg": program.argument}
            names["xacro"] = _Functions(space, {key: _example_of(function) for key, function in own.items()})
        if "load_yaml" in names:
            names["load_yaml"] = program.chosen.load
        return example_of(program.xacro.safe_eval(ast.unparse(Texts().visit(_copied(tree))), names))

    def bool_of(self, tree: ast.BoolOp) -> Any:
        """Return the value of and, or; what is known decides, or is left out."""
        wins = isinstance(tree.op, ast.Or)
        left: list[Any] = []
        for item in tree.values:
            value = self.eval(item)
            if not is_known(value):
                left.append(value)
            elif bool(example_of(value)) == wins or item is tree.values[-1]:
                left.append(value)
                break
        if len(left) > 1 and is_known(left[-1]) and bool(example_of(left[-1])) != wins:
            left.pop()
        if len(left) == 1:
            return left[0]
        examples = [example_of(one) for one in left]
        found = UNKNOWN if UNKNOWN in examples else next((one for one in examples if bool(one) == wins), examples[-1])
        return Symbol(ast.BoolOp(tree.op, [*map(node_of, left)]), found, False, self.program)

    # Formulas.

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if isinstance(node.ctx, ast.Store):
            return node
        try:
            value = self.lookup(node.id)
        except (NameError, KeyError):  # of a comprehension
            return node
        return node_of(value)

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return node_of(self.program.joined(node.value)) if isinstance(node.value, str) else node

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        return node_of(self.eval(node)) if self.is_complete(node) else self.generic_visit(node)

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        return node_of(self.eval(node)) if self.is_complete(node) else self.generic_visit(node)

    def is_complete(self, node: ast.expr) -> bool:
        """Return True if all names in an expression have values: it is not within a comprehension."""
        try:
            self.names(node)
        except (NameError, KeyError):
            return False
        return True

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        if self.is_complete(node):
            self.program.note_comparison([self.eval(item) for item in (node.left, *node.comparators)])
        return self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        text = getattr(node.left, "value", None)
        if not isinstance(node.op, ast.Mod) or not isinstance(text, str):
            return self.generic_visit(node)
        values = node.right.elts if isinstance(node.right, ast.Tuple) else [node.right]
        first, *others = text.split("%s")
        if len(others) != len(values) or "%" in "".join([first, *others]):
            return self.computed(node)
        pairs = zip(map(self.visit, values), map(ast.Constant, others), strict=True)
        return join([ast.Constant(first), *(piece for pair in pairs for piece in pair)])

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        if isinstance(node.value, ast.Name) and self.is_complete(node.value):
            owner = self.lookup(node.value.id)
            if isinstance(owner, self.program.xacro.NameSpace):
                return node_of(self.program.read(owner, node.attr, own=True))
        return ast.Subscript(self.visit(node.value), ast.Constant(node.attr), ast.Load())

    def visit_Tuple(self, node: ast.Tuple) -> ast.AST:
        is_target = isinstance(node.ctx, ast.Store)
        return node if is_target else ast.List([self.visit(one) for one in node.elts], ast.Load())

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> ast.AST:
        return self.visit(ast.ListComp(node.elt, node.generators))  # type: ignore[no-any-return]

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        return self.computed(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        function: Any = node.func
        is_attribute = isinstance(function, ast.Attribute)
        name = function.attr if is_attribute else getattr(function, "id", "")
        is_named = is_attribute and isinstance(function.value, ast.Name) and self.is_complete(function.value)
        is_space = is_named and isinstance(self.lookup(function.value.id), self.program.xacro.NameSpace)
        is_method = is_attribute and not is_space
        if name == "dict" and node.keywords and not node.args:
            keys: list[Any] = [ast.Constant(one.arg) for one in node.keywords]
            return ast.Dict(keys, [self.visit(one.value) for one in node.keywords])
        if name == "load_yaml":
            return node_of(self.program.chosen.load(self.eval(node.args[0])))
        if name == "dotify":
            return self.visit(node.args[0])  # type: ignore[no-any-return]
        if name == "arg" and not is_method:
            return node_of(self.program.literal(self.program.argument(str(example_of(self.eval(node.args[0]))))))
        known = (_METHODS if is_method else _FUNCTIONS).split()
        has_lambda = any(isinstance(one, ast.Lambda) for one in ast.walk(node))
        if node.keywords or has_lambda or (name not in known and name != "str"):
            return self.computed(node)
        arguments = [self.visit(one) for one in node.args]
        if name == "str" and len(arguments) == 1:
            return join(arguments)
        return ast.Call(ast.Name(name), [self.visit(function.value), *arguments] if is_method else arguments, [])

    def computed(self, node: ast.expr) -> ast.AST:
        """Return the value of what the language has no word for. Raises Failed if it is not known."""
        unknown = [one.node for one in self.names(node).values() if not is_known(one)]
        if unknown:
            raise Failed(f"{ast.unparse(node)[:60]} cannot be translated", unknown[0])
        value = self.example(node)
        return node_of(list(value) if isinstance(value, Iterator) else value)


class _Functions:
    """The functions of xacro, some of them replaced."""

    def __init__(self, space: Any, own: dict[str, Any]) -> None:
        self.space, self.own = space, own

    def __getattr__(self, name: str) -> Any:
        return self.own.get(name) or getattr(self.space, name)


def _example_of(function: Any) -> Any:
    return lambda value: example_of(function(value))


def _copied(tree: ast.expr) -> Any:
    return ast.parse(ast.unparse(tree), mode="eval").body


def join(pieces: Iterable[ast.expr]) -> ast.Call:
    """Return the formula of a text that is made of pieces."""
    return ast.Call(ast.Name("__join"), list(pieces), [])


def is_find(node: Any) -> bool:
    """Return True for the folder of a package."""
    return isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find"


def parts_of(node: Any) -> list[Any]:
    """Return the pieces of a text."""
    parts = list(node.args) if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__join" else [node]
    plain = ("__number", "__flag")
    return [one.args[0] if isinstance(one, ast.Call) and getattr(one.func, "id", "") in plain else one for one in parts]


def as_printed(value: Any) -> ast.expr:
    """Return the formula of what is printed: an entry of a table may be true or false."""
    node = node_of(value)
    is_entry = isinstance(node, ast.Subscript) and isinstance(example_of(value), bool)
    return ast.Call(ast.Name("__flag"), [node], []) if is_entry else node


def as_condition(test: Symbol) -> Symbol:
    """Return a condition of xacro, which may be a text such as "true", as one of Python."""
    if not isinstance(test.value, str):
        return test
    return Symbol(ast.Call(ast.Name("__flag"), [test.node], []), test.value, test.known, test.program)

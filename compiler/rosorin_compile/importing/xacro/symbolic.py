"""Run xacro with symbols for its arguments and for the parameters of its macros.

The xacro library executes the file, so that scopes, lazy evaluation, includes and namespaces are exactly those of
xacro. Three things are different. The value of an expression is a ``Symbol``: a formula, with an example of its value.
A condition that depends on an argument stays in the document, with the elements of its branch. The call of a macro that
becomes a part stays in the document, and the body of the macro is evaluated once, with symbols for its parameters.
Everything in ``Plan`` is expanded as xacro does it. This module runs in the child process.
"""

from __future__ import annotations

import ast
import glob
import math
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from copy import copy
from importlib import import_module
from pathlib import Path
from typing import Any

from . import child
from .child import Expansion, causes, portable

MAX_RUNS, MAX_DEPTH, MAX_FILES = 60, 40, 20
TOKEN = re.compile("\ua657(\\d+)\ua657")  # a letter that no file uses: a token is a name in an expression
_MARK, _COMMENTS = "rosorin_place", "rosorin_comments"
_UNKNOWN = object()  # an example that cannot be computed
_TRANSPARENT = ("xacro-if", "xacro:if", "xacro:unless", "xacro-group")
_ORIGIN = (("xyz", "0 0 0"), ("rpy", "0 0 0"))
_CONSTANTS = ("pi", "e", "tau", "inf", "nan")
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


class Macro:
    """A macro that stays: the names and symbols of its parameters, and its body as it was evaluated."""

    def __init__(self, definition: Any, level: str) -> None:
        self.id = f"{place_key(definition)} {level}"
        self.definition = definition
        self.name = definition.body.getAttribute("name").removeprefix("xacro:")
        self.level = level
        self.parameters: dict[str, str] = {}  # ids of variables
        self.materials = False
        self.reads: dict[str, str] = {}
        self.depth = 0
        self.table: Any = None
        self.body: Any = None


def main() -> None:
    """Answer one request with the program of a file."""
    child.main(lambda request: Program(request).program())


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
            return self.program.choice(test, self.eval(tree.body), self.eval(tree.orelse))
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
            value = _UNKNOWN
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
        if any(value is _UNKNOWN for value in names.values()):
            return _UNKNOWN
        program = self.program

        class Texts(ast.NodeTransformer):
            def visit_Constant(self, node: ast.Constant) -> ast.AST:
                is_text = isinstance(node.value, str) and TOKEN.search(node.value)
                return ast.Constant(names[str(node.value)]) if is_text else node

        space = names.get("xacro")
        if isinstance(space, program.xacro.NameSpace):
            own = {"load_yaml": program.load, "arg": program.argument}
            names["xacro"] = _Functions(space, {key: _example_of(function) for key, function in own.items()})
        if "load_yaml" in names:
            names["load_yaml"] = program.load
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
        found = _UNKNOWN if _UNKNOWN in examples else next((one for one in examples if bool(one) == wins), examples[-1])
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
        if (
            not isinstance(node.op, ast.Mod)
            or not isinstance(node.left, ast.Constant)
            or not isinstance(node.left.value, str)
        ):
            return self.generic_visit(node)
        values = node.right.elts if isinstance(node.right, ast.Tuple) else [node.right]
        texts = node.left.value.split("%s")
        if len(texts) != len(values) + 1 or "%" in "".join(texts):
            return self.computed(node)
        pieces = [
            one for pair in zip(texts, values, strict=False) for one in (ast.Constant(pair[0]), self.visit(pair[1]))
        ]
        return ast.Call(ast.Name("__join"), [*pieces, ast.Constant(texts[-1])], [])

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
        parts = [one if isinstance(one, ast.Constant) else self.visit(one.value) for one in node.values]  # type: ignore[attr-defined]
        return ast.Call(ast.Name("__join"), parts, [])

    def visit_Call(self, node: ast.Call) -> ast.AST:
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        is_dict = name == "dict" and node.keywords and not node.args
        if is_dict:
            return ast.Dict(
                [ast.Constant(one.arg) for one in node.keywords], [self.visit(one.value) for one in node.keywords]
            )
        is_space = isinstance(node.func, ast.Attribute) and isinstance(node.func.value, ast.Name)
        owner = self.lookup(node.func.value.id) if is_space and self.is_complete(node.func.value) else None  # type: ignore[attr-defined]
        is_method = isinstance(node.func, ast.Attribute) and not isinstance(owner, self.program.xacro.NameSpace)
        if name == "load_yaml":
            return node_of(self.program.load(self.eval(node.args[0])))
        if name == "dotify":
            return self.visit(node.args[0])  # type: ignore[no-any-return]
        if name == "arg" and not is_method:
            return node_of(self.program.literal(self.program.argument(str(example_of(self.eval(node.args[0]))))))
        if any(isinstance(one, ast.Lambda) for one in ast.walk(node)):
            return self.computed(node)
        plain = [self.visit(one) for one in node.args] if not node.keywords else []
        if name == "str" and len(plain) == 1:
            return ast.Call(ast.Name("__join"), plain, [])
        if node.keywords or name not in (_METHODS if is_method else _FUNCTIONS).split():
            return self.computed(node)
        return ast.Call(ast.Name(name), [self.visit(node.func.value), *plain] if is_method else plain, [])  # type: ignore[attr-defined]

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


class Program(Expansion):
    """A run of a file with symbols. ``plan``: macros to expand (by place), values of arguments, implicit parameters."""

    def __init__(self, request: dict[str, Any]) -> None:
        super().__init__(request)
        self.inlined: dict[str, str] = dict(request["inlined"])  # places of macros, with the reason
        self.fixed: dict[str, list[str]] = dict(request["fixed"])
        self.implicit: dict[str, set[str]] = {key: set(names) for key, names in request["implicit"].items()}
        self.shapes: dict[str, dict[tuple[str, str], str]] = {}  # of the blocks of macros
        self.plain: set[str] = set(request["plain"])  # places of properties that are no named values

    def program(self) -> dict[str, Any]:
        """Return the program of the file, or the error."""
        xacro = self.xacro = import_module("xacro")
        self.prepare(xacro)
        self.patch(xacro)
        document: Any = None
        for _ in range(MAX_RUNS):
            self.reset()
            try:
                document = self.expanded(xacro, {})
                break
            except Restart:
                continue
            except Exception as problem:
                chain = list(causes(problem))
                if any(isinstance(one, Restart) for one in chain):
                    continue
                failed = next((one for one in chain if isinstance(one, Failed)), None)
                if failed is None or not self.blame(failed.node, str(failed)):
                    return {"error": str(failed or problem) or repr(problem), "line": 0}
        if document is None:
            return {"error": "too much of it cannot be translated"}
        return self.answer_of(document)

    def reset(self) -> None:
        self.tokens: list[Symbol] = []
        self.arguments: dict[str, dict[str, Any]] = {}
        self.variables: dict[str, dict[str, Any]] = {}
        self.macros: dict[str, Macro] = {}
        self.building: list[Macro] = []
        self.levels: list[str] = ["robot"]
        self.assumed: dict[str, bool] = {}
        self.depth = 0
        self.called: dict[str, str] = {}
        self.made: dict[str, bool] = {}
        self.defined: dict[str, tuple[str, Any]] = {}
        self.bound: dict[tuple[int, str], tuple[Any, Any]] = {}
        self.tables: list[Any] = []
        self.candidates: dict[str, list[Any]] = {}
        self.loaded: dict[str, str] = {}
        self.xacro.all_includes[:] = []
        for name, text in self.given.items():
            if name not in self.fixed:
                self.declare(name, text, None, given=True)

    def blame(self, node: ast.AST, reason: str) -> bool:
        """Give up what a formula depends on: the macros whose parameters it has, else its arguments."""
        found = False
        variables = [self.variables[name] for name in names_in(node) if name in self.variables]
        for one in variables:
            key = one["owner"].rpartition(" ")[0]
            if key and key not in self.inlined:
                self.inlined[key] = reason
                found = True
        for one in variables if not found else ():
            if one["kind"] == "argument" and one["name"] not in self.fixed:
                self.fixed[one["name"]] = [str(one["value"]), reason]
                found = True
            elif one["kind"] == "let" and "node" in one:
                found = self.blame(one["node"], reason) or found
        return found

    # Values.

    def variable(self, kind: str, name: str, value: Any, known: bool, **more: Any) -> Symbol:
        key = f"v{len(self.variables)}_"
        self.variables[key] = {"id": key, "kind": kind, "name": name, "value": value, "owner": "", **more}
        return Symbol(ast.Name(key, ast.Load()), value, known, self)

    def joined(self, text: str) -> Any:
        """Return a text with tokens as a symbol."""
        parts = TOKEN.split(text)
        if len(parts) == 1:
            return text
        pieces: list[Any] = [self.tokens[int(part)] if index % 2 else part for index, part in enumerate(parts)]
        pieces = [piece for piece in pieces if piece != ""]
        if len(pieces) == 1:
            return pieces[0]
        made = ast.Call(ast.Name("__join"), [*map(as_printed, pieces)], [])
        examples = [example_of(piece) for piece in pieces]
        value = _UNKNOWN if any(one is _UNKNOWN for one in examples) else "".join(map(str, examples))
        return Symbol(made, value, all(map(is_known, pieces)), self)

    def literal(self, value: Any) -> Any:
        """Return the value of a text, as xacro takes it for that of a property."""
        own = self.own_literal
        if not isinstance(value, Symbol):
            return own(value)
        made = own(value.value) if isinstance(value.value, str) else value.value
        if isinstance(made, str) and made != value.value:  # without the quotes around it
            parts = [one.value if isinstance(one, ast.Constant) else one for one in parts_of(value.node)]
            parts = [str(parts[0])[1:], *parts[1:-1], str(parts[-1])[:-1]] if len(parts) > 1 else parts
            pieces = [one if isinstance(one, ast.expr) else ast.Constant(one) for one in parts]
            node = ast.Call(ast.Name("__join"), pieces, [])
            return Symbol(node, made, value.known, self) if len(parts) > 1 else value
        if made is value.value or isinstance(made, str):
            return value
        kind = "__flag" if isinstance(made, bool) else "__number"
        return Symbol(ast.Call(ast.Name(kind), [value.node], []), made, value.known, self)

    def choice(self, test: Any, then: Any, other: Any) -> Any:
        """Return one of two values, by a condition."""
        if isinstance(test.node, ast.UnaryOp) and isinstance(test.node.op, ast.Not):
            test = Symbol(test.node.operand, _UNKNOWN if test.value is _UNKNOWN else not test.value, False, self)
            then, other = other, then
        same = ast.dump(test.node)
        nodes = [node_of(then), node_of(other)]
        for index, name in ((0, "body"), (1, "orelse")):
            node = nodes[index]
            while isinstance(node, ast.IfExp) and ast.dump(node.test) == same:
                node = getattr(node, name)
            nodes[index] = node
        examples = [example_of(then), example_of(other)]
        if ast.dump(nodes[0]) == ast.dump(nodes[1]):
            return then
        value = _UNKNOWN if test.value is _UNKNOWN else examples[0] if self.holds(test.value) else examples[1]
        return Symbol(ast.IfExp(test.node, *nodes), value, False, self)

    def holds(self, value: Any) -> bool:
        return bool(self.xacro.get_boolean_value(value, "")) if value is not _UNKNOWN else False

    def note_comparison(self, items: list[Any]) -> None:
        """Record the values that an argument is compared with: they are used to verify the translation."""
        texts = [
            one for item in map(example_of, items) for one in (item if isinstance(item, (list, tuple)) else [item])
        ]
        for item in items:
            for name in names_in(item.node) if isinstance(item, Symbol) and not item.known else ():
                self.candidates.setdefault(name, []).extend(
                    one for one in texts if isinstance(one, (str, int, float)) and not isinstance(one, bool)
                )

    def load(self, name: Any) -> Any:
        """Return the table of a YAML file, which an argument may choose."""
        path = example_of(name)
        if path is _UNKNOWN:
            raise Failed("the file that is loaded is not known", node_of(name))
        value = self.xacro.load_yaml(str(path))
        node: Any = node_of(name)
        if is_known(name):
            node = ast.Constant(self.address(str(path)))
        else:
            self.address(str(path))
            self.note_files(name)
            node = self.package_first(node)
        return Symbol(ast.Call(ast.Name("load"), [node], []), value, is_known(name), self)

    def address(self, name: str) -> str:
        """Return the name of a YAML file in the description, and record the file."""
        path = os.path.abspath(str(self.xacro.abs_filename_spec(name)))
        if "://" not in name and not name.startswith("/"):
            name = os.path.normpath(name)
            name = Path(name).name if name.startswith("..") else name
        else:
            name = portable(path, self.packages, [*self.files, self.file])
        self.loaded[name] = path
        return name

    def note_files(self, name: Any) -> None:
        """Record the YAML files that an argument chooses from."""
        base = self.folder()
        for one in names_in(name.node) & self.variables.keys():
            self.variables[one]["names_file"] = True
        with suppress(Failed):
            for _, path in self.matching(name.node, "load"):
                self.address(os.path.relpath(path, base) if path.startswith(base) else path)

    def folder(self) -> str:
        """Return the folder of the file that is read."""
        return str(Path(os.path.abspath(self.xacro.filestack[-1])).parent)

    def package_first(self, node: Any) -> Any:
        """Return the name of a file whose folder is found by its package as an address of the package."""
        parts = parts_of(node)
        first = parts[0]
        if isinstance(first, ast.Call) and getattr(first.func, "id", "") == "find":
            parts[0] = ast.Constant(f"package://{first.args[0].value}")  # type: ignore[attr-defined]
        return ast.Call(ast.Name("__join"), parts, [])

    def matching(self, node: Any, what: str) -> list[tuple[dict[str, str], str]]:
        """Return the files with a name that depends on arguments, each with their values. Raises Failed."""
        pattern, form = "", ""
        names: dict[str, str] = {}
        for part in parts_of(node):
            if isinstance(part, ast.Constant):
                pattern, form = pattern + glob.escape(str(part.value)), form + re.escape(str(part.value))
            elif isinstance(part, ast.Call) and getattr(part.func, "id", "") == "find":
                folder = self.share(part.args[0].value)  # type: ignore[attr-defined]
                pattern, form = pattern + glob.escape(folder), form + re.escape(folder)
            elif isinstance(part, ast.Name) and self.variables.get(part.id, {}).get("kind") == "argument":
                form += f"(?P={names[part.id]})" if part.id in names else f"(?P<{part.id}>[^/]+)"
                pattern, names[part.id] = pattern + "*", part.id
            else:
                raise Failed(f"the file to {what} is chosen by an expression", node)
        if not re.search(r"\w", pattern):
            raise Failed(f"the file to {what} is named by it", node)
        base = "" if pattern.startswith("/") else f"{self.folder()}/"
        found = []
        for path in sorted(self.xacro.glob.glob(glob.escape(base) + pattern))[:MAX_FILES]:
            match = re.fullmatch(re.escape(base) + form, path)
            if match and Path(path).is_file():
                found.append((match.groupdict(), path))
        self.note_choices(found)
        return found

    def note_choices(self, found: list[tuple[dict[str, str], str]]) -> None:
        for values, _ in found:
            for name, value in values.items():
                self.candidates.setdefault(name, []).append(value)

    # Arguments.

    def declare(self, name: str, text: Any, node: Any, given: bool = False, environment: bool = False) -> None:
        if name in self.arguments:
            self.arguments[name]["place"] = self.arguments[name]["place"] or getattr(node, _MARK, None)
            return
        example = example_of(text)
        place, comments = getattr(node, _MARK, None), getattr(node, _COMMENTS, [])
        symbol = self.variable("argument", name, str(example), False, default=node_of(text), place=place)
        made = self.variables[symbol.node.id]  # type: ignore[attr-defined]
        made |= {"comments": comments, "environment": environment, "given": given}
        self.arguments[name] = made

    def argument(self, name: str) -> Any:
        if name in self.fixed:
            self.fixed[name] = self.fixed[name][:2]
            return self.fixed[name][0]
        if name not in self.arguments:
            raise import_module("xacro.substitution_args").ArgException(name)
        made = self.arguments[name]
        return Symbol(ast.Name(made["id"], ast.Load()), made["value"], False, self)

    def extension(self, text: str, symbols: Any) -> Any:
        """Return the value of $(...)."""
        kind, _, rest = text.strip().partition(" ")
        rest = rest.strip()
        named = self.joined(rest)
        if kind != "eval" and not is_known(named):
            raise Failed(f"$({kind}) cannot be translated", named.node)
        rest = str(example_of(named)) if kind != "eval" else rest
        if kind == "arg":
            return self.argument(rest)
        if kind == "eval":
            return Evaluator(self, symbols, arguments=True).eval(ast.parse(rest.strip(), mode="eval").body)
        if kind == "find":
            return Symbol(ast.Call(ast.Name("find"), [ast.Constant(rest)], []), self.share(rest), True, self)
        if kind in ("env", "optenv"):
            name, _, default = rest.partition(" ")
            if kind == "env" and name not in os.environ:
                return self.own_extension(f"$({text})")
            if name not in self.fixed:
                self.declare(name, os.environ.get(name, default.strip()), None, environment=True)
            return self.argument(name)
        return self.own_extension(f"$({kind} {rest})".replace(" )", ")"))

    def eval_text(self, text: str, symbols: Any, inner: bool = False) -> Any:
        """Return the value of a text, as xacro does."""
        xacro, results = self.xacro, []
        lexer = xacro.QuickLexer(xacro.LEXER)
        lexer.lex(text)
        while lexer.peek():
            kind, found = lexer.peek()[0], lexer.next()[1]
            if kind == lexer.EXPR:
                expression = self.eval_text(found[2:-1], symbols, inner=True)
                try:
                    tree = ast.parse(expression.strip(), mode="eval").body
                    results.append(Evaluator(self, symbols).eval(tree))
                except (Restart, Failed):
                    raise
                except Exception as problem:
                    suffix = f"{os.linesep}when evaluating expression '{found[2:-1]}'"
                    raise xacro.XacroException(exc=problem, suffix=suffix) from problem
            elif kind == lexer.EXTENSION:
                results.append(self.extension(self.eval_text(found[2:-1], symbols, inner=True), symbols))
            else:
                results.append(found[1:] if kind == lexer.DOLLAR_DOLLAR_BRACE else found)
        if inner:
            return "".join(map(str, results))
        if len(results) == 1:
            return self.joined(results[0]) if isinstance(results[0], str) else results[0]
        return self.joined("".join(map(str, results)))

    # Properties.

    def read(self, table: Any, name: str, own: bool = False) -> Any:
        """Return what a name stands for: a global name of xacro, or a property, a parameter."""
        xacro, holder = self.xacro, table
        while isinstance(holder, xacro.Table) and not dict.__contains__(holder, name):
            holder = holder.parent
        if not isinstance(holder, xacro.Table) or (isinstance(holder, xacro.NameSpace) and holder.parent == {}):
            if name not in holder:
                raise NameError(f"name '{name}' is not defined")
            value = holder[name]
            if name in _CONSTANTS:
                return Symbol(ast.Name(name, ast.Load()), value, True, self)
            return value
        value = self.named(holder, name)
        for macro in reversed(self.building) if not own else ():
            if holder.depth >= macro.depth:
                break
            names = names_in(value.node) & self.variables.keys() if isinstance(value, Symbol) else ()
            owners = {self.variables[one]["owner"] for one in names}
            if owners - {"", macro.id}:
                self.implicit.setdefault(place_key(macro.definition), set()).add(name)
                raise Restart
            macro.reads.setdefault(name, self.identity(value))
        return value

    def identity(self, value: Any) -> str:
        try:
            return ast.dump(node_of(value))
        except Failed:
            return str(id(value))

    def named(self, table: Any, name: str) -> Any:
        """Return the value of a property as a reference to it."""
        value = table[name]
        if "rosorin_plain" in vars(table) or isinstance(value, self.xacro.Table):
            return value
        known = self.bound.get((id(table), name))
        if known is not None and known[0] is value:
            return known[1]
        if isinstance(value, Symbol) and isinstance(parts_of(value.node)[0], ast.Name) and not is_let(value, self):
            return value
        try:
            node = node_of(value)
        except Failed:
            return value
        owner = vars(table).get("rosorin_owner", "")
        place, comments, raw = vars(table).get("rosorin_places", {}).get(name, (None, [], ""))
        if isinstance(value, float) and value == math.pi:
            return Symbol(ast.Name("pi", ast.Load()), value, True, self)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if place is not None and str(place[:2]) in self.plain:
            return example_of(value) if is_known(value) else value
        made = self.variable(
            "let", name, example_of(value), is_known(value), node=node, place=place, comments=comments,
            raw=raw if is_number and self.own_literal(raw) == value else "",
        )  # fmt: skip
        self.variables[made.node.id]["owner"] = owner  # type: ignore[attr-defined]
        self.tables.append(table)
        self.bound[id(table), name] = (value, made)
        return made

    # Elements.

    def patch(self, xacro: Any) -> None:
        """Let xacro evaluate with symbols."""
        self.own_literal, self.own_extension = xacro.Table._eval_literal, xacro.eval_extension
        self.own_include, own_boolean = xacro.process_include, xacro.get_boolean_value
        xacro.Table._eval_literal = staticmethod(self.literal)
        xacro.eval_text, xacro.eval_all, xacro.handle_macro_call = self.eval_text, self.eval_all, self.call
        xacro.remove_previous_comments = self.take_comments
        xacro.get_boolean_value = lambda value, condition: own_boolean(example_of(value), condition)

    def take_comments(self, node: Any) -> None:
        """Remove the comments before an element of xacro and remember them with it."""
        found: list[str] = []
        before = node.previousSibling
        while before is not None:
            if before.nodeType == before.TEXT_NODE and before.data.isspace() and before.data.count("\n") <= 1:
                before = before.previousSibling
            elif before.nodeType == before.COMMENT_NODE:
                found.insert(0, before.data)
                before, gone = before.previousSibling, before
                gone.parentNode.removeChild(gone)
            else:
                break
        after = node.nextSibling
        if after is not None and after.nodeType == after.TEXT_NODE and "\n" not in after.data and after.data.isspace():
            after = after.nextSibling
        if (
            after is not None and after.nodeType == after.COMMENT_NODE and "\n" not in after.data
        ):  # behind it on its line
            found.append(after.data)
            after.parentNode.removeChild(after)
        setattr(node, _COMMENTS, [*getattr(node, _COMMENTS, []), *found])

    def eval_all(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate an element and what it contains."""
        for name, value in list(node.attributes.items()):
            if name.startswith("xacro:") or name == "xmlns:xacro":
                node.removeAttribute(name)
            else:
                node.setAttribute(name, str(self.eval_text(value, symbols)))
        child = node.firstChild
        while child is not None:
            if child.nodeType == child.ELEMENT_NODE and child.tagName.startswith("xacro:"):
                self.take_comments(child)
            following = child.nextSibling
            if child.nodeType == child.ELEMENT_NODE:
                if child.tagName == "xacro:element":
                    name = self.eval_text(child.getAttribute("xacro:name"), symbols)
                    if not is_known(name):
                        raise Failed("the name of an element depends on it", name.node)
                    child.removeAttribute("xacro:name")
                    child.nodeName = child.tagName = str(example_of(name))
                    continue
                self.element(child, macros, symbols)
            elif child.nodeType == child.TEXT_NODE and child.data.strip():
                child.data = str(self.eval_text(child.data, symbols))
            child = following

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        xacro, tag = self.xacro, node.tagName
        if tag in ("xacro:if", "xacro:unless"):
            self.condition(node, macros, symbols)
        elif tag == "xacro:include":
            self.include(node, macros, symbols)
        elif tag == "xacro:property":
            self.property(node, symbols)
        elif tag == "xacro:macro":
            place = getattr(node, _MARK, None)
            name = node.getAttribute("name")
            xacro.grab_macro(node, macros)
            self.defined.setdefault(str(place), (name, place))
        elif tag == "xacro:arg":
            self.take_comments(node)
            name = node.getAttribute("name")
            if name not in self.fixed and (name not in self.arguments or self.arguments[name]["place"] is None):
                self.declare(name, self.eval_text(node.getAttribute("default"), symbols), node)
            elif name in self.arguments and not self.arguments[name]["comments"]:
                self.arguments[name]["comments"] = getattr(node, _COMMENTS, [])
            xacro.replace_node(node, by=None)
        elif tag == "xacro:insert_block":
            self.insert(node, macros, symbols)
        elif tag == "xacro:attribute":
            name, value = (self.eval_text(node.getAttribute(one), symbols) for one in ("name", "value"))
            if not is_known(name):
                raise Failed("the name of an attribute depends on it", name.node)
            node.parentNode.setAttribute(str(example_of(name)), str(value))
            xacro.replace_node(node, by=None)
        elif not self.call(node, macros, symbols):
            self.eval_all(node, macros, symbols)

    def property(self, node: Any, symbols: Any) -> None:
        scope = node.getAttribute("scope")
        if scope == "global":
            for macro in self.building:
                self.give_up(macro, "it sets a property of its caller")
        elif scope == "parent" and self.building and symbols is self.building[-1].table:
            self.give_up(self.building[-1], "it sets a property of its caller")
        name = str(example_of(self.eval_text(node.getAttribute("name"), symbols)))
        self.take_comments(node)
        place = (getattr(node, _MARK, None), getattr(node, _COMMENTS, []), node.getAttribute("value"))
        vars(symbols).setdefault("rosorin_places", {})[name] = place
        self.bound.pop((id(symbols), name), None)
        self.xacro.grab_property(node, symbols)

    def give_up(self, macro: Macro, reason: str) -> None:
        self.inlined[place_key(macro.definition)] = reason
        raise Restart

    def insert(self, node: Any, macros: Any, symbols: Any) -> None:
        """Insert a block."""
        name = node.getAttribute("name")
        key = f"**{name}" if f"**{name}" in symbols else f"*{name}"
        if key not in symbols:
            raise self.xacro.XacroException(f'Undefined block "{name}"')
        block, holder = symbols[key].cloneNode(deep=True), symbols
        while not dict.__contains__(holder, key):
            holder = holder.parent
        for macro in self.building:
            if self.building[0].depth <= holder.depth < macro.depth:
                self.give_up(macro, "it inserts a block of its caller")
        self.eval_all(block, macros, symbols)
        self.xacro.replace_node(node, by=block, content_only=key.startswith("**"))

    def include(self, node: Any, macros: Any, symbols: Any) -> None:
        """Include a file; one that an argument chooses is included on the condition that it does."""
        name = self.eval_text(node.getAttribute("filename"), symbols)
        if not is_known(name):
            chosen = list(self.matching(name.node, "include"))
            self.alternatives(
                node, name, "filename", [(one, path.replace("${", "$${")) for one, path in chosen], macros, symbols
            )
            return
        node.setAttribute("filename", str(example_of(name)).replace("${", "$${"))
        self.levels.append("robot" if self.levels[-1] == "robot" else self.levels[-1])
        try:
            self.own_include(node, macros, symbols, self.eval_all)
        finally:
            self.levels.pop()

    def alternatives(
        self,
        node: Any,
        name: Symbol,
        attribute: str,
        chosen: list[tuple[dict[str, str], str]],
        macros: Any,
        symbols: Any,
    ) -> None:
        """Replace an element with an attribute that depends on a variable by one for each of its values."""
        if not chosen:
            raise Failed(f"{ast.unparse(name.node)[:60]} names nothing", name.node)
        self.take_comments(node)
        for values, text in chosen:
            made, inner = node.ownerDocument.createElement("xacro:if"), node.cloneNode(deep=True)
            inner.setAttribute(attribute, text)
            made.appendChild(inner)
            setattr(made, _MARK, getattr(node, _MARK, None))
            setattr(made, _COMMENTS, getattr(node, _COMMENTS, []))
            node.parentNode.insertBefore(made, node)
            tests: list[ast.expr] = [
                ast.Compare(ast.Name(one, ast.Load()), [ast.Eq()], [ast.Constant(v)]) for one, v in values.items()
            ]
            test: Any = tests[0] if len(tests) == 1 else ast.BoolOp(ast.And(), tests)
            holds = all(str(self.variables[one]["value"]) == value for one, value in values.items())
            self.branch(made, Symbol(test, holds, False, self), True, macros, symbols)
        node.parentNode.removeChild(node)

    def matching_macros(self, name: Symbol, macros: Any) -> list[tuple[dict[str, str], str]]:
        """Return the macros with a name that depends on variables, each with their values. Raises Failed."""
        pattern, names = "", set()
        for part in parts_of(name.node):
            if isinstance(part, ast.Constant):
                pattern += re.escape(str(part.value))
            elif isinstance(part, ast.Name):
                pattern += f"(?P={part.id})" if part.id in names else f"(?P<{part.id}>.+)"
                names.add(part.id)
            else:
                raise Failed("the macro that is called is named by an expression", name.node)
        defined: list[str] = []
        while isinstance(macros, dict):
            defined += [one for one in dict.keys(macros) if isinstance(one, str)]
            macros = vars(macros).get("parent") if hasattr(macros, "__dict__") else None
        found = [(match.groupdict(), one) for one in dict.fromkeys(defined) if (match := re.fullmatch(pattern, one))]
        self.note_choices(found)
        return found

    def condition(self, node: Any, macros: Any, symbols: Any) -> None:
        self.take_comments(node)
        text = node.getAttribute("value")
        test, holds = self.eval_text(text, symbols), node.tagName == "xacro:if"
        if not is_known(test) and type(self.own_literal(test.value)) in (int, float):
            self.note_comparison([test, 0, 1])
        if is_known(test):
            decided: bool | None = bool(self.xacro.get_boolean_value(test, text))
        else:
            plain, positive = test.node, True
            while isinstance(plain, ast.UnaryOp) and isinstance(plain.op, ast.Not):
                plain, positive = plain.operand, not positive
            found = self.assumed.get(ast.dump(plain))
            decided = None if found is None else found == positive
        if decided is None:
            self.branch(node, test, holds, macros, symbols)
        elif decided == holds:
            self.eval_all(node, macros, symbols)
            self.xacro.replace_node(node, by=node, content_only=True)
        else:
            self.xacro.replace_node(node, by=None)

    def branch(self, node: Any, test: Symbol, holds: bool, macros: Any, symbols: Any) -> None:
        """Evaluate what depends on a condition, and let the properties that it sets depend on it, too."""
        before = list(self.state(symbols))
        defined = [(table, name, copy(one)) for table, _, _ in self.state(macros) for name, one in dict.items(table)
                   if isinstance(one, self.xacro.Macro)]  # fmt: skip
        plain, positive = test.node, holds
        while isinstance(plain, ast.UnaryOp) and isinstance(plain.op, ast.Not):
            plain, positive = plain.operand, not positive
        key = ast.dump(plain)
        self.assumed[key] = positive
        if node.hasAttribute("value"):
            node.removeAttribute("value")
        node.tagName = node.nodeName = "xacro-if"
        stack = len(self.xacro.filestack), len(self.xacro.macrostack), len(self.levels), self.depth
        try:
            self.eval_all(node, macros, symbols)
        except Restart:
            raise
        except Exception as problem:
            chain = list(causes(problem))
            if any(isinstance(one, Restart) for one in chain):
                raise Restart from None
            taken = test.value is not _UNKNOWN and self.holds(test.value) == holds
            if taken or any(isinstance(one, (Failed, RecursionError)) for one in chain):
                if (taken and not any(isinstance(one, RecursionError) for one in chain)) or not self.blame(
                    test.node, f"with another value of it, {reason_of(problem)}"
                ):
                    raise
                raise Restart from None
            self.restore(before, stack)  # xacro refuses the other value as well
            self.xacro.replace_node(node, by=None)
            return
        finally:
            self.assumed.pop(key, None)
        node.setAttribute("test", str(test))
        node.setAttribute("holds", str(int(holds)))
        for table, name, other in defined:
            if table[name].body is not other.body:
                made = copy(table[name])
                made.rosorin_other = (test, holds, other)
                dict.__setitem__(table, name, made)
        for table, values, unevaluated in before:
            for name in [one for one in table if dict.get(table, one) is not values.get(one, _UNKNOWN)]:
                old, new = values.get(name, _UNKNOWN), dict.get(table, name)
                if old is _UNKNOWN or not isinstance(new, (str, int, float, Symbol, list, dict)):
                    continue
                new = table[name]
                dict.__setitem__(table, name, old)
                table.unevaluated.discard(name)
                if name in unevaluated:
                    table.unevaluated.add(name)
                old = table[name]
                pair = (new, old) if holds else (old, new)
                made = self.choice(as_condition(test), *pair)
                dict.__setitem__(table, name, made)
                self.bound.pop((id(table), name), None)

    def restore(self, before: list[tuple[Any, dict[str, Any], set[str]]], stack: tuple[int, int, int, int]) -> None:
        """Undo what a branch did that xacro cannot evaluate."""
        for table, values, unevaluated in before:
            dict.clear(table)
            dict.update(table, values)
            table.unevaluated = unevaluated
        del self.xacro.filestack[stack[0] :], self.xacro.macrostack[stack[1] :], self.levels[stack[2] :]
        self.depth = stack[3]

    def state(self, symbols: Any) -> Iterator[tuple[Any, dict[str, Any], set[str]]]:
        while isinstance(symbols, self.xacro.Table) and symbols is not symbols.root:
            yield symbols, dict(dict.items(symbols)), set(symbols.unevaluated)
            symbols = symbols.parent

    # Macros.

    def level(self, node: Any) -> str:
        """Return where a call is: the element that it is in, of those that become entries; else ``xml``."""
        parent = node.parentNode
        while parent is not None and parent.nodeType == parent.ELEMENT_NODE:
            tag = parent.tagName
            if tag == "xacro:macro":
                return self.levels[-1]
            if parent.parentNode is None or parent.parentNode.nodeType == parent.DOCUMENT_NODE:
                return "robot"
            if tag not in _TRANSPARENT:
                return "" if tag.startswith("xacro") else tag if self.is_entry(parent) else "xml"
            parent = parent.parentNode
        return self.levels[-1]

    def is_entry(self, node: Any) -> bool:
        """Return True if an element is a link or a joint, or belongs to one."""
        order = {"link": (), "joint": (), "inertial": ("link",), "visual": ("link",), "collision": ("link",)}
        order["geometry"] = ("visual", "collision")
        tag = node.tagName
        if tag not in order:
            return False
        above = node.parentNode
        while above is not None and above.nodeType == above.ELEMENT_NODE and above.tagName in _TRANSPARENT:
            above = above.parentNode
        if above is None or above.nodeType != above.ELEMENT_NODE or above.tagName == "xacro:macro":
            return (self.levels[-1] if above is not None else "robot") in (order[tag] or ("robot",))
        if not order[tag]:
            return above.parentNode is None or above.parentNode.nodeType == above.DOCUMENT_NODE
        return above.tagName in order[tag] and self.is_entry(above)

    def call(self, node: Any, macros: Any, symbols: Any) -> bool:
        xacro = self.xacro
        if not node.tagName.startswith("xacro:"):
            return False
        if node.tagName == "xacro:call":
            name = self.eval_text(node.getAttribute("macro"), symbols)
            if not is_known(name):
                self.alternatives(node, name, "macro", self.matching_macros(name, macros), macros, symbols)
                return True
            node.removeAttribute("macro")
            node.tagName = node.nodeName = f"xacro:{example_of(name)}"
        name = node.tagName.removeprefix("xacro:")
        try:
            own_macros, own_symbols, macro = xacro.resolve_macro(name, macros, symbols)
        except KeyError:
            raise xacro.XacroException(f"unknown macro name: {node.tagName}") from None
        if "rosorin_other" in vars(macro):
            self.call_either(node, macro, macros, symbols)
            return True
        macro = copy(macro)  # the name may be defined again
        key = place_key(macro)
        self.called.setdefault(key, name)
        level = self.level(node)
        self.depth += 1
        if self.depth > MAX_DEPTH * (1 if self.assumed else 5):
            raise RecursionError("macros call each other without end")
        xacro.macrostack.append(macro)
        values, defaulted, blocks = self.given_to(macro, node, macros, symbols, own_symbols)
        if self.stays(key, level):
            self.keep(macro, key, node, level, values, defaulted, blocks, own_macros, own_symbols)
        else:
            self.expand(macro, key, node, values, blocks, own_macros, own_symbols)
        xacro.macrostack.pop()
        self.depth -= 1
        return True

    def call_either(self, node: Any, macro: Any, macros: Any, symbols: Any) -> None:
        """Call a macro that is defined in two ways, on a condition: each on its condition."""
        test, holds, other = macro.rosorin_other
        name = node.tagName.removeprefix("xacro:")
        for one, side in ((macro, holds), (other, not holds)):
            made = node.ownerDocument.createElement("xacro:if")
            made.appendChild(node.cloneNode(deep=True))
            node.parentNode.insertBefore(made, node)
            table = self.xacro.Table(macros)
            one = copy(one)
            vars(one).pop("rosorin_other", None) if one.__dict__.get("rosorin_other", (test,))[0] is test else None
            dict.__setitem__(table, name, one)
            self.branch(made, test, side, table, symbols)
        node.parentNode.removeChild(node)

    def given_to(
        self, macro: Any, node: Any, macros: Any, symbols: Any, own_symbols: Any
    ) -> tuple[dict[str, Any], set[str], dict[str, Any]]:
        """Return the values of the parameters of a call, which of them are defaults, and the blocks."""
        xacro, parameters = self.xacro, list(macro.params)
        values: dict[str, Any] = {}
        for name, text in node.attributes.items():
            if name not in parameters:
                raise xacro.XacroException(f'Invalid parameter "{name}"', macro=macro)
            parameters.remove(name)
            values[name] = self.literal(self.eval_text(text, symbols))
            node.setAttribute(name, "")
        self.eval_all(node, macros, symbols)
        blocks: dict[str, Any] = {}
        block = xacro.first_child_element(node)
        for name in [one for one in parameters if one.startswith("*")]:
            if not block:
                raise xacro.XacroException("Not enough blocks", macro=macro)
            if block.tagName == "xacro-if":
                self.blame_block(block)
            parameters.remove(name)
            blocks[name] = block
            block = xacro.next_sibling_element(block)
        if block is not None:
            raise xacro.XacroException(f'Unused block "{block.tagName}"', macro=macro)
        table = xacro.Table(own_symbols)
        for name, value in values.items():
            dict.__setitem__(table, name, value)
        table.rosorin_plain = True
        defaulted = set()
        for name in parameters:
            forward, default = macro.defaultmap.get(name, (None, None))
            if forward is None and default is None:
                raise xacro.XacroException(f"Undefined parameters [{name}]", macro=macro)
            if forward is not None and forward in symbols:
                value = self.read(symbols, forward)
            elif default is None:
                raise xacro.XacroException(f"Undefined property to forward: {forward}", macro=macro)
            else:
                value = self.eval_text(default, symbols)
                defaulted.add(name)
            values[name] = self.literal(value)
        return values, defaulted, blocks

    def blame_block(self, block: Any) -> None:
        token = TOKEN.search(block.getAttribute("test"))
        node = self.tokens[int(token[1])].node if token else ast.Constant(0)
        raise Failed("a block depends on a condition", node)

    def stays(self, key: str, level: str) -> bool:
        if key in self.inlined or not level:
            return False
        if any(place_key(one.definition) == key for one in self.building):
            self.inlined[key] = "it calls itself"
            raise Restart
        return True

    def keep(
        self, definition: Any, key: str, node: Any, level: str, values: dict[str, Any], defaulted: set[str],
        blocks: dict[str, Any], macros: Any, symbols: Any,
    ) -> None:  # fmt: skip
        """Replace a call by an element that describes it; evaluate the body of the macro at its first call."""
        for name in sorted(self.implicit.get(key, ())):
            with_name = self.try_read(symbols, name)
            if with_name is not _UNKNOWN and name not in values:
                values[name] = with_name
        macro = self.macros.get(f"{key} {level}")
        given = dict(values)
        names = self.take_blocks(key, definition, blocks, values, defaulted)
        if macro is None:
            macro = self.macros[f"{key} {level}"] = Macro(definition, level)
            self.build(macro, key, values, blocks, names, macros, symbols)
        else:
            for name, before in macro.reads.items():
                if self.identity(self.try_read(symbols, name)) != before and name not in self.implicit.get(key, ()):
                    self.implicit.setdefault(key, set()).add(name)
                    raise Restart
        self.take_comments(node)
        made = node.ownerDocument.createElement("xacro-call")
        made.setAttribute("macro", macro.id)
        for name in list(values):
            if name not in macro.parameters:
                self.give_up(macro, f'its calls have different parameters: "{name}"')
        for value in values.values():
            if not is_known(value) and str(value.value).endswith((".yaml", ".yml")):
                self.note_files(value)
        texts = {name: [self.source(node_of(value)), name in defaulted] for name, value in values.items()}
        made.rosorin_given = texts
        made.rosorin_examples = {name: example_of(value) for name, value in values.items()}
        setattr(made, _MARK, getattr(node, _MARK, None))
        setattr(made, _COMMENTS, getattr(node, _COMMENTS, []))
        if macro.materials:
            self.hoist(definition, key, node, given, blocks, macros, symbols)
        self.xacro.replace_node(node, by=made)

    def take_blocks(
        self, key: str, definition: Any, blocks: dict[str, Any], values: dict[str, Any], defaulted: set[str]
    ) -> dict[tuple[str, str], str]:
        """Make the attributes in the blocks of a call parameters; return their names by element and attribute."""
        found: dict[tuple[str, str], Any] = {}
        for name, block in blocks.items():
            for number, element in enumerate(within(block)):
                if element.tagName.startswith("xacro") or any(
                    one.nodeType == one.TEXT_NODE and one.data.strip() for one in element.childNodes
                ):
                    self.inlined[key] = "a block has text, a macro or a condition in it"
                    raise Restart
                found[f"{name}/{number}{element.tagName}", ""] = None
                for attribute, text in (*(_ORIGIN if element.tagName == "origin" else ()), *element.attributes.items()):
                    found[f"{name}/{number}{element.tagName}", attribute] = text
        shape = self.shapes.setdefault(key, {})
        elements = [path for path, attribute in found if not attribute]
        if shape and elements != [path for path, attribute in shape if not attribute]:
            self.inlined[key] = "its calls have different elements in a block"
            raise Restart
        for path, attribute in [one for one in found if one not in shape]:
            tag = path.partition("/")[2].lstrip("0123456789")
            name = tag if attribute in ("value", "name", "link") else attribute
            taken = {*shape.values(), *definition.params}
            shape[path, attribute] = (
                "" if not attribute else name if name not in taken else f"{path.split('/')[0][1:]}_{name}"
            )
            if key in {one.rpartition(" ")[0] for one in self.macros}:
                self.shapes[key] = dict(shape)
                raise Restart
        for (path, attribute), name in shape.items():
            text = found.get((path, attribute))
            values.update({name: self.literal(self.joined(text)) if text is not None else None} if attribute else {})
            if attribute and (text is None or (path.endswith("origin") and text == dict(_ORIGIN).get(attribute))):
                defaulted.add(name)
        return shape

    def hoist(
        self,
        definition: Any,
        key: str,
        node: Any,
        values: dict[str, Any],
        blocks: dict[str, Any],
        macros: Any,
        symbols: Any,
    ) -> None:
        """Put the materials that a call makes before it: a robot shares them."""
        group, call = (node.ownerDocument.createElement(tag) for tag in ("xacro-group", node.tagName))
        node.parentNode.insertBefore(group, node)
        group.appendChild(call)
        self.expand(
            definition, key, call, values, {k: one.cloneNode(deep=True) for k, one in blocks.items()}, macros, symbols
        )
        only_materials(group, True)
        self.xacro.replace_node(group, by=group, content_only=True)

    def try_read(self, symbols: Any, name: str) -> Any:
        try:
            return self.read(symbols, name)
        except (NameError, KeyError):
            return _UNKNOWN

    def build(
        self, macro: Macro, key: str, values: dict[str, Any], blocks: dict[str, Any], names: dict[tuple[str, str], str],
        macros: Any, symbols: Any,
    ) -> None:  # fmt: skip
        """Evaluate the body of a macro with symbols for its parameters."""
        table = self.xacro.Table(symbols)
        table.rosorin_owner = macro.id
        for name, value in values.items():
            example = example_of(value)
            made = self.variable("parameter", name, example, False)
            self.variables[made.node.id]["owner"] = macro.id  # type: ignore[attr-defined]
            macro.parameters[name] = made.node.id  # type: ignore[attr-defined]
            dict.__setitem__(table, name, made)
        body = macro.definition.body.cloneNode(deep=True)
        for name, block in blocks.items():
            inner = block.cloneNode(deep=True)
            for number, element in enumerate(within(inner)):
                for (path, attribute), parameter in names.items():
                    if attribute and path == f"{name}/{number}{element.tagName}":
                        element.setAttribute(attribute, str(dict.__getitem__(table, parameter)))
            dict.__setitem__(table, name, inner)
        for name in ("name", "params"):
            if body.hasAttribute(name):
                body.removeAttribute(name)
        macro.depth, macro.table = table.depth, table
        outer, self.assumed = self.assumed, {}
        self.building.append(macro)
        self.levels.append(macro.level)
        holder = body.ownerDocument.createElement("xacro:macro")
        holder.appendChild(body)
        self.eval_all(body, self.xacro.Table(macros), table)
        self.levels.pop()
        self.building.pop()
        self.assumed = outer
        macro.materials = macro.level == "robot" and only_materials(body, False)
        macro.body = body
        self.made[key] = True

    def expand(
        self, macro: Any, key: str, node: Any, values: dict[str, Any], blocks: dict[str, Any], macros: Any, symbols: Any
    ) -> None:
        """Expand a call in its place, as xacro does."""
        table = self.xacro.Table(symbols)
        table.rosorin_plain = True
        for name, value in (values | blocks).items():
            dict.__setitem__(table, name, value)
        body = macro.body.cloneNode(deep=True)
        for name in ("name", "params"):
            if body.hasAttribute(name):
                body.removeAttribute(name)
        parent = node.parentNode
        self.take_comments(node)
        level = self.level(node)
        self.levels.append(level or "xml")
        # the body is evaluated where it belongs, so that calls in it know what they are in
        holder = node.ownerDocument.createElement("xacro:macro")
        holder.appendChild(body)
        body.tagName = body.nodeName = "xacro:macro"
        self.eval_all(body, self.xacro.Table(macros), table)
        self.levels.pop()
        if any(child.nodeType == child.ELEMENT_NODE for child in body.childNodes):
            self.made[key] = True
        self.made.setdefault(key, False)
        first = next((child for child in body.childNodes if child.nodeType == child.ELEMENT_NODE), None)
        if first is not None and getattr(node, _COMMENTS, []):
            setattr(first, _COMMENTS, [*getattr(node, _COMMENTS), *getattr(first, _COMMENTS, [])])
        self.xacro.import_xml_namespaces(parent, body.attributes)
        self.xacro.replace_node(node, by=body, content_only=True)

    # The answer.

    def answer_of(self, document: Any) -> dict[str, Any]:
        body = list(self.nodes(document.documentElement))
        macros = [
            {
                "key": key, "name": one.name, "level": one.level, "parameters": one.parameters,
                "body": list(self.nodes(one.body)), "place": getattr(one.definition.body, _MARK, None),
                "comments": getattr(one.definition.body, _COMMENTS, []),
            }
            for key, one in self.macros.items()
        ]  # fmt: skip
        tokens = [self.source(as_printed(one)) for one in self.tokens]
        variables = []
        for one in self.variables.values():
            value = one["value"]
            plain = value if isinstance(value, (str, int, float, bool)) else None
            kind = "list" if isinstance(value, (list, tuple)) else "table" if isinstance(value, dict) else ""
            made = {**one, "value": plain, "shape": kind, "candidates": self.candidates.get(one["id"], [])}
            for name in ("node", "default"):
                if name in made:
                    made[name] = self.source(made[name])
            variables.append(made)
        return {
            "name": document.documentElement.getAttribute("name"),
            "body": body, "macros": macros, "tokens": tokens, "variables": variables,
            "inlined": [[*self.defined.get(k, (k, 0)), why, k] for k, why in self.inlined.items() if k in self.called],
            "silent": [self.defined[key][0] for key, made in self.made.items() if not made and key in self.defined],
            "uncalled": [name for key, (name, _) in self.defined.items() if key not in self.called],
            "defined": [[key, name, place] for key, (name, place) in self.defined.items()],
            "fixed": self.fixed, "reasons": self.inlined,
            "implicit": {key: sorted(names) for key, names in self.implicit.items()},
            "files": list(self.files), "loaded": self.loaded,
            "packages": {name: str(folder) for name, folder in self.packages.found()},
        }  # fmt: skip

    def source(self, node: ast.expr) -> str:
        return ast.unparse(ast.fix_missing_locations(node))

    def nodes(self, parent: Any) -> Iterator[dict[str, Any]]:
        for node in parent.childNodes:
            if node.nodeType == node.COMMENT_NODE:
                yield {"comment": node.data}
            elif node.nodeType == node.TEXT_NODE:
                if node.data.strip():
                    yield {"text": node.data.strip()}
                elif "\n" in node.data:
                    yield {"text": "", "lines": node.data.count("\n")}
            elif node.nodeType == node.ELEMENT_NODE:
                yield self.element_of(node)

    def element_of(self, node: Any) -> dict[str, Any]:
        place = getattr(node, _MARK, None)
        made: dict[str, Any] = {"place": place, "comments": getattr(node, _COMMENTS, [])}
        if node.tagName == "xacro-call":
            examples = {
                n: v if isinstance(v, (str, int, float, bool)) else None for n, v in node.rosorin_examples.items()
            }
            return {**made, "call": node.getAttribute("macro"), "given": node.rosorin_given, "examples": examples}
        if node.tagName == "xacro-if":
            test = int(TOKEN.fullmatch(node.getAttribute("test"))[1])  # type: ignore[index]
            return {**made, "test": test, "holds": node.getAttribute("holds") == "1", "body": list(self.nodes(node))}
        attributes = dict(node.attributes.items())
        if "filename" in attributes and node.tagName in ("mesh", "texture"):
            attributes["filename"] = self.portable(attributes["filename"])
        return {**made, "tag": node.tagName, "attributes": attributes, "body": list(self.nodes(node))}

    def portable(self, text: str) -> str:
        text = text.removeprefix("file://") if TOKEN.match(text.removeprefix("file://")) else text
        token = TOKEN.match(text)
        if token:
            node = self.tokens[int(token[1])].node
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find":
                return f"package://{node.args[0].value}{text[token.end() :]}"  # type: ignore[attr-defined]
        return portable(text, self.packages, [*map(str, self.xacro.all_includes), self.file])


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


def within(block: Any) -> list[Any]:
    """Return a block and the elements in it."""
    inner = [child for child in block.childNodes if child.nodeType == child.ELEMENT_NODE]
    return [block, *(one for child in inner for one in within(child))]


def only_materials(node: Any, keep: bool) -> bool:
    """Remove all but materials, or (unless ``keep``) the materials; return True if there are any."""
    found = False
    for inner in list(node.childNodes):
        is_group = inner.nodeType == inner.ELEMENT_NODE and inner.tagName in _TRANSPARENT
        is_material = inner.nodeType == inner.ELEMENT_NODE and inner.tagName == "material"
        found = (only_materials(inner, keep) if is_group else is_material) or found
        if not is_group and is_material != keep:
            node.removeChild(inner)
    return found


def as_condition(test: Symbol) -> Symbol:
    """Return a condition of xacro, which may be a text such as "true", as one of Python."""
    if not isinstance(test.value, str):
        return test
    return Symbol(ast.Call(ast.Name("__flag"), [test.node], []), test.value, test.known, test.program)


def place_key(macro: Any) -> str:
    """Return the key of a macro: the place of its definition."""
    return str(getattr(macro.body, _MARK, None))


def is_let(value: Symbol, program: Program) -> bool:
    """Return True if a value is a property or a text, which may have a name."""
    is_text = isinstance(value.node, ast.Call) and getattr(value.node.func, "id", "") == "__join"
    return is_text or (
        isinstance(value.node, ast.Name) and program.variables.get(value.node.id, {}).get("kind") == "let"
    )


def reason_of(problem: BaseException) -> str:
    """Return an error of xacro in one line."""
    return " ".join(str(problem).split())[:120] or type(problem).__name__

"""Evaluate xacro expressions and conditions symbolically.

Each expression is translated to the description language and evaluated once with example values. Elements with a
condition on an argument stay in the document, and properties that they set become conditional expressions. This module
runs in the child process.
"""

from __future__ import annotations

import ast
import glob
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source import files
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from . import ir
from .child import causes, portable

if TYPE_CHECKING:
    from .program import Program

MAX_FILES = 20
_ANGULAR = ("acos", "asin", "atan", "atan2", "radians")
# Python functions and methods that have the same name in the description language.
_FUNCTIONS = """
    abs acos all any asin atan atan2 bool ceil copysign cos cosh degrees enumerate exp float floor fmod gcd hypot int
    isclose len list log log10 log2 max min pow radians range reversed round sin sinh sorted sqrt sum tan tanh trunc zip
"""
_METHODS = "endswith get items join keys lower replace split startswith strip upper values"


class Evaluator:
    """Evaluates expressions in the scope ``symbols``. With ``arguments``, names can be arguments, as in $(eval)."""

    def __init__(self, program: Program, symbols: Any, arguments: bool = False) -> None:
        self.program, self.symbols, self.arguments = program, symbols, arguments

    def eval(self, tree: ast.expr) -> Any:
        """Evaluate an expression to a symbolic value, function or namespace. Raises Untranslatable or Python errors."""
        return getattr(self, f"_{type(tree).__name__.lower()}", self._computed)(tree)

    def _symbol(self, tree: ast.expr) -> ir.Symbol:
        return ir.symbol_of(self.eval(tree))

    def _made(self, tree: ast.expr, node: ast.expr, items: dict[ast.expr, ir.Symbol], kind: str = "") -> ir.Symbol:
        """Return a symbol for ``node``, the translation of ``tree``, with an example value computed from ``items``."""
        known = all(map(ir.is_known, items.values()))
        value: Any = ir.UNKNOWN
        if all(one.value is not ir.UNKNOWN for one in items.values()):
            try:
                value = self._example(tree, items)
            except Exception:
                if known:
                    raise
        return ir.Symbol(node, value, kind or ir.type_of(value), known)

    def _example(self, tree: ast.expr, items: dict[ast.expr, Any]) -> Any:
        """Evaluate an expression in Python, using the example values of the subtrees in ``items``."""
        names = {one: f"_{index}" for index, one in enumerate(items)}
        examples = {names[one]: ir.example_of(value) for one, value in items.items()}
        value = self.program.xacro.safe_eval(ast.unparse(_with_names(tree, names)), examples)
        return list(value) if isinstance(value, Iterator) else value

    def _constant(self, tree: ast.Constant) -> Any:
        made = ir.symbol_of(ir.with_tokens(tree.value) if isinstance(tree.value, str) else tree.value)
        return self._text(made) if isinstance(tree.value, str) and made.type in ("boolean", "number") else made

    def _text(self, item: ir.Symbol) -> ir.Symbol:
        value = ir.UNKNOWN if item.value is ir.UNKNOWN else str(item.value)
        return item if item.type == "text" else ir.Symbol(item.as_text(), value, "text", item.known, [item])

    def _name(self, tree: ast.Name) -> Any:
        if token := ir.TOKEN.fullmatch(tree.id):
            return ir.symbol_of(self.program.literal(ir.Symbol.tokens[int(token[1])]))
        if self.arguments and tree.id in self.program.arguments:
            return ir.symbol_of(self.program.literal(self.program.argument(tree.id)))
        return self.program.read(self.symbols, tree.id)

    def _attribute(self, tree: ast.Attribute) -> Any:
        base = self.eval(tree.value)
        if isinstance(base, self.program.xacro.NameSpace):
            return self.program.read(base, tree.attr, own=True)
        subscript = ast.Subscript(tree.value, ast.Constant(tree.attr), ast.Load())
        return self._entry(subscript, ir.symbol_of(base), ir.symbol_of(tree.attr))

    def _subscript(self, tree: ast.Subscript) -> Any:
        if isinstance(tree.slice, ast.Slice):
            return self._computed(tree)
        return self._entry(tree, self._symbol(tree.value), self._symbol(tree.slice))

    def _entry(self, tree: ast.Subscript, base: ir.Symbol, key: ir.Symbol) -> ir.Symbol:
        node = base.node
        if isinstance(node, ast.Dict) and not key.known and not any(one.owner for one in ir.variables_in([node])):
            self.program.note_comparison([key, ir.symbol_of(list(base.value))])
            variable = self.program.variable("let", "table", base.value, "table")  # a table cannot be in an expression
            variable.symbol, node = base, variable.node
        made = self._made(tree, ast.Subscript(node, key.node, ast.Load()), {tree.value: base, tree.slice: key})
        if isinstance(base.node, ast.Dict) and key.known:
            pairs = zip(base.node.keys, base.node.values, strict=True)
            found = [value for one, value in pairs if getattr(one, "value", None) == key.value]
        elif isinstance(base.node, ast.List) and isinstance(key.node, ast.Constant) and type(key.value) is int:
            found = base.node.elts[key.value : key.value + 1]
        else:
            found = []
        return ir.Symbol(found[0], made.value, made.type, made.known) if found else made

    def _boolop(self, tree: ast.BoolOp) -> ir.Symbol:
        wins = isinstance(tree.op, ast.Or)
        left: list[ir.Symbol] = []
        for item in tree.values:
            value = self._symbol(item)
            decides = value.known and bool(value.value) == wins
            if not value.known or decides or item is tree.values[-1]:
                left.append(value)
            if decides:
                break
        if len(left) > 1 and left[-1].known and bool(left[-1].value) != wins:
            left.pop()
        if len(left) == 1:
            return left[0]
        values = [one.value for one in left]
        found = ir.UNKNOWN if ir.UNKNOWN in values else next((one for one in values if bool(one) == wins), values[-1])
        types = {one.type for one in left}
        nodes = [one.as_truth() if types == {"boolean"} else one.node for one in left]
        return ir.Symbol(ast.BoolOp(tree.op, nodes), found, types.pop() if len(types) == 1 else "", False)

    def _ifexp(self, tree: ast.IfExp) -> Any:
        test = self._symbol(tree.test)
        if test.known:
            return self.eval(tree.body if test.value else tree.orelse)
        return choice(test, self._symbol(tree.body), self._symbol(tree.orelse))

    def _unaryop(self, tree: ast.UnaryOp) -> ir.Symbol:
        item = self._symbol(tree.operand)
        if isinstance(tree.op, ast.Not):
            return self._made(tree, ir.negate(item.as_truth()), {tree.operand: item}, "boolean")
        return self._made(tree, ast.UnaryOp(tree.op, item.as_number()), {tree.operand: item})

    def _binop(self, tree: ast.BinOp) -> Any:
        left, right = self._symbol(tree.left), self._symbol(tree.right)
        if isinstance(tree.op, ast.Mod) and left.type == "text":
            return self._computed(tree)
        if isinstance(tree.op, ast.Add) and left.type == right.type == "text":
            return ir.symbol_of(ir.join_pieces([left, right]))
        return self._made(tree, ast.BinOp(left.node, tree.op, right.node), {tree.left: left, tree.right: right})

    def _compare(self, tree: ast.Compare) -> ir.Symbol:
        sides = {one: self._symbol(one) for one in (tree.left, *tree.comparators)}
        items = [*sides.values()]
        self.program.note_comparison(items)
        node = self._equality(items, tree.ops[0]) if len(items) == 2 else None
        node = node or ast.Compare(items[0].node, tree.ops, [one.node for one in items[1:]])
        return self._made(tree, node, sides, "boolean")

    def _equality(self, items: list[ir.Symbol], operator: ast.cmpop) -> ast.expr | None:
        """Simplify ``flag == 1`` to ``flag``, and similar comparisons with a constant; return None for all others."""
        constants = [one for one in items if one.known and not any(ir.variables_in([one.node]))]
        if not isinstance(operator, (ast.Eq, ast.NotEq)) or not constants:
            return None
        other = constants[-1]
        item = items[0] if other is items[1] else items[1]
        value = ir.literal(other.value)
        if isinstance(item.value, str) != isinstance(other.value, str):
            return None
        if item.type == "boolean" and value in (0, 1):
            return item.node if bool(value) == isinstance(operator, ast.Eq) else ir.negate(item.node)
        if item.type == "number" and isinstance(value, (bool, int, float)):
            number = ir.plain_node(int(value) if isinstance(value, bool) else value)
            return ast.Compare(item.node, [operator], [number])
        return None

    def _list(self, tree: ast.List | ast.Tuple) -> ir.Symbol:
        items = {one: self._symbol(one) for one in tree.elts}
        return self._made(tree, ast.List([one.node for one in items.values()], ast.Load()), items, "list")

    _tuple = _list

    def _dict(self, tree: ast.Dict) -> ir.Symbol:
        items = {one: self._symbol(one) for one in (*tree.keys, *tree.values) if one is not None}
        keys: list[ast.expr | None] = [items[one].node for one in tree.keys if one is not None]
        return self._made(tree, ast.Dict(keys, [items[one].node for one in tree.values]), items, "table")

    def _call(self, tree: ast.Call) -> Any:
        function: Any = tree.func
        owner = self.eval(function.value) if isinstance(function, ast.Attribute) else None
        name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
        if name == "dict" and tree.keywords and not tree.args:
            return self._dict(
                ast.Dict([ast.Constant(one.arg) for one in tree.keywords], [one.value for one in tree.keywords])
            )
        is_plain = not tree.keywords and not any(isinstance(one, ast.Starred) for one in tree.args)
        if isinstance(owner, ir.Symbol) and is_plain and name in _METHODS.split():
            return self._function(tree, name, {function.value: owner})
        if isinstance(owner, ir.Symbol) or not is_plain or any(isinstance(one, ast.Lambda) for one in ast.walk(tree)):
            return self._computed(tree)
        if name == "load_yaml":
            return self.program.named.load(self._symbol(tree.args[0]))
        if name == "dotify":
            return self.eval(tree.args[0])
        if name == "arg":
            return ir.symbol_of(self.program.literal(self.program.argument(str(self._symbol(tree.args[0]).value))))
        if name == "str" and len(tree.args) == 1:
            return self._text(self._symbol(tree.args[0]))
        if name not in _FUNCTIONS.split():
            return self._computed(tree)
        return self._function(tree, name, {})

    def _function(self, tree: ast.Call, name: str, owner: dict[ast.expr, ir.Symbol]) -> ir.Symbol:
        arguments = owner | {one: self._symbol(one) for one in tree.args}
        items = list(arguments.values())
        node: ast.expr = ir.call(name, *(one.node for one in items))
        if name == "split" and items[0].type == "list":
            node = items[0].node
        elif name == "float" and items[0].type == "number":
            node = items[0].as_number()
        elif name in _ANGULAR:
            node = ir.call("float", node)
        called = {} if owner else {tree.func: ir.Symbol(None, self.eval(tree.func), "", True)}
        return self._made(tree, node, arguments | called)

    def _computed(self, tree: ast.expr) -> Any:
        """Evaluate an untranslatable expression in Python. Raises Untranslatable if it is not constant."""
        own = {one.id for one in ast.walk(tree) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}
        own |= {one.arg for one in ast.walk(tree) if isinstance(one, ast.arg)}
        items: dict[ast.expr, Any] = {}
        for one in ast.walk(tree):
            is_text = isinstance(one, ast.Constant) and isinstance(one.value, str) and ir.TOKEN.search(one.value)
            if is_text or (isinstance(one, ast.Name) and one.id not in own):
                items[one] = self.eval(one)  # type: ignore[index, arg-type]
        unknown = [one.node for one in items.values() if not ir.is_known(one)]
        if unknown:
            raise ir.Untranslatable(f"{ir.TOKEN.sub('_', ast.unparse(tree))[:60]} cannot be translated", *unknown)
        value = self._example(tree, items)
        return value if callable(value) else ir.symbol_of(value)


def _with_names(tree: Any, names: dict[ast.expr, str]) -> Any:
    if isinstance(tree, list):
        return [_with_names(one, names) for one in tree]
    if not isinstance(tree, ast.AST):
        return tree
    if tree in names:
        return ast.Name(names[tree], ast.Load())
    return type(tree)(**{field: _with_names(value, names) for field, value in ast.iter_fields(tree)})


def choice(test: ir.Symbol, then: ir.Symbol, other: ir.Symbol) -> ir.Symbol:
    """Return the symbolic value of the expression ``then if test else other``, simplified if possible."""
    node, is_same = _without_not(test.as_truth())
    if not is_same:
        then, other = other, then
    if ir.as_text(then.node) == ir.as_text(other.node):
        return then
    value: Any = ir.UNKNOWN if test.value is ir.UNKNOWN else (then if bool(test.value) == is_same else other).value
    if then.declared_type == other.declared_type == "list":
        return ir.Symbol(ast.IfExp(node, then.as_list(), other.as_list()), value, "list", False)
    return ir.Symbol(ast.IfExp(node, then.node, other.node), value, then.type if then.type == other.type else "", False)


def _without_not(node: ast.expr) -> tuple[ast.expr, bool]:
    """Strip ``not`` operators from a condition; return (condition, False if stripping inverts the condition)."""
    is_same = True
    while isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        node, is_same = node.operand, not is_same
    return node, is_same


class Conditions:
    """Evaluates <xacro:if> and <xacro:unless>; ``assumed`` has the values of the enclosing conditions."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.assumed: dict[str, bool] = {}

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate ``<xacro:if>`` or ``<xacro:unless>``."""
        program, text, holds = self.program, node.getAttribute("value"), node.tagName == "xacro:if"
        program.take_comments(node)
        test = program.eval_text(text, symbols)
        if ir.is_known(test):
            decided: bool | None = bool(program.xacro.get_boolean_value(test, text))
        else:
            if type(ir.literal(test.value)) in (int, float):
                program.note_comparison([test, ir.symbol_of(0), ir.symbol_of(1)])
            plain, is_same = _without_not(test.as_flag())
            found = self.assumed.get(ir.as_text(plain))
            decided = None if found is None else found == is_same
        if decided is None:
            self._branch(node, test, holds, macros, symbols)
        elif decided == holds:
            program.eval_all(node, macros, symbols)
            program.xacro.replace_node(node, by=node, content_only=True)
        else:
            program.xacro.replace_node(node, by=None)

    def _branch(self, node: Any, test: ir.Symbol, holds: bool, macros: Any, symbols: Any) -> None:
        """Evaluate the content of a condition that depends on an argument; properties set there become conditional."""
        program, calls, xacro = self.program, self.program.macro_calls, self.program.xacro
        value = test.value is not ir.UNKNOWN and bool(xacro.get_boolean_value(test, ""))
        test = ir.Symbol(test.as_flag(), value, "boolean", False)
        before = [(table, dict(dict.items(table)), set(table.unevaluated)) for table in self._tables(symbols)]
        every = [one for table in self._tables(macros) for one in dict.values(table)]
        defined = [(macro, macro.body) for macro in every if isinstance(macro, xacro.Macro)]  # others are namespaces
        plain, is_same = _without_not(test.node)
        key = ir.as_text(plain)
        self.assumed[key] = is_same == holds
        node.removeAttribute("value")
        node.tagName = node.nodeName = "xacro-if"
        stacks = [(one, len(one)) for one in (xacro.filestack, xacro.macrostack, calls.paths, calls.building)]
        try:
            program.eval_all(node, macros, symbols)
        except Exception as problem:
            chain = list(causes(problem))
            is_endless = any(isinstance(one, RecursionError) for one in chain)
            if any(isinstance(one, ir.Restart) for one in chain) or (value == holds and not is_endless):
                raise
            reason = f"with another value of it, {' '.join(str(problem).split())[:120] or type(problem).__name__}"
            reason = "it controls how often a macro calls itself" if is_endless else reason
            if is_endless or any(isinstance(one, ir.Untranslatable) for one in chain):
                raise (ir.Restart if program.blame([test.node], reason) else ir.Untranslatable(reason)) from None
            program.refused |= dict.fromkeys(ir.variables_in([test.node]), reason)
            for table, values, unevaluated in before:  # undo the branch: xacro rejects this value
                dict.clear(table)
                dict.update(table, values)
                table.unevaluated = unevaluated
            for stack, length in stacks:
                del stack[length:]
            xacro.replace_node(node, by=None)
            return
        finally:
            self.assumed.pop(key, None)
        if any(macro.body is not body for macro, body in defined):
            raise ir.Untranslatable("a macro is defined in two ways", test.node)
        node.setAttribute("test", str(test))
        node.setAttribute("holds", str(int(holds)))
        for table, values, unevaluated in before:
            for name in [one for one in values if dict.get(table, one) is not values[one]]:
                if not isinstance(dict.get(table, name), (str, int, float, ir.Symbol, list, dict)):
                    continue
                new = table[name]
                dict.__setitem__(table, name, values[name])
                table.unevaluated.discard(name)
                if name in unevaluated:
                    table.unevaluated.add(name)
                then, other = map(ir.symbol_of, (new, table[name]) if holds else (table[name], new))
                dict.__setitem__(table, name, choice(test, then, other))

    def _tables(self, table: Any) -> Iterator[Any]:
        while isinstance(table, self.program.xacro.Table) and table is not table.root:
            yield table
            table = table.parent


class NamedFiles:
    """The ROS packages and YAML files to which a translated description refers."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.copied: dict[str, str] = {}  # file name -> text of a YAML file to copy to the description
        self.folders: dict[str, str] = {}  # package name -> folder
        self.unfound: dict[str, None] = {}  # names of packages that need the option --package
        self._found = Packages({}, os.environ, Path(program.request["folder"], Description.ROOT_FILE))

    def finds(self, package: str) -> bool:
        """Return True if a package is found without --package. Raises Untranslatable if xacro cannot find it at all."""
        folder, found = self.program.packages.find(package), self._found.find(package)
        if folder is None:
            raise ir.Untranslatable(f'the package "{package}" is not found')
        self.folders[package] = str(folder)
        return found is not None and files.resolve(found) == files.resolve(folder)

    def load(self, name: ir.Symbol) -> ir.Symbol:
        """Translate ``load_yaml`` to a call to ``load``; the example value is the content of the YAML file."""
        if name.value is ir.UNKNOWN:
            raise ir.Untranslatable("the file that is loaded is not known", name.node)
        node: ast.expr = ir.plain_node(self._copy(str(name.value)))
        if not name.known:
            for one in ir.variables_in([name.node]):
                one.names_file = True
            self.copy_candidates(name)
            node = ir.symbol_of(ir.join_pieces(self.name_of(ir.pieces_of(name)))).node
        value = self.program.xacro.load_yaml(str(name.value))
        return ir.Symbol(ir.call("load", node), value, ir.type_of(value), name.known)

    def name_of(self, pieces: ir.Pieces) -> ir.Pieces:
        """Convert the name of a YAML file for the description: a ``package://`` URI if the package can be found."""
        first = pieces[0] if pieces else ""
        if not isinstance(first, ir.Symbol) or not first.package:
            return pieces
        start, *rest = ir.pieces_of(ir.join_pieces([f"package://{first.package}", *pieces[1:]]))
        return [self._address(start), *rest]

    def _address(self, name: str) -> str:
        package, _, rest = name.removeprefix("package://").partition("/")
        return name if not name.startswith("package://") or self.finds(package) else rest

    def _copy(self, name: str) -> str:
        """Return the file name to use in the description; copy the file if its package cannot be found."""
        path = os.path.abspath(str(self.program.xacro.abs_filename_spec(name)))
        if "://" in name or name.startswith("/"):
            name = self._address(portable(path, self.program.packages, [*self.program.files, self.program.file]))
        else:
            name = os.path.normpath(name)
            name = Path(name).name if name.startswith("..") else name
        if not name.startswith("package://"):
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise ir.Untranslatable(f"{Path(name).name} is not a file of the xacro or its packages")
            with suppress(OSError, ValueError):  # xacro reports unreadable files
                self.copied[name] = files.read_text(Path(path))
        return name

    def copy_candidates(self, name: ir.Symbol) -> None:
        """Copy the files that a file name with arguments can match; record the argument values as ``candidates``."""
        pattern, form, variables = "", "", []
        for piece in ir.pieces_of(name):
            variable = piece.variable if isinstance(piece, ir.Symbol) else None
            if isinstance(piece, str) or piece.package:
                text = piece if isinstance(piece, str) else str(piece.value)
                pattern, form = pattern + glob.escape(text), form + re.escape(text)
            elif variable is not None and variable.kind == "argument" and variable not in variables:
                variables.append(variable)
                pattern, form = f"{pattern}*", f"{form}([^/]+)"
            else:
                return
        if not variables or not re.search(r"\w", pattern):
            return
        folder = Path(os.path.abspath(self.program.xacro.filestack[-1])).parent
        found = sorted(glob.glob(pattern, root_dir=folder))[:MAX_FILES]  # noqa: PTH207 - the pattern may be absolute
        for match in filter(None, (re.fullmatch(form, path) for path in found)):
            for variable, value in zip(variables, match.groups(), strict=True):
                variable.candidates.append(value)
        for path in found:
            self._copy(path)

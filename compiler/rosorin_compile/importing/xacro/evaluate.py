"""Evaluate the expressions of a xacro: Python computes the example, and the language gets the expression.

This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .nodes import Failed, call, literal, negate, plain_node, variables_in
from .symbols import TOKEN, UNKNOWN, Symbol, example_of, is_known, join_pieces, symbol_of, type_of, with_tokens

if TYPE_CHECKING:
    from .program import Program

_ANGULAR = ("acos", "asin", "atan", "atan2", "radians")
# Functions of Python, of its mathematics and of its texts, lists and tables that the language has by the same name.
_FUNCTIONS = """
    abs acos all any asin atan atan2 bool ceil copysign cos cosh degrees enumerate exp float floor fmod gcd hypot int
    isclose len list log log10 log2 max min pow radians range reversed round sin sinh sorted sqrt sum tan tanh trunc zip
"""
_METHODS = "endswith get items join keys lower replace split startswith strip upper values"


class Evaluator:
    """Evaluates expressions in a table of symbols; with ``arguments``, names are those of arguments, as in $(eval)."""

    def __init__(self, program: Program, symbols: Any, arguments: bool = False) -> None:
        self.program, self.symbols, self.arguments = program, symbols, arguments

    def eval(self, tree: ast.expr) -> Any:
        """Return a symbol, or a function or a name space. Raises what Python raises if it is known, or Failed."""
        method = getattr(self, f"_{type(tree).__name__.lower()}", self._computed)
        return method(tree)

    def _symbol(self, tree: ast.expr) -> Symbol:
        return symbol_of(self.eval(tree))

    def _made(self, node: ast.expr, template: ast.expr, parts: list[Symbol], kind: str = "") -> Symbol:
        """Return a symbol; its example is that of a template with the names _0, _1 for the examples of its parts."""
        known = all(map(is_known, parts))
        value: Any = UNKNOWN
        if all(one.value is not UNKNOWN for one in parts):
            names = {f"_{index}": one.value for index, one in enumerate(parts)}
            try:
                value = self.program.xacro.safe_eval(ast.unparse(ast.fix_missing_locations(template)), names)
            except Exception:
                if known:
                    raise
        value = list(value) if isinstance(value, Iterator) else value
        return Symbol(node, value, kind or type_of(value), known)

    # Names.

    def _constant(self, tree: ast.Constant) -> Any:
        return symbol_of(with_tokens(tree.value) if isinstance(tree.value, str) else tree.value)

    def _name(self, tree: ast.Name) -> Any:
        token = TOKEN.fullmatch(tree.id)
        if token:
            return symbol_of(self.program.literal(Symbol.tokens[int(token[1])]))
        if self.arguments and tree.id in self.program.arguments:
            return symbol_of(self.program.literal(self.program.argument(tree.id)))
        return self.program.read(self.symbols, tree.id)

    def _attribute(self, tree: ast.Attribute) -> Any:
        base = self.eval(tree.value)
        if isinstance(base, self.program.xacro.NameSpace):
            return self.program.read(base, tree.attr, own=True)
        key = ast.Constant(tree.attr)
        return self._entry(symbol_of(base), symbol_of(tree.attr), ast.Subscript(_part(0), key, ast.Load()))

    def _subscript(self, tree: ast.Subscript) -> Any:
        if isinstance(tree.slice, ast.Slice):
            return self._computed(tree)
        template = ast.Subscript(_part(0), _part(1), ast.Load())
        return self._entry(self._symbol(tree.value), self._symbol(tree.slice), template)

    def _entry(self, base: Symbol, key: Symbol, template: ast.expr) -> Symbol:
        made = self._made(ast.Subscript(base.node, key.node, ast.Load()), template, [base, key])
        if isinstance(base.node, ast.Dict) and key.constant is not None:
            pairs = zip(base.node.keys, base.node.values, strict=True)
            found = [value for one, value in pairs if getattr(one, "value", None) == key.constant]
        elif isinstance(base.node, ast.List) and isinstance(key.node, ast.Constant) and type(key.value) is int:
            found = base.node.elts[key.value : key.value + 1]
        else:
            found = []
        return Symbol(found[0], made.value, made.type, made.known) if found else made

    # Operators.

    def _boolop(self, tree: ast.BoolOp) -> Symbol:
        """Return the value of and, or; what is known decides, or is left out."""
        wins = isinstance(tree.op, ast.Or)
        left: list[Symbol] = []
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
        examples = [one.value for one in left]
        found = UNKNOWN if UNKNOWN in examples else next((one for one in examples if bool(one) == wins), examples[-1])
        types = {one.type for one in left}
        nodes = [one.as_truth() if types == {"boolean"} else one.node for one in left]
        return Symbol(ast.BoolOp(tree.op, nodes), found, types.pop() if len(types) == 1 else "", False)

    def _ifexp(self, tree: ast.IfExp) -> Any:
        test = self._symbol(tree.test)
        if test.known:
            return self.eval(tree.body if test.value else tree.orelse)
        return self.program.conditions.choice(test, self._symbol(tree.body), self._symbol(tree.orelse))

    def _unaryop(self, tree: ast.UnaryOp) -> Symbol:
        item = self._symbol(tree.operand)
        if isinstance(tree.op, ast.Not):
            return self._made(negate(item.as_truth()), ast.UnaryOp(ast.Not(), _part(0)), [item], "boolean")
        return self._made(ast.UnaryOp(tree.op, item.as_number()), ast.UnaryOp(tree.op, _part(0)), [item])

    def _binop(self, tree: ast.BinOp) -> Any:
        left, right = self._symbol(tree.left), self._symbol(tree.right)
        if isinstance(tree.op, ast.Mod) and left.type == "text":
            return self._computed(tree)
        if isinstance(tree.op, ast.Add) and left.type == right.type == "text":
            return symbol_of(join_pieces([left, right]))
        template = ast.BinOp(_part(0), tree.op, _part(1))
        return self._made(ast.BinOp(left.node, tree.op, right.node), template, [left, right])

    def _compare(self, tree: ast.Compare) -> Symbol:
        items = [self._symbol(one) for one in (tree.left, *tree.comparators)]
        self.program.note_comparison(items)
        template = ast.Compare(_part(0), tree.ops, [_part(index) for index in range(1, len(items))])
        node = self._equality(items, tree.ops[0]) if len(items) == 2 else None
        node = node or ast.Compare(items[0].node, tree.ops, [one.node for one in items[1:]])
        return self._made(node, template, items, "boolean")

    def _equality(self, items: list[Symbol], operator: ast.cmpop) -> ast.expr | None:
        """Return the comparison of a flag or a number with a constant, which may be a text."""
        item, other = items if not _is_constant(items[0]) else items[::-1]
        value = literal(other.value)
        is_alike = isinstance(item.value, str) == isinstance(other.value, str)
        if not isinstance(operator, (ast.Eq, ast.NotEq)) or not _is_constant(other) or not is_alike:
            return None
        if item.type == "boolean" and value in (0, 1):
            return item.node if bool(value) == isinstance(operator, ast.Eq) else negate(item.node)
        if item.type == "number" and isinstance(value, (bool, int, float)):
            number = plain_node(int(value) if isinstance(value, bool) else value)
            return ast.Compare(item.node, [operator], [number])
        return None

    # Lists, tables and calls.

    def _list(self, tree: ast.List | ast.Tuple) -> Symbol:
        items = [self._symbol(one) for one in tree.elts]
        template = ast.List([_part(index) for index in range(len(items))], ast.Load())
        return self._made(ast.List([one.node for one in items], ast.Load()), template, items, "list")

    _tuple = _list

    def _dict(self, tree: ast.Dict) -> Symbol:
        keys = [self._symbol(one) for one in tree.keys if one is not None]
        return self._table(keys, [self._symbol(one) for one in tree.values])

    def _table(self, keys: list[Symbol], values: list[Symbol]) -> Symbol:
        names: list[Any] = [_part(index) for index in range(len(keys) * 2)]
        template = ast.Dict(names[: len(keys)], names[len(keys) :])
        return self._made(
            ast.Dict([one.node for one in keys], [one.node for one in values]), template, keys + values, "table"
        )

    def _call(self, tree: ast.Call) -> Any:
        function: Any = tree.func
        owner = self.eval(function.value) if isinstance(function, ast.Attribute) else None
        name = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
        if name == "dict" and tree.keywords and not tree.args:
            keys = [symbol_of(one.arg) for one in tree.keywords]
            return self._table(keys, [self._symbol(one.value) for one in tree.keywords])
        is_plain = not tree.keywords and not any(isinstance(one, ast.Starred) for one in tree.args)
        if isinstance(owner, Symbol) and is_plain and name in _METHODS.split():
            return self._function(name, [owner, *map(self._symbol, tree.args)], True)
        if isinstance(owner, Symbol) or not is_plain or any(isinstance(one, ast.Lambda) for one in ast.walk(tree)):
            return self._computed(tree)
        if name == "load_yaml":
            return self.program.loaded.load(self._symbol(tree.args[0]))
        if name == "dotify":
            return self.eval(tree.args[0])
        if name == "arg":
            return symbol_of(self.program.literal(self.program.argument(str(self._symbol(tree.args[0]).value))))
        if name == "str" and len(tree.args) == 1:
            item = self._symbol(tree.args[0])
            value = UNKNOWN if item.value is UNKNOWN else str(item.value)
            return item if item.type == "text" else Symbol(item.as_text(), value, "text", item.known, [item])
        if name not in _FUNCTIONS.split():
            return self._computed(tree)
        return self._function(name, [self._symbol(one) for one in tree.args], False, self.eval(function))

    def _function(self, name: str, items: list[Symbol], is_method: bool, function: Any = None) -> Symbol:
        """Return the call of a function that the language has, too."""
        parts: list[Any] = [_part(index) for index in range(len(items))]
        if is_method:
            template = ast.Call(ast.Attribute(_part(0), name, ast.Load()), parts[1:], [])
        else:
            template = ast.Call(_part(len(items)), parts, [])
        node: ast.expr = call(name, *(one.node for one in items))
        if name == "split" and items[0].type == "list":
            node = items[0].node
        elif name == "float" and items[0].type == "number":
            node = items[0].as_number()
        elif name in _ANGULAR:
            node = call("float", node)
        return self._made(node, template, items if is_method else [*items, Symbol(None, function, "", True)])

    def _computed(self, tree: ast.expr) -> Any:
        """Return the value of what the language has no word for. Raises Failed if it is not known."""
        own = {one.id for one in ast.walk(tree) if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Store)}
        own |= {one.arg for one in ast.walk(tree) if isinstance(one, ast.arg)}
        names = {one.id: self._name(one) for one in ast.walk(tree) if isinstance(one, ast.Name) and one.id not in own}
        texts = {
            one.value: with_tokens(one.value)
            for one in ast.walk(tree)
            if isinstance(one, ast.Constant) and isinstance(one.value, str) and TOKEN.search(one.value)
        }
        unknown = [one.node for one in (*names.values(), *texts.values()) if not is_known(one)]
        if unknown:
            raise Failed(f"{TOKEN.sub('_', ast.unparse(tree))[:60]} cannot be translated", *unknown)
        for one in ast.walk(tree):
            if isinstance(one, ast.Constant) and one.value in texts:
                one.value = example_of(texts[one.value])
        value = self.program.xacro.safe_eval(ast.unparse(tree), {key: example_of(one) for key, one in names.items()})
        if callable(value):
            return value
        return symbol_of(list(value) if isinstance(value, Iterator) else value)


def _is_constant(item: Symbol) -> bool:
    return item.known and not any(variables_in([item.node]))


def _part(index: int) -> ast.expr:
    return ast.Name(f"_{index}", ast.Load())

"""Conditions while xacro runs with symbols.

What a condition that depends on an argument contains stays in the document, and properties that it sets depend on it.
This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from copy import copy
from typing import TYPE_CHECKING, Any

from .child import causes
from .symbols import UNKNOWN, Failed, Restart, Symbol, as_condition, example_of, is_known, node_of

if TYPE_CHECKING:
    from .symbolic import Program


class Conditions:
    """The conditions of one run; ``assumed`` are those of the branches that are evaluated, as formulas."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.assumed: dict[str, bool] = {}

    def choice(self, test: Symbol, then: Any, other: Any) -> Any:
        """Return one of two values, by a condition."""
        node, positive = _without_not(test.node)
        if not positive:
            value = UNKNOWN if test.value is UNKNOWN else not test.value
            test, then, other = Symbol(node, value, False, self.program), other, then
        nodes = [node_of(then), node_of(other)]
        for index, name in ((0, "body"), (1, "orelse")):
            inner: Any = nodes[index]
            while isinstance(inner, ast.IfExp) and ast.dump(inner.test) == ast.dump(node):
                inner = getattr(inner, name)
            nodes[index] = inner
        if ast.dump(nodes[0]) == ast.dump(nodes[1]):
            return then
        value = UNKNOWN if test.value is UNKNOWN else example_of(then if self._holds(test.value) else other)
        return Symbol(ast.IfExp(node, *nodes), value, False, self.program)

    def _holds(self, value: Any) -> bool:
        return value is not UNKNOWN and bool(self.program.xacro.get_boolean_value(value, ""))

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate ``<xacro:if>`` or ``<xacro:unless>``."""
        program, text, holds = self.program, node.getAttribute("value"), node.tagName == "xacro:if"
        program.take_comments(node)
        test = program.eval_text(text, symbols)
        if is_known(test):
            decided: bool | None = bool(program.xacro.get_boolean_value(test, text))
        else:
            if type(program.own_literal(test.value)) in (int, float):
                program.note_comparison([test, 0, 1])
            plain, positive = _without_not(test.node)
            found = self.assumed.get(ast.dump(plain))
            decided = None if found is None else found == positive
        if decided is None:
            self.branch(node, test, holds, macros, symbols)
        elif decided == holds:
            program.eval_all(node, macros, symbols)
            program.xacro.replace_node(node, by=node, content_only=True)
        else:
            program.xacro.replace_node(node, by=None)

    def branch(self, node: Any, test: Symbol, holds: bool, macros: Any, symbols: Any) -> None:
        """Evaluate what depends on a condition, and let the properties that it sets depend on it, too."""
        program, xacro = self.program, self.program.xacro
        before = list(self._state(symbols))
        defined = [
            (table, name, copy(macro))
            for table, values, _ in self._state(macros)
            for name, macro in values.items()
            if isinstance(macro, xacro.Macro)
        ]
        plain, positive = _without_not(test.node)
        key = ast.dump(plain)
        self.assumed[key] = positive == holds
        if node.hasAttribute("value"):
            node.removeAttribute("value")
        node.tagName = node.nodeName = "xacro-if"
        lists = [(some, len(some)) for some in (xacro.filestack, xacro.macrostack, program.macro_calls.levels)]
        depth = program.macro_calls.depth
        try:
            program.eval_all(node, macros, symbols)
        except Exception as problem:
            self._check_failure(problem, test, holds)
            for table, values, unevaluated in before:  # xacro refuses the other value as well
                dict.clear(table)
                dict.update(table, values)
                table.unevaluated = unevaluated
            for some, length in lists:
                del some[length:]
            program.macro_calls.depth = depth
            xacro.replace_node(node, by=None)
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
            for name in [one for one in values if dict.get(table, one) is not values[one]]:
                if not isinstance(dict.get(table, name), (str, int, float, Symbol, list, dict)):
                    continue
                new = table[name]
                dict.__setitem__(table, name, values[name])
                table.unevaluated.discard(name)
                if name in unevaluated:
                    table.unevaluated.add(name)
                then, other = (new, table[name]) if holds else (table[name], new)
                dict.__setitem__(table, name, self.choice(as_condition(test), then, other))
                program.bound.pop((id(table), name), None)

    def _check_failure(self, problem: Exception, test: Symbol, holds: bool) -> None:
        """Raise unless xacro refuses the other value of a condition, too."""
        chain = list(causes(problem))
        if any(isinstance(one, Restart) for one in chain):
            raise Restart from None
        is_endless = any(isinstance(one, RecursionError) for one in chain)
        is_taken = self._holds(test.value) == holds and test.value is not UNKNOWN
        if not is_taken and not is_endless and not any(isinstance(one, Failed) for one in chain):
            return
        reason = " ".join(str(problem).split())[:120] or type(problem).__name__
        if (is_taken and not is_endless) or not self.program.blame(test.node, f"with another value of it, {reason}"):
            raise problem
        raise Restart from None

    def _state(self, table: Any) -> Iterator[tuple[Any, dict[str, Any], set[str]]]:
        """Yield a table and those above it with their values."""
        while isinstance(table, self.program.xacro.Table) and table is not table.root:
            yield table, dict(dict.items(table)), set(table.unevaluated)
            table = table.parent


def _without_not(node: ast.expr) -> tuple[ast.expr, bool]:
    """Return a condition without ``not``, and whether it is the same then."""
    is_same = True
    while isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        node, is_same = node.operand, not is_same
    return node, is_same

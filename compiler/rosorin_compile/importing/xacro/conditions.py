"""Conditions, and YAML files that arguments choose, while xacro runs with symbols.

What a condition that depends on an argument contains stays in the document, and properties that it sets depend on it.
This module runs in the child process.
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

from rosorin_compile.source.files import read_text

from .child import causes, portable
from .nodes import Failed, as_text, call, literal, plain_node, variables_in
from .symbols import UNKNOWN, Pieces, Restart, Symbol, is_known, join_pieces, pieces_of, symbol_of, type_of

if TYPE_CHECKING:
    from .program import Program

MAX_FILES = 20


class Conditions:
    """The conditions of one run; ``assumed`` are those of the branches that are evaluated, as text."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.assumed: dict[str, bool] = {}

    def choice(self, test: Symbol, then: Symbol, other: Symbol) -> Symbol:
        """Return one of two values, by a condition."""
        node, positive = _without_not(test.as_truth())
        if not positive:
            then, other = other, then
        if as_text(then.node) == as_text(other.node):
            return then
        value: Any = UNKNOWN if test.value is UNKNOWN else (then if bool(test.value) == positive else other).value
        if then.declared_type == other.declared_type == "list":
            return Symbol(ast.IfExp(node, then.as_list(), other.as_list()), value, "list", False)
        return Symbol(
            ast.IfExp(node, then.node, other.node), value, then.type if then.type == other.type else "", False
        )

    def element(self, node: Any, macros: Any, symbols: Any) -> None:
        """Evaluate ``<xacro:if>`` or ``<xacro:unless>``."""
        program, text, holds = self.program, node.getAttribute("value"), node.tagName == "xacro:if"
        program.take_comments(node)
        test = program.eval_text(text, symbols)
        if is_known(test):
            decided: bool | None = bool(program.xacro.get_boolean_value(test, text))
        else:
            if type(literal(test.value)) in (int, float):
                program.note_comparison([test, symbol_of(0), symbol_of(1)])
            plain, positive = _without_not(test.as_flag())
            found = self.assumed.get(as_text(plain))
            decided = None if found is None else found == positive
        if decided is None:
            self._branch(node, test, holds, macros, symbols)
        elif decided == holds:
            program.eval_all(node, macros, symbols)
            program.xacro.replace_node(node, by=node, content_only=True)
        else:
            program.xacro.replace_node(node, by=None)

    def _branch(self, node: Any, test: Symbol, holds: bool, macros: Any, symbols: Any) -> None:
        """Evaluate what depends on a condition, and let the properties that it sets depend on it, too."""
        program, xacro = self.program, self.program.xacro
        value = test.value is not UNKNOWN and bool(xacro.get_boolean_value(test, ""))
        test = Symbol(test.as_flag(), value, "boolean", False)
        before = list(self._state(symbols))
        defined = [(macro, macro.body) for _, values, _ in self._state(macros) for macro in values.values()]
        plain, positive = _without_not(test.node)
        key = as_text(plain)
        self.assumed[key] = positive == holds
        node.removeAttribute("value")
        node.tagName = node.nodeName = "xacro-if"
        lists = [(some, len(some)) for some in (xacro.filestack, xacro.macrostack, program.macro_calls.paths)]
        depth = program.macro_calls.depth
        try:
            program.eval_all(node, macros, symbols)
        except Exception as problem:
            chain = list(causes(problem))
            is_endless = any(isinstance(one, RecursionError) for one in chain)
            if any(isinstance(one, Restart) for one in chain) or (value == holds and not is_endless):
                raise
            reason = f"with another value of it, {' '.join(str(problem).split())[:120] or type(problem).__name__}"
            if is_endless or any(isinstance(one, Failed) for one in chain):
                if not program.blame([test.node], reason):
                    raise
                raise Restart from None
            program.refused |= dict.fromkeys(variables_in([test.node]), reason)
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
        if any(macro.body is not body for macro, body in defined):
            raise Failed("a macro is defined in two ways", test.node)
        node.setAttribute("test", str(test))
        node.setAttribute("holds", str(int(holds)))
        for table, values, unevaluated in before:
            for name in [one for one in values if dict.get(table, one) is not values[one]]:
                if not isinstance(dict.get(table, name), (str, int, float, Symbol, list, dict)):
                    continue
                new = table[name]
                dict.__setitem__(table, name, values[name])
                table.unevaluated.discard(name)
                if name in unevaluated:
                    table.unevaluated.add(name)
                then, other = map(symbol_of, (new, table[name]) if holds else (table[name], new))
                dict.__setitem__(table, name, self.choice(test, then, other))

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


class LoadedFiles:
    """The YAML files that a run loads; ``copied`` are those that the description cannot find in a package."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.copied: dict[str, str] = {}

    def load(self, name: Symbol) -> Symbol:
        """Return the table of a YAML file."""
        if name.value is UNKNOWN:
            raise Failed("the file that is loaded is not known", name.node)
        node: ast.expr = plain_node(self._address(str(name.value)))
        if not name.known:
            for one in variables_in([name.node]):
                one.names_file = True
            for path in self._candidates(name):
                self._address(path)
            node = symbol_of(join_pieces(self.name_of(pieces_of(name)))).node
        value = self.program.xacro.load_yaml(str(name.value))
        return Symbol(call("load", node), value, type_of(value), name.known)

    def name_of(self, pieces: Pieces) -> Pieces:
        """Return the name by which the description finds a YAML file; for one in a package its address."""
        first = pieces[0] if pieces else ""
        if not isinstance(first, Symbol) or not first.package:
            return pieces
        start, *rest = pieces_of(join_pieces([f"package://{first.package}", *pieces[1:]]))
        return [self.program.packages_named.address(start), *rest]

    def _address(self, name: str) -> str:
        """Return the name of a YAML file in the description, to which it is copied unless that finds its package."""
        path = os.path.abspath(str(self.program.xacro.abs_filename_spec(name)))
        if "://" not in name and not name.startswith("/"):
            name = os.path.normpath(name)
            name = Path(name).name if name.startswith("..") else name
        else:
            name = portable(path, self.program.packages, [*self.program.files, self.program.file])
            name = self.program.packages_named.address(name)
        if not name.startswith("package://"):
            if Path(name).is_absolute() or ".." in Path(name).parts:
                raise Failed(f"{Path(name).name} is not a file of the xacro or its packages")
            with suppress(OSError, ValueError):  # xacro cannot read it either
                self.copied[name] = read_text(Path(path))
        return name

    def _candidates(self, name: Symbol) -> list[str]:
        """Return the files that arguments in a name choose from, and record the values that choose them."""
        pattern, form, variables = "", "", []
        for piece in pieces_of(name):
            variable = piece.variable if isinstance(piece, Symbol) else None
            if isinstance(piece, str) or piece.package:
                text = piece if isinstance(piece, str) else str(piece.value)
                pattern, form = pattern + glob.escape(text), form + re.escape(text)
            elif variable is not None and variable.kind == "argument" and variable not in variables:
                variables.append(variable)
                pattern, form = f"{pattern}*", f"{form}([^/]+)"
            else:
                return []
        if not re.search(r"\w", pattern):
            return []
        folder = Path(os.path.abspath(self.program.xacro.filestack[-1])).parent
        found = sorted(glob.glob(pattern, root_dir=folder))[:MAX_FILES]  # noqa: PTH207 - an absolute pattern, too
        for match in filter(None, (re.fullmatch(form, path) for path in found)):
            for variable, value in zip(variables, match.groups(), strict=True):
                variable.candidates.append(value)
        return found

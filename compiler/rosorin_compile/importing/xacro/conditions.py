"""Conditions, and files and macros that arguments choose, while xacro runs with symbols.

What a condition that depends on an argument contains stays in the document, and properties that it sets depend on it.
An include or a call whose name depends on arguments becomes one for each file or macro that fits, on the condition that
the arguments have the values that name it. This module runs in the child process.
"""

from __future__ import annotations

import ast
import glob
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from copy import copy
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .child import causes, portable
from .macro_calls import copy_marks
from .symbols import (
    UNKNOWN,
    Failed,
    Restart,
    Symbol,
    as_condition,
    example_of,
    is_find,
    is_known,
    join,
    names_in,
    node_of,
    parts_of,
)

if TYPE_CHECKING:
    from .symbolic import Program

MAX_FILES = 20


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


class ChosenFiles:
    """The files and macros that a run chooses; ``loaded`` are YAML files by their name in the description."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.loaded: dict[str, str] = {}

    def load(self, name: Any) -> Symbol:
        """Return the table of a YAML file, which an argument may choose."""
        path = example_of(name)
        if path is UNKNOWN:
            raise Failed("the file that is loaded is not known", node_of(name))
        node: Any = ast.Constant(self.address(str(path)))
        if not is_known(name):
            self.note_files(name)
            parts = parts_of(name.node)
            if is_find(parts[0]):
                parts[0] = ast.Constant(f"package://{parts[0].args[0].value}")
            node = join(parts)
        value = self.program.xacro.load_yaml(str(path))
        return Symbol(ast.Call(ast.Name("load"), [node], []), value, is_known(name), self.program)

    def address(self, name: str) -> str:
        """Return the name of a YAML file in the description, and record the file."""
        path = os.path.abspath(str(self.program.xacro.abs_filename_spec(name)))
        if "://" not in name and not name.startswith("/"):
            name = os.path.normpath(name)
            name = Path(name).name if name.startswith("..") else name
        else:
            name = portable(path, self.program.packages, [*self.program.files, self.program.file])
        self.loaded[name] = path
        return name

    def note_files(self, name: Any) -> None:
        """Record the YAML files that an argument chooses from."""
        base = self.folder()
        for one in names_in(name.node) & self.program.variables.keys():
            self.program.variables[one]["names_file"] = True
        with suppress(Failed):
            for _, path in self.matching(name.node, "load"):
                self.address(os.path.relpath(path, base) if path.startswith(base) else path)

    def folder(self) -> str:
        """Return the folder of the file that is read."""
        return str(Path(os.path.abspath(self.program.xacro.filestack[-1])).parent)

    def matching(self, node: Any, what: str) -> list[tuple[dict[str, str], str]]:
        """Return the files with a name that depends on arguments, each with their values. Raises Failed."""
        pattern, form = self._patterns(node, f"the file to {what} is chosen by an expression", "argument")
        if not re.search(r"\w", pattern):
            raise Failed(f"the file to {what} is named by it", node)
        base = "" if pattern.startswith("/") else f"{self.folder()}/"
        paths = sorted(glob.glob(glob.escape(base) + pattern))[:MAX_FILES]  # noqa: PTH207 - an absolute pattern, too
        return self._matches(node, re.escape(base) + form, filter(os.path.isfile, paths))

    def matching_macros(self, node: Any, macros: Any) -> list[tuple[dict[str, str], str]]:
        """Return the macros with a name that depends on variables, each with their values. Raises Failed."""
        _, form = self._patterns(node, "the macro that is called is named by an expression")
        defined: list[str] = []
        while isinstance(macros, dict):
            defined += [one for one in dict.keys(macros) if isinstance(one, str)]
            macros = vars(macros).get("parent") if hasattr(macros, "__dict__") else None
        return self._matches(node, form, defined)

    def _patterns(self, node: Any, reason: str, kind: str = "") -> tuple[str, str]:
        """Return the names that a formula may have as a pattern of files, and as a regular expression."""
        pattern = form = ""
        for part in parts_of(node):
            variable = self.program.variables.get(getattr(part, "id", ""))
            if variable is not None and kind in ("", variable["kind"]):
                form += f"(?P={part.id})" if f"(?P<{part.id}>" in form else f"(?P<{part.id}>[^/]+)"
                pattern += "*"
                continue
            if is_find(part):
                text = self.program.share(part.args[0].value)
            elif isinstance(part, ast.Constant):
                text = str(part.value)
            else:
                raise Failed(reason, node)
            pattern, form = pattern + glob.escape(text), form + re.escape(text)
        return pattern, form

    def _matches(self, node: ast.AST, form: str, names: Iterable[str]) -> list[tuple[dict[str, str], str]]:
        found = [(match.groupdict(), one) for one in dict.fromkeys(names) if (match := re.fullmatch(form, one))]
        if not found:
            raise Failed("no file or macro has that name", node)
        for values, _ in found:
            for name, value in values.items():
                self.program.candidates.setdefault(name, []).append(value)
        return found

    def alternatives(
        self, node: Any, attribute: str, chosen: list[tuple[dict[str, str], str]], macros: Any, symbols: Any
    ) -> None:
        """Replace an element with an attribute that depends on variables by one for each of their values."""
        program = self.program
        program.take_comments(node)
        for values, text in chosen:
            made, inner = node.ownerDocument.createElement("xacro:if"), node.cloneNode(deep=True)
            inner.setAttribute(attribute, text.replace("${", "$${"))
            made.appendChild(inner)
            copy_marks(node, made)
            node.parentNode.insertBefore(made, node)
            tests: list[ast.expr] = [
                ast.Compare(ast.Name(one, ast.Load()), [ast.Eq()], [ast.Constant(v)]) for one, v in values.items()
            ]
            test = tests[0] if len(tests) == 1 else ast.BoolOp(ast.And(), tests)
            holds = all(str(program.variables[one]["value"]) == value for one, value in values.items())
            program.conditions.branch(made, Symbol(test, holds, False, program), True, macros, symbols)
        node.parentNode.removeChild(node)

"""Files and macros that arguments choose by their names, while xacro runs with symbols.

An include or a call whose name depends on arguments becomes one for each file or macro that fits, on the condition that
the arguments have the values that name it. This module runs in the child process.
"""

from __future__ import annotations

import ast
import glob
import os
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .child import portable
from .macro_calls import copy_marks
from .symbols import UNKNOWN, Failed, Symbol, example_of, is_find, is_known, join, names_in, node_of, parts_of

if TYPE_CHECKING:
    from .symbolic import Program

MAX_FILES = 20


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
        return self._matches(re.escape(base) + form, filter(os.path.isfile, paths))

    def matching_macros(self, node: Any, macros: Any) -> list[tuple[dict[str, str], str]]:
        """Return the macros with a name that depends on variables, each with their values. Raises Failed."""
        _, form = self._patterns(node, "the macro that is called is named by an expression")
        defined: list[str] = []
        while isinstance(macros, dict):
            defined += [one for one in dict.keys(macros) if isinstance(one, str)]
            macros = vars(macros).get("parent") if hasattr(macros, "__dict__") else None
        return self._matches(form, defined)

    def _patterns(self, node: Any, reason: str, kind: str = "") -> tuple[str, str]:
        """Return the names that a formula may have as a pattern of files, and as a regular expression."""
        pattern = form = ""
        for part in parts_of(node):
            if isinstance(part, ast.Name) and (not kind or self.program.variables[part.id]["kind"] == kind):
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

    def _matches(self, form: str, names: Iterable[str]) -> list[tuple[dict[str, str], str]]:
        found = [(match.groupdict(), one) for one in dict.fromkeys(names) if (match := re.fullmatch(form, one))]
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

"""Write the intermediate representation of a xacro as the documents of a description, in one pass.

What nothing uses is left out. This module runs in the child process, and the documents are its answer.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.xml_reader import ANGLES
from rosorin_compile.source.project import Description
from rosorin_compile.source.xml.markup import COMMENT

from ..layout import Expression, Verbatim, clean_comment
from .entries import Entries, conditional, merge
from .ir import Call, Comment, Element, If, Macro, Words, expressions_in, nodes_of, walk
from .symbols import (
    Failed,
    Restart,
    Symbol,
    Variable,
    all_of,
    as_text,
    fold,
    literal,
    pieces_of,
    symbol_of,
    usable,
    variables_in,
    with_tokens,
)
from .values import Values, number

if TYPE_CHECKING:
    from .program import Program

PROBE = "probe_"  # a text that an argument has in no condition
_MARKS: dict[type, str] = {Expression: "$", Verbatim: "#"}


class Writer:
    """Writes a program. ``documents`` are the sections by file, and ``remarks`` their comments by file and path."""

    def __init__(self, program: Program) -> None:
        self.program = program
        self.documents: dict[str, dict[str, Any]] = {}
        self.remarks: list[tuple[str, tuple[Any, ...], list[str]]] = []
        self.file_names = _file_names(program)
        self.macros = list(program.macro_calls.macros.values())
        self.values = Values(program, program.request["meshes"])
        self.entries = Entries(self.values, self.write_macro)
        self._written: dict[Macro, dict[str, Any]] = {}
        self._macro: Macro | None = None  # the macro that is written
        self._part: dict[str, Any] = {}  # its entry, if it is a part
        self._keys: set[str] = set()
        self._alternatives: dict[tuple[int, str], list[Any]] = {}

    def answer(self, document: Any) -> dict[str, Any]:
        """Return the description as JSON: its documents, arguments and macros, and what was given up."""
        program, root = self.program, document.documentElement
        body = nodes_of(root)
        self._name_macros()
        for macro in self.macros:
            self.write_macro(macro)
        with self._within(None):
            self._body(body, None)
            name = self.values.text(pieces_of(with_tokens(root.getAttribute("name"))))
        self._propagate()
        before = -1
        while before != (before := sum(one.used for one in program.variables)):
            self._write_arguments()
            self._write_lets(None)
        for file in self.file_names.values():
            self.documents.setdefault(file, {})
        called, defined = program.macro_calls.called, program.defined
        lost = []
        for key, reason in program.inlined.items():
            if called.get(key) and key in defined:
                name_in_source, (file, offset, _) = defined[key]
                source = program.parsed[file].source
                at = f"{Path(source.path).name}:{source.text.count(chr(10), 0, offset) + 1}"
                lost.append([name_in_source, reason, at])
        return {
            "documents": encode(self.documents),
            "heads": {self.file_names[index]: comments_before(one) for index, one in program.parsed.items()},
            "remarks": self.remarks,
            "name": encode(name),
            "copied": program.named.copied,
            "packages": program.named.folders,
            "unfound": list(program.named.unfound),
            "arguments": [self._argument(one) for one in program.arguments.values()],
            "macros": [[one.name, one.ours, one.key] for one in self.macros],
            "lost": lost,
            "silent": [defined[key][0] for key, has_made in called.items() if not has_made and key in defined],
            "uncalled": [name for key, (name, _) in defined.items() if key not in called],
            "inlined": program.inlined,
            "fixed": program.fixed,
        }

    # Names and places.

    def _name_macros(self) -> None:
        """Give macros unique names, and find the variables that are names of files."""
        parts: set[str] = set()
        for macro in self.macros:
            if macro.level == "robot":
                macro.ours = _free(macro.name.replace(".", "_"), parts)
                parts.add(macro.ours)
            else:
                macro.ours = usable(macro.name, self.program.names)
                self.program.names.add(macro.ours)
            for node in walk(macro.body):
                pieces = node.attributes.get("filename", []) if isinstance(node, Element) else []
                is_sole = len(pieces) == 1 and isinstance(pieces[0], Symbol) and pieces[0].variable is not None
                if is_sole and node.tag in ("mesh", "texture"):
                    pieces[0].variable.names_mesh = True
        self._propagate()

    def _propagate(self) -> None:
        """Let variables have what is known of those that they are given to as they are."""
        given = [(one.symbol, one) for one in self.program.variables if one.symbol is not None]
        for macro in self.macros:
            given += [
                (symbol, macro.parameters[key]) for call in macro.calls for key, (symbol, _) in call.given.items()
            ]
        pairs = [(symbol.variable, target) for symbol, target in given if symbol.variable is not None]
        for _ in range(len(self.macros) + 1):  # macros that call each other are written out
            for source, target in pairs:
                source.names_mesh |= target.names_mesh
                source.names_file |= target.names_file
                source.printed |= target.printed
                source.candidates = list(dict.fromkeys([*source.candidates, *target.candidates]))

    def _section(self, place: Any, key: str) -> dict[str, Any]:
        return self.documents.setdefault(self._file(place), {}).setdefault(key, {})  # type: ignore[no-any-return]

    def _file(self, place: Any) -> str:
        return self.file_names[place[0]] if place is not None else Description.ROOT_FILE

    def _remark(self, place: Any, path: tuple[Any, ...], comments: Iterable[str]) -> None:
        lines = [line for comment in comments for line in clean_comment(comment)]
        remark = (self._file(place), path, lines)
        if lines and remark not in self.remarks:
            self.remarks.append(remark)

    @contextmanager
    def _within(self, macro: Macro | None, node: Element | Call | None = None) -> Iterator[None]:
        """Write a node in a macro; give up the macro, or what the node depends on, if it cannot be written."""
        before, self._macro = self._macro, macro
        try:
            yield
        except Failed as problem:
            macro = node.macro if macro is None and isinstance(node, Call) else macro
            inner = [] if node is None else [node, *walk(getattr(node, "body", []))]
            nodes = problem.nodes or [expression for one in inner for expression in expressions_in(one)]
            if macro is not None:
                self.program.inlined[macro.key] = str(problem)
            elif not self.program.blame(nodes, str(problem)):
                raise
            raise Restart from None
        finally:
            self._macro = before

    # What is at the level of links.

    def _body(self, nodes: list[Any], when: ast.expr | None) -> None:
        """Write what is at the level of links: of the robot, or of the part that is written."""
        comments: list[str] = []
        for node in nodes:
            if isinstance(node, Comment):
                comments.append(node.text)
                continue
            if isinstance(node, If):
                condition = all_of(when, self.entries.condition(node))
                if condition is None or fold(condition) is not False:
                    self._body([*map(Comment, comments), *node.body], condition)
            elif isinstance(node, Words):
                raise Failed("text among links")
            else:
                with self._within(self._macro, node):
                    write = self._use if isinstance(node, Call) else self._entry
                    write(node, when, [*comments, *node.comments])
            comments = []

    def _place_of(self, node: Element | Call) -> tuple[Any, tuple[Any, ...], dict[str, Any]]:
        """Return where a node is written: the place that has the file, the path in it, and the mapping."""
        macro = self._macro
        if macro is not None:
            return macro.place, ("parts", macro.ours), self._part
        return node.place, (), self.documents.setdefault(self._file(node.place), {})

    def _entry(self, node: Element, when: ast.expr | None, comments: list[str]) -> None:
        place, path, document = self._place_of(node)
        if node.tag == "material":
            if self._macro is not None:  # the robot has it
                inner = [node, *walk(node.body)]
                read = variables_in(expression for one in inner for expression in expressions_in(one))
                if when is not None or any(one.owner for one in read):
                    raise Failed("it defines materials of several values, which the robot shares")
                document = self.documents.setdefault(self._file(place), {})
            name = self.values.text(node.attributes.get("name", []))
            value = self.entries.finish(self.entries.fragment(node.body, "material"))
            holder = next((one for one in self.documents.values() if name in one.get("materials", ())), document)
            section = holder.setdefault("materials", {})
            known = self._alternatives.get((id(section), str(name)), [])
            if not known or known[-1][1] is not None:  # the first one that is always there is it
                self._put(section, name, value, when)
                self._remark(place, ("materials", name), comments)
        elif node.tag in ("link", "joint"):
            key = self.values.text(node.attributes.get("name", []))
            value = self.entries.link(node) if node.tag == "link" else self.entries.joint(node)
            section = document.setdefault(f"{node.tag}s", {})
            self._put(section, key, value, when)
            self._remark(place, (*path, f"{node.tag}s", key), [*comments, *self.entries.inner])
        else:
            made = document.setdefault("urdf_elements", [])
            self._remark(place, (*path, "urdf_elements", len(made)), comments)
            made.append(conditional(self.entries.xml(node), when))

    def _put(self, section: dict[Any, Any], key: Any, value: Any, when: ast.expr | None) -> None:
        """Add an entry; entries of one name on different conditions become one."""
        known = self._alternatives.setdefault((id(section), str(key)), [])
        known.append((value, when))
        chosen = merge("", known)
        if chosen is None:
            raise Failed(f'there are several entries "{key}"', *(one for _, one in known if one is not None))
        section[key] = chosen

    # Macros: parts and named values.

    def write_macro(self, macro: Macro) -> dict[str, Any]:
        """Write a macro, unless that is done; return the keys of a named value."""
        if macro in self._written:
            return self._written[macro]
        self._written[macro] = {}
        inner = self.entries.inner
        with self._within(macro):
            if macro.level == "robot":
                self._write_part(macro)
            else:
                value, keys = self.entries.named_value(macro)
                names = ", ".join(one.ours for one in macro.parameters.values())
                self._section(macro.place, "let")[f"{macro.ours}({names})"] = value
                self._remark(macro.place, ("let", f"{macro.ours}({names})"), [*macro.comments, *self.entries.inner])
                self._written[macro] = keys
        self.entries.inner = inner
        return self._written[macro]

    def _write_part(self, macro: Macro) -> None:
        path = ("parts", macro.ours)
        outer, self._part = self._part, {}
        self._body(macro.body, None)
        made, self._part = self._part, outer
        made["let"] = self._write_lets(macro, path)
        made["params"] = params = {}
        for name, variable in macro.parameters.items():
            params[variable.ours] = entry = dict[str, Any]()
            if variable.type in ("text", "boolean", "list", "number"):
                entry["type"] = variable.type
            if (default := self._default_of(macro, name)) is not None:
                value = self.values.value(default, variable)
                entry["default"] = Expression("${none}") if value is None else value
        order = ("params", "let", "links", "joints", "use", "urdf_elements")
        self._section(macro.place, "parts")[macro.ours] = {key: made[key] for key in order if made.get(key)}
        self._remark(macro.place, path, macro.comments)

    def _default_of(self, macro: Macro, name: str) -> Symbol | None:
        """Return the default of a parameter, if it is the same in all calls."""
        found = {as_text(one.given[name][0].node): one.given[name][0] for one in macro.calls if one.given[name][1]}
        if len(found) != 1:
            return None
        symbol = next(iter(found.values()))
        is_hidden = any(one.owner or one.ours == macro.parameters[name].ours for one in variables_in([symbol.node]))
        return None if is_hidden else symbol

    def _use(self, call: Call, when: ast.expr | None, comments: list[str]) -> None:
        """Write a call of a macro that is a part."""
        macro = call.macro
        self.write_macro(macro)
        passed: dict[str, Any] = {}
        for name, variable in macro.parameters.items():
            symbol, is_default = call.given[name]
            if not is_default or self._default_of(macro, name) is None:
                passed[variable.ours] = self.values.value(symbol, variable, ANGLES if name.endswith("rpy") else "")
        place, path, document = self._place_of(call)
        section = document.setdefault("use", {})
        names = [pieces_of(call.given[one][0]) for one in ("name", "prefix") if one in call.given]
        last = next((pieces[-1] for pieces in names if pieces and isinstance(pieces[-1], str)), "")
        words = [re.sub(r"[^\w-]+", "_", last).strip("_"), macro.ours]
        key = _free("_".join(dict.fromkeys(filter(None, words))), section if path else self._keys)
        if not path:
            self._keys.add(key)
        section[key] = conditional({"part": macro.ours, "prefix": "", **({"with": passed} if passed else {})}, when)
        self._remark(place, (*path, "use", key), comments)

    # Properties and arguments.

    def _write_lets(self, macro: Macro | None, path: tuple[Any, ...] = ()) -> dict[str, Any]:
        """Write the properties of a macro, or of the robot, that are used, in their order; return those of a macro."""
        owner = macro.key if macro is not None else ""
        lets = [one for one in self.program.variables if one.kind == "let" and one.owner == owner]
        values: dict[Variable, Any] = {}
        while waiting := [one for one in lets if one.used and one not in values]:
            for variable in waiting:
                with self._within(self._macro):
                    is_literal, symbol = bool(variable.digits), symbol_of(variable.symbol)
                    values[variable] = (
                        number(variable.digits, "") if is_literal else self.values.value(symbol, variable)
                    )
        lets_of_macro: dict[str, Any] = {}
        for variable in [one for one in lets if one in values]:
            section = lets_of_macro if macro is not None else self._section(variable.place, "let")
            section[variable.ours] = values[variable]
            place = macro.place if macro is not None else variable.place
            self._remark(place, (*path, "let", variable.ours), variable.comments)
        return lets_of_macro

    def _write_arguments(self) -> None:
        """Write the arguments that are used; one that is made of others is after them, in the first file."""
        used = [one for one in self.program.arguments.values() if one.used]
        values = {one: self.values.value(symbol_of(one.symbol), one) for one in used}
        for file in self.documents.values():
            file.pop("args", None)
        for variable in sorted(used, key=lambda one: isinstance(values[one], Expression)):
            if variable.printed and variable.names_file:
                raise Failed("it is the name of a file that is loaded, and a text", variable.node)
            place = None if isinstance(values[variable], Expression) else variable.place
            entry = {"type": variable.type, "default": values[variable], "one_of": self._allowed(variable)}
            self._section(place, "args")[variable.ours] = {key: one for key, one in entry.items() if one != []}
            self._remark(place, ("args", variable.ours), variable.comments)

    # What arguments are compared with.

    def _allowed(self, variable: Variable) -> list[str]:
        """Return the texts that an argument may be, or nothing if it may be any."""
        texts = [str(one) for one in variable.candidates]
        if variable.type != "text" or not texts or variable.printed or "" in texts:
            return []
        allowed = list(dict.fromkeys([str(variable.value), *sorted(texts)]))
        return allowed if len(allowed) > 1 else []

    def _argument(self, variable: Variable) -> dict[str, Any]:
        """Return an argument with the values that are compiled.

        The ``choices`` are those that it is compared with; one that is ``invented`` shows whether it is followed.
        """
        default, value = str(variable.value), literal(str(variable.value))
        choices, invented = sorted(str(one) for one in variable.candidates), []
        words = [literal(one) for one in default.split()]
        if not variable.used:
            choices = []
        elif variable.type == "boolean":
            choices = ["false" if value is True else "true"]
        elif variable.type == "number":
            choices = [str(one) for one in variable.candidates if isinstance(literal(str(one)), (int, float))]
            other = repr(value + 1 if isinstance(value, int) else value * 1.25 + 0.01)
            invented = [other] if other not in choices else []
        elif len(words) > 1 and all(isinstance(one, (int, float)) for one in words):
            invented = [" ".join(repr(one * 1.25 + 0.01) for one in words)]
        elif not self._allowed(variable) and not variable.names_file and not re.search(r"[\s/]", default):
            invented = [PROBE]
        return {
            "name": variable.name,
            "value": default,
            "choices": list(dict.fromkeys([default, *choices])),
            "invented": invented,
            "used": variable.used,
            "environment": variable.environment,
        }


def encode(value: Any) -> Any:
    """Return a value of a document as JSON; a mark before each text has its type."""
    if isinstance(value, dict):
        return {encode(key): encode(item) for key, item in value.items()}
    if isinstance(value, list):
        return [encode(item) for item in value]
    return f"{_MARKS.get(type(value), ' ')}{value}" if isinstance(value, str) else value


def decode(value: Any) -> Any:
    """Return the value of a document that ``encode`` has made JSON."""
    if isinstance(value, dict):
        return {decode(key): decode(item) for key, item in value.items()}
    if isinstance(value, list):
        return [decode(item) for item in value]
    kinds = {mark: kind for kind, mark in _MARKS.items()}
    return kinds.get(value[0], str)(value[1:]) if isinstance(value, str) else value


def comments_before(document: Any) -> list[str]:
    """Return the lines of the comments at the top of a file."""
    remarks = [one.text for one in document.before if one.kind == COMMENT]
    return [line for text in remarks if "autogenerated by xacro" not in text for line in clean_comment(text)]


def _file_names(program: Program) -> dict[int, str]:
    """Return the file in the description for each file of the xacro: in the same folder next to the first."""
    made: dict[int, str] = {}
    first = Path(program.file).absolute()
    for path, index in program.files.items():
        here = Path(path).absolute()
        stem = re.sub(r"[^\w.-]+", "_", re.sub(r"(\.urdf)?\.xacro$|\.urdf$|\.xml$", "", here.name)).strip(".") or "part"
        folder = ""
        if here.is_relative_to(first.parent) and here.parent != first.parent:
            folder = f"{here.parent.relative_to(first.parent).as_posix()}/"
        stem = "robot_parts" if f"{folder}{stem}" == "robot" else stem
        names = [name.removesuffix(".yaml") for name in made.values()]
        made[index] = f"{_free(f'{folder}{stem}', names)}.yaml" if made else Description.ROOT_FILE
    return made


def _free(name: str, taken: Iterable[str]) -> str:
    """Return a name that is not taken: with a number."""
    key, count = name, 1
    while key in taken:
        count += 1
        key = f"{name}_{count}"
    return key

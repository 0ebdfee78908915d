"""The intermediate representation of a xacro: macros, calls, properties, conditions, blocks, elements and text.

``build`` reads it from the answer of the child process that ran the file with symbols, see ``symbolic``.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from keyword import iskeyword
from pathlib import Path
from typing import Any

from rosorin_compile.language.expression.functions import OF_DESCRIPTIONS, functions
from rosorin_compile.source.xml.markup import COMMENT, Document, Remark, parse, read_source

_CONSTANTS = ("pi", "e", "tau", "true", "false", "none", "rad", "deg")
ARGUMENT, PARAMETER, LET = "argument", "parameter", "let"
NUMBER, TEXT, FLAG, LIST, TABLE, ANY = "number", "text", "boolean", "list", "table", ""
_TOKEN = re.compile("\ua657(\\d+)\ua657")
_NUMBERS = re.compile(r"\s*[-+]?[\d.][\d.eE+-]*(?:\s+[-+]?[\d.][\d.eE+-]*)+\s*")

Place = tuple[int, int]  # the number of a file, and the offset in its text
Pieces = list[Any]  # texts and formulas


class Unsupported(Exception):
    """Something that the language cannot express; ``node`` is the formula, if it is one."""

    def __init__(self, reason: str, node: ast.AST | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        self.node = node


@dataclass(eq=False, repr=False)
class Variable:
    """An argument, a parameter of a macro or a property. ``values`` are examples of what it has."""

    id: str
    kind: str
    name: str
    values: list[Any] = field(default_factory=list)
    node: ast.expr | None = None  # of a property, or the default of an argument
    owner: str = ""  # the key of its macro
    place: Place | None = None
    comments: tuple[str, ...] = ()
    candidates: list[Any] = field(default_factory=list)
    environment: bool = False
    names_file: bool = False
    raw: str = ""  # the digits of a number
    ours: str = ""
    type: str = ANY


@dataclass(eq=False, repr=False)
class Element:
    """An element with its attributes and its content."""

    tag: str
    attributes: dict[str, Pieces]
    body: list[Any]
    place: Place | None = None
    comments: tuple[str, ...] = ()


@dataclass(eq=False, repr=False)
class Call:
    """A call of a macro that stays; ``given`` has the formula of each parameter, and whether that is its default."""

    macro: Macro
    given: dict[str, tuple[ast.expr, bool]]
    place: Place | None = None
    comments: tuple[str, ...] = ()
    caller: Macro | None = None


@dataclass(eq=False, repr=False)
class If:
    """Nodes that are there on a condition."""

    test: ast.expr
    holds: bool
    body: list[Any]


@dataclass(eq=False, repr=False)
class Words:
    """Text in an element."""

    pieces: Pieces


@dataclass(eq=False, repr=False)
class Comment:
    """A comment."""

    text: str


@dataclass(eq=False, repr=False)
class Macro:
    """A macro that stays. ``level`` is the element in which it is called; ``robot`` makes it a part."""

    key: str  # the place of its definition, and the level
    name: str
    level: str
    parameters: dict[str, Variable]
    place: Place
    comments: tuple[str, ...]
    body: list[Any] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    ours: str = ""

    @property
    def definition(self) -> str:
        """Return the place of its definition, as the child process names it."""
        return self.key.rpartition(" ")[0]


@dataclass(eq=False, repr=False)
class File:
    """A file of the source; ``name`` is its file in the description."""

    path: str
    document: Document
    name: str


@dataclass(eq=False, repr=False)
class Program:
    """A xacro with all that it includes."""

    name: Pieces
    body: list[Any]
    macros: dict[str, Macro]
    variables: dict[str, Variable]
    files: list[File]
    answer: Mapping[str, Any]

    @property
    def arguments(self) -> dict[str, Variable]:
        return {one.name: one for one in self.variables.values() if one.kind == ARGUMENT}

    def file_of(self, place: Place | None) -> File:
        return self.files[place[0]] if place is not None else self.files[0]

    def at(self, place: Place | None) -> str:
        """Return a place for a person, such as ``arm.xacro:12``."""
        if place is None:
            return ""
        file = self.file_of(place)
        return f"{Path(file.path).name}:{file.document.source.text.count(chr(10), 0, place[1]) + 1}"

    def variables_in(self, node: ast.AST) -> list[Variable]:
        names = dict.fromkeys(one.id for one in ast.walk(node) if isinstance(one, ast.Name))
        return [self.variables[name] for name in names if name in self.variables]


def build(answer: Mapping[str, Any]) -> Program:
    """Return the program that the child process answers. Raises MarkupError, OSError."""
    return _Builder(answer).program()


class _Builder:
    def __init__(self, answer: Mapping[str, Any]) -> None:
        self.answer = answer
        self.tokens = [formula(text) for text in answer["tokens"]]
        self.variables = {one["id"]: self.variable(one) for one in answer["variables"]}
        self.macros = {one["key"]: self.macro(one) for one in answer["macros"]}
        self.caller: Macro | None = None

    def program(self) -> Program:
        answer = self.answer
        for one in answer["macros"]:
            self.caller = self.macros[one["key"]]
            self.caller.body = self.nodes(one["body"])
        self.caller = None
        files: list[File] = []
        for path in answer["files"]:
            files.append(File(path, parse(read_source(Path(path))), _free_name(path, files)))
        body = self.nodes(answer["body"])
        return Program(self.pieces(answer["name"]), body, self.macros, self.variables, files, answer)

    def variable(self, one: Mapping[str, Any]) -> Variable:
        node = one.get("node", one.get("default"))
        value = one["value"] if not one["shape"] else {LIST: [], TABLE: {}}[one["shape"]]
        made = Variable(one["id"], one["kind"], one["name"], [value], node and formula(node), one["owner"])
        made.place, made.comments = _place(one.get("place")), tuple(one.get("comments") or ())
        made.candidates, made.environment = one["candidates"], one.get("environment", False)
        made.raw = one.get("raw", "")
        made.names_file = one.get("names_file", False)
        made.ours = usable(one["name"])
        return made

    def macro(self, one: Mapping[str, Any]) -> Macro:
        parameters = {name: self.variables[key] for name, key in one["parameters"].items()}
        place: Any = _place(one["place"])
        return Macro(one["key"], one["name"], one["level"], parameters, place, tuple(one["comments"]))

    def pieces(self, text: str) -> Pieces:
        """Return a text with formulas for its tokens."""
        parts = _TOKEN.split(text)
        return flattened([self.tokens[int(part)] if index % 2 else part for index, part in enumerate(parts)])

    def nodes(self, nodes: list[Mapping[str, Any]]) -> list[Any]:
        return [made for one in nodes if (made := self.node(one)) is not None]

    def node(self, one: Mapping[str, Any]) -> Any:
        if "comment" in one:
            return Comment(one["comment"])
        if "text" in one:
            return Words(self.pieces(one["text"])) if one["text"] else None
        place, comments = _place(one["place"]), tuple(one["comments"])
        if "test" in one:
            return If(self.tokens[one["test"]], one["holds"], [*map(Comment, comments), *self.nodes(one["body"])])
        if "call" in one:
            given = {name: (formula(text), default) for name, (text, default) in one["given"].items()}
            made = Call(self.macros[one["call"]], given, place, comments, self.caller)
            made.macro.calls.append(made)
            for name, value in one["examples"].items():
                made.macro.parameters[name].values.append(value)
            return made
        attributes = {name: self.pieces(text) for name, text in one["attributes"].items()}
        return Element(one["tag"], attributes, self.nodes(one["body"]), place, comments)


def formula(text: str) -> ast.expr:
    """Parse a formula."""
    return ast.parse(text, mode="eval").body


def _place(place: Any) -> Place | None:
    return None if place is None else (place[0], place[1])


def flattened(pieces: Pieces) -> Pieces:
    """Return pieces with joined texts taken apart, and neighbouring texts as one."""
    made: Pieces = []
    for piece in pieces:
        if isinstance(piece, ast.Call) and getattr(piece.func, "id", "") == "__join":
            inner = flattened(list(piece.args))
        elif isinstance(piece, ast.Constant) and isinstance(piece.value, str):
            inner = [piece.value]
        else:
            inner = [piece]
        for one in inner:
            if isinstance(one, str) and made and isinstance(made[-1], str):
                made[-1] += one
            elif one != "":
                made.append(one)
    return made


def usable(name: str, taken: Any = (), shadows: bool = False) -> str:
    """Return a name for an expression of the language that is not taken; ``shadows``: it may be that of a function."""
    name = re.sub(r"\W", "_", name, flags=re.ASCII) or "value"
    made, number = name, 1
    reserved = {*(() if shadows else functions()), *OF_DESCRIPTIONS, *_CONSTANTS, *taken}
    while made in reserved or iskeyword(made):
        number += 1
        made = f"{name}_{number}"
    return made


def is_list_text(value: Any) -> bool:
    """Return True if a value is a text of several numbers."""
    return isinstance(value, str) and _NUMBERS.fullmatch(value) is not None


def walk(nodes: list[Any]) -> Iterator[Any]:
    """Yield all nodes of a body, in their order."""
    for node in nodes:
        yield node
        yield from walk(getattr(node, "body", []) if not isinstance(node, Macro) else [])


def comments_before(file: File) -> list[str]:
    """Return the comments at the top of a file."""
    remarks: list[Remark] = [one for one in file.document.before if one.kind == COMMENT]
    return [one.text for one in remarks if "autogenerated by xacro" not in one.text]


def _free_name(path: str, files: list[File]) -> str:
    """Return the name of a file in the description: that of the xacro, in its folder next to the first."""
    if not files:
        return "robot.yaml"
    first, here = Path(files[0].path).absolute(), Path(path).absolute()
    stem = re.sub(r"[^\w.-]+", "_", re.sub(r"(\.urdf)?\.xacro$|\.urdf$|\.xml$", "", here.name)).strip(".") or "part"
    folder = ""
    if here.is_relative_to(first.parent) and here.parent != first.parent:
        folder = f"{here.parent.relative_to(first.parent).as_posix()}/"
    stem = "robot_parts" if f"{folder}{stem}" == "robot" else stem
    taken, name, number = {file.name for file in files}, f"{folder}{stem}.yaml", 1
    while name in taken:
        number += 1
        name = f"{folder}{stem}_{number}.yaml"
    return name

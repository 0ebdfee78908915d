"""The intermediate representation of a xacro: macros, calls, properties, conditions, blocks, elements and text.

Properties, arguments and parameters are ``Variable``s, and blocks are parameters. ``nodes_of`` builds it from a
document that was evaluated with symbols. This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from .symbols import TOKEN, Pieces, Symbol, Variable, pieces_of, with_tokens

MARK, COMMENTS = "rosorin_place", "rosorin_comments"

Place = tuple[int, int, int]  # the number of a file, the offset in its text, and the number of the call


@dataclass(eq=False)
class Element:
    """An element with its attributes and its content."""

    tag: str
    attributes: dict[str, Pieces]
    body: list[Any]
    place: Place | None
    comments: list[str]


@dataclass(eq=False)
class Call:
    """A call of a macro that is kept; ``given`` has the value of each parameter, and whether that is its default."""

    macro: Macro
    given: dict[str, tuple[Symbol, bool]]
    place: Place | None
    comments: list[str]


@dataclass(eq=False)
class If:
    """Nodes that are there on a condition."""

    test: Symbol
    holds: bool
    body: list[Any]


@dataclass(eq=False)
class Words:
    """Text in an element."""

    pieces: Pieces


@dataclass(eq=False)
class Comment:
    """A comment."""

    text: str


@dataclass(eq=False)
class Macro:
    """A macro that is kept. ``level`` is the element in which it is called; ``robot`` makes it a part.

    ``definition`` is that of xacro, and ``key`` the place of it. ``reads`` are the properties of its callers.
    """

    definition: Any
    key: str
    level: str
    parameters: dict[str, Variable] = field(default_factory=dict)
    body: list[Any] = field(default_factory=list)
    calls: list[Call] = field(default_factory=list)
    reads: dict[str, str] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    depth: int = 0
    table: Any = None
    ours: str = ""

    @property
    def name(self) -> str:
        return str(self.definition.body.getAttribute("name")).removeprefix("xacro:")

    @property
    def place(self) -> Place | None:
        return getattr(self.definition.body, MARK, None)

    @property
    def comments(self) -> list[str]:
        return getattr(self.definition.body, COMMENTS, [])


def nodes_of(parent: Any) -> list[Any]:
    """Return the content of an element of an evaluated document."""
    made: list[Any] = []
    for node in parent.childNodes:
        place, comments = getattr(node, MARK, None), getattr(node, COMMENTS, [])
        if node.nodeType == node.COMMENT_NODE:
            made.append(Comment(node.data))
        elif node.nodeType == node.TEXT_NODE and node.data.strip():
            made.append(Words(pieces_of(with_tokens(node.data.strip()))))
        elif node.nodeType != node.ELEMENT_NODE:
            continue
        elif node.tagName == "xacro-call":
            macro, given = node.rosorin_call
            made.append(Call(macro, given, place, comments))
            macro.calls.append(made[-1])
        elif node.tagName == "xacro-if":
            test = Symbol.tokens[int(TOKEN.fullmatch(node.getAttribute("test"))[1])]  # type: ignore[index]
            made.append(If(test, node.getAttribute("holds") == "1", [*map(Comment, comments), *nodes_of(node)]))
        else:
            attributes = {name: pieces_of(with_tokens(text)) for name, text in node.attributes.items()}
            made.append(Element(node.tagName, attributes, nodes_of(node), place, comments))
    return made


def walk(nodes: list[Any]) -> Iterator[Any]:
    """Yield all nodes of a body, in their order."""
    for node in nodes:
        yield node
        yield from walk(getattr(node, "body", []))


def expressions_in(node: Any) -> list[ast.AST]:
    """Return the expressions of a node, without those of its body."""
    pieces: Pieces = []
    if isinstance(node, Element):
        pieces = [piece for text in node.attributes.values() for piece in text]
    elif isinstance(node, Words):
        pieces = node.pieces
    elif isinstance(node, If):
        pieces = [node.test]
    elif isinstance(node, Call):
        pieces = [one for one, _ in node.given.values()]
    return [piece.node for piece in pieces if isinstance(piece, Symbol)]

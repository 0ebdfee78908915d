"""Texts: a text of xacro taken apart as xacro takes it apart: plain pieces, ``${...}`` and ``$(...)``."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from typing import NamedTuple, TypeVar

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.xml.markup import Element

T = TypeVar("T")

TEXT, EXPRESSION, EXTENSION = "text", "expression", "extension"
# As LEXER of xacro 2.1.
_TOKEN = re.compile(r"(\$\$+[{(])|(\$\{[^}]*\})|(\$\([^)]*\))|([^$]+|\$[^{($]+|\$$)", re.DOTALL)
_DEFAULT = r"""\$\{.*?\}|\$\(.*?\)|(?:'.*?'|\".*?\"|[^\s'\"]+)+|"""
_PARAMETER = re.compile(r"^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?(" + _DEFAULT + r")(?:\s+|$)(.*)", re.DOTALL)


_ARGUMENT = re.compile(r"\$\(\s*(\w+)\s*([^)]*)\)")


class Unsupported(Exception):
    """Something of xacro that is not translated; ``reason`` in words, at a place; the one ``element`` it is about."""

    def __init__(self, reason: str, span: Span | None = None, element: Element | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span
        self.element = element


class Token(NamedTuple):
    """A piece of a text: plain, an expression without its braces, or an extension without its brackets."""

    kind: str
    text: str


class Parameter(NamedTuple):
    """A parameter of a macro: ``default`` is None where it has none; ``forward`` where the caller's value is taken.

    ``of_caller`` is a default that speaks of names that only a caller has. ``block`` is empty, ``*`` for an element,
    ``**`` for the content of an element.
    """

    name: str
    default: str | None
    forward: bool = False
    block: str = ""
    of_caller: str | None = None


def tokens(text: str) -> list[Token]:
    """Return the pieces of a text in order. Raises Unsupported for one that xacro cannot read."""
    found: list[Token] = []
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise Unsupported(f'"{text}" cannot be read')
        position = match.end()
        escaped, expression, extension, plain = match.groups()
        if expression is not None:
            found.append(Token(EXPRESSION, expression[2:-1]))
        elif extension is not None:
            found.append(Token(EXTENSION, extension[2:-1]))
        else:
            piece = escaped[1:] if escaped is not None else plain
            if found and found[-1].kind == TEXT:
                found[-1] = Token(TEXT, found[-1].text + piece)
            else:
                found.append(Token(TEXT, piece))
    return found


def words(pieces: Sequence[Token]) -> list[list[Token]]:
    """Return the words of a text, each as its pieces: parted by the white space of plain pieces."""
    return [[piece for piece, _ in word] for word in scoped_words([(piece, None) for piece in pieces])]


def scoped_words(pieces: Sequence[tuple[Token, T]]) -> list[list[tuple[Token, T]]]:
    """Return the words of a text as ``words``, each piece with what stands beside it: its scope."""
    made: list[list[tuple[Token, T]]] = []
    fresh = True
    for piece, beside in pieces:
        if piece.kind != TEXT:
            if fresh:
                made.append([])
            made[-1].append((piece, beside))
            fresh = False
            continue
        for part in re.split(r"(\s+)", piece.text):
            if not part:
                continue
            if part.isspace():
                fresh = True
                continue
            if fresh:
                made.append([])
            made[-1].append((Token(TEXT, part), beside))
            fresh = False
    return made


def signed(pieces: Sequence[Token]) -> tuple[str, Token, str] | None:
    """Return a number that is put together: its sign, its one piece that is evaluated, its exponent; None for others.

    >>> signed(tokens("-${width}"))
    ('-', Token(kind='expression', text='width'), '')
    """
    found = [index for index, piece in enumerate(pieces) if piece.kind != TEXT]
    if len(found) != 1 or len(pieces) == 1:
        return None
    (at,) = found
    sign = "".join(piece.text for piece in pieces[:at]).lstrip()
    exponent = "".join(piece.text for piece in pieces[at + 1 :]).rstrip()
    fits = sign in ("", "+", "-") and re.fullmatch(r"([eE][-+]?[0-9]+)?", exponent) and (sign or exponent)
    return (sign, pieces[at], exponent) if fits else None


def parameters(text: str) -> list[Parameter]:
    """Return the parameters of a macro, as ``params`` declares them."""
    found: list[Parameter] = []
    while text.strip():
        match = _PARAMETER.match(text)
        if match:
            name, forward, default, text = match.groups()
            found.append(_parameter(name, default or None, bool(forward)))
            continue
        name, *rest = text.strip().split(None, 1)
        text = rest[0] if rest else ""
        found.append(_parameter(name, None, False))
    return found


def _parameter(name: str, default: str | None, forward: bool) -> Parameter:
    if default and "$(" in default and re.fullmatch(r"'[^']*'", default):
        default = default[1:-1]  # quoted for Python, which reads it once it is put together
    block = "**" if name.startswith("**") else "*" if name.startswith("*") else ""
    return Parameter(name.lstrip("*"), default, forward, block)


def source_tree(text: str) -> ast.expr:
    """Return an expression of xacro as Python reads it, with ``__arg_NAME`` for each ``$(arg NAME)``.

    Raises ValueError for one that is none, or holds another extension than ``arg`` and ``find``.
    """
    try:
        return _Simpler().visit(ast.parse(_without_extensions(text).strip(), mode="eval").body)  # type: ignore
    except (SyntaxError, RecursionError, MemoryError) as problem:
        raise ValueError(str(problem)) from None


class _Simpler(ast.NodeTransformer):
    """Leaves out the empty texts that stand around an argument in quotes."""

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        for one, other in ((node.left, node.right), (node.right, node.left)):
            if isinstance(node.op, ast.Add) and isinstance(one, ast.Constant) and one.value == "" and _of_text(other):
                return other
        return node


def _of_text(node: ast.expr) -> bool:
    return isinstance(node, ast.BinOp) or (isinstance(node, ast.Call) and getattr(node.func, "id", "") == "__text")


def _without_extensions(text: str) -> str:
    """Return an expression in which what xacro puts into its text before it is read are names."""
    if "$(" not in text:
        return text
    made, position, quote = [], 0, ""
    while position < len(text):
        letter = text[position]
        match = _ARGUMENT.match(text, position)
        if match:
            made.append(_extension(match[1], match[2].strip(), quote))
            position = match.end()
            continue
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "'\"":
            quote = letter
        made.append(letter)
        position += 1
    return "".join(made)


def _extension(kind: str, rest: str, quote: str) -> str:
    if kind == "arg" and rest.isidentifier():
        return f"{quote} + __text(__arg_{rest}) + {quote}" if quote else f"__arg_{rest}"
    if kind == "find" and quote:
        return f"package://{rest}"
    raise ValueError(f"$({kind} {rest}) stands in an expression")

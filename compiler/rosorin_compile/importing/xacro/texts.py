"""Split texts of xacro into plain text, ``${...}`` and ``$(...)``, and parse parameters and expressions."""

from __future__ import annotations

import ast
import re
from typing import NamedTuple, TypeVar

from rosorin_compile.source.diagnostics import Span

T = TypeVar("T")

TEXT, EXPRESSION, EXTENSION = "text", "expression", "extension"
# As LEXER of xacro 2.1.
_TOKEN = re.compile(r"(\$\$+[{(])|(\$\{[^}]*\})|(\$\([^)]*\))|([^$]+|\$[^{($]+|\$$)", re.DOTALL)
_DEFAULT = r"""\$\{.*?\}|\$\(.*?\)|(?:'.*?'|\".*?\"|[^\s'\"]+)+|"""
_PARAMETER = re.compile(r"^\s*([^\s:=]+?)\s*:?=\s*(\^\|?)?(" + _DEFAULT + r")(?:\s+|$)(.*)", re.DOTALL)


_ARGUMENT = re.compile(r"\$\(\s*(\w+)\s*([^)]*)\)")


class Unsupported(Exception):
    """A construct that cannot be translated, with the reason and its place."""

    def __init__(self, reason: str, span: Span | None = None) -> None:
        super().__init__(reason)
        self.reason = reason
        self.span = span


class Token(NamedTuple):
    """A piece of a text: plain, an expression without its braces, or an extension without its brackets."""

    kind: str
    text: str


class Parameter(NamedTuple):
    """A parameter of a macro.

    ``forward``: the value of the caller's name is the default. ``block`` is ``*`` for an element, ``**`` for the
    content of an element, and empty for a value.
    """

    name: str
    default: str | None
    forward: bool = False
    block: str = ""


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
    if default and "$" in default and re.fullmatch(r"'[^']*'", default):
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

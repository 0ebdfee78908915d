"""Bounded: JSON, Python and YAML of others, read up to a depth that no code behind the parser has to guard against.

Parsers and what walks their trees call themselves: of a text that is nested a hundred thousand times some raise
RecursionError or MemoryError, and libyaml's composer ends the whole program. What is read here is never so deep.
(Descriptions are read by ``frontend.load``, XML by ``xml.markup``; both have limits of their own.)
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import ast

MAX_DEPTH = 100
# Nodes of Python's syntax tree: a call in a list in a call is six of them.
MAX_NODE_DEPTH = 150

_TOO_DEEP = f"nested deeper than {MAX_DEPTH} levels"
# Compiled when they are needed first.
_JSON = r'(?s)"[^"\\]*(?:\\.[^"\\]*)*"|[\[\]{}]'
# Brackets of one kind, quotes and backslashes; and all else.
_ONE_KIND = bytes.maketrans(b"{}", b"[]")
_NO_SIGNS = bytes(set(range(256)) - set(b'[]{}"\\'))
_INDENT = r"(?m)^[ \t?-]+"


def json_of(text: str | bytes, parse_constant: Callable[[str], Any] | None = None) -> Any:
    """Return what a JSON text says. Raises ValueError, with the place where there is one, also if it is too deep."""
    import json

    if isinstance(text, bytes):
        text = text.decode(json.detect_encoding(text))
    depth = 0
    for match in re.finditer(_JSON, text) if _may_be_deep_json(text) else ():
        depth += (match[0] in "[{") - (match[0] in "]}")
        if depth > MAX_DEPTH:
            raise json.JSONDecodeError(_TOO_DEEP, text, match.start())
    return json.loads(text, parse_constant=parse_constant)


def _may_be_deep_json(text: str) -> bool:
    """Say whether a text might be nested too deep: its brackets are looked at alone, if none stands in a text."""
    if text.count("[") + text.count("{") <= MAX_DEPTH:
        return False
    signs = text.encode("utf-8", "replace").translate(_ONE_KIND, _NO_SIGNS).replace(b'""', b"")
    for _ in range(MAX_DEPTH):
        signs = signs.replace(b"[]", b"")  # the innermost pairs: one level
    return bool(signs)


def python_of(text: str, expression: bool = False) -> ast.Module | ast.Expression:
    """Return the syntax tree of a program, or of an expression. Raises SyntaxError; ValueError if it is too deep."""
    import ast

    try:
        tree: ast.Module | ast.Expression = ast.parse(text, mode="eval") if expression else ast.parse(text)
    except (RecursionError, MemoryError):
        raise ValueError("nested too deep") from None
    nodes: list[ast.AST] = [tree]
    for _ in range(MAX_NODE_DEPTH):
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
        if not nodes:
            return tree
    raise ValueError("nested too deep")


def yaml_of(text: str) -> Any:
    """Return what a YAML text says. Raises ValueError, with what is wrong, also if it is too deep."""
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        if _may_be_deep(text) and _is_deep(yaml.parse(text, Loader=loader)):
            raise yaml.MarkedYAMLError(problem=_TOO_DEEP)
        return yaml.load(text, Loader=loader)  # noqa: S506 - both are safe
    except yaml.YAMLError as wrong:
        if is_too_deep(wrong):
            raise ValueError(_TOO_DEEP) from None
        raise ValueError(" ".join(str(getattr(wrong, "problem", None) or "it is no YAML").split())) from None
    except (ValueError, LookupError, TypeError, AttributeError):  # a value is not of the kind that its tag says
        raise ValueError("it is no YAML") from None


def is_too_deep(problem: Exception) -> bool:
    """Say whether a parser of YAML gave up because of the nesting: that of PyYAML 6.0.4 does at 1,000 levels."""
    return "maximum nesting depth" in str(getattr(problem, "problem", None))


def _may_be_deep(text: str) -> bool:
    """Say whether a text might be nested too deep: a level is a bracket, or begins behind the one that it is in.

    A list may begin where the key above it does, so two levels may have one column.
    """
    indent = max((len(blank) for blank in re.findall(_INDENT, text)), default=0)
    return text.count("[") + text.count("{") + 2 * indent + 2 > MAX_DEPTH


def _is_deep(events: Any) -> bool:
    import yaml

    depth = 0
    for event in events:
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            return True
    return False

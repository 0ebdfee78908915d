"""Parse JSON, Python and YAML of other programs up to a depth that recursive code can process.

Nested a hundred thousand times, parsers raise RecursionError or MemoryError, and libyaml's composer ends the program.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .diagnostics import Source

if TYPE_CHECKING:
    import ast

MAX_DEPTH = 100
_TOO_DEEP = f"nested deeper than {MAX_DEPTH} levels"
_JSON = re.compile(r'(?s)"[^"\\]*(?:\\.[^"\\]*)*"|[\[\]{}]')


def json_of(text: str | bytes, parse_constant: Callable[[str], Any] | None = None) -> Any:
    """Parse JSON. Raises ValueError, with the place if there is one, also if it is nested too deep."""
    if isinstance(text, bytes):
        text = text.decode(json.detect_encoding(text))
    depth = 0
    for match in _JSON.finditer(text) if text.count("[") + text.count("{") > MAX_DEPTH else ():
        depth += (match[0] in "[{") - (match[0] in "]}")
        if depth > MAX_DEPTH:
            raise json.JSONDecodeError(_TOO_DEEP, text, match.start())
    return json.loads(text, parse_constant=parse_constant)


def python_of(text: str, expression: bool = False) -> ast.Module | ast.Expression:
    """Parse a program or an expression. Raises SyntaxError; ValueError if it is nested too deep."""
    import ast

    try:
        tree: ast.Module | ast.Expression = ast.parse(text, mode="eval") if expression else ast.parse(text)
    except (RecursionError, MemoryError):
        raise ValueError("nested too deep") from None
    nodes: list[ast.AST] = [tree]
    for _ in range(150):  # a call in a list in a call is six levels of Python's syntax tree
        nodes = [child for node in nodes for child in ast.iter_child_nodes(node)]
    if nodes:
        raise ValueError("nested too deep")
    return tree


def yaml_of(text: str) -> Any:
    """Parse YAML. Raises ValueError with the reason, also if it is nested too deep."""
    from .load import LoadError, parse_yaml

    try:
        return parse_yaml(Source("", text))
    except LoadError as problem:
        raise ValueError(str(problem)) from None

"""JSON, Python and YAML of others, parsed up to a depth that the code behind the parser can take.

Parsers and what walks their trees are recursive: nested a hundred thousand times, some raise RecursionError or
MemoryError, and libyaml's composer ends the whole program.
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
_JSON = r'(?s)"[^"\\]*(?:\\.[^"\\]*)*"|[\[\]{}]'


def json_of(text: str | bytes, parse_constant: Callable[[str], Any] | None = None) -> Any:
    """Parse JSON. Raises ValueError, with the place where there is one, also if it is nested too deep."""
    import json

    if isinstance(text, bytes):
        text = text.decode(json.detect_encoding(text))
    depth = 0
    is_flat = text.count("[") + text.count("{") <= MAX_DEPTH
    for match in () if is_flat else re.finditer(_JSON, text):
        depth += (match[0] in "[{") - (match[0] in "]}")
        if depth > MAX_DEPTH:
            raise json.JSONDecodeError(_TOO_DEEP, text, match.start())
    return json.loads(text, parse_constant=parse_constant)


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
    """Parse YAML. Raises ValueError, with what is wrong, also if it is nested too deep."""
    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    # A level is a bracket, or is indented deeper than the one around it; a list may begin where its key does.
    indent = max((len(blank) for blank in re.findall(r"(?m)^[ \t?-]+", text)), default=0)
    depth = 0
    try:
        if text.count("[") + text.count("{") + 2 * indent + 2 > MAX_DEPTH:
            for event in yaml.parse(text, Loader=loader):
                depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
                if depth > MAX_DEPTH:
                    raise ValueError(_TOO_DEEP)
        return yaml.load(text, Loader=loader)  # noqa: S506 - both are safe
    except yaml.YAMLError as wrong:
        reason = " ".join(str(getattr(wrong, "problem", None) or "it is no YAML").split())
        raise ValueError(_TOO_DEEP if is_too_deep(wrong) else reason) from None
    except (ValueError, LookupError, TypeError, AttributeError) as wrong:  # a value does not fit its tag
        raise ValueError(_TOO_DEEP if str(wrong) == _TOO_DEEP else "it is no YAML") from None


def is_too_deep(problem: Exception) -> bool:
    """Return True if libyaml gave up because of the nesting, as it does at 1,000 levels."""
    return "maximum nesting depth" in str(getattr(problem, "problem", None))

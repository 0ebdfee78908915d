"""The door: the public modules with their names, what it hands on to the tool's own packages, and who goes past it."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from support.imports import modules

# The modules of the door, seen from the package.
DOOR = ("", "model", "diagnostics", "extending")

# What it hands on to the tool's own packages alone.
BACKEND = "backend"


def breaches(package: Path, core: str, public: Mapping[str, Sequence[str]]) -> list[str]:
    """Return where a package beside the core takes something else of it, or of another package, than a public name.

    Imports within functions and for types alone count, too, and so do modules that are named as text.
    """
    doors = {f"{core}.{name}".rstrip("."): names for name, names in public.items()}
    return [
        f"{package.name}.{module.name}".rstrip(".") + f", line {line}: {what}"
        for module in modules(package).values()
        for line, what in _breaching(ast.parse(module.text), package.name, core, doors)
    ]


def _breaching(tree: ast.Module, own: str, core: str, doors: Mapping[str, Sequence[str]]) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, one.name) for one in node.names if _is_beyond(one.name, own, core))
        elif isinstance(node, ast.ImportFrom) and _is_beyond(node.module or "", own, core) and not node.level:
            known = doors.get(node.module or "", ())
            yield from ((node.lineno, f"{one.name} of {node.module}") for one in node.names if one.name not in known)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _is_module(node.value, own, core):
            yield node.lineno, node.value


def _is_beyond(module: str, own: str, core: str) -> bool:
    """Say whether a module is of the core or of another package."""
    top = module.partition(".")[0]
    return top == core or (top.startswith(f"{core}_") and top != own)


def _is_module(text: str, own: str, core: str) -> bool:
    """Say whether a text is the name of a module of another package, or of the core, that could be imported by it."""
    return _is_beyond(text, own, core) and "." in text and all(part.isidentifier() for part in text.split("."))

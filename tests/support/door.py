"""The door: the public modules with their names, and what the tools beside the core import besides."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from support.imports import Module, modules, origin_of

# The modules of the door, seen from the package.
DOOR = ("", "model", "diagnostics", "extending")

# Each package beside the core, and the rooms that are its own: tools first, then formats that move with them.
PACKAGES: Mapping[str, Sequence[str]] = {
    "mujoco": ("formats.mjcf",),
    "ros": (
        *("tools.package", "tools.parameters", "formats.controllers", "formats.parameters", "formats.nav2"),
        *("formats.navigation", "formats.robot_localization", "formats.launching", "formats.srdf"),
    ),
    "view": ("tools.view", "tools.picture", "formats.page", "formats.drawing"),
}


class Taken(NamedTuple):
    """A name of the core, or of another package, that a tool takes past the door, by the module that does."""

    package: str
    name: str
    by: str
    line: int

    def __str__(self) -> str:
        return f"{self.by}, line {self.line}, imports {self.name}"


def past_the_door(package: Path, public: Mapping[str, Sequence[str]]) -> list[Taken]:
    """Return what the tools of a package take that is no public name; imports for types alone count, too.

    ``public`` are the names of each module of the door. Of a module that is imported as a whole each name counts that
    is taken of it. What a module of its own only hands on counts as that which it imports, and so does a module that
    is imported by its name as text; of a name that is made at run time nobody knows which one it is.
    """
    known = modules(package)
    tools = [module for module in known.values() if module.name.startswith("tools.")]
    return sorted(taken for module in tools for taken in _taken(module, known, package.name, public))


def owner(module: str) -> str:
    """Return the package that a module belongs to; "" for the core."""
    return next((name for name, rooms in PACKAGES.items() if any(f"{module}.".startswith(f"{r}.") for r in rooms)), "")


def _taken(
    module: Module, known: Mapping[str, Module], package: str, public: Mapping[str, Sequence[str]]
) -> Iterator[Taken]:
    own = owner(module.name)
    for of, name, line in _names(ast.parse(module.text), module, known, package):
        of, name = _origin(of, name, known, package, public)
        if name in public.get(of, ()) or (of == "tools" or (of.startswith("tools.") and not owner(of))):
            continue
        if owner(of) != own or not own:
            yield Taken(own, f"{of}.{name}".strip("."), module.name, line)


def _origin(
    of: str, name: str, known: Mapping[str, Module], package: str, public: Mapping[str, Sequence[str]]
) -> tuple[str, str]:
    """Return the module that a name is of, and what it is called there; a name of the door is of the door."""
    while of in known and name not in public.get(of, ()):
        brought = _brought(known[of], package)
        if name not in brought:
            break
        of, name = brought[name]
    return of, name


@cache
def _brought(module: Module, package: str) -> Mapping[str, tuple[str, str]]:
    """Return the names that a module imports at its top of others of its package, each with where it is from."""
    found: dict[str, tuple[str, str]] = {}
    for node in ast.parse(module.text).body:
        if isinstance(node, ast.ImportFrom) and (of := origin_of(node, module, package)) is not None:
            found |= {alias.asname or alias.name: (of, alias.name) for alias in node.names}
    return found


def _by_text(node: ast.Call, package: str) -> str | None:
    """Return the module of the package that a call imports by its name as text; "?" for one made at run time."""
    called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    if called not in ("import_module", "__import__") or not node.args:
        return None
    text = node.args[0].value if isinstance(node.args[0], ast.Constant) else None
    if not isinstance(text, str) or text.startswith("."):
        return "?"
    top, _, name = text.partition(".")
    return name if top == package else None


def _names(tree: ast.AST, module: Module, known: Mapping[str, Module], package: str) -> Iterator[tuple[str, str, int]]:
    """Yield the names that a module takes of others of its package: the module, the name, the line."""
    whole: dict[str, str] = {}  # modules that are imported as a whole, by the names that they have here
    used: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and (text := _by_text(node, package)) is not None:
            yield text, "", node.lineno
        elif isinstance(node, ast.Import):
            for alias in node.names:
                top, _, name = alias.name.partition(".")
                if top == package:
                    yield name, "", node.lineno
        elif isinstance(node, ast.ImportFrom) and (of := origin_of(node, module, package)) is not None:
            for alias in node.names:
                child = f"{of}.{alias.name}".lstrip(".")
                if child in known:
                    whole[alias.asname or alias.name] = child
                else:
                    yield of, alias.name, node.lineno
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in whole:
            used.add(node.value.id)
            yield whole[node.value.id], node.attr, node.lineno
    yield from ((of, "", 1) for name, of in whole.items() if name not in used)


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

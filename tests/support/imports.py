"""What the modules of a package import of each other at run time, read from their sources; nothing is imported for it.

Imports under ``TYPE_CHECKING`` are left aside; those within functions count.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple


class Module(NamedTuple):
    """A module by its name within the package ("" is the package's own), whether it is a package, and its source."""

    name: str
    is_package: bool
    text: str

    @property
    def folder(self) -> str:
        """The package that the module stands in; a package stands in itself."""
        return self.name if self.is_package else self.name.rpartition(".")[0]

    @property
    def lines(self) -> int:
        return len(self.text.splitlines())


class Import(NamedTuple):
    """One import: the module that imports, the one that is imported, the name that is taken of it, and the line."""

    by: str
    of: str
    name: str
    line: int

    def __str__(self) -> str:
        of = self.of or "the package"
        taken = f"{self.name} of {of}" if self.name else of
        return f"{self.by}, line {self.line}, imports {taken}"


def modules(package: Path) -> dict[str, Module]:
    """Return the modules of a package by name."""
    made = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        is_package = parts[-1] == "__init__"
        name = ".".join(parts[:-1] if is_package else parts)
        made[name] = Module(name, is_package, path.read_text("utf-8"))
    return made


def imports(package: Path) -> list[Import]:
    """Return what the modules of a package import of each other, those of a module in the order of its lines."""
    known = modules(package)
    names = frozenset(known)
    every = (one for module in known.values() for one in _of_module(module, names, package.name))
    return sorted(one for one in every if one.of != one.by)


@cache  # many tests ask of the same sources
def _of_module(module: Module, known: frozenset[str], package: str) -> tuple[Import, ...]:
    return tuple(_imports(module, known, package))


def _imports(module: Module, known: frozenset[str], package: str) -> Iterator[Import]:
    for node in _at_run_time(ast.parse(module.text)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                top, _, name = alias.name.partition(".")
                if top == package:
                    yield Import(module.name, name, "", node.lineno)
        elif isinstance(node, ast.ImportFrom):
            origin = origin_of(node, module, package)
            for alias in node.names if origin is not None else ():
                child = f"{origin}.{alias.name}".lstrip(".")
                taken = (child, "") if child in known else (origin or "", alias.name)
                yield Import(module.name, *taken, node.lineno)


def origin_of(node: ast.ImportFrom, module: Module, package: str) -> str | None:
    """Return the module that something is imported from, by its name within the package; None for one of others."""
    named = node.module or ""
    if node.level == 0:
        top, _, rest = named.partition(".")
        return rest if top == package else None
    parts = module.folder.split(".") if module.folder else []
    above = parts[: len(parts) - node.level + 1]
    return ".".join([*above, named] if named else above)


def _at_run_time(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a tree but for those under ``if TYPE_CHECKING``."""
    yield node
    if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        children: Iterable[ast.AST] = node.orelse
    else:
        children = ast.iter_child_nodes(node)
    for child in children:
        yield from _at_run_time(child)


def circle(arrows: Mapping[str, Iterable[str]]) -> list[str]:
    """Return a shortest way round a circle of arrows, its first place again at the end; empty if there is none."""
    ways = [way for place in sorted(arrows) if (way := _way_back(arrows, place))]
    return min(ways, key=len, default=[])


def _way_back(arrows: Mapping[str, Iterable[str]], place: str) -> list[str]:
    """Return a shortest way from a place to itself."""
    ways = [[place]]
    reached: set[str] = set()
    for way in ways:  # it grows
        for other in sorted(arrows.get(way[-1], ())):
            if other == place:
                return [*way, other]
            if other not in reached:
                reached.add(other)
                ways.append([*way, other])
    return []

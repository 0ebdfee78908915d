"""The documents of a translation, the files and packages that they name, and what keeps a macro from being written."""

from __future__ import annotations

import ast
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from ..layout import cleaned
from .ir import Call, Element, Macro, Program, Unsupported, Variable, walk
from .part_names import formulas_of
from .values import Values
from .wording import Spot

_BYTES = 2_000_000  # of a file that is copied
PROBE = "probe_"  # a text that an argument has in no condition


class Target(NamedTuple):
    """Where a description is going to be, and what it has other than the xacro.

    ``schema`` is the address of the schema for editors; ``name`` another name of the robot; ``meshes`` is put before
    relative names of meshes. ``verbatim`` keeps elements for which the language has words. ``sharing`` are the other
    robots of the package.
    """

    folder: Path
    schema: str = ""
    name: str | None = None
    meshes: str | None = None
    verbatim: bool = False
    sharing: Any = None


class GiveUp(Exception):
    """Something that cannot be written: a macro, or what a formula outside of macros depends on.

    ``explicit``: the macro can be written if its names keep their prefix.
    """

    def __init__(self, macro: Macro | None, problem: Unsupported, explicit: bool = False) -> None:
        super().__init__(problem.reason)
        self.macro, self.problem, self.explicit = macro, problem, explicit


@dataclass(eq=False)
class Documents:
    """The documents of a translation by file name, with comments.

    ``plain`` are elements without expressions, ``counts`` the numbers of elements by file and part. ``labels`` are the
    elements that became entries, by section, and ``conditions`` those on which options of outputs are needed.
    """

    files: dict[str, dict[str, Any]] = field(default_factory=dict)
    comments: dict[str, dict[tuple[Any, ...], list[str]]] = field(default_factory=dict)
    plain: dict[Spot, str] = field(default_factory=dict)
    counts: dict[tuple[Any, ...], int] = field(default_factory=dict)
    labels: dict[str, list[str]] = field(default_factory=dict)
    conditions: dict[str, list[ast.expr | None]] = field(default_factory=dict)

    def section(self, file: str, key: str) -> dict[str, Any]:
        """Return a section of a file, which is added if there is none."""
        return self.files.setdefault(file, {}).setdefault(key, {})  # type: ignore[no-any-return]

    def remark(self, file: str, path: tuple[Any, ...], comments: Iterable[str]) -> None:
        """Add comments to an entry."""
        lines = [line for comment in comments for line in cleaned(comment)]
        if lines:
            self.comments.setdefault(file, {}).setdefault(path, []).extend(lines)


@dataclass(eq=False)
class WrittenFiles:
    """The files of a description, with what they were made of and the packages that they need.

    ``choices`` are the values of arguments that are compiled, ``empty`` macros that make nothing but materials.
    """

    files: dict[str, str]
    program: Program
    packages: dict[str, Path]
    documents: Documents
    used: set[Variable]
    choices: dict[str, list[str]]
    unfound: tuple[str, ...] = ()
    empty: tuple[str, ...] = ()


@contextmanager
def within(values: Values, macro: Macro | None, node: Element | Call | None = None) -> Iterator[None]:
    """Write a node in a macro. Raises GiveUp for what cannot be written."""
    before, values.macro = values.macro, macro
    try:
        yield
    except Unsupported as problem:
        if macro is None and isinstance(node, Call):
            macro = node.macro
        if macro is None and problem.node is None and node is not None:
            inner = [node, *walk(node.body)] if isinstance(node, Element) else [node]
            problem.node = ast.List([formula for one in inner for formula in formulas_of(one)], ast.Load())
        raise GiveUp(macro, problem) from None
    finally:
        values.macro = before


class PackageFiles:
    """The ``folders`` of packages that a program needs, and the names of those that the description does not find."""

    def __init__(self, program: Program, folder: Path) -> None:
        self.program = program
        self.folders: dict[str, Path] = {}
        self.unfound: dict[str, None] = {}
        self._named = Packages({}, os.environ, folder / Description.ROOT_FILE)

    def find(self, name: str) -> None:
        """Record a package that is named. Raises Unsupported if it is missing."""
        folder = self.program.answer["packages"].get(name)
        if folder is None:
            raise Unsupported(f'the package "{name}" is not found')
        if not self._finds(name):
            self.folders[name] = Path(folder)
            self.unfound[name] = None

    def _finds(self, package: str) -> bool:
        """Return True if the description finds a package by its name."""
        folder, own = self.program.answer["packages"].get(package), self._named.find(package)
        if folder is None or own is None or files.resolve(own) != files.resolve(Path(folder)):
            return False
        self.folders[package] = Path(folder)
        return True

    def address(self, name: str) -> str:
        """Return the name of a file that is loaded as the description has it."""
        package, _, rest = name.removeprefix("package://").partition("/")
        return name if not name.startswith("package://") or self._finds(package) else rest

    def copied(self) -> dict[str, str]:
        """Return the YAML files that are loaded, unless the description finds their package. Raises GiveUp."""
        made: dict[str, str] = {}
        for name, path in self.program.answer["loaded"].items():
            own = self.address(name)
            if own.startswith("package://"):
                continue
            if Path(own).is_absolute() or ".." in Path(own).parts:
                raise GiveUp(None, Unsupported(f"{name} is not a file of the xacro or its packages"))
            try:
                if Path(path).stat().st_size <= _BYTES:
                    made[own] = files.read_text(Path(path))
            except (OSError, ValueError) as problem:
                raise GiveUp(None, Unsupported(f"{Path(path).name} cannot be read: {problem}")) from None
        return made

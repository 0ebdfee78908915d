"""The documents of a translation by file, with their comments, and what keeps a macro from being written."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from ..layout import cleaned
from .ir import Call, Element, Macro, Program, Unsupported, Variable, walk
from .part_names import formulas_of
from .values import Values
from .wording import Spot

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

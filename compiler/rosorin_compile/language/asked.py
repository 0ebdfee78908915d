"""Asked: what a caller of the Python API gives, as the stages have it: a name on disk, arguments, folders of packages.

Nothing here raises for what is wrong: that is a diagnostic.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from decimal import Decimal
from numbers import Integral, Real
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.load import MAX_DEPTH, MAX_NODES
from rosorin_compile.source.project import ENDINGS, NoDescription
from rosorin_compile.source.tree import Text
from rosorin_compile.source.units import Quantity

from .expression.functions import FUNCTIONS, kind_of

# From here on YAML's whole numbers are floats, too (see load).
_LARGEST = 10**18


class Asked(NamedTuple):
    """What is asked for: the name of a file, a folder or a description, and what goes with it."""

    name: str
    arguments: dict[str, Any]
    packages: dict[str, Path]
    diagnostics: list[Diagnostic]


def ask(path: object, arguments: object, packages: object) -> Asked:
    """Return what is asked for; with diagnostics, it is not fit to be followed."""
    diagnostics: list[Diagnostic] = []
    name = ""
    if isinstance(path, (str, os.PathLike)):
        name = os.fsdecode(path)
    else:
        message = f"the path of a robot is text or a Path; this is {_a_kind(path)}"
        diagnostics.append(error("wrong-type", message, None))
    values, wrong = from_python({} if arguments is None else arguments)
    folders, missing = _folders({} if packages is None else packages)
    return Asked(name, values, folders, [*diagnostics, *wrong, *missing])


def unreadable(problem: NoDescription | OSError) -> Diagnostic:
    """Return the error for a robot that was not found; an OSError without a name is that of the working directory."""
    deleted = isinstance(problem, OSError) and problem.filename is None
    return error("file-unreadable", "the working directory was deleted" if deleted else str(problem), None)


def is_description(path: Path) -> bool:
    """Say whether a file is called as the files of a description are."""
    return path.suffix.lower() in ENDINGS


NO_ARGUMENTS = "leave the arguments out"


def deaf(path: Path) -> Diagnostic:
    """Return the error about arguments for a file that takes none."""
    message = f"{path.name} has no arguments: only a description and a xacro have them"
    return error("unknown-argument", message, None, NO_ARGUMENTS)


def _folders(packages: object) -> tuple[dict[str, Path], list[Diagnostic]]:
    if not isinstance(packages, Mapping):
        message = f"packages map names to folders; this is {_a_kind(packages)}"
        return {}, [error("package-missing", message, None, 'write {"NAME": FOLDER}')]
    folders: dict[str, Path] = {}
    diagnostics: list[Diagnostic] = []
    for name, folder in packages.items():
        is_path = isinstance(name, str) and isinstance(folder, (str, os.PathLike))
        if is_path and files.is_folder(folder):
            folders[name] = Path(os.fsdecode(folder))
        else:
            message = f'there is no folder "{folder!s:.200}" for the package {name!s:.60}'
            diagnostics.append(error("package-missing", message, None))
    return folders, diagnostics


class _NoValue(Exception):
    """What no argument can be; the message says what it is."""


def from_python(arguments: object) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Return arguments that a program gives as those of the language, and what is wrong with them.

    Numbers are in SI units; a text is what stands behind ``-a NAME=``. What has ``tolist``, as numpy's values have, is
    a number or a list.
    """
    if not isinstance(arguments, Mapping):
        message = f"arguments map names to values; this is {_a_kind(arguments)}"
        return {}, [error("bad-argument", message, None, 'write {"NAME": VALUE}')]
    values: dict[str, Any] = {}
    diagnostics: list[Diagnostic] = []
    for name, value in arguments.items():
        try:
            if not isinstance(name, str):
                raise _NoValue("is no name: a name is text")
            values[str(name)] = _plain(value, 0, [0])
        except _NoValue as problem:
            help = "a value is text, a number, true or false, None, a list or a table of them"
            diagnostics.append(error("bad-argument", f'the argument "{name!s:.60}" {problem}', None, help))
    return values, diagnostics


def _plain(value: object, depth: int, count: list[int]) -> Any:
    """Return a value as the language has it; ``count`` is how many there are so far. Raises _NoValue."""
    count[0] += 1
    if depth > MAX_DEPTH or count[0] > MAX_NODES:
        raise _NoValue("is too deep or too large a value")
    if value is None or isinstance(value, (bool, Quantity, Text)):
        return value
    if isinstance(value, str):
        return str.__str__(value)
    if isinstance(value, os.PathLike):
        return Text(os.fsdecode(value))
    if isinstance(value, (Real, Decimal)):
        return _number(value)
    if isinstance(value, Mapping):
        return {_key(key): _plain(item, depth + 1, count) for key, item in value.items()}
    if isinstance(value, (list, tuple, range)):
        return [_plain(item, depth + 1, count) for item in value]
    tolist = getattr(value, "tolist", None)
    if not callable(tolist):
        raise _NoValue(f"is {_a_kind(value)}")
    return _plain(tolist(), depth + 1, count)


def _number(value: Real | Decimal) -> int | float:
    """Return a number; one of more digits than YAML has for a whole number is a float. Raises _NoValue."""
    if isinstance(value, Integral) and abs(int(value)) < _LARGEST:
        return int(value)
    try:
        return float(value)
    except (OverflowError, ValueError):
        raise _NoValue("is too large a number") from None


def _key(key: object) -> str:
    if not isinstance(key, str):
        raise _NoValue(f"is a table with a key that is {_a_kind(key)}, not text")
    return str.__str__(key)


def _a_kind(value: object) -> str:
    return "None" if value is None else f"of the type {type(value).__name__}"


def as_texts(values: Mapping[str, Any]) -> tuple[dict[str, str], list[Diagnostic]]:
    """Return values as the arguments of a xacro, which are text (quantities in SI units), and what is wrong."""
    texts: dict[str, str] = {}
    diagnostics: list[Diagnostic] = []
    for name, value in values.items():
        if isinstance(value, bool):
            texts[name] = str(value).lower()
        elif isinstance(value, (str, int, float)):
            texts[name] = str(FUNCTIONS["str"](value))
        else:
            message = f'the argument "{name}" of a xacro is text or a number, not {kind_of(value)}'
            diagnostics.append(error("bad-argument", message, None))
    return texts, diagnostics

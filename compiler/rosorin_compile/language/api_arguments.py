"""Convert the arguments of the Python API to values of the language; errors are diagnostics."""

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

_LARGEST = 10**18  # from here on YAML's whole numbers are floats (see load)
NO_ARGUMENTS = "leave the arguments out"


class Asked(NamedTuple):
    """The name of a file, a folder or a description, with arguments and folders of packages."""

    name: str
    arguments: dict[str, Any]
    packages: dict[str, Path]
    diagnostics: list[Diagnostic]


def ask(path: object, arguments: object, packages: object) -> Asked:
    """Convert the arguments of a function of the API; the values are invalid if diagnostics are returned."""
    diagnostics: list[Diagnostic] = []
    name = os.fsdecode(path) if isinstance(path, (str, os.PathLike)) else ""
    if not isinstance(path, (str, os.PathLike)):
        diagnostics.append(error("wrong-type", f"the path of a robot is text or a Path; this is {_type(path)}", None))
    values, wrong = from_python({} if arguments is None else arguments)
    diagnostics += wrong
    folders: dict[str, Path] = {}
    packages = {} if packages is None else packages
    if not isinstance(packages, Mapping):
        message = f"packages map names to folders; this is {_type(packages)}"
        diagnostics.append(error("package-missing", message, None, 'write {"NAME": FOLDER}'))
        packages = {}
    for package, folder in packages.items():
        is_path = isinstance(package, str) and isinstance(folder, (str, os.PathLike))
        if is_path and files.is_folder(folder):
            folders[package] = Path(os.fsdecode(folder))
        else:
            message = f'there is no folder "{folder!s:.200}" for the package {package!s:.60}'
            diagnostics.append(error("package-missing", message, None))
    return Asked(name, values, folders, diagnostics)


def unreadable(problem: NoDescription | OSError) -> Diagnostic:
    """Return the error for a robot that was not found; an OSError without a name is that of the working directory."""
    is_deleted = isinstance(problem, OSError) and problem.filename is None
    return error("file-unreadable", "the working directory was deleted" if is_deleted else str(problem), None)


def is_description(path: Path) -> bool:
    """Return True if a file has the ending of a description."""
    return path.suffix.lower() in ENDINGS


def deaf(path: Path) -> Diagnostic:
    """Return the error about arguments for a file that takes none."""
    message = f"{path.name} has no arguments: only a description and a xacro have them"
    return error("unknown-argument", message, None, NO_ARGUMENTS)


class _NoValue(Exception):
    """A value that is not possible for an argument; the message is the reason."""


def from_python(arguments: object) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Convert arguments of a Python program to values of the language; also returns the errors.

    Numbers are in SI units; a text is read like ``-a NAME=TEXT``. An object with ``tolist``, such as a numpy array, is
    a number or a list.
    """
    if not isinstance(arguments, Mapping):
        message = f"arguments map names to values; this is {_type(arguments)}"
        return {}, [error("bad-argument", message, None, 'write {"NAME": VALUE}')]
    values: dict[str, Any] = {}
    diagnostics: list[Diagnostic] = []
    for name, value in arguments.items():
        try:
            if not isinstance(name, str):
                raise _NoValue("is not a name: a name is text")
            values[str(name)] = _plain(value, 0, [0])
        except _NoValue as problem:
            help = "a value is text, a number, true or false, None, a list or a table of them"
            diagnostics.append(error("bad-argument", f'the argument "{name!s:.60}" {problem}', None, help))
    return values, diagnostics


def _plain(value: object, depth: int, count: list[int]) -> Any:
    """Convert a value; ``count`` is the number of values so far. Raises _NoValue."""
    count[0] += 1
    if depth > MAX_DEPTH or count[0] > MAX_NODES:
        raise _NoValue("is too deep or too large a value")
    if value is None or isinstance(value, (bool, Quantity, Text)):
        return value
    if isinstance(value, str):
        return str.__str__(value)
    if isinstance(value, os.PathLike):
        return Text(os.fsdecode(value))
    if isinstance(value, Integral) and abs(int(value)) < _LARGEST:
        return int(value)
    if isinstance(value, (Real, Decimal)):
        try:
            return float(value)
        except (OverflowError, ValueError):
            raise _NoValue("is too large a number") from None
    if isinstance(value, Mapping):
        for key in (key for key in value if not isinstance(key, str)):
            raise _NoValue(f"is a table with a key that is {_type(key)}, not text")
        return {str.__str__(key): _plain(item, depth + 1, count) for key, item in value.items()}
    if isinstance(value, (list, tuple, range)):
        return [_plain(item, depth + 1, count) for item in value]
    tolist = getattr(value, "tolist", None)
    if not callable(tolist):
        raise _NoValue(f"is {_type(value)}")
    return _plain(tolist(), depth + 1, count)


def _type(value: object) -> str:
    return "None" if value is None else f"of the type {type(value).__name__}"


def as_text(value: object) -> str | None:
    """Return a value as an argument of a xacro, which is text (a quantity in SI units); None for a list or a table."""
    if isinstance(value, bool):
        return str(value).lower()
    return str(FUNCTIONS["str"](value)) if isinstance(value, (str, int, float)) else None


def as_texts(values: Mapping[str, Any]) -> tuple[dict[str, str], list[Diagnostic]]:
    """Return values as the arguments of a xacro, and the errors."""
    texts = {name: text for name, value in values.items() if (text := as_text(value)) is not None}
    wrong = (
        f'the argument "{n}" of a xacro is text or a number, not {kind_of(values[n])}' for n in values if n not in texts
    )
    return texts, [error("bad-argument", message, None) for message in wrong]

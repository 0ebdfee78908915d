"""Nearby: what is wrong with the name of a file that an include cannot have."""

from __future__ import annotations

import os
from pathlib import Path

from ...diagnostics import Diagnostic
from ...project import DESCRIPTIONS, nearest_file


def corrected(diagnostic: Diagnostic, name: str, target: Path) -> Diagnostic:
    """Return what is said of a file; of one that is not there, with the file beside it that is nearly called so."""
    if diagnostic.rule != "file-unreadable":
        return diagnostic
    close = None if os.path.exists(target) else nearest_file(target)  # noqa: PTH110 - Path.exists raises for some names
    if close is None:
        return diagnostic
    folder = name.rpartition("/")[0]
    meant = f"{folder}/{close.name}" if folder else close.name
    return diagnostic._replace(help=f'did you mean "{meant}"?')


def outside(name: str, by: Path, folder: Path) -> str:
    """Return why a file that ``by`` names is not inside a folder (links followed): by its name, or by a link."""
    written = os.path.normpath(by.parent.resolve() / name)
    by_link = ": a link leads there" if Path(written).is_relative_to(folder) else ""
    return f"{name} is {outside_of(folder)}{by_link}"


def outside_of(project: Path) -> str:
    """Return the words for what is not in the project of a description, or not beside a lone one."""
    if (project / DESCRIPTIONS).is_dir():
        return "outside the project, the folder that has descriptions/"
    return "outside the folder of the description"

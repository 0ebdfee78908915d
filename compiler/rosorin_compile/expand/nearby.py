"""Nearby: what is wrong with the name of a file that an include cannot have."""

from __future__ import annotations

import os
from pathlib import Path

from ..diagnostic import Diagnostic, nearest


def corrected(found: Diagnostic, name: str, target: Path) -> Diagnostic:
    """Return what is said of a file; of one that is not there, with the file beside it that is nearly called so."""
    if found.rule != "file-unreadable":
        return found
    try:
        beside = [] if target.exists() else [file for file in target.parent.iterdir() if file.is_file()]
    except (OSError, ValueError):  # no folder, or a name that no file can have
        return found
    stems = {file.stem: file.name for file in sorted(beside)}  # all descriptions end alike: that is no likeness
    stem = nearest(target.stem, stems)
    if stem is None:
        return found
    close = stems[stem]
    folder = name.rpartition("/")[0]
    return found._replace(help=f'did you mean "{folder}/{close}"?' if folder else f'did you mean "{close}"?')


def outside(name: str, by: Path, folder: Path) -> str:
    """Return why a file that ``by`` names is not inside a folder (links followed): by its name, or by a link."""
    written = os.path.normpath(by.parent.resolve() / name)
    by_link = ": a link leads there" if Path(written).is_relative_to(folder) else ""
    return f"{name} is outside the folder of the description{by_link}"

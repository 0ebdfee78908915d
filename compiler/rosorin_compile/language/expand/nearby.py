"""Nearby: the names of files that an include may have, and what is wrong with one that it cannot have."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.project import DESCRIPTIONS, Description

ADDRESS = "package://"


def address(name: str) -> tuple[str | None, str]:
    """Return the ROS package that a name of a file begins with, None if it names none, and the file.

    >>> address("package://arm/parts/hand.yaml"), address("hand.yaml")
    (('arm', 'parts/hand.yaml'), (None, 'hand.yaml'))
    """
    if not name.startswith(ADDRESS):
        return None, name
    package, _, file = name.removeprefix(ADDRESS).partition("/")
    return package, file


def package_missing(package: str) -> tuple[str, str]:
    """Return what is said of a ROS package that is not found, and the way out."""
    way_out = f"say where it is, --package {package}=FOLDER or packages: of the include; or source its workspace"
    return f'the package "{package}" is not found', way_out


def corrected(diagnostic: Diagnostic, name: str, target: Path) -> Diagnostic:
    """Return what is said of a file; of one that is not there, with the file beside it that is nearly called so."""
    if diagnostic.rule != "file-unreadable":
        return diagnostic
    close = None if files.exists(target) else Description.nearest_file(target)
    if close is None:
        return diagnostic
    folder = name.rpartition("/")[0]
    meant = f"{folder}/{close.name}" if folder else close.name
    return replace(diagnostic, help=f'did you mean "{meant}"?')


def outside(name: str, by: Path, folder: Path) -> str:
    """Return why a file that ``by`` names is not inside a folder (links followed): by its name, or by a link."""
    written = os.path.normpath(files.resolve(by.parent) / name)
    by_link = ": a link leads there" if Path(written).is_relative_to(folder) else ""
    return f"{name} is {outside_of(folder)}{by_link}"


def outside_of(project: Path) -> str:
    """Return the words for what is not in the project of a description, or not beside a lone one."""
    if files.is_folder(project / DESCRIPTIONS):
        return "outside the project, the folder that has descriptions/"
    return "outside the folder of the description"

"""Names of included files: their packages, and messages about files that are not found."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.project import DESCRIPTIONS, Description

ADDRESS = "package://"


def address(name: str) -> tuple[str | None, str]:
    """Split the name of a file into its ROS package, or None, and the rest.

    >>> address("package://arm/parts/hand.yaml"), address("hand.yaml")
    (('arm', 'parts/hand.yaml'), (None, 'hand.yaml'))
    """
    if not name.startswith(ADDRESS):
        return None, name
    package, _, file = name.removeprefix(ADDRESS).partition("/")
    return package, file


def package_missing(package: str) -> tuple[str, str]:
    """Return the message about a ROS package that is not found, and the help."""
    way_out = f"say where it is, --package {package}=FOLDER or packages: of the include; or source its workspace"
    return f'the package "{package}" is not found', way_out


def corrected(diagnostic: Diagnostic, name: str, target: Path) -> Diagnostic:
    """Add a suggestion to the error about a file that does not exist: a file in the folder with a similar name."""
    if diagnostic.rule != "file-unreadable":
        return diagnostic
    close = None if files.exists(target) else Description.nearest_file(target)
    if close is None:
        return diagnostic
    folder = name.rpartition("/")[0]
    meant = f"{folder}/{close.name}" if folder else close.name
    return replace(diagnostic, help=f'did you mean "{meant}"?')


def outside(name: str, by: Path, folder: Path) -> str:
    """Return the message about a file that ``by`` names and that is outside of a folder, by its name or a link."""
    written = os.path.normpath(files.resolve(by.parent) / name)
    by_link = ": a link leads there" if Path(written).is_relative_to(folder) else ""
    return f"{name} is {outside_of(folder)}{by_link}"


def outside_of(project: Path) -> str:
    """Return the words for a place outside of the project of a description."""
    if files.is_folder(project / DESCRIPTIONS):
        return "outside the project, the folder that has descriptions/"
    return "outside the folder of the description"

"""Packages: the folder of a ROS package by its name, with and without ROS.

Asked in this order: what ``--package`` says, ``ROS_PACKAGE_PATH`` (ROS 1), ``AMENT_PREFIX_PATH`` (ROS 2), the folders
in which Gazebo looks for models (``OF_GAZEBO``), and the folders around the file that is read: a package.xml there, or
beside it, says what the package is called.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from urllib.parse import unquote

from . import files

# The variables of the environment that say where models of Gazebo are, the first asked first.
PACKAGE_XML = "package.xml"
OF_GAZEBO = ("SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")

# How deep a workspace nests its packages, and how many folders are looked into: enough for ROS, not for a whole disk.
_DEPTH = 4
_FOLDERS = 5_000
_SKIPPED = {"build", "install", "log", "node_modules", "__pycache__"}


class Packages:
    """Knows where packages are; each is looked for once."""

    def __init__(self, given: Mapping[str, Path], environment: Mapping[str, str], source: Path) -> None:
        self.given = {name: Path(folder) for name, folder in given.items()}
        self.environment = environment
        self.source = Path(os.path.abspath(source))
        self._known: dict[str, Path | None] = {}
        self._listed: dict[Path, dict[str, Path]] = {}

    @staticmethod
    def name_of(folder: Path) -> str:
        """Return what the package.xml of a folder calls the package; empty if there is none."""
        return package_name(folder)

    def find(self, name: str) -> Path | None:
        """Return the folder of a package, in ROS 2 its share folder; None if it is not there."""
        if name not in self._known:
            folder = self._find(name) if _is_name(name) else None
            self._known[name] = folder
        return self._known[name]

    def found(self) -> list[tuple[str, Path]]:
        """Return the packages that were asked for and are there; of one within another the inner first."""
        known = [(name, Path(os.path.abspath(folder))) for name, folder in self._known.items() if folder is not None]
        return sorted(known, key=lambda one: -len(one[1].parts))

    def resolve(self, address: str, folder: Path) -> Path | None:
        """Return the file that an address names: package://, file:// or a path, relative to ``folder``.

        None if the package is not known, or the address is of another kind; the file need not exist.
        """
        scheme, colon, rest = address.partition("://")
        if not colon:
            return folder / address
        if scheme in ("package", "model"):
            name, _, path = rest.lstrip("/").partition("/")
            package = self.find(name)
            return None if package is None else package / path
        return Path(unquote(rest) if "%" in rest else rest) if scheme == "file" else None

    def _find(self, name: str) -> Path | None:
        if name in self.given:
            return Path(os.path.abspath(self.given[name]))
        for folder in self._entries("ROS_PACKAGE_PATH"):
            package = self._below(folder).get(name)
            if package is not None:
                return package
        for prefix in self._entries("AMENT_PREFIX_PATH"):
            share = prefix / "share" / name
            if files.is_folder(share):
                return share
        for folder in (entry for variable in OF_GAZEBO for entry in self._entries(variable)):
            if files.is_folder(folder / name):
                return folder / name
        return self._around(name)

    def _entries(self, variable: str) -> Iterator[Path]:
        for entry in self.environment.get(variable, "").split(os.pathsep):
            if entry:
                yield Path(entry)

    def _around(self, name: str) -> Path | None:
        """Return a package in a folder around the source, or beside the package that the source is in."""
        above = list(self.source.parents)
        own = None
        for folder in above:
            called = package_name(folder)
            if called == name:
                return folder
            if called and own is None:
                own = folder
        if own is not None:
            package = self._below(own.parent).get(name)
            if package is not None:
                return package
        for folder in above[:-1]:  # packages are often handed on without their package.xml
            if folder.name == name:
                return folder
        return next((folder / name for folder in above[:-1] if files.is_folder(folder / name)), None)

    def _below(self, top: Path) -> dict[str, Path]:
        """Return the packages in a folder by name; a package holds no further ones."""
        if top not in self._listed:
            folders: dict[str, Path] = {}
            seen: set[str] = set()
            waiting = [(top, 0)]
            while waiting and len(seen) < _FOLDERS:
                folder, depth = waiting.pop(0)
                where = str(files.resolve(folder))
                if where in seen:  # links that lead round
                    continue
                seen.add(where)
                try:
                    name = package_name(folder)
                except PermissionError:  # a folder that nobody may read is searched no further
                    continue
                if name:
                    folders.setdefault(name, folder)
                elif depth < _DEPTH:
                    waiting += [(inner, depth + 1) for inner in _folders(folder)]
            self._listed[top] = folders
        return self._listed[top]


def package_name(folder: Path) -> str:
    """Return what the package.xml of a folder calls the package; empty if there is none."""
    path = folder / PACKAGE_XML
    if not files.is_file(path):
        return ""
    from .xml.files import read_source
    from .xml.markup import MarkupError, parse

    try:
        root = parse(read_source(path)).root
    except MarkupError:
        return folder.name
    return next((child.text for child in root.children if child.tag == "name" and child.text), folder.name)


def _is_name(name: str) -> bool:
    return bool(name) and name not in (".", "..") and not any(letter in name for letter in "/\\\0")


def _folders(folder: Path) -> list[Path]:
    """Return the folders in a folder, in order; links are followed, as rospack does."""
    try:
        inside = files.list_folder(folder)
    except OSError:
        return []
    return [path for path in inside if path.is_dir() and not path.name.startswith(".") and path.name not in _SKIPPED]

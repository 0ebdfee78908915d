"""Data: tables in YAML that a xacro loads. They stay files: of their package where that has a name, else beside.

What a xacro of another package becomes is included from there, too, where that package has it already.

A package has a name where the description finds it by it: in the environment, or around its folder. What is loaded from
another one, or from beside the xacro, is copied into the folder of the description.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from .pieces import File
from .program import Program
from .texts import Unsupported

_ADDRESS = "package://"
_MOST, _BYTES = 200, 2_000_000


class Data:
    """The tables of one translation: ``files`` are those that are copied, text by name."""

    def __init__(self, program: Program, folder: Path) -> None:
        self.program = program
        self.named = Packages({}, os.environ, folder / "robot.yaml")
        self.files: dict[str, str] = {}
        self.used: dict[str, Path] = {}

    def name(self, text: str, rest: bool) -> str:
        """Return the name of a file here, or its beginning if there is a ``rest`` behind it. Raises Unsupported."""
        if text.startswith(_ADDRESS):
            package, _, file = text.removeprefix(_ADDRESS).partition("/")
            return self._of_package(package, file, rest)
        return self._beside(text, rest)

    def finds(self, package: str) -> bool:
        """Say whether the description finds the package that the xacro finds by a name; then it is used."""
        folder, own = self.program.packages.find(package), self.named.find(package)
        if folder is None or own is None or files.resolve(own) != files.resolve(folder):
            return False
        self.used[package] = folder
        return True

    def address_of(self, file: File, text: str) -> str:
        """Return the address at which the package of a xacro has what it becomes, to the letter; empty if none."""
        folders = [folder for folder in Path(file.path).parents if Packages.name_of(folder)][:1]
        if not folders or Path(self.program.root.path).is_relative_to(folders[0]):
            return ""
        package = Packages.name_of(folders[0])
        there = sorted((folders[0] / Description.FOLDER).glob(f"**/{Path(file.name).name}"))
        same = next((one for one in there if is_text(one, text)), None)
        if same is None or not self.finds(package):
            return ""
        return f"{_ADDRESS}{package}/{same.relative_to(folders[0]).as_posix()}"

    def _of_package(self, package: str, file: str, rest: bool) -> str:
        folder = self.program.packages.find(package)
        if folder is None:
            raise Unsupported(f'the package "{package}" is not found')
        if self.finds(package):
            return f"{_ADDRESS}{package}/{file}"
        self._copy(folder, file, rest)
        return file

    def _beside(self, text: str, rest: bool) -> str:
        if Path(text).is_absolute():
            raise Unsupported(f"{text} is a file of this machine")
        folders = [Path(path).parent for path in self.program.files]
        folder = next(
            (one for one in folders if files.exists(one / text.rpartition("/")[0]) and self._has(one, text)), None
        )
        if folder is None or ".." in Path(text).parts:
            raise Unsupported(f"{text} is not found")
        self._copy(folder, text, rest)
        return text

    def _has(self, folder: Path, text: str) -> bool:
        return files.exists(folder / text) or "/" in text

    def _copy(self, folder: Path, file: str, rest: bool) -> None:
        """Take down a file; of a name that goes on, all tables that it may be."""
        if not rest and not files.is_folder(folder / file):
            found = [folder / file]
        else:
            above = folder / file.rpartition("/")[0] if rest else folder / file
            found = [one for one in sorted(above.glob("**/*")) if one.suffix in (".yaml", ".yml")][:_MOST]
        for one in found:
            try:
                if one.stat().st_size <= _BYTES:
                    name = one.relative_to(folder).as_posix()
                    self.files[name] = files.read_text(one)
            except (OSError, ValueError) as problem:
                raise Unsupported(f"{one.name} cannot be read: {problem}") from None


def is_text(path: Path, text: str) -> bool:
    """Say whether a file has a text, to the letter."""
    try:
        return path.stat().st_size <= _BYTES and files.read_text(path) == text
    except (OSError, ValueError):
        return False


def opened(text: str) -> str:
    """Return the name of a file without ``file://``, and a package by its address."""
    return re.sub(r"^file://", "", text)

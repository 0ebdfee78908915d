"""The packages and the files that a translation names, as the description finds them."""

from __future__ import annotations

import os
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from .documents import GiveUp
from .ir import File, Program, Unsupported

_BYTES = 2_000_000  # of a file that is copied or compared


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

    def address_of(self, file: File, text: str) -> str:
        """Return the address at which the package of a xacro has the same description, or nothing."""
        folder = next((one for one in Path(file.path).absolute().parents if Packages.name_of(one)), None)
        if folder is None or Path(self.program.files[0].path).absolute().is_relative_to(folder):
            return ""
        package = Packages.name_of(folder)
        for there in sorted((folder / Description.FOLDER).glob(f"**/{Path(file.name).name}")):
            if there.stat().st_size <= _BYTES and files.read_text(there) == text and self._finds(package):
                return f"package://{package}/{there.relative_to(folder).as_posix()}"
        return ""

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

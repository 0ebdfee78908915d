"""Share files between the robots of a package: what several xacros include is written to ``descriptions/common``.

A file is shared if a xacro of the package that is no part of this robot includes it, too, itself or by others, and if
the description that is there has the same entries.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from ..reimport import ENDING, read_record
from .ir import File, Program

COMMON = "common"
_MOST, _BYTES = 2000, 2_000_000
_INCLUDE = re.compile(r"<(?:xacro:)?include\s[^<>]*?filename\s*=\s*[\"']([^\"']+)[\"']")
_FIND = re.compile(r"\$\(find\s+([^)\s]+)\)|^package://([^/]+)")


class Sharing:
    """What the robot in a folder of the descriptions of a package shares with others of that package."""

    def __init__(self, package: Path, folder: Path) -> None:
        self.package = Path(os.path.abspath(package))
        self.folder = folder
        self._apart: dict[str, str] = {}  # files that are not shared, with the file that is another
        self._graph: dict[str, set[str]] | None = None

    def placed(self, program: Program, file: File, text: str) -> tuple[str, str]:
        """Return the address of a file as seen from the robot, and its text: that of others if it is the same."""
        record = read_record(self.folder) if files.is_folder(self.folder) else None
        same = [
            os.path.relpath(one, self.folder) for one in sorted(self.folder.parent.glob(f"*/**/{Path(file.name).name}"))
        ]
        if record is not None and file.name not in record.files:  # where the import before has put it
            address = next((one for one in same if any(one in root for root in record.files.values())), "")
            if address and files.is_file(self._at(f"{address}{ENDING}")):
                return address, text
        if (record is not None and file.name in record.files) or not self._is_shared(program, file):
            return file.name, text
        parts = Path(os.path.abspath(file.path)).relative_to(self.package).parent.parts[1:]
        place = Path("..", COMMON, *(one for one in parts if one != COMMON), Path(file.name).name).as_posix()
        for address in dict.fromkeys((place, *same)):
            there = _text(self._at(address))
            if address != file.name and there is not None and _is_equal(there, text):
                return address, there
        if os.path.lexists(self._at(place)):
            self._apart[file.name] = f"{Description.FOLDER}/{place.removeprefix('../')}"
            return file.name, text
        return place, text

    def report(self, files: Mapping[str, str]) -> Iterator[str]:
        """Yield a line about each file that others include, too, and that is not shared."""
        for name, other in self._apart.items():
            if name in files:
                yield f"{name} is of this robot alone, since {other} is another"

    def _at(self, address: str) -> Path:
        return Path(os.path.normpath(self.folder / address))

    def _is_shared(self, program: Program, file: File) -> bool:
        """Return True if a xacro of the package that is no part of the robot includes a file."""
        common, path = self.folder.parent / COMMON, os.path.abspath(file.path)
        is_robot = common == self.folder or files.exists(common / Description.ROOT_FILE)
        if is_robot or not Path(path).is_relative_to(self.package):
            return False
        if self._graph is None:
            paths = [os.path.abspath(one) for one in sorted(self.package.glob("**/*.xacro"))[:_MOST]]
            self._graph = {one: set(self._included(Path(one), paths)) for one in paths}
        own = {os.path.abspath(one.path) for one in program.files}
        reached: set[str] = set()
        found = [one for other in self._graph.keys() - own for one in self._graph[other]]
        while found:
            one = found.pop()
            if one not in reached:
                reached.add(one)
                found += self._graph.get(one, ())
        return path in reached

    def _included(self, path: Path, paths: list[str]) -> Iterator[str]:
        text = re.sub(r"<!--.*?-->", "", _text(path) or "", flags=re.DOTALL)
        for name in _INCLUDE.findall(text):
            package = _FIND.match(name)
            rest = _FIND.sub("", name)
            if "$" in rest:  # of a name that depends on something, its end
                yield from (one for one in paths if "$" not in Path(rest).name and Path(one).name == Path(rest).name)
            elif package is None:
                yield os.path.normpath(path.parent / name)
            elif (package[1] or package[2]) == Packages.name_of(self.package):
                yield os.path.normpath(f"{self.package}/{rest}")


def _text(path: Path) -> str | None:
    try:
        return files.read_text(path) if path.stat().st_size <= _BYTES else None
    except (OSError, ValueError):
        return None


def _is_equal(one: str, other: str) -> bool:
    """Return True if two files have the same entries."""
    try:
        return bool(parse_yaml(Source("", one)) == parse_yaml(Source("", other)))
    except LoadError:
        return False

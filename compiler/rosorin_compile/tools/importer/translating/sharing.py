"""Sharing: what several robots of a package include is imported once, into ``descriptions/common``.

A file is shared if a xacro of the package that is no part of this robot includes it, too, itself or by others. What it
becomes can still be the robot's own: where it is not, to the letter, what the others have; ``apart`` says why.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from itertools import zip_longest
from pathlib import Path

from ....diagnostics import Source
from ....diagnostics.wording import quoted
from ....frontend.load import LoadError, parse_yaml
from ....frontend.packages import package_name
from ....frontend.tree import Map
from ....project import DESCRIPTIONS, ROOT_FILE
from .data import is_text
from .pieces import File
from .program import Program

COMMON = "common"
_MOST, _BYTES = 2000, 2_000_000
_INCLUDE = re.compile(r"<(?:xacro:)?include\s[^<>]*?filename\s*=\s*[\"']([^\"']+)[\"']")
_FIND = re.compile(r"\$\(find\s+([^)\s]+)\)|^package://([^/]+)")


class Sharing:
    """What the robot in a folder of the descriptions of a package shares with others of that package.

    ``places`` says where the shared ones of its files go, by their name here.
    """

    def __init__(self, package: Path, folder: Path) -> None:
        self.package = Path(os.path.abspath(package))
        self.folder = folder
        self.places: dict[str, str] = {}
        self._includes: dict[str, set[str]] | None = None

    def address_of(self, program: Program, file: File, text: str) -> str:
        """Return where others have what a file becomes, as seen from the robot; empty for a file of its own."""
        if not self._is_shared(program, file) or is_text(self.folder / file.name, text):
            return ""
        place = self._place(file)
        self.places[file.name] = place
        name = Path(file.name).name
        others = [os.path.relpath(one, self.folder) for one in sorted(self.folder.parent.glob(f"*/**/{name}"))]
        same = next((one for one in (place, *others) if is_text(self._at(one), text)), None)
        return same or ("" if os.path.lexists(self._at(place)) else place)

    def apart(self, files: Mapping[str, str]) -> Iterator[str]:
        """Yield why shared files are written for this robot alone, a line each."""
        for name, place in self.places.items():
            there = self._at(place)
            if name in files and there.is_file() and not is_text(there, files[name]):
                why = _difference(there.read_text("utf-8", "replace"), files[name])
                place = place.removeprefix("../")
                yield f"{name} is of this robot alone, since {DESCRIPTIONS}/{place} is another: {why}"

    def _at(self, address: str) -> Path:
        """Return what an address names, also while the folder of the robot is not there."""
        return Path(os.path.normpath(self.folder / address))

    def _place(self, file: File) -> str:
        """Return where a file goes: as in the package, without the first folder, such as ``urdf``, and ``common``."""
        within = [one for one in Path(file.path).relative_to(self.package).parent.parts[1:] if one != COMMON]
        return Path("..", COMMON, *within, Path(file.name).name).as_posix()

    def _is_shared(self, program: Program, file: File) -> bool:
        common = self.folder.parent / COMMON
        if common == self.folder or (common / ROOT_FILE).exists() or not Path(file.path).is_relative_to(self.package):
            return False
        includes = self._graph()
        reached: set[str] = set()
        found = [one for path in includes.keys() - program.files.keys() for one in includes[path]]
        while found:
            path = found.pop()
            if path not in reached:
                reached.add(path)
                found += includes.get(path, ())
        return file.path in reached

    def _graph(self) -> dict[str, set[str]]:
        """Return what each xacro of the package includes of it, as far as the names are said."""
        if self._includes is None:
            paths = [
                os.path.abspath(one) for one in sorted(self.package.rglob("*.xacro"))[:_MOST] if _is_text_file(one)
            ]
            self._includes = {path: set(self._included(Path(path), paths)) for path in paths}
        return self._includes

    def _included(self, path: Path, paths: list[str]) -> Iterator[str]:
        for name in _INCLUDE.findall(re.sub(r"<!--.*?-->", "", path.read_text("utf-8", "replace"), flags=re.S)):
            package = _FIND.match(name)
            rest = _FIND.sub("", name)
            if "$" in rest:  # of a name that is not known by now, its end
                yield from (one for one in paths if "$" not in Path(rest).name and Path(one).name == Path(rest).name)
            elif package is None:
                yield os.path.normpath(path.parent / name)
            elif (package[1] or package[2]) == package_name(self.package):
                yield os.path.normpath(f"{self.package}/{rest}")


def _is_text_file(path: Path) -> bool:
    return path.is_file() and path.stat().st_size <= _BYTES


def _difference(there: str, here: str) -> str:
    """Return why a file of others is not that of a robot: parts that one has alone, else the first other line."""
    others, own = _parts(there), _parts(here)
    lacks = [name for name in own if name not in others]
    if lacks:
        return f"this robot uses {quoted(lacks)}, too"
    more = [name for name in others if name not in own]
    if more:
        return f"this robot does not use {quoted(more)}"
    lines = enumerate(zip_longest(there.split("\n"), here.split("\n"), fillvalue=""), 1)
    number, (first, second) = next((one for one in lines if one[1][0] != one[1][1]), (1, ("", "")))
    return f'line {number} there is "{first.strip()}", and here "{second.strip()}"'


def _parts(text: str) -> list[str]:
    """Return the names of the parts and values that a file has."""
    try:
        tree = parse_yaml(Source("", text))
    except LoadError:
        return []
    sections = [tree.get(name) for name in ("parts", "let", "args", "materials")] if isinstance(tree, Map) else []
    return [str(name) for section in sections if isinstance(section, Map) for name in section]

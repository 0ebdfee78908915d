"""Find ROS packages by name: in the search paths of ROS 1, ROS 2 and Gazebo, and near the file of the robot."""

import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import islice
from pathlib import Path
from urllib.parse import unquote

from . import files
from .xml.markup import MarkupError, parse, read_source

PACKAGE_XML = "package.xml"
OF_GAZEBO = ("SDF_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH", "GAZEBO_MODEL_PATH")
_DEPTH, _FOLDERS = 4, 5_000  # maximum depth and number of folders of a search
_SKIPPED = {"build", "install", "log", "node_modules", "__pycache__"}


def package_name(folder: Path) -> str:
    """Return the package name in ``package.xml`` of a folder, or an empty string if the folder is not a package."""
    path = folder / PACKAGE_XML
    if not files.is_file(path):
        return ""
    with suppress(MarkupError):
        names = (child.text for child in parse(read_source(path)).root.children if child.tag == "name")
        return next(filter(None, names), folder.name)
    return folder.name


def package_of(folder: Path) -> tuple[Path, str] | None:
    """Return (folder, name) of the ROS package that contains a folder, or None if it is in no package."""
    folder = files.resolve(folder)
    for place in (folder, *list(folder.parents)[:4]):
        if name := package_name(place):
            return place, name
    return None


class Packages:
    """Find the folders of ROS packages by name, and cache the results.

    ``given`` maps names to folders and takes precedence over search paths, such as ``AMENT_PREFIX_PATH``, in
    ``environment``. Packages that contain the file ``source``, or are next to it, are searched last.
    """

    def __init__(self, given: Mapping[str, Path], environment: Mapping[str, str], source: Path) -> None:
        self.given = {name: Path(os.path.abspath(folder)) for name, folder in given.items()}
        self.environment = environment
        self.source = Path(os.path.abspath(source))
        self._known: dict[str, Path | None] = {}
        self._listed: dict[Path, dict[str, Path]] = {}

    name_of = staticmethod(package_name)

    def find(self, name: str) -> Path | None:
        """Return the folder of a package (in ROS 2, its share folder), or None if the package is not found."""
        if name not in self._known:
            is_name = name not in ("", ".", "..") and not any(letter in name for letter in "/\\\0")
            self._known[name] = next(self._candidates(name), None) if is_name else None
        return self._known[name]

    def found_packages(self) -> list[tuple[str, Path]]:
        """Return (name, folder) of the packages that ``find`` has found, nested packages before enclosing packages."""
        known = [(name, Path(os.path.abspath(folder))) for name, folder in self._known.items() if folder is not None]
        return sorted(known, key=lambda pair: -len(pair[1].parts))

    def resolve(self, address: str, folder: Path) -> Path | None:
        """Resolve a package, model or file URL or a path relative to ``folder``; return None for an unknown package."""
        scheme, colon, rest = address.partition("://")
        if not colon:
            return folder / address
        if scheme in ("package", "model"):
            name, _, path = rest.lstrip("/").partition("/")
            package = self.find(name)
            return None if package is None else package / path
        return Path(unquote(rest)) if scheme == "file" else None

    def _candidates(self, name: str) -> Iterator[Path]:
        if name in self.given:
            yield self.given[name]
        for folder in self._entries("ROS_PACKAGE_PATH"):
            if name in (packages := self._below(folder)):
                yield packages[name]
        places = [prefix / "share" / name for prefix in self._entries("AMENT_PREFIX_PATH")]
        places += [folder / name for variable in OF_GAZEBO for folder in self._entries(variable)]
        yield from filter(files.is_folder, places)
        # Search the packages that contain the file of the robot, and the packages next to the innermost package.
        above = list(self.source.parents)
        own = None
        for folder in above:
            called = package_name(folder)
            if called == name:
                yield folder
            own = own or (folder if called else None)
        if own is not None and name in (packages := self._below(own.parent)):
            yield packages[name]
        # Many downloads have no package.xml: use a folder with the name of the package.
        places = [*(folder for folder in above[:-1] if folder.name == name), *(folder / name for folder in above[:-1])]
        yield from filter(files.is_folder, places)

    def _entries(self, variable: str) -> Iterator[Path]:
        return map(Path, filter(None, self.environment.get(variable, "").split(os.pathsep)))

    def _below(self, top: Path) -> dict[str, Path]:
        if top not in self._listed:
            found, visited = self._listed.setdefault(top, {}), set()
            for path, inner, _ in islice(os.walk(top, followlinks=True), _FOLDERS):
                folder, name = Path(path), ""
                is_new = (real := files.resolve(folder)) not in visited  # symbolic links may form a loop
                visited.add(real)
                with suppress(OSError):
                    name = package_name(folder) if is_new else ""
                if name:
                    found.setdefault(name, folder)
                is_searched = is_new and not name and len(folder.relative_to(top).parts) < _DEPTH
                inner[:] = sorted(n for n in inner if is_searched and n[0] != "." and n not in _SKIPPED)
        return self._listed[top]

"""Included: the files that an <include> of an SDF names, and how much may be included in all.

A file of a stranger says which files are read with it. They are in the folder of the first file, in a package or a
model that is found by its name, or where the user said: ``--package``, the variables of the environment. And each of
them may include others, twice: one budget holds for all that is read of a robot.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from rosorin_compile.formats.urdf.reading import Reading
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.files import exists, is_file, is_folder, resolve
from rosorin_compile.source.packages import OF_GAZEBO, Packages
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, parse

_ROS_PATHS = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")
_OF_A_MODEL = ("model.config", "package.xml", "model.sdf")
_NOT_FETCHED = "download the model, and name the file: nothing is fetched from the net"

MAX_MODELS = 1_000
MAX_ELEMENTS = 200_000


class Included:
    """Finds and reads what an SDF includes; ``files`` are those that were read, the first one first."""

    def __init__(self, reading: Reading, file: Path) -> None:
        self.reading = reading
        self.files: list[Path] = [file]
        given = reading.options.environment
        self.environment = os.environ if given is None else given
        self.packages = Packages(reading.options.packages, self.environment, file)
        self._said = [Path(os.path.abspath(folder)) for folder in reading.options.packages.values()]
        self._said += [Path(os.path.abspath(entry)) for entry in self._entries((*OF_GAZEBO, *_ROS_PATHS))]
        own = (Path(os.path.abspath(file)).parent, resolve(file).parent)
        self._homes = [resolve(folder) for folder in (*own, *self._said)]
        self._elements = 0
        self._is_full = False

    def _entries(self, variables: tuple[str, ...]) -> Iterator[str]:
        for variable in variables:
            yield from (entry for entry in self.environment.get(variable, "").split(os.pathsep) if entry)

    def document(self, file: Path, asked: Span) -> Document | None:
        """Return a file that is included, and count it; None after an error, and when the budget is spent."""
        if self._is_full:
            return None
        try:
            document = parse(read_source(file, asked))
        except MarkupError as problem:
            self.reading.diagnostics.append(problem.diagnostic)
            return None
        self.files.append(file)
        self._elements += sum(1 for _ in document.root.iter())
        if len(self.files) > MAX_MODELS or self._elements > MAX_ELEMENTS:
            self._is_full = True
            message = f"more is included than a robot has: over {MAX_MODELS:,} models, or {MAX_ELEMENTS:,} elements"
            self.reading.error("include-too-many", message, asked, "do files include each other, or one many times?")
            return None
        return document

    def find(self, uri: str, beside: Path) -> tuple[Path | None, str, str]:
        """Return the file of an address; without one why it is not read, empty if it is not there, and the way out."""
        if re.match(r"https?://", uri):
            return None, "", _NOT_FETCHED
        refused = False
        scheme, _, rest = uri.partition("://")
        name = (rest or scheme).partition("/")[0]
        for path in self._places(uri, beside):
            found = _of_folder(path) if is_folder(path) else path
            if found is None or not exists(found):
                continue
            if self._is_allowed(found):
                return found, "", ""
            refused = True
        if refused:
            what = f"{uri} lies outside the folder of the robot, and is not read"
            return None, what, "move it there, or allow its folder: --package NAME=FOLDER"
        return None, "", f"put it beside the file, or say where it is: --package {name}=FOLDER"

    def _is_allowed(self, file: Path) -> bool:
        """Say whether a file is where files may be read; links are followed, but in folders that the user names."""
        plain, led = Path(os.path.abspath(file)), resolve(file)
        return any(plain.is_relative_to(one) for one in self._said) or any(led.is_relative_to(o) for o in self._homes)

    def _places(self, uri: str, beside: Path) -> Iterator[Path]:
        """Yield where the file of an address may be, as seen from the file that names it."""
        scheme, colon, rest = uri.partition("://")
        folder = Path(os.path.abspath(beside)).parent
        if not colon:
            yield folder / uri
            rest = uri
        elif scheme == "file":
            yield folder / rest
            return
        name, _, inside = rest.partition("/")
        package = self.packages.find(name)
        if package is not None:
            self._may_be_read(package)
            yield package / inside
        for entry in self._entries(OF_GAZEBO):
            yield Path(entry, rest)
        for above in (folder, *folder.parents):
            if name not in ("", ".", ".."):
                self._may_be_read(above / name)
            yield above / rest

    def _may_be_read(self, folder: Path) -> None:
        """Let files of a folder be read that was found by its name: a model, a package, or what the robot is in."""
        is_around = resolve(self.files[0]).is_relative_to(resolve(folder)) and not _is_of_a_person(folder)
        if is_around or any(is_file(folder / name) for name in _OF_A_MODEL):
            self._homes.append(resolve(folder))


def _is_of_a_person(folder: Path) -> bool:
    """Say whether a folder is one in which all that a person has may be, which is no model: /home, /tmp, ~."""
    led, home = resolve(folder), resolve(os.environ.get("HOME", "") or os.path.expanduser("~"))
    return len(led.parts) <= 2 or home.is_relative_to(led)


def _of_folder(folder: Path) -> Path | None:
    """Return the SDF of a folder of a model, the newest that its model.config names; None if there is none."""
    config = folder / "model.config"
    try:
        root = parse(read_source(config)).root
        named_there = [child for child in root.children if child.tag == "sdf"]
    except (MarkupError, OSError):
        named_there = []
    files = [folder / one.text for one in sorted(named_there, key=_age, reverse=True)]
    return next((file for file in (*files, folder / "model.sdf") if is_file(file)), None)


def _age(sdf: Element) -> list[int]:
    """Return the version of an <sdf> of a model.config as numbers."""
    return [int(digits) for digits in re.findall(r"\d+", sdf.get("version"))]

"""Read values of SDF elements: numbers, poses, unknown elements, and the files that an <include> names."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.formats.xml_reader import ANGLES, LENGTHS, UNITS, XmlReader
from rosorin_compile.model import Pose, Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.files import exists, is_file, is_folder, resolve
from rosorin_compile.source.packages import OF_GAZEBO, Packages
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.markup import (
    Document,
    Element,
    MarkupError,
    correction,
    name_of,
    parse,
    place,
    read_source,
    words,
)

from .content import UNLIMITED

_INFINITE = re.compile(r"[-+]?(?:inf|infinity)\Z", re.I)
_POSE_ATTRIBUTES = ("relative_to", "frame", "rotation_format", "degrees")
_ROUNDING = 1e-15  # as in ``Pose``: smaller numbers of a pose are rounding errors
MAX_MODELS = 1_000  # the files that a robot may consist of, each inclusion counted
MAX_ELEMENTS = 200_000  # in these files
_ROS_PATHS = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")


class WrittenPose(NamedTuple):
    """A pose: its transform, its numbers with their places (empty if only computed), and its <pose> element."""

    transform: Transform
    xyz: Sequence[Placed] = ()
    rpy: Sequence[Placed] = ()
    element: Element | None = None

    def entry(self, span: Span) -> dict[str, Any]:
        """Return the keys ``xyz`` and ``rpy`` of an entry, each unless it is zero."""
        xyz = self.xyz or [Placed(clean_number(value), span) for value in self.transform.xyz]
        rpy = self.rpy or [Placed(clean_number(value), span) for value in self.transform.rpy()]
        keys = (("xyz", xyz), ("rpy", rpy))
        return {key: Placed(list(values), values[0].span) for key, values in keys if any(one.value for one in values)}


def clean_number(value: float) -> float:
    """Return a calculated number without rounding errors."""
    return 0.0 if abs(value) < _ROUNDING else float(f"{value:.15g}")


def is_true(text: str) -> bool:
    """Return True if a text of SDF is true."""
    return text.lower() in ("1", "true")


def name_span(element: Element) -> Span:
    """Return the position of the name of an element, or of the element."""
    return element.attributes["name"].span if "name" in element.attributes else element.span


class SdfValues(XmlReader):
    """One reading of an SDF and of the files that it includes; ``files`` are all of them, the first one first."""

    def __init__(self, options: ReadOptions, file: Path) -> None:
        super().__init__(options)
        self.files: list[Path] = [file]
        self.environment = os.environ if options.environment is None else options.environment
        self.packages = Packages(options.packages, self.environment, file)
        allowed = [*options.packages.values(), *map(Path, self._folders(*OF_GAZEBO, *_ROS_PATHS))]
        self._allowed = [Path(os.path.abspath(folder)) for folder in allowed]
        folders = (Path(os.path.abspath(file)).parent, resolve(file).parent)
        self._resolved_allowed = [resolve(folder) for folder in (*folders, *self._allowed)]
        self._elements, self._is_too_much = 0, False

    # Values of elements

    def text(self, element: Element, tag: str) -> Placed | None:
        child = self.single(element, tag)
        return None if child is None or not child.text else Placed(child.text, place(child))

    def all_of(self, element: Element, count: int, unit: str = "") -> list[Placed] | None:
        return self.numbers(words(element), element, "", element.span, count, unit)

    def one(self, element: Element | None, tag: str, unit: str = "") -> Placed | None:
        child = None if element is None else self.single(element, tag)
        found = None if child is None else self.all_of(child, 1, unit)
        return found[0] if found else None

    def limit(self, element: Element | None, tag: str, unit: str) -> Placed | None:
        """Return a limit, or None if it is missing or infinite, or after an error."""
        child = None if element is None else self.single(element, tag)
        found = None if child is None or _INFINITE.match(child.text) else self.one(element, tag, unit)
        return found if found is not None and abs(found.value) < UNLIMITED else None

    def pose(self, element: Element | None) -> WrittenPose:
        """Return the pose of a <pose>; a missing or empty one is the identity."""
        none = WrittenPose(Transform(), element=element)
        if element is None or not words(element):
            return none
        form = element.get("rotation_format", "euler_rpy")
        if form == "euler_rpy":
            self.check_attributes(element, _POSE_ATTRIBUTES)
        elif form != "quat_xyzw":
            message, help = f'the rotation of {name_of(element)} is in "{form}"', "one of euler_rpy, quat_xyzw"
            self.error("wrong-value", message, element.attributes["rotation_format"].span, help)
        found = self.all_of(element, 7 if form == "quat_xyzw" else 6)
        if found is None:
            return none
        if form == "quat_xyzw":
            x, y, z, a, b, c, w = (float(one.value) for one in found)
            if any((a, b, c, w)):
                return WrittenPose(Transform.of_quaternion((x, y, z), (w, a, b, c)), found[:3], (), element)
            message = f"the quaternion of {name_of(element)} is zero: no rotation"
            self.error("zero-quaternion", message, element.span, "correct it")
            return none
        if is_true(element.get("degrees")):
            found = [*found[:3], *(Placed(math.radians(one.value), one.span) for one in found[3:])]
        xyz, rpy = ([_with_unit(one, unit) for one in found[at : at + 3]] for at, unit in ((0, LENGTHS), (3, ANGLES)))
        x, y, z, a, b, c = (float(one.value) for one in (*xyz, *rpy))
        return WrittenPose(Pose((x, y, z), (a, b, c)).transform(), xyz, rpy, element)

    def rest(self, element: Element, read: Collection[str], attributes: Collection[str] = ()) -> list[Element]:
        """Return the children that the caller does not read; report misspelt ones."""
        known = {*read, *sdf_elements().get(element.tag, ())}
        tags = [child.tag for child in element.children if child.tag in known or correction(child.tag, known) is None]
        self.check(element, {*known, *tags}, attributes, None)
        found = [child for child in element.children if child.tag in tags and child.tag not in read]
        return [child for child in found if not child.tag.startswith("xacro:")]

    # Included files

    def _folders(self, *variables: str) -> Iterator[str]:
        for variable in variables:
            yield from filter(None, self.environment.get(variable, "").split(os.pathsep))

    def open_included(self, file: Path, asked: Span) -> Document | None:
        """Return a file that is included, and count it; None after an error, and when too much is included."""
        if self._is_too_much:
            return None
        try:
            document = parse(read_source(file, asked))
        except MarkupError as problem:
            self.diagnostics.append(problem.diagnostic)
            return None
        self.files.append(file)
        self._elements += sum(1 for _ in document.root.iter())
        self._is_too_much = len(self.files) > MAX_MODELS or self._elements > MAX_ELEMENTS
        if not self._is_too_much:
            return document
        message = f"more is included than a robot has: over {MAX_MODELS:,} models, or {MAX_ELEMENTS:,} elements"
        self.error("include-too-many", message, asked, "do files include each other, or one many times?")
        return None

    def find_file(self, uri: str, including: Path) -> tuple[Path | None, str, str]:
        """Return the file of an address, or None with the reason (empty if it is not found) and what to do.

        Only files in the folder of the first file, in packages and models found by name, and in folders that the user
        names (``--package``, environment) may be included: the SDF may be of unknown origin.
        """
        if re.match(r"https?://", uri):
            return None, "", "download the model, and name the file: nothing is fetched from the net"
        name = uri.partition("://")[2].partition("/")[0]
        folders = [Path(os.path.abspath(including)).parent, *map(Path, self._folders(*OF_GAZEBO))]
        found = [self.packages.resolve(uri, folder) for folder in (folders if not name else folders[:1])]
        models = [_model_in(path) if is_folder(path) else path for path in found if path is not None]
        files = [file for file in models if file is not None and exists(file)]
        package = self.packages.find(name)
        if package is not None and any(is_file(package / one) for one in ("model.config", "package.xml", "model.sdf")):
            self._resolved_allowed.append(resolve(package))
        for file in files:
            absolute, resolved = Path(os.path.abspath(file)), resolve(file)
            is_allowed = any(absolute.is_relative_to(folder) for folder in self._allowed)
            if is_allowed or any(resolved.is_relative_to(folder) for folder in self._resolved_allowed):
                return file, "", ""
        if files:
            reason = f"{uri} lies outside the folder of the robot, and is not read"
            return None, reason, "move it there, or allow its folder: --package NAME=FOLDER"
        name = name or uri.partition("/")[0]
        return None, "", f"put it next to the file, or say where it is: --package {name}=FOLDER"


def _with_unit(one: Placed, unit: str) -> Placed:
    dimension, far = UNITS[unit]
    return Placed(Quantity(one.value, dimension, f"{one.value} {unit}"), one.span) if abs(one.value) > far else one


def _model_in(folder: Path) -> Path | None:
    """Return the newest SDF that the model.config of a folder names, or its model.sdf."""
    listed: list[Element] = []
    if is_file(config := folder / "model.config"):
        with suppress(MarkupError):
            listed = [child for child in parse(read_source(config)).root.children if child.tag == "sdf"]
    listed.sort(key=lambda sdf: [int(digits) for digits in re.findall(r"\d+", sdf.get("version"))], reverse=True)
    files = [*(folder / one.text for one in listed), folder / "model.sdf"]
    return next((file for file in files if is_file(file)), None)

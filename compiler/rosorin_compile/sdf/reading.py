"""Read values of SDF elements: numbers, poses, kept elements, and the files that an <include> names."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS, UNITS, Reading
from rosorin_compile.model import Pose, Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.files import exists, is_file, is_folder, resolve
from rosorin_compile.source.packages import OF_GAZEBO, Packages
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, correction, named, parse, place, words

from .content import UNLIMITED

_INFINITE = re.compile(r"[-+]?(?:inf|infinity)\Z", re.I)
_OF_POSE = ("relative_to", "frame", "rotation_format", "degrees")
# As ``Pose`` has it: below this, the numbers of a pose are what rounding has left of a way there and back.
_ROUNDING = 1e-15

# The files that one robot may consist of; each of them may include others twice.
MAX_MODELS = 1_000
MAX_ELEMENTS = 200_000
_ROS_PATHS = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")


class WrittenPose(NamedTuple):
    """A pose as it is written: its transform, its numbers with their places if they can be kept, its element."""

    transform: Transform
    xyz: Sequence[Placed] = ()
    rpy: Sequence[Placed] = ()
    element: Element | None = None

    def entry(self, span: Span) -> dict[str, Any]:
        """Return the keys ``xyz`` and ``rpy`` of an entry, without those that move nothing."""
        xyz = self.xyz or [Placed(cleaned(value), span) for value in self.transform.xyz]
        rpy = self.rpy or [Placed(cleaned(value), span) for value in self.transform.rpy()]
        keys = (("xyz", xyz), ("rpy", rpy))
        return {key: Placed(list(values), values[0].span) for key, values in keys if any(one.value for one in values)}


def cleaned(value: float) -> float:
    """Return a number that was calculated without what rounding has left in it."""
    return 0.0 if abs(value) < _ROUNDING else float(f"{value:.15g}")


class SdfReading(Reading):
    """One reading of an SDF and of the files that it includes; ``files`` are those, the first one first."""

    def __init__(self, options: ReadOptions, file: Path) -> None:
        super().__init__(options)
        self.files: list[Path] = [file]
        self.environment = os.environ if options.environment is None else options.environment
        self.packages = Packages(options.packages, self.environment, file)
        self._allowed = [Path(os.path.abspath(folder)) for folder in options.packages.values()]
        self._allowed += [Path(os.path.abspath(entry)) for entry in self._entries((*OF_GAZEBO, *_ROS_PATHS))]
        folders = (Path(os.path.abspath(file)).parent, resolve(file).parent)
        self._resolved_allowed = [resolve(folder) for folder in (*folders, *self._allowed)]
        self._elements = 0

    # Values of elements

    def text(self, element: Element, tag: str) -> Placed | None:
        """Return the text of a child with its place, or None if it is missing or empty."""
        child = self.single(element, tag)
        return None if child is None or not child.text else Placed(child.text, place(child))

    def all_of(self, element: Element, count: int, unit: str = "") -> list[Placed] | None:
        """Return the numbers of an element, or None after an error."""
        return self.numbers(words(element), named(element), element.span, count, unit)

    def one(self, element: Element | None, tag: str, unit: str = "") -> Placed | None:
        """Return the number of a child, or None if it is missing, or after an error."""
        child = None if element is None else self.single(element, tag)
        found = None if child is None else self.all_of(child, 1, unit)
        return found[0] if found else None

    def limit(self, element: Element | None, tag: str, unit: str) -> Placed | None:
        """Return a limit, or None if it is missing or infinite, or after an error."""
        child = None if element is None else self.single(element, tag)
        if child is None or _INFINITE.match(child.text):
            return None
        found = self.one(element, tag, unit)
        return found if found is not None and abs(found.value) < UNLIMITED else None

    def pose(self, element: Element | None) -> WrittenPose:
        """Return the pose of a <pose>; one that is missing or empty moves nothing."""
        if element is None or not words(element):
            return WrittenPose(Transform(), element=element)
        form = element.get("rotation_format", "euler_rpy")
        quaternion = form == "quat_xyzw"
        if form not in ("euler_rpy", "quat_xyzw"):
            span = element.attributes["rotation_format"].span
            message = f'the rotation of {named(element)} is in "{form}"'
            self.error("wrong-value", message, span, "one of euler_rpy, quat_xyzw")
        elif not quaternion:
            self.check_attributes(element, _OF_POSE)
        found = self.all_of(element, 7 if quaternion else 6)
        if found is None:
            return WrittenPose(Transform(), element=element)
        if quaternion:
            x, y, z, a, b, c, w = (float(one.value) for one in found)
            if any((a, b, c, w)):
                return WrittenPose(Transform.of_quaternion((x, y, z), (w, a, b, c)), found[:3], (), element)
            self.error(
                "zero-quaternion",
                f"the quaternion of {named(element)} is zero: no rotation",
                element.span,
                "correct it",
            )
            return WrittenPose(Transform(), element=element)
        if is_true(element.get("degrees")):
            found = [*found[:3], *(Placed(math.radians(one.value), one.span) for one in found[3:])]
        xyz, rpy = ([_with_unit(one, unit) for one in found[at : at + 3]] for at, unit in ((0, LENGTHS), (3, ANGLES)))
        x, y, z, a, b, c = (float(one.value) for one in (*xyz, *rpy))
        return WrittenPose(Pose((x, y, z), (a, b, c)).transform(), xyz, rpy, element)

    def rest(self, element: Element, read: Collection[str], attributes: Collection[str] = ()) -> list[Element]:
        """Return the children whose tags are not among those that are read; misspelt ones are reported."""
        known = {*read, *sdf_elements().get("axis" if element.tag == "axis2" else element.tag, ())}
        tags = [child.tag for child in element.children if child.tag in known or correction(child.tag, known) is None]
        self.check(element, {*known, *tags}, attributes, None)
        found = [child for child in element.children if child.tag in tags and child.tag not in read]
        return [child for child in found if not child.tag.startswith("xacro:")]

    # Included files

    def _entries(self, variables: tuple[str, ...]) -> Iterator[str]:
        for variable in variables:
            yield from (entry for entry in self.environment.get(variable, "").split(os.pathsep) if entry)

    def included(self, file: Path, asked: Span) -> Document | None:
        """Return a file that is included, and count it; None after an error, and when too much is included."""
        if len(self.files) > MAX_MODELS or self._elements > MAX_ELEMENTS:
            return None
        try:
            document = parse(read_source(file, asked))
        except MarkupError as problem:
            self.diagnostics.append(problem.diagnostic)
            return None
        self.files.append(file)
        self._elements += sum(1 for _ in document.root.iter())
        if len(self.files) > MAX_MODELS or self._elements > MAX_ELEMENTS:
            message = f"more is included than a robot has: over {MAX_MODELS:,} models, or {MAX_ELEMENTS:,} elements"
            self.error("include-too-many", message, asked, "do files include each other, or one many times?")
            return None
        return document

    def find_file(self, uri: str, including: Path) -> tuple[Path | None, str, str]:
        """Return the file of an address, or None with the reason (empty if it is not found) and what to do.

        The file of a stranger decides which files are read with it. They have to be in the folder of the first file, in
        a package or a model that is found by its name, or in a folder that the user named: with ``--package`` or in
        the environment.
        """
        if re.match(r"https?://", uri):
            return None, "", "download the model, and name the file: nothing is fetched from the net"
        scheme, colon, rest = uri.partition("://")
        folder, rest = Path(os.path.abspath(including)).parent, rest or uri
        name, _, inside = rest.partition("/")
        candidates = [folder / rest]
        if colon and scheme != "file":
            candidates += [above / rest for above in folder.parents]
            package = self.packages.find(name)
            if package is not None:
                candidates.insert(0, package / inside)
                if any(is_file(package / name) for name in ("model.config", "package.xml", "model.sdf")):
                    self._resolved_allowed.append(resolve(package))
        candidates += [Path(entry, rest) for entry in self._entries(OF_GAZEBO)]
        models = [_model_in(path) if is_folder(path) else path for path in candidates]
        files = [file for file in models if file is not None and exists(file)]
        for file in files:
            if any(map(Path(os.path.abspath(file)).is_relative_to, self._allowed)):
                return file, "", ""
            if any(map(resolve(file).is_relative_to, self._resolved_allowed)):
                return file, "", ""
        if files:
            what = f"{uri} lies outside the folder of the robot, and is not read"
            return None, what, "move it there, or allow its folder: --package NAME=FOLDER"
        return None, "", f"put it next to the file, or say where it is: --package {name}=FOLDER"


def _with_unit(one: Placed, unit: str) -> Placed:
    dimension, far = UNITS[unit]
    return Placed(Quantity(one.value, dimension, f"{one.value} {unit}"), one.span) if abs(one.value) > far else one


def is_true(text: str) -> bool:
    """Return True if a text of SDF is true."""
    return text.lower() in ("1", "true")


def _model_in(folder: Path) -> Path | None:
    """Return the SDF of a model's folder, the newest that its model.config names; None if there is none."""
    try:
        root = parse(read_source(folder / "model.config")).root
    except (MarkupError, OSError):
        return folder / "model.sdf" if is_file(folder / "model.sdf") else None
    named_there = [child for child in root.children if child.tag == "sdf"]
    named_there.sort(key=lambda sdf: [int(digits) for digits in re.findall(r"\d+", sdf.get("version"))], reverse=True)
    files = [folder / one.text for one in named_there]
    return next((file for file in (*files, folder / "model.sdf") if is_file(file)), None)

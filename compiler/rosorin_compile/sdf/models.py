"""Resolve the nested and included models of an SDF, with their files, names and poses.

A model is a scope: its links, frames, joints and models share a namespace, and ``other::name`` is in a nested model.
A pose can be relative to any of these; the root of all poses is the frame of the outermost model (``__model__``).
Source: http://sdformat.org/tutorials?tut=pose_frame_semantics.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.format import SourceValue
from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.formats.xml_reader import ANGLES, LENGTHS, NAME, UNITS, XmlReader, artifact_numbers, sequence
from rosorin_compile.model import Pose, Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import Related, Span, Suggestion, count_of, quote
from rosorin_compile.source.files import exists, is_file, is_folder, resolve
from rosorin_compile.source.packages import OF_GAZEBO, Packages
from rosorin_compile.source.tree import Seq
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml import markup
from rosorin_compile.source.xml.elements import kept_text
from rosorin_compile.source.xml.markup import Attribute, Document, Element, MarkupError, correction, name_of, words

from .content import RESERVED, UNLIMITED, WORLD

LINK, FRAME, JOINT, MODEL = "link", "frame", "joint", "model"
OWN = "__model__"
_VERSIONS = [f"1.{minor}" for minor in range(4, 13)]
_DEEPEST = 20  # maximum depth of nested models; deeper nesting is a cycle of includes
_INFINITE = re.compile(r"[-+]?(?:inf|infinity)\Z", re.I)
_ROUNDING = 1e-15  # smaller numbers in a pose are rounding errors
_PLAUSIBLE = min(far for _, far in UNITS.values())  # larger numbers in a pose get an explicit unit
MAX_MODELS = 1_000  # maximum number of included models
MAX_ELEMENTS = 200_000  # maximum number of XML elements in all files
_ROS_PATHS = ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")


class WrittenPose(NamedTuple):
    """A pose and its <pose> element; ``xyz`` and ``rpy`` are the numbers in the file, None if they were computed."""

    transform: Transform
    xyz: Seq | None = None
    rpy: Seq | None = None
    element: Element | None = None

    def entry(self, span: Span) -> dict[str, Any]:
        """Return the keys ``xyz`` and ``rpy`` of an entry, without those that are zero."""
        xyz = self.xyz or sequence(map(clean_number, self.transform.xyz), [span] * 3)
        rpy = self.rpy or sequence(map(clean_number, self.transform.rpy()), [span] * 3)
        return {key: SourceValue(values, values.span) for key, values in (("xyz", xyz), ("rpy", rpy)) if any(values)}


def clean_number(value: float) -> float:
    """Round a number to 15 digits, and to zero if it is only a rounding error."""
    return 0.0 if abs(value) < _ROUNDING else float(f"{value:.15g}")


def is_true(text: str) -> bool:
    """Return True if an SDF value is "true" or "1"."""
    return text.lower() in ("1", "true")


def name_span(element: Element) -> Span:
    """Return the source position of the name of an element, or of the element if it has no name."""
    return element.attributes["name"].span if "name" in element.values else element.span


@dataclass(eq=False)
class Node:
    """A named element of an SDF with a pose: a link, frame, joint or model."""

    kind: str
    name: str
    element: Element
    scope: Scope
    written: WrittenPose  # pose in the file, which can be relative to another frame
    called: str = ""  # unique name in the description
    inner: Scope | None = None  # contents of a model

    @property
    def child(self) -> Element | None:
        return next((one for one in self.element.children if one.tag == "child"), None) if self.kind == JOINT else None


@dataclass(eq=False)
class Scope:
    """The namespace of a model, with its element, file and SDF version, and the <include> of an included model."""

    element: Element
    file: Path
    version: tuple[int, ...]
    outer: Scope | None
    name: str
    including: Element | None = None
    nodes: dict[str, Node] = field(default_factory=dict)
    node: Node | None = None

    @property
    def is_merged(self) -> bool:
        return self.including is not None and is_true(self.including.get("merge"))

    @property
    def depth(self) -> int:
        return 0 if self.outer is None else self.outer.depth + 1

    @property
    def prefix(self) -> str:
        """The prefix of all names in this model after the import."""
        above = "" if self.outer is None else self.outer.prefix
        return above if self.outer is None or self.is_merged else f"{above}{self.name}_"

    def all_nodes(self) -> Iterator[Node]:
        for node in self.nodes.values():
            yield node
            if node.inner is not None:
                yield from node.inner.all_nodes()

    def find(self, name: str) -> Node | None:
        """Resolve a name such as "arm::hand", or return None if it does not exist."""
        if name in self.nodes:
            return self.nodes[name]
        first, colon, rest = name.partition("::")
        model = self.nodes.get(first) if colon else None
        if model is not None and model.inner is not None:
            return model.inner.find(rest)
        merged = (node.inner for node in self.nodes.values() if node.inner is not None and node.inner.is_merged)
        return next((node for scope in merged if (node := scope.find(name)) is not None), None)


def relative_to(pose: Element | None) -> Attribute | None:
    """Return the attribute that names the frame of a <pose>, or None if it is relative to its parent element."""
    name = "relative_to" if pose is not None and "relative_to" in pose.values else "frame"
    return pose.attribute(name) if pose is not None and pose.get(name) else None


class SdfReader(XmlReader):
    """The state of importing an SDF; ``files`` are the main file and all included files."""

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
        self._poses: dict[Node, Transform] = {}

    def text(self, element: Element, tag: str) -> SourceValue | None:
        child = self.single(element, tag)
        return None if child is None or not child.text else SourceValue(child.text, markup.place(child))

    def all_of(self, element: Element, count: int, unit: str = "") -> Seq | None:
        plain = artifact_numbers(element, element.text, count)
        return self.numbers(words(element), element, "", element.span, count, unit) if plain is None else plain

    def one(self, element: Element | None, tag: str, unit: str = "") -> SourceValue | None:
        child = None if element is None else self.single(element, tag)
        found = None if child is None else self.all_of(child, 1, unit)
        return SourceValue(found[0], found.value_spans[0]) if found else None

    def limit(self, element: Element | None, tag: str, unit: str) -> SourceValue | None:
        """Parse a child of a <limit>; return None if it is missing or infinite, or after reporting an error."""
        child = None if element is None else self.single(element, tag)
        found = None if child is None or _INFINITE.match(child.text) else self.one(element, tag, unit)
        return found if found is not None and abs(found.value) < UNLIMITED else None

    def pose(self, element: Element | None) -> WrittenPose:
        """Parse a <pose>; a missing or empty <pose> is the identity."""
        if element is None or not element.text:
            return WrittenPose(Transform(), element=element)
        form = element.get("rotation_format", "euler_rpy")
        if form == "euler_rpy":
            self.check_attributes(element, ("relative_to", "frame", "rotation_format", "degrees"))
        elif form != "quat_xyzw":
            message, help = f'the rotation of {name_of(element)} is in "{form}"', "one of euler_rpy, quat_xyzw"
            self.error("wrong-value", message, element.attributes["rotation_format"].span, help)
        if (found := self.all_of(element, 7 if form == "quat_xyzw" else 6)) is None:
            return WrittenPose(Transform(), element=element)
        if form == "quat_xyzw":
            x, y, z, a, b, c, w = map(float, found)
            if any((a, b, c, w)):
                xyz = sequence(found[:3], found.value_spans[:3])
                return WrittenPose(Transform.of_quaternion((x, y, z), (w, a, b, c)), xyz, None, element)
            message = f"the quaternion of {name_of(element)} is zero: no rotation"
            self.error("zero-quaternion", message, element.span, "write a rotation, such as 0 0 0 1 for none")
            return WrittenPose(Transform(), element=element)
        if is_true(element.get("degrees")):
            found[3:] = map(math.radians, found[3:])
        x, y, z, a, b, c = map(float, found)
        if max(map(abs, found)) > _PLAUSIBLE:
            found[:] = map(_with_unit, found, [LENGTHS] * 3 + [ANGLES] * 3)
        xyz, rpy = (sequence(found[at : at + 3], found.value_spans[at : at + 3]) for at in (0, 3))
        return WrittenPose(Pose((x, y, z), (a, b, c)).transform(), xyz, rpy, element)

    def rest(self, element: Element, read: Collection[str], attributes: Collection[str] = ()) -> list[Element]:
        """Return the child elements with tags not in ``read``; report misspelled tags and unknown attributes."""
        if not {child.tag for child in element.children}.difference(read):
            self.check_attributes(element, attributes)
            return []
        known = {*read, *sdf_elements().get(element.tag, ())}
        tags = [child.tag for child in element.children if child.tag in known or correction(child.tag, known) is None]
        self.check(element, {*known, *tags}, attributes, None)
        found = [child for child in element.children if child.tag in tags and child.tag not in read]
        return [child for child in found if not child.tag.startswith("xacro:")]

    def _folders(self, *variables: str) -> Iterator[str]:
        for variable in variables:
            yield from filter(None, self.environment.get(variable, "").split(os.pathsep))

    def open_included(self, file: Path, asked: Span) -> Document | None:
        """Parse an included file; return None after an error, or if too many files or elements are included."""
        if self._is_too_much:
            return None
        try:
            document = markup.parse(markup.read_source(file, asked))
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
        """Return (file that a URI refers to, "", ""), or (None, reason or "" if the file does not exist, help).

        Because an SDF may be untrusted, only files in its folder, in packages and models found by name, and in folders
        that the user specifies (``--package``, environment) can be included.
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

    def top(self, root: Element, file: Path) -> Scope | None:
        """Return the only model of a document, or report an error and return None."""
        version, models = self._version(root), [child for child in root.children if child.tag == MODEL]
        if len(models) != 1:
            other = next((child for child in root.children if child.tag in ("world", "actor", "light")), root)
            names = f": {quote([one.get('name') for one in models], 3)}" if models else ""
            message = f"<sdf> holds {count_of(len(models), 'model')}{names}; a description is of one robot"
            help = "put the <model> of the robot into a file of its own, in <sdf>"
            self.error("sdf-models", message, (models[1] if models else other).span, help)
            return None
        self.check(root, (MODEL,), ("version",), None)
        return self._fill(Scope(models[0], file, version, None, self._name(models[0]))) if version else None

    def _version(self, root: Element) -> tuple[int, ...] | None:
        attribute, version, newest = root.attribute("version"), root.get("version").strip(), _VERSIONS[-1]
        self.need(root, "version")
        if attribute is not None and version not in _VERSIONS:
            message, help = f'SDF of version "{version}" is not read', f"versions {_VERSIONS[0]} to {newest} are"
            if self.lenient("sdf-version", message, attribute.span, help, f"reads it as {newest}"):
                version = newest
        return tuple(map(int, version.split("."))) if version in _VERSIONS else None

    def _name(self, element: Element) -> str:
        name, span = element.get("name"), name_span(element)
        if name != WORLD and not RESERVED.match(name) and NAME.match(name):
            return name
        if not name.strip():
            self.error("missing-attribute", f"a <{element.tag}> has no name", span, 'add name="..."')
            return ""
        why = "SDF keeps that name for itself" if NAME.match(name) else "it has a space at an end, or one of < > & \" '"
        self.error("bad-name", f'no {element.tag} can be called "{name}": {why}', span, "rename it")
        return ""

    def _fill(self, scope: Scope) -> Scope:
        outside = self.text(scope.including, "placement_frame") if scope.including is not None else None
        if (placement := outside or scope.element.attribute("placement_frame")) is not None and placement.value:
            message = f"placement_frame of {name_of(scope.element)} is not read: a model is placed by its own frame"
            self.error("sdf-include", message, placement.span, "remove it, and adapt the <pose> of the model")
        for child in scope.element.children:
            if child.tag in (LINK, FRAME, JOINT):
                self._add(scope, child.tag, self._name(child), child, child)
            elif child.tag == MODEL and (name := self._name(child)):
                self._add_model(scope, Scope(child, scope.file, scope.version, scope, name))
            elif child.tag == "include":
                self._include(scope, child)
        return scope

    def _add_model(self, outer: Scope, inner: Scope) -> None:
        by = inner.including
        if inner.depth > _DEEPEST:
            message = f"models are nested {_DEEPEST} levels deep"
            self.error("sdf-include", message, (by or inner.element).span, "do they include each other?")
            return
        self._fill(inner)
        posed = by if by is not None and any(child.tag == "pose" for child in by.children) else inner.element
        inner.node = self._add(outer, MODEL, inner.name, inner.element, posed)
        if inner.node is not None:
            inner.node.inner = inner

    def _add(self, scope: Scope, kind: str, name: str, element: Element, posed: Element) -> Node | None:
        if (first := scope.nodes.get(name)) is not None:
            message = f'the {kind} "{name}" has the name of another {first.kind}'
            related = [Related("first defined here", first.element.span)]
            self.error("duplicate-name", message, name_span(element), "rename or remove one of them", related)
        if first is not None or not name:
            return None
        return scope.nodes.setdefault(name, Node(kind, name, element, scope, self.pose(self.single(posed, "pose"))))

    def _include(self, scope: Scope, element: Element) -> None:
        if (uri := self.text(element, "uri")) is None:
            self.error("missing-element", f"{name_of(element)} has no <uri>", element.span, "add <uri>")
            return
        file, outside, help = self.find_file(str(uri.value), scope.file)
        if outside:
            self.error("include-outside", outside, uri.span, help)
        elif file is None:
            message = f'"{uri.value}" is not found'
            if self.lenient("sdf-include", message, uri.span, help, "leaves the model out"):
                self.cannot_carry(f"the included model {uri.value}", element.span)
        document = None if file is None else self.open_included(file, uri.span)
        if document is None or file is None:
            return
        model = next((child for child in document.root.children if child.tag == MODEL), None)
        if document.root.tag != "sdf" or model is None:
            message = f"{file.name} holds no model of SDF: its root is <{document.root.tag}>"
            self.error("sdf-include", message, uri.span, "include the SDF of a model")
            return
        version, renamed = self._version(document.root), self.text(element, "name")
        name = str(renamed.value) if renamed is not None else self._name(model)
        if version is not None and name:
            self._add_model(scope, Scope(model, file, version, scope, name, element))

    def require(self, scope: Scope, name: str, span: Span, what: str, of: Element | None = None) -> Node | None:
        """Resolve a name, or report that ``what`` of an element refers to an unknown name and return None."""
        node = self.canonical(scope) if name == OWN else scope.find(name)
        if node is None:
            help = Suggestion(name, [*scope.nodes], none="the model has nothing with a name")
            what += f" of {name_of(of)}" if of is not None else ""
            self.error("sdf-name-unknown", f'{what} is "{name}", which is not there', span, help)
        return node

    def base(self, node: Node) -> tuple[str, Span]:
        """Return (name of the frame that the pose of a node is relative to, source position of that name)."""
        if (attribute := relative_to(node.written.element)) is None and node.kind == FRAME:
            attribute = node.element.attribute("attached_to")
        if attribute is not None and attribute.value:
            return attribute.value, attribute.span
        return (OWN, node.element.span) if node.child is None else (node.child.text, node.child.span)

    def model_pose(self, scope: Scope, visited: tuple[Node, ...] = ()) -> Transform:
        return Transform() if scope.node is None else self.node_pose(scope.node, visited)

    def node_pose(self, node: Node, visited: tuple[Node, ...] = ()) -> Transform:
        if node in visited and node not in self._poses:
            path = " -> ".join(one.name for one in (*visited[visited.index(node) :], node))
            message = f"the pose of {name_of(node.element)} is relative to itself: {path}"
            self.error("sdf-name-unknown", message, self.base(node)[1], "let one be relative to __model__")
            self._poses[node] = Transform()
        if node not in self._poses:
            self._poses.setdefault(node, self.base_pose(node, (*visited, node)).then(node.written.transform))
        return self._poses[node]

    def base_pose(self, node: Node, visited: tuple[Node, ...] = ()) -> Transform:
        """Return the pose, in the outermost model, of the frame ``base(node)``."""
        name, span = self.base(node)
        if name in (OWN, ""):
            return self.model_pose(node.scope, visited or (node,))
        found = self.require(node.scope, name.removesuffix(f"::{OWN}"), span, "relative_to", node.element)
        return Transform() if found is None else self.node_pose(found, visited or (node,))

    def link_of(self, node: Node, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link that a link, frame, joint or model moves with, or None after an error."""
        if node.kind == LINK:
            return node
        if node in visited or len(visited) > 1000:
            message = f"{name_of(node.element)} is attached to itself"
            self.error("sdf-name-unknown", message, node.element.span, "attach it to a link")
            return None
        visited, attribute = (*visited, node), node.element.attribute("attached_to")
        if node.inner is not None:
            return self.canonical(node.inner, visited)
        if node.kind == JOINT:
            found = None if node.child is None else node.scope.find(node.child.text)
        elif attribute is None or attribute.value in ("", OWN):
            return self.canonical(node.scope, visited)
        else:
            found = self.require(node.scope, attribute.value, attribute.span, "attached_to", node.element)
        return None if found is None else self.link_of(found, visited)

    def canonical(self, scope: Scope, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link named by ``canonical_link`` of a model, or its first link, or None if it has no link."""
        if (attribute := scope.element.attribute("canonical_link")) is not None and attribute.value:
            found = self.require(scope, attribute.value, attribute.span, "canonical_link", scope.element)
            return None if found is None else self.link_of(found, visited)
        links = (node for node in scope.nodes.values() if node.kind == LINK)
        inner = (self.canonical(node.inner, visited) for node in scope.nodes.values() if node.inner is not None)
        return next(links, None) or next(filter(None, inner), None)

    def text_of(self, element: Element, scope: Scope, owner: Element | None = None) -> str:
        """Return an element as XML, with references to frames renamed as in the description.

        ``owner`` is a <pose> whose relative_to is removed, because the caller attaches the element to that frame.
        """
        made = element.verbatim
        if owner is not None and not owner.content:
            made = made[: owner.start - element.start].rstrip() + made[owner.end - element.start :]
            return kept_text(element, made)
        named_frames = [(inner, attribute) for inner in element.iter() for attribute in inner.attributes.values()]
        for inner, attribute in reversed(named_frames):
            if attribute.name not in ("relative_to", "frame", "attached_to", "expressed_in"):
                continue
            start, at = attribute.name_start - element.start, attribute.start - element.start
            before, after = made[:start], made[at + len(attribute.raw) :]
            if inner is owner:
                made = before.rstrip() + after[1:]
                continue
            node, name = scope.find(attribute.value), attribute.name
            called = node.called if node is not None and node.called else attribute.raw
            word = "relative_to" if name == "frame" and inner.tag == "pose" else name
            made = f"{before}{word}{made[start + len(name) : at]}{called}{after}"
        return kept_text(element, made)


def _with_unit(value: float, unit: str) -> float:
    dimension, far = UNITS[unit]
    return Quantity(value, dimension, f"{value} {unit}") if abs(value) > far else value


def _model_in(folder: Path) -> Path | None:
    """Return the newest SDF file that model.config lists, else model.sdf, or None if there is neither."""
    listed: list[Element] = []
    if is_file(config := folder / "model.config"):
        with suppress(MarkupError):
            listed = [child for child in markup.parse(markup.read_source(config)).root.children if child.tag == "sdf"]
    listed.sort(key=lambda sdf: [int(digits) for digits in re.findall(r"\d+", sdf.get("version"))], reverse=True)
    files = [*(folder / one.text for one in listed), folder / "model.sdf"]
    return next((file for file in files if is_file(file)), None)

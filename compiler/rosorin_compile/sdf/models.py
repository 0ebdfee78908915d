"""Models of an SDF: nested and included models, the meaning of the names in them, and the poses of their contents.

A model is a scope: its links, frames, joints and models share their names; ``other::name`` leads into a nested model.
A pose is relative to another of these, in the end to the frame of the outermost model (``__model__``).
Source: http://sdformat.org/tutorials?tut=pose_frame_semantics.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rosorin_compile.formats.xml_reader import NAME
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Related, Span, Suggestion, count_of, quote
from rosorin_compile.source.xml.elements import kept_text
from rosorin_compile.source.xml.markup import Attribute, Element, name_of

from .content import RESERVED, WORLD
from .values import SdfValues, WrittenPose, is_true, name_span

LINK, FRAME, JOINT, MODEL = "link", "frame", "joint", "model"
OWN = "__model__"
_NAMING = ("relative_to", "frame", "attached_to", "expressed_in")
_VERSIONS = [f"1.{minor}" for minor in range(4, 13)]
_DEEPEST = 20  # nested models: more is a circle of includes


@dataclass(eq=False)
class Node:
    """A link, a frame, a joint or a model."""

    kind: str
    name: str
    element: Element
    scope: Scope
    written: WrittenPose  # its pose as written
    called: str = ""  # its name in the description
    inner: Scope | None = None  # the scope of a model

    @property
    def child(self) -> Element | None:
        return next((one for one in self.element.children if one.tag == "child"), None) if self.kind == JOINT else None


@dataclass(eq=False)
class Scope:
    """A model: its element, file and version, and what its names refer to; ``including`` is the <include> of it."""

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
        """The text before the names of its contents in the description."""
        if self.outer is None:
            return ""
        return self.outer.prefix if self.is_merged else f"{self.outer.prefix}{self.name}_"

    def all_nodes(self) -> Iterator[Node]:
        for node in self.nodes.values():
            yield node
            if node.inner is not None:
                yield from node.inner.all_nodes()

    def find(self, name: str) -> Node | None:
        """Return the node that a name refers to, or None."""
        if name in self.nodes:
            return self.nodes[name]
        first, colon, rest = name.partition("::")
        model = self.nodes.get(first) if colon else None
        if model is not None and model.inner is not None:
            return model.inner.find(rest)
        merged = (node.inner for node in self.nodes.values() if node.inner is not None and node.inner.is_merged)
        return next((node for scope in merged if (node := scope.find(name)) is not None), None)


def relative_to(pose: Element | None) -> Attribute | None:
    """Return the attribute of a <pose> that names another frame."""
    found = None if pose is None else pose.attributes.get("relative_to") or pose.attributes.get("frame")
    return found if found is not None and found.value else None


class SdfReader(SdfValues):
    """One reading of an SDF: its models, and the place of everything in them."""

    _poses: dict[Node, Transform]

    def top(self, root: Element, file: Path) -> Scope | None:
        """Return the only model of a document, or None after an error."""
        self._poses = {}
        version = self._version(root)
        models = [child for child in root.children if child.tag == MODEL]
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
        attribute = root.attributes.get("version")
        version = "" if attribute is None else attribute.value.strip()
        self.need(root, "version")
        if attribute is not None and version not in _VERSIONS:
            message, help = f'SDF of version "{version}" is not read', f"versions {_VERSIONS[0]} to {_VERSIONS[-1]} are"
            if self.lenient("sdf-version", message, attribute.span, help, f"takes it for {_VERSIONS[-1]}"):
                version = _VERSIONS[-1]
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
        placement = outside or scope.element.attributes.get("placement_frame")
        if placement is not None and placement.value:
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
        first = scope.nodes.get(name)
        if first is not None:
            message = f'the {kind} "{name}" has the name of another {first.kind}'
            related = [Related("first defined here", first.element.span)]
            self.error("duplicate-name", message, name_span(element), "rename or remove one", related)
        elif name:
            scope.nodes[name] = Node(kind, name, element, scope, self.pose(self.single(posed, "pose")))
            return scope.nodes[name]
        return None

    def _include(self, scope: Scope, element: Element) -> None:
        uri = self.text(element, "uri")
        if uri is None:
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
        root = document.root
        model = next((child for child in root.children if child.tag == MODEL), None)
        if root.tag != "sdf" or model is None:
            message = f"{file.name} holds no model of SDF: its root is <{root.tag}>"
            self.error("sdf-include", message, uri.span, "include the SDF of a model")
            return
        version, renamed = self._version(root), self.text(element, "name")
        name = str(renamed.value) if renamed is not None else self._name(model)
        if version is not None and name:
            self._add_model(scope, Scope(model, file, version, scope, name, element))

    # Names and places

    def require(self, scope: Scope, name: str, span: Span, what: str) -> Node | None:
        """Return the node that a name refers to, or None after an error."""
        node = self.canonical(scope) if name == OWN else scope.find(name)
        if node is None:
            help = Suggestion(name, [*scope.nodes], none="the model has nothing with a name")
            self.error("sdf-name-unknown", f'{what} is "{name}", which is not there', span, help)
        return node

    def base(self, node: Node) -> tuple[str, Span]:
        """Return the name of the frame that a pose is relative to, and the place of that name."""
        attribute = relative_to(node.written.element)
        if attribute is None and node.kind == FRAME:
            attribute = node.element.attributes.get("attached_to")
        if attribute is not None and attribute.value:
            return attribute.value, attribute.span
        return (OWN, node.element.span) if node.child is None else (node.child.text, node.child.span)

    def model_pose(self, scope: Scope, visited: tuple[Node, ...] = ()) -> Transform:
        return Transform() if scope.node is None else self.node_pose(scope.node, visited)

    def node_pose(self, node: Node, visited: tuple[Node, ...] = ()) -> Transform:
        if node in self._poses:
            return self._poses[node]
        made = Transform()
        if node in visited:
            path = " -> ".join(one.name for one in (*visited[visited.index(node) :], node))
            message = f"the pose of {name_of(node.element)} is relative to itself: {path}"
            self.error("sdf-name-unknown", message, self.base(node)[1], "let one be relative to __model__")
        else:
            made = self.base_pose(node, (*visited, node)).then(node.written.transform)
        return self._poses.setdefault(node, made)

    def base_pose(self, node: Node, visited: tuple[Node, ...] = ()) -> Transform:
        """Return the pose in the outermost model of the frame that a node is relative to."""
        name, span = self.base(node)
        if name in (OWN, ""):
            return self.model_pose(node.scope, visited or (node,))
        what = f"relative_to of {name_of(node.element)}"
        found = self.require(node.scope, name.removesuffix(f"::{OWN}"), span, what)
        return Transform() if found is None else self.node_pose(found, visited or (node,))

    def link_of(self, node: Node, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link that a node moves with, or None after an error, or if there is none."""
        if node.kind == LINK:
            return node
        if node in visited or len(visited) > 1000:
            message = f"{name_of(node.element)} is attached to itself"
            self.error("sdf-name-unknown", message, node.element.span, "attach it to a link")
            return None
        visited = (*visited, node)
        if node.inner is not None:
            return self.canonical(node.inner, visited)
        if node.kind == JOINT:
            found = None if node.child is None else node.scope.find(node.child.text)
        else:
            attribute = node.element.attributes.get("attached_to")
            if attribute is None or attribute.value in ("", OWN):
                return self.canonical(node.scope, visited)
            what = f"attached_to of {name_of(node.element)}"
            found = self.require(node.scope, attribute.value, attribute.span, what)
        return None if found is None else self.link_of(found, visited)

    def canonical(self, scope: Scope, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link that represents a model: the one that it names, or the first."""
        attribute = scope.element.attributes.get("canonical_link")
        if attribute is not None and attribute.value:
            what = f"canonical_link of {name_of(scope.element)}"
            found = self.require(scope, attribute.value, attribute.span, what)
            return None if found is None else self.link_of(found, visited)
        links = (node for node in scope.nodes.values() if node.kind == LINK)
        inner = (self.canonical(node.inner, visited) for node in scope.nodes.values() if node.inner is not None)
        return next(links, None) or next((one for one in inner if one is not None), None)

    def text_of(self, element: Element, scope: Scope, owner: Element | None = None) -> str:
        """Return an element as it is, with the names that the description gives to the frames in it.

        ``owner`` is the <pose> of an element that becomes one of the frame that the pose is relative to.
        """
        made = element.verbatim
        if owner is not None and not owner.content:
            made = made[: owner.start - element.start].rstrip() + made[owner.end - element.start :]
            return kept_text(element, made)
        named_frames = [(inner, attribute) for inner in element.iter() for attribute in inner.attributes.values()]
        for inner, attribute in reversed(named_frames):
            if attribute.name not in _NAMING:
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

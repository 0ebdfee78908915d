"""Models of an SDF: those within a model, those that it includes, and what each name in them refers to.

A model is a scope: its links, frames, joints and models share their names; ``other::name`` leads into a model within.
A pose is relative to another of these, in the end to the frame of the outermost model (``__model__``).
Sources: http://sdformat.org/tutorials?tut=pose_frame_semantics; for what is older than 1.7 the converters of
libsdformat 12.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rosorin_compile.formats.urdf.reading import NAME
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Related, Span, Suggestion, counted, quoted
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.xml.elements import kept
from rosorin_compile.source.xml.markup import Attribute, Element, named

from .elements import RESERVED, WORLD
from .reading import SdfReading, WrittenPose, is_true

RULES = (
    Rule("sdf-version", "An SDF of a version that is not read.", "`gz sdf -p FILE` converts old files.", READING),
    Rule("sdf-models", "A file has no model, several, or a world.", "Name a file of one model.", READING),
    Rule("sdf-include", "An included file is not found.", "Say where it is: `--package NAME=FOLDER`.", READING),
    Rule("sdf-name-unknown", "A name refers to nothing, or to itself in a circle.", "Correct it.", READING),
)

LINK, FRAME, JOINT, MODEL = "link", "frame", "joint", "model"
OWN = "__model__"
_NAMING = ("relative_to", "frame", "attached_to", "expressed_in")
_VERSIONS = [f"1.{minor}" for minor in range(4, 13)]
_DEEPEST = 20  # models within models: more is a circle of includes


@dataclass(eq=False)
class Node:
    """A link, a frame, a joint or a model: its element, the scope that it is in, its pose as written.

    ``called`` is its name in the description, ``inner`` the scope of a model.
    """

    kind: str
    name: str
    element: Element
    scope: Scope
    written: WrittenPose
    called: str = ""
    inner: Scope | None = None

    @property
    def child(self) -> Element | None:
        """The <child> of a joint."""
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
    merged: list[Scope] = field(default_factory=list)
    is_merged: bool = False

    @property
    def prefix(self) -> str:
        """The text before the names of its contents in the description."""
        if self.outer is None:
            return ""
        return self.outer.prefix if self.is_merged else f"{self.outer.prefix}{self.name}_"

    def all_nodes(self) -> Iterator[Node]:
        """Yield its nodes and those of the models within, in the order of the file."""
        for node in self.nodes.values():
            yield node
            if node.inner is not None:
                yield from node.inner.all_nodes()


def relative_to(pose: Element | None) -> Attribute | None:
    """Return the attribute of a <pose> that names another frame."""
    found = None if pose is None else pose.attributes.get("relative_to") or pose.attributes.get("frame")
    return found if found is not None and found.value else None


class Models:
    """The models of a file, and the places of everything in them."""

    def __init__(self, reading: SdfReading) -> None:
        self.reading = reading
        self._poses: dict[int, Transform] = {}

    def top(self, root: Element, file: Path) -> Scope | None:
        """Return the only model of a document, or leniently the only one of a world; None after an error."""
        reading, version = self.reading, self._version(root)
        if version is None:
            return None
        found = [child for child in root.children if child.tag in (MODEL, "world", "actor", "light")]
        models = [child for child in found if child.tag == MODEL]
        if len(models) == 1:
            reading.check(root, (MODEL,), ("version",), None)
            return self._fill(Scope(models[0], file, version, None, self._name(models[0])))
        holder = root if models or not found else found[0]
        models = models or [child for child in holder.children if child.tag == MODEL]
        span = models[1].span if len(models) > 1 and holder is root else holder.span
        names = ": " + quoted([one.get("name") for one in models], 3) if models else ""
        message = f"<{holder.tag}> holds {counted(len(models), 'model')}{names}; a description is of one robot"
        help = "put the <model> of the robot into a file of its own, in <sdf>"
        if len(models) != 1:
            reading.error("sdf-models", message, span, help)
        elif reading.lenient("sdf-models", message, span, help, "takes the model alone"):
            reading.cannot_carry("the world around the model", span)
            return self._fill(Scope(models[0], file, version, None, self._name(models[0])))
        return None

    def _version(self, root: Element) -> tuple[int, ...] | None:
        attribute, help = root.attributes.get("version"), f"versions {_VERSIONS[0]} to {_VERSIONS[-1]} are"
        version = None if attribute is None else attribute.value.strip()
        if attribute is None:
            message, version = '<sdf> lacks the attribute "version"', "1.9"
            if not self.reading.lenient("missing-attribute", message, root.span, help, "takes it for 1.9"):
                return None
        elif version not in _VERSIONS:
            message, version = f'SDF of version "{version}" is not read', _VERSIONS[-1]
            if not self.reading.lenient("sdf-version", message, attribute.span, help, f"takes it for {version}"):
                return None
        return tuple(map(int, version.split(".")))

    def _name(self, element: Element) -> str:
        """Return the name of an element, empty after an error."""
        attribute, name = element.attributes.get("name"), element.get("name")
        span = element.span if attribute is None else attribute.span
        if name != WORLD and not RESERVED.match(name) and NAME.match(name):
            return name
        if not name.strip():
            self.reading.error("missing-attribute", f"a <{element.tag}> has no name", span, 'add name="..."')
            return ""
        why = "SDF keeps that name for itself" if NAME.match(name) else "it has a space at an end, or one of < > & \" '"
        self.reading.error("bad-name", f'no {element.tag} can be called "{name}": {why}', span, "rename it")
        return ""

    def _fill(self, scope: Scope) -> Scope:
        """Fill a scope with the contents of its model."""
        for child in scope.element.children:
            if child.tag in (LINK, FRAME, JOINT):
                self._add(scope, child.tag, self._name(child), child, child)
            elif child.tag == MODEL and (name := self._name(child)):
                self._add_model(scope, Scope(child, scope.file, scope.version, scope, name))
            elif child.tag == "include":
                self._include(scope, child)
        return scope

    def _add_model(self, outer: Scope, inner: Scope) -> None:
        """Add a model within a model."""
        depth, above, by = 0, outer, inner.including
        while above.outer is not None:
            depth, above = depth + 1, above.outer
        if depth >= _DEEPEST:
            message = f"models are nested {_DEEPEST} levels deep"
            self.reading.error("sdf-include", message, (by or inner.element).span, "do they include each other?")
            return
        self._fill(inner)
        posed = by if by is not None and any(child.tag == "pose" for child in by.children) else inner.element
        node = self._add(outer, MODEL, inner.name, inner.element, posed)
        if node is None:
            return
        node.inner, inner.node = inner, node
        inner.is_merged = by is not None and is_true(by.get("merge"))
        if inner.is_merged:
            outer.merged.append(inner)

    def _add(self, scope: Scope, kind: str, name: str, element: Element, posed: Element) -> Node | None:
        """Add a named element, unless the scope has the name; before 1.7, a node of another kind may have it."""
        if not name:
            return None
        node = Node(kind, name, element, scope, self.reading.pose(self.reading.single(posed, "pose")))
        first = scope.nodes.get(name)
        if first is not None and first.kind != kind and scope.version < (1, 7):
            name = f"{name} ({kind})"
        elif first is not None:
            span = element.attributes["name"].span if "name" in element.attributes else element.span
            message = f'the {kind} "{name}" has the name of another {first.kind}'
            related = [Related("first defined here", first.element.span)]
            self.reading.error("duplicate-name", message, span, "rename or remove one", related)
            return None
        scope.nodes[name] = node
        return node

    def _include(self, scope: Scope, element: Element) -> None:
        """Add the model of another file."""
        reading, uri = self.reading, self.reading.text(element, "uri")
        if uri is None:
            reading.error("missing-element", f"{named(element)} has no <uri>", element.span, "add <uri>")
            return
        file, outside, help = reading.find_file(str(uri.value), scope.file)
        if file is None:
            what = f'"{uri.value}" is not found'
            if outside:
                reading.error("include-outside", outside, uri.span, help)
            elif reading.lenient("sdf-include", what, uri.span, help, "leaves the model out"):
                reading.cannot_carry(f"the included model {uri.value}", element.span)
            return
        document = reading.included(file, uri.span)
        if document is None:
            return
        root = document.root
        model = next((child for child in root.children if child.tag == MODEL), None)
        if root.tag != "sdf" or model is None:
            message = f"{file.name} holds no model of SDF: its root is <{root.tag}>"
            reading.error("sdf-include", message, uri.span, "include the SDF of a model")
            return
        version, renamed = self._version(root), reading.text(element, "name")
        name = str(renamed.value) if renamed is not None else self._name(model)
        if version is not None and name:
            self._add_model(scope, Scope(model, file, version, scope, name, element))

    # Names and places

    def find(self, scope: Scope, name: str) -> Node | None:
        """Return the node that a name refers to in a scope, or None.

        Where a joint and another node have the same name, as in old files, that is the other node.
        """
        for one in (scope, *scope.merged):
            keys = (name, *(f"{name} ({kind})" for kind in (LINK, FRAME, JOINT)))
            nodes = [one.nodes[key] for key in keys if key in one.nodes]
            if nodes:
                return next((node for node in nodes if node.kind != JOINT), nodes[0])
            first, colon, rest = name.partition("::")
            inner = one.nodes.get(first) if colon else None
            if inner is not None and inner.inner is not None:
                return self.find(inner.inner, rest)
        return None

    def require(self, scope: Scope, name: str, span: Span, what: str) -> Node | None:
        """Return the node that a name refers to, or None after an error."""
        node = self.canonical(scope) if name == OWN else self.find(scope, name)
        if node is None:
            help = Suggestion(name, [*scope.nodes], none="the model has nothing with a name")
            self.reading.error("sdf-name-unknown", f'{what} is "{name}", which is not there', span, help)
        return node

    def base(self, node: Node) -> tuple[str, Span]:
        """Return the name of the frame that a pose is relative to, and the place of that name."""
        attribute = relative_to(node.written.element)
        if attribute is None and node.kind == FRAME:
            attribute = node.element.attributes.get("attached_to")
        if attribute is not None and attribute.value:
            return attribute.value, attribute.span
        return (OWN, node.element.span) if node.child is None else (node.child.text, node.child.span)

    def pose(self, node: Node | None, scope: Scope, visited: tuple[Node, ...] = ()) -> Transform:
        """Return the pose of a node in the outermost model; None is the frame of ``scope``."""
        if node is None:
            return Transform() if scope.node is None else self.pose(scope.node, scope, visited)
        if id(node) in self._poses:
            return self._poses[id(node)]
        if node in visited:
            way = " -> ".join(one.name for one in (*visited[visited.index(node) :], node))
            message = f"the pose of {named(node.element)} is relative to itself: {way}"
            self.reading.error("sdf-name-unknown", message, self.base(node)[1], "let one be relative to __model__")
            return self._poses.setdefault(id(node), Transform())
        made = self.base_pose(node, (*visited, node)).then(node.written.transform)
        if node.kind == MODEL and node.inner is not None:
            made = made.then(self.placement(node.inner).inverse())
        return self._poses.setdefault(id(node), made)

    def base_pose(self, node: Node, visited: tuple[Node, ...] = ()) -> Transform:
        """Return the pose in the outermost model of the frame that a node is relative to."""
        name, span = self.base(node)
        if name in (OWN, ""):
            return self.pose(None, node.scope, visited or (node,))
        what = f"relative_to of {named(node.element)}"
        found = self.require(node.scope, name.removesuffix(f"::{OWN}"), span, what)
        return Transform() if found is None else self.pose(found, found.scope, visited or (node,))

    def placement(self, inner: Scope) -> Transform:
        """Return the pose in a model of the frame that it is placed by."""
        attribute = inner.element.attributes.get("placement_frame")
        name, span = ("", inner.element.span) if attribute is None else (attribute.value, attribute.span)
        for child in inner.including.children if inner.including is not None else ():
            name, span = (child.text, child.span) if child.tag == "placement_frame" else (name, span)
        made, what = Transform(), f"placement_frame of {named(inner.element)}"
        for _ in range(len(inner.nodes)):  # poses in a circle are reported by ``pose``
            if name in (OWN, ""):
                break
            node = self.require(inner, name, span, what)
            if node is None:
                break
            made, what = node.written.transform.then(made), f"relative_to of {named(node.element)}"
            name, span = self.base(node)
        return made

    def link_of(self, node: Node, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link that a node moves with, or None after an error, or if there is none."""
        if node.kind == LINK:
            return node
        if node in visited or len(visited) > 1000:
            message = f"{named(node.element)} is attached to itself"
            self.reading.error("sdf-name-unknown", message, node.element.span, "attach it to a link")
            return None
        visited = (*visited, node)
        if node.kind == MODEL and node.inner is not None:
            return self.canonical(node.inner, visited)
        if node.kind == JOINT:
            found = None if node.child is None else self.find(node.scope, node.child.text)
        else:
            attribute = node.element.attributes.get("attached_to")
            if attribute is None or attribute.value in ("", OWN):
                return self.canonical(node.scope, visited)
            what = f"attached_to of {named(node.element)}"
            found = self.require(node.scope, attribute.value, attribute.span, what)
        return None if found is None else self.link_of(found, visited)

    def canonical(self, scope: Scope, visited: tuple[Node, ...] = ()) -> Node | None:
        """Return the link that stands for a model: the one that it names, or the first."""
        attribute = scope.element.attributes.get("canonical_link")
        if attribute is not None and attribute.value:
            what = f"canonical_link of {named(scope.element)}"
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
            return kept(element, made)
        for inner in reversed(list(element.iter())):
            for name in reversed(_NAMING):
                attribute = inner.attributes.get(name)
                if attribute is None:
                    continue
                node = self.find(scope, attribute.value)
                at, where = attribute.start - element.start, attribute.name_start - element.start
                if inner is owner:
                    made = made[:where].rstrip() + made[at + len(attribute.raw) + 1 :]
                    continue
                if node is not None and node.called:
                    made = f"{made[:at]}{node.called}{made[at + len(attribute.raw) :]}"
                if name == "frame" and inner.tag == "pose":
                    made = f"{made[:where]}relative_to{made[where + len(name) :]}"
        return kept(element, made)

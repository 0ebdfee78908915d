"""Scopes: the models of an SDF, those within it and those that it includes, and what each name in them stands for.

A model is a scope: its links, frames, joints and models share their names; ``other::name`` leads into a model within.
A pose is relative to another of these, in the end to the frame of the outermost model (``__model__``).
Sources: http://sdformat.org/tutorials?tut=pose_frame_semantics; for what is older than 1.7 the converters of
libsdformat 12.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.urdf.reading import NAME, Reading, named
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Related, Span, counted, did_you_mean, quoted
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element

from .included import Included
from .reading import Numbers, Said
from .words import RESERVED, WORLD

RULES = (
    Rule(
        "sdf-version",
        "An SDF of a version that is not read.",
        "1.4 to 1.12 are; `gz sdf -p FILE` converts older ones.",
        Heading.READING,
    ),
    Rule(
        "sdf-models",
        "A file holds no model, or more than one, or a world.",
        "Name a file of one model.",
        Heading.READING,
    ),
    Rule(
        "sdf-include",
        "What an SDF includes is not found, or is not read.",
        "Put the model beside the file, or say where it is: `--package NAME=FOLDER`.",
        Heading.READING,
    ),
    Rule(
        "sdf-name-unknown",
        "A name of an SDF stands for nothing, or for itself in a circle.",
        "Correct it.",
        Heading.READING,
    ),
)

LINK, FRAME, JOINT, MODEL = "link", "frame", "joint", "model"
OWN = "__model__"
_VERSIONS = [f"1.{minor}" for minor in range(4, 13)]
_DEEPEST = 20  # models within models: more is a circle of includes


class Node:
    """A link, a frame, a joint or a model: its element, the scope that it stands in, and what its pose says."""

    def __init__(self, kind: str, name: str, element: Element, scope: Scope, said: Said) -> None:
        self.kind = kind
        self.name = name
        self.element = element
        self.scope = scope
        self.said = said
        self.called = ""  # in the description
        self.inner: Scope | None = None  # of a model


class Scope:
    """A model: its element, the file that it stands in, its version, and what its names stand for.

    ``name_span`` is where its name was written.
    """

    def __init__(self, element: Element, file: Path, version: str, outer: Scope | None, name: str) -> None:
        self.element = element
        self.file = file
        self.version = tuple(map(int, version.split(".")))
        self.outer = outer
        self.name = name
        self.nodes: dict[str, Node] = {}
        self.node: Node | None = None
        self.merged: list[Scope] = []
        self.is_merged = False
        self.overriding: Element | None = None  # the <include> that brings it

    @property
    def prefix(self) -> str:
        """What stands before the names of what is in it."""
        if self.outer is None:
            return ""
        return self.outer.prefix if self.is_merged else f"{self.outer.prefix}{self.name}_"

    def own(self, name: str) -> Node | None:
        """Return what has a name in it; where a joint and another have the same, as in old files, the other."""
        same = (self.nodes.get(key) for key in (name, *(f"{name} ({kind})" for kind in (LINK, FRAME, JOINT))))
        found = [node for node in same if node is not None]
        return next((node for node in found if node.kind != JOINT), found[0] if found else None)

    def all_nodes(self) -> Iterator[Node]:
        """Yield what stands in it and in the models within, in the order of the file."""
        for node in self.nodes.values():
            yield node
            if node.inner is not None:
                yield from node.inner.all_nodes()

    def word(self, name: str) -> tuple[str, Span]:
        """Return a setting of the model and its place: an attribute, or a child of the <include> that wins over it."""
        for child in self.overriding.children if self.overriding is not None else ():
            if child.tag == name:
                return child.text, child.span
        attribute = self.element.attributes.get(name)
        return ("", self.element.span) if attribute is None else (attribute.value, attribute.span)


class Models:
    """Finds the models of a file, and where everything in them sits."""

    def __init__(self, reading: Reading, file: Path) -> None:
        self.reading = reading
        self.numbers = Numbers(reading)
        self.included = Included(reading, file)
        self._poses: dict[int, Transform] = {}

    def top(self, root: Element, file: Path) -> Scope | None:
        """Return the one model of a document; None after an error."""
        version = self._version(root)
        models = [child for child in root.children if child.tag == MODEL]
        if version is None:
            return None
        if not models:
            alone = self._no_model(root)
            return None if alone is None else self._scope(alone, file, version, None, self._name(alone))
        if len(models) > 1:
            message = f"the file holds {len(models)} models; a description is of one robot"
            related = [Related("the first", models[0].span)]
            self.reading.error("sdf-models", message, models[1].span, "give each a file of its own", related)
            return None
        self.reading.check(root, (MODEL,), ("version",), None)
        return self._scope(models[0], file, version, None, self._name(models[0]))

    def _no_model(self, root: Element) -> Element | None:
        """Say that a file has no model, and what it has; leniently return the one model of a world."""
        other = next((child for child in root.children if child.tag in ("world", "actor", "light")), None)
        if other is None:
            self.reading.error("sdf-models", "<sdf> holds no <model>", root.span, 'add <model name="...">')
            return None
        message = f"the file holds <{other.tag}>, not a model"
        models = [child for child in other.children if child.tag == MODEL]
        if models:
            names = quoted([one.get("name") for one in models], 3)
            message = f"the file holds a world, with {counted(len(models), 'model')}: {names}"
        help = "put the <model> of the robot into a file of its own, in <sdf>"
        if len(models) != 1:
            self.reading.error("sdf-models", message, other.span, help)
        elif self.reading.lenient("sdf-models", message, other.span, help, "takes the model alone"):
            self.reading.cannot_carry("the world around the model", other.span)
            return models[0]
        return None

    def _version(self, root: Element) -> str | None:
        attribute = root.attributes.get("version")
        if attribute is None:
            message, help = '<sdf> lacks the attribute "version"', 'add version="1.9"'
            taken = self.reading.lenient("missing-attribute", message, root.span, help, "takes it for 1.9")
            return "1.9" if taken else None
        version = attribute.value.strip()
        if version in _VERSIONS:
            return version
        message = f'SDF of version "{version}" is not read'
        help = f"versions {_VERSIONS[0]} to {_VERSIONS[-1]} are"
        taken = self.reading.lenient("sdf-version", message, attribute.span, help, f"takes it for {_VERSIONS[-1]}")
        return _VERSIONS[-1] if taken else None

    def _name(self, element: Element) -> str:
        """Return the name of an element; empty after an error."""
        attribute = element.attributes.get("name")
        if attribute is None or not attribute.value.strip():
            message = f"a <{element.tag}> has no name"
            self.reading.error("missing-attribute", message, (attribute or _At(element)).span, 'add name="..."')
            return ""
        if not NAME.match(attribute.value):
            message = f'the name of the {element.tag} "{attribute.value}" has a space at an end, or one of < > & " \''
            self.reading.error("bad-name", message, attribute.span, "rename it")
            return ""
        if attribute.value == WORLD or RESERVED.match(attribute.value):
            message = f'no {element.tag} can be called "{attribute.value}": SDF keeps that name for itself'
            self.reading.error("bad-name", message, attribute.span, "rename it")
            return ""
        return attribute.value

    def _scope(
        self, element: Element, file: Path, version: str, outer: Scope | None, name: str, by: Element | None = None
    ) -> Scope:
        """Return a model and all that is in it."""
        scope = Scope(element, file, version, outer, name)
        scope.overriding = by
        for child in element.children:
            if child.tag in (LINK, FRAME, JOINT):
                self._add(scope, child.tag, self._name(child), child, child)
            elif child.tag == MODEL:
                self._within(scope, child, scope.file, version, self._name(child))
            elif child.tag == "include":
                self._include(scope, child)
        return scope

    def _within(
        self, scope: Scope, element: Element, file: Path, version: str, name: str, by: Element | None = None
    ) -> None:
        """Add a model within a model; ``by`` is the <include> that brings it."""
        if not name:
            return
        depth, above = 0, scope
        while above.outer is not None:
            depth, above = depth + 1, above.outer
        if depth >= _DEEPEST:
            message = f"models are nested {_DEEPEST} levels deep"
            self.reading.error("sdf-include", message, (by or element).span, "do they include each other?")
            return
        inner = self._scope(element, file, version, scope, name, by)
        posed = by if by is not None and any(child.tag == "pose" for child in by.children) else element
        node = self._add(scope, MODEL, name, element, posed)
        if node is None:
            return
        node.inner, inner.node = inner, node
        inner.is_merged = by is not None and by.get("merge").lower() in ("1", "true")
        if inner.is_merged:
            scope.merged.append(inner)

    def _add(self, scope: Scope, kind: str, name: str, element: Element, posed: Element) -> Node | None:
        """Add what has a name; a second one of that name is an error, but in files older than 1.7 of another kind."""
        if not name:
            return None
        pose = self.reading.single(posed, "pose")
        node = Node(kind, name, element, scope, self.numbers.pose(pose))
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
        uri = self.numbers.text(element, "uri")
        if uri is None:
            self.reading.error("missing-element", f"{named(element)} has no <uri>", element.span, "add <uri>")
            return
        file, outside, help = self.included.find(str(uri.value), scope.file)
        if outside:
            self.reading.error("include-outside", outside, uri.span, help)
            return
        if file is None:
            what = f'"{uri.value}" is not found'
            if not self.reading.lenient("sdf-include", what, uri.span, help, "leaves the model out"):
                return
            self.reading.cannot_carry(f"the included model {uri.value}", element.span)
            return
        self._read(scope, element, file, uri.span)

    def _read(self, scope: Scope, include: Element, file: Path, asked: Span) -> None:
        document = self.included.document(file, asked)
        if document is None:
            return
        root = document.root
        model = next((child for child in root.children if child.tag == MODEL), None)
        if root.tag != "sdf" or model is None:
            message = f"{file.name} holds no model of SDF: its root is <{root.tag}>"
            self.reading.error("sdf-include", message, asked, "include the SDF of a model")
            return
        version = self._version(root)
        given = self.numbers.text(include, "name")
        name = str(given.value) if given is not None else self._name(model)
        if version is not None and name:
            self._within(scope, model, file, version, name, include)

    # What names stand for, and where things sit.

    def find(self, scope: Scope, name: str) -> Node | None:
        """Return what a name stands for in a scope; the frame of the scope itself is None, as is what is not there."""
        for one in (scope, *scope.merged):
            node = one.own(name)
            if node is not None:
                return node
            first, colon, rest = name.partition("::")
            inner = one.nodes.get(first) if colon else None
            if inner is not None and inner.inner is not None:
                return self.find(inner.inner, rest)
        return None

    def asked(self, scope: Scope, name: str, span: Span, what: str) -> Node | None:
        """Return what a name stands for, which has to be there; None after an error."""
        node = self.canonical(scope) if name == OWN else self.find(scope, name)
        if node is None:
            message = f'{what} is "{name}", which is not there'
            help = did_you_mean(name, [*scope.nodes]) or "the model has nothing with a name"
            self.reading.error("sdf-name-unknown", message, span, help)
        return node

    def seen_from(self, node: Node) -> tuple[Scope, str, Span]:
        """Return the scope and the name of what a pose is relative to, and the place of that name."""
        outer = node.scope
        pose = node.said.element
        attribute = None if pose is None else pose.attributes.get("relative_to") or pose.attributes.get("frame")
        if attribute is not None and attribute.value:
            return outer, attribute.value, attribute.span
        if node.kind == FRAME and node.element.get("attached_to"):
            return outer, node.element.get("attached_to"), node.element.attributes["attached_to"].span
        if node.kind == JOINT:
            child = next((one for one in node.element.children if one.tag == "child"), None)
            return (outer, OWN, node.element.span) if child is None else (outer, child.text, child.span)
        return outer, OWN, node.element.span

    def pose(self, node: Node | None, scope: Scope, passed: tuple[Node, ...] = ()) -> Transform:
        """Return where something sits in the outermost model; None is the frame of ``scope``."""
        if node is None:
            return Transform() if scope.node is None else self.pose(scope.node, scope, passed)
        key = id(node)
        if key in self._poses:
            return self._poses[key]
        _, name, span = self.seen_from(node)
        if node in passed:
            message = f"the pose of {named(node.element)} is relative to itself"
            way = " -> ".join(one.name for one in (*passed[passed.index(node) :], node))
            self.reading.error("sdf-name-unknown", f"{message}: {way}", span, "let one be relative to __model__")
            return self._poses.setdefault(key, Transform())
        outer = self._of(node.scope, name, span, f"relative_to of {named(node.element)}", (*passed, node))
        made = outer.then(node.said.transform)
        if node.kind == MODEL and node.inner is not None:
            made = made.then(self.placement(node.inner).inverse())
        return self._poses.setdefault(key, made)

    def frame(self, scope: Scope, name: str, span: Span, node: Node) -> Transform:
        """Return where what something is seen from sits in the outermost model."""
        return self._of(scope, name, span, f"relative_to of {named(node.element)}", (node,))

    def _of(self, scope: Scope, name: str, span: Span, what: str, passed: tuple[Node, ...]) -> Transform:
        """Return where what a name stands for sits in the outermost model."""
        if name in (OWN, ""):
            return self.pose(None, scope, passed)
        node = self.asked(scope, name.removesuffix(f"::{OWN}"), span, what)
        return Transform() if node is None else self.pose(node, node.scope, passed)

    def placement(self, inner: Scope) -> Transform:
        """Return where the frame by which a model is placed sits in it."""
        name, asked = inner.word("placement_frame")
        node = self.asked(inner, name, asked, f"placement_frame of {named(inner.element)}") if name else None
        made = Transform()  # seen from the model itself, whose own place is not known yet
        for _ in range(len(inner.nodes)):  # poses in a circle are told where they are asked for
            if node is None:
                break
            made = node.said.transform.then(made)
            _, above, span = self.seen_from(node)
            if above in (OWN, ""):
                break
            node = self.asked(inner, above, span, f"relative_to of {named(node.element)}")
        return made

    def link_of(self, node: Node | None, scope: Scope, seen: tuple[int, ...] = ()) -> Node | None:
        """Return the link that something moves with; None after an error, or where there is none."""
        if node is None:
            return self.canonical(scope)
        if node.kind == LINK:
            return node
        if id(node) in seen or len(seen) > 1000:
            message = f"{named(node.element)} is attached to itself"
            self.reading.error("sdf-name-unknown", message, node.element.span, "attach it to a link")
            return None
        seen = (*seen, id(node))
        if node.kind == MODEL and node.inner is not None:
            return self.canonical(node.inner, seen)
        if node.kind == JOINT:
            child = next((one for one in node.element.children if one.tag == "child"), None)
            found = self.find(node.scope, child.text) if child is not None else None
            return self.link_of(found, node.scope, seen) if found is not None else None
        name = node.element.get("attached_to")
        if not name or name == OWN:
            return self.canonical(node.scope, seen)
        span = node.element.attributes["attached_to"].span
        found = self.asked(node.scope, name, span, f"attached_to of {named(node.element)}")
        return None if found is None else self.link_of(found, node.scope, seen)

    def canonical(self, scope: Scope, seen: tuple[int, ...] = ()) -> Node | None:
        """Return the link that stands for a model: the one that it names, or the first."""
        name = scope.element.get("canonical_link")
        if name:
            span = scope.element.attributes["canonical_link"].span
            found = self.asked(scope, name, span, f"canonical_link of {named(scope.element)}")
            return None if found is None else self.link_of(found, scope, seen)
        links = (node for node in scope.nodes.values() if node.kind == LINK)
        inner = (self.canonical(n.inner, seen) for n in scope.nodes.values() if n.inner is not None)
        return next(links, None) or next((one for one in inner if one is not None), None)


class _At(NamedTuple):
    """Stands for an attribute that is not there: its place is that of the element."""

    element: Element

    @property
    def span(self) -> Span:
        return self.element.span

"""Read an SDF into the tree of a description (http://sdformat.org/spec, versions 1.4 to 1.12).

What libsdformat refuses is refused, and so is what it accepts silently although it cannot be right: misspelt words, a
second element where one is taken. Models within a model and those of other files are resolved: their names get the name
of the model before them. What the language has no key for is kept as it is (``elements``).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.formats.format import Opened, Placed
from rosorin_compile.formats.imported import Imported, ReadOptions, as_tree, comments_of
from rosorin_compile.formats.reading import accept, lower_artifact
from rosorin_compile.formats.urdf.read import plain
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Source, Span, has_errors
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import masked
from rosorin_compile.source.xml.markup import Element, MarkupError, named, parse

from .bodies import Bodies, is_near
from .elements import OF_MODEL, WORLD, keep, wrapped
from .models import FRAME, LINK, Models, Node, Scope
from .read_joints import Joints
from .read_links import Entries, Links
from .reading import SdfReading, WrittenPose, is_true

_READ = ("link", "frame", "joint", "model", "include", "pose")
_IN_INCLUDE = ("uri", "name", "pose", "static", "placement_frame", "plugin")
_NAMING = ("relative_to", "frame", "attached_to", "expressed_in")
_NEWER = ("1.10", "1.11", "1.12")


def read_sdf(opened: Opened) -> Imported:
    """Return the robot of an SDF."""
    reading, document = SdfReading(opened.options, opened.path), opened.xml
    models = Models(reading)
    top = models.top(document.root, opened.path)
    sections = None if top is None else _Robot(models, top).read()
    diagnostics = reading.all_diagnostics()
    imported = Imported(None, diagnostics, (), tuple(reading.files))
    if sections is None or top is None or has_errors(diagnostics):
        return imported
    source = {"status": "imported", "note": f"from {masked(opened.path.name)}"}
    tree: Map | None = as_tree({"robot": sections.pop("robot"), "source": source, **sections}, document.root.span)
    problems: list[Diagnostic] = []
    if tree is not None and opened.options.checked:
        tree, problems = accept(tree, opened.options.lenient)
    if tree is None:
        return imported._replace(diagnostics=[*diagnostics, *problems])
    version = ".".join(map(str, top.version))
    output = {"file": "robot.sdf", **({"version": version} if version in _NEWER else {})}
    tree.put("outputs", as_tree({"sdf": output}, tree.span), tree.span, tree.span)
    for element in document.root.iter():  # comments in an element that has no entry belong to the entry around it
        above = reading.paths.get(id(element.parent))
        if above is not None and "urdf_elements" not in above:
            reading.paths.setdefault(id(element), () if above == ("robot",) else above)
    comments = comments_of(document, reading.paths)
    return imported._replace(tree=tree, diagnostics=[*diagnostics, *problems], comments=comments, version=version)


def read(text: str) -> Robot:
    """Return the robot that an SDF of ours contains. Raises ValueError if it is damaged."""
    try:
        document = parse(Source("the SDF", text))
        if document.root.tag != "sdf":
            raise ValueError(f"the root element is {document.root.tag}, not sdf")
        imported = read_sdf(Opened(Path("robot.sdf"), ReadOptions(checked=False), document))
    except MarkupError as problem:
        raise ValueError(problem.diagnostic.message) from None
    if imported.tree is None:
        raise ValueError(next(one.message for one in imported.diagnostics if one.severity == ERROR))
    return plain(lower_artifact(imported.whole, imported.diagnostics))


class _Robot:
    """Makes the sections of a description from a model."""

    def __init__(self, models: Models, top: Scope) -> None:
        self.models, self.top, self.reading = models, top, models.reading
        self.bodies = Bodies(models, top)
        self.entries = Entries({}, {}, {})
        self.holder: dict[str, Any] = {"urdf_elements": []}  # the elements of the robot
        self.constraints: dict[str, Placed] = {}

    def read(self) -> dict[str, Any] | None:
        """Return the sections of the description, or None after an error that hides all others."""
        top, reading = self.top, self.reading
        if not self.bodies.links and not has_errors(reading.diagnostics):
            help = "add <link>: readers of SDF refuse a model without"
            reading.error("no-links", f'the model "{top.name}" has no links', top.element.span, help)
        canonical = self.models.canonical(top)
        if canonical is None or has_errors(reading.diagnostics):
            return None
        self._name_nodes()
        roots = self.bodies.roots()
        world = self._world_link(roots)
        for node in self.bodies.members:
            self.entries.links[node.called] = {}
            reading.paths[id(node.element)] = ("links", node.called)
            if node.kind == FRAME:
                reading.check(node.element, ("pose",), ("name", "attached_to"), None)
        Links(self.bodies, self.entries).read()
        if roots and not world and self.bodies.body_of(roots[0]) is not canonical:
            message = f'the canonical link of the model is "{canonical.called}", that of the SDF of the robot where it'
            reading.note("import-converted", f"{message} begins", canonical.element.span)
        joints = Joints(self.bodies, self.entries)
        joints.read(world)
        for node in roots if world else ():
            joints.fix(node, world, self.bodies.local_pose(node, None), "fixed" if self._is_static() else "floating")
        spans = {node.called: _name_span(node.element) for node in self.bodies.members}
        links = {name: entry for name, entry in self.entries.links.items() if name != world}
        links = {world: {}, **links} if world else links
        made: dict[str, Any] = {"robot": Placed(top.name, _name_span(top.element))}
        made["links"] = {name: Placed(entry, spans.get(name, top.element.span)) for name, entry in links.items()}
        self._keep_elements(top)
        for name, found in self.entries.gazebo.items():
            self._put("gazebo", found, reference=name)
        optional = {"joints": self.entries.joints, "root": self._root(roots, world), "constraints": self.constraints}
        return made | {key: value for key, value in (optional | self.holder).items() if value}

    # Names and the world

    def _name_nodes(self) -> None:
        """Give each link, frame and joint a name that a description can have and no other has."""
        note = self.reading.note
        for nodes in (self.bodies.members, [joint.node for joint in self.bodies.joints]):
            taken: set[str] = set()
            for node in nodes:
                first = node.scope.prefix + node.name.removesuffix(f" ({node.kind})")
                node.called = first.replace("::", "_")
                while node.called in taken:
                    node.called += "_"
                taken.add(node.called)
                if node.called != first:
                    why = "no name leads into a model here" if "::" in first else "something else has its name"
                    message = f'the {node.kind} "{first}" is called "{node.called}": {why}'
                    note("import-changed", message, node.element.span)
        inner = [node.inner for node in self.top.nodes.values() if node.inner is not None and not node.inner.is_merged]
        for scope in inner:
            span = (scope.including or scope.element).span
            if scope is inner[0]:
                message = f'the names of the model "{scope.name}" within begin with "{scope.name}_" here'
                message += f", and so on for {len(inner) - 1} more" if len(inner) > 1 else ""
                note("import-converted", message, span)
            if any(child.tag == "plugin" for child in scope.element.children):
                what = f'a plugin of the model "{scope.name}" becomes one of the robot: names in it stay as they are'
                note("import-changed", what, span)

    def _is_static(self) -> bool:
        static = (child.text for child in self.top.element.children if child.tag == "static")
        return any(map(is_true, (self.top.element.get("static"), *static)))

    def _world_link(self, roots: list[Node]) -> str:
        """Return the link that is the world, if the model is joined to it or is in several pieces."""
        is_joined = any(joint.parent is None for joint in self.bodies.joints)
        if len(roots) < 2 and not is_joined:
            return ""
        name = WORLD
        while name in {node.called for node in self.bodies.members}:
            name += "_"
        if len(roots) > 1 or (roots and is_joined):
            how = "fixed, as the model is static" if self._is_static() else "floating"
            message = f'the model has pieces that no joint connects: joints to a link "{name}" hold them, {how}'
            if len(roots) == 1:
                message = f'no joint holds "{roots[0].called}": one to the link "{name}" does, {how}'
            self.reading.note("import-converted", message, roots[0].element.span)
        return name

    def _root(self, roots: list[Node], world: str) -> dict[str, Any]:
        """Return the pose of the root in the world."""
        if world:
            return {"world": True}
        if not roots:
            return {}
        own = self.bodies.pose(roots[0])
        if not is_near(own):
            message = f'the robot begins at "{roots[0].called}", which is not where the frame of the model is:'
            message += " what includes the SDF of the robot places that link"
            self.reading.note("import-converted", message, roots[0].element.span)
        here = self.bodies.world.then(own)
        of_model = self.reading.pose(self.reading.single(self.top.element, "pose"))
        written = of_model if of_model.transform == here else WrittenPose(here)
        return {} if is_near(here) else written.entry((written.element or self.top.element).span)

    # Kept elements

    def _put(self, tag: str, found: Sequence[tuple[Element, str]], **attributes: str) -> None:
        """Keep elements of the robot in one with a tag."""
        if found:
            text = wrapped(tag, [text for _, text in found], **attributes)
            index = keep(self.holder, found[0][0], text)
            for element, _ in found:
                self.reading.paths[id(element)] = ("urdf_elements", index)

    def _keep_elements(self, scope: Scope) -> None:
        """Keep what the models contain besides links, frames and joints."""
        element = scope.element
        self.reading.paths[id(element)] = ("robot",)
        rest = self.reading.rest(element, _READ, ("name", "canonical_link", "placement_frame"))
        gazebo = [child for child in rest if child.tag in OF_MODEL]
        rest = [child for child in rest if child.tag not in OF_MODEL]
        if scope is not self.top:  # what a model within has is for that alone, but plugins
            for child in gazebo:
                if child.tag != "plugin":
                    self.reading.cannot_carry(f"<{child.tag}> of {named(element)} within", child.span)
            gazebo = [child for child in gazebo if child.tag == "plugin"]
        if scope.including is not None:
            gazebo += [child for child in scope.including.children if child.tag == "plugin"]
            self.reading.check(scope.including, _IN_INCLUDE, ("merge",), None)
        for child in rest:
            if child.tag == "drake:joint":
                message = f"{named(child)} is a joint of Drake's own, which no description has"
                self.reading.lenient("sdf-joint", message, child.span, "make it one of SDF", "keeps it as it is")
        rest = [child for child in rest if not self._is_constraint(child, scope)]
        for tag, found in (("gazebo", gazebo), ("sdf", rest)):
            self._put(tag, [(child, self.models.text_of(child, scope)) for child in found])
        for node in scope.nodes.values():
            if node.inner is not None:
                self._keep_elements(node.inner)

    def _is_constraint(self, element: Element, scope: Scope) -> bool:
        """Add a ball constraint of Drake; return False if the element is none between two links."""
        words = {child.tag.removeprefix(f"{element.tag}_"): child for child in element.children}
        if element.tag != "drake:ball_constraint" or not {"body_A", "body_B", "p_AP"} <= words.keys():
            return False
        ends = [self.models.find(scope, words[key].text) for key in ("body_A", "body_B")]
        point = self.reading.all_of(words["p_AP"], 3)
        links = [node.called for node in ends if node is not None and node.kind == LINK]
        if len(links) != len(ends) or point is None:
            return False
        name = element.get("name") or "loop"
        while name in self.constraints:
            name += "_"
        entry = {"type": "connect", "links": links, "at": Placed(point, words["p_AP"].span)}
        self.constraints[name] = Placed(entry, element.span)
        self.reading.paths[id(element)] = ("constraints", name)
        return True


def _name_span(element: Element) -> Span:
    return element.attributes["name"].span if "name" in element.attributes else element.span

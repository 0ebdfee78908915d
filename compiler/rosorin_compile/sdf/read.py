"""Import an SDF as a description (http://sdformat.org/spec, versions 1.4 to 1.12).

Input that libsdformat rejects is an error, and so are mistakes that it silently accepts, such as misspelled or
duplicate elements. Nested and included models are merged, with the name of the model as a prefix. Elements that a
description has no key for are kept as XML (``urdf_elements``).
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.formats.format import ImportFile, SourceValue
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions, as_tree, comments_of
from rosorin_compile.formats.robot_files import accept, lower_artifact
from rosorin_compile.formats.urdf.read import plain
from rosorin_compile.formats.xml_reader import NAME
from rosorin_compile.model import Robot, Transform
from rosorin_compile.rules.urdf_elements import sdf_elements
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, has_errors
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import count_of, first_of, mask_controls, phrase, quote
from rosorin_compile.source.xml.markup import Element, MarkupError, correction, name_of, parse_artifact

from . import models
from .content import OF_LINK, OF_MODEL, SOLIDS, WORLD, keep, wrap
from .models import FRAME, LINK, Node, Scope, SdfReader, WrittenPose
from .read_joints import Bodies, Entries, Joints, is_near

_READ = ("link", "frame", "joint", "model", "include", "pose")
_IN_INCLUDE = ("uri", "name", "pose", "static", "placement_frame", "plugin")
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_WATER = 1000  # kg/m^3: the default density for an inertial with auto="true"


def read_sdf(opened: ImportFile) -> ImportedRobot:
    """Import the robot of an SDF; the result has diagnostics and, if there is no error, the description."""
    reading, document = SdfReader(opened.options, opened.path), opened.xml
    top = reading.top(document.root, opened.path)
    sections, diagnostics = None if top is None else _Robot(reading, top).read(), reading.all_diagnostics()
    imported = ImportedRobot(None, diagnostics, (), tuple(reading.files))
    if sections is None or top is None or has_errors(diagnostics):
        return imported
    source = {"status": "imported", "note": f"from {mask_controls(opened.path.name)}"}
    made: Map = as_tree({"robot": sections.pop("robot"), "source": source, **sections}, document.root.span)
    if not opened.options.checked:
        return imported._replace(tree=made)
    tree, problems = accept(made, opened.options.lenient)
    if tree is None:
        return imported._replace(diagnostics=[*diagnostics, *problems])
    version = ".".join(map(str, top.version))
    output = {"file": "robot.sdf", **({"version": version} if version in ("1.10", "1.11", "1.12") else {})}
    tree.put("outputs", as_tree({"sdf": output}, tree.span), tree.span, tree.span)
    for element in document.root.iter():  # move comments in an element without an entry to the entry of its parent
        if (above := reading.paths.get(id(element.parent))) is not None and "urdf_elements" not in above:
            reading.paths.setdefault(id(element), () if above == ("robot",) else above)
    comments = comments_of(document, reading.paths)
    return imported._replace(tree=tree, diagnostics=[*diagnostics, *problems], comments=comments, version=version)


def read(text: str) -> Robot:
    """Parse a generated SDF. Raises ValueError if its contents are invalid."""
    document = parse_artifact(text, "sdf")
    try:
        imported = read_sdf(ImportFile(Path("robot.sdf"), ReadOptions(checked=False), document))
    except MarkupError as problem:
        raise ValueError(problem.diagnostic.message) from None
    if imported.tree is None:
        raise ValueError(next(one.message for one in imported.diagnostics if one.severity == ERROR))
    return plain(lower_artifact(imported.whole, imported.diagnostics))


class _Robot:
    def __init__(self, reading: SdfReader, top: Scope) -> None:
        self.reading, self.top = reading, top
        self.bodies = Bodies(reading, top)
        self.entries = Entries({}, {}, {})
        self.holder: dict[str, Any] = {"urdf_elements": []}  # elements kept as XML for the robot
        self.constraints: dict[str, SourceValue] = {}
        static = [top.element.get("static"), *(one.text for one in top.element.children if one.tag == "static")]
        self.of_pieces = "fixed" if any(map(models.is_true, static)) else "floating"  # joint type of unconnected parts

    def read(self) -> dict[str, Any] | None:
        top, reading, bodies, links = self.top, self.reading, self.bodies, self.entries.links
        if not bodies.links and not has_errors(reading.diagnostics):
            help = "add <link>: readers of SDF refuse a model without"
            reading.error("no-links", f'the model "{top.name}" has no links', top.element.span, help)
        if reading.canonical(top) is None or has_errors(reading.diagnostics):
            return None
        for nodes in (bodies.members, [joint.node for joint in bodies.joints]):
            taken: set[str] = set()
            for node in nodes:
                first = node.scope.prefix + node.name
                node.called = first.replace("::", "_")
                while node.called in taken:
                    node.called += "_"
                taken.add(node.called)
                if node.called != first:
                    message = f'the {node.kind} "{first}" is called "{node.called}" in the description'
                    reading.note("import-changed", message, node.element.span)
        # The world becomes a link if the model has a joint to the world or several unconnected parts.
        roots, world = bodies.roots(), ""
        if len(roots) > 1 or any(joint.parent is None for joint in bodies.joints):
            world = WORLD
            while world in {node.called for node in bodies.members}:
                world += "_"
            links[world] = {}
            if roots:
                pieces = quote([node.called for node in roots], 3)
                message = f'no joint in the SDF moves {pieces}: {self.of_pieces} joints to a link "{world}" are added'
                reading.note("import-converted", message, roots[0].element.span)
        for node in bodies.members:
            links[node.called] = {}
            reading.paths[id(node.element)] = ("links", node.called)
            if node.kind == FRAME:
                reading.check(node.element, ("pose",), ("name", "attached_to"), None)
        for node in bodies.links:
            self._link(node)
        if massless := [node for node in bodies.links if all(one.tag != "inertial" for one in node.element.children)]:
            names = first_of([node.called for node in massless], 3)
            message = f"{count_of(len(massless), 'link')} without <inertial> ({names}): 1 kg, as readers of SDF take it"
            reading.note("import-converted", message, massless[0].element.span)
        joints = Joints(bodies, self.entries)
        joints.read(world)
        for node in roots if world else ():
            joints.fix(node, world, bodies.local_pose(node, None), self.of_pieces)
        spans = {node.called: models.name_span(node.element) for node in bodies.members}
        made: dict[str, Any] = {"robot": SourceValue(top.name, models.name_span(top.element))}
        made["links"] = {name: SourceValue(links[name], spans.get(name, top.element.span)) for name in links}
        self._keep_elements(top)
        for name, found in self.entries.gazebo.items():
            self._put("gazebo", found, reference=name)
        optional = {"joints": self.entries.joints, "root": self._root(roots, world), "constraints": self.constraints}
        return made | {key: value for key, value in (optional | self.holder).items() if value}

    def _root(self, roots: list[Node], world: str) -> dict[str, Any]:
        if world or not roots:
            return {"world": True} if world else {}
        here = self.bodies.world.then(self.bodies.pose(roots[0]))
        of_model = self.reading.pose(self.reading.single(self.top.element, "pose"))
        written = of_model if of_model.transform == here else WrittenPose(here)
        return {} if is_near(here) else written.entry((written.element or self.top.element).span)

    def _put(self, tag: str, found: Sequence[tuple[Element, str]], **attributes: str) -> None:
        if found:
            text = wrap(tag, [text for _, text in found], **attributes)
            index = keep(self.holder, found[0][0], text)
            for element, _ in found:
                self.reading.paths[id(element)] = ("urdf_elements", index)

    def _keep_elements(self, scope: Scope) -> None:
        element, reading = scope.element, self.reading
        reading.paths[id(element)] = ("robot",)
        gazebo, rest = list[Element](), list[Element]()
        for child in reading.rest(element, _READ, ("name", "canonical_link", "placement_frame")):
            if child.tag == "drake:joint":
                message = f"{name_of(child)} is a joint of Drake's own, which no description has"
                reading.lenient("sdf-joint", message, child.span, "make it one of SDF", "keeps it as it is")
            if child.tag not in OF_MODEL:
                rest += [] if self._is_constraint(child, scope) else [child]
            elif scope is self.top or child.tag == "plugin":
                gazebo.append(child)
            else:  # the element would apply to the whole robot after nested models are merged
                reading.cannot_carry(f"<{child.tag}> of {name_of(element)} within", child.span)
        for child in gazebo if scope is not self.top and not scope.is_merged else ():
            message = f"{name_of(child)} becomes one of the robot: names in it stay as they are"
            reading.note("import-changed", message, child.span)
        if scope.including is not None:
            gazebo += [child for child in scope.including.children if child.tag == "plugin"]
            reading.check(scope.including, _IN_INCLUDE, ("merge",), None)
        for tag, found in (("gazebo", gazebo), ("sdf", rest)):
            self._put(tag, [(child, reading.text_of(child, scope)) for child in found])
        for inner in filter(None, (node.inner for node in scope.nodes.values())):
            self._keep_elements(inner)

    def _is_constraint(self, element: Element, scope: Scope) -> bool:
        """Import a ball constraint of Drake between two links, or return False for any other element."""
        words = {child.tag.removeprefix(f"{element.tag}_"): child for child in element.children}
        if element.tag != "drake:ball_constraint" or not {"body_A", "body_B", "p_AP"} <= words.keys():
            return False
        ends = [scope.find(words[key].text) for key in ("body_A", "body_B")]
        point = self.reading.all_of(words["p_AP"], 3)
        links = [node.called for node in ends if node is not None and node.kind == LINK]
        if len(links) != len(ends) or point is None:
            return False
        name = element.get("name") or "loop"
        while name in self.constraints:
            name += "_"
        entry = {"type": "connect", "links": links, "at": SourceValue(point, words["p_AP"].span)}
        self.constraints[name] = SourceValue(entry, element.span)
        self.reading.paths[id(element)] = ("constraints", name)
        return True

    def _link(self, link: Node) -> None:
        self._inertial(link)
        for child in (child for child in link.element.children if child.tag in ("visual", "collision")):
            self._shape(child, link)
        for child in self.reading.rest(link.element, ("pose", "inertial", "visual", "collision"), ("name",)):
            if child.tag not in OF_LINK:
                self._keep(child, link)
                continue
            pose = self.reading.single(child, "pose")
            owner, _ = self._placed(pose, link)
            text = self.reading.text_of(child, link.scope, None if owner is link else pose)
            self.entries.gazebo.setdefault(owner.called, []).append((child, text))

    def _keep(self, element: Element, link: Node) -> None:
        text = wrap("sdf", [self.reading.text_of(element, link.scope)])
        index = keep(self.entries.links[link.called], element, text)
        self.reading.paths[id(element)] = ("links", link.called, "urdf_elements", index)

    def _inertial(self, link: Node) -> None:
        reading = self.reading
        element = reading.single(link.element, "inertial")
        span = (element or link.element).span
        made: dict[str, Any] = {"mass": 1, "inertia": {key: SourceValue(1, span) for key in _INERTIA[:3]}}
        if element is not None:
            reading.paths[id(element)] = ("links", link.called, "inertial")
        if element is not None and models.is_true(element.get("auto")):
            made = {"of": "collision", "density": reading.one(element, "density") or SourceValue(_WATER, span)}
            reading.check(element, ("density",), ("auto",), None)
            for child in link.element.children:
                for part in child.children if child.tag == "collision" else ():
                    if part.tag in ("density", "auto_inertia_params"):
                        reading.cannot_carry(f"<{part.tag}> of {name_of(child)}", part.span)
        elif element is not None:
            inertia = reading.single(element, "inertia")
            at = (inertia or element).span
            moments = dict.fromkeys(_INERTIA[:3], SourceValue(1, at))
            if inertia is not None:
                moments |= {key: one for key in _INERTIA if (one := reading.one(inertia, key))}
                reading.check(inertia, _INERTIA, (), None)
            made = {"mass": reading.one(element, "mass") or SourceValue(1, span)}
            made |= self._placed(reading.single(element, "pose"), link, at_frame=False)[1].entry(span)
            made["inertia"] = SourceValue(moments, at)
            reading.check(element, ("pose", "mass", "inertia"), ("auto",), None)
        self.entries.links[link.called]["inertial"] = SourceValue(made, span)

    def _placed(self, pose: Element | None, link: Node, at_frame: bool = True) -> tuple[Node, WrittenPose]:
        """Return (frame, pose in that frame); the frame is ``link`` or, if ``at_frame``, a frame attached to it."""
        written, base, attribute = self.reading.pose(pose), link, models.relative_to(pose)
        if attribute is not None and pose is not None:
            base = self.reading.require(link.scope, attribute.value, attribute.span, "relative_to", pose) or link
        if base is link or (at_frame and base.kind in (LINK, FRAME) and self.bodies.body_of(base) is link):
            return base, written
        here = self.bodies.pose(link).inverse().then(self.bodies.pose(base))
        return link, written if here == Transform() else WrittenPose(here.then(written.transform), element=pose)

    def _shape(self, element: Element, link: Node) -> None:
        reading = self.reading
        owner, placed = self._placed(reading.single(element, "pose"), link)
        if (geometry := reading.single(element, "geometry")) is None:
            reading.error("missing-element", f"{name_of(element)} has no <geometry>", element.span, "add one")
            return
        made: dict[str, Any] = {}
        if (solid := self._solid(geometry, made, link)) is None:
            return
        if solid.tag not in SOLIDS:
            message = f"<{solid.tag}> of {name_of(element)} is not a standard shape: it is kept as XML"
            reading.diagnostics.append(Diagnostic("import-kept", NOTE, message, solid.span))
            self._keep(element, link)
            return
        shapes = self.entries.links[owner.called].setdefault(element.tag, [])
        reading.paths[id(element)] = ("links", owner.called, element.tag, len(shapes))
        if (attribute := element.attribute("name")) is None or not attribute.value:
            message = f"a <{element.tag}> of {name_of(link.element)} has no name"
            reading.lenient("missing-attribute", message, element.span, 'add name="..."', "accepts it without")
        elif not NAME.match(attribute.value):
            reading.cannot_carry(f'the name "{attribute.value}" of <{element.tag}>', attribute.span)
        elif attribute.value != f"{owner.called}_{element.tag}_{len(shapes) + 1}":  # not the default name
            made["name"] = SourceValue(attribute.value, attribute.span)
        made |= placed.entry(element.span)
        self._details(element, solid, made, link)
        shapes.append(SourceValue(made, element.span))

    def _details(self, element: Element, solid: Element, made: dict[str, Any], link: Node) -> None:
        reading, rest, more = self.reading, list[str](), dict[str, list[Element]]()
        more[solid.tag] = reading.rest(solid, (*SOLIDS[solid.tag], "uri"), ("optimization",))
        if any(child.tag == "submesh" for child in more[solid.tag]):
            message = f"the submesh of {name_of(element)} is kept for SDF alone: other formats have the whole mesh"
            reading.note("import-converted", message, solid.span)
        if (material := reading.single(element, "material")) is not None and element.tag == "collision":
            reading.ignore("the material of a collision: what collides is not seen", material.span)
        elif material is not None:
            more["material"] = self._look(material, made, link)
        for tag, inner in more.items():
            rest += [wrap(tag, [reading.text_of(child, link.scope) for child in inner])] if inner else []
        for child in reading.rest(element, ("pose", "geometry", "material"), ("name",)):
            # A <surface> becomes ``contact`` if it only has friction that is equal in both directions.
            ode = _only_descendant(child, "friction", "ode") if child.tag == "surface" else None
            found = {one.tag: reading.one(ode, one.tag) for one in ode.children} if ode is not None else {}
            mu, other = found.get("mu"), found.get("mu2")
            if mu is not None and found.keys() <= {"mu", "mu2"} and (other is None or mu.value == other.value):
                made["contact"] = SourceValue({"friction": SourceValue([mu], mu.span)}, child.span)
            else:
                rest.append(reading.text_of(child, link.scope))
        if rest:
            keep(made, element, wrap("sdf", rest))

    def _look(self, material: Element, made: dict[str, Any], link: Node) -> list[Element]:
        """Set the colour and the image of a visual, and return the other elements of its material."""
        diffuse, ambient = (self._colour(material, tag) for tag in ("diffuse", "ambient"))
        read = ["diffuse"]
        if diffuse is not None:
            made["rgba"] = diffuse
            if ambient is not None and ambient.value == diffuse.value:
                read.append("ambient")
        rest = []
        for child in self.reading.rest(material, read):
            image = _only_descendant(child, "metal", "albedo_map") if child.tag == "pbr" else None
            if image is not None and image.text:
                made["texture"] = SourceValue(self._address(image.text, link), image.span)
            else:
                rest.append(child)
        return rest

    def _colour(self, material: Element, tag: str) -> SourceValue | None:
        child = self.reading.single(material, tag)
        values = None if child is None else self.reading.all_of(child, 3 if len(child.text.split()) == 3 else 4)
        if values is None or child is None:
            return None
        if len(values) == 3:
            values.put(1, child.span)
        return SourceValue(values, child.span)

    def _solid(self, geometry: Element, made: dict[str, Any], link: Node) -> Element | None:
        reading = self.reading
        children = [child for child in geometry.children if child.tag != "empty"] or geometry.children
        if len(children) > 1 and {child.tag for child in children} != {"polyline"}:
            message = f"{name_of(geometry)} has {phrase(f'<{child.tag}>' for child in children)}; it takes one"
            reading.error("duplicate-element", message, children[1].span, "move one to another collision or visual")
            return None
        if not children:
            help = f"it takes one of {', '.join(SOLIDS)}"
            reading.error("missing-element", f"{name_of(geometry)} is empty", geometry.span, help)
            return None
        solid, before = children[0], len(reading.diagnostics)
        if solid.tag not in SOLIDS:
            known = sdf_elements()["geometry"]
            near = None if solid.tag in known or reading.options.lenient else correction(solid.tag, known)
            if near is None:
                return solid
            reading.misspelt(f"<{solid.tag}>", f"<{near}>", geometry, solid.span)
            return None
        sizes: dict[str, Any] = {}
        uri = reading.text(solid, "uri") if solid.tag == "mesh" else None
        if uri is not None and uri.value != "__default__":
            sizes["file"] = SourceValue(self._address(str(uri.value), link), uri.span)
        elif solid.tag == "mesh":
            reading.error("missing-element", f"{name_of(solid)} has no <uri>", solid.span, "name the mesh")
        for key, count in SOLIDS[solid.tag].items():
            child, unit = reading.single(solid, key), "" if key == "scale" else "m"
            if child is None and unit:
                reading.error("missing-element", f"{name_of(solid)} has no <{key}>", solid.span, f"add <{key}>")
            values = None if child is None else reading.all_of(child, count, unit)
            if child is not None and values and (unit or values != [1, 1, 1]):
                sizes[key] = SourceValue(*(values[0], values.value_spans[0]) if count == 1 else (values, child.span))
        made[solid.tag] = SourceValue(sizes, solid.span)
        return None if has_errors(reading.diagnostics[before:]) else solid

    def _address(self, uri: str, link: Node) -> str:
        first, own = self.reading.files[0], link.scope.file
        if "://" in uri or uri.startswith("/") or first.parent == own.parent:
            return uri
        return os.path.relpath(own.parent / uri, first.parent).replace(os.sep, "/")


def _only_descendant(element: Element, *tags: str) -> Element | None:
    """Return the descendant at a path of tags, or None if an element on the path has siblings."""
    for tag in tags:
        if [child.tag for child in element.children] != [tag]:
            return None
        element = element.children[0]
    return element

"""SDF: a robot as Gazebo and Drake have it, read into the plain tree (http://sdformat.org/spec, versions 1.4 to 1.12).

What libsdformat refuses is refused, and so is what it passes silently although it cannot be meant: misspelt words, a
second element where one is taken. Models within a model and those of files beside it are resolved: their names get the
name of the model before them. What the language has no word for is kept as it stands (``verbatim``).
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.formats.format import Opened, Placed
from rosorin_compile.formats.imported import Comment, Imported, ReadOptions, as_tree
from rosorin_compile.formats.reading import accept, lower_artifact
from rosorin_compile.formats.urdf.reading import Reading, named
from rosorin_compile.formats.urdf.robot import comments_of, plain
from rosorin_compile.model import Joint, Limit, Link, Mesh, Output, Robot, Shape
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Source, has_errors
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.files import printable_name
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, parse

from .bodies import has_mass
from .read_joints import Joints
from .read_links import Entries, Links
from .reading import Said, changed, converted, entry_of, others
from .scopes import FRAME, Models, Node, Scope
from .trees import Tree, is_near, named_twice
from .verbatim import keep, text_of, wrapped
from .words import OF_MODEL, WORLD, world_of

_OF_MODEL = ("link", "frame", "joint", "model", "include", "pose")
_OF_INCLUDE = ("uri", "name", "pose", "static", "placement_frame", "plugin")
_NEWER = ("1.10", "1.11", "1.12")


def read_sdf(opened: Opened) -> Imported:
    """Return the robot of an SDF."""
    reading = Reading(opened.options)
    document = opened.xml
    models = Models(reading, opened.path)
    top = models.top(document.root, opened.path)
    entries = None if top is None else _Robot(models, top).read()
    diagnostics = reading.all_diagnostics()
    files, left_out = tuple(models.included.files), reading.left_out()
    if entries is None or top is None or has_errors(diagnostics):
        return Imported(None, diagnostics, (), files, left_out)
    name = printable_name(opened.path)
    whole = {"robot": entries.pop("robot"), "source": {"status": "imported", "note": f"from {name}"}, **entries}
    tree = as_tree(whole, document.root.span)
    told: list[Diagnostic] = []
    accepted: Map | None = tree
    if opened.options.checked:
        accepted, told = accept(tree, opened.options.lenient)
    if accepted is None:
        return Imported(None, [*diagnostics, *told], (), files, left_out)
    accepted.put("outputs", as_tree(_outputs(top), tree.span), tree.span, tree.span)
    comments = _comments(document, reading)
    return Imported(accepted, [*diagnostics, *told], comments, files, left_out, _version(top))


def view(robot: Robot, output: Output) -> Robot:
    """Return what an SDF has to contain at least: frames, what joints may do, masses, and what collides."""
    from .write import FOLLOWERS, joint_names, version_of

    followers = version_of(robot, output) in (FOLLOWERS, "1.12")
    names, world = joint_names(robot), world_of(robot)
    form = str(output.options.get("height_maps", "rows"))
    links, joints = [], []
    for link in robot.links:
        solids = [solid for shape in link.collision for solid in shape.solids(form)]
        bare = tuple(Shape(solid.geometry, solid.pose) for solid in solids)
        meshes = any(isinstance(solid.geometry, Mesh) for solid in solids)
        links.append(Link(link.name, link.inertial if has_mass(link.inertial) else None, (), () if meshes else bare))
    # A link that no joint of the SDF holds is read as one that floats in the world, and so is the root then.
    loose = [joint for joint in robot.joints if joint.type in ("floating", "planar") and joint.parent != world]
    around = world or WORLD
    while loose and not world and around in robot.link:
        around += "_"
    if loose and not world:
        links.append(Link(around))
        joints.append(Joint("", "floating", around, robot.root))
    poses = robot.poses_in_root({}) if loose else {}
    for joint in robot.joints:
        if joint in loose:
            joints.append(Joint("", "floating", around, joint.child, pose_of(poses[joint.child])))
        elif joint.parent != world or joint.type not in ("floating", "planar"):
            axis = joint.axis if joint.moves else (1.0, 0.0, 0.0)
            place = (joint.parent, joint.child, joint.origin)
            mimic = joint.mimic and followers and replace(joint.mimic, joint=names[joint.mimic.joint])
            name = names[joint.name] if joint.moves else ""
            limit = joint.limit if joint.moves else None
            if limit is not None:
                ends = (None, None) if joint.type == "continuous" else (limit.known("lower"), limit.known("upper"))
                limit = Limit(*ends, limit.known("effort"))
            joints.append(Joint(name, joint.type, *place, axis, limit, mimic or None))
    return Robot(robot.name, tuple(links), tuple(joints))


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


def _version(top: Scope) -> str:
    return ".".join(map(str, top.version))


def _outputs(top: Scope) -> dict[str, Any]:
    """Return what the description asks for: an SDF, of the version that the words in it are of."""
    version = {"version": _version(top)} if _version(top) in _NEWER else {}
    return {"sdf": {"file": "robot.sdf", **version}}


def _comments(document: Document, reading: Reading) -> list[Comment]:
    """Return the comments; those in an element that is read with what holds it belong to that."""
    for element in document.root.iter():
        above = reading.paths.get(id(element.parent)) if element.parent is not None else None
        if above is not None and "urdf_elements" not in above:
            reading.paths.setdefault(id(element), () if above == ("robot",) else above)
    return comments_of(document, reading.paths)


class _Robot:
    """Makes the sections of a description from a model."""

    def __init__(self, models: Models, top: Scope) -> None:
        self.models = models
        self.reading = models.reading
        self.top = top
        self.entries = Entries({}, {})
        self.elements: list[Placed] = []
        self.constraints: dict[str, Placed] = {}

    def read(self) -> dict[str, Any] | None:
        """Return the sections; None after an error that hides all else."""
        top, reading = self.top, self.reading
        tree = Tree(self.models, top)
        if not tree.links and not has_errors(reading.diagnostics):
            help = "add <link>: readers of SDF refuse a model without"
            reading.error("no-links", f'the model "{top.name}" has no links', top.element.span, help)
        canonical = self.models.canonical(top)
        if canonical is None or has_errors(reading.diagnostics):
            return None
        self._name(tree)
        roots = tree.roots()
        world = self._world(tree, roots)
        for node in tree.members:
            self.entries.links[node.called] = {}
            reading.paths[id(node.element)] = ("links", node.called)
            if node.kind == FRAME:
                reading.check(node.element, ("pose",), ("name", "attached_to"), None)
        Links(tree, self.entries).read()
        if roots and not world and tree.body_of(roots[0]) is not canonical:
            message = (
                f'the canonical link of the model is "{canonical.called}", that of the SDF of the robot where it begins'
            )
            converted(reading, message, canonical.element.span)
        joints = Joints(tree, self.entries)
        joints.read(world)
        for node in roots if world else ():
            joints.fix(node, world, tree.local_pose(node, None), "fixed" if self._is_static() else "floating")
        return self._sections(tree, joints, roots, world)

    def _sections(self, tree: Tree, joints: Joints, roots: list[Node], world: str) -> dict[str, Any]:
        spans = {node.called: _name_span(node) for node in tree.members}
        made: dict[str, Any] = {"robot": Placed(self.top.name, _name_span_of(self.top.element))}
        links = {name: entry for name, entry in self.entries.links.items() if name != world}
        if world:
            links = {world: {}, **links}
        made["links"] = {name: Placed(entry, spans.get(name, self.top.element.span)) for name, entry in links.items()}
        if joints.made:
            made["joints"] = {name: Placed(entry, joints.spans[name]) for name, entry in joints.made.items()}
        root = self._root(tree, roots, world)
        if root:
            made["root"] = root
        self._kept()
        if self.constraints:
            made["constraints"] = self.constraints
        if self.elements:
            made["urdf_elements"] = self.elements
        return made

    def _name(self, tree: Tree) -> None:
        """Say what links, frames and joints are called in the description."""
        named_twice(tree.members, set(), self.reading)
        named_twice((joint.node for joint in tree.joints), set(), self.reading)
        inner = [node for node in self.top.nodes.values() if node.inner is not None and not node.inner.is_merged]
        if inner:
            node = inner[0]
            message = f'the names of the model "{node.name}" within begin with "{node.name}_" here'
            if len(inner) > 1:
                message += f", and so on for {len(inner) - 1} more"
            converted(self.reading, message, _brought(node).span)
        for node in inner:
            if any(child.tag == "plugin" for child in node.element.children):
                what = f'a plugin of the model "{node.name}" becomes one of the robot: names in it stay as they are'
                changed(self.reading, what, _brought(node).span)

    def _is_static(self) -> bool:
        return self.top.element.get("static").lower() in ("1", "true") or any(
            child.tag == "static" and child.text.lower() in ("1", "true") for child in self.top.element.children
        )

    def _world(self, tree: Tree, roots: list[Node]) -> str:
        """Return the link that is the world, where the model is joined to it, or is in several pieces."""
        if len(roots) < 2 and all(joint.parent is not None for joint in tree.joints):
            return ""
        taken = {node.called for node in tree.members}
        name = WORLD
        while name in taken:
            name += "_"
        self.entries.links[name] = {}
        if len(roots) > 1 or (roots and any(joint.parent is None for joint in tree.joints)):
            how = "fixed, as the model is static" if self._is_static() else "floating"
            message = f'the model has pieces that no joint connects: joints to a link "{name}" hold them, {how}'
            if len(roots) == 1:
                message = f'no joint holds "{roots[0].called}": one to the link "{name}" does, {how}'
            converted(self.reading, message, roots[0].element.span)
        return name

    def _root(self, tree: Tree, roots: list[Node], world: str) -> dict[str, Any]:
        """Return how the root stands in the world."""
        span = self.top.element.span
        if world:
            return {"world": True}
        if not roots:
            return {}
        own = tree.pose(roots[0])
        if not is_near(own):
            message = f'the robot begins at "{roots[0].called}", which is not where the frame of the model is:'
            message += " what includes the SDF of the robot places that link"
            converted(self.reading, message, roots[0].element.span)
        here = tree.world.then(own)
        if is_near(here):
            return {}
        of_model = self.models.numbers.pose(self.reading.single(self.top.element, "pose"))
        said = of_model if of_model.transform == here else Said(here)
        return entry_of(said, said.element.span if said.element is not None else span)

    def _kept(self) -> None:
        """Keep what stands in the models, and what links and joints have for Gazebo."""
        self._of_model(self.top)
        for name, found in self.entries.gazebo.items():
            self._put(found[0][0], wrapped("gazebo", [text for _, text in found], reference=name))
            for element, _ in found:
                self.reading.paths[id(element)] = ("urdf_elements", len(self.elements) - 1)

    def _put(self, element: Element, text: str) -> None:
        holder: dict[str, Any] = {"urdf_elements": self.elements}
        keep(holder, element, text)
        self.reading.paths[id(element)] = ("urdf_elements", len(self.elements) - 1)

    def _of_model(self, scope: Scope) -> None:
        element = scope.element
        self.reading.paths[id(element)] = ("robot",)
        attributes = ("name", "canonical_link", "placement_frame")
        rest = others(self.reading, element, (*_OF_MODEL, *OF_MODEL), attributes)
        gazebo = [child for child in element.children if child.tag in OF_MODEL]
        if scope is not self.top:  # what is said of a model within holds for that alone
            for child in (one for one in gazebo if one.tag != "plugin"):
                self.reading.cannot_carry(f"<{child.tag}> of {named(element)} within", child.span)
            gazebo = [child for child in gazebo if child.tag == "plugin"]
        if scope.overriding is not None:
            gazebo += [child for child in scope.overriding.children if child.tag == "plugin"]
            self.reading.check(scope.overriding, _OF_INCLUDE, ("merge",), None)
        for child in (one for one in rest if one.tag == "drake:joint"):
            message = f"{named(child)} is a joint of Drake's own, which no description has"
            self.reading.lenient("sdf-joint", message, child.span, "make it one of SDF", "keeps it as it is")
        rest = [child for child in rest if not (child.tag == "drake:ball_constraint" and self._of_drake(child, scope))]
        texts = {tag: [(child, text_of(child, scope, self.models)) for child in found]
                 for tag, found in (("gazebo", gazebo), ("sdf", rest))}  # fmt: skip
        for tag, found in texts.items():
            if found:
                self._put(found[0][0], wrapped(tag, [text for _, text in found]))
                for one, _ in found:
                    self.reading.paths[id(one)] = ("urdf_elements", len(self.elements) - 1)
        for node in scope.nodes.values():
            if node.inner is not None:
                self._of_model(node.inner)

    def _of_drake(self, element: Element, scope: Scope) -> bool:
        """Add a ball constraint of Drake; return False if it does not hold two links."""
        words = {child.tag.removeprefix("drake:ball_constraint_"): child for child in element.children}
        ends = [self.models.find(scope, words[key].text) for key in ("body_A", "body_B") if key in words]
        point = self.models.numbers.all_of(words["p_AP"], 3) if "p_AP" in words else None
        links = [node.called for node in ends if node is not None and node.kind == "link"]
        if len(links) != len(("A", "B")) or point is None:
            return False
        name = element.get("name") or "loop"
        while name in self.constraints:
            name += "_"
        entry = {"type": "connect", "links": links, "at": Placed(point, words["p_AP"].span)}
        self.constraints[name] = Placed(entry, element.span)
        self.reading.paths[id(element)] = ("constraints", name)
        return True


def _brought(node: Node) -> Element:
    """Return what brings a model within a model: the <include>, or the <model> itself."""
    return node.inner.overriding if node.inner is not None and node.inner.overriding is not None else node.element


def _name_span(node: Node) -> Any:
    return _name_span_of(node.element)


def _name_span_of(element: Element) -> Any:
    attribute = element.attributes.get("name")
    return element.span if attribute is None else attribute.span

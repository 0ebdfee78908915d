"""Import the joints of an SDF, and the frames that are attached to links, as entries of ``joints``.

The members of a body are a link and all frames attached to it. The topmost member is the child of a joint, or else the
reference frame of the other poses. The parent of any other member is the reference frame of its pose if that is in the
body, else the topmost member. If the child of a joint does not have its origin on the joint axis, a link is added.
"""

from operator import sub
from typing import Any, NamedTuple

from rosorin_compile.formats.format import SourceValue
from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import cross
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, Suggestion, phrase, quote
from rosorin_compile.source.tree import Seq
from rosorin_compile.source.xml.markup import Element, name_of, place

from . import models
from .content import OF_JOINT, WORLD, keep, wrap
from .models import FRAME, JOINT, LINK, OWN, Node, Scope, SdfReader, WrittenPose

_NEAR = 1e-10  # m, or elements of a rotation matrix: smaller values are rounding errors
_TYPES = ("revolute", "continuous", "prismatic", "fixed", "ball")
_NOT_CARRIED = ("screw", "gearbox", "universal", "revolute2")
_LIMIT = ("lower", "upper", "effort", "velocity")
_DYNAMICS = ("damping", "friction", "spring_stiffness", "spring_reference")
# Elements of a joint that are not kept as XML. The last five have no effect on the supported joint types.
_READ = (
    *("pose", "parent", "child", "axis"),
    *("axis2", "thread_pitch", "screw_thread_pitch", "gearbox_ratio", "gearbox_reference_body"),
)
_Z: Vector = (0.0, 0.0, 1.0)
_STAND_INS = {"lower": -1000, "upper": 1000, "effort": 1000, "velocity": 10}  # rad or m; N*m or N; rad/s or m/s
_USUAL_MIMIC = {"multiplier": 1.0, "offset": 0.0}
_MIMIC = (*_USUAL_MIMIC, "reference")


class Entries(NamedTuple):
    """Entries of links and joints by name, and the contents of <gazebo> blocks as (element, XML) by link or joint."""

    links: dict[str, dict[str, Any]]
    joints: dict[str, SourceValue]
    gazebo: dict[str, list[tuple[Element, str]]]


class JointNode(NamedTuple):
    """A joint of an SDF. ``parent`` is None for the world; ``there`` is the pose of the child in the joint frame."""

    node: Node
    kind: str
    parent: Node | None
    child: Node
    there: Transform


def is_near(transform: Transform) -> bool:
    """Return True if a transform is the identity, except for rounding errors."""
    distances = map(sub, (*sum(transform.rows, ()), *transform.xyz), (1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0))
    return all(abs(distance) < _NEAR for distance in distances)


class Bodies:
    """The bodies of a model (links with the frames attached to them), and the joints between them."""

    def __init__(self, reading: SdfReader, top: Scope) -> None:
        self.reading, self.top = reading, top
        nodes = list(top.all_nodes())
        self.links = [node for node in nodes if node.kind == LINK]
        self.members = [node for node in nodes if node.kind in (LINK, FRAME)]
        pose = reading.single(top.element, "pose")
        self.world, attribute = reading.pose(pose).transform, models.relative_to(pose)
        if attribute is not None and attribute.value != WORLD:
            message = f'the pose of the model is relative to "{attribute.value}", which is not in the file'
            reading.error("sdf-name-unknown", message, attribute.span, "leave it out: the world is what is meant")
        self._body = {node: reading.link_of(node) for node in self.members}
        self.joints: list[JointNode] = []
        self._joint_to: dict[Node | None, JointNode] = {}  # the joint that moves each link
        for node in (node for node in nodes if node.kind == JOINT):
            self._join(node)
        self._tops = {body: joint.child for body, joint in self._joint_to.items() if body is not None}
        for link in self.links:
            path = [link]
            while (above := self._base_in_body(path[-1])) is not None and above not in path:
                path.append(above)
            self._tops.setdefault(link, path[-1])

    def pose(self, node: Node | None) -> Transform:
        """Return the pose of a link, frame or joint in the outermost model; None represents the world."""
        return self.world.inverse() if node is None else self.reading.node_pose(node)

    def body_of(self, node: Node | None) -> Node | None:
        """Return the link that a link, frame or joint moves with, or None for the world or after an error."""
        return None if node is None else self._body.get(node)

    def _join(self, node: Node) -> None:
        reading, attribute = self.reading, node.element.attribute("type")
        reading.need(node.element, "type")
        kind = attribute.value if attribute is not None else ""
        if attribute is not None and kind not in _TYPES:
            what, help = f'{name_of(node.element)} is of type "{kind}", which', f"use {phrase(_TYPES)}"
            if kind not in _NOT_CARRIED:
                suggestion = Suggestion(kind, (*_TYPES, *_NOT_CARRIED))
                reading.error("joint-type", f"{what} is unknown", attribute.span, suggestion)
            elif reading.lenient("sdf-joint", f"{what} no description has", attribute.span, help, "leaves it out"):
                reading.cannot_carry(name_of(node.element), attribute.span)
        parent, child = (self._end(node, end) for end in ("parent", "child"))
        if not parent or not child or kind not in _TYPES:
            return
        body = self.body_of(child[0])
        first = self._joint_to.get(body)
        if child[0] is None:
            message = f"the child of {name_of(node.element)} is the world, which no joint moves"
            reading.error("sdf-joint", message, child[1], "swap parent and child")
        elif parent[0] is not None and self.body_of(parent[0]) is body:
            message = f'{name_of(node.element)} joins "{child[0].name}" to the link that it is part of'
            reading.error("sdf-joint", message, child[1], "name another link")
        elif first is None or body is None:
            there = self.pose(node).inverse().then(self.pose(child[0]))
            self._joint_to[body] = JointNode(node, kind, parent[0], child[0], there)
            self.joints.append(self._joint_to[body])
        elif reading.options.checked or kind not in ("ball", "fixed"):  # in our files, these close loops, see write.py
            message = f'two joints move link "{body.name}", "{first.node.name}" and "{node.name}": a loop, or swapped'
            if reading.lenient("two-parents", message, node.element.span, "remove one joint", "leaves the second out"):
                reading.cannot_carry(name_of(node.element), node.element.span)

    def _end(self, node: Node, end: str) -> tuple[Node | None, Span] | None:
        """Return (node, source position) for an end of a joint, or None after an error; node is None for the world."""
        text, reading = self.reading.text(node.element, end), self.reading
        if text is None:
            message = f"{name_of(node.element)} has no <{end}>"
            reading.error("missing-element", message, node.element.span, f"add <{end}>LINK</{end}>")
            return None
        if text.value == WORLD and node.scope.find(WORLD) is None:
            return None, text.span
        found = reading.require(node.scope, text.value, text.span, f"the {end}", node.element)
        member = found if found is None or found.kind in (LINK, FRAME) else reading.link_of(found)
        if member is None and found is not None:
            reading.error("sdf-name-unknown", f'"{text.value}" has no link', text.span, "name a link or a frame")
        return None if member is None else (member, text.span)

    def _base_in_body(self, node: Node) -> Node | None:
        found = node.scope.find(self.reading.base(node)[0])
        return found if found in self._body and self.body_of(found) is self.body_of(node) else None

    def parent_of(self, node: Node) -> Node | None:
        """Return the parent of a link or frame within its body, or None for the topmost member."""
        body = self.body_of(node)
        top = self._tops.get(body) if body is not None else None
        return None if top is node else self._base_in_body(node) or top

    def roots(self) -> list[Node]:
        return [self._tops[link] for link in self.links if link not in self._joint_to]

    def local_pose(self, node: Node, parent: Node | None) -> WrittenPose:
        """Return the pose of a node relative to ``parent``, as in the file if ``parent`` is its reference frame."""
        above = self.pose(parent)
        if self.reading.base_pose(node) == above:
            return node.written
        return WrittenPose(above.inverse().then(self.pose(node)), element=node.written.element)


class Joints:
    """Converts the joints of a model to entries."""

    def __init__(self, bodies: Bodies, entries: Entries) -> None:
        self.bodies, self.entries, self.reading = bodies, entries, bodies.reading
        self._names = {joint.node.called for joint in bodies.joints}
        self.stand_ins: dict[str, dict[str, Span]] = {}  # source positions of placeholder limits by key and joint

    def read(self, world: str) -> None:
        """Add the entries of all joints; ``world`` is the name of the link that represents the world."""
        for joint in self.bodies.joints:
            self.reading.paths[id(joint.node.element)] = ("joints", joint.node.called)
            self._joint(joint, joint.parent.called if joint.parent is not None else world)
        for node in self.bodies.members:
            if (above := self.bodies.parent_of(node)) is not None:
                self.fix(node, above.called, self.bodies.local_pose(node, above))
        for key, places in self.stand_ins.items():
            message = f"no {key} limit in the SDF, so {_STAND_INS[key]} is used as a stand-in: {quote([*places], 3)}"
            help, span = "put in what the robot really has", next(iter(places.values()))
            self.reading.diagnostics.append(Diagnostic("import-stand-in", NOTE, message, span, (), help))

    def fix(self, node: Node, parent: str, pose: WrittenPose, kind: str = "fixed") -> None:
        """Add a joint that is not in the SDF, which connects a frame to its link, or a link to the world."""
        name = f"{node.called}_joint"
        while name in self._names or name in self.entries.joints:
            name += "_"
        entry = {"type": kind, "parent": parent, "child": node.called, **pose.entry(node.element.span)}
        self.entries.joints[name] = SourceValue(entry, node.element.span)

    def _joint(self, joint: JointNode, parent: str) -> None:
        element, node, reading = joint.node.element, joint.node, self.reading
        has_axis = joint.kind not in ("fixed", "ball")
        axis = reading.single(element, "axis") if has_axis else None
        if (found := self._direction(node, axis)) is None:
            return
        direction, numbers = found
        is_at = joint.kind in ("fixed", "prismatic") or is_near(Transform(xyz=joint.there.xyz))
        if joint.kind in ("revolute", "continuous"):
            is_at = max(map(abs, cross(joint.there.xyz, direction))) < _NEAR
        of_child, pose = (self.bodies.local_pose(one, joint.parent) for one in (joint.child, node))
        child = joint.child.called
        pose = of_child if is_at and (not is_near(joint.there) or (of_child.xyz and not pose.xyz)) else pose
        if not is_at:
            child = f"{node.called}_anchor"
            while child in self.entries.links:
                child += "_"
            self.entries.links[child] = {}
            message = f'the child of {name_of(element)} is not at the joint: link "{child}" is added between'
            reading.note("import-converted", message, element.span)
        entry: dict[str, Any] = {"type": SourceValue(joint.kind, element.attributes["type"].span)}
        for end, link in (("parent", parent), ("child", child)):
            entry[end] = SourceValue(link, place(next(one for one in element.children if one.tag == end)))
        entry |= pose.entry(element.span)
        self.entries.joints[node.called] = SourceValue(entry, models.name_span(element))
        texts = [(one, reading.text_of(one, node.scope)) for one in reading.rest(element, _READ, ("name", "type"))]
        if of_gazebo := [(one, text) for one, text in texts if one.tag in OF_JOINT]:
            self.entries.gazebo.setdefault(node.called, []).extend(of_gazebo)
        if kept := [text for one, text in texts if one.tag not in OF_JOINT]:
            keep(entry, element, wrap("sdf", kept))
        if has_axis:
            there = joint.there if is_at and not is_near(joint.there) else Transform()
            if numbers is None or there.rows != Transform().rows:
                turned = there.inverse().rotate(direction)
                entry["axis"] = SourceValue([*map(models.clean_number, turned)], (axis or element).span)
            else:
                entry["axis"] = SourceValue(numbers, numbers.value_spans[0])
            self._details(node, entry, axis)
        if not is_at:
            self.fix(joint.child, child, WrittenPose(joint.there, element=joint.child.written.element))

    def _direction(self, node: Node, axis: Element | None) -> tuple[Vector, Seq | None] | None:
        """Return (axis in the joint frame, its numbers in the file), or None after an error.

        The numbers are None if there are none, or if they are in another frame. Up to SDF 1.6, an axis is in the model
        frame if use_parent_model_frame is true, the default up to SDF 1.4.
        """
        xyz = None if axis is None else self.reading.single(axis, "xyz")
        numbers = None if xyz is None else self.reading.all_of(xyz, 3)
        if axis is None or xyz is None:
            return _Z, None
        if numbers is None:
            return None
        x, y, z = map(float, numbers)
        attribute = xyz.attribute("expressed_in")
        of_model = attribute is not None and attribute.value == OWN
        frame: Transform | None = None
        if attribute is not None and attribute.value and not of_model:
            found = self.reading.require(node.scope, attribute.value, attribute.span, "expressed_in of an axis")
            frame = None if found is None else self.bodies.pose(found)
        elif not of_model and node.scope.version <= (1, 6):
            flag = self.reading.single(axis, "use_parent_model_frame")
            of_model = node.scope.version < (1, 5) if flag is None else models.is_true(flag.text)
        frame = self.reading.model_pose(node.scope) if of_model else frame
        if frame is None:
            return (x, y, z), numbers
        turned = self.bodies.pose(node).inverse().then(frame)
        return turned.rotate((x, y, z)), numbers if is_near(Transform(turned.rows)) else None

    def _details(self, node: Node, entry: dict[str, Any], axis: Element | None) -> None:
        reading = self.reading
        self._limit(node.called, entry, axis, (axis or node.element).span)
        if axis is None:
            return
        reading.paths.setdefault(id(axis), ("joints", node.called))
        dynamics = reading.single(axis, "dynamics")
        made = {key: number for key in _DYNAMICS if (number := reading.one(dynamics, key)) and number.value}
        if dynamics is not None and made:
            keys = {"spring_stiffness": "stiffness"}
            entry["dynamics"] = SourceValue({keys.get(key, key): number for key, number in made.items()}, dynamics.span)
        rest, known = list[str](), {"limit": _LIMIT, "dynamics": _DYNAMICS}
        for child in reading.rest(axis, ("xyz", "use_parent_model_frame")):
            if child.tag in ("mimic", "drake:mimic"):
                self._mimic(child, node, entry)
            elif child.tag not in known:
                rest.append(reading.text_of(child, node.scope))
            elif texts := [reading.text_of(one, node.scope) for one in reading.rest(child, known[child.tag])]:
                rest.append(wrap(child.tag, texts))
        if rest:
            text = SourceValue(wrap("sdf", [wrap("axis", rest)]), axis.span)
            entry["urdf_elements"] = [text, *entry.get("urdf_elements", ())]

    def _limit(self, name: str, entry: dict[str, Any], axis: Element | None, span: Span) -> None:
        limit, kind = self.reading.single(axis, "limit") if axis is not None else None, entry["type"].value
        unit = "m" if kind == "prismatic" else "rad"
        units = {"lower": unit, "upper": unit, "effort": "", "velocity": f"{unit}/s"}
        read = {key: self.reading.limit(limit, key, units[key]) for key in _LIMIT}
        found = {key: one for key, one in read.items() if one and (key in _LIMIT[:2] or one.value >= 0)}
        has_range = kind == "prismatic" or (kind == "revolute" and bool({"lower", "upper"} & found.keys()))
        if kind != "prismatic":
            entry["type"] = entry["type"]._replace(value="revolute" if has_range else "continuous")
        needed = _LIMIT if has_range else _LIMIT[2:]
        if not has_range and not found.keys() & set(needed):
            return
        where = limit.span if limit is not None else span
        missing = [key for key in needed if key not in found]
        for key in missing:
            found[key] = SourceValue(f"{_STAND_INS[key]} {unit}" if key in _LIMIT[:2] else _STAND_INS[key], where)
            self.stand_ins.setdefault(key, {})[name] = where
        made: dict[str, Any] = {key: found[key] for key in needed}
        if missing:
            made["stand_ins"] = [SourceValue(key, where) for key in missing]
            made["source"] = {"status": "stand_in", "note": f"the SDF does not limit {phrase(missing)}"}
        entry["limit"] = SourceValue(made, where)
        if limit is not None:
            self.reading.paths.setdefault(id(limit), ("joints", name, "limit"))

    def _mimic(self, element: Element, node: Node, entry: dict[str, Any]) -> None:
        """Set ``mimic`` of a joint: position = multiplier * (leader - reference) + offset."""
        reading = self.reading
        if (attribute := element.attribute("joint")) is None or not attribute.value:
            reading.error("missing-attribute", f"{name_of(element)} names no joint", element.span, 'add joint="..."')
            return
        if (leader := node.scope.find(attribute.value)) is None or leader.kind != JOINT:
            message = f'{name_of(element)} follows "{attribute.value}", which is not a joint'
            joints = [one.name for one in node.scope.nodes.values() if one.kind == JOINT]
            help = Suggestion(attribute.value, joints, none="name a joint")
            if reading.lenient("mimic-unknown", message, attribute.span, help, "leaves the mimic out"):
                reading.cannot_carry(name_of(element), element.span)
            return
        made: dict[str, Any] = {"joint": SourceValue(leader.called, attribute.span)}
        for key in _MIMIC:  # a child element in SDF, an attribute in files for Drake
            of_drake, number = element.attribute(key), reading.one(element, key)
            if of_drake is not None:
                found = reading.numbers(of_drake.words(), element, key, of_drake.span, 1)
                number = SourceValue(found[0], found.value_spans[0]) if found else None
            if number is not None:
                made[key] = number
        if (reference := made.pop("reference", None)) is not None and reference.value:
            factor, offset = (float(made[key].value) if key in made else usual for key, usual in _USUAL_MIMIC.items())
            made["offset"] = SourceValue(models.clean_number(offset - factor * reference.value), element.span)
        entry["mimic"] = SourceValue(made, element.span)
        reading.check(element, _MIMIC, ("joint", "axis", *_MIMIC), None)

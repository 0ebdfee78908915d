"""Joints of an SDF as entries of ``joints``: types, axes, limits, dynamics, and the joints that they follow.

A joint of two axes becomes two, one behind the other; one whose child is not at it moves a link in between.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, Suggestion, counted, first_of, listed
from rosorin_compile.source.xml.markup import Element, named, place, words

from .bodies import NEAR, PAIRS, Bodies, Joined, is_near
from .elements import OF_JOINT, keep, wrapped
from .models import JOINT, OWN, Node
from .read_links import Entries
from .reading import WrittenPose, cleaned, is_true

_LIMIT = ("lower", "upper", "effort", "velocity")
# The numbers of an axis with the keys of the language.
_DYNAMICS = {
    "damping": "damping",
    "friction": "friction",
    "spring_stiffness": "stiffness",
    "spring_reference": "spring_reference",
}
_UNUSED = ("thread_pitch", "screw_thread_pitch", "gearbox_ratio", "gearbox_reference_body")
_Z: Vector = (0.0, 0.0, 1.0)
_STAND_INS = {"lower": -1000, "upper": 1000, "effort": 1000, "velocity": 10}  # N*m or N, rad/s or m/s, m or rad
_OF_MIMIC = ("multiplier", "offset", "reference")


class _Axis(NamedTuple):
    """An axis: its element, its direction in the frame of the joint, and the numbers as written if they are that."""

    element: Element | None
    direction: Vector
    numbers: list[Placed] | None

    def entry(self, there: Transform, span: Span) -> Placed:
        """Return the axis in a frame that is ``there`` in the joint."""
        if self.numbers is not None and there.rows == Transform().rows:
            return Placed(self.numbers, self.numbers[0].span)
        return Placed([cleaned(value) for value in there.inverse().rotate(self.direction)], span)


class Joints:
    """Reads the joints of a model into entries."""

    def __init__(self, bodies: Bodies, entries: Entries) -> None:
        self.bodies, self.entries = bodies, entries
        self.models, self.reading = bodies.models, bodies.reading
        self.stand_ins: dict[str, list[tuple[str, Span]]] = {}

    def read(self, world: str) -> None:
        """Fill the entries of all joints; ``world`` is the link that is the world."""
        for joint in self.bodies.joints:
            element = joint.node.element
            self.reading.paths[id(element)] = ("joints", joint.node.called)
            parent = joint.parent.called if joint.parent is not None else world
            if joint.kind == "fixed":
                self._add(joint, "fixed", parent, joint.child.called, self.bodies.at_joint(joint))
                self._ignore_axes(element, "fixed")
            elif joint.kind in PAIRS:
                self._pair(joint, parent)
            else:
                self._moving(joint, parent)
        for node in self.bodies.members:
            above = self.bodies.above(node)
            if above is not None:
                self.fix(node, above.called, self.bodies.local_pose(node, above))
        for word, value in (("range", 1000), ("effort", 1000), ("velocity", 10)):
            places = self.stand_ins.get(word, [])
            names = list(dict.fromkeys(name for name, _ in places))
            if names:
                whose = f'joint "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'joint')} have"
                which = f" ({first_of(names, 3)})" if len(names) > 1 else ""
                message = f"{whose} no {word} limit in the SDF{which}: {value} is written as a stand-in"
                help = "put in what the robot really has"
                self.reading.diagnostics.append(Diagnostic("import-stand-in", NOTE, message, places[0][1], (), help))

    def fix(self, node: Node, parent: str, pose: WrittenPose, kind: str = "fixed") -> None:
        """Add a joint that the SDF has no word for: of a frame, or of a link in the world."""
        span = node.element.span
        entry = {"type": kind, "parent": parent, "child": node.called, **pose.entry(span)}
        self.entries.joints[self._free_name(f"{node.called}_joint")] = Placed(entry, span)

    def _free_name(self, name: str) -> str:
        taken = {joint.node.called for joint in self.bodies.joints} | self.entries.joints.keys()
        while name in taken:
            name += "_"
        return name

    def _add(self, joint: Joined, kind: str, parent: str, child: str, pose: WrittenPose) -> dict[str, Any]:
        """Add the entry of a joint of the SDF with what is kept of it, and return it."""
        element, node = joint.node.element, joint.node
        entry: dict[str, Any] = {"type": Placed(kind, element.attributes["type"].span)}
        for end, link in (("parent", parent), ("child", child)):
            entry[end] = Placed(link, place(next(one for one in element.children if one.tag == end)))
        entry |= pose.entry(element.span)
        span = element.attributes["name"].span if "name" in element.attributes else element.span
        self.entries.joints[node.called] = Placed(entry, span)
        kept = []
        for one in self.reading.rest(element, ("pose", "parent", "child", "axis", "axis2"), ("name", "type")):
            if one.tag in OF_JOINT:
                text = self.models.text_of(one, node.scope)
                self.entries.gazebo.setdefault(node.called, []).append((one, text))
            elif one.tag in _UNUSED:
                self.reading.ignored(f"<{one.tag}> has no effect on a joint of its type", one.span)
            else:
                kept.append(self.models.text_of(one, node.scope))
        if kept:
            keep(entry, element, wrapped("sdf", kept))
        return entry

    def _ignore_axes(self, element: Element, kind: str) -> None:
        """Report what has no effect on a joint without an axis; the axis itself is written by many tools."""
        for tag in ("axis", "axis2"):
            axis = self.reading.single(element, tag)
            for child in axis.children if axis is not None else ():
                numbers = [word.text for inner in child.iter() for word in words(inner)]
                if child.tag in ("mimic", "dynamics") and any(word.strip("0.") for word in numbers):
                    self.reading.ignored(f"<{child.tag}> of a {kind} joint has no effect", child.span)

    def _moving(self, joint: Joined, parent: str) -> None:
        """Add a joint of one axis, or a ball; with a link in between where the child is not at the joint."""
        element, is_ball = joint.node.element, joint.kind == "ball"
        axis = _Axis(None, _Z, None) if is_ball else self._axis(joint.node, "axis")
        if axis is None:
            return
        (a, b, c), (x, y, z) = joint.there.xyz, axis.direction
        along_axis = max(abs(b * z - c * y), abs(c * x - a * z), abs(a * y - b * x)) < NEAR
        at = joint.kind == "prismatic" or (is_near(Transform(xyz=(a, b, c))) if is_ball else along_axis)
        child = joint.child.called if at else self._between(joint.node)
        pose = self.bodies.at_joint(joint) if at else self.bodies.local_pose(joint.node, joint.parent)
        entry = self._add(joint, joint.kind, parent, child, pose)
        if is_ball:
            self._ignore_axes(element, "ball")
        else:
            there = joint.there if at and not is_near(joint.there) else Transform()
            entry["axis"] = axis.entry(there, (axis.element or element).span)
            self._details(joint.node, joint.node.called, entry, axis.element)
        if not at:
            self._fix_child(joint, child)

    def _fix_child(self, joint: Joined, anchor: str) -> None:
        """Fix the child of a joint to the link that the joint moves."""
        self.fix(joint.child, anchor, WrittenPose(joint.there, element=joint.child.written.element))

    def _between(self, node: Node, what: str = "anchor") -> str:
        """Add a link without mass that a joint moves, and return its name."""
        name = f"{node.called}_{what}"
        while name in self.entries.links:
            name += "_"
        self.entries.links[name] = {}
        message = f'the child of {named(node.element)} is not at the joint: a link "{name}" stands between'
        if what != "anchor":
            message = f"{named(node.element)} turns about two axes: it becomes two joints, with a link "
            message += f'"{name}" between'
        self.reading.note("import-converted", message, node.element.span)
        return name

    def _pair(self, joint: Joined, parent: str) -> None:
        """Add the two joints of a joint that turns about two axes."""
        node, element = joint.node, joint.node.element
        first, second = self._axis(node, "axis"), self._axis(node, "axis2")
        if first is None or second is None:
            return
        if second.element is None:
            message = f'{named(element)} is of type "{joint.kind}" and has no <axis2>'
            self.reading.error("missing-element", message, element.span, "add it")
            return
        link = self._between(node, "link")
        entry = self._add(joint, "revolute", parent, link, self.bodies.local_pose(node, joint.parent))
        entry["axis"] = first.entry(Transform(), element.span)
        self._details(node, node.called, entry, first.element)
        other, at = self._free_name(f"{node.called}_2"), is_near(joint.there)
        child = joint.child.called if at else self._between(node)
        entry = {"type": Placed("revolute", element.span), "parent": link, "child": child}
        entry["axis"] = second.entry(Transform(), second.element.span)
        self.entries.joints[other] = Placed(entry, self.entries.joints[node.called].span)
        self._details(node, other, entry, second.element)
        if not at:
            self._fix_child(joint, child)

    def _axis(self, node: Node, tag: str) -> _Axis | None:
        """Return an axis in the frame of its joint, or None after an error.

        Versions before 1.5 have it in the frame of the model, and those up to 1.6 if use_parent_model_frame is true.
        """
        element = self.reading.single(node.element, tag)
        xyz = None if element is None else self.reading.single(element, "xyz")
        numbers = None if xyz is None else self.reading.all_of(xyz, 3)
        if xyz is not None and numbers is None:
            return None
        x, y, z = _Z if numbers is None else (float(one.value) for one in numbers)
        attribute = None if xyz is None else xyz.attributes.get("expressed_in")
        frame: Transform | None = None
        of_model = attribute is not None and attribute.value == OWN
        if attribute is not None and attribute.value and not of_model:
            found = self.models.require(node.scope, attribute.value, attribute.span, "expressed_in of an axis")
            of_model, frame = found is None, None if found is None else self.bodies.pose(found)
        elif element is not None and not of_model and node.scope.version <= (1, 6):
            flag = self.reading.single(element, "use_parent_model_frame")
            of_model = node.scope.version < (1, 5) if flag is None else is_true(flag.text)
        if of_model:
            frame = self.models.pose(None, node.scope)
        if frame is None:
            return _Axis(element, (x, y, z), numbers)
        turned = self.bodies.pose(node).inverse().then(frame)
        return _Axis(element, turned.rotate((x, y, z)), numbers if is_near(Transform(turned.rows)) else None)

    def _details(self, node: Node, name: str, entry: dict[str, Any], axis: Element | None) -> None:
        """Set limit, dynamics and mimic of a joint, and keep what else its axis has."""
        reading = self.reading
        self._limit(name, entry, axis, (axis or node.element).span)
        if axis is None:
            return
        reading.paths.setdefault(id(axis), ("joints", name))
        dynamics = reading.single(axis, "dynamics")
        made = {
            key: number for word, key in _DYNAMICS.items() if (number := reading.one(dynamics, word)) and number.value
        }
        if dynamics is not None and made:
            entry["dynamics"] = Placed(made, dynamics.span)
        rest: list[str] = []
        for child in reading.rest(axis, ("xyz", "use_parent_model_frame")):
            if child.tag in ("limit", "dynamics"):
                inner = reading.rest(child, _LIMIT if child.tag == "limit" else _DYNAMICS)
                texts = [self.models.text_of(one, node.scope) for one in inner]
                rest += [wrapped(child.tag, texts)] if texts else []
            elif child.tag in ("mimic", "drake:mimic"):
                self._mimic(child, node, entry)
            else:
                rest.append(self.models.text_of(child, node.scope))
        if rest:
            text = Placed(wrapped("sdf", [wrapped("axis", rest)]), axis.span)
            entry["urdf_elements"] = [text, *entry.get("urdf_elements", ())]

    def _limit(self, name: str, entry: dict[str, Any], axis: Element | None, span: Span) -> None:
        """Set the limit; stand-ins replace what readers of other formats need and the SDF does not have."""
        limit = self.reading.single(axis, "limit") if axis is not None else None
        turns = entry["type"].value != "prismatic"
        unit = "rad" if turns else "m"
        found: dict[str, Placed] = {}
        for key in _LIMIT:
            number = self.reading.limit(limit, key, {"effort": "", "velocity": f"{unit}/s"}.get(key, unit))
            if number is not None and (key in ("lower", "upper") or number.value >= 0):
                found[key] = number
        has_range = not turns or (entry["type"].value == "revolute" and bool({"lower", "upper"} & found.keys()))
        if turns:
            entry["type"] = entry["type"]._replace(value="revolute" if has_range else "continuous")
        needed = _LIMIT if has_range else _LIMIT[2:]
        if not has_range and not found.keys() & set(needed):
            return
        where = limit.span if limit is not None else span
        missing = [key for key in needed if key not in found]
        for key in missing:
            is_end = key in ("lower", "upper")
            found[key] = Placed(f"{_STAND_INS[key]} {unit}" if is_end else _STAND_INS[key], where)
            self.stand_ins.setdefault("range" if is_end else key, []).append((name, where))
        made: dict[str, Any] = {key: found[key] for key in needed}
        if missing:
            made["stand_ins"] = [Placed(key, where) for key in missing]
            note = f"{listed(missing)} {'is a stand-in' if len(missing) == 1 else 'are stand-ins'}: the SDF does not"
            note += f" limit {'it' if len(missing) == 1 else 'them'}"
            made["source"] = {"status": "stand_in", "note": note}
        entry["limit"] = Placed(made, where)
        if limit is not None:
            self.reading.paths.setdefault(id(limit), ("joints", name, "limit"))

    def _mimic(self, element: Element, node: Node, entry: dict[str, Any]) -> None:
        """Set the joint that a joint follows: position = multiplier * (leader - reference) + offset."""
        reading = self.reading
        if element.tag != "mimic":
            reading.note("import-converted", "<drake:mimic> becomes a mimic: the same", element.span)
        attribute = element.attributes.get("joint")
        if attribute is None or not attribute.value:
            reading.error("missing-attribute", f"{named(element)} names no joint", element.span, 'add joint="..."')
            return
        leader = self.models.find(node.scope, attribute.value)
        if leader is None or leader.kind != JOINT:
            message = f'{named(element)} follows "{attribute.value}", which is no joint'
            joints = [one.name for one in node.scope.nodes.values() if one.kind == JOINT]
            help = Suggestion(attribute.value, joints, none="name a joint")
            if reading.lenient("mimic-unknown", message, attribute.span, help, "leaves the mimic out"):
                reading.cannot_carry(named(element), element.span)
            return
        called = f"{leader.called}_2" if element.get("axis", "axis") == "axis2" else leader.called
        made: dict[str, Any] = {"joint": Placed(called, attribute.span)}
        for key in _OF_MIMIC:  # a child, or for Drake an attribute
            of_drake, number = element.attributes.get(key), reading.one(element, key)
            if of_drake is not None:
                found = reading.numbers(of_drake.words(), f"{key} of {named(element)}", of_drake.span, 1)
                number = found[0] if found else None
            if number is not None:
                made[key] = number
        reference = float(made.pop("reference").value) if "reference" in made else 0.0
        if reference:
            factor, offset = (
                float(made[key].value) if key in made else usual
                for key, usual in (("multiplier", 1.0), ("offset", 0.0))
            )
            made["offset"] = Placed(cleaned(offset - factor * reference), element.span)
        entry["mimic"] = Placed(made, element.span)
        reading.check(element, _OF_MIMIC, ("joint", "axis", *_OF_MIMIC), None)

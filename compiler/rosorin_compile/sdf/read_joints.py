"""Joints of an SDF as entries of ``joints``: types, axes, limits, dynamics, and who follows whom.

A joint of two axes becomes two, one behind the other; one whose child is not at it moves a link in between.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import Reading, named
from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import (
    NOTE,
    Diagnostic,
    Span,
    Suggestion,
    counted,
    first_of,
    listed,
)
from rosorin_compile.source.xml.markup import Element

from .read_links import Entries
from .reading import Numbers, Said, cleaned, converted, entry_of, others, place, words
from .scopes import JOINT, OWN, Models, Node
from .trees import PAIRS, Joined, Tree, is_along, is_near
from .verbatim import keep, text_of, wrapped
from .words import MOTION, OF_JOINT

_OF_JOINT = ("pose", "parent", "child", "axis", "axis2")
_OF_AXIS = ("xyz", "limit", "dynamics", "use_parent_model_frame", "mimic", "drake:mimic", "initial_position")
_KEPT_OF_LIMIT = ("stiffness", "dissipation")
_UNUSED = ("thread_pitch", "screw_thread_pitch", "gearbox_ratio", "gearbox_reference_body")
_Z: Vector = (0.0, 0.0, 1.0)
_STAND_INS = {"lower": -1000, "upper": 1000, "effort": 1000, "velocity": 10}  # N*m or N, rad/s or m/s, m or rad
_OF_MIMIC = ("multiplier", "offset", "reference")
_CALLED = {"spring_stiffness": "stiffness"}  # what a description calls otherwise


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
    """Reads the joints of a tree into entries."""

    def __init__(self, tree: Tree, entries: Entries) -> None:
        self.tree = tree
        self.models: Models = tree.models
        self.reading: Reading = tree.reading
        self.numbers: Numbers = tree.models.numbers
        self.entries = entries
        self.made: dict[str, dict[str, Any]] = {}
        self.spans: dict[str, Span] = {}
        self.stand_ins: dict[str, list[tuple[str, Span]]] = {}

    def read(self, world: str) -> None:
        """Fill the entries of all joints; ``world`` is the link that is the world."""
        for joint in self.tree.joints:
            self.reading.paths[id(joint.node.element)] = ("joints", joint.node.called)
            parent = joint.parent.called if joint.parent is not None else world
            if joint.kind == "fixed":
                said = self.tree.at_joint(joint)
                entry = self._add(joint.node.called, "fixed", parent, joint.child.called, said, joint.node.element)
                self._ignored(joint.node.element, "fixed")
                self._rest(joint.node, entry)
            elif joint.kind in PAIRS:
                self._pair(joint, parent)
            else:
                self._moving(joint, parent)
        for node in self.tree.members:
            above = self.tree.above(node)
            if above is not None:
                self.fix(node, above.called, self.tree.local_pose(node, above))
        self._report_stand_ins()

    def fix(self, node: Node, parent: str, said: Said, kind: str = "fixed") -> None:
        """Add a joint that the SDF has no word for: of a frame, or of a link in the world."""
        name = self._free(f"{node.called}_joint")
        self.made[name] = {"type": kind, "parent": parent, "child": node.called, **entry_of(said, node.element.span)}
        self.spans[name] = node.element.span

    def _free(self, name: str) -> str:
        """Return a name that no joint has."""
        taken = {joint.node.called for joint in self.tree.joints} | self.made.keys()
        while name in taken:
            name += "_"
        return name

    def _add(self, name: str, kind: str, parent: str, child: str, said: Said, element: Element) -> dict[str, Any]:
        """Add the entry of a joint of the SDF, and return it."""
        entry: dict[str, Any] = {"type": Placed(kind, element.attributes["type"].span)}
        for end, link in (("parent", parent), ("child", child)):
            entry[end] = Placed(link, place(next(one for one in element.children if one.tag == end)))
        self.made[name] = entry | entry_of(said, element.span)
        self.spans[name] = element.attributes["name"].span if "name" in element.attributes else element.span
        return self.made[name]

    def _ignored(self, element: Element, kind: str) -> None:
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
        way = joint.there.xyz
        at = is_near(Transform(xyz=way)) if is_ball else joint.kind == "prismatic" or is_along(way, axis.direction)
        child = joint.child.called if at else self._between(joint.node)
        said = self.tree.at_joint(joint) if at else self.tree.local_pose(joint.node, joint.parent)
        entry = self._add(joint.node.called, joint.kind, parent, child, said, element)
        if is_ball:
            self._ignored(element, "ball")
        else:
            there = joint.there if at and not is_near(joint.there) else Transform()
            entry["axis"] = axis.entry(there, (axis.element or element).span)
            self._details(joint.node, joint.node.called, entry, axis.element)
        self._rest(joint.node, entry)
        if not at:
            self._fix_to(joint, child)

    def _fix_to(self, joint: Joined, anchor: str) -> None:
        """Fix the child of a joint to the link that the joint moves."""
        self.fix(joint.child, anchor, Said(joint.there, element=joint.child.said.element))

    def _between(self, node: Node, what: str = "anchor") -> str:
        """Add a link without mass that a joint moves, and return its name."""
        name = node.called + f"_{what}"
        while name in self.entries.links:
            name += "_"
        self.entries.links[name] = {}
        message = f'the child of {named(node.element)} is not at the joint: a link "{name}" stands between'
        if what != "anchor":
            message = f"{named(node.element)} turns about two axes: it becomes two joints, with a link "
            message += f'"{name}" between'
        converted(self.reading, message, node.element.span)
        return name

    def _pair(self, joint: Joined, parent: str) -> None:
        """Add the two joints of a joint that turns about two axes."""
        element, name = joint.node.element, joint.node.called
        first, second = self._axis(joint.node, "axis"), self._axis(joint.node, "axis2")
        if first is None or second is None:
            return
        if second.element is None:
            message = f'{named(element)} is of type "{joint.kind}" and has no <axis2>'
            self.reading.error("missing-element", message, element.span, "add it")
            return
        link = self._between(joint.node, "link")
        entry = self._add(name, "revolute", parent, link, self.tree.local_pose(joint.node, joint.parent), element)
        entry["axis"] = first.entry(Transform(), element.span)
        self._details(joint.node, name, entry, first.element)
        self._rest(joint.node, entry)
        other, at = self._free(f"{name}_2"), is_near(joint.there)
        child = joint.child.called if at else self._between(joint.node)
        self.made[other] = entry = {"type": Placed("revolute", element.span), "parent": link, "child": child}
        self.spans[other] = self.spans[name]
        entry["axis"] = second.entry(Transform(), second.element.span)
        self._details(joint.node, other, entry, second.element)
        if not at:
            self._fix_to(joint, child)

    def _axis(self, node: Node, tag: str) -> _Axis | None:
        """Return an axis in the frame of its joint; None after an error.

        Versions before 1.5 have it in the frame of the model, and those up to 1.6 where they say so.
        """
        element = self.reading.single(node.element, tag)
        xyz = None if element is None else self.reading.single(element, "xyz")
        numbers = None if xyz is None else self.numbers.all_of(xyz, 3)
        if xyz is not None and numbers is None:
            return None
        a, b, c = _Z if numbers is None else (float(one.value) for one in numbers)
        attribute = None if xyz is None else xyz.attributes.get("expressed_in")
        seen: Transform | None = None
        if attribute is not None and attribute.value:
            what = "expressed_in of an axis"
            found = (
                None if attribute.value == OWN else self.models.asked(node.scope, attribute.value, attribute.span, what)
            )
            if found is not None or attribute.value == OWN:
                seen = self.models.pose(None, node.scope) if found is None else self.tree.pose(found)
        elif element is not None and node.scope.version <= (1, 6):
            said = any(child.tag == "use_parent_model_frame" for child in element.children)
            if self.numbers.flag(element, "use_parent_model_frame") if said else node.scope.version < (1, 5):
                seen = self.models.pose(None, node.scope)
        if seen is None:
            return _Axis(element, (a, b, c), numbers)
        turned = self.tree.pose(node).inverse().then(seen)
        return _Axis(element, turned.rotate((a, b, c)), numbers if is_near(Transform(turned.rows)) else None)

    def _details(self, node: Node, name: str, entry: dict[str, Any], axis: Element | None) -> None:
        """Set limit, dynamics and mimic of a joint, and keep what else its axis has."""
        self._limit(name, entry, axis, (axis or node.element).span)
        if axis is None:
            return
        self.reading.paths.setdefault(id(axis), ("joints", name))
        dynamics = self.reading.single(axis, "dynamics")
        if dynamics is not None:
            found = {word: self.numbers.one(dynamics, word) for word in MOTION["dynamics"]}
            made = {_CALLED.get(word, word): one for word, one in found.items() if one is not None and one.value}
            if made:
                entry["dynamics"] = Placed(made, dynamics.span)
        more = others(self.reading, axis, _OF_AXIS, ())
        rest: list[str] = []
        for child in axis.children:
            if child.tag in MOTION:
                known = MOTION[child.tag]
                others(self.reading, child, (*known, *(_KEPT_OF_LIMIT if child.tag == "limit" else ())), ())
                kept = [self._text(one, node) for one in child.children if one.tag not in known]
                rest += [wrapped(child.tag, kept)] if kept else []
            elif child.tag.endswith("mimic"):
                self._mimic(child, node, entry)
            elif child.tag == "initial_position" or child in more:
                rest.append(self._text(child, node))
        if rest:
            keep(entry, axis, wrapped("sdf", [wrapped("axis", rest)]))

    def _text(self, element: Element, node: Node) -> str:
        return text_of(element, node.scope, self.models)

    def _limit(self, name: str, entry: dict[str, Any], axis: Element | None, span: Span) -> None:
        """Set the limit; stand-ins take the place of what readers of other formats need and the SDF does not have."""
        limit = self.reading.single(axis, "limit") if axis is not None else None
        turns = entry["type"].value != "prismatic"
        unit = "rad" if turns else "m"
        found: dict[str, Placed] = {}
        for key, of in MOTION["limit"].items():
            number = self.numbers.limit(limit, key, of.format(q=unit, f=""))
            if number is not None and (key in ("lower", "upper") or number.value >= 0):
                found[key] = number
        ends = [key for key in ("lower", "upper") if key in found and (not turns or entry["type"].value == "revolute")]
        if turns:
            entry["type"] = entry["type"]._replace(value="revolute" if ends else "continuous")
        needed = ("lower", "upper", "effort", "velocity") if ends or not turns else ("effort", "velocity")
        if turns and not ends and not any(key in found for key in needed):
            return
        where = limit.span if limit is not None else span
        missing = [key for key in needed if key not in found]
        for key in missing:
            value = _STAND_INS[key]
            found[key] = Placed(f"{value} {unit}" if key in ("lower", "upper") else value, where)
            self.stand_ins.setdefault("range" if key in ("lower", "upper") else key, []).append((name, where))
        made: dict[str, Any] = {key: found[key] for key in needed}
        if missing:
            made["stand_ins"] = [Placed(key, where) for key in missing]
            note = f"{listed(missing)} {'is a stand-in' if len(missing) == 1 else 'are stand-ins'}: the SDF does not"
            note += f" limit {'it' if len(missing) == 1 else 'them'}"
            made["source"] = {"status": "stand_in", "note": note}
        entry["limit"] = Placed(made, where)
        if limit is not None:
            self.reading.paths.setdefault(id(limit), ("joints", name, "limit"))

    def _report_stand_ins(self) -> None:
        """Report the limits that the file does not have, and other formats get all the same."""
        for word, value in (("range", 1000), ("effort", 1000), ("velocity", 10)):
            entries = self.stand_ins.get(word, [])
            names = list(dict.fromkeys(name for name, _ in entries))
            if names:
                whose = f'joint "{names[0]}" has' if len(names) == 1 else f"{counted(len(names), 'joint')} have"
                which = f" ({first_of(names, 3)})" if len(names) > 1 else ""
                message = f"{whose} no {word} limit in the SDF{which}: {value} stands in where readers ask for one"
                help = "put in what the robot really has"
                self.reading.diagnostics.append(Diagnostic("import-stand-in", NOTE, message, entries[0][1], (), help))

    def _mimic(self, element: Element, node: Node, entry: dict[str, Any]) -> None:
        """Set whom a joint follows: position = multiplier * (leader - reference) + offset."""
        if element.tag != "mimic":
            converted(self.reading, "<drake:mimic> is said as a mimic: the same", element.span)
        attribute = element.attributes.get("joint")
        if attribute is None or not attribute.value:
            message = f"{named(element)} names no joint"
            self.reading.error("missing-attribute", message, element.span, 'add joint="..."')
            return
        leader = self.models.find(node.scope, attribute.value)
        if leader is None or leader.kind != JOINT:
            message = f'{named(element)} follows "{attribute.value}", which is no joint'
            joints = [one.name for one in node.scope.nodes.values() if one.kind == JOINT]
            help = Suggestion(attribute.value, joints, none="name a joint")
            if self.reading.lenient("mimic-unknown", message, attribute.span, help, "leaves the mimic out"):
                self.reading.cannot_carry(named(element), element.span)
            return
        found: dict[str, Placed] = {}
        for key in _OF_MIMIC:  # a child, or for Drake an attribute
            of_drake = element.attributes.get(key)
            if of_drake is None:
                number = self.numbers.one(element, key)
            else:
                texts = of_drake.words()
                value = self.numbers.number(element, texts[0], "") if len(texts) == 1 else None
                number = None if value is None else Placed(value, of_drake.span)
            if number is not None:
                found[key] = number
        called = f"{leader.called}_2" if element.get("axis", "axis") == "axis2" else leader.called
        made: dict[str, Any] = {"joint": Placed(called, attribute.span), **found}
        reference = float(made.pop("reference").value) if "reference" in made else 0.0
        if reference:
            factor, offset = (
                float(found[k].value) if k in found else d for k, d in (("multiplier", 1.0), ("offset", 0.0))
            )
            made["offset"] = Placed(cleaned(offset - factor * reference), element.span)
        entry["mimic"] = Placed(made, element.span)
        self.reading.check(element, _OF_MIMIC, ("joint", "axis", *_OF_MIMIC), None)

    def _rest(self, node: Node, entry: dict[str, Any]) -> None:
        """Keep what the language has no word for."""
        found = others(self.reading, node.element, (*_OF_JOINT, *OF_JOINT, *_UNUSED), ("name", "type"))
        for child in node.element.children:
            if child.tag in OF_JOINT:
                self.entries.gazebo.setdefault(node.called, []).append((child, self._text(child, node)))
            elif child.tag in _UNUSED:
                self.reading.ignored(f"<{child.tag}> has no effect on a joint of its type", child.span)
        if found:
            keep(entry, node.element, wrapped("sdf", [self._text(child, node) for child in found]))

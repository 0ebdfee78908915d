"""Import an SRDF: convert it to the sections ``moveit`` and ``poses``.

Elements that MoveIt ignores (``moveit/srdfdom@ros2:src/model.cpp``, ``moveit_core/robot_model``) are reported and left
out. A group can have only one chain in a description; further chains are converted to lists of joints.
"""

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from rosorin_compile.formats.format import ImportFile, SourceValue
from rosorin_compile.formats.xml_reader import ANGLES, LENGTHS, PLAIN, XmlReader, numbers
from rosorin_compile.language.lower import lower
from rosorin_compile.model import DisabledCollision, Output, Robot, Transform
from rosorin_compile.ros.sections.moveit import FIXED, FLOATING, PLANAR, Group, Moveit, Pair, VirtualJoint
from rosorin_compile.source.diagnostics import Diagnostic, Span, has_errors, nearest, quote
from rosorin_compile.source.tree import Map, Text
from rosorin_compile.source.wording import suggest
from rosorin_compile.source.xml.markup import Element, name_of

from .planning import URDF, PlanningModel, sort_pair

Entry = dict[str, Any]

# Attributes by element; the value is "link", "joint" or "group" if the attribute is a reference. MoveIt requires all
# except _OPTIONAL. Elements are read in this order: virtual joints and groups before elements that refer to them.
_KNOWN: Mapping[str, Mapping[str, str]] = {
    "virtual_joint": {"name": "", "type": "", "parent_frame": "", "child_link": ""},
    "group": {"name": ""},
    "group_state": {"name": "", "group": "group"},
    "end_effector": {"name": "", "parent_link": "link", "group": "group", "parent_group": ""},
    "passive_joint": {"name": "joint"},
    "disable_collisions": {"link1": "link", "link2": "link", "reason": ""},
    "enable_collisions": {"link1": "link", "link2": "link", "reason": ""},
    "disable_default_collisions": {"link": "link"},
    "link_sphere_approximation": {"link": "link"},
    "joint_property": {"joint_name": "joint", "property_name": "", "value": ""},
}
_OPTIONAL = ("parent_group", "reason")
_MEMBERS = ("joints", "links", "groups")  # keys of a planning group
_INSIDE: Mapping[str, Mapping[str, Mapping[str, str]]] = {
    "group": {
        "chain": {"base_link": "link", "tip_link": "link"},
        "joint": {"name": "joint"},
        "link": {"name": "link"},
        "group": {"name": ""},
    },
    "group_state": {"joint": {"name": "joint", "value": ""}},
    "link_sphere_approximation": {"sphere": {"center": "", "radius": ""}},
}


@dataclass
class _State:
    """A state of a planning group; ``base`` is the pose of the base, set by the virtual joint, or None."""

    span: Span
    positions: dict[str, SourceValue] = field(default_factory=dict)
    base: Entry | None = None


def join(opened: ImportFile, tree: Map) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Convert an SRDF to sections for ``tree``, the description of the same robot; return (sections, diagnostics)."""
    robot, root = lower(tree).robot, opened.xml.root
    if robot is None:
        raise ValueError("the robot cannot be made")  # impossible: ``tree`` has no errors
    of_urdf = ("link", "joint", "material", "transmission")
    if other := next((child for child in root.children if child.tag in of_urdf), None):
        what = f"this is a URDF, not an SRDF: it has {name_of(other)}"
        raise opened.problem(what, other.span, help="name the SRDF; a URDF is what is imported")
    if macro := next((child for child in root.iter() if child.tag.startswith("xacro:")), None):
        what = f"this is a xacro, which is to be expanded first: it has <{macro.tag}>"
        raise opened.problem(what, macro.span, help=f"xacro {opened.path.name} > expanded.srdf")
    made = _Importer(opened, robot)
    made.read(root)
    poses = made.poses(tree.get("poses") or {})
    return {"moveit": made.moveit(), **({"poses": poses} if poses else {})}, made.reading.all_diagnostics()


class _Importer:
    def __init__(self, opened: ImportFile, robot: Robot) -> None:
        self.robot = robot
        self.reading = XmlReader(opened.options)
        self.planning = PlanningModel(robot, Output(URDF, URDF, ""))
        self.virtual: VirtualJoint | None = None
        self.virtual_entry: Any = False
        self.groups: dict[str, SourceValue] = {}
        self.states: dict[str, dict[str, _State]] = defaultdict(dict)
        self.sections: Entry = {}
        self.pairs: dict[str, dict[Pair, SourceValue]] = {"disable_collisions": {}, "enable_collisions": {}}

    def read(self, root: Element) -> None:
        self.reading.check(root, tuple(_KNOWN), ("name", "version"), None)
        if (name := root.attributes.get("name")) is not None and name.value.strip() != self.robot.name:
            help = f'the robot is "{self.robot.name}": is it another one? MoveIt wants the same name in both files'
            self.reading.cannot_carry(f'the name "{name.value}" of the SRDF', name.span, help)
        for tag, attributes in _KNOWN.items():
            for child in (one for one in root.children if one.tag == tag):
                if (words := self._words(child, attributes, _INSIDE.get(tag, ()))) is not None:
                    getattr(self, f"_{tag}")(child, *words)
            if tag == "group":
                self._remove_unusable_groups()

    def _words(
        self, element: Element, names: Mapping[str, str], tags: Collection[str] = ()
    ) -> list[SourceValue] | None:
        """Return the required attributes in the order of ``names``, or report the problem and return None."""
        before = len(self.reading.diagnostics)
        self.reading.check(element, tags, names, None)
        needed = [name for name in names if name not in _OPTIONAL]
        given = {name: one for name, one in element.attributes.items() if name in needed and one.value.strip()}
        words = {name: SourceValue(given[name].value.strip(), given[name].span) for name in needed if name in given}
        if missing := [name for name in needed if name not in given]:
            if not has_errors(self.reading.diagnostics[before:]):
                help = f"MoveIt passes over it: it has no {quote(missing, 5)}"
                self.reading.cannot_carry(name_of(element), element.span, help)
            return None
        exist = [self._exists(word, names[name], element) for name, word in words.items() if names[name]]
        return list(words.values()) if all(exist) else None

    def _children(self, element: Element) -> list[tuple[Element, list[SourceValue]]]:
        known = _INSIDE[element.tag]
        found = [(child, self._words(child, known[child.tag])) for child in element.children if child.tag in known]
        return [(child, words) for child, words in found if words is not None]

    def _exists(self, name: SourceValue, kind: str, element: Element) -> bool:
        joints = [*self.planning.joints, *([self.virtual.name] if self.virtual is not None else [])]
        known: Collection[str] = {"group": [*self.groups], "link": [*self.planning.links], "joint": joints}[kind]
        if name.value in known:
            return True
        near = nearest(name.value, known)
        help = f"MoveIt passes over it: the robot has no such {kind}" + (f"; {suggest(near)}" if near else "")
        is_it = element.tag == kind or element.get("name").strip() == name.value
        what = name_of(element) if is_it else f'{name_of(element)} of {kind} "{name.value}"'
        self.reading.cannot_carry(what, element.span if element.tag == "group_state" else name.span, help)
        return False

    def _virtual_joint(
        self, element: Element, name: SourceValue, kind: SourceValue, parent: SourceValue, child: SourceValue
    ) -> None:
        if self.virtual is not None or child.value != self.planning.root:
            help = f'MoveIt takes one whose child is the root, "{self.planning.root}"'
            self.reading.cannot_carry(name_of(element), element.span, help)
            return
        if (taken := kind.value.lower()) not in (FIXED, PLANAR, FLOATING):
            self.reading.cannot_carry(f'the type "{kind.value}" of {name_of(element)}', kind.span, "MoveIt takes fixed")
            taken = FIXED
        self.virtual = VirtualJoint(taken, parent.value, name.value)
        self.virtual_entry = {"name": name, "type": SourceValue(taken, kind.span), "parent": parent}

    def _group(self, element: Element, name: SourceValue) -> None:
        if name.value in self.groups:
            what, help = f"a second {name_of(element)}", "MoveIt uses the first of this name"
            self.reading.cannot_carry(what, element.span, help)
            return
        entry: Entry = {}
        for child, words in self._children(element):
            if child.tag != "chain":
                entry.setdefault(f"{child.tag}s", []).append(words[0])
                continue
            joints = [
                SourceValue(one.name, child.span) for one in self.planning.joints_between(*(w.value for w in words))
            ]
            if not joints:
                self.reading.ignore("a chain that begins and ends at one link has no joint", child.span)
            elif "chain" in entry:
                entry.setdefault("joints", []).extend(joints)
            else:
                entry["chain"] = SourceValue({"base": words[0], "tip": words[1]}, child.span)
        self.groups[name.value] = SourceValue(entry, name.span)

    def _remove_unusable_groups(self) -> None:
        """Remove and report groups that MoveIt ignores: groups without joints or with an unusable subgroup."""
        model = {}
        for name, (entry, _) in self.groups.items():
            chain = entry["chain"].value if "chain" in entry else None
            ends = chain and (chain["base"].value, chain["tip"].value)
            joints, links, groups = (tuple(one.value for one in entry.get(key, ())) for key in _MEMBERS)
            model[name] = Group(name, ends, joints, links, groups)
        moveit = Moveit(groups=tuple(model.values()), virtual_joint=self.virtual)
        self.planning = PlanningModel(replace(self.robot, moveit=moveit), self.planning.urdf)
        usable: set[str] = set()
        candidates = [one for one in model.values() if one.groups or self.planning.joints_in(one)]
        while more := {one.name for one in candidates if usable.issuperset(one.groups)} - usable:
            usable |= more
        for name, group in ((name, group) for name, group in model.items() if name not in usable):
            reason = "a group in it is left out" if group.groups else "it has no joint"
            reason = next((f'there is no group "{one}"' for one in group.groups if one not in model), reason)
            help = f"MoveIt leaves it out: {reason}"
            self.reading.cannot_carry(f'<group name="{name}">', self.groups.pop(name).span, help)

    def _group_state(self, element: Element, name: SourceValue, group: SourceValue) -> None:
        inside = self.planning.joints_in(self.planning.groups[group.value])
        state, before = _State(element.span), len(self.reading.diagnostics)
        for child, (joint, _) in self._children(element):
            if joint.value in inside:
                self._add_position(state, joint, child)
            else:
                help = "MoveIt passes over it: the joint is not in the group"
                self.reading.cannot_carry(name_of(child), child.span, help)
        if state.positions or state.base is not None:
            if name.value in self.states[group.value]:
                self.reading.ignore("of two states of a group with one name, the first has no effect", name.span)
            self.states[group.value][name.value] = state
        elif not has_errors(self.reading.diagnostics[before:]):
            self.reading.cannot_carry(name_of(element), element.span, "it places no joint")

    def _add_position(self, state: _State, name: SourceValue, element: Element) -> None:
        value, joint = element.attributes["value"], self.robot.joint.get(name.value)
        words = value.words()
        if joint is None:  # only the virtual joint is not a joint of the robot
            count = {PLANAR: 3, FLOATING: 7}.get(self.virtual.type if self.virtual else "", 0)
            found = numbers(element, "value", count, PLAIN, self.reading) if count else None
            if found is not None and count == 3:  # x, y, theta
                state.base = {"xyz": [*found[:2], 0.0], "rpy": [0.0, 0.0, found[2]]}
            elif found is not None:  # x, y, z and a quaternion x, y, z, w
                a, b, c, w = found[3:] if any(found[3:]) else (0.0, 0.0, 0.0, 1.0)
                rpy = Transform.of_quaternion((0.0, 0.0, 0.0), (w, a, b, c)).rpy()
                state.base = {"xyz": found[:3], "rpy": list(rpy)}
        elif joint.mimic is not None:
            self.reading.ignore("the value of a joint that follows another one has no effect", name.span)
        elif not joint.moves or len(words) != 1:
            help = f"the joint is {joint.type}" if not joint.moves else f"it has {len(words)} numbers"
            self.reading.cannot_carry(name_of(element), value.span, help)
        else:
            unit = LENGTHS if joint.type == "prismatic" else ANGLES
            if (number := self.reading.number(words[0], element, "value", unit, "size")) is not None:
                state.positions[name.value] = SourceValue(number, words[0].span)

    def _end_effector(self, element: Element, name: SourceValue, parent: SourceValue, group: SourceValue) -> None:
        above, entry = element.attributes.get("parent_group"), {"group": group, "parent": parent}
        carrier = above.value.strip() if above is not None else ""
        moves = self.planning.links_in(self.planning.groups[carrier]) if carrier in self.groups else set()
        if above is not None and carrier != group.value and parent.value in moves:
            entry["parent_group"] = SourceValue(carrier, above.span)
        elif above is not None:
            help = f'MoveIt looks for another group: this one does not move the link "{parent.value}"'
            self.reading.cannot_carry(f'the parent group "{carrier}" of {name_of(element)}', above.span, help)
        effectors = self.sections.setdefault("end_effectors", {})
        if name.value in effectors:
            self.reading.cannot_carry(f"a second {name_of(element)}", element.span)
        effectors.setdefault(name.value, SourceValue(entry, element.span))

    def _passive_joint(self, element: Element, name: SourceValue) -> None:
        names = self.sections.setdefault("passive_joints" if element.tag == "passive_joint" else "unchecked_links", [])
        names += [] if name.value in [one.value for one in names] else [name]

    _disable_default_collisions = _passive_joint

    def _disable_collisions(self, element: Element, *names: SourceValue) -> None:
        first, second = sorted(names, key=lambda name: str(name.value))
        pair, found = sort_pair((first.value, second.value)), self.pairs[element.tag]
        links, reason = SourceValue([first, second], element.span), element.attributes.get("reason")
        if pair in found or first.value == second.value:
            what = "a pair of one link, or a pair that is named a second time, has no effect"
            self.reading.ignore(what, element.span)
        elif element.tag == "enable_collisions":
            found[pair] = links
        else:
            why = SourceValue(DisabledCollision.reason, element.span)
            why = SourceValue(reason.value.strip(), reason.span) if reason and reason.value.strip() else why
            found[pair] = SourceValue({"links": links, "reason": why}, element.span)

    _enable_collisions = _disable_collisions

    def _link_sphere_approximation(self, element: Element, link: SourceValue) -> None:
        for child, _ in self._children(element):
            center = numbers(child, "center", 3, LENGTHS, self.reading)
            radius = numbers(child, "radius", 1, LENGTHS, self.reading)
            if center is None or radius is None:
                continue
            balls = self.sections.setdefault("spheres", {}).setdefault(link.value, SourceValue([], element.span)).value
            if radius[0] > 0:
                xyz = [SourceValue(value, span) for value, span in zip(center, center.value_spans, strict=True)]
                balls.append(
                    SourceValue({"xyz": xyz, "radius": SourceValue(radius[0], radius.value_spans[0])}, child.span)
                )

    def _joint_property(self, _: Element, joint: SourceValue, name: SourceValue, value: SourceValue) -> None:
        of_joint = self.sections.setdefault("joint_properties", {}).setdefault(joint.value, {})
        of_joint[name.value] = SourceValue(Text(value.value), value.span)

    def poses(self, taken: Mapping[str, Any]) -> Entry:
        """Convert states to poses with names that are not in ``taken``; merge states with equal names if possible."""
        made: Entry = {}
        names: dict[tuple[str, str], str] = {}
        of_groups = [(group, self.states.get(group, {})) for group in self.groups]
        for name in dict.fromkeys(name for _, states in of_groups for name in states):
            parts = {group: states[name] for group, states in of_groups if name in states}
            merged = self._merged(parts)
            for group, state in parts.items():
                free = name if merged is not None else f"{name}_{group}"
                while free in taken or (free in made and merged is None):
                    free += "_state"
                names[group, name], pose = free, merged or state
                base = {} if pose.base is None else {"base": pose.base}
                made[free] = SourceValue({"positions": dict(pose.positions), **base}, pose.span)
        for group, states in of_groups if made or taken else ():
            of_group = {name: names[group, name] for name in states}
            is_same = all(name == pose for name, pose in of_group.items())
            self.groups[group].value["states"] = list(of_group) if is_same else of_group
        return made

    def _merged(self, parts: Mapping[str, _State]) -> _State | None:
        """Merge the states of several groups, or return None if that would change the state of a group."""
        merged = _State(next(iter(parts.values())).span)
        for state in parts.values():
            merged.positions |= state.positions
            merged.base = merged.base or state.base
        for group, state in parts.items():
            inside = self.planning.joints_in(self.planning.groups[group])
            base = merged.base if self.virtual is not None and self.virtual.name in inside else None
            here = {name: at.value for name, at in merged.positions.items() if name in inside}
            if here != {name: at.value for name, at in state.positions.items()} or base != state.base:
                return None
        return merged

    def moveit(self) -> Entry:
        off, on = self.pairs["disable_collisions"], self.pairs["enable_collisions"]
        for pair in [pair for pair in on if pair in off]:
            what = "<enable_collisions> of links that are disabled as well has no effect"
            self.reading.ignore(what, on.pop(pair).span)
        entry: Entry = {"virtual_joint": self.virtual_entry} | ({"groups": self.groups} if self.groups else {})
        # In a description, mappings come before lists.
        entry |= dict(sorted(self.sections.items(), key=lambda one: isinstance(one[1], list)))
        for key, pairs in (("disabled_collisions", off), ("checked_collisions", on)):
            if pairs:
                entry[key] = [pairs[pair] for pair in sorted(pairs)]
        return entry

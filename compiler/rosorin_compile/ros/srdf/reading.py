"""An SRDF that somebody has, read beside the robot that it belongs to: it becomes the section ``moveit``, and poses.

MoveIt passes over what it does not know (``moveit/srdfdom@ros2:src/model.cpp``, ``moveit_core/robot_model``): a link
that the URDF lacks, a group without a joint, a state of another group. What it passes over is left out here, too, and
listed. What it reads is kept. Joints of a second chain of a group are named one by one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Joined, Opened, Placed
from rosorin_compile.formats.urdf.reading import ANGLES, LENGTHS, PLAIN, Reading, numbers
from rosorin_compile.language.lower import lower
from rosorin_compile.model import DisabledCollision, Output, Robot, Transform
from rosorin_compile.ros.moveit import FIXED, FLOATING, PLANAR, Group, Moveit, Pair, VirtualJoint
from rosorin_compile.source.diagnostics import Span, has_errors, nearest, quoted
from rosorin_compile.source.tree import Map, Text
from rosorin_compile.source.xml.markup import Element, correction, named

from .matrix import ordered
from .planning import URDF, Planning

Entry = dict[str, Any]

# The elements of a file, and what each has.
_KNOWN = {
    "group": ("name",),
    "group_state": ("name", "group"),
    "end_effector": ("name", "parent_link", "group", "parent_group"),
    "virtual_joint": ("name", "type", "parent_frame", "child_link"),
    "passive_joint": ("name",),
    "disable_collisions": ("link1", "link2", "reason"),
    "enable_collisions": ("link1", "link2", "reason"),
    "disable_default_collisions": ("link",),
    "link_sphere_approximation": ("link",),
    "joint_property": ("joint_name", "property_name", "value"),
}
_INSIDE = {
    "group": ("chain", "joint", "link", "group"),
    "group_state": ("joint",),
    "link_sphere_approximation": ("sphere",),
}
_ATTRIBUTES = {name for names in _KNOWN.values() for name in names} | {"base_link", "tip_link", "center", "radius"}
_OF_INSIDE = {
    "chain": ("base_link", "tip_link"),
    "joint": ("name", "value"),
    "link": ("name",),
    "group": ("name",),
    "sphere": ("center", "radius"),
}
_OF_URDF = ("link", "joint", "material", "transmission")
_WHOLE = ("name", "version")


class _State(NamedTuple):
    """A state of a group: where it puts joints, with the places, and the base if it does."""

    name: str
    positions: Mapping[str, Placed]
    base: Entry | None
    span: Span


def join(opened: Opened, tree: Map) -> Joined:
    """Return the sections that a file adds to a robot, and what there is to say about it."""
    robot = lower(tree).robot
    root = opened.xml.root
    if robot is None:
        raise ValueError("the robot cannot be made")  # it has been read without an error
    if any(child.tag in _OF_URDF for child in root.children):
        other = next(child for child in root.children if child.tag in _OF_URDF)
        what = f"this is a URDF, not an SRDF: it has {named(other)}"
        raise opened.problem(what, other.span, help="name the SRDF; a URDF is what is imported")
    macro = next((child for child in root.iter() if child.tag.startswith("xacro:")), None)
    if macro is not None:
        what = f"this is a xacro, which is to be expanded first: it has <{macro.tag}>"
        raise opened.problem(what, macro.span, help=f"xacro {opened.path.name} > expanded.srdf")
    made = _Joining(opened, robot)
    made.read(root)
    poses = made.poses(tree.get("poses") or {})
    moveit = made.moveit()
    sections = {"moveit": moveit, **({"poses": poses} if poses else {})}
    return Joined(sections, made.reading.all_diagnostics())


class _Joining:
    """One reading: what is taken of each element, in words of a description, each value with its place."""

    def __init__(self, opened: Opened, robot: Robot) -> None:
        self.opened = opened
        self.robot = robot
        self.reading = Reading(opened.options)
        self.planning = Planning(robot, Output(URDF, URDF, ""))
        self.virtual: VirtualJoint | None = None
        self.of_virtual: Any = False
        self.groups: dict[str, Entry] = {}
        self.spans: dict[str, Span] = {}
        self.states: dict[str, dict[str, _State]] = {}
        self.lists: dict[str, list[Any]] = {}
        self.named: dict[str, Entry] = {}
        self.pairs: dict[str, dict[Pair, Placed]] = {"disable_collisions": {}, "enable_collisions": {}}

    def read(self, root: Element) -> None:
        """Read the file: first what others name."""
        self.reading.check(root, tuple(_KNOWN), _WHOLE, None)
        name = root.attributes.get("name")
        if name is not None and name.value.strip() != self.robot.name:
            help = f'the robot is "{self.robot.name}": is it another one? MoveIt wants the same name in both files'
            self.reading.cannot_carry(f'the name "{name.value}" of the SRDF', name.span, help)
        for child in root.children:
            if child.tag in _KNOWN:
                self._known(child)
        self._each(root, "virtual_joint", self.virtual_joint)
        self._each(root, "group", self.group)
        self._settle_groups()
        for tag in _KNOWN:
            if tag not in ("virtual_joint", "group"):
                self._each(root, tag, getattr(self, tag))

    def _known(self, element: Element) -> None:
        tags = _INSIDE.get(element.tag, ())
        self.reading.check(element, tags, _KNOWN[element.tag], None)
        for child in element.children:
            if child.tag in tags:
                self.reading.check(child, (), _OF_INSIDE[child.tag], None)

    def _each(self, root: Element, tag: str, take: Callable[[Element], None]) -> None:
        for child in root.children:
            if child.tag == tag:
                take(child)

    # -- what several have

    def words(self, element: Element, *names: str) -> tuple[Placed, ...] | None:
        """Return attributes that have to be there; None after saying that one is not."""
        found = [element.attributes.get(name) for name in names]
        missing = [name for name, one in zip(names, found, strict=True) if one is None or not one.value.strip()]
        if missing:
            misspelt = any(correction(one, missing) for one in element.attributes if one not in _ATTRIBUTES)
            if not misspelt or self.reading.options.lenient:  # else that is what there is to say
                help = f"MoveIt passes over it: it has no {quoted(missing, 5)}"
                self.reading.cannot_carry(named(element), element.span, help)
            return None
        return tuple(Placed(one.value.strip(), one.span) for one in found if one is not None)

    def is_link(self, name: Placed, element: Element) -> bool:
        """Say whether the robot has a link; tell it if not."""
        if name.value in self.planning.links:
            return True
        self._unknown(element, name, "link", self.planning.links)
        return False

    def is_joint(self, name: Placed, element: Element) -> bool:
        """Say whether the robot has a joint, or it is the virtual one; tell it if not."""
        if name.value in self.planning.joints or (self.virtual is not None and self.virtual.name == name.value):
            return True
        self._unknown(element, name, "joint", self.planning.joints)
        return False

    def _unknown(self, element: Element, name: Placed, kind: str, known: Iterable[str]) -> None:
        near = nearest(name.value, known)
        help = f"MoveIt passes over it: the robot has no such {kind}"
        help += f'; did you mean "{near}"?' if near else ""
        self.reading.cannot_carry(self._what(element, name, kind), name.span, help)

    def _what(self, element: Element, name: Placed, kind: str) -> str:
        if element.tag == kind or element.get("name").strip() == name.value:
            return named(element)
        return f'{named(element)} of {kind} "{name.value}"'

    # -- elements

    def virtual_joint(self, element: Element) -> None:
        said = self.words(element, "name", "type", "parent_frame", "child_link")
        if said is None:
            return
        name, kind, parent, child = said
        if self.virtual is not None or child.value != self.planning.root:
            help = f'MoveIt takes one whose child is the root, "{self.planning.root}"'
            self.reading.cannot_carry(named(element), element.span, help)
            return
        taken = kind.value.lower()
        if taken not in (FIXED, PLANAR, FLOATING):
            self.reading.cannot_carry(f'the type "{kind.value}" of {named(element)}', kind.span, "MoveIt takes fixed")
            taken = FIXED
        self.virtual = VirtualJoint(taken, parent.value, name.value)
        self.of_virtual = {"name": name, "type": Placed(taken, kind.span), "parent": parent}

    def group(self, element: Element) -> None:
        said = self.words(element, "name")
        if said is None:
            return
        name = said[0].value
        if name in self.groups:
            help = "MoveIt takes the first of this name"
            self.reading.cannot_carry(f"a second {named(element)}", element.span, help)
            return
        entry: Entry = {}
        for child in element.children:
            if child.tag == "chain":
                self._chain(entry, child)
                continue
            one = self.words(child, "name") if child.tag in _INSIDE["group"] else None
            if one is None or (child.tag == "link" and not self.is_link(one[0], child)):
                continue
            if child.tag != "joint" or self.is_joint(one[0], child):
                entry.setdefault(f"{child.tag}s", []).append(one[0])
        self.groups[name], self.spans[name] = entry, said[0].span

    def _chain(self, entry: Entry, element: Element) -> None:
        said = self.words(element, "base_link", "tip_link")
        if said is None or not all(self.is_link(one, element) for one in said):
            return
        base, tip = said
        joints = self.planning.between(base.value, tip.value)
        if not joints:
            self.reading.ignored("a chain that begins and ends at one link has no joint", element.span)
        elif "chain" not in entry:
            entry["chain"] = Placed({"base": base, "tip": tip}, element.span)
        else:
            entry.setdefault("joints", []).extend(Placed(joint.name, element.span) for joint in joints)

    def _settle_groups(self) -> None:
        left = True
        while left:
            model = {name: _group(name, entry) for name, entry in self.groups.items()}
            said = Moveit(groups=tuple(model.values()), virtual_joint=self.virtual)
            self.planning.said, self.planning.groups = said, model
            self.planning.__dict__.pop("virtual", None)
            left = False
            for name in _unsatisfied(model):
                lacking = next((one for one in model[name].groups if one not in model), "")
                why = f'there is no group "{lacking}"' if lacking else "its groups are in each other"
                self._leave_group(name, f"MoveIt leaves it out: {why}")
                left = True
            if left:
                continue
            for name, group in model.items():
                if not self.planning.joints_in(group):
                    self._leave_group(name, "MoveIt leaves it out: it has no joint")
                    left = True

    def _leave_group(self, name: str, why: str) -> None:
        self.reading.cannot_carry(f'<group name="{name}">', self.spans[name], why)
        del self.groups[name]

    def group_state(self, element: Element) -> None:
        said = self.words(element, "name", "group")
        if said is None:
            return
        name, group = said
        if group.value not in self.groups:
            what = f'{named(element)} of group "{group.value}"'
            self.reading.cannot_carry(what, element.span, "there is no such group")
            return
        inside = set(self.planning.joints_in(self.planning.groups[group.value]))
        state, said_before = _State(name.value, {}, None, element.span), len(self.reading.diagnostics)
        for child in element.children:
            one = self.words(child, "name", "value") if child.tag == "joint" else None
            if one is None or not self.is_joint(one[0], child):
                continue
            if one[0].value not in inside:
                help = "MoveIt passes over it: the joint is not in the group"
                self.reading.cannot_carry(named(child), child.span, help)
            else:
                state = self._placed(state, one[0], child)
        if not state.positions and state.base is None:
            if not has_errors(self.reading.diagnostics[said_before:]):
                self.reading.cannot_carry(named(element), element.span, "it places no joint")
            return
        if name.value in self.states.setdefault(group.value, {}):
            self.reading.ignored("of two states of a group with one name, the first has no effect", name.span)
        self.states[group.value][name.value] = state

    def _placed(self, state: _State, name: Placed, element: Element) -> _State:
        value = element.attributes["value"]
        joint = self.robot.joint.get(name.value)
        if joint is None:
            count = {PLANAR: 3, FLOATING: 7}.get(self.virtual.type if self.virtual else "", 0)
            found = numbers(element, "value", count, PLAIN, self.reading) if count else None
            return state if found is None else state._replace(base=_base(found))
        words = value.words()
        if joint.mimic is not None:
            self.reading.ignored("the value of a joint that follows another one has no effect", name.span)
        elif not joint.moves or len(words) != 1:
            help = f"the joint is {joint.type}" if not joint.moves else f"it has {len(words)} numbers"
            self.reading.cannot_carry(named(element), value.span, help)
        else:
            unit = LENGTHS if joint.type == "prismatic" else ANGLES
            number = self.reading.number(words[0], f"value of {named(element)}", unit, "size")
            if number is not None:
                at = Placed(number, words[0].span)
                return state._replace(positions={**state.positions, name.value: at})
        return state

    def end_effector(self, element: Element) -> None:
        said = self.words(element, "name", "parent_link", "group")
        if said is None or not self.is_link(said[1], element):
            return
        name, parent, group = said
        if group.value not in self.groups:
            self.reading.cannot_carry(named(element), group.span, f'there is no group "{group.value}"')
            return
        above = element.attributes.get("parent_group")
        entry: Entry = {"group": group, "parent": parent}
        if above is not None and self._may_carry(element, parent.value, group.value, above.value.strip()):
            entry["parent_group"] = Placed(above.value.strip(), above.span)
        if name.value in self.named.setdefault("end_effectors", {}):
            self.reading.cannot_carry(f"a second {named(element)}", element.span)
            return
        self.named["end_effectors"][name.value] = Placed(entry, element.span)

    def _may_carry(self, element: Element, parent: str, group: str, above: str) -> bool:
        why = ""
        if above not in self.groups:
            why = "there is no such group"
        elif above == group:
            why = "it is the group of the end effector"
        elif parent not in self.planning.links_in(self.planning.groups[above]):
            why = f'it does not have the link "{parent}"'
        if why:
            what = f'the parent group "{above}" of {named(element)}'
            self.reading.cannot_carry(what, element.attributes["parent_group"].span, f"MoveIt looks for one: {why}")
        return not why

    def passive_joint(self, element: Element) -> None:
        said = self.words(element, "name")
        if said is not None and self.is_joint(said[0], element):
            self._listed("passive_joints", said[0])

    def disable_default_collisions(self, element: Element) -> None:
        said = self.words(element, "link")
        if said is not None and self.is_link(said[0], element):
            self._listed("unchecked_links", said[0])

    def _listed(self, key: str, one: Placed) -> None:
        if one.value not in [other.value for other in self.lists.setdefault(key, [])]:
            self.lists[key].append(one)

    def disable_collisions(self, element: Element) -> None:
        self._pair(element)

    enable_collisions = disable_collisions

    def _pair(self, element: Element) -> None:
        said = self.words(element, "link1", "link2")
        if said is None or not all(self.is_link(one, element) for one in said):
            return
        one, other = sorted(said, key=lambda name: str(name.value))
        pair, found = ordered((one.value, other.value)), self.pairs[element.tag]
        if one.value == other.value:
            self.reading.ignored("a link that is paired with itself has no effect", element.span)
        elif pair in found:
            self.reading.ignored("a pair of links that is named a second time has no effect", element.span)
        else:
            reason = element.attributes.get("reason")
            why = Placed(DisabledCollision.reason, element.span)
            if reason is not None and reason.value.strip():
                why = Placed(reason.value.strip(), reason.span)
            links = Placed([one, other], element.span)
            is_off = element.tag == "disable_collisions"
            found[pair] = Placed({"links": links, "reason": why}, element.span) if is_off else links

    def link_sphere_approximation(self, element: Element) -> None:
        said = self.words(element, "link")
        if said is None or not self.is_link(said[0], element):
            return
        balls: list[Any] = []
        nothing = True
        for child in element.children:
            if child.tag != "sphere" or self.words(child, "center", "radius") is None:
                continue
            center = numbers(child, "center", 3, LENGTHS, self.reading)
            radius = numbers(child, "radius", 1, LENGTHS, self.reading)
            if center is None or radius is None:
                continue
            nothing = False
            if radius[0] > 0:
                xyz = [Placed(value, span) for value, span in zip(center, center.value_spans, strict=True)]
                balls.append(Placed({"xyz": xyz, "radius": Placed(radius[0], radius.value_spans[0])}, child.span))
        if not nothing:
            self.named.setdefault("spheres", {})[said[0].value] = Placed(balls, element.span)

    def joint_property(self, element: Element) -> None:
        said = self.words(element, "joint_name", "property_name", "value")
        if said is not None and self.is_joint(said[0], element):
            joint, name, value = said
            of_joint = self.named.setdefault("joint_properties", {}).setdefault(joint.value, {})
            of_joint[name.value] = Placed(Text(value.value), value.span)

    # -- what comes of it

    def poses(self, taken: Mapping[str, Any]) -> Entry:
        """Return the states as poses, one for states of one name that agree; groups get their ``states``."""
        made: Entry = {}
        by_name: dict[str, list[tuple[str, _State]]] = {}
        for group in self.groups:
            for name, state in self.states.get(group, {}).items():
                by_name.setdefault(name, []).append((group, state))
        names: dict[tuple[str, str], str] = {}
        for name, several in by_name.items():
            together = self._together(several)
            for group, state in several:
                wanted = name if together is not None else f"{name}_{group}"
                while wanted in taken or (wanted in made and together is None):
                    wanted += "_state"
                names[group, name] = wanted
                made[wanted] = _pose(together or state)
        for group, entry in self.groups.items():
            of_group = {name: names[group, name] for name in self.states.get(group, {})}
            if made or taken:
                entry["states"] = list(of_group) if all(k == v for k, v in of_group.items()) else of_group
        return made

    def _together(self, several: list[tuple[str, _State]]) -> _State | None:
        positions: dict[str, Placed] = {}
        for _, state in several:
            positions |= state.positions
        bases = [state.base for _, state in several]
        base = next((one for one in bases if one is not None), None)
        for group, state in several:
            inside = self.planning.joints_in(self.planning.groups[group])
            whole = {name: at.value for name, at in positions.items() if name in inside}
            if whole != {name: at.value for name, at in state.positions.items()}:
                return None
            with_base = self.virtual is not None and self.virtual.name in inside
            if (base if with_base else None) != state.base:
                return None
        first = several[0][1]
        return _State(first.name, positions, base, first.span)

    def moveit(self) -> Entry:
        """Return the section."""
        entry: Entry = {"virtual_joint": self.of_virtual}
        if self.groups:
            entry["groups"] = {name: Placed(one, self.spans[name]) for name, one in self.groups.items()}
        off, on = self.pairs["disable_collisions"], self.pairs["enable_collisions"]
        for pair in [pair for pair in on if pair in off]:
            self.reading.ignored(
                "<enable_collisions> of links that are disabled as well has no effect", on.pop(pair).span
            )
        entry |= self.named | self.lists
        if off:
            entry["disabled_collisions"] = [off[pair] for pair in sorted(off)]
        if on:
            entry["checked_collisions"] = [on[pair] for pair in sorted(on)]
        return entry


def _group(name: str, entry: Entry) -> Group:
    chain = entry["chain"].value if "chain" in entry else None
    joints, links, groups = (tuple(one.value for one in entry.get(key, ())) for key in ("joints", "links", "groups"))
    return Group(name, chain and (chain["base"].value, chain["tip"].value), joints, links, groups)


def _unsatisfied(groups: Mapping[str, Group]) -> list[str]:
    known: set[str] = set()
    while True:
        more = {name for name, group in groups.items() if name not in known and known.issuperset(group.groups)}
        if not more:
            return [name for name in groups if name not in known]
        known |= more


def _base(found: list[float]) -> Entry:
    if len(found) == 3:
        x, y, theta = found
        return {"xyz": [x, y, 0.0], "rpy": [0.0, 0.0, theta]}
    x, y, z, *rotation = found
    if not any(rotation):
        rotation = [0.0, 0.0, 0.0, 1.0]
    a, b, c, w = rotation
    return {"xyz": [x, y, z], "rpy": list(Transform.of_quaternion((0.0, 0.0, 0.0), (w, a, b, c)).rpy())}


def _pose(state: _State) -> Placed:
    base = {} if state.base is None else {"base": state.base}
    return Placed({"positions": dict(state.positions), **base}, state.span)

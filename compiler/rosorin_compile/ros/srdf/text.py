"""The SRDF of a robot: what it is meant to contain, its text, and what such a text contains.

It speaks of the links and joints of one URDF. Rules of the readers: ``ros-planning/srdfdom`` and
``moveit/moveit2@{humble,jazzy}:moveit_core/robot_model``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model import DisabledCollision, Output, Pose, Robot
from rosorin_compile.model.robot import JointPose
from rosorin_compile.ros.moveit import FIXED, PLANAR, Ball, Group
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, error, first_of
from rosorin_compile.source.numbers import NumberFormat, number_format, vector
from rosorin_compile.source.rule_registry import Heading, declare
from rosorin_compile.source.xml.elements import number_of, numbers_of, tree_of

from .matrix import RENEW, ordered, stale_pairs, stale_text
from .planning import Planning, planning_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

RULES = declare(
    Heading.FORMATS,
    {
        "srdf-without-urdf": "An SRDF belongs to a URDF, and the robot has none among its outputs, or none of that "
        "name. Fix: Add `urdf` to `outputs`; `urdf` of `moveit` names one of several.",
        "srdf-cannot-say": "A note: a pair of links that are not to collide is not in the URDF, so that the SRDF "
        "leaves it out. Fix: Nothing, if that is meant. `frames: all` of a URDF has every link.",
    },
)

Entries = Mapping[str, Mapping[str, Any]]
_NOTHING = Ball((0.0, 0.0, 0.0), 0.0)  # of a link that touches nothing


@dataclass(frozen=True)
class Srdf:
    """What an SRDF contains: things by name, and pairs of links as texts ("arm - base")."""

    group: Entries = field(default_factory=dict)
    state: Entries = field(default_factory=dict)
    end_effector: Entries = field(default_factory=dict)
    virtual_joint: Entries = field(default_factory=dict)
    joint: Entries = field(default_factory=dict)
    link: Entries = field(default_factory=dict)
    passive_joints: frozenset[str] = frozenset()
    links_without_collisions: frozenset[str] = frozenset()
    disabled_collisions: frozenset[str] = frozenset()
    checked_collisions: frozenset[str] = frozenset()


def view(robot: Robot, output: Output) -> Srdf:  # noqa: ARG001
    """Return what the SRDF of a robot is meant to contain."""
    planning = planning_of(robot)
    if planning is None:
        return Srdf()
    said, virtual = planning.said, planning.virtual
    groups = {
        one.name: {"chain": " to ".join(one.chain or ()), "joint": one.joints, "link": one.links, "group": one.groups}
        for one in said.groups
    }
    ends = {
        one.name: {"group": one.group, "parent link": one.parent, "parent group": one.parent_group}
        for one in said.end_effectors
    }
    states = {
        f"{state} of {group.name}": dict(_positions(planning, group, pose))
        for group in said.groups
        for state, pose in planning.states(group).items()
    }
    joints = {
        name: {f"property {key}": value for key, value in of.items()}
        for name, of in planning.joint_properties().items()
    }
    balls = {
        link: {"spheres": tuple((*ball.xyz, ball.radius) for ball in some or (_NOTHING,))}
        for link, some in said.spheres.items()
    }
    virtual_joint = {"parent frame": virtual.parent, "type": virtual.type} if virtual is not None else {}
    return Srdf(
        groups,
        states,
        ends,
        {virtual.name: {**virtual_joint, "child link": planning.root}} if virtual is not None else {},
        joints,
        balls,
        frozenset(said.passive_joints),
        frozenset(said.unchecked_links),
        frozenset(f"{' - '.join(one.links)} ({one.reason})" for one in planning.disabled()),
        frozenset(" - ".join(ordered(pair)) for pair in said.checked),
    )


def _positions(planning: Planning, group: Group, pose: JointPose) -> Iterator[tuple[str, float | tuple[float, ...]]]:
    """Yield where a state puts the joints of a group, and the base if the virtual joint is in the group.

    MoveIt counts the numbers of a virtual joint as x y theta, or as x y z and a quaternion x y z w.
    """
    virtual = planning.virtual
    for joint in planning.joints_in(group):
        if joint in pose.positions:
            yield joint, pose.positions[joint]
        elif virtual is not None and joint == virtual.name and pose.base is not None and virtual.type != FIXED:
            yield joint, _base(virtual.type, pose.base)


def _base(kind: str, base: Pose) -> tuple[float, ...]:
    if kind == PLANAR:
        return (*base.xyz[:2], base.rpy[2])
    w, x, y, z = base.transform().quaternion()
    return (*base.xyz, x, y, z, w)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the SRDF of a robot. Option: ``number_format`` (short, exact or six)."""
    planning = planning_of(robot)
    if planning is None:
        message = f"{output.file} belongs to a URDF, and the robot has none among its outputs"
        return "", [error("srdf-without-urdf", message, None, "add urdf: {file: NAME.urdf} to outputs")]
    head = f"Generated by rosorin-compile from the description of {comment(robot.name)}; edits here are lost."
    lines = ['<?xml version="1.0"?>', f"<!-- {head} -->", f"<!-- It belongs to {comment(planning.urdf.file)}. -->"]
    lines += [f"<robot{attributes(name=robot.name)}>", *_elements(planning, number_format(output.options)), "</robot>"]
    return "\n".join(lines) + "\n", [*_stale_meshes(planning), *_left_out(planning)]


def _tag(tag: str, inside: Sequence[tuple[str, Mapping[str, str]]] | None = None, /, **values: str) -> Iterator[str]:
    """Yield the lines of an element; with ``inside`` it has elements, by tag and attributes."""
    if inside is None:
        yield f"  <{tag}{attributes(**values)}/>"
        return
    yield f"  <{tag}{attributes(**values)}>"
    yield from (f"    <{name}{attributes(**of)}/>" for name, of in inside)
    yield f"  </{tag}>"


def _elements(planning: Planning, number: NumberFormat) -> Iterator[str]:
    said, virtual = planning.said, planning.virtual
    for group in said.groups:
        base, tip = group.chain or ("", "")
        inside = [("chain", {"base_link": base, "tip_link": tip})] if group.chain is not None else []
        for tag, names in (("joint", group.joints), ("link", group.links), ("group", group.groups)):
            inside += [(tag, {"name": name}) for name in names]
        yield from _tag("group", inside, name=group.name)
    for group in said.groups:
        for state, pose in planning.states(group).items():
            inside = []
            for joint, value in _positions(planning, group, pose):
                if isinstance(value, tuple):  # lengths, then a rotation
                    split = 2 if len(value) == 3 else 3
                    text = f"{vector(value[:split], number)} {vector(value[split:], number)}"
                else:
                    text = number(value)
                inside.append(("joint", {"name": joint, "value": text}))
            yield from _tag("group_state", inside, name=state, group=group.name)
    for one in said.end_effectors:
        more = {"parent_group": one.parent_group} if one.parent_group else {}
        yield from _tag("end_effector", name=one.name, parent_link=one.parent, group=one.group, **more)
    if virtual is not None:
        ends = {"parent_frame": virtual.parent, "child_link": planning.root}
        yield from _tag("virtual_joint", name=virtual.name, type=virtual.type, **ends)
    for joint, properties in planning.joint_properties().items():
        for name, text in properties.items():
            yield from _tag("joint_property", joint_name=joint, property_name=name, value=text)
    for name in said.passive_joints:
        yield from _tag("passive_joint", name=name)
    for link, balls in said.spheres.items():
        inside = [
            ("sphere", {"center": vector(ball.xyz, number), "radius": number(ball.radius)})
            for ball in balls or (_NOTHING,)
        ]
        yield from _tag("link_sphere_approximation", inside, link=link)
    for link in said.unchecked_links:
        yield from _tag("disable_default_collisions", link=link)
    for first, second in sorted(map(ordered, said.checked)):
        yield from _tag("enable_collisions", link1=first, link2=second)
    if said.matrix is not None:
        states = f"{counted(said.matrix.states, 'random state')}, seed {said.search.seed}"
        remark = f"Computed by rosorin-compile collisions: {states}. Lengths are the smallest distances of the states"
        yield f"  <!-- {comment(f'{remark} that were tried.')} -->"
    for pair in planning.disabled():
        remark = ""
        if pair.nearest is not None:
            remark = f"{abs(pair.nearest) * 1000:.1f} mm{' deep' if pair.nearest < 0 else ''}"
        elif pair.beyond is not None:
            remark = f"more than {pair.beyond * 1000:.4g} mm"
        (line,) = _tag("disable_collisions", link1=pair.links[0], link2=pair.links[1], reason=pair.reason)
        yield f"{line} <!-- {comment(remark)} -->" if remark else line


def _stale_meshes(planning: Planning) -> Iterator[Diagnostic]:
    """Yield a warning about pairs whose mesh files changed; ``checks`` has the rule about all else."""
    pairs, meshes = stale_pairs(planning)
    if meshes and pairs:
        message = f"{first_of(meshes, 3)} changed since the collision matrix was computed: {stale_text(pairs)}"
        yield Diagnostic("collisions-stale", WARNING, message, help=RENEW)


def _left_out(planning: Planning) -> Iterator[Diagnostic]:
    """Yield a note on pairs that are not to collide, of links that the URDF lacks and not just simulations have."""
    simulated = {joint.child for joint in planning.robot.joints if joint.publisher.simulated}
    pairs = [
        " and ".join(pair)
        for pair in planning.robot.disabled_contacts
        if simulated.isdisjoint(pair) and not planning.links.issuperset(pair)
    ]
    if pairs:
        message = f"not in the SRDF, because {planning.urdf.file} has not both links: disabled contacts of "
        yield Diagnostic("srdf-cannot-say", NOTE, message + first_of(pairs, 3))


def read(text: str) -> Srdf:
    """Return what an SRDF that ``write`` made contains. Raises ValueError if it is damaged."""
    root = tree_of(text)
    if root.tag != "robot":
        raise ValueError(f"the root element is {root.tag}, not robot")
    entries: dict[str, dict[str, dict[str, Any]]] = defaultdict(lambda: defaultdict(dict))
    sets: dict[str, set[str]] = defaultdict(set)
    for element in root:
        _read_element(element, entries, sets)
    return Srdf(**entries, **{name: frozenset(found) for name, found in sets.items()})  # type: ignore[arg-type]


def _text(element: Element, attribute: str) -> str:
    value = element.get(attribute)
    if value is None:
        raise ValueError(f"<{element.tag}> has no {attribute}")
    return value


def _read_element(element: Element, entries: dict[str, dict[str, dict[str, Any]]], sets: dict[str, set[str]]) -> None:
    tag = element.tag
    if tag == "group":
        entry: dict[str, Any] = {"chain": "", "joint": (), "link": (), "group": ()}
        for inner in element:
            if inner.tag == "chain":
                entry["chain"] = f"{_text(inner, 'base_link')} to {_text(inner, 'tip_link')}"
            else:
                entry[inner.tag] = (*entry.get(inner.tag, ()), _text(inner, "name"))
        entries["group"][_text(element, "name")] = entry
    elif tag == "group_state":
        entry = entries["state"][f"{_text(element, 'name')} of {_text(element, 'group')}"]
        for inner in element:
            value = _text(inner, "value")
            entry[_text(inner, "name")] = numbers_of(value) if " " in value else number_of(value)
    elif tag == "end_effector":
        words = ("group", "parent_link", "parent_group")
        entries[tag][_text(element, "name")] = {word.replace("_", " "): element.get(word, "") for word in words}
    elif tag == "virtual_joint":
        words = ("type", "parent_frame", "child_link")
        entries[tag][_text(element, "name")] = {word.replace("_", " "): _text(element, word) for word in words}
    elif tag == "joint_property":
        entry = entries["joint"][_text(element, "joint_name")]
        entry[f"property {_text(element, 'property_name')}"] = _text(element, "value")
    elif tag == "link_sphere_approximation":
        balls = ((*numbers_of(_text(one, "center"), 3), number_of(_text(one, "radius"))) for one in element)
        entries["link"][_text(element, "link")] = {"spheres": tuple(balls)}
    elif tag in ("disable_collisions", "enable_collisions"):
        pair = " - ".join(sorted((_text(element, "link1"), _text(element, "link2"))))
        if tag == "enable_collisions":
            sets["checked_collisions"].add(pair)
        else:
            sets["disabled_collisions"].add(f"{pair} ({element.get('reason', DisabledCollision.reason)})")
    elif tag == "passive_joint":
        sets["passive_joints"].add(_text(element, "name"))
    elif tag == "disable_default_collisions":
        sets["links_without_collisions"].add(_text(element, "link"))

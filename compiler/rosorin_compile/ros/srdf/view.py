"""What an SRDF contains: what it is meant to contain, and what a text contains."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import DisabledCollision, Output, Robot
from rosorin_compile.ros.moveit import FIXED
from rosorin_compile.source.xml.elements import number_of, numbers_of, tree_of

from .matrix import ordered
from .planning import Planning, planning_of
from .write import NOTHING, base_position

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

Entries = Mapping[str, Mapping[str, Any]]


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
    joints = {} if virtual is None else {virtual.name: _virtual(virtual.type, virtual.parent, planning.root)}
    balls = {
        link: {"spheres": tuple((*ball.xyz, ball.radius) for ball in some or (NOTHING,))}
        for link, some in said.spheres.items()
    }
    return Srdf(
        groups,
        _states(planning),
        ends,
        joints,
        {
            name: {f"property {key}": value for key, value in of.items()}
            for name, of in planning.joint_properties().items()
        },
        balls,
        frozenset(said.passive_joints),
        frozenset(said.unchecked_links),
        frozenset(f"{' - '.join(one.links)} ({one.reason})" for one in planning.disabled()),
        frozenset(" - ".join(ordered(pair)) for pair in said.checked),
    )


def _virtual(kind: str, parent: str, child: str) -> dict[str, str]:
    return {"type": kind, "parent frame": parent, "child link": child}


def _states(planning: Planning) -> Entries:
    found: dict[str, dict[str, Any]] = {}
    virtual = planning.virtual
    for group in planning.said.groups:
        for state, pose in planning.states(group).items():
            entry = found.setdefault(f"{state} of {group.name}", {})
            for joint in planning.joints_in(group):
                if joint in pose.positions:
                    entry[joint] = pose.positions[joint]
                elif virtual is not None and joint == virtual.name and pose.base is not None and virtual.type != FIXED:
                    entry[joint] = base_position(virtual.type, pose.base)
    return found


def read(text: str) -> Srdf:
    """Return what an SRDF contains. Raises ValueError if it is damaged."""
    root = tree_of(text)
    if root.tag != "robot":
        raise ValueError(f"the root element is {root.tag}, not robot")
    entries: dict[str, dict[str, dict[str, Any]]] = defaultdict(lambda: defaultdict(dict))
    sets: dict[str, set[str]] = defaultdict(set)
    for element in root:
        if element.tag in _READERS:
            _READERS[element.tag](element, entries, sets)
    return Srdf(**entries, **{name: frozenset(found) for name, found in sets.items()})  # type: ignore[arg-type]


def _text(element: Element, attribute: str) -> str:
    value = element.get(attribute)
    if value is None:
        raise ValueError(f"<{element.tag}> has no {attribute}")
    return value


def _group(element: Element, entries: Any, _: Any) -> None:
    entry: dict[str, Any] = {"chain": "", "joint": (), "link": (), "group": ()}
    for inner in element:
        if inner.tag == "chain":
            entry["chain"] = f"{_text(inner, 'base_link')} to {_text(inner, 'tip_link')}"
        else:
            entry[inner.tag] = (*entry.get(inner.tag, ()), _text(inner, "name"))
    entries["group"][_text(element, "name")] = entry


def _state(element: Element, entries: Any, _: Any) -> None:
    entry = entries["state"][f"{_text(element, 'name')} of {_text(element, 'group')}"]
    for inner in element:
        value = _text(inner, "value")
        entry[_text(inner, "name")] = numbers_of(value) if " " in value else number_of(value)


def _end_effector(element: Element, entries: Any, _: Any) -> None:
    words = ("group", "parent_link", "parent_group")
    entries["end_effector"][_text(element, "name")] = {word.replace("_", " "): element.get(word, "") for word in words}


def _virtual_joint(element: Element, entries: Any, _: Any) -> None:
    values = (_text(element, word) for word in ("type", "parent_frame", "child_link"))
    entries["virtual_joint"][_text(element, "name")] = _virtual(*values)


def _property(element: Element, entries: Any, _: Any) -> None:
    entry = entries["joint"][_text(element, "joint_name")]
    entry[f"property {_text(element, 'property_name')}"] = _text(element, "value")


def _spheres(element: Element, entries: Any, _: Any) -> None:
    balls = ((*numbers_of(_text(one, "center"), 3), number_of(_text(one, "radius"))) for one in element)
    entries["link"][_text(element, "link")] = {"spheres": tuple(balls)}


def _disabled(element: Element, _: Any, sets: Any) -> None:
    sets["disabled_collisions"].add(f"{_pair(element)} ({element.get('reason', DisabledCollision.reason)})")


def _pair(element: Element) -> str:
    return " - ".join(sorted((_text(element, "link1"), _text(element, "link2"))))


_READERS: Mapping[str, Callable[[Element, Any, Any], object]] = {
    "group": _group,
    "group_state": _state,
    "end_effector": _end_effector,
    "virtual_joint": _virtual_joint,
    "joint_property": _property,
    "link_sphere_approximation": _spheres,
    "disable_collisions": _disabled,
    "enable_collisions": lambda element, _, sets: sets["checked_collisions"].add(_pair(element)),
    "passive_joint": lambda element, _, sets: sets["passive_joints"].add(_text(element, "name")),
    "disable_default_collisions": lambda element, _, sets: sets["links_without_collisions"].add(_text(element, "link")),
}

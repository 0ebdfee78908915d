"""The SRDF format: write the SRDF of a robot, and parse an SRDF to compare it with the robot.

Sources: ``ros-planning/srdfdom``, ``moveit/moveit2@{humble,jazzy}:moveit_core/robot_model``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.format import NUMBER_FORMAT, Format, OutputEntry, Unsupported, xml_syntax
from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model import DisabledCollision, Output, Robot
from rosorin_compile.model.robot import JointPose
from rosorin_compile.ros.sections.moveit import FIXED, PLANAR, Ball, Group
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, count_of, first_of
from rosorin_compile.source.numbers import number_format, vector
from rosorin_compile.source.xml.elements import number_of, numbers_of, tree_of

from . import checks, importer
from .planning import PlanningModel, planning_model, sort_pair, stale_text

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.source.xml.markup import Document

Entries = Mapping[str, Mapping[str, Any]]
_NOTHING = Ball((0.0, 0.0, 0.0), 0.0)  # the radius 0 means that the link has no collision shapes


@dataclass(frozen=True)
class Srdf:
    """The contents of an SRDF for comparison: elements by name, and link pairs as text such as "arm - base"."""

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
    """Return the contents of the SRDF of a robot, for comparison with an existing file."""
    if (planning := planning_model(robot)) is None:
        return Srdf()
    said, virtual = planning.said, planning.virtual
    entries: dict[str, dict[str, dict[str, Any]]] = defaultdict(dict)
    for group in said.groups:
        parts = {"joint": group.joints, "link": group.links, "group": group.groups}
        entries["group"][group.name] = {"chain": " to ".join(group.chain or ()), **parts}
        for state, pose in planning.states(group).items():
            entries["state"][f"{state} of {group.name}"] = dict(_positions(planning, group, pose))
    for one in said.end_effectors:
        entry = {"group": one.group, "parent link": one.parent, "parent group": one.parent_group}
        entries["end_effector"][one.name] = entry
    if virtual is not None:
        entry = {"parent frame": virtual.parent, "type": virtual.type, "child link": planning.root}
        entries["virtual_joint"][virtual.name] = entry
    for joint, properties in planning.joint_properties().items():
        entries["joint"][joint] = {f"property {key}": value for key, value in properties.items()}
    for link, balls in said.spheres.items():
        entries["link"][link] = {"spheres": tuple((*ball.xyz, ball.radius) for ball in balls or (_NOTHING,))}
    return Srdf(
        **entries,
        passive_joints=frozenset(said.passive_joints),
        links_without_collisions=frozenset(said.unchecked_links),
        disabled_collisions=frozenset(f"{' - '.join(one.links)} ({one.reason})" for one in planning.disabled_pairs()),
        checked_collisions=frozenset(" - ".join(sort_pair(pair)) for pair in said.checked),
    )


def _positions(
    planning: PlanningModel, group: Group, pose: JointPose
) -> Iterator[tuple[str, float | tuple[float, ...]]]:
    """Yield (joint, position); for a virtual joint, (x, y, theta) or (x, y, z, qx, qy, qz, qw) in m and rad."""
    virtual, base = planning.virtual, pose.base
    for joint in planning.joints_in(group):
        if joint in pose.positions:
            yield joint, pose.positions[joint]
        elif virtual is not None and joint == virtual.name and base is not None and virtual.type != FIXED:
            w, x, y, z = base.transform().quaternion()
            yield joint, (*base.xyz[:2], base.rpy[2]) if virtual.type == PLANAR else (*base.xyz, x, y, z, w)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return (text of the SRDF of a robot, diagnostics); the text is "" if the robot has no URDF output."""
    planning, number = planning_model(robot), number_format(output.options)
    if planning is None:
        message = f"{output.file} needs a URDF, but the robot has no output of this format"
        return "", [report("srdf-without-urdf", message)]
    said, computed = planning.said, ""
    if said.matrix is not None:
        states = f"{count_of(said.matrix.states, 'random state')}, seed {said.search.seed}"
        computed = f"Computed by rosorin-compile collisions: {states}. Lengths are the smallest distances of the "
        computed += "states that were tried."

    def value(at: float | tuple[float, ...]) -> str:
        if isinstance(at, float | int):
            return number(at)
        split = 2 if len(at) == 3 else 3  # the position has 2 or 3 numbers; the rest is the orientation
        return f"{vector(at[:split], number)} {vector(at[split:], number)}"

    values = {"name": robot.name, "planning": planning, "said": said, "attributes": attributes, "comment": comment}
    values |= {
        "positions": lambda group, pose: [(name, value(at)) for name, at in _positions(planning, group, pose)],
        "balls": {link: balls or (_NOTHING,) for link, balls in said.spheres.items()},
        "number": number,
        "vector": lambda values: vector(values, number),
        "checked": sorted(map(sort_pair, said.checked)),
        "computed": comment(computed),
        "distance": _distance,
    }
    text, notes = templates.own("ros/robot.srdf.jinja", values), []
    stale, meshes = planning.stale_pairs()
    if meshes and stale:  # the module ``checks`` reports other changes
        message = f"{first_of(meshes, 3)} changed since the collision matrix was computed: {stale_text(stale)}"
        notes.append(report("collisions-stale", message))
    simulated = {joint.child for joint in robot.joints if joint.publisher.simulated}
    contacts = [pair for pair in robot.disabled_contacts if simulated.isdisjoint(pair)]
    if lost := [" and ".join(pair) for pair in contacts if not planning.links.issuperset(pair)]:
        message = f"left out of the SRDF, because {planning.urdf.file} does not have both links: disabled contacts of "
        notes.append(report("srdf-cannot-say", message + first_of(lost, 3)))
    return text, notes


def _distance(pair: DisabledCollision) -> str:
    if pair.nearest is not None:
        return f"{abs(pair.nearest) * 1000:.1f} mm{' deep' if pair.nearest < 0 else ''}"
    return f"more than {pair.beyond * 1000:.4g} mm" if pair.beyond is not None else ""


def read(text: str) -> Srdf:
    """Parse an SRDF written by ``write``. Raises ValueError if it is damaged."""
    root = tree_of(text)
    if root.tag != "robot":
        raise ValueError(f"the root element is {root.tag}, not robot")
    entries: dict[str, dict[str, dict[str, Any]]] = defaultdict(lambda: defaultdict(dict))
    sets: dict[str, set[str]] = defaultdict(set)
    for element in root:
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
    return Srdf(**entries, **{name: frozenset(found) for name, found in sets.items()})  # type: ignore[arg-type]


def _text(element: Element, attribute: str) -> str:
    if (value := element.get(attribute)) is None:
        raise ValueError(f"<{element.tag}> has no {attribute}")
    return value


def _is_other(document: Document) -> bool:
    tags = {child.tag for child in document.root.children}
    return document.root.tag == "robot" and bool(tags & _OWN) and not tags & {"link", "joint"}


_OWN = {"group", "group_state", "end_effector", "virtual_joint", "disable_collisions", "passive_joint"}

_FINGERPRINT = Unsupported("tells whether the matrix is of this robot", quiet=True)
_UNSUPPORTED = {
    **{f"moveit.collision_matrix.{key}": _FINGERPRINT for key in ("of", "how", "shapes", "joints", "meshes")},
    "moveit.collisions": Unsupported("how the pairs are searched, by the command collisions", quiet=True),
    "moveit.urdf": Unsupported("the output whose links MoveIt loads", quiet=True),
}

FORMAT = Format(
    name="srdf",
    word="SRDF",
    article="an",
    about="what MoveIt needs to know in addition to the URDF",
    rank=25,
    covers=("robot", "moveit", "disabled_contacts", "poses.positions", "poses.pulses"),
    unsupported=_UNSUPPORTED,
    options={"number_format": NUMBER_FORMAT},
    file="{}.srdf",
    endings=(".srdf",),
    check=checks.check,
    write=write,
    view=view,
    read=read,
    join=importer.join,
    is_other=_is_other,
    asked=lambda tree, _, name: OutputEntry({"file": f"{name}.srdf"}) if "moveit" in tree else None,
    measures=True,
    syntax=xml_syntax,
    folder="srdf",
    deploys=True,
)

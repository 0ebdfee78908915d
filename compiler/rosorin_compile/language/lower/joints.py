"""Lower joints and sensors, and who publishes them: one node always, or several that take turns.

A sensor with a ``parent`` brings its frame and the joint to it. One without is on a link of the description, or on the
frame of another sensor; its optical frame may be one that fixed joints hold to it, and is made otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Link, Pose, Publisher, Sensor, Transform
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.joint import AXLELESS, ROBOT_STATE_PUBLISHER, UNPUBLISHED, SafetyController
from rosorin_compile.source.diagnostics import Help, Related, Suggestion
from rosorin_compile.source.rule_registry import FRAMES, Rule
from rosorin_compile.source.tree import Path

from ..suggestions import suggest_name
from .lowering import Lowering
from .records import pose_of_entry, record_of, source_of, vector_of
from .sensor_elements import Frames, gazebo_sensors, mjcf_elements

RULES = (Rule("sensor-frame", "The frame of a sensor without a `parent` is no link.", "Add the `parent`.", FRAMES),)
_OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)  # REP 103, "Suffix Frames": from a body frame to its image frame
_OF_THE_JOINT = ("joint", "xyz", "rpy", "publisher")
OF_THE_URDF = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
_IN_TURNS = Publisher(UNPUBLISHED, about="its publishers take turns")
# ros/kdl_parser knows no such joint, and ros/robot_state_publisher sends what kdl_parser finds.
_NOT_FLOATING = Publisher(UNPUBLISHED, about="robot_state_publisher publishes no floating joint")


class Turn(NamedTuple):
    """An entry of a list of publishers: a node, when it publishes, and where that is written."""

    publisher: Publisher
    when: str
    path: Path


class Publishing(NamedTuple):
    """Who publishes a joint: one always, and those that publish it in some modes.

    robot_state_publisher publishes its URDF in every mode, so it is never one of the turns.
    """

    always: Publisher
    turns: tuple[Turn, ...] = ()

    def of_optical(self) -> Publishing:
        """Return who publishes the optical frame by default: the same, but a static publisher needs a second node."""

        def second(node: Publisher) -> Publisher:
            is_static = node.kind == STATIC_TRANSFORM_PUBLISHER
            return Publisher(STATIC_TRANSFORM_PUBLISHER, f"{node.name}_optical") if is_static else node

        turns = tuple(turn._replace(publisher=second(turn.publisher)) for turn in self.turns)
        return Publishing(second(self.always), turns)


def lower_joint(lowering: Lowering, name: str, entry: Mapping[str, Any]) -> Joint:
    """Return a joint. Keys that are named like a field of ``Joint`` need nothing here."""
    path: Path = ("joints", name)
    lowering.place_joint(name, path, entry["child"], (*path, "child"))
    by = publishing(lowering, entry, path)
    safety = record_of(SafetyController, entry["safety_controller"]) if "safety_controller" in entry else None
    axis = vector_of(entry.get("axis"), (1.0, 0.0, 0.0))
    joint = record_of(Joint, entry, name=name, publisher=by.always, axis=axis, safety=safety)
    _take_turns(lowering, joint, by)
    return joint


def _take_turns(lowering: Lowering, joint: Joint, publishing: Publishing) -> None:
    for turn in publishing.turns:
        lowering.places["edge", str(len(lowering.edges))] = turn.path
        moving = not joint.is_fixed and turn.publisher.kind != STATIC_TRANSFORM_PUBLISHER
        edge = Edge(joint.parent, joint.child, turn.publisher, moving, turn.when, joint.origin)
        lowering.edges.append(replace(edge, source=joint.source, joint=joint.name))


def node(lowering: Lowering, name: str, path: Path) -> Publisher:
    """Return a node by the name that a description gives it; report an unknown name."""
    if name in lowering.nodes:
        return lowering.nodes[name]
    help: Help = Suggestion(name, [*lowering.nodes, ROBOT_STATE_PUBLISHER])
    if name == STATIC_TRANSFORM_PUBLISHER:
        help = f"write {{{name}: NODE_NAME}}: each is a node of its own"
    lowering("unknown-publisher", f'there is no publisher "{name}"', path, help)
    return OF_THE_URDF


def publishing(lowering: Lowering, entry: Mapping[str, Any], path: Path) -> Publishing:
    """Return who publishes the joint of the entry at a path."""
    requested, here = entry.get("publisher", ROBOT_STATE_PUBLISHER), (*path, "publisher")

    def publisher(value: Any, at: Path) -> Publisher:
        if isinstance(value, dict):
            if "none" in value or "simulation" in value:
                simulated = "none" not in value
                return Publisher(UNPUBLISHED, about=value["simulation" if simulated else "none"], simulated=simulated)
            return Publisher(STATIC_TRANSFORM_PUBLISHER, value[STATIC_TRANSFORM_PUBLISHER], "tf2_ros")
        if value == ROBOT_STATE_PUBLISHER:
            return _NOT_FLOATING if entry.get("type") in AXLELESS else OF_THE_URDF
        return node(lowering, value, at)

    if not isinstance(requested, list):
        return Publishing(publisher(requested, here))
    items = [(item, (*here, index)) for index, item in enumerate(requested)]
    turns = [Turn(publisher(item["by"], (*at, "by")), item.get("when", ""), at) for item, at in items]
    others = tuple(turn for turn in turns if turn.publisher.kind != ROBOT_STATE_PUBLISHER)
    return Publishing(_IN_TURNS if len(others) == len(turns) else OF_THE_URDF, others)


class _Above(NamedTuple):
    """What leads to a link: the name of the joint, its parent and pose (None if it moves), and where it is written."""

    joint: str
    parent: str
    pose: Pose | None
    path: Path


def lower_sensor(lowering: Lowering, name: str, entry: Mapping[str, Any]) -> Sensor:
    """Return a sensor, and add its frames and the fixed joints to them that do not exist yet."""
    path: Path = ("sensors", name)
    frame, source = entry["frame"], source_of(entry.get("source"))
    optical = entry.get("optical") or {}
    optical_frame = optical.get("frame", "")
    optical_pose = Pose(vector_of(optical.get("xyz")), vector_of(optical.get("rpy"), _OPTICAL_RPY))
    joint, parent, mount, by, existing = "", frame, IDENTITY, Publishing(OF_THE_URDF), None
    if "parent" in entry:
        joint, parent, mount = entry.get("joint", f"{frame}_joint"), entry["parent"], pose_of_entry(entry)
        lowering.place_joint(joint, path, frame, (*path, "frame"))
        by = publishing(lowering, entry, path)
        made = Joint(joint, "fixed", parent, frame, mount, publisher=by.always, source=source)
        lowering.joints.append(made)
        _take_turns(lowering, made, by)
    else:
        above = _above(lowering.tree, name)
        _check(lowering, name, entry, above)
        joint = above[frame].joint if frame in above else ""
        existing = _pose_in(frame, optical_frame, above) if optical else None
    frames = Frames(
        frame, mount, parent, optical_frame, joint, existing or optical_pose, turned=entry.get("optical") is False
    )
    stamps = () if by.always.simulated else (frame, optical_frame) if optical else (frame,)
    elements = mjcf_elements(lowering, name, entry, frames)
    stamps = tuple(entry.get("stamps", stamps))
    gazebo = gazebo_sensors(lowering, name, entry, frames)
    sensor = Sensor(name, entry["type"], frame, joint, optical_frame, source, elements, stamps, gazebo)
    if optical and existing is None:
        here, to_optical = (*path, "optical"), optical.get("joint", f"{optical_frame}_joint")
        lowering.place_joint(to_optical, here, optical_frame, (*here, "frame"))
        by = publishing(lowering, optical, here) if "publisher" in optical else by.of_optical()
        made = Joint(to_optical, "fixed", frame, optical_frame, optical_pose, publisher=by.always, source=source)
        lowering.joints.append(made)
        _take_turns(lowering, made, by)
    return sensor


def add_frames(lowering: Lowering, sensors: list[Sensor]) -> None:
    """Add a link for each frame of a sensor that ``links`` does not have."""
    for sensor in sensors:
        for frame, keys in ((sensor.frame, ("frame",)), (sensor.optical_frame, ("optical", "frame"))):
            if frame and ("link", frame) not in lowering.places:
                lowering.place("link", frame, ("sensors", sensor.name, *keys))
                lowering.links.append(Link(frame, source=sensor.source))


def _check(lowering: Lowering, name: str, entry: Mapping[str, Any], above: Mapping[str, _Above]) -> None:
    path: Path = ("sensors", name)
    frame, links = entry["frame"], lowering.tree.get("links") or {}
    if frame not in links and frame not in above:
        message = f'sensor "{name}" has no parent, and its frame "{frame}" is no link of the description'
        help = suggest_name(lowering.tree, (*path, "frame"), frame, list(dict.fromkeys((*links, *above))))
        lowering("sensor-frame", message, (*path, "frame"), help)
        return
    for key in _OF_THE_JOINT:
        if key in entry:
            message = f'sensor "{name}" sits on link "{frame}", which has a place of its own: {key} has no effect'
            at = lowering.tree.locate(above[frame].path, key=True).span if frame in above else None
            related = (Related("its place is said here", at),) if at else ()
            lowering("ignored-key", message, (*path, key), "remove it, or say the parent", related)


def _above(tree: Mapping[str, Any], name: str) -> dict[str, _Above]:
    """Return what leads to each link: a joint, or another sensor that brings its frame."""
    found: dict[str, _Above] = {}
    for joint, entry in (tree.get("joints") or {}).items():
        pose = pose_of_entry(entry) if entry["type"] == "fixed" else None
        found.setdefault(entry["child"], _Above(joint, entry["parent"], pose, ("joints", joint)))
    for other, entry in (tree.get("sensors") or {}).items():
        if other != name and "parent" in entry:
            joint, path = entry.get("joint", f"{entry['frame']}_joint"), ("sensors", other, "frame")
            found.setdefault(entry["frame"], _Above(joint, entry["parent"], pose_of_entry(entry), path))
    return found


def _pose_in(frame: str, link: str, above: Mapping[str, _Above]) -> Pose | None:
    transform, visited = Transform(), set[str]()
    while link != frame:
        step = above.get(link)
        if step is None or step.pose is None or link in visited:
            return None
        visited.add(link)
        transform, link = step.pose.transform().then(transform), step.parent
    return pose_of(transform)

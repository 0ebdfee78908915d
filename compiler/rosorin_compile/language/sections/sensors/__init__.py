"""The section ``sensors``: each has a frame, and its elements in MuJoCo and Gazebo.

A sensor with a ``parent`` brings its frame and the joint to it. One without is on a link of the description, or on the
frame of another sensor; its optical frame may already exist, attached by fixed joints; otherwise it is created.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Link, Pose, Sensor, Transform
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.link import Source
from rosorin_compile.model.sections import Section
from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.tree import Path

from ...lower import Lowering, entries_of, pose_of_entry, record_of, vector_of
from ...suggestions import suggest_name
from ..joints import OF_THE_URDF, Publishing, add_joint, publishing
from .elements import Frames, gazebo_sensors, mjcf_elements

_OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)  # REP 103, "Suffix Frames": from a body frame to its image frame
_OF_THE_JOINT = ("joint", "xyz", "rpy", "publisher")


def _sensors(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Sensor, ...]:
    sensors = tuple(_sensor(lowering, name, entry) for name, entry in entries_of(tree, "sensors"))
    for sensor in sensors:
        for frame, keys in ((sensor.frame, ("frame",)), (sensor.optical_frame, ("optical", "frame"))):
            if frame and ("link", frame) not in lowering.places:
                lowering.place("link", frame, ("sensors", sensor.name, *keys))
                lowering.links.append(Link(frame, source=sensor.source))
    for name, entry in tree["sensors"].items():
        for index, text in enumerate(entry.get("urdf_elements") or ()):
            path: Path = ("sensors", name, "urdf_elements", index)
            lowering.places["urdf_element", str(len(lowering.urdf_elements))] = path
            lowering.urdf_elements.append(text)
    return sensors


class _Above(NamedTuple):
    """What leads to a link: the name of the joint, its parent and pose (None if it moves), and where it is written."""

    joint: str
    parent: str
    pose: Pose | None
    path: Path


def _sensor(lowering: Lowering, name: str, entry: Mapping[str, Any]) -> Sensor:
    """Return a sensor, and add its frames and the fixed joints to them that do not exist yet."""
    path: Path = ("sensors", name)
    frame, source = entry["frame"], record_of(Source, entry.get("source"))
    optical = entry.get("optical") or {}
    optical_frame = optical.get("frame", "")
    optical_pose = Pose(vector_of(optical.get("xyz")), vector_of(optical.get("rpy"), _OPTICAL_RPY))
    joint, parent, mount, by, existing = "", frame, IDENTITY, Publishing(OF_THE_URDF), None
    if "parent" in entry:
        joint, parent, mount = entry.get("joint", f"{frame}_joint"), entry["parent"], pose_of_entry(entry)
        lowering.place_joint(joint, path, frame, (*path, "frame"))
        by = publishing(lowering, entry, path)
        add_joint(lowering, Joint(joint, "fixed", parent, frame, mount, publisher=by.always, source=source), by)
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
        add_joint(lowering, made, by)
    return sensor


def _check(lowering: Lowering, name: str, entry: Mapping[str, Any], above: Mapping[str, _Above]) -> None:
    path: Path = ("sensors", name)
    frame, links = entry["frame"], lowering.tree.get("links") or {}
    if frame not in links and frame not in above:
        message = f'sensor "{name}" has no parent, and its frame "{frame}" is not a link of the description'
        help = suggest_name(lowering.tree, (*path, "frame"), frame, list(dict.fromkeys((*links, *above))))
        lowering("sensor-frame", message, (*path, "frame"), help)
        return
    for key in _OF_THE_JOINT:
        if key in entry:
            message = f'sensor "{name}" sits on link "{frame}", which has a place of its own: {key} has no effect'
            at = lowering.tree.locate(above[frame].path, key=True).span if frame in above else None
            related = (Related("its place is defined here", at),) if at else ()
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


SECTION: Section[Any] = Section("sensors", Sensor, lower=_sensors)

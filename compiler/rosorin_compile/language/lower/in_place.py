"""Sensors on links that are there: no frame is made for them, and no joint.

Such a sensor has no ``parent``. Its frame is a link that the description has, or the frame that another sensor brings;
its optical frame may be one that fixed joints hold to it, and is made where it is not there.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Joint, Pose, Sensor, Transform
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.rule_registry import FRAMES, Rule
from rosorin_compile.source.tree import Path, locate

from ..misnamed import name_meant
from .entries import source_of
from .plainly import pose_of_entry
from .publishing import OF_THE_URDF, Publishing, optical_pose
from .sdf import Frames

if TYPE_CHECKING:
    from . import _Lowering

RULES = (
    Rule(
        "sensor-frame",
        "A sensor without a `parent` has a frame that is no link of the description.",
        "Correct the name, or say the `parent` that the sensor sits on.",
        FRAMES,
    ),
)

_OF_THE_JOINT = ("joint", "xyz", "rpy", "publisher")


class Above(NamedTuple):
    """What leads to a link: the name of the joint, the link that it comes from, and the pose; None if it moves."""

    joint: str
    parent: str
    pose: Pose | None
    path: Path


def sensor_in_place(lowering: _Lowering, name: str, entry: dict[str, Any]) -> tuple[Sensor, list[Joint]]:
    """Return a sensor whose frame is a link of the description, and the joint of an optical frame that is not there."""
    frame, above = entry["frame"], _above(lowering.tree, name)
    _check(lowering, name, entry, above)
    optical, joint = entry.get("optical") or None, above[frame].joint if frame in above else ""
    there = _pose_in(frame, optical["frame"], above) if optical else None
    pose = optical_pose(optical) if there is None else there
    turned = entry.get("optical") is False
    frames = Frames(frame, IDENTITY, frame, optical["frame"] if optical else "", joint, pose, turned)
    stamps = tuple(entry.get("stamps", [frame, frames.optical] if optical else [frame]))
    simulated, gazebo = lowering.elements(name, entry, frames), lowering.gazebo(name, entry, frames)
    source = source_of(entry.get("source"))
    sensor = Sensor(name, entry["type"], frame, joint, frames.optical, source, simulated, stamps, gazebo)
    return sensor, [
        lowering.to_optical(sensor, optical, pose, Publishing(OF_THE_URDF))
    ] if optical and there is None else []


def _check(lowering: _Lowering, name: str, entry: dict[str, Any], above: Mapping[str, Above]) -> None:
    """Report a frame that nobody describes, and what is said of a joint that the sensor does not bring."""
    path: Path = ("sensors", name)
    frame, links = entry["frame"], lowering.section("links")
    if frame not in links and frame not in above:
        message = f'sensor "{name}" has no parent, and its frame "{frame}" is no link of the description'
        known = list(dict.fromkeys((*links, *above)))
        help = name_meant(lowering.tree, (*path, "frame"), frame, known)
        lowering.problem("sensor-frame", message, (*path, "frame"), help)
        return
    for key in _OF_THE_JOINT:
        if key in entry:
            message = f'sensor "{name}" sits on link "{frame}", which has a place of its own: {key} has no effect'
            at = locate(lowering.tree, above[frame].path, key=True).span if frame in above else None
            related = (Related("its place is said here", at),) if at else ()
            lowering.problem("ignored-key", message, (*path, key), "remove it, or say the parent", related)


def _above(tree: Mapping[str, Any], name: str) -> dict[str, Above]:
    """Return what leads to each link: a joint, or another sensor that brings its frame."""
    found: dict[str, Above] = {}
    for joint, entry in (tree.get("joints") or {}).items():
        pose = pose_of_entry(entry) if entry["type"] == "fixed" else None
        found.setdefault(entry["child"], Above(joint, entry["parent"], pose, ("joints", joint)))
    for other, entry in (tree.get("sensors") or {}).items():
        if other != name and "parent" in entry:
            joint = entry.get("joint", f"{entry['frame']}_joint")
            path: Path = ("sensors", other, "frame")
            found.setdefault(entry["frame"], Above(joint, entry["parent"], pose_of_entry(entry), path))
    return found


def _pose_in(frame: str, link: str, above: Mapping[str, Above]) -> Pose | None:
    """Return the pose in a frame of a link that fixed joints hold to it; None if none do."""
    transform, seen = Transform(), set[str]()
    while link != frame:
        one = above.get(link)
        if one is None or one.pose is None or link in seen:
            return None
        seen.add(link)
        transform, link = one.pose.transform().then(transform), one.parent
    return pose_of(transform)

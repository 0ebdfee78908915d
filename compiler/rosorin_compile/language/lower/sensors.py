"""Lower sensors: their frames and joints, and what MuJoCo and Gazebo have of them.

A sensor with a ``parent`` brings its frame and the joint to it. One without sits on a link of the description, or on
the frame of another sensor; its optical frame may be one that fixed joints hold to it, and is made where there is none.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Joint, Link, Pose, Sensor, Transform
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.simulation import (
    AT_JOINT,
    BODY_ELEMENT,
    SENSOR_ELEMENT,
    TEMPLATE_ELEMENT,
    GazeboSensor,
    Replicas,
    SdfElement,
    Simulated,
)
from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.rule_registry import FRAMES, Rule
from rosorin_compile.source.tree import Path, locate
from rosorin_compile.source.wording import listed

from ..expand.sensor_types import ChangedSensor
from ..suggestions import name_meant
from .publishing import OF_THE_URDF, Publishing, optical_pose, publishing
from .records import attribute_of, pose_of_entry, source_of
from .shapes import ShapeProblem

if TYPE_CHECKING:
    from . import Lowering

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


def lower_sensor(lowering: Lowering, name: str, entry: dict[str, Any]) -> tuple[Sensor, list[Joint]]:
    """Return a sensor and the fixed joints of its frame and its optical frame, those that do not exist yet."""
    path: Path = ("sensors", name)
    frame, source, optical = entry["frame"], source_of(entry.get("source")), entry.get("optical") or None
    named, turned = optical["frame"] if optical else "", entry.get("optical") is False
    pose, existing = optical_pose(optical), None
    if "parent" in entry:
        joint, parent, mount = entry.get("joint", f"{frame}_joint"), entry["parent"], pose_of_entry(entry)
        lowering.place_joint(joint, path, frame, (*path, "frame"))
        by = publishing(entry, path, lowering.nodes, lowering)
        joints = [Joint(joint, "fixed", parent, frame, mount, publisher=by.always, source=source)]
        lowering.take_turns(joints[0], by)
    else:
        above = _above(lowering.tree, name)
        _check(lowering, name, entry, above)
        joint, parent, mount = above[frame].joint if frame in above else "", frame, IDENTITY
        existing = _pose_in(frame, named, above) if optical else None
        pose, by, joints = existing or pose, Publishing(OF_THE_URDF), []
    frames = Frames(frame, mount, parent, named, joint, pose, turned)
    stamps = [] if by.always.simulated else [frame, named] if optical else [frame]
    sensor = Sensor(
        name,
        entry["type"],
        frame,
        joint,
        named,
        source,
        _mjcf_elements(lowering, name, entry, frames),
        tuple(entry.get("stamps", stamps)),
        _gazebo_sensors(lowering, name, entry, frames),
    )
    if optical and existing is None:
        joints.append(_to_optical(lowering, sensor, optical, pose, by))
    return sensor, joints


def _to_optical(lowering: Lowering, sensor: Sensor, optical: dict[str, Any], pose: Pose, by: Publishing) -> Joint:
    """Return the fixed joint from the frame of a sensor, which ``by`` publishes, to its optical frame."""
    path: Path = ("sensors", sensor.name, "optical")
    joint = optical.get("joint", f"{optical['frame']}_joint")
    lowering.place_joint(joint, path, optical["frame"], (*path, "frame"))
    by = publishing(optical, path, lowering.nodes, lowering) if "publisher" in optical else by.of_optical()
    made = Joint(joint, "fixed", sensor.frame, optical["frame"], pose, publisher=by.always, source=sensor.source)
    lowering.take_turns(made, by)
    return made


def frames_of_sensors(lowering: Lowering, sensors: Sequence[Sensor]) -> list[Link]:
    """Return a link for each sensor frame that ``links`` does not mention."""
    made = []
    for sensor in sensors:
        for frame, key in ((sensor.frame, ("frame",)), (sensor.optical_frame, ("optical", "frame"))):
            if frame and ("link", frame) not in lowering.places:
                lowering.place("link", frame, ("sensors", sensor.name, *key))
                made.append(Link(frame, source=sensor.source))
    return made


def _mjcf_elements(lowering: Lowering, name: str, entry: dict[str, Any], frames: Frames) -> tuple[Simulated, ...]:
    """Return the elements of MJCF of a sensor; two of a kind with the same name are a problem."""
    path: Path = ("sensors", name, "mjcf")
    links = {link.name: link for link in lowering.links}
    made: list[Simulated] = []
    try:
        for unmoved in lower_elements(name, entry.get("mjcf") or (), frames):
            element = around_shapes(moved(unmoved, entry.get("gazebo"), frames), links)
            if element.kind != TEMPLATE_ELEMENT:
                lowering.place(f"MuJoCo {element.element}", element.name, (*path, len(made)))
            if element.kind == SENSOR_ELEMENT and element.pose is not None:
                lowering.place("MuJoCo site", element.site, (*path, len(made)))
            made.append(element)
    except ShapeProblem as problem:
        lowering.misfit(problem, path, f' (sensor "{name}")')
    return tuple(made)


def _gazebo_sensors(lowering: Lowering, name: str, entry: dict[str, Any], frames: Frames) -> tuple[GazeboSensor, ...]:
    """Return the sensors of Gazebo of a sensor; two with the same name are a problem."""
    path: Path = ("sensors", name, "gazebo")
    made: list[GazeboSensor] = []
    try:
        for one in lower_gazebo(name, entry.get("gazebo") or (), frames):
            lowering.place("Gazebo sensor", one.name, (*path, len(made)))
            made.append(one)
    except ShapeProblem as problem:
        lowering.misfit(problem, path, f' (sensor "{name}")')
    return tuple(made)


def _check(lowering: Lowering, name: str, entry: dict[str, Any], above: Mapping[str, Above]) -> None:
    """Report a frame that nobody describes, and what is said of a joint that the sensor does not bring."""
    path: Path = ("sensors", name)
    frame, links = entry["frame"], lowering.tree.get("links") or {}
    if frame not in links and frame not in above:
        message = f'sensor "{name}" has no parent, and its frame "{frame}" is no link of the description'
        known = list(dict.fromkeys((*links, *above)))
        help = partial(name_meant, lowering.tree, (*path, "frame"), frame, known)
        lowering("sensor-frame", message, (*path, "frame"), help)
        return
    for key in _OF_THE_JOINT:
        if key in entry:
            message = f'sensor "{name}" sits on link "{frame}", which has a place of its own: {key} has no effect'
            at = locate(lowering.tree, above[frame].path, key=True).span if frame in above else None
            related = (Related("its place is said here", at),) if at else ()
            lowering("ignored-key", message, (*path, key), "remove it, or say the parent", related)


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


MAX_DEPTH = 12
_ZERO = 1e-12  # m and rad: what is left of a turn there and back
_NAME = r"[A-Za-z_][\w.-]*"
_ATTRIBUTES = "attributes"


class Frames(NamedTuple):
    """The frames that an element may sit in: that of the sensor, its optical frame, and the link that it is on."""

    sensor: str
    mount: Pose
    parent: str
    optical: str = ""
    joint: str = ""
    optical_pose: Pose = IDENTITY
    turned: bool = False  # where there is no optical frame, what sits in one is turned as if there were


def lower_gazebo(sensor: str, entries: Sequence[Mapping[str, Any]], frames: Frames) -> Iterator[GazeboSensor]:
    """Yield the sensors of Gazebo. Raises ShapeProblem, whose path leads to the culprit within the entries."""
    for index, entry in enumerate(entries):
        try:
            yield _sensor(sensor, entry, frames)
        except ShapeProblem as problem:
            raise ShapeProblem(problem.rule, problem.message, (index, *problem.path), problem.help) from None


def _sensor(sensor: str, entry: Mapping[str, Any], frames: Frames) -> GazeboSensor:
    frame, suffix, feels = entry.get("frame", "sensor"), entry.get("name"), entry.get("feels", "")
    if frame == "optical" and not frames.optical and not frames.turned:
        raise ShapeProblem("missing-key", "the sensor has no optical frame", ("frame",), "give it one: optical")
    link, transform, said = frames.sensor, pose_of_entry(entry).transform(), entry.get("elements") or {}
    if frame == "optical":
        transform = frames.optical_pose.transform().then(transform)
    elif frame == "parent":
        link, transform = frames.parent, frames.mount.transform().then(transform)
    return GazeboSensor(
        type=entry["sensor"],
        name=sensor if suffix is None else f"{sensor}_{suffix}",
        link=frames.joint if frame == AT_JOINT else link,
        pose=_cleaned(transform),
        stamp=frames.optical if frame == "optical" and frames.optical else frames.sensor,
        elements=tuple(_elements(said, ("elements",))),
        at_joint=frame == AT_JOINT,
        feels={"parent": frames.parent, "sensor": frames.sensor}.get(feels, ""),
        without=frozenset(str(name) for name, value in said.items() if value is None),
    )


def moved(element: Simulated, entries: Any, frames: Frames) -> Simulated:
    """Move a MuJoCo element of a sensor type as the sensor moves the Gazebo sensor of that type."""
    if (
        not isinstance(entries, ChangedSensor)
        or entries.brought is None
        or element.link == frames.parent != frames.sensor
    ):
        return element
    optical = frames.optical_pose.transform()

    def placed(entry: Mapping[str, Any]) -> Transform | None:
        one = _sensor("", entry, frames)
        if one.at_joint or one.feels or one.link not in (frames.sensor, frames.optical):
            return None
        own = one.pose.transform()
        for camera in one.elements:  # SDF composes <sensor><pose> and <sensor><camera><pose>
            texts = [str(inner.value).split() for inner in camera.elements if (camera.name, inner.name) == _LENS]
            with suppress(ValueError):
                for x, y, z, roll, pitch, yaw in (map(float, words) for words in texts):
                    own = own.then(Pose((x, y, z), (roll, pitch, yaw)).transform())
        return own if one.link == frames.sensor else optical.then(own)

    before, after = placed(entries.brought), placed(entries[0])
    if before is None or after is None:
        return element
    shift = _cleaned(after.then(before.inverse()))
    if shift == IDENTITY:
        return element
    pose = (element.pose or IDENTITY).transform()
    at = pose if element.link == frames.sensor else optical.then(pose)
    return replace(element, link=frames.sensor, pose=_cleaned(shift.transform().then(at)))


_LENS = ("camera", "pose")
_MARGIN = 1e-3  # m: contacts lie on the surface, and a little below it
_MESH_ZONE = 2.0  # m: half the zone around a link with a mesh, whose size is not known here


def around_shapes(element: Simulated, links: Mapping[str, Link]) -> Simulated:
    """Give a box without a size, the zone of a contact sensor, the extents of all collision shapes of its link."""
    values = element.attributes
    if element.element != "site" or values.get("type") != "box" or values.get("size") is not None:
        return element
    shapes = links[element.link].collision if element.link in links else ()
    bounds = bounds_of(shapes)
    if bounds is None:
        zone, pose = (_MESH_ZONE if shapes else _MARGIN,) * 3, element.pose or IDENTITY
    else:
        (a, b, c), (x, y, z) = bounds.lower, bounds.size
        zone = (x / 2 + _MARGIN, y / 2 + _MARGIN, z / 2 + _MARGIN)
        pose = Pose((a + x / 2, b + y / 2, c + z / 2), IDENTITY.rpy)
    return replace(element, pose=pose, attributes={**values, "size": zone})


def _cleaned(transform: Transform) -> Pose:
    """Return a pose without what rounding has left of a turn there and back."""
    pose = pose_of(transform)
    x, y, z, roll, pitch, yaw = (0.0 if abs(value) < _ZERO else value for value in (*pose.xyz, *pose.rpy))
    return Pose((x, y, z), (roll, pitch, yaw))


def _elements(entries: Mapping[str, Any], path: tuple[str | int, ...]) -> Iterator[SdfElement]:
    """Yield the elements that a mapping says, in its order; those without a value are left out."""
    for name, value in entries.items():
        here = (*path, name)
        if not re.fullmatch(_NAME, name):
            raise ShapeProblem("bad-name", f'no element of SDF is called "{name}"', here, "correct it")
        if len(here) > MAX_DEPTH:
            raise ShapeProblem("wrong-value", f"elements are nested deeper than {MAX_DEPTH}", here, "SDF has none such")
        for index, one in enumerate(value) if isinstance(value, list) else [(None, value)]:
            if one is not None:
                yield _element(name, one, here if index is None else (*here, index))


def _element(name: str, value: Any, path: tuple[str | int, ...]) -> SdfElement:
    if not isinstance(value, Mapping):
        return SdfElement(name, _scalar(value, path))
    given = value.get(_ATTRIBUTES) or {}
    if not isinstance(given, Mapping):
        raise ShapeProblem("wrong-type", "attributes map names to values", (*path, _ATTRIBUTES), "write {type: ...}")
    attributes = {}
    for key, one in given.items():
        if not re.fullmatch(_NAME, key):
            raise ShapeProblem("bad-name", f'no attribute is called "{key}"', (*path, _ATTRIBUTES, key), "correct it")
        if one is not None:
            attributes[key] = _scalar(one, (*path, _ATTRIBUTES, key))
    inner = {key: one for key, one in value.items() if key != _ATTRIBUTES}
    return SdfElement(name, None, attributes, tuple(_elements(inner, path)))


def _scalar(value: Any, path: tuple[str | int, ...]) -> float | str | bool:
    if isinstance(value, (bool, str)):
        return value if isinstance(value, bool) else str(value)
    if isinstance(value, (int, float)):
        return float(value)
    raise ShapeProblem("wrong-type", "an element of SDF is text, a number, or elements", path, "write each by its name")


# What a simulation can still do with.
MAX_COPIES = 100_000

_KINDS = (SENSOR_ELEMENT, BODY_ELEMENT, TEMPLATE_ELEMENT)


def lower_elements(sensor: str, entries: Sequence[Mapping[str, Any]], frames: Frames) -> Iterator[Simulated]:
    """Yield the elements of a sensor. Raises ShapeProblem, whose path leads to the culprit within the entries."""
    for index, entry in enumerate(entries):
        try:
            yield _mjcf_element(sensor, entry, frames)
        except ShapeProblem as problem:
            raise ShapeProblem(problem.rule, problem.message, (index, *problem.path), problem.help) from None


def _mjcf_element(sensor: str, entry: Mapping[str, Any], frames: Frames) -> Simulated:
    kinds = [kind for kind in _KINDS if kind in entry]
    if len(kinds) != 1:
        message = f"an element of mjcf has one of {', '.join(_KINDS)}; this one has {listed(kinds) or 'none'}"
        raise ShapeProblem("missing-key", message, (), "write one entry an element")
    if "section" in entry and kinds[0] != TEMPLATE_ELEMENT:
        raise ShapeProblem("ignored-key", "only a template has a section", ("section",), "remove it")
    link, pose = _element_pose(entry, frames)
    suffix = entry.get("name")
    return Simulated(
        kind=kinds[0],
        element=entry[kinds[0]],
        name=sensor if suffix is None else f"{sensor}_{suffix}",
        link=link,
        pose=pose,
        attributes={name: attribute_of(value) for name, value in sorted(entry.get("attributes", {}).items())},
        replicas=_replicas(entry["replicate"]) if "replicate" in entry else None,
        section=entry.get("section", ""),
    )


def _element_pose(entry: Mapping[str, Any], frames: Frames) -> tuple[str, Pose | None]:
    """Return the link of an element, and where it sits in it; None is at the frame of the link."""
    own = pose_of_entry(entry) if any(key in entry for key in ("xyz", "rpy", "replicate")) else None
    frame = entry.get("frame", "sensor")
    if frame == "sensor":
        return frames.sensor, own
    if frame == "parent":
        mount = frames.mount.transform()
        return frames.parent, frames.mount if own is None else pose_of(mount.then(own.transform()))
    if not frames.optical and frames.turned:
        turn = frames.optical_pose.transform()
        return frames.sensor, pose_of(turn if own is None else turn.then(own.transform()))
    if not frames.optical:
        raise ShapeProblem("missing-key", "the sensor has no optical frame", ("frame",), "give it one: optical")
    return frames.optical, own


def _replicas(entry: Mapping[str, Any]) -> Replicas:
    if not 1 <= entry["count"] <= MAX_COPIES:
        message = f"a count is 1 to {MAX_COPIES:,}, not {entry['count']}"
        raise ShapeProblem("wrong-value", message, ("replicate", "count"), "correct it")
    step = pose_of_entry(entry)
    if sum(angle != 0 for angle in step.rpy) > 1:
        # MuJoCo multiplies the angles by the number of the copy, which is no steady turn where there are several.
        message = "copies turn about one axis: one of roll, pitch, yaw"
        raise ShapeProblem("wrong-value", message, ("replicate", "rpy"), "turn the element itself with its own rpy")
    return Replicas(entry["count"], step)

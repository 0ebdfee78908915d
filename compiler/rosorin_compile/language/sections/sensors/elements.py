"""Lower the elements of a sensor in MuJoCo and Gazebo."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import Link, Pose, Transform
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
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import phrase

from ...expand.parts import ChangedSensor
from ...lower import Lowering, LoweringError, pose_of_entry, values_of

MAX_DEPTH = 12
MAX_COPIES = 100_000  # of an element; a simulation still runs with it
_KINDS = (SENSOR_ELEMENT, BODY_ELEMENT, TEMPLATE_ELEMENT)
_ZERO = 1e-12  # m and rad: rounding errors of a rotation and its inverse
_MARGIN = 1e-3  # m: contacts are on the surface, and a little below it
_MESH_ZONE = 2.0  # m: half the zone around a link with a mesh, whose size is not known here
_NAME = re.compile(r"[A-Za-z_][\w.-]*")


class Frames(NamedTuple):
    """The frames that an element may be in: that of the sensor, its optical frame, and the link that it is on.

    ``turned``: there is no optical frame, and elements that belong in it are rotated as if there were one.
    """

    sensor: str
    mount: Pose
    parent: str
    optical: str = ""
    joint: str = ""
    optical_pose: Pose = IDENTITY
    turned: bool = False


def mjcf_elements(lowering: Lowering, name: str, entry: Mapping[str, Any], frames: Frames) -> tuple[Simulated, ...]:
    """Return the elements of MJCF of a sensor; two of a kind with the same name are reported."""
    links = {link.name: link for link in lowering.links}
    made: list[Simulated] = []
    with lowering.reporting(f' (sensor "{name}")'):
        for index, item in enumerate(entry.get("mjcf") or ()):
            path = ("sensors", name, "mjcf", index)
            element = _around_shapes(_moved(_mjcf_element(name, item, frames, path), entry, frames), links)
            if element.kind != TEMPLATE_ELEMENT:
                lowering.place(f"MuJoCo {element.element}", element.name, path)
            if element.kind == SENSOR_ELEMENT and element.pose is not None:
                lowering.place("MuJoCo site", element.site, path)
            made.append(element)
    return tuple(made)


def gazebo_sensors(lowering: Lowering, name: str, entry: Mapping[str, Any], frames: Frames) -> tuple[GazeboSensor, ...]:
    """Return the sensors of Gazebo of a sensor; two with the same name are reported."""
    made: list[GazeboSensor] = []
    with lowering.reporting(f' (sensor "{name}")'):
        for index, item in enumerate(entry.get("gazebo") or ()):
            path = ("sensors", name, "gazebo", index)
            made.append(_gazebo_sensor(name, item, frames, path))
            lowering.place("Gazebo sensor", made[-1].name, path)
    return tuple(made)


def _check_optical(frames: Frames, path: Path) -> None:
    if not frames.optical and not frames.turned:
        help = "give it one: optical"
        raise LoweringError("missing-key", "the sensor has no optical frame", (*path, "frame"), help)


def _mjcf_element(sensor: str, entry: Mapping[str, Any], frames: Frames, path: Path) -> Simulated:
    kinds = [kind for kind in _KINDS if kind in entry]
    if len(kinds) != 1:
        message = f"an element of mjcf has one of {', '.join(_KINDS)}; this one has {phrase(kinds) or 'none'}"
        raise LoweringError("missing-key", message, path, "write one entry an element")
    if "section" in entry and kinds[0] != TEMPLATE_ELEMENT:
        raise LoweringError("ignored-key", "only a template has a section", (*path, "section"), "remove it")
    own = pose_of_entry(entry) if any(key in entry for key in ("xyz", "rpy", "replicate")) else None
    link, pose, frame = frames.sensor, own, entry.get("frame", "sensor")
    if frame == "parent":
        link, pose = frames.parent, frames.mount
    elif frame == "optical":
        _check_optical(frames, path)
        link, pose = (frames.optical, None) if frames.optical else (frames.sensor, frames.optical_pose)
    if frame != "sensor" and own is not None:
        pose = own if pose is None else pose_of(pose.transform().then(own.transform()))
    name = f"{sensor}_{entry['name']}" if entry.get("name") is not None else sensor
    replicas = _replicas(entry["replicate"], (*path, "replicate")) if "replicate" in entry else None
    attributes, section = values_of(entry.get("attributes")), entry.get("section", "")
    return Simulated(kinds[0], entry[kinds[0]], name, link, pose, attributes, replicas=replicas, section=section)


def _replicas(entry: Mapping[str, Any], path: Path) -> Replicas:
    if not 1 <= entry["count"] <= MAX_COPIES:
        message = f"a count is 1 to {MAX_COPIES:,}, not {entry['count']}"
        raise LoweringError("wrong-value", message, (*path, "count"), "correct it")
    step = pose_of_entry(entry)
    if sum(angle != 0 for angle in step.rpy) > 1:  # MuJoCo multiplies each angle: not a steady turn about two axes
        message, help = "copies turn about one axis: one of roll, pitch, yaw", "turn the element with its own rpy"
        raise LoweringError("wrong-value", message, (*path, "rpy"), help)
    return Replicas(entry["count"], step)


def _gazebo_sensor(sensor: str, entry: Mapping[str, Any], frames: Frames, path: Path) -> GazeboSensor:
    frame, elements = entry.get("frame", "sensor"), entry.get("elements") or {}
    link, transform, stamp = frames.sensor, pose_of_entry(entry).transform(), frames.sensor
    if frame == "optical":
        _check_optical(frames, path)
        transform, stamp = frames.optical_pose.transform().then(transform), frames.optical or frames.sensor
    elif frame == "parent":
        link, transform = frames.parent, frames.mount.transform().then(transform)
    return GazeboSensor(
        type=entry["sensor"],
        name=f"{sensor}_{entry['name']}" if entry.get("name") is not None else sensor,
        link=frames.joint if frame == AT_JOINT else link,
        pose=_rounded(transform),
        stamp=stamp,
        elements=tuple(_sdf_elements(elements, (*path, "elements"), 1)),
        at_joint=frame == AT_JOINT,
        feels={"parent": frames.parent, "sensor": frames.sensor}.get(entry.get("feels", ""), ""),
        without=frozenset(str(name) for name, value in elements.items() if value is None),
    )


def _sdf_elements(entries: Mapping[str, Any], path: Path, depth: int) -> Iterator[SdfElement]:
    for name, value in entries.items():
        here = (*path, name)
        _check_name("element of SDF", name, here)
        if depth >= MAX_DEPTH:
            message = f"elements are nested deeper than {MAX_DEPTH}"
            raise LoweringError("wrong-value", message, here, "SDF has none such")
        for index, item in enumerate(value) if isinstance(value, list) else [(None, value)]:
            at = here if index is None else (*here, index)
            if isinstance(item, Mapping):
                attributes, place = item.get("attributes") or {}, (*at, "attributes")
                if not isinstance(attributes, Mapping):
                    raise LoweringError("wrong-type", "attributes map names to values", place, "write {type: ...}")
                for key in attributes:
                    _check_name("attribute", key, (*place, key))
                given = {key: text for key, text in attributes.items() if text is not None}
                texts = {key: _sdf_value(text, (*place, key)) for key, text in given.items()}
                inner = {key: inside for key, inside in item.items() if key != "attributes"}
                yield SdfElement(name, None, texts, tuple(_sdf_elements(inner, at, depth + 1)))
            elif item is not None:
                yield SdfElement(name, _sdf_value(item, at))


def _check_name(what: str, name: str, path: Path) -> None:
    if not _NAME.fullmatch(name):
        raise LoweringError("bad-name", f'no {what} is called "{name}"', path, "correct it")


def _sdf_value(value: Any, path: Path) -> float | str | bool:
    if isinstance(value, bool):
        return value
    if not isinstance(value, (str, int, float)):
        message = "an element of SDF is text, a number, or elements"
        raise LoweringError("wrong-type", message, path, "write each by its name")
    return str(value) if isinstance(value, str) else float(value)


def _moved(element: Simulated, sensor: Mapping[str, Any], frames: Frames) -> Simulated:
    """Move a MuJoCo element of a sensor type as the sensor moves the Gazebo sensor of that type."""
    changed, is_on_parent = sensor.get("gazebo"), element.link == frames.parent != frames.sensor
    if not isinstance(changed, ChangedSensor) or changed.brought is None or is_on_parent:
        return element
    before, after = _pose_in_sensor(changed.brought, frames), _pose_in_sensor(changed[0], frames)
    shift = IDENTITY if before is None or after is None else _rounded(after.then(before.inverse()))
    if shift == IDENTITY:
        return element
    pose = (element.pose or IDENTITY).transform()
    if element.link != frames.sensor:
        pose = frames.optical_pose.transform().then(pose)
    return replace(element, link=frames.sensor, pose=_rounded(shift.transform().then(pose)))


def _pose_in_sensor(entry: Mapping[str, Any], frames: Frames) -> Transform | None:
    sensor = _gazebo_sensor("", entry, frames, ())
    if sensor.at_joint or sensor.feels or sensor.link not in (frames.sensor, frames.optical):
        return None
    pose = sensor.pose.transform()
    cameras = (element for element in sensor.elements if element.name == "camera")
    for inner in (inner for camera in cameras for inner in camera.elements if inner.name == "pose"):
        with suppress(ValueError):  # SDF composes <sensor><pose> and <sensor><camera><pose>
            x, y, z, roll, pitch, yaw = map(float, str(inner.value).split())
            pose = pose.then(Pose((x, y, z), (roll, pitch, yaw)).transform())
    return pose if sensor.link == frames.sensor else frames.optical_pose.transform().then(pose)


def _around_shapes(element: Simulated, links: Mapping[str, Link]) -> Simulated:
    values = element.attributes
    if element.element != "site" or values.get("type") != "box" or values.get("size") is not None:
        return element
    shapes = links[element.link].collision if element.link in links else ()
    bounds, pose = bounds_of(shapes), element.pose or IDENTITY
    zone = (_MESH_ZONE if shapes else _MARGIN,) * 3
    if bounds is not None:
        (a, b, c), (x, y, z) = bounds.lower, bounds.size
        zone = (x / 2 + _MARGIN, y / 2 + _MARGIN, z / 2 + _MARGIN)
        pose = Pose((a + x / 2, b + y / 2, c + z / 2), IDENTITY.rpy)
    return replace(element, pose=pose, attributes={**values, "size": zone})


def _rounded(transform: Transform) -> Pose:
    """Return a pose without the rounding errors of a rotation and its inverse."""
    pose = pose_of(transform)
    x, y, z, roll, pitch, yaw = (0.0 if abs(value) < _ZERO else value for value in (*pose.xyz, *pose.rpy))
    return Pose((x, y, z), (roll, pitch, yaw))

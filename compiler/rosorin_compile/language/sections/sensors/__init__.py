"""The section ``sensors``: sensors with their frames, and their elements in MuJoCo and Gazebo.

A sensor with a ``parent`` defines a frame and a fixed joint from the parent to that frame. A sensor without ``parent``
uses an existing link, or the frame of another sensor. An optical frame is created, with a fixed joint, if needed.
"""

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Link, Pose, Sensor, Transform, simulation
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.link import Source
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import TEMPLATE_ELEMENT, GazeboSensor, Replicas, SdfElement, SensorElement
from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import phrase

from ...expand.parts import ChangedSensor
from ...lower import Lowering, LoweringError, entries_of, pose_of_entry, record_of, values_of, vector_of
from ...suggestions import suggest_name
from ..joints import OF_THE_URDF, JointPublishers, add_joint, joint_publishers

_OPTICAL_RPY = (-math.pi / 2, 0.0, -math.pi / 2)  # REP 103, "Suffix Frames": rotation from body frame to optical frame
MAX_DEPTH = 12
MAX_COPIES = 100_000  # maximum number of copies of an element that MuJoCo can simulate
_KINDS = (simulation.SENSOR_ELEMENT, simulation.BODY_ELEMENT, TEMPLATE_ELEMENT)
_ZERO = 1e-12  # m or rad: more than the rounding error of a rotation followed by its inverse
_MARGIN = 1e-3  # m: margin around shapes, because contact points are on the surface or slightly below
_MESH_ZONE = 2.0  # m: half size of the zone around a link with a mesh, whose bounds are unknown
_NAME = re.compile(r"[A-Za-z_][\w.-]*")


def _sensors(tree: Mapping[str, Any], lowering: Lowering) -> tuple[Sensor, ...]:
    entries = entries_of(tree, "sensors")
    mounts = [_mount(entry) for _, entry in entries if "parent" in entry]
    above = {joint.child: joint for joint in reversed([*lowering.joints, *mounts])}
    sensors = tuple(_sensor(lowering, name, entry, above) for name, entry in entries)
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


def _mount(entry: Mapping[str, Any]) -> Joint:
    frame, source = entry["frame"], record_of(Source, entry.get("source"))
    name = entry.get("joint", f"{frame}_joint")
    return Joint(name, "fixed", entry["parent"], frame, pose_of_entry(entry), source=source)


def _sensor(lowering: Lowering, name: str, entry: Mapping[str, Any], above: Mapping[str, Joint]) -> Sensor:
    path: Path = ("sensors", name)
    frame, source = entry["frame"], record_of(Source, entry.get("source"))
    optical = entry.get("optical") or {}
    optical_frame = optical.get("frame", "")
    optical_pose = Pose(vector_of(optical.get("xyz")), vector_of(optical.get("rpy"), _OPTICAL_RPY))
    joint, parent, mount, by, existing = "", frame, IDENTITY, JointPublishers(OF_THE_URDF), None
    if "parent" in entry:
        made = _mount(entry)
        joint, parent, mount = made.name, made.parent, made.origin
        lowering.place_joint(joint, path, frame, (*path, "frame"))
        by = joint_publishers(lowering, entry, path)
        add_joint(lowering, replace(made, publisher=by.always), by)
    else:
        _check(lowering, name, entry, above)
        joint = above[frame].name if frame in above else ""
        existing = _pose_in(frame, optical_frame, above) if optical else None
    is_turned, stamps = entry.get("optical") is False, (frame, optical_frame) if optical else (frame,)
    frames = Frames(frame, mount, parent, optical_frame, joint, existing or optical_pose, is_turned)
    stamps = tuple(entry.get("stamps", () if by.always.simulated else stamps))
    elements, gazebo = _elements(lowering, name, entry, frames)
    sensor = Sensor(name, entry["type"], frame, joint, optical_frame, source, elements, stamps, gazebo)
    if optical and existing is None:
        here, to_optical = (*path, "optical"), optical.get("joint", f"{optical_frame}_joint")
        lowering.place_joint(to_optical, here, optical_frame, (*here, "frame"))
        by = joint_publishers(lowering, optical, here) if "publisher" in optical else by.of_optical()
        made = Joint(to_optical, "fixed", frame, optical_frame, optical_pose, publisher=by.always, source=source)
        add_joint(lowering, made, by)
    return sensor


def _check(lowering: Lowering, name: str, entry: Mapping[str, Any], above: Mapping[str, Joint]) -> None:
    path: Path = ("sensors", name)
    frame, links = entry["frame"], lowering.tree.get("links") or {}
    if frame not in links and frame not in above:
        message = f'sensor "{name}" has no parent, and its frame "{frame}" is not a link of the description'
        help = suggest_name(lowering.tree, (*path, "frame"), frame, list(dict.fromkeys((*links, *above))))
        lowering("sensor-frame", message, (*path, "frame"), help)
        return
    for key in (key for key in ("joint", "xyz", "rpy", "publisher") if key in entry):
        message = f'sensor "{name}" is on link "{frame}", whose pose is defined elsewhere: "{key}" has no effect'
        at = lowering.places.get(("joint", above[frame].name)) if frame in above else None
        related: tuple[Related, ...] = ()
        if at is not None:
            related = (Related(f'the pose of "{frame}" is defined here', lowering.tree.locate(at, key=True).span),)
        lowering("ignored-key", message, (*path, key), 'remove the key, or add "parent"', related)


def _pose_in(frame: str, link: str, above: Mapping[str, Joint]) -> Pose | None:
    transform, visited = Transform(), set[str]()
    while link != frame:
        joint = above.get(link)
        if joint is None or joint.type != "fixed" or link in visited:
            return None
        visited.add(link)
        transform, link = joint.origin.transform().then(transform), joint.parent
    return pose_of(transform)


class Frames(NamedTuple):
    """The frames of a sensor's elements: the sensor frame, its optical frame, and the parent link.

    If ``turned`` is True, there is no optical frame; elements that need it are rotated in the sensor frame instead.
    """

    sensor: str
    mount: Pose
    parent: str
    optical: str = ""
    joint: str = ""
    optical_pose: Pose = IDENTITY
    turned: bool = False


def _elements(
    lowering: Lowering, name: str, entry: Mapping[str, Any], frames: Frames
) -> tuple[tuple[SensorElement, ...], tuple[GazeboSensor, ...]]:
    links = {link.name: link for link in lowering.links}
    elements, gazebo = list[SensorElement](), list[GazeboSensor]()
    with lowering.report_errors(f' (sensor "{name}")'):
        for index, item in enumerate(entry.get("mjcf") or ()):
            path: Path = ("sensors", name, "mjcf", index)
            element = _around_shapes(_moved(_mjcf_element(name, item, frames, path), entry, frames), links)
            if element.kind != TEMPLATE_ELEMENT:
                lowering.place(f"MuJoCo {element.element}", element.name, path)
            if element.kind == simulation.SENSOR_ELEMENT and element.pose is not None:
                lowering.place("MuJoCo site", element.site, path)
            elements.append(element)
    with lowering.report_errors(f' (sensor "{name}")'):
        for index, item in enumerate(entry.get("gazebo") or ()):
            path = ("sensors", name, "gazebo", index)
            gazebo.append(_gazebo_sensor(name, item, frames, path))
            lowering.place("Gazebo sensor", gazebo[-1].name, path)
    return tuple(elements), tuple(gazebo)


def _check_optical(frames: Frames, path: Path) -> None:
    if not frames.optical and not frames.turned:
        help = 'add "optical" to the sensor'
        raise LoweringError("missing-key", "the sensor has no optical frame", (*path, "frame"), help)


def _mjcf_element(sensor: str, entry: Mapping[str, Any], frames: Frames, path: Path) -> SensorElement:
    kinds = [kind for kind in _KINDS if kind in entry]
    if len(kinds) != 1:
        message = f'an entry of "mjcf" needs exactly one of {", ".join(_KINDS)}, but has {phrase(kinds) or "none"}'
        raise LoweringError("missing-key", message, path, "write one element per entry" if kinds else "add one of them")
    if "section" in entry and kinds[0] != TEMPLATE_ELEMENT:
        raise LoweringError("ignored-key", '"section" is only allowed with "template"', (*path, "section"), "remove it")
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
    return SensorElement(kinds[0], entry[kinds[0]], name, link, pose, attributes, replicas=replicas, section=section)


def _replicas(entry: Mapping[str, Any], path: Path) -> Replicas:
    if not 1 <= entry["count"] <= MAX_COPIES:
        message = f'"count" must be from 1 to {MAX_COPIES:,}, not {entry["count"]}'
        raise LoweringError("wrong-value", message, (*path, "count"), "correct the count")
    step = pose_of_entry(entry)
    if sum(angle != 0 for angle in step.rpy) > 1:  # MuJoCo scales the angles, which is wrong for several axes
        message, help = "copies can only be rotated about one axis", 'rotate the element with its own "rpy"'
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
        link=frames.joint if frame == simulation.AT_JOINT else link,
        pose=_rounded(transform),
        stamp=stamp,
        elements=tuple(_sdf_elements(elements, (*path, "elements"), 1)),
        at_joint=frame == simulation.AT_JOINT,
        feels={"parent": frames.parent, "sensor": frames.sensor}.get(entry.get("feels", ""), ""),
        without=frozenset(str(name) for name, value in elements.items() if value is None),
    )


def _sdf_elements(entries: Mapping[str, Any], path: Path, depth: int) -> Iterator[SdfElement]:
    for name, value in entries.items():
        here = (*path, name)
        _check_name("SDF element", name, here)
        if depth >= MAX_DEPTH:
            message = f"elements are nested deeper than {MAX_DEPTH}"
            raise LoweringError("wrong-value", message, here, "SDF has none such")
        for index, item in enumerate(value) if isinstance(value, list) else [(None, value)]:
            at = here if index is None else (*here, index)
            if isinstance(item, Mapping):
                attributes, place = item.get("attributes") or {}, (*at, "attributes")
                if not isinstance(attributes, Mapping):
                    raise LoweringError("wrong-type", '"attributes" must be a mapping', place, 'write "{type: ...}"')
                for key in attributes:
                    _check_name("attribute", key, (*place, key))
                texts = {k: _sdf_value(text, (*place, k)) for k, text in attributes.items() if text is not None}
                inner = {key: inside for key, inside in item.items() if key != "attributes"}
                yield SdfElement(name, None, texts, tuple(_sdf_elements(inner, at, depth + 1)))
            elif item is not None:
                yield SdfElement(name, _sdf_value(item, at))


def _check_name(what: str, name: str, path: Path) -> None:
    if not _NAME.fullmatch(name):
        raise LoweringError("bad-name", f'"{name}" is not a valid name of an {what}', path, "correct the name")


def _sdf_value(value: Any, path: Path) -> float | str | bool:
    if isinstance(value, bool):
        return value
    if not isinstance(value, (str, int, float)):
        message = "an SDF element must be text, a number, or a mapping of elements"
        raise LoweringError("wrong-type", message, path, 'write "NAME: VALUE" for each element')
    return str(value) if isinstance(value, str) else float(value)


def _moved(element: SensorElement, sensor: Mapping[str, Any], frames: Frames) -> SensorElement:
    """If a sensor moves the Gazebo sensor of its sensor type, move a MuJoCo element of that type with it."""
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
        with suppress(ValueError):  # SDF composes the poses <sensor><pose> and <sensor><camera><pose>
            x, y, z, roll, pitch, yaw = map(float, str(inner.value).split())
            pose = pose.then(Pose((x, y, z), (roll, pitch, yaw)).transform())
    return pose if sensor.link == frames.sensor else frames.optical_pose.transform().then(pose)


def _around_shapes(element: SensorElement, links: Mapping[str, Link]) -> SensorElement:
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
    pose = pose_of(transform)
    x, y, z, roll, pitch, yaw = (0.0 if abs(value) < _ZERO else value for value in (*pose.xyz, *pose.rpy))
    return Pose((x, y, z), (roll, pitch, yaw))


SECTION: Section[Any] = Section("sensors", Sensor, lower=_sensors)

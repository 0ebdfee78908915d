"""What Gazebo has of a sensor: entries of ``gazebo`` as sensors in the words of SDF."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import Link, Pose, Transform
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.model.geometry import IDENTITY, pose_of
from rosorin_compile.model.simulation import AT_JOINT, GazeboSensor, SdfElement, Simulated

from ..expand.sensor_types import ChangedSensor
from .plainly import pose_of_entry
from .shapes import ShapeProblem

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

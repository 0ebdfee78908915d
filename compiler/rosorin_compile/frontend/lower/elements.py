"""Building what a simulation has of a sensor: the entries of its ``mjcf`` become elements, each in a link."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ...diagnostics.wording import listed
from ...model import BODY_ELEMENT, SENSOR_ELEMENT, TEMPLATE_ELEMENT, Attribute, Pose, Replicas, Simulated, pose_of
from .entries import pose_of_entry
from .shapes import ShapeProblem

# What a simulation can still do with.
MAX_COPIES = 100_000

_KINDS = (SENSOR_ELEMENT, BODY_ELEMENT, TEMPLATE_ELEMENT)


class Frames(NamedTuple):
    """The frames that an element may sit in: that of the sensor, its optical frame, and the link that it is on."""

    sensor: str
    mount: Pose
    parent: str
    optical: str = ""


def lower_elements(sensor: str, entries: Sequence[Mapping[str, Any]], frames: Frames) -> Iterator[Simulated]:
    """Yield the elements of a sensor. Raises ShapeProblem, whose path leads to the culprit within the entries."""
    for index, entry in enumerate(entries):
        try:
            yield _element(sensor, entry, frames)
        except ShapeProblem as problem:
            raise ShapeProblem(problem.rule, problem.message, (index, *problem.path), problem.help) from None


def _element(sensor: str, entry: Mapping[str, Any], frames: Frames) -> Simulated:
    kinds = [kind for kind in _KINDS if kind in entry]
    if len(kinds) != 1:
        message = f"an element of mjcf has one of {', '.join(_KINDS)}; this one has {listed(kinds) or 'none'}"
        raise ShapeProblem("missing-key", message, (), "write one entry an element")
    if "section" in entry and kinds[0] != TEMPLATE_ELEMENT:
        raise ShapeProblem("ignored-key", "only a template has a section", ("section",), "remove it")
    link, pose = _place(entry, frames)
    suffix = entry.get("name")
    return Simulated(
        kind=kinds[0],
        element=entry[kinds[0]],
        name=sensor if suffix is None else f"{sensor}_{suffix}",
        link=link,
        pose=pose,
        attributes={name: _attribute(value) for name, value in sorted(entry.get("attributes", {}).items())},
        replicas=_replicas(entry["replicate"]) if "replicate" in entry else None,
        section=entry.get("section", ""),
    )


def _place(entry: Mapping[str, Any], frames: Frames) -> tuple[str, Pose | None]:
    """Return the link of an element, and where it sits in it; None is at the frame of the link."""
    own = pose_of_entry(entry) if any(key in entry for key in ("xyz", "rpy", "replicate")) else None
    frame = entry.get("frame", "sensor")
    if frame == "sensor":
        return frames.sensor, own
    if frame == "parent":
        mount = frames.mount.transform()
        return frames.parent, frames.mount if own is None else pose_of(mount.then(own.transform()))
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


def _attribute(value: Any) -> Attribute:
    if isinstance(value, list):
        return tuple(_scalar(item) for item in value)
    return None if value is None else _scalar(value)


def _scalar(value: Any) -> float | str | bool:
    if isinstance(value, (bool, str)):
        return value if isinstance(value, bool) else str(value)
    return float(value)

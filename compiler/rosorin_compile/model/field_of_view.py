"""The fields of view of a sensor, from its MuJoCo elements or, if it has none, from its Gazebo elements."""

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

from .geometry import IDENTITY, Pose, pose_of
from .robot import Sensor
from .simulation import BODY_ELEMENT, SENSOR_ELEMENT, GazeboSensor, SdfElement, SensorElement

Data = dict[str, "Any"]

_FLAT = 1e-9  # rad; layers of a lidar whose elevations differ by less are the same layer
_DIGITS = 12
_LAYERS = 1000  # maximum number of lidar layers to show; if a lidar has more, evenly spaced layers are chosen
_IMAGE = Pose((0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2))  # optical frame relative to a frame with x forward
_CAMERA = Pose((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0))  # optical frame relative to a MuJoCo camera (looks along -z)
_AXES = ("gyro", "accelerometer", "magnetometer", "force", "torque")
_GAZEBO_AXES = ("imu", "magnetometer", "force_torque")


def page_pose(pose: Pose) -> Data:
    """Convert a pose to JSON data for the viewer page: metres, and radians about the fixed axes x, y, z."""
    return {"xyz": numbers(pose.xyz), "rpy": numbers(pose.rpy)}


def numbers(values: Sequence[float]) -> list[float]:
    """Return the values as a list, with 0.0 in place of -0.0."""
    return [value + 0.0 for value in values]


def seen_by(sensor: Sensor) -> list[Data]:
    """Return the fields of view of a sensor as JSON data for the viewer page.

    The "kind" is "frustum" (camera), "fan" (rays of a lidar), "box" or "axes". Fans that differ only in elevation are
    merged into the layers of one fan.
    """
    views = [view for one in sensor.simulated if (view := _of_mujoco(one))]
    views = views or [view for one in sensor.gazebo if not one.at_joint and (view := _of_gazebo(one))]
    if not views and any(one.type in _GAZEBO_AXES for one in sensor.gazebo):
        views = [{"kind": "axes", "frame": sensor.frame, **page_pose(IDENTITY)}]
    merged: list[Data] = []
    for view in views:
        same = next((one for one in merged if {**one, "layers": 0} == {**view, "layers": 0}), None)
        if same is None:
            merged.append(view)
        elif "layers" in view:
            same["layers"] += [rise for rise in view["layers"] if min(abs(rise - r) for r in same["layers"]) > _FLAT]
    return merged


def _of_mujoco(one: SensorElement) -> Data | None:
    pose, attributes = one.pose or IDENTITY, one.attributes
    place = {"frame": one.link, **page_pose(pose)}
    kind = one.element if one.kind in (BODY_ELEMENT, SENSOR_ELEMENT) else ""
    fovy, resolution, size, cutoff = (attributes.get(key) for key in ("fovy", "resolution", "size", "cutoff"))
    if kind == "camera" and isinstance(fovy, float | int) and isinstance(resolution, tuple):
        wide, tall = (float(value) for value in resolution)
        vertical = math.radians(float(fovy))
        return _frustum(one.link, pose, _CAMERA, 2 * math.atan(math.tan(vertical / 2) * wide / tall), vertical)
    if kind == "site" and attributes.get("type") == "box" and isinstance(size, tuple):
        return {"kind": "box", **place, "size": [2 * float(half) for half in size]}
    if kind != "rangefinder" or one.pose is None:
        return {"kind": "axes", **place} if kind in _AXES else None
    # A rangefinder measures along the z axis of its site. Its replicas are rotated about the z axis of the link.
    x, y, z = pose.transform().rotate((0.0, 0.0, 1.0))
    copies = one.replicas
    fan: Data = {"kind": "fan", "frame": one.link, "xyz": numbers(pose.xyz), "rpy": [0.0, 0.0, 0.0]}
    fan |= {"layers": [math.atan2(z, math.hypot(x, y))], "first": math.atan2(y, x)}
    fan |= {"step": copies.step.rpy[2] if copies else 0.0, "count": copies.count if copies else 1}
    return fan | ({"range": float(cutoff)} if isinstance(cutoff, float | int) and cutoff > 0 else {})


def _frustum(frame: str, pose: Pose, turn: Pose, horizontal: float, vertical: float) -> Data:
    roll, pitch, yaw = (round(angle, _DIGITS) for angle in pose_of(pose.transform().then(turn.transform())).rpy)
    place = page_pose(Pose(pose.xyz, (roll, pitch, yaw)))
    return {"kind": "frustum", "frame": frame, **place, "hfov": horizontal, "vfov": vertical}


def _of_gazebo(one: GazeboSensor) -> Data | None:
    wide, width, height = (_number(one, *path) for path in (("horizontal_fov",), ("width",), ("height",)))
    if wide and width and height:
        return _frustum(one.link, one.pose, _IMAGE, wide, 2 * math.atan(math.tan(wide / 2) * height / width))
    if "lidar" not in one.type and one.type != "ray":
        return None
    count, first, last = (_number(one, "horizontal", key) for key in ("samples", "min_angle", "max_angle"))
    layers, lowest, highest = (_number(one, "vertical", key) for key in ("samples", "min_angle", "max_angle"))
    layers = min(layers, _LAYERS)
    step = (last - first) / (count - 1) if count > 1 else 0.0
    rise = (highest - lowest) / (layers - 1) if layers > 1 else 0.0
    fan: Data = {"kind": "fan", "frame": one.link, **page_pose(one.pose)}
    fan["layers"] = [lowest + rise * layer for layer in range(int(layers) or 1)]
    fan |= {"first": first, "step": step, "count": int(count) or 1}
    reach = _number(one, "range", "max")
    return fan | ({"range": reach} if 0 < reach < math.inf else {})


def _number(one: GazeboSensor, *path: str) -> float:
    """Return the number in the first element that is nested in these tags, at any depth, or 0 if it is missing."""
    elements, value = one.elements, None
    for name in path:
        found = next((element for element in _all(elements) if element.name == name), None)
        elements, value = ((), None) if found is None else (found.elements, found.value)
    with suppress(ValueError):
        number = float(value or 0.0)
        return number if math.isfinite(number) else 0.0
    return 0.0


def _all(elements: Sequence[SdfElement]) -> Iterator[SdfElement]:
    for element in elements:
        yield element
        yield from _all(element.elements)

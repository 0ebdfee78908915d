"""The field of view of a sensor, from its simulation elements: a pyramid, rays, a contact zone, or axes.

MuJoCo's elements are asked first, Gazebo's where MuJoCo has none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from .geometry import IDENTITY, Pose, pose_of
from .robot import Sensor
from .simulation import BODY_ELEMENT, SENSOR_ELEMENT, GazeboSensor, SdfElement, Simulated

Data = dict[str, "Any"]

_FLAT = 1e-9  # rad; rays closer than this to one layer are in it
_DIGITS = 12
_LAYERS = 1000  # of a lidar; of more than that so many are seen, between the same two
_IMAGE = Pose((0.0, 0.0, 0.0), (-math.pi / 2, 0.0, -math.pi / 2))  # an image frame in one that looks along x
_CAMERA = Pose((0.0, 0.0, 0.0), (math.pi, 0.0, 0.0))  # and in a camera of MuJoCo, which looks along -z with y up
_AXES = ("gyro", "accelerometer", "magnetometer", "force", "torque")
_GAZEBO_AXES = ("imu", "magnetometer", "force_torque")


def placed(pose: Pose) -> Data:
    """Return a pose as the page has it: metres, and radians about the fixed axes x, y, z."""
    return {"xyz": numbers(pose.xyz), "rpy": numbers(pose.rpy)}


def numbers(values: Sequence[float]) -> list[float]:
    """Return numbers without minus zero."""
    return [value + 0.0 for value in values]


def seen_by(sensor: Sensor) -> list[Data]:
    """Return what a sensor sees; empty where its type does not say."""
    found = [seen for one in sensor.simulated if (seen := _simulated(one))]
    found = found or [seen for one in sensor.gazebo if not one.at_joint and (seen := _gazebo(one))]
    if not found and any(one.type in _GAZEBO_AXES for one in sensor.gazebo):
        found = [{"kind": "axes", "frame": sensor.frame, **placed(IDENTITY)}]
    return _merged(found)


def _simulated(one: Simulated) -> Data | None:
    """Return what an element of MuJoCo sees."""
    place = {"frame": one.link, **placed(one.pose or IDENTITY)}
    if one.kind == BODY_ELEMENT and one.element == "camera":
        return _camera(one)
    if one.kind == BODY_ELEMENT and one.element == "site" and one.attributes.get("type") == "box":
        return _zone(one, place)
    if one.kind != SENSOR_ELEMENT:
        return None
    if one.element == "rangefinder" and one.pose is not None:
        return _fan(one, one.pose)
    return {"kind": "axes", **place} if one.element in _AXES else None


def _camera(one: Simulated) -> Data | None:
    fovy, resolution = one.attributes.get("fovy"), one.attributes.get("resolution")
    if not isinstance(fovy, float | int) or not isinstance(resolution, tuple):
        return None
    wide, tall = (float(value) for value in resolution)
    vertical = math.radians(float(fovy))
    horizontal = 2 * math.atan(math.tan(vertical / 2) * wide / tall)
    return {
        "kind": "frustum",
        "frame": one.link,
        **placed(_turned(one.pose or IDENTITY, _CAMERA)),
        "hfov": horizontal,
        "vfov": vertical,
    }


def _turned(pose: Pose, turn: Pose) -> Pose:
    """Return a pose in the axes of another one that sits in it; what is left of rounding is rounded off."""
    turned = pose_of(pose.transform().then(turn.transform()))
    roll, pitch, yaw = (round(angle, _DIGITS) for angle in turned.rpy)
    return Pose(pose.xyz, (roll, pitch, yaw))


def _zone(one: Simulated, place: Data) -> Data | None:
    size = one.attributes.get("size")
    if not isinstance(size, tuple) or not all(isinstance(half, float | int) for half in size):
        return None
    return {"kind": "box", **place, "size": [2 * float(half) for half in size]}


def _fan(one: Simulated, pose: Pose) -> Data:
    """Return the rays of a rangefinder: it measures along z of its site, the next ones are turned about z."""
    x, y, z = pose.transform().rotate((0.0, 0.0, 1.0))
    copies = one.replicas
    made: Data = {"kind": "fan", "frame": one.link, "xyz": numbers(pose.xyz), "rpy": [0.0, 0.0, 0.0]}
    made |= {"layers": [math.atan2(z, math.hypot(x, y))], "first": math.atan2(y, x)}
    made |= {"step": copies.step.rpy[2] if copies else 0.0, "count": copies.count if copies else 1}
    cutoff = one.attributes.get("cutoff")
    return made | ({"range": float(cutoff)} if isinstance(cutoff, float | int) and cutoff > 0 else {})


def _merged(sees: Sequence[Data]) -> list[Data]:
    """Return fans that differ in their rise alone as layers of one, and what is there twice once."""
    made: list[Data] = []
    for seen in sees:
        rest = {key: value for key, value in seen.items() if key != "layers"}
        same = next((one for one in made if {k: v for k, v in one.items() if k != "layers"} == rest), None)
        if same is None:
            made.append(seen)
        elif "layers" in seen:
            same["layers"] += [rise for rise in seen["layers"] if min(abs(rise - r) for r in same["layers"]) > _FLAT]
    return made


def _gazebo(one: GazeboSensor) -> Data | None:
    """Return what a sensor of Gazebo sees, which looks along x."""
    wide, width, height = (_number(one, *path) for path in (("horizontal_fov",), ("width",), ("height",)))
    if wide and width and height:
        image = _turned(one.pose, _IMAGE)
        tall = 2 * math.atan(math.tan(wide / 2) * height / width)
        return {"kind": "frustum", "frame": one.link, **placed(image), "hfov": wide, "vfov": tall}
    if "lidar" not in one.type and one.type != "ray":
        return None
    count, first, last = (_number(one, "horizontal", key) for key in ("samples", "min_angle", "max_angle"))
    layers, lowest, highest = (_number(one, "vertical", key) for key in ("samples", "min_angle", "max_angle"))
    layers = min(layers, _LAYERS)
    step = (last - first) / (count - 1) if count > 1 else 0.0
    rise = (highest - lowest) / (layers - 1) if layers > 1 else 0.0
    made: Data = {"kind": "fan", "frame": one.link, **placed(one.pose)}
    made["layers"] = [lowest + rise * layer for layer in range(int(layers) or 1)]
    made |= {"first": first, "step": step, "count": int(count) or 1}
    reach = _number(one, "range", "max")
    return made | ({"range": reach} if 0 < reach < math.inf else {})


def _number(one: GazeboSensor, *path: str) -> float:
    """Return the number of the first element at the end of a path of names, whatever is between them; 0 without."""
    found = list(_all(one.elements))
    for name in path:
        here = [element for element in found if element.name == name]
        if not here:
            return 0.0
        found, value = list(_all(here[0].elements)), here[0].value
    try:
        number = float(value or 0.0)
    except ValueError:
        return 0.0
    return number if math.isfinite(number) else 0.0


def _all(elements: Sequence[SdfElement]) -> Iterator[SdfElement]:
    for element in elements:
        yield element
        yield from _all(element.elements)

"""Convert a ``<sensor>`` in a ``<gazebo>`` to an entry of ``sensors`` on the link that it is in.

The library's type that measures the same is used, with arguments as far as the element has them. What Gazebo has
differently or additionally becomes ``gazebo``: ``overlay`` compares the element with the one of the type.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.compare.precision import NOISE, same_number
from rosorin_compile.formats.gazebo_elements import SDF_DEFAULTS, SDF_FLAGS, SDF_TRUTH
from rosorin_compile.model import Robot, Sensor

from .blocks import Unsayable, plain

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

LIDARS = ("ray", "gpu_ray", "gpu_lidar", "lidar")
TYPES: Mapping[str, str] = {
    "camera": "camera",
    "depth": "depth_camera",
    "depth_camera": "depth_camera",
    "rgbd_camera": "depth_camera",
    "imu": "imu",
    "gps": "gnss",
    "navsat": "gnss",
    "contact": "contact",
    "force_torque": "force_torque",
    "magnetometer": "magnetometer",
    "altimeter": "altimeter",
}
IMAGES = ("camera", "depth_camera")
LIDAR_TYPES = ("lidar_2d", "lidar_3d", "range_finder")
MAX_RAYS = 2000  # more are a burden in MuJoCo: the lidar is left out of it
_CLASSIC = ("ray", "gpu_ray", "depth", "gps", "multicamera")
_MODERN = ("gpu_lidar", "rgbd_camera", "navsat")
_NAME = re.compile(r"""[^\s<>&"'/]+""")
_FRAMES = ("gz_frame_id", "ignition_frame_id")
_FRAME_NAMES = ("frame_name", "frameName", "frame_id")
_SMALLEST = 1e-4  # m: what the library takes as the least distance that is seen
_WIDEST = math.radians(170)
_NEAR = 5e-3  # rad: how precisely a circle is written


class Seen(NamedTuple):
    """A sensor of a source: what it is called, its type there, the link or joint that it is in, its elements."""

    name: str
    type: str
    reference: str
    elements: dict[str, Any]
    pose: tuple[float, ...]


def seen(element: Element, reference: str) -> Seen:
    """Return a <sensor> taken apart. Raises Unsayable."""
    extra = sorted(set(element.attrib) - {"name", "type"})
    if extra:
        raise Unsayable(f'the attribute "{extra[0]}"')
    name, kind = element.get("name", "").strip(), element.get("type", "").strip()
    if not _NAME.fullmatch(name):
        raise Unsayable(f'the name "{name}"' if name else "it has no name")
    made = _elements(element, exact=False)
    pose = made.pop("pose", None)
    if isinstance(pose, (dict, list)):
        raise Unsayable("a <pose> with attributes, or two")
    return Seen(name, kind, reference, made, _pose(pose))


def _pose(text: Any) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, str(text or "0 0 0 0 0 0").split()))
    except ValueError:
        raise Unsayable(f'its <pose> is "{text}"') from None
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        raise Unsayable(f'its <pose> is "{text}"')
    return tuple(0.0 if abs(number) <= NOISE else number for number in numbers)


def _elements(element: Element, exact: bool) -> dict[str, Any]:
    """Return what an element holds as the words of ``elements``; ``exact`` keeps texts as they are."""
    made: dict[str, Any] = {}
    for child in element:
        value = _value(child, exact or child.tag == "plugin")
        if child.tag in made:
            before = made[child.tag]
            made[child.tag] = [*before, value] if isinstance(before, list) else [before, value]
        else:
            made[child.tag] = value
    return made


def _value(element: Element, exact: bool) -> Any:
    text = (element.text or "").strip() + "".join((child.tail or "").strip() for child in element)
    if not re.fullmatch(r"[A-Za-z_][\w.-]*", element.tag) or element.tag == "attributes":
        raise Unsayable(f"an element is called <{element.tag}>")
    if (element.attrib or len(element)) and text:
        raise Unsayable(f"<{element.tag}> has a text beside attributes or elements")
    if element.tag in SDF_FLAGS and text in SDF_TRUTH and not exact:
        return SDF_TRUTH[text] == "true"
    if element.attrib or len(element) or not text:
        attributes = {name: plain(value) if exact else _scalar(value) for name, value in element.attrib.items()}
        return {**({"attributes": attributes} if attributes else {}), **_elements(element, exact)}
    return plain(text) if exact else _scalar(text)


def _scalar(text: str) -> Any:
    word = " ".join(text.split())
    if word in ("true", "false"):
        return word == "true"
    try:
        number = float(word)
    except ValueError:
        return word
    return number if "_" not in word and math.isfinite(number) else word


def gazebo_of(found: Sequence[Seen]) -> str:
    """Return which Gazebo most of some sensors are for: harmonic, fortress or classic."""
    votes = {"harmonic": 0, "fortress": 0, "classic": 0}
    for one in found:
        plugins = one.elements.get("plugin") or {}
        listed = plugins if isinstance(plugins, list) else [plugins]
        files = [str((item.get("attributes") or {}).get("filename", "")) for item in listed if isinstance(item, dict)]
        if "ignition_frame_id" in one.elements:
            votes["fortress"] += 1
        elif "gz_frame_id" in one.elements or one.type in _MODERN:
            votes["harmonic"] += 1
        elif one.type in _CLASSIC or any(re.match(r"lib.*(gazebo|hector).*\.so$", file) for file in files):
            votes["classic"] += 1
    return max(votes, key=lambda name: votes[name])


def entry(one: Seen, robot: Robot, asked: str) -> dict[str, Any]:
    """Return the entry of a sensor without what Gazebo has differently. Raises Unsayable."""
    kind = _kind(one)
    horizontal, vertical = (_inner(_lidar(one), "scan", axis) for axis in ("horizontal", "vertical"))
    frame = _frame(one, robot, kind)
    if kind == "contact":
        own = {frame, *(shape.name for shape in robot.link[frame].collision)}
        for name in collisions_of(one):
            base = re.sub(r"_collision(_\d+)?$", "", name.rpartition("_fixed_joint_lump__")[2])
            if base not in own and name not in own:
                raise Unsayable(f'it responds to the collision "{name}", which is not one of link "{frame}"')
    made: dict[str, Any] = {"type": kind, "frame": frame}
    rate, topic = one.elements.get("update_rate", 0.0), one.elements.get("topic")
    words: dict[str, Any] = {"rate": rate} if isinstance(rate, float) and rate >= 0 else {}
    words |= {"topic": topic} if isinstance(topic, str) and topic else {}
    if kind in LIDAR_TYPES:
        words |= _lidar_words(kind, _lidar(one), horizontal, vertical)
    elif kind in IMAGES:
        words |= _camera_words(_inner(one.elements, "camera"))
    elif kind == "imu":
        words |= _imu_words(_inner(one.elements, "imu"), asked)
    elif kind == "contact" and isinstance(topic := _inner(one.elements, "contact").get("topic"), str):
        words["topic"] = topic
    if words:
        made["with"] = words
    if kind in IMAGES:
        optical = _optical(one, robot, frame)
        made["optical"] = {"frame": optical} if optical else False
    elif kind in LIDAR_TYPES and not _in_mujoco(words, horizontal, vertical):
        made["mjcf"] = []
    stamp = _stamp(one)
    if stamp in robot.link and stamp not in (frame, made["optical"]["frame"] if made.get("optical") else frame):
        made["stamps"] = [stamp]
    return made


def _kind(one: Seen) -> str:
    if one.type in LIDARS:
        samples, layers = (_inner(_lidar(one), "scan", axis).get("samples", 1) for axis in ("horizontal", "vertical"))
        if not (_is_count(samples) and _is_count(layers)):
            raise Unsayable("the number of its rays is no whole number")
        return "lidar_3d" if layers > 1 else "lidar_2d" if samples > 1 else "range_finder"
    if one.type not in TYPES:
        raise Unsayable(f'the library has no type of sensor for "{one.type}"')
    return TYPES[one.type]


def _frame(one: Seen, robot: Robot, kind: str) -> str:
    if kind == "force_torque":
        if any(one.pose):
            raise Unsayable("a sensor at a joint with a <pose>")
        if one.reference not in robot.joint:
            raise Unsayable(f'"{one.reference}" is no joint of the URDF')
        return robot.joint[one.reference].child
    if one.reference not in robot.link:
        raise Unsayable(f'"{one.reference}" is no link of the URDF' if one.reference else "no reference says its link")
    return one.reference


def _lidar(one: Seen) -> Mapping[str, Any]:
    return _inner(one.elements, "ray") or _inner(one.elements, "lidar")


def _inner(values: Mapping[str, Any], *path: str) -> Mapping[str, Any]:
    for key in path:
        found = values.get(key)
        values = found if isinstance(found, dict) else {}
    return values


def _is_count(value: Any) -> bool:
    return (isinstance(value, float) and value == int(value) and 1 <= value <= 100_000) or value == 1


def _is_positive(value: Any) -> bool:
    return isinstance(value, float) and value > 0


def _noise(word: str, noise: Mapping[str, Any]) -> dict[str, Any]:
    kind, stddev = noise.get("type", _inner(noise, "attributes").get("type")), noise.get("stddev")
    return {word: stddev} if kind == "gaussian" and _is_positive(stddev) and not noise.get("mean") else {}


def _lidar_words(
    kind: str, lidar: Mapping[str, Any], horizontal: Mapping[str, Any], vertical: Mapping[str, Any]
) -> dict[str, Any]:
    """Return rays, layers, fields of view and ranges."""
    made: dict[str, Any] = {}
    limits = _inner(lidar, "range")
    if kind != "range_finder":
        made["rays"] = int(horizontal["samples"])
        made |= _field_of_view("fov", horizontal, math.tau, made["rays"])
    if kind == "lidar_3d":
        made["layers"] = int(vertical["samples"])
        made |= _field_of_view("vertical_fov", vertical, math.radians(179), 0)
    if _is_positive(limits.get("max")):
        made["max_range"] = limits["max"]
    if _is_positive(limits.get("min")) and limits["min"] >= _SMALLEST:
        made["min_range"] = limits["min"]
    return made | _noise("noise", _inner(lidar, "noise"))


def _field_of_view(word: str, axis: Mapping[str, Any], widest: float, rays: int) -> dict[str, Any]:
    """Return the field of view if it is symmetric; a full circle is the default of the library."""
    low, high = axis.get("min_angle"), axis.get("max_angle")
    if not isinstance(low, float) or not isinstance(high, float):
        return {}
    span = high - low
    if (rays and abs(span + span / max(rays - 1, 1) - math.tau) < _NEAR) or span >= math.tau - _NEAR:
        return {}
    return {word: 2 * high if abs(low + high) <= NOISE else span} if 0 < span <= widest else {}


def _in_mujoco(words: Mapping[str, Any], horizontal: Mapping[str, Any], vertical: Mapping[str, Any]) -> bool:
    """Return True if MuJoCo can simulate a lidar: its rays are symmetric, and not too many."""
    if int(words.get("rays", 1)) * int(words.get("layers", 1)) > MAX_RAYS:
        return False
    for axis, word in ((horizontal, "fov"), (vertical, "vertical_fov")):
        low, high = axis.get("min_angle", 0.0), axis.get("max_angle", 0.0)
        if not isinstance(low, float) or not isinstance(high, float):
            return False
        full = math.tau - 2 * _NEAR - math.tau / words.get("rays", 1)
        is_circle = word == "fov" and word not in words and high - low >= full
        if not is_circle and abs(low + high) > _NEAR:
            return False
    return True


def _camera_words(camera: Mapping[str, Any]) -> dict[str, Any]:
    made: dict[str, Any] = {}
    hfov = camera.get("horizontal_fov", 1.047)
    if isinstance(hfov, float) and math.radians(1) <= hfov <= _WIDEST:
        made["hfov"] = hfov
    for section, key in (("image", "width"), ("image", "height"), ("clip", "near"), ("clip", "far")):
        value = _inner(camera, section).get(key, float(SDF_DEFAULTS[section][key]))
        if section == "image" and _is_count(value):
            made[key] = int(value)
        elif section == "clip" and _is_positive(value) and value >= _SMALLEST:
            made[key] = value
    return made | _noise("noise", _inner(camera, "noise"))


def _imu_words(imu: Mapping[str, Any], asked: str) -> dict[str, Any]:
    made: dict[str, Any] = {}
    if imu.get("enable_orientation", True if asked != "classic" else None) in (True, 1.0):
        made["orientation"] = True
    for word, what in (("gyro_noise", "angular_velocity"), ("accelerometer_noise", "linear_acceleration")):
        x, y, z = (_inner(imu, what, axis, "noise") for axis in "xyz")
        made |= _noise(word, x) if x and x == y == z else {}
    return made


def collisions_of(one: Seen) -> list[str]:
    """Return the names of the collisions that a contact sensor responds to."""
    names = _inner(one.elements, "contact").get("collision", [])
    return [str(name) for name in (names if isinstance(names, list) else [names])]


def without_collisions(texts: Sequence[str]) -> list[str]:
    """Return elements without the names of the collisions of contact sensors: they follow from the shapes of a link."""
    return [re.sub(r"<collision>[^<]*</collision>", "", text) for text in texts]


def _stamp(one: Seen) -> str:
    """Return the frame that messages carry, as the element of Gazebo or a plug-in names it."""
    for name in _FRAMES:
        if isinstance(one.elements.get(name), str):
            return str(one.elements[name])
    plugins = one.elements.get("plugin") or []
    for plugin in plugins if isinstance(plugins, list) else [plugins]:
        for name in _FRAME_NAMES if isinstance(plugin, dict) else ():
            if isinstance(plugin.get(name), str):
                return str(plugin[name]).lstrip("/")
    return ""


def _optical(one: Seen, robot: Robot, frame: str) -> str:
    """Return the image frame that belongs to a camera: fixed to its frame, turned as one, and called so."""
    if "optical" in frame:
        return ""
    below, waiting = list[str](), [frame]
    while waiting:
        link = waiting.pop(0)
        fixed = [joint.child for joint in robot.joints if joint.parent == link and joint.is_fixed]
        below += [name for name in fixed if "optical" in name]
        waiting += fixed
    stamp = _stamp(one)
    return stamp if stamp in below else below[0] if below and not stamp else ""


def overlay(one: Seen, sensor: Sensor, asked: str) -> dict[str, Any]:
    """Return what a sensor of the source has otherwise than the one of Gazebo that its type brings, or besides."""
    made: dict[str, Any] = {}
    brought = sensor.gazebo[0]
    frame_id = brought.FRAME_ELEMENTS[asked]
    if asked == "classic":  # elements keep the names that a description has
        brought = replace(brought, type=brought.in_classic().type)
    if one.type != brought.type:
        made["sensor"] = one.type
    pose = (*brought.pose.xyz, *brought.pose.rpy)
    stamp = brought.stamp
    if any(abs(a - b) > NOISE for a, b in zip(pose, one.pose, strict=True)):
        image = TYPES.get(one.type) in IMAGES
        made |= {"frame": "sensor"} if image else {}
        made |= {"xyz": list(one.pose[:3])} if any((*one.pose[:3], *pose[:3])) else {}
        made |= {"rpy": list(one.pose[3:])} if image or any(one.pose[3:]) else {}
        stamp = "" if image else stamp
    elements = dict(one.elements)
    lidar = "ray" if asked == "classic" or one.type in ("gpu_lidar", "lidar") else ""
    if lidar in elements and "lidar" not in elements:
        elements = {("lidar" if key == lidar else key): value for key, value in elements.items()}
    if brought.feels and "contact" in elements:  # its shapes are those of the link
        contact = _inner(elements, "contact").items()
        elements["contact"] = {key: value for key, value in contact if key != "collision"}
    own = {item.name: item.words() for item in brought.elements}
    if frame_id and not any(name in elements for name in _FRAMES):
        elements[frame_id] = None
    elif frame_id and elements.get(frame_id) == stamp:
        del elements[frame_id]
    changes = _changes(own, elements, ("sensor",))
    if changes:
        made["elements"] = changes
    return made


def _changes(own: Mapping[str, Any], wanted: Mapping[str, Any], above: tuple[str, ...]) -> dict[str, Any]:
    """Return what makes one mapping of elements another: what is new or other, and None for what goes."""
    made: dict[str, Any] = {}
    for key, value in wanted.items():
        if key not in own:
            if not _is_default((*above, key), value):
                made[key] = value
        elif isinstance(value, dict) and isinstance(own[key], dict):
            inner = _changes(own[key], value, (*above, key))
            if inner:
                made[key] = inner
        elif not _same(own[key], value):
            made[key] = value
    for key, value in own.items():
        if key not in wanted and not _is_default((*above, key), value):
            made[key] = None
    return made


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return same_number(one, other)
    return bool(one == other) and isinstance(one, bool) == isinstance(other, bool)


def _is_default(path: tuple[str, ...], value: Any) -> bool:
    if isinstance(value, dict):
        return bool(value) and all(_is_default((*path, key), item) for key, item in value.items())
    default = SDF_DEFAULTS.get(path[-2], {}).get(path[-1]) if len(path) > 1 else None
    return default is not None and _same(value, _scalar(default))

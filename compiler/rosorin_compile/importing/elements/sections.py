"""Convert Gazebo and ros2_control elements to entries of the ``sensors`` and ``control`` sections.

A ``<sensor>`` becomes an entry with a sensor type of the parts library, and arguments such as range, rays and image
size. ``overlay`` compares it with the ``<sensor>`` that this type generates, and puts the differences into the key
``gazebo``. A ``<ros2_control>`` is read in the syntax of Humble or Jazzy. Content that an entry cannot represent is
detected later, when the entry is compiled and compared with the element.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

from rosorin_compile.compare.precision import NOISE
from rosorin_compile.formats.gazebo import SDF_DEFAULTS, SDF_FLAGS, SDF_TRUTH
from rosorin_compile.model import Robot, Sensor
from rosorin_compile.source.numbers import exact

LIDARS = ("ray", "gpu_ray", "gpu_lidar", "lidar")
_ALIKE = ("camera", "depth_camera", "imu", "contact", "force_torque", "magnetometer", "altimeter")
TYPES: Mapping[str, str] = {
    **{name: name for name in _ALIKE},
    **dict.fromkeys(("depth", "rgbd_camera"), "depth_camera"),
    **dict.fromkeys(("gps", "navsat"), "gnss"),
}
IMAGES = ("camera", "depth_camera")
LIDAR_TYPES = ("lidar_2d", "lidar_3d", "range_finder")
MAX_RAYS = 2000  # lidars with more rays are too slow for MuJoCo and are not written to the MJCF
_CLASSIC = ("ray", "gpu_ray", "depth", "gps", "multicamera")
_MODERN = ("gpu_lidar", "rgbd_camera", "navsat")
_FRAMES = ("gz_frame_id", "ignition_frame_id")
_FRAME_NAMES = ("frame_name", "frameName", "frame_id")
_NEAR = 5e-3  # rad, tolerance for symmetric angles and full circles
# Argument of a sensor type of the parts library -> (element, child element) in SDF with the same value.
_RANGES = {"max_range": ("range", "max"), "min_range": ("range", "min")}
_LENSES = {
    "hfov": ("camera", "horizontal_fov"),
    "width": ("image", "width"),
    "height": ("image", "height"),
    "near": ("clip", "near"),
    "far": ("clip", "far"),
}
_WIDEST = {"hfov": math.radians(170), "fov": math.tau, "vertical_fov": math.radians(179)}
_SMALLEST = 1e-4  # m, the smallest range that library sensor types accept
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_INTERFACE_NUMBERS = {"min": "min", "max": "max", "initial_value": "initial"}


class CannotConvert(Exception):
    """An element has content that the description language cannot express; the message names the content."""


class GazeboSensor(NamedTuple):
    """A parsed <sensor>: ``reference`` is its link or joint, ``pose`` is x, y, z (m), roll, pitch, yaw (rad)."""

    name: str
    type: str
    reference: str
    elements: dict[str, Any]
    pose: tuple[float, ...]

    def inner(self, *path: str) -> Mapping[str, Any]:
        """Return the children of the element at a path of tags; ``lidar`` also matches <ray> (Gazebo classic)."""
        values: Mapping[str, Any] = self.elements
        for key in path:
            found = values.get(key) or (values.get("ray") if key == "lidar" else None)
            values = found if isinstance(found, dict) else {}
        return values

    @property
    def stamp(self) -> str:
        """The frame_id of the sensor messages, from a Gazebo element or a plug-in, or "" if unset."""
        plugins = self.elements.get("plugin") or []
        plugins = plugins if isinstance(plugins, list) else [plugins]
        named = [self.elements.get(name) for name in _FRAMES]
        named += [one.get(name) for one in plugins if isinstance(one, dict) for name in _FRAME_NAMES]
        return next((name.lstrip("/") for name in named if isinstance(name, str)), "")


def read_sensor(element: Element, reference: str) -> GazeboSensor:
    """Parse the <sensor> of the link or joint ``reference``. Raises CannotConvert if <pose> is not six numbers."""
    made = _elements(element, exact=False)
    try:
        numbers = tuple(map(float, str(made.pop("pose", None) or "0 0 0 0 0 0").split()))
    except ValueError:
        numbers = ()
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        raise CannotConvert("its <pose> is not six numbers")
    pose = tuple(0.0 if abs(number) <= NOISE else number for number in numbers)
    return GazeboSensor(element.get("name", "").strip(), element.get("type", "").strip(), reference, made, pose)


def _elements(element: Element, exact: bool) -> dict[str, Any]:
    """Convert child elements to nested mappings; ``exact`` keeps numbers as strings if formatting would change them."""
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
    text, read = (element.text or "").strip(), plain if exact else _scalar
    if element.tag in SDF_FLAGS and text in SDF_TRUTH and not exact:
        return SDF_TRUTH[text] == "true"
    if element.attrib or len(element) or not text:
        attributes = {name: read(value) for name, value in element.attrib.items()}
        return {**({"attributes": attributes} if attributes else {}), **_elements(element, exact)}
    return read(text)


def _scalar(text: str) -> Any:
    word = " ".join(text.split())
    number = _number(word)
    return word == "true" if word in ("true", "false") else word if number is None else number


def gazebo_of(elements: Sequence[Element]) -> str:
    """Return the Gazebo version that most <sensor> elements are written for: harmonic, fortress or classic."""
    votes = {"harmonic": 0, "fortress": 0, "classic": 0}
    for one in elements:
        kind, files = one.get("type", "").strip(), [plugin.get("filename", "") for plugin in one.findall("plugin")]
        if one.find("ignition_frame_id") is not None:
            votes["fortress"] += 1
        elif one.find("gz_frame_id") is not None or kind in _MODERN:
            votes["harmonic"] += 1
        elif kind in _CLASSIC or any(re.match(r"lib.*(gazebo|hector).*\.so$", file) for file in files):
            votes["classic"] += 1
    return max(votes, key=lambda name: votes[name])


def entry(one: GazeboSensor, robot: Robot, gazebo: str) -> dict[str, Any]:
    """Convert a sensor to an entry of ``sensors``, without the key ``gazebo``. Raises CannotConvert if impossible."""
    kind, frame = TYPES.get(one.type, ""), one.reference
    if one.type in LIDARS:
        rays, layers = (one.inner("lidar", "scan", axis).get("samples", 1.0) for axis in ("horizontal", "vertical"))
        if not (_is_count(rays) and _is_count(layers)):
            raise CannotConvert("the number of its rays is not a whole number")
        kind = "lidar_3d" if layers > 1 else "lidar_2d" if rays > 1 else "range_finder"
    elif not kind:
        raise CannotConvert(f'the library has no type of sensor for "{one.type}"')
    if kind == "force_torque":
        if frame not in robot.joint or any(one.pose):
            raise CannotConvert(f'"{frame}" is not a joint of the URDF, or it has a <pose> there')
        frame = robot.joint[frame].child
    elif frame not in robot.link:
        raise CannotConvert(f'"{frame}" is not a link of the URDF' if frame else "no reference defines its link")
    if kind == "contact":
        own, names = {frame, *(shape.name for shape in robot.link[frame].collision)}, one.inner("contact")
        named = names.get("collision", [])
        for name in map(str, named if isinstance(named, list) else [named]):
            base = re.sub(r"_collision(_\d+)?$", "", name.rpartition("_fixed_joint_lump__")[2])
            if base not in own and name not in own:
                raise CannotConvert(f'it responds to the collision "{name}", which is not one of link "{frame}"')
    made: dict[str, Any] = {"type": kind, "frame": frame}
    if arguments := _arguments(one, kind, gazebo):
        made["with"] = arguments
    stamp, optical = one.stamp, ""
    if kind in IMAGES:  # find the optical frame, a link that is fixed to the camera
        near = [frame, *(joint.child for joint in robot.joints if joint.parent == frame and joint.is_fixed)]
        fixed = [joint.child for joint in robot.joints if joint.parent in near and joint.is_fixed]
        below = [name for name in fixed if "optical" in name and "optical" not in frame]
        optical = stamp if stamp in below else below[0] if below and not stamp else ""
        made["optical"] = {"frame": optical} if optical else False
    elif kind in LIDAR_TYPES:
        axes = {"fov": one.inner("lidar", "scan", "horizontal"), "vertical_fov": one.inner("lidar", "scan", "vertical")}
        ends = [(axis["min_angle"], axis["max_angle"]) for word, axis in axes.items() if word in arguments]
        count = int(arguments.get("rays", 1)) * int(arguments.get("layers", 1))
        if count > MAX_RAYS or any(abs(low + high) > _NEAR for low, high in ends):
            made["mjcf"] = []  # omit from the MJCF: too slow, or asymmetric, which MuJoCo does not support
    if stamp in robot.link and stamp not in (frame, optical):
        made["stamps"] = [stamp]
    return made


def _arguments(one: GazeboSensor, kind: str, gazebo: str) -> dict[str, Any]:
    """Return the arguments for a sensor type of the parts library, without numbers that the type does not accept."""
    rate, topic = one.elements.get("update_rate", 0.0), one.elements.get("topic")
    topic = one.inner("contact").get("topic", topic) if kind == "contact" else topic
    made: dict[str, Any] = {"rate": rate} if isinstance(rate, float) and rate >= 0 else {}
    made |= {"topic": topic} if isinstance(topic, str) and topic else {}
    if kind == "imu":
        if one.inner("imu").get("enable_orientation", True if gazebo != "classic" else None) in (True, 1.0):
            made["orientation"] = True
        for word, what in (("gyro_noise", "angular_velocity"), ("accelerometer_noise", "linear_acceleration")):
            x, y, z = (one.inner("imu", what, axis, "noise") for axis in "xyz")
            made |= _noise(word, x) if x and x == y == z else {}
    if kind not in (*LIDAR_TYPES, *IMAGES):
        return made
    name, numbers = ("camera", _LENSES) if kind in IMAGES else ("lidar", _RANGES)
    if name == "lidar":
        horizontal, vertical = (one.inner("lidar", "scan", axis) for axis in ("horizontal", "vertical"))
        if kind != "range_finder":
            made["rays"] = int(horizontal["samples"])
            made |= _field_of_view("fov", horizontal, made["rays"])
        if kind == "lidar_3d":
            made["layers"] = int(vertical["samples"])
            made |= _field_of_view("vertical_fov", vertical, 0)
    for word, (section, key) in numbers.items():
        holder = one.inner(name) if section == name else one.inner(name, section)
        value = holder.get(key, _scalar(SDF_DEFAULTS.get(section, {}).get(key, "")))
        if section == "image" and _is_count(value):
            made[word] = int(value)
        elif section != "image" and isinstance(value, float) and _SMALLEST <= value <= _WIDEST.get(word, math.inf):
            made[word] = value
    return made | _noise("noise", one.inner(name, "noise"))


def _is_count(value: Any) -> bool:
    return isinstance(value, float) and 1 <= value <= 100_000 and value == int(value)


def _noise(word: str, noise: Mapping[str, Any]) -> dict[str, Any]:
    kind, stddev = noise.get("type", (noise.get("attributes") or {}).get("type")), noise.get("stddev")
    is_gaussian = kind == "gaussian" and isinstance(stddev, float) and stddev > 0 and not noise.get("mean")
    return {word: stddev} if is_gaussian else {}


def _field_of_view(word: str, axis: Mapping[str, Any], rays: int) -> dict[str, Any]:
    """Return {word: field of view (rad)} for the scan axis ``axis``, or {} for a full circle, which is the default."""
    low, high = axis.get("min_angle"), axis.get("max_angle")
    if not isinstance(low, float) or not isinstance(high, float):
        return {}
    span = high - low
    if (rays and abs(span + span / max(rays - 1, 1) - math.tau) < _NEAR) or span >= math.tau - _NEAR:
        return {}
    return {word: 2 * high if abs(low + high) <= NOISE else span} if 0 < span <= _WIDEST[word] else {}


def without_collisions(texts: Sequence[str]) -> list[str]:
    """Remove the <collision> names in contact sensors from XML, because they follow from the shapes of the link."""
    return [re.sub(r"<collision>[^<]*</collision>", "", text) for text in texts]


def overlay(one: GazeboSensor, sensor: Sensor, gazebo: str) -> dict[str, Any]:
    """Return the values of the key ``gazebo`` that make the generated ``sensor`` equal to ``one``, the original."""
    made: dict[str, Any] = {}
    if len(sensor.gazebo) != 1:
        return made
    brought = sensor.gazebo[0]
    frame_id = brought.FRAME_ELEMENTS[gazebo]
    if gazebo == "classic":  # only convert the type, because a description has the element names of new Gazebo versions
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
    lidar = "ray" if gazebo == "classic" or one.type in ("gpu_lidar", "lidar") else ""
    if lidar in elements and "lidar" not in elements:
        elements = {("lidar" if key == lidar else key): value for key, value in elements.items()}
    if brought.feels and "contact" in elements:  # ignore collision names, which are generated from the link
        elements["contact"] = {key: value for key, value in one.inner("contact").items() if key != "collision"}
    if frame_id and not any(name in elements for name in _FRAMES):
        elements[frame_id] = None
    elif frame_id and elements.get(frame_id) == stamp:
        del elements[frame_id]
    changes = _changes({item.name: item.words() for item in brought.elements}, elements, ("sensor",))
    return made | ({"elements": changes} if changes else {})


def _changes(own: Mapping[str, Any], wanted: Mapping[str, Any], above: tuple[str, ...]) -> dict[str, Any]:
    """Return the values in ``wanted`` that differ from ``own``, and None for each key that is only in ``own``."""
    made: dict[str, Any] = {}
    for key, value in wanted.items():
        if isinstance(value, dict) and isinstance(own.get(key), dict):
            inner = _changes(own[key], value, (*above, key))
            made |= {key: inner} if inner else {}
        elif not (_same(own[key], value) if key in own else _is_default((*above, key), value)):
            made[key] = value
    gone = [key for key, value in own.items() if key not in wanted and not _is_default((*above, key), value)]
    return made | dict.fromkeys(gone)


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=NOISE, abs_tol=NOISE)
    return bool(one == other) and isinstance(one, bool) == isinstance(other, bool)


def _is_default(path: tuple[str, ...], value: Any) -> bool:
    if isinstance(value, dict):
        return bool(value) and all(_is_default((*path, key), item) for key, item in value.items())
    default = SDF_DEFAULTS.get(path[-2], {}).get(path[-1]) if len(path) > 1 else None
    return default is not None and _same(value, _scalar(default))


def block(element: Element, robot: Robot, humble: bool) -> dict[str, Any]:
    """Convert a <ros2_control> block to an entry of ``control``, in the syntax of Humble (``humble``) or Jazzy."""
    hardware = element.find("hardware")
    hardware = Element("hardware") if hardware is None else hardware
    kind = element.get("type", "").strip()
    groups, flag = hardware.findall("group")[-1:], element.get("is_async", "").strip()
    entry = {
        "type": None if kind == "system" else kind,
        "plugin": _text(hardware.find("plugin")),
        "group": _text(groups[0]) if groups else None,
        "params": _params(hardware),
        "rate": _integer(element.get("rw_rate")),
        "thread_priority": _integer(element.get("thread_priority")),
        "async": _FLAGS.get(flag, flag),
        "joints": _by_name(element, "joint", lambda joint: _joint(joint, robot, humble)),
        "sensors": _by_name(element, "sensor", lambda sensor: _component(sensor) or None),
        "gpio": _by_name(element, "gpio", lambda gpio: _component(gpio) or None),
    }
    return _without_empty(entry)


def _without_empty(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if value or value == 0}


def _joint(element: Element, robot: Robot, humble: bool) -> dict[str, Any] | None:
    joint = robot.joint.get(element.get("name", ""))
    entry = _component(element)
    if element.find("limits") is not None:
        entry["limits"] = False
    elif joint is not None:
        commands = entry.get("command", {})
        if not isinstance(commands, dict):
            commands = dict.fromkeys([commands] if isinstance(commands, str) else commands)
        for interface, numbers in commands.items():  # set "limits: urdf" if a command omits a limit of the joint
            low, high = joint.limits_of(interface)
            ends = {end for end, limit in (("min", low), ("max", high)) if limit is not None}
            if not ends <= (numbers or {}).keys():
                entry["limits"] = "urdf"
    if not humble and "mimic" in element.attrib:
        flag = element.attrib["mimic"].strip()
        if not (joint and joint.mimic and _FLAGS.get(flag) is True):
            entry["mimic"] = _FLAGS.get(flag, flag)
    elif humble and joint is not None and joint.mimic is not None:
        # On Humble, the parameter ``mimic`` names the leader joint; without the parameter, the joint is not coupled.
        params = entry.get("params", {})
        if params.pop("mimic", None) is None:
            entry["mimic"] = False
        params.pop("multiplier", None)
    return _without_empty(entry) or None


def _component(element: Element) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    for key in ("command", "state"):
        interfaces = _by_name(element, f"{key}_interface", _interface)
        names = list(interfaces)
        entry[key] = interfaces if any(interfaces.values()) else names[0] if len(names) == 1 else names
    return _without_empty({**entry, "params": _params(element)})


def _interface(element: Element) -> dict[str, Any] | None:
    params = _params(element)
    numbers = {key: _number(str(params.get(name, ""))) for name, key in _INTERFACE_NUMBERS.items()}
    params = {name: value for name, value in params.items() if numbers.get(_INTERFACE_NUMBERS.get(name, "")) is None}
    entry = {"data_type": element.get("data_type"), "size": _integer(element.get("size")), "params": params}
    return _without_empty({**numbers, **entry}) or None


def _by_name(element: Element, tag: str, read: Callable[[Element], Any]) -> dict[str, Any]:
    return {child.get("name", ""): read(child) for child in element if child.tag == tag}


def _params(element: Element) -> dict[str, Any]:
    return {child.get("name", ""): plain(_text(child)) for child in element if child.tag == "param"}


def plain(text: str) -> Any:
    """Parse a number or boolean if formatting the value gives the same string; return other strings unchanged."""
    if text in ("true", "false"):
        return text == "true"
    number = _number(text)
    return number if number is not None and exact(number) == text else text


def _integer(text: str | None) -> Any:
    return int(text) if text is not None and text.strip().isdecimal() else text


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if "_" not in text and number - number == 0 else None


def _text(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()

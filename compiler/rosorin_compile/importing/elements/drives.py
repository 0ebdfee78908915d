"""Read the drive and the published transforms from known plug-ins of Gazebo.

The plug-in itself is kept, because no output writes one. Its wheels become ``drive``, and the transform that it
publishes becomes an edge with a publisher.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Drive, Robot
from rosorin_compile.model.drive import Driving

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_BRIDGE = "ros_gz_bridge"
_FAR = 0.1  # relative difference from which on a size is another one


class Drives(NamedTuple):
    """The result: sections of a description, the plug-ins they came from, and reasons for what is kept."""

    sections: dict[str, Any]
    names: dict[str, list[str]]
    kept: dict[str, str]


class Plugin(NamedTuple):
    """A known plug-in: the element names of its wheels by role, of its sizes, and of its transform.

    Alternative names of an element are separated by spaces. ``odom`` and ``base`` name the frames, each with its
    default; ``publishes`` turns the transform on. A ``bridged`` plug-in publishes through ros_gz_bridge.
    """

    kind: str = ""
    roles: Mapping[str, tuple[str, ...]] = {}
    separation: str = "wheel_separation wheelSeparation"
    radius: str = "wheel_radius"
    diameter: str = "wheel_diameter wheelDiameter"
    odom: tuple[str, str] = ("frame_id", "")
    base: tuple[str, str] = ("child_frame_id", "")
    publishes: tuple[str, bool] = ("tf_topic", False)
    bridged: bool = True


_CORNERS = [(end, side) for end in ("front", "back") for side in ("left", "right")]
_CLASSIC = Plugin(
    odom=("odometry_frame odometryFrame", "odom"),
    base=("robot_base_frame robotBaseFrame", "base_footprint"),
    publishes=("publish_odom_tf publishOdomTF", True),
    bridged=False,
)
# gz-sim@gz-sim8:src/systems/{diff_drive,mecanum_drive,ackermann_steering,odometry_publisher}, and
# gazebo_ros_pkgs@{melodic-devel,ros2}:gazebo_plugins/src.
_KNOWN: Mapping[str, Plugin] = {
    "diff-drive-system": Plugin(Drive.DIFFERENTIAL, {"left": ("left_joint",), "right": ("right_joint",)}),
    "mecanum-drive-system": Plugin(
        Drive.MECANUM,
        {f"{'rear' if end == 'back' else end}_{side}": (f"{end}_{side}_joint",) for end, side in _CORNERS},
    ),
    "ackermann-steering-system": Plugin(
        Drive.ACKERMANN,
        {"driven": ("left_joint", "right_joint"), "steering": ("left_steering_joint", "right_steering_joint")},
    ),
    "odometry-publisher-system": Plugin(odom=("odom_frame", ""), base=("robot_base_frame", "")),
    "libgazebo_ros_diff_drive": _CLASSIC._replace(
        kind=Drive.DIFFERENTIAL,
        roles={"left": ("left_joint leftJoint",), "right": ("right_joint rightJoint",)},
        publishes=("publish_odom_tf publishOdomTF publishTf", False),
    ),
    "libgazebo_ros_planar_move": _CLASSIC,
}


def read_drives(elements: Iterable[Element], robot: Robot) -> Drives:
    """Return what the plug-ins among elements specify about the drive and the transforms of a robot."""
    found = Drives({}, {}, {})
    for plugin in (child for element in elements if element.tag == "gazebo" for child in element):
        file = plugin.get("filename", "").removesuffix(".so")
        known = next((known for name, known in _KNOWN.items() if file.endswith(name)), None)
        if plugin.tag != "plugin" or known is None:
            continue
        name = plugin.get("name", "").strip() or "plug-in"
        if known.kind and (reason := _add_drive(plugin, known, name, robot, found)):
            found.kept[f'the drive of "{name}"'] = reason
        if reason := _add_edge(plugin, known, name, robot, found):
            found.kept[f'the transform of "{name}"'] = reason
    return found


def _texts(plugin: Element, names: str) -> list[str]:
    """Return the texts of the first of several elements that exists."""
    found = ([(child.text or "").strip() for child in plugin if child.tag == name] for name in names.split())
    return next(filter(None, found), [])


def _text(plugin: Element, names: str, default: str = "") -> str:
    return next(iter(_texts(plugin, names)), default)


def _number(plugin: Element, names: str) -> float | None:
    try:
        return float(_text(plugin, names))
    except ValueError:
        return None


def _add_drive(plugin: Element, known: Plugin, name: str, robot: Robot, found: Drives) -> str:
    """Add the drive to the sections; return the reason if it is kept, else ""."""
    if "drive" in found.sections:
        return "the robot has another one: a robot has one drive"
    roles = {role: tuple(text for tag in tags for text in _texts(plugin, tag)) for role, tags in known.roles.items()}
    missing = next((joint for joints in roles.values() for joint in joints if joint not in robot.joint), None)
    if missing is not None:
        return f'"{missing}" is not a joint of the URDF'
    is_mecanum = known.kind == Drive.MECANUM
    if not all(roles.values()) or (is_mecanum and any(len(joints) != 1 for joints in roles.values())):
        return "it does not name its wheels"
    base, diameter = _text(plugin, *known.base).lstrip("/"), _number(plugin, known.diameter)
    radius = _number(plugin, known.radius) if diameter is None else diameter / 2
    wheels = {role: joints[0] if is_mecanum else list(joints) for role, joints in roles.items()}
    entry: dict[str, Any] = {known.kind: wheels}
    drive = Drive(known.kind, roles, base if base in robot.link else "")
    if drive.frame and drive.frame != robot.root:
        entry["frame"] = drive.frame
    driving = _driving(robot, drive)
    if driving is None and radius is not None:  # the shapes of the wheels have no radius
        driving, entry["radius"] = _driving(robot, replace(drive, radius=radius)), radius
    if driving is None:
        return "the joints and shapes of its wheels have no size"
    sizes = [("separation", _number(plugin, known.separation), abs(driving.track))]
    sizes += [] if "radius" in entry else [("radius", radius, driving.wheels[0].radius)]
    for what, written, actual in sizes:
        if written is not None and abs(written - actual) > _FAR * actual:
            return f"the {what} of its wheels is {written:.4g} m there, and {actual:.4g} m by the joints and shapes"
    found.sections["drive"] = entry
    found.names["drive"] = [name]
    return ""


def _driving(robot: Robot, drive: Drive) -> Driving | None:
    """Return where a drive has its wheels, or None if the joints and shapes of the wheels have no size."""
    try:
        return replace(robot, drive=drive).driving
    except (ValueError, KeyError, ArithmeticError):
        return None


def _add_edge(plugin: Element, known: Plugin, name: str, robot: Robot, found: Drives) -> str:
    """Add the published transform to the sections; return the reason if it is kept, else ""."""
    word, default = known.publishes
    texts = _texts(plugin, word)
    is_ros_1 = plugin.find("leftJoint") is not None or plugin.find("commandTopic") is not None  # which publishes
    publishes = (known.bridged or texts[0].lower() in ("true", "1")) if texts else default or is_ros_1
    if not publishes:
        return "its transform stays in Gazebo: it has no <tf_topic>" if known.bridged else ""
    parent, child = (_text(plugin, *frame).lstrip("/") for frame in (known.odom, known.base))
    if not parent or not child:
        return "it does not name both frames"
    if child not in robot.link:
        return f'"{child}" is not a link of the URDF'
    node = _BRIDGE if known.bridged else re.sub(r"[^\w.-]+", "_", name)
    package = _BRIDGE if known.bridged else "gazebo_plugins"
    about = f"plug-in {plugin.get('filename', '')} of Gazebo"
    found.sections.setdefault("publishers", {})[node] = {"package": package, "about": about}
    edge = {"parent": parent, "child": child, "publisher": node}
    edges = found.sections.setdefault("edges", [])
    if edge not in edges:
        edges.append(edge)
        found.names.setdefault("transform", []).append(f"{parent} -> {child}")
    return ""

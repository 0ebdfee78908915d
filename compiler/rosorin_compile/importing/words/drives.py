"""Drives: what known plug-ins of Gazebo say of the wheels, and of the transforms that they publish.

The plug-in itself stays as it is, for no output writes one. What it says of the robot becomes ``drive``; what it
publishes becomes an edge with its publisher.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Drive, Robot

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_BRIDGE = "ros_gz_bridge"
_CLOSE = 0.01  # a distance of a plug-in that is as near to that of the joints is the same, rounded
_FAR = 0.1  # one that is so far off is about other wheels
_TRUE = ("true", "1")


class Driven(NamedTuple):
    """What plug-ins say: sections of a description, what became of which, what stayed and why, and remarks."""

    sections: Mapping[str, Any] = {}
    said: Mapping[str, list[str]] = {}
    kept: Mapping[str, str] = {}
    remarks: Sequence[str] = ()


class Plugin(NamedTuple):
    """A plug-in that is known: the words for its wheels by role, its numbers, and for its transform.

    ``odom`` and ``base`` name the frames, each with what is taken when nothing is said (empty: it is not known);
    ``publishes`` says whether it does, with the default.
    """

    kind: str = ""
    roles: Mapping[str, tuple[str, ...]] = {}
    separation: tuple[str, ...] = ()
    radius: tuple[str, ...] = ()
    diameter: tuple[str, ...] = ()
    odom: tuple[str, str] = ("", "")
    base: tuple[str, str] = ("", "")
    publishes: tuple[str, bool] = ("", False)
    bridged: bool = False
    package: str = "gazebo_plugins"


_MODERN = Plugin(odom=("frame_id", ""), base=("child_frame_id", ""), publishes=("tf_topic", False), bridged=True)
_SIDES = {"left": ("left_joint",), "right": ("right_joint",)}
_CORNERS = {
    "front_left": ("front_left_joint",),
    "front_right": ("front_right_joint",),
    "rear_left": ("back_left_joint",),
    "rear_right": ("back_right_joint",),
}
# gz-sim@gz-sim8:src/systems/{diff_drive,mecanum_drive,ackermann_steering,odometry_publisher}, and
# gazebo_ros_pkgs@{melodic-devel,ros2}:gazebo_plugins/src.
_KNOWN: Mapping[str, Plugin] = {
    "diff-drive-system": _MODERN._replace(
        kind=Drive.DIFFERENTIAL, roles=_SIDES, separation=("wheel_separation",), radius=("wheel_radius",)
    ),
    "mecanum-drive-system": _MODERN._replace(
        kind=Drive.MECANUM, roles=_CORNERS, separation=("wheel_separation",), radius=("wheel_radius",)
    ),
    "ackermann-steering-system": _MODERN._replace(
        kind=Drive.ACKERMANN,
        roles={"driven": ("left_joint", "right_joint"), "steering": ("left_steering_joint", "right_steering_joint")},
        separation=("wheel_separation",),
        radius=("wheel_radius",),
    ),
    "odometry-publisher-system": _MODERN._replace(odom=("odom_frame", ""), base=("robot_base_frame", "")),
    "libgazebo_ros_diff_drive.so": Plugin(
        kind=Drive.DIFFERENTIAL,
        roles={"left": ("left_joint", "leftJoint"), "right": ("right_joint", "rightJoint")},
        separation=("wheel_separation", "wheelSeparation"),
        diameter=("wheel_diameter", "wheelDiameter"),
        odom=("odometry_frame odometryFrame", "odom"),
        base=("robot_base_frame robotBaseFrame", "base_footprint"),
        publishes=("publish_odom_tf publishOdomTF publishTf", False),
    ),
    "libgazebo_ros_planar_move.so": Plugin(
        odom=("odometry_frame odometryFrame", "odom"),
        base=("robot_base_frame robotBaseFrame", "base_footprint"),
        publishes=("publish_odom_tf publishOdomTF", True),
    ),
}


def driven(elements: Iterable[tuple[int, Element]], robot: Robot) -> Driven:
    """Return what the plug-ins among elements say of a robot."""
    made = _Drives(robot)
    for _, element in elements:
        if element.tag == "gazebo":
            for plugin in element:
                known = _known(plugin) if plugin.tag == "plugin" else None
                if known is not None:
                    made.take(plugin, known)
    return Driven(made.sections, made.said, made.kept, made.remarks)


def _known(plugin: Element) -> Plugin | None:
    file = plugin.get("filename", "")
    return next(
        (known for name, known in _KNOWN.items() if file.removesuffix(".so").endswith(name.removesuffix(".so"))), None
    )


def _texts(plugin: Element, *names: str) -> list[str]:
    """Return the texts of the first of some elements that is there."""
    for name in (word for words in names for word in words.split()):
        found = [(child.text or "").strip() for child in plugin if child.tag == name]
        if found:
            return found
    return []


def _number(plugin: Element, names: Sequence[str]) -> float | None:
    try:
        return float(next(iter(_texts(plugin, *names)), ""))
    except ValueError:
        return None


class _Drives:
    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.sections: dict[str, Any] = {}
        self.said: dict[str, list[str]] = {}
        self.kept: dict[str, str] = {}
        self.remarks: list[str] = []

    def take(self, plugin: Element, known: Plugin) -> None:
        """Take what a plug-in says of the drive and of its transform."""
        name = plugin.get("name", "").strip() or "plug-in"
        if known.kind:
            why = self._drive(plugin, known, name)
            if why:
                self.kept[f'the drive of "{name}"'] = why
        why = self._edge(plugin, known, name)
        if why:
            self.kept[f'the transform of "{name}"'] = why

    def _drive(self, plugin: Element, known: Plugin, name: str) -> str:
        """Take the drive; return why not, empty if it is taken."""
        if "drive" in self.sections:
            return "the robot has another one: a robot has one drive"
        roles = {
            role: tuple(text for tag in tags for text in _texts(plugin, tag))
            for role, tags in self._roles(known).items()
        }
        missing = [joint for joints in roles.values() for joint in joints if joint not in self.robot.joint]
        if missing:
            return f'"{missing[0]}" is no joint of the URDF'
        several = any(len(joints) != 1 for joints in roles.values())
        if not all(roles.values()) or (known.kind == Drive.MECANUM and several):
            return "it does not name its wheels"
        entry: dict[str, Any] = {
            role: joints[0] if known.kind == Drive.MECANUM else list(joints) for role, joints in roles.items()
        }
        base = self._base(plugin, known)
        drive = Drive(known.kind, roles, base if base in self.robot.link else "")
        radius = _number(plugin, known.radius)
        diameter = _number(plugin, known.diameter)
        radius = diameter / 2 if diameter is not None else radius
        why = self._sizes(plugin, known, name, drive, radius)
        if why:
            return why
        made: dict[str, Any] = {known.kind: entry}
        if drive.frame and drive.frame != self.robot.root:
            made["frame"] = drive.frame
        if self.radius is not None:
            made["radius"] = self.radius
        self.sections["drive"] = made
        self.said.setdefault("drive", []).append(name)
        return ""

    def _sizes(self, plugin: Element, known: Plugin, name: str, drive: Drive, radius: float | None) -> str:
        """Hold the numbers of a plug-in against those of the robot; return why they are about another drive."""
        self.radius: float | None = None
        try:
            driving = replace(self.robot, drive=drive).driving
        except (ValueError, KeyError, ArithmeticError):
            if radius is None:
                return "nothing says how large its wheels are"
            self.radius = radius
            try:
                driving = replace(self.robot, drive=replace(drive, radius=radius)).driving
            except (ValueError, KeyError, ArithmeticError) as problem:
                return str(problem) or "the joints do not place its wheels"
        pairs = [("separation of its wheels", _number(plugin, known.separation), driving.track)]
        if self.radius is None:
            pairs.append(("radius of its wheels", radius, driving.wheels[0].radius))
        for what, said, found in pairs:
            if said is None or not found or said == found:
                continue
            off = abs(said - found) / found
            if off > _FAR:
                return f"the {what} is {said:.4g} m there, and {found:.4g} m by the joints and shapes"
            if off > _CLOSE:
                self.remarks.append(f'plug-in "{name}": the {what} is {said:.4g} m there, {found:.4g} m in the robot')
        return ""

    @staticmethod
    def _roles(known: Plugin) -> Mapping[str, tuple[str, ...]]:
        """Return the words for the joints of each role, those that are spellings of one another as one."""
        one = known.kind == Drive.DIFFERENTIAL
        return {role: (" ".join(tags),) if one else tags for role, tags in known.roles.items()}

    def _base(self, plugin: Element, known: Plugin) -> str:
        return next(iter(_texts(plugin, known.base[0])), known.base[1]).lstrip("/")

    def _edge(self, plugin: Element, known: Plugin, name: str) -> str:
        """Take the transform that a plug-in publishes; return why not, empty if it is taken or publishes none."""
        word, default = known.publishes
        said = next(iter(_texts(plugin, word)), None)
        old = (
            plugin.find("leftJoint") is not None or plugin.find("commandTopic") is not None
        )  # of ROS 1, which publishes
        does = (said is not None if known.bridged else said.lower() in _TRUE) if said is not None else default or old
        if not does:
            return "its transform stays in Gazebo: it has no <tf_topic>" if known.bridged else ""
        parent, child = next(iter(_texts(plugin, known.odom[0])), known.odom[1]).lstrip("/"), self._base(plugin, known)
        if not parent or not child:
            return "it does not name both frames"
        if child not in self.robot.link:
            return f'"{child}" is no link of the URDF'
        node = _BRIDGE if known.bridged else re.sub(r"[^\w.-]+", "_", name)
        entry: dict[str, Any] = {"package": _BRIDGE if known.bridged else known.package}
        entry["about"] = f"plug-in {plugin.get('filename', '')} of Gazebo"
        self.sections.setdefault("publishers", {})[node] = entry
        edge = {"parent": parent, "child": child, "publisher": node}
        if edge in self.sections.setdefault("edges", []):
            return ""
        self.sections["edges"].append(edge)
        self.said.setdefault("transform", []).append(f"{parent} -> {child}")
        return ""

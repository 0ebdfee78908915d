"""Read the drive from known plug-ins of Gazebo: its wheels become ``drive``. The plug-in itself is kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Drive, Robot
from rosorin_compile.model.drive import Driving

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_FAR = 0.1  # relative difference from which on a size is another one
_CORNERS = [(end, side) for end in ("front", "back") for side in ("left", "right")]
# The elements that name the wheels, by kind and role; alternative names are separated by spaces.
_ROLES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    Drive.DIFFERENTIAL: {"left": ("left_joint leftJoint",), "right": ("right_joint rightJoint",)},
    Drive.MECANUM: {f"{'rear' if end == 'back' else end}_{side}": (f"{end}_{side}_joint",) for end, side in _CORNERS},
    Drive.ACKERMANN: {
        "driven": ("left_joint", "right_joint"),
        "steering": ("left_steering_joint", "right_steering_joint"),
    },
}
# gz-sim@gz-sim8:src/systems, and gazebo_ros_pkgs@{melodic-devel,ros2}:gazebo_plugins/src.
_KINDS = {
    "diff-drive-system": Drive.DIFFERENTIAL,
    "mecanum-drive-system": Drive.MECANUM,
    "ackermann-steering-system": Drive.ACKERMANN,
    "libgazebo_ros_diff_drive": Drive.DIFFERENTIAL,
}


class PluginDrive(NamedTuple):
    """The section ``drive`` of a plug-in, or the reason why it has none."""

    plugin: str = ""
    entry: Mapping[str, Any] = {}
    reason: str = ""


def read_drive(elements: Iterable[Element], robot: Robot) -> PluginDrive:
    """Return the drive of the first known plug-in among elements."""
    for plugin in (child for element in elements if element.tag == "gazebo" for child in element):
        file = plugin.get("filename", "").removesuffix(".so")
        kind = next((kind for ending, kind in _KINDS.items() if file.endswith(ending)), None)
        if plugin.tag == "plugin" and kind is not None:
            try:
                return PluginDrive(plugin.get("name", "").strip(), _drive(plugin, kind, robot))
            except ValueError as problem:
                return PluginDrive(plugin.get("name", "").strip(), reason=str(problem))
    return PluginDrive()


def _drive(plugin: Element, kind: str, robot: Robot) -> dict[str, Any]:
    """Return the section ``drive``. Raises ValueError with the reason if the plug-in does not fit the robot."""

    def texts(names: str) -> list[str]:
        """Return the texts of the first of several elements that exists."""
        found = ([(child.text or "").strip() for child in plugin if child.tag == name] for name in names.split())
        return next(filter(None, found), [])

    def number(names: str) -> float | None:
        try:
            return float(next(iter(texts(names)), ""))
        except ValueError:
            return None

    def driving(drive: Drive) -> Driving | None:
        try:
            return replace(robot, drive=drive).driving
        except (ValueError, KeyError, ArithmeticError):
            return None

    roles = {role: tuple(text for tag in tags for text in texts(tag)) for role, tags in _ROLES[kind].items()}
    missing = next((joint for joints in roles.values() for joint in joints if joint not in robot.joint), None)
    if missing is not None:
        raise ValueError(f'"{missing}" is no joint of the URDF')
    is_mecanum = kind == Drive.MECANUM
    if not all(roles.values()) or (is_mecanum and any(len(joints) != 1 for joints in roles.values())):
        raise ValueError("it does not name its wheels")
    base = next(iter(texts("child_frame_id robot_base_frame robotBaseFrame")), "").lstrip("/")
    diameter = number("wheel_diameter wheelDiameter")
    radius = number("wheel_radius") if diameter is None else diameter / 2
    entry: dict[str, Any] = {kind: {role: joints[0] if is_mecanum else list(joints) for role, joints in roles.items()}}
    drive = Drive(kind, roles, base if base in robot.link else "")
    if drive.frame and drive.frame != robot.root:
        entry["frame"] = drive.frame
    placed = driving(drive)
    if placed is None and radius is not None:  # the shapes of the wheels have no radius
        placed, entry["radius"] = driving(replace(drive, radius=radius)), radius
    if placed is None:
        raise ValueError("the joints and shapes of its wheels have no size")
    sizes = [("separation", number("wheel_separation wheelSeparation"), abs(placed.track))]
    sizes += [] if "radius" in entry else [("radius", radius, placed.wheels[0].radius)]
    for what, written, actual in sizes:
        if written is not None and abs(written - actual) > _FAR * actual:
            message = f"the {what} of its wheels is {written:.4g} m there, and {actual:.4g} m by the joints and shapes"
            raise ValueError(message)
    return entry

"""The tables of ros2_control: plugins and parameters of the controllers of a distribution, as data that ships with us.

``schemas/ros2_controllers.json`` says which commits it was made from. It is read when a controller is looked at.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from ...project import data_folder
from ..distributions import HUMBLE, JAZZY

_BROADCASTER = "{0}_broadcaster/{1}Broadcaster"
# Short words for types; each means the same in every distribution that has it.
SHORT: Mapping[str, str] = {
    "diff_drive": "diff_drive_controller/DiffDriveController",
    "mecanum_drive": "mecanum_drive_controller/MecanumDriveController",
    "omni_wheel_drive": "omni_wheel_drive_controller/OmniWheelDriveController",
    "tricycle": "tricycle_controller/TricycleController",
    "tricycle_steering": "tricycle_steering_controller/TricycleSteeringController",
    "bicycle_steering": "bicycle_steering_controller/BicycleSteeringController",
    "ackermann_steering": "ackermann_steering_controller/AckermannSteeringController",
    "joint_trajectory": "joint_trajectory_controller/JointTrajectoryController",
    "forward_command": "forward_command_controller/ForwardCommandController",
    "position_group": "position_controllers/JointGroupPositionController",
    "velocity_group": "velocity_controllers/JointGroupVelocityController",
    "effort_group": "effort_controllers/JointGroupEffortController",
    "position_gripper": "position_controllers/GripperActionController",
    "effort_gripper": "effort_controllers/GripperActionController",
    "parallel_gripper": "parallel_gripper_action_controller/GripperActionController",
    "pid": "pid_controller/PidController",
    "admittance": "admittance_controller/AdmittanceController",
    "gpio": "gpio_controllers/GpioCommandController",
    "joint_state_broadcaster": _BROADCASTER.format("joint_state", "JointState"),
    "imu_sensor_broadcaster": _BROADCASTER.format("imu_sensor", "IMUSensor"),
    "range_sensor_broadcaster": _BROADCASTER.format("range_sensor", "RangeSensor"),
    "force_torque_sensor_broadcaster": _BROADCASTER.format("force_torque_sensor", "ForceTorqueSensor"),
    "gps_sensor_broadcaster": _BROADCASTER.format("gps_sensor", "GPSSensor"),
    "pose_broadcaster": _BROADCASTER.format("pose", "Pose"),
}

MANAGER = "controller_manager"
# Parameters that every node has, or that the spawner reads out of the section of a controller.
_OF_ALL_NODES = ("use_sim_time", "start_type_description_service")
_ANY_PREFIX = "qos_overrides."


class Key(NamedTuple):
    """A parameter: its type in the words of the table, its default (None: it has none), validators, what sets it."""

    type: str
    default: Any
    has_default: bool
    valid: Mapping[str, list[Any]]
    forced: str = ""


class Table:
    """The parameters of a controller, or of the manager, in one distribution."""

    def __init__(self, keys: Mapping[str, Mapping[str, Any]], plain: frozenset[str]) -> None:
        self._keys = {name: _key(entry) for name, entry in keys.items() if "__map_" not in name}
        self._maps = {name: _key(entry) for name, entry in keys.items() if "__map_" in name}
        self.plain = plain

    def __contains__(self, key: str) -> bool:
        return self.find(key) is not None

    def find(self, key: str) -> Key | None:
        """Return a parameter by its full key; None if there is none."""
        if key in self._keys:
            return self._keys[key]
        return next((found for name, found in self._maps.items() if _pattern(name).fullmatch(key)), None)

    def mapped(self, key: str) -> tuple[str, str]:
        """Return the list whose values are keys, and the one that a key has: ("joints", "joint1") of gains.joint1.p."""
        for name in self._maps if key not in self._keys else ():
            found = _pattern(name).fullmatch(key)
            if found is not None:
                return name.partition("__map_")[2].partition(".")[0], found[1]
        return "", ""

    def names(self) -> Iterator[str]:
        """Yield the keys that do not depend on other values."""
        yield from self._keys

    def shown(self) -> list[str]:
        """Return all keys as a person writes them, those of lists with the name of the list."""
        return [*self._keys, *(re.sub(r"__map_(\w+)", r"<\1>", name) for name in self._maps)]

    def needed(self) -> Iterator[tuple[str, Key]]:
        """Yield the parameters without which a controller does not start: no default, or one that is refused."""
        from .values import refused

        for name, key in self._keys.items():
            if name in self.plain or key.type == "none" or key.forced:
                continue
            if not key.has_default or refused(key, key.default):
                yield name, key


def _key(entry: Mapping[str, Any]) -> Key:
    default = entry.get("default")
    if entry["type"] == "double" and isinstance(default, str):
        default = float(default)
    return Key(entry["type"], default, "default" in entry, entry.get("valid", {}), entry.get("forced", ""))


@cache
def _pattern(name: str) -> re.Pattern[str]:
    """Return the pattern of keys such as gains.__map_joints.p."""
    return re.compile(re.sub(r"__map_\w+", r"([^.]+)", name.replace(".", r"\.")))


@cache
def _data() -> Mapping[str, Any]:
    path = data_folder("schemas") / "ros2_controllers.json"
    loaded: Mapping[str, Any] = json.loads(path.read_text("utf-8"))
    return loaded


def plugins(distribution: str) -> Mapping[str, str]:
    """Return every type of the controllers of a distribution, humble or jazzy, with its package."""
    found: Mapping[str, str] = _data()[distribution]["plugins"]
    return found


@cache
def table(distribution: str, kind: str) -> Table | None:
    """Return the parameters of a type of controllers in a distribution, humble or jazzy; None if nobody knows them."""
    data = _data()[distribution]
    if kind not in data["plugins"] or kind not in data:
        return None
    common = data["every_controller"]
    from_manager = {name.partition(".")[2]: e for name, e in data[MANAGER].items() if name.startswith("<name>.")}
    plain = frozenset((*common, *from_manager))
    return Table({**from_manager, **common, **data[kind]}, plain)


@cache
def manager(distribution: str) -> Table:
    """Return the parameters of the controller_manager in a distribution, humble or jazzy, without those of names."""
    keys = {name: entry for name, entry in _data()[distribution][MANAGER].items() if not name.startswith("<name>.")}
    return Table(keys, frozenset(keys))


@cache
def of_names(distribution: str) -> Table:
    """Return the parameters that the controller_manager has of each controller, ``type`` among them."""
    data = _data()[distribution][MANAGER]
    keys = {name.partition(".")[2]: entry for name, entry in data.items() if name.startswith("<name>.")}
    return Table(keys, frozenset(keys))


def is_of_all_nodes(key: str) -> bool:
    """Say whether every node has a parameter."""
    return key in _OF_ALL_NODES or key.startswith(_ANY_PREFIX)


def other(distribution: str) -> str:
    """Return the other one of humble and jazzy."""
    return JAZZY if distribution == HUMBLE else HUMBLE


def full(kind: str) -> str:
    """Return the type of a controller that a short word stands for, or the word itself."""
    return SHORT.get(kind, kind)

"""Derive parameters of ros2_control controllers from the robot, and write controllers.yaml."""

import math
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import Any, NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Controller, Edge, Output, Robot
from rosorin_compile.model.drive import DIFFERENTIAL, MECANUM, OMNI, DriveKinematics, Steering, Wheel, drive_kinematics
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

from .. import node_kinds
from ..node_kinds import MANAGER, Kind, convert, is_of, kinds
from ..parameter_files import Node, Parameters, distro_of, parameters_of, text
from ..ports import Role, facts, full_topic, full_type, interfaces_of, port_of
from ..ports import described_by as known_distribution
from ..sections.control import EFFORT, JOINT_WORDS, POSITION, VELOCITY
from ..sections.controllers import flat

UPDATE_RATE = 100  # Hz
TF = "/tf"
COMMAND = "/cmd_vel"  # the velocity topic of Nav2 and most teleoperation nodes
# Steering controllers of Jazzy have traction_joints_names; keys of Humble such as rear_wheels_names are deprecated.
_LATER, _EARLIER = "traction_joints_names", ("front_wheel", "rear_wheel", "wheel_track")
_EVEN = 1e-6  # tolerance (m, rad) for equal wheel radii and evenly spaced wheels
# cmd_vel_timeout (s) of mecanum drives. The default is one control cycle, too short for Nav2, which publishes at 20 Hz.
_TIMEOUT = 0.5


class RobotParameters(NamedTuple):
    """Controller parameters derived from the robot; ``why_not`` is the reason why some are missing, or ""."""

    values: Mapping[str, Any]
    why_not: str = ""


def derive(robot: Robot, controller: Controller, plugin: str) -> RobotParameters:
    """Derive controller parameters from the robot for all ROS distributions; ``plugin`` is the full controller type."""
    about = interfaces_of(plugin)
    if "drive" in about:
        return _of_drive(robot, controller, about["drive"], about["turning"])
    if "sensor" not in about:
        values = _of_joints(robot, controller, about)
        return RobotParameters({key: value for key, value in values.items() if value is not None})
    name, kind = controller.sensor, about["sensor"]
    found = [one for one in robot.sensors if (one.name == name if name else one.type == kind)]
    if len(found) == 1:
        return RobotParameters({"sensor_name": found[0].name, "frame_id": found[0].frame})
    why = f'there is no sensor "{name}"' if name else f"the description has {len(found) or 'no'} sensors of type {kind}"
    return RobotParameters({}, f'{why}: write "sensor: NAME"' if found or name else f"{why}: add one")


def _of_drive(robot: Robot, controller: Controller, kind: str, read: str) -> RobotParameters:
    """Derive the parameters of a drive controller, which by default reads the state ``read`` of its wheels."""
    if robot.drive is None or robot.drive.kind != kind:
        why = f'the drive is {robot.drive.kind}, not {kind}: change "type" of the controller' if robot.drive else ""
        return RobotParameters({}, why or 'the description has no drive: add "drive"')
    try:
        driving = drive_kinematics(robot)
    except ValueError as problem:
        return RobotParameters({}, f'{problem}: correct "drive"')
    base = _base(robot, driving.frame)
    edges, navigates = [edge for edge in robot.edges if edge.child == base], _navigates(robot)
    # Disable the frame prefix: by default, the controller prepends its namespace to frame names.
    values: dict[str, Any] = {"base_frame_id": base, "tf_frame_prefix_enable": False}
    # Nav2 of Humble sends Twist, not TwistStamped. Controllers of later distributions do not have this parameter.
    values |= {"use_stamped_vel": False} if navigates else {}
    values["enable_odom_tf"] = any(edge in edges for edge in edges_of(robot, controller))
    values |= {"odom_frame_id": edges[0].parent} if edges else {}
    known = _quantities(robot, driving, robot.drive.joints)
    keys = facts("ros2_controllers")["derived"]["steered" if driving.steering else kind]
    values |= {key: known[what] for key, what in keys.items() if what in known}
    wheels = {wheel.joint for wheel in driving.wheels}
    states = [one.states for block in robot.control for one in block.joints if one.name in wheels]
    other = VELOCITY if read == POSITION else POSITION
    if not all(read in words for words in states) and all(other in words for words in states):
        values["position_feedback"] = other == POSITION
    rounded = {key: float(f"{value:.9g}") for key, value in values.items() if isinstance(value, float)}
    return RobotParameters(values | rounded)


def edges_of(robot: Robot, controller: Controller) -> list[Edge]:
    """Return the transforms in the section ``edges`` that a drive controller publishes.

    If no publisher has the name of the only drive controller, publishers with its ROS package match instead.
    """
    driving = [one for one in robot.controllers if "drive" in interfaces_of(full_type(one.type))]
    kind = node_kinds.controller(full_type(controller.type), "") if driving == [controller] else None
    return [edge for edge in robot.edges if is_of(controller.name, kind, edge.publisher, robot.publishers)]


def _navigates(robot: Robot) -> bool:
    return any(output.backend == "nav2" for output in robot.outputs)


def _base(robot: Robot, frame: str) -> str:
    """Return the frame that odometry moves if it is exactly above or below ``frame``, else ``frame``."""
    base = frame
    while not any(edge.child == base for edge in robot.edges):
        joint = robot.joint_to.get(base)
        is_level = joint is not None and max(map(abs, (*joint.origin.xyz[:2], *joint.origin.rpy))) <= _EVEN
        if joint is None or not joint.is_fixed or not is_level:
            return frame
        base = joint.parent
    return base


def _quantities(robot: Robot, driving: DriveKinematics, joints: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return joint names and sizes (m, rad) of the drive, with the keys that ``ros2_controllers.json`` refers to."""
    radii = [wheel.radius for wheel in driving.wheels]
    radius = radii[0] if _spread(radii) < _EVEN else sum(radii) / len(radii)
    found: dict[str, Any] = {"radius": radius, "wheelbase": driving.wheelbase, "track": driving.track}
    if driving.kind == MECANUM:
        around = (driving.wheelbase + driving.track) / 2
        found |= {role: names[0] for role, names in joints.items()} | {"half_sum": around}
        found |= {"timeout": _TIMEOUT} if _navigates(robot) else {}
        # The offset is the position of the base relative to the centre of the wheels (mecanum_drive_controller.cpp).
        found |= {f"offset_{axis}": -at for axis, at in zip("xy", driving.centre, strict=True) if abs(at) > 1e-9}
        return found | _speeds(robot, driving, around)
    if driving.kind == DIFFERENTIAL:
        found |= {"left": list(joints["left"]), "right": list(joints["right"]), "per_side": len(joints["left"])}
        return found | _speeds(robot, driving, driving.track / 2)
    if driving.kind == OMNI:  # the controller expects evenly spaced wheels in counter-clockwise order
        wheels = sorted(driving.wheels, key=lambda one: math.atan2(one.y, one.x) % math.tau)
        angles = [math.atan2(one.y, one.x) % math.tau for one in wheels]
        away = [math.hypot(one.x, one.y) for one in wheels]
        turns = [angle - angles[0] - math.tau / len(wheels) * index for index, angle in enumerate(angles)]
        if max(map(abs, turns)) < _EVEN and _spread(away) < _EVEN:
            found |= {"wheels": [one.joint for one in wheels], "first_angle": angles[0], "away": away[0]}
        return found
    found["front"] = driving.steering[0].x > 0
    places = ("front", "rear") if found["front"] else ("rear", "front")
    ends: tuple[Sequence[Steering | Wheel], ...] = (driving.steering, driving.wheels)
    for role, place, axes in zip(("steering", "wheel"), places, ends, strict=True):
        for word in (role, place):
            found[f"{word}_joints"] = [one.joint for one in axes]
            found[f"{word}_track"] = _spread([one.y for one in axes])
    if len(driving.wheels) == 1 and len(driving.steering) == 1:
        found |= {"wheel_joint": driving.wheels[0].joint, "steering_joint": driving.steering[0].joint}
    return found


def _spread(numbers: list[float]) -> float:
    return max(numbers) - min(numbers)


def _speeds(robot: Robot, driving: DriveKinematics, around: float) -> dict[str, Any]:
    """Derive the velocity limits of the base (m/s, rad/s); a rotation by 1 rad rolls each wheel by ``around`` (m)."""
    rims = [(robot.joint[one.joint].limits_of(VELOCITY)[1] or 0.0) * one.radius for one in driving.wheels]
    if not (least := min(rims, default=0.0)) or not around:
        return {}
    turn = least / around
    return {"speed": least, "back": -least, "turn": turn, "turn_back": -turn, "limited": True}


def _of_joints(robot: Robot, controller: Controller, about: Mapping[str, Any]) -> dict[str, Any]:
    command = about.get("command", "")
    block = next((one for one in robot.control if one.name == controller.hardware), None)
    moved = [one for one in block.joints if one.command and (not command or command in one.commands)] if block else []
    names = [one.name for one in moved]
    if command and about.get("joints") == "joint":  # a gripper controller, which has a single joint
        joint = robot.joint.get(str(controller.params.get("joint", names[0] if len(names) == 1 else "")))
        limits = {f"max_{key}": joint.limits_of(key)[1] for key in (EFFORT, VELOCITY)} if joint else {}
        return {"joint": joint.name if joint else None, **limits}
    values: dict[str, Any] = {"joints": names or None, "joint": names[0] if len(names) == 1 else None}
    if "states" in about and "action" in about:
        # Select one command interface, because only one is used at a time, and all common state interfaces.
        given = controller.params.get("joints")
        names = list(map(str, given)) if given and isinstance(given, (list, tuple)) else names
        found = [one for block in robot.control for one in block.joints if one.name in names]
        if names and len(found) >= len(names):
            commands = [word for word in (POSITION, VELOCITY, EFFORT) if all(word in one.commands for one in found)][:1]
            states = list(takewhile(lambda word: all(word in one.states for one in found), JOINT_WORDS[:3]))
            values |= {"command_interfaces": commands or None, "state_interfaces": states or None}
    return values


class ControllerParameters(NamedTuple):
    """A controller with all its parameters (``values``) and the parameters derived from the robot (``known``)."""

    controller: Controller
    type: str
    values: Mapping[str, Any]
    known: RobotParameters
    kind: Kind | None

    @property
    def remaps(self) -> list[tuple[str, str]]:
        """The remaps (from, to) that make the controller publish its odometry transform on /tf."""
        topic = self.kind.odometry if self.kind is not None and self.values.get("enable_odom_tf") else ""
        return [(topic, TF)] if topic.startswith("~") else []


def fill(robot: Robot, distribution: str) -> list[ControllerParameters]:
    """Return the controllers of a robot with all parameters for a ROS distribution."""
    made = []
    for one in robot.controllers:
        plugin = full_type(one.type)
        kind, known = node_kinds.controller(plugin, distribution), derive(robot, one, plugin)
        unused = _EARLIER if kind and _LATER in kind else ()
        keys = [key for key in known.values if kind and key in kind and not key.startswith(unused)]
        values = {**{key: known.values[key] for key in keys}, **one.params}
        values = {key: _typed(kind, key, value) for key, value in values.items()}
        made.append(ControllerParameters(one, plugin, values, known, kind))
    return made


def manager_parameters(output: Output, distribution: str) -> dict[str, Any]:
    """Return the parameters of the controller_manager node, except the types of controllers."""
    values = {"update_rate": output.options.get("update_rate", UPDATE_RATE)} | flat(output.options.get("manager") or {})
    return {key: _typed(kinds(distribution)[MANAGER], key, value) for key, value in values.items()}


def _typed(kind: Kind | None, key: str, value: Any) -> Any:
    if kind is not None and (entry := kind.key(key)) is not None:
        return convert(value, entry.type)
    return list(value) if isinstance(value, tuple) else value


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return (text of controllers.yaml for the ROS distribution of the output, diagnostics)."""
    name, notes, controllers = distro_of(output).capitalize(), [], fill(robot, distro_of(output))
    made = text(robot, output, templates, [f"Controllers of ros2_control, for {name}."], _nodes(output, controllers))
    if distro_of(output) not in node_kinds.DISTRIBUTIONS:
        last = node_kinds.DISTRIBUTIONS[-1].capitalize()
        notes.append(Diagnostic("controllers-later", NOTE, f"for {name}, the controllers of {last} are used"))
    for one in controllers:
        for topic, to in one.remaps:
            full = full_topic(topic, namespace_of(output), one.controller.name)
            frames = f"{one.values.get('odom_frame_id', 'odom')} -> {one.values.get('base_frame_id', 'base_link')}"
            message = f'controller "{one.controller.name}" publishes {frames} on {full}, not on {to}'
            notes.append(report("controllers-remap", message, help=f'remap this controller topic: "{full}:={to}"'))
    return made, notes


def view(robot: Robot, output: Output) -> Parameters:
    """Return the parameters in controllers.yaml, for comparison with an existing file."""
    return parameters_of(output, _nodes(output, fill(robot, distro_of(output))))


def namespace_of(output: Output) -> str:
    """Return the option ``namespace`` of an output, without leading and trailing slashes."""
    return str(output.options.get("namespace", "")).strip("/")


def _nodes(output: Output, controllers: Sequence[ControllerParameters]) -> list[Node]:
    distribution, space = known_distribution(distro_of(output)), namespace_of(output)
    types = {f"{one.controller.name}.type": one.type for one in controllers}
    manager = {**manager_parameters(output, distribution), **types}
    nodes = [Node(f"{space}/{MANAGER}", kinds(distribution)[MANAGER], manager)]
    return nodes + [Node(f"{space}/{one.controller.name}", one.kind, one.values) for one in controllers]


class Driver(NamedTuple):
    """A drive controller with its velocity command topic and its odometry topic.

    A leading "~" in a topic stands for the name of the controller. ``space`` is the namespace, or "". ``stamped`` is
    True for commands of type TwistStamped, False for Twist.
    """

    one: ControllerParameters
    space: str
    command: str
    odometry: str
    stamped: bool

    @property
    def name(self) -> str:
        return self.one.controller.name

    def topic(self, own: str) -> str:
        """Replace a leading "~" in a topic with the namespace and the name of the controller."""
        return f"{f'/{self.space}/' if self.space else ''}{self.name}{own.removeprefix('~')}"


def drivers(robot: Robot) -> list[Driver]:
    """Return the drive controllers, active controllers first, or [] if no output has the format ``controllers``."""
    output = next((one for one in robot.outputs if one.backend == "controllers"), None)  # ``backend`` is the format
    if output is None or not is_whole(robot):
        return []
    found = []
    for one in fill(robot, distro_of(output)):
        command, odometry = (port_of(one.type, distro_of(output), role) for role in (Role.VELOCITY, Role.ODOMETRY))
        if command is not None and odometry is not None:
            stamped = command.is_stamped(one.values)
            found.append(Driver(one, namespace_of(output), command.name(one.values), odometry.topic, stamped))
    return sorted(found, key=lambda driver: driver.one.controller.inactive)


def is_whole(robot: Robot) -> bool:
    """Return True if all joints and the frame of the drive exist, or if the robot has no drive."""
    if (drive := robot.drive) is None:
        return True
    names = [name for names in drive.joints.values() for name in names]
    return all(name in robot.joint for name in names) and (not drive.frame or drive.frame in robot.link)

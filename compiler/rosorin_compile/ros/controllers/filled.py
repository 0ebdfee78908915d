"""The controllers of a description with all their parameters, and the text of controllers.yaml.

What the description says goes before what the robot knows (``derived``): joints by their roles, radius and places of
the wheels (``model.drive``), frames, limits. Each number is written as its type wants it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import takewhile
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.formats.format import described_by as known_distribution
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Controller, Edge, Output, Robot
from rosorin_compile.model.drive import DIFFERENTIAL, MECANUM, OMNI, Driving, driving_of
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

from ..parameters import files, tables
from ..parameters.files import Node, distro_of
from ..parameters.tables import MANAGER, Kind, convert, is_of, kinds
from ..ports import ODOMETRY, VELOCITY, facts, full_type, interfaces_of, port_of
from ..sections.control.hardware import EFFORT, JOINT_WORDS, POSITION
from ..sections.control.hardware import VELOCITY as SPEED
from ..sections.controllers import flat

UPDATE_RATE = 100  # Hz
CONTROLLERS = "controllers"  # the backend
TF = "/tf"
COMMAND = "/cmd_vel"  # where Nav2 and most others send velocities
# Steering controllers of Jazzy call wheels by what they do, and keep the words of Humble for where they stand.
_LATER, _EARLIER = "traction_joints_names", ("front_wheel", "rear_wheel", "wheel_track")
_EVEN = 1e-6  # m and rad: wheels that the controller takes to be alike, or evenly around, are so to this
_ZERO = 1e-9
_NAV2 = "nav2"
# By default a mecanum controller stops one cycle after each velocity, and Nav2 sends 20 a second. Seconds: what
# diff_drive has by default (cmd_vel_timeout).
_TIMEOUT = 0.5


class Derived(NamedTuple):
    """Parameters by their keys, as many as the robot knows, and why it does not know others, in words."""

    values: Mapping[str, Any]
    why_not: str = ""


def derive(robot: Robot, controller: Controller, kind: str) -> Derived:
    """Return what a robot knows of the parameters of a controller; of all distributions."""
    about = interfaces_of(kind)
    if "drive" in about:
        return _of_drive(robot, controller, about["drive"])
    if "sensor" in about:
        return _of_sensor(robot, controller, about["sensor"])
    return Derived(_of_joints(robot, controller, about))


def _of_drive(robot: Robot, controller: Controller, kind: str) -> Derived:
    drive = robot.drive
    if drive is None:
        return Derived({}, "the description has no drive")
    if drive.kind != kind:
        return Derived({}, f"the drive is {drive.kind}, not {kind}")
    try:
        driving = driving_of(robot)
    except ValueError as problem:
        return Derived({}, str(problem))
    known = _quantities(robot, driving, drive.joints)
    keys = facts("ros2_controllers")["derived"]["steered" if driving.steering else drive.kind]
    values = _frames(robot, controller, driving) | {key: known[what] for key, what in keys.items() if what in known}
    if not _has_positions(robot, [one.joint for one in driving.wheels]):
        values["position_feedback"] = False
    return Derived({key: _short(value) for key, value in values.items()})


def _has_positions(robot: Robot, wheels: list[str]) -> bool:
    states = [one.states for block in robot.control for one in block.joints if one.name in wheels]
    return not states or any(POSITION in words for words in states) or not all(SPEED in words for words in states)


def _short(value: Any) -> Any:
    return float(f"{value:.9g}") if isinstance(value, float) else value


def edges_of(robot: Robot, controller: Controller) -> list[Edge]:
    """Return the edges of the description that a controller of a drive publishes.

    One that the description calls otherwise is known by its package, if it is the only one that drives.
    """
    driving = [one for one in robot.controllers if "drive" in interfaces_of(full_type(one.type))]
    kind = tables.controller(full_type(controller.type), "") if driving == [controller] else None
    return [edge for edge in robot.edges if is_of(controller.name, kind, edge.publisher, robot.publishers)]


def _frames(robot: Robot, controller: Controller, driving: Driving) -> dict[str, Any]:
    """Return the frames of the odometry, and whether the controller publishes the edge between them.

    A namespace would be written before the frames by default; they are called as the description calls them.
    """
    base = _base(robot, driving.frame)
    edges = [edge for edge in robot.edges if edge.child == base]
    values: dict[str, Any] = {"base_frame_id": base, "tf_frame_prefix_enable": False}
    if _navigates(robot):
        values["use_stamped_vel"] = False  # Nav2 of Humble has no header; a key of Humble alone
    values["enable_odom_tf"] = any(edge in edges for edge in edges_of(robot, controller))
    return {**values, "odom_frame_id": edges[0].parent} if edges else values


def _navigates(robot: Robot) -> bool:
    return any(output.backend == _NAV2 for output in robot.outputs)


def _base(robot: Robot, frame: str) -> str:
    base = frame
    while not any(edge.child == base for edge in robot.edges):
        joint = robot.joint_to.get(base)
        if joint is None or not joint.is_fixed:
            return frame
        if max(map(abs, (*joint.origin.xyz[:2], *joint.origin.rpy))) > _EVEN:
            return frame
        base = joint.parent
    return base


def _quantities(robot: Robot, driving: Driving, joints: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """Return what the drive says, by the names that ``derived`` of ``ros2_controllers.json`` has for it (m, rad)."""
    radii = [wheel.radius for wheel in driving.wheels]
    radius = radii[0] if _spread(radii) < _EVEN else sum(radii) / len(radii)
    found: dict[str, Any] = {"radius": radius, "wheelbase": driving.wheelbase, "track": driving.track}
    if driving.kind == MECANUM:
        around = (driving.wheelbase + driving.track) / 2
        found |= {role: names[0] for role, names in joints.items()}
        found |= {"half_sum": around, **({"timeout": _TIMEOUT} if _navigates(robot) else {})}
        # The base seen from the centre of the wheels: the controller has vx + y * wz (mecanum_drive_controller.cpp).
        found |= {f"offset_{axis}": -at for axis, at in zip("xy", driving.centre, strict=True) if abs(at) > _ZERO}
        return found | _speeds(robot, driving, around)
    if driving.kind == DIFFERENTIAL:
        found |= {"left": list(joints["left"]), "right": list(joints["right"]), "per_side": len(joints["left"])}
        return found | _speeds(robot, driving, driving.track / 2)
    return found | (_omni(driving) if driving.kind == OMNI else _steered(driving))


def _omni(driving: Driving) -> dict[str, Any]:
    """Return the wheels in their order around the robot, if they are even."""
    wheels = sorted(driving.wheels, key=lambda one: math.atan2(one.y, one.x) % math.tau)
    angles = [math.atan2(one.y, one.x) % math.tau for one in wheels]
    away = [math.hypot(one.x, one.y) for one in wheels]
    turns = [angle - angles[0] - math.tau / len(wheels) * index for index, angle in enumerate(angles)]
    if max(map(abs, turns)) >= _EVEN or _spread(away) >= _EVEN:
        return {}
    return {"wheels": [one.joint for one in wheels], "first_angle": angles[0], "away": away[0]}


def _steered(driving: Driving) -> dict[str, Any]:
    steering, wheels = [one.joint for one in driving.steering], [one.joint for one in driving.wheels]
    tracks = {
        "steering": _spread([one.y for one in driving.steering]),
        "wheel": _spread([one.y for one in driving.wheels]),
    }
    front = driving.steering[0].x > 0
    at_front, at_rear = ("steering", "wheel") if front else ("wheel", "steering")
    names = {"steering": steering, "wheel": wheels}
    found: dict[str, Any] = {f"{what}_joints": joints for what, joints in names.items()} | {"front": front}
    found |= {f"{what}_track": track for what, track in tracks.items()}
    found |= {"front_joints": names[at_front], "rear_joints": names[at_rear]}
    found |= {"front_track": tracks[at_front], "rear_track": tracks[at_rear]}
    if len(wheels) == 1 and len(steering) == 1:
        found |= {"wheel_joint": wheels[0], "steering_joint": steering[0]}
    return found


def _spread(numbers: list[float]) -> float:
    return max(numbers) - min(numbers)


def _speeds(robot: Robot, driving: Driving, around: float) -> dict[str, Any]:
    """Return the largest velocities of the base that no wheel turns too fast for; nothing where one has no limit.

    ``around`` (m) is what a turn of the base by 1 rad rolls of a wheel.
    """
    rims = []
    for wheel in driving.wheels:
        limit = robot.joint[wheel.joint].limit
        speed = limit.known_value("velocity") if limit is not None else None
        rims.append(0.0 if speed is None else speed * wheel.radius)
    least = min(rims, default=0.0)
    if not least or not around:
        return {}
    turn = least / around
    return {"speed": least, "back": -least, "turn": turn, "turn_back": -turn, "limited": True}


def _of_sensor(robot: Robot, controller: Controller, kind: str) -> Derived:
    named = [one for one in robot.sensors if one.name == controller.sensor]
    found = named or [one for one in robot.sensors if one.type == kind and not controller.sensor]
    if controller.sensor and not named:
        return Derived({}, f'there is no sensor "{controller.sensor}"')
    if len(found) != 1:
        why = f"the description has {len(found) or 'no'} sensors of type {kind}"
        return Derived({}, f"{why}: say which, sensor: NAME" if found else why)
    return Derived({"sensor_name": found[0].name, "frame_id": found[0].frame})


def _of_joints(robot: Robot, controller: Controller, about: Mapping[str, Any]) -> dict[str, Any]:
    wanted = about.get("command", "")
    block = next((one for one in robot.control if one.name == controller.hardware), None)
    moved = [one for one in block.joints if one.command and (not wanted or wanted in one.commands)] if block else []
    names = [one.name for one in moved]
    if wanted and about.get("joints") == "joint":
        return _of_gripper(robot, str(controller.params.get("joint", names[0] if len(names) == 1 else "")))
    values: dict[str, Any] = {"joints": names} if names else {}
    values |= {"joint": names[0]} if len(names) == 1 else {}
    if "states" in about and "action" in about:
        given = controller.params.get("joints")
        values |= _interfaces(robot, tuple(map(str, given if given and isinstance(given, (list, tuple)) else names)))
    return values


def _of_gripper(robot: Robot, name: str) -> dict[str, Any]:
    joint = robot.joint.get(name)
    if joint is None:
        return {}
    values: dict[str, Any] = {"joint": name}
    for key in (EFFORT, SPEED):
        most = joint.limit.known_value(key) if joint.limit is not None else None
        if most is not None:
            values[f"max_{key}"] = most
    return values


def _interfaces(robot: Robot, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the first command that all of some joints have in their blocks, and the states that all of them have.

    Several commands of a joint are ways to move it of which one is used at a time, as position and velocity of an arm.
    """
    found = [one for block in robot.control for one in block.joints if one.name in names]
    if not names or len(found) < len(names):
        return {}
    commands = [word for word in (POSITION, SPEED, EFFORT) if all(word in one.commands for one in found)][:1]
    states = list(takewhile(lambda word: all(word in one.states for one in found), JOINT_WORDS[:3]))
    values = {"command_interfaces": commands, "state_interfaces": states}
    return {key: words for key, words in values.items() if words}


class Filled(NamedTuple):
    """A controller with its type in full, all its parameters as they are written, and what the robot knows of them."""

    controller: Controller
    type: str
    values: Mapping[str, Any]
    known: Derived
    kind: Kind | None


def fill(robot: Robot, distribution: str) -> list[Filled]:
    """Return the controllers of a robot with all that is known of their parameters, for humble or jazzy."""
    made = []
    for one in robot.controllers:
        kind = full_type(one.type)
        found, knows = tables.controller(kind, distribution), derive(robot, one, kind)
        values = {key: value for key, value in knows.values.items() if found is not None and key in found}
        if found is not None and _LATER in found:
            values = {key: value for key, value in values.items() if not key.startswith(_EARLIER)}
        values |= one.params
        made.append(Filled(one, kind, {key: _typed(found, key, value) for key, value in values.items()}, knows, found))
    return made


def distribution_of(robot: Robot, controllers: str) -> str:
    """Return the distribution, humble or jazzy, that the output ``controllers`` is for; without it, that of another."""
    said = sorted(robot.outputs, key=lambda one: one.name != controllers)
    words = (one.options.get("distribution") or one.options.get("control") for one in said)
    return known_distribution(str(next(filter(None, words), JAZZY)))


def manager_parameters(output: Output, distribution: str) -> dict[str, Any]:
    """Return the parameters of the controller_manager itself."""
    values = {"update_rate": output.options.get("update_rate", UPDATE_RATE)} | flat(output.options.get("manager") or {})
    return {key: _typed(kinds(distribution)[MANAGER], key, value) for key, value in values.items()}


def _typed(found: Kind | None, key: str, value: Any) -> Any:
    entry = found.key(key) if found is not None else None
    if entry is not None:
        return convert(value, entry.type)
    return list(value) if isinstance(value, tuple) else value


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the controllers.yaml of a robot, for the distribution that the output asks for."""
    controllers = fill(robot, distro_of(output))
    head = [f"Controllers of ros2_control, for {distro_of(output).capitalize()}."]
    text = files.text(robot, output, templates, head, _nodes(output, controllers))
    said = []
    if distro_of(output) not in (HUMBLE, JAZZY):
        message = (
            f"what is known of controllers is that of Jazzy: {distro_of(output).capitalize()} is taken to be like it"
        )
        said.append(Diagnostic("controllers-later", NOTE, message))
    for one in filter(_needs_remap, controllers):
        name = f"{f'/{_namespace(output)}'.rstrip('/')}/{one.controller.name}/tf_odometry"
        frames = f"{one.values.get('odom_frame_id', 'odom')} -> {one.values.get('base_frame_id', 'base_link')}"
        message = f'the controller "{one.controller.name}" publishes {frames} on {name}, not on /tf'
        said.append(Diagnostic("controllers-remap", NOTE, message, help=f"start it with {name}:=/tf"))
    return text, said


def view(robot: Robot, output: Output) -> files.Parameters:
    """Return what the controllers.yaml of a robot is meant to contain."""
    return files.parameters_of(output, _nodes(output, fill(robot, distro_of(output))))


def _namespace(output: Output) -> str:
    return str(output.options.get("namespace", "")).strip("/")


def _nodes(output: Output, controllers: Sequence[Filled]) -> list[Node]:
    distribution, space = known_distribution(distro_of(output)), _namespace(output)
    types = {f"{one.controller.name}.type": one.type for one in controllers}
    nodes = [Node(MANAGER, kinds(distribution)[MANAGER], {**manager_parameters(output, distribution), **types})]
    nodes += [Node(one.controller.name, one.kind, one.values) for one in controllers]
    return [one._replace(name=f"{space}/{one.name}") for one in nodes]


def remaps(robot: Robot, output: Output) -> dict[str, list[tuple[str, str]]]:
    """Return the remaps, from and to, without which a controller of an output would not publish what it owns."""
    controllers = fill(robot, distro_of(output))
    return {one.controller.name: [("~/tf_odometry", "/tf")] for one in controllers if _needs_remap(one)}


def _needs_remap(one: Filled) -> bool:
    return one.kind is not None and one.kind.odometry.startswith("~") and bool(one.values.get("enable_odom_tf"))


class Driver(NamedTuple):
    """A controller of a drive as others reach it; topics begin with ~ for its name.

    ``space`` is its namespace, empty for none; ``stamped`` says that it takes TwistStamped, else Twist.
    """

    one: Filled
    space: str
    command: str
    odometry: str
    stamped: bool

    @property
    def name(self) -> str:
        """The name of the controller."""
        return self.one.controller.name

    def topic(self, own: str) -> str:
        """Return one of its topics as nodes outside of its namespace reach it."""
        return f"{f'/{self.space}/' if self.space else ''}{self.name}{own.removeprefix('~')}"


def drivers(robot: Robot) -> list[Driver]:
    """Return the controllers of a drive, those that are started active first; none without an output for them."""
    output = next((one for one in robot.outputs if one.backend == CONTROLLERS), None)
    if output is None or not is_whole(robot):
        return []
    space, distribution, found = _namespace(output), distro_of(output), []
    for one in fill(robot, distribution):
        command, odometry = (port_of(one.type, distribution, role) for role in (VELOCITY, ODOMETRY))
        if command is not None and odometry is not None:
            stamped = command.is_stamped(one.values)
            found.append(Driver(one, space, command.name(one.values), odometry.topic, stamped))
    return sorted(found, key=lambda driver: driver.one.controller.inactive)


def is_whole(robot: Robot) -> bool:
    """Return True if the joints and the frame of the drive exist."""
    drive = robot.drive
    if drive is None:
        return True
    names = [name for names in drive.joints.values() for name in names]
    return all(name in robot.joint for name in names) and (not drive.frame or drive.frame in robot.link)

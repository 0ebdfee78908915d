"""Derive parameters of a robot_localization filter, which publishes odom -> base or map -> odom."""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.model.drive import drive_kinematics
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Suggestion, phrase, quote

from .controllers.write import drivers, is_whole
from .navigation import FILTER, Frames, Problem, PublishedTransform, diagnose, frames_of, kind_of, stated_topic
from .parameter_files import Node, Parameters, distro_of, parameter_file, parameters_of, text
from .ports import facts

# State variables of a filter, in the order of the 15 booleans of odom0_config (filter_common.hpp).
STATES = (*("x", "y", "z", "roll", "pitch", "yaw"), *("vx", "vy", "vz", "vroll", "vpitch", "vyaw", "ax", "ay", "az"))

_NAME = re.compile(r"(odom|pose|twist|imu)(0|[1-9]\d*)")


def _inputs_of(output: Output) -> Mapping[str, Mapping[str, Any]]:
    return output.options.get("inputs") or {}


def _content(robot: Robot, output: Output) -> tuple[Node | None, PublishedTransform | None, list[Problem]]:
    """Return (filter node, published transform, problems); the node is None on errors."""
    frames, wrong = frames_of(robot, output)
    if frames is None:
        return None, None, wrong
    filters = {one.name: one for one in robot.publishers if kind_of(one) == FILTER}
    named = output.options.get("node")
    name = str(named or next(iter(filters), "ekf_filter_node"))
    owned = frames.transforms_of(filters[name]) if name in filters else []
    possible = ((frames.odom, frames.moved), (frames.map, frames.odom))
    if named is None and len(filters) > 1:
        message = f"the robot has several filters, {quote(filters)}"
        wrong.append(Problem("filter-unclear", message, (), 'write an output for each, with "node: NAME"', key=True))
    elif named is not None and named not in filters and (filters or named in [one.name for one in robot.publishers]):
        suggestion = Suggestion(named, filters, none='write "package: robot_localization" in its entry of "publishers"')
        message = f'"{named}" is not a filter of robot_localization'
        wrong.append(Problem("filter-unclear", message, ("node",), suggestion))
    elif not owned:
        message = f'"{name}" is not the publisher of a transform in "edges", so "publish_tf" is false'
        wrong.append(Problem("filter-owns-nothing", message, severity=NOTE, key=True))
    elif others := [lead for lead in owned if (lead.parent, lead.child) not in possible] or owned[1:]:
        message = f'"{name}" has to publish {phrase(map(str, owned))}, but a filter publishes either '
        message += f"{frames.odom} -> {frames.moved} or {frames.map or 'map'} -> {frames.odom}"
        wrong.append(Problem("navigation-owner", message, others[0].path, absolute=True))
    wrong += _check_inputs(robot, output, frames)
    if any(one.severity == ERROR for one in wrong):
        return None, None, wrong
    lead, options = owned[0] if owned else None, {"two_d_mode": True} if robot.drive is not None else {}
    options |= {key: output.options[key] for key in ("frequency", "two_d_mode") if key in output.options}
    values: dict[str, Any] = {key: options[key] for key in ("frequency", "two_d_mode") if key in options}
    values["publish_tf"] = lead is not None
    values |= {"map_frame": frames.map} if frames.map else {}
    values |= {"odom_frame": frames.odom, "base_link_frame": frames.moved}
    values["world_frame"] = frames.odom if lead is None else lead.parent
    for key, one in _inputs_of(output).items():
        kind = key.rstrip("0123456789")
        uses = one.get("uses") or usual(robot, kind, frames.moved)
        values |= {key: topic(robot, key, one), f"{key}_config": [state in uses for state in STATES]}
        keys = facts("ros2_nodes")["filter_inputs"][kind]["keys"]
        values |= {f"{key}_{word}": one[word] for word in keys if word in one}
    return Node(name, "ekf", values), lead, wrong


def _check_inputs(robot: Robot, output: Output, frames: Frames) -> Iterator[Problem]:
    rule, inputs, driving = "filter-input", _inputs_of(output), [driver.name for driver in drivers(robot)]
    imus = {sensor.name for sensor in robot.sensors if sensor.type == "imu"}
    if not inputs:
        message = "the filter has no inputs: it estimates nothing"
        yield Problem(rule, message, (), 'add "inputs: {odom0: {topic: NAME}}"', WARNING, key=True)
    for name, one in inputs.items():
        path, match = ("inputs", name), _NAME.fullmatch(name)
        if match is None:
            help = "use names such as odom0, pose0, twist0, imu0, imu1"
            yield Problem(rule, f'"{name}" is not a valid name of a filter input', path, help, key=True)
            continue
        kind, uses, about = match[1], one.get("uses"), facts("ros2_nodes")["filter_inputs"][match[1]]
        if (gap := next((at for at in range(int(match[2])) if f"{kind}{at}" not in inputs), None)) is not None:
            message = f'"{name}" would never be read: there is no {kind}{gap}'
            yield Problem(rule, message, path, f"number the inputs from 0 without a gap: {kind}{gap}", key=True)
        if (sensor := one.get("sensor")) is not None and sensor not in imus:
            suggestion = Suggestion(sensor, imus, none="the robot has no IMU")
            yield Problem(rule, f'there is no IMU "{sensor}"', (*path, "sensor"), suggestion)
        if not topic(robot, name, one):
            help = 'add "topic: NAME" here; a topic of the sensor counts only if it differs from the name of the sensor'
            yield Problem(rule, f'"{name}" has no topic', path, help, key=True)
        controller = one.get("controller")
        if controller is not None and is_whole(robot) and (controller not in driving or kind != "odom"):
            message = f'"{controller}" is not a controller of the drive, so "{name}" cannot be its odometry'
            yield Problem(rule, message, (*path, "controller"), Suggestion(controller, driving))
        for index, state in enumerate(uses or ()):
            if state not in about["states"]:
                message = f'"{name}" cannot use {state}: its messages contain {phrase(about["states"])}'
                yield Problem(rule, message, (*path, "uses", index), f'remove "{state}"')
        if uses is not None and not uses:
            yield Problem(rule, f'"uses" of "{name}" is empty', (*path, "uses"), "list values, or remove the input")
        if uses is None and not usual(robot, kind, frames.moved):
            message = f'"{name}" needs "uses", the list of values to use'
            yield Problem(rule, message, path, f'write, for example, "uses: [{", ".join(about["example"])}]"', key=True)
        for key in sorted(one.keys() - {*about["keys"], "topic", "sensor", "controller", "uses"}):
            yield Problem(rule, f'"{key}" is not a key of "{name}"', (*path, key), "remove it", key=True)


def remaps(robot: Robot, output: Output) -> list[tuple[str, str]]:
    """Return remaps (from, to) that connect the inputs of a filter to the odometry topics of controllers."""
    topics = {driver.name: f"/{driver.topic(driver.odometry).lstrip('/')}" for driver in drivers(robot)}
    inputs = {topic(robot, name, one): one.get("controller", "") for name, one in _inputs_of(output).items()}
    moved = [(heard, topics[one]) for heard, one in inputs.items() if one in topics]
    return [(heard, to) for heard, to in moved if f"/{heard.lstrip('/')}" != to]


def usual(robot: Robot, kind: str, base: str) -> tuple[str, ...]:
    """Return the state variables that a filter input (odom, pose, twist or imu) uses by default.

    Wheels measure velocities. If the base cannot move sideways, its lateral velocity of 0 is a valid measurement, but
    only at the axle: any other frame ``base`` moves sideways when the robot turns. Without a drive, the result is ().
    """
    if robot.drive is None or kind == "pose":
        return ()
    if kind == "imu":
        return ("vyaw",)
    at_axle = False
    with suppress(ValueError, KeyError):  # rules about drives report the error
        driving = drive_kinematics(robot)
        at_axle = abs(robot.transform(base, driving.frame).apply((*driving.centre, 0.0))[0]) < 1e-3  # m
    return ("vx", "vy", "vyaw") if robot.drive.slides or at_axle else ("vx", "vyaw")


def topic(robot: Robot, name: str, one: Mapping[str, Any]) -> str:
    """Return the topic in the entry ``one`` of a filter input, else the topic of its IMU sensor, or "" if unknown."""
    if "topic" in one or not name.startswith("imu"):
        return str(one.get("topic", ""))
    known = [sensor.name for sensor in robot.sensors if sensor.type == "imu"]
    return stated_topic(robot, one.get("sensor") or (known[0] if len(known) == 1 else ""))


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return (text of the parameter file of a filter, diagnostics); the text is "" if the output has errors."""
    node, lead, _ = _content(robot, output)
    if node is None:
        return "", []  # rules report these errors
    head = f"robot_localization of {distro_of(output).capitalize()}: {node.name} publishes {lead or 'no transform'}."
    return text(robot, output, templates, [head, "No covariance is in it: load it after your own."], [node]), []


def view(robot: Robot, output: Output) -> Parameters:
    """Return the parameters of a filter, for comparison with an existing file."""
    node = _content(robot, output)[0]
    return parameters_of(output, [node] if node is not None else [])


FORMAT = parameter_file(
    "robot_localization",
    word="parameter file for robot_localization",
    about="frames, ownership and inputs of an EKF",
    rank=63,
    covers=("robot", "edges.parent", "edges.child", "edges.publisher", "publishers.node"),
    file="ekf.yaml",
    check=partial(diagnose, find=_content),
    write=write,
    view=view,
)

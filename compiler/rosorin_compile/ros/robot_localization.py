"""The parameters of a filter of robot_localization that a description knows.

The edges say whether it publishes, and what: with odom -> base its world is the odometry, with map -> odom the map.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.model.drive import driving_of
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Help, Suggestion, error, listed, quoted
from rosorin_compile.source.wording import suggest, swaps

from .controllers.filled import drivers, intended_topic
from .navigation import FILTER, Found, Frames, diagnose, frames_of, kind_of, stated_topic
from .parameters import parameter_file
from .parameters.files import Node, Parameters, asked, parameters_of, text

# What a filter estimates, in the order of its fifteen booleans (robot_localization: filter_common.hpp).
STATES = (*("x", "y", "z", "roll", "pitch", "yaw"), *("vx", "vy", "vz", "vroll", "vpitch", "vyaw", "ax", "ay", "az"))

_PACKAGE = "robot_localization"
_USUAL = "ekf_filter_node"
_NAME = re.compile(r"(odom|pose|twist|imu)(0|[1-9]\d*)")
_POSE, _TWIST, _ACCELERATION = STATES[:6], STATES[6:12], STATES[12:]
# What the messages have that an input takes (nav_msgs/Odometry, geometry_msgs, sensor_msgs/Imu).
_HAVE = {"odom": (*_POSE, *_TWIST), "pose": _POSE, "twist": _TWIST, "imu": (*_POSE[3:], *_TWIST[3:], *_ACCELERATION)}
_COPIED = ("differential", "relative", "queue_size", "remove_gravitational_acceleration")
_MISSING = {"twist": ("differential", "relative")}  # what some inputs have not
_NEAR = 1e-3  # m


@dataclass(frozen=True)
class Filter:
    """A filter: its name, and the two ends of what it publishes; both empty if it publishes nothing."""

    name: str
    parent: str = ""
    child: str = ""


def filter_of(robot: Robot, output: Output, frames: Frames) -> tuple[Filter | None, list[Found]]:
    """Return the filter that an output is for, and what is wrong with it."""
    filters = {one.name: one for one in robot.publishers if kind_of(one) == FILTER}
    packages = {one.name: one.package for one in robot.publishers}
    named = output.options.get("node")
    if named is None and len(filters) > 1:
        message = f"the robot has several filters, {quoted(filters)}"
        return None, [Found("filter-unclear", message, (), "an output for each: node: NAME", key=True)]
    if named is not None and named not in filters and (filters or named in packages):
        package = packages.get(named, "")
        if _PACKAGE in swaps(package):
            path, help = ("publishers", named, "package"), suggest(_PACKAGE)
            return None, [Found("filter-unclear", f'there is no package "{package}"', path, help, absolute=True)]
        message = f'"{named}" is no filter of robot_localization'
        suggestion: Help = Suggestion(named, filters, none="its publisher says package: robot_localization")
        return None, [Found("filter-unclear", message, ("node",), suggestion)]
    name = named or next(iter(filters), _USUAL)
    owned = frames.owned(filters[name]) if name in filters else []
    if not owned:
        message = f'no edge is of "{name}": it is written with publish_tf: false'
        help = f"if it is to publish {frames.odom} -> {frames.moved}, name it there: publisher: {name}"
        return Filter(name), [Found("filter-owns-nothing", message, (), help, NOTE, key=True)]
    possible = ((frames.odom, frames.moved), (frames.map, frames.odom))
    wrong = next((lead for lead in owned if (lead.parent, lead.child) not in possible), None)
    if wrong is not None:
        message = f'"{name}" is to publish {wrong}: a filter publishes {frames.odom} -> {frames.moved}'
        message += f" or {frames.map or 'map'} -> {frames.odom}"
        return None, [Found("navigation-owner", message, wrong.path, "correct the edge", absolute=True)]
    if len(owned) > 1:
        message = f'"{name}" is to publish {listed(map(str, owned))}: a filter publishes one of them'
        return None, [Found("navigation-owner", message, owned[1].path, "give one to another node", absolute=True)]
    return Filter(name, owned[0].parent, owned[0].child), []


def _inputs(robot: Robot, output: Output, frames: Frames) -> Iterator[Found]:
    """Yield what is wrong with the inputs."""
    inputs: Mapping[str, Mapping[str, Any]] = output.options.get("inputs") or {}
    imus = {sensor.name for sensor in robot.sensors if sensor.type == "imu"}
    rule = "filter-input"
    if not inputs:
        message = "the filter has no inputs: it estimates nothing"
        yield Found(rule, message, (), "add inputs: {odom0: {topic: NAME}}", WARNING, key=True)
    for name, one in inputs.items():
        path, match = ("inputs", name), _NAME.fullmatch(name)
        if match is None:
            help = "write odom0, pose0, twist0 or imu0, and so on"
            yield Found(rule, f'a filter has no input "{name}"', path, help, key=True)
            continue
        kind, heard, uses = match[1], topic(robot, name, one), one.get("uses")
        gap = next((at for at in range(int(match[2])) if f"{kind}{at}" not in inputs), None)
        if gap is not None:
            message = f'"{name}" would never be read: there is no {kind}{gap}'
            yield Found(rule, message, path, f"number them from 0: {kind}{gap}", key=True)
        sensor = one.get("sensor")
        if sensor is not None and sensor not in imus:
            found = next((other for other in robot.sensors if other.name == sensor), None)
            message = f'there is no sensor "{sensor}"'
            message = message if found is None else f'sensor "{sensor}" is no IMU: it is {found.type}'
            suggestion = Suggestion(sensor, imus, none="the robot has no IMU")
            yield Found(rule, message, (*path, "sensor"), suggestion)
        if not heard:
            yield Found(rule, f'"{name}" has no topic', path, "add topic: NAME", key=True)
        driving = drivers(robot) if kind == "odom" else []
        controller = one.get("controller")
        if controller is not None and controller not in [driver.name for driver in driving]:
            message = f'"{controller}" is no controller of the drive, whose odometry "{name}" could be'
            suggestion = Suggestion(controller, [driver.name for driver in driving])
            yield Found(rule, message, (*path, "controller"), suggestion)
        # In a namespace a controller is known by its own name, too: that is what people write.
        names = ((own, driver) for driver in driving for own in (driver.name, driver.topic("").strip("/")))
        meant = intended_topic(heard, {own: driver.topic(driver.odometry) for own, driver in names})
        if meant:
            message = f'no node publishes "{heard}", which "{name}" listens to: the controller publishes "{meant}"'
            yield Found(rule, message, (*path, "topic"), f'write "{meant}"', WARNING)
        for index, state in enumerate(uses or ()):
            if state not in _HAVE[kind]:
                message = f'"{name}" has no {state}: its messages have {listed(_HAVE[kind])}'
                yield Found(rule, message, (*path, "uses", index), "remove it")
        if uses is not None and not uses:
            help = "name what is, or remove the input"
            yield Found(rule, f'nothing of "{name}" is used', (*path, "uses"), help)
        if uses is None and not usual(robot, kind, frames.moved):
            message = f'"{name}" does not list the values that are used'
            message += ", and the robot has no drive" if robot.drive is None and kind != "pose" else ""
            usually = {"pose": "x, y, yaw", "imu": "vyaw"}.get(kind, "vx, vyaw")
            yield Found(rule, message, path, f"such as uses: [{usually}]", key=True)
        for key in _COPIED:
            if key in one and (key in _MISSING.get(kind, ()) or (key == _COPIED[-1] and kind != "imu")):
                yield Found(rule, f'"{name}" has no {key}', (*path, key), "remove it", key=True)


def remaps(robot: Robot, output: Output) -> list[tuple[str, str]]:
    """Return the remaps, from and to, by which the inputs of a filter come from controllers that are started."""
    topics = {driver.name: f"/{driver.topic(driver.odometry).lstrip('/')}" for driver in drivers(robot)}
    inputs: Mapping[str, Mapping[str, Any]] = output.options.get("inputs") or {}
    named = [(topic(robot, name, one), topics.get(one.get("controller", ""))) for name, one in inputs.items()]
    return [(heard, to) for heard, to in named if to is not None and f"/{heard.lstrip('/')}" != to]


def usual(robot: Robot, kind: str, base: str) -> tuple[str, ...]:
    """Return the variables of an input that are used by default, by the drive; none without a drive.

    Wheels give velocities. A base that cannot go sideways has a speed of 0 there, which is worth as much as one that
    was measured; but at the axle alone: where the frame ``base`` is elsewhere, it goes sideways as the base turns.
    """
    drive = robot.drive
    if drive is None or kind == "pose":
        return ()
    if kind == "imu":
        return ("vyaw",)
    return ("vx", "vy", "vyaw") if drive.slides or _at_axle(robot, base) else ("vx", "vyaw")


def _at_axle(robot: Robot, base: str) -> bool:
    try:
        driving = driving_of(robot)
    except (ValueError, KeyError):  # which the rules about drives tell
        return False
    return abs(robot.transform(base, driving.frame).apply((*driving.centre, 0.0))[0]) < _NEAR


def topic(robot: Robot, name: str, one: Mapping[str, Any]) -> str:
    """Return the topic of an input: its own, else that of the IMU in the description; empty if there is none."""
    if "topic" in one or not name.startswith("imu"):
        return str(one.get("topic", ""))
    known = [sensor.name for sensor in robot.sensors if sensor.type == "imu"]
    sensor = one.get("sensor") or (known[0] if len(known) == 1 else "")
    return stated_topic(robot, sensor)


def problems(robot: Robot, output: Output) -> tuple[Frames | None, Filter | None, list[Found]]:
    """Return what an output is about, and what is wrong with it."""
    frames, wrong = frames_of(robot, output)
    if frames is None:
        return None, None, wrong
    own, more = filter_of(robot, output, frames)
    return frames, own, [*wrong, *more, *_inputs(robot, output, frames)]


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield what is wrong with an entry."""
    yield from diagnose(case, output, lambda robot, output: problems(robot, output)[2])


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the parameters of a filter. The options are in the record."""
    frames, own, found = problems(robot, output)
    wrong = [one for one in found if one.severity not in (WARNING, NOTE)]
    if frames is None or own is None or wrong:
        return "", [error(one.rule, one.message, None, one.help) for one in wrong]
    publishes = f"publishes {own.parent} -> {own.child}" if own.child else "publishes no transform"
    head = [
        f"robot_localization of {asked(output).capitalize()}: {own.name} {publishes}.",
        "No covariance is in it: load it after your own.",
    ]
    return text(robot, output, templates, head, [_node(robot, output, frames, own)]), []


def view(robot: Robot, output: Output) -> Parameters:
    """Return what the parameter file of a filter is meant to contain."""
    frames, own, _ = problems(robot, output)
    return parameters_of(output, () if frames is None or own is None else [_node(robot, output, frames, own)])


def _node(robot: Robot, output: Output, frames: Frames, own: Filter) -> Node:
    values: dict[str, Any] = {}
    if "frequency" in output.options:
        values["frequency"] = output.options["frequency"]
    if "two_d_mode" in output.options or robot.drive is not None:
        values["two_d_mode"] = output.options.get("two_d_mode", True)
    values["publish_tf"] = bool(own.child)
    values |= {"map_frame": frames.map} if frames.map else {}
    values |= {"odom_frame": frames.odom, "base_link_frame": frames.moved, "world_frame": own.parent or frames.odom}
    for name, one in (output.options.get("inputs") or {}).items():
        values[name] = topic(robot, name, one)
        uses = one.get("uses") or usual(robot, name.rstrip("0123456789"), frames.moved)
        values[f"{name}_config"] = booleans(uses)
        values |= {f"{name}_{key}": one[key] for key in _COPIED if key in one}
    return Node(own.name, "ekf", values)


def booleans(uses: Sequence[str]) -> list[bool]:
    """Return the fifteen booleans of an input.

    >>> "".join("x" if one else "." for one in booleans(("vx", "vyaw")))
    '......x....x...'
    """
    return [state in uses for state in STATES]


FORMAT = parameter_file(
    "robot_localization",
    word="parameter file for robot_localization",
    about="frames, ownership and inputs of an EKF",
    rank=63,
    covers=("robot", "edges.parent", "edges.child", "edges.publisher", "publishers.node"),
    file="ekf.yaml",
    check=check,
    write=write,
    view=view,
)

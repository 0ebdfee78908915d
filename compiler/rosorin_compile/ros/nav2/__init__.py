"""Derive parameters of Nav2, AMCL and slam_toolbox from a robot, and write nav2.yaml.

Obstacle heights are relative to the global frame of the costmap, where the link that odometry moves has z = 0. The
tables ``ros2_nodes.json`` and ``ros2_ports.json`` in ``schemas`` have the frame and topic parameters of each node.
"""

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Mesh, Output, Robot, Sensor
from rosorin_compile.model.drive import STEERED, drive_kinematics
from rosorin_compile.model.mesh_vertices import clouds_of, why_unread
from rosorin_compile.rules.case import report
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Suggestion, error, phrase
from rosorin_compile.source.tree import Path

from ..controllers.write import drivers, edges_of
from ..navigation import AMCL, FILTER, SLAM, Frames, Problem, diagnose, frames_of, kind_of, owners_of_map, stated_topic
from ..parameter_files import Node, Parameters, distro_of, parameter_file, parameters_of, text
from ..ports import IN, Role, distribution_of_ports, facts, full_topic, message_of_sensor, ports, short_type
from .footprint import CORNERS, footprint, holds, pad, solids_of

_LAYERS = {"local_costmap": "voxel_layer", "global_costmap": "obstacle_layer"}  # default layers of nav2_params.yaml
_CORNERS_OF_CIRCLE = 16  # Nav2 replaces a circle with a polygon with this number of corners
_PLANAR = "lidar_2d"
_SEEING = (_PLANAR, "lidar_3d", "depth_camera")  # sensor types whose data a costmap accepts
_SOURCE = "scan"  # name of the observation source in nav2_bringup/params/nav2_params.yaml
_MONITORED = {"LaserScan": "scan", "PointCloud2": "pointcloud"}  # source type of collision_monitor by message type
_CLEARANCE = 0.05  # m: default height above which points of a point cloud are obstacles
_MOTION = {True: "nav2_amcl::OmniMotionModel", False: "nav2_amcl::DifferentialMotionModel"}


class _Source(NamedTuple):
    """An observation source of a costmap; ``topic`` is "" if unknown. Points below ``clearance`` (m) are ignored."""

    name: str
    sensor: Sensor
    topic: str
    type: str
    clearance: float


class _Basics(NamedTuple):
    frames: Frames
    base: str
    positions: Mapping[str, float]
    sources: list[_Source]


class _Size(NamedTuple):
    """The footprint parameters of a costmap; ``heights`` are the minimum and maximum obstacle height (m)."""

    parameters: Mapping[str, Any]
    heights: tuple[float, float]
    remark: str = ""

    def band(self, place: str, clearance: float = 0.0) -> dict[str, float]:
        low, high = self.heights
        return {f"{place}.min_obstacle_height": _round(low + clearance), f"{place}.max_obstacle_height": high}


def _basics(robot: Robot, output: Output) -> tuple[_Basics | None, list[Problem]]:
    frames, wrong = frames_of(robot, output)

    def add(rule: str, message: str, path: Path = (), help: Help = "", **more: Any) -> None:
        wrong.append(Problem(rule, message, path, help, **more))

    pose, poses = output.options.get("pose"), {one.name: one.positions for one in robot.poses}
    if pose is not None and pose not in poses:
        suggestion = Suggestion(pose, poses, none="the robot has no poses")
        add("nav2-pose", f'there is no pose "{pose}"', ("pose",), suggestion)
    sensors = {sensor.name: sensor.type for sensor in robot.sensors}
    for name, source in (output.options.get("sources") or {}).items():
        sensor, path = source["sensor"], ("sources", name, "sensor")
        if sensor not in sensors:
            suggestion = Suggestion(sensor, sensors, none="the robot has no sensors")
            add("nav2-source", f'there is no sensor "{sensor}"', path, suggestion)
        elif sensors[sensor] not in _SEEING:
            message = f'sensor "{sensor}" has the type {sensors[sensor]}, which cannot detect obstacles for a costmap'
            add("nav2-source", message, path, "use a lidar or a depth camera")
    sources = _sources(robot, output)
    for one in [one for one in sources if not one.topic]:
        path = ("sources", one.name, "sensor")
        help = 'add "topic: NAME" here; a topic of the sensor counts only if it differs from the name of the sensor'
        add("nav2-source", f'sensor "{one.sensor.name}" has no topic', path, help)
    if frames is None:
        return None, wrong
    if (base := str(output.options.get("base_frame", frames.moved))) not in robot.link:
        add("nav2-base", f'there is no frame "{base}" on the robot', ("base_frame",), Suggestion(base, robot.frames))
    elif robot.moves_between(base, frames.moved):
        message = f'"{base}" moves relative to "{frames.moved}", the frame that odometry moves'
        add("nav2-base", message, ("base_frame",), f'use a frame that is fixed to "{frames.moved}"')
    locating = [one for one in robot.publishers if kind_of(one) in (AMCL, SLAM)]
    owned = [(one, lead) for one in locating for lead in frames.transforms_of(one)]
    others = [(one, lead) for one, lead in owned if (lead.parent, lead.child) != (frames.map, frames.odom)]
    for publisher, lead in others:
        step = f"{frames.map or 'map'} -> {frames.odom if frames.map else 'odom'}"
        message = f'"{publisher.name}" has to publish {lead}, but can only publish {step}'
        add("navigation-owner", message, lead.path, absolute=True)
    if not frames.map and not others:
        message = f"the transform map -> {frames.odom} has no publisher: parameters with the map frame are left out"
        add("navigation-no-map", message, severity=WARNING, key=True)
    spoken = [distro_of(one) for one in robot.outputs if one.backend == "controllers"]
    if spoken and distro_of(output) not in spoken:
        message = f'output "{output.name}" is for {distro_of(output).capitalize()}, but the controllers are for '
        help = "use the same distribution, so that the nodes of both have the same message types"
        add("controllers-distribution", message + spoken[0].capitalize(), ("distribution",), help, severity=WARNING)
    stamped = [one for one in drivers(robot) if one.stamped and distro_of(output) == HUMBLE]
    # A kind has no distribution if its controller type does not exist there, which is an error of its own.
    for driver in [one for one in stamped if one.one.kind is not None and one.one.kind.distribution]:
        message = f'controller "{driver.name}" expects TwistStamped, but Nav2 of {HUMBLE.capitalize()} sends Twist'
        add("nav2-command", message, ("controllers", driver.name), severity=WARNING, absolute=True, key=True)
    return _Basics(frames, base, poses.get(str(pose), {}), sources), wrong


def _sources(robot: Robot, output: Output) -> list[_Source]:
    seeing = {one.name: one for one in robot.sensors if one.type in _SEEING}
    given: Mapping[str, Mapping[str, Any]] = output.options.get("sources") or {}
    if not given:
        names = [name for name in seeing if stated_topic(robot, name)]
        given = {_SOURCE if len(names) == 1 else name: {"sensor": name} for name in names}
    found = []
    for name, source in given.items():
        if sensor := seeing.get(source["sensor"]):
            kind = short_type(message_of_sensor(sensor.type))
            clearance = _CLEARANCE if kind == "PointCloud2" and "clearance" not in output.options else 0.0
            topic = str(source.get("topic") or stated_topic(robot, sensor.name))
            found.append(_Source(name, sensor, topic, kind, clearance))
    return found


@of_robot
def _measure(robot: Robot, output: Output) -> tuple[_Size | None, list[Diagnostic]]:
    made, _ = _basics(robot, output)
    if made is None:
        return None, []
    rule, left, options = "nav2-footprint", "footprint and heights are left out", output.options
    solids, unknown = solids_of(robot, made.base, made.positions, clouds_of(robot))
    if unknown:
        shapes = [shape.geometry for name in unknown for shape in robot.link[name].collision]
        reasons = {mesh.file: why_unread(robot, mesh.file) for mesh in shapes if isinstance(mesh, Mesh)}
        files = [file for file, reason in reasons.items() if reason]
        message = f"the size of {phrase(files, 3)} (link {phrase(unknown, 3)}) is unknown: {left}"
        help = f"{reasons[files[0]]}; use an existing STL or OBJ file, or give the link a box or cylinder"
        return None, [report(rule, message, help=help)]
    if not solids:
        return None, [report(rule, f"no link of the robot has a collision shape: {left}")]
    corners = int(options.get("corners", CORNERS))
    try:
        outline = footprint(solids, corners)
    except ValueError as problem:
        return None, [report(rule, f"{problem}: {left}", help="correct the sizes of the shapes")]
    found, circle = [], options.get("outline") == "circle"
    if outline.inscribed <= 0 and not circle:
        message = f'the base frame "{made.base}" is not within the footprint, as Nav2 requires'
        found.append(report(rule, message, help='write "base_frame: FRAME" with a frame in the middle of the robot'))

    def above(frame: str) -> float:
        return robot.transform(made.frames.moved, frame, made.positions).xyz[2]

    # Obstacles are detected from the floor to the top of the robot, or to the highest 2D lidar.
    up, planes = above(made.base), [above(sensor.frame) for sensor in robot.sensors if sensor.type == _PLANAR]
    low = min(0.0, outline.lowest + up) + float(options.get("clearance", 0.0))
    high = max([outline.highest + up, *planes]) + float(options.get("headroom", 0.1))  # m
    heights = (math.floor(low * 1000 + 0.5) / 1000 + 0.0, math.ceil(high * 1000) / 1000)
    for source in made.sources:
        at = above(source.sensor.frame)
        if source.sensor.type == _PLANAR and at <= heights[0]:
            message = f'lidar "{source.sensor.name}" sees nothing: it is {at:.3g} m above the floor, but points below '
            message += f"{heights[0]:g} m are not obstacles"
            found.append(error("nav2-source", message, None, 'lower "clearance"'))
    padding, remark = options.get("padding"), ""
    free = float(0.01 if padding is None else padding)  # m; 0.01 is Nav2's default
    if not circle and not holds(solids, pad(outline.corners, free)):
        outline, padding = footprint(solids, corners, free), 0.0
        remark = f"It has {free:g} m of padding: Nav2's own would move a corner inwards."
    around = outline.circumscribed / math.cos(math.pi / _CORNERS_OF_CIRCLE)
    points = "" if circle else ", ".join(f"[{x!r}, {y!r}]" for x, y in outline.corners)
    values: dict[str, Any] = {"footprint": f"[{points}]", "robot_radius": math.ceil(around * 1e4) / 1e4}
    values |= {} if padding is None else {"footprint_padding": float(padding)}
    return _Size(values, heights, remark), found


def _round(height: float) -> float:
    return round(height * 1000) / 1000 + 0.0


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return (text of nav2.yaml, diagnostics); the text is "" if the output has errors."""
    made, found = _basics(robot, output)
    if made is None or any(one.severity == ERROR for one in found):
        return "", []  # rules report these errors
    size, diagnostics = _measure(robot, output)
    head = [f"Nav2 of {distro_of(output).capitalize()}: frames, footprint and heights of the robot."]
    head += ["No tuning is in it: load it after your own."]
    if size is not None:
        pose = output.options.get("pose")
        head += [f"The footprint is that {'with all joints at zero' if pose is None else f'in the pose {pose}'}."]
        head += [size.remark] if size.remark else []
        low = f"That points are obstacles from {_CLEARANCE:g} m above the floor is a stand-in: set clearance."
        head += [low] if any(source.clearance for source in made.sources) else []
    return text(robot, output, templates, head, list(_nodes(robot, output, made, size))), diagnostics


def view(robot: Robot, output: Output) -> Parameters:
    """Return the parameters in nav2.yaml, for comparison with an existing file."""
    made, size = _basics(robot, output)[0], _measure(robot, output)[0]
    return parameters_of(output, () if made is None else _nodes(robot, output, made, size))


def _nodes(robot: Robot, output: Output, made: _Basics, size: _Size | None) -> Iterator[Node]:
    distribution, frames = distribution_of_ports(distro_of(output)), made.frames
    facts_of = facts("ros2_nodes")["navigation"]
    known = {"map": frames.map, "odom": frames.odom, "base": made.base}
    found: dict[str, dict[str, Any]] = {}
    for row in facts_of["frames"]:
        values = {key: known[frame] for key, frame in row["keys"].items() if known[frame]}
        is_complete = len(values) == len(row["keys"]) or row.get("optional", False)
        if is_complete and distribution in row.get("only", [distribution]):
            found[row["node"]] = values
    for name in _LAYERS.keys() & found.keys():
        found[name] |= _costmap(output, name, made.sources, size)
    found["collision_monitor"] |= _monitored(robot, output, made, size)
    # Use the odometry topic of the drive controller that publishes the transform odom -> base.
    driving = drivers(robot)
    of_drive: dict[str, str] = {}
    for driver in reversed(driving):
        owners = (edge.publisher.name for edge in edges_of(robot, driver.one.controller))
        of_drive |= dict.fromkeys(owners, driver.topic(driver.odometry))
    moving = [one.publisher for one in frames.leads if (one.parent, one.child) == (frames.odom, frames.moved)]
    topics = {"odometry/filtered" if kind_of(one) == FILTER else of_drive.get(one.name, "") for one in moving}
    odometry = topics.pop() if len(topics) == 1 else ""
    for port in ports(distribution, role=Role.ODOMETRY, direction=IN, group="nav2") if odometry else ():
        found.setdefault(port.node, {})[port.parameter] = odometry
    stamping = [one for one in ports(distribution, role=Role.VELOCITY, group="nav2") if one.stamp_parameter]
    for port in stamping if driving else ():
        found.setdefault(port.node, {})[port.stamp_parameter] = driving[0].stamped
    if robot.drive is not None and robot.drive.slides:  # by default, Nav2 limits the lateral velocity to 0
        for name, limits in facts_of["sideways"][distribution].items():
            found[name] |= limits
    if robot.drive is not None and robot.drive.kind in STEERED:  # by default, MPPI turns in place
        found["controller_server"] |= _steered(robot)
    for name, values in found.items():
        yield Node(f"{name}/{name}", "costmap", values) if name in _LAYERS else Node(name, name, values)
    if not frames.map:
        return
    # nav2_bringup always starts AMCL, with `tf_broadcast: true` by default; slam_toolbox is optional.
    amcl: dict[str, Any] = {"global_frame_id": frames.map, "odom_frame_id": frames.odom}
    amcl |= {"base_frame_id": frames.moved, "tf_broadcast": AMCL in owners_of_map(frames)}
    if robot.drive is not None:
        amcl["robot_model_type"] = _MOTION[robot.drive.slides]
    yield Node(AMCL, AMCL, amcl | _scan(robot, output, AMCL))
    if any(kind_of(one) == SLAM for one in robot.publishers):
        yield Node(SLAM, SLAM, slam_parameters(robot, output, frames))


def _steered(robot: Robot) -> dict[str, Any]:
    """Return the motion model of a drive with steering, with its least turning radius (m) if the joints have limits."""
    values: dict[str, Any] = {"FollowPath.motion_model": "Ackermann"}
    with suppress(ValueError, KeyError):  # rules about drives report the error
        radii = []
        for one in drive_kinematics(robot).steering:
            lower, upper = robot.joint[one.joint].limits_of("position")
            angle = min(-(lower or 0.0), upper or 0.0, math.pi / 2)
            radii += [abs(one.x) / math.tan(angle) + abs(one.y)] if angle > 0 else []
        if radii:
            values["FollowPath.AckermannConstraints.min_turning_r"] = math.ceil(max(radii) * 1000) / 1000
    return values


def _costmap(output: Output, name: str, sources: list[_Source], size: _Size | None) -> dict[str, Any]:
    layer = (output.options.get("layers") or {}).get(name, _LAYERS[name])
    values = {**size.parameters, **size.band(layer)} if size is not None else {}
    if sources:
        values[f"{layer}.observation_sources"] = " ".join(source.name for source in sources)
    for source in sources:
        own = f"{layer}.{source.name}"
        values |= {f"{own}.topic": full_topic(source.topic, "", ""), f"{own}.data_type": source.type}
        values[f"{own}.sensor_frame"] = source.sensor.optical_frame or source.sensor.frame
        values |= {f"{own}.{key}": value for key, value in facts("ros2_nodes")["navigation"]["source"].items()}
        values |= size.band(own, source.clearance) if size is not None else {}
    return values


def _monitored(robot: Robot, output: Output, made: _Basics, size: _Size | None) -> dict[str, Any]:
    """Return the observation sources of collision_monitor; their heights (m) are relative to the base frame."""
    up = robot.transform(made.frames.moved, made.base, made.positions).xyz[2]
    values: dict[str, Any] = {}
    for port in ports(distro_of(output), node="collision_monitor", role=Role.OBSTACLES) if made.sources else ():
        values[port.each] = [source.name for source in made.sources]
        for source in made.sources:
            name, kind = source.name, _MONITORED[source.type]
            values |= {f"{name}.type": kind, port.parameter.replace("<source>", name): source.topic}
            if kind == "pointcloud" and size is not None:
                low, high = size.heights[0] + source.clearance, size.heights[1]
                values |= {f"{name}.min_height": _round(low - up), f"{name}.max_height": _round(high - up)}
    return values


def _scan(robot: Robot, output: Output, node: str) -> dict[str, Any]:
    """Return the parameter with the scan topic of a node: that of the only 2D lidar, or of the source "scan", or {}."""
    lidars = [source for source in _sources(robot, output) if source.sensor.type == _PLANAR]
    topics = {source.topic for source in lidars if source.name == _SOURCE} or {source.topic for source in lidars}
    topics = topics or {stated_topic(robot, one.name) for one in robot.sensors if one.type == _PLANAR}
    topic = topics.pop() if len(topics) == 1 else ""
    return {port.parameter: topic for port in ports(distro_of(output), node=node, role=Role.SCAN)} if topic else {}


def slam_parameters(robot: Robot, output: Output, frames: Frames) -> dict[str, Any]:
    """Return the frame and scan topic parameters of slam_toolbox, which replaces AMCL if it is not in "publishers"."""
    values = {"map_frame": frames.map, "odom_frame": frames.odom, "base_frame": frames.moved}
    owners, is_listed = owners_of_map(frames), any(kind_of(one) == SLAM for one in robot.publishers)
    is_silent = SLAM not in owners if frames.map and is_listed else FILTER in owners
    return values | _scan(robot, output, SLAM) | ({"transform_publish_period": 0.0} if is_silent else {})


FORMAT = parameter_file(
    "nav2",
    word="parameter file for Nav2",
    about="frames, footprint and height of the robot for Nav2, AMCL and slam_toolbox",
    rank=62,
    covers=("robot", "edges.parent", "edges.child"),
    file="nav2.yaml",
    check=partial(diagnose, find=_basics),
    write=write,
    view=view,
    measures=True,
)

"""The parameters of Nav2, AMCL and slam_toolbox that a description knows.

Heights of obstacles are those of the costmap's global frame, in which the frame that the odometry moves is at z = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Mesh, Output, Publisher, Robot, Sensor
from rosorin_compile.model.mesh_vertices import clouds_of, why_unread
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, error, listed

from ..controllers.derived import owned
from ..controllers.filled import Driver, drivers
from ..navigation import AMCL, FILTER, SLAM, Found, Frames, diagnose, frames_of, kind_of, stated_topic
from ..parameters import parameter_file
from ..parameters.files import Node, Parameters, asked, parameters_of, text
from ..ports import IN, OBSTACLES, ODOMETRY, VELOCITY, message_of_sensor, ports, short_type
from .footprint import CORNERS, Footprint, footprint, left_out, padded, solids

LOCAL, GLOBAL = "local_costmap", "global_costmap"
_LAYERS = {LOCAL: "voxel_layer", GLOBAL: "obstacle_layer"}  # nav2_bringup/params/nav2_params.yaml
_HEADROOM = 0.1  # m
_PADDING = 0.01  # m, Nav2's own
_CORNERS_OF_CIRCLE = 16  # of what Nav2 makes of a radius, on the circle
CIRCLE = "circle"
PLANAR = "lidar_2d"
SEEING = (PLANAR, "lidar_3d", "depth_camera")  # the types of sensors that see obstacles
_SOURCE = "scan"  # the observation source of nav2_bringup/params/nav2_params.yaml
_MONITORED = {"LaserScan": "scan", "PointCloud2": "pointcloud"}  # types of sources of the collision_monitor
_RANGES = {"obstacle_max_range": 2.5, "raytrace_max_range": 3.0}  # m, Nav2's own: it clears farther than it marks
_CLEARANCE = 0.05  # m, of points of depth where the output gives none: they see the floor
_MOTION = {True: "nav2_amcl::OmniMotionModel", False: "nav2_amcl::DifferentialMotionModel"}
_MILLIMETRES = 1000
_FILTERED = "odometry/filtered"  # of robot_localization
# How fast a base goes along x and how fast it turns (m/s, rad/s), as nav2_params.yaml has it, by distribution.
_SPEEDS = {HUMBLE: (0.26, 1.0), JAZZY: (0.5, 2.0)}
_ACCELERATIONS = (2.5, 3.2)


class Basics(NamedTuple):
    """What a description knows for Nav2: the frames, the base frame of Nav2, and the positions of the joints."""

    frames: Frames
    base: str
    positions: Mapping[str, float]


class Measured(NamedTuple):
    """The robot in numbers: its footprint, and between which heights (m) something is an obstacle.

    ``padding`` (m) is what Nav2 is told of it; None for its own. ``remarks`` are about the footprint.
    """

    outline: Footprint
    heights: tuple[float, float]
    padding: float | None
    remarks: tuple[str, ...] = ()


def basics(robot: Robot, output: Output) -> tuple[Basics | None, list[Found]]:
    """Return what is known of a robot for an output without measuring it, and all that is wrong."""
    frames, wrong = frames_of(robot, output)
    pose = output.options.get("pose")
    poses = {one.name: one.positions for one in robot.poses}
    if pose is not None and pose not in poses:
        suggestion = Suggestion(pose, poses, none="the robot has no poses")
        wrong.append(Found("nav2-pose", f'there is no pose "{pose}"', ("pose",), suggestion))
    wrong += _sources(robot, output)
    if frames is None:
        return None, wrong
    base = str(output.options.get("base_frame", frames.moved))
    wrong += _problems(robot, output, frames, base)
    return Basics(frames, base, poses.get(pose, {}) if pose is not None else {}), wrong


def _problems(robot: Robot, output: Output, frames: Frames, base: str) -> Iterator[Found]:
    """Yield what is wrong with the base frame, with who publishes map -> odom, and with who takes velocities."""
    if base not in robot.link:
        suggestion = Suggestion(base, robot.frames)
        yield Found("nav2-base", f'there is no frame "{base}" on the robot', ("base_frame",), suggestion)
    elif robot.moves_between(base, frames.moved):
        message = f'"{base}" moves against "{frames.moved}", which the odometry moves'
        yield Found("nav2-base", message, ("base_frame",), "name a frame that is fixed to it")
    else:
        yield from _left_out(robot, output, base)
    step = f"{frames.map or 'map'} -> {frames.odom if frames.map else 'odom'}"
    leads = [(one, lead) for one in robot.publishers if kind_of(one) in (AMCL, SLAM) for lead in frames.owned(one)]
    wrong = [(one, lead) for one, lead in leads if (lead.parent, lead.child) != (frames.map, frames.odom)]
    for publisher, lead in wrong:
        message = f'"{publisher.name}" is to publish {lead}, and it publishes {step} alone'
        help = "correct the edge: the step from the odometry to the robot is of another node"
        yield Found("navigation-owner", message, lead.path, help, absolute=True)
    if not frames.map and not wrong:
        message = f"no publisher is described for map -> {frames.odom}: what needs the frame of a map is left out"
        help = f"add it to edges: {{parent: map, child: {frames.odom}, publisher: NAME}}"
        yield Found("navigation-no-map", message, (), help, WARNING, key=True)
    for driver in drivers(robot) if asked(output) == HUMBLE else ():
        if driver.stamped:
            message = f'controller "{driver.name}" takes TwistStamped, and Nav2 of {HUMBLE.capitalize()} sends Twist'
            help = "give it use_stamped_vel: false, where its output is for Humble, too"
            yield Found("nav2-command", message, ("controllers", driver.name), help, WARNING, absolute=True, key=True)


def _left_out(robot: Robot, output: Output, base: str) -> Iterator[Found]:
    pose, poses = output.options.get("pose"), {one.name: one.positions for one in robot.poses}
    if pose not in poses or not robot.is_tree or not robot.mimics_resolve:
        return
    for one in left_out(robot, base, poses[pose], clouds_of(robot)):
        reaches = f'"{one.link}" reaches {one.reach:.3g} m from "{base}", as far as it can: {one.least:.3g} m elsewhere'
        message = f'pose "{pose}" does not name joint "{one.joint}", which stays at zero, where {reaches}'
        yield Found("nav2-pose-left-out", message, ("pose",), "name it in the pose", WARNING)


def measured(robot: Robot, output: Output, made: Basics) -> tuple[Measured | None, list[Diagnostic]]:
    """Return the dimensions and velocities of the robot, and diagnostics; None if its size is unknown."""
    corners, clouds = int(output.options.get("corners", CORNERS)), clouds_of(robot)
    try:
        outline = footprint(robot, made.base, made.positions, corners, clouds)
    except ValueError as problem:
        message = f"{problem}: footprint and heights are left out"
        return None, [Diagnostic("nav2-footprint", WARNING, message, help="correct the size of its shapes")]
    if outline is None or outline.meshes:
        _, unknown = solids(robot, made.base, made.positions, clouds)
        return None, [_unmeasured(robot, unknown)]
    said = []
    circle = output.options.get("outline") == CIRCLE
    if outline.inscribed <= 0 and not circle:
        message = f'the base frame "{made.base}" is not within the footprint, which Nav2 takes for granted'
        said.append(Diagnostic("nav2-footprint", WARNING, message, help="name a frame in the middle: base_frame"))
    heights = _heights(robot, output, made, outline)
    sources = {source["sensor"] for source in sources_of(robot, output).values()}
    for sensor in robot.sensors:
        at = _above(robot, made, sensor)
        if sensor.type == PLANAR and sensor.name in sources and at <= heights[0]:
            message = f'lidar "{sensor.name}" sees nothing: it is at {at:.3g} m, and what is below {heights[0]:g} m is '
            said.append(error("nav2-source", f"{message}no obstacle", None, "make clearance less"))
    padding = output.options.get("padding")
    free = float(_PADDING if padding is None else padding)
    if circle or outline.holds(padded(outline.corners, free)):
        return Measured(outline, heights, None if padding is None else free), said
    grown = footprint(robot, made.base, made.positions, corners, clouds, free)
    remark = f"It has {free:g} m of padding: Nav2's own would move a corner inwards."
    return Measured(grown or outline, heights, 0.0, (remark,)), said


def _unmeasured(robot: Robot, unknown: Sequence[str]) -> Diagnostic:
    left = "footprint and heights are left out"
    if not unknown:
        message = f"no link of the robot has a collision shape: {left}"
        return Diagnostic("nav2-footprint", WARNING, message, help="give its links collision shapes")
    shapes = [shape.geometry for name in unknown for shape in robot.link[name].collision]
    reasons = {mesh.file: why_unread(robot, mesh.file) for mesh in shapes if isinstance(mesh, Mesh)}
    files = [file for file, reason in reasons.items() if reason]
    message = f"the size of {listed(files, 3)} is unknown ({listed(unknown, 3)}): {left}"
    way_out = f"{reasons[files[0]]}: name an STL or an OBJ that is there, or give the link a box or a cylinder"
    return Diagnostic("nav2-footprint", WARNING, message, help=way_out)


def _heights(robot: Robot, output: Output, made: Basics, outline: Footprint) -> tuple[float, float]:
    """Return between which heights (m) something is an obstacle: over the floor, and as high as the robot reaches.

    A lidar of one plane sees at its own height: that is within, also where nothing of the robot is as high.
    """
    up = robot.transform(made.frames.moved, made.base, made.positions).xyz[2]
    planes = [_above(robot, made, sensor) for sensor in robot.sensors if sensor.type == PLANAR]
    low = min(0.0, outline.lowest + up) + float(output.options.get("clearance", 0.0))
    high = max([outline.highest + up, *planes]) + float(output.options.get("headroom", _HEADROOM))
    return math.floor(low * _MILLIMETRES + 0.5) / _MILLIMETRES + 0.0, math.ceil(high * _MILLIMETRES) / _MILLIMETRES


def _above(robot: Robot, made: Basics, sensor: Sensor) -> float:
    return robot.transform(made.frames.moved, sensor.frame, made.positions).xyz[2]


def _sources(robot: Robot, output: Output) -> Iterator[Found]:
    sensors = {sensor.name: sensor for sensor in robot.sensors}
    for name, source in (output.options.get("sources") or {}).items():
        sensor, path = sensors.get(source["sensor"]), ("sources", name, "sensor")
        if sensor is None:
            way_out = Suggestion(source["sensor"], sensors, none="the robot has no sensors")
            yield Found("nav2-source", f'there is no sensor "{source["sensor"]}"', path, way_out)
        elif sensor.type not in SEEING:
            article = "an" if sensor.type[0] in "aeiou" else "a"
            message = f'sensor "{sensor.name}" is {article} {sensor.type}, which sees no obstacles for a costmap'
            yield Found("nav2-source", message, path, "name a lidar or a depth camera")
        elif not topic_of(robot, source):
            message = f'sensor "{sensor.name}" has no topic'
            yield Found("nav2-source", message, path, "add topic: NAME")


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield what is wrong with an entry."""
    yield from diagnose(case, output, lambda robot, output: basics(robot, output)[1])


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the parameters of a robot for Nav2. The options are in the record."""
    made, found = basics(robot, output)
    wrong = [error(one.rule, one.message, None, one.help) for one in found if one.severity != WARNING]
    if made is None or wrong:
        return "", wrong
    size, said = measured(robot, output, made)
    head = [
        f"Nav2 of {asked(output).capitalize()}: frames, footprint and heights of the robot.",
        "No tuning is in it: load it after your own.",
    ]
    if size is not None:
        pose = output.options.get("pose")
        at = "with all joints at zero" if pose is None else f"in the pose {pose}"
        head += [f"The footprint is that {at}.", *size.remarks]
        sensors = {source["sensor"] for source in sources_of(robot, output).values()}
        if any(one.name in sensors and _stands_in(output, one) for one in robot.sensors):
            head.append(
                f"That points are obstacles from {_CLEARANCE:g} m above the floor is a stand-in: set clearance."
            )
    return text(robot, output, templates, head, list(_nodes(robot, output, made, size))), said


def view(robot: Robot, output: Output) -> Parameters:
    """Return what the parameter file of a robot for Nav2 is meant to contain."""
    made, _ = basics(robot, output)
    return parameters_of(output, () if made is None else _nodes(robot, output, made, measured(robot, output, made)[0]))


def _nodes(robot: Robot, output: Output, made: Basics, size: Measured | None) -> Iterator[Node]:
    frames, base = made.frames, {"robot_base_frame": made.base}
    costmaps = {LOCAL: frames.odom, **({GLOBAL: frames.map} if frames.map else {})}
    for name, frame in costmaps.items():
        layer = (output.options.get("layers") or {}).get(name, _LAYERS[name])
        values: dict[str, Any] = {"global_frame": frame, **base, **_outline(output, size)}
        values |= _band(layer, size)
        yield Node(f"{name}/{name}", "costmap", values | dict(_seen(robot, output, layer, size)))
    servers = _servers(output, made)
    servers["collision_monitor"] |= _monitored(robot, output, made, size)
    for name, more in _way_of_velocities(robot, output, frames).items():
        servers[name] = {**servers.get(name, {}), **more}
    yield from (Node(name, name, values) for name, values in servers.items() if values)
    if frames.map:
        yield from _localisation(robot, output, frames)


def _servers(output: Output, made: Basics) -> dict[str, dict[str, Any]]:
    frames, base = made.frames, {"robot_base_frame": made.base}
    found: dict[str, dict[str, Any]] = {}
    if frames.map:
        found["bt_navigator"] = {"global_frame": frames.map, **base}
    found["controller_server"] = {}
    # In Humble the behaviours have one frame, that of the local costmap.
    local = {"global_frame": frames.odom} if asked(output) == HUMBLE else {"local_frame": frames.odom}
    far = {"global_frame": frames.map} if frames.map and "local_frame" in local else {}
    found["behavior_server"] = {**local, **far, **base}
    found["velocity_smoother"] = {}
    found["collision_monitor"] = {"base_frame_id": made.base, "odom_frame_id": frames.odom}
    if asked(output) != HUMBLE:
        found["docking_server"] = {"base_frame": made.base, "fixed_frame": frames.odom}
    if asked(output) not in (HUMBLE, JAZZY) and frames.map:
        found["route_server"] = {"base_frame": made.base, "route_frame": frames.map}
    return found


def _way_of_velocities(robot: Robot, output: Output, frames: Frames) -> dict[str, dict[str, Any]]:
    distribution, driving, odometry = asked(output), drivers(robot), _odometry(robot, frames)
    found: dict[str, dict[str, Any]] = {}
    for port in ports(distribution, role=ODOMETRY, direction=IN, group="nav2") if odometry else ():
        found.setdefault(port.node, {})[port.parameter] = odometry
    for port in ports(distribution, role=VELOCITY, group="nav2") if driving else ():
        if port.stamp_parameter:
            found.setdefault(port.node, {})[port.stamp_parameter] = driving[0].stamped
    if robot.drive is not None and robot.drive.slides:  # Nav2's own limits keep every base from going sideways
        for name, values in _sideways(distribution).items():
            found[name] = {**found.get(name, {}), **values}
    return found


def _sideways(distribution: str) -> dict[str, dict[str, Any]]:
    (ahead, turning), (push, twist) = _SPEEDS.get(distribution, _SPEEDS[JAZZY]), _ACCELERATIONS
    smoother = {"max_velocity": [ahead, ahead, turning], "min_velocity": [-ahead, -ahead, -turning]}
    smoother |= {"max_accel": [push, push, twist], "max_decel": [-push, -push, -twist]}
    controller: dict[str, Any] = {"FollowPath.motion_model": "Omni"}
    if distribution == HUMBLE:
        limits = (("min_vel_y", -ahead), ("max_vel_y", ahead), ("acc_lim_y", push), ("decel_lim_y", -push))
        controller = {f"FollowPath.{name}": value for name, value in limits}
    return {"controller_server": controller, "velocity_smoother": smoother}


def _odometry(robot: Robot, frames: Frames) -> str:

    def topics(publisher: Publisher) -> Iterator[str]:
        if kind_of(publisher) == FILTER:
            yield _FILTERED
        yield from (driver.topic(driver.odometry) for driver in driving if _owns(robot, driver, publisher))

    driving = drivers(robot)
    moving = [lead.publisher for lead in frames.leads if (lead.parent, lead.child) == (frames.odom, frames.moved)]
    found = {next(topics(publisher), "") for publisher in moving}
    return found.pop() if len(found) == 1 else ""


def _owns(robot: Robot, driver: Driver, publisher: Publisher) -> bool:
    return any(edge.publisher.name == publisher.name for edge in owned(robot, driver.one.controller))


def _outline(output: Output, size: Measured | None) -> dict[str, Any]:
    if size is None:
        return {}
    around = size.outline.circumscribed / math.cos(math.pi / _CORNERS_OF_CIRCLE)
    circle = output.options.get("outline") == CIRCLE
    corners = "" if circle else ", ".join(f"[{x!r}, {y!r}]" for x, y in size.outline.corners)
    values: dict[str, Any] = {"footprint": f"[{corners}]", "robot_radius": math.ceil(around * 1e4) / 1e4}
    return values if size.padding is None else {**values, "footprint_padding": size.padding}


def _band(place: str, size: Measured | None, clearance: float = 0.0) -> dict[str, float]:
    if size is None:
        return {}
    heights = {"min_obstacle_height": _round(size.heights[0] + clearance), "max_obstacle_height": size.heights[1]}
    return {f"{place}.{name}": height for name, height in heights.items()}


def sources_of(robot: Robot, output: Output) -> dict[str, Mapping[str, Any]]:
    """Return the observation sources by name: those of the output, else all sensors with a topic that see obstacles."""
    seeing = [one for one in robot.sensors if one.type in SEEING]
    if given := output.options.get("sources"):
        names = [one.name for one in seeing]
        return {name: one for name, one in given.items() if one["sensor"] in names}
    seeing = [one for one in seeing if stated_topic(robot, one.name)]
    return {_SOURCE if len(seeing) == 1 else one.name: {"sensor": one.name} for one in seeing}


def topic_of(robot: Robot, source: Mapping[str, Any]) -> str:
    """Return the topic of an observation source, or "" if nothing in the description names it."""
    return str(source.get("topic") or stated_topic(robot, source["sensor"]))


def scan_topic(robot: Robot, output: Output) -> str:
    """Return the topic of the only lidar of one plane, or "" if it is unknown."""
    lidars = [sensor.name for sensor in robot.sensors if sensor.type == PLANAR]
    topics = {topic_of(robot, one) for one in sources_of(robot, output).values() if one["sensor"] in lidars}
    topics |= {stated_topic(robot, lidars[0])} if len(lidars) == 1 and not topics else set()
    return topics.pop() if len(topics) == 1 else ""


def seen_by_slam(robot: Robot, output: Output, frames: Frames) -> dict[str, Any]:
    """Return the frames and the topic of the scan for slam_toolbox."""
    values = {"map_frame": frames.map, "odom_frame": frames.odom, "base_frame": frames.moved}
    return values | _scan(robot, output, SLAM)


def _scan(robot: Robot, output: Output, node: str) -> dict[str, Any]:
    topic = scan_topic(robot, output)
    return {port.parameter: topic for port in ports(asked(output), node=node, role="scan")} if topic else {}


def _stands_in(output: Output, sensor: Sensor) -> bool:
    return short_type(message_of_sensor(sensor.type)) == "PointCloud2" and "clearance" not in output.options


def _seen(robot: Robot, output: Output, layer: str, size: Measured | None) -> Iterator[tuple[str, Any]]:
    sources = sources_of(robot, output)
    sensors: dict[str, Sensor] = {sensor.name: sensor for sensor in robot.sensors}
    if sources:
        yield f"{layer}.observation_sources", " ".join(sources)
    for name, source in sources.items():
        sensor, own = sensors[source["sensor"]], f"{layer}.{name}"
        yield f"{own}.topic", topic_of(robot, source)
        yield f"{own}.data_type", short_type(message_of_sensor(sensor.type))
        yield f"{own}.sensor_frame", sensor.optical_frame or sensor.frame
        yield from ((f"{own}.{key}", True) for key in ("marking", "clearing"))
        yield from ((f"{own}.{key}", value) for key, value in _RANGES.items())
        yield from _band(own, size, _CLEARANCE if _stands_in(output, sensor) else 0.0).items()


def _monitored(robot: Robot, output: Output, made: Basics, size: Measured | None) -> dict[str, Any]:
    sources, sensors = sources_of(robot, output), {sensor.name: sensor for sensor in robot.sensors}
    values: dict[str, Any] = {}
    for port in ports(asked(output), node="collision_monitor", role=OBSTACLES) if sources else ():
        values[port.each] = list(sources)
        for name, source in sources.items():
            sensor = sensors[source["sensor"]]
            kind = _MONITORED[short_type(message_of_sensor(sensor.type))]
            values |= {f"{name}.type": kind, port.parameter.replace("<source>", name): topic_of(robot, source)}
            if kind == "pointcloud" and size is not None:  # in the base frame
                up = robot.transform(made.frames.moved, made.base, made.positions).xyz[2]
                low = size.heights[0] + (_CLEARANCE if _stands_in(output, sensor) else 0.0)
                values |= {f"{name}.min_height": _round(low - up), f"{name}.max_height": _round(size.heights[1] - up)}
    return values


def _round(height: float) -> float:
    return round(height * _MILLIMETRES) / _MILLIMETRES + 0.0


def _localisation(robot: Robot, output: Output, frames: Frames) -> Iterator[Node]:
    """Yield AMCL, and slam_toolbox if it is there: the frames, and whether it publishes map -> odom, as the edges say.

    nav2_bringup starts AMCL by default, with `tf_broadcast: true`.
    """
    there = {kind: [one for one in robot.publishers if kind_of(one) == kind] for kind in (AMCL, SLAM)}
    owns = {kind: any(frames.owned(one) for one in mine) for kind, mine in there.items()}
    values: dict[str, Any] = {"global_frame_id": frames.map, "odom_frame_id": frames.odom}
    values |= {"base_frame_id": frames.moved, "tf_broadcast": owns[AMCL]}
    if (drive := robot.drive) is not None:
        values["robot_model_type"] = _MOTION[drive.slides]
    yield Node(AMCL, AMCL, values | _scan(robot, output, AMCL))
    if there[SLAM]:
        silent = {} if owns[SLAM] else {"transform_publish_period": 0.0}
        yield Node(SLAM, SLAM, seen_by_slam(robot, output, frames) | silent)


FORMAT = parameter_file(
    "nav2",
    word="parameter file for Nav2",
    about="frames, footprint and height of the robot for Nav2, AMCL and slam_toolbox",
    rank=62,
    covers=("robot", "edges.parent", "edges.child"),
    file="nav2.yaml",
    check=check,
    write=write,
    view=view,
    measures=True,
)

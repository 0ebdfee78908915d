"""The parameters of Nav2, AMCL and slam_toolbox that a description knows.

Heights of obstacles are those of the costmap's global frame, in which the frame that the odometry moves is at z = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...diagnostics import WARNING, Diagnostic, did_you_mean, error
from ...diagnostics.registry import NAVIGATION, Rule
from ...diagnostics.wording import listed
from ...model import Mesh, Output, Publisher, Robot, Sensor
from ...model.footprint import CORNERS, Footprint, footprint, padded, solids
from ...model.footprint import outside as reaching_out
from ...model.standing import Cloud, Clouds
from ...rules.case import Case
from ..mesh_vertices import clouds_of
from ..navigation import AMCL, SLAM, Found, Frames, frames_of, kind_of, stated_topic, told
from ..node_parameters import Node, asked, nodes_of, text
from ..templating import Templates

RULES = (
    Rule(
        "nav2-footprint",
        "A warning: the footprint is left out, for the robot has no collision shapes, or meshes of unknown size, so it "
        "would be too small; or the base frame is not within it, which Nav2 takes for granted.",
        "Give the links shapes; or name another `base_frame`.",
        NAVIGATION,
    ),
    Rule(
        "nav2-base",
        "The base frame for Nav2 is no frame of the robot, or it moves against the one that the odometry moves.",
        "Name a frame that is fixed to it.",
        NAVIGATION,
    ),
    Rule("nav2-pose", "The robot has no pose of this name.", "Name one of `poses`.", NAVIGATION),
    Rule(
        "nav2-source",
        "An observation source is no sensor that sees obstacles, has no topic, or sees nothing within the heights of "
        "obstacles.",
        "As the message says.",
        NAVIGATION,
    ),
)

LOCAL, GLOBAL = "local_costmap", "global_costmap"
_LAYERS = {LOCAL: "voxel_layer", GLOBAL: "obstacle_layer"}  # nav2_bringup/params/nav2_params.yaml
_HEADROOM = 0.1  # m
_PADDING = 0.01  # m, Nav2's own
_CIRCLE = 16  # corners of what Nav2 makes of a radius, all of them on the circle
# What a sensor publishes that sees obstacles.
_SEES = {"lidar_2d": "LaserScan", "lidar_3d": "PointCloud2", "depth_camera": "PointCloud2"}
_MOTION = {True: "nav2_amcl::OmniMotionModel", False: "nav2_amcl::DifferentialMotionModel"}
_MILLIMETRES = 1000


@dataclass
class Known:
    """What a description knows for Nav2; ``wrong`` is what is wrong with it.

    ``floor`` and ``top`` (m) are how low and how high the robot reaches over the frame that the odometry moves.
    """

    frames: Frames | None
    base: str = ""
    outline: Footprint | None = None
    floor: float = 0.0
    top: float = 0.0
    remarks: list[str] = field(default_factory=list)
    wrong: list[Found] = field(default_factory=list)


def known(robot: Robot, output: Output) -> Known:
    """Return what is known of a robot for an output, and all that is wrong."""
    frames, wrong = frames_of(robot, output)
    made = Known(frames, wrong=wrong)
    pose = output.options.get("pose")
    names = [one.name for one in robot.poses]
    if pose is not None and pose not in names:
        way_out = did_you_mean(pose, names) or "the robot has no poses"
        wrong.append(Found("nav2-pose", f'there is no pose "{pose}"', ("pose",), way_out))
    if frames is None:
        return made
    made.base = str(output.options.get("base_frame", frames.moved))
    wrong += _base(robot, made.base, frames)
    wrong += _owners(robot, frames)
    if not frames.map:
        message = f"nobody is said to publish map -> {frames.odom}: what needs the frame of a map is left out"
        way_out = f"add it to edges: {{parent: map, child: {frames.odom}, publisher: NAME}}"
        wrong.append(Found("navigation-no-map", message, (), way_out, WARNING, key=True))
    if any(one.severity != WARNING for one in wrong):
        return made
    positions = robot.positions(pose) if pose is not None else {}
    _measure(robot, output, made, positions, frames)
    wrong += _sources(robot, output, made, positions, frames)
    return made


def _base(robot: Robot, base: str, frames: Frames) -> Iterator[Found]:
    path = ("base_frame",)
    if base not in robot.link:
        yield Found("nav2-base", f'there is no frame "{base}" on the robot', path, did_you_mean(base, robot.frames))
    elif robot.moves_between(base, frames.moved):
        message = f'"{base}" moves against "{frames.moved}", which the odometry moves'
        yield Found("nav2-base", message, path, "name a frame that is fixed to it")


def _owners(robot: Robot, frames: Frames) -> Iterator[Found]:
    """Yield edges of AMCL and slam_toolbox that these do not publish."""
    for publisher in robot.publishers:
        if kind_of(publisher) in (AMCL, SLAM):
            for lead in frames.owned(publisher):
                if lead.child != frames.odom or lead.parent != frames.map:
                    message = f'"{publisher.name}" is to publish {lead}, and it publishes map -> {frames.odom} alone'
                    way_out = f"{{parent: {frames.map or 'map'}, child: {frames.odom}, publisher: {publisher.name}}}"
                    yield Found("navigation-owner", message, lead.path, way_out, absolute=True)


def _clouds(robot: Robot) -> Clouds:
    """Return what says where the vertices of meshes are; of those that were looked for in vain nobody does."""
    read = clouds_of(robot)

    def cloud(mesh: Mesh) -> Cloud | None:
        return None if mesh.file in robot.missing_meshes else read(mesh)

    return cloud


def _measure(robot: Robot, output: Output, made: Known, positions: Mapping[str, float], frames: Frames) -> None:
    """Measure the robot: its footprint, and how high it reaches; what is unusual is said."""
    corners, clouds = int(output.options.get("corners", CORNERS)), _clouds(robot)
    outline = footprint(robot, made.base, positions, corners, clouds)
    _, unknown = solids(robot, made.base, positions, clouds) if outline is None else ([], outline.meshes)
    if outline is None or unknown:
        left = "footprint and heights are left out"
        message, way_out = f"no link of the robot has a collision shape: {left}", "give its links collision shapes"
        if unknown:
            files = dict.fromkeys(
                shape.geometry.file
                for name in unknown
                for shape in robot.link[name].collision
                if isinstance(shape.geometry, Mesh)
            )
            message = f"nobody knows how large {listed(files, 3)} is ({listed(unknown, 3)}): {left}"
            way_out = "give these links a box or a cylinder, or a mesh that is found: a binary STL or an OBJ"
        made.wrong.append(Found("nav2-footprint", message, (), way_out, WARNING, key=True))
        return
    padding = float(output.options.get("padding", _PADDING))
    if outline.inscribed <= 0 and output.options.get("outline") != "circle":
        message = f'the base frame "{made.base}" is not within the footprint, which Nav2 takes for granted'
        made.wrong.append(
            Found("nav2-footprint", message, ("base_frame",), "name a frame in the middle: base_frame", WARNING)
        )
    if not outline.holds(padded(outline.corners, padding)):
        grown = footprint(robot, made.base, positions, corners, clouds, padding)
        assert grown is not None  # noqa: S101 - it has shapes
        outline = grown._replace(lowest=outline.lowest, highest=outline.highest)
        made.remarks.append("The padding is in the footprint: Nav2's own would move a corner inwards.")
    made.outline = outline
    up = robot.transform(frames.moved, made.base, positions).xyz[2]
    made.floor, made.top = min(0.0, outline.lowest + up), outline.highest + up


def _sources(
    robot: Robot, output: Output, made: Known, positions: Mapping[str, float], frames: Frames
) -> Iterator[Found]:
    """Yield what is wrong with the observation sources."""
    sensors = {sensor.name: sensor for sensor in robot.sensors}
    band = heights(robot, output, made, positions)
    for name, source in (output.options.get("sources") or {}).items():
        sensor, path = sensors.get(source["sensor"]), ("sources", name, "sensor")
        if sensor is None:
            way_out = did_you_mean(source["sensor"], sensors) or "the robot has no sensors"
            yield Found("nav2-source", f'there is no sensor "{source["sensor"]}"', path, way_out)
            continue
        if sensor.type not in _SEES:
            message = f'sensor "{sensor.name}" is {_article(sensor.type)}, which sees no obstacles for a costmap'
            yield Found("nav2-source", message, path, f"name one of type {listed(sorted(_SEES))}")
        elif not _topic(robot, source):
            message = f'nobody says which topic sensor "{sensor.name}" is on'
            yield Found("nav2-source", message, path, "add topic: NAME")
        above = robot.transform(frames.moved, sensor.frame, positions).xyz[2]
        if band is not None and sensor.type == "lidar_2d" and above <= band[0]:
            message = (
                f'lidar "{sensor.name}" sees nothing: it is {above - made.floor:.3g} m above the floor,'
                f" and what is lower than {output.options.get('clearance', 0.0):.3g} m is no obstacle"
            )
            at = ("clearance",) if "clearance" in output.options else path
            yield Found("nav2-source", message, at, "make clearance less")


def _article(word: str) -> str:
    return f"{'an' if word[0] in 'aeiou' else 'a'} {word}"


def _topic(robot: Robot, source: Mapping[str, Any]) -> str:
    return str(source.get("topic") or stated_topic(robot, source["sensor"]))


def heights(robot: Robot, output: Output, made: Known, positions: Mapping[str, float]) -> tuple[float, float] | None:
    """Return between which heights (m) something is an obstacle; None where nobody knows how high the robot is.

    A lidar of one plane sees at its own height: that is within, also where nothing of the robot is as high.
    """
    if made.outline is None or made.frames is None:
        return None
    planes = [
        robot.transform(made.frames.moved, sensor.frame, positions).xyz[2]
        for sensor in robot.sensors
        if sensor.type == "lidar_2d" and sensor.frame in robot.link
    ]
    low = made.floor + float(output.options.get("clearance", 0.0))
    high = max([made.top, *planes]) + float(output.options.get("headroom", _HEADROOM))
    return math.floor(low * _MILLIMETRES + 0.5) / _MILLIMETRES + 0.0, math.ceil(high * _MILLIMETRES) / _MILLIMETRES


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield what is wrong with an entry."""
    yield from told(case, output, known(case.robot, output).wrong)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the parameters of a robot for Nav2. The options are in the record."""
    made = known(robot, output)
    wrong = [one for one in made.wrong if one.severity != WARNING]
    if made.frames is None or wrong:
        return "", [error(one.rule, one.message, None, one.help) for one in wrong]
    head = [
        f"Nav2 of {asked(output).capitalize()}: frames, footprint and heights of the robot.",
        "No tuning is in it: load it after your own.",
    ]
    if made.outline is not None:
        pose = output.options.get("pose")
        head.append(f"Footprint: {'all joints at zero' if pose is None else f'pose {pose}'}, in {made.base}.")
    head += made.remarks
    return text(robot, output, templates, head, list(_nodes(robot, output, made, made.frames))), []


def _nodes(robot: Robot, output: Output, made: Known, frames: Frames) -> Iterator[Node]:
    positions = robot.positions(output.options["pose"]) if "pose" in output.options else {}
    band = heights(robot, output, made, positions)
    costmaps = {LOCAL: frames.odom, **({GLOBAL: frames.map} if frames.map else {})}
    for name, frame in costmaps.items():
        values: dict[str, Any] = {"global_frame": frame, "robot_base_frame": made.base}
        values |= _outline(output, made)
        layer = (output.options.get("layers") or {}).get(name, _LAYERS[name])
        if band is not None:
            values |= {f"{layer}.min_obstacle_height": band[0], f"{layer}.max_obstacle_height": band[1]}
        yield Node(f"{name}/{name}", "costmap", values | dict(_seen(robot, output, layer, band)))
    if frames.map:
        values = {"global_frame": frames.map, "robot_base_frame": made.base}
        yield Node("bt_navigator", "bt_navigator", values)
    # In Humble the behaviours have one frame, that of the local costmap.
    local = {"global_frame": frames.odom} if asked(output) == "humble" else {"local_frame": frames.odom}
    far = {"global_frame": frames.map} if frames.map and "local_frame" in local else {}
    yield Node("behavior_server", "behavior_server", {**local, **far, "robot_base_frame": made.base})
    values = {"base_frame_id": made.base, "odom_frame_id": frames.odom}
    yield Node("collision_monitor", "collision_monitor", values)
    if frames.map:
        for publisher in robot.publishers:
            yield from _localisation(robot, output, frames, publisher)


def _outline(output: Output, made: Known) -> dict[str, Any]:
    """Return the keys of the footprint. A footprint wins over a radius, which is for where it cannot be read."""
    outline = made.outline
    if outline is None:
        return {}
    around = outline.circumscribed / math.cos(math.pi / _CIRCLE)
    circle = output.options.get("outline") == "circle"
    corners = "" if circle else ", ".join(f"[{x!r}, {y!r}]" for x, y in outline.corners)
    values: dict[str, Any] = {"footprint": f"[{corners}]", "robot_radius": math.ceil(around * 1e4) / 1e4}
    if made.remarks:
        values["footprint_padding"] = 0.0
    elif "padding" in output.options:
        values["footprint_padding"] = output.options["padding"]
    return values


def _seen(robot: Robot, output: Output, layer: str, band: tuple[float, float] | None) -> Iterator[tuple[str, Any]]:
    """Yield the keys of the observation sources of a layer."""
    sources = output.options.get("sources") or {}
    sensors: dict[str, Sensor] = {sensor.name: sensor for sensor in robot.sensors}
    if sources:
        yield f"{layer}.observation_sources", " ".join(sources)
    for name, source in sources.items():
        sensor, own = sensors[source["sensor"]], f"{layer}.{name}"
        yield f"{own}.topic", _topic(robot, source)
        yield f"{own}.data_type", _SEES[sensor.type]
        yield f"{own}.sensor_frame", sensor.optical_frame or sensor.frame
        if band is not None:
            yield f"{own}.min_obstacle_height", band[0]
            yield f"{own}.max_obstacle_height", band[1]


def _localisation(robot: Robot, output: Output, frames: Frames, publisher: Publisher) -> Iterator[Node]:
    """Yield AMCL or slam_toolbox: the frames, and whether it publishes map -> odom, as the edges say."""
    kind, owns, scan = kind_of(publisher), bool(frames.owned(publisher)), _scan(robot, output)
    if kind == AMCL:
        values: dict[str, Any] = {"global_frame_id": frames.map, "odom_frame_id": frames.odom}
        values |= {"base_frame_id": frames.moved, "tf_broadcast": owns}
        if robot.drive is not None:
            values["robot_model_type"] = _MOTION[robot.drive.slides]
        yield Node(publisher.name, kind, values | ({"scan_topic": scan} if scan else {}))
    elif kind == SLAM:
        values = {"map_frame": frames.map, "odom_frame": frames.odom, "base_frame": frames.moved}
        values |= {} if owns else {"transform_publish_period": 0.0}
        yield Node(publisher.name, kind, values | ({"scan_topic": scan} if scan else {}))


def _scan(robot: Robot, output: Output) -> str:
    """Return the topic of the only lidar of one plane, if the description says it; else nothing."""
    lidars = [sensor.name for sensor in robot.sensors if sensor.type == "lidar_2d"]
    sources: Sequence[Mapping[str, Any]] = list((output.options.get("sources") or {}).values())
    topics = {_topic(robot, source) for source in sources if source["sensor"] in lidars}
    topics |= {stated_topic(robot, lidars[0])} if len(lidars) == 1 and not topics else set()
    return topics.pop() if len(topics) == 1 else ""


def disagreements(robot: Robot, output: Output, written: str) -> Iterator[str]:
    """Yield where the robot reaches out of a footprint that an artifact has. Raises ValueError for a damaged one."""
    import yaml

    pose = output.options.get("pose")
    positions = robot.positions(pose) if pose is not None else {}
    for name, values in nodes_of(written).items():
        if "footprint" not in values or values.get("robot_base_frame") not in robot.link:
            continue
        points = yaml.safe_load(values["footprint"])
        if points:
            placed, _ = solids(robot, values["robot_base_frame"], positions, _clouds(robot))
            beyond, link = reaching_out(placed, [(x, y) for x, y in points])
            if beyond:
                yield f'"{link}" reaches {1000 * beyond:.3g} mm out of the footprint of {name}'

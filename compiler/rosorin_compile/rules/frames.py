"""Rules about frames: the conventions of REP 103 and REP 105, and sensors whose view the robot blocks."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from rosorin_compile.model import Link, Pose, Robot, Shape, Transform, Vector
from rosorin_compile.model.bounds import ball_of, through
from rosorin_compile.model.field_of_view import Data, seen_by
from rosorin_compile.model.geometry import unit
from rosorin_compile.model.shape import MERGED
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, NUMBERS, rule
from rosorin_compile.source.tree import Path

from .case import Case
from .joints import WORLD_FRAMES
from .magnitudes import FULL_TURN

# REP 103, "Suffix Frames": z forward, x right, y down, relative to a body frame with x forward, y left, z up.
OPTICAL = Pose(rpy=(-math.pi / 2, 0.0, -math.pi / 2)).transform()
SUFFIXES = ("_optical", "_optical_frame", "_optical_link")
TOLERANCE = 1e-3  # rad
CALIBRATION = 0.2  # rad; optical frames of one device may differ by the factory calibration


@rule("owns-world-frame", help="Make `base_link` the robot's root.", topic=FRAMES, accept="link", imported="always")
def world_frames(case: Case) -> Iterator[Diagnostic]:
    """The description defines `map`, `odom` or `earth`, which localisation publishes (REP 105); use `edges` instead."""
    robot = case.robot
    for frame in WORLD_FRAMES:
        ends = [case.end(one, end) for one in robot.joints for end in ("parent", "child") if getattr(one, end) == frame]
        at = case.link(frame) if frame in robot.link else next(iter(ends), None)
        if at is not None:
            who = "odometry or localisation (REP 105)"
            message = f'"{frame}" is a frame of the robot, but its transform comes from {who}'
            help = 'use another "frame" for the sensor' if at[0] == "sensors" else ""
            problem = case.problem("owns-world-frame", message, at, help, key=frame in robot.link and at[0] == "links")
            # Users can suppress this with ``accept`` only for a link.
            yield problem if frame in robot.link else replace(problem, of=())


@rule("optical-frame", help="Write `rpy: [-90 deg, 0, -90 deg]`.", topic=FRAMES, accept="link", imported="always")
def optical_frames(case: Case) -> Iterator[Diagnostic]:
    """The rotation of an optical frame is not that of REP 103: z forward out of the lens, x right, y down."""
    declared = {sensor.optical_frame for sensor in case.robot.sensors if sensor.optical_frame}
    steps = [(one.parent, one.child, one.origin, case.joint(one)) for one in case.robot.joints]
    for index, edge in enumerate(case.robot.edges):
        if edge.pose is not None and not edge.joint:
            steps.append((edge.parent, edge.child, edge.pose, ("edges", index)))
    for parent, child, pose, path in steps:
        is_image = child in declared or child.endswith(SUFFIXES)
        if not is_image or any(abs(angle) > FULL_TURN for angle in pose.rpy):  # another rule reports angles in degrees
            continue
        is_pair = parent in declared or parent.endswith(SUFFIXES)
        off = pose.transform().angle_to(Transform() if is_pair else OPTICAL)
        if off > (CALIBRATION if is_pair else TOLERANCE):
            at = case.value(path, "rpy")
            turned = ", ".join(f"{math.degrees(angle):.4g}" for angle in pose.rpy)
            right = "no rotation there" if is_pair else "[-90, 0, -90] deg: z forward, x right, y down"
            message = f'frame "{child}" is rotated by [{turned}] deg relative to "{parent}"; REP 103 requires {right}'
            help = 'remove "rpy", or attach the frame to a body frame' if is_pair else ""
            yield case.problem("optical-frame", message, at, help, key=at == path)


@rule("optical-mount", help="Remove `rpy`: the frame of a camera has x forward, y left, z up.", topic=FRAMES)
def optical_mounts(case: Case) -> Iterator[Diagnostic]:
    """A warning: a camera with a separate optical frame is mounted with the rotation of an optical frame."""
    for sensor in case.robot.sensors:
        mount = case.robot.joint_to.get(sensor.frame) if sensor.optical_frame not in ("", sensor.frame) else None
        if mount is not None and mount.origin.transform().angle_to(OPTICAL) <= TOLERANCE:
            place: Path = case.value(case.joint(mount), "rpy")
            message = f'the frame "{sensor.frame}" of {sensor.type} "{sensor.name}" is mounted with the rotation of an'
            message += f' optical frame, and its optical frame "{sensor.optical_frame}" is rotated once more'
            yield case.problem("optical-mount", message, place, key=place[-1] != "rpy")


AT_ONCE = 0.05  # m; only shapes within this distance count, because sensor hoods are not deeper
NEARLY_ALL = 0.9  # minimum fraction of blocked rays; a few rays may pass an edge of the shape
ON_A_FACE = 1e-4  # m; tolerance for rounded poses: a sensor on the face of a shape is outside it
# Rays per lidar layer, lidar layers, and rays along each side of an image; more rays give the same result.
RAYS, LAYERS, ALONG = 72, 9, 5


@rule("sensor-sees-itself", help="Move the sensor.", topic=NUMBERS, accept="link or joint", imported="always")
def sight(case: Case) -> Iterator[Diagnostic]:
    """A warning: a shape of the robot close to the sensor blocks nearly all rays of a lidar or nearly all of an image.

    The sensor is inside or close to a shape of another link that is fixed relative to it. Meshes are not checked, nor
    is the housing: the link of the sensor, and links that carry only the sensor.
    """
    robot = case.robot
    for sensor in robot.sensors if robot.is_tree else ():
        views = [view for view in seen_by(sensor) if view["kind"] in ("fan", "frustum")]
        if not views or sensor.frame not in robot.link:
            continue
        places, queue, housing = {sensor.frame: Transform()}, [sensor.frame], _housing(robot, sensor.frame)
        for here in queue:  # links that are fixed relative to the sensor
            for name, step in robot.fixed_neighbours(here):
                if name not in places:
                    places[name] = places[here].then(step)
                    queue.append(name)
        shapes = [one for one in case.shapes() if one[0].name in places and one[0].name not in housing]
        ends = [end for view in views if view["frame"] in places for end in _ends(view, places, shapes)]
        hits = [end for end in ends if end is not None]
        if hits and len(hits) >= NEARLY_ALL * len(ends):
            _, shape = min(hits, key=lambda hit: hit[0])
            away = 1000 * max(0.0, *(distance for distance, _ in hits))
            message = f'{100 * len(hits) // len(ends)} % of the rays of {sensor.type} "{sensor.name}" end on the robot'
            message += f" itself, at most {away:.3g} mm away"
            mount = robot.joint_to.get(sensor.frame)
            path = case.value(case.joint(mount) if mount else case.link(sensor.frame), "xyz")
            yield case.problem("sensor-sees-itself", message, path, related=[("the shape", shape)], within=True)


def _housing(robot: Robot, frame: str) -> set[str]:
    found = {frame, *(robot.subtree(frame) if frame in robot.joint_to else ())}
    top = robot.joint_to.get(frame)
    while top is not None and top.is_fixed and top.parent in robot.joint_to:
        for joint in robot.joints_from[top.parent]:
            links = [robot.link[name] for name in robot.subtree(joint.child)] if joint is not top else []
            if not joint.is_fixed or any(link.visual or link.collision for link in links):
                return found
        found.add(top.parent)
        top = robot.joint_to[top.parent]
    return found


def _ends(
    view: Data, places: Mapping[str, Transform], shapes: Iterable[tuple[Link, Path, Shape]]
) -> Iterator[tuple[float, Path] | None]:
    eye, near = places[view["frame"]].then(Pose(tuple(view["xyz"]), tuple(view["rpy"])).transform()), []
    for link, path, shape in shapes:
        for solid in shape.solids(MERGED):
            ball, place = ball_of(solid), places[link.name]
            if ball is not None and math.dist(place.apply(ball.middle), eye.xyz) <= ball.radius + AT_ONCE:
                to_solid = place.then(solid.origin().transform()).inverse()
                near.append((path, solid.geometry, to_solid, to_solid.apply(eye.xyz)))
    for direction in map(eye.rotate, _directions(view)):
        hits = []
        for path, geometry, to_solid, start in near:
            enters, leaves = through(geometry, start, to_solid.rotate(direction)) or (0.0, 0.0)
            if leaves > ON_A_FACE and enters <= AT_ONCE:
                hits.append((leaves if enters < -ON_A_FACE else enters, path))
        yield min(hits, key=lambda hit: hit[0], default=None)


def _directions(view: Data) -> list[Vector]:
    if view["kind"] == "frustum":
        wide, tall = math.tan(view["hfov"] / 2), math.tan(view["vfov"] / 2)
        steps = [2 * index / (ALONG - 1) - 1 for index in range(ALONG)]
        return [unit((wide * x, tall * y, 1.0)) for x in steps for y in steps]
    count, layers = view["count"], view["layers"]
    turns = [view["first"] + view["step"] * index for index in range(0, count, max(1, count // RAYS))]
    rises = layers[:: max(1, len(layers) // LAYERS)]
    return [(math.cos(u) * math.cos(v), math.sin(u) * math.cos(v), math.sin(v)) for v in rises for u in turns]

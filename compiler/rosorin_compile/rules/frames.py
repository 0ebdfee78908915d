"""Frames and views: the conventions of REP 103 and REP 105, and sensors whose view the robot itself blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint, Pose, Robot, Sensor, Shape, Transform, Vector
from rosorin_compile.model.bounds import ball_of, through
from rosorin_compile.model.field_of_view import Data, seen_by
from rosorin_compile.model.geometry import unit
from rosorin_compile.model.shape import MERGED
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, NUMBERS, rule
from rosorin_compile.source.tree import Path

from .case import Case
from .kinematics import WORLD_FRAMES
from .magnitudes import FULL_TURN

# REP 103, "Suffix Frames": z forward, x right, y down, seen from a body frame with x forward, y left, z up.
OPTICAL = Pose(rpy=(-math.pi / 2, 0.0, -math.pi / 2)).transform()
SUFFIXES = ("_optical", "_optical_frame", "_optical_link")
TOLERANCE = 1e-3  # rad
CALIBRATION = 0.2  # rad; the image frames of one device differ by what the maker calibrated, never by much


@rule("owns-world-frame", help="Begin the robot at `base_link`.", topic=FRAMES, accept="link", imported="always")
def world_frames(case: Case) -> Iterator[Diagnostic]:
    """The description owns `map`, `odom` or `earth`, which localisation places (REP 105); `edges` may name them."""
    robot = case.robot
    for frame in WORLD_FRAMES:
        ends = [
            case.end(joint, end)
            for joint in robot.joints
            for end in ("parent", "child")
            if getattr(joint, end) == frame
        ]
        at = case.link(frame) if frame in robot.link else next(iter(ends), None)
        if at is not None:
            message = f'the description owns the frame "{frame}", which localisation places (REP 105)'
            help = f'begin the robot at "base_link" and name the publisher of "{frame}" under edges'
            key = frame in robot.link and at[0] == "links"
            problem = case.problem("owns-world-frame", message, at, help, key=key)
            # Without a link of that name there is nothing that could be accepted.
            yield problem if frame in robot.link else replace(problem, of=())


@rule("optical-frame", help="Write `rpy: [-90 deg, 0, -90 deg]`.", topic=FRAMES, accept="link", imported="always")
def optical_frames(case: Case) -> Iterator[Diagnostic]:
    """An image frame is not turned as REP 103 says: z out of the lens, x right, y down."""
    robot = case.robot
    declared = {sensor.optical_frame for sensor in robot.sensors if sensor.optical_frame}
    steps = [(one.parent, one.child, one.origin, case.joint(one)) for one in robot.joints]
    steps += [
        (edge.parent, edge.child, edge.pose, ("edges", index))
        for index, edge in enumerate(robot.edges)
        if edge.pose is not None and not edge.joint
    ]
    for parent, child, pose, path in steps:
        is_image = child in declared or child.endswith(SUFFIXES)
        if not is_image or any(abs(angle) > FULL_TURN for angle in pose.rpy):  # degrees have a rule of their own
            continue
        at = case.value(path, "rpy")
        is_pair = parent in declared or parent.endswith(SUFFIXES)
        off = pose.transform().angle_to(Transform() if is_pair else OPTICAL)
        turned = "[" + ", ".join(f"{math.degrees(angle):.4g}" for angle in pose.rpy) + "] deg"
        message = f'image frame "{child}" is turned by rpy {turned} against '
        if is_pair and off > CALIBRATION:
            message += f'the image frame "{parent}"'
            help = "the axes of two image frames agree (REP 103); leave rpy out, or let its parent be a body frame"
            yield case.problem("optical-frame", message, at, help, key=at == path)
        elif not is_pair and off > TOLERANCE:
            message += f'"{parent}"; REP 103 requires [-90, 0, -90] deg (z out of the lens, x right, y down)'
            help = "write rpy: [-90 deg, 0, -90 deg]; a camera that is tilted has a body frame for that, x forward"
            yield case.problem("optical-frame", message, at, help, key=at == path)


@rule("optical-mount", help="Leave `rpy` out: the frame of a camera has x forward, y left, z up.", topic=FRAMES)
def optical_mounts(case: Case) -> Iterator[Diagnostic]:
    """A warning: a camera with an optical frame is itself mounted with the rotation of an optical frame."""
    for sensor in case.robot.sensors:
        mount = case.robot.joint_to.get(sensor.frame)
        if not sensor.optical_frame or sensor.optical_frame == sensor.frame or mount is None:
            continue
        if mount.origin.transform().angle_to(OPTICAL) <= TOLERANCE:
            place: Path = case.value(case.joint(mount), "rpy")
            message = f'the frame "{sensor.frame}" of {sensor.type} "{sensor.name}" is mounted with the rotation of an'
            message += f' optical frame, and its optical frame "{sensor.optical_frame}" is turned again'
            yield case.problem("optical-mount", message, place, key=place[-1] != "rpy")


# --- views that the robot blocks ---

AT_ONCE = 0.05  # m; what is nearer is right in front of a sensor: no housing of a robot has a larger hood
NEARLY_ALL = 0.9  # of the rays: the others look past an edge
ON_A_FACE = 1e-4  # m; a sensor on a face is not inside, in spite of the rounding of poses
# So many rays of a layer, so many layers and so many along each side of an image are examined: more see the same.
RAYS, LAYERS, ALONG = 72, 9, 5


class _End(NamedTuple):
    """Where a ray ends: how far away (m), on the shape of which link and path, and whether it began inside."""

    away: float
    link: str
    path: Path
    inside: bool


@rule(
    "sensor-sees-itself", help="Move it, or make room for it.", topic=NUMBERS, accept="link or joint", imported="always"
)
def sight(case: Case) -> Iterator[Diagnostic]:
    """A warning: nearly all rays of a lidar, or nearly all of an image, end on the robot itself at once.

    The sensor is inside a shape of another link that never moves against it, or close in front of one. Its housing,
    which is its own link and links that carry nothing else, does not count; meshes are not examined.
    """
    for sensor in case.robot.sensors if case.robot.is_tree else ():
        views = [view for view in seen_by(sensor) if view["kind"] in ("fan", "frustum")]
        if views and sensor.frame in case.robot.link:
            places = _rigid_neighbours(case.robot, sensor.frame)
            housing = _housing(case.robot, sensor.frame)
            solids = [
                (shape, place, name, case.link(name, purpose, index))
                for name, place in places.items()
                if name not in housing
                for purpose in ("collision", "visual")
                for index, shape in enumerate(getattr(case.robot.link[name], purpose))
            ]
            ends = [end for view in views if view["frame"] in places for end in _ends(view, places, solids)]
            hits = [end for end in ends if end is not None]
            if hits and len(hits) >= NEARLY_ALL * len(ends):
                yield _blocked(case, sensor, hits, len(ends))


def _rigid_neighbours(robot: Robot, frame: str) -> dict[str, Transform]:
    """Return the links that never move against a frame, and where they are in it."""
    found = {frame: Transform()}
    queue = [frame]
    for here in queue:
        for name, step in robot.fixed_neighbours(here):
            if name not in found:
                found[name] = found[here].then(step)
                queue.append(name)
    return found


def _housing(robot: Robot, frame: str) -> set[str]:
    """Return the links that carry a sensor and nothing else, and those attached to its own; of a root that alone."""
    found = {frame, *(robot.below(frame) if frame in robot.joint_to else ())}
    top = robot.joint_to.get(frame)
    while top is not None and top.is_fixed and top.parent in robot.joint_to:
        if not all(_is_bare(robot, joint) for joint in robot.joints_from[top.parent] if joint is not top):
            break
        found.add(top.parent)
        top = robot.joint_to[top.parent]
    return found


def _is_bare(robot: Robot, joint: Joint) -> bool:
    """Return True if a joint leads to frames without shapes."""
    links = (robot.link[name] for name in robot.below(joint.child))
    return joint.is_fixed and not any(link.visual or link.collision for link in links)


def _ends(
    view: Data, places: Mapping[str, Transform], solids: Sequence[tuple[Shape, Transform, str, Path]]
) -> Iterator[_End | None]:
    """Yield where the rays of a view end, None for each that leads away from the robot."""
    eye = places[view["frame"]].then(Pose(tuple(view["xyz"]), tuple(view["rpy"])).transform())
    near = [
        (piece, place, link, path)
        for shape, place, link, path in solids
        if _is_near(shape, place, eye.xyz)
        for piece in shape.solids(MERGED)
        if _is_near(piece, place, eye.xyz)
    ]
    for direction in map(eye.rotate, _directions(view)):
        hits = []
        for piece, place, link, path in near:
            way = through(piece, place, eye.xyz, direction)
            if way is not None and way.leaves > ON_A_FACE and way.enters <= AT_ONCE:
                inside = way.enters < -ON_A_FACE
                hits.append(_End(way.leaves if inside else max(way.enters, 0.0), link, path, inside))
        yield min(hits, key=lambda end: end.away, default=None)


def _is_near(shape: Shape, place: Transform, eye: Vector) -> bool:
    ball = ball_of(shape)
    return ball is not None and math.dist(place.apply(ball.middle), eye) <= ball.radius + AT_ONCE


def _directions(view: Data) -> list[Vector]:
    """Return rays of a view in its own axes: those of a fan around z, those of an image along z."""
    if view["kind"] == "frustum":
        wide, tall = math.tan(view["hfov"] / 2), math.tan(view["vfov"] / 2)
        steps = [2 * index / (ALONG - 1) - 1 for index in range(ALONG)]
        return [unit((wide * x, tall * y, 1.0)) for x in steps for y in steps]
    count, layers = view["count"], view["layers"]
    turns = [view["first"] + view["step"] * index for index in range(0, count, max(1, count // RAYS))]
    rises = layers[:: max(1, len(layers) // LAYERS)]
    return [(math.cos(u) * math.cos(v), math.sin(u) * math.cos(v), math.sin(v)) for v in rises for u in turns]


def _blocked(case: Case, sensor: Sensor, hits: Sequence[_End], rays: int) -> Diagnostic:
    near, far = (f"{1000 * of(end.away for end in hits):.3g}" for of in (min, max))
    share = "all" if len(hits) == rays else f"{100 * len(hits) // rays} % of"
    inside = next((end for end in hits if end.inside), None)
    solid = inside or max(hits, key=lambda end: sum(other.path == end.path for other in hits))
    message = f'{share} rays of {sensor.type} "{sensor.name}" end on the robot itself, '
    message += f"{near if near == far else f'{near} to {far}'} mm away"
    message += f': it is inside a shape of "{solid.link}"' if inside else f', on "{solid.link}"'
    help = f'put "{sensor.frame}" where it looks out, or leave room around it in the shape'
    mount = case.robot.joint_to.get(sensor.frame)
    path = case.value(case.joint(mount) if mount else case.link(sensor.frame), "xyz")
    return case.problem("sensor-sees-itself", message, path, help, related=[("the shape", solid.path)], within=True)

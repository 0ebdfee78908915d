"""Sight: sensors that measure distances or make images, and see nothing but the robot that carries them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import Joint, Pose, Robot, Sensor, Shape, Transform, Vector
from rosorin_compile.model.bounds import ball_of
from rosorin_compile.model.field_of_view import Data, seen_by
from rosorin_compile.model.geometry import unit
from rosorin_compile.model.rays import through
from rosorin_compile.model.shape import MERGED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path, exists

from .case import Case

# What is nearer is in front of a sensor at once: no housing that a robot carries has a larger hood (m).
AT_ONCE = 0.05
# Of the rays: the others are those that look past an edge.
NEARLY_ALL = 0.9
# A sensor on a face is not inside, whatever the rounding of poses made of it (m).
ON_A_FACE = 1e-4
# So many rays of a layer, so many layers and so many along each side of an image are asked: more see the same.
RAYS, LAYERS, ALONG = 72, 9, 5


@rule(
    "sensor-sees-itself",
    "A warning: nearly all rays of a lidar, or nearly all of an image, end on the robot itself at once: the sensor sits"
    " inside a shape of another link that never moves against it, or close in front of one. What a sensor is housed in"
    " does not count: its own link, and links that carry nothing else. Meshes are not looked into.",
    "Put the sensor where it looks out, or make the shape leave room around it, such as `bottom` of a height map.",
    NUMBERS,
    accept="link or joint",
    imported="always",
)
def sight(case: Case) -> Iterator[Diagnostic]:
    """Sensors whose view is blocked by the robot, whatever its joints do."""
    for sensor in case.robot.sensors if case.robot.is_tree else ():
        views = [view for view in seen_by(sensor) if view["kind"] in ("fan", "frustum")]
        if not views or sensor.frame not in case.robot.link:
            continue
        places = _held(case.robot, sensor.frame)
        solids = _around(case, places, _housing(case.robot, sensor.frame))
        ends = [end for view in views for end in _ends(view, places, solids)]
        met = [end for end in ends if end is not None]
        if met and len(met) >= NEARLY_ALL * len(ends):
            yield _blocked(case, sensor, met, len(ends))


class _Solid(NamedTuple):
    """A solid that never moves against a sensor: where its link is, seen from the frame of the sensor, and its path."""

    shape: Shape
    place: Transform
    link: str
    path: Path


class _End(NamedTuple):
    """Where a ray ends: how far away (m), on what, and whether it began inside of that."""

    away: float
    solid: _Solid
    inside: bool


def _around(case: Case, places: Mapping[str, Transform], housing: Collection[str]) -> list[_Solid]:
    """Return the shapes of what never moves against a sensor, without what houses it."""
    found = []
    for name, place in places.items():
        link = case.robot.link[name]
        for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
            if name not in housing:
                found += [_Solid(one, place, name, case.link(name, purpose, i)) for i, one in enumerate(shapes)]
    return found


def _held(robot: Robot, frame: str) -> dict[str, Transform]:
    """Return the links that never move against a frame, and where they are in it."""
    found = {frame: Transform()}
    ways = [frame]
    while ways:
        here = ways.pop()
        for name, step in robot.fixed_neighbours(here):
            if name not in found:
                found[name] = found[here].then(step)
                ways.append(name)
    return found


def _housing(robot: Robot, frame: str) -> set[str]:
    """Return the links that carry a sensor and nothing else, and what hangs on its own; of a root that one alone."""
    found = {frame}
    if frame in robot.joint_to:
        found.update(robot.below(frame))
    top = robot.joint_to.get(frame)
    while top is not None and top.is_fixed and top.parent in robot.joint_to:
        beside = (joint for joint in robot.joints_from[top.parent] if joint is not top)
        if not all(_is_bare(robot, joint) for joint in beside):
            break
        found.add(top.parent)
        top = robot.joint_to[top.parent]
    return found


def _is_bare(robot: Robot, joint: Joint) -> bool:
    """Say whether a joint leads to frames alone."""
    links = (robot.link[name] for name in robot.below(joint.child))
    return joint.is_fixed and not any(link.visual or link.collision for link in links)


def _ends(view: Data, places: Mapping[str, Transform], solids: Sequence[_Solid]) -> list[_End | None]:
    """Return where the rays of a view end; None for each that leads away from the robot."""
    if view["frame"] not in places:
        return []
    eye = places[view["frame"]].then(Pose(tuple(view["xyz"]), tuple(view["rpy"])).transform())
    near = [piece for solid in solids for piece in _near(solid, eye.xyz)]
    return [_end(near, eye.xyz, eye.rotate(direction)) for direction in _directions(view)]


def _near(solid: _Solid, eye: Vector) -> Iterator[_Solid]:
    """Yield the pieces of a solid that are near enough to end a ray at once."""
    for piece in solid.shape.solids(MERGED) if _is_near(solid.shape, solid.place, eye) else ():
        if _is_near(piece, solid.place, eye):
            yield solid._replace(shape=piece)


def _is_near(shape: Shape, place: Transform, eye: Vector) -> bool:
    ball = ball_of(shape)
    return ball is not None and math.dist(place.apply(ball.middle), eye) <= ball.radius + AT_ONCE


def _end(near: Sequence[_Solid], eye: Vector, direction: Vector) -> _End | None:
    first: _End | None = None
    for solid in near:
        way = through(solid.shape, solid.place, eye, direction)
        if way is None or way.leaves <= ON_A_FACE or way.enters > AT_ONCE:
            continue
        inside = way.enters < -ON_A_FACE
        away = way.leaves if inside else max(way.enters, 0.0)
        if first is None or away < first.away:
            first = _End(away, solid, inside)
    return first


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


def _blocked(case: Case, sensor: Sensor, met: Sequence[_End], rays: int) -> Diagnostic:
    near, far = (f"{1000 * of(end.away for end in met):.3g}" for of in (min, max))
    away = f"{near} mm" if near == far else f"{near} to {far} mm"
    share = "all" if len(met) == rays else f"{100 * len(met) // rays} % of"
    most = max(met, key=lambda end: sum(other.solid.path == end.solid.path for other in met)).solid
    inside = next((end.solid for end in met if end.inside), None)
    where = f': it sits inside a shape of "{inside.link}"' if inside else f', on "{most.link}"'
    message = f'{share} rays of {sensor.type} "{sensor.name}" end on the robot itself, {away} away{where}'
    solid = inside or most
    help = f'put "{sensor.frame}" where it looks out, or leave room around it in the shape'
    path = (
        case.joint(case.robot.joint_to[sensor.frame])
        if sensor.frame in case.robot.joint_to
        else case.link(sensor.frame)
    )
    path = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
    related = [case.related("the shape", solid.path)]
    return case.problem("sensor-sees-itself", message, path, help, related=related, severity=WARNING, within=True)

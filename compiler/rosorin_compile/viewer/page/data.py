"""Convert a robot to the JSON data of its page (``schemas/page.schema.json``).

A URDF is not sufficient, because it lacks the frames of other ROS nodes and the fields of view of sensors.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rosorin_compile import model
from rosorin_compile.formats.format import describe
from rosorin_compile.model import Joint, Link, Pose, Robot, Sensor, Shape
from rosorin_compile.model.colours import default_colours
from rosorin_compile.model.field_of_view import numbers, page_pose, seen_by
from rosorin_compile.model.frame_tree import Row, publishers
from rosorin_compile.model.joint import MOVING_TYPES

from ..frames import FrameSituation, TooMany, colours, frame_trees
from .images import Data, texture_names

_PURPOSES = ("visual", "collision")
_GEOMETRIES: Mapping[type, tuple[str, Callable[[Any], Data]]] = {
    model.Box: ("box", lambda box: {"size": numbers(box.size)}),
    model.Cylinder: ("cylinder", lambda tube: {"radius": tube.radius, "length": tube.length}),
    model.Capsule: ("capsule", lambda tube: {"radius": tube.radius, "length": tube.length}),
    model.Ellipsoid: ("ellipsoid", lambda ellipsoid: {"radii": numbers(ellipsoid.radii)}),
    model.Sphere: ("sphere", lambda sphere: {"radius": sphere.radius}),
    model.Mesh: ("mesh", lambda mesh: {"mesh": mesh.file, "scale": numbers(mesh.scale)}),
    model.HeightMap: ("height_map", lambda grid: {"origin": [*grid.origin], "cell": grid.cell, "heights": _rows(grid)}),
}


def _rows(grid: model.HeightMap) -> list[list[float]]:
    return [numbers(row) for row in grid.heights]


def robot_data(robot: Robot) -> Data:
    """Convert a robot to JSON data for an HTML page (m, rad, kg), without the contents of meshes and textures."""
    return {
        "name": robot.name,
        "root": robot.root,
        "links": [_link(robot, link) for link in robot.links],
        "joints": [_joint(robot, joint) for joint in robot.joints],
        "sensors": [_sensor(sensor) for sensor in robot.sensors],
        "poses": [
            {"name": one.name, "positions": dict(one.positions), "about": describe(one.source)} for one in robot.poses
        ],
        "modes": list(robot.modes),
        "publishers": dict(colours(publishers(robot.frame_tree()))),
        "situations": _situations(robot),
        "collision_only": not robot.has_looks,
        "meshes": {},
        **({"textures": {}} if any(texture_names(robot)) else {}),
    }


def before_data(robot: Robot, shapes: Mapping[tuple[str, str], Sequence[Shape]], at: Pose) -> Data:
    """Convert the previous version of a robot to JSON data, with only the shapes that the HTML page draws.

    The keys of ``shapes`` are (link, "visual" or "collision"); ``at`` is the pose of the old root in the new root.
    """
    return {
        "root": robot.root,
        "at": page_pose(at),
        "links": [
            {"name": one.name, **{key: _shapes(shapes.get((one.name, key), ())) for key in _PURPOSES}}
            for one in robot.links
        ],
        "joints": [_joint(robot, joint) for joint in robot.joints],
        "collision_only": not robot.has_looks,
        "meshes": {},
    }


def _link(robot: Robot, link: Link) -> Data:
    colour = "".join(f"{round(255 * part):02x}" for part in default_colours(robot)[link.name][:3])
    made: Data = {"name": link.name, "colour": f"#{colour}"}
    if (inertial := link.inertial) is not None:
        moments = {key: getattr(inertial, key) + 0.0 for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")}
        made["inertial"] = {"mass": inertial.mass, **page_pose(inertial.pose), **moments}
    made["visual"] = [_shape(one) | _colour(robot, one) for shape in link.visual for one in shape.drawn_shapes()]
    look = robot.look_of(link)
    instead = {} if look is None or robot.has_looks else {"rgba": list(look)}
    made["collision"] = [one | instead for one in _shapes(link.collision)]
    return made


def _shapes(shapes: Iterable[Shape]) -> list[Data]:
    return [_shape(one) for shape in shapes for one in shape.drawn_shapes()]


def _shape(shape: Shape) -> Data:
    name = {"name": shape.name} if shape.name else {}
    kind, values_of = _GEOMETRIES[type(shape.geometry)]
    return {**page_pose(shape.origin()), **name, "kind": kind, **values_of(shape.geometry)}


def _colour(robot: Robot, shape: Shape) -> Data:
    rgba, texture = robot.colour(shape), robot.texture(shape)
    shown = {} if rgba is None else {"rgba": [min(max(part, 0.0), 1.0) for part in rgba]}
    return shown | ({"texture": texture} if texture else {})


def _joint(robot: Robot, joint: Joint) -> Data:
    made: Data = {"name": joint.name, "type": joint.type, "parent": joint.parent, "child": joint.child}
    made |= page_pose(joint.origin)
    if joint.type in (*MOVING_TYPES, "planar"):
        made["axis"] = numbers(joint.axis)
    limits = {key: getattr(joint.limit, key, None) for key in ("lower", "upper")}
    if all(bound is not None and math.isfinite(bound) for bound in limits.values()):
        made["limit"] = limits
    if joint.mimic is not None:
        made["mimic"] = {key: getattr(joint.mimic, key) for key in ("joint", "multiplier", "offset")}
    for servo in [group for group in robot.servos if joint.name in group.joints][:1]:
        made["servo"] = {"rad_per_pulse": servo.rad_per_pulse, "zero": servo.zero_pulse}
        made["servo"] |= {"flipped": servo.flipped, "range": list(servo.pulse_range)}
    if describe(joint.source):
        made["source"] = describe(joint.source)
    return made


def _situations(robot: Robot) -> list[Data]:
    try:
        trees: Sequence[FrameSituation] = frame_trees(robot, {})
    except TooMany:
        trees = [FrameSituation("", ({},), rows=robot.frame_tree())]
    return [{"label": t.when, "modes": [*map(dict, t.modes)], "edges": [*map(_edge, t.rows)]} for t in trees]


def _edge(row: Row) -> Data:
    made: Data = {"parent": row.parent, "child": row.child, "publisher": row.publisher, "published": row.is_published}
    rest = {"topic": row.topic if row.is_published else "", "why": row.why, "joint": row.joint, "kind": row.kind}
    return made | {key: value for key, value in rest.items() if value}


def _sensor(sensor: Sensor) -> Data:
    made: Data = {"name": sensor.name, "type": sensor.type, "frame": sensor.frame}
    if sensor.optical_frame:
        made["optical_frame"] = sensor.optical_frame
    sees = seen_by(sensor)
    return made | ({"sees": sees} if sees else {})

"""Chains: how a frame hangs on the root, edge by edge, with the numbers of the way; then those of joints and links."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Geometry,
    HeightMap,
    Inertial,
    Joint,
    Link,
    Mesh,
    Pose,
    Publisher,
    Robot,
    Sphere,
)
from rosorin_compile.model import Edge as NodeEdge
from rosorin_compile.model import Transform as Rigid
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path

from ..schema import fragment_at, joint_unit, sections
from ..symbols import SymbolTable
from .explanation import Edge, Number, Placed, Shape, Transform
from .origins import Origins

_POSE = (("xyz", ("x", "y", "z"), "m"), ("rpy", ("roll", "pitch", "yaw"), "rad"))
_NOT_WRITTEN = "not written"
_OPTICAL = "not written: an optical frame is turned like this (REP 103)"

# What ``expand.parts`` says of a use of a part.
_USE = re.compile(r'part ".*?" used here as "(.*?)"')

Places = Mapping[tuple[str, str], Path]


class Frames:
    """The tree of frames of one robot: its joints, and the edges of other nodes."""

    def __init__(self, robot: Robot, places: Places, origins: Origins) -> None:
        self.robot = robot
        self.places = places
        self.origins = origins

    def names(self) -> list[str]:
        """Return all frames, those of other nodes included."""
        found = [link.name for link in self.robot.links]
        found += [name for edge in self.robot.edges for name in (edge.parent, edge.child)]
        return list(dict.fromkeys(found))

    def uses(self, frame: str) -> list[str]:
        """Return the uses of parts that a frame comes from, the outermost first: arm, arm_hand."""
        place = self.places.get(("link", frame))
        stack = self.origins.at(place)[1] if place is not None else ()
        names = [use[1] for step in reversed(stack) if (use := _USE.match(step.message))]
        return ["_".join(names[: count + 1]) for count in range(len(names))]

    def chain(self, frame: str) -> tuple[Edge, ...]:
        """Return the edges from the root to a frame; through those of other nodes where no joint leads on."""
        seen: set[str] = set()
        above: list[Edge] = []
        while frame not in self.robot.link and frame not in seen:
            seen.add(frame)
            steps = [self._of_node(index, edge) for index, edge in enumerate(self.robot.edges) if edge.child == frame]
            if not steps:
                return tuple(above)
            same = [step for step in steps if step.parent == steps[0].parent]
            above = [*same, *above]
            frame = steps[0].parent
        if frame not in self.robot.link:
            return tuple(above)
        return (*(self._of_joint(joint) for joint in self.robot.chain(frame)), *above)

    def others(self, frame: str) -> tuple[Edge, ...]:
        """Return the edges of other nodes that place a frame that has a place in the description already."""
        if frame not in self.robot.link:
            return ()
        return tuple(self._of_node(index, edge) for index, edge in enumerate(self.robot.edges) if edge.child == frame)

    def children(self, frame: str) -> tuple[str, ...]:
        """Return the frames that sit on a frame, those of other nodes last."""
        joints = [joint.child for joint in self.robot.joints_from.get(frame, ())]
        return tuple(dict.fromkeys([*joints, *(edge.child for edge in self.robot.edges if edge.parent == frame)]))

    def placed(self, frame: str, chain: Sequence[Edge], pose: str) -> Placed:
        """Return where a frame sits in the root of its chain, with the joints in a named pose ("": all at zero)."""
        positions = next((p.positions for p in self.robot.poses if p.name == pose), {})
        found: Rigid | None = Rigid()
        for edge in dict.fromkeys((edge.parent, edge.child) for edge in chain):
            step = self._step(edge, positions)
            found = None if step is None or found is None else found.then(step)
        root = chain[0].parent if chain else frame
        return Placed(pose, root, None if found is None else transform_of(found))

    def _step(self, edge: tuple[str, str], positions: Mapping[str, float]) -> Rigid | None:
        parent, child = edge
        joint = self.robot.joint_to.get(child)
        if joint is not None and joint.parent == parent:
            return joint.transform(self.robot.position(joint, positions))
        poses = [edge.pose for edge in self.robot.edges if (edge.parent, edge.child) == (parent, child)]
        return poses[0].transform() if poses[0] is not None and len(set(poses)) == 1 else None

    def _of_joint(self, joint: Joint) -> Edge:
        path = self.places["joint", joint.name]
        where, stack = self.origins.at(path)
        numbers = list(self.pose(path, joint.origin, optical=path[-1:] == ("optical",)))
        if path[0] in self.robot.sections.said:  # its numbers may be anything that the section makes of its own
            numbers = [number._replace(origin=None, note=f"of {path[0]}") for number in numbers]
        if joint.moves or joint.type == "planar":
            numbers += self.vector(path, "axis", joint.axis)
        topic = "" if joint.publisher.kind == UNPUBLISHED else "/tf" if joint.moves_on_tf else "/tf_static"
        transform = transform_of(joint.transform())
        words = "published in turns" if joint.name in self.robot.turns else publisher_words(joint.publisher)
        return Edge(
            joint.parent, joint.child, joint.name, joint.type, words, topic, "", transform, tuple(numbers), where, stack
        )

    def _of_node(self, index: int, edge: NodeEdge) -> Edge:
        path: Path = self.places["joint", edge.joint] if edge.joint else ("edges", index)
        where, stack = self.origins.at(path)
        topic = "/tf" if edge.moving else "/tf_static"
        transform = None if edge.pose is None else transform_of(edge.pose.transform())
        numbers = () if edge.pose is None else tuple(self.pose(path, edge.pose))
        words = publisher_words(edge.publisher)
        return Edge(edge.parent, edge.child, "", "", words, topic, edge.when, transform, numbers, where, stack)

    def pose(self, path: Path, pose: Pose, optical: bool = False) -> Iterator[Number]:
        """Yield the six numbers of the pose that stands in an entry."""
        for (key, names, unit), values in zip(_POSE, (pose.xyz, pose.rpy), strict=True):
            note = _OPTICAL if optical and key == "rpy" else _NOT_WRITTEN
            for index, (name, value) in enumerate(zip(names, values, strict=True)):
                origin = self.origins.of((*path, key, index))
                yield Number(name, value, unit, origin, "" if origin else note)

    def vector(self, path: Path, key: str, values: Sequence[float]) -> Iterator[Number]:
        """Yield the numbers of a list, named after their axes, such as "axis x"."""
        for index, (name, value) in enumerate(zip("xyz", values, strict=True)):
            origin = self.origins.of((*path, key, index))
            yield Number(f"{key} {name}", value, "", origin, "" if origin else _NOT_WRITTEN)

    def added(self, kind: str, name: str) -> Iterator[Number]:
        """Yield the numbers of the entries of sections of plug-ins that name something."""
        for section in self.robot.sections.said:
            named = [
                one.path for one in SymbolTable(self.origins.tree).references((kind,), section) if one.name == name
            ]
            for path in dict.fromkeys(path[:-1] for path in named):
                for number in self.numbers(path):
                    yield number._replace(name=f"{' '.join(map(str, path[:-1]))} {number.name}".strip())

    def numbers(self, path: Path, joint: Joint | None = None) -> Iterator[Number]:
        """Yield every number in a piece of the tree, named by the keys that lead to it; ``joint`` decides on units."""
        leader = self.robot.joint.get(joint.mimic.joint) if joint is not None and joint.mimic is not None else None
        slides, leads = (one is not None and one.type in ("prismatic", "planar") for one in (joint, leader))
        waiting: list[tuple[Path, object]] = [(path, _at(self.origins, path))]
        while waiting:
            here, value = waiting.pop(0)
            if isinstance(value, dict):
                waiting = [((*here, key), item) for key, item in value.items()] + waiting
            elif isinstance(value, list):
                waiting = [((*here, index), item) for index, item in enumerate(value)] + waiting
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                unit = joint_unit(here, slides, leads if leader is not None else None) or ""
                yield Number(_words(here[len(path) - 1 :]), float(value), unit, self.origins.of(here))


def _at(origins: Origins, path: Path) -> object:
    node: object = origins.tree
    for step in path:
        if isinstance(node, dict) and step in node:
            node = node[str(step)]
        elif isinstance(node, list) and isinstance(step, int) and step < len(node):
            node = node[step]
        else:
            return None
    return node


def _words(steps: Path) -> str:
    """Return keys as the name of a number: inertia ixx, xyz x, size[0]."""
    words = ""
    for step in steps:
        if isinstance(step, int):
            axes = {"xyz": "xyz", "rpy": ("roll", "pitch", "yaw")}.get(words.rpartition(" ")[2])
            words += f" {axes[step]}" if axes and step < 3 else f"[{step}]"
        else:
            words += f" {step}" if words else step
    return words


def transform_of(rigid: Rigid) -> Transform:
    """Return a transform with all that people ask of it."""
    rpy = _unsigned_zeros(rigid.rpy())
    w, x, y, z = rigid.quaternion()
    degrees = tuple(math.degrees(angle) for angle in rpy)
    return Transform(_unsigned_zeros(rigid.xyz), rpy, degrees, _unsigned_zeros((x, y, z, w)))


def _unsigned_zeros(values: Sequence[float]) -> tuple[float, ...]:
    return tuple(value + 0.0 for value in values)


def publisher_words(publisher: Publisher) -> str:
    """Return who publishes an edge, as one says it."""
    if publisher.simulated:
        return f"of simulations alone: {publisher.about}"
    if publisher.kind == UNPUBLISHED:
        return f"nobody publishes it: {publisher.about}" if publisher.about else "nobody publishes it"
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f"published by the static_transform_publisher {publisher.name}"
    about = f" ({publisher.about})" if publisher.kind == NODE and publisher.about else ""
    name = ROBOT_STATE_PUBLISHER if publisher.kind == ROBOT_STATE_PUBLISHER else publisher.name
    return f"published by {name}{about}"


_OF_JOINT = ("limit", "mimic", "dynamics", "actuator", "calibration", "safety_controller")
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def of_joint(frames: Frames, joint: Joint) -> Iterator[Number]:
    """Yield the limits of a joint, whom it follows, what a simulation knows of it, and what sections say of it."""
    path = frames.places["joint", joint.name]
    for key in () if path[0] in frames.robot.sections.said else _OF_JOINT:  # which has keys of its own
        yield from frames.numbers((*path, key), joint)
    for section, node in sections().items():
        if isinstance(node.explained, str):
            yield from _naming(frames, joint, section, node.explained)


def _naming(frames: Frames, joint: Joint, section: str, word: str) -> Iterator[Number]:
    """Yield the numbers of the entries of a section that name a joint, each behind a word."""
    named = {
        one.path[1]
        for one in SymbolTable(frames.origins.tree).references(("joint",), section)
        if one.name == joint.name
    }
    for name in sorted(map(str, named)):
        for key in fragment_at((section, "*"))["properties"]:
            for number in frames.numbers((section, name, key)):
                yield number._replace(name=f"{word} {number.name}")


def of_entry(frames: Frames, path: Path) -> Iterator[Number]:
    """Yield the numbers of an entry of a simulation section, each under the last part of its name."""
    for number in frames.numbers(path):
        yield number._replace(name=_short(number.name))


def of_mass(frames: Frames, link: Link) -> Iterator[Number]:
    """Yield the numbers of an inertial, those that were calculated from shapes too, and what sections add to it."""
    path = frames.places["link", link.name]
    as_said = frames.robot.as_said().link
    said = as_said[link.name].inertial if link.name in as_said else None
    if path[0] == "links" and said is not None:
        written = [number._replace(name=_short(number.name)) for number in frames.numbers((*path, "inertial"))]
        yield from written
        if not any(number.name == "inertia ixx" for number in written):
            note = "calculated from the shapes"
            known = {number.name for number in written}
            yield from (n for n in _calculated(said, note) if n.name not in known)
    if link.inertial is not None and link.inertial != said:
        yield from frames.added("link", link.name)
        yield Number("mass in all", link.inertial.mass, "kg", None, "with what is added to it")


def _calculated(inertial: Inertial, note: str) -> Iterator[Number]:
    yield Number("mass", inertial.mass, "kg", None, note)
    for name, value in zip("xyz", inertial.pose.xyz, strict=True):
        yield Number(f"xyz {name}", value, "m", None, note)
    for name, value in zip(("roll", "pitch", "yaw"), inertial.pose.rpy, strict=True):
        yield Number(f"rpy {name}", value, "rad", None, note)
    for name in _MOMENTS:
        yield Number(f"inertia {name}", getattr(inertial, name), "kg*m^2", None, note)


def of_shapes(frames: Frames, link: Link) -> Iterator[Shape]:
    """Yield the shapes of a link."""
    path = frames.places["link", link.name]
    for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
        for index, shape in enumerate(shapes):
            here: Path = (*path, purpose, index)
            where, _ = frames.origins.at(here)
            kind, words = _in_words(shape.geometry)
            if isinstance(shape.geometry, HeightMap):
                single = ("bottom",) if isinstance(shape.geometry.bottom, (int, float)) else ()
                keys = [(*here, "height_map", key) for key in ("origin", "cell", "step", *single)]
                numbers = [number for key in keys for number in frames.numbers(key)]
            else:
                numbers = [number._replace(name=_short(number.name)) for number in frames.numbers(here)]
            yield Shape(purpose, kind, words, tuple(numbers), where)


def _short(name: str) -> str:
    """Return the name of a number without that of the piece it stands in: "inertial mass" is "mass"."""
    return name.partition(" ")[2]


def _in_words(geometry: Geometry) -> tuple[str, str]:
    """Return the kind of a geometry, and its size in metres."""
    if isinstance(geometry, Box):
        return "box", " x ".join(exact(round(length, 12)) for length in geometry.size) + " m"
    if isinstance(geometry, (Cylinder, Capsule)):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        return kind, f"radius {exact(geometry.radius)} m, length {exact(geometry.length)} m"
    if isinstance(geometry, Sphere):
        return "sphere", f"radius {exact(geometry.radius)} m"
    if isinstance(geometry, Ellipsoid):
        return "ellipsoid", "radii " + " x ".join(map(exact, geometry.radii)) + " m"
    if isinstance(geometry, Mesh):
        return "mesh", geometry.file
    rows, columns = len(geometry.heights), len(geometry.heights[0])
    return "height map", f"{rows} x {columns} cells of {exact(geometry.cell)} m"

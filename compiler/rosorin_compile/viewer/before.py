"""The robot of committed artifacts, for a picture: the compiled robot with old values put back.

Where frames were, how joints moved and which shapes links had is read from the artifacts; all else is as compiled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from rosorin_compile.compare.describe import likened
from rosorin_compile.compare.names import links_of
from rosorin_compile.compare.pairs import Pair
from rosorin_compile.compare.solids import Solid, match, solid_of
from rosorin_compile.compare.walk import Address, Difference, Leaves, Shapes, compare_leaves
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HeightMap,
    Joint,
    Link,
    Mesh,
    Pose,
    Robot,
    Shape,
    Sphere,
    Transform,
)
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.joint import Mimic
from rosorin_compile.model.shape import MERGED, ROWS

_GRID = frozenset(field.name for field in fields(HeightMap))
# More solids than these are not compared with each other one by one.
_MANY = 50


def robot_before(robot: Robot, pairs: Sequence[Pair]) -> Robot:
    """Return the robot of the artifacts as they were; the robot itself if they describe no tree.

    What is new in one artifact, and was in another before, is not new.
    """
    known = {name for pair in pairs for name in links_of(pair.old)}
    work = _Before(robot, [pair.old for pair in pairs])
    done: set[Address] = set()
    for pair in sorted(pairs, key=lambda pair: -len(pair.old)):
        for one in compare_leaves(pair.old, pair.new, pair.precisions):
            kind, name, quantity = one.address
            is_fresh = one.old is None and not quantity and kind in ("frame", "link")
            if one.address not in done and not (is_fresh and name in known):
                done.add(one.address)
                work.apply(one, pair.old)
    return work.robot()


class _Before:
    def __init__(self, robot: Robot, sides: Sequence[Leaves]) -> None:
        self.start = robot
        self.links = {link.name: link for link in robot.links}
        self.joints = {joint.child: joint for joint in robot.joints}
        self.materials = {material.name: material for material in robot.materials}
        # Not every format has the names of all joints.
        self.names = {
            str(of["child"]): name
            for side in sides
            for (kind, name), of in side.items()
            if kind == "joint" and "child" in of
        }

    def robot(self) -> Robot:
        joints = [joint for child, joint in self.joints.items() if {child, joint.parent} <= self.links.keys()]
        materials = tuple(self.materials.values())
        made = replace(self.start, links=tuple(self.links.values()), joints=tuple(joints), materials=materials)
        return made if made.is_tree else self.start

    def apply(self, one: Difference, old: Leaves) -> None:
        """Put the old value of a difference back; what the model has no place for is passed over."""
        kind, name, quantity = one.address
        if not quantity and kind in ("frame", "link") and " " not in name:
            if one.old is None:
                self.joints.pop(name, None)
                self.links.pop(name, None)
            else:
                self._add(name, old)
        elif kind == "frame" and name in self.joints:
            joint = self.joints[name]
            if quantity == "parent" and one.old in self.links and one.old != name:
                self.joints[name] = replace(joint, parent=one.old)
            elif quantity == "origin" and isinstance(one.old, Pose):
                self.joints[name] = replace(joint, origin=one.old)
        elif kind == "joint":
            child = next((child for child, joint in self.joints.items() if joint.name == name), "")
            if child:
                self.joints[child] = _joint(self.joints[child], quantity, one.old, old.get(("joint", name), {}))
        elif kind == "material" and name in self.materials and quantity in ("rgba", "texture"):
            self.materials[name] = replace(self.materials[name], **{quantity: one.old})
        elif kind == "height map" and name in self.links and quantity in _GRID and one.old is not None:
            link = self.links[name]
            self.links[name] = replace(link, collision=tuple(_grid(s, quantity, one.old) for s in link.collision))
        elif kind == "link" and name in self.links and quantity in ("collision", "visual"):
            sides = [side.solids() if isinstance(side, Shapes) else [] for side in (one.old, one.new)]
            shapes = _shapes(getattr(self.links[name], quantity), *sides)
            self.links[name] = replace(self.links[name], **{quantity: shapes})  # type: ignore[arg-type]

    def _add(self, name: str, old: Leaves) -> None:
        """Add a link that is no more, with the joint that placed it."""
        if name not in self.links:
            entry = old.get(("link", name), {})
            shapes = {key: entry[key].shapes for key in ("collision", "visual") if key in entry}
            self.links[name] = Link(name, **shapes)
        frame = old.get(("frame", name), {})
        if name not in self.joints and isinstance(frame.get("origin"), Pose) and frame.get("parent"):
            joint = Joint(self.names.get(name, name), "fixed", frame["parent"], name, frame["origin"])
            for quantity, value in old.get(("joint", joint.name), {}).items():
                joint = _joint(joint, quantity, value, old.get(("joint", joint.name), {}))
            self.joints[name] = joint


def _joint(joint: Joint, quantity: str, value: Any, entry: Mapping[str, Any]) -> Joint:
    if not quantity:  # one that an artifact names only where it moves
        return replace(joint, type="fixed" if value is None else value.get("type", "fixed"))
    if quantity == "type":
        return replace(joint, type=value or "fixed")
    if quantity == "axis" and value is not None and any(value):
        return replace(joint, axis=value)
    if quantity.startswith("mimic "):
        leader = entry.get("mimic joint")
        parts = entry.get("mimic multiplier", 1.0), entry.get("mimic offset", 0.0)
        return replace(joint, mimic=Mimic(leader, *parts) if leader else None)
    return joint


def _grid(shape: Shape, quantity: str, value: Any) -> Shape:
    if not isinstance(shape.geometry, HeightMap):
        return shape
    return replace(shape, geometry=replace(shape.geometry, **{quantity: value}))


def _shapes(now: Sequence[Shape], old: Sequence[Solid], new: Sequence[Solid]) -> tuple[Shape, ...]:
    """Return the shapes of a link as they were; those of other frames, which an artifact may have there, are not."""
    old, new = [*map(_plain, old)], [*map(_plain, new)]
    rest = match(old, new)
    removed, added = [old[at] for at in rest.old], [new[at] for at in rest.new]
    pieces, own = max((_own(now, added, form) for form in (ROWS, MERGED)), key=lambda found: len(found[1]))
    if removed and added and not own:
        return tuple(now)  # they are of another frame, which has a difference of its own
    became = {at: was for was, at in likened(removed, added)} if len(added) <= _MANY else {}
    cut = {id(pieces[index][0]) for index in own}
    kept: list[Shape] = []
    for index, (shape, piece) in enumerate(pieces):
        if id(shape) not in cut:
            kept += [] if kept and kept[-1] is shape else [shape]
        elif index not in own:
            kept.append(piece)
        elif own[index] in became:
            kept.append(_placed(piece, removed[became[own[index]]]))
    return (*kept, *(_shape_of(solid) for at, solid in enumerate(removed) if at not in became.values()))


def _shape_of(solid: Solid) -> Shape:
    """Return a solid as a shape of the model."""
    place = pose_of(Transform(solid.rows, solid.centre))
    half = tuple(size / 2 for size in solid.sizes)
    file = next((word.removeprefix("file ") for word in solid.words if word.startswith("file ")), "")
    geometry: Box | Cylinder | Capsule | Sphere | Ellipsoid | Mesh
    if solid.kind == "box":
        geometry = Box(tuple(-x for x in half), half)  # type: ignore[arg-type]
    elif solid.kind == "mesh":
        geometry = Mesh(file, solid.sizes)  # type: ignore[arg-type]
    elif solid.kind == "ellipsoid":
        geometry = Ellipsoid(half)  # type: ignore[arg-type]
    else:
        geometry = {"cylinder": Cylinder, "capsule": Capsule, "sphere": Sphere}[solid.kind](*solid.sizes)
    words = dict(word.split(" ", 1) for word in solid.words if word.split(" ", 1)[0] in ("name", "material", "texture"))
    return Shape(geometry, place, rgba=solid.rgba, **words)  # type: ignore[arg-type]


def _plain(solid: Solid) -> Solid:
    """Return a solid without its looks and names, except that of its file."""
    return solid._replace(rgba=None, words=tuple(word for word in solid.words if word.startswith("file ")))


def _own(
    shapes: Sequence[Shape], solids: Sequence[Solid], form: str
) -> tuple[list[tuple[Shape, Shape]], dict[int, int]]:
    """Return shapes with their pieces, and which of some solids these are; ``form`` is how height maps are cut."""
    pieces = [(shape, piece) for shape in shapes for piece in shape.solids(form)]
    bare = [_plain(solid_of(piece)) for _, piece in pieces]
    own = dict(match(bare, solids).pairs)
    return pieces, own or dict(match([solid.as_cylinder for solid in bare], solids).pairs)


def _placed(shape: Shape, was: Solid) -> Shape:
    """Return a shape with the geometry and the place that it had."""
    made = _shape_of(was)
    geometry = made.geometry
    if isinstance(geometry, Cylinder) and isinstance(shape.geometry, Capsule):  # which a format without them has
        geometry = Capsule(geometry.radius, max(0.0, geometry.length - 2 * geometry.radius))
    return replace(shape, geometry=geometry, pose=made.pose)

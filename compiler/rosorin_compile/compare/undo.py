"""Undo differences: the robot that committed artifacts tell of.

It is the compiled robot with the old values put back that artifacts contain: where frames were, how joints moved, which
shapes links had. What an artifact is meant to contain of that robot shows which of its differences follow from others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from rosorin_compile.model import Capsule, Cylinder, HeightMap, Joint, Link, Mesh, Pose, Robot, Shape
from rosorin_compile.model.joint import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Mimic
from rosorin_compile.model.link import Inertial
from rosorin_compile.model.shape import MERGED, ROWS

from .describe import likened
from .pairs import Pair, links_of
from .solids import Solid, match, shape_of, solid_of
from .walk import Address, Difference, Leaves, Shapes, compare_leaves

_GRID = frozenset(field.name for field in fields(HeightMap))
# More solids than these are not held against each other one by one.
_MANY = 50


def undo_all(robot: Robot, pairs: Sequence[Pair]) -> Robot:
    """Return the robot of the artifacts as they were; what is new in one, and was in another before, is not new."""
    known = {name for pair in pairs for name in links_of(pair.old)}
    work = _Undo(robot, [pair.old for pair in pairs])
    done: set[Address] = set()
    for pair in sorted(pairs, key=lambda pair: -len(pair.old)):
        for one in compare_leaves(pair.old, pair.new, pair.precisions):
            kind, name, quantity = one.address
            is_fresh = one.old is None and not quantity and kind in ("frame", "link")
            if one.address not in done and not (is_fresh and name in known):
                done.add(one.address)
                work.apply(one, pair.old)
    return work.robot()


class _Undo:
    def __init__(self, robot: Robot, sides: Sequence[Leaves]) -> None:
        self.start = robot
        self.links = {link.name: link for link in robot.links}
        self.joints = {joint.child: joint for joint in robot.joints}
        self.materials = {material.name: material for material in robot.materials}
        # Not every format has the names of all joints.
        self.names = {
            str(of["child"]): name
            for side in {id(side): side for side in sides}.values()
            for (kind, name), of in side.items()
            if kind == "joint" and "child" in of
        }

    def robot(self) -> Robot:
        links, joints = tuple(self.links.values()), tuple(self.joints.values())
        made = replace(self.start, links=links, joints=joints, materials=tuple(self.materials.values()))
        return _largest_tree(made) or self.start

    def apply(self, one: Difference, old: Leaves) -> None:
        kind, name, quantity = one.address
        if not quantity and kind in ("frame", "link") and " " not in name:
            if one.old is None:
                self.joints.pop(name, None)
                self.links.pop(name, None)
            else:
                self._add(name, old)
        elif kind == "frame" and name in self.joints:
            self._frame(self.joints[name], quantity, one.old)
        elif kind == "joint":
            child = next((child for child, joint in self.joints.items() if joint.name == name), "")
            if child:
                self.joints[child] = _joint(self.joints[child], quantity, one.old, old.get(("joint", name), {}))
        elif kind == "material" and name in self.materials and quantity in ("rgba", "texture"):
            self.materials[name] = replace(self.materials[name], **{quantity: one.old})
        elif kind == "height map" and name in self.links and quantity in _GRID:
            link = self.links[name]
            self.links[name] = replace(link, collision=tuple(_grid(s, quantity, one.old) for s in link.collision))
        elif kind == "link" and name in self.links:
            self.links[name] = _link(self.links[name], one, old.get(("link", name), {}))

    def _frame(self, joint: Joint, quantity: str, old: Any) -> None:
        if quantity == "parent" and old in self.links and old != joint.child:
            self.joints[joint.child] = replace(joint, parent=old)
        elif quantity == "origin" and isinstance(old, Pose):
            self.joints[joint.child] = replace(joint, origin=old)
        elif quantity == "publisher" and isinstance(old, str):
            same = (other.publisher for other in self.joints.values() if other.publisher.name == old)
            usual = {ROBOT_STATE_PUBLISHER: ROBOT_STATE_PUBLISHER, "nobody": UNPUBLISHED}
            kind = usual.get(old.partition(":")[0], STATIC_TRANSFORM_PUBLISHER)
            publisher = next(same, replace(joint.publisher, name=old, kind=kind))
            self.joints[joint.child] = replace(joint, publisher=publisher)

    def _add(self, name: str, old: Leaves) -> None:
        """Add a link that is no more, with the joint that placed it, and what it was attached to."""
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
    if not isinstance(shape.geometry, HeightMap) or value is None:
        return shape
    return replace(shape, geometry=replace(shape.geometry, **{quantity: value}))


def _link(link: Link, one: Difference, entry: Mapping[str, Any]) -> Link:
    quantity = one.address.quantity
    if quantity in ("collision", "visual"):
        sides = [side.solids() if isinstance(side, Shapes) else [] for side in (one.old, one.new)]
        return replace(link, **{quantity: _shapes(getattr(link, quantity), *sides)})  # type: ignore[arg-type]
    if quantity in ("mass", "centre of mass", "inertia"):
        mass, centre, six = (entry.get(key) for key in ("mass", "centre of mass", "inertia"))
        known = None not in (mass, centre, six)
        return replace(link, inertial=Inertial(mass, Pose(centre), *six) if known else None)  # type: ignore[arg-type, misc]
    return link


def _shapes(now: Sequence[Shape], old: Sequence[Solid], new: Sequence[Solid]) -> tuple[Shape, ...]:
    """Return the shapes of a link as they were; those of other frames, which an artifact may have there, are not."""
    rest = match([one.bare for one in old], [one.bare for one in new])
    removed, added = [old[at].bare for at in rest.old], [new[at].bare for at in rest.new]
    if not removed and not added:
        return _repainted(now, old, new)
    pieces, own = max((_own(now, added, form) for form in (ROWS, MERGED)), key=lambda found: len(found[1]))
    if removed and added and not own:
        return tuple(now)  # they are of another frame, which tells of itself
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
    kept += [shape_of(solid) for at, solid in enumerate(removed) if at not in became.values()]
    return _repainted(kept, old, new)


Pieces = list[tuple[Shape, Shape]]


def _own(shapes: Sequence[Shape], solids: Sequence[Solid], form: str) -> tuple[Pieces, dict[int, int]]:
    """Return shapes with their pieces, and which of some solids these are; ``form`` is how height maps are cut."""
    pieces = [(shape, piece) for shape in shapes for piece in shape.solids(form)]
    bare = [solid_of(piece).bare for _, piece in pieces]
    own = dict(match(bare, solids).pairs)
    return pieces, own or dict(match([solid.as_cylinder for solid in bare], solids).pairs)


def _placed(shape: Shape, was: Solid) -> Shape:
    """Return a shape with the geometry and the place that it had."""
    made = shape_of(was)
    geometry = made.geometry
    if isinstance(geometry, Cylinder) and isinstance(shape.geometry, Capsule):  # which a format without them has
        geometry = Capsule(geometry.radius, max(0.0, geometry.length - 2 * geometry.radius))
    if isinstance(geometry, Mesh) and isinstance(shape.geometry, Mesh):
        geometry = replace(shape.geometry, scale=geometry.scale)
    return replace(shape, geometry=geometry, pose=made.pose)


def _repainted(now: Sequence[Shape], old: Sequence[Solid], new: Sequence[Solid]) -> tuple[Shape, ...]:
    """Return shapes with the colours, names and files that they had."""
    made = list(now)
    for was, became in ((a, b) for a in old for b in new if a.bare == b.bare and a != b):
        for at, shape in enumerate(made):
            if not isinstance(shape.geometry, HeightMap) and match([solid_of(shape).bare], [was.bare]).pairs:
                made[at] = _painted(shape, was, became)
    return tuple(made)


def _painted(shape: Shape, was: Solid, became: Solid) -> Shape:
    words = {word.split(" ", 1)[0]: "" for word in became.words if word not in was.words}
    words |= {word.split(" ", 1)[0]: word.split(" ", 1)[-1] for word in was.words if word not in became.words}
    known = {word: value for word, value in words.items() if word in ("name", "material", "texture")}
    if isinstance(shape.geometry, Mesh) and words.get("file"):
        shape = replace(shape, geometry=replace(shape.geometry, file=words["file"]))
    return replace(shape, **known, **({"rgba": was.rgba} if was.rgba != became.rgba else {}))  # type: ignore[arg-type]


def _largest_tree(robot: Robot) -> Robot | None:
    """Return the largest tree of a robot, without what is attached to nothing; None if there is none."""
    below: dict[str, list[str]] = {}
    joints = {joint.child: joint for joint in robot.joints}
    for child, joint in joints.items():
        below.setdefault(joint.parent, []).append(child)
    names = {link.name for link in robot.links}
    best: list[str] = []
    for root in (link.name for link in robot.links if link.name not in joints or joints[link.name].parent not in names):
        found, waiting = [root], [root]
        while waiting:
            children = [name for name in below.get(waiting.pop(), ()) if name in names]
            found += children
            waiting += children
        best = max(best, found, key=len)
    kept = set(best)
    links = tuple(link for link in robot.links if link.name in kept)
    inner = tuple(joint for child, joint in joints.items() if child in kept and joint.parent in kept)
    return replace(robot, links=links, joints=inner) if best else None

"""The robot of committed artifacts, for a picture: the compiled robot with old values put back.

Where frames were, how joints moved and which shapes links had is read from the artifacts; all else is as compiled.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

from rosorin_compile.compare.names import links_of
from rosorin_compile.compare.pairs import Pair
from rosorin_compile.compare.solids import Solid, match
from rosorin_compile.compare.walk import Address, Difference, Leaves, Shapes, compare_leaves
from rosorin_compile.model import HeightMap, Joint, Link, Pose, Robot, Shape
from rosorin_compile.model.joint import Mimic

_GRID = frozenset(field.name for field in fields(HeightMap))


def robot_before(robot: Robot, pairs: Sequence[Pair]) -> Robot:
    """Return the robot of the artifacts as they were; the robot itself if they describe no tree.

    A frame that is new in one artifact, and was in another before, is not new.
    """
    known = {name for pair in pairs for name in links_of(pair.old)}
    before = _Before(robot, [pair.old for pair in pairs])
    done: set[Address] = set()
    for pair in sorted(pairs, key=lambda pair: -len(pair.old)):
        for difference in compare_leaves(pair.old, pair.new, pair.precisions):
            kind, name, quantity = difference.address
            is_new = difference.old is None and not quantity and kind in ("frame", "link")
            if difference.address not in done and not (is_new and name in known):
                done.add(difference.address)
                before.undo(difference, pair.old)
    return before.robot()


class _Before:
    def __init__(self, robot: Robot, sides: Sequence[Leaves]) -> None:
        self.start = robot
        self.links = {link.name: link for link in robot.links}
        self.joints = {joint.child: joint for joint in robot.joints}
        # Not every format has the names of all joints.
        entries = [(thing, entry) for side in sides for thing, entry in side.items()]
        self.names = {str(of["child"]): name for (kind, name), of in entries if kind == "joint" and "child" in of}

    def robot(self) -> Robot:
        joints = [joint for child, joint in self.joints.items() if {child, joint.parent} <= self.links.keys()]
        made = replace(self.start, links=tuple(self.links.values()), joints=tuple(joints))
        return made if made.is_tree else self.start

    def undo(self, difference: Difference, old: Leaves) -> None:
        """Put the old value of a difference back, if the model has a place for it."""
        (kind, name, quantity), was = difference.address, difference.old
        link, joint = self.links.get(name), self.joints.get(name)
        if not quantity and kind in ("frame", "link") and " " not in name:
            if was is None:
                self.joints.pop(name, None)
                self.links.pop(name, None)
            else:
                self._add(name, old)
        elif kind == "frame" and joint is not None:
            if quantity == "parent" and was in self.links and was != name:
                self.joints[name] = replace(joint, parent=was)
            elif quantity == "origin" and isinstance(was, Pose):
                self.joints[name] = replace(joint, origin=was)
        elif kind == "joint":
            for moved in [joint for joint in self.joints.values() if joint.name == name]:
                self.joints[moved.child] = _joint(moved, quantity, was, old.get(("joint", name), {}))
        elif kind == "height map" and link is not None and quantity in _GRID and was is not None:
            grids = (
                replace(shape, geometry=replace(shape.geometry, **{quantity: was}))
                if isinstance(shape.geometry, HeightMap)
                else shape
                for shape in link.collision
            )
            self.links[name] = replace(link, collision=tuple(grids))
        elif kind == "link" and link is not None and quantity in ("collision", "visual"):
            sides = [side if isinstance(side, Shapes) else Shapes(()) for side in (was, difference.new)]
            shapes = _shapes(getattr(link, quantity), *sides)
            self.links[name] = (
                replace(link, collision=shapes) if quantity == "collision" else replace(link, visual=shapes)
            )

    def _add(self, name: str, old: Leaves) -> None:
        """Add a link that was removed, with the joint that placed it."""
        if name not in self.links:
            entry = old.get(("link", name), {})
            shapes = {key: entry[key].shapes for key in ("collision", "visual") if key in entry}
            self.links[name] = Link(name, **shapes)
        frame = old.get(("frame", name), {})
        if name not in self.joints and isinstance(frame.get("origin"), Pose) and frame.get("parent"):
            joint = Joint(self.names.get(name, name), "fixed", frame["parent"], name, frame["origin"])
            entry = old.get(("joint", joint.name), {})
            for quantity, value in entry.items():
                joint = _joint(joint, quantity, value, entry)
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


def _shapes(now: Sequence[Shape], old: Shapes, new: Shapes) -> tuple[Shape, ...]:
    """Return the shapes of a link as they were; those of other frames, which an artifact may have there, are not."""
    before, after = ([_bare(solid) for solid in side.solids()] for side in (old, new))
    rest = match(before, after)
    added = [after[at] for at in rest.new]
    solids = [_bare(solid) for solid in Shapes(tuple(now)).solids()]
    own = {at for at, _ in match(solids, added).pairs}
    own = own or {at for at, _ in match([solid.as_cylinder for solid in solids], added).pairs}
    if not own:  # with both, they are of another frame, which has a difference of its own
        return tuple(now) if rest.old and rest.new else (*now, *(_pieces(old)[at] for at in rest.old))
    kept = (piece for at, piece in enumerate(_pieces(Shapes(tuple(now)))) if at not in own)
    return (*kept, *(_pieces(old)[at] for at in rest.old))


def _pieces(side: Shapes) -> list[Shape]:
    return [piece for shape in side.shapes for piece in shape.solids()]


def _bare(solid: Solid) -> Solid:
    """Return a solid without its looks and names, except that of its file."""
    return solid._replace(rgba=None, words=tuple(word for word in solid.words if word.startswith("file ")))

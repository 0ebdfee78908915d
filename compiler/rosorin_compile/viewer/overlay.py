"""Compute which links moved between two versions of a robot, and which old shapes to draw, for a page of changes.

A link that moved relative to its parent is distinguished from a link that moved with its parent. Unchanged shapes are
drawn only once. The previous robot is the compiled robot with the frames, joints and shapes of the committed artifacts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields, replace
from itertools import product
from typing import Any, NamedTuple

from rosorin_compile.compare.artifacts import Pair
from rosorin_compile.compare.bodies import Bodies, same_motion
from rosorin_compile.compare.diff import not_carried, pair_sides, pieces_of
from rosorin_compile.compare.difference import Difference as RobotDifference
from rosorin_compile.compare.precision import Precision, exact
from rosorin_compile.compare.solids import Solid, match
from rosorin_compile.compare.walk import Address, Difference, Leaves, Shapes, compare_leaves, links_of, renamed_robot
from rosorin_compile.model import HeightMap, Joint, Link, Mesh, Pose, Robot, Shape
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.joint import Mimic

# Kinds of changes of a link. A CARRIED link only moved because its parent moved.
MOVED, CARRIED, SHAPED, NEW, REMOVED = "moved", "carried", "shaped", "new", "removed"
PURPOSES = ("visual", "collision")
_LEAST = 1e-9  # smallest tolerance, in m and rad


class Overlay(NamedTuple):
    """The old robot, with links named as in the new robot, to be drawn over the new robot.

    ``how`` maps each changed link to the kind of change. ``shapes`` maps (link, "visual" or "collision") to the old
    shapes to draw. ``at`` is the pose of the old root link in the new root link. ``frames`` maps each link and joint in
    the comparison to the frame that shows the change.
    """

    old: Robot
    how: Mapping[str, str]
    shapes: Mapping[tuple[str, str], tuple[Shape, ...]]
    at: Pose
    frames: Mapping[str, str] = {}

    def with_meshes(self, changed: Collection[str]) -> Overlay:
        """Return a copy that also has the links with a mesh file in ``changed`` (file names in the description)."""
        how, shapes = dict(self.how), dict(self.shapes)
        for link, purpose in product(self.old.links, PURPOSES):
            others = [s for s in getattr(link, purpose) if isinstance(s.geometry, Mesh) and s.geometry.file in changed]
            if others and how.setdefault(link.name, SHAPED) == SHAPED:
                shapes[link.name, purpose] = (*dict.fromkeys((*shapes.get((link.name, purpose), ()), *others)),)
        return self._replace(how=how, shapes=shapes)


def of_two(difference: RobotDifference, prefix: str | None) -> Overlay:
    """Return the overlay of the first robot on the second.

    ``prefix`` is the prefix of all names in the second robot, "" for none, or None to detect it.
    """
    a, b = difference.sides
    pairing = pair_sides(a, b, difference.tolerance, prefix)
    first, second = pairing.a.robot, pairing.b.robot
    # Map the names used in the comparison to the names in the second robot.
    links, joints = (
        {common.name: own.name for common, own in zip(getattr(second, kind), getattr(b.robot, kind), strict=True)}
        for kind in ("links", "joints")
    )
    old_links, old_joints = _apart([*first.link], links), _apart([*first.joint], joints)
    frames: dict[str, str] = {}
    for robot, names in ((first, old_links), (second, links)):
        frames |= {joint.name: names[joint.child] for joint in robot.joints if joint.child in robot.link}
        frames |= {name: names[name] for name in robot.link}
    old = renamed_robot(first, old_links, old_joints)
    unknown = {links.get(name, old_links.get(name, name)) for name in not_carried(pairing, a, b)[0]}
    found = moves(old, b.robot, difference.tolerance, (a.printing, b.printing), unknown)
    return found._replace(frames=frames)


def _apart(names: Sequence[str], shared: Mapping[str, str]) -> dict[str, str]:
    """Map names of the first robot to the second; append "(before)" if the second uses the name for something else."""
    taken = set(shared.values())
    return {name: shared.get(name, f"{name} (before)" if name in taken else name) for name in names}


def moves(
    old: Robot,
    new: Robot,
    tolerance: float = _LEAST,
    precisions: tuple[Precision, Precision] = (exact, exact),
    unknown: Collection[str] = (),
) -> Overlay:
    """Compare the links of two versions of a robot by name, and return an overlay of the old version.

    Differences within ``tolerance`` (m, rad) or within the rounding of the files (``precisions``) are ignored, and so
    are the links in ``unknown``, which one of the file formats cannot represent.
    """
    tolerance = max(tolerance, _LEAST)
    a, b = Bodies(old, precisions[0]), Bodies(new, precisions[1])
    # Align the robots at a root link that both have, or else at the first common link.
    names = [new.root, old.root, *(link.name for link in new.walk())]
    anchor = next((name for name in names if name in a.top and name in b.top), "")
    # Skip visuals or collision shapes if a robot has none, because its format may not support them.
    purposes = [p for p in PURPOSES if all(any(getattr(x, p) for x in robot.links) for robot in (old, new))]
    how: dict[str, str] = {}
    for link in new.walk():
        name = link.name
        if name not in a.top:
            how[name] = NEW
            continue
        # Compare the pose relative to the nearest ancestor link that both robots have.
        above = next((j.parent for j in reversed(new.chain(name)) if j.parent in a.top), anchor)
        ways = (side.joints_between(side.top[above], side.top[name]) or [] for side in (a, b))
        first, second = ([joint.mimic for joint in way] for way in ways)
        if name != anchor and not (first == second and same_motion(a, b, above, name, tolerance)):
            how[name] = MOVED
        elif name != anchor and how.get(above) in (MOVED, CARRIED):
            how[name] = CARRIED
        elif any(_gone(a, b, name, p, tolerance) or _gone(b, a, name, p, tolerance) for p in purposes):
            how[name] = SHAPED
    how |= {link.name: REMOVED for link in old.walk() if link.name not in new.link}
    shapes: dict[tuple[str, str], tuple[Shape, ...]] = {}
    for link, purpose in product(old.links, PURPOSES):
        name, what = link.name, how.get(link.name)
        found: Sequence[Shape] = ()
        if what in (MOVED, CARRIED):
            found = getattr(link, purpose)
        elif what == REMOVED or (what == SHAPED and purpose in purposes):
            mates = [mate for mate in a.members[a.top[name]] if mate in b.top and how.get(mate) not in (MOVED, CARRIED)]
            found = _gone(a, b, name, purpose, tolerance, name if name in b.top else next(iter(mates), ""))
        if found and name not in unknown:
            shapes[name, purpose] = tuple(found)
    at = Pose()
    if anchor:
        here, there = (side.relative(side.robot.root, anchor).transform for side in (a, b))
        at = pose_of(there.then(here.inverse()))
    return Overlay(old, {name: what for name, what in how.items() if name not in unknown}, shapes, at)


def _gone(a: Bodies, b: Bodies, name: str, purpose: str, tolerance: float, mate: str | None = None) -> list[Shape]:
    """Return the shapes of link ``name`` in robot ``a`` that robot ``b`` lacks in link ``mate`` and links fixed to it.

    By default, ``mate`` is ``name``. If ``mate`` is "", there is no such link, and all shapes are returned.
    """
    pieces, around = _pieces(a, name, purpose), list[Solid]()
    mate = name if mate is None else mate
    if not mate:
        return [shape for shape, _ in pieces]
    for member in b.members[b.top[mate]]:
        around += [solid.seen_from(b.relative(mate, member)) for _, solid in _pieces(b, member, purpose)]
    solids = [solid.seen_from(a.relative(mate, name)) for _, solid in pieces]
    return [pieces[index][0] for index in match(solids, around, tolerance).old]


def _pieces(side: Bodies, name: str, purpose: str) -> list[tuple[Shape, Solid]]:
    shapes = [solid for shape in getattr(side.robot.link[name], purpose) for solid in shape.solids()]
    pieces = pieces_of(name, shapes, side.precision, capsules=False)
    return [(shape, piece.solid) for shape, piece in zip(shapes, pieces, strict=True)]


_GRID = frozenset(field.name for field in fields(HeightMap))


def robot_before(robot: Robot, pairs: Sequence[Pair]) -> Robot:
    """Return the robot as it was when the artifacts were committed, or ``robot`` if the old links are not a tree.

    A frame is only new if none of the committed artifacts has it.
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
        # Joint names by child link, from all artifacts, because some formats have no joint names.
        entries = [(thing, entry) for side in sides for thing, entry in side.items()]
        self.names = {str(of["child"]): name for (kind, name), of in entries if kind == "joint" and "child" in of}

    def robot(self) -> Robot:
        joints = [joint for child, joint in self.joints.items() if {child, joint.parent} <= self.links.keys()]
        made = replace(self.start, links=tuple(self.links.values()), joints=tuple(joints))
        return made if made.is_tree else self.start

    def undo(self, difference: Difference, old: Leaves) -> None:
        (kind, name, quantity), was = difference.address, difference.old
        link, joint = self.links.get(name), self.joints.get(name)
        if not quantity and kind in ("frame", "link") and " " not in name:
            if was is not None:
                self._add(name, old)
            else:
                self.joints.pop(name, None)
                self.links.pop(name, None)
        elif kind == "frame" and joint is not None:
            if quantity == "parent" and was in self.links and was != name:
                self.joints[name] = replace(joint, parent=was)
            elif quantity == "origin" and isinstance(was, Pose):
                self.joints[name] = replace(joint, origin=was)
        elif kind == "joint":
            for moved in [joint for joint in self.joints.values() if joint.name == name]:
                self.joints[moved.child] = _joint(moved, quantity, was, old.get(("joint", name), {}))
        elif kind == "height map" and link is not None and quantity in _GRID and was is not None:
            shapes = list(link.collision)
            for at, shape in enumerate(shapes):
                if isinstance(shape.geometry, HeightMap):
                    shapes[at] = replace(shape, geometry=replace(shape.geometry, **{quantity: was}))
            self.links[name] = replace(link, collision=tuple(shapes))
        elif kind == "link" and link is not None and quantity in PURPOSES:
            sides = [side if isinstance(side, Shapes) else Shapes(()) for side in (was, difference.new)]
            changed: dict[str, Any] = {quantity: _shapes(getattr(link, quantity), *sides)}
            self.links[name] = replace(link, **changed)

    def _add(self, name: str, old: Leaves) -> None:
        entry = old.get(("link", name), {})
        self.links.setdefault(name, Link(name, **{key: entry[key].shapes for key in PURPOSES if key in entry}))
        frame = old.get(("frame", name), {})
        if name not in self.joints and isinstance(frame.get("origin"), Pose) and frame.get("parent"):
            joint = Joint(self.names.get(name, name), "fixed", frame["parent"], name, frame["origin"])
            entry = old.get(("joint", joint.name), {})
            for quantity, value in entry.items():
                joint = _joint(joint, quantity, value, entry)
            self.joints[name] = joint


def _joint(joint: Joint, quantity: str, value: Any, entry: Mapping[str, Any]) -> Joint:
    if not quantity:  # some formats only list moving joints, so a missing joint is fixed
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
    """Undo added and removed shapes of a link, but keep shapes that the artifact has in another link."""
    before, after = ([_bare(solid) for solid in side.solids()] for side in (old, new))
    rest = match(before, after)
    added = [after[at] for at in rest.new]
    solids = [_bare(solid) for solid in Shapes(tuple(now)).solids()]
    own = {at for at, _ in match(solids, added).pairs}
    own = own or {at for at, _ in match([solid.as_cylinder for solid in solids], added).pairs}
    before_now, here = ([piece for shape in shapes for piece in shape.solids()] for shapes in (old.shapes, now))
    back = [before_now[at] for at in rest.old]
    if own:
        return (*(piece for at, piece in enumerate(here) if at not in own), *back)
    return tuple(now) if rest.old and rest.new else (*now, *back)  # the change is in another link


def _bare(solid: Solid) -> Solid:
    return solid._replace(rgba=None, words=tuple(word for word in solid.words if word.startswith("file ")))

"""Causes: why shapes differ, where something else that differs says it already.

An artifact that does not carry every frame gives the shapes of a frame that it leaves out to a link that it carries;
boxes are made from a height map. Such shapes differ because something else does. That there is no more to it is
calculated: the old shapes must follow from what was, and the new ones from what is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from rosorin_compile.formats import Fact
from rosorin_compile.formats.facts import COLLISION, Solid
from rosorin_compile.model import HeightMap, Joint, Link, Robot, Shape
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.shape import GROUNDED, MERGED, ROWS

from .entities import Change, Pair, joints_by_child
from .solids_old import remainder, same_bodies, same_set, shape_of, solid_from
from .view import View, transform_of

# A damaged height beyond this (m) is not cut into steps.
_SKY = 1e6
# What shapes look like, in the words of an artifact.
LOOK = ("red", "green", "blue", "alpha", "texture")
_STILL = ("", "fixed")
_OF_BOXES = ("cells", "cell", "origin x", "origin y")


def causes(
    robot: Robot, pair: Pair, thing: tuple[str, str], pairs: Sequence[Pair], whole: Pair | None, found: Sequence[Change]
) -> list[int]:
    """Return which of the changes found so far explain all that differs in some shapes of an artifact.

    ``thing`` is the link and the purpose of the shapes; ``whole`` the artifact that carries every frame with its own
    shapes, None if there is none.
    """
    link, purpose = thing
    maps = [at for at, change in enumerate(found) if _is_map(change) and change.name == link]
    if maps and purpose == COLLISION and _made_of_map(robot, pair, link, pairs):
        return maps
    painted = _painted(robot, pair, thing)
    materials = [at for at, change in enumerate(found) if change.kind == "material" and change.name in painted]
    if materials and painted <= {found[at].name for at in materials}:
        return materials
    if whole is None or whole.output == pair.output:
        return []
    trees = _tree(whole.old, purpose), _tree(whole.new, purpose)
    if purpose == COLLISION and _is_grounded(robot, pair):
        teller = next((other for other in pairs if other.old.heights and other.new.heights), None)
        told = (teller.old, teller.new) if teller else (None, None)
        trees = _grounded(trees[0], robot, told[0]), _grounded(trees[1], robot, told[1])
    members: set[str] = set()
    for tree, view, every in zip(trees, (pair.old, pair.new), (whole.old, whole.new), strict=True):
        if link not in tree.link:
            return []
        tolerance = 8 * max((solid.tolerance for solids in every.shapes.values() for solid in solids), default=0.0)
        shapes, lenders = tree.shapes_at(link, view.names, purpose)
        # Colours and materials are said differently in each artifact.
        mine = [solid._replace(words=()) for solid in view.shapes.get(thing, ())]
        if not same_bodies(mine, [solid_from(shape, tolerance) for shape in shapes]):
            return []
        members |= lenders
    return [at for at, change in enumerate(found) if members and _moves(change, pair, thing, members, trees)]


def _painted(robot: Robot, pair: Pair, thing: tuple[str, str]) -> set[str]:
    """Return the materials of the shapes that differ, if they differ in their look alone; empty if not."""
    link, purpose = thing
    old, new = (view.shapes.get(thing, ()) for view in (pair.old, pair.new))
    visuals = robot.link[link].visual if link in robot.link and purpose == "visual" else ()
    solids = [solid for shape in visuals for solid in shape.solids()]
    if not len(old) == len(new) == len(solids):
        return set()
    found = set()
    for before, after, solid in zip(old, new, solids, strict=True):
        if before != after:
            found.add(solid.material if _without_look(before) == _without_look(after) else "")
    return found


def _without_look(solid: Solid) -> Solid:
    return solid._replace(words=tuple(word for word in solid.words if word.split(" ")[0] not in LOOK))


def _made_of_map(robot: Robot, pair: Pair, link: str, pairs: Sequence[Pair]) -> bool:
    """Say whether the shapes of a link differ only because its height map does."""
    shapes = robot.link[link].collision if link in robot.link else ()
    step = next((shape.geometry.step for shape in shapes if isinstance(shape.geometry, HeightMap)), 0.0)
    teller = next((other for other in pairs if link in other.old.heights and link in other.new.heights), None)
    if not step or teller is None or max(map(_highest, (teller.old.heights[link], teller.new.heights[link]))) > _SKY:
        return False
    rest = []
    for view, told in ((pair.old, teller.old), (pair.new, teller.new)):
        solids = [solid._replace(words=()) for solid in view.shapes.get((link, COLLISION), ())]
        grid = _with_bottom(_grid(told, link, step), shapes)
        forms = (ROWS, MERGED, GROUNDED)
        left = (remainder(solids, [solid_from(Shape(box)) for box in grid.boxes(form)]) for form in forms)
        fitting = next((one for one in left if not one.added), None)
        if fitting is None:
            return False
        rest.append(fitting.removed)
    return same_set(rest[0], rest[1])


def _highest(cells: Mapping[tuple[int, int], float]) -> float:
    return max(cells.values())


def _grid(view: View, frame: str, step: float) -> HeightMap:
    """Return a height map as an artifact tells it."""
    cells = view.heights[frame]
    rows, columns = (1 + max(cell[axis] for cell in cells) for axis in (0, 1))
    heights = tuple(tuple(cells.get((i, j), 0.0) for j in range(columns)) for i in range(rows))
    x, y, cell = (_number(view, frame, quantity) for quantity in ("origin x", "origin y", "cell"))
    return HeightMap((x, y), cell, heights, step)


def _with_bottom(grid: HeightMap, shapes: Sequence[Shape]) -> HeightMap:
    """Return a height map with the bottom that a link says, for an artifact may tell the top alone."""
    for shape in shapes:
        given = shape.geometry
        if isinstance(given, HeightMap) and [*map(len, given.heights)] == [*map(len, grid.heights)]:
            return replace(grid, bottom=given.bottom)
    return grid


def _number(view: View, frame: str, quantity: str) -> float:
    found = view.plain.get(Fact("height map", frame, quantity))
    return found.value if found and isinstance(found.value, float) else 0.0


def _tree(view: View, purpose: str) -> Robot:
    """Return the frames of an artifact that carries all of them, with their shapes of one purpose, as a robot."""
    names = sorted(view.names)
    frames = {name: view.parent(name) for name in names}
    moving = {
        child for child, joint in joints_by_child(view).items() if view.text("joint", joint, "type") not in _STILL
    }
    shapes = {name: map(shape_of, view.shapes.get((name, purpose), ())) for name in names}
    solids = {name: tuple(filter(None, shapes[name])) for name in names}
    links = [Link(name, collision=solids[name], visual=solids[name]) for name in names]
    joints = [
        Joint(name, "revolute" if name in moving else "fixed", parent, name, pose_of(transform_of(view, name)))
        for name, parent in frames.items()
        if parent in frames
    ]
    return Robot("", tuple(links), tuple(joints))


def _is_map(change: Change) -> bool:
    """Say whether a change is about the numbers of a height map that boxes are made from."""
    return change.kind == "height map" and change.quantity in _OF_BOXES


def _is_grounded(robot: Robot, pair: Pair) -> bool:
    """Say whether an artifact has height maps down to z = 0, unlike the one that carries every frame."""
    return any(one.name == pair.output and one.options.get("height_maps") == GROUNDED for one in robot.outputs)


def _grounded(tree: Robot, robot: Robot, told: View | None) -> Robot:
    """Return a tree whose height maps reach down to z = 0, with the heights that an artifact tells, if one does."""
    links = []
    for link in tree.links:
        shapes = robot.link[link.name].collision if link.name in robot.link else ()
        maps = [shape.geometry for shape in shapes if isinstance(shape.geometry, HeightMap)]
        solids = [solid for shape in shapes for solid in shape.solids(GROUNDED)]
        if len(maps) == len(shapes) == 1 and told is not None and link.name in told.heights:
            solids = [Shape(box, shapes[0].pose) for box in _grid(told, link.name, maps[0].step).boxes(GROUNDED)]
        links.append(replace(link, collision=tuple(solids)) if maps else link)
    return replace(tree, links=tuple(links))


def _moves(change: Change, pair: Pair, thing: tuple[str, str], members: set[str], trees: tuple[Robot, Robot]) -> bool:
    """Say whether a change is about a frame whose shapes a link carries, or about where it sits."""
    link, purpose = thing
    if change.kind == "frame" and not change.quantity and change.name in pair.old.names ^ pair.new.names:
        return pair.output in change.artifacts
    if change.kind == "frame":
        above = [tree.joint_to[link].parent for tree in trees if link in tree.joint_to]
        placed = change.name in members or (change.name == link and bool(members.intersection(above)))
        return placed and change.quantity not in ("publisher", "topic")
    if change.kind == "link" and change.name in {link, *members}:
        return change.quantity.startswith(purpose)
    return _is_map(change) and change.name in members and purpose == COLLISION

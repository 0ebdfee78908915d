"""Bodies and geoms of an MJCF of ours: their names, groups and bits, ranges of joints, and the pose at home.

MuJoCo lets two geoms touch if the ``contype`` of one has a bit that the ``conaffinity`` of the other has. A shape has
those of its ``contact``; a shape without them, and so the floor of a scene, has bit 1 in both. Where a robot sets no
bits, the wheels of its drive meet the floor alone: a hub and its rollers are built into each other, and a wheel into
its arch.

A height map is boxes or a height field (XMLreference "asset/hfield"), which has elevations of points, with slopes
between them: a point has the height of its highest cell, so that the field is never smaller than the body. They are
scaled between the lowest and the highest; the first row has the largest y. Below the lowest point is a slab.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from functools import reduce
from itertools import product
from typing import NamedTuple

from rosorin_compile import model
from rosorin_compile.model.bounds import Bounds, reach_along
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.mesh_vertices import Clouds, no_clouds
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.shape import MERGED
from rosorin_compile.source.cache import of_robot

WORLD = "world"  # the root body of MuJoCo
# Attributes of a pair besides its geoms that mean no more than that they touch.
TOUCHES: tuple[dict[str, str], ...] = ({}, {"condim": "1"})

# The ends of the names of the joints that stand for one, as MuJoCo's own reader of URDF names them.
PLANAR = ("_TX", "_TY", "_RZ")
FLOATING = ("_TX", "_TY", "_TZ", "_R")

# The default stiffness of the coupling of a joint that follows another one.
STIFF = {"solref": (0.005, 1.0), "solimp": (0.95, 0.99, 0.001)}
# The ends of the names of default classes (``Classes``), and the groups by which viewers show and hide.
VISUAL, COLLISION = "visual", "collision"
WHEEL = "wheel_collision"  # what of wheels collides: with the floor alone (``Masks``)
# Collision shapes that are seen, in the groups of visuals: those of links that have nothing else to be seen by.
SHOWN, SHOWN_WHEEL = "shown_collision", "shown_wheel_collision"
FRAME = "frame"  # the sites that mark frames: dots that a viewer shows with group 4
CLASSES = (VISUAL, COLLISION, WHEEL, SHOWN, SHOWN_WHEEL, FRAME)

VISUAL_GROUP, COLLISION_GROUP, FRAME_GROUP = 2, 3, 4


def body_name(robot: model.Robot, link: str) -> str:
    """Return the name of the body of a link: its own, unless MuJoCo reserves that name."""
    if link == robot.root and robot.root_in_world.world:
        return WORLD
    name = link if link != WORLD else f"{WORLD}_link"
    known = {*robot.link, *(edge.child for edge in robot.edges)} if link == WORLD else ()
    return free_name(name, known)


def free_name(name: str, taken: Container[str]) -> str:
    """Return a name, with underscores after it while another object has it."""
    while name in taken:
        name += "_"
    return name


def reference(joint: model.Joint) -> float:
    """Return the position (rad or m) of a joint in the initial pose of MuJoCo (``ref``)."""
    value = joint.mjcf.get("ref", 0.0) if joint.moves else 0.0
    return value if isinstance(value, (int, float)) else 0.0


def shift_polynomial(coefficients: Sequence[float], by: float) -> list[float]:
    """Return the coefficients of the polynomial of ``x + by`` as one of ``x``, from the lowest up.

    >>> shift_polynomial([1, 2, 3], 1)
    [6, 8, 3]
    """
    made = list(coefficients)
    for lowest in range(len(made)):
        for place in range(len(made) - 2, lowest - 1, -1):
            made[place] += by * made[place + 1]
    return made


def is_free(robot: model.Robot, joint: model.Joint) -> bool:
    """Return True if a floating joint is a free joint of MuJoCo, whose parent is the world."""
    return joint.type == "floating" and robot.root_in_world.world and joint.parent == robot.root


@of_robot
def weld_groups(robot: model.Robot) -> dict[str, list[str]]:
    """Return the links that no joint moves against each other, in the order of the tree, by the topmost of them."""
    top, groups = dict[str, str](), dict[str, list[str]]()
    for name in (link.name for link in robot.walk()):
        joint = robot.joint_to.get(name)
        top[name] = top[joint.parent] if joint is not None and joint.is_fixed else name
        groups.setdefault(top[name], []).append(name)
    return groups


class Mask(NamedTuple):
    """The bits that a geom is on, and those that it touches."""

    contype: int = 1
    conaffinity: int = 1

    def meets(self, other: Mask) -> bool:
        return bool(self.contype & other.conaffinity or other.contype & self.conaffinity)

    def attributes(self) -> dict[str, str]:
        return {"contype": str(self.contype), "conaffinity": str(self.conaffinity)}


BITS = ("contype", "conaffinity")
USUAL, ROLLS, BESIDE_WHEELS = Mask(), Mask(1, 0), Mask(3, 2)


class Masks:
    """The masks of collision shapes, without ``implied`` the described ones; ``rolling`` links meet the floor alone."""

    def __init__(self, robot: model.Robot, implied: bool) -> None:
        self.rolling = rolling(robot) if implied else frozenset[str]()
        self.usual = BESIDE_WHEELS if self.rolling else USUAL
        self._of_links = {link.name: {self.mask_of(link.name, one) for one in link.collision} for link in robot.links}

    def mask_of(self, link: str, shape: model.Shape) -> Mask:
        if link in self.rolling:
            return ROLLS
        values = shape.contact.values if shape.contact is not None else {}
        found = zip((values.get(word) for word in BITS), self.usual, strict=True)
        return Mask(*(int(bit) if isinstance(bit, (int, float)) else usual for bit, usual in found))

    def meet(self, one: str, other: str) -> bool:
        return any(mask.meets(theirs) for mask in self._of_links[one] for theirs in self._of_links[other])


@of_robot
def rolling(robot: model.Robot) -> frozenset[str]:
    """Return the links that meet the floor alone: wheels with what turns on them, unless the description sets bits."""
    drive, contacts = robot.drive, (shape.contact for link in robot.links for shape in link.collision)
    if drive is None or any(one and not one.values.keys().isdisjoint(BITS) for one in contacts):
        return frozenset()
    wheels = {robot.joint[name].child for names in drive.joints.values() for name in names if name in robot.joint}
    steered = {robot.joint[name].child for name in drive.steering if name in robot.joint}
    wheels -= steered
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        if above is not None and (above.parent in wheels or (above.parent in steered and above.type == "continuous")):
            wheels.add(link.name)
        elif above is not None and above.parent in steered:
            steered.add(link.name)
    return frozenset(wheels)


HFIELD = "hfield"
_THIN = 1e-5  # m: instead of a thickness of zero, which MuJoCo refuses


class Field(NamedTuple):
    """A height field: points along y and x, MuJoCo's four sizes (m), elevations (m) row by row, and its place."""

    rows: int
    columns: int
    size: tuple[float, float, float, float]
    elevation: tuple[float, ...]
    pose: model.Pose


def has_volume(geometry: model.Geometry) -> bool:
    """Return True if MuJoCo accepts the sizes of a geometry: all above zero; a mesh may be mirrored."""
    if isinstance(geometry, model.Mesh):
        return all(geometry.scale)
    return all(size > 0 for size in half_sizes(geometry))


def half_sizes(geometry: model.Geometry) -> tuple[float, ...]:
    """Return the sizes of a primitive as MuJoCo counts: half extents, radii, radius and half length (m)."""
    if isinstance(geometry, model.Box):
        x, y, z = geometry.size
        return (x / 2, y / 2, z / 2)
    if isinstance(geometry, (model.Cylinder, model.Capsule)):
        return (geometry.radius, geometry.length / 2)
    if isinstance(geometry, model.Ellipsoid):
        return geometry.radii
    return (geometry.radius,) if isinstance(geometry, model.Sphere) else ()


def form_of(output: model.Output) -> str:
    """Return the form of height maps in an output: a form of boxes, or ``hfield``."""
    return str(output.options.get("height_maps", MERGED))


def numbered_solids(link: model.Link, purpose: str, form: str) -> Iterator[tuple[int, model.Shape]]:
    """Yield the shapes of the geoms of a link, counted from 1: a height map as boxes in a form, or as it is."""
    shapes = link.visual if purpose == VISUAL else link.collision
    yield from enumerate((one for shape in shapes for one in ((shape,) if form == HFIELD else shape.solids(form))), 1)


def colliding(link: model.Link, output: model.Output) -> Sequence[model.Shape] | None:
    """Return the shapes of the geoms that a link collides with; None where one is a height field, no shape of ours."""
    form = form_of(output)
    if form == HFIELD and any(len(shape.solids()) > 1 for shape in link.collision):
        return None
    return [solid for shape in link.collision for solid in shape.solids(form) if has_volume(solid.geometry)]


def field_of(shape: model.Shape, grid: model.HeightMap) -> Field:
    """Return the height field of a height map in the frame of its link."""
    tops: dict[tuple[int, int], float] = {}
    count, across = len(grid.heights), len(grid.heights[0])
    boxes = grid.boxes()
    lowest = min((box.lower[2] for box in boxes), default=0.0)

    def cells(axis: int, box: model.Box) -> range:
        first, last = (round((end[axis] - grid.origin[axis]) / grid.cell) for end in (box.lower, box.upper))
        return range(first, last + 1)

    for box in boxes:
        for point in product(cells(0, box), cells(1, box)):
            tops[point] = max(box.upper[2], tops.get(point, lowest))
    points = [tops.get((x, y), lowest) for y in range(across, -1, -1) for x in range(count + 1)]
    low, high = min(points), max(points)
    half = count * grid.cell / 2, across * grid.cell / 2
    size = (*half, max(high - low, _THIN), max(low - lowest, _THIN))
    middle = shape.pose.transform().apply((grid.origin[0] + half[0], grid.origin[1] + half[1], low))
    elevation = tuple(round(point - low, 12) for point in points)
    return Field(across + 1, count + 1, size, elevation, model.Pose(middle, shape.pose.rpy))


HOME = "home"
_DIGITS = 9  # of a height in metres: removes rounding only


def range_of(joint: model.Joint) -> tuple[float, float] | None:
    """Return the range of a joint that moves by itself (rad or m), a turn without limits; None if it has no bounds."""
    limit = joint.limit
    if not joint.moves or joint.mimic is not None:
        return None
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        return limit.lower, limit.upper
    return None if joint.type == "prismatic" else (-math.pi, math.pi)


def leader_of(robot: model.Robot, joint: model.Joint) -> model.Joint:
    """Return the joint that a joint follows in the end, or itself."""
    while joint.mimic is not None:
        joint = robot.joint[joint.mimic.joint]
    return joint


def home_of(robot: model.Robot) -> JointPose:
    """Return the pose called home; without one all joints are at zero, or at the limit nearest to it."""
    named = next((pose for pose in robot.poses if pose.name == HOME), None)
    return JointPose(HOME, nearest_to_zero(robot)) if named is None else named


def nearest_to_zero(robot: model.Robot) -> dict[str, float]:
    """Return the limits (rad or m), no stand-ins, nearest to zero of the joints whose limits do not include it."""
    measured = [joint for joint in robot.joints if joint.limit and not {"lower", "upper"} & set(joint.limit.stand_ins)]
    ranges = {joint.name: range_of(joint) or (0.0, 0.0) for joint in measured}
    return {name: low if low > 0.0 else high for name, (low, high) in ranges.items() if low < high and low * high > 0.0}


def stands_at(robot: model.Robot, pose: JointPose, clouds: Clouds = no_clouds) -> model.Pose:
    """Return the pose of the root of a free robot in the world.

    It is that of the pose, or that of the root in the description. Without either, the robot stands upright, its lowest
    collision shape at z = 0; with meshes of unknown size it stays at the origin.
    """
    if pose.base is not None:
        return pose.base
    if robot.root_in_world.placed:
        return robot.root_in_world.pose
    bounds, meshes = reach(robot, pose.positions, "collision", IDENTITY, clouds)
    if bounds is None or meshes:
        return IDENTITY
    return model.Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], _DIGITS)))


def reach(
    robot: model.Robot, positions: Mapping[str, float], purpose: str, at: model.Pose, clouds: Clouds
) -> tuple[Bounds | None, int]:
    """Return the box (m) around the shapes of a robot at joint positions (rad or m), with its root ``at`` a pose.

    It is None without shapes. The second value is the number of meshes of unknown size, which are not in it.
    """
    boxes, unknown, root = list[Bounds](), 0, at.transform()
    places = [(name, root.then(place)) for name, place in robot.poses_in_root(dict(positions)).items()]
    for shape, there in ((shape, there) for name, there in places for shape in getattr(robot.link[name], purpose)):
        if isinstance(shape.geometry, model.Mesh):
            points, frame = clouds(shape.geometry), there.then(shape.pose.transform())
            a, b, c = shape.geometry.scale
            placed = [frame.apply((a * x, b * y, c * z)) for x, y, z in points or ()]
            unknown += points is None
            boxes += [Bounds(*(tuple(map(end, zip(*placed, strict=True))) for end in (min, max)))] if placed else []
            continue
        far = reach_along(shape, there)
        lower, upper = (
            (sign * far((sign, 0.0, 0.0)), sign * far((0.0, sign, 0.0)), sign * far((0.0, 0.0, sign)))
            for sign in (-1.0, 1.0)
        )
        boxes += [Bounds(lower, upper)] if lower[0] <= upper[0] else []
    return reduce(Bounds.join, boxes) if boxes else None, unknown

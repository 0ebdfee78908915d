"""Names, groups and contact bits of bodies and geoms in a generated MJCF, joint ranges, and the home pose.

Two geoms can collide in MuJoCo if ``contype`` of one and ``conaffinity`` of the other have a common bit. A shape
without ``contact`` bits has bit 1 in both, and so does the floor of a scene. If a robot sets no bits, the wheels of its
drive collide only with the floor, because wheels and rollers overlap with their hubs and arches.

A height map is written as boxes or as a height field. A height field has elevations at grid points, relative to the
lowest point; each point gets the height of its highest adjacent cell, so that the field encloses the boxes.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Sequence
from functools import reduce
from itertools import product
from typing import NamedTuple

from rosorin_compile import model
from rosorin_compile.model.bounds import Bounds, reach_along
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.mesh_vertices import Clouds
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.shape import MERGED
from rosorin_compile.source.cache import of_robot

WORLD = "world"  # the root body of MuJoCo
# Attributes, besides the geoms, of a <pair> that only enables a contact (condim 1: without friction).
TOUCHES: tuple[dict[str, str], ...] = ({}, {"condim": "1"})

# Suffixes of the MuJoCo joints that represent one planar or floating joint, as in MuJoCo's URDF importer.
PLANAR = ("_TX", "_TY", "_RZ")
FLOATING = ("_TX", "_TY", "_TZ", "_R")

# The default stiffness of the equality constraint of a mimic joint.
STIFF = {"solref": (0.005, 1.0), "solimp": (0.95, 0.99, 0.001)}
# Suffixes of the names of the MJCF default classes, which ``Classes`` creates.
VISUAL, COLLISION = "visual", "collision"
WHEEL = "wheel_collision"  # collision geoms of wheels, which collide only with the floor (``ContactBits``)
# Collision geoms of links without visuals. They are in the group of the visuals, so that viewers show them.
SHOWN, SHOWN_WHEEL = "shown_collision", "shown_wheel_collision"
FRAME = "frame"  # sites at link frames, which viewers draw as dots when group 4 is enabled
CLASSES = (VISUAL, COLLISION, WHEEL, SHOWN, SHOWN_WHEEL, FRAME)

VISUAL_GROUP, COLLISION_GROUP, FRAME_GROUP = 2, 3, 4


def no_clouds(mesh: model.Mesh) -> None:
    """Return None for every mesh; used as ``Clouds`` by callers without mesh files."""


def body_name(robot: model.Robot, link: str) -> str:
    """Return the name of the MuJoCo body of a link: the name of the link, or a variant if MuJoCo reserves it."""
    if link == robot.root and robot.root_in_world.world:
        return WORLD
    name = link if link != WORLD else f"{WORLD}_link"
    return free_name(name, {*robot.link, *(edge.child for edge in robot.edges)} if link == WORLD else ())


def free_name(name: str, taken: Container[str]) -> str:
    """Append underscores to a name until it is not in ``taken``."""
    while name in taken:
        name += "_"
    return name


def reference(joint: model.Joint) -> float:
    """Return the position (rad or m) of a joint in MuJoCo's initial configuration (``ref``)."""
    value = joint.mjcf.get("ref", 0.0) if joint.moves else 0.0
    return value if isinstance(value, (int, float)) else 0.0


def shift_polynomial(coefficients: Sequence[float], by: float) -> list[float]:
    """Return the coefficients of p(x + by) as a polynomial in x, lowest order first.

    >>> shift_polynomial([1, 2, 3], 1)
    [6, 8, 3]
    """
    made = list(coefficients)
    for lowest in range(len(made)):
        for place in range(len(made) - 2, lowest - 1, -1):
            made[place] += by * made[place + 1]
    return made


def is_free(robot: model.Robot, joint: model.Joint) -> bool:
    """Return True if a joint is floating and its parent is the world, so that it can be a free joint in MuJoCo."""
    return joint.type == "floating" and robot.root_in_world.world and joint.parent == robot.root


@of_robot
def weld_groups(robot: model.Robot) -> dict[str, list[str]]:
    """Map the topmost link of each rigid group (links joined by fixed joints) to the links of the group, in order."""
    top, groups = dict[str, str](), dict[str, list[str]]()
    for name in (link.name for link in robot.walk()):
        joint = robot.joint_to.get(name)
        top[name] = top[joint.parent] if joint is not None and joint.is_fixed else name
        groups.setdefault(top[name], []).append(name)
    return groups


class Mask(NamedTuple):
    """The contact bits of a geom in MuJoCo."""

    contype: int = 1
    conaffinity: int = 1

    def meets(self, other: Mask) -> bool:
        return bool(self.contype & other.conaffinity or other.contype & self.conaffinity)

    def attributes(self) -> dict[str, str]:
        return {"contype": str(self.contype), "conaffinity": str(self.conaffinity)}


BITS = ("contype", "conaffinity")
USUAL, ROLLS, BESIDE_WHEELS = Mask(), Mask(1, 0), Mask(3, 2)


class ContactBits:
    """The contact bits of all collision shapes. If ``implied`` is true, wheels collide only with the floor."""

    def __init__(self, robot: model.Robot, implied: bool) -> None:
        self.rolling = rolling_links(robot) if implied else frozenset[str]()
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
def rolling_links(robot: model.Robot) -> frozenset[str]:
    """Return all wheels with their child links, or an empty set if the description sets contact bits."""
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
_THIN = 1e-5  # m: written instead of a height of zero, which MuJoCo rejects


class Field(NamedTuple):
    """A MuJoCo height field: ``size`` as in MJCF (m), and heights (m) above its lowest point, row by row."""

    rows: int
    columns: int
    size: tuple[float, float, float, float]
    elevation: tuple[float, ...]
    pose: model.Pose


def has_volume(geometry: model.Geometry) -> bool:
    """Return True if all sizes of a geometry are above zero, as MuJoCo requires; a mesh may have a negative scale."""
    return all(geometry.scale) if isinstance(geometry, model.Mesh) else all(size > 0 for size in half_sizes(geometry))


def half_sizes(geometry: model.Geometry) -> tuple[float, ...]:
    """Return the sizes (m) of a primitive as in MuJoCo: half extents, radii, or radius and half length."""
    if isinstance(geometry, model.Box):
        x, y, z = geometry.size
        return (x / 2, y / 2, z / 2)
    if isinstance(geometry, (model.Cylinder, model.Capsule)):
        return (geometry.radius, geometry.length / 2)
    if isinstance(geometry, model.Ellipsoid):
        return geometry.radii
    return (geometry.radius,) if isinstance(geometry, model.Sphere) else ()


def form_of(output: model.Output) -> str:
    """Return the output option ``height_maps``: "hfield", or a method to split height maps into boxes."""
    return str(output.options.get("height_maps", MERGED))


def numbered_solids(link: model.Link, purpose: str, form: str) -> Iterator[tuple[int, model.Shape]]:
    """Yield (number from 1, shape) for each geom of a link; ``form`` is the option ``height_maps``."""
    shapes = link.visual if purpose == VISUAL else link.collision
    yield from enumerate((one for shape in shapes for one in ((shape,) if form == HFIELD else shape.solids(form))), 1)


def collision_solids(link: model.Link, output: model.Output) -> Sequence[model.Shape] | None:
    """Return the shapes of the collision geoms of a link, or None if one of them is a height field."""
    form = form_of(output)
    if form == HFIELD and any(len(shape.solids()) > 1 for shape in link.collision):
        return None
    return [solid for shape in link.collision for solid in shape.solids(form) if has_volume(solid.geometry)]


def field_of(shape: model.Shape, grid: model.HeightMap) -> Field:
    """Convert a height map to a height field in the frame of its link."""
    tops: dict[tuple[int, int], float] = {}
    count, across, boxes = len(grid.heights), len(grid.heights[0]), grid.boxes()
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


def range_of(joint: model.Joint) -> tuple[float, float] | None:
    """Return the range (rad or m) of a joint, from -pi to pi if it is continuous.

    Return None for a fixed joint, a mimic joint and a prismatic joint without limits.
    """
    limit = joint.limit
    if not joint.moves or joint.mimic is not None:
        return None
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        return limit.lower, limit.upper
    return None if joint.type == "prismatic" else (-math.pi, math.pi)


def leader_of(robot: model.Robot, joint: model.Joint) -> model.Joint:
    """Return the end of the chain of mimic joints that starts at ``joint``, or ``joint`` if it is not a mimic joint."""
    while joint.mimic is not None:
        joint = robot.joint[joint.mimic.joint]
    return joint


def home_of(robot: model.Robot) -> JointPose:
    """Return the pose "home" of the description; by default, each joint is as close to zero as its limits allow."""
    named = next((pose for pose in robot.poses if pose.name == HOME), None)
    return JointPose(HOME, nearest_to_zero(robot)) if named is None else named


def nearest_to_zero(robot: model.Robot) -> dict[str, float]:
    """Return the limit (rad or m) nearest to zero for each joint whose limits exclude zero."""
    measured = [joint for joint in robot.joints if joint.limit and not {"lower", "upper"} & set(joint.limit.stand_ins)]
    ranges = {joint.name: range_of(joint) or (0.0, 0.0) for joint in measured}
    return {name: low if low > 0.0 else high for name, (low, high) in ranges.items() if low < high and low * high > 0.0}


def resting_pose(robot: model.Robot, pose: JointPose, clouds: Clouds = no_clouds) -> model.Pose:
    """Return the world pose of the root link of a robot with a free base.

    Use the base pose in ``pose`` or else the root pose in the description. If neither is set, the robot is upright
    with its lowest collision shape at z = 0, or with its root at the origin if the size of a mesh is unknown.
    ``clouds`` returns the vertices of a mesh.
    """
    if pose.base is not None:
        return pose.base
    if robot.root_in_world.placed:
        return robot.root_in_world.pose
    bounds, meshes = reach(robot, tuple(pose.positions.items()), "collision", IDENTITY, clouds)
    return IDENTITY if bounds is None or meshes else model.Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], 9)))


@of_robot
def reach(
    robot: model.Robot, positions: Iterable[tuple[str, float]], purpose: str, at: model.Pose, clouds: Clouds
) -> tuple[Bounds | None, int]:
    """Return (bounding box in m, number of meshes of unknown size, which the box omits) of a robot.

    The joints are at ``positions`` (rad or m), the root link at ``at``. ``purpose`` is "visual" or "collision", and
    ``clouds`` returns the vertices of a mesh. The box is None if no shape has a known size.
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
        if isinstance(shape.geometry, model.Sphere):
            (x, y, z), radius = there.apply(shape.pose.xyz), shape.geometry.radius
            boxes.append(Bounds((x - radius, y - radius, z - radius), (x + radius, y + radius, z + radius)))
            continue
        far = reach_along(shape, there)
        lower, upper = (
            (sign * far((sign, 0.0, 0.0)), sign * far((0.0, sign, 0.0)), sign * far((0.0, 0.0, sign)))
            for sign in (-1.0, 1.0)
        )
        boxes += [Bounds(lower, upper)] if lower[0] <= upper[0] else []
    return reduce(Bounds.join, boxes) if boxes else None, unknown

"""Meshes held against what is said about their links: size, mass, inertia, centre of mass, and the other shapes.

What a link weighs may be that of all that is fixed to it, so a number is only told where it fits neither the link nor
all that is fixed together.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rosorin_compile.model import Inertial, Link, Mesh, Robot, Shape
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of
from rosorin_compile.source.rule_registry import Heading, Rule

from .accepted import apart
from .files import PURPOSES, Meshes, Named, named_meshes
from .overlaps import at_most
from .scene import corners_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "mesh-size",
        "A warning: a mesh is hundreds of times longer than the rest of the robot, or shorter than a millimetre: it "
        "was drawn in another unit.",
        "`scale: [0.001, 0.001, 0.001]` makes metres of millimetres.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-mass",
        "A warning: the mass of a link is more than its meshes could weigh if they were of osmium, or less than air.",
        "Check the unit of the mass, and the scale of the mesh.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-inertia",
        "A warning: the inertia of a link is larger than that of its mass at the far end of its meshes, or less than a "
        "hundredth of what they have with even density.",
        "Compute it anew: `inertia: {of: collision}`, or from the CAD program, about the centre of mass and in kg*m^2.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-centre-of-mass",
        "A warning: the centre of mass of a link is outside the box around its shapes.",
        "Check `xyz` of the inertial: it is seen from the frame of the link, in metres.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-apart",
        "A warning: the collision shapes of a link are not where its visuals are.",
        "Check the `xyz`, `rpy` and `scale` of both.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-not-closed",
        "A note: collision meshes are inside out or have holes, so that they have no volume of their own. Simulators "
        "take their hulls.",
        "Close the holes in the program that made them.",
        Heading.PHYSICS,
    ),
)

LONGEST_PART = 20.0  # m: no part of a robot is longer
SHORTEST_PART = 1e-3
TIMES = 200.0  # longer than all else in the robot: millimetres are 1,000 times, and parts are not all of a size
HEAVIEST, LIGHTEST = 25_000.0, 1.0  # kg/m^3: osmium has 22,600, air 1.2
SMALL_INERTIA = 0.01  # of that of the hull with even density
FAR_INERTIA = 1.2  # of that of all mass at the farthest corner
OUTSIDE = 0.1  # of the longest side of the box, beyond which a centre of mass is outside
APART = 0.25  # of the longest side: so far the boxes of what collides and of what is seen may be apart
_SHOWN = 5


def diagnose_meshes(case: Case, meshes: Meshes) -> Iterator[Diagnostic]:
    """Yield what is wrong with the meshes that were read."""
    named = list(named_meshes(case))
    strange: set[str] = set()
    sizes: dict[Mesh, Diagnostic] = {}
    for one in named:
        for found in _sizes(case, meshes, one, named):
            strange.add(one.link)
            sizes.setdefault(one.mesh, found)
    yield from at_most(case, list(sizes.values()), "of this kind")
    top = _tops(case.robot)
    with_meshes = dict.fromkeys(one.link for one in named if meshes.of(one.mesh) is not None)
    for name in with_meshes:
        if name in strange:
            continue  # one cause, one message
        fixed = [link for link in case.robot.links if top[link.name] == top[name]]
        yield from _inertial(case, meshes, case.robot.link[name], fixed)
        yield from _apart(case, meshes, case.robot.link[name])
    yield from _open(case, meshes, named)


def _tops(robot: Robot) -> dict[str, str]:
    """Return the topmost link that each link is fixed to."""
    top: dict[str, str] = {}
    for link in robot.walk():
        joint = robot.joint_to.get(link.name)
        top[link.name] = top[joint.parent] if joint is not None and joint.is_fixed else link.name
    return top


def _sizes(case: Case, meshes: Meshes, one: Named, named: Sequence[Named]) -> Iterator[Diagnostic]:
    """Yield a warning about a mesh that is of another size than the rest of the robot."""
    loaded = meshes.of(one.mesh)
    if loaded is None:
        return
    path = case.link(one.link, one.purpose, one.number, "mesh", "scale" if one.mesh.scale != (1, 1, 1) else "file")
    rest = _rest(case.robot, meshes, one, named)
    longest = loaded.longest
    what = f'the mesh {one.mesh.file.rpartition("/")[2]} of link "{one.link}" is {float(f"{longest:.3g}"):.6g} m long'
    if longest > LONGEST_PART or (rest > SHORTEST_PART and longest > TIMES * rest):
        than = f", {longest / rest:,.4g} times as long as all else in the robot" if longest > TIMES * rest > 0 else ""
        message, help = f"{what}{than}: that looks like millimetres", "scale: [0.001, 0.001, 0.001]"
    elif longest < SHORTEST_PART:
        message, help = f"{what}: that looks shrunk by 1,000", "check the scale, and the unit that it was exported in"
    else:
        return
    made = case.problem("mesh-size", message, path, help, severity=WARNING)
    yield replace(made, numbers=(("longest", longest), ("rest", rest)))


def _rest(robot: Robot, meshes: Meshes, one: Named, named: Sequence[Named]) -> float:
    """Return the longest thing (m) in a robot besides its meshes: a primitive, or the way from a joint to the next."""
    ways = [math.dist((0, 0, 0), joint.origin.xyz) for joint in robot.joints]
    solids = [solid for link in robot.links for shape in link.collision for solid in shape.solids()]
    sides = [max(_sides(meshes, solid)) for solid in solids if not isinstance(solid.geometry, Mesh)]
    others = [
        loaded.longest for other in named if other.mesh.file != one.mesh.file and (loaded := meshes.of(other.mesh))
    ]
    middle = sorted(others)[len(others) // 2 : len(others) // 2 + 1]
    return max([*ways, *sides, *middle], default=0.0)


def _sides(meshes: Meshes, shape: Shape) -> tuple[float, ...]:
    corners = corners_of(shape, meshes)
    return (0.0,) if corners is None else tuple(corners.max(axis=0) - corners.min(axis=0))


def _inertial(case: Case, meshes: Meshes, link: Link, fixed: Sequence[Link]) -> Iterator[Diagnostic]:
    """Yield what does not fit about the mass of a link with meshes; ``fixed`` are all links that are fixed to it."""
    inertial = link.inertial
    if inertial is None or inertial.mass <= 0:
        return
    points = _points(case.robot, meshes, link, fixed)
    strange = _strange(meshes, link, fixed)
    if strange:
        yield _mass(case, link, inertial.mass, strange)
    elif points is not None:
        yield from _centre(case, link, inertial, points)
        yield from _moments(case, meshes, link, inertial, points)


def _strange(meshes: Meshes, link: Link, fixed: Sequence[Link]) -> float:
    """Return the volume (m^3) that does not fit the mass of a link, nor that of all that is fixed to it; 0 if one does.

    Few spheres where a foot touches the floor are no foot: too heavy is what is so for collision and visual shapes.
    """
    weights = [sum(one.inertial.mass for one in links if one.inertial) for links in ([link], fixed)]
    volumes = [[_volume(meshes, links, purpose) for links in ([link], fixed)] for purpose in PURPOSES]
    known = [own for own in volumes if own[0] > 0]
    if known and all(mass > HEAVIEST * volume for own in known for mass, volume in zip(weights, own, strict=True)):
        return max(own[0] for own in known)
    if known and all(mass < LIGHTEST * volume for own in known for mass, volume in zip(weights, own, strict=True)):
        return min(own[0] for own in known)
    return 0.0


def _volume(meshes: Meshes, links: Iterable[Link], purpose: str) -> float:
    """Return the volume (m^3) of the collision or visual shapes of links, of meshes that of their hulls."""
    total = 0.0
    for shape in (shape for link in links for shape in getattr(link, purpose)):
        if isinstance(shape.geometry, Mesh):
            loaded = meshes.of(shape.geometry)
            total += loaded.hull.volume if loaded and loaded.hull else 0.0
        else:
            total += shape.volume
    return total


def _mass(case: Case, link: Link, mass: float, volume: float) -> Diagnostic:
    density = mass / volume
    than = "no material is as heavy" if density > HEAVIEST else "less than air"
    message = (
        f'link "{link.name}" weighs {mass:.6g} kg, and the hull of its shapes has'
        f" {float(f'{1000 * volume:.3g}'):.6g} litres: that is {density:,.3g} kg/m^3, {than}"
    )
    help = "check the unit of the mass (grams?) and the scale of the mesh (millimetres?)"
    made = case.problem("mesh-mass", message, case.link(link.name, "inertial", "mass"), help, severity=WARNING)
    return replace(made, numbers=(("mass", mass), ("volume", volume)))


def _points(robot: Robot, meshes: Meshes, link: Link, fixed: Sequence[Link]) -> Floats | None:
    """Return the corners (n, 3) of all shapes of links that are fixed to each other, in the frame of one of them."""
    import numpy as np

    poses = robot.poses_in_root({})
    back = poses[link.name].inverse()
    made = []
    for one in fixed:
        way = back.then(poses[one.name])
        for solid in (solid for shape in (*one.collision, *one.visual) for solid in shape.solids()):
            corners = corners_of(solid, meshes)
            if corners is not None:
                made.append(corners @ np.array(way.rows).T + np.array(way.xyz))
    return np.concatenate(made) if made else None


def _centre(case: Case, link: Link, inertial: Inertial, points: Floats) -> Iterator[Diagnostic]:
    import numpy as np

    lower, upper = points.min(axis=0), points.max(axis=0)
    centre = np.array(inertial.pose.xyz)
    beyond = float(np.maximum(lower - centre, centre - upper).max())
    if beyond <= OUTSIDE * float((upper - lower).max()):
        return
    message = f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside the box around its shapes'
    help = "xyz of the inertial is seen from the frame of the link, in metres"
    path = case.link(link.name, "inertial", "xyz")
    made = case.problem("mesh-centre-of-mass", message, path, help, severity=WARNING)
    yield replace(made, numbers=(("beyond", beyond),))


def _moments(case: Case, meshes: Meshes, link: Link, inertial: Inertial, points: Floats) -> Iterator[Diagnostic]:
    import numpy as np

    largest = inertial.principal_moments[2]
    if largest <= 0:
        return
    reach = float(np.linalg.norm(points - np.array(inertial.pose.xyz), axis=1).max())
    gyration = math.sqrt(largest / inertial.mass)
    hull = [
        loaded.hull for loaded in (meshes.of(one.mesh) for one in named_meshes(case) if one.link == link.name) if loaded
    ]
    own = max((_even(one.corners) for one in hull if one), default=0.0) * inertial.mass
    if gyration > FAR_INERTIA * reach:
        message = (
            f'the inertia of link "{link.name}" is too large: {inertial.mass:.6g} kg would sit'
            f" {float(f'{gyration:.3g}'):.6g} m away from the centre of mass, and its shapes reach"
            f" {float(f'{reach:.3g}'):.6g} m"
        )
    elif own and largest < SMALL_INERTIA * own:
        message = (
            f'the inertia of link "{link.name}" is too small: its largest moment is {largest:.6g} kg*m^2, and'
            f" {inertial.mass:.6g} kg in the hull of its mesh have {float(f'{own:.3g}'):.6g} kg*m^2"
        )
    else:
        return
    help = "inertia is about the centre of mass, in kg*m^2; inertia: {of: collision} computes it for primitives"
    path = case.link(link.name, "inertial", "inertia")
    made = case.problem("mesh-inertia", message, path, help, severity=WARNING, within=True)
    yield replace(made, numbers=(("largest", largest), ("mass", inertial.mass)))


def _even(corners: Floats) -> float:
    """Return the largest moment of a convex body of even density and mass 1 about its middle (m^2)."""
    import trimesh

    hull = trimesh.convex.convex_hull(corners)
    return float(max(hull.principal_inertia_components)) / float(hull.volume)


def _apart(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    """Yield a warning where the collision shapes of a link are not where its visuals are."""
    import numpy as np

    boxes = []
    for purpose in PURPOSES:
        solids = [solid for shape in getattr(link, purpose) for solid in shape.solids()]
        corners = [found for found in (corners_of(solid, meshes) for solid in solids) if found is not None]
        if not corners or len(corners) < len(solids):
            return
        every = np.concatenate(corners)
        boxes.append((every.min(axis=0), every.max(axis=0)))
    (low, high), (lower, upper) = boxes
    between = float(np.linalg.norm((low + high) / 2 - (lower + upper) / 2))
    longest = float(max((upper - lower).max(), (high - low).max()))
    gap = float(np.maximum(low - upper, lower - high).max())
    if gap <= APART * longest:
        return
    message = (
        f'the collision shapes of link "{link.name}" have their middle {1000 * between:.1f} mm away from that of its'
        f" visuals, and do not touch them"
    )
    path = case.link(link.name, "collision", 0)
    related = [case.related("the visual", case.link(link.name, "visual", 0))]
    made = case.problem(
        "mesh-apart", message, path, "check xyz, rpy and scale of both", related=related, severity=WARNING
    )
    yield replace(made, numbers=(("between", between),))


def _open(case: Case, meshes: Meshes, named: Sequence[Named]) -> Iterator[Diagnostic]:
    """Yield a note on the collision meshes that have no inside."""
    holes: dict[str, Named] = {}
    turned: dict[str, Named] = {}
    for one in named:
        loaded = meshes.of(one.mesh) if one.purpose == "collision" else None
        if loaded is None:
            continue
        file = one.mesh.file.rpartition("/")[2]
        if not loaded.is_closed:
            holes.setdefault(file, one)
        elif loaded.surface.volume < 0:
            turned.setdefault(file, one)
    for every, what in ((holes, "not closed"), (turned, "inside out")):
        taken, left = apart(case, "mesh-not-closed", every, lambda file: (every[file].link,))  # noqa: B023 - used at once
        yield from taken
        files = {file: every[file] for file in left}
        if files:
            one = next(iter(files.values()))
            names = first_of(list(files), _SHOWN)
            verb = "mesh is" if len(files) == 1 else "meshes are"
            message = f"{len(files)} collision {verb} {what}: {names}; simulators take the hull"
            path = case.link(one.link, one.purpose, one.number, "mesh", "file")
            help = "close it in the program that made it" if every is holes else "turn its faces round"
            yield replace(case.problem("mesh-not-closed", message, path, help, severity=NOTE), related=(), of=())

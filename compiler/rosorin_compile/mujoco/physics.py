"""Check meshes (size, mass, holes) and collisions between links, at rest and while joints move.

Adjacent links overlap at their joint in most robots, so a single note lists them. Each joint is moved alone over its
range, from zero and from each named pose. If it moves a link deep into an adjacent link over much of the range, an axis
or an origin is probably wrong, which is a warning. A smaller collision is a note, because limits are often too wide.
"""

import math
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.language.suppressions import is_accepted
from rosorin_compile.model import Joint, Link, Mesh
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import acceptable, apply_acceptances
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, MissingPackages, first_of, has_errors, quote
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import is_installed
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.wording import count_of, phrase

from .mjcf.bodies import nearest_to_zero, range_of, weld_groups
from .solids import Meshes, MeshShape, Overlap, Pair, Positions, Scene, Solid, read_meshes, solids_of

# Required modules, and the package to install with pip for each of them.
_NEEDED = {"mujoco": "'mujoco>=3.12'", "numpy": "numpy", "scipy": "scipy", "trimesh": "trimesh", "collada": "pycollada"}
_LONGEST, _SHORTEST = 20.0, 1e-3  # m: plausible lengths of a link
_TIMES = 200.0  # largest plausible length relative to the other links; a mesh in millimetres is 1,000 times too long
_HEAVIEST, _LIGHTEST = 25_000.0, 1.0  # kg/m^3, plausible densities: osmium has 22,600, air 1.2
_FAR_INERTIA = 1.2  # largest radius of gyration, relative to the distance from the centre of mass to the farthest point
_OUTSIDE = 0.1  # tolerance for a centre of mass outside the bounding box, relative to its longest side
_APART = 0.25  # largest gap between the bounding boxes of collision shapes and visuals, relative to the longest side

_MOST_INSIDE = 0.9  # share of the volume of a link that must be inside another link to count as enclosed
_CORNER = 0.2  # share of the volume of a link; smaller overlaps of adjacent links are normal
_SHOWN = 5  # maximum number of names in a note
_STEP, _MOST_STEPS, _SLIDE_STEPS = math.radians(5), 72, 24  # step (rad) and maximum number of steps; steps if prismatic
_MOST_STATES = 20_000  # maximum number of states for all joints; above it, steps become larger
_GROWTH = 0.3  # minimum share of the volume of the moved link inside the adjacent link, for a warning
_BLOCKED = 0.25  # share of the joint range in collision; if it is smaller, probably just a limit is too wide


@dataclass(frozen=True)
class CheckedPhysics:
    """The result of ``check_physics`` for one robot."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether there is no error; the exit code is 0 where all are fine"]
    looked_at: Annotated[str, "poses, joints and meshes in words; empty if the description has errors"]
    diagnostics: tuple[Diagnostic, ...] = ()


def missing_packages() -> str:
    """Return the names of missing packages, separated by spaces as for pip, or "" if all are installed."""
    return " ".join(pip_name for name, pip_name in _NEEDED.items() if not is_installed(name))


def require(command: str) -> None:
    """Raise MissingPackages, with the name of the command, if a package for checks in MuJoCo is missing."""
    if missing := missing_packages():
        raise MissingPackages(f"{command} needs what is not installed: pip install {missing}")


def check_physics(
    robot: FilePath | Request, arguments: Values = None, packages: Packages = None, *, trust: bool = False
) -> CheckedPhysics:
    """Find links that collide at rest or while joints move, and implausible masses, inertias and meshes, with MuJoCo.

    Raises MissingPackages if MuJoCo or a package that reads meshes is not installed.
    """
    require("check physics")
    import numpy as np

    request = Request.from_arguments(robot, arguments, packages, trust=trust)
    description, understood = request.description, request.understand()
    case, looked_at = understood.case, ""
    found = [one for one in understood.diagnostics if one.severity == "error"]
    if case is not None:
        files = Places(description.path, description.outputs, request.packages, os.environ)
        # Other rules report the huge numbers that numpy warns about.
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            shapes, meshes, found = read_meshes(case, files.meshes(case.tree, case.robot.outputs))
            found += [*_check_meshes(case, shapes, meshes), *check_overlaps(case, Scene(case.robot, meshes))]
        found = arrange(apply_acceptances(case, found, "physics"))
        joints = sum(range_of(joint) is not None for joint in case.robot.joints)
        count, of_meshes = len(case.robot.poses), len({shape.mesh.file for shape in shapes})
        ranges = [f"the ranges of {count_of(joints, 'joint')}"] * bool(joints)
        of_poses, of_files = [count_of(count, "pose")] * bool(count), [count_of(of_meshes, "mesh")] * bool(of_meshes)
        looked_at = phrase([*of_poses, "zero", *ranges, *of_files])
    return CheckedPhysics(description.name, str(description.path), not has_errors(found), looked_at, tuple(found))


class OverlapFinder:
    """Finds overlapping links for the viewer. The first call of ``pairs`` is slow, because it reads the meshes."""

    def __init__(self, case: Case, files: Mapping[str, Path]) -> None:
        self.case, self.files = case, files
        self.scene: Scene | None = None
        self.lacking = missing_packages

    def pairs(self, positions: Mapping[str, Any]) -> list[list[str]]:
        """Return the pairs of non-adjacent links that overlap at joint positions (rad or m)."""
        if self.scene is None:
            _, meshes, _ = read_meshes(self.case, self.files)
            self.scene = Scene(self.case.robot, meshes)
        return [list(pair) for pair in next(self.scene.overlaps([positions])) if self.scene.joint_of(pair) is None]


def _check_meshes(case: Case, shapes: Sequence[MeshShape], meshes: Meshes) -> Iterator[Diagnostic]:
    read = [shape for shape in shapes if shape.mesh in meshes]
    skipped = {shape.link for shape in shapes if shape.mesh not in meshes}
    boxes = [bounds_of([shape]) for link in case.robot.links for shape in link.collision]
    sizes = [*(math.dist((0, 0, 0), one.origin.xyz) for one in case.robot.joints), *(max(b.size) for b in boxes if b)]
    wrong_size, holes = dict[Mesh, Diagnostic](), dict[str, Member]()
    for shape in read:
        surface, file = meshes[shape.mesh], shape.mesh.file.rpartition("/")[2]
        others = sorted(other.extents.max() for mesh, other in meshes.items() if mesh.file != shape.mesh.file)
        rest = max([*sizes, *others[len(others) // 2 : len(others) // 2 + 1]], default=0.0)
        longest = float(surface.extents.max())
        is_long = longest > _LONGEST or (rest > _SHORTEST and longest > _TIMES * rest)
        if is_long or longest < _SHORTEST:
            key = "scale" if shape.mesh.scale != (1, 1, 1) else "file"
            looks = "looks like millimetres" if is_long else "looks shrunk by 1,000"
            message = f'the mesh {file} of link "{shape.link}" is {longest:.3g} m long: that {looks}'
            path = case.link(shape.link, shape.purpose, shape.number, "mesh", key)
            wrong_size.setdefault(shape.mesh, case.problem("mesh-size", message, path))
            skipped.add(shape.link)
        if shape.purpose == "collision" and not (surface.is_watertight and surface.volume >= 0):
            path = case.link(shape.link, shape.purpose, shape.number, "mesh", "file")
            holes[file] = Member((shape.link,), file, path)
    yield from wrong_size.values()
    for name in dict.fromkeys(shape.link for shape in read if shape.link not in skipped):
        yield from _check_link(case, meshes, case.robot.link[name])
    message = "collision meshes that are not closed, or inside out ({count}): {names}; simulators take the hull"
    yield from note(case, "mesh-not-closed", holes.values(), message)


def _check_link(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    import numpy as np

    group = next(group for group in weld_groups(case.robot).values() if link.name in group)
    fixed, poses = [one for one in case.robot.links if one.name in group], case.robot.poses_in_root({})

    def solids(links: Sequence[Link], *purposes: str) -> list[Solid]:
        return [s for one in links for what in purposes for s in solids_of(getattr(one, what), one.name, meshes)]

    def corners(links: Sequence[Link], *purposes: str) -> Any:
        points = [np.empty((0, 3))]
        for solid in solids(links, *purposes):
            place = poses[link.name].inverse().then(poses[solid.link])
            points.append(solid.in_link(solid.hull.vertices) @ np.array(place.rows).T + np.array(place.xyz))
        return np.concatenate(points)

    inertial, points = link.inertial, corners(fixed, "collision", "visual")
    if inertial is not None and inertial.mass > 0 and len(points):
        densities = []
        purposes = [purpose for purpose in ("collision", "visual") if solids([link], purpose)]
        for purpose, links in product(purposes, ([link], fixed)):
            mass = sum(one.inertial.mass for one in links if one.inertial)
            densities.append(mass / sum(solid.hull.volume for solid in solids(links, purpose)))
        centre, lower, upper = np.array(inertial.pose.xyz), points.min(axis=0), points.max(axis=0)
        beyond = float(np.maximum(lower - centre, centre - upper).max())
        reach = float(np.linalg.norm(points - centre, axis=1).max())
        gyration = math.sqrt(max(0.0, inertial.principal_moments[2]) / inertial.mass)
        if densities and (min(densities) > _HEAVIEST or max(densities) < _LIGHTEST):
            why = "no material is as heavy" if min(densities) > _HEAVIEST else "less than air"
            message = f'link "{link.name}" weighs {inertial.mass:.6g} kg, {densities[0]:,.3g} kg/m^3 in its hull: {why}'
            yield case.problem("mesh-mass", message, case.link(link.name, "inertial", "mass"))
        elif beyond > _OUTSIDE * float((upper - lower).max()):
            message = f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside its shapes'
            yield case.problem("mesh-centre-of-mass", message, case.link(link.name, "inertial", "xyz"))
        elif gyration > _FAR_INERTIA * reach:
            what, where = f"{inertial.mass:.6g} kg would be {gyration:.3g} m away", f"its shapes reach {reach:.3g} m"
            message = f'the inertia of link "{link.name}" is too large: {what} from the centre of mass, and {where}'
            yield case.problem("mesh-inertia", message, case.link(link.name, "inertial", "inertia"), within=True)
    solid, seen = corners([link], "collision"), corners([link], "visual")
    if len(solid) and len(seen):
        gap = np.maximum(solid.min(axis=0) - seen.max(axis=0), seen.min(axis=0) - solid.max(axis=0)).max()
        if gap > _APART * max(np.ptp(solid, axis=0).max(), np.ptp(seen, axis=0).max()):
            message = f'the collision shapes of link "{link.name}" are {1000 * gap:.1f} mm away from its visuals'
            yield case.problem("mesh-apart", message, case.link(link.name, "collision", 0))


class State(NamedTuple):
    """The name of a pose ("" if all joints are at zero), its joint positions (rad or m), and the overlaps of links."""

    name: str
    positions: Positions
    overlaps: Mapping[Pair, Overlap]


class Member(NamedTuple):
    """A finding to summarize in a note: names for which the key "accept" can suppress it, its text and its path."""

    names: tuple[str, ...]
    text: str
    path: TreePath


def note(case: Case, rule: str, members: Iterable[Member], message: str, key: bool = False) -> Iterator[Diagnostic]:
    """Yield one note with all findings, and a separate diagnostic for each finding that the key "accept" suppresses.

    ``message`` is a template with ``{count}`` and ``{names}``. If ``key`` is true, the note points at a YAML key.
    """
    rest: dict[tuple[str, ...], Member] = {}
    for member in members:
        found = Diagnostic(rule, NOTE, "", of=member.names)
        if is_accepted(case.tree, found, acceptable()):
            yield found
        else:  # report only the first finding for each joint
            rest.setdefault(member.names[:1] if rule == "joints-meet-parts" else (*member.names, member.text), member)
    if rest:
        text = message.format(count=len(rest), names=first_of([one.text for one in rest.values()], _SHOWN))
        first = next(iter(rest.values()))
        yield replace(case.problem(rule, text, first.path, severity=NOTE, key=key), related=(), of=())


def check_overlaps(case: Case, scene: Scene) -> Iterator[Diagnostic]:
    """Report links that overlap at rest, and links that collide while a joint moves."""
    poses = [("", nearest_to_zero(case.robot)), *((pose.name, pose.positions) for pose in case.robot.poses)]
    states = [State(name, positions, next(scene.overlaps([positions]))) for name, positions in poses]
    always = set.intersection(*(set(state.overlaps) for state in states))
    ranges = {joint: ends for joint in case.robot.joints if (ends := range_of(joint)) and ends[0] < ends[1]}
    counts = {
        joint: _SLIDE_STEPS if joint.type == "prismatic" else min(_MOST_STEPS, math.ceil((upper - lower) / _STEP))
        for joint, (lower, upper) in ranges.items()
    }
    factor = min(1.0, _MOST_STATES / max(1, len(states) * sum(counts.values())))
    driven: dict[tuple[str, Pair], Member | Diagnostic | None] = {}
    for (number, state), joint in product(enumerate(states), ranges):
        Progress.step("moving joints", number, len(states))
        steps, start = max(2, round(factor * counts[joint])), state.positions.get(joint.name, 0.0)
        lower, upper = ranges[joint]
        every = [lower + (upper - lower) * index / steps for index in range(steps + 1)]
        # Test positions away from the start, first downwards, then upwards. The start was tested before.
        positions = [p for p in reversed(every) if p < start] + [p for p in every if p > start]
        moved = list(scene.overlaps([{**state.positions, joint.name: position} for position in positions]))
        always = always.intersection(*moved)
        for pair in dict.fromkeys(pair for several in moved for pair in several):
            if driven.get((joint.name, pair)) is None:
                overlaps = dict(zip(positions, moved, strict=True))
                driven[joint.name, pair] = _driven(case, scene, state, joint, overlaps, pair)
    pairs = {pair: [one for one in states if pair in one.overlaps] for state in states for pair in state.overlaps}
    deepest = {pair: max(where, key=lambda one: one.overlaps[pair].depth) for pair, where in pairs.items()}
    designs, hulls = list[Member](), list[Member]()
    for pair in sorted(pairs, key=lambda pair: -deepest[pair].overlaps[pair].depth):
        overlap, at, where = deepest[pair].overlaps[pair], deepest[pair].positions, pairs[pair]
        outer, inner = overlap.solids
        small, large = sorted(pair, key=lambda link: scene.volume[link])
        share, depth = scene.share(small, large, at), f"{1000 * overlap.depth:.1f} mm"
        member = Member(pair, f"{pair[1]} in {pair[0]} by {depth}", _path(case, inner))
        rule, what = "parts-overlap", f'link "{pair[1]}" is {depth} inside link "{pair[0]}"'
        if share >= _MOST_INSIDE and scene.share(small, large, at, exact=True) >= _MOST_INSIDE:
            outer, inner = overlap.solids if inner.link == small else (inner, outer)
            rule, what = "part-inside-part", f'link "{small}" is inside link "{large}" with {share:.0%} of its volume'
        elif pair in always or (scene.joint_of(pair) is not None and share < _CORNER):
            designs.append(member)
            continue
        elif not scene.touches(overlap.solids, at):
            hulls.append(member)
            continue
        # Report the overlap at its likely cause: the pose, the joint between adjacent links, or the shape.
        between, pose = scene.joint_of(pair), where[0].name
        path = ("poses", pose) if pose else case.joint(between, "xyz") if between else _path(case, inner)
        names = quote([state.name for state in where if state.name], _SHOWN)
        places = ["at zero"] * (not pose) + [f"in pose {names}"] * bool(where[-1].name)
        message = f"{what} {' and '.join(places)}: {_name(case, inner)} in {_name(case, outer)}"
        related = _shapes_of(case, *([inner] if pose or between else []), outer)
        yield replace(case.problem(rule, message, path, related=related, key=bool(pose)), of=(inner.link, outer.link))
    message = "links that overlap in every position, or at their joint, as parts of one design do ({count}): {names}"
    yield from note(case, "parts-always-overlap", designs, message, key=True)
    message = "hulls that overlap though their meshes do not touch ({count}): {names}; simulators push them apart"
    yield from note(case, "hulls-overlap", hulls, message, key=True)
    near = [one for one in driven.values() if isinstance(one, Diagnostic)]
    yield from sorted(near, key=lambda one: one.severity != WARNING)
    message = "joints that can each move a link into collision with one that is not adjacent ({count}): {names}"
    yield from note(case, "joints-meet-parts", [one for one in driven.values() if isinstance(one, Member)], message)


def _path(case: Case, solid: Solid) -> TreePath:
    return case.link(solid.link, "collision", solid.number)


def _shapes_of(case: Case, *solids: Solid) -> list[tuple[str, TreePath]]:
    return [(f'the shape of "{solid.link}"', _path(case, solid)) for solid in solids]


def _name(case: Case, solid: Solid) -> str:
    shapes, place = case.robot.link[solid.link].collision, case.stand_in(_path(case, solid))
    geometry = shapes[solid.number].geometry
    if isinstance(geometry, Mesh):
        return f"the hull of {geometry.file.rpartition('/')[2]}{place}"
    name = type(geometry).__name__.replace("Map", " map").lower()
    return name + (f" {solid.number + 1} of {len(shapes)}" if len(shapes) > 1 else "") + place


def _driven(
    case: Case, scene: Scene, state: State, joint: Joint, overlaps: Mapping[float, Mapping[Pair, Overlap]], pair: Pair
) -> Member | Diagnostic | None:
    """Return a finding if a joint moves two links into collision (adjacent links: deeper than at rest), else None."""
    moved, still = pair if pair[0] in scene.robot.subtree(joint.child) else pair[::-1]
    start, is_neighbour, least = state.positions.get(joint.name, 0.0), scene.joint_of(pair) == joint, 0.0

    def at(position: float) -> Positions:
        return {**state.positions, joint.name: position}

    def meet(position: float) -> bool:
        several = overlaps[position] if position in overlaps else next(scene.overlaps([at(position)]))
        return pair in several and (not least or scene.share(moved, still, at(position)) >= least)

    if pair in state.overlaps:
        least = scene.share(moved, still, at(start)) + _GROWTH if is_neighbour else 1.0
    if not (hits := [position for position in overlaps if least < 1 and meet(position)]):
        return None
    far = min(hits, key=lambda position: abs(position - start))
    before = [p for p in (start, *overlaps) if min(start, far) <= p <= max(start, far) and p != far]
    near, beyond = min(before, key=lambda position: abs(position - far)), far
    for _ in range(8):
        middle = (near + beyond) / 2
        near, beyond = (near, middle) if meet(middle) else (middle, beyond)
    angle = f"{round(beyond, 2):.6g} rad ({math.degrees(beyond):.0f} deg)"
    where = f"{float(f'{beyond:.3g}'):.6g} m" if joint.type == "prismatic" else angle
    where += f' in pose "{state.name}"' if state.name else ""
    side = "upper" if far > start else "lower"
    path = case.joint(joint, "limit", side)
    if not is_neighbour:
        return Member((joint.name, still, moved), f"{joint.name} {moved} into {still} from {where}", path)
    inside = max(scene.share(moved, still, at(position)) for position in hits) - max(0.0, least - _GROWTH)
    if inside < _CORNER:
        return None
    tested = hits[:: 1 + len(hits) // 4]  # a few samples, because testing meshes is slow
    is_real = any(scene.touches(overlaps[position][pair].solids, at(position)) for position in tested)
    is_grave = is_real and inside >= _GROWTH and len(hits) >= _BLOCKED * len(overlaps)
    outer, inner = sorted(overlaps[far][pair].solids, key=lambda solid: solid.link == moved)
    message = f'joint "{joint.name}" drives link "{moved}" into link "{still}" from {where} towards its {side} limit, '
    message += f"{len(hits) / len(overlaps):.0%} of its range: {_name(case, inner)} into {_name(case, outer)}"
    related, severity = _shapes_of(case, inner, outer), WARNING if is_grave else NOTE
    return case.problem("joint-through-neighbour", message, path, related=related, severity=severity)

"""Check the physics of one robot: sizes, masses and holes of its meshes, and overlaps at rest and while joints move."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.model import Link, Mesh
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import apply_acceptances
from rosorin_compile.source.diagnostics import Diagnostic, MissingPackages, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.system import is_installed
from rosorin_compile.source.wording import count_of, phrase

from ..mjcf.bodies import weld_groups
from ..rest_pose import range_of
from .overlaps import Member, check_overlaps, note
from .scene import Meshes, MeshShape, Scene, Solid, read_meshes, solids_of

# The packages that are imported, and their names for pip.
_NEEDED = {"mujoco": "'mujoco>=3.12'", "numpy": "numpy", "scipy": "scipy", "trimesh": "trimesh", "collada": "pycollada"}
_LONGEST, _SHORTEST = 20.0, 1e-3  # m: no part of a robot is longer, or shorter
_TIMES = 200.0  # longer than all else in the robot: millimetres are 1,000 times, and parts are not all of a size
_HEAVIEST, _LIGHTEST = 25_000.0, 1.0  # kg/m^3: osmium has 22,600, air 1.2
_FAR_INERTIA = 1.2  # of that of all mass at the farthest corner
_OUTSIDE = 0.1  # of the longest side of the box, beyond which a centre of mass is outside
_APART = 0.25  # of the longest side: the largest gap between the boxes of collision shapes and of visuals


@dataclass(frozen=True)
class LookedAt:
    """The extent of a check: zero and the poses, the joints that were moved over their ranges, the meshes."""

    poses: Annotated[int, "how many named poses; position zero comes on top"]
    joints: Annotated[int, "how many joints, each moved over its range"]
    meshes: Annotated[int, "how many files of meshes"]

    def __str__(self) -> str:
        parts = [count_of(self.poses, "pose")] if self.poses else []
        parts += ["zero"] + ([f"the ranges of {count_of(self.joints, 'joint')}"] if self.joints else [])
        return phrase(parts + ([count_of(self.meshes, "mesh")] if self.meshes else []))


@dataclass(frozen=True)
class CheckedPhysics:
    """The result of the check of one robot."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether there is no error; the exit code is 0 where all are fine"]
    looked_at: Annotated[LookedAt | None, "null if the description has errors"]
    diagnostics: tuple[Diagnostic, ...] = ()


def missing_packages() -> str:
    """Return the packages to install, as arguments of pip; empty if nothing is missing."""
    return " ".join(pip_name for name, pip_name in _NEEDED.items() if not is_installed(name))


def require(command: str) -> None:
    """Raise MissingPackages if a package that a command needs is not installed."""
    if missing := missing_packages():
        raise MissingPackages(f"{command} needs what is not installed: pip install {missing}")


def check_physics(
    robot: FilePath | Request, arguments: Values = None, packages: Packages = None, *, trust: bool = False
) -> CheckedPhysics:
    """Find links that collide at rest or while joints move, and masses that do not fit the meshes, with MuJoCo."""
    require("check physics")
    import numpy as np

    request = Request.of(robot, arguments, packages, trust=trust)
    description, understood = request.description, request.understand()
    case, looked_at = understood.case, None
    found = [one for one in understood.diagnostics if one.severity == "error"]
    if case is not None:
        files = Places(description.path, description.outputs, request.packages, os.environ)
        # numpy warns about huge numbers, which have rules of their own.
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            shapes, meshes, found = read_meshes(case, files.meshes(case.tree, case.robot.outputs))
            found += [*_check_meshes(case, shapes, meshes), *check_overlaps(case, Scene(case.robot, meshes))]
        found = arrange(apply_acceptances(case, found, "physics"))
        joints = sum(range_of(joint) is not None for joint in case.robot.joints)
        looked_at = LookedAt(len(case.robot.poses), joints, len({shape.mesh.file for shape in shapes}))
    return CheckedPhysics(description.name, str(description.path), not has_errors(found), looked_at, tuple(found))


class OverlapFinder:
    """Finds overlapping links for the viewer; the scene in MuJoCo is built at the first request."""

    def __init__(self, case: Case, files: Mapping[str, Path]) -> None:
        """``files`` are the mesh files of the robot by name."""
        self.case, self.files = case, files
        self.scene: Scene | None = None
        self.lacking = missing_packages

    def pairs(self, positions: Mapping[str, Any]) -> list[list[str]]:
        """Return the pairs of links that overlap at joint positions, without neighbours."""
        if self.scene is None:
            _, meshes, _ = read_meshes(self.case, self.files)
            self.scene = Scene(self.case.robot, meshes)
        return [list(pair) for pair in next(self.scene.overlaps([positions])) if self.scene.joint_of(pair) is None]


def _check_meshes(case: Case, shapes: Sequence[MeshShape], meshes: Meshes) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each link or mesh that cannot be right; ``meshes`` are those that could be read."""
    read = [shape for shape in shapes if shape.mesh in meshes]
    skipped = {shape.link for shape in shapes if shape.mesh not in meshes}
    boxes = [bounds_of([shape]) for link in case.robot.links for shape in link.collision]
    sizes = [*(math.dist((0, 0, 0), one.origin.xyz) for one in case.robot.joints), *(max(b.size) for b in boxes if b)]
    wrong_size: dict[Mesh, Diagnostic] = {}
    for shape in read:
        others = sorted(surface.extents.max() for mesh, surface in meshes.items() if mesh.file != shape.mesh.file)
        rest = max([*sizes, *others[len(others) // 2 : len(others) // 2 + 1]], default=0.0)
        longest = float(meshes[shape.mesh].extents.max())
        is_long = longest > _LONGEST or (rest > _SHORTEST and longest > _TIMES * rest)
        if is_long or longest < _SHORTEST:
            file, key = shape.mesh.file.rpartition("/")[2], "scale" if shape.mesh.scale != (1, 1, 1) else "file"
            looks = "looks like millimetres" if is_long else "looks shrunk by 1,000"
            message = f'the mesh {file} of link "{shape.link}" is {longest:.3g} m long: that {looks}'
            path = case.link(shape.link, shape.purpose, shape.number, "mesh", key)
            wrong_size.setdefault(shape.mesh, case.problem("mesh-size", message, path))
            skipped.add(shape.link)
    yield from wrong_size.values()
    for name in dict.fromkeys(shape.link for shape in read):
        if name not in skipped:
            yield from _check_link(case, meshes, case.robot.link[name])
    kinds: dict[str, dict[str, Member]] = {"not closed": {}, "inside out": {}}
    for shape in read:
        surface, file = meshes[shape.mesh], shape.mesh.file.rpartition("/")[2]
        if shape.purpose == "collision" and not (surface.is_watertight and surface.volume >= 0):
            path = case.link(shape.link, shape.purpose, shape.number, "mesh", "file")
            kinds["inside out" if surface.is_watertight else "not closed"][file] = Member((shape.link,), file, path)
    for kind, members in kinds.items():
        message = f"collision meshes that are {kind} ({{count}}): {{names}}; simulators take the hull"
        yield from note(case, "mesh-not-closed", members.values(), message)


def _check_link(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    """Yield warnings about the mass, the inertia and the places of the shapes of a link.

    The mass of a link may be that of all links that are fixed to it: a number is wrong if it fits neither. A mass is
    too large if it is so for the collision and for the visual shapes: a few spheres can stand for a foot.
    """
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
        for purpose in ("collision", "visual"):
            for links in ([link], fixed) if solids([link], purpose) else ():
                mass = sum(one.inertial.mass for one in links if one.inertial)
                densities.append(mass / sum(solid.hull.volume for solid in solids(links, purpose)))
        centre, lower, upper = np.array(inertial.pose.xyz), points.min(axis=0), points.max(axis=0)
        beyond = float(np.maximum(lower - centre, centre - upper).max())
        reach = float(np.linalg.norm(points - centre, axis=1).max())
        gyration = math.sqrt(max(0.0, inertial.principal_moments[2]) / inertial.mass)
        if densities and (min(densities) > _HEAVIEST or max(densities) < _LIGHTEST):
            message = (
                f'link "{link.name}" weighs {inertial.mass:.6g} kg, {densities[0]:,.3g} kg/m^3 in the hull of its'
                f" shapes: {'no material is as heavy' if min(densities) > _HEAVIEST else 'less than air'}"
            )
            yield case.problem("mesh-mass", message, case.link(link.name, "inertial", "mass"))
        elif beyond > _OUTSIDE * float((upper - lower).max()):
            message = f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside its shapes'
            yield case.problem("mesh-centre-of-mass", message, case.link(link.name, "inertial", "xyz"))
        elif gyration > _FAR_INERTIA * reach:
            message = (
                f'the inertia of link "{link.name}" is too large: {inertial.mass:.6g} kg would be {gyration:.3g} m away'
                f" from the centre of mass, and its shapes reach {reach:.3g} m"
            )
            yield case.problem("mesh-inertia", message, case.link(link.name, "inertial", "inertia"), within=True)
    solid, seen = corners([link], "collision"), corners([link], "visual")
    if len(solid) and len(seen):
        gap = np.maximum(solid.min(axis=0) - seen.max(axis=0), seen.min(axis=0) - solid.max(axis=0)).max()
        if gap > _APART * max(np.ptp(solid, axis=0).max(), np.ptp(seen, axis=0).max()):
            message = f'the collision shapes of link "{link.name}" are {1000 * gap:.1f} mm away from its visuals'
            yield case.problem("mesh-apart", message, case.link(link.name, "collision", 0))

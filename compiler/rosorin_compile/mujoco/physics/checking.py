"""Check the physics of one robot: its meshes, overlaps at rest and along the ranges of joints, and how it settles."""

from __future__ import annotations

import os
import warnings

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import settled
from rosorin_compile.source.diagnostics import MissingPackages, arrange
from rosorin_compile.source.installing import is_installed
from rosorin_compile.source.progress import Progress

from . import meshes as mesh_facts
from . import overlaps, rest, sweeps
from .answers import CheckedPhysics, LookedAt
from .files import Meshes, named_meshes
from .overlaps import ZERO, State
from .scene import Scene

NEEDED = ("mujoco", "numpy", "scipy", "trimesh", "collada")
_NAMES = {"collada": "pycollada", "mujoco": "'mujoco>=4'"}


def lacking() -> str:
    """Return the packages to install, as arguments of pip; empty if nothing is missing."""
    return " ".join(_NAMES.get(name, name) for name in NEEDED if not is_installed(name))


def require(command: str) -> None:
    """Raise MissingPackages if a package that a command needs is not installed."""
    if missing := lacking():
        raise MissingPackages(f"{command} needs what is not installed: pip install {missing}")


def check_robot(request: Request) -> CheckedPhysics:
    """Check the physics of a robot. Raises MissingPackages without MuJoCo and the libraries for meshes."""
    require("check physics")
    import numpy as np

    description, understood = request.description, request.understand()
    name, file, case = description.name, str(description.path), understood.case
    if case is None:
        errors = [one for one in understood.diagnostics if one.severity == "error"]
        return CheckedPhysics.of(name, file, None, errors)
    # numpy warns about huge numbers, which have rules of their own.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return _check(name, file, case, request)


def _check(name: str, file: str, case: Case, request: Request) -> CheckedPhysics:
    done = 0
    named = list(named_meshes(case))
    poses = [(ZERO, {}), *((pose.name, pose.positions) for pose in case.robot.poses)]
    joints = sweeps.swept_joints(case.robot)
    # What is done weighs about as much: a mesh, a second, a joint over its range.
    total = len(named) + len(poses) * (1 + len(joints))

    def tick() -> None:
        nonlocal done
        done += 1
        Progress.step("checking the physics", done, total)

    description = request.description
    places = Places(description.path, description.outputs, request.packages, os.environ)
    meshes = Meshes(case, places.meshes(case.tree, case.robot.outputs))
    for one in named:
        meshes.read(one)
        tick()
    found = [*overlaps.at_most(case, meshes.told, "of this kind"), *mesh_facts.diagnose_meshes(case, meshes)]
    scene = Scene(case.robot, meshes)
    states = [State(name, positions, scene.overlaps(positions)) for name, positions in poses]
    starts = [_legal(scene), *states[1:]]
    swept = sweeps.sweep(scene, starts, tick)
    always = swept.always & set(states[0].overlaps)
    found += overlaps.diagnose_overlaps(case, scene, states, always)
    found += sweeps.diagnose_sweeps(case, scene, swept.meetings)
    found += rest.diagnose_rest(case, starts, tick)
    at = LookedAt(len(poses) - 1, len(joints), len({one.mesh.file for one in named}))
    return CheckedPhysics.of(name, file, at, arrange(settled(case, found, "physics")))


def _legal(scene: Scene) -> State:
    """Return zero, or where that is beyond limits what is as near to it as they let."""
    positions = {joint.name: overlaps.nearest(joint) for joint in scene.robot.joints if overlaps.nearest(joint)}
    return State(ZERO, positions, scene.overlaps(positions), bool(positions))

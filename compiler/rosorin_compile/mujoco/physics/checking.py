"""Goes through what there is to check of the physics of a robot, with a bar on the terminal."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic, Progress, arrange
from rosorin_compile.source.installing import is_installed
from rosorin_compile.source.project import Description

from . import meshes as mesh_facts
from . import overlaps, rest, sweeps
from .answers import LookedAt
from .files import Meshes, named_meshes
from .overlaps import ZERO, State
from .scene import Scene

NEEDED = ("mujoco", "numpy", "scipy", "trimesh", "collada")
_NAMES = {"collada": "pycollada", "mujoco": "'mujoco>=4'"}


class Looked(NamedTuple):
    """What was found, and at what was looked."""

    diagnostics: list[Diagnostic]
    at: LookedAt


def lacking() -> str:
    """Return what has to be installed for this, as pip has it; empty if nothing is missing."""
    return " ".join(_NAMES.get(name, name) for name in NEEDED if not is_installed(name))


def look(case: Case, description: Description, packages: Mapping[str, Path]) -> Looked:
    """Return what is wrong with the physics of a robot."""
    import numpy as np

    # Of numbers beyond all robots numpy has much to say; the rules about numbers have told them.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        return _looked(case, description, packages)


def _looked(case: Case, description: Description, packages: Mapping[str, Path]) -> Looked:
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

    places = Places(description.path, description.outputs, packages, os.environ)
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
    return Looked(arrange(case.settled(found, "physics")), at)


def _legal(scene: Scene) -> State:
    """Return zero, or where that is beyond limits what is as near to it as they let."""
    positions = {joint.name: overlaps.nearest(joint) for joint in scene.robot.joints if overlaps.nearest(joint)}
    return State(ZERO, positions, scene.overlaps(positions), bool(positions))

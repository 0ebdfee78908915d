"""Check the physics of one robot: its meshes, and overlaps at rest and along the ranges of joints."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import settled
from rosorin_compile.source.diagnostics import (
    Diagnostic,
    MissingPackages,
    counted,
    has_errors,
    listed,
)
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.system import is_installed

from ..rest_pose import range_of
from .mesh_checks import check_meshes
from .overlaps import check_overlaps
from .scene import Scene
from .solids import mesh_shapes, read_meshes

# The packages that are imported, and what pip calls them.
_NEEDED = {
    "mujoco": "'mujoco>=3.12'",
    "numpy": "numpy",
    "scipy": "scipy",
    "trimesh": "trimesh",
    "collada": "pycollada",
}


@dataclass(frozen=True)
class LookedAt:
    """The extent of a check: zero and the poses, the joints that were moved over their ranges, the meshes."""

    poses: Annotated[int, "how many named poses; position zero comes on top"]
    joints: Annotated[int, "how many joints, each moved over its range"]
    meshes: Annotated[int, "how many files of meshes"]

    def __str__(self) -> str:
        at = [f"the ranges of {counted(self.joints, 'joint')}"] if self.joints else []
        at += [counted(self.meshes, "mesh")] if self.meshes else []
        return listed([counted(self.poses, "pose"), "zero", *at] if self.poses else ["zero", *at])


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


def check_robot(request: Request) -> CheckedPhysics:
    """Check the physics of a robot. Raises MissingPackages without MuJoCo and the libraries for meshes."""
    require("check physics")
    import numpy as np

    description, understood = request.description, request.understand()
    case, looked_at = understood.case, None
    found = [one for one in understood.diagnostics if one.severity == "error"]
    if case is not None:
        files = Places(description.path, description.outputs, request.packages, os.environ)
        # numpy warns about huge numbers, which have rules of their own.
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            shapes = list(mesh_shapes(case))
            meshes, found = read_meshes(case, shapes, files.meshes(case.tree, case.robot.outputs))
            found += [*check_meshes(case, shapes, meshes), *check_overlaps(case, Scene(case.robot, meshes))]
        found = arrange(settled(case, found, "physics"))
        joints = sum(range_of(joint) is not None for joint in case.robot.joints)
        looked_at = LookedAt(len(case.robot.poses), joints, len({shape.mesh.file for shape in shapes}))
    return CheckedPhysics(description.name, str(description.path), not has_errors(found), looked_at, tuple(found))


class OverlapFinder:
    """Finds overlapping links for the viewer; the scene in MuJoCo is built at the first request."""

    def __init__(self, case: Case, files: Mapping[str, Path]) -> None:
        """``files`` are the mesh files of the robot by name."""
        self.case, self.files = case, files
        self.scene: Scene | None = None

    def lacking(self) -> str:
        """Return the packages to install, as arguments of pip; empty if nothing is missing."""
        return missing_packages()

    def pairs(self, positions: Mapping[str, Any]) -> list[list[str]]:
        """Return the pairs of links that overlap at joint positions (rad or m), without neighbours.

        The position of a joint with several coordinates is a sequence.
        """
        if self.scene is None:
            meshes, _ = read_meshes(self.case, list(mesh_shapes(self.case)), self.files)
            self.scene = Scene(self.case.robot, meshes)
        return [list(pair) for pair in self.scene.overlaps(positions) if self.scene.joint_of(pair) is None]

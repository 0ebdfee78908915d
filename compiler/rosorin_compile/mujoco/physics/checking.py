"""Check the physics of one robot: its meshes, overlaps at rest and along the ranges of joints, and how it settles."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Mesh
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import settled
from rosorin_compile.source.diagnostics import (
    ERROR,
    WARNING,
    Diagnostic,
    MissingPackages,
    counted,
    has_errors,
    listed,
)
from rosorin_compile.source.installing import is_installed
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import PHYSICS, Rule

from ..simulate.world import FIXED, Refused, SimulationDiverged, World, describe_joint, mjcf_text, quiet, single_joints
from .mesh_checks import check_meshes
from .overlaps import ZERO, State, check_overlaps, check_sweeps, nearest_to_zero, sweep, swept_joints
from .scene import Scene
from .solids import mesh_shapes, read_meshes

RULES = (
    Rule(
        "explodes-at-rest",
        "Left alone for a second in MuJoCo, the positions of the robot become infinite. A warning where a joint gets "
        "faster than any joint is, or is driven out of its limits.",
        "Look for parts that start inside each other, masses and inertias that are far too small, gains that are far "
        "too large.",
        PHYSICS,
    ),
    Rule(
        "sinks-at-rest",
        "A warning: left alone for a second in MuJoCo, an actuator does not hold its joint against gravity.",
        "Check the mass that it carries, `kp` of the actuator, and the effort of the joint.",
        PHYSICS,
    ),
)

SECONDS = 1.0  # at rest
FASTEST = 300.0  # rad/s or m/s: a light link that hangs without damping gets to 100 rad/s by gravity
SUNK, SUNK_SLIDE = math.radians(10), 0.02  # m
BEYOND = 0.1  # rad or m out of the limits: bounds are soft
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
            looked_at, found = _check(case, files.meshes(case.tree, case.robot.outputs))
        found = arrange(settled(case, found, "physics"))
    return CheckedPhysics(description.name, str(description.path), not has_errors(found), looked_at, tuple(found))


def _check(case: Case, files: Mapping[str, Path]) -> tuple[LookedAt, list[Diagnostic]]:
    shapes, joints = list(mesh_shapes(case)), swept_joints(case.robot)
    poses: list[tuple[str, Mapping[str, float]]] = [
        (ZERO, {}),
        *((one.name, one.positions) for one in case.robot.poses),
    ]
    # The steps weigh about the same: reading a mesh, simulating a second, moving a joint over its range.
    done, total = 0, len(shapes) + len(poses) * (1 + len(joints))

    def tick() -> None:
        nonlocal done
        done += 1
        Progress.step("checking the physics", done, total)

    meshes, found = read_meshes(case, shapes, files, tick)
    found += check_meshes(case, shapes, meshes)
    scene = Scene(case.robot, meshes)
    states = [State(name, positions, scene.overlaps(positions)) for name, positions in poses]
    # Sweeps and simulations start within the limits of all joints.
    legal = {joint.name: position for joint in case.robot.joints if (position := nearest_to_zero(joint))}
    starts = [State(ZERO, legal, scene.overlaps(legal)), *states[1:]]
    meetings, always = sweep(scene, starts, tick)
    found += check_overlaps(case, scene, states, always & set(states[0].overlaps))
    found += check_sweeps(case, scene, meetings)
    with quiet() as mujoco:
        world = _without_meshes(mujoco, case)
        at_rest: dict[tuple[str, str], Diagnostic] = {}
        for state in starts:
            for one in _check_rest(case, state, world) if world is not None else ():
                at_rest.setdefault((one.rule, "".join(one.of)), one)
            tick()
    found += at_rest.values()
    return LookedAt(len(poses) - 1, len(joints), len({shape.mesh.file for shape in shapes})), found


def _without_meshes(mujoco: Any, case: Case) -> World | None:
    """Return the robot held in the world, or None if MuJoCo refuses it, which ``check`` reports.

    Meshes take no part: overlaps of their hulls are reported by ``overlaps``.
    """
    links = []
    for link in case.robot.links:
        primitives = tuple(shape for shape in link.collision if not isinstance(shape.geometry, Mesh))
        links.append(replace(link, collision=primitives, visual=()))
    robot = replace(case.robot, links=tuple(links))
    try:
        return World(mujoco, robot, mjcf_text(robot, None, Templates(), FIXED), FIXED, Path())
    except Refused:
        return None


def _check_rest(case: Case, state: State, world: World) -> Iterator[Diagnostic]:
    """Simulate a second from a state, with actuators that hold it: the robot should stay whole, and in place."""
    joints, fastest, explodes = single_joints(world.robot), (0.0, 0.0, ""), "explodes-at-rest"
    world.reset(state.positions)
    load = {joint.name: float(world.data.joint(joint.name).qfrc_bias[0]) for joint in joints}
    speeds = {joint.name: world.data.joint(joint.name).qvel for joint in joints}
    help = "look for parts that start inside each other, for masses and inertias far too small, for gains far too large"
    try:
        for time in world.run(SECONDS):
            fastest = max([fastest, *((abs(float(speed[0])), time, name) for name, speed in speeds.items())])
    except SimulationDiverged as problem:
        message = f"left alone {state}, after {problem.time:.6g} s: {problem}"
        message += describe_joint(case.robot, problem.joint)
        yield replace(case.problem(explodes, message, ("robot",), help, severity=ERROR), of=())
        return
    speed, time, name = fastest
    if speed > FASTEST:
        joint = case.robot.joint[name]
        message = (
            f'left alone {state}, joint "{name}" gets to {speed:.0f} {joint.unit}/s within {time:.2g} s in MuJoCo'
            f"{describe_joint(case.robot, name)}"
        )
        yield case.problem(explodes, message, case.joint(joint), help, severity=WARNING, key=True)
        return
    for joint in (joint for joint in joints if joint.mimic is None):
        start, end, limit = state.positions.get(joint.name, 0.0), world.position(joint.name), joint.limit
        moved = f"from {round(start, 3):.6g} to {round(end, 3):.6g} {joint.unit} within a second in MuJoCo"
        if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
            low, high = limit.lower - BEYOND, limit.upper + BEYOND
            if low <= start <= high and not low <= end <= high:
                message = f'left alone {state}, joint "{joint.name}" is driven out of its limits, {moved}'
                path = case.joint(joint, "limit")
                yield case.problem(explodes, message, path, help, severity=WARNING, key=True)
                continue
        slides, actuator = joint.type == "prismatic", joint.actuator
        # A part that is pushed out of another one does not move against its load.
        sinks = abs(end - start) > (SUNK_SLIDE if slides else SUNK) and (end - start) * load[joint.name] <= 0
        if sinks and actuator is not None and actuator.holds_position:
            message = (
                f'left alone {state}, joint "{joint.name}" sinks {moved}: it carries {abs(load[joint.name]):.3g}'
                f" {'N' if slides else 'N*m'}, held by kp {actuator.kp or 0.0:.6g}"
            )
            help = "check the mass that it carries, kp of its actuator, and its effort"
            path = case.joint(joint, "actuator")
            yield case.problem("sinks-at-rest", message, path, help, severity=WARNING, key=True)


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

"""rosorin-compile collisions: compute the collision matrix for MoveIt, and write it next to the description."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile import api
from rosorin_compile.cli.console import Console
from rosorin_compile.model import DisabledCollision
from rosorin_compile.mujoco.collisions.matrix import FILE
from rosorin_compile.source.diagnostics import counted, listed
from rosorin_compile.source.project import Description

from .answer import PROBLEMS
from .command import Options, command, flag, path_option, robot_argument, robot_options
from .run import Run

if TYPE_CHECKING:
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix


@command("collisions", exits="0 written or unchanged, 1 errors")
@robot_argument
@path_option("-o", "--output", metavar="FILE", help=f"file to write; default: {FILE} next to the description")
@flag("--force", help="compute again, even if the file is up to date")
@robot_options
def run(options: Options) -> int:
    """Compute the matrix of a robot, and write it."""
    how = "rosorin-compile collisions ROBOT"
    run, description = Run.alone(options, "the matrix of one robot is computed at a time", how, "name its file")
    result = api.collisions(run.request(description), output=options.output, force=options.force)
    if run.show(result):
        return PROBLEMS
    _show(result, run.console, description)
    return run.give(result)


def _show(result: CollisionMatrix, console: Console, description: Description) -> None:
    if not result.written:
        console.say(f"{result.robot}: the collision matrix is that of {result.urdf}; --force computes it")
        return
    if result.touching_hulls:
        console.say(f"checked all the same: {_named(result.touching_hulls)}, whose hulls touch, and not the meshes")
    if result.contradicted:
        console.warn(f"disabled_collisions says Never of {_named(result.contradicted)}, which do collide")
    if result.kept:
        console.say(f"{counted(result.kept, 'pair')} as before: the same shapes, and the same joints between")
    every, found = result.links * (result.links - 1) // 2, len(result.pairs)
    counts = Counter(pair.reason for pair in result.pairs)
    reasons = listed(f"{counts[reason]} {reason}" for reason in DisabledCollision.REASONS if counts[reason]) or "none"
    console.say(f"{result.file}: {counted(every, 'pair')} of links, need no check: {reasons}; {every - found} to check")
    console.say(f"tried: {counted(result.states, 'random state')}, seed {result.seed}")
    included = "" if result.included else f"include: [{Path(result.file).name}] in {description.path}, then "
    console.say(f"next: {included}rosorin-compile all")


def _named(pairs: Sequence[tuple[str, str]]) -> str:
    return listed([" and ".join(pair) for pair in pairs], 3)

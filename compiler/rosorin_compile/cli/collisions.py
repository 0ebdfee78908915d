"""rosorin-compile collisions: compute the collision matrix for MoveIt, and write it next to the description."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from rosorin_compile import api
from rosorin_compile.model import DisabledCollision
from rosorin_compile.mujoco.collisions.matrix import FILE
from rosorin_compile.source.diagnostics import counted, listed

from .command import Options, command, flag, option, robot_argument, robot_options
from .console import PROBLEMS
from .run import Run


@command("collisions", exits="0 written or unchanged, 1 errors")
@robot_argument
@option("-o", "--output FILE", help=f"file to write; default: {FILE} next to the description")
@flag("--force", help="compute again, even if the file is up to date")
@robot_options
def run(options: Options) -> int:
    """Compute the matrix of a robot, and write it."""
    run, description = Run.alone(options, stdin=False)
    console = run.console
    result = api.collisions(run.request(description), output=options.output, force=options.force)
    if run.show(result):
        return PROBLEMS
    if not result.written:
        console.say(f"{result.robot}: the collision matrix is that of {result.urdf}; --force computes it")
        return run.give(result)
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
    return run.give(result)


def _named(pairs: Sequence[tuple[str, str]]) -> str:
    return listed([" and ".join(pair) for pair in pairs], 3)

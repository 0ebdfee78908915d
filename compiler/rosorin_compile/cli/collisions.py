"""rosorin-compile collisions: compute the collision matrix for MoveIt, and write it beside the description."""

from __future__ import annotations

import argparse
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.model import DisabledCollision
from rosorin_compile.mujoco.collisions.planning import Pair, Parts, Planning, ordered, planning_of
from rosorin_compile.output import may_replace
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Console, Heading, Progress, Rule, counted, error, listed
from rosorin_compile.source.project import Description
from rosorin_compile.source.yaml_text import Scalar

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

    from .parser import Parser

RULES = (
    Rule(
        "collisions-refused",
        "The collision matrix cannot be computed or written: the robot has no URDF, a mesh of its shapes cannot be "
        "read, or the file is not one that the tool has written.",
        "As the message says.",
        Heading.WRITING,
    ),
)

FILE = "collisions.yaml"
_HOW = "rosorin-compile collisions ROBOT"


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument(
        "-o", "--output", type="path", metavar="FILE", help=f"file to write; default: {FILE} next to the description"
    )
    command.add_argument("--force", action="store_true", help="compute again, even if the file is up to date")
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Compute the matrix of a robot, and write it."""
    run, description = Run.alone(options, "the matrix of one robot is computed at a time", _HOW, "name its file")
    console = run.console
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    planning = planning_of(case.robot)
    if planning is None:
        return _refused(console, f"{case.robot.name} has no URDF among its outputs", "add urdf: {file: NAME.urdf}")
    path = Path(options.output) if options.output else description.path.parent / FILE
    if os.path.lexists(path) and not files.is_file(path):
        raise WrongUsage(f"{path} cannot be written: it is no regular file")
    if not _is_ours(path):
        help = "name another file with -o, or remove it"
        return _refused(console, f"{path} is there, and rosorin-compile has not written it", help)
    return _compute(run, planning, case, description, path)


def _refused(console: Console, message: str, help: str) -> int:
    console.show([error("collisions-refused", message, None, help)])
    return PROBLEMS


def _is_ours(path: Path) -> bool:
    """Say whether a file may be replaced."""
    try:
        return may_replace(path)
    except (OSError, ValueError):
        return True  # it is not there, or writing says why not


def _compute(run: Run, planning: Planning, case: Case, description: Description, path: Path) -> int:
    from rosorin_compile.formats.mesh_files import Places

    options, console = run.options, run.console
    files: Mapping[str, Path] = {}
    if planning.meshes:
        places = Places(description.path, description.outputs, run.given.packages, os.environ)
        files = places.meshes(case.tree, case.robot.outputs)
    meshes, matrix, of = planning.digests(files), planning.said.matrix, planning.digest
    if matrix is not None and matrix.of == of and dict(matrix.meshes) == meshes and not options.force:
        console.say(f"{planning.robot.name}: the collision matrix is that of {planning.urdf.file}; --force computes it")
        give_result(options, {"robot": planning.robot.name, "file": str(path), "written": False}, str)
        return FINE
    _need()
    now = planning.parts(meshes)
    same = {} if options.force else planning.same_pairs(now)
    pairs, tried = _searched(console, planning, case, files, same)
    if pairs is None:
        return PROBLEMS
    if same:
        console.say(f"{counted(len(same), 'pair')} as before: the same shapes, and the same joints between")
    text = _text(planning, of, tried, meshes, now, pairs)
    code = _write(console, planning, description, path, text, pairs, tried)
    if code == FINE:
        found = [{"links": list(pair.links), "reason": pair.reason} for pair in pairs]
        result = {"robot": planning.robot.name, "file": str(path), "written": True, "states": tried, "pairs": found}
        give_result(options, result, str)
    return code


def _need() -> None:
    """Raise WrongUsage where a library is not installed."""
    from rosorin_compile.mujoco.physics.checking import lacking

    if lacking():
        raise WrongUsage(f"collisions needs what is not installed: pip install {lacking()}")


def _searched(
    console: Console,
    planning: Planning,
    case: Case,
    files: Mapping[str, Path],
    same: Mapping[Pair, DisabledCollision | None],
) -> tuple[list[DisabledCollision] | None, int]:
    """Return the pairs that need no check, and how many states were tried; None after saying what is wrong."""
    from rosorin_compile.mujoco.collisions.search import Search
    from rosorin_compile.mujoco.physics.files import Meshes, named_meshes

    meshes, colliding = Meshes(case, files), planning.meshes
    for named in named_meshes(case):
        if named.purpose == "collision" and named.mesh.file in colliding:
            meshes.read(named)
    if meshes.told:
        console.show(meshes.told)
        _refused(console, "without all meshes nobody knows what never touches", "--package NAME=PATH names a package")
        return None, 0
    search = Search(planning, meshes, Progress.step, same)
    pairs = search.run()
    if search.by_hulls:
        names = listed([" and ".join(pair) for pair in sorted(search.by_hulls)], 3)
        console.say(f"checked all the same: {names}, whose hulls touch, and not the meshes")
    wrong = [
        one.links
        for one in planning.said.disabled
        if one.reason == DisabledCollision.NEVER and ordered(one.links) in search.hit
    ]
    if wrong:
        names = listed([" and ".join(pair) for pair in wrong], 3)
        console.warn(f"disabled_collisions says Never of {names}, which do collide")
    return pairs, search.tried


def _text(
    planning: Planning,
    of: str,
    tried: int,
    meshes: Mapping[str, str],
    now: Parts,
    pairs: Sequence[DisabledCollision],
) -> str:
    """Return the file that the description includes."""
    lines = [
        "# Generated by rosorin-compile collisions; edits here are lost. Which pairs of links MoveIt need not check:",
        f"# {counted(tried, 'random state')} of {planning.urdf.file}, seed {planning.said.search.seed}.",
        "moveit:",
        "  collision_matrix:",
        f'    of: "{of}"',
        f"    states: {tried}",
    ]
    lines.append(f'    how: "{now.how}"')
    for key, told in (("meshes", meshes), ("shapes", now.shapes), ("joints", now.joints)):
        if told:
            lines.append(f"    {key}:")
            lines += [f'      {Scalar(name).written(False)}: "{one}"' for name, one in sorted(told.items())]
    lines.append("    pairs:" if pairs else "    pairs: []")
    for pair in pairs:
        names = ", ".join(Scalar(name).written(True) for name in pair.links)
        far = {"nearest": pair.nearest, "beyond": pair.beyond}
        said = "".join(f", {key}: {1000 * value + 0.0:.6g} mm" for key, value in far.items() if value is not None)
        lines.append(f"      - {{links: [{names}], reason: {pair.reason}{said}}}")
    return "\n".join(lines) + "\n"


def _write(
    console: Console,
    planning: Planning,
    description: Description,
    path: Path,
    text: str,
    pairs: Sequence[DisabledCollision],
    tried: int,
) -> int:
    from rosorin_compile.output import OutputError, write_file

    try:
        write_file(path, text.encode())
    except OutputError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    every = len(planning.solids) * (len(planning.solids) - 1) // 2
    counts = Counter(pair.reason for pair in pairs)
    reasons = listed(f"{counts[reason]} {reason}" for reason in DisabledCollision.REASONS if counts[reason]) or "none"
    console.say(f"{path}: {counted(every, 'pair')} of links, need no check: {reasons}; {every - len(pairs)} to check")
    console.say(f"tried: {counted(tried, 'random state')}, seed {planning.said.search.seed}")
    if description.path != description.ON_STDIN and planning.said.matrix is None:
        console.say(f"next: include: [{path.name}] in {description.path}, then rosorin-compile all")
    else:
        console.say("next: rosorin-compile all")
    return FINE

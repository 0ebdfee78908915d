"""rosorin-compile collisions: compute the collision matrix for MoveIt, and write it beside the description."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from rosorin_compile.diagnostics import Console, Heading, Progress, Rule, counted, error, listed
from rosorin_compile.extending import (
    FINE,
    PROBLEMS,
    Description,
    Given,
    Holding,
    WrongUsage,
    argument_options,
    console_of,
    give_result,
    given_arguments,
    json_option,
    one_robot,
    package_option,
    place,
    quiet_option,
    scalar,
    world,
)

from ...commands.robots import no_stdin, one
from ...commands.understanding import Known, understood
from ...formats.srdf.matrix import Parts, digest, digests, meshes_of, parts, same_pairs
from ...formats.srdf.planning import Planning, ordered, urdf_of
from ...model.moveit import NEVER, REASONS, DisabledCollision, Pair

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


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    one_robot(command)
    command.add_argument("-o", "--output", type=place, metavar="FILE", help=f"default: {FILE} beside the description")
    command.add_argument("--force", action="store_true", help="compute it anew, though it is that of the robot")
    json_option(command)
    quiet_option(command)
    package_option(command)
    argument_options(command)


def run(options: argparse.Namespace) -> int:
    """Compute the matrix of a robot, and write it."""
    given, words = given_arguments(options, options.words)
    if len(words) > 1:
        raise WrongUsage(f"the matrix of one robot is computed at a time: {_HOW}")
    no_stdin(words, "name its file")
    description = one(words[0] if words else "", _HOW)
    console = console_of(options)
    if not options.quiet:
        console.log_progress()
    known = understood(given, description, console)
    if known is None:
        return PROBLEMS
    urdf = urdf_of(known.robot)
    if urdf is None:
        return _refused(console, f"{known.robot.name} has no URDF among its outputs", "add urdf: {file: NAME.urdf}")
    path = Path(options.output) if options.output else description.path.parent / FILE
    if world.stands(path) and world.kind(path) != world.FILE:
        raise WrongUsage(f"{path} cannot be written: it is no regular file")
    if not _is_ours(path):
        help = "name another file with -o, or remove it"
        return _refused(console, f"{path} is there, and rosorin-compile has not written it", help)
    return _compute(options, console, Planning(known.robot, urdf), known, description, given, path)


def _refused(console: Console, message: str, help: str) -> int:
    console.show([error("collisions-refused", message, None, help)])
    return PROBLEMS


def _is_ours(path: Path) -> bool:
    """Say whether a file may be replaced."""
    try:
        return Holding.wrote(path)
    except (OSError, ValueError):
        return True  # it is not there, or writing says why not


def _compute(
    options: argparse.Namespace,
    console: Console,
    planning: Planning,
    known: Known,
    description: Description,
    given: Given,
    path: Path,
) -> int:
    from rosorin_compile.extending import Places

    from ...formats.mesh_files import files_of

    files: Mapping[str, Path] = {}
    if meshes_of(planning):
        places = Places(description.path, description.outputs, given.packages, world.environment())
        files = files_of(known.case.tree, known.robot.outputs, places)
    meshes, matrix, of = digests(meshes_of(planning), files), planning.said.matrix, digest(planning)
    if matrix is not None and matrix.of == of and dict(matrix.meshes) == meshes and not options.force:
        console.say(f"{planning.robot.name}: the collision matrix is that of {planning.urdf.file}; --force computes it")
        give_result(options, {"robot": planning.robot.name, "file": str(path), "written": False}, str)
        return FINE
    _need()
    now = parts(planning, meshes)
    same = {} if options.force else same_pairs(planning, now)
    pairs, tried = _searched(console, planning, known, files, same)
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
    from ..physics.checking import lacking

    if lacking():
        raise WrongUsage(f"collisions needs what is not installed: pip install {lacking()}")


def _searched(
    console: Console,
    planning: Planning,
    known: Known,
    files: Mapping[str, Path],
    same: Mapping[Pair, DisabledCollision | None],
) -> tuple[list[DisabledCollision] | None, int]:
    """Return the pairs that need no check, and how many states were tried; None after saying what is wrong."""
    from ..physics.files import Meshes, named_meshes
    from .search import Search

    meshes = Meshes(known.case, files)
    for named in named_meshes(known.case):
        if named.purpose == "collision" and named.mesh.file in meshes_of(planning):
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
    wrong = [one.links for one in planning.said.disabled if one.reason == NEVER and ordered(one.links) in search.hit]
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
            lines += [f'      {scalar(name, False)}: "{one}"' for name, one in sorted(told.items())]
    lines.append("    pairs:" if pairs else "    pairs: []")
    for pair in pairs:
        names = ", ".join(scalar(name, True) for name in pair.links)
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
    from rosorin_compile.extending import OutputError, write_file

    try:
        write_file(path, text.encode())
    except OutputError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    every = len(planning.solids) * (len(planning.solids) - 1) // 2
    counts = Counter(pair.reason for pair in pairs)
    reasons = listed(f"{counts[reason]} {reason}" for reason in REASONS if counts[reason]) or "none"
    console.say(f"{path}: {counted(every, 'pair')} of links, need no check: {reasons}; {every - len(pairs)} to check")
    console.say(f"tried: {counted(tried, 'random state')}, seed {planning.said.search.seed}")
    if description.path != description.ON_STDIN and planning.said.matrix is None:
        console.say(f"next: include: [{path.name}] in {description.path}, then rosorin-compile all")
    else:
        console.say("next: rosorin-compile all")
    return FINE

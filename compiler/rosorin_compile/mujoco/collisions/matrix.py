"""Compute the collision matrix of a robot for MoveIt, and write the file that its description includes."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats.mesh_files import Places
from rosorin_compile.model import DisabledCollision, Robot
from rosorin_compile.output import OutputError, may_replace, write_file
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, counted, error
from rosorin_compile.source.rule_registry import WRITING, declare
from rosorin_compile.source.yaml_text import Scalar

from ..physics.checking import require
from ..physics.scene import Pair, mesh_shapes, read_meshes
from .search import Planning, Search

RULES = declare(
    WRITING,
    {
        "collisions-refused": "The collision matrix cannot be computed or written: the robot has no URDF, a mesh of "
        "its shapes cannot be read, or the file is not one that the tool has written. Fix: As the message says.",
    },
)

FILE = "collisions.yaml"


@dataclass(frozen=True)
class CollisionMatrix:
    """The collision matrix of a robot. With an error among ``diagnostics`` it was not computed or not written."""

    robot: str
    file: str
    written: Annotated[bool, "false: the file is up to date, or there is an error"] = False
    urdf: Annotated[str, "the URDF that the matrix belongs to"] = ""
    seed: Annotated[int, "the seed of the search"] = 0
    states: Annotated[int, "the number of random states that were tried"] = 0
    links: Annotated[int, "the number of links with collision shapes"] = 0
    pairs: Annotated[tuple[DisabledCollision, ...], "pairs that MoveIt does not need to check; distances in m"] = ()
    kept: Annotated[int, "the number of pairs whose result is still valid from the matrix before"] = 0
    touching_hulls: Annotated[tuple[Pair, ...], "pairs to be checked whose hulls touch, but not their meshes"] = ()
    contradicted: Annotated[tuple[Pair, ...], "pairs that the description declares as Never, and that collide"] = ()
    included: Annotated[bool, "whether the description includes a matrix"] = False
    diagnostics: tuple[Diagnostic, ...] = ()


def compute_matrix(
    request: Request,
    planning_of: Callable[[Robot], Planning | None],
    *,
    output: Path | None = None,
    force: bool = False,
) -> CollisionMatrix:
    """Compute the pairs of links that need no check, and write them next to the description or to ``output``.

    ``planning_of`` returns the robot as MoveIt plans with it. A file that is up to date is only computed again with
    ``force``. Raises RequestError without MuJoCo, or if ``output`` is not a regular file.
    """
    understood, path = request.understand(), output or request.description.path.parent / FILE
    case, errors = understood.case, tuple(one for one in understood.diagnostics if one.severity == "error")
    refused = CollisionMatrix(request.description.name, str(path), diagnostics=errors)
    if case is None:
        return refused

    def refuse(message: str, help: str, *more: Diagnostic) -> CollisionMatrix:
        return replace(refused, diagnostics=(*more, error("collisions-refused", message, None, help)))

    planning = planning_of(case.robot)
    if planning is None:
        return refuse(f"{case.robot.name} has no URDF among its outputs", "add urdf: {file: NAME.urdf}")
    if os.path.lexists(path) and not path.is_file():
        raise RequestError(f"{path} cannot be written: it is not a regular file")
    with suppress(OSError, ValueError):  # it does not exist, or writing reports the reason
        if not may_replace(path):
            return refuse(f"{path} was not written by rosorin-compile", "name another file with -o, or remove it")
    places = Places(request.description.path, request.description.outputs, request.packages, os.environ)
    files = places.meshes(case.tree, case.robot.outputs) if planning.meshes else {}
    digests, included, seed = planning.digests(files), planning.said.matrix, planning.said.search.seed
    result = CollisionMatrix(
        planning.robot.name, str(path), urdf=planning.urdf.file, seed=seed, included=included is not None
    )
    if included is not None and included.of == planning.digest and dict(included.meshes) == digests and not force:
        return result
    require("collisions")
    colliding = [one for one in mesh_shapes(case) if one.purpose == "collision" and one.mesh.file in planning.meshes]
    meshes, problems = read_meshes(case, colliding, files)
    if problems:
        help = "--package NAME=PATH names a package"
        return refuse("pairs that never touch can only be found with all meshes", help, *problems)
    parts = planning.parts(digests)
    search = Search(planning, meshes, {} if force else planning.same_pairs(parts))
    pairs = search.run()
    content = {"meshes": digests, "shapes": parts.shapes, "joints": parts.joints}
    try:
        write_file(path, _text(planning, search.tried, parts.how, content, pairs).encode())
    except OutputError as problem:
        return replace(refused, diagnostics=(problem.diagnostic,))
    never = [one.links for one in planning.said.disabled if one.reason == DisabledCollision.NEVER]
    return replace(
        result,
        written=True,
        states=search.tried,
        links=len(planning.solids),
        pairs=tuple(pairs),
        kept=len(search.same),
        touching_hulls=tuple(sorted(search.only_hulls)),
        contradicted=tuple(pair for pair in never if not search.hit.isdisjoint((pair, pair[::-1]))),
    )


def _text(planning: Planning, tried: int, how: str, content: dict[str, Any], pairs: Sequence[DisabledCollision]) -> str:
    """Return the file that the description includes."""
    lines = [
        "# Generated by rosorin-compile collisions; edits here are lost. Which pairs of links MoveIt need not check:",
        f"# {counted(tried, 'random state')} of {planning.urdf.file}, seed {planning.said.search.seed}.",
        "moveit:",
        "  collision_matrix:",
        f'    of: "{planning.digest}"',
        f"    states: {tried}",
        f'    how: "{how}"',
    ]
    for key, digests in content.items():
        lines += [f"    {key}:"] if digests else []
        lines += [f'      {Scalar(name).written(False)}: "{digest}"' for name, digest in sorted(digests.items())]
    lines.append("    pairs:" if pairs else "    pairs: []")
    for pair in pairs:
        names = ", ".join(Scalar(name).written(True) for name in pair.links)
        distances = {"nearest": pair.nearest, "beyond": pair.beyond}
        more = "".join(f", {key}: {1000 * d + 0.0:.6g} mm" for key, d in distances.items() if d is not None)
        lines.append(f"      - {{links: [{names}], reason: {pair.reason}{more}}}")
    return "\n".join(lines) + "\n"

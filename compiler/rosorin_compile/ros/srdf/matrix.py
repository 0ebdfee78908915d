"""The collision matrix: what it was computed of, as a digest, and whether that is still the robot.

Numbers go into the digest to nine decimals (1 nm, 1e-9 of a turn), so that the last digit of a sine, which is not the
same on every machine, does not make a matrix stale. Joints that carry no shape are not in it: a new frame of a sensor
touches nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from hashlib import sha256
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import DisabledCollision, Mesh, Shape, Transform
from rosorin_compile.ros.moveit import Pair
from rosorin_compile.source.diagnostics import counted, first_of
from rosorin_compile.source.files import read_bytes

if TYPE_CHECKING:
    from .planning import Planning

_SHOWN = 20  # pairs in a message
_DECIMALS = 9
RENEW = "rosorin-compile collisions computes it again"
_FORM = 1  # of the search: another one makes every matrix stale


def digest(planning: Planning) -> str:
    """Return what tells the shapes, joints and limits of a URDF, and how it is searched, from any other."""
    said = {
        "form": _FORM,
        "links": {name: [_solid(one) for one in solids] for name, solids in planning.solids.items() if solids},
        "joints": [_joint(planning, name) for name in sorted(_carrying(planning))],
        "search": vars(planning.said.search),
    }
    text = json.dumps(said, sort_keys=True, separators=(",", ":"))
    return _hash(text.encode())


class Parts(NamedTuple):
    """Digests of what decides on single pairs: the search, the shapes of each link with its meshes, and each joint."""

    how: str
    shapes: Mapping[str, str]
    joints: Mapping[str, str]


def parts(planning: Planning, meshes: Mapping[str, str]) -> Parts:
    """Return the digests of what decides on single pairs; ``meshes`` are those of mesh files, by name."""
    shapes = {}
    for name in sorted(planning.solids):
        files = [meshes.get(one.geometry.file, "") for one in planning.solids[name] if isinstance(one.geometry, Mesh)]
        shapes[name] = _short([[_solid(one) for one in planning.solids[name]], files])
    joints = {name: _short(_joint(planning, name)) for name in sorted(_carrying(planning))}
    return Parts(_short([_FORM, vars(planning.said.search)]), shapes, joints)


def _short(said: Any) -> str:
    return _hash(json.dumps(said, sort_keys=True, separators=(",", ":")).encode())[:16]


def same_pairs(planning: Planning, now: Parts) -> dict[Pair, DisabledCollision | None]:
    """Return the pairs of a matrix whose shapes and joints between are the same as then; None for one to be checked."""
    matrix = planning.said.matrix
    if matrix is None or matrix.how != now.how:
        return {}
    then = {ordered(pair.links): pair for pair in matrix.pairs}
    shapes = [name for name, one in now.shapes.items() if matrix.shapes.get(name) == one]
    joints = {name for name, one in now.joints.items() if matrix.joints.get(name) == one}
    ways = {name: planning.chain(name) for name in shapes}
    found: dict[Pair, DisabledCollision | None] = {}
    for pair in combinations(sorted(shapes), 2):
        one, other = (ways[name] for name in pair)
        between = {joint.name for joint in one}.symmetric_difference(joint.name for joint in other)
        if between | _leaders(planning, between) <= joints:
            found[ordered(pair)] = then.get(ordered(pair))
    return found


def _leaders(planning: Planning, names: Iterable[str]) -> set[str]:
    found: set[str] = set()
    waiting = list(names)
    while waiting:
        mimic = planning.joints[waiting.pop()].mimic
        if mimic is not None and mimic.joint not in found:
            found.add(mimic.joint)
            waiting += [mimic.joint] if mimic.joint in planning.joints else []
    return found


def _carrying(planning: Planning) -> set[str]:
    found: set[str] = set()
    for link, solids in planning.solids.items():
        if solids:
            found.update(joint.name for joint in planning.chain(link))
    open_ends = list(found)
    while open_ends:
        mimic = planning.joints[open_ends.pop()].mimic
        if mimic and mimic.joint in planning.joints and mimic.joint not in found:
            found.add(mimic.joint)
            open_ends.append(mimic.joint)
    return found


def _hash(data: bytes) -> str:
    return sha256(data).hexdigest()[:32]


def _solid(shape: Shape) -> list[Any]:
    geometry = shape.geometry
    sizes = [[key, _rounded(value)] for key, value in sorted(vars(geometry).items())]
    return [type(geometry).__name__, sizes, _place(shape.origin().transform())]


def _joint(planning: Planning, name: str) -> list[Any]:
    joint = planning.joints[name]
    limit = joint.limit
    limits = None if limit is None or joint.type == "continuous" else _rounded((limit.lower, limit.upper))
    mimic = joint.mimic and [joint.mimic.joint, _rounded((joint.mimic.multiplier, joint.mimic.offset))]
    axis = None if joint.is_fixed else _rounded(joint.axis)
    return [name, joint.type, joint.parent, joint.child, _place(joint.origin.transform()), axis, limits, mimic]


def _place(transform: Transform) -> list[list[float]]:
    return [[round(value, _DECIMALS) + 0.0 for value in row] for row in (transform.xyz, *transform.rows)]


def _rounded(value: Any) -> Any:
    if isinstance(value, (tuple, list)):
        return [_rounded(one) for one in value]
    return round(float(value), _DECIMALS) + 0.0 if isinstance(value, (int, float)) else value


def meshes_of(planning: Planning) -> list[str]:
    """Return the names of the mesh files that collide, each once, sorted."""
    shapes = (shape.geometry for solids in planning.solids.values() for shape in solids)
    return sorted({geometry.file for geometry in shapes if isinstance(geometry, Mesh)})


def digests(names: Iterable[str], files: Mapping[str, Path]) -> dict[str, str]:
    """Return the digests of mesh files by name, of those that were found and can be read."""
    found = {}
    for name in names:
        try:
            data = read_bytes(files[name])
        except (KeyError, OSError):
            continue
        found[name] = _hash(data)
    return found


def stale_pairs(planning: Planning) -> tuple[list[Pair], list[str]]:
    """Return the pairs of the matrix whose shapes, joints or meshes changed since, and the mesh files that changed.

    A pair that is adjacent stays so, whatever its shapes. Mesh files that were not found count as unchanged.
    """
    computed = planning.said.matrix
    if computed is None:
        return [], []
    then, now = dict(computed.meshes), digests(meshes_of(planning), planning.robot.mesh_files)
    changed = [name for name, digest in now.items() if then.get(name) != digest]
    if computed.of == planning.digest and not changed:
        return [], []
    same = same_pairs(planning, parts(planning, {**then, **now}))
    reasons = {ordered(pair.links): pair.reason for pair in computed.pairs}
    adjacent = {pair for pair in planning.adjacent if reasons.get(pair) == DisabledCollision.ADJACENT}
    existing = [pair for pair in reasons if planning.links.issuperset(pair)]
    return [pair for pair in existing if pair not in same and pair not in adjacent], changed


def stale_text(pairs: list[Pair]) -> str:
    """Return the pairs whose result may be wrong, in a sentence."""
    names = first_of([f"{one} and {other}" for one, other in pairs], _SHOWN)
    return f"{counted(len(pairs), 'pair')} may collide now, though the SRDF still disables the check of {names}"


def ordered(pair: Pair) -> Pair:
    """Return two names in their order."""
    one, other = sorted(pair)
    return (one, other)

"""The collision matrix: what it was computed of, as a digest, and whether that is still the robot.

Numbers go into the digest to nine decimals (1 nm, 1e-9 of a turn), so that the last digit of a sine, which is not the
same on every machine, does not make a matrix stale. Joints that carry no shape are not in it: a new frame of a sensor
touches nothing.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from ...model import Mesh, Shape, Transform
from ...startup import TYPE_CHECKING
from ...startup.cache import sha256
from .planning import Planning

if TYPE_CHECKING:
    from typing import Any

_DECIMALS = 9
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


def _carrying(planning: Planning) -> set[str]:
    """Return the joints that place a shape, and those that such a joint mimics."""
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
    return sha256(data)[:32]


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
            data = files[name].read_bytes()
        except (KeyError, OSError):
            continue
        found[name] = _hash(data)
    return found


def changed_meshes(planning: Planning) -> list[str]:
    """Return the mesh files that are others than those that the matrix was computed of, as far as they were found."""
    matrix = planning.said.matrix
    if matrix is None:
        return []
    now = digests(meshes_of(planning), planning.robot.mesh_files)
    return [name for name, one in now.items() if matrix.meshes.get(name) != one]

"""Vertices of mesh files: what MuJoCo reads of a binary STL, an OBJ or an MSH, for whoever asks how far meshes reach.

A file is read when its mesh is asked for, once. It is that which an artifact opens: of what is converted on the way the
copy, whose numbers are those of the MJCF.
"""

from __future__ import annotations

import math
import struct
from array import array
from collections.abc import Callable, Iterable
from pathlib import Path
from sys import byteorder

from ..model import Mesh, Robot, Vector
from ..model.standing import Cloud, Clouds
from ..world import FILE, kind, read, size

_HEAD = 84  # bytes of an STL before its triangles, of which each has 50
_TRIANGLE = struct.Struct("<12x9f2x")
_MSH = struct.Struct("<4i")  # how many vertices, normals, texture coordinates and faces
MAX_BYTES = 500_000_000


def clouds_of(robot: Robot) -> Clouds:
    """Return what says where the vertices of a mesh are; of one whose file is not known or not read it says None.

    A mesh that artifacts go without has none.
    """
    known: dict[str, Cloud | None] = {}

    def cloud(mesh: Mesh) -> Cloud | None:
        if mesh.file in robot.missing_meshes:
            return Cloud((), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        if mesh.file not in known:
            known[mesh.file] = _cloud(vertices(*_content(robot, mesh.file)))
        return known[mesh.file]

    return cloud


def _content(robot: Robot, name: str) -> tuple[bytes, str]:
    """Return the bytes of a mesh and how its name ends; nothing where nobody looked for it."""
    ready = robot.mesh_contents.get(name)
    if ready is not None:
        return ready
    path = robot.mesh_files.get(name, Path())
    try:
        if kind(path) == FILE and size(path) <= MAX_BYTES:
            return read(path), path.suffix.lower()
    except OSError:
        pass  # it went away since it was looked for
    return b"", ""


def vertices(data: bytes, ending: str) -> Iterable[Vector]:
    """Return the vertices of a mesh, in the units of its file; nothing of what is damaged or of another format."""
    readers: dict[str, Callable[[bytes], Iterable[Vector]]] = {".stl": _stl, ".obj": _obj, ".msh": _msh}
    try:
        return readers[ending](data) if ending in readers else ()
    except (ValueError, IndexError, struct.error):
        return ()


def _cloud(points: Iterable[Vector]) -> Cloud | None:
    """Return vertices with the box around them; None of none, or of some that are nowhere."""
    every = tuple(points)
    if not every or not all(map(math.isfinite, (number for point in every for number in point))):
        return None
    xs, ys, zs = zip(*every, strict=True)
    return Cloud(every, (min(xs), min(ys), min(zs)), (max(xs), max(ys), max(zs)))


def _stl(data: bytes) -> Iterable[Vector]:
    count = struct.unpack("<I", data[80:_HEAD])[0]
    if len(data) != _HEAD + 50 * count:
        raise ValueError("no binary STL")
    found: set[Vector] = set()  # most corners stand in six triangles
    for a, b, c, d, e, f, g, h, i in _TRIANGLE.iter_unpack(data[_HEAD:]):
        found.update(((a, b, c), (d, e, f), (g, h, i)))
    return found


def _obj(data: bytes) -> Iterable[Vector]:
    """Return all vertices: MuJoCo takes those that no face has into the hull, too."""
    lines = (
        line.split() for line in data.decode("utf-8", "replace").splitlines() if line.lstrip()[:2] in ("v ", "v\t")
    )
    return {(float(x), float(y), float(z)) for _, x, y, z, *_ in lines}


def _msh(data: bytes) -> Iterable[Vector]:
    count = _MSH.unpack_from(data)[0]
    numbers = array("f", data[_MSH.size : _MSH.size + 12 * count])
    if byteorder == "big":
        numbers.byteswap()
    return list(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True))

"""Read vertices of STL, OBJ and MSH files without optional packages, so that artifacts do not depend on these."""

import math
import re
import struct
from array import array
from collections.abc import Callable, Sequence

from rosorin_compile.source import files
from rosorin_compile.source.cache import of_robot

from .geometry import Vector
from .robot import Robot
from .shape import Mesh

MAX_BYTES = 500_000_000
STL_HEADER = 84  # bytes: 80 of text and 4 for the number of triangles; each triangle then has 50 bytes
_OBJ_VERTEX = re.compile(rb"(?:^|[\r\n])[ \t]*v[ \t]+([^\r\n]*)")
_STL_VERTEX = re.compile(rb"(?:^|[\r\n])[ \t]*vertex[ \t]+([^\r\n]*)", re.IGNORECASE)

# A function that returns the vertices of a mesh in the unit of its file, or None if the file cannot be read.
Clouds = Callable[[Mesh], Sequence[Vector] | None]


class UnreadableMesh(Exception):
    """Raised for a damaged or unsupported mesh file. The message is a clause, such as "the file is empty"."""

    def __init__(self, message: str, help: str = "export it again", rule: str = "") -> None:
        super().__init__(message)
        self.help, self.rule = help, rule


@of_robot
def clouds_of(robot: Robot, as_opened: bool = False) -> Clouds:
    """Return a function that returns the vertices of a mesh, or None if its file is missing or unreadable.

    By default, the function reads the files that the description names. With ``as_opened``, it reads the files that
    MuJoCo opens, such as an OBJ converted from a DAE, and returns () for a missing mesh, which the MJCF omits.
    """

    def read(mesh: Mesh) -> Sequence[Vector] | None:
        return () if as_opened and mesh.file in robot.missing_meshes else _cloud(robot, mesh.file, as_opened)[0]

    return read


def why_unread(robot: Robot, name: str) -> str:
    """Return the reason why the file of the mesh ``name`` cannot be read, or "" if it can."""
    return _cloud(robot, name, False)[1]


@of_robot
def _cloud(robot: Robot, name: str, as_opened: bool) -> tuple[tuple[Vector, ...] | None, str]:
    data, ending = robot.mesh_contents.get(name, (b"", "")) if as_opened else (b"", "")
    path = robot.mesh_files.get(name)
    try:
        if not ending:
            if path is None or not files.is_file(path):
                return None, "the file is not found"
            data, ending = files.read_bytes(path, MAX_BYTES + 1), path.suffix.lower()
        if len(data) > MAX_BYTES:
            return None, f"the file is larger than {MAX_BYTES:,} bytes"
        coordinates = read_vertices(data, ending)
    except OSError as problem:
        return None, problem.strerror or "the file cannot be read"
    except UnreadableMesh as problem:
        return None, str(problem)
    return tuple(dict.fromkeys(zip(coordinates[::3], coordinates[1::3], coordinates[2::3], strict=True))), ""


def read_vertices(data: bytes, ending: str) -> "array[float]":
    """Return the coordinates x, y, z of all vertices in a mesh file as a flat array, in the unit of the file.

    ``ending`` is the file extension, such as ".stl". An STL has three vertices per triangle. OBJ vertices without a
    face are included, because MuJoCo includes them in the convex hull. Raises UnreadableMesh for invalid data.
    """
    check_content(data)
    if ending not in (".stl", ".obj", ".msh"):
        raise UnreadableMesh("only STL, OBJ and MSH files are measured", "export it as STL or OBJ")
    coordinates = array("d")
    if ending == ".msh":  # MuJoCo format: numbers of vertices, normals, texture coordinates and faces, then the data
        counts = struct.unpack_from("<4i", data) if len(data) >= 16 else (-1, 0, 0, 0)
        size = 16 + sum(count * size for count, size in zip(counts, (12, 12, 8, 12), strict=True))
        if min(counts) < 0 or size != len(data) or {counts[1], counts[2]} - {0, counts[0]}:
            raise UnreadableMesh("the MSH is damaged")
        coordinates.extend(struct.unpack_from(f"<{3 * counts[0]}f", data, 16))
    elif ending == ".stl" and not is_ascii_stl(data):
        if stl_count(data) is None:
            raise UnreadableMesh("the STL is damaged")
        for triangle in struct.iter_unpack("<12x9f2x", data[STL_HEADER:]):
            coordinates.extend(triangle)
    else:
        for line in (_OBJ_VERTEX if ending == ".obj" else _STL_VERTEX).finditer(data):
            try:
                x, y, z = map(float, line[1].split()[:3])
            except ValueError:
                raise UnreadableMesh("a vertex is not three numbers") from None
            coordinates.extend((x, y, z))
        if ending == ".stl" and len(coordinates) % 9:
            raise UnreadableMesh("the STL is damaged: a triangle has fewer than three vertices")
    if not coordinates:
        raise UnreadableMesh("it has no vertices")
    if not math.isfinite(sum(map(abs, coordinates))):
        raise UnreadableMesh("a coordinate of a vertex is not a finite number")
    return coordinates


def check_content(data: bytes) -> None:
    """Raise UnreadableMesh if a mesh file is empty or a Git LFS pointer."""
    if not data.strip():
        raise UnreadableMesh("the file is empty")
    if data.startswith(b"version https://git-lfs"):
        raise UnreadableMesh("it is a pointer of Git LFS, not the file itself", "fetch the file: git lfs pull")


def stl_count(data: bytes) -> int | None:
    """Return the number of triangles in a binary STL, or None if the size of ``data`` does not match this number."""
    count = int(struct.unpack_from("<I", data, STL_HEADER - 4)[0]) if len(data) >= STL_HEADER else -1
    return count if len(data) == STL_HEADER + 50 * count else None


def is_ascii_stl(data: bytes) -> bool:
    """Return True if an STL is in ASCII format. The header of a binary STL may also begin with "solid"."""
    return stl_count(data) is None and data.lstrip()[:5].lower() == b"solid"

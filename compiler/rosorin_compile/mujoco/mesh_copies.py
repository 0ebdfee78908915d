"""Copy the meshes and textures that an MJCF refers to into the folder of the artifacts.

Binary STL, OBJ, MSH and PNG files are copied, because MuJoCo reads them. ASCII STL is converted to binary STL; DAE,
glTF and GLB are converted to OBJ with trimesh. A converted file has the SHA-256 of its source in its first line.
Without trimesh, an existing copy of the same source is used, and it is an error if there is none.
"""

import hashlib
import re
import struct
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from rosorin_compile.formats.mesh_files import OF_ELEMENT, OF_MESH, FoundFile, NamedFile, SearchResult, files_diagnostic
from rosorin_compile.model.geometry import Vector, cross, dot, minus, norm
from rosorin_compile.model.mesh_triangles import ExtractProblem, TriangleMesh, load_mesh
from rosorin_compile.model.mesh_vertices import UnreadableMesh, check_content, is_ascii_stl, read_vertices, stl_count
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.progress import Progress

MAX_BYTES = 500_000_000
MAX_STL_TRIANGLES = 200_000  # per file: the maximum of MuJoCo
MAX_COORDINATE = 2.0**30  # in the unit of the file; MuJoCo computes no convex hull of larger coordinates
MIN_VERTICES = 4  # distinct vertices per file: the minimum of MuJoCo
FLAT = 1e-9  # MuJoCo computes no convex hull of a mesh with a smaller ratio of thickness to length
_MARK = "made by rosorin-compile of SHA-256 "
_PNG_START, _PNG_END = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"
_OBJ_INDEX = re.compile(rb"(?:^|(?<=[ \t]))(-?\d+)", re.MULTILINE)
_STL_TRIANGLE = struct.Struct("<12x9f2x")


def copy_meshes(searched: SearchResult, outputs: Path) -> SearchResult:
    """Return ``searched`` with all meshes and textures converted for MuJoCo; ``outputs`` is the folder of copies."""
    files, missing, converted = dict(searched.files), set(searched.missing), list[NamedFile]()
    failed: dict[tuple[str, str, str, str], list[NamedFile]] = {}  # unusable files by (rule, reason, help, kind)
    found = [one for one in searched.found if one.named.kind != OF_MESH]
    for number, one in enumerate(found):
        Progress.step("reading meshes", number, len(found))
        try:
            copies, is_new = _copies(one, outputs)
        except UnreadableMesh as problem:
            cause = (problem.rule or "mesh-not-read", str(problem), problem.help, one.named.kind)
            failed.setdefault(cause, []).append(one.named)
            missing.add(one.named.name)
            continue
        files |= copies
        converted += [one.named] if is_new else []
    diagnostics = list(searched.diagnostics)
    for (rule, reason, help, kind), many in failed.items():
        effect = "not converted for the MJCF" if rule == "extra-missing" else "left out of the MJCF"
        severity = ERROR if rule == "extra-missing" or kind == OF_ELEMENT else WARNING
        message = f"{'not read' if kind == OF_ELEMENT else effect}: {reason}"
        diagnostics.append(files_diagnostic(rule, message, help, severity, many))
    if converted:
        message = "converted for the MJCF: MuJoCo reads binary STL, OBJ and MSH"
        diagnostics.append(replace(files_diagnostic("mesh-converted", message, "", NOTE, converted), related=()))
    return searched._replace(missing=frozenset(missing), diagnostics=diagnostics, files=files)


def check_for_mujoco(data: bytes, ending: str, collides: bool = False) -> None:
    """Raise UnreadableMesh if MuJoCo cannot load the contents of a mesh or image file.

    ``ending`` is the file extension. If ``collides`` is true, the mesh must also have a convex hull.
    """
    check_content(data)
    if ending == ".png" and not (data.startswith(_PNG_START) and data.endswith(_PNG_END)):
        raise UnreadableMesh("it is not a complete PNG", "export it again, as PNG")
    if ending not in (".stl", ".obj"):
        return
    if ending == ".stl":
        if is_ascii_stl(data):
            raise UnreadableMesh("MuJoCo reads no ASCII STL", "export it as binary STL")
        if (count := stl_count(data)) is not None and not 1 <= count <= MAX_STL_TRIANGLES:
            message = f"it has {count:,} triangles, and MuJoCo reads 1 to {MAX_STL_TRIANGLES:,} of an STL"
            raise UnreadableMesh(message, "reduce the number of triangles, or export it as OBJ")
    coordinates = read_vertices(data, ending)
    farthest = max(map(abs, coordinates))
    if farthest > MAX_COORDINATE:
        raise UnreadableMesh(f"a coordinate of a vertex is {farthest:g}")
    vertices = list(dict.fromkeys(zip(coordinates[::3], coordinates[1::3], coordinates[2::3], strict=True)))
    if len(vertices) < MIN_VERTICES:
        message = f"MuJoCo needs {MIN_VERTICES} different vertices, and it has {len(vertices)}"
        raise UnreadableMesh(message, "name a mesh that has a surface")
    if collides and _is_flat(vertices[:100]) and _is_flat(vertices):
        help = "use a thin box in place of the mesh, or the mesh as visual only"
        raise UnreadableMesh("all its points are in one plane, and MuJoCo computes no hull of it", help)
    if ending == ".obj":
        count = len(coordinates) // 3  # vertex indices in faces start at 1, or at -1 counting backwards
        faces = b"\n".join(re.findall(rb"(?:^|[\r\n])[ \t]*f[ \t]+([^\r\n]*)", data))
        if not all(1 <= abs(index) <= count for index in map(int, set(_OBJ_INDEX.findall(faces)))):
            raise UnreadableMesh("it has a face with a vertex that does not exist")


def _is_flat(points: list[Vector]) -> bool:
    rest = [minus(point, points[0]) for point in points]
    axis = max(rest, key=norm)
    normal = max((cross(axis, point) for point in rest), key=norm)
    least = FLAT * norm(axis)
    return norm(normal) <= least * norm(axis) or all(abs(dot(normal, one)) <= least * norm(normal) for one in rest)


def _copies(found: FoundFile, outputs: Path) -> tuple[dict[str, bytes], bool]:
    """Return (contents of each copy by path, True if a copy was newly converted). Raises UnreadableMesh."""
    try:
        if found.file.stat().st_size > MAX_BYTES:
            raise UnreadableMesh(f"it is larger than {MAX_BYTES:,} bytes", "reduce the number of triangles")
        data, source_ending = read_bytes(found.file), found.file.suffix.lower()
    except OSError as problem:
        raise UnreadableMesh(problem.strerror or type(problem).__name__, "check the permissions") from None
    check_content(data)
    paths = [outputs / place for place in found.places]
    if not paths or any(path.exists() and path.samefile(found.file) for path in paths):
        check_for_mujoco(data, source_ending, found.named.collides)
        return dict.fromkeys(found.places, data), False
    copies, is_new, mark = dict.fromkeys(found.places, data), False, f"{_MARK}{hashlib.sha256(data).hexdigest()[:40]}"
    for place, path in zip(found.places, paths, strict=True):
        ending, existing = path.suffix.lower(), b""
        if ending != source_ending or (ending == ".stl" and is_ascii_stl(data)):
            with suppress(OSError, ValueError):
                existing = path.read_bytes()
            copies[place] = _binary_stl(data, mark) if ending == ".stl" else _obj(found.file, mark, existing)
            is_new = is_new or copies[place] != existing
        check_for_mujoco(copies[place], ending, found.named.collides)
    return copies, is_new


def _binary_stl(data: bytes, mark: str) -> bytes:
    coordinates = read_vertices(data, ".stl")
    try:
        packed = b"".join(map(_STL_TRIANGLE.pack, *(coordinates[first::9] for first in range(9))))
    except OverflowError:
        raise UnreadableMesh("a coordinate of a vertex is too large for a binary STL") from None
    return mark.encode().ljust(80) + struct.pack("<I", len(coordinates) // 9) + packed


def _obj(path: Path, mark: str, existing: bytes) -> bytes:
    """Convert a mesh to OBJ. Without trimesh, return ``existing`` if its ``mark`` shows the same source."""
    try:
        TriangleMesh.require_packages()
        import numpy as np

        triangles = load_mesh(path).triangles
    except ExtractProblem as problem:
        reason = problem.diagnostic
        if reason.rule != "extra-missing":
            raise UnreadableMesh(reason.message.removeprefix(f"{path} "), reason.help) from None
        if mark.encode() in existing[:200]:
            return existing
        message = f"MuJoCo does not read its format, and {reason.message}"
        raise UnreadableMesh(message, f"{reason.help}; or export it as STL or OBJ", reason.rule) from None
    # MuJoCo stores vertices as 32-bit floats, so duplicates are merged at that precision.
    corners, faces = np.unique(triangles.reshape(-1, 3).astype(np.float32), axis=0, return_inverse=True)
    lines = [f"# {mark}", *("v " + " ".join(f"{value + 0.0:.9g}" for value in corner) for corner in corners.tolist())]
    lines += ["f " + " ".join(map(str, face)) for face in (faces.reshape(-1, 3) + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()

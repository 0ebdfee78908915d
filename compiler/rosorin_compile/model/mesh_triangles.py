"""Triangles of mesh files in metres, read by trimesh.

A file that is broken, empty or hostile is an ``ExtractProblem``, never a traceback. Side files are not read, except the
buffers of a .gltf and the materials of an .obj in the same folder; a .dae with a DTD is not parsed.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, error
from rosorin_compile.source.installing import pip_install
from rosorin_compile.source.rule_registry import MESHES, Rule
from rosorin_compile.source.wording import counted

from .geometry import Pose
from .link import Inertial

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosorin_compile.rules.case import Case

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "mesh-unreadable",
        "A mesh cannot be read: it is not there, broken, or of a format that `extract` does not know. A warning where "
        "a robot names it.",
        "Export it anew; [which meshes](meshes.md#supported-mesh-formats).",
        MESHES,
        asked="physics",
    ),
    Rule("mesh-empty", "A mesh, or a robot, has no triangle.", "Name one that has a surface.", MESHES),
)

MAX_BYTES = 2_000_000_000
_MAX_MATERIALS = 1_000_000  # bytes
_MAP, _WHITE = re.compile(rb"(?mi)^[ \t]*map_Kd\b[^\r\n]*"), re.compile(rb"(?mi)^[ \t]*Kd\b[^\r\n]*")
_NAMELESS = "material_0"  # the name of a material that trimesh made up
_AGAIN = "export it again"

Colour = tuple[float, float, float]


class ExtractProblem(Exception):
    """A mesh cannot be used; carries the diagnostic that says why, and what to do."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic

    @classmethod
    def of(cls, rule: str, message: str, help: str = "", span: Span | None = None) -> ExtractProblem:
        """Return a problem, to be raised."""
        return cls(error(rule, message, span, help))


class NotThere(ExtractProblem):
    """A file, a robot, a package or a link does not exist. For commands this is a usage error."""


@dataclass(frozen=True)
class TriangleMesh:
    """Triangles of a mesh: ``triangles`` is (n, 3, 3), corners in metres, counter-clockwise seen from outside.

    ``colours`` has the length of each run of triangles and its colour (sRGB, 0 to 1), or None if the file has none.
    """

    name: str
    triangles: Floats
    colours: tuple[tuple[int, Colour | None], ...] = ()

    FORMATS: ClassVar[tuple[str, ...]] = ("stl", "obj", "dae", "gltf", "glb")

    @classmethod
    def of_shape(
        cls, case: Case, shape: tuple[str, str, int], files: Mapping[str, Path], coloured: bool = False
    ) -> TriangleMesh | Diagnostic:
        """Return the mesh of a shape, or a warning at its place if it cannot be read.

        ``shape`` is the link, "visual" or "collision", and the index there; ``files`` are mesh files by the names in
        the description.
        """
        link, purpose, number = shape
        mesh = getattr(case.robot.link[link], purpose)[number].geometry
        file = files.get(mesh.file)
        help = "its shape is left out here; a package is named by --package NAME=PATH"
        message = f'the mesh {mesh.file} of link "{link}" is not found'
        if file is not None:
            try:
                return load_mesh(file, mesh.scale, coloured)
            except ExtractProblem as problem:
                message, help = problem.diagnostic.message, "its shape is left out here"
                if problem.diagnostic.rule == "extra-missing":
                    help += f"; {problem.diagnostic.help}"
        path = (*case.link(link), purpose, number, "mesh", "file")
        return case.problem("mesh-unreadable", message, path, help, severity=WARNING)

    @staticmethod
    def needed() -> None:
        """Raise ExtractProblem unless the packages that read meshes are installed."""
        try:
            import numpy  # noqa: F401
            import scipy  # type: ignore[import-untyped,unused-ignore]  # noqa: F401
            import trimesh  # noqa: F401
        except ImportError as problem:
            raise _missing(f"reading meshes needs the package {problem.name}") from None

    @staticmethod
    def placed(triangles: Floats, rows: Sequence[Sequence[float]], xyz: Sequence[float]) -> Floats:
        """Return triangles (n, 3, 3) turned by the rotation matrix ``rows`` and moved by ``xyz`` (metres)."""
        import numpy as np

        rotation = np.asarray(rows, dtype=np.float64)
        moved = triangles if (rotation == np.eye(3)).all() else triangles @ rotation.T
        offset = np.asarray(xyz, dtype=np.float64)
        return moved + offset if offset.any() else moved


def load_mesh(path: Path, scale: Sequence[float] = (1.0, 1.0, 1.0), coloured: bool = False) -> TriangleMesh:
    """Return the triangles of a mesh file, of all geometries of its scene, times ``scale``.

    The numbers of STL, OBJ and glTF times ``scale`` are metres. The unit of a DAE is applied, its up axis is not: z of
    the file is height. ``coloured``: with the colours of its materials; a material with an image is white.
    Raises NotThere if there is no such file, else ExtractProblem.
    """
    TriangleMesh.needed()
    import numpy as np

    kind = path.suffix.lower().removeprefix(".")
    if kind not in TriangleMesh.FORMATS:
        known = ", ".join(f".{name}" for name in TriangleMesh.FORMATS)
        help = "convert it; the ending of the name says the format"
        raise ExtractProblem.of("mesh-unreadable", f"{path} is none of {known}", help)
    data = _read(path)
    unit = _checked_unit(path, data) if kind == "dae" else 1.0
    parsed = [piece for piece in _parse(path, kind, data, coloured) if len(piece[0])]
    if not parsed:
        raise ExtractProblem.of("mesh-empty", f"{path} has no triangle", "name a mesh that has a surface")
    triangles = np.concatenate([piece for piece, _ in parsed])
    factors = np.asarray(scale, dtype=np.float64) * unit
    if not (factors == 1.0).all():
        triangles = triangles * factors
        if factors.prod() < 0:  # the corners of a mirrored mesh go round the other way
            triangles = triangles[:, ::-1]
    if not np.isfinite(triangles).all():
        raise _unreadable(f"{path} has corners that are not finite numbers")
    runs = groupby(parsed, lambda piece: piece[1])
    colours = tuple((sum(len(piece) for piece, _ in run), colour) for colour, run in runs)
    return TriangleMesh(path.name, triangles, colours if coloured else ())


def mesh_inertial(path: Path, scale: Sequence[float]) -> Inertial:
    """Return the inertial of a closed mesh of density 1 kg/m^3, in the frame of the file. Raises ExtractProblem."""
    triangles = load_mesh(path, scale).triangles
    import numpy as np
    import trimesh

    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=True)
    if not mesh.is_watertight or not abs(mesh.volume) > 0:
        raise _unreadable(f"{path} is not a closed mesh", "close it, or list primitive shapes")
    x, y, z = map(float, mesh.center_mass)
    moments = mesh.moment_inertia * (1 if mesh.volume > 0 else -1)
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = moments.tolist()
    return Inertial(abs(float(mesh.volume)), Pose((x, y, z)), ixx, iyy, izz, ixy, ixz, iyz)


def _unreadable(message: str, help: str = _AGAIN) -> ExtractProblem:
    return ExtractProblem.of("mesh-unreadable", message, help)


def _missing(message: str) -> ExtractProblem:
    help = f"{pip_install('import')} brings what reads meshes"
    return ExtractProblem.of("extra-missing", f"{message}, which is not installed", help)


def _read(path: Path) -> bytes:
    try:
        if files.is_special(path):
            raise _unreadable(f"{path} is no regular file", "name a mesh file")
        if files.is_file(path) and path.stat().st_size > MAX_BYTES:
            raise _unreadable(f"{path} is larger than {MAX_BYTES:,} bytes", "reduce the number of triangles")
        data = files.read_bytes(path)
    except (FileNotFoundError, NotADirectoryError):
        raise NotThere.of("mesh-unreadable", f'there is no file "{path}"', "check the name") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise _unreadable(f"cannot read {path}: {reason}", "check the name and the permissions") from None
    if not data:
        raise ExtractProblem.of("mesh-empty", f"{path} is an empty file", _AGAIN)
    return data


def _checked_unit(path: Path, data: bytes) -> float:
    """Return the unit of a DAE in metres (COLLADA 1.4.1, <unit meter="...">, default 1). Raises ExtractProblem.

    A DTD is refused: entities can make a small file endless or read other files. So is a corner that is not a finite
    number of 32 bits: pycollada 0.9 turns NaN into zero, and trimesh leaves out triangles with infinite corners.
    """
    from xml.etree import ElementTree

    import numpy as np

    if re.search(rb"<!\s*(DOCTYPE|ENTITY)", data.replace(b"\0", b""), re.IGNORECASE):  # without the zeros of UTF-16
        raise _unreadable(f"{path} has a DTD, which no mesh needs", "remove the <!DOCTYPE ...>")
    try:
        root = ElementTree.fromstring(data)  # noqa: S314 - it has no DTD, so no entities
    except (ElementTree.ParseError, ValueError, LookupError):
        return 1.0  # trimesh reports the reason
    inputs = [entry for entry in root.iterfind(".//{*}vertices/{*}input") if entry.get("semantic") == "POSITION"]
    names = {entry.get("source", "").removeprefix("#") for entry in inputs}
    for source in root.iterfind(".//{*}source[@id]"):
        words = (source.findtext("{*}float_array") or "").split() if source.get("id") in names else []
        try:
            with np.errstate(over="ignore"):
                is_finite = bool(np.isfinite(np.array(words, np.float64).astype(np.float32)).all())
        except ValueError:
            is_finite = False
        if not is_finite:
            raise _unreadable(f"{path} has corners that are not finite numbers")
    found = root.find(".//{*}unit[@meter]")
    try:
        unit = float(found.get("meter", "1")) if found is not None else 1.0
    except ValueError:
        return 1.0
    return unit if math.isfinite(unit) and unit > 0 else 1.0


def _parse(path: Path, kind: str, data: bytes, coloured: bool) -> list[tuple[Floats, Colour | None]]:
    """Return the triangles of each geometry of a file, and its colour if requested. Raises ExtractProblem."""
    import logging
    import warnings

    import trimesh

    options: dict[str, Any] = {"process": False}
    if kind == "gltf":
        options["resolver"] = _Resolver(partial(_buffer, path.parent))
    if kind == "obj" and coloured:
        options["resolver"] = _Resolver(partial(_materials, path.parent))
    elif kind in ("obj", "gltf", "glb"):
        options["skip_materials"] = True
    log = logging.getLogger("trimesh")  # which logs whole tracebacks of a broken file, and goes on
    level = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return list(_pieces(path, trimesh.load(io.BytesIO(data), file_type=kind, **options)))
    except ExtractProblem:
        raise
    except ImportError as problem:
        raise _missing(f"reading {path.suffix} files needs the package {problem.name or 'pycollada'}") from None
    except Exception as problem:  # a reader can raise anything for a broken file
        reason = " ".join(str(problem).split())[:200] or type(problem).__name__
        message = f"{path} is not a mesh that can be read as {kind.upper()}: {reason}"
        raise _unreadable(message, "export it again; the ending says the format") from None
    finally:
        log.setLevel(level)


def _pieces(path: Path, loaded: Any) -> Iterator[tuple[Floats, Colour | None]]:
    """Yield triangles and colour of each geometry at its place in the scene; lines have no triangles."""
    import numpy as np
    import trimesh

    if isinstance(loaded, trimesh.Trimesh):
        yield _triangles(path, loaded), _colour(loaded)
    elif isinstance(loaded, trimesh.Scene):
        for node in sorted(loaded.graph.nodes_geometry):
            matrix, name = loaded.graph[node]
            geometry = loaded.geometry.get(name)
            if isinstance(geometry, trimesh.Trimesh):
                matrix = np.asarray(matrix, dtype=np.float64)
                moved = TriangleMesh.placed(_triangles(path, geometry), matrix[:3, :3].tolist(), matrix[:3, 3].tolist())
                yield moved[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else moved, _colour(geometry)


def _colour(mesh: Any) -> Colour | None:
    """Return the colour of the material of a Trimesh (sRGB, 0 to 1), or None if it has none."""
    material = getattr(mesh.visual, "material", None)
    colour = getattr(material, "main_color", None)
    if colour is None or getattr(material, "name", "") == _NAMELESS:
        return None
    red, green, blue = (float(part) / 255 for part in colour[:3])
    return red, green, blue


def _triangles(path: Path, mesh: Any) -> Floats:
    """Return the triangles (n, 3, 3) of a Trimesh. Raises ExtractProblem for corners that the file does not have."""
    import numpy as np

    corners = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(mesh.faces).reshape(-1, 3)
    broken = int(((faces < 0) | (faces >= len(corners))).any(axis=1).sum())
    if broken:
        raise _unreadable(f"{path} has {counted(broken, 'triangle')} with a corner that the file does not have")
    triangles: Floats = corners[faces]
    return triangles


class _Resolver:
    """Give trimesh the side files of a mesh, by a function that raises FileNotFoundError."""

    def __init__(self, get: Callable[[str], bytes]) -> None:
        self.get = get

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)


def _materials(folder: Path, name: str) -> bytes:
    """Return the materials of an OBJ, without images: a material with an image is white."""
    file = folder / name
    if not name.lower().endswith(".mtl") or Path(name).is_absolute() or not files.is_file(file):
        raise FileNotFoundError(f"{name} is not beside it")
    blocks = re.split(rb"(?mi)^(?=[ \t]*newmtl\b)", files.read_bytes(file, _MAX_MATERIALS))
    return b"".join(_WHITE.sub(b"Kd 1 1 1", _MAP.sub(b"", one)) if _MAP.search(one) else one for one in blocks)


def _buffer(folder: Path, name: str) -> bytes:
    """Return a buffer of a .gltf in its folder or below."""
    file = files.resolve(folder / name)
    if not file.is_relative_to(files.resolve(folder)) or not files.is_file(file):
        raise FileNotFoundError(f'the buffer "{name}" is not beside it')
    return files.read_bytes(file)

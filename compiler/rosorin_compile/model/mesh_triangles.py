"""Meshes: a file becomes triangles in metres. trimesh reads the formats; nothing but the triangles is taken from it.

Files are foreign: one that is broken, empty or hostile gives an ``ExtractProblem``, never a traceback. Side
files are not read, except the buffers of a .gltf that stand beside it; a .dae with a DTD is not even parsed.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
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
_MOST_MATERIALS = 1_000_000  # bytes
_MAP, _WHITE = re.compile(rb"(?mi)^[ \t]*map_Kd\b[^\r\n]*"), re.compile(rb"(?mi)^[ \t]*Kd\b[^\r\n]*")
_NAMELESS = "material_0"  # what trimesh calls a material that it made up
_ENDLESS = "has corners that are not finite numbers"


Colour = tuple[float, float, float]


class ExtractProblem(Exception):
    """What keeps numbers from being taken out of a mesh; carries the diagnostic that says why, and the way out."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic

    @classmethod
    def of(cls, rule: str, message: str, help: str = "", span: Span | None = None) -> ExtractProblem:
        """Return a problem, to be raised."""
        return cls(error(rule, message, span, help))


class NotThere(ExtractProblem):
    """What is asked for by name is not there: a file, a robot, a package, a link. For commands it is wrong usage."""


@dataclass(frozen=True)
class TriangleMesh:
    """Triangles of a mesh: ``triangles`` is (n, 3, 3), corners in metres, counter-clockwise seen from outside.

    ``colours`` has for each run of triangles how many they are and their colour (sRGB, 0 to 1), if the file has one.
    """

    name: str
    triangles: Floats
    colours: tuple[tuple[int, Colour | None], ...] = ()

    FORMATS: ClassVar[tuple[str, ...]] = ("stl", "obj", "dae", "gltf", "glb")

    @staticmethod
    def load(path: Path, scale: Sequence[float] = (1.0, 1.0, 1.0), coloured: bool = False) -> TriangleMesh:
        """Return the triangles of a mesh file in metres, as ``load_mesh``. Raises NotThere, ExtractProblem."""
        return load_mesh(path, scale, coloured)

    @classmethod
    def of_shape(
        cls, case: Case, shape: tuple[str, str, int], files: Mapping[str, Path], coloured: bool = False
    ) -> TriangleMesh | Diagnostic:
        """Return the mesh of a shape, or a warning at its place if it cannot be read.

        ``shape`` is the link, "visual" or "collision", and the number there; ``files`` were found by the names in the
        description.
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
            message = f"reading meshes needs the package {problem.name}, which is not installed"
            raise ExtractProblem.of("extra-missing", message, _install()) from None

    @staticmethod
    def placed(triangles: Floats, rows: Sequence[Sequence[float]], xyz: Sequence[float]) -> Floats:
        """Return triangles (n, 3, 3) turned by the rotation matrix ``rows`` and moved by ``xyz`` (metres)."""
        import numpy as np

        rotation = np.asarray(rows, dtype=np.float64)
        moved = triangles if (rotation == np.eye(3)).all() else triangles @ rotation.T
        offset = np.asarray(xyz, dtype=np.float64)
        return moved + offset if offset.any() else moved


def load_mesh(path: Path, scale: Sequence[float] = (1.0, 1.0, 1.0), coloured: bool = False) -> TriangleMesh:
    """Return the triangles of a mesh file: all geometries of its scene where the scene places them, times ``scale``.

    STL, OBJ and glTF have no unit that differs from file to file: their numbers times ``scale`` are metres. A DAE names
    its unit, which is applied; its up axis is not: what the file has along z is height. ``coloured``: with the colours
    of its materials, those of an OBJ from the files beside it; what has an image is white.
    Raises NotThere if there is no such file, else ExtractProblem.
    """
    TriangleMesh.needed()
    import numpy as np

    kind = _format(path)
    data = _read(path)
    if kind == "dae":
        _refuse_dtd(path, data)
        _refuse_endless(path, data)
    parsed = [piece for piece in _parsed(path, kind, data, coloured) if len(piece[0])]
    pieces = [triangles for triangles, _ in parsed]
    if not pieces:
        raise ExtractProblem.of("mesh-empty", f"{path} has no triangle", "name a mesh that has a surface")
    triangles = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
    factors = np.asarray(scale, dtype=np.float64) * (_unit(data) if kind == "dae" else 1.0)
    if not (factors == 1.0).all():
        triangles = triangles * factors
        if factors.prod() < 0:  # a mirrored mesh is inside out until its corners go round the other way
            triangles = triangles[:, ::-1]
    if not np.isfinite(triangles).all():
        raise ExtractProblem.of("mesh-unreadable", f"{path} {_ENDLESS}", "export it anew")
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
        raise ExtractProblem.of("mesh-unreadable", f"{path} is not a closed mesh", "close it, or list primitive shapes")
    x, y, z = map(float, mesh.center_mass)
    moments = mesh.moment_inertia * (1 if mesh.volume > 0 else -1)
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = moments.tolist()
    return Inertial(abs(float(mesh.volume)), Pose((x, y, z)), ixx, iyy, izz, ixy, ixz, iyz)


def _install() -> str:
    return f"{pip_install('import')} brings what reads meshes"


def _format(path: Path) -> str:
    kind = path.suffix.lower().removeprefix(".")
    if kind not in TriangleMesh.FORMATS:
        message = f"{path} is none of {', '.join(f'.{name}' for name in TriangleMesh.FORMATS)}"
        raise ExtractProblem.of("mesh-unreadable", message, "convert it; the ending of the name says the format")
    return kind


def _read(path: Path) -> bytes:
    try:
        if files.is_special(path):
            raise ExtractProblem.of("mesh-unreadable", f"{path} is no regular file", "name a mesh file")
        if files.is_file(path) and path.stat().st_size > MAX_BYTES:
            help = "reduce the number of triangles"
            raise ExtractProblem.of("mesh-unreadable", f"{path} is larger than {MAX_BYTES:,} bytes", help)
        data = files.read_bytes(path)
    except (FileNotFoundError, NotADirectoryError):
        raise NotThere.of("mesh-unreadable", f'there is no file "{path}"', "check the name") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        help = "check the name and the permissions"
        raise ExtractProblem.of("mesh-unreadable", f"cannot read {path}: {reason}", help) from None
    if not data:
        raise ExtractProblem.of("mesh-empty", f"{path} is an empty file", "export it anew")
    return data


def _refuse_dtd(path: Path, data: bytes) -> None:
    """Raise ExtractProblem for a DTD: entities can make a small file endless or read other files."""
    text = data.replace(b"\0", b"")  # of UTF-16 this leaves the letters that matter
    if re.search(rb"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):
        message = f"{path} has a DTD, which no mesh needs"
        raise ExtractProblem.of("mesh-unreadable", message, "remove the <!DOCTYPE ...>")


def _refuse_endless(path: Path, data: bytes) -> None:
    """Raise ExtractProblem for a DAE with a corner that is not a finite number of 32 bits.

    pycollada 0.9 silently turns NaN into zero, and trimesh leaves out triangles with infinite corners.
    """
    from xml.etree import ElementTree

    import numpy as np

    try:
        root = ElementTree.fromstring(data)  # noqa: S314 - it has no DTD, so no entities
    except (ElementTree.ParseError, ValueError, LookupError):
        return  # what reads the file says what is wrong
    inputs = (one for one in root.iterfind(".//{*}vertices/{*}input") if one.get("semantic") == "POSITION")
    named = {one.get("source", "").removeprefix("#") for one in inputs}
    for source in root.iterfind(".//{*}source[@id]"):
        words = (source.findtext("{*}float_array") or "").split() if source.get("id") in named else []
        try:
            with np.errstate(over="ignore"):
                is_finite = bool(np.isfinite(np.array(words, np.float64).astype(np.float32)).all())
        except ValueError:
            is_finite = False
        if not is_finite:
            raise ExtractProblem.of("mesh-unreadable", f"{path} {_ENDLESS}", "export it anew")


def _unit(data: bytes) -> float:
    """Return the unit of a DAE in metres (COLLADA 1.4.1, <unit meter="...">, default 1)."""
    match = re.search(rb"<unit\b[^>]*\bmeter\s*=\s*[\"']\s*([^\"']+?)\s*[\"']", data[:100_000])
    try:
        unit = float(match[1]) if match else 1.0
    except ValueError:
        return 1.0
    return unit if math.isfinite(unit) and unit > 0 else 1.0


def _parsed(path: Path, kind: str, data: bytes, coloured: bool) -> list[tuple[Floats, Colour | None]]:
    """Return the triangles of each geometry of a file, and its colour if that is asked for. Raises ExtractProblem."""
    import trimesh

    options: dict[str, Any] = {"process": False}
    if kind in ("obj", "gltf", "glb") and not (coloured and kind == "obj"):
        options["skip_materials"] = True
    resolver: Any = _Beside(path) if kind == "gltf" else _Materials(path) if coloured and kind == "obj" else None
    try:
        with _quiet():
            return list(_pieces(path, trimesh.load(io.BytesIO(data), file_type=kind, resolver=resolver, **options)))
    except ExtractProblem:
        raise
    except ImportError as problem:
        message = f"reading {path.suffix} files needs the package {problem.name or 'pycollada'}, which is not installed"
        raise ExtractProblem.of("extra-missing", message, _install()) from None
    except Exception as problem:  # whatever a reader stumbles over in a broken file
        reason = " ".join(str(problem).split())[:200] or type(problem).__name__
        message = f"{path} is not a mesh that can be read as {kind.upper()}: {reason}"
        raise ExtractProblem.of("mesh-unreadable", message, "export it anew; the ending says the format") from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what trimesh logs off the terminal: of a broken file it logs whole tracebacks, and goes on."""
    import logging
    import warnings

    log = logging.getLogger("trimesh")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        log.setLevel(before)


def _pieces(path: Path, loaded: Any) -> Iterator[tuple[Floats, Colour | None]]:
    """Yield triangles and colour of each geometry of what trimesh loaded, where the scene puts it; lines have none."""
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
    """Return the colour of the material of a Trimesh (sRGB, 0 to 1); None if it has none."""
    material = getattr(mesh.visual, "material", None)
    colour = getattr(material, "main_color", None)
    if colour is None or getattr(material, "name", "") == _NAMELESS:
        return None
    red, green, blue = (float(part) / 255 for part in colour[:3])
    return red, green, blue


def _triangles(path: Path, mesh: Any) -> Floats:
    """Return the triangles (n, 3, 3) of a Trimesh; a file that names corners it does not have has no such triangle."""
    import numpy as np

    corners = np.asarray(mesh.vertices, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(mesh.faces).reshape(-1, 3)
    if len(corners) == faces.size and (faces.ravel() == np.arange(faces.size)).all():
        return corners.reshape(-1, 3, 3)  # an STL: each corner stands once for each triangle
    legal = ((faces >= 0) & (faces < len(corners))).all(axis=1)
    if not legal.all():
        what = counted(int((~legal).sum()), "triangle")
        message = f"{path} has {what} with a corner that the file does not have"
        raise ExtractProblem.of("mesh-unreadable", message, "export it anew")
    triangles: Floats = corners[faces]
    return triangles


class _Materials:
    """Gives trimesh the materials of an OBJ that stand beside it, and no image: what has one is white."""

    def __init__(self, path: Path) -> None:
        self.folder = path.parent

    def get(self, name: str) -> bytes:
        """Return a file of materials. Raises FileNotFoundError for what is none."""
        file = self.folder / name
        if not name.lower().endswith(".mtl") or Path(name).is_absolute() or not files.is_file(file):
            raise FileNotFoundError(f"{name} is not beside it")
        blocks = re.split(rb"(?mi)^(?=[ \t]*newmtl\b)", files.read_bytes(file, _MOST_MATERIALS))
        return b"".join(_WHITE.sub(b"Kd 1 1 1", _MAP.sub(b"", one)) if _MAP.search(one) else one for one in blocks)

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)


class _Beside:
    """Gives trimesh the buffers that a .gltf names, if they stand in its folder or below, and nothing else."""

    def __init__(self, path: Path) -> None:
        self.folder = path.parent

    def get(self, name: str) -> bytes:
        """Return the bytes of a side file. Raises FileNotFoundError for one that is elsewhere."""
        inside = files.resolve(self.folder / name)
        if not inside.is_relative_to(files.resolve(self.folder)) or not files.is_file(inside):
            raise FileNotFoundError(f'the buffer "{name}" is not beside it')
        return files.read_bytes(inside)

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

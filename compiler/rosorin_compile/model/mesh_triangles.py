"""Read the triangles of mesh files in metres with trimesh.

Broken, empty or malicious files raise ``ExtractProblem``. Buffers of a .gltf and materials of an .obj are read only
from the folder of the mesh. A .dae with a DTD is rejected.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Help, SourceError, Span, error
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.wording import count_of

from .geometry import Pose
from .link import Inertial

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from rosorin_compile.rules.case import Case

    Floats = NDArray[np.float64]

MAX_BYTES = 2_000_000_000
_MAX_MATERIALS = 1_000_000  # bytes
_MAP, _WHITE = re.compile(rb"(?mi)^[ \t]*map_Kd\b[^\r\n]*"), re.compile(rb"(?mi)^[ \t]*Kd\b[^\r\n]*")
_NAMELESS = "material_0"  # the name that trimesh gives to an unnamed material
_UNIT = re.compile(rb"""<unit\b[^>]*\bmeter\s*=\s*["']\s*(\d+\.?\d*(?:[eE][+-]?\d+)?)\s*["']""")  # COLLADA 1.4.1

Colour = tuple[float, float, float]


class ExtractProblem(SourceError):
    """Raised if a mesh cannot be used; ``diagnostic`` explains the reason and the fix."""

    @classmethod
    def new(cls, rule: str, message: str, help: Help = "", span: Span | None = None) -> ExtractProblem:
        return cls(error(rule, message, span, help))


class NotFound(ExtractProblem):
    """Raised if a file, robot, package or link does not exist. Commands then exit with the code of a usage error."""


@dataclass(frozen=True)
class TriangleMesh:
    """The triangles of a mesh and their colours."""

    name: str
    triangles: Floats  # (n, 3, 3): corners in metres, counter-clockwise seen from outside
    colours: tuple[tuple[int, Colour | None], ...] = ()  # runs of triangles: (count, sRGB from 0 to 1 or None)

    FORMATS: ClassVar[tuple[str, ...]] = ("stl", "obj", "dae", "gltf", "glb")

    @classmethod
    def of_shape(
        cls, case: Case, shape: tuple[str, str, int], files: Mapping[str, Path], coloured: bool = False
    ) -> TriangleMesh | Diagnostic:
        """Load the mesh of a shape, identified by (link, "visual" or "collision", index), or return a warning."""
        link, purpose, number = shape
        mesh = getattr(case.robot.link[link], purpose)[number].geometry
        message, help = f'the mesh {mesh.file} of link "{link}" is not found', "its shape is left out here"
        try:
            if mesh.file in files:
                return load_mesh(files[mesh.file], mesh.scale, coloured)
            help += "; a package is named by --package NAME=PATH"
        except ExtractProblem as problem:
            message = problem.diagnostic.message
            help += f"; {problem.diagnostic.help}" if problem.diagnostic.rule == "extra-missing" else ""
        path = (*case.link(link), purpose, number, "mesh", "file")
        return case.problem("mesh-unreadable", message, path, help, severity=WARNING)

    @staticmethod
    def require_packages() -> None:
        """Raise ExtractProblem if a package that is needed to read meshes is not installed."""
        try:
            import numpy  # noqa: F401
            import scipy  # type: ignore[import-untyped,unused-ignore]  # noqa: F401
            import trimesh  # noqa: F401
        except ImportError as problem:
            raise _missing(f"reading meshes needs the package {problem.name}") from None

    @staticmethod
    def place(triangles: Floats, rows: Sequence[Sequence[float]], xyz: Sequence[float]) -> Floats:
        """Rotate triangles (n, 3, 3) by the matrix ``rows``, then translate them by ``xyz`` (m)."""
        import numpy as np

        moved: Floats = triangles @ np.asarray(rows, np.float64).T + np.asarray(xyz, np.float64)
        return moved


def load_mesh(path: Path, scale: Sequence[float] = (1.0, 1.0, 1.0), coloured: bool = False) -> TriangleMesh:
    """Load the triangles of a mesh file, in metres.

    Coordinates are multiplied by ``scale`` and, in a DAE, by the unit of the file. The up axis of a DAE is ignored: z
    is up. With ``coloured``, the colours of materials are read; a material with an image is white. Raises NotFound for
    a missing file, and ExtractProblem for an unusable file.
    """
    TriangleMesh.require_packages()
    import numpy as np

    kind = path.suffix.lower().removeprefix(".")
    if kind not in TriangleMesh.FORMATS:
        known = ", ".join(f".{name}" for name in TriangleMesh.FORMATS)
        raise _unreadable(f"{path} is none of {known}", "convert it; the ending of the name says the format")
    try:
        data = files.read_bytes(path, MAX_BYTES + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise NotFound.new("mesh-unreadable", f'there is no file "{path}"', "check the name") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise _unreadable(f"cannot read {path}: {reason}", "check the name and the permissions") from None
    if len(data) > MAX_BYTES:
        raise _unreadable(f"{path} is larger than {MAX_BYTES:,} bytes", "reduce the number of triangles")
    if not data:
        raise ExtractProblem.new("mesh-empty", f"{path} is an empty file", "export it again")
    text = data.replace(b"\0", b"") if kind == "dae" else b""  # without zero bytes, UTF-16 looks like ASCII
    if re.search(rb"<!\s*(DOCTYPE|ENTITY)", text, re.IGNORECASE):  # entities may expand endlessly or read other files
        raise _unreadable(f"{path} has a DTD, which no mesh needs", "remove the <!DOCTYPE ...>")
    # Check all positions, because pycollada reads those that do not fit into 32-bit floats as zero.
    for name in re.findall(rb"""semantic=["']POSITION["']\s+source=["']#([^"']+)["']""", text):
        array = re.search(rb"<source\s+id=.%s.[^>]*>\s*<float_array[^>]*>([^<]*)" % re.escape(name), text)
        corners = None
        with np.errstate(over="ignore"), suppress(ValueError):
            corners = np.array(array[1].split() if array else (), np.float64).astype(np.float32)
        if corners is None or not np.isfinite(corners).all():
            raise _unreadable(f"{path} has corners that are not finite numbers")
    parsed = [piece for piece in _parse(path, kind, data, coloured) if len(piece[0])]
    if not parsed:
        raise ExtractProblem.new("mesh-empty", f"{path} has no triangle", "name a mesh that has a surface")
    triangles = np.concatenate([piece for piece, _ in parsed])
    unit = _UNIT.search(text)
    factors = np.asarray(scale, dtype=np.float64) * (float(unit[1]) if unit else 1.0)
    if not (factors == 1.0).all():
        triangles = triangles * factors
        if factors.prod() < 0:  # mirroring turns triangles inside out, so reverse the order of their corners
            triangles = triangles[:, ::-1]
    if not np.isfinite(triangles).all():
        raise _unreadable(f"{path} has corners that are not finite numbers")
    runs = groupby(parsed, lambda piece: piece[1])
    colours = tuple((sum(len(piece) for piece, _ in run), colour) for colour, run in runs)
    return TriangleMesh(path.name, triangles, colours if coloured else ())


def mesh_inertial(path: Path, scale: Sequence[float]) -> Inertial:
    """Return the inertial of a mesh with density 1 kg/m^3. Raises ExtractProblem if it is unreadable or not closed."""
    triangles = load_mesh(path, scale).triangles
    import numpy as np
    import trimesh

    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=True)
    if not mesh.is_watertight or not abs(mesh.volume) > 0:
        raise _unreadable(f"{path} is not a closed mesh", "close it, or list primitive shapes")
    (ixx, ixy, ixz), (_, iyy, iyz), (_, _, izz) = (mesh.moment_inertia * np.sign(mesh.volume)).tolist()
    return Inertial(abs(float(mesh.volume)), Pose(tuple(mesh.center_mass.tolist())), ixx, iyy, izz, ixy, ixz, iyz)


def _unreadable(message: str, help: str = "export it again") -> ExtractProblem:
    return ExtractProblem.new("mesh-unreadable", message, help)


def _missing(message: str) -> ExtractProblem:
    help = f"{pip_install('import')} brings what reads meshes"
    return ExtractProblem.new("extra-missing", f"{message}, which is not installed", help)


def _parse(path: Path, kind: str, data: bytes, coloured: bool) -> list[tuple[Floats, Colour | None]]:
    import logging
    import warnings

    import trimesh

    options: dict[str, Any] = {"process": False, "resolver": _Resolver(path.parent)}
    if kind in ("gltf", "glb") or (kind == "obj" and not coloured):
        options["skip_materials"] = True
    log = logging.getLogger("trimesh")  # silenced, because trimesh logs tracebacks for broken files
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
    except Exception as problem:  # trimesh can raise any exception for a broken file
        reason = " ".join(str(problem).split())[:200] or type(problem).__name__
        message = f"{path} is not a mesh that can be read as {kind.upper()}: {reason}"
        raise _unreadable(message, "export it again; the ending says the format") from None
    finally:
        log.setLevel(level)


def _pieces(path: Path, loaded: Any) -> Iterator[tuple[Floats, Colour | None]]:
    import numpy as np
    import trimesh

    scene = loaded if isinstance(loaded, trimesh.Scene) else trimesh.Scene(loaded)
    for matrix, name in (scene.graph[node] for node in sorted(scene.graph.nodes_geometry)):
        mesh = scene.geometry.get(name)
        if not isinstance(mesh, trimesh.Trimesh):
            continue
        corners, faces = np.asarray(mesh.vertices, np.float64).reshape(-1, 3), np.asarray(mesh.faces).reshape(-1, 3)
        if broken := int(((faces < 0) | (faces >= len(corners))).any(axis=1).sum()):
            raise _unreadable(f"{path} has {count_of(broken, 'triangle')} with a corner that the file does not have")
        triangles = TriangleMesh.place(corners[faces], matrix[:3, :3].tolist(), matrix[:3, 3].tolist())
        triangles = triangles[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else triangles
        material, colour = getattr(mesh.visual, "material", None), None
        main = getattr(material, "main_color", None)
        if main is not None and getattr(material, "name", "") != _NAMELESS:
            colour = float(main[0]) / 255, float(main[1]) / 255, float(main[2]) / 255
        yield triangles, colour


class _Resolver:
    """Open files for trimesh, but only below the folder of the mesh. Materials with an image become white."""

    def __init__(self, folder: Path) -> None:
        self.folder = files.resolve(folder)

    def __getitem__(self, name: str) -> bytes:
        file = files.resolve(self.folder / name)
        if not file.is_relative_to(self.folder) or not files.is_file(file):
            raise FileNotFoundError(f'the file "{name}" is not next to it')
        if file.suffix.lower() != ".mtl":
            return files.read_bytes(file)
        blocks = re.split(rb"(?mi)^(?=[ \t]*newmtl\b)", files.read_bytes(file, _MAX_MATERIALS))
        return b"".join(_WHITE.sub(b"Kd 1 1 1", _MAP.sub(b"", one)) if _MAP.search(one) else one for one in blocks)

"""The inputs of extract: the grid of a height map, and meshes in files or of the links of a robot in their frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.model import Mesh, Robot
from rosorin_compile.model.mesh_triangles import ExtractProblem, TriangleMesh, load_mesh
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, RequestError, UnknownName
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description, NoDescription
from rosorin_compile.source.tree import Map

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

MAX_DIGITS = 9


@dataclass(frozen=True)
class GridOptions:
    """The options of a height map, lengths in metres; ``size`` is another way to give ``cells``.

    By default, cells are 10 mm and cover the mesh, and ``step`` is a cell. ``below`` removes the surface above a
    height. ``bottom``: also compute the lowest point of the mesh. Raises RequestError for options that are out of range
    or exclude each other.
    """

    cell: float | None = None
    origin: tuple[float, float] | None = None
    cells: tuple[int, int] | None = None
    size: tuple[float, float] | None = None
    below: float | None = None
    digits: int = 4
    step: float | None = None
    bottom: bool = False

    def __post_init__(self) -> None:
        for name, values in {"cell": (self.cell,), "step": (self.step,), "size": self.size or ()}.items():
            if any(value is not None and not value > 0 for value in values):
                raise RequestError(f'--{name} takes lengths above zero, not "{",".join(map(str, values))}"')
        if self.cells is not None and self.size is not None:
            raise RequestError("--cells and --size exclude each other; give one")
        if not 0 <= self.digits <= MAX_DIGITS:
            raise RequestError(f"--map-digits takes 0 to {MAX_DIGITS} decimals")


@dataclass(frozen=True)
class Part:
    """A named body: its triangles (n, 3, 3) in its own frame in metres, and the names of its mesh files."""

    name: str
    triangles: Floats
    meshes: tuple[str, ...]


@dataclass
class RobotSource:
    """A robot: its model, the tree that it was built from, and where its meshes are searched."""

    robot: Robot
    tree: Map
    folder: Path
    packages: Packages
    diagnostics: list[Diagnostic]

    @classmethod
    def read(cls, name: str, options: ReadOptions, diagnostics: list[Diagnostic]) -> RobotSource:
        """Read a robot in any format, by name, folder or file; add the warnings about its file to ``diagnostics``.

        Raises RequestError if there is none, ExtractProblem for its first error; ``diagnostics`` gets the others.
        """
        try:
            (description,) = Description.find([name])
        except NoDescription as problem:
            raise RequestError(f"{problem}; or name mesh files, or a URDF") from None
        request = Request(description, options.arguments, (), options.packages, options.trust, options.tell)
        reading = request.read(options.lenient)
        if reading.robot is None or reading.tree is None:
            first = next(one for one in reading.diagnostics if one.severity == ERROR)
            diagnostics += [one for one in reading.diagnostics if one is not first]
            raise ExtractProblem(first)
        # Elements that cannot be converted hold no joint and no mesh; `check` reports those of a description.
        found = reading.diagnostics if request.is_foreign else ()
        diagnostics += [one for one in found if one.severity != NOTE and one.rule != "import-cannot-carry"]
        path = description.path
        return cls(reading.robot, reading.tree, path.parent, Packages(options.packages, os.environ, path), diagnostics)

    def link(self, name: str) -> str:
        """Return the name of a link. Raises UnknownName if the robot has no link of this name."""
        if name not in self.robot.link:
            raise UnknownName("link", name, self.robot.link, "the robot")
        return name

    def part(self, link: str, section: str) -> Part | None:
        """Return the meshes of a link in its frame, or None if it has none that can be read.

        ``section`` is collision, visual, or auto: collision if there are meshes, else visual. A mesh that is missing or
        cannot be read is a warning in ``diagnostics``, at the line that names it.
        """
        import numpy as np

        shapes = {"collision": self.robot.link[link].collision, "visual": self.robot.link[link].visual}
        if section == "auto":
            has_mesh = any(isinstance(shape.geometry, Mesh) for shape in shapes["collision"])
            section = "collision" if has_mesh else "visual"
        pieces, names = [], []
        for number, shape in enumerate(shapes[section]):
            if not isinstance(shape.geometry, Mesh):
                continue
            address = shape.geometry.file
            path = self.packages.resolve(address, self.folder)
            try:
                if path is None or not files.is_file(path):
                    package = address.split("://")[-1].split("/")[0]
                    help = f"name its folder: --package {package}=FOLDER" if path is None else ""
                    raise ExtractProblem.new("mesh-missing", f"{section} of {link}: there is no file {address}", help)
                mesh = load_mesh(Path(files.label(path)), shape.geometry.scale)
            except ExtractProblem as problem:
                span = self.tree.locate(("links", link, section, number, "mesh", "file")).span
                self.diagnostics.append(replace(problem.diagnostic, severity=WARNING, span=span))
                continue
            transform = shape.pose.transform()
            pieces.append(TriangleMesh.place(mesh.triangles, transform.rows, transform.xyz))
            names.append(mesh.name)
        return Part(link, np.concatenate(pieces), tuple(dict.fromkeys(names))) if pieces else None


def read_parts(
    names: Sequence[str],
    links: Sequence[str],
    section: str,
    scale: Sequence[float],
    options: ReadOptions,
    diagnostics: list[Diagnostic],
) -> tuple[list[Part], RobotSource | None]:
    """Return a part for each mesh file, or for each link with meshes of one robot, and that robot.

    ``scale`` has factors of mesh files along x, y and z; ``links`` selects links. Warnings are added to
    ``diagnostics``. Raises RequestError, ExtractProblem.
    """
    if names and all(Path(name).suffix.lower().removeprefix(".") in TriangleMesh.FORMATS for name in names):
        if links:
            raise RequestError("--link selects a link of a robot; a mesh file has none")
        bodies: dict[str, Part] = {}
        for name in names:
            mesh, stem = load_mesh(Path(name), scale), Path(name).stem
            longest = float((mesh.triangles.max(axis=(0, 1)) - mesh.triangles.min(axis=(0, 1))).max())
            if longest > 20:
                message = f"{mesh.name} is {longest:g} m long; that looks like millimetres"
                help = "--scale 0.001 turns millimetres into metres"
                diagnostics.append(Diagnostic("mesh-looks-like-millimetres", WARNING, message, None, (), help))
            if stem in bodies:
                raise RequestError(f'two meshes are called "{stem}"; each part needs a different name')
            bodies[stem] = Part(stem, mesh.triangles, (mesh.name,))
        return list(bodies.values()), None
    if len(names) != 1:
        raise RequestError("name mesh files, or one robot")
    source = RobotSource.read(names[0], options, diagnostics)
    selected = [source.link(name) for name in links] or list(source.robot.link)
    parts = [part for name in selected if (part := source.part(name, section)) is not None]
    if not parts:
        message = f"{', '.join(links) or names[0]} has no mesh that can be read"
        raise ExtractProblem.new("mesh-empty", message, "see above, or --from")
    return parts, source

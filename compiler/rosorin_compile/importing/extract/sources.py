"""The inputs of extract: the grid of a height map, and meshes in files or of the links of a robot in their frames."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.model import Mesh, Robot
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh, load_mesh
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, RequestError, Suggestion
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import ENDINGS, Description, NoDescription
from rosorin_compile.source.tree import Map

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_MAX_DIGITS = 9
_LONGEST_PART = 20.0  # m; a longer mesh was drawn in millimetres


def check_digits(count: int, option: str) -> None:
    """Raise RequestError for a number of decimals out of range."""
    if not 0 <= count <= _MAX_DIGITS:
        raise RequestError(f"{option} takes 0 to {_MAX_DIGITS} decimals")


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
        check_digits(self.digits, "--map-digits")


@dataclass(frozen=True)
class Part:
    """A named body: its triangles (n, 3, 3) in its own frame in metres, and the names of its mesh files."""

    name: str
    triangles: Floats
    meshes: tuple[str, ...]


def are_meshes(names: Sequence[str], links: Sequence[str]) -> bool:
    """Return True for mesh files, False for one robot. Raises RequestError for none and for a mixture."""
    kinds = {Path(name).suffix.lower().removeprefix(".") in TriangleMesh.FORMATS for name in names}
    if len(kinds) != 1:
        raise RequestError("name mesh files, or one robot")
    if kinds == {True} and links:
        raise RequestError("--link selects a link of a robot; a mesh file has none")
    if kinds == {False} and len(names) != 1:
        raise RequestError(f"one robot at a time, not {len(names)}")
    return kinds == {True}


def mesh_parts(names: Sequence[str], scale: tuple[float, float, float], diagnostics: list[Diagnostic]) -> list[Part]:
    """Return a part for each mesh file; ``scale`` has factors along x, y and z. Raises RequestError, ExtractProblem."""
    parts: dict[str, Part] = {}
    for name in names:
        mesh, stem = load_mesh(Path(name), scale), Path(name).stem
        longest = float((mesh.triangles.max(axis=(0, 1)) - mesh.triangles.min(axis=(0, 1))).max())
        if longest > _LONGEST_PART:
            message = f"{mesh.name} is {longest:g} m long; that looks like millimetres"
            help = "--scale 0.001 turns millimetres into metres"
            diagnostics.append(Diagnostic("mesh-looks-like-millimetres", WARNING, message, None, (), help))
        if stem in parts:
            raise RequestError(f'two meshes are called "{stem}"; each part needs a name of its own')
        parts[stem] = Part(stem, mesh.triangles, (mesh.name,))
    return list(parts.values())


class SourceProblem(ExtractProblem):
    """A robot that cannot be read, with all diagnostics about it."""

    def __init__(self, diagnostics: list[Diagnostic]) -> None:
        super().__init__(next(one for one in diagnostics if one.severity == ERROR))
        self.diagnostics = diagnostics


@dataclass
class RobotSource:
    """A robot: its model, the tree that it was built from, and where its meshes are looked for."""

    robot: Robot
    tree: Map
    folder: Path
    packages: Packages
    diagnostics: list[Diagnostic] = field(default_factory=list)

    @classmethod
    def read(cls, name: str, options: ReadOptions) -> RobotSource:
        """Read a URDF, xacro, SDF or MJCF file, or a description by name, folder or file.

        Raises NotThere if there is none, else ExtractProblem; other problems are in ``diagnostics``.
        """
        path, messages = Path(name), list[Diagnostic]()
        if path.suffix.lower() in ENDINGS or not files.is_file(path):
            try:
                (description,) = Description.find([name])
            except NoDescription as problem:
                raise NotThere.new("mesh-unreadable", str(problem), "or name mesh files, or a URDF") from None
            path = description.path
            compiled = Request.of(path, options.arguments, options.packages, warn=options.tell).read()
            robot, tree, diagnostics = compiled.robot, compiled.tree, compiled.diagnostics
        else:
            imported = read_robot(path, options)
            lowered = None if imported.tree is None else imported.lowered()
            robot, tree = lowered.robot if lowered else None, imported.tree
            diagnostics = [*imported.diagnostics, *(lowered.diagnostics if lowered else ())]
            # Elements that cannot be converted hold no joint and no mesh.
            messages = [d for d in imported.diagnostics if d.severity != NOTE and d.rule != "import-cannot-carry"]
        if robot is None or tree is None:
            raise SourceProblem(diagnostics)
        environment = os.environ if options.environment is None else options.environment
        return cls(robot, tree, path.parent, Packages(options.packages, environment, path), messages)

    def link(self, name: str) -> str:
        """Return the name of a link. Raises NotThere if the robot has no link of this name."""
        if name not in self.robot.link:
            help = Suggestion(name, self.robot.link)
            raise NotThere.new("unknown-link", f'the robot has no link "{name}"', help)
        return name

    def part(self, link: str, section: str) -> Part | None:
        """Return the meshes of a link in its frame, or None if it has none that can be read.

        ``section`` is collision, visual, or auto: collision if there are meshes, else visual. A mesh that is missing or
        cannot be read is a warning in ``diagnostics``, at the line that names it.
        """
        import numpy as np

        entry = self.robot.link[link]
        shapes = {"collision": entry.collision, "visual": entry.visual}
        if section == "auto":
            has_mesh = any(isinstance(shape.geometry, Mesh) for shape in entry.collision)
            section = "collision" if has_mesh else "visual"
        pieces, names = [], []
        for number, shape in enumerate(shapes[section]):
            if not isinstance(shape.geometry, Mesh):
                continue
            address = shape.geometry.file
            path = self.packages.resolve(address, self.folder)
            try:
                if path is None:
                    help = f"say where the package is: --package {address.split('://')[-1].split('/')[0]}=FOLDER"
                    raise NotThere.new("mesh-missing", f"{section} of {link}: cannot find {address}", help)
                if not files.is_file(path):
                    raise NotThere.new("mesh-missing", f"{section} of {link}: there is no file {address}")
                mesh = load_mesh(Path(files.label(path)), shape.geometry.scale)
            except ExtractProblem as problem:
                span = self.tree.locate(("links", link, section, number, "mesh", "file")).span
                self.diagnostics.append(replace(problem.diagnostic, severity=WARNING, span=span))
                continue
            transform = shape.pose.transform()
            pieces.append(TriangleMesh.place(mesh.triangles, transform.rows, transform.xyz))
            names.append(mesh.name)
        return Part(link, np.concatenate(pieces), tuple(dict.fromkeys(names))) if pieces else None

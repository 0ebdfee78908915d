"""Extract: fit boxes to meshes, compute height maps, and take the numbers of a ROS description package."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.model import HeightMap, Pose
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.output import OutputError, write_set
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, arrange, masked

from . import boxes, factory, into, writing
from .fits import KINDS
from .heightmap import Wanted, make_map, summary
from .meshes import too_large
from .parts import AUTO, Part, SourceProblem, part_of_link, read_source

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DEFAULT_CELL = 0.01
MAX_DIGITS = 9


@dataclass(frozen=True)
class MeshSource:
    """The meshes to measure: files, or links of one robot.

    ``names`` are mesh files, or one robot: a description, URDF, xacro, SDF or MJCF. ``links`` are those of the robot,
    by default all. ``section`` is collision, visual or auto. ``scale`` has the factors of mesh files along x, y and z.
    """

    names: Sequence[str]
    reading: ReadOptions
    links: Sequence[str] = ()
    section: str = AUTO
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def are_files(self) -> bool:
        """Whether the names are those of mesh files. Raises RequestError for none and for a mixture."""
        kinds = {Path(name).suffix.lower().removeprefix(".") in TriangleMesh.FORMATS for name in self.names}
        if len(kinds) != 1:
            raise RequestError("name mesh files, or one robot")
        if kinds == {True} and self.links:
            raise RequestError("--link is that of a robot; a mesh file has none")
        if kinds == {False} and len(self.names) != 1:
            raise RequestError(f"one robot at a time, not {len(self.names)}")
        return kinds == {True}

    def file_parts(self, diagnostics: list[Diagnostic]) -> list[Part]:
        """Return a part for each mesh file. Raises RequestError, ExtractProblem."""
        parts: list[Part] = []
        for name in self.names:
            mesh = TriangleMesh.load(Path(name), self.scale)
            diagnostics += too_large(mesh)
            stem = Path(name).stem
            if stem in {part.name for part in parts}:
                raise RequestError(f'two meshes are called "{stem}"; each part needs a name of its own')
            parts.append(Part(stem, mesh.triangles, (mesh.name,)))
        return parts

    def command(self, what: str) -> str:
        """Return the first line of a file that is made from these meshes."""
        words = [*self.names, *(f"{name}:={value}" for name, value in self.reading.arguments.items())]
        return masked(f"{writing.MARK} {what} {shlex.join(words)}".replace("\n", " ")) + "\n"


@dataclass(frozen=True)
class GridOptions:
    """The grid of a height map, lengths in metres.

    By default the grid covers the mesh; ``size`` replaces ``cells``. ``spacing`` is the largest distance between
    samples, by default a third of a cell. ``step`` is what heights of boxes are rounded to, by default a cell.
    """

    cell: float | None = None
    origin: tuple[float, float] | None = None
    cells: tuple[int, int] | None = None
    size: tuple[float, float] | None = None
    spacing: float | None = None
    exact: bool = False
    below: float | None = None
    digits: int = 4
    step: float | None = None

    def wanted(self, bottom: bool = False) -> Wanted:
        """Return the height map to compute. Raises RequestError."""
        cell = DEFAULT_CELL if self.cell is None else self.cell
        if not cell > 0:
            raise RequestError(f'--cell takes a length above zero, not "{cell:g}"')
        if self.step is not None and not self.step > 0:
            raise RequestError(f'--step takes a length above zero, not "{self.step:g}"')
        if self.cells is not None and self.size is not None:
            raise RequestError("--cells and --size say the same; give one")
        check_digits(self.digits, "--map-digits")
        cells = self._cells(cell)
        return Wanted(cell, self.origin, cells, self.spacing, self.exact, self.below, self.digits, self.step, bottom)

    def _cells(self, cell: float) -> tuple[int, int] | None:
        if self.size is None:
            return self.cells
        width, depth = self.size
        if not (width > 0 and depth > 0):
            raise RequestError(f'--size takes lengths above zero, not "{width:g},{depth:g}"')
        return math.ceil(width / cell - 1e-6), math.ceil(depth / cell - 1e-6)

    def replacing(self, block: into.Block) -> Wanted:
        """Return the height map that replaces another: on its grid, unless the options have another one."""
        wanted = self.wanted()
        if self.cell is not None and self.origin is not None and wanted.cells is not None:
            cell, origin, cells = wanted.cell, self.origin, wanted.cells
        else:
            cell, origin, cells = into.grid_of(block)
            if self.cell is not None and self.cell != cell:
                factor = cell / self.cell
                cells = (math.ceil(cells[0] * factor - 1e-6), math.ceil(cells[1] * factor - 1e-6))
                cell = self.cell
            origin = self.origin or origin
            cells = self._cells(cell) or cells
        step, there = self.step, block.height_map.get("step")
        if step is None and isinstance(there, int | float) and there > 0:
            step = float(there)
        return replace(wanted, cell=cell, origin=origin, cells=cells, step=step)


@dataclass(frozen=True)
class ExtractedBoxes:
    """The shapes around each part, how well they fit, and the section ``links`` of a description with one of them."""

    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    text: str = ""
    report: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class ExtractedHeightMap:
    """A height map in a frame, and the section ``links`` of a description with it."""

    frame: str = ""
    height_map: HeightMap | None = None
    text: str = ""
    report: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def values(self) -> dict[str, Any]:
        """The height map in the form of the driver's model (schemas/robot_model.schema.json)."""
        return {} if self.height_map is None else writing.driver_height_map(self.frame, self.height_map)


@dataclass(frozen=True)
class ExtractedFactory:
    """The numbers of a ROS description package."""

    joints: tuple[str, ...] = ()
    boxes: Annotated[tuple[str, ...], "the links that have one"] = ()
    written: Annotated[tuple[str, ...], "the files that were written"] = ()
    report: Annotated[tuple[str, ...], "what was found, in sentences"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def check_digits(count: int, option: str) -> None:
    """Raise RequestError for a number of decimals out of range."""
    if not 0 <= count <= MAX_DIGITS:
        raise RequestError(f"{option} takes 0 to {MAX_DIGITS} decimals")


def _reasons(problem: ExtractProblem) -> list[Diagnostic]:
    """Return the diagnostics of a problem. Raises RequestError for the name of something that does not exist."""
    if isinstance(problem, SourceProblem):
        return arrange(problem.diagnostics)
    if isinstance(problem, NotThere):
        found = problem.diagnostic
        raise RequestError(f"{found.message}; {found.help}" if found.help else found.message) from None
    return [problem.diagnostic]


def extract_boxes(
    source: MeshSource,
    shape: str = "box",
    stack: int = 4,
    axis: str = "auto",
    digits: int = 5,
    output: Path | None = None,
    force: bool = False,
) -> ExtractedBoxes:
    """Fit shapes of every kind to each mesh file, or to the meshes of each link. Raises RequestError."""
    diagnostics: list[Diagnostic] = []
    if not 1 <= stack <= 100:
        raise RequestError("--stack takes 1 to 100 boxes")
    try:
        TriangleMesh.needed()
        check_digits(digits, "--digits")
        fitted = boxes.fit_parts(_parts(source, diagnostics), digits, stack, axis)
        text = source.command("boxes") + boxes.yaml_text(fitted, shape)
        if output is not None:
            writing.save(output, text, force)
    except ExtractProblem as problem:
        return ExtractedBoxes(diagnostics=(*diagnostics, *_reasons(problem)))
    report = tuple(boxes.table(fitted, KINDS))
    return ExtractedBoxes(boxes.json_values(fitted, KINDS), text, report, tuple(diagnostics))


def _parts(source: MeshSource, diagnostics: list[Diagnostic]) -> list[Part]:
    """Return the parts that get a shape: mesh files, or links that have meshes. Raises RequestError, ExtractProblem."""
    if source.are_files:
        return source.file_parts(diagnostics)
    robot = read_source(source.names[0], source.reading)
    links = [robot.link(name) for name in source.links] or list(robot.robot.link)
    parts = [part for link in links if (part := part_of_link(robot, link, source.section)) is not None]
    diagnostics += arrange(robot.diagnostics)
    if not parts:
        message = f"{source.names[0]} has no link with a mesh that can be read"
        raise ExtractProblem.of("mesh-empty", message, "see above, or --from")
    return parts


def extract_height_map(
    source: MeshSource,
    grid: GridOptions,
    frame: str | None = None,
    pose: Pose | None = None,
    bottom: bool = False,
    into_file: Path | None = None,
    status: str = "calculated",
    note: str | None = None,
    output: Path | None = None,
    force: bool = False,
) -> ExtractedHeightMap:
    """Compute the top surface of meshes as heights on a grid. Raises RequestError.

    ``pose`` is that of the mesh in the frame. With ``into_file``, the height map of a description is replaced.
    """
    diagnostics: list[Diagnostic] = []
    if into_file is not None and output is not None:
        raise RequestError("--into edits a file; it goes with neither -o nor JSON")
    if into_file is not None and bottom:
        raise RequestError("--bottom goes with neither --into nor JSON; write a file with -o, and paste it")
    try:
        TriangleMesh.needed()
        wanted, block = grid.wanted(bottom), None
        if into_file is not None:
            description = into.read(into_file)
            block = into.find_block(description, frame)
            wanted, frame = grid.replacing(block), block.link
        triangles, meshes, frame = _surface(source, frame, pose or Pose(), diagnostics)
        made, remarks = make_map(triangles, wanted, frame)
        diagnostics += remarks
        note = note or f"top of {', '.join(meshes)}"
        if into_file is not None and block is not None:
            text = into.replaced(description, block, made, status, note)
            place = f"{into_file}:{block.line}: height map of {block.link}"
            report = [f"{place} unchanged"]
            if text != description.text:
                writing.replace(into_file, text)
                report = [f"{place} replaced", *(f"  {line}" for line in into.changes(block, made, status))]
        else:
            text = source.command("heightmap") + "\n".join(writing.height_map(frame, made, status, note)) + "\n"
            report = [summary(made)]
            if output is not None:
                writing.save(output, text, force)
    except ExtractProblem as problem:
        return ExtractedHeightMap(diagnostics=(*diagnostics, *_reasons(problem)))
    return ExtractedHeightMap(frame, made, text, tuple(report), tuple(diagnostics))


def _surface(
    source: MeshSource, frame: str | None, pose: Pose, diagnostics: list[Diagnostic]
) -> tuple[Floats, tuple[str, ...], str]:
    """Return the triangles (n, 3, 3) in metres in a frame, the names of the meshes, and the name of the frame."""
    import numpy as np

    transform = pose.transform()
    if source.are_files:
        parts = source.file_parts(diagnostics)
        triangles = parts[0].triangles if len(parts) == 1 else np.concatenate([part.triangles for part in parts])
        meshes = tuple(name for part in parts for name in part.meshes)
        return TriangleMesh.placed(triangles, transform.rows, transform.xyz), meshes, frame or parts[0].name
    if not source.links:
        raise RequestError("of which link of the robot? --link LINK")
    robot = read_source(source.names[0], source.reading)
    link = robot.link(source.links[0])
    frame = robot.link(frame or link)
    part = part_of_link(robot, link, source.section)
    diagnostics += arrange(robot.diagnostics)
    if part is None:
        raise ExtractProblem.of("mesh-empty", f"{link} has no mesh that can be read", "see above, or --from")
    transform = transform.then(robot.robot.transform(frame, link, {}))
    return TriangleMesh.placed(part.triangles, transform.rows, transform.xyz), part.meshes, frame


def extract_factory(
    package: Path,
    output: Path,
    reading: ReadOptions,
    grid: GridOptions,
    robot: str | None = None,
    map_link: str | None = None,
    frame: str | None = None,
    section: str = AUTO,
) -> ExtractedFactory:
    """Write the joints, boxes and a height map of a ROS description package to a folder. Raises RequestError."""
    if frame and not map_link:
        raise RequestError("--frame is that of the height map; say of which link: --heightmap-link LINK")
    try:
        TriangleMesh.needed()
        path = factory.robot_file(package, robot)
        name = factory.name_of(package)
        reading = replace(reading, packages={name: package, **reading.packages})
        asked = factory.Asked(map_link, frame, grid.wanted(), section)
        made = factory.extract(read_source(str(path), reading), name, asked)
    except ExtractProblem as problem:
        return ExtractedFactory(diagnostics=tuple(_reasons(problem)))
    diagnostics = arrange(made.diagnostics)
    try:
        write_set(output, made.files, judge=lambda _, old, __: "replace" if writing.is_made(old) else "refuse")
    except OutputError as problem:
        return ExtractedFactory(diagnostics=(*diagnostics, problem.diagnostic))
    written = tuple(str(Path(output, file)) for file in sorted(made.files))
    names = (("joints", made.joints), ("boxes", list(made.boxes)))
    report = [f"{what} ({len(found)}): {', '.join(found) or 'none'}" for what, found in names]
    if made.height_map is not None:
        report.append(f"height map in {made.frame}: {summary(made.height_map)}")
    report.append(f"written: {', '.join(written)}")
    return ExtractedFactory(tuple(made.joints), tuple(made.boxes), written, tuple(report), tuple(diagnostics))

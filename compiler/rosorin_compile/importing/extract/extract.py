"""Extract numbers from meshes: shapes around parts, height maps, and the numbers of a ROS description package.

numpy, scipy and trimesh are imported after a check that they are installed.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.model import HeightMap, Pose
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.output import OutputError, write_set
from rosorin_compile.source.diagnostics import Diagnostic, RequestError
from rosorin_compile.source.files import resolve
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import masked

from . import replace_map, results
from .sources import AUTO, MeshSource, RobotSource, SourceProblem, check_digits
from .sources import GridOptions as GridOptions

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


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
        if self.height_map is None:
            return {}
        return {
            "frame": self.frame,
            "origin_xy": list(self.height_map.origin),
            "cell": self.height_map.cell,
            "method": self.height_map.method,
            "z": [list(heights) for heights in self.height_map.heights],
        }


@dataclass(frozen=True)
class ExtractedFactory:
    """The numbers of a ROS description package."""

    joints: tuple[str, ...] = ()
    boxes: Annotated[tuple[str, ...], "the links that have one"] = ()
    written: Annotated[tuple[str, ...], "the files that were written"] = ()
    report: Annotated[tuple[str, ...], "what was found, in sentences"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


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
    check_digits(digits, "--digits")
    try:
        TriangleMesh.needed()
        from .shapes import fit_shapes, measure_fits

        parts = source.file_parts(diagnostics) if source.are_files else source.link_parts(diagnostics)
        fitted = []
        for index, part in enumerate(parts):
            Progress.step("fitting", index, len(parts))
            fits = fit_shapes(part.triangles, digits, stack, axis)
            fitted.append(results.FittedPart(part, fits, measure_fits(part.triangles, fits)))
        text = _first_line(source, "boxes") + results.boxes_yaml(fitted, shape)
        if output is not None:
            results.save(output, text, force)
    except ExtractProblem as problem:
        return ExtractedBoxes(diagnostics=(*diagnostics, *_diagnostics(problem)))
    table = tuple(results.boxes_table(fitted))
    return ExtractedBoxes(results.boxes_json(fitted), text, table, tuple(arrange(diagnostics)))


def extract_height_map(
    source: MeshSource,
    grid: GridOptions,
    frame: str | None = None,
    pose: Pose | None = None,
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
        raise RequestError("--into edits a file; it excludes -o and JSON")
    if into_file is not None and grid.bottom:
        raise RequestError("--bottom excludes --into and JSON; write a file with -o, and paste it")
    grid.check()
    try:
        TriangleMesh.needed()
        from .height_map import make_height_map, summary

        existing = None if into_file is None else replace_map.find_map(into_file, frame)
        if existing is not None:
            grid, frame = existing.completed(grid), existing.link
        triangles, meshes, frame = _surface(source, frame, pose or Pose(), diagnostics)
        height_map, messages = make_height_map(triangles, grid, frame)
        diagnostics += messages
        note = note or f"top of {', '.join(meshes)}"
        if existing is not None and into_file is not None:
            text = replace_map.replaced(existing, height_map, status, note)
            place = f"{into_file}:{existing.line}: height map of {existing.link}"
            report = [f"{place} unchanged"]
            if text != existing.source.text:
                results.replace(into_file, text)
                lines = replace_map.changes(existing, height_map, status)
                report = [f"{place} replaced", *(f"  {line}" for line in lines)]
        else:
            text = _first_line(source, "heightmap") + results.height_map_yaml(frame, height_map, status, note)
            report = [summary(height_map)]
            if output is not None:
                results.save(output, text, force)
    except ExtractProblem as problem:
        return ExtractedHeightMap(diagnostics=(*diagnostics, *_diagnostics(problem)))
    return ExtractedHeightMap(frame, height_map, text, tuple(report), tuple(diagnostics))


def _surface(
    source: MeshSource, frame: str | None, pose: Pose, diagnostics: list[Diagnostic]
) -> tuple[Floats, tuple[str, ...], str]:
    """Return the triangles (n, 3, 3) in metres in a frame, the names of the meshes, and the name of the frame."""
    import numpy as np

    transform = pose.transform()
    if source.are_files:
        parts = source.file_parts(diagnostics)
        frame = frame or parts[0].name
    elif not source.links:
        raise RequestError("name the link of the robot: --link LINK")
    else:
        robot = RobotSource.read(source.names[0], source.reading)
        link = robot.link(source.links[0])
        frame = robot.link(frame or link)
        part = robot.part(link, source.section)
        diagnostics += arrange(robot.diagnostics)
        if part is None:
            raise ExtractProblem.of("mesh-empty", f"{link} has no mesh that can be read", "see above, or --from")
        parts, transform = [part], transform.then(robot.robot.transform(frame, link, {}))
    triangles = np.concatenate([part.triangles for part in parts])
    meshes = tuple(name for part in parts for name in part.meshes)
    return TriangleMesh.placed(triangles, transform.rows, transform.xyz), meshes, frame


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
        raise RequestError("--frame is that of the height map; name its link: --heightmap-link LINK")
    grid.check()
    path = None
    try:
        TriangleMesh.needed()
        from . import factory
        from .height_map import summary

        path = factory.find_robot_file(package, robot)
        name = Packages.name_of(package) or resolve(package).name
        reading = replace(reading, packages={name: package, **reading.packages})
        taken = factory.take_numbers(RobotSource.read(str(path), reading), name, map_link, frame, grid, section)
    except ExtractProblem as problem:
        choice = [] if path is None else factory.choice_of(path)
        return ExtractedFactory(diagnostics=(*_diagnostics(problem), *choice))
    diagnostics = arrange(taken.diagnostics)
    try:
        write_set(output, taken.files, judge=lambda _, old, __: "replace" if results.is_made(old) else "refuse")
    except OutputError as problem:
        return ExtractedFactory(diagnostics=(*diagnostics, problem.diagnostic))
    written = tuple(str(Path(output, file)) for file in sorted(taken.files))
    names = (("joints", taken.joints), ("boxes", list(taken.boxes)))
    report = [f"{what} ({len(found)}): {', '.join(found) or 'none'}" for what, found in names]
    if taken.height_map is not None:
        report.append(f"height map in {taken.frame}: {summary(taken.height_map)}")
    report.append(f"written: {', '.join(written)}")
    return ExtractedFactory(tuple(taken.joints), tuple(taken.boxes), written, tuple(report), tuple(diagnostics))


def _first_line(source: MeshSource, command: str) -> str:
    """Return the first line of a file that is made from these meshes."""
    names = [Path(name).name if Path(name).is_absolute() else name for name in source.names]
    words = [*names, *(f"{name}:={value}" for name, value in source.reading.arguments.items())]
    return masked(f"{results.MARK} {command} {shlex.join(words)}".replace("\n", " ")) + "\n"


def _diagnostics(problem: ExtractProblem) -> list[Diagnostic]:
    """Return the diagnostics of a problem. Raises RequestError for the name of something that does not exist."""
    if isinstance(problem, SourceProblem):
        return arrange(problem.diagnostics)
    if isinstance(problem, NotThere):
        found = problem.diagnostic.worded()
        raise RequestError(f"{found.message}; {found.help}" if found.help else found.message) from None
    return [problem.diagnostic]

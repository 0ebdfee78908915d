"""Extract numbers from meshes: shapes around parts, height maps, and the numbers of a ROS description package.

numpy, scipy and trimesh are imported after a check that they are installed.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rosorin_compile.model import HeightMap, Pose
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.output import OutputError, write_set
from rosorin_compile.request import FilePath, Packages, Values, Warn, read_options
from rosorin_compile.source.diagnostics import Diagnostic, RequestError
from rosorin_compile.source.files import resolve
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import Packages as PackageFinder
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import mask_controls

from . import replace_map, results
from .sources import GridOptions as GridOptions
from .sources import MeshSource, RobotSource, SourceProblem, check_digits

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


def _three(numbers: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z


def extract_boxes(
    sources: Sequence[str],
    arguments: Values = None,
    packages: Packages = None,
    *,
    links: Sequence[str] = (),
    section: str = "auto",
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    shape: str = "box",
    stack: int = 4,
    axis: str = "auto",
    digits: int = 5,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ExtractedBoxes:
    """Fit boxes, cylinders, capsules and stacks of boxes to meshes.

    ``parts`` of the result has for each part the shapes of every kind with their fit (metres, cubic metres, radians),
    ``text`` the section ``links`` of a description with one of them, and ``report`` a table.

    Args:
        sources: Mesh files, or one robot: a description, URDF, xacro, SDF or MJCF.
        links: The links of the robot to use; by default all that have meshes.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"``: collision, else visual.
        scale: The factors of mesh files along x, y and z, such as 0.001 for millimetres.
        shape: The shape in ``text``: box, oriented_box, cylinder, capsule, stack or smallest.
        stack: The number of boxes in a stack, 1 to 100.
        axis: The axis of the stack: x, y, z or auto.
        digits: Decimals of lengths in metres, 0 to 9.
    """
    reading, wrong = read_options(arguments, packages, trust, warn)
    if wrong:
        return ExtractedBoxes(diagnostics=tuple(wrong))
    source = MeshSource(sources, reading, links, section, _three(scale))
    diagnostics: list[Diagnostic] = []
    if not 1 <= stack <= 100:
        raise RequestError("--stack takes 1 to 100 boxes")
    check_digits(digits, "--digits")
    try:
        TriangleMesh.require_packages()
        from .shapes import fit_shapes, measure_fits

        parts = source.file_parts(diagnostics) if source.are_files else source.link_parts(diagnostics)
        fitted = []
        for index, part in enumerate(parts):
            Progress.step("fitting", index, len(parts))
            fits = fit_shapes(part.triangles, digits, stack, axis)
            fitted.append(results.FittedPart(part, fits, measure_fits(part.triangles, fits)))
        text = _first_line(source, "boxes") + results.boxes_yaml(fitted, shape)
        if output is not None:
            results.save(Path(output), text, force)
    except ExtractProblem as problem:
        return ExtractedBoxes(diagnostics=(*diagnostics, *_diagnostics(problem)))
    table = tuple(results.boxes_table(fitted))
    return ExtractedBoxes(results.boxes_json(fitted), text, table, tuple(arrange(diagnostics)))


def extract_height_map(
    sources: Sequence[str],
    arguments: Values = None,
    packages: Packages = None,
    *,
    link: str | None = None,
    section: str = "auto",
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    frame: str | None = None,
    xyz: Sequence[float] = (0.0, 0.0, 0.0),
    rpy: Sequence[float] = (0.0, 0.0, 0.0),
    cell: float | None = None,
    origin: tuple[float, float] | None = None,
    cells: tuple[int, int] | None = None,
    size: tuple[float, float] | None = None,
    below: float | None = None,
    map_digits: int = 4,
    step: float | None = None,
    bottom: bool = False,
    into: FilePath | None = None,
    status: str = "calculated",
    note: str | None = None,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ExtractedHeightMap:
    """Compute the top surface of meshes as heights on a grid.

    ``height_map`` of the result is None with errors in ``diagnostics``; ``text`` is the section ``links`` of a
    description with the map.

    Args:
        sources: Mesh files, or one robot with ``link``.
        link: The link of the robot whose meshes are used.
        section: As in ``extract_boxes``.
        scale: As in ``extract_boxes``.
        frame: The link whose frame the height map uses; by default ``link``.
        xyz: The position of the mesh in the frame, in metres.
        rpy: The orientation of the mesh in the frame: roll, pitch, yaw in radians.
        cell: The edge length of a cell in metres; by default 0.01.
        origin: The corner of the first cell (x, y) in metres; by default the corner of the mesh.
        cells: The number of cells along x and y; by default those that cover the mesh.
        size: The size of the grid (x, y) in metres, instead of ``cells``.
        below: Ignore surfaces above this height, in metres.
        map_digits: Decimals of heights in metres, 0 to 9.
        step: Round heights of boxes to multiples of this length in metres; by default a cell.
        bottom: Also compute the lowest point of the mesh.
        into: A file of a description whose height map is replaced, on the same grid.
        status: The status of the source in the description: calculated, measured or factory.
        note: The note of the source in the description; by default the names of the meshes.
    """
    reading, wrong = read_options(arguments, packages, trust, warn)
    if wrong:
        return ExtractedHeightMap(diagnostics=tuple(wrong))
    source = MeshSource(sources, reading, [link] if link is not None else (), section, _three(scale))
    grid = GridOptions(cell, origin, cells, size, below, map_digits, step, bottom)
    pose, into_file = Pose(_three(xyz), _three(rpy)), Path(into) if into is not None else None
    diagnostics: list[Diagnostic] = []
    if into_file is not None and output is not None:
        raise RequestError("--into edits a file; it excludes -o and JSON")
    if into_file is not None and grid.bottom:
        raise RequestError("--bottom excludes --into and JSON; write a file with -o, and paste it")
    grid.check()
    try:
        TriangleMesh.require_packages()
        from .height_map import make_height_map, summary

        existing = None if into_file is None else replace_map.find_map(into_file, frame)
        if existing is not None:
            grid, frame = existing.complete(grid), existing.link
        triangles, meshes, frame = _surface(source, frame, pose, diagnostics)
        height_map, messages = make_height_map(triangles, grid, frame)
        diagnostics += messages
        note = note or f"top of {', '.join(meshes)}"
        if existing is not None and into_file is not None:
            text = replace_map.replace_map(existing, height_map, status, note)
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
                results.save(Path(output), text, force)
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
            raise ExtractProblem.new("mesh-empty", f"{link} has no mesh that can be read", "see above, or --from")
        parts, transform = [part], transform.then(robot.robot.transform(frame, link, {}))
    triangles = np.concatenate([part.triangles for part in parts])
    meshes = tuple(name for part in parts for name in part.meshes)
    return TriangleMesh.place(triangles, transform.rows, transform.xyz), meshes, frame


def extract_factory(
    package: FilePath,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    robot: str | None = None,
    height_map_link: str | None = None,
    frame: str | None = None,
    section: str = "auto",
    cell: float | None = None,
    origin: tuple[float, float] | None = None,
    cells: tuple[int, int] | None = None,
    size: tuple[float, float] | None = None,
    below: float | None = None,
    map_digits: int = 4,
    step: float | None = None,
    lenient: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ExtractedFactory:
    """Write the joints, a box for each link and a height map of a ROS description package to a folder.

    The options that are not listed here are those of ``extract_height_map``.

    Args:
        package: The folder of the package.
        robot: The robot file in the package; by default the only one.
        height_map_link: The link whose meshes are used for a height map. Default: no height map.
        frame: The link whose frame the height map uses; by default ``height_map_link``.
        lenient: Accept violations of the specification where possible.
    """
    reading, wrong = read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return ExtractedFactory(diagnostics=tuple(wrong))
    folder, target, grid = Path(package), Path(output), GridOptions(cell, origin, cells, size, below, map_digits, step)
    if frame and not height_map_link:
        raise RequestError("--frame is that of the height map; name its link: --heightmap-link LINK")
    grid.check()
    path = None
    try:
        TriangleMesh.require_packages()
        from . import factory
        from .height_map import summary

        path = factory.find_robot_file(folder, robot)
        name = PackageFinder.name_of(folder) or resolve(folder).name
        reading = replace(reading, packages={name: folder, **reading.packages})
        taken = factory.take_numbers(RobotSource.read(str(path), reading), name, height_map_link, frame, grid, section)
    except ExtractProblem as problem:
        choice = [] if path is None else factory.choice_of(path)
        return ExtractedFactory(diagnostics=(*_diagnostics(problem), *choice))
    diagnostics = arrange(taken.diagnostics)
    try:
        write_set(target, taken.files, judge=lambda _, old, __: "replace" if results.is_made(old) else "refuse")
    except OutputError as problem:
        return ExtractedFactory(diagnostics=(*diagnostics, problem.diagnostic))
    written = tuple(str(target / file) for file in sorted(taken.files))
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
    return mask_controls(f"{results.MARK} {command} {shlex.join(words)}".replace("\n", " ")) + "\n"


def _diagnostics(problem: ExtractProblem) -> list[Diagnostic]:
    """Return the diagnostics of a problem. Raises RequestError for the name of something that does not exist."""
    if isinstance(problem, SourceProblem):
        return arrange(problem.diagnostics)
    if isinstance(problem, NotThere):
        found = problem.diagnostic.with_help()
        raise RequestError(f"{found.message}; {found.help}" if found.help else found.message) from None
    return [problem.diagnostic]

"""Extract bounding shapes and height maps from meshes; numpy, scipy and trimesh are imported on first use."""

from __future__ import annotations

import math
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Mesh, Pose, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotFound, TriangleMesh, load_mesh
from rosorin_compile.output.atomic_files import OutputError, write_file
from rosorin_compile.request import FilePath, Packages, Request, Values, Warn, read_options
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, DiagnosticError, RequestError, UnknownName
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import Packages as PackageFinder
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, NoDescription
from rosorin_compile.source.wording import mask_controls

from ..description import layout, number, plain_value

if TYPE_CHECKING:
    from rosorin_compile.model.mesh_triangles import Floats

MARK = "# rosorin-compile extract"  # the first words of every file that the command ``extract`` writes


@dataclass(frozen=True)
class ExtractedBoxes:
    """The result of ``extract_boxes``: the shapes of each mesh or link in ``parts``, and YAML in ``text``."""

    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    text: str = ""
    report: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class ExtractedHeightMap:
    """The result of ``extract_height_map``: a height map in the link frame ``frame``, and YAML in ``text``."""

    frame: str = ""
    height_map: HeightMap | None = None
    text: str = ""
    report: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()

    @property
    def values(self) -> dict[str, Any]:
        """The height map in the format of robot_model.json (schemas/robot_model.schema.json)."""
        if self.height_map is None:
            return {}
        grid, rows = self.height_map, [list(heights) for heights in self.height_map.heights]
        head = {"frame": self.frame, "origin_xy": list(grid.origin), "cell": grid.cell, "method": grid.method}
        return {**head, "z": rows}


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

    In the result, ``parts`` has the shapes of each mesh or link, and how well they fit (m, m^3, rad). ``text`` is the
    section ``links`` of a description with shapes of the kind ``shape``, and ``report`` is a table.

    Args:
        sources: Mesh files, or one robot: a description, URDF, xacro, SDF or MJCF.
        links: The links of the robot to use; by default all links with meshes.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"`` prefers collision meshes.
        scale: Factors for the coordinates in mesh files along x, y and z, such as 0.001 for millimetres.
        shape: The kind of shape in ``text``: box, oriented_box, cylinder, capsule, stack or smallest.
        stack: The number of boxes in a stack, 1 to 100.
        axis: The axis of the stack: x, y, z or auto.
        digits: Decimals of lengths in metres, 0 to 9.
    """
    reading, wrong = read_options(arguments, packages, trust, warn)
    if wrong:
        return ExtractedBoxes(diagnostics=tuple(wrong))
    diagnostics: list[Diagnostic] = []
    if not 1 <= stack <= 100:
        raise RequestError("--stack takes 1 to 100 boxes")
    if not 0 <= digits <= 9:
        raise RequestError("--digits takes 0 to 9 decimals")
    try:
        TriangleMesh.require_packages()
        from .shapes import fit_shapes

        parts, _ = read_parts(sources, links, section, scale, reading, diagnostics)
        values, entries, rows = {}, {}, [("part", "shape", "volume", "overhang", "overlap")]
        for index, part in enumerate(parts):
            Progress.step("fitting", index, len(parts))
            fits = fit_shapes(part.triangles, digits, stack, axis)
            smallest = min(fits, key=lambda kind: fits[kind].volume)
            fit = fits[smallest if shape == "smallest" else shape]
            words = {"box": "axis-aligned box", "stack": f"stack of {len(fit.pieces)} boxes"}
            note = f"{words.get(fit.kind, fit.kind.replace('_', ' '))} around {', '.join(part.meshes)}"
            collision = [shape_entry(piece) for piece in fit.pieces]
            entries[part.name] = {"collision": collision, "source": {"status": "calculated", "note": note}}
            shapes = {}
            for kind, fit in fits.items():
                poses = [{"xyz": [*piece.pose.xyz], "rpy": [*piece.pose.rpy]} for piece in fit.pieces]
                pieces = [_sizes(piece) | pose for piece, pose in zip(fit.pieces, poses, strict=True)]
                measures = {"volume": fit.volume, "overhang_volume": fit.overhang, "overlap": fit.overlap}
                shapes[kind] = {"shapes": pieces, **measures}
                name = f"stack of {len(pieces)}" if kind == "stack" else kind.replace("_", " ")
                overhang = "open mesh"
                if fit.overhang is not None:
                    overhang = f"{_volume(fit.overhang)} ({100 * fit.overhang / fit.volume:.0f}%)"
                overlap = math.floor(fit.overlap * 1000) / 10  # round down, so that 100% means all vertices
                rows.append((part.name, name, _volume(fit.volume), overhang, f"{overlap:g}%"))
            values[part.name] = {"meshes": list(part.meshes), "triangles": len(part.triangles)}
            values[part.name] |= {"closed": fit.overhang is not None, "smallest": smallest, "shapes": shapes}
        text = _first_line(sources, reading.arguments, "boxes") + layout({"links": entries})
        if output is not None:
            _save(output, text, force)
    except DiagnosticError as problem:
        return ExtractedBoxes(diagnostics=all_diagnostics(problem, diagnostics))
    width = max(len(name) for name, *_ in rows)
    table = (f"{row[0]:<{width}}  {row[1]:<12}  {row[2]:>10}  {row[3]:>16}  {row[4]:>7}" for row in rows)
    return ExtractedBoxes(values, text, tuple(table), tuple(arrange(diagnostics)))


def _volume(value: float) -> str:
    return f"{value * 1e6:.1f} cm3" if value < 0.01 else f"{value * 1e3:.1f} l"


def _sizes(shape: Shape) -> dict[str, dict[str, Any]]:
    """Return the dimensions of a shape by its kind, such as ``{"cylinder": {"radius": 0.1, "length": 0.2}}``."""
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return {"box": {"min": list(geometry.lower), "max": list(geometry.upper)}}
    assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits have no other shape
    return {type(geometry).__name__.lower(): {"radius": geometry.radius, "length": geometry.length}}


def shape_entry(shape: Shape) -> dict[str, Any]:
    """Convert a shape to an entry of the list ``collision`` of a link, ready for writing as YAML."""
    geometry, sizes = shape.geometry, _sizes(shape)
    if isinstance(geometry, Box) and geometry.centre == (0.0, 0.0, 0.0):
        sizes = {"box": {"size": geometry.size}}
    entry: dict[str, Any] = plain_value(sizes)
    if shape.pose.xyz != (0, 0, 0):
        entry["xyz"] = plain_value(shape.pose.xyz)
    if shape.pose.rpy != (0, 0, 0):
        entry["rpy"] = [number(angle, "deg") for angle in shape.pose.rpy]
    return entry


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

    In the result, ``height_map`` is None if ``diagnostics`` has errors; ``text`` is the section ``links`` of a
    description with the map.

    Args:
        sources: Mesh files, or one robot (then ``link`` is required).
        link: The link of the robot whose meshes are used.
        section: As in ``extract_boxes``.
        scale: As in ``extract_boxes``.
        frame: The link whose frame the height map uses; by default ``link``.
        xyz: The position of the mesh in the frame, in metres.
        rpy: The orientation of the mesh in the frame: roll, pitch, yaw in radians.
        cell: The edge length of a cell in metres; by default 0.01.
        origin: The smallest x and y of the grid in metres; by default those of the mesh.
        cells: The number of cells along x and y; by default enough to cover the mesh.
        size: The size of the grid (x, y) in metres, instead of ``cells``.
        below: Ignore surfaces above this height, in metres.
        map_digits: Decimals of heights in metres, 0 to 9.
        step: Artifacts approximate the map with boxes of rounded height: multiples of this (m), by default ``cell``.
        bottom: Also compute the height of the lowest point of the mesh.
        into: A description file; its height map is replaced with a new map on the same grid.
        status: How the heights were obtained, for the key ``source``: calculated, measured or factory.
        note: A note for the key ``source``; by default the names of the meshes.
    """
    reading, wrong = read_options(arguments, packages, trust, warn)
    if wrong:
        return ExtractedHeightMap(diagnostics=tuple(wrong))
    transform = Pose((xyz[0], xyz[1], xyz[2]), (rpy[0], rpy[1], rpy[2])).transform()
    diagnostics: list[Diagnostic] = []
    if into is not None and output is not None:
        raise RequestError("--into edits a file; it excludes -o and JSON")
    if into is not None and bottom:
        raise RequestError("--bottom excludes --into and JSON; write a file with -o, and paste it")
    try:
        TriangleMesh.require_packages()
        import numpy as np

        from .height_map import GridOptions, find_map, height_map_yaml, make_height_map, replace_map, summary

        grid = GridOptions(cell, origin, cells, size, below, map_digits, step, bottom)
        existing = None if into is None else find_map(Path(into), frame)
        if existing is not None:
            grid, frame = existing.complete(grid), existing.link
        parts, source = read_parts(sources, [link] if link else [], section, scale, reading, diagnostics)
        if source is not None:
            if link is None:
                raise RequestError("name the link of the robot: --link LINK")
            frame = source.link(frame or link)
            transform = transform.then(source.robot.transform(frame, link, {}))
        frame = frame or parts[0].name
        triangles = np.concatenate([part.triangles for part in parts])
        triangles = TriangleMesh.place(triangles, transform.rows, transform.xyz)
        height_map, messages = make_height_map(triangles, grid, frame)
        diagnostics += messages
        note = note or f"top of {', '.join(name for part in parts for name in part.meshes)}"
        report = [summary(height_map)]
        if existing is not None:
            text = replace_map(existing, height_map, status, note)
            is_new, place = text != existing.source.text, existing.collision.key_spans["height_map"]
            verb = "replaced" if is_new else "unchanged"
            report.append(f"{place.source.path}:{place.line}: height map of {frame} {verb}")
            output, force = existing.source.path if is_new else None, True
        else:
            text = _first_line(sources, reading.arguments, "heightmap")
            text += height_map_yaml(frame, height_map, status, note)
        if output is not None:
            _save(output, text, force)
    except DiagnosticError as problem:
        return ExtractedHeightMap(diagnostics=all_diagnostics(problem, diagnostics))
    return ExtractedHeightMap(frame, height_map, text, tuple(report), tuple(arrange(diagnostics)))


def _first_line(sources: Sequence[str], arguments: Mapping[str, str], command: str) -> str:
    """Return the first line of an extracted file: a comment with the command that wrote the file."""
    names = [Path(name).name if Path(name).is_absolute() else name for name in sources]
    words = [*names, *(f"{name}:={value}" for name, value in arguments.items())]
    return mask_controls(f"{MARK} {command} {shlex.join(words)}".replace("\n", " ")) + "\n"


def _save(path: FilePath, text: str, force: bool) -> None:
    """Write a file. Raises ExtractProblem if the file exists and extract did not write it, unless ``force`` is True."""
    try:
        write_file(Path(path), text.encode(), (), None if force else lambda old: is_made(files.read_bytes(old)))
    except OutputError as problem:
        is_other = problem.diagnostic.rule == "output-not-ours"
        help = "name another file, or add --force" if is_other else problem.diagnostic.help
        raise ExtractProblem(replace(problem.diagnostic, rule="extract-file", help=help)) from None


def is_made(old: bytes) -> bool:
    """Return True if a file with this content was written by the command ``extract``."""
    return old.startswith(MARK.encode())


def all_diagnostics(problem: DiagnosticError, others: list[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Return ``others`` and the diagnostic of ``problem``, sorted. Raises RequestError if a mesh file is missing."""
    if isinstance(problem, NotFound):
        raise RequestError(f"{problem.diagnostic.message}; {problem.diagnostic.help}") from None
    return tuple(arrange([*others, problem.diagnostic]))


@dataclass(frozen=True)
class Part:
    """A mesh file, or the meshes of a link in the link frame: triangles (n, 3, 3) in metres, and mesh file names."""

    name: str
    triangles: Floats
    meshes: tuple[str, ...]


class RobotSource:
    """A robot whose meshes are extracted: its model, its parsed description, and the package search path."""

    def __init__(self, name: str, options: ReadOptions, diagnostics: list[Diagnostic]) -> None:
        """Read a robot, and append warnings to ``diagnostics``. Raises RequestError or ExtractProblem."""
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
        # Skip diagnostics that ``check`` reports for a description, and unsupported elements, which have no mesh.
        found = reading.diagnostics if request.is_foreign else ()
        found = [one for one in found if one.rule != "import-cannot-carry"]
        diagnostics += [one for one in found if one.severity in (ERROR, WARNING)]
        self.robot, self.tree, self.diagnostics = reading.robot, reading.tree, diagnostics
        self.path, self.packages = description.path, PackageFinder(options.packages, os.environ, description.path)

    def link(self, name: str) -> str:
        """Return the link name unchanged. Raises UnknownName if the robot has no such link."""
        if name not in self.robot.link:
            raise UnknownName("link", name, self.robot.link, "the robot")
        return name

    def part(self, link: str, section: str) -> Part | None:
        """Return the meshes of a link in the link frame, or None if it has no readable mesh; append warnings.

        ``section`` is "collision", "visual", or "auto" to prefer collision meshes.
        """
        import numpy as np

        shapes = {"collision": self.robot.link[link].collision, "visual": self.robot.link[link].visual}
        if section == "auto":
            has_mesh = any(isinstance(shape.geometry, Mesh) for shape in shapes["collision"])
            section = "collision" if has_mesh else "visual"
        pieces, names = [], []
        for index, shape in enumerate(shapes[section]):
            if not isinstance(shape.geometry, Mesh):
                continue
            address = shape.geometry.file
            path = self.packages.resolve(address, self.path.parent)
            try:
                if path is None or not files.is_file(path):
                    package = address.split("://")[-1].split("/")[0]
                    help = f"name its folder: --package {package}=FOLDER" if path is None else ""
                    raise ExtractProblem.new("mesh-missing", f"{section} of {link}: there is no file {address}", help)
                mesh = load_mesh(Path(files.label(path)), shape.geometry.scale)
            except ExtractProblem as problem:
                span = self.tree.locate(("links", link, section, index, "mesh", "file")).span
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
    """Load mesh files, or the meshes of one robot; return (a ``Part`` for each file or link, the robot or None).

    ``links`` are the links to use (default: all), ``scale`` has the factors for mesh files along x, y and z. Raises
    RequestError for conflicting arguments, or ExtractProblem if a file cannot be read or there is no mesh.
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
    source = RobotSource(names[0], options, diagnostics)
    selected = [source.link(name) for name in links] or list(source.robot.link)
    parts = [part for name in selected if (part := source.part(name, section)) is not None]
    if not parts:
        message = f"{', '.join(links) or names[0]} has no mesh that can be read"
        raise ExtractProblem.new("mesh-empty", message, "see above, or --from")
    return parts, source

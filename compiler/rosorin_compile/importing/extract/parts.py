"""Parts: triangles of mesh files, and of the links of a robot in their own frames."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.model import Mesh as MeshShape
from rosorin_compile.model import Robot, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem, NotThere, TriangleMesh
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Span, did_you_mean
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description, NoDescription
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "mesh-missing",
        "A warning: a robot names a mesh that is not there.",
        "Add the file, or `--package NAME=PATH`.",
        Heading.MESHES,
    ),
)

AUTO = "auto"
SECTIONS = ("collision", "visual")
# What a reader says of elements that hold no joint and no mesh.
_NOT_FOR_NUMBERS = {"import-cannot-carry"}


@dataclass(frozen=True)
class Part:
    """What gets a shape: its name, its triangles (n, 3, 3) in its own frame, and the names of its mesh files."""

    name: str
    triangles: Floats
    meshes: tuple[str, ...]


@dataclass
class RobotSource:
    """A robot that was read: the model, the tree that it came from, and how the names of its meshes are found."""

    robot: Robot
    tree: Map
    folder: Path
    packages: Packages
    files: tuple[Path, ...]
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def link(self, name: str) -> str:
        """Return the name of a link. Raises NotThere if the robot has none of this name."""
        if name not in self.robot.link:
            help = did_you_mean(name, self.robot.link)
            raise NotThere.of("unknown-link", f'the robot has no link "{name}"', help)
        return name


def read_source(word: str, options: ReadOptions) -> RobotSource:
    """Return the robot of a URDF, xacro, SDF or MJCF file, or of a description by name, folder or file.

    Raises NotThere if there is none, else ExtractProblem; other problems are among the diagnostics of what is returned.
    """
    path = Path(word)
    if path.suffix.lower() in (".yaml", ".yml") or not files.is_file(path):
        return _described(word, options)
    imported = read_robot(path, options)
    lowered = None if imported.tree is None else imported.lowered()
    if imported.tree is None or lowered is None or lowered.robot is None:
        raise SourceProblem([*imported.diagnostics, *(lowered.diagnostics if lowered else [])])
    environment = os.environ if options.environment is None else options.environment
    packages = Packages(options.packages, environment, path)
    remarks = [one for one in imported.diagnostics if one.severity != NOTE and one.rule not in _NOT_FOR_NUMBERS]
    return RobotSource(lowered.robot, imported.tree, path.parent, packages, imported.files, remarks)


class SourceProblem(ExtractProblem):
    """A robot that cannot be read; carries all that there is to say."""

    def __init__(self, diagnostics: list[Diagnostic]) -> None:
        errors = [one for one in diagnostics if one.severity == "error"]
        super().__init__(errors[0])
        self.diagnostics = diagnostics


def _described(word: str, options: ReadOptions) -> RobotSource:
    """Return the robot of a description. Raises ExtractProblem."""
    try:
        (description,) = Description.find([word])
    except NoDescription as problem:
        raise NotThere.of("mesh-unreadable", str(problem), "or name mesh files, or a URDF") from None
    found = Request.of(description.path, options.arguments, options.packages, warn=options.tell).read()
    if found.robot is None:
        raise SourceProblem(found.diagnostics)
    assert found.tree is not None  # a model is made of a tree  # noqa: S101
    environment = os.environ if options.environment is None else options.environment
    folder = description.path.parent
    packages = Packages(options.packages, environment, description.path)
    return RobotSource(found.robot, found.tree, folder, packages, found.inputs)


def part_of_link(source: RobotSource, link: str, section: str = AUTO) -> Part | None:
    """Return the meshes of a link in its frame; None if it names none that can be read.

    ``section`` is collision, visual, or auto: of collisions if they name meshes, else of visuals. A mesh that is
    missing or cannot be read is a warning in ``source.diagnostics``, at the line that names it.
    """
    import numpy as np

    pieces, names = [], []
    for place, shape in _mesh_shapes(source.robot, link, section):
        geometry = shape.geometry
        assert isinstance(geometry, MeshShape)  # noqa: S101
        span = source.tree.locate(("links", link, *place, "mesh", "file")).span
        path = source.packages.resolve(geometry.file, source.folder)
        if path is None or not files.is_file(path):
            source.diagnostics.append(_missing(link, place[0], geometry.file, path, span))
            continue
        try:
            mesh = TriangleMesh.load(Path(files.shown(path)), geometry.scale)
        except ExtractProblem as problem:
            diagnostic = problem.diagnostic
            source.diagnostics.append(replace(diagnostic, severity=WARNING, span=span))
            continue
        transform = shape.pose.transform()
        pieces.append(TriangleMesh.placed(mesh.triangles, transform.rows, transform.xyz))
        names.append(mesh.name)
    return Part(link, np.concatenate(pieces), tuple(dict.fromkeys(names))) if pieces else None


def _mesh_shapes(robot: Robot, link: str, section: str) -> Iterator[tuple[tuple[str, int], Shape]]:
    """Yield the shapes of a link that are meshes, each with its section and index."""
    entry = robot.link[link]
    by_section: Mapping[str, tuple[Shape, ...]] = {"collision": entry.collision, "visual": entry.visual}
    for name in SECTIONS if section == AUTO else (section,):
        meshes = [
            ((name, index), shape)
            for index, shape in enumerate(by_section[name])
            if isinstance(shape.geometry, MeshShape)
        ]
        if meshes:
            yield from meshes
            return


def _missing(link: str, section: str, address: str, path: Path | None, span: Span) -> Diagnostic:
    if path is None:
        help = f"say where the package is: --package {address.split('://')[-1].split('/')[0]}=FOLDER"
        return Diagnostic("mesh-missing", WARNING, f"{section} of {link}: cannot find {address}", span, (), help)
    return Diagnostic("mesh-missing", WARNING, f"{section} of {link}: there is no file {address}", span, (), "")

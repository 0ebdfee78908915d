"""Compile a robot: load it, search its meshes, and generate the texts of its artifacts. Nothing is written."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.accepting import settled, unused
from rosorin_compile.model import Mesh, Output, Robot
from rosorin_compile.rules.check import acceptable
from rosorin_compile.source.diagnostics import Diagnostic, Span, error, has_errors
from rosorin_compile.source.files import read_text, recording
from rosorin_compile.source.load import unreadable
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import PACKAGE_XML
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import of_tool
from rosorin_compile.source.tree import Map, locate
from rosorin_compile.source.wording import and_more, counted

from . import FORMATS, Artifact
from .load_robot import Understood, understand
from .templating import TemplateProblem, Templates
from .unsupported import notes as unsupported_notes

if TYPE_CHECKING:
    from rosorin_compile.language.expand.included_robots import Tell
    from rosorin_compile.source.project import Resolved

    from .mesh_files import Searched

Search = Callable[[Map, Sequence[Output]], "Searched"]
MAX_SHOWN = 200  # diagnostics in a notebook


@dataclass(frozen=True)
class Variant:
    """One robot of a list: its name, its arguments with their positions, and the position of its name.

    ``diagnostics`` are the errors of the entry itself.
    """

    name: str
    arguments: Map
    span: Span | None = None
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Compiled:
    """The model and the artifacts of a description, which exist only without errors, and all diagnostics.

    ``inputs`` are the files that were read or looked for and not found: a change of one of them may change the result.
    ``missing`` are those that were not found. A package.xml from which only the name of the package was read does not
    count. ``resolved`` maps names of packages and mesh files to the paths that were found. ``meshes`` are the mesh
    files, or None if they were not requested. ``variant`` is set by ``sweep``.
    """

    robot: Robot | None
    artifacts: tuple[Artifact, ...]
    diagnostics: list[Diagnostic]
    inputs: tuple[Path, ...]
    resolved: tuple[Resolved, ...] = ()
    meshes: Searched | None = None
    variant: Variant | None = None
    missing: tuple[Path, ...] = ()

    @property
    def files_read(self) -> tuple[Path, ...]:
        """The files that were read."""
        return tuple(path for path in self.inputs if path not in self.missing)

    @property
    def mesh_files(self) -> Mapping[str, bytes]:
        """The mesh files that belong to the artifacts, bytes by name."""
        return self.meshes.files if self.meshes else {}

    @property
    def packages(self) -> dict[str, Path]:
        """The folders of the ROS packages that were found, by name."""
        return {one.name: Path(one.answer) for one in self.resolved if one.is_ros_package}

    @property
    def python_packages(self) -> list[Path]:
        """The folders of the Python packages that were found."""
        return [Path(one.answer) for one in self.resolved if one.is_python_package]

    def __repr__(self) -> str:
        """Return a summary without the texts of the artifacts."""
        return f"<Compiled {self.robot!r}, {len(self.artifacts)} artifacts, {_counted(self.diagnostics)}>"

    def _repr_html_(self) -> str:
        return _html(self.robot, self.diagnostics)


@dataclass(frozen=True)
class Reading:
    """The robot of a file in any format (None if it has errors), all diagnostics, and the files that were read.

    ``tree`` is the robot as a description, after includes, arguments and expressions.
    """

    robot: Robot | None
    diagnostics: list[Diagnostic]
    inputs: tuple[Path, ...]
    tree: Map | None = None

    def __repr__(self) -> str:
        """Return a summary."""
        return f"<Reading {self.robot!r}, {_counted(self.diagnostics)}>"

    def _repr_html_(self) -> str:
        return _html(self.robot, self.diagnostics)


def compile_robot(
    path: Path,
    arguments: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    search: Search | None = None,
    requested: Sequence[str] = (),
    cache: dict[Any, Any] | None = None,
    *,
    exact: bool = False,
) -> Compiled:
    """Compile the description whose main file is ``path``. Errors are diagnostics, never exceptions.

    The parameters are those of ``understand`` and ``emit``. With ``exact``, outputs without a number format print all
    digits.
    """
    with recording() as recorded:
        try:
            understood = understand(path, arguments, tell, packages, requested, cache)
            if exact and understood.lowered is not None and understood.lowered.robot is not None:
                robot = understood.lowered.robot
                robot = replace(robot, outputs=tuple(map(_with_all_digits, robot.outputs)))
                understood = understood._replace(lowered=understood.lowered._replace(robot=robot))
            if understood.expanded.scope is not None:
                understood.expanded.scope.expansion.forget()
            compiled = emit(understood, path, search, requested)
        except OSError as problem:
            if problem.filename is None:
                raise
            compiled = Compiled(None, (), [unreadable(problem)], (path,))
    listed = {*map(os.path.abspath, compiled.inputs)}
    new = {
        path: found
        for path, found in recorded.items()
        if path.name != PACKAGE_XML and os.path.abspath(path) not in listed and not of_tool(path)
    }
    missing = tuple(path for path, found in new.items() if not found)
    return replace(compiled, inputs=(*compiled.inputs, *new), missing=missing)


def _with_all_digits(output: Output) -> Output:
    if "number_format" not in FORMATS[output.backend].options:
        return output
    return replace(output, options={"number_format": "exact", **output.options})


def emit(understood: Understood, path: Path, search: Search | None = None, requested: Sequence[str] = ()) -> Compiled:
    """Generate the artifacts of a loaded robot; ``path`` is its main file.

    ``search`` looks for mesh files, by the tree and the outputs; without it each is assumed to be where the artifacts
    look. ``requested`` are the names of the only outputs to generate, in their order; by default all.
    """
    expanded, lowered, diagnostics, used, _ = understood
    if expanded.tree is None or lowered is None or lowered.robot is None or has_errors(diagnostics):
        return Compiled(None, (), diagnostics, expanded.files)
    robot, meshes, outputs = lowered.robot, None, lowered.robot.outputs
    if requested:
        named = {output.name: output for output in outputs}
        outputs = tuple(named[name] for name in dict.fromkeys(requested))
    if search is not None and _names_files(robot):
        # An artifact that opens or measures meshes finds the same ones if other outputs are not generated.
        formats = [FORMATS[output.backend] for output in outputs]
        opening = any(format.opens is not None or format.measures for format in formats)
        meshes = search(expanded.tree, robot.outputs if opening else outputs)
        robot = meshes.told_to(robot)
    artifacts, found, templates = _texts(robot, outputs, expanded.tree, path)
    found += unsupported_notes(expanded.tree, outputs, FORMATS)
    may = acceptable() if meshes is None else {**acceptable(), **meshes.acceptable}
    found, more = settled(expanded.tree, [*(meshes.diagnostics if meshes else ()), *found], may)
    if has_errors(found):
        artifacts = ()
    if not requested:  # otherwise an entry of accept may be about another output
        found += unused(expanded.tree, used | more, acceptable(), ("",) if search is None else ("", "meshes"))
    inputs = (*expanded.files, *templates, *(meshes.inputs if meshes else ()))
    resolved = (*expanded.resolved, *(meshes.resolved if meshes else ()))
    return Compiled(robot, artifacts, arrange([*diagnostics, *found]), inputs, resolved, meshes)


def emit_published(understood: Understood, path: Path) -> Compiled:
    """Return the URDF of a robot that was loaded with ``understand_foreign``."""
    expanded, robot = understood.expanded, understood.robot
    if robot is None:
        return Compiled(None, (), understood.diagnostics, expanded.files)
    format, (output,) = FORMATS.published(), robot.outputs
    text, remarks = format.written(robot, output, Templates(path.parent))
    if path.suffix.lower() in format.endings:
        text = read_text(path, errors="replace")  # the text that robot_state_publisher gets
    artifact = Artifact(output.file, text, format.name, output.name)
    return Compiled(robot, (artifact,), arrange([*understood.diagnostics, *remarks]), expanded.files)


def _names_files(robot: Robot) -> bool:
    """Return True if a robot has meshes, textures, or elements of MJCF that may name files."""
    shapes = [shape for link in robot.links for shape in (*link.visual, *link.collision)]
    elements = (robot.mjcf_elements, *(link.mjcf_elements for link in robot.links))
    return (
        any(isinstance(shape.geometry, Mesh) or shape.texture for shape in shapes)
        or any(material.texture for material in robot.materials)
        or any("file" in text for texts in elements for text in texts)  # begins all attributes that name one
    )


def _texts(
    robot: Robot, outputs: Sequence[Output], tree: Map, path: Path
) -> tuple[tuple[Artifact, ...], list[Diagnostic], tuple[Path, ...]]:
    """Return the artifacts, the diagnostics of their formats, and the template files that were read."""
    templates, artifacts, diagnostics = Templates(path.parent, first=path), list[Artifact](), list[Diagnostic]()
    for number, output in enumerate(outputs):
        Progress.step(f"making {output.file},", number, len(outputs))
        format, place = FORMATS[output.backend], locate(tree, ("outputs", output.name), key=True)
        try:
            text, found = format.written(robot, output, templates)
        except TemplateProblem as problem:
            one = problem.diagnostic
            diagnostics.append(one if one.span else error(one.rule, one.message, place.span, one.help, place.stack()))
            continue
        diagnostics += [
            d if d.span else replace(d, span=place.span, related=(*d.related, *place.stack())) for d in found
        ]
        artifacts.append(Artifact(output.file, text, output.backend, output.name, format.is_withheld(output)))
    return tuple(artifacts), diagnostics, templates.read()


def _counted(diagnostics: Sequence[Diagnostic]) -> str:
    counts = Counter(diagnostic.severity for diagnostic in diagnostics)
    return ", ".join(counted(count, severity) for severity, count in counts.items()) or "no diagnostics"


def _html(robot: Robot | None, diagnostics: Sequence[Diagnostic]) -> str:
    """Return a robot and its diagnostics for a notebook."""
    from html import escape

    from rosorin_compile.source.report import text

    remarks = f"<pre>{escape(text(diagnostics[:MAX_SHOWN]))}</pre>" if diagnostics else ""
    if len(diagnostics) > MAX_SHOWN:
        remarks += f"<p>{and_more(len(diagnostics) - MAX_SHOWN).strip()}</p>"
    return remarks + (robot._repr_html_() if robot is not None else "")

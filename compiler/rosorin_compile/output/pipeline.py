"""The pipeline: load, expand, validate, lower, check, write as text. Values in, values and diagnostics out.

``compile`` and ``read`` are the public API; the commands call ``compile_robot`` and ``understand``.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, plugged_diagnostics
from rosorin_compile.language.accepting import Entry, settled, unknown, unused
from rosorin_compile.language.expand import Expanded, expand
from rosorin_compile.language.expression.functions import plugged as plugged_functions
from rosorin_compile.language.lower import Lowered, lower
from rosorin_compile.language.section_registry import plugged as sections_of_plugins
from rosorin_compile.language.validate import validate
from rosorin_compile.language.wanted import with_wanted
from rosorin_compile.model import Link, Mesh, Output, Robot
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, arrange, error, has_errors
from rosorin_compile.source.files import recording
from rosorin_compile.source.load import unreadable
from rosorin_compile.source.load import unsaved as held_in_memory
from rosorin_compile.source.packages import PACKAGE_XML
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import of_tool
from rosorin_compile.source.tree import Map, locate
from rosorin_compile.source.wording import and_more, counted

if TYPE_CHECKING:
    from rosorin_compile.formats.imported import Imported
    from rosorin_compile.formats.mesh_files import Searched
    from rosorin_compile.language.asked import Asked
    from rosorin_compile.language.expand.files import Kept
    from rosorin_compile.language.expand.included_robots import How, Tell
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.project import Resolved

Search = Callable[[Map, Sequence[Output]], "Searched"]

# Of what there is to say, a notebook shows so much.
MAX_SHOWN = 200
NOTHING: Mapping[Path, bytes] = MappingProxyType({})
FILE = "file"  # begins the names of all attributes of MJCF that name one


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

    def files(self) -> dict[str, bytes]:
        """Return all that is to be written, bytes by name: the artifacts, and the mesh files with them.

        Raises OutputError for what cannot be a file.
        """
        from . import check_names, encoded

        files = {**self.mesh_files, **{one.file: encoded(one.file, one.text) for one in self.artifacts}}
        check_names(files)
        return files

    def proven(self) -> Compiled:
        """Read the artifacts back; if one contradicts the robot, return the result without them and with the reason."""
        from rosorin_compile.compare.agreement import agreement

        wrong = agreement(self.robot, self.artifacts) if self.robot is not None else []
        return replace(self, artifacts=(), diagnostics=[*self.diagnostics, *wrong]) if wrong else self

    @property
    def packages(self) -> dict[str, Path]:
        """The folders of the ROS packages that were found, by name."""
        return {one.name: Path(one.answer) for one in self.resolved if one.is_ros_package}

    @property
    def python_packages(self) -> list[Path]:
        """The folders of the packages of Python that were found."""
        return [Path(one.answer) for one in self.resolved if one.is_python_package]

    def __repr__(self) -> str:
        """Return what there is, without the texts of the artifacts."""
        return f"<Compiled {self.robot!r}, {len(self.artifacts)} artifacts, {_counted(self.diagnostics)}>"

    def _repr_html_(self) -> str:
        """Return the robot and what there is to say, for a notebook."""
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
        """Return what there is."""
        return f"<Reading {self.robot!r}, {_counted(self.diagnostics)}>"

    def _repr_html_(self) -> str:
        """Return the robot and what there is to say, for a notebook."""
        return _html(self.robot, self.diagnostics)


class Understood(NamedTuple):
    """What a description says: its tree, its model and where it was written (each only as far as it was right).

    ``used`` are the entries of ``accept`` that took something.
    """

    expanded: Expanded
    lowered: Lowered | None
    diagnostics: list[Diagnostic]
    used: frozenset[Entry] = frozenset()

    @property
    def case(self) -> Case | None:
        """The robot with the places of all that it says, to be asked about; None of one with errors."""
        from rosorin_compile.rules.case import Case
        from rosorin_compile.rules.remarkable import collect

        tree, lowered = self.expanded.tree, self.lowered
        if lowered is None or lowered.robot is None or tree is None or has_errors(self.diagnostics):
            return None
        return Case(lowered.robot, tree, lowered.places, collect(tree))


def understand(
    path: Path,
    arguments: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    wanted: Sequence[str] = (),
    kept: dict[Path, Kept] | None = None,
) -> Understood:
    """Return what the description whose first file is ``path`` says; no artifact is made.

    ``tell`` takes what has to be said before anything is run; without it, that is among the diagnostics. ``packages``
    are folders of ROS packages by name, for robots that are included. ``wanted`` as in ``judged``, ``kept`` as in
    ``expand``.
    """
    return judged(expand(path, arguments or {}, Readers(), tell, packages, kept), wanted)


def judged(expanded: Expanded, wanted: Sequence[str] = ()) -> Understood:
    """Return what a tree says, and whether it may.

    ``wanted`` are outputs that somebody asks for: names under ``outputs``, or of formats, which are taken with their
    defaults (see ``frontend.wanted``).
    """
    from rosorin_compile.rules.check import acceptable, check

    plugged = (*plugged_functions().diagnostics, *plugged_diagnostics(), *sections_of_plugins().diagnostics)
    if expanded.tree is None:
        return Understood(expanded, None, arrange([*expanded.diagnostics, *plugged, *_plugged_rules()]))
    tree, unknown_outputs = with_wanted(expanded.tree, wanted, FORMATS)
    expanded = expanded._replace(tree=tree)
    diagnostics = [*expanded.diagnostics, *plugged, *unknown_outputs]
    Progress.step("validating")
    diagnostics += validate(tree, FORMATS, expanded.scope)
    Progress.step("building the robot")
    lowered = None if has_errors(diagnostics) else lower(tree, expanded.scope)
    diagnostics += [*_plugged_rules(), *unknown(tree, acceptable())]
    if lowered is None or has_errors(diagnostics):
        return Understood(expanded, None, arrange(diagnostics))
    diagnostics += lowered.diagnostics
    if lowered.robot is not None:
        try:
            diagnostics += check(lowered.robot, tree, lowered.places, FORMATS, expanded.scope, wanted)
        except PluginFailed as problem:
            diagnostics.append(problem.diagnostic)
    if has_errors(diagnostics):
        from rosorin_compile.rules.misspelt import once

        diagnostics = once(diagnostics, tree, lowered.places)
    else:  # with errors, what is wrong may be the use
        diagnostics += expanded.unused
    left = settled(tree, diagnostics, acceptable())
    return Understood(expanded, lowered, arrange(_by_cause(expanded, left.diagnostics)), left.used)


def _by_cause(expanded: Expanded, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return what is wrong; what misses names of something that is left out says so, once."""
    if expanded.tree is None or expanded.scope is None or not expanded.scope.ledger.left_out:
        return diagnostics
    if all(one.severity == NOTE for one in diagnostics):
        return diagnostics
    from rosorin_compile.language.expand.left_out import told_by_cause

    return told_by_cause(expanded.scope, expanded.tree, diagnostics)


def _plugged_rules() -> tuple[Diagnostic, ...]:
    """Return what is wrong with the rules of plug-ins."""
    from rosorin_compile.rules.check import plugged

    return plugged().diagnostics


class Readers:
    """Reads the foreign robots that descriptions include (``expand.included_robots.ForeignReader``)."""

    def endings(self) -> tuple[str, ...]:
        """Return how the names of files end that a description may include and that are no descriptions."""
        return FORMATS.endings(include=True)

    def read(
        self, path: Path, texts: Mapping[str, str], packages: Mapping[str, Path], how: How, tell: Tell, by: Span
    ) -> Imported:
        """Return the robot of a file; ``by`` is the place that names it."""
        from rosorin_compile.formats.imported import ReadOptions
        from rosorin_compile.formats.reading import read_robot
        from rosorin_compile.rules.check import acceptable

        read = read_robot(path, ReadOptions(texts, packages, how.lenient, tell=tell), by)
        # Notes on what is accepted: the rules say so again, of the whole robot.
        new = [one for one in read.diagnostics if one.severity != NOTE or one.rule not in acceptable()]
        return read._replace(diagnostics=new)


def compile(  # noqa: A001 - the word of the API
    path: str | os.PathLike[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
) -> Compiled:
    """Compile a description; nothing is written, and nothing that is wrong with the input is an exception.

    ``path`` is its first file, its folder, or its name in ``descriptions/``, seen from the current folder.
    ``arguments`` are texts as behind ``-a NAME=``, or values of Python: numbers in SI units, truth values, None, lists
    and tables. ``packages`` are folders of ROS packages by name. Without ``robot`` there are errors in ``diagnostics``.
    """
    from rosorin_compile.language.asked import ask, description_of, is_description

    asked = ask(path, arguments, packages)
    first, missing = description_of(asked.name) if not asked.diagnostics else (None, asked.diagnostics)
    if first is None:
        return Compiled(None, (), missing, ())
    compiled = compile_robot(first, asked.arguments, packages=asked.packages)
    if compiled.robot is None and not is_description(first):
        message = f"{first.name} is not called as a description is, such as robot.yaml"
        note = Diagnostic("wrong-format", NOTE, message, None, (), "rosorin_compile.read takes robots in other formats")
        compiled.diagnostics.append(note)
    return compiled


def read(
    path: str | os.PathLike[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    lenient: bool = False,
    trust: bool = False,
    tell: Tell | None = None,
) -> Reading:
    """Return the robot of a file in any format that there is a reader for, or of a description as ``compile`` takes it.

    ``arguments`` are those of a description or a xacro. ``lenient`` takes what breaks a foreign format's specification
    where a robot comes out all the same. Nothing that is wrong with the input is an exception; a xacro is expanded in a
    process of its own, and what it says in Python is run there: a warning says so, unless there is ``trust``. ``tell``
    takes that warning before it is run.
    """
    from rosorin_compile.language.asked import ask, file_of, is_description

    asked = ask(path, arguments, packages)
    file, missing = file_of(asked.name) if not asked.diagnostics else (None, asked.diagnostics)
    if file is None:
        return Reading(None, missing, ())
    if not is_description(file):
        return _read_foreign(file, asked, lenient, trust, tell)
    expanded, lowered, diagnostics, _ = understand(file, asked.arguments, tell, asked.packages)
    robot = None if lowered is None or has_errors(diagnostics) else lowered.robot
    return Reading(robot, diagnostics, expanded.files, expanded.tree)


def _read_foreign(path: Path, asked: Asked, lenient: bool, trust: bool, tell: Tell | None) -> Reading:
    """Return the robot of a file that is no description."""
    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.formats.reading import read_robot
    from rosorin_compile.language.asked import as_texts, deaf

    texts, wrong = as_texts(asked.arguments)
    if wrong:
        return Reading(None, wrong, ())
    imported = read_robot(path, ReadOptions(texts, asked.packages, lenient, tell=tell, trust=trust))
    diagnostics = imported.diagnostics
    if texts and not imported.takes_arguments and imported.tree is not None:
        diagnostics.append(deaf(path))
    if imported.tree is None or has_errors(diagnostics):
        return Reading(None, arrange(diagnostics), imported.files)
    lowered = lower(imported.tree)
    diagnostics = arrange([*diagnostics, *lowered.diagnostics])
    return Reading(None if has_errors(diagnostics) else lowered.robot, diagnostics, imported.files, imported.tree)


def compile_robot(
    path: Path,
    arguments: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    search: Search | None = None,
    wanted: Sequence[str] = (),
    kept: dict[Path, Kept] | None = None,
    *,
    exact: bool = False,
    unsaved: Mapping[Path, bytes] = NOTHING,
) -> Compiled:
    """Compile the description whose first file is ``path``; nothing is written.

    ``arguments`` are texts by name, as on the command line. Problems are diagnostics, never exceptions. ``tell`` and
    ``packages`` as in ``understand``; ``search`` and ``wanted`` as in ``emitted``, ``kept`` as in ``expand``. Numbers
    are ``exact`` where an output does not say how it prints them. ``unsaved`` are bytes that are read in the place of
    files.
    """
    with recording() as recorded:
        try:
            compiled = _compiled(path, arguments, tell, packages, search, wanted, kept, exact, unsaved)
        except OSError as problem:
            if problem.filename is None:
                raise
            compiled = Compiled(None, (), [unreadable(problem)], (path,))
    known = {*map(os.path.abspath, compiled.inputs)}
    new = {
        path: found
        for path, found in recorded.items()
        if path.name != PACKAGE_XML and os.path.abspath(path) not in known and not of_tool(path)
    }
    missing = tuple(path for path, found in new.items() if not found)
    return replace(compiled, inputs=(*compiled.inputs, *new), missing=missing)


def _compiled(
    path: Path,
    arguments: Mapping[str, Any] | None,
    tell: Tell | None,
    packages: Mapping[str, Path] | None,
    search: Search | None,
    wanted: Sequence[str],
    kept: dict[Path, Kept] | None,
    exact: bool,
    unsaved: Mapping[Path, bytes],
) -> Compiled:
    with held_in_memory(unsaved):
        understood = understand(path, arguments, tell, packages, wanted, kept)
    if exact and understood.lowered is not None and understood.lowered.robot is not None:
        robot = understood.lowered.robot
        robot = replace(robot, outputs=tuple(map(_exactly, robot.outputs)))
        understood = understood._replace(lowered=understood.lowered._replace(robot=robot))
    if understood.expanded.scope is not None:
        understood.expanded.scope.ledger.forget()
    return emitted(understood, path, search, wanted)


def _exactly(output: Output) -> Output:
    """Return an output that prints all digits, if it may say so and does not."""
    if "number_format" not in FORMATS[output.backend].options:
        return output
    return replace(output, options={"number_format": "exact", **output.options})


def emitted(understood: Understood, path: Path, search: Search | None = None, wanted: Sequence[str] = ()) -> Compiled:
    """Return the artifacts of a robot that is understood; ``path`` is its first file.

    ``search`` looks for the files of meshes, by the tree and the outputs; without it each is taken to be where the
    artifacts look. ``wanted`` are the names of the only outputs that are made, in their order; without it all are.
    """
    expanded, lowered, diagnostics, used = understood
    if expanded.tree is None or lowered is None or lowered.robot is None or has_errors(diagnostics):
        return Compiled(None, (), diagnostics, expanded.files)
    from rosorin_compile.rules.check import acceptable

    robot, meshes = lowered.robot, None
    outputs = _outputs(robot, wanted)
    if search is not None and _has_files(robot):
        # An artifact that opens or measures meshes finds the same ones, whether the others are made or not.
        records = [FORMATS[output.backend] for output in outputs]
        opening = any(one.writing.opens is not None or one.writing.measures for one in records)
        meshes = search(expanded.tree, robot.outputs if opening else outputs)
        robot = meshes.told_to(robot)
    artifacts, said, templates = _made(robot, outputs, expanded.tree, path)
    may = acceptable() if meshes is None else {**acceptable(), **meshes.acceptable}
    said, more = settled(expanded.tree, [*(meshes.diagnostics if meshes else ()), *said], may)
    if has_errors(said):
        artifacts = ()
    if not wanted:  # else what is accepted may be about the others
        said += unused(expanded.tree, used | more, acceptable(), ("",) if search is None else ("", "meshes"))
    inputs = (*expanded.files, *templates, *(meshes.inputs if meshes else ()))
    led = (*expanded.resolved, *(meshes.resolved if meshes else ()))
    return Compiled(robot, artifacts, arrange([*diagnostics, *said]), inputs, led, meshes)


def _outputs(robot: Robot, wanted: Sequence[str]) -> tuple[Output, ...]:
    """Return the outputs that are made."""
    named = {output.name: output for output in robot.outputs}
    return tuple(named[name] for name in dict.fromkeys(wanted)) if wanted else robot.outputs


def _has_files(robot: Robot) -> bool:
    """Say whether a robot has meshes or textures, or elements of MJCF that may name files."""
    texts = (robot.mjcf_elements, *(link.mjcf_elements for link in robot.links))
    return (
        any(map(_has_file, robot.links))
        or any(one.texture for one in robot.materials)
        or any(FILE in text for inner in texts for text in inner)
    )


def _has_file(link: Link) -> bool:
    """Say whether a link has a mesh or a texture."""
    return any(isinstance(shape.geometry, Mesh) or shape.texture for shape in (*link.visual, *link.collision))


def _made(
    robot: Robot, outputs: Sequence[Output], tree: Map, path: Path
) -> tuple[tuple[Artifact, ...], list[Diagnostic], tuple[Path, ...]]:
    """Return the artifacts that outputs ask for, what formats cannot say, and the templates of the description."""
    from rosorin_compile.formats.templating import TemplateProblem, Templates

    templates, artifacts, told = Templates(path.parent, first=path), list[Artifact](), list[Diagnostic]()
    for number, output in enumerate(outputs):
        Progress.step(f"making {output.file},", number, len(outputs))
        format, place = FORMATS[output.backend], locate(tree, ("outputs", output.name), key=True)
        try:
            text, said = format.written(robot, output, templates)
        except TemplateProblem as problem:
            found = problem.diagnostic
            there = error(found.rule, found.message, place.span, found.help, place.stack())
            told.append(found if found.span else there)
            continue
        told += [d if d.span else replace(d, span=place.span, related=(*d.related, *place.stack())) for d in said]
        artifacts.append(Artifact(output.file, text, output.backend, output.name, format.is_withheld(output)))
    return tuple(artifacts), told, templates.read()


def _counted(diagnostics: Sequence[Diagnostic]) -> str:
    """Return how many diagnostics of each severity there are."""
    counts = Counter(diagnostic.severity for diagnostic in diagnostics)
    return ", ".join(counted(count, severity) for severity, count in counts.items()) or "nothing to say"


def _html(robot: Robot | None, diagnostics: Sequence[Diagnostic]) -> str:
    """Return a robot, and what there is to say of it, for a notebook."""
    from html import escape

    from rosorin_compile.source.report import text

    remarks = f"<pre>{escape(text(diagnostics[:MAX_SHOWN]))}</pre>" if diagnostics else ""
    if len(diagnostics) > MAX_SHOWN:
        remarks += f"<p>{and_more(len(diagnostics) - MAX_SHOWN).strip()}</p>"
    return remarks + (robot._repr_html_() if robot is not None else "")

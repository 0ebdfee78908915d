"""Compile a robot: load and check it, find its meshes, and generate its artifacts, without writing them to disk."""

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.language.arguments import with_wanted
from rosorin_compile.language.expand.description import ExpandedDescription, expand
from rosorin_compile.language.expand.included_robots import Tell
from rosorin_compile.language.expression.functions import plugin_functions as plugged_functions
from rosorin_compile.language.lower import LoweredRobot, lower
from rosorin_compile.language.schema import plugin_sections as plugged_sections
from rosorin_compile.language.suppressions import Entry, apply, unknown_rules, unused_entries
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot
from rosorin_compile.rules import check as rules
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.magnitudes import collect
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, error, has_errors
from rosorin_compile.source.files import label, record_reads
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import PACKAGE_XML
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import PYTHON_PACKAGE, ROS_PACKAGE, PackageFolder, tool_folders
from rosorin_compile.source.rule_registry import find_declared
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import count_of

from . import FORMATS, Artifact, plugged_diagnostics
from .format import notes as unsupported_notes
from .imported_robot import ImportedRobot, ReadOptions, as_tree
from .mesh_files import SearchResult
from .robot_files import outputs_of, read_robot
from .templating import TemplateProblem, Templates

Search = Callable[[Map, Sequence[Output]], SearchResult]


class LoadedRobot(NamedTuple):
    """A loaded robot: the expanded YAML tree, the robot model (None after errors), and all diagnostics."""

    expanded: ExpandedDescription
    lowered: LoweredRobot | None
    diagnostics: list[Diagnostic]
    used: frozenset[Entry] = frozenset()  # entries of ``accept`` that suppressed a diagnostic
    imported: ImportedRobot | None = None  # set for a robot in another format, such as a URDF

    @property
    def robot(self) -> Robot | None:
        return None if self.lowered is None or has_errors(self.diagnostics) else self.lowered.robot

    @property
    def case(self) -> Case | None:
        """The robot with the source positions of all values, or None after errors."""
        robot, tree, lowered = self.robot, self.expanded.tree, self.lowered
        return Case(robot, tree, lowered.places, collect(tree)) if robot and tree is not None and lowered else None


@dataclass(frozen=True)
class Variant:
    """A variant of a robot that ``sweep`` compiles, with the arguments to set."""

    name: str
    arguments: Map
    span: Span | None = None  # position of the name in the list
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class CompileResult:
    """The result of a compilation: the robot, its artifacts (none after errors), and all diagnostics.

    ``inputs`` are all files that can change the result, including ``missing`` files that were searched for but do not
    exist. ``meshes`` is None if meshes were not requested. ``variant`` is set by ``sweep``.
    """

    robot: Robot | None
    artifacts: tuple[Artifact, ...]
    diagnostics: list[Diagnostic]
    inputs: tuple[Path, ...]
    resolved: tuple[PackageFolder, ...] = ()  # the packages that were looked up, with their folders
    meshes: SearchResult | None = None
    variant: Variant | None = None
    missing: tuple[Path, ...] = ()

    @property
    def files_read(self) -> tuple[Path, ...]:
        return tuple(path for path in self.inputs if path not in self.missing)

    @property
    def mesh_files(self) -> Mapping[str, bytes]:
        return self.meshes.files if self.meshes else {}

    @property
    def packages(self) -> dict[str, Path]:
        return {found.name: found.folder for found in self.resolved if found.kind == ROS_PACKAGE}

    @property
    def python_packages(self) -> list[Path]:
        return [found.folder for found in self.resolved if found.kind == PYTHON_PACKAGE]

    def __repr__(self) -> str:
        return f"<CompileResult {self.robot!r}, {len(self.artifacts)} artifacts, {_counted(self.diagnostics)}>"


@dataclass(frozen=True)
class ReadResult:
    """The result of reading a robot in any format: the model, all diagnostics, the input files, the YAML tree."""

    robot: Robot | None
    diagnostics: list[Diagnostic]
    inputs: tuple[Path, ...]
    tree: Map | None = None

    def __repr__(self) -> str:
        return f"<ReadResult {self.robot!r}, {_counted(self.diagnostics)}>"


def _counted(diagnostics: Sequence[Diagnostic]) -> str:
    counts = Counter(diagnostic.severity for diagnostic in diagnostics)
    return ", ".join(count_of(count, severity) for severity, count in counts.items()) or "no diagnostics"


class RobotReader:
    """Reads files in other formats that a description includes."""

    def endings(self) -> tuple[str, ...]:
        return FORMATS.endings(include=True)

    def read(
        self, path: Path, texts: Mapping[str, str], packages: Mapping[str, Path], entry: Map, tell: Tell, by: Span
    ) -> ImportedRobot:
        """Import the file that an entry of ``include`` refers to; ``by`` is the source position of the entry."""
        call = entry if "macro" in entry else None
        spans = entry["args"].key_spans if texts else {}
        options = ReadOptions(texts, packages, bool(entry.get("lenient")), tell=tell, call=call, spans=spans)
        imported = read_robot(path, options, by)
        # Drop notes of rules, because the rules are checked again for the complete robot.
        new = [one for one in imported.diagnostics if one.severity != NOTE or one.rule not in rules.acceptable()]
        return imported._replace(diagnostics=new)


def understand(
    path: Path,
    arguments: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    requested: Sequence[str] = (),
    cache: dict[Any, Any] | None = None,
) -> LoadedRobot:
    """Load and check the description at ``path``.

    ``tell`` receives warnings before untrusted code is run. ``requested`` are formats to add to the outputs.
    """
    return check_expanded(expand(path, arguments or {}, RobotReader(), tell, packages, cache), requested)


def check_expanded(expanded: ExpandedDescription, requested: Sequence[str], is_valid: bool = False) -> LoadedRobot:
    """Check an expanded YAML tree and convert it to a robot; ``requested`` are formats to add to the outputs."""
    diagnostics = [*expanded.diagnostics, *plugged_functions()[1], *plugged_diagnostics()]
    diagnostics += [*plugged_sections().diagnostics, *rules.plugin_checks()[1]]
    if expanded.tree is None:
        return LoadedRobot(expanded, None, arrange(diagnostics))
    tree, unknown_outputs = with_wanted(expanded.tree, requested, FORMATS)
    expanded, scope = expanded._replace(tree=tree), expanded.scope
    Progress.step("validating")
    invalid = unknown_outputs if is_valid else [*unknown_outputs, *validate(tree, FORMATS, scope)]
    Progress.step("building the robot")
    lowered = None if has_errors([*diagnostics, *invalid]) else lower(tree, scope)
    diagnostics += [*invalid, *unknown_rules(tree, rules.acceptable())]
    if lowered is None or has_errors(diagnostics):
        return LoadedRobot(expanded, None, arrange(diagnostics))
    diagnostics += lowered.diagnostics
    if lowered.robot is not None:
        try:
            diagnostics += rules.check(lowered.robot, tree, lowered.places, FORMATS, scope, requested)
        except PluginFailed as problem:
            diagnostics.append(problem.diagnostic)
    is_wrong = has_errors(diagnostics)  # after an error, an argument can falsely seem unused
    merged = rules.merge_misspelt(diagnostics, tree) if is_wrong else diagnostics
    diagnostics = [*merged, *(() if is_wrong else expanded.unused)]
    found = apply(tree, diagnostics, rules.acceptable())
    diagnostics = found.diagnostics
    if scope and scope.expansion.disabled and any(one.severity != NOTE for one in diagnostics):
        from rosorin_compile.language.expand.description import explain_missing_names

        diagnostics = explain_missing_names(scope, tree, diagnostics)
    return LoadedRobot(expanded, lowered, arrange(diagnostics), found.used)


def understand_foreign(path: Path, options: ReadOptions) -> LoadedRobot:
    """Load a robot in another format, such as MJCF, without checking the rules. Its only output is a URDF."""
    imported = read_robot(path, options)
    expanded = _with_outputs(imported, [FORMATS.published_format().name])
    lowered = None if expanded.tree is None or has_errors(imported.diagnostics) else lower(expanded.tree)
    diagnostics = arrange([*imported.diagnostics, *(lowered.diagnostics if lowered is not None else ())])
    return LoadedRobot(expanded, lowered, diagnostics, imported=imported)


def judge_foreign(path: Path, how: ReadOptions, requested: Sequence[str] = (), optional: bool = False) -> LoadedRobot:
    """Load a robot in another format, such as MJCF, with the outputs that ``import`` writes, and check the rules."""
    names = [format.name for format in FORMATS.values() if optional or not format.optional]
    return check_expanded(_with_outputs(read_robot(path, how), [*names, *requested]), requested, is_valid=how.checked)


def _with_outputs(imported: ImportedRobot, names: Sequence[str]) -> ExpandedDescription:
    tree = imported.tree
    if tree is not None:
        entries = {name: entry for name, entry in outputs_of(imported).entries.items() if name in names}
        tree = tree.copy()
        tree.pop("outputs", None)
        tree.put("outputs", as_tree(entries, tree.span, ["outputs"]), tree.span, tree.span)
    return ExpandedDescription(tree, imported.diagnostics, imported.files)


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
) -> CompileResult:
    """Compile the description at ``path``. Errors in files are returned as diagnostics.

    ``search`` finds the mesh files; ``exact`` prints numbers with all digits. See ``understand`` for other arguments.
    """

    def with_all_digits(output: Output) -> Output:
        has_option = "number_format" in FORMATS[output.backend].options
        return replace(output, options={"number_format": "exact", **output.options}) if has_option else output

    with record_reads() as recorded:
        try:
            understood = understand(path, arguments, tell, packages, requested, cache)
            lowered = understood.lowered
            if exact and lowered is not None and lowered.robot is not None:
                robot = replace(lowered.robot, outputs=tuple(map(with_all_digits, lowered.robot.outputs)))
                understood = understood._replace(lowered=lowered._replace(robot=robot))
            if understood.expanded.scope is not None:
                understood.expanded.scope.expansion.forget()
                understood = understood._replace(expanded=understood.expanded._replace(scope=None, symbols=None))
            compiled = emit(understood, path, search, requested)
        except OSError as problem:
            if problem.filename is None:
                raise
            message = f"cannot read {label(os.fsdecode(problem.filename))}: {problem.strerror}"
            compiled = CompileResult(
                None, (), [error("file-unreadable", message, None, "check the permissions")], (path,)
            )
    listed = {*map(os.path.abspath, compiled.inputs)}
    own = tuple(f"{folder}{os.sep}" for folder in tool_folders().values())
    places = {os.path.abspath(path): path for path in recorded if path.name != PACKAGE_XML}
    new = [path for place, path in places.items() if place not in listed and not place.startswith(own)]
    return replace(compiled, inputs=(*compiled.inputs, *new), missing=tuple(path for path in new if not recorded[path]))


def emit(
    understood: LoadedRobot, path: Path, search: Search | None = None, requested: Sequence[str] = ()
) -> CompileResult:
    """Generate the artifacts of a robot for the outputs ``requested`` (default: all); ``search`` finds mesh files."""
    expanded, robot, diagnostics = understood.expanded, understood.robot, understood.diagnostics
    tree = expanded.tree
    if tree is None or robot is None:
        return CompileResult(None, (), diagnostics, expanded.files)
    meshes, acceptable, found = None, rules.acceptable(), list[Diagnostic]()
    named = {output.name: output for output in robot.outputs}
    outputs = [named[name] for name in dict.fromkeys(requested or named)]
    if search is not None:
        # Search for the meshes of all outputs, so that an artifact does not depend on which outputs are requested.
        opening = any(format.opens or format.measures for format in (FORMATS[output.backend] for output in outputs))
        meshes = search(tree, robot.outputs if opening else outputs)
        robot, acceptable = meshes.add_to(robot), {**acceptable, "mesh-not-found": find_declared("mesh-not-found")}
        found += meshes.diagnostics
    templates, artifacts = Templates(path.parent, first=path), list[Artifact]()
    for number, output in enumerate(outputs):
        Progress.step(f"making {output.file},", number, len(outputs))
        format, place = FORMATS[output.backend], tree.locate(("outputs", output.name), key=True)
        try:
            text, remarks = format.compile(robot, output, templates)
        except TemplateProblem as problem:
            text, remarks = "", [problem.diagnostic]
        found += [d if d.span else replace(d, span=place.span, related=(*d.related, *place.stack())) for d in remarks]
        artifacts.append(Artifact(output.file, text, output.backend, output.name, format.is_withheld(output)))
    found, more = apply(tree, [*found, *unsupported_notes(tree, outputs, FORMATS)], acceptable)
    if not requested:  # otherwise, an entry of ``accept`` may be for an output that was not generated
        stages = ("",) if search is None else ("", "meshes")
        found += unused_entries(tree, understood.used | more, rules.acceptable(), stages)
    all_diagnostics, inputs = arrange([*diagnostics, *found]), (*expanded.files, *templates.read())
    resolved = (*expanded.resolved, *(meshes.resolved if meshes else ()))
    return CompileResult(
        robot, () if has_errors(found) else tuple(artifacts), all_diagnostics, inputs, resolved, meshes
    )

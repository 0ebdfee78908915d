"""The Python API: functions that return a frozen dataclass and never print.

Functions of larger features are in other modules; ``rosorin_compile`` exports all of them. Errors in the files of a
robot are in ``diagnostics`` of the result. ``RequestError`` is raised for an invalid argument, a missing package, or a
file that must not be replaced, and ``UnknownName`` for an unknown name. Arguments of many functions:

- ``robot``: the path of the main file or folder of a description, or its name in ``descriptions/``. Functions that do
  not compile also accept a file in another format, such as URDF. The command line passes a ``Request``.
- ``arguments``: values by name for the arguments of the description or xacro: strings, as in ``-a NAME=TEXT``, or
  Python values in SI units.
- ``packages``: folders of ROS packages by package name.
- ``trust``: run Python code in a xacro without a warning. Otherwise, the warning is passed to ``warn``, or is in
  ``diagnostics``.
- ``output``: the file or folder to write. ``force`` replaces a file that this tool did not write.
"""

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.compare.difference import DEFAULT_TOLERANCE, YAML, Difference, Side
from rosorin_compile.compare.golden_check import GoldenDifferences, compare_committed, load_all
from rosorin_compile.compare.precision import printed_precision
from rosorin_compile.compare.sentences import several
from rosorin_compile.formats import FORMATS, plugged_diagnostics, schema_names, schema_text
from rosorin_compile.formats.compilation import CompileResult, ReadResult
from rosorin_compile.formats.imported_robot import ImportedRobot
from rosorin_compile.formats.mesh_files import opened_by
from rosorin_compile.language.arguments import Argument, declared_arguments, takes_no_arguments
from rosorin_compile.model import Output, Robot
from rosorin_compile.output.artifact_set import read_set, write_artifacts
from rosorin_compile.output.atomic_files import OutputError
from rosorin_compile.request import EXECUTED, FilePath, Packages, Request, Values
from rosorin_compile.rules.check import plugin_checks
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, RequestError, UnknownName, error, has_errors
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.project import Description, all_here
from rosorin_compile.source.rule_registry import OF_PLUGINS, Rule, find

if TYPE_CHECKING:
    from rosorin_compile.language.explain import Answer, Explanation, NamedValue
    from rosorin_compile.mujoco.collisions import CollisionMatrix


@dataclass(frozen=True)
class CheckResult:
    """The result of comparing the committed artifacts of a robot with newly compiled artifacts.

    ``differing`` are files that are missing, changed, or no longer artifacts; ``lines`` describe the differences as
    ``rosorin-compile check`` prints them. Both are empty if ``compiled`` has errors.
    """

    compiled: CompileResult
    folder: Path
    differing: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    committed: GoldenDifferences | None = field(default=None, repr=False)

    @property
    def same(self) -> bool:
        """Whether the robot has no errors, and all committed artifacts are up to date."""
        return not self.differing and not has_errors(self.diagnostics)

    def __str__(self) -> str:
        return "\n".join(self.lines)


@dataclass(frozen=True)
class WriteResult:
    """The names of the files in ``folder`` after writing the artifacts of a robot.

    ``kept`` are files that are not artifacts and were not touched; ``removed`` are files that ``prune`` deleted. If
    ``diagnostics`` has errors, nothing was written.
    """

    compiled: CompileResult
    folder: Path
    written: tuple[str, ...] = ()
    unchanged: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class ExplainResult:
    """The explanations of the requested names, with the YAML line of each number; empty if there are errors."""

    answers: "tuple[Explanation | Answer | NamedValue, ...]" = ()
    diagnostics: tuple[Diagnostic, ...] = ()

    def __str__(self) -> str:
        from rosorin_compile.language.explain import lines

        return "\n".join(line for answer in self.answers for line in lines(answer))


@dataclass(frozen=True)
class Arguments:
    """The arguments that a description declares, with their current values."""

    robot: str
    arguments: tuple[Argument, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Outputs:
    """The outputs of a robot; ``outputs`` is None if ``diagnostics`` has errors."""

    robot: str
    outputs: tuple[Output, ...] | None = None
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Rules:
    """The documentation of rules; ``diagnostics`` has the errors of plug-ins that cannot be loaded."""

    rules: tuple[Rule, ...]
    diagnostics: tuple[Diagnostic, ...] = ()


def compile(  # noqa: A001 - like re.compile
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    outputs: Sequence[str] = (),
    meshes: bool = False,
    trust: bool = False,
) -> CompileResult:
    """Compile a description to artifacts in memory; ``write`` also writes them to files.

    If there are errors, ``diagnostics`` of the result lists them, and ``artifacts`` is empty.

    Args:
        outputs: Names of the outputs to generate. Default: all.
        meshes: Search the mesh files, and verify the artifacts by reading them back, as ``rosorin-compile all`` does.

    Example:
        >>> import rosorin_compile
        >>> compiled = rosorin_compile.compile("descriptions/rosorin")
        >>> compiled.robot
        <Robot rosorin: 60 links, 59 joints (51 that move), 3 sensors>
        >>> [artifact.file for artifact in compiled.artifacts][:4]
        ['controllers.yaml', 'frames.md', 'frames_amcl.svg', 'frames_slam.svg']
    """
    return Request.from_arguments(robot, arguments, packages, trust=trust).compile(outputs, meshes=meshes)


def read(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    lenient: bool = False,
    trust: bool = False,
) -> ReadResult:
    """Read a robot in any supported format: URDF, xacro, SDF, MJCF, ``robot_model`` JSON, or a description.

    Args:
        lenient: Where possible, accept files that violate the specification of their format.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.read("outputs/rosorin/rosorin.urdf").robot
        <Robot rosorin: 11 links, 10 joints (5 that move), 0 sensors>
    """
    return Request.from_arguments(robot, arguments, packages, trust=trust).read(lenient)


def check(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    outputs: FilePath | None = None,
    trust: bool = False,
) -> CheckResult:
    """Compile a description, and compare the result with the committed artifacts.

    Args:
        outputs: The folder that contains one subfolder per robot. Default: the outputs folder of the project.

    Example:
        >>> import rosorin_compile
        >>> checked = rosorin_compile.check("rosorin")
        >>> checked.same, checked.differing
        (True, ())
    """
    request = Request.from_arguments(robot, arguments, packages, outputs, trust)
    compiled, folder = request.compile(), request.description.outputs
    diagnostics = tuple(compiled.diagnostics)
    if compiled.robot is None or has_errors(diagnostics):
        return CheckResult(compiled, folder, diagnostics=diagnostics)
    try:
        present = read_set(folder)
    except OutputError as problem:
        return CheckResult(compiled, folder, diagnostics=(*diagnostics, problem.diagnostic))
    committed = compare_committed(compiled, present, folder, lambda: request.understand().case)
    diagnostics = (*diagnostics, *committed.diagnostics)
    return CheckResult(compiled, folder, committed.differing_files(), tuple(committed.lines()), diagnostics, committed)


def write(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    outputs: FilePath | None = None,
    prune: bool = False,
    *,
    only: Sequence[str] = (),
    trust: bool = False,
) -> WriteResult:
    """Compile a description and write its artifacts. If there are errors, nothing is written.

    Args:
        outputs: As in ``check``.
        prune: Delete files in the robot's subfolder that are not artifacts.
        only: Names of the outputs to write. Default: all.

    Example:
        >>> import rosorin_compile, tempfile
        >>> written = rosorin_compile.write("rosorin", outputs=tempfile.mkdtemp())
        >>> len(written.written), written.unchanged, written.kept
        (16, (), ())
    """
    request = Request.from_arguments(robot, arguments, packages, outputs, trust)
    compiled, folder = request.compile(only), request.description.outputs
    diagnostics, artifacts, searched = compiled.diagnostics, compiled.artifacts, compiled.meshes
    if compiled.robot is None or not artifacts or has_errors(diagnostics):
        return WriteResult(compiled, folder, diagnostics=tuple(diagnostics))
    meshes = compiled.mesh_files
    if only and searched is not None:
        written = {artifact.output for artifact in artifacts}
        outputs_written = [output for output in compiled.robot.outputs if output.name in written]
        names = {opened_by(output, found.named.name) for found in searched.found for output in outputs_written}
        meshes = {name: data for name, data in meshes.items() if name in names}
    files: dict[str, str | bytes] = {**meshes, **{artifact.file: artifact.text for artifact in artifacts}}
    try:
        done = write_artifacts(folder, files, prune)
    except OutputError as problem:
        return WriteResult(compiled, folder, diagnostics=(*diagnostics, problem.diagnostic))
    changed = [artifact for artifact in artifacts if artifact.file in done.written]
    more = [*done.diagnostics(folder), *load_all(changed, folder, lambda: request.understand().case)]
    for name in () if only else done.kept:
        message = f"{folder}/{name} is not an artifact of this robot; it is kept"
        more.append(Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it"))
    return WriteResult(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*diagnostics, *more))


def diff(
    a: FilePath | Robot | Request,
    b: FilePath | Robot | Request,
    tolerance: float = DEFAULT_TOLERANCE,
    prefix: str | None = None,
    *,
    arguments: Values = None,
    a_arguments: Values = None,
    b_arguments: Values = None,
    packages: Packages = None,
    brief: bool = False,
    trust: bool = False,
) -> Difference:
    """Compare the meaning of two robots: descriptions, files in any supported format, or ``Robot`` objects.

    Values that the format of a robot cannot express are not compared. If ``diagnostics`` of the result has errors,
    ``a`` and ``b`` are None. ``str(result)`` is the text that ``rosorin-compile diff`` prints.

    Args:
        tolerance: The largest difference to ignore: in metres, in radians, or relative to any other number.
        prefix: The prefix of all names in ``b``, or "" for none. Default: detect it.
        arguments: Arguments of both robots.
        a_arguments: Arguments of ``a`` only; ``b_arguments`` are those of ``b`` only.
        brief: Shorten ``not_compared``, the list of values that were not compared.

    Example:
        >>> import rosorin_compile
        >>> difference = rosorin_compile.diff("rosorin", "outputs/rosorin/rosorin.urdf")
        >>> difference.same, difference.items
        (True, ())
        >>> rosorin_compile.diff("rosorin", "nothing.urdf").diagnostics[0].message
        'cannot read nothing.urdf: No such file or directory'
    """
    from rosorin_compile.compare.diff import compare_robots

    diagnostics: list[Diagnostic] = []
    if isinstance(tolerance, bool) or not (isinstance(tolerance, (int, float)) and 0 <= tolerance < float("inf")):
        message = f"the tolerance is a number from zero upwards, not {tolerance!s:.60}"
        diagnostics.append(error("bad-argument", message, None))
    loaded = [_load_side(robot, arguments, own, packages, trust) for robot, own in ((a, a_arguments), (b, b_arguments))]
    (first, first_file, _), (second, second_file, _) = loaded
    diagnostics += [one for _, _, found in loaded for one in found]
    if first and arguments and all(file is not None and not file.takes_arguments for file in (first_file, second_file)):
        diagnostics.append(takes_no_arguments(Path(first.label)))
    if first is None or second is None or has_errors(diagnostics):
        return Difference(None, None, (), (), (), tolerance, tuple(dict.fromkeys(diagnostics)))
    try:
        found = compare_robots(first, second, tolerance, prefix)
    except PluginFailed as problem:
        return Difference(None, None, (), (), (), tolerance, (*diagnostics, problem.diagnostic))
    not_compared = [*found.not_compared]
    for side, file in ((first, first_file), (second, second_file)):
        if file is not None and file.left_out:
            left_out = [several(file.left_out)] if brief else file.left_out
            not_compared += [f"{side.label}: {what}" for what in left_out]
    return replace(found, not_compared=tuple(not_compared), diagnostics=tuple(diagnostics))


def _load_side(
    robot: FilePath | Robot | Request, shared: Values, own: Values, packages: Packages, trust: bool
) -> tuple[Side | None, ImportedRobot | None, list[Diagnostic]]:
    if isinstance(robot, Robot):
        return Side(robot.name, YAML, robot), None, []
    requests = [Request.from_arguments(robot, values, packages, trust=trust) for values in (shared, own)]
    if problems := [problem for request in requests for problem in request.problems]:
        return None, None, problems
    request = replace(requests[1], arguments={**requests[0].arguments, **requests[1].arguments})
    found, path = request.understand(), request.description.path
    diagnostics = [d for d in found.diagnostics if d.severity == ERROR or (d.rule == EXECUTED and not request.trust)]
    if found.robot is None:
        return None, None, diagnostics
    label = str(path) if isinstance(robot, Request) or path == Description.ON_STDIN else os.fsdecode(robot)
    imported = found.imported
    if imported is None or imported.tree is None:
        return Side(label, YAML, found.robot, folder=path.parent), None, diagnostics
    if requests[1].arguments and not imported.takes_arguments:
        diagnostics.append(takes_no_arguments(path))
    reduced = replace(found.robot, outputs=())
    text = imported.tree.span.source.text
    return Side(label, FORMATS[imported.format], reduced, printed_precision(text), path.parent), imported, diagnostics


def explain(
    robot: FilePath | Request, names: Sequence[str], arguments: Values = None, packages: Packages = None, pose: str = ""
) -> ExplainResult:
    """Explain frames, links, joints, sensors or parts: return their numbers and the YAML line that defines each.

    Args:
        names: Names of frames, links, etc. Names of numbers, such as ``z`` or ``mass``, restrict the result to these.
        pose: The name of a pose of the description. Frames are also computed at its joint positions.

    Example:
        >>> import rosorin_compile
        >>> explained = rosorin_compile.explain("rosorin", ["laser", "z"])
        >>> number = explained.answers[0].numbers[0]
        >>> number.name, number.value, number.unit, number.origin.where.file, number.origin.where.line
        ('z', 0.106748, 'm', 'descriptions/rosorin/lidar_and_imu.yaml', 25)
    """
    from rosorin_compile.language.explain import explain as explain_names

    request = Request.from_arguments(robot, arguments, packages)
    found = request.understand(foreign=False)
    if found.lowered is None or found.robot is None:
        return ExplainResult(diagnostics=tuple(found.diagnostics))
    answers = explain_names(found.expanded, found.lowered, request.values(), names, pose)
    return ExplainResult(tuple(answers), tuple(found.diagnostics))


def arguments(robot: FilePath | Request, arguments: Values = None, packages: Packages = None) -> Arguments:
    """List the arguments that a description declares; ``arguments`` sets their current values.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.arguments("examples/unitree_a1")
        >>> [(one.name, one.allowed, one.default) for one in found.arguments if one.name == "base"]
        [('base', ('fixed', 'free'), 'free')]
    """
    request = Request.from_arguments(robot, arguments, packages)
    name, problems = request.description.name, [*request.problems]
    found: list[Argument] = []
    try:
        if not problems:
            found, problems = declared_arguments(request.description.path, request.values(), request.packages)
    except LoadError as problem:
        problems = [problem.diagnostic]
    return Arguments(name, tuple(found), tuple(problems))


def outputs(robot: FilePath | Request, arguments: Values = None, packages: Packages = None) -> Outputs:
    """List the outputs of a robot in any supported format.

    Example:
        >>> import rosorin_compile
        >>> [output.file for output in rosorin_compile.outputs("rosorin").outputs][:2]
        ['controllers.yaml', 'frames.md']
    """
    request = Request.from_arguments(robot, arguments, packages)
    found, name = request.understand(outputs=True), request.description.name
    return Outputs(name, None if found.robot is None else found.robot.outputs, tuple(found.diagnostics))


def explain_rules(ids: Sequence[str] = ()) -> Rules:
    """Return the documentation of the rules ``ids``, or of all rules including plug-ins, sorted by id.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.explain_rules(["axis-zero"]).rules[0].help
        'Write a direction, such as `[0, 0, 1]`.'
    """
    diagnostics = (*plugin_checks()[1], *plugged_diagnostics())
    known = {**OF_PLUGINS, **find(ids or None)}
    for id in ids:
        if id not in known:
            raise UnknownName("rule", id, {**find(), **OF_PLUGINS})
    return Rules(tuple(known[id] for id in dict.fromkeys(ids or sorted(known))), diagnostics)


def schema(name: str = "authoring", macros: bool = False) -> dict[str, Any]:
    """Return the JSON Schema with this name (see ``rosorin-compile schema --list``). Default: the schema for editors.

    Args:
        macros: Add the names and parameters of macros in the xacro files that the descriptions of this project include.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.schema("robot_model")["type"]
        'object'
    """
    if name not in (known := schema_names()):
        raise UnknownName("schema", name, known)
    found: dict[str, Any] = json.loads(schema_text(name))
    if macros:
        from rosorin_compile.importing.xacro.macros import with_macros

        if name != "authoring":
            raise RequestError(f'the schema "{name}" has no include: macros goes with "authoring"')
        found = with_macros(found, all_here())
    return found


def collisions(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
) -> "CollisionMatrix":
    """Compute which pairs of links MoveIt need not check for collisions, and write them and their distances (m).

    Args:
        output: The file to write. Default: ``collisions.yaml`` next to the description, which includes it.
        force: Compute the pairs again, even if the file is up to date.
    """
    from rosorin_compile.mujoco.collisions import compute_matrix
    from rosorin_compile.ros.srdf.planning import planning_model

    request = Request.from_arguments(robot, arguments, packages, trust=trust)
    return compute_matrix(request, planning_model, output=None if output is None else Path(output), force=force)

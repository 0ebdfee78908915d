"""The Python API: one function for each command, which returns a frozen dataclass and never prints.

Errors in the files of a robot are among the ``diagnostics`` of the result. An invalid argument, a missing package or a
file that must not be replaced raises ``RequestError``, an unknown name ``UnknownName``, which has a suggestion. Many
functions have these arguments:

- ``robot``: a description, as its main file, its folder, or its name in ``descriptions/``. Functions that do not
  compile also accept a URDF, xacro, SDF, MJCF or ``robot_model`` JSON file. The command line passes a ``Request``.
- ``arguments``: arguments of the description or the xacro by name. Values are texts as in ``-a NAME=TEXT``, numbers in
  SI units, truth values, None, lists and dicts.
- ``packages``: folders of ROS packages by name.
- ``trust``: run the Python code of a xacro without a warning in ``diagnostics``. ``warn`` receives the warning before
  the code is run.
- ``output``: the file or folder to write. ``force`` replaces a file that this tool did not write.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile import queries
from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import DEFAULT_TOLERANCE, YAML, Difference, Side
from rosorin_compile.compare.precision import printed
from rosorin_compile.compare.sentences import several
from rosorin_compile.formats import FORMATS, plugged_diagnostics, schema_names, schema_text
from rosorin_compile.formats.compiled import Compiled, Reading
from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.formats.mesh_files import opened_by
from rosorin_compile.language.arguments import Argument, as_texts, declared, of_api, takes_no_arguments
from rosorin_compile.language.explain import explain as explain_names
from rosorin_compile.model import Pose, Robot
from rosorin_compile.model.servos import against_model
from rosorin_compile.output import OutputError, read_set, write_artifacts
from rosorin_compile.output.committed import compare_committed, judged
from rosorin_compile.request import FilePath, Request
from rosorin_compile.rules.check import plugged
from rosorin_compile.rules.publishers import check_modes
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    MissingPackages,
    RequestError,
    UnknownName,
    error,
    has_errors,
)
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.project import Description, all_here, no_file
from rosorin_compile.source.rule_registry import OF_PLUGINS, find
from rosorin_compile.source.system import pip_install
from rosorin_compile.viewer import frames as viewer_frames
from rosorin_compile.viewer.frames import Frames
from rosorin_compile.viewer.frames_picture import frame_trees
from rosorin_compile.viewer.picture.draw import Look, Picture, draw
from rosorin_compile.viewer.showing import Page, write_page

from .results import Arguments, Checked, Explained, ModelComparison, Outputs, Pulses, Rules, Transforms, Written

if TYPE_CHECKING:
    from distributed import Client

    from rosorin_compile.importing.extract.extract import ExtractedBoxes, ExtractedFactory, ExtractedHeightMap
    from rosorin_compile.importing.import_robot import ImportResult
    from rosorin_compile.importing.new_robot import NewRobot
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.checking import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.recordings.results import Verified
    from rosorin_compile.ros.check_parameters.checking import CheckedParameters
    from rosorin_compile.ros.graph import RobotGraph
    from rosorin_compile.ros.package.deploy import CheckedCopies, Deployed
    from rosorin_compile.ros.package.package import WrittenPackage
    from rosorin_compile.rules.case import Case
    from rosorin_compile.variants.writing import WrittenVariants

Values = Mapping[str, Any] | None
Packages = Mapping[str, FilePath] | None
Warn = Callable[[Diagnostic], None] | None


_EXECUTED = "xacro-runs-code"  # the rule of the warning about code that was executed


def compile(  # noqa: A001 - re.compile has this name, too
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    outputs: Sequence[str] = (),
    meshes: bool = False,
    trust: bool = False,
) -> Compiled:
    """Compile a description to its artifacts; nothing is written.

    Without ``robot`` in the result there are errors in ``diagnostics``.

    Args:
        outputs: The names of the only outputs to generate.
        meshes: Search the mesh files, and read the artifacts back, as ``rosorin-compile all`` does.

    Example:
        >>> import rosorin_compile
        >>> compiled = rosorin_compile.compile("descriptions/rosorin")
        >>> compiled.robot
        <Robot rosorin: 60 links, 59 joints (51 that move), 3 sensors>
        >>> [artifact.file for artifact in compiled.artifacts][:4]
        ['controllers.yaml', 'frames.md', 'frames_amcl.svg', 'frames_slam.svg']
    """
    request = Request.of(robot, arguments, packages, trust=trust)
    compiled, path = request.compile(outputs, meshes=meshes), request.description.path
    if compiled.robot is None and not request.problems and os.path.lexists(path) and request.is_foreign:
        message = f"{path.name} is not called as a description is, such as robot.yaml"
        help = "rosorin_compile.read takes robots in other formats"
        compiled.diagnostics.append(Diagnostic("wrong-format", NOTE, message, help=help))
    return compiled


def read(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    lenient: bool = False,
    trust: bool = False,
) -> Reading:
    """Read a robot in any supported format: URDF, xacro, SDF, MJCF, ``robot_model`` JSON, or a description.

    Args:
        lenient: Accept violations of the specification of a format where possible.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.read("outputs/rosorin/rosorin.urdf").robot
        <Robot rosorin: 11 links, 10 joints (5 that move), 0 sensors>
    """
    return Request.of(robot, arguments, packages, trust=trust).read(lenient)


def check(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    outputs: FilePath | None = None,
    trust: bool = False,
) -> Checked:
    """Compile a description and compare the result with its committed artifacts.

    Args:
        outputs: The folder that contains a folder for each robot; by default that of the project.

    Example:
        >>> import rosorin_compile
        >>> checked = rosorin_compile.check("rosorin")
        >>> checked.same, checked.differing
        (True, ())
    """
    request = Request.of(robot, arguments, packages, outputs, trust)
    compiled, folder = request.compile(), request.description.outputs
    diagnostics = tuple(compiled.diagnostics)
    if compiled.robot is None or has_errors(diagnostics):
        return Checked(compiled, folder, diagnostics=diagnostics)
    try:
        present = read_set(folder)
    except OutputError as problem:
        return Checked(compiled, folder, diagnostics=(*diagnostics, problem.diagnostic))
    committed = compare_committed(compiled, present, folder, lambda: request.understand().case)
    diagnostics = (*diagnostics, *committed.diagnostics)
    return Checked(compiled, folder, committed.differing(), tuple(committed.lines()), diagnostics, committed)


def write(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    outputs: FilePath | None = None,
    prune: bool = False,
    *,
    only: Sequence[str] = (),
    trust: bool = False,
) -> Written:
    """Compile a description and write its artifacts, all of them or none.

    Args:
        outputs: As in ``check``.
        prune: Delete files in the robot's folder that are not artifacts.
        only: The names of the only outputs to write.

    Example:
        >>> import rosorin_compile, tempfile
        >>> written = rosorin_compile.write("rosorin", outputs=tempfile.mkdtemp())
        >>> len(written.written), written.unchanged, written.kept
        (16, (), ())
    """
    request = Request.of(robot, arguments, packages, outputs, trust)
    compiled, folder = request.compile(only), request.description.outputs
    diagnostics, artifacts, searched = compiled.diagnostics, compiled.artifacts, compiled.meshes
    if compiled.robot is None or not artifacts or has_errors(diagnostics):
        return Written(compiled, folder, diagnostics=tuple(diagnostics))
    meshes = compiled.mesh_files
    if only and searched is not None:
        written = {artifact.output for artifact in artifacts}
        outputs_written = [output for output in compiled.robot.outputs if output.name in written]
        names = {opened_by(output, found.named.name) for found in searched.found for output in outputs_written}
        meshes = {name: data for name, data in meshes.items() if name in names}
    files: dict[str, str | bytes] = {**meshes, **{artifact.file: artifact.text for artifact in artifacts}}
    try:
        done = write_artifacts(folder, files, prune, complete=not only)
    except OutputError as problem:
        return Written(compiled, folder, diagnostics=(*diagnostics, problem.diagnostic))
    changed = [artifact for artifact in artifacts if artifact.file in done.written]
    more = [*done.diagnostics(folder), *judged(changed, folder, lambda: request.understand().case)]
    for name in () if only else done.kept:
        message = f"{folder}/{name} is no artifact of this robot; it is kept"
        more.append(Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it"))
    return Written(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*diagnostics, *more))


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
    """Compare two robots by meaning: descriptions, files in any supported format, or ``Robot`` objects.

    A ``Robot`` counts as a description, which can express every value: pass the path of a file in another format.
    Without ``a`` and ``b`` in the result there are errors in ``diagnostics``. ``str`` of it is the text of
    ``rosorin-compile diff``.

    Args:
        tolerance: The largest difference to ignore, in metres, radians or relative to the number.
        prefix: The prefix of all names in ``b``; by default it is detected.
        arguments: Arguments of both robots.
        a_arguments: Arguments of ``a`` only.
        b_arguments: Arguments of ``b`` only.
        brief: Shorten the lists of what is not compared.

    Example:
        >>> import rosorin_compile
        >>> difference = rosorin_compile.diff("rosorin", "outputs/rosorin/rosorin.urdf")
        >>> difference.same, difference.items
        (True, ())
        >>> rosorin_compile.diff("rosorin", "nothing.urdf").diagnostics[0].message
        'cannot read nothing.urdf: No such file or directory'
    """
    diagnostics: list[Diagnostic] = []
    if isinstance(tolerance, bool) or not (isinstance(tolerance, (int, float)) and 0 <= tolerance < float("inf")):
        message = f"the tolerance is a number from zero upwards, not {tolerance!s:.60}"
        diagnostics.append(error("bad-argument", message, None))
    if not (prefix is None or isinstance(prefix, str)):
        diagnostics.append(error("bad-argument", f"the prefix is text, not {prefix!s:.60}", None))
    first = _side(a, arguments, a_arguments, packages, trust)
    second = _side(b, arguments, b_arguments, packages, trust)
    diagnostics += [*first.diagnostics, *second.diagnostics]
    if arguments and first.deaf and second.deaf:
        diagnostics.append(takes_no_arguments(first.deaf))
    if first.side is None or second.side is None or has_errors(diagnostics):
        return Difference(None, None, (), (), (), tolerance, tuple(dict.fromkeys(diagnostics)))
    try:
        found = compare_robots(first.side, second.side, tolerance, prefix)
    except PluginFailed as problem:
        return Difference(None, None, (), (), (), tolerance, (*diagnostics, problem.diagnostic))
    not_compared = [*found.not_compared]
    for one in (first, second):
        left_out = [several(one.left_out)] if brief and one.left_out else one.left_out
        not_compared += [f"{one.side.label}: {what}" for what in left_out if one.side is not None]
    return replace(found, not_compared=tuple(not_compared), diagnostics=tuple(diagnostics))


class _Loaded(NamedTuple):
    """One side of a comparison, and what of its file is not part of it; ``deaf`` is a file that takes no arguments."""

    side: Side | None
    diagnostics: Sequence[Diagnostic] = ()
    left_out: Sequence[str] = ()
    deaf: Path | None = None


def _side(robot: FilePath | Robot | Request, shared: Values, own: Values, packages: Packages, trust: bool) -> _Loaded:
    if isinstance(robot, Robot):
        return _Loaded(Side(robot.name, YAML, robot))
    requests = [Request.of(robot, values, packages, trust=trust) for values in (shared, own)]
    if problems := [problem for request in requests for problem in request.problems]:
        return _Loaded(None, problems)
    request = replace(requests[1], arguments={**requests[0].arguments, **requests[1].arguments})
    found, path = request.understand(), request.description.path
    diagnostics = [d for d in found.diagnostics if d.severity == ERROR or (d.rule == _EXECUTED and not request.trust)]
    if found.robot is None:
        return _Loaded(None, diagnostics)
    label = str(path) if isinstance(robot, Request) or path == Description.ON_STDIN else os.fsdecode(robot)
    imported = found.imported
    if imported is None or imported.tree is None:
        return _Loaded(Side(label, YAML, found.robot, folder=path.parent), diagnostics)
    if requests[1].arguments and not imported.takes_arguments:
        diagnostics.append(takes_no_arguments(path))
    reduced = replace(found.robot, outputs=())
    side = Side(label, FORMATS[imported.format], reduced, printed(imported.tree.span.source.text), path.parent)
    return _Loaded(side, diagnostics, imported.left_out, None if imported.takes_arguments else path)


def explain(
    robot: FilePath | Request, names: Sequence[str], arguments: Values = None, packages: Packages = None, pose: str = ""
) -> Explained:
    """Return the poses of frames, links, joints, sensors or parts, and the line of YAML behind each number.

    Args:
        names: Names of things, and of the only numbers of them to explain, such as ``z`` or ``mass``.
        pose: The named pose in which frames are shown, too.

    Example:
        >>> import rosorin_compile
        >>> explained = rosorin_compile.explain("rosorin", ["laser", "z"])
        >>> number = explained.answers[0].numbers[0]
        >>> number.name, number.value, number.unit, number.origin.where.file, number.origin.where.line
        ('z', 0.106748, 'm', 'descriptions/rosorin/lidar_and_imu.yaml', 25)
    """
    request = Request.of(robot, arguments, packages)
    found = request.understand(foreign=False)
    if found.lowered is None or found.robot is None:
        return Explained(diagnostics=tuple(found.diagnostics))
    answers = explain_names(found.expanded, found.lowered, request.values(), names, pose)
    return Explained(tuple(answers), tuple(found.diagnostics))


def transform(
    robot: FilePath | Request,
    source: str,
    target: str,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    joints: Values = None,
    pulses: Values = None,
    sweeps: Mapping[str, str] | None = None,
    modes: Mapping[str, bool] | None = None,
    strict: bool = False,
    trust: bool = False,
) -> Transforms:
    """Return the pose of a frame in another, with the numbers that ``tf2_echo`` prints.

    Args:
        source: The frame in which the pose is expressed.
        target: The frame whose pose is returned.
        pose: A named pose of the description; joints that nothing sets are at zero.
        joints: Positions by joint: numbers in rad or m, or texts such as ``"30deg"``. They override all others.
        pulses: Pulses of servos by joint; they override ``pose``.
        sweeps: Positions to use in turn by joint, ``"FROM:TO:COUNT"``; of several, all combinations.
        modes: Modes of the robot that are on or off; if any is set, all others are off.
        strict: Treat positions beyond a limit as errors.

    Example:
        >>> import rosorin_compile
        >>> (found,) = rosorin_compile.transform("rosorin", "base_link", "laser").transforms
        >>> found.translation
        (0.048156, 7.5552e-05, 0.106748)
    """
    case, diagnostics = _case(Request.of(robot, arguments, packages, trust=trust))
    if case is None:
        return Transforms(diagnostics=diagnostics)
    start = queries.positions(case.robot, pose, joints or {}, pulses or {})
    turned = [queries.sweep_of(case.robot, name, text) for name, text in (sweeps or {}).items()]
    states = list(queries.states(start, turned))
    diagnostics = (*diagnostics, *queries.beyond_limits(case, states, ERROR if strict else WARNING))
    if has_errors(diagnostics):
        return Transforms(diagnostics=diagnostics, robot=case.robot)
    check_modes(case.robot, modes or {})
    found, remarks = queries.transforms(case, source, target, states, modes or {})
    units = {name: "m" if case.robot.joint[name].type == "prismatic" else "rad" for name, _ in turned}
    return Transforms(tuple(found), units, (*diagnostics, *remarks), case.robot)


def _case(request: Request) -> tuple[Case | None, tuple[Diagnostic, ...]]:
    """Return a robot with its positions in YAML, and its errors if it has some, else warnings about executed code."""
    found = request.understand()
    case = found.case
    if case is None:
        return None, tuple(one for one in found.diagnostics if one.severity == ERROR)
    return case, tuple(one for one in found.diagnostics if one.rule == _EXECUTED and not request.trust)


def frames(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    frame: str | None = None,
    publisher: str | None = None,
    modes: Mapping[str, bool] | None = None,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
) -> Frames:
    """Return the trees of frames of a robot with the publisher of each edge, or write them as drawings.

    Args:
        frame: Return only the path from the root to this frame.
        publisher: Return only the edges of this node; ``"nobody"``: edges without a publisher.
        modes: Modes that are on or off; by default there is a tree for each combination that differs.
        output: A drawing to write: an ``.svg`` file, or a folder for one file per tree.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.frames("rosorin", frame="laser")
        >>> [(edge.parent, edge.child, edge.publisher) for edge in found.situations[0].edges][-1:]
        [('base_link', 'laser', 'tf_base_laser')]
    """
    request = Request.of(robot, arguments, packages, trust=trust)
    case, diagnostics = _case(request)
    if case is None:
        return Frames(request.description.name, diagnostics=diagnostics)
    chosen = check_modes(case.robot, modes or {})
    if output is not None:
        shown = frame_trees(case.robot, chosen)
        found = viewer_frames.draw_frames(case.robot, shown, os.fsdecode(output), force)
    else:
        found = viewer_frames.frames(case.robot, chosen, frame, publisher)
    return replace(found, diagnostics=(*diagnostics, *found.diagnostics))


def graph(
    robot: FilePath | Request, arguments: Values = None, packages: Packages = None, *, trust: bool = False
) -> RobotGraph:
    """Return the ROS 2 nodes that a package of a robot starts, and the topics between them.

    Topics that a node reads and nothing publishes are diagnostics.

    Example:
        >>> import rosorin_compile
        >>> [topic.type for topic in rosorin_compile.graph("rosorin").topics if topic.topic == "/scan"]
        ['sensor_msgs/msg/LaserScan']
    """
    from rosorin_compile.ros.graph import RobotGraph, robot_graph

    compiled = Request.of(robot, arguments, packages, trust=trust).compile()
    errors = tuple(one for one in compiled.diagnostics if one.severity == ERROR)
    return RobotGraph(diagnostics=errors) if compiled.robot is None or errors else robot_graph(compiled.robot)


def pulses(
    robot: FilePath | Request,
    values: Values = None,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    unit: str = "",
    model: FilePath | None = None,
    strict: bool = False,
    trust: bool = False,
) -> Pulses:
    """Convert servo pulses to joint positions and back.

    Args:
        values: Pulses as whole numbers, or positions as texts with a unit (``"30deg"``), by joint.
        pose: A named pose to convert, before ``values``.
        unit: ``"rad"`` or ``"deg"``: numbers in ``values`` are positions in this unit (or metres), not pulses.
        model: A ``robot_model.json`` whose positions are compared with those of the description, pulse by pulse.
        strict: Treat positions beyond a limit as errors.

    Raises:
        NoPulse: A pulse does not exist, or no pulse sets a position.

    Example:
        >>> import rosorin_compile
        >>> (joint,) = rosorin_compile.pulses("rosorin", {"joint1": "30deg"}).joints
        >>> joint.pulse, round(joint.degrees, 2)
        (375, 30.0)
    """
    case, diagnostics = _case(Request.of(robot, arguments, packages, trust=trust))
    if case is None:
        return Pulses(diagnostics=diagnostics)
    servos = queries.calibrations(case.robot)
    if model is not None:
        if not Path(model).is_file():
            raise RequestError(no_file(Path(model)))
        comparison = ModelComparison(str(model), *against_model(case.robot, Path(model).read_bytes()))
        return Pulses(servos, model=comparison, diagnostics=diagnostics, robot=case.robot)
    found = queries.joint_pulses(case.robot, values or {}, pose, unit)
    state = {one.joint: one.position for one in found}
    beyond = queries.beyond_limits(case, [state], ERROR if strict else WARNING)
    posed = next((one.positions for one in case.robot.poses if pose and one.name == pose), {})
    without = tuple(name for name in posed if not any(name in group.joints for group in servos))
    return Pulses(servos, tuple(found), None, without, (*diagnostics, *beyond), case.robot)


def picture(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    joints: Values = None,
    pulses: Values = None,
    view: str = "iso",
    size: tuple[int, int] = (1280, 800),
    collision: bool = False,
    published_frames: bool = False,
    frames: Sequence[str] = (),
    modes: Mapping[str, bool] | None = None,
    theme: str = "light",
    transparent: bool = False,
    force: bool = False,
    trust: bool = False,
) -> Picture:
    """Draw a robot to a PNG file, without a browser. This needs the extra ``view``.

    ``pose``, ``joints`` and ``pulses`` are as in ``transform``, ``modes`` as in ``frames``.

    Args:
        view: The camera: ``"iso"``, ``"front"``, ``"side"``, ``"top"`` or two angles such as ``"30deg,20deg"``.
        size: Width and height in pixels.
        collision: Show collision shapes of all links; by default of links without visuals only.
        published_frames: Show all published frames with their names.
        frames: Further frames to show.
        theme: ``"light"`` or ``"dark"``.
        transparent: Draw only the robot and its shadow, on a transparent background.

    Example:
        >>> drawn = picture("rosorin", "rosorin.png", pose="tuck")  # doctest: +SKIP
        >>> drawn.width, drawn.height  # doctest: +SKIP
        (1280, 800)
    """

    def state(case: Case) -> tuple[Mapping[str, Any], Sequence[Diagnostic]]:
        check_modes(case.robot, modes or {})
        found = queries.positions(case.robot, pose, joints or {}, pulses or {})
        return found, queries.beyond_limits(case, [found], WARNING)

    look = Look(view, size, collision, published_frames, frames, modes or {}, theme, transparent)
    return draw(Request.of(robot, arguments, packages, trust=trust), Path(output), state, look, force)


def view(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    meshes: bool = True,
    max_megabytes: float | None = None,
    trust: bool = False,
) -> Page:
    """Write one HTML page that shows a robot in a browser, without a network or any other file.

    Args:
        meshes: Embed the meshes.
        max_megabytes: The largest size of all embedded meshes; by default 40.

    Example:
        >>> import rosorin_compile, tempfile
        >>> page = rosorin_compile.view("rosorin", tempfile.mkdtemp() + "/rosorin.html")
        >>> page.robot, page.bytes > 100_000
        ('rosorin', True)
    """
    return write_page(Request.of(robot, arguments, packages, trust=trust), Path(output), meshes, max_megabytes)


def init(name: str, template: str = "base", project: FilePath = ".") -> NewRobot:
    """Write a new description from a template, and the schema for editors.

    Args:
        name: The name of the robot: letters, digits and underscores.
        template: ``"base"``, ``"arm"``, ``"mobile_manipulator"`` or ``"sensor_rig"``.
        project: The folder that contains ``descriptions/``.

    Raises:
        OSError: The folder cannot be written.

    Example:
        >>> import rosorin_compile, tempfile
        >>> new = rosorin_compile.init("my_robot", "arm", project=tempfile.mkdtemp())
        >>> new.description.name, new.schema_written
        ('robot.yaml', True)
    """
    from rosorin_compile.importing import new_robot

    if template not in new_robot.TEMPLATES:
        raise UnknownName("template", template, new_robot.TEMPLATES)
    return new_robot.start(name, Path(project), template)


def arguments(robot: FilePath | Request, arguments: Values = None, packages: Packages = None) -> Arguments:
    """List the arguments that a description declares, with the values that ``arguments`` sets.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.arguments("examples/unitree_a1")
        >>> [(one.name, one.allowed, one.default) for one in found.arguments if one.name == "base"]
        [('base', ('fixed', 'free'), 'free')]
    """
    request = Request.of(robot, arguments, packages)
    name, problems = request.description.name, [*request.problems]
    found: list[Argument] = []
    try:
        if not problems:
            found, problems = declared(request.description.path, request.values(), request.packages)
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
    request = Request.of(robot, arguments, packages)
    found, name = request.understand(outputs=True), request.description.name
    return Outputs(name, None if found.robot is None else found.robot.outputs, tuple(found.diagnostics))


def explain_rules(ids: Sequence[str] = ()) -> Rules:
    """Return the meaning of rule ids, of plug-ins, too; without ``ids`` of all rules, sorted by id.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.explain_rules(["axis-zero"]).rules[0].help
        'Name one, such as `[0, 0, 1]`.'
    """
    diagnostics = (*plugged().diagnostics, *plugged_diagnostics())
    known = {**OF_PLUGINS, **find(ids or None)}
    for id in ids:
        if id not in known:
            raise UnknownName("rule", id, {**find(), **OF_PLUGINS})
    return Rules(tuple(known[id] for id in dict.fromkeys(ids or sorted(known))), diagnostics)


def schema(name: str = "authoring", macros: bool = False) -> dict[str, Any]:
    """Return a JSON Schema by its name in ``rosorin-compile schema --list``; by default that for editors.

    Args:
        macros: Add the names and parameters of the macros in xacro files that robots of this project include.

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


def simulate(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    base: str | None = None,
    seconds: float = 2.0,
    limits: Mapping[str, float] | None = None,
    timing: bool = True,
    trust: bool = False,
) -> Simulated:
    """Simulate a robot in MuJoCo: at rest, in its poses, driving, and along the ranges of its joints.

    Each result beyond a limit is among the ``diagnostics``. Without ``poses`` the robot could not be simulated.

    Args:
        base: ``fixed`` to the world, or ``free`` on a floor; by default a robot with a drive is free.
        seconds: How long each pose is held, 0.5 to 600 s.
        limits: Limits by name, as in ``simulate --limit``, in m, rad, m/s and rad/s.
        timing: Measure the speed of the simulation, which differs between runs.

    Example:
        >>> result = simulate("rosorin", limits={"hold": 0.02})  # doctest: +SKIP
        >>> result.poses[0].worst  # doctest: +SKIP
    """
    from rosorin_compile.mujoco.simulate.simulation import simulate_robot

    request = Request.of(robot, arguments, packages, trust=trust)
    return simulate_robot(request, base=base, seconds=seconds, limits=limits, timing=timing)


def check_physics(
    robot: FilePath | Request, arguments: Values = None, packages: Packages = None, *, trust: bool = False
) -> CheckedPhysics:
    """Find links that collide at rest or while joints move, and masses that do not fit the meshes, with MuJoCo.

    Example:
        >>> result = check_physics("rosorin")  # doctest: +SKIP
        >>> result.fine, [one.message for one in result.diagnostics]  # doctest: +SKIP
    """
    from rosorin_compile.mujoco.physics.checking import check_robot

    return check_robot(Request.of(robot, arguments, packages, trust=trust))


def collisions(
    robot: FilePath | Request,
    arguments: Values = None,
    packages: Packages = None,
    *,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
) -> CollisionMatrix:
    """Compute the pairs of links that MoveIt does not need to check, with distances in m, and write them to a file.

    Args:
        output: The file; by default ``collisions.yaml`` next to the description, which includes it.
        force: Compute the pairs again, even if the file is up to date.

    Example:
        >>> result = collisions("rosorin", output="collisions.yaml")  # doctest: +SKIP
        >>> [pair.links for pair in result.pairs if pair.reason == "Never"]  # doctest: +SKIP
    """
    from rosorin_compile.mujoco.collisions.matrix import compute_matrix
    from rosorin_compile.ros.srdf.planning import planning_of

    request = Request.of(robot, arguments, packages, trust=trust)
    return compute_matrix(request, planning_of, output=_path(output), force=force)


def _path(path: FilePath | None) -> Path | None:
    return None if path is None else Path(path)


def verify(
    robot: FilePath | Request,
    source: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    modes: Mapping[str, bool] | None = None,
    without: Sequence[str] = (),
    pose: str = "",
    frames: tuple[str, str] | None = None,
    since: float | None = None,
    until: float | None = None,
    stale: float = 1.0,
    namespace: str = "",
    prefix: str = "",
    trust: bool = False,
) -> Verified:
    """Compare a recording of the running robot with its description; ``findings`` are what is not as described.

    Args:
        source: A rosbag2 folder, a .mcap or .db3 file, a file with the output of ``tf2_echo`` or ``view_frames``, or
            ``-`` for such text on standard input.
        modes: Modes that were on or off; the others are detected.
        without: Nodes that were not running.
        pose: The named pose of the joints while ``tf2_echo`` ran.
        frames: The source and the target frame of the output of ``tf2_echo``.
        since: Start this many seconds after the start of the recording.
        until: Stop this many seconds after the start of the recording.
        stale: The maximum age of a transform in s.
        namespace: The namespace of the topics, such as ``robot1``.
        prefix: The prefix of the recorded frames, such as ``robot1/``.

    Example:
        >>> result = verify("rosorin", "recordings/drive")  # doctest: +SKIP
        >>> result.as_described, [finding.message for finding in result.findings]  # doctest: +SKIP
    """
    try:
        from rosorin_compile.recordings.expected import Options
        from rosorin_compile.recordings.verification import verify_recording
    except ModuleNotFoundError as problem:
        if problem.name != "numpy":
            raise
        needs = "rosorin-compile verify needs numpy, and rosbags for recordings"
        raise MissingPackages(f"{needs}: {pip_install('verify')}") from None
    options = Options(modes or {}, frozenset(without), None, frames, since, until, namespace, prefix, stale)
    return verify_recording(Request.of(robot, arguments, packages, trust=trust), os.fsdecode(source), options, pose)


def sweep(
    robot: FilePath | Request,
    variants: FilePath | Mapping[str, Any] | Iterable[Any],
    arguments: Values = None,
    packages: Packages = None,
    client: Client | None = None,
    *,
    trust: bool = False,
) -> Iterator[Compiled]:
    """Compile a description with the arguments of each variant; nothing is written.

    Args:
        variants: A CSV or YAML file or a folder as in ``sweep --over``, arguments by name, or an iterable of pairs of a
            name and arguments or of tables with ``name`` among the arguments.
        arguments: Arguments of all variants, which those of a variant override.
        client: A ``distributed.Client`` on whose cluster the variants are compiled.

    Yields:
        A ``Compiled`` for each variant, in order; errors in the list itself are one ``Compiled`` without a variant.

    Raises:
        OutputError: The cluster fails.

    Example:
        >>> import rosorin_compile
        >>> variants = {"low": {"base": "fixed"}, "wrong": {"base": "tall"}}
        >>> for compiled in rosorin_compile.sweep("examples/unitree_a1", variants):
        ...     print(compiled.variant.name, compiled.robot)
        low <Robot unitree_a1: 23 links, 22 joints (12 that move), 5 sensors>
        wrong None
    """
    from rosorin_compile.variants.library import compile_variants

    request = Request.of(robot, arguments, packages, trust=trust)
    if request.problems:
        yield request.compile()
    else:
        yield from compile_variants(request, variants, client)


def write_sweep(
    robot: FilePath | Request,
    variants: FilePath,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    jobs: int | None = None,
    whole: str = "",
    dask: str = "",
    prune: bool = False,
    report: Warn = None,
    trust: bool = False,
) -> WrittenVariants:
    r"""Compile a description with the arguments of each variant, and write each variant to a separate folder.

    The result has the number of variants by their status. Variants that are up to date are not compiled again.

    Args:
        variants: A CSV or YAML file, or a folder with a file of arguments for each variant.
        folder: The folder that gets a folder for each variant, and ``sweep.json``.
        arguments: Arguments of all variants, which those of a variant override.
        jobs: The number of processes; by default one per core.
        whole: The argument that takes each file of the folder ``variants``.
        dask: The address of a Dask scheduler.
        prune: Remove variants that are not in the list any more.
        report: Receives each diagnostic as soon as it is known.

    Example:
        >>> import rosorin_compile, tempfile
        >>> with open(tempfile.mkdtemp() + "/variants.csv", "w") as file:
        ...     _ = file.write("name,base\nlow,fixed\n")
        >>> result = rosorin_compile.write_sweep("examples/unitree_a1", file.name, tempfile.mkdtemp(), jobs=1)
        >>> result.made, result.error, result.complete
        (1, 0, True)
    """
    from rosorin_compile.variants.writing import WrittenVariants, write_variants

    request = Request.of(robot, arguments, packages, trust=trust)
    if request.problems:
        return WrittenVariants(str(robot), os.fsdecode(folder), diagnostics=request.problems)
    over, output = Path(os.fsdecode(variants)), Path(os.fsdecode(folder))
    return write_variants(request, over, output, jobs=jobs, whole=whole, dask=dask, prune=prune, report=report)


def import_robot(
    source: FilePath,
    into: FilePath | None = None,
    arguments: Values = None,
    packages: Packages = None,
    *,
    output: FilePath | None = None,
    name: str | None = None,
    meshes: str | None = None,
    companions: Mapping[str, FilePath] | None = None,
    strict: bool = False,
    lenient: bool = False,
    parts: bool = True,
    verbatim: bool = False,
    flat: bool = False,
    drives: str | None = None,
    force: bool = False,
    keep_edits: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ImportResult:
    """Convert a URDF, xacro, SDF or MJCF file to a description, and write it unless an error is found.

    The description is compiled and compared with the source before it is written. If the folder has the description of
    an earlier import of the same source, the changes of both are merged. Nothing was written if ``diagnostics`` of the
    result has errors and ``written`` is empty.

    Args:
        source: The file of the robot.
        into: The folder of the ROS package that contains ``source``. The description is written to its
            ``descriptions/``, with a test that compares both.
        output: The folder of the description without ``into``; by default ``descriptions/ROBOT``.
        name: The name of the robot; by default that of ``source``.
        meshes: The prefix of relative mesh names: a folder relative to the artifacts, or ``package://NAME``.
        companions: Files that add to the robot, by format: ``{"srdf": "robot.srdf"}``.
        strict: Treat unsupported elements as errors.
        lenient: Accept violations of the specification where possible.
        parts: Factor repeated structures into parts.
        verbatim: Copy the Gazebo and ros2_control elements of a URDF unchanged.
        flat: Import the URDF that a xacro generates, without its macros.
        drives: Servos that the MJCF gets for a robot without actuators: ``"position"`` (for joints with limits; the
            others get velocity servos), ``"velocity"`` or ``"none"``; by default ``"position"``.
        force: Write to a folder that is not empty.
        keep_edits: If both the source and the description changed the same lines, keep those of the description.

    Example:
        >>> result = import_robot("robot.urdf")  # doctest: +SKIP
        >>> result.folder  # doctest: +SKIP
        'descriptions/robot'
    """
    from rosorin_compile.importing import import_robot as importing

    reading, wrong = _read_options(arguments, packages, trust, warn)
    if wrong:
        return importing.ImportResult(str(source), diagnostics=tuple(wrong))
    options = importing.ImportOptions(
        into=_path(into),
        arguments=dict(reading.arguments),
        packages=dict(reading.packages),
        output=_path(output),
        name=name,
        meshes=meshes,
        companions={format: Path(file) for format, file in (companions or {}).items()},
        strict=strict,
        lenient=lenient,
        parts=parts,
        verbatim=verbatim,
        flat=flat,
        drives=drives,
        force=force,
        ours=keep_edits,
        trust=trust,
        warn=warn,
    )
    return importing.import_robot(source if isinstance(source, Path) else Path(source), options)


def _read_options(
    arguments: Values, packages: Packages, trust: bool, warn: Warn, lenient: bool = False
) -> tuple[ReadOptions, list[Diagnostic]]:
    """Return how a robot in another format is read, and the errors in the arguments and packages."""
    found = of_api("", arguments, packages)
    texts, wrong = as_texts(found.arguments)
    return ReadOptions(texts, found.packages, lenient, tell=warn, trust=trust), [*found.diagnostics, *wrong]


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

    Example:
        >>> result = extract_boxes(["gripper.stl"], shape="capsule")  # doctest: +SKIP
        >>> result.parts["gripper"]["smallest"]  # doctest: +SKIP
        'capsule'
    """
    from rosorin_compile.importing.extract import extract as extracting
    from rosorin_compile.importing.extract.sources import MeshSource

    reading, wrong = _read_options(arguments, packages, trust, warn)
    if wrong:
        return extracting.ExtractedBoxes(diagnostics=tuple(wrong))
    x, y, z = scale
    source = MeshSource(sources, reading, links, section, (x, y, z))
    return extracting.extract_boxes(source, shape, stack, axis, digits, _path(output), force)


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
        bottom: Also compute the lowest point in each cell.
        into: A file of a description whose height map is replaced, on the same grid.
        status: The status of the source in the description: calculated, measured or factory.
        note: The note of the source in the description; by default the names of the meshes.

    Example:
        >>> result = extract_height_map(["chassis.stl"], cell=0.02)  # doctest: +SKIP
        >>> result.height_map.cell  # doctest: +SKIP
        0.02
    """
    from rosorin_compile.importing.extract import extract as extracting
    from rosorin_compile.importing.extract.sources import MeshSource

    reading, wrong = _read_options(arguments, packages, trust, warn)
    if wrong:
        return extracting.ExtractedHeightMap(diagnostics=tuple(wrong))
    (x, y, z), (roll, pitch, yaw) = xyz, rpy
    pose = Pose((x, y, z), (roll, pitch, yaw))
    x, y, z = scale
    source = MeshSource(sources, reading, [link] if link is not None else (), section, (x, y, z))
    grid = extracting.GridOptions(cell, origin, cells, size, below, map_digits, step, bottom)
    paths = _path(into), _path(output)
    return extracting.extract_height_map(source, grid, frame, pose, paths[0], status, note, paths[1], force)


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

    Example:
        >>> extract_factory("nano_description", "factory").joints  # doctest: +SKIP
        ('wheel_left_joint', 'wheel_right_joint')
    """
    from rosorin_compile.importing.extract import extract as extracting

    reading, wrong = _read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return extracting.ExtractedFactory(diagnostics=tuple(wrong))
    grid = extracting.GridOptions(cell, origin, cells, size, below, map_digits, step)
    folder, target = Path(package), Path(output)
    return extracting.extract_factory(folder, target, reading, grid, robot, height_map_link, frame, section)


def package(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    name: str | None = None,
    build_type: str | None = None,
    version: str | None = None,
    maintainer: str | None = None,
    license: str | None = None,  # noqa: A002 - as in package.xml
    url: str | None = None,
    topics: Mapping[str, str] | None = None,
    compile_at_launch: bool | None = None,
    control: bool | None = None,
    moveit: bool | None = None,
    nav2: bool | None = None,
    trust: bool = False,
) -> WrittenPackage:
    """Write a ROS 2 package with the artifacts of a robot, unless an error is found.

    A package that this function wrote before keeps the options that are None. With an error ``package`` of the result
    is empty.

    Args:
        folder: The folder of the package.
        name: The name of the package; by default ``ROBOT_description``.
        build_type: ``"ament_cmake"``, the default, or ``"ament_python"``.
        version: The version, three numbers; by default ``"0.1.0"``.
        maintainer: The maintainer, as ``"Name <mail@example.org>"``.
        license: The license as an SPDX name.
        url: The website of the package.
        topics: Topics by sensor, for the RViz configuration.
        compile_at_launch: Compile the description at launch, with its arguments as launch arguments.
        control: Add a launch file that starts the controller_manager and the controllers.
        moveit: Add a launch file that starts MoveIt.
        nav2: Add a launch file that starts Nav2 and robot_localization.

    Example:
        >>> package("rosorin", "rosorin_description", license="MIT").package  # doctest: +SKIP
        'rosorin_description'
    """
    from rosorin_compile.ros.package.package import write_package

    request = Request.of(robot, arguments, packages, trust=trust)
    options: dict[str, Any] = {"name": name, "build_type": build_type, "version": version, "maintainer": maintainer}
    options |= {"license": license, "url": url, "at_launch": compile_at_launch}
    starts = {"control": control, "moveit": moveit, "nav2": nav2}
    return write_package(request, Path(folder), options, starts, topics or {})


def deploy(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    places: Mapping[str, str] | None = None,
    dry_run: bool = False,
    full: bool = False,
    trust: bool = False,
) -> Deployed:
    """Write the artifacts of a robot into a ROS 2 package or another folder that exists.

    The result has the copies with their paths, and the changes as text; with an error its ``robot`` is empty.

    Args:
        places: The paths of outputs in the folder, or ``"none"``; they are stored there.
        dry_run: Write nothing.
        full: List differences of texts in full in ``changes``.

    Example:
        >>> result = deploy("rosorin", "ros_ws/src/rosorin_base", dry_run=True)  # doctest: +SKIP
        >>> [copy.file for copy in result.copies if not copy.same]  # doctest: +SKIP
        ['urdf/rosorin.urdf']
    """
    from rosorin_compile.ros.package.deploy import deploy as write_copies

    request = Request.of(robot, arguments, packages, trust=trust)
    return write_copies(request, Path(folder), places or {}, dry_run, full)


def check_deployed(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    full: bool = False,
    trust: bool = False,
) -> CheckedCopies:
    """Compare the artifacts of a robot with the copies in a package, an install space or another folder.

    Args:
        full: List differences of texts in full in ``lines``.

    Example:
        >>> check_deployed("rosorin", "ros_ws/src/rosorin_base").differing  # doctest: +SKIP
        ()
    """
    from rosorin_compile.ros.package.deploy import check_deployed as check_copies

    return check_copies(Request.of(robot, arguments, packages, trust=trust), Path(folder), full)


def check_parameters(
    robot: FilePath | Request,
    files: Sequence[FilePath],
    arguments: Values = None,
    packages: Packages = None,
    *,
    controllers: Sequence[FilePath] = (),
    launch: Sequence[FilePath] = (),
    remaps: Sequence[str] = (),
    namespace: str = "",
    distribution: str | None = None,
    trust: bool = False,
) -> CheckedParameters:
    """Check parameter files of ROS nodes against a robot: frames, publishers, controllers and odometry topics.

    Args:
        files: The parameter files.
        controllers: Parameter files of a controller_manager.
        launch: Launch files to read remappings from.
        remaps: Further remappings, as ``"NODE:FROM:=TO"``.
        namespace: The namespace of the nodes.
        distribution: The ROS 2 distribution; by default that of the outputs of the robot, if they agree.

    Example:
        >>> result = check_parameters("rosorin", ["ekf.yaml"])  # doctest: +SKIP
        >>> [one.rule for one in result.diagnostics]  # doctest: +SKIP
        ['parameters-frame']
    """
    from rosorin_compile.ros.check_parameters import checking

    nodes, managers, launches = ([Path(file) for file in paths] for paths in (files, controllers, launch))
    selected = checking.ParameterFiles(nodes, managers, launches, remaps, namespace, distribution or "")
    return checking.check_parameters(Request.of(robot, arguments, packages, trust=trust), selected)

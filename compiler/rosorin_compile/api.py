"""The Python API: one function for each command, which returns a frozen dataclass and never prints.

What is wrong with the files of a robot is among the ``diagnostics`` of the result; a wrong argument of a function is a
``RequestError``. In all functions, ``robot`` is a path or a name in ``descriptions/``; the command line passes a
``Request``. ``arguments`` sets arguments of the description, ``packages`` are folders of ROS packages by name, and
``trust`` runs the Python code of a xacro without a warning.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import DEFAULT_TOLERANCE, Difference
from rosorin_compile.formats import plugged_diagnostics
from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.formats.mesh_files import opened_by
from rosorin_compile.formats.schemas import schema_names, schema_text
from rosorin_compile.language import arguments as declarations
from rosorin_compile.language import asked
from rosorin_compile.language.explain.answer import explain as explain_names
from rosorin_compile.model import Pose, Robot
from rosorin_compile.model.servos import against_model
from rosorin_compile.output import OutputError, diff_inputs, new_robot, pipeline, write_artifacts
from rosorin_compile.output.check_outputs import compare_committed
from rosorin_compile.output.pipeline import Compiled, Reading
from rosorin_compile.output.request import Request
from rosorin_compile.rules import conditions, joint_states
from rosorin_compile.rules import pulses as servo_pulses
from rosorin_compile.rules import transform as frame_transforms
from rosorin_compile.rules.check import plugged
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    MissingPackages,
    RequestError,
    UnknownName,
    did_you_mean,
    has_errors,
)
from rosorin_compile.source.installing import pip_install
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.project import no_file
from rosorin_compile.source.rule_registry import OF_PLUGINS, WRITING, Rule, every_rule, find
from rosorin_compile.viewer import frames as frame_trees
from rosorin_compile.viewer.frames import Frames
from rosorin_compile.viewer.page.write import Page, write_page
from rosorin_compile.viewer.picture.draw import Look, Picture, draw

from .results import (
    Arguments,
    Checked,
    Explained,
    ModelComparison,
    NewRobot,
    Outputs,
    Pulses,
    Rules,
    Transforms,
    Written,
)

if TYPE_CHECKING:
    from distributed import Client

    from rosorin_compile.importing.extract.extract import ExtractedBoxes, ExtractedFactory, ExtractedHeightMap
    from rosorin_compile.importing.import_robot import ImportResult
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.recordings.answers import Verified
    from rosorin_compile.ros.check_parameters.checking import CheckedParameters
    from rosorin_compile.ros.package.checking import CheckedCopies
    from rosorin_compile.ros.package.deploy import Deployed
    from rosorin_compile.ros.package.write import WrittenPackage
    from rosorin_compile.rules.case import Case
    from rosorin_compile.variants.writing import WrittenVariants

FilePath = str | os.PathLike[str]
Packages = Mapping[str, FilePath]

RULES = (
    Rule(
        "not-an-artifact",
        "A note: a file in the outputs folder is no artifact; it is kept.",
        "`rosorin-compile all --prune` removes it.",
        WRITING,
    ),
)


def compile(  # noqa: A001 - re.compile has this name, too
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    outputs: Sequence[str] = (),
    meshes: bool = False,
    trust: bool = False,
) -> Compiled:
    """Compile a description to its artifacts; nothing is written.

    Args:
        robot: The main file of the description, its folder, or its name in ``descriptions/``.
        arguments: Texts as in ``-a NAME=TEXT``, or values: numbers in SI units, truth values, None, lists and tables.
        packages: Folders of ROS packages by name.
        outputs: The names of the only outputs to generate.
        meshes: Search the mesh files, and read the artifacts back, as ``rosorin-compile all`` does.
        trust: Run the Python code of an included xacro without a warning.

    Returns:
        The model and the artifacts; ``robot`` is None with errors in ``diagnostics``.

    Example:
        >>> import rosorin_compile
        >>> compiled = rosorin_compile.compile("descriptions/rosorin")
        >>> compiled.robot
        <Robot rosorin: 60 links, 59 joints (51 that move), 3 sensors>
        >>> [artifact.file for artifact in compiled.artifacts][:4]
        ['controllers.yaml', 'frames.md', 'frames_amcl.svg', 'frames_slam.svg']

    """
    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return Compiled(None, (), wrong, ())
    compiled = request.compile(outputs, meshes=meshes)
    path = request.description.path
    if compiled.robot is None and not asked.is_description(path):
        message = f"{path.name} is not called as a description is, such as robot.yaml"
        note = Diagnostic("wrong-format", NOTE, message, None, (), "rosorin_compile.read takes robots in other formats")
        compiled.diagnostics.append(note)
    return compiled


def read(
    robot: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    lenient: bool = False,
    trust: bool = False,
) -> Reading:
    """Read a robot in any supported format: URDF, xacro, SDF, MJCF, ``robot_model`` JSON, or a description.

    Args:
        robot: A file, or a description as ``compile`` accepts it.
        arguments: The arguments of a description or a xacro.
        packages: Folders of ROS packages by name.
        lenient: Accept violations of the specification of a format where possible.
        trust: Run the Python code of a xacro without a warning in ``diagnostics``.

    Returns:
        The robot, or None with errors in ``diagnostics``.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.read("outputs/rosorin/rosorin.urdf").robot
        <Robot rosorin: 11 links, 10 joints (5 that move), 0 sensors>

    """
    return pipeline.read(robot, arguments, packages, lenient, trust)


def check(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    outputs: FilePath | None = None,
    trust: bool = False,
) -> Checked:
    """Compile a description and compare the result with its committed artifacts.

    Args:
        robot: As in ``compile``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        outputs: The folder that contains a folder for each robot; by default that of the project.
        trust: As in ``compile``.

    Example:
        >>> import rosorin_compile
        >>> checked = rosorin_compile.check("rosorin")
        >>> checked.same, checked.differing
        (True, ())

    """
    request, wrong = Request.of(robot, arguments, packages, outputs, trust)
    if request is None:
        return Checked(Compiled(None, (), wrong, ()), Path(), diagnostics=tuple(wrong))
    compiled, folder = request.compile(), request.description.outputs
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return Checked(compiled, folder, diagnostics=tuple(compiled.diagnostics))
    committed = compare_committed(request, compiled)
    diagnostics = (*compiled.diagnostics, *committed.diagnostics)
    return Checked(compiled, folder, committed.differing(), tuple(committed.lines()), diagnostics, committed)


def write(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    outputs: FilePath | None = None,
    prune: bool = False,
    *,
    only: Sequence[str] = (),
    trust: bool = False,
) -> Written:
    """Compile a description and write its artifacts, all of them or none.

    Args:
        robot: As in ``compile``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        outputs: As in ``check``.
        prune: Delete files in the robot's folder that are not artifacts.
        only: The names of the only outputs to write.
        trust: As in ``compile``.

    Example:
        >>> import rosorin_compile, tempfile
        >>> written = rosorin_compile.write("rosorin", outputs=tempfile.mkdtemp())
        >>> len(written.written), written.unchanged, written.kept
        (16, (), ())

    """
    request, wrong = Request.of(robot, arguments, packages, outputs, trust)
    if request is None:
        return Written(Compiled(None, (), wrong, ()), Path(), diagnostics=tuple(wrong))
    compiled, folder = request.compile(only), request.description.outputs
    said = compiled.diagnostics
    if not compiled.artifacts or has_errors(said):
        return Written(compiled, folder, diagnostics=tuple(said))
    meshes = _belonging(compiled) if only else compiled.mesh_files
    files: dict[str, str | bytes] = {**meshes, **{artifact.file: artifact.text for artifact in compiled.artifacts}}
    try:
        done = write_artifacts(folder, files, prune, complete=not only)
    except OutputError as problem:
        return Written(compiled, folder, diagnostics=(*said, problem.diagnostic))
    more = done.diagnostics(folder)
    for name in () if only else done.kept:
        message = f"{folder}/{name} is no artifact of this robot; it is kept"
        more.append(Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it"))
    return Written(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*said, *more))


def _belonging(compiled: Compiled) -> dict[str, bytes]:
    """Return the mesh files that belong to the artifacts of a robot of which not all outputs were generated."""
    robot, searched = compiled.robot, compiled.meshes
    if robot is None or searched is None:
        return {}
    made = {artifact.output for artifact in compiled.artifacts}
    outputs = [output for output in robot.outputs if output.name in made]
    names = {opened_by(output, found.named.name) for found in searched.found for output in outputs}
    return {name: data for name, data in searched.files.items() if name in names}


def diff(
    a: FilePath | Robot,
    b: FilePath | Robot,
    tolerance: float = DEFAULT_TOLERANCE,
    prefix: str | None = None,
    *,
    arguments: Mapping[str, Any] | None = None,
    a_arguments: Mapping[str, Any] | None = None,
    b_arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    trust: bool = False,
) -> Difference:
    """Compare two robots by meaning: descriptions, files in any supported format, or ``Robot`` objects.

    A ``Robot`` counts as a description, which can express every value: pass the path of a file in another format.

    Args:
        a: The first robot.
        b: The second robot.
        tolerance: The largest difference to ignore, in metres, radians or relative to the number.
        prefix: The prefix of all names in ``b``; by default it is detected.
        arguments: Arguments of both robots.
        a_arguments: Arguments of ``a`` only.
        b_arguments: Arguments of ``b`` only.
        packages: Folders of ROS packages by name.
        trust: Run the Python code of a xacro without a warning in ``diagnostics``.

    Returns:
        The differences; without ``a`` and ``b`` there are errors in ``diagnostics``. ``str`` of it is the text of
        ``rosorin-compile diff``.

    Example:
        >>> import rosorin_compile
        >>> difference = rosorin_compile.diff("rosorin", "outputs/rosorin/rosorin.urdf")
        >>> difference.same, difference.items
        (True, ())
        >>> rosorin_compile.diff("rosorin", "nothing.urdf").diagnostics[0].message
        'there is no file "nothing.urdf"'

    """
    wrong = diff_inputs.wrong_options(tolerance, prefix)
    sides = ((a, (arguments, a_arguments)), (b, (arguments, b_arguments)))
    first, second = (diff_inputs.side_of(robot, given, packages, trust) for robot, given in sides)
    diagnostics = [*wrong, *first.diagnostics, *second.diagnostics]
    if first.side is None or second.side is None or has_errors(diagnostics):
        return Difference(None, None, (), (), (), tolerance, tuple(dict.fromkeys(diagnostics)))
    try:
        difference = compare_robots(first.side, second.side, tolerance, prefix)
    except PluginFailed as problem:
        return Difference(None, None, (), (), (), tolerance, (*diagnostics, problem.diagnostic))
    left = [line for one in (first, second) if one.side for line in one.lines(one.side.label, each=True)]
    return replace(difference, not_compared=(*difference.not_compared, *left), diagnostics=tuple(diagnostics))


def explain(
    robot: FilePath | Request,
    names: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    pose: str = "",
) -> Explained:
    """Return the poses of frames, links, joints, sensors or parts, and the line of YAML behind each number.

    Args:
        robot: As in ``compile``.
        names: Names of things, and of the only numbers of them to explain, such as ``z`` or ``mass``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        pose: The named pose in which frames are shown, too.

    Raises:
        UnknownName: The robot has nothing of a name; the message has a suggestion.

    Example:
        >>> import rosorin_compile
        >>> explained = rosorin_compile.explain("rosorin", ["laser", "z"])
        >>> number = explained.answers[0].numbers[0]
        >>> number.name, number.value, number.unit, number.origin.where.file, number.origin.where.line
        ('z', 0.106748, 'm', 'descriptions/rosorin/lidar_and_imu.yaml', 25)

    """
    request, wrong = Request.of(robot, arguments, packages)
    if request is None:
        return Explained(diagnostics=tuple(wrong))
    found = request.understand(foreign=False)
    if found.lowered is None or found.lowered.robot is None or has_errors(found.diagnostics):
        return Explained(diagnostics=tuple(found.diagnostics))
    answers = explain_names(found.expanded, found.lowered, request.values(), names, pose)
    return Explained(tuple(answers), tuple(found.diagnostics))


def transform(
    robot: FilePath | Request,
    source: str,
    target: str,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    pose: str = "",
    joints: Mapping[str, Any] | None = None,
    pulses: Mapping[str, Any] | None = None,
    sweeps: Mapping[str, str] | None = None,
    modes: Mapping[str, bool] | None = None,
    strict: bool = False,
    trust: bool = False,
) -> Transforms:
    """Return the pose of a frame in another, with the numbers that ``tf2_echo`` prints.

    Args:
        robot: A robot in any supported format.
        source: The frame in which the pose is expressed.
        target: The frame whose pose is returned.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        pose: A named pose of the description; joints that nothing sets are at zero.
        joints: Positions by joint: numbers in rad or m, or texts such as ``"30deg"``. They override all others.
        pulses: Pulses of servos by joint; they override ``pose``.
        sweeps: Positions to use in turn by joint, ``"FROM:TO:COUNT"``; of several, all combinations.
        modes: Modes of the robot that are on or off; if any is set, all others are off.
        strict: Treat positions beyond a limit as errors.
        trust: As in ``compile``.

    Raises:
        RequestError: The robot has no such frame, joint, pose or mode, or a value is invalid.

    Example:
        >>> import rosorin_compile
        >>> (found,) = rosorin_compile.transform("rosorin", "base_link", "laser").transforms
        >>> found.translation
        (0.048156, 7.5552e-05, 0.106748)

    """
    case, diagnostics, request = _case(robot, arguments, packages, trust)
    if case is None or request is None:
        return Transforms(diagnostics=diagnostics)
    start = joint_states.positions(case.robot, pose, joints or {}, pulses or {})
    turned = [joint_states.sweep_of(case.robot, f"{name}={text}") for name, text in (sweeps or {}).items()]
    states = list(joint_states.states(start, turned))
    beyond = _beyond(case, states, strict)
    if has_errors(beyond):
        return Transforms(diagnostics=(*diagnostics, *beyond), robot=case.robot)
    conditions.check_modes(case.robot, modes or {})
    found, remarks = frame_transforms.transforms(case, source, target, states, modes or {})
    units = {one.joint: "m" if case.robot.joint[one.joint].type == "prismatic" else "rad" for one in turned}
    return Transforms(tuple(found), units, (*diagnostics, *beyond, *remarks), case.robot)


def frames(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
        robot: A robot in any supported format.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        frame: Return only the path from the root to this frame.
        publisher: Return only the edges of this node; ``"nobody"``: edges without a publisher.
        modes: Modes that are on or off; by default there is a tree for each combination that differs.
        output: A drawing to write: ``.svg``, ``.dot``, ``.gv``, ``.mmd`` or ``.md``, or a folder for one SVG per tree.
        force: Replace a file that this tool did not write.
        trust: As in ``compile``.

    Raises:
        RequestError: The robot has no such frame, publisher or mode, or the drawing cannot be written.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.frames("rosorin", frame="laser")
        >>> [(edge.parent, edge.child, edge.publisher) for edge in found.situations[0].edges][-1:]
        [('base_link', 'laser', 'tf_base_laser')]

    """
    case, diagnostics, request = _case(robot, arguments, packages, trust)
    if case is None or request is None:
        return Frames("" if request is None else request.description.name, diagnostics=diagnostics)
    chosen = conditions.check_modes(case.robot, modes or {})
    if output is not None:
        shown = frame_trees.trees(case.robot, chosen)
        found = frame_trees.draw_frames(case.robot, shown, os.fsdecode(output), force)
    else:
        found = frame_trees.frames(case.robot, chosen, frame, publisher)
    return replace(found, diagnostics=(*diagnostics, *found.diagnostics))


def pulses(
    robot: FilePath | Request,
    values: Mapping[str, Any] | None = None,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    pose: str = "",
    unit: str = "",
    model: FilePath | None = None,
    strict: bool = False,
    trust: bool = False,
) -> Pulses:
    """Convert servo pulses to joint positions and back.

    Args:
        robot: A robot in any supported format.
        values: Pulses as whole numbers, or positions as texts with a unit (``"30deg"``), by joint.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        pose: A named pose to convert, before ``values``.
        unit: ``"rad"`` or ``"deg"``: numbers in ``values`` are positions in this unit (or metres), not pulses.
        model: A ``robot_model.json`` whose positions are compared with those of the description, pulse by pulse.
        strict: Treat positions beyond a limit as errors.
        trust: As in ``compile``.

    Raises:
        RequestError: The robot has no servos, no such joint or no such pose, or a value is invalid.
        NoPulse: A pulse does not exist, or no pulse sets a position.

    Example:
        >>> import rosorin_compile
        >>> (joint,) = rosorin_compile.pulses("rosorin", {"joint1": "30deg"}).joints
        >>> joint.pulse, round(joint.degrees, 2)
        (375, 30.0)

    """
    case, diagnostics, request = _case(robot, arguments, packages, trust)
    if case is None or request is None:
        return Pulses(diagnostics=diagnostics)
    groups = servo_pulses.servos(case.robot)
    servos = tuple(map(servo_pulses.summary, groups))
    if model is not None:
        if not Path(model).is_file():
            raise RequestError(no_file(Path(model)))
        compared = against_model(case.robot, Path(model).read_bytes())
        comparison = ModelComparison(str(model), compared.joints, compared.pulses, compared.differences)
        return Pulses(servos, model=comparison, diagnostics=diagnostics, robot=case.robot)
    found = servo_pulses.joint_pulses(case.robot, values or {}, pose, unit)
    beyond = _beyond(case, [{one.joint: one.position for one in found}], strict)
    served = {name for group in groups for name in group.joints}
    posed = next((one.positions for one in case.robot.poses if pose and one.name == pose), {})
    without = tuple(name for name in posed if name not in served)
    return Pulses(servos, tuple(found), None, without, (*diagnostics, *beyond), case.robot)


def picture(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    pose: str = "",
    joints: Mapping[str, Any] | None = None,
    pulses: Mapping[str, Any] | None = None,
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

    Args:
        robot: A robot in any supported format.
        output: The file to write, which ends in ``.png``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        pose: As in ``transform``.
        joints: As in ``transform``.
        pulses: As in ``transform``.
        view: The camera: ``"iso"``, ``"front"``, ``"side"``, ``"top"`` or two angles such as ``"30deg,20deg"``.
        size: Width and height in pixels.
        collision: Show collision shapes of all links; by default of links without visuals only.
        published_frames: Show all published frames with their names.
        frames: Further frames to show.
        modes: As in ``frames``.
        theme: ``"light"`` or ``"dark"``.
        transparent: Draw only the robot and its shadow, on a transparent background.
        force: Replace a file that this tool did not write.
        trust: As in ``compile``.

    Raises:
        RequestError: An argument is invalid, or the file must not be replaced.

    Example:
        >>> import rosorin_compile
        >>> drawn = rosorin_compile.picture("rosorin", "rosorin.png", pose="tuck")  # doctest: +SKIP
        >>> drawn.width, drawn.height  # doctest: +SKIP
        (1280, 800)

    """
    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return Picture("", Path(output), *size, diagnostics=tuple(wrong))

    def state(case: Case) -> tuple[Mapping[str, Any], Sequence[Diagnostic]]:
        conditions.check_modes(case.robot, modes or {})
        found = joint_states.positions(case.robot, pose, joints or {}, pulses or {})
        return found, _beyond(case, [found])

    look = Look(view, size, collision, published_frames, frames, modes or {}, theme, transparent)
    return draw(request, Path(output), state, look, force)


def view(
    robot: FilePath | Request,
    output: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    meshes: bool = True,
    max_megabytes: float | None = None,
    trust: bool = False,
) -> Page:
    """Write one HTML page that shows a robot in a browser, without a network or any other file.

    Args:
        robot: A robot in any supported format.
        output: The file to write.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        meshes: Embed the meshes.
        max_megabytes: The largest size of all embedded meshes; by default 40.
        trust: As in ``compile``.

    Example:
        >>> import rosorin_compile, tempfile
        >>> page = rosorin_compile.view("rosorin", tempfile.mkdtemp() + "/rosorin.html")
        >>> page.robot, page.bytes > 100_000
        ('rosorin', True)

    """
    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return Page("", Path(output), diagnostics=tuple(wrong))
    return write_page(request, Path(output), meshes, max_megabytes)


def init(name: str, template: str = new_robot.DEFAULT, project: FilePath = ".") -> NewRobot:
    """Write a new description from a template, and the schema for editors.

    Args:
        name: The name of the robot: letters, digits and underscores.
        template: ``"base"``, ``"arm"``, ``"mobile_manipulator"`` or ``"sensor_rig"``.
        project: The folder that contains ``descriptions/``.

    Raises:
        RequestError: The name is invalid or in use, or the template does not exist.
        OSError: The folder cannot be written.

    Example:
        >>> import rosorin_compile, tempfile
        >>> new = rosorin_compile.init("my_robot", "arm", project=tempfile.mkdtemp())
        >>> new.description.name, new.schema_written
        ('robot.yaml', True)

    """
    if template not in new_robot.TEMPLATES:
        raise UnknownName(f'there is no template "{template}"; take one of {", ".join(new_robot.TEMPLATES)}')
    return new_robot.start(name, Path(project), template)


def arguments(
    robot: FilePath | Request, arguments: Mapping[str, Any] | None = None, packages: Packages | None = None
) -> Arguments:
    """List the arguments that a description declares, with the values that ``arguments`` sets.

    Example:
        >>> import rosorin_compile
        >>> found = rosorin_compile.arguments("examples/unitree_a1")
        >>> [(one.name, one.allowed, one.default) for one in found.arguments if one.name == "base"]
        [('base', ('fixed', 'free'), 'free')]

    """
    request, wrong = Request.of(robot, arguments, packages)
    if request is None:
        return Arguments("", diagnostics=tuple(wrong))
    description = request.description
    try:
        found, wrong = declarations.declared(description.path, request.values(), request.packages)
    except LoadError as problem:
        found, wrong = [], [problem.diagnostic]
    return Arguments(description.name, tuple(found), tuple(wrong))


def outputs(
    robot: FilePath | Request, arguments: Mapping[str, Any] | None = None, packages: Packages | None = None
) -> Outputs:
    """List the outputs of a robot in any supported format.

    Example:
        >>> import rosorin_compile
        >>> [output.file for output in rosorin_compile.outputs("rosorin").outputs][:2]
        ['controllers.yaml', 'frames.md']

    """
    request, wrong = Request.of(robot, arguments, packages)
    if request is None:
        return Outputs("", diagnostics=tuple(wrong))
    found, name = request.understand_outputs(), request.description.name
    if found.lowered is None or found.lowered.robot is None or has_errors(found.diagnostics):
        return Outputs(name, diagnostics=tuple(found.diagnostics))
    return Outputs(name, found.lowered.robot.outputs, tuple(found.diagnostics))


def explain_rules(ids: Sequence[str] = ()) -> Rules:
    """Return the meaning of rule ids, of plug-ins, too; without ``ids`` of all rules, sorted by id.

    Raises:
        UnknownName: A rule id does not exist; the message has a suggestion.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.explain_rules(["axis-zero"]).rules[0].help
        'Name one, such as `[0, 0, 1]`.'

    """
    diagnostics = (*plugged().diagnostics, *plugged_diagnostics())
    known = {**OF_PLUGINS, **(find(ids) if ids else every_rule())}
    for id in ids:
        if id not in known:
            raise UnknownName(f'there is no rule "{id}"; {did_you_mean(id, {**every_rule(), **OF_PLUGINS})}')
    return Rules(tuple(known[id] for id in dict.fromkeys(ids or sorted(known))), diagnostics)


def schema(name: str = "authoring") -> dict[str, Any]:
    """Return a JSON Schema by its name in ``rosorin-compile schema --list``; by default that for editors.

    Raises:
        UnknownName: The schema does not exist; the message has a suggestion.

    Example:
        >>> import rosorin_compile
        >>> rosorin_compile.schema("robot_model")["type"]
        'object'

    """
    if name not in (known := schema_names()):
        raise UnknownName(f'there is no schema "{name}"; {did_you_mean(name, known)}')
    found: dict[str, Any] = json.loads(schema_text(name))
    return found


def simulate(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    base: str | None = None,
    seconds: float = 2.0,
    limits: Mapping[str, float] | None = None,
    timing: bool = True,
    trust: bool = False,
) -> Simulated:
    """Simulate a robot in MuJoCo: at rest, in its poses, driving, and along the ranges of its joints.

    Args:
        robot: As in ``compile``, or a file in another format.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        base: ``fixed`` to the world, or ``free`` on a floor; by default a robot with a drive is free.
        seconds: How long each pose is held, 0.5 to 600 s.
        limits: Limits by name, as in ``simulate --limit``, in m, rad, m/s and rad/s.
        timing: Measure the speed of the simulation, which differs between runs.
        trust: As in ``compile``.

    Returns:
        The behaviour; each result beyond a limit is among its ``diagnostics``. Without ``poses`` the robot could not be
        simulated.

    Raises:
        RequestError: A value is invalid, or MuJoCo is not installed.

    Example:
        >>> import rosorin_compile  # doctest: +SKIP
        >>> result = rosorin_compile.simulate("rosorin", limits={"hold": 0.02})  # doctest: +SKIP
        >>> result.poses[0].worst  # doctest: +SKIP

    """
    from rosorin_compile.mujoco.simulate.simulation import Simulated, simulate_robot

    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return Simulated(str(robot), diagnostics=tuple(wrong))
    return simulate_robot(request, base=base, seconds=seconds, limits=limits, timing=timing)


def check_physics(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    trust: bool = False,
) -> CheckedPhysics:
    """Find links that collide at rest or while joints move, and masses that do not fit the meshes, with MuJoCo.

    Args:
        robot: As in ``simulate``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        trust: As in ``compile``.

    Raises:
        RequestError: MuJoCo or a library for meshes is not installed.

    Example:
        >>> import rosorin_compile  # doctest: +SKIP
        >>> result = rosorin_compile.check_physics("rosorin")  # doctest: +SKIP
        >>> result.fine, [one.message for one in result.diagnostics]  # doctest: +SKIP

    """
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.physics.checking import check_robot

    request, wrong = Request.of(robot, arguments, packages, None, trust)
    return CheckedPhysics.of(str(robot), "", None, wrong) if request is None else check_robot(request)


def collisions(
    robot: FilePath | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    output: FilePath | None = None,
    force: bool = False,
    trust: bool = False,
) -> CollisionMatrix:
    """Compute the pairs of links that MoveIt does not need to check, and write them to a file.

    Args:
        robot: As in ``simulate``.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        output: The file; by default ``collisions.yaml`` next to the description, which includes it.
        force: Compute the pairs again, even if the file is up to date.
        trust: As in ``compile``.

    Returns:
        The pairs, with distances in m.

    Raises:
        RequestError: MuJoCo or a library for meshes is not installed, or ``output`` is not a regular file.

    Example:
        >>> import rosorin_compile  # doctest: +SKIP
        >>> result = rosorin_compile.collisions("rosorin", output="collisions.yaml")  # doctest: +SKIP
        >>> [pair.links for pair in result.pairs if pair.reason == "Never"]  # doctest: +SKIP

    """
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix, compute_matrix
    from rosorin_compile.ros.srdf.planning import planning_of

    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return CollisionMatrix(str(robot), "", diagnostics=tuple(wrong))
    return compute_matrix(request, planning_of, output=None if output is None else Path(output), force=force)


def verify(
    robot: FilePath | Request,
    source: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
    """Compare a recording of the running robot with its description.

    Args:
        robot: As in ``simulate``.
        source: A rosbag2 folder, a .mcap or .db3 file, a file with the output of ``tf2_echo`` or ``view_frames``, or
            ``-`` for such text on standard input.
        arguments: As in ``compile``.
        packages: As in ``compile``.
        modes: Modes that were on or off; the others are detected.
        without: Nodes that were not running.
        pose: The named pose of the joints while ``tf2_echo`` ran.
        frames: The source and the target frame of the output of ``tf2_echo``.
        since: Start this many seconds after the start of the recording.
        until: Stop this many seconds after the start of the recording.
        stale: The maximum age of a transform in s.
        namespace: The namespace of the topics, such as ``robot1``.
        prefix: The prefix of the recorded frames, such as ``robot1/``.
        trust: As in ``compile``.

    Returns:
        The comparison; its ``findings`` are what is not as described.

    Raises:
        RequestError: The robot has no such mode, node or pose, a time is invalid, or numpy is not installed.

    Example:
        >>> import rosorin_compile  # doctest: +SKIP
        >>> result = rosorin_compile.verify("rosorin", "recordings/drive")  # doctest: +SKIP
        >>> result.as_described, [finding.message for finding in result.findings]  # doctest: +SKIP

    """
    from rosorin_compile.recordings.answers import Verified

    try:
        from rosorin_compile.recordings.verification import verify_recording
    except ModuleNotFoundError as problem:
        if problem.name != "numpy":
            raise
        needs = "rosorin-compile verify needs numpy, and rosbags for recordings"
        raise MissingPackages(f"{needs}: {pip_install('verify')}") from None
    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return Verified(str(robot), os.fsdecode(source), diagnostics=tuple(wrong))
    return verify_recording(
        request,
        os.fsdecode(source),
        modes=modes or {},
        without=without,
        pose=pose,
        frames=frames,
        since=since,
        until=until,
        stale=stale,
        namespace=namespace,
        prefix=prefix,
    )


def sweep(
    robot: FilePath | Request,
    variants: FilePath | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    client: Client | None = None,
    *,
    trust: bool = False,
) -> Iterator[Compiled]:
    """Compile a description with the arguments of each variant; nothing is written.

    Args:
        robot: As in ``compile``.
        variants: A CSV or YAML file or a folder as in ``sweep --over``, arguments by name, or an iterable of pairs of a
            name and arguments or of tables with ``name`` among the arguments.
        arguments: Arguments of all variants, which those of a variant override.
        packages: As in ``compile``.
        client: A ``distributed.Client`` on whose cluster the variants are compiled.
        trust: As in ``compile``.

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

    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        yield Compiled(None, (), wrong, ())
    else:
        yield from compile_variants(request, variants, client)


def write_sweep(
    robot: FilePath | Request,
    variants: FilePath,
    folder: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    jobs: int | None = None,
    whole: str = "",
    dask: str = "",
    prune: bool = False,
    report: Callable[[Diagnostic], None] | None = None,
    trust: bool = False,
) -> WrittenVariants:
    r"""Compile a description with the arguments of each variant, and write each variant to a separate folder.

    Args:
        robot: As in ``compile``.
        variants: A CSV or YAML file, or a folder with a file of arguments for each variant.
        folder: The folder that gets a folder for each variant, and ``sweep.json``.
        arguments: Arguments of all variants, which those of a variant override.
        packages: As in ``compile``.
        jobs: The number of processes; by default one per core.
        whole: The argument that takes each file of the folder ``variants``.
        dask: The address of a Dask scheduler.
        prune: Remove variants that are not in the list any more.
        report: Receives each diagnostic as soon as it is known.
        trust: As in ``compile``.

    Returns:
        The number of variants by their status. Variants that are up to date are not compiled again.

    Raises:
        RequestError: An argument is invalid.

    Example:
        >>> import rosorin_compile, tempfile
        >>> with open(tempfile.mkdtemp() + "/variants.csv", "w") as file:
        ...     _ = file.write("name,base\nlow,fixed\n")
        >>> result = rosorin_compile.write_sweep("examples/unitree_a1", file.name, tempfile.mkdtemp(), jobs=1)
        >>> result.made, result.error, result.complete
        (1, 0, True)

    """
    from rosorin_compile.variants.writing import WrittenVariants, write_variants

    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return WrittenVariants(str(robot), os.fsdecode(folder), diagnostics=tuple(wrong))
    over, output = Path(os.fsdecode(variants)), Path(os.fsdecode(folder))
    return write_variants(request, over, output, jobs=jobs, whole=whole, dask=dask, prune=prune, report=report)


def _case(
    robot: FilePath | Request, arguments: Mapping[str, Any] | None, packages: Packages | None, trust: bool
) -> tuple[Case | None, tuple[Diagnostic, ...], Request | None]:
    """Return a robot with its positions in YAML, and the errors of one that has some; warnings about executed code."""
    request, wrong = Request.of(robot, arguments, packages, None, trust)
    if request is None:
        return None, tuple(wrong), None
    found = request.understand()
    case = found.case
    shown = diff_inputs.EXECUTED if case is not None and not trust else ()
    kept = (one for one in found.diagnostics if one.rule in shown or (case is None and one.severity == ERROR))
    return case, tuple(kept), request


def _beyond(case: Case, states: Iterable[Mapping[str, Any]], strict: bool = False) -> list[Diagnostic]:
    """Return a diagnostic for each joint and side of its limits that positions exceed."""
    found: dict[tuple[str, str], Diagnostic] = {}
    for state in states:
        for one in joint_states.beyond(case.robot, state):
            key = (one.joint.name, one.side)
            if key not in found:
                found[key] = joint_states.beyond_limit(case, one, ERROR if strict else WARNING)
    return list(found.values())


def import_robot(
    source: FilePath,
    into: FilePath | None = None,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
    force: bool = False,
    keep_edits: bool = False,
    trust: bool = False,
    warn: Callable[[Diagnostic], None] | None = None,
) -> ImportResult:
    """Convert a URDF, xacro, SDF or MJCF file to a description, and write it unless an error is found.

    The description is compiled and compared with the source before it is written. If the folder has the description of
    an earlier import of the same source, the changes of both are merged.

    Args:
        source: The file of the robot.
        into: The folder of the ROS package that contains ``source``. The description is written to its
            ``descriptions/``, with a test that compares both.
        arguments: The arguments of a xacro file: texts, numbers (SI units) or truth values by name.
        packages: Folders of ROS packages by name.
        output: The folder of the description without ``into``; by default ``descriptions/ROBOT``.
        name: The name of the robot; by default that of ``source``.
        meshes: The prefix of relative mesh names: a folder relative to the artifacts, or ``package://NAME``.
        companions: Files that add to the robot, by format: ``{"srdf": "robot.srdf"}``.
        strict: Treat unsupported elements as errors.
        lenient: Accept violations of the specification where possible.
        parts: Factor repeated structures into parts.
        verbatim: Copy the Gazebo and ros2_control elements of a URDF unchanged.
        flat: Import the URDF that a xacro generates, without its macros.
        force: Write to a folder that is not empty.
        keep_edits: If both the source and the description changed the same lines, keep those of the description.
        trust: Run the Python code of a xacro without a warning.
        warn: Receives that warning before the code is run; without it the warning is the first of the diagnostics.

    Returns:
        The result; nothing was written if ``diagnostics`` has errors and ``written`` is empty.

    Raises:
        RequestError: ``source`` is not a file, the folder is in use, or options do not fit each other.

    Example:
        >>> result = import_robot("robot.urdf")  # doctest: +SKIP
        >>> result.folder  # doctest: +SKIP
        'descriptions/robot'

    """
    from rosorin_compile.importing import import_robot as importing

    given = asked.ask(source, arguments, packages)
    texts, wrong = asked.as_texts(given.arguments)
    if given.diagnostics or wrong:
        return importing.ImportResult(str(source), diagnostics=(*given.diagnostics, *wrong))
    options = importing.ImportOptions(
        into=None if into is None else Path(into),
        arguments=texts,
        packages=given.packages,
        output=None if output is None else Path(output),
        name=name,
        meshes=meshes,
        companions={format: Path(file) for format, file in (companions or {}).items()},
        strict=strict,
        lenient=lenient,
        parts=parts,
        verbatim=verbatim,
        flat=flat,
        force=force,
        ours=keep_edits,
        trust=trust,
        warn=warn,
    )
    return importing.import_robot(source if isinstance(source, Path) else Path(source), options)


def _read_options(
    arguments: Mapping[str, Any] | None,
    packages: Mapping[str, FilePath] | None,
    trust: bool,
    warn: Callable[[Diagnostic], None] | None,
    lenient: bool = False,
) -> tuple[ReadOptions, list[Diagnostic]]:
    """Return how a robot in another format is read, and what is wrong with the arguments and packages."""
    given = asked.ask("", arguments, packages)
    texts, wrong = asked.as_texts(given.arguments)
    options = ReadOptions(texts, given.packages, lenient, tell=warn, trust=trust)
    return options, [*given.diagnostics, *wrong]


def extract_boxes(
    sources: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
    warn: Callable[[Diagnostic], None] | None = None,
) -> ExtractedBoxes:
    """Fit boxes, cylinders, capsules and stacks of boxes to meshes.

    Args:
        sources: Mesh files, or one robot: a description, URDF, xacro, SDF or MJCF.
        arguments: The arguments of the robot, by name.
        packages: Folders of ROS packages by name.
        links: The links of the robot to use; by default all that have meshes.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"``: collision, else visual.
        scale: The factors of mesh files along x, y and z, such as 0.001 for millimetres.
        shape: The shape in ``text``: box, oriented_box, cylinder, capsule, stack or smallest.
        stack: The number of boxes in a stack, 1 to 100.
        axis: The axis of the stack: x, y, z or auto.
        digits: Decimals of lengths in metres, 0 to 9.
        output: A file to write ``text`` to.
        force: Replace a file that this function did not write.
        trust: Run the Python code of a xacro without a warning.
        warn: Receives that warning before the code is run.

    Returns:
        ``parts`` has for each part the shapes of every kind with their fit (metres, cubic metres, radians), ``text``
        the section ``links`` of a description with one of them, and ``report`` a table.

    Raises:
        RequestError: A file, robot or link does not exist, or an option is out of range.

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
    file = None if output is None else Path(output)
    return extracting.extract_boxes(source, shape, stack, axis, digits, file, force)


def extract_height_map(
    sources: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
    exact: bool = True,  # noqa: ARG001 - of earlier versions
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
    warn: Callable[[Diagnostic], None] | None = None,
) -> ExtractedHeightMap:
    """Compute the top surface of meshes as heights on a grid.

    Args:
        sources: Mesh files, or one robot with ``link``.
        arguments: The arguments of the robot, by name.
        packages: Folders of ROS packages by name.
        link: The link of the robot whose meshes are used.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"``: collision, else visual.
        scale: The factors of mesh files along x, y and z.
        frame: The link whose frame the height map uses; by default ``link``.
        xyz: The position of the mesh in the frame, in metres.
        rpy: The orientation of the mesh in the frame: roll, pitch, yaw in radians.
        cell: The edge length of a cell in metres; by default 0.01.
        origin: The corner of the first cell (x, y) in metres; by default the corner of the mesh.
        cells: The number of cells along x and y; by default those that cover the mesh.
        size: The size of the grid (x, y) in metres, instead of ``cells``.
        exact: Ignored; heights are always exact.
        below: Ignore surfaces above this height, in metres.
        map_digits: Decimals of heights in metres, 0 to 9.
        step: Round heights of boxes to multiples of this length in metres; by default a cell.
        bottom: Also compute the lowest point in each cell.
        into: A file of a description whose height map is replaced, on the same grid.
        status: The status of the source in the description: calculated, measured or factory.
        note: The note of the source in the description; by default the names of the meshes.
        output: A file to write ``text`` to.
        force: Replace a file that this function did not write.
        trust: Run the Python code of a xacro without a warning.
        warn: Receives that warning before the code is run.

    Returns:
        ``height_map`` is the map, or None with errors in ``diagnostics``; ``text`` is the section ``links`` of a
        description with it.

    Raises:
        RequestError: A file, robot or link does not exist, or options are out of range or do not fit each other.

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
    x, y, z = scale
    source = MeshSource(sources, reading, [link] if link is not None else (), section, (x, y, z))
    grid = extracting.GridOptions(cell, origin, cells, size, below, map_digits, step, bottom)
    (x, y, z), (roll, pitch, yaw) = xyz, rpy
    return extracting.extract_height_map(
        source,
        grid,
        frame,
        Pose((x, y, z), (roll, pitch, yaw)),
        None if into is None else Path(into),
        status,
        note,
        None if output is None else Path(output),
        force,
    )


def extract_factory(
    package: FilePath,
    output: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    robot: str | None = None,
    height_map_link: str | None = None,
    frame: str | None = None,
    section: str = "auto",
    cell: float | None = None,
    origin: tuple[float, float] | None = None,
    cells: tuple[int, int] | None = None,
    size: tuple[float, float] | None = None,
    exact: bool = True,  # noqa: ARG001 - of earlier versions
    below: float | None = None,
    map_digits: int = 4,
    step: float | None = None,
    lenient: bool = False,
    trust: bool = False,
    warn: Callable[[Diagnostic], None] | None = None,
) -> ExtractedFactory:
    """Write the joints, a box for each link and a height map of a ROS description package to a folder.

    Args:
        package: The folder of the package.
        output: The folder to write.
        arguments: The arguments of its xacro, by name.
        packages: Folders of other ROS packages by name.
        robot: The robot file in the package; by default the only one.
        height_map_link: The link whose meshes are used for a height map. Default: no height map.
        frame: The link whose frame the height map uses; by default ``height_map_link``.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"``: collision, else visual.
        cell: As in ``extract_height_map``.
        origin: As in ``extract_height_map``.
        cells: As in ``extract_height_map``.
        size: As in ``extract_height_map``.
        exact: As in ``extract_height_map``.
        below: As in ``extract_height_map``.
        map_digits: As in ``extract_height_map``.
        step: As in ``extract_height_map``.
        lenient: Accept violations of the specification where possible.
        trust: Run the Python code of a xacro without a warning.
        warn: Receives that warning before the code is run.

    Returns:
        The names of the joints and of the links with a box, and the files that were written.

    Raises:
        RequestError: The package, the robot file or a link does not exist, or an option is out of range.

    Example:
        >>> extract_factory("nano_description", "factory").joints  # doctest: +SKIP
        ('wheel_left_joint', 'wheel_right_joint')

    """
    from rosorin_compile.importing.extract import extract as extracting

    reading, wrong = _read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return extracting.ExtractedFactory(diagnostics=tuple(wrong))
    grid = extracting.GridOptions(cell, origin, cells, size, below, map_digits, step)
    return extracting.extract_factory(
        Path(package), Path(output), reading, grid, robot, height_map_link, frame, section
    )


def package(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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

    A package that this function wrote before keeps the options that are None.

    Args:
        robot: The first file of a description, its folder, or its name in ``descriptions/``.
        folder: The folder of the package.
        arguments: The arguments of the description, by name.
        packages: Folders of ROS packages by name.
        name: The name of the package; by default ``ROBOT_description``.
        build_type: ``"ament_cmake"``, the default, or ``"ament_python"``.
        version: The version, three numbers; by default ``"0.1.0"``.
        maintainer: The maintainer, as ``"FilePath <mail@example.org>"``.
        license: The license as an SPDX name.
        url: The website of the package.
        topics: Topics by sensor, for the RViz configuration.
        compile_at_launch: Compile the description at launch, with its arguments as launch arguments.
        control: Add a launch file that starts the controller_manager and the controllers.
        moveit: Add a launch file that starts MoveIt.
        nav2: Add a launch file that starts Nav2 and robot_localization.
        trust: Permit a xacro to run Python code without a warning.

    Returns:
        The files of the package; ``package`` is empty if an error kept it from being written.

    Raises:
        RequestError: An option is invalid, or the robot has no such sensor.

    Example:
        >>> package("rosorin", "rosorin_description", license="MIT").package  # doctest: +SKIP
        'rosorin_description'

    """
    from rosorin_compile.ros.package import write as packaging

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return packaging.WrittenPackage("", os.fsdecode(folder), diagnostics=tuple(wrong))
    starts = {"control": control, "moveit": moveit, "nav2": nav2}
    options = packaging.PackageOptions(
        name, build_type, version, maintainer, license, url, compile_at_launch, starts, topics or {}
    )
    return packaging.write_package(request, Path(folder), options)


def deploy(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    places: Mapping[str, str] | None = None,
    install: FilePath | None = None,
    dry_run: bool = False,
    full: bool = False,
    trust: bool = False,
) -> Deployed:
    """Write the artifacts of a robot into a ROS 2 package or another folder that exists.

    Args:
        robot: The first file of a description, its folder, or its name in ``descriptions/``.
        folder: The folder.
        arguments: The arguments of the description, by name.
        packages: Folders of ROS packages by name.
        places: The paths of outputs in the folder, or ``"none"``; they are stored there.
        install: The install space that is checked for older copies; by default the one of the workspace.
        dry_run: Write nothing.
        full: List differences of texts in full in ``changes``.
        trust: Permit a xacro to run Python code without a warning.

    Returns:
        The copies with their paths, and the changes as text; ``robot`` is empty if an error kept it from being
        deployed.

    Raises:
        RequestError: The folder or output does not exist.

    Example:
        >>> result = deploy("rosorin", "ros_ws/src/rosorin_base", dry_run=True)  # doctest: +SKIP
        >>> [copy.file for copy in result.copies if not copy.same]  # doctest: +SKIP
        ['urdf/rosorin.urdf']

    """
    from rosorin_compile.ros.package import deploy as deploying

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return deploying.Deployed("", os.fsdecode(folder), diagnostics=tuple(wrong))
    return deploying.deploy(
        request, Path(folder), places or {}, None if install is None else Path(install), dry_run, full
    )


def check_deployed(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
    *,
    full: bool = False,
    trust: bool = False,
) -> CheckedCopies:
    """Compare the artifacts of a robot with the copies in a package, an install space or another folder.

    Args:
        robot: The first file of a description, its folder, or its name in ``descriptions/``.
        folder: The folder.
        arguments: The arguments of the description, by name.
        packages: Folders of ROS packages by name.
        full: List differences of texts in full in ``lines``.
        trust: Permit a xacro to run Python code without a warning.

    Returns:
        The names of the copies that are as compiled, and of those that differ, with the differences as text.

    Example:
        >>> check_deployed("rosorin", "ros_ws/src/rosorin_base").differing  # doctest: +SKIP
        ()

    """
    from rosorin_compile.ros.package import checking as copies

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return copies.CheckedCopies(diagnostics=tuple(wrong))
    return copies.check_deployed(request, Path(folder), full)


def check_parameters(
    robot: FilePath | Request,
    files: Sequence[FilePath],
    arguments: Mapping[str, Any] | None = None,
    packages: Packages | None = None,
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
        robot: A description, or a robot in another format.
        files: The parameter files.
        arguments: The arguments of the robot, by name.
        packages: Folders of ROS packages by name.
        controllers: Parameter files of a controller_manager.
        launch: Launch files to read remappings from.
        remaps: Further remappings, as ``"NODE:FROM:=TO"``.
        namespace: The namespace of the nodes.
        distribution: The ROS 2 distribution; by default that of the outputs of the robot, if they agree.
        trust: Permit a xacro to run Python code without a warning.

    Returns:
        The diagnostics, with the number of frames that were judged.

    Raises:
        RequestError: A file does not exist, or a remapping is invalid.

    Example:
        >>> result = check_parameters("rosorin", ["ekf.yaml"])  # doctest: +SKIP
        >>> [one.rule for one in result.diagnostics]  # doctest: +SKIP
        ['parameters-frame']

    """
    from rosorin_compile.ros.check_parameters import checking as parameter_files

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return parameter_files.CheckedParameters(diagnostics=tuple(wrong))
    paths, own, launched = ([Path(file) for file in some] for some in (files, controllers, launch))
    return parameter_files.check_parameters(
        request, parameter_files.ParameterFiles(paths, own, launched, remaps, namespace, distribution or "")
    )

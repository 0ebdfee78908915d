"""The commands ``check``, ``write`` (``all``), ``explain`` and ``schema`` for programs: values in, values out.

``compile`` and ``read`` stand in ``pipeline``, ``diff`` in ``sides``. Nothing is printed, and what is wrong with a
robot's files is no exception: it is among the diagnostics.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.cli.given import Given
from rosorin_compile.cli.registry import service
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.project import Description

if TYPE_CHECKING:
    from distributed import Client

    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.importing.extract.extract import ExtractedBoxes, ExtractedFactory, ExtractedHeightMap
    from rosorin_compile.importing.import_robot import ImportResult
    from rosorin_compile.language.explain.explanation import Answer, Explanation
    from rosorin_compile.output.pipeline import Compiled, Understood
    from rosorin_compile.output.request import Request
    from rosorin_compile.ros.check_parameters.checking import CheckedParameters
    from rosorin_compile.ros.package.checking import CheckedCopies
    from rosorin_compile.ros.package.deploy import Deployed
    from rosorin_compile.ros.package.write import WrittenPackage

    Name = str | os.PathLike[str]


@dataclass(frozen=True)
class Checked:
    """Whether the committed artifacts of a robot are those of its description.

    ``differing`` are the files that are not as compiled (missing, changed, or no artifact any more); ``lines`` says
    how they differ, as the command line does. Both are empty where ``compiled`` has errors.
    """

    compiled: Compiled
    folder: Path
    differing: tuple[str, ...]
    lines: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def same(self) -> bool:
        """Whether the robot has no errors, no engine refuses an artifact, and each is as committed."""
        return not self.differing and not has_errors(self.diagnostics)

    def __str__(self) -> str:
        """Return what differs, in lines."""
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Written:
    """What writing the artifacts of a robot into ``folder`` did to each file there, by name.

    ``kept`` are no artifacts and were left alone, ``removed`` were none either and are gone because pruning was asked
    for. With errors among the diagnostics nothing is written.
    """

    compiled: Compiled
    folder: Path
    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class Explained:
    """Where things of a robot sit, and where each of their numbers was written; none if the robot has errors."""

    answers: tuple[Explanation | Answer, ...]
    diagnostics: tuple[Diagnostic, ...]

    @classmethod
    def of(cls, found: Understood, arguments: Mapping[str, Any], names: Sequence[str], pose: str = "") -> Explained:
        """Return the same of a description without errors that was read with these arguments. Raises KeyError."""
        from rosorin_compile.language.explain.answer import NotThere, explain

        if found.lowered is None:
            raise ValueError("a description with errors has no meaning to explain")
        try:
            answers = explain(found.expanded, found.lowered, arguments, names, pose)
        except NotThere as problem:
            raise KeyError(str(problem)) from None
        return cls(tuple(answers), tuple(found.diagnostics))

    def lines(self) -> list[str]:
        """Return what the command line prints, line by line."""
        from rosorin_compile.cli.explain_text import lines

        return [line for answer in self.answers for line in lines(answer)]

    def __str__(self) -> str:
        """Return what the command line prints."""
        return "\n".join(self.lines())


def check(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
) -> Checked:
    """Compile a description and compare with its committed artifacts, as ``rosorin-compile check`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``. ``outputs`` is the folder that has a folder a robot; by
    default that of the project.
    """
    from rosorin_compile.cli.comparing import compared

    description, given, compiled = _proven(path, arguments, packages, outputs)
    said = compiled.diagnostics
    if description is None or compiled.robot is None or has_errors(said):
        return Checked(compiled, _folder(description), (), (), tuple(said))
    held = compared(given, description, compiled)
    return Checked(compiled, description.outputs, held.differing(), tuple(held.lines()), (*said, *held.diagnostics))


def write(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
    prune: bool = False,
) -> Written:
    """Compile a description and write its artifacts, the whole set or nothing, as ``rosorin-compile all`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``, ``outputs`` as in ``check``. ``prune`` removes what is
    no artifact from the robot's folder.
    """
    from rosorin_compile.cli.all import left_alone
    from rosorin_compile.output import OutputError, write_outputs

    description, _, compiled = _proven(path, arguments, packages, outputs)
    said, folder = compiled.diagnostics, _folder(description)
    if not compiled.artifacts or has_errors(said):
        return Written(compiled, folder, (), (), (), (), tuple(said))
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    try:
        done = write_outputs(folder, {**compiled.mesh_files, **files}, prune)
    except OutputError as problem:
        return Written(compiled, folder, (), (), (), (), (*said, problem.diagnostic))
    more = (*done.put_aside(folder), *left_alone(folder, done))
    return Written(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*said, *more))


def explain(
    path: Name,
    names: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    pose: str = "",
) -> Explained:
    """Return where frames, links, joints, sensors and uses of parts sit, and where each number of theirs was written.

    ``path``, ``arguments`` and ``packages`` as in ``compile``; ``names`` and ``pose`` as ``rosorin-compile explain``
    takes them. Raises KeyError for a name that the robot does not have, with what is near.
    """
    from rosorin_compile.output.pipeline import understand

    description, given, wrong = Given.asked(path, arguments, packages)
    if description is None:
        return Explained((), tuple(wrong))
    values = given.values()
    found = understand(description.path, values, packages=given.packages)
    if found.lowered is None or found.lowered.robot is None or has_errors(found.diagnostics):
        return Explained((), tuple(found.diagnostics))
    return Explained.of(found, values, names, pose)


def sweep(
    path: str | os.PathLike[str],
    variants: str | os.PathLike[str] | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    client: Client | None = None,
) -> Iterator[Compiled]:
    """Yield what becomes of a description with the arguments of each variant; nothing is written.

    ``variants`` is what ``rosorin-compile sweep --over`` takes, a CSV or YAML file or a folder; or arguments by name;
    or pairs of a name and arguments, or tables with ``name`` among the arguments, also from a generator. ``arguments``
    hold for all, where a variant has none of its own; they and ``packages`` are those of ``compile``. Each ``Compiled``
    has its ``variant``. With ``client``, a ``distributed.Client``, they are compiled on its cluster; OutputError is
    raised if that fails. The order is that of ``variants``.

    What is wrong with a variant is among its diagnostics; what is wrong with all, such as the list itself, is a single
    ``Compiled`` without a variant.
    """
    made: Iterator[Compiled] = service("many variants")(path, variants, arguments, packages, client)
    return made


def schema(name: str = "authoring") -> dict[str, Any]:
    """Return a JSON Schema by a name of ``rosorin-compile schema``. Raises KeyError, with what is near."""
    import json

    from rosorin_compile.cli.schema import names, text_of
    from rosorin_compile.source.diagnostics import did_you_mean

    if name not in (known := names()):
        raise KeyError(f'there is no schema "{name}"; {did_you_mean(name, known)}')
    found: dict[str, Any] = json.loads(text_of(name))
    return found


def _proven(
    path: Name, arguments: object, packages: object, outputs: Name | None
) -> tuple[Description | None, Given, Compiled]:
    """Return what becomes of a description with its meshes, read back as a command does before it writes."""
    from rosorin_compile.output.pipeline import Compiled

    description, given, wrong = Given.asked(path, arguments, packages, outputs)
    if description is None:
        return None, given, Compiled(None, (), wrong, ())
    return description, given, given.request(description).compile()


def _folder(description: Description | None) -> Path:
    return description.outputs if description is not None else Path()


def import_robot(
    source: Name,
    into: Name | None = None,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    output: Name | None = None,
    name: str | None = None,
    meshes: str | None = None,
    companions: Mapping[str, Name] | None = None,
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
    from rosorin_compile.importing.import_robot import ImportOptions, ImportResult
    from rosorin_compile.importing.import_robot import import_robot as convert
    from rosorin_compile.language.asked import as_texts, ask

    asked = ask(source, arguments, packages)
    texts, wrong = as_texts(asked.arguments)
    if asked.diagnostics or wrong:
        return ImportResult(str(source), diagnostics=(*asked.diagnostics, *wrong))
    options = ImportOptions(
        into=None if into is None else Path(into),
        arguments=texts,
        packages=asked.packages,
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
    return convert(source if isinstance(source, Path) else Path(source), options)


def _read_options(
    arguments: Mapping[str, Any] | None,
    packages: Mapping[str, Name] | None,
    trust: bool,
    warn: Callable[[Diagnostic], None] | None,
    lenient: bool = False,
) -> tuple[ReadOptions, list[Diagnostic]]:
    """Return how a robot in another format is read, and what is wrong with the arguments and packages."""
    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.language.asked import as_texts, ask

    asked = ask("", arguments, packages)
    texts, wrong = as_texts(asked.arguments)
    options = ReadOptions(texts, asked.packages, lenient, tell=warn, trust=trust)
    return options, [*asked.diagnostics, *wrong]


def extract_boxes(
    sources: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    links: Sequence[str] = (),
    section: str = "auto",
    scale: Sequence[float] = (1.0, 1.0, 1.0),
    shape: str = "box",
    stack: int = 4,
    axis: str = "auto",
    digits: int = 5,
    output: Name | None = None,
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
    from rosorin_compile.importing.extract import extract

    reading, wrong = _read_options(arguments, packages, trust, warn)
    if wrong:
        return extract.ExtractedBoxes(diagnostics=tuple(wrong))
    x, y, z = scale
    source = extract.MeshSource(sources, reading, links, section, (x, y, z))
    file = None if output is None else Path(output)
    return extract.extract_boxes(source, shape, stack, axis, digits, file, force)


def extract_height_map(
    sources: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
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
    spacing: float | None = None,
    exact: bool = False,
    below: float | None = None,
    map_digits: int = 4,
    step: float | None = None,
    bottom: bool = False,
    into: Name | None = None,
    status: str = "calculated",
    note: str | None = None,
    output: Name | None = None,
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
        spacing: The largest distance between samples in metres; by default a third of a cell.
        exact: Compute the highest point in each cell exactly instead of sampling.
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
    from rosorin_compile.importing.extract import extract
    from rosorin_compile.model import Pose

    reading, wrong = _read_options(arguments, packages, trust, warn)
    if wrong:
        return extract.ExtractedHeightMap(diagnostics=tuple(wrong))
    x, y, z = scale
    source = extract.MeshSource(sources, reading, [link] if link is not None else (), section, (x, y, z))
    grid = extract.GridOptions(cell, origin, cells, size, spacing, exact, below, map_digits, step)
    (x, y, z), (roll, pitch, yaw) = xyz, rpy
    return extract.extract_height_map(
        source,
        grid,
        frame,
        Pose((x, y, z), (roll, pitch, yaw)),
        bottom,
        None if into is None else Path(into),
        status,
        note,
        None if output is None else Path(output),
        force,
    )


def extract_factory(
    package: Name,
    output: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    robot: str | None = None,
    height_map_link: str | None = None,
    frame: str | None = None,
    section: str = "auto",
    cell: float | None = None,
    origin: tuple[float, float] | None = None,
    cells: tuple[int, int] | None = None,
    size: tuple[float, float] | None = None,
    spacing: float | None = None,
    exact: bool = False,
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
        height_map_link: The link whose meshes are used for a height map; by default there is none.
        frame: The link whose frame the height map uses; by default ``height_map_link``.
        section: Use the meshes of ``"collision"`` or ``"visual"`` shapes; ``"auto"``: collision, else visual.
        cell: As in ``extract_height_map``.
        origin: As in ``extract_height_map``.
        cells: As in ``extract_height_map``.
        size: As in ``extract_height_map``.
        spacing: As in ``extract_height_map``.
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
    from rosorin_compile.importing.extract import extract

    reading, wrong = _read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return extract.ExtractedFactory(diagnostics=tuple(wrong))
    grid = extract.GridOptions(cell, origin, cells, size, spacing, exact, below, map_digits, step)
    return extract.extract_factory(Path(package), Path(output), reading, grid, robot, height_map_link, frame, section)


def package(
    robot: Name | Request,
    folder: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
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
        maintainer: The maintainer, as ``"Name <mail@example.org>"``.
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
    from rosorin_compile.output.request import Request
    from rosorin_compile.ros.package.write import PackageOptions, WrittenPackage, write_package

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return WrittenPackage("", os.fsdecode(folder), diagnostics=tuple(wrong))
    starts = {"control": control, "moveit": moveit, "nav2": nav2}
    options = PackageOptions(
        name, build_type, version, maintainer, license, url, compile_at_launch, starts, topics or {}
    )
    return write_package(request, Path(folder), options)


def deploy(
    robot: Name | Request,
    folder: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    places: Mapping[str, str] | None = None,
    install: Name | None = None,
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
        RequestError: There is no such folder or output.

    Example:
        >>> result = deploy("rosorin", "ros_ws/src/rosorin_base", dry_run=True)  # doctest: +SKIP
        >>> [copy.file for copy in result.copies if not copy.same]  # doctest: +SKIP
        ['urdf/rosorin.urdf']

    """
    from rosorin_compile.output.request import Request
    from rosorin_compile.ros.package.deploy import Deployed
    from rosorin_compile.ros.package.deploy import deploy as write_copies

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return Deployed("", os.fsdecode(folder), diagnostics=tuple(wrong))
    return write_copies(request, Path(folder), places or {}, None if install is None else Path(install), dry_run, full)


def check_deployed(
    robot: Name | Request,
    folder: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
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
    from rosorin_compile.output.request import Request
    from rosorin_compile.ros.package.checking import CheckedCopies
    from rosorin_compile.ros.package.checking import check_deployed as compare_copies

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return CheckedCopies(diagnostics=tuple(wrong))
    return compare_copies(request, Path(folder), full)


def check_parameters(
    robot: Name | Request,
    files: Sequence[Name],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    controllers: Sequence[Name] = (),
    launch: Sequence[Name] = (),
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
    from rosorin_compile.output.request import Request
    from rosorin_compile.ros.check_parameters.checking import CheckedParameters, ParameterFiles
    from rosorin_compile.ros.check_parameters.checking import check_parameters as check_files

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return CheckedParameters(diagnostics=tuple(wrong))
    paths, own, launched = ([Path(file) for file in some] for some in (files, controllers, launch))
    return check_files(request, ParameterFiles(paths, own, launched, remaps, namespace, distribution or ""))

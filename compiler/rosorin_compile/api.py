"""The Python API: one function for each command, which returns a frozen dataclass and never prints."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import Diagnostic

if TYPE_CHECKING:
    from rosorin_compile.formats.imported import ReadOptions
    from rosorin_compile.importing.extract.extract import ExtractedBoxes, ExtractedFactory, ExtractedHeightMap
    from rosorin_compile.importing.import_robot import ImportResult

FilePath = str | os.PathLike[str]


def import_robot(
    source: FilePath,
    into: FilePath | None = None,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, FilePath] | None = None,
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
    packages: Mapping[str, FilePath] | None,
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
    packages: Mapping[str, FilePath] | None = None,
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
    packages: Mapping[str, FilePath] | None = None,
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
    package: FilePath,
    output: FilePath,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, FilePath] | None = None,
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

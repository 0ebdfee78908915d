"""The Python API: one function for each command, which returns a frozen dataclass and never prints."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import Diagnostic

if TYPE_CHECKING:
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

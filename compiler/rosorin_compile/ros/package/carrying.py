"""Descriptions that a package compiles at launch: the files that it carries, and the launch arguments.

The files are stored below ``descriptions`` with the same relative places as in the project. The copy is compiled before
anything is written, to check that it works from the install space.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.static_tf import free_names
from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span
from rosorin_compile.source.files import read_bytes, resolve
from rosorin_compile.source.load import yaml_of
from rosorin_compile.source.project import Description, tool_folders

from .copies import write_files
from .launch import ARGUMENTS, WORDS, LaunchArgument, mode_arguments
from .meshes import named
from .options import Options, is_legal

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.request import Request

STATICS = "static_tf_json"
_RULE = "package-not-carried"
_CUT = "..."  # the end of a text that is shortened in lists


@dataclass(frozen=True)
class PassedArgument:
    """An argument of the description, and the launch argument for it.

    ``own`` is the default in the description, or None: an argument with that value is not passed.
    """

    name: str
    argument: LaunchArgument
    own: str | None


@dataclass(frozen=True)
class Carried:
    """A description in a package: its main file, all its files by place, and its arguments.

    ``urdf`` and ``statics`` are the outputs that are printed at launch; ``packages`` are the ROS packages it reads.
    """

    description: str
    files: Mapping[str, bytes]
    passed: tuple[PassedArgument, ...]
    urdf: str
    statics: str
    packages: tuple[str, ...]

    @property
    def required(self) -> bool:
        """Return True if a launch must set an argument."""
        return any(one.argument.default is None for one in self.passed)


def carry(compiled: Compiled, request: Request, options: Options) -> tuple[Carried | None, list[Diagnostic]]:
    """Return the description that a package with these options carries, if any, or the errors about its files.

    The arguments of the request become the defaults at launch. Raises LoadError.
    """
    from rosorin_compile.language.arguments import declared

    main = next((one for one in compiled.artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if not options.at_launch or compiled.robot is None or main is None:
        return None, []
    path, values, packages = request.description.path, request.values(), {**compiled.packages, **request.packages}
    elsewhere = [tool_folders()["parts_library"], *compiled.python_packages, *map(_absolute, packages.values())]
    inputs = [_absolute(one) for one in compiled.files_read]
    own = [one for one in inputs if not any(map(one.is_relative_to, elsewhere))]
    top, prefix = _top(_absolute(path), own)
    if problems := list(_relative_meshes(main, options.name, own)):
        return None, problems
    places = {one: prefix + one.relative_to(top).as_posix() for one in own if one.is_relative_to(top)}
    taken = [*(argument.name for argument in ARGUMENTS), *mode_arguments(compiled.robot).values(), WORDS]
    arguments = declared(path, values)[0]
    names = free_names([one.name for one in arguments], taken, "arg_")
    read = (
        name
        for name, folder in packages.items()
        if str(folder) in main.text or any(one.is_relative_to(folder) for one in inputs)
    )
    return Carried(
        description=places[_absolute(path)],
        files={place: read_bytes(file) for file, place in places.items()},
        passed=tuple(_passed(one, names[one.name], values) for one in arguments),
        urdf=main.output,
        statics=next((one.output for one in compiled.artifacts if one.backend == STATICS), STATICS),
        packages=tuple(sorted(name for name in read if is_legal(name) and name != options.name)),
    ), []


def _absolute(path: Path) -> Path:
    return Path(os.path.abspath(path))


def _top(first: Path, files: Sequence[Path]) -> tuple[Path, str]:
    """Return the folder that is copied below ``descriptions`` of the package, and the prefix of its files there.

    This is ``descriptions`` of the project if it has all files, else the project; for a lone description its folder.
    """
    folder = next((one for one in (first.parent, *first.parent.parents) if one.name == Description.FOLDER), None)
    if folder is None:
        name = first.parent.name
        return first.parent, f"{Description.FOLDER}/{name if name.isprintable() and name.strip('.') else 'robot'}/"
    return (folder if all(one.is_relative_to(folder) for one in files) else folder.parent), f"{Description.FOLDER}/"


def _relative_meshes(main: Artifact, package: str, files: Sequence[Path]) -> Iterator[Diagnostic]:
    for name in named(main.text):
        if "://" not in name and not name.startswith("/"):
            message = f"mesh {name} is named by a path, and a URDF that is compiled at launch is in no folder"
            inside = name if name.startswith("meshes/") else f"meshes/{name.rpartition('/')[2]}"
            help = f"write package://{package}/{inside} in the description; the file is copied into the package"
            yield report(_RULE, message, _mention(name, files), help)


def _mention(name: str, files: Iterable[Path]) -> Span | None:
    """Return the first place of a name in the descriptions among some files."""
    for file in files:
        if file.suffix in Description.ENDINGS:
            source = Source(str(file), read_bytes(file).decode("utf-8", "replace"))
            for number, line in enumerate(source.text.splitlines(), 1):
                if name in line:
                    return Span(source, number, line.index(name) + 1, len(name))
    return None


def _passed(one: Argument, launch_name: str, values: Mapping[str, Any]) -> PassedArgument:
    own = default = None if one.required else _unquoted(one.default)
    if one.name in values and not one.required:
        value = values[one.name]
        default = value if isinstance(value, str) else _unquoted(one.value)
    choices = [_unquoted(text) for text in one.allowed]
    if default is not None and choices and default not in choices:
        choices.append(default)
    if any(text.endswith(_CUT) for text in choices):
        choices = []
    help = one.help or f"the argument {one.name} of the description"
    if one.help and launch_name != one.name:
        help += f" ({one.name} of the description)"
    return PassedArgument(one.name, LaunchArgument(launch_name, default, help, tuple(choices)), own)


def _unquoted(written: str) -> str:
    """Return a text of a description without its quotes; other values as they are written."""
    if written[:1] not in ("'", '"'):
        return written
    try:
        value = yaml_of(written)
    except ValueError:  # it is shortened
        return written
    return value if isinstance(value, str) else written


def check_carried(
    carried: Carried, compiled: Compiled, request: Request, files: Mapping[str, bytes], package: str
) -> list[Diagnostic]:
    """Return an error if the description in the files of a package does not compile to the same URDF from there."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder, package)
        write_files(root, files)
        packages = {**compiled.packages, **request.packages, package: root}
        copy = Description(package, root / carried.description, root / Description.OUTPUTS)
        again = replace(request, description=copy, packages=packages, trust=True).compile((carried.urdf,))
        allowed = [tool_folders()["parts_library"], *packages.values(), *again.python_packages]
        allowed = [resolve(one) for one in allowed]
        strays = [one for one in again.files_read if not any(map(resolve(one).is_relative_to, allowed))]
    own = [_absolute(one) for one in compiled.files_read]
    before = {one.output: one.text for one in compiled.artifacts}
    for wrong in (one for one in again.diagnostics if one.severity == "error"):
        span = wrong.span and _mention(wrong.span.source.line(wrong.span.line), own)
        message = f"the description does not compile from the package: {wrong.message}"
        return [report(_RULE, message, span, f"keep all files inside the folder of the project; {wrong.worded().help}")]
    for stray in strays:
        message = f"compiled from the package, the description still reads {stray}"
        return [report(_RULE, message, _mention(stray.name, own), "name it relative to the file that reads it")]
    if any(one.text != before[one.output] for one in again.artifacts):
        message = f"compiled from the package, the description gives another {carried.urdf}"
        return [report(_RULE, message, None, "it may read files by a path that depends on its folder")]
    return []

"""Compiling at launch: the description that a package carries, and what its launch files call its arguments.

The files of the description stand below ``descriptions`` of the package as they stand in the project, so that they find
each other from the install space. That they do is proven: the copy is compiled before anything is written.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.static_tf import free_names
from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, first_of
from rosorin_compile.source.files import read_bytes, resolve
from rosorin_compile.source.load import yaml_of
from rosorin_compile.source.project import Description, tool_folders

from .copies import named
from .options import is_legal
from .starting import ARGUMENTS, WORDS, LaunchArgument, spelt_statics

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.language.arguments import Argument
    from rosorin_compile.request import Request

    from .options import Options

STATICS = "static_tf_json"
_CUT = "..."  # the end of a text that is too long to be shown
# What is the same value on a command line, within quotes, as it is in YAML.
_SIMPLE = re.compile(r"(?!(null|Null|NULL|~)$)[\w.+/ -]*")


class Passed(NamedTuple):
    """An argument of the description as the launch files have it.

    ``own`` is the default that the description has itself: with that text nothing is passed. None is no text.
    ``simple`` says that it may as well be passed.
    """

    name: str
    argument: LaunchArgument
    own: str | None
    simple: bool


class Carried(NamedTuple):
    """A description in a package: its first file and all that it reads by place, and how it is compiled.

    ``urdf`` and ``statics`` are what ``rosorin-compile print`` is asked for; ``packages`` are ROS packages it needs.
    """

    description: str
    files: Mapping[str, bytes]
    passed: tuple[Passed, ...]
    urdf: str
    statics: str
    packages: tuple[str, ...]

    @property
    def simple(self) -> bool:
        """Whether the words of the command can stand in a launch file: every argument can be passed as it is."""
        return bool(_SIMPLE.fullmatch(self.description)) and all(one.simple for one in self.passed)

    @property
    def required(self) -> list[str]:
        """Return the arguments that a launch has to give."""
        return [one.argument.name for one in self.passed if one.argument.default is None]


def described(compiled: Compiled, request: Request, options: Options) -> tuple[Carried | None, list[Diagnostic]]:
    """Return the description that a package with these options carries, if any, or what cannot be carried."""
    if not options.at_launch or compiled.robot is None:
        return None, []
    modes = spelt_statics(compiled.robot, [argument.name for argument in ARGUMENTS]).modes
    return carry(compiled, request, options.name, modes.values())


def carry(
    compiled: Compiled, request: Request, package: str, modes: Iterable[str]
) -> tuple[Carried | None, list[Diagnostic]]:
    """Return the description as a package carries it, or the errors about what cannot be carried.

    The arguments of the request become the defaults at launch; ``modes`` are names of launch arguments in use.
    Raises LoadError.
    """
    from rosorin_compile.language.arguments import declared

    main = next((one for one in compiled.artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if main is None:
        return None, []  # a package without a URDF is refused anyway
    statics = next((one.output for one in compiled.artifacts if one.backend == STATICS), STATICS)
    path, values = request.description.path, request.values()
    packages = {**compiled.packages, **request.packages}
    places, problems = _places(compiled, path, packages)
    problems += _unfindable(main, package, places)
    if problems:
        return None, problems
    files = {place: read_bytes(file) for file, place in places.items()}
    taken = [*(argument.name for argument in ARGUMENTS), *modes, WORDS]
    passed = tuple(_passed(declared(path, values)[0], values, taken))
    read = [
        name
        for name, folder in packages.items()
        if str(folder) in main.text or any(_spelled(f).is_relative_to(folder) for f in compiled.files_read)
    ]
    needs = tuple(sorted(name for name in read if is_legal(name) and name != package))
    return Carried(places[_spelled(path)], files, passed, main.output, statics, needs), []


def _spelled(path: Path) -> Path:
    return Path(os.path.abspath(path))


def _places(compiled: Compiled, path: Path, packages: Mapping[str, Path]) -> tuple[dict[Path, str], list[Diagnostic]]:
    python = compiled.python_packages
    elsewhere = [tool_folders()["parts_library"], *python, *map(_spelled, packages.values())]
    inputs = [_spelled(one) for one in compiled.files_read]
    own = [one for one in inputs if not any(map(one.is_relative_to, elsewhere))]
    top, prefix = _top(_spelled(path), own)
    outside = [one for one in own if not one.is_relative_to(top)]
    problems = [
        report(
            "package-not-carried",
            f"{one} is read, and is outside the project {top}: no package can carry it",
            _named_in(one.name, own),
        )
        for one in outside
    ]
    return {one: f"{prefix}{one.relative_to(top).as_posix()}" for one in own if one not in outside}, problems


def _top(first: Path, files: Sequence[Path]) -> tuple[Path, str]:
    """Return the folder whose files stand below ``descriptions`` in a package, and what comes before their names.

    It is ``descriptions`` of the project, if that has them all, else the project; for a lone description its folder.
    """
    folder = next((one for one in (first.parent, *first.parent.parents) if one.name == Description.FOLDER), None)
    if folder is None:
        name = first.parent.name
        return first.parent, f"{Description.FOLDER}/{name if name.isprintable() and name.strip('.') else 'robot'}/"
    return (folder if all(one.is_relative_to(folder) for one in files) else folder.parent), f"{Description.FOLDER}/"


def _named_in(name: str, files: Iterable[Path]) -> Span | None:
    for file in files:
        if file.suffix in Description.ENDINGS:
            source = Source(str(file), read_bytes(file).decode("utf-8", "replace"))
            for number, line in enumerate(source.text.splitlines(), 1):
                if name in line:
                    return Span(source, number, line.index(name) + 1, len(name))
    return None


def _unfindable(main: Artifact, package: str, places: Iterable[Path]) -> Iterator[Diagnostic]:
    files = list(places)
    for name in named(main.text):
        if "://" not in name and not name.startswith("/"):
            message = f"mesh {name} is named by a path, and a URDF that is compiled at launch is in no folder"
            inside = name if name.startswith("meshes/") else f"meshes/{name.rpartition('/')[2]}"
            help = f"write package://{package}/{inside} in the description; the file is copied into the package"
            yield report("package-not-carried", message, _named_in(name, files), help)


def _passed(found: Sequence[Argument], values: Mapping[str, Any], taken: Iterable[str]) -> Iterator[Passed]:
    names = free_names([one.name for one in found], taken, "arg_")
    for one in found:
        own = None if one.required else _plain(one.default)
        default = own if one.required or one.name not in values else _text_of(one, values[one.name])
        choices = [_plain(text) for text in one.allowed]
        if default is not None and choices and default not in choices:
            choices.append(default)
        cut = any(text.endswith(_CUT) for text in choices)
        help = one.help or f"the argument {one.name} of the description"
        if names[one.name] != one.name:
            help = f"{help} ({one.name} of the description)" if one.help else help
        argument = LaunchArgument(names[one.name], default, help, () if cut else tuple(choices))
        simple = _is_simple(one) and not any(letter in (default or "") for letter in '"\\\n')
        yield Passed(one.name, argument, own, simple)


def _is_simple(argument: Argument) -> bool:
    written = argument.default
    quoted = written[:1] in ("'", '"') and argument.type == "text"
    return argument.required or bool(_SIMPLE.fullmatch(_plain(written) if quoted else written))


def _plain(written: str) -> str:
    if written[:1] not in ("'", '"'):
        return written
    try:
        value = yaml_of(written)
    except ValueError:  # it is shown shortened
        return written
    return value if isinstance(value, str) else written


def _text_of(argument: Argument, value: Any) -> str:
    return value if isinstance(value, str) else _plain(argument.value)


def proven(carried: Carried, compiled: Compiled, request: Request, there: Path, package: str) -> list[Diagnostic]:
    """Return why the description of a package in the folder ``there`` does not compile as it did.

    It has to say the same to the byte, and to read nothing outside.
    """
    packages = {**compiled.packages, **request.packages, package: there}
    copy = Description(package, there / carried.description, there / Description.OUTPUTS)
    again = replace(request, description=copy, packages=packages, trust=True).compile((carried.urdf,))
    wrong = [one for one in again.diagnostics if one.severity == "error"]
    if wrong:
        message = f"the description does not compile from the package: {wrong[0].message}"
        return [report("package-not-carried", message, _moved(wrong[0].span, carried, compiled, there), wrong[0].help)]
    before = {one.output: one.text for one in compiled.artifacts}
    if any(one.text != before[one.output] for one in again.artifacts):
        message = f"the description says something else from the package: {carried.urdf} is another one"
        return [report("package-not-carried", message, None, "it may read files by a path that depends on its folder")]
    python = again.python_packages
    allowed = [resolve(one) for one in (tool_folders()["parts_library"], *packages.values(), *python)]
    strays = [one for one in again.files_read if not any(map(resolve(one).is_relative_to, allowed))]
    if strays:
        message = f"from the package the description still reads {first_of([str(one) for one in strays], 3)}"
        span = _named_in(strays[0].name, [_spelled(one) for one in compiled.files_read])
        return [report("package-not-carried", message, span, "name it relative to the file that reads it")]
    return []


def _moved(span: Span | None, carried: Carried, compiled: Compiled, there: Path) -> Span | None:
    """Return a place in the copy of a file as one in the file itself."""
    if span is None:
        return None
    data = carried.files.get(os.path.relpath(resolve(span.source.path), resolve(there)))
    file = next((one for one in compiled.files_read if read_bytes(one) == data), None)
    return None if file is None else span._replace(source=Source(str(file), span.source.text))

"""Write a ROS 2 package: compile a robot, decide on the options, and put the files into a folder."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from rosorin_compile.formats.compiled import Compiled
from rosorin_compile.output import OutputError, PackageFolder, open_package_folder
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, has_errors

from .carrying import Carried, described, proven
from .deploy_plan import kept, protected_files, refused, told_before
from .naming import OF_A_NAME, STARTS, is_legal, package_name
from .package import BUILD_TYPES, Options, make
from .papers import left_alone

_PERSON = re.compile(r"\s*([^<>]+?)\s*<\s*([^<>\s@]+@[^<>\s@]+\.[^<>\s@]+)\s*>\s*")
_VERSION = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)")
_ADDRESS = re.compile(r"https?://[^\s<>\"']+")
_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


@dataclass(frozen=True)
class PackageOptions:
    """The options of a package, named as those of ``rosorin-compile package``; None leaves one as it was.

    ``starts`` says what the package starts besides the publishers: control, moveit, nav2.
    """

    name: str | None = None
    build_type: str | None = None
    version: str | None = None
    maintainer: str | None = None
    license: str | None = None
    url: str | None = None
    compile_at_launch: bool | None = None
    starts: Mapping[str, bool | None] = field(default_factory=dict)
    topics: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class WrittenPackage:
    """A ROS 2 package."""

    package: str
    folder: str
    files: Annotated[tuple[str, ...], "all files of it, as seen from the folder"] = ()
    written: Annotated[tuple[str, ...], "those that are new or others than before"] = ()
    inputs: Annotated[tuple[str, ...], "the files that the robot was compiled from"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def write_package(request: Request, folder: Path, options: PackageOptions) -> WrittenPackage:
    """Compile a robot and write its package, unless an error is found. Raises RequestError."""
    compiled = request.compile()
    result = WrittenPackage("", str(folder), inputs=tuple(map(str, request.inputs(compiled))))
    diagnostics = [*compiled.diagnostics]
    if compiled.robot is not None and not has_errors(diagnostics):
        try:
            with open_package_folder(folder) as target:
                asked = _options(options, folder, compiled.robot.name, [one.name for one in compiled.robot.sensors])
                result = _write(request, compiled, folder, asked, target, result, diagnostics)
        except OutputError as problem:
            diagnostics.append(problem.diagnostic)
    return replace(result, diagnostics=tuple(diagnostics))


def _write(
    request: Request,
    compiled: Compiled,
    folder: Path,
    options: Options,
    target: PackageFolder,
    result: WrittenPackage,
    diagnostics: list[Diagnostic],
) -> WrittenPackage:
    """Write a package, unless it would replace something; add to the diagnostics. Raises OutputError."""
    if compiled.robot is None:
        return result
    carried, wrong = described(compiled, request, options)
    sources = [request.description.path.parent, request.description.outputs]
    package = make(compiled.robot, compiled.artifacts, options, sources, folder, compiled, carried)
    if carried is not None and package.files:
        wrong = _proven(carried, compiled, request, package.files, options.name)
    problem = refused(folder, package.files)
    diagnostics += [*wrong, *package.diagnostics, *([problem] if problem else [])]
    if wrong or problem or not package.files:
        return result
    left = left_alone(folder, package.files, target.digests())
    ours = {name: data for name, data in package.files.items() if name not in left}
    there = protected_files(folder, ours, target.digests(), own_package=True)
    diagnostics += kept(there)
    written = target.write(ours, {file.kept: file.data for file in there})
    fresh = [name for name in written if name in package.files]
    return replace(result, package=options.name, files=tuple(sorted(package.files)), written=tuple(sorted(fresh)))


def _proven(
    carried: Carried, compiled: Compiled, request: Request, files: Mapping[str, bytes], name: str
) -> list[Diagnostic]:
    """Compile a copy of the description in the package, and return the errors."""
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder, name)
        for place, data in files.items():
            (there / place).parent.mkdir(parents=True, exist_ok=True)
            (there / place).write_bytes(data)
        return proven(carried, compiled, request, there, name)


def _options(options: PackageOptions, folder: Path, robot: str, sensors: list[str]) -> Options:
    """Return the options of the package in a folder with those that are new. Raises RequestError."""
    made = told_before(folder, Options(package_name(robot)), sensors)
    made = replace(made, name=options.name or made.name, build_type=options.build_type or made.build_type)
    if not is_legal(made.name):
        raise RequestError(f'"{made.name}" is no name for a ROS 2 package: {OF_A_NAME}')
    if options.build_type not in (None, *BUILD_TYPES):
        raise RequestError(f'"{options.build_type}" is no build type: {" or ".join(BUILD_TYPES)}')
    if options.version is not None:
        if not _VERSION.fullmatch(options.version):
            message = f'"{options.version}" is no version of a ROS 2 package, which has three numbers: 1.2.3'
            raise RequestError(message)
        made = replace(made, version=options.version)
    if options.maintainer is not None:
        person = _PERSON.fullmatch(options.maintainer)
        if person is None or not options.maintainer.isprintable():
            raise RequestError(f"\"{options.maintainer}\" is not a name and an address: --maintainer 'NAME <MAIL>'")
        made = replace(made, maintainer=person[1], email=person[2])
    if options.license is not None:
        if not options.license.strip() or not options.license.isprintable():
            raise RequestError("the license is one line of text")
        made = replace(made, license=options.license.strip())
    if options.url is not None:
        if not _ADDRESS.fullmatch(options.url) or not options.url.isprintable():
            raise RequestError(f'"{options.url}" is no address of a page: https://example.org/robot')
        made = replace(made, url=options.url)
    if options.compile_at_launch is not None:
        made = replace(made, at_launch=options.compile_at_launch)
    switches = {word: options.starts.get(word) for word in STARTS}
    starts = tuple(word for word, on in switches.items() if (word in made.starts if on is None else on))
    _check_topics(options.topics, sensors)
    return replace(made, starts=starts, topics={**made.topics, **options.topics})


def _check_topics(topics: Mapping[str, str], sensors: Iterable[str]) -> None:
    """Raise RequestError for a name that is no topic, or a sensor that the robot does not have."""
    for sensor, topic in topics.items():
        if not _TOPIC.fullmatch(topic):
            raise RequestError(f'"{sensor}={topic}" is not SENSOR=TOPIC, such as laser=/scan')
        if sensor not in sensors:
            raise RequestError(f'the robot has no sensor "{sensor}"; it has {", ".join(sensors) or "none"}')

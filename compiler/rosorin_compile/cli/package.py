"""rosorin-compile package: write a ROS 2 package that is ready to build."""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.ros.package.naming import CONTROL, MOVEIT, NAV2, STARTS
from rosorin_compile.source.diagnostics import Console

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosorin_compile.output import PackageFolder
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.ros.package.carrying import Carried
    from rosorin_compile.ros.package.package import Options
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.project import Description

    from .given import Given
    from .parser import Parser

_HOW = "rosorin-compile package ROBOT -o FOLDER"
_PERSON = re.compile(r"\s*([^<>]+?)\s*<\s*([^<>\s@]+@[^<>\s@]+\.[^<>\s@]+)\s*>\s*")
_VERSION = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)")
_ADDRESS = re.compile(r"https?://[^\s<>\"']+")
_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument("-o", "--output", required=True, type="path", metavar="FOLDER", help="folder of the package")
    command.add_argument("--name", metavar="NAME", help="name of the package; default: ROBOT_description")
    command.add_argument(
        "--build-type", choices=("ament_cmake", "ament_python"), help="build type of the package; default: ament_cmake"
    )
    command.add_argument("--package-version", metavar="X.Y.Z", help="version of the package; default: 0.1.0")
    command.add_argument("--maintainer", metavar="'NAME <MAIL>'", help="maintainer of the package")
    command.add_argument("--license", metavar="SPDX", help="license of the package, such as Apache-2.0")
    command.add_argument("--url", metavar="URL", help="website of the package")
    command.add_argument(
        "--topic",
        action="append",
        default=[],
        dest="topics",
        metavar="SENSOR=TOPIC",
        help="topic of a sensor, for the RViz configuration; repeatable",
    )
    command.add_argument(
        "--compile-at-launch",
        action=argparse.BooleanOptionalAction,
        help="compile the description at launch, with its arguments as launch arguments",
    )
    for word, what in (
        (CONTROL, "the controller_manager and the controllers"),
        (MOVEIT, "MoveIt"),
        (NAV2, "Nav2 and robot_localization"),
    ):
        help = f"add a launch file that starts {what} with the parameters of the robot"
        command.add_argument(f"--{word}", action=argparse.BooleanOptionalAction, help=help)
    command.add_messages()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Compile a robot and write its package."""
    from rosorin_compile.output import OutputError, open_package_folder

    run, description = Run.alone(options, "a package is for one robot", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    compiled = run.compiled(description)
    code = PROBLEMS
    if compiled is not None and compiled.robot is not None:
        robot = compiled.robot
        try:
            with open_package_folder(Path(options.output)) as folder:
                asked = _asked(options, robot.name, [sensor.name for sensor in robot.sensors])
                code = _write(options, console, asked, compiled, run.given, description, Path(options.output), folder)
        except OutputError as problem:
            console.show([problem.diagnostic])
    console.finish()
    return code


def _write(
    options: argparse.Namespace,
    console: Console,
    asked: Options,
    compiled: Compiled,
    given: Given,
    description: Description,
    target: Path,
    folder: PackageFolder,
) -> int:
    """Write a package, unless it would write over something; return the exit code. Raises OutputError."""
    from rosorin_compile.ros.package.carrying import described
    from rosorin_compile.ros.package.deploying import kept, protected_files, refused
    from rosorin_compile.ros.package.package import make
    from rosorin_compile.ros.package.papers import left_alone

    robot, artifacts, sources = compiled.robot, compiled.artifacts, [description.path.parent, description.outputs]
    if robot is None:
        return PROBLEMS
    carried, wrong = described(compiled, description, given, asked)
    package = make(robot, artifacts, asked, sources, target, compiled, carried)
    if carried is not None and package.files:
        wrong = _proven(carried, compiled, given, package.files, asked.name)
    problem = refused(target, package.files)
    console.show([*wrong, *package.diagnostics, *([problem] if problem else [])])
    if wrong or problem or not package.files:
        return PROBLEMS
    left = left_alone(target, package.files, folder.digests())
    ours = {name: data for name, data in package.files.items() if name not in left}
    there = protected_files(target, ours, folder.digests(), own_package=True)
    console.show(list(kept(there)))
    written = folder.write(ours, {file.kept: file.data for file in there})
    fresh = [name for name in written if name in package.files]
    summary = f"{len(fresh)} written" if fresh else "unchanged"
    console.say(f"{asked.name}: {len(package.files)} files in {target}, {summary}")
    result = {"package": asked.name, "folder": str(target), "files": sorted(package.files), "written": sorted(fresh)}
    give_result(options, result, str)
    return FINE


def _proven(
    carried: Carried, compiled: Compiled, given: Given, files: Mapping[str, bytes], name: str
) -> list[Diagnostic]:
    """Return why the description would not compile from the package: a copy of it is tried."""
    import tempfile

    from rosorin_compile.ros.package.carrying import proven

    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder, name)
        for place, data in files.items():
            (there / place).parent.mkdir(parents=True, exist_ok=True)
            (there / place).write_bytes(data)
        return proven(carried, compiled, given, there, name)


def _asked(options: argparse.Namespace, robot: str, sensors: list[str]) -> Options:
    """Return what the command line says of the package, and what it was told before. Raises WrongUsage."""
    from rosorin_compile.ros.package.deploying import told_before
    from rosorin_compile.ros.package.naming import OF_A_NAME, is_legal, package_name
    from rosorin_compile.ros.package.package import Options

    asked = told_before(Path(options.output), Options(package_name(robot)), sensors)
    asked = replace(asked, name=options.name or asked.name, build_type=options.build_type or asked.build_type)
    if not is_legal(asked.name):
        raise WrongUsage(f'"{asked.name}" is no name for a ROS 2 package: {OF_A_NAME}')
    if options.package_version is not None:
        if not _VERSION.fullmatch(options.package_version):
            message = f'"{options.package_version}" is no version of a ROS 2 package, which has three numbers: 1.2.3'
            raise WrongUsage(message)
        asked = replace(asked, version=options.package_version)
    if options.maintainer is not None:
        person = _PERSON.fullmatch(options.maintainer)
        if person is None or not options.maintainer.isprintable():
            raise WrongUsage(f"\"{options.maintainer}\" is not a name and an address: --maintainer 'NAME <MAIL>'")
        asked = replace(asked, maintainer=person[1], email=person[2])
    if options.license is not None:
        asked = replace(asked, license=_line(options.license, "license"))
    if options.url is not None:
        if not _ADDRESS.fullmatch(options.url) or not options.url.isprintable():
            raise WrongUsage(f'"{options.url}" is no address of a page: https://example.org/robot')
        asked = replace(asked, url=options.url)
    if options.compile_at_launch is not None:
        asked = replace(asked, at_launch=options.compile_at_launch)
    said = {word: getattr(options, word) for word in STARTS}
    starts = tuple(word for word, on in said.items() if (word in asked.starts if on is None else on))
    asked = replace(asked, starts=starts)
    return replace(asked, topics={**asked.topics, **_topics(options.topics, sensors)})


def _topics(texts: list[str], sensors: list[str]) -> dict[str, str]:
    """Return topics by sensor. Raises WrongUsage."""
    found = {}
    for text in texts:
        sensor, equals, topic = text.partition("=")
        if not equals or not _TOPIC.fullmatch(topic):
            raise WrongUsage(f'"{text}" is not SENSOR=TOPIC, such as laser=/scan')
        if sensor not in sensors:
            raise WrongUsage(f'the robot has no sensor "{sensor}"; it has {", ".join(sensors) or "none"}')
        found[sensor] = topic
    return found


def _line(text: str, what: str) -> str:
    if not text.strip() or not text.isprintable():
        raise WrongUsage(f"the {what} is one line of text")
    return text.strip()

"""rosorin-compile package: write a ROS 2 package that is ready to build."""

from __future__ import annotations

from typing import Any

import click

from rosorin_compile.ros.package.naming import CONTROL, MOVEIT, NAV2
from rosorin_compile.source.diagnostics import has_errors

from .answer import give_result
from .command import Options, command, option
from .options import PATH, Decorator, robot_argument, robot_options
from .run import Run, nothing_written
from .usage import FINE, PROBLEMS, WrongUsage

_HOW = "rosorin-compile package ROBOT -o FOLDER"


def _launch(name: str, started: str) -> Decorator[Any]:
    """Return an option that adds a launch file."""
    text = f"add a launch file that starts {started} with the parameters of the robot"
    return option(f"--{name}/--no-{name}", default=None, help=text)


@command("package", exits="0 written or unchanged, 1 errors")
@robot_argument
@option("-o", "--output", required=True, type=PATH, metavar="FOLDER", help="folder of the package")
@option("--name", metavar="NAME", help="name of the package; default: ROBOT_description")
@option(
    "--build-type",
    type=click.Choice(("ament_cmake", "ament_python")),
    help="build type of the package; default: ament_cmake",
)
@option("--package-version", metavar="X.Y.Z", help="version of the package; default: 0.1.0")
@option("--maintainer", metavar="'NAME <MAIL>'", help="maintainer of the package")
@option("--license", metavar="SPDX", help="license of the package, such as Apache-2.0")
@option("--url", metavar="URL", help="website of the package")
@option(
    "--topic",
    "topics",
    multiple=True,
    metavar="SENSOR=TOPIC",
    help="topic of a sensor, for the RViz configuration; repeatable",
)
@option(
    "--compile-at-launch/--no-compile-at-launch",
    default=None,
    help="compile the description at launch, with its arguments as launch arguments",
)
@_launch(CONTROL, "the controller_manager and the controllers")
@_launch(MOVEIT, "MoveIt")
@_launch(NAV2, "Nav2 and robot_localization")
@robot_options
def run(options: Options) -> int:
    """Write the package of a robot, and print what became of it."""
    from rosorin_compile.api import package

    run, description = Run.alone(options, "a package is for one robot", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    result = package(
        run.request(description),
        options.output,
        name=options.name,
        build_type=options.build_type,
        version=options.package_version,
        maintainer=options.maintainer,
        license=options.license,
        url=options.url,
        topics=_topics(options.topics),
        compile_at_launch=options.compile_at_launch,
        control=options.control,
        moveit=options.moveit,
        nav2=options.nav2,
    )
    console.tell_read(result.inputs)
    console.show(result.diagnostics)
    if result.package:
        written = f"{len(result.written)} written" if result.written else "unchanged"
        console.say(f"{result.package}: {len(result.files)} files in {result.folder}, {written}")
        give_result(options, result, str)
    else:
        nothing_written(run.console, description.name, result.diagnostics)
    console.finish()
    return PROBLEMS if has_errors(result.diagnostics) or not result.package else FINE


def _topics(texts: list[str]) -> dict[str, str]:
    """Return topics by sensor. Raises WrongUsage."""
    found = {}
    for text in texts:
        sensor, equals, topic = text.partition("=")
        if not equals:
            raise WrongUsage(f'"{text}" is not SENSOR=TOPIC, such as laser=/scan')
        found[sensor] = topic
    return found

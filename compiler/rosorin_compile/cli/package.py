"""rosorin-compile package: write a ROS 2 package that is ready to build."""

from __future__ import annotations

from typing import Any

from rosorin_compile.ros.package.options import CONTROL, MOVEIT, NAV2

from .answer import FINE, PROBLEMS
from .command import Decorator, Options, choice, command, option, path_option, robot_argument, robot_options, texts
from .run import Run, assignments, nothing_written

_HOW = "rosorin-compile package ROBOT -o FOLDER"


def _launch(name: str, started: str) -> Decorator[Any]:
    """Return an option that adds a launch file."""
    text = f"add a launch file that starts {started} with the parameters of the robot"
    return option(f"--{name}/--no-{name}", default=None, help=text)


@command("package", exits="0 written or unchanged, 1 errors")
@robot_argument
@path_option("-o", "--output", required=True, metavar="FOLDER", help="folder of the package")
@option("--name", metavar="NAME", help="name of the package; default: ROBOT_description")
@choice("--build-type", ("ament_cmake", "ament_python"), help="build type of the package; default: ament_cmake")
@option("--package-version", metavar="X.Y.Z", help="version of the package; default: 0.1.0")
@option("--maintainer", metavar="'NAME <MAIL>'", help="maintainer of the package")
@option("--license", metavar="SPDX", help="license of the package, such as Apache-2.0")
@option("--url", metavar="URL", help="website of the package")
@texts("--topic", "topics", metavar="SENSOR=TOPIC", help="topic of a sensor, for the RViz configuration; repeatable")
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
    """Write the package of a robot, and print the result."""
    from rosorin_compile import api

    run, description = Run.alone(options, "a package is for one robot", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    result = api.package(
        run.request(description),
        options.output,
        **options.pick("name build_type maintainer license url compile_at_launch control moveit nav2"),
        version=options.package_version,
        topics=assignments(options.topics, "SENSOR=TOPIC, such as laser=/scan"),
    )
    console.tell_read(result.inputs)
    failed = run.show(result)
    if result.package:
        written = f"{len(result.written)} written" if result.written else "unchanged"
        console.say(f"{result.package}: {len(result.files)} files in {result.folder}, {written}")
        run.give(result)
    else:
        nothing_written(console, description.name, result.diagnostics)
    console.finish()
    return PROBLEMS if failed or not result.package else FINE

"""rosorin-compile package: write a ROS 2 package that is ready to build."""

from rosorin_compile.ros.package.package import package

from .command import Options, combined, command, option, repeatable, robot_argument, robot_options
from .console import FINE, PROBLEMS
from .run import Run

_AT_LAUNCH = "compile the description at launch, with its arguments as launch arguments"
_STARTS = "add a launch file that starts {} with the parameters of the robot"
_STARTED = {"control": "the controller_manager and the controllers", "moveit": "MoveIt"}
_STARTED["nav2"] = "Nav2 and robot_localization"


@command("package", exits="0 written or unchanged, 1 errors")
@robot_argument
@option("-o", "--output FOLDER", required=True, help="folder of the package")
@option("--name NAME", help="name of the package; default: ROBOT_description")
@option("--build-type ament_cmake|ament_python", help="build type of the package; default: ament_cmake")
@option("--package-version X.Y.Z", "version", help="version of the package; default: 0.1.0")
@option("--maintainer 'NAME <MAIL>'", help="maintainer of the package")
@option("--license SPDX", help="license of the package, such as Apache-2.0")
@option("--url URL", help="website of the package")
@repeatable("--topic SENSOR=TOPIC", "topics", help="topic of a sensor, for the RViz configuration; repeatable")
@option("--compile-at-launch/--no-compile-at-launch", default=None, help=_AT_LAUNCH)
@combined(*(option(f"--{name}/--no-{name}", default=None, help=_STARTS.format(it)) for name, it in _STARTED.items()))
@robot_options
def run(options: Options) -> int:
    """Write the package of a robot, and print the result."""
    run, description = Run.alone(options, stdin=False)
    console = run.console
    console.begin(description.name)
    result = package(
        run.request(description),
        options.output,
        **options.pick("name build_type version maintainer license url topics compile_at_launch control moveit nav2"),
    )
    console.print_read(result.inputs)
    failed = run.show(result)
    if not result.package:
        run.nothing_written(description, result.diagnostics)
        return PROBLEMS
    written = f"{len(result.written)} written" if result.written else "unchanged"
    console.say(f"{result.package}: {len(result.files)} files in {result.folder}, {written}")
    run.give(result)
    return PROBLEMS if failed else FINE

"""rosorin-compile package, deploy, check deployed and check parameters: artifacts and parameter files of ROS 2."""

import re
from pathlib import Path

from rosorin_compile.formats.format import DISTRIBUTIONS
from rosorin_compile.request import is_foreign
from rosorin_compile.ros.check_parameters.check import check_parameters, summary
from rosorin_compile.ros.package.deploy import check_deployed, deploy
from rosorin_compile.ros.package.package import package
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, error
from rosorin_compile.source.project import Description

from . import command as cli
from .console import FINE, PROBLEMS
from .run import Run, for_each

_AT_LAUNCH = "compile the description at launch, with its arguments as launch arguments"
_LAUNCHED = {"control": "controller_manager and controllers", "moveit": "MoveIt", "nav2": "Nav2 and robot_localization"}
_LAUNCH = "add a launch file for "
_PLACES = "path of an output in FOLDER, such as urdf=urdf/robot.urdf, or none to skip it"


@cli.command("package", exits="0 written or unchanged, 1 errors")
@cli.robot_argument
@cli.option("-o", "--output FOLDER", required=True, help="folder of the package")
@cli.option("--name NAME", help="name of the package; default: ROBOT_description")
@cli.option("--build-type ament_cmake|ament_python", help="build type of the package; default: ament_cmake")
@cli.option("--package-version X.Y.Z", "version", help="version of the package; default: 0.1.0")
@cli.option("--maintainer 'NAME <MAIL>'", help="maintainer of the package")
@cli.option("--license SPDX", help="license of the package, such as Apache-2.0")
@cli.option("--url URL", help="website of the package")
@cli.option("--compile-at-launch/--no-compile-at-launch", default=None, help=_AT_LAUNCH)
@cli.combine(*(cli.option(f"--{one}/--no-{one}", default=None, help=_LAUNCH + it) for one, it in _LAUNCHED.items()))
@cli.robot_options
def run_package(run: Run) -> int:
    """Write the package of a robot, and print the result."""
    description = run.only_robot(stdin=False)
    settings = "name build_type version maintainer license url compile_at_launch control moveit nav2"
    result = package(run.request(description), run.output, **run.pick(settings))
    failed = run.show(result)
    if not result.package:
        return max(PROBLEMS, run.nothing_written(description, result.diagnostics))
    written = f"{len(result.written)} written" if result.written else "unchanged"
    run.console.say(f"{result.package}: {len(result.files)} files in {result.folder}, {written}")
    return max(run.give(result), PROBLEMS if failed else FINE)


@cli.command("deploy", exits="0 written or unchanged, 1 errors or, with --dry-run, a file would change")
@cli.robot_argument
@cli.option("-o", "--output FOLDER", required=True, help="existing package or folder")
@cli.repeatable("--map OUTPUT=PLACE", "places", help=_PLACES, offers="output=")
@cli.dry_run_option
@cli.full_option
@cli.robot_options
def run_deploy(run: Run) -> int:
    """Deploy the artifacts of a robot, and print the changes."""
    description, console = run.only_robot(stdin=False), run.console
    result = deploy(run.request(description), run.output, **run.pick("places dry_run full"))
    failed = run.show(result)
    if not result.robot:
        return max(PROBLEMS, run.nothing_written(description, result.diagnostics))
    if result.changes:
        changes = "\n".join(result.changes)
        print(changes) if console.for_people else console.show([Diagnostic("deploy-changes", NOTE, changes)])
    same, total = sum(copy.same for copy in result.copies), len(result.copies)
    done = "written" if result.written else "would be written"
    console.say(f"{result.robot}: {total - same} of {total} files in {result.folder} {done}")
    return max(run.give(result), PROBLEMS if failed or (run.dry_run and same < total) else FINE)


@cli.check("deployed", exits="0 no differences, 1 differences or errors")
@cli.check_options("[ROBOT] FOLDER", "the robot, required if there are several, and a package, install space or folder")
@cli.full_option
def run_check_deployed(run: Run) -> int:
    """Compare the deployed copies in a folder with the compiled artifacts."""
    if not run.words:
        raise RequestError("there is no folder to look into: rosorin-compile check deployed ROBOT FOLDER")
    *robots, folder = run.words
    if not files.is_folder(folder):
        raise RequestError(f'there is no folder "{folder}"')

    def check_robot(run: Run, description: Description) -> int:
        result = check_deployed(run.request(description), folder, full=run.full)
        if result.differing:
            help = "run rosorin-compile deploy to write them again"
            found = error("deployed-differs", "\n".join(result.lines), None, help)
            run.console.differ("not as deployed", result.lines, found)
        failed = run.show(result)
        if not result.robot:
            return max(PROBLEMS, run.nothing_written(description, result.diagnostics))
        total = len(result.same) + len(result.differing)
        run.console.say(f"{description.name}: {len(result.same)} of {total} copies in {folder} as compiled")
        return PROBLEMS if result.differing or failed else FINE

    return for_each(run, check_robot, "ROBOT FOLDER", robots)


_USAGE = "ROBOT FILE ..."
_DESCRIPTION = re.compile(r"""^["']?robot["']?[ \t]*:[ \t]*[^\s#{]""", re.MULTILINE)
_MAX_BYTES = 1_000_000  # number of bytes at the beginning of a file that are searched


@cli.check("parameters", exits="0 no errors, 1 errors")
@cli.check_options("[ROBOT] FILE ...", "the robot, required if there are several, and parameter files of its nodes")
@cli.repeatable("--controllers FILE", help="parameter file of a controller_manager; repeatable")
@cli.repeatable("--launch FILE", help="launch file to read remappings from; repeatable")
@cli.repeatable("--remap NODE:FROM:=TO", type=str, help="add a remapping")
@cli.option("--namespace NS", default="", help="namespace of the nodes")
@cli.option(f"--distribution {'|'.join(DISTRIBUTIONS)}", help="ROS 2 distribution; default: that of the outputs")
def run_check_parameters(run: Run) -> int:
    """Check the parameter files against the robot."""
    has_robot = bool(run.words) and _is_robot(run.words[0])
    robots, parameters = run.words[:has_robot], run.words[has_robot:]
    if not parameters and not run.controllers:
        raise RequestError(f"there is no parameter file to check: rosorin-compile check parameters {_USAGE}")

    def check_robot(run: Run, description: Description) -> int:
        picked = run.pick("controllers launch namespace distribution")
        result = check_parameters(run.request(description), parameters, **picked, remaps=run.remap)
        failed = run.show(result)
        if not result.robot:
            return PROBLEMS
        run.console.say(f"{description.name}: {summary(result)}")
        return PROBLEMS if failed else FINE

    return for_each(run, check_robot, _USAGE, robots)


def _is_robot(word: str) -> bool:
    if not files.is_file(word) or is_foreign(Path(word)) or Path(word).name == Description.ROOT_FILE:
        return True
    return _DESCRIPTION.search(files.read_bytes(word, _MAX_BYTES).decode("utf-8", "replace")) is not None

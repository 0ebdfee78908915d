"""What this package brings to the command line, and does for others."""

from __future__ import annotations

from rosorin_compile import Check, Command

COMMANDS = (
    Command(
        name="package",
        group="deploy and verify",
        words="[ROBOT] -o FOLDER",
        help="write a ROS 2 package with the artifacts of a robot",
        exits="0 written or unchanged, 1 errors",
        options="package.command:options",
        run="package.command:run",
        order=10,
    ),
    Command(
        name="deploy",
        group="deploy and verify",
        words="[ROBOT] -o FOLDER",
        help="copy the artifacts to an existing ROS 2 package",
        exits="0 written or unchanged, 1 errors or, with --dry-run, a file would change",
        options="package.deploy_command:options",
        run="package.deploy_command:run",
        order=20,
    ),
)
CHECKS = (
    Check(
        name="parameters",
        words="[ROBOT] FILE ...",
        help="check parameter files of ROS nodes: frames and publishers",
        exits="0 no errors, 1 errors",
        options="check_parameters.command:options",
        run="check_parameters.command:run",
    ),
    Check(
        name="deployed",
        words="[ROBOT] FOLDER",
        help="compare with copies in a package, an install space or another folder",
        exits="0 no differences, 1 differences or errors",
        options="package.deployed_command:options",
        run="package.deployed_command:run",
    ),
)
SERVICES = {
    "planning of MoveIt": "package.bringup:planning_of",
    "package around a folder": "package.finding:package_of",
    "files below a folder": "package.finding:files_below",
    "files that are not installed": "package.installing:missing",
    "is a launch file": "package.launch_files:is_launch_file",
}

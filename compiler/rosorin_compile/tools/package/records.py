"""What this package brings to the command line."""

from __future__ import annotations

from rosorin_compile import Check, Command

COMMANDS = (
    Command(
        name="package",
        group="run on the robot",
        words="[ROBOT] -o FOLDER",
        help="write a ROS 2 package that is ready to build",
        exits="0 written or unchanged, 1 errors",
        options="command:options",
        run="command:run",
        order=10,
    ),
    Command(
        name="deploy",
        group="run on the robot",
        words="[ROBOT] -o FOLDER",
        help="write the artifacts into a ROS 2 package that you have",
        exits="0 written or unchanged, 1 errors; with --dry-run also 1 something would change",
        options="deploy_command:options",
        run="deploy_command:run",
        order=20,
    ),
)
SERVICES = {
    "planning of MoveIt": "bringup:planning_of",
    "package around a folder": "finding:package_of",
    "files below a folder": "finding:files_below",
    "files that are not installed": "installing:missing",
    "is a launch file": "launch_files:is_launch_file",
}
CHECKS = (
    Check(
        name="deployed",
        words="[ROBOT] FOLDER",
        help="compare with the copies in a package, an install space or any folder",
        exits="0 as compiled, 1 differences or errors",
        options="deployed_command:options",
        run="deployed_command:run",
        old=("--deployed",),
    ),
)

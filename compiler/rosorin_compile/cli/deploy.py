"""rosorin-compile deploy: write the artifacts into a ROS 2 package that exists."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Console, Heading, Rule

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.formats.format import Artifact
    from rosorin_compile.model import Robot
    from rosorin_compile.output import PackageFolder
    from rosorin_compile.ros.package.deploying import Plan, ProtectedFile
    from rosorin_compile.source.diagnostics import Diagnostic

    from .parser import Parser

RULES = (
    Rule(
        "deploy-unreadable",
        "The folder cannot be read, or holds more than 50,000 files.",
        "Name the folder of the package.",
        Heading.PACKAGES,
    ),
    Rule("deploy-changes", "A note: what was changed (in the forms for programs).", topic=Heading.PACKAGES),
)

_HOW = "rosorin-compile deploy ROBOT -o FOLDER"


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument("-o", "--output", type="path", metavar="FOLDER", help="existing package or folder")
    command.add_argument(
        "--map",
        action="append",
        default=[],
        metavar="OUTPUT=PLACE",
        help="path of an output in FOLDER, or none to skip it; stored in FOLDER",
    )
    command.add_argument(
        "--install", type="path", metavar="FOLDER", help="install space; default: the one of the workspace, if any"
    )
    command.add_argument("-n", "--dry-run", action="store_true", help="write nothing; print what would change")
    command.add_argument("--full", action="store_true", help="print differences of texts in full")
    command.add_messages()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Compile a robot and put its artifacts into a folder."""
    from rosorin_compile.output import OutputError, open_package_folder
    from rosorin_compile.source.load import LoadError

    if options.output is None:
        raise WrongUsage(f"deploy into which folder? {_HOW}")
    folder = Path(options.output)
    if not files.is_folder(folder):
        raise WrongUsage(f'there is no folder "{folder}"; rosorin-compile package makes a new package')
    run, description = Run.alone(options, "one robot is deployed at a time", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    compiled = run.compiled(description)
    code = PROBLEMS
    if compiled is not None and compiled.robot is not None:
        try:
            with open_package_folder(folder, options.dry_run) as target:
                code = _deploy(options, console, compiled.robot, compiled.artifacts, target)
        except (LoadError, OutputError) as problem:
            console.show([problem.diagnostic])
        except OSError as problem:
            console.show([_unreadable(folder, problem)])
    console.finish()
    return code


def _deploy(
    options: argparse.Namespace, console: Console, robot: Robot, artifacts: tuple[Artifact, ...], target: PackageFolder
) -> int:
    """Put artifacts into a folder; raises LoadError, OutputError, OSError."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.ros.package import naming
    from rosorin_compile.ros.package.checking import launch_files
    from rosorin_compile.ros.package.deploying import afterwards, change_lines, not_ours, plan, protected_files
    from rosorin_compile.ros.package.finding import files_below
    from rosorin_compile.source.diagnostics import has_errors

    folder = Path(options.output)
    files = files_below(folder, skip_built=True)
    wanted = naming.read(folder, robot.name) | _mapped(options.map, artifacts)
    planned = plan(robot, artifacts, folder, files, wanted)
    console.show(planned.diagnostics)
    if has_errors(planned.diagnostics):
        return PROBLEMS
    for copy in planned.copies:
        target.check_name(copy.place)
    there = protected_files(folder, _files(planned), _digests(robot, planned, folder, target))
    found = list(not_ours(planned, there))
    console.show(found)
    if has_errors(found):
        return PROBLEMS
    _tell(console, change_lines(planned.copies, options.full))
    _write(options, console, robot, planned, wanted, there, target)
    rows = [{"file": copy.place, "output": copy.artifact.output, "same": copy.is_same} for copy in planned.copies]
    result = {"robot": robot.name, "folder": str(folder), "written": not options.dry_run, "copies": rows}
    give_result(options, result, str)
    ours = [copy.place for copy in planned.copies if FORMATS[copy.artifact.backend].writing.located]
    problems = list(launch_files(robot, folder, files, ours))
    problems += afterwards(robot, planned, folder, Path(options.install) if options.install else None)
    console.show(problems)
    changes = options.dry_run and any(not copy.is_same for copy in planned.copies)
    return PROBLEMS if changes or has_errors(problems) else FINE


def _files(planned: Plan) -> dict[str, bytes]:
    return {copy.place: copy.artifact.text.encode() for copy in planned.copies}


def _digests(robot: Robot, planned: Plan, folder: Path, target: PackageFolder) -> dict[str, list[str]]:
    """Return the digests of what was written before; a file that names its robot, and is in no manifest, is ours."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.output import digest

    ours = {}
    for copy in planned.copies:
        robot_of = FORMATS[copy.artifact.backend].ros.robot_of
        if copy.old is not None and robot_of is not None and robot_of(folder / copy.place) == robot.name:
            ours[copy.place] = [digest(copy.old)]
    return {**ours, **target.digests()}


def _write(
    options: argparse.Namespace,
    console: Console,
    robot: Robot,
    planned: Plan,
    wanted: dict[str, str],
    there: Sequence[ProtectedFile],
    target: PackageFolder,
) -> None:
    """Write what is planned, or say that nothing is written; raises LoadError, OutputError."""
    from rosorin_compile.ros.package import naming

    folder = Path(options.output)
    same = sum(copy.is_same for copy in planned.copies)
    summary = f"{robot.name}: {len(planned.copies) - same} of {len(planned.copies)} files in {folder}"
    if options.dry_run:
        console.say(f"{summary} would be written")
        return
    unlisted = {file.kept: file.data for file in there}
    if options.map:
        unlisted[naming.FILE] = naming.text(folder, robot.name, wanted).encode()
    target.write(_files(planned), unlisted)
    every = f"all {same} files" if same > 1 else "the one file" if same else "no file"
    console.say(f"{summary} written" if same < len(planned.copies) else f"{robot.name}: {every} as compiled")


def _mapped(texts: list[str], artifacts: tuple[Artifact, ...]) -> dict[str, str]:
    """Return the places of outputs that are told; a folder gets the name of the file. Raises WrongUsage."""
    names = {artifact.output: artifact.file.rpartition("/")[2] for artifact in artifacts}
    found = {}
    for text in texts:
        output, equals, place = text.partition("=")
        if not equals or not place:
            raise WrongUsage(f'"{text}" is not OUTPUT=PLACE, such as urdf=urdf/robot.urdf')
        if output not in names:
            raise WrongUsage(f'the robot has no output "{output}"; it has {", ".join(names)}')
        found[output] = place + names[output] if place.endswith("/") else place
    return found


def _tell(console: Console, lines: list[str]) -> None:
    """Print what changes; a program gets it as a note."""
    from rosorin_compile.source.diagnostics import NOTE, Diagnostic

    if console.for_people:
        for line in lines:
            print(line)
    elif lines:
        console.show([Diagnostic("deploy-changes", NOTE, "\n".join(lines))])


def _unreadable(folder: Path, problem: OSError) -> Diagnostic:
    from rosorin_compile.source.diagnostics import error

    message = f"cannot read {folder}: {problem.strerror or problem}"
    return error("deploy-unreadable", message, None, "name another folder")

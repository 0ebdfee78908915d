"""rosorin-compile import: make a description of a robot that exists as URDF, xacro, SDF or MJCF."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import ERROR, counted, has_errors
from rosorin_compile.source.project import Description

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


def options(command: Parser) -> None:
    """Add what this command takes."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.importing.import_robot import companions

    *others, last = FORMATS.endings(include=True)
    command.add_argument("words", nargs="+", metavar="SOURCE", help=f"a {', '.join(others)} or {last} file")
    command.add_argument(
        "-o",
        "--output",
        type="path",
        metavar="FOLDER",
        help="new folder of the description; default: descriptions/ROBOT",
    )
    command.add_argument(
        "--into",
        type="path",
        metavar="FOLDER",
        help="write the description to the ROS package of SOURCE, with a test that compares both",
    )
    command.add_argument("--name", metavar="NAME", help="name of the robot; default: that of SOURCE")
    command.add_argument("--strict", action="store_true", help="treat unsupported elements as errors")
    command.add_argument("--lenient", action="store_true", help="accept violations of the specification where possible")
    command.add_argument("--no-parts", action="store_true", help="do not factor repeated structures into parts")
    command.add_argument(
        "--verbatim", action="store_true", help="copy the Gazebo and ros2_control elements of a URDF unchanged"
    )
    command.add_argument(
        "--flat", action="store_true", help="import the URDF that a xacro generates, without its macros"
    )
    command.add_argument("--force", action="store_true", help="write to a folder that is not empty")
    command.add_argument(
        "--ours", action="store_true", help="if both SOURCE and the description changed, keep the description"
    )
    command.add_argument(
        "--meshes",
        metavar="FOLDER",
        help="prefix of relative mesh names: a folder relative to the artifacts, or package://NAME",
    )
    for format in companions():
        command.add_argument(
            f"--{format.name}", type="path", metavar="FILE", help=f"also read the {format.word} of the robot"
        )
    command.add_messages()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Import a robot, and print what became of it."""
    from rosorin_compile.api import import_robot
    from rosorin_compile.importing.import_robot import companions

    run = Run.of(options)
    if len(run.words) != 1:
        raise WrongUsage(f"import takes one SOURCE, not {len(run.words) or 'none'}")
    Run.take_stdin(run.words)
    source = Path(run.words[0]) if run.words[0] != Description.STDIN else Description.ON_STDIN
    console = run.console
    console.begin(source.name)
    files = {format.name: getattr(options, format.name) for format in companions()}
    result = import_robot(
        source,
        options.into,
        run.given.as_written(),
        run.given.packages,
        output=options.output,
        name=options.name,
        meshes=options.meshes,
        companions={name: file for name, file in files.items() if file is not None},
        strict=options.strict,
        lenient=options.lenient,
        parts=not options.no_parts,
        verbatim=options.verbatim,
        flat=options.flat,
        force=options.force,
        keep_edits=options.ours,
        trust=options.trust,
        warn=console.ahead,
    )
    console.tell_read(result.inputs)
    console.show(result.diagnostics)
    failed = has_errors(result.diagnostics)
    if failed and not result.written:
        errors = sum(one.severity == ERROR for one in result.diagnostics)
        console.warn(f"{source}: {counted(errors, 'error')}, nothing written")
    for line in result.report:
        console.say(line)
    for line in result.to_do:
        console.say(line, needed=True)
    if not failed and options.into is None:
        console.say(f"next: rosorin-compile all {shlex.quote(result.folder)}")
    if not failed:
        give_result(options, result, str)
    console.finish()
    return PROBLEMS if failed else FINE

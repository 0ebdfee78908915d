"""rosorin-compile import: make a description of a robot that exists as URDF, xacro, SDF or MJCF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosorin_compile.source.diagnostics import ERROR, counted, has_errors
from rosorin_compile.source.project import Description

from .answer import give_result
from .command import Options, combined, command, option
from .options import PATH, Decorator, robot_options, words_argument
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage


def _source() -> Decorator[Any]:
    """Return the argument for the source, with the endings of files that can be imported."""
    from rosorin_compile.formats import FORMATS

    *others, last = FORMATS.endings(include=True)
    return words_argument("SOURCE", f"a {', '.join(others)} or {last} file", required=True, offers=("file", "argument"))


def _companion_options() -> Decorator[Any]:
    """Return an option for each format whose files add to the robot of another file."""
    from rosorin_compile.importing.import_robot import companions

    return combined(
        *(
            option(f"--{one.name}", type=PATH, metavar="FILE", help=f"also read the {one.word} of the robot")
            for one in companions()
        )
    )


@command("import", exits="0 written, 1 the source has errors")
@_source()
@option(
    "-o",
    "--output",
    type=PATH,
    metavar="FOLDER",
    help="new folder of the description; default: descriptions/ROBOT",
)
@option(
    "--into",
    type=PATH,
    metavar="FOLDER",
    help="write the description to the ROS package of SOURCE, with a test that compares both",
)
@option("--name", metavar="NAME", help="name of the robot; default: that of SOURCE")
@option("--strict", is_flag=True, help="treat unsupported elements as errors")
@option("--lenient", is_flag=True, help="accept violations of the specification where possible")
@option("--no-parts", is_flag=True, help="do not factor repeated structures into parts")
@option("--verbatim", is_flag=True, help="copy the Gazebo and ros2_control elements of a URDF unchanged")
@option("--flat", is_flag=True, help="import the URDF that a xacro generates, without its macros")
@option("--force", is_flag=True, help="write to a folder that is not empty")
@option("--ours", is_flag=True, help="if both SOURCE and the description changed, keep the description")
@option(
    "--meshes",
    metavar="FOLDER",
    help="prefix of relative mesh names: a folder relative to the artifacts, or package://NAME",
)
@_companion_options()
@robot_options
def run(options: Options) -> int:
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
    for line in result.next_steps:
        console.say(line)
    if not failed:
        give_result(options, result, str)
    console.finish()
    return PROBLEMS if failed else FINE

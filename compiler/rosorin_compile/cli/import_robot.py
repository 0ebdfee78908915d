"""rosorin-compile import and init: convert an existing robot to a description, or create one from a template."""

from collections.abc import Iterator
from pathlib import Path

import click

from rosorin_compile.formats import FORMATS
from rosorin_compile.importing.import_robot import companions, import_robot
from rosorin_compile.importing.new_robot import DEFAULT, TEMPLATES, NewRobot, init
from rosorin_compile.source.diagnostics import ERROR, RequestError, count_of, error
from rosorin_compile.source.project import Description

from .command import argument, combine, command, flag, option, robot_options, words_argument
from .console import PROBLEMS
from .run import Run, take_stdin

_DRIVES = "servos in the MJCF for a robot without actuators; default: position for joints with limits, else velocity"
_MESHES = "prefix of relative mesh names: a folder relative to the artifacts, or package://NAME"


@command("import", exits="0 written, 1 the source has errors")
@words_argument("SOURCE", f"a {', '.join(FORMATS.endings(include=True))} file", True, ("file", "argument"))
@option("-o", "--output FOLDER", help="new folder of the description; default: descriptions/ROBOT")
@option("--into FOLDER", help="write the description to the ROS package of SOURCE, with a test that compares both")
@option("--name NAME", help="name of the robot; default: that of SOURCE")
@flag("--strict", help="treat unsupported elements as errors")
@flag("--lenient", help="accept violations of the specification where possible")
@flag("--no-parts", help="do not factor repeated structures into parts")
@flag("--verbatim", help="copy the Gazebo and ros2_control elements of a URDF unchanged")
@flag("--flat", help="import the URDF that a xacro generates, without its macros")
@option("--drives position|velocity|none", help=_DRIVES)
@flag("--force", help="write to a folder that is not empty")
@flag("--ours", help="if both SOURCE and the description changed, keep the description")
@option("--meshes FOLDER", type=str, help=_MESHES)
@combine(*(option(f"--{one.name} FILE", help=f"also read the {one.word} of the robot") for one in companions()))
@robot_options
def run_import(run: Run) -> int:
    """Import a robot, and print the result."""
    if len(run.words) != 1:
        raise RequestError(f"import takes one SOURCE, not {len(run.words) or 'none'}")
    take_stdin(run.words)
    source = Path(run.words[0]) if run.words[0] != Description.STDIN else Description.ON_STDIN
    console = run.console
    console.begin(source.name)
    files = {format.name: getattr(run, format.name) for format in companions()}
    result = import_robot(
        source,
        run.into,
        **run.read_options(),
        **run.pick("output name meshes strict lenient verbatim flat drives force"),
        companions={name: file for name, file in files.items() if file is not None},
        parts=not run.no_parts,
        keep_edits=run.ours,
    )
    failed = run.show(result)
    if failed and not result.written:
        errors = sum(one.severity == ERROR for one in result.diagnostics)
        console.warn(f"{source}: {count_of(errors, 'error')}, nothing written")
    for line in (*result.report, *result.to_do, *result.next_steps):
        console.say(line, needed=line in result.to_do)
    return PROBLEMS if failed else run.give(result)


_TEMPLATE = f"one of {', '.join(TEMPLATES)}; default: {DEFAULT}"


@command("init", exits="0 written, 1 the folder cannot be written")
@argument("name", metavar="NAME", help="name of the robot: letters, digits and underscores")
@argument("template", default=DEFAULT, type=click.Choice([*TEMPLATES]), metavar="[TEMPLATE]", help=_TEMPLATE)
@option("-o", "--output FOLDER", default=".", help="folder of the project")
def run_init(run: Run) -> int:
    """Write a new description, and print the next step."""
    try:
        new = init(run.name, run.template, run.output)
    except OSError as problem:
        message = f"cannot write in {run.output}: {problem.strerror or problem}"
        run.console.show([error("output-folder", message, None, "name another folder")])
        return PROBLEMS
    return run.give(new, lambda: "\n".join(_next_steps(run, new)))


def _next_steps(run: Run, new: NewRobot) -> Iterator[str]:
    yield f"{new.description} written: {TEMPLATES[new.template].what}"
    if new.schema_written:
        yield f"{new.schema} written: completion and help in editors"
    elif new.schema_outdated:
        yield f"{new.schema} is of another version; to renew it: rosorin-compile schema > {new.schema}"
    where = "" if Path(run.output).samefile(".") else f"cd {run.output} && "
    yield f"next: {where}rosorin-compile all {run.name}, and rosorin-compile view {run.name} to see it"

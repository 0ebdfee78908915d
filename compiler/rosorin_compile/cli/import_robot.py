"""rosorin-compile import: make a description of a robot that exists as URDF, xacro, SDF or MJCF."""

from pathlib import Path

from rosorin_compile.formats import FORMATS
from rosorin_compile.importing.import_robot import companions, import_robot
from rosorin_compile.source.diagnostics import ERROR, RequestError, count_of
from rosorin_compile.source.project import Description

from .command import combine, command, flag, option, robot_options, words_argument
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
    console.print_read(result.inputs)
    failed = run.show(result)
    if failed and not result.written:
        errors = sum(one.severity == ERROR for one in result.diagnostics)
        console.warn(f"{source}: {count_of(errors, 'error')}, nothing written")
    for line in (*result.report, *result.to_do, *result.next_steps):
        console.say(line, needed=line in result.to_do)
    return PROBLEMS if failed else run.give(result)

"""rosorin-compile print: compile one artifact, and print it and nothing else, for launch files and build rules."""

from pathlib import Path

from rosorin_compile import api
from rosorin_compile.formats import FORMATS
from rosorin_compile.language.arguments import UNKNOWN
from rosorin_compile.output.artifact_set import encode, is_remembered, remember
from rosorin_compile.output.atomic_files import is_generated, may_replace, write_file
from rosorin_compile.source.diagnostics import ERROR, RequestError
from rosorin_compile.source.wording import count_of

from .command import command, depfile_options, flag, option, robot_options, words_argument
from .console import FINE, PROBLEMS, USAGE, give, table
from .run import Run, write_depfile

_CALL = "rosorin-compile print"


@command("print", exits="0 printed, 1 the robot has errors")
@words_argument(
    "[ROBOT] OUTPUT",
    "the robot (name, folder or file; also a URDF, xacro, SDF or MJCF), required if there are several, and the name of "
    "an output or a format such as urdf",
    offers=("robot", "output", "format", "argument"),
)
@option("-o", "--output FILE", help="write to a file instead of standard output")
@flag("--list", help="list the outputs of the robot", excludes="output depfile")
@depfile_options("default: FILE of -o")
@flag("--lenient", help="accept a URDF, xacro, SDF or MJCF that violates its specification, where possible")
@robot_options
def run_print(run: Run) -> int:
    """Print one artifact, or list the outputs."""
    run.console.quiet = not run.verbose
    if run.list:
        return _list(run)
    console, target = run.console, run.depfile_target or run.output
    if run.format != "text":
        raise RequestError("JSON goes with --list: an artifact is printed as it is")
    if run.depfile is not None and target is None:
        raise RequestError("a depfile needs a target: write -o FILE, or --depfile-target NAME")
    words = run.words
    if "" in words:
        raise RequestError("a name is empty: a variable of the shell that is not set?")
    if not 1 <= len(words) <= 2:
        raise RequestError(f"print takes one ROBOT and one OUTPUT, not {len(words)} words; see {_CALL} --list")
    output = words[-1]
    description = run.find_robot("".join(words[:-1]), f"ROBOT {output}")
    request = run.request(description)
    compiled = request.compile((output,), foreign=True, lenient=run.lenient)
    inputs = request.inputs(compiled)
    console.print_read(inputs)
    console.show(compiled.diagnostics)
    console.unlisted.clear()
    if not compiled.artifacts:
        errors = [one.rule for one in compiled.diagnostics if one.severity == ERROR]
        console.warn(f"{description.name}: {count_of(len(errors), 'error')}, nothing printed")
        return USAGE if set(errors) <= {UNKNOWN} else PROBLEMS
    (artifact,) = compiled.artifacts
    data = encode(artifact.file, artifact.text)
    if run.output is not None:
        # Replace a file without the mark of this tool only if this tool wrote it.
        path, robot_of = Path(run.output), FORMATS[artifact.backend].robot_of
        known = is_remembered(path)
        write_file(path, data, inputs, lambda old: known or may_replace(old) or bool(robot_of and robot_of(old)))
        if not is_generated(data):
            remember(path)
    if run.depfile is not None:
        write_depfile(run, target, compiled, inputs, [Path(run.output)] if run.output else [])
    if run.output is None:
        give(artifact.text)
    return FINE


def _list(run: Run) -> int:
    if len(run.words) > 1:
        raise RequestError(f"a list is of one robot: {_CALL} --list ROBOT")
    description = run.find_robot("".join(run.words), "--list ROBOT")
    found = api.outputs(run.request(description))
    if found.outputs is None:
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        run.console.warn(f"{description.name}: a description with errors has no outputs")
        return PROBLEMS
    rows = [{"name": output.name, "format": output.backend, "file": output.file} for output in found.outputs]
    lines = table([("output", "format", "file"), *(tuple(row.values()) for row in rows)])
    if not rows:
        names = ", ".join(format.name for format in FORMATS.values() if format.write is not None)
        lines = [f"{description.name} lists no outputs; print takes the name of a format: {names}"]
    return run.give(rows, lambda: "\n".join(lines))

"""rosorin-compile print: compile one artifact, and print it on standard output and nothing else.

Launch files and build rules call it instead of xacro: without errors nothing is printed on standard error, and nothing
is written beside the file that ``-o`` names.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from rosorin_compile.cli.console import give
from rosorin_compile.language.arguments import UNKNOWN
from rosorin_compile.source.diagnostics import ERROR, RequestError
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import counted, first_of

from .answer import FINE, PROBLEMS, USAGE, table
from .command import Options, command, depfile_options, flag, path_option, robot_options, words_argument
from .run import Run, find_robot, is_robot, refuse_half_marks

_CALL = "rosorin-compile print"
_MAX_NAMES = 20


@command("print", exits="0 printed, 1 the robot has errors")
@words_argument(
    "[ROBOT] OUTPUT",
    "the robot (name, folder or file; also a URDF, xacro, SDF or MJCF), required if there are several, and the name of "
    "an output or a format such as urdf",
    offers=("robot", "output", "format", "argument"),
)
@path_option("-o", "--output", metavar="FILE", help="write to a file instead of standard output")
@flag("--list", help="list the outputs of the robot")
@depfile_options("default: FILE of -o")
@flag("--lenient", help="accept a URDF, xacro, SDF or MJCF that violates its specification, where possible")
@robot_options
def run(options: Options) -> int:
    """Print one artifact, or list the outputs."""
    options.quiet = not options.verbose
    run = Run.of(options)
    if options.list:
        return _list(run)
    words, console, target = run.words, run.console, options.depfile_target or options.output
    if not words:
        raise RequestError(f"print what? {_CALL} [ROBOT] OUTPUT{_outputs_here(run)}")
    if "" in words:
        raise RequestError("a name is empty: a variable of the shell that is not set?")
    if len(words) > 2:
        refuse_half_marks(words)
        raise RequestError(f"print takes one ROBOT and one OUTPUT: {_CALL} {words[0]} {words[1]}")
    if options.format != "text":
        raise RequestError("JSON goes with --list: an artifact is printed as it is")
    if options.depfile is None and options.depfile_target is not None:
        raise RequestError("--depfile-target goes with --depfile FILE")
    if options.depfile is not None and target is None:
        raise RequestError("a depfile needs a target: write -o FILE, or --depfile-target NAME")
    description, output = _requested(words)
    request = run.request(description)
    compiled = request.compile((output,), foreign=True, lenient=options.lenient)
    inputs = request.inputs(compiled)
    console.tell_read(inputs)
    console.show(compiled.diagnostics)
    if not compiled.artifacts:
        errors = [one for one in compiled.diagnostics if one.severity == ERROR]
        unknown = [one for one in errors if one.rule == UNKNOWN]
        if unknown and len(words) == 1 and is_robot(output):
            console.warn(_missing_output(output))
        console.warn(f"{description.name}: {counted(len(errors), 'error')}, nothing printed")
        return USAGE if len(unknown) == len(errors) else PROBLEMS
    (artifact,) = compiled.artifacts
    from rosorin_compile.output import OutputError, encoded

    try:
        data = encoded(artifact.file, artifact.text)
        if options.output is not None:
            _write(Path(options.output), data, inputs, artifact.backend)
    except OutputError as problem:
        console.show([problem.diagnostic])
        return PROBLEMS
    if options.depfile is not None:
        from .depfile import write_depfile

        made = [Path(name) for name in (options.output, options.depfile) if name]
        if write_depfile(run, target, request.watched(compiled, made), made[:-1]):
            return PROBLEMS
    if options.output is None:
        give(artifact.text)
    return FINE


def _requested(words: list[str]) -> tuple[Description, str]:
    """Return the requested robot and output. Raises RequestError."""
    if len(words) == 1:
        try:
            return find_robot("", f"{_CALL} ROBOT {words[0]}"), words[0]
        except RequestError:
            if is_robot(words[0]):
                raise RequestError(_missing_output(words[0])) from None
            raise
    robot, output = words
    if not is_robot(robot):
        if is_robot(output):
            raise RequestError(f"the robot comes first: {_CALL} {output} {robot}")
        refuse_half_marks([output])
    return find_robot(robot, f"{_CALL} ROBOT {output}"), output


def _missing_output(robot: str) -> str:
    return f"{robot} is a robot: write {_CALL} {robot} OUTPUT; --list {robot} shows its outputs"


def _write(path: Path, data: bytes, inputs: list[Path], backend: str) -> None:
    """Write an artifact; one without a line that marks it is replaced if it was written before. Raises OutputError."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.output import is_generated, may_replace, write_file
    from rosorin_compile.output.artifact_set import remember, remembered

    robot_of = FORMATS[backend].robot_of
    is_known = remembered(path) is not None
    write_file(path, data, inputs, lambda old: is_known or may_replace(old) or bool(robot_of and robot_of(old)))
    if not is_generated(data):
        remember(path)


def _list(run: Run) -> int:
    """List the outputs of a robot."""
    from rosorin_compile import api
    from rosorin_compile.formats import FORMATS

    options, words, console = run.options, run.words, run.console
    if len(words) > 1 or options.output or options.depfile:
        raise RequestError(f"a list is of one robot: {_CALL} --list ROBOT")
    description = find_robot("".join(words), f"{_CALL} --list ROBOT")
    found = api.outputs(run.request(description))
    if found.outputs is None:
        console.show([one for one in found.diagnostics if one.severity == ERROR])
        console.warn(f"{description.name}: a description with errors has no outputs")
        return PROBLEMS
    rows = [{"name": output.name, "format": output.backend, "file": output.file} for output in found.outputs]
    lines = table([("output", "format", "file"), *(tuple(row.values()) for row in rows)])
    if not rows:
        names = ", ".join(format.name for format in FORMATS.values() if format.write is not None)
        lines = [f"{description.name} lists no outputs; print takes the name of a format: {names}"]
    return run.give(rows, lambda: "\n".join(lines))


def _outputs_here(run: Run) -> str:
    """Return the outputs of the only robot here, as the end of a sentence."""
    from rosorin_compile import api

    with suppress(RequestError):
        description = find_robot("", "")
        outputs = api.outputs(replace(run.request(description), warn=None)).outputs
        if outputs:
            return f"; the outputs of {description.name}: {first_of([one.name for one in outputs], _MAX_NAMES)}"
    return "; --list ROBOT shows what there is"

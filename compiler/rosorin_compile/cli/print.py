"""rosorin-compile print: compile one artifact, and print it on standard output and nothing else.

Launch files and build rules call it where they call xacro: what is right prints nothing on standard error, and nothing
is written beside the file that ``-o`` names.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.console import Console, give
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import counted, first_of

from .answer import give_result
from .command import Options, command, option
from .given import no_half_mark
from .options import PATH, depfile_options, robot_options, words_argument
from .robots import is_robot, one
from .run import Run
from .usage import FINE, PROBLEMS, USAGE, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.model import Output
    from rosorin_compile.request import Request
    from rosorin_compile.source.diagnostics import Diagnostic


_CALL = "rosorin-compile print"
_MOST_NAMED = 20


@command("print", exits="0 printed, 1 the robot has errors")
@words_argument(
    "[ROBOT] OUTPUT",
    "the robot (name, folder or file; also a URDF, xacro, SDF or MJCF), required if there are several, and the name of "
    "an output or a format such as urdf",
    offers=("robot", "output", "format", "argument"),
)
@option("-o", "--output", type=PATH, metavar="FILE", help="write to a file instead of standard output")
@option("--list", is_flag=True, help="list the outputs of the robot")
@depfile_options("default: FILE of -o")
@option(
    "--lenient", is_flag=True, help="accept a URDF, xacro, SDF or MJCF that violates its specification, where possible"
)
@robot_options
def run(options: Options) -> int:
    """Print one artifact, or list those that there are."""
    options.quiet = not options.verbose  # what there is to say of the cache, too
    run = Run.of(options)
    words, console = run.words, run.console
    if options.list:
        return _list(run)
    if not words:
        raise WrongUsage(f"print what? {_CALL} [ROBOT] OUTPUT{_outputs_here(run)}")
    if "" in words:
        raise WrongUsage("a name is empty: a variable of the shell that is not set?")
    if len(words) > 2:
        no_half_mark(words)
        raise WrongUsage(f"print takes one ROBOT and one OUTPUT: {_CALL} {words[0]} {words[1]}")
    if options.format != "text":
        raise WrongUsage("JSON goes with --list: an artifact is printed as it is")
    target = options.depfile_target or options.output
    if options.depfile is None and options.depfile_target is not None:
        raise WrongUsage("--depfile-target goes with --depfile FILE")
    if options.depfile is not None and target is None:
        raise WrongUsage("a depfile needs a target: write -o FILE, or --depfile-target NAME")
    description, output = _asked(run)
    request = run.request(description)
    compiled = request.compile((output,), foreign=True, lenient=options.lenient)
    console.tell_read(request.inputs(compiled))
    console.show(compiled.diagnostics)
    if not compiled.artifacts:
        return _nothing_printed(words, console, description, compiled.diagnostics)
    return _put(options, console, request, compiled, target)


def _asked(run: Run) -> tuple[Description, str]:
    """Return the robot that is asked for, and which of its outputs. Raises WrongUsage."""
    words = run.words
    if len(words) == 1:
        try:
            return one("", f"{_CALL} ROBOT {words[0]}"), words[0]
        except WrongUsage:
            if is_robot(words[0]):
                raise WrongUsage(_meant(words[0])) from None
            raise
    robot, output = words
    if not is_robot(robot) and is_robot(output):
        raise WrongUsage(f"the robot comes first: {_CALL} {output} {robot}")
    if not is_robot(robot):
        no_half_mark([output])
    return one(robot, f"{_CALL} ROBOT {output}"), output


def _meant(robot: str) -> str:
    return f"{robot} is a robot: write {_CALL} {robot} OUTPUT; --list {robot} shows its outputs"


def _put(options: Options, console: Console, request: Request, compiled: Compiled, target: str | None) -> int:
    """Print an artifact, or write it into the file that is named; then the depfile."""
    (artifact,) = compiled.artifacts
    # What writes files is not imported for nothing: most of what is printed is text that UTF-8 has.
    if options.output is not None or options.depfile is not None or not _is_text(artifact.text):
        from rosorin_compile.output import OutputError, encoded

        from .depfile import write_depfile

        try:
            data = encoded(artifact.file, artifact.text)
            if options.output is not None:
                _write(Path(options.output), data, request.inputs(compiled), artifact.backend)
            if options.depfile is not None and target is not None:
                made = [Path(name) for name in (options.output, options.depfile) if name]
                write_depfile(Path(options.depfile), target, request.watched(compiled, made), made[:-1])
        except OutputError as problem:
            console.show([problem.diagnostic])
            return PROBLEMS
    return FINE if options.output is not None or _printed(artifact.text, console) else PROBLEMS


def _write(path: Path, data: bytes, inputs: list[Path], backend: str) -> None:
    """Write an artifact; what no line in it tells to be ours, its format or the cache knows. Raises OutputError."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.output import is_generated, may_replace, write_file
    from rosorin_compile.source.cache import remember, remembered

    robot_of = FORMATS[backend].ros.robot_of
    is_known = remembered(path) is not None
    write_file(path, data, inputs, lambda old: is_known or may_replace(old) or bool(robot_of and robot_of(old)))
    if not is_generated(data):
        remember(path)


def _is_text(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _printed(text: str, console: Console) -> bool:
    """Print an artifact; say whether that went well. Whoever reads the first lines alone has what they want."""
    try:
        give(text)
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as problem:
        console.warn(f"cannot write to standard output: {problem.strerror or problem}")
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), sys.__stdout__.fileno() if sys.__stdout__ else 1)
        return False
    return True


def _nothing_printed(
    words: list[str], console: Console, description: Description, diagnostics: list[Diagnostic]
) -> int:
    from rosorin_compile.language.wanted import UNKNOWN

    errors = [one for one in diagnostics if one.severity == "error"]
    if len(words) == 1 and is_robot(words[0]) and any(one.rule == UNKNOWN for one in errors):
        console.warn(_meant(words[0]))
    console.warn(f"{description.name}: {counted(len(errors), 'error')}, nothing printed")
    return USAGE if all(one.rule == UNKNOWN for one in errors) else PROBLEMS


def _list(run: Run) -> int:
    """List the outputs of a robot."""
    from rosorin_compile import api

    options, words, console = run.options, run.words, run.console
    if len(words) > 1 or options.output or options.depfile:
        raise WrongUsage(f"a list is of one robot: {_CALL} --list ROBOT")
    description = one("".join(words), f"{_CALL} --list ROBOT")
    found = api.outputs(run.request(description))
    outputs = found.outputs
    if outputs is None:
        console.show([one for one in found.diagnostics if one.severity == "error"])
        console.warn(f"{description.name}: a description with errors has no outputs")
        return PROBLEMS
    rows = [{"name": output.name, "format": output.backend, "file": output.file} for output in outputs]
    give_result(options, rows, lambda: "\n".join(_lines(description.name, outputs)))
    return FINE


def _lines(name: str, outputs: tuple[Output, ...]) -> list[str]:
    if not outputs:
        return [f"{name} lists no outputs; print takes the name of a format: {', '.join(_written())}"]
    rows = [("output", "format", "file"), *((output.name, output.backend, output.file) for output in outputs)]
    widths = [max(len(row[index]) for row in rows) for index in range(2)]
    return [f"{first:<{widths[0]}}  {second:<{widths[1]}}  {third}" for first, second, third in rows]


def _written() -> list[str]:
    from rosorin_compile.formats import FORMATS

    return [format.name for format in FORMATS.values() if format.write is not None]


def _outputs_here(run: Run) -> str:
    """Return the outputs of the only robot here, as the end of a sentence."""
    from rosorin_compile import api

    try:
        description = one("", "")
    except WrongUsage:
        return "; --list ROBOT shows what there is"
    outputs = api.outputs(replace(run.request(description), warn=None)).outputs
    if not outputs:
        return "; --list ROBOT shows what there is"
    return f"; the outputs of {description.name}: {first_of([output.name for output in outputs], _MOST_NAMED)}"

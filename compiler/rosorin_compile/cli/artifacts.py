"""rosorin-compile all and print: compile robots, and write their artifacts or print a single artifact."""

import os
from pathlib import Path

from rosorin_compile import api
from rosorin_compile.formats import FORMATS
from rosorin_compile.language.arguments import UNKNOWN
from rosorin_compile.output.artifact_set import encode, is_remembered, remember
from rosorin_compile.output.atomic_files import is_generated, may_replace, write_file
from rosorin_compile.source.diagnostics import ERROR, RequestError, has_errors
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import count_of

from . import command as cli
from .console import FINE, PROBLEMS, USAGE, give, table
from .run import Run, count, counted_files, for_each, refuse_stdin, write_depfile

_ONLY = "write only this output and its meshes; repeatable"


@cli.command("all", exits="0 written or unchanged, 1 a robot has errors or, with --dry-run, an artifact would change")
@cli.robots_argument()
@cli.dry_run_option
@cli.flag("--prune", help="delete files in the output folder that are not artifacts")
@cli.hook_option
@cli.repeatable("--only OUTPUT", type=cli.PATH, help=_ONLY, offers="output", excludes="prune dry_run")
@cli.output_folder_option
@cli.depfile_options("default: the first artifact, or that of the first --only")
@cli.notes_option
@cli.fail_on_option
def run_all(run: Run) -> int:
    """Compile each robot and write its artifacts."""
    refuse_stdin(run.words, "name a file, or print one artifact: rosorin-compile print - OUTPUT")
    if run.dry_run:
        from .check import check_robot

        return for_each(run, check_robot)
    return for_each(run, _write)


def _write(run: Run, description: Description) -> int:
    console, request = run.console, run.request(description)
    result = api.write(request, prune=run.prune, only=run.only)
    compiled = result.compiled
    inputs = request.inputs(compiled)
    console.print_read(inputs)
    for is_kept in (False, True):  # always print notes about files that are not artifacts: ``check`` fails for them
        console.show([d for d in result.diagnostics if (d.rule == "not-an-artifact") == is_kept], listed=is_kept)
    if not compiled.artifacts:
        unknown = any(one.rule == UNKNOWN for one in compiled.diagnostics)
        return max(run.nothing_written(description, compiled.diagnostics), USAGE if unknown else FINE)
    failed = has_errors(result.diagnostics)
    if failed and not (result.written or result.unchanged):
        return PROBLEMS
    console.robots[-1] |= {name: getattr(result, name) for name in ("folder", "written", "unchanged", "removed")}
    files = [artifact.file for artifact in compiled.artifacts]
    meshes = [file for file in (*result.written, *result.unchanged) if file not in files]
    written = [name for name in result.written if name in files]
    written += counted_files([name for name in result.written if name in meshes])
    changes = {"written": written, "removed": result.removed}
    done = "; ".join(f"{word}: {', '.join(names)}" for word, names in changes.items() if names) or "unchanged"
    console.say(f"{description.name}: {count(files, meshes)} in {result.folder}, {done}")
    if run.depfile is not None:
        # Keep the time of a mesh that was also read as an input, or it would always be newer than the artifacts.
        read = {os.path.realpath(file) for file in inputs}
        made = [description.outputs / file for file in (*files, *meshes)]
        newer = [file for file in made if os.path.realpath(file) not in read]
        write_depfile(run, run.depfile_target or str(made[0]), compiled, inputs, made, newer)
    return PROBLEMS if failed or (run.hook and (result.written or result.removed)) else FINE


_CALL = "rosorin-compile print"


@cli.command("print", exits="0 printed, 1 the robot has errors")
@cli.words_argument(
    "[ROBOT] OUTPUT",
    "the robot (name, folder or file; also a URDF, xacro, SDF or MJCF), required if there are several, and the name of "
    "an output or a format such as urdf",
    offers=("robot", "output", "format", "argument"),
)
@cli.option("-o", "--output FILE", help="write to a file instead of standard output")
@cli.flag("--list", help="list the outputs of the robot", excludes="output depfile")
@cli.depfile_options("default: FILE of -o")
@cli.flag("--lenient", help="accept a URDF, xacro, SDF or MJCF that violates its specification, where possible")
@cli.robot_options
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
        name = description.name if description.path.suffix in (*Description.ENDINGS, "") else description.path.name
        console.warn(f"{name}: {count_of(len(errors), 'error')}, nothing printed")
        return USAGE if set(errors) <= {UNKNOWN} else PROBLEMS
    (artifact,) = compiled.artifacts
    data = encode(artifact.file, artifact.text)
    if run.output is not None:
        # Replace an existing file only if this tool has written it; ``robot_of`` detects formats without comments.
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
        return PROBLEMS
    rows = [{"name": output.name, "format": output.backend, "file": output.file} for output in found.outputs]
    lines = table([("output", "format", "file"), *(tuple(row.values()) for row in rows)])
    if not rows:
        names = ", ".join(format.name for format in FORMATS.values() if format.write is not None)
        lines = [f"{description.name} lists no outputs; print takes the name of a format: {names}"]
    return run.give(rows, lambda: "\n".join(lines))

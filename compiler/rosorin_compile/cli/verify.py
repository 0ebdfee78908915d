"""rosorin-compile verify: compare a recording of the running robot with its description."""

from __future__ import annotations

import errno
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.cli.console import Console
from rosorin_compile.request import is_foreign
from rosorin_compile.source.diagnostics import ERROR, WARNING, RequestError
from rosorin_compile.source.files import exists, is_file, is_folder, read_bytes
from rosorin_compile.source.project import Description, NoDescription

from . import complete
from .answer import FINE, PROBLEMS
from .command import Options, command, flag, mode_option, option, pose_option, robot_options, words_argument
from .run import Run, find_robot, mode_states

if TYPE_CHECKING:
    from rosorin_compile.recordings.results import Verified

_SOURCES = "a rosbag2 folder, a .mcap or .db3 file, a text file, or -"
_RECORDED = re.compile(r"\.mcap$|\.db3$|^metadata\.yaml$")  # files of a rosbag2 folder


@command("verify", exits="0 it matches, 1 it does not match or cannot be read")
@words_argument(
    "[ROBOT] SOURCE",
    "the robot, required if there are several, and a rosbag2 folder, a .mcap or .db3 file, a text file, or - for text "
    "on standard input",
    required=True,
    offers=("robot", "file"),
)
@mode_option("detected")
@option("--without", multiple=True, metavar="NODE", help="node that was not running; repeatable")
@pose_option("named pose of the joints while tf2_echo ran")
@option(
    "--frames",
    nargs=2,
    metavar="SOURCE TARGET",
    help="frames of the tf2_echo output",
    shell_complete=complete.of("frame"),
)
@option("--since", type=float, metavar="S", help="start S seconds after the start of the recording")
@option("--until", type=float, metavar="S", help="stop S seconds after the start of the recording")
@option("--stale", type=float, default=1.0, metavar="S", help="maximum age of a transform in seconds; default: 1")
@option("--namespace", default="", metavar="NS", help="namespace of the topics, such as robot1")
@option("--prefix", default="", metavar="TEXT", help="prefix of the recorded frames, such as robot1/")
@flag("--strict", help="treat warnings as errors")
@option("--junit", metavar="FILE", help="also write the result as JUnit XML")
@option("--picture", metavar="FILE.svg", help="write a plot of rates and gaps over time")
@robot_options
def run(options: Options) -> int:
    """Compare one recording with one robot."""
    from rosorin_compile import api

    run = Run.of(options)
    source, description = _requested(run.words)
    if source != "-" and not _may_exist(source):
        raise RequestError(f"there is no {source}; name {_SOURCES}")
    result = api.verify(
        run.request(description),
        source,
        **options.pick("without pose since until stale namespace prefix"),
        modes=mode_states(options.modes),
        frames=tuple(options.frames) if options.frames else None,
    )
    if result.data is None:
        run.console.show(result.diagnostics)
        run.console.warn(f"{description.name}: not compared")
        return PROBLEMS
    _show(run, result, description.name)
    _write(result, options)
    return PROBLEMS if result.fails(options.strict) else FINE


def _requested(words: list[str]) -> tuple[str, Description]:
    """Return the source and the robot. Raises RequestError."""
    if not words or len(words) > 2:
        raise RequestError("write verify [ROBOT] SOURCE: one robot, and one recording")
    if words.count(Description.STDIN) > 1:
        raise RequestError("standard input is the recording or the robot, not both")
    robot, source = words[0] if len(words) > 1 else "", words[-1]
    if _is_robot(source):
        named = Path(robot).suffix.lower() in (".yaml", ".yml") or is_foreign(Path(robot))
        if robot and not _is_robot(robot) and not (named and is_file(robot)):
            raise RequestError(f"the robot comes first: write verify {source} {robot}")
        what = "a second robot" if robot else "a robot"
        raise RequestError(f"{source} is {what}: write verify {robot or source} SOURCE; SOURCE is {_SOURCES}")
    return source, find_robot(robot, f"rosorin-compile verify ROBOT {source}")


def _may_exist(source: str) -> bool:
    """Return True if a source exists or cannot be accessed; reading it then reports the reason."""
    try:
        Path(source).stat()
    except OSError as problem:
        return problem.errno not in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP)
    except ValueError:  # a NUL in the name
        return False
    return True


def _is_robot(source: str) -> bool:
    """Return True if the word for the recording is a description, or a robot in another format."""
    from rosorin_compile.formats import FORMATS

    path = Path(source)
    try:
        if is_folder(path):
            names = [inner.name for inner in path.iterdir()]
            return Description.ROOT_FILE in names and not any(map(_RECORDED.search, names))
        found = path if is_file(path) else Description.find([source])[0].path
    except (NoDescription, OSError, ValueError):
        return False
    # Messages may be pasted as JSON or as YAML of any name.
    return found.name == Description.ROOT_FILE or found.suffix.lower() in FORMATS.endings(include=True)


def _show(run: Run, result: Verified, name: str) -> None:
    from rosorin_compile.recordings.results import summary, table

    options, console = run.options, run.console
    if options.format != "text":
        if options.format == "json":
            console.show(result.diagnostics)
        run.give(result)
    elif options.quiet:
        failing = (ERROR, WARNING) if options.strict else (ERROR,)
        Console("text").show([finding for finding in result.diagnostics if finding.severity in failing])
    else:
        for line in table(result):
            print(line)
        sys.stdout.flush()
        console.show(result.diagnostics)
        sys.stderr.flush()
        print(summary(result, name, options.strict))


def _write(result: Verified, options: Options) -> None:
    """Write the result as JUnit XML and as a plot, if requested. Raises RequestError."""
    if options.junit:
        from rosorin_compile.recordings.results import as_junit

        _save(options.junit, as_junit(result, options.strict), "<testsuites")
    if options.picture:
        from rosorin_compile.recordings.picture import as_svg

        try:
            _save(options.picture, as_svg(result.data), "<svg")
        except ValueError as problem:
            raise RequestError(f"--picture: {problem}") from None


def _save(name: str, text: str, kind: str) -> None:
    """Write a file; an existing one is replaced if it is of that kind. Raises RequestError."""
    from rosorin_compile.output import OutputError, write_file

    try:
        there = exists(name)
        if there and not is_file(name):
            raise RequestError(f"{name} cannot be written: it is no regular file")
        begins = read_bytes(name, 1000) if there else b""
        if begins and kind.encode() not in begins:
            raise RequestError(f"{name} is there, and verify did not write it; name another file, or move it away")
        write_file(Path(name), text.encode(), may_replace=None)
    except OSError as problem:
        raise RequestError(f"{name} cannot be written: {problem.strerror}") from None
    except OutputError as problem:
        raise RequestError(problem.diagnostic.message) from None

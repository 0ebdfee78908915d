"""rosorin-compile verify: compare a recording of the running robot with its description."""

from pathlib import Path

from rosorin_compile.output.atomic_files import OutputError, write_file
from rosorin_compile.recordings import verify
from rosorin_compile.source.diagnostics import ERROR, WARNING, RequestError
from rosorin_compile.source.files import exists, is_file, read_bytes
from rosorin_compile.source.project import Description

from .command import command, flag, mode_option, option, repeatable, robot_options, words_argument
from .console import FINE, PROBLEMS, Console
from .run import Run

_SOURCES = "a rosbag2 folder, a .mcap or .db3 file, a text file, or -"


@command("verify", exits="0 it matches, 1 it does not match or cannot be read")
@words_argument(
    "[ROBOT] SOURCE",
    f"the robot, required if there are several, and {_SOURCES} for text on standard input",
    required=True,
    offers=("robot", "file"),
)
@mode_option("detected")
@repeatable("--without NODE", help="node that was not running; repeatable")
@option("--pose POSE", default="", help="named pose of the joints while tf2_echo ran", offers="pose")
@option("--frames SOURCE TARGET", nargs=2, help="frames of the tf2_echo output", offers="frame")
@option("--since S", type=float, help="start S seconds after the start of the recording")
@option("--until S", type=float, help="stop S seconds after the start of the recording")
@option("--stale S", default=1.0, help="maximum age of a transform in seconds; default: 1")
@option("--namespace NS", default="", help="namespace of the topics, such as robot1")
@option("--prefix TEXT", default="", help="prefix of the recorded frames, such as robot1/")
@flag("--strict", help="treat warnings as errors")
@option("--junit FILE", help="also write the result as JUnit XML")
@option("--picture FILE.svg", help="write a plot of rates and gaps over time")
@robot_options
def run_verify(run: Run) -> int:
    """Compare one recording with one robot."""
    from rosorin_compile.recordings.results import as_junit, summary, table

    console, source = run.console, run.words[-1]
    if run.words.count(Description.STDIN) > 1:
        raise RequestError("standard input is the recording or the robot, not both")
    if source != Description.STDIN and not Path(source).exists():
        raise RequestError(f"there is no {source}; name {_SOURCES}")
    description, _ = run.robot_before(1, "ROBOT SOURCE")
    picked = run.pick("modes without pose frames since until stale namespace prefix")
    result = verify(run.request(description), source, **picked)
    if result.data is None:
        console.show(result.diagnostics)
        return PROBLEMS
    if run.format != "text":
        console.show(result.diagnostics)
        run.give(result)
    elif run.quiet:
        failing = (ERROR, WARNING) if run.strict else (ERROR,)
        Console().show([finding for finding in result.diagnostics if finding.severity in failing])
    else:
        print("".join(f"{line}\n" for line in table(result)), end="", flush=True)
        console.show(result.diagnostics)
        print(summary(result, description.name, run.strict))
    if run.junit:
        _save(run.junit, as_junit(result, run.strict), b"<testsuites")
    if run.picture:
        from rosorin_compile.recordings.verification import as_svg

        try:
            _save(run.picture, as_svg(result.data), b"<svg")
        except ValueError as problem:
            raise RequestError(f"--picture: {problem}") from None
    return PROBLEMS if result.fails(run.strict) else FINE


def _save(name: str, text: str, kind: bytes) -> None:
    """Write a file, but replace only a file whose beginning contains ``kind``. Raises RequestError."""
    if exists(name) and not is_file(name):
        raise RequestError(f"{name} cannot be written: it is not a regular file")
    try:
        write_file(Path(name), text.encode(), may_replace=lambda old: kind in (read_bytes(old, 1000) or kind))
    except OutputError as problem:
        raise RequestError(f"{problem.diagnostic.message}; {problem.diagnostic.help}") from None

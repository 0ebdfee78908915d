"""rosorin-compile verify: hold a recording of the running robot against its description."""

from __future__ import annotations

import argparse
import errno
import re
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import Console, Heading, Progress, Rule, pip_install
from rosorin_compile.source.files import exists, is_file, is_folder, read_bytes
from rosorin_compile.source.project import Description, NoDescription

from .answer import give_result
from .given import Given
from .robots import is_foreign
from .run import Run
from .understanding import mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosorin_compile.model import Robot
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.recordings.expected import Options
    from rosorin_compile.recordings.judge import Verdict
    from rosorin_compile.source.diagnostics import Diagnostic

    from .parser import Parser

RULES = (
    Rule(
        "recording-unreadable",
        "The source is no recording, or it is damaged, or its end is missing because the recorder was killed.",
        "The message says why; `ros2 bag reindex` or `mcap recover` may help. End a recording with Ctrl-C.",
        Heading.RECORDINGS,
    ),
)

_SOURCES = "a rosbag2 folder, a .mcap or .db3 file, a text file, or -"
_RECORDED = re.compile(r"\.mcap$|\.db3$|^metadata\.yaml$")  # files of a rosbag2 folder


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_argument(
        "words",
        nargs="+",
        metavar="[ROBOT] SOURCE",
        completes="[ROBOT] FILE",
        help="the robot, required if there are several, and a rosbag2 folder, a .mcap or .db3 file, a text file, or - "
        "for text on standard input",
    )
    command.add_modes("detected")
    command.add_argument(
        "--without", action="append", default=[], metavar="NODE", help="node that was not running; repeatable"
    )
    command.add_argument("--pose", default="", metavar="POSE", help="named pose of the joints while tf2_echo ran")
    command.add_argument(
        "--frames", nargs=2, metavar=("SOURCE", "TARGET"), completes="FRAME", help="frames of the tf2_echo output"
    )
    command.add_argument("--since", type=float, metavar="S", help="start S seconds after the start of the recording")
    command.add_argument("--until", type=float, metavar="S", help="stop S seconds after the start of the recording")
    command.add_argument(
        "--stale", type=float, default=1.0, metavar="S", help="maximum age of a transform in seconds; default: 1"
    )
    command.add_argument("--namespace", default="", metavar="NS", help="namespace of the topics, such as robot1")
    command.add_argument("--prefix", default="", metavar="TEXT", help="prefix of the recorded frames, such as robot1/")
    command.add_argument("--strict", action="store_true", help="treat warnings as errors")
    command.add_argument("--junit", metavar="FILE", help="also write the result as JUnit XML")
    command.add_argument("--picture", metavar="FILE.svg", help="write a plot of rates and gaps over time")
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Hold one recording against one robot."""
    run = Run.of(options)
    given, console = run.given, run.console
    source, description = _asked(run)
    if source != "-" and not _is_there(source):
        raise WrongUsage(f"there is no {source}; name {_SOURCES}")
    compiled = _compiled(given, description, console)
    if compiled.robot is None or any(d.severity == "error" for d in compiled.diagnostics):
        console.show([diagnostic for diagnostic in compiled.diagnostics if diagnostic.severity == "error"])
        console.warn(f"{description.name}: a description with errors is nothing to compare with")
        return PROBLEMS
    try:
        from rosorin_compile.recordings.bags import Unreadable
        from rosorin_compile.recordings.sources import verify
    except ModuleNotFoundError as problem:
        if problem.name != "numpy":
            raise
        needs = "rosorin-compile verify needs numpy, and rosbags for recordings"
        raise WrongUsage(f"{needs}: {pip_install('verify')}") from None
    said = _options(options, compiled.robot)
    told = partial(Progress.step, "reading messages")
    try:
        verdict = verify(compiled.robot, compiled.artifacts, source, said, told, sys.stdin.buffer.read)
    except Unreadable as problem:
        from rosorin_compile.source.diagnostics import error

        console.show([error("recording-unreadable", str(problem), None, problem.help)])
        return PROBLEMS
    verdict = verdict._replace(findings=_placed(verdict, given, description, console))
    _show(verdict, options, source, description.name, console)
    _write(verdict, options)
    return PROBLEMS if verdict.fails(options.strict) else FINE


def _compiled(given: Given, description: Description, console: Console) -> Compiled:
    """Return a description, or a robot in another format, with its artifacts."""
    if not is_foreign(description.path):
        return given.compile(description, console)
    return given.compile_foreign(description, console)


def _asked(run: Run) -> tuple[str, Description]:
    """Return the source and the robot that are meant. Raises WrongUsage."""
    words = run.words
    if not words or len(words) > 2:
        raise WrongUsage("write verify [ROBOT] SOURCE: one robot, and one recording")
    if words.count(Description.STDIN) > 1:
        raise WrongUsage("standard input is the recording or the robot, not both")
    robot, source = "", words[-1]
    if len(words) > 1:
        robot = words[0]
    if _is_robot(source):
        if robot and not _may_be_robot(robot):
            raise WrongUsage(f"the robot comes first: write verify {source} {robot}")
        what = "a second robot" if robot else "a robot"
        raise WrongUsage(f"{source} is {what}: write verify {robot or source} SOURCE; SOURCE is {_SOURCES}")
    found = run.robots([robot] if robot else [])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; write verify ROBOT {source}")
    return source, found[0]


def _may_be_robot(word: str) -> bool:
    """Return True if a word may be the robot: a description, or a YAML file or foreign robot file that exists."""
    named = Path(word).suffix.lower() in (".yaml", ".yml") or (word != Description.STDIN and is_foreign(Path(word)))
    return _is_robot(word) or (named and is_file(word))


def _is_there(source: str) -> bool:
    """Say whether there is a source; one that cannot be looked at is, and reading it says why."""
    try:
        Path(source).stat()
    except OSError as problem:
        return problem.errno not in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP)
    return True


def _is_robot(source: str) -> bool:
    """Say whether the word for the recording is a robot: a description, or a file in another format."""
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


def _options(options: argparse.Namespace, robot: Robot) -> Options:
    from rosorin_compile.recordings.expected import Options
    from rosorin_compile.source.diagnostics import did_you_mean

    modes = mode_states(robot, options.modes)
    owners = {joint.publisher.name for joint in robot.joints} | {edge.publisher.name for edge in robot.edges}
    for name in options.without:
        if name not in owners:
            raise WrongUsage(f'{robot.name} has no publisher "{name}"; {did_you_mean(name, owners - {""})}')
    for name in ("since", "until", "stale"):
        value = getattr(options, name)
        if value is not None and not 0 <= value < 1e9:
            raise WrongUsage(f"--{name} {value:g} is no time in seconds")
    if options.since is not None and options.until is not None and options.since >= options.until:
        raise WrongUsage("--since is not before --until")
    frames = (options.frames[0], options.frames[1]) if options.frames else None
    return Options(
        modes,
        frozenset(options.without),
        _pose(options.pose, robot),
        frames,
        options.since,
        options.until,
        options.namespace,
        options.prefix.removeprefix("/"),
        options.stale,
    )


def _pose(name: str, robot: Robot) -> Mapping[str, float] | None:
    from rosorin_compile.source.diagnostics import did_you_mean

    if not name:
        return None
    pose = next((pose for pose in robot.poses if pose.name == name), None)
    if pose is None:
        known = [pose.name for pose in robot.poses]
        raise WrongUsage(f'{robot.name} has no pose "{name}"; {did_you_mean(name, known) or "it has none"}')
    return pose.positions


def _placed(verdict: Verdict, given: Given, description: Description, console: Console) -> list[Diagnostic]:
    """Return the findings with the places in the description of the edges that they are about."""
    from rosorin_compile.recordings.findings import with_place

    edges = {edge.name: edge for edge in verdict.description.edges}
    # What takes arguments may run code: once is enough.
    if _takes_arguments(description.path) or not any(finding.of[0] in edges for finding in verdict.findings):
        return verdict.findings
    expanded, lowered, *_ = given.understand(description, console)
    if expanded.tree is None or lowered is None:
        return verdict.findings
    found = []
    for finding in verdict.findings:
        edge = edges.get(finding.of[0])
        if edge is not None:
            path = edge.place if edge.joint is None else lowered.places.get(("joint", edge.joint.name), ())
            finding = with_place(finding, expanded.tree.locate(path, key=True).span)
        found.append(finding)
    return found


def _takes_arguments(path: Path) -> bool:
    """Say whether a robot in another format than a description is told arguments."""
    from rosorin_compile.formats import FORMATS

    return any(one.reading.takes_arguments and path.suffix.lower() in one.endings for one in FORMATS.values())


def _show(verdict: Verdict, options: argparse.Namespace, source: str, name: str, console: Console) -> None:
    from rosorin_compile.recordings.lines import summary, table
    from rosorin_compile.source.diagnostics import ERROR, WARNING

    if options.format != "text":
        from rosorin_compile.recordings.machine import as_object

        if options.format == "json":
            console.show(verdict.findings)
        give_result(options, as_object(verdict, source), str)
        return
    if options.quiet:
        failing = (ERROR, WARNING) if options.strict else (ERROR,)
        Console("text").show([finding for finding in verdict.findings if finding.severity in failing])
        return
    for line in table(verdict):
        print(line)
    sys.stdout.flush()
    console.show(verdict.findings)
    sys.stderr.flush()
    print(summary(verdict, name, options.strict))


def _write(verdict: Verdict, options: argparse.Namespace) -> None:
    if options.junit:
        from rosorin_compile.recordings.machine import as_junit

        _save(options.junit, as_junit(verdict, options.strict), "<testsuites")
    if options.picture:
        from rosorin_compile.recordings.picture import as_svg

        try:
            _save(options.picture, as_svg(verdict), "<svg")
        except ValueError as problem:
            raise WrongUsage(f"--picture: {problem}") from None


def _save(name: str, text: str, kind: str) -> None:
    """Write a file; what is there is replaced if it is of that kind, as the one of the last run. Raises WrongUsage."""
    from rosorin_compile.output import OutputError, write_file

    try:
        there = exists(name)
        if there and not is_file(name):
            raise WrongUsage(f"{name} cannot be written: it is no regular file")
        begins = read_bytes(name, 1000) if there else b""
        if begins and kind.encode() not in begins:
            raise WrongUsage(f"{name} is there, and verify did not write it; name another file, or move it away")
        write_file(Path(name), text.encode(), may_replace=None)
    except OSError as problem:
        raise WrongUsage(f"{name} cannot be written: {problem.strerror}") from None
    except OutputError as problem:
        raise WrongUsage(problem.diagnostic.message) from None

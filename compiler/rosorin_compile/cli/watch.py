"""rosorin-compile watch: compile on every change, and say what moved."""

from __future__ import annotations

import signal
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import ERROR, Diagnostic, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, NoDescription
from rosorin_compile.source.watched_files import INTERVAL, WatchedFiles
from rosorin_compile.source.wording import and_more, counted

from .command import Options, command
from .options import output_folder_option, robots_argument
from .robots import described
from .run import Run, count
from .usage import FINE

if TYPE_CHECKING:
    from rosorin_compile.compare.committed import Comparison
    from rosorin_compile.output.pipeline import Compiled


MAX_SHOWN = 20  # changes of one run, one line each


@command("watch", exits="0 stopped with Ctrl-C or SIGTERM")
@robots_argument()
@output_folder_option
def run(options: Options) -> int:
    """Compile robots whenever one of their files changes, until Ctrl-C or SIGTERM."""
    import gc

    gc.enable()  # this run is a long one
    run = Run.of(options)
    run.no_stdin(run.words, "name a file to watch")
    watched = {one.path: _Robot(one, run) for one in described(options, run.words)}
    stop = _Stop()
    for robot in watched.values():
        robot.compile()
    _say(f"watching {', '.join(robot.description.name for robot in watched.values())}; Ctrl-C ends it")
    while not stop.asked:
        time.sleep(INTERVAL)
        if not run.words:
            _notice_new(watched, run)
        for robot in watched.values():
            if not stop.asked and robot.inputs.changed():
                robot.inputs.settle()
                robot.compile()
    _say("watch ended")
    return FINE


class _Stop:
    """Whether somebody asked for the end. The work at hand is finished first; a second Ctrl-C does not wait for it."""

    def __init__(self) -> None:
        self.asked = False
        signal.signal(signal.SIGINT, self._ask)
        signal.signal(signal.SIGTERM, self._ask)

    def _ask(self, _number: int, _frame: FrameType | None) -> None:
        self.asked = True
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _notice_new(watched: dict[Path, _Robot], run: Run) -> None:
    """Compile descriptions that were not there before."""
    try:
        found = Description.find([], run.options.output)
    except NoDescription:
        return
    for description in found:
        if description.path not in watched:
            watched[description.path] = _Robot(description, run)
            watched[description.path].compile()


class ReportedDiagnostics:
    """The diagnostics that were reported about a robot, so that they are not repeated at each save."""

    def __init__(self) -> None:
        self._reported: Counter[tuple[str, ...]] = Counter()

    def new(self, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
        """Return the diagnostics that the previous run did not have, and remember all of them.

        One whose line has only moved is the same. While there are errors, other rules may not be checked, so what they
        reported is remembered until a run without errors.
        """
        current = list(diagnostics)
        left, new = self._reported.copy(), []
        for diagnostic in current:
            key = _key(diagnostic)
            if left[key]:
                left[key] -= 1
            else:
                new.append(diagnostic)
        hidden = Counter({key: n for key, n in left.items() if key[0] != ERROR}) if has_errors(current) else Counter()
        self._reported = Counter(map(_key, current)) + hidden
        return new


def _key(diagnostic: Diagnostic) -> tuple[str, ...]:
    span = diagnostic.span
    place = (span.source.path, span.source.line(span.line).strip()) if span else ()
    return (diagnostic.severity, diagnostic.rule, diagnostic.message, *place)


class _Robot:
    """One robot that is watched."""

    def __init__(self, description: Description, run: Run) -> None:
        self.description = description
        self.request, self.console = run.request(description), run.console
        self.inputs = WatchedFiles(description.outputs)
        self.reported = ReportedDiagnostics()

    def compile(self) -> None:
        """Compile the robot, write what changed, and say what that means; after an error all stays as it is."""
        Progress.begin()
        self.inputs.read(self._compile)

    def _compile(self) -> None:
        """Compile, and write what came of it; after an error nothing."""
        compiled = self.request.compile()
        self.console.tell_read(self.request.inputs(compiled))
        errors = sum(diagnostic.severity == "error" for diagnostic in compiled.diagnostics)
        new = self.reported.new(compiled.diagnostics)
        self.console.show(new)
        name = self.description.name
        if errors:
            old = errors - sum(diagnostic.severity == "error" for diagnostic in new)
            also = "" if not old else ", as before" if old == errors else f", {old} as before"
            self.console.warn(f"{name}: {counted(errors, 'error')}{also}; the artifacts stay as they are")
        elif not compiled.artifacts:
            _say(f"{name}: nothing to emit; say under outputs: what you want")
        else:
            self._write(compiled)

    def _write(self, compiled: Compiled) -> None:
        from rosorin_compile.compare.committed import compare
        from rosorin_compile.formats.templating import Templates
        from rosorin_compile.output import OutputError, read_set, write_artifacts

        if compiled.robot is None:
            return
        files = {artifact.file: artifact.text for artifact in compiled.artifacts}
        meshes, path = compiled.mesh_files, self.description.path
        try:
            before = read_set(self.description.outputs)
            comparison = compare(compiled.robot, compiled.artifacts, before, Templates(path.parent, first=path))
            done = write_artifacts(self.description.outputs, {**meshes, **files})
        except OutputError as problem:
            self.console.show([problem.diagnostic])
            return
        written = done.written
        self.console.show(done.diagnostics(self.description.outputs))
        summary = f"{self.description.name}: {count(files)} in {self.description.outputs}"
        _say(f"{summary}, {'written: ' + ', '.join(written) if written else 'unchanged'}")
        for line in _moved(comparison):
            _say(f"  {line}")


def _moved(comparison: Comparison) -> list[str]:
    """Return what changed by its meaning, a line each."""
    lines = [change.line() for change in comparison.changes]
    if len(lines) > MAX_SHOWN:
        lines[MAX_SHOWN:] = [f"...{and_more(len(lines) - MAX_SHOWN)}"]
    return lines


def _say(line: str) -> None:
    print(line)
    sys.stdout.flush()

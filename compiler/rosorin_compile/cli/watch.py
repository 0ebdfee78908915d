"""rosorin-compile watch and sweep: compile on every change of a file, or many variants of one robot."""

import gc
import signal
import time
from contextlib import suppress
from functools import partial

from rosorin_compile.compare.golden_check import compare
from rosorin_compile.output.artifact_set import read_set, write_artifacts
from rosorin_compile.output.atomic_files import OutputError
from rosorin_compile.output.watched_files import INTERVAL, WatchedFiles
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description, NoDescription
from rosorin_compile.source.wording import and_more, count_of, first_of
from rosorin_compile.variants.sweep import MAX_FAILED, write_sweep

from .command import PATH, command, flag, option, output_folder_option, robot_argument, robot_options, robots_argument
from .console import FINE, PROBLEMS
from .run import Run, count, find_robots, refuse_stdin

MAX_SHOWN = 20  # maximum number of changes that are printed for one compilation
_say = partial(print, flush=True)


@command("watch", exits="0 stopped with Ctrl-C or SIGTERM")
@robots_argument()
@output_folder_option
def run_watch(run: Run) -> int:
    """Compile robots whenever one of their files changes, until Ctrl-C or SIGTERM."""
    gc.enable()  # ``__main__`` disables garbage collection for short runs
    refuse_stdin(run.words, "name a file to watch")
    robots = find_robots(run, run.words)
    stopped = False

    def stop(*_: object) -> None:
        """Stop after the current compilation; a second Ctrl-C does not wait for it."""
        nonlocal stopped
        stopped = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

    signal.signal(signal.SIGINT, stop)
    signal.signal(signal.SIGTERM, stop)
    watched = {description.path: WatchedRobot(description, run) for description in robots}
    _say(f"watching {', '.join(description.name for description in robots)}; Ctrl-C ends it")
    while not stopped:
        time.sleep(INTERVAL)
        with suppress(NoDescription):
            for description in Description.find([], run.output) if not run.words else ():
                if description.path not in watched:
                    watched[description.path] = WatchedRobot(description, run)
        for robot in watched.values():
            if not stopped and robot.inputs.has_changed():
                robot.inputs.settle()
                robot.compile()
    _say("watch ended")
    return FINE


class WatchedRobot:
    """A robot that ``watch`` compiles again when a file changes."""

    def __init__(self, description: Description, run: Run) -> None:
        self.description = description
        self.request, self.console = run.request(description), run.console
        self.inputs = WatchedFiles(description.outputs)
        self.reported: set[tuple[str, str, str]] = set()  # (severity, rule, message) of printed diagnostics
        self.compile()

    def compile(self) -> None:
        """Compile the robot, and write its artifacts if there are no errors."""
        Progress.begin()
        self.inputs.read(self._write)

    def _write(self) -> None:
        compiled, console = self.request.compile(), self.console
        console.print_read(self.request.inputs(compiled))
        errors = sum(diagnostic.severity == ERROR for diagnostic in compiled.diagnostics)
        keys = {(one.severity, one.rule, one.message): one for one in compiled.diagnostics}
        console.show([diagnostic for key, diagnostic in keys.items() if key not in self.reported])
        # With errors, some rules are not checked: remember their earlier warnings, so that they are not printed again.
        self.reported = {*keys, *(key for key in self.reported if errors and key[0] != ERROR)}
        name, folder = self.description.name, self.description.outputs
        if errors or compiled.robot is None:
            console.warn(f"{name}: {count_of(errors, 'error')}; the artifacts stay as they are")
            return
        if not compiled.artifacts:
            _say(f"{name}: nothing to write: the description lists no outputs")
            return
        files = {artifact.file: artifact.text for artifact in compiled.artifacts}
        try:
            changes = compare(compiled.robot, compiled.artifacts, read_set(folder)).changes
            done = write_artifacts(folder, {**compiled.mesh_files, **files})
        except OutputError as problem:
            console.show([problem.diagnostic])
            return
        console.show(done.diagnostics(folder))
        state = f"written: {', '.join(done.written)}" if done.written else "unchanged"
        lines = [f"{name}: {count(files)} in {folder}, {state}", *(f"  {one.line()}" for one in changes[:MAX_SHOWN])]
        _say("\n".join([*lines, *([f"  ...{and_more(len(changes) - MAX_SHOWN)}"] if changes[MAX_SHOWN:] else [])]))


_OVER = "variants: a CSV file with a row for each, a YAML list, or a folder with a file of arguments for each"
_AS = "with a folder: argument to set to the content of each file, or to its path if it is a text"


@command("sweep", exits="0 all variants written or unchanged, 1 a variant has errors or cannot be written")
@robot_argument
@option("--over LIST", type=PATH, required=True, help=_OVER)
@option("-o", "--output FOLDER", required=True, help="a folder per variant")
@option("-j", "--jobs NUMBER", type=int, help="number of processes; default: one per core")
@option("--as ARGUMENT", "whole", default="", help=_AS)
@option("--dask ADDRESS", default="", help="address of a Dask scheduler, such as tcp://HOST:8786")
@flag("--prune", help="delete variants that are no longer in the list")
@robot_options
def run_sweep(run: Run) -> int:
    """Compile the variants of a list; return the exit code."""
    request, console, code = run.request(run.only_robot(stdin=False)), run.console, PROBLEMS
    picked = run.pick("jobs whole dask prune")
    try:
        result = write_sweep(request, run.over, run.output, **picked, report=lambda found: console.show([found]))
    except KeyboardInterrupt as stop:
        if stop.args:
            console.warn(f"stopped: {stop.args[0]}; the same command continues from there")
        raise
    if result.complete:
        if result.removed:
            console.say(f"{count_of(len(result.removed), 'variant')} removed: {first_of(result.removed, 5)}")
        if result.error > MAX_FAILED:
            console.warn(f"{result.error - MAX_FAILED} more variants with errors: see sweep.json")
        for status, count in (("made", result.made), ("unchanged", result.unchanged), ("errors", result.error)):
            console.say(f"{status:<9} {count:>10,}")
        run.give(result)
        code = PROBLEMS if result.error else FINE
    elif not result.made + result.unchanged + result.error:
        console.warn(f"{run.over}: {count_of(len(result.diagnostics), 'error')}, nothing written")
    console.end(code != FINE)
    return code

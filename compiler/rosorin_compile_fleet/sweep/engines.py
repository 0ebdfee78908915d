"""Engines: who makes the variants of a sweep. This process, or several; a cluster is in ``cluster``.

An engine takes variants while it has ``room``, and gives back what became of them in any order. A process that dies is
replaced: the variant that it was at is tried once more, and is an error if that ends the same way.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections import deque
from contextlib import suppress
from multiprocessing import connection, get_context
from typing import TYPE_CHECKING, Any, Protocol

from rosorin_compile import Variant
from rosorin_compile.diagnostics import Diagnostic, Heading, Progress, Rule, error
from rosorin_compile.extending import world

from .making import ERROR, Folder, Job, Made, Maker, line_of
from .remote import folder_of

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess

RULES = (
    Rule(
        "worker-died",
        "The process that compiled a variant was ended from outside, and again when it was tried once more.",
        "Out of memory? Fewer at once (`-j`) need less.",
        Heading.WRITING,
    ),
)

AHEAD = 2  # variants that a process is given: one to be at, one to go on with
_TRIES = 2
_HOPELESS = 10  # deaths without a variant in between
_LOOK = 0.5  # seconds between two looks whether the run still lives

Result = tuple[int, Made]


class Engine(Protocol):
    """Makes variants."""

    @property
    def room(self) -> bool:
        """Whether a variant can be taken."""

    def submit(self, index: int, variant: Variant) -> None:
        """Take a variant."""

    def results(self) -> list[Result]:
        """Return what became of some variants; waits a little if there is nothing yet."""

    def close(self) -> None:
        """End what is still being made."""


class InProcess:
    """Makes one variant after the other, in this process."""

    def __init__(self, job: Job, folder: Folder) -> None:
        import gc

        self.maker = Maker(job, folder)
        self.done: list[Result] = []
        gc.freeze()
        gc.enable()  # a command that compiles one robot goes without

    @property
    def room(self) -> bool:
        """Whether there is no result that waits."""
        return not self.done

    def submit(self, index: int, variant: Variant) -> None:
        """Make a variant."""
        self.done.append((index, self.maker.make(variant)))

    def results(self) -> list[Result]:
        """Return the result."""
        done, self.done = self.done, []
        return done

    def close(self) -> None:
        """Nothing is being made."""


class _Worker:
    """A process, the pipe to it, and what it was given, the oldest first."""

    def __init__(self, context: Any, job: Job, folder: Folder) -> None:
        Progress.wipe()
        self.pipe, theirs = context.Pipe()
        lock = folder.lock if context.get_start_method() == "fork" else None
        arguments = (theirs, job, folder.address, os.getpid(), lock)
        self.process: BaseProcess = context.Process(target=_work, args=arguments, daemon=True)
        self.process.start()
        theirs.close()
        self.given: deque[tuple[int, Variant]] = deque()

    def give(self, index: int, variant: Variant) -> None:
        self.given.append((index, variant))
        with suppress(OSError):  # it is dead, as the next look will find
            self.pipe.send((index, variant))

    def take(self) -> tuple[int, Any]:
        """Return a result. Raises EOFError if the process is dead."""
        try:
            index, result = self.pipe.recv()
        except OSError:
            raise EOFError from None
        self.given.popleft()
        return index, result

    def end(self) -> None:
        self.process.terminate()
        self.process.join()
        self.pipe.close()


class Processes:
    """Makes variants in several processes at once."""

    def __init__(self, job: Job, folder: Folder, count: int) -> None:
        self.job, self.folder = job, folder
        # Forking takes along what is imported; with threads around it is not safe.
        safe = sys.platform == "linux" and world.can_fork and threading.active_count() == 1
        self.context = get_context("fork" if safe else "spawn")
        self.count = count
        self.workers: list[_Worker] = []
        self.tries: dict[int, int] = {}
        self.waiting: deque[tuple[int, Variant]] = deque()
        self.deaths = 0

    @property
    def room(self) -> bool:
        """Whether a process has less to do than it may."""
        return not self.waiting and self._has_room

    @property
    def _has_room(self) -> bool:
        return len(self.workers) < self.count or any(len(worker.given) < AHEAD for worker in self.workers)

    def submit(self, index: int, variant: Variant) -> None:
        """Give a variant to the process that has least to do."""
        if not self.workers:
            _prepare()
        least = min(self.workers, key=lambda worker: len(worker.given), default=None)
        if least is None or (least.given and len(self.workers) < self.count):
            least = _Worker(self.context, self.job, self.folder)
            self.workers.append(least)
        least.give(index, variant)

    def results(self) -> list[Result]:
        """Return what became of some variants."""
        found: list[Result] = []
        ready = connection.wait([worker.pipe for worker in self.workers], _LOOK)
        for worker in [worker for worker in self.workers if worker.pipe in ready]:
            try:
                index, result = worker.take()
            except EOFError:
                found += self._buried(worker)
                continue
            if isinstance(result, str):
                raise RuntimeError(f"a process of the sweep failed:\n{result}")
            self.deaths = 0
            self.tries.pop(index, None)
            found.append((index, result))
        while self.waiting and self._has_room:
            self.submit(*self.waiting.popleft())
        return found

    def close(self) -> None:
        """End the processes; what one is at stays undone."""
        for worker in self.workers:
            worker.end()
        self.workers = []

    def _buried(self, worker: _Worker) -> list[Result]:
        """Put what a dead process was given in line again; the variant that it was at a second time only."""
        self.workers.remove(worker)
        worker.end()
        self.deaths += 1
        if self.deaths >= _HOPELESS:
            raise RuntimeError(f"the processes of the sweep end at once (exit code {worker.process.exitcode})")
        given = list(worker.given)
        failed: list[Result] = []
        if given:
            index, variant = given[0]
            self.tries[index] = self.tries.get(index, 0) + 1
            if self.tries[index] >= _TRIES:
                failed.append((index, died(variant, worker.process.exitcode)))
                given = given[1:]
        self.waiting.extend(given)
        return failed


def died(variant: Variant, code: int | None = None) -> Made:
    """Return what became of a variant whose process died with an exit code, twice."""
    return Made(line_of(variant, {}, [death(variant, code)]), ERROR)


def death(variant: Variant, code: int | None = None) -> Diagnostic:
    """Return the error about a variant whose process died with an exit code, twice."""
    how = ""
    if code is not None:
        with suppress(ValueError):
            how = f" by {signal.Signals(-code).name}" if code < 0 else f", with exit code {code}"
    message = f"the process that compiled it was ended{how}, twice"
    return error("worker-died", message, variant.span, "out of memory? -j with a smaller number needs less")


def _prepare() -> None:
    """Import what every process needs, once."""
    from rosorin_compile import Compiled

    Compiled(None, (), [], ()).proven()


def _work(pipe: Any, job: Job, address: str, parent: int, lock: int | None) -> None:
    """Make variants that come through a pipe, until it ends or the run is dead."""
    import gc
    import traceback

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who presses Ctrl-C means the run, which ends us
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    Progress.hide()
    if lock is not None:
        os.close(lock)  # it goes when the run does
    gc.freeze()
    gc.enable()
    folder = folder_of(address)
    with folder.working():
        maker = Maker(job, folder)
        while True:
            try:
                while not pipe.poll(_LOOK):
                    if os.getppid() != parent:
                        return
                index, variant = pipe.recv()
            except (EOFError, OSError):
                return
            made: Made | str
            try:
                made = maker.make(variant)
            except MemoryError:
                os._exit(1)
            except Exception:
                made = traceback.format_exc()
            with suppress(BrokenPipeError):
                pipe.send((index, made))

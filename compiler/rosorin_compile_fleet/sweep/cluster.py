"""Cluster: the variants of a sweep made by dask.distributed, which looks after lost workers.

A worker needs no file of ours (see ``worker``): a bundle has, by content, all that the first variant was made of, and
the folder of the description. A variant for which a worker lacks a file is made here. The bundle stands in the graph of
the scheduler, so that a new worker gets it, too. Variants travel in batches that take about a second, and less towards
the end, so that all are done at about the same time.
"""

from __future__ import annotations

import json
import os
import queue
import time
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from operator import length_hint
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile import Variant
from rosorin_compile.diagnostics import Diagnostic, Heading, Rule, error, pip_install
from rosorin_compile.extending import Description, Given, Holding, tool_folders, world

from .engines import Result, death, died
from .folder import VariantsFolder
from .making import Folder, Job, Made, Maker, Row, compiled_here
from .running import Stopped
from .worker import Answer, Answers, Batch, Bundle, Task, tool, work

if TYPE_CHECKING:
    from rosorin_compile import Compiled

RULES = (
    Rule(
        "cluster-failed",
        "The scheduler of a cluster cannot be reached or went away, or a worker lacks this tool, or has another one.",
        "As the message says; a sweep goes on where it was.",
        Heading.WRITING,
    ),
)

MAX_FILES, MAX_BYTES = 2_000, 64_000_000  # of the folder of a description
_BATCH_SECONDS = 1.0
_MAX_BATCH = 64
_A_THREAD = 3  # batches in flight
_WAIT = 0.5
_PATIENCE = 10.0  # seconds in which the scheduler has to answer


def connect(address: str) -> Any:
    """Return a client of the scheduler at an address. Raises Stopped."""
    try:
        from distributed import Client

        make: Any = Client
    except ImportError:
        message = "--dask needs dask.distributed, which is not installed"
        raise Stopped(error("cluster-failed", message, None, pip_install("dask"))) from None
    try:
        return make(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as problem:
        reason = str(problem).partition("\n")[0] or type(problem).__name__
        message = f"there is no scheduler of dask at {address}: {reason}"
        raise Stopped(error("cluster-failed", message, None, "tcp://HOST:8786 is what dask scheduler prints")) from None


def bundle(first: Path, compiled: Compiled, packages: Mapping[str, Path]) -> Bundle:
    """Return what the workers need for a description of which one variant was compiled here."""
    own = list(tool_folders().values())
    wanted = {Path(os.path.abspath(path)): None for path in (first, *compiled.inputs)}
    wanted |= dict.fromkeys(_below(Path(os.path.abspath(first)).parent))
    files: dict[str, bytes] = {}
    for path in wanted:
        if not any(map(path.is_relative_to, own)):
            with suppress(OSError):
                files[str(path)] = world.read(path)
    folders = {name: str(folder) for name, folder in compiled.packages.items()}
    folders |= {name: os.path.abspath(folder) for name, folder in packages.items()}
    here = os.path.abspath(first.parent)
    named = ((f"{here}/", f"{first.parent}/" if str(first.parent) != "." else ""), (f"{world.here()}/", ""))
    told = json.dumps([{name: Holding.digest(data) for name, data in files.items()}, folders, named], sort_keys=True)
    return Bundle(files, os.path.abspath(first), folders, named, Holding.digest(told.encode()))


def _below(folder: Path) -> Iterator[Path]:
    """Yield the files below a folder, as many as a description may have with it; hidden ones aside."""
    count = size = 0
    waiting = [folder]
    while waiting:
        top = waiting.pop()
        inside: dict[str, str] = {}
        with suppress(OSError):
            inside = {name: kind for name, kind in world.names(top).items() if not name.startswith(".")}
        for path in (top / name for name, kind in inside.items() if kind == world.FILE):
            count, size = count + 1, size + world.size(path)
            if count > MAX_FILES or size > MAX_BYTES:
                return
            yield path
        folders = [top / name for name, kind in inside.items() if kind == world.FOLDER]
        waiting += [path for path in reversed(folders) if not world.link(path)]


class _Flight:
    """Batches of variants on their way: given to the cluster, and what comes back."""

    def __init__(self, client: Any, bundle: Bundle, task: Task, total: int) -> None:
        self.client, self.task, self.total = client, task, total
        self.bundle = client.submit(_same, bundle, key=f"rosorin-compile-{bundle.key}", pure=True)
        self.files = bundle.files
        self.home, self.projects = Path(bundle.first).parent, Description.at(Path(bundle.first)).projects
        self.batch: Batch = []
        self.each = _BATCH_SECONDS  # seconds a variant
        self.flying: dict[str, tuple[Any, Batch]] = {}
        self.landed: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.threads = 1
        self.looked = 0.0

    @property
    def room(self) -> bool:
        """Whether another variant can be taken."""
        return len(self.flying) < _A_THREAD * self._threads()

    def _threads(self) -> int:
        """Return how many threads the cluster has now; workers come and go."""
        if time.monotonic() - self.looked > 1.0:
            self.looked = time.monotonic()
            with suppress(Exception):
                self.threads = max(1, sum(self.client.nthreads().values()))
        return self.threads

    def submit(self, index: int, variant: Variant) -> None:
        """Take a variant; it goes with others."""
        self.batch.append((index, variant, self._own_files(variant)))
        if len(self.batch) >= self._size(index):
            self.send(self.batch)
            self.batch = []

    def _size(self, index: int) -> int:
        """Return how many variants go together: a share of those that are left, and no more than take a second."""
        share = (self.total - index) // (2 * self._threads()) if self.total else _MAX_BATCH
        return max(1, min(share, _MAX_BATCH, round(_BATCH_SECONDS / self.each)))

    def _own_files(self, variant: Variant) -> dict[str, bytes]:
        """Return the files that the arguments of a variant name, which are in no bundle."""
        found = {}
        for value in variant.arguments.values():
            if isinstance(value, str) and 0 < len(value) < 1_000 and "\0" not in value:
                path = Path(os.path.normpath(self.home / value))
                with suppress(OSError):
                    if str(path) not in self.files and self._may_read(path):
                        found[str(path)] = world.read(path)
        return found

    def _may_read(self, path: Path) -> bool:
        """Say whether a description may read a file: it is of its project. Raises OSError."""
        real = world.real(path)
        return (
            any(map(real.is_relative_to, self.projects))
            and world.kind(real) == world.FILE
            and world.size(real) <= MAX_BYTES
        )

    def send(self, batch: Batch) -> None:
        """Give a batch to the cluster."""
        future = self.client.submit(work, self.bundle, self.task, batch, pure=False)
        self.flying[future.key] = (future, batch)
        future.add_done_callback(lambda done: self.landed.put(done.key))

    def flush(self) -> None:
        """Send what waits for others."""
        if self.batch:
            self.send(self.batch)
            self.batch = []

    def land(self) -> Iterator[tuple[int, Variant, Answer | None]]:
        """Yield what came back; None for a variant whose worker died again and again. Raises Stopped."""
        self.flush()
        try:
            key = self.landed.get(timeout=_WAIT)
        except queue.Empty:
            if self.client.status not in ("running", "connecting"):
                raise Stopped(_gone()) from None
            return
        future, batch = self.flying.pop(key)
        answers = self._result(future, batch)
        if answers is None:
            return
        if isinstance(answers, Answers):
            if answers.tool != tool():
                message = f"a worker has rosorin-compile {answers.tool}, and here is {tool()}"
                raise Stopped(error("cluster-failed", message, None, "install the same one on both sides"))
            self.each = max(answers.seconds / len(batch), 1e-3)
        known = dict(answers.answers) if isinstance(answers, Answers) else {}
        for index, variant, _ in batch:
            yield index, variant, known.get(index)

    def _result(self, future: Any, batch: Batch) -> Answers | str | None:
        """Return the answers of a batch; None if it was sent once more, a text if its worker died too often."""
        from distributed import KilledWorker

        try:
            answers = future.result(timeout=_PATIENCE)
        except KilledWorker:
            if len(batch) == 1:
                return "died"
            for one in batch:
                self.send([one])
            return None
        except Exception as problem:
            if future.status in ("cancelled", "lost") or isinstance(problem, TimeoutError):
                if self.client.status != "running":
                    raise Stopped(_gone()) from None
                self.send(batch)
                return None
            raise Stopped(_failed(problem)) from None
        finally:
            future.release()
        made: Answers = answers
        return made

    def close(self) -> None:
        """Ask for nothing more."""
        with suppress(Exception):
            self.client.cancel([future for future, _ in self.flying.values()])


def _same(bundle: Bundle) -> Bundle:
    return bundle


def _gone() -> Diagnostic:
    return error("cluster-failed", "the scheduler of dask went away", None, "the same command goes on when it is back")


def _failed(problem: BaseException) -> Diagnostic:
    help = f"install on every worker what is installed here, with its extra; here that is: {pip_install('dask')}"
    if isinstance(problem, ImportError):
        return error("cluster-failed", f"a worker cannot run rosorin-compile: {problem}", None, help)
    if "deserialization" in str(problem):  # the scheduler could not even read what it was asked
        message = f"the scheduler and its workers have another rosorin-compile than here ({tool()}), or none"
        return error("cluster-failed", message, None, help.replace("on every worker", "there"))
    message = f"a worker failed: {type(problem).__name__}: {problem}"
    return error("cluster-failed", message, None, "the log of the worker says more")


class Cluster:
    """Makes ``total`` variants on a cluster; artifacts that a worker cannot write come back, and are written here."""

    def __init__(self, job: Job, folder: Folder, client: Any, total: int) -> None:
        self.maker = Maker(job, folder)
        self.client, self.total = client, total
        self.flight: _Flight | None = None
        self.asked: list[Row] = []
        self.done: list[Result] = []

    @property
    def room(self) -> bool:
        """Whether another variant can be taken."""
        return self.flight is None or self.flight.room

    def submit(self, index: int, variant: Variant) -> None:
        """Take a variant; the first one is made here, which says what the workers need."""
        if self.flight is not None:
            self.flight.submit(index, variant)
            return
        job, folder = self.maker.job, self.maker.folder
        with world.noting() as notes:
            world.note_tool()
            compiled = self.maker.compiled(variant)
        made = bundle(job.description.path, compiled, job.packages)
        rows = notes.rows()
        self.asked = self.maker.asked(variant, rows)
        task = Task(job.shared, job.trust, tool(), out=folder.address, key=job.key, asked=tuple(self.asked))
        if isinstance(folder, VariantsFolder):
            task = task._replace(out=os.path.abspath(folder.path), run=folder.announced())
        self.flight = _Flight(self.client, made, task, self.total)
        self.done.append((index, self.maker.finished(variant, compiled, rows)))

    def results(self) -> list[Result]:
        """Return what became of some variants. Raises Stopped."""
        done, self.done = self.done, []
        if done or self.flight is None:
            return done
        return [(index, self._taken(variant, answer)) for index, variant, answer in self.flight.land()]

    def _taken(self, variant: Variant, answer: Answer | None) -> Made:
        if answer is None:
            return died(variant)
        if answer.lacking:
            return self.maker.make(variant)
        if answer.made is not None:
            return answer.made
        artifacts = {name: zlib.decompress(data) for name, data in answer.files.items()}
        asked = [*self.asked, *answer.read] if answer.read and self.asked else []
        return self.maker.take(variant, answer.line, artifacts, asked)

    def close(self) -> None:
        """Ask for nothing more, and leave the cluster."""
        if self.flight is not None:
            self.flight.close()
        with suppress(Exception):
            self.client.close()


def compiled_on(client: Any, first: Path, given: Given, variants: Iterable[Variant]) -> Iterator[Compiled]:
    """Yield what becomes of variants on a cluster, as it comes (see ``library``)."""
    from rosorin_compile import Compiled

    rest, total = enumerate(variants), length_hint(variants)
    flight: _Flight | None = None
    more = True
    try:
        while more or flight is None or flight.flying or flight.batch:
            while more and (flight is None or flight.room):
                index, variant = next(rest, (0, None))
                if variant is None:
                    more = False
                    break
                if flight is None:
                    compiled = compiled_here(first, given, variant)
                    made = bundle(first, compiled, given.packages)
                    flight = _Flight(client, made, Task(given.values(), False, tool(), whole=True), total)
                    yield compiled
                    continue
                flight.submit(index, variant)
            if flight is None:
                return
            if not flight.flying and not flight.batch:
                continue
            for _, variant, answer in flight.land():
                if answer is None:
                    yield Compiled(None, (), [death(variant)], (), variant=variant)
                elif answer.lacking or answer.compiled is None:
                    yield compiled_here(first, given, variant)
                else:
                    yield answer.compiled
    finally:
        if flight is not None:
            flight.close()

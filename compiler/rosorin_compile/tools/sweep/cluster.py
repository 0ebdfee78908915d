"""Cluster: the variants of a sweep made by dask.distributed, which looks after lost workers.

A worker needs no file of ours: a bundle has, by content, all that the first variant was made of, and the folder of the
description. Each worker unpacks it once, at the same paths below a folder of its own, and names files in its messages
as they are named here. A variant for which a worker lacks a file is made here. The bundle stands in the graph of the
scheduler, so that a new worker gets it, too. Variants travel in batches that take about a second.
"""

from __future__ import annotations

import hashlib
import json
import os
import queue
import tempfile
import threading
import time
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ... import __version__
from ...diagnostics import Diagnostic, error, has_errors
from ...diagnostics.registry import WRITING, Rule
from ...frontend.asked import Asked
from ...frontend.expand.files import Kept
from ...frontend.variants import Variant
from ...output import OutputError
from ...output.ours import digest
from ...output.remote import RemoteFolder, folder_of
from ...output.variants import VariantsFolder
from ...project import DATA, ROS_PACKAGE, Description, Resolved, data_folder, projects_of
from ...startup.records import NamedTuple
from .engines import Result, death, died
from .making import Folder, Job, Made, Maker, compiled_here, files_of, line_of
from .running import Stopped

if TYPE_CHECKING:
    from ...pipeline import Compiled

RULES = (
    Rule(
        "cluster-failed",
        "The scheduler of a cluster cannot be reached or went away, or a worker lacks this tool, or has another one.",
        "As the message says; a sweep goes on where it was.",
        WRITING,
    ),
)

PIP = "pip install 'rosorin-compile[dask]'"
MAX_FILES, MAX_BYTES = 2_000, 64_000_000  # of the folder of a description
_BATCH_SECONDS = 1.0
_MAX_BATCH = 64
_A_THREAD = 3  # batches in flight
_WAIT = 0.5
_PATIENCE = 10.0  # seconds in which the scheduler has to answer
_MISSING = ("file-unreadable", "package-missing", "template-missing", "include-outside")


class Bundle(NamedTuple):
    """What a description is made of, bytes by absolute path; ``named`` says how paths are shown here."""

    files: dict[str, bytes]
    first: str
    packages: dict[str, str]
    named: tuple[tuple[str, str], ...]
    key: str


class Answer(NamedTuple):
    """What a worker made: the line of the index, the artifacts (compressed), and the digests of what was read.

    ``lacking`` says that a file was looked for that may be here. Instead of files there is what became of the variant,
    where the worker has written them, or ``compiled`` for the library.
    """

    line: str
    files: dict[str, bytes]
    read: dict[str, str]
    lacking: bool
    made: Made | None = None
    compiled: Compiled | None = None


class Answers(NamedTuple):
    """What a worker made of a batch, in what time, and by which tool."""

    answers: list[tuple[int, Answer]]
    seconds: float
    tool: str


def connect(address: str) -> Any:
    """Return a client of the scheduler at an address. Raises Stopped."""
    try:
        from distributed import Client

        make: Any = Client
    except ImportError:
        message = "--dask needs dask.distributed, which is not installed"
        raise Stopped(error("cluster-failed", message, None, PIP)) from None
    try:
        return make(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as problem:
        reason = str(problem).partition("\n")[0] or type(problem).__name__
        message = f"there is no scheduler of dask at {address}: {reason}"
        raise Stopped(error("cluster-failed", message, None, "tcp://HOST:8786 is what dask scheduler prints")) from None


# The bundle.


def bundle(first: Path, compiled: Compiled, packages: Mapping[str, Path]) -> Bundle:
    """Return what the workers need for a description of which one variant was compiled here."""
    own = [data_folder(name) for name in DATA] + [Path(__file__).parents[2]]
    wanted = {Path(os.path.abspath(path)): None for path in (first, *compiled.inputs)}
    wanted |= dict.fromkeys(_below(Path(os.path.abspath(first)).parent))
    files: dict[str, bytes] = {}
    for path in wanted:
        if not any(map(path.is_relative_to, own)):
            with suppress(OSError):
                files[str(path)] = path.read_bytes()
    folders = {one.name: one.answer for one in compiled.resolved if one.kind == ROS_PACKAGE and one.answer}
    folders |= {name: os.path.abspath(folder) for name, folder in packages.items()}
    here = os.path.abspath(first.parent)
    named = ((f"{here}/", f"{first.parent}/" if str(first.parent) != "." else ""), (f"{Path.cwd()}/", ""))
    told = json.dumps([{name: digest(data) for name, data in files.items()}, folders, named], sort_keys=True)
    return Bundle(files, os.path.abspath(first), folders, named, digest(told.encode()))


def _below(folder: Path) -> Iterator[Path]:
    """Yield the files below a folder, as many as a description may have with it; hidden ones aside."""
    count = size = 0
    for top, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            path = Path(top, name)
            if name.startswith(".") or not path.is_file():
                continue
            count, size = count + 1, size + path.stat().st_size
            if count > MAX_FILES or size > MAX_BYTES:
                return
            yield path


_lock = threading.Lock()
_unpacked: dict[str, Path] = {}
_kept: dict[str, Kept] = {}
_tools: list[str] = []


def tool() -> str:
    """Return what tells this tool from another: its version and the contents of its sources."""
    if not _tools:
        known = hashlib.sha256()
        for folder in (Path(__file__).parents[2], *map(data_folder, DATA)):
            for path in sorted(folder.rglob("*")):
                if path.is_file() and "__pycache__" not in path.parts:
                    known.update(path.name.encode() + hashlib.sha256(path.read_bytes()).digest())
        _tools.append(f"{__version__} ({known.hexdigest()[:12]})")
    return _tools[0]


def _unpack(bundle: Bundle) -> Path:
    """Return the folder below which the files of a bundle stand in this process."""
    if bundle.key in _unpacked and _unpacked[bundle.key].is_dir():
        return _unpacked[bundle.key]
    place = None
    with suppress(ImportError, ValueError):
        from distributed import get_worker

        place = get_worker().local_directory  # goes with the worker
    root = Path(os.path.realpath(tempfile.mkdtemp(prefix="rosorin-compile-", dir=place)))
    for name, data in bundle.files.items():
        _unpack_one(root, name, data)
    _unpacked[bundle.key] = root
    return root


def _unpack_one(root: Path, name: str, data: bytes) -> None:
    path = _within(root, name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def _within(root: Path, name: str) -> Path:
    return root / name.lstrip("/")


# What a worker does.


class Task(NamedTuple):
    """What is the same for all batches: arguments of all variants, whom to trust, and what is wanted of each.

    ``whole``: what was compiled, for the library; ``out``: that the artifacts are written there; else that they come.
    ``key`` is that of the job.
    """

    shared: dict[str, Any]
    trust: bool
    whole: bool = False
    out: str = ""
    key: str = ""


def work(bundle: Bundle, task: Task, batch: list[tuple[int, Variant, dict[str, bytes]]]) -> Answers:
    """Make a batch of variants; this is what runs on a worker, one batch at a time in a process."""
    begun = time.perf_counter()
    with _lock:
        root = _unpack(bundle)
        answers = []
        for index, variant, files in batch:
            for name, data in files.items():
                _unpack_one(root, name, data)
            answers.append((index, _answer(root, bundle, task, variant)))
            for name in files:
                _within(root, name).unlink(missing_ok=True)
    return Answers(answers, time.perf_counter() - begun, tool())


def _answer(root: Path, bundle: Bundle, task: Task, variant: Variant) -> Answer:
    packages = {name: _within(root, folder) for name, folder in bundle.packages.items()}
    nowhere = VariantsFolder(root / "outputs")
    first = _within(root, bundle.first)
    maker = Maker(Job(Description("", first, root), task.shared, packages, task.trust, ""), nowhere)
    maker.kept = _kept.setdefault(bundle.key, maker.kept)
    if task.whole:
        return _whole(maker, root, bundle, variant)
    compiled = maker.compiled(variant)
    said = [*variant.diagnostics, *compiled.diagnostics]
    files: dict[str, bytes] = {}
    try:
        if not has_errors(said):
            files = files_of(compiled)
    except OutputError as problem:
        said.append(problem.diagnostic)
    line = _named(line_of(variant, {name: digest(data) for name, data in files.items()}, said), root, bundle)
    read = _read(root, compiled) if files else {}
    lacking = _lacking(root, compiled, said)
    if task.out and not lacking:
        folder = folder_of(task.out)
        there = Maker(maker.job._replace(key=task.key), folder)
        resolved = [tuple(_shown(text, root, bundle) for text in one) for one in compiled.resolved]
        return Answer(line, {}, {}, False, there.take(variant, line, files, read, resolved))
    packed = {name: zlib.compress(data, 1) for name, data in files.items()}
    return Answer(line, packed, read, lacking)


def _read(root: Path, compiled: Compiled) -> dict[str, str]:
    """Return the digests of the files that a variant was made of, by their paths where the sweep was asked for."""
    inputs = [path for path in dict.fromkeys(compiled.inputs) if path.is_relative_to(root) and path.is_file()]
    return {f"/{path.relative_to(root)}": digest(path.read_bytes()) for path in inputs}


def _whole(maker: Maker, root: Path, bundle: Bundle, variant: Variant) -> Answer:
    """Return the same for the library, which wants what was compiled and no files."""
    job = maker.job
    compiled = compiled_here(job.description.path, Asked("", job.shared, job.packages, []), variant, maker.kept)
    lacking = _lacking(root, compiled, compiled.diagnostics)
    inputs = tuple(Path(_shown(str(path), root, bundle)) for path in compiled.inputs)
    said = [_moved(one, root, bundle) for one in compiled.diagnostics]
    resolved = tuple(Resolved(*(_shown(text, root, bundle) for text in one)) for one in compiled.resolved)
    moved = compiled._replace(inputs=inputs, diagnostics=said, resolved=resolved)
    return Answer("", {}, {}, lacking, compiled=moved)


def _lacking(root: Path, compiled: Compiled, said: Iterable[Diagnostic]) -> bool:
    """Say whether a file was looked for that is not here."""
    if any(path.is_relative_to(root) and not path.exists() for path in compiled.inputs):
        return True
    if compiled.meshes is not None and compiled.meshes.missing:
        return True
    return any(one.rule in _MISSING for one in said)


def _shown(text: str, root: Path, bundle: Bundle) -> str:
    """Return a text with paths as they are shown where the sweep was asked for."""
    relative = f"{os.path.relpath(root)}/"
    text = text.replace(relative, f"{root}/") if not relative.startswith("..") else text
    for path, shown in bundle.named:
        text = text.replace(f"{root}{path}", shown)
    return text.replace(f"{root}/", "/")


def _named(line: str, root: Path, bundle: Bundle) -> str:
    if root.name not in line:
        return line

    def through(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: through(one) for key, one in value.items()}
        if isinstance(value, list):
            return [through(one) for one in value]
        return _shown(value, root, bundle) if isinstance(value, str) else value

    entry = json.loads(line)
    return json.dumps({**entry, "diagnostics": through(entry["diagnostics"])})


def _moved(diagnostic: Diagnostic, root: Path, bundle: Bundle) -> Diagnostic:
    """Return a diagnostic whose places are shown as they are where the sweep was asked for."""

    def moved(one: Any) -> Any:
        span = one.span
        if span is not None:
            path = _shown(span.source.path, root, bundle)
            one = one._replace(span=span._replace(source=span.source._replace(path=path)))
        return one._replace(message=_shown(one.message, root, bundle))

    made: Diagnostic = moved(diagnostic)
    return made._replace(related=tuple(map(moved, made.related)), help=_shown(made.help, root, bundle))


# What is done here.


class _Flight:
    """Batches of variants on their way: given to the cluster, and what comes back."""

    def __init__(self, client: Any, bundle: Bundle, task: Task) -> None:
        self.client, self.task = client, task
        self.bundle = client.submit(_same, bundle, key=f"rosorin-compile-{bundle.key}", pure=True)
        self.files = bundle.files
        self.home, self.projects = Path(bundle.first).parent, projects_of(Path(bundle.first))
        self.batch: list[tuple[int, Variant, dict[str, bytes]]] = []
        self.size = 1
        self.flying: dict[str, tuple[Any, list[tuple[int, Variant, dict[str, bytes]]]]] = {}
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
        if len(self.batch) >= self.size:
            self.send(self.batch)
            self.batch = []

    def _own_files(self, variant: Variant) -> dict[str, bytes]:
        """Return the files that the arguments of a variant name, which are in no bundle."""
        found = {}
        for value in variant.arguments.values():
            if isinstance(value, str) and 0 < len(value) < 1_000 and "\0" not in value:
                path = Path(os.path.normpath(self.home / value))
                with suppress(OSError):
                    if str(path) not in self.files and self._may_read(path):
                        found[str(path)] = path.read_bytes()
        return found

    def _may_read(self, path: Path) -> bool:
        """Say whether a description may read a file: it is of its project. Raises OSError."""
        real = Path(os.path.realpath(path))
        return any(map(real.is_relative_to, self.projects)) and real.is_file() and real.stat().st_size <= MAX_BYTES

    def send(self, batch: list[tuple[int, Variant, dict[str, bytes]]]) -> None:
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
            each = max(answers.seconds / max(1, len(batch)), 1e-3)
            self.size = max(1, min(_MAX_BATCH, round(_BATCH_SECONDS / each)))
        known = dict(answers.answers) if isinstance(answers, Answers) else {}
        for index, variant, _ in batch:
            yield index, variant, known.get(index)

    def _result(self, future: Any, batch: list[tuple[int, Variant, dict[str, bytes]]]) -> Answers | str | None:
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
    if isinstance(problem, ImportError):
        help = f"on every worker: {PIP}"
        return error("cluster-failed", f"a worker cannot run rosorin-compile: {problem}", None, help)
    message = f"a worker failed: {type(problem).__name__}: {problem}"
    return error("cluster-failed", message, None, "the log of the worker says more")


class Cluster:
    """Makes variants on a cluster; the artifacts come back, and are written here."""

    def __init__(self, job: Job, folder: Folder, client: Any) -> None:
        self.maker = Maker(job, folder)
        self.client = client
        self.flight: _Flight | None = None
        self.resolved: list[list[str]] = []
        self.done: list[Result] = []

    @property
    def room(self) -> bool:
        """Whether another variant can be taken."""
        return self.flight is None or self.flight.room

    def submit(self, index: int, variant: Variant) -> None:
        """Take a variant; the first one is compiled here, which says what the workers need."""
        if self.flight is None:
            job = self.maker.job
            compiled = self.maker.compiled(variant)
            made = bundle(job.description.path, compiled, job.packages)
            self.resolved = [list(one) for one in compiled.resolved]
            out = self.maker.folder.address if isinstance(self.maker.folder, RemoteFolder) else ""
            self.flight = _Flight(self.client, made, Task(job.shared, job.trust, out=out, key=job.key))
        self.flight.submit(index, variant)

    def results(self) -> list[Result]:
        """Return what became of some variants. Raises Stopped."""
        if self.flight is None:
            return []
        return [(index, self._taken(variant, answer)) for index, variant, answer in self.flight.land()]

    def _taken(self, variant: Variant, answer: Answer | None) -> Made:
        if answer is None:
            return died(variant)
        if answer.lacking:
            return self.maker.make(variant)
        if answer.made is not None:
            return answer.made
        artifacts = {name: zlib.decompress(data) for name, data in answer.files.items()}
        return self.maker.take(variant, answer.line, artifacts, answer.read, self.resolved)

    def close(self) -> None:
        """Ask for nothing more, and leave the cluster."""
        if self.flight is not None:
            self.flight.close()
        with suppress(Exception):
            self.client.close()


def compiled_on(client: Any, first: Path, asked: Asked, variants: Iterable[Variant]) -> Iterator[Compiled]:
    """Yield what becomes of variants on a cluster, as it comes (see ``library``)."""
    from ...pipeline import Compiled

    rest = enumerate(variants)
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
                    compiled = compiled_here(first, asked, variant)
                    made = bundle(first, compiled, asked.packages)
                    flight = _Flight(client, made, Task(asked.arguments, False, whole=True))
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
                    yield compiled_here(first, asked, variant)
                else:
                    yield answer.compiled
    finally:
        if flight is not None:
            flight.close()

"""Compile the variants of a sweep in this process, in child processes or on a Dask cluster, without writing them."""

import gc
import json
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from importlib import import_module
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from rosorin_compile.formats.compilation import CompileResult, Variant, compile_robot
from rosorin_compile.output.artifact_set import check_names, encode
from rosorin_compile.output.atomic_files import OutputError, digest
from rosorin_compile.request import Request, prove
from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import Diagnostic, Related, Source, Span, error, has_errors
from rosorin_compile.source.files import read_bytes, read_text
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import tool_folders
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.tree import Map
from rosorin_compile.source.version import __version__

_lock = threading.Lock()  # allows one compilation at a time, because a Dask worker may have several threads
_parsed: dict[Path, dict[Path, Any]] = {}  # cache of parsed description files, by working directory


@dataclass(frozen=True)
class Job:
    """The input that all variants of a sweep share: the robot, common arguments, and the working directory."""

    request: Request  # the robot to compile, and the output folder of the sweep
    shared: dict[str, Any]
    current: Path = field(default_factory=Path.cwd)
    version: str = __version__

    def is_current(self, variant: Variant, record: Mapping[str, Any]) -> bool:
        """Return True if a variant was written with the same arguments, and its input files have not changed since."""
        same = (input_digest(path) == before for path, before in record["inputs"].items())
        return bool(record["key"] == self.key(variant)) and all(same)

    def key(self, variant: Variant) -> str:
        """Return a digest of everything that affects a variant, except the contents of its input files."""
        packages = sorted((name, os.path.abspath(folder)) for name, folder in self.request.packages.items())
        job = [self.state, str(self.request.description.path), str(self.current), self.request.trust, packages]
        arguments = plain([self.shared, variant.arguments], typed=True)
        return digest(json.dumps([*job, variant.name, arguments]).encode())

    @cached_property
    def state(self) -> str:
        """A digest of the version of this tool, the installed Python packages and the ROS package search path."""
        files = [path for folder in tool_folders().values() for path in folder.rglob("*") if path.suffix != ".pyc"]
        parts = [f"{one.metadata['Name']} {one.version}" for one in distributions()]
        parts += [f"{path} {path.stat().st_mtime_ns}" for path in files if path.is_file()]
        variables = [os.environ.get(name, "") for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")]
        return digest(json.dumps([variables, sorted(parts)]).encode())


@dataclass(frozen=True)
class Result:
    """A compiled variant: its entry in ``sweep.json``, its artifacts, and the digests of its input files by path."""

    entry: dict[str, Any]
    files: Mapping[str, bytes]
    inputs: Mapping[str, str]


def compile_variant(job: Job, variant: Variant) -> Result:
    """Compile a variant; errors are part of the result. Raises ValueError in a worker with another version."""
    with _entered(job):
        start = time.time_ns()
        description = job.request.description
        placed = replace(description, outputs=description.outputs / variant.name)
        compiled = prove(_compiled(job, variant, replace(job.request, description=placed).search_meshes))
        found, files = compiled.diagnostics, dict[str, bytes]()
        if not has_errors(found):
            try:
                files = {**compiled.mesh_files, **{one.file: encode(one.file, one.text) for one in compiled.artifacts}}
                check_names(files)
            except OutputError as problem:
                files, found = {}, [*found, problem.diagnostic]
        entry = entry_of(variant, found, {name: digest(data) for name, data in files.items()})
        # The list of variants is an input if a diagnostic has a position in it, because this position can change.
        mentioned = {place.get("file") for one in entry["diagnostics"] for place in (one, *one["related"])}
        listed = mentioned & {span.source.path for span in variant.arguments.value_spans.values()}
        inputs = map(os.path.abspath, (*compiled.inputs, *listed))
        return Result(entry, files, {path: input_digest(path, start) for path in inputs})


def compile_only(job: Job, variant: Variant) -> CompileResult:
    """Compile a variant for the Python API, without mesh files. Raises ValueError in a worker with another version."""
    with _entered(job):
        return replace(_compiled(job, variant), variant=variant)


def _compiled(job: Job, variant: Variant, search: Any = None) -> CompileResult:
    if has_errors(variant.diagnostics):
        return CompileResult(None, (), list(variant.diagnostics), ())
    arguments = Map(variant.arguments.span)
    for source in (job.shared, variant.arguments):  # arguments of the variant override shared arguments
        arguments.update(source)
        if isinstance(source, Map):
            for name in source.value_spans:
                arguments.put_from(source, name)
    request, kept = job.request, _parsed.setdefault(job.current, {})
    path, packages = request.description.path, request.packages
    compiled = compile_robot(path, arguments, request.tell, packages, search, cache=kept)
    return replace(compiled, diagnostics=[*variant.diagnostics, *compiled.diagnostics])


@contextmanager
def _entered(job: Job) -> Iterator[None]:
    if job.version != __version__:
        raise ValueError(f"the worker has rosorin-compile {__version__}, not {job.version}")
    with _lock, Progress.hide_steps():
        before = Path.cwd()
        try:
            os.chdir(job.current)
            yield
        finally:
            os.chdir(before)


def entry_of(variant: Variant, found: list[Diagnostic], artifacts: Mapping[str, str]) -> dict[str, Any]:
    """Return the entry of a variant for ``sweep.json``; ``artifacts`` maps file names to digests."""
    return {
        "name": variant.name,
        "folder": variant.name,
        "arguments": plain(variant.arguments),
        "status": "error" if has_errors(found) else "made",
        "artifacts": dict(sorted(artifacts.items())),
        "diagnostics": [one.as_object() for one in found],
    }


def from_json(found: Mapping[str, Any], variants: str) -> Diagnostic:
    """Convert a diagnostic in ``sweep.json``; ``variants`` is the start of the message, such as "low and 3 more"."""

    def span_of(place: Mapping[str, Any]) -> Span | None:
        text = ""
        with suppress(OSError, ValueError):
            text = read_text(place["file"]) if "file" in place else ""
        source = Source(place.get("file", ""), text)
        return Span(source, place["line"], place["column"], place["length"]) if source.path else None

    related = tuple(Related(one["message"], span_of(one)) for one in found["related"])
    message = f"{variants}: {found['message']}"
    return Diagnostic(found["rule"], found["severity"], message, span_of(found), related, found["help"])


def plain(value: Any, typed: bool = False) -> Any:
    """Convert an argument to JSON data; a quantity becomes its text ("5 cm"). ``typed`` adds the type of each value."""
    made = value
    if isinstance(value, dict):
        made = {str(key): plain(item, typed) for key, item in value.items()}
    elif isinstance(value, list):
        made = [plain(item, typed) for item in value]
    elif isinstance(value, float):
        made = getattr(value, "text", "") or (float(value) if math.isfinite(value) else str(float(value)))
    elif isinstance(value, str):
        made = str(value)
    return [type(value).__name__, made] if typed else made


def input_digest(path: str, start: float = math.inf) -> str:
    """Return the digest of a file, "changed" if it was modified after ``start`` (ns), or "" if it is unreadable."""
    with suppress(OSError):
        status = Path(path).stat()
        is_new = max(status.st_mtime_ns, status.st_ctime_ns) >= start
        return "changed" if is_new else _content_digest(path, status.st_mtime_ns, status.st_size)
    return ""


@lru_cache(maxsize=4096)
def _content_digest(path: str, *_: int) -> str:
    return digest(read_bytes(path))


_TIMEOUT = 10  # seconds to wait for a Dask scheduler and its workers
Work = Callable[[Variant], Any]


def connect(address: str) -> Any:
    """Connect to the Dask scheduler at an address, and return the Dask client. Raises OutputError."""
    try:
        client = import_module("distributed").Client(address, timeout=_TIMEOUT, set_as_default=False)
        client.wait_for_workers(1, timeout=_TIMEOUT)
        return client
    except ImportError:
        message, help = "--dask needs distributed, which is not installed", pip_install("dask")
    except Exception as problem:
        message, help = f"no scheduler with workers at {address}: {problem}", "start dask scheduler and dask worker"
    raise OutputError("cluster-failed", message.partition("\n")[0], help)


def compile_in_order(
    variants: Iterable[Variant], work: Work, jobs: int = 1, client: Any = None, known: Work = lambda _: None
) -> Iterator[tuple[Variant, Any]]:
    """Yield (variant, ``work(variant)``) in order, computed by ``jobs`` processes or by a Dask client.

    If ``known(variant)`` is not None, it is the result; if the process died, the result is a diagnostic. Raises
    OutputError if the Dask cluster fails.
    """
    gc.enable()  # the command line disables garbage collection for short runs
    pool: Any = _processes(jobs) if jobs > 1 and client is None else None
    if client is not None:
        jobs, pool = max(1, sum(client.nthreads().values())), client.get_executor(pure=False)
    waiting: deque[tuple[Variant, Any]] = deque()
    try:
        for variant in variants:
            result = known(variant)
            if result is None:
                try:
                    result = work(variant) if pool is None else pool.submit(work, variant)
                except BrokenProcessPool:
                    pool = _processes(jobs)
                    result = pool.submit(work, variant)
            waiting.append((variant, result))
            # Limit the number of waiting results, so that memory does not grow with the number of variants.
            while waiting and (len(waiting) > 2 * jobs or not isinstance(head := waiting[0][1], Future) or head.done()):
                yield _finished(*waiting.popleft(), work, client)
        while waiting:
            yield _finished(*waiting.popleft(), work, client)
    finally:
        if pool is not None:
            pool.shutdown(**({"cancel_futures": True} if client is None else {"wait": False}))


def _finished(variant: Variant, result: Any, work: Work, client: Any) -> tuple[Variant, Any]:
    """Wait for the result of a variant; if the process died, compile the variant again in a new process."""
    try:
        return variant, result.result() if isinstance(result, Future) else result
    except (BrokenProcessPool, MemoryError):
        pass
    except (Exception, CancelledError) as problem:
        if client is None:
            raise
        if type(problem).__name__ != "KilledWorker":
            message = f"the Dask cluster failed: {type(problem).__name__}: {problem}"
            help = f"scheduler and workers need rosorin-compile {__version__} and must see the files at the same paths"
            raise OutputError("cluster-failed", message, help) from None
    with _processes(1) as alone:
        try:
            return variant, alone.submit(work, variant).result()
        except (BrokenProcessPool, MemoryError):
            return variant, error("worker-died", "the process that compiled it died, twice", variant.span)


def _processes(jobs: int) -> ProcessPoolExecutor:
    # A forked process starts fast, because all modules are loaded, but forking is unsafe while other threads run.
    forks = sys.platform == "linux" and system.HAS_FORK and threading.active_count() == 1
    context = multiprocessing.get_context("fork" if forks else "spawn")
    Progress.wipe()
    return ProcessPoolExecutor(jobs, context, _begin_worker, (os.getpid(),))


def _begin_worker(parent: int) -> None:
    def end_with_parent() -> None:
        while os.getppid() == parent:
            time.sleep(0.5)
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_DFL)  # exit silently after Ctrl-C
    Progress.hide()
    threading.Thread(target=end_with_parent, daemon=True).start()

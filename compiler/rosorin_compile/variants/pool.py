"""Compile variants in this process, in several, or by the workers of a Dask scheduler."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from rosorin_compile.formats.compilation import Variant
from rosorin_compile.output import OutputError
from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.version import __version__

_TIMEOUT = 10  # seconds in which a scheduler has to answer
cores = system.cores
Work = Callable[[Variant], Any]


def connect(address: str) -> Any:
    """Return a client of the Dask scheduler at an address. Raises OutputError."""
    try:
        from distributed import Client

        make: Any = Client
        client = make(address, timeout=_TIMEOUT, set_as_default=False)
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
    """Yield each variant with its result: that of ``known``, or else of ``work``; a diagnostic if its process died.

    The work is done by ``jobs`` processes, or by a Dask client. Raises OutputError if the client fails.
    """
    gc.enable()  # the command line disables it for commands that compile one robot
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
            # Few results wait for their turn, so that memory does not grow with the list.
            while waiting and (len(waiting) > 2 * jobs or not isinstance(head := waiting[0][1], Future) or head.done()):
                yield _finished(*waiting.popleft(), work, client)
        while waiting:
            yield _finished(*waiting.popleft(), work, client)
    finally:
        if pool is not None:
            pool.shutdown(**({"cancel_futures": True} if client is None else {"wait": False}))


def _finished(variant: Variant, result: Any, work: Work, client: Any) -> tuple[Variant, Any]:
    """Wait for the result of a variant; if its process died, compile it again in a process of its own."""
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
    # A forked process need not import anything, but forking is unsafe while other threads run.
    forks = sys.platform == "linux" and system.HAS_FORK and threading.active_count() == 1
    context = multiprocessing.get_context("fork" if forks else "spawn")
    Progress.wipe()
    return ProcessPoolExecutor(jobs, context, _begin_worker, (os.getpid(),))


def _begin_worker(parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # so that Ctrl-C prints no traceback
    Progress.hide()
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(0.5)
    os._exit(1)

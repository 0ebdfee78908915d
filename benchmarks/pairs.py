"""Timing of two commands in pairs: A, B, A, B, ... so that a machine whose speed drifts does not favour one."""

from __future__ import annotations

import os
import statistics
import subprocess
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple


class Ratio(NamedTuple):
    """Seconds of both commands (medians) and the ratio A/B, pair by pair: smallest, median, largest."""

    first: float
    second: float
    low: float
    median: float
    high: float


def wall_time(command: Sequence[str], prepare: Callable[[], None] | None = None) -> float:
    """Return the wall seconds of one whole process, which has to succeed; ``prepare`` is not counted."""
    if prepare is not None:
        prepare()
    start = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - start


class Used(NamedTuple):
    """What one command used: seconds of processor, user and system together, and the most memory at a time (MiB)."""

    seconds: float
    memory: float


def used(command: Sequence[str], prepare: Callable[[], None] | None = None) -> Used:
    """Return what one command used, which has to succeed; other programs on the machine count for little."""
    if prepare is not None:
        prepare()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return Used(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def compare(first: Callable[[], float], second: Callable[[], float], pairs: int, warm_up: int = 1) -> Ratio:
    """Run both ``pairs`` times in turn, after ``warm_up`` pairs that are not counted."""
    times = [(first(), second()) for _ in range(pairs + warm_up)][warm_up:]
    ratios = [a / b for a, b in times]
    medians = [statistics.median(column) for column in zip(*times, strict=True)]
    return Ratio(medians[0], medians[1], min(ratios), statistics.median(ratios), max(ratios))


def row(name: str, ratio: Ratio, goal: float | None = None) -> str:
    """Return one line of a table of results."""
    told = f"{ratio.median:6.3f} ({ratio.low:.3f} to {ratio.high:.3f})"
    told += "" if goal is None else f"   goal {goal:g}"
    return f"{name:<42} {ratio.first * 1e3:8.1f} ms {ratio.second * 1e3:8.1f} ms   {told}"

"""Measure ``rosorin-compile sweep``: time per variant and memory for many variants, processes, a Dask cluster.

Each line is the ratio of two runs on this machine, with its goal. The robot is that of descriptions/rosorin with the
height of its lidar as an argument. Usage: ``python benchmarks/sweep.py [MANY] [FEW]``, by default 1,000 and 100; the
goals are for 10,000.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
TOOL = str(Path(sys.executable).parent / "rosorin-compile")
HEIGHT = "0.106748"
PAIRS = 5


class Run(NamedTuple):
    """Wall seconds of a whole run, and the memory of its largest process, in MiB."""

    seconds: float
    memory: float


def main(many: int, few: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        os.environ["ROSORIN_COMPILE_CACHE"] = str(Path(name, "cache"))
        robot(Path("descriptions/rosorin"))
        for count in (few, 3 * few, many):
            table(count)
        sweep(few, "-j", "2")  # compiled templates and the like
        print(f"{'sweep of the reference robot':<44} {'first':>12} {'second':>12}   ratio")
        small, large = sweep(few, "-j", "2"), sweep(many, "-j", "2")
        row(f"ms a variant, {many:,} / {few:,}", each(large, many), each(small, few), "at most 1.1")
        row(f"MiB of the largest process, {many:,} / {few:,}", large.memory, small.memory, "at most 1.1")
        again = sweep(many, "-j", "2", anew=False)
        row("ms a variant, unchanged / made", each(again, many), each(large, many), "at most 0.05")
        alone, two = sweep(few, "-j", "1"), sweep(few, "-j", "2")
        row(f"seconds, -j 1 / -j 2, {few:,}", alone.seconds, two.seconds, "at least 1.8")
        cluster(few, 3 * few)


def robot(folder: Path) -> None:
    """Write the reference robot with the height of its lidar as an argument."""
    shutil.copytree(HERE.parent / "descriptions" / "rosorin", folder)
    edit(folder / "lidar_and_imu.yaml", HEIGHT, '"${lidar_height}"')
    edit(folder / "robot.yaml", "args:\n", f"args:\n  lidar_height: {{type: length, default: {HEIGHT}}}\n")


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    if text.count(old) != 1:
        raise SystemExit(f"{path.name} has not one {old!r}")
    path.write_text(text.replace(old, new), "utf-8")


def table(count: int) -> None:
    rows = "".join(f"r{number:06},{float(HEIGHT) + number * 1e-7:.7f}\n" for number in range(count))
    Path(f"{count}.csv").write_text(f"name,lidar_height\n{rows}", "utf-8")


def sweep(count: int, *words: str, anew: bool = True) -> Run:
    """Run a sweep of some variants into an empty folder."""
    out = Path(f"build{count}")
    if anew:
        shutil.rmtree(out, ignore_errors=True)
    begun = time.perf_counter()
    command = [TOOL, "sweep", "rosorin", "--over", f"{count}.csv", "-o", str(out), "-q", *words]
    quiet = [(os.POSIX_SPAWN_OPEN, 2, os.devnull, os.O_WRONLY, 0)]
    child = os.posix_spawn(TOOL, command, os.environ, file_actions=quiet)
    _, status, used = os.wait4(child, 0)
    if status:
        raise SystemExit(f"sweep failed: {' '.join(command)}")
    return Run(time.perf_counter() - begun, used.ru_maxrss / 1024)


def cluster(*counts: int) -> None:
    """Compare a running cluster of two processes with two processes, in pairs that alternate.

    The time to import Dask and to connect counts.
    """
    try:
        from distributed import LocalCluster
    except ImportError:
        print("distributed is not installed: no cluster is measured")
        return
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as workers:
        words = ("--dask", workers.scheduler_address)
        sweep(counts[0], *words)
        for count in counts:
            there, here = zip(*((sweep(count, *words), sweep(count, "-j", "2")) for _ in range(PAIRS)), strict=True)
            first, second = (median(run.seconds for run in runs) for runs in (there, here))
            row(f"seconds, a cluster of two / -j 2, {count:,}", first, second, "at most 1.15")


def each(run: Run, count: int) -> float:
    return 1e3 * run.seconds / count


def row(name: str, first: float, second: float, goal: str) -> None:
    print(f"{name:<44} {first:12.2f} {second:12.2f}   {first / second:5.2f}   goal {goal}", flush=True)


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*[*given, *(1_000, 100)[len(given) :]])

"""Runs mutants: each against quick tests that run its line, in a process that is forked with everything imported.

    python tests/judges/mutants/running.py [--workers 2] [--answers FILE]
    python tests/judges/mutants/running.py --count 50 [--seed 2]
    python tests/judges/mutants/running.py --coverage

Runs those of drawn.txt, and writes behind each which test saw it; ``--count`` draws others, and ``--draw`` writes them
into that file instead of running them.
Prints the survivors by module, and ends with 1 if one is not in survivors.txt, or if the tests run fewer lines of a
room than coverage.txt says; ``--coverage`` writes that anew, and runs no mutant. ``--answers`` keeps what each mutant
came to, so that a run that was stopped goes on; without its lines of ``survives``, those alone are asked again.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import hashlib
import importlib
import json
import os
import random
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import accumulate
from pathlib import Path
from queue import Queue
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from judges.mutants.drawing import Mutant

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
COMPILER = Path("compiler")
PACKAGES = [path.parent for path in sorted(ROOT.glob("compiler/rosorin_compile*/__init__.py"))]  # the core is the first
KNOWN, DRAWN = HERE / "survivors.txt", HERE / "drawn.txt"
COUNT = 1_500
# Imported before a process is forked: what is not ours, and takes long.
HEAVY = (
    "numpy",
    "yaml",
    "jinja2",
    "hypothesis",
    "pytest",
    "_pytest.assertion.rewrite",
    "mujoco",
    "yourdfpy",
    "trimesh",
)
MOST = 100  # tests that a mutant is run against, the quickest first,
LEAST, LONGEST = 20, 8.0  # of them only so many, where more would take longer than so many seconds of CPU
FILES = 3  # of tests that come to a line, of which one test is asked
SLOW = 2.0  # what takes longer is asked with the others
JUDGES = "tests/judges/planted/"
PART = 10.0  # seconds of CPU of the tests that are run in one go where all are asked
SECONDS = 120  # of CPU: the machine may have other things to do
WAITED = 20 * SECONDS  # by the clock, for what waits and does nothing
MEASURED = ".coverage"

Lines = Mapping[int, Sequence[str]]
Tests = Mapping[str, Lines]


def covering(folder: Path, over: Sequence[str]) -> Tests:
    """Return the quick tests that run each line, by module: coverage with a context for each test.

    Its fixtures count, too: what several tests share is made for the first of them.
    """
    data = folder / MEASURED
    words = [sys.executable, "-m", "pytest", "-q", "-n", "auto", "-m", "not slow"]
    words += [f"--cov={path.name}" for path in PACKAGES]
    words += ["--cov-context=test", "--cov-report=", "-p", "no:cacheprovider", "-p", "judges.mutants.forgetting"]
    environment = {**os.environ, "COVERAGE_FILE": str(data), "ROSORIN_COMPILE_CACHE": "off"}
    environment |= {"PYTHONPATH": str(ROOT / "tests")}  # a plug-in is imported before pytest knows where tests are
    subprocess.run([*words, *over], cwd=ROOT, env=environment, check=False)
    found: dict[str, dict[int, set[str]]] = {}
    with sqlite3.connect(data) as base:
        asked = "SELECT file.path, context.context, line_bits.numbits FROM line_bits JOIN file ON file.id = file_id"
        for path, context, bits in base.execute(f"{asked} JOIN context ON context.id = context_id"):
            test, _, phase = context.rpartition("|")
            inside = Path(path).is_relative_to(ROOT / COMPILER)
            if phase in ("setup", "run") and inside:
                module = Path(path).relative_to(ROOT / COMPILER).as_posix()
                for line in (8 * at + bit for at, byte in enumerate(bits) for bit in range(8) if byte & (1 << bit)):
                    found.setdefault(module, {}).setdefault(line, set()).add(test)
    if not found:
        raise RuntimeError("no test runs a line of this tree: install it with pip install -e")
    return {module: {line: sorted(some) for line, some in by_line.items()} for module, by_line in found.items()}


def import_lines(text: str) -> set[int]:
    """Return the lines of a module that its import runs: all but those within functions."""
    within = set[int]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            within.update(range(node.body[0].lineno, (node.end_lineno or 0) + 1))
    return set(range(1, text.count("\n") + 2)) - within


def with_imports(tests: Tests) -> Tests:
    """Return the tests by line with all those of a module for the lines that its import runs.

    It is imported for the first test that needs it, or before, which says little about what stands at its top.
    """
    found: dict[str, Lines] = {}
    for module, lines in tests.items():
        path = ROOT / COMPILER / module
        every = sorted(set().union(*lines.values()))
        at_top = import_lines(path.read_text("utf-8")) if path.exists() else ()
        found[module] = {**lines, **dict.fromkeys(at_top, every)}
    return found


def asked_of(
    lines: Lines, line: int, seconds: Mapping[str, float], unsound: Collection[str], chance: random.Random
) -> list[str]:
    """Return the tests that a mutant of a line is run against, of those that run it; ``lines`` are of the module.

    What the line decides is seen where few tests come, and many that come there look at something else: first, for each
    line of the module, rare ones first, the quickest test that runs both of each of some files of tests. ``seconds``
    are what each test takes.
    """
    sound = set(lines.get(line, ())) - set(unsound)
    every = {test for test in sound if seconds.get(test, 0.0) <= SLOW} or sound

    def quickness(test: str) -> tuple[float, str]:
        return seconds.get(test, 0.0), test

    chosen: dict[str, None] = {}
    for other in sorted(lines, key=lambda one: (len(lines[one]), one)):
        files: dict[str, list[str]] = {}
        for test in sorted(every.intersection(lines[other])) if len(chosen) < MOST else ():
            files.setdefault(test.partition("::")[0], []).append(test)
        for file in chance.sample(sorted(files), min(FILES, len(files))):
            if chosen.keys().isdisjoint(files[file]) and len(chosen) < MOST:
                chosen[min(files[file], key=quickness)] = None
    rest = sorted(every - chosen.keys())
    some = [*chosen, *chance.sample(rest, min(MOST - len(chosen), len(rest)))]
    spent = list(accumulate(seconds.get(test, 0.0) for test in some))
    few = [test for test, sum_ in zip(some, spent, strict=True) if sum_ <= LONGEST]
    return sorted(some[: max(LEAST, len(few))], key=quickness)


def others_of(lines: Lines, line: int, seconds: Mapping[str, float], apart: Collection[str]) -> Iterator[list[str]]:
    """Yield all other tests that run a line, in parts that take a while each; none of ``apart``.

    First come the quickest, then those of ``JUDGES``, which look at each number and name.
    """
    tests = sorted(set(lines.get(line, ())).difference(apart), key=lambda test: (seconds.get(test, 0.0), test))
    quickest, *rest = _parts([test for test in tests if not test.startswith(JUDGES)], seconds) or [[]]
    yield from filter(None, (quickest, *_parts([test for test in tests if test.startswith(JUDGES)], seconds), *rest))


def _parts(tests: Sequence[str], seconds: Mapping[str, float]) -> list[list[str]]:
    parts: list[list[str]] = []
    spent = 0.0
    for test in tests:
        spent += seconds.get(test, 0.0)
        if not parts or spent > PART:
            parts.append([])
            spent = seconds.get(test, 0.0)
        parts[-1].append(test)
    return parts


class Worker:
    """A copy of the tree, and a process beside it that forks for each mutant."""

    def __init__(self, folder: Path) -> None:
        self.tree, self.told = folder, folder / "told.json"
        listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
        for name in filter(None, listed.stdout.split("\0")):
            copy = folder / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, copy, follow_symlinks=False)
        environment = {**os.environ, "PYTHONPATH": f"{folder / 'compiler'}:{folder / 'tests'}"}
        environment |= {"ROSORIN_COMPILE_CACHE": "off", "PYTHONDONTWRITEBYTECODE": ""}
        words = [sys.executable, str(HERE / "running.py"), "--serve"]
        self.server = subprocess.Popen(
            words, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def fails(self, tests: Sequence[str]) -> bool:
        """Say whether a test fails, or does not end."""
        code = self._asked({"tests": list(tests), "seconds": SECONDS, "waited": WAITED, "all": False})
        if code == "5":
            raise RuntimeError(f"pytest finds no test of these: {' '.join(tests)[:500]}")
        return code != "0"

    def without(self, tests: Sequence[str]) -> tuple[set[str], dict[str, float]]:
        """Return the tests that fail without a mutant, and the seconds of CPU that each takes."""
        code = self._asked({"tests": list(tests), "seconds": 20 * SECONDS, "waited": 20 * WAITED, "all": True})
        if code not in ("0", "1"):
            raise RuntimeError(f"pytest does not run these tests: exit code {code}")
        read = self._read()
        return set(read["failing"]), read["seconds"]

    def failing(self) -> str | None:
        """Return the test that failed in the last run; ``None`` if that did not end."""
        return next(iter(self._read()["failing"]), None) if self.told.exists() else None

    def _read(self) -> Any:
        return json.loads(self.told.read_text("utf-8"))

    def _asked(self, job: Mapping[str, object]) -> str:
        assert self.server.stdin is not None
        assert self.server.stdout is not None
        self.told.unlink(missing_ok=True)
        self.server.stdin.write(json.dumps({**job, "told": str(self.told)}) + "\n")
        self.server.stdin.flush()
        return self.server.stdout.readline().strip()

    def sees(self, module: str, text: str, tests: Sequence[str]) -> bool:
        """Say whether the tests see a mutant, which is taken back."""
        path = self.tree / COMPILER / module
        before = path.read_text("utf-8")
        _forget(path)
        path.write_text(text, "utf-8")
        try:
            return self.fails(tests)
        finally:
            path.write_text(before, "utf-8")
            _forget(path)


@contextlib.contextmanager
def taken(free: Queue[Worker]) -> Iterator[Worker]:
    """Take a worker, and give it back."""
    worker = free.get()
    try:
        yield worker
    finally:
        free.put(worker)


PASSES, SURVIVES = "passes", "survives"  # of the first round one passes, of the second one survives


class Answers:
    """What mutants came to, which may be kept in a file; one whose module has changed is asked again.

    An answer is the test that sees a mutant, or ``PASSES``, or ``SURVIVES``.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        lines = path.read_text("utf-8").splitlines() if path is not None and path.exists() else []
        self.of = {digest: answer for digest, _, answer in (line.split("\t") for line in lines)}

    def before(self, one: Mutant) -> str | None:
        """Return what a mutant came to in this run or one before; ``None`` if it was not asked."""
        return self.of.get(_digest(one))

    def add(self, one: Mutant, answer: str) -> str:
        """Keep what a mutant came to, and return it."""
        self.of[_digest(one)] = answer
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(f"{_digest(one)}\t{one.name}\t{answer}\n")
        return answer


def _digest(one: Mutant) -> str:
    return hashlib.sha256(f"{one.module}\n{one.text}".encode()).hexdigest()


def _forget(path: Path) -> None:
    """Remove the bytecode of a module: it is believed for the second of its time."""
    for kept in (path.parent / "__pycache__").glob(f"{path.stem}.*.pyc"):
        kept.unlink()


def serve() -> None:
    """Run what comes line by line, each in a process of its own; answer with its exit code."""
    for name in HEAVY:
        with contextlib.suppress(ImportError):
            importlib.import_module(name)
    for line in sys.stdin:
        job = json.loads(line)
        pid = os.fork()
        if pid == 0:
            os.setpgid(0, 0)  # no session of its own: the kernel would give that a priority of its own
            resource.setrlimit(resource.RLIMIT_CPU, (job["seconds"], job["seconds"]))
            _run(job["tests"], Path(job["told"]), all_=job["all"])
        sys.stdout.write(f"{_ended(pid, job['waited'])}\n")
        sys.stdout.flush()


class _Watching:
    """Takes down the tests that fail, and the seconds of CPU that each takes, for pytest."""

    def __init__(self) -> None:
        self.failing: set[str] = set()
        self.seconds: dict[str, float] = {}
        self._before = 0.0

    def pytest_runtest_logstart(self) -> None:
        """Begin to count."""
        self._before = sum(os.times()[:4])

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Note a test that fails, and what it has taken so far."""
        if report.failed:
            self.failing.add(report.nodeid)
        self.seconds[report.nodeid] = round(sum(os.times()[:4]) - self._before, 3)


def _run(tests: Sequence[str], told: Path, *, all_: bool) -> None:
    """Run tests, all or up to the first that fails; write into a file which ones fail, and what each takes."""
    import pytest

    sys.dont_write_bytecode = not all_  # that of a mutant would be believed; what is kept of the rest saves seconds
    watching = _Watching()
    with open(os.devnull, "r+") as nowhere:  # noqa: PTH123
        for stream in (0, 1, 2):
            os.dup2(nowhere.fileno(), stream)
        words = ["-q", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning", "--tb=no"]
        code = pytest.main([*words, *(() if all_ else ("-x",)), *tests], plugins=[watching])
    found = {"failing": sorted(watching.failing), "seconds": watching.seconds}
    told.write_text(json.dumps(found), "utf-8")
    os._exit(int(code))


def _ended(pid: int, seconds: float) -> int:
    """Return the exit code of a process; one that does not end in time is ended with all that it began."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        done, status = os.waitpid(pid, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.005)
    os.killpg(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    return 124


def main() -> int:
    """Draw mutants and run them; print who survives."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, help="draw so many mutants; left out: those of drawn.txt")
    parser.add_argument("--draw", action="store_true", help="write those that are drawn into drawn.txt, and run none")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--covered", type=Path, help="where the tests by line are kept between two runs")
    parser.add_argument("--answers", type=Path, help="where what each mutant came to is kept between two runs")
    parser.add_argument("--over", nargs="+", default=["tests"], help="the tests that are asked")
    parser.add_argument("--coverage", action="store_true", help="write coverage.txt anew, and run no mutant")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve()
        return 0
    sys.path.append(str(ROOT / "tests"))
    with tempfile.TemporaryDirectory() as folder:
        return _renewed(Path(folder)) if options.coverage else _told(options, Path(folder))


def _renewed(folder: Path) -> int:
    """Write down how many lines of each room the quick tests run."""
    from judges.mutants import line_coverage

    covering(folder, ["tests"])
    table = line_coverage.text(line_coverage.measured(folder / MEASURED, PACKAGES))
    line_coverage.KEPT.write_text(table, "utf-8")
    sys.stdout.write(table)
    return 0


def _fewer(options: argparse.Namespace, folder: Path) -> int:
    """Print the rooms of which the tests run fewer lines than is written down; return 1 if there is one."""
    from judges.mutants import line_coverage

    data = folder / MEASURED
    if not data.exists() or options.over != ["tests"]:
        return 0  # not measured in this run, or of some tests alone
    now = line_coverage.measured(data, PACKAGES)
    fewer = list(line_coverage.fewer(line_coverage.kept(line_coverage.KEPT.read_text("utf-8")), now))
    sys.stdout.write("".join(f"{line}\n" for line in fewer))
    return 1 if fewer else 0


def _told(options: argparse.Namespace, folder: Path) -> int:
    tests = with_imports(_kept(options.covered, folder, options.over))
    fewer = _fewer(options, folder)
    chosen, gone = _chosen(options, tests)
    if options.draw:
        write_drawn((one.name, "") for one in chosen)
        return 0
    free: Queue[Worker] = Queue()
    with ThreadPoolExecutor(options.workers) as pool:
        for worker in pool.map(Worker, [folder / f"tree{number}" for number in range(options.workers)]):
            free.put(worker)
    began = time.monotonic()
    asking = Asking(chosen, tests, *_without(tests, free, options), Answers(options.answers), free)
    with ThreadPoolExecutor(options.workers) as pool:
        answers = list(pool.map(asking.first, range(len(chosen))))
        again = [number for number, answer in enumerate(answers) if answer == PASSES]
        sys.stdout.write(f"{len(again)} of {len(chosen)} are asked of all other tests that run their lines\n")
        sys.stdout.flush()
        for number, answer in zip(again, pool.map(asking.second, again), strict=True):
            answers[number] = answer
    if options.count is None and options.over == ["tests"]:
        seen = [(one.name, answer) for one, answer in zip(chosen, answers, strict=True)]
        write_drawn([*((name, "") for name in gone), *seen])
    left = [one for one, answer in zip(chosen, answers, strict=True) if answer == SURVIVES]
    return max(fewer, _report(len(chosen), sorted(left), time.monotonic() - began))


@dataclass(frozen=True)
class Asking:
    """Mutants, and the tests that they are asked of in two rounds: ``first``, and ``second`` of those that pass."""

    chosen: Sequence[Mutant]
    tests: Tests
    unsound: Collection[str]
    seconds: Mapping[str, float]
    answers: Answers
    free: Queue[Worker]

    def first(self, number: int) -> str:
        """Return what a mutant comes to with the test that saw it, then with some of those that run its line.

        A known survivor is not asked.
        """
        one = self.chosen[number]
        if one.name in survivors():
            return SURVIVES
        if (before := self.answers.before(one)) is not None:
            return before
        last = seen_by().get(one.name)
        sound = set(self.tests.get(one.module, {}).get(one.line, ())).difference(self.unsound)
        with taken(self.free) as worker:
            test = self._sees(worker, one, [last] if last in sound else [])
            test = test or self._sees(worker, one, self._some(number))
        return self.answers.add(one, test or PASSES)

    def second(self, number: int) -> str:
        """Return what a mutant that passes comes to with all other tests that run its line; print one that survives."""
        one = self.chosen[number]
        apart = {*self._some(number), *self.unsound}
        parts = others_of(self.tests.get(one.module, {}), one.line, self.seconds, apart)
        with taken(self.free) as worker:
            seeing = ((part, self._sees(worker, one, part)) for part in parts)
            answer = next((test for part, test in seeing if test and not worker.fails(part)), SURVIVES)
        if answer == SURVIVES:
            sys.stdout.write(f"{number} of {len(self.chosen)}: {_at(one)}\n")
            sys.stdout.flush()
        return self.answers.add(one, answer)

    @staticmethod
    def _sees(worker: Worker, one: Mutant, part: Sequence[str]) -> str | None:
        """Return which test sees a mutant, the first one if they do not end; ``None`` if none does."""
        return (worker.failing() or part[0]) if part and worker.sees(one.module, one.text, part) else None

    def _some(self, number: int) -> list[str]:
        one = self.chosen[number]
        lines = self.tests.get(one.module, {})
        return asked_of(lines, one.line, self.seconds, self.unsound, random.Random(number))  # noqa: S311


def _chosen(options: argparse.Namespace, tests: Tests) -> tuple[list[Mutant], list[str]]:
    """Return the mutants that are asked for, and the names of those in drawn.txt that have gone, which are printed."""
    from judges.mutants.drawing import drawn, found

    if options.count is not None or options.draw:
        lines = {module: set(by_line) for module, by_line in tests.items()}
        return drawn(ROOT / COMPILER, options.count or COUNT, options.seed, lines), []
    chosen, gone = found(ROOT / COMPILER, [name for name, _ in drawn_before()])
    sys.stdout.write("".join(f"gone: {name}\n" for name in gone))
    return chosen, gone


def _without(tests: Tests, free: Queue[Worker], options: argparse.Namespace) -> tuple[set[str], dict[str, float]]:
    """Return the tests that fail without a mutant, which judge none and are printed, and what each test takes.

    They may be kept beside the tests by line.
    """
    kept = options.covered.with_suffix(".without.json") if options.covered is not None else None
    if kept is not None and kept.exists():
        read = json.loads(kept.read_text("utf-8"))
        return set(read["failing"]), read["seconds"]
    every = sorted({test for by_line in tests.values() for some in by_line.values() for test in some})
    workers = [free.get() for _ in range(options.workers)]
    shares = [every[number :: options.workers] for number in range(options.workers)]
    unsound, seconds = set[str](), dict[str, float]()
    with ThreadPoolExecutor(options.workers) as pool:
        for failing, taken in pool.map(Worker.without, workers, shares):
            unsound |= failing
            seconds |= taken
    for worker in workers:
        free.put(worker)
    for test in sorted(unsound):
        sys.stdout.write(f"fails without a mutant: {test}\n")
    sys.stdout.flush()
    if kept is not None:
        kept.write_text(json.dumps({"failing": sorted(unsound), "seconds": seconds}), "utf-8")
    return unsound, seconds


def _kept(path: Path | None, folder: Path, over: Sequence[str]) -> Tests:
    """Return the tests by line, which may be kept in a file; each test stands there once."""
    if path is not None and path.exists():
        read = json.loads(path.read_text("utf-8"))
        names, there = read["tests"], _collected(over)
        return {
            module: {int(line): [names[one] for one in some if names[one] in there] for line, some in by_line.items()}
            for module, by_line in read["lines"].items()
        }
    tests = covering(folder, over)
    if path is not None:
        names = sorted({test for by_line in tests.values() for some in by_line.values() for test in some})
        at = {name: number for number, name in enumerate(names)}
        lines = {
            module: {line: [at[one] for one in some] for line, some in by_line.items()}
            for module, by_line in tests.items()
        }
        path.write_text(json.dumps({"tests": names, "lines": lines}), "utf-8")
    return tests


def _collected(over: Sequence[str]) -> set[str]:
    """Return the quick tests that there are: what was kept may name some that have gone since."""
    words = [sys.executable, "-m", "pytest", "--collect-only", "-m", "not slow", "-p", "no:cacheprovider", *over]
    printed = subprocess.run(words, cwd=ROOT, check=False, capture_output=True, text=True).stdout
    return {line for line in printed.splitlines() if "::" in line}


@cache
def survivors() -> dict[str, str]:
    """Return the reason of each mutant that is known to survive, by its name."""
    lines = KNOWN.read_text("utf-8").splitlines() if KNOWN.exists() else []
    rows = (line.rpartition(" # ") for line in lines if line and not line.startswith("#"))
    return {name: reason for name, _, reason in rows}


def drawn_before() -> list[tuple[str, str]]:
    """Return the names of the mutants that were drawn, each with the test that saw it last, or with nothing."""
    rows = (line.partition("\t") for line in DRAWN.read_text("utf-8").splitlines())
    return [(name, test) for name, _, test in rows]


@cache
def seen_by() -> dict[str, str]:
    """Return the test that saw a mutant last, by the name of that."""
    return {name: test for name, test in drawn_before() if test}


def write_drawn(rows: Iterable[tuple[str, str]]) -> None:
    """Write down mutants by name, each with the test that saw it, if one did."""
    lines = sorted(f"{name}\t{test}" if "::" in test else name for name, test in rows)
    DRAWN.write_text("".join(f"{line}\n" for line in lines), "utf-8")


def _at(one: Mutant) -> str:
    return f"{one.module}:{one.line}: {one.kind}: {one.before} -> {one.after}"


def _report(count: int, left: Sequence[Mutant], seconds: float) -> int:
    known = survivors()
    fresh = [one for one in left if one.name not in known]
    for module, number in sorted(Counter(one.module for one in left).items()):
        sys.stdout.write(f"{number:4} survive in {module}\n")
    sys.stdout.write("".join(f"{_at(one)}\n" for one in fresh))
    sys.stdout.write(f"{count} mutants, {len(left)} survive, {len(fresh)} of them not known; {seconds / 60:.0f} min\n")
    return 1 if fresh else 0


if __name__ == "__main__":
    sys.exit(main())

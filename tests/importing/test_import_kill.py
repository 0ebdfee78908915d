"""Import that is killed leaves the folder as it was: not there, or whole.

    python test_import_kill.py FOLDER

works in FOLDER: for each line of input it lets a process import and kills it, at the given one of all its calls to the
system that leave a trace on disk, or after that many seconds ("after 0.01"); then it says what stands there.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from support.paths import IMPORTED, TESTS

pytestmark = pytest.mark.slow

ROVER = IMPORTED / "rover"
BEFORE = {"robot.yaml": "robot: before\n", "notes.txt": "mine\n"}


def child(folder: Path) -> None:
    """Do what is said on standard input, one kill a line."""
    from rosorin_compile.cli.main import main
    from rosorin_compile.formats.reading import read_robot
    from rosorin_compile.importing import import_robot
    from rosorin_compile.importing.words import worded
    from support.output_child import die_at

    quiet = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115 (for as long as the process lives)
    told, sys.stdout = sys.stdout, quiet
    trips: list[Any] = []
    checked = import_robot.check_round_trip
    import_robot.check_round_trip = lambda *arguments, **named: trips[0] if trips else checked(*arguments, **named)
    main(["import", str(ROVER / "rover.urdf"), "-o", str(folder / "first")])  # loads what the others then have
    said = worded(read_robot(ROVER / "rover.urdf"))
    trips.append(checked(said.imported, folder / "first", parts=False, plain=said.plain))  # several files
    after = {path.name: path.read_text("utf-8") for path in (ROVER / "flat").iterdir()}
    write_set = import_robot.write_set
    for line in sys.stdin:
        how, number, existing = line.split()
        target = folder / f"{how}{number}{existing}"
        if existing == "there":
            target.mkdir()
            for name, text in BEFORE.items():
                (target / name).write_text(text, "utf-8")
        process = os.fork()
        if process == 0:
            if how == "at":

                def dying(*arguments: Any, step: int = int(number), **named: Any) -> Any:
                    die_at(step)
                    return write_set(*arguments, **named)

                import_robot.write_set = dying
            sys.stderr = quiet
            os._exit(main(["import", str(ROVER / "rover.urdf"), "-o", str(target), "--force"]))
        if how == "after":
            time.sleep(float(number))
            os.kill(process, signal.SIGKILL)
        code = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        told.write(f"{code} {state(target, after)}\n")
        told.flush()


def state(target: Path, after: dict[str, str]) -> str:
    """Return what stands there: nothing, what stood there before, the whole new description, or a mixture."""
    if not target.exists():
        return "nothing"
    there = {path.name: path.read_text("utf-8") for path in target.iterdir() if path.suffix != ".imported"}
    notes = {name: BEFORE[name.removesuffix(".kept")] for name in there if name in ("notes.txt", "robot.yaml.kept")}
    if there == BEFORE:
        return "before"
    return "after" if there == {**after, **notes} else f"a mixture: {sorted(there)}"


def killed(folder: Path, lines: list[str]) -> list[tuple[int, str]]:
    """Return the exit code and what stands there for each kill."""
    command = [sys.executable, __file__, str(folder)]
    environment = {**os.environ, "PYTHONPATH": str(TESTS)}
    ran = subprocess.run(command, input="\n".join(lines), env=environment, capture_output=True, text=True, check=True)
    return [(int(code), what) for code, what in (line.split(maxsplit=1) for line in ran.stdout.splitlines())]


@pytest.mark.parametrize("each", [150, pytest.param(10, marks=pytest.mark.tier("builds"))], ids=["some", "more"])
def test_killed_at_every_step_of_writing(tmp_path: Path, each: int) -> None:
    for existing, old in (("new", "nothing"), ("there", "before")):
        steps = [f"at {step} {existing}" for step in range(1, 361, each)]
        found = killed(tmp_path, steps)
        assert len(found) == len(steps)
        assert {what for _, what in found} == {old, "after"}
        assert {code for code, _ in found} == {0, -signal.SIGKILL}, "the last steps come after the end"
        whole = [what for _, what in found].index("after")
        assert all(what == old for _, what in found[:whole])
        assert all(what == "after" for _, what in found[whole:])
    left = [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]
    assert len(left) <= 1, "each run clears away what killed runs left"


def test_killed_at_any_time(tmp_path: Path) -> None:
    lines = [f"after {seconds:.3f} new" for seconds in (0.0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.08, 0.1)]
    assert {what for _, what in killed(tmp_path, lines)} <= {"nothing", "after"}


if __name__ == "__main__":
    child(Path(sys.argv[1]))

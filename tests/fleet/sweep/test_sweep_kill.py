"""sweep that is killed, interrupted, or loses a process: whole variants only, and the next run does the rest.

What is killed runs in a process of its own, which forks and so has everything imported.
"""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.kills import at_each_step
from support.paths import data_text

ROBOT = data_text("robots/sweep_kill.yaml")
COUNT = 24


def table(step: int) -> str:
    return "name,height\n" + "".join(f"r{n},{n + step} cm\n" for n in range(1, COUNT + 1))


PROJECT = {
    "mast/robot.yaml": ROBOT,
    "mast/same.txt.jinja": "the same\n",
    "a.csv": table(1),
    "die.py": """\
import os, signal, sys
from pathlib import Path
from rosorin_compile.cli.main import main
from rosorin_compile.variants import sweep, workers

def dying(job, variant):
    if variant.name == "r5" or (variant.name == "r9" and not Path("died").exists()):
        if variant.name == "r9":
            Path("died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return workers.compile_variant(job, variant)

if __name__ == "__main__":
    sweep.compile_variant = dying
    sys.exit(main(["sweep", "mast", "--over", "a.csv", "-o", "out", "-j", "2"]))
""",
}


@pytest.fixture(autouse=True)
def here(project: Path) -> Path:
    return project


def ran(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=300)


def test_a_process_that_dies_takes_no_other_variant_along() -> None:
    done = ran("die.py")
    assert done.returncode == 1
    assert "a.csv:6:1: error[worker-died]: r5: " in done.stderr
    made = json.loads(Path("out/sweep.json").read_text())["variants"]
    assert [one["name"] for one in made if one["status"] == "error"] == ["r5"]
    assert len(made) == COUNT
    assert main(["sweep", "mast", "--over", "a.csv", "-o", "out", "-j", "1"]) == 0
    assert Path("out/r5/mast.urdf").exists()


KILLS = pytest.mark.tier("builds")
ENDED = [
    *(pytest.param(rest, 24, id=f"{rest}-some calls") for rest in ("b.csv", "c.csv")),
    *(pytest.param(rest, 6, id=f"{rest}-more calls", marks=KILLS) for rest in ("b.csv", "c.csv")),
]


@pytest.mark.landing("builds", "b.csv-some calls")
@pytest.mark.slow
@pytest.mark.parametrize(("rest", "each"), ENDED)
def test_prune_after_a_kill_leaves_no_half_of_a_variant(here: Path, rest: str, each: int) -> None:
    """Killed while a variant is removed, is replaced, or is made: the next run knows which files are ours."""
    (here / "a.csv").write_text("name,height\nr0,1 m\n")
    (here / "b.csv").write_text("name,height\nr1,1 m\n")
    (here / "c.csv").write_text("name,height\nr0,2 m\nr2,2 m\n")
    (here / "d.csv").write_text("name,height\nr3,3 m\n")
    words = ["-o", "fleet", "-j", "1", "-q", "--prune"]
    fleet = here / "fleet"

    def run(over: str) -> int:
        return main(["sweep", "mast", "--over", over, *words])

    def after() -> None:
        listed = json.loads((fleet / "sweep.json").read_text())["variants"] if (fleet / "sweep.json").exists() else []
        assert all((fleet / one["name"]).is_dir() for one in listed), "the index names what there is"
        assert run("d.csv") == 0
        there = [path.relative_to(fleet).as_posix() for path in fleet.rglob("*") if path.is_file()]
        assert {name.split("/")[0] for name in there if name[0] != "."} == {"r3", "sweep.json"}
        assert run("a.csv") == 0

    assert run("a.csv") == 0
    assert at_each_step(lambda: run(rest), after, each) > 20


def test_ctrl_c_leaves_what_is_made_and_says_how_to_go_on() -> None:
    Path("many.csv").write_text("name,height\n" + "".join(f"r{n},{n} mm\n" for n in range(1, 3_000)))
    words = ["-m", "rosorin_compile", "sweep", "mast", "--over", "many.csv", "-o", "out", "-j", "2"]
    process = subprocess.Popen(
        [sys.executable, *words], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    until = time.monotonic() + 60
    while not Path("out/r20").exists() and time.monotonic() < until:
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert " of 2,999 variants done; the same command continues from there" in said
    assert "Traceback" not in said
    assert not Path("out/sweep.json").exists()
    made = len(list(Path("out").glob("r*/mast.urdf")))
    Path("many.csv").write_text("".join(Path("many.csv").read_text().splitlines(keepends=True)[:11]))
    assert main(["sweep", "mast", "--over", "many.csv", "-o", "out", "-j", "1", "--prune"]) == 0
    assert made >= 15  # two at a time, so not in order
    assert json.loads(Path("out/sweep.json").read_text())["variants"][9]["name"] == "r10"

"""sweep on a cluster of dask: the same as without one, also when a worker is killed or lacks a file.

The cluster and its client run in processes of their own.
"""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.source.system import pip_install
from rosorin_compile.variants import workers as pool
from support.commands import Shown
from support.paths import data_text

pytest.importorskip("distributed")

ROBOT = data_text("robots/sweep_dask.yaml")
ROWS = 40
PROJECT = {
    "descriptions/mast/robot.yaml": ROBOT,
    "descriptions/mast/more.yaml": "links: {eye: {}}\njoints: {e: {type: fixed, parent: mast, child: eye}}\n",
    "descriptions/mast/cal.yaml": "size: 2 cm\n",
    "descriptions/mast/notes.txt.jinja": "the same for all\n",
    "tables/far.yaml": "size: 9 cm\n",
    "fleet.csv": "name,height,table\n"
    + "".join(f"r{n},{n} cm,\n" for n in range(1, ROWS))
    + "wrong,tall,\nfar,,../../tables/far.yaml\nnone,,nothing.yaml\nzero,0,cal.yaml\n",
    "run.py": """\
import os, signal, sys, threading, time
from pathlib import Path

def main():
    from distributed import Client, LocalCluster
    from rosorin_compile.cli.main import main
    out, count, kills = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        with Client(cluster) as client:
            client.wait_for_workers(count)

            def kill():
                for number in range(kills):
                    while len(list(Path("out").glob("r*"))) < 4 + 8 * number:
                        time.sleep(0.01)
                    pids = client.run(os.getpid)
                    os.kill(sorted(pids.values())[0], signal.SIGKILL)
                    print("killed", flush=True)

            threading.Thread(target=kill, daemon=True).start()
            words = ["sweep", "mast", "--over", "fleet.csv", "-o", out, "--dask", cluster.scheduler_address]
            print("code", main(words), flush=True)
            print("code", main(words), flush=True)

if __name__ == "__main__":
    main()
""",
    "version.py": """\
def set_version():
    from rosorin_compile.variants import workers
    workers.__version__ = "0.0.1"

def main():
    import sys
    from distributed import Client, LocalCluster
    from rosorin_compile.cli.main import main
    sys.stderr = sys.stdout
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        with Client(cluster) as client:
            client.run(set_version)
        main(["sweep", "mast", "--over", "fleet.csv", "-o", "out", "--dask", cluster.scheduler_address])

if __name__ == "__main__":
    main()
""",
    "library.py": """\
import pickle

def main():
    import rosorin_compile
    from distributed import Client, LocalCluster
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster:
        with Client(cluster) as client:
            rows = ({"name": f"x{n}", "height": n / 100} for n in range(1, 31))
            every = rosorin_compile.sweep("mast", rows, {"table": "cal.yaml"}, client=client)
            made = {one.variant.name: one for one in every}
            here = {one.variant.name: one for one in rosorin_compile.sweep("mast", "fleet.csv")}
            there = {one.variant.name: one for one in rosorin_compile.sweep("mast", "fleet.csv", client=client)}
    assert {name: one.robot.joint["mast_joint"].origin.xyz[2] for name, one in made.items()} == {
        f"x{n}": n / 100 for n in range(1, 31)
    }
    assert here.keys() == there.keys()
    for name in here:
        assert here[name].robot == there[name].robot, name
        assert here[name].artifacts == there[name].artifacts, name
        assert list(map(str, here[name].diagnostics)) == list(map(str, there[name].diagnostics)), name
        assert {p.absolute() for p in here[name].inputs} == {p.absolute() for p in there[name].inputs}, name
    print("fine")

if __name__ == "__main__":
    main()
""",
}


@pytest.fixture(autouse=True)
def here(project: Path) -> Path:
    return project


def ran(*words: str) -> str:
    done = subprocess.run([sys.executable, *words], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


def without() -> bytes:
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "out", "-j", "1", "-q"]) == 1
    made = Path("out/sweep.json").read_bytes()
    shutil.copytree("out", "here")
    shutil.rmtree("out")
    return made


def same_files() -> bool:
    made, own = (
        {p.relative_to(top): p.read_bytes() for p in Path(top).glob("[!.]*/*") if p.is_file()}
        for top in ("out", "here")
    )
    return made == own and len(made) == 2 * (ROWS - 1 + 2)


@pytest.mark.slow
def test_a_cluster_makes_what_is_made_here() -> None:
    alone = without()
    said = ran("run.py", "out", "2", "0")
    assert said.count("code 1") == 2
    assert Path("out/sweep.json").read_bytes() == alone
    assert same_files()
    lines = [line.split() for line in said.splitlines()]
    assert ["made", str(ROWS + 1)] in lines
    assert ["unchanged", str(ROWS + 1)] in lines, "the second run has nothing to do"


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_a_killed_worker_loses_nothing() -> None:
    alone = without()
    said = ran("run.py", "out", "2", "2")
    assert said.count("killed") == 2
    assert Path("out/sweep.json").read_bytes() == alone
    assert same_files()


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_the_library_asks_a_cluster() -> None:
    assert "fine" in ran("library.py")


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_a_worker_of_another_version_is_one_error() -> None:
    said = ran("version.py")
    assert "error[cluster-failed]" in said
    assert "the worker has rosorin-compile 0.0.1" in said
    assert "Traceback" not in said


def test_a_scheduler_that_is_not_there(capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pool, "_TIMEOUT", 0.3)
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "out", "--dask", "tcp://127.0.0.1:9"]) == 1
    assert "error[cluster-failed]: no scheduler with workers at tcp://127.0.0.1:9: " in capsys.readouterr().err


def test_without_dask_the_error_names_the_command_that_installs_it(
    capsys: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["sweep", "mast", "--over", "fleet.csv", "-o", "out", "--dask", "tcp://127.0.0.1:9"]) == 1
    said = capsys.readouterr().err
    assert "error[cluster-failed]: --dask needs distributed, which is not installed" in said
    assert pip_install("dask") in said

"""Real processes: each path that the kernel was asked for stands in the notes, and no change of one is missed."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.commands import edit
from support.memory.processes import Project

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed"),
]
pytest.importorskip("xacro")
LINES = (("all",), ("check",), ("print", "urdf"), ("all", "-q"), ("check", "--every-argument"))


@pytest.mark.landing("memory", "words2")
@pytest.mark.parametrize("words", [("all",), ("print", "mjcf"), ("check",)])
def test_what_the_kernel_was_asked_for_stands_in_the_notes(tmp_path: Path, words: tuple[str, ...]) -> None:
    project = Project(tmp_path)
    if words == ("check",):
        assert project.run("all", memory=False)[0] == 0
    code, _, said = project.run(*words, traced=True)
    assert code == 0, said
    asked, noted = project.asked(), project.noted()
    assert len(asked) > 10
    outputs = str(project.folder / "outputs")
    written = (outputs, str(project.folder / ".rosorin-compile-"))  # who writes looks for himself
    missed = [path for path in asked if path not in noted and not path.startswith(written)]
    assert not missed, "\n".join(missed)
    assert outputs in noted or words[0] == "print"


SWEEP = ("sweep", "r", "--over", "fleet.csv", "-j", "2", "-o")


def sweep(project: Project, out: str = "out", traced: bool = True) -> list[str]:
    """Sweep into a folder; return what the kernel was asked for that may tell something of a variant."""
    code, _, said = project.run(*SWEEP, out, traced=traced)
    assert code in (0, 1), said
    ours = (str(project.folder / "out"), str(project.folder / ".rosorin-compile-"))  # who writes looks for himself
    return [path for path in project.asked() if not path.startswith(ours)] if traced else []


@pytest.mark.tier("memory")
def test_what_a_sweep_asked_the_kernel_for_stands_in_its_notes(tmp_path: Path) -> None:
    """Or it is asked for again by a run in which all is unchanged: the list of variants, and which robots there are."""
    project = Project(tmp_path)
    asked = sweep(project)
    noted = project.noted_of_sweep("out")
    again = sweep(project)
    assert len(asked) > 10
    assert "unchanged 2" in " ".join(project.run(*SWEEP, "out")[1].split())
    missed = [path for path in asked if path not in noted and path not in again]
    assert not missed, "\n".join(missed)
    home = project.folder / "descriptions/r"
    read = ["robot.yaml", "arm.yaml", "claw.xacro", "more.xacro", "t.jinja", "meshes/a.stl"]
    assert not {str(home / name) for name in read} - noted
    assert str(project.vendor / "b.stl") in noted


def sweep_and_change(tmp_path: Path, steps: int) -> None:
    """Change what the kernel was asked for, and sweep again, and once more from there as another tool, which makes all.

    Both begin with the folder of before: a mesh that stands beside the artifacts is found there.
    """
    chance, project = random.Random(37), Project(tmp_path)  # noqa: S311 - the same steps each time
    out, before = project.folder / "out", project.folder / "before"
    for number in range(steps):
        change(chance, Path(chance.choice(sweep(project))), number)
        shutil.copytree(out, before)
        sweep(project, traced=False)
        made = project.variants("out")
        shutil.rmtree(out)
        before.rename(out)
        project.environment["PYTHONPATH"] = str(tmp_path / f"another{number}")
        said = sweep_words(project)
        assert "unchanged 0" in said, said
        assert made == project.variants("out"), f"step {number}"


def sweep_words(project: Project) -> str:
    """Sweep, and return what is said, blanks and line feeds as one blank."""
    return " ".join(project.run(*SWEEP, "out")[1].split())


@pytest.mark.tier("memory")
def test_a_change_of_what_a_sweep_asked_for(tmp_path: Path) -> None:
    sweep_and_change(tmp_path, 1)


@pytest.mark.tier("memory")
def test_many_changes_of_what_a_sweep_asked_for(tmp_path: Path) -> None:
    sweep_and_change(tmp_path, 20)


def play(tmp_path: Path, steps: int) -> int:
    """Change what the kernel was asked for, and compare with and without memory; return how often memory answered."""
    chance, project, answered = random.Random(37), Project(tmp_path), 0  # noqa: S311 - the same steps each time
    project.run("all")
    for number in range(steps):
        words = chance.choice(LINES)
        project.run(*words, traced=True)
        asked = [path for path in project.asked() if "/.cache" not in path]
        if asked:
            change(chance, Path(chance.choice(asked)), number)
        elif chance.random() < 0.5:
            project.environment["SIDE"] = str(number)
        with_memory = project.run(*words)
        before = project.records()
        again = project.run(*words)
        answered += project.records() == before
        without = project.run(*words, memory=False)
        assert again == without, f"step {number}: {words}"
        assert with_memory[0] == without[0], f"step {number}: {words}"
    print(f"{answered} of {steps} answered from memory")
    return answered


def change(chance: random.Random, path: Path, number: int) -> None:
    """Change a file in place, or take it away, or make one where there was nothing."""
    try:
        if path.is_file():
            status, data = path.stat(), path.read_bytes()
            path.write_bytes(data + b"\n" if chance.random() < 0.6 else data)
            os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
        elif not path.exists():
            path.write_text(f"<!-- {number} -->\n", "utf-8")
    except OSError:
        return


@pytest.mark.tier("memory")
def test_changes_of_what_was_asked_for(tmp_path: Path) -> None:
    assert play(tmp_path, 2) > 0


@pytest.mark.tier("memory")
def test_many_changes_of_what_was_asked_for(tmp_path: Path) -> None:
    assert play(tmp_path, 50) >= 50 / 3


@pytest.mark.tier("memory")
def test_a_check_of_every_argument_is_answered_from_memory(tmp_path: Path) -> None:
    project, words = Project(tmp_path), ("check", "--every-argument")
    first, kept = project.run(*words), project.records()
    assert (project.run(*words), project.records()) == (first, kept)
    assert project.run(*words, memory=False) == first
    edit(project.folder / "descriptions/r/arm.yaml", "parent: base_link", "parent: nothing")
    wrong = project.run(*words)
    assert wrong[0] == 1
    assert (project.run(*words), project.run(*words, memory=False)) == (wrong, wrong)


def test_a_run_into_a_closed_pipe_is_made_again(tmp_path: Path) -> None:
    project = Project(tmp_path)
    for _ in range(2):  # the second time it may be answered from memory
        reading, writing = os.pipe()
        os.close(reading)
        command = [sys.executable, "-m", "rosorin_compile", "print", "urdf"]
        with os.fdopen(writing, "wb") as closed:
            done = subprocess.run(
                command, cwd=project.folder, env=project.environment, stdout=closed, stderr=subprocess.PIPE, check=False
            )
        assert done.returncode
    assert project.run("print", "urdf") == project.run("print", "urdf", memory=False)

"""Artifacts that are made in two processes are those of one, whatever becomes of the second."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rosorin_compile.diagnostics.console import Console
from rosorin_compile.formats import FORMATS
from rosorin_compile.pipeline import Compiled, Made, Task
from rosorin_compile.project import Description
from rosorin_compile.startup.cache import digest
from rosorin_compile.tools import beside
from rosorin_compile.tools.compiling import compile_proven
from rosorin_compile.tools.given import Given
from support.paths import ROOT

ROBOTS = sorted(path.parent.relative_to(ROOT) for path in ROOT.glob("*/*/robot.yaml"))
GIVEN = Given({}, (), {}, False)
ROSORIN = ROOT / "descriptions/rosorin"


def compiled(folder: Path, monkeypatch: pytest.MonkeyPatch, cores: int = 2) -> Compiled:
    """Return what becomes of a description where there are so many cores; no process may be left."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr("threading.active_count", lambda: 1)  # those of pytest do nothing here
    description = Description("robot", folder / "robot.yaml", folder / "outputs")
    made = compile_proven(GIVEN, description, Console("json", quiet=True))
    while beside._ended:  # they were killed; the system takes a moment
        time.sleep(0.001)
        beside._bury()
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
    return made


def seen(made: Compiled) -> tuple[object, ...]:
    told = [(one.rule, one.severity, one.message, str(one.span)) for one in made.diagnostics]
    return made.artifacts, told, made.inputs, made.resolved


def in_second(do: Callable[[], None]) -> Callable[[Task, beside.Output, object], Made]:
    """Return what makes an artifact as ever, but does something first if it is asked in the second process."""
    first, make = os.getpid(), beside.make_one

    def one(task: Task, output: beside.Output, templates: object) -> Made:
        if os.getpid() != first:
            do()
        return make(task, output, templates)

    return one


@pytest.mark.parametrize("robot", ROBOTS, ids=str)
def test_two_processes_make_what_one_makes(robot: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert seen(compiled(ROOT / robot, monkeypatch)) == seen(compiled(ROOT / robot, monkeypatch, 1))


def test_digests_are_those_of_the_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    made = compiled(ROSORIN, monkeypatch)
    assert made.digests == {artifact.file: digest(artifact.text.encode()) for artifact in made.artifacts}


def test_a_text_that_no_file_can_hold_has_no_digest(monkeypatch: pytest.MonkeyPatch) -> None:
    make = beside.make_one

    def odd(task: Task, output: beside.Output, templates: object) -> Made:
        made = make(task, output, templates)
        assert made.artifact is not None
        text = made.artifact.text + "\ud800" * (output.name == "frames")
        return made._replace(artifact=made.artifact._replace(text=text))

    monkeypatch.setattr(beside, "make_one", odd)
    made = compiled(ROSORIN, monkeypatch)
    assert made.digests is not None
    assert {one.file for one in made.artifacts} - made.digests.keys() == {"frames.md"}


@pytest.mark.parametrize("fork", [os.fork, None], ids=["", "refused"])
def test_no_handle_is_left(fork: Callable[[], int] | None, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    compiled(ROSORIN, monkeypatch)
    before = len(list(Path("/proc/self/fd").iterdir()))
    monkeypatch.setattr(os, "fork", fork or refused)
    compiled(ROSORIN, monkeypatch)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_the_second_process_does_something(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mark = tmp_path / "second"
    monkeypatch.setattr(beside, "make_one", in_second(mark.touch))
    compiled(ROSORIN, monkeypatch)
    assert mark.exists()


@pytest.mark.parametrize(
    "dies",
    [lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: os._exit(0), lambda: 1 / 0],
    ids=["killed", "gone", "failed"],
)
def test_without_the_second_process_all_is_made(dies: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    alone = seen(compiled(ROSORIN, monkeypatch, 1))
    monkeypatch.setattr(beside, "make_one", in_second(dies))
    assert seen(compiled(ROSORIN, monkeypatch)) == alone


def test_where_the_system_does_not_tell_of_processes_that_end(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = seen(compiled(ROSORIN, monkeypatch, 1))
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        assert seen(compiled(ROSORIN, monkeypatch)) == alone
        monkeypatch.setattr(beside, "make_one", in_second(lambda: os._exit(0)))  # it is gone before it is let go
        assert seen(compiled(ROSORIN, monkeypatch)) == alone
    finally:
        signal.signal(signal.SIGCHLD, before)


def test_where_no_process_can_begin_all_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> int:
        raise BlockingIOError(11, "Resource temporarily unavailable")

    alone = seen(compiled(ROSORIN, monkeypatch, 1))
    monkeypatch.setattr(os, "fork", refused)
    assert seen(compiled(ROSORIN, monkeypatch)) == alone


def test_where_python_knows_no_files_in_memory(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    alone = seen(compiled(ROSORIN, monkeypatch, 1))
    mark = tmp_path / "second"
    monkeypatch.delattr(os, "memfd_create")
    monkeypatch.setattr(beside, "make_one", in_second(mark.touch))
    assert seen(compiled(ROSORIN, monkeypatch)) == alone
    assert mark.exists()


def test_what_the_second_process_makes_wrongly_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    make = beside.make_one

    def spoilt(task: Task, output: beside.Output, templates: object) -> Made:
        made = make(task, output, templates)
        assert made.artifact is not None
        text = made.artifact.text.replace('lower="-', 'lower="-1')
        return made._replace(artifact=made.artifact._replace(text=text))

    monkeypatch.setattr(beside, "make_one", spoilt)
    made = compiled(ROSORIN, monkeypatch)
    assert made.artifacts == ()
    assert {one.rule for one in made.diagnostics if one.severity == "error"} == {"artifacts-disagree"}


def test_a_description_with_errors_leaves_no_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for number, text in enumerate(
        ("links: {a: {}, b: {}}\n", "links: [a]\n", "links: {a: {inertial: 3}}\n", "jionts: {}\n")
    ):
        folder = tmp_path / str(number)
        folder.mkdir()
        (folder / "robot.yaml").write_text(f"robot: bad\n{text}outputs: {{urdf: {{}}, mjcf: {{}}}}\n", "utf-8")
        assert compiled(folder, monkeypatch).robot is None


def test_formats_of_plug_ins_run_in_the_first_process(monkeypatch: pytest.MonkeyPatch) -> None:
    first, foreign, write = os.getpid(), FORMATS["sdf"], FORMATS["sdf"].write
    assert write is not None

    def watched(*words: object) -> object:
        assert os.getpid() == first
        return write(*words)  # type: ignore[arg-type]

    monkeypatch.setattr("rosorin_compile.formats.is_built_in", lambda name: name != "sdf")
    monkeypatch.setattr("rosorin_compile.formats.sdf.FORMAT", foreign)
    monkeypatch.setattr(type(foreign), "written", _written(foreign, watched))
    assert any(artifact.backend == "sdf" for artifact in compiled(ROSORIN, monkeypatch).artifacts)


def _written(foreign: object, watched: Callable[..., object]) -> Callable[..., object]:
    def written(self: object, *words: object) -> object:
        return watched(*words) if self is foreign else self.write(*words)  # type: ignore[attr-defined]

    return written

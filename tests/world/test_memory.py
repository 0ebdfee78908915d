"""Memory: a record answers as long as each of its questions is answered as it was, and whatever is odd is no record."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from rosorin_compile import world
from rosorin_compile.world import memory
from rosorin_compile.world.listening import listening

KEY = ["a", "key"]
LARGE = memory.SMALL + 1
SECOND = 1_000_000_000  # ns


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))


def known(work: Callable[[], object], outputs: tuple[Path, ...] = ()) -> bool:
    """Do a piece of work, unless it is known; say whether it was."""

    def done() -> int:
        work()
        memory.hear(memory.OUT, "words\n")
        return 0

    found, was_known = memory.once(KEY, done, outputs)
    assert found.said == [(memory.OUT, "words\n")]
    return was_known


def test_what_is_known_is_not_done_again(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("1")
    assert [known(lambda: world.read(file)) for _ in range(3)] == [False, True, True]
    file.write_text("2")
    assert [known(lambda: world.read(file)) for _ in range(2)] == [False, True]


@pytest.mark.parametrize("size", [1, LARGE])
def test_a_change_that_size_and_times_of_content_do_not_show(tmp_path: Path, size: int) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"1" * size)
    before = file.stat()
    known(lambda: world.read(file))
    file.write_bytes(b"2" * size)
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert not known(lambda: world.read(file))


def test_a_large_file_that_stands_for_a_while_is_not_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"1" * LARGE)
    later = time.time_ns() + 10 * SECOND
    monkeypatch.setattr(world.disk.Disk, "now", lambda _: later)
    if file.stat().st_ctime_ns % SECOND == 0:
        pytest.skip("this disk keeps whole seconds")
    known(lambda: world.read(file))
    read = []
    own = world.disk.Disk.read
    monkeypatch.setattr(world.disk.Disk, "read", lambda self, path, most=-1: read.append(path) or own(self, path, most))
    assert known(lambda: world.read(file))
    assert read == []


def test_artifacts_as_they_were_left(tmp_path: Path) -> None:
    made = tmp_path / "made"
    made.mkdir()
    (made / "a").write_text("1")
    known(lambda: None, (made,))
    assert known(lambda: None, (made,))
    (made / "b").symlink_to("a")
    assert not known(lambda: None, (made,))
    (made / "b").unlink()
    (made / "b").mkdir()
    assert not known(lambda: None, (made,))


@pytest.mark.parametrize("data", [b"", b"x", b"x\n", bytes(100)])
def test_a_damaged_record_is_none(tmp_path: Path, data: bytes) -> None:
    known(lambda: None)
    (record,) = (tmp_path / "cache" / "runs").iterdir()
    whole = record.read_bytes()
    for damaged in (data, whole[:-1], whole + b"x", whole.replace(b"words", b"sword")):
        record.write_bytes(damaged)
        assert not known(lambda: None)


def test_a_spoiled_run_is_not_kept() -> None:
    assert [known(lambda: world.spoil("for a reason")) for _ in range(2)] == [False, False]


def test_what_fails_oddly_is_not_kept() -> None:
    assert [memory.once(KEY, lambda: 2)[1] for _ in range(2)] == [False, False]
    assert [memory.once(KEY, lambda: 1)[1] for _ in range(2)] == [False, True]


# ---- Code of others ----


def others(tmp_path: Path) -> Callable[[], None]:
    """Return code that opens files past the door: one that is there, one that is not, and lists a folder."""

    def work() -> None:
        with listening():
            (tmp_path / "data").read_text()
            if "more" in os.listdir(tmp_path / "folder"):  # noqa: PTH208
                return
            with pytest.raises(FileNotFoundError):
                (tmp_path / "absent").read_text()

    return work


@pytest.mark.parametrize(
    "change",
    [
        lambda folder: (folder / "data").write_text("2"),
        lambda folder: (folder / "absent").write_text(""),
        lambda folder: (folder / "folder" / "more").write_text(""),
        lambda _: os.environ.update(SOME_VARIABLE="1"),
    ],
)
def test_what_code_of_others_opens_is_noted(
    tmp_path: Path, change: Callable[[Path], object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOME_VARIABLE", "0")
    monkeypatch.setattr("rosorin_compile.world.notes._heard", world.Notes())
    (tmp_path / "data").write_text("1")
    (tmp_path / "folder").mkdir()
    work = others(tmp_path)
    known(work)
    assert known(work)
    change(tmp_path)
    monkeypatch.setattr("rosorin_compile.world.notes._heard", world.Notes())
    assert memory.recall(KEY) is None


def test_another_process_spoils_the_notes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rosorin_compile.world.notes._heard", world.Notes())
    with world.noting() as notes, listening():
        subprocess.run([sys.executable, "-c", ""], check=True)
    assert "subprocess.Popen" in notes.spoiled
    monkeypatch.setattr("rosorin_compile.world.notes._heard", world.Notes())

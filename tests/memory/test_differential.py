"""What memory answers is what a run would have said: thousands of random changes of a world of values."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from unittest import mock

import pytest

from rosorin_compile.world import asking, listening, memory, notes
from rosorin_compile.world.disk import disk
from support.memory.differential import ANSWERED, APPEARED, CHANGED, Differential, Wrong
from support.memory.folder import Folder

SOME, ALL = 2_000, 20_000
A_WORLD = 100  # steps


def play(steps: int, seed: int = 0, folder: Path | None = None) -> dict[str, int]:
    """Make steps, each hundred in a world of its own, or a folder; return how many were of which kind."""
    counts = dict.fromkeys((ANSWERED, CHANGED, APPEARED), 0)
    for number in range(steps // A_WORLD):
        world = Differential(seed + number)
        if folder is not None:
            (folder / str(number)).mkdir()
            world = Differential(seed + number, Folder(folder / str(number)))
        for _ in range(A_WORLD):
            world.step()
        for kind, count in world.counts.items():
            counts[kind] += count
    return counts


def judged(counts: dict[str, int], steps: int) -> None:
    print(", ".join(f"{kind}: {count}" for kind, count in counts.items()))
    assert min(counts.values()) >= steps / 3, counts


@pytest.mark.slow
def test_memory_answers_what_a_run_would() -> None:
    judged(play(SOME // 2), SOME // 2)


@pytest.mark.tier("memory")
def test_memory_answers_what_a_run_would_many_times() -> None:
    judged(play(ALL, 1_000), ALL)


@pytest.mark.tier("memory")
@pytest.mark.slow
def test_memory_answers_so_on_a_disk_with_a_plugin_too(tmp_path: Path) -> None:
    judged(play(SOME // 10, 0, tmp_path), SOME // 10)


@pytest.mark.tier("memory")
def test_memory_answers_so_on_a_disk_with_a_plugin_many_times(tmp_path: Path) -> None:
    judged(play(SOME, 1_000, tmp_path), SOME)


# ---- That these tests can fail ----


@contextmanager
def forgets(*kinds: str) -> Iterator[None]:
    own = notes.Notes.take

    def take(self: notes.Notes, question: notes.Question, answer: str) -> None:
        if question[0].partition(" ")[0] not in kinds:
            own(self, question, answer)

    with mock.patch.object(notes.Notes, "take", take):
        yield


@contextmanager
def forgets_absences() -> Iterator[None]:
    own = notes.Notes.take

    def take(self: notes.Notes, question: notes.Question, answer: str) -> None:
        if answer and not answer.startswith("! "):
            own(self, question, answer)

    with mock.patch.object(notes.Notes, "take", take):
        yield


@contextmanager
def believes_times() -> Iterator[None]:
    def as_seen(kind: str, path: str, seen: dict[str, tuple[str, int]]) -> bool:
        if path not in seen or not kind.startswith(("bytes", "head")):
            return False
        now = disk().status(path).signature.split()
        return now[2:4] == seen[path][0].split()[2:4]

    with mock.patch.object(memory, "_as_seen", as_seen):
        yield


@contextmanager
def digests_after_the_run() -> Iterator[None]:
    own = memory.remember

    def remember(key: list[str], told: notes.Notes, done: memory.Done) -> bool:
        for question in told.answers:
            if question[0] == "bytes":
                told.answers[question] = asking.answer(*question)
        return own(key, told, done)

    with mock.patch.object(memory, "remember", remember):
        yield


@contextmanager
def forgets_what_it_remembers() -> Iterator[None]:
    with mock.patch.object(memory, "note_all"):
        yield


@contextmanager
def forgets_where_it_is() -> Iterator[None]:
    with mock.patch.object(memory, "surroundings", list), mock.patch.object(memory, "_here", str):
        yield


FAULTS = {
    "where it is": forgets_where_it_is,
    "variables": lambda: forgets("variable"),
    "links": lambda: forgets("link", "real"),
    "absences": forgets_absences,
    "listings": lambda: forgets("names"),
    "believes times": believes_times,
    "digests after the run": digests_after_the_run,
    "what a process remembers": forgets_what_it_remembers,
    "outputs": lambda: forgets("contents"),
}


@pytest.mark.landing("memory", "links", "believes times", "outputs")
@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_a_planted_fault_is_found(fault: str) -> None:
    with ExitStack() as stack:
        stack.enter_context(FAULTS[fault]())
        with pytest.raises(Wrong):
            play(SOME)


@pytest.mark.slow
def test_a_plugin_that_is_not_listened_to_is_found(tmp_path: Path) -> None:
    with mock.patch.object(listening, "_opened"), pytest.raises(Wrong):
        play(SOME, 0, tmp_path)

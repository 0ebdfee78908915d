"""Notes: what a run has asked of the world, and what it was answered.

A run that is asked for again is the same one if each of these questions is answered as it was. Nothing else is
believed: no time of a folder, no list of inputs that somebody made afterwards. Notes that are spoiled are good for no
answer; why is kept for whoever wants to know.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    Given = ParamSpec("Given")
    Found = TypeVar("Found")

Question = tuple[str, str]  # what was asked, and of what


class Notes:
    """Questions with their answers, in the order in which they were asked first.

    ``seen`` has, for a file that was read, its signature and when that was taken (ns); ``written``, for a folder that
    was written, what its files are then: digests by path, "" for what somebody else keeps there.
    """

    def __init__(self) -> None:
        self.answers: dict[Question, str] = {}
        self.seen: dict[str, tuple[str, int]] = {}
        self.written: dict[str, dict[str, str]] = {}
        self.spoiled = ""

    def take(self, question: Question, answer: str) -> None:
        """Note an answer; another one than before means that nobody knows what the run was told."""
        if self.answers.setdefault(question, answer) != answer and not self.spoiled:
            self.spoiled = f"{question[0]} of {question[1]} has changed while it was read"

    def rows(self) -> list[tuple[str, str, str]]:
        """Return what was asked, of what, and the answer, in plain rows; none of notes that are good for no answer."""
        return [] if self.spoiled else [(*question, said) for question, said in self.answers.items()]

    def take_all(self, other: Notes) -> None:
        """Note what others have noted."""
        for question, answer in other.answers.items():
            self.take(question, answer)
        for path, seen in other.seen.items():
            self.seen.setdefault(path, seen)
        self.written.update(other.written)
        self.spoiled = self.spoiled or other.spoiled


_open: list[Notes] = []
_heard = Notes()  # what code of others has asked since the process began: it may remember anything


class noting:  # noqa: N801 - it is used as a function
    """Take down what is asked until the end of the block. What is noted within goes to the notes around it, too."""

    def __init__(self) -> None:
        self.notes = Notes()

    def __enter__(self) -> Notes:
        _open.append(self.notes)
        return self.notes

    def __exit__(self, *_: object) -> None:
        _open.remove(self.notes)
        note_all(self.notes)


def note(kind: str, subject: str, answer: str) -> None:
    """Take down a question and its answer, if somebody is noting."""
    if _open:
        _open[-1].take((kind, subject), answer)


def note_seen(path: str, signature: str, when: int) -> None:
    """Take down the signature of a file that is noted."""
    if _open:
        _open[-1].seen.setdefault(path, (signature, when))


def note_files(folder: str, files: dict[str, str]) -> None:
    """Take down which files a folder has after it was written, digests by path."""
    if _open:
        _open[-1].written[folder] = files


def written(folder: str) -> dict[str, str] | None:
    """Return which files a folder had when it was written; None if it was not."""
    return _open[-1].written.get(folder) if _open else None


def note_all(notes: Notes) -> None:
    """Take down what was noted elsewhere: by another process, or before."""
    if _open:
        _open[-1].take_all(notes)


def note_heard(notes: Notes) -> None:
    """Take down what code of others has asked, for this run and all that come after it in this process."""
    _heard.take_all(notes)
    note_all(notes)


def note_all_heard() -> None:
    """Take down what code of others has asked so far."""
    note_all(_heard)


def spoil(why: str) -> None:
    """Say that the run depends on something that cannot be noted: it will not be remembered."""
    if _open and not _open[-1].spoiled:
        _open[-1].spoiled = why


def are_open() -> bool:
    """Say whether somebody is noting."""
    return bool(_open)

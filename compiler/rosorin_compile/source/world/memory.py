"""Memory: a run that would only do again what it did before is not made; what it said is said again.

A record is kept for each key (a command line, or a command with one robot and its options): the notes of the run,
the tool and the folders of artifacts as it left them, what it said, and how it ended. Asked for the same key,
each question of the notes is asked again, and if all are answered as they were, so is the run. There is no other reason
to believe a record: no time of a folder, no list of inputs. A record that is damaged in whatever way is none.

It is asked before the command line is read, so this room imports nothing that takes long.
"""

from __future__ import annotations

import marshal
import os
import sys
from functools import wraps
from typing import TYPE_CHECKING

from ..cache import digest, keep, private_folder, recalled
from ..memo import forget_too
from .asking import answer, note_contents, note_tool
from .disk import disk
from .notes import Notes, note_all, note_all_heard, noting
from .tool import is_racy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence
    from typing import Any, ParamSpec, TypeVar

    Given = ParamSpec("Given")
    Found = TypeVar("Found")

COMMANDS = ("all", "compile", "print", "check")
OUT, ERR, RAW = "out", "err", "raw"  # what was said: text on standard output and error, an artifact
FINE, PROBLEMS = 0, 1
SMALL = 64_000  # bytes: what is not larger counts by its content alone
_VERSION = 1
_MOST = 1_000  # results of a function that a process remembers

Said = list[tuple[str, str]]
_heard: Said = []
_works: list[int] = []  # that are under way: where in ``_heard`` the words of each begin


class Done:
    """What a run did: how it ended, what it said, and numbers that somebody adds up."""

    def __init__(self, code: int, said: Said, numbers: dict[str, int]) -> None:
        self.code = code
        self.said = said
        self.numbers = numbers


def hear(kind: str, text: str) -> None:
    """Take down what is said, while it may be kept."""
    if text and _works:
        _heard.append((kind, text))


class otherwise:  # noqa: N801 - it is used as a function
    """Take something else down for what is said in the block: what would be said the next time."""

    def __init__(self, kind: str, text: str) -> None:
        self.kind = kind
        self.text = text

    def __enter__(self) -> None:
        self.before = len(_heard)

    def __exit__(self, *_: object) -> None:
        del _heard[self.before :]
        hear(self.kind, self.text)


def recall(key: Sequence[str]) -> Done | None:
    """Return what a run did, if it would only do the same again. Never raises."""
    try:
        file = _file(key)
        data = recalled(file) if file else None
        if data is None:
            return None
        version, answers, seen, said, code, numbers = marshal.loads(data)  # noqa: S302 - private, and of this digest
        notes = Notes()
        notes.answers, notes.seen = dict(answers), dict(seen)
        if version != _VERSION or not holds(notes):
            return None
        note_all(notes)
        return Done(code, said, numbers)
    except Exception:  # a record that is damaged in whatever way is none
        return None


def remember(key: Sequence[str], notes: Notes, done: Done) -> bool:
    """Keep what a run did, if its notes are good for an answer; say whether it was kept."""
    file = _file(key) if not notes.spoiled and done.code in (FINE, PROBLEMS) else ""
    if not file:
        return False
    rows = (_VERSION, list(notes.answers.items()), list(notes.seen.items()), done.said, done.code, done.numbers)
    try:
        keep(file, marshal.dumps(rows))
    except ValueError:
        return False
    return True


def once(
    key: Sequence[str],
    work: Callable[[], int],
    outputs: Iterable[str | os.PathLike[str]] = (),
    numbers: Callable[[], dict[str, int]] = dict,
) -> tuple[Done, bool]:
    """Return what a piece of work did, and whether it was known: it is done unless a record answers for it.

    ``outputs`` are folders as it leaves them; ``numbers`` returns what else it has come to.
    """
    known = recall(key)
    if known is not None:
        return known, True
    _works.append(len(_heard))
    try:
        with noting() as notes:
            code = work()
            note_tool()
            note_all_heard()
            for folder in outputs:
                note_contents(folder)
        done = Done(code, _heard[_works[-1] :], numbers())
    finally:
        _works.pop()
        if not _works:
            _heard.clear()
    remember(key, notes, done)
    return done, False


def asked_again(work: Callable[Given, Found]) -> Callable[Given, Found]:
    """Return a function that uses a result again while what it asked for it is answered as it was.

    Each time that is noted anew: whoever uses the result depends on it. What is raised is not remembered.
    """
    known: dict[Any, tuple[Found, Notes]] = {}

    @wraps(work)
    def remembering(*given: Given.args, **named: Given.kwargs) -> Found:
        # A relative path is another file elsewhere.
        key = (_here(), given, tuple(sorted(named.items())))
        if key in known and holds(known[key][1]):
            note_all(known[key][1])
            return known[key][0]
        if len(known) >= _MOST:
            known.clear()
        with noting() as notes:
            found = work(*given, **named)
        known[key] = found, notes
        return found

    forget_too(known.clear)
    return remembering


def _here() -> str:
    try:
        return disk().here()
    except OSError:
        return ""


def is_asked_often(words: Sequence[str]) -> bool:
    """Say whether a command line is one whose runs are remembered."""
    return bool(words) and words[0] in COMMANDS and sys.stdout is not None and sys.stderr is not None


def line(words: Sequence[str]) -> list[str]:
    """Return the key of a command line, with all that is seen of where it is called from, and is asked of nobody."""
    return ["line", *words, "", *surroundings()]


def surroundings() -> list[str]:
    """Return what decides how something is said: the folder that names are seen from, terminals, encodings."""
    streams = (sys.stdout, sys.stderr)
    seen = [f"{stream.isatty()} {getattr(stream, 'encoding', '')}" for stream in streams]
    return [disk().here(), *seen, sys.getfilesystemencoding(), str(sys.flags)]


def say_again(words: Sequence[str]) -> Done | None:
    """Say what a command line said the last time, if a run would only do the same; None if a run is to be made."""
    done = recall(line(words)) if is_asked_often(words) else None
    return done if done is not None and say(done) else None


def say(done: Done) -> bool:
    """Say what a run said; false if that fails, and then a run is to say why."""
    try:
        for kind, text in done.said:
            stream = sys.stderr if kind == ERR else sys.stdout
            stream.buffer.write(text.encode("utf-8" if kind == RAW else stream.encoding, "backslashreplace"))
            stream.flush()
    except Exception:
        return False
    return True


def _file(key: Sequence[str]) -> str:
    folder = private_folder("runs")
    if not folder:
        return ""
    whole = "\0".join([sys.version, __file__, *key])
    return os.path.join(folder, digest(whole.encode("utf-8", "surrogateescape")))


def holds(notes: Notes) -> bool:
    """Say whether each question is answered as it was."""
    try:
        return all(
            _as_seen(*question, notes.seen) or answer(*question) == said for question, said in notes.answers.items()
        )
    except OSError:
        return False


def answers_now(notes: Notes) -> list[str]:
    """Return how each question is answered now; "?" for what is odd."""
    found = []
    for question in notes.answers:
        try:
            found.append(answer(*question))
        except OSError:
            found.append("?")
    return found


def _as_seen(kind: str, path: str, seen: dict[str, tuple[str, int]]) -> bool:
    """Say whether a large file has the signature that it had when it was read, and cannot have another content."""
    if not kind.startswith(("bytes", "head")) or path not in seen:
        return False
    signature, when = seen[path]
    if int(signature.split()[2]) <= SMALL:
        return False
    status = disk().status(path)
    return status.own and status.signature == signature and not is_racy(status.changed, when)

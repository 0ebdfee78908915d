"""Asking: each function here asks the system one thing, and notes what it was told.

``answer`` gives the same answer in one line of text, for the question that was noted: so a question that is asked again
is answered by the very code that answered it first.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from ..cache import digest
from .disk import ABSENCES, ABSENT, FILE, FOLDER, Status, disk
from .notes import are_open, note, note_files, note_seen, spoil, written
from .tool import signature

if TYPE_CHECKING:
    from collections.abc import Iterator

    Name = str | os.PathLike[str]

BYTES, _HEAD, _KIND, _LINK, _SIZE, _MODE, _NAMES, _REAL = (
    "bytes",
    "head",
    "kind",
    "link",
    "size",
    "mode",
    "names",
    "real",
)
_SAME, _VARIABLE, _ALL, _HERE, _PACKAGE = "same", "variable", "environment", "here", "package"
_CONTENTS, _TOOL, _ENDING = "contents", "tool", "ending"
OF_ENVIRONMENT = (_VARIABLE, _ALL)
_END = "\0"
_SET, _UNSET = "=", ""
_tools: list[str] = []  # the question which tool this is, its answer, and for which path of Python
# Variables that tell nothing of a run.
PASSING = ("_", "SHLVL", "OLDPWD")


def read(path: Name) -> bytes:
    """Return what is in a regular file. Raises OSError, for a pipe and the like too."""
    return _read(BYTES, os.fspath(path), -1)


def now() -> int:
    """Return the time (ns), by the clock from which the system takes the times of files."""
    return disk().now()


def note_read(path: Name, since: int) -> None:
    """Note a file that another process has read ``since`` then (``now``). Raises OSError."""
    read(path)
    if disk().status(os.fspath(path)).changed >= since:
        spoil(f"{os.fspath(path)} has changed while it was read")


def head(path: Name, most: int) -> bytes:
    """Return the first bytes of a regular file. Raises OSError as ``read``."""
    return _read(f"{_HEAD} {most}", os.fspath(path), most)


def text(path: Name, encoding: str = "utf-8", errors: str = "strict") -> str:
    """Return the text of a file, its lines ended as Python ends them. Raises OSError, UnicodeDecodeError."""
    return read(path).decode(encoding, errors).replace("\r\n", "\n").replace("\r", "\n")


def own_text(path: Name) -> str | None:
    """Return what stands in a file that this run has made, or a child of it; None if there is none.

    It is noted nowhere: what the run itself has written tells it nothing of the world. Raises OSError, if it cannot be
    read.
    """
    try:
        return disk().read(os.fspath(path))[0].decode("utf-8")
    except FileNotFoundError:
        return None


def stream(path: Name) -> BinaryIO:
    """Return a regular file to read from in pieces; the run is not remembered. Raises OSError as ``read``."""
    spoil(f"{os.fspath(path)} is read in pieces")
    return disk().stream(os.fspath(path))


def version(path: Name) -> str:
    """Return what tells a file from its next version while a process runs; the run is not remembered. Raises OSError.

    It is what a file system says, numbers with spaces between them, and no reason to believe that the bytes are equal.
    """
    spoil(f"{os.fspath(path)} is told by its times")
    return disk().status(os.fspath(path)).signature


def kind(path: Name) -> str:
    """Return what there is at a path, links followed: FILE, FOLDER, OTHER, or ABSENT, which is false."""
    place = os.fspath(path)
    found = _told(_KIND, place, lambda: disk().status(place).kind)
    return found if found is not None else ABSENT


def stands(path: Name) -> bool:
    """Say whether there is an entry of that name, if only a link that leads nowhere."""
    return bool(link(path) or kind(path))


def link(path: Name) -> str:
    """Return where a link leads, as it is written; "" for what is no link."""
    place = os.fspath(path)
    return _told(_LINK, place, lambda: disk().link(place)) or ""


def size(path: Name) -> int:
    """Return the size (bytes) of what there is at a path, links followed. Raises OSError."""
    place = os.fspath(path)
    return int(_asked(_SIZE, place, lambda: str(disk().status(place).size)))


def mode(path: Name) -> int:
    """Return the mode of what there is at a path, links followed, as ``os.stat`` has it. Raises OSError."""
    place = os.fspath(path)
    return int(_asked(_MODE, place, lambda: str(disk().status(place).mode)))


def names(folder: Name) -> dict[str, str]:
    """Return the kinds of what is in a folder, links followed, by name, sorted. Raises OSError."""
    place = os.fspath(folder) or "."
    found: dict[str, str] = {}

    def asked() -> str:
        found.update(disk().names(place))
        return _as_answer(found)

    _asked(_NAMES, place, asked)
    return found


def ending(folder: Name, endings: tuple[str, ...]) -> list[str]:
    """Return the names in a folder that end in one of some ways, sorted; nothing else is asked. Raises OSError."""
    place = os.fspath(folder) or "."
    told = _asked(_ENDING, _END.join([place, *endings]), lambda: _END.join(_ending(place, *endings)))
    return told.split(_END) if told else []


def _ending(place: str, *endings: str) -> list[str]:
    return [name for name in disk().names(place) if name.endswith(endings)]


def matching(folder: Name, pattern: str) -> list[Path]:
    """Return what matches a pattern of ``Path.glob`` below a folder, sorted; a folder that cannot be read has nothing.

    ``**`` stands for folders below each other, and does not follow links.
    """
    return sorted(set(_matching(Path(folder), pattern.split("/"))))


def _matching(folder: Path, parts: list[str]) -> Iterator[Path]:
    first, rest = parts[0], parts[1:]
    if first == "**":
        yield from _matching(folder, rest) if rest else (folder,)
        for name, found in _names_or_none(folder).items():
            if found == FOLDER and not link(folder / name):
                yield from _matching(folder / name, parts)
    elif not any(sign in first for sign in "*?["):
        if rest and kind(folder / first) == FOLDER:
            yield from _matching(folder / first, rest)
        elif not rest and stands(folder / first):
            yield folder / first
    else:
        for name, found in _names_or_none(folder).items():
            if not fnmatchcase(name, first):
                continue
            if not rest:
                yield folder / name
            elif found == FOLDER:
                yield from _matching(folder / name, rest)


def _names_or_none(folder: Path) -> dict[str, str]:
    try:
        return names(folder)
    except OSError:
        return {}


def real(path: Name) -> Path:
    """Return a path without links, as far as there is one, as ``Path.resolve`` does."""
    place = os.fspath(path)
    return Path(_asked(_REAL, place, lambda: disk().real(place)))


def is_same(path: Name, other: Name) -> bool:
    """Say whether two paths lead to the same file or folder; not if one is absent."""
    one, two = os.fspath(path), os.fspath(other)
    return _told(_SAME, f"{_whole(one)}{_END}{_whole(two)}", lambda: _same(one, two)) == "1"


def _same(one: str, two: str) -> str:
    try:
        found = [disk().status(path).signature.split()[:2] for path in (one, two)]
    except OSError as problem:
        if problem.errno in ABSENCES:
            return ""
        raise
    return "1" if found[0] == found[1] else ""


def variable(name: str, default: str = "") -> str:
    """Return the value of a variable of the environment; ``default`` if it is not set."""
    value = disk().environment().get(name)
    note(_VARIABLE, name, _UNSET if value is None else _SET + value)
    return default if value is None else value


def is_set(name: str) -> bool:
    """Say whether there is a variable of the environment."""
    value = disk().environment().get(name)
    note(_VARIABLE, name, _UNSET if value is None else _SET + value)
    return value is not None


class Environment(Mapping[str, str]):
    """The variables of the environment: one that is asked for is noted, and all of them where they are listed."""

    def __getitem__(self, name: str) -> str:
        if not is_set(name):
            raise KeyError(name)
        return variable(name)

    def __iter__(self) -> Iterator[str]:
        note(_ALL, "", _all())
        return iter(dict(disk().environment()))

    def __len__(self) -> int:
        note(_ALL, "", _all())
        return len(disk().environment())


def environment() -> Environment:
    """Return the variables of the environment, as a mapping that notes what is asked; of ``dict`` of it, all."""
    return Environment()


def _all() -> str:
    rows = sorted(f"{name}={value}" for name, value in disk().environment().items() if name not in PASSING)
    return digest(_END.join(rows).encode("utf-8", "surrogatepass"))


def here() -> Path:
    """Return the folder of the process. Raises OSError if it is gone."""
    return Path(_asked(_HERE, "", lambda: disk().here()))


def package(name: str) -> tuple[str, ...]:
    """Return the folders of an installed package of Python, not imported, or the file of a module; () for none."""
    found = disk().package(name)
    note(_PACKAGE, name, _END.join(found))
    return found


def note_contents(folder: Name) -> None:
    """Note the names, kinds and contents of all that is below a folder, as it stands now.

    What this run has written there (``note_written``) has to stand there still, and nothing else beside it.
    """
    place = _whole(os.fspath(folder))
    try:
        rows = _rows(place)
        note(_CONTENTS, place, _digest_of_rows(rows))
    except OSError as problem:
        spoil(f"{place}: {problem.strerror}")
        return
    wrote = written(place)
    if wrote is not None and not _are(rows, wrote):
        spoil(f"what stands in {place} is not what was written")


def _are(rows: Iterable[tuple[str, str, str, str]], wrote: Mapping[str, str]) -> bool:
    """Say whether all that is below a folder but folders, links not followed, is what was written there."""
    found: dict[str, str] = {}
    links: list[str] = []
    for path, what, link, told in rows:
        if (what != FOLDER or link) and not any(path.startswith(f"{one}/") for one in links):
            found[path] = told
            links += [path] if link else []
    return found.keys() == wrote.keys() and all(not told or found[path] == told for path, told in wrote.items())


def note_written(folder: Name, files: Mapping[str, bytes], kept: Iterable[str]) -> None:
    """Note that a folder has these files, bytes by relative name, since this run, and the names of others there."""
    if are_open():
        place = _whole(os.fspath(folder))
        told = {**{f"{place}/{name}": "" for name in kept}, **{f"{place}/{n}": digest(d) for n, d in files.items()}}
        note_files(place, told)


def note_tool() -> None:
    """Note which tool this is, if the program has said so (``tool_is``)."""
    if _tools:
        note(*_tools[:3])


def tool_is(folders: Iterable[str]) -> None:
    """Say in which folders the files of the tool are; which they are is worked out once for a process and its path."""
    whole = _END.join(folders)
    asked = [whole, *sys.path]
    if _tools[3:] != asked:
        _tools[:] = [_TOOL, whole, signature(whole, disk().now()), *asked]


def _contents(folder: str) -> str:
    return _digest_of_rows(_rows(folder))


def _digest_of_rows(rows: Iterable[tuple[str, ...]]) -> str:
    return digest(_END.join(" ".join(row) for row in rows).encode("utf-8", "surrogateescape"))


def _rows(folder: str) -> list[tuple[str, str, str, str]]:
    """Return path, kind, link and digest of all that is below a folder. Raises OSError."""
    rows: list[tuple[str, str, str, str]] = []
    waiting, seen = [folder], set()
    while waiting:
        here = waiting.pop()
        place = disk().real(here)
        if place in seen:  # links that lead round
            continue
        seen.add(place)
        try:
            inside = disk().names(here)
        except (FileNotFoundError, NotADirectoryError) as problem:
            rows.append((here, FOLDER, _absence(problem), ""))
            continue
        for name, what in inside.items():
            path = f"{here}/{name}"
            rows.append((path, what, disk().link(path), _digest_of(path, -1) if what == FILE else ""))
            waiting += [path] if what == FOLDER else []
    return rows


def _whole(path: str) -> str:
    """Return a path as seen from anywhere: what is asked again may be asked from another folder."""
    if path.startswith("/") or not are_open():
        return path
    try:
        return os.path.join(disk().here(), path)
    except OSError:
        spoil("the folder of the process is gone")
        return path


def _asked(question: str, path: str, asked: Callable[[], str]) -> str:
    """Return what the system says, and note it. Raises OSError."""
    try:
        found = asked()
    except OSError as problem:
        _note_problem(question, path, problem)
        raise
    note(question, path if question in (_SAME, _HERE) else _whole(path), found)
    return found


def _told(question: str, path: str, asked: Callable[[], str]) -> str | None:
    """Return what the system says, and note it; None for what is not there, or cannot be looked at."""
    try:
        return _asked(question, path, asked)
    except OSError:
        return None


def _note_problem(question: str, path: str, problem: OSError) -> None:
    note(question, path if question in (_SAME, _HERE) else _whole(path), _absence(problem))
    if problem.errno not in (*ABSENCES, errno.EISDIR):
        spoil(f"{path}: {problem.strerror}")


def _absence(problem: OSError) -> str:
    """Return the answer that says why there is none."""
    return f"! {errno.errorcode.get(problem.errno or 0, '')}"


def _read(question: str, path: str, most: int) -> bytes:
    """Return what is in a file, and note its digest with the signature that it had."""
    when = disk().now() if are_open() else 0
    try:
        data, before, after = disk().read(path, most)
    except OSError as problem:
        _note_problem(question, path, problem)
        raise
    if are_open():
        whole = _whole(path)
        note(question, whole, digest(data))
        note_seen(whole, before.signature, when)
        _look_at(path, before, after, len(data), most)
    return data


def _look_at(path: str, before: Status, after: Status, read: int, most: int) -> None:
    """Spoil the notes if nobody knows what was read."""
    if not before.own:
        spoil(f"{path} belongs to somebody else")
    elif before.signature != after.signature or (most < 0 and read != before.size):
        spoil(f"{path} has changed while it was read")


def answer(question: str, subject: str) -> str:
    """Return what the system says to a question that was noted, as it was noted. Raises OSError for what is odd."""
    asked, _, most = question.partition(" ")
    try:
        return _ANSWERS[asked](subject, int(most or -1))
    except OSError as problem:
        if problem.errno not in (*ABSENCES, errno.EISDIR):
            raise
        return _absence(problem)


def _as_answer(found: Mapping[str, str]) -> str:
    rows = [f"{name}/{what}" for name, what in found.items()]
    return digest(_END.join(rows).encode("utf-8", "surrogateescape"))


def _digest_of(path: str, most: int) -> str:
    data, before, _ = disk().read(path, most)
    if not before.own:
        raise OSError(errno.EPERM, "It belongs to somebody else", path)
    return digest(data)


def _value_of(name: str) -> str:
    value = disk().environment().get(name)
    return _UNSET if value is None else _SET + value


_ANSWERS: dict[str, Callable[[str, int], str]] = {
    BYTES: _digest_of,
    _HEAD: _digest_of,
    _KIND: lambda path, _: disk().status(path).kind,
    _LINK: lambda path, _: disk().link(path),
    _SIZE: lambda path, _: str(disk().status(path).size),
    _MODE: lambda path, _: str(disk().status(path).mode),
    _NAMES: lambda folder, _: _as_answer(disk().names(folder)),
    _ENDING: lambda asked, _: _END.join(_ending(*asked.split(_END))),
    _REAL: lambda path, _: disk().real(path),
    _SAME: lambda paths, _: _same(*paths.split(_END)),
    _VARIABLE: lambda name, _: _value_of(name),
    _ALL: lambda _, __: _all(),
    _HERE: lambda _, __: disk().here(),
    _PACKAGE: lambda name, _: _END.join(disk().package(name)),
    _CONTENTS: lambda folder, _: _contents(folder),
    _TOOL: lambda folders, _: signature(folders, disk().now()),
}

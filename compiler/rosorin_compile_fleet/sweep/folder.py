"""Variants: a folder that holds a folder of artifacts for each of many robots, and equal artifacts once.

Below it stands a hidden folder: ``objects`` has each artifact under its SHA-256, of which the folders of the variants
have hard links; ``records`` has a file a variant that says of what and by whom it was made, and the digests of its
artifacts; ``made_of`` has the digests of the files that variants were made of, which most of them share.

A variant is prepared beside the others and renamed into its place: after a kill at any moment each folder is whole,
old or new. Before that its record says which files are ours, old ones and new, so that none is ever nobody's; after
that, by what it was made. A record alone proves nothing: a variant counts as made when its files are those of the
record, byte for byte, so that what was edited, or lost in a power failure, is made anew. Objects are read-only, since
an edit in place would show up in other variants; it is found, and what has it is made anew, too. Where a file system
has no hard links, there are copies and no objects.

What is not ours stays: it is carried over when a folder is replaced, and no folder goes that holds it.
"""

from __future__ import annotations

import errno
import json
import os
import stat
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import Heading, Rule
from rosorin_compile.extending import Holding, OutputError, Stage, world

RULES = (
    Rule(
        "output-busy",
        "Another run writes into the folder.",
        "Wait until it ends, or name another folder.",
        Heading.WRITING,
    ),
)

HIDDEN = ".rosorin-compile-sweep"
INDEX = "sweep.json"
BEGIN = b'{"sweep": '
_PATIENCE = 10.0  # seconds in which processes of a run that was killed end what they are at
_LET_GO = 2.0  # seconds in which such a process, killed as it began, lets go of the lock that it got from the run
_NO_LINKS = {errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EXDEV, errno.ENOSYS}
_KNOWN_SOUND = 4_000  # objects of which a process remembers that they are as they were
_READ_ONLY = 0o444


class Record(NamedTuple):
    """What is known of a variant: ``key`` tells by what it was made, ``made_of`` of which files.

    ``line`` is its line of the index, ``at`` its place in the list of variants, if the result names it.
    """

    key: str
    made_of: str
    at: int
    line: str

    @property
    def artifacts(self) -> dict[str, str]:
        """The digests of the artifacts, by name."""
        found: dict[str, str] = json.loads(self.line)["artifacts"]
        return found


def unfinished(record: Record, before: Record | None) -> Record:
    """Return what is known of a variant while it is replaced: nothing but which files are ours, old ones and new."""
    line = json.loads(record.line)
    line["artifacts"] = {**(before.artifacts if before else {}), **line["artifacts"]}
    return Record("", "", 0, json.dumps(line))


class Stored(NamedTuple):
    """How many artifacts are stored, equal ones once, and their bytes."""

    objects: int
    size: int


class VariantsFolder:
    """A folder of variants, for one process of a run. ``base`` is the folder from which the paths in it are seen."""

    def __init__(self, path: Path) -> None:
        self.address = str(path)
        self.path = path
        self.base = path
        self.hidden = path / HIDDEN
        self.links = True
        self.lock: int | None = None
        self.sound: dict[str, tuple[int, int, int]] = {}

    def place(self, name: str) -> Path:
        """Return where the artifacts of a variant stand."""
        return self.path / name

    def named(self, path: Path) -> str:
        """Return how a file is called in the index: as seen from the folder."""
        return os.path.relpath(path, self.path)

    def explained(self, problem: OSError) -> OutputError:
        """Return the error for a user when something cannot be written."""
        return OutputError.of(problem, self.path, "write")

    # The run as a whole.

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Make the folder, and keep other runs from it. Raises OutputError."""
        try:
            self.hidden.mkdir(parents=True, exist_ok=True)
            with (self.hidden / "lock").open("ab") as lock, (self.hidden / "working").open("ab") as working:
                self._take(lock.fileno(), _LET_GO)
                self.lock = lock.fileno()
                self._take(working.fileno(), _PATIENCE)
                working.close()
                self._check_index()
                Stage.tidy(self.path)
                Stage.tidy(self.hidden)
                self._announcement.unlink(missing_ok=True)
                try:
                    yield
                finally:
                    self._announcement.unlink(missing_ok=True)
        except OSError as problem:
            raise self.explained(problem) from None

    @contextmanager
    def working(self) -> Iterator[None]:
        """Let a next run wait for this process, should the run end before it."""
        with (self.hidden / "working").open("ab") as working:
            with suppress(OSError):
                world.lock(working.fileno(), shared=True)
            yield

    def announced(self) -> str:
        """Leave a word by which a process elsewhere knows the folder of this run; return it. Raises OSError."""
        word = os.urandom(16).hex()
        self._announcement.write_text(word)
        return word

    @contextmanager
    def joined(self, word: str) -> Iterator[bool]:
        """Do as ``working`` if this is the folder of the run with that word, and this user's; say whether it is."""
        if not self._announces(word):
            yield False
            return
        with self.working():
            yield self._announces(word)  # while this process waited, a next run may have begun

    def _announces(self, word: str) -> bool:
        try:
            return world.is_own(self._announcement.stat()) and self._announcement.read_text() == word
        except OSError:
            return False

    @property
    def _announcement(self) -> Path:
        return self.hidden / "run"

    def _take(self, handle: int, patience: float) -> None:
        """Take a lock, waiting for it so many seconds. Raises OutputError if another run keeps it.

        On some network drives there is none to be had.
        """
        until = time.monotonic() + patience
        while True:
            try:
                world.lock(handle, wait=False)
            except BlockingIOError:
                if time.monotonic() < until:
                    time.sleep(0.05)
                    continue
                message = f"another run writes into {self.path}"
                raise OutputError("output-busy", message, "wait until it ends, or name another folder") from None
            except OSError:
                return
            return

    def _check_index(self) -> None:
        """Raise OutputError if another program's file stands where the index goes."""
        with suppress(FileNotFoundError), (self.path / INDEX).open("rb") as file:
            if file.read(len(BEGIN)) not in (BEGIN, b""):
                message = f"this tool did not write {self.path / INDEX}: it is not replaced"
                raise OutputError("output-not-ours", message, "move it away, or name another folder")

    def sweep_up(self) -> Stored:
        """Remove the objects that no variant has any more; return what is stored. Raises OSError."""
        count = size = 0
        for _, entry in Stage.below(self.hidden / "objects") if (self.hidden / "objects").is_dir() else ():
            if not entry.is_file(follow_symlinks=False):
                continue
            status = entry.stat(follow_symlinks=False)
            if status.st_nlink == 1:
                os.unlink(entry.path)  # noqa: PTH108 - of an entry
            else:
                count, size = count + 1, size + status.st_size
        return Stored(count, size)

    def names(self) -> Iterator[str]:
        """Yield the names of the variants of which there is a record, in no order."""
        for shard in sorted((self.hidden / "records").glob("*/")):
            for entry in list(os.scandir(shard)):
                if entry.name.endswith(".json"):
                    yield entry.name[:-5]

    # The index.

    def index(self) -> Index:
        """Return what writes the index of all variants."""
        return Index(self)

    # A variant.

    def record(self, name: str) -> Record | None:
        """Return what is known of a variant; None if nothing is, or its record is damaged."""
        try:
            known = json.loads(self._record(name).read_bytes())
            return Record(str(known["key"]), str(known["made_of"]), int(known["at"]), str(known["line"]))
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def holds(self, name: str, artifacts: Mapping[str, str]) -> bool:
        """Say whether the folder of a variant has artifacts with these digests."""
        folder = self.path / name
        try:
            return bool(artifacts) and all(self._has(folder / file, known) for file, known in artifacts.items())
        except OSError:
            return False

    def put(self, name: str, files: Mapping[str, bytes], record: Record | None) -> None:
        """Make ``files`` the artifacts of a variant; with none there is no folder. Raises OutputError, OSError.

        ``record`` is what will be known of it; None forgets it.
        """
        before = self.record(name)
        folder = self.path / name
        foreign, ours = self._there(folder, files, before.artifacts if before else {})
        with Stage.within(self.path) as stage:
            new = stage.path / name
            new.mkdir(parents=True)
            for entry in foreign:
                stage.carry(folder / entry, f"{name}/{entry}")
            for file, data in files.items():
                (new / file).parent.mkdir(parents=True, exist_ok=True)
                self._store(stage.path, new / file, data)
            gone = [one for one in ours if one not in files]
            if record is not None:
                self._remember(stage.path, name, unfinished(record, before))
            if files or foreign:
                stage.put(name, folder, list(files), gone)
            elif os.path.lexists(folder):
                folder.rename(stage.path / "gone")
            self._remember(stage.path, name, record)

    def drop(self, name: str) -> None:
        """Remove the artifacts of a variant that there is to be no more. Raises OSError."""
        self.put(name, {}, None)

    def _there(self, folder: Path, files: Mapping[str, bytes], known: Mapping[str, str]) -> tuple[list[str], list[str]]:
        """Return what in a folder is somebody else's, and what is ours. Raises OutputError, OSError."""
        if not os.path.lexists(folder):
            return [], []
        if folder.is_symlink() or not folder.is_dir():
            what = "a symbolic link" if folder.is_symlink() else "not a folder"
            raise OutputError("output-in-the-way", f"{folder} is {what}", "move it away, or rename the variant")
        foreign: list[str] = []
        ours: list[str] = []
        for name, entry in Stage.below(folder):
            if entry.is_dir(follow_symlinks=False):
                continue
            if name in files and not (name in known or _is_ours(Path(entry.path), files[name])):
                message = f"this tool did not write {folder / name}: it is not replaced"
                raise OutputError("output-not-ours", message, "move it away, or name another folder")
            (ours if name in files or name in known else foreign).append(name)
        return foreign, ours

    def _has(self, file: Path, known: str) -> bool:
        """Say whether a file has a digest, or is the same file as an object that has it. Raises OSError."""
        status = file.lstat()
        if not stat.S_ISREG(status.st_mode):
            return False
        if self._sound(known, status.st_ino):
            return True
        return Holding.digest(file.read_bytes()) == known

    def _sound(self, known: str, number: int = 0) -> bool:
        """Say whether an object is as it was, and the file with this number; one that is not is removed."""
        place = self._object(known)
        try:
            status = place.lstat()
        except FileNotFoundError:
            return False
        mark = (status.st_ino, status.st_size, status.st_mtime_ns)
        if number and number != status.st_ino:
            return False
        if self.sound.get(known) == mark:
            return True
        if Holding.digest(place.read_bytes()) != known:
            place.unlink(missing_ok=True)
            return False
        if len(self.sound) >= _KNOWN_SOUND:
            self.sound.clear()
        self.sound[known] = mark
        return True

    def _object(self, known: str) -> Path:
        return self.hidden / "objects" / known[:2] / known[2:]

    def _record(self, name: str) -> Path:
        return self.hidden / "records" / Holding.digest(name.encode())[:2] / f"{name}.json"

    def _store(self, stage: Path, target: Path, data: bytes) -> None:
        """Let ``target`` be a link to the object of some bytes, or a copy of them. Raises OSError."""
        known = Holding.digest(data)
        place = self._object(known)
        if self.links and self._sound(known) and self._linked(place, target):
            return
        new = stage / "new"
        new.write_bytes(data)
        # Where there is an object, no more links can be made to it: the next ones lead to this one.
        if not self.links or not self._linked(new, target):
            new.rename(target)
            return
        new.chmod(_READ_ONLY)
        place.parent.mkdir(parents=True, exist_ok=True)
        new.replace(place)

    def _linked(self, place: Path, target: Path) -> bool:
        """Make a hard link; say whether that could be done. Raises OSError."""
        try:
            world.hard_link(place, target)
        except OSError as problem:
            if problem.errno in (errno.EMLINK, errno.ENOENT):
                return False
            if problem.errno not in _NO_LINKS:
                raise
            self.links = False
            return False
        return True

    def _remember(self, stage: Path, name: str, record: Record | None) -> None:
        place = self._record(name)
        if record is None:
            place.unlink(missing_ok=True)
            return
        (stage / "record").write_text(json.dumps(record._asdict()), "utf-8")
        place.parent.mkdir(parents=True, exist_ok=True)
        (stage / "record").replace(place)

    # What variants were made of.

    def keep_made_of(self, files: Mapping[str, Any]) -> str:
        """Keep what a variant was made of, plain JSON; return the name under which it is known. Raises OSError."""
        data = json.dumps(files, sort_keys=True).encode()
        known = Holding.digest(data)
        place = self.hidden / "made_of" / f"{known}.json"
        if not place.is_file():
            place.parent.mkdir(exist_ok=True)
            with Stage.within(self.hidden) as stage:
                (stage.path / "made_of").write_bytes(data)
                (stage.path / "made_of").replace(place)
        return known

    def made_of(self, known: str) -> dict[str, Any] | None:
        """Return what is kept under a name; None if that is nothing."""
        try:
            data = (self.hidden / "made_of" / f"{known}.json").read_bytes()
            found = json.loads(data) if Holding.digest(data) == known else None
        except (OSError, ValueError):
            return None
        return found if isinstance(found, dict) else None


class Index:
    """Writes the index of all variants, line by line; it stands in its place when all is done, and not before."""

    def __init__(self, folder: VariantsFolder) -> None:
        self.place = folder.path / INDEX
        self.new, self.old = folder.hidden / "index.new", folder.hidden / "index.old"
        self.file = self.new.open("w", encoding="utf-8", newline="\n")

    def write(self, text: str) -> None:
        """Add some text. Raises OSError."""
        self.file.write(text)

    def outdate(self) -> None:
        """Take the old index away: from now on the variants are not as it says. Raises OSError."""
        with suppress(FileNotFoundError):
            self.place.replace(self.old)

    def close(self) -> None:
        """Put the new index into its place; one that is equal stays the same file. Raises OSError."""
        import filecmp

        self.file.close()
        for old in (self.place, self.old):
            if old.is_file() and filecmp.cmp(old, self.new, shallow=False):
                if old != self.place:
                    old.replace(self.place)
                self.new.unlink()
                break
        else:
            self.new.replace(self.place)
        self.old.unlink(missing_ok=True)

    def leave(self) -> None:
        """Leave without an index: not all is done."""
        self.file.close()
        with suppress(OSError):
            self.new.unlink()


def _is_ours(path: Path, new: bytes) -> bool:
    """Say whether a file of which nothing is known is one that we have written, or can be replaced without a loss."""
    if path.is_symlink() or not path.is_file():
        return False
    old = path.read_bytes()
    return old == new or Holding.is_marked(old) or not old.strip()

"""Output: the only code that writes artifacts.

A set of artifacts is replaced as a whole. The new set is written into a folder of its own beside the old one, and then
the two change places (see ``staging``, which also says what remains of this promise on file systems that cannot do
it). A lock on the parent folder keeps two runs from working at once; it leaves no file behind.

The output folder is for artifacts. What else somebody keeps there is carried over into the new folder as hard links,
so that it stays the same file, with its times and permissions.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, error
from rosorin_compile.source.rule_registry import WRITING, Rule
from rosorin_compile.source.wording import printable

from . import staging
from .staging import There, is_stage, replace, tidy

RULES = (
    Rule(
        "output-kept",
        "A warning: a file was replaced that the tool may not have written; it is kept under the name that is told.",
        "Remove what was kept, if nobody needs it.",
        WRITING,
    ),
    Rule(
        "output-folder",
        "The outputs folder cannot be one: a link, a file, the folder that you stand in.",
        "Name a folder of its own.",
        WRITING,
    ),
    Rule(
        "output-name",
        "An artifact would not stand in the folder, or is the folder of another.",
        "Another `file`.",
        WRITING,
    ),
    Rule("output-in-the-way", "Something that is no artifact stands where one goes.", "Move it away.", WRITING),
    Rule(
        "output-not-ours",
        "Where a file would go, one stands that the tool did not write.",
        "Move it away, or another name or folder.",
        WRITING,
    ),
    Rule(
        "output-foreign",
        "The folder holds many files that are no artifacts, or a repository.",
        "Name a folder of its own.",
        WRITING,
    ),
    Rule(
        "output-text",
        "An artifact has a character that UTF-8 cannot write.",
        "Remove it from the description.",
        WRITING,
    ),
    Rule("output-read-only", "You may not write there.", "Get the right, or use `-o`.", WRITING),
    Rule("output-unreadable", "You may not read there.", "Get the right, or use `-o`.", WRITING),
    Rule("output-full", "The disk is full.", "Make room, or use `-o`.", WRITING),
    Rule("output-mounted", "A file system is mounted at the outputs folder.", "Name a folder below it.", WRITING),
    Rule("output-failed", "Writing failed in another way, which the message names.", "Name another folder.", WRITING),
)

MAX_FOREIGN = 200  # files that are not artifacts, above which this does not look like an output folder

_READ_ONLY = {errno.EROFS, errno.EACCES, errno.EPERM}
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_NOT_A_FOLDER = {errno.ENOTDIR, errno.EEXIST}
_MOUNTED = {errno.EBUSY, errno.EXDEV}


Judge = Callable[[str, bytes, bytes], str]


class Written(NamedTuple):
    """What writing a set did to each file, by relative POSIX name, sorted.

    ``written`` is new or has other bytes than before, ``unchanged`` is equal already, ``kept`` is not an artifact of
    this set and was left alone, ``removed`` was not an artifact either and is gone because pruning was asked for.
    ``aside`` are those that somebody else may have written, each with the name under which it stands now.
    """

    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    aside: tuple[tuple[str, str], ...] = ()

    def put_aside(self, folder: Path) -> list[Diagnostic]:
        """Return what there is to say of files that somebody else may have written, and that were replaced."""
        help = "if nobody needs it, remove that file"
        return [
            Diagnostic(
                "output-kept", WARNING, f"{folder}/{name} may be of somebody else; it is {kept} now", None, (), help
            )
            for name, kept in self.aside
        ]


class OutputError(Exception):
    """The artifacts cannot be written or read; the old set stands as before. Carries the diagnostic."""

    def __init__(self, rule: str, message: str, help: str) -> None:
        super().__init__(message)
        self.diagnostic: Diagnostic = error(rule, printable(message), None, printable(help))

    @classmethod
    def of(cls, problem: OSError, folder: Path, verb: str, what: str = "output folder") -> OutputError:
        """Return the error for a user: what cannot be done, why, and the way out; ``what`` cannot be written."""
        place = problem.filename if isinstance(problem.filename, str) else str(folder)
        # The folder in which the new set is prepared has a name by chance, and is gone already.
        place = str(folder.parent) if any(is_stage(part) for part in Path(place).parts) else place
        reason = problem.strerror or type(problem).__name__
        message = f"cannot {verb} {folder}: {reason} ({place})"
        if problem.errno in _READ_ONLY:
            rule = "output-read-only" if verb == "write" else "output-unreadable"
            return cls(rule, message, f"give yourself the right to {verb} there, or name another {what}")
        if problem.errno in _FULL:
            return cls("output-full", message, f"make room on the disk, or name an {what} on another one")
        if problem.errno in _NOT_A_FOLDER:
            message = f"cannot {verb} {folder}: {place} is not a folder"
            return cls("output-folder", message, f"name another {what}, or move that file away")
        if problem.errno in _MOUNTED:
            message = f"cannot replace {folder} as a whole: a file system is mounted at {place}"
            return cls("output-mounted", message, "name a folder below the mount point as the output folder")
        return cls("output-failed", message, f"name another {what}")


def write_outputs(folder: Path, files: Mapping[str, str | bytes], prune: bool = False, whole: bool = True) -> Written:
    """Make ``files`` the set of artifacts in ``folder``, as ``write_set``; a file of somebody else is not lost.

    They are all that the robot has, or, without ``whole``, some of it.
    """
    from . import ours

    written = write_set(folder, files, prune, None if prune else ours.judge(folder, files))
    ours.remember(folder, files, whole)
    return written


def write_set(
    folder: Path,
    files: Mapping[str, str | bytes],
    prune: bool = False,
    judge: Judge | None = None,
    tidied: bool = False,
) -> Written:
    """Make ``files``, text or bytes by relative POSIX name, the set of artifacts in ``folder``.

    After a kill at any moment the folder holds the old set or the new one. If every file is equal already, nothing is
    touched. Other files in the folder are kept, or removed with ``prune``. ``judge`` says of a file that would be
    replaced, by its name, its bytes and the new ones, whether that is refused (``ours.FOREIGN``), or it is kept under
    another name (any other word). With ``tidied``, the caller has removed what killed runs left in the parent folder.
    Raises OutputError.
    """
    _check_place(folder)
    check_names(files)
    contents = {name: encoded(name, files[name]) for name in sorted(files)}
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with _locked(folder.parent, exclusive=True) as alone:
            if alone and not tidied:
                tidy(folder.parent)
            return _update(folder, contents, prune, judge)
    except OSError as problem:
        raise OutputError.of(problem, folder, "write") from None


def read_set(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all regular files below ``folder`` by relative POSIX name, sorted; none if it is missing.

    Waits for a run that is writing the set. Raises OutputError.
    """
    _check_place(folder)
    try:
        if not os.path.lexists(folder.parent):
            return {}
        with _locked(folder.parent, exclusive=False):
            if _status(folder) is None:
                return {}
            entries = [(n, entry.path) for n, entry in staging.below(folder) if entry.is_file(follow_symlinks=False)]
            return {printable(name): Path(path).read_bytes() for name, path in sorted(entries)}
    except OSError as problem:
        raise OutputError.of(problem, folder, "read") from None


@contextmanager
def cleared(folder: Path) -> Iterator[None]:
    """Hold the lock on a folder in which something is prepared, rid of what killed runs left there. Raises OSError."""
    with _locked(folder, exclusive=True) as alone:
        if alone:
            tidy(folder)
        yield


def _check_place(folder: Path) -> None:
    try:
        impossible = b"\0" in os.fsencode(folder)
    except UnicodeEncodeError:
        impossible = True
    if impossible or folder.name in ("", "..") or is_stage(folder.name):
        message = f'"{folder}" cannot be the output folder'
        raise OutputError("output-folder", message, 'name a folder of its own, such as "outputs/my_robot"')


def check_names(files: Collection[str]) -> None:
    """Raise OutputError for a name that is none below the folder, or that of the folder of another one."""
    for name in sorted(files):
        parts = name.split("/")
        if not name.isprintable() or any(part in ("", ".", "..") or part.casefold() == ".git" for part in parts):
            message = f'artifact "{name}" would not stand in the output folder'
            raise OutputError("output-name", message, 'name a file below the folder, such as "urdf/robot.urdf"')
        for parent in _parents(name):
            if parent in files:
                message = f'"{parent}" cannot be an artifact and the folder of the artifact "{name}"'
                raise OutputError("output-name", message, "give one of them another name")


def _parents(name: str) -> list[str]:
    """Return the folders that a relative name leads through: ``a`` and ``a/b`` for ``a/b/c``."""
    parts = name.split("/")
    return ["/".join(parts[:count]) for count in range(1, len(parts))]


def encoded(name: str, text: str | bytes) -> bytes:
    """Return the bytes of an artifact. Raises OutputError for what UTF-8 cannot write."""
    if isinstance(text, bytes):
        return text
    try:
        return text.encode("utf-8")
    except UnicodeEncodeError as problem:
        message = f'artifact "{name}" holds the character {text[problem.start]!a}, which UTF-8 cannot write'
        raise OutputError("output-text", message, "remove that character from the description") from None


@contextmanager
def _locked(parent: Path, exclusive: bool) -> Iterator[bool]:
    """Hold the lock on a folder; the value is False if it cannot be had, as on some network drives.

    Even then sets do not mix, since each run prepares its own folder. Raises OSError.
    """
    if not system.HAS_FOLDER_HANDLES:
        yield False
        return
    try:
        handle = os.open(parent, os.O_RDONLY | system.AS_FOLDER)
    except PermissionError:
        if exclusive:
            raise
        yield False
        return
    try:
        locked = False
        with suppress(OSError):
            system.lock(handle, shared=not exclusive)
            locked = True
        yield locked
    finally:
        os.close(handle)


def _update(folder: Path, contents: dict[str, bytes], prune: bool, judge: Judge | None) -> Written:
    """Compare the set with what is there, and replace the folder if anything differs. Raises OutputError, OSError."""
    status = _status(folder)
    if status:
        tidy(folder)  # of what was killed that wrote a single file there
    folders = set[str]().union(*map(_parents, contents))
    there = _look(folder, status.st_dev, folders.union(contents)) if status else {}
    _check_way(folder, contents, there, prune)
    same = {name for name, data in contents.items() if _holds(folder / name, there.get(name), data)}
    aside = _aside(folder, {name: contents[name] for name in contents if name in there and name not in same}, judge)
    contents |= {kept: (folder / name).read_bytes() for name, kept in aside}
    ours = {name for name, it in there.items() if name in folders and stat.S_ISDIR(it.st_mode)}
    foreign = [name for name in there if name not in ours and name not in contents]
    loose = tuple(printable(name) for name in foreign if not stat.S_ISDIR(there[name].st_mode))
    kept, removed = ((), loose) if prune else (loose, ())
    written = tuple(name for name in contents if name not in same)
    result = Written(
        tuple(name for name in written if name not in dict(aside).values()), tuple(sorted(same)), kept, removed, aside
    )
    if status is None or written or (prune and foreign):
        _check_writable(folder, status)
        stays = ours.union(same, () if prune else foreign)
        carried = {name: it for name, it in there.items() if name in stays}
        replace(folder, {name: contents[name] for name in written}, carried, there)
    return result


def _aside(folder: Path, replaced: Mapping[str, bytes], judge: Judge | None) -> tuple[tuple[str, str], ...]:
    """Return which files go to which other names. Raises OutputError for one that is not replaced."""
    if judge is None:
        return ()
    from .ours import FOREIGN, kept_name

    aside = []
    for name, new in replaced.items():
        path = folder / name
        old = path.read_bytes()
        why = judge(name, old, new)
        if why == FOREIGN:
            help = "move it away, or give the new file another name or folder"
            raise OutputError("output-not-ours", f"this tool did not write {path}: it is not replaced", help)
        if why:
            aside.append((name, kept_name(path).relative_to(folder).as_posix()))
    return tuple(aside)


def _status(folder: Path) -> os.stat_result | None:
    """Return the status of the output folder, None if it is missing. Raises OutputError if it is something else."""
    try:
        status = folder.lstat()
    except FileNotFoundError:
        return None
    if not stat.S_ISDIR(status.st_mode):
        what = "a symbolic link" if stat.S_ISLNK(status.st_mode) else "not a folder"
        message = f"the output folder {folder} is {what}"
        raise OutputError("output-folder", message, "name the real folder, or move the file away")
    return status


def _look(folder: Path, device: int, ours: set[str]) -> There:
    """Return all that is in the output folder. Raises OutputError if it does not look like an output folder."""
    there, foreign = {}, 0
    for name, entry in staging.below(folder):
        there[name] = entry.stat(follow_symlinks=False)
        foreign += name not in ours
        if entry.name == ".git" or foreign > MAX_FOREIGN:
            what = "a .git" if entry.name == ".git" else f"more than {MAX_FOREIGN} files that are not artifacts"
            message = f"{folder} holds {what}; the whole output folder is replaced, so it is for artifacts only"
            raise OutputError("output-foreign", message, "name a folder of its own, or move the other files away")
        if entry.is_dir(follow_symlinks=False) and there[name].st_dev != device:
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), entry.path)
    return dict(sorted(there.items()))


def _check_way(folder: Path, contents: Mapping[str, bytes], there: There, prune: bool) -> None:
    """Raise OutputError if something that is not ours stands where an artifact goes, or leads it elsewhere."""
    for name in contents:
        for step in (*_parents(name), name):
            if step not in there:
                continue
            kind = _kind(there[step].st_mode)
            if kind != ("a file" if step == name else "a folder") and not (prune and kind != "a symbolic link"):
                message = f'artifact "{name}" cannot be written: {folder / step} is {kind}'
                raise OutputError("output-in-the-way", message, "move it away, or give the artifact another name")


def _kind(mode: int) -> str:
    kinds = {stat.S_IFREG: "a file", stat.S_IFDIR: "a folder", stat.S_IFLNK: "a symbolic link"}
    return kinds.get(stat.S_IFMT(mode), "a special file")


def _holds(path: Path, status: os.stat_result | None, data: bytes) -> bool:
    """Say whether a regular file holds exactly these bytes."""
    if status is None or not stat.S_ISREG(status.st_mode) or status.st_size != len(data):
        return False
    return path.read_bytes() == data


def _check_writable(folder: Path, status: os.stat_result | None) -> None:
    """Raise OSError or OutputError if replacing the folder would be against the will of somebody."""
    if status is None:
        return
    if not os.access(folder, os.W_OK | os.X_OK):
        code = errno.EROFS if hasattr(os, "statvfs") and os.statvfs(folder).f_flag & os.ST_RDONLY else errno.EACCES
        raise OSError(code, os.strerror(code), str(folder))
    if status.st_dev != folder.parent.stat().st_dev:
        raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), str(folder))
    # A shell that stands in a folder that is replaced would see an empty folder from then on.
    with suppress(FileNotFoundError):
        if Path.cwd().is_relative_to(folder.resolve()):
            message = f"{folder} is replaced as a whole, and cannot be while the command runs inside it"
            raise OutputError("output-folder", message, "run the command from another folder")

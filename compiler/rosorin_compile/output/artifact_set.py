"""Write the artifacts of a robot as one set: after a kill at any moment the folder holds the old set or the new one.

A new folder is prepared and exchanged with the old one. Files that are not artifacts are hard-linked into it.
"""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Literal, NamedTuple

from rosorin_compile.source.cache import cache_folder
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.load import json_of
from rosorin_compile.source.wording import printable

from .single_file import OutputError, is_generated, kept_name
from .staging import STAGING_NAME, Entries, entries_below, locked, replace_folder, staging_folder

MAX_FOREIGN = 200  # files that are not artifacts, above which this does not look like an output folder
Decision = Literal["replace", "keep", "refuse"]  # keep: under another name
Judge = Callable[[str, bytes, bytes], Decision]  # of the name of a file, its bytes, and the new bytes


class WriteResult(NamedTuple):
    """The files of a folder after writing a set: new or changed artifacts, the others, and files that are no artifacts.

    All are relative POSIX names, sorted. ``renamed`` may be of somebody else, and are kept under another name.
    """

    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    renamed: tuple[tuple[str, str], ...] = ()

    def diagnostics(self, folder: Path) -> list[Diagnostic]:
        """Return a warning for each replaced file that somebody else may have written."""
        texts = [f"{folder}/{name} may be of somebody else; it is {kept} now" for name, kept in self.renamed]
        return [Diagnostic("output-kept", WARNING, t, help="remove that file if it is not needed") for t in texts]


def write_artifacts(
    folder: Path, files: Mapping[str, str | bytes], prune: bool = False, complete: bool = True
) -> WriteResult:
    """Write the artifacts of a robot, as ``write_set``; files of somebody else are refused or kept under another name.

    A file without the mark of this tool is refused if the new file has one. If neither has one, it is kept, unless
    this tool wrote that name before, or, where that is not recorded, wrote another file of the set. ``complete`` is
    False if the robot has other artifacts, too. Raises OutputError.
    """
    known = remembered(folder)
    try:
        present = [folder / name for name in files if known is None and (folder / name).is_file()]
        is_first = known is None and not any(is_generated(path.read_bytes()) for path in present)
    except OSError as problem:
        raise OutputError.of(problem, folder, "read") from None

    def judge(name: str, old: bytes, new: bytes) -> Decision:
        if is_generated(old) or not old.strip():
            return "replace"
        is_unknown = is_first or (known is not None and name not in known)
        return "refuse" if is_generated(new) else "keep" if is_unknown else "replace"

    result = write_set(folder, files, prune, judge)
    remember(folder, files, complete)
    return result


def write_set(
    folder: Path,
    files: Mapping[str, str | bytes],
    prune: bool = False,
    judge: Judge | None = None,
    durable: bool = True,
) -> WriteResult:
    """Make ``files``, text or bytes by relative POSIX name, the set of artifacts in ``folder``.

    If all files are equal already, nothing is touched. Other files in the folder are kept, or removed with ``prune``.
    ``judge`` decides about each file that would be replaced. Without ``durable``, which is for many sets whose contents
    the caller checks, nothing is flushed to the disk, and what killed processes left next to the folder stays. Raises
    OutputError.
    """
    check_names(files)
    contents = {name: encoded(name, files[name]) for name in sorted(files)}
    try:
        real = _resolved(folder)
        real.parent.mkdir(parents=True, exist_ok=True)
        with locked(real.parent, tidy=durable):
            return _update(folder, real, contents, prune, judge, durable)
    except OSError as problem:
        raise OutputError.of(problem, folder, "write") from None


def read_set(folder: Path) -> dict[str, bytes]:
    """Return the bytes of all regular files below ``folder`` by relative POSIX name, sorted; {} if it is missing.

    Waits for a process that is writing the set. Raises OutputError.
    """
    try:
        real = _resolved(folder)
        with suppress(FileNotFoundError), locked(real.parent, shared=True):
            paths = [(n, entry.path) for n, entry in entries_below(real) if entry.is_file(follow_symlinks=False)]
            return {printable(name): Path(path).read_bytes() for name, path in sorted(paths)}
        return {}
    except OSError as problem:
        raise OutputError.of(problem, folder, "read") from None


def _resolved(folder: Path) -> Path:
    """Return the output folder, or the folder to which it links. Raises OutputError for one that cannot be replaced."""
    with suppress(ValueError):  # of a surrogate in the name
        if (
            folder.name not in ("", "..")
            and not STAGING_NAME.fullmatch(folder.name)
            and b"\0" not in os.fsencode(folder)
        ):
            return folder.resolve() if folder.is_symlink() and folder.is_dir() else folder
    message = f'"{folder}" cannot be the output folder'
    raise OutputError("output-folder", message, 'name a folder of its own, such as "outputs/my_robot"')


def check_names(files: Collection[str]) -> None:
    """Raise OutputError for a name that leads out of the folder, or is the folder of another one."""
    for name in sorted(files):
        if not is_inside(name):
            message = f'artifact "{name}" would not stand in the output folder'
            raise OutputError("output-name", message, 'name a file below the folder, such as "urdf/robot.urdf"')
        for parent in (parent for parent in _parents(name) if parent in files):
            message = f'"{parent}" cannot be an artifact and the folder of the artifact "{name}"'
            raise OutputError("output-name", message, "give one of them another name")


def is_inside(name: str) -> bool:
    """Return True for a relative POSIX name of a file below a folder."""
    parts = name.split("/")
    return name.isprintable() and not any(part in ("", ".", "..") or part.casefold() == ".git" for part in parts)


def _parents(name: str) -> list[str]:
    return [parent.as_posix() for parent in Path(name).parents][-2::-1]


def encoded(name: str, text: str | bytes) -> bytes:
    """Return the bytes of an artifact. Raises OutputError for characters that UTF-8 cannot encode."""
    try:
        return text if isinstance(text, bytes) else text.encode("utf-8")
    except UnicodeEncodeError as problem:
        message = f'artifact "{name}" holds the character {problem.object[problem.start]!a}, which UTF-8 cannot write'
        raise OutputError("output-text", message, "remove that character from the description") from None


def _update(
    shown: Path, folder: Path, contents: dict[str, bytes], prune: bool, judge: Judge | None, durable: bool
) -> WriteResult:
    """Compare the set with the folder, and replace the folder if anything differs. Raises OutputError, OSError."""
    status = folder.lstat() if os.path.lexists(folder) else None
    if status and not stat.S_ISDIR(status.st_mode):
        raise OutputError("output-folder", f"the output folder {folder} is not a folder", "name another one")
    folders = {parent for name in contents for parent in _parents(name)}
    seen: Entries = {}
    if status:
        with suppress(OSError), locked(folder, tidy=True):
            pass  # what was left by processes that wrote a single file into the folder
        seen = _entries(folder, status.st_dev, folders.union(contents))
    for name, (path, kind) in ((name, found) for name in contents if (found := obstacle(folder, name))):
        if kind == "a symbolic link" or not prune:
            message = f'artifact "{name}" cannot be written: {path} is {kind}'
            raise OutputError("output-in-the-way", message, "move it away, or give the artifact another name")
    same_size = [n for n, data in contents.items() if n in seen and seen[n].st_size == len(data)]
    unchanged = {n for n in same_size if (folder / n).is_file() and (folder / n).read_bytes() == contents[n]}
    renamed = {}
    for name in (name for name in contents if not prune and name in seen and name not in unchanged):
        decision = judge(name, (folder / name).read_bytes(), contents[name]) if judge else "replace"
        if decision == "refuse":
            message = f"this tool did not write {shown / name}: it is not replaced"
            raise OutputError("output-not-ours", message, "move it away, or give the new file another name or folder")
        if decision == "keep":
            renamed[name] = kept_name(folder / name).relative_to(folder).as_posix()
    folders = {name for name in folders if name in seen and stat.S_ISDIR(seen[name].st_mode)}
    foreign = [name for name in seen if name not in folders and name not in contents]
    foreign_files = tuple(printable(name) for name in foreign if not stat.S_ISDIR(seen[name].st_mode))
    written = tuple(name for name in contents if name not in unchanged)
    if status is None or written or (prune and foreign):
        fresh = {kept: (folder / name).read_bytes() for name, kept in renamed.items()}
        with staging_folder(folder.parent) as stage:
            if status and not os.access(folder, os.W_OK | os.X_OK):
                raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
            if status and status.st_dev != folder.parent.stat().st_dev:
                raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), str(folder))
            if status and Path(os.path.realpath(".")).is_relative_to(folder.resolve()):
                message = f"{folder} is replaced as a whole, and cannot be while the command runs inside it"
                raise OutputError("output-folder", message, "run the command from another folder")
            fresh |= {name: contents[name] for name in written}
            kept_names = folders.union(unchanged, () if prune else foreign)
            replace_folder(folder, stage, fresh, seen, kept_names, durable)
    kept, removed = ((), foreign_files) if prune else (foreign_files, ())
    return WriteResult(written, tuple(sorted(unchanged)), kept, removed, tuple(renamed.items()))


def _entries(folder: Path, device: int, own: Collection[str]) -> Entries:
    """Return all entries of the folder. Raises OutputError if it does not look like an output folder."""
    seen, foreign = {}, 0
    for name, entry in entries_below(folder):
        seen[name] = entry.stat(follow_symlinks=False)
        foreign += name not in own
        if entry.name == ".git" or foreign > MAX_FOREIGN:
            what = "a .git" if entry.name == ".git" else f"more than {MAX_FOREIGN} files that are not artifacts"
            message = f"{folder} holds {what}; the whole output folder is replaced, so it is for artifacts only"
            raise OutputError("output-foreign", message, "name a folder of its own, or move the other files away")
        if entry.is_dir(follow_symlinks=False) and seen[name].st_dev != device:
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), entry.path)
    return dict(sorted(seen.items()))


def obstacle(folder: Path, name: str) -> tuple[Path, str] | None:
    """Return the first path that must be another kind of file for ``name`` to be written, and its kind, or None."""
    kinds = {stat.S_IFREG: "a file", stat.S_IFDIR: "a folder", stat.S_IFLNK: "a symbolic link"}
    for step in (*_parents(name), name):
        if not os.path.lexists(folder / step):
            return None
        kind = kinds.get(stat.S_IFMT((folder / step).lstat().st_mode), "a special file")
        if kind != ("a file" if step == name else "a folder"):
            return folder / step, kind
    return None


def remember(path: Path, files: Collection[str] = (), complete: bool = True) -> None:
    """Store the names of the artifacts in a folder, or that the file ``path`` is an artifact.

    Without ``complete``, ``files`` are added to the names that are stored, if there are any. A failure is silent.
    """
    record, known = _record(path), remembered(path)
    names = set(files) if complete else set(files) | (known or set())
    if record is None or known == names or not (complete or known is not None):
        return
    with suppress(OSError):
        new = record.with_name(f".{os.urandom(8).hex()}")
        new.write_text(json.dumps(sorted(names)), "utf-8")
        new.replace(record)


def remembered(path: Path) -> set[str] | None:
    """Return the names that ``remember`` stored, or None."""
    record = _record(path)
    try:
        names = json_of(record.read_bytes()) if record else None
    except (OSError, ValueError):
        return None
    return {str(name) for name in names} if isinstance(names, list) else None


def _record(path: Path) -> Path | None:
    """Return the file with the names of a folder, or None if there is no cache."""
    if (folder := cache_folder("outputs")) is None:
        return None
    return folder / f"{blake2b(os.fsencode(os.path.abspath(path)), digest_size=32).hexdigest()}.json"

"""Write the artifacts of a robot as a set: even if the process is killed, the folder has either the old or the new set.

A new folder is prepared and swapped with the old folder. Other files are hard-linked into the new folder.
"""

import errno
import os
import stat
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path
from typing import Literal, NamedTuple

from rosorin_compile.source.cache import cache_folder
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.wording import printable

from .atomic_files import STAGING_NAME, OutputError, entries_below, is_generated, kept_name, lock, replace_folder

MAX_FOREIGN = 200  # a folder with more files that are not artifacts is probably not an output folder
Texts = Mapping[str, str | bytes]  # contents of files by relative POSIX name
Decision = Literal["replace", "keep", "refuse"]  # what to do with an existing file that differs; "keep" renames it
Judge = Callable[[str, bytes, bytes], Decision]  # arguments: file name, old contents, new contents


class WriteResult(NamedTuple):
    """The result of writing a set of artifacts, as sorted relative POSIX names.

    ``kept`` are files that are not artifacts, ``renamed`` (old, new) names of files that others may have written.
    """

    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    renamed: tuple[tuple[str, str], ...] = ()

    def diagnostics(self, folder: Path) -> list[Diagnostic]:
        """Return a warning for each file that was renamed, because this tool may not have written it."""
        texts = [f"{folder}/{name} may be of somebody else; it is {kept} now" for name, kept in self.renamed]
        return [Diagnostic("output-kept", WARNING, t, help="remove that file if it is not needed") for t in texts]


def write_artifacts(folder: Path, files: Texts, prune: bool = False) -> WriteResult:
    """Write the artifacts of a robot like ``write_set``, but do not overwrite files that this tool did not write.

    If only the new version of a file has the mark of this tool, raise OutputError. If neither version has it, rename
    the old file, unless this tool wrote it or, in a fresh checkout, another file of the set.
    """
    try:
        present = [path for path in map(folder.joinpath, files) if path.is_file()]
        is_first = not any(is_generated(path.read_bytes()) for path in present)
    except OSError as problem:
        raise OutputError.from_os_error(problem, folder, "read") from None
    is_recorded = any(is_remembered(folder / name) for name in files)

    def judge(name: str, old: bytes, new: bytes) -> Decision:
        if is_generated(old) or not old.strip() or is_remembered(folder / name):
            return "replace"
        return "refuse" if is_generated(new) else "keep" if is_first or is_recorded else "replace"

    result = write_set(folder, files, prune, judge)
    for name, data in files.items():
        if not is_generated(encode(name, data)):
            remember(folder / name)
    return result


def write_set(
    folder: Path, files: Texts, prune: bool = False, judge: Judge | None = None, durable: bool = True
) -> WriteResult:
    """Write ``files``, text or bytes by relative POSIX name, as the set of artifacts in ``folder``.

    If no file changes, nothing is written. Other files in the folder are kept, or removed with ``prune``. ``judge``
    decides about each file that would be replaced. Without ``durable``, for callers that write many sets and verify
    their contents, nothing is flushed to disk, and leftovers of killed processes next to the folder are not removed.
    Raises OutputError.
    """
    check_names(files)
    contents = {name: encode(name, files[name]) for name in sorted(files)}
    try:
        real = _resolved(folder)
        real.parent.mkdir(parents=True, exist_ok=True)
        with lock(real.parent, tidy=durable):
            return _update(folder, real, contents, prune, judge, durable)
    except OSError as problem:
        raise OutputError.from_os_error(problem, folder, "write") from None


def read_set(folder: Path) -> dict[str, bytes]:
    """Return the contents of all files below a folder by relative POSIX name, or {} if the folder does not exist.

    If another process is writing the set, wait until it is complete. Raises OutputError.
    """
    try:
        real = _resolved(folder)
        with suppress(FileNotFoundError), lock(real.parent, shared=True):
            paths = [(n, entry.path) for n, entry in entries_below(real) if entry.is_file(follow_symlinks=False)]
            return {printable(name): Path(path).read_bytes() for name, path in sorted(paths)}
        return {}
    except OSError as problem:
        raise OutputError.from_os_error(problem, folder, "read") from None


def _resolved(folder: Path) -> Path:
    """Return the output folder with links resolved. Raises OutputError if the folder cannot be replaced."""
    with suppress(ValueError):  # a surrogate in the name raises ValueError
        is_named = folder.name not in ("", "..") and not STAGING_NAME.fullmatch(folder.name)
        if is_named and b"\0" not in os.fsencode(folder):
            return folder.resolve() if folder.is_symlink() and folder.is_dir() else folder
    message = f'"{folder}" cannot be the output folder'
    raise OutputError("output-folder", message, 'name a folder of its own, such as "outputs/my_robot"')


def check_names(files: Collection[str]) -> None:
    """Raise OutputError if a name is outside of the folder, or is both a file and the folder of another name."""
    for name in sorted(files):
        if not is_inside(name):
            message = f'artifact "{name}" would not be in the output folder'
            raise OutputError("output-name", message, 'name a file below the folder, such as "urdf/robot.urdf"')
        for parent in (parent for parent in _parents(name) if parent in files):
            message = f'"{parent}" cannot be an artifact and the folder of the artifact "{name}"'
            raise OutputError("output-name", message, "give one of them another name")


def is_inside(name: str) -> bool:
    """Return True if a relative POSIX name stays inside its folder."""
    parts = name.split("/")
    return name.isprintable() and not any(part in ("", ".", "..") or part.casefold() == ".git" for part in parts)


def _parents(name: str) -> list[str]:
    return [parent.as_posix() for parent in Path(name).parents][-2::-1]


def encode(name: str, text: str | bytes) -> bytes:
    """Return the bytes of an artifact. Raises OutputError for characters that UTF-8 cannot encode."""
    try:
        return text if isinstance(text, bytes) else text.encode("utf-8")
    except UnicodeEncodeError as problem:
        message = f'artifact "{name}" holds the character {problem.object[problem.start]!a}, which UTF-8 cannot write'
        raise OutputError("output-text", message, "remove that character from the description") from None


def _update(
    shown: Path, folder: Path, contents: dict[str, bytes], prune: bool, judge: Judge | None, durable: bool
) -> WriteResult:
    """Replace the folder if a file in ``contents`` is new or changed. Raises OutputError, OSError."""
    exists = os.path.lexists(folder)
    if exists and (folder.is_symlink() or not folder.is_dir()):
        raise OutputError("output-folder", f"the output folder {folder} is not a folder", "name another one")
    parents = {parent for name in contents for parent in _parents(name)}
    present = _entries(folder, parents.union(contents)) if exists else {}
    for name, (path, kind) in ((name, found) for name in contents if (found := obstacle(folder, name))):
        if kind == "a symbolic link" or not prune:
            message = f'artifact "{name}" cannot be written: {path} is {kind}'
            raise OutputError("output-in-the-way", message, "move it away, or give the artifact another name")
    old = {name: (folder / name).read_bytes() for name in contents if (folder / name).is_file()}
    unchanged = {name for name in old if old[name] == contents[name]}
    fresh = {name: data for name, data in contents.items() if name not in unchanged}
    written, renamed = tuple(fresh), {}
    for name in (name for name in written if name in old and not prune):
        decision = judge(name, old[name], contents[name]) if judge is not None else "replace"
        if decision == "refuse":
            message = f"this tool did not write {shown / name}: it is not replaced"
            raise OutputError("output-not-ours", message, "move it away, or give the new file another name or folder")
        if decision == "keep":
            renamed[name] = kept_name(folder / name).relative_to(folder).as_posix()
            fresh[renamed[name]] = old[name]
    foreign = [name for name, is_folder in present.items() if name not in (parents if is_folder else contents)]
    if not exists or written or (prune and foreign):
        dropped = {name for name in present if name in fresh or (prune and name in foreign)}
        carried = {name: is_folder for name, is_folder in present.items() if name not in dropped}
        replace_folder(folder, fresh, carried, sorted(dropped - fresh.keys()), durable)
    others = tuple(printable(name) for name in foreign if not present[name])
    kept, removed = ((), others) if prune else (others, ())
    return WriteResult(written, tuple(sorted(unchanged)), kept, removed, tuple(renamed.items()))


def _entries(folder: Path, own: Collection[str]) -> dict[str, bool]:
    """Map the relative POSIX name of each entry in the folder to True if the entry is a folder.

    Raises OutputError if this is probably not an output folder, and OSError if another file system is mounted in it.
    """
    with suppress(OSError), lock(folder, tidy=True):
        pass  # locking with ``tidy`` removes leftovers of killed processes
    present, foreign, device = {}, 0, folder.stat().st_dev
    for name, entry in entries_below(folder):
        present[name] = entry.is_dir(follow_symlinks=False)
        foreign += name not in own
        if entry.name == ".git" or foreign > MAX_FOREIGN:
            what = "a .git" if entry.name == ".git" else f"more than {MAX_FOREIGN} files that are not artifacts"
            message = f"{folder} holds {what}; the whole output folder is replaced, so it is for artifacts only"
            raise OutputError("output-foreign", message, "name a folder of its own, or move the other files away")
        if present[name] and entry.stat(follow_symlinks=False).st_dev != device:
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), entry.path)
    return dict(sorted(present.items()))


def obstacle(folder: Path, name: str) -> tuple[Path, str] | None:
    """Return (path, kind of file) for the first path that prevents writing the file ``name``, or None."""
    kinds = {stat.S_IFREG: "a file", stat.S_IFDIR: "a folder", stat.S_IFLNK: "a symbolic link"}
    for step in (*_parents(name), name):
        if not os.path.lexists(folder / step):
            return None
        kind = kinds.get(stat.S_IFMT((folder / step).lstat().st_mode), "a special file")
        if kind != ("a file" if step == name else "a folder"):
            return folder / step, kind
    return None


def remember(path: Path) -> None:
    """Record that this tool wrote a file, for files that cannot have its mark. Failures are ignored."""
    with suppress(OSError):
        if (record := _record(path)) and not record.exists():
            record.touch()


def is_remembered(path: Path) -> bool:
    """Return True if ``remember`` recorded the file."""
    return (record := _record(path)) is not None and record.exists()


def _record(path: Path) -> Path | None:
    folder = cache_folder("outputs")
    return folder and folder / blake2b(os.fsencode(os.path.abspath(path)), digest_size=32).hexdigest()

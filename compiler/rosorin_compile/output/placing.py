"""Placing files into a folder that holds other things, too: all of the set or nothing of it.

The new files are prepared in a folder inside the folder; renaming that to READY is the moment at which the set counts.
Then each file is moved to its place. A run that is killed before that moment has changed nothing; what one leaves that
is killed after it, the next run finishes, and says so: where a file is still what was to be replaced. What somebody has
changed since stays. What stands under that name and is no set that was made there is put aside, or removed if it is the
rest of one. Nothing is written through a symbolic link. A folder that is not there yet is made as a whole.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import stat
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.source import system
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import PACKAGES, Rule
from rosorin_compile.source.wording import listed

from . import OutputError, Written, cleared, ours
from .one_file import replace_text
from .ours import ProtectedFile, digest, kept_name
from .staging import STAGE, discard, replace, staged, tidy

RULES = (
    Rule("deploy-outside", "A place is not below the folder.", "Name a file below it.", PACKAGES),
    Rule(
        "deploy-link",
        "A symbolic link stands where a file goes, or on the way there.",
        "Name the folder that it leads to, or remove it.",
        PACKAGES,
    ),
    Rule(
        "deploy-in-the-way",
        "A folder stands where a file goes, or a file where a folder goes.",
        "Move it away, or choose another place.",
        PACKAGES,
    ),
    Rule(
        "deploy-finished",
        "A warning: a run before was ended while it put files into their places. The others are put there now, but for "
        "those that were changed since.",
        "Deploy the robot again that the files are of.",
        PACKAGES,
    ),
    Rule("deploy-failed", "Writing failed; the folder is as before.", "The message says why.", PACKAGES),
)

READY = ".rosorin-compile-ready"
_LIST = "list.json"
_OURS = re.compile(r"(old-)?\d+|list\.json")  # the names in the folder of a run
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK)


class Finished(NamedTuple):
    """What came of the set of a killed run, by name: put into place now, and left since somebody changed it.

    ``before`` are the digests of those that the killed run has put into place itself.
    """

    put: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    before: Mapping[str, str] = {}

    def diagnostics(self, dry: bool = False) -> list[Diagnostic]:
        """Return what there is to say; ``dry`` says that nothing was put."""
        begun = "a run before was ended while it put files into their places"
        found = []
        put = [name for name in self.put if not name.startswith(".")]
        if put:
            are = "would be" if dry else "is" if len(put) == 1 else "are"
            found.append((f"{begun}: {listed(put)} {are} put there now, too", "to undo that, deploy their robot again"))
        for name in self.left:
            found.append((f"{begun}; {name} was changed since, and stays as it is", "deploy its robot again"))
        return [Diagnostic("deploy-finished", WARNING, message, None, (), help) for message, help in found]


class Entry(NamedTuple):
    """A file of a set: its name, the digest of what it replaces (None: there is nothing), and its own."""

    name: str
    old: str | None
    new: str


class Holding(NamedTuple):
    """A folder into which nobody else places anything now; ``is_new``: it is not there yet.

    ``finished`` is what came of the set of a killed run, or would come.
    """

    root: Path
    is_new: bool
    finished: Finished

    @property
    def record(self) -> str:
        """The name of the file in which it stands what was written into the folder."""
        return ours.RECORD

    def recorded(self) -> dict[str, str]:
        """Return the digests of what was written into the folder, by name; none if nobody noted that."""
        return ours.recorded(self.root)

    def with_record(self, files: Mapping[str, bytes]) -> dict[str, bytes]:
        """Return ``files`` with the note on what was written into the folder, themselves among it."""
        return {**files, ours.RECORD: ours.record_of(self.root, files)}

    def protected(
        self, files: Mapping[str, bytes], record: Mapping[str, str], *, own: bool = False
    ) -> list[ProtectedFile]:
        """Return what stands at the names of ``files`` and is not replaced in silence, as ``ours.protected_files``."""
        return list(ours.protected_files(self.root, files, record, own=own))

    @staticmethod
    def digest(data: bytes) -> str:
        """Return by what a file is known in the note: its SHA-256."""
        return digest(data)

    @staticmethod
    def is_marked(data: bytes) -> bool:
        """Say whether a file says that this tool has generated it."""
        return ours.is_marked(data)

    @staticmethod
    def wrote(path: Path) -> bool:
        """Say whether a file says that this tool wrote it, or has nothing that could be lost. Raises OSError."""
        return ours.wrote(path)

    @staticmethod
    def write_set(
        folder: Path,
        files: Mapping[str, str | bytes],
        replaces: Callable[[str, bytes], bool],
        *,
        refuse: bool = False,
        tidied: bool = False,
    ) -> Written:
        """Make ``files``, by relative POSIX name, the set in a folder: after a kill it holds the old or the new set.

        ``replaces`` says of a file, by its name and its bytes, whether it is replaced; others are put aside, or with
        ``refuse`` nothing is written. With ``tidied``, the caller has removed what killed runs left in the
        parent folder. Raises OutputError.
        """
        from . import write_set

        def judge(name: str, old: bytes, _: bytes) -> str:
            return "" if replaces(name, old) else ours.FOREIGN if refuse else ours.UNKNOWN

        return write_set(folder, files, judge=judge, tidied=tidied)

    @staticmethod
    def write_text(path: Path, text: str, rule: str) -> None:
        """Put a new text into a file: after a kill at any moment it holds the old or the new one.

        A link stays a link, and permissions stay as they are. Raises OutputError, whose diagnostic is of ``rule``.
        """
        replace_text(path, text, rule)

    def check_way(self, name: str) -> None:
        """Raise OutputError for a name that is not below the folder, or to which a link leads."""
        check_way(self.root, name)

    def place(self, files: Mapping[str, bytes]) -> tuple[str, ...]:
        """Write ``files``, bytes by relative POSIX name; other files in the folder stay as they are.

        Returns the names of those that are new or changed. Raises OutputError, and then the folder is as before.
        """
        try:
            for name in files:
                check_way(self.root, name)
            if self.is_new:
                replace(self.root, files, {}, {})
                return tuple(sorted(files))
            entries = [Entry(name, _digest(self.root / name), digest(files[name])) for name in files]
            # What is new comes first: there are the copies of what is replaced.
            fresh = sorted((one for one in entries if one.old != one.new), key=lambda one: (one.old is not None, one))
            if fresh:
                _place(self.root, fresh, files)
            return tuple(sorted(one.name for one in fresh))
        except OSError as problem:
            raise _explained(problem, self.root) from None


@contextmanager
def holding(folder: Path, dry: bool = False) -> Iterator[Holding]:
    """Lock a folder against other runs that place files there, and finish what a killed one has begun.

    With ``dry`` nothing is locked or changed. Raises OutputError.
    """
    root = folder.resolve()
    with ExitStack() as held:
        try:
            if not dry and not root.is_dir():
                root.parent.mkdir(parents=True, exist_ok=True)
                held.enter_context(cleared(root.parent))
            is_new = not root.is_dir()
            if not dry and not is_new:
                held.enter_context(cleared(root))
                with suppress(OSError):
                    tidy(root.parent)  # a run was killed that had just made the folder
            finished = Finished() if is_new else _finish(root, dry)
        except OSError as problem:
            raise _explained(problem, folder) from None
        yield Holding(root, is_new, finished)


def place(folder: Path, files: Mapping[str, bytes]) -> tuple[str, ...]:
    """Write ``files`` into a folder, as ``Holding.place``. Raises OutputError."""
    with holding(folder) as held:
        return held.place(files)


def check_way(root: Path, name: str) -> None:
    """Raise OutputError if ``name`` leads out of ``root``, through a link, or to what is no file. Raises OSError."""
    parts = name.split("/")
    if not name.isprintable() or any(part in ("", ".", "..") or part.casefold() == ".git" for part in parts):
        raise OutputError("deploy-outside", f'"{name}" does not stand in the folder', "name a file below the folder")
    path = root
    for part in parts:
        path = path / part
        try:
            mode = path.lstat().st_mode
        except FileNotFoundError:
            return
        last = path == root.joinpath(*parts)
        if stat.S_ISLNK(mode):
            message = f"{path} is a symbolic link to {os.readlink(path)}; nothing is written through links"  # noqa: PTH115
            raise OutputError("deploy-link", message, "name the folder that it leads to, or remove the link")
        if stat.S_ISREG(mode) if last else stat.S_ISDIR(mode):
            continue
        wanted = "a file" if last else "a folder"
        raise OutputError("deploy-in-the-way", f"{path} is not {wanted}", "move it away, or choose another place")


def _digest(path: Path) -> str | None:
    """Return what tells the content of a file; None if there is no file. Raises OSError."""
    try:
        return digest(path.read_bytes())
    except FileNotFoundError:
        return None


def _place(root: Path, entries: Sequence[Entry], files: Mapping[str, bytes]) -> None:
    """Bring new files to the disk, let them count, and move them to their places. Raises OSError, OutputError."""
    for entry in entries:
        _check_writable(root, entry.name)
    ready = root / READY
    with staged(root) as stage:
        for number, entry in enumerate(entries):
            target = root / entry.name
            _write(stage / str(number), files[entry.name], target)
            if entry.old is not None:
                _keep(target, stage / f"old-{number}")
        told = {"folder": stage.stat().st_ino, "files": entries}
        _write(stage / _LIST, json.dumps(told).encode(), None)
        stage.rename(ready)
        try:
            _move_all(root, entries)
        finally:
            _retire(ready, stage)


def _check_writable(root: Path, name: str) -> None:
    place = (root / name).parent
    while not place.is_dir():
        place = place.parent
    if not os.access(place, os.W_OK | os.X_OK):
        raise OSError(errno.EACCES, os.strerror(errno.EACCES), str(place))


def _write(path: Path, data: bytes, model: Path | None) -> None:
    """Write a new file with the permissions of the one that it replaces."""
    with path.open("xb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    if model is not None and model.is_file():
        path.chmod(stat.S_IMODE(model.stat().st_mode))


def _keep(target: Path, old: Path) -> None:
    """Let a file stand under a second name: the same file where links can be made, else a copy. Raises OSError."""
    try:
        system.link(target, old)
    except OSError as problem:
        if problem.errno not in _NO_LINKS:
            raise
        shutil.copy2(target, old)


def _move_all(root: Path, entries: Sequence[Entry]) -> None:
    """Move the files of a set to their places; if that fails, put back what was there. Raises OSError, OutputError."""
    for entry in entries:
        if _digest(root / entry.name) != entry.old:
            message = f"{root / entry.name} was changed just now: nothing is written"
            raise OutputError("deploy-failed", message, "run the command again")
    with ExitStack() as undo:
        for entry in entries:
            for folder in _make_folders(root, root / entry.name):
                undo.callback(_try, folder.rmdir)
        for number, entry in enumerate(entries):
            target, old = root / entry.name, root / READY / f"old-{number}"
            undo.callback(_try, target.unlink if entry.old is None else partial(old.replace, target))
            (root / READY / str(number)).replace(target)
        undo.pop_all()


def _try(step: Callable[[], object]) -> None:
    with suppress(OSError):
        step()


def _make_folders(root: Path, target: Path) -> Iterator[Path]:
    """Make the folders that a file needs, and yield each."""
    for parent in reversed(target.relative_to(root).parents):
        if not (root / parent).is_dir():
            (root / parent).mkdir()
            yield root / parent


def _finish(root: Path, dry: bool) -> Finished:
    """Move what is left of the set of a killed run to its places, unless somebody changed what stands there.

    Raises OSError.
    """
    ready = root / READY
    entries = _listed(ready)
    if entries is None:
        if not dry:
            _clear(ready)
        return Finished()
    put, left, before = [], [], {}
    for number, entry in enumerate(entries):
        new, target = ready / str(number), root / entry.name
        if not new.is_file():
            before[entry.name] = entry.new
            continue
        if not _is_free(root, entry):
            left.append(entry.name)
            continue
        put.append(entry.name)
        if not dry:
            for _ in _make_folders(root, target):
                pass
            new.replace(target)
    if not dry:
        stage = root / (STAGE + os.urandom(8).hex())
        _retire(ready, stage)
        discard(stage)
    return Finished(tuple(put), tuple(left), before)


def _retire(ready: Path, stage: Path) -> None:
    """Let a set count no more, in one step: half removed, it would have lost its list."""
    try:
        ready.rename(stage)
    except OSError:
        with suppress(OSError):
            (ready / _LIST).unlink()
        shutil.rmtree(ready, ignore_errors=True)  # what stays of it, the next run clears away


def _is_free(root: Path, entry: Entry) -> bool:
    """Say whether a file of a killed run may go to its place: nobody has changed what is there. Raises OSError."""
    try:
        check_way(root, entry.name)
    except OutputError:
        return False
    return _digest(root / entry.name) in (None, entry.old, entry.new)


def _listed(ready: Path) -> Sequence[Entry] | None:
    """Return the files of a set that counts; None if there is none, or it was not made here.

    It knows the number of its folder on this disk, which no copy has, and no folder that came with a repository.
    """
    try:
        status = ready.lstat()
        if not stat.S_ISDIR(status.st_mode) or not system.is_own(status):
            return None
        told = json_of((ready / _LIST).read_bytes())
        if not isinstance(told, dict) or told.get("folder") != status.st_ino:
            return None
        return [Entry(str(name), old, str(new)) for name, old, new in told["files"]]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _clear(folder: Path) -> None:
    """Remove the rest of a run; what no run has made is put aside, under a name beside it. Raises OSError."""
    if not os.path.lexists(folder):
        return
    if folder.is_dir() and not folder.is_symlink():
        folder.chmod(0o700)
        if all(_OURS.fullmatch(path.name) and not path.is_dir() for path in folder.iterdir()):
            shutil.rmtree(folder)
            return
    folder.rename(kept_name(folder))


def _explained(problem: OSError, folder: Path) -> OutputError:
    """Return the error for a user: what cannot be done, why, and the way out."""
    place = problem.filename if isinstance(problem.filename, str) else str(folder)
    place = str(folder) if STAGE in place else place
    message = f"cannot write into {folder}: {problem.strerror or type(problem).__name__} ({place})"
    return OutputError("deploy-failed", message, "give yourself the right to write there, or name another folder")

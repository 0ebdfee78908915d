"""Placing files into a folder that holds other things, too: all of the set or nothing of it.

The new files are prepared in a folder inside the folder; renaming that to READY is the moment at which the set counts.
Then each file is moved to its place. A run that is killed before that moment has changed nothing; what one leaves that
is killed after it, the next run finishes. What stands under those names and is no set of ours is put aside, or removed
if it is the rest of one. Nothing is written through a symbolic link.
"""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ...diagnostics.bounded import json_of
from ...diagnostics.registry import PACKAGES, Rule
from ...output import OutputError
from ...output.ours import kept_name

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
    Rule("deploy-failed", "Writing failed; the folder is as before.", "The message says why.", PACKAGES),
)

STAGE = ".rosorin-compile-stage"
READY = ".rosorin-compile-ready"
_LIST = "list.json"
_OURS = re.compile(r"(old-)?\d+|list\.json")  # the names in the folder of a run
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK)


def place(folder: Path, files: Mapping[str, bytes]) -> tuple[str, ...]:
    """Write ``files``, bytes by relative POSIX name, into ``folder``; other files there stay as they are.

    Returns the names of those that are new or changed. Raises OutputError, and then the folder is as before.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        root = folder.resolve()
        with _locked(root):
            _finish(root)
            for name in files:
                check_way(root, name)
            fresh = [name for name in sorted(files) if not _holds(root / name, files[name])]
            if not fresh:
                _clear(root / STAGE)  # a run was killed while it cleared up
            else:
                _prepare(root, {name: files[name] for name in fresh})
                _finish(root)
            return tuple(fresh)
    except OSError as problem:
        raise _explained(problem, folder) from None


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


@contextmanager
def _locked(root: Path) -> Iterator[None]:
    import fcntl

    handle = os.open(root, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with suppress(OSError):  # some network drives have no locks
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def _holds(path: Path, data: bytes) -> bool:
    try:
        return path.stat().st_size == len(data) and path.read_bytes() == data
    except FileNotFoundError:
        return False


def _prepare(root: Path, files: Mapping[str, bytes]) -> None:
    """Bring the new files to the disk, and then let them count. Raises OSError."""
    for name in files:
        _check_writable(root, name)
    stage = root / STAGE
    _clear(stage)
    stage.mkdir(mode=0o700)
    try:
        for number, (name, data) in enumerate(files.items()):
            _write(stage / str(number), data, root / name)
        _write(stage / _LIST, json.dumps(list(files)).encode(), None)
        stage.rename(root / READY)
    except BaseException:
        _clear(stage)
        raise


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


def _finish(root: Path) -> None:
    """Move the files of a set that counts to their places; if that fails, put back what was there. Raises OSError."""
    ready = root / READY
    names = _listed(root)
    if names is None:
        _clear(ready)
        return
    undo: list[tuple[Path, Path | None]] = []
    try:
        for number, name in enumerate(names):
            new, target, old = ready / str(number), root / name, ready / f"old-{number}"
            if new.exists():
                _make_folders(root, target, undo)
                _move(new, target, old, undo)
    except BaseException:
        _put_back(undo)
        _discard(root)
        raise
    _discard(root)


def _listed(root: Path) -> Sequence[str] | None:
    """Return the names of a set that counts; None if there is none, or what is there is no set that could be finished.

    Its list is missing or damaged, or since then something stands in the way of a file: the run at hand will say so.
    """
    ready = root / READY
    if not ready.is_dir() or ready.is_symlink():
        return None
    try:
        names = json_of((ready / _LIST).read_bytes())
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            return None
        for name in names:
            check_way(root, name)
    except (OSError, ValueError, OutputError):
        return None
    return names


def _make_folders(root: Path, target: Path, undo: list[tuple[Path, Path | None]]) -> None:
    for parent in reversed(target.relative_to(root).parents):
        if not (root / parent).is_dir():
            (root / parent).mkdir()
            undo.append((root / parent, None))


def _move(new: Path, target: Path, old: Path, undo: list[tuple[Path, Path | None]]) -> None:
    """Replace ``target`` in one step, the old file kept under another name until all is done."""
    if target.exists():
        _keep(target, old)
        undo.append((target, old))
    else:
        undo.append((target, None))
    new.replace(target)


def _keep(target: Path, old: Path) -> None:
    """Let a file stand under a second name: the same file where links can be made, else a copy. Raises OSError."""
    try:
        os.link(target, old)
    except FileExistsError:
        return  # a run was killed between the two steps
    except OSError as problem:
        if problem.errno not in _NO_LINKS:
            raise
        shutil.copy2(target, old)


def _put_back(undo: Sequence[tuple[Path, Path | None]]) -> None:
    for target, old in reversed(undo):
        with suppress(FileNotFoundError):
            if old is not None:
                old.replace(target)
            elif target.is_dir():
                target.rmdir()
            else:
                target.unlink()


def _discard(root: Path) -> None:
    """Remove what is left of a set. In one step it counts no more: half removed, it would have lost its list."""
    try:
        _clear(root / STAGE)
        (root / READY).rename(root / STAGE)
        _clear(root / STAGE)
    except OSError:
        shutil.rmtree(root / READY, ignore_errors=True)  # what stays of it, the next run clears away


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
    place = str(folder) if STAGE in place or READY in place else place
    message = f"cannot write into {folder}: {problem.strerror or type(problem).__name__} ({place})"
    return OutputError("deploy-failed", message, "give yourself the right to write there, or name another folder")

"""The project: where descriptions and outputs stand on disk.

The data that ships with the tool, the user's cache and paths as people read them stand here too.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

ROOT_FILE = "robot.yaml"
ENDINGS = (".yaml", ".yml")
DESCRIPTIONS = "descriptions"
OUTPUTS = "outputs"


class Description(NamedTuple):
    """A description that was asked for: its name, its first file, and the folder of its artifacts."""

    name: str
    path: Path
    outputs: Path


class NoDescription(Exception):
    """There is no description of that name; the message says what there is."""


def find(names: list[str], outputs: str | None) -> list[Description]:
    """Return the descriptions asked for by name, folder or file; without names all in ``descriptions/``.

    The project is that of this folder or of one above it. ``outputs`` is the folder that gets a folder a robot; by
    default ``outputs`` beside ``descriptions``.
    Raises NoDescription.
    """
    paths = [first_file(name) for name in names] or all_here()
    if not paths:
        where = f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here or above"
        raise NoDescription(f"{where}; name a description, or go to its project")
    return [_description(path, outputs) for path in paths]


def all_here() -> list[Path]:
    """Return the first files of all descriptions of the project around this folder, sorted by name."""
    return all_in(around())


def all_in(project: Path) -> list[Path]:
    """Return the first files of all descriptions of a project, sorted by name."""
    return sorted(Path(project, DESCRIPTIONS).glob(f"*/{ROOT_FILE}"))


def all_with(files: Iterable[str]) -> list[Path]:
    """Return the first files of all descriptions of the projects that some files are in, project by project.

    The project of a file is that of its folder, or of the nearest one above it.
    """
    known: dict[Path, list[Path]] = {}
    found: dict[Path, None] = {}
    for file in files:
        for folder in Path(file).parents:
            if known.setdefault(folder, all_in(folder)):
                found |= dict.fromkeys(known[folder])
                break
        else:
            found |= dict.fromkeys(all_here())
    return sorted(found)


def around() -> Path:
    """Return the folder of the project that this folder is in, as seen from here; this folder if there is none.

    A folder above that everybody can write into, such as /tmp, is nobody's project.
    """
    above = Path()
    try:
        here = Path.cwd()
        for folder in (here, *here.parents):
            if folder != here and folder.stat().st_mode & stat.S_IWOTH:
                break
            if any(Path(above, DESCRIPTIONS).glob(f"*/{ROOT_FILE}")):
                return above
            above = above / os.pardir
    except OSError:  # the folder of this process is gone, or one above may not be read
        pass
    return Path()


def narrowed(found: list[Description]) -> list[Description]:
    """Return of several descriptions the one whose folder this folder is in, if it is in one."""
    here = Path.cwd()
    within = [one for one in found if here.is_relative_to(one.path.parent.resolve())]
    return within if len(within) == 1 else found


def project_of(path: Path) -> Path:
    """Return the folder of the project that a description is in, links followed; without one its own folder."""
    folder = path.parent.resolve()
    return next((one.parent for one in (folder, *folder.parents) if one.name == DESCRIPTIONS), folder)


def first_file(name: str) -> Path:
    """Return the first file of a description given as a file, a folder or a name. Raises NoDescription."""
    for path in (Path(name), Path(DESCRIPTIONS, name), Path(around(), DESCRIPTIONS, name)):
        if is_file(path / ROOT_FILE):
            return path / ROOT_FILE
    if is_file(Path(name)):
        return Path(name)
    known = [path.parent.name for path in all_here()]
    from .diagnostics import did_you_mean

    help = did_you_mean(name, known) or f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here"
    raise NoDescription(f'no description "{name}": it is no file, no folder with {ROOT_FILE}, no name; {help}')


def is_file(path: Path) -> bool:
    """Say whether there is a file; there is none of a name that no file can have."""
    return os.path.isfile(path)  # noqa: PTH113 - Path.is_file raises for such a name


def _description(path: Path, outputs: str | None) -> Description:
    folder = Path(os.path.abspath(path)).parent
    name = folder.name if path.name == ROOT_FILE else path.stem
    if outputs is not None:
        base = Path(outputs)
    elif folder.parent.name == DESCRIPTIONS:
        base = _from_here(folder.parent.parent / OUTPUTS, absolute=path.is_absolute())
    else:
        base = Path(OUTPUTS)
    return Description(name, path, base / name)


def _from_here(path: Path, absolute: bool) -> Path:
    """Return an absolute path relative to here, as a person would name it; not if it is above, and ``absolute``."""
    here = os.path.relpath(path)
    return path if absolute and here.startswith("..") else Path(here)


def nearest_file(path: Path) -> Path | None:
    """Return the file of the same folder that is called nearly so, whatever its ending; None if none is."""
    from .diagnostics import nearest

    try:
        # Files of one kind end alike: that is no likeness.
        stems = {file.stem: file for file in sorted(path.parent.iterdir()) if file.is_file()}
    except (OSError, ValueError):  # no folder, or a name that no file can have
        return None
    close = nearest(path.stem, stems)
    return None if close is None else stems[close]


def shown(path: Path) -> str:
    """Return a path as a person would name it: relative to here if it is below."""
    try:
        here = os.path.relpath(path)
    except OSError:  # the folder of this process is gone
        return str(path)
    return str(path) if here.startswith("..") and path.is_absolute() else here


class Resolved(NamedTuple):
    """Where a name led that was looked for: a ROS package as seen ``by`` a file, a package of Python, a mesh file.

    ``answer`` is an absolute path, empty if there was none. On another day, or in another environment, the same name
    may lead elsewhere. The name of a mesh file is where it was looked for.
    """

    kind: str
    name: str
    by: str
    answer: str


ROS_PACKAGE, PYTHON_PACKAGE, MESH_FILE = "ROS package", "Python package", "mesh file"


def resolved(kind: str, name: str, by: Path | str, answer: Path | None) -> Resolved:
    """Return where a name led, with absolute paths."""
    return Resolved(kind, name, os.path.abspath(by) if by else "", "" if answer is None else os.path.abspath(answer))


def python_folder(package: str) -> Path | None:
    """Return the folder of an installed package of Python, without importing it."""
    from importlib.util import find_spec

    try:
        spec = find_spec(package) if package.isidentifier() else None
    except (ImportError, ValueError):
        return None
    places = list(spec.submodule_search_locations or ()) if spec else []
    return Path(places[0]) if places else None


# The data packages, each a folder of the same name at the top of the project (parts_library is ``parts``).
DATA = ("parts_library", "schemas", "templates", "viewer")


def data_folder(name: str) -> Path:
    """Return the folder of a data package: "templates", "schemas" or "parts_library"."""
    return Path(import_module(f".{name}", __package__).__path__[0])


_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of cached files, which only the user can change; None if there is no such place.

    ``ROSORIN_COMPILE_CACHE`` names another place; ``off`` turns caching off. Otherwise the XDG base directory
    specification holds. What is cached is run (templates) and believed (stamps): a folder that anybody else but root
    could change, or put another one in the place of, is none; ``cache_refused`` says so.
    """
    top = _cache_top()
    if top is None:
        return None
    folder = top / name
    try:
        for place in (*reversed(folder.parents), folder):
            if not os.path.lexists(place):
                with suppress(FileExistsError):  # another run was quicker
                    place.mkdir(mode=0o700)
        open_to, way_out = _open_to_others(folder)
    except (OSError, ValueError):
        return None
    if open_to:
        _refused.append((f"{open_to}: nothing is kept in the cache {top}", way_out))
        return None
    return Path(os.path.realpath(folder)) if os.access(folder, os.W_OK) else None


def cache_refused() -> tuple[str, str] | None:
    """Return why there is no cache though there could be one, and the way out; once."""
    first = _refused[0] if _refused else None
    _refused.clear()
    return first


def _cache_top() -> Path | None:
    """Return the folder of the cache, absolute; None if there is to be none, or no place for one."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen:
        return None if chosen == "off" else Path(os.path.abspath(chosen))
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):  # noqa: PTH117 - an empty one is none, and a relative one does not count by XDG
        # It stays as it is for a user without a home; an empty HOME would be the root of the disk.
        base = os.path.expanduser("~/.cache") if os.environ.get("HOME", "~") else ""
    return Path(base, "rosorin-compile") if os.path.isabs(base) else None  # noqa: PTH117


def _open_to_others(folder: Path) -> tuple[str, str]:
    """Return who else could change what is in a folder of the cache, and the way out; empty if only root can.

    In a folder above others may write if it is sticky, as /tmp is: what stands there is its owner's. Raises OSError.
    """
    for place in _way(folder, 40):
        status = place.lstat()
        open_mode = not stat.S_ISLNK(status.st_mode) and status.st_mode & 0o022 and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (0, os.geteuid()) or open_mode:
            return _told(place, not open_mode)
    for place in (folder.parent, folder):
        status = place.stat()
        if status.st_uid != os.geteuid() or status.st_mode & 0o022:
            return _told(place, status.st_uid != os.geteuid())
    return "", ""


def _told(place: Path, foreign: bool) -> tuple[str, str]:
    if foreign:
        return f"{shown(place)} belongs to another user", _ELSEWHERE
    return f"{shown(place)} can be written by others", f"chmod go-w {shown(place)}; or {_ELSEWHERE}"


def _way(path: Path, links: int) -> Iterator[Path]:
    """Yield each folder on the way to an absolute path, and of each link that it leads through too. Raises OSError."""
    for place in (*reversed(path.parents), path):
        yield place
        if place.is_symlink():
            if not links:
                raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(place))
            target = os.path.join(place.parent, os.readlink(place))  # noqa: PTH115
            yield from _way(Path(os.path.abspath(target)), links - 1)


def recalled(file: Path) -> bytes | None:
    """Return what was kept in a file of the cache; None if there is none, or it is damaged in whatever way."""
    import hashlib

    try:
        handle = os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, "rb") as opened:
            status = os.fstat(handle)
            if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid() or status.st_mode & 0o022:
                return None
            digest, _, data = opened.read().partition(b"\n")
    except OSError:
        return None
    return data if hashlib.sha256(data).hexdigest().encode() == digest else None


def keep(file: Path, data: bytes) -> None:
    """Keep something in a file of the cache, for the user alone. A failure is silent: the next run does without."""
    import hashlib

    new = file.with_name(f".{os.urandom(8).hex()}")
    with suppress(OSError):
        _forget_some(file.parent)
        try:
            handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
            with os.fdopen(handle, "wb") as opened:
                opened.write(hashlib.sha256(data).hexdigest().encode() + b"\n" + data)
            new.replace(file)
        finally:
            new.unlink(missing_ok=True)


MAX_KEPT = 400  # files of a folder of the cache; when there are more, the older half goes


def _forget_some(folder: Path) -> None:
    """Remove the older half of the files when there are many, with what killed runs left between them."""
    with os.scandir(folder) as entries:
        kept = sorted((entry.stat(follow_symlinks=False).st_mtime_ns, entry.name) for entry in entries)
    if len(kept) > MAX_KEPT:
        for _, name in kept[: len(kept) // 2]:
            with suppress(OSError):
                (folder / name).unlink()

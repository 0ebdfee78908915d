"""Locate descriptions, their output folders, and the data files of the tool."""

import os
import re
import stat
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import ClassVar, NamedTuple

from . import files
from .diagnostics import UnknownName
from .system import package_folders
from .wording import nearest

ROOT_FILE = "robot.yaml"
ENDINGS = (".yaml", ".yml")
DESCRIPTIONS = "descriptions"
_on_stdin: list[bytes] = []


class NoDescription(Exception):
    """No description has the requested name; the message lists the descriptions that exist."""


@dataclass(frozen=True)
class Description:
    """A description: its name, its main file, and the folder of its artifacts."""

    name: str
    path: Path
    outputs: Path

    STDIN: ClassVar[str] = "-"  # the name of a description on standard input
    ON_STDIN: ClassVar[Path] = Path("<stdin>")  # path of "-" in messages; includes are relative to the current folder
    ENDINGS, ROOT_FILE, FOLDER, OUTPUTS = ENDINGS, ROOT_FILE, DESCRIPTIONS, "outputs"
    SCHEMA: ClassVar[Path] = Path(".schema", "rosorin-compile.schema.json")  # relative to the folder descriptions/

    @classmethod
    def find(cls, names: list[str], outputs: str | None = None) -> "list[Description]":
        """Return the descriptions of the names, folders or files; without any, all here. Raises NoDescription."""
        if paths := [first_file(name) for name in names] or all_here():
            return [cls.from_path(path, outputs) for path in paths]
        why = (
            "; name a description, or go to its project; rosorin-compile init NAME creates one, rosorin-compile import "
        )
        why += "FILE converts a URDF, xacro, SDF, MJCF"
        problems = (f": {'; '.join(problem)}" for folder in _upwards() for problem in without_first_file(folder))
        raise NoDescription(f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here or above{next(problems, why)}")

    @classmethod
    def from_path(cls, path: Path, outputs: str | None = None) -> "Description":
        """Return the description with this main file; its artifacts are in a subfolder of ``outputs``."""
        folder = Path(os.path.abspath(path)).parent
        name = folder.name if path.name == ROOT_FILE else path.stem
        base = Path(cls.OUTPUTS if outputs is None else outputs)
        if outputs is None and folder.parent.name == DESCRIPTIONS:
            base = folder.parent.parent / cls.OUTPUTS
            relative = os.path.relpath(base)  # a relative path is shorter in messages
            base = base if path.is_absolute() and relative.startswith("..") else Path(relative)
        return cls(name, path, base / name)

    @classmethod
    def project_folder(cls) -> Path:
        """Return the project folder around the current folder, as a relative path; without one, the current folder."""
        return next((folder for folder in _upwards() if all_in(folder)), Path())

    @staticmethod
    def nearest_file(path: Path) -> Path | None:
        """Return the file in the same folder with a similar name, whatever its extension, or None."""
        with suppress(OSError, ValueError):  # the folder does not exist, or the path has invalid characters
            stems = {file.stem: file for file in sorted(path.parent.iterdir()) if files.is_file(file)}
            return stems.get(nearest(path.stem, stems) or "")
        return None

    @property
    def projects(self) -> tuple[Path, ...]:
        """The project folders that contain the description (see ``homes``), or its folder if it is in no project."""
        return tuple(
            next((folder.parent for folder in (home, *home.parents) if folder.name == DESCRIPTIONS), home)
            for home in homes(self.path)
        )


def give_stdin(data: bytes) -> None:
    """Register data from standard input as the description ``-``."""
    _on_stdin[:] = [data]


def stdin_of(path: Path) -> bytes | None:
    """Return the data from standard input if the path denotes it, or None."""
    return _on_stdin[0] if _on_stdin and path == Description.ON_STDIN else None


def all_here() -> list[Path]:
    """Return the main files of all descriptions of the current project, sorted by name."""
    return all_in(Description.project_folder())


def all_in(project: Path) -> list[Path]:
    """Return the main files of all descriptions of a project, sorted by name. Raises OSError."""
    return [folder / ROOT_FILE for folder in _description_folders(project) if _has_first_file(folder)]


def descriptions_of(changed: Iterable[str]) -> list[Path]:
    """Return the main files of all descriptions of the projects that contain the files, sorted."""
    projects = (next(filter(None, map(all_in, Path(file).parents)), []) or all_here() for file in changed)
    return sorted({path for project in projects for path in project})


def nearest_descriptions() -> list[Description]:
    """Return the description in or above the current folder, or all of the current project. Raises NoDescription."""
    for folder in _upwards():
        if all_in(folder):
            break
        if files.is_file(folder / ROOT_FILE):
            return [Description.from_path(folder / ROOT_FILE)]
    return Description.find([])


def without_first_file(project: Path) -> list[tuple[str, str]]:
    """Return a message and a fix for each folder in ``descriptions/`` without a main file. Raises OSError."""
    # Do not report a folder of shared files: files of other folders contain its name.
    folders = [folder for folder in _description_folders(project) if folder.is_dir() and folder.name[0] != "."]
    lacking = [folder for folder in folders if not _has_first_file(folder)]
    text = b"".join(_beginning(file) for folder in folders for file in folder.rglob("*.y*ml")) if lacking else b""
    return [_no_first_file(folder) for folder in lacking if f"{folder.name}/".encode() not in text or _misnamed(folder)]


def _description_folders(project: Path) -> list[Path]:
    folder = Path(project, DESCRIPTIONS)
    return sorted(folder.iterdir()) if folder.is_dir() else []


def _has_first_file(folder: Path) -> bool:
    """Return True if a folder has a main file, even if it is a dangling link or unreadable."""
    try:
        return bool((folder / ROOT_FILE).lstat())
    except PermissionError:  # reading the description will report this
        return not folder.name.startswith(".")
    except OSError:
        return False


def _misnamed(folder: Path) -> Path | None:
    """Return the file in a folder that is probably its main file, by its name or content, or None."""
    inside = [file for file in sorted(folder.iterdir()) if file.suffix.lower() in ENDINGS]
    named = [file for file in inside if file.stem.lower() == Path(ROOT_FILE).stem]
    return next((f for f in (*named, *inside) if f in named or re.search(rb"^robot:", _beginning(f), re.M)), None)


def _beginning(file: Path) -> bytes:
    with suppress(OSError):
        return files.read_bytes(file, 1_000_000)
    return b""


def _no_first_file(folder: Path) -> tuple[str, str]:
    if (misnamed := _misnamed(folder)) is not None:
        return f"{files.label(misnamed)} is not compiled: it has to be called {ROOT_FILE}", f"rename it to {ROOT_FILE}"
    return f"{files.label(folder)} has no {ROOT_FILE}", f"add {ROOT_FILE}, or move the folder out of {DESCRIPTIONS}"


def _upwards() -> Iterator[Path]:
    """Yield the current folder and its parents as relative paths, up to one that is writable by all, such as /tmp."""
    here = Path.cwd()
    with suppress(OSError):  # a parent may be unreadable
        for depth, folder in enumerate((here, *here.parents)):
            if depth and folder.stat().st_mode & stat.S_IWOTH:
                return
            yield Path(*[os.pardir] * depth)


def homes(path: Path) -> tuple[Path, ...]:
    """Return the folder of a description and, if colcon installed it as a link, the folder of the source file."""
    here = files.resolve(path.parent)
    with suppress(OSError, RuntimeError):  # a loop of links
        if path.is_symlink() and (there := files.resolve(path).parent) != here:
            return here, there
    return (here,)


def first_file(name: str) -> Path:
    """Return the main file of a description, requested by file, folder or name. Raises NoDescription."""
    if name == Description.STDIN and _on_stdin:
        return Description.ON_STDIN
    if Path(name).suffix in ENDINGS and _may_be_file(Path(name)):  # a file: do not search parent folders
        return Path(name)
    places = (Path(name), Path(DESCRIPTIONS, name), Path(Description.project_folder(), DESCRIPTIONS, name))
    for path in (*(place / ROOT_FILE for place in places), Path(name)):
        if _may_be_file(path):
            return path
    for path in filter(files.is_folder, places):
        if _misnamed(path) or path.parent.name == DESCRIPTIONS:
            raise NoDescription(f'no description "{name}": {"; ".join(_no_first_file(path))}')
    known, none = [path.parent.name for path in all_here()], f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here"
    what = f"file, folder with {ROOT_FILE} or description"
    raise NoDescription(str(UnknownName(what, name[:200], known, none=none)))


def _may_be_file(path: Path) -> bool:
    """Return True if a file exists or is inaccessible; reading it later reports the reason."""
    try:
        return files.is_file(path)
    except PermissionError:
        return True


def no_file(path: Path, of: str = "") -> str:
    """Return the message for a path that is not a readable file; ``of`` is the content, such as "arguments"."""
    what = f" of {of}" if of else ""
    if not files.exists(path):
        return f'there is no file "{str(path)[:200]}"{what}'
    is_folder, pipe = files.is_folder(path), ": a pipe can be read once only; write it to a file first"
    return f'"{path}" is {f"a folder, not a file{what}" if is_folder else f"not a regular file{what}{pipe}"}'


ROS_PACKAGE, PYTHON_PACKAGE = "ROS package", "Python package"


class PackageFolder(NamedTuple):
    """A package that was looked up by name; ``kind`` is ``ROS_PACKAGE`` or ``PYTHON_PACKAGE``; the path is absolute."""

    kind: str
    name: str
    folder: Path


def python_folder(package: str) -> Path | None:
    """Return the folder of an installed Python package without importing it, or None."""
    places = package_folders(package) if package.isidentifier() else ()
    return Path(places[0]) if places and files.is_folder(places[0]) else None


_DATA = {name: name for name in ("bazel", "cmake", "schemas", "templates")}
_DATA |= {"parts_library": "parts", "viewer": "viewer/built"}  # maps each data package to its folder in a checkout
_CHECKOUT = Path(__file__).parents[3]


def data_folder(name: str) -> Path:
    """Return the folder of a data package ("templates", "schemas", ...), in a checkout the folder of the repository."""
    if (_CHECKOUT / "pyproject.toml").is_file() and (_CHECKOUT / _DATA[name]).is_dir():
        return _CHECKOUT / _DATA[name]
    package = "viewer.built" if name == "viewer" else name
    return Path(import_module(f"rosorin_compile.{package}").__path__[0])


@cache
def tool_folders() -> dict[str, Path]:
    """Return the folders of the tool by name: the folder of the code, then the folders of data packages."""
    return {"rosorin_compile": Path(__file__).parents[1], **{name: data_folder(name) for name in _DATA}}

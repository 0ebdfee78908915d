"""Locate robot descriptions, their output folders, and the data files of this package."""

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
    """Raised if no description has the requested name; the message lists the existing descriptions."""


@dataclass(frozen=True)
class Description:
    """The name of a robot description, the path of its main file, and the folder of its artifacts (``outputs``)."""

    name: str
    path: Path
    outputs: Path

    STDIN: ClassVar[str] = "-"  # the name that means standard input
    ON_STDIN: ClassVar[Path] = Path("<stdin>")  # path of standard input in messages
    ENDINGS, ROOT_FILE, FOLDER, OUTPUTS = ENDINGS, ROOT_FILE, DESCRIPTIONS, "outputs"
    SCHEMA: ClassVar[Path] = Path(".schema", "rosorin-compile.schema.json")  # relative to the folder descriptions/

    @classmethod
    def find(cls, names: list[str], outputs: str | None = None) -> "list[Description]":
        """Find descriptions by name, folder or main file, or all descriptions of the project if ``names`` is empty.

        ``outputs`` is the folder that contains one subfolder of artifacts per robot. Raises NoDescription.
        """
        if paths := [first_file(name) for name in names] or all_here():
            return [cls.from_path(path, outputs) for path in paths]
        why = "; name a description, or go to its project; rosorin-compile init NAME creates one, "
        why += "rosorin-compile import FILE converts a URDF, xacro, SDF, MJCF"
        problems = (f": {'; '.join(problem)}" for folder in _upwards() for problem in without_first_file(folder))
        raise NoDescription(f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here or above{next(problems, why)}")

    @classmethod
    def from_path(cls, path: Path, outputs: str | None = None) -> "Description":
        """Create a description from the path of its main file; its artifacts are in a subfolder of ``outputs``."""
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
        """Return the nearest parent folder with ``descriptions/``, as a relative path, or the current folder."""
        return next((folder for folder in _upwards() if all_in(folder)), Path())

    @staticmethod
    def nearest_file(path: Path) -> Path | None:
        """Return the file whose name is most similar to that of a missing file, ignoring extensions, or None."""
        with suppress(OSError, ValueError):
            found = [file for file in sorted(path.parent.iterdir()) if files.is_file(file)]
            stems = {file.stem: file for file in found if file.suffix != ".imported"}  # not a record of an import
            return stems.get(nearest(path.stem, stems) or "")
        return None

    @property
    def projects(self) -> tuple[Path, ...]:
        """The project folders of the description: two if its main file is a symlink into another project."""
        return tuple(
            next((folder.parent for folder in (home, *home.parents) if folder.name == DESCRIPTIONS), home)
            for home in homes(self.path)
        )


def give_stdin(data: bytes) -> None:
    """Store the contents of standard input, which the description "-" then refers to."""
    _on_stdin[:] = [data]


def stdin_of(path: Path) -> bytes | None:
    """Return the stored contents of standard input if ``path`` is ``Description.ON_STDIN``, or None."""
    return _on_stdin[0] if _on_stdin and path == Description.ON_STDIN else None


def all_here() -> list[Path]:
    """Return the main files of all descriptions in the current project, sorted by name."""
    return all_in(Description.project_folder())


def all_in(project: Path) -> list[Path]:
    """Return the main files of all descriptions in a project, sorted by name. Raises OSError."""
    return [folder / ROOT_FILE for folder in _description_folders(project) if _has_first_file(folder)]


def descriptions_of(changed: Iterable[str]) -> list[Path]:
    """Return the main files of all descriptions in the projects that contain the ``changed`` files, sorted."""
    projects = (next(filter(None, map(all_in, Path(file).parents)), []) or all_here() for file in changed)
    return sorted({path for project in projects for path in project})


def nearest_descriptions() -> list[Description]:
    """Return the description that contains the current folder, or all in the project. Raises NoDescription."""
    for folder in _upwards():
        if all_in(folder):
            break
        if files.is_file(folder / ROOT_FILE):
            return [Description.from_path(folder / ROOT_FILE)]
    return Description.find([])


def without_first_file(project: Path) -> list[tuple[str, str]]:
    """Return (message, fix) for each folder in ``descriptions/`` that lacks a main file. Raises OSError."""
    # A folder of shared files needs no main file; it is recognized because other descriptions mention its name.
    folders = [folder for folder in _description_folders(project) if folder.is_dir() and folder.name[0] != "."]
    lacking = [folder for folder in folders if not _has_first_file(folder)]
    text = b"".join(_beginning(file) for folder in folders for file in folder.rglob("*.y*ml")) if lacking else b""
    return [_no_first_file(folder) for folder in lacking if f"{folder.name}/".encode() not in text or _misnamed(folder)]


def _description_folders(project: Path) -> list[Path]:
    folder = Path(project, DESCRIPTIONS)
    return sorted(folder.iterdir()) if folder.is_dir() else []


def _has_first_file(folder: Path) -> bool:
    try:
        return bool((folder / ROOT_FILE).lstat())
    except PermissionError:  # this is reported when the description is read
        return not folder.name.startswith(".")
    except OSError:
        return False


def _misnamed(folder: Path) -> Path | None:
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
    """Yield ".", ".." and so on, and stop before a folder that all users can write, such as /tmp."""
    here = Path.cwd()
    with suppress(OSError):
        for depth, folder in enumerate((here, *here.parents)):
            if depth and folder.stat().st_mode & stat.S_IWOTH:
                return
            yield Path(*[os.pardir] * depth)


def homes(path: Path) -> tuple[Path, ...]:
    """Return the folder of a description and, if its main file is a symlink (as in colcon installs), of the target."""
    here = files.resolve(path.parent)
    with suppress(OSError, RuntimeError):
        if path.is_symlink() and (there := files.resolve(path).parent) != here:
            return here, there
    return (here,)


def first_file(name: str) -> Path:
    """Return the main file of the description with this path, folder or name. Raises NoDescription."""
    if name == Description.STDIN and _on_stdin:
        return Description.ON_STDIN
    if Path(name).suffix in ENDINGS and _may_be_file(Path(name)):  # a path, not the name of a description
        return Path(name)
    places = (Path(name), Path(DESCRIPTIONS, name), Path(Description.project_folder(), DESCRIPTIONS, name))
    for path in (*(place / ROOT_FILE for place in places), Path(name)):
        if _may_be_file(path):
            return path
    for path in filter(files.is_folder, places):
        if _misnamed(path) or path.parent.name == DESCRIPTIONS:
            raise NoDescription(f'no description "{name}": {"; ".join(_no_first_file(path))}')
    known, none = [path.parent.name for path in all_here()], f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here"
    raise NoDescription(str(UnknownName(f"file, folder with {ROOT_FILE} or description", name[:200], known, none=none)))


def _may_be_file(path: Path) -> bool:
    try:
        return files.is_file(path)
    except PermissionError:
        return True


def no_file(path: Path, of: str = "") -> str:
    """Return the message for a path that is not a regular file; ``of`` is the expected content, such as "arguments"."""
    what = f" of {of}" if of else ""
    if not files.exists(path):
        return f'there is no file "{str(path)[:200]}"{what}'
    is_folder, pipe = files.is_folder(path), ": a pipe can be read once only; write it to a file first"
    return f'"{path}" is {f"a folder, not a file{what}" if is_folder else f"not a regular file{what}{pipe}"}'


ROS_PACKAGE, PYTHON_PACKAGE = "ROS package", "Python package"


class PackageFolder(NamedTuple):
    """A ROS or Python package that a description refers to by name, and the absolute path of its folder."""

    kind: str
    name: str
    folder: Path


def python_folder(package: str) -> Path | None:
    """Return the folder of an installed Python package, or None. The package is not imported."""
    places = package_folders(package) if package.isidentifier() else ()
    return Path(places[0]) if places and files.is_folder(places[0]) else None


_DATA = {name: name for name in ("bazel", "cmake", "schemas", "templates")}
_DATA |= {"parts_library": "parts", "viewer": "viewer/built"}  # data package: its folder in a Git checkout
_CHECKOUT = Path(__file__).parents[3]


def data_folder(name: str) -> Path:
    """Return the folder of data files, such as "templates" or "schemas", in the package or in a Git checkout."""
    if (_CHECKOUT / "pyproject.toml").is_file() and (_CHECKOUT / _DATA[name]).is_dir():
        return _CHECKOUT / _DATA[name]
    package = "viewer.built" if name == "viewer" else name
    return Path(import_module(f"rosorin_compile.{package}").__path__[0])


@cache
def tool_folders() -> dict[str, Path]:
    """Return the folders of this package by name: the folder of the code, and the folders of data files."""
    return {"rosorin_compile": Path(__file__).parents[1], **{name: data_folder(name) for name in _DATA}}

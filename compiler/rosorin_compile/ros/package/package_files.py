"""List the files of ROS packages on disk, and find files that the build files of a package do not install."""

import fnmatch
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from rosorin_compile.source.files import exists, is_file, read_text, resolve

MAX_FILES = 50_000
_BUILT = ("build", "install", "log")  # created by colcon if they contain COLCON_IGNORE
_SKIPPED = {"__pycache__", "node_modules"}
_LAUNCH_ENDINGS = (".launch.py", "_launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch")
_NODES = ("robot_state_publisher", "tf2_ros")


def files_below(folder: Path, skip_built: bool) -> list[str]:
    """Return the sorted POSIX paths of all files below a folder, relative to the folder.

    If ``skip_built``, skip symlinked folders and folders that colcon created, where this tool must not write. Raises
    OSError, for example for more than 50,000 files.
    """
    names: list[str] = []
    visited: set[Path] = set()

    def fail(problem: OSError) -> None:
        raise problem

    for place, folders, files in os.walk(folder, followlinks=not skip_built, onerror=fail):
        here, real = Path(place), resolve(Path(place))
        if real in visited or (visited and resolve(folder).is_relative_to(real)):
            folders.clear()
            continue
        visited.add(real)
        built = {name for name in _BUILT if (skip_built or name != "install") and exists(here / name / "COLCON_IGNORE")}
        entered = [name for name in folders if not name.startswith(".") and name not in built | _SKIPPED]
        folders[:] = sorted(entered, key=lambda name: ((here / name).is_symlink(), name))
        names += [(here.relative_to(folder) / name).as_posix() for name in files if is_file(here / name)]
        if len(names) > MAX_FILES:
            raise OSError(f"more than {MAX_FILES:,} files; name the folder of the package")
    return sorted(names)


def is_launch_file(name: str) -> bool:
    """Return True if a path looks like a launch file."""
    return name.endswith(_LAUNCH_ENDINGS) or ("launch/" in name and name.endswith(".py"))


class InstallHint(NamedTuple):
    """The build file (setup.py or CMakeLists.txt) that does not install a file, and the line to add to it."""

    decided_by: str
    line: str


def uninstalled_files(package: Path, name: str, files: Sequence[str]) -> Iterator[tuple[str, InstallHint]]:
    """Yield (file, hint) for each file, relative to the package, that setup.py or CMakeLists.txt does not install.

    If a package has both build files, its build type determines which of them applies.
    """
    setup, cmake = package / "setup.py", package / "CMakeLists.txt"
    is_python = is_file(setup) and (not is_file(cmake) or "<build_type>ament_python<" in _text(package / "package.xml"))
    text = re.sub(r"#[^\n]*", "", _text(setup if is_python else cmake))
    words = {word.removeprefix("${CMAKE_CURRENT_SOURCE_DIR}/").rstrip("/") for word in re.split(r'[\s()"]+', text)}
    for file in files if is_file(setup) or is_file(cmake) else ():
        folder = file.rpartition("/")[0]
        if is_python and not _setup_installs(text, file):
            yield file, InstallHint("setup.py", f"('{f'share/{name}/{folder}'.rstrip('/')}', ['{file}']),")
        elif not is_python and words.isdisjoint({file, *map(str, PurePosixPath(file).parents)}):
            what = f"DIRECTORY {folder}" if folder else f"FILES {file}"
            yield file, InstallHint("CMakeLists.txt", f"install({what} DESTINATION share/${{PROJECT_NAME}})")


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""


def _setup_installs(text: str, file: str) -> bool:
    """Return True if setup.py names a file or its folder, matches it with a wildcard, or searches for files."""
    if "data_files" not in text or re.search(r"rglob|os\.walk|iterdir|listdir", text):
        return True
    patterns = [re.sub(r"\{[^}]*\}", "*", found) for found in re.findall(r"""['"](?:\./)?([^'"\n]*)['"]""", text)]
    folder, _, name = file.rpartition("/")
    if not folder or any(folder == pattern.rstrip("/") for pattern in patterns):
        file = name
        patterns = [pattern.rpartition("/")[2] for pattern in patterns]
    # unlike in fnmatch, a wildcard in glob does not match "/"
    return any(file.count("/") == one.count("/") and fnmatch.fnmatchcase(file, one) for one in patterns)


def undeclared_packages(package: Path, launch: Sequence[str]) -> list[str]:
    """Return the packages that launch files need and package.xml lacks; ``launch`` are the texts of launch files."""
    declared = set(re.findall(r"<(?:exec_|run_)?depend[^<>]*>\s*([^<\s]+)\s*<", _text(package / "package.xml")))
    started = [name for name in _NODES if any(name in one for one in launch)]
    return [name for name in started if name not in declared]

"""ROS packages on disk: the package of a folder, its files, what it installs, and its install space."""

from __future__ import annotations

import ast
import fnmatch
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from .files import exists, is_file, is_folder, read_text, resolve

MAX_FILES = 50_000
_SKIPPED = {"__pycache__", "node_modules"}
# What colcon makes beside the sources; it puts a file COLCON_IGNORE into each.
BUILT = ("build", "install", "log")
_LAUNCH_ENDINGS = (".launch.py", "_launch.py", ".launch.xml", ".launch.yaml", ".launch.yml", ".launch")

_AUTO = re.compile(r"\bINSTALL_TO_SHARE\s+([^()]*)\)")
_INSTALL = re.compile(r"install\s*\(\s*(DIRECTORY|FILES|PROGRAMS)\s+([^()]*?)\bDESTINATION\b", re.IGNORECASE)
_NODES = ("robot_state_publisher", "tf2_ros")
_WALKS = ("rglob", "os.walk", "iterdir", "listdir")


def package_of(folder: Path) -> tuple[Path, str] | None:
    """Return the folder of the package that a folder is in, and the name of the package; None if it is in none."""
    for place in _upwards(resolve(folder)):
        path = place / "package.xml"
        if is_file(path):
            match = re.search(r"<name>\s*([^<\s]+)\s*</name>", read_text(path, errors="replace"))
            return (place, match[1]) if match else None
    return None


def _upwards(folder: Path) -> Iterator[Path]:
    yield folder
    yield from list(folder.parents)[:4]


def files_below(folder: Path, skip_built: bool) -> list[str]:
    """Return the files below a folder by relative POSIX name, sorted; a folder that several names lead to counts once.

    ``skip_built`` leaves out what colcon made and what links to folders lead to: nothing may be written there.
    Raises OSError, also if there are more than 50,000 files.
    """
    names: list[str] = []
    seen: set[Path] = set()
    for place, folders, files in _walk(folder, follow=not skip_built):
        real = resolve(place)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        folders[:] = [name for name in folders if _is_wanted(place / name, skip_built)]
        relative = place.relative_to(folder)
        names += [(relative / name).as_posix() for name in files]
        if len(names) > MAX_FILES:
            raise OSError(f"more than {MAX_FILES:,} files; name the folder of the package")
    return sorted(names)


def _walk(folder: Path, follow: bool) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Walk a folder, and then what links lead to: a file is found by the name without a link, if it has one.

    A link to what the folder itself is in leads nowhere. Raises OSError.
    """
    links: list[Path] = []
    for place, folders, files in _below(folder, follow=False):
        yield place, folders, files
        links += [place / name for name in folders if follow and (place / name).is_symlink()]
    for link in links:
        if resolve(folder).is_relative_to(resolve(link)):
            continue
        yield from _below(link, follow=True)


def _below(top: Path, follow: bool) -> Iterator[tuple[Path, list[str], list[str]]]:
    """Yield each folder with the folders and files in it, sorted; those are gone into that are left. Raises OSError."""
    waiting = [top]
    while waiting:
        place = waiting.pop()
        inside = sorted(place.iterdir())
        folders, files = ([path.name for path in inside if test(path)] for test in (is_folder, is_file))
        yield place, folders, files
        waiting += [place / name for name in reversed(folders) if follow or not (place / name).is_symlink()]


def _is_wanted(folder: Path, skip_built: bool) -> bool:
    if folder.name.startswith(".") or folder.name in _SKIPPED:
        return False
    made = folder.name in BUILT and exists(folder / "COLCON_IGNORE")
    return not (made and (skip_built or folder.name != "install"))


def is_launch_file(name: str) -> bool:
    """Return True if a file is a launch file, by its name."""
    return name.endswith(_LAUNCH_ENDINGS) or ("launch/" in name and name.endswith(".py"))


class Missing(NamedTuple):
    """A file that a package does not install: the file that decides it, and the line that would."""

    decided_by: str
    line: str


def missing(package: Path, name: str, files: Sequence[str]) -> Iterator[tuple[str, Missing]]:
    """Yield the files, relative to the package, that plainly neither setup.py nor CMakeLists.txt installs.

    Where a package has both, its build type says which of them counts.
    """
    setup, cmake = package / "setup.py", package / "CMakeLists.txt"
    in_python = is_file(setup) and "<build_type>ament_python<" in _text(package / "package.xml")
    if is_file(cmake) and not in_python:
        text = re.sub(r"#[^\n]*", "", read_text(cmake, errors="replace"))
        for file in files:
            folder = file.rpartition("/")[0]
            if not _cmake_installs(text, file):
                line = f"install(DIRECTORY {folder} DESTINATION share/${{PROJECT_NAME}})"
                whole = f"install(FILES {file} DESTINATION share/${{PROJECT_NAME}})"
                yield file, Missing("CMakeLists.txt", line if folder else whole)
    elif is_file(setup):
        text = read_text(setup, errors="replace")
        for file in files:
            if not _setup_installs(text, file):
                folder = file.rpartition("/")[0]
                share = f"share/{name}/{folder}".rstrip("/")
                yield file, Missing("setup.py", f"('{share}', ['{file}']),")


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""


def _cmake_installs(text: str, file: str) -> bool:
    """Say whether CMakeLists.txt installs a file; also where a variable hides it and the folder is named at all."""
    for kind, words in [*_INSTALL.findall(text), *(("DIRECTORY", words) for words in _AUTO.findall(text))]:
        for word in words.replace('"', " ").split():
            plain = word.removeprefix("${CMAKE_CURRENT_SOURCE_DIR}/").rstrip("/")
            if "${" in plain and re.search(rf"\b{re.escape(file.partition('/')[0])}\b", text):
                return True
            below = kind.upper() == "DIRECTORY" and (plain in ("", ".") or file.startswith(f"{plain}/"))
            if below or plain == file:
                return True
    return False


def _setup_installs(text: str, file: str) -> bool:
    """Return True if setup.py names a file, as it is or with wildcards, or searches for files itself.

    The folder and the name may be two texts, as in ``glob(os.path.join("launch", "*.py"))``.
    """
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return True
    if any(word in text for word in _WALKS):
        return True
    nodes = list(ast.walk(tree))
    texts = {node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    formatted = (node.values for node in nodes if isinstance(node, ast.JoinedStr))
    texts |= {"".join(str(one.value) if isinstance(one, ast.Constant) else "*" for one in each) for each in formatted}
    texts = {text.removeprefix("./") for text in texts}
    folder, _, name = file.rpartition("/")
    has_folder = not folder or any(folder in (text, text.rstrip("/")) for text in texts)
    return any(_matches(file, text) or (has_folder and _matches(name, text.rpartition("/")[2])) for text in texts)


def _matches(file: str, pattern: str) -> bool:
    """Return True if a pattern matches a file; its wildcards stop at "/"."""
    words, patterns = file.split("/"), pattern.split("/")
    return len(words) == len(patterns) and all(map(fnmatch.fnmatchcase, words, patterns))


def undeclared(package: Path, launch: Sequence[str]) -> list[str]:
    """Return the packages whose nodes the ``launch`` texts start, and which package.xml does not name."""
    text = _text(package / "package.xml")
    declared = set(re.findall(r"<(?:exec_|run_)?depend[^<>]*>\s*([^<\s]+)\s*<", text))
    started = [name for name in _NODES if any(name in one for one in launch)]
    return [name for name in started if name not in declared]


def install_space(package: Path, name: str) -> Path | None:
    """Return share/NAME of the install space beside the sources, as colcon makes it; None if there is none."""
    for parent in list(resolve(package).parents)[:4]:
        for share in (parent / "install" / name / "share" / name, parent / "install" / "share" / name):
            if is_folder(share):
                return share
    return None


def share_folder(install: Path, name: str) -> Path | None:
    """Return share/NAME of a folder that is an install space, the prefix of a package, or share/NAME itself."""
    for share in (install / name / "share" / name, install / "share" / name, install):
        if is_file(share / "package.xml"):
            return share
    return None

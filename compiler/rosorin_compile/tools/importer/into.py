"""Into: the description of a robot put into the ROS package that has its xacro, beside it.

A test holds both against each other until the xacro is removed. What is there already stays to the byte: lines for
CMakeLists.txt, setup.py, package.xml and launch files are told, and written by whoever maintains them.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...diagnostics import Diagnostic
from ...diagnostics.wording import listed
from ...output.placing import alone
from ...project import DESCRIPTIONS, ROOT_FILE
from ...startup.records import NamedTuple
from ..package.finding import package_of
from ..package.installing import missing
from ..usage import WrongUsage
from .switching import Line, lines_to_change

CMAKE, PYTHON = "ament_cmake", "ament_python"
_BUILD_TYPE = re.compile(r"<build_type[^<>]*>\s*([^<\s]+)\s*</build_type>")
_NO_WORD = re.compile(r"\W+")


class Package(NamedTuple):
    """A ROS package: its folder, its name, and what builds it."""

    folder: Path
    name: str
    build_type: str

    @property
    def registry(self) -> str:
        """The file that says what is installed and tested."""
        return "setup.py" if self.build_type == PYTHON else "CMakeLists.txt"


class Put(NamedTuple):
    """What was put into a package: the files that are new, those that were there and are other ones, and what to do.

    ``add`` are lines by the file that they belong to, ``change`` lines of launch files. ``finished`` is what is to be
    said of a run before.
    """

    written: tuple[str, ...]
    kept: tuple[str, ...]
    add: Mapping[str, Sequence[str]]
    change: Sequence[Line]
    test: str
    finished: list[Diagnostic]


def package_at(folder: Path) -> Package:
    """Return the package in a folder. Raises WrongUsage where there is none."""
    if not folder.is_dir():
        raise WrongUsage(f"{folder} is no folder; --into names the folder of a ROS package")
    found = package_of(folder)
    if found is None or found[0] != folder.resolve():
        way = (
            f"; did you mean {found[0]}?" if found else "; to write a package of its own: rosorin-compile package ROBOT"
        )
        raise WrongUsage(f"{folder} is no ROS package: it has no package.xml with a name{way}")
    said = _BUILD_TYPE.search(_text(folder / "package.xml"))
    build_type = said[1] if said else ""
    if build_type not in (CMAKE, PYTHON):
        help = "add <export><build_type>ament_cmake</build_type></export>" if not said else "only those two are known"
        was = f'its build type is "{build_type}"' if said else "its package.xml says no build type"
        raise WrongUsage(f"{folder} is not built by ament_cmake or ament_python: {was}; {help}")
    return Package(folder, found[1], build_type)


def inside(source: Path, package: Package) -> str:
    """Return a source as seen from the package that it is in. Raises WrongUsage for one that is elsewhere."""
    try:
        return source.resolve().relative_to(package.folder.resolve()).as_posix()
    except ValueError:
        own = package_of(source.resolve().parent)
        way = f"; it is in package {own[1]}: --into {own[0]}" if own else "; copy it there, or name its package"
        message = f"{source} is not in {package.folder}: the test that is written holds both against each other"
        raise WrongUsage(f"{message}{way}") from None


def put_into(
    package: Package,
    source: str,
    given: Mapping[str, str],
    name: str,
    files: Mapping[str, str],
    tree: Mapping[str, Any],
) -> Put:
    """Put the files of a description into a package, all or nothing; what is there stays. Raises OutputError.

    ``source`` is the file that it was imported from, seen from the package, with what it was ``given``; ``tree`` is
    that of the description.
    """
    description = f"{DESCRIPTIONS}/{name}"
    test = f"test/test_{_NO_WORD.sub('_', name).lower()}_description.py"
    wanted = {f"{description}/{file}": text.encode() for file, text in files.items()}
    there = package.folder / description
    with alone(package.folder) as held:
        if there.exists() and any(there.iterdir()):
            wanted = {}
        wanted[test] = _test(package, source, f"{description}/{ROOT_FILE}", given).encode()
        kept = [file for file in wanted if _differs(package.folder / file, wanted[file])]
        fresh = held.place({file: data for file, data in wanted.items() if file not in kept})
    others = {file: text.encode() for file, text in files.items()}
    if any(_differs(there / file, data) for file, data in others.items()):
        kept.insert(0, description)
    change = lines_to_change(package.folder, source, description, frozenset(tree.get("args") or ()))
    add = {file: found for file, found in _to_add(package, description, test, files).items() if found}
    return Put(fresh, tuple(kept), add, change, test, held.finished.told())


def _differs(path: Path, data: bytes) -> bool:
    """Say whether another file stands at a path."""
    return os.path.lexists(path) and not (path.is_file() and path.read_bytes() == data)


def _text(path: Path) -> str:
    return path.read_text("utf-8", "replace") if path.is_file() else ""


def _test(package: Package, source: str, description: str, given: Mapping[str, str]) -> str:
    """Return the test that holds a description against its source."""
    from ...formats.templating import BUILTIN, Templates

    values = {
        "source": source,
        "description": description,
        "given": dict(given),
        "name": package.name,
        "registry": f"{package.registry} and package.xml",
        "literal": repr,
    }
    return Templates().render(f"{BUILTIN}import_test.py.jinja", values)


def _to_add(package: Package, description: str, test: str, files: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the lines that the files of a package lack, by file."""
    names = [f"{description}/{file}" for file in files]
    absent = [file for file, _ in missing(package.folder, package.name, names)]
    manifest = _text(package.folder / "package.xml")
    if package.build_type == PYTHON:
        row = ", ".join(map(repr, absent))
        install = [f"('share/{package.name}/{description}', [{row}]),"] if absent else []
        if "pytest" not in _text(package.folder / "setup.py"):  # colcon asks that before it runs pytest
            install.append("extras_require={'test': ['pytest']},")
        depends = "python3-pytest"
    else:
        install = ["install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})"] if absent else []
        install += _registered(_text(package.folder / "CMakeLists.txt"), test)
        depends = "ament_cmake_pytest"
    named = re.search(rf"<(test_|build_)?depend[^<>]*>\s*{depends}\s*<", manifest)
    needs = [] if named else [f"<test_depend>{depends}</test_depend>"]
    return {package.registry: install, "package.xml": needs}


def _registered(cmake: str, test: str) -> list[str]:
    """Return the lines by which CMakeLists.txt has a test run, if it does not yet."""
    plain = re.sub(r"#[^\n]*", "", cmake)
    if re.search(rf"ament_add_pytest_test\s*\([^()]*\b{re.escape(test)}", plain):
        return []
    name = Path(test).stem
    return ["if(BUILD_TESTING)", "  find_package(ament_cmake_pytest REQUIRED)",
            f"  ament_add_pytest_test({name} {test})", "endif()"]  # fmt: skip


def _place(file: str) -> str:
    """Return what a file is told as: those of a description are one thing."""
    return "/".join(file.split("/")[:2]) if file.startswith(f"{DESCRIPTIONS}/") else file


def told(package: Package, put: Put) -> Iterator[str]:
    """Yield the lines about what was put into a package."""
    name = package.folder.resolve().name
    if put.written:
        places = dict.fromkeys(_place(file) for file in put.written)
        yield f"{name}: written: {', '.join(places)}"
    for file in put.kept:
        yield f"{name}: {file} is there with changes of its own, and stays as it is"
    if not put.written and not put.kept:
        yield f"{name}: unchanged"


def to_do(package: Package, put: Put) -> Iterator[str]:
    """Yield the lines about what is left to be done in a package."""
    for file, lines in put.add.items():
        yield f"add to {package.folder / file}:"
        yield from (f"  {line}" for line in lines)
    for line in put.change:
        where = os.path.normpath(package.folder / line.file)
        yield f"change {where}:{line.number}{f' ({line.remark})' if line.remark else ''}:"
        yield f"  - {line.old}"
        if line.new:
            yield f"  + {line.new}"


def in_the_end(source: str, put: Put) -> Iterator[str]:
    """Yield the lines about how the source and its description go on together."""
    if not put.change:
        yield f"no launch file here names {Path(source).name}: where it is expanded, take rosorin-compile print urdf"
    yield f"{listed([source])} stays; {put.test} holds both against each other: colcon test, or pytest"

"""The ROS package that gets the description of a robot next to its source, with a test that compares both."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output.package_folder import package_of
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.files import is_file, is_folder, read_text, resolve
from rosorin_compile.source.project import Description

CMAKE, PYTHON = "ament_cmake", "ament_python"
_BUILD_TYPE = re.compile(r"<build_type[^<>]*>\s*([^<\s]+)\s*</build_type>")


class Package(NamedTuple):
    """A ROS package: its folder, its name, and what builds it."""

    folder: Path
    name: str
    build_type: str

    @property
    def registry(self) -> str:
        """The file that defines what is installed and tested."""
        return "setup.py" if self.build_type == PYTHON else "CMakeLists.txt"


def package_at(folder: Path) -> Package:
    """Return the package in a folder. Raises RequestError if there is none."""
    if not is_folder(folder):
        raise RequestError(f"{folder} is no folder; --into names the folder of a ROS package")
    found = package_of(folder)
    if found is None or found[0] != resolve(folder):
        help = f"did you mean {found[0]}?" if found else "to write a new package: rosorin-compile package ROBOT"
        raise RequestError(f"{folder} is no ROS package: it has no package.xml with a name; {help}")
    match = _BUILD_TYPE.search(_text(folder / "package.xml"))
    if match is None or match[1] not in (CMAKE, PYTHON):
        help = "only those two are supported" if match else "add <export><build_type>ament_cmake</build_type></export>"
        what = f'its build type is "{match[1]}"' if match else "its package.xml has no build type"
        raise RequestError(f"{folder} is not built by ament_cmake or ament_python: {what}; {help}")
    return Package(folder, found[1], match[1])


def inside(source: Path, package: Package) -> str:
    """Return the path of a source relative to its package. Raises RequestError if it is elsewhere."""
    try:
        return resolve(source).relative_to(resolve(package.folder)).as_posix()
    except ValueError:
        own = package_of(resolve(source).parent)
        help = f"it is in package {own[1]}: --into {own[0]}" if own else "copy it there, or name its package"
        message = f"{source} is not in {package.folder}, where the test that is written compares both; {help}"
        raise RequestError(message) from None


def comparing_test(package: Package, source: str, description: str, arguments: Mapping[str, str]) -> tuple[str, str]:
    """Return the name and the text of the test that compares a description with its source.

    ``source`` and ``description`` are relative to the package; ``arguments`` are those of the source.
    """
    from rosorin_compile.formats.templating import Templates

    values = {
        "source": source,
        "description": f"{description}/{Description.ROOT_FILE}",
        "given": dict(arguments),
        "name": package.name,
        "registry": f"{package.registry} and package.xml",
        "literal": repr,
    }
    name = re.sub(r"\W+", "_", Path(description).name).lower()
    return f"test/test_{name}_description.py", Templates().own("importing/test.py.jinja", values)


def lines_to_add(package: Package, description: str, test: str, files: Iterable[str]) -> Iterator[str]:
    """Yield the lines that a package needs to install a description and to run its test, below the names of files."""
    if package.build_type == PYTHON:
        rows: dict[str, list[str]] = {}
        for file in sorted(f"{description}/{name}" for name in files):
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {names})," for folder, names in rows.items()]
        if "pytest" not in _text(package.folder / package.registry):  # colcon requires it to run pytest
            install.append("extras_require={'test': ['pytest']},")
        depends = "python3-pytest"
    else:
        install = [
            "install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})",
            "if(BUILD_TESTING)",
            "  find_package(ament_cmake_pytest REQUIRED)",
            f"  ament_add_pytest_test({Path(test).stem} {test})",
            "endif()",
        ]
        depends = "ament_cmake_pytest"
    for file, lines in ((package.registry, install), ("package.xml", [f"<test_depend>{depends}</test_depend>"])):
        yield f"add to {package.folder / file}, if it is not there:"
        yield from (f"  {line}" for line in lines)


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""

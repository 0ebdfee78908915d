"""The ROS package that gets the description of a robot next to its source, with a test that compares both."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.formats.ros_packages import package_of
from rosorin_compile.output.package_folder import open_package_folder
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.files import is_file, is_folder, read_bytes, read_text, resolve
from rosorin_compile.source.project import Description

from .reimport import ENDING, is_record

CMAKE, PYTHON = "ament_cmake", "ament_python"
_REGISTRY = {CMAKE: "CMakeLists.txt", PYTHON: "setup.py"}  # the file that defines what is installed and tested
_BUILD_TYPE = re.compile(r"<build_type[^<>]*>\s*([^<\s]+)\s*</build_type>")


class Package(NamedTuple):
    """A ROS package: its folder, its name, what builds it, and the source of a robot relative to it."""

    folder: Path
    name: str
    build_type: str
    source: str


class Written(NamedTuple):
    """The new and changed files of a description, lines to add to other files, and lines about the next steps."""

    files: tuple[str, ...]
    to_do: tuple[str, ...]
    next_steps: tuple[str, ...]


def package_at(folder: Path, source: Path) -> Package:
    """Return the package in a folder. Raises RequestError if there is none, or if the source is elsewhere."""
    if not is_folder(folder):
        raise RequestError(f"{folder} is not a folder; --into names the folder of a ROS package")
    found = package_of(folder)
    if found is None or found[0] != resolve(folder):
        help = f"did you mean {found[0]}?" if found else "to write a new package: rosorin-compile package ROBOT"
        raise RequestError(f"{folder} is not a ROS package: it has no package.xml with a name; {help}")
    match = _BUILD_TYPE.search(read_text(folder / "package.xml", errors="replace"))
    if match is None or match[1] not in _REGISTRY:
        help = "only those two are supported" if match else "add <export><build_type>ament_cmake</build_type></export>"
        what = f'its build type is "{match[1]}"' if match else "its package.xml has no build type"
        raise RequestError(f"{folder} is not built by ament_cmake or ament_python: {what}; {help}")
    if not resolve(source).is_relative_to(resolve(folder)):
        own = package_of(resolve(source).parent)
        help = f"it is in package {own[1]}: --into {own[0]}" if own else "copy it there, or name its package"
        raise RequestError(f"{source} is not in {folder}, where the test that is written compares both; {help}")
    return Package(folder, found[1], match[1], resolve(source).relative_to(resolve(folder)).as_posix())


def write_into(
    package: Package, name: str, files: Mapping[str, str], arguments: Mapping[str, str], is_new: bool
) -> Written:
    """Write a description with its test into a package, all or nothing. Raises OutputError.

    Args:
        package: The package. Its other files stay as they are, and so does an edited test.
        name: The folder of the description.
        files: New and changed files of the description with their records, text by name.
        arguments: The arguments of the source.
        is_new: The description did not exist; without it, no lines to add are returned.

    """
    from rosorin_compile.formats.templating import Templates

    description, source = f"{Description.FOLDER}/{name}", package.source
    root, word = f"{description}/{Description.ROOT_FILE}", re.sub(r"\W+", "_", name).lower()
    test = f"test/test_{word}_description.py"
    values = {
        "source": source,
        "description": root,
        "given": dict(arguments),
        "name": package.name,
        "registry": f"{_REGISTRY[package.build_type]} and package.xml",
        "literal": repr,
    }
    text, path = Templates().own("importing/test.py.jinja", values).encode(), package.folder / test
    with open_package_folder(package.folder) as target:
        is_edited = os.path.lexists(path) and not (is_file(path) and read_bytes(path) == text)
        # The records are the manifest of the description, and that of robot.yaml is the last.
        order = sorted(files, key=lambda file: (is_record(file), file == f"{Description.ROOT_FILE}{ENDING}", file))
        data = {} if is_edited else {test: text}
        data |= {f"{description}/{file}": files[file].encode() for file in order}
        written = target.write(data, manifest=False)
    compares = "was edited and may compare something else" if is_edited else "compares both"
    command = f"rosorin-compile print {root} urdf"
    steps = (
        f"to expand the description instead of {Path(source).name} in launch files: {command}",
        f"{source} stays; {test} {compares}: colcon test, or pytest",
    )
    names = tuple(file.removeprefix(f"{description}/") for file in written if file != test)
    return Written(names, tuple(_lines_to_add(package, description, test, files)) if is_new else (), steps)


def _lines_to_add(package: Package, description: str, test: str, files: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that install a description and run its test, below the names of the files that need them."""
    if package.build_type == PYTHON:
        rows: dict[str, list[str]] = {}
        for file in sorted(f"{description}/{name}" for name in files if not is_record(name)):
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {names})," for folder, names in rows.items()]
        install.append("extras_require={'test': ['pytest']},")  # colcon requires it to run pytest
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
    for file, lines in (
        (_REGISTRY[package.build_type], install),
        ("package.xml", [f"<test_depend>{depends}</test_depend>"]),
    ):
        yield f"add to {package.folder / file}, if it is not there:"
        yield from (f"  {line}" for line in lines)

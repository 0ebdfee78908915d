"""Write the description of a robot into the ROS package that contains its source, with a test that compares both.

Files of the package stay as they are; lines to add to them are printed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output import open_package_folder
from rosorin_compile.output.package_folder import missing, package_of
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, error
from rosorin_compile.source.files import is_file, is_folder, read_bytes, read_text, resolve
from rosorin_compile.source.project import Description

from .reimport import (
    ENDING,
    Merged,
    Request,
    import_again,
    is_record,
    is_same_source,
    read_record,
    record_of,
    recorded,
    remove,
    source_of,
)

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


class Put(NamedTuple):
    """The result of writing a description into a package.

    ``written`` are new or changed files. ``report``, ``to_do`` and ``after`` are lines: what was done, what is left to
    the user, and how both go on. ``is_new``: the description did not exist.
    """

    written: tuple[str, ...] = ()
    report: Sequence[str] = ()
    to_do: Sequence[str] = ()
    after: Sequence[str] = ()
    diagnostics: Sequence[Diagnostic] = ()
    is_new: bool = False


def package_at(folder: Path) -> Package:
    """Return the package in a folder. Raises RequestError if there is none."""
    if not is_folder(folder):
        raise RequestError(f"{folder} is not a folder; --into names the folder of a ROS package")
    found = package_of(folder)
    if found is None or found[0] != resolve(folder):
        help = f"did you mean {found[0]}?" if found else "to write a new package: rosorin-compile package ROBOT"
        raise RequestError(f"{folder} is not a ROS package: it has no package.xml with a name; {help}")
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


def put_into(
    package: Package,
    source: str,
    arguments: Mapping[str, str],
    name: str,
    files: Mapping[str, str],
    request: Request,
) -> Put:
    """Write the files of a description into a package, all or nothing. Raises OutputError, RequestError.

    Args:
        package: The package.
        source: The imported file, relative to the package.
        arguments: The arguments of the source.
        name: The folder of the description.
        files: The files of the description, text by name.
        request: The command line of the import.

    """
    from rosorin_compile.formats.templating import Templates

    description = f"{Description.FOLDER}/{name}"
    test = f"test/test_{re.sub(r'[^A-Za-z0-9_]+', '_', name).lower()}_description.py"
    folder, root = package.folder / description, f"{description}/{Description.ROOT_FILE}"
    with open_package_folder(package.folder) as target:
        is_new = not (is_folder(folder) and any(folder.iterdir()))
        merged = _merged(package, description, files, request, is_new)
        if merged.refused:
            return Put(diagnostics=merged.diagnostics)
        values = {
            "source": source,
            "description": root,
            "given": dict(arguments),
            "name": package.name,
            "registry": f"{package.registry} and package.xml",
            "literal": repr,
        }
        text = Templates().own("importing/test.py.jinja", values).encode()
        own_test = os.path.lexists(package.folder / test) and _bytes(package.folder / test) != text
        # The records are the manifest of the description, and that of robot.yaml is the last.
        names = sorted(
            merged.files, key=lambda file: (is_record(file), file == f"{Description.ROOT_FILE}{ENDING}", file)
        )
        data = {f"{description}/{file}": merged.files[file].encode() for file in names}
        written = target.write(data if own_test else {test: text, **data}, manifest=False)
        remove(folder, merged)
    written = tuple(file for file in written if not is_record(file))
    name = resolve(package.folder).name
    places = [description if file.startswith(f"{description}/") else file for file in written]
    report = [f"{name}: written: {', '.join(dict.fromkeys(places))}"] if written else []
    report += [f"{name}: {test} was edited, and stays as it is"] if own_test else []
    report = [*(report or [f"{name}: unchanged"]), *merged.lines]
    compares = "was edited and may compare something else" if own_test else "compares both"
    after = [
        f"to expand the description instead of {Path(source).name} in launch files: rosorin-compile print {root} urdf",
        f"{source} stays; {test} {compares}: colcon test, or pytest",
    ]
    return Put(written, report, list(_to_add(package, description, test, files)), after, merged.diagnostics, is_new)


def _merged(package: Package, description: str, files: Mapping[str, str], request: Request, is_new: bool) -> Merged:
    """Merge the new state of a source with its description in a package. Raises RequestError."""
    if is_new:
        return Merged({**files, **record_of(files, request.words)})
    folder = package.folder / description
    previous = read_record(folder)
    if previous is None:
        message = f"{description} has no {Description.ROOT_FILE}{ENDING}, so that changes cannot be merged"
        help = f"give this import another --name, or import the earlier source with -o, and copy its {ENDING} files"
        return Merged(diagnostics=[error("import-no-record", message, None, help)], refused=True)
    if not is_same_source(previous.words, request.words):
        message = (
            f'"{folder.name}" is taken in {package.name}: {description} was imported from '
            f"{source_of(previous.words)}, and this is {source_of(request.words)}"
        )
        help = f"give this robot another name with --name, or remove {description} to replace it"
        return Merged(diagnostics=[error("import-name-taken", message, None, help)], refused=True)
    return import_again(folder, recorded(folder, request.words) or previous, files, request)


def _bytes(path: Path) -> bytes:
    return read_bytes(path) if is_file(path) else b""


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""


def _to_add(package: Package, description: str, test: str, files: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that the files of a package lack, below the names of the files."""
    absent = [file for file, _ in missing(package.folder, package.name, [f"{description}/{file}" for file in files])]
    registry = _text(package.folder / package.registry)
    if package.build_type == PYTHON:
        rows: dict[str, list[str]] = {}
        for file in absent:
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {names})," for folder, names in rows.items()]
        if "pytest" not in registry:  # colcon requires it to run pytest
            install.append("extras_require={'test': ['pytest']},")
        depends = "python3-pytest"
    else:
        install = ["install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})"] if absent else []
        if test not in registry:
            install += ["if(BUILD_TESTING)", "  find_package(ament_cmake_pytest REQUIRED)"]
            install += [f"  ament_add_pytest_test({Path(test).stem} {test})", "endif()"]
        depends = "ament_cmake_pytest"
    needs = [f"<test_depend>{depends}</test_depend>"] if depends not in _text(package.folder / "package.xml") else []
    for file, lines in ((package.registry, install), ("package.xml", needs)):
        if lines:
            yield f"add to {package.folder / file}:"
            yield from (f"  {line}" for line in lines)

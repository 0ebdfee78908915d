"""Write the description of a robot into the ROS package that contains its source, with a test that compares both.

Files of the package stay as they are; lines to add to or change in them are printed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output import open_package_folder
from rosorin_compile.output.ros_packages import missing, package_of
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, error, listed
from rosorin_compile.source.files import is_file, is_folder, read_bytes, read_text, resolve
from rosorin_compile.source.load import LoadError, load_mapping
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map

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
    text_of,
)
from .rewrite_launch import Line, lines_to_change

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
    """The result of writing a description into a package.

    ``written`` are new or changed files, ``kept`` existing files that differ. ``add`` are lines to add, by file, and
    ``change`` lines of launch files to change. ``has_test``: the test compares this description. ``refused`` are the
    errors if nothing is written. ``merged`` is the result for a description that existed, ``others`` are robots that
    include a changed file, too.
    """

    test: str
    written: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    add: Mapping[str, Sequence[str]] = {}
    change: Sequence[Line] = ()
    has_test: bool = True
    refused: Sequence[Diagnostic] = ()
    merged: Merged | None = None
    others: Sequence[str] = ()


def package_at(folder: Path) -> Package:
    """Return the package in a folder. Raises RequestError where there is none."""
    if not is_folder(folder):
        raise RequestError(f"{folder} is no folder; --into names the folder of a ROS package")
    found = package_of(folder)
    if found is None or found[0] != resolve(folder):
        way = (
            f"; did you mean {found[0]}?" if found else "; to write a package of its own: rosorin-compile package ROBOT"
        )
        raise RequestError(f"{folder} is no ROS package: it has no package.xml with a name{way}")
    said = _BUILD_TYPE.search(_text(folder / "package.xml"))
    build_type = said[1] if said else ""
    if build_type not in (CMAKE, PYTHON):
        help = "add <export><build_type>ament_cmake</build_type></export>" if not said else "only those two are known"
        was = f'its build type is "{build_type}"' if said else "its package.xml says no build type"
        raise RequestError(f"{folder} is not built by ament_cmake or ament_python: {was}; {help}")
    return Package(folder, found[1], build_type)


def inside(source: Path, package: Package) -> str:
    """Return a source as seen from the package that it is in. Raises RequestError for one that is elsewhere."""
    try:
        return resolve(source).relative_to(resolve(package.folder)).as_posix()
    except ValueError:
        own = package_of(resolve(source).parent)
        way = f"; it is in package {own[1]}: --into {own[0]}" if own else "; copy it there, or name its package"
        message = f"{source} is not in {package.folder}: the test that is written holds both against each other"
        raise RequestError(f"{message}{way}") from None


def _places(name: str) -> tuple[str, str]:
    """Return the folder of a description in its package, and its test."""
    return f"{Description.FOLDER}/{name}", f"test/test_{_NO_WORD.sub('_', name).lower()}_description.py"


def _arguments(root: Path) -> frozenset[str]:
    """Return the names of the arguments that a description declares."""
    try:
        declared = load_mapping(root, root.name).get("args")
    except LoadError:
        return frozenset()
    return frozenset(declared) if isinstance(declared, Map) else frozenset()


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
    description, test = _places(name)
    folder = package.folder / description
    with open_package_folder(package.folder) as target:
        merged = _merged(package, description, files, request) if _has_files(folder) else None
        if merged and merged.refused:
            return Put(test, refused=merged.diagnostics)
        texts = merged.files if merged else {**files, **_records(folder, files, request)}
        wanted = {os.path.normpath(f"{description}/{file}"): text.encode() for file, text in texts.items()}
        record = f"{description}/{Description.ROOT_FILE}{ENDING}"
        wanted[test] = _test(package, source, f"{description}/{Description.ROOT_FILE}", arguments).encode()
        kept = [
            file
            for file, data in wanted.items()
            if _differs(package.folder / file, data) and (file == test or not (merged or is_record(file)))
        ]
        # The records are the manifest of the description, and that of robot.yaml is the last.
        order = sorted(wanted.keys() - kept, key=lambda file: (is_record(file), file == record, file))
        fresh = target.write({file: wanted[file] for file in order}, manifest=False)
        if merged:
            remove(folder, merged)
    change = lines_to_change(package.folder, source, description, _arguments(folder / Description.ROOT_FILE))
    add = {file: lines for file, lines in _to_add(package, description, test, files).items() if lines}
    written = tuple(file for file in fresh if not is_record(file))
    others = _others(package.folder, name, written) if merged else []
    has_test = f"{description}/{Description.ROOT_FILE}" in _text(package.folder / test)
    return Put(test, written, tuple(kept), add, change, has_test, (), merged, others)


def _has_files(folder: Path) -> bool:
    return is_folder(folder) and any(folder.iterdir())


def _records(there: Path, files: Mapping[str, str], request: Request) -> dict[str, str]:
    """Return the record of a new robot; that of a file of others stays as it is."""
    made = record_of(files, request.words)
    for file in files:
        record = Path(os.path.normpath(there / f"{file}{ENDING}"))
        if file.startswith("../") and is_file(record):
            made[f"{file}{ENDING}"] = text_of(record)
    return made


def _merged(package: Package, description: str, files: Mapping[str, str], request: Request) -> Merged:
    """Merge the new state of a source with its description in a package. Raises RequestError."""
    folder = package.folder / description
    previous = read_record(folder, files)
    if previous is not None and not is_same_source(previous.words, request.words):
        message = (
            f'"{folder.name}" is taken in {package.name}: {description} was imported from '
            f"{source_of(previous.words)}, and this is {source_of(request.words)}"
        )
        help = f"give this robot another name with --name, or remove {description} to replace it"
        return Merged({}, {}, [], [error("import-name-taken", message, None, help)], [], refused=True)
    record = recorded(folder, request.words, files)
    if record is not None:
        return import_again(folder, record, files, request)
    others = [file for file, text in files.items() if _differs(folder / file, text.encode())]
    if not others:  # it is equal, or an import was killed before it had written all files
        absent = {file: text for file, text in files.items() if not os.path.lexists(folder / file)}
        return Merged({}, {**absent, **record_of(files, request.words)}, [], [], [])
    message = (
        f"{description} differs from what would be imported ({listed(others)}), and has no "
        f"{Description.ROOT_FILE}{ENDING}, so that changes cannot be merged"
    )
    help = f"import it beside this one with --name, or the source as it was then with -o, and copy the {ENDING} files"
    return Merged({}, {}, [], [error("import-no-record", message, None, help)], [], refused=True)


def _others(package: Path, name: str, written: Sequence[str]) -> list[str]:
    """Return the other descriptions of a package that include what was written for one of them, too."""
    names = [
        f"../{file.removeprefix(f'{Description.FOLDER}/')}"
        for file in written
        if file.startswith(f"{Description.FOLDER}/")
    ]
    found = (
        path
        for path in sorted((package / Description.FOLDER).glob(f"*/{Description.ROOT_FILE}"))
        if path.parent.name != name
    )
    return [path.parent.name for path in found if any(one in _text(path) for one in names)]


def _differs(path: Path, data: bytes) -> bool:
    """Return True if there is another file at a path."""
    return os.path.lexists(path) and not (is_file(path) and read_bytes(path) == data)


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""


def _test(package: Package, source: str, description: str, given: Mapping[str, str]) -> str:
    """Return the test that holds a description against its source."""
    from rosorin_compile.formats.templating import Templates

    values = {
        "source": source,
        "description": description,
        "given": dict(given),
        "name": package.name,
        "registry": f"{package.registry} and package.xml",
        "literal": repr,
    }
    return Templates().own("importing/test.py.jinja", values)


def _to_add(package: Package, description: str, test: str, files: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the lines that the files of a package lack, by file."""
    names = [os.path.normpath(f"{description}/{file}") for file in files]
    absent = [file for file, _ in missing(package.folder, package.name, names)]
    manifest = _text(package.folder / "package.xml")
    if package.build_type == PYTHON:
        rows: dict[str, list[str]] = {}
        for file in absent:
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {files})," for folder, files in rows.items()]
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
    return "/".join(file.split("/")[:2]) if file.startswith(f"{Description.FOLDER}/") else file


def package_report(package: Package, put: Put) -> Iterator[str]:
    """Yield the lines about what was put into a package."""
    name = resolve(package.folder).name
    if put.written:
        places = dict.fromkeys(_place(file) for file in put.written)
        yield f"{name}: written: {', '.join(places)}"
    for file in put.kept:
        yield f"{name}: {file} is there with changes of its own, and stays as it is"
    if not put.written and not put.kept:
        yield f"{name}: unchanged"
    yield from put.merged.lines if put.merged else ()
    if put.others:
        yield f"{name}: {listed(put.others)} includes what was changed, too: import that again"


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
        taken = "rosorin-compile print FILE urdf"
        yield f"no launch file here names {Path(source).name}: where it is expanded, take {taken}"
    if put.has_test:
        yield f"{listed([source])} stays; {put.test} holds both against each other: colcon test, or pytest"
    else:
        yield f"{listed([source])} stays; {put.test} is not the test that import writes: see what it holds against what"

"""Write the description of a robot into the ROS package that contains its source, with a test that compares both.

Files of the package stay as they are; lines to add to or change in them are printed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output import open_package_folder
from rosorin_compile.output.package_folder import files_below, is_launch_file, missing, package_of
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, error, phrase
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
_OURS = f"{Description.FOLDER}/"
_NO_WORD = re.compile(r"\W+")
_COMMENTS = ("#", "<!--")
_LARGEST = 1_000_000  # bytes of a launch file
_MOST_PACKAGES = 200
_MOST_LINES = 20


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
    description, test = f"{Description.FOLDER}/{name}", f"test/test_{_NO_WORD.sub('_', name).lower()}_description.py"
    folder, root = package.folder / description, f"{description}/{Description.ROOT_FILE}"
    with open_package_folder(package.folder) as target:
        merged = None
        if is_folder(folder) and any(folder.iterdir()):
            merged = _merged(package, description, files, request)
            if merged.refused:
                return Put(diagnostics=merged.diagnostics)
        texts = merged.files if merged else {**files, **record_of(files, request.words)}
        data = {f"{description}/{file}": text.encode() for file, text in texts.items()}
        data[test] = _test(package, source, root, arguments).encode()
        kept = [
            file
            for file in data
            if _differs(package.folder / file, data[file]) and (file == test or not (merged or is_record(file)))
        ]
        # The records are the manifest of the description, and that of robot.yaml is the last.
        order = sorted(data.keys() - kept, key=lambda file: (is_record(file), file == f"{root}{ENDING}", file))
        written = target.write({file: data[file] for file in order}, manifest=False)
        if merged:
            remove(folder, merged)
    written = tuple(file for file in written if not is_record(file))
    name = resolve(package.folder).name
    places = ["/".join(file.split("/")[:2]) if file.startswith(_OURS) else file for file in written]
    report = [f"{name}: written: {', '.join(dict.fromkeys(places))}"] if written else []
    report += [f"{name}: {file} was edited, and stays as it is" for file in kept]
    report += [] if report else [f"{name}: unchanged"]
    report += merged.lines if merged else []
    to_do = list(_to_add(package, description, test, files))
    lines = list(_lines_with(Path(source).name, package.folder))[:_MOST_LINES]
    command = f"rosorin-compile print {root} urdf"
    if lines:
        to_do += [f"expand the description by {command} instead of the source in:", *(f"  {line}" for line in lines)]
    after = [] if lines else [f"no launch file names {Path(source).name}; to expand the description: {command}"]
    compares = "was edited and may compare something else" if test in kept else "compares both"
    after.append(f"{phrase([source])} stays; {test} {compares}: colcon test, or pytest")
    is_new = merged is None and any(file.startswith(_OURS) for file in written)
    return Put(written, report, to_do, after, merged.diagnostics if merged else (), is_new)


def _merged(package: Package, description: str, files: Mapping[str, str], request: Request) -> Merged:
    """Merge the new state of a source with its description in a package. Raises RequestError."""
    folder = package.folder / description
    previous = read_record(folder)
    if previous is not None and not is_same_source(previous.words, request.words):
        message = (
            f'"{folder.name}" is taken in {package.name}: {description} was imported from '
            f"{source_of(previous.words)}, and this is {source_of(request.words)}"
        )
        help = f"give this robot another name with --name, or remove {description} to replace it"
        return Merged.refuse(error("import-name-taken", message, None, help))
    record = recorded(folder, request.words)
    if record is not None:
        return import_again(folder, record, files, request)
    others = [file for file, text in files.items() if _differs(folder / file, text.encode())]
    if not others:  # it is equal, or an import was killed before it had written all files
        absent = {file: text for file, text in files.items() if not os.path.lexists(folder / file)}
        return Merged({}, {**absent, **record_of(files, request.words)}, [], [], [])
    message = (
        f"{description} differs from the import ({phrase(others)}), and has no "
        f"{Description.ROOT_FILE}{ENDING}, so that changes cannot be merged"
    )
    help = f"give this import another --name, or import the earlier source with -o, and copy its {ENDING} files"
    return Merged.refuse(error("import-no-record", message, None, help))


def _differs(path: Path, data: bytes) -> bool:
    """Return True if there is another file at a path."""
    return os.path.lexists(path) and not (is_file(path) and read_bytes(path) == data)


def _text(path: Path) -> str:
    return read_text(path, errors="replace") if is_file(path) else ""


def _test(package: Package, source: str, description: str, arguments: Mapping[str, str]) -> str:
    """Return the test that compares a description with its source."""
    from rosorin_compile.formats.templating import Templates

    values = {
        "source": source,
        "description": description,
        "given": dict(arguments),
        "name": package.name,
        "registry": f"{package.registry} and package.xml",
        "literal": repr,
    }
    return Templates().own("importing/test.py.jinja", values)


def _to_add(package: Package, description: str, test: str, files: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines that the files of a package lack, below the names of the files."""
    absent = [file for file, _ in missing(package.folder, package.name, [f"{description}/{file}" for file in files])]
    registry = _text(package.folder / package.registry)
    if package.build_type == PYTHON:
        rows: dict[str, list[str]] = {}
        for file in absent:
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {files})," for folder, files in rows.items()]
        if "pytest" not in registry:  # colcon requires it to run pytest
            install.append("extras_require={'test': ['pytest']},")
        depends = "python3-pytest"
    else:
        install = ["install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})"] if absent else []
        if not re.search(rf"ament_add_pytest_test\s*\([^()]*\b{re.escape(test)}", re.sub(r"#[^\n]*", "", registry)):
            install += ["if(BUILD_TESTING)", "  find_package(ament_cmake_pytest REQUIRED)"]
            install += [f"  ament_add_pytest_test({Path(test).stem} {test})", "endif()"]
        depends = "ament_cmake_pytest"
    is_declared = re.search(rf"<(test_|build_)?depend[^<>]*>\s*{depends}\s*<", _text(package.folder / "package.xml"))
    needs = [] if is_declared else [f"<test_depend>{depends}</test_depend>"]
    for file, lines in ((package.registry, install), ("package.xml", needs)):
        if lines:
            yield f"add to {package.folder / file}:"
            yield from (f"  {line}" for line in lines)


def _lines_with(name: str, package: Path) -> Iterator[str]:
    """Yield the lines with a file name in launch files and CMakeLists.txt of a package and those next to it."""
    root = resolve(package)
    with suppress(OSError):
        others = [one for one in sorted(root.parent.iterdir()) if is_file(one / "package.xml") and resolve(one) != root]
        for folder in [package, *others[:_MOST_PACKAGES]]:
            for file in files_below(folder, skip_built=True):
                path = folder / file
                is_build_file = is_launch_file(file) or file == "CMakeLists.txt"
                if not is_build_file or path.stat().st_size > _LARGEST:
                    continue
                for number, line in enumerate(_text(path).split("\n"), 1):
                    has_name = re.search(rf"(?<![\w.-]){re.escape(name)}", line)
                    if has_name and not line.lstrip().startswith(_COMMENTS):
                        place = os.path.normpath(package / os.path.relpath(path, package))
                        yield f"{place}:{number}: {line.strip()}"

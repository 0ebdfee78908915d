"""Into: the description of a robot put into the ROS package that has its xacro, beside it.

A test holds both against each other until the xacro is removed. What is there already stays to the byte: lines for
CMakeLists.txt, setup.py, package.xml and launch files are told, and written by whoever maintains them.
"""

from __future__ import annotations

import ast
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output import open_package_folder
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, error, listed
from rosorin_compile.source.files import is_file, is_folder, read_bytes, read_text, resolve
from rosorin_compile.source.load import LoadError, load_mapping
from rosorin_compile.source.project import Description
from rosorin_compile.source.ros_packages import missing, package_of
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map

from .reimport import ENDING, Merged, Request, import_again, is_record, record_of, recorded, remove, text_of
from .rewrite_launch import Line, lines_to_change
from .translating.uniting import with_more

RULES = (
    Rule(
        "import-name-taken",
        "The package has a description or a test of this name that was imported from another source, with other "
        "arguments, or does not say from what; nothing is written.",
        "`--name` gives this robot a name of its own. To import the other one anew, remove its description and test.",
        Heading.READING,
    ),
    Rule(
        "import-no-record",
        "The package has a description of this source that stands otherwise than it would be imported, and nothing "
        "says how it was imported: what somebody changed in it cannot be told from what the source changed; nothing is "
        "written.",
        "`--name` imports it beside that one. Or import the source as it was then with `-o`, and put the `.imported` "
        "files that come of it beside those of the description.",
        Heading.READING,
    ),
)

CMAKE, PYTHON = "ament_cmake", "ament_python"
_BUILD_TYPE = re.compile(r"<build_type[^<>]*>\s*([^<\s]+)\s*</build_type>")
_NO_WORD = re.compile(r"\W+")
_NAME = re.compile(r"[\w-]+")
_SAID = ("SOURCE", "OF_THE_SOURCE", "DESCRIPTION")  # what the test calls them


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

    ``add`` are lines by the file that they belong to, ``change`` lines of launch files. ``holds`` says whether the test
    is one of this source. ``refused`` is why nothing was put,
    ``again`` what came of it where the description was there. ``others`` are robots that have a changed file, too.
    """

    written: tuple[str, ...]
    kept: tuple[str, ...]
    add: Mapping[str, Sequence[str]]
    change: Sequence[Line]
    test: str
    holds: bool = True
    refused: Sequence[Diagnostic] = ()
    again: Merged | None = None
    others: Sequence[str] = ()


class Said(NamedTuple):
    """What a test says of itself: the file that a description was imported from, with what, and that description."""

    source: str
    given: Mapping[str, str]
    description: str

    @property
    def words(self) -> str:
        """The source as it was named on the command line."""
        return " ".join([self.source, *(f"{name}:={value}" for name, value in self.given.items())])


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


def _taken(package: Package, wanted: Said, name: str, files: Mapping[str, str], tree: Map) -> Diagnostic | None:
    """Return the error that a name is that of another robot of a package; None where it is free, or this robot's."""
    description, test = _places(name)
    why = _why_taken(package.folder, wanted, test, files, (tree.get("source") or {}).get("note"))
    if not why:
        return None
    own = Path(wanted.source).name.partition(".")[0]
    own = own if _NAME.fullmatch(own) and own != name else "NAME"
    there = " and ".join(one for one in (description, test) if os.path.lexists(package.folder / one))
    help = f"give this robot a name of its own, such as --name {own}; to import it under this one, remove {there}"
    span = tree.value_spans.get("robot", tree.span)
    return error("import-name-taken", f'"{name}" is taken in {package.name}: {why}', span, help)


def _why_taken(folder: Path, wanted: Said, test: str, files: Mapping[str, str], note: str | None) -> str:
    """Return why a description is not to be taken for that of a source; empty if it is, or is not there.

    Where no test says what it was imported from, it is the same one where it stands as it would be written, or where
    it has the same ``note`` of its source and that takes no arguments.
    """
    said, root = _said(folder / test), folder / wanted.description
    description = f"{Description.FOLDER}/{root.parent.name}"
    if said is not None and said != wanted:
        return f"{test} says that {said.description} was imported from {said.words}, and this is {wanted.words}"
    if not _has_files(root.parent):
        return ""
    if not is_file(root):
        return f"{description} is there, without a {root.name}"
    if said is not None or not any(_differs(root.parent / file, text.encode()) for file, text in files.items()):
        return ""
    own = _note(root)
    if own != note:
        what = f"says that it is {own}" if own else "does not say what it was imported from"
        return f"{description} {what}, and this is {wanted.words}"
    return f"no test says that {description} was imported from {wanted.words}" if wanted.given else ""


def _said(test: Path) -> Said | None:
    """Return what a test says that it holds against each other; None if it is not there, or says nothing of it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of whoever wrote it
            body = ast.parse(_text(test)).body
        found = {
            node.targets[0].id: ast.literal_eval(_in_package(node.value))
            for node in body
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id in _SAID
        }
        source, given, description = (found[name] for name in _SAID)
        return Said(str(source), {str(name): str(value) for name, value in given.items()}, str(description))
    except (SyntaxError, ValueError, TypeError, LookupError, AttributeError, RecursionError, MemoryError):
        return None


def _in_package(value: ast.expr) -> ast.expr:
    """Return the path of ``PACKAGE / path``; another value as it is."""
    return value.right if isinstance(value, ast.BinOp) and isinstance(value.left, ast.Name) else value


def _note(root: Path) -> str | None:
    """Return what a description says that it is from."""
    try:
        source = load_mapping(root, root.name).get("source")
    except LoadError:
        return None
    note = source.get("note") if isinstance(source, Map) else None
    return note if isinstance(note, str) else None


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
    given: Mapping[str, str],
    name: str,
    files: Mapping[str, str],
    tree: Map,
    asked: Request,
    grown: Mapping[str, str] = {},
) -> Put:
    """Put the files of a description into a package, all or nothing. Raises OutputError, RequestError.

    ``source`` is the file that it was imported from, seen from the package, with what it was ``given``; ``tree`` is
    that of the description. Nothing is put where the name is that of another robot there. A description of the source
    that is there is put together with the new state of it, as ``asked``; other files that are there stay. ``grown`` are
    files of other robots that have more now, by what they were: only what is still that is replaced.
    """
    description, test = _places(name)
    there = package.folder / description
    with open_package_folder(package.folder) as target:
        taken = _taken(package, Said(source, dict(given), f"{description}/{Description.ROOT_FILE}"), name, files, tree)
        again = None if taken or not _has_files(there) else _again(package, description, files, asked)
        refused = [taken] if taken else again.diagnostics if again and again.refused else []
        if refused:
            return Put((), (), {}, (), test, refused=refused)
        made = again.files if again else {**files, **_records(there, files, grown, asked)}
        wanted = {os.path.normpath(f"{description}/{file}"): text.encode() for file, text in made.items()}
        record = f"{description}/{Description.ROOT_FILE}{ENDING}"
        wanted[test] = _test(package, source, f"{description}/{Description.ROOT_FILE}", given).encode()
        more = {os.path.normpath(f"{description}/{file}"): text.encode() for file, text in grown.items()}
        kept = [
            file
            for file in wanted
            if _differs(package.folder / file, wanted[file])
            and (file == test or not (again or is_record(file)))
            and (file not in more or _differs(package.folder / file, more[file]))
        ]
        # The records are the manifest of the description, and its own is the last.
        order = sorted(wanted.keys() - kept, key=lambda file: (is_record(file), file == record, file))
        fresh = target.write({file: wanted[file] for file in order}, manifest=False)
        if again:
            remove(there, again)
    change = lines_to_change(package.folder, source, description, _arguments(there / Description.ROOT_FILE))
    add = {file: found for file, found in _to_add(package, description, test, files).items() if found}
    written = tuple(file for file in fresh if not is_record(file))
    others = _others(package.folder, name, written) if again else []
    holds = _said(package.folder / test) is not None
    return Put(written, tuple(kept), add, change, test, holds, (), again, others)


def _has_files(folder: Path) -> bool:
    return is_folder(folder) and any(folder.iterdir())


def _records(there: Path, files: Mapping[str, str], grown: Mapping[str, str], asked: Request) -> dict[str, str]:
    """Return the record of a new robot; that of a file of others has what it adds, and not what somebody changed."""
    made = record_of(files, asked.words)
    for file in files:
        record = Path(os.path.normpath(there / f"{file}{ENDING}"))
        if file.startswith("../") and is_file(record):
            before = text_of(record)
            made[f"{file}{ENDING}"] = with_more(before, grown[file], files[file]) if file in grown else before
    return made


def _again(package: Package, description: str, files: Mapping[str, str], asked: Request) -> Merged:
    """Put the description that is there and what its source says now together. Raises RequestError."""
    there = package.folder / description
    record = recorded(there, asked.words, files)
    if record is not None:
        return import_again(there, record, files, asked)
    others = [file for file, text in files.items() if _differs(there / file, text.encode())]
    if not others:  # it is as it would be imported, or an import was killed before it had written all files
        missing = {file: text for file, text in files.items() if not os.path.lexists(there / file)}
        return Merged({}, {**missing, **record_of(files, asked.words)}, [], [], [])
    called = f"{Description.ROOT_FILE}{ENDING}"
    message = (
        f"{description} stands otherwise than it would be imported ({listed(others)}), and no {called} "
        "there says how it was imported: what the source changed cannot be told from what was changed here"
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
    """Say whether another file stands at a path."""
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
    yield from put.again.lines if put.again else ()
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
    if put.holds:
        yield f"{listed([source])} stays; {put.test} holds both against each other: colcon test, or pytest"
    else:
        yield f"{listed([source])} stays; {put.test} is not the test that import writes: see what it holds against what"

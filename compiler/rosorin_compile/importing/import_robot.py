"""Import a robot: convert a URDF, xacro, SDF or MJCF to a description, compare both, and write the description."""

import os
import re
import shlex
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Format
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions, file_name
from rosorin_compile.formats.robot_files import join, read_robot
from rosorin_compile.model.joint import MOVING_TYPES
from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.output.atomic_files import OutputError
from rosorin_compile.output.package_folder import open_package_folder
from rosorin_compile.request import FilePath, Packages, Values, Warn, read_options
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, RequestError, count_of, error, has_errors
from rosorin_compile.source.files import exists, is_file, is_folder, read_bytes, read_text, resolve
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import package_of
from rosorin_compile.source.project import Description, no_file
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import suggest

from .description import write
from .elements.convert import ConvertedRobot, put_values, report_elements, with_sections
from .mesh_names import rename_files
from .reimport import ENDING, MergeResult, import_again, is_record, read_record, record_of, remove
from .round_trip import RoundTrip, check_round_trip, schema_path
from .xacro.translate import Target, translate

_MJCF = "mjcf"
_TAG = re.compile(r"(?:\s|<!--.*?-->)*<([^\s/>!?]+)", re.DOTALL)  # matches the first tag of an XML string
_REGISTRY = {"ament_cmake": "CMakeLists.txt", "ament_python": "setup.py"}  # build type -> build file
_BUILD_TYPE = re.compile(r"<build_type[^<>]*>\s*([^<\s]+)\s*</build_type>")
_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")


# (names of the written files, lines to add to other files of the package, next steps for the user)
_Written = tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]


@dataclass(frozen=True)
class ImportResult:
    """The result of ``import_robot``: the written files, a report and diagnostics."""

    source: Annotated[str, "the file that was imported"]
    robot: Annotated[str, "its name"] = ""
    folder: Annotated[str, "where the description is"] = ""
    written: Annotated[tuple[str, ...], "the files that are new or changed, relative to the folder"] = ()
    report: Annotated[tuple[str, ...], "what was converted and compared, in sentences"] = ()
    to_do: Annotated[tuple[str, ...], "with `--into`: lines to add to or change in files of the package"] = ()
    next_steps: Annotated[tuple[str, ...], "what to do next, in sentences"] = ()
    inputs: Annotated[tuple[str, ...], "the files that were read"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


class _Package(NamedTuple):
    """The ROS package to which the description is written; ``source`` is the robot file, relative to ``folder``."""

    folder: Path
    name: str
    build_type: str
    source: str


def companions() -> list[Format]:
    """Return the formats that extend a robot in another format; for example, SRDF extends a URDF."""
    return [format for format in FORMATS.values() if format.join is not None]


def import_robot(
    source: FilePath,
    into: FilePath | None = None,
    arguments: Values = None,
    packages: Packages = None,
    *,
    output: FilePath | None = None,
    name: str | None = None,
    meshes: str | None = None,
    companions: Mapping[str, FilePath] | None = None,
    strict: bool = False,
    lenient: bool = False,
    parts: bool = True,
    verbatim: bool = False,
    flat: bool = False,
    drives: str | None = None,
    force: bool = False,
    keep_edits: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ImportResult:
    """Convert a URDF, xacro, SDF or MJCF file to a description, and write it unless an error is found.

    The description is compiled and compared with the source before it is written. If the folder already contains a
    description of the same source, changes of the source are merged with edits of the description. If ``diagnostics``
    of the result has errors and ``written`` is empty, nothing was written.

    Args:
        source: The file of the robot.
        into: The folder of the ROS package that contains ``source``. The description is written to ``descriptions/`` in
            this package, with a test that compares it with ``source``.
        output: The folder of the description if ``into`` is not set; by default ``descriptions/ROBOT``.
        name: The name of the robot; by default the name in ``source``.
        meshes: A prefix for relative mesh file names: a folder relative to the artifacts, or ``package://NAME``.
        companions: Files that extend the robot, by format: ``{"srdf": "robot.srdf"}``.
        strict: Treat unsupported elements as errors.
        lenient: Accept violations of the specification where possible.
        parts: Write repeated structures once, as parts.
        verbatim: Copy the Gazebo and ros2_control elements of a URDF unchanged.
        flat: Import the URDF that a xacro generates, without its macros.
        drives: The servos to add to the MJCF if the robot has no actuators: ``"position"`` (default; joints without
            limits get velocity servos), ``"velocity"`` or ``"none"``.
        force: Write to a folder that is not empty.
        keep_edits: If the same lines changed in the source and in the description, keep the lines of the description.
    """
    reading, wrong = read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return ImportResult(str(source), diagnostics=tuple(wrong))
    source = source if isinstance(source, Path) else Path(source)
    others = {format: Path(file) for format, file in (companions or {}).items()}
    package = _check_options(source, others, into, output, force, name, meshes)
    if package is not None:
        reading = reading._replace(packages={package.name: package.folder, **reading.packages})
    # Record the arguments that affect the result, because a repeated import must use the same arguments.
    options = {"name": name, "meshes": meshes, "drives": drives}
    flags = {"--no-parts": not parts, "--verbatim": verbatim, "--flat": flat}
    words = [package.source if package else source.name, *(f"{key}:={text}" for key, text in reading.arguments.items())]
    words += [word for key, value in options.items() if value is not None for word in (f"--{key}", value)]
    words += [flag for flag, is_set in flags.items() if is_set]
    words += [word for format, path in others.items() for word in (f"--{format}", path.name)]

    imported, diagnostics = _read(source, reading, others, strict)
    result = ImportResult(str(source), inputs=tuple(map(str, imported.files)), diagnostics=tuple(diagnostics))
    if imported.tree is None or has_errors(diagnostics):
        return result
    tree = _with_drives(imported.tree, drives, source)
    tree = tree if name is None else put_values(tree, {"robot": name})
    base = package.folder if package else Description.project_folder()
    folder = Path(output) if output is not None else base / Description.FOLDER / file_name(tree["robot"])
    result = replace(result, robot=tree["robot"], folder=str(folder))
    record = None if force else read_record(folder, words)
    if record is None and not force:
        help = "name a new folder with -o, or write into this one with --force"
        _check_folder(folder, "give this robot another name with --name" if package else help)
    keeps = imported.takes_arguments and not flat
    tree, renaming, prefix = rename_files(tree, source, folder, meshes, reading.packages, keeps)
    read = imported._replace(tree=tree)
    converted = ConvertedRobot(read) if verbatim else with_sections(read)
    try:
        trip = check_round_trip(converted.imported, folder, parts and not flat, converted.plain, reading.packages)
    except OSError as problem:
        reason = problem.strerror or type(problem).__name__
        message = f"cannot work in the temporary folder: {reason}; TMPDIR can name another one"
        return replace(result, diagnostics=(*diagnostics, error("output-failed", message, None)))
    untold = list(trip.untold)
    if reading.lenient and not strict:
        untold = [replace(one, severity=WARNING, help="please report it with the file") for one in untold]
    diagnostics += [*arrange(renaming), *arrange([*trip.diagnostics, *untold])]
    if has_errors(diagnostics):
        return replace(result, diagnostics=tuple(diagnostics))
    imported, files = converted.imported, trip.files
    lines, translated = [*_report_parts(trip), *report_elements(converted)], list[str]()
    if record is not None and (len(record) > 1) != (len(files) > 1):  # do not split or join an existing description
        files = write(trip.shown, trip.outputs, schema_path(folder), len(record) > 1)
    if keeps and source is not Description.ON_STDIN:
        target = Target(folder, schema_path(folder), name, prefix, package is not None)
        translation = translate(source, reading, read, trip.outputs, target)
        translated += translation.report
        if translation.files:  # a translated xacro keeps Gazebo and ros2_control elements as XML
            imported, files, lines = read, translation.files, []
    has_servos = "drive" not in tree and "drives" in trip.outputs.entries.get(_MJCF, {})
    if has_servos and "continuous" in [joint["type"] for joint in tree["joints"].values()]:
        lines.append("the base is fixed in the MJCF; if the wheels move the robot, set base: free in the MJCF output")
    report = [*_report(folder, imported, trip, files), *lines, *translated]
    if record is None:
        merged = MergeResult({**files, **record_of(files, words)})
    else:
        merged = import_again(folder, record, files, words, keep_edits)
    diagnostics += arrange(merged.diagnostics)
    if merged.refused:
        return replace(result, diagnostics=tuple(diagnostics))
    written, found = _write(folder, merged, package, reading.arguments, record is None)
    result = replace(result, diagnostics=(*diagnostics, *found))
    if written is None:
        return result
    paths, to_do, steps = written
    names = tuple(name for name in paths if not is_record(name))
    if record is not None:
        with suppress(OSError):  # a remaining file is harmless, because no file includes it
            remove(folder, merged)
        changed = [*names, *(f"{name} (removed)" for name in merged.removed if not is_record(name))]
        first = f"{folder}: written: {', '.join(changed)}" if changed else f"{folder}: unchanged"
        report = [first, *merged.lines]
    steps = steps if package or not has_errors(result.diagnostics) else ()
    return replace(result, written=names, report=tuple(report), to_do=to_do, next_steps=steps)


def _check_options(
    source: Path,
    companions: Mapping[str, Path],
    into: FilePath | None,
    output: FilePath | None,
    force: bool,
    name: str | None,
    meshes: str | None,
) -> _Package | None:
    """Validate files and options; return the ROS package at ``into``, or None without ``into``. Raises RequestError."""
    for path in (source, *companions.values()):
        try:
            if path is not Description.ON_STDIN and (is_folder(path) or not exists(path)):
                close = None if is_folder(path) else Description.nearest_file(path)
                help = suggest(str(close)) if close else "name the file of the robot in it" if is_folder(path) else ""
                raise RequestError(no_file(path) + (f"; {help}" if help else ""))
        except OSError as problem:
            raise RequestError(f"cannot read {path}: {problem.strerror}") from None
    if into is not None and (output is not None or force):
        word = "-o" if output is not None else "--force"
        raise RequestError(f"--into names the place, and what is there stays: leave {word} out")
    if into is not None and source is Description.ON_STDIN:
        raise RequestError("--into compares the description with a file: name it, not -")
    package = None if into is None else _package_at(Path(into), source)
    if name is not None and not (_NAME.fullmatch(name) and name.isprintable()):
        raise RequestError(f'"{name}" cannot be the name of a robot: no markup, no quotes, spaces only within')
    if meshes is not None and (not meshes.isprintable() or not meshes.strip() or meshes.endswith("://")):
        raise RequestError(f'--meshes "{meshes}" is neither a folder nor package://NAME')
    return package


def _read(
    source: Path, reading: ReadOptions, companions: Mapping[str, Path], strict: bool
) -> tuple[ImportedRobot, list[Diagnostic]]:
    imported = read_robot(source, reading)
    if reading.arguments and not imported.takes_arguments and imported.tree is not None:
        raise RequestError(f"{source} takes no arguments: only xacro files do")
    for format, path in companions.items():
        imported = join(imported, format, path, reading)
    found = imported.diagnostics
    if strict:
        found = [replace(one, severity=ERROR) if one.rule == "import-cannot-carry" else one for one in found]
    return imported, arrange(found)


def _with_drives(tree: Map, drives: str | None, source: Path) -> Map:
    """Add the servos of the option ``--drives`` to a robot without actuators. Raises RequestError for an MJCF."""
    outputs, joints = tree.get("outputs") or Map(tree.span), list((tree.get("joints") or {}).values())
    if _MJCF in outputs:
        if drives not in (None, "none"):
            raise RequestError(f"{source} is an MJCF, and its actuators are imported: leave --drives out")
        return tree
    has_actuators = "actuators" in tree or any("actuator" in joint for joint in joints)
    drives = drives or ("none" if has_actuators else "position")
    if drives == "none" or all(joint["type"] not in MOVING_TYPES for joint in joints):
        return tree
    return put_values(tree, {"outputs": put_values(outputs, {_MJCF: {"file": "robot.xml", "drives": drives}})})


def _write(
    folder: Path, merged: MergeResult, package: _Package | None, arguments: Mapping[str, str], is_new: bool
) -> tuple[_Written | None, list[Diagnostic]]:
    """Write the files of a description after backing up edited files; return (None, errors) on failure."""

    def judge(name: str, old: bytes, _: bytes) -> Literal["replace", "keep"]:
        return "replace" if is_record(name) or old == merged.before.get(name, "").encode() else "keep"

    try:
        if package is not None:
            return _write_into(package, folder.name, merged.files, arguments, is_new), []
        made = write_set(folder, merged.files, judge=judge)
    except OutputError as problem:
        return None, [problem.diagnostic]
    step = f"next: rosorin-compile all {shlex.quote(str(folder))}"
    return (made.written, (), (step,)), arrange(made.diagnostics(folder))


def _check_folder(folder: Path, help: str) -> None:
    """Raise RequestError if the folder is not empty, or if the path is a file."""
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"{folder} is not a folder; name a new one with -o")
    with suppress(OSError):  # an unreadable folder is reported when the files are written, with a better message
        if any(folder.iterdir()):
            message = f"{folder} is not empty; {help}"
            if (folder / Description.ROOT_FILE).is_file():
                record = f"{Description.ROOT_FILE}{ENDING}"
                message += f" (no {record} there says what was imported, so changes cannot be merged)"
            raise RequestError(message)


def _report(folder: Path, imported: ImportedRobot, trip: RoundTrip, files: Mapping[str, str]) -> list[str]:
    tree = imported.whole
    links, joints = len(tree.get("links") or ()), len(tree.get("joints") or ())
    report = [
        f"{folder}: {count_of(links, 'link')}, {count_of(joints, 'joint')} in {', '.join(files)}",
        f"the compiled {FORMATS.published_format().word} is the same robot",
    ]
    if trip.proof.said or trip.proof.unknown:
        report.append(trip.proof.said or f"not compared with the source in its engine: {trip.proof.unknown}")
    report += [f"no {name} among its outputs: {reason}" for name, reason in trip.outputs.left_out.items()]
    report += [f"its {FORMATS[name].word} is {remark}" for name, remark in trip.outputs.remarks.items()]
    tags = Counter(match[1] for text in _texts(tree) if (match := _TAG.match(text)))
    if tags:
        kept = (f"{tag} ({count})" if count > 1 else tag for tag, count in tags.items())
        report.append(f"kept as they are: {', '.join(kept)}")
    if accepted := tree.get("accept"):
        report.append(f"accepted: {', '.join(dict.fromkeys(entry['rule'] for entry in accepted))}")
    if count := len(imported.left_out):
        report.append(f"not carried over: {count}, see the {'warning' if count == 1 else 'warnings'} above")
    return report


def _report_parts(trip: RoundTrip) -> list[str]:
    tree = trip.shown.whole
    bodies = [tree, *(tree.get("parts") or {}).values()]
    uses = Counter(use["part"] for body in bodies for use in (body.get("use") or {}).values())
    if not uses:
        return []
    lines = ["parts: " + ", ".join(f"{part} ({count_of(count, 'use')})" for part, count in uses.items())]
    reordered = "the joints come in another order than in the source; --no-parts keeps it"
    return [*lines, reordered] if trip.reordered else lines


def _texts(node: Any) -> Iterator[str]:
    if isinstance(node, (Map, Seq)):
        for item in node.values() if isinstance(node, Map) else node:
            yield from _texts(item)
    elif isinstance(node, str):
        yield node


def _package_at(folder: Path, source: Path) -> _Package:
    """Return the ROS package at ``folder``. Raises RequestError if it is not a package or lacks ``source``."""
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
    return _Package(folder, found[1], match[1], resolve(source).relative_to(resolve(folder)).as_posix())


def _write_into(
    package: _Package, name: str, files: Mapping[str, str], arguments: Mapping[str, str], is_new: bool
) -> _Written:
    """Write a description and its test into a ROS package in one transaction. Raises OutputError.

    The result has lines that the user must add to existing files of the package if the description ``is_new``.
    """
    from rosorin_compile.formats.templating import Templates

    description, source = f"{Description.FOLDER}/{name}", package.source
    root, word = f"{description}/{Description.ROOT_FILE}", re.sub(r"\W+", "_", name).lower()
    test, registry = f"test/test_{word}_description.py", f"{_REGISTRY[package.build_type]} and package.xml"
    values = {"source": source, "description": root, "given": dict(arguments), "name": package.name}
    text = Templates().own("importing/test.py.jinja", {**values, "registry": registry, "literal": repr}).encode()
    with open_package_folder(package.folder) as target:
        path = package.folder / test
        is_edited = os.path.lexists(path) and not (is_file(path) and read_bytes(path) == text)
        # Write records (*.imported) last, and robot.yaml.imported at the very end, because it marks a complete import.
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
    return names, tuple(_lines_to_add(package, description, test, files)) if is_new else (), steps


def _lines_to_add(package: _Package, description: str, test: str, files: Mapping[str, str]) -> Iterator[str]:
    depends = "ament_cmake_pytest"
    install = [
        "install(DIRECTORY descriptions DESTINATION share/${PROJECT_NAME})",
        "if(BUILD_TESTING)",
        "  find_package(ament_cmake_pytest REQUIRED)",
        f"  ament_add_pytest_test({Path(test).stem} {test})",
        "endif()",
    ]
    if package.build_type == "ament_python":
        rows: dict[str, list[str]] = {}
        for file in sorted(f"{description}/{name}" for name in files if not is_record(name)):
            rows.setdefault(file.rpartition("/")[0], []).append(file)
        install = [f"('share/{package.name}/{folder}', {names})," for folder, names in rows.items()]
        install.append("extras_require={'test': ['pytest']},")  # without this key, colcon does not run pytest
        depends = "python3-pytest"
    tag = f"<test_depend>{depends}</test_depend>"
    for file, lines in {_REGISTRY[package.build_type]: install, "package.xml": [tag]}.items():
        yield f"add to {package.folder / file}, if it is not there:"
        yield from (f"  {line}" for line in lines)

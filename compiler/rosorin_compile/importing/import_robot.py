"""Import a robot: convert a URDF, xacro, SDF or MJCF to a description, prove it, and write it."""

from __future__ import annotations

import re
import shlex
import stat
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Literal

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Format
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import join, read_robot
from rosorin_compile.model.joint import MOVING_TYPES
from rosorin_compile.output import OutputError, WriteResult, write_set
from rosorin_compile.request import FilePath, Packages, Values, Warn, read_options
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, RequestError, error, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import suggest

from .description import tree_of, write
from .into import Package, inside, package_at, put_into
from .reimport import ENDING, Record, Request, import_again, is_record, record_of, recorded, remove
from .report import rename_files, report_accepted, report_kept, report_parts, sizes
from .round_trip import RoundTrip, check_round_trip, schema_beside
from .words import Worded, report_words, with_sections
from .xacro.translate import Target, translate

_MJCF = "mjcf"
_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")


@dataclass(frozen=True)
class _Options:
    """The options of ``import_robot``."""

    into: Path | None
    output: Path | None
    name: str | None
    meshes: str | None
    companions: Mapping[str, Path]
    strict: bool
    parts: bool
    verbatim: bool
    flat: bool
    drives: str | None
    force: bool
    ours: bool


@dataclass(frozen=True)
class ImportResult:
    """The description that an import wrote."""

    source: Annotated[str, "the file that was imported"]
    robot: Annotated[str, "its name"] = ""
    folder: Annotated[str, "where the description is"] = ""
    written: Annotated[tuple[str, ...], "the files that are new or changed, relative to the folder"] = ()
    report: Annotated[tuple[str, ...], "what was converted and compared, in sentences"] = ()
    to_do: Annotated[tuple[str, ...], "with `--into`: lines to add to or change in files of the package"] = ()
    next_steps: Annotated[tuple[str, ...], "what to do next, in sentences"] = ()
    inputs: Annotated[tuple[str, ...], "the files that were read"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def companions() -> list[Format]:
    """Return the formats of files that add to a robot in another file, such as SRDF."""
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

    The description is compiled and compared with the source before it is written. If the folder has the description of
    an earlier import of the same source, the changes of both are merged. Nothing was written if ``diagnostics`` of the
    result has errors and ``written`` is empty.

    Args:
        source: The file of the robot.
        into: The folder of the ROS package that contains ``source``. The description is written to its
            ``descriptions/``, with a test that compares both.
        output: The folder of the description without ``into``; by default ``descriptions/ROBOT``.
        name: The name of the robot; by default that of ``source``.
        meshes: The prefix of relative mesh names: a folder relative to the artifacts, or ``package://NAME``.
        companions: Files that add to the robot, by format: ``{"srdf": "robot.srdf"}``.
        strict: Treat unsupported elements as errors.
        lenient: Accept violations of the specification where possible.
        parts: Factor repeated structures into parts.
        verbatim: Copy the Gazebo and ros2_control elements of a URDF unchanged.
        flat: Import the URDF that a xacro generates, without its macros.
        drives: Servos that the MJCF gets for a robot without actuators: ``"position"`` (for joints with limits; the
            others get velocity servos), ``"velocity"`` or ``"none"``; by default ``"position"``.
        force: Write to a folder that is not empty.
        keep_edits: If both the source and the description changed the same lines, keep those of the description.
    """
    reading, wrong = read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return ImportResult(str(source), diagnostics=tuple(wrong))
    package, folder = (Path(path) if path is not None else None for path in (into, output))
    files = {format: Path(file) for format, file in (companions or {}).items()}
    options = _Options(package, folder, name, meshes, files, strict, parts, verbatim, flat, drives, force, keep_edits)
    path = source if isinstance(source, Path) else Path(source)
    if path is not Description.ON_STDIN:
        _check_file(path)
    return _Import(path, options, reading).run()


def _check_file(path: Path) -> None:
    """Raise RequestError if a path is not a file."""
    try:
        is_folder = stat.S_ISDIR(path.stat().st_mode)
    except PermissionError as problem:
        raise RequestError(f"cannot read {path}: {problem.strerror}") from None
    except (OSError, ValueError):
        close = Description.nearest_file(path)
        raise RequestError(f"{path} is not there" + (f"; {suggest(str(close))}" if close else "")) from None
    if is_folder:
        raise RequestError(f"{path} is a folder; name the file of the robot in it")


class _Import:
    """One import: the source with the options, and the diagnostics so far."""

    def __init__(self, source: Path, options: _Options, reading: ReadOptions) -> None:
        self.source, self.options = source, options
        self.diagnostics: list[Diagnostic] = []
        self.package, self.name_in_package = self._package()
        own = {self.package.name: self.package.folder} if self.package is not None else {}
        self.reading = replace(reading, packages={**own, **reading.packages})
        name, meshes = options.name, options.meshes
        if name is not None and not (_NAME.fullmatch(name) and name.isprintable()):
            raise RequestError(f'"{name}" cannot be the name of a robot: no markup, no quotes, spaces only within')
        if meshes is not None and (not meshes.isprintable() or not meshes.strip() or meshes.endswith("://")):
            raise RequestError(f'--meshes "{meshes}" is neither a folder nor package://NAME')
        self.request = Request(self._command_line(), options.ours)

    def _package(self) -> tuple[Package | None, str]:
        """Return the package that gets the description, and the source relative to it. Raises RequestError."""
        options = self.options
        if options.into is None:
            return None, ""
        if options.output is not None or options.force:
            word = "-o" if options.output is not None else "--force"
            raise RequestError(f"--into names the place, and what is there stays: leave {word} out")
        if self.source is Description.ON_STDIN:
            raise RequestError("--into compares the description with a file: name it, not -")
        package = package_at(options.into)
        return package, inside(self.source, package)

    def _command_line(self) -> list[str]:
        """Return the words of the command line that determine what is written; the next import needs the same."""
        options = self.options
        words = [self.name_in_package or self.source.name]
        words += [f"{name}:={value}" for name, value in self.reading.arguments.items()]
        values = {"--name": options.name, "--meshes": options.meshes, "--drives": options.drives}
        words += [word for name, value in values.items() if value is not None for word in (name, value)]
        flags = {"--no-parts": not options.parts, "--verbatim": options.verbatim, "--flat": options.flat}
        words += [flag for flag, is_set in flags.items() if is_set]
        return words + [word for name, path in options.companions.items() for word in (f"--{name}", path.name)]

    def run(self) -> ImportResult:
        """Read, convert, prove and write. Raises RequestError."""
        options, imported = self.options, self._read()
        result = ImportResult(str(self.source), inputs=tuple(map(str, imported.files)))
        if imported.tree is None or has_errors(self.diagnostics):
            return self._end(result)
        tree = imported.tree if options.name is None else _with(imported.tree, "robot", options.name)
        base = self.package.folder if self.package else Description.around()
        folder = options.output or Path(base, Description.FOLDER, imported._replace(tree=tree).file_name)
        result = replace(result, robot=tree["robot"], folder=str(folder))
        record = recorded(folder, self.request.words) if self.package is None and not options.force else None
        if self.package is None and record is None:
            _check_folder(folder, options.force)
        keeps = imported.takes_arguments and not options.flat
        named = rename_files(tree, self.source, folder, options.meshes, self.reading.packages, keeps)
        self.diagnostics += arrange(named.diagnostics)
        read = imported._replace(tree=named.tree)
        in_words = Worded(read) if options.verbatim else with_sections(read)
        trip = self._prove(in_words, folder)
        if trip is None or has_errors(self.diagnostics):
            return self._end(result)
        imported, files = in_words.imported, trip.files
        lines = [*report_parts(tree_of(trip.shown), trip.reordered), *report_words(in_words)]
        translated: Sequence[str] = ()
        if keeps and self.source is not Description.ON_STDIN:
            target = Target(folder, schema_beside(folder), options.name, named.meshes, self.package is not None)
            translation = translate(self.source, self.reading, read, trip.outputs, target)
            translated = translation.report
            if translation.files:  # it keeps elements as they are
                imported, files, lines = read._replace(tree=named.tree), translation.files, []
        is_flat = files is trip.files
        trip = trip._replace(files=files)
        if self.package is not None:
            return self._put_into(self.package, result, imported, trip, [*lines, *translated])
        if record is not None:
            return self._import_again(result, record, _as_split(trip, record, folder) if is_flat else files)
        written = self._write(folder, {**files, **record_of(files, self.request.words)})
        if written is None:
            return self._end(result)
        report = [*_report(folder, imported, trip, written.kept, lines), *translated]
        return self._end(replace(result, written=written.written, report=tuple(report)))

    def _end(self, result: ImportResult) -> ImportResult:
        if not self.package and result.report and not has_errors(self.diagnostics):
            result = replace(result, next_steps=(f"next: rosorin-compile all {shlex.quote(result.folder)}",))
        return replace(result, diagnostics=tuple(self.diagnostics))

    def _read(self) -> Imported:
        """Read the source and its companions. Raises RequestError."""
        imported = read_robot(self.source, self.reading)
        if self.reading.arguments and not imported.takes_arguments and imported.tree is not None:
            raise RequestError(f"{self.source} takes no arguments: only a xacro does")
        for format, path in self.options.companions.items():
            _check_file(path)
            imported = join(imported, format, path, self.reading)
        found = imported.diagnostics
        if self.options.strict:
            found = [replace(one, severity=ERROR) if one.rule == "import-cannot-carry" else one for one in found]
        self.diagnostics += arrange(found)
        return imported if imported.tree is None else imported._replace(tree=self._with_drives(imported.tree))

    def _with_drives(self, tree: Map) -> Map:
        """Let servos stand in for the actuators of a source that has none. Raises RequestError for an MJCF."""
        drives, outputs = self.options.drives, tree.get("outputs") or Map(tree.span)
        joints = list((tree.get("joints") or {}).values())
        if _MJCF in outputs:
            if drives not in (None, "none"):
                raise RequestError(f"{self.source} is an MJCF, and its actuators are imported: leave --drives out")
            return tree
        has_actuators = "actuators" in tree or any("actuator" in joint for joint in joints)
        drives = drives or ("none" if has_actuators else "position")
        if drives == "none" or all(joint["type"] not in MOVING_TYPES for joint in joints):
            return tree
        entry = _with(_with(Map(tree.span), "file", "robot.xml"), "drives", drives)
        return _with(tree, "outputs", _with(outputs, _MJCF, entry))

    def _prove(self, in_words: Worded, folder: Path) -> RoundTrip | None:
        """Compile the description in a temporary folder and compare it with the source."""
        options = self.options
        try:
            parts = options.parts and not options.flat
            trip = check_round_trip(in_words.imported, folder, parts, in_words.plain, self.reading.packages)
        except OSError as problem:
            reason = problem.strerror or type(problem).__name__
            message = f"{self.source}: cannot work in the temporary folder: {reason}; TMPDIR can name another one"
            self.diagnostics.append(error("output-failed", message, None))
            return None
        untold = list(trip.untold)
        if self.reading.lenient and not options.strict:
            untold = [replace(one, severity=WARNING, help="please report it with the file") for one in untold]
        self.diagnostics += arrange([*trip.diagnostics, *untold])
        return trip

    def _put_into(
        self, package: Package, result: ImportResult, imported: Imported, trip: RoundTrip, lines: Sequence[str]
    ) -> ImportResult:
        """Write the description to the package of its source."""
        folder = Path(result.folder)
        try:
            put = put_into(package, self.name_in_package, self.reading.arguments, folder.name, trip.files, self.request)
        except OutputError as problem:
            self.diagnostics.append(problem.diagnostic)
            return self._end(result)
        self.diagnostics += arrange(put.diagnostics)
        report = (*(_report(folder, imported, trip, (), lines) if put.is_new else ()), *put.report)
        made = replace(result, written=put.written, report=report, to_do=tuple(put.to_do), next_steps=tuple(put.after))
        return self._end(made)

    def _import_again(self, result: ImportResult, record: Record, files: Mapping[str, str]) -> ImportResult:
        """Merge a newer state of the source into its description."""
        folder = Path(result.folder)
        merged = import_again(folder, record, files, self.request)
        self.diagnostics += arrange(merged.diagnostics)
        written = None if merged.refused else self._write(folder, merged.files, merged.before)
        if written is None:
            return self._end(result)
        with suppress(OSError):  # nothing includes them any more
            remove(folder, merged)
        names = [name for name in written.written if not is_record(name)]
        changed = [*names, *(f"{name} (removed)" for name in merged.removed if not is_record(name))]
        first = f"{folder}: written: {', '.join(changed)}" if changed else f"{folder}: unchanged"
        return self._end(replace(result, written=tuple(names), report=(first, *merged.lines)))

    def _write(
        self, folder: Path, files: Mapping[str, str], before: Mapping[str, str] = MappingProxyType({})
    ) -> WriteResult | None:
        """Write the files of a description; a file that is replaced is kept, unless it is as it was ``before``."""

        def judge(name: str, old: bytes, _: bytes) -> Literal["replace", "keep"]:
            return "replace" if is_record(name) or old == before.get(name, "").encode() else "keep"

        try:
            written = write_set(folder, files, judge=judge)
        except OutputError as problem:
            self.diagnostics.append(problem.diagnostic)
            return None
        self.diagnostics += arrange(written.diagnostics(folder))
        return written


def _as_split(trip: RoundTrip, record: Record, folder: Path) -> Mapping[str, str]:
    """Return the files of a flat description, in several files if it had several when it was imported."""
    split = len(record.files) > 1
    if split == (len(trip.files) > 1):
        return trip.files
    return write(trip.shown, trip.outputs, schema_beside(folder), split)


def _with(tree: Map, key: str, value: object) -> Map:
    """Return a mapping with another value of a key."""
    made = tree.copy()
    made.put(key, value, tree.span, tree.span)
    return made


def _check_folder(folder: Path, force: bool) -> None:
    """Raise RequestError if a folder is not empty, unless it is forced, or if it is a file."""
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"{folder} is no folder; name a new one with -o")
    with suppress(OSError):  # writing to a folder that cannot be read fails with a better message
        if force or not any(folder.iterdir()):
            return
        message = f"{folder} is not empty; name a new folder with -o, or write into this one with --force"
        if (folder / Description.ROOT_FILE).is_file():
            record = f"{Description.ROOT_FILE}{ENDING}"
            message += f" (no {record} there says what was imported, against which changes could be told)"
        raise RequestError(message)


def _report(folder: Path, imported: Imported, trip: RoundTrip, left: Sequence[str], lines: Sequence[str]) -> list[str]:
    """Return the sentences about a new description: its size, the proof, what is kept and what is left out."""
    tree = tree_of(imported)
    report = [
        f"{folder}: {sizes(tree)} in {', '.join(trip.files)}",
        f"the compiled {FORMATS.published_format().word} is the same robot",
    ]
    if trip.proof.said or trip.proof.unknown:
        report.append(trip.proof.said or f"not held against the source in its engine: {trip.proof.unknown}")
    report += [f"no {name} among its outputs: {reason}" for name, reason in trip.outputs.left_out.items()]
    report += [*lines, *report_kept(tree), *report_accepted(tree)]
    report += [f"its {FORMATS[name].word} is {remark}" for name, remark in trip.outputs.remarks.items()]
    if imported.left_out:
        count = len(imported.left_out)
        report.append(f"not carried over: {count}, see the {'warning' if count == 1 else 'warnings'} above")
    others = [name for name in left if not is_record(name)]
    if others:
        report.append(f"left alone in {folder}, not written by this import: {', '.join(others)}")
    return report

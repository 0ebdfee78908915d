"""Import a robot: convert a URDF, xacro, SDF or MJCF to a description, prove it, and write it."""

from __future__ import annotations

import re
import shlex
import stat
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Format
from rosorin_compile.formats.imported_robot import Imported, ReadOptions, as_tree
from rosorin_compile.formats.robot_files import join, read_robot
from rosorin_compile.model.joint import MOVING_TYPES
from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.output.atomic_files import OutputError
from rosorin_compile.request import FilePath, Packages, Values, Warn, read_options
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, RequestError, count_of, error, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import suggest

from .description import write
from .elements import Converted, report_elements, with_sections
from .mesh_names import rename_files
from .reimport import ENDING, Merged, import_again, is_record, record_of, recorded, remove
from .ros_package import Package, Written, package_at, write_into
from .round_trip import RoundTrip, check_round_trip, schema_beside
from .xacro.translate import Target, translate

_MJCF = "mjcf"
_TAG = re.compile(r"(?:\s|<!--.*?-->)*<([^\s/>!?]+)", re.DOTALL)  # an element that is kept
_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")


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
    return _Import(
        source=source if isinstance(source, Path) else Path(source),
        reading=reading,
        into=None if into is None else Path(into),
        output=None if output is None else Path(output),
        name=name,
        meshes=meshes,
        companions={format: Path(file) for format, file in (companions or {}).items()},
        strict=strict,
        parts=parts,
        verbatim=verbatim,
        flat=flat,
        drives=drives,
        force=force,
        keep_edits=keep_edits,
    ).run()


@dataclass
class _Import:
    """One import: its source, the arguments of ``import_robot``, and the diagnostics so far."""

    source: Path
    reading: ReadOptions
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
    keep_edits: bool
    package: Package | None = None
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Find the package that gets the description. Raises RequestError for invalid combinations of options."""
        if self.source is not Description.ON_STDIN:
            _check_file(self.source)
        if self.into is not None:
            if self.output is not None or self.force:
                word = "-o" if self.output is not None else "--force"
                raise RequestError(f"--into names the place, and what is there stays: leave {word} out")
            if self.source is Description.ON_STDIN:
                raise RequestError("--into compares the description with a file: name it, not -")
            self.package = package_at(self.into, self.source)
            own = {self.package.name: self.package.folder}
            self.reading = replace(self.reading, packages={**own, **self.reading.packages})
        if self.name is not None and not (_NAME.fullmatch(self.name) and self.name.isprintable()):
            raise RequestError(f'"{self.name}" cannot be the name of a robot: no markup, no quotes, spaces only within')
        meshes = self.meshes
        if meshes is not None and (not meshes.isprintable() or not meshes.strip() or meshes.endswith("://")):
            raise RequestError(f'--meshes "{meshes}" is neither a folder nor package://NAME')

    def _command_line(self) -> list[str]:
        """Return the command-line arguments that determine the result; a later import needs the same ones."""
        words = [self.package.source if self.package else self.source.name]
        words += [f"{name}:={value}" for name, value in self.reading.arguments.items()]
        values = {"--name": self.name, "--meshes": self.meshes, "--drives": self.drives}
        words += [word for name, value in values.items() if value is not None for word in (name, value)]
        flags = {"--no-parts": not self.parts, "--verbatim": self.verbatim, "--flat": self.flat}
        words += [flag for flag, is_set in flags.items() if is_set]
        return words + [word for name, path in self.companions.items() for word in (f"--{name}", path.name)]

    def run(self) -> ImportResult:
        """Read, convert, prove and write. Raises RequestError."""
        imported = self._read()
        result = ImportResult(str(self.source), inputs=tuple(map(str, imported.files)))
        if imported.tree is None or has_errors(self.diagnostics):
            return self._end(result)
        tree = imported.tree if self.name is None else _with(imported.tree, "robot", self.name)
        base = self.package.folder if self.package else Description.project_folder()
        folder = self.output or Path(base, Description.FOLDER, imported._replace(tree=tree).file_name)
        result = replace(result, robot=tree["robot"], folder=str(folder))
        words = self._command_line()
        record = None if self.force else recorded(folder, words)
        if record is None and not self.force:
            others = "name a new folder with -o, or write into this one with --force"
            _check_folder(folder, "give this robot another name with --name" if self.package else others)
        keeps = imported.takes_arguments and not self.flat
        renamed = rename_files(tree, self.source, folder, self.meshes, self.reading.packages, keeps)
        self.diagnostics += arrange(renamed.diagnostics)
        read = imported._replace(tree=renamed.tree)
        converted = Converted(read) if self.verbatim else with_sections(read)
        trip = self._prove(converted, folder)
        if trip is None or has_errors(self.diagnostics):
            return self._end(result)
        imported, lines = converted.imported, [*_report_parts(trip), *report_elements(converted)]
        translated: Sequence[str] = ()
        if record is not None and (len(record.files) > 1) != (len(trip.files) > 1):  # in as many files as before
            files = write(trip.shown, trip.outputs, schema_beside(folder), len(record.files) > 1)
        else:
            files = trip.files
        if keeps and self.source is not Description.ON_STDIN:
            target = Target(folder, schema_beside(folder), self.name, renamed.meshes, self.package is not None)
            translation = translate(self.source, self.reading, read, trip.outputs, target)
            translated = translation.report
            if translation.files:  # it keeps elements as they are
                imported, files, lines = read, translation.files, []
        report = [*_report(folder, imported, trip, files), *lines, *translated]
        if record is None:
            merged = Merged({**files, **record_of(files, words)})
        else:
            merged = import_again(folder, record, files, words, self.keep_edits)
        self.diagnostics += arrange(merged.diagnostics)
        written = None if merged.refused else self._write(folder, merged, record is None)
        if written is None:
            return self._end(result)
        names = tuple(name for name in written.files if not is_record(name))
        if record is not None:
            with suppress(OSError):  # nothing includes them any more
                remove(folder, merged)
            changed = [*names, *(f"{name} (removed)" for name in merged.removed if not is_record(name))]
            first = f"{folder}: written: {', '.join(changed)}" if changed else f"{folder}: unchanged"
            report = [first, *merged.lines]
        made = replace(result, written=names, report=tuple(report), to_do=written.to_do)
        return self._end(replace(made, next_steps=written.next_steps))

    def _end(self, result: ImportResult) -> ImportResult:
        return replace(result, diagnostics=tuple(self.diagnostics))

    def _read(self) -> Imported:
        """Read the source and its companions. Raises RequestError."""
        imported = read_robot(self.source, self.reading)
        if self.reading.arguments and not imported.takes_arguments and imported.tree is not None:
            raise RequestError(f"{self.source} takes no arguments: only a xacro does")
        for format, path in self.companions.items():
            _check_file(path)
            imported = join(imported, format, path, self.reading)
        found = imported.diagnostics
        if self.strict:
            found = [replace(one, severity=ERROR) if one.rule == "import-cannot-carry" else one for one in found]
        self.diagnostics += arrange(found)
        return imported if imported.tree is None else imported._replace(tree=self._with_drives(imported.tree))

    def _with_drives(self, tree: Map) -> Map:
        """Add servos as stand-ins if the source has no actuators. Raises RequestError for an MJCF."""
        outputs, joints = tree.get("outputs") or Map(tree.span), list((tree.get("joints") or {}).values())
        if _MJCF in outputs:
            if self.drives not in (None, "none"):
                raise RequestError(f"{self.source} is an MJCF, and its actuators are imported: leave --drives out")
            return tree
        has_actuators = "actuators" in tree or any("actuator" in joint for joint in joints)
        drives = self.drives or ("none" if has_actuators else "position")
        if drives == "none" or all(joint["type"] not in MOVING_TYPES for joint in joints):
            return tree
        entry = as_tree({"file": "robot.xml", "drives": drives}, tree.span)
        return _with(tree, "outputs", _with(outputs, _MJCF, entry))

    def _prove(self, converted: Converted, folder: Path) -> RoundTrip | None:
        """Compile the description in a temporary folder and compare it with the source."""
        try:
            parts = self.parts and not self.flat
            trip = check_round_trip(converted.imported, folder, parts, converted.plain, self.reading.packages)
        except OSError as problem:
            reason = problem.strerror or type(problem).__name__
            message = f"{self.source}: cannot work in the temporary folder: {reason}; TMPDIR can name another one"
            self.diagnostics.append(error("output-failed", message, None))
            return None
        untold = list(trip.untold)
        if self.reading.lenient and not self.strict:
            untold = [replace(one, severity=WARNING, help="please report it with the file") for one in untold]
        self.diagnostics += arrange([*trip.diagnostics, *untold])
        return trip

    def _write(self, folder: Path, merged: Merged, is_new: bool) -> Written | None:
        """Write the files of a description; an edited file that is replaced is kept under another name."""

        def judge(name: str, old: bytes, _: bytes) -> Literal["replace", "keep"]:
            return "replace" if is_record(name) or old == merged.before.get(name, "").encode() else "keep"

        try:
            if self.package is not None:
                return write_into(self.package, folder.name, merged.files, self.reading.arguments, is_new)
            made = write_set(folder, merged.files, judge=judge)
        except OutputError as problem:
            self.diagnostics.append(problem.diagnostic)
            return None
        self.diagnostics += arrange(made.diagnostics(folder))
        steps = () if has_errors(self.diagnostics) else (f"next: rosorin-compile all {shlex.quote(str(folder))}",)
        return Written(made.written, (), steps)


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


def _with(tree: Map, key: str, value: object) -> Map:
    """Return a mapping with another value of a key."""
    made = tree.copy()
    made.put(key, value, tree.span, tree.span)
    return made


def _check_folder(folder: Path, help: str) -> None:
    """Raise RequestError if a folder is not empty, or if it is a file."""
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"{folder} is not a folder; name a new one with -o")
    with suppress(OSError):  # writing to a folder that cannot be read fails with a better message
        if any(folder.iterdir()):
            message = f"{folder} is not empty; {help}"
            if (folder / Description.ROOT_FILE).is_file():
                record = f"{Description.ROOT_FILE}{ENDING}"
                message += f" (no {record} there says what was imported, so that changes cannot be merged)"
            raise RequestError(message)


def _report(folder: Path, imported: Imported, trip: RoundTrip, files: Mapping[str, str]) -> list[str]:
    """Return the summary of a new description: its size, the comparison with the source, what was kept or left out."""
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
    """Return the lines about parts, and about the order of joints, which readers of joint positions depend on."""
    tree = trip.shown.whole
    bodies = [tree, *(tree.get("parts") or {}).values()]
    uses = Counter(use["part"] for body in bodies for use in (body.get("use") or {}).values())
    if not uses:
        return []
    lines = ["parts: " + ", ".join(f"{part} ({count_of(count, 'use')})" for part, count in uses.items())]
    reordered = "the joints come in another order than in the source; --no-parts keeps it"
    return [*lines, reordered] if trip.reordered else lines


def _texts(node: Any) -> Iterator[str]:
    """Yield every text in a tree."""
    if isinstance(node, (Map, Seq)):
        for item in node.values() if isinstance(node, Map) else node:
            yield from _texts(item)
    elif isinstance(node, str):
        yield node

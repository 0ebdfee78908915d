"""rosorin-compile import: make a description of a robot that exists as URDF, xacro, SDF or MJCF."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Console, counted
from rosorin_compile.source.project import Description

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.formats.format import Format
    from rosorin_compile.formats.imported import Imported, ReadOptions
    from rosorin_compile.importing.into import Package
    from rosorin_compile.importing.reimport import Record, Request
    from rosorin_compile.importing.report import Renamed
    from rosorin_compile.importing.round_trip import RoundTrip
    from rosorin_compile.importing.translating import Translation
    from rosorin_compile.importing.words import Worded
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.tree import Map

    from .parser import Parser

_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")


def options(command: Parser) -> None:
    """Add what this command takes."""
    from rosorin_compile.formats import FORMATS

    *others, last = FORMATS.endings(include=True)
    command.add_argument("words", nargs="+", metavar="SOURCE", help=f"a {', '.join(others)} or {last} file")
    command.add_argument(
        "-o",
        "--output",
        type="path",
        metavar="FOLDER",
        help="new folder of the description; default: descriptions/ROBOT",
    )
    command.add_argument(
        "--into",
        type="path",
        metavar="FOLDER",
        help="write the description to the ROS package of SOURCE, with a test that compares both",
    )
    command.add_argument("--name", metavar="NAME", help="name of the robot; default: that of SOURCE")
    command.add_argument("--strict", action="store_true", help="treat unsupported elements as errors")
    command.add_argument("--lenient", action="store_true", help="accept violations of the specification where possible")
    command.add_argument("--no-parts", action="store_true", help="do not factor repeated structures into parts")
    command.add_argument(
        "--verbatim", action="store_true", help="copy the Gazebo and ros2_control elements of a URDF unchanged"
    )
    command.add_argument(
        "--flat", action="store_true", help="import the URDF that a xacro generates, without its macros"
    )
    command.add_argument("--force", action="store_true", help="write to a folder that is not empty")
    command.add_argument(
        "--ours", action="store_true", help="if both SOURCE and the description changed, keep the description"
    )
    command.add_argument(
        "--meshes",
        metavar="FOLDER",
        help="prefix of relative mesh names: a folder relative to the artifacts, or package://NAME",
    )
    for format in _companions():
        command.add_argument(
            f"--{format.name}", type="path", metavar="FILE", help=f"also read the {format.word} of the robot"
        )
    command.add_messages()
    command.add_given()


def _companions() -> list[Format]:
    """Return the formats of files that say more about a robot of another file."""
    from rosorin_compile.formats import FORMATS

    return [one for one in FORMATS.values() if one.reading.join is not None]


def run(options: argparse.Namespace) -> int:
    """Read the source, check the description that is made of it, and write it."""
    from rosorin_compile.formats.imported import Imported, ReadOptions

    run = Run.of(options)
    source, arguments = _source(run)
    packages = dict(run.given.packages)
    target = _target(options, source, arguments)
    if target is not None and target.package.name not in packages:
        packages = {**packages, target.package.name: target.package.folder}
    if options.name is not None and not (_NAME.fullmatch(options.name) and options.name.isprintable()):
        raise WrongUsage(f'"{options.name}" cannot be the name of a robot: no markup, no quotes, spaces only within')
    if options.meshes is not None and not _can_begin(options.meshes):
        raise WrongUsage(f'--meshes "{options.meshes}" is neither a folder nor package://NAME')
    console = run.console
    console.begin(source.name)
    how = ReadOptions(arguments, packages, options.lenient, tell=console.ahead, trust=options.trust)
    imported = Imported.read(source, how)
    if arguments and not imported.takes_arguments and imported.tree is not None:
        raise WrongUsage(f"{source} takes no arguments: only a xacro does")
    for format in _companions():
        beside = getattr(options, format.name)
        if beside is not None:
            if _kind(Path(beside)) != "file":
                raise WrongUsage(
                    f"{beside} is {'a folder' if _kind(Path(beside)) else 'not there'}{_alike(Path(beside))}"
                )
            imported = imported.joined(format.name, Path(beside), how)
    if options.strict:
        imported = imported._replace(diagnostics=[_strictly(diagnostic) for diagnostic in imported.diagnostics])
    console.tell_read(imported.files)
    _show(console, imported.diagnostics)
    code = _describe(options, console, source, imported, target, how)
    if code != FINE:
        give_result(options, None, str)
    console.finish()
    return code


class _Written(NamedTuple):
    """The files of a description that are new, and those beside them that were left alone."""

    written: tuple[str, ...]
    kept: tuple[str, ...] = ()


class _Target(NamedTuple):
    """The package that a description goes into, its source as seen from there, and what that was given."""

    package: Package
    source: str
    given: dict[str, str]


def _target(options: argparse.Namespace, source: Path, arguments: dict[str, str]) -> _Target | None:
    """Return where ``--into`` puts a description. Raises WrongUsage."""
    if options.into is None:
        return None
    from rosorin_compile.importing.into import inside, package_at

    if options.output is not None or options.force:
        word = "-o" if options.output is not None else "--force"
        raise WrongUsage(f"--into names the place, and what is there stays: leave {word} out")
    if source is Description.ON_STDIN:
        raise WrongUsage("--into holds the description against a file: name it, not -")
    package = package_at(Path(options.into))
    return _Target(package, inside(source, package), arguments)


def _source(run: Run) -> tuple[Path, dict[str, str]]:
    """Return the file to import, and the arguments for it as texts. Raises WrongUsage."""
    given, names = run.given, run.words
    if len(names) != 1:
        raise WrongUsage(f"import takes one SOURCE, not {len(names) or 'none'}")
    Run.take_stdin(names)
    path = Path(names[0]) if names[0] != Description.STDIN else Description.ON_STDIN
    kind = _kind(path) if path is not Description.ON_STDIN else "file"
    if kind == "folder":
        raise WrongUsage(f"{path} is a folder; name the file of the robot in it")
    if not kind:
        raise WrongUsage(f"{path} is not there{_alike(path)}")
    return path, given.as_written()


def _can_begin(folder: str) -> bool:
    """Say whether the name of a file can begin so."""
    return folder.isprintable() and bool(folder.strip()) and not folder.endswith("://")


def _kind(path: Path) -> str:
    """Return whether a path is a folder or another file; empty if it is not there, or no file can be called so."""
    return "folder" if files.is_folder(path) else "file" if files.exists(path) else ""


def _alike(path: Path) -> str:
    """Return "did you mean FILE?" for a file of the same folder with nearly that name; empty if there is none."""
    close = Description.nearest_file(path)
    return f'; did you mean "{close}"?' if close else ""


def _show(console: Console, diagnostics: list[Diagnostic]) -> None:
    from rosorin_compile.source.diagnostics import arrange

    console.show(arrange(diagnostics))


def _strictly(diagnostic: Diagnostic) -> Diagnostic:
    from rosorin_compile.source.diagnostics import ERROR

    carried = diagnostic.rule != "import-cannot-carry"
    return diagnostic if carried else replace(diagnostic, severity=ERROR)


def _leniently(diagnostic: Diagnostic) -> Diagnostic:
    from rosorin_compile.source.diagnostics import WARNING

    return replace(diagnostic, severity=WARNING, help="please report it with the file")


def _describe(
    options: argparse.Namespace,
    console: Console,
    source: Path,
    imported: Imported,
    target: _Target | None,
    how: ReadOptions,
) -> int:
    """Write what became of a source and say so; or say how many errors keep it from being written."""
    from rosorin_compile.importing.description import tree_of
    from rosorin_compile.importing.reimport import Request, record_of, recorded
    from rosorin_compile.importing.report import renamed, repeated
    from rosorin_compile.importing.round_trip import check_round_trip
    from rosorin_compile.importing.translating.report import translation_report as told_translation
    from rosorin_compile.importing.words.report import told_words
    from rosorin_compile.source.diagnostics import ERROR

    errors = sum(diagnostic.severity == ERROR for diagnostic in imported.diagnostics)
    if imported.tree is None or errors:
        return _refused(console, source, errors)
    tree = imported.tree if options.name is None else _renamed(imported.tree, options.name)
    base = target.package.folder if target else Description.around()
    called = imported._replace(tree=tree).file_name
    folder = Path(options.output) if options.output else Path(base, Description.FOLDER, called)
    give_result(options, {"source": str(source), "robot": tree["robot"], "folder": str(folder)}, str)
    request = Request(_words(options, source, how), options.ours)
    record = recorded(folder, request.words) if target is None and not options.force else None
    if target is None and record is None:
        _check_folder(folder, options.force)
    keeps = imported.takes_arguments and not options.flat
    named = renamed(tree, source, folder, options.meshes, how.packages, keeps)
    _show(console, named.diagnostics)
    read = imported._replace(tree=named.tree)
    in_words = _worded(options, imported._replace(tree=named.tree))
    imported = in_words.imported
    try:
        parts = not (options.no_parts or options.flat)
        trip = check_round_trip(imported, folder, parts, in_words.plain, how.packages)
    except OSError as problem:
        reason = problem.strerror or type(problem).__name__
        console.warn(f"{source}: cannot work in the temporary folder: {reason}; TMPDIR can name another one")
        return PROBLEMS
    takes_all = options.lenient and not options.strict
    told = [*trip.diagnostics, *(_leniently(error) if takes_all else error for error in trip.untold)]
    _show(console, told)
    errors = sum(diagnostic.severity == ERROR for diagnostic in told)
    if errors:
        return _refused(console, source, errors)
    lines = [*repeated(tree_of(trip.shown), trip.reordered), *told_words(in_words)]
    translation = _translated(options, source, read, named, trip, folder, how, target)
    if translation is not None and translation.files:  # it has words of its own: those of all combinations
        imported, lines = read._replace(tree=translation.plain or named.tree), list(translation.words)
        trip = trip._replace(files=translation.files)
    translated = list(told_translation(translation)) if translation is not None else []
    if target is not None:
        grown = translation.grown if translation is not None else {}
        return _put_into(console, target, folder, imported, trip, [*lines, *translated], grown, request)
    if record is not None:
        is_program = translation is not None and translation.files
        files = trip.files if is_program else _as_split(trip, record, folder)
        return _import_again(console, source, folder, record, files, request)
    written = _write(console, folder, {**trip.files, **record_of(trip.files, request.words)})
    if written is None:
        return PROBLEMS
    _report(console, folder, imported, trip, written, lines)
    for line in translated:
        console.say(line)
    console.say(f"next: rosorin-compile all {shlex.quote(str(folder))}")
    return FINE


def _words(options: argparse.Namespace, source: Path, how: ReadOptions) -> list[str]:
    """Return the words of an import that decide what is written: those that the next one has to say, too."""
    words = [source.name, *(f"{name}:={value}" for name, value in how.arguments.items())]
    for name in ("name", "meshes"):
        value = getattr(options, name)
        words += [] if value is None else [f"--{name}", value]
    words += [f"--{name.replace('_', '-')}" for name in ("no_parts", "verbatim", "flat") if getattr(options, name)]
    for format in _companions():
        beside = getattr(options, format.name)
        words += [] if beside is None else [f"--{format.name}", Path(beside).name]
    return words


def _import_again(
    console: Console, source: Path, folder: Path, record: Record, files: Mapping[str, str], request: Request
) -> int:
    """Merge a newer state of a source into its description, and report it."""
    from rosorin_compile.importing.reimport import import_again, is_record, remove
    from rosorin_compile.source.diagnostics import has_errors

    merged = import_again(folder, record, files, request)
    if merged.refused:
        _show(console, merged.diagnostics)
        return _refused(console, source, len(merged.diagnostics))
    written = _write(console, folder, merged.files, merged.before)
    if written is None:
        return PROBLEMS
    with suppress(OSError):  # nothing includes them any more
        remove(folder, merged)
    _show(console, merged.diagnostics)
    changed = [name for name in written.written if not is_record(name)]
    changed += [f"{name} (removed)" for name in merged.removed if not is_record(name)]
    console.say(f"{folder}: written: {', '.join(changed)}" if changed else f"{folder}: unchanged")
    for line in merged.lines:
        console.say(line)
    if has_errors(merged.diagnostics):
        return PROBLEMS
    console.say(f"next: rosorin-compile all {shlex.quote(str(folder))}")
    return FINE


def _as_split(trip: RoundTrip, record: Record, folder: Path) -> dict[str, str]:
    """Return the files of a description that is no program, in several if it was several when it was imported."""
    from rosorin_compile.importing.description import write
    from rosorin_compile.importing.round_trip import schema_beside

    split = len(record.files) > 1
    if split == (len(trip.files) > 1):
        return trip.files
    return write(trip.shown, trip.outputs, schema_beside(folder), split)


def _put_into(
    console: Console,
    target: _Target,
    folder: Path,
    imported: Imported,
    trip: RoundTrip,
    lines: list[str],
    grown: Mapping[str, str],
    request: Request,
) -> int:
    """Put a description into a package, and say what is left to be done there."""
    from rosorin_compile.importing.description import tree_of
    from rosorin_compile.importing.into import in_the_end, package_report, put_into, to_do
    from rosorin_compile.output import OutputError
    from rosorin_compile.source.diagnostics import has_errors

    package = target.package
    try:
        tree = tree_of(imported)
        put = put_into(package, target.source, target.given, folder.name, trip.files, tree, request, grown)
    except OutputError as problem:
        _show(console, [problem.diagnostic])
        return PROBLEMS
    if put.refused:
        _show(console, list(put.refused))
        return _refused(console, package.folder / target.source, len(put.refused))
    again = put.again.diagnostics if put.again else []
    _show(console, again)
    if put.again is None and any(file.startswith(f"{Description.FOLDER}/") for file in put.written):
        _report(console, folder, imported, trip, _Written(tuple(trip.files)), lines)
    for line in package_report(package, put):
        console.say(line)
    for line in to_do(package, put):
        console.say(line, needed=True)
    for line in in_the_end(target.source, put):
        console.say(line)
    return PROBLEMS if has_errors(again) else FINE


def _worded(options: argparse.Namespace, imported: Imported) -> Worded:
    """Return a robot with what its elements say in words, unless they are to stay as they are."""
    from rosorin_compile.importing.words import Worded, worded

    return Worded(imported) if options.verbatim else worded(imported)


def _translated(
    options: argparse.Namespace,
    source: Path,
    imported: Imported,
    named: Renamed,
    trip: RoundTrip,
    folder: Path,
    how: ReadOptions,
    target: _Target | None,
) -> Translation | None:
    """Return what a xacro says with its macros and arguments; None for what is none, or is asked for flat."""
    if options.flat or not imported.takes_arguments or source is Description.ON_STDIN:
        return None
    from rosorin_compile.importing.round_trip import schema_beside
    from rosorin_compile.importing.translating import Changed, translate
    from rosorin_compile.importing.translating.sharing import Sharing

    sharing = Sharing(target.package.folder, folder) if target is not None else None
    changed = Changed(folder, schema_beside(folder), options.name, named.meshes, options.verbatim, sharing)
    return translate(source, how, imported._replace(tree=named.tree), trip.outputs, changed)


def _refused(console: Console, source: Path, errors: int) -> int:
    console.warn(f"{source}: {counted(errors, 'error')}, nothing written")
    return PROBLEMS


def _renamed(tree: Map, name: str) -> Map:
    """Return a tree with another name of the robot."""
    from rosorin_compile.source.tree import Map

    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        made.put(key, name if key == "robot" else value, tree.key_spans[key], tree.value_spans[key])
    return made


def _check_folder(folder: Path, force: bool) -> None:
    """Raise WrongUsage if a folder is taken."""
    from rosorin_compile.importing.reimport import ENDING

    if _kind(folder) == "file":
        raise WrongUsage(f"{folder} is no folder; name a new one with -o")
    with suppress(OSError):  # a folder that nobody may look into is no place to write either: that is said there
        if force or not any(folder.iterdir()):
            return
        message = f"{folder} is not empty; name a new folder with -o, or write into this one with --force"
        if files.is_file(folder / Description.ROOT_FILE):
            record = f"{Description.ROOT_FILE}{ENDING}"
            message += f" (no {record} there says what was imported, against which changes could be told)"
        raise WrongUsage(message)


def _write(
    console: Console, folder: Path, files: Mapping[str, str], known: Mapping[str, str] | None = None
) -> _Written | None:
    """Write the files of a description; what they replace is kept beside them, unless it is ``known``: taken over."""
    from rosorin_compile.importing.reimport import is_record
    from rosorin_compile.output import OutputError, write_set

    def judge(name: str, old: bytes, _: bytes) -> Literal["replace", "keep"]:
        return "replace" if is_record(name) or old == (known or {}).get(name, "").encode() else "keep"

    try:
        written = write_set(folder, files, judge=judge)
        _show(console, written.diagnostics(folder))
        return _Written(written.written, written.kept)
    except OutputError as problem:
        _show(console, [problem.diagnostic])
        return None


def _report(
    console: Console, folder: Path, imported: Imported, trip: RoundTrip, written: _Written, lines: list[str]
) -> None:
    """Say what was made, what was compared, what is kept as it was, and what comes next."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.importing.description import tree_of
    from rosorin_compile.importing.reimport import is_record
    from rosorin_compile.importing.report import accepted, kept, sizes

    tree = tree_of(imported)
    console.say(f"{folder}: {sizes(tree)} in {', '.join(trip.files)}")
    console.say(
        f"the compiled {trip.word} is the same robot: {counted(trip.frames, 'frame')} at "
        f"zero and {trip.states} random joint states, largest difference {trip.largest:.2g}"
    )
    if trip.proof.said or trip.proof.unknown:
        console.say(trip.proof.said or f"not held against the source in its engine: {trip.proof.unknown}")
    for name, reason in trip.outputs.left_out.items():
        console.say(f"no {name} among its outputs: {reason}")
    for line in (*lines, *kept(tree), *accepted(tree)):
        console.say(line)
    for name, remark in trip.outputs.remarks.items():
        console.say(f"its {FORMATS[name].word} is {remark}")
    if imported.left_out:
        count = len(imported.left_out)
        console.say(f"not carried over: {count}, see the {'warning' if count == 1 else 'warnings'} above")
    left = [name for name in written.kept if not is_record(name)]
    if left:
        console.say(f"left alone in {folder}, not written by this import: {', '.join(left)}")

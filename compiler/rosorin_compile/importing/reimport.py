"""Import a source again into the description that an earlier import of it wrote.

An import keeps a record of the files that it wrote: ``robot.yaml.imported`` next to ``robot.yaml``, and so on. The
first line of the record of ``robot.yaml`` has the command line of the import. The record belongs to the description and
goes with it into version control. It is the common base when ``git merge-file`` merges edited files with new ones.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.source.diagnostics import (
    WARNING,
    Diagnostic,
    RequestError,
    Source,
    Span,
    count_of,
    error,
    phrase,
    printable,
)
from rosorin_compile.source.files import is_file, read_bytes
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.project import Description

ENDING = ".imported"
_PROGRAM = "# rosorin-compile import "
_MARK = re.compile(r"^<{7}(?= |$)", re.MULTILINE)
_MOST_CONFLICTS = 127  # the largest exit code of git merge-file that counts conflicts


class Record(NamedTuple):
    """The command line of an earlier import, and the text of each file that it wrote, by name."""

    words: list[str]
    files: dict[str, str]


class Request(NamedTuple):
    """The command line of an import as a record has it; ``keep_ours`` resolves conflicts in favour of the edits."""

    words: Sequence[str]
    keep_ours: bool = False


class Merged(NamedTuple):
    """The result of importing again.

    ``before`` are the files of the description as they were read. ``files`` are to be written, with their records;
    ``removed`` are files and records that the source no longer produces. ``refused``: nothing is written.
    """

    before: dict[str, str]
    files: dict[str, str]
    removed: list[str]
    diagnostics: list[Diagnostic]
    lines: list[str]
    refused: bool = False

    @classmethod
    def refuse(cls, *diagnostics: Diagnostic) -> Merged:
        """Return the result of an import that writes nothing because of errors."""
        return cls({}, {}, [], list(diagnostics), [], refused=True)


def record_of(files: Mapping[str, str], words: Iterable[str]) -> dict[str, str]:
    """Return the record of the files of a description, text by name."""
    command = list(words)
    line = shlex.join(command)
    if not line.isprintable():  # a line end, or a byte that is not UTF-8
        line = json.dumps(command)
    made = {f"{name}{ENDING}": text for name, text in files.items()}
    root = f"{Description.ROOT_FILE}{ENDING}"
    if root in made:
        made[root] = f"{_PROGRAM}{line}\n{made[root]}"
    return made


def is_record(name: str) -> bool:
    """Return True if a file is the record of another one."""
    return name.endswith(ENDING)


def read_record(folder: Path) -> Record | None:
    """Return the record of the description in a folder, or None if it is missing or damaged. Raises OSError."""
    try:
        first, _, root = _text(folder / f"{Description.ROOT_FILE}{ENDING}").partition("\n")
        line = first.removeprefix(_PROGRAM) if first.startswith(_PROGRAM) else ""
        words = json.loads(line) if line.startswith('["') else shlex.split(line)
        paths = filter(is_file, sorted(folder.glob(f"**/*{ENDING}")))
        files = {path.relative_to(folder).as_posix().removesuffix(ENDING): _text(path) for path in paths}
    except (ValueError, FileNotFoundError, NotADirectoryError):
        return None
    return Record(words, {**files, Description.ROOT_FILE: root}) if words else None


def _text(path: Path) -> str:
    """Return the text of a file without converting line ends. Raises OSError, ValueError."""
    return read_bytes(path).decode()


def recorded(folder: Path, words: Sequence[str]) -> Record | None:
    """Return the record of the description in a folder, or None. Raises RequestError if it is of another import."""
    try:
        record = read_record(folder)
    except OSError as problem:
        raise RequestError(f"cannot read {folder}: {problem.strerror or type(problem).__name__}") from None
    if record is None or not os.path.lexists(folder / Description.ROOT_FILE):
        return None
    if not is_same_source(record.words, words):
        message = f"{folder} is of another import: rosorin-compile import {source_of(record.words)}; "
        message += f"this one is: {source_of(words)}"
        raise RequestError(f"{message}; name a folder with -o, or another robot with --name")
    missing = [option for option in record.words[1:] if option.startswith("--") and option not in words]
    if missing:
        message = f"{folder} was imported with {phrase(missing)}: rosorin-compile import {shlex.join(record.words)}"
        raise RequestError(f"{message}; give the same options, or name a folder with -o")
    return record


def source_of(words: Sequence[str]) -> str:
    """Return the source of a command line with its arguments."""
    return shlex.join(takewhile(lambda word: not word.startswith("--"), words))


def is_same_source(before: Sequence[str], now: Sequence[str]) -> bool:
    """Return True if two command lines import the same source with the same arguments.

    Earlier versions recorded the name of the file without its folder.
    """
    return source_of(before) in (source_of(now), source_of([Path(now[0]).name, *now[1:]]))


def import_again(folder: Path, record: Record, theirs: Mapping[str, str], request: Request) -> Merged:
    """Merge the files that the importer now makes of a source with those of a description. Nothing is written here.

    Raises RequestError for a file that cannot be read.
    """
    source = printable(Path(request.words[0]).name)
    ours = _read_files(folder, {**record.files, **theirs})
    marked = [problem for name, text in ours.items() if (problem := _marks(folder / name, text))]
    if marked:
        return Merged.refuse(*marked)
    files: dict[str, str] = {}
    removed = [f"{name}{ENDING}" for name in record.files if name not in theirs]
    found: list[Diagnostic] = []
    for name in {**record.files, **theirs}:
        base, own, new = record.files.get(name), ours.get(name), theirs.get(name)
        if new is None:
            if own is not None and own == base:
                removed.append(name)
            elif own is not None:
                message = f"{folder / name} was edited, and the newer {source} has nothing for it: it stays"
                found.append(_left(message, "remove it if you do not need it"))
        elif own is None:
            if base is None:
                files[name] = new
            elif base != new:
                message = f"{folder / name} was deleted, and the newer {source} changes it: it is not written again"
                found.append(_left(message, "to get it back, import into a new folder with -o"))
        elif own == base or new in (base, own):
            files[name] = new if own == base else own
        else:
            try:
                files[name] = _merge_texts(base or "", own, new, source, request.keep_ours)
            except _NoGit as problem:
                message = f"{folder} was edited, and the changes of the newer {source} cannot be merged: {problem}"
                help = "install git, and import again; or import into a new folder with -o"
                return Merged.refuse(error("import-no-git", message, None, help))
            if mark := _MARK.search(files[name]):
                found.append(_conflict(folder / name, files[name], mark.start(), source))
    lines = _report(record, ours, theirs, files, source)
    written = {name: text for name, text in files.items() if text != ours.get(name)}
    return Merged(ours, {**written, **record_of(theirs, request.words)}, removed, found, lines)


def _read_files(folder: Path, names: Iterable[str]) -> dict[str, str]:
    """Return the files of a description that exist. Raises RequestError."""
    texts = {}
    for name in names:
        path = folder / name
        try:
            if is_file(path):
                texts[name] = _text(path)
        except OSError as problem:
            raise RequestError(f"cannot read {path}: {problem.strerror or type(problem).__name__}") from None
        except ValueError:
            raise RequestError(f"{path} is not UTF-8 text: nothing is merged into it") from None
    return texts


def _marks(path: Path, text: str) -> Diagnostic | None:
    """Return the error about the conflict marks of an earlier merge, or None."""
    if _MARK.search(text):
        try:
            parse_yaml(Source(str(path), text))
        except LoadError as problem:
            return problem.diagnostic
    return None


def _left(message: str, help: str) -> Diagnostic:
    return Diagnostic("import-file-left", WARNING, message, help=help)


def _conflict(path: Path, text: str, start: int, source: str) -> Diagnostic:
    """Return the error about the conflicts in a merged file, the first of which begins at ``start``."""
    count = count_of(len(_MARK.findall(text)), "conflict")
    message = f"the newer {source} changes lines of {path.name} that were edited here: {count}"
    message += "; both versions are in the file"
    span = Span(Source(str(path), text), text.count("\n", 0, start) + 1, 1, 7)
    return error("import-conflict", message, span, "choose a version at each <<<<<<<, and remove the marks")


class _NoGit(Exception):
    """``git merge-file`` cannot run; the message has the reason."""


def _merge_texts(base: str, ours: str, theirs: str, source: str, keep_ours: bool) -> str:
    """Merge three texts with ``git merge-file``; conflicts are marked in the style of diff3. Raises _NoGit."""
    git = shutil.which("git")
    if git is None:
        raise _NoGit("git is not installed")
    windows = "\r\n" in ours and "\n" not in ours.replace("\r\n", "")
    texts = {"ours": ours.replace("\r\n", "\n") if windows else ours, "base": base, "theirs": theirs}
    labels = ("edited here", "imported before", f"newer {source}")
    # Neither the repository around the description nor the configuration of the user changes the result.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    environment |= {"GIT_CONFIG_NOSYSTEM": "1", "GIT_CONFIG_GLOBAL": os.devnull, "LC_ALL": "C"}
    try:
        with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as stage:
            for side, text in texts.items():
                Path(stage, side).write_bytes(text.encode())
            options = ["--ours"] if keep_ours else ["--diff3"]
            options += [word for label in labels for word in ("-L", label)]
            command = [git, "merge-file", "-p", *options, *texts]
            done = subprocess.run(command, cwd=stage, env=environment, capture_output=True, check=False)  # noqa: S603
            merged = done.stdout.decode()
    except (OSError, ValueError) as problem:
        raise _NoGit(f"git merge-file fails: {problem}") from None
    if not 0 <= done.returncode <= _MOST_CONFLICTS:
        raise _NoGit(f"git merge-file fails: {printable(done.stderr.decode('utf-8', 'replace').strip())}")
    return merged.replace("\n", "\r\n") if windows else merged


def _report(
    record: Record, ours: Mapping[str, str], theirs: Mapping[str, str], files: Mapping[str, str], source: str
) -> list[str]:
    """Return the summary lines about merged and kept files."""
    if dict(theirs) == record.files:
        lines = [f"{source} is as it was when it was imported before"]
    else:
        taken = [name for name in files if name in theirs and files[name] != ours.get(name)]
        lines = [f"changes of the newer {source}: {', '.join(taken)}"] if taken else []
    edited = [name for name, base in record.files.items() if name in theirs and ours.get(name) not in (None, base)]
    lines += [f"edited here, and kept: {', '.join(edited)}"] if edited else []
    return lines


def remove(folder: Path, merged: Merged) -> None:
    """Delete files that the source no longer produces, unless they changed since they were read. Raises OSError."""
    for name in merged.removed:
        path = folder / name
        if is_record(name) or path.read_bytes() == merged.before[name].encode():
            path.unlink(missing_ok=True)

"""Import a changed source again, and merge the changes with edits of the existing description.

An import stores a copy of each file that it writes, called a record: ``robot.yaml.imported`` next to ``robot.yaml``.
The first line of ``robot.yaml.imported`` has the command line of the import. Records are committed together with the
description. They are the common base when ``git merge-file`` merges edited files with newly imported files.
"""

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

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, RequestError, Source, error
from rosorin_compile.source.files import is_file, read_bytes
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.project import Description
from rosorin_compile.source.wording import count_of, phrase, printable

ENDING = ".imported"
_PROGRAM = "# rosorin-compile import "
_MARK = re.compile(r"^<{7}(?= |$)", re.MULTILINE)
_MOST_CONFLICTS = 127  # highest exit code of git merge-file that is a number of conflicts; higher codes are errors


class MergeResult(NamedTuple):
    """The result of merging an edited description with a new import of its source."""

    files: Mapping[str, str] = {}  # file name -> text to write, including records
    before: Mapping[str, str] = {}  # file name -> text before the merge
    removed: Sequence[str] = ()  # names of files and records that the new import does not have
    diagnostics: Sequence[Diagnostic] = ()
    lines: Sequence[str] = ()  # lines of the import report
    refused: bool = False  # True if an error prevents the merge, so that nothing is written


def record_of(files: Mapping[str, str], words: Iterable[str]) -> dict[str, str]:
    """Return the record (unedited copy) of each file by record name; ``words`` is the import command line."""
    made = {f"{name}{ENDING}": text for name, text in files.items()}
    root = f"{Description.ROOT_FILE}{ENDING}"
    if root in made:
        made[root] = f"{_PROGRAM}{printable(shlex.join(words))}\n{made[root]}"
    return made


def is_record(name: str) -> bool:
    """Return True if a file is a record, whose name ends with ``.imported``."""
    return name.endswith(ENDING)


def _text(path: Path) -> str:
    """Read a file without converting line endings. Raises OSError, ValueError."""
    return read_bytes(path).decode()


def read_record(folder: Path, words: Sequence[str]) -> dict[str, str] | None:
    """Return the text of each file as written by the last import, or None if records are missing or damaged.

    Raises RequestError if a record cannot be read, or if its source or arguments differ from those in ``words``.
    """
    try:
        first, _, root = _text(folder / f"{Description.ROOT_FILE}{ENDING}").partition("\n")
        line = first.removeprefix(_PROGRAM) if first.startswith(_PROGRAM) else ""
        before = shlex.split(line)
        paths = filter(is_file, sorted(folder.glob(f"**/*{ENDING}")))
        files = {path.relative_to(folder).as_posix().removesuffix(ENDING): _text(path) for path in paths}
    except (ValueError, FileNotFoundError, NotADirectoryError):
        return None
    except OSError as problem:
        raise RequestError(f"cannot read {folder}: {problem.strerror or type(problem).__name__}") from None
    if not before or not os.path.lexists(folder / Description.ROOT_FILE):
        return None
    # Also accept the file name alone, because earlier versions recorded the source without its folder.
    if _source(before) not in map(_source, (words, [Path(words[0]).name, *words[1:]])):
        message = f"{folder} is of another import: rosorin-compile import {_source(before)}; this one is: "
        raise RequestError(f"{message}{_source(words)}; name a folder with -o, or another robot with --name")
    if missing := [option for option in before[1:] if option.startswith("--") and option not in words]:
        message = f"{folder} was imported with {phrase(missing)}: rosorin-compile import {shlex.join(before)}"
        raise RequestError(f"{message}; give the same options, or name a folder with -o")
    return {**files, Description.ROOT_FILE: root}


def _source(words: Sequence[str]) -> str:
    """Return the part of an import command line before the options: the source file and its arguments."""
    return printable(shlex.join(takewhile(lambda word: not word.startswith("--"), words)))


def import_again(
    folder: Path, record: Mapping[str, str], theirs: Mapping[str, str], words: Sequence[str], keep_ours: bool = False
) -> MergeResult:
    """Merge newly imported files (``theirs``) with the files of a description; nothing is written yet.

    ``record`` has the files of the last import, ``words`` is the command line of the new import. With ``keep_ours``,
    conflicts keep the edits of the description. Raises RequestError if a file cannot be read.
    """
    source = printable(Path(words[0]).name)
    ours, found, files = dict[str, str](), list[Diagnostic](), dict[str, str]()
    for name in {**record, **theirs}:
        path = folder / name
        try:
            if not is_file(path):
                continue
            ours[name] = _text(path)
            if _MARK.search(ours[name]):  # report conflict markers that are left from an earlier merge
                parse_yaml(Source(str(path), ours[name]))
        except LoadError as problem:
            found.append(problem.diagnostic)
        except OSError as problem:
            raise RequestError(f"cannot read {path}: {problem.strerror or type(problem).__name__}") from None
        except ValueError:
            raise RequestError(f"{path} is not UTF-8 text: nothing is merged into it") from None
    if found:
        return MergeResult(diagnostics=found, refused=True)
    removed = [f"{name}{ENDING}" for name in record if name not in theirs]
    for name in {**record, **theirs}:
        base, own, new = record.get(name), ours.get(name), theirs.get(name)
        left, help = "", ""
        if new is None and own == base is not None:
            removed.append(name)
        elif new is None and own is not None:
            left = f"was edited, and the newer {source} has nothing for it: it stays"
            help = "remove it if you do not need it"
        elif own is None and base is not None and new is not None:
            includes = f"{Description.ROOT_FILE} includes it" if name in ours.get(Description.ROOT_FILE, "") else ""
            why = f"the newer {source} changes it" if new != base else includes
            left = f"was deleted, and {why}: it is not written again" if why else ""
            help = "to get it back, import into a new folder with -o"
        elif new is not None and own == base:
            files[name] = new
        elif own is not None and new in (base, own):
            files[name] = own
        elif own is not None and new is not None:
            try:
                files[name] = _merge_texts(base or "", own, new, source, keep_ours)
            except _NoGit as problem:
                message = f"{folder} was edited, and the changes of the newer {source} cannot be merged: {problem}"
                help = "install git, and import again; or import into a new folder with -o"
                return MergeResult(diagnostics=[error("import-no-git", message, None, help)], refused=True)
            if mark := _MARK.search(files[name]):
                message = f"the newer {source} changes lines of {name} that were edited here: "
                message += f"{count_of(len(_MARK.findall(files[name])), 'conflict')}; both versions are in the file"
                span = Source(str(folder / name), files[name]).span(mark.start(), 7)
                help = "choose a version at each <<<<<<<, and remove the marks"
                found.append(error("import-conflict", message, span, help))
        if left:
            found.append(Diagnostic("import-file-left", WARNING, f"{folder / name} {left}", help=help))
    written = {name: text for name, text in files.items() if text != ours.get(name)}
    lines = [f"changes of the newer {source}: {', '.join(written)}"] if written else []
    if dict(theirs) == record:
        lines = [f"{source} is as it was when it was imported before"]
    edited = [name for name, base in record.items() if name in theirs and ours.get(name) not in (None, base)]
    lines += [f"edited here, and kept: {', '.join(edited)}"] if edited else []
    return MergeResult({**written, **record_of(theirs, words)}, ours, removed, found, lines)


class _NoGit(Exception):
    """Raised if ``git merge-file`` cannot run; the message is the reason."""


def _merge_texts(base: str, ours: str, theirs: str, source: str, keep_ours: bool) -> str:
    """Merge with ``git merge-file``; write diff3 markers at conflicts unless ``keep_ours``. Raises _NoGit."""
    git = shutil.which("git")
    if git is None:
        raise _NoGit("git is not installed")
    windows = "\r\n" in ours and "\n" not in ours.replace("\r\n", "")
    texts = {"ours": ours.replace("\r\n", "\n") if windows else ours, "base": base, "theirs": theirs}
    # Ignore the git configuration of the user and of the current repository.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    environment |= {"GIT_CONFIG_NOSYSTEM": "1", "GIT_CONFIG_GLOBAL": os.devnull, "LC_ALL": "C"}
    try:
        with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as stage:
            for side, text in texts.items():
                Path(stage, side).write_bytes(text.encode())
            command = [git, "merge-file", "-p", "--ours" if keep_ours else "--diff3"]
            command += ["-L", "edited here", "-L", "imported before", "-L", f"newer {source}", *texts]
            done = subprocess.run(command, cwd=stage, env=environment, capture_output=True, check=False)  # noqa: S603
            merged = done.stdout.decode()
    except (OSError, ValueError) as problem:
        raise _NoGit(f"git merge-file fails: {problem}") from None
    if not 0 <= done.returncode <= _MOST_CONFLICTS:
        raise _NoGit(f"git merge-file fails: {printable(done.stderr.decode('utf-8', 'replace').strip())}")
    return merged.replace("\n", "\r\n") if windows else merged


def remove(folder: Path, merged: MergeResult) -> None:
    """Delete the files in ``merged.removed``, except files that changed since they were read. Raises OSError."""
    for name in merged.removed:
        path = folder / name
        if is_record(name) or path.read_bytes() == merged.before[name].encode():
            path.unlink(missing_ok=True)

"""Reimport: the import of a source that was imported before, into the description that stands there."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.diagnostics import Diagnostic, has_errors, listed
from rosorin_compile.extending import Description, LoadError, WrongUsage, world

from . import record as records
from .record import ENDING, Record, text_of
from .report import in_the_way, merge_report, of_merge
from .together import proved, put_together


class Wanted(NamedTuple):
    """What an import is asked for: the words of it that a record has, and how to go on.

    ``keep_ours`` says that what both sides changed stays as it is here. ``arguments`` and ``packages`` are those that a
    description is compiled with.
    """

    words: Sequence[str]
    keep_ours: bool = False
    arguments: Mapping[str, str] = {}
    packages: Mapping[str, Path] = {}


class Again(NamedTuple):
    """What came of it: the files to write, those to remove, what there is to say; ``refused``: nothing is written.

    ``before`` are our files as they were read.
    """

    before: dict[str, str]
    files: dict[str, str]
    gone: list[str]
    diagnostics: list[Diagnostic]
    lines: list[str]
    refused: bool = False


def recorded(folder: Path, words: Sequence[str], others: Iterable[str] = ()) -> Record | None:
    """Return the record of the description in a folder; None if there is none. Raises WrongUsage for another import."""
    try:
        record = records.read(folder, others)
    except OSError as problem:
        raise WrongUsage(f"cannot read {folder}: {problem.strerror or type(problem).__name__}") from None
    if record is None or not world.stands(folder / Description.ROOT_FILE):
        return None
    before, now = (_said(one) for one in (record.words, words))
    if before.of != now.of:
        message = f"{folder} is of another import: rosorin-compile import {before.of}; this one is: {now.of}"
        raise WrongUsage(f"{message}; name a folder with -o, or another robot with --name")
    forgotten = [option for option in before.options if option not in now.options]
    if forgotten:
        message = f"{folder} was imported with {listed(forgotten)}: rosorin-compile import {shlex.join(record.words)}"
        raise WrongUsage(f"{message}; say so again, or name a folder with -o")
    return record


class _Said(NamedTuple):
    """The words of an import: the source with its arguments, and its options."""

    of: str
    options: list[str]


def _said(words: Sequence[str]) -> _Said:
    options = [word for word in words[1:] if word.startswith("--")]
    return _Said(shlex.join(takewhile(lambda word: word not in options, words)), options)


def imported_again(folder: Path, record: Record, files: Mapping[str, str], wanted: Wanted) -> Again:
    """Put ``files``, what the importer makes of the source now, together with what stands in a folder.

    Nothing is written here.
    """
    source = wanted.words[0]
    try:
        ours = {
            name: text_of(folder / name)
            for name in {**record.files, **files}
            if world.kind(folder / name) == world.FILE
        }
        together = put_together(record.files, ours, files, folder, wanted.keep_ours)
    except LoadError as problem:
        return Again({}, {}, [], [problem.diagnostic], [], refused=True)
    found = in_the_way(together, source, folder)
    if not found and together.taken:
        merge = proved(folder, record.files, files, together.files, wanted.arguments, wanted.packages)
        found = of_merge(merge, source, folder, wanted.keep_ours)
    if has_errors(found):
        return Again({}, {}, [], found, [], refused=True)
    written = {name: text for name, text in together.files.items() if text != ours.get(name)}
    made = {**written, **records.of(files, wanted.words)}
    return Again(ours, made, together.gone, found, list(merge_report(together, source)))


def remove(folder: Path, names: Iterable[str]) -> None:
    """Remove files that the newer source has nothing for, and their record. Raises OSError."""
    for name in names:
        for path in (folder / name, folder / f"{name}{ENDING}"):
            path.unlink(missing_ok=True)

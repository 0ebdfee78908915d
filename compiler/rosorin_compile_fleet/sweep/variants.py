"""Variants: a list of robots that are made of one description by other arguments.

The list is a CSV (a row a variant, the column ``name`` and arguments by column), a YAML or JSON file (a list of entries
with ``name``, or a mapping of names to arguments), or a folder with a YAML or JSON file a variant, called after it.

A list may have a million variants: it is read twice, and never held. The first time (``check``) says all that is wrong
with the list as a whole, before anything is done; of it stay eight bytes a name. What is wrong with one variant alone
goes with that variant. Text in a CSV is read as behind ``-a NAME=``, and an empty cell gives nothing.
"""

from __future__ import annotations

import csv
import hashlib
import os
import re
import unicodedata
from array import array
from bisect import bisect_left
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from io import TextIOWrapper
from itertools import pairwise
from pathlib import Path
from typing import Any, TextIO

from rosorin_compile import Variant
from rosorin_compile.diagnostics import (
    Diagnostic,
    Heading,
    Related,
    Rule,
    Source,
    Span,
    counted,
    did_you_mean,
    error,
    nearest,
    quoted,
)
from rosorin_compile.extending import (
    Description,
    Given,
    LoadError,
    Map,
    Text,
    each_entry,
    read_utf8,
    world,
)

RULES = (
    Rule(
        "variants-list",
        "A list of variants is not one: no CSV, no column `name`, a row of another length than the header, no entry.",
        "[How a list looks](sweep.md#the-list).",
        Heading.ARGUMENTS,
    ),
    Rule(
        "variant-name",
        "A variant has no name, one that no folder can have, or that of another variant.",
        "Give each variant a name of its own, such as r0007.",
        Heading.ARGUMENTS,
    ),
)

NAME = "name"
TABLES = (".csv", ".tsv")
TREES = (*Description.ENDINGS, ".json")
MAX_TOLD = 20  # mistakes of a list
MAX_NAME = 200  # bytes
_MAX_LINE = 1_000_000  # characters
_DELIMITERS = ",;\t|"
_RESERVED = ("sweep.json",)


class Row(Source):
    """Some lines of a file that is never held as a whole; ``first`` is the number of the first of them."""

    first = 1

    def line(self, number: int) -> str:
        """Return a line by its number in the file."""
        return super().line(number - self.first + 1)


class Names:
    """The names of all variants, eight bytes each: enough to know one again, and to find one that stands twice."""

    def __init__(self) -> None:
        self.buckets = [array("Q") for _ in range(256)]
        self.count = 0
        self.twice: set[int] = set()

    def add(self, name: str) -> None:
        """Take down a name."""
        digest = _digest(name)
        self.buckets[digest & 255].append(digest)
        self.count += 1

    def close(self) -> None:
        """Bring the names into order; ``twice`` has those that stand there more than once."""
        for index, bucket in enumerate(self.buckets):
            ordered = sorted(bucket)
            self.twice.update(one for one, other in pairwise(ordered) if one == other)
            self.buckets[index] = array("Q", ordered)

    def __contains__(self, name: object) -> bool:
        digest = _digest(str(name))
        bucket = self.buckets[digest & 255]
        place = bisect_left(bucket, digest)
        return place < len(bucket) and bucket[place] == digest

    def is_twice(self, name: str) -> bool:
        """Say whether a name stands there more than once, or as another one does on a disk that folds letters."""
        return bool(self.twice) and _digest(name) in self.twice


def _digest(name: str) -> int:
    folded = name.casefold() if name.isascii() else unicodedata.normalize("NFC", name).casefold()
    return int.from_bytes(hashlib.blake2b(folded.encode("utf-8", "surrogatepass"), digest_size=8).digest(), "little")


class Variants:
    """A list of variants in a file or a folder. ``check`` comes first; then it is iterated over, any number of times.

    ``arguments`` are the names of what the description declares. ``whole`` is the argument that takes each file of a
    folder as a whole; ``by_path``, that it takes its path, as seen from the folder ``home``.
    """

    def __init__(
        self, path: Path, arguments: Collection[str], whole: str = "", by_path: bool = False, home: Path | None = None
    ) -> None:
        self.path = path
        self.arguments = arguments
        self.whole, self.by_path, self.home = whole, by_path, home
        self.names = Names()

    def __len__(self) -> int:
        return self.names.count

    def __iter__(self) -> Iterator[Variant]:
        """Yield the variants in their order. Raises LoadError if the list is none any more."""
        if world.kind(self.path) == world.FOLDER:
            return self._of_folder()
        return self._of_table() if self.path.suffix.lower() in TABLES else self._of_tree()

    def check(self) -> list[Diagnostic]:
        """Return what is wrong with the list as a whole; ``names`` has the names then."""
        self.names = Names()
        wrong: list[Diagnostic] = []
        try:
            self._check_kind()
            if self.path.suffix.lower() in TABLES and world.kind(self.path) != world.FOLDER:
                wrong += self._wrong_columns()
            for variant in self._heads() if not wrong else ():
                self.names.add(variant.name)
                wrong += wrong_name(variant)
                if len(wrong) >= MAX_TOLD:
                    break
            self.names.close()
            wrong = wrong or list(self._repeated())
        except LoadError as problem:
            wrong.append(problem.diagnostic)
        if not wrong and not self.names.count:
            message, help = f"{world.shown(self.path)} has no variant", "write one row, entry or file for each"
            wrong.append(error("variants-list", message, None, help))
        return wrong

    def _check_kind(self) -> None:
        """Raise LoadError for what is no list by its name or its kind."""
        path, there = world.shown(self.path), world.kind(self.path)
        if there == world.FOLDER or (there == world.FILE and self.path.suffix.lower() in (*TABLES, *TREES)):
            return
        if not world.stands(self.path):
            raise LoadError(error("file-unreadable", f'there is no file or folder "{path}" of variants', None))
        message = f"{path} is not a regular file" if there != world.FILE else f"{path} is no list of variants"
        help = "name a file .csv, .yaml or .json, or a folder of .yaml or .json files"
        raise LoadError(error("variants-list", message, None, help))

    def _repeated(self) -> Iterator[Diagnostic]:
        """Yield an error for each name that stands twice."""
        first: dict[int, Span | None] = {}
        for variant in self._heads() if self.names.twice else ():
            if not self.names.is_twice(variant.name):
                continue
            digest = _digest(variant.name)
            if digest not in first:
                first[digest] = variant.span
            elif len(first) <= MAX_TOLD:
                related = [Related("first here", first[digest])]
                message = f'two variants are called "{variant.name}", up to capital letters'
                yield error("variant-name", message, variant.span, "each needs a folder of its own", related)

    # A table.

    def _rows(self) -> Iterator[tuple[Row, list[str], str]]:
        """Yield each row of a table that is not empty: its lines, its cells, and the letter between them."""
        path = world.shown(self.path)
        try:
            with TextIOWrapper(world.stream(self.path), "utf-8-sig", newline="") as file:
                yield from _table(file, path)
        except OSError as problem:
            message = f"cannot read {path}: {problem.strerror}"
            raise LoadError(error("file-unreadable", message, None, "check the name and the permissions")) from None
        except UnicodeDecodeError as problem:
            message = f"{path} is not UTF-8 text: {problem.reason}"
            help = 'save it as UTF-8; a spreadsheet calls that "CSV UTF-8"'
            raise LoadError(error("not-utf8", message, None, help)) from None

    def _of_table(self) -> Iterator[Variant]:
        rows = self._rows()
        _, named, delimiter = next(rows)
        names = [name.strip() for name in named]
        for row, cells, _ in rows:
            places = _places(row, delimiter)
            if len(cells) != len(names):
                raise LoadError(_uneven(places, cells, names))
            made = Map(Span(row, row.first, 1))
            name, span = "", Span(row, row.first, 1)
            for column, cell, place in zip(names, cells, places, strict=True):
                value = cell.strip()
                if column == NAME:
                    name, span = value, place
                elif value and not column:
                    message = "this cell stands in a column without a name"
                    raise LoadError(error("variants-list", message, place, "name the column, or empty the cell"))
                elif value:
                    made.put(column, value, place, place)
            yield Variant(name, made, span)

    def _wrong_columns(self) -> Iterator[Diagnostic]:
        """Yield what is wrong with the header of a table."""
        rows = self._rows()
        head = next(rows, None)
        rows.close()  # type: ignore[attr-defined]
        if head is None:
            message = f"{world.shown(self.path)} is empty"
            yield error("variants-list", message, None, "write a header: name, and a column for each argument")
            return
        header, cells, delimiter = head
        names = [cell.strip() for cell in cells]
        places = _places(header, delimiter)
        near = nearest(NAME, names) if NAME not in names else None
        if NAME not in names:
            help = "each variant needs a name" + (f'; call "{near}" so?' if near else "")
            message = f'{world.shown(self.path)} has no column "{NAME}"'
            yield error("variants-list", message, Span(header, header.first, 1, len(header.line(header.first))), help)
        for index, (name, place) in enumerate(zip(names, places, strict=True)):
            if name and name in names[:index]:
                yield error("variants-list", f'the column "{name}" stands twice', place, "remove one")
            elif name not in (NAME, "", near, *self.arguments):
                known = [one for one in self.arguments if one not in names]
                help = did_you_mean(name, known) or "it has none"
                yield error("unknown-argument", f'the description has no argument "{name}"', place, help)

    # A tree.

    def _of_tree(self) -> Iterator[Variant]:
        try:
            source = read_utf8(self.path, world.shown(self.path))
        except LoadError as problem:
            if problem.diagnostic.rule == "file-too-large":
                raise LoadError(replace(problem.diagnostic, help="a list as long as this is a CSV")) from None
            raise
        for entry in each_entry(_without_tabs(source, self.path)):
            key, value = entry.key, entry.value
            if key is None:
                yield _of_entry(value, entry.span)
            elif value is None:
                yield Variant(key, Map(entry.key_span), entry.key_span)
            elif isinstance(value, Map):
                yield Variant(key, value, entry.key_span, _expressions(value))
            else:
                message = f'variant "{key}" is no table of arguments'
                raise LoadError(error("variants-list", message, entry.span, "write NAME: {ARGUMENT: VALUE}"))

    # A folder.

    def _heads(self) -> Iterator[Variant]:
        """Yield the variants; those of a folder without their arguments, so that no file is read."""
        if world.kind(self.path) != world.FOLDER:
            yield from self
            return
        for path in self._files():
            start = Source(world.shown(path), "").start()
            yield Variant(path.stem, Map(start), start)

    def _of_folder(self) -> Iterator[Variant]:
        return map(self._of_file, self._files())

    def _files(self) -> Iterator[Path]:
        """Yield the files of a folder that are variants, by name. Raises LoadError."""
        try:
            inside = world.names(self.path)
        except OSError as problem:
            message = f"cannot read {world.shown(self.path)}: {problem.strerror}"
            raise LoadError(error("file-unreadable", message, None, "check the permissions")) from None
        return (self.path / name for name, what in inside.items() if what == world.FILE and _is_list(name))

    def _of_file(self, path: Path) -> Variant:
        """Return the variant of one file of a folder; what is wrong with the file is wrong with the variant."""
        source = Source(world.shown(path), "")
        start = source.start()
        if self.whole and self.by_path:
            made = Map(start)
            made.put(self.whole, Text(os.path.relpath(path, self.home)), start, start)
            return Variant(path.stem, made, start)
        try:
            is_json = path.suffix.lower() == ".json"
            values = mapping_of_json(path) if is_json else Map.load(path, world.shown(path))
        except LoadError as problem:
            diagnostic = problem.diagnostic
            if diagnostic.rule == "not-a-mapping":
                diagnostic = replace(diagnostic, message=f"{world.shown(path)} is no table of values", help="")
            return Variant(path.stem, Map(start), start, (diagnostic,))
        wrong = _expressions(values)
        if self.whole:
            made = Map(values.span)
            made.put(self.whole, values, values.span, values.span)
            values = made
        return Variant(path.stem, values, values.span, wrong)


def mapping_of_json(path: Path) -> Map:
    """Return the table of values in a JSON file, with their places. Raises LoadError."""
    entries = list(each_entry(_without_tabs(read_utf8(path, world.shown(path)), path)))
    made = Map(entries[0].key_span if entries else Source(world.shown(path), "").start())
    for entry in entries:
        if entry.key is None:
            raise LoadError(error("not-a-mapping", f"{world.shown(path)} is a list", entry.span))
        made.put(entry.key, entry.value, entry.key_span, entry.span)
    return made


def _is_list(name: str) -> bool:
    """Say whether a file of a folder is called as that of a variant is."""
    return name.lower().endswith(TREES) and not name.startswith(".")


def _without_tabs(source: Source, path: Path) -> Source:
    """Return JSON as YAML has it, which indents with no tabs; in the texts of JSON there are none."""
    return source._replace(text=source.text.replace("\t", " ")) if path.suffix.lower() == ".json" else source


def _of_entry(value: Any, span: Span) -> Variant:
    """Return the variant of an entry of a list, whose name stands among its arguments. Raises LoadError."""
    if not isinstance(value, Map):
        raise LoadError(error("variants-list", "this entry is no table", span, "write - {name: NAME, ARGUMENT: VALUE}"))
    if NAME not in value:
        raise LoadError(error("variant-name", "this entry has no name", span, "write name: NAME first"))
    made = Map(value.span)
    for key, one in value.items():
        if key != NAME:
            made.put(key, one, value.key_spans[key], value.value_spans[key])
    name, place = value[NAME], value.value_spans[NAME]
    # 0007 is the text of a name, not seven.
    text = name if isinstance(name, str) else place.source.line(place.line)[place.column - 1 :][: place.length]
    return Variant(str(text), made, place, _expressions(made))


def _expressions(values: Map) -> tuple[Diagnostic, ...]:
    """Return an error for each value that is to be calculated: a list holds values."""
    return tuple(
        error(
            "bad-argument",
            f'the argument "{name}" is an expression; a list of variants holds values',
            values.value_spans[name],
            "write its result",
        )
        for name in values.calculated()
    )


def wrong_name(variant: Variant) -> Iterator[Diagnostic]:
    """Yield an error if no folder can be called as a variant is."""
    name = variant.name
    if not name:
        yield error("variant-name", "this variant has no name", variant.span, "give it one of its own, such as r0007")
        return
    why = ""
    if name.startswith((".", "-")):
        why = f'begins with "{name[0]}"'
    elif bad := [letter for letter in dict.fromkeys(name) if letter in '/\\:*?"<>|' or not letter.isprintable()]:
        why = f"has {quoted(bad)}" if all(map(str.isprintable, bad)) else "has a letter that cannot be seen"
    elif len(name.encode("utf-8", "surrogatepass")) > MAX_NAME:
        why = f"is longer than {MAX_NAME} bytes"
    elif name.casefold() in _RESERVED:
        why = "is that of a file that the sweep writes"
    elif name.endswith((".", " ")):
        why = f'ends with "{name[-1]}"'
    if why:
        message = f'no folder is made for the variant "{name[:60]}": its name {why}'
        yield error("variant-name", message, variant.span, "use letters, digits, _, - and .")


class _Lines:
    """The lines of a table, and which of them were taken for the row at hand."""

    def __init__(self, file: TextIO, shown: str) -> None:
        self.file, self.shown = file, shown
        self.number = 0
        self.taken: list[str] = []

    def __iter__(self) -> Iterator[str]:
        while line := self.file.readline(_MAX_LINE):
            self.number += 1
            if len(line) == _MAX_LINE:
                message = f"line {self.number} of {self.shown} has more than {_MAX_LINE:,} letters"
                raise LoadError(error("variants-list", message, None, "is it a CSV?"))
            self.taken.append(line)
            yield line


def _table(file: TextIO, shown: str) -> Iterator[tuple[Row, list[str], str]]:
    delimiter = _delimiter(file)
    lines = _Lines(file, shown)
    rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
    csv.field_size_limit(_MAX_LINE)
    while True:
        lines.taken, first = [], lines.number + 1
        try:
            cells = next(rows, None)
        except csv.Error as problem:
            row = _row(shown, lines, first)
            message = f"this is no CSV: {problem}"
            help = 'a cell in quotes ends with a quote; a quote within is written ""'
            raise LoadError(error("variants-list", message, Span(row, row.first, 1), help)) from None
        if cells is None:
            return
        if any(map(str.strip, cells)) and not (first == 1 and _SEPARATOR.match("".join(lines.taken))):
            yield _row(shown, lines, first), cells, delimiter


def _row(shown: str, lines: _Lines, first: int) -> Row:
    row = Row(shown, "".join(lines.taken[:1000]))
    row.first = first
    return row


_SEPARATOR = re.compile(r"sep=(.)\r?\n?\Z", re.IGNORECASE)  # how a spreadsheet says what stands between cells


def _delimiter(file: TextIO) -> str:
    """Return the letter between cells: that which stands in the header most often, outside of quotes."""
    start = file.tell()
    line = file.readline(_MAX_LINE)
    said = _SEPARATOR.match(line)
    while line and not line.strip():
        line = file.readline(_MAX_LINE)
    file.seek(start)
    if said:
        return said.group(1)
    plain = re.sub('"[^"]*"', "", line)
    return max(_DELIMITERS, key=plain.count)


def _places(row: Row, delimiter: str) -> list[Span]:
    """Return the place of each cell of a row."""
    places, line, column, start = [], row.first, 1, (row.first, 1)
    length, within = 0, False
    for letter in row.text.rstrip("\r\n"):
        if letter == '"':
            within = not within
        if letter == delimiter and not within:
            places.append(Span(row, *start, max(1, length)))
            start, length = (line, column + 1), 0
        elif length or not letter.isspace():
            length += 1
        else:
            start = (line, column + 1)
        line, column = (line + 1, 1) if letter == "\n" else (line, column + 1)
    return [*places, Span(row, *start, max(1, length))]


def _uneven(places: Sequence[Span], cells: Sequence[str], names: Sequence[str]) -> Diagnostic:
    message = f"this row has {counted(len(cells), 'cell')}, and the header {len(names)}"
    more = len(cells) > len(names)
    help = "put what has a comma into quotes" if more else "an argument that is not given is an empty cell"
    return error("variants-list", message, places[len(names) if more else -1], help)


def given(variants: Iterable[tuple[str, Any]], origin: str) -> Iterator[Variant]:
    """Yield variants that a program gives: names with values of Python, or texts."""
    source = Source(origin, "")
    for name, arguments in variants:
        asked, wrong = Given.of(arguments)
        made = Map(source.start())
        made.update(asked.values())
        yield Variant(name, made, None, tuple(wrong))

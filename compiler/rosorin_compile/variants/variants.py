"""Read a list of variants: the name and the arguments for each robot of a sweep."""

import csv
import io
import os
import re
import unicodedata
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

from rosorin_compile.formats.compilation import Variant
from rosorin_compile.language.arguments import from_python
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Related, Source, Span, Suggestion, error, nearest
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.messages import add_suggestions
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map, Seq, Text

NAME = "name"
TABLES, TREES = (".csv", ".tsv"), (*Description.ENDINGS, ".json")
_MAX_NODES = 20_000_000  # maximum number of values in a list of variants
_SEPARATOR = re.compile(r"sep=(.)\r?\n?\Z", re.IGNORECASE)  # the optional first line of CSV files from spreadsheets


class Variants:
    """A list of variants in a CSV, TSV, YAML or JSON file, or in a folder of YAML or JSON files. Call ``check`` first.

    ``arguments`` are the names that the description declares. If ``whole`` names an argument, each file in a folder is
    the value of this argument: its contents or, if ``home`` is not None, its path relative to ``home``.
    """

    def __init__(self, path: Path, arguments: Collection[str], whole: str = "", home: Path | None = None) -> None:
        self.path, self.shown, self.arguments, self.whole, self.home = path, files.label(path), arguments, whole, home
        self.is_folder = files.is_folder(path)
        self.is_table = not self.is_folder and path.suffix.lower() in TABLES
        self._places: dict[str, Span | None] = {}  # key: case-folded name, because some file systems ignore case

    def __len__(self) -> int:
        return len(self._places)

    def __contains__(self, name: str) -> bool:
        return unicodedata.normalize("NFC", name).casefold() in self._places

    def __iter__(self) -> Iterator[Variant]:
        if self.is_folder:
            return map(self._from_file, self._files)
        return self._from_table() if self.is_table else self._from_tree()

    def check(self) -> list[Diagnostic]:
        """Return the errors that make the list unusable; errors in a single variant are part of the variant."""
        found: list[Diagnostic] = []
        try:
            if not os.path.lexists(self.path):
                raise _refused(f'there is no file or folder "{self.shown}" of variants', rule="file-unreadable")
            if not self.is_folder and not self.path.suffix.lower().endswith((*TABLES, *TREES)):
                help = "name a file .csv, .yaml or .json, or a folder of .yaml or .json files"
                raise _refused(f"{self.shown} is not a list of variants", help=help)
            found += self._wrong_columns() if self.is_table else ()
            for variant in map(_unread, self._files) if self.is_folder else () if found else self:
                name = unicodedata.normalize("NFC", variant.name).casefold()
                first = self._places.setdefault(name, variant.span)
                found += wrong_name(variant)
                if first is not variant.span:
                    message = f'two variants are called "{variant.name}", ignoring case'
                    related = [Related("first here", first)]
                    found.append(error("variant-name", message, variant.span, "each needs its own folder", related))
            if not found and not self._places:
                raise _refused(f"{self.shown} has no variant", help="write one row, entry or file for each")
        except LoadError as problem:
            found.append(problem.diagnostic)
        except OSError as problem:
            found.append(error("file-unreadable", f"cannot read {self.shown}: {problem.strerror}", None))
        return add_suggestions(found)

    @cached_property
    def _source(self) -> Source:
        return _read(self.path)

    @cached_property
    def _files(self) -> list[Path]:
        found = [path for path in sorted(self.path.iterdir()) if path.name.lower().endswith(TREES)]
        return [path for path in found if files.is_file(path) and not path.name.startswith(".")]

    def _rows(self) -> Iterator[tuple[list[str], list[Span]]]:
        """Yield (cells, positions of the cells) for each row that is not empty. Raises LoadError."""
        lines, first = io.StringIO(self._source.text, newline="").readlines(), 0
        header = next((line for line in lines if line.strip()), "")
        declared = _SEPARATOR.match(header)
        delimiter = declared[1] if declared else max(",;\t|", key=re.sub('"[^"]*"', "", header).count)
        rows = csv.reader(lines, delimiter=delimiter, skipinitialspace=True, strict=True)
        try:
            for cells in rows:
                text = "".join(lines[first : rows.line_num])
                if any(map(str.strip, cells)) and not _SEPARATOR.match(text):
                    # Send only this row to worker processes, after empty lines, so that its line number is right.
                    yield cells, _places(Source(self.shown, "\n" * first + text), text, first + 1, delimiter)
                first = rows.line_num
        except csv.Error as problem:
            help = 'close each quoted cell with a quote; write a quote inside one as ""'
            raise _refused(f"this is not a CSV: {problem}", Span(self._source, first + 1, 1), help) from None

    def _wrong_columns(self) -> Iterator[Diagnostic]:
        cells, places = next(self._rows(), ([], [self._source.span()]))
        names = [cell.strip() for cell in cells]
        if NAME not in names:
            near = nearest(NAME, names)
            help = f'rename the column "{near}"' if near else "write a header: name, and a column for each argument"
            place = places[0]._replace(column=1, length=len(places[0].source.line(places[0].line)) or 1)
            raise _refused(f'{self.shown} has no column "{NAME}"', place, help)
        for index, (name, place) in enumerate(zip(names, places, strict=True)):
            if name and name in names[:index]:
                yield error("variants-list", f'there are two columns "{name}"', place, "remove one")
            elif name not in (NAME, "", *self.arguments):
                left = [one for one in self.arguments if one not in names]
                message = f'the description has no argument "{name}"'
                yield error("unknown-argument", message, place, Suggestion(name, left, none="it has none"))

    def _from_table(self) -> Iterator[Variant]:
        rows = self._rows()
        names = [name.strip() for name in next(rows)[0]]
        for cells, places in rows:
            if len(cells) != len(names):
                help = "quote a cell that contains a comma; leave that of an argument empty to use its default"
                message = f"the length of this row is {len(cells)}, that of the header {len(names)}"
                raise _refused(message, places[min(len(cells) - 1, len(names))], help)
            start = places[0]._replace(column=1, length=1)
            name, name_place, values = "", start, Map(start)
            for column, cell, place in zip(names, map(str.strip, cells), places, strict=True):
                if column == NAME:
                    name, name_place = cell, place
                elif cell and not column:
                    raise _refused("this cell is in a column without a name", place, "name the column")
                elif cell:
                    values.put(column, cell, place, place)
            yield Variant(name, values, name_place)

    def _from_tree(self) -> Iterator[Variant]:
        tree = parse_yaml(self._source, max_nodes=_MAX_NODES)
        if tree is None:
            return
        if not isinstance(tree, (Map, Seq)):
            message = f"{self._source.path} is a text"
            raise _refused(message, self._source.span(), "write a list or a mapping", "not-a-mapping")
        is_named = isinstance(tree, Map)
        spans = [*tree.value_spans.values()] if isinstance(tree, Map) else tree.value_spans
        for key, value, span in zip(tree, tree.values() if isinstance(tree, Map) else tree, spans, strict=True):
            if not isinstance(value, Map) and not (is_named and value is None):
                raise _refused("this variant is not a table of arguments", span, "write NAME: {ARGUMENT: VALUE}")
            key_span = tree.key_spans[key] if isinstance(tree, Map) else span
            values = Map(key_span) if value is None else value
            yield Variant(key, values, key_span, _expressions(values)) if is_named else _from_entry(values)

    def _from_file(self, path: Path) -> Variant:
        variant = _unread(path)
        arguments = variant.arguments
        if self.whole and self.home:
            arguments.put(self.whole, Text(os.path.relpath(path, self.home)), arguments.span, arguments.span)
            return variant
        try:
            values = parse_yaml(_read(path))
            if not isinstance(values, Map):
                raise _refused(f"{files.label(path)} is not a table of values", arguments.span, rule="not-a-mapping")
        except LoadError as problem:
            return replace(variant, diagnostics=(problem.diagnostic,))
        if self.whole:
            arguments.put(self.whole, values, values.span, values.span)
        return Variant(path.stem, arguments if self.whole else values, values.span, _expressions(values))


def _refused(message: str, place: Span | None = None, help: str = "", rule: str = "variants-list") -> LoadError:
    return LoadError(error(rule, message, place, help))


def _read(path: Path) -> Source:
    source = read_utf8(path, files.label(path))
    # Replace tabs, because JSON allows them as indentation, but YAML does not; JSON strings contain no tabs.
    return source._replace(text=source.text.replace("\t", " ")) if path.suffix.lower() == ".json" else source


def _unread(path: Path) -> Variant:
    start = Source(files.label(path), "").span()
    return Variant(path.stem, Map(start), start)


def _from_entry(entry: Map) -> Variant:
    if NAME not in entry:
        raise _refused("this entry has no name", entry.span, "write name: NAME first", "variant-name")
    name, place, values = entry[NAME], entry.value_spans[NAME], Map(entry.span)
    for key in (key for key in entry if key != NAME):
        values.put_from(entry, key)
    if not isinstance(name, str):  # keep the text of a name such as 0007 instead of the number 7
        name = place.source.line(place.line)[place.column - 1 :][: place.length]
    return Variant(name, values, place, _expressions(values))


def _expressions(values: Map) -> tuple[Diagnostic, ...]:
    message, help = 'the argument "{}" is an expression; a list of variants contains values', "write its result"
    names = values.expression_keys()
    return tuple(error("bad-argument", message.format(name), values.value_spans[name], help) for name in names)


def python_variant(entry: Any) -> Variant:
    """Create a variant from (name, arguments), or from a mapping of arguments that includes ``name``."""
    if isinstance(entry, Mapping):
        name, arguments = entry.get(NAME, ""), {key: value for key, value in entry.items() if key != NAME}
    else:
        name, arguments = entry if isinstance(entry, (tuple, list)) and len(entry) == 2 else ("", entry)
    values, wrong = from_python({} if arguments is None else arguments)
    tree = Map(Source("variants", "").span())
    tree.update(values)
    variant = Variant(name if isinstance(name, str) else "", tree)
    return replace(variant, diagnostics=(*wrong, *wrong_name(variant)))


def wrong_name(variant: Variant) -> Iterator[Diagnostic]:
    """Yield an error if the name of a variant cannot be the name of a folder."""
    name = variant.name.lower()
    is_bad = any(letter in '/\\:*?"<>|' or not letter.isprintable() for letter in name)
    if name in ("", "sweep.json") or is_bad or name[0] in ".-" or name[-1] in ". " or len(os.fsencode(name)) > 200:
        help = "use letters, digits, _, - and inner dots, at most 200 bytes, such as r0007"
        yield error("variant-name", f'"{name[:60]}" cannot be the name of a variant and its folder', variant.span, help)


def _places(source: Source, text: str, first: int, delimiter: str) -> list[Span]:
    """Return the position of each cell in a row (``text``); ``first`` is the line number of the row."""
    places, at = list[Span](), 0
    masked = re.sub('"[^"]*"', lambda quoted: "_" * len(quoted[0]), text.rstrip("\r\n"))
    for cell in masked.split(delimiter):
        start = at + len(cell) - len(cell.lstrip())
        line, column = first + text.count("\n", 0, start), start - text.rfind("\n", 0, start)
        places.append(Span(source, line, column, max(1, len(cell.strip()))))
        at += len(cell) + 1
    return places

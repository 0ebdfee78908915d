"""Uniting: a file of several robots that has all that each of them needs of it, and stays as somebody has written it.

What a robot needs more is put behind what is there: parts, named values, arguments and materials, with their comments.
What is there under its name already has to be the same value; ``Apart`` says where it is not. Entries that a robot has
whether it asks for them or not (links, joints, uses) have to be the same on both sides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import zip_longest
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.tree import Map

ASKED_FOR = ("args", "let", "materials", "parts")  # what does nothing until it is named
_KINDS = {"args": "argument", "let": "value", "materials": "material", "parts": "part"}
_MOST = 60


class Apart(NamedTuple):
    """Why two files are not one: the section and the entry in which they differ, in words, and the line there."""

    section: str
    name: str
    words: str
    line: int

    @property
    def entry(self) -> str:
        """The entry in words."""
        return f'{_KINDS.get(self.section, self.section)} "{self.name}"' if self.name else self.section


class United(NamedTuple):
    """The text of both files, or why there is none."""

    text: str
    apart: tuple[Apart, ...] = ()


def united(there: str, own: str, theirs: bool = False) -> United:
    """Return a file with what another has more; with ``theirs``, entries that both have stay as they are there."""
    try:
        one, other = parse_yaml(Source("", there)), parse_yaml(Source("", own))
    except LoadError as problem:
        return United("", (Apart("it", "", "cannot be read", _line(problem)),))
    if not isinstance(one, Map) or not isinstance(other, Map):
        return United("", (Apart("it", "", "is no description", 1),))
    apart = tuple(_apart(one, other, theirs))
    if apart:
        return United("", apart)
    for section in other:
        lacks = [key for key in other[section] if key not in one.get(section, ())] if section in ASKED_FOR else []
        if lacks:
            there = _with(there, own, section, lacks)
    grown = parse_yaml(Source("", there))
    wanted = {**one, **{key: {**one.get(key, {}), **other[key]} for key in other if key in ASKED_FOR and not theirs}}
    if not theirs and not _same(grown, wanted):
        return United("", (Apart("it", "", "is written in a way that cannot be added to", 1),))
    return United(there)


def renewed(record: str, text: str) -> str:
    """Return a shared file as an import wrote it, with its entries as one robot needs them now; the others stay."""
    made, wanted = record, {}
    try:
        old, new = parse_yaml(Source("", record)), parse_yaml(Source("", text))
        for section, entries in new.items():
            before = old.get(section, Map(entries.span)) if isinstance(entries, Map) else None
            if not isinstance(before, Map):
                wanted[section] = entries
                continue
            wanted[section] = {**before, **entries}
            for key in entries:
                if key in before and not _same(before[key], entries[key]):
                    made = _replaced(made, text, section, key)
            added = [key for key in entries if key not in before]
            if added:
                made = _with(made, text, section, added)
        return made if _same(parse_yaml(Source("", made)), {**old, **wanted}) else text
    except LoadError:  # an entry is not on lines of its own
        return text


def with_more(record: str, before: str, after: str) -> str:
    """Return the record of a shared file with the entries that a robot has added to the file."""
    own, new = parse_yaml(Source("", before)), parse_yaml(Source("", after))
    for section in ASKED_FOR:
        there = parse_yaml(Source("", record)).get(section, ())
        added = [key for key in new.get(section, ()) if key not in own.get(section, ()) and key not in there]
        if added:
            record = _with(record, after, section, added)
    return record


def _line(problem: LoadError) -> int:
    return problem.diagnostic.span.line if problem.diagnostic.span else 1


def _apart(one: Map, other: Map, theirs: bool) -> Iterator[Apart]:
    for section in dict.fromkeys((*other, *one)):
        line = one.key_spans[section].line if section in one else 1
        asked = section in ASKED_FOR
        if section not in one or section not in other:
            if not asked and not (theirs and section in one):
                sides = ("are there", "are none here") if section in one else ("are none there", "some here")
                yield Apart(section, "", ", and ".join(sides), line)
            continue
        mine, yours = one[section], other[section]
        if not isinstance(mine, Map) or not isinstance(yours, Map):
            if not _same(mine, yours) and not theirs:
                yield Apart(section, "", *_difference(mine, yours, line))
            continue
        if asked and line == next(iter(mine.key_spans.values())).line and any(key not in mine for key in yours):
            yield Apart(section, "", "stands on one line there", line)
        yield from _entries_apart(section, mine, yours, theirs, line)


def _entries_apart(section: str, mine: Map, yours: Map, theirs: bool, line: int) -> Iterator[Apart]:
    asked = section in ASKED_FOR
    names = {_called(key): key for key in mine}
    for key in yours:
        known = names.get(_called(key))
        if known is None:
            if not asked:
                yield Apart(section, key, "is not there", line)
        elif known != key:
            yield Apart(section, _called(key), f"is {known} there, and {key} here", mine.key_spans[known].line)
        elif not theirs and not _same(mine[key], yours[key]):
            yield Apart(section, key, *_difference(mine[key], yours[key], mine.key_spans[key].line))
    for key in mine if not asked and not theirs else ():
        if key not in yours:
            yield Apart(section, key, "is there, and not here", mine.key_spans[key].line)


def _called(key: str) -> str:
    return key.partition("(")[0]


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    return isinstance(one, bool) == isinstance(other, bool) and bool(one == other)


def _difference(one: Any, other: Any, line: int) -> tuple[str, int]:
    path: list[str] = []
    while True:
        pairs: list[tuple[Any, Any, Any]] = []
        if isinstance(one, Map) and isinstance(other, Map):
            pairs = [(key, one.get(key), other.get(key)) for key in dict.fromkeys((*one, *other))]
        elif isinstance(one, list) and isinstance(other, list):
            pairs = [(at, *pair) for at, pair in enumerate(zip_longest(one, other))]
        found = next((pair for pair in pairs if not _same(*pair[1:])), None)
        if found is None:
            where = " ".join(path)
            return f"{where} is {_said(one)} there, and {_said(other)} here".strip(), line
        spans = getattr(one, "value_spans", None)
        if isinstance(spans, Mapping):
            line = spans[found[0]].line if found[0] in spans else line
            path.append(str(found[0]))
        elif spans is not None and found[0] < len(spans):
            line = spans[found[0]].line
        one, other = found[1:]


def _said(value: Any) -> str:
    if value is None:
        return "nothing"
    text = " ".join(str(value).split())
    text = str(value).lower() if isinstance(value, bool) else text
    return text if len(text) <= _MOST else f"{text[:_MOST]}..."


def _with(there: str, own: str, section: str, keys: Sequence[str]) -> str:
    one, other = parse_yaml(Source("", there)), parse_yaml(Source("", own))
    lines, others = there.rstrip("\n").split("\n"), own.rstrip("\n").split("\n")
    entries = {key: _block(others, other, section, key) for key in keys}
    if section not in one:
        after = list(other)[list(other).index(section) + 1 :]
        follows = next((key for key in after if key in one), None)
        at = _first(lines, one.key_spans[follows].line) if follows else len(lines)
        at = at or (one.key_spans[follows].line - 1 if follows else 0)  # what begins a file stays at its beginning
        made = [f"{section}:", *_parted(entries.values())]
        made = [*made, ""] if follows else ["", *made]
        return "\n".join([*lines[:at], *made, *lines[at:]]) + "\n"
    last = list(one[section])[-1]
    block = _block(lines, one, section, last)
    end = _first(lines, one[section].key_spans[last].line) + len(block)
    pad = one[section].key_spans[last].column - other[section].key_spans[keys[0]].column
    moved = [[_indented(line, pad) for line in entry] for entry in entries.values()]
    made = _parted([block, *moved])[len(block) :]
    return "\n".join([*lines[:end], *made, *lines[end:]]) + "\n"


def _replaced(there: str, own: str, section: str, key: str) -> str:
    one, other = parse_yaml(Source("", there)), parse_yaml(Source("", own))
    lines = there.rstrip("\n").split("\n")
    at = _first(lines, one[section].key_spans[key].line)
    entry = _block(own.rstrip("\n").split("\n"), other, section, key)
    pad = one[section].key_spans[key].column - other[section].key_spans[key].column
    lines[at : at + len(_block(lines, one, section, key))] = [_indented(line, pad) for line in entry]
    return "\n".join(lines) + "\n"


def _parted(entries: Iterable[list[str]]) -> list[str]:
    made: list[str] = []
    before = 0
    for entry in entries:
        made += [""] if made and (before > 1 or len(entry) > 1) else []
        made += entry
        before = len(entry)
    return made


def _indented(line: str, pad: int) -> str:
    return line if not line.strip() or not pad else " " * pad + line if pad > 0 else line[-pad:]


def _block(lines: Sequence[str], tree: Map, section: str, key: str) -> list[str]:
    entries: Map = tree[section]
    starts = [entries.key_spans[one].line for one in entries] + [tree.key_spans[one].line for one in tree]
    start = entries.key_spans[key].line
    after = [line for line in starts if line > start]
    end = _first(lines, min(after)) if after else len(lines)
    found = list(lines[_first(lines, start) : end])
    while found and not found[-1].strip():
        found.pop()
    return found


def _first(lines: Sequence[str], line: int) -> int:
    at = line - 1
    pad = len(lines[at]) - len(lines[at].lstrip())
    while at and lines[at - 1].startswith(" " * pad + "#"):
        at -= 1
    return at

"""Merge files that several robots of a package share: what one robot needs in addition is put behind what is there.

Parts, named values, arguments and materials are added with their comments; what has the same name must have the same
value. Links, joints and uses, which a robot has without asking for them, must be equal on both sides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.tree import Map

ON_DEMAND = ("args", "let", "materials", "parts")  # sections without effect until something names an entry
_KINDS = {"args": "argument", "let": "value", "materials": "material", "parts": "part"}


class Merged(NamedTuple):
    """The text of both files; without one, the entry that differs, with its line, and why."""

    text: str
    name: str = ""
    line: int = 1
    reason: str = ""


def merged(there: str, own: str, keep: bool = False) -> Merged:
    """Return a file with what another has in addition; with ``keep``, entries of both stay as they are there."""
    try:
        one, other = _parsed(there), _parsed(own)
    except LoadError as problem:
        return Merged("", line=problem.diagnostic.span.line if problem.diagnostic.span else 1, reason="cannot be read")
    difference = next(_differences(one, other, keep), None)
    if difference is not None:
        return difference
    for section in other:
        missing = [key for key in other[section] if key not in one.get(section, ())] if section in ON_DEMAND else []
        if missing:
            there = _inserted(there, own, section, missing)
    wanted = {**one, **{key: {**one.get(key, {}), **other[key]} for key in other if key in ON_DEMAND and not keep}}
    if not keep and not _same(_parsed(there), wanted):
        return Merged("", reason="is written in a way that cannot be added to")
    return Merged(there)


def renewed(record: str, text: str) -> str:
    """Return a shared file as an import wrote it, with its entries as one robot needs them now; the others stay."""
    made, wanted = record, {}
    try:
        old, new = _parsed(record), _parsed(text)
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
                made = _inserted(made, text, section, added)
        return made if _same(_parsed(made), {**old, **wanted}) else text
    except LoadError:  # an entry is not on lines of its own
        return text


def with_more(record: str, before: str, after: str) -> str:
    """Return the record of a shared file with the entries that a robot has added to the file."""
    own, new = _parsed(before), _parsed(after)
    for section in ON_DEMAND:
        there = _parsed(record).get(section, ())
        added = [key for key in new.get(section, ()) if key not in own.get(section, ()) and key not in there]
        if added:
            record = _inserted(record, after, section, added)
    return record


def _parsed(text: str) -> Map:
    """Return a file as a mapping. Raises LoadError."""
    tree = parse_yaml(Source("", text))
    return tree if isinstance(tree, Map) else Map(Source("", text).span())


def _differences(one: Map, other: Map, keep: bool) -> Iterator[Merged]:
    """Yield the entries for which two files have different values."""
    for section in dict.fromkeys((*other, *one)):
        on_demand = section in ON_DEMAND
        line = one.key_spans[section].line if section in one else 1
        if section not in one or section not in other:
            if not on_demand and not (keep and section in one):
                yield Merged("", section, line, f"only one of the two files has {section}")
            continue
        mine, theirs = one[section], other[section]
        if not isinstance(mine, Map) or not isinstance(theirs, Map):
            if not _same(mine, theirs) and not keep:
                yield Merged("", section, line, f"{section} differs")
            continue
        if on_demand and line == next(iter(mine.key_spans.values())).line and any(key not in mine for key in theirs):
            yield Merged("", section, line, f"{section} is written on one line")
        names = {key.partition("(")[0]: key for key in mine}
        for key in theirs:
            name = key.partition("(")[0]
            known = names.get(name)
            if known is None and on_demand:
                continue
            if known != key or not (keep or _same(mine[key], theirs[key])):
                at = mine.key_spans[known].line if known is not None else line
                yield Merged("", name, at, f'{_KINDS.get(section, section)} "{name}" differs')
        for key in mine if not on_demand and not keep else ():
            if key not in theirs:
                yield Merged("", key, mine.key_spans[key].line, f'{section} "{key}" is not in both')


def _same(one: Any, other: Any) -> bool:
    """Return True if two values are equal; true is not 1."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    return isinstance(one, bool) == isinstance(other, bool) and bool(one == other)


def _inserted(there: str, own: str, section: str, keys: Sequence[str]) -> str:
    """Return a text with entries of another in one of its sections, behind those that are there."""
    one, other = _parsed(there), _parsed(own)
    lines, others = there.rstrip("\n").split("\n"), own.rstrip("\n").split("\n")
    entries = {key: _entry_lines(others, other, section, key) for key in keys}
    if section not in one:
        after = list(other)[list(other).index(section) + 1 :]
        follows = next((key for key in after if key in one), None)
        at = _first(lines, one.key_spans[follows].line) if follows else len(lines)
        at = at or (one.key_spans[follows].line - 1 if follows else 0)  # what begins a file stays at its beginning
        made = [f"{section}:", *_separated(entries.values())]
        made = [*made, ""] if follows else ["", *made]
        return "\n".join([*lines[:at], *made, *lines[at:]]) + "\n"
    last = list(one[section])[-1]
    block = _entry_lines(lines, one, section, last)
    end = _first(lines, one[section].key_spans[last].line) + len(block)
    pad = one[section].key_spans[last].column - other[section].key_spans[keys[0]].column
    moved = [[_indented(line, pad) for line in entry] for entry in entries.values()]
    made = _separated([block, *moved])[len(block) :]
    return "\n".join([*lines[:end], *made, *lines[end:]]) + "\n"


def _replaced(there: str, own: str, section: str, key: str) -> str:
    """Return a text with an entry as another text has it."""
    one, other = _parsed(there), _parsed(own)
    lines = there.rstrip("\n").split("\n")
    at = _first(lines, one[section].key_spans[key].line)
    entry = _entry_lines(own.rstrip("\n").split("\n"), other, section, key)
    pad = one[section].key_spans[key].column - other[section].key_spans[key].column
    lines[at : at + len(_entry_lines(lines, one, section, key))] = [_indented(line, pad) for line in entry]
    return "\n".join(lines) + "\n"


def _separated(entries: Iterable[list[str]]) -> list[str]:
    """Return the lines of entries, with an empty line around those of several lines."""
    made: list[str] = []
    before = 0
    for entry in entries:
        made += [""] if made and (before > 1 or len(entry) > 1) else []
        made += entry
        before = len(entry)
    return made


def _indented(line: str, pad: int) -> str:
    return line if not line.strip() or not pad else " " * pad + line if pad > 0 else line[-pad:]


def _entry_lines(lines: Sequence[str], tree: Map, section: str, key: str) -> list[str]:
    """Return the lines of an entry, with the comments above it."""
    entries: Map = tree[section]
    starts = [entries.key_spans[one].line for one in entries] + [tree.key_spans[one].line for one in tree]
    start = entries.key_spans[key].line
    after = [line for line in starts if line > start]
    end = _first(lines, min(after)) if after else len(lines)
    return "\n".join(lines[_first(lines, start) : end]).rstrip().split("\n")


def _first(lines: Sequence[str], line: int) -> int:
    """Return the index of the first line of an entry: that of the comments above it."""
    at = line - 1
    pad = len(lines[at]) - len(lines[at].lstrip())
    while at and lines[at - 1].startswith(" " * pad + "#"):
        at -= 1
    return at

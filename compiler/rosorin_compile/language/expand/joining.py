"""Joining: the sections of several files and parts become those of one tree."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, Related
from rosorin_compile.source.tree import Map, Place, Seq

from ..annotations import ENTRIES, ITEMS
from ..misnamed import word_meant
from ..schema import holds_many, is_one_entry, keys_of, merged
from ..validate import validate
from .provenance import argument_behind
from .scope import Scope

OF_PARTS = ("parts", "sensor_types", "use")  # joined by name, although the schema of results has no such sections


class Clash(NamedTuple):
    """A name, a key or a whole section that two fragments have; ``rule`` tells which."""

    rule: str
    section: str
    name: str
    first: Map
    second: Map

    def report(self, scope: Scope) -> None:
        """Report the clash, at the argument that a name comes from if it has one."""
        rule, section, name = self.rule, self.section, self.name
        place = Place(self.second.key_spans[name], getattr(self.second[name], "via", None) or self.second.via)
        related = [Related("first defined here", self.first.key_spans[name])]
        if rule == "unknown-key":
            message, help, related = f'{section} has no key "{name}"', word_meant(name, keys_of(section)), []
        elif rule == "duplicate-name":
            help = "rename or remove one, or give the part another prefix"
            message = f'{section.rstrip("s")} "{name}" is defined twice'
        elif not _is_joined(name):
            related += Place(self.first.key_spans[name], getattr(self.first[name], "via", None)).stack()
            message, help = f'"{name}" is said twice', "remove one"
        else:
            kind = "a list" if name in merged(ITEMS) else "a mapping"
            rule, message, help = "wrong-type", f"{name} is {kind} in every file", "write it so in both"
            if not isinstance(self.first[name], Seq if name in merged(ITEMS) else Map):
                return  # validation reports it
        origin = argument_behind(scope.expansion.root, place)
        scope.report_origin(rule, message, place, help, related, origin)

    def shape_errors(self, tree: Map) -> list[Diagnostic]:
        """Return the errors of the section in one of the fragments, which is not validated if it is not joined."""
        alone = Map(tree.span, tree.via)
        alone.put("robot", "robot", tree.span, tree.span)
        alone.put(self.name, tree[self.name], tree.key_spans[self.name], tree.value_spans[self.name])
        return validate(alone, {})


def join(tree: Map, more: Map, parts: bool = False) -> list[Clash]:
    """Add the sections of a fragment to a tree, and return what cannot be added.

    ``parts``: the fragment comes from a part, whose entries know what made them.
    """
    clashes: list[Clash] = []
    for section, value in more.items():
        have = tree.get(section)
        if have is None:
            if value is not None or not parts:
                tree.put(section, copy(value), more.key_spans[section], more.value_spans[section])
        elif isinstance(have, Seq) and isinstance(value, Seq) and section in merged(ITEMS):
            _extend(have, value)
        elif isinstance(have, Map) and isinstance(value, Map) and _is_joined(section):
            clashes += (_join_within if holds_many(section) else _join_entries)(section, have, value)
        elif value is not None:
            clashes.append(Clash("duplicate-key", "", section, tree, more))
            continue
        if parts and isinstance(tree.get(section), (Map, Seq)) and (have is not None or not is_one_entry(section)):
            tree[section].via = tree.via  # it holds the entries of others too: each entry knows what made it
    return clashes


def _is_joined(section: str) -> bool:
    return section in merged(ENTRIES, ITEMS) or holds_many(section) or section in OF_PARTS


def _extend(have: Seq, more: Seq) -> None:
    have.extend(more)
    have.value_spans.extend(more.value_spans)


def _join_entries(section: str, have: Map, more: Map) -> Iterator[Clash]:
    for name, entry in more.items():
        if name in have:
            yield Clash("duplicate-name", section, name, have, more)
        else:
            have.put(name, entry, more.key_spans[name], more.value_spans[name])


def _join_within(section: str, have: Map, more: Map) -> Iterator[Clash]:
    """Add the tables and lists of one entry to those of another, and yield what both define differently."""
    for key, value in more.items():
        mine = have.get(key)
        if mine is None:
            have.put(key, copy(value), more.key_spans[key], more.value_spans[key])
        elif key not in keys_of(section):
            yield Clash("unknown-key", section, key, have, more)
        elif isinstance(mine, Seq) and isinstance(value, Seq):
            have[key] = joined = copy(mine)
            _extend(joined, value)
        elif _is_table_of_entries(mine) and _is_table_of_entries(value):
            have[key] = joined = copy(mine)
            for name, entry in value.items():
                if name not in joined:
                    joined.put(name, entry, value.key_spans[name], value.value_spans[name])
                elif not _is_same(name, joined, value):
                    yield Clash("duplicate-name", key, name, joined, value)
        elif not _is_same(key, have, more):
            yield Clash("duplicate-name", section, key, have, more)


def _is_table_of_entries(value: Any) -> bool:
    return isinstance(value, Map) and all(isinstance(item, (Map, Seq)) for item in value.values())


def _is_same(key: str, have: Map, more: Map) -> bool:
    """Return True if two uses of one part define a key equally, about something outside of the part."""
    return bool(have[key] == more[key]) and have.value_spans[key] == more.value_spans[key]


def copy(value: Any) -> Any:
    """Return a mapping or a list of the same entries, which may grow."""
    if isinstance(value, Map):
        return value.copied()
    if isinstance(value, Seq):
        made = Seq(value.span, value.via)
        _extend(made, value)
        return made
    return value


def with_source(tree: Map, owner: Map) -> Map:
    """Return sections in which every entry has a source: its own, or that of ``owner``, a use."""
    made = tree.copied()
    for section, entries in tree.items():
        if isinstance(entries, Map) and not holds_many(section):
            made[section] = _sourced(entries, owner) if is_one_entry(section) else sourced(entries, owner)
    return made


def sourced(section: Map, owner: Map) -> Map:
    """Return a section in which every entry has a source: its own, or that of ``owner``, a file or a use."""
    made = section.copied()
    for name, entry in section.items():
        made[name] = _sourced(entry, owner) if isinstance(entry, Map) else entry
    return made


def _sourced(entry: Map, owner: Map) -> Map:
    made = entry.copied()
    if "source" not in entry:
        made.put("source", owner["source"], owner.key_spans["source"], owner.value_spans["source"])
    return made

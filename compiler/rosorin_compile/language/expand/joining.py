"""Joining: the sections of several files and parts become those of one tree."""

from __future__ import annotations

from functools import partial
from typing import Any

from rosorin_compile.source.diagnostics import Related
from rosorin_compile.source.tree import Include, Map, Place, Seq

from ..annotations import ENTRIES, ITEMS
from ..schema import holds_many, is_one_entry, keys_of, merged_sections
from ..suggestions import word_meant
from ..validate import validate
from .provenance import argument_behind
from .scope import Scope

OF_PARTS = ("parts", "sensor_types", "use")  # joined by name, although the schema of results has no such sections


def join(tree: Map, more: Map, scope: Scope, parts: bool = False) -> bool:
    """Add the sections of a fragment to a tree; report what cannot be added, and return True if there is nothing.

    ``parts``: the fragment comes from a part, whose entries know what made them.
    """
    good = True
    for section, value in more.items():
        have = tree.get(section)
        for key in value if parts and holds_many(section) and isinstance(value, Map) else ():
            if key not in keys_of(section):
                place, message = Place(value.key_spans[key], more.via or value.via), f'{section} has no key "{key}"'
                help, origin = partial(word_meant, key, keys_of(section)), argument_behind(scope.expansion.root, place)
                scope.report_origin("unknown-key", message, place, help, (), origin)
                good = False
        if have is None:
            if value is not None or not parts:
                tree.put(section, copy(value), more.key_spans[section], more.value_spans[section])
        elif isinstance(have, Seq) and isinstance(value, Seq) and section in merged_sections(ITEMS):
            _extend(have, value)
        elif isinstance(have, Map) and isinstance(value, Map) and _is_joined(section):
            if holds_many(section):
                good &= _join_within(section, have, value, scope)
            else:  # two calls of a macro have the materials of its file
                good &= _join_entries(section, have, value, scope, equal=section == "materials")
        elif value is not None:
            good &= _report_section(section, tree, more, scope)
            continue
        joined = tree.get(section)
        holds_others = isinstance(joined, (Map, Seq)) and (have is not None or not is_one_entry(section))
        # Each entry of a part knows what made it; an include also leads to the entries of other files.
        if parts and joined is not None and holds_others and not isinstance(joined.via, Include):
            joined.via = tree.via
    return good


def _report_section(section: str, tree: Map, more: Map, scope: Scope) -> bool:
    if not _is_joined(section):
        _report("duplicate-key", f'"{section}" is defined twice', "remove one", section, tree, more, scope)
        for fragment in (tree, more) if scope.expansion.parts else ():
            alone = Map(fragment.span, fragment.via)
            alone.put("robot", "robot", fragment.span, fragment.span)
            alone.put(section, fragment[section], fragment.key_spans[section], fragment.value_spans[section])
            scope.expansion.diagnostics += validate(alone, {})
        return False
    is_list = section in merged_sections(ITEMS)
    if not isinstance(tree[section], Seq if is_list else Map):
        return True
    message = f"{section} is {'a list' if is_list else 'a mapping'} in every file"
    return _report("wrong-type", message, "write it so in both", section, tree, more, scope)


def _report(rule: str, message: str, help: str, name: str, first: Map, second: Map, scope: Scope) -> bool:
    """Report a name of two mappings, at the argument that it comes from if it has one; return False."""
    place = Place(second.key_spans[name], getattr(second[name], "via", None) or second.via)
    earlier = Place(first.key_spans[name], getattr(first[name], "via", None) if rule == "duplicate-key" else None)
    related = [Related("first defined here", earlier.span), *earlier.stack()]
    scope.report_origin(rule, message, place, help, related, argument_behind(scope.expansion.root, place))
    return False


def _is_joined(section: str) -> bool:
    return section in merged_sections(ENTRIES, ITEMS) or holds_many(section) or section in OF_PARTS


def _extend(have: Seq, more: Seq) -> None:
    have.extend(more)
    have.value_spans.extend(more.value_spans)


def _join_entries(section: str, have: Map, more: Map, scope: Scope, equal: bool = False) -> bool:
    """Add the entries of a mapping to another; report those of both, with ``equal`` only those that differ."""
    good = True
    for name, entry in more.items():
        if name not in have:
            have.put(name, entry, more.key_spans[name], more.value_spans[name])
        elif not (equal and have[name] == entry and have.value_spans[name] == more.value_spans[name]):
            message = f'{section.rstrip("s")} "{name}" is defined twice'
            help = "rename or remove one, or give the part another prefix"
            good = _report("duplicate-name", message, help, name, have, more, scope)
    return good


def _join_within(section: str, have: Map, more: Map, scope: Scope) -> bool:
    good, others = True, Map(more.span, more.via)
    for key, value in more.items():
        mine = have.get(key)
        if mine is None:
            have.put(key, copy(value), more.key_spans[key], more.value_spans[key])
        elif key not in keys_of(section):
            continue  # validation reports it
        elif isinstance(mine, Seq) and isinstance(value, Seq):
            have[key] = joined = copy(mine)
            _extend(joined, value)
        elif _is_table_of_entries(mine) and _is_table_of_entries(value):
            have[key] = joined = copy(mine)
            good &= _join_entries(key, joined, value, scope, equal=True)
        else:
            others.put(key, value, more.key_spans[key], more.value_spans[key])
    return _join_entries(section, have, others, scope, equal=True) and good


def _is_table_of_entries(value: Any) -> bool:
    return isinstance(value, Map) and all(isinstance(item, (Map, Seq)) for item in value.values())


def copy(value: Any) -> Any:
    """Return a mapping or a list of the same entries, which may grow."""
    if isinstance(value, Map):
        return value.copy()
    if isinstance(value, Seq):
        made = Seq(value.span, value.via)
        _extend(made, value)
        return made
    return value


def with_source(tree: Map, owner: Map) -> Map:
    """Return sections in which every entry has a source: its own, or that of ``owner``, a use."""
    maps = {key: entries for key, entries in tree.items() if isinstance(entries, Map) and not holds_many(key)}
    return tree.like(
        {key: (_sourced if is_one_entry(key) else with_sources)(part, owner) for key, part in maps.items()}
    )


def with_sources(section: Map, owner: Map) -> Map:
    """Return a section in which every entry has a source: its own, or that of ``owner``, a file or a use."""
    return section.like({name: _sourced(entry, owner) for name, entry in section.items() if isinstance(entry, Map)})


def _sourced(entry: Map, owner: Map) -> Map:
    made = entry.copy()
    if "source" not in entry:
        made.put("source", owner["source"], owner.key_spans["source"], owner.value_spans["source"])
    return made

"""Sections of other packages: entry points of ``rosorin_compile.sections``, read before they are used.

A section becomes part of the schema, and with it of all that walks a description by it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.model.sections import ENTRIES, ITEMS, Section
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean
from rosorin_compile.source.plugins import Plugin, broken, load
from rosorin_compile.source.rule_registry import OF_PLUGINS, Check, check_texts, find

from .annotations import DESCRIPTION, GIVES, NAMES, check_annotations, kinds_of, own_schema
from .validator import check_schema

Loaded = tuple[tuple[Plugin, Section[Any]], ...]


class Plugged(NamedTuple):
    """The sections that plug-ins add, each with who brings it, and what is wrong with plug-ins of this kind."""

    sections: Loaded
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged() -> Plugged:
    """Return the sections of plug-ins."""
    loaded, diagnostics = load("sections", Section, _marks, _is_taken)
    if loaded:
        loaded, more = _of_known_kinds(loaded)
        diagnostics = (*diagnostics, *more)
    OF_PLUGINS.update((rule.id, rule) for _, section in loaded for check in section.checks for rule in check.rules)
    return Plugged(loaded, diagnostics)


def _of_known_kinds(loaded: Loaded) -> tuple[Loaded, tuple[Diagnostic, ...]]:
    """Return the sections that name kinds of things that there are, also those of each other, and what is wrong."""
    known = {kind for _, section in loaded for kind in kinds_of(section.schema, GIVES)}
    known |= kinds_of(own_schema(), GIVES) | kinds_of(own_schema(), NAMES)
    unknown = [(plugin, kinds_of(section.schema, NAMES) - known) for plugin, section in loaded]
    wrong = tuple(
        broken(plugin, f'has a schema that names "{kind}", of which there is none; {did_you_mean(kind, sorted(known))}')
        for plugin, kinds in unknown
        for kind in sorted(kinds)
    )
    return tuple(one for one, (_, kinds) in zip(loaded, unknown, strict=True) if not kinds), wrong


def plugged_sections() -> Mapping[str, Section[Any]]:
    """Return the sections of plug-ins by name."""
    return {section.name: section for _, section in plugged().sections}


def piece(section: Section[Any]) -> dict[str, Any]:
    """Return the piece of the schema of descriptions that a section is, with what holds for each that is brought."""
    said: dict[str, Any] = {"x-reckoned": True, "x-compared": section.schema.get("x-called", section.name)}
    if section.form in (ENTRIES, ITEMS):
        said["x-merge"] = section.form
    if section.form == ENTRIES:
        said["x-explained"] = True
    made: dict[str, Any] = _looked_up({**said, **section.schema})
    key = {ENTRIES: "additionalProperties", ITEMS: "items"}.get(section.form)
    if key is None:
        return {"x-accepted": _names(made), **made}
    own = ["{1}"] if section.form == ENTRIES else []
    return {**made, key: {"x-accepted": [*own, *_names(made[key])], **made[key]}}


def _names(entry: Mapping[str, Any]) -> list[str]:
    """Return the names of links and joints that an entry says: what is wrong with it may be accepted of them."""
    kinds = ((key, said.get("x-names", said.get("x-gives"))) for key, said in entry.get("properties", {}).items())
    return [f"{{{key}}}" for key, kind in kinds if kind in ("link", "joint")]


def _looked_up(part: Any) -> Any:
    """Return a part of a schema in which it is said of each name of a thing that it is looked up in the description."""
    if isinstance(part, list):
        return [_looked_up(one) for one in part]
    if not isinstance(part, Mapping):
        return part
    made = {key: _looked_up(one) for key, one in part.items()}
    if part.get("x-names", "link") in ("link", "joint"):  # which are looked up with those of all others
        return made
    return {"x-among": DESCRIPTION, **made}


def _is_taken(name: str) -> bool:
    return name in own_schema()["properties"] or name in _APART or ("-" in name and bool(find([name])))


# Sections that the schema of plain descriptions has no more.
_APART = ("parts", "use", "sensor_types", "help")


def _marks(section: Section[Any]) -> Collection[str]:
    """Return what nobody else may have: the name of a section, and the ids of its rules.

    Raises ValueError or TypeError for a record that is none.
    """
    section.check()
    if not all(isinstance(check, Check) for check in section.checks):
        raise TypeError("its checks are functions under @rule")
    own = {"type": "object", "properties": {section.name: section.schema}}
    check_schema(own, {**own_schema(), **own}, strict=True)
    check_annotations(piece(section), own_schema())
    rules = [rule for check in section.checks for rule in check.rules]
    for rule in rules:
        check_texts(rule)
    return [section.name, *(rule.id for rule in rules)]

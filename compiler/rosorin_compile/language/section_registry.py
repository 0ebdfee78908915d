"""Sections of plug-ins: entry points of ``rosorin_compile.sections``, checked before they are used.

A section becomes part of the schema, and with it of everything that walks a description by the schema.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.model.sections import ENTRIES, ITEMS, Section
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean
from rosorin_compile.source.plugins import Plugin, broken, load
from rosorin_compile.source.rule_registry import OF_PLUGINS, Check, find

from .annotations import DESCRIPTION, GIVES, NAMES, check_annotations, kinds_of, own_schema
from .validator import check_schema

_RESERVED = ("parts", "use", "sensor_types", "help")  # sections that the schema of expanded descriptions lacks


class Plugged(NamedTuple):
    """The sections of plug-ins, each with its plug-in, and problems with these plug-ins."""

    sections: tuple[tuple[Plugin, Section[Any]], ...]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged() -> Plugged:
    """Return the sections of plug-ins that name only kinds of things that some section defines."""
    loaded, diagnostics = load("sections", Section, _marks, _is_taken)
    known = kinds_of(own_schema(), GIVES) | kinds_of(own_schema(), NAMES) if loaded else set()
    known |= {kind for _, section in loaded for kind in kinds_of(section.schema, GIVES)}
    sections, problems = [], [*diagnostics]
    for plugin, section in loaded:
        unknown = sorted(kinds_of(section.schema, NAMES) - known)
        for kind in unknown:
            guess = did_you_mean(kind, sorted(known))
            problems.append(broken(plugin, f'has a schema that names "{kind}", of which there is none; {guess}'))
        if not unknown:
            sections.append((plugin, section))
            OF_PLUGINS.update((rule.id, rule) for check in section.checks for rule in check.rules)
    return Plugged(tuple(sections), tuple(problems))


def plugged_sections() -> Mapping[str, Section[Any]]:
    """Return the sections of plug-ins by name."""
    return {section.name: section for _, section in plugged().sections}


def piece(section: Section[Any]) -> dict[str, Any]:
    """Return the fragment of the schema of a section, with the annotations that all sections of plug-ins have."""
    defaults: dict[str, Any] = {"x-reckoned": True, "x-compared": section.schema.get("x-called", section.name)}
    if section.form in (ENTRIES, ITEMS):
        defaults["x-merge"] = section.form
    if section.form == ENTRIES:
        defaults["x-explained"] = True
    made: dict[str, Any] = _looked_up({**defaults, **section.schema})
    key = {ENTRIES: "additionalProperties", ITEMS: "items"}.get(section.form)
    entry = made if key is None else made[key]
    # A problem with an entry may be accepted for it and for the links and joints that it names.
    kinds = ((name, inner.get("x-names", inner.get("x-gives"))) for name, inner in entry.get("properties", {}).items())
    named = [f"{{{name}}}" for name, kind in kinds if kind in ("link", "joint")]
    entry = {"x-accepted": ["{1}", *named] if section.form == ENTRIES else named, **entry}
    return entry if key is None else {**made, key: entry}


def _looked_up(fragment: Any) -> Any:
    """Return a fragment of a schema in which each name is looked up in the description."""
    if isinstance(fragment, list):
        return [_looked_up(item) for item in fragment]
    if not isinstance(fragment, Mapping):
        return fragment
    made = {key: _looked_up(item) for key, item in fragment.items()}
    is_usual = fragment.get("x-names", "link") in ("link", "joint")  # which are looked up there anyway
    return made if is_usual else {"x-among": DESCRIPTION, **made}


def _is_taken(name: str) -> bool:
    return name in own_schema()["properties"] or name in _RESERVED or ("-" in name and bool(find([name])))


def _marks(section: Section[Any]) -> Collection[str]:
    """Return the names that a section reserves: its own and the ids of its rules. Raises ValueError or TypeError."""
    section.check()
    if not all(isinstance(check, Check) for check in section.checks):
        raise TypeError("its checks are functions under @rule")
    own = {"type": "object", "properties": {section.name: section.schema}}
    check_schema(own, {**own_schema(), **own}, strict=True)
    check_annotations(piece(section), own_schema())
    rules = [rule for check in section.checks for rule in check.rules]
    return [section.name, *(rule.id for rule in rules)]

"""What URDF, SDF, MJCF and xacro call a thing, and what it is called here, or how it is expressed otherwise.

The words for a key are next to it in the schema (``x-also``), the ways out for words that are not keys next to its keys
(``x-instead``). ``schemas/synonyms.json`` has the others: ``keys`` by the kind of entry in ``$defs`` of the schema
(``top``: the description), ``values`` by the kind of value, the help for ``others``, and spellings of ``units``. A
meaning without spaces is the word to write, with spaces the fix. Words are compared in small letters, without ``_``
and the like.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from rosorin_compile.source.project import data_folder

from .schema import of_parts, resolve, schema


@cache
def _data() -> dict[str, dict[str, Any]]:
    loaded: dict[str, dict[str, Any]] = json.loads((data_folder("schemas") / "synonyms.json").read_text("utf-8"))
    return loaded


def _by_word(meanings: Mapping[str, str]) -> dict[str, str]:
    return {word: meaning for meaning, words in meanings.items() for word in words.split()}


@cache
def keys_of_kinds() -> Mapping[str, Mapping[str, str]]:
    """Return what each word is called, or the fix for it, by the kind of the entry that it is a key of."""
    return {kind: _by_word(meanings) for kind, meanings in _data()["keys"].items()}


@cache
def values_of_kinds() -> Mapping[str, Mapping[str, str]]:
    """Return what each word is called, or the fix for it, by the kind of the value."""
    return {kind: _by_word(meanings) for kind, meanings in _data()["values"].items()}


@cache
def spellings_of_units() -> Mapping[str, str]:
    """Return units by the words that people write for them, in small letters."""
    return _by_word(_data()["units"])


def of_other_keys(kind: str) -> str:
    """Return the help for any other key of a kind of entry, or an empty string."""
    return str(_data()["others"].get(kind, ""))


@cache
def words_for(kind: str) -> Mapping[str, str]:
    """Return what each word is called in an entry of a kind, or the fix for it, with the words of the schema."""
    sections = schema()["properties"]
    if kind in ("top", "part"):
        known = sections if kind == "top" else {section: sections[section] for section in of_parts()}
    elif kind in schema()["$defs"]:
        known = schema()["$defs"][kind].get("properties", {})
    else:  # a section whose entries are defined in place
        known = dict(_keys_within(sections.get(kind, {})))
    also = {word: key for key, fragment in known.items() for word in _also(fragment)}
    return {**keys_of_kinds().get(kind, {}), **_instead(kind), **also}


def _instead(kind: str) -> dict[str, str]:
    """Return the fix for each word that is not a key of an entry, by the schema."""
    said = schema()["$defs"].get(kind, {}).get("x-instead", {})
    if isinstance(said, str):  # as for another kind
        return _instead(said)
    return {word: way for words, way in said.items() for word in words.split()}


def _keys_within(fragment: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    if isinstance(fragment, Mapping):
        yield from fragment.get("properties", {}).items()
    for inner in fragment.values() if isinstance(fragment, Mapping) else fragment if isinstance(fragment, list) else ():
        yield from _keys_within(inner)


def _also(fragment: Mapping[str, Any]) -> list[str]:
    return f"{fragment.get('x-also', '')} {resolve(dict(fragment)).get('x-also', '')}".split()


def plain(word: str) -> str:
    """Return a word as it is compared: small letters and digits alone."""
    return re.sub(r"[^a-z0-9]", "", word.casefold())


def synonym(word: str, table: Mapping[str, str], known: Iterable[str]) -> str | None:
    """Return what a word is called here, one of ``known``; None if no table has it or it only names a way out."""
    meaning = table.get(plain(word))
    return meaning if meaning in set(known) else None


def way_out(word: str, table: Mapping[str, str]) -> str:
    """Return the sentence that a table has for a word; "" if it has none, or another word alone."""
    meaning = table.get(plain(word), "")
    return meaning if " " in meaning else ""

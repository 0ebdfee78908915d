"""Misnamed: what a person may have meant by a key or a word that is not known where it stands."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from types import NoneType
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import did_you_mean, nearest
from rosorin_compile.source.tree import Map, Path, locate, prefix_at
from rosorin_compile.source.units import parse_unit

from .expand.provenance import text_at
from .schema import resolve
from .symbols import MOUNT
from .synonyms import OTHERS, VALUES, synonym, way_out, words_for


def key_meant(key: str, entry: Map, known: Mapping[str, Any], kind: str, path: Sequence[str | int] = ()) -> str:
    """Return the way out for a key that the entry at a path does not have.

    ``known`` are the keys that it may have, with their fragments of the schema; ``kind`` is that of the entry.
    """
    table = words_for(kind)
    said, key = key, key.removeprefix("xacro:")
    told = _written_wrongly(said, entry, known) or way_out(key, table)
    if told:
        return told
    close = synonym(key, table, known)
    inner = entry.get(said)
    is_entry = len(path) == 2 and isinstance(inner, Map) and inner and known.keys() >= set(inner)
    if is_entry and not close and nearest(key, known) is None:
        return f'"{said}" has the keys of an entry of {path[0]}: indent it as far as "{path[1]}"'
    help = f'did you mean "{close}"?' if close else did_you_mean(key, known)
    if help.startswith("known") and kind == "pose":
        return f"joints stand in positions: {{{key}: ...}} or in pulses: {{{key}: ...}}"
    if help.startswith("did"):
        return f"{help} (legal: {', '.join(sorted(known))})"
    return f"{OTHERS[kind]} ({help})" if kind in OTHERS else help


def _written_wrongly(key: str, entry: Map, known: Mapping[str, Any]) -> str:
    """Return the way out for what is no key: an entry without a space, half a number, a line not indented."""
    if key[:1] in "\u00a0\u3000\u200b\ufeff" and key[:1]:
        return "it begins with a space that is none for YAML: type the spaces anew"
    glued = re.match(r"\s*([\w.-]+)\s*([:=])\s*(.*)", key, re.DOTALL)
    if glued and glued[1] in known:
        name, sign, value = glued.groups()
        return f'a space is missing after the ":": {name}: {value}' if sign == ":" else f"write {name}: {value}"
    colon = re.match(r"\s*([\w.-]+)\s+([{\[].*)", key, re.DOTALL)
    if colon and colon[1] in known:
        return f'a ":" is missing: {colon[1]}: {"{...}" if colon[2][0] == "{" else "[...]"}'
    keys = list(entry)
    before = keys[keys.index(key) - 1] if key in entry and keys.index(key) else ""
    if not before:
        return ""
    if told := text_meant_by(key, entry):
        return told
    part = re.fullmatch(r"(\d+)\s*(\D.*)?", key)
    if part and entry[key] is None and type(entry[before]) is int and (not part[2] or parse_unit(part[2])):
        return f"a number has a point, not a comma: {before}: {entry[before]}.{key}"
    inner = resolve(known.get(before) or {}).get("properties", {})
    if entry[before] is None and key in inner:
        return f'"{key}" is a key of {before}: indent it deeper than "{before}"'
    return ""


def text_meant_by(key: str, entry: Map) -> str:
    """Return the way out for a key that is the rest of a text: the "b" of ``{note: a, b}``; "" if it is none.

    YAML takes what stands behind a comma in braces for a key without a value.
    """
    keys = list(entry)
    first = end = keys.index(key) if key in entry else 0
    while first > 0 and _goes_on(entry, keys[first - 1], keys[first]):
        first -= 1
    if first == end or type(entry[keys[first]]) is not str:
        return ""
    while end + 1 < len(keys) and _goes_on(entry, keys[end], keys[end + 1]):
        end += 1
    whole = ", ".join([entry[keys[first]], *keys[first + 1 : end + 1]])
    return f'a comma ends the text: put it in quotes, {keys[first]}: "{whole}"'


def text_tails(entry: Map, unknown: Collection[str]) -> set[str]:
    """Return the unknown keys that are the rest of a text after a comma, and whose beginning is an unknown key."""
    tails: set[str] = set()
    in_text = False
    for before, key in pairwise(entry):
        in_text = _goes_on(entry, before, key) and (in_text or type(entry[before]) is str)
        if in_text and before in unknown:
            tails.add(key)
    return tails


def _goes_on(entry: Map, before: str, key: str) -> bool:
    """Say whether a key without a value stands behind another entry, with nothing but a comma between."""
    value, span = entry[before], entry.key_spans[key]
    begin = entry.key_spans[before] if value is None else entry.value_spans[before]
    if entry[key] is not None or not isinstance(value, (str, NoneType)):
        return False
    lines = [begin.source.line(number) for number in range(begin.line, span.line + 1)]
    lines[-1] = lines[-1][: span.column - 1]
    return "".join(lines)[begin.column - 1 + begin.length :].strip() == ","


def is_meant(key: str, wanted: str, kind: str, known: Iterable[str]) -> bool:
    """Say whether the way out for an unknown key leads to the one that is missing."""
    names, table = list(known), words_for(kind)
    if synonym(key, table, names) == wanted or f"{wanted}: " in way_out(key, table):
        return True
    return re.split(r"[:=]", key)[0].strip() == wanted or nearest(key, names) == wanted


def word_meant(word: str, known: Iterable[str], kind: str = "") -> str:
    """Return the way out for a word that is not one of those that are known; ``kind`` is that of its synonyms."""
    table = VALUES.get(kind) or words_for(kind)
    close = synonym(word, table, known)
    return way_out(word, table) or (f'did you mean "{close}"?' if close else did_you_mean(word, known))


def name_meant(tree: Map, path: Path, word: str, known: Iterable[str], more: Sequence[str] = ()) -> str:
    """Return what a name at a path may stand for that is none of ``known``, as ``did_you_mean``.

    In a part its own names go first, without the prefix, as it calls them; ``more`` are further names of its own.
    """
    given = text_at(locate(tree, path).span) == MOUNT  # by the use: it speaks of what is around the part
    names, prefix = list(known), prefix_at(tree, path, outside=given)
    own = [name.removeprefix(prefix) for name in names if prefix and name.startswith(prefix)]
    if not own:
        return did_you_mean(word, names)
    guess = did_you_mean(word, [*own, *more])
    if guess.startswith("did"):
        return guess
    of_others = did_you_mean(word, [name for name in names if not name.startswith(prefix)])
    return of_others if of_others.startswith("did") else guess


class Fallen(NamedTuple):
    """The entry that a key was meant to stand in, and whether it is the first one that stands beside it instead."""

    owner: str
    is_first: bool


def fallen_out(tree: Map, path: Sequence[str | int], fragment: Mapping[str, Any]) -> Fallen | None:
    """Return the entry above to which what stands at a path belongs: a key of such entries that is not indented.

    ``fragment`` is that of the entries in the schema. None if it is an entry itself.
    """
    section = tree[str(path[0])] if len(path) == 2 else None
    legal = fragment.get("properties", {})
    if not isinstance(section, Map) or path[-1] not in legal:
        return None
    keys = list(section)
    index = above = keys.index(str(path[-1]))
    while above >= 0 and keys[above] in legal:
        above -= 1
    return Fallen(keys[above], above == index - 1) if above >= 0 and section[keys[above]] is None else None

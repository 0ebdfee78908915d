"""Checks of what an ``include`` of another one's robot says, before its file is read."""

from __future__ import annotations

import re
from typing import Any

from ..diagnostic import did_you_mean
from ..expression.functions import kind_of
from ..tree import Map, Place
from .scope import Failed, Scope

_OF_FILE = ("file", "package", "packages", "args", "lenient")
KEYS = (*_OF_FILE, "prefix", "meshes", "parent", "xyz", "rpy", "joint", "publisher", "source", "for", "if")
_TEXTS = ("file", "package", "prefix", "meshes", "parent", "joint")
_PREFIX = re.compile(r"([^\s<>&\"']+( +[^\s<>&\"']+)* *)?")  # what a name can begin with


def check_include(entry: Map, scope: Scope) -> None:
    """Report keys and kinds of values that an include cannot have. Raises Failed after that."""
    wrong = 0
    for key in entry:
        if key not in KEYS:
            place = Place(entry.key_spans[key], scope.via or entry.via)
            scope.report("unknown-key", f'an include has no key "{key}"', place, did_you_mean(key, KEYS))
            wrong += 1
    kinds: list[tuple[str, type, str]] = [(key, str, "text") for key in _TEXTS]
    kinds += [("args", Map, "a mapping"), ("packages", Map, "a mapping"), ("lenient", bool, "true or false")]
    for key, wanted, word in kinds:
        value = entry.get(key)
        if not isinstance(value, wanted) and (value is not None or key == "file"):
            message = f"{key} of an include is {word}, not {kind(value)}"
            missing = f"an include needs {key}, the name of the robot's file"
            scope.report("wrong-type", message if key in entry else missing, place_of(entry, key, scope))
            wrong += 1
    prefix = entry.get("prefix")
    if isinstance(prefix, str) and not _PREFIX.fullmatch(prefix):
        help = "no markup, no quotes; spaces only within"
        scope.report("bad-name", f'no name can begin with "{prefix}"', place_of(entry, "prefix", scope), help)
        wrong += 1
    for name, folder in (entry.get("packages") or {}).items() if not wrong else ():
        if not isinstance(folder, str):
            place = place_of(entry["packages"], name, scope)
            scope.report("wrong-type", f"a package is a folder: text, not {kind(folder)}", place)
            wrong += 1
    if wrong:
        raise Failed


def place_of(entry: Map, key: str, scope: Scope) -> Place:
    """Return where the value of a key stands; of one that is missing, where the whole stands."""
    return Place(entry.value_spans.get(key, entry.span), scope.via or entry.via)


def kind(value: Any) -> str:
    """Return in words what kind of value this is."""
    if isinstance(value, (Map, list)):
        return "a mapping" if isinstance(value, Map) else "a list"
    return "empty" if value is None else kind_of(value)

"""Keys and kinds of values in files of parts, parts, sensor types and ``use``.

The sections of a description are validated by the schema after the expansion, which does not see what is around them
in parts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.units import ANGLE, LENGTH, Dimension, Quantity, describe
from rosorin_compile.source.wording import in_words, unseen

from ..annotations import ENTRIES, ITEMS
from ..expression import pieces
from ..expression.functions import kind_of
from ..misnamed import text_meant_by, text_tails, word_meant
from ..schema import merged, of_parts, of_types, resolve, schema
from .expansion import Failed
from .mirroring import AXES, is_number
from .scope import Scope

_KINDS = {Map: "a mapping", Seq: "a list", str: "text", bool: "true or false"}
_FILE_KEYS = ("rosorin_compile", "help", "let", "parts", "sensor_types")
_PART_KEYS = ("help", "params", "let", "use")
_SENSOR_TYPE_KEYS = ("help", "params", "let")
_USE_KINDS = {"part": str, "with": Map, "prefix": str, "parent": str, "content": Map}
_USE_KEYS = ("part", "with", "prefix", "parent", "xyz", "rpy", "mirror", "content", "source")


def check_file(file: str, tree: Map, scope: Scope) -> None:
    """Check a file of parts. Raises Failed after reporting."""
    if not check_entry(file, tree, scope, _FILE_KEYS, dict.fromkeys(("let", "parts", "sensor_types"), Map)):
        raise Failed


def check_part(name: str, parts: Map, scope: Scope) -> bool:
    """Check a part; return True if it has no errors."""
    owner, body = f'part "{name}"', parts[name]
    if not isinstance(body, Map):
        scope.report("wrong-type", f"{owner} is a mapping, not {_kind(body)}", place_of(parts, name, scope))
        return False
    kinds = dict.fromkeys(("params", "let", "use"), Map)
    good = check_entry(owner, body, scope, (*_PART_KEYS, *of_parts()), kinds, "part")
    good &= check_controls(f"{owner} ", body, (*merged(ENTRIES, in_parts=True), "use"), scope)
    return check_sections(owner, body, scope, evaluated=False) and good


def check_sensor_type(name: str, body: Map, scope: Scope) -> None:
    """Check a type of sensors. Raises Failed after reporting."""
    kinds, keys = dict.fromkeys(("params", "let"), Map), (*_SENSOR_TYPE_KEYS, *of_types())
    if not check_entry(f'sensor type "{name}"', body, scope, keys, kinds, "sensor_type"):
        raise Failed


def check_use(name: str, entry: Map, scope: Scope) -> None:
    """Check a ``use``. Raises Failed after reporting."""
    owner = f'use "{name}"'
    good = check_entry(owner, entry, scope, _USE_KEYS, _USE_KINDS, "use")
    good &= not hides_letters("prefix", entry, scope)
    good &= _check_vector(owner, entry, "xyz", LENGTH, scope) & _check_vector(owner, entry, "rpy", ANGLE, scope)
    content, mirror = entry.get("content"), entry.get("mirror")
    if isinstance(content, Map):
        good &= check_entry(f"content of {owner}", content, scope, of_parts(), {})
        good &= check_sections(f"content of {owner}", content, scope)
    if mirror is not None and not (isinstance(mirror, str) and mirror in AXES):
        shown = f'"{mirror}"' if isinstance(mirror, str) else kind_of(mirror)
        help = "one of x, y, z: the axis that is reversed"
        raise scope.failed(
            "wrong-value", f"mirror cannot be {shown}", Place(entry.value_spans["mirror"], entry.via), help
        )
    if not good:
        raise Failed


def hides_letters(key: str, entry: Map, scope: Scope) -> bool:
    """Report an invisible letter in a text that all names of a part or of a robot begin with; return True for one."""
    value = entry.get(key)
    letter = unseen(value) if isinstance(value, str) else ""
    if letter:
        message = f'{key} "{value}" has a letter that nobody sees: {in_words(letter)}'
        scope.report("invisible-letter", message, place_of(entry, key, scope), "type it anew, without it")
    return bool(letter)


def check_controls(owner: str, tree: Map, sections: Sequence[str], scope: Scope) -> bool:
    """Report a loop or a condition beside the entries of a section; return True if there is none.

    An entry may be named like a control: its value tells them apart.
    """
    good = True
    for section in sections:
        entries = tree.get(section)
        for control, what in (("for", "loop"), ("if", "condition")):
            if isinstance(entries, Map) and control in entries and _is_control(section, control, entries[control]):
                place = Place(entries.key_spans[control], scope.via or entries.via)
                help = f"move it into the entry: NAME: {{{control}: ..., ...}}"
                message = f'"{control}" stands beside the entries of {owner}{section}: a {what} stands in its entry'
                scope.report("wrong-type", message, place, help)
                good = False
    return good


def check_content(name: str, entry: Any, scope: Scope) -> None:
    """Report loops and conditions beside the entries of the content of a ``use``. Raises Failed after that.

    To be called before the use is evaluated, which would take a section of the content for an entry with a loop.
    """
    content = entry.get("content") if isinstance(entry, Map) else None
    owner = f'content of use "{name}" '
    if isinstance(content, Map) and not check_controls(owner, content, merged(ENTRIES, in_parts=True), scope):
        raise Failed


def _is_control(section: str, control: str, value: Any) -> bool:
    if control == "if":
        return isinstance(value, (str, bool))
    if not isinstance(value, Map) or not value:
        return False
    entry: Any = {} if section == "use" else resolve(schema()["properties"][section]["additionalProperties"])
    legal = _USE_KEYS if section == "use" else entry.get("properties", ())
    # A file with a source has given it to all its entries.
    return not any(key in legal for key in value if key != "source")


def check_sections(owner: str, tree: Map, scope: Scope, evaluated: bool = True) -> bool:
    """Report sections of the wrong kind; return True if there is none. Before evaluation, expressions are allowed."""
    lists = merged(ITEMS, in_parts=True)
    kinds = {key: Seq if key in lists else Map for key in of_parts()}
    if not evaluated:
        kinds = {key: kind for key, kind in kinds.items() if not _is_expression(tree.get(key))}
    return check_entry(owner, tree, scope, None, kinds)


def check_entry(
    owner: str, tree: Map, scope: Scope, keys: Sequence[str] | None, kinds: Mapping[str, type], word: str = ""
) -> bool:
    """Report unknown ``keys``, and values of another kind than ``kinds`` has; return True if there are none.

    ``word`` is the kind of the entry, for suggestions.
    """
    unknown = [key for key in tree if keys is not None and key not in keys]
    tails = text_tails(tree, unknown) if unknown else ()
    for key in (key for key in unknown if key not in tails):
        help = text_meant_by(key, tree) or word_meant(key, keys or (), word)
        if word == "use" and help.startswith("known"):
            help = f"an argument of the part stands in with: {{{key}: ...}}; {help}"
        place = Place(tree.key_spans[key], scope.via or tree.via)
        scope.report("unknown-key", f'{owner} has no key "{key}"', place, help)
    wrong = [key for key, kind in kinds.items() if tree.get(key) is not None and not isinstance(tree[key], kind)]
    for key in wrong:
        message = f"{owner} {key} is {_KINDS[kinds[key]]}, not {_kind(tree[key])}"
        scope.report("wrong-type", message, place_of(tree, key, scope))
    return not unknown and not wrong


def _check_vector(owner: str, tree: Map, key: str, dimension: Dimension, scope: Scope) -> bool:
    value = tree.get(key)
    if value is None:
        return True
    where, place = f"{owner} {key}", place_of(tree, key, scope)
    if not isinstance(value, list) or len(value) != 3:
        scope.report("wrong-type", f"{where} is a list of three numbers, not {_kind(value)}", place)
        return False
    wrong = [v for v in value if not is_number(v, dimension)]
    if wrong and isinstance(wrong[0], Quantity):
        number = wrong[0].text or float(wrong[0])
        message = f"{where} is {describe(dimension)}, but {number} is {_kind(wrong[0])}"
        scope.report("wrong-unit", message, place, "correct the unit; a bare number is in SI units")
    elif wrong:
        scope.report("wrong-type", f"{where} is a list of three numbers, not of {_kind(wrong[0])}", place)
    elif not all(map(math.isfinite, value)):
        scope.report("not-finite", f"{where} is not finite", place, "write numbers, or leave the key out")
    else:
        return True
    return False


def _is_expression(value: Any) -> bool:
    return isinstance(value, str) and any(piece.is_expression for piece in pieces(value))


def place_of(entry: Map, key: str, scope: Scope) -> Place:
    """Return where the value of a key is written; of a missing key, the place of the entry."""
    return Place(entry.value_spans.get(key, entry.span), scope.via or entry.via)


def _kind(value: Any) -> str:
    if isinstance(value, (Map, Seq)):
        return "a mapping" if isinstance(value, Map) else f"a list of {len(value)}"
    return "empty" if value is None else kind_of(value)

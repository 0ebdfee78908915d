"""Forms: what a part, a ``use`` and their sections have to look like, whatever their values are.

The sections of a description are held against the schema after the expansion. What stands around them in parts never
reaches the schema, so its keys and kinds are looked at here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.units import ANGLE, LENGTH, Dimension, Quantity, describe
from rosorin_compile.source.wording import in_words, unseen

from ..annotations import ENTRIES, ITEMS
from ..expression import pieces
from ..expression.functions import kind_of
from ..schema import merged, of_parts, of_types, resolve, schema
from ..suggestions import text_meant_by, text_tails, word_meant
from .ledger import Failed
from .scope import Scope

KEPT = "urdf_elements"  # a list of texts that are elements of XML
OF_MJCF = "mjcf_elements"  # the same, for the MJCF
_FILE_KEYS = ("rosorin_compile", "help", "let", "parts", "sensor_types")
_PART_KEYS = ("help", "params", "let", "use")
_USE_KEYS = ("part", "with", "prefix", "parent", "xyz", "rpy", "mirror", "content", "source")
_SENSOR_TYPE_KEYS = ("help", "params", "let")
_USE_TEXTS = ("part", "prefix", "parent")
_POSE: dict[str, Dimension] = {"xyz": LENGTH, "rpy": ANGLE}
_FLOATS = [float] * 3


def check_file(file: str, tree: Map, scope: Scope) -> None:
    """Report keys and kinds of values that a file of parts cannot have. Raises Failed after that."""
    sound = _check_keys(file, tree, _FILE_KEYS, scope)
    for key in ("let", "parts", "sensor_types"):
        sound &= _check_kind(file, tree, key, Map, scope, evaluated=False)
    if not sound:
        raise Failed


def check_part(name: str, parts: Map, scope: Scope) -> bool:
    """Report keys and kinds of values that a part cannot have; say whether it is sound."""
    owner, body = f'part "{name}"', parts[name]
    if not isinstance(body, Map):
        _report(f"{owner} is a mapping, not {_kind(body)}", parts, name, scope)
        return False
    sound = _check_keys(owner, body, (*_PART_KEYS, *of_parts()), scope, "part")
    for key in ("params", "let", "use"):
        sound &= _check_kind(owner, body, key, Map, scope, evaluated=False)
    sound &= check_controls(f"{owner} ", body, (*merged(ENTRIES, in_parts=True), "use"), scope)
    return _check_sections(owner, body, scope, evaluated=True) and sound


def check_sensor_type(name: str, body: Map, scope: Scope) -> None:
    """Report keys and kinds of values that a type of sensors cannot have. Raises Failed after that."""
    owner = f'sensor type "{name}"'
    sound = _check_keys(owner, body, (*_SENSOR_TYPE_KEYS, *of_types()), scope, "sensor_type")
    for key in ("params", "let"):
        sound &= _check_kind(owner, body, key, Map, scope, evaluated=False)
    params = body.get("params")
    for parameter, entry in params.items() if isinstance(params, Map) else ():
        for bound in ("min", "max"):
            value = entry.get(bound) if isinstance(entry, Map) else None
            if value is not None and not is_number(value):
                _report(f'{owner} argument "{parameter}" {bound} is a number, not {_kind(value)}', entry, bound, scope)
                sound = False
    if not sound:
        raise Failed


def check_use(name: str, entry: Map, scope: Scope) -> None:
    """Report keys and kinds of values that a ``use`` cannot have. Raises Failed after that."""
    owner = f'use "{name}"'
    sound = _check_keys(owner, entry, _USE_KEYS, scope, "use")
    for key in _USE_TEXTS:
        value = entry.get(key, "")
        if not isinstance(value, str) and value is not None:
            _report(f"{owner} {key} is text, not {_kind(value)}", entry, key, scope)
            sound = False
    sound &= "prefix" not in entry or not hides_letters("prefix", entry, scope)
    for key, dimension in _POSE.items():
        sound &= key not in entry or _check_vector(owner, entry, key, dimension, scope)
    for key in ("with", "content"):
        sound &= key not in entry or _check_kind(owner, entry, key, Map, scope, evaluated=False)
    content = entry.get("content")
    if isinstance(content, Map):
        sound &= _check_keys(f"content of {owner}", content, of_parts(), scope)
        sound &= _check_sections(f"content of {owner}", content, scope, evaluated=False)
    if not sound:
        raise Failed


def hides_letters(key: str, entry: Map, scope: Scope) -> bool:
    """Report a letter that nobody sees in what all names of a part or of a robot begin with; say whether one is."""
    value = entry.get(key)
    letter = unseen(value) if isinstance(value, str) else ""
    if letter:
        message = f'{key} "{value}" has a letter that nobody sees: {in_words(letter)}'
        scope.report("invisible-letter", message, _place_of(entry, key, scope), "type it anew, without it")
    return bool(letter)


def check_controls(owner: str, tree: Map, sections: Sequence[str], scope: Scope) -> bool:
    """Report a loop or a condition that stands beside the entries of a section; say whether there is none.

    An entry may have the name of a control all the same: what makes it one is what it holds.
    """
    sound = True
    for section in sections:
        entries = tree.get(section)
        for control in ("for", "if"):
            if isinstance(entries, Map) and control in entries and _is_control(section, control, entries[control]):
                place = Place(entries.key_spans[control], scope.via or entries.via)
                what = "loop" if control == "for" else "condition"
                help = f"move it into the entry: NAME: {{{control}: ..., ...}}"
                message = f'"{control}" stands beside the entries of {owner}{section}: a {what} stands in its entry'
                scope.report("wrong-type", message, place, help)
                sound = False
    return sound


def check_content(name: str, entry: Any, scope: Scope) -> None:
    """Report loops and conditions beside the entries of the content of a ``use``. Raises Failed after that.

    Asked before anything is evaluated: there, a section of the content would be taken for an entry with a loop.
    """
    content = entry.get("content") if isinstance(entry, Map) else None
    if isinstance(content, Map) and not check_controls(
        f'content of use "{name}" ', content, merged(ENTRIES, in_parts=True), scope
    ):
        raise Failed


def _is_control(section: str, control: str, value: Any) -> bool:
    """Say whether the value of a key is that of a loop or of a condition, and not an entry that is called so."""
    if control == "if":
        return isinstance(value, (str, bool))
    if not isinstance(value, Map) or not value:
        return False
    entry: Any = _USE_KEYS if section == "use" else resolve(schema()["properties"][section]["additionalProperties"])
    legal = entry if section == "use" else entry.get("properties", ())
    # A file with a source has given it to all its entries.
    return not any(key in legal for key in value if key != "source")


def check_sections(owner: str, tree: Map, scope: Scope) -> None:
    """Report sections that are of the wrong kind. Raises Failed after that."""
    if not _check_sections(owner, tree, scope, evaluated=False):
        raise Failed


def _check_sections(owner: str, tree: Map, scope: Scope, evaluated: bool) -> bool:
    lists = merged(ITEMS, in_parts=True)
    kinds = {key: Seq if key in lists else Map for key in of_parts()}
    sound = [_check_kind(owner, tree, key, kind, scope, evaluated) for key, kind in kinds.items()]
    return all(sound)


def _check_keys(owner: str, tree: Map, known: Sequence[str], scope: Scope, kind: str = "") -> bool:
    unknown = [key for key in tree if key not in known]
    for key in unknown:
        if key in text_tails(tree, unknown):
            continue
        place = Place(tree.key_spans[key], scope.via or tree.via)
        help = text_meant_by(key, tree) or word_meant(key, known, kind)
        if kind == "use" and help.startswith("known"):
            help = f"an argument of the part stands in with: {{{key}: ...}}; {help}"
        scope.report("unknown-key", f'{owner} has no key "{key}"', place, help)
    return not unknown


def _check_kind(owner: str, tree: Map, key: str, wanted: type, scope: Scope, evaluated: bool) -> bool:
    """Report a value of another kind than wanted. With ``evaluated`` it may also be an expression, evaluated later."""
    value = tree.get(key)
    if value is None or isinstance(value, wanted) or (evaluated and _is_expression(value)):
        return True
    kind = "a mapping" if wanted is Map else "a list"
    _report(f"{owner} {key} is {kind}, not {_kind(value)}", tree, key, scope)
    return False


def _check_vector(owner: str, tree: Map, key: str, dimension: Dimension, scope: Scope) -> bool:
    value = tree.get(key)
    if value is None or (type(value) is Seq and list(map(type, value)) == _FLOATS and all(map(math.isfinite, value))):
        return True
    where = f"{owner} {key}"
    if not isinstance(value, list) or len(value) != 3:
        _report(f"{where} is a list of three numbers, not {_kind(value)}", tree, key, scope)
        return False
    wrong = [v for v in value if not is_number(v, dimension)]
    if not wrong and all(map(math.isfinite, value)):
        return True
    if not wrong:
        help = "write numbers, or leave the key out"
        scope.report("not-finite", f"{where} is not finite", _place_of(tree, key, scope), help)
    elif isinstance(wrong[0], Quantity):
        message = f"{where} is {describe(dimension)}, but {wrong[0].text or float(wrong[0])} is {_kind(wrong[0])}"
        help = "correct the unit; a bare number is in SI units"
        scope.report("wrong-unit", message, _place_of(tree, key, scope), help)
    else:
        _report(f"{where} is a list of three numbers, not of {_kind(wrong[0])}", tree, key, scope)
    return False


def is_number(value: Any, dimension: Dimension | None = None) -> bool:
    """Say whether a value is a number, of a dimension if one is given; a bare number is of any."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return dimension is None or not isinstance(value, Quantity) or value.dimension == dimension


def _is_expression(value: Any) -> bool:
    return isinstance(value, str) and any(piece.is_expression for piece in pieces(value))


def _report(message: str, tree: Map, key: str, scope: Scope) -> None:
    scope.report("wrong-type", message, _place_of(tree, key, scope))


def _place_of(tree: Map, key: str, scope: Scope) -> Place:
    return Place(tree.value_spans[key], scope.via or tree.via)


def _kind(value: Any) -> str:
    if isinstance(value, (Map, Seq)):
        return "a mapping" if isinstance(value, Map) else f"a list of {len(value)}"
    return "empty" if value is None else kind_of(value)

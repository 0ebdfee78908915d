"""Suggest corrections for invalid values, keys and names.

The functions return a help text, or an empty string. ``source.messages`` calls them after the last stage, only for
errors that are shown.

In the schema, ``x-also`` lists the names that URDF, SDF, MJCF and xacro have for a key, and ``x-instead`` the help for
names without an equivalent key. ``schemas/synonyms.json`` has further synonyms: of ``keys`` by kind of entry (a
definition in ``$defs``, or ``top``), of ``values`` by kind of value, and of ``units``; and the help for all ``others``.
A replacement without spaces is the word to write, a replacement with spaces is the help.
"""

import json
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from itertools import pairwise
from types import NoneType
from typing import Any

from rosorin_compile.source.diagnostics import Suggestion, nearest
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.tree import Map, Path, Seq, Text, prefix_at
from rosorin_compile.source.units import UNITS, Dimension, Quantity, parse_unit
from rosorin_compile.source.wording import suggest

from .annotations import mappings_in
from .expression import ExpressionError, compile_expression
from .schema import keys_of_xml, of_parts, resolve, schema
from .symbols import MOUNT

Names = Collection[str]
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
MAX_SHOWN = 60
SPELLED_OUT = 5  # minimum length of a word that may be a misspelled unit name; symbols are shorter
_SIGNS = {"\u00b2": "^2", "\u00b3": "^3", "**": "^", "\u00b7": "*", "\u22c5": "*", "\u00d7": "*", " per ": "/"}
_TO_ASCII = {0x2212: "-", 0x2013: "-", 0x2014: "-", 0xA0: " "}  # characters that look like a minus or a space
_UNMEASURED = ("todo", "tbd", "tba", "fixme", "unknown", "?", "??", "???", "n/a", "na", "none", "xxx", "-", "x")
_NOTHING = ("none", "no", "off", "null", "empty")
_AXES = {"x": "[1, 0, 0]", "y": "[0, 1, 0]", "z": "[0, 0, 1]"}
_EXAMPLES = {"rpy": "[ROLL, PITCH, YAW]", "rgba": "[RED, GREEN, BLUE, OPACITY]", "axis": "[0, 0, 1]"}
_VECTORS = (("roll", "pitch", "yaw"), ("r", "p", "y"), ("x", "y", "z"), ("r", "g", "b", "a"))
_TRUE = ("yes", "y", "on", "true", "1", "enabled")
_FALSE = ("no", "n", "off", "false", "0", "disabled")


@cache
def _data() -> Any:
    return json.loads((data_folder("schemas") / "synonyms.json").read_text("utf-8"))


@cache
def synonyms(table: str, kind: str = "") -> Mapping[str, str]:
    """Map each synonym in a table of ``synonyms.json``, for a kind of entry or value, to its replacement."""
    meanings = _data()[table] if table == "units" else _data()[table].get(kind, {})
    return {word: meaning for meaning, words in meanings.items() for word in words.split()}


@cache
def words_for(kind: str) -> Mapping[str, str]:
    """Map synonyms of the keys in a kind of entry to the key to write or to a help text."""
    root, definitions = schema()["properties"], schema()["$defs"]
    if kind in ("top", "part"):
        known = root if kind == "top" else {section: root[section] for section in of_parts()}
    else:  # a definition, or a section with an inline definition
        parts = [definitions[kind]] if kind in definitions else mappings_in(root.get(kind, {}))
        known = dict(entry for part in parts for entry in part.get("properties", {}).items())
    instead = definitions.get(kind, {}).get("x-instead", {})
    if isinstance(instead, str):  # the name of another kind, whose ``x-instead`` also applies to this kind
        instead = definitions[instead].get("x-instead", {})
    found = {**synonyms("keys", kind), **{word: way for words, way in instead.items() for word in words.split()}}
    for key, fragment in known.items():
        also = (fragment.get("x-also", ""), resolve(dict(fragment)).get("x-also", ""))
        found |= dict.fromkeys(" ".join(also).split(), key)
    return found


def _meaning(word: str, table: Mapping[str, str]) -> str:
    return table.get(re.sub(r"[^a-z0-9]", "", word.casefold()), "")


def way_out(word: str, table: Mapping[str, str]) -> str:
    """Return the replacement for a word if it is a help text, not a single word, otherwise ""."""
    meaning = _meaning(word, table)
    return meaning if " " in meaning else ""


def unit_meant(text: str, wanted: Sequence[str]) -> str:
    """Return the unit that a text probably means, or ""; prefer units with the dimension of ``wanted``."""
    unit = text.strip()
    for sign, written in _SIGNS.items():
        unit = unit.replace(sign, written)
    unit = re.sub(r"[-. ]", "*", unit.strip().strip(".()[]"))
    unit = re.sub(r"\**/\**", "/", re.sub(r"\*+", "*", unit))
    split = re.sub(r"^(kg|g)(mm|cm|m)(?![a-z])", r"\1*\2", unit)  # "kgm2" becomes "kg*m2"
    guesses = [_factors(unit, {}), _factors(unit, {"nm": "Nm", "kg": "kgf"}), _factors(split, {})]
    known = [guess for guess in guesses if guess and parse_unit(guess)] or [""]
    right = {*_dimensions(wanted)}
    return next((guess for guess in known if right & {*_dimensions([guess])}), "" if right else known[0])


def _dimensions(units: Sequence[str]) -> list[Dimension]:
    return [unit[1] for unit in map(parse_unit, units) if unit is not None]


def _factors(unit: str, others: Mapping[str, str]) -> str:
    """Return a unit with each factor replaced by its symbol, or "" if one is unknown; ``others`` take precedence."""
    pieces: list[str] = []
    spellings = synonyms("units")
    for sign, word, power in re.findall(r"([*/]?)([^*/^\d\s]+)\^?(-?\d)?", unit):
        small = word.casefold()
        same = (name for name in UNITS if name.casefold() == small)
        name = others.get(small) or (word if word in UNITS else spellings.get(small) or next(same, ""))
        if not name and len(small) >= SPELLED_OUT:
            name = spellings.get(nearest(small, spellings) or "", "")
        if not name:
            return ""
        pieces += [sign, name, f"^{power}" if power else ""]
    return "".join(pieces)


def number_meant(text: str, wanted: Sequence[str], key: str = "") -> str:
    """Return the help for a text that should be a number; ``wanted`` are the valid units."""
    number = text.strip()
    if isinstance(text, Text) and _is_number(number):
        return f"write {number} without the quotes"
    tidy = re.sub(r"(?<=\d)[_'\u2019 ](?=\d{3}(\D|$))", "", number.translate(_TO_ASCII).rstrip(",;").strip())
    if tidy != number and _is_number(tidy):
        return f"write {tidy}"
    if comma := re.fullmatch(r"([-+]?\d+),(\d+(?:\s*\D.*)?)", number):
        is_group = re.fullmatch(r"[-+]?[1-9]\d{0,2},\d{3}(\D.*)?", number)
        either = f", or {comma[1]}{comma[2]} if the comma separates thousands" if is_group else ""
        return f"write a decimal point, not a comma: {comma[1]}.{comma[2]}{either}"
    if found := re.fullmatch(rf"[~\u2248<>=]*\s*({_NUMBER})\s*(?!\d|[-+*/(]\s*\d)(\S.*)", tidy, re.DOTALL):
        if key and not wanted:
            return "write a plain number, without a unit" if found[2] != "%" else f"write {float(found[1]) / 100:g}"
        if unit := unit_meant(found[2], wanted):
            unknown = f'unknown unit "{found[2]}"; ' if found[2] != unit else ""
            return f"{unknown}write {found[1]} {unit}"
        if re.fullmatch(r"[A-Za-z][\w^*/-]*", found[2]):
            return f'unknown unit "{found[2]}"; {Suggestion(found[2], _units_like(wanted))()}'
    if help := _expression_meant(number):
        return help
    if number.casefold() in _UNMEASURED:
        return 'until it is known, write a guess and add "source: {status: stand_in, note: ...}" to the entry'
    if parse_unit(number) or unit_meant(number, wanted) in _units_like(wanted):
        return "write a number before the unit"
    if number.isidentifier() and number.isascii():
        return f'write a number, or "${{{number}}}" if {number} is defined in "args" or "let"'
    quantity = "" if key and not wanted else "a quantity such as 12.5 mm, "
    return f"write a number, {quantity}or an expression ${{...}}"


def _units_like(wanted: Sequence[str]) -> list[str]:
    dimensions = _dimensions(wanted)
    return [name for name, (_, dimension) in UNITS.items() if dimension in dimensions] or list(UNITS)


def _expression_meant(text: str) -> str:
    """Return the help for a name or calculation in the syntax of another language: $(arg m), {{m}}, 2*M_PI."""
    if found := re.fullmatch(r"(?:\$\(|\$|\{\{?|%\(?|<|@)\s*([A-Za-z_]\w*)\s*(?:\)s?|\}\}?|%|>)?", text):
        return f'write "${{{found[1]}}}", and define {found[1]} in "args" or "let"'
    formula = text.replace("math.", "").replace("^", "**").replace("M_PI", "pi")
    formula = formula[1:-1] if formula.startswith("{") and formula.endswith("}") else formula
    is_sum = re.search(r"[-+*/(]", formula) and re.search(r"\d|pi|\w\s*[-+*/]\s*\w", formula)
    with suppress(ExpressionError):
        if formula in ("pi", "tau") or (is_sum and len(text) <= MAX_SHOWN and compile_expression(formula)):
            return f'write the calculation as an expression: "${{{formula}}}"'
    return ""


def _is_number(text: str) -> bool:
    value = plain_scalar(text) if text else None
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def numbers_in(text: str) -> list[str]:
    """Split text into numbers and quantities; return [] if it contains anything else."""
    found: list[str] = []
    for word in re.split(r"[\s,;]+", text.strip("()[]{}<> \t\n")):
        if _is_number(word):
            found.append(word)
        elif found and parse_unit(word) and " " not in found[-1]:
            found[-1] += f" {word}"
        else:
            return []
    return found


def list_meant(value: Any, key: str, fragment: Mapping[str, Any]) -> str:
    """Return the help for a value that should be a list; ``fragment`` is the schema of the list."""
    items = fragment.get("items", {})
    example = _EXAMPLES.get(key) or f"[{', '.join('XYZW'[: fragment.get('minItems', 0)] or 'X')}]"
    is_of_numbers = items.get("type") == "number"
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        text = format_scalar(value)
        known = {"scale": f"write [{', '.join([text] * 3)}]", "rpy": f"write [0, 0, {text}] for a turn about z"}
        return known.get(key) or (f"write {example}" if is_of_numbers else f"write [{text}]")
    if isinstance(value, Map):
        small = {name.casefold(): name for name in value}
        if names := next((names for names in _VECTORS if small and set(small) <= set(names)), ()):
            numbers = [format_scalar(value[small[name]]) if name in small else "01"[name == "a"] for name in names]
            return f"write only the numbers: [{', '.join(numbers)}]"
    elif isinstance(value, str):
        if value.casefold() in _NOTHING and not is_of_numbers:
            return "write [] for an empty list, or remove the key"
        if len(listed := numbers_in(value)) > 1 and is_of_numbers:
            return f"write [{', '.join(listed)}]"
        if key == "axis" and (axis := _AXES.get(value.casefold().lstrip("+-"))):
            return f"write {axis.replace('1', '-1') if value.startswith('-') else axis}"
        if items.get("type") == "string" or items.get("$ref", "").endswith("/name"):
            return f"write [{', '.join(value.replace(',', ' ').split())}]"
    else:
        return ""
    return f"write {example}" if is_of_numbers else 'begin each item of the list with "- "'


def items_meant(value: Seq, fragment: Mapping[str, Any]) -> str:
    """Return the help for a list with the wrong number of items, or "" if there is no suggestion."""
    is_of_numbers = fragment.get("items", {}).get("type") == "number"
    if is_of_numbers and len(value) == 1 and isinstance(value[0], str) and len(listed := numbers_in(value[0])) > 1:
        return f"separate the numbers with commas: [{', '.join(listed)}]"
    if is_of_numbers and all(type(item) is int for item in value) and len(value) == 2 * fragment.get("maxItems", 0):
        pairs = (f"{first}.{second}" for first, second in zip(value[::2], value[1::2], strict=True))
        return f"write a decimal point, not a comma: [{', '.join(pairs)}]"
    return ""


def mapping_meant(value: Any, fragment: Mapping[str, Any]) -> str:
    """Return the help for a value that should be a mapping; ``fragment`` is the schema of the mapping."""
    legal, required = fragment.get("properties", {}), fragment.get("required", ())
    if value is None:
        return "indent its keys below its name" if legal else "indent its entries below it, or remove it"
    if isinstance(value, str):
        if value.startswith("<"):
            return 'this is XML: write it as YAML, or keep it as XML in "urdf_elements"'
        if found := re.fullmatch(r"([\w./-]+)\s*(?::=|[:= ])\s*([^=]*)", value, re.DOTALL):
            return f'write "{f"{found[1]}: {found[2]}".strip()}"' if not legal or found[1] in legal else ""
        if value and not legal:
            return f'add the missing ":", as in "{value}: ..."'
    if isinstance(value, Seq) and not legal:
        return 'write each entry as "NAME: {...}", without a leading "- "'
    if isinstance(value, Seq) and value and all(isinstance(item, Map) and set(item) <= set(legal) for item in value):
        return 'write its keys without "- "'
    keys = required or [key for key in legal if key not in {"source", *keys_of_xml()}][:4]
    only = format_scalar(value) if len(keys) == 1 and isinstance(value, (str, int, float)) else "..."
    keys = keys[:1] if keys[:1] in (["size"], ["box"]) else keys  # the other keys are alternatives
    return f"write {{{', '.join(f'{key}: {only}' for key in keys)}}}" if keys else ""


def flag_meant(value: Any) -> str:
    """Return the help for a value that should be a boolean, or "" if it resembles neither true nor false."""
    word = str(value).casefold()
    flag = "true" if word in _TRUE else "false" if word in _FALSE else ""
    if flag and isinstance(value, str) and not isinstance(value, Text):
        return f'write {flag}: in YAML 1.2 "{value}" is text, not a boolean'
    return f"write {flag}, without quotes" if flag else ""


def format_scalar(value: Any) -> str:
    """Format a scalar as it should be written in YAML."""
    if isinstance(value, Quantity):
        return value.text
    return f"{value:g}" if isinstance(value, float) else str(value)[:MAX_SHOWN]


def key_meant(key: str, entry: Map, known: Mapping[str, Any], kind: str, path: Sequence[str | int] = ()) -> str:
    """Return the help for an unknown key of the entry at ``path``; ``known`` maps valid keys to their schemas."""
    table, word, inner, keys = words_for(kind), key.removeprefix("xacro:"), entry.get(key), list(entry)
    if (written := _key_and_value(word)) and written[0] in known:
        return f'write "{written[0]}: {"..." if written[1][:1] in "{[" else written[1]}"'
    before = keys[keys.index(key) - 1] if key in keys[1:] else ""
    if help := text_meant_by(key, entry) or way_out(word, table):
        return help
    if before and type(entry[before]) is int and inner is None and re.match(r"\d+\s*\D*$", key):
        return f"write a decimal point, not a comma: {before}: {entry[before]}.{key}"
    if before and entry[before] is None and key in resolve(known.get(before) or {}).get("properties", {}):
        return f'"{key}" is a key of "{before}": indent it below "{before}"'
    close = _meaning(word, table)
    is_entry = len(path) == 2 and isinstance(inner, Map) and inner and known.keys() >= set(inner)
    if is_entry and close not in known and nearest(word, known) is None:
        return f'"{key}" looks like an entry of "{path[0]}": indent it as far as "{path[1]}"'
    legal, other = f"known: {', '.join(sorted(known))}", _data()["others"].get(kind)
    if close in known:
        return f"{suggest(close)} ({legal})"
    of_pose = f'write joints in "positions: {{{key}: ...}}" or "pulses: {{{key}: ...}}"'
    instead = of_pose if kind == "pose" else f"{other} ({legal})" if other else ""
    return Suggestion(word, known, instead=instead, details=legal)()


def _key_and_value(key: str) -> tuple[str, str] | None:
    """Split a key that contains its value, such as "mass=1" or "limit {lower: 0}"; return None for other keys."""
    found = re.match(r"\s*([\w.-]+)(?:\s*[:=]\s*|\s+(?=[{\[]))(.*)", key, re.DOTALL)
    return (found[1], found[2]) if found else None


def _texts_with_commas(entry: Map) -> list[list[str]]:
    """Find unquoted texts with commas, which YAML splits into keys: ``{note: a, b}`` gives ``[["note", "b"]]``."""
    runs: list[list[str]] = []
    for before, key in pairwise(entry):
        value, span = entry[before], entry.key_spans[key]
        if entry[key] is not None or not isinstance(value, (str, NoneType)):
            continue
        begin = entry.key_spans[before] if value is None else entry.value_spans[before]
        lines = [begin.source.line(number) for number in range(begin.line, span.line + 1)]
        lines[-1] = lines[-1][: span.column - 1]
        if "".join(lines)[begin.column - 1 + begin.length :].strip() != ",":  # separated by more than a comma
            continue
        if runs and runs[-1][-1] == before:
            runs[-1].append(key)
        elif type(value) is str:
            runs.append([before, key])
    return runs


def text_meant_by(key: str, entry: Map) -> str:
    """Return the help for a key that is really text after a comma, as in ``{note: a, b}``, or "" for other keys."""
    for first, *rest in _texts_with_commas(entry):
        if key in rest:
            text = ", ".join([entry[first], *rest])
            return f"a comma ends text without quotes; write '{first}: \"{text}\"'"
    return ""


def text_tails(entry: Map, unknown: Collection[str]) -> set[str]:
    """Return keys that YAML reads from unquoted text after a comma, if the text belongs to a key in ``unknown``."""
    return {key for run in _texts_with_commas(entry) for before, key in pairwise(run) if before in unknown}


def is_meant(key: str, wanted: str, kind: str, known: Iterable[str]) -> bool:
    """Return True if an unknown key is probably a synonym or misspelling of the missing key ``wanted``."""
    table, written = words_for(kind), _key_and_value(key)
    if _meaning(key, table) == wanted or f"{wanted}: " in way_out(key, table):
        return True
    return (written is not None and written[0] == wanted) or nearest(key, list(known)) == wanted


def word_meant(word: str, known: Iterable[str], kind: str = "") -> str:
    """Return the help for an invalid word; ``known`` are the valid words, ``kind`` selects the synonyms."""
    table, names = synonyms("values", kind) or words_for(kind), list(known)
    close = _meaning(word, table)
    return way_out(word, table) or (suggest(close) if close in names else Suggestion(word, names)())


def suggest_name(
    tree: Map, path: Path, word: str, known: Names, otherwise: str = "", more: Names = (), none: str = ""
) -> Suggestion:
    """Return the suggestion for an unknown name at a path; ``known`` are the valid names.

    In a part, names of the same part are suggested first, without the prefix; ``more`` are further names in the part.
    ``otherwise`` and ``none`` are passed to ``Suggestion``.
    """
    span = tree.locate(path).span
    text = span.source.line(span.line)[span.column - 1 :][: span.length]
    is_mount = text.strip("\"'") == MOUNT  # "mount" stands for a frame outside of the part
    prefix = prefix_at(tree, path, outside=is_mount)
    own = [name.removeprefix(prefix) for name in known if prefix and name.startswith(prefix)]
    others = [name for name in known if not name.startswith(prefix)]
    if own:
        return Suggestion(word, [*own, *more], otherwise, others=others)
    return Suggestion(word, known, otherwise, none=none)


def fallen_out(tree: Map, path: Sequence[str | int], fragment: Mapping[str, Any]) -> tuple[str, bool] | None:
    """Detect a key of an entry that is not indented enough, so that YAML reads it as another entry of the section.

    Return (name of that entry, True if the key directly follows the name) or None; ``fragment`` is the entry's schema.
    """
    section = tree[str(path[0])] if len(path) == 2 else None
    legal = fragment.get("properties", {})
    if not isinstance(section, Map) or path[-1] not in legal:
        return None
    keys = list(section)
    index = above = keys.index(str(path[-1]))
    while above >= 0 and keys[above] in legal:
        above -= 1
    return (keys[above], above == index - 1) if above >= 0 and section[keys[above]] is None else None


def key_of_entry_meant(key: str, entry: Map, known: Sequence[str], kind: str) -> str:
    """Return the help for an unknown key of an entry before expansion, such as an entry of ``use``."""
    help = text_meant_by(key, entry) or word_meant(key, known, kind)
    if kind == "use" and help.startswith("known"):
        return f'to pass it to the part, write "with: {{{key}: VALUE}}"; known keys{help[5:]}'
    return help

"""Suggestions: what a person may have meant by a value of another kind than its place asks for, written as it should.

``unit_meant`` knows units as people write them, ``number_meant``, ``list_meant``, ``mapping_meant``, ``text_meant`` and
``flag_meant`` the values; each gives a way out in a few words, or nothing.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.source.diagnostics import did_you_mean, nearest
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.tree import Map, Seq, Text
from rosorin_compile.source.units import UNITS, Dimension, Quantity, parse_unit

from .schema import keys_of_xml, resolve, schema

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
MAX_SHOWN = 60
# A word of so many letters is no symbol of a unit: it may be the name of one, misspelt.
SPELLED_OUT = 5

# Units as people write them, by the word in small letters.
_UNITS = {
    **dict.fromkeys(("meter", "meters", "metre", "metres", "mtr"), "m"),
    **dict.fromkeys(("millimeter", "millimeters", "millimetre", "millimetres", "mms"), "mm"),
    **dict.fromkeys(("centimeter", "centimeters", "centimetre", "centimetres", "cms"), "cm"),
    **dict.fromkeys(("kilometer", "kilometers", "kilometre", "kilometres"), "km"),
    **dict.fromkeys(("\u00b5m", "\u03bcm", "micron", "microns", "micrometer", "micrometers"), "um"),
    **dict.fromkeys(("inches", "in", '"', "''", "\u2033", "\u201d", "zoll"), "inch"),
    **dict.fromkeys(("foot", "feet", "'", "\u2032"), "ft"),
    **dict.fromkeys(("gram", "grams", "gramme", "grammes", "gr", "gs"), "g"),
    **dict.fromkeys(("kilogram", "kilograms", "kilogramme", "kilo", "kilos", "kgs"), "kg"),
    **dict.fromkeys(("pound", "pounds", "lbs", "lbm"), "lb"),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "msecs", "millisecond", "milliseconds"), "ms"),
    **dict.fromkeys(("minute", "minutes", "mins"), "min"),
    **dict.fromkeys(("hour", "hours", "hr", "hrs"), "h"),
    **dict.fromkeys(("hertz",), "Hz"),
    **dict.fromkeys(("degree", "degrees", "degs", "\u00b0", "\u00ba", "\u02da", "grad"), "deg"),
    **dict.fromkeys(("radian", "radians", "rads"), "rad"),
    **dict.fromkeys(("turn", "turns", "revs", "revolution", "revolutions", "rot"), "rev"),
    **dict.fromkeys(("dps",), "deg/s"),
    **dict.fromkeys(("rps",), "rev/s"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("newtonmeter", "newtonmeters", "newtonmetre"), "Nm"),
    **dict.fromkeys(("ncm",), "N*cm"),
    **dict.fromkeys(("nmm", "mnm"), "N*mm"),
    **dict.fromkeys(("kgm",), "kg*m"),
    **dict.fromkeys(("watt", "watts"), "W"),
}
_SIGNS = {"\u00b2": "^2", "\u00b3": "^3", "**": "^", "\u00b7": "*", "\u22c5": "*", "\u00d7": "*", " per ": "/"}


def unit_meant(text: str, wanted: Sequence[str]) -> str:
    """Return the unit that a text may stand for, one of the kinds of ``wanted`` if it can be; "" for none.

    >>> unit_meant("degrees", []), unit_meant("kgm2", ["kg*m^2"]), unit_meant("KG", ["kg"])
    ('deg', 'kg*m^2', 'kg')
    """
    plain = text.strip()
    for sign, written in _SIGNS.items():
        plain = plain.replace(sign, written)
    plain = plain.strip().strip(".()[]").replace(".", "*").replace(" ", "*").replace("-", "*")
    plain = re.sub(r"\*+", "*", plain).replace("*/*", "/").replace("/*", "/").replace("*/", "/")
    dimensions = [unit[1] for unit in map(parse_unit, wanted) if unit is not None]
    guesses = [_factors(plain, {}), _factors(plain, {"nm": "Nm", "kg": "kgf"}), _factors(_split(plain), {})]
    known = [guess for guess in guesses if guess and parse_unit(guess) is not None]
    fitting = [guess for guess in known if (parse_unit(guess) or (0, None))[1] in dimensions]
    return (fitting or known or [""])[0]


def _factors(unit: str, others: Mapping[str, str]) -> str:
    """Return a unit with each factor as it is called here; ``others`` are readings of names that could be two."""
    pieces: list[str] = []
    for sign, word, power in re.findall(r"([*/]?)([^*/^\d\s]+)\^?(-?\d)?", unit):
        small = word.casefold()
        alike = [name for name in UNITS if name.casefold() == small]
        name = others.get(small) or (word if word in UNITS else _UNITS.get(small) or (alike[0] if alike else ""))
        close = nearest(small, _UNITS) if not name and len(small) >= SPELLED_OUT else None
        name = _UNITS[close] if close else name
        if not name:
            return ""
        pieces += [sign, name, f"^{power}" if power else ""]
    return "".join(pieces)


def _split(unit: str) -> str:
    """Return a unit of which two factors were written without a sign between them: kgm2 is kg*m2."""
    return re.sub(r"^(kg|g)(mm|cm|m)(?![a-z])", r"\1*\2", unit)


def units_like(wanted: Sequence[str]) -> list[str]:
    """Return the units of the dimensions that are wanted; all units if none has a name of its own."""
    dimensions: list[Dimension] = [unit[1] for unit in map(parse_unit, wanted) if unit is not None]
    return [name for name, (_, dimension) in UNITS.items() if dimension in dimensions] or list(UNITS)


def number_meant(text: str, wanted: Sequence[str], key: str = "") -> str:
    """Return the way out for a text where a number belongs; ``wanted`` are the units that may stand there.

    Under a ``key`` without any it is a plain number, counted in what the key says.
    """
    plain = text.strip()
    told = _of_signs(text, plain, wanted, key) or _of_references(plain) or _of_words(plain, wanted)
    quantity = "" if key and not wanted else "a quantity such as 12.5 mm, "
    return told or f"write a number, {quantity}or an expression ${{...}}"


def inner_number(value: Any, key: str) -> str:
    """Return the way out for a mapping or a list where a number belongs, under a key."""
    inner = list(value.values()) if isinstance(value, Map) else list(value) if isinstance(value, Seq) else []
    if len(inner) != 1:
        return ""
    if isinstance(value, Map) and inner[0] is None:
        return f'write "${{{next(iter(value))}}}" for a named value, in quotes'
    return f"write {key}: {_short(inner[0])}" if isinstance(inner[0], (int, float)) else ""


def _of_signs(text: str, plain: str, wanted: Sequence[str], key: str) -> str:
    if isinstance(text, Text) and _is_number(plain):
        return f"write it without the quotes: {plain}"
    tidy = plain.translate({0x2212: "-", 0x2013: "-", 0x2014: "-", 0xA0: " "}).rstrip(",;").strip()
    tidy = re.sub(r"(?<=\d)[_'\u2019 ](?=\d{3}(\D|$))", "", tidy)
    if tidy != plain and _is_number(tidy):
        return f"write {tidy}"
    comma = re.fullmatch(r"([-+]?\d+),(\d+)(\s*\D.*)?", plain)
    if comma:
        whole, part, unit = comma[1], comma[2], comma[3] or ""
        point = f"{whole}.{part}{unit}"
        thousands = f" (or {whole}{part}{unit})" if len(part) == 3 and len(whole.lstrip("+-")) < 4 else ""
        return f"a number has a point, not a comma: {point}{thousands}" if _is_number(point) else ""
    if re.fullmatch(rf"{_NUMBER}\s*%", plain):
        return f"write {float(plain.rstrip(' %')) / 100:g}"
    found = re.fullmatch(rf"[~\u2248<>=]*\s*({_NUMBER})\s*(\S.*)?", tidy, re.DOTALL)
    return _of_unit(found, wanted, key) if found else ""


def _of_unit(found: re.Match[str], wanted: Sequence[str], key: str) -> str:
    number, rest = found[1], (found[2] or "").strip()
    about = re.match(r"([A-Za-z*/^\d]*)\s*(\+-|\+/-|\u00b1)", rest)
    if about or rest in UNITS or not rest:
        return f"write {f'{number} {about[1] if about else rest}'.strip()} alone; the rest is for source: {{note: ...}}"
    if re.match(r"[-+*/(]|\d", rest):
        return ""
    if key and not wanted:
        return plain_number(float(number) * _megabytes(rest, key), " of megabytes" if "megabytes" in key else "")
    meant = unit_meant(rest, wanted)
    if meant:
        return f'there is no unit "{rest}"; write {number} {meant}' if '"' not in rest else f"write {number} {meant}"
    if re.fullmatch(r"[A-Za-z][\w^*/-]*", rest):
        return f'there is no unit "{rest}"; {did_you_mean(rest, units_like(wanted))}'
    return ""


def plain_number(value: float, counted: str = "") -> str:
    """Return the way out for a number with a unit where none may have one; ``counted`` says of what."""
    return f"write {value:g}: a plain number{counted}, without a unit"


def _megabytes(unit: str, key: str) -> float:
    """Return how many megabytes a unit of data has, for a key that counts in them; 1 for another unit or key."""
    found = re.fullmatch(r"([kmgt]?)(i?)(?:b|bytes?)?", unit.casefold())
    if found is None or "megabytes" not in key:
        return 1
    power = " kmgt".index(found[1] or " ")
    return float(1024 if found[2] else 1000) ** power / 1e6


def _of_references(plain: str) -> str:
    foreign = re.fullmatch(r"(?:\$\(|\$|\{\{?|%\(?|<|@)\s*([A-Za-z_]\w*)\s*(?:\)s?|\}\}?|%|>)?", plain)
    if foreign:
        name = foreign[1]
        return f'write "${{{name}}}", with {name} under args or let'
    sum_of = plain.replace("math.", "").replace("^", "**").replace("M_PI", "pi")
    inner = re.fullmatch(r"\{(.*)\}", sum_of)
    sum_of = inner[1] if inner else sum_of
    fraction = re.fullmatch(rf"({_NUMBER})\s*/\s*({_NUMBER})\s*([A-Za-z].*)", sum_of)
    if fraction and parse_unit(fraction[3]) and float(fraction[2]):
        return f"write {float(fraction[1]) / float(fraction[2]):g} {fraction[3]}"
    if len(plain) <= MAX_SHOWN and _is_expression(sum_of):
        return f'a calculation stands in an expression: "${{{sum_of}}}"'
    return ""


def _is_expression(text: str) -> bool:
    from .expression import ExpressionError, compiled

    if not re.search(r"[-+*/(]", text) and text not in ("pi", "tau"):
        return False
    if not re.search(r"\d|pi|\w\s*[-+*/]\s*\w", text):
        return False
    try:
        compiled(text)
    except ExpressionError:
        return False
    return True


_UNKNOWN = ("todo", "tbd", "tba", "fixme", "unknown", "?", "??", "???", "n/a", "na", "none", "xxx", "-", "x")


def _of_words(plain: str, wanted: Sequence[str]) -> str:
    if plain.casefold() in _UNKNOWN:
        return "not known yet? write the best guess, with source: {status: stand_in, note: ...}"
    if plain.casefold() in ("nan", "inf", "infinity", "-inf", "unlimited"):
        return "write a number, or leave the key out"
    if parse_unit(plain) or unit_meant(plain, wanted) in units_like(wanted):
        return "a number is missing before the unit"
    if re.fullmatch(r"\d+(:\d+)+", plain):
        return "a number is decimal: 12.5, not 12:30"
    if plain.isidentifier() and plain.isascii():
        return f'write a number, or "${{{plain}}}" for a named value'
    return ""


def _is_number(text: str) -> bool:
    value = plain_scalar(text) if text else None
    return isinstance(value, (int, float)) and not isinstance(value, bool)


_COLOURS = {
    "red": "[1, 0, 0, 1]",
    "green": "[0, 1, 0, 1]",
    "blue": "[0, 0, 1, 1]",
    "white": "[1, 1, 1, 1]",
    "black": "[0, 0, 0, 1]",
    "yellow": "[1, 1, 0, 1]",
    "orange": "[1, 0.5, 0, 1]",
    **dict.fromkeys(("grey", "gray"), "[0.5, 0.5, 0.5, 1]"),
}
_AXES = {"x": "[1, 0, 0]", "y": "[0, 1, 0]", "z": "[0, 0, 1]"}
_AXES |= {f"-{name}": axis.replace("1", "-1") for name, axis in _AXES.items()}
_TURNS = (("roll", "pitch", "yaw"), ("r", "p", "y"), ("x", "y", "z"), ("r", "g", "b", "a"))


_ITEMS = 'its items stand below it, each with "- " before it'


def list_meant(value: Any, key: str, fragment: Mapping[str, Any]) -> str:
    """Return the way out for what stands where a list belongs, under a key, by its fragment of the schema."""
    count = fragment.get("minItems", 0)
    items = fragment.get("items", {})
    if isinstance(value, Map):
        return _list_of(value, key, items)
    if isinstance(value, str):
        listed = numbers_in(value)
        if len(listed) > 1 and items.get("type") == "number":
            return f"write [{', '.join(listed)}]"
        known = _COLOURS.get(value.casefold()) or _hexadecimal(value) if key == "rgba" else None
        known = known or (_AXES.get(value.casefold().lstrip("+")) if key == "axis" else None)
        if known:
            return f"write {known}"
        if items.get("type") == "string" or items.get("$ref", "").endswith("/name"):
            return f"write [{', '.join(value.replace(',', ' ').split())}]"
        if value.startswith(("-", "\u2013", "\u2022", "*")):
            return 'an item of a list begins with "- ", with a space'
        return f"write {_example(key, int(count))}" if items.get("type") == "number" else _ITEMS
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        text = value.text if isinstance(value, Quantity) else f"{value:g}"
        if key == "scale":
            return f"write [{', '.join([text] * 3)}]"
        if key == "rpy":
            return f"write [0, 0, {text}] for a turn about z"
        return f"write {_example(key, int(count))}" if items.get("type") == "number" else f"write [{text}]"
    return ""


def _example(key: str, count: int) -> str:
    known = {"rpy": "[ROLL, PITCH, YAW]", "rgba": "[RED, GREEN, BLUE, OPACITY]", "axis": "[0, 0, 1]"}
    return known.get(key) or f"[{', '.join('XYZW'[:count] or 'X')}]"


def _is_xml(fragment: Mapping[str, Any]) -> bool:
    """Say whether a fragment of the schema is that of elements of XML, which are texts."""
    return fragment.get("$ref", "").endswith("/element") or fragment is schema()["$defs"]["element"]


def _as_xml(value: Map) -> str:
    name = next(iter(value), "NAME")
    inner = value.get(name)
    plain = inner.items() if isinstance(inner, Map) else ()
    attributes = [f' {key}="{_attribute(item)}"' for key, item in plain if not isinstance(item, (Map, Seq))]
    whole = len(attributes) == len(inner) if isinstance(inner, Map) else inner is None
    return f"<{name}{''.join(attributes)}{'/>' if whole else f'>...</{name}>'}"


def _attribute(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else _short(value)


def _list_of(value: Map, key: str, items: Mapping[str, Any]) -> str:
    if _is_xml(items):
        return f"its items are elements of XML: write {key}: ['{_as_xml(value)}']"
    small = {name.casefold(): name for name in value}
    for names in _TURNS:
        if small and set(small) <= set(names):
            given = [_short(value[small[name]]) if name in small else "01"[name == "a"] for name in names]
            return f"write the numbers alone: [{', '.join(given)}]"
    if list(value) == [key] or list(value) == ["xyz"]:
        return f"write {key}: {_short(next(iter(value.values())))}"
    glued = next((name for name in value if name[:1] in "-\u2013\u2022*"), None)
    if glued is not None:
        name = glued.lstrip("-*\u2013\u2022").strip()
        return f'an item of a list begins with "- ", with a space: "- {name}: ..."'
    if items.get("type") != "number":
        value = value["geometry"] if isinstance(value.get("geometry"), Map) else value
        first = next(iter(value), "")
        return f'its items begin with "- ": write "- {first}: ..."' if first else "write []"
    return ""


def _hexadecimal(text: str) -> str | None:
    found = re.fullmatch(r"#?([0-9a-fA-F]{6})([0-9a-fA-F]{2})?", text)
    if found is None:
        return None
    letters = found[1] + (found[2] or "ff")
    return f"[{', '.join(f'{int(letters[i : i + 2], 16) / 255:.3g}' for i in (0, 2, 4, 6))}]"


def numbers_in(text: str) -> list[str]:
    """Return the numbers and quantities that a text lists; none if it has anything else in it.

    >>> numbers_in("0 0 20 mm"), numbers_in("(1, 2.5; 3)"), numbers_in("no")
    (['0', '0', '20 mm'], ['1', '2.5', '3'], [])
    """
    found: list[str] = []
    for word in re.split(r"[\s,;]+", text.strip("()[]{}<> \t\n")):
        if _is_number(word):
            found.append(word)
        elif found and parse_unit(word) and " " not in found[-1]:
            found[-1] += f" {word}"
        else:
            return []
    return found


def items_meant(value: Seq, fragment: Mapping[str, Any]) -> str:
    """Return the way out for a list that has another number of items; "" if there is none to guess."""
    if fragment.get("items", {}).get("type") != "number":
        return ""
    if len(value) == 1 and isinstance(value[0], str) and len(listed := numbers_in(value[0])) > 1:
        return f'a "," stands between its items: [{", ".join(listed)}]'
    whole = all(type(item) is int for item in value)
    if whole and len(value) == 2 * fragment.get("maxItems", 0):
        pairs = (f"{first}.{second}" for first, second in zip(value[::2], value[1::2], strict=True))
        return f"a number has a point, not a comma: [{', '.join(pairs)}]"
    return ""


def mapping_meant(value: Any, path: Sequence[str | int], fragment: Mapping[str, Any]) -> str:
    """Return the way out for what stands where a mapping belongs, at a path, by its fragment of the schema."""
    legal = fragment.get("properties", {})
    for key in fragment.get("required", ()):
        if value in resolve(legal.get(key, {})).get("enum", ()):
            return f"write {path[-1]}: {{{key}: {value}}}"
    if isinstance(value, str) and (told := _entry_in(value, legal or None)):
        return told
    if not legal and isinstance(value, Seq):
        return _named(value, str(path[-1]))
    if not legal and isinstance(value, str) and value:
        return f'a ":" is missing: write {value}: ...' if len(value.split()) == 1 else ""
    if value is None:
        return "what belongs to it is indented below it" if legal else "indent its entries below it, or remove it"
    if value in ("none", "empty", "nil", "None") or (not value and not isinstance(value, (int, float))):
        return "write {} for an empty one"
    if isinstance(value, Seq) and legal and all(isinstance(item, Map) and set(item) <= set(legal) for item in value):
        return 'its keys stand without "- " before them'
    if isinstance(value, Seq) and "lower" in legal and len(value) == 2:
        return f"write {path[-1]}: {{lower: {_short(value[0])}, upper: {_short(value[1])}, effort: ..., velocity: ...}}"
    required = fragment.get("required", ())
    for key in [*required, *legal]:
        if _may_be(value, key, resolve(legal[key]) if key in legal else {}):
            shown = ", ".join([_short(value), *(f"{other}: ..." for other in required if other != key)])
            return f"write {path[-1]}: {{{key}: {shown}}}" if isinstance(path[-1], str) else f"write {key}: {shown}"
    keys = required or [key for key in legal if key not in {"source", *keys_of_xml()}][:4]
    return f"write {{{', '.join(f'{key}: ...' for key in keys)}}}" if keys else ""


def _may_be(value: Any, key: str, part: Mapping[str, Any]) -> bool:
    """Say whether a value may be what a key of a mapping is for, by its fragment of the schema."""
    if "enum" in part or key in {*keys_of_xml(), "name"}:
        return False
    kind = "string" if isinstance(value, str) else "array" if isinstance(value, Seq) else "number"
    wanted = part.get("type", "")
    fits = kind in ([wanted] if isinstance(wanted, str) else wanted)
    return fits and (kind != "array" or _may_hold(part, value))


def _may_hold(part: Mapping[str, Any], value: Seq) -> bool:
    wanted = part.get("items", {}).get("type", "")
    of_one_kind = not any(isinstance(item, (Map, Seq)) for item in value) or wanted not in ("number", "string")
    return part.get("minItems", len(value)) == len(value) and of_one_kind


def _short(value: Any) -> str:
    if isinstance(value, Seq):
        plain = all(isinstance(item, (int, float, str)) for item in value) and len(value) < 7
        return f"[{', '.join(_short(item) for item in value)}]" if plain else "[...]"
    if isinstance(value, Quantity):
        return value.text
    return f"{value:g}" if isinstance(value, float) else str(value)[:MAX_SHOWN]


def _entry_in(value: str, legal: Mapping[str, Any] | None) -> str:
    if value.startswith("<"):
        return "this is XML: write it in YAML, or keep it under urdf_elements"
    pairs = re.findall(r"([\w.-]+)\s*=\s*\"?([^\s\",=]+)", value)
    if len(pairs) > 1 and (legal is None or all(name in legal for name, _ in pairs)):
        return f"write {{{', '.join(f'{name}: {given}' for name, given in pairs)}}}"
    found = re.fullmatch(r"([\w./-]+)\s*(:=|[:=])\s*(.*)", value, re.DOTALL)
    if found and (legal is None or found[1] in legal):
        return f"write {found[1]}: {found[3]}".strip()
    if legal is not None and value.split(" ")[0] in legal:
        return f"write {value.replace(' ', ': ', 1) if ' ' in value else value + ': ...'}"
    return ""


def _named(value: Seq, section: str) -> str:
    first = value[0] if value else None
    if isinstance(first, Map):
        name = first.get("name") or (next(iter(first)) if len(first) == 1 else None)
        glue = 'without "- " and "name:"' if "name" in first else 'without "- "'
        return f'each stands under its name, {glue}: "{name or "NAME"}:"'
    if isinstance(first, str):
        body = "{file: ...}" if section == "outputs" else "{}"
        return f"each stands under its name: {{{first}: {body}}}"
    return "each stands under its name"


def text_meant(value: Any, key: str, fragment: Mapping[str, Any]) -> str:
    """Return the way out for what stands where a text belongs, under a key, by its fragment of the schema."""
    if isinstance(value, Map) and _is_xml(fragment):
        return f"an element is XML: write - {_as_xml(value)}"
    if isinstance(value, (bool, int, float)):
        return "put it in quotes to make it text"
    inner = list(value.values()) if isinstance(value, Map) else list(value) if isinstance(value, Seq) else []
    if len(inner) == 1 and isinstance(inner[0], str):
        return f"write {key}: {inner[0]}"
    if isinstance(value, Map) and isinstance(value.get("name"), str):
        return f"write {key}: {value['name']}"
    return f"write {key}: NAME" if value is None or inner else ""


_TRUE = ("yes", "y", "on", "true", "1", "enabled")
_FALSE = ("no", "n", "off", "false", "0", "disabled")


def flag_meant(value: Any) -> str:
    """Return the way out for what stands where true or false belongs; "" if it says neither."""
    word = str(value).casefold()
    meant = "true" if word in _TRUE else "false" if word in _FALSE else ""
    if not meant:
        return ""
    if isinstance(value, Text):
        return f"write {meant}, without quotes"
    return f"write {meant}: in YAML 1.2 {value} is a text" if isinstance(value, str) else f"write {meant}"

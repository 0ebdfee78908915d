"""Declare and check parameters (``args``, ``params``), and check the keys of parts, sensor types and ``use`` entries.

The JSON Schema does not cover these keys: it is applied after expansion, which removes them.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Help, Related, Suggestion, error, nearest
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.units import ANGLE, DIMENSIONS, LENGTH, NUMBER, UNITS, Dimension, Quantity, describe, in_si
from rosorin_compile.source.wording import hidden_letter, in_words, quote

from ..annotations import ENTRIES, ITEMS
from ..expression.functions import kind_of
from ..expression.syntax import CHOICES
from ..schema import merged_sections, of_parts, resolve, schema
from ..suggestions import flag_meant, key_of_entry_meant, number_meant, text_tails, word_meant
from .placing import AXES, is_number, is_vector
from .provenance import argument_at
from .scope import EvaluationFailed, Scope, key_place, value_place

Given = Mapping[str, tuple[Any, Place]]  # (value, position of the value) by argument name

KEYS = ("type", "default", "one_of", "help")
TYPES: dict[str, tuple[type, ...]] = {"any": (object,), "text": (str,), "boolean": (bool,), "integer": (int,)}
TYPES |= {"number": (int, float), "list": (list,), "table": (dict,)}
_KINDS = {Map: "a mapping", Seq: "a list", str: "text", bool: "true or false", float: "a number"}
_PARAMETER_KINDS = {"type": str, "min": float, "max": float}
FILE_KEYS = ("rosorin_compile", "help", "let", "parts", "sensor_types")
_PART_KEYS = ("help", "params", "let", "use")
_USE_KINDS = {"part": str, "with": Map, "prefix": str, "parent": str, "content": Map}
_CONTROLS = {
    "for": "a loop goes inside the entry that it repeats",
    "if": "a condition goes inside the entry that it applies to",
}
_USE_KEYS = ("part", "with", "prefix", "parent", "xyz", "rpy", "mirror", "content", "source")


class Parameter(NamedTuple):
    """A parameter that ``args`` or ``params`` declares; ``sound`` is False if the declaration has errors.

    ``place`` is the position of the default or, if there is none, of the name. ``low`` and ``high`` are the limits
    ``min`` and ``max``.
    """

    name: str
    place: Place
    type: str = ""
    has_default: bool = False
    default: Any = None
    one_of: Any = None
    low: Any = None
    high: Any = None
    help: str = ""
    sound: bool = True

    def accepts(self, value: Any) -> bool:
        """Return True if a value has the declared type or, if no type is declared, the type of the default."""
        if isinstance(value, (list, dict)):
            return False
        if self.type not in ("", "any"):
            return _fits(value, self.type)
        written = self.has_default and not (isinstance(self.default, str) and "$" in self.default)
        return written and kind_of(value) == kind_of(self.default)


def declare(scope: Scope, declared: Any, given: Given, owner: str, user: Place | None = None, lets: Any = None) -> None:
    """Define each declared parameter as a name in a scope: its value is the argument, or else the default.

    Report unknown arguments, missing arguments and wrong types. ``given`` has the arguments; ``owner`` is the name of
    the part or description in messages. Missing arguments are reported at the entry ``user``, or at the declaration if
    ``user`` is None. Defaults may use the named values ``lets``. Expressions with a missing argument cause no further
    errors.
    """
    known = scope.declared = _parameters(scope, declared)
    unknown, spans = [name for name in given if name not in known], {key: one.place.span for key, one in known.items()}
    for name in unknown:
        help = Suggestion(name, known, none="it has none", places=spans)
        scope.report("unknown-argument", f'{owner} has no argument "{name}"', given[name][1], help)
    missing = [one for name, one in known.items() if name not in given and not one.has_default]
    scope.broken.update(one.name for one in missing)
    # Do not report an argument as missing if an unknown argument is probably its misspelled name.
    suggested = [nearest(name, known) for name in unknown]
    missing = [one for one in missing if one.sound and one.name not in suggested]
    for first, *others in [missing] if user and missing else [[one] for one in missing]:
        names, place = [one.name for one in (first, *others)], user or first.place
        values = f'add "with: {{{": VALUE, ".join(names)}: VALUE}}"' if user else f'write "-a {first.name}=VALUE"'
        way = "; ".join(filter(None, [values, first.help if not others else ""]))
        stack = [note for note in (scope.via.stack() if scope.via else place.stack()) if note.span != place.span]
        related = [Related("declared here", first.place.span)] if user else []
        message = f"{owner} needs the argument{'s' if others else ''} {quote(names)}"
        scope.expansion.diagnostics.append(error("missing-argument", message, place.span, way, [*related, *stack]))
    for name, parameter in known.items():
        if name in given:
            scope.bind(name, *given[name])
        elif parameter.has_default and scope.expansion.is_constant(parameter.default):
            scope.bind(name, parameter.default, parameter.place)
            scope.local[name] = parameter.place
        elif parameter.has_default:
            scope.define(name, parameter.default, parameter.place)
    scope.define_all(lets)
    for name, parameter in known.items():
        _check(scope, parameter, given[name][1] if name in given else parameter.place, owner)


def _parameters(scope: Scope, declared: Any) -> dict[str, Parameter]:
    known: dict[str, Parameter] = scope.expansion.parameters.setdefault(id(declared), {})
    for name, entry in declared.items() if isinstance(declared, Map) and not known else ():
        if not isinstance(entry, Map):  # the short form "NAME: DEFAULT"
            place = key_place(declared, name) if entry is None else value_place(declared, name)
            known[name] = Parameter(name, place, has_default=entry is not None, default=entry)
            continue
        good = check_entry(f'argument "{name}"', entry, scope, (*KEYS, "min", "max"), _PARAMETER_KINDS, "arg")
        kind = entry["type"] if isinstance(entry.get("type"), str) else ""
        if kind and kind not in TYPES and kind not in DIMENSIONS:
            help = partial(word_meant, kind, [*TYPES, *DIMENSIONS], "arg type")
            message = f'"type" of argument "{name}" cannot be "{kind}"'
            scope.report("wrong-value", message, value_place(entry, "type"), help)
            kind = ""
        has_default = "default" in entry
        place = value_place(entry, "default") if has_default else key_place(declared, name)
        low, high = (bound if is_number(bound) else None for bound in (entry.get("min"), entry.get("max")))
        default, one_of, help_text = entry.get("default"), entry.get("one_of"), entry.get("help")
        help_text = f'description of "{name}": {help_text}' if help_text else ""
        known[name] = Parameter(name, place, kind, has_default, default, one_of, low, high, help_text, good)
    return known


def _check(scope: Scope, parameter: Parameter, place: Place, owner: str) -> None:
    name, wanted, low, high = parameter.name, parameter.type, parameter.low, parameter.high
    if not wanted and parameter.one_of is None and low is None and high is None:
        return
    try:
        value = scope.lookup(name)
        allowed = scope.resolve(parameter.one_of, place)
    except EvaluationFailed:
        return
    if value is None and parameter.has_default:  # "none" is valid for an optional argument, whatever its type
        return
    limited = isinstance(allowed, list)
    if wanted and not _fits(value, wanted):
        shown = f'the text "{value}"' if isinstance(value, str) else kind_of(value)
        message = f'argument "{name}" of {owner} must be of type {wanted}, not {shown}'
        help: Help = parameter.help
        if not help and wanted == "boolean":
            help = flag_meant(value) or "write true or false"
        elif not help and isinstance(value, str) and (wanted in DIMENSIONS or wanted in ("integer", "number")):
            units = [unit for unit, (_, dimension) in UNITS.items() if dimension == DIMENSIONS.get(wanted)]
            help = partial(number_meant, value, units)
    elif limited and value not in allowed:
        shown = f'"{value}"' if isinstance(value, (str, int, float)) else kind_of(value)
        message = f'argument "{name}" of {owner} cannot be {shown}'
        details = "; ".join(filter(None, [f"possible values: {', '.join(map(str, allowed))}", parameter.help]))
        texts = [one for one in allowed if isinstance(one, str)]
        help = Suggestion(value, texts, details=details) if isinstance(value, str) else details
    elif is_number(value) and not ((low is None or value >= low) and (high is None or value <= high)):
        least, most, shown = (getattr(n, "text", "") or f"{n:g}" if n is not None else "" for n in (low, high, value))
        shown += f" {in_si(0, DIMENSIONS[wanted]).unit}" if wanted in DIMENSIONS and type(value) is not Quantity else ""
        bounds = f"from {least} to {most}" if least and most else f"at least {least}" if least else f"at most {most}"
        message, help = f'argument "{name}" of {owner} must be {bounds}, not {shown}', parameter.help
    else:
        if wanted in DIMENSIONS and not isinstance(value, Quantity):
            value = in_si(value, DIMENSIONS[wanted])
        scope.values[name] = float(value) if wanted == "number" and isinstance(value, Quantity) else value
        if limited:
            scope.values[name + CHOICES] = allowed
        return
    scope.broken.add(name)
    scope.values.pop(name, None)
    scope.report_origin("bad-argument", message, place, help, (), argument_at(scope, place.span, not limited))


def _fits(value: Any, wanted: str) -> bool:
    if wanted not in TYPES or wanted == "number":
        return is_number(value, DIMENSIONS.get(wanted, NUMBER))
    return isinstance(value, TYPES[wanted]) and not (wanted == "integer" and isinstance(value, bool))


def check_part(name: str, parts: Map, scope: Scope) -> bool:
    """Report invalid keys and sections of the part ``name`` in ``parts``; return True if all are valid."""
    owner, body = f'part "{name}"', parts[name]
    if not isinstance(body, Map):
        scope.report("wrong-type", f"{owner} must be a mapping, not {_kind(body)}", place_of(parts, name, scope))
        return False
    kinds = dict.fromkeys(("params", "let", "use"), Map)
    good = check_entry(owner, body, scope, (*_PART_KEYS, *of_parts()), kinds, "part")
    good &= check_controls(f" of {owner}", body, (*merged_sections(ENTRIES, in_parts=True), "use"), scope)
    return check_sections(owner, body, scope, evaluated=False) and good


def check_use(name: str, entry: Map, scope: Scope) -> None:
    """Report invalid keys and values of the ``use`` entry ``name``. Raises EvaluationFailed if there are any."""
    owner = f'the entry "{name}" of "use"'
    good = check_entry(owner, entry, scope, _USE_KEYS, _USE_KINDS, "use")
    good &= not hides_letters("prefix", entry, scope)
    good &= _check_vector(owner, entry, "xyz", LENGTH, scope) & _check_vector(owner, entry, "rpy", ANGLE, scope)
    content, mirror = entry.get("content"), entry.get("mirror")
    if isinstance(content, Map):
        good &= check_entry(f'"content" of {owner}', content, scope, of_parts(), {})
        good &= check_sections(f'"content" of {owner}', content, scope)
    if mirror is not None and not (isinstance(mirror, str) and mirror in AXES):
        shown = f'"{mirror}"' if isinstance(mirror, str) else kind_of(mirror)
        help = "possible values: x, y, z (the axis that is reversed)"
        raise scope.fail("wrong-value", f'"mirror" of {owner} cannot be {shown}', value_place(entry, "mirror"), help)
    if not good:
        raise EvaluationFailed


def hides_letters(key: str, entry: Map, scope: Scope) -> bool:
    """Report an invisible character in the value of ``key``; return True if it was reported."""
    value = entry.get(key)
    if letter := hidden_letter(value) if isinstance(value, str) else "":
        message = f'{key} "{value}" contains an invisible character: {in_words(letter)}'
        scope.report("invisible-letter", message, place_of(entry, key, scope), "retype it without this character")
    return bool(letter)


def check_controls(owner: str, tree: Map, sections: Sequence[str], scope: Scope) -> bool:
    """Report ``for`` and ``if`` that are directly in a section, not in an entry; return True if there are none."""
    good = True
    tables = [(section, tree[section]) for section in sections if isinstance(tree.get(section), Map)]
    for section, entries, control in [(*one, control) for one in tables for control in _CONTROLS if control in one[1]]:
        value = entries[control]
        is_control = isinstance(value, (str, bool))
        if control == "for":  # may be the name of an entry, to which "source" of the file was copied
            entry: Any = schema()["properties"].get(section, {}).get("additionalProperties", {})
            legal = _USE_KEYS if section == "use" else resolve(entry).get("properties", ())
            is_control = isinstance(value, Map) and bool(value) and ({*value} - {"source"}).isdisjoint(legal)
        if is_control:
            place = Place(entries.key_spans[control], scope.via or entries.via)
            message = f'"{control}" is not an entry of "{section}"{owner}: {_CONTROLS[control]}'
            scope.report("wrong-type", message, place, f'write "NAME: {{{control}: ..., ...}}"')
            good = False
    return good


def check_sections(owner: str, tree: Map, scope: Scope, evaluated: bool = True) -> bool:
    """Report sections of a wrong type; return True if there are none. Allow expressions if ``evaluated`` is False."""
    lists = merged_sections(ITEMS, in_parts=True)
    texts = () if evaluated else [key for key, value in tree.items() if isinstance(value, str) and "$" in value]
    kinds = {key: Seq if key in lists else Map for key in of_parts() if key not in texts}
    return check_entry(owner, tree, scope, None, kinds)


def check_entry(
    owner: str, tree: Map, scope: Scope, keys: Sequence[str] | None, kinds: Mapping[str, type], word: str = ""
) -> bool:
    """Report keys that are not in ``keys``, and values of a wrong type; return True if there are none.

    ``owner`` is the entry's name in messages. If ``keys`` is None, all keys are valid. ``kinds`` maps keys to types.
    ``word`` is the kind of entry, such as "arg", which selects the synonyms in suggestions.
    """
    unknown = [key for key in tree if keys is not None and key not in keys]
    tails = text_tails(tree, unknown) if unknown else ()
    for key in (key for key in unknown if key not in tails):
        help = partial(key_of_entry_meant, key, tree, keys or (), word)
        place = Place(tree.key_spans[key], scope.via or tree.via)
        scope.report("unknown-key", f'{owner} has no key "{key}"', place, help)
    given = [(key, kind) for key, kind in kinds.items() if tree.get(key) is not None]
    wrong = [key for key, kind in given if not isinstance(tree[key], (int, float) if kind is float else kind)]
    for key in wrong:
        message = f'"{key}" of {owner} must be {_KINDS[kinds[key]]}, not {_kind(tree[key])}'
        scope.report("wrong-type", message, place_of(tree, key, scope))
    return not unknown and not wrong


def _check_vector(owner: str, tree: Map, key: str, dimension: Dimension, scope: Scope) -> bool:
    value: Any = tree.get(key)
    if is_vector(value, dimension):
        return True
    is_triple = isinstance(value, list) and len(value) == 3
    wrong = [one for one in value if not is_number(one, dimension)] if is_triple else [value]
    rule, message, help = "not-finite", "has an infinite number or NaN", "write numbers, or remove the key"
    if wrong and isinstance(wrong[0], Quantity) and is_triple:
        message = f"must be {describe(dimension)}, but {wrong[0].text or float(wrong[0])} is {_kind(wrong[0])}"
        rule, help = "wrong-unit", "correct the unit; a bare number is in SI units"
    elif wrong:
        message = f"must be a list of three numbers, not {'of ' if is_triple else ''}{_kind(wrong[0])}"
        rule, help = "wrong-type", ""
    scope.report(rule, f'"{key}" of {owner} {message}', place_of(tree, key, scope), help)
    return False


def place_of(entry: Map, key: str, scope: Scope) -> Place:
    """Return the place of the value of ``key``, or the place of the entry if it lacks the key."""
    return Place(entry.value_spans.get(key, entry.span), scope.via or entry.via)


def _kind(value: Any) -> str:
    if isinstance(value, (Map, Seq)):
        return "a mapping" if isinstance(value, Map) else f"a list of length {len(value)}"
    return "empty" if value is None else kind_of(value)

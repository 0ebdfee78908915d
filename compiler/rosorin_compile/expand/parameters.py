"""Parameters: the declared inputs of a description (``args``) and of a part (``params``), and their checks.

A parameter is a mapping with ``type``, ``default``, ``one_of`` and ``help``, all optional; anything else is
its default.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..diagnostic import did_you_mean
from ..expression.functions import kind_of
from ..quantity import DIMENSIONS, NUMBER, Quantity
from ..tree import Map, Place, locate
from .scope import Failed, Scope

KEYS = ("type", "default", "one_of", "help")

TYPES: dict[str, tuple[type, ...]] = {
    "any": (object,),
    "text": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
    "list": (list,),
    "table": (dict,),
}


class Parameter(NamedTuple):
    """A declared parameter; ``place`` is where its default is written, or its name."""

    name: str
    type: str
    has_default: bool
    default: Any
    one_of: Any
    help: str
    place: Place


def declare(
    scope: Scope, declared: Any, given: Mapping[str, Any], places: Mapping[str, Place], owner: str, way: str
) -> None:
    """Bind every declared parameter in a scope: to what was given, else to its default, evaluated in that scope.

    ``places`` says where each given value stands; ``owner`` names what is parameterised, and ``way`` how an argument is
    given to it, for messages. Values of the
    wrong type, unknown names and missing values are reported; a name without a value stays broken, so that what uses it
    adds no further message.
    """
    known = _parameters(scope, declared)
    for name in given:
        if name not in known:
            help = did_you_mean(name, known) or "it has none"
            scope.report("unknown-argument", f'{owner} has no argument "{name}"', places[name], help)
    for name, parameter in known.items():
        if name in given:
            scope.bind(name, given[name], places[name])
        elif not parameter.has_default:
            scope.broken.add(name)
            help = f"give it: {way.format(name)}" + (f"; {parameter.help}" if parameter.help else "")
            scope.report("missing-argument", f'{owner} needs the argument "{name}"', parameter.place, help)
            continue
        elif scope.ledger.is_constant(parameter.default):
            scope.bind(name, parameter.default, parameter.place)
        else:
            scope.define(name, parameter.default, parameter.place)
        if parameter.type or parameter.one_of is not None:
            _check(scope, parameter, places.get(name, parameter.place), owner)


def _parameters(scope: Scope, declared: Any) -> dict[str, Parameter]:
    """Return the declared parameters by name, read once for each declaration."""
    if not isinstance(declared, Map):
        return {}
    known: dict[str, Parameter] | None = scope.ledger.parameters.get(id(declared))
    if known is None:
        known = {name: _parameter(name, entry, declared) for name, entry in declared.items()}
        scope.ledger.parameters[id(declared)] = known
    return known


def _parameter(name: str, entry: Any, declared: Map) -> Parameter:
    place = locate(declared, (name,), key=True)
    if entry is None:
        return Parameter(name, "", False, None, None, "", place)
    if not isinstance(entry, Map) or (entry and not set(entry) & set(KEYS)):
        return Parameter(name, "", True, entry, None, "", Place(declared.value_spans[name], declared.via))
    if "default" in entry:
        place = Place(entry.value_spans["default"], entry.via)
    wanted, help = str(entry.get("type") or ""), str(entry.get("help") or "")
    return Parameter(name, wanted, "default" in entry, entry.get("default"), entry.get("one_of"), help, place)


def _check(scope: Scope, parameter: Parameter, place: Place, owner: str) -> None:
    """Hold the value of a parameter against its type and its allowed values."""
    name, wanted = parameter.name, parameter.type
    try:
        value = scope.lookup(name)
        allowed = scope.resolve(parameter.one_of, place)
    except Failed:
        return
    if wanted and not _fits(value, wanted):
        message = f'"{name}" of {owner} is {_article(wanted)}, not {_shown(value)}'
        known = [*TYPES, *DIMENSIONS]
        help = parameter.help if wanted in known else f'there is no type "{wanted}"; {did_you_mean(wanted, known)}'
    elif isinstance(allowed, list) and value not in allowed:
        told = f'"{value}"' if isinstance(value, (str, int, float)) else kind_of(value)
        message = f'{told} is not a value of the argument "{name}"'
        help = f"allowed: {', '.join(map(str, allowed))}" + (f"; {parameter.help}" if parameter.help else "")
    else:
        return
    scope.broken.add(name)
    scope.values.pop(name, None)
    scope.report("bad-argument", message, place, help)


def _fits(value: Any, wanted: str) -> bool:
    if wanted in TYPES:
        if isinstance(value, bool) and wanted in ("integer", "number"):
            return False
        if isinstance(value, Quantity) and wanted == "number":
            return value.dimension == NUMBER
        return isinstance(value, TYPES[wanted])
    dimension = DIMENSIONS.get(wanted)
    if dimension is None or isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return not isinstance(value, Quantity) or value.dimension == dimension


def _article(wanted: str) -> str:
    if wanted in ("text", "any"):
        return wanted
    return f"{'an' if wanted[0] in 'aeiou' else 'a'} {wanted.replace('_', ' ')}"


def _shown(value: Any) -> str:
    return f'the text "{value}"' if isinstance(value, str) else kind_of(value)

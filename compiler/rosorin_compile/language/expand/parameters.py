"""Parameters: the declared inputs of a description (``args``) and of a part (``params``), and their checks.

A parameter is a mapping with ``type``, ``default``, ``one_of`` and ``help``, all optional; anything that is no mapping
is its default.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Related, did_you_mean, error, nearest
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Map, Place, Seq, locate
from rosorin_compile.source.units import DIMENSIONS, NUMBER, Quantity, in_si
from rosorin_compile.source.wording import quoted

from ..expression import CHOICES
from ..expression.functions import kind_of
from ..suggestions import flag_meant, number_meant, text_meant_by, text_tails, word_meant
from .ledger import Failed
from .scope import Scope

RULES = (
    Rule(
        "unknown-argument",
        "`-a`, the `args` of an include or a `with` sets an argument that there is not.",
        "Correct the name, or add it to `args` or `params`.",
        ARGUMENTS,
    ),
    Rule(
        "missing-argument",
        "An argument without a default is not given.",
        "Give it: `-a NAME=VALUE`, or `with: {NAME: VALUE}`.",
        ARGUMENTS,
    ),
    Rule(
        "bad-argument",
        "An argument has a value of another type, or one that `one_of`, `min` or `max` does not allow.",
        "Give one that the message names.",
        ARGUMENTS,
    ),
)

KEYS = ("type", "default", "one_of", "help")
BOUNDS = ("min", "max")  # of parameters of sensor types

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
    sound: bool = True

    def fits(self, value: Any) -> bool:
        """Say whether a value is of the kind that is asked for: that of the type, or of the default.

        Of what stands in a list or a table nobody has asked anything.
        """
        if isinstance(value, (list, dict)):
            return False
        if self.type not in ("", "any"):
            return _fits(value, self.type)
        written = self.has_default and not (isinstance(self.default, str) and "$" in self.default)
        return written and kind_of(value) == kind_of(self.default)


def declare(
    scope: Scope,
    declared: Any,
    given: Mapping[str, Any],
    places: Mapping[str, Place],
    owner: str,
    way: str,
    asked: Place | None = None,
) -> None:
    """Bind every declared parameter in a scope: to what was given, else to its default, evaluated in that scope.

    ``places`` says where each given value stands; ``owner`` names what is parameterised, and ``way`` how an argument is
    given to it, for messages; ``asked`` is the place of whoever should have given it, if not that of the declaration.
    Values of the wrong type, unknown names and missing values are reported; a name without a value stays broken, so
    that what uses it adds no further message.
    """
    known = scope.declared = _parameters(scope, declared)
    meant: set[str | None] = set()
    for name in given:
        if name not in known:
            help = did_you_mean(name, known) or "it has none"
            close = nearest(name, known)
            meant.add(close)
            near = [Related("the suggestion is defined here", known[close].place.span)] if close else []
            scope.report("unknown-argument", f'{owner} has no argument "{name}"', places[name], help, near)
    missing = [parameter for name, parameter in known.items() if name not in given and not parameter.has_default]
    scope.broken.update(parameter.name for parameter in missing)
    # Of others the default, or the argument, may be there under a misspelt key, which is reported.
    sound = [parameter for parameter in missing if parameter.sound and parameter.name not in meant]
    for together in [sound] if asked and sound else [[parameter] for parameter in sound]:
        _missing(scope, together, owner, way, asked)
    for name, parameter in known.items():
        if name in given:
            scope.bind(name, given[name], places[name])
        elif not parameter.has_default:
            continue
        elif scope.ledger.is_constant(parameter.default):
            scope.bind(name, parameter.default, parameter.place)
            scope.said[name] = parameter.place
        else:
            scope.define(name, parameter.default, parameter.place)
        if parameter.type or parameter.one_of is not None:
            _check(scope, parameter, places.get(name, parameter.place), owner)


def _missing(scope: Scope, missing: list[Parameter], owner: str, way: str, asked: Place | None) -> None:
    """Report parameters without a value, where they should have been given."""
    names = [parameter.name for parameter in missing]
    if len(missing) == 1:
        explained = f"; {missing[0].help}" if missing[0].help else ""
        what, help = f'argument "{names[0]}"', f"give it: {way.format(names[0])}{explained}"
    else:
        what, help = f"arguments {quoted(names)}", f"give them: {way.format(': VALUE, '.join(names))}"
    place = asked or missing[0].place
    stack = [note for note in (scope.via.stack() if scope.via else place.stack()) if note.span != place.span]
    related = [Related("declared here", missing[0].place.span)] if asked else []
    message = f"{owner} needs the {what}"
    scope.ledger.diagnostics.append(error("missing-argument", message, place.span, help, [*related, *stack]))


def _parameters(scope: Scope, declared: Any) -> dict[str, Parameter]:
    """Return the declared parameters by name, read once for each declaration."""
    if not isinstance(declared, Map) or not declared:
        return {}
    known: dict[str, Parameter] | None = scope.ledger.parameters.get(id(declared))
    if known is None:
        known = {name: _parameter(scope, name, entry, declared) for name, entry in declared.items()}
        scope.ledger.parameters[id(declared)] = known
    return known


def _parameter(scope: Scope, name: str, entry: Any, declared: Map) -> Parameter:
    place = locate(declared, (name,), key=True)
    if entry is None:
        return Parameter(name, "", False, None, None, "", place)
    if not isinstance(entry, Map):
        return Parameter(name, "", True, entry, None, "", Place(declared.value_spans[name], declared.via))
    unknown = [key for key in entry if key not in (*KEYS, *BOUNDS)]
    if unknown:
        tails = text_tails(entry, unknown)
        for key in (one for one in unknown if one not in tails):
            help = text_meant_by(key, entry) or word_meant(key, KEYS, "arg")
            scope.report(
                "unknown-key", f'argument "{name}" has no key "{key}"', Place(entry.key_spans[key], entry.via), help
            )
    if "default" in entry:
        place = Place(entry.value_spans["default"], entry.via)
    help = str(entry.get("help") or "")
    wanted = _type(scope, name, entry)
    default, one_of = entry.get("default"), entry.get("one_of")
    return Parameter(name, wanted, "default" in entry, default, one_of, help, place, not unknown)


def _type(scope: Scope, name: str, entry: Map) -> str:
    """Return the declared type of a parameter; one that does not exist is reported, and no value held against it."""
    wanted = entry.get("type")
    if wanted is None or (isinstance(wanted, str) and (wanted in TYPES or wanted in DIMENSIONS)):
        return wanted or ""
    place = Place(entry.value_spans["type"], entry.via)
    if not isinstance(wanted, str):
        scope.report("wrong-type", f'argument "{name}" type is text, not {kind_of(wanted)}', place, "such as length")
        return ""
    help = word_meant(wanted, [*TYPES, *DIMENSIONS], "arg type")
    scope.report("wrong-value", f'argument "{name}" type cannot be "{wanted}"', place, help)
    return ""


def _check(scope: Scope, parameter: Parameter, place: Place, owner: str) -> None:
    """Hold the value of a parameter against its type and its allowed values."""
    name, wanted = parameter.name, parameter.type
    try:
        value = scope.lookup(name)
        allowed = scope.resolve(parameter.one_of, place)
    except Failed:
        return
    if value is None and parameter.has_default:  # an optional argument, passed on as a key that is left out
        return
    near: list[Related] = []
    if wanted and not _fits(value, wanted):
        message = f'"{name}" of {owner} is {_article(wanted)}, not {_shown(value)}'
        help = parameter.help or _way_out(value, wanted)
    elif isinstance(allowed, list) and value not in allowed:
        told = f'"{value}"' if isinstance(value, (str, int, float)) else kind_of(value)
        message = f'{told} is not a value of the argument "{name}"'
        help = f"allowed: {', '.join(map(str, allowed))}" + (f"; {parameter.help}" if parameter.help else "")
        meant = nearest(value, [one for one in allowed if isinstance(one, str)]) if isinstance(value, str) else None
        if meant and isinstance(allowed, Seq):
            help = f'did you mean "{meant}"? ({help})'
            near = [Related("the suggestion is defined here", allowed.value_spans[allowed.index(meant)])]
    else:
        scope.values[name] = _of_type(value, wanted)
        if isinstance(allowed, list):
            scope.values[name + CHOICES] = allowed
        return
    scope.broken.add(name)
    scope.values.pop(name, None)
    misfit = not isinstance(allowed, list)
    scope.report("bad-argument", message, place, help, near, of_kinds=misfit)


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


def _of_type(value: Any, wanted: str) -> Any:
    """Return a value that fits a type: a bare number as the quantity in SI units that it is, a plain one as a float."""
    if wanted in DIMENSIONS and not isinstance(value, Quantity):
        return in_si(value, DIMENSIONS[wanted])
    return float(value) if wanted == "number" and isinstance(value, Quantity) else value


def _way_out(value: Any, wanted: str) -> str:
    """Return the way out for a value of another type than its parameter has."""
    if wanted == "boolean":
        return flag_meant(value) or "write true or false"
    if isinstance(value, str) and (wanted in DIMENSIONS or wanted in ("number", "integer")):
        return number_meant(value, _SI.get(wanted, ()))
    return ""


# A unit of each dimension that has one, for what a text may mean.
_SI = {"length": ["m"], "mass": ["kg"], "time": ["s"], "angle": ["rad"], "force": ["N"], "torque": ["N*m"]}
_SI |= {"inertia": ["kg*m^2"], "speed": ["m/s"], "angular_speed": ["rad/s"], "frequency": ["Hz"], "density": ["kg/m^3"]}


def _article(wanted: str) -> str:
    if wanted in ("text", "any"):
        return wanted
    return f"{'an' if wanted[0] in 'aeiou' else 'a'} {wanted.replace('_', ' ')}"


def _shown(value: Any) -> str:
    return f'the text "{value}"' if isinstance(value, str) else kind_of(value)

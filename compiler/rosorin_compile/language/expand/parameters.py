"""Parameters: the declared inputs of a description (``args``), a part and a sensor type (``params``), and their checks.

A parameter is a mapping with ``type``, ``default``, ``one_of``, ``min``, ``max`` and ``help``, all optional; anything
that is no mapping is its default.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Related, did_you_mean, error, nearest
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.units import DIMENSIONS, NUMBER, Quantity, in_si
from rosorin_compile.source.wording import quoted

from ..expression import CHOICES
from ..expression.functions import kind_of
from ..misnamed import text_meant_by, text_tails, word_meant
from ..suggestions import flag_meant, number_meant
from .expansion import Failed
from .scope import Scope, key_place, value_place

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
BOUNDS = ("min", "max")

TYPES: dict[str, tuple[type, ...]] = {
    "any": (object,),
    "text": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
    "list": (list,),
    "table": (dict,),
}
# A unit of each dimension that has one, to suggest what a text may mean.
_SI = {"length": ["m"], "mass": ["kg"], "time": ["s"], "angle": ["rad"], "force": ["N"], "torque": ["N*m"]}
_SI |= {"inertia": ["kg*m^2"], "speed": ["m/s"], "angular_speed": ["rad/s"], "frequency": ["Hz"], "density": ["kg/m^3"]}


class Parameter(NamedTuple):
    """A declared parameter; ``place`` is that of its default, or of its name. ``has_default``, ``sound``: no errors."""

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
        """Return True if a value is of the requested kind: that of the type, or of the default.

        False for a list or a table: no kind is requested for what is in it.
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
    user: Place | None = None,
) -> None:
    """Bind every declared parameter in a scope: to the given value, else to its default, evaluated in that scope.

    ``places`` has the place of each given value; ``owner`` names what has the parameters, and ``way`` how an argument
    is given to it, for messages; ``user`` is the place that should give the arguments, by default the declaration.
    Values of the wrong type, unknown names and missing values are reported; a name without a value stays broken, so
    that nothing that uses it is reported too.
    """
    known = scope.declared = _parameters(scope, declared)
    suggested: set[str | None] = set()
    for name in given:
        if name not in known:
            close = nearest(name, known)
            suggested.add(close)
            near = [Related("the suggestion is defined here", known[close].place.span)] if close else []
            help = did_you_mean(name, known) or "it has none"
            scope.report("unknown-argument", f'{owner} has no argument "{name}"', places[name], help, near)
    missing = [one for name, one in known.items() if name not in given and not one.has_default]
    scope.broken.update(one.name for one in missing)
    # The default, or the argument, may be there under a misspelt key, which is reported.
    missing = [one for one in missing if one.sound and one.name not in suggested]
    for together in [missing] if user and missing else [[one] for one in missing]:
        _report_missing(scope, together, owner, way, user)
    for name, parameter in known.items():
        if name in given:
            scope.bind(name, given[name], places[name])
        elif not parameter.has_default:
            continue
        elif scope.expansion.is_constant(parameter.default):
            scope.bind(name, parameter.default, parameter.place)
            scope.local[name] = parameter.place
        else:
            scope.define(name, parameter.default, parameter.place)
        _check(scope, parameter, places.get(name, parameter.place), owner)


def given_places(given: Map, declared: Any) -> dict[str, Place]:
    """Return the place of each argument of a ``with``: its value, or its key if there is no such argument."""
    known = declared if isinstance(declared, Map) else ()
    return {key: value_place(given, key) if key in known else key_place(given, key) for key in given}


def _report_missing(scope: Scope, missing: list[Parameter], owner: str, way: str, user: Place | None) -> None:
    names = [parameter.name for parameter in missing]
    if len(missing) == 1:
        explained = f"; {missing[0].help}" if missing[0].help else ""
        what, help = f'argument "{names[0]}"', f"give it: {way.format(names[0])}{explained}"
    else:
        what, help = f"arguments {quoted(names)}", f"give them: {way.format(': VALUE, '.join(names))}"
    place = user or missing[0].place
    stack = [note for note in (scope.via.stack() if scope.via else place.stack()) if note.span != place.span]
    related = [Related("declared here", missing[0].place.span)] if user else []
    message = f"{owner} needs the {what}"
    scope.expansion.diagnostics.append(error("missing-argument", message, place.span, help, [*related, *stack]))


def _parameters(scope: Scope, declared: Any) -> dict[str, Parameter]:
    """Return the declared parameters by name, read once for each declaration."""
    if not isinstance(declared, Map) or not declared:
        return {}
    known: dict[str, Parameter] | None = scope.expansion.parameters.get(id(declared))
    if known is None:
        known = {name: _parameter(scope, name, entry, declared) for name, entry in declared.items()}
        scope.expansion.parameters[id(declared)] = known
    return known


def _parameter(scope: Scope, name: str, entry: Any, declared: Map) -> Parameter:
    place = key_place(declared, name)
    if entry is None:
        return Parameter(name, place)
    if not isinstance(entry, Map):
        return Parameter(name, value_place(declared, name), has_default=True, default=entry)
    unknown = [key for key in entry if key not in (*KEYS, *BOUNDS)]
    tails = text_tails(entry, unknown) if unknown else ()
    for key in (key for key in unknown if key not in tails):
        help = text_meant_by(key, entry) or word_meant(key, KEYS, "arg")
        scope.report("unknown-key", f'argument "{name}" has no key "{key}"', key_place(entry, key), help)
    wanted = entry.get("type")
    if wanted is not None and not isinstance(wanted, str):
        message = f'argument "{name}" type is text, not {kind_of(wanted)}'
        scope.report("wrong-type", message, value_place(entry, "type"), "such as length")
        wanted = None
    elif wanted is not None and wanted not in TYPES and wanted not in DIMENSIONS:
        help = word_meant(wanted, [*TYPES, *DIMENSIONS], "arg type")
        scope.report("wrong-value", f'argument "{name}" type cannot be "{wanted}"', value_place(entry, "type"), help)
        wanted = None
    for bound in BOUNDS:
        if entry.get(bound) is not None and not _is_number(entry[bound]):
            message = f'argument "{name}" {bound} is a number, not {kind_of(entry[bound])}'
            raise scope.failed("wrong-type", message, value_place(entry, bound))
    return Parameter(
        name,
        value_place(entry, "default") if "default" in entry else place,
        wanted or "",
        "default" in entry,
        entry.get("default"),
        entry.get("one_of"),
        entry.get("min"),
        entry.get("max"),
        str(entry.get("help") or ""),
        not unknown,
    )


def _check(scope: Scope, parameter: Parameter, place: Place, owner: str) -> None:
    """Check the value of a parameter: its type, its allowed values, its bounds."""
    name, wanted, low, high = parameter.name, parameter.type, parameter.low, parameter.high
    if not wanted and parameter.one_of is None and low is None and high is None:
        return
    try:
        value = scope.lookup(name)
        allowed = scope.resolve(parameter.one_of, place)
    except Failed:
        return
    if value is None and parameter.has_default:  # an optional argument, passed on as a key that is left out
        return
    near: list[Related] = []
    limited = isinstance(allowed, list)
    explained = f"; {parameter.help}" if parameter.help else ""
    if wanted and not _fits(value, wanted):
        shown = f'the text "{value}"' if isinstance(value, str) else kind_of(value)
        message = f'"{name}" of {owner} is {_article(wanted)}, not {shown}'
        help = parameter.help or _suggestion(value, wanted)
    elif limited and value not in allowed:
        shown = f'"{value}"' if isinstance(value, (str, int, float)) else kind_of(value)
        message = f'{shown} is not a value of the argument "{name}"'
        help = f"allowed: {', '.join(map(str, allowed))}{explained}"
        meant = nearest(value, [one for one in allowed if isinstance(one, str)]) if isinstance(value, str) else None
        if meant and isinstance(allowed, Seq):
            help = f'did you mean "{meant}"? ({help})'
            near = [Related("the suggestion is defined here", allowed.value_spans[allowed.index(meant)])]
    elif _is_number(value) and not ((low is None or value >= low) and (high is None or value <= high)):
        range_ = f"from {_shown(low)} to {_shown(high)}" if low is not None and high is not None else ""
        range_ = range_ or (f"at least {_shown(low)}" if high is None else f"at most {_shown(high)}")
        message, help = f'"{name}" of {owner} is {range_}, not {_shown(value)}', parameter.help
    else:
        scope.values[name] = _of_type(value, wanted)
        if limited:
            scope.values[name + CHOICES] = allowed
        return
    scope.broken.add(name)
    scope.values.pop(name, None)
    scope.report("bad-argument", message, place, help, near, of_kinds=not limited)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _fits(value: Any, wanted: str) -> bool:
    if wanted in TYPES:
        if isinstance(value, bool) and wanted in ("integer", "number"):
            return False
        if isinstance(value, Quantity) and wanted == "number":
            return value.dimension == NUMBER
        return isinstance(value, TYPES[wanted])
    return _is_number(value) and (not isinstance(value, Quantity) or value.dimension == DIMENSIONS.get(wanted))


def _of_type(value: Any, wanted: str) -> Any:
    """Return a value of a type: a bare number as a quantity in SI units, a plain one as a float."""
    if wanted in DIMENSIONS and not isinstance(value, Quantity):
        return in_si(value, DIMENSIONS[wanted])
    return float(value) if wanted == "number" and isinstance(value, Quantity) else value


def _suggestion(value: Any, wanted: str) -> str:
    """Return what to write for a value of another type than its parameter has."""
    if wanted == "boolean":
        return flag_meant(value) or "write true or false"
    if isinstance(value, str) and (wanted in DIMENSIONS or wanted in ("number", "integer")):
        return number_meant(value, _SI.get(wanted, ()))
    return ""


def _article(wanted: str) -> str:
    if wanted in ("text", "any"):
        return wanted
    return f"{'an' if wanted[0] in 'aeiou' else 'a'} {wanted.replace('_', ' ')}"


def _shown(value: Any) -> str:
    """Return a number as it was written."""
    return getattr(value, "text", "") or f"{value:g}"

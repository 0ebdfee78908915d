"""Sensor types: what a sensor of a kind brings along, such as its optical frame and its elements in a simulation.

A type is a mapping under ``sensor_types``, in a description or in the library: ``params`` that a sensor may set in
``with``, ``let``, and the keys that every sensor of this type gets unless it says otherwise. Its expressions know the
``name`` of the sensor, its ``frame`` and its ``parent``. A parameter of a type may have bounds, ``min`` and ``max``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosorin_compile.source.load import LoadError, load_own
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Instance, Map, Place, Seq

from ..schema import of_types
from ..suggestions import word_meant
from .forms import KEPT, check_sensor_type
from .ledger import Failed
from .parameters import declare
from .scope import Scope

RULES = (
    Rule(
        "unknown-sensor-type",
        "A sensor is of a type that neither `sensor_types` nor [the library](parts-library.md) has.",
        "Correct it, or add the type.",
        ARGUMENTS,
    ),
)


class ChangedSensor(Seq):
    """The Gazebo sensor of a type with the changes of one sensor; ``brought`` is the entry of the type.

    The elements that the type has for MuJoCo move by the same amount as the Gazebo sensor. ``brought`` is None where
    the sensor has MuJoCo elements of its own.
    """

    __slots__ = ("brought",)
    brought: Map | None


def apply_types(tree: Map, own: Any, scope: Scope, library: Path) -> None:
    """Give every sensor of a tree what its type brings.

    ``own`` are the types of the description; they go before those of the library file. A sensor of which something is
    wrong is reported and stays as it was written.
    """
    sensors = tree.get("sensors")
    if not isinstance(sensors, Map) or not sensors:
        return
    types = own if isinstance(own, Map) else {}
    shared: Map | None = None
    for name in list(sensors):
        sensor = sensors[name]
        kind = sensor.get("type") if isinstance(sensor, Map) else None
        if not isinstance(kind, str):
            continue
        home = scope
        definition = types.get(kind)
        if definition is None:
            shared = shared if shared is not None else _library(library)
            definition, home = shared.get(kind), Scope(scope.ledger)
        place = Place(sensor.value_spans["type"], sensor.via)
        if not isinstance(definition, Map):
            help = word_meant(kind, [*types, *(shared or {})], "sensor type")
            scope.report("unknown-sensor-type", f'sensor "{name}": unknown sensor type "{kind}"', place, help)
            continue
        try:
            full = _full(name, kind, sensor, definition, Scope(scope.ledger, home, _via(kind, name, sensor)))
        except Failed:
            continue
        sensors.put(name, full, sensors.key_spans[name], sensors.value_spans[name])


def _via(kind: str, name: str, sensor: Map) -> Instance:
    span = sensor.value_spans["type"]
    return Instance(f'sensor type "{kind}" of "{name}" used here', span, sensor.via, made=True)


def _library(path: Path) -> Map:
    try:
        types = load_own(path, f"parts/{path.name}").get("sensor_types")
    except LoadError as problem:
        raise RuntimeError(f"the library of sensor types is damaged: {problem}") from problem
    assert isinstance(types, Map)  # noqa: S101 - ships with the tool
    return types


def _full(name: str, kind: str, sensor: Map, definition: Map, scope: Scope) -> Map:
    """Return a sensor with what its type brings. Raises Failed after reporting."""
    check_sensor_type(kind, definition, scope)
    before = len(scope.ledger.diagnostics)
    place = Place(sensor.span, sensor.via)
    scope.bind("name", name, place)
    on = "parent" if "parent" in sensor else "frame"  # without a parent it sits on the link that is its frame
    for key, said in (("frame", "frame"), ("parent", on)):
        if sensor.get(said) is None:
            scope.broken.add(key)  # validate says that it is missing
        else:
            scope.bind(key, sensor[said], place)
    _bind(kind, sensor, definition, scope)
    scope.define_all(definition.get("let"))
    if len(scope.ledger.diagnostics) > before:
        raise Failed
    made = Map(sensor.span, sensor.via)
    for key, value in sensor.items():
        if key != "with":
            made.put(key, value, sensor.key_spans[key], sensor.value_spans[key])
    changed = sensor["gazebo"] if isinstance(sensor.get("gazebo"), Map) else None
    for key in of_types():
        if key in definition and (key not in sensor or (key == "gazebo" and changed is not None)):
            brought = scope.resolve(definition[key], Place(definition.value_spans[key], scope.via), key == KEPT)
            if key == "gazebo" and changed is not None:
                made[key] = _changed(brought, changed, kind, sensor, scope)
            elif brought is not None:
                made.put(key, _brought(brought, scope.via), definition.key_spans[key], definition.value_spans[key])
    if changed is not None and "gazebo" not in definition:
        _changed(None, changed, kind, sensor, scope)
    return made


def _changed(brought: Any, changed: Map, kind: str, sensor: Map, scope: Scope) -> Seq:
    """Return the one sensor of Gazebo that a type brings, with what a sensor says of it. Raises Failed."""
    only = brought[0] if isinstance(brought, Seq) and len(brought) == 1 else None
    if not isinstance(only, Map):
        count = len(brought) if isinstance(brought, Seq) else 0
        brings = f"{count} sensors" if count else "no sensor"
        message = f'sensor type "{kind}" brings {brings} of Gazebo: a mapping changes the one there is'
        place = Place(sensor.key_spans["gazebo"], sensor.via)
        scope.report("ignored-key", message, place, "write a list: gazebo: [{sensor: TYPE, elements: {...}}]")
        raise Failed
    made = ChangedSensor(changed.span, changed.via)
    made.brought = None if "mjcf" in sensor else only
    made.put(merged(only, changed), changed.span)
    return made


def merged(one: Map, other: Map) -> Map:
    """Return a mapping with the values of another one put over its own, mappings within joined in the same way."""
    made = Map(other.span, other.via)
    for key, value in one.items():
        made.put(key, value, one.key_spans[key], one.value_spans[key])
    for key, value in other.items():
        before = made.get(key)
        both = merged(before, value) if isinstance(before, Map) and isinstance(value, Map) else value
        made.put(key, both, other.key_spans[key], other.value_spans[key])
    return made


def _brought(value: Any, via: Instance | None) -> Any:
    """Return a value of a type as one that came by the use of it, so that messages on it name the sensor."""
    if isinstance(value, Map):
        made = Map(value.span, via)
        for key, item in value.items():
            made.put(key, item, value.key_spans[key], value.value_spans[key])
        return made
    if isinstance(value, Seq):
        listed = Seq(value.span, via)
        for item, span in zip(value, value.value_spans, strict=True):
            listed.put(item, span)
        return listed
    return value


def _bind(kind: str, sensor: Map, definition: Map, scope: Scope) -> None:
    """Bind the parameters of a type to what the sensor gives in ``with``, within their bounds."""
    given = sensor.get("with")
    if given is None:
        given = Map(sensor.span, sensor.via)
    if not isinstance(given, Map):
        raise Failed  # validate says what it is instead
    declared, asked = definition.get("params"), Place(sensor.value_spans["type"], sensor.via)
    known = declared if isinstance(declared, Map) else Map(sensor.span)
    places = {key: Place((given.value_spans if key in known else given.key_spans)[key], given.via) for key in given}
    declare(scope, declared, given, places, f'sensor type "{kind}"', "with: {{{}: VALUE}}", asked)
    for name, parameter in known.items():
        if isinstance(parameter, Map) and ("min" in parameter or "max" in parameter):
            _check_bounds(scope, kind, name, parameter, places.get(name, asked))


def _check_bounds(scope: Scope, kind: str, name: str, parameter: Map, place: Place) -> None:
    """Report a number that is below ``min`` or above ``max`` of its parameter."""
    try:
        value = scope.lookup(name)
    except Failed:
        return
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return
    low, high = parameter.get("min"), parameter.get("max")
    if (low is None or value >= low) and (high is None or value <= high):
        return
    wanted = f"at least {_said(low)}" if high is None else f"at most {_said(high)}"
    if low is not None and high is not None:
        wanted = f"from {_said(low)} to {_said(high)}"
    scope.report(
        "bad-argument",
        f'"{name}" of sensor type "{kind}" is {wanted}, not {_said(value)}',
        place,
        str(parameter.get("help") or ""),
    )


def _said(value: Any) -> str:
    """Return a number as it was written."""
    return getattr(value, "text", "") or f"{value:g}"

"""Sensor types: what a sensor of a kind brings along, such as its optical frame and its elements in a simulation.

A type is a mapping under ``sensor_types``, in a description or in the library: ``params`` that a sensor may set in
``with``, ``let``, and the keys that every sensor of this type gets unless it says otherwise.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..diagnostic import did_you_mean
from ..load import LoadError, load_mapping
from ..tree import Instance, Map, Place
from .parameters import declare
from .scope import Failed, Scope

_TYPE_KEYS = ("help", "params", "let", "optical", "mjcf", "publisher", "source")
_BROUGHT = ("optical", "mjcf", "publisher", "source")


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
            help = did_you_mean(kind, [*types, *(shared or {})])
            scope.report("unknown-sensor-type", f'sensor "{name}" is of no known type: "{kind}"', place, help)
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
        found = load_mapping(path, path.name).get("sensor_types")
    except LoadError as problem:
        raise RuntimeError(f"the library of sensor types is damaged: {problem}") from problem
    assert isinstance(found, Map)  # noqa: S101 - ships with the tool
    return found


def _full(name: str, kind: str, sensor: Map, definition: Map, scope: Scope) -> Map:
    """Return a sensor with what its type brings. Raises Failed after reporting."""
    for key in definition:
        if key not in _TYPE_KEYS:
            place = Place(definition.key_spans[key], definition.via)
            scope.report(
                "unknown-key", f'sensor type "{kind}" has no key "{key}"', place, did_you_mean(key, _TYPE_KEYS)
            )
            raise Failed
    before = len(scope.ledger.diagnostics)
    place = Place(sensor.span, sensor.via)
    scope.bind("name", name, place)
    scope.bind("frame", sensor.get("frame"), place)
    given = sensor.get("with") or {}
    if isinstance(given, Map):
        places = {key: Place(given.value_spans[key], given.via) for key in given}
        declare(scope, definition.get("params"), given, places, f'sensor type "{kind}"', "with: {{{}: VALUE}}")
    scope.define_all(definition.get("let"))
    if len(scope.ledger.diagnostics) > before:
        raise Failed
    made = Map(sensor.span, sensor.via)
    for key, value in sensor.items():
        if key != "with":
            made.put(key, value, sensor.key_spans[key], sensor.value_spans[key])
    for key in _BROUGHT:
        if key in definition and key not in sensor:
            brought = scope.resolve(definition[key], Place(definition.value_spans[key], scope.via))
            if brought is not None:
                made.put(key, brought, definition.key_spans[key], definition.value_spans[key])
    return made

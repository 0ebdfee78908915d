"""Sensor types: what every sensor of a type has, such as its optical frame and its elements in a simulation.

A type is a mapping under ``sensor_types``, in a description or in the library: ``params`` that a sensor may set in
``with``, ``let``, and the keys that every sensor of this type gets unless it has its own. Its expressions may use the
``name`` of the sensor, its ``frame`` and its ``parent``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosorin_compile.source.load import load_own
from rosorin_compile.source.rule_registry import ARGUMENTS, Rule
from rosorin_compile.source.tree import Instance, Map, Place, Seq

from ..schema import keys_of_xml, of_types
from ..suggestions import word_meant
from .declarations import check_sensor_type, declare, given_places
from .expansion import Failed
from .joining import copy
from .scope import Scope

RULES = (
    Rule("unknown-sensor-type", "There is no such sensor type.", "See [the library](parts-library.md).", ARGUMENTS),
)


class ChangedSensor(Seq):
    """The Gazebo sensor of a type with the changes of one sensor; ``brought`` is the Gazebo sensor of the type.

    The elements that the type has for MuJoCo move by the same amount as the Gazebo sensor. ``brought`` is None if the
    sensor has MuJoCo elements of its own.
    """

    __slots__ = ("brought",)
    brought: Map | None


def apply_types(tree: Map, own: Any, scope: Scope, library: Path) -> None:
    """Add the values of its type to every sensor of a tree."""
    sensors: Any = tree.get("sensors")
    types = own if isinstance(own, Map) else {}
    shared: Any = None
    for name, sensor in list(sensors.items()) if isinstance(sensors, Map) else ():
        kind = sensor.get("type") if isinstance(sensor, Map) else None
        if not isinstance(kind, str):
            continue
        home, definition = scope, types.get(kind)
        if definition is None:
            shared = shared or load_own(library, f"parts/{library.name}")["sensor_types"]
            home, definition = Scope(scope.expansion), shared.get(kind)
        span = sensor.value_spans["type"]
        if not isinstance(definition, Map):
            help = word_meant(kind, [*types, *(shared or {})], "sensor type")
            message = f'sensor "{name}": unknown sensor type "{kind}"'
            scope.report("unknown-sensor-type", message, Place(span, sensor.via), help)
            continue
        via = Instance(f'sensor type "{kind}" of "{name}" used here', span, sensor.via, made=True)
        try:
            full = _with_type(name, kind, sensor, definition, Scope(scope.expansion, home, via))
        except Failed:
            continue
        sensors.put(name, full, sensors.key_spans[name], sensors.value_spans[name])


def _with_type(name: str, kind: str, sensor: Map, definition: Map, scope: Scope) -> Map:
    check_sensor_type(kind, definition, scope)
    before = len(scope.expansion.diagnostics)
    place = Place(sensor.span, sensor.via)
    scope.bind("name", name, place)
    on = "parent" if "parent" in sensor else "frame"  # without a parent it is on the link that is its frame
    for key, source in (("frame", "frame"), ("parent", on)):
        if sensor.get(source) is None:
            scope.broken.add(key)  # validation reports that it is missing
        else:
            scope.bind(key, sensor[source], place)
    given = sensor.get("with")
    given = Map(sensor.span, sensor.via) if given is None else given
    if not isinstance(given, Map):
        raise Failed  # validation reports it
    params, user = definition.get("params"), Place(sensor.value_spans["type"], sensor.via)
    declare(scope, params, given, given_places(given, params), f'sensor type "{kind}"', user)
    scope.define_all(definition.get("let"))
    if len(scope.expansion.diagnostics) > before:
        raise Failed
    made = Map(sensor.span, sensor.via)
    for key, value in sensor.items():
        if key != "with":
            made.put(key, value, sensor.key_spans[key], sensor.value_spans[key])
    changes = sensor["gazebo"] if isinstance(sensor.get("gazebo"), Map) else None
    for key in of_types():
        changed = key == "gazebo" and changes is not None
        if key not in definition or (key in sensor and not changed):
            continue
        value = scope.resolve(definition[key], Place(definition.value_spans[key], scope.via), key in keys_of_xml())
        if changed:
            made[key] = _changed(value, sensor, kind, scope)
        elif value is not None:
            value = copy(value)
            if isinstance(value, (Map, Seq)):
                value.via = scope.via  # so that messages name the sensor
            made.put(key, value, definition.key_spans[key], definition.value_spans[key])
    if changes is not None and "gazebo" not in definition:
        _changed(None, sensor, kind, scope)
    return made


def _changed(brought: Any, sensor: Map, kind: str, scope: Scope) -> Seq:
    """Return the Gazebo sensor of a type with the changes of a sensor. Raises Failed after reporting."""
    changes = sensor["gazebo"]
    only = brought[0] if isinstance(brought, Seq) and len(brought) == 1 else None
    if not isinstance(only, Map):
        count = len(brought) if isinstance(brought, Seq) else 0
        brings = f"{count} sensors" if count else "no sensor"
        message = f'sensor type "{kind}" brings {brings} of Gazebo: a mapping changes the one there is'
        place = Place(sensor.key_spans["gazebo"], sensor.via)
        raise scope.failed("ignored-key", message, place, "write a list: gazebo: [{sensor: TYPE, elements: {...}}]")
    made = ChangedSensor(changes.span, changes.via)
    made.brought = None if "mjcf" in sensor else only
    made.put(_merged(only, changes), changes.span)
    return made


def _merged(base: Map, changes: Map) -> Map:
    made = base.copied()
    made.span, made.via = changes.span, changes.via
    for key, value in changes.items():
        before = made.get(key)
        both = _merged(before, value) if isinstance(before, Map) and isinstance(value, Map) else value
        made.put(key, both, changes.key_spans[key], changes.value_spans[key])
    return made

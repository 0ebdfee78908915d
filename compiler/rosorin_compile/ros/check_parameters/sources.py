"""The sources of obstacles of costmaps and collision_monitor, and the scans that nodes read, against the sensors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, listed

from ..graph import Graph, source_message, topics_of_sensors
from ..ports import SCAN, full_topic, short_type
from .nodes import Node

_LISTING = "observation_sources"
_RANGES = ("obstacle_max_range", "raytrace_max_range")  # of costmaps, whose defaults are 2.5 and 3 m


def check(robot: Robot, nodes: Sequence[Node], made: Graph) -> Iterator[Diagnostic]:
    """Yield what keeps sources of obstacles from marking and clearing, and scans that no sensor has."""
    sensors = {full_topic(topic, "", ""): message for _, topic, message in topics_of_sensors(robot)}
    by_name = {node.full: node for node in nodes}
    for end in made.read:
        if end.port.role == SCAN:
            setting = by_name[end.node].setting(end.key)
            yield from _unseen(by_name[end.node], end.topic, end.type, sensors, setting.span)
    for node in nodes:
        plugins = node.parameters.get("plugins")
        loaded = plugins.value if plugins is not None and isinstance(plugins.value, list) else None
        for key, listing in node.parameters.items():
            layer, _, last = key.rpartition(".")
            is_used = last == _LISTING and node.kind is not None and not listing.substituted
            if is_used and (not layer or loaded is None or layer in loaded):
                names = listing.value.split() if isinstance(listing.value, str) else listing.value
                for name in names if isinstance(names, list) else ():
                    yield from _source(node, layer, str(name), listing.span, sensors)


def _source(node: Node, layer: str, name: str, place: Span, sensors: Mapping[str, str]) -> Iterator[Diagnostic]:
    before = f"{layer}.{name}." if layer else f"{name}."
    given = {key.removeprefix(before): one for key, one in node.parameters.items() if key.startswith(before)}
    if not given:
        message = f'{node.shown} lists the source "{name}", which has no parameters'
        help = f"{name}: {{topic: TOPIC, data_type: LaserScan, marking: true, clearing: true}}"
        yield report("parameters-source", message, place, help if layer else "")
    if not given or any(one.substituted for one in given.values()):
        return
    values = {key: one.value for key, one in given.items()}
    what = f'the source "{name}" of {node.shown}'
    place = given["topic"].span if "topic" in given else next(iter(given.values())).span
    if layer and values.get("marking", True) is True:
        yield from _clearing(what, values, place)
    topic, message = "/" + str(values.get("topic", name)).strip("/"), source_message(values)
    if values.get("type") in ("polygon", "costmap"):
        return
    if topic in sensors and sensors[topic] != message:
        text = f"{what} expects {short_type(message)} on {topic}, and the sensor publishes {short_type(sensors[topic])}"
        help = f"data_type: {short_type(sensors[topic])}" if layer else "choose the type of these messages"
        yield report("parameters-source", f"{text}: it sees nothing", place, help)
    elif topic not in sensors:
        yield from _unseen(node, topic, message, sensors, place)


def _clearing(what: str, values: Mapping[str, Any], place: Span) -> Iterator[Diagnostic]:
    if "clearing" not in values:
        message = f'{what} marks obstacles and never clears them: "clearing" is false by default'
        yield report("parameters-source", message, place, "clearing: true")
    marks, clears = (values.get(key, default) for key, default in zip(_RANGES, (2.5, 3.0), strict=True))
    if values.get("clearing") is True and isinstance(marks, float) and isinstance(clears, float) and clears < marks:
        message = f"{what} marks obstacles up to {marks:g} m and clears them up to {clears:g} m"
        yield report("parameters-source", message, place, f"raytrace_max_range: {marks + 0.5:g}")


def _unseen(node: Node, topic: str, message: str, sensors: Mapping[str, str], place: Span) -> Iterator[Diagnostic]:
    """Yield that no sensor publishes a topic, if the description has the topics of such sensors."""
    known = sorted(other for other, kind in sensors.items() if kind == message)
    if known and topic not in known:
        text = (
            f"{node.shown} reads {short_type(message)} on {topic}, and the sensors of the robot publish {listed(known)}"
        )
        yield report("parameters-source", text, place, f"topic: {known[0]}", severity=NOTE)

"""The topics of nodes in parameter files: remaps, topics between the nodes, and those of the sensors of a robot.

Remaps of the command line and of launch files say which topic a node really reads or publishes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Related, RequestError, Span, error, phrase

from ..graph import End, Graph, mismatched_qos, source_message, topics_of_sensors
from ..launch_files import LaunchError, nodes_of
from ..ports import IMU, ODOMETRY, SCAN, VELOCITY, controller_ports, full_topic, full_type, ports, short_type
from .nodes import Node

_ODOM = "odom"  # the usual topic
_OF_CONTROLLER = re.compile(r"_controller/odom(etry)?\Z")  # as controllers of a drive are called
_LISTING = "observation_sources"
# Nodes that run others in their process: their remaps apply to all of them.
_HOSTS = ("controller_manager", "ros2_control_node")
_FLAGS = ("-r", "--remap")


class Remap(NamedTuple):
    """One rule: names as they are written. ``node`` is the name of the node that it is for; empty for all."""

    node: str
    name: str
    to: str


def parse_remap(word: str) -> Remap:
    """Parse a remap such as NODE:FROM:=TO. Raises RequestError."""
    left, _, to = word.partition(":=")
    node, colon, name = left.rpartition(":")
    if not name or not to or (colon and not node):
        raise RequestError(f'"{word}" is not a remap: write NODE:FROM:=TO, as in controller:~/tf_odometry:=/tf')
    return Remap(node.strip("/").rsplit("/", 1)[-1], name, to)


def remapped_topics(node: Node, remaps: Iterable[Remap]) -> dict[str, str]:
    """Return the new topics of a node by the old ones, in full; the first remap of one is followed."""
    space, name = node.namespace, node.name
    mine = [one for one in remaps if one.node in ("", name)]
    return {full_topic(one.name, space, name): full_topic(one.to, space, name) for one in reversed(mine)}


def launch_remaps(path: Path) -> tuple[list[Remap], list[Diagnostic]]:
    """Return the remaps of a launch file, and diagnostics about those that only a run of it knows."""
    from rosorin_compile.source.load import LoadError, read_utf8

    remaps: list[Remap] = []
    diagnostics: list[Diagnostic] = []
    try:
        for node in nodes_of(read_utf8(path, str(path))):
            name = "" if node.name in _HOSTS else node.name
            if node.remaps is None:
                diagnostics.append(_unknown("which remaps this node has is", "them", node.span))
            for remap in node.remaps or ():
                if "$(" in remap.name + remap.to:
                    diagnostics.append(_unknown("which topic is remapped is", "it", remap.span))
                else:
                    remaps.append(Remap(name, remap.name, remap.to))
            remaps += _of_arguments([word or "" for word in node.arguments or ()], name)
    except LoadError as problem:
        return [], [problem.diagnostic]
    except LaunchError as problem:
        return [], [error("parameters-launch", f"{path} is no launch file: {problem}", None, "name a launch file")]
    return remaps, diagnostics


def _unknown(what: str, these: str, span: Span) -> Diagnostic:
    message, help = f"{what} known only when the launch file runs", f"say {these}: --remap NODE:FROM:=TO"
    return Diagnostic("parameters-launch", WARNING, message, span, help=help)


def _of_arguments(words: Sequence[str], node: str) -> Iterator[Remap]:
    for flag, word in pairwise(words):
        if flag in _FLAGS:
            with suppress(RequestError):  # which the node refuses, too
                remap = parse_remap(word)
                yield remap if remap.node else remap._replace(node=node)
        elif flag == "--controller-ros-args":
            spawned = next((one for one in words if not one.startswith("-")), "")
            yield from _of_arguments(word.split(), spawned)


def check(robot: Robot, nodes: Sequence[Node], remaps: Sequence[Remap], distribution: str) -> Iterator[Diagnostic]:
    """Yield topics without a publisher, of two types or qualities, and sources of obstacles that do not work."""
    made = _graph(nodes, remaps, distribution)
    sensors = {full_topic(topic, "", ""): message for _, topic, message in topics_of_sensors(robot)}
    by_name = {node.full: node for node in nodes}
    for end in made.read:
        node = by_name[end.node]
        if end.port.role == SCAN:
            yield from _unseen(node, end.topic, end.type, sensors, node.setting(end.key).span)
        yield from _unheard(node, end, made, by_name, bool(distribution))
    for node in nodes:
        plugins = node.setting("plugins").value
        for key, listing in node.parameters.items():
            layer, _, last = key.rpartition(".")
            is_used = not layer or not isinstance(plugins, list) or layer in plugins
            if last == _LISTING and is_used and node.kind is not None and not listing.substituted:
                names = listing.value.split() if isinstance(listing.value, str) else listing.value
                for name in names if isinstance(names, list) else ():
                    yield from _source(node, layer, str(name), listing.span, sensors)


def _graph(nodes: Sequence[Node], remaps: Sequence[Remap], distribution: str) -> Graph:
    """Return the topics of all nodes that are in the table of ports, but for those that a launch file names."""
    made = Graph()
    for node in nodes:
        values = node.values
        known = controller_ports(full_type(node.type), distribution) if node.type else ()
        if node.kind is not None and not node.type:
            known = tuple(ports(distribution, node=node.kind.name))
        those = [one for one in known if not one.each and node.setting(one.parameter).value != ""]
        those = [one for one in those if one.parameter in values or one.parameter not in node.parameters]
        made.add(node.full, those, values, node.namespace, remapped_topics(node, remaps).items())
    return made


def _unheard(node: Node, end: End, made: Graph, by_name: Mapping[str, Node], is_decided: bool) -> Iterator[Diagnostic]:
    """Yield that no node publishes what a node reads, if a controller publishes a similar topic, or another type."""
    there, role = made.publishers(end), end.port.role
    sources = [one for one in made.published if one.port.role == role and one.port.group == "control"]
    fitting = [one for one in there if one.type == end.type]
    if mismatch := mismatched_qos(end, fitting):
        help = f"qos_overrides.{end.topic}.publisher.reliability: reliable"
        yield report("parameters-topic", mismatch, node.span, help)
    if fitting:
        return
    if there and is_decided and role == VELOCITY:
        message = f"{node.shown} takes {short_type(end.type)} on {end.topic}, and {there[0].node.strip('/')} sends "
        message += f"{short_type(there[0].type)}: {end.port.missing}"
        yield report("parameters-topic", message, node.span, "give both the same value of enable_stamped_cmd_vel")
    elif role in (ODOMETRY, IMU) and sources:
        yield from _unpublished(node, end, {by_name[one.node]: one.topic for one in sources})


def _unpublished(node: Node, end: End, sources: Mapping[Node, str]) -> Iterator[Diagnostic]:
    """Yield that a controller publishes an odometry or an IMU on another topic than the one that a node reads."""
    heard, setting, is_imu = end.topic, node.setting(end.key), end.port.role == IMU
    meant = next((one for one in sources if one.full == heard.rpartition("/")[0] and sources[one] != heard), None)
    of_drive = heard in (full_topic(_ODOM, node.namespace, ""), f"/{_ODOM}") or _OF_CONTROLLER.search(heard)
    if meant is None and not of_drive and not is_imu:
        return  # of somebody else, such as a camera
    source = meant or next(iter(sources))
    message = f'{node.shown} listens to the {"IMU" if is_imu else "odometry"} {heard} ("{end.key}"{setting.how}), and '
    message += f"no node in the files publishes that: {source.shown} publishes {sources[source]}"
    help = f"{end.key}: {sources[source].strip('/')}" + ("" if meant else "; or say the remap: --remap NODE:FROM:=TO")
    related = (Related(f"{source.shown} is here", source.span),)
    rule = "parameters-topic" if is_imu else "parameters-odometry"
    yield report(rule, message, setting.span, help, related, WARNING if meant else NOTE)


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
    marks, clears = values.get("obstacle_max_range", 2.5), values.get("raytrace_max_range", 3.0)
    if values.get("clearing") is True and isinstance(marks, float) and isinstance(clears, float) and clears < marks:
        message = f"{what} marks obstacles up to {marks:g} m and clears them up to {clears:g} m"
        yield report("parameters-source", message, place, f"raytrace_max_range: {marks + 0.5:g}")


def _unseen(node: Node, topic: str, message: str, sensors: Mapping[str, str], place: Span) -> Iterator[Diagnostic]:
    """Yield that no sensor publishes a topic, if the description has the topics of such sensors."""
    known = sorted(other for other, kind in sensors.items() if kind == message)
    if known and topic not in known:
        text = (
            f"{node.shown} reads {short_type(message)} on {topic}, and the sensors of the robot publish {phrase(known)}"
        )
        yield report("parameters-source", text, place, f"topic: {known[0]}", severity=NOTE)

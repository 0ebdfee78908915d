"""Check ROS parameter files, with remaps from launch files and the command line, against a robot."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from rosorin_compile.model import Controller, Robot
from rosorin_compile.model.joint import NODE
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case, report
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, RequestError, Source, Span
from rosorin_compile.source.files import is_file
from rosorin_compile.source.load import LoadError, read_utf8
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.project import no_file
from rosorin_compile.source.wording import count_of, phrase, quote

from ..controllers import against_robot, missing_parameters, of_type
from ..controllers.write import derive
from ..graph import End, Graph, mismatched_qos, source_message, topics_of_sensors
from ..launch_files import LaunchError, Remap, nodes_of
from ..node_kinds import MANAGER
from ..parameter_files import PARAMETERS, NoParameters, Section, read_sections
from ..ports import Role, controller_ports, full_topic, full_type, ports, short_type
from .nodes import Node, check_edges, check_frames, check_node, claims, nodes_in_files, remapped_topics

# Top-level keys of MoveIt configuration files, which look like ROS parameter files but are not.
_MOVEIT = re.compile(
    r"\b(cartesian_limits|joint_limits|kinematics_solver|moveit_controller_manager|moveit_simple_controller_manager"
    r"|octomap_frame|planner_configs|planning_plugins?|sensor_plugin|trajectory_execution)\s*:"
)
_ODOM = "odom"  # default odometry topic of Nav2 nodes
_OF_CONTROLLER = re.compile(r"_controller/odom(etry)?\Z")  # matches the default odometry topics of drive controllers


@dataclass(frozen=True)
class CheckedParameters:
    """The result of ``check_parameters``; ``robot`` is "" if the description has errors.

    ``judged`` is the number of transforms in the section ``edges`` that were checked. ``absent`` are entries of the
    section ``publishers`` that no file configures, ``unknown`` are entries whose kind of node is unknown.
    """

    robot: str = ""
    judged: int = 0
    absent: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def check_parameters(
    robot: FilePath | Request,
    files: Sequence[FilePath],
    arguments: Values = None,
    packages: Packages = None,
    *,
    controllers: Sequence[FilePath] = (),
    launch: Sequence[FilePath] = (),
    remaps: Sequence[str] = (),
    namespace: str = "",
    distribution: str | None = None,
    trust: bool = False,
) -> CheckedParameters:
    """Check the frames, transforms, controllers and topics in ROS parameter files against a robot.

    Args:
        files: Parameter files of ROS nodes.
        controllers: Parameter files of a controller_manager and its controllers.
        launch: Launch files whose remaps apply to the nodes. Launch files are parsed, but not run.
        remaps: Additional remaps, as ``"NODE:FROM:=TO"``.
        namespace: The namespace in which the nodes are started.
        distribution: The ROS 2 distribution; by default that of the robot's outputs, if it is the same for all.

    Raises:
        RequestError: A file does not exist, or a remap is invalid.
    """
    paths, managers, launches = ([Path(file) for file in some] for some in (files, controllers, launch))
    if unread := [path for path in (*paths, *managers, *launches) if not is_file(path)]:
        raise RequestError(no_file(unread[0]))
    moved = [_parse_remap(word) for word in remaps]
    understood = Request.from_arguments(robot, arguments, packages, trust=trust).understand()
    if (case := understood.case) is None:
        return CheckedParameters(diagnostics=tuple(one for one in understood.diagnostics if one.severity == ERROR))
    if not distribution:
        every = {str(one.options["distribution"]) for one in case.robot.outputs if "distribution" in one.options}
        distribution = every.pop() if len(every) == 1 else ""
    found: list[Diagnostic] = []
    sections = _read((*managers, *paths), found)
    for path in launches:
        moved += _launch_remaps(path, found)
    known, wrong = nodes_in_files(sections, namespace, distribution, case.robot.controllers)
    found += wrong
    if managers and not any(node.type for node in known) and all(one.severity != ERROR for one in found):
        help = f"{MANAGER}: {{ros__parameters: {{NAME: {{type: TYPE}}}}}}"
        spans = [section.span for of_file in sections for section in of_file]
        span = [*spans, Span(Source(str(managers[0]), ""), 1, 1)][0]
        found.append(report("controllers-none", "no controller has a type here", span, help))
    for node in known:
        found += _check_node(case, node, distribution, [one.name for one in known])
    owned = claims(known, moved)
    found += check_edges(case, owned)
    found += check_frames(case, known, owned)
    found += _check_topics(case.robot, known, moved, distribution)
    publishers = case.robot.publishers
    of_nodes = [edge.publisher for edge in case.robot.edges if edge.publisher.kind == NODE]
    judged = [one for one in of_nodes if any(node.kind and node.is_of(one, publishers) for node in known)]
    absent = dict.fromkeys(one.name for one in of_nodes if one not in judged)
    unknown = [node for node in known if node.kind is None]
    names = (node.display_name for node in unknown if any(node.is_of(one, publishers) for one in publishers))
    return CheckedParameters(case.robot.name, len(judged), tuple(absent), tuple(names), tuple(arrange(found)))


def _read(paths: Iterable[Path], diagnostics: list[Diagnostic]) -> list[list[Section]]:
    read: list[list[Section]] = []
    for path in paths:
        try:
            sections, wrong = read_sections(read_utf8(path, str(path)))
            read.append(sections)
            diagnostics += wrong
        except (LoadError, NoParameters) as problem:
            found = problem.diagnostic
            text = found.span.source.text if found.span is not None else ""
            if _MOVEIT.search(text) and PARAMETERS not in text:
                message = f"{path.name} is not checked: it has no parameters of a node, and launch files of MoveIt "
                found = Diagnostic("parameters-syntax", NOTE, f"{message}read it")
            diagnostics.append(found)
    return read


def _check_node(case: Case, node: Node, distribution: str, names: Sequence[str]) -> Iterator[Diagnostic]:
    wrong = of_type(node.display_name, node.type, distribution) if node.type else None
    yield from (one.place(node.type_span) for one in [wrong] if one)
    if wrong is not None and wrong.severity == "error":
        return  # with an unknown type, every parameter would be reported
    diagnostics = list(check_node(node))
    yield from diagnostics
    if not node.type:
        return
    if wrong is None and (needed := missing_parameters(node.kind, node.parameters)):
        message = f"{node.display_name} needs {quote(needed, most=4)}: it does not start"
        yield report("controller-missing", message, node.span, f"add {needed[0]}: VALUE")
    places = {one.span for one in diagnostics}
    values = {key: value for key, value in node.values.items() if node.parameters[key].span not in places}
    kind = full_type(node.type)
    known = derive(case.robot, Controller(node.name, kind, values), kind)
    moving = any(not joint.is_fixed for joint in case.robot.joints)
    for one in against_robot(node.display_name, kind, values, known, case.robot, "error", names):
        if one.rule == "controller-name" and not moving:
            continue  # the description has no moving joints to compare with
        if wrong is not None:  # in a controller of an unknown package, a key can have another meaning
            one = one._replace(severity=WARNING)
        drive = [case.related_place("the drive of the robot", ("drive",), key=True)]
        yield one.place(node.setting(one.key).span, drive if one.rule == "controller-differs" else [])


def _parse_remap(word: str) -> Remap:
    left, _, to = word.partition(":=")
    node, colon, name = left.rpartition(":")
    if not name or not to or (colon and not node):
        raise RequestError(f'"{word}" is not a remap: write NODE:FROM:=TO, as in controller:~/tf_odometry:=/tf')
    return Remap(name, to, node=node.strip("/").rsplit("/", 1)[-1])


def _launch_remaps(path: Path, diagnostics: list[Diagnostic]) -> list[Remap]:
    try:
        nodes = list(nodes_of(read_utf8(path, str(path))))
    except LoadError as problem:
        diagnostics.append(problem.diagnostic)
        return []
    except LaunchError as problem:
        diagnostics.append(report("parameters-launch", f"{path} is not a launch file: {problem}", None, "name one"))
        return []
    remaps: list[Remap] = []
    for node in nodes:
        name = "" if node.name in ("controller_manager", "ros2_control_node") else node.name
        unknown = [one for one in node.remaps or () if "$(" in one.name + one.to]
        spans = [(node.span, "which remaps this node has")] if node.remaps is None else []
        for span, what in [*spans, *((one.span, "which topic is remapped") for one in unknown)]:
            message, help = f"{what} is known only when the launch file runs", "pass it: --remap NODE:FROM:=TO"
            diagnostics.append(report("parameters-launch", message, span, help, severity=WARNING))
        remaps += [one._replace(node=name) for one in node.remaps or () if one not in unknown]
        remaps += _of_arguments([word or "" for word in node.arguments or ()], name)
    return remaps


def _of_arguments(words: Sequence[str], node: str) -> Iterator[Remap]:
    for flag, word in pairwise(words):
        if flag in ("-r", "--remap"):
            with suppress(RequestError):  # ROS also ignores an invalid remap
                remap = _parse_remap(word)
                yield remap._replace(node=remap.node or node)
        elif flag == "--controller-ros-args":
            yield from _of_arguments(word.split(), next((one for one in words if not one.startswith("-")), ""))


def _check_topics(robot: Robot, nodes: Sequence[Node], remaps: Sequence[Remap], distro: str) -> Iterator[Diagnostic]:
    graph, by_name = Graph(), {node.full: node for node in nodes}
    for node in nodes:  # skip topic names with launch substitutions: they are only known at launch
        values, of_kind = node.values, ports(distro, node=node.kind.name) if node.kind else ()
        known = controller_ports(full_type(node.type), distro) if node.type else of_kind
        those = [one for one in known if not one.each and node.setting(one.parameter).value != ""]
        those = [one for one in those if one.parameter in values or one.parameter not in node.parameters]
        graph.add(node.full, those, values, node.namespace, remapped_topics(node, remaps).items())
    described = {full_topic(topic, "", ""): (sensor, message) for sensor, topic, message in topics_of_sensors(robot)}
    sensors = {topic: message for topic, (_, message) in described.items()}
    lidars = {topic: sensor.frame for topic, (sensor, _) in described.items() if sensor.type == "lidar_2d"}
    planes = {topic: frame for topic, frame in lidars.items() if robot.is_tree and frame in robot.link}
    heights = {topic: robot.transform(robot.root, frame).xyz[2] for topic, frame in planes.items()}
    for end in graph.read:
        node = by_name[end.node]
        if end.port.role == Role.SCAN:
            yield from _unseen(node, end.topic, end.type, sensors, node.setting(end.key).span)
        yield from _unheard(node, end, graph, by_name, bool(distro))
    for node, key in ((one, key) for one in nodes if one.kind for key in one.values):
        plugins, (layer, _, last) = node.setting("plugins").value, key.rpartition(".")
        if last == "observation_sources" and (not layer or not isinstance(plugins, list) or layer in plugins):
            listing = node.parameters[key]
            names = listing.value.split() if isinstance(listing.value, str) else listing.value
            for name in names if isinstance(names, list) else ():
                inside = any(one.inside for one in ports(distro, node=node.name, role=Role.OBSTACLES))
                yield from _source(
                    node, layer, str(name), listing.span, sensors, heights, node.namespace if inside else ""
                )


def _unheard(node: Node, end: End, graph: Graph, by_name: Mapping[str, Node], is_decided: bool) -> Iterator[Diagnostic]:
    """Report a topic with a subscriber but no publisher that has the same message type and a compatible QoS."""
    there, role, heard = graph.publishers(end), end.port.role, end.topic
    fitting = [one for one in there if one.type == end.type]
    if mismatch := mismatched_qos(end, fitting):
        yield report("parameters-topic", mismatch, node.span, f"qos_overrides.{heard}.publisher.reliability: reliable")
    if not fitting and there and is_decided and role == Role.VELOCITY:
        sent = f"{there[0].node.strip('/')} sends {short_type(there[0].type)}"
        message = f"{node.display_name} takes {short_type(end.type)} on {heard}, and {sent}: {end.port.missing}"
        yield report("parameters-topic", message, node.span, "give both the same value of enable_stamped_cmd_vel")
        return
    senders = [one for one in graph.published if one.port.role == role == Role.VELOCITY and one.node != end.node]
    senders = [one for one in senders if not graph.readers(one)] or senders
    if not there and senders and node.setting(end.key).given:
        message = (
            f'{node.display_name} takes {short_type(end.type)} on {heard} ("{end.key}"), and no node in the files '
        )
        message += f"publishes that: {senders[0].node.strip('/')} sends to {senders[0].topic}; {end.port.missing}"
        help = f"{end.key}: {senders[0].topic.strip('/')}; or name the remap: --remap NODE:FROM:=TO"
        yield report("parameters-topic", message, node.setting(end.key).span, help, severity=WARNING)
    of_control = [one for one in graph.published if one.port.role == role and one.port.group == "control"]
    sources = {by_name[one.node]: one.topic for one in of_control}
    if fitting or role not in (Role.ODOMETRY, Role.IMU) or not sources:
        return
    meant = next((one for one in sources if one.full == heard.rpartition("/")[0] and sources[one] != heard), None)
    of_drive = heard in (node.topic(_ODOM), f"/{_ODOM}") or _OF_CONTROLLER.search(heard)
    if meant is None and not of_drive and role != Role.IMU:
        return  # the publisher is probably a node that is not in the files, such as a camera driver
    source, setting = meant or next(iter(sources)), node.setting(end.key)
    what = "IMU" if role == Role.IMU else "odometry"
    known = f"no node in the files publishes that: {source.display_name} publishes {sources[source]}"
    message = f'{node.display_name} listens to the {what} {heard} ("{end.key}"{setting.how}), and {known}'
    help = f"{end.key}: {sources[source].strip('/')}" + ("" if meant else "; or say the remap: --remap NODE:FROM:=TO")
    related = (Related(f"{source.display_name} is here", source.span),)
    rule = "parameters-topic" if role == Role.IMU else "parameters-odometry"
    yield report(rule, message, setting.span, help, related, WARNING if meant else NOTE)


def _source(
    node: Node,
    layer: str,
    name: str,
    place: Span,
    sensors: Mapping[str, str],
    heights: Mapping[str, float],
    space: str,
) -> Iterator[Diagnostic]:
    """Report a source that does not mark or clear obstacles; ``heights`` (m) has the topics of 2D lidars."""
    before, rule = f"{layer}.{name}." if layer else f"{name}.", "parameters-source"
    if not (given := {key.removeprefix(before): one for key, one in node.parameters.items() if key.startswith(before)}):
        message = f'{node.display_name} lists the source "{name}", which has no parameters'
        help = f"{name}: {{topic: TOPIC, data_type: LaserScan, marking: true, clearing: true}}"
        yield report(rule, message, place, help if layer else "")
    if not given or any(one.has_substitution for one in given.values()):
        return
    values: dict[str, Any] = {key: one.value for key, one in given.items()}
    what = f'the source "{name}" of {node.display_name}'
    place = given["topic"].span if "topic" in given else next(iter(given.values())).span
    topic = full_topic(str(values.get("topic", name)), space, node.name)
    if layer and values.get("marking", True) is True:
        highest, plugin = values.get("max_obstacle_height", 0.0), str(node.setting(f"{layer}.plugin").value)
        if isinstance(highest, float) and highest <= max(0.0, heights.get(topic, 0.0)) and "Spatio" not in plugin:
            how = "" if "max_obstacle_height" in values else " by default"
            at = f", and the lidar is at {heights[topic]:.3g} m" if topic in heights else ""
            text = f'{what} marks no obstacle: "max_obstacle_height" is {highest:g} m{how}{at}'
            yield report(rule, text, place, "max_obstacle_height: 2.0")
        if "clearing" not in values:
            message = f'{what} marks obstacles and never clears them: "clearing" is false by default'
            yield report(rule, message, place, "clearing: true")
        marks, clears = values.get("obstacle_max_range", 2.5), values.get("raytrace_max_range", 3.0)
        if values.get("clearing") is True and isinstance(marks, float) and isinstance(clears, float) and clears < marks:
            message = f"{what} marks obstacles up to {marks:g} m and clears them up to {clears:g} m"
            yield report(rule, message, place, f"raytrace_max_range: {marks + 0.5:g}")
    message, is_seen = source_message(values), values.get("type") not in ("polygon", "costmap")
    if is_seen and sensors.get(topic, message) != message:
        actual = short_type(sensors[topic])
        text = f"{what} expects {short_type(message)} on {topic}, and the sensor publishes {actual}: it sees nothing"
        yield report(rule, text, place, f"data_type: {actual}" if layer else "choose the type of these messages")
    elif is_seen and topic not in sensors:
        yield from _unseen(node, topic, message, sensors, place)


def _unseen(node: Node, topic: str, message: str, sensors: Mapping[str, str], place: Span) -> Iterator[Diagnostic]:
    """Report an observation source if sensors publish its message type, but only on other topics."""
    if (known := sorted(other for other, kind in sensors.items() if kind == message)) and topic not in known:
        text = f"{node.display_name} reads {short_type(message)} on {topic}, and the sensors of the robot publish "
        meant = topic.removeprefix(node.namespace)  # a relative topic, which the node looks up in its own namespace
        known, severity = ([meant], WARNING) if meant in known else (known, NOTE)
        yield report("parameters-source", text + phrase(known), place, f"topic: {known[0]}", severity=severity)


def summary(result: CheckedParameters) -> str:
    """Summarize a check of parameter files in one line of text."""
    severities = [one.severity for one in result.diagnostics]
    counts = phrase(count_of(severities.count(s), s) for s in ("error", "warning", "note") if s in severities)
    line = f"{count_of(result.judged, 'edge')} of nodes compared with the files: {counts or 'as described'}"
    line = line if result.judged else f"no node in the files owns an edge of the description: {counts or 'no problem'}"
    return line + (f"; no known parameters of {phrase(result.absent)}" if result.absent else "")

"""Build the ROS graph of a robot (the nodes that its package starts, and their topics); find unconnected topics."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Robot, Sensor
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, has_errors, phrase

from . import nav2, robot_localization
from .controllers.write import COMMAND, drivers, fill, namespace_of
from .navigation import frames_of, stated_topic
from .parameter_files import distro_of
from .ports import IN, OUT, Port, Role, controller_ports, full_topic, full_type, message_of_sensor, ports, short_type

CONTROL, MOVEIT, NAV2 = "control", "moveit", "nav2"
DRIVER, NODE = "driver", "node"
_Remaps = Iterable[tuple[str, str]]
_SCANS = "sensor_msgs/msg/LaserScan"
_OBSTACLE_MESSAGES = (_SCANS, "sensor_msgs/msg/PointCloud2")


@dataclass(frozen=True)
class End:
    """A publisher or subscriber of a topic; ``reliable`` is False if the QoS is best effort.

    ``type`` is the message type, ``key`` the parameter that sets the topic, or "".
    """

    node: str
    topic: str
    type: str
    port: Port
    key: str = ""
    reliable: bool = True


@dataclass
class Graph:
    """ROS nodes, their publishers and subscribers; ``nodes`` maps names to "node" or, for sensor drivers, "driver"."""

    nodes: dict[str, str] = field(default_factory=dict)
    published: list[End] = field(default_factory=list)
    read: list[End] = field(default_factory=list)
    starts: tuple[str, ...] = ()

    def publishers(self, end: End) -> list[End]:
        """Return all publishers on the topic of ``end``, including publishers of other message types."""
        return [one for one in self.published if one.topic == end.topic]

    def readers(self, end: End) -> list[End]:
        """Return the subscribers with the same topic and message type as ``end``."""
        return [one for one in self.read if one.topic == end.topic and one.type == end.type]

    def add(
        self, name: str, those: Iterable[Port], values: Mapping[str, Any], space: str = "", remaps: _Remaps = ()
    ) -> None:
        """Add a node with its topics (``those``), parameters, namespace (``space``), and remaps as pairs (from, to)."""
        self.nodes[name] = NODE
        own = name.rpartition("/")[2]
        moved = {full_topic(old, space, own): new for old, new in remaps}
        for port in those:
            for key, topic, message in _topics(port, values) if port.exists(values) else ():
                full = full_topic(topic, f"{space}/{own}" if port.inside else space, own)
                full = full_topic(moved.get(full, full), space, own)
                side, ends = ("subscription", self.read) if port.direction == IN else ("publisher", self.published)
                qos = values.get(f"qos_overrides.{full}.{side}.reliability") or port.qos
                ends.append(End(name, full, message, port, key, qos != "best_effort"))


def _topics(port: Port, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield (parameter, topic, message type) for each topic of a port; a port such as ``odom<n>`` has several."""
    if "<n>" in port.parameter:
        pattern = re.compile(port.parameter.replace("<n>", r"\d+"))
        yield from ((key, str(value), port.type) for key, value in values.items() if pattern.fullmatch(key))
        return
    if not port.each:
        yield port.parameter, port.name(values), port.message(values)
        return
    last = port.each.rpartition(".")[2]
    lists = {key: value for key, value in values.items() if key.rpartition(".")[2] == last}
    for key, value in lists.items():
        for name in value.split() if isinstance(value, str) else value:
            words = ("topic", "data_type", "type")
            own = {word: values.get(f"{key.removesuffix(last)}{name}.{word}") for word in words}
            yield key, str(own["topic"] or name), source_message(own)
    if port.role == Role.OBSTACLES and not any(lists.values()):
        yield "", "/scan", _SCANS  # the default in nav2_bringup/params/nav2_params.yaml


def source_message(values: Mapping[str, Any]) -> str:
    """Return the message type of an observation source from its parameters; by default LaserScan."""
    kind = str(values.get("data_type") or values.get("type") or "LaserScan")
    kind = {"scan": "LaserScan", "pointcloud": "PointCloud2", "range": "Range"}.get(kind, kind)
    return f"sensor_msgs/msg/{kind}"


def graph_of(robot: Robot, starts: Sequence[str]) -> Graph:
    """Build the graph of the nodes that a package starts; ``starts`` may contain "control", "moveit" and "nav2"."""
    made, first = Graph(starts=tuple(starts)), {output.backend: output for output in reversed(robot.outputs)}
    control, navigation = first.get("controllers"), first.get(NAV2) if NAV2 in starts else None
    namespace = namespace_of(control) if control else ""
    made.add("robot_state_publisher", ports("", node="robot_state_publisher"), {}, namespace)
    if CONTROL in starts and control is not None:
        commands = {driver.name: driver.command for driver in drivers(robot)} if navigation is not None else {}
        distribution = distro_of(control)
        made.add("controller_manager", ports(distribution, node="controller_manager"), {}, namespace)
        for one in fill(robot, distribution):
            name, those = one.controller.name, controller_ports(one.type, distribution)
            remaps = [(port.topic, "/tf") for port in those if port.role == Role.TF and port.topic != "/tf"]
            remaps += [(commands[name], COMMAND)] if name in commands else []
            if not one.controller.inactive:
                made.add(name, those, one.values, namespace, remaps)
    parameters: dict[str, Mapping[str, Any]] = {}
    for backend, view in ((NAV2, nav2.view), ("robot_localization", robot_localization.view)):
        if backend in first and NAV2 in starts:
            parameters |= {name.rpartition("/")[2]: one for name, one in view(robot, first[backend]).node.items()}
    if navigation is not None:
        frames, distribution = frames_of(robot, navigation)[0], distro_of(navigation)
        if frames is not None:  # parameters that the launch file passes to slam_toolbox
            parameters.setdefault("slam_toolbox", nav2.slam_parameters(robot, navigation, frames))
        for port in ports(distribution):
            values = parameters.get(port.node, {})
            silent = values.get("tf_broadcast") is False or values.get("transform_publish_period") == 0.0
            if port.node not in made.nodes and port.group in ("nav2", "localization", "slam") and not silent:
                made.add(port.node, ports(distribution, node=port.node), values)
    for name, values in parameters.items():
        if "world_frame" in values:
            moved = robot_localization.remaps(robot, first["robot_localization"]) if CONTROL in starts else []
            made.add(name, ports("", node="ekf"), values, remaps=moved)
    if MOVEIT in starts:
        made.add("move_group", ports("", node="move_group"), {}, namespace)
    broadcast = {one.values.get("sensor_name") for one in fill(robot, "")} if CONTROL in starts else set()
    for sensor, topic, message in topics_of_sensors(robot):
        if sensor.name not in broadcast:
            node = f"driver of {sensor.name}"
            made.nodes[node] = DRIVER
            port, reliable = Port(node, OUT, topic, sensor.type), sensor.type == "imu"  # as in most drivers
            made.published.append(End(node, full_topic(topic, "", ""), message, port, reliable=reliable))
    return made


def topics_of_sensors(robot: Robot) -> Iterator[tuple[Sensor, str, str]]:
    """Yield (sensor, topic, message type) for each sensor whose topic is in the description."""
    first = {output.backend: output.options for output in reversed(robot.outputs)}
    keys = ((NAV2, "sources"), ("robot_localization", "inputs"))
    entries = [entry for backend, key in keys for entry in (first.get(backend, {}).get(key) or {}).values()]
    given = {one["sensor"]: one["topic"] for one in reversed(entries) if one.get("sensor") and one.get("topic")}
    for sensor in robot.sensors:
        topic, message = given.get(sensor.name) or stated_topic(robot, sensor.name), message_of_sensor(sensor.type)
        if topic and message:
            yield sensor, topic, message


def mismatched_qos(reader: End, publishers: Sequence[End]) -> str:
    """Return an error message if all publishers are best effort and the subscriber is reliable, else ""."""
    if not reader.reliable or not publishers or any(one.reliable for one in publishers):
        return ""
    who, sender = reader.node.strip("/"), publishers[0].node.strip("/")
    message = f"{who} needs reliable messages on {reader.topic} and gets none: {sender} sends them as best effort"
    return f"{message}; {reader.port.missing}" if reader.port.missing else message


def open_ends(robot: Robot, made: Graph) -> Iterator[Diagnostic]:
    """Report topics with subscribers but no publisher, incompatible QoS, and velocity commands without a subscriber."""
    reported: set[tuple[str, str]] = set()
    for end in made.read:
        others = made.publishers(end)
        fitting = [one for one in others if one.type == end.type]
        if mismatch := mismatched_qos(end, fitting):
            yield report("package-open", mismatch, None, "make the publisher reliable")
        if not fitting and (end.topic, end.type) not in reported:
            reported.add((end.topic, end.type))
            yield from _open(robot, made, made.readers(end), others)
    for end in made.published:
        known = end.topic in {topic for topic, _ in reported}
        if end.port.role == Role.VELOCITY and CONTROL in made.starts and not known and not made.readers(end):
            message = f"{end.node} sends {short_type(end.type)} on {end.topic}, and no node of the package takes that"
            help = "give the controllers and nav2 the same distribution, and the package a controller of the drive"
            yield report("package-open", f"{message}: the robot does not move", None, help)


def _open(robot: Robot, made: Graph, readers: Sequence[End], others: Sequence[End]) -> Iterator[Diagnostic]:
    end = readers[0]
    who, role = phrase(dict.fromkeys(one.node for one in readers)), end.port.role
    what = f"{who} {'reads' if who == end.node else 'read'} {short_type(end.type)} on {end.topic}"
    symptom = next((one.port.missing for one in readers if "the robot" in one.port.missing), end.port.missing)
    same_type = [one for one in made.published if one.type == end.type and one.node != end.node]
    why, help = "", "start the driver that publishes it"
    if end.port.node == "ekf" and not any(made.publishers(one) for one in made.read if one.node == end.node):
        symptom = "the filter publishes no transform until one of its inputs speaks"
    if others:
        why = f"{others[0].node} publishes {short_type(others[0].type)} there"
        help = "give both the same distribution"
    elif role in (Role.OBSTACLES, Role.SCAN):
        if not (seeing := [one for one in robot.sensors if message_of_sensor(one.type) in _OBSTACLE_MESSAGES]):
            why = "the robot has no sensor for that"
            help = "add a lidar_2d to sensors, and to nav2: sources: {scan: {sensor: NAME, topic: /scan}}"
        elif len(same_type) == 1:
            why, help = f"the scan is on {same_type[0].topic}", "name the topic in nav2: sources"
        elif same_type:  # AMCL and slam_toolbox read one lidar: that of the source "scan"
            drivers = sorted(
                (one for one in made.published if one.type in _OBSTACLE_MESSAGES), key=lambda one: one.type
            )
            names = ["scan", *(one.node.removeprefix("driver of ") for one in drivers[1:])]
            each = [f"sensor: {one.node.removeprefix('driver of ')}, topic: {one.topic}" for one in drivers]
            help = ", ".join(f"{name}: {{{entry}}}" for name, entry in zip(names, each, strict=True))
            help = f'name the source of the lidar that they read "scan": nav2: sources: {{{help}}}'
        elif role == Role.SCAN and all(message_of_sensor(one.type) != _SCANS for one in seeing):
            help = f"start a node that makes {end.topic} from a point cloud, such as pointcloud_to_laserscan"
        else:
            help = f"nav2: sources: {{scan: {{sensor: {seeing[0].name}, topic: NAME}}}}, or a node that publishes it"
    elif role in (Role.ODOMETRY, Role.IMU, Role.POSE, Role.TWIST):
        heard = {one.topic for one in made.read if one.node == end.node}
        there = next((one for one in same_type if one.port.group == CONTROL), None)
        if there is not None and not heard & {one.topic for one in same_type}:
            why = f"{there.node} publishes on {there.topic}"
            help = f"topic: {there.topic.removeprefix('/')}"
            if role == Role.ODOMETRY and end.port.node == "ekf":
                help += f"; or controller: {there.node}, where another node publishes {end.topic} without --control"
    elif role == Role.JOINT_STATES and CONTROL in made.starts:
        why, help = "no joint_state_broadcaster is started", "add it to controllers, or start the driver"
        broadcasters = [one for one in robot.controllers if full_type(one.type).endswith("/JointStateBroadcaster")]
        if same_type:
            why = f"{same_type[0].node} publishes on {same_type[0].topic}"
            help = 'remove "use_local_topics" from its "params"'
        elif broadcasters:
            why, help = f"{broadcasters[0].name} is started inactive", 'remove "inactive: true" from it'
        yield report("package-external", f"{what}, and {why}: {symptom}", None, help)
        return
    else:
        return
    message = f"and {why}: {symptom}" if why else f"which no node of the package publishes: without it, {symptom}"
    yield report("package-open" if why else "package-external", f"{what}, {message}", None, help)


@dataclass(frozen=True)
class Topic:
    """A topic with the names of its publishers and subscribers."""

    topic: str
    type: str
    published_by: tuple[str, ...]
    read_by: tuple[str, ...]


@dataclass(frozen=True)
class RobotGraph:
    """The ROS nodes of a robot and their topics; ``robot`` is "" if the description has errors."""

    robot: str = ""
    nodes: tuple[str, ...] = ()
    drivers: Annotated[tuple[str, ...], "nodes outside of the package, such as drivers of sensors"] = ()
    topics: tuple[Topic, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)

    def text(self) -> str:
        """Format the graph as text: for each topic its message type, publishers and subscribers."""
        lines = []
        for one in self.topics:
            publishers, readers = ", ".join(one.published_by), ", ".join(one.read_by)
            ends = f"{publishers or '(no publisher)'} -> {readers or '(no reader)'}"
            lines.append(f"{one.topic}  {one.type}\n  {ends}")
        return "\n".join(lines)

    def svg(self) -> str:
        """Draw the graph as SVG: publishers on the left, topics in the middle, subscribers on the right."""
        left = dict.fromkeys(name for one in self.topics for name in one.published_by)
        right = dict.fromkeys(name for one in self.topics for name in one.read_by)
        columns = [list(left), [one.topic for one in self.topics], list(right)]
        places = [{name: 40 + 26 * row for row, name in enumerate(names)} for names in columns]
        values = {"graph": self, "places": places, "height": 60 + 26 * max(map(len, columns)), "short_type": short_type}
        return Templates.own("ros/graph.svg.jinja", values)


def graph(
    robot: FilePath | Request, arguments: Values = None, packages: Packages = None, *, trust: bool = False
) -> RobotGraph:
    """Return the ROS 2 nodes that the package of a robot starts, and their topics.

    Topics that have subscribers but no publisher are reported in ``diagnostics``.

    Example:
        >>> import rosorin_compile
        >>> [topic.type for topic in rosorin_compile.graph("rosorin").topics if topic.topic == "/scan"]
        ['sensor_msgs/msg/LaserScan']
    """
    compiled = Request.from_arguments(robot, arguments, packages, trust=trust).compile()
    errors = tuple(one for one in compiled.diagnostics if has_errors([one]))
    if compiled.robot is None or errors:
        return RobotGraph(diagnostics=errors)
    backends = {output.backend for output in compiled.robot.outputs}
    needed = {CONTROL: {"controllers"}, MOVEIT: {"srdf"}, NAV2: {NAV2, "robot_localization"}}
    made = graph_of(compiled.robot, [word for word, formats in needed.items() if backends & formats])

    def nodes_at(ends: Sequence[End], *topic: str) -> tuple[str, ...]:
        return tuple(dict.fromkeys(end.node for end in ends if (end.topic, end.type) == topic))

    pairs = sorted({(end.topic, end.type) for end in (*made.published, *made.read)})
    topics = tuple(Topic(*pair, nodes_at(made.published, *pair), nodes_at(made.read, *pair)) for pair in pairs)
    nodes, others = (tuple(name for name, kind in made.nodes.items() if kind == each) for each in (NODE, DRIVER))
    return RobotGraph(compiled.robot.name, nodes, others, topics, tuple(open_ends(compiled.robot, made)))

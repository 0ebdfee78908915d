"""The ports of stock ROS 2 nodes (topics that they subscribe to or publish), from ``schemas/ros2_ports.json``."""

import json
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.source import files
from rosorin_compile.source.project import data_folder

IN, OUT = "in", "out"


def described_by(distribution: str) -> str:
    """Return the distribution whose rules are used for ``distribution``: Humble for Humble, and Jazzy for any other."""
    return HUMBLE if distribution == HUMBLE else JAZZY


class Role:
    """The purpose of a topic."""

    VELOCITY, ODOMETRY, OBSTACLES, SCAN = "velocity", "odometry", "obstacles", "scan"
    IMU, TF, JOINT_STATES = "imu", "tf", "joint_states"
    POSE, TWIST = "pose", "twist"


class Port(NamedTuple):
    """A topic that a node or controller type subscribes to or publishes; ros2_ports.json explains the fields.

    ``topic`` is the name after the remaps in nav2_bringup. ``stamp_parameter`` is the parameter that selects
    TwistStamped, or "" if the node has none; ``stamped`` is its default. If ``inside``, a relative topic is resolved in
    a namespace with the name of the node.
    """

    node: str
    direction: str
    topic: str
    role: str
    type: str = ""
    parameter: str = ""
    qos: str = "reliable"
    unstamped: str = ""
    local: str = ""
    each: str = ""
    display: str = ""
    missing: str = ""
    when: tuple[tuple[str, Any], ...] = ()
    stamp_parameter: str = ""
    stamped: bool = False
    optional: bool = False
    group: str = ""
    inside: bool = False

    def is_stamped(self, parameters: Mapping[str, Any]) -> bool:
        """Return True if a node with these parameters uses TwistStamped instead of Twist."""
        return bool(parameters.get(self.stamp_parameter, self.stamped)) if self.stamp_parameter else self.stamped

    def message(self, parameters: Mapping[str, Any]) -> str:
        """Return the message type that a node with these parameters uses."""
        return self.type + ("Stamped" if self.is_stamped(parameters) else "")

    def name(self, parameters: Mapping[str, Any]) -> str:
        """Return the topic that a node with these parameters uses, before remaps in its launch file."""
        if self.local and parameters.get("use_local_topics"):
            return self.local
        if self.unstamped and not self.is_stamped(parameters):
            return self.unstamped
        return str(parameters.get(self.parameter) or self.topic)

    def exists(self, parameters: Mapping[str, Any]) -> bool:
        """Return True if a node with these parameters has the port. An ``optional`` port does not exist by default."""
        return all(parameters[key] == value if key in parameters else not self.optional for key, value in self.when)


@cache
def facts(name: str) -> Any:
    """Load ``schemas/NAME.json``, a table of facts about ROS 2."""
    return json.loads(files.read_text(data_folder("schemas") / f"{name}.json"))


def distribution_of_ports(distribution: str) -> str:
    """Return ``distribution`` if the table of ports has it, else the last distribution in the table."""
    known = facts("ros2_ports")["distributions"]
    return distribution if distribution in known else str(known[-1])


def message_of_sensor(kind: str) -> str:
    """Return the message type that drivers publish for a sensor type of the description, or "" if unknown."""
    return str(facts("ros2_ports")["message_types"].get(kind, ""))


def short_type(message: str) -> str:
    """Remove the package from a message type: sensor_msgs/msg/LaserScan becomes LaserScan."""
    return message.rpartition("/")[2]


def _port(owner: str, entry: Mapping[str, Any], distribution: str, group: str) -> Port:
    direction, known = IN if IN in entry else OUT, {key: entry[key] for key in Port._fields if key in entry}
    known |= {"node": owner, "direction": direction, "group": group, "when": tuple(entry.get("when", {}).items())}
    known |= {"topic": entry.get("bringup", {}).get(distribution, entry[direction]), "stamped": False}
    known["inside"] = distribution in entry.get("inside", ())
    for key, defaults in entry.get("stamped", {}).items():
        if (default := defaults.get(distribution)) is not None:
            known |= {"stamp_parameter": key, "stamped": bool(default) or group == "control"}
        elif group == "control":  # controllers without the parameter use TwistStamped
            known |= {"stamp_parameter": "", "stamped": True}
    return Port(**known)


@cache
def _of_nodes(distribution: str) -> tuple[Port, ...]:
    rows = [(name, node, entry) for name, node in facts("ros2_ports")["nodes"].items() for entry in node["ports"]]
    known = [row for row in rows if all(distribution in one.get("only", [distribution]) for one in row[1:])]
    return tuple(_port(name, entry, distribution, node["group"]) for name, node, entry in known)


def ports(distribution: str, *, node: str = "", role: str = "", direction: str = "", group: str = "") -> Iterator[Port]:
    """Yield the ports of stock nodes in a distribution that match all arguments; "" matches everything."""
    for port in _of_nodes(distribution_of_ports(distribution)):
        filters = ((node, port.node), (role, port.role), (direction, port.direction), (group, port.group))
        if all(value in ("", actual) for value, actual in filters):
            yield port


@cache
def controller_ports(plugin: str, distribution: str) -> tuple[Port, ...]:
    """Return the ports of a controller or broadcaster type, or () for an unknown type."""
    entries = facts("ros2_ports")["controllers"]["types"].get(plugin, ())
    return tuple(_port(plugin, one, distribution_of_ports(distribution), "control") for one in entries)


def port_of(plugin: str, distribution: str, role: str) -> Port | None:
    """Return the port of a controller type for a role, such as odometry, or None if there is none."""
    return next((port for port in controller_ports(plugin, distribution) if port.role == role), None)


def full_type(word: str) -> str:
    """Return the full controller type for a short name such as "diff_drive"; return other names unchanged."""
    return str(facts("ros2_ports")["controllers"]["short"].get(word, word))


def interfaces_of(plugin: str) -> dict[str, Any]:
    """Return the command and state interfaces, drive or sensor that a controller type needs, or {} if unknown."""
    return dict(facts("ros2_ports")["controllers"]["interfaces"].get(plugin, {}))


def full_topic(topic: str, namespace: str, node: str) -> str:
    """Resolve the topic name of a node in a namespace to a full name.

    >>> full_topic("~/odom", "left", "base"), full_topic("scan", "", "amcl"), full_topic("/tf", "left", "base")
    ('/left/base/odom', '/scan', '/tf')
    """
    inside = f"/{namespace.strip('/')}".rstrip("/")
    if topic.startswith("~/"):
        return f"{inside}/{node}/{topic[2:]}"
    return topic if topic.startswith("/") else f"{inside}/{topic}"

"""Topics: which of the topics of a bag are looked at, and what for."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...registry import RECORDINGS, Rule
from ..findings import problem
from ..recording.recording import Recording

RULES = (
    Rule(
        "recording-type",
        "A topic has the name of one that is looked at, and another type.",
        "Rename it.",
        RECORDINGS,
    ),
)

TF, TF_STATIC, JOINTS, ROBOT, HEADER, CLOCK = range(6)
TYPES = {
    TF: "tf2_msgs/msg/TFMessage",
    TF_STATIC: "tf2_msgs/msg/TFMessage",
    JOINTS: "sensor_msgs/msg/JointState",
    ROBOT: "std_msgs/msg/String",
    CLOCK: "rosgraph_msgs/msg/Clock",
}
TOPICS = {"tf": TF, "tf_static": TF_STATIC, "joint_states": JOINTS, "robot_description": ROBOT, "clock": CLOCK}
# Their frame_id, if there is one, is no place.
NOT_PLACED = {
    f"sensor_msgs/msg/{name}" for name in ("JointState", "Joy", "BatteryState", "TimeReference", "Temperature")
}
NOT_PLACED |= {"diagnostic_msgs/msg/DiagnosticArray"}


class Topic(NamedTuple):
    """What is done with the messages of a connection."""

    kind: int
    name: str
    type: str


def topics_of(reader: Any, recording: Recording) -> dict[int, Topic]:
    """Return what is done with each connection that matters, by its id."""
    from rosbags.typesys import Stores, get_typestore

    known = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    namespace = recording.description.options.namespace.strip("/")
    names = {f"/{name}": kind for name, kind in TOPICS.items()}
    if namespace:
        names |= {f"/{namespace}/{name}": kind for name, kind in TOPICS.items()}
    topics: dict[int, Topic] = {}
    for connection in reader.connections:
        topic, kind = connection.topic, names.get(connection.topic, HEADER)
        recording.topics[topic] = connection.msgtype
        if kind != HEADER and connection.msgtype != TYPES[kind]:
            text = f"{topic} is of type {connection.msgtype}, not {TYPES[kind]}"
            help = "something else uses the name of this topic: rename it"
            recording.troubles.append(problem("recording-type", topic, text, help))
        elif kind != HEADER or _has_header(connection, known):
            topics[connection.id] = Topic(kind, topic, connection.msgtype)
    return topics


def _has_header(connection: Any, known: Any) -> bool:
    """Say whether the messages of a connection begin with a std_msgs/Header."""
    if connection.msgtype in NOT_PLACED:
        return False
    if connection.msgtype in known:
        fields = known[connection.msgtype][1]
        return bool(fields) and str(fields[0][1][1]) == "std_msgs/msg/Header"
    for line in str(connection.msgdef.data).splitlines():
        words = line.split("#")[0].split()
        if len(words) >= 2 and "=" not in line:
            return words[0] in ("std_msgs/Header", "std_msgs/msg/Header", "Header")
    return False

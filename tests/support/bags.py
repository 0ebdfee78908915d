"""Recordings of the reference robot for tests: what its nodes publish while the arm moves, clean and with faults.

The behaviour is that of the stock nodes: robot_state_publisher stamps with the stamp of the joint state and publishes
fixed joints once on /tf_static; static_transform_publisher stamps when it starts. rosbags writes the files.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Pose, Robot, Transform
from rosorin_compile.recordings.expected_edges import Options
from rosorin_compile.recordings.results import Verification
from rosorin_compile.recordings.verification import verify
from support.robots import compiled, texts

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = STORE.types
SECOND = 1_000_000_000
START = 1_790_000_000 * SECOND
ARM = ("joint1", "joint2", "joint3", "joint4", "joint5")


class Message(NamedTuple):
    """A message of a recording: when it was received (ns), its topic, its type, its content."""

    received: int
    topic: str
    kind: str
    content: Any


@dataclass
class Scene:
    """What a robot does in front of the recorder. Times in s, rates in Hz."""

    seconds: float = 12.0
    states_rate: float = 10.0
    camera_delay: float = 0.16
    publishers: bool = True
    laser: Transform | None = None
    laser_from: float = -5.0
    camera_frame: str = "depth_camera_link"
    slam: Callable[[float], bool] = lambda _: True
    description: str | None = None
    change: Callable[[list[Message]], list[Message]] = field(default=lambda messages: messages)
    joint_names: tuple[str, ...] = ARM
    joint_offset: dict[str, float] = field(default_factory=dict)


@cache
def made() -> CompileResult:
    """Return the reference robot, compiled once."""
    return compiled()


def robot() -> Robot:
    """Return the reference robot."""
    found = made().robot
    assert found is not None
    return found


def urdf() -> str:
    """Return its URDF."""
    return texts(made())["rosorin.urdf"]


def judged(source: Path | str, text: str = "", **options: Any) -> Verification:
    """Return the verdict about a recording of the reference robot; "-" is the text."""
    return verify(robot(), made().artifacts, str(source), Options(**options), standard_input=text.encode)


def rules(verdict: Verification) -> list[str]:
    """Return the rules of the findings of a verdict."""
    return [finding.rule for finding in verdict.findings]


def ns(seconds: float) -> int:
    """Return a time into the recording in ns."""
    return START + round(seconds * 1e9)


def time(stamp: int) -> Any:
    return TYPES["builtin_interfaces/msg/Time"](stamp // SECOND, stamp % SECOND)


def header(stamp: int, frame: str) -> Any:
    return TYPES["std_msgs/msg/Header"](time(stamp), frame)


def transform_message(stamp: int, parent: str, child: str, transform: Transform) -> Any:
    w, x, y, z = transform.quaternion()
    vector = TYPES["geometry_msgs/msg/Vector3"](*transform.xyz)
    turn = TYPES["geometry_msgs/msg/Quaternion"](x, y, z, w)
    inner = TYPES["geometry_msgs/msg/Transform"](vector, turn)
    return TYPES["geometry_msgs/msg/TransformStamped"](header(stamp, parent), child, inner)


def stamped(message: Message, new: Callable[[int], int]) -> Message:
    """Return a message with other stamps, in ns."""
    content = message.content
    parts = content.transforms if hasattr(content, "transforms") else [content] if hasattr(content, "header") else []
    for part in parts:
        stamp = part.header.stamp
        at = max(0, new(stamp.sec * SECOND + stamp.nanosec))
        stamp.sec, stamp.nanosec = at // SECOND, at % SECOND
    return message


def tf(received: int, transforms: list[Any], still: bool = False) -> Message:
    topic = "/tf_static" if still else "/tf"
    return Message(received, topic, "tf2_msgs/msg/TFMessage", TYPES["tf2_msgs/msg/TFMessage"](transforms))


def edge(
    stamp: int, parent: str, child: str, transform: Transform, delay: float = 0.002, still: bool = False
) -> Message:
    """Return a message with one transform."""
    return tf(stamp + round(delay * 1e9), [transform_message(stamp, parent, child, transform)], still)


def positions(seconds: float) -> dict[str, float]:
    """Return where the joints of the arm are: each swings within its limits."""
    return {name: 0.3 * number * math.sin(0.7 * seconds + number) for number, name in enumerate(ARM, 1)}


def joint_state(stamp: int, names: tuple[str, ...], values: list[float]) -> Any:
    empty = np.empty(0)
    return TYPES["sensor_msgs/msg/JointState"](header(stamp, ""), list(names), np.array(values), empty, empty)


def every(rate: float, seconds: float, phase: float = 0.0) -> Iterator[float]:
    for number in range(int(seconds * rate)):
        yield phase + number / rate


def messages(scene: Scene) -> list[Message]:
    """Return all messages of a scene in the order of their arrival."""
    found = [*_still(scene), *_arm(scene), *_drive(scene), *_sensors(scene)]
    found = scene.change(found)
    return sorted(found, key=lambda message: message.received)


def _still(scene: Scene) -> Iterator[Message]:
    started = ns(-5.0)
    text = urdf() if scene.description is None else scene.description
    string = TYPES["std_msgs/msg/String"]
    yield Message(ns(0.02), "/robot_description", "std_msgs/msg/String", string(text))
    fixed = [joint for joint in robot().published_by(ROBOT_STATE_PUBLISHER) if not joint.moves]
    yield tf(ns(0.01), [_joint(started, joint, 0.0) for joint in fixed], still=True)
    for joint in robot().published_by(STATIC_TRANSFORM_PUBLISHER):
        value, began = joint.transform(), started
        if joint.child == "laser":
            value, began = scene.laser or value, ns(scene.laser_from)
        received = max(began, ns(0.012))
        yield tf(received, [transform_message(began, joint.parent, joint.child, value)], still=True)
    optical = Pose((0.0251, 0.0002, 0.0), (0.001, -0.002, 0.003)).transform()
    yield tf(ns(0.013), [transform_message(started, "depth_camera_link", "rgb_camera_link", optical)], still=True)


def _joint(stamp: int, joint: Joint, position: float) -> Any:
    return transform_message(stamp, joint.parent, joint.child, joint.transform(position))


def _arm(scene: Scene) -> Iterator[Message]:
    moving = [joint for joint in robot().published_by(ROBOT_STATE_PUBLISHER) if joint.moves]
    for seconds in every(scene.states_rate, scene.seconds, 0.03):
        stamp = ns(seconds)
        at = positions(seconds)
        said = {name: at.get(name, 0.0) + scene.joint_offset.get(name, 0.0) for name in scene.joint_names}
        state = joint_state(stamp, scene.joint_names, list(said.values()))
        yield Message(stamp + 1_000_000, "/joint_states", "sensor_msgs/msg/JointState", state)
        transforms = [_joint(stamp, joint, said[joint.name]) for joint in moving if joint.name in said]
        if transforms:
            yield tf(stamp + 2_000_000, transforms)


def _drive(scene: Scene) -> Iterator[Message]:
    for seconds in every(50.0, scene.seconds):
        pose = Pose((0.2 * seconds, 0.1 * math.sin(seconds), 0.0), (0.0, 0.0, 0.1 * seconds))
        yield edge(ns(seconds), "odom", "base_link", pose.transform())
    for seconds in every(20.0, scene.seconds, 0.004):
        if scene.slam(seconds):
            pose = Pose((0.5 + 0.001 * seconds, -0.2, 0.0), (0.0, 0.0, 0.02))
            yield edge(ns(seconds), "map", "odom", pose.transform())


def _sensors(scene: Scene) -> Iterator[Message]:
    kinds = [
        ("/scan", "sensor_msgs/msg/LaserScan", scan, "laser", 10.0, 0.01),
        ("/imu/data", "sensor_msgs/msg/Imu", imu, "imu_link", 50.0, 0.003),
        ("/camera/depth/image", "sensor_msgs/msg/Image", image, scene.camera_frame, 15.0, scene.camera_delay),
        ("/odom", "nav_msgs/msg/Odometry", odometry, "odom", 50.0, 0.002),
    ]
    for topic, kind, make, frame, rate, delay in kinds:
        for seconds in every(rate, scene.seconds - 0.3, 0.2):
            yield Message(ns(seconds + delay), topic, kind, make(header(ns(seconds), frame)))


def scan(head: Any) -> Any:
    empty = np.empty(0, np.float32)
    return TYPES["sensor_msgs/msg/LaserScan"](head, 0.0, 6.28, 0.01, 0.0, 0.1, 0.1, 12.0, empty, empty)


def imu(head: Any) -> Any:
    turn, zero = (
        TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
        TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0),
    )
    nine = np.zeros(9)
    return TYPES["sensor_msgs/msg/Imu"](head, turn, nine, zero, nine, zero, nine)


def image(head: Any) -> Any:
    return TYPES["sensor_msgs/msg/Image"](head, 2, 3, "16UC1", 0, 6, np.zeros(12, np.uint8))


def odometry(head: Any) -> Any:
    point, turn = (
        TYPES["geometry_msgs/msg/Point"](0.0, 0.0, 0.0),
        TYPES["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )
    zero = TYPES["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    pose = TYPES["geometry_msgs/msg/PoseWithCovariance"](TYPES["geometry_msgs/msg/Pose"](point, turn), np.zeros(36))
    twist = TYPES["geometry_msgs/msg/TwistWithCovariance"](TYPES["geometry_msgs/msg/Twist"](zero, zero), np.zeros(36))
    return TYPES["nav_msgs/msg/Odometry"](head, "base_link", pose, twist)


def write(folder: Path, said: list[Message], storage: str = "sqlite3", compression: str = "NONE") -> Path:
    """Write messages as a rosbag2 folder; return it."""
    writer = Writer(folder, version=9, storage_plugin=StoragePlugin[storage.upper()])
    writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    with writer:
        connections: dict[tuple[str, str], Any] = {}
        for message in said:
            key = (message.topic, message.kind)
            if key not in connections:
                connections[key] = writer.add_connection(*key, typestore=STORE)
            raw = STORE.serialize_cdr(message.content, message.kind)
            writer.write(connections[key], message.received, raw)
    return folder


def bag(folder: Path, storage: str = "sqlite3", **scene: Any) -> Path:
    """Write the recording of a scene; return its folder."""
    return write(folder, messages(Scene(**scene)), storage)


def part(folder: Path) -> Path:
    """Return the file of a recording that holds its messages."""
    (found,) = [path for path in folder.iterdir() if path.suffix in (".db3", ".mcap")]
    return found

"""Speed of verify, as a ratio to rosbags merely reading and decoding the same recording in the same run; and memory.

    python benchmarks/verify.py [MESSAGES] [sqlite3|mcap ...]

The recording is of the reference robot: the edges of its arm from joint states at 200 Hz, those of the odometry and of
the localisation, one transform a message. Memory is the peak of a separate process.
"""

from __future__ import annotations

import resource
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from rosorin_compile.formats import Artifact
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot, Transform
from rosorin_compile.recordings.expected_edges import Options
from rosorin_compile.recordings.verification import verify

ROOT = Path(__file__).resolve().parent.parent
ROBOT = ROOT / "descriptions" / "rosorin" / "robot.yaml"
STORE = get_typestore(Stores.ROS2_HUMBLE)
START = 1_790_000_000_000_000_000
PERIOD = 5_000_000
ROUNDS = 3


def transform_template(parent: str, child: str) -> bytes:
    """Return a /tf message of one transform with stamp and numbers at zero."""
    types = STORE.types
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    vector, turn = (
        types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0),
        types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0),
    )
    inner = types["geometry_msgs/msg/Transform"](vector, turn)
    header = types["std_msgs/msg/Header"](stamp, parent)
    message = types["tf2_msgs/msg/TFMessage"]([types["geometry_msgs/msg/TransformStamped"](header, child, inner)])
    return bytes(STORE.serialize_cdr(message, "tf2_msgs/msg/TFMessage"))


def filled(template: bytes, stamp: int, transform: Transform) -> bytes:
    """Return a message of a template; the stamp stands behind the count, the numbers at the end."""
    raw = bytearray(template)
    struct.pack_into("<iI", raw, 8, stamp // 10**9, stamp % 10**9)
    w, x, y, z = transform.quaternion()
    struct.pack_into("<7d", raw, len(raw) - 56, *transform.xyz, x, y, z, w)
    return bytes(raw)


def messages(robot: Robot, count: int) -> Iterator[tuple[int, str, bytes]]:
    """Yield joint states and /tf messages, ``count`` of the latter, as time (ns), topic and bytes."""
    joints = [joint for joint in robot.published_by(ROBOT_STATE_PUBLISHER) if joint.moves]
    templates = [transform_template(joint.parent, joint.child) for joint in joints]
    others = [transform_template("odom", "base_link"), transform_template("map", "odom")]
    states = [[0.001 * step * (number + 1) for number in range(len(joints))] for step in range(200)]
    poses = [[joint.transform(at) for joint, at in zip(joints, state, strict=True)] for state in states]
    names = [joint.name for joint in joints]
    empty = STORE.types["sensor_msgs/msg/JointState"]
    made = tick = 0
    while made < count:
        stamp, step = START + tick * PERIOD, tick % len(states)
        head = STORE.types["std_msgs/msg/Header"](
            STORE.types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9), ""
        )
        state = empty(head, names, array(states[step]), array([]), array([]))
        yield stamp + 100_000, "/joint_states", bytes(STORE.serialize_cdr(state, "sensor_msgs/msg/JointState"))
        for template, pose in zip(templates, poses[step], strict=True):
            yield stamp + 200_000, "/tf", filled(template, stamp, pose)
        for number, template in enumerate(others):
            yield stamp + 300_000 + number, "/tf", filled(template, stamp, Transform(xyz=(0.0001 * tick, 0.0, 0.0)))
        made += len(templates) + len(others)
        tick += 1


def array(values: list[float]) -> object:
    """Return numbers as rosbags wants them."""
    import numpy as np

    return np.array(values, np.float64)


def write(folder: Path, robot: Robot, count: int, storage: str) -> Path:
    """Write a recording; return its folder."""
    types = {"/tf": "tf2_msgs/msg/TFMessage", "/joint_states": "sensor_msgs/msg/JointState"}
    with Writer(folder, version=9, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in types.items()}
        for received, topic, raw in messages(robot, count):
            writer.write(connections[topic], received, raw)
    return folder


def compiled() -> tuple[Robot, tuple[Artifact, ...]]:
    """Return the reference robot and its artifacts."""
    made = compile_robot(ROBOT)
    if made.robot is None:
        raise SystemExit("the reference robot does not compile")
    return made.robot, made.artifacts


def merely_read(folder: Path) -> int:
    """Read and decode every message with rosbags, as a program with it would; return how many there are."""
    count = 0
    with Reader(folder) as reader:
        for connection, _, raw in reader.messages():
            STORE.deserialize_cdr(raw, connection.msgtype)
            count += 1
    return count


def seconds(run: Callable[[], object]) -> float:
    """Return how long something takes."""
    began = time.perf_counter()
    run()
    return time.perf_counter() - began


def ratio(folder: Path) -> str:
    """Return the speeds of both in pairs, and the median ratio."""
    robot, artifacts = compiled()
    total = merely_read(folder)
    pairs = []
    for _ in range(ROUNDS):
        read = seconds(lambda: merely_read(folder))
        own = seconds(lambda: verify(robot, artifacts, str(folder), Options(without=frozenset({"deptrum"}))))
        pairs.append((read / own, total / read, total / own))
    middle, reads, owns = sorted(pairs)[len(pairs) // 2]
    return f"verify {owns:,.0f} messages/s, rosbags {reads:,.0f}: {1 / middle:.2f} times as long (at most 3)"


def peak(folder: Path) -> float:
    """Return the peak memory in MiB of a process that verifies a recording."""
    ran = subprocess.run([sys.executable, __file__, "--peak", str(folder)], check=True, capture_output=True, text=True)
    return float(ran.stdout)


def main() -> None:
    words = sys.argv[1:]
    if words[:1] == ["--peak"]:
        verify(*compiled(), words[1], Options())
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
        return
    count = int(words[0]) if words else 1_000_000
    robot, _ = compiled()
    for storage in words[1:] or ["sqlite3", "mcap"]:
        with tempfile.TemporaryDirectory() as folder:
            long = write(Path(folder, "long"), robot, count, storage)
            print(f"{storage}, {count:,} /tf messages: {ratio(long)}")
            print(f"{storage}: peak {peak(long):.0f} MiB at {count:,} (at most 300 at 1,000,000)")


if __name__ == "__main__":
    main()

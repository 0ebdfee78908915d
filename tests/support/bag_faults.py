"""Faults that are planted in recordings, and the findings that they must give."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from rosorin_compile.model import Pose, Transform
from support import bags
from support.bags import Message, Scene, edge, ns, tf, transform_message


def backwards(_: Scene) -> dict[str, Any]:
    joint = bags.robot().joint_to["laser"]
    return {"laser": Pose(joint.origin.xyz, (0.0, 0.0, 0.0)).transform()}


def shifted() -> Transform:
    joint = bags.robot().joint_to["laser"]
    x, y, z = joint.origin.xyz
    return Pose((x + 0.01, y, z), joint.origin.rpy).transform()


def more(*added: Message) -> Callable[[list[Message]], list[Message]]:
    return lambda messages: [*messages, *added]


def without(topic: str, child: str) -> Callable[[list[Message]], list[Message]]:
    """Return a change that takes the edges into a frame out of a topic."""

    def change(messages: list[Message]) -> list[Message]:
        kept = []
        for message in messages:
            if message.topic == topic:
                rest = [t for t in message.content.transforms if t.child_frame_id != child]
                if not rest:
                    continue
                message = tf(message.received, rest, topic == "/tf_static")
            kept.append(message)
        return kept

    return change


def renamed(topic: str, child: str, new: dict[str, str]) -> Callable[[list[Message]], list[Message]]:
    """Return a change that gives the edges into a frame another parent or child."""

    def change(messages: list[Message]) -> list[Message]:
        for message in messages:
            if message.topic == topic:
                for transform in message.content.transforms:
                    if transform.child_frame_id == child:
                        transform.header.frame_id = new.get("parent", transform.header.frame_id)
                        transform.child_frame_id = new.get("child", child)
        return messages

    return change


def second_odometry(messages: list[Message]) -> list[Message]:
    """A wheel odometry that publishes odom -> base_link beside the filter, 5 cm away."""
    own = [
        edge(ns(seconds), "odom", "base_link", Pose((0.2 * seconds + 0.05, 0.1 * math.sin(seconds), 0.0)).transform())
        for seconds in bags.every(50.0, 12.0, 0.007)
    ]
    return [*messages, *own]


def second_odometry_of_the_same_kind(messages: list[Message]) -> list[Message]:
    """The filter runs twice: the same values, stamped at other times."""
    own = [
        edge(
            ns(seconds),
            "odom",
            "base_link",
            Pose((0.2 * seconds, 0.1 * math.sin(seconds), 0.0), (0.0, 0.0, 0.1 * seconds)).transform(),
        )
        for seconds in bags.every(50.0, 12.0, 0.004)
    ]
    return [*messages, *own]


def second_publisher_of_the_arm(messages: list[Message]) -> list[Message]:
    """A second robot_state_publisher that was given another URDF: link2 sits 5 mm further."""
    own = []
    for message in messages:
        for transform in message.content.transforms if message.topic == "/tf" else ():
            if transform.child_frame_id == "link2":
                t = transform.transform.translation
                pose = Transform(_rows(transform), (t.x + 0.005, t.y, t.z))
                other = transform_message(_stamp(transform), "link1", "link2", pose)
                own.append(tf(message.received + 500_000, [other]))
    return [*messages, *own]


def twice(messages: list[Message]) -> list[Message]:
    """A second robot_state_publisher with the same URDF."""
    own = [m for m in messages if m.topic == "/tf" and m.content.transforms[0].child_frame_id == "link1"]
    return [*messages, *(m._replace(received=m.received + 300_000) for m in own)]


def _stamp(transform: Any) -> int:
    stamp = transform.header.stamp
    return int(stamp.sec) * bags.SECOND + int(stamp.nanosec)


def _rows(transform: Any) -> Any:
    from rosorin_compile.model.geometry import Transform

    q = transform.transform.rotation
    return Transform.of_quaternion((0.0, 0.0, 0.0), (q.w, q.x, q.y, q.z)).rows


def on_the_other_topic(child: str, to_static: bool) -> Callable[[list[Message]], list[Message]]:
    def change(messages: list[Message]) -> list[Message]:
        here = "/tf" if to_static else "/tf_static"
        kept = without(here, child)(messages)
        source = [t for m in messages if m.topic == here for t in m.content.transforms if t.child_frame_id == child]
        if to_static:
            return [*kept, tf(ns(0.05), source[:1], still=True)]
        value = transform_of(source[0])
        return [*kept, *(edge(ns(s), source[0].header.frame_id, child, value) for s in bags.every(10.0, 12.0))]

    return change


def transform_of(message: Any) -> Transform:
    t = message.transform.translation
    return Transform(_rows(message), (t.x, t.y, t.z))


def broken_quaternions(messages: list[Message]) -> list[Message]:
    for number, message in enumerate(messages):
        if message.topic == "/tf" and message.content.transforms[0].child_frame_id == "odom" and number % 7 == 0:
            message.content.transforms[0].transform.rotation.w = math.nan
    return messages


def back_in_time(messages: list[Message]) -> list[Message]:
    """From the sixth second on, everybody stamps with a clock that is three seconds behind."""
    for message in messages:
        heads = [t.header for t in message.content.transforms] if message.topic == "/tf" else []
        heads += [message.content.header] if hasattr(message.content, "header") else []
        for head in heads:
            stamp = head.stamp.sec * bags.SECOND + head.stamp.nanosec
            if stamp > ns(6.0):
                head.stamp.sec -= 3
    return messages


def no_clock(messages: list[Message]) -> list[Message]:
    for message in messages:
        if message.topic == "/tf" and message.content.transforms[0].child_frame_id == "odom":
            message.content.transforms[0].header.stamp = bags.time(0)
    return messages


def second_driver(messages: list[Message]) -> list[Message]:
    """A joint_state_publisher beside the driver: all joints at zero."""
    own = []
    for seconds in bags.every(10.0, 12.0, 0.06):
        state = bags.joint_state(ns(seconds), bags.ARM, [0.0] * 5)
        own.append(Message(ns(seconds + 0.001), "/joint_states", "sensor_msgs/msg/JointState", state))
        joints = [joint for joint in bags.robot().joints if joint.name in bags.ARM]
        own.append(
            tf(
                ns(seconds + 0.002),
                [transform_message(ns(seconds), j.parent, j.child, j.transform(0.0)) for j in joints],
            )
        )
    return [*messages, *own]


def second_driver_with_velocities(messages: list[Message]) -> list[Message]:
    """The same, and its messages have velocities: they are longer than those of the driver."""
    own = second_driver(messages)
    for message in own[len(messages) :]:
        if message.topic == "/joint_states":
            message.content.velocity = np.zeros(5)
    return own


def gripper_of_its_own(messages: list[Message]) -> list[Message]:
    """The claw reports in messages of its own, at another rate."""
    own = []
    for seconds in bags.every(25.0, 12.0, 0.013):
        state = bags.joint_state(ns(seconds), ("r_joint",), [0.1])
        own.append(Message(ns(seconds + 0.001), "/joint_states", "sensor_msgs/msg/JointState", state))
    return [*messages, *own]


def not_a_number(messages: list[Message]) -> list[Message]:
    state = next(m for m in messages if m.topic == "/joint_states")
    state.content.position[0] = math.nan
    return messages


def second_robot() -> str:
    old = '<origin xyz="0.04662 7.5437e-05 0.16044"'
    assert old in bags.urdf()
    return bags.urdf().replace(old, '<origin xyz="0.04662 7.5437e-05 0.17044"')


OTHER_LASER = tf(ns(3.0), [transform_message(ns(-5.0), "base_link", "laser", shifted())], still=True)

# What is planted, the scene that has it, and the findings that it must give: all of them, by name. What they say
# stands in tests/data/recordings/findings.txt.
FAULTS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "localisation stops for ten seconds": ({"seconds": 20.0, "slam": lambda s: not 5.0 < s < 15.3}, ["edge-stale"]),
    "localisation stops for good": ({"slam": lambda s: s < 9.0}, ["edge-stale"]),
    "the laser frame comes after the first scan": ({"laser_from": 1.5}, ["frame-late"]),
    "the lidar is mounted backwards": (backwards(Scene()), ["mounted-backwards"]),
    "the lidar is 10 mm off": ({"laser": shifted()}, ["edge-wrong-value"]),
    "images come before the arm is known": ({"camera_delay": 0.03}, ["lookup-fails"]),
    "two odometries": ({"change": second_odometry}, ["edge-two-values"]),
    "the same odometry twice": ({"change": second_odometry_of_the_same_kind}, ["edge-published-twice"]),
    "two lasers": ({"change": more(OTHER_LASER)}, ["edge-two-values"]),
    "two robots": ({"change": second_publisher_of_the_arm}, ["edge-two-values"]),
    "the same robot twice": ({"change": twice}, ["edge-published-twice"]),
    "a frame of the driver's own": ({"camera_frame": "depth_camera_lnk"}, ["frame-unknown"]),
    "the IMU has no publisher": ({"change": without("/tf_static", "imu_link")}, ["edge-missing"]),
    "the odometry has no publisher": ({"change": without("/tf", "base_link")}, ["edge-missing"]),
    "nobody recorded what stands still": (
        {"change": lambda messages: [m for m in messages if m.topic != "/tf_static"]},
        ["recording-no-static"],
    ),
    "the IMU hangs on the laser": (
        {"change": renamed("/tf_static", "imu_link", {"parent": "laser"})},
        ["edge-wrong-parent"],
    ),
    "the laser has two parents": (
        {"change": more(tf(ns(0.1), [transform_message(ns(0), "link1", "laser", Transform())], still=True))},
        ["edge-two-parents"],
    ),
    "a frame that nobody described": (
        {"change": more(edge(ns(1.0), "base_link", "sonar", Transform(), still=True))},
        ["edge-not-described"],
    ),
    "the laser on /tf": ({"change": on_the_other_topic("laser", to_static=False)}, ["edge-not-static"]),
    "the turntable on /tf_static": ({"change": on_the_other_topic("link1", to_static=True)}, ["edge-not-moving"]),
    "the laser on both": (
        {"change": more(edge(ns(1.0), "base_link", "laser", bags.robot().joint_to["laser"].transform()))},
        ["edge-static-and-moving"],
    ),
    "quaternions that are none": ({"change": broken_quaternions}, ["not-a-rotation"]),
    "the clock is set back": ({"change": back_in_time}, ["stamp-jumps-back"]),
    "a node without a clock": ({"change": no_clock}, ["stamp-zero"]),
    "a joint that is not described": ({"joint_names": (*bags.ARM, "jaw")}, ["joint-state-unknown"]),
    "a joint that is left out": ({"joint_names": bags.ARM[:4]}, ["joint-state-missing"]),
    "a joint beyond its limits": ({"joint_offset": {"joint1": 2.0}}, ["joint-beyond-limit"]),
    "a joint that is no number": ({"change": not_a_number}, ["joint-not-a-number"]),
    "two drivers": ({"change": second_driver}, ["joint-states-two-values"]),
    "two drivers of two kinds": ({"change": second_driver_with_velocities}, ["joint-states-two-values"]),
    "another URDF": ({"description": second_robot()}, ["other-robot-description"]),
    "a URDF that is none": ({"description": "<robot"}, ["other-robot-description"]),
    "the same URDF in another text": (
        {"description": bags.urdf().replace("<joint ", "<joint  ")},
        ["robot-description-text"],
    ),
}

"""Recordings as real robots make them: verify is silent about what is no fault, and finds what is one all the same."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Pose
from support import bags
from support.bags import SECOND, START, TYPES, Message, edge, judged, ns, rules, stamped, tf, time, transform_message

Change = Callable[[list[Message]], list[Message]]
CHANCE = random.Random(5)  # noqa: S311
STATE = "sensor_msgs/msg/JointState"


def stamp_of(message: Message) -> int:
    stamp = message.content.transforms[0].header.stamp
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def simulated(speed: float, clock: bool = True) -> Change:
    """A simulation at a part of the real speed; the recorder runs on the wall clock."""

    def change(messages: list[Message]) -> list[Message]:
        made = [stamped(message, lambda at: at - START) for message in messages]
        if clock:
            kind = "rosgraph_msgs/msg/Clock"
            ticks = range(0, 12 * SECOND, SECOND // 200)
            made += [Message(START + at, "/clock", kind, TYPES[kind](time(at))) for at in ticks]
        return [message._replace(received=START + int((message.received - START) / speed)) for message in made]

    return change


def in_its_time(messages: list[Message]) -> list[Message]:
    return [
        message._replace(received=max(0, message.received - START))
        for message in (stamped(message, lambda at: at - START) for message in messages)
    ]


def played(messages: list[Message]) -> list[Message]:
    return [stamped(message, lambda at: at - 86_400 * SECOND) for message in messages]


def clock_set(messages: list[Message]) -> list[Message]:
    late = 30 * SECOND
    return [
        stamped(message, lambda at: at + late)._replace(received=message.received + late)
        if message.received > ns(6.0)
        else message
        for message in messages
    ]


def future(messages: list[Message]) -> list[Message]:
    return [stamped(message, lambda at: at + SECOND) if of(message, "odom") else message for message in messages]


def of(message: Message, child: str) -> bool:
    return message.topic == "/tf" and message.content.transforms[0].child_frame_id == child


def lost(messages: list[Message]) -> list[Message]:
    """Best effort: every twentieth message of what is not latched does not arrive."""
    latched = ("/tf_static", "/robot_description")
    return [message for message in messages if message.topic in latched or CHANCE.random() > 0.05]


def restarted(messages: list[Message]) -> list[Message]:
    again = [message for message in messages if message.topic == "/tf_static"]
    return [*messages, *(message._replace(received=message.received + 4 * SECOND) for message in again)]


def shuffled(messages: list[Message]) -> list[Message]:
    """A driver that reads its joints out of a hash: another order in each message."""
    for message in messages:
        if message.topic == "/joint_states":
            content = message.content
            order = CHANCE.sample(range(len(content.name)), len(content.name))
            content.name = [content.name[at] for at in order]
            content.position = content.position[order]
    return messages


def in_two_parts(messages: list[Message]) -> list[Message]:
    """Two drivers, each with some of the joints; robot_state_publisher publishes after each of them."""
    made = []
    for message in messages:
        if message.topic == "/joint_states":
            content = message.content
            stamp = content.header.stamp.sec * SECOND + content.header.stamp.nanosec
            for part in (slice(0, 2), slice(2, 5)):
                state = bags.joint_state(stamp, tuple(content.name[part]), list(content.position[part]))
                made.append(message._replace(content=state))
        elif of(message, "link1"):
            transforms = message.content.transforms
            made += [tf(message.received, transforms[:2]), tf(message.received, transforms[2:])]
        else:
            made.append(message)
    return made


def speeds(messages: list[Message]) -> list[Message]:
    empty, names = np.empty(0), ["joint1"]
    return messages + [
        Message(
            ns(at) + 5, "/joint_states", STATE, TYPES[STATE](bags.header(ns(at), ""), names, empty, np.ones(1), empty)
        )
        for at in bags.every(20.0, 12.0)
    ]


def trembling(spread: float, step: float) -> Change:
    """The arm holds its place; the position of one servo is noisy, in steps."""

    def change(messages: list[Message]) -> list[Message]:
        moving = [joint for joint in bags.robot().published_by(ROBOT_STATE_PUBLISHER) if joint.moves]
        said: dict[int, dict[str, float]] = {}
        made = []
        for message in messages:
            if message.topic == "/joint_states":
                noise = CHANCE.gauss(0.0, spread)
                content = message.content
                content.position = np.array([0.1 + (round(noise / step) * step if step else noise), 0.2, 0.3, 0.1, 0.2])
                stamp = content.header.stamp.sec * SECOND + content.header.stamp.nanosec
                said[stamp] = dict(zip(content.name, content.position, strict=True))
            elif of(message, "link1"):
                at = stamp_of(message)
                parts = [bags._joint(at, joint, said[at][joint.name]) for joint in moving]
                message = tf(message.received, parts)
            made.append(message)
        return made

    return change


def noisy_map(x: float, yaw: float) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        made = []
        for message in messages:
            if of(message, "odom"):
                pose = Pose((0.5 + CHANCE.gauss(0, x), -0.2, 0.0), (0.0, 0.0, CHANCE.gauss(0, yaw)))
                message = edge(stamp_of(message), "map", "odom", pose.transform())
            made.append(message)
        return made

    return change


def depth_camera(messages: list[Message]) -> list[Message]:
    frames = [("camera_link", f"camera_{eye}_frame") for eye in ("color", "depth", "infra1")]
    frames += [(child, child.replace("_frame", "_optical_frame")) for _, child in frames]
    parts = [transform_message(ns(-3.0), parent, child, Pose().transform()) for parent, child in frames]
    return [*messages, tf(ns(0.02), parts, still=True)]


def wheels(messages: list[Message]) -> list[Message]:
    for message in messages:
        if message.topic == "/joint_states":
            message.content.name = [*message.content.name, *(f"wheel{number}" for number in range(4))]
            message.content.position = np.append(message.content.position, np.zeros(4))
    return messages


def booting(messages: list[Message]) -> list[Message]:
    """For 4 s there is only the IMU; what was latched before was not recorded."""
    return [message for message in messages if message.topic == "/imu/data" or message.received > ns(4.0)]


HABITS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "a simulation": ({"change": simulated(1.0)}, ["recording-other-clock"]),
    "a slow simulation": ({"change": simulated(0.4)}, ["recording-other-clock"]),
    "a slow simulation without its clock": ({"change": simulated(0.4, clock=False)}, ["recording-other-clock"]),
    "a simulation in its own time": ({"change": in_its_time}, []),
    "a bag that is played": ({"change": played}, ["recording-other-clock"]),
    "a clock that is set forward": ({"change": clock_set}, ["recording-silent"]),
    "localisation ahead of time": ({"change": future}, []),
    "localisation ahead of time, in a simulation": (
        {"change": lambda messages: simulated(0.9, clock=False)(future(messages))},
        ["recording-other-clock"],
    ),
    "messages are lost": ({"change": lost}, []),
    "nodes start again": ({"change": restarted}, []),
    "joints in any order": ({"change": shuffled}, []),
    "joint states of two nodes": ({"change": in_two_parts}, []),
    "joint states of a motor": ({"change": speeds}, []),
    "a noisy joint": ({"change": trembling(0.03, 0.0)}, []),
    "a servo that trembles": ({"change": trembling(0.006, 0.0084)}, []),
    "a map that jumps to and fro": ({"change": noisy_map(0.02, 0.0)}, []),
    "a map that turns to and fro": ({"change": noisy_map(0.0, 0.02)}, []),
    "a camera with frames of its own": ({"change": depth_camera}, ["edge-not-described"]),
    "four wheels that nobody described": ({"change": wheels}, ["joint-state-unknown"]),
    "a robot that boots": ({"change": booting}, ["recording-no-static", "edge-late", "edge-late", "edge-late"]),
    "localisation that is started by hand": ({"slam": lambda seconds: seconds > 5.0}, ["edge-late"]),
    "a simulation whose localisation stops": (
        {"seconds": 20.0, "slam": lambda seconds: not 5.0 < seconds < 15.3, "change": simulated(0.5, clock=False)},
        ["edge-stale", "recording-other-clock"],
    ),
    "a simulation with the lidar backwards": (
        {"laser": Pose((0.048156, 0.000076, 0.106748)).transform(), "change": simulated(0.5)},
        ["mounted-backwards", "recording-other-clock"],
    ),
    "a bag that is played, with slow joint states": (
        {"camera_delay": 0.03, "change": played},
        ["lookup-fails", "recording-other-clock"],
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", HABITS)
def test_what_real_robots_record(tmp_path: Path, name: str) -> None:
    scene, expected = HABITS[name]
    CHANCE.seed(name)
    verdict = judged(bags.bag(tmp_path / "bag", "mcap" if len(name) % 2 else "sqlite3", **scene))
    assert rules(verdict) == expected, [finding.message for finding in verdict.findings]


def test_a_slow_simulation_is_as_old_as_its_own_clock_says(tmp_path: Path) -> None:
    """Ages and times are those of the simulation: the same as of a robot that is not simulated."""
    real = judged(bags.bag(tmp_path / "real"))
    slow = judged(bags.bag(tmp_path / "slow", change=simulated(0.25)))
    for key, series in real.data.series.items():
        if not series.static:
            pace = slow.data.series[key].pace
            assert pace.mean_age == pytest.approx(series.pace.mean_age, abs=0.006)
            assert pace.gap.seconds == pytest.approx(series.pace.gap.seconds, abs=0.012)
            assert pace.rate == pytest.approx(series.pace.rate, rel=0.01)


def fleet(unprefixed: str = "") -> list[Message]:
    """Two robots on one /tf: all frames have a prefix but the map, and topics of sensors a namespace."""
    said = []
    for robot in ("r1/", "r2/"):
        for message in bags.messages(bags.Scene(seconds=3.0)):
            content = message.content
            for transform in getattr(content, "transforms", []):
                if transform.header.frame_id != "map":
                    transform.header.frame_id = robot + transform.header.frame_id
                transform.child_frame_id = robot + transform.child_frame_id
            if getattr(getattr(content, "header", None), "frame_id", "") not in ("", unprefixed):
                content.header.frame_id = robot + content.header.frame_id
            shared = message.topic in ("/tf", "/tf_static")
            said.append(message if shared else message._replace(topic=f"/{robot}{message.topic[1:]}"))
    return sorted(said, key=lambda message: message.received)


def test_one_robot_of_a_fleet(tmp_path: Path) -> None:
    bag = bags.write(tmp_path / "bag", fleet())
    for number in (1, 2):
        assert judged(bag, namespace=f"r{number}", prefix=f"r{number}/").findings == ()
    forgotten = bags.write(tmp_path / "forgotten", fleet(unprefixed="laser"))
    findings = judged(forgotten, namespace="r1", prefix="r1/").findings
    assert {finding.rule for finding in findings} == {"frame-unknown"}
    assert findings[0].message == (
        '/r1/scan is stamped "laser without r1/" (27 messages), a frame that is neither described nor published'
    )

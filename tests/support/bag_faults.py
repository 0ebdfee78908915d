"""What is done to recordings, by name. The findings of each are in tests/data/recordings/findings.txt."""

import copy
import math
import random
from collections.abc import Callable
from typing import Any

import numpy as np

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Pose, Transform
from support import bags
from support.bags import ARM, SECOND, START, TYPES, Message, edge, every, ns, stamped, tf, time, transform_message

Change = Callable[[list[Message]], list[Message]]
Stamp = Callable[[int], int]
CHANCE = random.Random(5)  # noqa: S311
STATE, CLOCK = "sensor_msgs/msg/JointState", "rosgraph_msgs/msg/Clock"
HERE = Transform()
LASER = bags.robot().joint_to["laser"]


def of(message: Message, name: str) -> bool:
    """Return True for a message of a topic, or of /tf whose first transform leads into a frame."""
    return name in (message.topic, message.content.transforms[0].child_frame_id if message.topic == "/tf" else "")


def stamp_of(header: Any) -> int:
    return int(header.stamp.sec) * SECOND + int(header.stamp.nanosec)


def moved(transform: Any, x: float = 0.0) -> Transform:
    """Return the value of a message of a transform, moved along x (m)."""
    at, q = transform.transform.translation, transform.transform.rotation
    return Transform.of_quaternion((at.x + x, at.y, at.z), (q.w, q.x, q.y, q.z))


def state(seconds: float, names: tuple[str, ...], values: list[float], delay: float = 0.001) -> Message:
    return Message(ns(seconds + delay), "/joint_states", STATE, bags.joint_state(ns(seconds), names, values))


# Changes of messages.


def both(*changes: Change) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        for one in changes:
            messages = one(messages)
        return messages

    return change


def more(*added: Message) -> Change:
    return lambda messages: [*messages, *added]


def without(topic: str, child: str) -> Change:
    """Take the edges into a frame out of a topic."""

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


def parent(topic: str, child: str, name: str) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        for message in (message for message in messages if message.topic == topic):
            for transform in (one for one in message.content.transforms if one.child_frame_id == child):
                transform.header.frame_id = name
        return messages

    return change


def on_the_other_topic(child: str, to_static: bool) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        here = "/tf" if to_static else "/tf_static"
        kept = without(here, child)(messages)
        source = [t for m in messages if m.topic == here for t in m.content.transforms if t.child_frame_id == child]
        if to_static:
            return [*kept, tf(ns(0.05), source[:1], still=True)]
        name = source[0].header.frame_id
        return [*kept, *(edge(ns(at), name, child, moved(source[0])) for at in every(10.0, 12.0))]

    return change


def node(names: set[str], new: Stamp, since: float = -99.0, until: float = 99.0) -> Change:
    """Give messages of some topics or frames other stamps."""

    def change(messages: list[Message]) -> list[Message]:
        for message in messages:
            if any(of(message, name) for name in names) and ns(since) < message.received <= ns(until):
                stamped(message, new)
        return messages

    return change


def all_stamps(new: Stamp) -> Change:
    return lambda messages: [stamped(message, new) for message in messages]


def by(seconds: float) -> Stamp:
    return lambda at: at + round(seconds * SECOND)


def received(new: Stamp) -> Change:
    return lambda messages: [message._replace(received=new(message.received)) for message in messages]


def frame(topic: str, name: str, each: int = 1) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        for message in [message for message in messages if message.topic == topic][::each]:
            message.content.header.frame_id = name
        return messages

    return change


def prefixed(prefix: str, but: str = "", headers: bool = True, namespace: str = "") -> Change:
    """All frames have a prefix, but for one; those of other messages may lack it. Topics may have a namespace."""

    def change(messages: list[Message]) -> list[Message]:
        for message in messages:
            heads = [transform.header for transform in getattr(message.content, "transforms", ())]
            for transform in getattr(message.content, "transforms", ()):
                transform.child_frame_id = prefix + transform.child_frame_id
            head = getattr(message.content, "header", None)
            heads += [head] if headers and head is not None and head.frame_id else []
            for one in heads:
                one.frame_id = one.frame_id if one.frame_id == but else prefix + one.frame_id
        return [message._replace(topic=f"{namespace}{message.topic}") for message in messages]

    return change


def simulated(speed: float = 1.0, clock: float = 200.0) -> Change:
    """A simulation at a part of the real speed, with /clock at a rate or 0; the recorder runs on the wall clock."""

    def change(messages: list[Message]) -> list[Message]:
        made = all_stamps(lambda at: at - START)(messages)
        ticks = [int(at * SECOND) for at in every(clock, 12.0)] if clock else []
        made += [Message(START + at, "/clock", CLOCK, TYPES[CLOCK](time(at))) for at in ticks]
        return received(lambda at: START + int((at - START) / speed))(made)

    return change


def all_but_the_imu(change: Change) -> Change:
    def changed(messages: list[Message]) -> list[Message]:
        kept = copy.deepcopy([message for message in messages if message.topic == "/imu/data"])
        return change([message for message in messages if message.topic != "/imu/data"]) + kept

    return changed


# Second nodes.


def odometry(rate: float, phase: float, x: float = 0.0, yaw: float = 0.0) -> Change:
    """A second odometry that publishes odom -> base_link, beside the filter or as the filter does."""
    poses = (
        (at, Pose((0.2 * at + x, 0.1 * math.sin(at), 0.0), (0.0, 0.0, yaw * at))) for at in every(rate, 12.0, phase)
    )
    return more(*[edge(ns(at), "odom", "base_link", pose.transform()) for at, pose in poses])


def second_publisher_of_the_arm(messages: list[Message]) -> list[Message]:
    """A second robot_state_publisher that was given another URDF: link2 is 5 mm further."""
    own = []
    for message in messages:
        for one in message.content.transforms if message.topic == "/tf" else ():
            if one.child_frame_id == "link2":
                other = transform_message(stamp_of(one.header), "link1", "link2", moved(one, 0.005))
                own.append(tf(message.received + 500_000, [other]))
    return [*messages, *own]


def twice(messages: list[Message]) -> list[Message]:
    """A second robot_state_publisher with the same URDF."""
    return [*messages, *(m._replace(received=m.received + 300_000) for m in messages if of(m, "link1"))]


def second_driver(velocities: bool) -> Change:
    """A joint_state_publisher beside the driver: all joints at zero, perhaps with velocities."""
    own = []
    for seconds in every(10.0, 12.0, 0.06):
        message = state(seconds, ARM, [0.0] * 5)
        message.content.velocity = np.zeros(5 if velocities else 0)
        joints = [joint for joint in bags.robot().joints if joint.name in ARM]
        values = [transform_message(ns(seconds), j.parent, j.child, j.transform(0.0)) for j in joints]
        own += [message, tf(ns(seconds + 0.002), values)]
    return more(*own)


def in_two_parts(messages: list[Message]) -> list[Message]:
    """Two drivers, each with some of the joints; robot_state_publisher publishes after each of them."""
    made = []
    for message in messages:
        content = message.content
        if message.topic == "/joint_states":
            for part in (slice(0, 2), slice(2, 5)):
                values = list(content.position[part])
                said = bags.joint_state(stamp_of(content.header), tuple(content.name[part]), values)
                made.append(message._replace(content=said))
        elif of(message, "link1"):
            made += [tf(message.received, content.transforms[:2]), tf(message.received, content.transforms[2:])]
        else:
            made.append(message)
    return made


def merged(messages: list[Message]) -> list[Message]:
    """A scan that is made of others, in the frame of the body."""
    scans = [message for message in messages if message.topic == "/scan"]
    contents = [bags.scan(bags.header(message.received, "base_link")) for message in scans]
    return messages + [m._replace(topic="/merged", content=made) for m, made in zip(scans, contents, strict=True)]


# Values.


def broken_quaternions(messages: list[Message]) -> list[Message]:
    for number, message in enumerate(messages):
        if of(message, "odom") and number % 7 == 0:
            message.content.transforms[0].transform.rotation.w = math.nan
    return messages


def not_a_number(messages: list[Message]) -> list[Message]:
    next(m for m in messages if m.topic == "/joint_states").content.position[0] = math.nan
    return messages


def shuffled(messages: list[Message]) -> list[Message]:
    """A driver that reads its joints out of a hash: another order in each message."""
    for content in (message.content for message in messages if message.topic == "/joint_states"):
        order = CHANCE.sample(range(len(content.name)), len(content.name))
        content.name, content.position = [content.name[at] for at in order], content.position[order]
    return messages


def wheels(messages: list[Message]) -> list[Message]:
    for content in (message.content for message in messages if message.topic == "/joint_states"):
        content.name = [*content.name, *(f"wheel{number}" for number in range(4))]
        content.position = np.append(content.position, np.zeros(4))
    return messages


def speeds(seconds: float) -> Message:
    empty = np.empty(0)
    content = TYPES[STATE](bags.header(ns(seconds), ""), ["joint1"], empty, np.ones(1), empty)
    return Message(ns(seconds) + 5, "/joint_states", STATE, content)


def trembling(spread: float, step: float) -> Change:
    """The arm holds its place; the position of one servo is noisy, in steps."""

    def change(messages: list[Message]) -> list[Message]:
        moving = [joint for joint in bags.robot().published_by(ROBOT_STATE_PUBLISHER) if joint.moves]
        said: dict[int, dict[str, float]] = {}
        for number, message in enumerate(messages):
            content = message.content
            if message.topic == "/joint_states":
                noise = CHANCE.gauss(0.0, spread)
                content.position = np.array([0.1 + (round(noise / step) * step if step else noise), 0.2, 0.3, 0.1, 0.2])
                said[stamp_of(content.header)] = dict(zip(content.name, content.position, strict=True))
            elif of(message, "link1"):
                at = stamp_of(content.transforms[0].header)
                parts = [bags._joint(at, joint, said[at][joint.name]) for joint in moving]
                messages[number] = tf(message.received, parts)
        return messages

    return change


def noisy_map(x: float, yaw: float) -> Change:
    def change(messages: list[Message]) -> list[Message]:
        for number, message in enumerate(messages):
            if of(message, "odom"):
                pose = Pose((0.5 + CHANCE.gauss(0, x), -0.2, 0.0), (0.0, 0.0, CHANCE.gauss(0, yaw)))
                stamp = stamp_of(message.content.transforms[0].header)
                messages[number] = edge(stamp, "map", "odom", pose.transform())
        return messages

    return change


def depth_camera() -> Change:
    frames = [("camera_link", f"camera_{eye}_frame") for eye in ("color", "depth", "infra1")]
    frames += [(child, child.replace("_frame", "_optical_frame")) for _, child in frames]
    return more(tf(ns(0.02), [transform_message(ns(-3.0), above, child, HERE) for above, child in frames], still=True))


# Times of arrival.


def lost(messages: list[Message]) -> list[Message]:
    """Best effort: every twentieth message of what is not latched does not arrive."""
    latched = ("/tf_static", "/robot_description")
    return [message for message in messages if message.topic in latched or CHANCE.random() > 0.05]


def restarted(messages: list[Message]) -> list[Message]:
    again = [message for message in messages if message.topic == "/tf_static"]
    return [*messages, *(message._replace(received=message.received + 4 * SECOND) for message in again)]


def busy_network(messages: list[Message]) -> list[Message]:
    made, last = [], 0
    for message in messages:
        if message.topic == "/camera/depth/image":
            late = 0.7 if ns(4.0) < message.received < ns(6.0) else CHANCE.uniform(0.0, 0.08)
            last = max(last + 1, message.received + round(late * SECOND))
            message = message._replace(received=last)
        made.append(message)
    return made


def drifting(messages: list[Message]) -> list[Message]:
    for message in messages:
        if of(message, "base_link"):
            stamped(message, by(0.08 * (message.received - START) / SECOND))
    return messages


def from_the_sixth_second(stamp: float, arrival: float) -> Change:
    """All stamps, and times of arrival, are later by some seconds from the sixth second on."""

    def change(messages: list[Message]) -> list[Message]:
        return [
            stamped(message, by(stamp))._replace(received=by(arrival)(message.received))
            if message.received > ns(6.0)
            else message
            for message in messages
        ]

    return change


def without_battery(at: int) -> int:
    return at if at > ns(6.0) else at - START + 50 * SECOND


def back_in_time(at: int) -> int:
    return at - 3 * SECOND if at > ns(6.0) else at


def second_robot() -> str:
    old = '<origin xyz="0.04662 7.5437e-05 0.16044"'
    assert old in bags.urdf()
    return bags.urdf().replace(old, '<origin xyz="0.04662 7.5437e-05 0.17044"')


def stopping(seconds: float) -> bool:
    return not 5.0 < seconds < 15.3


SHIFTED = Pose((LASER.origin.xyz[0] + 0.01, *LASER.origin.xyz[1:]), LASER.origin.rpy).transform()
BACKWARDS = Pose(LASER.origin.xyz, (0.0, 0.0, 0.0)).transform()
OTHER_LASER = tf(ns(3.0), [transform_message(ns(-5.0), "base_link", "laser", SHIFTED)], still=True)
BOOT = 50 - START / SECOND  # s from the time of the recording to that of a clock which began in 1970
NAMELESS = (edge(ns(1.0), "", "laser", HERE), edge(ns(1.1), "laser", "/", HERE), edge(ns(1.2), "", "", HERE))

# Each scene by its name: what is unusual in it.
SCENES: dict[str, dict[str, Any]] = {
    "nothing": {},
    "localisation stops for ten seconds": {"seconds": 20.0, "slam": stopping},
    "localisation stops for good": {"slam": lambda s: s < 9.0},
    "localisation is started by hand": {"slam": lambda seconds: seconds > 5.0},
    "the laser frame comes after the first scan": {"laser_from": 1.5},
    "the lidar is mounted backwards": {"laser": BACKWARDS},
    "the lidar is 10 mm off": {"laser": SHIFTED},
    "images come before the arm is known": {"camera_delay": 0.03},
    "another URDF": {"description": second_robot()},
    "a URDF that is none": {"description": "<robot"},
    "the same URDF in another text": {"description": bags.urdf().replace("<joint ", "<joint  ")},
    "a joint that is not described": {"joint_names": (*ARM, "jaw")},
    "a joint that is left out": {"joint_names": ARM[:4]},
    "a joint beyond its limits": {"joint_offset": {"joint1": 2.0}},
    "a frame of the driver's own": {"camera_frame": "depth_camera_lnk"},
    "another eye of the camera": {"camera_frame": "rgb_camera_link"},
    "a simulation whose localisation stops": {"seconds": 20.0, "slam": stopping, "change": simulated(0.5, clock=0)},
    "a simulation with the lidar backwards": {"laser": BACKWARDS, "change": simulated(0.5)},
    "a bag that is played, with slow joint states": {"camera_delay": 0.03, "change": all_stamps(by(-86_400))},
}
CHANGES: dict[str, Change] = {
    # Publishers.
    "two odometries": odometry(50.0, 0.007, x=0.05),
    "the same odometry twice": odometry(50.0, 0.004, yaw=0.1),
    "two lasers": more(OTHER_LASER),
    "two robots": second_publisher_of_the_arm,
    "the same robot twice": twice,
    "the IMU has no publisher": without("/tf_static", "imu_link"),
    "the odometry has no publisher": without("/tf", "base_link"),
    "nobody recorded what stands still": lambda messages: [m for m in messages if m.topic != "/tf_static"],
    "the IMU hangs on the laser": parent("/tf_static", "imu_link", "laser"),
    "the laser has two parents": more(tf(ns(0.1), [transform_message(ns(0), "link1", "laser", HERE)], still=True)),
    "a frame that nobody described": more(edge(ns(1.0), "base_link", "sonar", HERE, still=True)),
    "a camera with frames of its own": depth_camera(),
    "the laser on /tf": on_the_other_topic("laser", to_static=False),
    "the turntable on /tf_static": on_the_other_topic("link1", to_static=True),
    "the laser on both": more(edge(ns(1.0), "base_link", "laser", LASER.transform())),
    "quaternions that are none": broken_quaternions,
    "nodes start again": restarted,
    "a robot that boots": lambda messages: [m for m in messages if m.topic == "/imu/data" or m.received > ns(4.0)],
    "messages are lost": lost,
    "a network that is busy": busy_network,
    "a map that jumps to and fro": noisy_map(0.02, 0.0),
    "a map that turns to and fro": noisy_map(0.0, 0.02),
    # Joint states.
    "a joint that is no number": not_a_number,
    "two drivers": second_driver(velocities=False),
    "two drivers of two kinds": second_driver(velocities=True),
    "a gripper that reports by itself": more(*[state(at, ("r_joint",), [0.1]) for at in every(25.0, 12.0, 0.013)]),
    "joints in any order": shuffled,
    "joint states of two nodes": in_two_parts,
    "joint states of a motor": more(*[speeds(at) for at in every(20.0, 12.0)]),
    "four wheels that nobody described": wheels,
    "a noisy joint": trembling(0.03, 0.0),
    "a servo that trembles": trembling(0.006, 0.0084),
    # Clocks.
    "the clock is set back": all_stamps(back_in_time),
    "a node without a clock": node({"odom"}, lambda _: 0),
    "AMCL dates a second ahead": node({"odom"}, by(1.0)),
    "slam_toolbox dates half a second ahead": node({"odom"}, by(0.5)),
    "localisation, too far ahead": node({"odom"}, by(1.502)),
    "localisation ahead, in a simulation": both(node({"odom"}, by(1.0)), simulated(0.9, clock=0)),
    "a computer, 3 s behind": node({"base_link"}, by(-3.0)),
    "a computer, a minute ahead": node({"base_link"}, by(60.0)),
    "a computer, an hour ahead": node({"base_link"}, by(3600.0)),
    "a computer, an hour behind": node({"base_link"}, by(-3600.0)),
    "the arm and its computer ahead": node({"link1", "/joint_states"}, by(30.0)),
    "a scanner ahead": node({"/scan"}, by(3.01)),
    "two computers ahead": both(node({"base_link"}, by(20.0)), node({"/scan"}, by(3.01))),
    "the clock of the recorder is behind": all_stamps(by(30.0)),
    "a clock that is set forward": node({"base_link"}, by(0.6), since=6.0),
    "all clocks are set forward": from_the_sixth_second(30.0, 30.0),
    "a clock that drifts": drifting,
    "a clock that hears the time late": node({"base_link"}, by(BOOT), until=6.0),
    "the clock of the recorder is set": from_the_sixth_second(0.0, 30.0),
    "a computer without a battery": both(all_stamps(without_battery), received(without_battery)),
    "a recorder without a battery": received(lambda at: at - START + 50 * SECOND),
    "one node with the time of a simulation": node({"base_link", "/scan"}, by(-START / SECOND)),
    "all nodes but one": all_but_the_imu(all_stamps(by(-START / SECOND))),
    "a simulation": simulated(),
    "a slow simulation": simulated(0.4),
    "a slow simulation without its clock": simulated(0.4, clock=0),
    "a simulation in its own time": both(all_stamps(lambda at: at - START), received(lambda at: max(0, at - START))),
    "a simulation, and a driver without use_sim_time": all_but_the_imu(simulated(clock=50.0)),
    "a clock that nobody listens to": lambda messages: messages + simulated(clock=50.0)([]),
    "a bag that is played": all_stamps(by(-86_400)),
    "no stamps at all": all_stamps(lambda _: 0),
    "one stamp that is none": node({"base_link"}, lambda _: 0, since=5.0, until=5.01),
    # Names of frames.
    "a slash": frame("/scan", "/laser"),
    "a slash in some": frame("/scan", "/laser", each=2),
    "a slash, and no such frame": frame("/scan", "/lasr"),
    "the frame of the body": frame("/scan", "base_link"),
    "two frames in each other's place": both(frame("/scan", "imu_link"), frame("/imu/data", "laser")),
    "a frame that others publish": both(
        frame("/scan", "lidar_frame"), more(edge(ns(0.01), "base_link", "lidar_frame", HERE, still=True))
    ),
    "a scan that is made of others": merged,
    "a frame under itself": more(*[edge(ns(at), "laser", "laser", HERE) for at in range(1, 6)]),
    "a frame under itself, with a slash": more(edge(ns(1.0), "laser", "/laser", HERE, still=True)),
    "a frame under itself alone": both(
        without("/tf_static", "laser"), more(edge(ns(1.0), "laser", "laser", HERE, still=True))
    ),
    "names that are empty": more(*NAMELESS),
    "a slash before all transforms": prefixed("/", headers=False),
}
SCENES |= {name: {"change": change} for name, change in CHANGES.items()}

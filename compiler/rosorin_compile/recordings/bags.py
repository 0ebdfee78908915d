"""Bags: rosbag2 recordings. rosbags reads the files and deserializes the messages, one after the other.

``topics_of`` selects the topics that are compared. ``Clock`` converts times of arrival to the clock of the stamps where
the recorder had another one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.source.diagnostics import NOTE, WARNING
from rosorin_compile.source.files import is_file, is_folder
from rosorin_compile.source.installing import pip_install
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND, Times
from .findings import YEAR, problem, seconds
from .pace import APART
from .recording import Batch, Recording

RULES = (
    Rule(
        "recording-type",
        "A topic has the name of one that is looked at, and another type.",
        "Rename it.",
        Heading.RECORDINGS,
    ),
    Rule(
        "recording-other-clock",
        "A warning, or a note with `/clock`: all stamps are of another clock than that of the recorder, as in a "
        "simulation or in a bag that was played. Ages are told by the clock of the stamps.",
        "`ros2 bag record --use-sim-time`; or set the clocks of the computers.",
        Heading.RECORDINGS,
    ),
)


BAGS = (".mcap", ".db3")
BATCH = 16_384
FAR = 2**62  # ns; no clock shows that

Progress = Callable[[int, int], None]


class Unreadable(Exception):
    """A recording cannot be read; ``help`` is what to do about it."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


def _damaged(path: Path, wrong: Exception, where: str = "") -> Unreadable:
    """Return the error for whatever rosbags raised: damaged files make it fail in many ways."""
    reason = " ".join(str(wrong).split())[:300].rstrip(".") or type(wrong).__name__
    help = "if the recorder was killed or a copy is incomplete, ros2 bag reindex FOLDER may help; else record again"
    if path.suffix == ".mcap" or sorted(path.glob("*.mcap")):
        help = "if the recorder was killed or a copy is incomplete, mcap recover FILE may help; else record again"
    return Unreadable(f"{path} cannot be read: {where}{reason}", help)


class Part(NamedTuple):
    """An open rosbag2 folder or file: number of messages, time of the first and the last (ns), topics by connection."""

    reader: Any
    path: Path
    messages: int
    start: int
    end: int
    topics: dict[int, Topic]


def read(paths: Sequence[Path], recording: Recording, progress: Progress) -> None:
    """Read a rosbag2 folder, or the files of one that has no metadata.yaml, into a recording. Raises Unreadable."""
    with ExitStack() as stack:
        parts = [part for path in paths for part in _open(path, recording, stack)]
        parts = sorted((part for part in parts if part.messages), key=lambda part: part.start)
        if parts:
            _read_all(parts, recording, progress)
    recording.finish()


def _open(path: Path, recording: Recording, stack: ExitStack) -> list[Part]:
    """Open a rosbag2 folder or file. Raises Unreadable."""
    try:
        from rosbags.rosbag2 import Reader
    except ImportError:
        help = pip_install("verify")
        raise Unreadable("reading a recording needs the package rosbags, which is not installed", help) from None
    try:
        reader: Any = stack.enter_context(Reader(path))
        files = getattr(reader.storage, "storages", None) or [reader.storage]
        if reader.compression_mode == "message":  # which the folder alone decompresses
            _check_topics(reader, files)
            files = [reader.storage]
        # Otherwise file by file: of a folder rosbags skips the topics about which metadata.yaml contradicts the files.
        return [_part(file, path if reader.compression_mode else file.path, recording) for file in files]
    except Exception as wrong:
        if is_folder(path):  # rosbags does not name the file of a folder that it cannot read
            for inner in sorted(path.iterdir()):
                if inner.suffix in BAGS and is_file(inner):
                    _open(inner, recording, stack)
        raise _damaged(path, wrong) from None


def _part(reader: Any, path: Path, recording: Recording) -> Part:
    """Return a part with the number and the times of its messages. Raises ValueError for impossible ones."""
    messages, start, end = reader.metadata.message_count, reader.metadata.start_time, reader.metadata.end_time
    if messages and not -FAR < start <= end <= FAR:
        raise ValueError("its first or its last time is beyond all clocks")
    return Part(reader, path, messages, start, end, topics_of(reader, recording))


def _check_topics(reader: Any, files: Sequence[Any]) -> None:
    """Raise ValueError if a file has topics that metadata.yaml does not have: rosbags skips their messages."""
    listed = [(one.topic, one.msgtype, one.ext, digest) for one in reader.connections for digest in ("", one.digest)]
    for one in (connection for file in files for connection in file.connections):
        if (one.topic, one.msgtype, one.ext, one.digest) not in listed:
            raise ValueError(f"metadata.yaml contradicts the files about {one.topic}")


def _read_all(parts: Sequence[Part], recording: Recording, progress: Progress) -> None:
    """Read all parts between the two requested times; of latched topics also what came before."""
    options = recording.description.options
    first, end = parts[0].start, max(part.end for part in parts)
    start = first if options.since is None else first + int(options.since * SECOND)
    stop = None if options.until is None else first + int(options.until * SECOND)
    if start > end > first:
        long = f"{(end - first) / SECOND:.1f} s long"
        raise Unreadable(f"--since {options.since:g} is behind the end of the recording, which is {long}")
    recording.span(start, start)
    reading = _Reading(recording, progress, sum(part.messages for part in parts))
    if start > first:
        for part in parts:
            latched = {key: topic for key, topic in part.topics.items() if topic.kind in (TF_STATIC, ROBOT)}
            reading.read(part, latched, None, start)
        recording.begin_at(start)
    for part in parts:
        reading.read(part, part.topics, start if start > first else None, stop)


def _messages(
    part: Part, topics: dict[int, Topic], start: int | None, stop: int | None
) -> Iterator[tuple[Topic, int, Any]]:
    """Yield topic, time of arrival (ns) and content of messages; of sensors the header alone. Raises Unreadable."""
    from rosbags.typesys import Stores, get_typestore

    connections = [connection for connection in part.reader.connections if connection.id in topics]
    if not connections:  # no connections are all connections for rosbags
        return
    store, where = get_typestore(Stores.ROS2_HUMBLE), ""
    try:
        for connection, received, raw in part.reader.messages(connections, start=start, stop=stop):
            topic = topics[connection.id]
            where = f"a message of {topic.name}: "
            if not -FAR < received < FAR:
                raise ValueError("its time is beyond all clocks")
            if topic.kind == HEADER:
                length = int.from_bytes(raw[12:16], "little" if raw[1] else "big")
                yield topic, received, store.deserialize_cdr(raw[: 16 + length], TYPES[HEADER])
            else:
                yield topic, received, store.deserialize_cdr(raw, topic.type)
            where = ""
    except Exception as wrong:
        raise _damaged(part.path, wrong, where) from None


class _Reading:
    """Reads the parts of a recording in batches."""

    def __init__(self, recording: Recording, progress: Progress, count: int) -> None:
        self.recording, self.progress, self.count = recording, progress, count
        self.clock = Clock(recording)
        self.batch, self.topics, self.stamps = Batch(), list[Topic](), list[int]()

    def read(self, part: Part, topics: dict[int, Topic], start: int | None, stop: int | None) -> None:
        """Read some topics of a part between two times (ns)."""
        for topic, received, content in _messages(part, topics, start, stop):
            self.batch.received.append(received)
            self.topics.append(topic)
            self.stamps.append(self._add(topic, content))
            if len(self.topics) >= BATCH:
                self._finish_batch(len(topics))
        self._finish_batch(len(topics))

    def _add(self, topic: Topic, content: Any) -> int:
        """Add a message to the batch; return its first stamp (ns), zero if the message has none of its time."""
        if topic.kind in (TF, TF_STATIC):
            frame, stamps = self.recording.tree_frame, []
            for one in content.transforms:
                key = (topic.kind == TF_STATIC, frame(one.header.frame_id), frame(one.child_frame_id))
                stamps.append(_ns(one.header.stamp))
                at, turn = one.transform.translation, one.transform.rotation
                self.batch.add_transform(key, stamps[-1], (at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w))
            return stamps[0] if stamps and topic.kind == TF else 0
        if topic.kind == ROBOT:
            self.recording.add_description(content.data.encode())
            return 0
        if topic.kind == CLOCK:
            return _ns(content.clock)
        if topic.kind == JOINTS:
            self.batch.add_state(content.name, content.position.tolist(), stamp := _ns(content.header.stamp))
            return stamp
        stamp = _ns(content.stamp)
        self.batch.add_header(topic.name, topic.type, self.recording.frame(content.frame_id), stamp)
        if content.frame_id.startswith("/"):
            self.batch.add_slash(topic.name, self.recording.frame(content.frame_id))
        return stamp

    def _finish_batch(self, topics: int) -> None:
        """Hand a batch on to the recording, and begin another one."""
        batch, recording = self.batch, self.recording
        if batch.received:
            received = np.array(batch.received, np.int64)
            received = self.clock.convert(received, np.array(self.stamps, np.int64), self.topics)
            recording.messages += len(received)
            recording.came(received, topics)
            recording.span(int(received.min()), int(received.max()))
            recording.take(batch, received)
            self.progress(recording.messages, self.count)
        self.batch, self.topics, self.stamps = Batch(), [], []


def _ns(stamp: Any) -> int:
    return int(stamp.sec * SECOND + stamp.nanosec)


TF, TF_STATIC, JOINTS, ROBOT, HEADER, CLOCK = range(6)
TYPES = {
    TF: "tf2_msgs/msg/TFMessage",
    TF_STATIC: "tf2_msgs/msg/TFMessage",
    JOINTS: "sensor_msgs/msg/JointState",
    ROBOT: "std_msgs/msg/String",
    HEADER: "std_msgs/msg/Header",
    CLOCK: "rosgraph_msgs/msg/Clock",
}
TOPICS = {"tf": TF, "tf_static": TF_STATIC, "joint_states": JOINTS, "robot_description": ROBOT, "clock": CLOCK}
# Their frame_id, if there is one, is no place.
NOT_PLACED = {
    f"sensor_msgs/msg/{name}" for name in ("JointState", "Joy", "BatteryState", "TimeReference", "Temperature")
}
NOT_PLACED |= {"diagnostic_msgs/msg/DiagnosticArray"}


class Topic(NamedTuple):
    """A topic that is read: what kind of messages it has, its name and their type."""

    kind: int
    name: str
    type: str


def topics_of(reader: Any, recording: Recording) -> dict[int, Topic]:
    """Return the topics that are read, by the id of their connection in the bag."""
    from rosbags.typesys import Stores, get_typestore

    known = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    namespace = recording.description.options.namespace.strip("/")
    names = {f"/{name}": kind for name, kind in TOPICS.items()}
    if namespace:
        names |= {f"/{namespace}/{name}": kind for name, kind in TOPICS.items()}
    topics: dict[int, Topic] = {}
    for connection in reader.connections:
        if not isinstance(connection.topic, str) or not isinstance(connection.msgtype, str):
            raise TypeError("a topic has no name, or no type")
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


class Clock:
    """Detects that a recording has two clocks, and converts times of arrival to that of the stamps."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.other: bool | None = None  # whether there are two; None as long as there was no stamp
        self._last: tuple[int, int] | None = None  # received, and the time of the stamps then

    def convert(self, received: Times, stamps: Times, topics: Sequence[Topic]) -> Times:
        """Return the times of arrival (n,) of a batch in the clock of its stamps (n,), if that is another one."""
        stamped = stamps != 0
        if self.other is None and stamped.any():
            self._decide(received, stamps, topics)
        if not self.other:
            return received
        kinds = np.array([topic.kind for topic in topics])
        known, now = self._now(received[stamped], stamps[stamped], kinds[stamped])
        return np.interp(received, known, now).astype(np.int64) if len(known) else received

    def _decide(self, received: Times, stamps: Times, topics: Sequence[Topic]) -> None:
        """Decide by the first stamps: each topic has to be far off, for one alone is a fault of its node.

        Of a simulation, whose clock is there, most topics: a node without use_sim_time is a fault of its own.
        """
        apart: dict[Topic, list[int]] = {}
        for topic, difference, stamp in zip(topics, (received - stamps).tolist(), stamps, strict=True):
            if stamp:
                apart.setdefault(topic, []).append(difference)
        medians = {topic: float(np.median(values)) for topic, values in apart.items()}
        ticks = {topic for topic in medians if topic.kind == CLOCK}
        far = [topic for topic, median in medians.items() if abs(median) > APART * SECOND]
        others = medians.keys() - ticks
        self.other = len(far) == len(medians)
        if ticks & set(far) and 2 * len(others & set(far)) >= len(others):
            self.other = True
        if not self.other:
            return
        self.recording.start, self.recording.end = None, 0
        self._tell(min(abs(medians[topic]) for topic in far) / SECOND, far_ahead=medians[far[0]] < 0)

    def _tell(self, far: float, far_ahead: bool) -> None:
        """Take down that there are two clocks, so far (s) apart."""
        message = "the stamps are of another clock than the recorder's, "
        message += f"{seconds(far) if far > YEAR else f'{far:,.0f} s'} apart: ages are told by that of the stamps"
        help = "a simulation or a bag that is played does that; computers whose clocks differ do, too"
        severity = WARNING
        if "/clock" in self.recording.topics:
            severity, help = NOTE, "a simulation does that; ros2 bag record --use-sim-time records in its time"
        elif far > YEAR:
            help = "the recorder's clock began in 1970" if far_ahead else "a simulation, or a clock that began in 1970"
        trouble = problem("recording-other-clock", "the recording", message, help, severity=severity)
        self.recording.troubles.append(trouble)

    def _now(self, received: Times, stamps: Times, kinds: Times) -> tuple[Times, Times]:
        """Return times of arrival, ascending, and what the clock of the stamps was then (ns).

        That is what /clock said; without it, the newest stamp of a message that is no transform: localisation stamps
        transforms with times to come.
        """
        ticks, placed = kinds == CLOCK, (kinds == JOINTS) | (kinds == HEADER)
        chosen = ticks if ticks.any() else placed if placed.any() else np.ones(len(kinds), bool)
        received, now = received[chosen], stamps[chosen]
        if self._last is not None:
            received, now = np.append(received, self._last[0]), np.append(now, self._last[1])
        if not len(received):
            return received, now
        order = np.argsort(received, kind="stable")
        received, now = received[order], now[order]
        if not ticks.any():
            if float(np.median(now)) < now[0] - SECOND:  # it began anew
                received, now = received[1:], now[1:]
            newest = np.maximum.accumulate(now)
            grown = np.concatenate(([True], newest[1:] > newest[:-1]))
            received, now = received[grown], newest[grown]
        self._last = (int(received[-1]), int(now[-1]))
        return received, now

"""Read rosbag2 recordings with rosbags."""

import re
from array import array
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from rosorin_compile.source.diagnostics import NOTE, WARNING
from rosorin_compile.source.files import is_file, is_folder
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.system import is_installed, pip_install

from .recording import Recording, Rows
from .results import problem, seconds
from .series import APART, SECOND, EdgeKey, Gap, Times

SUFFIXES = (".mcap", ".db3")
_FAR = 2**62  # ns: a larger time indicates a damaged file

Topic = tuple[int, str, str]  # (index in _TYPES, topic name, message type)


class Unreadable(Exception):
    """Raised if a recording cannot be read; ``help`` is the suggested solution."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


_TF, _TF_STATIC, _JOINTS, _ROBOT, _CLOCK, _HEADER = range(6)
_TYPES = (
    *("tf2_msgs/msg/TFMessage", "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/JointState"),
    *("std_msgs/msg/String", "rosgraph_msgs/msg/Clock", "std_msgs/msg/Header"),
)
_NAMES = ("tf", "tf_static", "joint_states", "robot_description", "clock")
# Message types whose frame_id is ignored, because it is usually empty or not a tf2 frame.
_NOT_PLACED = {f"sensor_msgs/msg/{name}" for name in ("Joy", "BatteryState", "TimeReference", "Temperature")}
_NOT_PLACED |= {"sensor_msgs/msg/JointState", "diagnostic_msgs/msg/DiagnosticArray"}


def read(paths: Sequence[Path], recording: Recording) -> None:
    """Read a rosbag2 folder, or several bag files without metadata.yaml, into a recording. Raises Unreadable."""
    if not is_installed("rosbags"):
        raise Unreadable("reading a recording needs the package rosbags, which is not installed", pip_install("verify"))
    with ExitStack() as stack:
        bags = sorted((_Bag(path, stack) for path in paths), key=lambda bag: bag.start)
        reader = _Reader(recording)
        if bags := [bag for bag in bags if bag.count]:
            reader.read(bags)
        reader.finish()


class _Bag:
    def __init__(self, path: Path, stack: ExitStack) -> None:
        from rosbags.rosbag2 import Reader
        from rosbags.typesys import Stores, get_typestore

        self.path, self.types = path, get_typestore(Stores.ROS2_HUMBLE)
        try:
            self.reader: Any = stack.enter_context(Reader(path))
            files = getattr(self.reader.storage, "storages", None) or [self.reader.storage]
            self.count = sum(file.metadata.message_count for file in files)
            self.start = min((file.metadata.start_time for file in files), default=0)
            self.end = max((file.metadata.end_time for file in files), default=0)
            if self.count and not -_FAR < self.start <= self.end <= _FAR:
                raise ValueError("its first or its last time is beyond all clocks")
            listed = [(c.topic, c.msgtype, c.ext, digest) for c in self.reader.connections for digest in ("", c.digest)]
            for one in (connection for file in files for connection in file.connections):
                if not isinstance(one.topic, str) or not isinstance(one.msgtype, str):
                    raise TypeError("a topic has no name, or no type")
                if (one.topic, one.msgtype, one.ext, one.digest) not in listed:  # rosbags would skip this topic
                    raise ValueError(f"metadata.yaml contradicts the files about {one.topic}")
        except Exception as cause:
            for inner in sorted(path.iterdir()) if is_folder(path) else ():  # find the damaged file
                if inner.suffix in SUFFIXES and is_file(inner):
                    _Bag(inner, stack)
            raise self._damaged(cause) from None

    def _damaged(self, cause: Exception, where: str = "") -> Unreadable:
        path, reason = self.path, " ".join(str(cause).split())[:300].rstrip(".") or type(cause).__name__
        is_mcap = path.suffix == ".mcap" or any(path.glob("*.mcap"))
        repair = "mcap recover FILE" if is_mcap else "ros2 bag reindex FOLDER"
        help = f"if the recorder was killed or a copy is incomplete, {repair} may help; else record again"
        return Unreadable(f"{path} cannot be read: {where}{reason}", help)

    def messages(self, known: dict[int, Topic], start: int | None, end: int | None) -> Iterator[tuple[Topic, int, Any]]:
        """Yield (topic, time of arrival in ns, message); ``known`` has the requested topics by connection id."""
        connections = [connection for connection in self.reader.connections if connection.id in known]
        if not connections:  # an empty list would select all topics
            return
        deserialize, where = self.types.deserialize_cdr, ""
        try:
            for connection, received, raw in self.reader.messages(connections, start=start, stop=end):
                kind, name, _ = topic = known[connection.id]
                where = f"a message of {name}: "
                if not -_FAR < received < _FAR:
                    raise ValueError("its time is beyond all clocks")
                raw = raw[: 16 + int.from_bytes(raw[12:16], "little" if raw[1] else "big")] if kind == _HEADER else raw
                yield topic, received, deserialize(raw, _TYPES[kind])
                where = ""
        except Exception as cause:
            raise self._damaged(cause, where) from None

    def topics(self, recording: Recording) -> dict[int, Topic]:
        namespace = recording.description.options.namespace.strip("/")
        fronts = ("/", f"/{namespace}/") if namespace else ("/",)
        kinds = {f"{front}{name}": kind for kind, name in enumerate(_NAMES) for front in fronts}
        topics: dict[int, Topic] = {}
        for connection in self.reader.connections:
            topic, message_type = connection.topic, connection.msgtype
            kind = kinds.get(topic, _HEADER)
            recording.topics[topic] = message_type
            if kind != _HEADER and message_type != _TYPES[kind]:
                text = f"{topic} is of type {message_type}, not {_TYPES[kind]}"
                recording.troubles.append(problem("recording-type", topic, text))
            elif kind != _HEADER or self._has_header(connection):
                topics[connection.id] = (kind, topic, message_type)
        return topics

    def _has_header(self, connection: Any) -> bool:
        if fields := self.types.fielddefs.get(connection.msgtype):
            has_header = bool(fields[1]) and str(fields[1][0][1][1]) == _TYPES[_HEADER]
            return has_header and connection.msgtype not in _NOT_PLACED
        first = re.search(r"^[ \t]*([\w/]+)[ \t]+\w+[ \t]*(?:#.*)?$", str(connection.msgdef.data), re.MULTILINE)
        return first is not None and first[1] in ("std_msgs/Header", "std_msgs/msg/Header", "Header")


class _Reader:
    def __init__(self, recording: Recording) -> None:
        self.recording, self.arrivals, self.ticks = recording, array("q"), Rows()
        self._edges: dict[tuple[bool, str, str], Rows] = {}  # key: (is static, parent, child), as recorded

    def read(self, bags: Sequence[_Bag]) -> None:
        """Read the messages in the requested interval, and earlier messages of /tf_static and /robot_description."""
        recording, options = self.recording, self.recording.description.options
        first, end, count = bags[0].start, max(bag.end for bag in bags), sum(bag.count for bag in bags)
        start = first if options.since is None else first + int(options.since * SECOND)
        stop = None if options.until is None else first + int(options.until * SECOND)
        if start > end > first:
            long = f"{(end - first) / SECOND:.1f} s long"
            raise Unreadable(f"--since {options.since:g} is behind the end of the recording, which is {long}")
        recording.start = start
        every = [(bag, bag.topics(recording)) for bag in bags]
        for bag, topics in every if start > first else ():
            latched = {id: topic for id, topic in topics.items() if topic[0] in (_TF_STATIC, _ROBOT)}
            for message in bag.messages(latched, None, start):
                self._add(*message)
        for bag, topics in every:
            for topic, received, content in bag.messages(topics, start if start > first else None, stop):
                self._add(topic, received, content)
                self.arrivals.append(received)
                if recording.messages % 16_384 == 0:  # limit the number of progress updates
                    Progress.step("reading messages", recording.messages, count)
        Progress.step("reading messages", recording.messages, count)

    def _add(self, topic: Topic, received: int, content: Any) -> None:
        recording, (kind, name, message_type) = self.recording, topic
        recording.messages += 1
        if kind in (_TF, _TF_STATIC):
            for one in content.transforms:
                header, static = one.header, kind == _TF_STATIC
                rows = self._edges.get((static, header.frame_id, one.child_frame_id))
                if rows is None:  # first transform between these frames
                    parent, child = recording.tree_frame(header.frame_id), recording.tree_frame(one.child_frame_id)
                    rows = recording.edges.setdefault(EdgeKey(static, parent, child), Rows())
                    self._edges[static, header.frame_id, one.child_frame_id] = rows
                at, turn = one.transform.translation, one.transform.rotation
                rows.add(received, _ns(header.stamp), (at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w))
        elif kind == _ROBOT:
            recording.descriptions[content.data.encode()] = None
        elif kind == _CLOCK:
            self.ticks.add(received, _ns(content.clock))
        elif kind == _JOINTS:
            recording.add_state(received, _ns(content.header.stamp), content.name, content.position.tolist())
        else:
            recording.add_header(received, _ns(content.stamp), name, message_type, content.frame_id)

    def finish(self) -> None:
        recording, clock = self.recording, self._other_clock()
        arrivals = np.sort(np.frombuffer(self.arrivals, np.int64))
        if len(arrivals):
            if clock is not None:
                arrivals = np.interp(arrivals, *clock).astype(np.int64)
                recording.start = int(arrivals[0])
            recording.start, recording.end = min(recording.start, int(arrivals[0])), int(arrivals[-1])
        steps = np.diff(arrivals)
        used = len(recording.headers) + bool(recording.positions) + len({key.static for key in recording.edges})
        if len(steps) and used > 1:  # a gap in a single topic may be a pause of its publisher
            recording.silence = Gap(float(steps.max() / SECOND), int(arrivals[steps.argmax()]))
        recording.finish(clock)

    def _other_clock(self) -> Times | None:
        """Return times of arrival and matching times of the other clock (2, n), or None if there is no other clock.

        Another clock is detected if the stamps of all topics are far from their times of arrival. If /clock was
        recorded, half of the topics are enough, because some nodes may run without use_sim_time.
        """
        recording, parts = self.recording, dict[str, list[Times]]()
        streams = [("/tf", rows) for key, rows in recording.edges.items() if not key.static]
        streams += [(topic, rows) for (topic, _, _), rows in recording.headers.items()]
        for topic, rows in (*streams, ("/joint_states", recording.states), ("/clock", self.ticks)):
            times = rows.times
            if (stamped := times[:, times[1] != 0]).size:
                parts.setdefault(topic, []).append(stamped)
        topics = {topic: np.concatenate(several, axis=1) for topic, several in parts.items()}
        leads = {topic: abs(float(np.median(times[0] - times[1]))) / SECOND for topic, times in topics.items()}
        far = [topic for topic, lead in leads.items() if lead > APART]
        others = [topic for topic in leads if topic != "/clock"]
        most = "/clock" in far and 2 * len([topic for topic in others if topic in far]) >= len(others)
        if not far or (len(far) < len(leads) and not most):
            return None
        apart = seconds(min(leads[topic] for topic in far))
        message = f"the stamps are of another clock, {apart} from the recorder's; ages are computed from the stamps"
        severity = NOTE if "/clock" in recording.topics else WARNING
        recording.troubles.append(problem("recording-other-clock", "the recording", message, severity=severity))
        if "/clock" in topics:
            times = topics["/clock"]
            return times[:, np.argsort(times[0], kind="stable")]
        # Use /tf only if there is no other topic, because localization nodes stamp transforms in the future.
        times = np.concatenate([times for topic, times in topics.items() if topic != "/tf"] or [topics["/tf"]], axis=1)
        times = times[:, np.argsort(times[0], kind="stable")]
        times[1] = np.maximum.accumulate(times[1])
        return times[:, np.concatenate(([True], np.diff(times[1]) > 0))]


def _ns(stamp: Any) -> int:
    return int(stamp.sec * SECOND + stamp.nanosec)

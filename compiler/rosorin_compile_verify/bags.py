"""Bags: rosbag2 recordings, read raw in batches by rosbags and decoded here, many messages at once.

``topics_of`` says which topics are looked at. ``Clock`` brings times of arrival into the clock of the stamps, where
the recorder had another one.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.diagnostics import NOTE, WARNING, Diagnostic, Heading, Rule, counted, pip_install
from rosorin_compile.extending import world

from . import cdr, cut_bags
from .arrays import SECOND, Samples, Times
from .findings import YEAR, problem, seconds
from .joints import in_order
from .metadata import Unreadable
from .pace import APART
from .recording import MAX_DESCRIPTIONS, Batch, Recording

RULES = (
    Rule(
        "recording-damaged",
        "A recording breaks off, or messages of a topic are cut short. What came before is compared all the same.",
        "Record again, or recover it.",
        Heading.RECORDINGS,
    ),
    Rule(
        "recording-cut-off",
        "A warning: the end of a file is missing, because the recorder was killed, or a copy broke off. What came "
        "before is read and compared.",
        "End a recording with Ctrl-C.",
        Heading.RECORDINGS,
    ),
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


BATCH = 16_384
BATCH_BYTES = 32 << 20
FAR = 2**62  # ns; no clock is there
_STAMP_AND_LENGTH = {0: struct.Struct(">iII"), 1: struct.Struct("<iII")}

Progress = Callable[[int, int], None]


class _Damage(Exception):
    """The reader gave up in the middle of a recording; the text says why."""


class Part(NamedTuple):
    """An open file of a recording, or a folder of compressed ones: number of messages, first and last time (ns)."""

    reader: Any
    path: Path
    number: int
    start: int
    end: int


def read(paths: Sequence[Path], recording: Recording, progress: Progress) -> None:
    """Read the files of a recording, or its folder, into it, as they follow each other in time. Raises Unreadable."""
    with ExitStack() as stack:
        parts = [_opened(path, recording, stack) for path in paths]
        every = [(part, topics_of(part.reader, recording)) for part in parts]
        _read_all(sorted((one for one in every if one[0].number), key=lambda one: one[0].start), recording, progress)
    recording.finish()


def _opened(path: Path, recording: Recording, stack: ExitStack) -> Part:
    """Return an open part; of a file whose end is missing what is left. Raises Unreadable."""
    try:
        from rosbags.rosbag2 import Reader
    except ImportError:
        help = pip_install("verify")
        raise Unreadable("reading a recording needs the package rosbags, which is not installed", help) from None
    left = cut_bags.opened(path) if world.kind(path) == world.FILE and cut_bags.is_cut(path) else None
    if left is not None:
        stack.callback(left.close)
        recording.troubles.append(_cut_off(path, left))
        return _part(left, path)
    world.spoil(f"rosbags reads {path}")
    try:
        reader = Reader(path)
        reader.open()
        stack.callback(reader.close)
        _agree(reader)
        return _part(reader, path)
    except Exception as wrong:
        raise Unreadable(f"{path} cannot be read: {_reason(wrong)}", _help(path)) from None


def _agree(reader: Any) -> None:
    """Raise ValueError if the files of a folder have topics that its metadata.yaml has not: rosbags skips them."""
    known = [(one.topic, one.msgtype, one.ext, digest) for one in reader.connections for digest in ("", one.digest)]
    for file in getattr(reader.storage, "storages", ()):
        for one in file.connections:
            if (one.topic, one.msgtype, one.ext, one.digest) not in known:
                raise ValueError(f"metadata.yaml says other things of {one.topic} than the files")


def _part(reader: Any, path: Path) -> Part:
    """Return a part with what its files say of themselves: what metadata.yaml says may be of others."""
    files = getattr(getattr(reader, "storage", None), "storages", None) if world.kind(path) == world.FOLDER else None
    said = [file.metadata for file in files] if files else [reader]
    number = sum(int(one.message_count) for one in said)
    start, end = min(int(one.start_time) for one in said), max(int(one.end_time) for one in said)
    if path.suffix == ".mcap":  # its last lines count; its first chunk has the first message
        try:
            first = next(_whole(reader.messages(list(reader.connections))), None)
        except _Damage:
            first = None
        if first is not None:
            number, start = max(1, number), first[1]
    return Part(reader, path, number if -FAR < start < FAR else 0, start, end)


def _cut_off(path: Path, left: cut_bags.CutReader) -> Diagnostic:
    """Return the finding for a file whose end is missing."""
    until = (left.end_time - left.start_time) / SECOND
    how = f"it ends {until:.1f} s after its begin, with {counted(left.message_count, 'message')}"
    message = f"{path.name} is cut off: {how if left.message_count else 'it ends before its first message'}"
    help = "the recorder was killed, or the copy broke off: what came before is compared; Ctrl-C ends a recording well"
    numbers = {"seconds": until if left.message_count else 0.0, "messages": left.message_count}
    return problem("recording-cut-off", "the recording", message, help, severity=WARNING, numbers=numbers)


def _reason(problem: BaseException) -> str:
    """Return what a library says about a problem, on one line."""
    text = " ".join(str(problem).split()) or type(problem).__name__
    return text[:300].rstrip(".")


def _help(path: Path) -> str:
    if path.suffix == ".mcap" or world.matching(path, "*.mcap"):
        return "if the recorder was stopped hard, mcap recover writes what can be saved"
    return "if the recorder was stopped hard, ros2 bag reindex FOLDER may help"


def _read_all(parts: Sequence[tuple[Part, dict[int, Topic]]], recording: Recording, progress: Progress) -> None:
    """Read all parts between the two times that are asked for; of what is latched also what came before."""
    if not parts:
        return
    options = recording.description.options
    first = parts[0][0].start
    start = first if options.since is None else first + int(options.since * SECOND)
    stop = None if options.until is None else first + int(options.until * SECOND)
    end = max(part.end for part, _ in parts)
    if options.since is not None and start > end > first:
        long = f"{(end - first) / SECOND:.1f} s long"
        raise Unreadable(f"--since {options.since:g} is behind the end of the recording, which is {long}")
    recording.span(start, start)
    reading = _Reading(recording, progress, sum(part.number for part, _ in parts))
    if start > first:
        for part, topics in parts:
            latched = {key: topic for key, topic in topics.items() if topic.kind in (TF_STATIC, ROBOT)}
            reading.take(part, latched, None, start)
        recording.begin_at(start)
    for part, topics in parts:
        reading.take(part, topics, start if start > first else None, stop)


class _Reading:
    """What goes on while a recording is read part by part."""

    def __init__(self, recording: Recording, progress: Progress, number: int) -> None:
        self.recording, self.progress, self.number = recording, progress, number
        self.decoder = _Decoder(recording, Clock(recording))

    def take(self, part: Part, topics: dict[int, Topic], start: int | None, stop: int | None) -> None:
        """Take some topics of a part between two times; that it is damaged is a trouble of the recording."""
        wanted = [connection for connection in part.reader.connections if connection.id in topics]
        if not wanted:
            return
        try:
            messages = part.reader.messages(wanted, start=start, stop=stop)
            _take_all(messages, topics, self.decoder, self.progress, self.number)
        except _Damage as wrong:
            text = f"{part.path} is damaged: after {self.recording.messages:,} messages, {wrong}"
            help = f"what came before is compared all the same; {_help(part.path)}"
            self.recording.troubles.append(problem("recording-damaged", "the recording", text, help))


def _whole(messages: Iterator[tuple[Any, int, bytes]]) -> Iterator[tuple[Any, int, bytes]]:
    """Yield the messages of a reader. Raises _Damage for whatever it raises: bad files make it fail in many ways."""
    try:
        for message in messages:
            if type(message[2]) is not bytes or type(message[1]) is not int or not -FAR < message[1] < FAR:
                raise _Damage("a message is none, or has no time")
            yield message
    except _Damage:
        raise
    except Exception as problem:
        raise _Damage(_reason(problem)) from None


def _take_all(
    messages: Iterator[tuple[Any, int, bytes]],
    topics: dict[int, Topic],
    decoder: _Decoder,
    progress: Progress,
    count: int,
) -> None:
    """Read messages in batches. Raises _Damage, after the messages before have been taken."""
    waiting: dict[int, tuple[list[int], list[bytes], list[int]]] = {key: ([], [], []) for key in topics}
    number = size = 0
    try:
        for connection, received, raw in _whole(messages):
            times, raws, order = waiting[connection.id]
            times.append(received)
            raws.append(raw)
            order.append(number)
            number += 1
            size += len(raw)
            if number >= BATCH or size >= BATCH_BYTES:
                decoder.take(waiting, topics, number)
                progress(decoder.recording.messages, count)
                number = size = 0
    except _Damage:
        decoder.take(waiting, topics, number)
        raise
    decoder.take(waiting, topics, number)


class _Decoder:
    """Decodes batches of raw messages into a recording."""

    def __init__(self, recording: Recording, clock: Clock) -> None:
        self.recording = recording
        self.clock = clock
        self.transforms = cdr.Reader(cdr.transforms)
        self.states = cdr.Reader(cdr.joint_state)
        self.frames: dict[bytes, tuple[str, bool]] = {}

    def take(self, waiting: dict[int, Any], topics: dict[int, Topic], number: int) -> None:
        """Decode what waits, and forget it."""
        batch = Batch()
        self.recording.messages += number
        self.clock.put(waiting, topics)
        came = [times for times, _, _ in waiting.values() if times]
        if came:
            self.recording.came(np.concatenate(came), len(topics))
        for key, (times, raws, order) in waiting.items():
            if not raws:
                continue
            topic = topics[key]
            self.recording.span(times[0], times[-1])
            broken: list[str] = []
            if topic.kind in (TF, TF_STATIC):
                self._transforms(batch, topic.kind == TF_STATIC, (times, raws, order), broken)
            elif topic.kind == JOINTS:
                self._states(times, raws, broken)
            elif topic.kind == ROBOT:
                self._robot(raws, broken)
            elif topic.kind != CLOCK:
                self._headers(batch, topic, times, raws, broken)
            if broken:
                self._broken(topic, broken)
            times.clear(), raws.clear(), order.clear()
        self.recording.take(batch)

    def _transforms(self, batch: Batch, still: bool, messages: Any, broken: list[str]) -> None:
        times, raws, order = messages
        received, places = np.array(times, np.int64), np.array(order, np.int64)
        for group in self.transforms.groups(raws, broken):
            frame = self.recording.tree_frame
            for item in group.layout.items:
                numbers = group.doubles(item.numbers, 7)
                stamps = group.stamps(item.stamp)
                samples = Samples(received[group.places], stamps, numbers[:, :3], numbers[:, 3:])
                batch.add_edge((still, frame(item.parent), frame(item.child)), places[group.places], samples)

    def _states(self, times: list[int], raws: list[bytes], broken: list[str]) -> None:
        """Take joint states: the times of all, then the positions of those that name the same joints, as they came."""
        received, joints = np.array(times, np.int64), self.recording.joints
        places: dict[tuple[tuple[str, ...], int], list[Any]] = {}
        stamps = np.zeros(len(raws), np.int64)
        for group in self.states.groups(raws, broken):
            item = group.layout.items[0]
            stamps[group.places] = group.stamps(item.stamp)
            names, positions = in_order(item.names, group.doubles(item.numbers, item.size))
            places.setdefault((names, item.size), []).append((group.places, positions))
        if places:
            good = np.sort(np.concatenate([part[0] for parts in places.values() for part in parts]))
            joints.pace.add(received[good], stamps[good], self.recording.start or 0)
        for (names, _), parts in places.items():
            at = np.concatenate([part[0] for part in parts])
            order = np.argsort(at)
            positions = np.concatenate([part[1] for part in parts])[order]
            joints.add(names, received[at[order]], stamps[at[order]], positions)

    def _robot(self, raws: list[bytes], broken: list[str]) -> None:
        for raw in raws:
            try:
                text = cdr.Cursor(raw).bytes()
            except cdr.CdrError as wrong:
                broken.append(str(wrong))
                continue
            known = self.recording.descriptions
            if text not in known and len(known) < MAX_DESCRIPTIONS:
                known.append(text)

    def _headers(self, batch: Batch, topic: Topic, times: list[int], raws: list[bytes], broken: list[str]) -> None:
        for received, raw in zip(times, raws, strict=True):
            layout = _STAMP_AND_LENGTH.get(raw[1] if len(raw) >= 16 else 9)
            if layout is None:
                broken.append("the message is not in CDR")
                continue
            seconds, nanoseconds, length = layout.unpack_from(raw, 4)
            name = raw[16 : 16 + length]
            if len(name) < length:
                broken.append(f"the message ends after {len(raw)} bytes, within the name of its frame")
                continue
            known = self.frames.get(name)
            if known is None:
                known = self.recording.frame(name.rstrip(b"\0").decode("utf-8", "replace")), name.startswith(b"/")
                if len(self.frames) < 10_000:
                    self.frames[name] = known
            frame, slashed = known
            if slashed:
                batch.slashed[topic.name, frame] = batch.slashed.get((topic.name, frame), 0) + 1
            key = (topic.name, topic.type, frame)
            batch.headers.setdefault(key, []).append((received, seconds * SECOND + nanoseconds))

    def _broken(self, topic: Topic, broken: list[str]) -> None:
        text = f"{topic.name}: {broken[0]}"
        help = "the file was damaged, or another type was recorded under this name"
        self.recording.troubles.append(problem("recording-damaged", topic.name, text, help))


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
            text = "a topic of the recording has no name, or no type"
            recording.troubles.append(problem("recording-damaged", "the recording", text, "its messages are left out"))
            continue
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


_STAMPS = {0: struct.Struct(">iI"), 1: struct.Struct("<iI")}
# Where the first stamp of a message stands; of /tf behind the number of its transforms.
_PLACES = {TF: 8, JOINTS: 4, HEADER: 4, CLOCK: 4}


class Clock:
    """Tells whether a recording has two clocks, and puts times of arrival into that of the stamps."""

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self.other: bool | None = None  # whether there are two; None as long as no stamp was seen
        self._last: tuple[int, int] | None = None  # received, and the time of the stamps then

    def put(self, waiting: Mapping[int, Any], topics: Mapping[int, Topic]) -> None:
        """Put the times of arrival of a batch into the clock of its stamps, if that is another one."""
        if self.other is False:
            return
        stamps = _stamps(waiting, topics)
        if self.other is None and stamps:
            self._decide(stamps, topics)
        if not self.other:
            return
        received, now = self._now(stamps, topics)
        for times, _, _ in waiting.values():
            times[:] = np.interp(times, received, now).astype(np.int64).tolist() if len(received) else times

    def _decide(self, stamps: Mapping[int, tuple[Times, Times]], topics: Mapping[int, Topic]) -> None:
        """Decide by the first stamps: each topic has to be far off, for one alone is a fault of its node.

        Of a simulation, whose clock is there, most topics: a node without use_sim_time is a fault of its own.
        """
        apart = {key: float(np.median(received - stamp)) for key, (received, stamp) in stamps.items()}
        ticks = {key for key in apart if topics[key].kind == CLOCK}
        far = [key for key in apart if abs(apart[key]) > APART * SECOND]
        others = apart.keys() - ticks
        self.other = len(far) == len(apart)
        if ticks & set(far) and 2 * len(others & set(far)) >= len(others):
            self.other = True
        if not self.other:
            return
        self.recording.start, self.recording.end = None, 0
        self._tell(min(abs(apart[key]) for key in far) / SECOND, far_ahead=apart[far[0]] < 0)

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

    def _now(self, stamps: Mapping[int, tuple[Times, Times]], topics: Mapping[int, Topic]) -> tuple[Times, Times]:
        """Return times of arrival, ascending, and what the clock of the stamps was then (ns).

        That is what /clock said; without it, the newest stamp of a message that is no transform: localisation stamps
        transforms with times to come.
        """
        kinds = {topics[key].kind for key in stamps}
        chosen = {CLOCK} if CLOCK in kinds else ({JOINTS, HEADER} & kinds or kinds)
        parts = [pair for key, pair in stamps.items() if topics[key].kind in chosen]
        if self._last is not None:
            parts.append((np.array([self._last[0]]), np.array([self._last[1]])))
        if not parts:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        received, now = (np.concatenate(values) for values in zip(*parts, strict=True))
        order = np.argsort(received, kind="stable")
        received, now = received[order], now[order]
        if CLOCK not in chosen:
            if float(np.median(now)) < now[0] - SECOND:  # it began anew
                received, now = received[1:], now[1:]
            newest = np.maximum.accumulate(now)
            grown = np.concatenate(([True], newest[1:] > newest[:-1]))
            received, now = received[grown], newest[grown]
        self._last = (int(received[-1]), int(now[-1]))
        return received, now


def _stamps(waiting: Mapping[int, Any], topics: Mapping[int, Topic]) -> dict[int, tuple[Times, Times]]:
    """Return the times of arrival and the first stamps (ns) of the messages of each topic; those of zero are none."""
    stamps = {}
    for key, (times, raws, _) in waiting.items():
        place = _PLACES.get(topics[key].kind)
        if place is None:
            continue
        pairs = []
        for received, raw in zip(times, raws, strict=True):
            layout = _STAMPS.get(raw[1] if len(raw) >= place + 8 else 9)
            if layout is not None:
                whole, rest = layout.unpack_from(raw, place)
                pairs += [(received, whole * SECOND + rest)] if whole or rest else []
        if pairs:
            both = np.array(pairs, np.int64).T
            stamps[key] = (both[0], both[1])
    return stamps

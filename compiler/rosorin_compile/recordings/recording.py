"""Recording: what is kept of a recording while it streams by. Its size does not grow with the recording.

``Recording`` takes batches, and keeps a series for each edge. ``SensorLog`` keeps, of each sensor, whether tf2 could
have placed it when its messages came.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.model import Vector
from rosorin_compile.source.diagnostics import Diagnostic

from .arrays import NO_SAMPLES, SECOND, Samples, Times
from .expected import Description, Expected
from .joints import JointLog
from .pace import Gap, Pace
from .series import Series, unlike

Rows = tuple[Vector, Vector, Vector]

MAX_EDGES = 4000
MAX_SENSORS = 500
MAX_FRAMES = 32  # that the messages of one topic name
MAX_DROPPED = 20
MAX_DESCRIPTIONS = 4


class Reading(NamedTuple):
    """One way in which tf2_echo prints a transform; what it does not print is None. Tolerances are half a digit."""

    xyz: Vector | None
    rows: Rows | None
    metres: float
    radians: float


class Asked(NamedTuple):
    """An answer of tf2_echo: where ``target`` is in ``source``, and the line of the text where it begins."""

    source: str
    target: str
    readings: tuple[Reading, ...]
    line: int
    positions: Mapping[str, float]


class Refused(NamedTuple):
    """A question that tf2_echo got no answer to: the two frames, why not, and the line of the text."""

    source: str
    target: str
    why: str
    line: int


class FrameRow(NamedTuple):
    """One frame of view_frames: rate in Hz; ``age`` in s of the most recent transform, None if it is not known."""

    parent: str
    child: str
    rate: float
    buffered: float
    age: float | None

    @property
    def still(self) -> bool:
        """Whether it came on /tf_static: one sample, over the shortest time that tf2 divides by."""
        return self.rate >= 9999.0 and self.buffered == 0.0


EdgeKey = tuple[bool, str, str]  # on /tf_static, parent, child


class Lists(NamedTuple):
    """Rows of a batch: number of the message, stamp in ns, and numbers, if there are any."""

    messages: list[int]
    stamps: list[int]
    values: list[Sequence[float]]


@dataclass
class Batch:
    """The messages of a short while: when each was received (ns), and what they say of edges, joints and frames."""

    received: list[int] = field(default_factory=list)
    edges: dict[EdgeKey, Lists] = field(default_factory=dict)
    states: dict[tuple[tuple[str, ...], int], Lists] = field(default_factory=dict)  # names, number of positions
    headers: dict[tuple[str, str, str], Lists] = field(default_factory=dict)  # topic, type, frame
    slashed: dict[tuple[str, str], int] = field(default_factory=dict)  # topic, frame: messages with "/" before it

    def add_transform(self, key: EdgeKey, stamp: int, values: Sequence[float]) -> None:
        """Add a transform of the latest message: x, y, z in metres and a quaternion x, y, z, w."""
        _append(self.edges, key, len(self.received) - 1, stamp, values)

    def add_state(self, names: Sequence[str], positions: Sequence[float], stamp: int) -> None:
        """Add the joint state of the latest message; positions in rad or m."""
        if len(names) == len(positions):  # sorted, because some drivers name their joints in any order
            order = sorted(range(len(names)), key=names.__getitem__)
            names, positions = [names[at] for at in order], [positions[at] for at in order]
        _append(self.states, (tuple(names), len(positions)), len(self.received) - 1, stamp, positions)

    def add_header(self, topic: str, kind: str, frame: str, stamp: int) -> None:
        """Add the header of the latest message, of a topic and a type."""
        _append(self.headers, (topic, kind, frame), len(self.received) - 1, stamp, ())

    def add_slash(self, topic: str, frame: str) -> None:
        """Count a message whose frame has "/" before it."""
        self.slashed[topic, frame] = self.slashed.get((topic, frame), 0) + 1


def _append(lists: dict[Any, Lists], key: Any, message: int, stamp: int, values: Sequence[float]) -> None:
    rows = lists.get(key)
    if rows is None:
        rows = lists[key] = Lists([], [], [])
    rows.messages.append(message)
    rows.stamps.append(stamp)
    rows.values.append(values)


class Recording:
    """All that is kept of a recording. ``whole`` says that an edge that is not in it was not published."""

    def __init__(self, description: Description, form: str) -> None:
        self.description = description
        self.form = form
        self.whole = False
        self.timed = True
        self.start: int | None = None
        self.end = 0
        self.messages = 0
        self.silence = Gap()  # the longest time without a message on several topics, and when it began
        self.series: dict[EdgeKey, Series] = {}
        self.parents: dict[str, str] = {}
        self.joints = JointLog(description)
        self.sensors: dict[str, SensorLog] = {}
        self.descriptions: list[bytes] = []
        self.troubles: list[Diagnostic] = []
        self.topics: dict[str, str] = {}
        self.asked: list[Asked] = []
        self.rows: list[FrameRow] = []
        self.refused: list[Refused] = []
        self.too_many = False
        self.dropped: dict[EdgeKey, int] = {}  # transforms that tf2 drops: from a frame to itself, or without a name
        self.tree_frames: set[str] = set()  # as they were recorded
        self._came: int | None = None

    def frame(self, name: str) -> str:
        """Return a recorded name of a frame as the description has it: without "/" before it and without the prefix.

        robot_state_publisher puts the prefix before all links: a link without it is another frame.
        """
        name = name.removeprefix("/")
        prefix = self.description.options.prefix
        if prefix and not name.startswith(prefix) and name in self.description.robot.link:
            return f"{name} without {prefix}"
        return name.removeprefix(prefix) if prefix else name

    def tree_frame(self, name: str) -> str:
        """Return the recorded name of a frame of a transform as the description has it, and remember it."""
        if len(self.tree_frames) < 2 * MAX_EDGES:
            self.tree_frames.add(name.removeprefix("/"))
        return self.frame(name)

    def of_another(self, frame: str) -> bool:
        """Whether a frame has the prefix of another robot of a fleet."""
        own = frame.rpartition("/")[2]
        fleet = bool(self.description.options.prefix) and "/" in frame and " " not in frame
        return fleet and (own in self.description.frames or own in self.description.robot.link)

    def expected(
        self, parent: str, child: str, still: bool | None = None, samples: Samples = NO_SAMPLES
    ) -> Expected | None:
        """Return the described edge into a frame; of several, as modes make them, the one that is most like this."""
        edges = self.description.by_child.get(child, ())
        if len(edges) < 2:
            return edges[0] if edges else None
        return min(edges, key=lambda edge: (edge.parent != parent, edge.moving is still, unlike(edge, samples)))

    def span(self, first: int, last: int) -> None:
        """Take note of a time (ns) from which on, and one until which, there were messages."""
        self.start = first if self.start is None else min(self.start, first)
        self.end = max(self.end, last)

    def begin_at(self, start: int) -> None:
        """Begin at a time (ns); what was latched before has been taken."""
        self.start, self.silence, self._came = start, Gap(), None

    def came(self, times: Times, topics: int) -> None:
        """Take the times (ns) of the messages of a batch; of one topic alone nothing follows for the others."""
        ordered = np.sort(times)
        if self._came is not None:
            ordered = np.concatenate(([self._came], ordered))
        self._came = int(ordered[-1])
        steps = np.diff(ordered)
        if topics > 1 and len(steps) and steps.max() / SECOND > self.silence.seconds:
            at = int(steps.argmax())
            self.silence = Gap(float(steps[at] / SECOND), int(ordered[at]))

    @property
    def no_static(self) -> bool:
        """Whether a bag has not one message of /tf_static."""
        return self.timed and not any(series.still for series in self.series.values())

    def add_description(self, text: bytes) -> None:
        """Take what /robot_description carried, each text once."""
        if text not in self.descriptions and len(self.descriptions) < MAX_DESCRIPTIONS:
            self.descriptions.append(text)

    def take(self, batch: Batch, received: Times) -> None:
        """Take a batch, received at these times (n,): joint states and edges, then the messages that ask for them."""
        self._take_states(batch, received)
        for series in self.series.values():
            series.begin_batch()
        for key, rows in batch.edges.items():
            if key[1] == key[2] or not all(key[1:]):
                if key in self.dropped or len(self.dropped) < MAX_DROPPED:
                    self.dropped[key] = self.dropped.get(key, 0) + len(rows.stamps)
                continue
            values = np.array(rows.values, np.float64)
            samples = Samples(received[rows.messages], np.array(rows.stamps, np.int64), values[:, :3], values[:, 3:])
            edge = None if self.of_another(key[2]) else self._series(key, samples)
            if edge is not None:
                edge.add(samples, self.start or 0)
        for series in self.series.values():
            series.compare(self.joints, last=False)
        for (topic, kind, frame), rows in batch.headers.items():
            if not self.of_another(frame):
                self._headers(topic, kind, frame, Headers(received[rows.messages], np.array(rows.stamps, np.int64)))
        for (topic, frame), count in batch.slashed.items():
            if topic in self.sensors and frame in self.sensors[topic].frames:
                self.sensors[topic].frames[frame].slashed += count

    def _take_states(self, batch: Batch, received: Times) -> None:
        """Take joint states: the times of all, then the positions of those that name the same joints."""
        pairs = [pair for rows in batch.states.values() for pair in zip(rows.messages, rows.stamps, strict=True)]
        if pairs:
            messages, stamps = np.array(sorted(pairs), np.int64).T
            self.joints.pace.add(received[messages], stamps, self.start or 0)
        for (names, size), rows in batch.states.items():
            positions = np.array(rows.values, np.float64).reshape(len(rows.values), size)
            self.joints.add(names, received[rows.messages], np.array(rows.stamps, np.int64), positions)

    def finish(self) -> None:
        """Compare what still waits for a joint state."""
        for series in self.series.values():
            series.compare(self.joints, last=True)
        self.joints.pace.aged = self.timed
        for log in self.sensors.values():
            for use in log.frames.values():
                use.pace.aged = self.timed

    def _series(self, key: EdgeKey, samples: Samples) -> Series | None:
        series = self.series.get(key)
        if series is None:
            if len(self.series) >= MAX_EDGES:
                self.too_many = True
                return None
            still, parent, child = key
            edge = self.expected(parent, child, still, samples)
            series = self.series[key] = Series(parent, child, still, edge, self.description)
            series.pace.aged = self.timed
            if child not in self.parents or (edge is not None and edge.parent == parent):
                self.parents[child] = parent
        return series

    def _headers(self, topic: str, kind: str, frame: str, headers: Headers) -> None:
        if topic not in self.sensors and len(self.sensors) >= MAX_SENSORS:
            return
        frames = self.sensors.setdefault(topic, SensorLog(topic, kind)).frames
        if frame not in frames and len(frames) >= MAX_FRAMES:
            return
        use = frames.setdefault(frame, FrameUse(frame))
        use.pace.add(headers.received, headers.stamp, self.start or 0)
        if not self.timed:
            return
        base = self.description.top(frame)
        chain = self.chain(frame, base)
        if chain is None:
            use.early += len(headers.received)
        else:
            use.ready, use.waited_for = ready_at(chain, self.start or 0)
            use.early += int(np.count_nonzero(headers.received < use.ready))
            if chain or frame == base:
                look_up(use, headers, chain, base)
        above = self.chain(frame, self.parents[base]) if base in self.parents else None
        if above:
            look_up(use, headers, above, self.parents[base])

    def chain(self, frame: str, target: str) -> list[Series] | None:
        """Return the recorded edges from a frame up to another; None if they do not lead there."""
        chain: list[Series] = []
        while frame != target:
            parent = self.parents.get(frame)
            if parent is None or len(chain) > len(self.parents):
                return None
            series = self.series.get((True, parent, frame)) or self.series.get((False, parent, frame))
            if series is None:
                return None
            chain.append(series)
            frame = parent
        return chain

    @property
    def into(self) -> Mapping[str, list[Series]]:
        """The recorded edges into each frame, in the order of their appearance."""
        by_child: dict[str, list[Series]] = {}
        for series in self.series.values():
            by_child.setdefault(series.child, []).append(series)
        return by_child


class Headers(NamedTuple):
    """The headers of the messages of one topic and frame in one batch: received and stamp, ns (n,)."""

    received: Times
    stamp: Times


@dataclass
class Lookups:
    """Transforms asked for at the exact stamps of messages, when they came: how many, how many failed, and by how much.

    The lag (s) is how far the newest sample of the slowest edge was behind the stamp; ``slowest`` counts, edge by
    edge, how often it was the one.
    """

    target: str
    asked: int = 0
    failed: int = 0
    lag_sum: float = 0.0
    lag_most: float = 0.0
    slowest: dict[str, int] = field(default_factory=dict)

    @property
    def mean_lag(self) -> float:
        """The mean lag (s) of those that failed."""
        return self.lag_sum / self.failed if self.failed else 0.0


@dataclass
class FrameUse:
    """One frame that the messages of a topic name."""

    frame: str
    pace: Pace = field(default_factory=Pace)
    slashed: int = 0  # messages that name it with "/" before it
    early: int = 0  # messages that came before the frame was in the tree
    ready: int | None = None  # when it was in the tree
    waited_for: str = ""  # the edge that came last
    lookups: dict[str, Lookups] = field(default_factory=dict)


@dataclass
class SensorLog:
    """The stamped messages of one topic, by the frames that they name."""

    topic: str
    kind: str
    frames: dict[str, FrameUse] = field(default_factory=dict)


def ready_at(chain: Sequence[Series], start: int) -> tuple[int, str]:
    """Return from when on (ns) all edges of a chain were there, and the edge that came last.

    An edge on /tf_static was there since it was stamped: a recorder that joins later gets it late. One on /tf that
    comes within the first second of a recording was there before.
    """
    ready, last = start, ""
    for series in chain:
        came = series.pace.first
        if series.still and series.pace.first_stamp > 0:
            came = min(came, series.pace.first_stamp)
        elif not series.still and came - start <= SECOND:
            came = start
        if came > ready:
            ready, last = came, series.name
    return ready, last


def look_up(use: FrameUse, headers: Headers, chain: Sequence[Series], target: str) -> None:
    """Ask for the transform to ``target`` at each stamp, with what had been received by then.

    tf2 answers at a stamp if every moving edge of the chain has a sample on both sides of it
    (tf2/src/time_cache.cpp, ExtrapolationException).
    """
    moving = [series for series in reversed(chain) if not series.still]
    lookups = use.lookups.setdefault(target, Lookups(target))
    begin = max([series.pace.first_stamp for series in moving] + [use.ready or 0])
    fit = (headers.stamp >= begin) & (headers.received >= begin)
    received, stamp = headers.received[fit], headers.stamp[fit]
    lookups.asked += len(stamp)
    if not moving or not len(stamp):
        return
    lags = np.stack([stamp - newest_at(series, received) for series in moving])
    worst = lags.argmax(axis=0)
    lag = lags[worst, np.arange(len(stamp))]
    failed = lag > 0
    lookups.failed += int(np.count_nonzero(failed))
    if not failed.any():
        return
    late = lag[failed] / SECOND
    lookups.lag_sum += float(late.sum())
    lookups.lag_most = max(lookups.lag_most, float(late.max()))
    for at, count in zip(*np.unique(worst[failed], return_counts=True), strict=True):
        name = moving[int(at)].name
        lookups.slowest[name] = lookups.slowest.get(name, 0) + int(count)


def newest_at(series: Series, received: Times) -> Times:
    """Return the newest stamp (n,) that an edge had at times of this batch (n,), a very small one where it had none."""
    before = np.iinfo(np.int64).min // 2 if series.known_before is None else series.known_before
    at = np.searchsorted(series.known[0], received, side="right") - 1
    if not series.known.shape[1]:
        return np.full(len(received), before)
    return np.where(at >= 0, series.known[1, np.maximum(at, 0)], before)

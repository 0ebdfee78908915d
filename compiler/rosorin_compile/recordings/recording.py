"""The class ``Recording``, which collects messages by transform (edge), joint and topic."""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import Diagnostic

from .expected_edges import Description
from .results import Lookup
from .series import SECOND, EdgeKey, Gap, JointStates, Messages, Pace, Series, Times

_NO_TIMES: Times = np.empty(0, np.int64)


class Rows:
    """A growing table of messages: (time of arrival, stamp, values) for a transform, a joint or a topic."""

    def __init__(self) -> None:
        self._times = array("q")
        self._values, self._width = array("d"), 0

    def add(self, received: int, stamp: int, values: Sequence[float] = ()) -> None:
        """Add a message; times are in ns, and the number of values is the same for all messages."""
        self._times.extend((received, stamp))
        self._values.extend(values)
        self._width = len(values)

    @property
    def times(self) -> Times:
        """Times of arrival and stamps (2, n) in ns."""
        return np.asarray(np.frombuffer(self._times, np.int64).reshape(-1, 2).T, np.int64)

    def messages(self, clock: Times | None) -> Messages:
        """Return the messages. ``clock`` (2, n; ns), if not None, maps times of arrival to times of another clock."""
        received, stamps = self.times
        received = received if clock is None else np.interp(received, *clock).astype(np.int64)
        return Messages(received, stamps, np.frombuffer(self._values, np.float64).reshape(len(stamps), self._width))


class PrintedTransform(NamedTuple):
    """A transform printed by tf2_echo: translation and rotation (None if not printed), and their rounding errors."""

    xyz: Vector | None
    turn: Transform | None
    metres: float
    radians: float


class Answer(NamedTuple):
    """A transform that tf2_echo printed, the pose of ``target`` in ``source``, and its line number in the text.

    ``why`` is the error message if tf2 found no transform. ``positions`` are the known joint positions (rad or m).
    """

    source: str
    target: str
    line: int
    readings: tuple[PrintedTransform, ...] = ()
    why: str = ""
    positions: Mapping[str, float] = {}

    @property
    def name(self) -> str:
        return f"{self.source} -> {self.target}"


class FrameRow(NamedTuple):
    """A transform in the output of view_frames: rate in Hz, and age of the newest sample in s, or None if unknown."""

    parent: str
    child: str
    static: bool
    rate: float
    age: float | None


@dataclass
class FrameUse:
    """The messages on a topic that have the same frame_id in their header. Times are in ns."""

    topic: str
    type: str
    frame: str
    pace: Pace
    slashed: int = 0  # messages with a leading "/" in the frame
    early: int = 0  # messages that arrived before the frame was connected to the tree
    ready: int | None = None  # time when the frame was connected to the tree, or None
    waited_for: str = ""  # the edge that arrived last and connected the frame
    lookups: dict[str, Lookup] = field(default_factory=dict)
    slowest: dict[str, Series] = field(default_factory=dict)  # by target frame: edge with most failed lookups


class Recording:
    """The contents of a recording. Readers add messages, then call ``finish``, which computes the statistics.

    If ``complete``, edges that are not recorded were not published; if ``timed``, times of arrival are known.
    The statistics are in ``series`` (edges), ``joints`` and ``uses`` (topics by frame_id).
    """

    def __init__(self, description: Description, form: str, complete: bool = False, timed: bool = False) -> None:
        self.description, self.form, self.complete, self.timed = description, form, complete, timed
        self.start = self.end = self.messages = 0
        self.silence = Gap()  # the longest time without any message
        self.topics: dict[str, str] = {}
        self.edges: dict[EdgeKey, Rows] = {}
        self.states, self.positions = Rows(), dict[str, Rows]()  # headers of /joint_states, and positions by joint
        self.short_states = 0  # messages of /joint_states with fewer positions than names
        self.headers: dict[tuple[str, str, str], Rows] = {}  # key: topic, type, frame
        self.slashed: dict[tuple[str, str], int] = {}  # number of messages with a leading "/", by topic and frame
        self.descriptions = dict[bytes, None]()  # the texts of /robot_description
        self.troubles = list[Diagnostic]()
        self.answers, self.refused, self.rows = list[Answer](), list[Answer](), list[FrameRow]()
        self.dropped: dict[EdgeKey, int] = {}  # number of transforms that tf2 rejects, by edge
        self.tree_frames: set[str] = set()  # names of frames as recorded, with the prefix
        self.series: dict[EdgeKey, Series] = {}
        self.parents: dict[str, str] = {}
        self.uses: list[FrameUse] = []
        self.joints: JointStates

    def frame(self, name: str) -> str:
        """Convert a recorded frame_id to the name in the description: remove a leading "/" and the option ``prefix``.

        If a link name lacks the prefix, return "NAME without PREFIX", because the frame belongs to another robot.
        """
        name, prefix = name.removeprefix("/"), self.description.options.prefix
        if prefix and not name.startswith(prefix) and name in self.description.robot.link:
            return f"{name} without {prefix}"
        return name.removeprefix(prefix)

    def tree_frame(self, name: str) -> str:
        """Convert the frame_id of a transform as ``frame`` does, and add the recorded name to ``tree_frames``."""
        self.tree_frames.add(name.removeprefix("/"))
        return self.frame(name)

    def add_state(self, received: int, stamp: int, names: Sequence[str], positions: Sequence[float]) -> None:
        """Add a message of /joint_states: times in ns, positions in rad or m."""
        self.states.add(received, stamp)
        self.short_states += 0 < len(positions) < len(names)
        for name, position in zip(names, positions, strict=False):  # positions can be empty
            self.positions.setdefault(name, Rows()).add(received, stamp, (position,))

    def add_header(self, received: int, stamp: int, topic: str, message_type: str, frame: str) -> None:
        """Add the std_msgs/Header of a message; times are in ns."""
        name = self.frame(frame)
        self.headers.setdefault((topic, message_type, name), Rows()).add(received, stamp)
        if frame.startswith("/"):
            self.slashed[topic, name] = self.slashed.get((topic, name), 0) + 1

    def finish(self, clock: Times | None = None) -> None:
        """Compute ``series``, ``joints`` and ``uses`` after all messages are added.

        ``clock`` (2, n; ns), if not None, maps times of arrival (first row, ascending) to times of another clock.
        """
        pace = Pace(*self.states.messages(clock)[:2], self.start, self.timed)
        states = {name: rows.messages(clock) for name, rows in self.positions.items()}
        self.joints = JointStates(self.description.robot, pace, states)
        for key, rows in self.edges.items():
            if key.parent == key.child or not key.parent or not key.child:
                self.dropped[key] = rows.times.shape[1]
            elif not self._is_of_other_robot(key.child):
                samples = rows.messages(clock)
                self._add_series(key, samples, Pace(*samples[:2], self.start, self.timed))
        for row in self.rows:
            key = EdgeKey(row.static, row.parent, row.child)
            if key not in self.series:
                pace = Pace(_NO_TIMES, _NO_TIMES, 0, False)
                pace.rate = row.rate
                series = self._add_series(key, Messages(_NO_TIMES, _NO_TIMES, np.empty((0, 7))), pace)
                series.listed, series.age = True, row.age
        for (topic, message_type, frame), rows in self.headers.items():
            if not self._is_of_other_robot(frame):
                pace = Pace(*rows.messages(clock)[:2], self.start, self.timed)
                use = FrameUse(topic, message_type, frame, pace, self.slashed.get((topic, frame), 0))
                self.uses.append(use)
                if self.timed:
                    self._look_up_all(use)

    def _add_series(self, key: EdgeKey, samples: Messages, pace: Pace) -> Series:
        series = self.series[key] = Series(key, samples, pace, self.description, self.joints)
        if key.child not in self.parents or series.has_parent:
            self.parents[key.child] = key.parent
        return series

    def _is_of_other_robot(self, frame: str) -> bool:
        name = frame.rpartition("/")[2]
        foreign = bool(self.description.options.prefix) and "/" in frame and " " not in frame
        return foreign and (name in self.description.frames or name in self.description.robot.link)

    def since_start(self, time: int) -> float:
        """Convert a time (ns) to seconds since the start of the recording."""
        return max(0, time - self.start) / SECOND

    @cached_property
    def edges_by_child(self) -> Mapping[str, list[Series]]:
        """The recorded edges by child frame, in the order in which they first occurred."""
        by_child: dict[str, list[Series]] = {}
        for series in self.series.values():
            by_child.setdefault(series.child, []).append(series)
        return by_child

    def chain(self, frame: str, target: str) -> list[Series] | None:
        """Return the recorded edges from a frame up to its ancestor ``target``, or None if there is no path."""
        chain: list[Series] = []
        while frame != target:
            if (parent := self.parents.get(frame)) is None or len(chain) > len(self.parents):
                return None
            chain.append(self.series.get(EdgeKey(True, parent, frame)) or self.series[EdgeKey(False, parent, frame)])
            frame = parent
        return chain

    def _look_up_all(self, use: FrameUse) -> None:
        """Simulate tf2 lookups from a frame to the robot base, and to the parent of the base, such as odom."""
        start, base = self.start, self.description.top(use.frame)
        if (chain := self.chain(use.frame, base)) is None:
            use.early = use.pace.count
        else:
            use.ready = start
            for series in chain:
                came = series.pace.first
                if series.static and series.pace.first_stamp > 0:  # published before the recorder subscribed
                    came = min(came, series.pace.first_stamp)
                elif not series.static and came - start <= SECOND:  # probably published before the recording
                    came = start
                if came > use.ready:
                    use.ready, use.waited_for = came, series.name
            use.early = int(np.count_nonzero(use.pace.received < use.ready))
            if chain or use.frame == base:
                _look_up(use, chain, base)
        if (above := self.parents.get(base, "")) and (chain := self.chain(use.frame, above)):
            _look_up(use, chain, above)


def _look_up(use: FrameUse, chain: Sequence[Series], target: str) -> None:
    """Count the messages for which lookupTransform to ``target`` at their stamp would fail when they arrive.

    A lookup fails if the stamp is newer than the newest transform of a moving edge (tf2/src/time_cache.cpp).
    """
    moving = [series for series in reversed(chain) if not series.static]
    begin = max([series.pace.first_stamp for series in moving] + [use.ready or 0])
    fit = (use.pace.stamps >= begin) & (use.pace.received >= begin)
    received, stamps = use.pace.received[fit], use.pace.stamps[fit]
    use.lookups[target] = Lookup(target, len(stamps))
    if not moving or not len(stamps):
        return
    lags = []
    for series in moving:
        at = np.searchsorted(series.pace.received, received, side="right") - 1
        lags.append(stamps - np.where(at >= 0, series.newest[np.maximum(at, 0)], np.iinfo(np.int64).min // 2))
    lag, worst = np.max(lags, axis=0), np.argmax(lags, axis=0)
    if (late := lag[lag > 0] / SECOND).size:
        use.lookups[target] = Lookup(target, len(stamps), len(late), float(late.mean()), float(late.max()))
        use.slowest[target] = moving[int(np.bincount(worst[lag > 0]).argmax())]

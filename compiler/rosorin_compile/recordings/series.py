"""Statistics of messages (rates, gaps, clocks, duplicate publishers), of joint states, and of recorded transforms.

Quaternions are (x, y, z, w) as in ROS.
"""

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rosorin_compile.model import Joint, Robot, Transform

from .expected_edges import EXACT, SIX_ANGLE, Description, ExpectedEdge
from .results import YEAR, RecordedJoint

Floats = NDArray[np.float64]
Times = NDArray[np.int64]

SECOND = 1_000_000_000
SLICES = 240  # maximum number of time slices that a recording is divided into
JUMP = SECOND // 10  # ns: a larger decrease of the stamp is a jump; messages can overtake each other by less
SIMULATED = 10**8 * SECOND  # ns: earlier stamps (before 1973) are simulation time, which starts at 0
APART = 60.0  # s: if all stamps differ from their times of arrival by more, they are from another clock

# To detect that a clock was set, compare three time slices before with three slices after, each at least 0.8 s wide.
_SLICE, _SIDE = 8 * SECOND // 10, 3
# The smallest change of a clock to report (s); if no stamp is in the future, a change below _DELAY may be a delay.
_STEP, _DELAY = 0.25, 5.0
AHEAD = 0.1  # s: stamps that are less far in the future are ignored, because clocks are not exactly synchronized
TREMBLING = 0.02  # rad or m: amplitude of a servo that holds a position
_SLIDING = 1e-3  # m: tolerance for the position of a prismatic mimic joint
_BEYOND = 1e-6


class Gap(NamedTuple):
    """A duration and a time (ns): a pause and its start, or the age of the newest data and when it had this age."""

    seconds: float = 0.0
    at: int = 0


class Step(NamedTuple):
    """A change of a clock: the time (ns), and how far stamps were ahead of arrival (s) before and after it."""

    time: int
    before: float
    after: float
    size: float


class Pace:
    """Rates, gaps and ages of messages on a topic, in order of arrival. Times are in ns, ages and gaps in s.

    ``start`` is the start of the recording; ``timed`` is True if times of arrival are known.
    """

    def __init__(self, received: Times, stamps: Times, start: int, timed: bool) -> None:
        self.received, self.stamps, self.start, self.timed = received, stamps, start, timed
        self.count = len(received)
        stamped = stamps != 0  # zero means no stamp
        self.zeros = self.count - int(np.count_nonzero(stamped))
        self.first, self.last = (int(received[0]), int(received[-1])) if self.count else (0, 0)
        self.first_stamp = int(stamps[0]) if self.count else 0
        self.newest = int(stamps.max(initial=0))
        span = self.last - self.first
        self.rate = (self.count - 1) * SECOND / span if self.count > 1 and span > 0 else math.nan  # Hz
        ahead = (stamps - received)[stamped] / SECOND
        self.most_ahead, self.least_ahead = float(ahead.max(initial=-math.inf)), float(ahead.min(initial=math.inf))
        self.mean_age = -float(ahead.mean()) if timed and len(ahead) else math.nan
        self.gap = _longest(np.diff(received), received)
        self.largest_gap = self.gap.seconds if timed else None
        falls = np.where(stamps[1:] != 0, -np.diff(stamps), 0)
        self.jumps = int(np.count_nonzero(falls > JUMP))
        self.farthest_jump = _longest(falls, received[1:])
        self.repeated = int(np.count_nonzero((np.diff(stamps) == 0) & (stamps[1:] != 0)))
        # The age of the newest data is largest just before the next message arrives.
        newest, came = np.maximum.accumulate(stamps[stamped]), received[stamped]
        self.oldest = _longest(came - np.concatenate((newest[:1], newest[:-1])), came)
        # In a simulation, time starts at zero, so a few zero stamps at the start are valid.
        begins = self.first_stamp == 0 and self.newest < SIMULATED and self.zeros <= max(1, self.count // 20)
        self.unstamped = self.zeros > 0 and not begins
        # If stamps advance slower than half the rate of arrival, the data is old, rather than stamped by another clock.
        limit = APART if self.newest - self.first_stamp > span / 2 > 0 else YEAR
        self.other_clock = timed and len(ahead) > 0 and (self.least_ahead > APART or self.most_ahead < -limit)

    @property
    def alternates(self) -> bool:
        """Return True if the stamps look like those of two publishers with the same rate.

        In this case, the time between successive stamps varies, but the time between every other stamp is constant.
        """
        one, two = np.diff(self.stamps) / SECOND, (self.stamps[2:] - self.stamps[:-2]) / SECOND
        if len(one) < 20 or one.sum() <= 0:
            return False
        return bool(one.var() > (0.15 * one.mean()) ** 2 and two.var() < 0.1 * one.var())

    def oldest_until(self, end: int) -> Gap:
        """Return the maximum age of the latest data at any time up to the end (ns) of the recording, as a Gap."""
        rest = (end - self.newest) / SECOND
        return Gap(rest, end) if rest > self.oldest.seconds else self.oldest

    def slices(self, width: int) -> Times:
        """Return the index of the time slice in which each message arrived (n,); slices are ``width`` ns wide."""
        return np.asarray(np.clip((self.received - self.start) // width, 0, SLICES - 1), np.int64)

    @cached_property
    def step(self) -> Step | None:
        """The largest change of the publisher's clock: a jump (the clock was set) or a steady drift; None if neither.

        This compares stamps with times of arrival, using the message with the shortest delay in each time slice.
        The differences before and after the change must be steady, so that growing delays are not reported.
        """
        width = slice_width(int(self.received.max(initial=self.start)) - self.start, _SLICE)
        leads, stamped = np.full(SLICES, -np.inf), self.stamps != 0
        np.maximum.at(leads, self.slices(width)[stamped], (self.stamps - self.received)[stamped] / SECOND)
        places = np.flatnonzero(np.isfinite(leads))
        if len(places) < 2 * _SIDE:
            return None
        leads, best = leads[places], _drift(leads[places], self.start)
        sides = np.sort(np.lib.stride_tricks.sliding_window_view(leads, _SIDE), axis=1)
        for time, before, after in zip(places[_SIDE:], sides, sides[_SIDE:], strict=False):
            low, high = float(before[_SIDE // 2]), float(after[_SIDE // 2])
            step = Step(self.start + int(time) * width, low, high, abs(high - low))
            steady = max(np.ptp(before), np.ptp(after)) < step.size / 4
            large = step.size > (_STEP if max(before[-1], after[-1]) > AHEAD else _DELAY)
            best = step if steady and large and (best is None or step.size > best.size) else best
        return best


def slice_width(span: int, width: int = SECOND // 10) -> int:
    """Return the width (ns) of time slices, at least ``width``, so that at most ``SLICES`` cover ``span`` ns."""
    while span // width >= SLICES:
        width *= 2
    return width


def _longest(spans: Times, times: Times) -> Gap:
    at = int(spans.argmax()) if len(spans) else 0
    return Gap(float(spans[at] / SECOND), int(times[at])) if len(spans) and spans[at] > 0 else Gap()


def _drift(leads: Floats, start: int) -> Step | None:
    """Return the drift of a clock if ``leads`` (stamp minus arrival, s) change linearly, or None."""
    at = np.arange(len(leads))
    line = np.polyval(np.polyfit(at, leads, 1), at)
    step = Step(start, float(line[0]), float(line[-1]), float(abs(line[-1] - line[0])))
    even = np.abs(leads - line).max() < step.size / 8
    return step if even and step.size > _STEP and min(step.before, step.after) > -AHEAD else None


LEAP = 5e-3  # m or rad: smallest change between two messages that may be a change of the publisher
# Two publishers are likely if leaps back exceed this share of all messages and of all leaps, and reach this number.
_SHARE, _RETURNING, _FEWEST = 0.2, 0.45, 4

Distance = Callable[[Floats, Floats], Floats]


def _max_difference(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.abs(one - other).max(axis=1, initial=0.0), np.float64)


class Leaps:
    """Signs of two publishers: leaps back to an earlier value, and different values with the same stamp.

    ``values`` (n, k) are in order of arrival. Successive values whose ``distance`` exceeds ``leap`` are a leap.
    """

    def __init__(self, stamps: Times, values: Floats, distance: Distance = _max_difference, leap: float = LEAP) -> None:
        self.steps = max(1, len(stamps) - 1)
        far = distance(values[1:], values[:-1])
        again = np.flatnonzero((np.diff(stamps) == 0) & (stamps[1:] != 0) & (far > 2 * SIX_ANGLE)) + 1
        leaping = np.flatnonzero(far > leap) + 1
        back = np.full(len(leaping), np.inf)
        for lag in range(2, 7):
            lands = distance(values[leaping], values[np.maximum(leaping - lag, 0)])
            back = np.minimum(back, np.where(leaping >= lag, lands, np.inf))
        returned = leaping[back < 0.1 * far[leaping - 1]]
        self.contradictions, self.leaps, self.returns = len(again), len(leaping), len(returned)
        self.largest = float(far[returned - 1].max(initial=0.0))
        first = min([*again[:1], *returned[:1]], default=0)
        self.pair = values[first - 1 : first + 1]  # the first two values that differ, or empty
        self.contradict = self.contradictions >= 3  # fewer can be a coincidence
        returns = self.returns >= _FEWEST and self.returns > max(_SHARE * self.steps, _RETURNING * self.leaps)
        self.two = self.contradict or returns  # two publishers seem to send different values


class Messages(NamedTuple):
    """Messages in order of arrival: times of arrival and stamps in ns (n,), and values (n, k).

    The values of a transform are x, y, z in m and a quaternion; the value of a joint state is a position in rad or m.
    """

    received: Times
    stamps: Times
    values: Floats

    def transform(self, at: int) -> Transform:
        """Return the message at an index as a transform."""
        return transform_from(self.values[at])


class JointStates:
    """The messages on /joint_states: ``pace`` has statistics of all messages, ``states`` the positions by joint."""

    def __init__(self, robot: Robot, pace: Pace, states: Mapping[str, Messages]) -> None:
        self.robot, self.pace = robot, pace
        self.leaps = Leaps(np.empty(0, np.int64), np.empty((0, 1)))  # leaps of the first joint that has two publishers
        self._states: dict[str, Messages] = {}  # key: joint name; messages are ordered by stamp
        self.reported: dict[str, RecordedJoint] = {}
        for name, messages in states.items():
            leaps = Leaps(messages.stamps, messages.values, leap=TREMBLING)
            self.leaps = leaps if leaps.two and not self.leaps.two else self.leaps
            order = np.lexsort((messages.received, messages.stamps))
            self._states[name] = Messages(messages.received[order], messages.stamps[order], messages.values[order])
            good, (lower, upper) = messages.values[np.isfinite(messages.values)], self.limits(name)
            beyond = int(np.count_nonzero((good < lower - _BEYOND) | (good > upper + _BEYOND)))
            lowest, highest = (float(good.min()), float(good.max())) if len(good) else (None, None)
            count = len(messages.stamps)
            self.reported[name] = RecordedJoint(name, lowest, highest, count, beyond, count - len(good))
        for joint in robot.joints:
            if joint.mimic is not None and joint.name in self._states:
                self._compare_follower(joint, robot.joint[joint.mimic.joint])

    def limits(self, name: str) -> tuple[float, float]:
        """Return the lower and upper limit of a joint (rad or m), or infinities if it has no limits."""
        joint = self.robot.joint.get(name)
        if joint is None or joint.limit is None or joint.type == "continuous":
            return -np.inf, np.inf
        lower, upper = joint.limit.lower, joint.limit.upper
        return (-np.inf if lower is None else lower), (np.inf if upper is None else upper)

    def position(self, joint: Joint, stamps: Times, received: Times) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the positions (n,) that robot_state_publisher used for transforms with these stamps (n,), and a mask.

        The mask (n,) is False where the position is unknown. If several joint states have the same stamp, the state
        closest to ``received`` is used. A recorded position of a mimic joint takes precedence over the joint that it
        follows (``callbackJointState`` of robot_state_publisher).
        """
        positions, known = np.zeros(len(stamps)), np.zeros(len(stamps), bool)
        if (states := self._states.get(joint.name)) is not None:
            first = np.minimum(np.searchsorted(states.stamps, stamps, side="left"), len(states.stamps) - 1)
            last = np.maximum(np.searchsorted(states.stamps, stamps, side="right") - 1, 0)
            is_later = np.abs(states.received[last] - received) < np.abs(states.received[first] - received)
            positions = states.values[np.where(is_later, last, first), 0]
            known = (states.stamps[first] == stamps) & (stamps != 0) & np.isfinite(positions)
        if joint.mimic is None or known.all():
            return positions, known
        leader, there = self.position(self.robot.joint[joint.mimic.joint], stamps, received)
        return np.where(known, positions, joint.mimic.multiplier * leader + joint.mimic.offset), known | there

    def _compare_follower(self, joint: Joint, leader: Joint) -> None:
        """Count the positions of a mimic joint that do not follow ``leader``, unless full turns make them ambiguous."""
        turns, mimic, states = leader.type == "continuous", joint.mimic, self._states[joint.name]
        if mimic is None or (turns and not float(mimic.multiplier).is_integer()):
            return
        positions, known = self.position(leader, states.stamps, states.received)
        apart = (states.values[:, 0] - mimic.multiplier * positions - mimic.offset)[known]
        slides, apart = joint.type == "prismatic", apart[np.isfinite(apart)]
        if (turns or joint.type == "continuous") and not slides:
            apart = np.remainder(apart + np.pi, 2 * np.pi) - np.pi
        report, apart = self.reported[joint.name], np.abs(apart)
        report.compared, report.farthest = len(apart), float(apart.max(initial=0.0))
        report.wrong = int(np.count_nonzero(apart > (_SLIDING if slides else TREMBLING)))


class EdgeKey(NamedTuple):
    """A transform parent -> child (an edge) on a topic; ``static`` is True for /tf_static, False for /tf."""

    static: bool
    parent: str
    child: str


class Series:
    """The recorded transforms parent -> child on /tf_static (``static``) or /tf; ``edge`` is the expected edge or None.

    If ``listed``, only the output of view_frames is known; ``age`` is the age (s) of the newest transform, or None.
    """

    def __init__(self, key: EdgeKey, samples: Messages, pace: Pace, tree: Description, joints: JointStates) -> None:
        self.static, self.parent, self.child = static, parent, child = key
        self.name, self.topic, self.pace = f"{parent} -> {child}", "/tf_static" if static else "/tf", pace
        self.listed = False
        self.age: float | None = None
        square = np.square(samples.values[:, 3:]).sum(axis=1)
        # tf2 drops transforms if the squared norm of the quaternion is not within 0.01 of 1 (tf2/src/buffer_core.cpp).
        good = np.isfinite(samples.values[:, :3]).all(axis=1) & (np.abs(square - 1.0) <= 10e-3)
        self.bad = int(np.count_nonzero(~good))
        self.first_bad = int(samples.received[~good][0]) if self.bad else 0
        self.samples = samples = samples if not self.bad else Messages(*(values[good] for values in samples))
        places, turns = samples.values[:, :3], _normalised(samples.values[:, 3:])
        self.edge = edge = tree.edge_like(parent, child, static, samples.transform(0) if len(turns) else None)
        self.owner = tree.owners(child)  # ROS node that should publish the edge, or "" if unknown
        self.by_owner = f" ({self.owner})" if self.owner else ""
        self.constant = static or (edge is not None and not edge.moving)
        self.has_parent = edge is not None and edge.parent == parent  # the parent is as described
        self.compared = self.by_state = self.wrong = self.others = 0
        self.first_wrong: tuple[Transform, Transform, int] | None = None  # recorded, described, time of arrival (ns)
        self.first_other: Transform | None = None
        if self.constant and len(turns):
            same = np.abs(places - places[0]).max(axis=1) <= EXACT
            same &= _angles(turns, turns[0]) <= SIX_ANGLE
            self.others = int(np.count_nonzero(~same))  # number of samples that differ from the first sample
            self.first_other = samples.transform(int(same.argmin())) if self.others else None
        if edge is None or edge.transform is None or not self.has_parent or not len(turns):
            return
        if edge.moving and (edge.joint is None or not edge.joint.moves):
            return
        xyz, quaternions, self.by_state = _expected_values(edge, samples, joints)
        metres, radians = np.linalg.norm(places - xyz, axis=1), _angles(turns, quaternions)
        wrong = (metres > EXACT) | (radians > edge.radians)
        self.compared, self.wrong = len(wrong), int(np.count_nonzero(wrong))
        if self.wrong:
            at = int(wrong.argmax())
            described = transform_from(np.concatenate((xyz[at], quaternions[at])))
            self.first_wrong = (samples.transform(at), described, int(samples.received[at]))

    @cached_property
    def newest(self) -> Times:
        """The newest stamp that had been received when each message arrived (n,)."""
        return np.asarray(np.maximum.accumulate(self.pace.stamps), np.int64)

    @cached_property
    def leaps(self) -> Leaps:
        """The signs that two ROS nodes publish this edge; empty for a static edge."""
        return Leaps(self.samples.stamps[: 0 if self.constant else None], self.samples.values, _distance)

    @property
    def has_two_sources(self) -> bool:
        """Return True if two ROS nodes seem to publish different values, unless all values are as described."""
        return not self.constant and self.leaps.two and not (self.compared and not self.wrong)


def _expected_values(edge: ExpectedEdge, samples: Messages, joints: JointStates) -> tuple[Floats, Floats, int]:
    """Return the expected xyz (n, 3) and quaternions (n, 4) of samples, and the number of samples with a joint state.

    For a sample without a joint state, this is the nearest transform that a position of the joint can produce.
    """
    count, joint, origin = len(samples.stamps), edge.joint, edge.transform or Transform()
    w, x, y, z = origin.quaternion()
    xyz, turns = np.tile(np.array(origin.xyz, np.float64), (count, 1)), np.tile(np.array((x, y, z, w)), (count, 1))
    if not edge.moving or joint is None:
        return xyz, turns, 0
    axis = np.array(joint.axis, np.float64) / np.linalg.norm(joint.axis)
    positions, known = joints.position(joint, samples.stamps, samples.received)
    by_state = int(np.count_nonzero(known))
    if joint.type == "prismatic":
        along = np.array(origin.rotate(tuple(axis.tolist())), np.float64)
        positions = np.where(known, positions, (samples.values[:, :3] - xyz) @ along)
        return xyz + positions[:, None] * along, turns, by_state
    rest = _product(turns * (-1.0, -1.0, -1.0, 1.0), _normalised(samples.values[:, 3:]))
    half = 0.5 * np.where(known, positions, 2.0 * np.arctan2(rest[:, :3] @ axis, rest[:, 3]))[:, None]
    return xyz, _product(turns, np.concatenate((np.sin(half) * axis, np.cos(half)), axis=1)), by_state


def transform_from(pose: Floats) -> Transform:
    """Convert a pose (7,) of x, y, z and a quaternion to a transform."""
    px, py, pz, x, y, z, w = pose.tolist()
    return Transform.of_quaternion((px, py, pz), (w, x, y, z))


def _distance(one: Floats, other: Floats) -> Floats:
    """Return distances (n,) between poses (n, 7): the maximum of translation (m) and rotation (rad)."""
    metres = _max_difference(one[:, :3], other[:, :3])
    radians = 2.0 * np.minimum(*(_max_difference(one[:, 3:], sign * other[:, 3:]) for sign in (1, -1)))
    return np.asarray(np.maximum(metres, radians), np.float64)


def _normalised(quaternions: Floats) -> Floats:
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1)[:, None], np.float64)


def _product(a: Floats, b: Floats) -> Floats:
    u, v, s, t = a[..., :3], b[..., :3], a[..., 3:], b[..., 3:]
    return np.concatenate((s * v + t * u + np.cross(u, v), s * t - (u * v).sum(axis=-1, keepdims=True)), axis=-1)


def _angles(a: Floats, b: Floats) -> Floats:
    """Return the angles (n,) from 0 to pi between two rotations, given as quaternions (n, 4) or (4,)."""
    turn = _product(a * (-1.0, -1.0, -1.0, 1.0), b)
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(turn[..., :3], axis=-1), np.abs(turn[..., 3])), np.float64)

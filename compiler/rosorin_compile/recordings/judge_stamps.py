"""Judging stamps: streams without a clock, with another clock than the recorder's, and with one that is set meanwhile.

What several streams share is told once: they come from one computer, or follow one node.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, first_of
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND
from .findings import YEAR, problem, seconds
from .judge_edges import owner_of, two_values
from .pace import SIMULATED, Pace, Step, step_of
from .recording import Recording

RULES = (
    Rule(
        "stamp-zero",
        "Messages are stamped with time zero.",
        "A node with `use_sim_time` hears no `/clock`.",
        Heading.RECORDINGS,
    ),
    Rule(
        "stamp-jumps-back",
        "Stamps jump back by more than 0.1 s.",
        "One clock for all nodes, which nobody sets while they run.",
        Heading.RECORDINGS,
    ),
    Rule(
        "stamp-other-clock",
        "Messages are stamped by another clock than the others: the time of a simulation among wall clocks, a clock "
        "that begins in 1970, one that is a minute or more away.",
        "`use_sim_time` for all nodes or for none; set the clocks of the computers.",
        Heading.RECORDINGS,
    ),
    Rule(
        "stamp-ahead",
        "A warning: messages are dated further ahead of the time when they were recorded than AMCL does it (1 s).",
        "Set the clock of the computer, or the parameter that dates ahead.",
        Heading.RECORDINGS,
    ),
    Rule(
        "stamp-clock-set",
        "A warning: how far stamps are ahead of the time when they were recorded, or behind it, changed meanwhile.",
        "Set the clocks of all computers before the nodes start.",
        Heading.RECORDINGS,
    ),
)

_MANY = 3
# AMCL dates map -> odom a second ahead (transform_tolerance), slam_toolbox half a second; told is more than this (s).
FAR_AHEAD = 1.2
# Streams whose clocks are as near to each other (a part, or s) share one.
_ALIKE, _NEAR = 0.1, 0.1


class Stream(NamedTuple):
    """Stamped messages that come one after the other: an edge, the joint states, or a topic; its name and times."""

    name: str
    pace: Pace


def streams(recording: Recording) -> list[Stream]:
    """Return the streams of a recording; what two nodes publish in turns is none."""
    found = []
    for series in recording.series.values():
        if not series.still and not two_values(series):
            found.append(Stream(f"{series.name}{owner_of(series)}", series.pace))
    if recording.joints.pace.count:
        found.append(Stream("/joint_states", recording.joints.pace))
    for log in recording.sensors.values():
        found += [Stream(log.topic, use.pace) for use in log.frames.values()]
    return found


def clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the clocks that stamp."""
    every = streams(recording)
    yield from _zero([one for one in every if one.pace.unstamped])
    yield from _back(recording, [one for one in every if one.pace.jumps])
    if not recording.timed:
        return
    there = [one for one in every if not one.pace.unstamped]
    other = [one for one in there if one.pace.other_clock]
    for ahead in (False, True):
        yield from _other(recording, [one for one in other if (one.pace.most_ahead > 0) == ahead])
    there = [one for one in there if not one.pace.other_clock]
    steps = [(one, step_of(one.pace.bins)) for one in there if not one.pace.jumps]
    yield from _steps(recording, [(one, step) for one, step in steps if step is not None], len(there))
    yield from _ahead([one for one in there if one.pace.most_ahead > FAR_AHEAD], len(there))


def of_rows(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the clocks of the edges that view_frames saw."""
    rows = [row for row in recording.rows if not row.still and row.age is not None and math.isfinite(row.age)]
    every = [Stream(f"{row.parent} -> {row.child}", Pace(most_ahead=-(row.age or 0.0))) for row in rows]
    for ahead in (False, True):
        sign = 1 if ahead else -1
        yield from _other(recording, [one for one in every if sign * one.pace.most_ahead > YEAR])
    yield from _ahead([one for one in every if FAR_AHEAD < one.pace.most_ahead <= YEAR], len(every))


def _zero(zero: Sequence[Stream]) -> Iterator[Diagnostic]:
    if not zero:
        return
    message = f"{_names(zero)} {'is' if len(zero) == 1 else 'are'} stamped with time zero"
    help = "a node with use_sim_time that hears no /clock, or a driver that does not set the stamp"
    yield problem("stamp-zero", zero[0].name, message, help, numbers={"streams": [one.name for one in zero]})


def _back(recording: Recording, back: Sequence[Stream]) -> Iterator[Diagnostic]:
    if not back:
        return
    name, pace = max(back, key=lambda stream: stream.pace.farthest.seconds)
    at = (pace.farthest.began - (recording.start or 0)) / SECOND
    where = f", {at:.1f} s into the recording" if recording.timed else ""
    message = f"the stamps of {_names(back)} jump back, by {seconds(pace.farthest.seconds)} at most{where}"
    help = "a clock was set, a simulation or a bag began anew, or two nodes stamp with two clocks"
    yield problem("stamp-jumps-back", name, message, help, numbers={"streams": [one.name for one in back]})


def _other(recording: Recording, other: Sequence[Stream]) -> Iterator[Diagnostic]:
    if not other:
        return
    far = min(abs(one.pace.most_ahead) for one in other)
    ahead = other[0].pace.most_ahead > 0
    message = f"{_names(other)} {'is' if len(other) == 1 else 'are'} stamped by another clock, {seconds(far)} "
    message += "ahead" if ahead else "behind"
    help = "set the clocks of the computers by NTP"
    if ahead and (recording.start or 0) < SIMULATED:
        help = "the wall clock among times of a simulation: use_sim_time for all nodes or for none"
    elif far > YEAR:
        help = "the time of a simulation (use_sim_time for all nodes or for none), or a computer that begins in 1970"
    numbers = {"seconds": far if ahead else -far, "streams": [one.name for one in other]}
    yield problem("stamp-other-clock", other[0].name, message, help, numbers=numbers)


def _ahead(ahead: Sequence[Stream], every: int) -> Iterator[Diagnostic]:
    waiting = sorted(ahead, key=lambda one: -one.pace.most_ahead)
    while waiting:
        most = waiting[0].pace.most_ahead
        alike = [one for one in waiting if most - one.pace.most_ahead <= max(_NEAR, _ALIKE * most)]
        waiting = waiting[len(alike) :]
        one = len(alike) == 1
        message = f"{_names(alike)} {'is' if one else 'are'} dated {seconds(most)} ahead of the time when "
        message += f"{'it was' if one else 'they were'} recorded"
        help = "AMCL dates 1 s ahead (transform_tolerance), slam_toolbox 0.5 s; "
        help += "what is more is a parameter, or the clock of a computer"
        if len(alike) == every > 1:
            help = "that is every stream there is: the clock of the recorder is behind"
        numbers = {"seconds": most, "streams": [one.name for one in alike]}
        yield problem("stamp-ahead", alike[0].name, message, help, severity=WARNING, numbers=numbers)


def _steps(recording: Recording, steps: Sequence[tuple[Stream, Step]], every: int) -> Iterator[Diagnostic]:
    waiting = sorted(steps, key=lambda one: -one[1].size)
    while waiting:
        first = waiting[0][1]
        alike = [
            one
            for one in waiting
            if abs(one[1].before - first.before) + abs(one[1].after - first.after) <= max(_NEAR, _ALIKE * first.size)
        ]
        waiting = [one for one in waiting if one not in alike]
        at = (first.time - (recording.start or 0)) / SECOND
        names = _names([one for one, _ in alike]) if len(alike) < max(every, 2) else "the recorder"
        message = f"the clock of {names} was set: stamps are {_offset(first.before)} at first, {_offset(first.after)} "
        message += f"from {at:.1f} s into the recording on" if at > 0 else "in the end"
        help = "against the time when they were recorded; tf2 mixes what one clock says with what the other said"
        numbers = {"before": first.before, "after": first.after, "at": at, "streams": [one.name for one, _ in alike]}
        yield problem("stamp-clock-set", alike[0][0].name, message, help, severity=WARNING, numbers=numbers)


def _offset(lead: float) -> str:
    return f"{seconds(abs(lead))} {'ahead' if lead > 0 else 'behind'}"


def _names(every: Sequence[Stream]) -> str:
    return first_of([one.name for one in every], _MANY)

"""Judge stamps: missing ones, those of other clocks, and clocks that were set. Streams with one cause are grouped."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, first_of

from .findings import YEAR, problem, seconds
from .recording import Recording
from .timing import SECOND, SIMULATED, Pace, Step

_SHOWN = 3
# AMCL dates map -> odom 1 s ahead (transform_tolerance), slam_toolbox 0.5 s; more than this (s) is reported.
_FAR_AHEAD = 1.2
# Streams whose clocks differ by less (a share, or s) have the same clock.
_SIMILAR, _NEAR = 0.1, 0.1


class _Stream(NamedTuple):
    """Stamped messages of one source: an edge, the joint states, or a topic."""

    name: str
    pace: Pace


def clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks that stamp."""
    streams = [
        _Stream(f"{one.name} ({one.owner})" if one.owner else one.name, one.pace)
        for one in recording.series.values()
        if not one.static and not one.has_two_sources
    ]
    streams += [_Stream("/joint_states", recording.joints.pace)] if recording.joints.pace.count else []
    streams += [_Stream(use.topic, use.pace) for use in recording.uses]
    yield from _zero([one.name for one in streams if one.pace.unstamped])
    yield from _jumps(recording, [one for one in streams if one.pace.jumps])
    if not recording.timed:
        return
    streams = [one for one in streams if not one.pace.unstamped]
    for ahead in (False, True):
        other = [one for one in streams if one.pace.other_clock and (one.pace.most_ahead > 0) == ahead]
        yield from _other(recording, [(one.name, one.pace.most_ahead) for one in other])
    same = [one for one in streams if not one.pace.other_clock]
    steps = [(one.name, one.pace.step) for one in same if not one.pace.jumps]
    yield from _steps(recording, [(name, step) for name, step in steps if step is not None], len(same))
    yield from _ahead([(one.name, one.pace.most_ahead) for one in same], len(same))


def row_clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks of the edges that view_frames saw."""
    leads = [(row.name, -row.age) for row in recording.rows if not row.static and row.age is not None]
    yield from _other(recording, [(name, lead) for name, lead in leads if lead < -YEAR])
    yield from _other(recording, [(name, lead) for name, lead in leads if lead > YEAR])
    yield from _ahead([(name, lead) for name, lead in leads if lead <= YEAR], len(leads))


def _is_are(names: Sequence[str]) -> str:
    return f"{first_of(names, _SHOWN)} {'is' if len(names) == 1 else 'are'}"


def _zero(names: Sequence[str]) -> Iterator[Diagnostic]:
    if names:
        message = f"{_is_are(names)} stamped with time zero"
        help = "a node with use_sim_time that hears no /clock, or a driver that does not set the stamp"
        yield problem("stamp-zero", names[0], message, help, numbers={"streams": names})


def _jumps(recording: Recording, streams: Sequence[_Stream]) -> Iterator[Diagnostic]:
    if not streams:
        return
    worst = max(streams, key=lambda stream: stream.pace.farthest_jump.seconds)
    far, at = worst.pace.farthest_jump
    where = f", {(at - (recording.start or 0)) / SECOND:.1f} s into the recording" if recording.timed else ""
    names = [one.name for one in streams]
    message = f"the stamps of {first_of(names, _SHOWN)} jump back, by {seconds(far)} at most{where}"
    help = "a clock was set, a simulation or a bag began anew, or two nodes stamp with two clocks"
    yield problem("stamp-jumps-back", worst.name, message, help, numbers={"streams": names})


def _other(recording: Recording, leads: Sequence[tuple[str, float]]) -> Iterator[Diagnostic]:
    """Yield the finding for streams with another clock; ``leads`` (s) are all ahead or all behind."""
    if not leads:
        return
    names, far, ahead = [name for name, _ in leads], min(abs(lead) for _, lead in leads), leads[0][1] > 0
    message = f"{_is_are(names)} stamped by another clock, {seconds(far)} {'ahead' if ahead else 'behind'}"
    help = "set the clocks of the computers by NTP"
    if ahead and (recording.start or 0) < SIMULATED:
        help = "the wall clock among times of a simulation: use_sim_time for all nodes or for none"
    elif far > YEAR:
        help = "the time of a simulation (use_sim_time for all nodes or for none), or a computer that begins in 1970"
    numbers = {"seconds": far if ahead else -far, "streams": names}
    yield problem("stamp-other-clock", names[0], message, help, numbers=numbers)


def _ahead(leads: Sequence[tuple[str, float]], count: int) -> Iterator[Diagnostic]:
    """Yield the findings for streams that are dated ahead (s), of ``count`` streams; each clock once."""
    waiting = sorted((one for one in leads if one[1] > _FAR_AHEAD), key=lambda one: -one[1])
    while waiting:
        most = waiting[0][1]
        names = [name for name, lead in waiting if most - lead <= max(_NEAR, _SIMILAR * most)]
        waiting = waiting[len(names) :]
        message = f"{_is_are(names)} dated {seconds(most)} ahead of the time when "
        message += f"{'it was' if len(names) == 1 else 'they were'} recorded"
        help = "AMCL dates 1 s ahead (transform_tolerance), slam_toolbox 0.5 s; "
        help += "what is more is a parameter, or the clock of a computer"
        if len(names) == count > 1:
            help = "that is every stream there is: the clock of the recorder is behind"
        numbers = {"seconds": most, "streams": names}
        yield problem("stamp-ahead", names[0], message, help, severity=WARNING, numbers=numbers)


def _steps(recording: Recording, steps: Sequence[tuple[str, Step]], count: int) -> Iterator[Diagnostic]:
    """Yield the findings for clocks that were set, of ``count`` streams; each clock once."""
    waiting = sorted(steps, key=lambda one: -one[1].size)
    while waiting:
        first = waiting[0][1]
        near = max(_NEAR, _SIMILAR * first.size)
        same = [one for one in waiting if abs(one[1].before - first.before) + abs(one[1].after - first.after) <= near]
        waiting = [one for one in waiting if one not in same]
        names, at = [name for name, _ in same], (first.time - (recording.start or 0)) / SECOND
        whose = first_of(names, _SHOWN) if len(names) < max(count, 2) else "the recorder"
        message = f"the clock of {whose} was set: stamps are {_offset(first.before)} at first, {_offset(first.after)} "
        message += f"from {at:.1f} s into the recording on" if at > 0 else "in the end"
        help = "against the time when they were recorded; tf2 mixes what one clock says with what the other said"
        numbers = {"before": first.before, "after": first.after, "at": at, "streams": names}
        yield problem("stamp-clock-set", names[0], message, help, severity=WARNING, numbers=numbers)


def _offset(lead: float) -> str:
    return f"{seconds(abs(lead))} {'ahead' if lead > 0 else 'behind'}"

"""Judge stamps: missing ones, those of other clocks, and clocks that were set. One finding for streams of one clock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.source.diagnostics import Diagnostic, first_of

from .findings import YEAR, problem, seconds
from .recording import Recording
from .timing import SIMULATED, Pace, Step

_SHOWN = 3
# AMCL dates map -> odom 1 s ahead (transform_tolerance), slam_toolbox 0.5 s; more than this (s) is reported.
_FAR_AHEAD = 1.2
# Clocks that differ by less (a share, or s) are the same.
_SIMILAR, _NEAR = 0.1, 0.1

Leads = Sequence[tuple[str, float]]  # name of a stream, and how far it is dated ahead (s)


def clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks that stamp."""
    moving = [one for one in recording.series.values() if not one.static and not one.has_two_sources]
    streams: list[tuple[str, Pace]] = [(f"{one.name}{one.by_owner}", one.pace) for one in moving]
    streams += [("/joint_states", recording.joints.pace)] if recording.joints.pace.count else []
    streams += [(use.topic, use.pace) for use in recording.uses]
    if zero := [name for name, pace in streams if pace.unstamped]:
        yield problem("stamp-zero", zero[0], f"{_are(zero)} stamped with time zero")
    if back := [(name, pace.farthest_jump) for name, pace in streams if pace.jumps]:
        name, (far, at) = max(back, key=lambda one: one[1].seconds)
        where = f", {recording.since_start(at):.1f} s into the recording" if recording.timed else ""
        names = first_of([name for name, _ in back], _SHOWN)
        message = f"the stamps of {names} jump back, by {seconds(far)} at most{where}"
        yield problem("stamp-jumps-back", name, message)
    if recording.timed:
        streams = [(name, pace) for name, pace in streams if not pace.unstamped]
        yield from _other(recording, [(name, pace.most_ahead) for name, pace in streams if pace.other_clock])
        streams = [(name, pace) for name, pace in streams if not pace.other_clock]
        steps = [(name, pace.step) for name, pace in streams if pace.step is not None and not pace.jumps]
        yield from _steps(recording, steps, len(streams))
        yield from _ahead([(name, pace.most_ahead) for name, pace in streams])


def row_clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks of the edges that view_frames saw."""
    leads = [(row.name, -row.age) for row in recording.rows if not row.static and row.age is not None]
    yield from _other(recording, [(name, lead) for name, lead in leads if abs(lead) > YEAR])
    yield from _ahead([(name, lead) for name, lead in leads if lead <= YEAR])


def _are(names: Sequence[str]) -> str:
    return f"{first_of(names, _SHOWN)} {'is' if len(names) == 1 else 'are'}"


def _other(recording: Recording, leads: Leads) -> Iterator[Diagnostic]:
    """Yield the findings for streams with other clocks: those behind, and those ahead."""
    for ahead in (False, True):
        group = [(name, abs(lead)) for name, lead in leads if (lead > 0) == ahead]
        if not group:
            continue
        names, far, help = [name for name, _ in group], min(lead for _, lead in group), ""
        if ahead and (recording.start or 0) < SIMULATED:
            help = "the wall clock among times of a simulation: use_sim_time for all nodes or for none"
        elif far > YEAR:
            help = "simulation time (use_sim_time for all nodes or for none), or a computer that begins in 1970"
        message = f"{_are(names)} stamped by another clock, {seconds(far)} {'ahead' if ahead else 'behind'}"
        yield problem("stamp-other-clock", names[0], message, help)


def _ahead(leads: Leads) -> Iterator[Diagnostic]:
    """Yield the findings for streams that are dated ahead; each clock once."""
    waiting = sorted((one for one in leads if one[1] > _FAR_AHEAD), key=lambda one: -one[1])
    while waiting:
        most = waiting[0][1]
        names = [name for name, lead in waiting if most - lead <= max(_NEAR, _SIMILAR * most)]
        waiting = waiting[len(names) :]
        was = "it was" if len(names) == 1 else "they were"
        message = f"{_are(names)} dated {seconds(most)} ahead of the time when {was} recorded"
        help = "all streams are: the clock of the recorder is behind" if len(names) == len(leads) > 1 else ""
        yield problem("stamp-ahead", names[0], message, help)


def _steps(recording: Recording, steps: Sequence[tuple[str, Step]], count: int) -> Iterator[Diagnostic]:
    """Yield the findings for clocks that were set, of ``count`` streams; each clock once."""
    waiting = sorted(steps, key=lambda one: -one[1].size)
    while waiting:
        first = waiting[0][1]
        near = max(_NEAR, _SIMILAR * first.size)
        same = [one for one in waiting if abs(one[1].before - first.before) + abs(one[1].after - first.after) <= near]
        waiting = [one for one in waiting if one not in same]
        names, at = [name for name, _ in same], recording.since_start(first.time)
        whose = first_of(names, _SHOWN) if len(names) < max(count, 2) else "the recorder"
        before, after = (f"{seconds(abs(lead))} {'ahead' if lead > 0 else 'behind'}" for lead in first[1:])
        when = f"from {at:.1f} s into the recording on" if at > 0 else "in the end"
        message = f"the clock of {whose} was set: stamps are {before} at first, {after} {when}"
        yield problem("stamp-clock-set", names[0], message)

"""Judge the tree: edges that are missing, late or stale, modes, and prefixes of frames."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, and_more, first_of

from .expected import Expected
from .findings import YEAR, problem, rate_text, seconds
from .recording import Recording
from .series import Series
from .timing import APART, SECOND, Gap

_FEW = 3
_LATE = 1.0  # an edge on /tf that comes within this time (s) was there before the recording


class Way(NamedTuple):
    """A combination of modes, the edges that should be published in it, and those of them that are missing."""

    modes: Mapping[str, bool]
    edges: list[Expected]
    missing: list[Expected]


def best_way(recording: Recording) -> Way:
    """Return the combination of modes with the fewest missing edges, and of those the one that fits best."""
    there = set(recording.into) | {row.child for row in recording.rows}
    ways = [
        Way(modes, edges, [edge for edge in edges if edge.child not in there])
        for modes, edges in recording.description.ways()
    ]
    return min(ways, key=lambda way: (len(way.missing), len(_of_other_modes(recording, way.edges))))


def _of_other_modes(recording: Recording, edges: Sequence[Expected]) -> list[tuple[Expected, Expected]]:
    """Return the edges that were recorded as described in other modes, each with the one of these modes."""
    own = {edge.child: edge for edge in edges}
    found = []
    for series in recording.series.values():
        edge, mine = series.edge, own.get(series.child)
        if edge is None or mine is None or edge.parent != series.parent or series.wrong:
            continue
        if (edge.parent, edge.moving, edge.transform) != (mine.parent, mine.moving, mine.transform):
            found.append((edge, mine))
    return found


def _modes_text(modes: Mapping[str, bool]) -> str:
    return " and ".join(f"{name} is {'on' if value else 'off'}" for name, value in modes.items())


def other_modes(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges of one combination of modes among those of another one."""
    way = best_way(recording)
    for edge, own in _of_other_modes(recording, way.edges):
        message = f"{edge.name} is as described when {edge.when or 'no mode says otherwise'}, but the others are those "
        message += f"when {_modes_text(way.modes)}"
        help = f"then {own.owner} should publish {own.name}: look which nodes run"
        yield problem("edge-of-other-mode", edge.name, message, help)


def prefixed(recording: Recording) -> Diagnostic | None:
    """Return the finding for frames that all have another prefix than the description and --prefix, or None."""
    frames, description = recording.tree_frames, recording.description
    known, given = description.frames | set(description.robot.link), description.options.prefix
    # The common prefix is one behind which at least half of the frames are known.
    counts = Counter(name[:at] for name in frames for at in range(1, len(name)) if name[at:] in known)
    fitting = [text for text, count in counts.items() if 2 * count >= len(frames) and not frames & known]
    prefix = next((text for text in fitting if all(name.startswith(text) for name in frames)), "")
    if prefix and prefix != given:
        message = f"all frames begin with {prefix}, "
        message += f"not with {given}" if given else "those of the description do not"
        help = f"--prefix {shlex.quote(prefix)} compares what is behind it"
    elif given and frames and not any(name.startswith(given) for name in frames):
        message = f"no frame begins with {given}: there are {first_of(sorted(frames), _FEW)}"
        help = "leave out --prefix, or give the one that they have"
    else:
        return None
    return problem("frames-prefixed", "the recording", message, help, numbers={"prefix": prefix})


def missing(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges that nobody published; several of one node share a finding."""
    if not recording.complete:
        return
    way = best_way(recording)
    silent: set[str] = set()  # joints that /joint_states leaves out: a finding of its own
    if recording.joints.pace.count:
        silent = set(recording.description.joint_names - recording.joints.ranges.keys())
    absent = [e for e in way.missing if e.joint is None or recording.description.leader(e.joint) not in silent]
    if recording.timed and not any(series.static for series in recording.series.values()):
        static = [edge for edge in way.missing if not edge.moving]
        absent = [edge for edge in absent if edge.moving]
        if static:
            names = [edge.name for edge in static]
            edges = "the edge" if len(static) == 1 else f"the {len(static)} edges"
            message = f"the recording has no message of /tf_static: {edges} that should be there could not be compared"
            help = "it is sent once, when a node starts: record it with durability transient_local, as ros2 bag record "
            help, evidence = f"{help}does", [", ".join(names)]
            yield problem(
                "recording-no-static", "/tf_static", message, help, evidence=evidence, numbers={"edges": names}
            )
    for owner in dict.fromkeys(edge.owner for edge in absent):
        edges = [edge for edge in absent if edge.owner == owner]
        for group in [edges] if len(edges) > _FEW else [[edge] for edge in edges]:
            yield _missing(recording, group, way)


def _missing(recording: Recording, edges: Sequence[Expected], way: Way) -> Diagnostic:
    """Return the finding for one missing edge, or for several of one node."""
    owner = edges[0].owner
    names, total = ", ".join(edge.name for edge in edges), sum(edge.owner == owner for edge in way.edges)
    if len(edges) == 1:
        message = f"nobody published {names}; {owner} should"
    elif len(edges) == total:
        message = f"none of the {total} edges of {owner} was published: {names}"
    else:
        message = f"{len(edges)} of the {total} edges of {owner} were not published: {names}"
    if way.modes and any(edge.when for edge in edges):
        message += f" (when {_modes_text(way.modes)})"
    help = f"look whether it runs; --without {edges[0].publisher.name} if it was not meant to"
    if edges[0].publisher.kind == ROBOT_STATE_PUBLISHER and all(edge.moving for edge in edges):
        help = "robot_state_publisher publishes nothing that moves without /joint_states: look who publishes these"
    topics = {f"/{'tf' if edge.moving else 'tf_static'}" for edge in edges}
    absent = sorted(topics - {name[name.rfind("/") :] for name in recording.topics}) if recording.timed else []
    if absent:
        help = f"the recording has no {' and no '.join(absent)}: record it, or look who publishes it"
    return problem("edge-missing", edges[0].name, message, help, numbers={"edges": [edge.name for edge in edges]})


def stale(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges whose newest sample was too old; those of one node share a finding."""
    if not recording.timed:
        return
    limit, silence = recording.description.options.stale, recording.silence
    silent = silence.seconds > limit
    if silent:
        yield _silence(recording)

    def is_stale(series: Series) -> bool:
        pace, edge = series.pace, series.edge
        if series.static or pace.unstamped or pace.jumps or (edge is not None and not edge.moving):
            return False
        oldest = pace.oldest_until(recording.end)
        if oldest.seconds <= limit or pace.other_clock or (silent and _within(oldest, silence)):
            return False
        step = pace.step  # a clock that was set has a finding of its own
        if step is None:
            return True
        of_recorder = silence.seconds > _LATE and abs(step.size - silence.seconds) < _LATE
        return not of_recorder and min(step.before, step.after) >= -APART

    for owner, group in _by_owner(recording, is_stale):
        for series in [group] if group[0].edge is not None else [[one] for one in group]:
            yield _stale(recording, owner, series)


def _by_owner(recording: Recording, chosen: Callable[[Series], bool]) -> Iterator[tuple[str, list[Series]]]:
    groups: dict[str, list[Series]] = {}
    for series in filter(chosen, recording.series.values()):
        groups.setdefault(series.owner or series.name, []).append(series)
    yield from groups.items()


def _within(oldest: Gap, silence: Gap) -> bool:
    """Return True if an edge grew old only because nothing at all was recorded."""
    most = silence.seconds + _LATE
    return oldest.seconds < most and abs(oldest.at - silence.at) < most * SECOND


def _silence(recording: Recording) -> Diagnostic:
    long, at = recording.silence.seconds, (recording.silence.at - (recording.start or 0)) / SECOND
    message = f"nothing was recorded for {seconds(long)}, {at:.1f} s into the recording"
    if long > YEAR:
        message = f"the clock of the recorder was set by {seconds(long)}, {at:.1f} s into the recording"
    help = "the recorder was paused, the computer stood still, or its clock was set; no edge is called stale for that"
    numbers = {"seconds": long, "at": at}
    return problem("recording-silent", "the recording", message, help, severity=WARNING, numbers=numbers)


def _stale(recording: Recording, owner: str, group: Sequence[Series]) -> Diagnostic:
    """Return the finding for the stale edges of one node."""
    worst = max(group, key=lambda series: series.pace.oldest_until(recording.end).seconds)
    pace, limit = worst.pace, recording.description.options.stale
    oldest = pace.oldest_until(recording.end)
    age, at = seconds(oldest.seconds), (oldest.at - (recording.start or 0)) / SECOND
    names = f"{worst.name}{and_more(len(group) - 1, f'of {owner}')}"
    message = f"{names} went {age} stale, {at:.1f} s into the recording"
    evidence = [f"it comes at {rate_text(pace.rate)}; the longest time without one is {seconds(pace.gap.seconds)}"]
    if pace.mean_age > limit:
        evidence.append(f"its stamps are {seconds(pace.mean_age)} old on average when they come")
    help = f"whoever asks then gets where things were {age} ago: look why {owner} stopped"
    if pace.most_ahead < -limit:
        fresh = seconds(-pace.most_ahead)
        help = f"even its freshest stamp was {fresh} old when it came: look at the clock of {owner}, or what delays it"
    help += f" (--stale: {seconds(limit)})"
    numbers = {"seconds": oldest.seconds, "at": at, "edges": [series.name for series in group]}
    return problem("edge-stale", worst.name, message, help, evidence=evidence, numbers=numbers)


def late(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges that came some time after the start; those of one node share a finding."""
    if not recording.timed:
        return

    def waited(series: Series) -> float:
        """Return how long (s) the recording ran before the first transform, without a pause of the recorder."""
        time, silence = (series.pace.first - (recording.start or 0)) / SECOND, recording.silence
        return time - (silence.seconds if silence.seconds > _LATE and series.pace.first > silence.at else 0.0)

    def is_late(series: Series) -> bool:
        edge = series.edge
        if series.static or edge is None or not edge.moving or edge.parent != series.parent:
            return False
        return waited(series) > (max(_LATE, 3 / series.pace.rate) if series.pace.rate > 0 else _LATE)

    for owner, group in _by_owner(recording, is_late):
        first, more = min(group, key=lambda series: series.pace.first), len(group) - 1
        names = f"{first.name}{and_more(more, f'of {owner}')} {'were' if more else 'was'}"
        message = f"{names} there only from {waited(first):.1f} s into the recording on"
        help = f"until then nothing in {first.parent} could be looked up: start {owner} earlier, or wait for it"
        numbers = {"seconds": waited(first), "edges": [series.name for series in group]}
        yield problem("edge-late", first.name, message, help, severity=NOTE, numbers=numbers)

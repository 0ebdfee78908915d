"""Judge the tree: edges that are missing, late or stale, modes, and prefixes of frames."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.source.diagnostics import Diagnostic, and_more, first_of

from .expected import Expected
from .findings import YEAR, problem, rate_text, seconds
from .recording import Recording
from .series import Series
from .timing import APART, SECOND

_FEW = 3
_LATE = 1.0  # an edge on /tf that comes within this time (s) was there before the recording


class Way(NamedTuple):
    """A combination of modes, the edges that should be published in it, and those of them that are missing."""

    modes: Mapping[str, bool]
    edges: list[Expected]
    missing: list[Expected]

    @property
    def text(self) -> str:
        """The modes in words."""
        return " and ".join(f"{name} is {'on' if value else 'off'}" for name, value in self.modes.items())


def best_way(recording: Recording) -> Way:
    """Return the combination of modes with the fewest missing edges, and of those the one that fits best."""
    there = set(recording.into) | {row.child for row in recording.rows}
    ways = [(modes, edges) for modes, edges in recording.description.ways()]
    every = [Way(modes, edges, [edge for edge in edges if edge.child not in there]) for modes, edges in ways]
    return min(every, key=lambda way: (len(way.missing), len(_of_other_modes(recording, way))))


def _of_other_modes(recording: Recording, way: Way) -> list[tuple[Expected, Expected]]:
    """Return the edges that were recorded as described in other modes, each with the one of these modes."""
    own, found = {edge.child: edge for edge in way.edges}, []
    for series in recording.series.values():
        edge, mine = series.edge, own.get(series.child)
        if edge is None or mine is None or edge.parent != series.parent or series.wrong:
            continue
        if (edge.parent, edge.moving, edge.transform) != (mine.parent, mine.moving, mine.transform):
            found.append((edge, mine))
    return found


def other_modes(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges of one combination of modes among those of another one."""
    way = best_way(recording)
    for edge, own in _of_other_modes(recording, way):
        message = f"{edge.name} is as described when {edge.when or 'no mode says otherwise'}, but the others are those "
        help = f"then {own.advice}: look which nodes run"
        yield problem("edge-of-other-mode", edge.name, f"{message}when {way.text}", help)


def prefixed(recording: Recording) -> Diagnostic | None:
    """Return the finding for frames that all have another prefix than the description and --prefix, or None."""
    frames, description = recording.tree_frames, recording.description
    known, given = description.frames | set(description.robot.link), description.options.prefix
    # The common prefix is one behind which at least half of the frames are known.
    counts = Counter(name[:at] for name in frames for at in range(1, len(name)) if name[at:] in known)
    fitting = [text for text, count in counts.items() if 2 * count >= len(frames) and not frames & known]
    prefix = next((text for text in fitting if all(name.startswith(text) for name in frames)), "")
    if prefix and prefix != given:
        other = f"not with {given}" if given else "those of the description do not"
        message, help = f"all frames begin with {prefix}, {other}", f"--prefix {shlex.quote(prefix)} compares what is "
        return problem("frames-prefixed", "the recording", message, f"{help}behind it")
    if given and frames and not any(name.startswith(given) for name in frames):
        message = f"no frame begins with {given}: there are {first_of(sorted(frames), _FEW)}"
        return problem("frames-prefixed", "the recording", message)
    return None


def missing(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges that nobody published; several of one node share a finding."""
    if not recording.complete:
        return
    way, absent = best_way(recording), []
    silent: set[str] = set()  # joints that /joint_states leaves out have a finding of their own
    if recording.joints.pace.count:
        silent = set(recording.description.joint_names - recording.joints.ranges.keys())
    no_static = recording.timed and not any(series.static for series in recording.series.values())
    if no_static and (static := [edge.name for edge in way.missing if not edge.moving]):
        edges = "the edge" if len(static) == 1 else f"the {len(static)} edges"
        message = f"the recording has no message of /tf_static: {edges} that should be there could not be compared"
        yield problem("recording-no-static", "/tf_static", message, evidence=[", ".join(static)])
    for edge in way.missing:
        if (edge.moving or not no_static) and (
            edge.joint is None or recording.description.leader(edge.joint) not in silent
        ):
            absent.append(edge)
    for owner in dict.fromkeys(edge.owner for edge in absent):
        group = [edge for edge in absent if edge.owner == owner]
        for edges_of in [group] if len(group) > _FEW else [[edge] for edge in group]:
            yield _missing(recording, edges_of, way)


def _missing(recording: Recording, edges: Sequence[Expected], way: Way) -> Diagnostic:
    """Return the finding for one missing edge, or for several of one node."""
    first, owner, names = edges[0], edges[0].owner, ", ".join(edge.name for edge in edges)
    total = sum(edge.owner == owner for edge in way.edges)
    message = f"{len(edges)} of the {total} edges of {owner} were not published: {names}"
    if len(edges) == 1:
        message = f"nobody published {names}; {owner} should"
    elif len(edges) == total:
        message = f"none of the {total} edges of {owner} was published: {names}"
    if way.modes and any(edge.when for edge in edges):
        message += f" (when {way.text})"
    help = f"look whether it runs; --without {first.publisher.name} if it was not meant to"
    if first.publisher.kind == ROBOT_STATE_PUBLISHER and all(edge.moving for edge in edges):
        help = "robot_state_publisher publishes nothing that moves without /joint_states: look who publishes these"
    topics = {f"/{'tf' if edge.moving else 'tf_static'}" for edge in edges}
    absent = sorted(topics - {name[name.rfind("/") :] for name in recording.topics}) if recording.timed else []
    if absent:
        help = f"the recording has no {' and no '.join(absent)}: record it, or look who publishes it"
    return problem("edge-missing", first.name, message, help)


def stale(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges whose newest sample was too old; those of one node share a finding."""
    limit, silence, end = recording.description.options.stale, recording.silence, recording.end
    if not recording.timed:
        return
    if silence.seconds > limit:
        message = f"nothing was recorded for {seconds(silence.seconds)}"
        if silence.seconds > YEAR:
            message = f"the clock of the recorder was set by {seconds(silence.seconds)}"
        message += f", {recording.since_start(silence.at):.1f} s into the recording"
        yield problem("recording-silent", "the recording", message)

    def is_stale(series: Series) -> bool:
        pace, edge = series.pace, series.edge
        oldest, most = pace.oldest_until(end), silence.seconds + _LATE
        if series.static or pace.unstamped or pace.jumps or (edge is not None and not edge.moving):
            return False
        in_silence = oldest.seconds < most and abs(oldest.at - silence.at) < most * SECOND
        if oldest.seconds <= limit or pace.other_clock or (silence.seconds > limit and in_silence):
            return False
        if (step := pace.step) is None:
            return True
        # A clock that was set has a finding of its own.
        of_recorder = silence.seconds > _LATE and abs(step.size - silence.seconds) < _LATE
        return not of_recorder and min(step.before, step.after) >= -APART

    for owner, group in _by_owner(recording, is_stale):
        worst = max(group, key=lambda series: series.pace.oldest_until(end).seconds)
        pace, oldest = worst.pace, worst.pace.oldest_until(end)
        names, age = f"{worst.name}{and_more(len(group) - 1, f'of {owner}')}", seconds(oldest.seconds)
        message = f"{names} went {age} stale, {recording.since_start(oldest.at):.1f} s into the recording"
        evidence = [f"it comes at {rate_text(pace.rate)}; the longest time without one is {seconds(pace.gap.seconds)}"]
        if pace.mean_age > limit:
            evidence.append(f"its stamps are {seconds(pace.mean_age)} old on average when they come")
        help = f"a lookup then returns poses of {age} ago; find out why {owner} stopped"
        if pace.most_ahead < -limit:
            help = f"even its freshest stamp was {seconds(-pace.most_ahead)} old when it came: look at the clock of "
            help += f"{owner}, or what delays it"
        yield problem("edge-stale", worst.name, message, f"{help} (--stale: {seconds(limit)})", evidence)


def _by_owner(recording: Recording, chosen: Callable[[Series], bool]) -> Iterator[tuple[str, list[Series]]]:
    """Yield chosen edges by the node that publishes them; one without a node alone."""
    groups: dict[str, list[Series]] = {}
    for series in filter(chosen, recording.series.values()):
        groups.setdefault(series.owner or series.name, []).append(series)
    yield from groups.items()


def late(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges that came some time after the start; those of one node share a finding."""

    def waited(series: Series) -> float:
        """Return how long (s) the recording ran before the first transform, without a pause of the recorder."""
        time, silence = recording.since_start(series.pace.first), recording.silence
        return time - (silence.seconds if silence.seconds > _LATE and series.pace.first > silence.at else 0.0)

    def is_late(series: Series) -> bool:
        edge, rate = series.edge, series.pace.rate
        if not recording.timed or series.static or edge is None or not edge.moving or edge.parent != series.parent:
            return False
        return waited(series) > (max(_LATE, 3 / rate) if rate > 0 else _LATE)

    for owner, group in _by_owner(recording, is_late):
        first, more = min(group, key=lambda series: series.pace.first), len(group) - 1
        names = f"{first.name}{and_more(more, f'of {owner}')} {'were' if more else 'was'}"
        message = f"{names} there only from {waited(first):.1f} s into the recording on"
        help = f"until then nothing in {first.parent} could be looked up: start {owner} earlier, or wait for it"
        yield problem("edge-late", first.name, message, help)

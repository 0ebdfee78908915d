"""Judging the tree: edges that are missing, and edges that were late or stale."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, and_more, first_of
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND
from .expected import Expected
from .findings import YEAR, problem, rate_text, seconds
from .pace import APART, Gap, step_of
from .recording import Recording
from .series import Series

RULES = (
    Rule(
        "recording-silent",
        "A warning: nothing at all was recorded for longer than `--stale`. No edge is called stale for that.",
        "Look whether the recorder was paused, or a clock was set.",
        Heading.RECORDINGS,
    ),
    Rule(
        "recording-no-static",
        "There is no message of `/tf_static`, and the robot has static edges: they cannot be compared.",
        "Record `/tf_static`, with durability transient_local.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-missing",
        "Nobody published an edge that is described, in any combination of modes; or tf2_echo got no answer.",
        "The message names who should publish it; `--without NODE` if it was not meant to run.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-of-other-mode",
        "Some edges are those of one mode, and others those of another: the robot was in none that is described.",
        "Look which nodes run; `--mode` says what was meant.",
        Heading.RECORDINGS,
    ),
    Rule(
        "frames-prefixed",
        "All frames of the transforms begin alike, and those of the description do not; or none begins as `--prefix` "
        "says. None could be compared.",
        "`--prefix TEXT`, as the message says it.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-late",
        "A note: a moving edge came only some time after the begin of the recording.",
        "Start its publisher earlier, or let listeners wait.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-stale",
        "The newest transform of an edge was older than `--stale` (1 s).",
        "Look why its publisher stopped.",
        Heading.RECORDINGS,
    ),
)

_MANY = 3
# An edge on /tf that comes within this time (s) of a recording was there before.
LATE = 1.0


class Missing(NamedTuple):
    """What is missing in the combination of modes that fits a recording best."""

    modes: Mapping[str, bool]
    edges: list[Expected]
    present: list[Expected]


def best_way(recording: Recording) -> Missing:
    """Return the combination of modes in which the fewest edges are missing, and of those the one that fits most."""
    there = set(recording.into) | {row.child for row in recording.rows}
    found = _fitting(recording)
    ways = []
    for modes, expected in recording.description.ways():
        ways.append(Missing(modes, [edge for edge in expected if edge.child not in there], expected))
    return min(ways, key=lambda way: (len(way.edges), len(_of_others(found, way.present))))


def _fitting(recording: Recording) -> list[Expected]:
    """Return the described edges that were recorded as they are described."""
    every = recording.series.values()
    return [one.edge for one in every if one.edge and one.edge.parent == one.parent and not one.values.wrong]


def _of_others(found: Sequence[Expected], present: Sequence[Expected]) -> list[Expected]:
    """Return the recorded edges that are of another combination of modes, as it can be seen."""
    own = {edge.child: edge for edge in present}
    return [edge for edge in found if edge.child in own and not _alike(edge, own[edge.child])]


def _alike(one: Expected, other: Expected) -> bool:
    """Say whether two edges into one frame are the same but for who publishes them."""
    return (one.parent, one.moving, one.transform) == (other.parent, other.moving, other.transform)


def other_modes(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges of one combination of modes among those of another: there is none that all are of."""
    way = best_way(recording)
    for edge in _of_others(_fitting(recording), way.present):
        own = next(own for own in way.present if own.child == edge.child)
        modes = " and ".join(f"{name} is {_on(value)}" for name, value in way.modes.items())
        message = f"{edge.name} is as described when {edge.when or 'no mode says otherwise'}, but the others are those "
        message += f"when {modes}"
        help = f"then {own.owner} should publish {own.name}: look which nodes run"
        yield problem("edge-of-other-mode", edge.name, message, help)


def prefixed(recording: Recording) -> Diagnostic | None:
    """Return the finding for frames that all begin otherwise than the description, and --prefix, let one expect."""
    frames, description = recording.tree_frames, recording.description
    known = description.frames | set(description.robot.link)
    given = description.options.prefix
    prefix = "" if frames & known else _common(frames, known)
    if prefix and prefix != given:
        message = f"all frames begin with {prefix}, "
        message += f"not with {given}" if given else "those of the description do not"
        help = f"--prefix {shlex.quote(prefix)} compares what is behind it"
    elif given and frames and not any(name.startswith(given) for name in frames):
        message = f"no frame begins with {given}: there are {first_of(sorted(frames), _MANY)}"
        help = "leave out --prefix, or give the one that they have"
    else:
        return None
    return problem("frames-prefixed", "the recording", message, help, numbers={"prefix": prefix})


def _common(frames: Collection[str], known: Collection[str]) -> str:
    """Return what all frames begin with where a known name follows in half of them; nothing if there is no such."""
    counts = Counter(name[:at] for name in frames for at in range(1, len(name)) if name[at:] in known)
    fitting = [prefix for prefix, count in counts.items() if 2 * count >= len(frames)]
    return next((prefix for prefix in fitting if all(name.startswith(prefix) for name in frames)), "")


def missing(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges that nobody published; several of one node in one finding."""
    if not recording.whole:
        return
    way = best_way(recording)
    silent = _silent_joints(recording)
    by_owner: dict[str, list[Expected]] = {}
    for edge in way.edges:
        leader = recording.description.leader(edge.joint)[0] if edge.joint is not None else ""
        if leader not in silent:
            by_owner.setdefault(edge.owner, []).append(edge)
    if recording.no_static:
        absent = [edge for edge in way.edges if not edge.moving]
        by_owner = {owner: [edge for edge in edges if edge.moving] for owner, edges in by_owner.items()}
        yield from _no_static(absent)
    for owner, edges in by_owner.items():
        all_of_it = [edge for edge in way.present if edge.owner == owner]
        groups = [edges] if len(edges) > _MANY else [[edge] for edge in edges]
        for group in groups:
            yield _missing(recording, owner, group, len(all_of_it), way.modes)


def _no_static(absent: Sequence[Expected]) -> Iterator[Diagnostic]:
    """Yield the finding for a recording without /tf_static: whether anybody published it cannot be told."""
    if not absent:
        return
    edges = "the edge" if len(absent) == 1 else f"the {len(absent)} edges"
    message = f"the recording has no message of /tf_static: {edges} that should be there could not be compared"
    help = "it is sent once, when a node starts: record it with durability transient_local, as ros2 bag record does"
    names = [edge.name for edge in absent]
    yield problem(
        "recording-no-static", "/tf_static", message, help, evidence=[", ".join(names)], numbers={"edges": names}
    )


def _silent_joints(recording: Recording) -> set[str]:
    """Return the joints that /joint_states leaves out: their edges are missing for this reason."""
    if not recording.joints.pace.count:
        return set()
    return set(recording.description.joint_names) - set(recording.joints.names)


def _missing(
    recording: Recording, owner: str, edges: Sequence[Expected], every: int, modes: Mapping[str, bool]
) -> Diagnostic:
    names = ", ".join(edge.name for edge in edges)
    plural = len(edges) > 1
    if plural and len(edges) == every:
        message = f"none of the {every} edges of {owner} was published: {names}"
    elif plural:
        message = f"{len(edges)} of the {every} edges of {owner} were not published: {names}"
    else:
        message = f"nobody published {names}; {owner} should"
    if modes and any(edge.when for edge in edges):
        message += f" (when {' and '.join(f'{name} is {_on(value)}' for name, value in modes.items())})"
    help = f"look whether it runs; --without {edges[0].publisher.name} if it was not meant to"
    moving = [edge for edge in edges if edge.moving]
    if edges[0].publisher.kind == ROBOT_STATE_PUBLISHER and len(moving) == len(edges):
        help = "robot_state_publisher publishes nothing that moves without /joint_states: look who publishes these"
    topics = {f"/{'tf' if edge.moving else 'tf_static'}" for edge in edges}
    absent = sorted(topics - {name[name.rfind("/") :] for name in recording.topics}) if recording.timed else []
    if absent:
        help = f"the recording has no {' and no '.join(absent)}: record it, or look who publishes it"
    return problem("edge-missing", edges[0].name, message, help, numbers={"edges": [edge.name for edge in edges]})


def _on(value: bool) -> str:
    return "on" if value else "off"


def stale(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges whose newest sample was too old to use; those of one node that stopped together in one."""
    if not recording.timed:
        return
    by_owner: dict[str, list[Series]] = {}
    limit = recording.description.options.stale
    silent = recording.silence.seconds > limit
    if silent:
        yield _silence(recording)
    for series in recording.series.values():
        edge = series.edge
        if series.still or series.pace.unstamped or series.pace.jumps or (edge is not None and not edge.moving):
            continue
        oldest = series.pace.oldest_until(recording.end)
        if (
            oldest.seconds > limit
            and not (silent and _within(oldest, recording.silence))
            and not _of_its_clock(recording, series)
        ):
            by_owner.setdefault(series.owner or series.name, []).append(series)
    for owner, of_owner in by_owner.items():
        groups = [of_owner] if len(of_owner) > 1 and of_owner[0].edge is not None else [[series] for series in of_owner]
        for group in groups:
            yield _stale(recording, owner, group)


def _of_its_clock(recording: Recording, series: Series) -> bool:
    """Whether an edge seems old because a clock is another one, or was set; that is told of elsewhere."""
    if series.pace.other_clock:
        return True
    step = step_of(series.pace.bins)
    if step is None:
        return False
    of_recorder = recording.silence.seconds > LATE and abs(step.size - recording.silence.seconds) < LATE
    return of_recorder or min(step.before, step.after) < -APART


def _within(oldest: Gap, silence: Gap) -> bool:
    """Whether an edge grew old only because nothing at all was recorded."""
    return (
        oldest.seconds < silence.seconds + LATE
        and abs(oldest.began - silence.began) < (silence.seconds + LATE) * SECOND
    )


def _silence(recording: Recording) -> Diagnostic:
    silence = recording.silence
    at = (silence.began - (recording.start or 0)) / SECOND
    message = f"nothing was recorded for {seconds(silence.seconds)}, {at:.1f} s into the recording"
    if silence.seconds > YEAR:
        message = f"the clock of the recorder was set by {seconds(silence.seconds)}, {at:.1f} s into the recording"
    help = "the recorder was paused, the computer stood still, or its clock was set; no edge is called stale for that"
    numbers = {"seconds": silence.seconds, "at": at}
    return problem("recording-silent", "the recording", message, help, severity=WARNING, numbers=numbers)


def _stale(recording: Recording, owner: str, of_owner: Sequence[Series]) -> Diagnostic:
    worst = max(of_owner, key=lambda series: series.pace.oldest_until(recording.end).seconds)
    oldest = worst.pace.oldest_until(recording.end)
    at = (oldest.began - (recording.start or 0)) / SECOND
    names = f"{worst.name}{and_more(len(of_owner) - 1, f'of {owner}')}"
    message = f"{names} went {seconds(oldest.seconds)} stale, {at:.1f} s into the recording"
    limit = seconds(recording.description.options.stale)
    evidence = [
        f"it comes at {rate_text(worst.pace.rate)}; the longest time without one is {seconds(worst.pace.gap.seconds)}"
    ]
    mean = worst.pace.mean_age
    if mean > recording.description.options.stale:
        evidence.append(f"its stamps are {seconds(mean)} old on average when they come")
    help = f"whoever asks then gets where things were {seconds(oldest.seconds)} ago: look why {owner} stopped"
    if worst.pace.most_ahead < -recording.description.options.stale:
        fresh = seconds(-worst.pace.most_ahead)
        help = f"even its freshest stamp was {fresh} old when it came: look at the clock of {owner}, or what delays it"
    help += f" (--stale: {limit})"
    numbers = {"seconds": oldest.seconds, "at": at, "edges": [series.name for series in of_owner]}
    return problem("edge-stale", worst.name, message, help, evidence=evidence, numbers=numbers)


def late(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges that came only some time after all else, those of one node in one finding."""
    if not recording.timed:
        return
    by_owner: dict[str, list[Series]] = {}
    for series in recording.series.values():
        edge = series.edge
        if series.still or edge is None or not edge.moving or edge.parent != series.parent:
            continue
        if _waited(recording, series) > (max(LATE, 3 / series.pace.rate) if series.pace.rate > 0 else LATE):
            by_owner.setdefault(series.owner, []).append(series)
    for owner, of_owner in by_owner.items():
        first = min(of_owner, key=lambda series: series.pace.first)
        waited = _waited(recording, first)
        more = len(of_owner) - 1
        names = f"{first.name}{and_more(more, f'of {owner}')} {'were' if more else 'was'}"
        message = f"{names} there only from {waited:.1f} s into the recording on"
        help = f"until then nothing in {first.parent} could be looked up: start {owner} earlier, or wait for it"
        numbers = {"seconds": waited, "edges": [series.name for series in of_owner]}
        yield problem("edge-late", first.name, message, help, severity=NOTE, numbers=numbers)


def _waited(recording: Recording, series: Series) -> float:
    """Return how long (s) a recording ran before the first transform of an edge, pauses of the recording left out."""
    waited = (series.pace.first - (recording.start or 0)) / SECOND
    silence = recording.silence
    return waited - (silence.seconds if silence.seconds > LATE and series.pace.first > silence.began else 0.0)

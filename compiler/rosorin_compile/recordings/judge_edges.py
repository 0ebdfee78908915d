"""Check recorded transforms (edges): values, parents, topics, modes, and whether they are missing, late or stale."""

import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.source.diagnostics import Diagnostic, Suggestion, nearest
from rosorin_compile.source.wording import and_more, count_of, first_of, phrase

from .expected_edges import ExpectedEdge
from .recording import Recording
from .results import YEAR, difference, pose_text, problem, rate_text, seconds, share, value_rule
from .series import APART, SECOND, Leaps, Series, transform_from

_REPEATED = 0.4  # smallest share of repeated stamps that indicates two publishers
_FEW = 3
_LATE = 1.0  # s: an edge is late if its first transform arrives more than this time after the start


def edges(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for recorded edges: wrong values, wrong parents, two publishers, or not in the description."""
    repeated, strange = list[Series](), list[Series]()
    for child, group in recording.edges_by_child.items():
        if child in recording.description.by_child:
            yield from _frame(recording, child, group)
        elif finding := _not_published(recording, group[0]):
            yield finding
        else:
            strange.append(group[0])
        for series in group:
            pace, name = series.pace, series.name
            yield from _values(recording, series)
            if series.has_two_sources:
                evidence = [pose_text(transform_from(pose)) for pose in series.leaps.pair]
                if series.compared:
                    evidence.append(f"not as described: {share(series.wrong, series.compared)} samples")
                message = f"{name} has two values in turns: {leaps_text(series.leaps)}"
                yield problem("edge-two-values", name, message, evidence=evidence)
            elif not series.static and pace.count > 4 and pace.repeated > _REPEATED * (pace.count - 1):
                repeated.append(series)
            elif not series.constant and not series.by_state and pace.alternates:
                message = f"{name} comes at {rate_text(pace.rate)} in short and long steps by turns, as two clocks give"
                yield problem("edge-published-twice", name, message)
    for group in _by_owner(repeated):
        first = group[0]
        again = share(first.pace.repeated, first.pace.count - 1)
        message = f"{_names(group, first)} published twice: {again} stamps come again with the same value"
        yield problem("edge-published-twice", first.name, message)
    for series in strange if len(strange) <= _FEW else ():
        frames, message = recording.description.frames, f"{series.name} was published, but no such edge is described"
        help = Suggestion(series.child, frames) if nearest(series.child, frames) else ""
        yield problem("edge-not-described", series.name, message, help)
    if len(strange) > _FEW:
        message = f"{len(strange)} edges were published that are not described"
        yield problem("edge-not-described", strange[0].name, message, evidence=[series.name for series in strange])


def dropped_transforms(recording: Recording) -> Iterator[Diagnostic]:
    """Yield a finding for transforms that tf2 drops because of their frame names."""
    for (static, parent, child), count in recording.dropped.items():
        many = f"{count_of(count, 'transform')} on {'/tf_static' if static else '/tf'}"
        why = f'"{child}" is published under itself' if parent == child and child else "a frame has no name"
        advice = next((edge.advice for edge in recording.description.by_child.get(child, ())), "")
        yield problem("edge-dropped", f"{parent} -> {child}", f'"{parent}" -> "{child}" ({many}): {why}', advice)


def _frame(recording: Recording, child: str, group: Sequence[Series]) -> Iterator[Diagnostic]:
    """Yield findings for a frame with several parents, a wrong parent, or transforms on the wrong topic."""
    expected = recording.description.by_child[child]
    parents, described = list(dict.fromkeys(one.parent for one in group)), [edge.parent for edge in expected]
    if len(parents) > 1:
        names = phrase(f"{name}{'' if name in described else ' (not described)'}" for name in parents)
        message = f'the frame "{child}" was published under {len(parents)} parents: {names}'
        help = f"a frame has one parent, {described[0]}: stop the node that publishes the other"
        yield problem("edge-two-parents", f"{described[0]} -> {child}", message, help, map(_evidence, group))
    elif parents[0] not in described:
        message = f'the parent of "{child}" is "{parents[0]}", described is "{expected[0].parent}"'
        yield problem("edge-wrong-parent", group[0].name, message, expected[0].advice)
    for parent in parents:
        first, *others = [series for series in group if series.parent == parent]
        edge, rate = first.edge or expected[0], rate_text(first.pace.rate)
        help = f"{edge.owner} should publish it on {'/tf' if edge.moving else '/tf_static'}"
        if others:
            message = f"{first.name} came on /tf and on /tf_static: two nodes publish it"
            evidence = map(_evidence, [first, *others])
            yield problem("edge-static-and-moving", first.name, message, f"{help}; stop the other", evidence)
        elif first.static and edge.moving:
            message = f"{first.name} moves, but came on /tf_static: listeners take it for fixed"
            yield problem("edge-not-moving", first.name, message, help)
        elif not first.static and not edge.moving:
            message = f"{first.name} never moves, but came on /tf{'' if rate == '-' else f' at {rate}'}: it can be late"
            yield problem("edge-not-static", first.name, message, help)


def _not_published(recording: Recording, series: Series) -> Diagnostic | None:
    """Return a finding if the description limits a recorded edge to other modes or declares it unpublished, or None."""
    description = recording.description
    conditions = [edge.when for edge in description.edges if edge.child == series.child]
    message, help = f"{series.name} was published, but ", "look what --mode says, and what runs"
    if conditions:
        message += f"such an edge is described only when {' or '.join(conditions)}"
    elif (joint := description.robot.joint_to.get(series.child)) is not None:
        message += f"the description declares that no node does: {joint.publisher.about}"
        help = "find out which node does, and declare it"
    else:
        return None
    return problem("edge-not-described", series.name, message, help)


def _evidence(series: Series) -> str:
    rate = f" at {rate_text(series.pace.rate)}" if series.pace.rate > 0 else ""
    return f"{series.name}: {count_of(series.pace.count, 'time')} on {series.topic}{rate}"


def _values(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield findings for invalid transforms, and for values that contradict the description or each other."""
    name, edge = series.name, series.edge
    if series.bad:
        message = f"{name}: {share(series.bad, series.pace.count)} are not transforms (NaN, or a quaternion not of "
        message += f"length 1), first {recording.since_start(series.first_bad):.1f} s into the recording: tf2 drops "
        yield problem("not-a-rotation", name, f"{message}them", f"mend the node that publishes it{series.by_owner}")
    if series.first_other is not None:
        first, described = series.samples.transform(0), edge.transform if edge and not edge.moving else None
        evidence = [f"described: {pose_text(described)}"] if described and series.has_parent else []
        evidence += [f"first:     {pose_text(first)}", f"others:    {pose_text(series.first_other)}"]
        often = share(series.others, len(series.samples.stamps))
        message = f"{name} has several values: {often} samples are {difference(first, series.first_other)}"
        yield problem("edge-two-values", name, message, evidence=evidence)
    elif series.first_wrong is not None and not series.has_two_sources:
        recorded, described, received = series.first_wrong
        often = "" if series.wrong == series.compared else f" in {share(series.wrong, series.compared)} samples"
        message = f"{name} is {difference(described, recorded)} against the description{often}"
        evidence = [f"described: {pose_text(described)}", f"recorded:  {pose_text(recorded)}"]
        if not series.constant and recording.timed:
            evidence.append(f"first {recording.since_start(received):.1f} s into the recording")
        help = f"{series.owner} publishes it: deploy what is compiled, or correct the description"
        yield problem(value_rule(described, recorded), name, message, help, evidence)


def leaps_text(leaps: Leaps) -> str:
    """Describe the evidence that two nodes publish different values of the same transform or joint."""
    if leaps.contradict:
        return f"{share(leaps.contradictions, leaps.steps)} stamps come twice with different values"
    return f"{share(leaps.returns, leaps.steps)} samples leap back to where it was, by {leaps.largest:.3g} m or rad"


class Way(NamedTuple):
    """A combination of modes with its expected edges, and the differences of the recording.

    ``others`` has (recorded edge, expected edge) for recorded edges of other modes; ``text`` describes ``modes``.
    """

    modes: Mapping[str, bool]
    edges: list[ExpectedEdge]
    missing: list[ExpectedEdge]
    others: list[tuple[ExpectedEdge, ExpectedEdge]]
    text: str


def best_way(recording: Recording) -> Way:
    """Return the combination of modes with the fewest missing edges, then with the fewest edges of other modes."""
    ways = []
    fitting = [one.edge for one in recording.series.values() if one.edge and one.has_parent and not one.wrong]
    for modes, edges in recording.description.ways():
        own = {edge.child: edge for edge in edges}
        missing = [edge for edge in edges if edge.child not in recording.edges_by_child]
        others = [(edge, own[edge.child]) for edge in fitting if edge.value != own.get(edge.child, edge).value]
        text = " and ".join(f"{name} is {'on' if value else 'off'}" for name, value in modes.items())
        ways.append(Way(modes, edges, missing, others, text))
    return min(ways, key=lambda way: (len(way.missing), len(way.others)))


def other_modes(recording: Recording) -> Iterator[Diagnostic]:
    """Yield a finding for each recorded edge that contradicts the most likely combination of modes."""
    way = best_way(recording)
    for edge, own in way.others:
        message = f"{edge.name} is as described when {edge.when or 'no mode says otherwise'}, but the others are those "
        help = f"then {own.advice}: look which nodes run"
        yield problem("edge-of-other-mode", edge.name, f"{message}when {way.text}", help)


def check_prefix(recording: Recording) -> Diagnostic | None:
    """Return a finding if the recorded frames do not start with the option ``prefix``, or None."""
    frames, description = recording.tree_frames, recording.description
    known, requested = description.frames | set(description.robot.link), description.options.prefix
    # Count the recorded frames for which the description has the name without the prefix, by prefix.
    counts = Counter(name[:at] for name in frames for at in range(1, len(name)) if name[at:] in known)
    fitting = [text for text, count in counts.items() if 2 * count >= len(frames) and not frames & known]
    prefix = next((text for text in fitting if all(name.startswith(text) for name in frames)), "")
    if prefix and prefix != requested:
        why = f"not with {requested}" if requested else "those of the description do not"
        help = f"--prefix {shlex.quote(prefix)} compares what is behind it"
        return problem("frames-prefixed", "the recording", f"all frames begin with {prefix}, {why}", help)
    if requested and frames and not any(name.startswith(requested) for name in frames):
        message = f"no frame begins with {requested}: there are {first_of(sorted(frames), _FEW)}"
        return problem("frames-prefixed", "the recording", message)
    return None


def missing_edges(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for expected edges that were not published, one for each ROS node."""
    if not recording.complete:
        return
    way, description, silent = best_way(recording), recording.description, frozenset[str]()
    if recording.joints.pace.count:  # for joints that are missing in /joint_states, there is another finding
        silent = description.joint_names - recording.joints.reported.keys()
    no_static = recording.timed and not any(series.static for series in recording.series.values())
    if no_static and (static := [edge.name for edge in way.missing if not edge.moving]):
        edges = "the edge" if len(static) == 1 else f"the {len(static)} edges"
        message = f"the recording has no message of /tf_static: {edges} that should be there could not be compared"
        yield problem("recording-no-static", "/tf_static", message, evidence=[", ".join(static)])
    absent: dict[str, list[ExpectedEdge]] = {}
    for edge in way.missing:
        is_silent = edge.joint is not None and description.leader(edge.joint) in silent
        if (edge.moving or not no_static) and not is_silent:
            absent.setdefault(edge.owner, []).append(edge)
    for owner, group in absent.items():
        total = sum(edge.owner == owner for edge in way.edges)
        message = f"no node published {', '.join(edge.name for edge in group)}; {owner} should"
        message += f" ({len(group)} of its {total} edges)" if len(group) > 1 else ""
        message += f" (when {way.text})" if way.modes and any(edge.when for edge in group) else ""
        help = f"look whether it runs; --without {group[0].publisher.name} if it was not meant to"
        if group[0].publisher.kind == ROBOT_STATE_PUBLISHER and all(edge.moving for edge in group):
            help = "robot_state_publisher needs /joint_states for all that moves: look who publishes these"
        topics = {f"/{'tf' if edge.moving else 'tf_static'}" for edge in group}
        if recording.timed and (lacking := sorted(topics - {name[name.rfind("/") :] for name in recording.topics})):
            help = f"the recording has no {' and no '.join(lacking)}: record it, or look who publishes it"
        yield problem("edge-missing", group[0].name, message, help)


def stale(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for moving edges whose newest transform was older than --stale, one for each ROS node."""
    limit, silence, end = recording.description.options.stale, recording.silence, recording.end
    for series in recording.series.values():
        if series.age is not None and series.edge and not series.static and limit < series.age <= YEAR:
            message = f"{series.name} went {seconds(series.age)} stale, when view_frames looked"
            help = f"look why {series.edge.owner} stopped (--stale: {seconds(limit)})"
            yield problem("edge-stale", series.name, message, help, [f"average rate {rate_text(series.pace.rate)}"])
    if not recording.timed:
        return
    if silence.seconds > limit:
        what = "the clock of the recorder was set by" if silence.seconds > YEAR else "nothing was recorded for"
        message = f"{what} {seconds(silence.seconds)}, {recording.since_start(silence.at):.1f} s into the recording"
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
        # Ignore edges whose clock was set, because another rule reports them, and pauses of the recorder.
        of_recorder = silence.seconds > _LATE and abs(step.size - silence.seconds) < _LATE
        return not of_recorder and min(step.before, step.after) >= -APART

    for group in _by_owner(filter(is_stale, recording.series.values())):
        worst = max(group, key=lambda series: series.pace.oldest_until(end).seconds)
        pace, oldest, owner = worst.pace, worst.pace.oldest_until(end), worst.owner or worst.name
        names, age = f"{worst.name}{and_more(len(group) - 1, f'of {owner}')}", seconds(oldest.seconds)
        message = f"{names} went {age} stale, {recording.since_start(oldest.at):.1f} s into the recording"
        evidence = [f"it comes at {rate_text(pace.rate)}; the longest time without one is {seconds(pace.gap.seconds)}"]
        if pace.mean_age > limit:
            evidence.append(f"its stamps are {seconds(pace.mean_age)} old on average when they come")
        help = f"a lookup then returns poses of {age} ago; find out why {owner} stopped"
        if pace.most_ahead < -limit:
            help = f"its stamps are {seconds(-pace.most_ahead)} old or more: check the clock of {owner}, or the delay"
        yield problem("edge-stale", worst.name, message, f"{help} (--stale: {seconds(limit)})", evidence)


def _by_owner(series: Iterable[Series]) -> Iterable[list[Series]]:
    """Group edges by the ROS node that publishes them; an edge without a known publisher is a group of one."""
    groups: dict[str, list[Series]] = {}
    for one in series:
        groups.setdefault(one.owner or one.name, []).append(one)
    return groups.values()


def _names(group: Sequence[Series], first: Series) -> str:
    more = len(group) - 1
    return f"{first.name}{and_more(more, f'of {first.owner}')} {'are' if more else 'is'}"


def late(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for moving edges that first arrived long after the start, one for each ROS node."""

    def waited(series: Series) -> float:
        time, silence = recording.since_start(series.pace.first), recording.silence
        return time - (silence.seconds if silence.seconds > _LATE and series.pace.first > silence.at else 0.0)

    def is_late(series: Series) -> bool:
        edge, rate = series.edge, series.pace.rate
        if not recording.timed or series.static or edge is None or not edge.moving or not series.has_parent:
            return False
        return waited(series) > (max(_LATE, 3 / rate) if rate > 0 else _LATE)

    for group in _by_owner(filter(is_late, recording.series.values())):
        first = min(group, key=lambda series: series.pace.first)
        message = f"{_names(group, first)} available only from {waited(first):.1f} s into the recording on"
        owner = first.owner or first.name
        help = f"until then nothing in {first.parent} could be looked up: start {owner} earlier, or wait for it"
        yield problem("edge-late", first.name, message, help)

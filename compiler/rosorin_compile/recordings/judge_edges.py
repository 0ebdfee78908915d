"""Judge the recorded edges: values, parents, topics and modes, and edges that are missing, late or stale."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER
from rosorin_compile.source.diagnostics import Diagnostic, Suggestion, nearest
from rosorin_compile.source.wording import and_more, counted, first_of, listed

from .expected import EXACT, Expected
from .findings import YEAR, difference, pose_text, problem, rate_text, seconds, share, value_rule
from .recording import FrameRow, Recording
from .series import APART, SECOND, Leaps, Series, transform_from

_REPEATED = 0.4  # share of repeated stamps from which on a stream is published twice
_FEW = 3
_LATE = 1.0  # an edge on /tf that comes within this time (s) was there before the recording


def edges(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the recorded edges."""
    repeated: dict[str, list[Series]] = {}
    for child, of_child in recording.into.items():
        yield from _frame(recording, child, of_child)
        for series in of_child:
            pace, name = series.pace, series.name
            yield from _values(recording, series)
            if series.has_two_sources:
                evidence = [pose_text(transform_from(pose[:3], pose[3:])) for pose in series.leaps.pair or ()]
                different = f"not as described: {share(series.wrong, series.compared)} samples"
                evidence += [different] if series.compared else []
                message = f"{name} has two values in turns: {leaps_text(series.leaps)}"
                yield problem("edge-two-values", name, message, evidence=evidence)
            elif not series.static and pace.count > 4 and pace.repeated > _REPEATED * (pace.count - 1):
                repeated.setdefault(series.owner or name, []).append(series)
            elif not series.constant and not series.by_state and pace.alternates:
                message = f"{name} comes at {rate_text(pace.rate)} in short and long steps by turns, as two clocks give"
                yield problem("edge-published-twice", name, message)
    for owner, group in repeated.items():
        first, more = group[0], len(group) - 1
        names = f"{first.name}{and_more(more, f'of {owner}')} {'are' if more else 'is'}"
        again = share(first.pace.repeated, first.pace.count - 1)
        message = f"{names} published twice: {again} stamps come again with the same value"
        yield problem("edge-published-twice", first.name, message)


def dropped(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the transforms that tf2 drops because of the names of their frames."""
    for (static, parent, child), count in recording.dropped.items():
        many = f"{counted(count, 'transform')} on {'/tf_static' if static else '/tf'}"
        message = f'"{child}" is published under itself ({many}): tf2 drops that'
        if parent != child:
            nameless = f'above "{child}"' if child else f'under "{parent}"'
            message = f"the frame {nameless} has no name ({many}): tf2 drops it"
        elif not child:
            message = f"neither frame has a name ({many}): tf2 drops that"
        advice = next((edge.advice for edge in recording.description.by_child.get(child, ())), "")
        yield problem("edge-dropped", f"{parent} -> {child}", message, advice)


def row(recording: Recording, row: FrameRow) -> Iterator[Diagnostic]:
    """Yield the faults of one frame of view_frames."""
    edge = recording.description.edge_like(row.parent, row.child, row.static)
    if edge is None:
        yield _undescribed(recording, row.name, row.child)
        return
    if edge.parent != row.parent:
        yield _wrong_parent(row.name, row.child, row.parent, edge)
    yield from _topic(row.name, row.static, edge, row.rate)
    limit = recording.description.options.stale
    if not row.static and row.age is not None and limit < row.age <= YEAR:
        message = f"{row.name} went {seconds(row.age)} stale, when view_frames looked"
        help = f"look why {edge.owner} stopped (--stale: {seconds(limit)})"
        yield problem("edge-stale", row.name, message, help, [f"average rate {rate_text(row.rate)}"])


def _frame(recording: Recording, child: str, of_child: Sequence[Series]) -> Iterator[Diagnostic]:
    """Yield the faults of the parents and topics of one frame."""
    expected = recording.description.by_child.get(child)
    if expected is None:
        yield from _not_described(recording, of_child[0])
        return
    parents, described = list(dict.fromkeys(one.parent for one in of_child)), [edge.parent for edge in expected]
    if len(parents) > 1:
        names = listed(f"{name}{'' if name in described else ' (not described)'}" for name in parents)
        message = f'the frame "{child}" was published under {len(parents)} parents: {names}'
        help = f"a frame has one parent, {described[0]}: stop the node that publishes the other"
        yield problem("edge-two-parents", f"{described[0]} -> {child}", message, help, map(_evidence, of_child))
    elif parents[0] not in described:
        yield _wrong_parent(of_child[0].name, child, parents[0], expected[0])
    for parent in parents:
        group = [series for series in of_child if series.parent == parent]
        first, edge = group[0], group[0].edge or expected[0]
        if len(group) > 1:
            message = f"{first.name} came on /tf and on /tf_static: two nodes publish it"
            help = f"{edge.owner} publishes it on {'/tf' if edge.moving else '/tf_static'}; stop the other"
            yield problem("edge-static-and-moving", first.name, message, help, map(_evidence, group))
        else:
            yield from _topic(first.name, first.static, edge, first.pace.rate)


def _wrong_parent(name: str, child: str, parent: str, edge: Expected) -> Diagnostic:
    message = f'the parent of "{child}" is "{parent}", described is "{edge.parent}"'
    return problem("edge-wrong-parent", name, message, edge.advice)


def _topic(name: str, static: bool, edge: Expected, rate: float) -> Iterator[Diagnostic]:
    """Yield the finding for a moving edge on /tf_static, or a static one on /tf."""
    help = f"{edge.owner} should publish it on {'/tf' if edge.moving else '/tf_static'}"
    if static and edge.moving:
        message = f"{name} moves, but came on /tf_static: listeners take it for fixed"
        yield problem("edge-not-moving", name, message, help)
    elif not static and not edge.moving:
        at = f" at {rate_text(rate)}" if rate_text(rate) != "-" else ""
        message = f"{name} never moves, but came on /tf{at}: it can be late, which a static one never is"
        yield problem("edge-not-static", name, message, help)


def _undescribed(recording: Recording, name: str, child: str) -> Diagnostic:
    frames = recording.description.frames
    help = Suggestion(child, frames) if nearest(child, frames) else ""
    return problem("edge-not-described", name, f"{name} was published, but no such edge is described", help)


def _not_described(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield the finding for an edge that is not described; many below one frame of the robot share one."""
    description, name = recording.description, series.name
    turns = [edge.when for edge in description.edges if edge.child == series.child]
    if turns:
        message = f"{name} was published, but such an edge is described only when {' or '.join(turns)}"
        yield problem("edge-not-described", name, message, "look what --mode says, and what runs")
        return
    if (joint := description.robot.joint_to.get(series.child)) is not None:
        message = f"{name} was published, but the description declares that no node does: {joint.publisher.about}"
        yield problem("edge-not-described", name, message, "find out which node does, and declare it")
        return
    strange = [group[0] for child, group in recording.into.items() if child not in description.by_child]
    above = {other.child: other.parent for other in strange}

    def top(frame: str) -> str:
        for _ in above:  # a loop ends somewhere
            frame = above.get(frame, frame)
        return frame

    names = [other.name for other in strange if top(other.parent) == top(series.parent)]
    if len(names) <= _FEW:
        yield _undescribed(recording, name, series.child)
    elif name == names[0]:
        message = f"{len(names)} edges below {top(series.parent)} were published, but no such edges are described"
        yield problem("edge-not-described", name, message, evidence=names)


def _evidence(series: Series) -> str:
    rate = f" at {rate_text(series.pace.rate)}" if series.pace.rate > 0 else ""
    return f"{series.name}: {counted(series.pace.count, 'time')} on {series.topic}{rate}"


def _values(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield values that are not transforms, differ from the description, or contradict each other."""
    name, edge = series.name, series.edge
    if series.bad:
        message = f"{name}: {share(series.bad, series.pace.count)} are no transforms (NaN, or a quaternion not of "
        message += f"length 1), first {recording.since_start(series.first_bad):.1f} s into the recording: tf2 drops "
        yield problem("not-a-rotation", name, f"{message}them", f"mend the node that publishes it{series.by_owner}")
    if len(series.values) > 1:
        evidence = []
        for pose, count in series.values:
            compared = ""
            if edge is not None and edge.transform is not None and not edge.moving and series.comparable:
                metres, radians, words = difference(edge.transform, pose)
                is_same = metres <= EXACT and radians <= edge.radians
                compared = ", as described" if is_same else f", {words} against the description"
            evidence.append(f"{count:,} x {pose_text(pose)}{compared}")
        evidence += [f"{series.other_values:,} x other values"] if series.other_values else []
        number = "many" if series.other_values else {2: "two", 3: "three", 4: "four"}[len(series.values)]
        words = difference(series.values[0][0], series.values[1][0])[2]
        message = f"{name} has {number} values, in {counted(series.switches, 'change')}: the second is {words}"
        yield problem("edge-two-values", name, message, evidence=evidence)
    elif series.first_wrong is not None and not series.has_two_sources:
        recorded, described, received = series.first_wrong
        often = "" if series.wrong == series.compared else f" in {share(series.wrong, series.compared)} samples"
        message = f"{name} is {difference(described, recorded)[2]} against the description{often}"
        evidence = [f"described: {pose_text(described)}", f"recorded:  {pose_text(recorded)}"]
        if not series.constant and recording.timed:
            evidence.append(f"first {recording.since_start(received):.1f} s into the recording")
        help = f"{series.owner} publishes it: deploy what is compiled, or correct the description"
        yield problem(value_rule(described, recorded), name, message, help, evidence)


def leaps_text(leaps: Leaps) -> str:
    """Return the reason why a stream seems to have two sources."""
    if leaps.contradict:
        return f"{share(leaps.contradictions, leaps.steps)} stamps come twice with different values"
    return f"{share(leaps.returns, leaps.steps)} samples leap back to where it was, by {leaps.largest:.3g} m or rad"


class Way(NamedTuple):
    """A combination of modes, the edges that should be published in it, and those of them that are missing.

    ``others`` were recorded as described in other modes, each with the edge of these modes; ``text`` is the modes.
    """

    modes: Mapping[str, bool]
    edges: list[Expected]
    missing: list[Expected]
    others: list[tuple[Expected, Expected]]
    text: str


def best_way(recording: Recording) -> Way:
    """Return the combination of modes with the fewest missing edges, and of those the one that fits best."""
    there, ways = {*recording.into, *(row.child for row in recording.rows)}, []
    fitting = [one.edge for one in recording.series.values() if one.edge and one.has_parent and not one.wrong]
    for modes, edges in recording.description.ways():
        own, missing = {edge.child: edge for edge in edges}, [edge for edge in edges if edge.child not in there]
        pairs = ((edge, own[edge.child]) for edge in fitting if edge.child in own)
        others = [(edge, mine) for edge, mine in pairs if edge.value != mine.value]
        text = " and ".join(f"{name} is {'on' if value else 'off'}" for name, value in modes.items())
        ways.append(Way(modes, edges, missing, others, text))
    return min(ways, key=lambda way: (len(way.missing), len(way.others)))


def other_modes(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges of one combination of modes among those of another one."""
    way = best_way(recording)
    for edge, own in way.others:
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
    message = help = ""
    if prefix and prefix != given:
        message = (
            f"all frames begin with {prefix}, {f'not with {given}' if given else 'those of the description do not'}"
        )
        help = f"--prefix {shlex.quote(prefix)} compares what is behind it"
    elif given and frames and not any(name.startswith(given) for name in frames):
        message = f"no frame begins with {given}: there are {first_of(sorted(frames), _FEW)}"
    return problem("frames-prefixed", "the recording", message, help) if message else None


def missing(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the edges that nobody published; several of one node share a finding."""
    if not recording.complete:
        return
    way, description, silent = best_way(recording), recording.description, frozenset[str]()
    if recording.joints.pace.count:  # joints that /joint_states leaves out have a finding of their own
        silent = description.joint_names - recording.joints.ranges.keys()
    no_static = recording.timed and not any(series.static for series in recording.series.values())
    if no_static and (static := [edge.name for edge in way.missing if not edge.moving]):
        edges = "the edge" if len(static) == 1 else f"the {len(static)} edges"
        message = f"the recording has no message of /tf_static: {edges} that should be there could not be compared"
        yield problem("recording-no-static", "/tf_static", message, evidence=[", ".join(static)])
    absent: dict[str, list[Expected]] = {}
    for edge in way.missing:
        is_silent = edge.joint is not None and description.leader(edge.joint) in silent
        if (edge.moving or not no_static) and not is_silent:
            absent.setdefault(edge.owner, []).append(edge)
    for group in absent.values():
        for several in [group] if len(group) > _FEW else [[edge] for edge in group]:
            first, owner, names = several[0], several[0].owner, ", ".join(edge.name for edge in several)
            total = sum(edge.owner == owner for edge in way.edges)
            message = f"{len(several)} of the {total} edges of {owner} were not published: {names}"
            if len(several) == 1:
                message = f"no node published {names}; {owner} should"
            elif len(several) == total:
                message = f"none of the {total} edges of {owner} was published: {names}"
            if way.modes and any(edge.when for edge in several):
                message += f" (when {way.text})"
            help = f"look whether it runs; --without {first.publisher.name} if it was not meant to"
            if first.publisher.kind == ROBOT_STATE_PUBLISHER and all(edge.moving for edge in several):
                help = "robot_state_publisher needs /joint_states for all that moves: look who publishes these"
            topics = {f"/{'tf' if edge.moving else 'tf_static'}" for edge in several}
            recorded = {name[name.rfind("/") :] for name in recording.topics}
            if recording.timed and (lacking := sorted(topics - recorded)):
                help = f"the recording has no {' and no '.join(lacking)}: record it, or look who publishes it"
            yield problem("edge-missing", first.name, message, help)


def stale(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the moving edges whose newest sample was too old; those of one node share a finding."""
    limit, silence, end = recording.description.options.stale, recording.silence, recording.end
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

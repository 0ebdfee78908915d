"""Judge each recorded edge: against the description, and against the other edges into the same frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Diagnostic, and_more, counted, did_you_mean, listed

from .expected import EXACT, Expected
from .findings import YEAR, difference, pose_text, problem, rate_text, seconds, share, value_rule
from .recording import FrameRow, Recording
from .series import Series, transform_from
from .timing import Leaps

_REPEATED = 0.4  # share of repeated stamps from which on a stream is published twice
_FEW = 3


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
        owners = recording.description.by_child.get(child, ())
        yield problem("edge-dropped", f"{parent} -> {child}", message, owners[0].advice if owners else "")


def row(recording: Recording, row: FrameRow) -> Iterator[Diagnostic]:
    """Yield the faults of one frame of view_frames."""
    edge = recording.expected(row.parent, row.child, row.static)
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
    parents = list(dict.fromkeys(series.parent for series in of_child))
    described = [edge.parent for edge in expected]
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
        yield problem(
            "edge-not-moving", name, f"{name} moves, but came on /tf_static: listeners take it for fixed", help
        )
    elif not static and not edge.moving:
        message = (
            f"{name} never moves, but came on /tf at {rate_text(rate)}: it can be late, which a static one never is"
        )
        yield problem("edge-not-static", name, message.replace(" at -:", ":"), help)


def _undescribed(recording: Recording, name: str, child: str) -> Diagnostic:
    guess = did_you_mean(child, recording.description.frames)
    help = guess if guess.startswith("did you mean") else ""
    return problem("edge-not-described", name, f"{name} was published, but no such edge is described", help)


def _not_described(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield the finding for an edge that is not described; many below one frame of the robot share one."""
    description, name = recording.description, series.name
    turns = [edge.when for edge in description.edges if edge.child == series.child]
    joint = description.robot.joint_to.get(series.child)
    if turns:
        message = f"{name} was published, but such an edge is described only when {' or '.join(turns)}"
        yield problem("edge-not-described", name, message, "look what --mode says, and what runs")
        return
    if joint is not None:
        message = f"{name} was published, but the description declares that no node does: {joint.publisher.about}"
        yield problem("edge-not-described", name, message, "find out which node does, and declare it")
        return
    strange = [group[0] for child, group in recording.into.items() if child not in description.by_child]
    above = {other.child: other.parent for other in strange}
    top = {other.name: _top(above, other.parent) for other in strange}
    names = [other for other in top if top[other] == top[name]]
    if len(names) <= _FEW:
        yield _undescribed(recording, name, series.child)
    elif name == names[0]:
        message = f"{len(names)} edges below {top[name]} were published, but no such edges are described"
        yield problem("edge-not-described", name, message, evidence=names)


def _top(parents: dict[str, str], frame: str) -> str:
    """Return the first frame above that has no parent here; a loop ends somewhere."""
    for _ in parents:
        frame = parents.get(frame, frame)
    return frame


def _evidence(series: Series) -> str:
    rate = f" at {rate_text(series.pace.rate)}" if series.pace.rate > 0 else ""
    return f"{series.name}: {counted(series.pace.count, 'time')} on {series.topic}{rate}"


def _values(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield values that are not transforms, differ from the description, or contradict each other."""
    name = series.name
    if series.bad:
        message = (
            f"{name}: {share(series.bad, series.pace.count)} are no transforms (NaN, or a quaternion not of length "
        )
        message += f"1), first {recording.since_start(series.first_bad):.1f} s into the recording: tf2 drops them"
        yield problem("not-a-rotation", name, message, f"mend the node that publishes it{series.by_owner}")
    if len(series.values) > 1:
        evidence = [f"{count:,} x {pose_text(pose)}{_comparison(series, pose)}" for pose, count in series.values]
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


def _comparison(series: Series, pose: Transform) -> str:
    """Return how one of several values of a static edge compares with the description, as the end of a line."""
    edge = series.edge
    if edge is None or edge.transform is None or edge.moving or not series.comparable:
        return ""
    metres, radians, words = difference(edge.transform, pose)
    return ", as described" if metres <= EXACT and radians <= edge.radians else f", {words} against the description"


def leaps_text(leaps: Leaps) -> str:
    """Return the reason why a stream seems to have two sources."""
    if leaps.contradict:
        return f"{share(leaps.contradictions, leaps.steps)} stamps come twice with different values"
    return f"{share(leaps.returns, leaps.steps)} samples leap back to where it was, by {leaps.largest:.3g} m or rad"

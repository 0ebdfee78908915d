"""Judge each recorded edge: against the description, and against the other edges into the same frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, and_more, counted, did_you_mean, listed

from .expected import EXACT, Expected
from .findings import YEAR, difference, pose_text, problem, rate_text, seconds, share, value_rule
from .recording import FrameRow, Recording
from .series import Series, transform_from
from .timing import SECOND, Leaps

_REPEATED = 0.4  # share of repeated stamps from which on a stream is published twice
_FEW = 3
_DECLARE = "declare it under edges, with the node that publishes it"
_DOUBLED = "tf2 takes whichever came last: let one node publish it"


def edges(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the recorded edges."""
    repeated: dict[str, list[Series]] = {}
    for child, of_child in recording.into.items():
        yield from _frame(recording, child, of_child)
        for series in of_child:
            pace, two = series.pace, series.has_two_sources
            yield from _values(recording, series)
            if two:
                yield _two_values(series)
            elif not series.static and pace.count > 4 and pace.repeated > _REPEATED * (pace.count - 1):
                repeated.setdefault(series.owner or series.name, []).append(series)
            elif not series.constant and not series.by_state and pace.alternates:
                message = f"{series.name} comes at {rate_text(pace.rate)} in short and long steps by turns, "
                message += "as two clocks give"
                yield problem("edge-published-twice", series.name, message, _DOUBLED, severity=WARNING)
    for owner, group in repeated.items():
        first, more = group[0], len(group) - 1
        names = f"{first.name}{and_more(more, f'of {owner}')}"
        again = share(first.pace.repeated, max(1, first.pace.count - 1))
        message = f"{names} {'are' if more else 'is'} published twice: {again} stamps come again with the same value"
        yield problem("edge-published-twice", first.name, message, _DOUBLED, severity=WARNING)


def dropped(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the transforms that tf2 drops because of the names of their frames."""
    for (static, parent, child), count in recording.dropped.items():
        many = f"{counted(count, 'transform')} on {'/tf_static' if static else '/tf'}"
        if parent != child:
            nameless = f'under "{parent}"' if not child else f'above "{child}"'
            message = f"the frame {nameless} has no name ({many}): tf2 drops it"
        elif child:
            message = f'"{child}" is published under itself ({many}): tf2 drops that'
        else:
            message = f"neither frame has a name ({many}): tf2 drops that"
        owners = recording.description.by_child.get(child, ())
        help = f"{owners[0].owner} should publish {owners[0].name}" if owners else "correct the frames of the node"
        yield problem("edge-dropped", f"{parent} -> {child}", message, help, numbers={"transforms": count})


def row(recording: Recording, row: FrameRow) -> Iterator[Diagnostic]:
    """Yield the faults of one frame of view_frames."""
    edge = recording.expected(row.parent, row.child, row.static)
    if edge is None:
        yield _undescribed(recording, row.name, row.child)
        return
    if edge.parent != row.parent:
        yield _wrong_parent(row.name, row.child, row.parent, edge)
    yield from _topic(row.name, row.static, edge, f" at {row.rate:.1f} Hz")
    limit = recording.description.options.stale
    if not row.static and row.age is not None and limit < row.age <= YEAR:
        message = f"{row.name} went {seconds(row.age)} stale, when view_frames looked"
        help = f"whoever asks then gets where things were {seconds(row.age)} ago: look why {edge.owner} stopped"
        evidence = [f"average rate {row.rate:.1f} Hz"]
        yield problem("edge-stale", row.name, message, f"{help} (--stale: {seconds(limit)})", evidence=evidence)


def _frame(recording: Recording, child: str, of_child: Sequence[Series]) -> Iterator[Diagnostic]:
    """Yield the faults of the parents and topics of one frame."""
    expected = recording.description.by_child.get(child)
    if expected is None:
        yield from _not_described(recording, of_child)
        return
    parents = list(dict.fromkeys(series.parent for series in of_child))
    described = [edge.parent for edge in expected]
    if len(parents) > 1:
        names = listed(f"{name}{'' if name in described else ' (not described)'}" for name in parents)
        message = f'the frame "{child}" was published under {len(parents)} parents: {names}'
        help = f"a frame has one parent, {described[0]}: stop the node that publishes the other"
        evidence = [_evidence(series) for series in of_child]
        yield problem("edge-two-parents", f"{described[0]} -> {child}", message, help, evidence=evidence)
    elif parents[0] not in described:
        yield _wrong_parent(of_child[0].name, child, parents[0], expected[0])
    for parent in parents:
        on_topics = [series for series in of_child if series.parent == parent]
        first = on_topics[0]
        edge = first.edge or expected[0]
        if len(on_topics) > 1:
            message = f"{first.name} came on /tf and on /tf_static: two nodes publish it"
            help = f"{edge.owner} publishes it on {'/tf' if edge.moving else '/tf_static'}; stop the other"
            evidence = [_evidence(series) for series in on_topics]
            yield problem("edge-static-and-moving", first.name, message, help, evidence=evidence)
        else:
            yield from _topic(first.name, first.static, edge, _rate(first))


def _wrong_parent(name: str, child: str, parent: str, edge: Expected) -> Diagnostic:
    message = f'the parent of "{child}" is "{parent}", described is "{edge.parent}"'
    return problem("edge-wrong-parent", name, message, f"{edge.owner} should publish {edge.name}")


def _topic(name: str, static: bool, edge: Expected, rate: str) -> Iterator[Diagnostic]:
    if static and edge.moving:
        message = f"{name} moves, but came on /tf_static: listeners take it for fixed"
        yield problem("edge-not-moving", name, message, f"{edge.owner} should publish it on /tf, again and again")
    elif not static and not edge.moving:
        message = f"{name} never moves, but came on /tf{rate}: it can be late, which a static one never is"
        yield problem("edge-not-static", name, message, f"{edge.owner} should publish it on /tf_static")


def _undescribed(recording: Recording, name: str, child: str) -> Diagnostic:
    frames = recording.description.frames
    help = did_you_mean(child, frames) if frames else ""
    help = help if help.startswith("did you mean") else _DECLARE
    message = f"{name} was published, but no such edge is described"
    return problem("edge-not-described", name, message, help, severity=WARNING)


def _not_described(recording: Recording, of_child: Sequence[Series]) -> Iterator[Diagnostic]:
    """Yield the finding for an edge that is not described; many below one frame of the robot share one."""
    series, description = of_child[0], recording.description
    turns = [edge.when for edge in description.edges if edge.child == series.child]
    joint = description.robot.joint_to.get(series.child)
    if turns:
        message = f"{series.name} was published, but such an edge is described only when {' or '.join(turns)}"
        help = "look what --mode says, and what runs"
        yield problem("edge-not-described", series.name, message, help, severity=WARNING)
        return
    if joint is not None:
        message = f"{series.name} was published, but the description says that nobody does: {joint.publisher.about}"
        help = "find out which node does, and declare it"
        yield problem("edge-not-described", series.name, message, help, severity=WARNING)
        return
    strange = [group[0] for child, group in recording.into.items() if child not in description.by_child]
    above = {other.child: other.parent for other in strange}

    def top(frame: str) -> str:
        """Return the first frame above that is described, or the topmost one."""
        for _ in above:  # at most as often: there may be a loop
            frame = above.get(frame, frame)
        return frame

    names = [other.name for other in strange if top(other.parent) == top(series.parent)]
    if len(names) <= _FEW:
        yield _undescribed(recording, series.name, series.child)
    elif series.name == names[0]:
        message = f"{len(names)} edges below {top(series.parent)} were published, but no such edges are described"
        numbers = {"edges": names}
        yield problem(
            "edge-not-described", names[0], message, _DECLARE, severity=WARNING, evidence=names, numbers=numbers
        )


def _rate(series: Series) -> str:
    return "" if math.isnan(series.pace.rate) else f" at {rate_text(series.pace.rate)}"


def _evidence(series: Series) -> str:
    return f"{series.name}: {counted(series.pace.count, 'time')} on {series.topic}{_rate(series)}"


def _values(recording: Recording, series: Series) -> Iterator[Diagnostic]:
    """Yield values that are not transforms, differ from the description, or contradict each other."""

    def when(time: int) -> str:
        return f"{max(0.0, (time - (recording.start or 0)) / SECOND):.1f} s into the recording"

    if series.bad:
        message = f"{series.name}: {share(series.bad, series.pace.count)} are no transforms (NaN, or a quaternion not "
        message += f"of length 1), first {when(series.first_bad)}: tf2 drops them"
        owner = f" ({series.owner})" if series.owner else ""
        yield problem("not-a-rotation", series.name, message, f"mend the node that publishes it{owner}")
    if len(series.values) > 1:
        yield _several_values(series)
    elif series.first_wrong is not None and not series.has_two_sources:
        recorded, described, received = series.first_wrong
        metres, radians, words = difference(described, recorded)
        often = "" if series.wrong == series.compared else f" in {share(series.wrong, series.compared)} samples"
        message = f"{series.name} is {words} against the description{often}"
        evidence = [f"described: {pose_text(described)}", f"recorded:  {pose_text(recorded)}"]
        if series.edge is not None and series.edge.moving and recording.timed:
            evidence.append(f"first {when(received)}")
        help = f"{series.owner} publishes it: deploy what is compiled, or correct the description"
        rule, numbers = value_rule(described, recorded), {"metres": metres, "radians": radians}
        yield problem(rule, series.name, message, help, evidence=evidence, numbers=numbers)


def _several_values(series: Series) -> Diagnostic:
    """Return the finding for an edge that should be constant and is not."""
    edge, evidence = series.edge, []
    for pose, count in series.values:
        comparison = ""
        if edge is not None and edge.transform is not None and not edge.moving and series.comparable:
            metres, radians, words = difference(edge.transform, pose)
            fits = metres <= EXACT and radians <= edge.radians
            comparison = ", as described" if fits else f", {words} against the description"
        evidence.append(f"{count:,} x {pose_text(pose)}{comparison}")
    evidence += [f"{series.other_values:,} x other values"] if series.other_values else []
    number = "many" if series.other_values else {2: "two", 3: "three", 4: "four"}[len(series.values)]
    words = difference(series.values[0][0], series.values[1][0])[2]
    message = f"{series.name} has {number} values, in {counted(series.switches, 'change')}: the second is {words}"
    return problem("edge-two-values", series.name, message, _DOUBLED, evidence=evidence)


def _two_values(series: Series) -> Diagnostic:
    pair = series.leaps.pair or ()
    evidence = [pose_text(transform_from(pose[:3], pose[3:])) for pose in pair]
    if series.compared:
        evidence.append(f"not as described: {share(series.wrong, series.compared)} samples")
    message = f"{series.name} has two values in turns: {leaps_text(series.leaps)}"
    return problem("edge-two-values", series.name, message, _DOUBLED, evidence=evidence)


def leaps_text(leaps: Leaps) -> str:
    """Return the reason why a stream seems to have two sources."""
    if leaps.contradict:
        return f"{share(leaps.contradictions, leaps.steps)} stamps come twice with different values"
    return f"{share(leaps.returns, leaps.steps)} samples leap back to where it was, by {leaps.largest:.3g} m or rad"

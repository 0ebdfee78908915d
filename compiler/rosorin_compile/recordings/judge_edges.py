"""Judging edges: each recorded edge against the description, and against the others into the same frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, and_more, counted, did_you_mean, listed
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND, Samples, transform_from
from .expected import Expected
from .findings import difference, half_turn_about, pose_text, problem, rate_text, seconds, share
from .pace import FEWEST_TWICE, Leaps
from .recording import Recording
from .series import Series, Wrong

RULES = (
    Rule(
        "edge-not-described",
        "A warning: an edge was published that is not described, or that nobody should publish.",
        "Correct the name, or declare the edge.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-wrong-parent",
        "A frame hangs on another frame than described.",
        "Correct the node, or the description.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-dropped",
        "A transform puts a frame under itself, or lacks a name: tf2 drops it.",
        "Correct the frames that the node is told.",
        Heading.RECORDINGS,
    ),
    Rule("edge-two-parents", "A frame was published under two parents.", "Stop one of the nodes.", Heading.RECORDINGS),
    Rule(
        "edge-two-values",
        "Two nodes publish one edge, with two values: a stamp has both, or the edge leaps to and fro, or it stood "
        "still and had several.",
        "Stop one of the nodes.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-published-twice",
        "A warning: two nodes seem to publish one edge, with the same values.",
        "Stop one of the nodes.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-static-and-moving",
        "An edge came on `/tf` and on `/tf_static`.",
        "Stop one of the nodes.",
        Heading.RECORDINGS,
    ),
    Rule(
        "edge-not-static", "An edge that never moves came on `/tf`.", "Publish it on `/tf_static`.", Heading.RECORDINGS
    ),
    Rule("edge-not-moving", "An edge that moves came on `/tf_static`.", "Publish it on `/tf`.", Heading.RECORDINGS),
    Rule(
        "edge-wrong-value",
        "An edge is elsewhere than described; the message says by how much.",
        "Deploy what is compiled, or correct the description.",
        Heading.RECORDINGS,
    ),
    Rule(
        "mounted-backwards",
        "An edge is turned by half a turn about z: the yaw of a sensor that is mounted backwards is missing, or said "
        "twice.",
        "Deploy what is compiled, or correct the description.",
        Heading.RECORDINGS,
    ),
    Rule(
        "not-a-rotation",
        "A transform has NaN, or a quaternion that is not of length one: tf2 drops it.",
        "Mend the node.",
        Heading.RECORDINGS,
    ),
)

# A stream is told to be published twice from this share of stamps on that come twice.
DOUBLES = 0.4
_FEW = 3
_DECLARE = "declare it under edges, with the node that publishes it"
_DOUBLED = "tf2 takes whichever came last: let one node publish it"


def edges(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the edges that were recorded."""
    twice: dict[str, list[Series]] = {}
    for child, of_child in recording.into.items():
        yield from _frame(recording, child, of_child)
        for series in of_child:
            two = not series.constant and two_values(series)
            yield from _values(recording, series, two)
            if two:
                yield _two_values(series)
            elif _comes_twice(series):
                twice.setdefault(series.owner or series.name, []).append(series)
            elif not series.constant and series.pace.alternates:
                yield _alternates(series)
    for owner, several in twice.items():
        yield _twice(owner, several)


def dropped(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the transforms that tf2 drops for their names: they are no edges, and nobody's second parent."""
    for (still, parent, child), count in recording.dropped.items():
        many = f"{counted(count, 'transform')} on {'/tf_static' if still else '/tf'}"
        message = f'"{child}" is published under itself ({many}): tf2 drops that'
        if parent != child:
            message = f'the frame under "{parent}" has no name ({many}): tf2 drops it'
            message = f'the frame above "{child}" has no name ({many}): tf2 drops it' if child else message
        elif not child:
            message = f"neither frame has a name ({many}): tf2 drops that"
        owners = recording.description.by_child.get(child, ())
        help = f"{owners[0].owner} should publish {owners[0].name}" if owners else "correct the frames of the node"
        yield problem("edge-dropped", f"{parent} -> {child}", message, help, numbers={"transforms": count})


def owner_of(series: Series) -> str:
    """Return who should publish an edge, in brackets."""
    return f" ({series.owner})" if series.owner else ""


def _frame(recording: Recording, child: str, of_child: Sequence[Series]) -> Iterator[Diagnostic]:
    expected = recording.description.by_child.get(child)
    parents = list(dict.fromkeys(series.parent for series in of_child))
    if expected is None:
        yield from _not_described(recording, of_child)
        return
    described = [edge.parent for edge in expected]
    if len(parents) > 1:
        names = listed(f"{name}{'' if name in described else ' (not described)'}" for name in parents)
        evidence = [_evidence(series) for series in of_child]
        message = f'the frame "{child}" was published under {len(parents)} parents: {names}'
        help = f"a frame has one parent, {described[0]}: stop the node that publishes the other"
        yield problem("edge-two-parents", f"{described[0]} -> {child}", message, help, evidence=evidence)
    elif parents[0] not in described:
        message = f'the parent of "{child}" is "{parents[0]}", described is "{described[0]}"'
        help = f"{expected[0].owner} should publish {expected[0].name}"
        yield problem("edge-wrong-parent", of_child[0].name, message, help)
    for parent in parents:
        yield from _topics([series for series in of_child if series.parent == parent], expected)


def _not_described(recording: Recording, of_child: Sequence[Series]) -> Iterator[Diagnostic]:
    """Yield the finding for an edge that is not described; many below one frame of the robot are told once."""
    series, description = of_child[0], recording.description
    turns = [edge.when for edge in description.edges if edge.child == series.child]
    if turns:
        message = f"{series.name} was published, but such an edge is described only when {' or '.join(turns)}"
        yield problem(
            "edge-not-described", series.name, message, "look what --mode says, and what runs", severity=WARNING
        )
        return
    joint = description.robot.joint_to.get(series.child)
    if joint is not None:
        message = f"{series.name} was published, but the description says that nobody does: {joint.publisher.about}"
        help = "find out which node does, and declare it"
        yield problem("edge-not-described", series.name, message, help, severity=WARNING)
        return
    top = _top(recording, series)
    names = [other.name for other in _strange(recording) if _top(recording, other) == top]
    if len(names) <= _FEW:
        message = f"{series.name} was published, but no such edge is described"
        help = did_you_mean(series.child, description.frames) if description.frames else ""
        help = help if help.startswith("did you mean") else _DECLARE
        yield problem("edge-not-described", series.name, message, help, severity=WARNING)
    elif series.name == names[0]:
        message = f"{len(names)} edges below {top} were published, but no such edges are described"
        numbers = {"edges": names}
        yield problem(
            "edge-not-described", names[0], message, _DECLARE, severity=WARNING, evidence=names, numbers=numbers
        )


def _strange(recording: Recording) -> list[Series]:
    return [of_child[0] for child, of_child in recording.into.items() if child not in recording.description.by_child]


def _top(recording: Recording, series: Series) -> str:
    """Return the first frame above an edge that is described, or the topmost there is."""
    above = {other.child: other.parent for other in _strange(recording)}
    frame = series.parent
    for _ in above:  # as often at most: there may be a loop
        if frame not in above:
            break
        frame = above[frame]
    return frame


def _topics(of_child: Sequence[Series], expected: Sequence[Expected]) -> Iterator[Diagnostic]:
    edge = of_child[0].edge or expected[0]
    name = of_child[0].name
    if len(of_child) > 1:
        evidence = [_evidence(series) for series in of_child]
        message = f"{name} came on /tf and on /tf_static: two nodes publish it"
        right = "/tf" if edge.moving else "/tf_static"
        help = f"{edge.owner} publishes it on {right}; stop the other"
        yield problem("edge-static-and-moving", name, message, help, evidence=evidence)
    else:
        yield from on_wrong_topic(name, of_child[0].still, edge, _rate(of_child[0]))


def on_wrong_topic(name: str, still: bool, edge: Expected, rate: str) -> Iterator[Diagnostic]:
    """Yield the finding for an edge that came on /tf_static (``still``) although it moves, or the other way round."""
    if still and edge.moving:
        message = f"{name} moves, but came on /tf_static: listeners take it for fixed"
        yield problem("edge-not-moving", name, message, f"{edge.owner} should publish it on /tf, again and again")
    elif not still and not edge.moving:
        message = f"{name} never moves, but came on /tf{rate}: it can be late, which a static one never is"
        yield problem("edge-not-static", name, message, f"{edge.owner} should publish it on /tf_static")


def _rate(series: Series) -> str:
    return "" if math.isnan(series.pace.rate) else f" at {rate_text(series.pace.rate)}"


def _evidence(series: Series) -> str:
    return f"{series.name}: {counted(series.pace.count, 'time')} on {series.topic}{_rate(series)}"


def _values(recording: Recording, series: Series, two: bool) -> Iterator[Diagnostic]:
    """Yield values that are no transforms, not as described, or several; ``two`` says that the last is told already."""
    values = series.values
    if values.bad:
        when = _when(recording, values.first_bad)
        message = (
            f"{series.name}: {share(values.bad, series.pace.count)} are no transforms (NaN, or a quaternion not of"
        )
        message += f" length 1), first {when}: tf2 drops them"
        yield problem("not-a-rotation", series.name, message, f"mend the node that publishes it{owner_of(series)}")
    if len(values.seen) > 1:
        yield _two_still_values(series)
    elif values.first_wrong is not None and not two:
        yield _wrong_value(recording, series, values.first_wrong)


def _wrong_value(recording: Recording, series: Series, first: Wrong) -> Diagnostic:
    values = series.values
    described, recorded = transform_from(first.xyz, first.quaternion), transform_of(first.sample)
    metres, radians, words = difference(described, recorded)
    rule = "mounted-backwards" if half_turn_about(described, recorded) == "z" else "edge-wrong-value"
    often = "" if values.wrong == values.compared else f" in {share(values.wrong, values.compared)} samples"
    message = f"{series.name} is {words} against the description{often}"
    evidence = [f"described: {pose_text(described)}", f"recorded:  {pose_text(recorded)}"]
    if series.edge is not None and series.edge.moving and recording.timed:
        evidence.append(f"first {_when(recording, int(first.sample.received[0]))}")
    help = f"{series.owner} publishes it: "
    help += "deploy what is compiled, or correct the description"
    return problem(rule, series.name, message, help, evidence=evidence, numbers={"metres": metres, "radians": radians})


def _two_still_values(series: Series) -> Diagnostic:
    values = series.values
    poses = [transform_of(seen.sample) for seen in values.seen]
    reference = series.reference.edge.transform if series.reference is not None else None
    evidence = []
    for seen, pose in zip(values.seen, poses, strict=True):
        like = ""
        if reference is not None and series.edge is not None and not series.edge.moving:
            metres, radians, words = difference(reference, pose)
            tolerance = series.edge.tolerance
            fits = metres <= tolerance.metres and radians <= tolerance.radians
            like = ", as described" if fits else f", {words} against the description"
        evidence.append(f"{seen.count:,} x {pose_text(pose)}{like}")
    if values.others:
        evidence.append(f"{values.others:,} x other values")
    _, _, words = difference(poses[0], poses[1])
    message = (
        f"{series.name} has {_number(values.seen, values.others)} values, in {counted(values.switches, 'change')}:"
    )
    message += f" the second is {words}"
    return problem("edge-two-values", series.name, message, _DOUBLED, evidence=evidence)


def _number(seen: Sequence[object], others: int) -> str:
    return "many" if others else {2: "two", 3: "three", 4: "four"}[len(seen)]


def _two_values(series: Series) -> Diagnostic:
    evidence = []
    if series.leaps.pair is not None:
        evidence = [pose_text(transform_from(pose[:3], pose[3:])) for pose in series.leaps.pair]
    if series.values.compared:
        evidence.append(f"not as described: {share(series.values.wrong, series.values.compared)} samples")
    message = f"{series.name} has two values in turns: {leaps_text(series.leaps)}"
    return problem("edge-two-values", series.name, message, _DOUBLED, evidence=evidence)


def _comes_twice(series: Series) -> bool:
    """Whether the stamps of an edge come again; on /tf_static that is what latched publishers do."""
    pace = series.pace
    return not series.still and pace.count > 4 and pace.twice > DOUBLES * (pace.count - 1)


def _alternates(series: Series) -> Diagnostic:
    rate = rate_text(series.pace.rate)
    message = f"{series.name} comes at {rate} in short and long steps by turns, as two clocks give"
    return problem("edge-published-twice", series.name, message, _DOUBLED, severity=WARNING)


def leaps_text(leaps: Leaps) -> str:
    """Return why a stream seems to have two sources."""
    if leaps.twice_different >= FEWEST_TWICE:
        return f"{share(leaps.twice_different, leaps.steps)} stamps come twice with different values"
    return f"{share(leaps.returns, leaps.steps)} samples leap back to where it was, by {leaps.largest:.3g} m or rad"


def _twice(owner: str, several: Sequence[Series]) -> Diagnostic:
    first, more = several[0], len(several) - 1
    names = f"{first.name}{and_more(more, f'of {owner}')}"
    again = share(first.pace.twice, max(1, first.pace.count - 1))
    message = f"{names} {'are' if more else 'is'} published twice: {again} stamps come again with the same value"
    return problem("edge-published-twice", first.name, message, _DOUBLED, severity=WARNING)


def transform_of(sample: Samples) -> Transform:
    """Return the first of some samples."""
    return transform_from(sample.xyz[0], sample.quaternion[0])


def _when(recording: Recording, time: int) -> str:
    return f"{max(0.0, (time - (recording.start or 0)) / SECOND):.1f} s into the recording"


def two_values(series: Series) -> bool:
    """Whether two nodes seem to publish a moving edge, with different values.

    What follows the joint states in all samples may leap as it likes.
    """
    as_described = series.values.compared > 0 and not series.values.wrong
    return series.leaps.two and not as_described


def age_text(value: float) -> str:
    """Return an age, or that it is not known."""
    return "-" if math.isnan(value) else seconds(max(0.0, value))

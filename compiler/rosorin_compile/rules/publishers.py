"""Who publishes a frame: conditions over modes, one publisher in every mode, and each of them is started."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from rosorin_compile.language.arguments import is_listed
from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Publisher, Robot
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, UnknownName, did_you_mean
from rosorin_compile.source.rule_registry import FRAMES, JOINTS, Check, rule
from rosorin_compile.source.tree import Path, Seq, Text, at, exists
from rosorin_compile.source.wording import first_of, listed, quoted

from .case import Case, first_fed

MAX_MODES = 10
_NAME = re.compile(r"[^\W\d]\w*")

Combination = Mapping[str, bool]


@rule("unknown-mode", "`when` names a mode that is not in `modes`.", "Correct it, or add the mode.", FRAMES)
@rule("bad-condition", "`when` is invalid or never true.", 'Combine modes: "slam and not replay".', FRAMES)
@rule("too-many-modes", "Conditions depend on too many modes.", "Use at most 10 modes for one frame.", FRAMES)
def legal(case: Case) -> Iterator[Diagnostic]:
    """Conditions that are invalid, name an unknown mode, or are never true."""
    for index, edge in enumerate(case.robot.edges):
        yield from _problems(case, index, edge)


def is_legal(case: Case, edge: Edge) -> bool:
    """Return True if the condition of an edge is valid."""
    return not any(_problems(case, 0, edge))


def _problems(case: Case, index: int, edge: Edge) -> Iterator[Diagnostic]:
    if not edge.when:
        return
    path, way = case.edge(index, "when"), f"{edge.parent} -> {edge.child}"
    names = modes_in(case.robot, [edge.when])
    if len(names) > MAX_MODES:
        message = f"the condition of {way} depends on {len(names)} modes: too many to check"
        yield case.problem("too-many-modes", message, path)
        return
    try:
        results = [evaluate(edge.when, combination.__getitem__) for combination in combinations(names)]
    except ExpressionError as problem:
        yield _invalid(case, index, edge, problem)
        return
    if not all(isinstance(result, bool) for result in results):
        message = f'the condition "{edge.when}" is not true or false'
        yield case.problem("bad-condition", message, path)
    elif not any(results):
        message = f'the condition "{edge.when}" is never true: {way} would not be published'
        yield case.problem("bad-condition", message, path, "correct the condition, or remove the edge")


def _invalid(case: Case, index: int, edge: Edge, problem: ExpressionError) -> Diagnostic:
    """Return the diagnostic of a condition that cannot be evaluated, at the column of the mistake."""
    name, column = problem.unknown, problem.column
    if name and not name.endswith("()"):
        help = Suggestion(name, case.robot.modes, f'add "{name}" to modes')
        found = case.problem("unknown-mode", f'there is no mode "{name}"', case.edge(index, "when"), help)
    else:
        name, reason = " ", problem.message.removeprefix("not an expression: ")
        message = f'the condition "{edge.when}" cannot be read: {reason}'
        found = case.problem("bad-condition", message, case.edge(index, "when"))
    if found.span is None or found.span.length < len(edge.when):
        return found
    # The expression is read without the blanks around it; quotes are part of the value's place in the file.
    is_quoted = isinstance(at(case.tree, case.edge(index, "when")), Text)
    start = len(edge.when) - len(edge.when.lstrip()) + column + is_quoted
    return replace(found, span=found.span._replace(column=found.span.column + start, length=max(1, len(name))))


def holds(when: str, combination: Combination) -> bool:
    """Return True if a legal condition is true in a combination of modes."""
    return not when or bool(evaluate(when, combination.__getitem__))


def modes_in(robot: Robot, whens: Iterable[str]) -> list[str]:
    """Return the modes that conditions name, in the order of the description."""
    named = {name for when in whens for name in _NAME.findall(when)}
    return [mode for mode in robot.modes if mode in named]


def combinations(modes: list[str]) -> Iterator[Combination]:
    """Yield every way in which modes can be on and off."""
    for states in product((False, True), repeat=len(modes)):
        yield dict(zip(modes, states, strict=True))


def in_words(combination: Combination) -> str:
    """Return a combination as the end of a sentence: ' when "slam" is off'; empty without modes."""
    states = [f'"{mode}" is {"on" if on else "off"}' for mode, on in combination.items()]
    return f" when {' and '.join(states)}" if states else ""


def check_modes(robot: Robot, modes: Mapping[str, bool]) -> Mapping[str, bool]:
    """Return modes by name if the robot has all of them. Raises UnknownName."""
    for name in modes:
        if name not in robot.modes:
            known = did_you_mean(name, robot.modes) or "it has none"
            raise UnknownName(f'{robot.name} has no mode "{name}"; {known}')
    return modes


# --- transforms ---


class Step(NamedTuple):
    """A transform: a joint, an edge, or a turn in the list of publishers of a joint.

    ``edge`` is the index of an edge, None for a joint. ``joint`` is empty for an edge of its own. ``path`` is that of
    the name of the parent.
    """

    parent: str
    child: str
    publisher: Publisher
    joint: str
    when: str
    edge: int | None
    path: Path

    @property
    def is_silent(self) -> bool:
        """Whether it is the turn of a joint in which nobody publishes it."""
        return self.publisher.kind == UNPUBLISHED and self.joint != ""

    @property
    def owner(self) -> str:
        """Who publishes it, in words."""
        static = f'static_transform_publisher "{self.publisher.name}"'
        name = static if self.publisher.kind == STATIC_TRANSFORM_PUBLISHER else self.publisher.name or "nobody"
        return f'{name} (joint "{self.joint}")' if self.joint else name


def all_steps(case: Case, legal: bool = True) -> list[Step]:
    """Return the transforms of joints, then those of edges and turns; with ``legal`` only those of valid conditions."""
    found = [
        Step(one.parent, one.child, one.publisher, one.name, "", None, case.end(one, "parent"))
        for one in case.robot.joints
    ]
    return found + [
        Step(edge.parent, edge.child, edge.publisher, edge.joint, edge.when, index, case.edge(index, "parent"))
        for index, edge in enumerate(case.robot.edges)
        if not legal or is_legal(case, edge)
    ]


def legal_steps(case: Case) -> list[Step]:
    """Return the transforms that are published in some combination of modes."""
    return [step for step in all_steps(case) if not step.is_silent]


def silent_turns(case: Case) -> list[Step]:
    """Return the turns of joints in which nobody publishes them."""
    return [step for step in all_steps(case) if step.is_silent and step.edge is not None]


def active_in(published: Iterable[Step], combination: Combination) -> list[Step]:
    """Return the transforms that are published in a combination of modes."""
    return [step for step in published if holds(step.when, combination)]


# --- publishers ---


def _claims(case: Case) -> dict[str, list[Step]]:
    """Return the transforms into each frame that an edge leads to, joints first.

    Into another frame only a joint leads, and nobody else can publish that. Of a link with two parents only the first
    is taken: that is the cause. Edges with an invalid condition are left out.
    """
    led_to = {edge.child for edge in case.robot.edges}
    steps = [step for step in all_steps(case) if step.child in led_to] if led_to else []
    by_child: dict[str, list[Step]] = {}
    for step in sorted(steps, key=lambda step: (step.edge is not None, not step.joint)):
        claims = by_child.setdefault(step.child, [])
        is_published = step.publisher.kind != UNPUBLISHED
        if (is_published and not claims) if step.edge is None else (is_published or step.joint):
            claims.append(step)
    return by_child


def _place(case: Case, step: Step) -> Path:
    """Return the path of the child of an edge, or of the publisher of a joint."""
    if step.edge is not None:
        return case.edge(step.edge, "child")
    joint = case.robot.joint[step.joint]
    return _turn_of_urdf(case, joint) or case.end(joint, "child")


def _turn_of_urdf(case: Case, joint: Joint) -> Path | None:
    """Return the path of robot_state_publisher in a list of publishers, or None if there is no such list."""
    path = case.publisher(joint)
    turns = at(case.tree, path) if path[-1] == "publisher" else None
    for index, turn in enumerate(turns if isinstance(turns, Seq) else ()):
        if turn["by"] == ROBOT_STATE_PUBLISHER:
            return (*path, index, "by")
    return None


@rule("two-publishers", "Two publishers own one frame.", "Remove one, or exclude each other by `when`.", FRAMES)
@rule("unpublished-edge", "Nobody publishes an edge; a warning in some modes.", "Name a publisher.", FRAMES)
def one_publisher(case: Case) -> Iterator[Diagnostic]:
    """Frames that have two publishers at once, and frames that have none in some combination of modes."""
    edges = case.robot.edges
    bare = {edge.child for edge in edges if edge.publisher.kind == UNPUBLISHED and not edge.joint}
    bare |= {edge.child for edge in edges if not is_legal(case, edge)}
    for child, claims in _claims(case).items():
        modes = modes_in(case.robot, [claim.when for claim in claims])
        if len(modes) > MAX_MODES:
            message = f'the publishers of "{child}" depend on {len(modes)} modes together: too many to check'
            yield case.problem("too-many-modes", message, _place(case, claims[-1]), severity=WARNING)
            continue
        gap: Combination | None = None
        for combination in combinations(modes):
            active = [claim for claim in claims if holds(claim.when, combination)]
            clashing = _clashing(active)
            if clashing:
                yield _two(case, child, clashing, combination)
                break
            gap = combination if not active and gap is None else gap
        else:
            if gap is not None and child not in bare:
                first, *others = claims
                message = f'nobody publishes the transform into "{child}"{in_words(gap)}'
                related = [(f"published here when {one.when}, by {one.owner}", _place(case, one)) for one in others]
                help = f"add {'an entry' if first.joint else 'an edge'} for that case, or widen the condition"
                path = case.edge(first.edge or 0, "when")
                yield case.problem("unpublished-edge", message, path, help, related=related, severity=WARNING)


def _clashing(active: list[Step]) -> list[Step]:
    """Return the claims that contradict each other; an edge may publish a joint that is on no topic."""
    owners = [claim for claim in active if not claim.is_silent]
    joints = {claim.joint for claim in owners if claim.joint}
    silent = [claim for claim in active if claim.is_silent and claim.joint in joints]
    return owners if len(owners) > 1 else [*silent, *owners] if silent else []


def _two(case: Case, child: str, active: list[Step], combination: Combination) -> Diagnostic:
    owners = list(dict.fromkeys(claim.owner for claim in active))
    parents = list(dict.fromkeys(claim.parent for claim in active))
    what = f"{listed(owners)} {'publishes twice' if len(owners) == 1 else 'publish'}"
    what = f"nobody and {active[-1].owner} are to publish" if active[0].is_silent else what
    message = f'{what} the transform into "{child}"{f", below {quoted(parents)}" if len(parents) > 1 else ""}'
    related = [(f"also published here, by {claim.owner}", _place(case, claim)) for claim in active[:-1]]
    help = "a frame has one publisher at a time: remove one, or give the edges conditions that exclude each other"
    joint = case.robot.joint.get(active[0].joint)
    if joint is not None and joint.publisher.kind == ROBOT_STATE_PUBLISHER:
        help = "robot_state_publisher publishes every joint of its URDF in every mode: choose the publisher by an"
        help += ' argument of the build, publisher: "${publisher}", or keep the joint for other programs, {none: WHY}'
    return case.problem(
        "two-publishers", message + in_words(combination), _place(case, active[-1]), help, related=related
    )


@Check
def urdf_always(case: Case) -> Iterator[Diagnostic]:
    """Conditions of robot_state_publisher, which publishes all of its URDF in every mode (bad-condition)."""
    claims = _claims(case) if case.robot.edges else {}
    for joint in case.robot.published_by(ROBOT_STATE_PUBLISHER):
        place = _turn_of_urdf(case, joint)
        when = at(case.tree, (*place[:-1], "when")) if place else None
        # With another one the frame has two publishers, which is reported.
        if place and when and len(claims.get(joint.child, ())) < 2:
            message = f'robot_state_publisher publishes joint "{joint.name}" in every mode, not only when {when}'
            help = 'leave the condition out, or choose by an argument of the build: publisher: "${publisher}"'
            yield case.problem("bad-condition", message, (*place[:-1], "when"), help)


@Check
def some_publisher(case: Case) -> Iterator[Diagnostic]:
    """Edges without a publisher: they would be in no artifact and nobody would own them (unpublished-edge)."""
    names = ", ".join(publisher.name for publisher in case.robot.publishers)
    help = f"add publisher: NAME, one of {names}" if names else "declare a node in publishers: publisher: NAME"
    for index, edge in enumerate(case.robot.edges):
        if edge.publisher.kind == UNPUBLISHED and not edge.joint:
            message = f"nobody publishes the edge {edge.parent} -> {edge.child}"
            yield case.problem("unpublished-edge", message, ("edges", index, "child"), help)


def _static_publishers(case: Case) -> Iterator[tuple[Joint, Publisher, Path]]:
    """Yield the joints that a static_transform_publisher publishes, always or in a turn, and the path that names it."""
    robot = case.robot
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        yield joint, joint.publisher, case.publisher(joint)
    for index, edge in enumerate(robot.edges):
        if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            yield robot.joint[edge.joint], edge.publisher, case.edge(index, "publisher")


@rule("static-tf-moves", help="Let robot_state_publisher publish it.", topic=FRAMES)
def static_joints(case: Case) -> Iterator[Diagnostic]:
    """A joint that moves has a static_transform_publisher."""
    for joint, _, path in _static_publishers(case):
        if not joint.is_fixed:
            message = f'joint "{joint.name}" is {joint.type}, but a static_transform_publisher is for fixed ones'
            yield case.problem("static-tf-moves", message, path)


@Check
def started(case: Case) -> Iterator[Diagnostic]:
    """Joints whose publisher no artifact starts or feeds (unpublished-edge).

    An output of an unknown format may be the missing one: that is reported alone.
    """
    robot, outputs = case.robot, case.section("outputs").values()
    if any(one.backend not in case.formats for one in robot.outputs) or not any(map(is_listed, outputs)):
        return
    launched = bool(case.feeding(STATIC_TRANSFORM_PUBLISHER))
    has_urdf = first_fed(robot, ROBOT_STATE_PUBLISHER, case.formats) is not None
    statics = [joint for joint, _, _ in _static_publishers(case)]
    for kind, joints, is_there, what in (
        (STATIC_TRANSFORM_PUBLISHER, statics, launched, "launch file that starts it"),
        (ROBOT_STATE_PUBLISHER, list(robot.published_by(ROBOT_STATE_PUBLISHER)), has_urdf, "URDF that it reads"),
    ):
        is_explicit = any(exists(case.tree, case.joint(joint, "publisher")) for joint in joints)
        if not is_there and (is_explicit or (launched and joints)):
            names = first_of([joint.name for joint in joints], 3)
            count = "one joint" if len(joints) == 1 else f"{len(joints)} joints"
            message = f"{kind} is to publish {count} ({names}), but no output is the {what}"
            format = next(one for one in case.formats.values() if one.write is not None and kind in one.feeds)
            help = f"add {format.name}: {{file: {format.file.format(robot.name)}}} to outputs"
            yield case.problem("unpublished-edge", message, ("outputs",), help, key=True)


@rule("planar-taken-as-fixed", help="Make it `type: floating`, with `publisher: NODE` or `{none: WHY}`.", topic=JOINTS)
def planar(case: Case) -> Iterator[Diagnostic]:
    """A warning: a planar joint is in the URDF, and robot_state_publisher takes it for a fixed one.

    ros/kdl_parser takes an unknown type for fixed, and robot_state_publisher sends it as static; floating it skips.
    """
    has_urdf = bool(case.feeding(ROBOT_STATE_PUBLISHER))
    for joint in case.robot.joints:
        ours = joint.publisher.kind == ROBOT_STATE_PUBLISHER
        if joint.type == "planar" and (ours or has_urdf):
            message = f'joint "{joint.name}" is planar, which robot_state_publisher takes for fixed'
            if not ours:
                turns = [edge.publisher for edge in case.robot.turns.get(joint.name, ())] or [joint.publisher]
                owners = dict.fromkeys(publisher.name for publisher in turns if publisher.name)
                beside = f"beside {listed(owners)}" if owners else "though nobody is to"
                message += f': it publishes the transform into "{joint.child}" from the URDF, {beside}'
            yield case.problem("planar-taken-as-fixed", message, case.publisher(joint))


@rule("bad-node-name", "ROS 2 refuses the name of a node.", "Use letters, digits, underscores; no digit first.", FRAMES)
@rule("duplicate-node", "Two nodes have one name.", "Give each static_transform_publisher its own name.", FRAMES)
def node_names(case: Case) -> Iterator[Diagnostic]:
    """Names of nodes that ROS 2 refuses, and two nodes with one name."""
    taken: dict[str, Path] = {ROBOT_STATE_PUBLISHER: ()}
    for key, entry in case.section("publishers").items():
        taken.setdefault((entry or {}).get("node", key), ("publishers", key))
    for _, publisher, path in _static_publishers(case):
        name, place = publisher.name, (*path, STATIC_TRANSFORM_PUBLISHER)
        if not (name.isascii() and name.isidentifier()):
            yield case.problem("bad-node-name", f'"{name}" cannot be the name of a node in ROS 2', place)
        if name in taken:
            related = [("first named here", taken[name])] if taken[name] else []
            message = f'two nodes would have the name "{name}"'
            yield case.problem("duplicate-node", message, place, related=related)
        taken.setdefault(name, place)

"""Who publishes: one publisher for each frame in every combination of modes, and each of them is started."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rosorin_compile.language.requested_outputs import is_listed
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Publisher
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, JOINTS, Check, rule
from rosorin_compile.source.tree import Map, Path, Seq, at, exists
from rosorin_compile.source.wording import first_of, listed, quoted

from . import conditions
from .case import Case, first_fed
from .kinematics import children


class Claim(NamedTuple):
    """Somebody who publishes the transform into a frame: its name, the place that says so, when and in which parent.

    ``joint`` is the name of the joint whose publisher it is; ``silent`` is the turn of a joint that nobody publishes.
    """

    owner: str
    path: Path
    parent: str
    when: str = ""
    when_path: Path = ()
    joint: str = ""
    silent: bool = False


def claims(case: Case) -> dict[str, list[Claim]]:
    """Return who publishes the transform into each frame that an edge leads to, in the order of the description.

    Into another frame only a joint leads, and nobody else can publish that.

    Of a link with two parents only the first is taken: that is the cause, whoever publishes. Edges with a condition
    that means nothing are left out.
    """
    by_child: dict[str, list[Claim]] = {}
    led_to = {edge.child for edge in case.robot.edges}
    for child, joints in children(case.robot).items() if led_to else ():
        joint = joints[0]
        if child in led_to and joint.publisher.kind != UNPUBLISHED:
            owner = f'{owner_of(joint.publisher)} (joint "{joint.name}")'
            path = turn_of_urdf(case, joint) or case.end(joint, "child")
            by_child[child] = [Claim(owner, path, joint.parent, joint=joint.name)]
    for index, edge in sorted(enumerate(case.robot.edges), key=lambda item: not item[1].joint):
        silent = edge.publisher.kind == UNPUBLISHED
        if (silent and not edge.joint) or not conditions.is_legal(case, edge):
            continue
        owner = owner_of(edge.publisher) + (f' (joint "{edge.joint}")' if edge.joint else "")
        path, when_path = case.edge(index, "child"), case.edge(index, "when")
        claim = Claim(owner, path, edge.parent, edge.when, when_path, edge.joint, silent)
        by_child.setdefault(edge.child, []).append(claim)
    return by_child


def owner_of(publisher: Publisher) -> str:
    """Return a publisher in words."""
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f'static_transform_publisher "{publisher.name}"'
    return publisher.name or "nobody"


def turn_of_urdf(case: Case, joint: Joint) -> Path | None:
    """Return the place of robot_state_publisher in a list of publishers; None if there is no such list."""
    path = case.joint(joint)
    entry = at(case.tree, path)
    if path[-1] != "optical" and isinstance(entry, Map) and not isinstance(entry.get("publisher"), Seq):
        return None  # as of nearly all; a sensor speaks for both of its frames
    path = case.publisher(joint)
    if path[-1] != "publisher":
        return None
    value = at(case.tree, path)
    turns = value if isinstance(value, Seq) else ()
    return next(((*path, i, "by") for i, turn in enumerate(turns) if turn["by"] == ROBOT_STATE_PUBLISHER), None)


def _lists_publishers(tree: Map) -> bool:
    """Say whether a joint, or a sensor that mounts one, has a list of publishers, which few robots have."""
    entries = [entry for section in ("joints", "sensors") for entry in (tree.get(section) or {}).values()]
    entries += [entry.get("optical") for entry in (tree.get("sensors") or {}).values() if isinstance(entry, Map)]
    return any(isinstance(entry, Map) and isinstance(entry.get("publisher"), Seq) for entry in entries)


@rule(
    "two-publishers",
    "Two publishers own one frame at the same time.",
    "Remove one, or give them conditions that exclude each other. Where one is robot_state_publisher, which has no "
    "conditions: an argument of the build.",
    FRAMES,
)
@rule(
    "unpublished-edge",
    "Nobody publishes an edge, or no artifact starts or feeds its publisher. As a warning: nobody does in some mode.",
    "Name a publisher, add the output, widen the condition.",
    FRAMES,
)
def one_publisher(case: Case) -> Iterator[Diagnostic]:
    """Frames that have two publishers at once, and frames that have none in some combination of modes."""
    edges = case.robot.edges
    bare = {edge.child for edge in edges if edge.publisher.kind == UNPUBLISHED and not edge.joint}
    bare |= {edge.child for edge in edges if not conditions.is_legal(case, edge)}
    for child, claimed in claims(case).items():
        modes = conditions.modes_in(case.robot, [claim.when for claim in claimed])
        if len(modes) > conditions.MAX_MODES:
            yield conditions.too_many(case, child, claimed[-1].path, len(modes))
            continue
        gap: conditions.Combination | None = None
        for combination in conditions.combinations(modes):
            active = [claim for claim in claimed if conditions.holds(claim.when, combination)]
            clashing = _clashing(active)
            if clashing:
                yield _two(case, child, clashing, combination)
                break
            if not active and gap is None:
                gap = combination
        else:
            if gap is not None and child not in bare:
                yield _gap(case, child, claimed, gap)


def _clashing(active: list[Claim]) -> list[Claim]:
    """Return the claims that cannot be true at once; a joint that nobody publishes may be published by an edge."""
    owners = [claim for claim in active if not claim.silent]
    if len(owners) > 1:
        return owners
    joints = {claim.joint for claim in owners if claim.joint}
    silent = [claim for claim in active if claim.silent and claim.joint in joints]
    return [*silent, *owners] if silent else []


def _two(case: Case, child: str, active: list[Claim], combination: conditions.Combination) -> Diagnostic:
    owners = list(dict.fromkeys(claim.owner for claim in active))
    parents = list(dict.fromkeys(claim.parent for claim in active))
    below = f", below {quoted(parents)}" if len(parents) > 1 else ""
    if len(owners) == 1:
        who = f'{owners[0]} publishes the transform into "{child}" {"twice" if len(active) == 2 else "many times"}'
    else:
        who = f'{"both " if len(owners) == 2 else ""}{listed(owners)} publish the transform into "{child}"'
    if active[0].silent:
        who = f'{active[-1].owner} and nobody are both to publish the transform into "{child}"'
    message = f"{who}{below}{conditions.in_words(combination)}"
    related = [
        case.related("nobody, it says here" if claim.silent else f"also published here, by {claim.owner}", claim.path)
        for claim in active[:-1]
    ]
    return case.problem("two-publishers", message, active[-1].path, _way_out(case, active, parents), related=related)


def _way_out(case: Case, active: list[Claim], parents: list[str]) -> str:
    """Return what to do about several publishers of one frame."""
    joint = case.robot.joint.get(active[0].joint)
    if joint is not None and joint.publisher.kind == ROBOT_STATE_PUBLISHER:
        if turn_of_urdf(case, joint):
            return (
                "robot_state_publisher publishes every joint of its URDF in every mode: choose the publisher"
                ' by an argument of the build instead, publisher: "${publisher}"'
            )
        if len(parents) > 1:
            return (
                "a frame has one parent and one publisher at a time: remove one, or keep the joint for programs that"
                f' read the description, with publisher: {{none: WHY}} in "{joint.name}"'
            )
    return "a frame has one publisher at a time: remove one, or give the edges conditions that exclude each other"


def _gap(case: Case, child: str, claimed: list[Claim], combination: conditions.Combination) -> Diagnostic:
    message = f'nobody publishes the transform into "{child}"{conditions.in_words(combination)}'
    what = "an entry" if claimed[0].joint else "an edge"
    first, *others = claimed
    related = [case.related(f"published here when {other.when}, by {other.owner}", other.path) for other in others]
    help = f"add {what} for that case, or widen the condition"
    return case.problem("unpublished-edge", message, first.when_path, help, related=related, severity=WARNING)


@Check
def urdf_always(case: Case) -> Iterator[Diagnostic]:
    """Conditions of robot_state_publisher, which publishes all of its URDF in every mode."""
    claimed = claims(case)
    for joint in case.robot.published_by(ROBOT_STATE_PUBLISHER) if _lists_publishers(case.tree) else ():
        place = turn_of_urdf(case, joint)
        when = at(case.tree, (*place[:-1], "when")) if place else None
        # With another one the frame has two publishers, which is said.
        if place and when and len(claimed.get(joint.child, ())) < 2:
            message = f'robot_state_publisher publishes joint "{joint.name}" in every mode, not only when {when}'
            help = 'leave the condition out, or choose by an argument of the build: publisher: "${publisher}"'
            yield case.problem("bad-condition", message, (*place[:-1], "when"), help)


@Check
def some_publisher(case: Case) -> Iterator[Diagnostic]:
    """Edges without a publisher: they would stand in no artifact and nobody would own them."""
    names = [publisher.name for publisher in case.robot.publishers]
    for index, edge in enumerate(case.robot.edges):
        if edge.publisher.kind == UNPUBLISHED and not edge.joint:
            message = f"nobody publishes the edge {edge.parent} -> {edge.child}"
            help = (
                f"add publisher: NAME, one of {', '.join(names)}"
                if names
                else "declare a node in publishers and name it: publisher: NAME"
            )
            yield case.problem("unpublished-edge", message, ("edges", index, "child"), help)


@rule(
    "static-tf-moves",
    "A joint that moves has a static_transform_publisher.",
    "Leave it to robot_state_publisher.",
    FRAMES,
)
def started(case: Case) -> Iterator[Diagnostic]:
    """Joints whose publisher no artifact starts or feeds, and moving joints with a publisher for what stands still.

    An output of no known format may be the one that is missing: that is told alone.
    """
    robot = case.robot
    launched = bool(case.feeding(STATIC_TRANSFORM_PUBLISHER))
    statics = list(static_publishers(case))
    for joint, _, path in statics:
        if not joint.is_fixed:
            message = f'joint "{joint.name}" is {joint.type}, but a static_transform_publisher says what never moves'
            help = "let robot_state_publisher publish it"
            yield case.problem("static-tf-moves", message, path, help)
    if any(output.backend not in case.formats for output in robot.outputs) or not _lists_outputs(case):
        return
    for kind, is_there in (
        (STATIC_TRANSFORM_PUBLISHER, launched),
        (ROBOT_STATE_PUBLISHER, first_fed(robot, ROBOT_STATE_PUBLISHER, case.formats) is not None),
    ):
        if is_there:
            continue
        joints = robot.published_by(kind)
        if kind == STATIC_TRANSFORM_PUBLISHER:
            joints = tuple(joint for joint, _, _ in statics)
        explicit = [joint for joint in joints if exists(case.tree, case.joint(joint, "publisher"))]
        if not (explicit or (launched and joints)):
            continue
        what = "launch file that starts it" if kind == STATIC_TRANSFORM_PUBLISHER else "URDF that it reads"
        names = first_of([joint.name for joint in joints], 3)
        count = "one joint" if len(joints) == 1 else f"{len(joints)} joints"
        message = f"{kind} is to publish {count} ({names}), but no output is the {what}"
        one = next(one for one in case.formats.values() if one.write is not None and kind in one.feeds)
        help = f"add {one.name}: {{file: {one.file.format(robot.name)}}} to outputs"
        yield case.problem("unpublished-edge", message, ("outputs",), help, key=True)


def _lists_outputs(case: Case) -> bool:
    """Say whether a description lists what is to be made; one that somebody asks for alone says nothing of others."""
    return any(is_listed(entry) for entry in (case.tree.get("outputs") or {}).values())


def static_publishers(case: Case) -> Iterator[tuple[Joint, Publisher, Path]]:
    """Yield the joints that a static_transform_publisher publishes, always or in its turn, with where that is said."""
    robot = case.robot
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        yield joint, joint.publisher, case.publisher(joint)
    for index, edge in enumerate(robot.edges):
        if edge.joint and edge.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            yield robot.joint[edge.joint], edge.publisher, case.edge(index, "publisher")


@rule(
    "planar-taken-as-fixed",
    "A warning: a planar joint is in the URDF, and robot_state_publisher takes it for a fixed one, whoever else "
    "publishes it.",
    "Make it `type: floating`, which robot_state_publisher leaves alone, with `publisher: NODE` or `{none: WHY}`.",
    JOINTS,
)
def planar(case: Case) -> Iterator[Diagnostic]:
    """Planar joints in the URDF: robot_state_publisher publishes each as a fixed one, whoever else does.

    ros/kdl_parser takes an unknown type for fixed, and robot_state_publisher sends it as static; floating it skips.
    """
    robot = case.robot
    has_urdf = bool(case.feeding(ROBOT_STATE_PUBLISHER))
    for joint in robot.joints:
        ours = joint.publisher.kind == ROBOT_STATE_PUBLISHER
        if joint.type != "planar" or not (ours or has_urdf):
            continue
        message = f'joint "{joint.name}" is planar, which robot_state_publisher takes for fixed'
        if not ours:
            turns = [edge.publisher for edge in robot.turns.get(joint.name, ())] or [joint.publisher]
            owners = dict.fromkeys(publisher.name for publisher in turns if publisher.name)
            beside = f"beside {listed(owners)}" if owners else "though nobody is to"
            message += f': it publishes the transform into "{joint.child}" from the URDF, {beside}'
        help = (
            "robot_state_publisher leaves floating joints alone: say type: floating, and publisher: NODE or {none: WHY}"
        )
        yield case.problem("planar-taken-as-fixed", message, case.publisher(joint), help, severity=WARNING)


@rule(
    "bad-node-name",
    "A node has a name that ROS 2 refuses.",
    "Letters, digits and underscores, no digit first.",
    FRAMES,
)
@rule("duplicate-node", "Two nodes have one name.", "Give each a name of its own.", FRAMES)
def node_names(case: Case) -> Iterator[Diagnostic]:
    """Names of nodes that ROS 2 refuses, and two nodes with one name."""
    taken: dict[str, Path | None] = {ROBOT_STATE_PUBLISHER: None}
    for key, entry in (case.tree.get("publishers") or {}).items():
        taken.setdefault((entry or {}).get("node", key), ("publishers", key))
    for _, publisher, path in static_publishers(case):
        name, place = publisher.name, (*path, STATIC_TRANSFORM_PUBLISHER)
        if not (name.isascii() and name.isidentifier()):
            help = "use letters, digits and underscores, and begin with no digit"
            yield case.problem("bad-node-name", f'"{name}" cannot be the name of a node in ROS 2', place, help)
        if name in taken:
            first = taken[name]
            related = [case.related("first named here", first, key=first[0] == "publishers")] if first else []
            message = f'two nodes would have the name "{name}"'
            help = "give each static_transform_publisher a name of its own"
            yield case.problem("duplicate-node", message, place, help, related=related)
        taken.setdefault(name, place)

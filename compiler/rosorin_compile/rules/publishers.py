"""Who publishes: one publisher for each frame in every combination of modes, and each of them is started."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from ..diagnostic import WARNING, Diagnostic
from ..model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, UNPUBLISHED, Edge, Joint, Publisher
from ..tree import Path
from . import conditions
from .case import Case, exists, listed
from .kinematics import children


class Claim(NamedTuple):
    """Somebody who publishes the transform into a frame: its name, the place that says so, when."""

    owner: str
    path: Path
    edge: Edge | None


def claims(case: Case) -> dict[str, list[Claim]]:
    """Return who publishes the transform into each frame, in the order of the description.

    Of a link with two parents only the first is taken: that is the cause, whoever publishes. Edges with a condition
    that means nothing are left out.
    """
    found: dict[str, list[Claim]] = {}
    for child, joints in children(case.robot).items():
        joint = joints[0]
        if joint.publisher.kind != UNPUBLISHED:
            owner = f'{owner_of(joint.publisher)} (joint "{joint.name}")'
            found[child] = [Claim(owner, case.end(joint, "child"), None)]
    for index, edge in enumerate(case.robot.edges):
        if edge.publisher.kind != UNPUBLISHED and conditions.is_legal(case, edge):
            claim = Claim(owner_of(edge.publisher), ("edges", index, "child"), edge)
            found.setdefault(edge.child, []).append(claim)
    return found


def owner_of(publisher: Publisher) -> str:
    """Return a publisher in words."""
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f'static_transform_publisher "{publisher.name}"'
    return publisher.name


def one_publisher(case: Case) -> Iterator[Diagnostic]:
    """Frames that have two publishers at once, and frames that have none in some combination of modes."""
    bare = {edge.child for edge in case.robot.edges if edge.publisher.kind == UNPUBLISHED}
    for child, claimed in claims(case).items():
        modes = conditions.modes_in(case, [claim.edge for claim in claimed if claim.edge])
        if len(modes) > conditions.MAX_MODES:
            yield conditions.too_many(case, child, claimed[-1].path, len(modes))
            continue
        gap: conditions.Combination | None = None
        for combination in conditions.combinations(modes):
            active = [claim for claim in claimed if _is_active(claim, combination)]
            if len(active) > 1:
                yield _two(case, child, active, combination)
                break
            if not active and gap is None:
                gap = combination
        else:
            if gap is not None and child not in bare:
                yield _gap(case, child, claimed[0], gap)


def _is_active(claim: Claim, combination: conditions.Combination) -> bool:
    return claim.edge is None or conditions.holds(claim.edge.when, combination)


def _two(case: Case, child: str, active: list[Claim], combination: conditions.Combination) -> Diagnostic:
    owners = list(dict.fromkeys(claim.owner for claim in active))
    if len(owners) == 1:
        who = f'{owners[0]} publishes the transform into "{child}" {"twice" if len(active) == 2 else "many times"}'
    else:
        who = f'{"both " if len(owners) == 2 else ""}{listed(owners)} publish the transform into "{child}"'
    message = f"{who}{conditions.in_words(combination)}"
    related = [case.related(f"also published here, by {claim.owner}", claim.path) for claim in active[:-1]]
    help = "a frame has one publisher at a time: remove one, or give the edges conditions that exclude each other"
    return case.problem("two-publishers", message, active[-1].path, help, related=related)


def _gap(case: Case, child: str, claim: Claim, combination: conditions.Combination) -> Diagnostic:
    message = f'nobody publishes the transform into "{child}"{conditions.in_words(combination)}'
    help = "add an edge for that case, or widen the condition"
    return case.problem("unpublished-edge", message, (*claim.path[:-1], "when"), help, severity=WARNING)


def some_publisher(case: Case) -> Iterator[Diagnostic]:
    """Edges without a publisher: they would stand in no artifact and nobody would own them."""
    names = [publisher.name for publisher in case.robot.publishers]
    for index, edge in enumerate(case.robot.edges):
        if edge.publisher.kind == UNPUBLISHED:
            message = f"nobody publishes the edge {edge.parent} -> {edge.child}"
            help = (
                f"add publisher: NAME, one of {', '.join(names)}"
                if names
                else "declare a node in publishers and name it: publisher: NAME"
            )
            yield case.problem("unpublished-edge", message, ("edges", index, "child"), help)


def started(case: Case) -> Iterator[Diagnostic]:
    """Joints whose publisher no artifact starts or feeds, and moving joints with a publisher for what stands still."""
    robot = case.robot
    backends = {output.backend for output in robot.outputs}
    launched = bool(backends & {"static_tf", "static_tf_json"})
    for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        if joint.moves:
            message = f'joint "{joint.name}" is {joint.type}, but a static_transform_publisher says what never moves'
            help = "let robot_state_publisher publish it"
            yield case.problem("static-tf-moves", message, case.publisher(joint), help)
    for kind, is_there, help in (
        (STATIC_TRANSFORM_PUBLISHER, launched, "add static_tf: {file: static_tf.launch.py} to outputs"),
        (ROBOT_STATE_PUBLISHER, _has_urdf(case), f"add urdf: {{file: {robot.name}.urdf}} to outputs"),
    ):
        joints = robot.published_by(kind)
        said = [joint for joint in joints if exists(case.tree, case.joint(joint, "publisher"))]
        if not backends or is_there or not (said or (launched and joints)):
            continue
        what = "launch file that starts it" if kind == STATIC_TRANSFORM_PUBLISHER else "URDF that it reads"
        count = "one joint" if len(joints) == 1 else f"{len(joints)} joints"
        message = f"{kind} is to publish {count} ({_some(joints)}), but no output is the {what}"
        yield case.problem("unpublished-edge", message, ("outputs",), help, key=True)


def _has_urdf(case: Case) -> bool:
    """Say whether an output is a URDF: by its backend, or a template of the user's own by the name of its file."""
    return any(output.backend == "urdf" or output.file.endswith(".urdf") for output in case.robot.outputs)


def _some(joints: tuple[Joint, ...]) -> str:
    names = [joint.name for joint in joints]
    return ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")


def node_names(case: Case) -> Iterator[Diagnostic]:
    """Names of nodes that ROS 2 refuses, and two nodes with one name."""
    taken: dict[str, Path | None] = {ROBOT_STATE_PUBLISHER: None}
    for key, entry in (case.tree.get("publishers") or {}).items():
        taken.setdefault((entry or {}).get("node", key), ("publishers", key))
    for joint in case.robot.published_by(STATIC_TRANSFORM_PUBLISHER):
        name, at = joint.publisher.name, (*case.publisher(joint), STATIC_TRANSFORM_PUBLISHER)
        if not (name.isascii() and name.isidentifier()):
            help = "use letters, digits and underscores, and begin with no digit"
            yield case.problem("bad-node-name", f'"{name}" cannot be the name of a node in ROS 2', at, help)
        if name in taken:
            first = taken[name]
            related = [case.related("first named here", first, key=first[0] == "publishers")] if first else []
            message = f'two nodes would have the name "{name}"'
            help = "give each static_transform_publisher a name of its own"
            yield case.problem("duplicate-node", message, at, help, related=related)
        taken.setdefault(name, at)

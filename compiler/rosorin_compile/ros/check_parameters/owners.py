"""Who publishes which edge: what the nodes of the files publish, held against the publishers of the description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from rosorin_compile.model import Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, error
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Path

from .nodes import Node, Setting
from .remaps import Remap, is_tf, topic
from .values import world_problem

RULES = (
    Rule(
        "parameters-two-owners",
        "A node publishes an edge that belongs to another one, so the frame jumps between the two.",
        "Switch one of them off, as the message says; or say in the description who owns the edge, and in which mode.",
        Heading.PARAMETERS,
    ),
    Rule(
        "parameters-no-owner",
        "The node that owns an edge by the description does not publish it.",
        "Switch it on, remap its topic to /tf, or name the real owner in the description.",
        Heading.PARAMETERS,
    ),
    Rule(
        "parameters-other-edge",
        "A node publishes an edge that the description does not have: it has another parent, or another child. A "
        "warning where no node of the description publishes that frame.",
        "Correct the frames of the node, or add the edge to `edges`.",
        Heading.PARAMETERS,
    ),
)


@dataclass(frozen=True)
class Claim:
    """A transform that a node publishes, or would: ``silent`` says why it does not reach tf, empty if it does.

    ``deciding`` is what decides it, ``way_out`` how it would be published, ``off`` how it would not be; ``aside`` how
    the node would publish the edge above it instead.
    """

    node: Node
    parent: Setting
    child: Setting
    deciding: Setting
    because: str
    silent: str = ""
    way_out: str = ""
    off: str = ""
    aside: str = ""

    @property
    def edge(self) -> str:
        """The edge in words."""
        return f"{self.parent.value} -> {self.child.value}"


class Declared(NamedTuple):
    """A transform of the description: its ends, who publishes it, where that is said, and in which modes."""

    parent: str
    child: str
    publisher: Publisher
    path: Path
    when: str
    who: str


def claims(nodes: Iterable[Node], remaps: Sequence[Remap], told: list[Diagnostic]) -> list[Claim]:
    """Return what the nodes publish; what keeps one of them from it altogether is added to ``told``."""
    found: list[Claim] = []
    for node in nodes:
        if node.kind is None:
            continue
        claim = _of_filter(node, told) if node.kind.name == "ekf" else _of_keys(node)
        if claim is not None:
            found.append(_on_topic(claim, remaps))
    return found


def _of_keys(node: Node) -> Claim | None:
    """Return the transform that a node publishes whose keys name its ends and its switch."""
    names = node.kind.transform if node.kind else {}
    if not names:
        return None
    parent, child = _frame(node, names["parent"]), _frame(node, names["child"])
    if child.value == "" and "else" in names:
        child = _frame(node, names["else"])
    switch = node.setting(names["switch"])
    if not parent.value or not child.value or switch.value is None:
        return None
    key = names["switch"]
    on = "0.05" if isinstance(switch.value, float) else "true"
    off = "0.0" if isinstance(switch.value, float) else "false"
    shown = str(switch.value).lower()
    silent = "" if switch.value else f'"{key}" is {shown}{switch.how}'
    return Claim(
        *(node, parent, child, switch, f'"{key}" is {shown}{switch.how}', silent),
        *(f"{key}: {on}", f"{key}: {off}"),
    )


def _frame(node: Node, key: str) -> Setting:
    """Return the name of a frame as a node writes it to tf: with its prefix, without what it strips."""
    setting = node.setting(key)
    if not isinstance(setting.value, str):
        return setting._replace(value=None)
    return setting._replace(value=prefix(node) + setting.value.removeprefix("/"))


def prefix(node: Node) -> str:
    """Return what a controller writes before its frames: its tf_frame_prefix, or its namespace."""
    if node.kind is None or "tf_frame_prefix" not in node.kind or not node.setting("tf_frame_prefix_enable").value:
        return ""
    text = str(node.setting("tf_frame_prefix").value or node.namespace).strip("/")
    return f"{text}/" if text else ""


def _of_filter(node: Node, told: list[Diagnostic]) -> Claim | None:
    """Return the transform of a filter of robot_localization: which one depends on ``world_frame``."""
    odom, map_ = _frame(node, "odom_frame"), _frame(node, "map_frame")
    base = _frame(node, "base_link_frame")
    output = _frame(node, "base_link_frame_output")
    base = base if output.value is None else output
    world = node.setting("world_frame", odom.value)
    if None in (odom.value, map_.value, base.value, world.value) or (output.given and output.value is None):
        return None  # a launch file says it
    wrong = world_problem(node, (str(odom.value), str(map_.value)))
    if wrong is not None:
        told.append(wrong)
        return None
    tf = node.setting("publish_tf")
    if tf.value is None:
        return None
    silent = "" if tf.value else f'"publish_tf" is false{tf.how}'
    in_map = world.value == map_.value and map_.value != odom.value
    ends = (map_, odom) if in_map else (odom, base)
    because = f'"publish_tf" is {str(tf.value).lower()}{tf.how}, "world_frame" is "{world.value}"{world.how}'
    aside = "" if in_map else f"world_frame: {map_.value}"
    deciding = tf if tf.given else world
    return Claim(node, *ends, deciding, because, silent, "publish_tf: true", "publish_tf: false", aside)


def _on_topic(claim: Claim, remaps: Sequence[Remap]) -> Claim:
    """Return a claim with why it does not reach tf, if its topic is another one."""
    node = claim.node
    name = node.kind.odometry if node.kind and node.kind.odometry else "/tf"
    full = topic(name, node.namespace, node.name, remaps)
    if claim.silent or is_tf(full, node.namespace):
        return claim
    way_out = f"remap {full} to /tf: --remap {node.name}:{name}:=/tf, if the launch file does"
    if name == "/tf":
        return replace(claim, silent=f"its /tf is remapped to {full}", way_out="remove that remap")
    return replace(claim, silent=f"publishes on {full}, which nothing remaps to /tf", way_out=way_out)


def declared(case: Case) -> list[Declared]:
    """Return the transforms of the description that somebody publishes, joints first."""
    found = []
    for joint in case.robot.joints:
        if joint.publisher.publishes:
            who = f'{joint.publisher.name} (joint "{joint.name}")'
            path = case.end(joint, "child")
            found.append(Declared(joint.parent, joint.child, joint.publisher, path, "", who))
    for index, edge in enumerate(case.robot.edges):
        if edge.publisher.publishes:
            path = case.edge(index, "child")
            found.append(Declared(edge.parent, edge.child, edge.publisher, path, edge.when, edge.publisher.name))
    return found


def check(case: Case, found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Yield where what nodes publish is not what the description says."""
    every = declared(case)
    publishers = case.robot.publishers
    explained: set[str] = set()
    for claim in found:
        if claim.silent:
            continue
        into = [one for one in every if one.child == claim.child.value]
        mine = [one for one in into if claim.node.is_of(one.publisher, publishers)]
        if mine and any(one.parent == claim.parent.value for one in mine):
            yield from _twice(case, claim, found, mine)
        elif mine:
            explained.add(claim.node.full)
            yield _other_parent(case, claim, mine)
        elif into and _meant(claim, every, publishers):
            explained.add(claim.node.full)
            yield from _other_child(case, claim, every)
        elif into:
            yield _not_its_own(case, claim, into, found, publishers)
        else:
            explained.add(claim.node.full)
            yield from _other_child(case, claim, every)
            yield from _both(claim, found)
    for one in every:
        silent = [claim for claim in found if claim.node.is_of(one.publisher, publishers)]
        told = any(claim.node.full in explained for claim in silent)
        speaking = [claim for claim in silent if not claim.silent and claim.child.value == one.child]
        if silent and not speaking and not told and _could_be(one, silent):
            yield _nobody(case, one, silent[0])


def _meant(claim: Claim, every: Sequence[Declared], publishers: Sequence[Publisher]) -> bool:
    """Say whether a node owns an edge that begins where the one does that it publishes."""
    return any(one.parent == claim.parent.value and claim.node.is_of(one.publisher, publishers) for one in every)


def _both(claim: Claim, found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Yield that another node publishes a frame too that the description knows nobody for."""
    before = found[: [one is claim for one in found].index(True)]
    other = next((one for one in before if not one.silent and one.child.value == claim.child.value), None)
    if other is not None:
        message = f"{other.node.shown} and {claim.node.shown} both publish {claim.edge}: {claim.because}"
        related = [Related(f"{other.node.shown} publishes it here: {other.because}", other.deciding.span)]
        help = f"an edge has one publisher: {other.off} in the one, or {claim.off} in the other"
        yield error("parameters-two-owners", message, claim.deciding.span, help, related)


def _could_be(one: Declared, silent: Sequence[Claim]) -> bool:
    """Say whether an edge is one that a node would publish: a node that owns others too is not asked for all."""
    return any(claim.child.value == one.child or claim.parent.value == one.parent for claim in silent)


def _twice(case: Case, claim: Claim, found: Sequence[Claim], mine: Sequence[Declared]) -> Iterator[Diagnostic]:
    """Yield that another node is the same publisher, and publishes the same."""
    before = found[: [one is claim for one in found].index(True)]
    for other in before:
        if other.silent or other.child.value != claim.child.value:
            continue
        theirs = [one for one in mine if other.node.is_of(one.publisher, case.robot.publishers)]
        if theirs:
            message = f"{other.node.shown} and {claim.node.shown} both publish {claim.edge}: {claim.because}"
            related = [
                Related(f"{other.node.shown} publishes it here: {other.because}", other.deciding.span),
                case.related(f"one publisher by the description, {theirs[0].who}", theirs[0].path),
            ]
            help = f"an edge has one publisher: {claim.off} in one of them"
            yield error("parameters-two-owners", message, claim.deciding.span, help, related)


def _other_parent(case: Case, claim: Claim, mine: Sequence[Declared]) -> Diagnostic:
    one = mine[0]
    message = f"{claim.node.shown} publishes {claim.edge}, and by the description it is {one.parent} -> {one.child}"
    related = [case.related(f"described here, of {one.who}", one.path)]
    help = f'name the frame "{one.parent}", or correct the edge'
    return error("parameters-other-edge", message, claim.parent.span, help, related)


def _not_its_own(
    case: Case, claim: Claim, into: Sequence[Declared], found: Sequence[Claim], publishers: Sequence[Publisher]
) -> Diagnostic:
    """Return that a node publishes an edge of another one."""
    one = into[0]
    message = (
        f"{claim.node.shown} publishes {claim.edge} ({claim.because}),"
        f" and by the description {one.parent} -> {one.child} is of {one.who}"
    )
    related = [case.related(f"{other.parent} -> {other.child} is of {other.who} here", other.path) for other in into]
    for other in found:
        if other.node is not claim.node and any(other.node.is_of(o.publisher, publishers) for o in into):
            says = f"{other.silent}" if other.silent else other.because
            related.append(Related(f"{other.node.shown}: {says}", other.deciding.span))
    help = claim.off
    above = [other for other in declared(case) if other.child == claim.parent.value]
    if claim.aside and any(claim.node.is_of(other.publisher, publishers) for other in above):
        help = claim.aside
    elif one.publisher.kind == NODE and claim.node.name != one.publisher.name:
        help += f"; if it is to own the edge, name it in the description: publisher: {claim.node.name}"
    return error("parameters-two-owners", message, claim.deciding.span, help, related)


def _other_child(case: Case, claim: Claim, every: Sequence[Declared]) -> Iterator[Diagnostic]:
    """Yield a problem where a node publishes a frame that the description gives to no publisher."""
    publishers = case.robot.publishers
    mine = [one for one in every if claim.node.is_of(one.publisher, publishers)]
    near = [one for one in mine if one.parent == claim.parent.value] or mine
    if near:
        one = near[0]
        said = f"{claim.edge}{claim.child.how}"
        message = f"{claim.node.shown} publishes {said}, and by the description it is {one.parent} -> {one.child}"
        related = [case.related(f"described here, of {one.who}", one.path)]
        help = _prefixed(claim) or f'name the frame "{one.child}", or correct the edge'
        yield error("parameters-other-edge", message, claim.child.span, help, related)
        return
    message = f"{claim.node.shown} publishes {claim.edge}, an edge that the description does not have"
    help = _prefixed(claim) or (
        f"{claim.off}, or add it to edges:"
        f" {{parent: {claim.parent.value}, child: {claim.child.value}, publisher: {claim.node.name}}}"
    )
    yield Diagnostic("parameters-other-edge", WARNING, message, claim.deciding.span, help=help)


def _prefixed(claim: Claim) -> str:
    """Return the fix for a controller that writes its namespace before its frames."""
    own = prefix(claim.node)
    if not own:
        return ""
    whose = "tf_frame_prefix" if claim.node.setting("tf_frame_prefix").value else "namespace"
    return f"the controller writes its {whose} before its frames; tf_frame_prefix_enable: false leaves them as they are"


def _nobody(case: Case, one: Declared, claim: Claim) -> Diagnostic:
    """Return that the node that owns an edge does not publish it."""
    why = claim.silent or f"it publishes {claim.edge}"
    when = f" when {one.when}" if one.when else ""
    message = f"no node publishes {one.parent} -> {one.child}{when}: {claim.node.shown} owns it, and {why}"
    related = [case.related(f"{one.who} owns it here", one.path)]
    help = claim.way_out if claim.silent else "correct its frames, or the edge"
    return error("parameters-no-owner", message, claim.deciding.span, help, related)

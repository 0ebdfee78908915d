"""Who publishes which edge: what the nodes of the files publish, compared with the publishers of the description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from rosorin_compile.model import Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, error
from rosorin_compile.source.tree import Path

from .nodes import Node, Setting
from .remaps import Remap, is_tf, topic
from .values import world_problem


@dataclass(frozen=True)
class Claim:
    """A transform that a node publishes, or would: ``silent`` is why it does not reach tf, empty if it does.

    ``deciding`` is the parameter that decides, ``because`` its value in words, ``way_out`` how the transform would be
    published, ``off`` how it would not be, ``aside`` how the node would publish the edge above it instead.
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

    def related(self) -> Related:
        """Return the place that makes the node publish it."""
        return Related(f"{self.node.shown} publishes it here: {self.because}", self.deciding.span)


@dataclass(frozen=True)
class Declared:
    """A transform of the description: its ends, its publisher with its name in messages, its place and mode."""

    parent: str
    child: str
    publisher: Publisher
    path: Path
    when: str
    who: str

    @property
    def edge(self) -> str:
        """The edge in words."""
        return f"{self.parent} -> {self.child}"


def claims(nodes: Iterable[Node], remaps: Sequence[Remap], told: list[Diagnostic]) -> list[Claim]:
    """Return what the nodes publish; what keeps one of them from it altogether is added to ``told``."""
    found: list[Claim] = []
    for node in nodes:
        if node.kind is not None:
            claim = _of_filter(node, told) if node.kind.name == "ekf" else _of_keys(node)
            found += [_on_topic(claim, remaps)] if claim is not None else []
    return found


def _of_keys(node: Node) -> Claim | None:
    """Return the transform of a node whose parameters name its ends and its switch."""
    names = node.kind.transform if node.kind else {}
    if not names:
        return None
    parent, child = _frame(node, names["parent"]), _frame(node, names["child"])
    if child.value == "" and "else" in names:
        child = _frame(node, names["else"])
    key = names["switch"]
    switch = node.setting(key)
    if not parent.value or not child.value or switch.value is None:
        return None
    on, off = ("0.05", "0.0") if isinstance(switch.value, float) else ("true", "false")
    because = f'"{key}" is {str(switch.value).lower()}{switch.how}'
    silent = "" if switch.value else because
    return Claim(node, parent, child, switch, because, silent, f"{key}: {on}", f"{key}: {off}")


def _frame(node: Node, key: str) -> Setting:
    """Return the name of a frame as a node writes it to tf: with its prefix, without a leading slash."""
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
    keys = ("odom_frame", "map_frame", "base_link_frame", "base_link_frame_output")
    odom, map_, base, output = (_frame(node, key) for key in keys)
    base = base if output.value is None else output
    world, tf = node.setting("world_frame", odom.value), node.setting("publish_tf")
    if None in (odom.value, map_.value, base.value, world.value) or (output.given and output.value is None):
        return None  # a launch file sets it
    wrong = world_problem(node, (str(odom.value), str(map_.value)))
    if wrong is not None or tf.value is None:
        told += [wrong] if wrong is not None else []
        return None
    silent = "" if tf.value else f'"publish_tf" is false{tf.how}'
    in_map = world.value == map_.value and map_.value != odom.value
    ends = (map_, odom) if in_map else (odom, base)
    because = f'"publish_tf" is {str(tf.value).lower()}{tf.how}, "world_frame" is "{world.value}"{world.how}'
    aside, deciding = "" if in_map else f"world_frame: {map_.value}", tf if tf.given else world
    return Claim(node, *ends, deciding, because, silent, "publish_tf: true", "publish_tf: false", aside)


def _on_topic(claim: Claim, remaps: Sequence[Remap]) -> Claim:
    node = claim.node
    name = node.kind.odometry if node.kind and node.kind.odometry else "/tf"
    full = topic(name, node.namespace, node.name, remaps)
    if claim.silent or is_tf(full, node.namespace):
        return claim
    if name == "/tf":
        return replace(claim, silent=f"its /tf is remapped to {full}", way_out="remove that remap")
    way_out = f"remap {full} to /tf: --remap {node.name}:{name}:=/tf, if the launch file does"
    return replace(claim, silent=f"publishes on {full}, which nothing remaps to /tf", way_out=way_out)


def _declared(case: Case) -> list[Declared]:
    """Return the transforms of the description that are published, joints first."""
    found = []
    for joint in case.robot.joints:
        who = f'{joint.publisher.name} (joint "{joint.name}")'
        found.append(Declared(joint.parent, joint.child, joint.publisher, case.end(joint, "child"), "", who))
    for index, edge in enumerate(case.robot.edges):
        path, who = case.edge(index, "child"), edge.publisher.name
        found.append(Declared(edge.parent, edge.child, edge.publisher, path, edge.when, who))
    return [one for one in found if one.publisher.publishes]


def check(case: Case, found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Yield where what nodes publish is not what the description says."""
    every, publishers = _declared(case), case.robot.publishers
    explained: set[str] = set()
    for index, claim in enumerate(found):
        if claim.silent:
            continue
        into = [one for one in every if one.child == claim.child.value]
        mine = [one for one in into if claim.node.is_of(one.publisher, publishers)]
        same_child = [one for one in found[:index] if not one.silent and one.child.value == claim.child.value]
        if any(one.parent == claim.parent.value for one in mine):
            for other in same_child:
                theirs = [one for one in mine if other.node.is_of(one.publisher, publishers)]
                if theirs:
                    place = case.related(f"one publisher by the description, {theirs[0].who}", theirs[0].path)
                    yield _both(claim, other, f"{claim.off} in one of them", place)
            continue
        owns_parent = any(
            one.parent == claim.parent.value and claim.node.is_of(one.publisher, publishers) for one in every
        )
        if into and not mine and not owns_parent:
            yield _not_its_own(case, claim, into, found, every)
            continue
        explained.add(claim.node.full)
        if mine:
            message = f"{claim.node.shown} publishes {claim.edge}, and by the description it is {mine[0].edge}"
            help = f'name the frame "{mine[0].parent}", or correct the edge'
            related = [case.related(f"described here, of {mine[0].who}", mine[0].path)]
            yield error("parameters-other-edge", message, claim.parent.span, help, related)
        else:
            yield _other_child(case, claim, every)
            if not into and same_child:
                yield _both(claim, same_child[0], f"{same_child[0].off} in the one, or {claim.off} in the other")
    for one in every:
        silent = [claim for claim in found if claim.node.is_of(one.publisher, publishers)]
        told = any(claim.node.full in explained for claim in silent)
        speaking = any(not claim.silent and claim.child.value == one.child for claim in silent)
        # A node that owns other edges, too, is not expected to publish all of them.
        could = any(claim.child.value == one.child or claim.parent.value == one.parent for claim in silent)
        if could and not speaking and not told:
            why = silent[0].silent or f"it publishes {silent[0].edge}"
            when = f" when {one.when}" if one.when else ""
            message = f"no node publishes {one.edge}{when}: {silent[0].node.shown} owns it, and {why}"
            help = silent[0].way_out if silent[0].silent else "correct its frames, or the edge"
            related = [case.related(f"{one.who} owns it here", one.path)]
            yield error("parameters-no-owner", message, silent[0].deciding.span, help, related)


def _both(claim: Claim, other: Claim, way_out: str, *related: Related) -> Diagnostic:
    message = f"{other.node.shown} and {claim.node.shown} both publish {claim.edge}: {claim.because}"
    help = f"an edge has one publisher: {way_out}"
    return error("parameters-two-owners", message, claim.deciding.span, help, [other.related(), *related])


def _not_its_own(
    case: Case, claim: Claim, into: Sequence[Declared], found: Sequence[Claim], every: Sequence[Declared]
) -> Diagnostic:
    """Return that a node publishes an edge of another one."""
    one, publishers = into[0], case.robot.publishers
    message = f"{claim.node.shown} publishes {claim.edge} ({claim.because}), and by the description {one.edge} is of "
    related = [case.related(f"{other.edge} is of {other.who} here", other.path) for other in into]
    for other in found:
        if other.node is not claim.node and any(other.node.is_of(those.publisher, publishers) for those in into):
            related.append(Related(f"{other.node.shown}: {other.silent or other.because}", other.deciding.span))
    above = [other for other in every if other.child == claim.parent.value]
    help = claim.off
    if claim.aside and any(claim.node.is_of(other.publisher, publishers) for other in above):
        help = claim.aside
    elif one.publisher.kind == NODE and claim.node.name != one.publisher.name:
        help += f"; if it is to own the edge, name it in the description: publisher: {claim.node.name}"
    return error("parameters-two-owners", message + one.who, claim.deciding.span, help, related)


def _other_child(case: Case, claim: Claim, every: Sequence[Declared]) -> Diagnostic:
    """Return that a node publishes a frame that the description gives to no publisher."""
    mine = [one for one in every if claim.node.is_of(one.publisher, case.robot.publishers)]
    near = next((one for one in mine if one.parent == claim.parent.value), mine[0] if mine else None)
    help = ""
    if prefix(claim.node):
        whose = "tf_frame_prefix" if claim.node.setting("tf_frame_prefix").value else "namespace"
        help = f"the controller writes its {whose} before its frames; "
        help += "tf_frame_prefix_enable: false leaves them as they are"
    if near is not None:
        message = (
            f"{claim.node.shown} publishes {claim.edge}{claim.child.how}, and by the description it is {near.edge}"
        )
        related = [case.related(f"described here, of {near.who}", near.path)]
        help = help or f'name the frame "{near.child}", or correct the edge'
        return error("parameters-other-edge", message, claim.child.span, help, related)
    message = f"{claim.node.shown} publishes {claim.edge}, an edge that the description does not have"
    ends = f"parent: {claim.parent.value}, child: {claim.child.value}, publisher: {claim.node.name}"
    help = help or f"{claim.off}, or add it to edges: {{{ends}}}"
    return Diagnostic("parameters-other-edge", WARNING, message, claim.deciding.span, help=help)

"""Check the transforms in parameter files: the publisher of each edge, and the names of frames."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model.joint import NODE
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.joints import pieces
from rosorin_compile.rules.publishers import Step, all_steps, steps_in_modes
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Suggestion, error, quote

from ..launch_files import Remap
from ..node_kinds import Key, as_yaml
from .nodes import Node, Setting

BASE, ODOM, MAP, SENSOR = "base", "odom", "map", "sensor"


def remapped_topics(node: Node, remaps: Iterable[Remap]) -> dict[str, str]:
    """Map full names of topics of a node to their remapped names; the first remap of a topic wins."""
    mine = [one for one in remaps if one.node in ("", node.name)]
    return {node.topic(one.name): node.topic(one.to) for one in reversed(mine)}


class Claim(NamedTuple):
    """A transform that a node publishes or could publish; ``silent`` is why it does not reach /tf, else "".

    ``switch`` is the value of the parameter ``key`` that enables publishing; ``fix`` is the setting that enables it.
    """

    node: Node
    parent: Setting
    child: Setting
    key: str
    switch: Setting
    silent: str = ""
    fix: str = ""

    @property
    def edge(self) -> str:
        """The transform as text: ``odom -> base_link``."""
        return f"{self.parent.value} -> {self.child.value}"

    @property
    def because(self) -> str:
        """The value of the switch for messages: ``"publish_tf" is false by default``."""
        return f'"{self.key}" is {as_yaml(self.switch.value)}{self.switch.how}'

    @property
    def off(self) -> str:
        """The setting that disables the transform."""
        return f"{self.key}: {'0.0' if isinstance(self.switch.value, float) else 'false'}"


def claims(nodes: Iterable[Node], remaps: Sequence[Remap]) -> list[Claim]:
    """Return the transforms that nodes publish or could publish."""
    found = []
    for node in nodes:
        kind = node.kind
        claim = None if kind is None else _of_filter(node) if kind.name == "ekf" else _of_keys(node, kind.transform)
        if kind is None or claim is None:
            continue
        if not claim.switch.value:
            claim = claim._replace(silent=claim.because)
        name = kind.odometry or "/tf"
        full = remapped_topics(node, remaps).get(node.topic(name), node.topic(name))
        if not claim.silent and full not in ("/tf", node.topic("tf")):
            fix = f"remap {full} to /tf: --remap {node.name}:{name}:=/tf, if the launch file does"
            claim = claim._replace(silent=f"publishes on {full}, which nothing remaps to /tf", fix=fix)
        found.append(claim)
    return found


def _of_keys(node: Node, names: Mapping[str, str]) -> Claim | None:
    """Return the transform of a node with parameters for its parent, child and switch."""
    if not names:
        return None
    parent, child, switch = _frame(node, names["parent"]), _frame(node, names["child"]), node.setting(names["switch"])
    child = _frame(node, names["else"]) if child.value == "" and "else" in names else child
    fix = f"{names['switch']}: {'0.05' if isinstance(switch.value, float) else 'true'}"
    is_complete = parent.value and child.value and switch.value is not None
    return Claim(node, parent, child, names["switch"], switch, fix=fix) if is_complete else None


def _of_filter(node: Node) -> Claim | None:
    """Return the transform of a robot_localization filter, which depends on ``world_frame``."""
    keys = ("odom_frame", "map_frame", "base_link_frame", "base_link_frame_output")
    odom, map_, base, output = (_frame(node, key) for key in keys)
    base = output if output.given or output.value is not None else base
    world, tf = node.setting("world_frame", odom.value).value, node.setting("publish_tf")
    if None in (odom.value, map_.value, base.value, tf.value) or world not in (odom.value, map_.value):
        return None  # invalid, or set by a launch file
    ends = (map_, odom) if world == map_.value != odom.value else (odom, base)
    switch = tf if tf.given else tf._replace(span=node.setting("world_frame").span)
    return Claim(node, *ends, "publish_tf", switch, fix="publish_tf: true")


def _frame(node: Node, key: str) -> Setting:
    """Return the name of a frame as the node publishes it: with its prefix, without a leading slash."""
    setting = node.setting(key)
    if not isinstance(setting.value, str):
        return setting._replace(value=None)
    return setting._replace(value=_prefix(node) + setting.value.removeprefix("/"))


def _prefix(node: Node) -> str:
    """Return the prefix that a controller adds to its frames: its tf_frame_prefix or its namespace."""
    if node.kind is None or "tf_frame_prefix" not in node.kind or not node.setting("tf_frame_prefix_enable").value:
        return ""
    text = str(node.setting("tf_frame_prefix").value or node.namespace).strip("/")
    return f"{text}/" if text else ""


def check_edges(case: Case, found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Report published transforms that contradict the edges of the description, and edges that nobody publishes."""
    declared = [step for step in all_steps(case, legal=False) if step.publisher.publishes]
    publishers = case.robot.publishers
    speaking = [claim for claim in found if not claim.silent]
    explained: set[str] = set()
    for index, claim in enumerate(speaking):
        node, parent, child = claim.node, claim.parent.value, claim.child.value
        own = [one for one in declared if node.is_of(one.publisher, publishers)]
        into = [one for one in declared if one.child == child]
        mine = [one for one in own if one.child == child]
        rival = next((one for one in speaking[:index] if one.child.value == child), None)
        if any(one.parent == parent for one in mine):
            if rival is not None and any(rival.node.is_of(one.publisher, publishers) for one in mine):
                yield _both(claim, rival)
        elif into and not mine and not any(one.parent == parent for one in own):
            others = [one for one in found if one.node is not node]
            owners = [one for one in others if any(one.node.is_of(other.publisher, publishers) for other in into)]
            message = f"{node.shown} publishes {claim.edge} ({claim.because}), and by the description "
            message += f"{into[0].parent} -> {child} is of {into[0].owner}"
            related = [case.related(f"{one.parent} -> {one.child} is of {one.owner} here", one.path) for one in into]
            related += [Related(f"{it.node.shown}: {it.silent or it.because}", it.switch.span) for it in owners]
            help = claim.off
            if into[0].publisher.kind == NODE and node.name != into[0].publisher.name:
                help += f"; if it is to own the edge, name it in the description: publisher: {node.name}"
            yield error("parameters-two-owners", message, claim.switch.span, help, related)
        else:
            explained.add(node.full)
            near = [*mine, *(one for one in own if one.parent == parent), *own]
            yield _other_edge(case, claim, near[0] if near else None, claim.parent if mine else claim.child)
            if not into and rival is not None:
                yield _both(claim, rival)
    for one in declared:
        owned = [claim for claim in found if claim.node.is_of(one.publisher, publishers)]
        # The node may publish one of its edges, but not all of them.
        could = any(claim.child.value == one.child or claim.parent.value == one.parent for claim in owned)
        does = any(not claim.silent and claim.child.value == one.child for claim in owned)
        if could and not does and not any(claim.node.full in explained for claim in owned):
            claim, when = owned[0], f" when {one.when}" if one.when else ""
            message = f"no node publishes {one.parent} -> {one.child}{when}: {claim.node.shown} owns it, and "
            message += claim.silent or f"it publishes {claim.edge}"
            help = claim.fix if claim.silent else "correct its frames, or the edge"
            related = [case.related(f"{one.owner} owns it here", one.path)]
            yield error("parameters-no-owner", message, claim.switch.span, help, related)


def _both(claim: Claim, rival: Claim) -> Diagnostic:
    message = f"{rival.node.shown} and {claim.node.shown} both publish {claim.edge}: {claim.because}"
    help = f"an edge has one publisher: {rival.off} in the one, or {claim.off} in the other"
    related = Related(f"{rival.node.shown} publishes it here: {rival.because}", rival.switch.span)
    return error("parameters-two-owners", message, claim.switch.span, help, [related])


def _other_edge(case: Case, claim: Claim, near: Step | None, end: Setting) -> Diagnostic:
    """Report a published edge that differs from the described edge ``near``, or is not in the description."""
    help, prefix = "", _prefix(claim.node)
    if prefix:
        help = f'the controller writes "{prefix}" before its frames, unless tf_frame_prefix_enable is false'
    message = f"{claim.node.shown} publishes {claim.edge}"
    if near is None:
        ends = f"parent: {claim.parent.value}, child: {claim.child.value}, publisher: {claim.node.name}"
        help = help or f"{claim.off}, or add it to edges: {{{ends}}}"
        message += ", an edge that the description does not have"
        return Diagnostic("parameters-other-edge", WARNING, message, claim.switch.span, help=help)
    message += f"{end.how}, but in the description it is {near.parent} -> {near.child}"
    related = [case.related(f"described here, of {near.owner}", near.path)]
    help = help or f'name the frame "{near.parent if end is claim.parent else near.child}", or correct the edge'
    return error("parameters-other-edge", message, end.span, help, related)


def check_frames(case: Case, nodes: Iterable[Node], found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Validate frame names in parameters, except the ends of published transforms, which ``check_edges`` validates."""
    speaking = [claim for claim in found if not claim.silent]
    published = [(str(claim.parent.value), str(claim.child.value)) for claim in speaking]
    known = {*case.robot.frames, *(name for edge in case.robot.edges for name in (edge.parent, edge.child))}
    known |= {parent for parent, _ in published}
    parts = pieces([*((step.parent, step.child) for step in steps_in_modes(case)[0]), *published])
    ends = {(claim.node.full, end.span) for claim in speaking for end in (claim.parent, claim.child) if end.given}
    for node in nodes:
        for key, full, setting in _named(node):
            is_end = (node.full, setting.span) in ends and key.frame != SENSOR
            if is_end and setting.value not in case.robot.simulated_frames:
                continue
            name, text = f'"{full}" of {node.shown} is "{setting.value}"{setting.how}', str(setting.value)
            value = text.removeprefix("/")
            if value != text and not (node.kind and node.kind.strips_slash):
                message = f'{name}: tf2 refuses names of frames that begin with "/"'
                yield error("parameters-frame", message, setting.span, f'write "{text.lstrip("/")}"')
            elif key.frame == BASE:
                yield from _check_base(case, node, key, name, value, setting, parts)
            elif value not in known:
                suggestion = Suggestion(value, known, "name a frame of the robot")
                yield error("parameters-frame", f"{name}: there is no such frame", setting.span, suggestion)
            elif not any(value in part for part in parts) and len(known) > 1:
                message, help = f"{name}, a frame that no node publishes", "add its publisher"
                yield error("parameters-frame", message, setting.span, help, _unpublished(case, value))


def _named(node: Node) -> Iterator[tuple[Key, str, Setting]]:
    """Yield the keys of a node that name frames, with their full names and their values, set or default."""
    # A default frame of a sensor is only used in message headers, such as base_link in joint_state_broadcaster.
    keys_of = node.kind.keys.values() if node.kind else ()
    kind, unset = node.kind, [key for key in keys_of if key.default and key.frame != SENSOR]
    keys = {name: kind.key(name) for name in node.parameters} if kind else {}
    for name, key in ({key.name: key for key in unset} | keys).items():
        unused = MAP if kind and kind.name == "ekf" else ""
        if key is not None and key.frame not in ("", unused) and not (key.many and name == key.name):
            setting = node.setting(name)
            if isinstance(setting.value, str) and (setting.value or key.frame != SENSOR):
                yield key, name, setting


def _check_base(
    case: Case, node: Node, key: Key, name: str, value: str, setting: Setting, parts: Sequence[Collection[str]]
) -> Iterator[Diagnostic]:
    """Report a base frame that no odometry moves; if the node names an odom frame, only its odometry counts."""
    links, edges = case.robot.link, case.robot.edges
    steps = [step for step in steps_in_modes(case)[0] if step.edge is not None and edges[step.edge].moving]
    leading = [step for step in steps if step.child in links and step.parent not in links]
    named = {other.value for one, _, other in _named(node) if one.frame == ODOM}
    moved = [step for step in leading if step.parent in named] or leading
    part: Collection[str] = next((part for part in parts if moved and moved[0].parent in part), ())
    related = [case.related(f"{step.parent} -> {step.child} is described here", step.path) for step in moved]
    help = f"{key.name}: {moved[0].child}" if moved else ""
    if moved and value not in part and value not in links:
        suggestion = Suggestion(value, part, instead=help)
        yield error("parameters-frame", f"{name}: there is no such frame", setting.span, suggestion, related)
    elif moved and value not in part:
        message = f'{name}, and no transform leads to it from "{moved[0].parent}": the odometry moves '
        message += quote(step.child for step in moved)
        yield error("parameters-base", message, setting.span, help, [*related, *_unpublished(case, value)])


def _unpublished(case: Case, frame: str) -> list[Related]:
    joint = case.robot.joint_to.get(frame) or next(iter(case.robot.joints_from.get(frame, ())), None)
    return [case.related(f'no node publishes joint "{joint.name}"', case.publisher(joint))] if joint else []

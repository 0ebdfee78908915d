"""The transforms of the files: who publishes which edge, and the frames that parameters name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.joints import pieces
from rosorin_compile.rules.publishers import steps_in_modes
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Suggestion, error, quoted
from rosorin_compile.source.tree import Path

from ..parameters.tables import Key
from .nodes import DEFAULT, Node, Setting, world_problem
from .remaps import Remap, is_tf, topic


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


BASE, ODOM, MAP, SENSOR = "base", "odom", "map", "sensor"


def check_frames(case: Case, nodes: Iterable[Node], found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the frames that nodes name. What they publish is judged by ``owners``."""
    simulated = case.robot.simulated_frames
    known = {*case.robot.frames, *(name for edge in case.robot.edges for name in (edge.parent, edge.child))}
    claimed = {claim.node.full: {claim.parent.span, claim.child.span} for claim in found if not claim.silent}
    made = {str(claim.parent.value) for claim in found if not claim.silent}
    published = [(str(claim.parent.value), str(claim.child.value)) for claim in found if not claim.silent]
    parts = pieces([*((step.parent, step.child) for step in steps_in_modes(case)[0]), *published])
    for node in nodes:
        yield from _prefixed(node)
        for key, name, setting in _named(node):
            own = setting.given and setting.span in claimed.get(node.full, ())
            if own and setting.value not in simulated and _is_end(node, key, found):
                continue  # told, if it is wrong, with the edge
            yield from _check_frame(case, node, key, name, setting, known | made, parts)


def _prefixed(node: Node) -> Iterator[Diagnostic]:
    prefix = node.setting("frame_prefix") if node.kind and node.kind.name == ROBOT_STATE_PUBLISHER else None
    if prefix is not None and prefix.value and isinstance(prefix.value, str):
        message = f'"frame_prefix" of {node.shown} is "{prefix.value}": it writes that before every frame of the robot'
        message += ", and no other node does"
        yield error("parameters-frame", message, prefix.span, "remove it, or give the links of the robot these names")


def _is_end(node: Node, key: Key, found: Sequence[Claim]) -> bool:
    return any(claim.node is node and not claim.silent for claim in found) and key.frame != SENSOR


def _named(node: Node) -> Iterator[tuple[Key, str, Setting]]:
    """Yield the keys of a node that name frames, by their full names, with what holds, given or by default.

    What a filter calls the map matters where its transform begins there, which is told with the edge.
    """
    if node.kind is None:
        return
    unused = MAP if node.kind.name == "ekf" else ""
    for name, parameter in node.parameters.items():
        key = node.kind.key(name)
        held = key is not None and key.frame and key.frame != unused and not parameter.substituted
        if key is not None and held and isinstance(parameter.value, str):
            yield key, name, Setting(parameter.value, parameter.span, True)
    for key in node.kind.keys.values():
        held = key.frame and key.frame != unused and not key.many and key.default
        if held and key.name not in node.parameters:
            yield key, key.name, node.setting(key.name)


def _check_frame(
    case: Case, node: Node, key: Key, full: str, setting: Setting, known: set[str], parts: Sequence[set[str]]
) -> Iterator[Diagnostic]:
    if not setting.value and key.frame == SENSOR:
        return
    name = f'"{full}" of {node.shown}'
    value, assumed = str(setting.value), f" {DEFAULT}" if not setting.given else ""
    if value.startswith("/") and not (node.kind and node.kind.strips_slash):
        message = f'{name} is "{value}": tf2 refuses names of frames that begin with "/"'
        yield error("parameters-frame", message, setting.span, f'write "{value.lstrip("/")}"')
        return
    value = value.removeprefix("/")
    if key.frame == BASE:
        yield from _base(case, node, key, setting, value, parts)
    elif value not in known:
        message = f'{name} is "{value}"{assumed}: there is no such frame'
        yield error("parameters-frame", message, setting.span, Suggestion(value, known, "name a frame of the robot"))
    elif not any(value in part for part in parts) and len(known) > 1:
        message = f'{name} is "{value}"{assumed}, a frame that no node publishes'
        yield error("parameters-frame", message, setting.span, "say who publishes it", _unpublished(case, value))


def _unpublished(case: Case, frame: str) -> list[Related]:
    joint = case.robot.joint_to.get(frame) or next(iter(case.robot.joints_from.get(frame, ())), None)
    return [case.related(f'no node publishes joint "{joint.name}"', case.publisher(joint))] if joint else []


def _base(
    case: Case, node: Node, key: Key, setting: Setting, value: str, parts: Sequence[set[str]]
) -> Iterator[Diagnostic]:
    name = f'"{key.name}" of {node.shown}'
    assumed = f" {DEFAULT}" if not setting.given else ""
    odom = _odometry(case, node)
    moved = [step for step in steps_in_modes(case)[0] if step.parent == odom]
    part = next((part for part in parts if odom in part), set[str]())
    if value in part or not moved:
        return
    related = [case.related(f"{step.parent} -> {step.child} is described here", step.path) for step in moved]
    help = f"{key.name}: {moved[0].child}"
    if value in case.robot.link:
        message = f'{name} is "{value}"{assumed}, and no transform leads to it from "{odom}"'
        message += f": the odometry moves {quoted(step.child for step in moved)}"
        yield error("parameters-base", message, setting.span, help, [*related, *_unpublished(case, value)])
    else:
        message = f'{name} is "{value}"{assumed}: there is no such frame'
        yield error("parameters-frame", message, setting.span, Suggestion(value, part, instead=help), related)


def _odometry(case: Case, node: Node) -> str:
    """Return the frame that the odometry is given in: as the node says, if it is there, else as the description has it.

    That is the parent of the transform of another node that leads to the robot and hangs on no other, but for a map.
    """
    said, steps = [s.value for key, _, s in _named(node) if key.frame == ODOM], steps_in_modes(case)[0]
    parents = [step.parent for step in steps if step.edge is not None]
    if said and said[0] in parents:
        return str(said[0])
    children = {step.child for step in steps}
    moving = [step for step in steps if step.edge is not None and case.robot.edges[step.edge].moving]
    lowest = [step.parent for step in moving if step.child not in parents]
    return next((p for p in lowest if p in children), next(iter(lowest), ""))

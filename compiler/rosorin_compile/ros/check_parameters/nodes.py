"""Find the ROS nodes in parameter files, and validate their parameters and the transforms that they publish."""

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Controller, Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.rules.case import Case, report
from rosorin_compile.rules.joints import pieces
from rosorin_compile.rules.publishers import Step, all_steps, steps_in_modes
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span, Suggestion, error, nearest, quote
from rosorin_compile.source.wording import suggest

from .. import node_kinds
from ..launch_files import Remap
from ..node_kinds import MANAGER, REMOVE, Key, Kind, against_kind, as_yaml, by_signs, is_of, kinds
from ..parameter_files import Parameter, Section
from ..ports import facts, full_topic, full_type

_POINT = r"\[\s*[^\[\],\s]+[\s,]+[^\[\],\s]+\s*\][\s,]*"
_POLYGON = re.compile(rf"\s*(\[\s*({_POINT}){{3,}}\]|\[\s*\])?\s*")
_INPUT = re.compile(r"(odom|pose|twist|imu)(\d+)(_.*)?")
BASE, ODOM, MAP, SENSOR = "base", "odom", "map", "sensor"


class Setting(NamedTuple):
    """The value of a parameter (None if unknown) and its position; ``given`` is False for a default value."""

    value: Any
    span: Span
    given: bool

    @property
    def how(self) -> str:
        """Text to append in messages: "" if a file sets the value, " by default" otherwise."""
        return "" if self.given else " by default"


@dataclass(frozen=True, eq=False)
class Node:
    """A ROS node that parameter files configure; ``full`` is its name with the namespace.

    ``kind`` is the kind of node, such as amcl, or None if unknown. ``type`` is the type of a controller, or "" for
    other nodes. ``shared`` are the parameters of wildcard sections, which can also apply to other nodes.
    """

    full: str
    span: Span
    kind: Kind | None
    parameters: Mapping[str, Parameter]
    type: str = ""
    type_span: Span | None = None
    shared: Collection[str] = ()

    @property
    def name(self) -> str:
        return self.full.rsplit("/", 1)[-1]

    @property
    def namespace(self) -> str:
        """The namespace, or "/" if the node has none."""
        return self.full.rsplit("/", 1)[0] or "/"

    @property
    def display_name(self) -> str:
        """The full name without the leading slash, for messages."""
        return self.full.strip("/")

    @property
    def values(self) -> dict[str, Any]:
        """The parameter values by key, without values that contain launch substitutions."""
        return {key: one.value for key, one in self.parameters.items() if "$(" not in key and not one.has_substitution}

    def topic(self, name: str) -> str:
        """Resolve a topic name, such as ``~/odom``, to its full name for this node."""
        return full_topic(name, self.namespace, self.name)

    def is_of(self, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
        """Return True if this node is the node ``publisher`` of the description; see ``node_kinds.is_of``."""
        return is_of(self.name, self.kind, publisher, publishers)

    def setting(self, key: str, default: Any = None) -> Setting:
        """Return a parameter value: from a file, or else the default of this kind of node, or else ``default``."""
        if (given := self.parameters.get(key)) is not None:
            return Setting(None if given.has_substitution else given.value, given.span, True)
        known = self.kind.key(key) if self.kind else None
        return Setting(default if known is None or known.default is None else known.default, self.span, False)


def nodes_in_files(
    files: Sequence[Sequence[Section]], namespace: str, distribution: str, controllers: Sequence[Controller] = ()
) -> tuple[list[Node], list[Diagnostic]]:
    """Return the nodes that parameter files configure, and diagnostics about node names.

    ``files`` are the sections of each file. A wildcard section applies to the nodes that are named in the same file; if
    there are none, the kind of node is inferred from the parameters. ``namespace`` is added to names without a
    namespace.
    """
    named: dict[str, list[Section]] = defaultdict(list)
    diagnostics: list[Diagnostic] = []
    space = list(filter(None, namespace.strip("/").split("/")))
    for sections in files:
        nodes = [section for section in sections if not section.of_any]
        exact = [section.name for section in nodes if "*" not in section.name]
        for section in nodes:
            words = section.name.strip("/").split("/")
            plain = [word for word in words if word not in ("*", "**")]
            if plain != words and any(map(section.matches, exact)):
                continue  # a wildcard for nodes that are named in this file, not another node
            is_full = plain == words and (len(words) > 1 or not space)
            full = section.name if is_full else f"/{'/'.join([*space, *plain])}"
            if plain and plain[-1] in kinds("")["costmap"].names and plain[-2:-1] != plain[-1:]:
                full += f"/{plain[-1]}"  # a costmap is in a namespace with its name
            diagnostics += [_reaches_nobody(section, full)] if not section.matches(full) else []
            wild = [one for one in sections if one.of_any or (plain == words and "*" in one.name)]
            named[full] += [one for one in sections if one is section or (one in wild and one.matches(full))]
        kind = by_signs(_merged(sections), distribution) if not nodes else None
        if kind is not None:
            named[f"{namespace.rstrip('/')}/{[*kind.names, kind.name][0]}"] += sections
    types = _types(named, controllers)
    # If a controller has no parameters, an unknown node with a similar name is probably this controller, misspelt.
    bare = {full.rpartition("/")[2]: full for full in types if all(one.of_any for one in named[full])}
    for full in [one for one in named if one not in types]:
        name = full.rpartition("/")[2]
        meant = name if name in bare else nearest(name, bare) if name != MANAGER else None
        if meant is None:
            continue
        kind, keys = node_kinds.controller(types[bare[meant]][0], ""), _merged(named[full])
        if meant != name and (kind is None or 2 * sum(key in kind for key in keys) <= len(keys)):
            continue
        sections = named.pop(full)
        named[bare[meant]] += sections
        if meant == name:
            diagnostics.append(_reaches_nobody(sections[0], bare[name]))
        else:
            message = f'no controller is called "{name}": no node reads these parameters'
            diagnostics.append(error("parameters-reach-nobody", message, sections[0].span, suggest(meant)))
    return [_node(full, sections, types.get(full), distribution) for full, sections in named.items()], diagnostics


def _reaches_nobody(section: Section, full: str) -> Diagnostic:
    message = f'"{section.name.strip("/")}" does not reach the node {full}, which has its defaults then'
    help = f"write {full} or /**{section.name}, unless the launch file rewrites the file for the namespace"
    return Diagnostic("parameters-reach-nobody", WARNING, message, section.span, help=help)


def _merged(sections: Sequence[Section]) -> dict[str, Parameter]:
    return {name: value for section in sections for name, value in section.parameters.items()}


def _types(named: Mapping[str, list[Section]], controllers: Sequence[Controller]) -> Mapping[str, tuple[str, Span]]:
    described = {one.name: full_type(one.type) for one in controllers}
    found: dict[str, tuple[str, Span]] = {}
    for full, sections in named.items():
        (space, _, name), merged = full.rpartition("/"), _merged(sections)
        own = merged.get("type")
        if name == MANAGER:
            for key, one in merged.items():
                if key.endswith(".type") and key.count(".") == 1 and isinstance(one.value, str):
                    found[f"{space}/{key.removesuffix('.type')}"] = (one.value, one.span)
        elif own is not None and isinstance(own.value, str) and nearest(own.value, node_kinds.plugins("")) is not None:
            found.setdefault(full, (own.value, own.span))
        elif name in described:
            found.setdefault(full, (described[name], sections[0].span))
    return found


def _node(full: str, sections: list[Section], of_type: tuple[str, Span] | None, distribution: str) -> Node:
    parameters, own = _merged(sections), [section for section in sections if not section.of_any]
    shared = parameters.keys() - _merged(own).keys()
    plugin, place = of_type or ("", None)
    places = [*(section.span for section in own or sections), *([place] if place else [])]
    usual = (one for one in kinds(distribution).values() if full.rpartition("/")[2] in one.names)
    if plugin in node_kinds.plugins(""):
        kind = node_kinds.controller(plugin, distribution)
    else:
        kind = (None if plugin else next(usual, None)) or node_kinds.drive_by_keys(parameters, distribution)
        kind = kind if kind or plugin else by_signs(parameters, distribution)
    return Node(full, places[0], kind, parameters, plugin, place, shared)


def check_node(node: Node) -> Iterator[Diagnostic]:
    """Validate the parameters of a node. If its kind is unknown, only report plugins whose type is not set."""
    for key, by_default in facts("ros2_nodes")["plugin_lists"].get(node.name, {}).items():
        setting = node.setting(key)
        names = setting.value if setting.given and isinstance(setting.value, list) else ()
        untyped = [one for one in map(str, names) if one not in by_default and f"{one}.plugin" not in node.parameters]
        if untyped:
            message = f'"{key}" of {node.display_name} names {quote(untyped, most=4)}, and their type is not set'
            help = f"{untyped[0]}: {{plugin: TYPE}}; the node does not start, unless another file says it"
            yield Diagnostic("parameters-wrong-value", WARNING, message, setting.span, help=help)
    if node.kind is None:
        stock = [name for kind in kinds("").values() for name in kind.names if name != node.name]
        if not node.type and (close := get_close_matches(node.name, stock, n=1, cutoff=0.9)):
            message = f'"{node.name}" is not the name of a stock node, so perhaps no node reads these parameters'
            yield Diagnostic("parameters-reach-nobody", WARNING, message, node.span, help=suggest(close[0]))
        return
    values = {key: value for key, value in node.values.items() if key in node.kind or key not in node.shared}
    for found in against_kind(node.display_name, node.kind, values):
        parameter = node.parameters[found.key]
        is_unknown = found.rule == "parameters-unknown-key" and node.kind.key(found.key) is None
        unset = node.kind.suggestions(found.key) - values.keys()
        if is_unknown and isinstance(found.help, Suggestion) and nearest(found.key, unset) is None:
            found = found._replace(severity=WARNING, help=REMOVE)  # not a typo: no unset key is similar
        yield found.place(parameter.key if found.at_key else parameter.span)
    footprint = node.setting("footprint")
    if "footprint" in node.kind and isinstance(footprint.value, str) and not _POLYGON.fullmatch(footprint.value):
        message = f'"footprint" of {node.display_name} is not a polygon: the costmap goes on with robot_radius'
        yield error("parameters-wrong-value", message, footprint.span, 'write three points or more: "[[x, y], ...]"')
    prefix = node.setting("frame_prefix")
    if node.kind.name == ROBOT_STATE_PUBLISHER and prefix.value and isinstance(prefix.value, str):
        message = (
            f'"frame_prefix" of {node.display_name} is "{prefix.value}": it writes that before every frame of the robot'
        )
        yield error("parameters-frame", f"{message}, and no other node does", prefix.span, "remove it")
    if node.kind.name == "ekf":
        yield from _filter(node)


def _filter(node: Node) -> Iterator[Diagnostic]:
    found = {name: match for name in node.parameters if (match := _INPUT.fullmatch(name))}
    for name, match in found.items():
        kind, number, is_about, parameter = match[1], int(match[2]), match[3], node.parameters[name]
        gap = next((n for n in ([number] if is_about else range(number)) if f"{kind}{n}" not in found), None)
        if gap is not None:
            message = f'"{name}" of {node.display_name} is never read: there is no {kind}{gap}'
            yield report("parameters-gap", message, parameter.key)
        config = node.parameters.get(f"{name}_config")
        if is_about or (config is not None and (not isinstance(config.value, list) or any(config.value))):
            continue
        why = f"there is no {name}_config" if config is None else f"all of {name}_config is false"
        message = f'nothing of "{name}" of {node.display_name} is used: {why}'
        place = parameter.key if config is None else config.span
        help = f"set what it measures in {name}_config, 15 booleans"
        yield Diagnostic("parameters-wrong-value", WARNING, message, place, help=help)
    keys: dict[str, str] = {}
    for key in ("map_frame", "odom_frame", "base_link_frame"):
        setting = node.setting(key)
        if not isinstance(setting.value, str):
            return  # the value is unknown, or already reported as invalid
        if (first := keys.setdefault(setting.value.removeprefix("/"), key)) != key:
            message = f'{quote((first, key))} of {node.display_name} are both "{setting.value}": they have to differ'
            yield error("parameters-wrong-value", message, setting.span, "name the frames of the robot")
    world = node.setting("world_frame")
    worlds = [frame for frame, key in keys.items() if key != "base_link_frame"]
    if world.given and world.value is not None and world.value not in worlds:
        message = f'"world_frame" of {node.display_name} is "{world.value}", neither its odom_frame nor its map_frame'
        help_ = Suggestion(str(world.value), worlds)
        yield error("parameters-wrong-value", f"{message}: it publishes nothing", world.span, help_)


def remapped_topics(node: Node, remaps: Iterable[Remap]) -> dict[str, str]:
    """Map full topic names of a node to their names after remapping. As in rcl, the first matching remap applies."""
    mine = [one for one in remaps if one.node in ("", node.name)]
    return {node.topic(one.name): node.topic(one.to) for one in reversed(mine)}


class Claim(NamedTuple):
    """A transform that a node publishes, or would publish with another parameter value.

    The value ``switch`` of the parameter ``key`` enables the transform. ``silent`` is the reason why the transform does
    not reach /tf, or "" if it does. ``fix`` is the change that makes it reach /tf, such as ``publish_tf: true``.
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
        """The transform as text, such as ``odom -> base_link``."""
        return f"{self.parent.value} -> {self.child.value}"

    @property
    def because(self) -> str:
        """The parameter that enables the transform, as text such as ``"publish_tf" is false by default``."""
        return f'"{self.key}" is {as_yaml(self.switch.value)}{self.switch.how}'

    @property
    def off(self) -> str:
        """The line in a parameter file that disables the transform, such as ``publish_tf: false``."""
        return f"{self.key}: {'0.0' if isinstance(self.switch.value, float) else 'false'}"


def claims(nodes: Iterable[Node], remaps: Sequence[Remap]) -> list[Claim]:
    """Return the transforms that nodes publish, or would publish with other parameter values."""
    found = []
    for node in nodes:
        kind = node.kind
        claim = None if kind is None else _of_filter(node) if kind.name == "ekf" else _of_keys(node, kind.transform)
        if kind is None or claim is None:
            continue
        claim = claim if claim.switch.value else claim._replace(silent=claim.because)
        name = kind.odometry or "/tf"
        full = remapped_topics(node, remaps).get(node.topic(name), node.topic(name))
        if not claim.silent and full not in ("/tf", node.topic("tf")):
            fix = f"remap {full} to /tf: --remap {node.name}:{name}:=/tf, if the launch file does"
            claim = claim._replace(silent=f"publishes on {full}, which nothing remaps to /tf", fix=fix)
        found.append(claim)
    return found


def _of_keys(node: Node, names: Mapping[str, str]) -> Claim | None:
    if not names:
        return None
    parent, child, switch = _frame(node, names["parent"]), _frame(node, names["child"]), node.setting(names["switch"])
    child = _frame(node, names["else"]) if child.value == "" and "else" in names else child
    fix = f"{names['switch']}: {'0.05' if isinstance(switch.value, float) else 'true'}"
    is_complete = parent.value and child.value and switch.value is not None
    return Claim(node, parent, child, names["switch"], switch, fix=fix) if is_complete else None


def _of_filter(node: Node) -> Claim | None:
    keys = ("odom_frame", "map_frame", "base_link_frame", "base_link_frame_output")
    odom, map_, base, output = (_frame(node, key) for key in keys)
    base = output if output.given or output.value is not None else base
    world, tf = node.setting("world_frame", odom.value).value, node.setting("publish_tf")
    if None in (odom.value, map_.value, base.value, tf.value) or world not in (odom.value, map_.value):
        return None  # a launch file may set the value; check_node reports an invalid value
    ends = (map_, odom) if world == map_.value != odom.value else (odom, base)
    switch = tf if tf.given else tf._replace(span=node.setting("world_frame").span)
    return Claim(node, *ends, "publish_tf", switch, fix="publish_tf: true")


def _frame(node: Node, key: str) -> Setting:
    """Return a frame name as the node publishes it: with the prefix of a controller, without a leading slash."""
    setting = node.setting(key)
    if not isinstance(setting.value, str):
        return setting._replace(value=None)
    return setting._replace(value=_prefix(node) + setting.value.removeprefix("/"))


def _prefix(node: Node) -> str:
    """Return the prefix that a controller adds to frame names (tf_frame_prefix or its namespace), or ""."""
    if node.kind is None or "tf_frame_prefix" not in node.kind or not node.setting("tf_frame_prefix_enable").value:
        return ""
    text = str(node.setting("tf_frame_prefix").value or node.namespace).strip("/")
    return f"{text}/" if text else ""


def check_edges(case: Case, found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Report transforms in ``found`` that are not in ``edges``, and transforms in ``edges`` that no node publishes."""
    declared = [step for step in all_steps(case, legal=False) if step.publisher.publishes]
    publishers, speaking = case.robot.publishers, [claim for claim in found if not claim.silent]
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
            message = f"{node.display_name} publishes {claim.edge} ({claim.because}), and by the description "
            message += f"{into[0].parent} -> {child} is of {into[0].owner}"
            related = [
                case.related_place(f"{one.parent} -> {one.child} is of {one.owner} here", one.path) for one in into
            ]
            related += [Related(f"{it.node.display_name}: {it.silent or it.because}", it.switch.span) for it in owners]
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
        # A node can be the publisher of several edges, of which these files may enable only some.
        could = any(claim.child.value == one.child or claim.parent.value == one.parent for claim in owned)
        does = any(not claim.silent and claim.child.value == one.child for claim in owned)
        if could and not does and not any(claim.node.full in explained for claim in owned):
            claim, when = owned[0], f" when {one.when}" if one.when else ""
            message = f"no node publishes {one.parent} -> {one.child}{when}: {claim.node.display_name} owns it, and "
            message += claim.silent or f"it publishes {claim.edge}"
            help = claim.fix if claim.silent else "correct its frames, or the edge"
            related = [case.related_place(f"{one.owner} owns it here", one.path)]
            yield error("parameters-no-owner", message, claim.switch.span, help, related)


def _both(claim: Claim, rival: Claim) -> Diagnostic:
    message = f"{rival.node.display_name} and {claim.node.display_name} both publish {claim.edge}: {claim.because}"
    help = f"an edge has one publisher: {rival.off} in the one, or {claim.off} in the other"
    related = Related(f"{rival.node.display_name} publishes it here: {rival.because}", rival.switch.span)
    return error("parameters-two-owners", message, claim.switch.span, help, [related])


def _other_edge(case: Case, claim: Claim, near: Step | None, end: Setting) -> Diagnostic:
    """Report a published transform that the description lacks; ``near`` is the most similar edge, or None."""
    help, prefix = "", _prefix(claim.node)
    if prefix:
        help = f'the controller writes "{prefix}" before its frames, unless tf_frame_prefix_enable is false'
    message = f"{claim.node.display_name} publishes {claim.edge}"
    if near is None:
        ends = f"parent: {claim.parent.value}, child: {claim.child.value}, publisher: {claim.node.name}"
        help = help or f"{claim.off}, or add it to edges: {{{ends}}}"
        message += ", an edge that the description does not have"
        return Diagnostic("parameters-other-edge", WARNING, message, claim.switch.span, help=help)
    message += f"{end.how}, but in the description it is {near.parent} -> {near.child}"
    related = [case.related_place(f"described here, of {near.owner}", near.path)]
    help = help or f'name the frame "{near.parent if end is claim.parent else near.child}", or correct the edge'
    return error("parameters-other-edge", message, end.span, help, related)


def check_frames(case: Case, nodes: Iterable[Node], found: Sequence[Claim]) -> Iterator[Diagnostic]:
    """Validate frame names in parameters, except the frames of the transforms ``found`` (see ``check_edges``)."""
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
            name, text = f'"{full}" of {node.display_name} is "{setting.value}"{setting.how}', str(setting.value)
            if (value := text.removeprefix("/")) != text and not (node.kind and node.kind.strips_slash):
                message = f'{name}: tf2 rejects names of frames that begin with "/"'
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
    """Yield (parameter, key in the file, value) for each parameter that is a frame name, including default values."""
    # Skip default sensor frames, such as base_link of joint_state_broadcaster: they only occur in message headers.
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
    """Report a base frame that is not connected to the odometry frame of the node."""
    links, edges = case.robot.link, case.robot.edges
    steps = [step for step in steps_in_modes(case)[0] if step.edge is not None and edges[step.edge].moving]
    leading = [step for step in steps if step.child in links and step.parent not in links]
    named = {other.value for one, _, other in _named(node) if one.frame == ODOM}
    moved = [step for step in leading if step.parent in named] or leading
    part: Collection[str] = next((part for part in parts if moved and moved[0].parent in part), ())
    related = [case.related_place(f"{step.parent} -> {step.child} is described here", step.path) for step in moved]
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
    return [case.related_place(f'no node publishes joint "{joint.name}"', case.publisher(joint))] if joint else []

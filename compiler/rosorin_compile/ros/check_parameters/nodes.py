"""The nodes in parameter files: identify the kind of each node, and check its keys and values."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Controller, Publisher
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span, Suggestion, error, nearest, quote
from rosorin_compile.source.wording import suggest

from ..node_kinds import MANAGER, REMOVE, Kind, against_kind, by_signs, controller, drive_by_keys, is_of, kinds, plugins
from ..parameter_files import Parameter, Section
from ..ports import facts, full_topic, full_type

_POINT = r"\[\s*[^\[\],\s]+[\s,]+[^\[\],\s]+\s*\][\s,]*"
_POLYGON = re.compile(rf"\s*(\[\s*({_POINT}){{3,}}\]|\[\s*\])?\s*")
_INPUT = re.compile(r"(odom|pose|twist|imu)(\d+)(_.*)?")


class Setting(NamedTuple):
    """The value of a node's parameter (None if unknown), its position, and True if a file sets it."""

    value: Any
    span: Span
    given: bool

    @property
    def how(self) -> str:
        """The suffix for messages: "" if a file sets the value, else " by default"."""
        return "" if self.given else " by default"


@dataclass(frozen=True, eq=False)
class Node:
    """A node in parameter files: its full name with its position, its kind or None, and its parameters.

    ``type`` is the type of a controller, "" for other nodes, and ``type_span`` its position. ``shared`` are the keys
    under a wildcard, which apply to other nodes as well.
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
        """The name without the namespace."""
        return self.full.rsplit("/", 1)[-1]

    @property
    def namespace(self) -> str:
        """The namespace, or / if there is none."""
        return self.full.rsplit("/", 1)[0] or "/"

    @property
    def shown(self) -> str:
        """The name in messages."""
        return self.full.strip("/")

    @property
    def values(self) -> dict[str, Any]:
        """The parameter values, without values that contain substitutions."""
        return {key: one.value for key, one in self.parameters.items() if "$(" not in key and not one.substituted}

    def topic(self, name: str) -> str:
        """Return the full name of a topic of this node."""
        return full_topic(name, self.namespace, self.name)

    def is_of(self, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
        """Return True if this node is a publisher of the description, by name or package."""
        return is_of(self.name, self.kind, publisher, publishers)

    def setting(self, key: str, default: Any = None) -> Setting:
        """Return the value in a file, else the default in the tables of ROS nodes, else ``default``."""
        given = self.parameters.get(key)
        if given is not None:
            return Setting(None if given.substituted else given.value, given.span, True)
        known = self.kind.key(key) if self.kind else None
        return Setting(default if known is None or known.default is None else known.default, self.span, False)


def nodes_in_files(
    files: Sequence[Sequence[Section]], namespace: str, distribution: str, controllers: Sequence[Controller] = ()
) -> tuple[list[Node], list[Diagnostic]]:
    """Return the nodes that files configure, without duplicates, and diagnostics about their names.

    Each file is a list of sections. Its wildcards apply to the nodes that it names; if it names none, one node is
    inferred from its keys. ``controllers`` are the controllers of the description.
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
                continue  # it is for those
            is_relative = plain != words or (len(words) == 1 and space)
            full = "/" + "/".join([*space, *plain]) if is_relative else section.name
            if not section.matches(full):
                diagnostics.append(_reaches_nobody(section, full))
            wild = [one for one in sections if one.of_any or (plain == words and "*" in one.name)]
            named[full] += [one for one in sections if one is section or (one in wild and one.matches(full))]
        kind = by_signs(_merged(sections), distribution) if not nodes else None
        if kind is not None:
            named[f"{namespace.rstrip('/')}/{[*kind.names, kind.name][0]}"] += sections
    types = _types(named, controllers)
    # Parameters for unknown names belong to controllers without parameters and with a similar name.
    bare = {full.rpartition("/")[2]: full for full in types if all(one.of_any for one in named[full])}
    for full in [one for one in named if one not in types]:
        name = full.rpartition("/")[2]
        meant = name if name in bare else nearest(name, bare) if name != MANAGER else None
        if meant is None:
            continue
        kind, keys = controller(types[bare[meant]][0], ""), _merged(named[full])
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
    """Return types of controllers and their positions, from the manager, the node itself, or the description."""
    described = {one.name: full_type(one.type) for one in controllers}
    found: dict[str, tuple[str, Span]] = {}
    for full, sections in named.items():
        (space, _, name), merged = full.rpartition("/"), _merged(sections)
        own = merged.get("type")
        if name == MANAGER:
            for key, one in merged.items():
                if key.endswith(".type") and key.count(".") == 1 and isinstance(one.value, str):
                    found[f"{space}/{key.removesuffix('.type')}"] = (one.value, one.span)
        elif own is not None and isinstance(own.value, str) and nearest(own.value, plugins("")) is not None:
            found.setdefault(full, (own.value, own.span))
        elif name in described:
            found.setdefault(full, (described[name], sections[0].span))
    return found


def _node(full: str, sections: list[Section], of_type: tuple[str, Span] | None, distribution: str) -> Node:
    parameters = _merged(sections)
    own = [section for section in sections if not section.of_any]
    shared = parameters.keys() - _merged(own).keys()
    plugin, place = of_type or ("", None)
    places = [*(section.span for section in own or sections), *([place] if place else [])]
    usual = (one for one in kinds(distribution).values() if full.rpartition("/")[2] in one.names)
    if plugin in plugins(""):
        kind = controller(plugin, distribution)
    else:
        kind = (None if plugin else next(usual, None)) or drive_by_keys(parameters, distribution)
        kind = kind if kind or plugin else by_signs(parameters, distribution)
    return Node(full, places[0], kind, parameters, plugin, place, shared)


def check_node(node: Node) -> Iterator[Diagnostic]:
    """Validate the keys and values of a node; for a node of unknown kind, only report plugins without a type."""
    for key, by_default in facts("ros2_nodes")["plugin_lists"].get(node.name, {}).items():
        setting = node.setting(key)
        names = setting.value if setting.given and isinstance(setting.value, list) else ()
        untyped = [one for one in map(str, names) if one not in by_default and f"{one}.plugin" not in node.parameters]
        if untyped:
            message = f'"{key}" of {node.shown} names {quote(untyped, most=4)}, and their type is not set'
            help = f"{untyped[0]}: {{plugin: TYPE}}; the node does not start, unless another file says it"
            yield Diagnostic("parameters-wrong-value", WARNING, message, setting.span, help=help)
    if node.kind is None:
        return
    values = {key: value for key, value in node.values.items() if key in node.kind or key not in node.shared}
    for found in against_kind(node.shown, node.kind, values):
        parameter = node.parameters[found.key]
        is_unknown = found.rule == "parameters-unknown-key" and node.kind.key(found.key) is None
        if is_unknown and isinstance(found.help, Suggestion) and found.help() == REMOVE:
            found = found._replace(severity=WARNING)  # no similar key exists, as for leftover keys in vendors' files
        yield found.place(parameter.key if found.at_key else parameter.span)
    footprint = node.setting("footprint")
    if "footprint" in node.kind and isinstance(footprint.value, str) and not _POLYGON.fullmatch(footprint.value):
        message = f'"footprint" of {node.shown} is not a polygon: the costmap goes on with robot_radius'
        help = 'write three points or more: "[[x, y], ...]"'
        yield error("parameters-wrong-value", message, footprint.span, help)
    prefix = node.setting("frame_prefix")
    if node.kind.name == ROBOT_STATE_PUBLISHER and prefix.value and isinstance(prefix.value, str):
        message = f'"frame_prefix" of {node.shown} is "{prefix.value}": it writes that before every frame of the robot'
        yield error("parameters-frame", f"{message}, and no other node does", prefix.span, "remove it")
    if node.kind.name == "ekf":
        yield from _filter(node)


def _filter(node: Node) -> Iterator[Diagnostic]:
    """Report unused inputs and invalid frames of a robot_localization filter."""
    found = {name: match for name in node.parameters if (match := _INPUT.fullmatch(name))}
    for name, match in found.items():
        kind, number, is_about, parameter = match[1], int(match[2]), match[3], node.parameters[name]
        gap = next((n for n in ([number] if is_about else range(number)) if f"{kind}{n}" not in found), None)
        if gap is not None:
            message = f'"{name}" of {node.shown} is never read: there is no {kind}{gap}'
            yield report("parameters-gap", message, parameter.key)
        config = node.parameters.get(f"{name}_config")
        if is_about or (config is not None and (not isinstance(config.value, list) or any(config.value))):
            continue
        why = f"there is no {name}_config" if config is None else f"all of {name}_config is false"
        message = f'nothing of "{name}" of {node.shown} is used: {why}'
        place = parameter.key if config is None else config.span
        help = f"set what it measures in {name}_config, 15 booleans"
        yield Diagnostic("parameters-wrong-value", WARNING, message, place, help=help)
    keys: dict[str, str] = {}
    for key in ("map_frame", "odom_frame", "base_link_frame"):
        setting = node.setting(key)
        if not isinstance(setting.value, str):
            return  # unknown, or already reported
        first = keys.setdefault(setting.value.removeprefix("/"), key)
        if first != key:
            message = f'{quote((first, key))} of {node.shown} are both "{setting.value}": they have to differ'
            yield error("parameters-wrong-value", message, setting.span, "name the frames of the robot")
    world = node.setting("world_frame")
    worlds = [frame for frame, key in keys.items() if key != "base_link_frame"]
    if world.given and world.value is not None and world.value not in worlds:
        message = f'"world_frame" of {node.shown} is "{world.value}", neither its odom_frame nor its map_frame'
        help_ = Suggestion(str(world.value), worlds)
        yield error("parameters-wrong-value", f"{message}: it publishes nothing", world.span, help_)

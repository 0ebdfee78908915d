"""The nodes that parameter files speak of: what each is, and what is wrong with its keys and values."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.model import Controller, Publisher
from rosorin_compile.source.diagnostics import (
    WARNING,
    Diagnostic,
    Span,
    Suggestion,
    error,
    nearest,
    quoted,
)
from rosorin_compile.source.wording import suggest

from ..parameters.checking import REMOVE, against_kind
from ..parameters.files import Parameter, Section
from ..parameters.tables import MANAGER, Kind, by_name, by_signs, controller, controller_by_keys, is_of, plugins
from ..ports import facts, full_type

DEFAULT = "by default"


class Setting(NamedTuple):
    """What holds for a key of a node: its value, the place that says so, and whether that is its default alone.

    The value is None if it is unknown: there is no default, or a launch file sets it.
    """

    value: Any
    span: Span
    given: bool

    @property
    def how(self) -> str:
        """The end of a sentence about it: nothing, or that it is a default."""
        return "" if self.given else f" {DEFAULT}"


@dataclass(frozen=True, eq=False)
class Node:
    """A node of the files: its full name, the place that names it, its kind if it is known, and its parameters.

    ``type`` is that of a controller, empty for other nodes, and ``said`` is the place of that. ``shared`` are keys that
    stand under a wildcard, where other nodes read them as well.
    """

    full: str
    span: Span
    kind: Kind | None
    parameters: Mapping[str, Parameter]
    type: str = ""
    said: Span | None = None
    shared: Collection[str] = ()

    @property
    def name(self) -> str:
        """The name without the namespace."""
        return self.full.rsplit("/", 1)[-1]

    @property
    def namespace(self) -> str:
        """The namespace; / for none."""
        return self.full.rsplit("/", 1)[0] or "/"

    @property
    def shown(self) -> str:
        """What messages call it."""
        return self.full.strip("/")

    def is_of(self, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
        """Say whether it is the node that a description calls a publisher."""
        return is_of(self.name, self.kind, publisher, publishers)

    def setting(self, key: str, default: Any = None) -> Setting:
        """Return what holds for a key: what is given, else the default of the tables, else ``default``."""
        given = self.parameters.get(key)
        if given is not None and given.substituted:
            return Setting(None, given.span, True)
        if given is not None:
            return Setting(given.value, given.span, True)
        known = self.kind.key(key) if self.kind else None
        value = known.default if known is not None and known.default is not None else default
        return Setting(value, self.span, False)


class Files(NamedTuple):
    """What was read: a list of sections for each file; and the controllers of the description."""

    sections: Sequence[Sequence[Section]]
    namespace: str
    distribution: str
    controllers: Sequence[Controller] = ()


def found(files: Files) -> tuple[list[Node], list[Diagnostic]]:
    """Return the nodes that files speak of, each once, and what is wrong with what they are.

    Wildcards of a file hold for the nodes that it names; where it names none, it is of one node, which its keys tell.
    """
    named: dict[str, list[Section]] = {}
    told: list[Diagnostic] = []
    for sections in files.sections:
        nodes = [section for section in sections if not section.of_any]
        for section in nodes:
            full = _full(section, files.namespace)
            if not section.matches(full):
                told.append(_reaches_nobody(section, full))
            mine = [one for one in sections if one is section or (one.of_any and one.matches(full))]
            named.setdefault(full, []).extend(mine)
        if not nodes and sections:
            merged = _merged(sections)
            kind = by_signs(merged, files.distribution)
            if kind is not None:
                named.setdefault(f"{files.namespace.rstrip('/')}/{kind.names[0]}", []).extend(sections)
    types = _types(named, files)
    for full in types:
        named.setdefault(full, [])
    told += _homeless(named, types)
    return [_node(full, sections, types.get(full), files.distribution) for full, sections in named.items()], told


def _full(section: Section, namespace: str) -> str:
    words = section.name.strip("/").split("/")
    own = [word for word in words if word not in ("*", "**")]
    if own != words or (len(words) == 1 and namespace.strip("/")):
        return "/" + "/".join([*filter(None, namespace.strip("/").split("/")), *own])
    return section.name


def _reaches_nobody(section: Section, full: str) -> Diagnostic:
    message = f'"{section.name.strip("/")}" does not reach the node {full}, which has its defaults then'
    help = f"write {full} or /**{section.name}, unless the launch file rewrites the file for the namespace"
    return Diagnostic("parameters-reach-nobody", WARNING, message, section.span, help=help)


def _merged(sections: Sequence[Section]) -> dict[str, Parameter]:
    return {name: value for section in sections for name, value in section.parameters.items()}


class _Type(NamedTuple):
    """The type of a controller, and its place."""

    name: str
    span: Span


def _types(named: Mapping[str, list[Section]], files: Files) -> dict[str, _Type]:
    """Return the types of controllers by full name.

    The manager says them, or the node itself (the spawner reads it), or the description of a controller of that name.
    """
    described = {one.name: full_type(one.type) for one in files.controllers}
    found: dict[str, _Type] = {}
    for full, sections in named.items():
        space, _, name = full.rpartition("/")
        merged = _merged(sections)
        own = merged.get("type")
        if name == MANAGER:
            keys = ((key, one) for key, one in merged.items() if key.endswith(".type") and key.count(".") == 1)
            texts = ((key.removesuffix(".type"), one) for key, one in keys if isinstance(one.value, str))
            found |= {f"{space}/{key}": _Type(one.value, one.span) for key, one in texts}
        elif own is not None and isinstance(own.value, str) and _is_type(own.value):
            found.setdefault(full, _Type(own.value, own.span))
        elif name in described:
            found.setdefault(full, _Type(described[name], sections[0].span))
    return found


def _is_type(text: str) -> bool:
    return text in plugins("") or nearest(text, plugins("")) is not None


def _homeless(named: dict[str, list[Section]], types: Mapping[str, _Type]) -> Iterator[Diagnostic]:
    bare = {full.rpartition("/")[2]: full for full in types if not any(not one.of_any for one in named[full])}
    for full in [one for one in named if one not in types]:
        name = full.rpartition("/")[2]
        if name in bare:
            sections = named.pop(full)
            named[bare[name]] += sections
            yield _reaches_nobody(sections[0], bare[name])
        elif name != MANAGER and (meant := nearest(name, bare)) and _fits(named[full], types[bare[meant]].name):
            sections = named.pop(full)
            named[bare[meant]] += sections
            message = f'no controller is called "{name}": no node reads these parameters'
            yield error("parameters-reach-nobody", message, sections[0].span, suggest(meant))


def _fits(sections: Sequence[Section], of_type: str) -> bool:
    kind, keys = controller(of_type, ""), _merged(sections)
    return kind is not None and 2 * sum(key in kind for key in keys) > len(keys)


def _node(full: str, sections: list[Section], of_type: _Type | None, distribution: str) -> Node:
    parameters = _merged(sections)
    own = [section for section in sections if not section.of_any]
    spans = [section.span for section in own or sections]
    shared = parameters.keys() - _merged(own).keys()
    if of_type is None:
        kind = by_name(full.rpartition("/")[2], distribution) or controller_by_keys(parameters, distribution)
        return Node(full, spans[0], kind or by_signs(parameters, distribution), parameters, shared=shared)
    kind = controller(of_type.name, distribution)
    if kind is None and of_type.name not in plugins(""):
        kind = controller_by_keys(parameters, distribution)
    return Node(full, spans[0] if spans else of_type.span, kind, parameters, of_type.name, of_type.span, shared)


INPUTS = ("odom", "pose", "twist", "imu")
_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)\Z")
# Words of AMCL until Galactic, which since then loads a plugin by its name.
_MODELS = {"differential": "nav2_amcl::DifferentialMotionModel", "omnidirectional": "nav2_amcl::OmniMotionModel"}
_OF_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)_")


def check_node(node: Node) -> Iterator[Diagnostic]:
    """Yield what is wrong with the keys and values of a node; of an unknown node only plugins without a type."""
    yield from _untyped(node)
    if node.kind is None:
        return
    plain = {name: one for name, one in node.parameters.items() if "$(" not in name and not one.substituted}
    values = {name: one.value for name, one in plain.items()}
    for name in node.shared:
        if name not in node.kind:
            values.pop(name, None)
    for found in against_kind(node.shown, node.kind, values):
        parameter = node.parameters[found.key]
        is_unknown = found.rule == "parameters-unknown-key" and node.kind.key(found.key) is None
        if is_unknown and isinstance(found.help, Suggestion) and found.help() == REMOVE:
            found = found._replace(severity=WARNING)  # no misspelt key: files of vendors have such ones
        yield found.at(parameter.key if found.at_key else parameter.span)
    model = node.parameters.get("robot_model_type")
    if model is not None and node.kind.name == "amcl" and str(model.value) in _MODELS:
        message = (
            f'"robot_model_type" of {node.shown} is "{model.value}", the word of Galactic: the node does not start'
        )
        yield error("parameters-wrong-value", message, model.span, f"write {_MODELS[str(model.value)]}")
    footprint = node.parameters.get("footprint")
    if footprint is not None and isinstance(footprint.value, str) and "footprint" in node.kind:
        yield from _footprint(node, footprint)
    if node.kind.name == "ekf":
        yield from _inputs(node)
        yield from _frames_differ(node)


def _untyped(node: Node) -> Iterator[Diagnostic]:
    for key, by_default in facts("ros2_nodes")["plugin_lists"].get(node.name, {}).items():
        given = node.parameters.get(key)
        if given is None or given.substituted or not isinstance(given.value, list):
            continue
        names = [one for one in given.value if isinstance(one, str) and one not in by_default]
        untyped = [one for one in names if f"{one}.plugin" not in node.parameters]
        if untyped:
            message = f'"{key}" of {node.shown} names {quoted(untyped, most=4)}, and their type is not set'
            help = f"{untyped[0]}: {{plugin: TYPE}}; the node does not start, unless another file says it"
            yield Diagnostic("parameters-wrong-value", WARNING, message, given.span, help=help)


_POINT = re.compile(r"\[\s*([^\[\],\s]+)[\s,]+([^\[\],\s]+)\s*\]")


def _footprint(node: Node, parameter: Parameter) -> Iterator[Diagnostic]:
    text = str(parameter.value)
    rest = _POINT.sub("", text.strip()[1:-1]).replace(",", "").strip()
    points = _POINT.findall(text)
    if text.strip() in ("", "[]") or (len(points) > 2 and not rest and text.strip()[:1] == "["):
        return
    message = f'"footprint" of {node.shown} is no polygon: the costmap goes on with robot_radius'
    yield error("parameters-wrong-value", message, parameter.span, 'write three points or more: "[[x, y], ...]"')


def _inputs(node: Node) -> Iterator[Diagnostic]:
    numbers: dict[str, set[int]] = {kind: set() for kind in INPUTS}
    for name in node.parameters:
        if match := _INPUT.match(name):
            numbers[match[1]].add(int(match[2]))
    for name, parameter in node.parameters.items():
        if match := _INPUT.match(name):
            missing = next((n for n in range(int(match[2])) if n not in numbers[match[1]]), None)
            if missing is not None:
                message = f'"{name}" of {node.shown} is never read: there is no {match[1]}{missing}'
                yield error("parameters-gap", message, parameter.key, f"number them from 0: {match[1]}{missing}")
            yield from _unused(node, name, parameter)
        elif (match := _OF_INPUT.match(name)) and int(match[2]) not in numbers[match[1]]:
            message = f'"{name}" of {node.shown} is never read: there is no {match[1]}{match[2]}, the topic'
            yield error("parameters-gap", message, parameter.key, f"add {match[1]}{match[2]}: TOPIC")


def _unused(node: Node, name: str, parameter: Parameter) -> Iterator[Diagnostic]:
    config = node.parameters.get(f"{name}_config")
    if config is None or (isinstance(config.value, list) and not any(config.value)):
        why = f"there is no {name}_config" if config is None else f"all of {name}_config is false"
        message = f'nothing of "{name}" of {node.shown} is used: {why}'
        place = parameter.key if config is None else config.span
        help = f"set what it measures in {name}_config, 15 booleans"
        yield Diagnostic("parameters-wrong-value", WARNING, message, place, help=help)


def _frames_differ(node: Node) -> Iterator[Diagnostic]:
    seen: dict[str, str] = {}
    for key in ("map_frame", "odom_frame", "base_link_frame"):
        setting = node.setting(key)
        if not isinstance(setting.value, str):
            continue  # unknown, or already reported
        if setting.value in seen:
            both = quoted((seen[setting.value], key))
            message = f'{both} of {node.shown} are both "{setting.value}": they have to differ'
            yield error("parameters-wrong-value", message, setting.span, "name the frames of the robot")
        seen.setdefault(setting.value, key)


def world_problem(node: Node, worlds: tuple[str, str]) -> Diagnostic | None:
    """Return that world_frame of an EKF is neither of the two that it may be; it publishes nothing then."""
    world = node.setting("world_frame")
    if not world.given or world.value is None or world.value in worlds:
        return None
    message = f'"world_frame" of {node.shown} is "{world.value}", neither its odom_frame nor its map_frame'
    help = Suggestion(str(world.value), worlds)
    return error("parameters-wrong-value", f"{message}: it publishes nothing", world.span, help)

"""The keys and values of nodes against what is known of them; footprints, and the inputs of the EKF."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, error, quoted

from ..parameters.checking import REMOVE, against_kind
from ..parameters.files import Parameter
from .nodes import Node

INPUTS = ("odom", "pose", "twist", "imu")
_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)\Z")
_LAYERS = {"plugins": ("static_layer", "obstacle_layer", "inflation_layer"), "filters": ()}
# Lists of plugins of Nav2, by node, with the names that have a type by default (nav2_*/src of Humble and Jazzy).
_PLUGINS: dict[str, dict[str, tuple[str, ...]]] = {
    "local_costmap": _LAYERS,
    "global_costmap": _LAYERS,
    "controller_server": {
        "controller_plugins": ("FollowPath",),
        "goal_checker_plugins": ("goal_checker",),
        "progress_checker_plugins": ("progress_checker",),
    },
    "planner_server": {"planner_plugins": ("GridBased",)},
    "smoother_server": {"smoother_plugins": ("simple_smoother",)},
    "behavior_server": {"behavior_plugins": ("spin", "backup", "drive_on_heading", "assisted_teleop", "wait")},
}
# Words of AMCL until Galactic, which since then loads a plugin by its name.
_MODELS = {"differential": "nav2_amcl::DifferentialMotionModel", "omnidirectional": "nav2_amcl::OmniMotionModel"}
_OF_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)_")


def check(node: Node) -> Iterator[Diagnostic]:
    """Yield what is wrong with the keys and values of a node; of one that nobody knows only plugins without a type."""
    yield from _untyped(node)
    if node.kind is None:
        return
    values = {name: one.value for name, one in node.parameters.items() if not one.substituted}
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
    for key, by_default in _PLUGINS.get(node.name, {}).items():
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
            continue  # nobody knows it, or it is told
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

"""The keys and values of nodes against what is known of them: keys, types, lengths, gaps in the inputs of the EKF."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ...diagnostics import WARNING, Diagnostic, did_you_mean, error, nearest
from ...diagnostics.registry import PARAMETERS, Rule
from ...diagnostics.wording import listed, quoted
from .files import Parameter
from .nodes import Node
from .tables import ANY_BELOW, ANY_NODE, Key, Kind, every

RULES = (
    Rule(
        "parameters-unknown-key",
        "A node does not know a key, or that of another distribution: it starts, and does not do what is written. A "
        "warning where only some keys of the node are known, and this is nearly one of them.",
        "Correct it.",
        PARAMETERS,
    ),
    Rule(
        "parameters-wrong-type",
        "A value has another type than its node takes: it throws when it starts. 1 is no double, 1.0 is one.",
        "Write it as that type.",
        PARAMETERS,
    ),
    Rule(
        "parameters-wrong-value",
        "A list has another length than its node takes, a text is none of those that it knows, frames are the same "
        "that have to differ. A warning where an input of the EKF uses nothing.",
        "As the message says.",
        PARAMETERS,
    ),
    Rule(
        "parameters-gap",
        "An input of the EKF is never read, for it reads odom0, odom1, ... up to the first number that is missing.",
        "Number the inputs from 0, without gaps.",
        PARAMETERS,
    ),
)

INPUTS = ("odom", "pose", "twist", "imu")
STATES = 15
_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)\Z")
_OF_INPUT = re.compile(rf"({'|'.join(INPUTS)})(\d+)_")


def check(node: Node, distribution: str) -> Iterator[Diagnostic]:
    """Yield what is wrong with the keys and values of a node; nothing of a node that nobody knows."""
    if node.kind is None:
        return
    for name, parameter in node.parameters.items():
        known = node.kind.key(name)
        if known is None:
            yield from _unknown(node, name, parameter, distribution)
        elif distribution and distribution not in known.only:
            having = listed(one.capitalize() for one in known.only)
            message = f'{node.shown} of {distribution.capitalize()} has no key "{name}"; {having} knows it'
            help = _near(node.kind, node, name, distribution) or "remove it"
            yield error("parameters-unknown-key", message, parameter.key, help)
        else:
            yield from _value(node, known, name, parameter)
    if node.kind.name == "ekf":
        yield from _inputs(node)
        yield from _frames_differ(node)


def _unknown(node: Node, name: str, parameter: Parameter, distribution: str) -> Iterator[Diagnostic]:
    """Yield that a key is unknown, where that can be said."""
    if node.kind is None or name in ANY_NODE or name.startswith(ANY_BELOW):
        return
    near = _near(node.kind, node, name, distribution)
    if node.kind.complete:
        message = f'{node.shown} has no key "{name}": it is accepted in silence, and does nothing'
        yield error("parameters-unknown-key", message, parameter.key, near or "remove it")
    elif near:
        message = f'"{name}" of {node.shown} is nearly a key that it has'
        yield Diagnostic("parameters-unknown-key", WARNING, message, parameter.key, help=near)


def _near(kind: Kind, node: Node, name: str, distribution: str) -> str:
    """Return "did you mean" for a key; of a node of which only some keys are known, only for one that is misspelt."""
    names = {key.name for key in every(kind, distribution) if not key.many}
    names -= set() if kind.complete else {*node.parameters}
    numbers = [one.group(2) for key in node.parameters if (one := _INPUT.match(key))]
    names |= {
        key.name.replace("<n>", number)
        for key in every(kind, distribution)
        for number in dict.fromkeys(numbers)
        if "<n>" in key.name
    }
    if kind.complete:
        near = did_you_mean(name, names)
        return near if near.startswith("did") else ""
    close = nearest(name, names)
    return f'did you mean "{close}"?' if close and _is_misspelt(name, close) else ""


def _is_misspelt(name: str, close: str) -> bool:
    """Say whether a key is another one with a slip: a letter or two of it, or its words joined otherwise."""
    import difflib

    one, other = name.replace("_", "").lower(), close.replace("_", "").lower()
    return one == other or (len(name) > 5 and difflib.SequenceMatcher(None, one, other).ratio() > 0.9)


def _value(node: Node, key: Key, name: str, parameter: Parameter) -> Iterator[Diagnostic]:
    """Yield what is wrong with a value of a known key."""
    if not _fits(parameter, key.type):
        has = f"is {_what(parameter)}, and has to be {_wanted(key.type)}"
        message = f'"{name}" of {node.shown} {has}: the node does not start'
        yield error("parameters-wrong-type", message, parameter.span, _as_type(parameter, key.type))
        return
    if key.lengths and isinstance(parameter.value, list) and len(parameter.value) not in key.lengths:
        wanted = " or ".join(map(str, key.lengths))
        message = f'"{name}" of {node.shown} has {len(parameter.value)} values, and needs {wanted}'
        yield error("parameters-wrong-value", message, parameter.span, _order(name, key))
    elif key.one_of and parameter.value not in key.one_of:
        message = f'"{name}" of {node.shown} cannot be "{parameter.value}"'
        yield error("parameters-wrong-value", message, parameter.span, did_you_mean(str(parameter.value), key.one_of))
    elif name == "footprint":
        yield from _footprint(node, parameter)


def _order(name: str, key: Key) -> str:
    if key.type == "bool_array" and key.lengths == (STATES,):
        return "x y z, roll pitch yaw, vx vy vz, vroll vpitch vyaw, ax ay az"
    rows = ", row by row" if name.endswith("covariance") else ""
    return f"write {' or '.join(map(str, key.lengths))} of them{rows}"


def _fits(parameter: Parameter, types: str) -> bool:
    words = types.split(" or ")
    return "none" in words or parameter.type in words or (not parameter.type and "_array" in types)


_WORDS = {"bool": "true or false", "int": "a whole number", "double": "a double", "string": "a text"}
_MANY = {"bool": "booleans", "int": "whole numbers", "double": "doubles", "string": "texts"}


def _what(parameter: Parameter) -> str:
    if not parameter.type:
        return "an empty list"
    base, _, many = parameter.type.partition("_")
    if many:
        return f"a list of {_MANY[base]}"
    shown = f'"{parameter.value}"' if base == "string" else str(parameter.value).lower()
    return f"{'the text ' if base == 'string' else ''}{shown}"


def _wanted(types: str) -> str:
    def one(kind: str) -> str:
        base, _, many = kind.partition("_")
        return f"a list of {_MANY[base]}" if many else _WORDS[base]

    return " or ".join(map(one, types.split(" or ")))


def _as_type(parameter: Parameter, types: str) -> str:
    """Return the way out for a value of the wrong type."""
    if parameter.type == "int" and types == "double":
        return f"write {parameter.value}.0"
    if parameter.type == "int_array" and types == "double_array":
        return "write every number with a point: 0.0"
    if parameter.type == "double" and types == "int":
        return "write a whole number"
    if parameter.type == "string" and types in ("double", "int", "bool"):
        return "write it without quotes"
    if types == "string" and parameter.type.endswith("_array"):
        return 'write the whole in quotes, as one text: "[[x, y], ...]"'
    return f"write {'[...]' if 'array' in types else 'the value in quotes' if types == 'string' else types}"


_POINT = re.compile(r"\[\s*([^\[\],\s]+)[\s,]+([^\[\],\s]+)\s*\]")


def _footprint(node: Node, parameter: Parameter) -> Iterator[Diagnostic]:
    """Yield that a footprint is none: the costmap goes on with a circle of robot_radius then."""
    text = str(parameter.value)
    rest = _POINT.sub("", text.strip()[1:-1]).replace(",", "").strip()
    points = _POINT.findall(text)
    if text.strip() in ("", "[]") or (len(points) > 2 and not rest and text.strip()[:1] == "["):
        return
    message = f'"footprint" of {node.shown} is no polygon: the costmap goes on with robot_radius'
    yield error("parameters-wrong-value", message, parameter.span, 'write three points or more: "[[x, y], ...]"')


def _inputs(node: Node) -> Iterator[Diagnostic]:
    """Yield gaps in the inputs of the EKF, and inputs of which nothing is used."""
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
    if config is None or (config.type == "bool_array" and not any(config.value)):
        why = f"there is no {name}_config" if config is None else f"all of {name}_config is false"
        message = f'nothing of "{name}" of {node.shown} is used: {why}'
        place = parameter.key if config is None else config.span
        help = f"set what it measures in {name}_config, 15 booleans"
        yield Diagnostic("parameters-wrong-value", WARNING, message, place, help=help)


def _frames_differ(node: Node) -> Iterator[Diagnostic]:
    """Yield frames of the EKF that are the same, though it wants them to differ; it says so and goes on."""
    seen: dict[str, str] = {}
    for key in ("map_frame", "odom_frame", "base_link_frame"):
        setting = node.setting(key)
        if setting.value in seen:
            both = quoted((seen[setting.value], key))
            message = f'{both} of {node.shown} are both "{setting.value}": they have to differ'
            yield error("parameters-wrong-value", message, setting.span, "name the frames of the robot")
        seen.setdefault(setting.value, key)


def world_problem(node: Node, worlds: tuple[str, str]) -> Diagnostic | None:
    """Return that world_frame of an EKF is neither of the two that it may be; it publishes nothing then."""
    world = node.setting("world_frame")
    if not world.given or world.value in worlds:
        return None
    message = f'"world_frame" of {node.shown} is "{world.value}", neither its odom_frame nor its map_frame'
    help = did_you_mean(str(world.value), worlds)
    return error("parameters-wrong-value", f"{message}: it publishes nothing", world.span, help)

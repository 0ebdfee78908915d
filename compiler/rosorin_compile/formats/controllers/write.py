"""The text of controllers.yaml: the controller_manager with the types of its controllers, and each with its parameters.

What the description gives goes before what the robot knows (``known``). Each number is written as its type wants it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ...diagnostics import NOTE, Diagnostic
from ...diagnostics.registry import CONTROL, Rule
from ...model import Output, Robot
from ..distributions import HUMBLE, JAZZY, title
from ..parameters.tables import MANAGER
from ..parameters.values import written
from ..templating import BUILTIN, Templates
from .filled import Filled, asked, filled, managed

RULES = (
    Rule(
        "controllers-later",
        "A note: the parameters of controllers are known up to Jazzy, and a later distribution is asked for.",
        "Nothing, as long as the controllers start.",
        CONTROL,
    ),
    Rule(
        "controllers-remap",
        "A note: a controller owns odom -> base, and publishes it beside /tf.",
        "Start it with the remap that the message names.",
        CONTROL,
    ),
)

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.:-]*")
_WORDS = frozenset(("y", "yes", "n", "no", "true", "false", "on", "off", "null", "nan", "inf", "infinity"))


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the controllers.yaml of a robot, for the distribution that the output asks for."""
    distribution = asked(output)
    controllers = filled(robot, distribution)
    types = {f"{one.controller.name}.type": one.type for one in controllers}
    nodes: list[tuple[str, Mapping[str, Any]]] = [(MANAGER, {**managed(output, distribution), **types})]
    nodes += [(one.controller.name, one.values) for one in controllers]
    space = str(output.options.get("namespace", "")).strip("/")
    rows = [(f"/{space}/{name}" if space else name, list(_rows(_nested(values)))) for name, values in nodes]
    said = str(output.options.get("distribution", JAZZY))
    values = {"robot": robot, "distribution": title(said), "nodes": [row for row in rows if row[1]]}
    text = templates.render(f"{BUILTIN}controllers.yaml.jinja", values)
    return text, [*_later(said), *_remaps(controllers, space)]


def _later(said: str) -> Iterator[Diagnostic]:
    if said not in (HUMBLE, JAZZY):
        message = f"what is known of controllers is that of Jazzy: {title(said)} is taken to be like it"
        yield Diagnostic("controllers-later", NOTE, message)


def _remaps(controllers: list[Filled], space: str) -> Iterator[Diagnostic]:
    for one in controllers:
        if one.kind is not None and one.kind.odometry.startswith("~") and one.values.get("enable_odom_tf"):
            name = f"/{space}/{one.controller.name}" if space else f"/{one.controller.name}"
            frames = f"{one.values.get('odom_frame_id', 'odom')} -> {one.values.get('base_frame_id', 'base_link')}"
            message = f'the controller "{one.controller.name}" publishes {frames} on {name}/tf_odometry, not on /tf'
            yield Diagnostic("controllers-remap", NOTE, message, help=f"start it with {name}/tf_odometry:=/tf")


def _nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters as mappings within mappings; an empty list is none, for rcl does not know of what."""
    tree: dict[str, Any] = {}
    for key, value in values.items():
        if value in ([], ()):
            continue
        *above, last = key.split(".")
        here = tree
        for word in above:
            here = here.setdefault(word, {})
            if not isinstance(here, dict):
                break
        else:
            here[last] = value
    return tree


def _rows(tree: Mapping[str, Any], depth: int = 0) -> Iterator[tuple[str, str, str]]:
    """Yield the lines of parameters: the indent, the key, the value (empty above others)."""
    for key, value in tree.items():
        indent = "  " * depth
        if isinstance(value, dict):
            yield indent, _text(key), ""
            yield from _rows(value, depth + 1)
        else:
            yield indent, _text(key), f" {_scalar(value)}"


def _scalar(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_scalar, value))}]"
    return _text(value) if isinstance(value, str) else written(value)


def _text(text: str) -> str:
    """Return a text so that YAML has no other idea of it."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS and not text.endswith(":"):
        return text
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'

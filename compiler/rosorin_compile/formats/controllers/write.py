"""The text of controllers.yaml: the controller_manager with the types of its controllers, and each with its parameters.

What the description gives goes before what the robot knows (``known``). Each number is written as its type wants it.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...diagnostics import NOTE, Diagnostic
from ...diagnostics.registry import CONTROL, Rule
from ...model import Output, Robot
from ..distributions import HUMBLE, JAZZY, known, title
from ..parameters import files
from ..parameters.files import Node, asked
from ..parameters.tables import MANAGER, manager
from ..templating import Templates
from .filled import Filled, filled, managed

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


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the controllers.yaml of a robot, for the distribution that the output asks for."""
    distribution = known(asked(output))
    controllers = filled(robot, distribution)
    types = {f"{one.controller.name}.type": one.type for one in controllers}
    space = str(output.options.get("namespace", "")).strip("/")
    nodes = [Node(MANAGER, manager(distribution), {**managed(output, distribution), **types})]
    nodes += [Node(one.controller.name, one.kind, one.values) for one in controllers]
    head = [f"Controllers of ros2_control, for {title(asked(output))}."]
    text = files.text(robot, output, templates, head, [one._replace(name=f"{space}/{one.name}") for one in nodes])
    return text, [*_later(asked(output)), *_remaps(controllers, space)]


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

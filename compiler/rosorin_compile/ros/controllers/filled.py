"""The controllers of a description with all their parameters, and the text of controllers.yaml.

What the description says goes before what the robot knows (``derived``). Each number is written as its type wants it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.formats.format import described_by as known_distribution
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Controller, Output, Robot
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

from ..parameters import files
from ..parameters.files import Node, asked
from ..parameters.tables import MANAGER, Kind, controller, converted, kinds
from ..ports import ODOMETRY, VELOCITY, full_type, port_of
from ..sections.controllers import flat
from .derived import Derived, derived

UPDATE_RATE = 100  # Hz
CONTROLLERS = "controllers"  # the backend
TF = "/tf"
COMMAND = "/cmd_vel"  # where Nav2 and most others send velocities
# Steering controllers of Jazzy call wheels by what they do, and keep the words of Humble for where they stand.
_LATER, _EARLIER = "traction_joints_names", ("front_wheel", "rear_wheel", "wheel_track")


class Filled(NamedTuple):
    """A controller with its type in full, all its parameters as they are written, and what the robot knows of them."""

    controller: Controller
    type: str
    values: Mapping[str, Any]
    known: Derived
    kind: Kind | None


def filled(robot: Robot, distribution: str) -> list[Filled]:
    """Return the controllers of a robot with all that is known of their parameters, for humble or jazzy."""
    made = []
    for one in robot.controllers:
        kind = full_type(one.type)
        found, knows = controller(kind, distribution), derived(robot, one, kind)
        values = {key: value for key, value in knows.values.items() if found is not None and key in found}
        if found is not None and _LATER in found:
            values = {key: value for key, value in values.items() if not key.startswith(_EARLIER)}
        values |= one.params
        made.append(Filled(one, kind, {key: _typed(found, key, value) for key, value in values.items()}, knows, found))
    return made


def distribution_of(robot: Robot, controllers: str) -> str:
    """Return the distribution, humble or jazzy, that the output ``controllers`` is for; without it, that of another."""
    said = sorted(robot.outputs, key=lambda one: one.name != controllers)
    words = (one.options.get("distribution") or one.options.get("control") for one in said)
    return known_distribution(str(next(filter(None, words), JAZZY)))


def managed(output: Output, distribution: str) -> dict[str, Any]:
    """Return the parameters of the controller_manager itself."""
    values = {
        "update_rate": output.options.get("update_rate", UPDATE_RATE),
        **flat(output.options.get("manager") or {}),
    }
    return {key: _typed(kinds(distribution)[MANAGER], key, value) for key, value in values.items()}


def _typed(found: Kind | None, key: str, value: Any) -> Any:
    entry = found.key(key) if found is not None else None
    if entry is not None:
        return converted(value, entry.type)
    return list(value) if isinstance(value, tuple) else value


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the controllers.yaml of a robot, for the distribution that the output asks for."""
    controllers = filled(robot, asked(output))
    head = [f"Controllers of ros2_control, for {asked(output).capitalize()}."]
    text = files.text(robot, output, templates, head, _nodes(output, controllers))
    return text, [*_later(asked(output)), *_remaps(controllers, _namespace(output))]


def view(robot: Robot, output: Output) -> files.Parameters:
    """Return what the controllers.yaml of a robot is meant to contain."""
    return files.parameters_of(output, _nodes(output, filled(robot, asked(output))))


def _namespace(output: Output) -> str:
    return str(output.options.get("namespace", "")).strip("/")


def _nodes(output: Output, controllers: Sequence[Filled]) -> list[Node]:
    distribution, space = known_distribution(asked(output)), _namespace(output)
    types = {f"{one.controller.name}.type": one.type for one in controllers}
    nodes = [Node(MANAGER, kinds(distribution)[MANAGER], {**managed(output, distribution), **types})]
    nodes += [Node(one.controller.name, one.kind, one.values) for one in controllers]
    return [one._replace(name=f"{space}/{one.name}") for one in nodes]


def _later(said: str) -> Iterator[Diagnostic]:
    if said not in (HUMBLE, JAZZY):
        message = f"what is known of controllers is that of Jazzy: {said.capitalize()} is taken to be like it"
        yield Diagnostic("controllers-later", NOTE, message)


def remaps(robot: Robot, output: Output) -> dict[str, list[tuple[str, str]]]:
    """Return the remaps, from and to, without which a controller of an output would not publish what it owns."""
    controllers = filled(robot, asked(output))
    return {one.controller.name: [("~/tf_odometry", "/tf")] for one in controllers if _is_beside(one)}


def _is_beside(one: Filled) -> bool:
    kind = one.kind
    return kind is not None and kind.odometry.startswith("~") and bool(one.values.get("enable_odom_tf"))


def _remaps(controllers: list[Filled], space: str) -> Iterator[Diagnostic]:
    for one in controllers:
        if _is_beside(one):
            name = f"/{space}/{one.controller.name}" if space else f"/{one.controller.name}"
            frames = f"{one.values.get('odom_frame_id', 'odom')} -> {one.values.get('base_frame_id', 'base_link')}"
            message = f'the controller "{one.controller.name}" publishes {frames} on {name}/tf_odometry, not on /tf'
            yield Diagnostic("controllers-remap", NOTE, message, help=f"start it with {name}/tf_odometry:=/tf")


class Driver(NamedTuple):
    """A controller of a drive as others reach it; topics begin with ~ for its name.

    ``space`` is its namespace, empty for none; ``stamped`` says that it takes TwistStamped, else Twist.
    """

    one: Filled
    space: str
    command: str
    odometry: str
    stamped: bool

    @property
    def name(self) -> str:
        """The name of the controller."""
        return self.one.controller.name

    def topic(self, own: str) -> str:
        """Return one of its topics as nodes outside of its namespace reach it."""
        return f"{f'/{self.space}/' if self.space else ''}{self.name}{own.removeprefix('~')}"


def drivers(robot: Robot) -> list[Driver]:
    """Return the controllers of a drive, those that are started active first; none without an output for them."""
    output = next((one for one in robot.outputs if one.backend == CONTROLLERS), None)
    if output is None or not is_whole(robot):
        return []
    space = str(output.options.get("namespace", "")).strip("/")
    distribution, found = asked(output), []
    for one in filled(robot, distribution):
        command, odometry = (port_of(one.type, distribution, role) for role in (VELOCITY, ODOMETRY))
        if command is not None and odometry is not None:
            stamped = command.is_stamped(one.values)
            found.append(Driver(one, space, command.name(one.values), odometry.topic, stamped))
    return sorted(found, key=lambda driver: driver.one.controller.inactive)


def is_whole(robot: Robot) -> bool:
    """Return True if the joints and the frame of the drive exist."""
    drive = robot.drive
    if drive is None:
        return True
    names = [name for names in drive.joints.values() for name in names]
    return all(name in robot.joint for name in names) and (not drive.frame or drive.frame in robot.link)


def intended_topic(topic: str, published: Mapping[str, str]) -> str:
    """Return the odometry topic of the controller whose name ``topic`` begins with; empty if it is ``topic`` itself.

    ``published`` has the odometry topics by name of the controller. Topics of other nodes give an empty text, too.
    """
    meant = published.get(topic.strip("/").rpartition("/")[0], "")
    return meant if meant.strip("/") != topic.strip("/") else ""

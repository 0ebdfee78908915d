"""Topics of the controllers of a drive: where each takes velocities, in which message, and where it has its odometry.

Source: ``ros-controls/ros2_controllers@{humble, jazzy}: */src/*_controller.cpp``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rosorin_compile.model import Robot

from ..parameters.files import asked
from ..ports import ODOMETRY, VELOCITY, port_of
from .filled import Filled, filled

CONTROLLERS = "controllers"  # the backend
TF = "/tf"
COMMAND = "/cmd_vel"  # where Nav2 and most others send velocities


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
    if output is None or not _is_whole(robot):
        return []
    space = str(output.options.get("namespace", "")).strip("/")
    distribution, found = asked(output), []
    for one in filled(robot, distribution):
        command, odometry = (port_of(one.type, distribution, role) for role in (VELOCITY, ODOMETRY))
        if command is not None and odometry is not None:
            stamped = command.is_stamped(one.values)
            found.append(Driver(one, space, command.name(one.values), odometry.topic, stamped))
    return sorted(found, key=lambda driver: driver.one.controller.inactive)


def _is_whole(robot: Robot) -> bool:
    drive = robot.drive
    if drive is None:
        return True
    names = [name for names in drive.joints.values() for name in names]
    return all(name in robot.joint for name in names) and (not drive.frame or drive.frame in robot.link)


def odometry_of(kind: str) -> str:
    """Return the odometry topic of a type of controllers, as ~/odom; empty if the type drives no base."""
    port = port_of(kind, "", ODOMETRY)
    return port.topic if port is not None else ""


def is_of_nobody(topic: str, published: Mapping[str, str]) -> str:
    """Return the topic that is meant by one that is below the name of a controller which does not publish it.

    ``published`` are the topics of the odometry by names of controllers; a topic of others is nobody's to judge.
    """
    meant = published.get(topic.strip("/").rpartition("/")[0], "")
    return meant if meant.strip("/") != topic.strip("/") else ""

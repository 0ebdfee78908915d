"""Views: what the RViz configuration of a package shows, in RViz's own names for Humble and Jazzy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from ..model import Robot

# What shows the messages of a sensor of a type: a class of rviz_default_plugins and the type of its messages.
DISPLAYS: Mapping[str, str] = {
    "lidar_2d": "LaserScan",
    "lidar_3d": "PointCloud2",
    "camera": "Image",
    "depth_camera": "PointCloud2",
    "range_finder": "Range",
}
_SMALLEST = 0.2


class Display(NamedTuple):
    """A display of RViz: its class, its name, and its topic; without a topic it is switched off."""

    kind: str
    name: str
    topic: str


def displays(robot: Robot, topics: Mapping[str, str]) -> list[Display]:
    """Return the displays of the sensors of a robot; ``topics`` by the name of the sensor, as far as they are known."""
    displays = []
    for sensor in robot.sensors:
        kind = DISPLAYS.get(sensor.type)
        if kind is not None:
            topic = topics.get(sensor.name, "")
            displays.append(Display(kind, sensor.name if topic else f"{sensor.name} (choose its topic)", topic))
    return displays


def reach(robot: Robot, links: Iterable[str]) -> float:
    """Return the largest distance of a frame from the root of a robot (m, all joints at zero), 0.2 at least."""
    root = robot.root
    return max([_SMALLEST, *(math.hypot(*robot.transform(root, link, {}).xyz) for link in links)])


def round_number(value: float) -> float:
    """Return a number rounded to one digit, so that small changes of a robot leave its view as it is.

    >>> round_number(0.234), round_number(17.0)
    (0.2, 20.0)
    """
    return float(f"{value:.1g}")

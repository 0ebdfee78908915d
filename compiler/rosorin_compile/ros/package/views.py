"""Views: what the configuration of RViz shows of a robot, and the topics in one that was made."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.source import files
from rosorin_compile.source.load import yaml_of

# What shows the messages of a sensor of a type: a class of rviz_default_plugins and the type of its messages.
DISPLAYS: Mapping[str, str] = {
    "lidar_2d": "LaserScan",
    "lidar_3d": "PointCloud2",
    "camera": "Image",
    "depth_camera": "PointCloud2",
    "range_finder": "Range",
}
_SMALLEST = 0.2


def view(robot: Robot, topics: Mapping[str, str]) -> dict[str, Any]:
    """Return what the RViz configuration needs: its fixed frame is the root of the URDF."""
    joints = robot.in_urdf()
    links = dict.fromkeys([joint.parent for joint in joints] + [joint.child for joint in joints])
    children = {joint.child for joint in joints}
    root = next((link for link in links if link not in children), robot.root)
    size = round_number(reach(robot, links))
    return {
        "fixed_frame": root,
        "displays": displays(robot, topics),
        "visual": any(robot.link[link].visual for link in links or [root]),
        "size": round_number(size / 2),
        "scale": min(1.0, size),
        "distance": round_number(3 * size),
    }


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


def topics_of(target: Path, sensors: set[str]) -> dict[str, str]:
    """Return the topics by sensor of the view that was made for RViz; none if it cannot be read."""
    topics: dict[str, str] = {}
    for path in sorted(target.glob("rviz/*.rviz")):
        try:
            view = yaml_of(files.read_bytes(path).decode("utf-8", "replace"))
            for display in view["Visualization Manager"]["Displays"]:
                topic = display.get("Topic", {}).get("Value")
                if display.get("Name") in sensors and isinstance(topic, str) and topic:
                    topics[display["Name"]] = topic
        except (ValueError, AttributeError, KeyError, TypeError):
            continue
    return topics

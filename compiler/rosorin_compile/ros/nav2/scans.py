"""What localisation has to know of the sensors of a robot: which topic has the scan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.model import Output, Robot

from ..navigation import Frames, stated_topic

PLANAR = "lidar_2d"


def topic_of(robot: Robot, source: Mapping[str, Any]) -> str:
    """Return the topic of an observation source; empty if nobody says it."""
    return str(source.get("topic") or stated_topic(robot, source["sensor"]))


def seen_by_slam(robot: Robot, output: Output, frames: Frames) -> dict[str, Any]:
    """Return what slam_toolbox has to know of a robot: its frames, and the topic of the scan."""
    values = {"map_frame": frames.map, "odom_frame": frames.odom, "base_frame": frames.moved}
    return values | scan_topic(robot, output)


def scan_topic(robot: Robot, output: Output) -> dict[str, Any]:
    """Return the parameter that says where the scan is, if that is known."""
    scan = _scan(robot, output)
    return {"scan_topic": scan} if scan else {}


def _scan(robot: Robot, output: Output) -> str:
    """Return the topic of the only lidar of one plane, if the description says it; else nothing."""
    lidars = [sensor.name for sensor in robot.sensors if sensor.type == PLANAR]
    sources: Sequence[Mapping[str, Any]] = list((output.options.get("sources") or {}).values())
    topics = {topic_of(robot, source) for source in sources if source["sensor"] in lidars}
    topics |= {stated_topic(robot, lidars[0])} if len(lidars) == 1 and not topics else set()
    return topics.pop() if len(topics) == 1 else ""

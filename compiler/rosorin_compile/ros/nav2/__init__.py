"""nav2: what Nav2, AMCL and slam_toolbox have to know of a robot, as a parameter file to be loaded after one's own.

It has the frames, the footprint, how high the robot is, and who publishes map -> odom: what the description knows, and
no tuning. ``write`` makes it, ``known`` says what goes into it.
"""

from __future__ import annotations

from typing import Any

from rosorin_compile.formats.format import Format

from ..parameters import DISTRIBUTION, read, syntax
from . import write

__all__ = ["FORMAT"]


_LAYER: dict[str, Any] = {"type": "string", "minLength": 1}

FORMAT = Format(
    name="nav2",
    word="parameter file for Nav2",
    article="a",
    about="frames, footprint and height of the robot for Nav2, AMCL and slam_toolbox",
    rank=62,
    covers=("robot", "edges.parent", "edges.child"),
    options={
        "distribution": DISTRIBUTION,
        "pose": {
            "type": "string",
            "description": "The pose that the footprint is taken in; default: all joints at zero.",
        },
        "corners": {
            "type": "integer",
            "minimum": 4,
            "description": "The most corners that the footprint may have; default 12.",
        },
        "outline": {
            "enum": ["polygon", "circle"],
            "description": "polygon (default): a footprint; circle: a radius around the base frame.",
        },
        "padding": {
            "type": "number",
            "x-unit": "m",
            "minimum": 0,
            "description": "footprint_padding, in m; default: that of Nav2.",
        },
        "base_frame": {
            "type": "string",
            "description": "The frame that the robot is at for Nav2; default: the one that the odometry moves.",
        },
        "odom_frame": {
            "type": "string",
            "description": "The frame of the odometry, where the description has several.",
        },
        "map_frame": {"type": "string", "description": "The frame of the map, where the description has several."},
        "clearance": {
            "type": "number",
            "x-unit": "m",
            "minimum": 0,
            "description": "What the robot drives over, in m above the floor: what is lower is no obstacle; default 0.",
        },
        "headroom": {
            "type": "number",
            "x-unit": "m",
            "minimum": 0,
            "description": "What has to be free above the robot, in m: what is higher is no obstacle; default 0.1.",
        },
        "layers": {
            "type": "object",
            "description": "The layers that see obstacles; default: those of Nav2's own parameters.",
            "properties": {
                "local_costmap": {**_LAYER, "description": "That of the local costmap; default voxel_layer."},
                "global_costmap": {**_LAYER, "description": "That of the global costmap; default obstacle_layer."},
            },
            "additionalProperties": False,
        },
        "sources": {
            "type": "object",
            "description": "The sensors that these layers see by, by the names of the observation sources.",
            "additionalProperties": {
                "type": "object",
                "description": "A sensor that sees obstacles: lidar_2d, lidar_3d or depth_camera.",
                "properties": {
                    "sensor": {"type": "string", "description": "The sensor, by its name."},
                    "topic": {
                        "type": "string",
                        "minLength": 1,
                        "description": "Its topic; default: that of the sensor, if it has one.",
                    },
                },
                "required": ["sensor"],
                "additionalProperties": False,
            },
        },
    },
    file="nav2.yaml",
    check=write.check,
    write=write.write,
    view=write.view,
    read=read,
    measures=True,
    names_robot=False,
    syntax=syntax,
    folder="config",
    deploys=True,
)

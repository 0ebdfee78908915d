"""robot_localization: what a filter (EKF or UKF) of robot_localization has to know of a robot, as a parameter file.

It has the frames, whether the filter publishes its transform, and what of each input it uses, which follows from the
drive unless the output says otherwise. ``write`` makes it.
"""

from __future__ import annotations

from rosorin_compile.formats.format import Format

from ..parameters import DISTRIBUTION, read, syntax
from . import write

__all__ = ["FORMAT"]

FORMAT = Format(
    name="robot_localization",
    word="parameter file for robot_localization",
    article="a",
    about="frames, ownership and inputs of an EKF",
    rank=63,
    covers=("robot", "edges.parent", "edges.child", "edges.publisher", "publishers.node"),
    options={
        "distribution": DISTRIBUTION,
        "node": {
            "type": "string",
            "description": "The filter, by the name of its node; default: the only one of robot_localization.",
        },
        "odom_frame": {
            "type": "string",
            "description": "The frame of the odometry, where the description has several.",
        },
        "map_frame": {"type": "string", "description": "The frame of the map, where the description has several."},
        "two_d_mode": {
            "type": "boolean",
            "description": "Whether the robot is taken to stay in a plane; default: true, if it has a drive.",
        },
        "frequency": {
            "type": "number",
            "x-unit": "Hz",
            "exclusiveMinimum": 0,
            "description": "How often the filter estimates, in Hz; default: that of the filter.",
        },
        "inputs": {
            "type": "object",
            "description": "What the filter listens to: odom0, odom1, ..., pose0, twist0, imu0, ...",
            "additionalProperties": {
                "type": "object",
                "description": "A topic, and what of its messages the filter uses.",
                "properties": {
                    "topic": {
                        "type": "string",
                        "minLength": 1,
                        "description": "The topic; default: that of the sensor, if it has one.",
                    },
                    "sensor": {"type": "string", "description": "The IMU, by its name; default: the only one."},
                    "uses": {
                        "type": "array",
                        "items": {"enum": list(write.STATES)},
                        "description": "What of it the filter uses; default with a drive: vx, vy and vyaw of odomN and"
                        " twistN, vyaw of imuN.",
                    },
                    "differential": {"type": "boolean", "description": "Whether poses are used by how they change."},
                    "relative": {"type": "boolean", "description": "Whether poses count from the first one on."},
                    "queue_size": {"type": "integer", "minimum": 1, "description": "How many messages may wait."},
                    "remove_gravitational_acceleration": {
                        "type": "boolean",
                        "description": "Whether gravity is taken off the accelerations of imuN.",
                    },
                },
                "additionalProperties": False,
            },
        },
    },
    file="ekf.yaml",
    check=write.check,
    write=write.write,
    view=write.view,
    read=read,
    names_robot=False,
    syntax=syntax,
    folder="config",
    deploys=True,
)

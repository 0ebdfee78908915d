"""nav2: what Nav2, AMCL and slam_toolbox have to know of a robot, as a parameter file to be loaded after one's own.

It has the frames, the footprint, how high the robot is, and who publishes map -> odom: what the description knows, and
no tuning. ``write`` makes it, ``known`` says what goes into it.
"""

from __future__ import annotations

from ..parameters import parameter_file
from . import write

__all__ = ["FORMAT"]


FORMAT = parameter_file(
    "nav2",
    word="parameter file for Nav2",
    about="frames, footprint and height of the robot for Nav2, AMCL and slam_toolbox",
    rank=62,
    covers=("robot", "edges.parent", "edges.child"),
    file="nav2.yaml",
    check=write.check,
    write=write.write,
    view=write.view,
    measures=True,
)

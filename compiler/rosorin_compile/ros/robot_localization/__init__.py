"""robot_localization: what a filter (EKF or UKF) of robot_localization has to know of a robot, as a parameter file.

It has the frames, whether the filter publishes its transform, and what of each input it uses, which follows from the
drive unless the output says otherwise. ``write`` makes it.
"""

from __future__ import annotations

from rosorin_compile.formats.format import Format

from ..parameters import options_of, read, syntax
from . import write

__all__ = ["FORMAT"]

FORMAT = Format(
    name="robot_localization",
    word="parameter file for robot_localization",
    article="a",
    about="frames, ownership and inputs of an EKF",
    rank=63,
    covers=("robot", "edges.parent", "edges.child", "edges.publisher", "publishers.node"),
    options=options_of("robot_localization"),
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

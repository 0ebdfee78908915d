"""MJCF: the robot for MuJoCo.

Written by ``write`` and ``write_sensors``, after ``unsaid`` and ``masses`` have told what MuJoCo would refuse;
``facts`` reads such a file back for comparison, and ``process`` asks MuJoCo whether it loads it. ``bodies`` is what
both sides know: names, welded links, excluded contacts.

Foreign files are read by MuJoCo itself in a child process; the text is read for the places. In this order: ``robot``
(the file as a whole), ``process`` and ``engine`` (MuJoCo is asked), ``source`` and ``reading`` (the text, and what is
known so far); then ``links``, ``joints``, ``actuators``, ``shapes`` and ``sections``, which fill the tree; last
``left_out``, which lists what is not carried.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..format import NUMBER_FORMAT, Asked, Fact, Facts, Format, Opened

if TYPE_CHECKING:
    from pathlib import Path

    from ...diagnostics import Diagnostic
    from ...frontend.tree import Map
    from ...model import Output, Robot, Shape
    from ..imported import Imported
    from ..templating import Templates

__all__ = ["FORMAT"]


def _write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    from .write import write

    return write(robot, output, templates)


def _read(opened: Opened) -> Imported:
    from .robot import read_mjcf  # the child process imports this package too, and needs no reader

    return read_mjcf(opened.path, opened.options)


def _facts(text: str) -> Facts:
    from .facts import read

    return read(text)


def _syntax(text: str) -> object:
    from ...xml.elements import canonical, tree_of

    return canonical(tree_of(text))


def _refusal(text: str, folder: Path) -> str:
    from .process import refusal

    return refusal(text, folder, by_itself=not _FILE.search(text))


def _solids(robot: Robot, link: str, output: Output, carried: frozenset[str]) -> Sequence[Shape]:  # noqa: ARG001
    from .unsaid import has_volume

    return [solid for shape in robot.link[link].collision for solid in shape.solids() if has_volume(solid.geometry)]


def _cannot_say(robot: Robot, fact: Fact) -> bool:
    """Say whether a fact is the type of a joint that MJCF tells from another one by its range alone."""
    if (fact.kind, fact.quantity) != ("joint", "type"):
        return False
    from .unsaid import position_range

    joint = robot.joint[fact.name]
    return joint.type == "revolute" and position_range(joint) is None


def _adds(robot: Robot, name: str, described: Robot) -> bool:
    """Say whether a frame of a simulation is a site or a camera that a sensor of the description has there."""
    link, joint = robot.link[name], robot.joint_to.get(name)
    if link.inertial or link.visual or link.collision or joint is None or not joint.is_fixed:
        return False
    made = [element for sensor in described.sensors for element in sensor.simulated]
    return any(name in (one.name, one.site) or (one.replicas and name.startswith(f"{one.name}_")) for one in made)


_FILE = re.compile(r'<(?:mesh|texture|hfield)\b[^<>]*?\bfile="([^"]*)"')


def _asked(tree: Map, version: str, name: str) -> Asked:  # noqa: ARG001
    wishes = (tree.get("outputs") or {}).get("mjcf") or {}  # of the source: how its base stands in the world
    return Asked({"file": f"{name}.xml", **{key: value for key, value in wishes.items() if key != "file"}})


FORMAT = Format(
    name="mjcf",
    word="MJCF",
    about="the model for MuJoCo",
    rank=30,
    options={
        "number_format": NUMBER_FORMAT,
        "base": {
            "enum": ["fixed", "free"],
            "description": "fixed (default): held in the world at the root link; free: free to move.",
        },
    },
    file="{}.xml",
    endings=(".xml", ".mjcf"),
    roots=("mujoco",),
    write=_write,
    read=_read,
    facts=_facts,
    syntax=_syntax,
    refusal=_refusal,
    frames=lambda robot: [joint.child for joint in robot.joints],
    solids=_solids,
    all_solids=True,
    cannot_say=_cannot_say,
    complete=True,
    lacks=frozenset(
        {"velocity", "calibration", "safety", "servo", "sensor", "publisher", "edge", "fixed joint name"}
        | {"urdf_elements"}
    ),
    adds=_adds,
    why="a simulation has sites and cameras of its own for the sensors of a description",
    folder="mjcf",
    beside=_FILE.findall,
    asked=_asked,
    optional=True,
)

"""MJCF: the robot for MuJoCo.

Writing: ``write`` with ``write_joints``, ``write_simulation`` and ``write_sensors``; ``omissions`` and ``masses``
report what MuJoCo would refuse, ``mjx`` what MJX does not load. ``bodies`` has names and welded links, ``contacts``
which links may touch, ``masks`` the bits of shapes, ``height_fields`` what height maps become. ``read_back`` reads
such a file for comparison, and ``process`` lets MuJoCo load it.

Reading: MuJoCo reads foreign files in a child process (``process``, ``engine``, ``resolved``); ``broken`` explains
what it refuses. ``source`` finds the places in the text, ``reading`` has the state, and ``robot`` fills the tree with
``links``, ``joints``, ``actuators``, ``shapes``, ``entries`` and ``poses``.

``proof`` compares an imported MJCF with the source in a child process: ``compiled_model`` and ``compare_models``
compare both models field by field, ``accelerations`` compares their motion.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rosorin_compile.formats.format import (
    BOXES_OF_HEIGHT_MAPS,
    FORMS_OF_BOXES,
    NUMBER_FORMAT,
    Asked,
    Format,
    Opened,
    xml_syntax,
)
from rosorin_compile.formats.unsupported import MODEL_KEYS, OF_PUBLISHERS, Unsupported
from rosorin_compile.source.files import record, version

from .settings import SETTINGS

if TYPE_CHECKING:
    from pathlib import Path

    from rosorin_compile.formats.format import Refusal
    from rosorin_compile.formats.imported import Imported, Proof
    from rosorin_compile.formats.mesh_files import Searched
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.tree import Map

    from .read_back import Mjcf

__all__ = ["FORMAT"]


def _read(opened: Opened) -> Imported:
    from .robot import read_mjcf

    return read_mjcf(opened.path, opened.options)


def _check(case: Case, output: Output) -> Iterator[Diagnostic]:
    from . import mjx, servos

    yield from servos.check(case, output)
    yield from mjx.check(case, output)


def _copies(searched: Searched, outputs: Path) -> Searched:
    from ..mesh_copies import copy_meshes

    return copy_meshes(searched, outputs)


def _refusal(text: str, folder: Path) -> Refusal:
    from xml.sax.saxutils import unescape

    from .process import refusal

    names = _FILE.findall(text)
    for name in names:
        file = folder / unescape(name, {"&quot;": '"'})
        record(file, version(file))
    return refusal(text, folder, by_itself=not names)


def _adds(robot: Robot, name: str, described: Robot) -> bool:
    """Say whether a frame of a simulation is a site or a camera that a sensor of the description has there."""
    link, joint = robot.link[name], robot.joint_to.get(name)
    if link.inertial or link.visual or link.collision or joint is None or not joint.is_fixed:
        return False
    made = [element for sensor in described.sensors for element in sensor.simulated]
    return any(name in (one.name, one.site) or (one.replicas and name.startswith(f"{one.name}_")) for one in made)


def _opens(file: str) -> str:
    from .omissions import mesh_path, texture_path

    return mesh_path(file) or texture_path(file)


_FILE = re.compile(r'<(?:mesh|texture|hfield)\b[^<>]*?\bfile="([^"]*)"')


# MuJoCo's own word where a file has none: what it does with a URDF too.
_ITS_OWN = {"integrator": "Euler"}


def _asked(tree: Map, version: str, name: str) -> Asked:  # noqa: ARG001
    wishes = (tree.get("outputs") or {}).get("mjcf") or {}  # of the source: how its base stands in the world
    option = {} if "drives" in wishes else {"option": wishes.get("option", _ITS_OWN)}
    return Asked({"file": "", **wishes, **option} | {"file": f"{name}.xml"})


_GROUP = {"type": "integer", "minimum": 0, "maximum": 5}


def _write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    from .write import write

    return write(robot, output, templates)


def _view(robot: Robot, output: Output) -> Mjcf:
    from .read_back import view

    return view(robot, output)


def _read_back(text: str) -> Mjcf:
    from .read_back import read

    return read(text)


def _prove(imported: Imported, text: str, files: Mapping[str, str]) -> Proof:
    from .proof import prove

    return prove(imported, text, files)


_NO_JOINT = Unsupported("bodies that are fixed to each other need no joint", quiet=True)
_UNSUPPORTED = {
    **OF_PUBLISHERS,
    "sensors.*.joint": _NO_JOINT,
    "sensors.*.optical.joint": _NO_JOINT,
    "joints.*.calibration": Unsupported("no calibration of joints"),
    "joints.*.safety_controller": Unsupported("no soft limits"),
    "joints.*.limit.velocity": Unsupported("it decides on drives alone", one_way=True),
    "root": Unsupported("worlds are not read", one_way=True),
}

FORMAT = Format(
    name="mjcf",
    word="MJCF",
    about="the model for MuJoCo",
    rank=30,
    covers=(*MODEL_KEYS, "poses", "mjcf"),
    unsupported=_UNSUPPORTED,
    options={
        "number_format": NUMBER_FORMAT,
        "base": {
            "enum": ["fixed", "free"],
            "description": "fixed: held in the world at the root link; free: free to move."
            " Default: free, if the robot has a drive.",
        },
        "option": {
            "type": "object",
            "description": "Settings of the simulation, in MuJoCo's words and SI units; default: integrator"
            " implicitfast; for what is free or drives also cone elliptic, and on rollers or feet impratio 100.",
            "properties": SETTINGS,
            "additionalProperties": False,
        },
        "visuals": {
            "enum": ["own", "from_collision"],
            "description": "What is seen of links without visuals: nothing (own), or their collision shapes, in one"
            " colour a link. Default: from_collision, if no link has a visual.",
        },
        "mesh_inertia": {
            "enum": ["convex", "exact", "legacy", "shell"],
            "description": "What MuJoCo takes meshes for that do not say it; default: shell, which may be thin or open."
            " Masses are those of the description in any case.",
        },
        "height_maps": {
            "enum": [*FORMS_OF_BOXES, "hfield"],
            "description": f"What height maps are; default: merged. Boxes: {BOXES_OF_HEIGHT_MAPS}; hfield: a height"
            " field, which does not collide with planes.",
        },
        "contacts": {
            "enum": ["implied", "described"],
            "description": "Who does not touch whom; default: implied, which is links that a joint connects, and those"
            " that touch wherever it is, with disabled_contacts; described: disabled_contacts alone,"
            " and what MuJoCo does by itself.",
        },
        "groups": {
            "type": "object",
            "description": "The groups by which viewers show and hide geoms, of visuals and of what collides.",
            "properties": {
                "visual": {**_GROUP, "description": "That of visuals; default 2."},
                "collision": {**_GROUP, "description": "That of what collides; default 3, of a robot without looks 0."},
            },
            "additionalProperties": False,
        },
        "actuators": {
            "type": "array",
            "items": {"type": "string"},
            "description": "The order of the actuators, by name; default: that of their joints.",
        },
        "drives": {
            "enum": ["position", "velocity", "none"],
            "description": "Servos for joints that no actuator moves, with gains from what they carry: for the position"
            " of joints with limits and the speed of others (position), or for all speeds (velocity). Default: none.",
        },
    },
    file="{}.xml",
    endings=(".xml", ".mjcf"),
    roots=("mujoco",),
    check=_check,
    write=_write,
    load=_read,
    view=_view,
    partial=True,
    read=_read_back,
    asked=_asked,
    optional=True,
    adds=_adds,
    why="a simulation has sites and cameras of its own for the sensors of a description",
    beside=lambda text: _FILE.findall(text),
    opens=_opens,
    copies=_copies,
    syntax=xml_syntax,
    refusal=_refusal,
    prove=_prove,
    engine_reads=True,
    folder="mjcf",
)

"""SDF: the robot for Gazebo and Drake.

Written by ``write``, from which links are bodies and which are frames (``bodies``), and from what a description keeps
for Gazebo (``kept``).

Foreign files are read, in this order, by ``robot`` (the file as a whole), ``scopes`` (models within models, and what a
name stands for), ``reading`` (numbers and poses), ``trees`` (what hangs on what), ``read_links``, ``read_joints`` and
``verbatim`` (what stays as it stands). ``words`` is what both sides know, ``grammar`` what both readers know.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.formats.format import (
    BOXES_OF_HEIGHT_MAPS,
    FORMS_OF_BOXES,
    NUMBER_FORMAT,
    Asked,
    Format,
)
from rosorin_compile.formats.unsupported import MODEL_KEYS, OF_MUJOCO, OF_PUBLISHERS, Unsupported

if TYPE_CHECKING:
    from rosorin_compile.formats.format import Opened
    from rosorin_compile.formats.imported import Imported
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.tree import Map

__all__ = ["FORMAT"]


def _asked(tree: Map, version: str, name: str) -> Asked | None:  # noqa: ARG001
    """Return the output of a robot that comes of an SDF; others are not asked for one."""
    wishes = (tree.get("outputs") or {}).get("sdf")
    return None if wishes is None else Asked({"file": "", **wishes} | {"file": f"{name}.sdf"})


def _syntax(text: str) -> object:
    from rosorin_compile.source.xml.elements import canonical, tree_of

    return canonical(tree_of(text))


def _view(robot: Robot, output: Output) -> Robot:
    from .content import view

    return view(robot, output)


def _check(case: Case, output: Output) -> Iterator[Diagnostic]:
    from .content import check

    return check(case, output)


def _read(opened: Opened) -> Imported:
    from .read import read_sdf

    return read_sdf(opened)


def _write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    from .write import write

    return write(robot, output, templates)


def _read_back(text: str) -> Robot:
    from .read import read

    return read(text)


_UNSUPPORTED = {
    **OF_MUJOCO,
    **OF_PUBLISHERS,
    "sensors.*.joint": Unsupported("links that are fixed to each other need no joint", quiet=True),
    "sensors.*.optical.joint": Unsupported("links that are fixed to each other need no joint", quiet=True),
    "disabled_contacts.*": Unsupported("no pairs of links that do not collide"),
    "tendons": Unsupported("no tendons"),
    "joints.*.calibration": Unsupported("no calibration of joints"),
    "joints.*.safety_controller": Unsupported("no soft limits"),
}


FORMAT = Format(
    name="sdf",
    word="SDF",
    article="an",
    about="the model for Gazebo and Drake",
    rank=22,
    covers=(
        *MODEL_KEYS,
        "urdf_elements",
    ),
    unsupported=_UNSUPPORTED,
    options={
        "number_format": NUMBER_FORMAT,
        "version": {
            "enum": ["1.9", "1.10", "1.11", "1.12", 1.9, 1.1, 1.11, 1.12],
            "description": "Version of the format; default: 1.9, or 1.11 if a joint follows another. Fortress reads up"
            " to 1.9, Harmonic up to 1.11, Ionic and Drake 1.12.",
        },
        "height_maps": {
            "enum": FORMS_OF_BOXES,
            "description": f"The boxes of height maps; default: rows. {BOXES_OF_HEIGHT_MAPS}.",
        },
        "visuals": {
            "enum": ["from_collision"],
            "description": "from_collision: a link without a visual is seen as its collision shapes, a colour a link.",
        },
        "gazebo": {
            "enum": [True, False, "harmonic", "fortress", "classic"],
            "description": "The sensors, and who reads them: true or harmonic, fortress, with the frame of their"
            " messages in its word, which Drake refuses; classic: by its names; false: none. Default: sensors in the"
            " words of SDF alone.",
        },
    },
    file="{}.sdf",
    endings=(".sdf",),
    roots=("sdf",),
    check=_check,
    write=_write,
    load=_read,
    view=_view,
    partial=True,
    read=_read_back,
    asked=_asked,
    lacks=frozenset(
        {"armature", "calibration", "safety", "simulation", "actuator", "pose", "servo", "sensor", "contact"}
        | {"publisher", "edge", "drive", "fixed joint name", "urdf_elements"}
    ),
    meshes=True,
    syntax=_syntax,
    folder="sdf",
    deploys=True,
)

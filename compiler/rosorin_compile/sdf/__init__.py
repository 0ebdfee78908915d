"""SDF, the format of Gazebo and Drake.

``content`` determines which links become links or frames, ``write`` formats the file. ``read`` imports an SDF, with
``models`` for numbers, poses, includes, nested models and names, and ``read_joints`` for joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats import format
from rosorin_compile.formats.format import Format, OutputEntry, Unsupported, xml_syntax
from rosorin_compile.formats.gazebo import unsupported_drives

if TYPE_CHECKING:
    from rosorin_compile.model import Output
    from rosorin_compile.source.tree import Map


def _call(module: str, name: str, *arguments: Any) -> Any:
    return getattr(import_module(f"{__name__}.{module}"), name)(*arguments)


def _asked(tree: Map, version: str, name: str) -> OutputEntry | None:  # noqa: ARG001
    """Return the SDF output of an imported robot, or None if it was not imported from an SDF."""
    options = (tree.get("outputs") or {}).get("sdf")
    return None if options is None else OutputEntry({"file": "", **options} | {"file": f"{name}.sdf"})


def _unsupported(output: Output) -> Mapping[str, Unsupported]:
    fixed = Unsupported("links that are fixed to each other need no joint", quiet=True)
    return {
        **format.OF_MUJOCO,
        **format.OF_PUBLISHERS,
        **unsupported_drives(output),
        "sensors.*.joint": fixed,
        "sensors.*.optical.joint": fixed,
        "disabled_contacts.*": Unsupported("no pairs of links that do not collide"),
        "joints.*.calibration": Unsupported("no calibration of joints"),
        "joints.*.safety_controller": Unsupported("no soft limits"),
    }


FORMAT = Format(
    name="sdf",
    word="SDF",
    article="an",
    about="the model for Gazebo and Drake",
    rank=22,
    covers=(*format.MODEL_KEYS, "urdf_elements"),
    unsupported=_unsupported,
    options={
        "number_format": format.NUMBER_FORMAT,
        "version": {
            "enum": ["1.9", "1.10", "1.11", "1.12", 1.9, 1.1, 1.11, 1.12],
            "description": "SDF version; default: 1.9, or 1.11 with mimic joints. Fortress supports up to 1.9,"
            " Harmonic up to 1.11, Ionic and Drake up to 1.12.",
        },
        "height_maps": format.HEIGHT_MAPS,
        "visuals": format.VISUALS,
        "gazebo": {
            "enum": [True, False, "harmonic", "fortress", "classic"],
            "description": "Version of Gazebo to write sensors for: true (harmonic), harmonic or fortress, with a"
            " Gazebo-specific element for the message frame, which Drake rejects; classic; false: no sensors;"
            " default: sensors in standard SDF only.",
        },
    },
    file="{}.sdf",
    endings=(".sdf",),
    roots=("sdf",),
    check=partial(_call, "content", "check"),
    write=partial(_call, "write", "write"),
    load=partial(_call, "read", "read_sdf"),
    view=partial(_call, "content", "view"),
    partial=True,
    read=partial(_call, "read", "read"),
    asked=_asked,
    meshes=True,
    syntax=xml_syntax,
    folder="sdf",
    deploys=True,
)

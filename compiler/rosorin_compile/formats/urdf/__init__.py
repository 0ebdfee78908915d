"""URDF: the format that robot_state_publisher, MoveIt and most other tools read."""

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Output, Robot
from rosorin_compile.source.tree import Map

from .. import format
from ..format import Format, OutputEntry, Unsupported, xml_syntax
from ..gazebo import unsupported_drives
from . import write
from .write import ELEMENTS, check, content_of, frames_of, links_of

__all__ = ["FORMAT"]


def _reader() -> Any:
    return import_module(f"{__name__}.read")  # lazy, because few runs need it


def _leaves_out(robot: Robot, link: str) -> bool:
    carried = {name for joint in robot.in_urdf() for name in (joint.parent, joint.child)}
    return bool(carried) and link not in carried


def _asked(tree: Map, version: str, name: str) -> OutputEntry:
    links = (tree.get("links") or {}).values()
    shapes = (shape for link in links if link for key in ("visual", "collision") for shape in link.get(key) or ())
    entry = {"file": f"{name}.urdf", **((tree.get("outputs") or {}).get("urdf") or {})}  # keep options of the import
    has_capsules = any("capsule" in shape for shape in shapes)
    entry |= {"version": "1.2"} if has_capsules or version == "1.2" else {}
    remark = "URDF 1.2, for the capsules; ROS up to Jazzy does not read it: without the version, they are cylinders"
    return OutputEntry(entry, remark if has_capsules else "")  # urdfdom before version 5 rejects URDF 1.2


def _unsupported(output: Output) -> Mapping[str, Unsupported | None]:
    table = {
        **format.OF_MUJOCO,
        **format.OF_PUBLISHERS,
        **unsupported_drives(output, quiet=not output.options.get("gazebo")),
        "constraints": Unsupported("no loops, and no couplings but mimic"),
        "sensors.*.joint": None,  # supported, even for fixed joints
        "links.*.collision.*.capsule": Unsupported("cylinders are written", one_way=True),
        "disabled_contacts": Unsupported("the SRDF lists pairs of links that are not to collide", quiet=True),
    }
    if not output.options.get("gazebo"):
        for_gazebo = Unsupported("Gazebo alone reads it, and needs the option gazebo", quiet=True)
        table |= dict.fromkeys(("sensors.*.gazebo", "links.*.collision.*.contact.friction"), for_gazebo)
        springs = ("joints.*.dynamics.stiffness", "joints.*.dynamics.spring_reference")
        table |= dict.fromkeys(springs, Unsupported("no springs; Gazebo reads them with the option gazebo"))
    return table


_ELEMENTS = "Elements of links and joints to write in addition to the kinematics; default: all."
_FRAMES = (
    "published: joints that robot_state_publisher publishes; all: all joints; bodies: all moving joints and links with"
    " mass, for simulators; default: published. Use only published for robot_state_publisher."
)
_GAZEBO = "Gazebo version for sensors and drives: true (harmonic), harmonic, fortress, classic; default: false (none)."
_CONTROL = "ROS 2 distribution for the hardware blocks in control; default: no hardware blocks."
_VERSION = "URDF version; 1.2 supports capsules; default: 1.0."

FORMAT = Format(
    name="urdf",
    word="URDF",
    article="a",
    about="the URDF",
    rank=10,
    covers=(*format.MODEL_KEYS, "urdf_elements", "control"),
    unsupported=_unsupported,
    options={
        "number_format": format.NUMBER_FORMAT,
        "elements": {"type": "array", "description": _ELEMENTS, "items": {"enum": [*ELEMENTS]}},
        "height_maps": format.HEIGHT_MAPS,
        "frames": {"enum": ["published", "all", "bodies"], "description": _FRAMES},
        "visuals": format.VISUALS,
        "version": {"enum": ["1.0", "1.2", 1.0, 1.2], "description": _VERSION},
        "gazebo": {"enum": [True, False, "harmonic", "fortress", "classic"], "description": _GAZEBO},
        "control": {"enum": format.DISTRIBUTIONS, "description": _CONTROL},
    },
    file="{}.urdf",
    endings=(".urdf",),
    roots=("robot",),
    check=check,
    write=write.write,
    view=lambda robot, output: content_of(robot, output).view,
    read=lambda text: _reader().read(text),
    load=lambda opened: _reader().read_urdf(opened.xml, opened.path, opened.options),
    asked=_asked,
    links=links_of,
    leaves_out=_leaves_out,
    brings=lambda robot, output: content_of(robot, output).blocks,
    why="a URDF has only what robot_state_publisher publishes",
    meshes=True,
    syntax=xml_syntax,
    feeds=(ROBOT_STATE_PUBLISHER,),
    withheld=lambda output: frames_of(output) != "published",
    folder="urdf",
    deploys=True,
)

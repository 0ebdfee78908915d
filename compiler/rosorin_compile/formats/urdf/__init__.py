"""URDF: what robot_state_publisher, MoveIt and most other readers take.

``write`` decides what a URDF contains and writes it, with blocks of ``gazebo``. ``read`` reads URDFs, with ``reading``,
which readers of other XML formats share.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import ROBOT_STATE_PUBLISHER

from ..format import (
    BOXES_OF_HEIGHT_MAPS,
    DISTRIBUTIONS,
    FORMS_OF_BOXES,
    MODEL_KEYS,
    NUMBER_FORMAT,
    OF_MUJOCO,
    OF_PUBLISHERS,
    Asked,
    Format,
    Unsupported,
    xml_syntax,
)
from ..gazebo_elements import unsupported_drives
from . import write
from .write import Content, check, frames_of, links_of

if TYPE_CHECKING:
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.source.tree import Map

__all__ = ["FORMAT"]


def _reader() -> Any:
    return import_module(f"{__name__}.read")  # few runs need it


def _leaves_out(robot: Robot, link: str) -> bool:
    carried = {name for joint in robot.in_urdf() for name in (joint.parent, joint.child)}
    return bool(carried) and link not in carried


def _asked(tree: Map, version: str, name: str) -> Asked:
    links = (tree.get("links") or {}).values()
    shapes = (shape for link in links if link for key in ("visual", "collision") for shape in link.get(key) or ())
    entry = {"file": f"{name}.urdf", **((tree.get("outputs") or {}).get("urdf") or {})}  # what an import found
    if any("capsule" in shape for shape in shapes):
        # urdfdom before version 5 (ROS up to Jazzy) refuses that version.
        remark = "URDF 1.2, for the capsules; ROS up to Jazzy does not read it: without the version,"
        return Asked({**entry, "version": "1.2"}, f"{remark} cylinders stand for them")
    return Asked({**entry, **({"version": "1.2"} if version == "1.2" else {})})


def _unsupported(output: Output) -> Mapping[str, Unsupported | None]:
    table = {
        **OF_MUJOCO,
        **OF_PUBLISHERS,
        **unsupported_drives(output, quiet=not output.options.get("gazebo")),
        "constraints": Unsupported("no loops, and no couplings but mimic"),
        "sensors.*.joint": None,  # also where it is fixed
        "links.*.collision.*.capsule": Unsupported("cylinders are written", one_way=True),
        "disabled_contacts": Unsupported("the SRDF lists pairs of links that are not to collide", quiet=True),
    }
    if not output.options.get("gazebo"):
        for_gazebo = Unsupported("Gazebo alone reads it, and needs the option gazebo", quiet=True)
        table |= dict.fromkeys(("sensors.*.gazebo", "links.*.collision.*.contact.friction"), for_gazebo)
        springs = ("joints.*.dynamics.stiffness", "joints.*.dynamics.spring_reference")
        table |= dict.fromkeys(springs, Unsupported("no springs; Gazebo reads them with the option gazebo"))
    return table


_ELEMENTS = "Which elements of links and joints to carry beside the kinematics; default all."
_BOXES = f"The boxes of height maps; default: rows. {BOXES_OF_HEIGHT_MAPS}."
_FRAMES = (
    "published (default): the joints that robot_state_publisher publishes; all: every joint; bodies: every joint that"
    " moves and every link with a mass, for simulators. Only the first is given to robot_state_publisher."
)
_VISUALS = "from_collision: a link without a visual is seen as its collision shapes, a colour a link."
_VERSION = "Version of the format. 1.0 (default) is read by everything; 1.2 has a word for capsules."
_GAZEBO = "Whether it has the sensors for Gazebo: true or harmonic, fortress, classic; default false."
_CONTROL = "The distribution of ROS 2 that it has the hardware blocks of control for; default: none."
_CARRIED = {"enum": ["inertial", "visual", "collision", "dynamics", "urdf_elements"]}

FORMAT = Format(
    name="urdf",
    word="URDF",
    article="a",
    about="the URDF",
    rank=10,
    covers=(*MODEL_KEYS, "urdf_elements", "control"),
    unsupported=_unsupported,
    options={
        "number_format": NUMBER_FORMAT,
        "elements": {"type": "array", "description": _ELEMENTS, "items": _CARRIED},
        "height_maps": {"enum": FORMS_OF_BOXES, "description": _BOXES},
        "frames": {"enum": ["published", "all", "bodies"], "description": _FRAMES},
        "visuals": {"enum": ["from_collision"], "description": _VISUALS},
        "version": {"enum": ["1.0", "1.2", 1.0, 1.2], "description": _VERSION},
        "gazebo": {"enum": [True, False, "harmonic", "fortress", "classic"], "description": _GAZEBO},
        "control": {"enum": DISTRIBUTIONS, "description": _CONTROL},
    },
    file="{}.urdf",
    endings=(".urdf",),
    roots=("robot",),
    check=check,
    write=write.write,
    view=lambda robot, output: Content(robot, output).view,
    read=lambda text: _reader().read(text),
    load=lambda opened: _reader().read_urdf(opened.xml, opened.path, opened.options),
    asked=_asked,
    links=links_of,
    leaves_out=_leaves_out,
    brings=lambda robot, output: Content(robot, output).blocks,
    why="a URDF has only what robot_state_publisher publishes",
    meshes=True,
    syntax=xml_syntax,
    feeds=(ROBOT_STATE_PUBLISHER,),
    withheld=lambda output: frames_of(output) != "published",
    folder="urdf",
    deploys=True,
)

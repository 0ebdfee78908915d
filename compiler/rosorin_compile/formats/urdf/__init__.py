"""URDF: what robot_state_publisher, MoveIt and most other readers take.

``content`` decides what a URDF contains of a robot, ``gazebo`` adds blocks for Gazebo, ``write`` writes it. ``read``
reads URDFs, with ``reading``, which readers of other XML formats share.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rosorin_compile.model import ROBOT_STATE_PUBLISHER

from ..distributions import DISTRIBUTIONS
from ..format import BOXES_OF_HEIGHT_MAPS, FORMS_OF_BOXES, NUMBER_FORMAT, Asked, Format, Opened, xml_syntax
from ..gazebo_drives import unsupported_drives
from ..unsupported import MODEL_KEYS, OF_MUJOCO, OF_PUBLISHERS, Unsupported
from . import write
from .content import check, frames_of, links_of

if TYPE_CHECKING:
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.source.tree import Map

    from ..imported import Imported

__all__ = ["FORMAT"]


def _read(opened: Opened) -> Imported:
    from .read import read_urdf

    return read_urdf(opened.xml, opened.path, opened.options)


def _read_back(text: str) -> Robot:
    from .read import read

    return read(text)


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


def _unsupported(output: Output) -> Mapping[str, Unsupported]:
    """Return what a URDF has no word for."""
    table = {
        **OF_MUJOCO,
        **OF_PUBLISHERS,
        **unsupported_drives(output, quiet=not output.options.get("gazebo")),
        "constraints": Unsupported("no loops, and no couplings but mimic"),
        "disabled_contacts": Unsupported("the SRDF lists pairs of links that are not to collide", quiet=True),
    }
    if not output.options.get("gazebo"):
        for_gazebo = Unsupported("Gazebo alone reads it, and needs the option gazebo", quiet=True)
        table |= dict.fromkeys(("sensors.*.gazebo", "links.*.collision.*.contact.friction"), for_gazebo)
        springs = ("joints.*.dynamics.stiffness", "joints.*.dynamics.spring_reference")
        table |= dict.fromkeys(springs, Unsupported("no springs; Gazebo reads them with the option gazebo"))
    return table


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
        "elements": {
            "type": "array",
            "description": "Which elements of links and joints to carry beside the kinematics; default all.",
            "items": {"enum": ["inertial", "visual", "collision", "dynamics", "urdf_elements"]},
        },
        "height_maps": {
            "enum": FORMS_OF_BOXES,
            "description": f"The boxes of height maps; default: rows. {BOXES_OF_HEIGHT_MAPS}.",
        },
        "frames": {
            "enum": ["published", "all", "bodies"],
            "description": "published (default): the joints that robot_state_publisher publishes; all: every joint;"
            " bodies: every joint that moves and every link with a mass, for simulators. Only the first is given to"
            " robot_state_publisher.",
        },
        "visuals": {
            "enum": ["from_collision"],
            "description": "from_collision: a link without a visual is seen as its collision shapes, a colour a link.",
        },
        "version": {
            "enum": ["1.0", "1.2", 1.0, 1.2],
            "description": "Version of the format. 1.0 (default) is read by everything; 1.2 has a word for capsules.",
        },
        "gazebo": {
            "enum": [True, False, "harmonic", "fortress", "classic"],
            "description": "Whether it has the sensors for Gazebo: true or harmonic, fortress, classic; default false.",
        },
        "control": {
            "enum": DISTRIBUTIONS,
            "description": "The distribution of ROS 2 that it has the hardware blocks of control for; default: none.",
        },
    },
    file="{}.urdf",
    endings=(".urdf",),
    roots=("robot",),
    check=check,
    write=write.write,
    view=write.view,
    read=_read_back,
    load=_read,
    asked=_asked,
    lacks=frozenset(
        {"armature", "stiffness", "simulation", "actuator", "pose", "servo", "sensor", "contact", "publisher", "edge"}
        | {"capsule", "drive", "planning", "mode"}
    ),
    links=links_of,
    leaves_out=_leaves_out,
    brings=write.added_elements,
    why="a URDF has only what robot_state_publisher publishes",
    meshes=True,
    syntax=xml_syntax,
    feeds=(ROBOT_STATE_PUBLISHER,),
    withheld=lambda output: frames_of(output) != "published",
    folder="urdf",
    deploys=True,
)

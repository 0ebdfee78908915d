"""SRDF: what MoveIt has to know of a robot beside its URDF.

``planning`` knows which links and joints it may speak of, and what a group has; ``write`` makes the text, which is
read here for comparison; ``reading`` reads what people have beside a URDF. ``checks`` finds what the section ``moveit``
says wrongly, ``matrix`` whether its matrix is of the robot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosorin_compile.formats.format import NUMBER_FORMAT, Asked, Format, Unsupported, xml_syntax

from . import checks, reading, write

if TYPE_CHECKING:
    from rosorin_compile.model import Output, Robot
    from rosorin_compile.source.tree import Map
    from rosorin_compile.source.xml.markup import Document

    from .view import Srdf

__all__ = ["FORMAT"]


def _is_other(document: Document) -> bool:
    """Say whether a document has elements of an SRDF, and neither links nor joints."""
    tags = {child.tag for child in document.root.children}
    return document.root.tag == "robot" and bool(tags & _OWN) and not tags & {"link", "joint"}


def _asked(tree: Map, _: str, name: str) -> Asked | None:
    return Asked({"file": f"{name}.srdf"}) if "moveit" in tree else None


def _read(text: str) -> Srdf:
    from .view import read

    return read(text)


def _view(robot: Robot, output: Output) -> Srdf:
    from .view import view

    return view(robot, output)


_OWN = {"group", "group_state", "end_effector", "virtual_joint", "disable_collisions", "passive_joint"}

_FINGERPRINT = Unsupported("tells whether the matrix is of this robot", quiet=True)
_UNSUPPORTED = {
    **{f"moveit.collision_matrix.{key}": _FINGERPRINT for key in ("of", "how", "shapes", "joints", "meshes")},
    "moveit.collisions": Unsupported(
        "how the pairs are searched, which only the command collisions renews", quiet=True
    ),
    "moveit.urdf": Unsupported("the output whose links MoveIt loads", quiet=True),
}

FORMAT = Format(
    name="srdf",
    word="SRDF",
    article="an",
    about="what MoveIt has to know beside the URDF",
    rank=25,
    covers=("robot", "moveit", "disabled_contacts", "poses.positions", "poses.pulses"),
    unsupported=_UNSUPPORTED,
    options={"number_format": NUMBER_FORMAT},
    file="{}.srdf",
    endings=(".srdf",),
    check=checks.check,
    write=write.write,
    view=_view,
    read=_read,
    join=reading.join,
    joins=("moveit",),
    is_other=_is_other,
    asked=_asked,
    measures=True,
    syntax=xml_syntax,
    folder="srdf",
    deploys=True,
)

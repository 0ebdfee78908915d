"""SRDF: what MoveIt has to know of a robot beside its URDF.

``planning`` has the links and joints of the URDF and the joints of groups; ``text`` writes an SRDF and reads it back,
``reading`` reads those of others. ``checks`` has the rules about the section ``moveit``, ``matrix`` its fingerprints.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosorin_compile.formats.format import NUMBER_FORMAT, Asked, Format, Unsupported, xml_syntax

from . import checks, reading, text

if TYPE_CHECKING:
    from rosorin_compile.source.tree import Map
    from rosorin_compile.source.xml.markup import Document

__all__ = ["FORMAT"]


def _is_other(document: Document) -> bool:
    tags = {child.tag for child in document.root.children}
    return document.root.tag == "robot" and bool(tags & _OWN) and not tags & {"link", "joint"}


def _asked(tree: Map, _: str, name: str) -> Asked | None:
    return Asked({"file": f"{name}.srdf"}) if "moveit" in tree else None


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
    write=text.write,
    view=text.view,
    read=text.read,
    join=reading.join,
    joins=("moveit",),
    is_other=_is_other,
    asked=_asked,
    measures=True,
    syntax=xml_syntax,
    folder="srdf",
    deploys=True,
)

"""SRDF: what MoveIt has to know of a robot beside its URDF.

``planning`` knows which links and joints it may speak of, and what a group has; ``write`` makes the text, which is
read here for comparison; ``reading`` reads what people have beside a URDF. ``checks`` finds what the section ``moveit``
says wrongly, ``matrix`` whether its matrix is of the robot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosorin_compile.formats.format import (
    NUMBER_FORMAT,
    Asked,
    Fact,
    Facts,
    Format,
    Importing,
    InRos,
    Proving,
    Writing,
)
from rosorin_compile.formats.unsupported import Unsupported

from . import checks, reading, write

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.formats.facts import FactSheet
    from rosorin_compile.source.tree import Map
    from rosorin_compile.source.xml.markup import Document

__all__ = ["FORMAT"]


def _syntax(text: str) -> object:
    from rosorin_compile.source.xml.elements import canonical, tree_of

    return canonical(tree_of(text))


def _is_other(document: Document) -> bool:
    """Say whether a document has elements of an SRDF, and neither links nor joints."""
    tags = {child.tag for child in document.root.children}
    return document.root.tag == "robot" and bool(tags & _OWN) and not tags & {"link", "joint"}


def _asked(tree: Map, _: str, name: str) -> Asked | None:
    return Asked({"file": f"{name}.srdf"}) if "moveit" in tree else None


def _facts(text: str) -> Facts:
    """Return what an SRDF says. Raises ValueError for a damaged one."""
    from rosorin_compile.formats.facts import FactSheet
    from rosorin_compile.model import DisabledCollision

    sheet = FactSheet(text, "robot")
    readers = {
        "group": _group_facts,
        "group_state": _state_facts,
        "end_effector": _end_effector_facts,
        "virtual_joint": _virtual_joint_facts,
    }
    for element in sheet.root:
        if element.tag in readers:
            readers[element.tag](sheet, element)
        elif element.tag == "passive_joint":
            sheet.add(Fact("planning", "passive joints", sheet.text(element, "name")), "passive")
        elif element.tag == "joint_property":
            joint, name = sheet.text(element, "joint_name"), sheet.text(element, "property_name")
            sheet.add(Fact("joint", joint, f"property {name}"), sheet.text(element, "value"))
        elif element.tag == "disable_collisions":
            _pair_fact(
                sheet, element, "disabled collision with {} " + f"({element.get('reason', DisabledCollision.reason)})"
            )
        elif element.tag == "enable_collisions":
            _pair_fact(sheet, element, "checked collision with {}")
        elif element.tag == "disable_default_collisions":
            sheet.add(Fact("collision of", sheet.text(element, "link"), "and others"), "off")
        elif element.tag == "link_sphere_approximation":
            balls = (" ".join((sheet.text(one, "center"), sheet.text(one, "radius"))) for one in element)
            sheet.add(Fact("link", sheet.text(element, "link"), "spheres"), ", ".join(balls))
    return sheet.facts


def _pair_fact(sheet: FactSheet, element: Element, quantity: str) -> None:
    one, other = sorted((sheet.text(element, "link1"), sheet.text(element, "link2")))
    sheet.add(Fact("planning", one, quantity.replace("{}", other)), "said")


def _group_facts(sheet: FactSheet, element: Element) -> None:
    name = sheet.text(element, "name")
    said: dict[str, list[str]] = {}
    for one in element:
        if one.tag == "chain":
            chain = f"{sheet.text(one, 'base_link')} to {sheet.text(one, 'tip_link')}"
            said.setdefault("chain", []).append(chain)
        else:
            said.setdefault(f"{one.tag}s", []).append(sheet.text(one, "name"))
    for key, names in said.items():
        sheet.add(Fact("group", name, key), ", ".join(names))


def _state_facts(sheet: FactSheet, element: Element) -> None:
    name = f"{sheet.text(element, 'name')} of {sheet.text(element, 'group')}"
    for one in element:
        fact, value = Fact("state", name, sheet.text(one, "name")), sheet.text(one, "value")
        sheet.add(fact, value if " " in value else sheet.number(one, "value"))


def _end_effector_facts(sheet: FactSheet, element: Element) -> None:
    for quantity in ("group", "parent_link", "parent_group"):
        if element.get(quantity) is not None:
            name = sheet.text(element, "name")
            sheet.add(Fact("end effector", name, quantity.replace("_", " ")), sheet.text(element, quantity))


def _virtual_joint_facts(sheet: FactSheet, element: Element) -> None:
    for quantity in ("type", "parent_frame", "child_link"):
        name = sheet.text(element, "name")
        sheet.add(Fact("virtual joint", name, quantity.replace("_", " ")), sheet.text(element, quantity))


_OWN = {"group", "group_state", "end_effector", "virtual_joint", "disable_collisions", "passive_joint"}

_FINGERPRINT = Unsupported("tells whether the matrix is of this robot", quiet=True)
_UNSUPPORTED = {
    **{f"moveit.collision_matrix.{key}": _FINGERPRINT for key in ("of", "how", "shapes", "joints", "meshes")},
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
    facts=_facts,
    reading=Importing(
        join=reading.join,
        joins=("moveit",),
        is_other=_is_other,
        asked=_asked,
    ),
    writing=Writing(
        says=("moveit", "disabled_contacts"),
        measures=True,
    ),
    proving=Proving(
        syntax=_syntax,
    ),
    ros=InRos(
        folder="srdf",
        deploys=True,
    ),
)

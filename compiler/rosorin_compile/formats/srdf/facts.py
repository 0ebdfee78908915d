"""What an SRDF says, read back for comparison."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...model.moveit import USER
from ..facts import FactSheet
from ..format import Fact, Facts

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element


def read(text: str) -> Facts:
    """Return what an SRDF says. Raises ValueError for a damaged one."""
    sheet = FactSheet(text, "robot")
    readers = {"group": _group, "group_state": _state, "end_effector": _end_effector, "virtual_joint": _virtual_joint}
    for element in sheet.root:
        if element.tag in readers:
            readers[element.tag](sheet, element)
        elif element.tag == "passive_joint":
            sheet.add(Fact("planning", "passive joints", sheet.text(element, "name")), "passive")
        elif element.tag == "joint_property":
            joint, name = sheet.text(element, "joint_name"), sheet.text(element, "property_name")
            sheet.add(Fact("joint", joint, f"property {name}"), sheet.text(element, "value"))
        elif element.tag == "disable_collisions":
            _pair(sheet, element, f"off: {element.get('reason', USER)}")
        elif element.tag == "enable_collisions":
            _pair(sheet, element, "on")
        elif element.tag == "disable_default_collisions":
            sheet.add(Fact("collision of", sheet.text(element, "link"), "and others"), "off")
        elif element.tag == "link_sphere_approximation":
            balls = (" ".join((sheet.text(one, "center"), sheet.text(one, "radius"))) for one in element)
            sheet.add(Fact("link", sheet.text(element, "link"), "spheres"), ", ".join(balls))
    return sheet.facts


def _pair(sheet: FactSheet, element: Element, said: str) -> None:
    pair = sorted((sheet.text(element, "link1"), sheet.text(element, "link2")))
    sheet.add(Fact("collision of", pair[0], f"and {pair[1]}"), said)


def _group(sheet: FactSheet, element: Element) -> None:
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


def _state(sheet: FactSheet, element: Element) -> None:
    name = f"{sheet.text(element, 'name')} of {sheet.text(element, 'group')}"
    for one in element:
        fact, value = Fact("state", name, sheet.text(one, "name")), sheet.text(one, "value")
        sheet.add(fact, value if " " in value else sheet.number(one, "value"))


def _end_effector(sheet: FactSheet, element: Element) -> None:
    for quantity in ("group", "parent_link", "parent_group"):
        if element.get(quantity) is not None:
            name = sheet.text(element, "name")
            sheet.add(Fact("end effector", name, quantity.replace("_", " ")), sheet.text(element, quantity))


def _virtual_joint(sheet: FactSheet, element: Element) -> None:
    for quantity in ("type", "parent_frame", "child_link"):
        name = sheet.text(element, "name")
        sheet.add(Fact("virtual joint", name, quantity.replace("_", " ")), sheet.text(element, quantity))

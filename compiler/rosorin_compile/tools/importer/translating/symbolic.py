"""Symbolic: a hardware block with expressions in its texts as an entry whose values are those expressions.

Each expression is read as a number that nothing else has; where that number comes out, the expression stands. Whether
the entry then says the same for all arguments is proven as everything else is.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from ....startup.records import NamedTuple
from ....xml.elements import tree_of
from ..layout import Expression, Verbatim
from ..words.blocks import Unsayable, block

if TYPE_CHECKING:
    from collections.abc import Mapping
    from xml.etree.ElementTree import Element

    from ....model import Joint, Robot

EXPRESSION = re.compile(r"\$\{([^{}]*)\}")
_FIRST = 731_001  # and on, with the same digits behind the point


class _Joints(NamedTuple):
    """The joints of a robot by the names that they have with numbers for expressions."""

    joint: Mapping[str, Joint]


def symbolic(text: str, said: str, robot: Robot, humble: bool) -> tuple[str, dict[str, Any], dict[str, str]] | None:
    """Return the name of a block, its entry with numbers for expressions, and these by their numbers; None for none.

    ``said`` is the block with its values, as ``robot`` has it.
    """
    slots: dict[str, str] = {}

    def numbered(found: re.Match[str]) -> str:
        number = f"{_FIRST + len(slots)}.25"
        slots[number] = found[1]
        return number

    form = EXPRESSION.sub(numbered, text)
    if "${" in form or any(number in text for number in slots):
        return None
    element, known = tree_of(form), tree_of(said)
    if element.tag != "ros2_control" or any(_has_text(one) for one in element.iter() if len(one)):
        return None
    joints = {
        one.get("name", ""): robot.joint[other.get("name", "")]
        for one, other in zip(element.iter("joint"), known.iter("joint"), strict=False)
        if other.get("name", "") in robot.joint
    }
    try:
        return element.get("name", ""), block(element, _Joints(joints), humble), slots  # type: ignore[arg-type]
    except Unsayable:
        return None


def _has_text(element: Element) -> bool:
    return bool((element.text or "").strip()) or any((child.tail or "").strip() for child in element)


def with_expressions(value: Any, slots: Mapping[str, str]) -> Any:
    """Return what is laid out with expressions for their numbers."""
    if isinstance(value, dict):
        return {with_expressions(key, slots): with_expressions(item, slots) for key, item in value.items()}
    if isinstance(value, list):
        return [with_expressions(item, slots) for item in value]
    if not isinstance(value, str) or not any(number in value for number in slots):
        return value
    sole = slots.get(value.removeprefix("-"))
    if isinstance(value, Verbatim) and sole is not None and value.startswith("-"):
        return Expression(f"${{-({sole})}}")
    made = str(value)
    for number, expression in slots.items():
        made = made.replace(number, f"${{{expression}}}")
    return Expression(made)

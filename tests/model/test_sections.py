"""What a robot says in sections: by their records and by their names, and taken from another robot."""

from __future__ import annotations

import pytest

from rosorin_compile.model import Controller, Link, Robot
from rosorin_compile.model.control import Block
from rosorin_compile.model.sections import NO_SECTIONS
from rosorin_compile.ros.sections.control import CONTROL
from rosorin_compile.ros.sections.controllers import CONTROLLERS

ROBOT = Robot("r", (Link("a"),), ())
BLOCKS, OTHERS = ((Block(name, "system", "some/Plugin"),) for name in ("arm", "base"))
ARM = (Controller("arm", "position_group"),)


def test_a_section_is_asked_for_by_its_record_and_by_its_name() -> None:
    robot = ROBOT.having(CONTROL, BLOCKS)
    assert robot.sections[CONTROL] == robot.sections["control"] == BLOCKS
    assert ROBOT.sections[CONTROL] == ROBOT.sections["control"] == ()
    with pytest.raises(KeyError):
        ROBOT.sections["no_such_section"]


def test_sections_are_taken_from_another_robot() -> None:
    one = NO_SECTIONS.having(CONTROL, BLOCKS).having(CONTROLLERS, ARM)
    other = NO_SECTIONS.having(CONTROL, OTHERS)
    assert one.taking(("control",), other) == NO_SECTIONS.having(CONTROL, OTHERS).having(CONTROLLERS, ARM)
    assert one.taking(("control",), NO_SECTIONS) == NO_SECTIONS.having(CONTROLLERS, ARM)
    assert other.taking(("controllers",), one) == NO_SECTIONS.having(CONTROL, OTHERS).having(CONTROLLERS, ARM)

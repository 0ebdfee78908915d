"""What the core makes of a drive without its name: what is left empty, other names, and a base that is free."""

from dataclasses import replace
from pathlib import Path

import pytest

from rosorin_compile.model import Drive, Joint, Link, Output, Robot
from support.robots import compiled_text

SIDES = {"left": ("l",), "right": ("r",)}
ROBOT = Robot(
    "base",
    (Link("footprint"), Link("l_link"), Link("r_link")),
    tuple(Joint(name, "continuous", "footprint", f"{name}_link", axis=(0, 1, 0)) for name in "lr"),
)
DRIVEN = replace(ROBOT, drive=Drive("differential", SIDES, "footprint", 0.05))


@pytest.mark.parametrize("said", ["{}", "{radius: 4 cm}"])
def test_a_drive_that_says_no_kind_is_refused(tmp_path: Path, said: str) -> None:
    made = compiled_text(tmp_path, f"robot: base\nlinks: {{footprint: {{}}}}\ndrive: {said}\n")
    assert [one.rule for one in made.diagnostics] == ["drive-kind"]


def test_a_section_that_is_left_empty_says_nothing(tmp_path: Path) -> None:
    made = compiled_text(tmp_path, "robot: base\nlinks: {footprint: {}}\nmoveit: {}\nservos: {}\n").robot
    assert made is not None
    assert (made.moveit, made.servos, made.sections.values) == (None, (), {})


def test_the_wheels_of_a_drive() -> None:
    assert [wheel.joint for wheel in DRIVEN.driving.wheels] == ["l", "r"]


@pytest.mark.parametrize(
    ("robot", "base", "free"), [(ROBOT, "", False), (DRIVEN, "", True), (ROBOT, "free", True), (DRIVEN, "fixed", False)]
)
def test_a_base_that_drives_is_free_unless_an_output_says_otherwise(robot: Robot, base: str, free: bool) -> None:
    assert robot.has_free_base(Output("mjcf", "mjcf", "base.xml", {"base": base} if base else {})) == free

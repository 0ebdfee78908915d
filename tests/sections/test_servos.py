"""What the core makes of servos by the schema and the place of their modules alone, without their name."""

from pathlib import Path

import pytest

from rosorin_compile.compare.changes import Change
from rosorin_compile.formats.compilation import understand
from rosorin_compile.language.explain import Explanation, explain
from rosorin_compile.viewer.changed import change_data
from support.paths import data_text

TWO = data_text("robots/servos_two.yaml")
PROJECT = {"descriptions/arm/robot.yaml": TWO}


@pytest.mark.usefixtures("project")
def test_explain_shows_the_numbers_of_the_entries_that_name_a_joint() -> None:
    expanded, lowered, *_ = understand(Path("descriptions/arm/robot.yaml"), {})
    assert lowered is not None
    (upper, tool) = explain(expanded, lowered, {}, ("upper", "tool"))
    assert isinstance(upper, Explanation)
    assert isinstance(tool, Explanation)
    numbers = [(one.name, one.value, one.unit) for one in tool.joint if one.name.startswith("servo")]
    assert [(one.name, one.value) for one in upper.joint if one.name.startswith("servo")] == [
        ("servo rad_per_pulse", 0.004),
        ("servo zero_pulse", 500),
        ("servo pulse_range[0]", 0),
        ("servo pulse_range[1]", 1000),
    ]
    assert numbers == [
        ("servo rad_per_pulse", 0.002, "rad"),
        ("servo zero_pulse", 450, ""),
        ("servo pulse_range[0]", 0, ""),
        ("servo pulse_range[1]", 900, ""),
    ]


@pytest.mark.usefixtures("project")
def test_a_page_shows_a_change_of_servos_at_their_first_joint() -> None:
    _, lowered, *_ = understand(Path("descriptions/arm/robot.yaml"), {})
    assert lowered is not None
    assert lowered.robot is not None
    change = Change("servo", "small", "zero", "zero 450 -> 451", ("model",))
    assert change_data(change, [lowered.robot])["frame"] == "tool"

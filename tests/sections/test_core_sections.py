"""What the core makes of a drive, of servos and of what only a simulation has, by the schema alone."""

from dataclasses import replace
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import understand
from rosorin_compile.language.explain import Explanation, explain
from rosorin_compile.model import Drive, Joint, Link, Output, Robot
from support.paths import data_text

PROJECT = {"descriptions/arm/robot.yaml": data_text("robots/servos_two.yaml")}
SIMULATED = data_text("robots/simulation.yaml")
STANDING = Robot(
    "base",
    (Link("footprint"), Link("l_link"), Link("r_link")),
    tuple(Joint(name, "continuous", "footprint", f"{name}_link", axis=(0, 1, 0)) for name in "lr"),
)
DRIVEN = replace(STANDING, drive=Drive("differential", {"left": ("l",), "right": ("r",)}, "footprint", 0.05))


@pytest.mark.parametrize(
    ("robot", "base", "free"),
    [(STANDING, "", False), (DRIVEN, "", True), (STANDING, "free", True), (DRIVEN, "fixed", False)],
)
def test_a_base_that_drives_is_free_unless_an_output_says_otherwise(robot: Robot, base: str, free: bool) -> None:
    assert robot.has_free_base(Output("mjcf", "mjcf", "base.xml", {"base": base} if base else {})) == free


@pytest.mark.usefixtures("project")
def test_explain_shows_the_numbers_of_the_entries_that_name_a_joint() -> None:
    expanded, lowered, *_ = understand(Path("descriptions/arm/robot.yaml"), {})
    assert lowered is not None
    found = explain(expanded, lowered, {}, ("upper", "tool"))
    numbers = [
        [(one.name, one.value, one.unit) for one in answer.joint if one.name.startswith("servo")]
        for answer in found
        if isinstance(answer, Explanation)
    ]
    names = ("servo rad_per_pulse", "servo zero_pulse", "servo pulse_range[0]", "servo pulse_range[1]")
    units = ("rad", "", "", "")
    values = ((0.004, 500, 0, 1000), (0.002, 450, 0, 900))
    assert numbers == [list(zip(names, row, units, strict=True)) for row in values]


def test_each_section_is_compared(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed = SIMULATED.replace("pull: 0.2", "pull: 0.3").replace('coef="2"', 'coef="3"')
    changed = changed.replace("type: motor", "type: motor, gear: 2").replace("[0, 0, 1]", "[0, 0, 2]")
    changed = changed.replace("type: connect", "type: weld").replace('data="x"', 'data="y"')
    (home / "a.yaml").write_text(SIMULATED)
    (home / "b.yaml").write_text(changed)
    assert main(["diff", "a.yaml", "b.yaml"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert set(lines) >= {
        "actuator pull gear: new, 2",
        "robot mjcf element fixed cord joint hip coef 2 -> 3",
        "constraint shut tag connect -> weld",
        "pose home: controls pull 0.2 -> 0.3",
        "root in simulation pose xyz 0 0 1 rpy 0 0 0 -> xyz 0 0 2 rpy 0 0 0",
    }

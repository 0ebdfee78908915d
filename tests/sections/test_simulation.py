"""The sections that only a simulation has: compared value by value."""

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model import Robot
from rosorin_compile.model.geometry import Pose
from rosorin_compile.model.simulation import Actuator, Entry, Root
from support.paths import data_text
from support.robots import compiled_text

ROBOT = data_text("robots/simulation.yaml")


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    found = compiled_text(tmp_path, ROBOT).robot
    assert found is not None
    return found


def test_the_values_of_all_sections(robot: Robot) -> None:
    assert robot.actuators == (Actuator("motor", "pull", {"tendon": "cord"}),)
    held = {"body1": "base", "body2": "arm", "anchor": (0.0, 0.0, 0.0)}
    assert robot.constraints == (Entry("connect", "shut", held),)
    assert robot.mjcf == (
        '<tendon><fixed name="cord"><joint joint="hip" coef="2"/></fixed></tendon>',
        '<custom><text name="note" data="x"/></custom>',
    )
    assert robot.root_in_world == Root(Pose((0.0, 0.0, 1.0)), placed=True)


def test_each_section_is_compared(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    changed = ROBOT.replace("pull: 0.2", "pull: 0.3").replace('coef="2"', 'coef="3"')
    changed = changed.replace("type: motor", "type: motor, gear: 2").replace("[0, 0, 1]", "[0, 0, 2]")
    changed = changed.replace("type: connect", "type: weld").replace('data="x"', 'data="y"')
    (home / "a.yaml").write_text(ROBOT)
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

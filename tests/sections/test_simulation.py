"""The sections that only a simulation has: compared value by value."""

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import data_text

ROBOT = data_text("robots/simulation.yaml")


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

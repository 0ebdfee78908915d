"""What differs between two drives is said in words; a format without a word for drives is compared without it."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown
from support.paths import data_text

TYRE = "collision: [{cylinder: {radius: 5 cm, length: 2 cm}, rpy: [90 deg, 0, 0]}]"
ROBOT = data_text("robots/drives_robot.yaml")
DIFFERENTIAL = "drive: {differential: {left: [lj], right: [rj]}}\n"
TRICYCLE = "drive: {tricycle: {steering: sj, driven: [lj, rj]}}\n"


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        (DIFFERENTIAL, DIFFERENTIAL, []),
        ("", DIFFERENTIAL, ["new: drive"]),
        (TRICYCLE, DIFFERENTIAL, ["drive kind tricycle -> differential"]),
        (TRICYCLE, TRICYCLE.replace("lj, rj", "lj"), ["drive driven lj rj -> lj"]),
        (
            TRICYCLE,
            TRICYCLE.replace("}}", "}, radius: 51 mm}").replace("rj]", "rj], rolling: [fj]"),
            ["drive rolling: new, fj", "drive radius: new, 0.051 m"],
        ),
        (
            DIFFERENTIAL.replace("}}", "}, radius: 50 mm}"),
            DIFFERENTIAL.replace("}}", "}, radius: 51 mm}"),
            ["drive radius 0.05 -> 0.051 m (+1.0 mm)"],
        ),
        (DIFFERENTIAL, DIFFERENTIAL.replace("}}", "}, frame: base}"), []),
    ],
)
def test_a_drive_that_differs_is_told(home: Path, one: str, other: str, said: list[str], capsys: Shown) -> None:
    (home / "a.yaml").write_text(ROBOT + one)
    (home / "b.yaml").write_text(ROBOT + other)
    assert main(["diff", "a.yaml", "b.yaml"]) == (1 if said else 0)
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert [line for line in lines if "drive" in line] == said


def test_a_urdf_says_nothing_of_drives(home: Path, capsys: Shown) -> None:
    (home / "r.yaml").write_text(ROBOT + DIFFERENTIAL)
    assert main(["all", "r.yaml"]) == 0
    capsys.readouterr()
    assert main(["diff", "r.yaml", "outputs/r/r.urdf"]) == 0
    out = capsys.readouterr().out
    assert "drive" in next(line for line in out.splitlines() if line.startswith("not compared:"))

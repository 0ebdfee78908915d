"""Colours that nobody has said: one for each link, by its name, and no fact about a robot."""

import re
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main

ROBOT = """\
robot: r
links:
  base_link: {{collision: [{{box: {{size: [1, 1, 1]}}}}]{more}}}
  z: {{collision: [{{box: {{size: [1, 1, 1]}}}}]}}
joints: {{j: {{type: fixed, parent: base_link, child: z, xyz: [0, 0, 2]}}}}
outputs:
  urdf: {{file: r.urdf, visuals: from_collision}}
  sdf: {{file: r.sdf, visuals: from_collision}}
  mjcf: {{file: r.xml, visuals: from_collision}}
"""
OWN = ", visual: [{box: {size: [1, 1, 1]}, rgba: [1, 0, 0, 1]}]"
# As links were coloured by their numbers.
BEFORE = "0.722 0.318 0.389 1"


def described(folder: Path, more: str = "") -> Path:
    (folder / "robot.yaml").write_text(ROBOT.format(more=more), "utf-8")
    return folder / "robot.yaml"


def repainted(folder: Path) -> int:
    """Give link z another colour in what was committed; return in how many files."""
    count = 0
    for file in (folder / "outputs").rglob("r.*"):
        text = file.read_text("utf-8")
        colour = re.search(r'name="(?:r_)?z_colour"[^/]*rgba="([^"]*)"', text)
        wanted = colour[1] if colour else re.findall(r"<diffuse>([^<]*)<", text)[-1]
        file.write_text(text.replace(wanted, BEFORE), "utf-8")
        count += text != file.read_text("utf-8")
    return count


def test_a_colour_that_nobody_gave_is_compared_as_well(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    described(home)
    assert main(["all", "."]) == 0
    for file in sorted((home / "outputs").rglob("r.*")):
        (home / file.name).write_bytes(file.read_bytes())
    assert repainted(home) == 3
    capsys.readouterr()
    assert main(["check", "."]) == 1
    said = capsys.readouterr().out
    assert "z visual colour" in said
    assert "base_link visual colour" not in said
    described(home, OWN)
    assert main(["check", "."]) == 1
    assert "base_link visual: 0 -> 1 shapes" in capsys.readouterr().out
    for name in ("r.urdf",):
        (file,) = (home / "outputs").rglob(name)
        assert main(["diff", name, str(file)]) == 1
        assert "z_colour colour" in (said := capsys.readouterr().out) or "z visual colour" in said

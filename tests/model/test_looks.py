"""Colours that nobody has said: one for each link, by its name, and no fact about a robot."""

import re
from colorsys import rgb_to_hls
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.model import Joint, Link, Robot
from rosorin_compile.model.colours import is_own, own_colours
from support.paths import data_text

names = st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=8)


@st.composite
def trees(draw: st.DrawFn) -> Robot:
    links = draw(st.lists(names, min_size=2, max_size=12, unique=True))
    above = [links[draw(st.integers(0, at - 1))] for at in range(1, len(links))]
    joints = [Joint(f"to {child}", "fixed", parent, child) for child, parent in zip(links[1:], above, strict=True)]
    return Robot("r", tuple(map(Link, links)), tuple(joints))


def hue(rgba: tuple[float, ...]) -> float:
    return 360 * rgb_to_hls(*rgba[:3])[0]


@given(trees(), names, st.integers(0, 100), st.randoms(use_true_random=False))
def test_a_link_that_is_added_leaves_the_others_as_they_are(robot: Robot, name: str, at: int, random) -> None:
    if name in robot.link:
        return
    links, joints = [*robot.links, Link(name)], [*robot.joints]
    joints.append(Joint("new", "fixed", links[at % len(robot.links)].name, name))
    random.shuffle(links)
    random.shuffle(joints)
    more = dict(own_colours(Robot("r", tuple(links), tuple(joints))))
    del more[name]
    assert more == own_colours(robot)


@given(trees())
def test_a_link_is_told_from_what_it_hangs_on(robot: Robot) -> None:
    colours = own_colours(robot)
    assert all(map(is_own, colours.values()))
    for joint in robot.joints:
        apart = abs((hue(colours[joint.child]) - hue(colours[joint.parent]) + 180) % 360 - 180)
        assert apart > 24  # colours have three digits


ROBOT = data_text("robots/looks_robot.yaml")
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

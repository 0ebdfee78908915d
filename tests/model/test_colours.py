"""Colours that nobody has said: one for each link, by its name, and no fact about a robot."""

from colorsys import rgb_to_hls

from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.model import Joint, Link, Robot
from rosorin_compile.model.colours import default_colours, is_default

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
    more = dict(default_colours(Robot("r", tuple(links), tuple(joints))))
    del more[name]
    assert more == default_colours(robot)


@given(trees())
def test_a_link_is_told_from_what_it_hangs_on(robot: Robot) -> None:
    colours = default_colours(robot)
    assert all(map(is_default, colours.values()))
    for joint in robot.joints:
        apart = abs((hue(colours[joint.child]) - hue(colours[joint.parent]) + 180) % 360 - 180)
        assert apart > 24  # colours have three digits


# As links were coloured by their numbers.

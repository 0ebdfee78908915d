"""The layout of a picture: nothing stands over anything, each arrow leads where it should."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from itertools import combinations, product
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Limit, Link, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from support.paths import ROOT
from support.pictures import NOBODY, SVG, drawn, robots
from support.robots import compiled

# The letters and boxes of an SVG.


class Area(NamedTuple):
    """A box or a text: its name, its sides (pixels)."""

    name: str
    left: float
    right: float
    top: float
    bottom: float


def letters_of(text: str, size: float) -> float:
    """Return how wide a text is in DejaVu Sans Mono; wide letters come from a font with whole squares."""
    wide = sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
    return wide * 0.602 * size


def areas(root: ElementTree.Element) -> Iterator[Area]:
    for text in root.iter(f"{SVG}text"):
        x, y, size = (float(text.get(key, "")) for key in ("x", "y", "font-size"))
        said = text.text or ""
        yield Area(f"text {said}", x, x + letters_of(said, size), y - 0.76 * size, y + 0.24 * size)
    for box in root.iter(f"{SVG}rect"):
        if box.get("class") == "box":
            x, y, width, height = (float(box.get(key, "")) for key in ("x", "y", "width", "height"))
            yield Area("box", x, x + width, y, y + height)


def check_layout(text: str) -> None:
    """Hold a picture against what makes it readable: all of it inside, nothing over anything, names in their boxes."""
    root = ElementTree.fromstring(text)
    found = list(areas(root))
    width, height = float(root.get("width", "")), float(root.get("height", ""))
    for area in found:
        assert 10 <= area.left < area.right <= width - 10, area
        assert 10 <= area.top < area.bottom <= height - 8, area
    boxes = [area for area in found if area.name == "box"]
    words = [area for area in found if area.name != "box"]
    for one, other in combinations(words, 2):
        assert apart(one, other), (one, other)
    for one, other in combinations(boxes, 2):
        assert apart(one, other), (one, other)
    for box, word in product(boxes, words):
        inside = box.left < word.left and word.right < box.right and box.top < word.top and word.bottom < box.bottom
        assert inside or apart(box, word), (box, word)


def apart(one: Area, other: Area) -> bool:
    return one.right <= other.left or other.right <= one.left or one.bottom <= other.top or other.bottom <= one.top


def check_arrows(text: str) -> None:
    """Each arrow runs from below the box of the parent to the box of the child, and looks as the edge is published."""
    for panel in ElementTree.fromstring(text).iter(f"{SVG}g"):
        if panel.get("class") != "panel":
            continue
        trunks = [path.get("d", "") for path in panel.iter(f"{SVG}path") if path.get("class") == "trunk"]
        places = {}
        for line in panel.iter(f"{SVG}g"):
            if line.get("class") == "line":
                box = next(rect for rect in line.iter(f"{SVG}rect") if rect.get("class") == "box")
                x, y = float(box.get("x", "")), float(box.get("y", ""))
                if not line.findtext(f"{SVG}text[@class='name']", "").endswith(" (again)"):
                    places[line.get("data-frame")] = (x, y + 10)
        for line in panel.iter(f"{SVG}g"):
            if line.get("data-child"):
                check_arrow(line, places, trunks)


def check_arrow(line: ElementTree.Element, places: dict[str | None, tuple[float, float]], trunks: list[str]) -> None:
    up = line.get("data-frame") == line.get("data-parent")
    hangs = places[line.get("data-child") if up else line.get("data-parent")]
    edge, tip = (line.find(f"{SVG}path[@class='{kind}']") for kind in ("edge", "tip"))
    assert edge is not None
    assert tip is not None
    start, y, end = map(float, re.findall(r"[\d.]+", edge.get("d", ""))[:3])
    begin = start - (7 if up else 0)
    assert begin == pytest.approx(hangs[0] + 10)
    assert any(
        abs(x - begin) < 0.1 and abs(top - hangs[1] - 10) < 0.1 and bottom >= y - 0.1
        for x, top, bottom in (map(float, re.findall(r"[\d.]+", trunk)) for trunk in trunks)
    )
    assert tip.get("d", "").startswith(f"M{begin if up else end + 7:g} ")
    thick, dashed = float(edge.get("stroke-width", "")), edge.get("stroke-dasharray") is not None
    assert {"/tf": (True, False), "/tf_static": (False, False), "none": (False, True)}[line.get("data-topic", "")] == (
        thick > 2,
        dashed,
    )


def big() -> Robot:
    """Return a robot of more than sixty frames with more publishers than there are colours, and long names."""
    names = [f"frame_{number}" for number in range(60)]
    names[7] = "a_very_long_name_of_a_frame_that_somebody_exported_from_a_cad_program_v2"
    joints = []
    for at in range(1, 60):
        publisher = Publisher(STATIC_TRANSFORM_PUBLISHER, f"tf_{at}") if at % 4 == 0 else NOBODY
        publisher = Publisher("robot_state_publisher", "robot_state_publisher") if at % 3 else publisher
        kind = "fixed" if at % 4 == 0 else "revolute"
        parent = names[at - 1 if at % 5 else at // 2]
        joints.append(Joint(f"joint_{at}", kind, parent, names[at], limit=Limit(-1, 1), publisher=publisher))
    why = Publisher(UNPUBLISHED, about="many words " * 40 + "w" * 400)
    edges = (
        Edge("map", "frame_0", Publisher(NODE, "slam"), True, "a"),
        Edge("map", "frame_0", Publisher(NODE, "amcl"), True, "not a"),
        Edge("frame_5", "lost", why, False),
        Edge("frame_9", "camera", Publisher(NODE, "camera"), False, "b and a"),
    )
    return Robot("big", tuple(map(Link, names)), tuple(joints), edges=edges, modes=("a", "b"))


@pytest.mark.parametrize("which", ["rosorin", "ur5e", "turtlebot3_burger", "unitree_a1", "big", "one"])
def test_the_layout_is_readable(which: str) -> None:
    made = {"big": big, "one": lambda: Robot("one", (Link("base_link"),), ())}
    path = ROOT / ("descriptions" if which == "rosorin" else "examples") / which / "robot.yaml"
    robot = made[which]() if which in made else compiled(path).robot
    assert robot is not None
    text = drawn(robot, "frames.svg")
    check_layout(text)
    check_arrows(text)


@settings(max_examples=40, deadline=None)
@given(robots())
def test_the_layout_of_any_robot_is_readable(robot: Robot) -> None:
    text = drawn(robot, "frames.svg")
    check_layout(text)
    check_arrows(text)

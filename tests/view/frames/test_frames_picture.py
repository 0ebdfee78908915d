"""Pictures of the tree of frames: every frame once, and every edge as the list of frames has it."""

from __future__ import annotations

import html
import unicodedata
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import frames
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expression import evaluate
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Limit, Link, Output, Publisher, Robot
from rosorin_compile.model.frame_tree import Row
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.viewer.frames import frame_trees, write
from support.paths import ROOT, data_text
from support.robots import compiled

NOBODY = Publisher(UNPUBLISHED, about="not in /joint_states")
SVG = "{http://www.w3.org/2000/svg}"
OUTPUT = Output("picture", "frames_picture", "frames.svg")
EXAMPLES = ["rosorin", "ur5e", "turtlebot3_burger", "unitree_a1"]


def example(name: str) -> Robot:
    robot = compiled(ROOT / ("descriptions" if name == "rosorin" else "examples") / name / "robot.yaml").robot
    assert robot is not None
    return robot


def drawn(robot: Robot) -> str:
    text, said = write(robot, OUTPUT, Templates())
    assert said == []
    return text


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_edge_of_the_list_of_frames_is_drawn(name: str) -> None:
    robot = example(name)
    text = html.unescape(drawn(robot))
    for edge in frames.view(robot, Output("frames", "frames", "frames.md")).frames:
        assert f'data-parent="{edge.parent}" data-child="{edge.child}"' in text


def test_a_joint_that_another_node_publishes_keeps_its_name() -> None:
    """One row, not two, where a filter publishes what the description only knows."""
    joint = Joint("base_joint", "fixed", "odom", "base", publisher=NOBODY)
    edge = Edge("odom", "base", Publisher(NODE, "ekf"), moving=True, when="a")
    robot = Robot("r", (Link("odom"), Link("base")), (joint,), edges=(edge,), modes=("a",))
    on, off = frame_trees(robot, {})
    assert on.rows == (Row("odom", "base", "ekf", "", "/tf", "a", "odom", "base_joint", "fixed"),)
    assert [row.publisher for row in off.rows] == ["nobody"]


TURNS = data_text("robots/frames_picture_turns.yaml")


def test_publishers_that_take_turns_are_one_line_each(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(TURNS, "utf-8")
    made = compiled(path)
    assert made.robot is not None
    assert [(tree.when, row.who, row.joint) for tree in frame_trees(made.robot, {}) for row in tree.rows] == [
        ("carried is on", "nobody: it is carried", "mast_joint"),
        ("carried is off and sim is on", "gazebo", "mast_joint"),
        ("carried is off and sim is off", "tf_mast", "mast_joint"),
    ]


# The layout of a picture: nothing stands over anything, each arrow leads where it should.


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


@pytest.mark.parametrize("name", [*EXAMPLES, "big", "one"])
def test_the_layout_is_readable(name: str) -> None:
    made = {"big": big, "one": lambda: Robot("one", (Link("base_link"),), ())}
    check_layout(drawn(made[name]() if name in made else example(name)))


# Situations: the trees of frames that the modes of a robot make.


CONDITIONS = ("", "a", "not a", "a and b", "a or b", "not (a and c)", "a and not b or c", "b")


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(CONDITIONS), max_size=4), st.dictionaries(st.sampled_from("abc"), st.booleans()))
def test_situations_share_out_all_combinations_of_modes(whens: list[str], fixed: dict[str, bool]) -> None:
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "node"), False, when) for at, when in enumerate(whens))
    robot = Robot("modes", (Link("base"),), (), edges=edges, modes=("a", "b", "c"))
    found = frame_trees(robot, fixed)
    for states in product((False, True), repeat=3):
        combination = dict(zip("abc", states, strict=True))
        if any(combination[mode] != state for mode, state in fixed.items()):
            continue
        here = [one for one in found if any(modes.items() <= combination.items() for modes in one.modes)]
        assert len(here) == 1
        meant = [edge.child for edge in edges if not edge.when or evaluate(edge.when, combination.__getitem__)]
        assert [row.child for row in here[0].rows] == meant
    assert len({one.rows for one in found}) == len(found) == len({one.when for one in found})
    assert len({one.short for one in found}) == len(found)


def test_modes_whose_names_run_together_get_files_of_their_own() -> None:
    whens = ("a and b", "a_on_b", "A")
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "n"), False, when) for at, when in enumerate(whens))
    robot = Robot("r", (Link("base"),), (), edges=edges, modes=("a", "b", "a_on_b", "A"))
    shorts = [one.short for one in frame_trees(robot, {})]
    assert len({short.casefold() for short in shorts}) == len(shorts)

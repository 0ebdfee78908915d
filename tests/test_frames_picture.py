"""Pictures of the tree of frames: every frame once, every edge as the list of frames has it, nothing over anything."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import unicodedata
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import combinations, product
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots import OUTPUTS, ROOT, compiled, copy_of_rosorin, texts
from rosorin_compile.compare import agreement, compare, lines
from rosorin_compile.drawing import SUFFIXES, read
from rosorin_compile.drawing.edges import Row
from rosorin_compile.drawing.letters import PALETTE, wrapped
from rosorin_compile.drawing.situations import TooMany, situations
from rosorin_compile.drawing.tree import lines as tree_lines
from rosorin_compile.emit import Artifact, Facts, frames, frames_picture
from rosorin_compile.expression import evaluate
from rosorin_compile.model import (
    NODE,
    STATIC_TRANSFORM_PUBLISHER,
    UNPUBLISHED,
    Edge,
    Joint,
    Limit,
    Link,
    Output,
    Publisher,
    Robot,
)
from rosorin_compile.templating import Templates

SVG = "{http://www.w3.org/2000/svg}"
FILES = tuple(f"frames{suffix}" for suffix in SUFFIXES)
ODD = ("end", "a b", "x`y`", "[z]{q}", "sub|graph", "#35;", "%%c", "漢字", "\\n", "--", "style", "/ns/f", "**b**", "é")
NOBODY = Publisher(UNPUBLISHED, about="not in /joint_states")


def drawn(robot: Robot, file: str, modes: list[str] | None = None) -> str:
    text, said = frames_picture.emit(robot, output(file, modes), Templates())
    assert said == []
    return text


def output(file: str, modes: list[str] | None = None) -> Output:
    return Output("picture", "frames_picture", file, {} if modes is None else {"modes": modes})


def listed(robot: Robot) -> Facts:
    """Return what the list of frames says about parents, publishers and topics."""
    text, _ = frames.emit(robot, Output("frames", "frames", "frames.md"), Templates())
    told = ("parent", "publisher", "topic")
    return {fact: value for fact, value in frames.read(text).items() if fact.quantity.split(" ")[0] in told}


def tree(robot: Robot, modes: dict[str, bool]) -> Counter[tuple[str, str, str]]:
    """Return the edges that are there in some modes, with their topic, worked out without the code that draws."""
    found: Counter[tuple[str, str, str]] = Counter()
    for joint in robot.joints:
        nobody = joint.publisher.kind == UNPUBLISHED
        still = joint.type == "fixed" or joint.publisher.kind == STATIC_TRANSFORM_PUBLISHER
        found[joint.parent, joint.child, "none" if nobody else "/tf_static" if still else "/tf"] += 1
    for edge in robot.edges:
        if not edge.when or evaluate(edge.when, modes.__getitem__):
            nobody = edge.publisher.kind == UNPUBLISHED
            moves = edge.moving and edge.publisher.kind != STATIC_TRANSFORM_PUBLISHER
            found[edge.parent, edge.child, "none" if nobody else "/tf" if moves else "/tf_static"] += 1
    return found


# Robots with odd names, several publishers, modes, and frames that nobody publishes.

name = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z"), exclude_characters="<>&\"'"), min_size=1)
names = st.lists(
    st.one_of(st.sampled_from(ODD), name.map(lambda text: text[:20])), min_size=2, max_size=12, unique=True
)
WHENS = ("", "a", "not a", "a and not b", "b or not a")


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    found = draw(names)
    said = draw(st.sampled_from(("", "because", "a | b\n c", 'say "no" [x] {y} #1;')))
    publishers = [Publisher("robot_state_publisher", "robot_state_publisher"), Publisher(NODE, draw(name))]
    publishers += [Publisher(STATIC_TRANSFORM_PUBLISHER, draw(name)), Publisher(UNPUBLISHED, about=said)]
    joints = []
    for at, child in enumerate(found[1:], 1):
        parent = found[draw(st.integers(0, at - 1))]
        kind = draw(st.sampled_from(("fixed", "revolute")))
        publisher = draw(st.sampled_from(publishers if kind == "fixed" else [*publishers[:2], publishers[3]]))
        joints.append(Joint(f"{child} joint", kind, parent, child, limit=Limit(-1, 1), publisher=publisher))
    fresh = [text for text in draw(names) if text not in found]
    edges = []
    for at, child in enumerate(fresh):
        parent = draw(st.sampled_from([*found, *fresh[:at]]))
        edges.append(Edge(parent, child, draw(st.sampled_from(publishers)), draw(st.booleans())))
    top = next(text for text in ("odom", "odom 2", "odom 3") if text not in (*found, *fresh))
    when = draw(st.sampled_from(WHENS))
    edges.append(Edge(top, found[0], publishers[1], moving=True, when=when))
    if when:
        edges.append(Edge(top, found[0], Publisher(NODE, "another"), moving=True, when=f"not ({when})"))
    # A joint that the description knows and another node's transform above the same frame, as under a filter.
    below = [joint.child for joint in joints if joint.publisher.kind == UNPUBLISHED]
    if below:
        edges.append(Edge("filter frame", below[0], Publisher(NODE, "filter"), moving=True))
    return Robot("the robot", tuple(map(Link, found)), tuple(joints), edges=tuple(edges), modes=("a", "b"))


@settings(max_examples=60, deadline=None)
@given(robots(), st.sampled_from(FILES))
def test_every_frame_and_edge_as_in_the_list_of_frames(robot: Robot, file: str) -> None:
    text = drawn(robot, file)
    assert text == drawn(robot, file)
    said = frames_picture.read(text)
    assert {fact: value for fact, value in said.items() if fact.kind == "frame"} == listed(robot)
    kinds = {fact.name: value.value for fact, value in said.items() if (fact.kind, fact.quantity) == ("joint", "type")}
    assert kinds == ({joint.name: joint.type for joint in robot.joints} if file.endswith(".svg") else {})
    assert list(frames_picture.disagreements(robot, output(file), text)) == []


@settings(max_examples=40, deadline=None)
@given(robots(), st.sampled_from(FILES), st.sampled_from([[], ["a"], ["b"], ["a", "b"]]))
def test_a_picture_of_some_modes_shows_what_is_there_in_them(robot: Robot, file: str, modes: list[str]) -> None:
    (shown,) = read(drawn(robot, file, modes))
    meant = tree(robot, {mode: mode in modes for mode in robot.modes})
    assert Counter((row.parent, row.child, row.topic) for row in shown.edges) == meant
    frames = {link.name for link in robot.links} | {name for parent, child, _ in meant for name in (parent, child)}
    assert sorted(shown.frames) == sorted(frames)


@settings(max_examples=40, deadline=None)
@given(robots())
def test_every_frame_has_one_line_of_its_own(robot: Robot) -> None:
    for situation in situations(robot, {}):
        found = tree_lines(situation.edges, [link.name for link in robot.links])
        assert max(Counter(line.frame for line in found if not line.again).values()) == 1
        assert Counter(line.row for line in found if line.row) == Counter(situation.edges)
        for line in found:
            if line.row is not None:
                ends = (line.row.child, line.row.parent) if line.up else (line.row.parent, line.row.child)
                assert (found[line.on].frame, line.frame) == ends


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


def test_publishers_have_colours_of_their_own() -> None:
    root = ElementTree.fromstring(drawn(compiled().robot, "frames.svg"))
    found: dict[str, set[str]] = {}
    for line in root.iter(f"{SVG}g"):
        if line.get("data-publisher") not in (None, "nobody"):
            strokes = {part.get("stroke", "") for part in line if part.get("class") in ("edge", "box")}
            found.setdefault(line.get("data-publisher", ""), set()).update(strokes)
    assert len(found) == 7
    assert all(len(strokes) == 1 for strokes in found.values())
    assert len({stroke for strokes in found.values() for stroke in strokes}) == 7
    keys = {text.text for text in root.iter(f"{SVG}text") if text.get("class") == "key"}
    assert keys >= found.keys()
    assert len(set(PALETTE)) == len(PALETTE)


def test_words_are_wrapped_and_long_ones_broken() -> None:
    assert wrapped("one two three", 60, 12) == ["one two", "three"]
    assert "".join(wrapped("x" * 100, 60, 12)) == "x" * 100


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz is not installed")
@settings(max_examples=12, deadline=None)
@given(robots())
def test_graphviz_reads_the_same_tree(robot: Robot) -> None:
    done = subprocess.run(
        ["dot", "-Tdot_json"], input=drawn(robot, "frames.dot", ["a"]), capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    graph = json.loads(done.stdout)
    labels = {
        node["_gvid"]: node["label"].replace("\\\\", "\\")
        for node in graph["objects"]
        if not node["name"].startswith("c")
    }
    styles = {"solid": "moving or static", "dashed": "none"}
    found = Counter((labels[edge["tail"]], labels[edge["head"]], styles[edge["style"]]) for edge in graph["edges"])
    meant = tree(robot, {"a": True, "b": False})
    assert found == Counter((p, c, "none" if topic == "none" else "moving or static") for p, c, topic in meant)


def test_mermaid_gets_no_letter_that_means_something_to_it() -> None:
    links = tuple(map(Link, ("base", *ODD)))
    joints = tuple(Joint(f"j {name}", "fixed", "base", name, publisher=Publisher(NODE, name)) for name in ODD)
    text = drawn(Robot("odd", links, joints), "frames.mmd")
    for line in text.splitlines():
        if not line.lstrip().startswith("%%"):
            said = re.findall(r'"([^"]*)"', line)
            assert all(re.fullmatch(r"(?:[\w/.:, -]|#\d+;|<br>)*", one) for one in said), line
    assert sorted(read(text)[0].frames) == sorted(("base", *ODD))


def test_a_page_of_markdown_has_a_chart_for_each_situation() -> None:
    page = drawn(compiled().robot, "frames.md")
    assert re.findall(r"^## (.*)$", page, re.MULTILINE) == ["Slam is on", "Slam is off"]
    assert page.count("```mermaid\n") == 2
    assert page.count("```") == 4


# Situations.

CONDITIONS = ("", "a", "not a", "a and b", "a or b", "not (a and c)", "a and not b or c", "b")


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from(CONDITIONS), max_size=4), st.dictionaries(st.sampled_from("abc"), st.booleans()))
def test_situations_share_out_all_combinations_of_modes(whens: list[str], fixed: dict[str, bool]) -> None:
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "node"), False, when) for at, when in enumerate(whens))
    robot = Robot("modes", (Link("base"),), (), edges=edges, modes=("a", "b", "c"))
    found = situations(robot, fixed)
    for states in product((False, True), repeat=3):
        combination = dict(zip("abc", states, strict=True))
        if any(combination[mode] != state for mode, state in fixed.items()):
            continue
        here = [one for one in found if any(modes.items() <= combination.items() for modes in one.modes)]
        assert len(here) == 1
        meant = [edge.child for edge in edges if not edge.when or evaluate(edge.when, combination.__getitem__)]
        assert [row.child for row in here[0].edges] == meant
    assert len({one.edges for one in found}) == len(found) == len({one.label for one in found})
    assert len({one.short for one in found}) == len(found)


def labels(whens: tuple[str, ...], modes: tuple[str, ...] = ("a", "b", "c")) -> list[tuple[str, str]]:
    edges = tuple(Edge("base", f"frame {at}", Publisher(NODE, "n"), False, when) for at, when in enumerate(whens))
    return [(one.label, one.short) for one in situations(Robot("r", (Link("base"),), (), edges=edges, modes=modes), {})]


def test_situations_are_said_in_few_words() -> None:
    assert labels(()) == [("", "")]
    assert labels(("a",)) == [("a is on", "a_on"), ("a is off", "a_off")]
    assert labels(("a and not b",)) == [("b is on, or a is off", "b_on"), ("a is on and b is off", "a_on_b_off")]


def test_modes_whose_names_run_together_get_files_of_their_own() -> None:
    shorts = [short for _, short in labels(("a and b", "a_on_b", "A"), ("a", "b", "a_on_b", "A"))]
    assert len({short.casefold() for short in shorts}) == len(shorts)


def test_too_many_trees_are_refused() -> None:
    modes = tuple("abcdef")
    edges = tuple(Edge("base", f"f{mode}", Publisher(NODE, "n"), False, mode) for mode in modes)
    robot = Robot("r", (Link("base"),), (), edges=edges, modes=modes)
    message = "the tree of frames differs in 64 combinations of modes: too many to show"
    with pytest.raises(TooMany, match=re.escape(message)):
        situations(robot, {})
    text, (problem,) = frames_picture.emit(robot, output("frames.svg"), Templates())
    assert (text, problem.rule, problem.severity, problem.message) == ("", "too-many-pictures", "error", message)
    assert problem.help == "say which modes are on, one picture each: modes: [NAME, ...]"
    assert len(situations(robot, {"a": True})) == 32
    many = tuple(f"m{at}" for at in range(12))
    edges = tuple(Edge("base", f"f{mode}", Publisher(NODE, "n"), False, mode) for mode in many)
    robot = Robot("r", (Link("base"),), (), edges=edges, modes=many)
    with pytest.raises(TooMany, match="the frames depend on 12 modes together"):
        situations(robot, {})
    (one,) = situations(robot, dict.fromkeys(many, True))
    assert one.label.startswith("m0 is on and m1 is on and ")


# As an artifact.


def test_the_reference_robot_has_a_picture_for_each_mode() -> None:
    made = compiled()
    assert made.robot is not None
    for file, modes, label, owner in (
        ("frames_slam.svg", ["slam"], "slam is on", "slam_toolbox"),
        ("frames_amcl.svg", [], "slam is off", "amcl"),
    ):
        text = (OUTPUTS / file).read_text("utf-8")
        assert text == texts(made)[file] == drawn(made.robot, file, modes)
        (shown,) = read(text)
        assert (shown.label, len(shown.frames)) == (label, 23)
        publisher = {row.child: row.publisher for row in shown.edges if row.published}
        assert (publisher["odom"], publisher["base_link"], publisher["laser"]) == (owner, "ekf", "tf_base_laser")
    said = frames_picture.read(texts(made)["frames_slam.svg"]).items()
    assert {item for item in said if item[0].kind == "frame"} < set(listed(made.robot).items())


FAULTS = [
    ("frames.svg", 'data-parent="link1"', 'data-parent="link3"', "it should show the frame|link1 -> link2"),
    ("frames.svg", '>ekf</text>\n<text class="topic"', '>efk</text>\n<text class="topic"', 'a line shows "efk"'),
    ("frames.svg", "joint1 (revolute)", "joint1 (continuous)", "joint joint1 (continuous)"),
    ("frames.dot", '[label="laser"]', '[label="lidar"]', "it should show the frame laser"),
    ("frames.dot", '[label="ekf\\n/tf"', '[label="ekf\\n/tf_static"', 'an edge shows "/tf_static" and says "/tf"'),
    ("frames.mmd", '"ekf<br>/tf"', '"amcl<br>/tf"', "odom -> base_link, published by amcl on /tf"),
    ("frames.md", '["imu_link"]', '["imu"]', "it should not show the frame imu"),
    ("frames.mmd", 'situation ["slam is on"]', 'situation ["slam"]', "it does not show the situations that it should"),
]


@pytest.mark.parametrize(("file", "old", "new", "said"), FAULTS)
def test_agreement_catches_a_wrong_picture(file: str, old: str, new: str, said: str) -> None:
    robot = compiled().robot
    assert robot is not None
    robot = replace(robot, outputs=(output(file),))
    text = drawn(robot, file)
    assert agreement(robot, [Artifact(file, text, "frames_picture", "picture")]) == []
    assert old in text
    found = agreement(robot, [Artifact(file, text.replace(old, new, 1), "frames_picture", "picture")])
    assert {problem.rule for problem in found} == {"artifacts-disagree"}
    assert any(re.search(said, problem.message) or said in problem.message for problem in found), found


@pytest.mark.parametrize(
    "text", ["", "<svg", "<svg/>", "<!DOCTYPE x><svg/>", "digraph {}", "// edge [3]", "%% edge []"]
)
def test_a_damaged_picture_is_no_traceback(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        frames_picture.read(text)


@settings(max_examples=80, deadline=None)
@given(st.sampled_from(FILES), st.data())
def test_any_damage_is_read_or_refused(file: str, data: st.DataObject) -> None:
    text = drawn(Robot("r", (Link("a"), Link("b c")), (Joint("j", "fixed", "a", "b c"),)), file)
    at = data.draw(st.integers(0, len(text) - 1))
    damaged = text[:at] + data.draw(st.text(max_size=2)) + text[at + data.draw(st.integers(0, 3)) :]
    with suppress(ValueError):
        frames_picture.read(damaged)


def test_check_speaks_of_the_meaning_first() -> None:
    made = compiled()
    assert made.robot is not None
    committed = {artifact.file: artifact.text.encode() for artifact in made.artifacts}
    committed["frames_amcl.svg"] = committed["frames_amcl.svg"].replace(b"amcl", b"acml")
    said = lines(compare(made.robot, made.artifacts, committed))
    assert said[0] == "odom when not slam: publisher acml -> amcl: frames_amcl"
    committed["frames_amcl.svg"] = texts(made)["frames_amcl.svg"].replace("\n<text", "\n  <text").encode()
    said = lines(compare(made.robot, made.artifacts, committed))
    assert said[0] == "frames_amcl.svg: same meaning, different text"


def test_the_same_bytes_whatever_the_order_of_sets(tmp_path: Path) -> None:
    found = set()
    for seed in ("0", "1"):
        target = tmp_path / f"{seed}.svg"
        done = subprocess.run(
            [sys.executable, "-m", "rosorin_compile", "frames", "rosorin", "-o", str(target)],
            cwd=ROOT,
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        found.add(target.read_bytes())
    assert len(found) == 1


def test_a_joint_that_another_node_publishes_keeps_its_name() -> None:
    """One row, not two, where a filter publishes what the description only knows."""
    joint = Joint("base_joint", "fixed", "odom", "base", publisher=NOBODY)
    edge = Edge("odom", "base", Publisher(NODE, "ekf"), moving=True, when="a")
    robot = Robot("r", (Link("odom"), Link("base")), (joint,), edges=(edge,), modes=("a",))
    on, off = situations(robot, {})
    assert on.edges == (Row("odom", "base", "ekf", "", "/tf", "a", "odom", "base_joint", "fixed"),)
    assert [row.publisher for row in off.edges] == ["nobody"]
    assert list(frames_picture.disagreements(robot, output("f.svg"), drawn(robot, "f.svg"))) == []


TURNS = """\
robot: turns
modes: {sim: simulated, carried: by hand}
publishers: {gazebo: {}}
links: {base_link: {}, mast: {}}
joints:
  mast_joint:
    type: fixed
    parent: base_link
    child: mast
    publisher:
      - {by: gazebo, when: sim and not carried}
      - {by: {static_transform_publisher: tf_mast}, when: not sim and not carried}
      - {by: {none: it is carried}, when: carried}
outputs:
  static_tf: {file: tf.launch.py}
  frames: {file: frames.md}
  frames_picture: {file: frames.svg}
"""


def test_publishers_that_take_turns_are_one_line_each(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(TURNS, "utf-8")
    made = compiled(path)
    assert made.robot is not None
    assert agreement(made.robot, [one for one in made.artifacts if one.backend == "frames_picture"]) == []
    said = [(one.label, row.who, row.joint) for one in read(texts(made)["frames.svg"]) for row in one.edges]
    assert said == [
        ("carried is on", "nobody: it is carried", "mast_joint"),
        ("carried is off and sim is on", "gazebo", "mast_joint"),
        ("carried is off and sim is off", "tf_mast", "mast_joint"),
    ]
    drawn_facts = frames_picture.read(texts(made)["frames.svg"])
    assert {fact: value for fact, value in drawn_facts.items() if fact.kind == "frame"} == listed(made.robot)


def test_a_new_robot_may_ask_for_any_kind(tmp_path: Path) -> None:
    more = "".join(f"  p{at}: {{backend: frames_picture, file: p{at}/{file}}}\n" for at, file in enumerate(FILES))
    path = copy_of_rosorin(
        tmp_path, {"robot.yaml": ("  frames: {file: frames.md}\n", f"  frames: {{file: frames.md}}\n{more}")}
    )
    made = compiled(path)
    assert made.robot is not None
    assert agreement(made.robot, made.artifacts) == []
    assert len(made.artifacts) == 8 + len(FILES)

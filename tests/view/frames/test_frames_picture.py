"""Pictures of the tree of frames: every frame once, every edge as the list of frames has it, whatever the format."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.agreement import agreement
from rosorin_compile.formats import frames
from rosorin_compile.language.expression import evaluate
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Link, Output, Publisher, Robot
from rosorin_compile.model.frame_tree import Row
from rosorin_compile.model.frame_tree import lines as tree_lines
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.viewer.drawing.situations import situations
from support.paths import OUTPUTS, ROOT
from support.pictures import FILES, NOBODY, ODD, drawn, robots
from support.robots import compiled, copy_of_rosorin, texts
from support.shown import read

LIST = Output("frames", "frames", "frames.md")


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


@settings(max_examples=60, deadline=None)
@given(robots(), st.sampled_from(FILES))
def test_every_frame_and_edge_as_in_the_list_of_frames(robot: Robot, file: str) -> None:
    text = drawn(robot, file)
    assert text == drawn(robot, file)
    listed = {(edge.parent, edge.child, edge.publisher.name) for edge in frames.view(robot, LIST).frames}
    shown = {(row.parent, row.child, row.who) for situation in read(text) for row in situation.edges}
    assert {row for row in shown if not row[2].startswith("nobody")} <= listed
    assert {row[:2] for row in shown} == {row[:2] for row in listed}


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


def test_a_new_robot_may_ask_for_any_kind(tmp_path: Path) -> None:
    more = "".join(f"  p{at}: {{backend: frames_picture, file: p{at}/{file}}}\n" for at, file in enumerate(FILES))
    path = copy_of_rosorin(
        tmp_path, {"robot.yaml": ("  frames: {file: frames.md}\n", f"  frames: {{file: frames.md}}\n{more}")}
    )
    made = compiled(path)
    assert made.robot is not None
    assert agreement(made.robot, made.artifacts) == []

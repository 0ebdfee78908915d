"""Pictures of the tree of frames: every frame once, and every edge as the list of frames has it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.committed import compare, lines
from rosorin_compile.formats import Facts, frames
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Edge, Joint, Link, Output, Publisher, Robot
from rosorin_compile.model.frame_tree import Row
from rosorin_compile.model.frame_tree import lines as tree_lines
from rosorin_compile.model.joint import NODE
from rosorin_compile.viewer import frames_picture
from rosorin_compile.viewer.frame_trees import frame_trees
from support.paths import OUTPUTS, ROOT
from support.pictures import NOBODY, drawn, robots
from support.robots import compiled, texts


def listed(robot: Robot) -> Facts:
    """Return what the list of frames has of parents, publishers and topics."""
    text, _ = frames.write(robot, Output("frames", "frames", "frames.md"), Templates())
    quantities = ("parent", "publisher", "topic")
    return {fact: value for fact, value in frames.read(text).items() if fact.quantity.split(" ")[0] in quantities}


@settings(max_examples=60, deadline=None)
@given(robots())
def test_every_frame_and_edge_as_in_the_list_of_frames(robot: Robot) -> None:
    text = drawn(robot, "frames.svg")
    assert text == drawn(robot, "frames.svg")
    facts = frames_picture.read(text)
    assert {fact: value for fact, value in facts.items() if fact.kind == "frame"} == listed(robot)
    kinds = {fact.name: value.value for fact, value in facts.items() if (fact.kind, fact.quantity) == ("joint", "type")}
    assert kinds == {joint.name: joint.type for joint in robot.joints}


@settings(max_examples=40, deadline=None)
@given(robots())
def test_every_frame_has_one_line_of_its_own(robot: Robot) -> None:
    for tree in frame_trees(robot, {}):
        found = tree_lines(tree.edges, [link.name for link in robot.links])
        assert max(Counter(line.frame for line in found if not line.again).values()) == 1
        assert Counter(line.row for line in found if line.row) == Counter(tree.edges)
        for line in found:
            if line.row is not None:
                ends = (line.row.child, line.row.parent) if line.up else (line.row.parent, line.row.child)
                assert (found[line.on].frame, line.frame) == ends


def test_the_reference_robot_has_a_picture_for_each_mode() -> None:
    made = compiled()
    assert made.robot is not None
    for file, modes, label, owner in (
        ("frames_slam.svg", ["slam"], "slam is on", "slam_toolbox"),
        ("frames_amcl.svg", [], "slam is off", "amcl"),
    ):
        text = (OUTPUTS / file).read_text("utf-8")
        assert text == texts(made)[file] == drawn(made.robot, file, modes)
        assert re.findall(r'data-when="(.*?)" aria', text) == [label]
        assert f'data-parent="map" data-child="odom" data-publisher="{owner}"' in text
    facts = frames_picture.read(texts(made)["frames_slam.svg"]).items()
    assert {item for item in facts if item[0].kind == "frame"} < set(listed(made.robot).items())


@pytest.mark.parametrize("text", ["", "<svg", "<svg/>", "<!DOCTYPE x><svg/>", "digraph {}"])
def test_a_damaged_picture_is_no_traceback(text: str) -> None:
    with pytest.raises(ValueError, match=r".+"):
        frames_picture.read(text)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_any_damage_is_read_or_refused(data: st.DataObject) -> None:
    text = drawn(Robot("r", (Link("a"), Link("b c")), (Joint("j", "fixed", "a", "b c"),)), "frames.svg")
    at = data.draw(st.integers(0, len(text) - 1))
    damaged = text[:at] + data.draw(st.text(max_size=2)) + text[at + data.draw(st.integers(0, 3)) :]
    with suppress(ValueError):
        frames_picture.read(damaged)


def test_check_reports_the_meaning_first() -> None:
    made = compiled()
    assert made.robot is not None
    committed = {artifact.file: artifact.text.encode() for artifact in made.artifacts}
    committed["frames_amcl.svg"] = committed["frames_amcl.svg"].replace(b"amcl", b"acml")
    reported = lines(compare(made.robot, made.artifacts, committed))
    assert reported[0] == "odom when not slam: published by acml -> amcl: frames_amcl"
    committed["frames_amcl.svg"] = texts(made)["frames_amcl.svg"].replace("\n<text", "\n  <text").encode()
    reported = lines(compare(made.robot, made.artifacts, committed))
    assert reported[0] == "frames_amcl.svg: same meaning, different text"


def test_the_same_bytes_whatever_the_order_of_sets(tmp_path: Path) -> None:
    found = set()
    for seed in ("0", "1"):
        target = tmp_path / f"{seed}.svg"
        command = [sys.executable, "-m", "rosorin_compile", "frames", "rosorin", "-o", str(target)]
        subprocess.run(command, cwd=ROOT, env={**os.environ, "PYTHONHASHSEED": seed}, check=True)
        found.add(target.read_bytes())
    assert len(found) == 1


def test_a_joint_that_another_node_publishes_keeps_its_name() -> None:
    """One row, not two, where a filter publishes what the description only knows."""
    joint = Joint("base_joint", "fixed", "odom", "base", publisher=NOBODY)
    edge = Edge("odom", "base", Publisher(NODE, "ekf"), moving=True, when="a")
    robot = Robot("r", (Link("odom"), Link("base")), (joint,), edges=(edge,), modes=("a",))
    on, off = frame_trees(robot, {})
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
    assert [(tree.label, row.who, row.joint) for tree in frame_trees(made.robot, {}) for row in tree.edges] == [
        ("carried is on", "nobody: it is carried", "mast_joint"),
        ("carried is off and sim is on", "gazebo", "mast_joint"),
        ("carried is off and sim is off", "tf_mast", "mast_joint"),
    ]
    facts = frames_picture.read(texts(made)["frames.svg"])
    assert {fact: value for fact, value in facts.items() if fact.kind == "frame"} == listed(made.robot)

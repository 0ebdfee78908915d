"""Pictures of the tree of frames: every frame once, and every edge as the list of frames has it."""

from __future__ import annotations

import html
import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

from hypothesis import given, settings

from rosorin_compile.formats import frames
from rosorin_compile.model import Edge, Joint, Link, Output, Publisher, Robot
from rosorin_compile.model.frame_tree import Row
from rosorin_compile.model.frame_tree import lines as tree_lines
from rosorin_compile.model.joint import NODE
from rosorin_compile.viewer.frame_trees import frame_trees
from support.paths import OUTPUTS, ROOT
from support.pictures import NOBODY, drawn, robots
from support.robots import compiled, texts

LIST = Output("frames", "frames", "frames.md")


@settings(max_examples=60, deadline=None)
@given(robots())
def test_every_frame_and_edge_as_in_the_list_of_frames(robot: Robot) -> None:
    text = drawn(robot, "frames.svg")
    assert text == drawn(robot, "frames.svg")
    for edge in frames.view(robot, LIST).frames:
        assert f'data-parent="{edge.parent}" data-child="{edge.child}"' in html.unescape(text)


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

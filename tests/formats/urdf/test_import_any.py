"""What holds for every URDF: no text makes the reader fail, and a robot comes back from its own URDF unchanged."""

from __future__ import annotations

import re

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map, Seq
from support.importing import accepted, meaning, read_any, robot, urdf_of

FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)

SEED = """<?xml version="1.0"?>
<!-- two links -->
<robot name="seed" xmlns:sim="http://sim.invalid">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual name="v"><origin xyz="1 2 3" rpy="0 .5 1e-3"/><geometry><box size="1 2 3"/></geometry></visual>
    <collision><geometry><mesh filename="a.stl" scale="1 1 1"/></geometry></collision>
  </link>
  <link name="arm"/> <!-- moves -->
  <joint name="j" type="revolute">
    <parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="k"/><dynamics damping="1"/>
  </joint>
  <joint name="k" type="continuous"><parent link="arm"/><child link="tip"/></joint><link name="tip"/>
  <gazebo><sim:x>text</sim:x></gazebo>
</robot>
"""


@FOLDER
@given(st.text() | st.binary())
def test_any_text_is_refused_in_words(tmp_path, text):
    assert read_any(text, tmp_path / "robot.urdf").tree is None


PIECES = st.sampled_from(
    [
        *("<", ">", "/>", '"', "'", "&", "--", "<!--", "-->", "<![CDATA[", "]]>", "<?x?>", "<!DOCTYPE a>", "\0", "\t"),
        *("nan", "1e999", "1,5", "${x}", "<link name='arm'/>", "<robot>", "</robot>", "<origin/>", "type=''", "\n"),
        *(["0", "-", "arm", "base", "link", "joint", "fixed", "planar", "\u2028", "&#0;", "&#38;", "&lt;", "é"]),
        "xyz='1 2'",
    ]
)


@FOLDER
@given(st.lists(st.tuples(st.floats(0, 1), st.integers(0, 12), PIECES), min_size=1, max_size=4), st.booleans())
def test_any_edit_is_read_or_refused_in_words(tmp_path, edits, lenient):
    text = SEED
    for where, gone, piece in edits:
        at = int(where * len(text))
        text = text[:at] + piece + text[at + gone :]
    read_any(text, tmp_path / "robot.urdf", lenient)


@settings(FOLDER, max_examples=60)
@given(robot())
def test_robot_comes_back_unchanged(tmp_path, text):
    first = read_any(text, tmp_path / "robot.urdf")
    assert first.tree is not None, report(arrange(first.diagnostics))
    again = read_any(urdf_of(first.tree), tmp_path / "robot.urdf")
    assert again.tree is not None, report(arrange(again.diagnostics))
    assert meaning(again.tree) == meaning(first.tree)
    assert accepted(again.tree) == accepted(first.tree)
    assert places(first.tree)


def places(tree: Map) -> int:
    """Check that the place of every number covers its digits; return how many there are."""
    checked = 0
    for value, span in numbers(tree):
        digits = span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length]
        if re.fullmatch(r"[-+0-9.eE]+", digits):
            assert float(digits) == value
            checked += 1
        else:  # a value that is not written has the place of an element
            assert value == 0
            assert digits == "limit"
    return checked


def numbers(tree: Map):
    waiting = [(tree, tree.span)]
    while waiting:
        value, span = waiting.pop()
        if isinstance(value, Map):
            waiting += [(value[key], value.value_spans[key]) for key in value]
        elif isinstance(value, Seq):
            waiting += zip(value, value.value_spans, strict=True)
        elif isinstance(value, (int, float)):
            yield value, span

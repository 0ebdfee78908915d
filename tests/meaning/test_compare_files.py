"""Committed files that somebody edited, added, removed or damaged; and how differences of text are shown."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.output.committed import Comparison, lines
from support.comparing import BASE, COMMITTED, against, edited, meaning
from support.robots import compiled, copy_of_rosorin

IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"

BEHIND = COMMITTED["rosorin.xml"].count(b"\n") + 1  # the line after its last one

EDITS = [
    pytest.param(
        *("rosorin.urdf", "0.00074282 0.08513", "0.00074282 0.08613", 1),
        "link3 moved 1.0 mm in link2: origin z 0.08613 -> 0.08513 m: urdf",
        id="origin",
    ),
    pytest.param(
        *("rosorin.urdf", '<box size="0.05377', '<box size="0.06377', 1),
        "base_link collision: box min x 0.016206 -> 0.021206 m, max x 0.079976 -> 0.074976 m: urdf",
        id="box",
    ),
    pytest.param(
        *("rosorin.xml", 'axis="0 1 0" range="-2.09 2.09"', 'axis="0 1 0.5" range="-2.09 2.09"', 1),
        "joint3 axis 0 1 0.5 -> 0 1 0 (turned 26.6 deg): mjcf",
        id="axis",
    ),
    pytest.param(
        *("frames.md", "| tuck         | joint1             | 0 rad", "| tuck         | joint1             | 1 rad", 1),
        "pose tuck: joint1 1 -> 0 rad (-57.3 deg): frames",
        id="pose",
    ),
    pytest.param(
        *("frames.md", "slam_toolbox", "slam", 1),
        "odom when slam: published by slam -> slam_toolbox: frames",
        id="edge",
    ),
    pytest.param(
        *("robot_model.json", "0.014 to 0.208 m", "0.014 to 0.218 m", 1),
        'base_footprint height map stand_in "... cells, 0.014 to 0.218 m, a block at the rear) and nothing m..." ->'
        ' "... cells, 0.014 to 0.208 m, a block at the rear) and nothing m...": robot_model',
        id="text",
    ),
    pytest.param(*("rosorin.urdf", "\n", "\n\n", 99), "rosorin.urdf: same meaning, different text", id="lines"),
    pytest.param(*("rosorin.urdf", "\n", "\r\n", 999), "rosorin.urdf: same meaning, different text", id="line-ends"),
    pytest.param(*("rosorin.urdf", '"1"', '"1.0e0"', 9), "rosorin.urdf: same meaning, different text", id="spelling"),
    pytest.param(*("rosorin.urdf", "<!--", "<!-- x", 1), "rosorin.urdf: same meaning, different text", id="comment"),
    pytest.param(
        *("robot_model.json", ": ", ":", 999), "robot_model.json: same meaning, different text", id="json-spaces"
    ),
    pytest.param(
        *("static_tf.launch.py", "# factory", "# maker", 1),
        "static_tf.launch.py: same meaning, different text",
        id="python-comment",
    ),
    pytest.param(*("frames.md", "| ---", "| -----", 1), "frames.md: same meaning, different text", id="table"),
    pytest.param(
        *("rosorin.xml", "implicitfast", "Euler", 1),
        "rosorin.xml: different text; nothing that is compared by meaning differs: "
        'line 6: integrator="Euler" -> integrator="implicitfast"',
        id="not-compared",
    ),
    pytest.param(
        *("rosorin.xml", "</mujoco>", "", 1),
        "rosorin.xml: the committed file is damaged and compared as text alone "
        f"(no element found: line {BEHIND}, column 0): line {BEHIND - 1}: nothing -> </mujoco>",
        id="damaged-xml",
    ),
    pytest.param(
        *("robot_model.json", '"parent": "base_link"', '"parent": 7', 1),
        "robot_model.json: the committed file is damaged and compared as text alone "
        '(not a driver\'s model: 7 does not match type "string"): '
        'line 1: 7, -> "base_link",',
        id="damaged-json",
    ),
]


@pytest.mark.parametrize(("name", "old", "new", "count", "said"), EDITS)
def test_an_edit_by_hand_is_named(name: str, old: str, new: str, count: int, said: str) -> None:
    comparison = edited(name, old, new, count)
    assert meaning(comparison) == [said]
    assert [(text.file, text.kind) for text in comparison.texts] == [(name, "changed")]
    assert lines(comparison)[-1] == IF_MEANT


def test_an_edit_and_a_change_are_told_apart(tmp_path: Path) -> None:
    made = compiled(copy_of_rosorin(tmp_path, {"arm.yaml": ("0.00074282, 0.08513]", "0.00074282, 0.08613]")}))
    urdf = COMMITTED["rosorin.urdf"].replace(b"0.00074282 0.08513", b"0.00074282 0.0853")
    assert meaning(against(made, {**COMMITTED, "rosorin.urdf": urdf})) == [
        "link3 moved 0.83 mm in link2: origin z 0.0853 -> 0.08613 m: urdf",
        "link3 moved 1.0 mm in link2: origin z 0.08513 -> 0.08613 m: urdf_sim, mjcf, robot_model, frames",
    ]


def test_nothing_differs() -> None:
    comparison = against(BASE, COMMITTED)
    assert comparison == Comparison((), (), True)
    assert lines(comparison) == []


def test_files_that_are_missing_extra_or_no_text() -> None:
    committed = {**COMMITTED, "notes\x1b[31m.txt": b"", "rosorin.xml": b"\xff\xfe"}
    del committed["rosorin.urdf"]
    comparison = against(BASE, committed)
    assert lines(comparison) == [
        "notes\\x1b[31m.txt: no artifact of this robot; remove it, or run rosorin-compile all --prune",
        "rosorin.urdf: missing; rosorin-compile all writes it",
        "rosorin.xml: the committed file is no UTF-8 text; rosorin-compile all writes it again",
    ]
    assert [text.kind for text in comparison.texts] == ["extra", "missing", "not-text"]
    assert not comparison.same


def test_nothing_is_committed() -> None:
    comparison = against(BASE, {})
    assert comparison.changes == ()
    assert [text.kind for text in comparison.texts] == ["missing"] * 10


def test_a_file_of_a_template_is_compared_as_text(tmp_path: Path) -> None:
    first = copy_of_rosorin(tmp_path)
    (first.parent / "mine.txt.jinja").write_text(
        "{{ robot.name }}: {{ number(robot.joint['joint3'].origin.xyz[2]) }}\n"
    )
    text = first.read_text("utf-8").replace(
        "outputs:\n", "outputs:\n  mine: {file: mine.txt, template: mine.txt.jinja}\n"
    )
    first.write_text(text, "utf-8")
    comparison = against(compiled(first), {**COMMITTED, "mine.txt": b"rosorin: 0.08\n"})
    diff = ["--- committed/mine.txt", "+++ compiled/mine.txt", "@@ -1 +1 @@", "-rosorin: 0.08", "+rosorin: 0.08513"]
    assert lines(comparison) == ["", *diff, "", IF_MEANT]


def test_the_diff_is_a_unified_diff_that_shows_what_differs() -> None:
    said = lines(edited("rosorin.urdf", "0.00074282 0.08513", "0.00074282 0.08613"))
    assert said[1:5] == ["", "--- committed/rosorin.urdf", "+++ compiled/rosorin.urdf", "@@ -176,7 +176,7 @@"]
    assert '-    <origin xyz="0.00025563 0.00074282 0.08613" rpy="0 0 0"/>' in said
    assert '+    <origin xyz="0.00025563 0.00074282 0.08513" rpy="0 0 0"/>' in said


def test_a_long_diff_is_cut() -> None:
    comparison = edited("robot_model.json", "0.00074282, 0.08513", "0.00074282, 0.08613")
    short, full = lines(comparison), lines(comparison, full=True)
    assert max(map(len, short)) < 170
    assert f"+{COMMITTED['robot_model.json'].decode().rstrip()}" in full
    many = edited("rosorin.urdf", "\n", "\n\n", 999)
    assert lines(many)[-3].endswith(" more lines (--full shows them)")
    assert len(lines(many)) < 50 < len(lines(many, full=True))


def test_line_ends_and_control_characters_are_made_visible() -> None:
    said = lines(edited("static_tf.json", '"robot": "rosorin"', '"robot": "\x1b[31mros\torin"'))
    assert '-  "robot": "\\x1b[31mros\torin",' in said
    said = lines(edited("static_tf.json", "}\n", "}\r\n", 99))
    assert any(line.startswith("-") and line.endswith("}\\r") for line in said)
    ends = lines(against(BASE, {**COMMITTED, "static_tf.json": COMMITTED["static_tf.json"].rstrip(b"\n")}))
    assert ends[-5:-2] == ["-}", "\\ No newline at end of file", "+}"]


def test_the_order_of_the_committed_files_makes_no_difference() -> None:
    changed = {**COMMITTED, "b": b"", "a": b"", "rosorin.urdf": b"<robot/>", "frames.md": b""}
    assert against(BASE, changed) == against(BASE, dict(reversed(changed.items())))


NUMBERS = ("NaN", "-Infinity", "1e308", "1e999", "9" * 400, "null", "[]", "true", '"a"', "", "1 2", "-0")


@given(st.sampled_from(sorted(COMMITTED)), st.randoms(use_true_random=False), st.sampled_from(NUMBERS))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_no_damage_makes_the_comparison_fail(name: str, random: Random, number: str) -> None:
    text = COMMITTED[name].decode()
    place = random.choice(list(re.finditer(r"-?\d+(\.\d+)?(e-?\d+)?", text)))
    numbered = text[: place.start()] + number + text[place.end() :]
    cut = text[: random.randrange(len(text))]
    garbage = bytes(random.randrange(256) for _ in range(200))
    for damaged in (numbered.encode(), cut.encode(), garbage, cut.encode() + garbage):
        comparison = against(BASE, {**COMMITTED, name: damaged})
        assert lines(comparison), (name, damaged)
        assert not comparison.same

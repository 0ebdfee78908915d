"""Committed files that somebody edited, added, removed or damaged; and how differences of text are shown."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.golden_check import Comparison, lines
from support.comparing import BASE, COMMITTED, against, edited, meaning
from support.paths import data_text
from support.robots import compiled, copy_of_rosorin

IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"

END = COMMITTED["rosorin.xml"].count(b"\n")


@pytest.mark.parametrize("case", yaml.safe_load(data_text("cases/edits_by_hand.yaml")), ids=lambda case: case["id"])
def test_an_edit_by_hand_is_named(case: dict[str, Any]) -> None:
    comparison = edited(*(case[key] for key in ("file", "old", "new", "count")))
    said = case["said"].replace("{last}", str(END)).replace("{behind}", str(END + 1))
    assert meaning(comparison) == [said]
    assert [(text.file, text.kind) for text in comparison.texts] == [(case["file"], "changed")]
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
    assert comparison == Comparison((), ())
    assert lines(comparison) == []


def test_files_that_are_missing_extra_or_no_text() -> None:
    committed = {**COMMITTED, "notes\x1b[31m.txt": b"", "rosorin.xml": b"\xff\xfe"}
    del committed["rosorin.urdf"]
    comparison = against(BASE, committed)
    assert lines(comparison) == [
        "notes\\x1b[31m.txt: no artifact of this robot; remove it, or run rosorin-compile all --prune",
        "rosorin.urdf: missing; rosorin-compile all writes it",
        "rosorin.xml: the committed file is not UTF-8 text; rosorin-compile all writes it again",
    ]
    assert [text.kind for text in comparison.texts] == ["extra", "missing", "not-text"]
    assert comparison.texts


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
        assert comparison.texts

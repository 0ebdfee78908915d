"""The robot that committed artifacts tell of is the one that they were compiled of, whatever formats they are."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.compare.golden_check import compare
from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.model import Robot
from rosorin_compile.viewer.overlay import moves
from rosorin_compile.viewer.overlay import robot_before as undo_all
from support.moving import random_state
from support.paths import data_text
from support.robots import compiled, compiled_text, copy_of_rosorin, sound

ROBOT = data_text("robots/crane.yaml")
LINE = ROBOT.partition("outputs: ")[2].strip()
OUTPUTS = {
    "all": LINE,
    "urdf": "{urdf: {file: crane.urdf}, static_tf: {file: tf.py}}",
    "six digits": "{urdf: {file: crane.urdf, number_format: six}, mjcf: {file: crane.xml, number_format: six},"
    " static_tf: {file: tf.py}}",
    "mjcf": "{urdf: {file: crane.urdf}, mjcf: {file: crane.xml}, static_tf: {file: tf.py}}",
}


def _old(new: CompileResult, before: CompileResult, only: str = "") -> Robot:
    """Return the robot that the artifacts of another one tell of, all or those of one format."""
    assert new.robot is not None
    committed = {one.file: one.text.encode() for one in before.artifacts if only in ("", one.backend)}
    return undo_all(new.robot, compare(new.robot, new.artifacts, committed).pairs)


def _same_places(one: Robot, other: Robot, within: float) -> None:
    """Hold all frames of two robots against each other, at joint states that are not zero."""
    assert set(one.link) == set(other.link)
    rng = random.Random(3)  # noqa: S311
    for _ in range(20):
        state = random_state(rng, one)
        places = one.poses_in_root(state), other.poses_in_root(state)
        for name, place in places[0].items():
            assert place.xyz == pytest.approx(places[1][name].xyz, abs=within), name
            assert place.angle_to(places[1][name]) < within, name


@pytest.mark.parametrize("outputs", OUTPUTS)
@pytest.mark.parametrize("change", yaml.safe_load(data_text("cases/undo.yaml")), ids=lambda change: change["id"])
def test_what_was_is_found_again(tmp_path: Path, change: dict[str, Any], outputs: str) -> None:
    """What the artifacts of some outputs alone cannot know is not asked."""
    became, was, how = change["new"], change["old"], change["how"]
    assert ROBOT.count(was) == 1
    text = ROBOT.replace(LINE, OUTPUTS[outputs])
    old, _, before = sound(compiled_text(tmp_path, text))
    new, _, after = sound(compiled_text(tmp_path, text.replace(was, became)))
    found = _old(after, before, "mjcf" if outputs == "mjcf" else "")
    _same_places(old, found, 1e-5 if outputs == "six digits" else 1e-9)
    assert moves(found, new).how == how
    assert moves(old, new).how == how
    drawn = {link for link, _ in moves(found, new).shapes}
    assert drawn == {link for link, _ in moves(old, new).shapes}


@pytest.mark.parametrize("outputs", ["all", "urdf", "mjcf"])
def test_links_that_came_and_went(tmp_path: Path, outputs: str) -> None:
    """What is in no artifact is not new; what one knew and knows no more is gone, with what hangs on it."""
    text = ROBOT.replace(LINE, OUTPUTS[outputs])
    without = "".join(line for line in text.splitlines(keepends=True) if "lamp" not in line)
    small, _, fewer = sound(compiled_text(tmp_path, without))
    large, _, more = sound(compiled_text(tmp_path, text))
    assert moves(_old(more, fewer), large).how == {"lamp": "new"}
    gone = moves(_old(fewer, more), small)
    assert gone.how == {"lamp": "removed"}
    _same_places(large, _old(fewer, more), 1e-9)
    assert "lamp_joint" in _old(fewer, more).joint or outputs == "mjcf"  # which has no names of fixed joints
    assert [purpose for link, purpose in gone.shapes if link == "lamp"] == ["visual"]


def test_a_root_above_the_root(tmp_path: Path) -> None:
    """The old root is another one: what both have stays where it is."""
    text = ROBOT
    below = text.replace("links:\n", "links:\n  footprint: {}\n", 1)
    below = below.replace(
        "joints:\n", "joints:\n  foot: {type: fixed, parent: footprint, child: base_link, xyz: [0, 0, 70 mm]}\n", 1
    )
    plain, _, first = sound(compiled_text(tmp_path, text))
    footed, _, second = sound(compiled_text(tmp_path, below))
    added = moves(_old(second, first), footed)
    assert (added.how, added.at.xyz) == ({"footprint": "new"}, (0.0, 0.0, 0.07))
    removed = moves(_old(first, second), plain)
    assert (removed.how, removed.at.xyz) == ({"footprint": "removed"}, (0.0, 0.0, -0.07))
    assert not added.shapes
    assert not removed.shapes


def test_an_artifact_that_was_edited_alone(tmp_path: Path) -> None:
    """What one artifact says otherwise is what was, though the others agree with the description."""
    text = ROBOT
    new, _, made = sound(compiled_text(tmp_path, text))
    committed = {artifact.file: artifact.text.encode() for artifact in made.artifacts}
    assert committed["crane.xml"].count(b"0 0 0.12") == 1
    committed["crane.xml"] = committed["crane.xml"].replace(b"0 0 0.12", b"0 0 0.125")
    old = undo_all(new, compare(new, made.artifacts, committed).pairs)
    assert old.joint_to["laser"].origin.xyz == (0.0, 0.0, 0.125)
    assert moves(old, new).how == {"laser": "moved"}


@pytest.mark.parametrize(
    ("file", "was", "became", "moved"),
    [
        ("lidar_and_imu.yaml", "0.106748", "0.116748", {"laser": "moved"}),
        ("chassis.yaml", "cell: 10 mm", "cell: 11 mm", {"base_footprint": "shaped"}),
    ],
    ids=["lidar", "height map"],
)
def test_the_reference_robot(tmp_path: Path, file: str, was: str, became: str, moved: dict[str, str]) -> None:
    before = compiled(copy_of_rosorin(tmp_path / "old"))
    after = compiled(copy_of_rosorin(tmp_path / "new", {file: (was, became)}))
    old = _old(after, before)
    assert before.robot is not None
    assert after.robot is not None
    _same_places(before.robot, old, 1e-9)
    assert moves(old, after.robot).how == moved
    assert moves(before.robot, after.robot).how == moved

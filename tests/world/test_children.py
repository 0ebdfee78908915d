"""What a child reads in its own way is noted, too: xacro its tables and patterns, MuJoCo the meshes."""

from __future__ import annotations

import errno
import time
from pathlib import Path

import pytest

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.formats.xacro import child
from rosorin_compile.world import noting, own_text
from rosorin_compile_mujoco.mjcf.robot import read_mjcf

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MJCF = """<mujoco>
  <asset><mesh name="m" file="m.obj"/></asset>
  <worldbody><body name="b"><geom type="mesh" mesh="m"/></body></worldbody>
</mujoco>
"""


def test_a_mesh_that_mujoco_reads_is_noted(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "m.obj").write_text(TETRAHEDRON, "utf-8")
    (tmp_path / "m.xml").write_text(MJCF, "utf-8")
    time.sleep(0.02)  # what was written just now may have been written while it was read
    with noting() as notes:
        imported = read_mjcf(tmp_path / "m.xml", ReadOptions())
    assert imported.tree is not None
    assert ("bytes", str(tmp_path / "m.obj")) in notes.answers
    assert not notes.spoiled


def test_a_pattern_of_xacro_notes_the_folders_that_it_looks_into(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    for name in ("a.xacro", "b.txt", ".hidden.xacro"):
        (tmp_path / "parts" / name).write_text("", "utf-8")
    with noting() as notes:
        found = child._matching(f"{tmp_path}/par*/*.xacro")
    assert found == [str(tmp_path / "parts" / "a.xacro")]
    assert {("names", str(tmp_path)), ("names", str(tmp_path / "parts"))} <= notes.answers.keys()


def test_a_table_of_xacro_is_noted_there_or_not(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_bytes(b"x: 1\r\n")
    with noting() as notes:
        opened = child._opened(str(tmp_path / "a.yaml"))
        with pytest.raises(FileNotFoundError):
            child._opened(str(tmp_path / "b.yaml"))
    assert (opened.read(), opened.name) == ("x: 1\n", str(tmp_path / "a.yaml"))
    assert notes.answers["bytes", str(tmp_path / "b.yaml")] == f"! {errno.errorcode[errno.ENOENT]}"


def test_what_a_run_has_written_itself_is_no_note(tmp_path: Path) -> None:
    (tmp_path / "answer").write_text("ä", "utf-8")
    with noting() as notes:
        assert own_text(tmp_path / "answer") == "ä"
        assert own_text(tmp_path / "none") is None
    assert not notes.answers

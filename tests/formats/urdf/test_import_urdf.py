"""Reading URDF: defaults, numbers, encodings, comments, what is kept, and files that are none."""

from __future__ import annotations

from pathlib import Path

from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map


def read(folder: Path, text: str | bytes, name: str = "robot.urdf", lenient: bool = False) -> ImportedRobot:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_robot(path, ReadOptions(lenient=lenient))


def tree_of(folder: Path, text: str | bytes) -> Map:
    imported = read(folder, text)
    assert imported.tree is not None, report(arrange(imported.diagnostics))
    return imported.tree


def told(imported: ImportedRobot) -> list[str]:
    return [f"{d.severity}[{d.rule}]: {d.message}" for d in arrange(imported.diagnostics)]


def test_external_entity_is_not_read(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("secret words", "utf-8")
    text = f'<!DOCTYPE robot [<!ENTITY s SYSTEM "{secret.as_uri()}">]><robot name="r"><link name="&s;"/></robot>'
    (diagnostic,) = read(tmp_path, text).diagnostics
    assert (diagnostic.rule, diagnostic.severity) == ("xml-doctype", ERROR)
    assert "secret words" not in report([diagnostic])


def test_deep_and_wide_files_end(tmp_path):
    assert told(read(tmp_path, "<a>" * 100_000))[0].startswith("error[xml-too-deep]")
    ends = '<parent link="l0"/><child link="l{0}"/>'
    one = f'<link name="l{{0}}"/><joint name="j{{0}}" type="fixed">{ends}</joint>'
    many = "".join(one.format(n) for n in range(1, 400))
    assert len(tree_of(tmp_path, f'<robot name="r"><link name="l0"/>{many}</robot>')["links"]) == 400

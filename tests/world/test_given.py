"""What is read of no file cannot be asked again: a robot on standard input, and texts in the place of files."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile import project
from rosorin_compile.frontend.expand.files import Kept, Reader
from rosorin_compile.frontend.load import load_mapping, unsaved
from rosorin_compile.world import noting

ROBOT = "robot: r\nlinks: {base: {}}\n"


def test_a_robot_on_standard_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(project, "_on_stdin", [ROBOT.encode()])
    with noting() as notes:
        load_mapping(project.ON_STDIN, "-")
    assert notes.spoiled


def test_a_text_in_the_place_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(ROBOT, "utf-8")
    with noting() as notes:
        load_mapping(path, "robot.yaml")
    assert not notes.spoiled
    with noting() as notes, unsaved({path: b"robot: other\n"}):
        assert load_mapping(path, "robot.yaml")["robot"] == "other"
    assert notes.spoiled


def test_a_description_that_is_kept_is_noted_for_each_of_its_robots(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("robot: r\ninclude: [package://arm/arm.yaml]\n", "utf-8")
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "arm.yaml").write_text("links: {base: {}}\n", "utf-8")
    kept = Kept()
    found = []
    for _ in range(2):
        with noting() as notes:
            reader, root = kept.read(Reader(path, None))
        assert root is not None
        assert not reader.diagnostics
        found.append(dict(notes.answers))
    assert ("kind", str(tmp_path / "arm")) in found[0]
    assert found[0].items() <= found[1].items()

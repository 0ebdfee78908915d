"""Quiet runs: errors alone, and how many stand-ins there are; also of a robot that has not changed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.cli import main

ROVER = """
robot: rover
links: {base_link: {}, laser: {}}
joints:
  laser_joint: {type: fixed, parent: base_link, child: laser, axis: [0, 0, 1], xyz: [0.1, 0, 0.2], source: unmeasured}
outputs: {urdf: {file: rover.urdf}}
""".replace("source: unmeasured", "source: {status: stand_in, note: nobody has measured the laser}")
STAND_IN = "1 stand-in: values that are not measured; without -q they are listed\n"


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "rover.yaml").write_text(ROVER)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / ".cache"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_only_stand_ins_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["all", "rover.yaml", "-q"], ["all", "rover.yaml", "-q"], ["check", "rover.yaml", "--quiet"]):
        assert main(words) == 0
        assert capsys.readouterr() == ("", STAND_IN)
    assert main(["all", "rover.yaml"]) == 0
    shown = capsys.readouterr()
    assert "warning[ignored-key]" in shown.err
    assert "note[stand-in]" in shown.err
    assert shown.out.startswith("rover: 1 artifact in ")


def test_errors_are_shown(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "rover.yaml").write_text(ROVER.replace("parent: base_link", "parent: base_lnik"))
    assert main(["all", "rover.yaml", "-q"]) == 1
    assert 'did you mean "base_link"?' in capsys.readouterr().err


def test_a_program_gets_errors_and_stand_ins(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["all", "rover.yaml", "-q", "--format", "json"]) == 0
    assert [entry["rule"] for entry in json.loads(capsys.readouterr().out)] == ["stand-in"]

"""Quiet runs: errors alone, and how many stand-ins there are; also of a robot that has not changed."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli import main, parser
from rosorin_compile.commands.registry import commands
from support.paths import DATA, ROOT

ROVER = """
robot: rover
links: {base_link: {}, laser: {}}
joints:
  laser_joint: {type: fixed, parent: base_link, child: laser, axis: [0, 0, 1], xyz: [0.1, 0, 0.2], source: unmeasured}
outputs: {urdf: {file: rover.urdf}}
""".replace("source: unmeasured", "source: {status: stand_in, note: nobody has measured the laser}")
STAND_IN = "1 stand-in: values that are not measured; {}\n"
OF_ALL, OF_OTHERS = STAND_IN.format("--notes lists them"), STAND_IN.format("without -q they are listed")


@pytest.fixture(autouse=True)
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "rover.yaml").write_text(ROVER)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / ".cache"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_only_stand_ins_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["all", "rover.yaml", "-q"]) == main(["all", "rover.yaml", "-q"]) == 0
    assert capsys.readouterr() == ("", OF_ALL * 2)
    for words in (["check", "rover.yaml", "--quiet"], ["all", "rover.yaml", "-q", "--notes"]):
        assert main(words) == 0
        assert capsys.readouterr() == ("", OF_OTHERS)


def test_all_counts_stand_ins_and_lists_them_with_notes(capsys: pytest.CaptureFixture[str]) -> None:
    for way in ("written: rover.urdf", "unchanged", "unchanged"):  # the last one is remembered
        assert main(["all", "rover.yaml"]) == 0
        shown = capsys.readouterr()
        assert shown.out.endswith(f", {way}\n")
        assert "warning[ignored-key]" in shown.err
        assert "note[stand-in]" not in shown.err
        assert shown.err.endswith(OF_ALL)
    for words in (["all", "--notes"], ["all", "--notes", "-n"], ["check"]):
        assert main([*words, "rover.yaml"]) == 0
        shown = capsys.readouterr()
        assert "note[stand-in]: nobody has measured the laser" in shown.err
        assert "values that are not measured" not in shown.err
    assert main(["all", "rover.yaml", "--format", "json"]) == 0
    assert "stand-in" in [entry["rule"] for entry in json.loads(capsys.readouterr().out)["diagnostics"]]


def test_errors_are_shown(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "rover.yaml").write_text(ROVER.replace("parent: base_link", "parent: base_lnik"))
    assert main(["all", "rover.yaml", "-q"]) == 1
    assert 'did you mean "base_link"?' in capsys.readouterr().err


def test_a_program_gets_errors_and_stand_ins(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["all", "rover.yaml", "-q", "--format", "json"]) == 0
    assert [entry["rule"] for entry in json.loads(capsys.readouterr().out)["diagnostics"]] == ["stand-in"]


# Commands that have nothing to say but their result.
WITHOUT = {"init", "schema", "rule", "cmake-dir", "bazel-dir", "completion"}


@pytest.mark.parametrize("name", [name for name in commands() if name not in WITHOUT])
def test_every_command_that_says_more_than_its_result_can_be_quiet(name: str) -> None:
    command = parser([name]).within[name]
    for one in command.within.values() or [command]:
        quiet = [action for action in one.options if "--quiet" in action.option_strings]
        assert [action.option_strings for action in quiet] == [["-q", "--quiet"]]


ASKED = (
    ["tf", "base_link", "arm", "--joint", "arm_joint=170deg"],
    ["tf", "base_link", "arm", "--joint", "arm_joint=170deg", "--format", "json-list"],
    ["explain", "arm"],
    ["frames", "--ascii"],
    ["args"],
    ["print", "urdf"],
    ["diff", "arm.yaml", "arm.yaml"],
    ["extract", "boxes", "brick.stl"],
)


@pytest.mark.parametrize("words", ASKED, ids=" ".join)
def test_a_result_is_the_same_without_its_messages(
    project: Path, words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    limit = "limit: {lower: 0, upper: 1, effort: 1, velocity: 1}"
    joint = f"arm_joint: {{type: revolute, parent: base_link, child: arm, axis: [0, 0, 1], {limit}}}"
    outputs = "outputs: {urdf: {file: arm.urdf}}"
    (project / "arm.yaml").write_text(
        f"robot: arm\nlinks: {{base_link: {{}}, arm: {{}}}}\njoints:\n  {joint}\n{outputs}\n"
    )
    facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 {0}\nvertex 1 0 {0}\nvertex 0 1 {0}\nendloop\nendfacet\n"
    (project / "brick.stl").write_text(f"solid a\n{facet.format(0)}{facet.format(1)}endsolid a\n")
    command, *rest = words
    words = words if command in ("diff", "extract") else [command, "arm.yaml", *rest]
    code = main(words)
    loud = capsys.readouterr()
    assert code == main([*words, "-q"]) == 0
    assert capsys.readouterr() == (loud.out, "")
    if words[0] in ("tf", "extract"):
        assert loud.err


@pytest.mark.parametrize(
    "words", [["tf", "a", "b"], ["frames"], ["explain", "a"], ["print", "urdf"], ["pulses"]], ids=" ".join
)
def test_errors_stay_where_one_asks(project: Path, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    (project / "rover.yaml").write_text(ROVER.replace("parent: base_link", "parent: base_lnik"))
    command, *rest = words
    assert main([command, "rover.yaml", *rest, "-q"]) == 1
    assert 'did you mean "base_link"?' in capsys.readouterr().err


def test_a_recording_that_is_as_described_is_silent(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("numpy")
    monkeypatch.chdir(ROOT)
    session = str(DATA / "recordings" / "session.txt")
    assert main(["verify", "rosorin", session, "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO((DATA / "recordings" / "session.txt").read_bytes())))
    assert main(["verify", "outputs/rosorin/rosorin.urdf", "-", "-q"]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "error[" in shown.err
    assert "warning[" not in shown.err

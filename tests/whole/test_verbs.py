"""The verbs check, write, explain and schema: the same as the commands, and nothing that is wrong is an exception."""

import json
from pathlib import Path

import pytest

import rosorin_compile
from rosorin_compile.cli.main import main
from rosorin_compile.source.diagnostics import has_errors
from support.paths import ROOT

SMALL = """\
robot: small
args: {length: {type: length, default: 1 m}}
links: {base: {}, tip: {}}
joints: {tip_joint: {type: fixed, parent: base, child: tip, xyz: ["${length}", 0, 0]}}
outputs: {urdf: {file: small.urdf}}
"""


@pytest.fixture
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "descriptions" / "small" / "robot.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(SMALL, "utf-8")
    monkeypatch.chdir(tmp_path)
    return path


@pytest.fixture
def in_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("small")
def test_what_is_written_is_what_the_command_writes(capsys: pytest.CaptureFixture[str]) -> None:
    written = rosorin_compile.write("small", {"length": 0.5}, outputs="mine")
    assert (written.written, written.unchanged, written.kept) == (("small.urdf",), (), ())
    assert main(["all", "small", "-a", "length=0.5", "-o", "theirs/small"]) == 0
    one, other = (Path(folder, "small", "small.urdf").read_bytes() for folder in ("mine", "theirs"))
    assert one == other
    assert rosorin_compile.write("small", {"length": 0.5}, outputs="mine").unchanged == ("small.urdf",)
    assert capsys.readouterr().err == ""


def test_what_is_no_artifact_is_kept_and_pruned(small: Path) -> None:
    folder = rosorin_compile.write(small).folder
    (folder / "notes.txt").write_text("mine", "utf-8")
    written = rosorin_compile.write(small)
    assert written.kept == ("notes.txt",)
    assert [one.rule for one in written.diagnostics][-1:] == ["not-an-artifact"]
    assert rosorin_compile.write(small, prune=True).removed == ("notes.txt",)


def test_check_says_what_the_command_says(small: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rosorin_compile.write(small)
    assert rosorin_compile.check(small).same
    small.write_text(SMALL.replace("1 m", "2 m"), "utf-8")
    checked = rosorin_compile.check("small")
    assert (checked.same, checked.differing) == (False, ("small.urdf",))
    assert main(["check", "small"]) == 1
    assert str(checked) in capsys.readouterr().out
    assert "tip moved" in checked.lines[0]
    assert rosorin_compile.check("small", {"length": "1 m"}).same


def test_a_broken_robot_is_among_the_diagnostics_and_nothing_is_written(small: Path) -> None:
    small.write_text(SMALL.replace("child: tip", "child: tap"), "utf-8")
    results = rosorin_compile.check(small), rosorin_compile.write(small), rosorin_compile.explain(small, ["tip"])
    assert all(has_errors(result.diagnostics) for result in results)
    assert not results[0].same
    assert not Path("outputs").exists()


@pytest.mark.parametrize("name", ["nowhere", 5, b"\0"])
@pytest.mark.usefixtures("small")
def test_a_robot_that_is_not_there_is_among_the_diagnostics(name: object) -> None:
    for verb in (rosorin_compile.check, rosorin_compile.write, lambda name: rosorin_compile.explain(name, ["tip"])):
        assert has_errors(verb(name).diagnostics)  # type: ignore[operator]


def test_a_folder_that_cannot_be_written_is_among_the_diagnostics(small: Path) -> None:
    Path("outputs").write_text("a file", "utf-8")
    written = rosorin_compile.write(small)
    assert has_errors(written.diagnostics)
    assert written.written == ()


@pytest.mark.usefixtures("in_root")
def test_explain_says_what_the_command_says(capsys: pytest.CaptureFixture[str]) -> None:
    explained = rosorin_compile.explain("rosorin", ["laser", "z"])
    assert main(["explain", "rosorin", "laser", "z"]) == 0
    assert capsys.readouterr().out == f"{explained}\n"
    with pytest.raises(KeyError, match='did you mean "laser"'):
        rosorin_compile.explain("rosorin", ["lasr"])


def test_schemas_are_those_of_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "description"]) == 0
    assert json.loads(capsys.readouterr().out) == rosorin_compile.schema("description")
    with pytest.raises(KeyError, match='did you mean "description"'):
        rosorin_compile.schema("descripton")

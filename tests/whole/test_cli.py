"""The command line as a person uses it: exit codes, messages, and nothing lost."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main


@pytest.fixture
def project(rosorin: Path) -> Path:
    """A project with the reference robot, compiled; the current folder."""
    assert main(["all"]) == 0
    return rosorin


def edit(project: Path, file: str, old: str, new: str) -> None:
    path = project / "descriptions" / "rosorin" / file
    text = path.read_text("utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), "utf-8")


def test_all_lists_the_stand_in_and_what_it_wrote(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(project, "arm.yaml", "0.08513]", "0.08613]")
    assert main(["all", "--notes"]) == 0
    shown = capsys.readouterr()
    written = "written: frames.md, robot_model.json, rosorin.urdf, rosorin.xml, rosorin_sim.urdf, scene.xml"
    assert f"10 artifacts in outputs/rosorin, {written}" in shown.out
    assert "note[stand-in]: " in shown.err
    assert "chassis height map" in shown.err


def test_an_edited_artifact_is_found_and_written_again(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    artifact = project / "outputs" / "rosorin" / "rosorin.urdf"
    good = artifact.read_text("utf-8")
    artifact.write_text(good.replace("0.08513", "0.09"), "utf-8")
    assert main(["check"]) == 1
    assert "outputs/rosorin/rosorin.urdf was edited" in capsys.readouterr().out
    assert main(["all"]) == 0
    assert artifact.read_text("utf-8") == good


def test_check_explains_by_meaning_first(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(project, "arm.yaml", "0.08513]", "0.08613]")
    capsys.readouterr()
    assert main(["check"]) == 1
    lines = capsys.readouterr().out.splitlines()
    (meaning,) = [line for line in lines if "link3 moved" in line]
    assert meaning.startswith("link3 moved 1.0 mm in link2: origin z 0.08513 -> 0.08613 m: ")
    for artifact in ("urdf", "mjcf", "robot_model"):
        assert artifact in meaning
    assert lines.index(meaning) < next(i for i, line in enumerate(lines) if line.startswith("@@"))


def test_missing_and_extra_files_are_differences(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outputs = project / "outputs" / "rosorin"
    (outputs / "frames.md").unlink()
    (outputs / "notes.txt").write_text("mine", "utf-8")
    assert main(["check"]) == 1
    shown = capsys.readouterr().out
    assert "frames.md" in shown
    assert "notes.txt" in shown
    assert main(["all"]) == 0
    assert (outputs / "notes.txt").read_text("utf-8") == "mine"
    assert "notes.txt" in capsys.readouterr().err
    assert main(["all", "--prune"]) == 0
    assert not (outputs / "notes.txt").exists()
    assert main(["check"]) == 0


def test_errors_are_reported_together_and_nothing_is_written(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path.name: path.read_bytes() for path in (project / "outputs" / "rosorin").iterdir()}
    edit(project, "arm.yaml", "xyz: [0.04662,", "xzy: [0.04662,")
    edit(project, "camera.yaml", "type: depth_camera", "type: deph_camera")
    assert main(["all"]) == 1
    shown = capsys.readouterr().err
    assert 'descriptions/rosorin/arm.yaml:62:5: error[unknown-key]: joint "joint1" has no key "xzy"' in shown
    assert '    xzy: [0.04662, 7.5437e-05, 0.16044]\n      |     ^^^ did you mean "xyz"?' in shown
    assert 'did you mean "depth_camera"?' in shown
    assert "2 errors, nothing written" in shown
    assert {path.name: path.read_bytes() for path in (project / "outputs" / "rosorin").iterdir()} == before


def test_dry_run_writes_nothing(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edit(project, "arm.yaml", "0.08513]", "0.08613]")
    before = (project / "outputs" / "rosorin" / "rosorin.urdf").read_bytes()
    assert main(["all", "--dry-run"]) == 1
    assert "link3 moved" in capsys.readouterr().out
    assert (project / "outputs" / "rosorin" / "rosorin.urdf").read_bytes() == before


def test_an_artifact_of_ones_own_needs_a_template_and_one_line(project: Path) -> None:
    description = project / "descriptions" / "rosorin"
    (description / "reach.md.jinja").write_text(
        "# Joints of {{ robot.name }}\n{% for joint in robot.joints if joint.moves and joint.limit %}\n"
        "- {{ joint.name }} {{ joint.limit.lower }} to {{ joint.limit.upper }} rad\n{% endfor %}\n",
        "utf-8",
    )
    edit(project, "robot.yaml", "outputs:\n", "outputs:\n  reach: {template: reach.md.jinja, file: docs/reach.md}\n")
    assert main(["all"]) == 0
    made = (project / "outputs" / "rosorin" / "docs" / "reach.md").read_text("utf-8")
    assert "- joint1 -2.09 to 2.09 rad\n" in made
    assert main(["check"]) == 0
    edit(project, "reach.md.jinja", "joint.name", "joint.nam")
    assert main(["all"]) == 1


@pytest.mark.slow
def test_output_goes_to_a_closed_pipe_without_a_traceback(project: Path) -> None:
    edit(project, "arm.yaml", "0.08513]", "0.08613]")
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "rosorin_compile", "check"]
    ran = subprocess.run(command, cwd=project, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert "Traceback" not in ran.stderr


@pytest.mark.parametrize("command", [["all", "--args"], ["check", "deployed"], ["extract", "boxes"]])
def test_a_name_that_no_file_can_have(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command, "n" * 300]) == 2
    assert re.match(
        "rosorin-compile: (no file can have so long a name|there is no file|no description)", capsys.readouterr().err
    )

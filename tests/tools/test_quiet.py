"""Quiet runs: errors alone, and how many stand-ins there are; also of a robot that has not changed."""

import io
import json
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
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
    assert main(["check", "rover.yaml", "--quiet"]) == 0
    assert capsys.readouterr() == ("", OF_ALL)
    for command in ("all", "check"):
        assert main([command, "rover.yaml", "-q", "--notes"]) == 0
        assert capsys.readouterr() == ("", OF_OTHERS)


def test_all_counts_stand_ins_and_lists_them_with_notes(capsys: pytest.CaptureFixture[str]) -> None:
    for way in ("written: rover.urdf", "unchanged", "unchanged"):  # the last one is remembered
        assert main(["all", "rover.yaml"]) == 0
        shown = capsys.readouterr()
        assert shown.out.endswith(f", {way}\n")
        assert "warning[ignored-key]" in shown.err
        assert "note[stand-in]" not in shown.err
        assert shown.err.endswith(OF_ALL)
    for words in (["all", "--notes"], ["all", "--notes", "-n"], ["check", "--notes"]):
        assert main([*words, "rover.yaml"]) == 0
        shown = capsys.readouterr()
        assert "note[stand-in]: nobody has measured the laser" in shown.err
        assert "values that are not measured" not in shown.err
    assert main(["all", "rover.yaml", "--format", "json"]) == 0
    assert "stand-in" in [entry["rule"] for entry in json.loads(capsys.readouterr().out)["diagnostics"]]


HEAVY = """
robot: {0}
links: {{base: {{inertial: {{mass: 1 kg, inertia: {{ixx: 1, iyy: 1, izz: 1}}}}}}, laser: {{}}}}
joints: {{laser_joint: {{type: fixed, parent: base, child: laser{1}}}}}
outputs: {{urdf: {{file: rover.urdf}}}}
"""
SOURCE = ", source: {status: stand_in, note: nobody has measured it}"


def heavy(name: str, stands_in: bool) -> str:
    """Return a robot with a note, as its root has a mass; and with a stand-in."""
    return HEAVY.format(name, SOURCE if stands_in else "")


COUNTED = {
    (False,): "1 note; --notes lists it\n",
    (False, False): "2 notes; --notes lists them\n",
    (True,): "1 stand-in: values that are not measured, and 1 note; --notes lists them\n",
    (True, True, False): "2 stand-ins: values that are not measured, and 3 notes; --notes lists them\n",
}


@pytest.mark.parametrize("stand_ins", COUNTED, ids=str)
def test_notes_are_counted_over_all_robots(
    project: Path, stand_ins: tuple[bool, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    for number, stands_in in enumerate(stand_ins):
        (project / f"r{number}.yaml").write_text(heavy(f"r{number}", stands_in))
    robots = [f"r{number}.yaml" for number in range(len(stand_ins))]
    for command in ("all", "all", "all", "check", "check"):  # also of robots that are known, in a new command line
        assert main([command, *robots]) == 0
        assert capsys.readouterr().err == COUNTED[stand_ins]
        robots.reverse()
    for command in ("all", "check"):
        assert main([command, *robots, "--notes"]) == 0
        told = capsys.readouterr().err
        assert told.count("note[root-inertial]: ") == len(stand_ins)
        assert told.count("note[stand-in]: ") == sum(stand_ins)
        assert "--notes" not in told


def test_a_file_for_which_check_fails_is_listed(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["all", "rover.yaml", "-q"]) == 0
    (project / "outputs" / "rover" / "old").touch()
    capsys.readouterr()
    for words, told in ((["all"], True), (["all", "--notes"], True), (["all", "-q"], False)):
        assert main([*words, "rover.yaml"]) == 0
        assert ("note[not-an-artifact]: outputs/rover/old is no artifact" in capsys.readouterr().err) == told, words
    assert main(["check", "rover.yaml"]) == 1


@pytest.mark.parametrize("form", ["json", "sarif", "github", "markdown"])
def test_a_program_gets_all_notes(project: Path, form: str, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "rover.yaml").write_text(heavy("rover", stands_in=True))
    for command in ("all", "check"):
        assert main([command, "rover.yaml", "--format", form]) == 0
        told = capsys.readouterr()
        assert ("2 notes (1 stand-in" if form == "markdown" else "nobody has measured it") in told.out
        assert "--notes" not in told.err
    assert main(["check", "rover.yaml", "--summary", "summary.md"]) == 0
    assert "2 notes (1 stand-in" in (project / "summary.md").read_text()


ASKED = (
    ["tf", "base_link", "arm", "--joint", "arm_joint=170deg"],
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

"""The forms of diagnostics for people and programs: each says the place, the way out, and how one came there."""

import json
import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import jsonschema
import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.cli.report_formats import FORMATS
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Source, Span
from support.paths import data_text

ROBOT = data_text("robots/report.yaml")
PARTS = """\
parts:
  wheel:
    links: {link: {inertial: {mass: -1, inertia: {ixx: 1, iyy: 1, izz: 1}}}}
    joints:
      joint: {type: fixed, parent: mount, child: link, xyz: [0, 0, "${3*kg}"]}
"""

SARIF = json.loads(data_text("sarif.schema.json"))
PROJECT = {
    "descriptions/my cart#1/robot.yaml": ROBOT,
    "descriptions/my cart#1/parts.yaml": PARTS.replace('"${3*kg}"', "0"),
}


def printed(capsys: pytest.CaptureFixture[str], form: str) -> str:
    capsys.readouterr()
    assert main(["check", "--format", form]) == 1
    return capsys.readouterr().out


@pytest.mark.usefixtures("project")
def test_sarif_has_the_shape_of_the_standard(capsys: pytest.CaptureFixture[str]) -> None:
    log = json.loads(printed(capsys, "sarif"))
    jsonschema.validate(log, SARIF)
    (run,) = log["runs"]
    (result,) = run["results"]
    assert run["tool"]["driver"]["rules"][result["ruleIndex"]]["id"] == result["ruleId"] == "mass-not-positive"
    place = result["locations"][0]["physicalLocation"]
    assert unquote(place["artifactLocation"]["uri"]) == "descriptions/my cart#1/parts.yaml"
    assert place["region"] == {"startLine": 3, "startColumn": 37, "endColumn": 39}
    stack = [location["message"]["text"] for location in result["relatedLocations"]]
    assert stack == ['part "wheel" used here as "wheel_1"', "i = 1", 'part "wheel" used here as "wheel_2"']


def test_sarif_of_every_kind_of_diagnostic() -> None:
    source = Source("/abs olute/größe%.yaml", "robot: a\n")
    span = Span(source, 1, 8, 1)
    made = [
        Diagnostic(
            "a", ERROR, "b", span, (Related("twice", span), Related("twice", span), Related("no place", None)), "c"
        ),
        Diagnostic("a", WARNING, "b"),
        Diagnostic("b-c", NOTE, "line\nline", span),
    ]
    log = json.loads(FORMATS["sarif"](made))
    jsonschema.validate(log, SARIF)
    levels = [result["level"] for result in log["runs"][0]["results"]]
    assert levels == ["error", "warning", "note"]
    uri = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == "file:///abs%20olute/gr%C3%B6%C3%9Fe%25.yaml"


def test_sarif_without_problems_is_a_run_without_results() -> None:
    log = json.loads(FORMATS["sarif"]([]))
    jsonschema.validate(log, SARIF)
    assert log["runs"][0]["results"] == []


@pytest.mark.usefixtures("project")
def test_a_github_annotation_carries_the_stack(capsys: pytest.CaptureFixture[str]) -> None:
    (line,) = printed(capsys, "github").splitlines()
    found = re.fullmatch(r"::error file=(.+?),line=(\d+),col=(\d+),title=(.+?)::(.*)", line)
    assert found is not None
    assert found.groups()[:4] == ("descriptions/my cart#1/parts.yaml", "3", "37", "mass-not-positive")
    message = found[5].replace("%0A", "\n").replace("%25", "%").splitlines()
    assert message[0].startswith('the mass of link "wheel_1_link" is -1 kg')
    assert message[1:] == [
        'descriptions/my cart#1/robot.yaml:5:3: part "wheel" used here as "wheel_1"',
        "descriptions/my cart#1/robot.yaml:6:15: i = 1",
        'descriptions/my cart#1/robot.yaml:5:3: part "wheel" used here as "wheel_2"',
    ]


def test_github_escapes_what_would_end_the_annotation() -> None:
    source = Source("a,b:c%.yaml", "x\n")
    (line,) = FORMATS["github"]([Diagnostic("r", ERROR, "50%\nnext", Span(source, 1, 1))]).splitlines()
    assert line == "::error file=a%2Cb%3Ac%25.yaml,line=1,col=1,title=r::50%25%0Anext"


@pytest.mark.usefixtures("project")
def test_json_carries_the_stack(capsys: pytest.CaptureFixture[str]) -> None:
    (found,) = json.loads(printed(capsys, "json"))["diagnostics"]
    assert (found["file"], found["line"], found["column"]) == ("descriptions/my cart#1/parts.yaml", 3, 37)
    stack = ['part "wheel" used here as "wheel_1"', "i = 1", 'part "wheel" used here as "wheel_2"']
    assert [note["message"] for note in found["related"]] == stack


def test_text_shows_the_stack_of_an_expression_in_a_part(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "descriptions" / "my cart#1" / "parts.yaml").write_text(PARTS.replace("mass: -1", "mass: 1"), "utf-8")
    capsys.readouterr()
    assert main(["check"]) == 1
    told = capsys.readouterr().err
    assert re.search(
        r"parts\.yaml:5:68: error\[wrong-unit\]: .*\n"
        r"    5 \| .*\n"
        r"      \| .*\n"
        r"(      and 1 more .*\n)?"
        r'      descriptions/my cart#1/robot\.yaml:5:3: part "wheel" used here as "wheel_1"\n'
        r"      descriptions/my cart#1/robot\.yaml:6:15: i = 1\n",
        told,
    ), told


@pytest.mark.slow
def test_no_letter_of_a_name_stops_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "descriptions" / "größe"
    folder.mkdir(parents=True)
    (folder / "robot.yaml").write_text("robot: größe\nlinks: {größe: {}}\noutputs: {urdf: {file: a.urdf}}\n", "utf-8")
    monkeypatch.setenv("PYTHONIOENCODING", "ascii")
    for words in (
        ["all"],
        ["args"],
        ["explain", "größe"],
        ["check", "--format", "json"],
        ["explain", "größe", "--format", "json"],
    ):
        command = [sys.executable, "-X", "utf8", "-m", "rosorin_compile", *words]
        ran = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
        assert b"Traceback" not in ran.stderr, ran.stderr
        assert ran.returncode == 0
        if words[-1] == "json":
            json.loads(ran.stdout)

"""The forms of diagnostics for people and programs: each says the place, the way out, and how one came there."""

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from rosorin_compile.cli.report_formats import FORMATS
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Source, Span
from support.paths import data_text

SARIF = json.loads(data_text("sarif.schema.json"))


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


def test_github_escapes_what_would_end_the_annotation() -> None:
    source = Source("a,b:c%.yaml", "x\n")
    (line,) = FORMATS["github"]([Diagnostic("r", ERROR, "50%\nnext", Span(source, 1, 1))]).splitlines()
    assert line == "::error file=a%2Cb%3Ac%25.yaml,line=1,col=1,title=r::50%25%0Anext"


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

"""check parameters: the comment of each file of tests/data/parameters lists the diagnostics that it gets.

A folder is one robot, with files after the real defaults of its nodes: ``sound.yaml``, which gets none, and
others with a conflict. The comments (see support/cases.py) follow ``# options:`` of the command line; with
``--controllers`` as the first of them the file has to have controllers.
"""

from pathlib import Path

import pytest

from rosorin_compile import check_parameters
from rosorin_compile.cli.main import main
from rosorin_compile.cli.run import Run
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from rosorin_compile.source.project import Description
from support.cases import as_comment, check
from support.commands import parse
from support.paths import DATA

FOLDER = DATA / "parameters"
STOCK = sorted(one for one in (DATA / "stock").glob("*/*.yaml") if one.name != "robot.yaml")
CASES = sorted(one for one in FOLDER.glob("*/*.yaml") if one.name != "robot.yaml" and ".launch" not in one.name)


def options(case: Path) -> Run:
    lines = case.read_text("utf-8").splitlines()
    words = next((line.split()[2:] for line in lines if line.startswith("# options: ")), [])
    if words[:1] == ["--controllers"]:
        made = parse(["check", "parameters", "robot.yaml", "--controllers", case.name, *words[1:]])
        made.parameters = []
        return made
    made = parse(["check", "parameters", "robot.yaml", *words])
    made.parameters = [case.name]
    return made


def looked_at(case: Path) -> list[Diagnostic]:
    request = Request(Description("robot", Path("robot.yaml"), Path("outputs")))
    given = options(case)
    result = check_parameters(
        request,
        given.parameters,
        controllers=given.controllers,
        launch=given.launch,
        remaps=given.remap,
        namespace=given.namespace,
        distribution=given.distribution,
    )
    assert result.robot
    return list(result.diagnostics)


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case.parent.name}-{case.stem}")
def test_message(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(case.parent)
    found = as_comment(looked_at(case), case.name)
    check(case, found)
    assert (case.stem == "sound") == (not found)


@pytest.mark.parametrize("case", STOCK, ids=lambda case: f"{case.parent.name}-{case.stem}")
def test_files_of_public_robots_have_no_error(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folders are robots with the names of the files: what is left are remarks on keys that nothing reads."""
    monkeypatch.chdir(case.parent)
    wrong = [one for one in looked_at(case) if one.severity == ERROR]
    assert not wrong


@pytest.mark.parametrize(
    ("words", "code", "shown"),
    [
        (["sound.yaml"], 0, "controllers: 1 edge of nodes compared with the files: as described\n"),
        (["--controllers", "sound.yaml", "--distribution", "rolling"], 0, "as described"),
        (["--controllers", "sound.yaml", "frames.yaml"], 1, "parameters-other-edge"),
        (["nothing.yaml"], 2, 'there is no file "nothing.yaml"'),
        (["sound.yaml", "--remap", "a"], 2, '"a" is not a remap: write NODE:FROM:=TO'),
        (["--launch", "a.launch.py"], 2, "there is no parameter file to check: rosorin-compile check "),
        (["--controllers", "sound.yaml", "--physics"], 2, "check parameters has no option"),
    ],
)
def test_the_command_line(
    words: list[str], code: int, shown: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(FOLDER / "controllers")
    assert main(["check", "parameters", "robot.yaml", *words]) == code
    captured = capsys.readouterr()
    assert shown in captured.out + captured.err

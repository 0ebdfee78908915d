"""action.yml: its steps are run as the shell lines they are, in a repository whose project is in a folder of it."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import uuid
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

from rosorin_compile.viewer.page import data_of
from support.commands import edit, write_files
from support.paths import ROOT
from support.snapshot import network, snapshot

ACTION: dict[str, Any] = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
STEPS: list[dict[str, Any]] = ACTION["runs"]["steps"]
EXPRESSION = re.compile(r"\$\{\{ *([a-z.\-_]+) *\}\}")
ROBOT = """\
robot: {0}
links: {{base_link: {{}}, mast: {{}}}}
joints: {{mast_joint: {{type: fixed, parent: base_link, child: mast, xyz: [0, 0, 100 mm]}}}}
outputs: {{urdf: {{file: {0}.urdf}}}}
"""


class Job(NamedTuple):
    """What became of a run of the action: exit code, what was printed, outputs, and the summary of the job."""

    code: int
    printed: str
    outputs: dict[str, str]
    summary: str


def filled(text: str, known: dict[str, str]) -> str:
    return EXPRESSION.sub(lambda found: known[found[1]], text)


def act(repository: Path, steps: list[dict[str, Any]], **inputs: str) -> Job:
    temporary = repository.parent / "temporary"
    temporary.mkdir(exist_ok=True)
    known = {f"inputs.{name}": str(one["default"]) for name, one in ACTION["inputs"].items()}
    known |= {f"inputs.{name.replace('_', '-')}": value for name, value in inputs.items()}
    known |= {"github.action_path": str(repository.parent / "action")}
    code, printed, told = 0, "", {}
    job = repository.parent / "summary.md"
    job.write_text("of another step\n")
    for step in steps:
        files = {name: temporary / uuid.uuid4().hex for name in ("GITHUB_OUTPUT", "script")}
        files["GITHUB_OUTPUT"].touch()
        files["script"].write_text(step["run"])
        environment = {**os.environ, **{name: filled(value, known) for name, value in step["env"].items()}}
        environment |= {"GITHUB_WORKSPACE": str(repository), "RUNNER_TEMP": str(temporary), "CI": "true"}
        environment |= {"GITHUB_OUTPUT": str(files["GITHUB_OUTPUT"]), "GITHUB_STEP_SUMMARY": str(job)}
        environment |= {"ROSORIN_COMPILE_CACHE": str(temporary / "cache")}
        assert step["shell"] == "bash"
        ran = subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", str(files["script"])],
            cwd=repository / filled(step.get("working-directory", "."), known),
            env=environment,
            check=False,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        printed += ran.stdout
        pairs = (line.partition("=") for line in files["GITHUB_OUTPUT"].read_text().splitlines())
        told |= {f"steps.{step.get('id')}.outputs.{name}": value for name, _, value in pairs}
        code = ran.returncode
        if code:
            break
    outputs = {name: filled(one["value"], told) for name, one in ACTION["outputs"].items()} if told else {}
    return Job(code, printed, outputs, job.read_text("utf-8").removeprefix("of another step\n"))


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A checkout with two robots in a folder, and in the place of the environment that is installed, this one."""
    folder = tmp_path / "repo sitory"
    write_files(folder, {f"robots/descriptions/{name}/robot.yaml": ROBOT.format(name) for name in ("arm", "dog")})
    program = tmp_path / "temporary/rosorin-compile/bin/rosorin-compile"
    program.parent.mkdir(parents=True)
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m rosorin_compile "$@"\n')
    program.chmod(0o755)
    ran = subprocess.run([program, "all"], cwd=folder / "robots", check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return folder


def test_nothing_from_outside_is_written_into_a_script() -> None:
    used = set()
    for step in STEPS:
        assert "${{" not in step["run"]
        for value in [*step["env"].values(), step.get("working-directory", "")]:
            assert value.count("${{") == len(EXPRESSION.findall(value))
            used |= set(EXPRESSION.findall(value))
    assert used == {*(f"inputs.{name}" for name in ACTION["inputs"]), "github.action_path"}
    variables = {name for step in STEPS for name in step["env"]}
    assert all(re.search(rf"\${{?{name}\b", "".join(step["run"] for step in STEPS)) for name in variables)


@pytest.mark.parametrize("step", STEPS, ids=lambda step: step["name"])
def test_shellcheck_has_nothing_to_say(step: dict[str, Any]) -> None:
    program = shutil.which("shellcheck", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if program is None:
        pytest.skip("shellcheck is not installed")
    words = [program, "--shell=bash", "--enable=check-unassigned-uppercase", "--exclude=SC2154", "-"]
    ran = subprocess.run(words, input=step["run"], check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout


def test_right_robots(repository: Path) -> None:
    job = act(repository, STEPS[1:], working_directory="robots")
    assert job.code == 0, job.printed
    assert "::error" not in job.printed
    assert job.summary.startswith("## Robots: no problems\n\n- `arm`: `1 artifact up to date")
    assert {name: job.outputs[name] for name in ("passed", "code")} == {"passed": "true", "code": "0"}
    assert Path(job.outputs["summary"]).read_text("utf-8") == job.summary


def test_a_robot_that_moved_and_one_with_a_mistake(repository: Path) -> None:
    edit(repository / "robots/descriptions/dog/robot.yaml", "100 mm", "120 mm")
    edit(repository / "robots/descriptions/arm/robot.yaml", "child: mast", "chidl: mast")
    job = act(repository, STEPS[1:], working_directory="robots")
    assert job.code == 1
    assert "::error file=robots/descriptions/arm/robot.yaml,line=3,col=" in job.printed
    assert "::error title=outputs-differ::mast moved 20.0 mm in base_link" in job.printed
    assert "mast moved 20.0 mm in base_link: origin z 0.1 -> 0.12 m" in job.summary
    assert "\nrobots/descriptions/arm/robot.yaml:3:" in job.summary
    assert {name: job.outputs[name] for name in ("passed", "code")} == {"passed": "false", "code": "1"}
    lenient = act(repository, STEPS[1:], working_directory="robots", fail_on="nothing")
    assert lenient.code == 0
    assert lenient.summary == job.summary
    assert lenient.outputs["passed"] == "false"


def test_the_page(repository: Path) -> None:
    """The same run writes the page, and says where it is; where nothing compiles there is none."""
    edit(repository / "robots/descriptions/dog/robot.yaml", "100 mm", "120 mm")
    job = act(repository, STEPS[1:], working_directory="robots", page="true")
    assert job.code == 1
    page = data_of(Path(job.outputs["page"]).read_text("utf-8"))
    assert [page["robot"]["name"], *(one["robot"]["name"] for one in page["others"])] == ["dog", "arm"]
    assert page["moved"] == {"mast": "moved"}
    assert "The page robots.html shows the robots, and what moved." in job.summary
    plain = act(repository, STEPS[1:], working_directory="robots")
    assert plain.outputs["page"] == ""
    assert "robots.html" not in plain.summary
    edit(repository / "robots/descriptions/dog/robot.yaml", "child: mast", "chidl: mast")
    broken = act(repository, STEPS[1:], working_directory="robots", robots="dog", page="true")
    assert (broken.code, broken.outputs["page"]) == (1, "")
    assert act(repository, STEPS[1:], working_directory="robots", page="yes").code == 2


def test_one_robot_with_an_argument_and_an_option(repository: Path) -> None:
    edit(repository / "robots/descriptions/dog/robot.yaml", "100 mm", '"${mast}"')
    with (repository / "robots/descriptions/dog/robot.yaml").open("a") as file:
        file.write("args: {mast: {type: length, default: 1 m}}\n")
    job = act(repository, STEPS[1:], robots="robots/descriptions/dog\n", args="mast=100 mm\n", options="--full\n\n-q\n")
    assert job.code == 0, job.printed
    assert job.outputs["passed"] == "true"
    assert "`arm`" not in job.summary


@pytest.mark.parametrize("name", ["robots", "args", "options", "fail-on"])
def test_wrong_usage_fails_always(repository: Path, name: str) -> None:
    evil = '"; touch owned; $(touch owned) `touch owned`'
    inputs = {"working-directory": "robots", "fail-on": "nothing", name: evil}
    job = act(repository, STEPS[1:], **inputs)
    assert job.code == 2, job.printed
    assert not list(repository.parent.rglob("owned"))


def test_no_project(repository: Path) -> None:
    job = act(repository, STEPS[1:])
    assert job.code == 2
    assert "there is no descriptions/*/robot.yaml here or above" in job.printed
    assert job.outputs["code"] == "2"


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_the_whole_action(repository: Path) -> None:
    """The environment is made, and the sources of the action are installed."""
    network()
    shutil.rmtree(repository.parent / "temporary")
    snapshot(repository.parent / "action")
    job = act(repository, STEPS, working_directory="robots", python=sys.executable)
    assert job.code == 0, job.printed
    assert "`dog`: `1 artifact up to date" in job.summary

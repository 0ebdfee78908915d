"""Folders of ``descriptions`` that are not compiled: nobody may read them, or they have no robot.yaml."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown, ask, write_files

ROBOT = "robot: {0}\nlinks: {{base_link: {{}}}}\noutputs: {{urdf: {{file: r.urdf}}}}\n"
PROJECT = {f"descriptions/{name}/robot.yaml": ROBOT.format(name) for name in "pq"}


def unprivileged(*words: str) -> subprocess.CompletedProcess[str]:
    before: list[str] = []
    if not os.geteuid():
        if shutil.which("setpriv") is None:
            pytest.skip("permissions do not hold root back, and there is no setpriv")
        before = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
    command = [*before, sys.executable, "-m", "rosorin_compile", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("closed", ["descriptions/q", "descriptions/q/robot.yaml"])
def test_one_of_two_robots_that_cannot_be_read_is_an_error(project: Path, closed: str) -> None:
    mode = (project / closed).stat().st_mode
    (project / closed).chmod(0)
    try:
        done = unprivileged("all")
        alone = unprivileged("all", "q")
        where = unprivileged("all", "descriptions/q/robot.yaml")
    finally:
        (project / closed).chmod(mode)
    said = "error[file-unreadable]: cannot read descriptions/q/robot.yaml: Permission denied\n"
    assert (done.returncode, "p: 1 artifact in outputs/p" in done.stdout) == (1, True)
    for one in (done, alone, where):
        assert one.returncode == 1
        assert said in one.stderr
        assert "Traceback" not in one.stderr


def test_a_folder_of_descriptions_that_cannot_be_read(project: Path) -> None:
    (project / "descriptions").chmod(0)
    try:
        done = unprivileged("all")
    finally:
        (project / "descriptions").chmod(0o755)
    assert done.returncode == 1
    assert "descriptions: Permission denied\n" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("files", "message", "help"),
    [
        (["robot.yml"], "descriptions/q/robot.yml is not compiled: it has to be called robot.yaml", "rename it"),
        (["Robot.yaml"], "descriptions/q/Robot.yaml is not compiled: it has to be called robot.yaml", "rename it"),
        (["q.yaml"], "descriptions/q/q.yaml is not compiled: it has to be called robot.yaml", "rename it"),
        ([], "descriptions/q has no robot.yaml", "add robot.yaml, or move the folder out of descriptions"),
    ],
)
def test_a_folder_without_robot_yaml_is_named(
    project: Path, capsys: Shown, files: list[str], message: str, help: str
) -> None:
    (project / "descriptions/q/robot.yaml").unlink()
    for name in files:
        (project / "descriptions/q" / name).write_text(ROBOT.format("q"))
    for command in ("all", "check", "args"):
        assert main([command]) == 0
        said = capsys.readouterr().err
        assert f"warning[no-robot-file]: {message}\n" in said
        assert help in said
    assert main(["all", "p"]) == 0
    assert "no-robot-file" not in capsys.readouterr().err
    assert message in ask(capsys, "all", "q", code=2)
    shutil.rmtree(project / "descriptions/p")
    assert message in ask(capsys, "all", code=2)


def test_files_that_descriptions_share_need_no_robot(project: Path, capsys: Shown) -> None:
    write_files(project, {"descriptions/common/arm.yaml": "links: {arm: {}}\n", "descriptions/.schema/x.json": ""})
    (project / "descriptions/q/robot.yaml").write_text(f"include: [../common/arm.yaml]\n{ROBOT.format('q')}")
    main(["all"])
    assert "no-robot-file" not in capsys.readouterr().err

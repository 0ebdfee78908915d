"""Folders of ``descriptions`` that are not compiled: nobody may read them, or they have no robot.yaml."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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

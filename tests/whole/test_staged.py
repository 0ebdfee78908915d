"""check --staged: what Git has staged for the next commit is checked, not the files on disk."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown, edit, write_files
from support.snapshot import commit, git

ROBOT = """\
robot: mast
include: [links.yaml]
joints: {mast_joint: {type: fixed, parent: base_link, child: mast, xyz: [0, 0, 100 mm]}}
outputs: {urdf: {file: mast.urdf}}
"""
FILES = {"descriptions/mast/robot.yaml": ROBOT, "descriptions/mast/links.yaml": "links: {base_link: {}, mast: {}}\n"}
DESCRIPTION = Path("descriptions/mast/robot.yaml")


@pytest.fixture
def repository(home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    write_files(home, FILES)
    assert main(["all"]) == 0
    commit(home)
    capsys.readouterr()
    return home


def test_new_artifacts_have_to_be_staged_too(repository: Path, capsys: Shown) -> None:
    edit(DESCRIPTION, "100 mm", "120 mm")
    assert main(["check", "--staged"]) == 0  # nothing is staged
    git(repository, "add", "descriptions")
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    capsys.readouterr()
    assert main(["check", "--staged"]) == 1
    assert "mast moved 20.0 mm in base_link" in capsys.readouterr().out
    git(repository, "add", "outputs")
    assert main(["check", "--staged"]) == 0
    assert capsys.readouterr().out == "mast: 1 artifact up to date in outputs/mast\n"


@pytest.mark.usefixtures("repository")
def test_inputs_have_to_be_staged(capsys: Shown) -> None:
    write_files(Path(), {"descriptions/mast/more.yaml": "links: {lamp: {}}\n"})
    edit(DESCRIPTION, "include: [links.yaml]", "include: [links.yaml, more.yaml]")
    git(Path(), "add", str(DESCRIPTION))
    assert main(["check", "--staged"]) == 1
    shown = capsys.readouterr()
    assert "descriptions/mast/robot.yaml:2:23: error[file-unreadable]" in shown.err
    assert str(Path.cwd()) not in shown.err


def test_without_a_repository(home: Path, capsys: Shown, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(home.parent))
    write_files(home, FILES)
    assert main(["check", "--staged"]) == 2
    assert "--staged: fatal: not a git repository" in capsys.readouterr().err
    monkeypatch.setenv("PATH", "")
    assert main(["check", "--staged"]) == 2
    assert "--staged: Git is not installed" in capsys.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="a hook that is a shell script")
def test_the_documented_hook_rejects_a_stale_commit(repository: Path) -> None:
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    hook = Path(".git/hooks/pre-commit")
    hook.parent.mkdir(exist_ok=True)
    hook.write_text(f"#!/bin/sh\nexec {sys.executable} -m rosorin_compile check --staged\n")
    hook.chmod(0o755)

    def committed(*words: str) -> bool:
        who = ("-c", "user.name=a", "-c", "user.email=a@example.invalid", "-c", "commit.gpgsign=false")
        command = ["git", *who, "commit", "--quiet", "--message", "b", *words]
        return subprocess.run(command, cwd=repository, check=False, capture_output=True).returncode == 0

    edit(DESCRIPTION, "100 mm", "120 mm")
    git(repository, "add", "--all")
    assert not committed()
    assert main(["all"]) == 0
    assert not committed()  # written, not added
    assert not committed("descriptions")  # with an index of its own
    assert committed("--all")
    edit(Path("outputs/mast/mast.urdf"), "0.12", "0.13")
    assert not committed("--all")

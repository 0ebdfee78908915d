""".pre-commit-hooks.yaml: pre-commit itself runs the hooks in a repository of a user; and --hook without it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from rosorin_compile.cli.main import main
from support.commands import Shown, edit, write_files
from support.paths import ROOT
from support.snapshot import commit, git, network, snapshot

ROBOT = """\
robot: {0}
links: {{base_link: {{}}, mast: {{}}}}
joints: {{mast_joint: {{type: fixed, parent: base_link, child: mast, xyz: [0, 0, 100 mm]}}}}
outputs: {{urdf: {{file: {0}.urdf}}}}
"""
FILES = {
    "ws/src/arm/descriptions/arm/robot.yaml": ROBOT.format("arm"),
    "ws/src/arm/descriptions/cell/robot.yaml": ROBOT.format("cell"),
    "dog/descriptions/dog/robot.yaml": ROBOT.format("dog"),
    "docs/descriptions/of/words.md": "words\n",
    "ml/outputs/weights.txt": "1\n",
    "README.md": "robots\n",
}
ARM, CELL, DOG = (name for name in FILES if name.endswith("robot.yaml"))
HOOKS = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))


@pytest.fixture
def user(home: Path, capsys: Shown) -> Path:
    write_files(home, FILES)
    assert main(["all", "ws/src/arm/descriptions/arm", "ws/src/arm/descriptions/cell", "dog/descriptions/dog"]) == 0
    capsys.readouterr()
    return home


def test_hooks_say_what_pre_commit_knows() -> None:
    clientlib = pytest.importorskip("pre_commit.clientlib")
    assert clientlib.load_manifest(ROOT / ".pre-commit-hooks.yaml")
    for hook in HOOKS:
        wanted = [name for name in FILES if re.search(hook["files"], name)]
        assert wanted == [name for name in FILES if name != "README.md"]
        assert hook["require_serial"]
        assert "pass_filenames" not in hook


class Ran(NamedTuple):
    code: int
    printed: str


def pre_commit(*words: str | Path) -> Ran:
    ran = subprocess.run(
        [sys.executable, "-m", "pre_commit", *words],
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    return Ran(ran.returncode, ran.stdout)


@pytest.fixture
def ours(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    pytest.importorskip("pre_commit")
    network()
    folder = tmp_path_factory.mktemp("project")
    monkeypatch.setenv("PRE_COMMIT_HOME", str(folder / "store"))
    for name in [name for name in os.environ if name.startswith("GIT_")]:
        monkeypatch.delenv(name)
    return snapshot(folder / "ours")


@pytest.fixture
def run(user: Path, ours: Path) -> Callable[..., Ran]:
    config = {
        "repo": str(ours),
        "rev": git(ours, "rev-parse", "HEAD").strip(),
        "hooks": [{"id": h["id"]} for h in HOOKS],
    }
    Path(".pre-commit-config.yaml").write_text(yaml.safe_dump({"repos": [config]}))
    Path(".gitignore").write_text("cache/\n")
    commit(user)
    return lambda name, *more: pre_commit("run", name, *more)


CHECK, ALL = (hook["id"] for hook in HOOKS)


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_pre_commit_runs_them(run: Callable[..., Ran], user: Path) -> None:
    right = run(CHECK, "--all-files")
    assert right.code == 0, right.printed
    assert "Passed" in right.printed

    Path("README.md").write_text("other words\n")
    git(user, "add", "--all")
    assert "Skipped" in run(CHECK).printed
    commit(user)

    edit(Path(CELL), "100 mm", "120 mm")
    git(user, "add", "--all")
    moved = run(CHECK)
    assert moved.code == 1
    assert "mast moved 20.0 mm in base_link: origin z 0.1 -> 0.12 m: urdf" in moved.printed
    assert "dog" not in moved.printed

    wrote = run(ALL)
    assert wrote.code == 1
    assert "files were modified by this hook" in wrote.printed
    assert "cell: 1 artifact in ws/src/arm/outputs/cell, written: cell.urdf" in wrote.printed
    git(user, "add", "--all")
    assert run(ALL).code == 0
    assert run(CHECK).code == 0
    commit(user)

    # A new robot: what is written is not in git yet, and pre-commit alone would not notice.
    write_files(user, {"dog/descriptions/puppy/robot.yaml": ROBOT.format("puppy")})
    git(user, "add", "--all")
    assert run(ALL).code == 1
    assert Path("dog/outputs/puppy/puppy.urdf").is_file()

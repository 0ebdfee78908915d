"""A copy of this project as a repository of its own, and whether a package index answers."""

import os
import shutil
import subprocess
import sys
import tempfile
import venv
from functools import lru_cache
from pathlib import Path

import pytest

from support.paths import ROOT


def snapshot(folder: Path) -> Path:
    """Copy what git knows or would add here, as it is now, and commit it; return the folder."""
    listed = of_clone("ls-files", "-z", "--cached", "--others", "--exclude-standard")
    for name in filter(None, listed.split("\0")):
        if not name.startswith("tests/") and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    commit(folder)
    return folder


def of_clone(*words: str) -> str:
    """Return what git prints of this clone; where this is none, such as an unpacked sdist, the test is skipped."""
    if not (ROOT / ".git").exists():
        pytest.skip("this is no clone")
    return git(ROOT, *words)


def commit(folder: Path) -> None:
    """Make a folder a repository, if it is none, and commit all that is in it."""
    git(folder, "init", "--quiet")
    git(folder, "add", "--all")
    who = ("-c", "user.name=a", "-c", "user.email=a@example.invalid", "-c", "commit.gpgsign=false")
    git(folder, *who, "commit", "--quiet", "--no-verify", "--message", "a")


def git(folder: Path, *words: str) -> str:
    """Return what git prints."""
    if shutil.which("git") is None:
        pytest.skip("git is not installed")
    ran = subprocess.run(["git", *words], cwd=folder, check=False, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


@lru_cache(maxsize=1)
def _index_answers() -> bool:
    with tempfile.TemporaryDirectory() as folder:
        venv.create(Path(folder, "env"), with_pip=True)
        words = [Path(folder, "env/bin/python"), "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder]
        ran = subprocess.run([*words, "setuptools>=77"], check=False, capture_output=True)
    return ran.returncode == 0


def network() -> None:
    """Skip a test that installs packages where no index answers; in CI one does."""
    if not os.environ.get("CI") and sys.platform != "win32" and not _index_answers():
        pytest.skip("no package index answers")

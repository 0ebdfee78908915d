"""A script that uses the public names is sound for mypy in its strict mode and for pyright; a fault is found."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import PACKAGE, TESTS

SCRIPT = TESTS / "data" / "typed" / "service.py"
# A use that is wrong, and a word of what is said of it.
FAULT = ('return Answer(texts["robot.urdf"]', 'return Answer(texts["robot.urdf"].files', "files")


def scripts(folder: Path) -> tuple[Path, Path]:
    """Return a script that is right, and one that is wrong."""
    right, wrong = folder / "right.py", folder / "wrong.py"
    text = SCRIPT.read_text("utf-8")
    assert FAULT[0] in text
    right.write_text(text, "utf-8")
    wrong.write_text(text.replace(*FAULT[:2]), "utf-8")
    return right, wrong


@pytest.mark.slow
def test_mypy_in_its_strict_mode_has_nothing_to_say(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    right, wrong = scripts(tmp_path)
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", tmp_path / "cache"]
    ran = [
        subprocess.run(
            [*map(str, command), str(script)],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "MYPYPATH": str(PACKAGE.parent)},
        )
        for script in (right, wrong)
    ]
    assert ran[0].returncode == 0, ran[0].stdout + ran[0].stderr
    assert (ran[1].returncode, ran[1].stdout.count("error:")) == (1, 1)
    assert FAULT[2] in ran[1].stdout


@pytest.mark.slow
def test_pyright_has_nothing_to_say(tmp_path: Path) -> None:
    npm = shutil.which("npm")
    if npm is None:
        pytest.skip("there is no npm, which installs pyright")
    right, wrong = scripts(tmp_path)
    subprocess.run(
        [npm, "install", "--no-audit", "--no-fund", "pyright"], cwd=tmp_path, check=True, capture_output=True
    )
    settings = {
        "extraPaths": [str(PACKAGE.parent)],
        "typeCheckingMode": "strict",
        "reportPrivateUsage": True,
        "reportUnusedFunction": False,
    }
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings), "utf-8")
    said = []
    for script in (right, wrong):
        pyright = tmp_path / "node_modules" / ".bin" / "pyright"
        ran = subprocess.run(
            [pyright, "--pythonpath", sys.executable, "--outputjson", script],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        said.append([one["message"] for one in json.loads(ran.stdout)["generalDiagnostics"]])
    assert said[0] == []
    assert FAULT[2] in " ".join(said[1])

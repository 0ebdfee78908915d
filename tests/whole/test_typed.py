"""A script that uses the public names is sound for mypy in its strict mode and for pyright; a fault is found."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import PACKAGE, TESTS

SCRIPTS = TESTS / "data" / "typed"
# Of each script a use that is wrong, and a word of what is said of it.
FAULTS = {
    "service": ('return Answer(texts["robot.urdf"]', 'return Answer(texts["robot.urdf"].files', "files"),
    "battery": ("one.mass for one in robot.sections[LIST]", "one.weight for one in robot.sections[LIST]", "weight"),
}


def scripts(folder: Path) -> tuple[list[str], list[str]]:
    made: tuple[list[str], list[str]] = [], []
    for name, (right, wrong, _) in FAULTS.items():
        text = (SCRIPTS / f"{name}.py").read_text("utf-8")
        assert right in text
        for many, kind, changed in zip(made, ("right", "wrong"), (text, text.replace(right, wrong)), strict=True):
            path = folder / f"{kind}_{name}.py"
            path.write_text(changed, "utf-8")
            many.append(str(path))
    return made


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_mypy_in_its_strict_mode_has_nothing_to_say(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    right, wrong = scripts(tmp_path)
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", tmp_path / "cache"]
    ran = [
        subprocess.run(
            [*map(str, command), *some],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "MYPYPATH": str(PACKAGE.parent)},
        )
        for some in (right, wrong)
    ]
    assert ran[0].returncode == 0, ran[0].stdout + ran[0].stderr
    assert (ran[1].returncode, ran[1].stdout.count("error:")) == (1, len(FAULTS))
    assert all(word in ran[1].stdout for _, _, word in FAULTS.values())


@pytest.mark.tier("outside")
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
    for some in (right, wrong):
        pyright = tmp_path / "node_modules" / ".bin" / "pyright"
        ran = subprocess.run(
            [pyright, "--pythonpath", sys.executable, "--outputjson", *some],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        said.append([one["message"] for one in json.loads(ran.stdout)["generalDiagnostics"]])
    assert said[0] == []
    assert all(word in " ".join(said[1]) for _, _, word in FAULTS.values())

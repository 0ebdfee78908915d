"""The worked example of docs/architecture.md is a patch: applied to a copy of this checkout, its test passes there."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from support.paths import DOCS

ROOT = DOCS.parent


def test_the_worked_example_applies_and_runs(tmp_path: Path) -> None:
    found = re.search(r"```diff\n(.*?)```", (DOCS / "architecture.md").read_text("utf-8"), re.DOTALL)
    assert found is not None
    patch = tmp_path / "example.patch"
    patch.write_text(found[1], "utf-8")
    checkout = tmp_path / "checkout"
    tests = ("tests/support", "docs/make")
    for folder in ("compiler", "schemas", "templates", "parts", "cmake", "bazel", "viewer/built", *tests):
        shutil.copytree(ROOT / folder, checkout / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "tests/renew.py"):
        shutil.copy(ROOT / file, checkout / file)
    subprocess.run(["git", "apply", "-C1", str(patch)], cwd=checkout, check=True)
    env = {**os.environ, "PYTHONPATH": str(checkout / "compiler"), "PYTHONDONTWRITEBYTECODE": "1"}
    (added,) = checkout.glob("tests/**/test_part_number.py")
    test = ("-m", "pytest", "-q", "-c", os.devnull, "-p", "no:cacheprovider", added)
    for words in (("tests/renew.py", "schema"), test):
        command = [sys.executable, *words]
        ran = subprocess.run(command, cwd=checkout, env=env, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stdout + ran.stderr

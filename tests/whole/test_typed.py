"""Scripts that use the public names are sound for mypy in its strict mode, which finds the faults that they mark."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import PACKAGE, TESTS


@pytest.mark.tier("outside")
@pytest.mark.slow
def test_mypy_in_its_strict_mode_has_nothing_to_say(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    scripts = sorted((TESTS / "data" / "typed").glob("*.py"))
    words = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", tmp_path / "cache"]
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}
    ran = subprocess.run([*words, *scripts], capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr

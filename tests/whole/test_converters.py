"""The comparison with other converters: what the page shows is what the benchmark measures."""

import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import DOCS, ROOT
from support.public_robots import ROBOTS


@pytest.mark.slow
@pytest.mark.tier("robots")
def test_the_tables_of_the_page_are_up_to_date(tmp_path: Path) -> None:
    command = [sys.executable, ROOT / "benchmarks" / "converters.py", "--environments", tmp_path]
    command += ["--check", DOCS / "converters.md"]
    if ROBOTS is not None:
        command += ["--robots", ROBOTS / "example-robot-data"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout

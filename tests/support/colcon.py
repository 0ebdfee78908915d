"""Colcon, which may be in another environment than the tests (``COLCON`` names it), and ament_cmake, Debian's."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

COLCON = os.environ.get("COLCON") or shutil.which("colcon") or ""
SITE = Path("/usr/lib/python3/dist-packages")
AMENT_PACKAGE = SITE / "ament_package"
AMENT_CMAKE = Path("/usr/share/ament_cmake/cmake/ament_cmakeConfig.cmake")
NEEDS_COLCON = pytest.mark.skipif(not COLCON, reason="colcon is not here: pip install colcon-common-extensions")
NEEDS_CMAKE = pytest.mark.skipif(
    not Path("/usr/share/ament_cmake_pytest/cmake/ament_cmake_pytestConfig.cmake").is_file(),
    reason="no ament-cmake-pytest",
)


def colcon(folder: Path, *words: str, fails: bool = False, ros: str = "") -> str:
    """Run colcon in a workspace; return what it prints.

    ``ros`` is a Python with ROS 2 from PyPI, whose ament_cmake takes the place of Debian's.
    """
    environment = {**os.environ, "COLCON_HOME": str(folder / "home"), "PYTHONPATH": str(folder / "site")}
    environment["PATH"] = f"{Path(COLCON).parent}:{Path(ros or sys.executable).parent}:{environment['PATH']}"
    (folder / "site").mkdir(exist_ok=True)
    if ros:
        prefix = str(Path(ros).parent.parent)
        environment |= {"AMENT_PREFIX_PATH": prefix, "CMAKE_PREFIX_PATH": prefix}
    # What ament_cmake and the test of a package ask for; the other packages of Debian's Python would be in the way.
    for module in () if ros else ("ament_package", "ament_cmake_test", "ament_index_python"):
        if (SITE / module).is_dir() and not (folder / "site" / module).exists():
            (folder / "site" / module).symlink_to(SITE / module)
    done = subprocess.run([COLCON, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert bool(done.returncode) == fails, done.stdout + done.stderr
    return done.stdout + done.stderr

"""Building with CMake: a project around the arm of tests/data/cmake, and what a build of it ran."""

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from rosorin_compile.source.project import data_folder
from support.paths import DATA

WORKSPACE = DATA / "cmake" / "workspace"
ARM = WORKSPACE / "src" / "arm_description"
PROGRAM = Path(sys.executable).parent / "rosorin-compile"
GENERATORS = [name for name, program in (("Ninja", "ninja"), ("Unix Makefiles", "make")) if shutil.which(program)]
HEAD = """\
cmake_minimum_required(VERSION 3.8)
project(plain NONE)
find_package(rosorin_compile 0.1 REQUIRED)
"""


class Built(Exception):
    """A build that failed; the text is what it printed."""


def project(folder: Path, calls: str) -> Path:
    """Write a project with the arm and these calls of CMake, and return its folder."""
    source = folder / "a plain project"
    if not source.exists():
        shutil.copytree(ARM, source)
    (source / "CMakeLists.txt").write_text(HEAD + calls + "\n", "utf-8")
    return source


def configure(source: Path, *options: str, program: str = str(PROGRAM), generator: str = GENERATORS[0]) -> str:
    """Run CMake and return what it prints, its lines joined as it has wrapped them. Raises Built."""
    words = [
        "-G",
        generator,
        f"-Drosorin_compile_DIR={data_folder('cmake')}",
        f"-DROSORIN_COMPILE_EXECUTABLE={program}",
    ]
    return _run(["cmake", "-S", str(source), "-B", str(source / "build"), *words, *options], source)


def build(source: Path, *options: str) -> str:
    """Build, and return what that prints. Raises Built."""
    return _run(["cmake", "--build", str(source / "build"), *options], source)


def ran(printed: str) -> list[str]:
    """Return the robots that a build compiled, and ``golden NAME`` for those that it compared, sorted."""
    found = re.findall(r"^\[.*?\] rosorin-compile: ([^:]+): (the committed)?", printed, re.MULTILINE)
    return sorted(f"golden {name}" if golden else name for name, golden in found)


def _run(words: Sequence[str], folder: Path) -> str:
    done = subprocess.run(
        words,
        cwd=folder,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        env=environment(folder),
    )
    if done.returncode:
        raise Built(done.stdout)
    return done.stdout


def environment(folder: Path) -> dict[str, str]:
    """Return the environment of a build: nobody's packages, a cache of its own."""
    kept = {name: text for name, text in os.environ.items() if name not in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")}
    return {**kept, "ROSORIN_COMPILE_CACHE": str(folder / "cache"), "CMAKE_COLOR_DIAGNOSTICS": "OFF"}


def plainly(printed: str) -> str:
    """Return what CMake prints without its line breaks."""
    return " ".join(printed.split())

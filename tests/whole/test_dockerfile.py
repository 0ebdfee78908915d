"""The Dockerfile, without Docker: its files and extras exist, and what it copies is enough to build the wheel."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import ROOT
from support.snapshot import network, snapshot

DOCKERFILE = (ROOT / "Dockerfile").read_text("utf-8")
PYPROJECT = (ROOT / "pyproject.toml").read_text("utf-8")


def copies() -> list[tuple[list[str], str]]:
    """Return the COPY instructions that read the repository: sources and destination."""
    words = [shlex.split(line)[1:] for line in DOCKERFILE.splitlines() if line.startswith("COPY ")]
    return [(sources, destination) for *sources, destination in words if not sources[0].startswith("--from=")]


def test_copied_files_exist_and_are_not_ignored() -> None:
    lines = (ROOT / ".dockerignore").read_text("utf-8").splitlines()
    included = {line[1:] for line in lines if line.startswith("!")}
    assert "*" in lines
    assert all((ROOT / name).exists() for name in included)
    assert included == {source for sources, _ in copies() for source in sources}


def test_the_extras_and_the_python_are_supported() -> None:
    (extras,) = re.findall("^ARG EXTRAS=(.+)$", DOCKERFILE, re.MULTILINE)
    for extra in extras.split(","):
        assert re.search(rf"^{extra} = \[", PYPROJECT, re.MULTILINE), extra
    versions = set(re.findall(r"^FROM python:(\d\.\d+)-slim", DOCKERFILE, re.MULTILINE))
    assert len(versions) == 1
    assert f'"Programming Language :: Python :: {versions.pop()}"' in PYPROJECT


@pytest.mark.tier("pythons")
@pytest.mark.slow
def test_the_copied_files_build_the_wheel_of_the_repository(tmp_path: Path) -> None:
    network()
    whole = snapshot(tmp_path / "whole")
    for sources, destination in copies():
        for source in sources:
            target = tmp_path / "image" / destination / (source if destination == "./" else "")
            target.parent.mkdir(parents=True, exist_ok=True)
            if (whole / source).is_dir():
                shutil.copytree(whole / source, target)
            else:
                shutil.copy2(whole / source, target)
    (command,) = re.findall("^RUN pip (wheel .+) --wheel-dir /wheels .$", DOCKERFILE, re.MULTILINE)
    for folder in (whole, tmp_path / "image"):
        words = [*command.split(), "--quiet", "--wheel-dir", tmp_path / f"{folder.name}-wheels", folder]
        subprocess.run([sys.executable, "-m", "pip", *words], check=True)
    (wheel,) = (tmp_path / "image-wheels").iterdir()
    assert wheel.read_bytes() == (tmp_path / "whole-wheels" / wheel.name).read_bytes()

"""What is handed out: one version, a sdist that is the repository, a page for an index, nothing that leads nowhere.

``.ci/archives`` makes sdist and wheel twice and compares the bytes; ``.ci/run`` asks the wheel what installs an extra.
"""

import json
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
from email import message_from_bytes
from pathlib import Path

import pytest

from rosorin_compile import __version__
from rosorin_compile.source.version import HOME
from support.paths import ROOT
from support.snapshot import network, of_clone, snapshot

VERSION = re.compile(r"^## \[(\d+\.\d+\.\d+)\] - \d{4}-\d\d-\d\d$", re.MULTILINE)
# What builds make, and what sdist adds.
MADE = re.compile(r"^(PKG-INFO|setup\.cfg|compiler/rosorin_compile\.egg-info/.*)$")


def test_the_version_is_the_same_everywhere() -> None:
    patterns = {
        "pyproject.toml": r'^version = "(.+)"$',
        "CITATION.cff": r"^version: (.+)$",
        "cmake/rosorin_compileConfigVersion.cmake": r'^set\(PACKAGE_VERSION "(.+)"\)',
        "package.xml": "<version>(.+)</version>",
        "ament/rosorin_compile_cmake/package.xml": "<version>(.+)</version>",
        "CHANGELOG.md": VERSION.pattern,
    }
    found = {}
    for file, pattern in patterns.items():
        match = re.search(pattern, (ROOT / file).read_text("utf-8"), re.MULTILINE)
        found[file] = match[1] if match else ""
    for file in ("viewer/package.json", "viewer/package-lock.json"):
        found[file] = json.loads((ROOT / file).read_text("utf-8"))["version"]
    assert found == dict.fromkeys(found, __version__)


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sdist")
    for name in of_clone("ls-files", "-z").split("\0")[:-1]:
        if (ROOT / name).is_file():
            (folder / "tree" / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / "tree" / name)
    build = "import sys; from setuptools import build_meta as b; b.build_sdist(sys.argv[1])"
    subprocess.run([sys.executable, "-c", build, folder], cwd=folder / "tree", check=True, capture_output=True)
    return folder / f"rosorin_compile-{__version__}.tar.gz"


@pytest.mark.tier("pythons")
@pytest.mark.slow
def test_an_sdist_is_the_repository_without_time_and_owner(sdist: Path) -> None:
    with tarfile.open(sdist) as archive:
        entries = archive.getmembers()
    top = f"rosorin_compile-{__version__}/"
    assert [one.name for one in entries] == sorted(one.name for one in entries)
    assert {(one.mtime, one.uid, one.gid, one.uname, one.gname, one.mode & ~0o111) for one in entries} == {
        (315532800, 0, 0, "", "", 0o644)
    }
    names = [one.name.removeprefix(top) for one in entries]
    tracked = [name for name in of_clone("ls-files").splitlines() if (ROOT / name).is_file()]
    assert [name for name in names if not MADE.match(name)] == sorted(tracked)
    assert sdist.read_bytes()[4:8] == bytes(4)  # no time in the head of gzip


@pytest.mark.slow
def test_the_page_of_an_index_names_no_file_of_the_repository(sdist: Path) -> None:
    with tarfile.open(sdist) as archive:
        information = archive.extractfile(f"rosorin_compile-{__version__}/PKG-INFO")
        assert information is not None
        about = message_from_bytes(information.read())
    text = str(about.get_payload())
    assert about["Description-Content-Type"] == "text/markdown"
    assert bool(about.get_all("Project-URL")) == bool(HOME)
    assert text.startswith("# rosorin-compile\n")
    assert "<!--" not in text
    assert "docs/pictures" not in text
    assert not re.findall(r"\]\((?!https?://)", text)
    readme = (ROOT / "README.md").read_text("utf-8")
    assert [line for line in text.splitlines() if line.startswith("## ")] == [
        line for line in readme.splitlines() if line.startswith("## ")
    ]


# The Dockerfile, without Docker: its files and extras exist, and what it copies is enough to build the wheel.


DOCKERFILE = (ROOT / "Dockerfile").read_text("utf-8")


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

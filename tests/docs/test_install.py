"""The commands of docs/install.md run in a clone, each block with an empty home folder.

A block that contains the words "not run here" is skipped. Blocks run in the order of the page: the first one makes the
environment that later ones use.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.colcon import COLCON
from support.pages import Block, blocks
from support.paths import DOCS
from support.snapshot import network, snapshot

PAGE = (DOCS / "install.md").read_text("utf-8")
SHELL = [block for block in blocks(PAGE) if block.language == "sh"]
SYSTEM = "import click, jinja2, jsonschema, venv, yaml"


def runs(block: Block) -> bool:
    return "not run here" not in "\n".join(block.lines)


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    network()
    return snapshot(tmp_path_factory.mktemp("install") / "clone")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with pipx and, where it is installed, colcon, whose Python gets the requirements of the tool."""
    folder = tmp_path_factory.mktemp("programs")
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    subprocess.run([folder / "venv/bin/pip", "install", "--quiet", "pipx"], check=True)
    (folder / "bin").mkdir()
    (folder / "bin" / "pipx").symlink_to(folder / "venv/bin/pipx")
    if COLCON:
        (folder / "bin" / "colcon").symlink_to(COLCON)
        pip = [Path(COLCON).with_name("python"), "-m", "pip", "install", "--quiet", "--target", folder / "site"]
        subprocess.run([*pip, "click", "jinja2", "jsonschema", "pyyaml"], check=True)
    return folder


@pytest.mark.tier("pythons")
@pytest.mark.slow
@pytest.mark.parametrize("block", [block for block in SHELL if runs(block)], ids=lambda block: f"line{block.start + 1}")
def test_commands_run(block: Block, clone: Path, programs: Path, tmp_path: Path) -> None:
    script = "\n".join(block.lines)
    if "colcon" in script and not (programs / "bin" / "colcon").exists():
        pytest.skip("colcon is not here: pip install colcon-common-extensions")
    system = "/usr/bin/python3" in script
    if system and subprocess.run(["/usr/bin/python3", "-c", SYSTEM], capture_output=True, check=False).returncode:
        pytest.skip("/usr/bin/python3 does not have the packages")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    env = {**kept, "HOME": str(tmp_path), "PATH": f"{programs / 'bin'}:{os.environ['PATH']}"}
    if "colcon" in script:
        env["PYTHONPATH"] = str(programs / "site")
    done = subprocess.run(
        ["bash", "-ec", script],
        cwd=clone,
        env=env,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, f"{script}\n{done.stdout[-3000:]}"
    if "rosorin-compile --version" in script:
        assert done.stdout.splitlines()[-1].startswith("rosorin-compile ")
    for program in (".local/bin/rosorin-compile", "rosorin/bin/rosorin-compile"):
        if (tmp_path / program).exists():
            version = subprocess.check_output([tmp_path / program, "--version"], env=env, text=True)
            assert version.startswith("rosorin-compile ")
    if system:
        where = [tmp_path / "rosorin/bin/python", "-c", "import jinja2, yaml; print(jinja2.__file__, yaml.__file__)"]
        assert all(path.startswith("/usr/lib/") for path in subprocess.check_output(where, text=True).split())

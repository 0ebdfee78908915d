"""MuJoCo 3.12 and 3.17 import, prove and load MJCFs as MuJoCo 4 does; they are installed from PyPI for this test."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import DATA

pytestmark = pytest.mark.slow

PROGRAM = "import sys; from rosorin_compile.cli.main import main; sys.exit(main(sys.argv[1:]))"
HELD = "MuJoCo's model of the MJCF is that of the source"


@pytest.fixture(scope="module", params=["3.12.0", "3.17.0"])
def environment(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of a process that imports this MuJoCo."""
    folder = tmp_path_factory.mktemp("mujoco")
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--target", str(folder)]
    done = subprocess.run([*install, f"mujoco=={request.param}"], capture_output=True, timeout=300)
    if done.returncode:
        pytest.skip(f"mujoco {request.param} cannot be installed here")
    made = {**os.environ, "PYTHONPATH": str(folder)}
    said = run(folder, made, "-c", "import mujoco; print(mujoco.__version__)")
    assert said.stdout.strip() == request.param
    return made


def run(folder: Path, environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize("name", ["ant", "half_cheetah", "hopper", "inverted_double_pendulum", "reacher"])
def test_an_import_is_proven_and_its_mjcf_loads(name: str, environment: dict[str, str], tmp_path: Path) -> None:
    file = str(DATA / "mjcf" / "public" / f"{name}.xml")
    done = run(tmp_path, environment, "-c", PROGRAM, "import", file)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    assert HELD in said
    (folder,) = (tmp_path / "descriptions").iterdir()
    done = run(tmp_path, environment, "-c", PROGRAM, "all", str(folder), "-o", "made")
    assert done.returncode == 0, done.stdout + done.stderr
    (mjcf,) = [path for path in Path(tmp_path, "made").rglob("*.xml") if "<mujoco" in path.read_text("utf-8")]
    done = run(tmp_path, environment, "-c", "import mujoco, sys; mujoco.MjModel.from_xml_path(sys.argv[1])", str(mjcf))
    assert done.returncode == 0, done.stderr

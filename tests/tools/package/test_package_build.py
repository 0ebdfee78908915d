"""The package builds: colcon from PyPI runs, ament_cmake from Debian where it is installed.

``COLCON`` names a colcon of another environment than the one in which the tests run.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from support.paths import ROSORIN

COLCON = os.environ.get("COLCON") or shutil.which("colcon")
AMENT_CMAKE = Path("/usr/share/ament_cmake/cmake/ament_cmakeConfig.cmake")
AMENT_PACKAGE = Path("/usr/lib/python3/dist-packages/ament_package")
NAME = "rosorin_description"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(COLCON is None, reason="colcon is not here: pip install colcon-common-extensions"),
]


def build(folder: Path, kind: str, *more: str) -> Path:
    """Build the package in a workspace and return its share folder in the install space."""
    source = folder / "src" / NAME
    assert main(["package", str(ROSORIN), "-o", str(source), "--build-type", kind]) == 0
    assert COLCON is not None
    environment = {**os.environ, "COLCON_HOME": str(folder / "home")}
    environment["PATH"] = f"{Path(COLCON).parent}:{environment['PATH']}"
    if (
        AMENT_PACKAGE.is_dir()
    ):  # ament_cmake asks for this one package of Debian, and the others there would be in the way
        (folder / "site").mkdir()
        (folder / "site/ament_package").symlink_to(AMENT_PACKAGE)
        environment["PYTHONPATH"] = str(folder / "site")
    ran = subprocess.run(
        [COLCON, "build", *more], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert "1 package finished" in ran.stdout
    return folder / "install" / NAME / "share" / NAME


KINDS = [
    "ament_python",
    pytest.param("ament_cmake", marks=pytest.mark.skipif(not AMENT_CMAKE.is_file(), reason="no ament-cmake")),
]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("link", [False, True])
def test_what_is_installed_is_what_was_written(
    tmp_path: Path, kind: str, link: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    share = build(tmp_path, kind, *["--symlink-install"] * link)
    source = tmp_path / "src" / NAME
    data = ("config", "doc", "launch", "mjcf", "rviz", "urdf")
    written = {p.relative_to(source).as_posix(): p.read_bytes() for d in data for p in (source / d).rglob("*")}
    assert len(written) > 8
    assert {name: (share / name).read_bytes() for name in written} == written
    assert (share / "package.xml").is_file()
    assert (share.parent / "ament_index/resource_index/packages" / NAME).is_file()
    capsys.readouterr()
    assert main(["check", str(ROSORIN), "--deployed", str(share)]) == 0
    urdf = source / "urdf/rosorin.urdf"
    urdf.write_text(urdf.read_text("utf-8").replace("0.16044", "0.17044"), "utf-8")
    # What is built without links is as it was; what is linked follows the source.
    assert main(["check", str(ROSORIN), "--deployed", str(share)]) == (1 if link else 0)


def test_an_install_space_that_is_older(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    share = build(tmp_path, "ament_python")
    source = tmp_path / "src" / NAME
    (share / "urdf/rosorin.urdf").write_text("<robot name='old'><link name='base_link'/></robot>\n")
    capsys.readouterr()
    assert main(["deploy", str(ROSORIN), "--to", str(source), "--map", "static_tf=none"]) == 0
    said = capsys.readouterr().err
    assert "what runs, and it is not what was deployed: urdf/rosorin.urdf (older)\n" in said
    assert "colcon build --packages-select rosorin_description; without --symlink-install" in said
    (share / "urdf/rosorin.urdf").write_bytes((source / "urdf/rosorin.urdf").read_bytes())
    assert main(["deploy", str(ROSORIN), "--to", str(source)]) == 0
    assert "deploy-not-built" not in capsys.readouterr().err

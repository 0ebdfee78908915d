"""The package builds: colcon from PyPI runs, ament_cmake from Debian where it is installed."""

import re
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.colcon import NEEDS_CMAKE, NEEDS_COLCON, SITE, colcon
from support.launch import read
from support.paths import ROSORIN

NAME = "rosorin_description"

pytestmark = [pytest.mark.slow, NEEDS_COLCON]


def build(folder: Path, kind: str, *more: str) -> Path:
    source = folder / "src" / NAME
    assert main(["package", str(ROSORIN), "-o", str(source), "--build-type", kind]) == 0
    assert "1 package finished" in colcon(folder, "build", *more)
    return folder / "install" / NAME / "share" / NAME


BUILDS = pytest.mark.tier("builds")
PYTHON, CMAKE = "ament_python", "ament_cmake"


def kinds(landing: str) -> pytest.MarkDecorator:
    marks = {kind: [] if kind == landing else [BUILDS] for kind in (PYTHON, CMAKE)}
    marks[CMAKE].append(NEEDS_CMAKE)
    return pytest.mark.parametrize("kind", [pytest.param(kind, marks=marks[kind]) for kind in (PYTHON, CMAKE)])


@pytest.mark.parametrize(
    ("link", "kind"),
    [
        pytest.param(False, PYTHON, id="False-ament_python"),
        pytest.param(False, CMAKE, id="False-ament_cmake", marks=[BUILDS, NEEDS_CMAKE]),
        pytest.param(True, PYTHON, id="True-ament_python", marks=BUILDS),
        pytest.param(True, CMAKE, id="True-ament_cmake", marks=[BUILDS, NEEDS_CMAKE]),
    ],
)
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
    assert main(["check", "deployed", str(ROSORIN), str(share)]) == 0
    urdf = source / "urdf/rosorin.urdf"
    urdf.write_text(urdf.read_text("utf-8").replace("0.16044", "0.17044"), "utf-8")
    # What is built without links is as it was; what is linked follows the source.
    assert main(["check", "deployed", str(ROSORIN), str(share)]) == (1 if link else 0)


@pytest.mark.tier("builds")
@pytest.mark.skipif(not (SITE / "ament_index_python").is_dir(), reason="no python3-ament-index")
@kinds(PYTHON)
def test_the_test_of_the_package_runs_and_finds_what_is_wrong(tmp_path: Path, kind: str) -> None:
    share = build(tmp_path, kind)
    colcon(tmp_path, "test", "--return-code-on-test-failure")
    found = colcon(tmp_path, "test-result", "--all")
    assert "2 tests, 0 errors, 0 failures, 0 skipped" in found
    urdf = share / "urdf/rosorin.urdf"
    urdf.write_text(urdf.read_text("utf-8").replace('<child link="link2"/>', '<child link="nobody"/>'), "utf-8")
    colcon(tmp_path, "test")
    assert re.search("0 errors, [12] failure", colcon(tmp_path, "test-result", "--all", fails=True))


@pytest.mark.skipif(not (SITE / "ament_index_python").is_dir(), reason="no python3-ament-index")
@kinds(CMAKE)
def test_a_description_compiles_from_the_install_space(tmp_path: Path, kind: str) -> None:
    source = tmp_path / "src" / NAME
    words = ["package", str(ROSORIN), "-o", str(source), "--build-type", kind, "--compile-at-launch"]
    assert main(words) == 0
    colcon(tmp_path, "build")
    colcon(tmp_path, "test", "--return-code-on-test-failure")
    assert "3 tests, 0 errors, 0 failures, 0 skipped" in colcon(tmp_path, "test-result", "--all")
    share = tmp_path / "install" / NAME / "share" / NAME
    source.rename(tmp_path / "gone")
    for form in ("py", "xml", "yaml"):
        nodes = read(share / f"launch/description.launch.{form}", {NAME: share}).nodes
        assert [node.name for node in nodes] == ["tf_base_laser", "tf_base_imu", "robot_state_publisher"]
        assert nodes[-1].parameters["robot_description"] == (share / "urdf/rosorin.urdf").read_text("utf-8")
    assert main(["check", "deployed", str(ROSORIN), str(share)]) == 0

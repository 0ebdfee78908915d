"""Where a package is: what is said first, then the paths of ROS, then the folders around the file."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.source.packages import Packages


def package(folder: Path, name: str = "") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    if name:
        (folder / "package.xml").write_text(f"<package><name> {name}\n</name></package>", "utf-8")
    return folder


def found(source: Path, name: str, environment: dict[str, str] | None = None, **given: Path) -> Path | None:
    return Packages(given, environment or {}, source).find(name)


def test_order(tmp_path):
    source = package(tmp_path / "src" / "arm", "arm") / "urdf" / "arm.urdf"
    beside = package(tmp_path / "src" / "deep" / "er" / "x", "hand")
    assert found(source, "arm") == tmp_path / "src" / "arm"
    assert found(source, "hand") == beside
    share = package(tmp_path / "install" / "share" / "hand")
    ament = {"AMENT_PREFIX_PATH": f"/nowhere:{tmp_path / 'install'}"}
    assert found(source, "hand", ament) == share
    ros = package(tmp_path / "ws" / "group" / "hand_description", "hand")
    assert found(source, "hand", ament | {"ROS_PACKAGE_PATH": str(tmp_path / "ws")}) == ros
    assert found(source, "hand", ament, hand=tmp_path / "said") == tmp_path / "said"


def test_folders_without_package_xml(tmp_path):
    source = package(tmp_path / "robots" / "arm_description" / "urdf") / "arm.urdf"
    package(tmp_path / "robots" / "hand_description")
    assert found(source, "arm_description") == tmp_path / "robots" / "arm_description"
    assert found(source, "hand_description") == tmp_path / "robots" / "hand_description"
    assert found(source, "none") is None


def test_damaged_package_xml_is_called_as_its_folder(tmp_path):
    folder = package(tmp_path / "src" / "arm")
    (folder / "package.xml").write_text("<package", "utf-8")
    assert found(folder / "arm.urdf", "arm") == folder


@pytest.mark.parametrize("name", ["", ".", "..", "../x", "a/b", "a\0b", "\\"])
def test_names_that_no_package_has(tmp_path, name):
    assert found(tmp_path / "arm.urdf", name) is None


def test_addresses(tmp_path):
    source = package(tmp_path / "arm", "arm") / "arm.urdf"
    packages = Packages({}, {}, source)
    folder = source.parent
    assert packages.resolve("package://arm/meshes/a%20b.stl", folder) == tmp_path / "arm/meshes/a%20b.stl"
    assert packages.resolve("package://none/a.stl", folder) is None
    assert packages.resolve("file:///a/b%20c.stl", folder) == Path("/a/b c.stl")
    assert packages.resolve("meshes/a.stl", folder) == folder / "meshes/a.stl"
    assert packages.resolve("/a/b.stl", folder) == Path("/a/b.stl")
    assert packages.resolve("https://a.invalid/b.stl", folder) is None


def test_links_that_lead_round_end(tmp_path):
    folder = package(tmp_path / "src" / "arm", "arm")
    (tmp_path / "src" / "loop").symlink_to(tmp_path / "src")
    assert found(folder / "arm.urdf", "none") is None


def test_a_package_may_be_a_link(tmp_path):
    """A checkout that is linked into a workspace, as rospack and colcon find it."""
    real = package(tmp_path / "checkout" / "hand", "hand")
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "hand").symlink_to(real)
    environment = {"ROS_PACKAGE_PATH": str(tmp_path / "src")}
    assert found(tmp_path / "elsewhere" / "arm.urdf", "hand", environment) == tmp_path / "src" / "hand"

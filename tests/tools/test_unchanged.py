"""``all`` says "unchanged" only if a run would do the same again: also where names of packages lead elsewhere now."""

from __future__ import annotations

import importlib
import shutil
import struct
import sys
import time
from pathlib import Path
from unittest import mock

import pytest

from rosorin_compile.cli import compiling
from rosorin_compile.cli.main import main

URDF = """\
<robot name="vendor"><link name="base_link"><visual><geometry><sphere radius="{}"/></geometry></visual></link></robot>
"""
INCLUDE = "robot: mine\ninclude: [{package: vendor, file: urdf/v.urdf}]\noutputs: {urdf: {file: mine.urdf}}\n"
PART = """\
robot: mine
links: {base: {}}
use: {w: {part: acme:parts/ball, parent: base}}
outputs: {urdf: {file: mine.urdf}}
"""
PARTS = """\
parts:
  ball:
    links: {{ball: {{visual: [{{sphere: {{radius: {}}}}}]}}}}
    joints: {{ball_joint: {{type: fixed, parent: mount, child: ball}}}}
"""


def describe(home: Path, text: str) -> None:
    (home / "descriptions" / "mine").mkdir(parents=True)
    (home / "descriptions" / "mine" / "robot.yaml").write_text(text)
    time.sleep(0.03)  # the clock of file times moves in steps, of 10 ms on some systems


def vendor(top: Path, radius: float, folder: str = "vendor", name: str = "vendor") -> Path:
    (top / folder / "urdf").mkdir(parents=True)
    (top / folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    (top / folder / "urdf" / "v.urdf").write_text(URDF.format(radius))
    time.sleep(0.03)
    return top


def compiled(capsys: pytest.CaptureFixture[str], code: int = 0) -> tuple[bool, str]:
    """Compile; return whether nothing was compiled, and the radius that is in the artifact."""
    capsys.readouterr()
    assert main(["all"]) == code
    unchanged = capsys.readouterr().out.endswith(", unchanged\n")
    return unchanged, Path("outputs/mine/mine.urdf").read_text().partition('radius="')[2].partition('"')[0]


@pytest.fixture
def ros(home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project whose robot comes from a package in ``base``; ``overlay``, which stands before it, is empty."""
    describe(home, INCLUDE)
    vendor(home / "base", 1)
    (home / "overlay").mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{home / 'overlay'}:{home / 'base'}")
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    return home


def test_a_package_that_comes_into_an_overlay(ros: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compiled(capsys) == (False, "1")
    assert compiled(capsys) == (True, "1")
    vendor(ros / "overlay", 2, "sub/other_folder")
    assert compiled(capsys) == (False, "2")
    assert compiled(capsys) == (True, "2")
    shutil.rmtree(ros / "overlay" / "sub")
    assert compiled(capsys) == (False, "1")


def test_a_package_that_gets_the_name(ros: Path, capsys: pytest.CaptureFixture[str]) -> None:
    vendor(ros / "overlay", 2, name="other")
    assert compiled(capsys) == (False, "1")
    assert compiled(capsys) == (True, "1")
    (ros / "overlay" / "vendor" / "package.xml").write_text("<package><name>vendor</name></package>")
    assert compiled(capsys) == (False, "2")


def test_the_same_package_by_another_way_is_the_same(
    ros: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The resolution counts, not the whole environment."""
    assert compiled(capsys) == (False, "1")
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{ros / 'base'}:{ros / 'nowhere'}")
    monkeypatch.setenv("AMENT_PREFIX_PATH", "/nowhere")
    assert compiled(capsys) == (True, "1")


def test_a_package_that_is_gone(ros: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert compiled(capsys) == (False, "1")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(ros / "overlay"))
    assert compiled(capsys, code=1) == (False, "1")
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    assert compiled(capsys, code=1) == (False, "1")


def test_a_package_of_ros_2(ros: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    vendor(ros / "one" / "share", 3)
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{ros / 'two'}:{ros / 'one'}")
    assert compiled(capsys) == (False, "3")
    assert compiled(capsys) == (True, "3")
    vendor(ros / "two" / "share", 4)
    assert compiled(capsys) == (False, "4")


def test_a_package_that_comes_beside_the_description(
    ros: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing but the folders around the description says where it is; a nearer one goes before a farther one."""
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    vendor(ros, 5)
    assert compiled(capsys) == (False, "5")
    assert compiled(capsys) == (True, "5")
    vendor(ros / "descriptions", 6)
    assert compiled(capsys) == (False, "6")


def test_a_package_that_the_description_names_needs_no_look(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    vendor(home / "descriptions" / "mine" / "given", 1)
    describe_text = INCLUDE.replace("file: urdf", "packages: {vendor: given/vendor}, file: urdf")
    (home / "descriptions" / "mine" / "robot.yaml").write_text(describe_text)
    time.sleep(0.03)
    assert compiled(capsys) == (False, "1")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(vendor(home / "overlay", 2)))
    assert compiled(capsys) == (True, "1")


def acme(top: Path, radius: str) -> str:
    (top / "acme").mkdir(parents=True)
    (top / "acme" / "__init__.py").write_text("raise SystemExit('imported')")
    (top / "acme" / "parts.yaml").write_text(PARTS.format(radius))
    time.sleep(0.03)
    return str(top)


def test_a_part_of_a_package_of_python(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As with another PYTHONPATH, with none, and with an installation in between."""
    describe(home, PART)
    ways = list(sys.path)
    first, second = acme(home / "first", "1"), acme(home / "second", "2")
    for way, code, expected in (
        ([first], 0, (False, "1")),
        ([first], 0, (True, "1")),
        ([second], 0, (False, "2")),
        ([second], 0, (True, "2")),
        ([second, first], 0, (True, "2")),
        ([first, second], 0, (False, "1")),
        ([], 1, (False, "1")),
        ([first], 0, (True, "1")),
        ([str(home / "third"), first], 0, (True, "1")),
    ):
        monkeypatch.setattr(sys, "path", [*way, *ways])
        importlib.invalidate_caches()
        assert compiled(capsys, code) == expected, way
    acme(home / "third", "3")
    importlib.invalidate_caches()
    assert compiled(capsys) == (False, "3")


def test_no_place_of_this_machine_is_in_an_artifact(ros: Path, capsys: pytest.CaptureFixture[str]) -> None:
    compiled(capsys)
    assert str(ros) not in (ros / "outputs" / "mine" / "mine.urdf").read_text()


MESHED = "robot: mine\nlinks: {base: {visual: [{mesh: {file: %s}}]}}\noutputs: {urdf: {file: mine.urdf}%s}\n"
MJCF = ", mjcf: {file: mine.xml}"


def stl(mark: bytes) -> bytes:
    corners = (0, 0, 0, 1, 0, 0, 0, 1, 0), (0, 0, 0, 0, 1, 0, 0, 0, 1), (0, 0, 0, 0, 0, 1, 1, 0, 0)
    faces = b"".join(struct.pack("<12fH", 0, 0, 0, *face, 0) for face in (*corners, (1, 0, 0, 0, 0, 1, 0, 1, 0)))
    return mark.ljust(80) + struct.pack("<I", 4) + faces


def put(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    time.sleep(0.03)


def again(capsys: pytest.CaptureFixture[str], code: int = 0) -> bool:
    """Compile; return whether nothing was compiled."""
    with mock.patch.object(compiling, "compile_proven", wraps=compiling.compile_proven) as compiled:
        assert main(["all"]) == code
    assert compiled.called or capsys.readouterr().out.endswith(", unchanged\n")
    capsys.readouterr()
    return not compiled.called


def copied() -> bytes:
    return Path("outputs/mine/meshes/vendor/m.stl").read_bytes()[:4]


def test_a_mesh_of_a_package_and_its_overlay(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    describe(home, MESHED % ("package://vendor/m.stl", MJCF))
    vendor(home / "base", 1)
    put(home / "base/vendor/m.stl", stl(b"base"))
    (home / "overlay").mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", f"{home / 'overlay'}:{home / 'base'}")
    assert not again(capsys)
    assert again(capsys)
    assert copied() == b"base"
    put(home / "base/vendor/m.stl", stl(b"new "))
    assert not again(capsys)
    assert again(capsys)
    vendor(home / "overlay", 2)
    put(home / "overlay/vendor/m.stl", stl(b"over"))
    assert not again(capsys)
    assert copied() == b"over"
    assert again(capsys)
    (home / "overlay/vendor/m.stl").unlink()  # the package is found still, and has no such file
    assert not again(capsys)


@pytest.mark.parametrize("more", ["", MJCF], ids=["urdf", "mjcf"])
@pytest.mark.parametrize("name", ["package://vendor/m.stl", "package://vendor/../m.stl"])
def test_a_mesh_that_is_missing_and_comes(
    name: str, more: str, home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    describe(home, MESHED % (name, more))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(home / "overlay"))
    assert not again(capsys)
    assert again(capsys)
    vendor(home / "overlay", 2)  # what is told is another thing now: the package has no such file
    assert not again(capsys)
    assert again(capsys)
    if ".." not in name:
        put(home / "overlay/vendor/m.stl", stl(b"over"))
        assert not again(capsys)
        assert again(capsys)
        assert not more or copied() == b"over"


def test_a_mesh_of_a_urdf_that_comes_and_goes(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    describe(home, MESHED % ("m.stl", ""))
    assert not again(capsys)
    assert again(capsys)
    put(home / "descriptions/mine/m.stl", stl(b""))
    assert not again(capsys)
    assert again(capsys)
    put(home / "descriptions/mine/m.stl", stl(b"other"))
    assert not again(capsys)  # it is beside the URDF
    assert (home / "outputs/mine/m.stl").read_bytes().startswith(b"other")
    (home / "descriptions/mine/m.stl").unlink()
    assert not again(capsys)


def test_a_nearer_file_than_the_one_beside_the_artifacts(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    describe(home, MESHED % ("m.stl", MJCF))
    put(home / "outputs/mine/m.stl", stl(b"beside"))
    assert not again(capsys)
    assert again(capsys)
    put(home / "descriptions/mine/m.stl", stl(b"nearer"))
    assert not again(capsys)
    assert (home / "outputs/mine/m.stl").read_bytes().startswith(b"nearer")


def test_a_mesh_that_cannot_be_read_is_tried_anew(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Not as long as it is what it was, on a machine where the same is installed."""
    pytest.importorskip("trimesh")
    describe(home, MESHED % ("m.dae", MJCF))
    put(home / "descriptions/mine/m.dae", b"<COLLADA")
    assert not again(capsys)
    assert again(capsys)
    put(home / "descriptions/mine/m.dae", b"<COLLADB")
    assert not again(capsys)

"""Meshes that a source names relative to itself: what import says of them, and what finds them afterwards."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rosorin_compile.cli import main

ROBOT = """\
<robot name="arm">
  <material name="wood"><texture filename="wood.png"/></material>
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="meshes/base.stl"/></geometry></visual>
    <visual><geometry><mesh filename="package://arm/meshes/cover.stl"/></geometry></visual>
    <collision><geometry><mesh filename="meshes/base.stl"/></geometry></collision>
  </link>
  <link name="file"/>
  <joint name="outputs" type="fixed"><parent link="base"/><child link="file"/></joint>
</robot>
"""
TETRAHEDRON = """\
solid base
facet normal 0 0 -1
outer loop
vertex 0 0 0
vertex 0 1 0
vertex 1 0 0
endloop
endfacet
facet normal 0 -1 0
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 1
endloop
endfacet
facet normal -1 0 0
outer loop
vertex 0 0 0
vertex 0 0 1
vertex 0 1 0
endloop
endfacet
facet normal 1 1 1
outer loop
vertex 1 0 0
vertex 0 1 0
vertex 0 0 1
endloop
endfacet
endsolid base
"""
MODEL = """\
<mujoco model="arm">
  <compiler meshdir="meshes"/>
  <asset><mesh name="base" file="base.obj"/></asset>
  <worldbody>
    <body name="base">
      <geom type="mesh" mesh="base"/>
      <body name="tip"><joint name="turn" type="hinge"/><geom type="capsule" size="0.1 0.2" mass="1"/></body>
    </body>
  </worldbody>
</mujoco>
"""
OBJECT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
NAMED = "files of meshes or textures are named as seen from"


@pytest.fixture
def here(tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path_factory.mktemp("cache")))
    folder = tmp_path / "vendor"
    (folder / "meshes").mkdir(parents=True)
    (folder / "arm.urdf").write_text(ROBOT, "utf-8")
    (folder / "arm.xml").write_text(MODEL, "utf-8")
    (folder / "meshes" / "base.stl").write_text(TETRAHEDRON, "utf-8")
    (folder / "meshes" / "base.obj").write_text(OBJECT, "utf-8")
    return tmp_path


def run(*words: str) -> int:
    try:
        return main([*words])
    except SystemExit as stopped:
        return int(stopped.code or 0)


def names(urdf: Path) -> list[str]:
    return [found.get("filename", "") for found in ET.parse(urdf).getroot().iter() if found.get("filename")]


def test_it_is_said_once_with_what_helps_and_is_no_loss(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "vendor" / "wood.png").write_bytes(b"")
    assert run("import", "vendor/arm.urdf", "--strict") == 0
    assert capsys.readouterr().err == (
        f"vendor/arm.urdf:1:14: warning[import-mesh-path]: {NAMED} arm.urdf, but readers look from the artifacts: "
        "wood.png and 1 more\n"
        '    1 | <robot name="arm">\n'
        "      |              ^^^ import again with --meshes ../../vendor, which is right for outputs/arm, "
        "or package://NAME\n"
    )
    text = (here / "descriptions" / "arm" / "robot.yaml").read_text("utf-8")
    assert "file: meshes/base.stl" in text


def test_a_file_that_is_not_there_is_no_help(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert not (here / "vendor" / "wood.png").exists()
    assert run("import", "vendor/arm.urdf", "-o", "elsewhere") == 0
    said = capsys.readouterr().err
    assert "import again with --meshes FOLDER, as seen from the artifacts, or --meshes package://NAME\n" in said


@pytest.mark.parametrize(
    ("meshes", "before"),
    [("../../vendor", "../../vendor/"), ("package://arm", "package://arm/"), ("a b/", "a b/"), ("${pi}", "${pi}/")],
)
def test_relative_names_alone_get_the_folder(
    here: Path, capsys: pytest.CaptureFixture[str], meshes: str, before: str
) -> None:
    assert run("import", "vendor/arm.urdf", "--meshes", meshes) == 0
    said = capsys.readouterr()
    assert "the compiled URDF is the same robot" in said.out
    assert "import-mesh-path" not in said.err
    where = here / "outputs" / "arm" / f"{before}meshes"  # as seen from the artifacts
    if "://" not in before and ".." not in before:
        where.mkdir(parents=True)
        (where / "base.stl").write_text(TETRAHEDRON, "utf-8")
    assert run("all", "arm") == 0
    expected = ["wood.png", "meshes/base.stl", "package://arm/meshes/cover.stl", "meshes/base.stl"]
    expected = [name if "://" in name else before + name for name in expected]
    assert names(here / "outputs" / "arm" / "arm.urdf") == expected


@pytest.mark.slow
@pytest.mark.parametrize("output", [(), ("-o", "descriptions/other"), ("-o", "robots/deep/arm")])
def test_mujoco_finds_the_meshes_with_what_the_warning_says(
    here: Path, capsys: pytest.CaptureFixture[str], output: tuple[str, ...]
) -> None:
    mujoco = pytest.importorskip("mujoco")
    assert run("import", "vendor/arm.xml", *output) == 0
    said = capsys.readouterr()
    assert f"{NAMED} arm.xml, but readers look from the artifacts: meshes/base.obj\n" in said.err
    assert "its URDF is URDF 1.2, for the capsules; ROS up to Jazzy does not read it" in said.out
    folder = said.err.partition("--meshes ")[2].partition(",")[0]
    assert run("import", "vendor/arm.xml", *output, "--force", "--meshes", folder) == 0
    made = Path(output[1] if output else "descriptions/arm")
    assert "\n  # URDF 1.2, for the capsules; ROS" in (made / "robot.yaml").read_text("utf-8")
    assert run("all", str(made)) == 0
    model = mujoco.MjModel.from_xml_path(str(here / "outputs" / made.name / "arm.xml"))
    assert model.nmesh == 1


def test_the_meshes_are_found_beside_the_urdf(here: Path) -> None:
    assert run("import", "vendor/arm.urdf", "--meshes", os.path.join("..", "..", "vendor")) == 0
    assert run("all") == 0
    urdf = here / "outputs" / "arm" / "arm.urdf"
    assert [(urdf.parent / name).is_file() for name in names(urdf) if name.endswith("base.stl")] == [True, True]


def test_a_robot_without_such_names(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "bare.urdf").write_text('<robot name="bare"><link name="base"/></robot>', "utf-8")
    assert run("import", "bare.urdf", "--meshes", "x") == 0
    assert capsys.readouterr().err == (
        "bare.urdf:1:14: warning[import-mesh-path]: bare.urdf names no mesh or texture by a relative path: "
        "--meshes changes nothing\n"
        '    1 | <robot name="bare"><link name="base"/></robot>\n'
        "      |              ^^^^ leave --meshes out\n"
    )


@pytest.mark.parametrize("meshes", ["", " ", "package://", "a\nb"])
def test_what_no_name_can_begin_with(here: Path, capsys: pytest.CaptureFixture[str], meshes: str) -> None:
    assert run("import", "vendor/arm.urdf", "--meshes", meshes) == 2
    expected = f'rosorin-compile: --meshes "{meshes}" is neither a folder nor package://NAME\n'
    assert capsys.readouterr().err == expected
    assert not (here / "descriptions").exists()


def test_arguments_of_a_file_that_takes_none(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["foo:=3"], ["-a", "foo=3"]):
        assert run("import", "vendor/arm.urdf", *words) == 2
        assert capsys.readouterr().err == "rosorin-compile: vendor/arm.urdf takes no arguments: only a xacro does\n"
    assert not (here / "descriptions").exists()

"""Meshes that a source names relative to itself: what import says of them, and what finds them afterwards."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import data_text

ROBOT = data_text("robots/import_meshes.urdf")
CORNERS = ((0, 0, 0), (0, 1, 0), (1, 0, 0), (0, 0, 1))
TETRAHEDRON = "solid base\n{}endsolid base\n".format(
    "".join(
        "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n".format(
            "".join("vertex {} {} {}\n".format(*CORNERS[corner]) for corner in face)
        )
        for face in ((0, 1, 2), (0, 2, 3), (0, 3, 1), (2, 1, 3))
    )
)
MODEL = data_text("robots/import_meshes_model.mjcf.xml")
OBJECT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


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
    return main([*words])


def names(urdf: Path) -> list[str]:
    return [found.get("filename", "") for found in ET.parse(urdf).getroot().iter() if found.get("filename")]


def found(folder: Path) -> list[bool]:
    urdf = next(folder.rglob("*.urdf"))
    return [(urdf.parent / name).is_file() for name in names(urdf) if "://" not in name]


def test_relative_names_are_found_from_then_on(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "vendor" / "wood.png").write_bytes(b"")
    assert run("import", "vendor/arm.urdf", "--strict") == 0
    said = capsys.readouterr()
    assert said.err == (
        "vendor/arm.urdf:6:39: warning[mesh-not-found]: mesh package://arm/meshes/cover.stl is not found: "
        "there is no package arm here\n"
        '    6 |     <visual><geometry><mesh filename="package://arm/meshes/cover.stl"/></geometry></visual>\n'
        "      |                                       ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ "
        "--package arm=FOLDER says where it is; readers of the URDF look for it themselves\n"
    )
    text = (here / "descriptions" / "arm" / "robot.yaml").read_text("utf-8")
    assert "file: meshes/base.stl" in text
    assert "source: {status: imported, note: from arm.urdf, folder: ../../vendor}\n" in text
    assert "accept" not in text
    assert run("all") == 0
    assert (
        "warning[mesh-not-found]: mesh package://arm/meshes/cover.stl is not in the package arm"
        in capsys.readouterr().err
    )
    assert found(here / "outputs") == [True, True, True]


LEADING = {
    "upwards": ("../meshes/base.stl", "pkg/urdf", "pkg/meshes", "meshes/base.stl"),
    "beside and upwards": ("../pkg/./meshes/base.stl", "pkg", "pkg/meshes", "meshes/base.stl"),
    "a file of this machine": ("file://HERE/theirs/pkg/meshes/base.stl", "pkg/urdf", "pkg/meshes", "meshes/base.stl"),
    "a path of this machine": ("HERE/theirs/pkg/meshes/base.stl", "pkg/urdf", "pkg/meshes", "meshes/base.stl"),
    "a package by its folder": ("package://pkg/meshes/base.stl", "pkg/a/b", "pkg/meshes", ""),
    "a package by its manifest": ("package://other/meshes/base.stl", "pkg/a/b", "pkg/meshes", ""),
    "a package beside": ("package://next_one/base.stl", "pkg/urdf", "next_one", ""),
    "a package with a slash more": ("package:///pkg/meshes/base.stl", "pkg/urdf", "pkg/meshes", ""),
    "a model": ("model://pkg/meshes/base.stl", "pkg/urdf", "pkg/meshes", "meshes/pkg/meshes/base.stl"),
}


@pytest.mark.parametrize(("name", "place", "meshes", "becomes"), LEADING.values(), ids=LEADING)
def test_where_a_name_leads_from_its_own_file(
    here: Path, capsys: pytest.CaptureFixture[str], name: str, place: str, meshes: str, becomes: str
) -> None:
    theirs = here / "theirs"
    (theirs / place).mkdir(parents=True)
    (theirs / meshes).mkdir(parents=True, exist_ok=True)
    (theirs / meshes / "base.stl").write_text(TETRAHEDRON, "utf-8")
    if "other" in name:
        (theirs / "pkg" / "package.xml").write_text("<package><name>other</name></package>", "utf-8")
    name = name.replace("HERE", str(here))
    text = ROBOT.replace('"meshes/base.stl"', f'"{name}"').replace("package://arm/meshes/cover.stl", name)
    (theirs / place / "arm.urdf").write_text(re.sub("<material.*\n", "", text), "utf-8")
    assert run("import", str(theirs / place / "arm.urdf")) == 0
    assert capsys.readouterr().err == ""
    assert run("all") == 0
    assert "mesh-not-found" not in capsys.readouterr().err
    urdf, mjcf = (here / "outputs" / "arm" / f"arm{ending}" for ending in (".urdf", ".xml"))
    assert set(names(urdf)) == {becomes or name}
    assert not becomes or found(here / "outputs") == [True] * 3
    (mesh,) = ET.parse(mjcf).getroot().findall("asset/mesh")
    assert (mjcf.parent / mesh.get("file", "")).read_bytes()[80:84] == b"\4\0\0\0"
    for made in (*here.glob("descriptions/arm/*"), urdf, mjcf):
        assert str(here) not in made.read_text("utf-8")
    assert run("check") == 0


XACRO = data_text("robots/import_meshes_xacro.xacro")


@pytest.mark.parametrize("relative", ["base.obj", "../meshes/base.obj"])
def test_meshes_of_a_xacro_whose_macros_are_kept(here: Path, capsys: pytest.CaptureFixture[str], relative: str) -> None:
    pytest.importorskip("xacro")
    mujoco = pytest.importorskip("mujoco")
    for folder in ("pkg/urdf", "pkg/meshes", "beside"):
        (here / "ws" / folder).mkdir(parents=True)
        (here / "ws" / folder / "base.obj").write_text(OBJECT, "utf-8")
    for package in ("pkg", "beside"):
        (here / "ws" / package / "package.xml").write_text(f"<package><name>{package}</name></package>", "utf-8")
    (here / "ws/pkg/urdf/arm.xacro").write_text(XACRO.replace("RELATIVE", relative), "utf-8")
    assert run("import", "ws/pkg/urdf/arm.xacro", "--trust") == 0
    said = capsys.readouterr()
    assert "1 of 1 macro kept" in said.out
    assert ("import-mesh-path" in said.err) == relative.startswith("..")
    assert run("all") == 0
    assert "mesh-not-found" not in capsys.readouterr().err
    model = mujoco.MjModel.from_xml_path(str(here / "outputs/arm/arm.xml"))
    assert int((model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).sum()) == 4


MODEL_OF_GAZEBO = """\
<sdf version="1.9"><model name="crate"><link name="base"><inertial><mass>1</mass></inertial>
  <visual name="v"><geometry><mesh><uri>model://crate/meshes/base.stl</uri></mesh></geometry></visual>
  <collision name="c"><geometry><mesh><uri>meshes/base.stl</uri></mesh></geometry></collision>
</link></model></sdf>
"""


@pytest.mark.parametrize("by", ["its own folder", "GZ_SIM_RESOURCE_PATH"])
def test_a_model_of_gazebo(
    here: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, by: str
) -> None:
    own = here / ("models/crate" if by == "its own folder" else "elsewhere")
    for folder in (here / "models" / "crate" / "meshes", own / "meshes"):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "base.stl").write_text(TETRAHEDRON, "utf-8")
    (own / "model.sdf").write_text(MODEL_OF_GAZEBO, "utf-8")
    if by != "its own folder":
        monkeypatch.setenv(by, str(here / "models"))
    assert run("import", str(own / "model.sdf")) == 0
    assert run("all") == 0
    assert "mesh-not-found" not in capsys.readouterr().err
    assert ("packages:" in (here / "descriptions/crate/robot.yaml").read_text("utf-8")) == (by == "its own folder")
    made = ET.parse(here / "outputs" / "crate" / "crate.sdf")
    assert [one.text for one in made.iter("uri")] == ["model://crate/meshes/base.stl", "meshes/base.stl"]
    urdf = here / "outputs" / "crate" / "crate.urdf"
    assert names(urdf) == ["meshes/crate/meshes/base.stl", "meshes/base.stl"]
    assert all((urdf.parent / name).is_file() for name in names(urdf))
    assert (here / "outputs" / "crate" / "meshes" / "base.stl").is_file()


@pytest.mark.parametrize("package", ["", "far_meshes"])
@pytest.mark.parametrize("scheme", ["", "file://"])
def test_no_path_of_this_machine_is_written(
    here: Path, tmp_path_factory: pytest.TempPathFactory, scheme: str, package: str
) -> None:
    far = tmp_path_factory.mktemp("far")
    (far / "base.stl").write_text(TETRAHEDRON, "utf-8")
    if package:
        (far / "package.xml").write_text(f"<package><name>{package}</name></package>", "utf-8")
    text = (here / "vendor" / "arm.urdf").read_text("utf-8").replace("meshes/base.stl", f"{scheme}{far}/base.stl")
    (here / "vendor" / "arm.urdf").write_text(text, "utf-8")
    assert run("import", "vendor/arm.urdf") == 0
    written = "".join(path.read_text("utf-8") for path in (here / "descriptions" / "arm").iterdir())
    assert str(far) not in written
    assert f"package://{package}/base.stl" in written if package else True
    assert run("all", "arm") == 0
    assert list((here / "outputs" / "arm").glob("**/base.stl"))


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
def test_mujoco_finds_the_meshes_of_an_mjcf_from_then_on(
    here: Path, capsys: pytest.CaptureFixture[str], output: tuple[str, ...]
) -> None:
    mujoco = pytest.importorskip("mujoco")
    assert run("import", "vendor/arm.xml", *output) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert "its URDF is URDF 1.2, for the capsules; ROS up to Jazzy does not read it" in said.out
    made = Path(output[1] if output else "descriptions/arm")
    assert "\n# URDF 1.2, for the capsules; ROS" in (made / "robot.yaml").read_text("utf-8")
    assert run("all", str(made)) == 0
    model = mujoco.MjModel.from_xml_path(str(here / "outputs" / made.name / "arm.xml"))
    assert model.nmesh == 1

"""Meshes of a description: where they are looked for, what gets beside the MJCF, and what is said of the rest."""

import shutil
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli import watch
from rosorin_compile.cli.main import main
from rosorin_compile.source.project import Description
from rosorin_compile.source.system import pip_install
from support.commands import parse
from support.projects import stl

ROBOT = """robot: r
links:
  base:
    collision: [{{mesh: {{file: "{0}"}}}}]
outputs: {{urdf: {{file: r.urdf}}{1}}}
"""
MJCF = ", mjcf: {file: r.xml}"
CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def letters() -> str:
    facets = ""
    for face in FACES:
        corners = "".join(f"vertex {' '.join(map(str, CORNERS[i]))}\n" for i in face)
        facets += f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"
    return f"solid corner\n{facets}endsolid corner\n"


def dae(unit: str = "1") -> str:
    places = " ".join(str(v) for corner in CORNERS for v in corner)
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit meter="{unit}"/><up_axis>Z_UP</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="12">{places}</float_array><technique_common>
      <accessor source="#a" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>{" ".join(str(i) for face in FACES for i in face)}</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
  </library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
"""


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "project").mkdir()
    monkeypatch.chdir(tmp_path / "project")
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)


def describe(file: str, more: str = MJCF) -> Path:
    folder = Path("descriptions/r")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robot.yaml").write_text(ROBOT.format(file, more), "utf-8")
    return folder


def put(path: Path, data: bytes | str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def ours(name: str = "r.xml") -> str:
    return Path("outputs/r", name).read_text("utf-8")


def loads(faces: int = 4) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path("outputs/r/r.xml")
    assert model.nmesh == 1
    assert model.nmeshface == faces


@pytest.mark.parametrize("how", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_a_mesh_of_a_package_is_found_by_the_paths_of_ros(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    describe("package://arm/meshes/part.stl")
    folder = tmp_path / ("ws/arm" if how == "ROS_PACKAGE_PATH" else "prefix/share/arm")
    put(folder / "package.xml", "<package><name>arm</name></package>")
    put(folder / "meshes/part.stl", stl())
    monkeypatch.setenv(how, str(tmp_path / ("ws" if how == "ROS_PACKAGE_PATH" else "prefix")))
    assert main(["all", "r"]) == 0
    assert 'file="meshes/arm/meshes/part.stl"' in ours()
    assert 'filename="package://arm/meshes/part.stl"' in ours("r.urdf")
    loads()
    assert main(["check", "r"]) == 0


@pytest.mark.parametrize(("name", "made"), [("part.dae", "part.dae.obj"), ("PART.DAE", "PART.DAE.obj")])
def test_a_dae_becomes_an_obj_of_metres(name: str, made: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("trimesh")
    put(describe(name) / name, dae("0.001"))
    assert main(["all", "--notes"]) == 0
    said = capsys.readouterr().err
    assert f"note[mesh-converted]: mesh {name} is converted for the MJCF: MuJoCo reads binary STL, OBJ and MSH" in said
    assert f'file="{made}"' in ours()
    assert f'filename="{name}"' in ours("r.urdf")
    lines = Path("outputs/r", made).read_text("utf-8").splitlines()
    corners = [line for line in lines if line.startswith("v ")]
    faces = [line.split()[1:] for line in lines if line.startswith("f ")]
    assert {int(number) for face in faces for number in face} == {1, 2, 3, 4}  # OBJ counts from 1
    assert corners == ["v 0 0 0", "v 0 0 0.00100000005", "v 0 0.00100000005 0", "v 0.00100000005 0 0"]
    assert main(["check"]) == 0
    assert "mesh-converted" not in capsys.readouterr().err


def artifacts() -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in Path("outputs").rglob("*") if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "data"), [("b.stl", letters()), ("c.dae", dae())])
def test_artifacts_do_not_depend_on_trimesh(
    name: str, data: bytes | str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    put(describe(name, f"{MJCF}, scene: {{file: scene.xml}}") / name, data)
    assert main(["all"]) == 0
    made = artifacts()
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    assert artifacts() == made
    shutil.rmtree("outputs")
    capsys.readouterr()
    if name.endswith(".dae"):
        assert main(["all"]) == 1
        said = capsys.readouterr().err
        assert f"robot.yaml:4:31: error[extra-missing]: mesh {name} is not converted for the MJCF: " in said
        assert pip_install("import") in said
        assert not Path("outputs").exists()
        assert main(["all", "--only", "urdf"]) == 0
    else:
        assert main(["all"]) == 0
        assert artifacts() == made


@pytest.mark.slow
def test_what_is_converted_never_stands_outside_of_the_artifacts() -> None:
    pytest.importorskip("trimesh")
    describe("../../vendor/part.dae")
    put(Path("vendor/part.dae"), dae())
    assert main(["all"]) == 0
    assert 'file="meshes/vendor/part.dae.obj"' in ours()
    loads()
    assert sorted(path.name for path in Path("vendor").iterdir()) == ["part.dae"]


@pytest.mark.parametrize("name", ["part.stl", "package://arm/part.stl"])
def test_watch_sees_a_mesh_that_comes(name: str) -> None:
    folder = describe(name)
    (folder.parent / "arm").mkdir()
    time.sleep(0.05)  # what changed just before a compilation is read again
    robot = watch.WatchedRobot(Description("r", folder / "robot.yaml", Path("outputs/r")), parse(["watch"]))
    assert not robot.inputs.has_changed()
    put((folder.parent / "arm" if "arm" in name else folder) / "part.stl", stl())
    assert robot.inputs.has_changed()
    robot.compile()
    loads()

"""Meshes of a description: where they are looked for, what gets beside the MJCF, and what is said of the rest."""

import os
import shutil
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli import watch
from rosorin_compile.cli.main import main
from rosorin_compile.cli.run import Run
from rosorin_compile.source.project import Description
from rosorin_compile.source.system import pip_install
from support.commands import parse

ROBOT = """robot: r
links:
  base:
    collision: [{{mesh: {{file: "{0}"}}}}]
outputs: {{urdf: {{file: r.urdf}}{1}}}
"""
MJCF = ", mjcf: {file: r.xml}"
CORNERS = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


def stl() -> bytes:
    import struct

    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in CORNERS[i]), 0) for face in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + triangles


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


def test_a_mesh_that_is_nowhere_is_an_error_with_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    describe("missing.stl")
    assert main(["all"]) == 1
    said = capsys.readouterr().err
    message = "mesh missing.stl is not there, neither as seen from the artifacts nor beside the description"
    assert f"descriptions/r/robot.yaml:4:31: error[mesh-not-found]: {message}\n" in said
    assert "put the file next to the description, or correct the name, or take mjcf out of outputs" in said
    assert not Path("outputs").exists()


def test_without_mjcf_it_is_a_warning(capsys: pytest.CaptureFixture[str]) -> None:
    describe("missing.stl", "")
    assert main(["all"]) == 0
    assert "robot.yaml:4:31: warning[mesh-not-found]: mesh missing.stl is not there, " in capsys.readouterr().err
    assert 'filename="missing.stl"' in ours("r.urdf")


@pytest.mark.parametrize("name", ["a%sb{0}.stl", "meshes/ä.STL", "deep/er/part.stl"])
def test_a_mesh_beside_the_description_gets_beside_the_artifacts(name: str) -> None:
    folder = describe(name)
    put(folder / name, stl())
    assert main(["all"]) == 0
    assert Path("outputs/r", name).read_bytes() == stl()
    assert main(["check"]) == 0
    loads()


def test_a_mesh_beside_an_included_file_is_found() -> None:
    folder = describe("part.stl")
    text = (folder / "robot.yaml").read_text("utf-8")
    head, links, rest = text.partition("links:\n")[0], text[text.index("links:") : text.index("outputs:")], "outputs:"
    (folder / "in").mkdir()
    (folder / "in" / "links.yaml").write_text(links, "utf-8")
    outputs = text[text.index(rest) :]
    (folder / "robot.yaml").write_text(f"{head}include: [in/links.yaml]\n{outputs}", "utf-8")
    put(folder / "in" / "part.stl", stl())
    assert main(["all"]) == 0
    loads()


def test_what_stands_beside_the_artifacts_stays() -> None:
    describe("meshes/part.stl")
    put(Path("outputs/r/meshes/part.stl"), stl())
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    loads()


@pytest.mark.parametrize("how", ["--package", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "beside", "own"])
def test_a_mesh_of_a_package_is_found_as_import_finds_it(
    how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    describe("package://arm/meshes/part.stl")
    more: list[str] = []
    if how == "--package":
        put(tmp_path / "elsewhere/meshes/part.stl", stl())
        more = ["--package", f"arm={tmp_path}/elsewhere"]
    elif how == "ROS_PACKAGE_PATH":
        put(tmp_path / "ws/arm/package.xml", "<package><name>arm</name></package>")
        put(tmp_path / "ws/arm/meshes/part.stl", stl())
        monkeypatch.setenv(how, str(tmp_path / "ws"))
    elif how == "AMENT_PREFIX_PATH":
        put(tmp_path / "prefix/share/arm/meshes/part.stl", stl())
        monkeypatch.setenv(how, str(tmp_path / "prefix"))
    elif how == "beside":
        put(Path("descriptions/arm/meshes/part.stl"), stl())
    else:
        put(Path("package.xml"), "<package><name>arm</name></package>")
        put(Path("meshes/part.stl"), stl())
    assert main(["all", "r", *more]) == 0
    assert 'file="meshes/arm/meshes/part.stl"' in ours()
    assert 'filename="package://arm/meshes/part.stl"' in ours("r.urdf")
    loads()
    assert main(["check", "r", *more]) == 0


def test_artifacts_with_their_meshes_are_the_same_where_the_package_is_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    describe("package://arm/part.stl")
    put(tmp_path / "arm/part.stl", stl())
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 0
    before = ours()
    assert main(["all"]) == 0
    assert main(["check"]) == 0
    assert ours() == before
    assert "mesh-not-found" not in capsys.readouterr().err
    put(tmp_path / "arm/part.stl", stl().replace(bytes(80), b"new".ljust(80)))
    assert main(["check", "--package", f"arm={tmp_path}/arm"]) == 1
    assert (
        "meshes/arm/part.stl: another file than the mesh is; rosorin-compile all writes it" in capsys.readouterr().out
    )
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 0
    assert main(["check", "--package", f"arm={tmp_path}/arm"]) == 0


def test_a_package_that_is_nowhere_is_told_and_the_mjcf_loads_without(capsys: pytest.CaptureFixture[str]) -> None:
    describe("package://arm/part.stl")
    assert main(["all"]) == 0
    said = capsys.readouterr().err
    what = "mesh package://arm/part.stl is not found: there is no package arm here, and left out of r.xml"
    assert f"descriptions/r/robot.yaml:4:31: warning[mesh-not-found]: {what}\n" in said
    assert "--package arm=FOLDER says where it is" in said
    assert "<mesh" not in ours()
    assert 'filename="package://arm/part.stl"' in ours("r.urdf")
    assert main(["check"]) == 0
    pytest.importorskip("mujoco").MjModel.from_xml_path("outputs/r/r.xml")


@pytest.mark.parametrize(
    "name", ["package://arm/../../etc/passwd.stl", "package://arm", "package:///x.stl", "http://h/x.stl"]
)
def test_addresses_that_lead_nowhere_are_told(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    describe(name)
    (tmp_path / "arm").mkdir()
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 0
    assert f"robot.yaml:4:31: warning[mesh-not-found]: mesh {name} is " in capsys.readouterr().err
    assert "<mesh" not in ours()


@pytest.mark.parametrize("kind", ["fifo", "device", "folder"])
def test_what_is_no_file_is_an_error_with_its_line(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    folder = describe("part.stl")
    if kind == "fifo":
        os.mkfifo(folder / "part.stl")
    elif kind == "device":
        (folder / "part.stl").symlink_to("/dev/zero")
    else:
        (folder / "part.stl").mkdir()
    assert main(["all"]) == 1
    said = capsys.readouterr().err
    what = "mesh part.stl is no regular file: descriptions/r/part.stl"
    assert f"descriptions/r/robot.yaml:4:31: error[mesh-not-a-file]: {what}\n" in said


@pytest.mark.parametrize(
    ("name", "data", "what"),
    [
        ("part.stl", b"", "the file is empty"),
        ("part.stl", stl()[:-1], "the STL is damaged"),
        ("part.stl", stl()[:80] + bytes(4), "it has 0 triangles, and MuJoCo reads 1 to 200,000 of an STL"),
        ("part.dae", b"<COLLADA", "is not a mesh that can be read as DAE"),
        ("part.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "a vertex is not three numbers"),
    ],
    ids=["empty", "cut", "no triangle", "broken dae", "broken letters"],
)
def test_a_mesh_that_cannot_be_read_is_left_out_and_told(
    name: str, data: bytes, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    put(describe(name) / name, data)
    assert main(["all"]) == 0
    said = capsys.readouterr().err
    assert f"robot.yaml:4:31: warning[mesh-not-read]: mesh {name} is left out of the MJCF: {what}" in said
    assert "Traceback" not in said
    assert "<mesh" not in ours()


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


def test_an_ascii_stl_becomes_a_binary_one_without_trimesh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    put(describe("part.stl") / "part.stl", letters())
    assert main(["all"]) == 0
    loads()
    first = Path("outputs/r/part.stl").read_bytes()
    assert main(["all"]) == 0
    assert Path("outputs/r/part.stl").read_bytes() == first
    assert main(["check"]) == 0


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


def test_a_change_of_a_mesh_is_seen(capsys: pytest.CaptureFixture[str]) -> None:
    folder = describe("part.stl")
    put(folder / "part.stl", stl())
    assert main(["all"]) == 0
    put(folder / "part.stl", stl().replace(bytes(80), b"new".ljust(80)))
    assert main(["all"]) == 0
    assert "written: 1 mesh file\n" in capsys.readouterr().out
    assert Path("outputs/r/part.stl").read_bytes().startswith(b"new")


@pytest.mark.slow
def test_what_is_converted_never_stands_outside_of_the_artifacts() -> None:
    pytest.importorskip("trimesh")
    describe("../../vendor/part.dae")
    put(Path("vendor/part.dae"), dae())
    assert main(["all"]) == 0
    assert 'file="meshes/vendor/part.dae.obj"' in ours()
    loads()
    assert sorted(path.name for path in Path("vendor").iterdir()) == ["part.dae"]


def two_parts(first: bytes, second: bytes, more: str = MJCF) -> Path:
    folder = describe("wheel.stl", more)
    for name, data in (("left", first), ("right", second)):
        links = f"links: {{{name}: {{visual: [{{mesh: {{file: wheel.stl}}}}]}}}}"
        joint = f"joints: {{{name}_joint: {{type: fixed, parent: base, child: {name}}}}}"
        put(folder / name / "part.yaml", f"{links}\n{joint}\n")
        put(folder / name / "wheel.stl", data)
    outputs = f"outputs: {{urdf: {{file: r.urdf}}{more}}}"
    text = f"robot: r\ninclude: [left/part.yaml, right/part.yaml]\nlinks: {{base: {{}}}}\n{outputs}\n"
    put(folder / "robot.yaml", text)
    return folder


def other() -> bytes:
    return stl().replace(bytes(80), b"other".ljust(80))


def test_two_files_of_one_name_are_an_error(capsys: pytest.CaptureFixture[str]) -> None:
    folder = two_parts(stl(), other())
    assert main(["all"]) == 1
    said = capsys.readouterr().err
    where = "descriptions/r/right/wheel.stl here, descriptions/r/left/wheel.stl elsewhere"
    assert (
        "descriptions/r/right/part.yaml:1:40: error[mesh-ambiguous]: mesh wheel.stl would be two files next to r.xml:"
        f" {where}\n"
    ) in said
    assert "give one of the two files another name" in said
    assert "descriptions/r/left/part.yaml:1:39: and here" in said
    put(folder / "right/wheel.stl", stl())
    assert main(["all"]) == 0
    assert ", unchanged" not in capsys.readouterr().out
    assert main(["all"]) == 0
    assert ", unchanged" in capsys.readouterr().out
    put(folder / "right/wheel.stl", other())  # the one that is not copied counts as well
    assert main(["all"]) == 1
    (folder / "right/wheel.stl").unlink()
    assert main(["all"]) == 0


def test_two_files_of_one_name_in_a_urdf_are_a_warning(capsys: pytest.CaptureFixture[str]) -> None:
    two_parts(stl(), other(), "")
    assert main(["all"]) == 0
    said = capsys.readouterr().err
    assert "warning[mesh-ambiguous]: mesh wheel.stl is two files, and one name in r.urdf: " in said


def test_two_names_of_one_place_are_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = describe("package://arm/part.stl")
    text = (folder / "robot.yaml").read_text("utf-8")
    shape = '{mesh: {file: "package://arm/part.stl"}}'
    put(folder / "robot.yaml", text.replace(shape, f"{shape}, {{mesh: {{file: meshes/arm/part.stl}}}}"))
    put(tmp_path / "arm/part.stl", stl())
    put(folder / "meshes/arm/part.stl", other())
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 1
    message = (
        "error[mesh-ambiguous]: meshes package://arm/part.stl and meshes/arm/part.stl would both be"
        " meshes/arm/part.stl beside the artifacts, and differ\n"
    )
    assert message in capsys.readouterr().err
    put(folder / "meshes/arm/part.stl", stl())
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 0
    assert main(["all", "--package", f"arm={tmp_path}/arm"]) == 0


@pytest.mark.parametrize("name", ["part.stl", "package://arm/part.stl"])
def test_watch_sees_a_mesh_that_comes(name: str) -> None:
    folder = describe(name)
    (folder.parent / "arm").mkdir()
    robot = watch.WatchedRobot(Description("r", folder / "robot.yaml", Path("outputs/r")), Run.of(parse(["watch"])))
    time.sleep(0.05)  # what changed just before a compilation is read again
    robot.compile()
    assert not robot.inputs.changed()
    put((folder.parent / "arm" if "arm" in name else folder) / "part.stl", stl())
    assert robot.inputs.changed()
    robot.compile()
    loads()

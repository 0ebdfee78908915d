"""Mesh files: every format gives the same triangles, and no broken or hostile file gives a traceback."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model.mesh_triangles import ExtractProblem, load_mesh
from rosorin_compile.source.system import pip_install
from support.meshes import box
from support.paths import DATA
from support.robots import compiled


def bounds(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))


MESHES = DATA / "factory_package" / "meshes"
LOWER, UPPER = (-0.02, 0.01, -0.03), (0.04, 0.05, 0.06)


def export(path: Path, kind: str) -> Path:
    mesh = trimesh.Trimesh(**trimesh.triangles.to_kwargs(box(LOWER, UPPER)))
    if kind == "gltf":
        for name, data in trimesh.Scene([mesh]).export(file_type="gltf").items():
            (path / name).write_bytes(data)
        return path / "model.gltf"
    file = path / f"brick.{kind.removesuffix('_ascii')}"
    mesh.export(file, file_type=kind)
    return file


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "obj", "dae", "glb", "gltf"])
def test_every_format_gives_the_same_triangles(kind: str, tmp_path: Path) -> None:
    triangles = load_mesh(export(tmp_path, kind)).triangles
    assert triangles.shape == (12, 3, 3)
    np.testing.assert_allclose(bounds(triangles), (LOWER, UPPER), atol=1e-8)
    ours, theirs = (
        sorted(np.sort(mesh.mean(axis=1).round(6), axis=0).tolist()) for mesh in (triangles, box(LOWER, UPPER))
    )
    np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_unit_of_a_dae_is_applied_and_its_up_axis_is_not(tmp_path: Path) -> None:
    text = (MESHES / "link2.dae").read_text()
    assert 'meter="0.001"' in text
    wanted = [(-0.01398, -0.03852, -0.00975), (0.01414, 0.00189, 0.09434)]
    for axis in ("X_UP", "Y_UP", "Z_UP"):
        path = tmp_path / f"{axis}.dae"
        path.write_text(text.replace("Z_UP", axis))
        np.testing.assert_allclose(bounds(load_mesh(path).triangles), wanted, atol=1e-8)


def first_number(word: str, semantic: str = "POSITION") -> bytes:
    text = (MESHES / "link2.dae").read_text()
    (source,) = {*re.findall(f'semantic="{semantic}" source="#([^"]+)"', text)}
    made, count = re.subn(
        rf'(<source id="{source}".*?<float_array[^>]*>)\s*\S+', rf"\g<1>{word}", text, count=1, flags=re.DOTALL
    )
    assert count == 1
    return made.encode()


BROKEN = {
    **{
        f"{word}.dae": (first_number(word), "mesh-unreadable", "{} has corners that are not finite numbers")
        for word in ("nan", "NaN", "INF", "-inf", "-1.#IND", "1.#QNAN", "1e39", "-1E+400", "9" * 40)
    },
    "empty.stl": (b"", "mesh-empty", "{} is an empty file"),
    "words.stl": (b"no mesh at all", "mesh-empty", "{} has no triangle"),
    "nothing.stl": (b"solid a\nendsolid a\n", "mesh-empty", "{} has no triangle"),
    "zero.stl": (bytes(84), "mesh-empty", "{} has no triangle"),
    "lines.obj": (b"v 0 0 0\nv 1 1 1\nl 1 2\n", "mesh-empty", "{} has no triangle"),
    "nan.obj": (
        b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "mesh-unreadable",
        "{} has corners that are not finite numbers",
    ),
    "mesh.ply": (b"ply", "mesh-unreadable", "{} is none of .stl, .obj, .dae, .gltf, .glb"),
    "dtd.dae": (
        b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><COLLADA>&b;</COLLADA>',
        "mesh-unreadable",
        "{} has a DTD, which no mesh needs",
    ),
    "wide.dae": (
        '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE a []><COLLADA/>'.encode("utf-16"),
        "mesh-unreadable",
        "{} has a DTD, which no mesh needs",
    ),
    "outside.gltf": (
        json.dumps({"asset": {"version": "2.0"}, "buffers": [{"uri": "../secret.bin", "byteLength": 3}]}).encode(),
        "mesh-unreadable",
        '{} is not a mesh that can be read as GLTF: the file "../secret.bin" is not next to it',
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_say_what_is_wrong(name: str, tmp_path: Path) -> None:
    data, rule, message = BROKEN[name]
    (tmp_path / "secret.bin").write_bytes(b"abc")
    path = tmp_path / "inner" / name
    path.parent.mkdir()
    path.write_bytes(data)
    with pytest.raises(ExtractProblem) as caught:
        load_mesh(path)
    assert caught.value.diagnostic.rule == rule
    assert caught.value.diagnostic.message == message.format(path)
    assert caught.value.diagnostic.help


ORIGINALS = sorted(path for path in MESHES.iterdir() if path.suffix != ".bin")


@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(original=st.sampled_from(ORIGINALS), data=st.data())
def test_damaged_files_are_meshes_or_problems(original: Path, data: st.DataObject, tmp_path: Path) -> None:
    content = bytearray(original.read_bytes())
    for _ in range(data.draw(st.integers(1, 6))):
        at = data.draw(st.integers(0, max(len(content) - 2, 0)))
        what = data.draw(st.sampled_from(["set", "cut", "drop", "digits"]))
        if not content:
            break
        if what == "set":
            content[at] = data.draw(st.integers(0, 255))
        elif what == "digits":
            content[at : at + 1] = b"99999999999"
        elif what == "drop":
            del content[at : at + data.draw(st.integers(1, 50))]
        elif at:
            del content[at:]
    path = tmp_path / original.name
    path.write_bytes(content)
    for side in MESHES.glob("*.bin"):
        (tmp_path / side.name).write_bytes(side.read_bytes())
    rules = {"fine"}
    try:
        mesh = load_mesh(path)
    except ExtractProblem as problem:
        rules = {problem.diagnostic.rule}
    else:
        assert np.isfinite(mesh.triangles).all()
    assert rules <= {"fine", "mesh-unreadable", "mesh-empty"}


def test_without_trimesh_the_way_out_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert main(["extract", "boxes", str(tmp_path / "a.stl")]) == 1
    said = capsys.readouterr().err
    assert said.splitlines() == [
        "error[extra-missing]: reading meshes needs the package trimesh, which is not installed",
        f"    {pip_install('import')} brings what reads meshes",
    ]


BROKEN_NORMAL = """solid x
facet normal a b c
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid x
"""


def test_an_stl_of_letters_with_a_broken_normal_prints_no_traceback(tmp_path: Path) -> None:
    (tmp_path / "a.stl").write_text(BROKEN_NORMAL, "utf-8")
    command = [sys.executable, "-m", "rosorin_compile", "extract", "boxes", "a.stl"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert "Traceback" not in done.stderr
    assert "failed to extract" not in done.stderr


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_is_no_file_is_refused_at_once(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "a.stl"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to("/dev/zero")
    with pytest.raises(ExtractProblem) as raised:
        load_mesh(path)
    assert raised.value.diagnostic.rule == "mesh-unreadable"


MESH_ROBOT = """robot: r
links:
  base:
    inertial: {KEY, of: collision}
    collision: [{mesh: {file: brick.stl}, xyz: [0, 0, 1]}, {box: {size: [0.01, 0.01, 0.01]}, xyz: [0, 0, 1]}]
outputs: {urdf: {file: r.urdf}}
"""


@pytest.mark.parametrize(("key", "mass"), [("density: 1000", 0.217), ("mass: 2", 2)])
def test_a_mesh_has_the_inertia_of_its_solid(tmp_path: Path, key: str, mass: float) -> None:
    export(tmp_path, "stl")
    (tmp_path / "robot.yaml").write_text(MESH_ROBOT.replace("KEY", key))
    inertial = compiled(tmp_path / "robot.yaml").robot.link["base"].inertial
    assert inertial.mass == pytest.approx(mass, rel=1e-6)
    brick = trimesh.Trimesh(**trimesh.triangles.to_kwargs(box(LOWER, UPPER)))
    share = brick.volume / (brick.volume + 1e-6)
    centre = np.array([0, 0, 1]) + brick.center_mass * share
    np.testing.assert_allclose(inertial.pose.xyz, centre, atol=1e-8)


@pytest.mark.parametrize("kind", ["open", "absent"])
def test_a_mesh_without_a_volume_is_an_error(tmp_path: Path, kind: str) -> None:
    if kind == "open":
        triangles = box(LOWER, UPPER)[:-1]
        trimesh.Trimesh(**trimesh.triangles.to_kwargs(triangles)).export(tmp_path / "brick.stl")
    (tmp_path / "robot.yaml").write_text(MESH_ROBOT.replace("KEY", "density: 1000"))
    found = [one for one in compile_robot(tmp_path / "robot.yaml").diagnostics if one.severity == "error"]
    assert [one.rule for one in found] == ["shape-kind"]
    assert "the volume of the mesh brick.stl is unknown" in found[0].message

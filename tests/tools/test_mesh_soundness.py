"""Meshes that are none: MuJoCo loads the MJCF whatever stands in their files, and what is left out is told."""

import struct
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.model.mesh_vertices import UnreadableMesh
from rosorin_compile.mujoco.mesh_copies import check_for_mujoco

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow

NAN, INF = float("nan"), float("inf")
CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
FACES = [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)]
POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"4d" * 32 + b"\nsize 12345\n"
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n"
DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">@ 0 0 1 0 0 0 1 0 0 0 1
</float_array><technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="4">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 3 2 0 1 3 1 2 3</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def stl(*more: tuple[float, ...], count: int | None = None) -> bytes:
    facets = [sum((CORNERS[one] for one in face), ()) for face in FACES] + list(more)
    body = b"".join(struct.pack("<12fH", 0, 0, 1, *facet, 0) for facet in facets)
    return bytes(80) + struct.pack("<I", len(facets) if count is None else count) + body


SOUND = {"a.stl": stl(), "a.obj": OBJ.encode(), "a.dae": DAE.replace("@", "0").encode()}
SOUND["shorthand.obj"] = (OBJ + "f 1 2\n").encode()
SOUND["large.obj"] = OBJ.replace("1", "1.5e+06").replace("f 1.5e+06", "f 1").encode().split(b"f ")[0]
SOUND["points.obj"] = OBJ.partition("f ")[0].encode()
SOUND["behind.obj"] = (OBJ + "f -1 -2 -3\nf 1/1 2/2 3//3\n").encode()
SOUND["no-normal.stl"] = stl().replace(struct.pack("<3f", 0, 0, 1), struct.pack("<3f", NAN, NAN, NAN), 1)

BROKEN = {f"{what}.{ending}": data
          for ending in ("stl", "obj", "dae", "gltf", "glb")
          for what, data in {"pointer": POINTER, "empty": b"", "blank": b" \n", "junk": bytes(range(256)) * 3,
                             "page": b"<!DOCTYPE html><html><body>404</body></html>"}.items()}  # fmt: skip
for name, value in {"nan": NAN, "inf": INF, "far": 3e38, "far-too": 1e30}.items():
    BROKEN[f"{name}.stl"] = stl((value, 0, 0, 1, 0, 0, 0, 1, 0))
    BROKEN[f"{name}.obj"] = f"v {value} 0 0\n{OBJ}".encode()
for number in ("1e400", "-1e39", "12345678901", "x", "1,5"):
    BROKEN[f"{number}.obj"] = OBJ.replace("v 1 0", f"v {number} 0").encode()
for face in ("0 1 2", "1 2 9", "-1 -2 -9"):
    BROKEN[f"face {face}.obj"] = f"{OBJ}f {face}\n".encode()
BROKEN |= {f"cut-{at}.stl": stl()[:at] for at in (10, 60, 84, 100, len(stl()) - 1)}
BROKEN |= {"cut.obj": OBJ[:20].encode(), "same.obj": b"v 0 0 0\n" * 4 + b"f 1 2 3\n", "only-faces.obj": b"f 1 2 3\n"}
BROKEN |= {"none.stl": bytes(84), "same.stl": bytes(80) + struct.pack("<I", 4) + bytes(200), "more.stl": stl() + b"x"}
BROKEN |= {"many.stl": stl(count=999_999_999)}
BROKEN |= {"letters.stl": b"solid a\nfacet normal 0 0 1\n"}


def compiled(folder: Path, name: str, data: bytes, purpose: str) -> None:
    """Compile a robot with a mesh; MuJoCo has to load what is written."""
    body = "inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}"
    links = f'{{base_link: {{}}, b: {{{body}, {purpose}: [{{mesh: {{file: "{name}"}}}}]}}}}'
    text = f"robot: r\nlinks: {links}\njoints: {{j: {{type: fixed, parent: base_link, child: b}}}}\n"
    home = folder / "descriptions" / "r"
    home.mkdir(parents=True)
    (home / name).write_bytes(data)
    (home / "robot.yaml").write_text(f"{text}outputs: {{urdf: {{file: r.urdf}}, mjcf: {{file: r.xml}}}}\n", "utf-8")
    assert main(["all"]) == 0
    mujoco.MjModel.from_xml_path(str(folder / "outputs" / "r" / "r.xml"))


@pytest.mark.parametrize("purpose", ["visual", "collision"])
@pytest.mark.parametrize("name", [*SOUND, *BROKEN])
def test_mujoco_loads_what_is_written_and_what_is_left_out_is_told(name, purpose, tmp_path, monkeypatch, capsys):
    if name.endswith((".dae", ".gltf", ".glb")):
        pytest.importorskip("trimesh")
    monkeypatch.chdir(tmp_path)
    compiled(tmp_path, name, {**SOUND, **BROKEN}[name], purpose)
    said = capsys.readouterr().err
    assert ("warning[mesh-not-read]" in said) == (name in BROKEN), said


@pytest.mark.parametrize("points", ["v 0 1 0\nv 1 1 0\n", "v 0 1 0.3\nv 1 1 0.3\n"])
def test_a_flat_mesh_is_reported_where_it_collides(points, tmp_path, monkeypatch, capsys):
    data = f"v 0 0 0\nv 1 0 0\n{points}f 1 2 3\nf 2 3 4\n".encode()
    for purpose in ("visual", "collision"):
        (tmp_path / purpose).mkdir()
    monkeypatch.chdir(tmp_path / "visual")
    compiled(tmp_path / "visual", "flat.obj", data, "visual")
    assert "mesh-not-read" not in capsys.readouterr().err
    monkeypatch.chdir(tmp_path / "collision")
    compiled(tmp_path / "collision", "flat.obj", data, "collision")
    reported = capsys.readouterr().err
    assert "warning[mesh-not-read]: mesh flat.obj is left out of the MJCF: all its points are in one plane" in reported


def test_a_pointer_is_told_with_the_way_out(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    compiled(tmp_path, "m.obj", POINTER, "visual")
    said = capsys.readouterr().err
    assert "left out of the MJCF: it is a pointer of Git LFS, not the file itself" in said
    assert "fetch the file: git lfs pull" in said


def test_what_mujoco_takes_is_sound_at_each_bound():
    bound = 2.0**30
    check_for_mujoco(stl((bound, 0, 0, 1, 0, 0, 0, 1, 0)), ".stl")
    check_for_mujoco(stl((-bound, 0, 0, 1, 0, 0, 0, 1, 0)), ".stl")
    for beyond in (bound * 1.001, -bound * 1.001):
        with pytest.raises(UnreadableMesh, match="a coordinate of a vertex is"):
            check_for_mujoco(stl((beyond, 0, 0, 1, 0, 0, 0, 1, 0)), ".stl")

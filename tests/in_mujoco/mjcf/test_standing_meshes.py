"""A free robot of meshes stands on the floor in MuJoCo: its lowest vertex is at z = 0, in every key."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

mujoco = pytest.importorskip("mujoco", minversion="4")

import numpy as np  # noqa: E402

from rosorin_compile.cli.main import main  # noqa: E402
from rosorin_compile.model.mesh_vertices import UnreadableMesh, read_vertices  # noqa: E402

# A foot that is lowest at a corner, whatever way it is turned; in millimetres.
CORNERS = ((-30.0, -20.0, 0.0), (60.0, -10.0, 5.0), (10.0, 40.0, 2.5), (5.0, 0.0, 90.0), (40.0, 30.0, -7.0))
FACES = ((0, 1, 4), (0, 4, 2), (0, 2, 3), (0, 3, 1), (1, 3, 4), (2, 4, 3))
ROBOT = """\
robot: walker
links:
  base:
    inertial: {{mass: 2, of: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]}}
    collision: [{{mesh: {{file: "{file}", scale: [0.002, 0.002, 0.002]}}, xyz: [0, 0, 0.3], rpy: [0.4, -0.3, 0.2]}}]
  foot:
    inertial: {{mass: 0.2, of: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]}}
    collision: [{{mesh: {{file: "{file}", scale: [0.001, -0.001, 0.0015]}}, xyz: [0.02, 0, -0.2], rpy: [0.5, 2.8, -1]}}]
joints:
  knee: {{type: revolute, parent: base, child: foot, axis: [0, 1, 0],
    limit: {{lower: -2, upper: 2, effort: 9, velocity: 1}}}}
poses:
  home: {{positions: {{knee: 0.3}}}}
  up: {{positions: {{knee: 1.9}}}}
outputs:
  mjcf: {{file: mjcf/walker.xml, base: free}}
  scene: {{file: mjcf/scene.xml}}
"""


def stl() -> bytes:
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in CORNERS[i]), 0) for face in FACES)
    return bytes(80) + struct.pack("<I", len(FACES)) + triangles


def letters() -> bytes:
    lines = ["solid foot"]
    for face in FACES:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {' '.join(map(str, CORNERS[i]))}" for i in face)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid foot", ""]).encode()


def obj() -> bytes:
    """Return an OBJ with a vertex that no face has, which MuJoCo's hull has all the same."""
    lines = ["v 0 0 -90 1.0", *(f"v {x} {y} {z}" for x, y, z in CORNERS), "vn 0 0 1"]
    lines += ["f " + " ".join(f"{i + 2}//1" for i in FACES[0])]
    lines += ["f " + " ".join(f"{i - len(CORNERS)}//1" for i in face) for face in FACES[1:]]
    return ("\n".join(lines) + "\n").encode()


def lowest(scene: Path, key: str) -> float:
    """Return how high the lowest vertex is that collides, in a key (m)."""
    model = mujoco.MjModel.from_xml_path(str(scene))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    mujoco.mj_forward(model, data)
    heights = []
    for geom in np.flatnonzero((model.geom_type == mujoco.mjtGeom.mjGEOM_MESH) & (model.geom_contype > 0)):
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        turned = model.mesh_vert[first : first + count] @ data.geom_xmat[geom].reshape(3, 3).T
        heights.append((turned + data.geom_xpos[geom])[:, 2].min())
    return float(min(heights))


@pytest.mark.parametrize(("file", "data"), [("foot.stl", stl()), ("foot.obj", obj()), ("letters/foot.stl", letters())])
@pytest.mark.parametrize("by", ["", "package://feet/"])
def test_the_lowest_vertex_is_on_the_floor(home: Path, file: str, data: bytes, by: str) -> None:
    if data == letters() and not by:
        pytest.skip("MuJoCo reads no STL of letters: it is converted on its way from a package alone")
    folder = home / "descriptions" / "walker"
    (folder / file).parent.mkdir(parents=True)
    (folder / file).write_bytes(data)
    (folder / "robot.yaml").write_text(ROBOT.format(file=by + file), "utf-8")
    (folder / "package.xml").write_text("<package><name>feet</name></package>")
    assert main(["all", *(["--package", f"feet={folder}"] if by else [])]) == 0
    scene = home / "outputs" / "walker" / "mjcf" / "scene.xml"
    for key in ("home", "up"):
        assert lowest(scene, key) == pytest.approx(0.0, abs=1e-6)
    assert main(["check", *(["--package", f"feet={folder}"] if by else [])]) == 0


def test_a_mesh_that_is_left_out_carries_nothing(home: Path) -> None:
    folder = home / "descriptions" / "walker"
    folder.mkdir(parents=True)
    (folder / "foot.stl").write_bytes(stl())
    old, new = (f'file: "{name}", scale: [0.001' for name in ("foot.stl", "package://away/a.stl"))
    text = ROBOT.format(file="foot.stl").replace(old, new)
    (folder / "robot.yaml").write_text(text, "utf-8")
    assert main(["all"]) == 0
    scene = home / "outputs" / "walker" / "mjcf" / "scene.xml"
    assert mujoco.MjModel.from_xml_path(str(scene)).nmesh == 1
    assert lowest(scene, "home") == pytest.approx(0.0, abs=1e-6)


def test_primitives_below_meshes_carry_the_robot(home: Path) -> None:
    folder = home / "descriptions" / "walker"
    folder.mkdir(parents=True)
    (folder / "foot.stl").write_bytes(stl())
    ball = "{sphere: {radius: 0.05}, xyz: [0, 0, -0.6]}, "
    (folder / "robot.yaml").write_text(ROBOT.format(file="foot.stl").replace("collision: [", f"collision: [{ball}", 1))
    assert main(["all"]) == 0
    model = mujoco.MjModel.from_xml_path(str(home / "outputs" / "walker" / "mjcf" / "scene.xml"))
    assert model.key("home").qpos[2] == pytest.approx(0.65)


def test_the_picture_of_a_robot_of_meshes_is_as_large_as_the_robot(home: Path) -> None:
    folder = home / "descriptions" / "walker"
    folder.mkdir(parents=True)
    (folder / "foot.stl").write_bytes(stl())
    (folder / "robot.yaml").write_text(ROBOT.format(file="foot.stl"), "utf-8")
    assert main(["all"]) == 0
    text = (home / "outputs" / "walker" / "mjcf" / "scene.xml").read_text("utf-8")
    assert "<statistic" in text
    model = mujoco.MjModel.from_xml_string(text.replace('<include file="walker.xml"/>', ""))
    assert 0.4 < model.stat.extent < 0.9


@pytest.mark.parametrize(
    ("data", "ending"),
    [
        (stl()[:-1], ".stl"),
        (b"", ".stl"),
        (letters()[:-60], ".stl"),
        (b"v 1 2\nf 1 1 1\n", ".obj"),
        (b"v 0 0 x\nf 1 2 3\n", ".obj"),
        (b"f 1 2 3\n", ".obj"),
        (b"ply", ".ply"),
    ],
)
def test_what_is_damaged_has_no_vertices(data: bytes, ending: str) -> None:
    with pytest.raises(UnreadableMesh):
        read_vertices(data, ending)


def test_every_vertex_is_read() -> None:
    for data, ending in ((stl(), ".stl"), (letters(), ".stl"), (obj(), ".obj")):
        stray = [(0.0, 0.0, -90.0)] if ending == ".obj" else []
        numbers = read_vertices(data, ending)
        assert set(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True)) == {*CORNERS, *stray}

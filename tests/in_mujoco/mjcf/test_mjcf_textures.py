"""Textures in MuJoCo: the images of visuals and materials are carried, each pixel of them; what is not is told."""

from pathlib import Path

import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

import struct  # noqa: E402

import numpy as np  # noqa: E402

from rosorin_compile.cli.main import main  # noqa: E402
from support.images import png  # noqa: E402
from support.paths import data_text  # noqa: E402

Said = pytest.CaptureFixture[str]
ROBOT = data_text("robots/mjcf_textures.yaml")


@pytest.fixture
def folder(home: Path) -> Path:
    made = home / "descriptions" / "box"
    (made / "images").mkdir(parents=True)
    (made / "images" / "wood.png").write_bytes(png(10))
    (made / "wood.png").write_bytes(png(200))
    (made / "package.xml").write_text("<package><name>house</name></package>")
    return made


def described(folder: Path, texture: str = "images/wood.png", other: str = "wood.png") -> None:
    (folder / "robot.yaml").write_text(ROBOT.replace("TEXTURE", texture).replace("OTHER", other), "utf-8")


def loaded(home: Path) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(home / "outputs" / "box" / "mjcf" / "scene.xml"))


def look_of(model: mujoco.MjModel, geom: str) -> tuple[int, list[float]]:
    """Return the blue of the texture of a geom, -1 without one, and the colour that it is tinted with."""
    material = int(model.geom(geom).matid[0])
    rgba = (model.geom(geom).rgba if material < 0 else model.mat_rgba[material]).tolist()
    rgba = model.geom(geom).rgba.tolist() if geom == "other" else rgba
    texture = int(model.mat_texid[material][mujoco.mjtTextureRole.mjTEXROLE_RGB]) if material >= 0 else -1
    if texture < 0:
        return -1, rgba
    start, count = model.tex_adr[texture], model.tex_width[texture] * model.tex_height[texture] * 3
    pixels = model.tex_data[start : start + count].reshape(model.tex_height[texture], model.tex_width[texture], 3)
    assert (np.sort(np.unique(pixels[:, :, 0])) == [0, 60, 120, 180]).all()
    assert model.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_2D
    return int(pixels[0, 0, 2]), rgba


@pytest.mark.parametrize("by", ["images/wood.png", "package://house/images/wood.png"])
def test_each_visual_has_its_image(home: Path, folder: Path, by: str) -> None:
    described(folder, by)
    assert main(["all", "--package", f"house={folder}"]) == 0
    model = loaded(home)
    looks = {name: look_of(model, name) for name in ("plank", "dyed", "own", "other", "plain")}
    white = [1.0, 1.0, 1.0, 1.0]
    assert looks == {
        "plank": (10, white),
        "dyed": (10, [0.5, 1, 1, 1]),
        "own": (10, white),
        "other": (200, [0.5, 0.5, 0.5, 1]),
        "plain": (-1, [1, 0, 0, 1]),
    }
    assert sum(model.tex_type == mujoco.mjtTexture.mjTEXTURE_2D) == 3  # one a file, and the floor
    assert main(["check", "--package", f"house={folder}"]) == 0


def test_what_mujoco_does_not_open_is_told(home: Path, folder: Path, capsys: Said) -> None:
    (folder / "wood.jpg").write_bytes(b"\xff\xd8\xff")
    described(folder, "wood.jpg", "wood.jpg")
    assert main(["all", "--notes"]) == 0
    said = capsys.readouterr().err
    assert "note[mjcf-cannot-say]: left out of the MJCF: wood.jpg; MuJoCo opens" in said
    assert look_of(loaded(home), "plank")[0] == -1
    assert look_of(loaded(home), "dyed") == (-1, [0.5, 1, 1, 1])


def test_what_is_not_found_is_told_and_left_out(home: Path, folder: Path, capsys: Said) -> None:
    described(folder, "gone.png", "package://away/gone.png")
    assert main(["all"]) == 0
    said = capsys.readouterr().err
    line = "3:19: warning[mesh-not-found]: texture gone.png is not there, neither as seen from the artifacts nor "
    assert f"{line}next to the description, and left out of mjcf/box.xml\n" in said
    assert "texture package://away/gone.png is not found: there is no package away here, and left out of " in said
    assert look_of(loaded(home), "plank")[0] == -1


@pytest.mark.parametrize("data", [b"", b"\xff\xd8\xff", png(0)[:-4], png(0)[:60]])
def test_what_is_no_image_is_told_and_left_out(home: Path, folder: Path, capsys: Said, data: bytes) -> None:
    (folder / "wood.png").write_bytes(data)
    described(folder)
    assert main(["all"]) == 0
    assert "warning[mesh-not-read]: texture wood.png is left out of the MJCF: " in capsys.readouterr().err
    assert look_of(loaded(home), "other")[0] == -1
    assert look_of(loaded(home), "plank")[0] == 10


def test_an_imported_mjcf_keeps_its_images(home: Path, capsys: Said) -> None:
    """An image as it is becomes a word; what MuJoCo wraps around a cube stays an element, and its material has it."""
    source = home / "source"
    (source / "pictures").mkdir(parents=True)
    (source / "pictures" / "wood.png").write_bytes(png(10))
    (source / "box.xml").write_text(data_text("robots/mjcf_textures_box.mjcf.xml"))
    assert main(["import", "source/box.xml", "-o", "descriptions/box", "--meshes", "../../source"]) == 0
    assert (
        "MuJoCo's model of the MJCF is that of the source, in every field but its appearance" in capsys.readouterr().out
    )
    assert main(["all"]) == 0
    made = next((home / "outputs").rglob("box.xml"))
    old, new = (mujoco.MjModel.from_xml_path(str(path)) for path in (source / "box.xml", made))
    assert sorted(old.tex_type) == sorted(new.tex_type)
    for name in ("plank", "crate", "dyed"):
        theirs, ours = (model.geom(name) for model in (old, new))
        assert ours.rgba.tolist() == pytest.approx(theirs.rgba.tolist())
        assert new.mat_rgba[ours.matid[0]].tolist() == pytest.approx(old.mat_rgba[theirs.matid[0]].tolist())
        assert new.mat_texrepeat[ours.matid[0]].tolist() == old.mat_texrepeat[theirs.matid[0]].tolist()
        textures = [model.mat_texid[one.matid[0]][1] for model, one in ((old, theirs), (new, ours))]
        assert old.tex_type[textures[0]] == new.tex_type[textures[1]]


# A free robot of meshes stands on the floor in MuJoCo: its lowest vertex is at z = 0, in every key.


# A foot that is lowest at a corner, whatever way it is turned; in millimetres.
CORNERS = ((-30.0, -20.0, 0.0), (60.0, -10.0, 5.0), (10.0, 40.0, 2.5), (5.0, 0.0, 90.0), (40.0, 30.0, -7.0))
FACES = ((0, 1, 4), (0, 4, 2), (0, 2, 3), (0, 3, 1), (1, 3, 4), (2, 4, 3))
ROBOT_MESHES = """\
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
    lines = ["v 0 0 -90 1.0", *(f"v {x} {y} {z}" for x, y, z in CORNERS), "vn 0 0 1"]
    lines += ["f " + " ".join(f"{i + 2}//1" for i in FACES[0])]
    lines += ["f " + " ".join(f"{i - len(CORNERS)}//1" for i in face) for face in FACES[1:]]
    return ("\n".join(lines) + "\n").encode()


def lowest(scene: Path, key: str) -> float:
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
    (folder / "robot.yaml").write_text(ROBOT_MESHES.format(file=by + file), "utf-8")
    (folder / "package.xml").write_text("<package><name>feet</name></package>")
    assert main(["all", *(["--package", f"feet={folder}"] if by else [])]) == 0
    scene = home / "outputs" / "walker" / "mjcf" / "scene.xml"
    for key in ("home", "up"):
        assert lowest(scene, key) == pytest.approx(0.0, abs=1e-6)
    assert main(["check", *(["--package", f"feet={folder}"] if by else [])]) == 0

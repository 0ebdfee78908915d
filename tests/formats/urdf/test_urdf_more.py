"""What only a URDF has: materials, textures, names of shapes, kept elements, calibration, capsules; any names."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.source.xml.elements import damage, indent_lines
from support.images import png
from support.paths import DATA
from support.robots import compiled_text, sound

mujoco = pytest.importorskip("mujoco", minversion="3.12")

OUTPUTS = "outputs: {urdf: {file: a.urdf}, mjcf: {file: a.xml}, frames: {file: a.md}, static_tf: {file: a.launch.py}}\n"
ROBOT = (DATA / "robots/urdf_more.yaml").read_text("utf-8")


def test_the_urdf_word_for_word(tmp_path):
    _, artifacts, _ = sound(compiled_text(tmp_path, ROBOT + OUTPUTS))
    assert artifacts["urdf"].splitlines()[2:] == GOLDEN.splitlines()


GOLDEN = (DATA / "robots/urdf_more.urdf").read_text("utf-8")


def test_mujoco_has_the_colours_and_the_names(tmp_path):
    _, artifacts, _ = sound(compiled_text(tmp_path, ROBOT + OUTPUTS))
    images = {"meshes/carrier/wood.png": png(1), "a.png": png(2)}
    model = mujoco.MjModel.from_xml_string(artifacts["mjcf"], images)
    geoms = [model.geom(name) for name in ("top", *(f"base link_visual_{n}" for n in range(2, 6)))]
    colours = [(model.mat_rgba[g.matid[0]] if g.matid[0] >= 0 else g.rgba).tolist() for g in geoms]
    grey, white, green = [pytest.approx(c, abs=1e-6) for c in ([0.7, 0.7, 0.7, 1], [1, 1, 1, 1], [0, 1, 0, 1])]
    assert colours == [grey, white, white, green, green]
    assert geoms[2].rgba.tolist() == [1, 0, 0, 1]
    textures = [int(model.mat_texid[geom.matid[0]][mujoco.mjtTextureRole.mjTEXROLE_RGB]) for geom in geoms[1:3]]
    assert [model.tex_data[model.tex_adr[texture] + 2] for texture in textures] == [1, 2]
    assert model.joint("joint 1/a").range == pytest.approx([-0.17453292519943295, 1])
    assert model.site("ns/arm").bodyid == model.body("ns/arm").id
    assert model.key("at rest").qpos == pytest.approx([0.3])


def test_yourdfpy_has_the_materials(tmp_path):
    text = ROBOT.replace("<controller:x", "<controller")  # lxml knows no prefix that nothing declares
    _, artifacts, _ = sound(compiled_text(tmp_path, text + OUTPUTS))
    (tmp_path / "a.urdf").write_text(artifacts["urdf"])
    read = yourdfpy.URDF.load(tmp_path / "a.urdf", load_meshes=False, build_scene_graph=False)
    found = {material.name: material for material in read.robot.materials}
    assert found["Light Grey"].color.rgba.tolist() == [0.7, 0.7, 0.7, 1]
    assert found["wood"].texture.filename == "package://carrier/wood.png"
    link = read.link_map["base link"]
    assert [v.name for v in link.visuals] == ["top", None, None, None, None]
    assert link.collisions[0].name == "c 1"
    joint = read.joint_map["joint 1/a"]
    assert (joint.calibration.rising, joint.safety_controller.k_position) == (pytest.approx(0.17453293), 15)


# --- texts of elements


_TEXTS = st.text("ab \n<&'\"", max_size=6)


@st.composite
def _elements(draw, depth=2):
    inner = draw(st.lists(_TEXTS if depth == 0 else st.one_of(_TEXTS, _elements(depth - 1)), max_size=3))
    element = ET.Element(draw(st.sampled_from("abc")), {"k": draw(_TEXTS)})
    for part in inner:
        if isinstance(part, str):
            if len(element):
                element[-1].tail = part
            else:
                element.text = part
        else:
            element.append(part)
    return element


@settings(max_examples=200, deadline=None)
@given(_elements())
def test_indentation_changes_no_meaning(element):
    """Text and attributes stay as they were, but for space that stands between elements alone."""
    element.tail = None
    text = ET.tostring(element, encoding="unicode")
    assert damage(text) == ""
    again = ET.fromstring(indent_lines(text, "    "))
    for one, other in zip(element.iter(), again.iter(), strict=True):
        assert (one.tag, one.attrib) == (other.tag, other.attrib) or "\n" in str(one.attrib)
        for a, b in ((one.text, other.text), (one.tail, other.tail)):
            assert (a or "") == (b or "") or not ((a or "").strip() or (b or "").strip())

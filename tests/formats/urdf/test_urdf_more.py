"""What only a URDF has: materials, textures, names of shapes, kept elements, calibration, capsules; any names."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
import yourdfpy
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.output.committed import compare, lines
from rosorin_compile.source.xml.elements import damage, indented
from support.images import png
from support.paths import DATA
from support.reading import leaves_of
from support.robots import compiled_text, sound

mujoco = pytest.importorskip("mujoco", minversion="4")

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


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("rgba: [0.7,", "rgba: [0.6,", "material Light Grey colour 0.6 0.7 0.7 1 -> 0.7 0.7 0.7 1 (and therefore the"),
        (
            '{texture: "package://carrier/wood.png"}',
            "{texture: b.png}",
            "material wood texture b.png -> package://carrier",
        ),
        ("  empty: {}\n", "", "new: material empty"),
        ("name: top", "name: lid", "base link visual: box name lid -> top: urdf"),
        ("rising: 10 deg", "rising: 0.2", "joint 1/a calibration rising 0.2 -> 0.174533 rad"),
        ("k_velocity: 10", "k_velocity: 11", "joint 1/a safety k velocity 11 -> 10 N*m*s/rad"),
        ("<mu1>0.2</mu1>", "<mu1>0.3</mu1>", "robot element mu1 0.3 -> 0.2"),
        ('<controller:x a="1"/>', '<controller:x a="2"/>', "base link element controller:x a 2 -> 1"),
        ("[<x/>]", "[]", "joint 1/a element x: new"),
    ],
)
def test_check_compares_them_by_meaning(tmp_path, old, new, told):
    robot, _, made = sound(compiled_text(tmp_path, ROBOT + OUTPUTS))
    assert ROBOT.count(old) >= 1
    _, _, other = sound(compiled_text(tmp_path, ROBOT.replace(old, new) + OUTPUTS))
    committed = {artifact.file: artifact.text.encode() for artifact in other.artifacts}
    said = lines(compare(robot, made.artifacts, committed))
    assert told in said[0], said[0]


def test_white_space_in_kept_elements_is_no_change_of_meaning(tmp_path):
    robot, _, made = sound(compiled_text(tmp_path, ROBOT + OUTPUTS))
    committed = {a.file: a.text.replace("<type>a/B</type>", "<type> a/B </type>").encode() for a in made.artifacts}
    comparison = compare(robot, made.artifacts, committed)
    assert comparison.changes == ()


@pytest.mark.parametrize("version", ["1.2", '"1.2"'])
def test_a_capsule_in_urdf_1_2(tmp_path, version):
    _, artifacts, made = sound(
        compiled_text(tmp_path, f"{ROBOT}outputs: {{urdf: {{file: a.urdf, version: {version}}}}}\n")
    )
    assert '<robot name="carrier" version="1.2">' in artifacts["urdf"]
    assert '<geometry><capsule radius="0.1" length="0.5"/></geometry>' in artifacts["urdf"]
    assert not [d for d in made.diagnostics if d.rule == "urdf-cannot-say"]
    assert leaves_of("urdf", artifacts["urdf"])["link", "base link", "collision"].solids()[0].sizes == (0.1, 0.5)


def test_elements_of_links_that_are_not_carried_are_named(tmp_path):
    text = """
robot: a
publishers: {node: {}}
links: {base: {}, arm: {}, hand: {urdf_elements: [<x/>]}}
joints:
  shoulder: {type: fixed, parent: base, child: arm}
  wrist: {type: fixed, parent: arm, child: hand, publisher: node, urdf_elements: [<y/>]}
outputs: {urdf: {file: a.urdf}}
"""
    _, artifacts, made = sound(compiled_text(tmp_path, text))
    assert "<x/>" not in artifacts["urdf"]
    assert [d.message for d in made.diagnostics] == [
        "not in the URDF, because robot_state_publisher does not publish them:"
        " hand (urdf_elements), wrist (urdf_elements)"
    ]


def test_materials_of_included_files_are_joined(tmp_path):
    (tmp_path / "more.yaml").write_text(
        "materials: {red: {rgba: [1, 0, 0, 1]}}\nurdf_elements: [<b/>]\naccept: []\n", "utf-8"
    )
    text = """
robot: a
include: [more.yaml]
materials: {blue: {rgba: [0, 0, 1, 1]}}
links: {base: {}}
urdf_elements: [<a/>]
outputs: {urdf: {file: a.urdf}}
"""
    robot, _, _ = sound(compiled_text(tmp_path, text))
    assert [material.name for material in robot.materials] == ["blue", "red"]
    assert robot.urdf_elements == ("<b/>", "<a/>")


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
    again = ET.fromstring(indented(text, "    "))
    for one, other in zip(element.iter(), again.iter(), strict=True):
        assert (one.tag, one.attrib) == (other.tag, other.attrib) or "\n" in str(one.attrib)
        for a, b in ((one.text, other.text), (one.tail, other.tail)):
            assert (a or "") == (b or "") or not ((a or "").strip() or (b or "").strip())

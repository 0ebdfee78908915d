"""Words for simulation: MuJoCo has what they describe, and parts rename them."""

import mujoco
import pytest

from rosorin_compile.source.diagnostics import text as report
from support.paths import DATA, data_text
from support.robots import compiled_text

HOPPER = (DATA / "robots/hopper.yaml").read_text("utf-8")


def mjcf(folder, text):
    made = compiled_text(folder, text)
    assert made.artifacts, report(made.diagnostics)
    return next(artifact.text for artifact in made.artifacts if artifact.backend == "mjcf")


@pytest.fixture(name="model")
def hopper(tmp_path):
    return mujoco.MjModel.from_xml_string(mjcf(tmp_path, HOPPER))


def names(model, kind, count):
    return [mujoco.mj_id2name(model, kind, index) for index in range(count)]


def test_mujoco_has_what_the_words_say(model):
    assert names(model, mujoco.mjtObj.mjOBJ_ACTUATOR, model.nu) == ["left_hip", "right_hip", "swing"]
    hip, swing = model.actuator("left_hip"), model.actuator("swing")
    assert hip.gainprm[0] == 30
    assert hip.ctrlrange == pytest.approx([-1.0471975511965976, 1.0471975511965976])
    assert swing.gear[0] == 2
    assert swing.ctrlrange == pytest.approx([-1, 1])
    joint = model.joint("left_hip")
    assert (joint.damping[0], joint.stiffness[0]) == (0.1, 2)
    assert model.qpos_spring[joint.qposadr[0]] == pytest.approx(0.17453292519943295)
    assert model.jnt_actfrcrange[joint.id] == pytest.approx([-5, 5])
    box, foot = model.geom("body_collision_1"), model.geom("left_thigh_collision_1")
    assert box.friction[:2] == pytest.approx([0.8, 0.01])
    assert (box.contype[0], box.conaffinity[0]) == (2, 1)
    assert (foot.contype[0], foot.conaffinity[0], foot.condim[0]) == (4, 5, 4)
    assert model.camera("eye").fovy[0] == 60
    assert model.tendon_range[model.tendon("both").id] == pytest.approx([-1, 1])
    assert model.key("home").ctrl == pytest.approx([0.2, 0.2, 0.1])
    assert model.key("home").qpos[:3] == pytest.approx([0, 0, 0.3])
    assert model.dof_damping[:6] == pytest.approx([0.01] * 6)


def test_names_in_elements_follow_the_prefix_of_the_part(model):
    sites = names(model, mujoco.mjtObj.mjOBJ_SITE, model.nsite)
    assert {"left_knee", "right_knee", "left_foot", "right_foot"} <= set(sites)
    assert model.site("right_knee").rgba == pytest.approx([1, 0, 0, 1])
    assert names(model, mujoco.mjtObj.mjOBJ_SENSOR, model.nsensor)[:2] == ["left_touch", "right_touch"]


PART = data_text("robots/simulation_words_part.yaml")


def test_every_attribute_that_names_something_gets_the_prefix(tmp_path):
    text = mjcf(tmp_path, PART)
    for prefix, mount in (("a_", "base"), ("b.", "a_thigh")):
        assert f'<exclude name="{prefix}apart" body1="{mount}" body2="{prefix}thigh"/>' in text
        assert (
            f'<framepos name="{prefix}where" objtype="geom" objname="{prefix}pad" reftype="body" refname="base"/>'
            in text
        )
        assert f'<text name="{prefix}note" data="thigh pad"/>' in text
        assert f'<geom name="{prefix}pad" size="0.1"/>' in text


def test_shapes_are_found_by_their_place_and_by_their_name(tmp_path):
    text = data_text("robots/simulation_words_shapes.yaml")
    model = mujoco.MjModel.from_xml_string(mjcf(tmp_path, text))
    assert model.geom("plate").id in (int(model.pair_geom1[0]), int(model.pair_geom2[0]))


def test_a_light_shines_where_its_pose_turns_it(tmp_path):
    text = """robot: r
links: {base: {lights: {lamp: {rpy: [0, 90 deg, 0]}, back: {rpy: [0, 90 deg, 0], dir: [1, 0, 0]}}}}
outputs: {mjcf: {file: r.xml}}
"""
    model = mujoco.MjModel.from_xml_string(mjcf(tmp_path, text))
    assert model.light("lamp").dir == pytest.approx([-1, 0, 0], abs=1e-12)
    assert model.light("back").dir == pytest.approx([0, 0, -1], abs=1e-12)


def test_keys_count_the_controls_of_every_actuator(tmp_path):
    text = HOPPER.replace("actuators:\n", "actuators:\n  pid: {joint: left_hip, type: pid, kp: 1}\n")
    text = text.replace("\nmjcf:\n", '\nmjcf:\n  - <actuator><motor joint="left_hip"/></actuator>\n', 1)
    model = mujoco.MjModel.from_xml_string(mjcf(tmp_path, text))
    assert model.nu == 6
    assert model.key("home").ctrl == pytest.approx([0.2, 0.2, 0, 0, 0.1, 0])


REFERRED = data_text("robots/simulation_words_referred.yaml")


@pytest.mark.parametrize("polynomial", [(), (0.1, -2.0), (0.1, 0.5, -0.3, 0.2, 0.1)])
def test_a_polynomial_of_joints_counts_from_zero_whatever_their_references_are(tmp_path, polynomial):
    said = f", polynomial: {list(polynomial)}" if polynomial else ""
    model = mujoco.MjModel.from_xml_string(mjcf(tmp_path, REFERRED.replace("POLYNOMIAL", said)))
    data = mujoco.MjData(model)
    for lead in (-0.9, 0.0, 0.4):
        turn = sum(factor * lead**power for power, factor in enumerate(polynomial or (0.0, 1.0)))
        data.joint("lead").qpos, data.joint("turn").qpos, data.joint("hold").qpos = lead, turn, 0.7
        mujoco.mj_forward(model, data)
        held = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
        assert held == pytest.approx([0, 0], abs=1e-9)

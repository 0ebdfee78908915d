"""A fact of a description reaches each format that has a word for it; engines judge the result."""

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from support import sdformat
from support.paths import data_text

mujoco = pytest.importorskip("mujoco")

MASS = "inertial: {mass: 1, inertia: {ixx: 0.01, iyy: 0.01, izz: 0.01}}"
ARM = f"""robot: r
links: {{base_link: {{{MASS}}}, head: {{{MASS}, collision: [COLLISION]}}}}
joints:
  pan: {{type: revolute, parent: base_link, child: head, axis: [0, 0, 1], limit: LIMIT, dynamics: SPRING}}
"""
TURNING = ARM.replace("LIMIT", "{lower: -1, upper: 1, effort: 1, velocity: 1}")
TURNING = TURNING.replace("SPRING", "{stiffness: 20, spring_reference: 0.1}")
TURNING = TURNING.replace("COLLISION", "{sphere: {radius: 0.1}, contact: {friction: [0.3]}}")
OUTPUTS = "outputs: {urdf: {file: r.urdf, gazebo: harmonic}, sdf: {file: r.sdf}, mjcf: {file: r.xml}}\n"


def made(folder: Path, text: str, **others: str) -> Path:
    """Compile a description; return the folder of its artifacts."""
    for name, content in {"robot.yaml": text, **{name.replace("_", "."): one for name, one in others.items()}}.items():
        (folder / name).write_text(content, "utf-8")
    assert main(["all", str(folder / "robot.yaml"), "-o", str(folder / "out")]) == 0
    return folder / "out"


def model_of(out: Path) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(out / "r.xml"))


def test_springs_and_friction_reach_gazebo(tmp_path: Path) -> None:
    sdformat.need()
    out = made(tmp_path, TURNING + OUTPUTS)
    by_urdf, _ = sdformat.as_sdf((out / "r.urdf").read_text("utf-8"), tmp_path)
    for model in (by_urdf, ET.parse(out / "r.sdf").getroot().find("model")):
        assert model is not None
        numbers = {tag: float(model.findtext(f".//{tag}", "nan")) for tag in ("spring_stiffness", "spring_reference")}
        assert numbers == {"spring_stiffness": 20, "spring_reference": 0.1}
        assert {float(one.text or "nan") for tag in ("mu", "mu2") for one in model.iter(tag)} == {0.3}


def test_one_friction_a_link_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    two = "{sphere: {radius: 0.1}, contact: {friction: [0.3]}}, {box: {size: [0.1, 0.1, 0.1]}}"
    out = made(tmp_path, TURNING.replace("{sphere: {radius: 0.1}, contact: {friction: [0.3]}}", two) + OUTPUTS)
    assert "<mu1>0.3</mu1>" in (out / "r.urdf").read_text("utf-8")
    assert 'warning[urdf-cannot-say]: shapes of "head" differ in friction' in capsys.readouterr().err


SENSORS = """sensors:
  imu: {type: imu, frame: head, gazebo: {xyz: [0.3, 0, 0], rpy: [0, 0, 90 deg]}}
  gps: {type: gnss, frame: head, gazebo: {xyz: [0, 0, 2]}}
  cam: {type: camera, frame: head, optical: false, gazebo: {elements: {camera: {pose: 0.1 0 0 0 0 0}}}}
  lid: {type: lidar_2d, frame: head, with: {rays: 4}, gazebo: {xyz: [0, 0, 0.5]}}
  own: {type: imu, frame: head, gazebo: {xyz: [0.3, 0, 0]}, mjcf: [{sensor: gyro, name: gyro}]}
"""


def test_sensors_sit_in_mujoco_where_they_sit_in_gazebo(tmp_path: Path) -> None:
    model = model_of(made(tmp_path, TURNING + SENSORS + OUTPUTS))
    data = mujoco.MjData(model)
    data.qvel[0] = 2
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensor("gps").data, (0, 0, 2), atol=1e-9)
    assert data.sensor("imu_accelerometer").data[1] == pytest.approx(1.2)  # 0.3 m off the axis at 2 rad/s
    np.testing.assert_allclose(model.cam("cam").pos, (0.1, 0, 0), atol=1e-9)
    looks = data.cam("cam").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(-looks, (1, 0, 0), atol=1e-9)
    np.testing.assert_allclose(data.site("lid_site_0").xpos, (0, 0, 0.5), atol=1e-9)
    assert model.sensor("own_gyro").objid[0] == model.site("head").id


@pytest.mark.parametrize(
    ("shapes", "x", "top"),
    [
        ("{box: {size: [0.2, 0.2, 0.04]}, xyz: [0.5, 0, -0.3]}", 0.5, -0.28),
        ("{sphere: {radius: 0.1}}, {box: {size: [0.2, 0.2, 0.2]}, xyz: [1, 0, 0]}", 1.0, 0.1),
    ],
)
def test_a_contact_sensor_responds_to_each_shape_of_its_link(tmp_path: Path, shapes: str, x: float, top: float) -> None:
    text = f"robot: r\nlinks: {{base_link: {{{MASS}, collision: [{shapes}]}}}}\n"
    text += "sensors: {bump: {type: contact, frame: base_link}}\noutputs: {mjcf: {file: r.xml, base: fixed}}\n"
    mjcf = (made(tmp_path, text) / "r.xml").read_text("utf-8")
    block = f'<body pos="{x} 0 {top + 0.02}"><freejoint/><geom type="box" size="0.02 0.02 0.02" mass="1"/></body>'
    model = mujoco.MjModel.from_xml_string(mjcf.replace("<worldbody>", f"<worldbody>{block}", 1))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    assert data.sensor("bump").data[0] == pytest.approx(9.81, rel=0.02)


PART = data_text("robots/facts_reach_formats_part.yaml")


def test_a_mirror_turns_height_maps_and_lights(tmp_path: Path) -> None:
    model = model_of(made(tmp_path, PART))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    boxes = {
        side: sorted(
            (*np.round(data.geom_xpos[i], 6), *np.round(model.geom_size[i], 6))
            for i in range(model.ngeom)
            if model.body(model.geom_bodyid[i]).name == f"{side}_w" and model.geom_contype[i]
        )
        for side in ("left", "right")
    }
    assert boxes["left"] == sorted((x, -y, *rest) for x, y, *rest in boxes["right"])
    np.testing.assert_allclose(model.light("right_lamp").dir * (1, -1, 1), model.light("left_lamp").dir)


DOG = """<mujoco model="dog"><compiler angle="radian"/><option timestep="0.001" integrator="RK4"/><worldbody>
<body name="trunk" pos="0 0 .4"><freejoint name="root"/><geom type="box" size=".2 .1 .05"/>
<body name="hip" pos=".1 0 0">
<joint name="hip" axis="0 1 0" range="-1 1"/><geom type="sphere" size=".05"/></body></body>
</worldbody></mujoco>"""


def test_the_settings_of_an_included_mjcf_are_those_of_the_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "robot: r\ninclude: [{file: dog.xml}]\noutputs: {mjcf: {file: r.xml}}\n"
    model = model_of(made(tmp_path, text, dog_xml=DOG))
    assert (model.nv, model.opt.timestep, model.opt.integrator) == (7, 0.001, mujoco.mjtIntegrator.mjINT_RK4)
    assert model.body("trunk").pos[2] == pytest.approx(0.4)
    made(tmp_path, text.replace("r.xml", "r.xml, option: {timestep: 0.004}"))
    said = capsys.readouterr().err
    assert "warning[include-settings]: the MJCF does not have these settings of dog.xml: timestep 0.001" in said


KEYED = DOG.replace(
    "</mujoco>", '<keyframe><key name="sit" qpos="0 0 .3 1 0 0 0 .5" qvel="0 0 0 0 0 0 1"/></keyframe></mujoco>'
)
ARM = """<mujoco model="arm"><compiler angle="radian"/><option timestep="0.003" density="1.2"/><worldbody>
<body name="post"><geom type="box" size=".05 .05 .05"/>
<body name="lower" pos="0 0 .05"><joint name="lower" axis="0 1 0"/><geom type="box" size=".05 .05 .05"/>
<body name="upper" pos="0 0 .3"><joint name="upper" axis="0 1 0"/><geom type="sphere" size=".05"/></body></body></body>
</worldbody><contact><exclude body1="post" body2="upper"/></contact>
<keyframe><key name="up" qpos=".1 .2"/></keyframe></mujoco>"""


def test_keys_and_contacts_of_included_mjcfs_reach_it_and_the_first_settings_win(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    includes = "[{file: dog.xml}, {file: arm.xml, prefix: a_, parent: trunk, xyz: [0, 0, 1]}]"
    text = f"robot: r\ninclude: {includes}\noutputs: {{mjcf: {{file: r.xml}}}}\n"
    model = model_of(made(tmp_path, text, dog_xml=KEYED, arm_xml=ARM))
    said = capsys.readouterr().err
    assert (model.nv, model.opt.timestep, model.opt.density) == (9, 0.001, 1.2)
    assert "the MJCF does not have these settings of arm.xml: integrator Euler, timestep 0.003" in said
    assert 'the MJCF does not have these values of dog.xml: qvel of pose "sit"' in said
    excluded = {tuple(sorted((one >> 16, one & 0xFFFF))) for one in model.exclude_signature.tolist()}
    assert tuple(sorted(model.body(name).id for name in ("a_post", "a_upper"))) in excluded
    at = {model.joint(index).name: int(model.jnt_qposadr[index]) for index in range(model.njnt)}
    assert model.key("sit").qpos[at["hip"]] == pytest.approx(0.5)
    assert model.key("sit").qpos[2] == pytest.approx(0.3)
    assert [model.key("a_up").qpos[at[name]] for name in ("a_lower", "a_upper")] == pytest.approx([0.1, 0.2])


def test_names_that_an_included_mjcf_refers_to_get_its_prefix(tmp_path: Path) -> None:
    texture = '<texture name="t" type="2d" builtin="checker" width="8" height="8"/>'
    body = '<worldbody><body name="b"><geom size="1" material="m"/><site name="s"/></body></worldbody>'
    asset = f'<asset>{texture}<material name="m" texture="t"/></asset>'
    arm = f'<mujoco>{asset}{body}<sensor><gyro name="g" site="s"/></sensor></mujoco>'
    include = "include: [{file: arm.xml, prefix: x_, parent: stand}]"
    text = f"robot: r\n{include}\nlinks: {{stand: {{}}}}\noutputs: {{mjcf: {{file: r.xml}}}}\n"
    model = model_of(made(tmp_path, text, arm_xml=arm))
    assert model.sensor_objid[0] == model.site("x_s").id
    assert model.texture("x_t").id in model.mat("r_x_m").texid


def test_a_spring_of_a_urdf_for_gazebo_reaches_mujoco(tmp_path: Path) -> None:
    out = made(tmp_path, TURNING + OUTPUTS)
    assert main(["import", str(out / "r.urdf"), "-o", str(tmp_path / "again")]) == 0
    assert main(["all", str(tmp_path / "again"), "-o", str(tmp_path / "made")]) == 0
    model = model_of(tmp_path / "made")
    assert (model.jnt_stiffness[0], model.qpos_spring[0]) == (20, 0.1)

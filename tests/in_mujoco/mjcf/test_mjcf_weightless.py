"""Links without mass between joints: MuJoCo loads them, and moves as if both joints were on one body."""

import numpy as np
import pytest

from support.paths import data_text
from support.robots import compiled_text, sound

mujoco = pytest.importorskip("mujoco", minversion="3.12")

ROBOT = data_text("robots/mjcf_weightless.yaml").replace(
    "LIMIT", "limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
)
ONE_BODY = """
<mujoco><worldbody><body pos="0 0 0.3">
  <joint name="slide" type="slide" axis="1 0 0"/>
  <joint name="lift" type="slide" axis="0 0 1"/>
  <joint name="turn" axis="0 1 0"/>
  <inertial pos="0.1 0 0.2" mass="2" diaginertia="0.1 0.2 0.25"/>
  <geom size="0.1" density="0"/>
</body></worldbody></mujoco>
"""


def test_they_have_the_least_mass_that_mujoco_loads(tmp_path):
    _, artifacts, made = sound(compiled_text(tmp_path, ROBOT))
    model = mujoco.MjModel.from_xml_string(artifacts["mjcf"])
    assert [model.body(name).mass[0] for name in ("rail", "cart", "swing", "plate", "body")] == [0, 1e-15, 1e-15, 0, 2]
    assert any("without mass: cart, swing with" in one.message for one in made.diagnostics)
    assert "1e-15" not in artifacts["urdf"]


def test_they_move_as_one_body_with_several_joints(tmp_path):
    """The same accelerations and the same inertia of the joints, in states that are not zero."""
    models = [
        mujoco.MjModel.from_xml_string(text) for text in (sound(compiled_text(tmp_path, ROBOT))[1]["mjcf"], ONE_BODY)
    ]
    chance = np.random.default_rng(1)
    for _ in range(20):
        qpos, qvel, force = chance.uniform(-0.9, 0.9, (3, 3))
        found = []
        for model in models:
            data = mujoco.MjData(model)
            data.qpos, data.qvel, data.qfrc_applied = qpos, qvel, force
            mujoco.mj_forward(model, data)
            mass = np.zeros((3, 3))
            mujoco.mj_fullM(model, data, mass)
            found.append((mass, data.qacc.copy(), data.xpos[-1].copy()))
        for one, other in zip(*found, strict=True):
            assert np.allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("body: {inertial: {mass: 2, xyz: [0.1, 0, 0.2], inertia: {ixx: 0.1, iyy: 0.2, izz: 0.25}}}", "body: {}"),
        ("type: continuous, parent: plate", "type: continuous, parent: rail"),
    ],
)
def test_where_nothing_hangs_on_it_mujoco_would_not_load_it(tmp_path, old, new):
    assert old in ROBOT
    made = compiled_text(tmp_path, ROBOT.replace(old, new))
    assert not made.artifacts
    assert "mjcf-needs-mass" in [d.rule for d in made.diagnostics if d.severity == "error"]

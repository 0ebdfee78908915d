"""The MJCF of the reference robot in MuJoCo, held in the world and free."""

from collections import Counter

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model import Robot  # noqa: E402
from rosorin_compile.source.diagnostics import ERROR, WARNING  # noqa: E402
from support.robots import RECORDED, compiled  # noqa: E402
from support.simulator import BASES, contacts, frame, load, pose, random_states  # noqa: E402

pytestmark = pytest.mark.slow

STATES = 60
MILLIMETRE, MILLIDEGREE = 0.5e-3, 0.5e-3  # half of what tf2_echo prints
PRINTED = 1.1e-12  # relative: what short numbers leave out
FINGERS = {"r_joint", "l_joint", "l_in_joint", "l_out_joint", "r_in_joint", "r_out_joint"}


@pytest.fixture(scope="module", params=BASES)
def made(request) -> tuple[Robot, str]:
    result = compiled(arguments={"base": request.param})
    assert [d for d in result.diagnostics if d.severity in (ERROR, WARNING)] == []
    assert result.robot is not None
    (text,) = [artifact.text for artifact in result.artifacts if artifact.file == "rosorin.xml"]
    assert ("<freejoint" in text) == (request.param == "free")
    return result.robot, text


@pytest.mark.parametrize("check", RECORDED["tf"], ids=lambda check: f"{check['from']}-{check['to']}")
@pytest.mark.parametrize("kind", ["body", "site"])
def test_what_was_recorded_on_the_robot_comes_out_of_the_keyframe(made, check, kind):
    _, text = made
    model, data = load(text)
    if "pose" in check:
        mujoco.mj_resetDataKeyframe(model, data, model.key(check["pose"]).id)
        mujoco.mj_forward(model, data)
    source, target = (np.vstack((frame(data, kind, check[end]), [0, 0, 0, 1])) for end in ("from", "to"))
    found = np.linalg.inv(source) @ target
    np.testing.assert_allclose(found[:3, 3], check["translation"], atol=MILLIMETRE)
    if "rpy_deg" in check:
        (_, _, _), (_, _, _), (g, h, i) = found[:3, :3]
        angles = np.degrees([np.arctan2(h, i), np.arctan2(-g, np.hypot(h, i)), np.arctan2(found[1, 0], found[0, 0])])
        off = (angles - check["rpy_deg"] + 180) % 360 - 180
        assert np.abs(off).max() <= MILLIDEGREE, angles


def test_the_keyframe_is_what_the_driver_reported(made):
    _, text = made
    model, data = load(text)
    mujoco.mj_resetDataKeyframe(model, data, model.key("tuck").id)
    arm = [f"joint{n}" for n in range(1, 6)]
    reported = pytest.approx(RECORDED["tuck"]["positions_rad"], rel=PRINTED, abs=0)
    assert [data.joint(name).qpos[0] for name in arm] == reported
    assert [data.actuator(name).ctrl[0] for name in arm] == reported


def test_nothing_touches_at_the_zero_pose_and_no_pair_touches_always(made):
    robot, text = made
    model, data = load(text)
    assert contacts(model, data) == set()
    seen: Counter[tuple[str, str]] = Counter()
    for state in random_states(robot, STATES):
        pose(robot, model, data, state)
        seen.update(contacts(model, data))
    assert seen, "boxes that never touch would make this test blind"
    assert max(seen.values()) < STATES / 2, seen.most_common(3)

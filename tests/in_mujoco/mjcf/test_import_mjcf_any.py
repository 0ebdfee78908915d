"""Rules of the import of MJCF that hold for every input: numbers, rotations, and chains of joints of every kind."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.model.geometry import rotation_of_rpy  # noqa: E402
from rosorin_compile.mujoco.mjcf import engine, robot  # noqa: E402
from rosorin_compile.mujoco.mjcf.compare_models import Comparison  # noqa: E402
from rosorin_compile.mujoco.mjcf.convert import rotation, rpy_of, tidy  # noqa: E402
from rosorin_compile.mujoco.mjcf.process import Answer  # noqa: E402
from support.mjcf_oracle import frames_differ, imported  # noqa: E402

pytestmark = pytest.mark.slow

finite = st.floats(allow_nan=False, allow_infinity=False, width=64)
component = st.floats(-1, 1)
quaternion = st.tuples(component, component, component, component)
QUICK = settings(max_examples=300, deadline=None)


@QUICK
@given(finite)
def test_a_number_is_hardly_moved(value: float) -> None:
    assert abs(tidy(value) - value) <= max(1e-15, 1e-15 * abs(value))
    assert tidy(tidy(value)) == tidy(value)


@QUICK
@given(quaternion)
def test_a_rotation_is_kept(quat: tuple[float, float, float, float]) -> None:
    assume(math.hypot(*quat) > 1e-3)
    rows = np.array(rotation(quat))
    assert np.abs(rows @ rows.T - np.eye(3)).max() < 1e-14
    assert np.abs(np.array(rotation_of_rpy(rpy_of(rotation(quat)))) - rows).max() < 2e-12


@QUICK
@given(
    st.floats(-3, 3), st.floats(-14, -1), st.sampled_from([-1.0, 1.0]), st.sampled_from([-1.0, 1.0]), st.floats(-3, 3)
)
def test_a_rotation_near_the_pole_is_kept(roll: float, exponent: float, side: float, up: float, yaw: float) -> None:
    turned = Rotation.from_euler("xyz", [roll, up * math.pi / 2 + side * 10**exponent, yaw])
    x, y, z, w = turned.as_quat()
    rows = rotation((w, x, y, z))
    assert np.abs(np.array(rotation_of_rpy(rpy_of(rows))) - rows).max() < 3e-12


metre = st.integers(-20, 20).map(lambda n: n / 16)
three = st.tuples(metre, metre, metre).map(lambda v: " ".join(map(str, v)))
turn = st.tuples(*[st.integers(-3, 3)] * 4).filter(any).map(lambda v: " ".join(map(str, v)))
axis = st.tuples(*[st.integers(-2, 2)] * 3).filter(any).map(lambda v: " ".join(map(str, v)))


@st.composite
def joints(draw: st.DrawFn) -> str:
    """Return the joints of a body: none, a few hinges and slides, or a ball."""
    if draw(st.integers(0, 5)) == 0:
        return f'<joint type="ball" pos="{draw(three)}"/>'
    made = ""
    for _ in range(draw(st.integers(0, 3))):
        kind, low = draw(st.sampled_from(["hinge", "slide"])), draw(st.integers(-90, 0))
        limit = draw(st.sampled_from(["", f'range="{low} {low + 60}"', f'range="{low} 5" ref="{low}"']))
        damping = draw(st.sampled_from(["", 'damping="0.5"']))
        made += f'<joint type="{kind}" axis="{draw(axis)}" pos="{draw(three)}" {limit} {damping}/>'
    return made


@st.composite
def body(draw: st.DrawFn, depth: int = 0) -> str:
    geom = f'<geom type="box" size="0.1 0.2 0.3" pos="{draw(three)}" quat="{draw(turn)}"/>'
    inner = "".join(draw(st.lists(body(depth + 1), max_size=2))) if depth < 3 else ""
    here = f'<body pos="{draw(three)}" quat="{draw(turn)}">{draw(joints())}{geom}{inner}</body>'
    return f'<frame pos="{draw(three)}" euler="10 20 30">{here}</frame>' if draw(st.booleans()) else here


STAND_INS = {("joint", "range"), ("joint", "limited")}


def here(path: Path) -> Answer:
    """Ask MuJoCo in this process: a child process for each of many models would take minutes."""
    return Answer(engine.read(mujoco, path, path.parent))


@pytest.mark.filterwarnings("ignore:Inertia matrix is too close to singular")  # of two joints with the same axis
@settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(body(), min_size=1, max_size=2))
def test_any_tree_of_bodies_moves_as_in_mujoco(tmp_path_factory: pytest.TempPathFactory, bodies: list[str]) -> None:
    path = tmp_path_factory.mktemp("any") / "robot.xml"
    path.write_text(f"<mujoco><worldbody>{''.join(bodies)}</worldbody></mujoco>", "utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(robot, "ask", here)
        case = imported(path)
    assert frames_differ(case, 5) < 1e-9
    ours = mujoco.MjSpec.from_string(case.text).compile()
    found = Comparison(mujoco, case.model, ours, case.imported.names).run()
    assert [one.text for one in found if (one.kind, one.field) not in STAND_INS] == []

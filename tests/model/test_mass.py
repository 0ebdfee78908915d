"""Mass and inertia of shapes, against MuJoCo, which takes them from its geoms, and against an integral by points."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.formats.compilation import compile_robot  # noqa: E402
from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Inertial, Mesh, Pose, Shape, Sphere  # noqa: E402
from rosorin_compile.model.link import inertial_of  # noqa: E402
from support.paths import data_text  # noqa: E402
from support.simulator import written  # noqa: E402

CASES = yaml.safe_load(data_text("cases/mass.yaml"))

SIZES = st.floats(0.01, 2.0)
SOLIDS = st.one_of(
    st.builds(lambda x, y, z: Box((-x, -y, -z), (x, y / 2, z)), SIZES, SIZES, SIZES),
    st.builds(Cylinder, SIZES, SIZES),
    st.builds(Capsule, SIZES, SIZES),
    st.builds(Sphere, SIZES),
)
ANGLES = st.floats(-3.0, 3.0)
POSES = st.builds(lambda x, y, z, r, p, w: Pose((x, y, z), (r, p, w)), *[st.floats(-2.0, 2.0)] * 3, *[ANGLES] * 3)


def geom(shape: Shape, density: float) -> str:
    geometry: Any = shape.geometry
    sizes = {Box: lambda: [extent / 2 for extent in geometry.size], Sphere: lambda: [geometry.radius]}.get(
        type(geometry), lambda: [geometry.radius, geometry.length / 2]
    )()
    place = shape.origin()
    quaternion = " ".join(map(repr, place.transform().quaternion()))
    kind = type(geometry).__name__.lower()
    at, size = " ".join(map(repr, place.xyz)), " ".join(map(repr, sizes))
    return f'<geom type="{kind}" size="{size}" pos="{at}" quat="{quaternion}" density="{density}"/>'


def tensor(inertial: Inertial) -> np.ndarray:
    i = inertial
    own = np.array([[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]])
    turn = np.array(i.pose.transform().rows)
    return turn @ own @ turn.T


@given(st.lists(st.builds(Shape, SOLIDS, POSES), min_size=1, max_size=4), st.floats(100, 8000))
@settings(max_examples=80, deadline=None, derandomize=True)
def test_mass_and_inertia_are_those_that_mujoco_takes_from_the_geoms(shapes: list[Shape], density: float) -> None:
    geoms = "".join(geom(shape, density) for shape in shapes)
    compiler = '<compiler inertiafromgeom="true"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{compiler}<worldbody><body>{geoms}</body></worldbody></mujoco>")
    ours = inertial_of(shapes, density=density)
    axes = np.empty(9)
    mujoco.mju_quat2Mat(axes, model.body_iquat[1])
    theirs = axes.reshape(3, 3) @ np.diag(model.body_inertia[1]) @ axes.reshape(3, 3).T
    scale = np.abs(theirs).max()
    assert ours.mass == pytest.approx(model.body_mass[1], rel=1e-9)
    np.testing.assert_allclose(ours.pose.xyz, model.body_ipos[1], atol=1e-9)
    np.testing.assert_allclose(tensor(ours), theirs, atol=1e-9 * scale)
    by_mass = inertial_of(shapes, mass=ours.mass)
    np.testing.assert_allclose(tensor(by_mass), tensor(ours), rtol=1e-9, atol=1e-12 * scale)


def test_a_height_map_is_its_boxes_and_a_mesh_is_nothing() -> None:
    boxes = HeightMap((0.0, 0.0), 0.1, ((0.2, 0.1), (0.3, 0.3)), 0.1)
    assert Shape(boxes).volume == pytest.approx(0.009)
    assert inertial_of([Shape(boxes)], density=1000).mass == pytest.approx(9)
    with pytest.raises(ValueError, match="a mesh"):
        _ = Shape(Mesh("part.stl")).volume
    with pytest.raises(ValueError, match="no shape"):
        inertial_of([], mass=1)


@pytest.mark.parametrize(("inertial", "rule"), CASES["an_inertial_of_shapes_is_whole_and_said_once"])
def test_an_inertial_of_shapes_is_whole_and_said_once(tmp_path: Path, inertial: str, rule: str) -> None:
    text = f"links:\n  base_link: {{collision: [sphere: {{radius: 0.1}}], inertial: {{{inertial}}}}}"
    made = compile_robot(written(tmp_path, text))
    if rule:
        assert made.diagnostics[0].rule == rule
        assert made.diagnostics[0].span.line == 3
    else:
        assert made.artifacts

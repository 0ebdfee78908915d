"""Bodies that can be are never told, whatever their shape; a mass in grams, a size in millimetres always is."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Box, Capsule, Cylinder, Pose, Shape, Sphere
from rosorin_compile.model.bounds import ball_of, bounds_of
from rosorin_compile.model.link import inertial_of
from rosorin_compile.rules.check import check
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from support.paths import ROOT

LENGTHS = st.floats(0.01, 0.5)
TURNS = st.tuples(*[st.floats(-math.pi, math.pi)] * 3)
PLACES = st.tuples(*[st.floats(-0.5, 0.5)] * 3)
SHAPES = st.one_of(
    st.builds(Sphere, LENGTHS),
    st.builds(Cylinder, LENGTHS, LENGTHS),
    st.builds(Capsule, LENGTHS, LENGTHS),
    st.builds(lambda x, y, z: Box((-x, -y, -z), (x, y / 2, z)), LENGTHS, LENGTHS, LENGTHS),
)
SOLIDS = st.builds(lambda shape, xyz, rpy: Shape(shape, Pose(xyz, rpy)), SHAPES, PLACES, TURNS)


def entry(shape: Shape) -> str:
    geometry = shape.geometry
    if isinstance(geometry, Box):
        words = f"box: {{min: {list(geometry.lower)}, max: {list(geometry.upper)}}}"
    else:
        kind = type(geometry).__name__.lower()
        words = f"{kind}: {{{', '.join(f'{key}: {value!r}' for key, value in vars(geometry).items())}}}"
    return f"{{{words}, xyz: {list(shape.pose.xyz)}, rpy: {list(shape.pose.rpy)}}}"


def told(solid: Shape, mass: float, inertia_by: float = 1.0) -> set[str]:
    """Return the rules that have something to say of a link of one solid, with the inertia of its mass."""
    made = inertial_of([solid], mass=mass)
    moments = {key: getattr(made, key) * inertia_by for key in ("ixx", "iyy", "izz")}
    text = f"""
robot: made
links:
  base_link:
    inertial:
      mass: {mass!r}
      xyz: {list(made.pose.xyz)}
      rpy: {list(made.pose.rpy)}
      inertia: {{{", ".join(f"{key}: {value!r}" for key, value in moments.items())}}}
    collision: [{entry(solid)}]
"""
    tree = parse_yaml(Source("made.yaml", text))
    lowered = lower(tree)
    assert lowered.robot is not None, lowered.diagnostics
    return {one.rule for one in check(lowered.robot, tree, lowered.places, FORMATS)}


@given(SOLIDS, st.floats(20, 19_000))
@settings(max_examples=150, deadline=None)
def test_a_solid_of_any_material_is_not_told(solid, density):
    assert told(solid, inertial_of([solid], density=density).mass) == set()


def is_chunky(solid: Shape) -> bool:
    """Say whether a solid is no plate: a tilted one fills so little of the space that it takes that iron has room."""
    bounds = bounds_of([Shape(solid.geometry)])
    return bounds is not None and min(bounds.size) > 0.3 * max(bounds.size)


@given(SOLIDS.filter(is_chunky), st.floats(300, 8_000))
@settings(max_examples=80, deadline=None)
def test_grams_for_kilograms_are_told(solid, density):
    assert told(solid, inertial_of([solid], density=density * 1000).mass) & {"mass-implausible", "inertia-implausible"}


@given(SOLIDS, st.floats(300, 8_000), st.sampled_from([1e-6, 1e6]))
@settings(max_examples=80, deadline=None)
def test_an_inertia_a_million_times_off_is_told(solid, density, factor):
    mass = inertial_of([solid], density=density).mass
    if mass > 0.01:
        assert told(solid, mass, factor) == {"inertia-implausible"}


@pytest.mark.parametrize(("density", "wrong"), [(40_000, False), (50_000, True)])
def test_an_inertia_is_told_from_twice_the_densest_on(density, wrong):
    """An inertia that somebody estimated is rough: osmium has 22 590 kg/m^3."""
    ball = Shape(Sphere(0.1))
    own = 1.0 / (4 / 3 * math.pi * 0.1**3)
    assert ("inertia-implausible" in told(ball, 1.0, (own / density) ** (2 / 3))) == wrong


@given(st.lists(SOLIDS, min_size=1, max_size=3))
@settings(max_examples=100, deadline=None)
def test_bounds_hold_every_point_of_the_shapes(solids):
    bounds = bounds_of(solids)
    assert bounds is not None
    rng = np.random.default_rng(1)
    for solid in solids:
        ball = ball_of(solid)
        assert ball is not None
        for point in surface(solid, rng):
            place = solid.pose.transform().apply(point)
            assert all(
                low - 1e-9 <= here <= high + 1e-9
                for low, here, high in zip(bounds.lower, place, bounds.upper, strict=True)
            )
            assert math.dist(place, ball.middle) <= ball.radius + 1e-9
            assert math.dist(place, (0, 0, 0)) <= bounds.reach((0, 0, 0)) + 1e-9


def surface(solid: Shape, rng: np.random.Generator) -> list[tuple[float, float, float]]:
    geometry = solid.geometry
    if isinstance(geometry, Box):
        return [tuple(map(float, rng.uniform(geometry.lower, geometry.upper))) for _ in range(20)]
    assert isinstance(geometry, (Sphere, Cylinder, Capsule))
    made = []
    for direction in rng.normal(size=(20, 3)):
        x, y, z = direction / np.linalg.norm(direction) * geometry.radius
        half = 0.0 if isinstance(geometry, Sphere) else geometry.length / 2
        if isinstance(geometry, Cylinder):
            z = 0.0
        made.append((float(x), float(y), float(z + math.copysign(half, z))))
    return made


# A sensor that sees nothing but its robot is told, and MuJoCo reads the same; one that looks out is left alone.


def test_the_lidar_of_the_reference_robot_sees() -> None:
    """With the stand-in of its chassis, by MuJoCo: in all directions but that of the tower behind it."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(ROOT / "outputs/rosorin/rosorin.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    names = [model.sensor(index).name for index in range(model.nsensor)]
    beams = [data.sensor(name).data[0] for name in names if name.startswith("lidar_")]
    assert len(beams) == 36
    assert beams.count(-1) >= 0.75 * len(beams)
    assert all(beam == -1 or beam > 0.08 for beam in beams)

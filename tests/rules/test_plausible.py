"""Bodies that can be are never told, whatever their shape; a mass in grams, a size in millimetres always is."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Box, Capsule, Cylinder, Pose, Shape, Sphere
from rosorin_compile.model.bounds import bounds_of
from rosorin_compile.model.link import inertial_of
from rosorin_compile.rules.check import check
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml

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


# A sensor that sees nothing but its robot is told, and MuJoCo reads the same; one that looks out is left alone.
